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
    {"gaussian_moment", py_gaussian_moment, METH_VARARGS, NULL},
    {"gaussian_moment_at", py_gaussian_moment_at, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL},
};

static int execute(PyObject *module) { return PyModule_AddIntConstant(module, "TERMS", TERMS); }

static PyModuleDef_Slot slots[] = {{Py_mod_exec, execute}, {0, NULL}};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_compiled", "Compiled kernels of microslip.", 0, methods, slots,
    NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__compiled(void) { return PyModuleDef_Init(&definition); }
