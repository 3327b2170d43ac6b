/* Sliders in two directions. Part of _compiled.c.
 *
 * A slider holds a vector g, which follows every step of the place as long as its size stays within
 * a radius; where it would not, the slider slips along g. Radii go with the normal load: that of
 * slider k is tops[k] less the separation, none where that is negative, and changes evenly along a
 * step, which is a straight line. While g slips, with f its angle to the step and x the way made,
 *
 *     df = -sin f dx / r(x),    tan(f/2) = tan(f0/2) exp(-integral of dx/r):
 *
 * at a held load g runs along a tractrix, and however long the step this end is exact. The way to
 * where it begins to slip is the root of a quadratic.
 */

/* Derivatives of where a slider ends by a, b, length, first, last, as its frame has them. */
typedef struct {
    double along[5], across[5];
} Turn;

/* A slider at (a, b), a along the step, goes with a step of that length as far as its radius, which
 * goes from `first` to `last`, lets it. */
static void slide(double a, double b, double length, double first, double last, double *along,
                  double *across, Turn *turn)
{
    double rise = last - first;
    if (turn) memset(turn, 0, sizeof(Turn));
    *along = *across = 0.0;
    if (!(last > 0.0)) return;
    if (!(first > 0.0)) { /* contact begins on the way, with nothing held */
        if (length <= rise) {
            *along = length * last / rise;
            if (turn) {
                turn->along[2] = last / rise;
                turn->along[3] = length * last / (rise * rise);
                turn->along[4] = (length - *along) / rise;
            }
        } else {
            *along = last;
            if (turn) turn->along[4] = 1.0;
        }
        return;
    }
    if ((a + length) * (a + length) + b * b <= last * last) {
        *along = a + length;
        *across = b;
        if (turn) turn->along[0] = turn->along[2] = turn->across[1] = 1.0;
        return;
    }
    double square = length * length - rise * rise, half = a * length - first * rise;
    double inside = fmin(a * a + b * b - first * first, 0.0), time = 0.0;
    double root = sqrt(fmax(half * half - square * inside, 0.0));
    if (half >= 0.0) time = half + root > 0.0 ? -inside / (half + root) : 0.0;
    else if (square > 0.0) time = (root - half) / square;
    time = fmin(fmax(time, 0.0), 1.0);
    double begin = a + time * length, radius = first + time * rise, left = 1.0 - time;
    double z = (last - radius) / radius, mean = 1.0;
    if (fabs(z) < 1e-3) mean = 1.0 - z * (0.5 - z * (1.0 / 3.0 - z * (0.25 - z * 0.2)));
    else mean = log1p(z) / z;
    double way = length * left * mean / radius, fade = way < 700.0 ? exp(-way) : 0.0;
    double c = begin / radius, s = b / radius;
    double ahead = fmax(1.0 + c, 0.0), behind = fmax(1.0 - c, 0.0) * fade * fade;
    double whole = ahead + behind, share = 2.0 * fade / whole;
    if (!(whole > 0.0)) { /* straight against the step, where it turns neither way */
        *along = -last;
        if (turn) turn->along[4] = -1.0;
        return;
    }
    double cosine = (ahead - behind) / whole, sine = s * share;
    *along = last * cosine;
    *across = last * sine;
    if (!turn) return;
    double grip = begin * length - radius * rise;
    double bend = fabs(z) < 1e-3 ? -0.5 + z * (2.0 / 3.0 - z * (0.75 - z * 0.8))
                                 : (1.0 / (1.0 + z) - mean) / z;
    double by[5] = {begin, b, time * begin, -radius * left, -radius * time};
    for (int k = 0; k < 5; k++) {
        double dt = grip > 0.0 ? -by[k] / grip : 0.0;
        double dbegin = (k == 0) + length * dt + (k == 2) * time, dlast = k == 4;
        double dradius = (k == 3) * left + (k == 4) * time + rise * dt;
        double dangle = (begin * (k == 1) - b * dbegin) / (radius * radius);
        double dz = (dlast - (1.0 + z) * dradius) / radius;
        double dway = mean * ((k == 2) * left - length * dt) / radius - way * dradius / radius +
                      length * left * bend * dz / radius;
        double dend = share * dangle - sine * dway;
        turn->along[k] = dlast * cosine - last * sine * dend;
        turn->across[k] = dlast * sine + last * cosine * dend;
    }
}

/* The same where nothing moves along the surface: the radius alone may press a slider in. */
static void press(double x, double y, double first, double last, double *to, double map[2][6])
{
    /* Columns of `map`: by x, y before, by the step's x, y, by first and last. */
    if (map) memset(map, 0, 2 * sizeof(map[0]));
    to[0] = x;
    to[1] = y;
    double size = hypot(x, y);
    if (!(last > 0.0)) {
        to[0] = to[1] = 0.0;
        return;
    }
    if (!(first > 0.0)) {
        if (map) map[0][2] = map[1][3] = last / (last - first);
        return;
    }
    if (!(size > last * (1.0 + 1e-14))) { /* at its bound by rounding, it holds */
        if (map) map[0][0] = map[1][1] = map[0][2] = map[1][3] = 1.0;
        return;
    }
    double e[2] = {x / size, y / size}, radius = fmin(size, first), z = (last - radius) / radius;
    double mean = fabs(z) < 1e-3 ? 1.0 - z * (0.5 - z / 3.0) : log1p(z) / z;
    double left = first > last ? (radius - last) / (first - last) : 0.0;
    double turned = last * left * mean / radius;
    for (int i = 0; i < 2; i++) {
        to[i] = last * e[i];
        for (int k = 0; map && k < 2; k++) {
            double across = (i == k) - e[i] * e[k];
            map[i][k] = last / size * across;
            map[i][2 + k] = turned * across;
        }
        if (map) map[i][5] = e[i];
    }
}

/* A step (x, y) of one slider, and how its end depends on columns as of press(). */
static void move_slider(const double *from, const double *step, double length, double first,
                        double last, double *to, double map[2][6])
{
    if (!(length > 0.0)) {
        press(from[0], from[1], first, last, to, map);
        return;
    }
    double e[2] = {step[0] / length, step[1] / length}, n[2] = {-e[1], e[0]};
    double held = first > 0.0, a = held * (from[0] * e[0] + from[1] * e[1]);
    double b = held * (from[0] * n[0] + from[1] * n[1]), along, across;
    Turn turn;
    slide(a, b, length, first, last, &along, &across, map ? &turn : NULL);
    for (int i = 0; i < 2; i++) to[i] = along * e[i] + across * n[i];
    if (!map) return;
    double swing[2] = {turn.along[0] * b - turn.along[1] * a - across,
                       turn.across[0] * b - turn.across[1] * a + along};
    if (held && turn.across[1] == 1.0 && turn.along[0] == 1.0) { /* it sticks: exactly so */
        swing[0] = 0.0;
        swing[1] = length;
    }
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 2; k++) {
            map[i][k] = held * (e[i] * (turn.along[0] * e[k] + turn.along[1] * n[k]) +
                                n[i] * (turn.across[0] * e[k] + turn.across[1] * n[k]));
            map[i][2 + k] =
                e[i] * (turn.along[2] * e[k] + swing[0] * n[k] / length) +
                n[i] * (turn.across[2] * e[k] + swing[1] * n[k] / length);
        }
        map[i][4] = e[i] * turn.along[3] + n[i] * turn.across[3];
        map[i][5] = e[i] * turn.along[4] + n[i] * turn.across[4];
    }
}

/* slide() at a held radius, from within it: the end, and its derivatives by the step, in x and y. */
static inline void slide_held(const double *from, const double *e, double length, double radius,
                              double *to, double slope[2][2])
{
    double a = from[0] * e[0] + from[1] * e[1], b = from[1] * e[0] - from[0] * e[1];
    double inverse = 1.0 / radius;
    double begin = sqrt(a * a - fmin(a * a + b * b - radius * radius, 0.0)), way = begin - a;
    if (a < 0.0 && way > length) way = length; /* on the circle by rounding alone */
    double c = begin * inverse, s = b * inverse, far = (length - way) * inverse;
    double fade = far < 40.0 ? exp(-far) : 0.0, behind = (1.0 - c) * fade * fade;
    double part = 1.0 / (1.0 + c + behind), share = 2.0 * fade * part;
    double cosine = (1.0 + c - behind) * part, sine = s * share;
    double turned = ((1.0 - fade) * (1.0 - fade) + c * (1.0 - fade * fade)) * part;
    turned = (turned + way * inverse * share * c) * radius / length;
    to[0] = radius * (cosine * e[0] - sine * e[1]);
    to[1] = radius * (cosine * e[1] + sine * e[0]);
    /* Of the end (along, across) by the step's length, and by its swing. */
    double al = sine * sine, cl = -cosine * sine, an = -turned * sine, cn = turned * cosine;
    slope[0][0] = al * e[0] * e[0] - (cl + an) * e[0] * e[1] + cn * e[1] * e[1];
    slope[0][1] = al * e[0] * e[1] - cl * e[1] * e[1] + an * e[0] * e[0] - cn * e[0] * e[1];
    slope[1][0] = al * e[0] * e[1] + cl * e[0] * e[0] - an * e[1] * e[1] - cn * e[0] * e[1];
    slope[1][1] = al * e[1] * e[1] + (cl + an) * e[0] * e[1] + cn * e[0] * e[0];
}

/* Trials of nodes that share the sliders. Places are (nodes, 2), vectors held and new (nodes,
 * sliders, 2), tangents (nodes, 2, 3) by both parts of the place and by the separation. */
static int run_vector_try(const Argument *a, Result *out)
{
    enum { PLACE, STEP, LAST_PLACE, LAST_STEP, HELD, TOPS, WEIGHTS, NEW, VALUE, TANGENT };
    Py_ssize_t nodes = a[LAST_STEP].n, sliders = a[TOPS].n;
    const int held = !a[STEP].reals;
    const double *x = a[PLACE].reals, *x0 = a[LAST_PLACE].reals, *d0 = a[LAST_STEP].reals,
                 *d = held ? d0 : a[STEP].reals, *tops = a[TOPS].reals, *weights = a[WEIGHTS].reals;
    if (a[PLACE].n < 2 * nodes || a[LAST_PLACE].n < 2 * nodes || (!held && a[STEP].n < nodes) ||
        a[WEIGHTS].n < sliders || a[HELD].n < 2 * nodes * sliders || a[NEW].n < 2 * nodes * sliders ||
        a[VALUE].n < 2 * nodes || a[TANGENT].n < 6 * nodes)
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        const double *from = a[HELD].reals + 2 * sliders * i;
        double *to = a[NEW].reals + 2 * sliders * i;
        double step[2] = {x[2 * i] - x0[2 * i], x[2 * i + 1] - x0[2 * i + 1]};
        double length = hypot(step[0], step[1]), sum[2] = {0}, slope[2][3] = {{0}}, stuck = 0.0;
        double e[2] = {step[0] / length, step[1] / length}; /* not used where it is 0 */
        for (Py_ssize_t k = 0; k < sliders; k++, from += 2, to += 2) {
            double w = weights[k], last = tops[k] - d[i], map[2][6];
            if (held && last > 0.0) { /* most of them: what sticks just moves along */
                double u = from[0] + step[0], v = from[1] + step[1];
                if (u * u + v * v <= last * last) {
                    to[0] = u;
                    to[1] = v;
                    sum[0] += w * u;
                    sum[1] += w * v;
                    stuck += w;
                    continue;
                }
                if (length > 0.0) {
                    double turn[2][2];
                    slide_held(from, e, length, last, to, turn);
                    for (int r = 0; r < 2; r++) {
                        sum[r] += w * to[r];
                        slope[r][0] += w * turn[r][0];
                        slope[r][1] += w * turn[r][1];
                    }
                    continue;
                }
            }
            move_slider(from, step, length, tops[k] - d0[i], last, to, map);
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

/* Settled cycles of nodes that share the sliders, with derivatives along directions: (nodes,
 * samples, 2, 2 places + steps) by those of each part of the place and of the separation. A cycle
 * begins where step + |place| is largest, with a straight path from rest, and is passed until its
 * values change by no more than `small`, or `most` times: then `passes` is negative. */
static int run_vector_cycle(const Argument *a, Result *out)
{
    enum { PLACE, STEP, REST, SAMPLES, TOPS, WEIGHTS, BY_PLACE, PLACES, BY_STEP, STEPS, MOST, SMALL,
           VALUE, SLOPES, PASSES };
    Py_ssize_t samples = a[SAMPLES].n, places = a[PLACES].n, steps = a[STEPS].n, most = a[MOST].n;
    Py_ssize_t sliders = a[TOPS].n, nodes = a[PASSES].n, n = nodes * samples;
    Py_ssize_t columns = 2 * places + steps;
    double small = a[SMALL].x;
    if (samples < 1 || places < 0 || steps < 0 || a[PLACE].n < 2 * n || a[STEP].n < n ||
        a[REST].n < nodes || a[WEIGHTS].n < sliders || a[BY_PLACE].n < samples * places ||
        a[BY_STEP].n < samples * steps || a[VALUE].n < 2 * n || a[SLOPES].n < 2 * n * columns)
        return TOO_SHORT;
    size_t room = (size_t)(2 * sliders * (2 + columns) + 2 * columns + 1);
    double *memory = malloc(room * sizeof(double));
    if (!memory) return NO_MEMORY;
    const double *tops = a[TOPS].reals, *weights = a[WEIGHTS].reals, *u = a[BY_PLACE].reals,
                 *v = a[BY_STEP].reals;
    long long *passes = a[PASSES].integers;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        const double *x = a[PLACE].reals + 2 * samples * i;
        const double *d = a[STEP].reals + samples * i;
        double *value = a[VALUE].reals + 2 * samples * i;
        double *slopes = a[SLOPES].reals + 2 * samples * columns * i;
        double *g = memory, *before = g + 2 * sliders, *by = before + 2 * sliders;
        double *row = by + 2 * sliders * columns;
        for (size_t k = 0; k < room; k++) memory[k] = 0.0;
        Py_ssize_t root = 0;
        double reach = -HUGE_VAL;
        for (Py_ssize_t t = 0; t < samples; t++) {
            double far = d[t] + hypot(x[2 * t], x[2 * t + 1]);
            if (far > reach) {
                reach = far;
                root = t;
            }
        }
        double last_x[2] = {0.0, 0.0}, last_d = a[REST].reals[i];
        Py_ssize_t last_t = -1;
        Py_ssize_t pass = 0;
        for (; pass < most; pass++) {
            double change = 0.0;
            for (Py_ssize_t k = 0; k < samples; k++) {
                Py_ssize_t t = root + k < samples ? root + k : root + k - samples;
                double step[2] = {x[2 * t] - last_x[0], x[2 * t + 1] - last_x[1]};
                double length = hypot(step[0], step[1]), sum[2] = {0.0, 0.0};
                double *out = slopes + 2 * columns * t;
                for (Py_ssize_t c = 0; c < 2 * columns; c++) out[c] = 0.0;
                for (Py_ssize_t j = 0; j < sliders; j++) {
                    double map[2][6], to[2], w = weights[j], *own = by + 2 * columns * j;
                    move_slider(g + 2 * j, step, length, tops[j] - last_d, tops[j] - d[t], to,
                                columns ? map : NULL);
                    for (int r = 0; r < 2; r++) {
                        sum[r] += w * to[r];
                        g[2 * j + r] = to[r];
                    }
                    if (!columns) continue;
                    for (Py_ssize_t c = 0; c < columns; c++) {
                        double in[6] = {own[c], own[columns + c], 0.0, 0.0, 0.0, 0.0};
                        if (c < 2 * places) {
                            Py_ssize_t way = c / places, p = c - way * places;
                            in[2 + way] = u[t * places + p] -
                                          (last_t < 0 ? 0.0 : u[last_t * places + p]);
                        } else {
                            Py_ssize_t p = c - 2 * places;
                            in[4] = last_t < 0 ? 0.0 : -v[last_t * steps + p];
                            in[5] = -v[t * steps + p];
                        }
                        for (int r = 0; r < 2; r++) {
                            double total = 0.0;
                            for (int m = 0; m < 6; m++) total += map[r][m] * in[m];
                            row[r] = total;
                        }
                        own[c] = row[0];
                        own[columns + c] = row[1];
                        out[c] += w * row[0];
                        out[columns + c] += w * row[1];
                    }
                }
                change = fmax(change, fmax(fabs(sum[0] - value[2 * t]),
                                           fabs(sum[1] - value[2 * t + 1])));
                value[2 * t] = sum[0];
                value[2 * t + 1] = sum[1];
                last_x[0] = x[2 * t];
                last_x[1] = x[2 * t + 1];
                last_d = d[t];
                last_t = t;
            }
            if (pass && change <= small) break;
        }
        passes[i] = pass < most ? pass + 1 : -(long long)most;
    }
    free(memory);
    return FINE;
}

/* What sliders lose at held radii, over their stiffness: over the length x slip loses the integral
 * of r cos f dx, which is r^2 ln(sin f0 / sin f1). */
static int run_vector_losses(const Argument *a, Result *out)
{
    const double *steps = a[1].reals, *radii = a[2].reals;
    double *loss = a[3].reals;
    Py_ssize_t nodes = a[1].n / 2, sliders = nodes ? a[2].n / nodes : 0;
    if (a[2].n != nodes * sliders || a[0].n < 2 * a[2].n || a[3].n < a[2].n) return TOO_SHORT;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        const double *step = steps + 2 * i;
        double length = hypot(step[0], step[1]);
        for (Py_ssize_t k = i * sliders; k < (i + 1) * sliders; k++) {
            const double *g = a[0].reals + 2 * k;
            double r = radii[k];
            loss[k] = 0.0;
            if (!(r > 0.0 && length > 0.0)) continue;
            double x = (g[0] * step[0] + g[1] * step[1]) / length;
            double y = (g[1] * step[0] - g[0] * step[1]) / length;
            if (!((x + length) * (x + length) + y * y > r * r)) continue;
            double begin = sqrt(x * x - fmin(x * x + y * y - r * r, 0.0));
            double way = fmax((length - (begin - x)) / r, 0.0), c = begin / r;
            double fade = exp(-fmin(way, 700.0));
            /* ln((1 + c + (1 - c) fade^2)/2) without a loss of digits where the way is short */
            double closing = log1p(-0.5 * (1.0 - c) * (1.0 - fade) * (1.0 + fade));
            loss[k] = r * r * fmax(way + closing, 0.0);
        }
    }
    return FINE;
}
