/* Compiled kernels of microslip: the arithmetic of twin.py, one call a record instead of one a sample.
 *
 * Limited API (abi3, Python >= 3.11). Arrays arrive as C-contiguous buffers of float64 or int64,
 * made by the package itself (memory/record.py, table.py, __init__.py); lengths are checked here,
 * the entries of `parent` are not. Nothing here knows physics: see twin.py, whose functions have
 * the same names, arguments and results, for what each one means.
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <math.h>

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

/* ---- piecewise polynomials -------------------------------------------------------------- */

typedef struct {
    const double *coefficients;
    Py_ssize_t panels;
    double inverse_width, limit, rate;
    int power;
} Table;

static inline double shape(const double *c, double s)
{
    double q = s * s;
    double even = ((((c[10] * q + c[8]) * q + c[6]) * q + c[4]) * q + c[2]) * q + c[0];
    double odd = ((((c[11] * q + c[9]) * q + c[7]) * q + c[5]) * q + c[3]) * q + c[1];
    return odd * s + even;
}

static inline double shape_slope(const double *c, double s)
{
    double q = s * s;
    double even = ((((11 * c[11]) * q + 9 * c[9]) * q + 7 * c[7]) * q + 5 * c[5]) * q + 3 * c[3];
    double odd = ((((10 * c[10]) * q + 8 * c[8]) * q + 6 * c[6]) * q + 4 * c[4]) * q + 2 * c[2];
    return (even * q + c[1]) + odd * s;
}

/* u >= 0. Returns u^power * S(u), past the last panel limit + rate * (u - end). */
static inline double evaluate_at(const Table *t, double u, double *slope)
{
    double z = u * t->inverse_width;
    if (!(z < (double)t->panels)) {
        if (slope) *slope = t->rate;
        return t->rate == 0.0 ? t->limit
                              : t->limit + t->rate * (u - (double)t->panels / t->inverse_width);
    }
    Py_ssize_t panel = (Py_ssize_t)z;
    double s = 2.0 * (z - (double)panel) - 1.0;
    const double *c = t->coefficients + panel * TERMS;
    double value = shape(c, s);
    if (t->power == 0) {
        if (slope) *slope = 2.0 * t->inverse_width * shape_slope(c, s);
        return value;
    }
    if (t->power == 1) {
        if (slope) *slope = value + u * (2.0 * t->inverse_width * shape_slope(c, s));
        return u * value;
    }
    if (t->power == 2) {
        if (slope) *slope = u * (2.0 * value + u * (2.0 * t->inverse_width * shape_slope(c, s)));
        return u * (u * value);
    }
    if (slope) *slope = u * u * (3.0 * value + u * (2.0 * t->inverse_width * shape_slope(c, s)));
    return u * (u * (u * value));
}

/* The trailing arguments that describe a table; keep in step with Table.arguments of table.py. */
#define TABLE_FORMAT "y*didd"
#define TABLE_ARGUMENTS(buffer, t) \
    &(buffer), &(t).inverse_width, &(t).power, &(t).limit, &(t).rate

static void bind_table(Table *t, const Py_buffer *buffer)
{
    t->coefficients = buffer->buf;
    t->panels = LENGTH(*buffer) / TERMS;
}

static PyObject *py_evaluate(PyObject *self, PyObject *args)
{
    Py_buffer u, value, slope = {0}, coefficients;
    PyObject *slope_object;
    Table t;
    if (!PyArg_ParseTuple(args, "y*w*O" TABLE_FORMAT, &u, &value, &slope_object,
                          TABLE_ARGUMENTS(coefficients, t)))
        return NULL;
    if (slope_object != Py_None && PyObject_GetBuffer(slope_object, &slope, PyBUF_WRITABLE) < 0) {
        PyBuffer_Release(&u);
        PyBuffer_Release(&value);
        PyBuffer_Release(&coefficients);
        return NULL;
    }
    bind_table(&t, &coefficients);
    const double *in = u.buf;
    double *out = value.buf, *ds = slope.obj ? slope.buf : NULL;
    Py_ssize_t n = LENGTH(u);
    int right = long_enough(LENGTH(value) >= n && (!ds || LENGTH(slope) >= n) && t.panels > 0);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    if (ds)
        for (Py_ssize_t i = 0; i < n; i++) out[i] = evaluate_at(&t, in[i], &ds[i]);
    else
        for (Py_ssize_t i = 0; i < n; i++) out[i] = evaluate_at(&t, in[i], NULL);
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&u);
    PyBuffer_Release(&value);
    PyBuffer_Release(&coefficients);
    if (slope.obj) PyBuffer_Release(&slope);
    if (!right) return NULL;
    Py_RETURN_NONE;
}

static PyObject *py_evaluate_one(PyObject *self, PyObject *args)
{
    Py_buffer coefficients;
    Table t;
    double u, slope, value;
    if (!PyArg_ParseTuple(args, "d" TABLE_FORMAT, &u, TABLE_ARGUMENTS(coefficients, t)))
        return NULL;
    bind_table(&t, &coefficients);
    value = evaluate_at(&t, u, &slope);
    PyBuffer_Release(&coefficients);
    return Py_BuildValue("dd", value, slope);
}

/* ---- the memory of a record ------------------------------------------------------------- */

/* The branch that a move from `last` to x ends on. Returns the new depth; *pushed says whether
 * `last` became the newest reversal. Entries of the stack are `stride` doubles apart. */
static inline Py_ssize_t locate(const double *stack, Py_ssize_t stride, Py_ssize_t depth,
                                double last, int *direction, double x, int *pushed)
{
    *pushed = 0;
    if (x == last) return depth;
    int way = x > last ? 1 : -1;
    int turned = *direction != 0 && way != *direction;
    *direction = way;
    if (turned) {
        /* With `last` on top: does the move reach the reversal below it? It closes that loop. */
        if (depth >= 1) {
            double close = stack[(depth - 1) * stride];
            if (!(way > 0 ? x >= close : x <= close)) {
                *pushed = 1;
                return depth + 1;
            }
            depth -= 1;
        } else {
            if (!(fabs(x) >= fabs(last))) {
                *pushed = 1;
                return 1;
            }
            return 0;
        }
    }
    while (depth > 1) {
        double close = stack[(depth - 2) * stride];
        if (!(way > 0 ? x >= close : x <= close)) return depth;
        depth -= 2;
    }
    if (depth == 1 && fabs(x) >= fabs(stack[0])) return 0;
    return depth;
}

static PyObject *py_locate(PyObject *self, PyObject *args)
{
    Py_buffer stack;
    Py_ssize_t depth;
    double last, x;
    int direction, pushed;
    if (!PyArg_ParseTuple(args, "dy*ndi", &x, &stack, &depth, &last, &direction)) return NULL;
    int right = long_enough(depth >= 0 && LENGTH(stack) >= 2 * depth);
    if (right) depth = locate(stack.buf, 2, depth, last, &direction, x, &pushed);
    PyBuffer_Release(&stack);
    if (!right) return NULL;
    return Py_BuildValue("nii", depth, pushed, direction);
}

static PyObject *py_respond(PyObject *self, PyObject *args)
{
    Py_buffer x_buffer, force, stack_buffer, coefficients;
    Py_ssize_t depth;
    double last, last_force;
    int direction;
    Table t;
    if (!PyArg_ParseTuple(args, "y*w*w*nddi" TABLE_FORMAT, &x_buffer, &force, &stack_buffer, &depth,
                          &last, &last_force, &direction, TABLE_ARGUMENTS(coefficients, t)))
        return NULL;
    bind_table(&t, &coefficients);
    const double *xs = x_buffer.buf;
    double *out = force.buf, *stack = stack_buffer.buf;
    Py_ssize_t n = LENGTH(x_buffer);
    int right = long_enough(LENGTH(force) >= n && depth >= 0 && t.panels > 0 &&
                            LENGTH(stack_buffer) >= 2 * (depth + n));
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        double x = xs[i];
        int pushed;
        depth = locate(stack, 2, depth, last, &direction, x, &pushed);
        if (pushed) {
            stack[2 * depth - 2] = last;
            stack[2 * depth - 1] = last_force;
        }
        if (depth) {
            const double *top = stack + 2 * depth - 2;
            double rise = 2.0 * evaluate_at(&t, 0.5 * fabs(x - top[0]), NULL);
            last_force = direction > 0 ? top[1] + rise : top[1] - rise;
        } else {
            last_force = copysign(evaluate_at(&t, fabs(x), NULL), x);
        }
        out[i] = last_force;
        last = x;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&x_buffer);
    PyBuffer_Release(&force);
    PyBuffer_Release(&stack_buffer);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return Py_BuildValue("nddi", depth, last, last_force, direction);
}

static PyObject *py_branches(PyObject *self, PyObject *args)
{
    Py_buffer x_buffer, half, sign, parent, stack_buffer, code_buffer;
    Py_ssize_t depth;
    double last;
    int direction;
    if (!PyArg_ParseTuple(args, "y*w*w*w*w*w*ndi", &x_buffer, &half, &sign, &parent, &stack_buffer,
                          &code_buffer, &depth, &last, &direction))
        return NULL;
    const double *xs = x_buffer.buf;
    double *halves = half.buf, *signs = sign.buf, *stack = stack_buffer.buf;
    long long *parents = parent.buf, *codes = code_buffer.buf;
    long long last_code = -2 - (long long)depth;
    Py_ssize_t n = LENGTH(x_buffer);
    int right = long_enough(LENGTH(half) >= n && LENGTH(sign) >= n && LENGTH(parent) >= n &&
                            depth >= 0 && LENGTH(stack_buffer) >= depth + n &&
                            LENGTH(code_buffer) >= depth + n);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        double x = xs[i];
        int pushed;
        depth = locate(stack, 1, depth, last, &direction, x, &pushed);
        if (pushed) {
            stack[depth - 1] = last;
            codes[depth - 1] = last_code;
        }
        if (depth) {
            halves[i] = 0.5 * fabs(x - stack[depth - 1]);
            signs[i] = direction > 0 ? 2.0 : -2.0;
            parents[i] = codes[depth - 1];
        } else {
            halves[i] = fabs(x);
            signs[i] = x < 0.0 ? -1.0 : 1.0;
            parents[i] = -1;
        }
        last = x;
        last_code = i;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&x_buffer);
    PyBuffer_Release(&half);
    PyBuffer_Release(&sign);
    PyBuffer_Release(&parent);
    PyBuffer_Release(&stack_buffer);
    PyBuffer_Release(&code_buffer);
    if (!right) return NULL;
    return Py_BuildValue("ndi", depth, last, direction);
}

static PyObject *py_accumulate(PyObject *self, PyObject *args)
{
    Py_buffer parent, rise, base;
    if (!PyArg_ParseTuple(args, "y*w*y*", &parent, &rise, &base)) return NULL;
    const long long *parents = parent.buf;
    const double *bases = base.buf;
    double *values = rise.buf;
    Py_ssize_t n = LENGTH(rise);
    int right = long_enough(LENGTH(parent) >= n);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        long long p = parents[i];
        if (p >= 0) values[i] += values[p];
        else if (p < -1) values[i] += bases[-2 - p];
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&parent);
    PyBuffer_Release(&rise);
    PyBuffer_Release(&base);
    if (!right) return NULL;
    Py_RETURN_NONE;
}

/* ---- load curves -------------------------------------------------------------------------- */

typedef struct {
    const double *coefficients;
    Py_ssize_t panels, first;
    double anchor, inverse_width;
} Profile;

/* The trailing arguments that describe a profile; keep in step with Profile.arguments. */
#define PROFILE_FORMAT "y*ddn"
#define PROFILE_ARGUMENTS(buffer, p) &(buffer), &(p).anchor, &(p).inverse_width, &(p).first

static int bind_profile(Profile *p, const Py_buffer *buffer)
{
    p->coefficients = buffer->buf;
    p->panels = LENGTH(*buffer) / PROFILE_TERMS;
    return p->panels > 0;
}

static inline double curve_value(const double *c, double s)
{
    double q = s * s, even = c[12], odd = c[13];
    for (int k = 10; k >= 0; k -= 2) even = even * q + c[k];
    for (int k = 11; k >= 1; k -= 2) odd = odd * q + c[k];
    return odd * s + even;
}

static inline double curve_slope(const double *c, double s)
{
    double q = s * s, even = 13 * c[13], odd = 12 * c[12];
    for (int k = 11; k >= 1; k -= 2) even = even * q + k * c[k];
    for (int k = 10; k >= 2; k -= 2) odd = odd * q + k * c[k];
    return odd * s + even;
}

static inline double first_difference(const double *c, double s0, double s1)
{
    double q0 = s0 * s0, q1 = s1 * s1, even = c[12], odd = c[13], even_rise = 0.0, odd_rise = 0.0;
    for (int k = 10; k >= 0; k -= 2) {
        even_rise = even_rise * q1 + even;
        odd_rise = odd_rise * q1 + odd;
        even = even * q0 + c[k];
        odd = odd * q0 + c[k + 1];
    }
    return (s0 + s1) * (even_rise + s1 * odd_rise) + odd;
}

static inline double second_difference(const double *c, double s0, double s1)
{
    double value = c[13], rise = 0.0, bend = 0.0;
    for (int k = 12; k >= 0; k--) {
        bend = bend * s1 + rise;
        rise = rise * s0 + value;
        value = value * s0 + c[k];
    }
    return bend;
}

static inline double slope_difference(const double *c, double s0, double s1)
{
    double slope = 13 * c[13], rise = 0.0;
    for (int k = 12; k >= 1; k--) {
        rise = rise * s1 + slope;
        slope = slope * s0 + k * c[k];
    }
    return rise;
}

/* Panel of a place z in widths from the anchor, `panels` past the last; the place in it. */
static inline Py_ssize_t find_panel(const Profile *p, double z, double *s)
{
    if (!(z < (double)(p->panels - p->first))) {
        *s = 0.0;
        return p->panels;
    }
    if (!(z >= (double)-p->first)) z = (double)-p->first; /* the caller sees to it that none is */
    Py_ssize_t whole = (Py_ssize_t)z;
    if (z < (double)whole) whole--;
    *s = 2.0 * (z - (double)whole) - 1.0;
    return whole + p->first;
}

static inline const double *panel_at(const Profile *p, Py_ssize_t panel)
{
    return p->coefficients + panel * PROFILE_TERMS;
}

static inline double load_at(const Profile *p, double x, double *fall)
{
    double s;
    Py_ssize_t panel = find_panel(p, (x - p->anchor) * p->inverse_width, &s);
    if (panel >= p->panels) {
        if (fall) *fall = 0.0;
        return 0.0;
    }
    const double *c = panel_at(p, panel);
    if (fall) *fall = -2.0 * p->inverse_width * curve_slope(c, s);
    return curve_value(c, s);
}

static double drop_at(const Profile *p, double base, double width)
{
    double s0, s1, z = (base - p->anchor) * p->inverse_width;
    Py_ssize_t low = find_panel(p, z, &s0);
    if (low >= p->panels) return 0.0;
    Py_ssize_t high = find_panel(p, z + width * p->inverse_width, &s1);
    const double *c = panel_at(p, low);
    double step = 2.0 * width * p->inverse_width;
    if (high == low) return -step * first_difference(c, s0, s1);
    if (high >= p->panels) return curve_value(c, s0);
    const double *d = panel_at(p, high);
    if (high == low + 1) {
        double left = 1.0 - s0, right = step - left;
        return -(left * first_difference(c, s0, 1.0) +
                 right * first_difference(d, -1.0, right - 1.0));
    }
    return curve_value(c, s0) - curve_value(d, s1);
}

static double excess_at(const Profile *p, double base, double width)
{
    double s0, s1, z = (base - p->anchor) * p->inverse_width;
    Py_ssize_t low = find_panel(p, z, &s0);
    if (low >= p->panels) return 0.0;
    Py_ssize_t high = find_panel(p, z + width * p->inverse_width, &s1);
    const double *c = panel_at(p, low);
    double step = 2.0 * width * p->inverse_width;
    if (high == low) return step * step * second_difference(c, s1, s0);
    if (high >= p->panels) return curve_value(c, s0);
    const double *d = panel_at(p, high);
    if (high == low + 1) {
        double left = 1.0 - s0, right = step - left, end = right - 1.0;
        return left * left * second_difference(c, 1.0, s0) +
               right * right * second_difference(d, end, -1.0) +
               left * right * slope_difference(d, -1.0, end);
    }
    return curve_value(c, s0) + (step * curve_slope(d, s1) - curve_value(d, s1));
}

static PyObject *py_loads(PyObject *self, PyObject *args)
{
    Py_buffer x, value, fall = {0}, coefficients;
    PyObject *fall_object;
    Profile p;
    if (!PyArg_ParseTuple(args, "y*w*O" PROFILE_FORMAT, &x, &value, &fall_object,
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    if (fall_object != Py_None && PyObject_GetBuffer(fall_object, &fall, PyBUF_WRITABLE) < 0) {
        PyBuffer_Release(&x);
        PyBuffer_Release(&value);
        PyBuffer_Release(&coefficients);
        return NULL;
    }
    const double *in = x.buf;
    double *out = value.buf, *slopes = fall.obj ? fall.buf : NULL;
    Py_ssize_t n = LENGTH(x);
    int right = long_enough(bind_profile(&p, &coefficients) && LENGTH(value) >= n &&
                            (!slopes || LENGTH(fall) >= n));
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) out[i] = load_at(&p, in[i], slopes ? &slopes[i] : NULL);
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&x);
    PyBuffer_Release(&value);
    PyBuffer_Release(&coefficients);
    if (fall.obj) PyBuffer_Release(&fall);
    if (!right) return NULL;
    Py_RETURN_NONE;
}

static PyObject *py_drops(PyObject *self, PyObject *args)
{
    Py_buffer base, width, drop, coefficients;
    Profile p;
    if (!PyArg_ParseTuple(args, "y*y*w*" PROFILE_FORMAT, &base, &width, &drop,
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    const double *bases = base.buf, *widths = width.buf;
    double *out = drop.buf;
    Py_ssize_t n = LENGTH(base);
    int right = long_enough(bind_profile(&p, &coefficients) && LENGTH(width) >= n &&
                            LENGTH(drop) >= n);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) out[i] = drop_at(&p, bases[i], widths[i]);
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&base);
    PyBuffer_Release(&width);
    PyBuffer_Release(&drop);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    Py_RETURN_NONE;
}

static PyObject *py_separations(PyObject *self, PyObject *args)
{
    Py_buffer load, separation, coefficients, inverse;
    double start;
    Profile p;
    Table t = {0};
    if (!PyArg_ParseTuple(args, "y*w*" PROFILE_FORMAT "y*dd", &load, &separation,
                          PROFILE_ARGUMENTS(coefficients, p), &inverse, &t.inverse_width, &start))
        return NULL;
    bind_table(&t, &inverse);
    const double *in = load.buf;
    double *out = separation.buf;
    Py_ssize_t n = LENGTH(load);
    int right = long_enough(bind_profile(&p, &coefficients) && t.panels > 0 &&
                            LENGTH(separation) >= n);
    if (!right) n = 0;
    double most = nextafter((double)t.panels / t.inverse_width, 0.0);
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        double x = log(in[i]) - start, fall;
        x = x > 0.0 ? (x < most ? x : most) : 0.0;
        double d = evaluate_at(&t, x, NULL), there = load_at(&p, d, &fall);
        out[i] = fall > 0.0 ? d + (there - in[i]) / fall : d;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&load);
    PyBuffer_Release(&separation);
    PyBuffer_Release(&coefficients);
    PyBuffer_Release(&inverse);
    if (!right) return NULL;
    Py_RETURN_NONE;
}

/* ---- memory diagrams -------------------------------------------------------------------- */

typedef struct {
    double end, density, beyond;
} Row;

static inline Py_ssize_t step_front(double separation, double place, const Row *stack,
                                    Py_ssize_t depth, double last_separation, double last_place,
                                    double *q, double *density, int *kind)
{
    double fall = last_separation - separation, move = place - last_place, sign;
    if (fabs(move) <= fall) {
        *q = last_separation;
        *density = fall > 0.0 ? move / fall : 0.0;
        *kind = 0;
        return depth;
    }
    if (fall >= 0.0) {
        sign = move > 0.0 ? 1.0 : -1.0;
        *q = last_separation;
    } else {
        while (depth && stack[depth - 1].end <= separation) depth--;
        double held = 0.0;
        if (depth) {
            const Row *row = &stack[depth - 1];
            held = row->density * (row->end - separation) + row->beyond;
        }
        *q = separation;
        if (place == held) {
            *density = 0.0;
            *kind = 2;
            return depth;
        }
        sign = place > held ? 1.0 : -1.0;
    }
    *density = sign;
    *kind = 1;
    for (; depth; depth--) {
        const Row *row = &stack[depth - 1];
        if (row->density != sign) {
            double front = (place + sign * separation - row->density * row->end - row->beyond) /
                           (sign - row->density);
            if (front < row->end - 4e-16 * (fabs(row->end) + fabs(separation))) {
                if (front > *q) *q = front;
                return depth;
            }
        }
        if (row->end > *q) *q = row->end;
    }
    double front = separation + sign * place;
    if (front > *q) *q = front;
    return 0;
}

static PyObject *py_step_front(PyObject *self, PyObject *args)
{
    Py_buffer stack;
    Py_ssize_t depth;
    double separation, place, last_separation, last_place, q = 0.0, density = 0.0;
    int kind = 0;
    if (!PyArg_ParseTuple(args, "ddy*ndd", &separation, &place, &stack, &depth, &last_separation,
                          &last_place))
        return NULL;
    int right = long_enough(depth >= 0 && LENGTH(stack) >= 3 * depth);
    if (right)
        depth = step_front(separation, place, stack.buf, depth, last_separation, last_place, &q,
                           &density, &kind);
    PyBuffer_Release(&stack);
    if (!right) return NULL;
    return Py_BuildValue("nddi", depth, q, density, kind);
}

static PyObject *py_diagram(PyObject *self, PyObject *args)
{
    Py_buffer separation, place, base, width, density, parent, top, stack_buffer, code_buffer;
    Py_ssize_t depth, count = 0;
    double last_separation, last_place;
    if (!PyArg_ParseTuple(args, "y*y*w*w*w*w*w*w*w*ndd", &separation, &place, &base, &width,
                          &density, &parent, &top, &stack_buffer, &code_buffer, &depth,
                          &last_separation, &last_place))
        return NULL;
    const double *ds = separation.buf, *xs = place.buf;
    double *bases = base.buf, *widths = width.buf, *densities = density.buf;
    long long *parents = parent.buf, *tops = top.buf, *codes = code_buffer.buf;
    Row *stack = stack_buffer.buf;
    Py_ssize_t n = LENGTH(separation);
    int right = long_enough(LENGTH(place) >= n && LENGTH(base) >= 2 * n && LENGTH(width) >= 2 * n &&
                            LENGTH(density) >= 2 * n && LENGTH(parent) >= 2 * n &&
                            LENGTH(top) >= n && depth >= 0 &&
                            LENGTH(stack_buffer) >= 3 * (depth + n) &&
                            LENGTH(code_buffer) >= depth + n);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        double d = ds[i], x = xs[i], q, D, outer = 0.0;
        int kind;
        depth = step_front(d, x, stack, depth, last_separation, last_place, &q, &D, &kind);
        if (depth) {
            const Row *row = &stack[depth - 1];
            outer = row->density * (row->end - q) + row->beyond;
            if (kind) {
                bases[count] = q;
                widths[count] = row->end - q;
                densities[count] = row->density;
                parents[count] = depth > 1 ? codes[depth - 2] : -1;
                codes[depth - 1] = count++;
            }
        }
        if (q > d) {
            bases[count] = d;
            widths[count] = q - d;
            densities[count] = D;
            parents[count] = depth ? codes[depth - 1] : -1;
            stack[depth].end = q;
            stack[depth].density = D;
            stack[depth].beyond = kind == 0 ? last_place : outer;
            codes[depth++] = count++;
        }
        tops[i] = depth ? codes[depth - 1] : -1;
        last_separation = d;
        last_place = x;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&separation);
    PyBuffer_Release(&place);
    PyBuffer_Release(&base);
    PyBuffer_Release(&width);
    PyBuffer_Release(&density);
    PyBuffer_Release(&parent);
    PyBuffer_Release(&top);
    PyBuffer_Release(&stack_buffer);
    PyBuffer_Release(&code_buffer);
    if (!right) return NULL;
    return Py_BuildValue("nndd", depth, count, last_separation, last_place);
}

/* ---- memory diagrams with a load curve ---------------------------------------------------- */

typedef struct {
    Row *stack;
    double *values;
    Py_ssize_t depth;
    double separation, place, value;
} Diagram;

/* A step up to its value: rows that stay, front, D, kind, value, share of the rows that stay. */
typedef struct {
    Py_ssize_t depth;
    double front, density, value, outer, drop;
    int kind;
} Step;

static inline void probe(const Profile *p, const Diagram *g, double separation, double place,
                         Step *step)
{
    step->depth = step_front(separation, place, g->stack, g->depth, g->separation, g->place,
                             &step->front, &step->density, &step->kind);
    Py_ssize_t depth = step->depth;
    double outer = depth ? g->values[depth - 1] : 0.0;
    if (depth && step->kind) {
        const Row *row = &g->stack[depth - 1];
        outer = depth > 1 ? g->values[depth - 2] : 0.0;
        outer = row->density * drop_at(p, step->front, row->end - step->front) + outer;
    }
    step->value = step->outer = outer;
    step->drop = 0.0;
    if (step->front > separation) {
        step->drop = drop_at(p, separation, step->front - separation);
        step->value = step->density * step->drop + outer;
    }
}

/* The stack must have room for one row more. */
static inline void push(Diagram *g, double separation, double place, const Step *step)
{
    double beyond = 0.0;
    g->depth = step->depth;
    if (g->depth) {
        const Row *row = &g->stack[g->depth - 1];
        beyond = row->density * (row->end - step->front) + row->beyond;
        g->values[g->depth - 1] = step->outer;
    }
    if (step->front > separation) {
        Row *row = &g->stack[g->depth];
        row->end = step->front;
        row->density = step->density;
        row->beyond = step->kind == 0 ? g->place : beyond;
        g->values[g->depth++] = step->value;
    }
    g->separation = separation;
    g->place = place;
    g->value = step->value;
}

static PyObject *py_coupled(PyObject *self, PyObject *args)
{
    Py_buffer separation, place, value, stack, values, coefficients;
    Profile p;
    Diagram g = {0};
    if (!PyArg_ParseTuple(args, "y*y*w*w*w*ndd" PROFILE_FORMAT, &separation, &place, &value,
                          &stack, &values, &g.depth, &g.separation, &g.place,
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    const double *ds = separation.buf, *xs = place.buf;
    double *out = value.buf;
    Py_ssize_t n = LENGTH(separation);
    int right = long_enough(bind_profile(&p, &coefficients) && LENGTH(place) >= n &&
                            LENGTH(value) >= n && g.depth >= 0 &&
                            LENGTH(stack) >= 3 * (g.depth + n) && LENGTH(values) >= g.depth + n);
    if (!right) n = 0;
    g.stack = stack.buf;
    g.values = values.buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        Step step;
        probe(&p, &g, ds[i], xs[i], &step);
        push(&g, ds[i], xs[i], &step);
        out[i] = g.value;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&separation);
    PyBuffer_Release(&place);
    PyBuffer_Release(&value);
    PyBuffer_Release(&stack);
    PyBuffer_Release(&values);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return Py_BuildValue("ndd", g.depth, g.separation, g.place);
}

static PyObject *py_coupled_step(PyObject *self, PyObject *args)
{
    Py_buffer stack, values, coefficients;
    Profile p;
    Diagram g = {0};
    Step step = {0};
    double separation, place, fall = 0.0;
    if (!PyArg_ParseTuple(args, "ddy*y*ndd" PROFILE_FORMAT, &separation, &place, &stack, &values,
                          &g.depth, &g.separation, &g.place, PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    int right = long_enough(bind_profile(&p, &coefficients) && g.depth >= 0 &&
                            LENGTH(stack) >= 3 * g.depth && LENGTH(values) >= g.depth);
    if (right) {
        g.stack = stack.buf;
        g.values = values.buf;
        probe(&p, &g, separation, place, &step);
        if (step.kind == 1) {
            load_at(&p, step.front, &fall);
        } else if (step.front > separation) {
            fall = step.drop / (step.front - separation);
        } else {
            const Row *row = step.depth ? &g.stack[step.depth - 1] : NULL;
            int slipped = step.kind == 0 && row && fabs(row->density) == 1.0;
            load_at(&p, slipped ? row->end : separation, &fall);
        }
    }
    PyBuffer_Release(&stack);
    PyBuffer_Release(&values);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return Py_BuildValue("nddiddd", step.depth, step.front, step.density, step.kind, step.value,
                         step.outer, fall);
}

/* ---- what slip dissipates ------------------------------------------------------------------ */

static const double RULE_PANELS[] = {0.05, 1.0, 16.0};
static const int RULE_NODES[] = {4, 8, 16};
#define RULES_LENGTH 56 /* nodes and weights of all of them */

static double run_piece(const Profile *p, const double *rules, double top, double start, double end,
                        double first, double last)
{
    double ahead = end - start, rise = last - first;
    if (!(ahead > 0.0)) return 0.0;
    double length = start >= top ? 0.0 : ahead, parts = 1.0, total = 0.0;
    double turn = fmin(fabs(rise), 1e300);
    length = fmax(length, turn) * p->inverse_width;
    int rule = 0;
    while (rule < 2 && length > RULE_PANELS[rule]) rules += 2 * RULE_NODES[rule++];
    if (rule == 2) parts = fmax(ceil(length / RULE_PANELS[2]), 1.0);
    int count = RULE_NODES[rule];
    for (double k = 0.0; k < parts; k += 1.0) {
        double sum = 0.0;
        for (int i = 0; i < count; i++) {
            double t = (k + rules[i]) / parts;
            double gap = (start - first) + t * (ahead - rise);
            sum += rules[count + i] * excess_at(p, first + t * rise, fmax(gap, 0.0));
        }
        total += sum / parts;
    }
    return ahead * total;
}

static double run_loss(const Profile *p, const double *rules, double start, double end,
                       double first, double last)
{
    /* Past the end of the curve nothing depends on the front any more. */
    double top = p->anchor + (double)(p->panels - p->first) / p->inverse_width;
    double rise = last - first, ahead = end - start, begin = start;
    /* Where the separation itself is past it there is no load, and however far it goes no loss. */
    if (first > top) {
        if (!(last < top)) return 0.0;
        start = begin + fmin((top - first) / rise, 1.0) * ahead;
        first = top;
    } else if (last > top) {
        end = begin + fmin((top - first) / rise, 1.0) * ahead;
        last = top;
    }
    double stop = fmax(start, fmin(top, end));
    double share = end > start ? (stop - start) / (end - start) : 0.0;
    double meanwhile = first + share * (last - first);
    return run_piece(p, rules, top, start, stop, first, meanwhile) +
           run_piece(p, rules, top, stop, end, meanwhile, last);
}

/* The runs of one step that slips, see runs() of twin_losses.py, and what they lose. */
static double step_loss(const Profile *p, const double *rules, const Diagram *g, double last,
                        double move)
{
    double first = g->separation, rise = last - first, q = first, time = 0.0, total = 0.0;
    Py_ssize_t row = g->depth - 1; /* -1: beyond all rows */
    while (time < 1.0) {
        while (row >= 0 && g->stack[row].end <= q) row--;
        double end = row >= 0 ? g->stack[row].end : HUGE_VAL;
        double density = row >= 0 ? g->stack[row].density : 0.0;
        double drive = move + density * fmax(rise, 0.0);
        if (fabs(drive) <= 4e-16 * (fabs(move) + fabs(rise))) {
            time = rise > 0.0 ? fmin((end - first) / rise, 1.0) : 1.0;
            q = end;
            continue;
        }
        double sign = drive > 0.0 ? 1.0 : -1.0, pace = sign * move + rise, begun = time, from = q;
        while (time < 1.0) {
            end = row >= 0 ? g->stack[row].end : HUGE_VAL;
            density = row >= 0 ? g->stack[row].density : 0.0;
            double here = first + rise * time, rate = 1.0 - sign * density;
            if (rate == 0.0) {
                q = end;
                row--;
                continue;
            }
            double speed = pace / rate, until = fmin(time + (end - q) / speed, 1.0);
            int ahead = 0;
            if (speed < rise) {
                double caught = time + (q - here) / (rise - speed);
                if (caught <= until) {
                    until = caught;
                    ahead = 1;
                }
            }
            double stop = until < 1.0 && !ahead ? end : fmin(q + speed * (until - time), end);
            if (stop > q)
                total += rate * run_loss(p, rules, q, stop, here, first + rise * until);
            q = stop;
            time = until;
            if (ahead) break;
            if (q >= end) row--;
        }
        if (time <= begun && q <= from) { /* rounding: neither moves, so that neither slips */
            time = rise > 0.0 ? fmin((end - first) / rise, 1.0) : 1.0;
            q = end;
        }
    }
    return total;
}

static PyObject *py_losses(PyObject *self, PyObject *args)
{
    Py_buffer separation, place, loss, stack, rules, coefficients;
    Profile p;
    Diagram g = {0};
    if (!PyArg_ParseTuple(args, "y*y*w*w*nddy*" PROFILE_FORMAT, &separation, &place, &loss, &stack,
                          &g.depth, &g.separation, &g.place, &rules,
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    const double *ds = separation.buf, *xs = place.buf;
    double *out = loss.buf;
    Py_ssize_t n = LENGTH(separation);
    int right = long_enough(bind_profile(&p, &coefficients) && LENGTH(place) >= n &&
                            LENGTH(loss) >= n && g.depth >= 0 && LENGTH(rules) >= RULES_LENGTH &&
                            LENGTH(stack) >= 3 * (g.depth + n));
    if (!right) n = 0;
    g.stack = stack.buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        double d = ds[i], x = xs[i], front, density, beyond = g.place;
        int kind;
        Py_ssize_t depth = step_front(d, x, g.stack, g.depth, g.separation, g.place, &front,
                                      &density, &kind);
        out[i] = kind ? step_loss(&p, rules.buf, &g, d, x - g.place) : 0.0;
        if (kind) {
            beyond = 0.0;
            if (depth) {
                const Row *row = &g.stack[depth - 1];
                beyond = row->density * (row->end - front) + row->beyond;
            }
        }
        if (front > d) {
            g.stack[depth].end = front;
            g.stack[depth].density = density;
            g.stack[depth++].beyond = beyond;
        }
        g.depth = depth;
        g.separation = d;
        g.place = x;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&separation);
    PyBuffer_Release(&place);
    PyBuffer_Release(&loss);
    PyBuffer_Release(&stack);
    PyBuffer_Release(&rules);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    Py_RETURN_NONE;
}

/* ---- force control -------------------------------------------------------------------------- */

static double solve_front(const Profile *p, double anchor, double wanted, double low, int before)
{
    double slope, there = load_at(p, anchor, &slope);
    double target = before ? there + wanted : there - wanted;
    double high = before ? anchor : HUGE_VAL, q = low;
    if (before && slope > 0.0) q = fmax(low, anchor - wanted / slope);
    for (int i = 0; i < 200; i++) {
        double miss = before ? drop_at(p, q, anchor - q) - wanted
                             : wanted - drop_at(p, anchor, q - anchor);
        if (miss == 0.0 || (miss < 0.0 && q == low)) return q;
        if (miss > 0.0) low = q;
        else high = q;
        double load = target + miss, fall, next = HUGE_VAL, length = 0.0;
        load_at(p, q, &fall);
        if (load > 0.0 && fall > 0.0 && target > 0.0) {
            length = load / fall;
            next = q + length * log1p(miss / target);
        }
        int newton = low <= next && next <= high && length > 0.0;
        if (!newton)
            next = high < HUGE_VAL ? 0.5 * (low + high) : low + 2.0 * (fabs(low - anchor) + 1e-30);
        double step = next - q;
        if (newton && step * step <= 4e-17 * length * fabs(next - anchor)) return next;
        if (fabs(step) <= 2e-16 * fabs(next)) return next;
        q = next;
    }
    return q;
}

static double place_of(const Profile *p, const Diagram *g, double separation, double value)
{
    double fall = g->separation - separation, change = value - g->value, sign, begin;
    Py_ssize_t depth = g->depth;
    if (fall >= 0.0) {
        double gain = fall > 0.0 ? drop_at(p, separation, fall) : 0.0;
        if (fabs(change) <= gain) return g->place + (gain > 0.0 ? change / gain * fall : 0.0);
        sign = change > 0.0 ? 1.0 : -1.0;
        begin = g->separation;
    } else {
        while (depth && g->stack[depth - 1].end <= separation) depth--;
        double held = 0.0, place = 0.0;
        if (depth) {
            const Row *row = &g->stack[depth - 1];
            double outer = depth > 1 ? g->values[depth - 2] : 0.0;
            held = row->density * drop_at(p, separation, row->end - separation) + outer;
            place = row->density * (row->end - separation) + row->beyond;
        }
        if (value == held) return place;
        sign = value > held ? 1.0 : -1.0;
        begin = separation;
    }
    for (; depth; depth--) {
        const Row *row = &g->stack[depth - 1];
        double outer = depth > 1 ? g->values[depth - 2] : 0.0;
        double surplus = drop_at(p, separation, row->end - separation) + sign * (outer - value);
        if (row->density != sign && surplus >= 0.0) {
            double wanted = surplus / (1.0 - sign * row->density);
            double q = solve_front(p, row->end, wanted, fmax(begin, separation), 1);
            return sign * (q - separation) + row->density * (row->end - q) + row->beyond;
        }
        begin = fmax(begin, row->end);
    }
    return sign * (solve_front(p, separation, sign * value, begin, 0) - separation);
}

static PyObject *py_hold(PyObject *self, PyObject *args)
{
    Py_buffer separation, value, place, stack, values, coefficients;
    Profile p;
    Diagram g = {0};
    if (!PyArg_ParseTuple(args, "y*y*w*w*w*nddd" PROFILE_FORMAT, &separation, &value, &place,
                          &stack, &values, &g.depth, &g.separation, &g.place, &g.value,
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    const double *ds = separation.buf, *vs = value.buf;
    double *out = place.buf;
    Py_ssize_t n = LENGTH(separation);
    int right = long_enough(bind_profile(&p, &coefficients) && LENGTH(value) >= n &&
                            LENGTH(place) >= n && g.depth >= 0 &&
                            LENGTH(stack) >= 3 * (g.depth + n) && LENGTH(values) >= g.depth + n);
    if (!right) n = 0;
    g.stack = stack.buf;
    g.values = values.buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        Step step;
        out[i] = place_of(&p, &g, ds[i], vs[i]);
        probe(&p, &g, ds[i], out[i], &step);
        push(&g, ds[i], out[i], &step);
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&separation);
    PyBuffer_Release(&value);
    PyBuffer_Release(&place);
    PyBuffer_Release(&stack);
    PyBuffer_Release(&values);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return Py_BuildValue("nddd", g.depth, g.separation, g.place, g.value);
}

/* ---- Gaussian moments -------------------------------------------------------------------- */

static inline double chebyshev(const double *c, double t)
{
    double b1 = 0.0, b2 = 0.0, twice = 2.0 * t;
    for (int k = MOMENT_TERMS - 1; k > 0; k--) {
        double b0 = twice * b1 - b2 + c[k];
        b2 = b1;
        b1 = b0;
    }
    return t * b1 - b2 + c[0];
}

/* v^(twice/2) for twice >= -1 and v > 0 */
static inline double half_power(double v, int twice)
{
    double result = twice & 1 ? sqrt(v) : 1.0;
    if (twice == -1) return 1.0 / result;
    for (int k = twice / 2; k > 0; k--) result *= v;
    return result;
}

static double moment(const double *c, int twice, double h)
{
    if (h >= 0.0) {
        /* exp(-h^2/2) with h = head + tail, head^2 exact: a rounded square would cost 1e-13. */
        if (h > 1e3) return 0.0;
        double head = floor(h * 128.0 + 0.5) / 128.0, tail = h - head;
        double decay = exp(-0.5 * head * head) * exp(-0.5 * tail * (h + head));
        double r = 1.0 / (h + 4.0);
        return decay * half_power(r, twice + 2) * chebyshev(c + 3 * MOMENT_TERMS, (h - 4.0) * r);
    }
    if (h >= -4.0) return chebyshev(c + 2 * MOMENT_TERMS, (h + 2.0) / 2.0);
    if (h >= -10.0) return chebyshev(c + MOMENT_TERMS, (h + 7.0) / 3.0);
    double z = 10.0 / h;
    return half_power(-h, twice) * chebyshev(c, 2.0 * z * z - 1.0);
}

static PyObject *py_gaussian_moment(PyObject *self, PyObject *args)
{
    Py_buffer h, out, coefficients;
    int twice;
    if (!PyArg_ParseTuple(args, "y*w*y*i", &h, &out, &coefficients, &twice)) return NULL;
    const double *in = h.buf, *c = coefficients.buf;
    double *values = out.buf;
    Py_ssize_t n = LENGTH(h);
    int right = long_enough(LENGTH(out) >= n && LENGTH(coefficients) >= 4 * MOMENT_TERMS);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) values[i] = moment(c, twice, in[i]);
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&h);
    PyBuffer_Release(&out);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    Py_RETURN_NONE;
}

static PyObject *py_gaussian_moment_at(PyObject *self, PyObject *args)
{
    Py_buffer coefficients;
    double h, value;
    int twice;
    if (!PyArg_ParseTuple(args, "dy*i", &h, &coefficients, &twice)) return NULL;
    value = moment(coefficients.buf, twice, h);
    PyBuffer_Release(&coefficients);
    return PyFloat_FromDouble(value);
}

/* ---- module ------------------------------------------------------------------------------ */

static PyMethodDef methods[] = {
    {"evaluate", py_evaluate, METH_VARARGS, NULL},
    {"evaluate_one", py_evaluate_one, METH_VARARGS, NULL},
    {"locate", py_locate, METH_VARARGS, NULL},
    {"respond", py_respond, METH_VARARGS, NULL},
    {"branches", py_branches, METH_VARARGS, NULL},
    {"accumulate", py_accumulate, METH_VARARGS, NULL},
    {"step_front", py_step_front, METH_VARARGS, NULL},
    {"diagram", py_diagram, METH_VARARGS, NULL},
    {"loads", py_loads, METH_VARARGS, NULL},
    {"drops", py_drops, METH_VARARGS, NULL},
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
