/* Piecewise polynomials: a backbone or an energy as a table. Part of _compiled.c.
 *
 * A table is panels of equal width, each with TERMS coefficients in s, -1 <= s <= 1, of a shape S:
 * the value at u >= 0 is u^power S(u); past the last panel it is limit + rate (u - end).
 */

struct Table {
    const double *coefficients;
    Py_ssize_t panels;
    double inverse_width, limit, rate;
    int power;
};

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

static int run_evaluate(const Argument *a, Result *out)
{
    const Table *t = a[3].table;
    const double *u = a[0].reals;
    double *value = a[1].reals, *slope = a[2].reals;
    if (a[1].n < a[0].n || (slope && a[2].n < a[0].n)) return TOO_SHORT;
    if (slope)
        for (Py_ssize_t i = 0; i < a[0].n; i++) value[i] = evaluate_at(t, u[i], &slope[i]);
    else
        for (Py_ssize_t i = 0; i < a[0].n; i++) value[i] = evaluate_at(t, u[i], NULL);
    return FINE;
}

static int run_evaluate_one(const Argument *a, Result *out)
{
    out[0].x = evaluate_at(a[1].table, a[0].x, &out[1].x);
    return FINE;
}
