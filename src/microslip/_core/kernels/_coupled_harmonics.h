/* Fourier coefficients of settled forces under separations that vary, without samples. Part of
 * _compiled.c.
 *
 * With a place p and a step d let a = d + p and b = d - p. Where both fall, all sticks and
 * T' = -N'(d) p'; where one rises, contact slips towards that side, where both do, towards the side
 * of before. What is held beyond a separation eta is a place P(eta), and the levels eta + P and
 * eta - P rise with eta: a slip front stands where the level of its side is a, or b. It lies
 *
 * - in what slipped the other way up to time k: dT = A_k + F_q (s dd + s dd_k + dp - dp_k),
 * - in what stuck at a time u, with q = d(u): T = T(u) + s [N(d) - N(q)],
 *   dT = dT(u) + F_q (s dd + dp - dp(u)), as u itself is stationary,
 *
 * each less s F_d dd; F = -N', s the side. So between the times at which a or b turns, a front passes
 * from one band into the next, or slip turns to the other side as its front is lost, the force is
 * smooth, and is integrated as at held loads (_harmonics.h), with places as of a cosine: it has roots
 * at the ends of bands. What sticks is kept as Chebyshev series in time.
 */

#define SERIES 16 /* terms of the series while sticking */
#define MOST_BANDS 128 /* besides bands that end at kinks of the law */
#define MARGIN 30.0 /* largest error of a rule over its estimate */
#define LEAST_PEAK 1e-4 /* smallest peak of the force over its limit to which the tolerance refers */
/* Lengths times the highest harmonic for which the rules usually reach 1e-10. */
static const double LENGTHS[RULES] = {0.45, 1.3, 3.0, 4.5, 6.3};

enum { SLIP_BAND, STICK_BAND, PRESS_BAND }; /* the last along the straight path from rest */

typedef struct {
    int kind;
    double side, end, level[2]; /* outer start and levels there */
    double from, to;            /* times of sticking */
    double value, step;         /* T/mu and step at the end of the slip */
    double *ahead, *phi;        /* slip: A, and the functions at its end */
    double *series;             /* sticking: T, then dT by each coefficient */
} Band;

typedef struct {
    Motion place, step, up, down; /* up: a, down: b */
    const Profile *p;
    double rest;
    double scale;
    int n, depth, failed, all; /* all: sums of a part */
    int most_bands;
    Band *bands;
    double *marks;
    double root_place, root_step, *root_phi;
    double then; /* found last */
    int band; /* band of the last front, -1 beyond all bands */
    double side, front, now, value, load, here, fall, back;
    const double *early, *before; /* functions and A where the band was left */
    double *slope, *ahead;        /* by places, then by steps */
    double *waves, *early_waves, *nothing, *w, *row, *rates; /* scratch */
    Node rules[RULES][MOST_HALF]; /* with places as of a cosine */
    double to_series[SERIES][SERIES], places[SERIES];
    double *sums; /* force, its slopes, load, products of F and functions */
    double force_miss, slope_miss;
    double most, peak, squares; /* scale and peak of the force; errors of pieces */
} Walk;

/* Quadrature nodes whose fronts are in one band. */
typedef struct {
    int band;
    double side, back;
    const double *early, *before;
} Group;

/* -N'', from the profile. */
static double bend_at(const Profile *p, double x)
{
    if (p->edges) return piece_bend(p, x);
    double s, sum = 0.0, scale = 2.0 * p->inverse_width;
    Py_ssize_t panel = find_panel(p, (x - p->anchor) * p->inverse_width, &s);
    if (panel >= p->panels) return 0.0;
    const double *c = panel_at(p, panel);
    for (int k = PROFILE_TERMS - 1; k >= 2; k--) sum = sum * s + k * (k - 1) * c[k];
    return -scale * scale * sum;
}

static double level_of(const Walk *w, double side, double t)
{
    return place_at(side > 0.0 ? &w->up : &w->down, t, NULL);
}

/* Evaluate the series of sticking at x in [-1, 1]: T, and its derivatives if requested. */
static double sum_series(const Walk *w, const double *series, double x, double *slope)
{
    int columns = slope ? 2 * w->n + 1 : 1, width = 2 * w->n + 1;
    double *restrict sum = w->row, term = x, before = 1.0;
    memcpy(sum, series, (size_t)columns * sizeof(double));
    for (int k = 1; k <= SERIES; k++) {
        const double *restrict row = series + k * width;
        for (int j = 0; j < columns; j++) sum[j] += term * row[j];
        double next = 2.0 * x * term - before;
        before = term;
        term = next;
    }
    if (slope) memcpy(slope, sum + 1, (size_t)(width - 1) * sizeof(double));
    return sum[0];
}

/* The place of a series for a time from -1 to 1: as of a cosine where N'' may have roots. */
static inline double series_place(const Walk *w, double x)
{
    return w->p->edges ? 4.0 / TURN * asin(fmax(fmin(x, 1.0), -1.0)) : x;
}

/* T, dT and the functions at the time when the front was at q. */
static double recall(Walk *w, const Band *b, double t, double *slope, double *phi)
{
    if (b->kind == STICK_BAND) {
        if (slope) make_waves(t, w->place.H, phi);
        double half = 0.5 * (b->to - b->from);
        return sum_series(w, b->series, series_place(w, (t - b->from - half) / half), slope);
    }
    double d = w->root_step, D = -w->root_place / d, fall = 0.0; /* t is the fraction of the path */
    double rise = drop_at(w->p, w->rest + t * d, -t * d);
    if (!slope) return D * rise;
    fall = fall_at(w->p, w->rest + t * d);
    for (int j = 0; j < w->n; j++) {
        phi[j] = t * w->root_phi[j];
        slope[j] = -rise / d * w->root_phi[j];
        slope[w->n + j] = -(rise / d + fall * t) * D * w->root_phi[j];
    }
    return D * rise;
}

/* Time at which sticking contact had a level, or the fraction of the path from rest. */
static double time_of(Walk *w, const Band *b, double side, double level)
{
    if (b->kind == PRESS_BAND) return level / (w->root_step + side * w->root_place);
    double near = w->then > b->from && w->then < b->to ? w->then : 0.5 * (b->from + b->to);
    return w->then = find_time(side > 0.0 ? &w->up : &w->down, 0, level, 0, b->from, b->to, near);
}

/* T at a time, with the functions then in `waves`, while contact slips, and what its derivatives hang
 * from. */
static void slip_here(Walk *w, double t, double side, int both)
{
    int k = w->depth - 1, n = w->n;
    const double *phi = w->waves;
    double d = 0.0, place = 0.0, value = 0.0;
    for (int j = 0; j < n; j++) {
        d += w->step.c[j] * phi[j];
        place += w->place.c[j] * phi[j];
    }
    if (both) { /* sliding continues with all contact that is not lost */
        double held = 0.0;
        while (k >= 0 && w->bands[k].end <= d) k--;
        if (k >= 0) {
            const Band *b = &w->bands[k];
            if (b->kind == SLIP_BAND) {
                held = b->side > 0.0 ? b->level[0] - d : d - b->level[1];
            } else if (b->kind == PRESS_BAND) {
                held = w->root_place / w->root_step * d;
            } else {
                double then = find_time(&w->step, 0, d, 0, b->from, b->to, 0.5 * (b->from + b->to));
                held = place_at(&w->place, then, NULL);
            }
        }
        side = place >= held ? 1.0 : -1.0;
    }
    double level = d + side * place, q = level;
    for (; k >= 0; k--) {
        const Band *b = &w->bands[k];
        if (!(b->kind == SLIP_BAND && b->side == side) && level < b->level[side < 0.0]) break;
    }
    const Band *b = k < 0 ? NULL : &w->bands[k];
    w->early = w->nothing;
    w->before = w->nothing;
    w->back = 0.0;
    if (b && b->kind == SLIP_BAND) {
        q = fmax(0.5 * (level + b->level[side > 0.0]), d);
        value = b->value + side * drop_at(w->p, w->rest + b->step, fmax(q - b->step, 0.0));
        w->early = b->phi;
        w->before = b->ahead;
        w->back = side;
    } else if (b) {
        double then = time_of(w, b, side, level);
        w->early = w->early_waves;
        w->before = w->ahead;
        value = recall(w, b, then, w->ahead, w->early_waves);
        q = b->kind == STICK_BAND ? place_at(&w->step, then, NULL) : then * w->root_step;
        q = fmax(q, d);
    }
    w->value = value + (q > d ? side * drop_at(w->p, w->rest + d, q - d) : 0.0);
    w->fall = fall_at(w->p, w->rest + q);
    w->load = load_at(w->p, w->rest + d, &w->here);
    w->band = k;
    w->side = side;
    w->front = q;
    w->now = d;
}

static void slip_at(Walk *w, double t, double side, int both)
{
    make_waves(t, 2 * w->place.H, w->waves);
    slip_here(w, t, side, both);
}

/* dT of this result, without the part that follows the step. */
static void derive_slip(Walk *w)
{
    const double *phi = w->waves, *early = w->early;
    double *ahead = w->ahead;
    for (int j = 0, n = w->n; j < n; j++) {
        ahead[j] = w->before[j] + w->fall * (phi[j] - early[j]);
        ahead[n + j] = w->before[n + j] + w->fall * (w->side * phi[j] + w->back * early[j]);
        w->slope[j] = ahead[j];
        w->slope[n + j] = ahead[n + j] - w->side * w->here * phi[j];
    }
}

/* Add the common terms of nodes in one band to the derivatives, and clear them. */
static void add_group(Walk *w, const Group *g, double *sums)
{
    int n = w->n, wide = 4 * w->place.H + 1;
    double *J = sums + n, *falls = J + 2 * n * n + n, *shares = falls + wide;
    double *fronts = shares + n, *heres = fronts + wide;
    if (g->band == -2) return;
    for (int i = 0; i < n; i++) {
        double *row = J + 2 * n * i;
        for (int j = 0; j < n; j++) {
            double both = product(fronts, i, j), early = fronts[i] * g->early[j];
            row[j] += shares[i] * g->before[j] + both - early;
            row[n + j] += shares[i] * g->before[n + j] +
                          g->side * (both - product(heres, i, j)) + g->back * early;
        }
    }
    for (int k = 0; k < wide; k++) falls[k] += heres[k];
    memset(shares, 0, (size_t)(n + 2 * wide) * sizeof(double));
}

/* Add the values at one node to the sums of a piece and to the error of the Gauss rule. */
static void add_place(Walk *w, const double *phi, double weight, double miss, int alone, double *off)
{
    int n = w->n, wide = 4 * w->place.H + 1;
    double *force = w->w, *J = force + n, *load = J + 2 * n * n, *falls = load + n;
    double *shares = falls + wide, *fronts = shares + n, *heres = fronts + wide;
    double f = weight * w->value, g = weight * w->load, here = weight * w->here;
    double front = weight * w->fall, f_miss = miss * w->value;
    double k_miss = miss * (alone ? w->slope[0] : w->fall);
    for (int k = 0; k < n; k++) {
        force[k] += f * phi[k];
        load[k] += g * phi[k];
    }
    if (alone) {
        for (int k = 0; k < n; k++) {
            double *restrict row = J + 2 * n * k, share = weight * phi[k];
            const double *restrict slope = w->slope;
            for (int j = 0; j < 2 * n; j++) row[j] += share * slope[j];
        }
        for (int k = 0; k < wide; k++) falls[k] += here * phi[k];
    } else {
        for (int k = 0; k < n; k++) shares[k] += weight * phi[k];
        for (int k = 0; k < wide; k++) {
            fronts[k] += front * phi[k];
            heres[k] += here * phi[k];
        }
    }
    /* The mean and the highest functions determine the error. */
    off[0] += f_miss;
    off[1] += f_miss * phi[n - 2];
    off[2] += f_miss * phi[n - 1];
    off[3] += k_miss * phi[n - 2];
    off[4] += k_miss * phi[n - 1];
    off[5] += miss * (alone ? w->slope[n] : w->here) * phi[n - 1];
}

/* Add the integrals over a piece, sticking in `band` or slipping. The number of nodes depends on
 * the length of the piece in periods of the highest harmonic. */
static void add_span(Walk *w, double low, double high, const Band *band, double side, int both)
{
    double begins[HALVINGS + 1], ends[HALVINGS + 1], cosines[MOST_HALF], sines[MOST_HALF];
    double length = w->scale * (high - low);
    int left = 0, n = w->n, H = w->place.H, all = w->all, rule = 0, whole = 1;
    long parts = 0;
    Group group = {-2, 0.0, 0.0, NULL, NULL};
    if (!(high > low)) return;
    if (length > LENGTHS[RULES - 1]) whole = (int)ceil(length / LENGTHS[RULES - 1]);
    while (rule < RULES - 1 && length > whole * LENGTHS[rule]) rule++;
    for (int piece = 0; left || piece < whole;) {
        if (!left) {
            begins[0] = low + (high - low) * piece / whole;
            ends[left++] = ++piece < whole ? low + (high - low) * piece / whole : high;
        }
        double from = begins[--left], to = ends[left], half = 0.5 * (to - from);
        double centre = 0.5 * (from + to), off[6] = {0.0}, co = cos(centre), si = sin(centre);
        Group own = {-2, 0.0, 0.0, NULL, NULL};
        double *phi = w->waves;
        memset(w->w, 0, (size_t)all * sizeof(double));
        for (int i = 0, middle = GAUSS_PLACES[rule]; i <= 2 * middle; i++) {
            int k = i <= middle ? i : 2 * middle - i, alone = 1;
            const Node *node = &w->rules[rule][k];
            double reach = half * node->place;
            if (i <= middle) {
                cosines[k] = cos(reach);
                sines[k] = -sin(reach);
            }
            double c = cosines[k], s = i < middle ? sines[k] : -sines[k];
            double t = i < middle ? centre - reach : centre + reach;
            raise_waves(co * c - si * s, si * c + co * s, 2 * H, phi);
            if (band) {
                double d = 0.0, x = 2.0 * (t - band->from) / (band->to - band->from) - 1.0;
                for (int j = 0; j < n; j++) d += w->step.c[j] * phi[j];
                w->load = load_at(w->p, w->rest + d, &w->here);
                w->value = sum_series(w, band->series, series_place(w, x), w->slope);
            } else {
                slip_here(w, t, side, both);
                alone = w->band >= 0 && w->bands[w->band].kind != SLIP_BAND;
                if (alone) derive_slip(w);
            }
            if (!alone && (w->band != own.band || w->side != own.side)) {
                add_group(w, &own, w->w);
                own = (Group){w->band, w->side, w->back, w->early, w->before};
            }
            w->peak = fmax(w->peak, fabs(w->value));
            add_place(w, phi, half * node->weight, half * node->miss, alone, off);
        }
        double worst = fmax(fmax(fabs(off[0]), fabs(off[1])), fabs(off[2]));
        double stiff = fmax(fmax(fabs(off[3]), fabs(off[4])), fabs(off[5]));
        int rough = worst > w->force_miss || stiff > w->slope_miss;
        if (rough && ++parts > MOST_PARTS) w->failed = 1;
        if (rough && !w->failed && left < HALVINGS - 1 && to - from > 1e-13) {
            begins[left] = centre;
            ends[left++] = to;
            begins[left] = from;
            ends[left++] = centre;
            continue;
        }
        if (w->most > 0.0) { /* exact to the power 3/2 of this, within the factor */
            worst /= 0.1 * w->most;
            w->squares += worst * worst * worst;
        }
        if (own.band != group.band || own.side != group.side) {
            add_group(w, &group, w->sums);
            group = own;
        }
        for (int i = 0; i < all; i++) w->sums[i] += w->w[i];
    }
    add_group(w, &group, w->sums);
}

/* Series of T and dT from `low` on with given initial values; returns 1 if converged. */
static int fit_stick(Walk *w, Band *b, double low, double high)
{
    int n = w->n, H = w->place.H;
    double half = 0.5 * (high - low);
    double *all = w->w; /* rates of all columns at the places */
    for (int i = 0; i < SERIES; i++) {
        double *row = all + (size_t)i * (2 * n + 1), x = w->rest, speed = 0.0;
        const double *phi = w->waves, *p = w->place.c, *d = w->step.c;
        double place = w->p->edges ? sin(0.25 * TURN * w->places[i]) : w->places[i];
        make_waves(low + half * (1.0 + place), H, w->waves);
        for (int j = 0; j < n; j++) x += d[j] * phi[j];
        for (int m = 1; m <= H; m++)
            speed += m * (p[2 * m] * phi[2 * m - 1] - p[2 * m - 1] * phi[2 * m]);
        double fall = fall_at(w->p, x), bend = bend_at(w->p, x) * speed;
        row[0] = fall * speed;
        row[1] = 0.0;
        for (int m = 1; m <= H; m++) {
            row[2 * m] = -m * fall * phi[2 * m];
            row[2 * m + 1] = m * fall * phi[2 * m - 1];
        }
        for (int j = 0; j < n; j++) row[1 + n + j] = bend * phi[j];
    }
    b->from = low;
    b->to = high;
    int width = 2 * n + 1;
    for (int i = 0; i < SERIES / 2; i++) { /* even and odd parts, for even and odd terms */
        double *restrict one = all + i * width, *restrict other = all + (SERIES - 1 - i) * width;
        for (int j = 0; j < width; j++) {
            double even = one[j] + other[j];
            other[j] = one[j] - other[j];
            one[j] = even;
        }
    }
    double *restrict sum = w->row;
    memset(sum, 0, (size_t)width * sizeof(double));
    for (int k = 0; k < SERIES; k++) {
        double *restrict rates = w->rates + k * width;
        memset(rates, 0, (size_t)width * sizeof(double));
        for (int i = 0; i < SERIES / 2; i++) {
            const double *restrict at = all + (k % 2 ? SERIES - 1 - i : i) * width;
            double share = half * w->to_series[k][i];
            if (w->p->edges) share *= 0.25 * TURN * cos(0.25 * TURN * w->places[i]);
            for (int j = 0; j < width; j++) rates[j] += share * at[j];
        }
    }
    for (int k = 1; k <= SERIES; k++) {
        double *restrict c = b->series + k * width, sign = k % 2 ? -1.0 : 1.0;
        const double *before = w->rates + (k - 1) * width, *after = before + 2 * width;
        double first = (k == 1 ? 2.0 : 1.0) / (2.0 * k), second = k + 1 < SERIES ? 0.5 / k : 0.0;
        for (int j = 0; j < width; j++) {
            c[j] = first * before[j] - second * after[j];
            sum[j] += sign * c[j];
        }
    }
    b->series[0] = w->value - sum[0];
    for (int j = 1; j < width; j++) b->series[j] = w->slope[j - 1] - sum[j];
    double worst = 0.0, stiff = 0.0; /* of the last two terms */
    for (int k = SERIES - 1; k <= SERIES; k++) {
        const double *c = b->series + k * width;
        worst = fmax(worst, fabs(c[0]));
        stiff = fmax(stiff, fmax(fabs(c[n]), fabs(c[2 * n])));
    }
    return worst <= 0.1 * w->force_miss && stiff <= 0.1 * w->slope_miss;
}

static Band *push_band(Walk *w, int kind, double side, double end, double up, double down)
{
    if (w->depth == w->most_bands) {
        w->failed = 1;
        w->depth--;
    }
    Band *b = &w->bands[w->depth++];
    b->kind = kind;
    b->side = side;
    b->end = end;
    b->level[0] = up;
    b->level[1] = down;
    return b;
}

/* Sticking from one time to another, in as many bands as the series need. */
static void stick(Walk *w, double low, double high, int halvings)
{
    Band *b = push_band(w, STICK_BAND, 0.0, place_at(&w->step, low, NULL),
                        level_of(w, 1.0, low), level_of(w, -1.0, low));
    if (!fit_stick(w, b, low, high) && halvings && !w->failed) {
        w->depth--;
        stick(w, low, 0.5 * (low + high), halvings - 1);
        stick(w, 0.5 * (low + high), high, halvings - 1);
        return;
    }
    w->value = sum_series(w, b->series, 1.0, w->slope);
}

/* End of a slip: store its state and the values there. */
static void leave_slip(Walk *w, double t, double side, int both)
{
    slip_at(w, t, side, both);
    derive_slip(w);
    w->depth = w->band + 1;
    if (!(w->front > w->now)) return;
    double level = level_of(w, w->side, t), other = 2.0 * w->front - level;
    Band *b = push_band(w, SLIP_BAND, w->side, w->front, w->side > 0.0 ? level : other,
                        w->side > 0.0 ? other : level);
    b->value = w->value;
    b->step = w->now;
    memcpy(b->ahead, w->ahead, 2 * (size_t)w->n * sizeof(double));
    memcpy(b->phi, w->waves, (size_t)w->n * sizeof(double));
}

/* Time at which slip changes side because its front is lost, `high` if it does not. */
static double find_flip(Walk *w, double low, double high)
{
    double inside = 1e-9 * (high - low), from = low + inside, to = high - inside;
    slip_at(w, from, 0.0, 1);
    double side = w->side;
    slip_at(w, to, 0.0, 1);
    if (w->side == side) return high;
    while (to - from > 1e-14) {
        double middle = 0.5 * (from + to);
        if (middle <= from || middle >= to) break;
        slip_at(w, middle, 0.0, 1);
        if (w->side == side) from = middle;
        else to = middle;
    }
    return to;
}

/* Adds the times at which a front on one side passes a place where the law is not smooth, while the
 * level of that side rises between two values. */
static int mark_fronts(const Walk *w, double side, double from, double to, double low, double high,
                       double *marks, int n)
{
    const Motion *m = side > 0.0 ? &w->up : &w->down;
    double inner = from;
    for (int k = w->depth - 1; k >= -1 && inner < to; k--) {
        const Band *b = k < 0 ? NULL : &w->bands[k];
        if (b && b->kind == SLIP_BAND && b->side == side) continue;
        double outer = b ? fmin(b->level[side < 0.0], to) : to;
        if (!(outer > inner)) continue;
        /* The front is at first + rate times the level; bands of sticking end at kinks of the
         * law. */
        double first = 0.0, rate = 1.0;
        if (b && b->kind == SLIP_BAND) {
            rate = 0.5;
            first = 0.5 * b->level[side > 0.0];
        } else if (b && b->kind == PRESS_BAND) {
            rate = w->root_step / (w->root_step + side * w->root_place);
        } else if (b) {
            inner = outer;
            continue;
        }
        const double *breaks;
        double begin = w->rest + first + rate * inner, end = w->rest + first + rate * outer;
        Py_ssize_t count = breaks_between(w->p, fmin(begin, end), fmax(begin, end), &breaks);
        for (Py_ssize_t i = 0; i < count; i++) {
            double level = (breaks[i] - w->rest - first) / rate;
            if (level > from && level < to)
                marks[n++] = find_time(m, 0, level, 1, low, high, 0.5 * (low + high));
        }
        inner = outer;
    }
    return n;
}

/* Term of the derivative by the step where the slip stiffness jumps at the start of sticking. */
static void pass_jump(Walk *w, double t)
{
    double rates[3], d = place_at(&w->step, t, rates), fall_rate = rates[0];
    const double *breaks;
    double near = 1e-9 * (fabs(w->rest + d) + fabs(w->root_step));
    if (!breaks_between(w->p, w->rest + d - near, w->rest + d + near, &breaks)) return;
    Py_ssize_t i = find_piece(w->p, breaks[0]);
    if (i < 1 || !(fall_rate < 0.0)) return;
    const double *row = piece_at(w->p, i - 1);
    double before = row[PIECE_INVERSE] * shape(row + PIECE_POWERS, -1.0);
    double jump = before - fall_at(w->p, breaks[0]);
    if (!(jump > 1e-10 * before)) return;
    place_at(&w->place, t, rates);
    make_waves(t, w->place.H, w->waves);
    for (int j = 0; j < w->n; j++) w->slope[w->n + j] += jump * rates[0] / fall_rate * w->waves[j];
}

/* One cycle from the root; with sums, integrated between the bands that a front passes. */
static void go_around(Walk *w, const double *times, int count, int sum)
{
    double *marks = w->marks, a, b;
    double a_end = level_of(w, 1.0, times[0]), b_end = level_of(w, -1.0, times[0]);
    for (int i = 0; i < count; i++) {
        double low = times[i], high = i + 1 < count ? times[i + 1] : times[0] + TURN;
        a = a_end;
        b = b_end;
        a_end = level_of(w, 1.0, high);
        b_end = level_of(w, -1.0, high);
        int rises = a_end > a, falls = b_end > b, n = 0;
        if (!rises && !falls) {
            int first = w->depth;
            if (w->p->edges && i) pass_jump(w, low);
            stick(w, low, high, 5);
            for (int k = first; sum && k < w->depth; k++)
                add_span(w, w->bands[k].from, w->bands[k].to, &w->bands[k], 0.0, 0);
            w->value = sum_series(w, w->bands[w->depth - 1].series, 1.0, w->slope);
            continue;
        }
        double side = rises ? 1.0 : -1.0;
        if (sum) {
            marks[n++] = low;
            for (int k = w->depth - 1; k >= 0; k--) {
                const double *level = w->bands[k].level;
                if (rises && level[0] > a && level[0] < a_end)
                    marks[n++] = find_time(&w->up, 0, level[0], 1, low, high, 0.5 * (low + high));
                if (falls && level[1] > b && level[1] < b_end)
                    marks[n++] = find_time(&w->down, 0, level[1], 1, low, high, 0.5 * (low + high));
            }
            if (w->p->edges && rises) n = mark_fronts(w, 1.0, a, a_end, low, high, marks, n);
            if (w->p->edges && falls) n = mark_fronts(w, -1.0, b, b_end, low, high, marks, n);
            for (int k = 1; k < n; k++) { /* in order */
                double t = marks[k];
                int j = k;
                for (; j > 0 && marks[j - 1] > t; j--) marks[j] = marks[j - 1];
                marks[j] = t;
            }
            marks[n++] = high;
            for (int k = 0; k + 1 < n; k++) {
                double from = marks[k], turn = marks[k + 1];
                if (rises && falls) turn = find_flip(w, from, turn);
                add_span(w, from, turn, NULL, side, rises && falls);
                add_span(w, turn, marks[k + 1], NULL, side, rises && falls);
            }
        }
        leave_slip(w, high, side, rises && falls);
    }
}

/* Straight path from rest to the root; returns 1 if it pressed down new contact in sticking. */
static int start_walk(Walk *w, double root)
{
    double p = place_at(&w->place, root, NULL);
    double d = place_at(&w->step, root, NULL);
    w->depth = 0;
    w->root_place = p;
    w->root_step = d;
    make_waves(root, w->place.H, w->root_phi);
    if (d < 0.0 && fabs(p) < -d * (1.0 - 1e-15)) {
        push_band(w, PRESS_BAND, 0.0, 0.0, 0.0, 0.0);
        w->value = recall(w, w->bands, 1.0, w->slope, w->waves);
        return 1;
    }
    leave_slip(w, root, p < 0.0 ? -1.0 : 1.0, 0);
    return 0;
}

/* Add the times at which the separation passes a kink of the law. */
static int mark_crossings(Walk *w, const double *grid, int points, double *times, int count)
{
    Motion *m = &w->step;
    if (!w->p->edges) return count;
    find_turns(m, grid, points);
    for (int i = 0; i < m->turns; i++) {
        double begin = m->times[i], end = i + 1 < m->turns ? m->times[i + 1] : m->times[0] + TURN;
        double from = m->x[i], to = m->x[(i + 1) % m->turns];
        const double *breaks;
        Py_ssize_t n = breaks_between(w->p, w->rest + fmin(from, to), w->rest + fmax(from, to),
                                      &breaks);
        for (Py_ssize_t k = 0; k < n; k++) {
            double near = begin + (end - begin) * (breaks[k] - w->rest - from) / (to - from);
            double t = find_time(m, 0, breaks[k] - w->rest, to > from, begin, end, near);
            times[count++] = fmod(t, TURN);
        }
    }
    return count;
}

/* Coefficients of force and load with their derivatives; NaN for nodes at rest. */
static void settle_varying(Walk *w, const double *grid, int points, double tolerance, double *times,
                           double *force, double *J, double *load, double *K, double *errors)
{
    int n = w->n, count = 0, root = 0;
    Motion *turning[2] = {&w->up, &w->down};
    double most = -HUGE_VAL, least = HUGE_VAL, far = 0.0, root_place = 0.0, stiff, heavy;
    for (int s = 0; s < 2; s++) {
        find_turns(turning[s], grid, points);
        for (int i = 0; i < turning[s]->turns; i++) times[count++] = turning[s]->times[i];
    }
    errors[0] = errors[1] = 0.0;
    if (!count) {
        force[0] = NAN;
        return;
    }
    for (int i = 0; i < count; i++) {
        double p = place_at(&w->place, times[i], NULL);
        double d = place_at(&w->step, times[i], NULL);
        times[i] = fmod(times[i], TURN);
        least = fmin(least, d);
        far = fmax(far, fabs(p));
        /* If two extremes agree within rounding, the cycle begins at the positive one. */
        double reach = d + fabs(p), near = 1e-13 * (fabs(d) + fabs(p));
        if (reach > most + near || (reach > most - near && p > root_place)) {
            root = i;
            root_place = p;
        }
        most = fmax(most, reach);
    }
    double first = times[root];
    count = mark_crossings(w, grid, points, times, count);
    for (int i = 0; i < count; i++)
        if (times[i] < first) times[i] += TURN;
    for (int k = 1; k < count; k++) {
        double t = times[k];
        int j = k;
        for (; j > 0 && times[j - 1] > t; j--) times[j] = times[j - 1];
        times[j] = t;
    }
    int kept = 1;
    for (int k = 1; k < count; k++)
        if (times[k] - times[kept - 1] > 1e-14 && times[k] < first + TURN - 1e-14)
            times[kept++] = times[k];
    count = kept;
    heavy = load_at(w->p, w->rest + least, &stiff);
    /* The rule of 21 places is exact to the power 3/2 of 10 times what the two differ by. */
    far = fmax(far, 1e-6 * (most - least)); /* below this, forces are differences of much larger
                                             * ones */
    most = fmax(fmin(heavy, stiff * far), 1e-16 * load_at(w->p, w->p->anchor, &far));
    stiff = fmax(stiff, 1e-16 * far); /* smaller steps are only approximate */
    w->slope_miss = 0.1 * cbrt(1e4 * tolerance * tolerance) * stiff;
    /* Where the load changes most, the force may be far smaller than the motion suggests. */
    for (int round = 0; round < 2; round++) {
        w->most = most;
        w->force_miss = 0.1 * cbrt(tolerance * tolerance / (4.0 * MARGIN * MARGIN)) * most;
        w->peak = 0.0;
        w->squares = 0.0;
        memset(w->sums, 0, (size_t)w->all * sizeof(double));
        if (start_walk(w, first)) go_around(w, times, count, 0);
        go_around(w, times, count, 1);
        if (!(w->peak < 0.25 * most)) break;
        most = fmax(w->peak, LEAST_PEAK * heavy);
    }
    const double *sums = w->sums, *slopes = sums + n, *loads = slopes + 2 * n * n;
    const double *falls = loads + n;
    errors[0] = 0.75 * MARGIN * w->most * sqrt(w->squares) + 64.0 * DBL_EPSILON * heavy;
    /* Rounding alone is within the default tolerance. */
    errors[1] = fmax(w->peak, 2.0 * LEAST_PEAK * heavy);
    for (int i = 0; i < n; i++) {
        double factor = i ? 2.0 / TURN : 1.0 / TURN;
        force[i] = factor * sums[i];
        load[i] = factor * loads[i];
        for (int j = 0; j < 2 * n; j++) J[2 * n * i + j] = factor * slopes[2 * n * i + j];
        for (int j = 0; j < n; j++) K[n * i + j] = -factor * product(falls, i, j);
    }
}

static int run_varying_harmonics(const Argument *a, Result *out)
{
    Py_ssize_t rows = a[2].n, size = a[3].n;
    int H = (int)(size / 2), points = 16 * H + 16;
    if (rows < 0 || size < 1 || size % 2 == 0 || size > 2001 || !all_have(a, 0, 1, rows * size) ||
        a[5].n < rows * size || a[6].n < 2 * rows * size * size || a[7].n < rows * size ||
        a[8].n < rows * size * size || a[9].n < 2 * rows || a[10].n < rows)
        return TOO_SHORT;
    size_t n = (size_t)size, turns = 4 * (size_t)H + 8, wide = 4 * (size_t)H + 1;
    size_t all = 2 * n * n + 3 * n + 3 * wide, room = SERIES * (2 * n + 1);
    size_t band = 3 * n + (SERIES + 1) * (2 * n + 1), kinks = (size_t)a[11].curve->break_count;
    size_t most_bands = MOST_BANDS + 2 * kinks, crossings = turns * kinks;
    size_t most_marks = 2 * most_bands + 2 * kinks + 4;
    size_t doubles = (size_t)points * n + 4 * (2 * n + wide + 2 * turns) + 2 * turns + 9 * n +
                     most_bands * band + wide + 2 * all + room + (SERIES + 3) * (2 * n + 1) +
                     crossings + most_marks;
    double *memory = calloc(doubles, sizeof(double)), *at = memory;
    Walk *w = malloc(sizeof(Walk));
    Band *bands = malloc(most_bands * sizeof(Band));
    if (!memory || !w || !bands) {
        free(memory);
        free(w);
        free(bands);
        return NO_MEMORY;
    }
    double *grid = at;
    at += (size_t)points * n;
    memset(w, 0, sizeof(Walk));
    w->bands = bands;
    w->most_bands = (int)most_bands;
    Motion *motions[4] = {&w->place, &w->step, &w->up, &w->down};
    double *own[4];
    for (int k = 0; k < 4; k++) {
        *motions[k] = (Motion){.H = H, .size = (int)size};
        motions[k]->c = own[k] = at;
        motions[k]->waves = at += 2 * n;
        motions[k]->times = at += wide;
        motions[k]->x = at += turns;
        at += turns;
    }
    double *times = at;
    w->marks = at += 2 * turns + crossings;
    w->root_phi = at += most_marks;
    at += n;
    for (size_t k = 0; k < most_bands; k++) {
        w->bands[k].ahead = at;
        w->bands[k].phi = at + 2 * n;
        w->bands[k].series = at + 3 * n;
        at += band;
    }
    w->slope = at;
    w->ahead = at += 2 * n;
    w->waves = at += 2 * n;
    w->early_waves = at += wide;
    w->nothing = at += n;
    w->sums = at += 2 * n;
    w->w = at += all;
    w->row = at += all + room;
    w->rates = at + 2 * n + 1;
    w->p = a[11].curve;
    w->n = (int)size;
    w->all = (int)all;
    w->scale = fmax(H, 1) * log(a[4].x) / log(1e-10);
    for (int r = 0; r < RULES; r++) {
        crowd_rule(make_rule(r, w->rules[r]), w->rules[r]);
    }
    for (int k = 0; k < SERIES; k++) {
        w->places[k] = cos(0.25 * TURN * (2 * k + 1) / SERIES);
        for (int i = 0; i < SERIES; i++)
            w->to_series[k][i] =
                (k ? 2.0 : 1.0) / SERIES * cos(0.25 * TURN * k * (2 * i + 1) / SERIES);
    }
    make_speeds(&w->place, grid, points);
    for (Py_ssize_t i = 0; i < rows; i++) {
        for (Py_ssize_t k = 0; k < size; k++) {
            double p = a[0].reals[i * size + k], d = a[1].reals[i * size + k];
            own[0][k] = p;
            own[1][k] = d;
            own[2][k] = d + p;
            own[3][k] = d - p;
        }
        w->rest = a[10].reals[i];
        settle_varying(w, grid, points, a[4].x, times, a[5].reals + i * size,
                       a[6].reals + 2 * i * size * size, a[7].reals + i * size,
                       a[8].reals + i * size * size, a[9].reals + 2 * i);
    }
    out[0].n = w->failed;
    free(memory);
    free(w);
    free(bands);
    return FINE;
}
