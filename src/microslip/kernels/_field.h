/* Many nodes on one load curve: see twin_field.py for what each function means. Part of _compiled.c.
 *
 * Places and steps count from each node's own rest. A row of a diagram has a mark beside it: T/mu
 * of the step that made the row, and the step itself. They never change, also where the row is
 * cut; at a held load one difference of N then gives the value of a move.
 */

static PyObject *py_excesses(PyObject *self, PyObject *args)
{
    Py_buffer base, width, excess, coefficients;
    Profile p;
    if (!PyArg_ParseTuple(args, "y*y*w*" PROFILE_FORMAT, &base, &width, &excess,
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    const double *bases = base.buf, *widths = width.buf;
    double *out = excess.buf;
    Py_ssize_t n = LENGTH(base);
    int right = long_enough(bind_profile(&p, &coefficients) && LENGTH(width) >= n &&
                            LENGTH(excess) >= n);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) out[i] = excess_at(&p, bases[i], widths[i]);
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&base);
    PyBuffer_Release(&width);
    PyBuffer_Release(&excess);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return none();
}

typedef struct {
    double value, base;
} Mark;

/* A move: rows that stay, front, D and kind as of step_front, T/mu, -dN/d(eta) by which it grows. */
typedef struct {
    Py_ssize_t depth;
    int kind;
    double front, density, value, fall;
} Move;

static inline double fall_at(const Profile *p, double x)
{
    double s;
    Py_ssize_t panel = find_panel(p, (x - p->anchor) * p->inverse_width, &s);
    if (panel >= p->panels) return 0.0;
    return -2.0 * p->inverse_width * curve_slope(panel_at(p, panel), s);
}

static inline void make_move(const Profile *p, double rest, const Row *rows, const Mark *marks,
                             Py_ssize_t depth, double last_step, double last_place,
                             double last_value, double step, double place, Move *m)
{
    m->depth = step_front(step, place, rows, depth, last_step, last_place, &m->front, &m->density,
                          &m->kind);
    double drop = m->front > step ? drop_at(p, rest + step, m->front - step) : 0.0;
    if (m->kind == 0) {
        m->value = last_value;
        if (m->front > step) { /* new contact sticks */
            m->value += m->density * drop;
            m->fall = drop / (m->front - step);
        } else { /* it stays where it is: what last slipped would go on */
            const Row *top = m->depth ? &rows[m->depth - 1] : NULL;
            m->fall = fall_at(p, rest + (top && fabs(top->density) == 1.0 ? top->end : step));
        }
        return;
    }
    m->value = m->density * drop;
    m->fall = fall_at(p, rest + m->front);
    if (!m->depth) return;
    const Row *row = &rows[m->depth - 1];
    const Mark *mark = &marks[m->depth - 1];
    if (mark->base == step)
        m->value = mark->value + (m->density - row->density) * drop;
    else
        m->value += mark->value -
                    row->density * drop_at(p, rest + mark->base, m->front - mark->base);
}

/* The rows need room for one more. */
static inline Py_ssize_t take_move(Row *rows, Mark *marks, double last_place, double step,
                                   const Move *m)
{
    Py_ssize_t depth = m->depth;
    double beyond = last_place;
    if (!(m->front > step)) return depth;
    if (m->kind) {
        beyond = 0.0;
        if (depth) {
            const Row *row = &rows[depth - 1];
            beyond = row->density * (row->end - m->front) + row->beyond;
        }
    }
    rows[depth].end = m->front;
    rows[depth].density = m->density;
    rows[depth].beyond = beyond;
    marks[depth].value = m->value;
    marks[depth].base = step;
    return depth + 1;
}

/* ---- settled cycles ------------------------------------------------------------------------- */

/* How a move depends on what came before it: entry i of a cycle, at sample t of it. */
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
    if (!at) {
        PyErr_NoMemory();
        return 0;
    }
    c->rows = (Row *)at;
    c->marks = (Mark *)(at += n * sizeof(Row));
    c->entries = (Entry *)(at += n * sizeof(Mark));
    c->ids = (int *)(at += n * sizeof(Entry));
    c->ahead = (double *)(at += n * sizeof(double));
    c->slopes = columns ? (double *)(at + n * (size_t)columns * sizeof(double)) : NULL;
    return 1;
}

/* Writes down how a move depends on what came before it, before it is made. */
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
    if (m->kind == 0) { /* it stays where it is */
        int slid = k >= 0 && fabs(c->rows[k].density) == 1.0;
        e->density = slid ? c->rows[k].density : 1.0;
        front = slid ? c->rows[k].end : step;
        k -= slid;
    } else if (m->kind == 2) {
        e->density = 1.0; /* of no account: it slips by nothing */
    }
    if (k < 0) return;
    e->parent = c->ids[k];
    const Entry *parent = &c->entries[e->parent];
    if (!parent->sticks) return;
    double left = c->rows[k].end - front;
    e->share = left / parent->width;
    e->gain = drop_at(p, rest + front, left) / parent->width;
}

/* One settled cycle. Returns the entry at which it begins: 0, or `samples` after a second pass. */
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
        /* Where the root lies within what it pressed down sticking, a pass more settles it. */
        passes = sticks ? 2 : 1;
    }
    return first;
}

static const double *row_of(const double *basis, const Entry *entries, int id, Py_ssize_t columns,
                            const double *zero)
{
    return id < 0 ? zero : basis + entries[id].sample * columns;
}

/* Derivatives of T/mu of all entries up to `count` along directions of place and step. */
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

static PyObject *py_field_cycle(PyObject *self, PyObject *args)
{
    Py_buffer place, step = {0}, rest, value, load, slope, coefficients;
    PyObject *step_object;
    Py_ssize_t samples;
    Profile p;
    Cycle c = {0};
    if (!PyArg_ParseTuple(args, "y*Oy*nw*w*w*" PROFILE_FORMAT, &place, &step_object, &rest,
                          &samples, &value, &load, &slope, PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    int right = step_object == Py_None || PyObject_GetBuffer(step_object, &step, PyBUF_SIMPLE) == 0;
    Py_ssize_t nodes = LENGTH(rest), n = nodes * samples;
    if (right)
        right = long_enough(bind_profile(&p, &coefficients) && samples > 0 &&
                            samples < INT_MAX / 4 && LENGTH(place) >= n &&
                            (!step.obj || LENGTH(step) >= n) && LENGTH(value) >= n &&
                            LENGTH(load) >= n && LENGTH(slope) >= n);
    if (right) right = make_cycle(&c, samples, 0);
    if (!right) nodes = 0;
    const double *rests = rest.buf, *steps = step.obj ? step.buf : NULL;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < nodes; i++) {
        Py_ssize_t at = i * samples;
        walk_cycle(&p, &c, rests[i], samples, (const double *)place.buf + at,
                   steps ? steps + at : NULL, (double *)value.buf + at, (double *)load.buf + at,
                   (double *)slope.buf + at);
    }
    Py_END_ALLOW_THREADS
    free(c.memory);
    PyBuffer_Release(&place);
    if (step.obj) PyBuffer_Release(&step);
    PyBuffer_Release(&rest);
    PyBuffer_Release(&value);
    PyBuffer_Release(&load);
    PyBuffer_Release(&slope);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return none();
}

/* Both kinds of derivatives: with weights, sums over the samples; without, all of them. */
static PyObject *py_field_slopes(PyObject *self, PyObject *args)
{
    Py_buffer place, step = {0}, rest, by_place, by_step, weights, spectrum, jacobian,
        load_spectrum, load_jacobian, coefficients;
    PyObject *step_object;
    Py_ssize_t samples, places, steps, rows, stride;
    Profile p;
    Cycle c = {0};
    if (!PyArg_ParseTuple(args, "y*Oy*ny*ny*nny*nw*w*w*w*" PROFILE_FORMAT, &place, &step_object,
                          &rest, &samples, &by_place, &places, &by_step, &steps, &stride, &weights,
                          &rows, &spectrum, &jacobian, &load_spectrum, &load_jacobian,
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    int right = step_object == Py_None || PyObject_GetBuffer(step_object, &step, PyBUF_SIMPLE) == 0;
    Py_ssize_t nodes = LENGTH(rest), columns = places + steps, kept = rows ? rows : samples;
    Py_ssize_t sets = stride ? nodes : 1;
    if (right)
        right = long_enough(
            bind_profile(&p, &coefficients) && samples > 0 && samples < INT_MAX / 4 &&
            places >= 0 && steps >= 0 && rows >= 0 && LENGTH(place) >= nodes * samples &&
            (!step.obj || LENGTH(step) >= nodes * samples) &&
            LENGTH(by_place) >= sets * samples * places &&
            LENGTH(by_step) >= sets * samples * steps && LENGTH(weights) >= samples * rows &&
            LENGTH(spectrum) >= nodes * rows && LENGTH(jacobian) >= nodes * kept * columns &&
            LENGTH(load_spectrum) >= nodes * rows &&
            LENGTH(load_jacobian) >= nodes * kept * steps);
    if (right) right = make_cycle(&c, samples, columns);
    double *zero = right ? calloc((size_t)columns + 1, sizeof(double)) : NULL;
    double *value = right ? malloc(2 * (size_t)samples * sizeof(double)) : NULL;
    if (right && (!zero || !value)) {
        PyErr_NoMemory();
        right = 0;
    }
    if (!right) nodes = 0;
    double *load = value + samples;
    const double *rests = rest.buf, *w = weights.buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < nodes; i++) {
        const double *x = (const double *)place.buf + i * samples;
        const double *d = step.obj ? (const double *)step.buf + i * samples : NULL;
        const double *u = by_place.buf, *v = by_step.buf;
        if (stride) {
            u += i * samples * places;
            v += i * samples * steps;
        }
        Py_ssize_t first = walk_cycle(&p, &c, rests[i], samples, x, d, value, load, NULL);
        derive_cycle(&c, first + samples, u, places, v, steps, zero);
        double *J = (double *)jacobian.buf + i * kept * columns;
        double *K = (double *)load_jacobian.buf + i * kept * steps;
        double *sum = (double *)spectrum.buf + i * rows;
        double *load_sum = (double *)load_spectrum.buf + i * rows;
        for (Py_ssize_t k = 0; k < rows; k++) sum[k] = load_sum[k] = 0.0;
        if (rows) {
            for (Py_ssize_t k = 0; k < rows * columns; k++) J[k] = 0.0;
            for (Py_ssize_t k = 0; k < rows * steps; k++) K[k] = 0.0;
        }
        for (Py_ssize_t id = first; id < first + samples; id++) {
            const Entry *e = &c.entries[id];
            Py_ssize_t t = e->sample;
            const double *slope = c.slopes + id * columns, *turn = v + t * steps;
            if (!rows) {
                for (Py_ssize_t k = 0; k < columns; k++) J[t * columns + k] = slope[k];
                for (Py_ssize_t k = 0; k < steps; k++) K[t * steps + k] = -e->here * turn[k];
                continue;
            }
            for (Py_ssize_t r = 0; r < rows; r++) {
                double a = w[t * rows + r], *row = J + r * columns;
                sum[r] += a * value[t];
                load_sum[r] += a * load[t];
                for (Py_ssize_t k = 0; k < columns; k++) row[k] += a * slope[k];
                for (Py_ssize_t k = 0; k < steps; k++) K[r * steps + k] -= a * e->here * turn[k];
            }
        }
    }
    Py_END_ALLOW_THREADS
    free(c.memory);
    free(zero);
    free(value);
    PyBuffer_Release(&place);
    if (step.obj) PyBuffer_Release(&step);
    PyBuffer_Release(&rest);
    PyBuffer_Release(&by_place);
    PyBuffer_Release(&by_step);
    PyBuffer_Release(&weights);
    PyBuffer_Release(&spectrum);
    PyBuffer_Release(&jacobian);
    PyBuffer_Release(&load_spectrum);
    PyBuffer_Release(&load_jacobian);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return none();
}

/* ---- states --------------------------------------------------------------------------------- */

/* Rows and marks of node i begin at entry begin[i], and there are so many. */
static int rows_fit(const Py_buffer *rows, const Py_buffer *marks, const Py_buffer *begin,
                    const Py_buffer *count, Py_ssize_t nodes)
{
    const long long *b = begin->buf, *n = count->buf;
    if (LENGTH(*begin) < nodes || LENGTH(*count) < nodes) return 0;
    long long most = LENGTH(*rows) / 3 < LENGTH(*marks) / 2 ? LENGTH(*rows) / 3 : LENGTH(*marks) / 2;
    for (Py_ssize_t i = 0; i < nodes; i++)
        if (b[i] < 0 || n[i] < 0 || n[i] > most || b[i] > most - n[i]) return 0;
    return 1;
}

static PyObject *py_field_try(PyObject *self, PyObject *args)
{
    enum { PLACE, REST, LAST_PLACE, LAST_STEP, LAST_VALUE, ROWS, MARKS, BEGIN, DEPTH,
           FRONT, DENSITY, VALUE, CODE, BY_PLACE, COUNT };
    Py_buffer b[COUNT], step = {0}, load = {0}, fall = {0}, by_step = {0}, coefficients;
    PyObject *step_object, *varied[3];
    Profile p;
    if (!PyArg_ParseTuple(args, "y*Oy*y*y*y*y*y*y*y*w*w*w*w*w*OOO" PROFILE_FORMAT, &b[PLACE],
                          &step_object, &b[REST], &b[LAST_PLACE], &b[LAST_STEP], &b[LAST_VALUE],
                          &b[ROWS], &b[MARKS], &b[BEGIN], &b[DEPTH], &b[FRONT], &b[DENSITY],
                          &b[VALUE], &b[CODE], &b[BY_PLACE], &varied[0], &varied[1], &varied[2],
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    Py_ssize_t nodes = LENGTH(b[PLACE]);
    int right = 1, varies = step_object != Py_None;
    if (varies)
        right = PyObject_GetBuffer(step_object, &step, PyBUF_SIMPLE) == 0 &&
                PyObject_GetBuffer(varied[0], &load, PyBUF_WRITABLE) == 0 &&
                PyObject_GetBuffer(varied[1], &fall, PyBUF_WRITABLE) == 0 &&
                PyObject_GetBuffer(varied[2], &by_step, PyBUF_WRITABLE) == 0;
    if (right) {
        right = bind_profile(&p, &coefficients) &&
                rows_fit(&b[ROWS], &b[MARKS], &b[BEGIN], &b[DEPTH], nodes);
        for (int k = 0; k < COUNT; k++)
            if (k != ROWS && k != MARKS) right = right && LENGTH(b[k]) >= nodes;
        if (varies)
            right = right && LENGTH(step) >= nodes && LENGTH(load) >= nodes &&
                    LENGTH(fall) >= nodes && LENGTH(by_step) >= nodes;
        right = long_enough(right);
    }
    if (!right) nodes = 0;
    const double *x = b[PLACE].buf, *rest = b[REST].buf, *last_place = b[LAST_PLACE].buf,
                 *last_step = b[LAST_STEP].buf, *last_value = b[LAST_VALUE].buf, *d = step.buf;
    const Row *rows = b[ROWS].buf;
    const Mark *marks = b[MARKS].buf;
    const long long *begin = b[BEGIN].buf, *depth = b[DEPTH].buf;
    double *front = b[FRONT].buf, *density = b[DENSITY].buf, *value = b[VALUE].buf,
           *by_place = b[BY_PLACE].buf, *loads = load.buf, *falls = fall.buf, *turns = by_step.buf;
    long long *code = b[CODE].buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < nodes; i++) {
        const Row *own = rows + begin[i];
        double now = varies ? d[i] : last_step[i];
        Move m;
        make_move(&p, rest[i], own, marks + begin[i], (Py_ssize_t)depth[i], last_step[i],
                  last_place[i], last_value[i], now, x[i], &m);
        front[i] = m.front;
        density[i] = m.density;
        value[i] = m.value;
        code[i] = 4 * (long long)m.depth + m.kind;
        by_place[i] = m.fall;
        if (varies) {
            double here, turn = m.density;
            loads[i] = load_at(&p, rest[i] + now, &here);
            if (!m.kind && !(m.front > now) && m.depth && fabs(own[m.depth - 1].density) == 1.0)
                turn = own[m.depth - 1].density; /* what last slipped would go on */
            falls[i] = here;
            turns[i] = turn * (m.fall - here);
        }
    }
    Py_END_ALLOW_THREADS
    for (int k = 0; k < COUNT; k++) PyBuffer_Release(&b[k]);
    PyBuffer_Release(&coefficients);
    if (step.obj) PyBuffer_Release(&step);
    if (load.obj) PyBuffer_Release(&load);
    if (fall.obj) PyBuffer_Release(&fall);
    if (by_step.obj) PyBuffer_Release(&by_step);
    if (!right) return NULL;
    return none();
}

static PyObject *py_field_commit(PyObject *self, PyObject *args)
{
    enum { PLACE, FRONT, DENSITY, VALUE, CODE, BEGIN, ROOM, LAST_PLACE, LAST_STEP, LAST_VALUE, ROWS,
           MARKS, DEPTH, COUNT };
    Py_buffer b[COUNT], step = {0};
    PyObject *step_object;
    if (!PyArg_ParseTuple(args, "y*Oy*y*y*y*y*y*w*w*w*w*w*w*", &b[PLACE], &step_object, &b[FRONT],
                          &b[DENSITY], &b[VALUE], &b[CODE], &b[BEGIN], &b[ROOM], &b[LAST_PLACE],
                          &b[LAST_STEP], &b[LAST_VALUE], &b[ROWS], &b[MARKS], &b[DEPTH]))
        return NULL;
    Py_ssize_t nodes = LENGTH(b[PLACE]);
    int right = 1;
    if (step_object != Py_None)
        right = PyObject_GetBuffer(step_object, &step, PyBUF_SIMPLE) == 0;
    const double *x = b[PLACE].buf, *d = step.obj ? step.buf : b[LAST_STEP].buf,
                 *front = b[FRONT].buf, *density = b[DENSITY].buf, *value = b[VALUE].buf;
    const long long *code = b[CODE].buf, *begin = b[BEGIN].buf, *room = b[ROOM].buf;
    double *last_place = b[LAST_PLACE].buf, *last_step = b[LAST_STEP].buf,
           *last_value = b[LAST_VALUE].buf;
    Row *rows = b[ROWS].buf;
    Mark *marks = b[MARKS].buf;
    long long *depth = b[DEPTH].buf;
    if (right) {
        right = rows_fit(&b[ROWS], &b[MARKS], &b[BEGIN], &b[ROOM], nodes) &&
                (!step.obj || LENGTH(step) >= nodes);
        for (int k = 0; k < COUNT; k++)
            if (k != ROWS && k != MARKS) right = right && LENGTH(b[k]) >= nodes;
        for (Py_ssize_t i = 0; right && i < nodes; i++)
            right = code[i] >= 0 && code[i] / 4 <= depth[i] &&
                    code[i] / 4 + (front[i] > d[i]) <= room[i];
        right = long_enough(right);
    }
    if (!right) nodes = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < nodes; i++) {
        Move m = {(Py_ssize_t)(code[i] / 4), (int)(code[i] % 4), front[i], density[i], value[i], 0};
        double now = d[i];
        depth[i] = take_move(rows + begin[i], marks + begin[i], last_place[i], now, &m);
        last_place[i] = x[i];
        last_step[i] = now;
        last_value[i] = value[i];
    }
    Py_END_ALLOW_THREADS
    for (int k = 0; k < COUNT; k++) PyBuffer_Release(&b[k]);
    if (step.obj) PyBuffer_Release(&step);
    if (!right) return NULL;
    return none();
}

static PyObject *py_field_losses(PyObject *self, PyObject *args)
{
    enum { PLACE, STEP, REST, CODE, LAST_PLACE, LAST_STEP, BEGIN, DEPTH, RULES_, ROWS, LOSS, COUNT };
    Py_buffer b[COUNT], coefficients;
    Profile p;
    if (!PyArg_ParseTuple(args, "y*y*y*y*y*y*y*y*y*w*w*" PROFILE_FORMAT, &b[PLACE], &b[STEP],
                          &b[REST], &b[CODE], &b[LAST_PLACE], &b[LAST_STEP], &b[BEGIN], &b[DEPTH],
                          &b[RULES_], &b[ROWS], &b[LOSS], PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    Py_ssize_t nodes = LENGTH(b[PLACE]);
    const long long *begin = b[BEGIN].buf, *depth = b[DEPTH].buf, *code = b[CODE].buf;
    int right = bind_profile(&p, &coefficients) && LENGTH(b[RULES_]) >= RULES_LENGTH &&
                LENGTH(b[BEGIN]) >= nodes && LENGTH(b[DEPTH]) >= nodes;
    for (int k = 0; k < COUNT; k++)
        if (k != RULES_ && k != ROWS) right = right && LENGTH(b[k]) >= nodes;
    for (Py_ssize_t i = 0; right && i < nodes; i++)
        right = begin[i] >= 0 && depth[i] >= 0 && begin[i] + depth[i] <= LENGTH(b[ROWS]) / 3;
    right = long_enough(right);
    if (!right) nodes = 0;
    const double *x = b[PLACE].buf, *d = b[STEP].buf, *rest = b[REST].buf,
                 *last_place = b[LAST_PLACE].buf, *last_step = b[LAST_STEP].buf;
    double *loss = b[LOSS].buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < nodes; i++) {
        Diagram g = {(Row *)b[ROWS].buf + begin[i], NULL, (Py_ssize_t)depth[i], last_step[i],
                     last_place[i], 0.0};
        Profile own = p;
        own.anchor -= rest[i];
        loss[i] = code[i] % 4 ? step_loss(&own, b[RULES_].buf, &g, d[i], x[i] - g.place) : 0.0;
    }
    Py_END_ALLOW_THREADS
    for (int k = 0; k < COUNT; k++) PyBuffer_Release(&b[k]);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return none();
}
