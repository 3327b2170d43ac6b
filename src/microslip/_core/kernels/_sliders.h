/* Sliders in two directions. Part of _compiled.c, and of what is exported as C.
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

/* Derivatives of the end of a slider by a, b, length, first and last radius, in its frame. */
typedef struct {
    double along[5], across[5];
} Turn;

/* Move a slider at (a, b), a along the step, by a step of the given length within its radius,
 * which changes from `first` to `last`. */
static void slide(double a, double b, double length, double first, double last, double *along,
                  double *across, Turn *turn)
{
    double rise = last - first;
    if (turn) memset(turn, 0, sizeof(Turn));
    *along = *across = 0.0;
    if (!(last > 0.0)) return;
    if (!(first > 0.0)) { /* contact begins during the step, with zero force */
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
    if (!(whole > 0.0)) { /* exactly against the step: the direction is undetermined */
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

/* Like press() without tangential motion: only the decreasing radius moves the slider. */
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
    if (!(size > last * (1.0 + 1e-14))) { /* at its bound within rounding: sticks */
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

/* Step (x, y) of one slider, and the derivatives of its end as in press(). */
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
    if (held && turn.across[1] == 1.0 && turn.along[0] == 1.0) { /* sticking is exact */
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

/* What a step of one slider loses, over its stiffness: the work of what it holds along the step, less
 * what it stores in the end. While it slips that work is the integral of r cos f dx, in closed form
 * at a held radius, else by Gauss's rule over the integral of dx/r. */
static double vector_loss(const double *from, const double *step, double length, double first,
                          double last)
{
    static const double NODES[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                    0.9602898564975363};
    static const double WEIGHTS[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                      0.1012285362903763};
    double rise = last - first, end = fmax(last, 0.0);
    if (!(first > 0.0))
        return length > rise && rise > 0.0 ? 0.5 * end * end * (length / rise - 1.0) : 0.0;
    if (!(length > 0.0)) {
        double size = from[0] * from[0] + from[1] * from[1];
        return size > end * end ? 0.5 * (size - end * end) : 0.0;
    }
    double a = (from[0] * step[0] + from[1] * step[1]) / length;
    double b = (from[1] * step[0] - from[0] * step[1]) / length;
    if (last > 0.0 && (a + length) * (a + length) + b * b <= last * last) return 0.0;
    double square = length * length - rise * rise, half = a * length - first * rise;
    double inside = fmin(a * a + b * b - first * first, 0.0), time = 0.0;
    double root = sqrt(fmax(half * half - square * inside, 0.0));
    if (half >= 0.0) time = half + root > 0.0 ? -inside / (half + root) : 0.0;
    else if (square > 0.0) time = (root - half) / square;
    time = fmin(fmax(time, 0.0), 1.0);
    double radius = first + time * rise, stop = last > 0.0 ? 1.0 : first / -rise;
    double way = fmax(stop - time, 0.0) * length, c = (a + time * length) / radius;
    if (!(radius > 0.0 && way > 0.0)) return 0.0;
    double ahead = fmax(1.0 + c, 0.0), behind = fmax(1.0 - c, 0.0);
    if (rise == 0.0) {
        double fade = exp(-fmin(way / radius, 700.0));
        /* ln((1 + c + (1 - c) fade^2)/2) without cancellation for short steps */
        double closing = log1p(-0.5 * (1.0 - c) * (1.0 - fade) * (1.0 + fade));
        return radius * radius * fmax(way / radius + closing, 0.0);
    }
    double grade = rise / length, z = (end - radius) / radius, mean = 1.0;
    if (fabs(z) < 1e-3) mean = 1.0 - z * (0.5 - z * (1.0 / 3.0 - z * (0.25 - z * 0.2)));
    else mean = end > 0.0 ? log1p(z) / z : 700.0;
    double reach = fmin(end > 0.0 ? way * mean / radius : 700.0, ahead > 0.0 ? 40.0 : 700.0);
    double pieces = ceil(reach * fmax(1.0, fabs(grade))), turned = 0.0;
    for (double k = 0.0; k < pieces; k += 1.0) {
        double h = 0.5 * reach / pieces, middle = (2.0 * k + 1.0) * h;
        for (int i = 0; i < 8; i++) {
            double at = middle + (i < 4 ? -h : h) * NODES[i % 4], fade = behind * exp(-2.0 * at);
            double share = ahead > 0.0 ? fade / (ahead + fade) : 1.0;
            turned += h * WEIGHTS[i % 4] * exp(2.0 * grade * at) * 2.0 * share;
        }
    }
    double work = 0.5 * (radius + end) * way - radius * radius * turned;
    return fmax(work - 0.5 * (end * end - radius * radius), 0.0);
}
