/* Arguments of a kernel: plain arrays and numbers, filled in by _calls.h. Part of _compiled.c. */

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

/* Results of a kernel. */
enum { FINE, TOO_SHORT, NO_MEMORY };

/* Return 1 if all of these arguments have at least `n` entries. */
static int all_have(const Argument *a, int first, int last, Py_ssize_t n)
{
    for (int k = first; k <= last; k++)
        if (a[k].n < n) return 0;
    return 1;
}
