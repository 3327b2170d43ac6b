/* What slip loses. Part of _compiled.c.
 *
 * While the front runs by dq over D, with s behind it, (1 - s D) [N(d) - N(q) + N'(q) (q - d)] dq is
 * lost, times mu kappa: by the integrals of N over a long run, of which enough is left after they
 * cancel, by quadrature of what is positive over a short one. Rules of Gauss and Legendre on [0, 1]
 * come in turn, nodes and then weights, for runs of so many panels at most, so many nodes each; then
 * the integrals of N from the middle of each panel on.
 */

static const double RULE_PANELS[] = {0.05, 1.0, 16.0};
static const int RULE_NODES[] = {4, 8, 16};
#define RULES_LENGTH 56 /* total number of nodes and weights */
#define KEPT 5e-5       /* smallest remainder over the largest term for which the integrals are
                         * accurate */

/* N and its tail integral at the last front. */
typedef struct {
    const Profile *curve;
    const double *rules;
    double front, load, tail;
} Losses;

/* Loss of a run from the integrals of N; below zero if cancellation is too large. */
static double run_tails(Losses *l, double ahead, double gap, double until, double first, double last)
{
    const double *tails = l->rules + RULES_LENGTH;
    double rise = last - first, from = l->tail, near = l->load, held, most;
    if (l->front != first + gap) from = tail_at(l->curve, tails, first + gap, &near);
    l->front = last + until;
    l->tail = tail_at(l->curve, tails, l->front, &l->load);
    if (rise == 0.0) {
        held = most = ahead * load_at(l->curve, first, NULL);
    } else {
        double pace = ahead / rise, load, whole = tail_at(l->curve, tails, first, &load);
        double tail = tail_at(l->curve, tails, last, &load);
        held = pace * (whole - tail);
        most = fabs(pace) * fmax(whole, tail);
    }
    double share = 1.0 + (until - gap) / ahead;
    double total = held + until * l->load - gap * near - share * (from - l->tail);
    most += fabs(share) * from + fmax(gap * near, until * l->load);
    return total > KEPT * most ? total : -1.0;
}

/* Mean loss of a run times its length, while the gap between front and separation goes from `gap` to
 * `until`. Past the end of the curve nothing depends on the front any more. */
static double run_piece(Losses *l, int past, double ahead, double gap, double until, double first,
                        double last)
{
    const Profile *p = l->curve;
    const double *rules = l->rules;
    double rise = last - first;
    if (!(ahead > 0.0)) return 0.0;
    double length = past ? 0.0 : ahead, parts = 1.0, total = 0.0;
    double turn = fmin(fabs(rise), 1e300);
    length = fmax(length, turn) * p->inverse_width;
    int rule = 0;
    if (!past && length > RULE_PANELS[0]) {
        double all = run_tails(l, ahead, gap, until, first, last);
        if (all >= 0.0) return all;
    }
    while (rule < 2 && length > RULE_PANELS[rule]) rules += 2 * RULE_NODES[rule++];
    if (rule == 2) parts = fmax(ceil(length / RULE_PANELS[2]), 1.0);
    int count = RULE_NODES[rule];
    for (double k = 0.0; k < parts; k += 1.0) {
        double sum = 0.0;
        for (int i = 0; i < count; i++) {
            double t = (k + rules[i]) / parts;
            sum += rules[count + i] * excess_at(p, first + t * rise, gap + t * (until - gap));
        }
        total += sum / parts;
    }
    return ahead * total;
}

static double run_loss(Losses *l, double ahead, double gap, double until, double first, double last)
{
    const Profile *p = l->curve;
    double top = p->anchor + (double)(p->panels - p->first) / p->inverse_width;
    double rise = last - first;
    /* Beyond the end there is no load and no loss. */
    if (first > top) {
        if (!(last < top)) return 0.0;
        double share = fmin((top - first) / rise, 1.0);
        gap += share * (until - gap);
        ahead *= 1.0 - share;
        first = top;
    } else if (last > top) {
        double share = fmin((top - first) / rise, 1.0);
        until = gap + share * (until - gap);
        ahead *= share;
        last = top;
    }
    double start = first + gap, end = last + until;
    if (start >= top) return run_piece(l, 1, ahead, gap, until, first, last);
    if (end <= top) return run_piece(l, 0, ahead, gap, until, first, last);
    double share = (top - start) / (end - start), meanwhile = first + share * (last - first);
    double between = fmax(top - meanwhile, 0.0);
    return run_piece(l, 0, share * ahead, gap, between, first, meanwhile) +
           run_piece(l, 1, (1.0 - share) * ahead, between, until, meanwhile, last);
}

/* Runs of the front, a row each: sample, way ahead, gap from and to, D, sign, separations from and
 * to. Those that find no room are counted only. */
typedef struct {
    double *rows;
    Py_ssize_t count, room;
    double sample;
} Runs;

#define RUN_COLUMNS 8

static void add_run(Runs *list, const double *run)
{
    double *row = list->rows + RUN_COLUMNS * list->count;
    if (list->count++ >= list->room) return;
    row[0] = list->sample;
    memcpy(row + 1, run, (RUN_COLUMNS - 1) * sizeof(double));
}

/* The runs of one step that slips, and what they lose; with `list` they are written down instead.
 *
 * The front covers the integral of 1 - sign D at a constant pace. While contact is lost, the
 * separation may catch up with it, and slip then begins anew in the other direction. What is
 * followed is the gap between the two, whose growth cancels no digits where the step goes along a
 * row's own D: proportional loading, the commonest of all. */
static double step_loss(Losses *l, const Diagram *g, double last, double move, Runs *list)
{
    double first = g->separation, rise = last - first, here = first, gap = 0.0, time = 0.0;
    double sign = 0.0, total = 0.0;
    Py_ssize_t row = g->depth - 1; /* -1: beyond all rows */
    while (time < 1.0) {
        double end = row >= 0 ? g->stack[row].end : HUGE_VAL;
        double density = row >= 0 ? g->stack[row].density : 0.0;
        if (end <= here + gap) {
            row--;
            continue;
        }
        double drive = move + density * rise;
        if (gap == 0.0) {
            if (drive == 0.0) { /* lost contact takes its D along */
                time = rise > 0.0 ? fmin((end - first) / rise, 1.0) : 1.0;
                here = end;
                row--;
                continue;
            }
            sign = (rise > 0.0 ? drive : move) > 0.0 ? 1.0 : -1.0;
        }
        double rate = 1.0 - sign * density;
        if (rate <= 0.0) { /* already slipping */
            gap = end - here;
            row--;
            continue;
        }
        double growth = fmax(sign * drive / rate, -rise), speed = growth + rise; /* monotone */
        double until = speed > 0.0 ? time + (end - here - gap) / speed : HUGE_VAL, then = until;
        int caught = growth < 0.0 && time - gap / growth <= fmin(until, 1.0);
        if (caught) then = time - gap / growth;
        then = fmin(then, 1.0);
        double there = then < 1.0 ? first + rise * then : last;
        double ahead = fmin(speed * (then - time), end - here - gap);
        double wide = caught ? 0.0 : fmax(gap + growth * (then - time), 0.0);
        if (!caught && until <= 1.0) { /* to the end of the row: the pace may be a ratio of
                                        * rounding errors */
            row--;
            ahead = end - here - gap;
            wide = fmax(end - there, 0.0);
        }
        if (ahead > 0.0 && list) {
            double run[] = {ahead, gap, wide, density, sign, here, there};
            add_run(list, run);
        } else if (ahead > 0.0) {
            total += rate * run_loss(l, ahead, gap, wide, here, there);
        }
        time = then;
        gap = wide;
        here = there;
    }
    return total;
}

/* Process a record; the loss of each step goes to `loss`, or its runs to the list. The stack is
 * used as scratch. */
static void walk_losses(const Profile *p, const double *rules, Diagram *g, const double *ds,
                        const double *xs, Py_ssize_t n, double *loss, Runs *list)
{
    Losses losses = {p, rules, NAN, 0.0, 0.0};
    for (Py_ssize_t i = 0; i < n; i++) {
        double d = ds[i], x = xs[i], front, density, lost = 0.0;
        int kind;
        Py_ssize_t depth = step_front(d, x, g->stack, g->depth, g->separation, g->place, &front,
                                      &density, &kind);
        if (list) list->sample = (double)i;
        if (kind) lost = step_loss(&losses, g, d, x - g->place, list);
        if (loss) loss[i] = lost;
        g->depth = add_row(g->stack, depth, d, front, density, kind, g->place);
        g->separation = d;
        g->place = x;
    }
}

static int run_losses(const Argument *a, Result *out)
{
    Diagram g = {(Row *)a[3].reals, NULL, a[4].n, a[5].x, a[6].x, 0.0};
    Py_ssize_t n = a[0].n;
    if (!all_have(a, 1, 2, n) || a[7].n < RULES_LENGTH + a[8].curve->panels || g.depth < 0 || g.depth > a[3].n / 3 - n)
        return TOO_SHORT;
    walk_losses(a[8].curve, a[7].reals, &g, a[0].reals, a[1].reals, n, a[2].reals, NULL);
    return FINE;
}

/* For curves without panels: list the runs, whose losses are integrated elsewhere. Returns their
 * number. */
static int run_slips(const Argument *a, Result *out)
{
    Diagram g = {(Row *)a[3].reals, NULL, a[4].n, a[5].x, a[6].x, 0.0};
    Runs list = {a[2].reals, 0, a[2].n / RUN_COLUMNS, 0.0};
    Py_ssize_t n = a[0].n;
    if (a[1].n < n || g.depth < 0 || g.depth > a[3].n / 3 - n) return TOO_SHORT;
    walk_losses(NULL, NULL, &g, a[0].reals, a[1].reals, n, NULL, &list);
    out->n = list.count;
    return FINE;
}
