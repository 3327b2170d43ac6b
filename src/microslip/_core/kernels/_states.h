/* States of many nodes on one load curve: trials, commits and losses. Part of _compiled.c.
 *
 * Rows and marks of node i begin at entry begin[i] and are depth[i].
 */

static int rows_fit(const Argument *rows, const Argument *marks, const Argument *begin,
                    const Argument *count, Py_ssize_t nodes)
{
    const unsigned long long *b = (const unsigned long long *)begin->integers,
                             *n = (const unsigned long long *)count->integers;
    if (begin->n < nodes || count->n < nodes) return 0;
    unsigned long long most = (unsigned long long)rows->n / 3, bad = 0;
    if (marks && (unsigned long long)marks->n / 2 < most) most = (unsigned long long)marks->n / 2;
    for (Py_ssize_t i = 0; i < nodes; i++) /* the highest bits alone: no branch in the loop */
        bad |= b[i] | n[i] | (most - n[i]) | (most - n[i] - b[i]);
    return bad >> 63 == 0;
}

/* Steps of separations from those at rest. Returns whether a separation is not finite, the smallest
 * one, and the least and the largest step from the origin, those at rest and committed included. */
static int run_field_steps(const Argument *a, Result *out)
{
    enum { SEPARATION, ORIGIN, ORIGINS, LENGTH, REST, LAST_STEP, STEP };
    Py_ssize_t n = a[SEPARATION].n;
    const double *d = a[SEPARATION].reals, *origins = a[ORIGINS].reals, *length = a[LENGTH].reals,
                 *rest = a[REST].reals, *last = a[LAST_STEP].reals;
    if ((origins && a[ORIGINS].n < n) || (length && a[LENGTH].n < n) || !all_have(a, REST, STEP, n))
        return TOO_SHORT;
    double least = HUGE_VAL, low = HUGE_VAL, high = -HUGE_VAL;
    int bad = 0;
    for (Py_ssize_t i = 0; i < n; i++) {
        double whole = d[i] - (origins ? origins[i] : a[ORIGIN].x);
        if (length) whole /= length[i];
        double step = whole - rest[i], moved = rest[i] + step, before = rest[i] + last[i];
        a[STEP].reals[i] = step;
        bad |= !(fabs(d[i]) <= DBL_MAX);
        least = d[i] < least ? d[i] : least;
        low = rest[i] < low ? rest[i] : low;
        low = before < low ? before : low;
        low = moved < low ? moved : low;
        high = rest[i] > high ? rest[i] : high;
        high = before > high ? before : high;
        high = moved > high ? moved : high;
    }
    out[0].n = bad;
    out[1].x = least;
    out[2].x = low;
    out[3].x = high;
    return FINE;
}

/* Rows of the committed values and of a trial, each of all nodes. A trial at held steps ends before
 * its step. */
enum { NOW_PLACE, NOW_STEP, NOW_VALUE, NOW_LOAD, NOW_FALL, NOW_ROWS };
enum { TRIAL_PLACE, TRIAL_FRONT, TRIAL_DENSITY, TRIAL_VALUE, TRIAL_STEP, TRIAL_LOAD, TRIAL_FALL,
       TRIAL_ROWS };

#define BLOCK 32 /* nodes whose fronts are found together */

/* Trials of all nodes, at held steps where `step` is None. Codes are four times the remaining rows
 * plus the kind of the move. Returns 1, with nothing computed, if a displacement is not finite. */
INLINED int try_nodes(const Argument *a, Result *out, int varies)
{
    enum { DISPLACEMENT, STEP, REST, SLIP, WEIGHT, SCALE, LENGTH, NOW, ROWS, MARKS, BEGIN, DEPTH,
           TRIAL, CODE, FORCE, LOAD, TANGENT, STIFFNESS, CURVE };
    Py_ssize_t n = a[DISPLACEMENT].n;
    const Profile *p = a[CURVE].curve;
    const double *x = a[DISPLACEMENT].reals, *d = varies ? a[STEP].reals : NULL, *now = a[NOW].reals,
                 *length = a[LENGTH].reals, *rests = a[REST].reals, *slips = a[SLIP].reals,
                 *weights = a[WEIGHT].reals, *scales = a[SCALE].reals;
    const Row *rows = (const Row *)a[ROWS].reals;
    const Mark *marks = (const Mark *)a[MARKS].reals;
    const long long *begin = a[BEGIN].integers, *depth = a[DEPTH].integers;
    long long *code = a[CODE].integers;
    double *trial = a[TRIAL].reals, *force = a[FORCE].reals, *load = a[LOAD].reals,
           *tangent = a[TANGENT].reals, *stiffness = a[STIFFNESS].reals;
    if ((d && a[STEP].n < n) || !all_have(a, REST, SCALE, n) || (length && a[LENGTH].n < n) ||
        a[NOW].n < NOW_ROWS * n || a[TRIAL].n < (d ? TRIAL_ROWS : TRIAL_STEP) * n ||
        !all_have(a, CODE, LOAD, n) || a[TANGENT].n < 4 * n || (stiffness && a[STIFFNESS].n < n) ||
        !rows_fit(&a[ROWS], &a[MARKS], &a[BEGIN], &a[DEPTH], n))
        return TOO_SHORT;
    out->n = 0;
    for (Py_ssize_t i = 0; i < n; i++) out->n |= !(fabs(x[i]) <= DBL_MAX);
    if (out->n) return FINE;
    /* Fronts first, since processors look ahead only where they need not wait for divisions. */
    Move moves[BLOCK];
    for (Py_ssize_t i = 0; i < n; i++) {
        if (i % BLOCK == 0)
            for (Py_ssize_t k = i; k < n && k < i + BLOCK; k++) {
                Move *m = &moves[k - i];
                double last = now[NOW_STEP * n + k];
                trial[TRIAL_PLACE * n + k] = x[k] / slips[k];
                m->depth = step_front(d ? d[k] : last, trial[TRIAL_PLACE * n + k],
                                      rows + begin[k], (Py_ssize_t)depth[k], last,
                                      now[NOW_PLACE * n + k], &m->front, &m->density, &m->kind);
            }
        long long first = begin[i];
        double rest = rests[i], last = now[NOW_STEP * n + i], weight = weights[i];
        double step = d ? d[i] : last, slip = slips[i];
        double here = now[NOW_FALL * n + i], carried = now[NOW_LOAD * n + i];
        Move m = moves[i % BLOCK];
        if (d) carried = load_at(p, rest + step, &here);
        value_move(p, rest, rows + first, marks + first, now[NOW_VALUE * n + i], step, carried, &m);
        trial[TRIAL_FRONT * n + i] = m.front;
        trial[TRIAL_DENSITY * n + i] = m.density;
        trial[TRIAL_VALUE * n + i] = m.value;
        code[i] = 4 * (long long)m.depth + m.kind;
        if (d) {
            trial[TRIAL_STEP * n + i] = step;
            trial[TRIAL_LOAD * n + i] = carried;
            trial[TRIAL_FALL * n + i] = here;
        }
        double by_step = weight * (turn_of(rows + first, step, &m) * (m.fall - here));
        double by_place = m.fall * (weight / slip), grip = scales[i] * here;
        force[i] = m.value * weight;
        load[i] = scales[i] * carried;
        tangent[4 * i] = by_place;
        tangent[4 * i + 1] = length ? by_step / length[i] : by_step;
        tangent[4 * i + 2] = 0.0;
        tangent[4 * i + 3] = length ? -(grip / length[i]) : -grip;
        if (stiffness) stiffness[i] = by_place;
    }
    return FINE;
}

static int run_field_try(const Argument *a, Result *out)
{
    /* A copy of the loop for held steps, and one for others. */
    return a[1].reals ? try_nodes(a, out, 1) : try_nodes(a, out, 0);
}

/* Before a commit of nodes with at most `limit` rows each, whose error state has five numbers. */
static int run_field_bound(const Argument *a, Result *out)
{
    enum { STEP, REST, FRONT, CODE, BEGIN, DEPTH, LIMIT, DOUBT, ROWS, MARKS, CURVE };
    Py_ssize_t nodes = a[STEP].n, limit = a[LIMIT].n;
    if (!all_have(a, REST, DEPTH, nodes) || a[DOUBT].n < 5 * nodes || limit < 4 ||
        !rows_fit(&a[ROWS], &a[MARKS], &a[BEGIN], &a[DEPTH], nodes))
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        Row *rows = (Row *)a[ROWS].reals + a[BEGIN].integers[i];
        Mark *marks = (Mark *)a[MARKS].reals + a[BEGIN].integers[i];
        Doubt *doubt = (Doubt *)a[DOUBT].reals + i;
        long long *code = &a[CODE].integers[i];
        double step = a[STEP].reals[i], rest = a[REST].reals[i];
        Move m = {(Py_ssize_t)(*code / 4), 0, a[FRONT].reals[i], 0.0, 0.0, 0.0};
        if (m.depth > a[DEPTH].integers[i]) return TOO_SHORT;
        meet_doubt(a[CURVE].curve, rest, step, &m, doubt);
        while (m.depth >= limit && m.front > step) {
            m.depth = make_room(a[CURVE].curve, rest, rows, marks, m.depth, m.front, doubt);
            *code -= 4;
        }
    }
    return FINE;
}

/* Number of rows of a slot that holds `rows`: spare rows, more for deep memories, so that rough
 * noise seldom requires a move. */
static inline long long with_spare(long long rows)
{
    long long extra = 2 * rows - 5;
    return rows + rows / 2 + (extra < 0 ? 0 : extra > 6 ? 6 : extra);
}

/* Apply a trial. Nodes whose rows exceed their slot move to the end of the pool, of which `used`
 * rows are in use. Returns the number used after the step; -1, with nothing applied, if the pool is
 * too short. */
static int run_field_commit(const Argument *a, Result *out)
{
    enum { TRIAL, CODE, BEGIN, ROOM, NOW, ROWS, MARKS, DEPTH, USED };
    Py_ssize_t n = a[CODE].n;
    int varied = a[TRIAL].n >= TRIAL_ROWS * n;
    const double *trial = a[TRIAL].reals, *front = trial + TRIAL_FRONT * n;
    const long long *code = a[CODE].integers;
    long long *begin = a[BEGIN].integers, *room = a[ROOM].integers, *depth = a[DEPTH].integers;
    long long used = a[USED].n, whole = a[ROWS].n / 3, need = used;
    Row *rows = (Row *)a[ROWS].reals;
    Mark *marks = (Mark *)a[MARKS].reals;
    double *now = a[NOW].reals;
    const double *step = varied ? trial + TRIAL_STEP * n : now + NOW_STEP * n;
    if (a[TRIAL].n < TRIAL_STEP * n || a[NOW].n < NOW_ROWS * n || a[DEPTH].n < n || used < 0 ||
        a[MARKS].n / 2 < whole || !rows_fit(&a[ROWS], &a[MARKS], &a[BEGIN], &a[ROOM], n))
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < n; i++) {
        long long kept = code[i] / 4, count = kept + (front[i] > step[i]);
        if (code[i] < 0 || kept > depth[i] || depth[i] > room[i]) return TOO_SHORT;
        if (count > room[i]) need += with_spare(count);
    }
    out->n = -1;
    if (need > whole) return FINE;
    for (Py_ssize_t i = 0; i < n; i++) {
        Move m = {(Py_ssize_t)(code[i] / 4), (int)(code[i] % 4), front[i],
                  trial[TRIAL_DENSITY * n + i], trial[TRIAL_VALUE * n + i], 0.0};
        long long count = m.depth + (front[i] > step[i]);
        if (count > room[i]) {
            memcpy(rows + used, rows + begin[i], (size_t)m.depth * sizeof(Row));
            memcpy(marks + used, marks + begin[i], (size_t)m.depth * sizeof(Mark));
            begin[i] = used;
            room[i] = with_spare(count);
            used += room[i];
        }
        depth[i] = take_move(rows + begin[i], marks + begin[i], now[NOW_PLACE * n + i], step[i],
                             &m);
        now[NOW_PLACE * n + i] = trial[TRIAL_PLACE * n + i];
        now[NOW_VALUE * n + i] = m.value;
    }
    if (varied) {
        memcpy(now + NOW_STEP * n, trial + TRIAL_STEP * n, (size_t)n * sizeof(double));
        memcpy(now + NOW_LOAD * n, trial + TRIAL_LOAD * n, 2 * (size_t)n * sizeof(double));
    }
    out->n = (Py_ssize_t)used;
    return FINE;
}

/* Copy the first `count` rows of each node to a new pool. */
static int run_field_move(const Argument *a, Result *out)
{
    enum { COUNT_OF, FROM, TO, OLD_ROWS, OLD_MARKS, ROWS, MARKS };
    Py_ssize_t n = a[COUNT_OF].n;
    const long long *count = a[COUNT_OF].integers, *from = a[FROM].integers, *to = a[TO].integers;
    if (!rows_fit(&a[OLD_ROWS], &a[OLD_MARKS], &a[FROM], &a[COUNT_OF], n) ||
        !rows_fit(&a[ROWS], &a[MARKS], &a[TO], &a[COUNT_OF], n))
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < n; i++) {
        size_t rows = (size_t)count[i];
        memcpy((Row *)a[ROWS].reals + to[i], (const Row *)a[OLD_ROWS].reals + from[i],
               rows * sizeof(Row));
        memcpy((Mark *)a[MARKS].reals + to[i], (const Mark *)a[OLD_MARKS].reals + from[i],
               rows * sizeof(Mark));
    }
    return FINE;
}

/* Energy dissipated in a trial by each node, over mu kappa. */
static int run_field_losses(const Argument *a, Result *out)
{
    enum { PLACE, STEP, REST, CODE, LAST_PLACE, LAST_STEP, BEGIN, DEPTH, RULE, ROWS, LOSS, CURVE };
    Py_ssize_t nodes = a[PLACE].n;
    if (!all_have(a, STEP, DEPTH, nodes) || a[LOSS].n < nodes || a[RULE].n < RULES_LENGTH + a[CURVE].curve->panels ||
        !rows_fit(&a[ROWS], NULL, &a[BEGIN], &a[DEPTH], nodes))
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        Diagram g = {(Row *)a[ROWS].reals + a[BEGIN].integers[i], NULL,
                     (Py_ssize_t)a[DEPTH].integers[i], a[LAST_STEP].reals[i], a[LAST_PLACE].reals[i],
                     0.0};
        Profile own = *a[CURVE].curve;
        own.anchor -= a[REST].reals[i];
        Losses losses = {&own, a[RULE].reals, NAN, 0.0, 0.0};
        a[LOSS].reals[i] = a[CODE].integers[i] % 4
                               ? step_loss(&losses, &g, a[STEP].reals[i],
                                           a[PLACE].reals[i] - g.place, NULL)
                               : 0.0;
    }
    return FINE;
}
