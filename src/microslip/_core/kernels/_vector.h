/* Sliders in two directions: states and settled cycles of many nodes. Part of _compiled.c. */

/* slide() at a held radius, from within it, in x and y: the end, and its derivatives by the step and
 * with `all` by what was held, in the columns of press(). */
static inline void slide_held(const double *from, const double *e, double length, double radius,
                              double *to, double map[2][6], int all)
{
    double a = from[0] * e[0] + from[1] * e[1], b = from[1] * e[0] - from[0] * e[1];
    double inverse = 1.0 / radius;
    double begin = sqrt(a * a - fmin(a * a + b * b - radius * radius, 0.0)), way = begin - a;
    if (a < 0.0 && way > length) way = length; /* on the circle within rounding */
    double c = begin * inverse, s = b * inverse, far = (length - way) * inverse;
    double fade = far < 40.0 ? exp(-far) : 0.0, behind = (1.0 - c) * fade * fade;
    double part = 1.0 / (1.0 + c + behind), share = 2.0 * fade * part;
    double cosine = (1.0 + c - behind) * part, sine = s * share;
    to[0] = radius * (cosine * e[0] - sine * e[1]);
    to[1] = radius * (cosine * e[1] + sine * e[0]);
    if (!map) return;
    double turned = ((1.0 - fade) * (1.0 - fade) + c * (1.0 - fade * fade)) * part;
    turned = (turned + way * inverse * share * c) * radius / length;
    /* Derivatives of the end (along, across) by the length and by the rotation of the step. */
    double al = sine * sine, cl = -cosine * sine, an = -turned * sine, cn = turned * cosine;
    map[0][2] = al * e[0] * e[0] - (cl + an) * e[0] * e[1] + cn * e[1] * e[1];
    map[0][3] = al * e[0] * e[1] - cl * e[1] * e[1] + an * e[0] * e[0] - cn * e[0] * e[1];
    map[1][2] = al * e[0] * e[1] + cl * e[0] * e[0] - an * e[1] * e[1] - cn * e[0] * e[1];
    map[1][3] = al * e[1] * e[1] + (cl + an) * e[0] * e[1] + cn * e[0] * e[0];
    if (!all) return;
    /* The force along the step acts like the step, the force across it through the start of
     * slip. */
    double across = begin > 0.0 ? (share - sine * s) * radius / begin : 0.0;
    double end[2] = {-across * (sine * e[0] + cosine * e[1]),
                     across * (cosine * e[0] - sine * e[1])};
    double ahead[2] = {al * e[0] - cl * e[1], al * e[1] + cl * e[0]};
    for (int r = 0; r < 2; r++) {
        map[r][0] = ahead[r] * e[0] - end[r] * e[1];
        map[r][1] = ahead[r] * e[1] + end[r] * e[0];
    }
}

enum { LAY_PIECES = 8 };

/* The same under a lay: what slips moves along g, but the step of the place is that of the motion
 * times a stiffness that differs along two axes. `lay` has both compliances C, and the cosine and
 * sine of the first axis. A piece of a step ends where C g = C (g before + its step) - l g with l
 * above zero and g at its radius: exact where g does not turn, else to 0.015 of the radius at worst
 * (compliances 1 and 1.4, any step). What is lost, if asked for, is the slip times g. */
static void move_lay(const double *from, const double *step, double first, double last,
                     const double *lay, double *to, double map[2][6], double *loss)
{
    const double *c = lay, e = lay[2], n = lay[3];
    if (map) memset(map, 0, 2 * sizeof(map[0]));
    to[0] = to[1] = 0.0;
    double left = 1.0, held = first > 0.0, rise = last - first;
    if (!(last > 0.0)) {
        if (!(held && loss)) return;
        left = first / -rise; /* to the loss of contact */
        last = 1e-6 * first;
    } else if (!held)
        left = last / rise; /* from the start of contact */
    double turned[2] = {e * step[0] + n * step[1], e * step[1] - n * step[0]};
    double g[2] = {held * (e * from[0] + n * from[1]), held * (e * from[1] - n * from[0])};
    double by[2][6] = {{held * e, held * n}, {-held * n, held * e}}, size = left / LAY_PIECES;
    double more[2][6] = {{0.0, 0.0, size * e, size * n}, {0.0, 0.0, -size * n, size * e}};
    for (int i = 0; i < 2 && !held; i++) {
        more[i][4] = turned[i] * last / (rise * rise) / LAY_PIECES;
        more[i][5] = -turned[i] * first / (rise * rise) / LAY_PIECES;
    }
    double before = held ? first : 0.0;
    for (int k = 1; k <= LAY_PIECES; k++) {
        double share = (double)k / LAY_PIECES, radius = (held ? first * (1.0 - share) : 0.0);
        radius += last * share;
        double dr[6] = {0.0, 0.0, 0.0, 0.0, held * (1.0 - share), share};
        double a[2] = {g[0] + size * turned[0], g[1] + size * turned[1]}, reach = hypot(a[0], a[1]);
        for (int i = 0; i < 2; i++) {
            g[i] = a[i];
            for (int m = 0; map && m < 6; m++) by[i][m] += more[i][m];
        }
        if (reach > radius) {
            double l = 0.0, now = reach, grip = 0.0;
            for (int turn = 0; turn < 40; turn++) { /* 1/size is nearly linear in l */
                grip = g[0] * g[0] / (c[0] + l) + g[1] * g[1] / (c[1] + l);
                double move = now * now * (now / radius - 1.0) / grip;
                l += move;
                for (int i = 0; i < 2; i++) g[i] = c[i] * a[i] / (c[i] + l);
                now = hypot(g[0], g[1]);
                if (fabs(move) <= 1e-15 * (l + c[0])) break;
            }
            for (int i = 0; i < 2; i++) g[i] *= radius / now;
            grip = g[0] * g[0] / (c[0] + l) + g[1] * g[1] / (c[1] + l);
            for (int m = 0; map && m < 6; m++) {
                double b[2] = {c[0] * by[0][m] / (c[0] + l), c[1] * by[1][m] / (c[1] + l)};
                double dl = (g[0] * b[0] + g[1] * b[1] - radius * dr[m]) / grip;
                for (int i = 0; i < 2; i++) by[i][m] = b[i] - g[i] * dl / (c[i] + l);
            }
            if (loss) *loss += 0.5 * l * radius * (radius + fmin(before, reach));
        }
        before = radius;
    }
    to[0] = e * g[0] - n * g[1];
    to[1] = n * g[0] + e * g[1];
    for (int m = 0; map && m < 6; m++) {
        map[0][m] = e * by[0][m] - n * by[1][m];
        map[1][m] = n * by[0][m] + e * by[1][m];
    }
}

/* Trials of nodes that share the sliders. Places are (nodes, 2), vectors before and after
 * (nodes, sliders, 2), tangents (nodes, 2, 3) by both components of the place and by the
 * separation. */
static int run_vector_try(const Argument *a, Result *out)
{
    enum { PLACE, STEP, LAST_PLACE, LAST_STEP, HELD, TOPS, WEIGHTS, LAY, NEW, VALUE, TANGENT };
    Py_ssize_t nodes = a[LAST_STEP].n, sliders = a[TOPS].n;
    const int held = !a[STEP].reals;
    const double *x = a[PLACE].reals, *x0 = a[LAST_PLACE].reals, *d0 = a[LAST_STEP].reals,
                 *d = held ? d0 : a[STEP].reals, *tops = a[TOPS].reals, *weights = a[WEIGHTS].reals,
                 *lay = a[LAY].reals;
    if (a[PLACE].n < 2 * nodes || a[LAST_PLACE].n < 2 * nodes || (!held && a[STEP].n < nodes) ||
        a[WEIGHTS].n < sliders || a[HELD].n < 2 * nodes * sliders || a[NEW].n < 2 * nodes * sliders ||
        (lay && a[LAY].n < 4) || a[VALUE].n < 2 * nodes || a[TANGENT].n < 6 * nodes)
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        const double *from = a[HELD].reals + 2 * sliders * i;
        double *to = a[NEW].reals + 2 * sliders * i;
        double step[2] = {x[2 * i] - x0[2 * i], x[2 * i + 1] - x0[2 * i + 1]};
        double length = hypot(step[0], step[1]), sum[2] = {0}, slope[2][3] = {{0}}, stuck = 0.0;
        double e[2] = {step[0] / length, step[1] / length}; /* not used where it is 0 */
        for (Py_ssize_t k = 0; k < sliders; k++, from += 2, to += 2) {
            double w = weights[k], last = tops[k] - d[i], map[2][6];
            if (held && last > 0.0) { /* most sliders: sticking sliders follow the step */
                double u = from[0] + step[0], v = from[1] + step[1];
                if (u * u + v * v <= last * last) {
                    to[0] = u;
                    to[1] = v;
                    sum[0] += w * u;
                    sum[1] += w * v;
                    stuck += w;
                    continue;
                }
                if (length > 0.0 && !lay) {
                    slide_held(from, e, length, last, to, map, 0);
                    for (int r = 0; r < 2; r++) {
                        sum[r] += w * to[r];
                        slope[r][0] += w * map[r][2];
                        slope[r][1] += w * map[r][3];
                    }
                    continue;
                }
            }
            if (lay) move_lay(from, step, tops[k] - d0[i], last, lay, to, map, NULL);
            else move_slider(from, step, length, tops[k] - d0[i], last, to, map);
            for (int r = 0; r < 2; r++) {
                sum[r] += w * to[r];
                slope[r][0] += w * map[r][2];
                slope[r][1] += w * map[r][3];
                slope[r][2] -= w * map[r][5];
            }
        }
        slope[0][0] += stuck;
        slope[1][1] += stuck;
        memcpy(a[VALUE].reals + 2 * i, sum, sizeof(sum));
        memcpy(a[TANGENT].reals + 6 * i, slope, sizeof(slope));
    }
    return FINE;
}

/* A step of the place, its direction and length, and the separations before and after it. */
typedef struct {
    double step[2], along[2], length, before, after;
} Stride;

static Stride make_stride(const double *from, double before, const double *to, double after)
{
    Stride s = {{to[0] - from[0], to[1] - from[1]}, {0.0, 0.0}, 0.0, before, after};
    s.length = hypot(s.step[0], s.step[1]);
    for (int r = 0; r < 2 && s.length > 0.0; r++) s.along[r] = s.step[r] / s.length;
    return s;
}

/* Cycle of a node: places (samples, 2) and separations, with their derivatives along directions. */
typedef struct {
    const double *x, *d, *u, *v, *lay;
    Stride *strides;              /* from rest to the root, and on from there: 1 .. samples */
    Py_ssize_t samples, places, steps, columns, root;
    double *begin;                /* scratch, 2 x columns */
    double *trace;                /* of a settled slider, see trace_slider */
    char *stuck;
    double *runs, *held, *shares; /* increments of slopes, values and weights at the start and
                                   * end of sticking */
} Round;

static inline Py_ssize_t sample_of(const Round *c, Py_ssize_t k)
{
    return c->root + k < c->samples ? c->root + k : c->root + k - c->samples;
}

/* Step of a slider; returns 1 if it stuck. `map` as in press(), or NULL. */
static inline int step_slider(const Round *c, const Stride *stride, double top, double *g,
                              double map[2][6])
{
    double first = top - stride->before, last = top - stride->after, to[2];
    if (first > 0.0 && last > 0.0) {
        double u = g[0] + stride->step[0], v = g[1] + stride->step[1];
        if (u * u + v * v <= last * last) {
            g[0] = u;
            g[1] = v;
            return 1;
        }
    }
    if (c->lay)
        move_lay(g, stride->step, first, last, c->lay, to, map, NULL);
    else if (first == last && last > 0.0 && stride->length > 0.0 && !(map && c->steps))
        slide_held(g, stride->along, stride->length, last, to, map, 1);
    else
        move_slider(g, stride->step, stride->length, first, last, to, map);
    g[0] = to[0];
    g[1] = to[1];
    return 0;
}

/* Takes N and B, of a start, over a step that did not stick; `before` is -1 at the start from rest. */
static void take_map(const Round *c, Py_ssize_t t, Py_ssize_t before, double map[2][6], double *N,
                     double *B)
{
    double n[4] = {N[0], N[1], N[2], N[3]};
    for (int r = 0; r < 2; r++)
        for (int k = 0; k < 2; k++) N[2 * r + k] = map[r][0] * n[k] + map[r][1] * n[2 + k];
    const double *now = c->u + t * c->places;
    const double *past = before < 0 ? NULL : c->u + before * c->places;
    for (Py_ssize_t k = 0; k < c->columns; k++) {
        double x = B[k], y = B[c->columns + k];
        B[k] = map[0][0] * x + map[0][1] * y;
        B[c->columns + k] = map[1][0] * x + map[1][1] * y;
    }
    for (Py_ssize_t k = 0; k < c->places; k++) {
        double du = now[k] - (past ? past[k] : 0.0);
        for (int r = 0; r < 2; r++) {
            B[r * c->columns + k] += map[r][2] * du;
            B[r * c->columns + c->places + k] += map[r][3] * du;
        }
    }
    for (Py_ssize_t k = 0; k < c->steps; k++) {
        double last = before < 0 ? 0.0 : c->v[before * c->steps + k], here = c->v[t * c->steps + k];
        for (int r = 0; r < 2; r++)
            B[r * c->columns + 2 * c->places + k] -= map[r][4] * last + map[r][5] * here;
    }
}

/* B of what stuck from one sample to another, -1 being rest: it just moves along. */
static void move_along(const Round *c, Py_ssize_t from, Py_ssize_t to, double *B)
{
    if (to < 0) return;
    for (Py_ssize_t k = 0; k < c->places; k++) {
        double du = c->u[to * c->places + k] - (from < 0 ? 0.0 : c->u[from * c->places + k]);
        B[k] += du;
        B[c->columns + c->places + k] += du;
    }
}

/* Steps 1 .. samples of a slider from a state at the root, the last back to it: whether each sticks,
 * where it ends and its map. */
static void trace_slider(const Round *c, double top, const double *root)
{
    double g[2] = {root[0], root[1]};
    for (Py_ssize_t k = 1; k <= c->samples; k++) {
        double *to = c->trace + 14 * k;
        c->stuck[k] = (char)step_slider(c, c->strides + k, top, g, (double(*)[6])(to + 2));
        to[0] = g[0];
        to[1] = g[1];
    }
}

static inline double (*map_of(const Round *c, Py_ssize_t k))[6]
{
    return (double(*)[6])(c->trace + 14 * k + 2);
}

/* By Newton's method the state at the root that a cycle brings back, from g on, with its trace;
 * the times around, or 0. A cycle that brings two states no further apart has one such state alone
 * where its derivative N has no eigenvalue of 1: what is found there is where passes tend to. */
static Py_ssize_t solve_slider(const Round *c, double top, double small, double *g, double *left)
{
    for (Py_ssize_t turn = 1; turn <= 12; turn++) {
        double N[4] = {1.0, 0.0, 0.0, 1.0}, *end = c->trace + 14 * c->samples;
        trace_slider(c, top, g);
        for (Py_ssize_t k = 1; k <= c->samples; k++) {
            if (c->stuck[k]) continue;
            double(*map)[6] = map_of(c, k), n[4] = {N[0], N[1], N[2], N[3]};
            for (int r = 0; r < 2; r++)
                for (int m = 0; m < 2; m++) N[2 * r + m] = map[r][0] * n[m] + map[r][1] * n[2 + m];
        }
        double a = 1.0 - N[0], b = -N[1], p = -N[2], q = 1.0 - N[3], det = a * q - b * p;
        double x = end[0] - g[0], y = end[1] - g[1];
        if (!(det > 1e-8)) return 0;
        double dx = (q * x - b * y) / det, dy = (a * y - p * x) / det;
        *left = hypot(dx, dy);
        if (*left <= small) return turn;
        g[0] = end[0] + N[0] * dx + N[1] * dy;
        g[1] = end[1] + N[2] * dx + N[3] * dy;
        double radius = top - c->d[c->root], size = hypot(g[0], g[1]);
        for (int r = 0; r < 2 && size > radius; r++) g[r] *= fmax(radius, 0.0) / size;
    }
    return 0;
}

/* Passes of a slider until its state at the root, which is left in g with its trace, changes by so
 * little that it is within `small` of where it tends to. Newton's method is tried after 1, 8, 64 ...
 * passes: from rest it may lead into a branch of the map without a fixed point. After `most` passes
 * the state is the last one; `left` is an estimate of its distance from the limit. */
static Py_ssize_t settle_slider(const Round *c, double top, double small, double rounding,
                                Py_ssize_t most, double *g, double *left)
{
    double root[2] = {0.0, 0.0}, change = 0.0;
    Py_ssize_t solve_at = 1;
    g[0] = g[1] = 0.0;
    *left = 0.0;
    step_slider(c, c->strides, top, g, NULL);
    for (Py_ssize_t pass = 1; pass < most; pass++) {
        root[0] = g[0];
        root[1] = g[1];
        for (Py_ssize_t k = 1; k <= c->samples; k++) step_slider(c, c->strides + k, top, g, NULL);
        double moved = hypot(g[0] - root[0], g[1] - root[1]);
        /* What is left of a change that shrinks as it did, or as the inverse cube of passes. */
        double ratio = moved / change;
        int there = pass > 1 && ratio < 1.0 && 2.0 * moved * ratio <= small * (1.0 - ratio);
        *left = ratio < 1.0 ? 2.0 * moved * ratio / (1.0 - ratio) : HUGE_VAL;
        change = moved;
        if (moved <= rounding || there) {
            if (!there) *left = moved;
            trace_slider(c, top, g);
            return pass + 1;
        }
        if (pass == solve_at) {
            double solved[2] = {g[0], g[1]};
            double step = 0.0;
            Py_ssize_t turns = solve_slider(c, top, small, solved, &step);
            solve_at *= 8;
            if (turns) {
                memcpy(g, solved, sizeof(solved));
                *left = step;
                return pass + 1 + turns;
            }
        }
    }
    trace_slider(c, top, g);
    *left = fmin(*left, 2.0 * fmax(top - c->d[c->root], 0.0));
    return most;
}

/* Derivatives of a slider's state at the root: what its cycle leaves, or, where it does not slip in
 * it, what the passes before left. */
static void derive_start(const Round *c, double top, Py_ssize_t passes, double *start)
{
    double N[4] = {1.0, 0.0, 0.0, 1.0}, *B = c->begin;
    size_t bytes = 2 * (size_t)c->columns * sizeof(double);
    Py_ssize_t last = c->root, from = c->root; /* before this step, and of B */
    memset(B, 0, bytes);
    for (Py_ssize_t k = 1; k <= c->samples; k++) {
        Py_ssize_t t = k < c->samples ? sample_of(c, k) : c->root;
        if (!c->stuck[k]) {
            move_along(c, from, last, B);
            take_map(c, t, last, map_of(c, k), N, B);
            from = t;
        }
        last = t;
    }
    move_along(c, from, c->root, B);
    double a = 1.0 - N[0], b = -N[1], p = -N[2], q = 1.0 - N[3], det = a * q - b * p;
    if (det > 1e-12) {
        for (Py_ssize_t k = 0; k < c->columns; k++) {
            double x = B[k], y = B[c->columns + k];
            start[k] = (q * x - b * y) / det;
            start[c->columns + k] = (a * y - p * x) / det;
        }
        return;
    }
    double g[2] = {0.0, 0.0}, map[2][6];
    memset(B, 0, bytes);
    last = from = -1;
    for (Py_ssize_t k = 0; k <= (passes - 1) * c->samples; k++) {
        Py_ssize_t t = sample_of(c, k % c->samples), stride = k ? (k - 1) % c->samples + 1 : 0;
        if (!step_slider(c, c->strides + stride, top, g, map)) {
            move_along(c, from, last, B);
            take_map(c, t, last, map, N, B);
            from = t;
        }
        last = t;
    }
    move_along(c, from, last, B);
    memcpy(start, B, bytes);
}

/* Adds a settled slider to the sums. What sticks from sample t on is w (g_t - x_t) and w x, which is
 * added where it begins and taken off where it ends. */
static void add_slider(const Round *c, double w, const double *settled, double *B)
{
    double N[4];
    Py_ssize_t width = 2 * c->columns;
    double *row = c->begin;
    for (Py_ssize_t k = 0; k < c->samples;) {
        Py_ssize_t from = sample_of(c, k), end = k + 1;
        const double *first = k ? c->trace + 14 * k : settled;
        while (end < c->samples && c->stuck[end]) end++;
        Py_ssize_t here = sample_of(c, end - 1);
        /* from k to end - 1 it moves along */
        double *begun = c->held + 2 * k, *ended = c->held + 2 * end;
        for (int r = 0; r < 2; r++) {
            double value = w * (first[r] - c->x[2 * from + r]);
            begun[r] += value;
            ended[r] -= value;
        }
        c->shares[k] += w;
        c->shares[end] -= w;
        if (width) {
            const double *u = c->u + from * c->places;
            double *start = c->runs + k * width, *stop = c->runs + end * width;
            memcpy(row, B, (size_t)width * sizeof(double));
            for (Py_ssize_t m = 0; m < c->places; m++) {
                row[m] -= u[m];
                row[c->columns + c->places + m] -= u[m];
            }
            for (Py_ssize_t m = 0; m < width; m++) {
                start[m] += w * row[m];
                stop[m] -= w * row[m];
            }
            if (end < c->samples) {
                Py_ssize_t t = sample_of(c, end);
                memset(N, 0, sizeof(N)); /* not used */
                move_along(c, from, here, B);
                take_map(c, t, here, map_of(c, end), N, B);
            }
        }
        k = end;
    }
}

/* Settled cycles of nodes that share the sliders, with derivatives along directions: (nodes,
 * samples, 2, 2 places + steps) by those of each part of the place and of the separation. A cycle
 * begins where step + |place| is largest, or with FIRST at its first sample, with a straight path
 * from rest; each slider is taken around
 * until it has settled, all together to `small`, or `most` times; `left` is how far the sum of all
 * sliders is estimated to be from its limit. */
static int run_vector_cycle(const Argument *a, Result *out)
{
    enum { PLACE, STEP, REST, SAMPLES, TOPS, WEIGHTS, LAY, BY_PLACE, PLACES, BY_STEP, STEPS, MOST,
           FIRST, SMALL, VALUE, SLOPES, PASSES, LEFT };
    Py_ssize_t samples = a[SAMPLES].n, places = a[PLACES].n, steps = a[STEPS].n, most = a[MOST].n;
    Py_ssize_t sliders = a[TOPS].n, nodes = a[PASSES].n, n = nodes * samples;
    Py_ssize_t columns = 2 * places + steps, width = 2 * columns;
    if (samples < 1 || places < 0 || steps < 0 || a[PLACE].n < 2 * n || a[STEP].n < n ||
        a[REST].n < nodes || a[WEIGHTS].n < sliders || a[BY_PLACE].n < samples * places ||
        a[BY_STEP].n < samples * steps || (a[LAY].reals && a[LAY].n < 4) ||
        a[VALUE].n < 2 * n || a[SLOPES].n < n * width || a[LEFT].n < nodes)
        return TOO_SHORT;
    size_t sums = (size_t)((samples + 1) * (width + 3));
    size_t doubles = sums + 2 * (size_t)width + 14 * ((size_t)samples + 1);
    size_t bytes = doubles * sizeof(double) + ((size_t)samples + 1) * sizeof(Stride);
    double *memory = malloc(bytes + (size_t)samples + 1);
    if (!memory) return NO_MEMORY;
    const double *tops = a[TOPS].reals, *weights = a[WEIGHTS].reals, rested[2] = {0.0, 0.0};
    double *start = memory + sums, whole = 0.0;
    for (Py_ssize_t j = 0; j < sliders; j++) whole += weights[j];
    Round c = {.u = a[BY_PLACE].reals, .v = a[BY_STEP].reals, .lay = a[LAY].reals,
               .strides = (Stride *)(memory + doubles), .samples = samples, .places = places,
               .steps = steps, .columns = columns, .runs = memory, .begin = start + width,
               .trace = start + 2 * width, .stuck = (char *)memory + bytes,
               .held = memory + (samples + 1) * width,
               .shares = memory + (samples + 1) * (width + 2)};
    for (Py_ssize_t i = 0; i < nodes; i++) {
        double reach = -HUGE_VAL, nearest = HUGE_VAL, *shares = c.shares, total = 0.0, size = 0.0;
        double distance = 0.0;
        Py_ssize_t longest = 1;
        c.x = a[PLACE].reals + 2 * samples * i;
        c.d = a[STEP].reals + samples * i;
        for (Py_ssize_t t = 0; t < samples; t++) {
            double far = c.d[t] + hypot(c.x[2 * t], c.x[2 * t + 1]);
            nearest = fmin(nearest, c.d[t]);
            size = fmax(size, 1e-15 * (fabs(c.d[t]) + far - c.d[t]));
            if (far > reach && !(a[FIRST].n && t)) {
                reach = far;
                c.root = t;
            }
        }
        Py_ssize_t last = c.root;
        c.strides[0] = make_stride(rested, a[REST].reals[i], c.x + 2 * last, c.d[last]);
        for (Py_ssize_t k = 1; k <= samples; k++) {
            Py_ssize_t t = k < samples ? sample_of(&c, k) : c.root;
            c.strides[k] = make_stride(c.x + 2 * last, c.d[last], c.x + 2 * t, c.d[t]);
            last = t;
        }
        memset(memory, 0, sums * sizeof(double));
        for (Py_ssize_t j = 0; j < sliders; j++) {
            double g[2], left;
            if (!(tops[j] > nearest)) continue; /* never in contact */
            Py_ssize_t passes = settle_slider(&c, tops[j], a[SMALL].x / whole,
                                              size + 1e-15 * fabs(tops[j]), most, g, &left);
            if (passes > longest) longest = passes;
            distance += weights[j] * left;
            if (columns) derive_start(&c, tops[j], passes, start);
            add_slider(&c, weights[j], g, start);
        }
        a[PASSES].integers[i] = longest;
        a[LEFT].reals[i] = distance;
        double held[2] = {0.0, 0.0}, *run = start;
        memset(run, 0, (size_t)width * sizeof(double));
        for (Py_ssize_t k = 0; k < samples; k++) {
            Py_ssize_t t = sample_of(&c, k);
            double *value = a[VALUE].reals + 2 * (samples * i + t);
            double *slopes = a[SLOPES].reals + width * (samples * i + t);
            total += shares[k];
            for (int r = 0; r < 2; r++) {
                held[r] += c.held[2 * k + r];
                value[r] = held[r] + total * c.x[2 * t + r];
            }
            for (Py_ssize_t m = 0; m < width; m++) {
                run[m] += c.runs[k * width + m];
                slopes[m] = run[m];
            }
            for (Py_ssize_t m = 0; m < places; m++) {
                slopes[m] += total * c.u[t * places + m];
                slopes[columns + places + m] += total * c.u[t * places + m];
            }
        }
    }
    free(memory);
    return FINE;
}

/* Energy dissipated by sliders in a step whose radii change from first to last, over stiffness. */
static int run_vector_losses(const Argument *a, Result *out)
{
    enum { HELD, STEP, FIRST, LAST, LAY, LOSS };
    const double *steps = a[STEP].reals, *first = a[FIRST].reals, *last = a[LAST].reals;
    const double *lay = a[LAY].reals;
    Py_ssize_t nodes = a[STEP].n / 2, sliders = nodes ? a[FIRST].n / nodes : 0, n = a[FIRST].n;
    if (n != nodes * sliders || a[HELD].n < 2 * n || a[LAST].n < n || (lay && a[LAY].n < 4) ||
        a[LOSS].n < n)
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        const double *step = steps + 2 * i;
        double length = hypot(step[0], step[1]);
        for (Py_ssize_t k = i * sliders; k < (i + 1) * sliders; k++) {
            const double *from = a[HELD].reals + 2 * k;
            double end[2], lost = 0.0;
            if (lay) move_lay(from, step, first[k], last[k], lay, end, NULL, &lost);
            else lost = vector_loss(from, step, length, first[k], last[k]);
            a[LOSS].reals[k] = lost;
        }
    }
    return FINE;
}
