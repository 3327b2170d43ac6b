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

static int run_gaussian_moment(const Argument *a, Result *out)
{
    const double *h = a[0].reals;
    double *values = a[1].reals;
    if (a[1].n < a[0].n || a[2].n < 4 * MOMENT_TERMS) return TOO_SHORT;
    for (Py_ssize_t i = 0; i < a[0].n; i++) values[i] = moment(a[2].reals, (int)a[3].n, h[i]);
    return FINE;
}

static int run_gaussian_moment_at(const Argument *a, Result *out)
{
    if (a[1].n < 4 * MOMENT_TERMS) return TOO_SHORT;
    out->x = moment(a[1].reals, (int)a[2].n, a[0].x);
    return FINE;
}
