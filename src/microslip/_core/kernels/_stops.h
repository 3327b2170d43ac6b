/* Stop elements whose yield displacements change along a cycle. Part of _compiled.c.
 *
 * Element j follows the displacement while it stays within its limit max(y[j] + shift, 0), which is
 * straight along a step; where the limit falls below it, it goes with the limit. One that enters
 * during a step moves only after its entry. Its mean over a step is exact for straight steps; where
 * displacement and shift bend within a step, by b tau (1 - tau) with their means over it, the part
 * that sticks goes with the first and the part that slips with the second.
 */

/* Integral of 6 tau (1 - tau) up to t. */
static double part_of_bend(double t) { return t * t * (3.0 - 2.0 * t); }

/* Moves one element by a step of `move` while its limit goes from `first` to `last`; both may be
 * below zero. Returns its mean over the step. */
static double move_stop(double *state, double move, double first, double last, double bend,
                        double limit_bend)
{
    if (last <= 0.0 && first <= 0.0) {
        *state = 0.0;
        return 0.0;
    }
    if (first <= 0.0) { /* from its entry on, either with the displacement or with its limit */
        double part = last / (last - first);
        *state = fmin(fmax(part * move, -last), last);
        return 0.5 * part * *state;
    }
    double from = fmin(fmax(*state, -first), first), trial = from + move;
    if (last <= 0.0) { /* it meets one of its limits before these meet at zero */
        double above = (first - from) / fmax(first - from + trial - last, 1e-300);
        double below = (first + from) / fmax(first + from - trial - last, 1e-300);
        double out = first / (first - last), t = out;
        if (trial > last) t = fmin(t, above);
        if (trial < -last) t = fmin(t, below);
        double there = from + t * move;
        *state = 0.0;
        return 0.5 * (from + there) * t + 0.5 * there * (out - t);
    }
    double sign = trial > 0.0 ? 1.0 : -1.0, over = sign * trial - last;
    if (over <= 0.0) {
        *state = trial;
        return from + 0.5 * move + bend;
    }
    double slack = first - sign * from, t = slack > 0.0 ? slack / (slack + over) : 0.0;
    double stuck = part_of_bend(t);
    *state = sign * last;
    return 0.5 * (from + *state) + sign * 0.5 * t * over + stuck * bend +
           sign * (1.0 - stuck) * limit_bend;
}

/* Least of two and larger of two numbers that are not NaN: unlike fmin, one instruction. */
static inline double lesser(double a, double b) { return a < b ? a : b; }
static inline double larger(double a, double b) { return a > b ? a : b; }

/* The same step for elements from `j` on, whose limits stay above zero: without branches. */
static void move_stops(const double *from, const double *y, Py_ssize_t j, Py_ssize_t columns,
                       double move, double before, double now, double *to)
{
    for (; j < columns; j++) {
        double first = y[j] + before, last = y[j] + now;
        double trial = lesser(larger(from[j], -first), first) + move;
        to[j] = lesser(larger(trial, -last), last);
    }
}

static void mean_stops(const double *state, const double *y, Py_ssize_t j, Py_ssize_t columns,
                       double move, double before, double now, double bend, double limit_bend,
                       double *to, double *mean)
{
    for (; j < columns; j++) {
        double first = y[j] + before, last = y[j] + now;
        double from = lesser(larger(state[j], -first), first), trial = from + move;
        double sign = trial > 0.0 ? 1.0 : -1.0, over = larger(sign * trial - last, 0.0);
        double slack = first - sign * from + 1e-300, t = slack / (slack + over);
        double stuck = part_of_bend(t);
        to[j] = lesser(larger(trial, -last), last);
        mean[j] = 0.5 * (from + to[j]) + sign * 0.5 * t * over + stuck * bend +
                  sign * (1.0 - stuck) * limit_bend;
    }
}

static int run_stops(const Argument *a, Result *out)
{
    const double *move = a[0].reals, *bend = a[1].reals, *shift = a[2].reals;
    const double *shift_bend = a[3].reals, *y = a[4].reals;
    double start = a[5].x, *value = a[6].reals, *mean = a[7].reals, lowest = 0.0, highest;
    Py_ssize_t n = a[0].n, columns = a[4].n, above = columns, below = 0;
    if (n == 0) return FINE;
    int with_means = a[7].n > 0; /* without them only the values at the places are computed */
    if (!all_have(a, 1, 3, n) || !all_have(a, 6, with_means ? 7 : 6, n * columns)) return TOO_SHORT;
    for (Py_ssize_t j = 0; j < columns; j++)
        value[j] = fmin(fmax(y[j] + shift[0], 0.0), start);
    highest = shift[0];
    for (Py_ssize_t i = 0; i < n; i++) {
        lowest = lesser(lowest, shift[i]);
        highest = larger(highest, shift[i]);
    }
    while (above > 0 && y[above - 1] + lowest > 0.0) above--;
    while (below < above && y[below] + highest <= 0.0) below++; /* these never carry a force */
    for (Py_ssize_t i = 0; i < n; i++)
        for (Py_ssize_t j = 0; j < below; j++) {
            value[i * columns + j] = 0.0;
            if (with_means) mean[i * columns + j] = 0.0;
        }
    /* From the largest displacement on; what the second cycle leaves is settled. */
    for (Py_ssize_t step = 1; step <= 2 * n; step++) {
        Py_ssize_t i = step % n, before = (step - 1) % n;
        double *to = value + i * columns, *to_mean = with_means ? mean + i * columns : NULL;
        const double *from = value + before * columns;
        for (Py_ssize_t j = below; j < above; j++) {
            double state = from[j];
            double over_step = move_stop(&state, move[i], y[j] + shift[before], y[j] + shift[i],
                                         bend[i], shift_bend[i]);
            to[j] = state;
            if (with_means) to_mean[j] = over_step;
        }
        if (step < n || !with_means)
            move_stops(from, y, above, columns, move[i], shift[before], shift[i], to);
        else
            mean_stops(from, y, above, columns, move[i], shift[before], shift[i], bend[i],
                       shift_bend[i], to, to_mean);
    }
    return FINE;
}
