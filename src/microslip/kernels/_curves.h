/* Load curves: N, its differences and its inverse. Part of _compiled.c. */

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
    return none();
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
    return none();
}

static inline double curve_integral(const double *c, double s)
{
    double q = s * s, even = c[12] / 13, odd = c[13] / 14;
    for (int k = 10; k >= 0; k -= 2) even = even * q + c[k] / (k + 1);
    for (int k = 11; k >= 1; k -= 2) odd = odd * q + c[k] / (k + 1);
    return s * (odd * s + even);
}

/* At small steps by quadrature of what is positive, further out by the integrals of N. */
static double cycle_energy_at(const Profile *p, const double *bends, const double *tails,
                              const double *rule, Py_ssize_t nodes, double base, double width)
{
    double s0, s1, z = (base - p->anchor) * p->inverse_width, step = width * p->inverse_width;
    Py_ssize_t low = find_panel(p, z, &s0);
    if (low >= p->panels) return 0.0;
    const double *c = panel_at(p, low);
    double here = curve_value(c, s0), fall = curve_slope(c, s0);
    /* One decay length of N = (-d)^(3/2), two of an exponential, which is smoother. */
    double reach = here * (0.5 + 1.5 * here * shape(bends + low * TERMS, s0) / (fall * fall));
    if (-2.0 * step * fall < reach) {
        double sum = 0.0, s;
        for (Py_ssize_t i = 0; i < nodes; i++) {
            double share = rule[i];
            Py_ssize_t panel = find_panel(p, z + share * step, &s);
            if (panel >= p->panels) break;
            sum += rule[nodes + i] * share * (1.0 - share) * shape(bends + panel * TERMS, s);
        }
        return 2.0 * width * step * step * sum;
    }
    double half = 0.5 / p->inverse_width, there = 0.0;
    double whole = tails[low] - half * curve_integral(c, s0);
    Py_ssize_t high = find_panel(p, z + step, &s1);
    if (high < p->panels) {
        const double *d = panel_at(p, high);
        there = curve_value(d, s1);
        whole -= tails[high] - half * curve_integral(d, s1);
    }
    return 0.5 * width * (here + there) - whole;
}

static PyObject *py_cycle_energies(PyObject *self, PyObject *args)
{
    Py_buffer base, width, energy, bends, tails, rule, coefficients;
    Profile p;
    if (!PyArg_ParseTuple(args, "y*y*w*y*y*y*" PROFILE_FORMAT, &base, &width, &energy, &bends,
                          &tails, &rule, PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    const double *bases = base.buf, *widths = width.buf;
    double *out = energy.buf;
    Py_ssize_t n = LENGTH(base), nodes = LENGTH(rule) / 2;
    int right = long_enough(bind_profile(&p, &coefficients) && LENGTH(width) >= n &&
                            LENGTH(energy) >= n && LENGTH(tails) >= p.panels &&
                            LENGTH(bends) >= p.panels * TERMS);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++)
        out[i] = cycle_energy_at(&p, bends.buf, tails.buf, rule.buf, nodes, bases[i], widths[i]);
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&base);
    PyBuffer_Release(&width);
    PyBuffer_Release(&energy);
    PyBuffer_Release(&bends);
    PyBuffer_Release(&tails);
    PyBuffer_Release(&rule);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return none();
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
    return none();
}
