/* Curves that no profile gives: what the kernels ask of them. Part of _compiled.c.
 *
 * ASK writes questions down and answers 0, TELL reads the answers in the same order, ONE asks the
 * object of Python at once, one question at a time (where the next question depends on the answer).
 */

enum { NO_QUESTIONS, ASK, TELL, ONE };

struct Questions {
    PyObject *object;
    int mode, failed;
    double *drops, *loads; /* (base, width, answer) and (place, N, -N') of each question */
    Py_ssize_t drop_count, drop_room, load_count, load_room, drop_next, load_next;
};

/* Slot of a new request, NULL if out of memory. */
static double *add_question(Questions *q, double **list, Py_ssize_t *count, Py_ssize_t *room)
{
    if (*count == *room) {
        Py_ssize_t more = 2 * *room + 16;
        double *longer = realloc(*list, 3 * (size_t)more * sizeof(double));
        if (!longer) {
            q->failed = 1;
            return NULL;
        }
        *list = longer;
        *room = more;
    }
    return *list + 3 * (*count)++;
}

static double ask_drop(Questions *q, double base, double width)
{
    double drop = 0.0;
    if (q->mode == TELL) return q->drop_next < q->drop_count ? q->drops[3 * q->drop_next++ + 2] : 0.0;
    if (q->mode == ASK) {
        double *question = add_question(q, &q->drops, &q->drop_count, &q->drop_room);
        if (question) {
            question[0] = base;
            question[1] = width;
        }
    } else if (!q->failed) {
        PyObject *answer = PyObject_CallMethod(q->object, "drop", "dd", base, width);
        q->failed = !answer;
        if (answer) drop = PyFloat_AsDouble(answer);
        Py_XDECREF(answer);
        q->failed |= PyErr_Occurred() != NULL;
    }
    return drop;
}

static double ask_load(Questions *q, double x, double *fall)
{
    double pair[2] = {0.0, 0.0};
    if (q->mode == TELL) {
        if (q->load_next < q->load_count) memcpy(pair, q->loads + 3 * q->load_next++ + 1, sizeof(pair));
    } else if (q->mode == ASK) {
        double *question = add_question(q, &q->loads, &q->load_count, &q->load_room);
        if (question) question[0] = x;
    } else if (!q->failed) {
        PyObject *answer = PyObject_CallMethod(q->object, "load", "d", x);
        q->failed = !answer;
        for (int k = 0; answer && !q->failed && k < 2; k++) {
            PyObject *number = PySequence_GetItem(answer, k);
            if (number) pair[k] = PyFloat_AsDouble(number);
            Py_XDECREF(number);
            q->failed = PyErr_Occurred() != NULL;
        }
        Py_XDECREF(answer);
    }
    if (fall) *fall = pair[1];
    return pair[0];
}

static PyObject *view_of(double *list, Py_ssize_t count)
{
    static double nothing[3];
    return PyMemoryView_FromMemory((char *)(list ? list : nothing),
                                   3 * count * (Py_ssize_t)sizeof(double), PyBUF_WRITE);
}

/* Let Python evaluate all requests: object(drops, loads) fills in the results. */
static int answer_all(Questions *q)
{
    if (q->failed) return NO_MEMORY;
    PyObject *drops = view_of(q->drops, q->drop_count), *loads = view_of(q->loads, q->load_count);
    PyObject *done =
        drops && loads ? PyObject_CallFunctionObjArgs(q->object, drops, loads, NULL) : NULL;
    q->failed = !done;
    q->mode = TELL;
    Py_XDECREF(done);
    Py_XDECREF(drops);
    Py_XDECREF(loads);
    return q->failed ? -1 : FINE;
}
