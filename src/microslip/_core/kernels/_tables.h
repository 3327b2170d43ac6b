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

/* Coefficients of an even power and of the next odd one, which processors multiply and add
 * together. */
#ifdef __GNUC__
typedef double Pair __attribute__((vector_size(16)));
#define EVEN(pair) (pair)[0]
#define ODD(pair) (pair)[1]
static inline Pair pair_next(Pair p, double q, Pair c) { return p * q + c; }
#else
typedef struct {
    double even, odd;
} Pair;
#define EVEN(pair) (pair).even
#define ODD(pair) (pair).odd
static inline Pair pair_next(Pair p, double q, Pair c)
{
    Pair next = {p.even * q + c.even, p.odd * q + c.odd};
    return next;
}
#endif

static inline Pair pair_of(const double *c)
{
    Pair p;
    memcpy(&p, c, sizeof(p));
    return p;
}

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

/* Sum of an even number of powers of s, and its derivative. */
static inline double powers_at(const double *c, int terms, double s, double *slope)
{
    double q = s * s;
    Pair p = pair_of(c + terms - 2), d = p;
    for (int k = terms - 4; k > 0; k -= 2) {
        p = pair_next(p, q, pair_of(c + k));
        d = pair_next(d, q, p);
    }
    p = pair_next(p, q, pair_of(c));
    *slope = ODD(p) + 2.0 * s * (EVEN(d) + s * ODD(d));
    return ODD(p) * s + EVEN(p);
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
    double rise, value = powers_at(c, TERMS, s, &rise);
    if (t->power == 0) {
        if (slope) *slope = 2.0 * t->inverse_width * rise;
        return value;
    }
    if (t->power == 1) {
        if (slope) *slope = value + u * (2.0 * t->inverse_width * rise);
        return u * value;
    }
    if (t->power == 2) {
        if (slope) *slope = u * (2.0 * value + u * (2.0 * t->inverse_width * rise));
        return u * (u * value);
    }
    if (slope) *slope = u * u * (3.0 * value + u * (2.0 * t->inverse_width * rise));
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
