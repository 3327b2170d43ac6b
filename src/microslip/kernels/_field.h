/* Many nodes on one load curve. Part of _compiled.c. */

static PyObject *py_excesses(PyObject *self, PyObject *args)
{
    Py_buffer base, width, excess, coefficients;
    Profile p;
    if (!PyArg_ParseTuple(args, "y*y*w*" PROFILE_FORMAT, &base, &width, &excess,
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    const double *bases = base.buf, *widths = width.buf;
    double *out = excess.buf;
    Py_ssize_t n = LENGTH(base);
    int right = long_enough(bind_profile(&p, &coefficients) && LENGTH(width) >= n &&
                            LENGTH(excess) >= n);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) out[i] = excess_at(&p, bases[i], widths[i]);
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&base);
    PyBuffer_Release(&width);
    PyBuffer_Release(&excess);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return none();
}
