/* Baselines of the rows for solvers: joints of a given backbone, one scalar at a time.
 *
 * Independent of microslip: Masing's and Madelung's rules with a stack of reversals for each joint,
 * and a backbone as cubic Hermite polynomials between equidistant samples, beyond which the joint
 * slips; or a sum of Jenkins elements. Compiled and called by solver_rows.py.
 */
#include <math.h>
#include <stddef.h>

#define MOST 64 /* open reversals of a joint */

typedef struct {
    double x[MOST], f[MOST], last, force;
    int depth, way;
} Joint;

/* Samples (force, stiffness times spacing) of a backbone. */
typedef struct {
    const double *samples;
    int count;
    double inverse;
} Backbone;

/* Where a step leads: depth of the stack, direction, and whether the last place is on top. */
typedef struct {
    double force;
    int depth, way, pushed;
} Step;

static inline double backbone(const Backbone *b, double u, double *slope)
{
    double z = u * b->inverse;
    if (!(z < b->count - 1)) {
        *slope = 0.0;
        return b->samples[2 * b->count - 2];
    }
    int i = (int)z;
    const double *p = b->samples + 2 * i;
    double t = z - i, rise = p[2] - p[0], a = p[1] - rise, c = rise - p[3];
    double bend = (1.0 - t) * a + t * c;
    *slope = b->inverse * (rise + (1.0 - 2.0 * t) * bend + t * (1.0 - t) * (c - a));
    return p[0] + t * rise + t * (1.0 - t) * bend;
}

static inline Step step(const Joint *j, const Backbone *b, double x, double *slope)
{
    int depth = j->depth, way = x > j->last ? 1 : x < j->last ? -1 : j->way;
    Step s = {0.0, 0, way, 0};
    if (way == -j->way) {
        double next = depth ? j->x[depth - 1] * way : fabs(j->last);
        if (x * way < next) s.pushed = 1; /* inside the last branch: the reversal opens a new one */
        else if (depth) depth--;
    }
    if (s.pushed) {
        s.depth = depth + 1;
        s.force = j->force + 2.0 * way * backbone(b, 0.5 * fabs(x - j->last), slope);
        return s;
    }
    while (depth > 1 && (x - j->x[depth - 2]) * way >= 0.0) depth -= 2;
    if (depth == 1 && fabs(x) >= fabs(j->x[0])) depth = 0;
    s.depth = depth;
    if (depth)
        s.force = j->f[depth - 1] + 2.0 * way * backbone(b, 0.5 * fabs(x - j->x[depth - 1]), slope);
    else
        s.force = copysign(backbone(b, fabs(x), slope), x);
    return s;
}

static inline void take(Joint *j, double x, const Step *s)
{
    if (s->pushed) {
        j->x[s->depth - 1] = j->last;
        j->f[s->depth - 1] = j->force;
    }
    j->depth = s->depth;
    j->way = s->way;
    j->last = x;
    j->force = s->force;
}

size_t joint_size(void) { return sizeof(Joint); }
size_t step_size(void) { return sizeof(Step); }

/* A trial of all joints, then its commit. */
void node_steps(Joint *joints, Step *steps, int nodes, const Backbone *b, const double *x,
                double *force, double *stiffness)
{
    for (int i = 0; i < nodes; i++) {
        steps[i] = step(&joints[i], b, x[i], &stiffness[i]);
        force[i] = steps[i].force;
    }
    for (int i = 0; i < nodes; i++) take(&joints[i], x[i], &steps[i]);
}

void record(Joint *joint, int count, const Backbone *b, const double *x, double *force)
{
    for (int i = 0; i < count; i++) {
        double slope;
        Step s = step(joint, b, x[i], &slope);
        take(joint, x[i], &s);
        force[i] = s.force;
    }
}

/* A step of joints that are sums of Jenkins elements, each with the displacement of its slider. */
void iwan_steps(int joints, int cells, const double *stiffness, const double *reach, double *sliders,
                const double *x, double *force, double *tangent)
{
    for (int i = 0; i < joints; i++) {
        double sum = 0.0, k = 0.0, *s = sliders + (ptrdiff_t)i * cells;
        for (int c = 0; c < cells; c++) {
            double u = x[i] - s[c];
            k += fabs(u) < reach[c] ? stiffness[c] : 0.0;
            u = u > reach[c] ? reach[c] : u < -reach[c] ? -reach[c] : u;
            s[c] = x[i] - u;
            sum += stiffness[c] * u;
        }
        force[i] = sum;
        tangent[i] = k;
    }
}
