/* Memory diagrams: records under a load that varies. Part of _compiled.c. */

/* ---- memory diagrams with a load curve ---------------------------------------------------- */

/* values[k] is the integral of D (-N') from where row k begins. */
typedef struct {
    Row *stack;
    double *values;
    Py_ssize_t depth;
    double separation, place, value;
} Diagram;

/* Result of a step: remaining rows, front, D, kind, value, part of the remaining rows. */
typedef struct {
    Py_ssize_t depth;
    double front, density, value, outer, drop;
    int kind;
} Step;

static inline void probe(const Profile *p, const Diagram *g, double separation, double place,
                         Step *step)
{
    step->depth = step_front(separation, place, g->stack, g->depth, g->separation, g->place,
                             &step->front, &step->density, &step->kind);
    Py_ssize_t depth = step->depth;
    double outer = depth ? g->values[depth - 1] : 0.0;
    if (depth && step->kind) {
        const Row *row = &g->stack[depth - 1];
        outer = depth > 1 ? g->values[depth - 2] : 0.0;
        outer = row->density * drop_at(p, step->front, row->end - step->front) + outer;
    }
    step->value = step->outer = outer;
    step->drop = 0.0;
    if (step->front > separation) {
        step->drop = drop_at(p, separation, step->front - separation);
        step->value = step->density * step->drop + outer;
    }
}

/* The stack needs room for one more row. */
static inline void push(Diagram *g, double separation, double place, const Step *step)
{
    if (step->depth) g->values[step->depth - 1] = step->outer;
    g->depth = add_row(g->stack, step->depth, separation, step->front, step->density, step->kind,
                       g->place);
    if (g->depth > step->depth) g->values[step->depth] = step->value;
    g->separation = separation;
    g->place = place;
    g->value = step->value;
}

/* Diagram from four arguments starting at the k-th, with room for `extra` more rows. */
static int bind_diagram(Diagram *g, const Argument *a, int k, Py_ssize_t extra)
{
    g->stack = (Row *)a[k].reals;
    g->values = a[k + 1].reals;
    g->depth = a[k + 2].n;
    g->separation = a[k + 3].x;
    g->place = a[k + 4].x;
    g->value = 0.0;
    return g->depth >= 0 && g->depth <= a[k].n / 3 - extra && g->depth <= a[k + 1].n - extra;
}

static int run_coupled_step(const Argument *a, Result *out)
{
    const Profile *p = a[7].curve;
    double separation = a[0].x, fall;
    Diagram g;
    Step step;
    if (!bind_diagram(&g, a, 2, 0)) return TOO_SHORT;
    probe(p, &g, separation, a[1].x, &step);
    if (step.kind == 1) {
        fall = fall_at(p, step.front);
    } else if (step.front > separation) {
        fall = step.drop / (step.front - separation);
    } else { /* a move in the same direction continues the last slip */
        const Row *row = step.depth ? &g.stack[step.depth - 1] : NULL;
        int slipped = step.kind == 0 && row && fabs(row->density) == 1.0;
        fall = fall_at(p, slipped ? row->end : separation);
    }
    out[0].n = step.depth;
    out[1].x = step.front;
    out[2].x = step.density;
    out[3].n = step.kind;
    out[4].x = step.value;
    out[5].x = step.outer;
    out[6].x = fall;
    return FINE;
}

/* Limit the rows of a diagram after a record to `limit`. Moves that reached merged rows are
 * detected from the remaining rows. */
static int run_bound_rows(const Argument *a, Result *out)
{
    Row *rows = (Row *)a[0].reals;
    double *values = a[1].reals, step = a[3].x;
    Py_ssize_t depth = a[2].n, limit = a[4].n, inner = 0, outer = 0;
    Doubt *doubt = (Doubt *)a[5].reals;
    if (depth < 0 || depth > a[0].n / 3 || depth > a[1].n || limit < 4 || a[5].n < 5)
        return TOO_SHORT;
    for (Py_ssize_t k = 0; k < depth; k++) {
        inner |= rows[k].end == doubt->inner;
        outer |= rows[k].end == doubt->outer;
    }
    if (doubt->most > 0.0 && !outer) {
        doubt->most = doubt->inner = doubt->outer = doubt->outside = 0.0;
    } else if (doubt->most > 0.0 && !inner) {
        double load = load_at(a[6].curve, step, NULL);
        doubt->most = fmin(doubt->most, 2.0 * load); /* largest difference of sliders */
        doubt->outside = 1.0;
        doubt->error = fmax(doubt->error, doubt->most);
    }
    out->n = depth;
    if (depth <= limit) return FINE;
    Mark *marks = malloc((size_t)depth * sizeof(Mark));
    if (!marks) return NO_MEMORY;
    for (Py_ssize_t k = 0; k < depth; k++) {
        marks[k].value = values[k];
        marks[k].base = k + 1 < depth ? rows[k + 1].end : step;
    }
    while (depth > limit) depth = make_room(a[6].curve, 0.0, rows, marks, depth, step, doubt);
    for (Py_ssize_t k = 0; k < depth; k++) values[k] = marks[k].value;
    free(marks);
    out->n = depth;
    return FINE;
}

/* ---- force control -------------------------------------------------------------------------- */

/* Separation q >= `low` whose load differs by `wanted` from that at the anchor, before it, where N
 * is higher, or after it: Newton's method on log N, which is concave for all but odd tables, in
 * brackets. */
static double solve_front(const Profile *p, double anchor, double wanted, double low, int before)
{
    double slope, there = load_at(p, anchor, &slope);
    /* N of the caller may be a rounding error above this one. */
    if (!before) wanted = fmin(wanted, there * (1.0 - 4.5e-16));
    double target = before ? there + wanted : there - wanted;
    double high = before ? anchor : HUGE_VAL, q = low;
    if (before && slope > 0.0) q = fmax(low, anchor - wanted / slope);
    for (int i = 0; i < 200; i++) {
        double miss = before ? drop_at(p, q, anchor - q) - wanted
                             : wanted - drop_at(p, anchor, q - anchor);
        if (miss == 0.0 || (miss < 0.0 && q == low)) return q;
        if (miss > 0.0) low = q;
        else high = q;
        double load = target + miss, fall, next = HUGE_VAL, length = 0.0;
        load_at(p, q, &fall);
        if (load > 0.0 && fall > 0.0 && target > 0.0) {
            length = load / fall;
            next = q + length * log1p(miss / target);
        }
        int newton = low <= next && next <= high && length > 0.0;
        if (!newton)
            next = high < HUGE_VAL ? 0.5 * (low + high) : low + 2.0 * (fabs(low - anchor) + 1e-30);
        double step = next - q;
        if (newton && step * step <= 4e-17 * length * fabs(next - anchor)) return next;
        if (fabs(step) <= 2e-16 * fabs(next)) return next;
        q = next;
    }
    return q;
}

static double place_of(const Profile *p, const Diagram *g, double separation, double value)
{
    double fall = g->separation - separation, change = value - g->value, sign, begin;
    Py_ssize_t depth = g->depth;
    if (fall >= 0.0) {
        double gain = fall > 0.0 ? drop_at(p, separation, fall) : 0.0;
        if (fabs(change) <= gain) return g->place + (gain > 0.0 ? change / gain * fall : 0.0);
        sign = change > 0.0 ? 1.0 : -1.0;
        begin = g->separation;
    } else {
        while (depth && g->stack[depth - 1].end <= separation) depth--;
        double held = 0.0, place = 0.0;
        if (depth) {
            const Row *row = &g->stack[depth - 1];
            double outer = depth > 1 ? g->values[depth - 2] : 0.0;
            held = row->density * drop_at(p, separation, row->end - separation) + outer;
            place = row->density * (row->end - separation) + row->beyond;
        }
        if (value == held) return place;
        sign = value > held ? 1.0 : -1.0;
        begin = separation;
    }
    for (; depth; depth--) {
        const Row *row = &g->stack[depth - 1];
        double outer = depth > 1 ? g->values[depth - 2] : 0.0;
        double surplus = drop_at(p, separation, row->end - separation) + sign * (outer - value);
        if (row->density != sign && surplus >= 0.0) {
            double wanted = surplus / (1.0 - sign * row->density);
            double q = solve_front(p, row->end, wanted, fmax(begin, separation), 1);
            return sign * (q - separation) + row->density * (row->end - q) + row->beyond;
        }
        begin = fmax(begin, row->end);
    }
    return sign * (solve_front(p, separation, sign * value, begin, 0) - separation);
}

/* Values T/mu at places along a record, or, from a `value` on, the places that hold values. */
static int run_along(const Argument *a, Result *out, const Profile *p, const double *value)
{
    const double *ds = a[0].reals, *given = a[1].reals;
    Py_ssize_t n = a[0].n;
    Diagram g;
    if (!all_have(a, 1, 2, n) || !bind_diagram(&g, a, 3, n)) return TOO_SHORT;
    if (value) g.value = *value;
    for (Py_ssize_t i = 0; i < n; i++) {
        Step step;
        double place = value ? place_of(p, &g, ds[i], given[i]) : given[i];
        probe(p, &g, ds[i], place, &step);
        push(&g, ds[i], place, &step);
        a[2].reals[i] = value ? place : g.value;
    }
    out[0].n = g.depth;
    out[1].x = g.separation;
    out[2].x = g.place;
    if (value) out[3].x = g.value;
    return FINE;
}

static int run_coupled(const Argument *a, Result *out)
{
    return run_along(a, out, a[8].curve, NULL);
}

static int run_hold(const Argument *a, Result *out)
{
    return run_along(a, out, a[9].curve, &a[8].x);
}
