/* Fourier coefficients of settled forces at held loads, without samples. Part of _compiled.c.
 *
 * A displacement is [mean, cos 1, sin 1, ... cos H, sin H], or has a few orders up to H. Between its turning points, and where
 * inner loops close, the settled force is smooth: each such piece is integrated by the rule of Gauss
 * and Kronrod with 21 places (QUADPACK's, DOI 10.1007/978-3-642-61786-7), halved until its own rule
 * of 10 agrees. On the branch that began at reversal r the derivative is D = D_r + k (c - c_r); all
 * products of two functions of the basis follow from the coefficients of k up to 2H. If there are few
 * orders, these products are integrated themselves, which makes the work linear in H.
 */

/* Rules of Gauss and Kronrod, QUADPACK's, each from its outermost place to its middle, and the
 * weights of every other place in the rule of Gauss. */
static const double PLACES[] = {
    0.9914553711208126, 0.9491079123427585, 0.8648644233597691, 0.7415311855993945,
    0.5860872354676911, 0.4058451513773972, 0.20778495500789848, 0.0, 0.9956571630258081,
    0.9739065285171717, 0.9301574913557082, 0.8650633666889845, 0.7808177265864169,
    0.6794095682990244, 0.5627571346686047, 0.4333953941292472, 0.2943928627014602,
    0.14887433898163122, 0.0, 0.9980022986933971, 0.9879925180204854, 0.9677390756791391,
    0.937273392400706, 0.8972645323440819, 0.8482065834104272, 0.790418501442466,
    0.7244177313601701, 0.650996741297417, 0.5709721726085388, 0.4850818636402397,
    0.3941513470775634, 0.29918000715316884, 0.20119409399743451, 0.1011420669187175, 0.0,
    0.9988590315882777, 0.9931285991850949, 0.9815078774502503, 0.9639719272779138,
    0.9408226338317548, 0.912234428251326, 0.878276811252282, 0.8391169718222188,
    0.7950414288375512, 0.7463319064601508, 0.6932376563347514, 0.636053680726515,
    0.5751404468197103, 0.5108670019508271, 0.4435931752387251, 0.37370608871541955,
    0.301627868114913, 0.22778585114164507, 0.15260546524092267, 0.07652652113349734, 0.0,
    0.9992621049926098, 0.9955569697904981, 0.9880357945340772, 0.9766639214595175,
    0.9616149864258425, 0.9429745712289743, 0.9207471152817016, 0.8949919978782753,
    0.8658470652932756, 0.833442628760834, 0.7978737979985001, 0.7592592630373576,
    0.7177664068130843, 0.6735663684734684, 0.6268100990103174, 0.577662930241223,
    0.5263252843347191, 0.473002731445715, 0.4178853821930377, 0.36117230580938786,
    0.30308953893110785, 0.24386688372098844, 0.1837189394210489, 0.1228646926107104,
    0.06154448300568508, 0.0,
};
static const double WEIGHTS[] = {
    0.022935322010529224, 0.06309209262997856, 0.10479001032225019, 0.14065325971552592,
    0.1690047266392679, 0.19035057806478542, 0.20443294007529889, 0.20948214108472782,
    0.011694638867371874, 0.032558162307964725, 0.054755896574351995, 0.07503967481091996,
    0.0931254545836976, 0.10938715880229764, 0.12349197626206584, 0.13470921731147334,
    0.14277593857706009, 0.14773910490133849, 0.1494455540029169, 0.005377479872923349,
    0.015007947329316122, 0.02546084732671532, 0.03534636079137585, 0.04458975132476488,
    0.05348152469092809, 0.06200956780067064, 0.06985412131872826, 0.07684968075772038,
    0.08308050282313302, 0.08856444305621176, 0.09312659817082532, 0.09664272698362368,
    0.09917359872179196, 0.10076984552387559, 0.10133000701479154, 0.0030735837185205317,
    0.008600269855642943, 0.014626169256971253, 0.020388373461266523, 0.02588213360495116,
    0.0312873067770328, 0.036600169758200796, 0.041668873327973685, 0.04643482186749767,
    0.05094457392372869, 0.05519510534828599, 0.05911140088063957, 0.06265323755478117,
    0.06583459713361842, 0.06864867292852161, 0.07105442355344407, 0.07303069033278667,
    0.07458287540049918, 0.07570449768455667, 0.07637786767208074, 0.07660071191799965,
    0.001987383892330316, 0.005561932135356714, 0.009473973386174152, 0.013236229195571676,
    0.0168478177091283, 0.020435371145882834, 0.024009945606953215, 0.02747531758785174,
    0.030792300167387487, 0.034002130274329335, 0.03711627148341554, 0.04008382550403238,
    0.04287284502017005, 0.04550291304992179, 0.04798253713883671, 0.05027767908071567,
    0.05236288580640747, 0.05425112988854549, 0.055950811220412316, 0.057437116361567835,
    0.058689680022394206, 0.05972034032417406, 0.06053945537604586, 0.061128509717053046,
    0.061471189871425316, 0.061580818067832936,
};
static const double GAUSS_WEIGHTS[] = {
    0.1294849661688697, 0.27970539148927664, 0.3818300505051189, 0.4179591836734694,
    0.06667134430868814, 0.1494513491505806, 0.21908636251598204, 0.26926671930999635,
    0.29552422471475287, 0.03075324199611727, 0.07036604748810812, 0.10715922046717194,
    0.13957067792615432, 0.16626920581699392, 0.1861610000155622, 0.19843148532711158,
    0.2025782419255613, 0.017614007139152118, 0.04060142980038694, 0.06267204833410907,
    0.08327674157670475, 0.10193011981724044, 0.11819453196151841, 0.13168863844917664,
    0.14209610931838204, 0.14917298647260374, 0.15275338713072584, 0.011393798501026288,
    0.026354986615032137, 0.040939156701306316, 0.054904695975835194, 0.06803833381235691,
    0.08014070033500102, 0.09102826198296365, 0.10053594906705064, 0.10851962447426365,
    0.11485825914571164, 0.11945576353578477, 0.12224244299031004, 0.12317605372671545,
};
#define RULES 5
static const int GAUSS_PLACES[RULES] = {7, 10, 15, 20, 25};
#define MOST_HALF 26 /* nodes of the largest rule from an end to its middle */

/* A node of a rule, its weight, and the difference to its weight in the Gauss rule. */
typedef struct {
    double place, weight, miss;
} Node;

/* Nodes of a rule from an end to the middle; returns the index of the middle. */
static int make_rule(int rule, Node *nodes)
{
    const double *place = PLACES, *weight = WEIGHTS, *gauss = GAUSS_WEIGHTS;
    for (int r = 0; r < rule; r++) {
        place += GAUSS_PLACES[r] + 1;
        weight += GAUSS_PLACES[r] + 1;
        gauss += (GAUSS_PLACES[r] + 1) / 2;
    }
    for (int i = 0; i <= GAUSS_PLACES[rule]; i++)
        nodes[i] = (Node){place[i], weight[i], weight[i] - (i % 2 ? gauss[i / 2] : 0.0)};
    return GAUSS_PLACES[rule];
}
#define TURN 6.283185307179586476925

/* The same nodes clustered like those of a cosine, for integrands with roots at an end. */
static void crowd_rule(int middle, Node *nodes)
{
    for (int i = 0; i <= middle; i++) {
        double angle = 0.25 * TURN * nodes[i].place, stretch = 0.25 * TURN * cos(angle);
        nodes[i] = (Node){sin(angle), stretch * nodes[i].weight, stretch * nodes[i].miss};
    }
}

/* The rule of 15 places for an integrand with a root of the distance to its end: shares of the way
 * back from the end, as squares. */
#define END_NODES 15
static void make_end_rule(Node *nodes)
{
    Node half[MOST_HALF];
    int middle = make_rule(0, half);
    for (int i = 0; i < END_NODES; i++) {
        const Node *node = &half[i <= middle ? i : 2 * middle - i];
        double y = 0.5 + (i <= middle ? 0.5 : -0.5) * node->place;
        nodes[i] = (Node){-y * y, y * node->weight, y * node->miss};
    }
}

/* Cosine and sine, of small angles by their series. */
static inline void make_wave(double t, double *c, double *s)
{
    double q = t * t;
    if (q < 1e-3) {
        *c = 1.0 - q * (0.5 - q * (1.0 / 24 - q * (1.0 / 720 - q * (1.0 / 40320))));
        *s = t * (1.0 - q * (1.0 / 6 - q * (1.0 / 120 - q * (1.0 / 5040 - q * (1.0 / 362880)))));
    } else {
        *c = cos(t);
        *s = sin(t);
    }
}

#define HALVINGS 48
#define MOST_PARTS 65536 /* of a piece */

/* One backbone: of a node on a load curve, or a table. For a stretch of a curve of pieces also the
 * piece in which it begins, its place, and the force there. */
typedef struct {
    const Profile *curve;
    const Table *table;
    double rest;
    Py_ssize_t piece;
    double base, force;
} Line;

static inline double line_at(const Line *l, double u, double *slope)
{
    if (l->table) return evaluate_at(l->table, u, slope);
    if (slope) *slope = fall_at(l->curve, l->rest + u);
    return u > 0.0 ? drop_at(l->curve, l->rest, u) : 0.0;
}

typedef struct {
    int H, size, wide, turns, failed;     /* wide: number of integrals of the slope */
    const double *orders;                /* of a few functions; NULL for all up to H */
    const double *c;                     /* coefficients */
    double jump;                         /* force at rest of a rigid law, otherwise 0 */
    double *waves;                       /* functions up to 2H at a place, or their products */
    double *times, *x, *force, *by, *phi; /* at turning points; D and functions by row */
    int *open;
    double *piece, *sums, *k_sums, *spans; /* of a piece, and of the whole */
    Node rule[MOST_HALF], end_rule[END_NODES];
    int middle;
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

/* Order of the functions 2 q - 1 and 2 q. */
static inline int order_of(const Motion *m, int q)
{
    return m->orders ? (int)m->orders[q - 1] : q;
}

/* Functions of a few orders of an angle by its cosine and sine; each follows from the one before by
 * a power, found by squaring. */
static inline void raise_few(const Motion *m, double c, double s, double *w)
{
    double a = 1.0, b = 0.0;
    w[0] = 1.0;
    for (int q = 1, before = 0; 2 * q < m->size; q++) {
        double x = c, y = s, next;
        for (int n = order_of(m, q) - before; n; n >>= 1) {
            if (n & 1) {
                next = a * x - b * y;
                b = a * y + b * x;
                a = next;
            }
            next = x * x - y * y;
            y *= 2.0 * x;
            x = next;
        }
        before = order_of(m, q);
        w[2 * q - 1] = a;
        w[2 * q] = b;
    }
}

/* The functions, and then those that the slope is integrated with: all up to 2H, or products. */
static inline void raise_all(const Motion *m, double c, double s, double *w)
{
    if (!m->orders) {
        raise_waves(c, s, 2 * m->H, w);
        return;
    }
    raise_few(m, c, s, w);
    double *next = w + m->size;
    for (int i = 1; i < m->size; i++)
        for (int j = i; j < m->size; j++) *next++ = w[i] * w[j];
}

static inline void make_functions(const Motion *m, double t, double *w)
{
    if (m->orders) raise_few(m, cos(t), sin(t), w);
    else make_waves(t, m->H, w);
}

/* The place, and its first three time derivatives if requested. */
static inline double place_at(const Motion *m, double t, double *rates)
{
    double x = m->c[0], v = 0.0, a = 0.0, j = 0.0;
    make_functions(m, t, m->waves);
    for (int q = 1; 2 * q < m->size; q++) {
        double co = m->waves[2 * q - 1], si = m->waves[2 * q];
        int n = order_of(m, q);
        double even = m->c[2 * q - 1] * co + m->c[2 * q] * si;
        double odd = n * (m->c[2 * q] * co - m->c[2 * q - 1] * si);
        x += even;
        v += odd;
        a -= (double)n * n * even;
        j -= (double)n * n * odd;
    }
    if (rates) {
        rates[0] = v;
        rates[1] = a;
        rates[2] = j;
    }
    return x;
}

/* Time between two others at which the place is `wanted` (order 0) or has a turning point (order
 * 1), starting at t, by Cauchy's method of third order. */
static double find_time(const Motion *m, int order, double wanted, int rising, double low,
                        double high, double t)
{
    double rates[3];
    for (int i = 0; i < 80; i++) {
        double x = place_at(m, t, rates), value = order ? rates[0] : x - wanted;
        double slope = rates[order], bend = rates[order + 1], small = 4e-16 * fmax(fabs(t), 1.0);
        if (value == 0.0) break;
        if ((value > 0.0) == rising) high = t;
        else low = t;
        double root = slope * slope - 2.0 * value * bend;
        double by = root > 0.0 ? slope + copysign(sqrt(root), slope) : 2.0 * slope;
        double next = by != 0.0 ? t - 2.0 * value / by : HUGE_VAL, move = fabs(next - t);
        /* Residual of the root; the slope is that at the root. */
        double left = fabs(rates[2] * move * move * move), most = small * sqrt(fmax(root, 0.0));
        if (root > 0.0 && (order ? move < 1e-7 : left <= most))
            return fmin(fmax(next, low), high);
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        if (fabs(next - t) <= small) break;
        t = next;
    }
    return t;
}

/* Turning points from the largest place on; fewer than two for a constant place. */
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
            /* Two turning points may be between the samples: check the minimum of the speed. */
            double low = t - 2.0 * step, high = t, rates[3], middle = t - step;
            for (int j = 0; j < 60; j++) {
                middle = 0.5 * (low + high);
                place_at(m, middle, rates);
                if (rates[0] * last <= 0.0) break;
                if (rates[1] * last < 0.0) low = middle;
                else high = middle;
            }
            if (rates[0] * last < 0.0) {
                times[n++] = find_time(m, 1, 0.0, last < 0.0, t - 2.0 * step, middle, middle);
                times[n++] = find_time(m, 1, 0.0, last > 0.0, middle, t, middle);
            }
        }
        before = last;
        last = v;
    }
    for (int i = 0; i < n; i++) x[i] = place_at(m, times[i], NULL);
    /* Keep only true turning points, at which the direction changes. */
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
    /* If two extremes agree within rounding, the cycle begins at the positive one. */
    for (int i = 0; i < n; i++)
        if (fabs(x[i]) >= most_size * (1.0 - 1e-13) && (root < 0 || x[i] > x[root])) root = i;
    for (int i = 0; i < root; i++) { /* rotate by one, `root` times */
        double t = times[0] + TURN, place = x[0];
        memmove(times, times + 1, (size_t)(n - 1) * sizeof(double));
        memmove(x, x + 1, (size_t)(n - 1) * sizeof(double));
        times[n - 1] = t;
        x[n - 1] = place;
    }
}

/* Add the integrals of force and slope from `low` to `high` to those of the piece, by bisection;
 * with the rule of roots at the end for a stretch. */
static void integrate(Motion *m, const Line *l, double low, double high, int parent, double sign,
                      double force_miss, double slope_miss)
{
    double begins[HALVINGS + 1], ends[HALVINGS + 1];
    long parts = 0;
    int left = 1, size = m->size, wide = m->wide, all = size + wide, stretch = l->piece >= 0;
    const Node *rule = stretch ? m->end_rule : m->rule;
    int last = stretch ? END_NODES - 1 : m->middle;
    begins[0] = low;
    ends[0] = high;
    while (left) {
        double a = begins[--left], b = ends[left], centre = 0.5 * (a + b);
        double scale = stretch ? b - a : 0.5 * (b - a), origin = stretch ? b : centre;
        double *sum = m->sums, off[6] = {0.0};
        memset(sum, 0, (size_t)all * sizeof(double));
        double *w = m->waves, co = cos(origin), si = sin(origin);
        for (int k = 0; k <= last; k++) {
            const Node *node = &rule[k];
            double weight = scale * node->weight, miss = scale * node->miss, cos_reach, sin_reach;
            make_wave(scale * node->place, &cos_reach, &sin_reach);
            int sides = stretch || k == last ? 1 : 2;
            for (int side = 0; side < sides; side++, sin_reach = -sin_reach) {
                double x = m->c[0], slope, force;
                raise_all(m, co * cos_reach - si * sin_reach, si * cos_reach + co * sin_reach, w);
                for (int n = 1; n < size; n++) x += m->c[n] * w[n];
                double u = 0.5 * fabs(x - m->x[parent]);
                if (stretch)
                    force = l->force + 2.0 * sign * piece_ahead(l->curve, l->piece, l->base,
                                                                l->rest + u, &slope);
                else
                    force = m->force[parent] + 2.0 * sign * line_at(l, u, &slope);
                double f = weight * force, g = miss * force, h = weight * slope, e = miss * slope;
                for (int n = 0; n < size; n++) sum[n] += f * w[n];
                for (int n = 0; n < wide; n++) sum[size + n] += h * w[n];
                /* The mean and the highest functions determine the error. */
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

/* Piece of the branch from `parent`, with its contribution to force and jacobian. */
static void add_piece(Motion *m, const Line *l, double low, double high, int parent, double sign,
                      double force_miss, double slope_miss, double *force, double *J)
{
    int size = m->size, wide = m->wide;
    if (!(high > low)) return;
    memset(m->piece, 0, (size_t)(size + wide) * sizeof(double));
    integrate(m, l, low, high, parent, sign, force_miss, slope_miss);
    m->spans[0] = high - low;
    make_functions(m, high, m->waves);
    for (int q = 1; 2 * q < size; q++) {
        m->spans[2 * q - 1] = m->waves[2 * q] / order_of(m, q);
        m->spans[2 * q] = -m->waves[2 * q - 1] / order_of(m, q);
    }
    make_functions(m, low, m->waves);
    for (int q = 1; 2 * q < size; q++) {
        m->spans[2 * q - 1] -= m->waves[2 * q] / order_of(m, q);
        m->spans[2 * q] += m->waves[2 * q - 1] / order_of(m, q);
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

/* The same, from the integrals that raise_all names. */
static inline double product_of(const Motion *m, const double *k, int i, int j)
{
    if (!m->orders) return product(k, i, j);
    int a = i < j ? i : j, b = i < j ? j : i;
    return k[a ? m->size + (a - 1) * m->size - (a - 1) * a / 2 + (b - a) : b];
}

/* Integrals of cos(n t) and sin(n t) between two times. */
static inline void wave_integral(int n, double low, double high, double *even, double *odd)
{
    double share = n ? 2.0 * sin(0.5 * n * (high - low)) / n : high - low;
    *even = share * cos(0.5 * n * (low + high));
    *odd = share * sin(0.5 * n * (low + high));
}

/* Integrals between two times of what raise_all names. */
static void integrate_waves(Motion *m, double low, double high, double *I)
{
    if (!m->orders) {
        make_waves(0.5 * (high - low), 2 * m->H, m->spans);
        make_waves(0.5 * (low + high), 2 * m->H, m->waves);
        I[0] = high - low;
        for (int n = 1; n <= 2 * m->H; n++) {
            double share = 2.0 * m->spans[2 * n] / n;
            I[2 * n - 1] = share * m->waves[2 * n - 1];
            I[2 * n] = share * m->waves[2 * n];
        }
        return;
    }
    double *next = I + m->size, even[2], odd[2];
    I[0] = high - low;
    for (int q = 1; 2 * q < m->size; q++)
        wave_integral(order_of(m, q), low, high, I + 2 * q - 1, I + 2 * q);
    for (int i = 1; i < m->size; i++)
        for (int j = i; j < m->size; j++) {
            int a = order_of(m, (i + 1) / 2), b = order_of(m, (j + 1) / 2);
            wave_integral(b - a, low, high, even, odd);
            wave_integral(b + a, low, high, even + 1, odd + 1);
            if (i % 2 == j % 2) *next++ = 0.5 * (even[0] + (i % 2 ? even[1] : -even[1]));
            else *next++ = 0.5 * (odd[1] + (i % 2 ? odd[0] : -odd[0]));
        }
}

/* A piece on which the slope is constant, in closed form: force = f + k (x - x0). */
static void add_straight(Motion *m, double low, double high, int parent, double f, double k,
                         double x0, double *force, double *J)
{
    int size = m->size, wide = m->wide;
    double *I = m->sums, *by = m->by + parent * size, *phi = m->phi + parent * size;
    integrate_waves(m, low, high, I);
    for (int n = 0; n < wide; n++) m->k_sums[n] += k * I[n];
    for (int i = 0; i < size; i++) {
        double sum = (f + k * (m->c[0] - x0)) * I[i];
        for (int j = 1; j < size; j++) sum += k * m->c[j] * product_of(m, I, i, j);
        force[i] += sum;
        for (int j = 0; j < size; j++) J[i * size + j] += I[i] * (by[j] - k * phi[j]);
    }
}

/* Like add_piece, cut at kinks of the law. */
static void add_cut(Motion *m, const Line *l, double low, double high, double from, double to,
                    int parent, double sign, double force_miss, double slope_miss, double *force,
                    double *J)
{
    const Profile *p = l->curve;
    if (!p || !p->edges || !(high > low)) {
        add_piece(m, l, low, high, parent, sign, force_miss, slope_miss, force, J);
        return;
    }
    double origin = m->x[parent], first = l->rest + 0.5 * fabs(from - origin), t = low, x = from;
    double last = l->rest + 0.5 * fabs(to - origin), at = first, k_here;
    double f = m->force[parent] + 2.0 * sign * piece_drop(p, l->rest, at - l->rest);
    Py_ssize_t i = find_piece(p, at); /* with `at` and `f`: where the next part begins */
    const double *breaks;
    Py_ssize_t count = breaks_between(p, first, last, &breaks);
    for (Py_ssize_t k = 0; k <= count; k++) {
        double next = k < count ? breaks[k] : last, end = high, y = to;
        if (k < count) {
            y = origin + 2.0 * sign * (next - l->rest);
            if ((y - x) * sign <= 0.0 || (to - y) * sign <= 0.0) continue;
            double near = t + (high - t) * (y - x) / (to - x);
            end = find_time(m, 0, y, sign > 0.0, t, high, near);
        }
        while (i < p->panels && at >= p->edges[i + 1]) i++;
        int straight = i >= p->panels, roots = 0;
        if (!straight) {
            const double *row = piece_at(p, i), *c = row + PIECE_POWERS;
            Py_ssize_t j = i;
            while (j + 1 < p->panels && next > p->edges[j + 1]) j++;
            roots = piece_at(p, j)[PIECE_ROOTS] != 0.0;
            straight = !row[PIECE_ROOTS] && next <= p->edges[i + 1];
            for (int n = 1; n < TERMS; n++) straight &= c[n] == 0.0;
        }
        double rise = piece_ahead(p, i, at, next, &k_here);
        if (straight) { /* N is linear on a straight piece */
            k_here = i < p->panels ? piece_at(p, i)[PIECE_INVERSE] * piece_at(p, i)[PIECE_WHOLE] : 0.0;
            add_straight(m, t, end, parent, f, k_here, x, force, J);
            rise = 0.5 * k_here * fabs(y - x);
        } else {
            Line part = {p, NULL, l->rest, roots ? i : -1, at, f};
            add_piece(m, &part, t, end, parent, sign, force_miss, slope_miss, force, J);
        }
        f += 2.0 * sign * rise;
        t = end;
        x = y;
        at = next;
    }
}

/* Derivative of the integrals by the times of the turning points, at which a rigid law jumps. */
static void add_jumps(Motion *m, double *J)
{
    int size = m->size;
    for (int r = 0; r < m->turns; r++) {
        double rates[3], *phi = m->phi + r * size;
        place_at(m, m->times[r], rates);
        double rise = (m->x[(r + 1) % m->turns] > m->x[r] ? 2.0 : -2.0) * m->jump / rates[1];
        for (int i = 0; i < size; i++)
            for (int q = 1; 2 * q < size; q++) {
                J[i * size + 2 * q - 1] -= phi[i] * rise * order_of(m, q) * phi[2 * q];
                J[i * size + 2 * q] += phi[i] * rise * order_of(m, q) * phi[2 * q - 1];
            }
    }
}

static void settle_harmonics(Motion *m, const Line *l, const double *grid, int points,
                             double tolerance, double *force, double *J)
{
    int size = m->size, n, depth = 1;
    double stiff, k;
    memset(force, 0, (size_t)size * sizeof(double));
    memset(J, 0, (size_t)(size * size) * sizeof(double));
    line_at(l, 0.0, &stiff);
    if (m->jump > 0.0) stiff = 1.0; /* its slope is 0 after the first motion: any scale will do */
    find_turns(m, grid, points);
    if (!(stiff > 0.0)) return; /* no contact */
    if (!(n = m->turns)) { /* limit of small cycles */
        force[0] = copysign(line_at(l, fabs(m->c[0]), &k), m->c[0]);
        for (int i = 0; i < size; i++) J[i * size + i] = i ? stiff : k;
        return;
    }
    memset(m->k_sums, 0, (size_t)m->wide * sizeof(double));
    double most = 0.0;
    for (int pass = 0; pass < 2; pass++) { /* forces at turning points, then the pieces */
        depth = 1;
        m->open[0] = 0;
        m->force[0] = copysign(line_at(l, fabs(m->x[0]), &k), m->x[0]);
        make_functions(m, m->times[0], m->phi);
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
                    add_cut(m, l, begin, t, from, close, m->open[depth - 1], sign, force_miss,
                            slope_miss, force, J);
                    begin = t;
                    from = close;
                }
                depth -= 2;
            }
            int parent = m->open[depth - 1];
            if (pass)
                add_cut(m, l, begin, last, from, end, parent, sign, force_miss, slope_miss, force,
                        J);
            if (pass || way + 1 == n) continue;
            double *by = m->by + (way + 1) * size, *phi = m->phi + (way + 1) * size;
            double value = line_at(l, 0.5 * fabs(end - m->x[parent]), &k);
            m->force[way + 1] = m->force[parent] + 2.0 * sign * value;
            most = fmax(most, fabs(m->force[way + 1]));
            make_functions(m, m->times[way + 1], phi);
            for (int j = 0; j < size; j++)
                by[j] = m->by[parent * size + j] + k * (phi[j] - m->phi[parent * size + j]);
        }
    }
    if (m->jump > 0.0) add_jumps(m, J);
    for (int i = 0; i < size; i++) {
        double factor = i ? 2.0 / TURN : 1.0 / TURN;
        force[i] *= factor;
        for (int j = 0; j < size; j++)
            J[i * size + j] = factor * (J[i * size + j] + product_of(m, m->k_sums, i, j));
    }
}

/* Derivatives of the functions, one row per time. */
static void make_speeds(const Motion *m, double *grid, int points)
{
    for (int i = 0; i < points; i++) {
        double *row = grid + (size_t)i * (size_t)m->size;
        make_functions(m, TURN / points * i, row);
        for (int q = 1; 2 * q < m->size; q++) {
            double even = row[2 * q - 1];
            row[2 * q - 1] = -order_of(m, q) * row[2 * q];
            row[2 * q] = order_of(m, q) * even;
        }
    }
}

/* Rows of [mean, cos 1, sin 1, ...], or of given orders; of nodes on a curve with their rests, or of
 * one table. */
static int run_harmonics(const Argument *a, Result *out, const Profile *curve,
                         const double *rests, const Table *table)
{
    Py_ssize_t rows = a[1].n, size = a[2].n, few = a[6].n;
    int H = (int)(few ? a[6].reals[few - 1] : (double)(size / 2)), points = 16 * H + 16;
    if ((few && size != 2 * few + 1) || rows < 0 || size < 1 || size % 2 == 0 || size > 2001 || a[0].n < rows * size ||
        a[4].n < rows * size || a[5].n < rows * size * size)
        return TOO_SHORT;
    size_t turns = 4 * (size_t)H + 8, n = (size_t)size;
    size_t wide = few ? n * (n + 1) / 2 : 4 * (size_t)H + 1;
    size_t doubles = (size_t)points * n + wide + turns * (3 + 2 * n) + 2 * (n + wide) + 2 * wide + n;
    double *memory = malloc(doubles * sizeof(double)), *at = memory;
    int *open = malloc(turns * sizeof(int));
    if (!memory || !open) {
        free(memory);
        free(open);
        return NO_MEMORY;
    }
    double *grid = at;
    Motion m = {.H = H, .size = (int)size, .wide = (int)wide, .open = open};
    m.orders = few ? a[6].reals : NULL;
    if (table && table->power == 0) m.jump = table->limit; /* constant: rigid */
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
    make_speeds(&m, grid, points);
    m.middle = make_rule(1, m.rule);
    make_end_rule(m.end_rule);
    if (curve && curve->edges) crowd_rule(m.middle, m.rule); /* roots at the ends of pieces */
    for (Py_ssize_t i = 0; i < rows; i++) {
        Line line = {curve, table, rests ? rests[i] : 0.0, -1, 0.0, 0.0};
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
    if (a[7].n < a[1].n) return TOO_SHORT;
    return run_harmonics(a, out, a[8].curve, a[7].reals, NULL);
}

static int run_table_harmonics(const Argument *a, Result *out)
{
    return run_harmonics(a, out, NULL, NULL, a[7].table);
}
