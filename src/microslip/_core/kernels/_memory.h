/* The memory of a record at constant load: Masing's rules. Part of _compiled.c.
 *
 * A memory is the stack of open reversals, oldest first, with the last displacement and the
 * direction (-1, 0 or 1) of the last move. Empty, it stands for the first loading curve.
 */

/* Branch at the end of a move from `last` to x. Returns the new depth; *pushed is 1 if `last`
 * became the newest reversal. Entries of the stack are `stride` doubles apart. */
static inline Py_ssize_t locate(const double *stack, Py_ssize_t stride, Py_ssize_t depth,
                                double last, int *direction, double x, int *pushed)
{
    *pushed = 0;
    if (x == last) return depth;
    int way = x > last ? 1 : -1;
    int turned = *direction != 0 && way != *direction;
    *direction = way;
    if (turned) {
        /* With `last` on top: a move that reaches the reversal below closes the loop. */
        if (depth >= 1) {
            double close = stack[(depth - 1) * stride];
            if (!(way > 0 ? x >= close : x <= close)) {
                *pushed = 1;
                return depth + 1;
            }
            depth -= 1;
        } else {
            if (!(fabs(x) >= fabs(last))) {
                *pushed = 1;
                return 1;
            }
            return 0;
        }
    }
    while (depth > 1) {
        double close = stack[(depth - 2) * stride];
        if (!(way > 0 ? x >= close : x <= close)) return depth;
        depth -= 2;
    }
    if (depth == 1 && fabs(x) >= fabs(stack[0])) return 0;
    return depth;
}

static int run_locate(const Argument *a, Result *out)
{
    int direction = (int)a[4].n, pushed;
    if (a[2].n < 0 || a[2].n > a[1].n / 2) return TOO_SHORT;
    out[0].n = locate(a[1].reals, 2, a[2].n, a[3].x, &direction, a[0].x, &pushed);
    out[1].n = pushed;
    out[2].n = direction;
    return FINE;
}

/* Samples of a branch within a panel of a table whose power is 1: alike, so that compilers take
 * several at once. */
static void run_of_panel(const Table *t, double panel, const double *restrict x,
                         double *restrict force, Py_ssize_t n, double way, double begin,
                         double share, double base, double factor)
{
    const double *c = t->coefficients + (Py_ssize_t)panel * TERMS;
    double inverse = t->inverse_width;
    for (Py_ssize_t i = 0; i < n; i++) {
        double u = share * (way * x[i] - begin);
        force[i] = base + factor * (u * shape(c, 2.0 * (u * inverse - panel) - 1.0));
    }
}

static int run_respond(const Argument *a, Result *out)
{
    const double *xs = a[0].reals;
    double *force = a[1].reals, *stack = a[2].reals, last = a[4].x, last_force = a[5].x;
    Py_ssize_t n = a[0].n, depth = a[3].n;
    int direction = (int)a[6].n;
    const Table own = *a[7].table, *t = &own; /* a copy stays in registers beside the forces written */
    if (a[1].n < n || depth < 0 || depth > a[2].n / 2 - n) return TOO_SHORT;
    int smooth = 0; /* above zero if one of the last four branches had several samples, unlike noise */
    for (Py_ssize_t i = 0; i < n;) {
        double x = xs[i];
        int pushed;
        Py_ssize_t opened = i;
        depth = locate(stack, 2, depth, last, &direction, x, &pushed);
        if (pushed) {
            stack[2 * depth - 2] = last;
            stack[2 * depth - 1] = last_force;
        }
        /* The branch continues while the motion does, up to the next closure. */
        double way = direction < 0 ? -1.0 : 1.0, begin = 0.0, base = 0.0;
        double end = direction ? HUGE_VAL : -HUGE_VAL; /* before the first move there is no branch */
        double share = depth ? 0.5 : 1.0, factor = depth ? 2.0 * way : way;
        if (depth) {
            begin = way * stack[2 * depth - 2];
            base = stack[2 * depth - 1];
            end = depth > 1 ? way * stack[2 * depth - 4] : fabs(stack[0]);
        }
        double y = way * x, previous;
        do {
            double u = share * (y - begin), z = u * t->inverse_width;
            Py_ssize_t first = i++;
            previous = y;
            if (smooth && t->power == 1 && z < (double)t->panels) {
                double panel = (double)(Py_ssize_t)z;
                for (; i < n; i++) {
                    double next = way * xs[i];
                    u = share * (next - begin);
                    if (!(next > previous && next < end && u * t->inverse_width < panel + 1.0)) break;
                    previous = next;
                }
                run_of_panel(t, panel, xs + first, force + first, i - first, way, begin, share, base,
                             factor);
            } else {
                force[first] = base + factor * evaluate_at(t, u, NULL);
            }
            if (i < n) y = way * xs[i];
        } while (i < n && y > previous && y < end);
        smooth = i - opened > 8 ? 4 : smooth > 0 ? smooth - 1 : 0;
        last_force = force[i - 1];
        last = way * previous;
    }
    out[0].n = depth;
    out[1].x = last;
    out[2].x = last_force;
    out[3].n = direction;
    return FINE;
}

/* Sample i lies half[i] along the backbone, entered with the factor sign[i] (2 or -2; 1 or -1 on
 * the first loading curve) from the value at parent[i]: a sample, -1 for the origin, -2 - k for
 * entry k of the memory at the start (k = depth: the last displacement before the record). */
static int run_branches(const Argument *a, Result *out)
{
    const double *xs = a[0].reals;
    double *half = a[1].reals, *sign = a[2].reals, *stack = a[4].reals, last = a[7].x;
    long long *parent = a[3].integers, *codes = a[5].integers;
    Py_ssize_t n = a[0].n, depth = a[6].n;
    int direction = (int)a[8].n;
    long long last_code = -2 - (long long)depth;
    if (!all_have(a, 1, 3, n) || depth < 0 || depth > a[4].n - n || depth > a[5].n - n)
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < n; i++) {
        double x = xs[i];
        int pushed;
        depth = locate(stack, 1, depth, last, &direction, x, &pushed);
        if (pushed) {
            stack[depth - 1] = last;
            codes[depth - 1] = last_code;
        }
        if (depth) {
            half[i] = 0.5 * fabs(x - stack[depth - 1]);
            sign[i] = direction > 0 ? 2.0 : -2.0;
            parent[i] = codes[depth - 1];
        } else {
            half[i] = fabs(x);
            sign[i] = x < 0.0 ? -1.0 : 1.0;
            parent[i] = -1;
        }
        last = x;
        last_code = i;
    }
    out[0].n = depth;
    out[1].x = last;
    out[2].n = direction;
    return FINE;
}

/* Half a loop, if first loading passes its mirror point, has a negative amplitude. */
static int run_closings(const Argument *a, Result *out)
{
    const double *xs = a[0].reals;
    double *closed = a[1].reals, *stack = a[2].reals, last = a[4].x;
    Py_ssize_t n = a[0].n, depth = a[3].n, count = 0;
    int direction = (int)a[5].n;
    if (depth < 0 || depth > a[2].n - n - 1 || depth > a[1].n - n - 1) return TOO_SHORT;
    for (Py_ssize_t i = 0; i < n; i++) {
        double x = xs[i];
        int pushed, before = direction;
        Py_ssize_t kept = locate(stack, 1, depth, last, &direction, x, &pushed);
        if (pushed) {
            stack[depth] = last;
        } else if (kept < depth || (direction != before && before && x != last)) {
            /* Reversals removed by locate(), in pairs, with `last` on top if the move reversed. */
            if (direction != before && before) stack[depth++] = last;
            while (depth >= kept + 2) {
                depth -= 2;
                closed[count++] = 0.5 * fabs(stack[depth + 1] - stack[depth]);
            }
            if (depth > kept) closed[count++] = -fabs(stack[--depth]);
        }
        depth = kept;
        last = x;
    }
    out->n = count;
    return FINE;
}

/* Parents precede their entries. Rises and base may have columns, each with its own tree. */
static int run_accumulate(const Argument *a, Result *out)
{
    const long long *parent = a[0].integers;
    const double *base = a[2].reals;
    double *value = a[1].reals;
    Py_ssize_t n = a[0].n, columns = n > 0 ? a[1].n / n : 0;
    if (a[1].n != n * columns) return TOO_SHORT;
    for (Py_ssize_t i = 0; i < n; i++) {
        long long p = parent[i];
        if (p == -1) continue;
        const double *above = p >= 0 ? value + p * columns : base + (-2 - p) * columns;
        for (Py_ssize_t k = 0; k < columns; k++) value[i * columns + k] += above[k];
    }
    return FINE;
}
