/* Fourier coefficients of settled forces at held loads, without samples. Part of _compiled.c.
 *
 * A displacement is [mean, cos 1, sin 1, ... cos H, sin H]. Between its turning points, and where
 * inner loops close, the settled force is smooth: each such piece is integrated by the rule of Gauss
 * and Kronrod with 21 places (QUADPACK's, DOI 10.1007/978-3-642-61786-7), halved until its own rule
 * of 10 agrees. On the branch that began at reversal r the derivative is D = D_r + k (c - c_r); all
 * products of two functions of the basis follow from the coefficients of k up to 2H.
 */

static const double KRONROD[11] = {
    0.0, 0.148874338981631210884826001129720, 0.294392862701460198131126603103866,
    0.433395394129247190799265943165784, 0.562757134668604683339000099272694,
    0.679409568299024406234327365114874, 0.780817726586416897063717578345042,
    0.865063366688984510732096688423493, 0.930157491355708226001207180059508,
    0.973906528517171720077964012084452, 0.995657163025808080735527280689003,
};
static const double KRONROD_WEIGHTS[11] = {
    0.149445554002916905664936468389821, 0.147739104901338491374841515972068,
    0.142775938577060080797094273138717, 0.134709217311473325928054001771707,
    0.123491976262065851077958109585166, 0.109387158802297641899210590325805,
    0.093125454583697605535065465083366, 0.075039674810919952767043140916190,
    0.054755896574351996031381300244580, 0.032558162307964727478818972459390,
    0.011694638867371874278064396062192,
};
static const double GAUSS_WEIGHTS[5] = { /* of every other place from the second on */
    0.295524224714752870173815619188769, 0.269266719309996355091226921569469,
    0.219086362515982043995534934228163, 0.149451349150580593145863396957697,
    0.066671344308688137593568809892332,
};
#define TURN 6.283185307179586476925
#define HALVINGS 48
#define MOST_PARTS 65536 /* of a piece */

/* One backbone: of a node on a load curve, or a table. */
typedef struct {
    const Profile *curve;
    const Table *table;
    double rest;
} Line;

static inline double line_at(const Line *l, double u, double *slope)
{
    if (l->table) return evaluate_at(l->table, u, slope);
    if (slope) *slope = fall_at(l->curve, l->rest + u);
    return u > 0.0 ? drop_at(l->curve, l->rest, u) : 0.0;
}

typedef struct {
    int H, size, turns, failed;
    const double *c;                     /* coefficients */
    double *waves;                       /* functions up to 2H at a place */
    double *times, *x, *force, *by, *phi; /* at turning points; D and functions by row */
    int *open;
    double *piece, *sums, *k_sums, *spans; /* of a piece, and of the whole */
} Motion;

/* [1, cos, sin, ...] up to n of an angle by its cosine and sine. */
static inline void raise_waves(double c, double s, int n, double *w)
{
    double a = 1.0, b = 0.0;
    w[0] = 1.0;
    for (int m = 1; m <= n; m++) {
        double next = a * c - b * s;
        b = a * s + b * c;
        a = next;
        w[2 * m - 1] = a;
        w[2 * m] = b;
    }
}

static inline void make_waves(double t, int n, double *w)
{
    raise_waves(cos(t), sin(t), n, w);
}

static inline double place_at(const Motion *m, double t, double *speed, double *bend)
{
    double x = m->c[0], v = 0.0, a = 0.0;
    make_waves(t, m->H, m->waves);
    for (int n = 1; n <= m->H; n++) {
        double co = m->waves[2 * n - 1], si = m->waves[2 * n];
        double even = m->c[2 * n - 1] * co + m->c[2 * n] * si;
        x += even;
        v += n * (m->c[2 * n] * co - m->c[2 * n - 1] * si);
        a -= (double)n * n * even;
    }
    if (speed) *speed = v;
    if (bend) *bend = a;
    return x;
}

/* Where the place is `wanted` between two times, from t on (order 0), or turns (order 1). */
static double find_time(const Motion *m, int order, double wanted, int rising, double low,
                        double high, double t)
{
    double v, a;
    for (int i = 0; i < 80; i++) {
        double x = place_at(m, t, &v, &a);
        double value = order == 0 ? x - wanted : v, slope = order == 0 ? v : a;
        if (value == 0.0) break;
        if ((value > 0.0) == rising) high = t;
        else low = t;
        double next = slope != 0.0 ? t - value / slope : low - 1.0;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        double move = fabs(next - t), small = 4e-16 * fmax(fabs(t), 1.0);
        if (move <= small) break;
        t = next;
        if (order == 0 && fabs(a) * move * move <= small * fabs(v)) break; /* what is left of it */
    }
    return t;
}

/* Turning points, from that of the largest size on; fewer than two where it stands still. */
static void find_turns(Motion *m, const double *grid, int points)
{
    double *times = m->times, *x = m->x;
    int n = 0, most = 4 * m->H + 4;
    double before = 0.0, last = 0.0, step = TURN / points;
    for (int i = 0; i <= points && n < most - 2; i++) {
        const double *row = grid + (Py_ssize_t)(i % points) * m->size;
        double v = 0.0;
        for (int k = 1; k < m->size; k++) v += m->c[k] * row[k];
        double t = step * i;
        if (i && last != 0.0 && v * last <= 0.0) {
            times[n++] = find_time(m, 1, 0.0, last < 0.0, t - step, t, t - 0.5 * step);
        } else if (before * last > 0.0 && fabs(last) < fabs(before) && fabs(last) <= fabs(v)) {
            /* Two of them may lie between the points: where the speed is least it has turned. */
            double low = t - 2.0 * step, high = t, speed, bend, middle = t - step;
            for (int j = 0; j < 60; j++) {
                middle = 0.5 * (low + high);
                place_at(m, middle, &speed, &bend);
                if (speed * last <= 0.0) break;
                if (bend * last < 0.0) low = middle;
                else high = middle;
            }
            if (speed * last < 0.0) {
                times[n++] = find_time(m, 1, 0.0, last < 0.0, t - 2.0 * step, middle, middle);
                times[n++] = find_time(m, 1, 0.0, last > 0.0, middle, t, middle);
            }
        }
        before = last;
        last = v;
    }
    for (int i = 0; i < n; i++) x[i] = place_at(m, times[i], NULL, NULL);
    /* Only true ones: each differs from its neighbours, in the other direction. */
    for (int i = 0; n > 2 && i < n;) {
        double back = x[i] - x[(i + n - 1) % n], ahead = x[(i + 1) % n] - x[i];
        if (back != 0.0 && back * ahead < 0.0) {
            i++;
            continue;
        }
        n--;
        memmove(times + i, times + i + 1, (size_t)(n - i) * sizeof(double));
        memmove(x + i, x + i + 1, (size_t)(n - i) * sizeof(double));
        i = 0;
    }
    m->turns = n >= 2 && x[0] != x[1] ? n : 0;
    if (!m->turns) return;
    double most_size = 0.0;
    int root = -1;
    for (int i = 0; i < n; i++) most_size = fmax(most_size, fabs(x[i]));
    /* Of two sizes that agree to rounding the positive one is where the cycle begins. */
    for (int i = 0; i < n; i++)
        if (fabs(x[i]) >= most_size * (1.0 - 1e-13) && (root < 0 || x[i] > x[root])) root = i;
    for (int i = 0; i < root; i++) { /* turned by one, `root` times */
        double t = times[0] + TURN, place = x[0];
        memmove(times, times + 1, (size_t)(n - 1) * sizeof(double));
        memmove(x, x + 1, (size_t)(n - 1) * sizeof(double));
        times[n - 1] = t;
        x[n - 1] = place;
    }
}

/* Adds the integrals of force and slope from `low` to `high` to those of the piece, halving it. */
static void integrate(Motion *m, const Line *l, double low, double high, int parent, double sign,
                      double force_miss, double slope_miss)
{
    double begins[HALVINGS + 1], ends[HALVINGS + 1];
    long parts = 0;
    int left = 1, size = m->size, wide = 4 * m->H + 1, all = size + wide;
    begins[0] = low;
    ends[0] = high;
    while (left) {
        double a = begins[--left], b = ends[left], half = 0.5 * (b - a), centre = 0.5 * (a + b);
        double *sum = m->sums, off[6] = {0.0};
        memset(sum, 0, (size_t)all * sizeof(double));
        double *w = m->waves, co, si;
        for (int k = 0; k <= 10; k++) {
            double reach = half * KRONROD[k], weight = half * KRONROD_WEIGHTS[k], other = weight;
            double cos_reach = cos(reach), sin_reach = sin(reach);
            if (k == 0) {
                co = cos(centre);
                si = sin(centre);
            }
            if (k % 2) other -= half * GAUSS_WEIGHTS[k / 2];
            for (int side = 0; side <= (k > 0); side++, sin_reach = -sin_reach) {
                double x = m->c[0], slope;
                raise_waves(co * cos_reach - si * sin_reach, si * cos_reach + co * sin_reach,
                            2 * m->H, w);
                for (int n = 1; n < size; n++) x += m->c[n] * w[n];
                double value = line_at(l, 0.5 * fabs(x - m->x[parent]), &slope);
                double force = m->force[parent] + 2.0 * sign * value;
                double f = weight * force, g = other * force, h = weight * slope, e = other * slope;
                for (int n = 0; n < size; n++) sum[n] += f * w[n];
                for (int n = 0; n < wide; n++) sum[size + n] += h * w[n];
                /* The mean and the fastest functions tell how well it went. */
                off[0] += g;
                off[1] += g * w[size - 2];
                off[2] += g * w[size - 1];
                off[3] += e;
                off[4] += e * w[wide - 2];
                off[5] += e * w[wide - 1];
            }
        }
        double worst = fmax(fmax(fabs(off[0]), fabs(off[1])), fabs(off[2]));
        double stiff = fmax(fmax(fabs(off[3]), fabs(off[4])), fabs(off[5]));
        int rough = worst > force_miss || stiff > slope_miss;
        if (rough && ++parts > MOST_PARTS) m->failed = 1;
        if (rough && !m->failed && left < HALVINGS - 1 && b - a > 1e-13) {
            begins[left] = centre;
            ends[left++] = b;
            begins[left] = a;
            ends[left++] = centre;
            continue;
        }
        for (int n = 0; n < all; n++) m->piece[n] += sum[n];
    }
}

/* A piece of the branch from `parent`, with all that it adds to force and jacobian. */
static void add_piece(Motion *m, const Line *l, double low, double high, int parent, double sign,
                      double force_miss, double slope_miss, double *force, double *J)
{
    int size = m->size, wide = 4 * m->H + 1;
    if (!(high > low)) return;
    memset(m->piece, 0, (size_t)(size + wide) * sizeof(double));
    integrate(m, l, low, high, parent, sign, force_miss, slope_miss);
    m->spans[0] = high - low;
    make_waves(high, m->H, m->waves);
    for (int n = 1; n <= m->H; n++) {
        m->spans[2 * n - 1] = m->waves[2 * n] / n;
        m->spans[2 * n] = -m->waves[2 * n - 1] / n;
    }
    make_waves(low, m->H, m->waves);
    for (int n = 1; n <= m->H; n++) {
        m->spans[2 * n - 1] -= m->waves[2 * n] / n;
        m->spans[2 * n] += m->waves[2 * n - 1] / n;
    }
    const double *by = m->by + parent * size, *phi = m->phi + parent * size, *K = m->piece + size;
    for (int n = 0; n < wide; n++) m->k_sums[n] += K[n];
    for (int i = 0; i < size; i++) {
        force[i] += m->piece[i];
        for (int j = 0; j < size; j++) J[i * size + j] += m->spans[i] * by[j] - K[i] * phi[j];
    }
}

/* The integral of k times two functions of the basis. */
static double product(const double *k, int i, int j)
{
    int a = (i + 1) / 2, b = (j + 1) / 2, sum = a + b, gap = a > b ? a - b : b - a;
    int sine_i = i && i % 2 == 0, sine_j = j && j % 2 == 0;
    double even_gap = gap ? k[2 * gap - 1] : k[0], even_sum = sum ? k[2 * sum - 1] : k[0];
    if (sine_i && sine_j) return 0.5 * (even_gap - even_sum);
    if (!sine_i && !sine_j) return 0.5 * (even_gap + even_sum);
    double odd_gap = gap ? k[2 * gap] : 0.0, odd_sum = sum ? k[2 * sum] : 0.0;
    int larger_sine = sine_i ? a > b : b > a;
    return 0.5 * (odd_sum + (larger_sine ? odd_gap : -odd_gap));
}

static void settle_harmonics(Motion *m, const Line *l, const double *grid, int points,
                             double tolerance, double *force, double *J)
{
    int size = m->size, n, depth = 1;
    double stiff, k;
    memset(force, 0, (size_t)size * sizeof(double));
    memset(J, 0, (size_t)(size * size) * sizeof(double));
    line_at(l, 0.0, &stiff);
    find_turns(m, grid, points);
    if (!(stiff > 0.0)) return; /* nothing touches */
    if (!(n = m->turns)) { /* what small cycles tend to */
        force[0] = copysign(line_at(l, fabs(m->c[0]), &k), m->c[0]);
        for (int i = 0; i < size; i++) J[i * size + i] = i ? stiff : k;
        return;
    }
    memset(m->k_sums, 0, (size_t)(4 * m->H + 1) * sizeof(double));
    double most = 0.0;
    for (int pass = 0; pass < 2; pass++) { /* forces at turning points, then the pieces */
        depth = 1;
        m->open[0] = 0;
        m->force[0] = copysign(line_at(l, fabs(m->x[0]), &k), m->x[0]);
        make_waves(m->times[0], m->H, m->phi);
        for (int j = 0; j < size; j++) m->by[j] = k * m->phi[j];
        most = fmax(most, fabs(m->force[0]));
        /* The rule of 21 places is exact to the power 3/2 of 200 times what the two differ by. */
        double small = cbrt(tolerance * tolerance), force_miss = small / 200.0 * most;
        double slope_miss = cbrt(1e4 * tolerance * tolerance) / 200.0 * stiff;
        for (int way = 0; way < n; way++) {
            double end = m->x[(way + 1) % n], from = m->x[way], begin = m->times[way];
            double last = way + 1 < n ? m->times[way + 1] : m->times[0] + TURN;
            double sign = end > from ? 1.0 : -1.0;
            if (way) m->open[depth++] = way;
            while (depth > 2 && (end - m->x[m->open[depth - 2]]) * sign >= 0.0) {
                double close = m->x[m->open[depth - 2]];
                if (pass && (close - from) * sign > 0.0) {
                    double t = 0.5 * (begin + last);
                    t = close == end ? last
                                     : find_time(m, 0, close, sign > 0.0, begin, last, t);
                    add_piece(m, l, begin, t, m->open[depth - 1], sign, force_miss, slope_miss,
                              force, J);
                    begin = t;
                    from = close;
                }
                depth -= 2;
            }
            int parent = m->open[depth - 1];
            if (pass)
                add_piece(m, l, begin, last, parent, sign, force_miss, slope_miss, force, J);
            if (pass || way + 1 == n) continue;
            double *by = m->by + (way + 1) * size, *phi = m->phi + (way + 1) * size;
            double value = line_at(l, 0.5 * fabs(end - m->x[parent]), &k);
            m->force[way + 1] = m->force[parent] + 2.0 * sign * value;
            most = fmax(most, fabs(m->force[way + 1]));
            make_waves(m->times[way + 1], m->H, phi);
            for (int j = 0; j < size; j++)
                by[j] = m->by[parent * size + j] + k * (phi[j] - m->phi[parent * size + j]);
        }
    }
    for (int i = 0; i < size; i++) {
        double factor = i ? 2.0 / TURN : 1.0 / TURN;
        force[i] *= factor;
        for (int j = 0; j < size; j++)
            J[i * size + j] = factor * (J[i * size + j] + product(m->k_sums, i, j));
    }
}

/* Derivatives of the functions, a row a time. */
static void make_speeds(double *grid, int points, int H, int size)
{
    for (int i = 0; i < points; i++) {
        double *row = grid + (size_t)i * (size_t)size;
        make_waves(TURN / points * i, H, row);
        for (int k = 1; k <= H; k++) {
            double even = row[2 * k - 1];
            row[2 * k - 1] = -k * row[2 * k];
            row[2 * k] = k * even;
        }
    }
}

/* Rows of [mean, cos 1, sin 1, ...]; of nodes on a curve with their rests, or of one table. */
static int run_harmonics(const Argument *a, Result *out, const Profile *curve,
                         const double *rests, const Table *table)
{
    Py_ssize_t rows = a[1].n, size = a[2].n;
    int H = (int)(size / 2), points = 16 * H + 16;
    if (rows < 0 || size < 1 || size % 2 == 0 || size > 2001 || a[0].n < rows * size ||
        a[4].n < rows * size || a[5].n < rows * size * size)
        return TOO_SHORT;
    size_t turns = 4 * (size_t)H + 8, wide = 4 * (size_t)H + 1, n = (size_t)size;
    size_t doubles = (size_t)points * n + wide + turns * (3 + 2 * n) + 2 * (n + wide) + 2 * wide + n;
    double *memory = malloc(doubles * sizeof(double)), *at = memory;
    int *open = malloc(turns * sizeof(int));
    if (!memory || !open) {
        free(memory);
        free(open);
        return NO_MEMORY;
    }
    double *grid = at;
    Motion m = {.H = H, .size = (int)size, .open = open};
    m.waves = at += (size_t)points * n;
    m.times = at += wide;
    m.x = at += turns;
    m.force = at += turns;
    m.by = at += turns;
    m.phi = at += turns * n;
    m.piece = at += turns * n;
    m.sums = at += n + wide;
    m.k_sums = at += n + wide;
    m.spans = at + wide;
    make_speeds(grid, points, H, (int)size);
    for (Py_ssize_t i = 0; i < rows; i++) {
        Line line = {curve, table, rests ? rests[i] : 0.0};
        m.c = a[0].reals + i * size;
        settle_harmonics(&m, &line, grid, points, a[3].x, a[4].reals + i * size,
                         a[5].reals + i * size * size);
    }
    out[0].n = m.failed;
    free(memory);
    free(open);
    return FINE;
}

static int run_field_harmonics(const Argument *a, Result *out)
{
    if (a[6].n < a[1].n) return TOO_SHORT;
    return run_harmonics(a, out, a[7].curve, a[6].reals, NULL);
}

static int run_table_harmonics(const Argument *a, Result *out)
{
    return run_harmonics(a, out, NULL, NULL, a[6].table);
}
