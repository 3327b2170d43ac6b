/* Load curves: N of the separation, its differences and its inverse. Part of _compiled.c.
 *
 * A profile is panels of equal width, each with PROFILE_TERMS coefficients in s, -1 <= s <= 1; panel
 * `first` begins at `anchor`, and past the last one N is 0. What is a difference of N or of N' is
 * taken from divided differences, so that no digits are lost where it is small.
 *
 * Where no profile gives the law, its curve answers questions: see `Questions`.
 */

typedef struct Questions Questions;

struct Profile {
    const double *coefficients;
    Py_ssize_t panels, first;
    double anchor, inverse_width, least, most; /* first place and end of the panels, in widths */
    Questions *questions; /* NULL for panels */
    const double *edges;  /* of pieces, see _pieces.h; NULL for panels of equal width */
    const double *breaks; /* kinks, increasing */
    Py_ssize_t break_count;
};

#include "_pieces.h"

static double ask_drop(Questions *q, double base, double width);
static double ask_load(Questions *q, double x, double *fall);

static inline double curve_value(const double *c, double s)
{
    double q = s * s;
    Pair p = pair_of(c + 12);
    for (int k = 10; k >= 0; k -= 2) p = pair_next(p, q, pair_of(c + k));
    return ODD(p) * s + EVEN(p);
}

static inline double curve_slope(const double *c, double s)
{
    double slope;
    powers_at(c, PROFILE_TERMS, s, &slope);
    return slope;
}

static inline double first_difference(const double *c, double s0, double s1)
{
    double q0 = s0 * s0, q1 = s1 * s1;
    Pair p = pair_of(c + 12), rise = p;
    for (int k = 10; k > 0; k -= 2) {
        p = pair_next(p, q0, pair_of(c + k));
        rise = pair_next(rise, q1, p);
    }
    p = pair_next(p, q0, pair_of(c));
    return (s0 + s1) * (EVEN(rise) + s1 * ODD(rise)) + ODD(p);
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

/* Panel of a place z, in widths from the anchor, `panels` past the last; s is the position in
 * it. */
static inline Py_ssize_t find_panel(const Profile *p, double z, double *s)
{
    if (!(z < p->most)) {
        *s = 0.0;
        return p->panels;
    }
    if (!(z >= p->least)) z = p->least; /* checked by the caller */
    Py_ssize_t whole = (Py_ssize_t)z;
    whole -= z < (double)whole; /* no branch: the sign of z changes from node to node */
    *s = 2.0 * (z - (double)whole) - 1.0;
    return whole + p->first;
}

static inline const double *panel_at(const Profile *p, Py_ssize_t panel)
{
    return p->coefficients + panel * PROFILE_TERMS;
}

/* N at a place, and -N' if requested. */
static inline double load_at(const Profile *p, double x, double *fall)
{
    double s;
    if (p->questions) return ask_load(p->questions, x, fall);
    if (p->edges) return piece_load(p, x, fall);
    Py_ssize_t panel = find_panel(p, (x - p->anchor) * p->inverse_width, &s);
    if (panel >= p->panels) {
        if (fall) *fall = 0.0;
        return 0.0;
    }
    const double *c = panel_at(p, panel);
    if (!fall) return curve_value(c, s);
    double slope, load = powers_at(c, PROFILE_TERMS, s, &slope);
    *fall = -2.0 * p->inverse_width * slope;
    return load;
}

static inline double fall_at(const Profile *p, double x)
{
    double s, fall;
    if (p->questions) {
        ask_load(p->questions, x, &fall);
        return fall;
    }
    if (p->edges) {
        piece_load(p, x, &fall);
        return fall;
    }
    Py_ssize_t panel = find_panel(p, (x - p->anchor) * p->inverse_width, &s);
    if (panel >= p->panels) return 0.0;
    return -2.0 * p->inverse_width * curve_slope(panel_at(p, panel), s);
}

/* N(base) - N(base + width), where `there` is N(base + width), or NAN; over half a panel a difference
 * of two values loses no digits. */
static double drop_to(const Profile *p, double base, double width, double there)
{
    if (p->questions) return ask_drop(p->questions, base, width);
    if (p->edges) return piece_drop(p, base, width);
    double s0, s1, z = (base - p->anchor) * p->inverse_width;
    Py_ssize_t low = find_panel(p, z, &s0);
    if (low >= p->panels) return 0.0;
    const double *c = panel_at(p, low);
    double step = 2.0 * width * p->inverse_width;
    if (step >= 1.0 && there >= 0.0) return curve_value(c, s0) - there;
    Py_ssize_t high = find_panel(p, (base + width - p->anchor) * p->inverse_width, &s1);
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

static double drop_at(const Profile *p, double base, double width)
{
    return drop_to(p, base, width, NAN);
}

/* N(base) - N(base + width) with -N' at base + width: together, since both wait for the same panel.
 * `load` is N(base), or NAN. */
static inline double front_at(const Profile *p, double base, double width, double load, double *fall)
{
    double s0, s1;
    if (p->questions || p->edges) {
        *fall = fall_at(p, base + width);
        return width > 0.0 ? drop_at(p, base, width) : 0.0;
    }
    *fall = 0.0;
    Py_ssize_t high = find_panel(p, (base + width - p->anchor) * p->inverse_width, &s1);
    if (high >= p->panels) return load >= 0.0 ? load : load_at(p, base, NULL);
    const double *d = panel_at(p, high);
    double slope, there = powers_at(d, PROFILE_TERMS, s1, &slope), step = 2.0 * width * p->inverse_width;
    *fall = -2.0 * p->inverse_width * slope;
    if (step >= 1.0 && load >= 0.0) return load - there;
    Py_ssize_t low = find_panel(p, (base - p->anchor) * p->inverse_width, &s0);
    const double *c = panel_at(p, low);
    if (high == low) return -step * first_difference(c, s0, s1);
    if (high > low + 1) return curve_value(c, s0) - there;
    double left = 1.0 - s0, right = step - left;
    return -(left * first_difference(c, s0, 1.0) + right * first_difference(d, -1.0, right - 1.0));
}

/* N(base) - N(base + width) + width N'(base + width); of panels only */
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

static int run_loads(const Argument *a, Result *out)
{
    double *value = a[1].reals, *fall = a[2].reals;
    if (a[1].n < a[0].n || (fall && a[2].n < a[0].n)) return TOO_SHORT;
    for (Py_ssize_t i = 0; i < a[0].n; i++)
        value[i] = load_at(a[3].curve, a[0].reals[i], fall ? &fall[i] : NULL);
    return FINE;
}

static int run_drops(const Argument *a, Result *out)
{
    if (!all_have(a, 1, 2, a[0].n)) return TOO_SHORT;
    for (Py_ssize_t i = 0; i < a[0].n; i++)
        a[2].reals[i] = drop_at(a[3].curve, a[0].reals[i], a[1].reals[i]);
    return FINE;
}

static int run_excesses(const Argument *a, Result *out)
{
    if (!all_have(a, 1, 2, a[0].n)) return TOO_SHORT;
    for (Py_ssize_t i = 0; i < a[0].n; i++)
        a[2].reals[i] = excess_at(a[3].curve, a[0].reals[i], a[1].reals[i]);
    return FINE;
}

static inline double curve_integral(const double *c, double s)
{
    double q = s * s, even = c[12] * (1.0 / 13), odd = c[13] * (1.0 / 14);
    for (int k = 10; k >= 0; k -= 2) even = even * q + c[k] * (1.0 / (k + 1));
    for (int k = 11; k >= 1; k -= 2) odd = odd * q + c[k] * (1.0 / (k + 1));
    return s * (odd * s + even);
}

/* Tail integral of N, from the integrals beyond the middle of each panel, and N. */
static inline double tail_at(const Profile *p, const double *tails, double x, double *load)
{
    double s;
    Py_ssize_t panel = find_panel(p, (x - p->anchor) * p->inverse_width, &s);
    *load = 0.0;
    if (panel >= p->panels) return 0.0;
    const double *c = panel_at(p, panel);
    *load = curve_value(c, s);
    return tails[panel] - 0.5 / p->inverse_width * curve_integral(c, s);
}

/* Quadrature of a positive integrand for small steps, integrals of N for large ones. */
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

static int run_cycle_energies(const Argument *a, Result *out)
{
    const Profile *p = a[6].curve;
    Py_ssize_t nodes = a[5].n / 2;
    if (!all_have(a, 1, 2, a[0].n) || a[3].n < p->panels * TERMS || a[4].n < p->panels)
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < a[0].n; i++)
        a[2].reals[i] = cycle_energy_at(p, a[3].reals, a[4].reals, a[5].reals, nodes,
                                        a[0].reals[i], a[1].reals[i]);
    return FINE;
}

/* Separation from a table over log N, followed by a Newton step. */
static int run_separations(const Argument *a, Result *out)
{
    const Profile *p = a[2].curve;
    Table t = {a[3].reals, a[3].n / TERMS, a[4].x, 0.0, 0.0, 0};
    if (a[1].n < a[0].n || t.panels < 1) return TOO_SHORT;
    double most = nextafter((double)t.panels / t.inverse_width, 0.0);
    for (Py_ssize_t i = 0; i < a[0].n; i++) {
        double load = a[0].reals[i], x = log(load) - a[5].x, fall;
        x = x > 0.0 ? (x < most ? x : most) : 0.0;
        double d = evaluate_at(&t, x, NULL), there = load_at(p, d, &fall);
        a[1].reals[i] = fall > 0.0 ? d + (there - load) / fall : d;
    }
    return FINE;
}
