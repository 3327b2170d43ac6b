/* What a kernel sees: plain arrays and numbers. Part of _compiled.c; _calls.h fills them in. */

typedef struct Table Table;
typedef struct Profile Profile;

typedef struct {
    union {
        double *reals;
        long long *integers;
        const Table *table;
        const Profile *curve;
    };
    Py_ssize_t n; /* entries of an array, 0 where it is None, or a whole number */
    double x;     /* a number */
} Argument;

typedef struct {
    double x;
    Py_ssize_t n;
} Result;

/* What a kernel returns. */
enum { FINE, TOO_SHORT, NO_MEMORY };

/* Whether all of these arguments have `n` entries at least. */
static int all_have(const Argument *a, int first, int last, Py_ssize_t n)
{
    for (int k = first; k <= last; k++)
        if (a[k].n < n) return 0;
    return 1;
}
