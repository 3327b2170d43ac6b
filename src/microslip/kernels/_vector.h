/* Sliders in two directions: states and settled cycles of many nodes. Part of _compiled.c. */

/* slide() at a held radius, from within it: the end, and its derivatives by the step, in x and y. */
static inline void slide_held(const double *from, const double *e, double length, double radius,
                              double *to, double slope[2][2])
{
    double a = from[0] * e[0] + from[1] * e[1], b = from[1] * e[0] - from[0] * e[1];
    double inverse = 1.0 / radius;
    double begin = sqrt(a * a - fmin(a * a + b * b - radius * radius, 0.0)), way = begin - a;
    if (a < 0.0 && way > length) way = length; /* on the circle by rounding alone */
    double c = begin * inverse, s = b * inverse, far = (length - way) * inverse;
    double fade = far < 40.0 ? exp(-far) : 0.0, behind = (1.0 - c) * fade * fade;
    double part = 1.0 / (1.0 + c + behind), share = 2.0 * fade * part;
    double cosine = (1.0 + c - behind) * part, sine = s * share;
    double turned = ((1.0 - fade) * (1.0 - fade) + c * (1.0 - fade * fade)) * part;
    turned = (turned + way * inverse * share * c) * radius / length;
    to[0] = radius * (cosine * e[0] - sine * e[1]);
    to[1] = radius * (cosine * e[1] + sine * e[0]);
    /* Of the end (along, across) by the step's length, and by its swing. */
    double al = sine * sine, cl = -cosine * sine, an = -turned * sine, cn = turned * cosine;
    slope[0][0] = al * e[0] * e[0] - (cl + an) * e[0] * e[1] + cn * e[1] * e[1];
    slope[0][1] = al * e[0] * e[1] - cl * e[1] * e[1] + an * e[0] * e[0] - cn * e[0] * e[1];
    slope[1][0] = al * e[0] * e[1] + cl * e[0] * e[0] - an * e[1] * e[1] - cn * e[0] * e[1];
    slope[1][1] = al * e[1] * e[1] + (cl + an) * e[0] * e[1] + cn * e[0] * e[0];
}

/* Trials of nodes that share the sliders. Places are (nodes, 2), vectors held and new (nodes,
 * sliders, 2), tangents (nodes, 2, 3) by both parts of the place and by the separation. */
static int run_vector_try(const Argument *a, Result *out)
{
    enum { PLACE, STEP, LAST_PLACE, LAST_STEP, HELD, TOPS, WEIGHTS, NEW, VALUE, TANGENT };
    Py_ssize_t nodes = a[LAST_STEP].n, sliders = a[TOPS].n;
    const int held = !a[STEP].reals;
    const double *x = a[PLACE].reals, *x0 = a[LAST_PLACE].reals, *d0 = a[LAST_STEP].reals,
                 *d = held ? d0 : a[STEP].reals, *tops = a[TOPS].reals, *weights = a[WEIGHTS].reals;
    if (a[PLACE].n < 2 * nodes || a[LAST_PLACE].n < 2 * nodes || (!held && a[STEP].n < nodes) ||
        a[WEIGHTS].n < sliders || a[HELD].n < 2 * nodes * sliders || a[NEW].n < 2 * nodes * sliders ||
        a[VALUE].n < 2 * nodes || a[TANGENT].n < 6 * nodes)
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        const double *from = a[HELD].reals + 2 * sliders * i;
        double *to = a[NEW].reals + 2 * sliders * i;
        double step[2] = {x[2 * i] - x0[2 * i], x[2 * i + 1] - x0[2 * i + 1]};
        double length = hypot(step[0], step[1]), sum[2] = {0}, slope[2][3] = {{0}}, stuck = 0.0;
        double e[2] = {step[0] / length, step[1] / length}; /* not used where it is 0 */
        for (Py_ssize_t k = 0; k < sliders; k++, from += 2, to += 2) {
            double w = weights[k], last = tops[k] - d[i], map[2][6];
            if (held && last > 0.0) { /* most of them: what sticks just moves along */
                double u = from[0] + step[0], v = from[1] + step[1];
                if (u * u + v * v <= last * last) {
                    to[0] = u;
                    to[1] = v;
                    sum[0] += w * u;
                    sum[1] += w * v;
                    stuck += w;
                    continue;
                }
                if (length > 0.0) {
                    double turn[2][2];
                    slide_held(from, e, length, last, to, turn);
                    for (int r = 0; r < 2; r++) {
                        sum[r] += w * to[r];
                        slope[r][0] += w * turn[r][0];
                        slope[r][1] += w * turn[r][1];
                    }
                    continue;
                }
            }
            move_slider(from, step, length, tops[k] - d0[i], last, to, map);
            for (int r = 0; r < 2; r++) {
                sum[r] += w * to[r];
                slope[r][0] += w * map[r][2];
                slope[r][1] += w * map[r][3];
                slope[r][2] -= w * map[r][5];
            }
        }
        slope[0][0] += stuck;
        slope[1][1] += stuck;
        memcpy(a[VALUE].reals + 2 * i, sum, sizeof(sum));
        memcpy(a[TANGENT].reals + 6 * i, slope, sizeof(slope));
    }
    return FINE;
}

/* Settled cycles of nodes that share the sliders, with derivatives along directions: (nodes,
 * samples, 2, 2 places + steps) by those of each part of the place and of the separation. A cycle
 * begins where step + |place| is largest, with a straight path from rest, and is passed until its
 * values change by no more than `small`, or `most` times: then `passes` is negative. */
static int run_vector_cycle(const Argument *a, Result *out)
{
    enum { PLACE, STEP, REST, SAMPLES, TOPS, WEIGHTS, BY_PLACE, PLACES, BY_STEP, STEPS, MOST, SMALL,
           VALUE, SLOPES, PASSES };
    Py_ssize_t samples = a[SAMPLES].n, places = a[PLACES].n, steps = a[STEPS].n, most = a[MOST].n;
    Py_ssize_t sliders = a[TOPS].n, nodes = a[PASSES].n, n = nodes * samples;
    Py_ssize_t columns = 2 * places + steps;
    double small = a[SMALL].x;
    if (samples < 1 || places < 0 || steps < 0 || a[PLACE].n < 2 * n || a[STEP].n < n ||
        a[REST].n < nodes || a[WEIGHTS].n < sliders || a[BY_PLACE].n < samples * places ||
        a[BY_STEP].n < samples * steps || a[VALUE].n < 2 * n || a[SLOPES].n < 2 * n * columns)
        return TOO_SHORT;
    size_t room = (size_t)(2 * sliders * (2 + columns) + 2 * columns + 1);
    double *memory = malloc(room * sizeof(double));
    if (!memory) return NO_MEMORY;
    const double *tops = a[TOPS].reals, *weights = a[WEIGHTS].reals, *u = a[BY_PLACE].reals,
                 *v = a[BY_STEP].reals;
    long long *passes = a[PASSES].integers;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        const double *x = a[PLACE].reals + 2 * samples * i;
        const double *d = a[STEP].reals + samples * i;
        double *value = a[VALUE].reals + 2 * samples * i;
        double *slopes = a[SLOPES].reals + 2 * samples * columns * i;
        double *g = memory, *before = g + 2 * sliders, *by = before + 2 * sliders;
        double *row = by + 2 * sliders * columns;
        for (size_t k = 0; k < room; k++) memory[k] = 0.0;
        Py_ssize_t root = 0;
        double reach = -HUGE_VAL;
        for (Py_ssize_t t = 0; t < samples; t++) {
            double far = d[t] + hypot(x[2 * t], x[2 * t + 1]);
            if (far > reach) {
                reach = far;
                root = t;
            }
        }
        double last_x[2] = {0.0, 0.0}, last_d = a[REST].reals[i];
        Py_ssize_t last_t = -1;
        Py_ssize_t pass = 0;
        for (; pass < most; pass++) {
            double change = 0.0;
            for (Py_ssize_t k = 0; k < samples; k++) {
                Py_ssize_t t = root + k < samples ? root + k : root + k - samples;
                double step[2] = {x[2 * t] - last_x[0], x[2 * t + 1] - last_x[1]};
                double length = hypot(step[0], step[1]), sum[2] = {0.0, 0.0};
                double *out = slopes + 2 * columns * t;
                for (Py_ssize_t c = 0; c < 2 * columns; c++) out[c] = 0.0;
                for (Py_ssize_t j = 0; j < sliders; j++) {
                    double map[2][6], to[2], w = weights[j], *own = by + 2 * columns * j;
                    move_slider(g + 2 * j, step, length, tops[j] - last_d, tops[j] - d[t], to,
                                columns ? map : NULL);
                    for (int r = 0; r < 2; r++) {
                        sum[r] += w * to[r];
                        g[2 * j + r] = to[r];
                    }
                    if (!columns) continue;
                    for (Py_ssize_t c = 0; c < columns; c++) {
                        double in[6] = {own[c], own[columns + c], 0.0, 0.0, 0.0, 0.0};
                        if (c < 2 * places) {
                            Py_ssize_t way = c / places, p = c - way * places;
                            in[2 + way] = u[t * places + p] -
                                          (last_t < 0 ? 0.0 : u[last_t * places + p]);
                        } else {
                            Py_ssize_t p = c - 2 * places;
                            in[4] = last_t < 0 ? 0.0 : -v[last_t * steps + p];
                            in[5] = -v[t * steps + p];
                        }
                        for (int r = 0; r < 2; r++) {
                            double total = 0.0;
                            for (int m = 0; m < 6; m++) total += map[r][m] * in[m];
                            row[r] = total;
                        }
                        own[c] = row[0];
                        own[columns + c] = row[1];
                        out[c] += w * row[0];
                        out[columns + c] += w * row[1];
                    }
                }
                change = fmax(change, fmax(fabs(sum[0] - value[2 * t]),
                                           fabs(sum[1] - value[2 * t + 1])));
                value[2 * t] = sum[0];
                value[2 * t + 1] = sum[1];
                last_x[0] = x[2 * t];
                last_x[1] = x[2 * t + 1];
                last_d = d[t];
                last_t = t;
            }
            if (pass && change <= small) break;
        }
        passes[i] = pass < most ? pass + 1 : -(long long)most;
    }
    free(memory);
    return FINE;
}

/* What sliders lose in a step whose radii go from the first to the last, over their stiffness. */
static int run_vector_losses(const Argument *a, Result *out)
{
    const double *steps = a[1].reals, *first = a[2].reals, *last = a[3].reals;
    Py_ssize_t nodes = a[1].n / 2, sliders = nodes ? a[2].n / nodes : 0;
    if (a[2].n != nodes * sliders || a[0].n < 2 * a[2].n || !all_have(a, 3, 4, a[2].n))
        return TOO_SHORT;
    for (Py_ssize_t i = 0; i < nodes; i++) {
        const double *step = steps + 2 * i;
        double length = hypot(step[0], step[1]);
        for (Py_ssize_t k = i * sliders; k < (i + 1) * sliders; k++)
            a[4].reals[k] = vector_loss(a[0].reals + 2 * k, step, length, first[k], last[k]);
    }
    return FINE;
}
