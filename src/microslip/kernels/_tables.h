/* Piecewise polynomials: a backbone or an energy as a table. Part of _compiled.c. */

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
    return none();
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
