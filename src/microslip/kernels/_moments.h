/* Partial moments of the normal distribution. Part of _compiled.c. */

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
    return none();
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
