/* Memory diagrams: the moves of a contact. Part of _compiled.c, and of what is exported as C.
 *
 * The shear is held by D(eta) over separations eta >= d, piecewise constant, |D| <= 1 (memory
 * diagrams: Aleshin and others, DOI 10.3389/fmech.2020.00030). Row k of a stack, counted from
 * outside, is (end, D, integral of D beyond the end) and reaches inwards to the end of the next row
 * or to the last separation; beyond row 0 D is 0. A place is the integral of all D.
 */

typedef struct {
    double end, density, beyond;
} Row;

/* Effect of a straight step of (separation, place) on the diagram. Returns the number of
 * remaining rows, the start q of the last of them, the D between q and the separation, and the
 * kind: 0 without slip, 1 if slip spread out to q, 2 if D was only cut off at q. */
static inline Py_ssize_t step_front(double separation, double place, const Row *stack,
                                    Py_ssize_t depth, double last_separation, double last_place,
                                    double *q, double *density, int *kind)
{
    double fall = last_separation - separation, move = place - last_place, sign;
    if (fabs(move) <= fall) {
        *q = last_separation;
        *density = fall > 0.0 ? move / fall : 0.0;
        *kind = 0;
        return depth;
    }
    *q = last_separation;
    sign = copysign(1.0, move);
    if (fall != 0.0) {
        while (depth && stack[depth - 1].end <= separation) depth--;
        double held = 0.0;
        if (depth) {
            const Row *row = &stack[depth - 1];
            held = row->density * (row->end - separation) + row->beyond;
        }
        /* Selected without branches, which processors could not foresee: the separation rises about
         * as often as it falls. */
        held = fall > 0.0 ? last_place : held;
        *q = separation > last_separation ? separation : last_separation;
        if (place == held) {
            *density = 0.0;
            *kind = 2;
            return depth;
        }
        sign = copysign(1.0, place - held);
    }
    *density = sign;
    *kind = 1;
    for (; depth; depth--) {
        const Row *row = &stack[depth - 1];
        if (row->density != sign) {
            double front = (place + sign * separation - row->density * row->end - row->beyond) /
                           (sign - row->density);
            if (front < row->end - 4e-16 * (fabs(row->end) + fabs(separation))) {
                if (front > *q) *q = front;
                return depth;
            }
        }
        if (row->end > *q) *q = row->end;
    }
    double front = separation + sign * place;
    if (front > *q) *q = front;
    return 0;
}

/* Push the row of a step if it is new; returns the new depth. */
static inline Py_ssize_t add_row(Row *stack, Py_ssize_t depth, double separation, double front,
                                 double density, int kind, double last_place)
{
    double beyond = last_place;
    if (!(front > separation)) return depth;
    if (kind) {
        const Row *row = depth ? &stack[depth - 1] : NULL;
        beyond = row ? row->density * (row->end - front) + row->beyond : 0.0;
    }
    stack[depth].end = front;
    stack[depth].density = density;
    stack[depth].beyond = beyond;
    return depth + 1;
}

/* Each row of a node has a mark: T/mu of the step that created the row, and the step itself.
 * Marks never change, even if the row is cut; at a constant load one difference of N then gives
 * the value. */
typedef struct {
    double value, base;
} Mark;

/* A move: remaining rows, front, D and kind as of step_front, T/mu, and the slope -dN/d(eta). */
typedef struct {
    Py_ssize_t depth;
    int kind;
    double front, density, value, fall;
} Move;

/* T/mu and the slope of a move whose front is known; `load` is N at the step, or NAN. */
static inline void value_move(const Profile *p, double rest, const Row *rows, const Mark *marks,
                              double last_value, double step, double load, Move *m)
{
    if (m->kind == 0) {
        m->value = last_value;
        if (m->front > step) { /* new contact sticks */
            double drop = drop_at(p, rest + step, m->front - step);
            m->value += m->density * drop;
            m->fall = drop / (m->front - step);
        } else { /* no motion: further motion would continue the last slip */
            const Row *top = m->depth ? &rows[m->depth - 1] : NULL;
            m->fall = fall_at(p, rest + (top && fabs(top->density) == 1.0 ? top->end : step));
        }
        return;
    }
    double drop = front_at(p, rest + step, m->front - step, load, &m->fall);
    m->value = m->density * drop;
    if (!m->depth) return;
    const Row *row = &rows[m->depth - 1];
    const Mark *mark = &marks[m->depth - 1];
    if (mark->base == step)
        m->value = mark->value + (m->density - row->density) * drop;
    else
        m->value += mark->value - row->density * drop_to(p, rest + mark->base,
                                                         m->front - mark->base, load - drop);
}

static inline void make_move(const Profile *p, double rest, const Row *rows, const Mark *marks,
                             Py_ssize_t depth, double last_step, double last_place,
                             double last_value, double step, double place, Move *m)
{
    m->depth = step_front(step, place, rows, depth, last_step, last_place, &m->front, &m->density,
                          &m->kind);
    value_move(p, rest, rows, marks, last_value, step, NAN, m);
}

/* The rows need room for one more. */
static inline Py_ssize_t take_move(Row *rows, Mark *marks, double last_place, double step,
                                   const Move *m)
{
    Py_ssize_t depth = add_row(rows, m->depth, step, m->front, m->density, m->kind, last_place);
    if (depth > m->depth) {
        marks[m->depth].value = m->value;
        marks[m->depth].base = step;
    }
    return depth;
}


/* D of further motion at the end of a move: it would continue the last slip. */
static inline double turn_of(const Row *rows, double step, const Move *m)
{
    int rests = !m->kind && !(m->front > step) && m->depth;
    return rests && fabs(rows[m->depth - 1].density) == 1.0 ? rows[m->depth - 1].density : m->density;
}

/* Error of a memory of limited depth: a bound of T over mu for moves whose front is between
 * `inner` and `outer`, a flag for such moves, and the largest bound that has applied so far. */
typedef struct {
    double most, inner, outer, outside, error;
} Doubt;

/* Replace three rows down to `inner` by two with D and -D that have the same place and T/mu, so
 * that T does not jump and rows further in are exact. The integral of D of the sliders in
 * between changes by g with mean zero, and no move increases it, so the error of T/mu is at most
 * half the integral of |g| N''. Returns a bound of this. */
static double lump(const Profile *p, double rest, const Row *rows, double inner, Row *two,
                   double *first, double *both)
{
    double ends[4] = {rows[0].end, rows[1].end, rows[2].end, inner}, way = 0.0, value = 0.0;
    double whole = 0.0, held[3] = {rows[0].density, rows[1].density, rows[2].density};
    for (int k = 0; k < 3; k++) {
        double drop = drop_at(p, rest + ends[k + 1], ends[k] - ends[k + 1]);
        way += held[k] * (ends[k] - ends[k + 1]);
        value += held[k] * drop;
        whole += drop;
    }
    double low = inner, high = ends[0], width = high - low, begin = low, past = whole, density = 0.0;
    /* At `low` the two sides of D cover (width, whole), at `high` the negative of it: somewhere
     * between they cover a multiple of (way, value). */
    double miss = way * whole - value * width, sign = miss > 0.0 ? 1.0 : -1.0;
    for (int k = 0; k < 60 && fabs(miss) > 1e-15 * width * whole; k++) {
        begin = 0.5 * (low + high);
        past = drop_at(p, rest + begin, ends[0] - begin);
        miss = way * (2.0 * past - whole) - value * (2.0 * (ends[0] - begin) - width);
        if (sign * miss > 0.0) low = begin;
        else high = begin;
    }
    double span = 2.0 * (ends[0] - begin) / width - 1.0, load = whole > 0.0 ? 2.0 * past / whole - 1.0 : 0.0;
    if (fabs(load) > fabs(span)) density = value / whole / load;
    else if (span != 0.0) density = way / width / span;
    /* The place is exact even if the load is negligible. */
    sign = density < 0.0 ? -1.0 : 1.0;
    density = sign * fmin(fmax(fabs(density), fabs(way) / width), 1.0);
    if (density != 0.0) {
        span = fmin(fmax(way / (width * density), -1.0), 1.0);
        begin = fmax(ends[0] - 0.5 * width * (1.0 + span), inner);
        past = drop_at(p, rest + begin, ends[0] - begin);
    }
    double most = 0.0, jump = fabs(value - density * (2.0 * past - whole));
    for (int k = 1; k < 4; k++) { /* largest difference: at one of the ends */
        double at = k < 3 ? ends[k] : begin, before = 0.0;
        for (int j = 0; j < 3; j++)
            before += held[j] * (fmax(ends[j], at) - fmax(ends[j + 1], at));
        double after = density * (ends[0] - fmax(begin, at)) - density * fmax(begin - at, 0.0);
        most = fmax(most, fabs(before - after));
    }
    two[0] = rows[0];
    two[0].density = density;
    two[1].end = begin;
    two[1].density = -density;
    two[1].beyond = rows[0].beyond + density * (ends[0] - begin);
    *first = density * past;
    *both = value;
    return jump + 0.5 * most * fmax(fall_at(p, rest + inner) - fall_at(p, rest + ends[0]), 0.0);
}

/* Merge one row of at least four: of the outermost loops, or of new contact from many sticking
 * steps, whichever has the smaller error. The last row is extended to `reach`. */
static Py_ssize_t make_room(const Profile *p, double rest, Row *rows, Mark *marks, Py_ssize_t depth,
                            double reach, Doubt *doubt)
{
    Py_ssize_t best = 0;
    double least = HUGE_VAL, first, both, cost;
    Row two[2], other[2];
    for (Py_ssize_t k = 1; k + 3 <= depth; k++) {
        const Row *r = rows + k;
        double width = r->end - (k + 3 < depth ? r[3].end : reach);
        double spread = fmax(fabs(r->density - r[1].density), fabs(r[1].density - r[2].density));
        int sticks = fabs(r->density) < 1.0 && fabs(r[1].density) < 1.0 && fabs(r[2].density) < 1.0;
        if (!sticks || !(spread * width * width < least)) continue;
        least = spread * width * width;
        best = k;
    }
    cost = lump(p, rest, rows, rows[3].end, two, &first, &both);
    if (best) {
        double at = best + 3 < depth ? rows[best + 3].end : reach, begin, end;
        double other_cost = lump(p, rest, rows + best, at, other, &begin, &end);
        if (other_cost < cost) {
            const Mark *mark = &marks[best - 1];
            double drop = drop_at(p, rest + mark->base, rows[best].end - mark->base);
            double outside = mark->value - rows[best - 1].density * drop;
            cost = other_cost;
            two[0] = other[0];
            two[1] = other[1];
            first = outside + begin;
            both = outside + end;
        } else {
            best = 0;
        }
    }
    double inner = best + 3 < depth ? rows[best + 3].end : reach;
    doubt->inner = doubt->most > 0.0 ? fmin(doubt->inner, inner) : inner;
    doubt->outer = doubt->most > 0.0 ? fmax(doubt->outer, rows[best].end) : rows[best].end;
    doubt->most += cost;
    rows[best] = two[0];
    rows[best + 1] = two[1];
    marks[best].value = first;
    marks[best].base = two[1].end;
    marks[best + 1].value = both;
    marks[best + 1].base = inner;
    for (Py_ssize_t k = best + 2; k + 1 < depth; k++) {
        rows[k] = rows[k + 1];
        marks[k] = marks[k + 1];
    }
    return depth - 1;
}

/* Apply the error of merged rows to a move: the bound applies from the time when a front reaches
 * them until they are wiped out, and is at most twice the limit of the sliders there. */
static void meet_doubt(const Profile *p, double rest, double step, const Move *m, Doubt *doubt)
{
    if (!(doubt->most > 0.0)) return;
    if (!m->depth || m->front >= doubt->outer) {
        doubt->most = doubt->inner = doubt->outer = doubt->outside = 0.0;
        return;
    }
    if (!(m->front > doubt->inner)) return;
    double from = m->front, to = doubt->outer, drop = drop_at(p, rest + from, to - from);
    double held = (from - step) * fall_at(p, rest + from) - (to - step) * fall_at(p, rest + to);
    doubt->inner = from;
    doubt->most = fmin(doubt->most, 2.0 * fmax(held + drop, 0.0));
    doubt->outside = 1.0;
    doubt->error = fmax(doubt->error, doubt->most);
}
