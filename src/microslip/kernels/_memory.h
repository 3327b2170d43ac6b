/* The memory of a record at constant load: branches, and their values. Part of _compiled.c. */

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
    int right = long_enough(depth >= 0 && depth <= LENGTH(stack) / 2);
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
                            depth <= LENGTH(stack_buffer) / 2 - n);
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
                            depth >= 0 && depth <= LENGTH(stack_buffer) - n &&
                            depth <= LENGTH(code_buffer) - n);
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

static PyObject *py_closings(PyObject *self, PyObject *args)
{
    Py_buffer x_buffer, closed_buffer, stack_buffer;
    Py_ssize_t depth, count = 0;
    double last;
    int direction;
    if (!PyArg_ParseTuple(args, "y*w*w*ndi", &x_buffer, &closed_buffer, &stack_buffer, &depth, &last,
                          &direction))
        return NULL;
    const double *xs = x_buffer.buf;
    double *closed = closed_buffer.buf, *stack = stack_buffer.buf;
    Py_ssize_t n = LENGTH(x_buffer);
    int right = long_enough(depth >= 0 && depth <= LENGTH(stack_buffer) - n - 1 &&
                            depth <= LENGTH(closed_buffer) - n - 1);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        double x = xs[i];
        int pushed, before = direction;
        Py_ssize_t kept = locate(stack, 1, depth, last, &direction, x, &pushed);
        if (pushed) {
            stack[depth] = last;
        } else if (kept < depth || (direction != before && before && x != last)) {
            /* What locate() has taken off: with `last` on top where the move turned, in pairs. */
            if (direction != before && before) stack[depth++] = last;
            while (depth >= kept + 2) {
                depth -= 2;
                closed[count++] = 0.5 * fabs(stack[depth + 1] - stack[depth]);
            }
            if (depth > kept) closed[count++] = -fabs(stack[--depth]);
        }
        depth = kept;
        last = x;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&x_buffer);
    PyBuffer_Release(&closed_buffer);
    PyBuffer_Release(&stack_buffer);
    if (!right) return NULL;
    return PyLong_FromSsize_t(count);
}

static PyObject *py_accumulate(PyObject *self, PyObject *args)
{
    Py_buffer parent, rise, base;
    if (!PyArg_ParseTuple(args, "y*w*y*", &parent, &rise, &base)) return NULL;
    const long long *parents = parent.buf;
    const double *bases = base.buf;
    double *values = rise.buf;
    Py_ssize_t n = LENGTH(parent), columns = n > 0 ? LENGTH(rise) / n : 0;
    int right = long_enough(LENGTH(rise) == n * columns);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        long long p = parents[i];
        if (p == -1) continue;
        const double *above = p >= 0 ? values + p * columns : bases + (-2 - p) * columns;
        for (Py_ssize_t k = 0; k < columns; k++) values[i * columns + k] += above[k];
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&parent);
    PyBuffer_Release(&rise);
    PyBuffer_Release(&base);
    if (!right) return NULL;
    return none();
}
