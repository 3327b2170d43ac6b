/* Compiled kernels of microslip: the arithmetic of twin.py, one call a record instead of one a sample.
 *
 * Limited API (abi3, Python >= 3.11). Arrays arrive as C-contiguous buffers of float64 or int64,
 * made by the package itself (memory/record.py, table.py, __init__.py); lengths are checked here,
 * the entries of `parent` are not. Nothing here knows physics: see twin.py, whose functions have
 * the same names, arguments and results, for what each one means.
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TERMS 12          /* coefficients a panel; fixed so that the polynomial unrolls */
#define PROFILE_TERMS 14  /* coefficients a panel of a load curve */
#define MOMENT_TERMS 30   /* coefficients a piece of a Gaussian moment */
#define LENGTH(buffer) ((Py_ssize_t)((buffer).len / (Py_ssize_t)sizeof(double)))

/* Raises ValueError and returns 0 where a buffer is shorter than what will be read or written. */
static int long_enough(int right)
{
    if (!right) PyErr_SetString(PyExc_ValueError, "a buffer is too short for this kernel");
    return right;
}

/* A new reference to None. Headers of Python 3.12 and 13 take none in Py_RETURN_NONE, since None is
 * immortal there; built by them, this module would take None's references away from Python 3.11. */
static PyObject *none(void)
{
    Py_IncRef(Py_None);
    return Py_None;
}

#include "_tables.h"
#include "_memory.h"
#include "_curves.h"
#include "_diagrams.h"
#include "_moments.h"
#include "_field.h"
#include "_vector.h"

static PyMethodDef methods[] = {
    {"evaluate", py_evaluate, METH_VARARGS, NULL},
    {"evaluate_one", py_evaluate_one, METH_VARARGS, NULL},
    {"locate", py_locate, METH_VARARGS, NULL},
    {"respond", py_respond, METH_VARARGS, NULL},
    {"branches", py_branches, METH_VARARGS, NULL},
    {"closings", py_closings, METH_VARARGS, NULL},
    {"accumulate", py_accumulate, METH_VARARGS, NULL},
    {"step_front", py_step_front, METH_VARARGS, NULL},
    {"diagram", py_diagram, METH_VARARGS, NULL},
    {"trace", py_trace, METH_VARARGS, NULL},
    {"loads", py_loads, METH_VARARGS, NULL},
    {"drops", py_drops, METH_VARARGS, NULL},
    {"excesses", py_excesses, METH_VARARGS, NULL},
    {"cycle_energies", py_cycle_energies, METH_VARARGS, NULL},
    {"field_cycle", py_field_cycle, METH_VARARGS, NULL},
    {"field_try", py_field_try, METH_VARARGS, NULL},
    {"field_commit", py_field_commit, METH_VARARGS, NULL},
    {"field_losses", py_field_losses, METH_VARARGS, NULL},
    {"vector_try", py_vector_try, METH_VARARGS, NULL},
    {"vector_cycle", py_vector_cycle, METH_VARARGS, NULL},
    {"field_slopes", py_field_slopes, METH_VARARGS, NULL},
    {"separations", py_separations, METH_VARARGS, NULL},
    {"coupled", py_coupled, METH_VARARGS, NULL},
    {"coupled_step", py_coupled_step, METH_VARARGS, NULL},
    {"losses", py_losses, METH_VARARGS, NULL},
    {"hold", py_hold, METH_VARARGS, NULL},
    {"gaussian_moment", py_gaussian_moment, METH_VARARGS, NULL},
    {"gaussian_moment_at", py_gaussian_moment_at, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL},
};

static int execute(PyObject *module)
{
    if (PyModule_AddIntConstant(module, "TERMS", TERMS) < 0) return -1;
    return PyModule_AddIntConstant(module, "PROFILE_TERMS", PROFILE_TERMS);
}

static PyModuleDef_Slot slots[] = {{Py_mod_exec, execute}, {0, NULL}};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_compiled", "Compiled kernels of microslip.", 0, methods, slots,
    NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__compiled(void) { return PyModuleDef_Init(&definition); }
