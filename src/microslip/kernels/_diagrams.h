/* Memory diagrams: records under a load that varies, their losses, and force control. Part of _compiled.c. */

/* ---- memory diagrams -------------------------------------------------------------------- */

typedef struct {
    double end, density, beyond;
} Row;

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
    if (fall >= 0.0) {
        sign = move > 0.0 ? 1.0 : -1.0;
        *q = last_separation;
    } else {
        while (depth && stack[depth - 1].end <= separation) depth--;
        double held = 0.0;
        if (depth) {
            const Row *row = &stack[depth - 1];
            held = row->density * (row->end - separation) + row->beyond;
        }
        *q = separation;
        if (place == held) {
            *density = 0.0;
            *kind = 2;
            return depth;
        }
        sign = place > held ? 1.0 : -1.0;
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

static PyObject *py_step_front(PyObject *self, PyObject *args)
{
    Py_buffer stack;
    Py_ssize_t depth;
    double separation, place, last_separation, last_place, q = 0.0, density = 0.0;
    int kind = 0;
    if (!PyArg_ParseTuple(args, "ddy*ndd", &separation, &place, &stack, &depth, &last_separation,
                          &last_place))
        return NULL;
    int right = long_enough(depth >= 0 && depth <= LENGTH(stack) / 3);
    if (right)
        depth = step_front(separation, place, stack.buf, depth, last_separation, last_place, &q,
                           &density, &kind);
    PyBuffer_Release(&stack);
    if (!right) return NULL;
    return Py_BuildValue("nddi", depth, q, density, kind);
}

static PyObject *py_diagram(PyObject *self, PyObject *args)
{
    Py_buffer separation, place, base, width, density, parent, top, stack_buffer, code_buffer;
    Py_ssize_t depth, count = 0;
    double last_separation, last_place;
    if (!PyArg_ParseTuple(args, "y*y*w*w*w*w*w*w*w*ndd", &separation, &place, &base, &width,
                          &density, &parent, &top, &stack_buffer, &code_buffer, &depth,
                          &last_separation, &last_place))
        return NULL;
    const double *ds = separation.buf, *xs = place.buf;
    double *bases = base.buf, *widths = width.buf, *densities = density.buf;
    long long *parents = parent.buf, *tops = top.buf, *codes = code_buffer.buf;
    Row *stack = stack_buffer.buf;
    Py_ssize_t n = LENGTH(separation);
    int right = long_enough(LENGTH(place) >= n && LENGTH(base) >= 2 * n && LENGTH(width) >= 2 * n &&
                            LENGTH(density) >= 2 * n && LENGTH(parent) >= 2 * n &&
                            LENGTH(top) >= n && depth >= 0 &&
                            depth <= LENGTH(stack_buffer) / 3 - n &&
                            depth <= LENGTH(code_buffer) - n);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        double d = ds[i], x = xs[i], q, D, outer = 0.0;
        int kind;
        depth = step_front(d, x, stack, depth, last_separation, last_place, &q, &D, &kind);
        if (depth) {
            const Row *row = &stack[depth - 1];
            outer = row->density * (row->end - q) + row->beyond;
            if (kind) {
                bases[count] = q;
                widths[count] = row->end - q;
                densities[count] = row->density;
                parents[count] = depth > 1 ? codes[depth - 2] : -1;
                codes[depth - 1] = count++;
            }
        }
        if (q > d) {
            bases[count] = d;
            widths[count] = q - d;
            densities[count] = D;
            parents[count] = depth ? codes[depth - 1] : -1;
            stack[depth].end = q;
            stack[depth].density = D;
            stack[depth].beyond = kind == 0 ? last_place : outer;
            codes[depth++] = count++;
        }
        tops[i] = depth ? codes[depth - 1] : -1;
        last_separation = d;
        last_place = x;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&separation);
    PyBuffer_Release(&place);
    PyBuffer_Release(&base);
    PyBuffer_Release(&width);
    PyBuffer_Release(&density);
    PyBuffer_Release(&parent);
    PyBuffer_Release(&top);
    PyBuffer_Release(&stack_buffer);
    PyBuffer_Release(&code_buffer);
    if (!right) return NULL;
    return Py_BuildValue("nndd", depth, count, last_separation, last_place);
}

/* The steps of a record from rest, each by what it ends on, see trace() of twin_diagram.py. */
static PyObject *py_trace(PyObject *self, PyObject *args)
{
    Py_buffer separation, place, front, density, kind_buffer, parent, stack_buffer, code_buffer;
    if (!PyArg_ParseTuple(args, "y*y*w*w*w*w*w*w*", &separation, &place, &front, &density,
                          &kind_buffer, &parent, &stack_buffer, &code_buffer))
        return NULL;
    const double *ds = separation.buf, *xs = place.buf;
    double *fronts = front.buf, *densities = density.buf, last_separation = 0.0, last_place = 0.0;
    long long *kinds = kind_buffer.buf, *parents = parent.buf, *codes = code_buffer.buf;
    Row *stack = stack_buffer.buf;
    Py_ssize_t n = LENGTH(separation), depth = 0;
    int right = long_enough(LENGTH(place) >= n && LENGTH(front) >= n && LENGTH(density) >= n &&
                            LENGTH(kind_buffer) >= n && LENGTH(parent) >= n &&
                            LENGTH(stack_buffer) / 3 >= n && LENGTH(code_buffer) >= n);
    if (!right) n = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        double d = ds[i], x = xs[i], outer = 0.0;
        int kind;
        if (i && d == last_separation && x == last_place) { /* no step: where the last one ended */
            fronts[i] = fronts[i - 1];
            densities[i] = densities[i - 1];
            kinds[i] = kinds[i - 1];
            parents[i] = parents[i - 1];
            continue;
        }
        depth = step_front(d, x, stack, depth, last_separation, last_place, &fronts[i],
                           &densities[i], &kind);
        kinds[i] = kind;
        parents[i] = kind == 0 ? i - 1 : depth ? codes[depth - 1] : -1;
        if (depth) {
            const Row *row = &stack[depth - 1];
            outer = row->density * (row->end - fronts[i]) + row->beyond;
        }
        if (fronts[i] > d) {
            stack[depth].end = fronts[i];
            stack[depth].density = densities[i];
            stack[depth].beyond = kind == 0 ? last_place : outer;
            codes[depth++] = i;
        }
        last_separation = d;
        last_place = x;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&separation);
    PyBuffer_Release(&place);
    PyBuffer_Release(&front);
    PyBuffer_Release(&density);
    PyBuffer_Release(&kind_buffer);
    PyBuffer_Release(&parent);
    PyBuffer_Release(&stack_buffer);
    PyBuffer_Release(&code_buffer);
    if (!right) return NULL;
    return none();
}

/* ---- memory diagrams with a load curve ---------------------------------------------------- */

typedef struct {
    Row *stack;
    double *values;
    Py_ssize_t depth;
    double separation, place, value;
} Diagram;

/* A step up to its value: rows that stay, front, D, kind, value, share of the rows that stay. */
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

/* The stack must have room for one row more. */
static inline void push(Diagram *g, double separation, double place, const Step *step)
{
    double beyond = 0.0;
    g->depth = step->depth;
    if (g->depth) {
        const Row *row = &g->stack[g->depth - 1];
        beyond = row->density * (row->end - step->front) + row->beyond;
        g->values[g->depth - 1] = step->outer;
    }
    if (step->front > separation) {
        Row *row = &g->stack[g->depth];
        row->end = step->front;
        row->density = step->density;
        row->beyond = step->kind == 0 ? g->place : beyond;
        g->values[g->depth++] = step->value;
    }
    g->separation = separation;
    g->place = place;
    g->value = step->value;
}

static PyObject *py_coupled(PyObject *self, PyObject *args)
{
    Py_buffer separation, place, value, stack, values, coefficients;
    Profile p;
    Diagram g = {0};
    if (!PyArg_ParseTuple(args, "y*y*w*w*w*ndd" PROFILE_FORMAT, &separation, &place, &value,
                          &stack, &values, &g.depth, &g.separation, &g.place,
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    const double *ds = separation.buf, *xs = place.buf;
    double *out = value.buf;
    Py_ssize_t n = LENGTH(separation);
    int right = long_enough(bind_profile(&p, &coefficients) && LENGTH(place) >= n &&
                            LENGTH(value) >= n && g.depth >= 0 &&
                            g.depth <= LENGTH(stack) / 3 - n && g.depth <= LENGTH(values) - n);
    if (!right) n = 0;
    g.stack = stack.buf;
    g.values = values.buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        Step step;
        probe(&p, &g, ds[i], xs[i], &step);
        push(&g, ds[i], xs[i], &step);
        out[i] = g.value;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&separation);
    PyBuffer_Release(&place);
    PyBuffer_Release(&value);
    PyBuffer_Release(&stack);
    PyBuffer_Release(&values);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return Py_BuildValue("ndd", g.depth, g.separation, g.place);
}

static PyObject *py_coupled_step(PyObject *self, PyObject *args)
{
    Py_buffer stack, values, coefficients;
    Profile p;
    Diagram g = {0};
    Step step = {0};
    double separation, place, fall = 0.0;
    if (!PyArg_ParseTuple(args, "ddy*y*ndd" PROFILE_FORMAT, &separation, &place, &stack, &values,
                          &g.depth, &g.separation, &g.place, PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    int right = long_enough(bind_profile(&p, &coefficients) && g.depth >= 0 &&
                            g.depth <= LENGTH(stack) / 3 && LENGTH(values) >= g.depth);
    if (right) {
        g.stack = stack.buf;
        g.values = values.buf;
        probe(&p, &g, separation, place, &step);
        if (step.kind == 1) {
            load_at(&p, step.front, &fall);
        } else if (step.front > separation) {
            fall = step.drop / (step.front - separation);
        } else {
            const Row *row = step.depth ? &g.stack[step.depth - 1] : NULL;
            int slipped = step.kind == 0 && row && fabs(row->density) == 1.0;
            load_at(&p, slipped ? row->end : separation, &fall);
        }
    }
    PyBuffer_Release(&stack);
    PyBuffer_Release(&values);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return Py_BuildValue("nddiddd", step.depth, step.front, step.density, step.kind, step.value,
                         step.outer, fall);
}

/* ---- what slip dissipates ------------------------------------------------------------------ */

static const double RULE_PANELS[] = {0.05, 1.0, 16.0};
static const int RULE_NODES[] = {4, 8, 16};
#define RULES_LENGTH 56 /* nodes and weights of all of them */

/* Mean loss of a run times its length, while the gap between front and separation goes from `gap` to
 * `until`. Past the end of the curve nothing depends on the front any more. */
static double run_piece(const Profile *p, const double *rules, int past, double ahead, double gap,
                        double until, double first, double last)
{
    double rise = last - first;
    if (!(ahead > 0.0)) return 0.0;
    double length = past ? 0.0 : ahead, parts = 1.0, total = 0.0;
    double turn = fmin(fabs(rise), 1e300);
    length = fmax(length, turn) * p->inverse_width;
    int rule = 0;
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

static double run_loss(const Profile *p, const double *rules, double ahead, double gap,
                       double until, double first, double last)
{
    double top = p->anchor + (double)(p->panels - p->first) / p->inverse_width;
    double rise = last - first;
    /* Where the separation is past it there is no load, and however far it goes no loss. */
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
    if (start >= top) return run_piece(p, rules, 1, ahead, gap, until, first, last);
    if (end <= top) return run_piece(p, rules, 0, ahead, gap, until, first, last);
    double share = (top - start) / (end - start), meanwhile = first + share * (last - first);
    double between = fmax(top - meanwhile, 0.0);
    return run_piece(p, rules, 0, share * ahead, gap, between, first, meanwhile) +
           run_piece(p, rules, 1, (1.0 - share) * ahead, between, until, meanwhile, last);
}

/* The runs of one step that slips, see runs() of twin_losses.py, and what they lose. */
static double step_loss(const Profile *p, const double *rules, const Diagram *g, double last,
                        double move)
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
            if (drive == 0.0) { /* what is lost takes just its share along */
                time = rise > 0.0 ? fmin((end - first) / rise, 1.0) : 1.0;
                here = end;
                row--;
                continue;
            }
            sign = (rise > 0.0 ? drive : move) > 0.0 ? 1.0 : -1.0;
        }
        double rate = 1.0 - sign * density;
        if (rate <= 0.0) { /* slips already */
            gap = end - here;
            row--;
            continue;
        }
        double growth = fmax(sign * drive / rate, -rise), speed = growth + rise; /* never back */
        double until = speed > 0.0 ? time + (end - here - gap) / speed : HUGE_VAL, then = until;
        int caught = growth < 0.0 && time - gap / growth <= fmin(until, 1.0);
        if (caught) then = time - gap / growth;
        then = fmin(then, 1.0);
        double there = then < 1.0 ? first + rise * then : last;
        double ahead = fmin(speed * (then - time), end - here - gap);
        double wide = caught ? 0.0 : fmax(gap + growth * (then - time), 0.0);
        if (!caught && until <= 1.0) { /* to the row's end: the pace may be rounding over rounding */
            row--;
            ahead = end - here - gap;
            wide = fmax(end - there, 0.0);
        }
        if (ahead > 0.0) total += rate * run_loss(p, rules, ahead, gap, wide, here, there);
        time = then;
        gap = wide;
        here = there;
    }
    return total;
}

static PyObject *py_losses(PyObject *self, PyObject *args)
{
    Py_buffer separation, place, loss, stack, rules, coefficients;
    Profile p;
    Diagram g = {0};
    if (!PyArg_ParseTuple(args, "y*y*w*w*nddy*" PROFILE_FORMAT, &separation, &place, &loss, &stack,
                          &g.depth, &g.separation, &g.place, &rules,
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    const double *ds = separation.buf, *xs = place.buf;
    double *out = loss.buf;
    Py_ssize_t n = LENGTH(separation);
    int right = long_enough(bind_profile(&p, &coefficients) && LENGTH(place) >= n &&
                            LENGTH(loss) >= n && g.depth >= 0 && LENGTH(rules) >= RULES_LENGTH &&
                            g.depth <= LENGTH(stack) / 3 - n);
    if (!right) n = 0;
    g.stack = stack.buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        double d = ds[i], x = xs[i], front, density, beyond = g.place;
        int kind;
        Py_ssize_t depth = step_front(d, x, g.stack, g.depth, g.separation, g.place, &front,
                                      &density, &kind);
        out[i] = kind ? step_loss(&p, rules.buf, &g, d, x - g.place) : 0.0;
        if (kind) {
            beyond = 0.0;
            if (depth) {
                const Row *row = &g.stack[depth - 1];
                beyond = row->density * (row->end - front) + row->beyond;
            }
        }
        if (front > d) {
            g.stack[depth].end = front;
            g.stack[depth].density = density;
            g.stack[depth++].beyond = beyond;
        }
        g.depth = depth;
        g.separation = d;
        g.place = x;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&separation);
    PyBuffer_Release(&place);
    PyBuffer_Release(&loss);
    PyBuffer_Release(&stack);
    PyBuffer_Release(&rules);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return none();
}

/* ---- force control -------------------------------------------------------------------------- */

static double solve_front(const Profile *p, double anchor, double wanted, double low, int before)
{
    double slope, there = load_at(p, anchor, &slope);
    /* The caller's own N may be a last place above this one: all but that much slips. */
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

static PyObject *py_hold(PyObject *self, PyObject *args)
{
    Py_buffer separation, value, place, stack, values, coefficients;
    Profile p;
    Diagram g = {0};
    if (!PyArg_ParseTuple(args, "y*y*w*w*w*nddd" PROFILE_FORMAT, &separation, &value, &place,
                          &stack, &values, &g.depth, &g.separation, &g.place, &g.value,
                          PROFILE_ARGUMENTS(coefficients, p)))
        return NULL;
    const double *ds = separation.buf, *vs = value.buf;
    double *out = place.buf;
    Py_ssize_t n = LENGTH(separation);
    int right = long_enough(bind_profile(&p, &coefficients) && LENGTH(value) >= n &&
                            LENGTH(place) >= n && g.depth >= 0 &&
                            g.depth <= LENGTH(stack) / 3 - n && g.depth <= LENGTH(values) - n);
    if (!right) n = 0;
    g.stack = stack.buf;
    g.values = values.buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < n; i++) {
        Step step;
        out[i] = place_of(&p, &g, ds[i], vs[i]);
        probe(&p, &g, ds[i], out[i], &step);
        push(&g, ds[i], out[i], &step);
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&separation);
    PyBuffer_Release(&value);
    PyBuffer_Release(&place);
    PyBuffer_Release(&stack);
    PyBuffer_Release(&values);
    PyBuffer_Release(&coefficients);
    if (!right) return NULL;
    return Py_BuildValue("nddd", g.depth, g.separation, g.place, g.value);
}
