/* Load curves and backbones that are smooth between given places only. Part of _compiled.c.
 *
 * Piece i lies between two edges. With z = (right edge - x)/width, N = N_r + z G(s), where s is
 * 2 z - 1, or 2 sqrt(z) - 1 where N - N_r has roots of z as at the end of a contact. A row holds N_r,
 * whether roots are taken, 1/width, G(1) = N at the left edge less N_r, and the powers of G. All
 * differences are sums of positive terms, so that no digits are lost near an edge.
 */

enum { PIECE_VALUE, PIECE_ROOTS, PIECE_INVERSE, PIECE_WHOLE, PIECE_POWERS };
#define PIECE_ROW (PIECE_POWERS + TERMS)
#define MOST_SUMMED 256 /* pieces whose differences are summed individually */

/* Piece of a place; `panels` past the last edge. */
static inline Py_ssize_t find_piece(const Profile *p, double x)
{
    const double *edges = p->edges;
    if (!(x < edges[p->panels])) return p->panels;
    Py_ssize_t low = 0, count = p->panels;
    while (count > 1) {
        Py_ssize_t half = count / 2;
        low += x >= edges[low + half] ? half : 0;
        count -= half;
    }
    return low;
}

static inline const double *piece_at(const Profile *p, Py_ssize_t i)
{
    return p->coefficients + i * PIECE_ROW;
}

static inline double piece_load(const Profile *p, double x, double *fall)
{
    Py_ssize_t i = find_piece(p, x);
    if (fall) *fall = 0.0;
    if (i >= p->panels) return 0.0;
    const double *row = piece_at(p, i), *c = row + PIECE_POWERS;
    double z = (p->edges[i + 1] - x) * row[PIECE_INVERSE], y = z;
    if (row[PIECE_ROOTS] != 0.0) y = sqrt(z);
    double s = 2.0 * y - 1.0, value = shape(c, s);
    if (fall) {
        double slope = shape_slope(c, s) * (row[PIECE_ROOTS] != 0.0 ? y : 2.0 * z);
        *fall = row[PIECE_INVERSE] * (value + slope);
    }
    return row[PIECE_VALUE] + z * value;
}

/* -N'' */
static inline double piece_bend(const Profile *p, double x)
{
    Py_ssize_t i = find_piece(p, x);
    if (i >= p->panels) return 0.0;
    const double *row = piece_at(p, i), *c = row + PIECE_POWERS;
    double z = (p->edges[i + 1] - x) * row[PIECE_INVERSE], y = z, bend = 0.0;
    int roots = row[PIECE_ROOTS] != 0.0;
    if (roots) y = sqrt(z);
    double s = 2.0 * y - 1.0, slope = shape_slope(c, s);
    for (int k = TERMS - 1; k >= 2; k--) bend = bend * s + k * (k - 1) * c[k];
    double sum = roots ? 1.5 * slope / fmax(y, 1e-150) + bend : 4.0 * (slope + z * bend);
    return -row[PIECE_INVERSE] * row[PIECE_INVERSE] * sum;
}

/* Difference of N over a width, from a place z of a piece. */
static inline double piece_part(const double *row, double z, double width)
{
    const double *c = row + PIECE_POWERS;
    double by = width * row[PIECE_INVERSE], end = fmax(z - by, 0.0), y = z, last = end, gap = by;
    if (row[PIECE_ROOTS] != 0.0) {
        y = sqrt(z);
        last = sqrt(end);
        gap = y + last > 0.0 ? by / (y + last) : 0.0;
    }
    double s = 2.0 * y - 1.0, t = 2.0 * last - 1.0, value = c[TERMS - 1], rise = 0.0;
    for (int k = TERMS - 2; k >= 0; k--) {
        rise = rise * t + value;
        value = value * s + c[k];
    }
    return by * value + 2.0 * end * gap * rise;
}

static double piece_drop(const Profile *p, double base, double width)
{
    double far = base + width;
    Py_ssize_t i = find_piece(p, base), last = find_piece(p, far);
    if (i >= p->panels) return 0.0;
    const double *row = piece_at(p, i);
    double z = (p->edges[i + 1] - base) * row[PIECE_INVERSE];
    if (i == last) return piece_part(row, z, width);
    double sum = piece_part(row, z, p->edges[i + 1] - base);
    if (last - i - 1 > MOST_SUMMED)
        sum += row[PIECE_VALUE] - (last > i + 1 ? piece_at(p, last - 1)[PIECE_VALUE] : 0.0);
    else
        for (Py_ssize_t k = i + 1; k < last; k++) sum += piece_at(p, k)[PIECE_WHOLE];
    if (last >= p->panels) return sum;
    return sum + piece_part(piece_at(p, last), 1.0, far - p->edges[last]);
}

/* N(base) - N(far) and -N'(far) for a base in piece `i` and a far place that is not before it. */
static inline double piece_ahead(const Profile *p, Py_ssize_t i, double base, double far,
                                 double *fall)
{
    double sum = 0.0;
    *fall = 0.0;
    for (; i < p->panels && far >= p->edges[i + 1]; i++, base = p->edges[i]) {
        const double *row = piece_at(p, i);
        double z = (p->edges[i + 1] - base) * row[PIECE_INVERSE];
        sum += base == p->edges[i] ? row[PIECE_WHOLE] : piece_part(row, z, p->edges[i + 1] - base);
    }
    if (i >= p->panels) return sum;
    const double *row = piece_at(p, i), *c = row + PIECE_POWERS;
    int roots = row[PIECE_ROOTS] != 0.0;
    double z = (p->edges[i + 1] - far) * row[PIECE_INVERSE], y = roots ? sqrt(z) : z;
    double s = 2.0 * y - 1.0;
    *fall = row[PIECE_INVERSE] * (shape(c, s) + shape_slope(c, s) * (roots ? y : 2.0 * z));
    return sum + piece_part(row, (p->edges[i + 1] - base) * row[PIECE_INVERSE], fmax(far - base, 0.0));
}

/* First break above x, and the number of breaks between x and y. */
static Py_ssize_t breaks_between(const Profile *p, double x, double y, const double **first)
{
    Py_ssize_t low = 0, count = p->break_count;
    while (count > 0) {
        Py_ssize_t half = count / 2;
        if (p->breaks[low + half] > x) {
            count = half;
        } else {
            low += half + 1;
            count -= half + 1;
        }
    }
    *first = p->breaks + low;
    Py_ssize_t n = 0;
    while (low + n < p->break_count && p->breaks[low + n] < y) n++;
    return n;
}
