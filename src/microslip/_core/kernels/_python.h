/* What this module uses of Python's stable ABI (PEP 384, CPython 3.11 on), declared once more.
 *
 * Distributions pack Python.h apart from Python, and a machine without a compiler seldom has it. The
 * layouts here are those that the stable ABI freezes; where Python.h is found, it is what counts.
 */
#include <stddef.h>

typedef ptrdiff_t Py_ssize_t;
typedef struct PyTypeObject PyTypeObject;

typedef struct {
    Py_ssize_t ob_refcnt;
    PyTypeObject *ob_type;
} PyObject;

typedef struct {
    void *buf;
    PyObject *obj;
    Py_ssize_t len, itemsize;
    int readonly, ndim;
    char *format;
    Py_ssize_t *shape, *strides, *suboffsets;
    void *internal;
} Py_buffer;

typedef PyObject *(*PyCFunction)(PyObject *, PyObject *);

typedef struct {
    const char *ml_name;
    PyCFunction ml_meth;
    int ml_flags;
    const char *ml_doc;
} PyMethodDef;

typedef struct {
    int slot;
    void *value;
} PyModuleDef_Slot;

typedef struct PyModuleDef {
    PyObject ob_base;
    PyObject *(*m_init)(void);
    Py_ssize_t m_index;
    PyObject *m_copy;
    const char *m_name, *m_doc;
    Py_ssize_t m_size;
    PyMethodDef *m_methods;
    PyModuleDef_Slot *m_slots;
    void *m_traverse, *m_clear, *m_free;
} PyModuleDef;

#define PyModuleDef_HEAD_INIT {1, NULL}, NULL, 0, NULL
#define PyMODINIT_FUNC __attribute__((visibility("default"))) PyObject *
#define PyBUF_SIMPLE 0
#define PyBUF_WRITABLE 1
#define PyBUF_WRITE 0x200
#define METH_FASTCALL 0x80
#define Py_mod_exec 2
#define Py_None (&_Py_NoneStruct)
#define Py_BEGIN_ALLOW_THREADS { void *thread = PyEval_SaveThread();
#define Py_END_ALLOW_THREADS PyEval_RestoreThread(thread); }
#define Py_XDECREF(object) Py_DecRef((PyObject *)(object))

extern PyObject _Py_NoneStruct, *PyExc_OverflowError, *PyExc_TypeError, *PyExc_ValueError;

int PyObject_GetBuffer(PyObject *, Py_buffer *, int);
void PyBuffer_Release(Py_buffer *);
double PyFloat_AsDouble(PyObject *);
PyObject *PyFloat_FromDouble(double);
PyObject *PyLong_FromSsize_t(Py_ssize_t);
Py_ssize_t PyNumber_AsSsize_t(PyObject *, PyObject *);
PyObject *PyErr_Occurred(void);
void PyErr_SetString(PyObject *, const char *);
PyObject *PyErr_Format(PyObject *, const char *, ...);
PyObject *PyErr_NoMemory(void);
void Py_IncRef(PyObject *);
void Py_DecRef(PyObject *);
PyObject *PyTuple_New(Py_ssize_t);
int PyTuple_SetItem(PyObject *, Py_ssize_t, PyObject *);
PyObject *PySequence_GetItem(PyObject *, Py_ssize_t);
PyObject *PyObject_CallMethod(PyObject *, const char *, const char *, ...);
PyObject *PyObject_CallFunctionObjArgs(PyObject *, ...);
PyObject *PyMemoryView_FromMemory(char *, Py_ssize_t, int);
PyObject *PyCapsule_New(void *, const char *, void (*)(PyObject *));
void *PyCapsule_GetPointer(PyObject *, const char *);
PyObject *PyCFunction_NewEx(PyMethodDef *, PyObject *, PyObject *);
int PyModule_AddObjectRef(PyObject *, const char *, PyObject *);
int PyModule_AddIntConstant(PyObject *, const char *, long);
PyObject *PyModuleDef_Init(PyModuleDef *);
void *PyEval_SaveThread(void);
void PyEval_RestoreThread(void *);
