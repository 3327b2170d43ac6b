/* Settled cycles of many nodes on one load curve. Part of _compiled.c.
 *
 * Places and steps (separations) count from each node's own rest.
 */

/* Dependence of a move on earlier ones: entry i of a cycle, at sample t. */
typedef struct {
    Py_ssize_t sample;
    int sticks, parent, before; /* entries of the row that was cut, and of the move before; -1 */
    double density, fall, here; /* D, -N' at the front, -N' at the step */
    double share, gain;         /* where the front lies in a parent that stuck; its mean -N' */
    double width;
} Entry;

typedef struct {
    Row *rows;
    Mark *marks;
    int *ids;
    Entry *entries;
    double *ahead, *slopes; /* of the row that a move leaves, and of its value; or NULL */
    void *memory;
} Cycle;

static int make_cycle(Cycle *c, Py_ssize_t samples, Py_ssize_t columns)
{
    size_t n = 2 * (size_t)samples + 2;
    size_t bytes = n * (sizeof(Row) + sizeof(Mark) + sizeof(Entry) + sizeof(double) +
                        2 * (size_t)columns * sizeof(double));
    char *at = c->memory = malloc(bytes);
    if (!at) return 0;
    c->rows = (Row *)at;
    c->marks = (Mark *)(at += n * sizeof(Row));
    c->entries = (Entry *)(at += n * sizeof(Mark));
    c->ids = (int *)(at += n * sizeof(Entry));
    c->ahead = (double *)(at += n * sizeof(double));
    c->slopes = columns ? (double *)(at + n * (size_t)columns * sizeof(double)) : NULL;
    return 1;
}

/* Record the dependence of a move on earlier ones, before it is applied. */
static void note_move(const Profile *p, const Cycle *c, const Move *m, double rest, double step,
                      double here, Py_ssize_t sample, Py_ssize_t id)
{
    Entry *e = &c->entries[id];
    e->sample = sample;
    e->before = (int)id - 1;
    e->fall = m->fall;
    e->here = here;
    e->density = m->density;
    e->width = m->front - step;
    e->sticks = m->kind == 0 && m->front > step;
    e->parent = -1;
    if (e->sticks) return;
    Py_ssize_t k = m->depth - 1;
    double front = m->front;
    if (m->kind == 0) { /* no motion */
        int slid = k >= 0 && fabs(c->rows[k].density) == 1.0;
        e->density = slid ? c->rows[k].density : 1.0;
        front = slid ? c->rows[k].end : step;
        k -= slid;
    } else if (m->kind == 2) {
        e->density = 1.0; /* slip of zero length */
    }
    if (k < 0) return;
    e->parent = c->ids[k];
    const Entry *parent = &c->entries[e->parent];
    if (!parent->sticks) return;
    double left = c->rows[k].end - front;
    e->share = left / parent->width;
    e->gain = drop_at(p, rest + front, left) / parent->width;
}

/* One settled cycle. Returns its first entry: 0, or `samples` after a second pass. The cycle
 * begins at the largest step + |place|, its root, with a straight path from rest. This wipes out
 * all memory, unless the root is within the region that this path pressed down in sticking. */
static Py_ssize_t walk_cycle(const Profile *p, Cycle *c, double rest, Py_ssize_t samples,
                             const double *place, const double *step, double *value, double *load,
                             double *slope)
{
    Py_ssize_t root = 0, depth = 0, passes = 1, first = 0;
    int sticks = 0;
    double most = -HUGE_VAL, last_place = 0.0, last_step = 0.0, last_value = 0.0, held_fall = 0.0;
    double held_load = load_at(p, rest, &held_fall);
    for (Py_ssize_t t = 0; t < samples; t++) {
        double reach = (step ? step[t] : 0.0) + fabs(place[t]);
        if (reach > most) {
            most = reach;
            root = t;
        }
    }
    for (Py_ssize_t pass = 0; pass < passes; pass++) {
        first = pass * samples;
        for (Py_ssize_t i = 0; i < samples; i++) {
            Py_ssize_t t = root + i < samples ? root + i : root + i - samples, id = first + i;
            double x = place[t], d = step ? step[t] : 0.0;
            Move m;
            make_move(p, rest, c->rows, c->marks, depth, last_step, last_place, last_value, d, x,
                      &m);
            double here = held_fall;
            load[t] = step ? load_at(p, rest + d, &here) : held_load;
            if (c->slopes) note_move(p, c, &m, rest, d, here, t, id);
            depth = take_move(c->rows, c->marks, last_place, d, &m);
            if (depth > m.depth) c->ids[depth - 1] = (int)id;
            sticks |= id == 0 && m.kind == 0 && m.front > d;
            value[t] = m.value;
            if (slope) slope[t] = m.fall;
            last_place = x;
            last_step = d;
            last_value = m.value;
        }
        /* If the root is within this region, another pass settles the cycle. */
        passes = sticks ? 2 : 1;
    }
    return first;
}

static const double *row_of(const double *basis, const Entry *entries, int id, Py_ssize_t columns,
                            const double *zero)
{
    return id < 0 ? zero : basis + entries[id].sample * columns;
}

/* Derivatives of T/mu of all entries up to `count` along directions of place and step.
 *
 * With A of a row the derivative of what it holds beyond a fixed separation, a slip from a parent row
 * k to the front q has A = A[k] - N'(q) (dp - dp[k]) for places p and, for separations d,
 * A = A[k] - N'(q) (s dd - s[k] dd[k]), and dT = A + s N'(d) dd; THEORY, section 15. A parent that
 * stuck shifts with both of its ends. */
static void derive_cycle(Cycle *c, Py_ssize_t count, const double *by_place, Py_ssize_t places,
                         const double *by_step, Py_ssize_t steps, const double *zero)
{
    Py_ssize_t columns = places + steps;
    const Entry *entries = c->entries;
    for (Py_ssize_t i = 0; i < count; i++) {
        const Entry *e = &entries[i];
        const double *u = by_place + e->sample * places, *v = by_step + e->sample * steps;
        double *ahead = c->ahead + i * columns, *slope = c->slopes + i * columns;
        double F = e->fall, D = e->density, here = e->here;
        if (e->sticks) {
            int l = e->before;
            const double *u0 = row_of(by_place, entries, l, places, zero);
            const double *v0 = row_of(by_step, entries, l, steps, zero);
            const double *before = l < 0 ? zero : c->slopes + (Py_ssize_t)l * columns;
            double there = l < 0 ? 0.0 : entries[l].here;
            for (Py_ssize_t k = 0; k < places; k++) {
                ahead[k] = before[k];
                slope[k] = ahead[k] + F * (u[k] - u0[k]);
            }
            for (Py_ssize_t k = 0; k < steps; k++) {
                ahead[places + k] = before[places + k] + D * there * v0[k];
                slope[places + k] = ahead[places + k] + D * (F * (v[k] - v0[k]) - here * v[k]);
            }
            continue;
        }
        int k0 = e->parent;
        const double *from = k0 < 0 ? zero : c->ahead + (Py_ssize_t)k0 * columns;
        const double *u0 = row_of(by_place, entries, k0, places, zero);
        const double *v0 = row_of(by_step, entries, k0, steps, zero);
        double old = k0 < 0 ? 0.0 : entries[k0].density;
        if (k0 < 0 || !entries[k0].sticks) {
            for (Py_ssize_t k = 0; k < places; k++) ahead[k] = from[k] + F * (u[k] - u0[k]);
            for (Py_ssize_t k = 0; k < steps; k++)
                ahead[places + k] = from[places + k] + F * (D * v[k] - old * v0[k]);
        } else {
            int l = entries[k0].before;
            const double *u1 = row_of(by_place, entries, l, places, zero);
            const double *v1 = row_of(by_step, entries, l, steps, zero);
            double r = e->share, g = e->gain;
            for (Py_ssize_t k = 0; k < places; k++)
                ahead[k] = from[k] + g * (u0[k] - u1[k]) +
                           F * (u[k] - ((1.0 - r) * u1[k] + r * u0[k]));
            for (Py_ssize_t k = 0; k < steps; k++)
                ahead[places + k] = from[places + k] + old * g * (v0[k] - v1[k]) +
                                    F * (D * v[k] - old * ((1.0 - r) * v1[k] + r * v0[k]));
        }
        for (Py_ssize_t k = 0; k < places; k++) slope[k] = ahead[k];
        for (Py_ssize_t k = 0; k < steps; k++)
            slope[places + k] = ahead[places + k] - D * here * v[k];
    }
}

/* T/mu, N and d(T/mu)/d(place) at every sample; without steps all nodes stay at rest. */
static int run_field_cycle(const Argument *a, Result *out)
{
    Py_ssize_t nodes = a[2].n, samples = a[3].n, n = nodes * samples;
    const double *place = a[0].reals, *step = a[1].reals;
    Cycle c = {0};
    if (samples < 1 || samples >= INT_MAX / 4 || a[0].n < n || (step && a[1].n < n) ||
        !all_have(a, 4, 6, n))
        return TOO_SHORT;
    if (!make_cycle(&c, samples, 0)) return NO_MEMORY;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        Py_ssize_t at = i * samples;
        walk_cycle(a[7].curve, &c, a[2].reals[i], samples, place + at, step ? step + at : NULL,
                   a[4].reals + at, a[5].reals + at, a[6].reals + at);
    }
    free(c.memory);
    return FINE;
}

/* Sums over the samples of a settled cycle with weights (samples, rows): of T/mu and N, and of their
 * derivatives (rows, places + steps) and (rows, steps). Without rows the derivatives themselves. */
static void sum_cycle(const Cycle *c, Py_ssize_t first, Py_ssize_t samples, Py_ssize_t rows,
                      Py_ssize_t columns, Py_ssize_t steps, const double *w, const double *by_step,
                      const double *value, const double *load, double *sum, double *J,
                      double *load_sum, double *K)
{
    memset(J, 0, (size_t)((rows ? rows : samples) * columns) * sizeof(double));
    memset(K, 0, (size_t)((rows ? rows : samples) * steps) * sizeof(double));
    for (Py_ssize_t k = 0; k < rows; k++) sum[k] = load_sum[k] = 0.0;
    for (Py_ssize_t id = first; id < first + samples; id++) {
        const Entry *e = &c->entries[id];
        Py_ssize_t t = e->sample;
        const double *slope = c->slopes + id * columns, *turn = by_step + t * steps;
        if (!rows) {
            for (Py_ssize_t k = 0; k < columns; k++) J[t * columns + k] = slope[k];
            for (Py_ssize_t k = 0; k < steps; k++) K[t * steps + k] = -e->here * turn[k];
            continue;
        }
        for (Py_ssize_t r = 0; r < rows; r++) {
            double weight = w[t * rows + r], *row = J + r * columns;
            sum[r] += weight * value[t];
            load_sum[r] += weight * load[t];
            for (Py_ssize_t k = 0; k < columns; k++) row[k] += weight * slope[k];
            for (Py_ssize_t k = 0; k < steps; k++) K[r * steps + k] -= weight * e->here * turn[k];
        }
    }
}

static int run_field_slopes(const Argument *a, Result *out)
{
    Py_ssize_t nodes = a[2].n, samples = a[3].n, places = a[5].n, steps = a[7].n, rows = a[10].n;
    Py_ssize_t columns = places + steps, kept = rows ? rows : samples, stride = a[8].n;
    Py_ssize_t sets = stride ? nodes : 1, n = nodes * samples;
    const double *place = a[0].reals, *step = a[1].reals;
    Cycle c = {0};
    if (samples < 1 || samples >= INT_MAX / 4 || places < 0 || steps < 0 || rows < 0 ||
        a[0].n < n || (step && a[1].n < n) || a[4].n < sets * samples * places ||
        a[6].n < sets * samples * steps || a[9].n < samples * rows || a[11].n < nodes * rows ||
        a[12].n < nodes * kept * columns || a[13].n < nodes * rows ||
        a[14].n < nodes * kept * steps)
        return TOO_SHORT;
    double *zero = calloc((size_t)columns + 1, sizeof(double));
    double *value = malloc(2 * (size_t)samples * sizeof(double)), *load = value + samples;
    int there = make_cycle(&c, samples, columns) && zero && value;
    for (Py_ssize_t i = 0; there && i < nodes; i++) {
        const double *u = a[4].reals, *v = a[6].reals;
        if (stride) {
            u += i * samples * places;
            v += i * samples * steps;
        }
        Py_ssize_t first =
            walk_cycle(a[15].curve, &c, a[2].reals[i], samples, place + i * samples,
                       step ? step + i * samples : NULL, value, load, NULL);
        derive_cycle(&c, first + samples, u, places, v, steps, zero);
        sum_cycle(&c, first, samples, rows, columns, steps, a[9].reals, v, value, load,
                  a[11].reals + i * rows, a[12].reals + i * kept * columns,
                  a[13].reals + i * rows, a[14].reals + i * kept * steps);
    }
    free(c.memory);
    free(zero);
    free(value);
    return there ? FINE : NO_MEMORY;
}
