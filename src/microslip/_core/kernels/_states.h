/* States of many nodes on one load curve: trials, commits and losses. Part of _compiled.c.
 *
 * Rows and marks of node i begin at entry begin[i] and are depth[i].
 */

static int rows_fit(const Argument *rows, const Argument *marks, const Argument *begin,
                    const Argument *count, Py_ssize_t nodes)
{
    const long long *b = begin->integers, *n = count->integers;
    if (begin->n < nodes || count->n < nodes) return 0;
    long long most = rows->n / 3;
    if (marks && marks->n / 2 < most) most = marks->n / 2;
    for (Py_ssize_t i = 0; i < nodes; i++)
        if (b[i] < 0 || n[i] < 0 || n[i] > most || b[i] > most - n[i]) return 0;
    return 1;
}

/* Outputs are the data for a commit (front, density, value, and code: four times the remaining
 * rows plus the kind) and d(T/mu)/d(place); with steps also N, -N' and d(T/mu)/d(step). */
static int run_field_try(const Argument *a, Result *out)
{
    enum { PLACE, STEP, REST, LAST_PLACE, LAST_STEP, LAST_VALUE, ROWS, MARKS, BEGIN, DEPTH, FRONT,
           DENSITY, VALUE, CODE, BY_PLACE, LOAD, FALL, BY_STEP, CURVE };
    Py_ssize_t nodes = a[PLACE].n;
    const Profile *p = a[CURVE].curve;
    const double *x = a[PLACE].reals, *d = a[STEP].reals, *rest = a[REST].reals,
                 *last_place = a[LAST_PLACE].reals, *last_step = a[LAST_STEP].reals,
                 *last_value = a[LAST_VALUE].reals;
    const Row *rows = (const Row *)a[ROWS].reals;
    const Mark *marks = (const Mark *)a[MARKS].reals;
    if (!all_have(a, REST, LAST_VALUE, nodes) || !all_have(a, BEGIN, BY_PLACE, nodes) ||
        (d && (a[STEP].n < nodes || !all_have(a, LOAD, BY_STEP, nodes))) ||
        !rows_fit(&a[ROWS], &a[MARKS], &a[BEGIN], &a[DEPTH], nodes))
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        long long first = a[BEGIN].integers[i];
        const Row *own = rows + first;
        double now = d ? d[i] : last_step[i];
        Move m;
        make_move(p, rest[i], own, marks + first, (Py_ssize_t)a[DEPTH].integers[i], last_step[i],
                  last_place[i], last_value[i], now, x[i], &m);
        a[FRONT].reals[i] = m.front;
        a[DENSITY].reals[i] = m.density;
        a[VALUE].reals[i] = m.value;
        a[CODE].integers[i] = 4 * (long long)m.depth + m.kind;
        a[BY_PLACE].reals[i] = m.fall;
        if (!d) continue;
        double here;
        a[LOAD].reals[i] = load_at(p, rest[i] + now, &here);
        a[FALL].reals[i] = here;
        a[BY_STEP].reals[i] = turn_of(own, now, &m) * (m.fall - here);
    }
    return FINE;
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

/* Apply a trial; every node needs room for the row that it adds. */
static int run_field_commit(const Argument *a, Result *out)
{
    enum { PLACE, STEP, FRONT, DENSITY, VALUE, CODE, BEGIN, ROOM, LAST_PLACE, LAST_STEP, LAST_VALUE,
           ROWS, MARKS, DEPTH };
    Py_ssize_t nodes = a[PLACE].n;
    const double *d = a[STEP].reals ? a[STEP].reals : a[LAST_STEP].reals, *front = a[FRONT].reals;
    const long long *code = a[CODE].integers, *begin = a[BEGIN].integers, *room = a[ROOM].integers;
    long long *depth = a[DEPTH].integers;
    if ((a[STEP].reals && a[STEP].n < nodes) || !all_have(a, FRONT, LAST_VALUE, nodes) ||
        a[DEPTH].n < nodes || !rows_fit(&a[ROWS], &a[MARKS], &a[BEGIN], &a[ROOM], nodes))
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < nodes; i++)
        if (code[i] < 0 || code[i] / 4 > depth[i] || code[i] / 4 + (front[i] > d[i]) > room[i])
            return TOO_SHORT;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        double now = d[i], value = a[VALUE].reals[i];
        Move m = {(Py_ssize_t)(code[i] / 4), (int)(code[i] % 4), front[i], a[DENSITY].reals[i],
                  value, 0.0};
        depth[i] = take_move((Row *)a[ROWS].reals + begin[i], (Mark *)a[MARKS].reals + begin[i],
                             a[LAST_PLACE].reals[i], now, &m);
        a[LAST_PLACE].reals[i] = a[PLACE].reals[i];
        a[LAST_STEP].reals[i] = now;
        a[LAST_VALUE].reals[i] = value;
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
