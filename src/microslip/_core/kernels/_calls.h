/* How Python calls a kernel: one parser for all of them. Part of _compiled.c.
 *
 * A kernel is a row of a table: its name, what it takes (a letter an argument), what it gives back
 * (a letter a number), and a C function that sees plain arrays and numbers. Letters of arguments:
 *
 *   a  array of float64, read            A  the same, written
 *   i  array of int64, read              I  the same, written
 *   S  array of float64, read and written: a state, which must not be gone through twice
 *   d  number                            n  whole number
 *   T  table: coefficients, inverse width, power, limit, rate
 *   P  load curve as a profile: coefficients, anchor, inverse width, first panel; or, for what
 *      takes it (harmonics), as pieces: edges, rows, breaks
 *   C  the same, or any curve: a callable that answers all questions of a call at once
 *   H  the same, or any curve: an object that is asked one question at a time
 *
 * and ? behind the letter of an array that may be None. Letters of results are d and n.
 *
 * Measured against cffi in API mode with the same limited API: an array costs 35 ns here and 200 to
 * 340 ns there, which would be 2 to 4 microseconds a call of the kernels of fields.
 */

#define MOST_ARGUMENTS 26
#define MOST_RESULTS 7

typedef struct {
    const char *name, *takes, *gives;
    int (*run)(const Argument *a, Result *out);
    int brief; /* too short to release the interpreter lock */
    const char *doc;
} Kernel;

/* Buffers held during a call. */
typedef struct {
    Argument a[MOST_ARGUMENTS];
    Py_buffer buffers[MOST_ARGUMENTS];
    char kinds[MOST_ARGUMENTS]; /* letters of the arguments */
    int arguments, held;
    Table table;
    Profile curve;
    Questions questions;
} Frame;

static int take_array(Frame *f, PyObject *object, char letter, int optional)
{
    Argument *a = &f->a[f->arguments];
    a->reals = NULL;
    a->n = 0;
    if (optional && object == Py_None) return 1;
    Py_buffer *buffer = &f->buffers[f->held];
    int flags = letter == 'a' || letter == 'i' ? PyBUF_SIMPLE : PyBUF_WRITABLE;
    if (PyObject_GetBuffer(object, buffer, flags) < 0) return 0;
    f->held++;
    a->reals = buffer->buf;
    a->n = buffer->len / (Py_ssize_t)sizeof(double);
    return 1;
}

static int take_real(PyObject *object, double *x)
{
    *x = PyFloat_AsDouble(object);
    return *x != -1.0 || !PyErr_Occurred();
}

static int take_whole(PyObject *object, Py_ssize_t *n)
{
    *n = PyNumber_AsSsize_t(object, PyExc_OverflowError);
    return *n != -1 || !PyErr_Occurred();
}

/* Coefficients of panels with the given number of terms, for a table or a profile. */
static int take_panels(Frame *f, PyObject *object, int terms, const double **first,
                       Py_ssize_t *panels)
{
    if (!take_array(f, object, 'a', 0)) return 0;
    *first = f->a[f->arguments].reals;
    *panels = f->a[f->arguments].n / terms;
    if (*panels > 0) return 1;
    PyErr_SetString(PyExc_ValueError, "a buffer is too short for this kernel");
    return 0;
}

static int take_table(Frame *f, PyObject *const *given)
{
    Table *t = &f->table;
    Py_ssize_t power;
    if (!take_panels(f, given[0], TERMS, &t->coefficients, &t->panels) ||
        !take_real(given[1], &t->inverse_width) || !take_whole(given[2], &power) ||
        !take_real(given[3], &t->limit) || !take_real(given[4], &t->rate))
        return 0;
    t->power = (int)power;
    f->a[f->arguments].table = t;
    return 1;
}

/* Edges, rows and breaks of a curve that is smooth between places. */
static int take_pieces(Frame *f, PyObject *const *given)
{
    Profile *p = &f->curve;
    Argument *a = &f->a[f->arguments];
    if (!take_panels(f, given[1], PIECE_ROW, &p->coefficients, &p->panels)) return 0;
    if (!take_array(f, given[2], 'a', 0)) return 0;
    p->breaks = a->reals;
    p->break_count = a->n;
    if (!take_array(f, given[0], 'a', 0)) return 0;
    p->edges = a->reals;
    if (a->n <= p->panels) {
        PyErr_SetString(PyExc_ValueError, "a buffer is too short for this kernel");
        return 0;
    }
    p->anchor = p->edges[0];
    a->curve = p;
    return 1;
}

/* Return the number of arguments used, 0 on failure. */
static int take_curve(Frame *f, PyObject *const *given, Py_ssize_t count, char letter)
{
    Profile *p = &f->curve;
    p->questions = NULL;
    p->edges = NULL;
    p->break_count = 0;
    if (count == 1 && letter != 'P') {
        f->questions.object = given[0];
        f->questions.mode = letter == 'C' ? ASK : ONE;
        p->questions = &f->questions;
        f->a[f->arguments].curve = p;
        return 1;
    }
    if (count == 3) return take_pieces(f, given) ? 3 : 0;
    if (count < 4) {
        PyErr_SetString(PyExc_TypeError, "this kernel needs the four arguments of a profile");
        return 0;
    }
    if (!take_panels(f, given[0], PROFILE_TERMS, &p->coefficients, &p->panels) ||
        !take_real(given[1], &p->anchor) || !take_real(given[2], &p->inverse_width) ||
        !take_whole(given[3], &p->first))
        return 0;
    p->least = (double)-p->first;
    p->most = (double)(p->panels - p->first);
    f->a[f->arguments].curve = p;
    return 4;
}

static int take_all(Frame *f, const Kernel *kernel, PyObject *const *given, Py_ssize_t count)
{
    Py_ssize_t k = 0;
    const char *letter = kernel->takes;
    for (; *letter; letter++, f->arguments++) {
        int took = 1, optional = letter[1] == '?';
        Argument *a = &f->a[f->arguments];
        f->kinds[f->arguments] = *letter;
        if (k + (*letter == 'T' ? 5 : 1) > count) break;
        switch (*letter) {
        case 'd': took = take_real(given[k], &a->x); break;
        case 'n': took = take_whole(given[k], &a->n); break;
        case 'T': took = take_table(f, given + k) ? 5 : 0; break;
        case 'P':
        case 'C':
        case 'H': took = take_curve(f, given + k, count - k, *letter); break;
        default: took = take_array(f, given[k], *letter, optional);
        }
        if (!took) return 0;
        k += took;
        letter += optional;
    }
    if (!*letter && k == count) return 1;
    PyErr_Format(PyExc_TypeError, "%s got %zd arguments, which are not those that it takes: %s",
                 kernel->name, count, kernel->doc);
    return 0;
}

/* Any curve. The kernel branches on the geometry of the steps alone, not on the loads, so it
 * runs twice with all states restored in between: first to collect the separations at which the
 * curve is needed, then with the answers. */
static int run_asking(Frame *f, const Kernel *kernel, Result *out)
{
    Questions *q = &f->questions;
    double *kept = NULL;
    size_t size = 0;
    for (int k = 0; k < f->arguments; k++)
        if (f->kinds[k] == 'S') size += (size_t)f->a[k].n;
    if (size && !(kept = malloc(size * sizeof(double)))) return NO_MEMORY;
    double *at = kept;
    for (int k = 0; k < f->arguments; k++)
        if (f->kinds[k] == 'S' && f->a[k].n) {
            memcpy(at, f->a[k].reals, (size_t)f->a[k].n * sizeof(double));
            at += f->a[k].n;
        }
    int state = kernel->run(f->a, out);
    at = kept;
    for (int k = 0; k < f->arguments; k++)
        if (f->kinds[k] == 'S' && f->a[k].n) {
            memcpy(f->a[k].reals, at, (size_t)f->a[k].n * sizeof(double));
            at += f->a[k].n;
        }
    free(kept);
    if (state == FINE) state = answer_all(q);
    return state == FINE ? kernel->run(f->a, out) : state;
}

static PyObject *give(const Kernel *kernel, const Result *out)
{
    Py_ssize_t count = (Py_ssize_t)strlen(kernel->gives);
    if (count == 0) { /* not Py_RETURN_NONE: in headers of 3.12 it takes no reference, which 3.11
                       * needs */
        Py_IncRef(Py_None);
        return Py_None;
    }
    PyObject *all = count > 1 ? PyTuple_New(count) : NULL;
    if (count > 1 && !all) return NULL;
    for (Py_ssize_t k = 0; k < count; k++) {
        PyObject *one = kernel->gives[k] == 'n' ? PyLong_FromSsize_t(out[k].n)
                                                : PyFloat_FromDouble(out[k].x);
        if (count == 1) return one;
        if (!one) {
            Py_DecRef(all);
            return NULL;
        }
        PyTuple_SetItem(all, k, one);
    }
    return all;
}

static PyObject *call(PyObject *self, PyObject *const *given, Py_ssize_t count)
{
    const Kernel *kernel = PyCapsule_GetPointer(self, NULL);
    if (!kernel) return NULL;
    Frame f;
    Result out[MOST_RESULTS];
    f.arguments = f.held = 0;
    memset(&f.questions, 0, sizeof(f.questions));
    int state = -1;
    if (take_all(&f, kernel, given, count)) {
        if (f.questions.mode == ASK) {
            state = run_asking(&f, kernel, out);
        } else if (kernel->brief || f.questions.mode == ONE) {
            state = kernel->run(f.a, out);
        } else {
            Py_BEGIN_ALLOW_THREADS
            state = kernel->run(f.a, out);
            Py_END_ALLOW_THREADS
        }
    }
    free(f.questions.drops);
    free(f.questions.loads);
    for (int k = 0; k < f.held; k++) PyBuffer_Release(&f.buffers[k]);
    if (PyErr_Occurred()) return NULL;
    if (state == TOO_SHORT) {
        PyErr_Format(PyExc_ValueError, "a buffer is too short for this kernel (%s)", kernel->name);
        return NULL;
    }
    if (state == NO_MEMORY || f.questions.failed) return PyErr_NoMemory();
    return give(kernel, out);
}

/* Add every kernel of a table to the module; `methods` has room for all of them. */
static int add_kernels(PyObject *module, const Kernel *kernels, PyMethodDef *methods, int count)
{
    for (int k = 0; k < count; k++) {
        PyMethodDef *method = &methods[k];
        method->ml_name = kernels[k].name;
        method->ml_meth = (PyCFunction)(void (*)(void))call;
        method->ml_flags = METH_FASTCALL;
        method->ml_doc = kernels[k].doc;
        PyObject *self = PyCapsule_New((void *)&kernels[k], NULL, NULL);
        PyObject *function = self ? PyCFunction_NewEx(method, self, NULL) : NULL;
        Py_XDECREF(self);
        int added = function ? PyModule_AddObjectRef(module, kernels[k].name, function) : -1;
        Py_XDECREF(function);
        if (added < 0) return -1;
    }
    return 0;
}
