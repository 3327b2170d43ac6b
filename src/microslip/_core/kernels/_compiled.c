/* The kernels of microslip: inner loops, with one call per record instead of one per sample.
 *
 * Limited API (abi3, Python >= 3.11). Arrays arrive as C-contiguous buffers of float64 or int64, made
 * by the package itself; lengths are checked, the entries of `parent` are not. Each header holds one
 * idea, its kernels at its end; a plain reference of them, loop by loop, is tests/scalar_kernels.py.
 */
#define PY_SSIZE_T_CLEAN
#if !defined(__has_include) || __has_include(<Python.h>)
#include <Python.h>
#else
#include "_python.h"
#endif
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifdef __GNUC__
#define INLINED static inline __attribute__((always_inline))
#else
#define INLINED static inline
#endif

#define TERMS 12         /* coefficients a panel of a table; fixed so that the polynomial unrolls */
#define PROFILE_TERMS 14 /* coefficients a panel of a load curve */
#define MOMENT_TERMS 30  /* coefficients a piece of a Gaussian moment */

#include "_arguments.h"
#include "_tables.h"
#include "_memory.h"
#include "_curves.h"
#include "_front.h"
#include "_diagrams.h"
#include "_losses.h"
#include "_cycles.h"
#include "_states.h"
#include "_harmonics.h"
#include "_coupled_harmonics.h"
#include "_sliders.h"
#include "_stops.h"
#include "_vector.h"
#include "_moments.h"
#include "_questions.h"
#include "_calls.h"

static const Kernel kernels[] = {
    {"evaluate", "aAA?T", "", run_evaluate, 0,
     "evaluate(u, value, slope or None, *table): values, and slopes if an array is there for them."},
    {"evaluate_one", "dT", "dd", run_evaluate_one, 1, "evaluate_one(u, *table) -> value, slope"},
    {"locate", "dandn", "nnn", run_locate, 1,
     "locate(x, stack, depth, last, direction) -> depth, 1 if `last` became the newest reversal, "
     "direction; the stack (capacity, 2) is not changed."},
    {"respond", "aAAnddnT", "nddn", run_respond, 0,
     "respond(x, value, stack, depth, last, last_value, direction, *table) -> depth, last, "
     "last_value, direction: a record by Masing's rules; the stack (capacity, 2) holds places and "
     "values."},
    {"branches", "aAAIAIndn", "ndn", run_branches, 0,
     "branches(x, half, sign, parent, stack, codes, depth, last, direction) -> depth, last, "
     "direction: the branch tree of a record, which depends on displacements alone."},
    {"closings", "aAAndn", "n", run_closings, 0,
     "closings(x, closed, stack, depth, last, direction) -> count: amplitudes of the loops that a "
     "record closes, in time order; the stack is used as scratch."},
    {"accumulate", "iAa", "", run_accumulate, 0,
     "accumulate(parent, rise, base): accumulates increments over parents to values, down the tree."},
    {"stops", "aaaaadAA", "", run_stops, 0,
     "stops(move, bend, shift, shift_bend, y, start, value, mean): stop elements with limits y + "
     "shift along a settled cycle; entry i of the first four is of the step that ends at place i; "
     "an empty mean is left out."},
    {"loads", "aAA?C", "", run_loads, 0, "loads(separation, N, -N' or None, *curve)"},
    {"drops", "aaAC", "", run_drops, 0, "drops(base, width, N(b) - N(b + w), *curve)"},
    {"excesses", "aaAP", "", run_excesses, 0,
     "excesses(base, width, N(b) - N(b + w) + w N'(b + w), *profile)"},
    {"cycle_energies", "aaAaaaP", "", run_cycle_energies, 0,
     "cycle_energies(base, width, energy, bends, tails, rule, *profile)"},
    {"separations", "aAPadd", "", run_separations, 0,
     "separations(load, separation, *profile, inverse, inverse_width, start)"},
    {"coupled", "aaASSnddC", "ndd", run_coupled, 0,
     "coupled(separation, place, value, stack, values, depth, last_separation, last_place, *curve) "
     "-> depth, last_separation, last_place: values T/mu along a record."},
    {"coupled_step", "ddaanddC", "nddnddd", run_coupled_step, 1,
     "coupled_step(separation, place, stack, values, depth, last_separation, last_place, *curve) -> "
     "depth, front, D, kind, value, part of the remaining rows, -dN/d(eta) at the front"},
    {"hold", "aaASSndddH", "nddd", run_hold, 0,
     "hold(separation, value, place, stack, values, depth, last_separation, last_place, last_value, "
     "*curve) -> depth, last_separation, last_place, last_value: places at which the values are reached."},
    {"losses", "aaAAnddaP", "", run_losses, 0,
     "losses(separation, place, loss, stack, depth, last_separation, last_place, rules, *profile): "
     "energy dissipated in each step over mu kappa; the stack is used as scratch."},
    {"slips", "aaAAndd", "n", run_slips, 0,
     "slips(separation, place, runs, stack, depth, last_separation, last_place) -> number of runs "
     "of the front, written as far as there is room; the stack is used as scratch."},
    {"field_cycle", "aa?anAAAC", "", run_field_cycle, 0,
     "field_cycle(place, step or None, rest, samples, value, load, slope, *curve)"},
    {"field_slopes", "aa?ananannanAAAAC", "", run_field_slopes, 0,
     "field_slopes(place, step or None, rest, samples, by_place, places, by_step, steps, stride, "
     "weights, rows, spectrum, jacobian, load_spectrum, load_jacobian, *curve): directions are "
     "(samples, places) and (samples, steps), with a stride of 1 for each node its own."},
    {"field_harmonics", "anndAAaaP", "n", run_field_harmonics, 0,
     "field_harmonics(place, rows, size, tolerance, value, jacobian, orders, rest, *profile) -> "
     "whether the tolerance was missed: of rows of mean, cos, sin, ... of the orders, of all if empty"},
    {"varying_harmonics", "aanndAAAAAaP", "n", run_varying_harmonics, 0,
     "varying_harmonics(place, step, rows, size, tolerance, value, jacobian, load, load_jacobian, "
     "errors, rest, *profile) -> whether the tolerance was missed; values are NaN for nodes at rest; "
     "errors are those of the coefficients and the force of each node to which the tolerance refers."},
    {"table_harmonics", "anndAAaT", "n", run_table_harmonics, 0,
     "table_harmonics(displacement, rows, size, tolerance, force, jacobian, orders, *table) -> whether it "
     "was missed"},
    {"field_steps", "ada?a?aaA", "nddd", run_field_steps, 0,
     "field_steps(separation, origin, origins or None, length or None, rest, last_step, step) -> whether "
     "a separation is not finite, the smallest, least and largest step from the origin"},
    {"field_try", "aa?aaaaa?aaaiiAIAAAA?C", "n", run_field_try, 0,
     "field_try(displacement, step or None, rest, slip, weight, scale, length or None, now, rows, marks, "
     "begin, depth, trial, code, force, load, tangent, stiffness or None, *curve) -> whether a "
     "displacement is not finite; the rows of now and trial are named in _states.h"},
    {"field_bound", "aaaIiinAAAP", "", run_field_bound, 0,
     "field_bound(step, rest, front, code, begin, depth, limit, doubt, rows, marks, *profile)"},
    {"bound_rows", "AAndnAP", "n", run_bound_rows, 0,
     "bound_rows(stack, values, depth, separation, limit, doubt, *profile) -> depth"},
    {"field_commit", "aiIIAAAIn", "n", run_field_commit, 0,
     "field_commit(trial, code, begin, room, now, rows, marks, depth, used) -> rows of the pool in use, "
     "-1 if it is too short"},
    {"field_move", "iiiaaAA", "", run_field_move, 0,
     "field_move(count, from, to, old rows, old marks, rows, marks): the rows of each node, moved"},
    {"field_losses", "aaaiaaiiaAAP", "", run_field_losses, 0,
     "field_losses(place, step, rest, code, last_place, last_step, begin, depth, rules, rows, loss, "
     "*profile)"},
    {"vector_try", "aa?aaaaaa?AAA", "", run_vector_try, 0,
     "vector_try(place, step or None, last_place, last_step, vectors, tops, weights, lay or None, "
     "new, value, tangent)"},
    {"settle_vectors", "aaanaaa?anannndAAIA", "", run_vector_cycle, 0,
     "settle_vectors(place, step, rest, samples, tops, weights, lay or None, by_place, places, "
     "by_step, steps, limit, first, small, value, slopes, passes, left)"},
    {"vector_losses", "aaaaa?A", "", run_vector_losses, 0,
     "vector_losses(vectors, step, first_radii, last_radii, lay or None, loss)"},
    {"gaussian_moment", "aAan", "", run_gaussian_moment, 0,
     "gaussian_moment(h, value, coefficients, twice the order)"},
    {"gaussian_moment_at", "dan", "d", run_gaussian_moment_at, 1,
     "gaussian_moment_at(h, coefficients, twice the order) -> value"},
};

#define COUNT ((int)(sizeof(kernels) / sizeof(kernels[0])))

static PyMethodDef methods[COUNT];

static int execute(PyObject *module)
{
    if (add_kernels(module, kernels, methods, COUNT) < 0) return -1;
    if (PyModule_AddIntConstant(module, "TERMS", TERMS) < 0) return -1;
    return PyModule_AddIntConstant(module, "PROFILE_TERMS", PROFILE_TERMS);
}

static PyModuleDef_Slot slots[] = {{Py_mod_exec, execute}, {0, NULL}};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_compiled", "The kernels of microslip.", 0, NULL, slots,
    NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__compiled(void) { return PyModuleDef_Init(&definition); }
