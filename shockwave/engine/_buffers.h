/* Arguments of the functions: buffers from Python, whose types are checked here, followed by other objects. */

#include <stdint.h>
#include <string.h>

#define MOST_BUFFERS 16

typedef struct {
    Py_buffer view[MOST_BUFFERS];
    Py_ssize_t size[MOST_BUFFERS]; /* number of elements */
    int count;
} Buffers;

static void release(Buffers *all)
{
    while (all->count > 0) PyBuffer_Release(all->view + --all->count);
}

/* Takes a contiguous buffer for each letter of `kinds`: f float64; writable: F float64, I int64, R records.
   Sets an exception and returns 0 if the arguments are not these and `others` more. */
static int take(Buffers *all, PyObject *args, const char *name, const char *kinds, int others)
{
    const int buffers = (int)strlen(kinds);
    int fits = PyTuple_Size(args) == buffers + others;
    if (!fits) PyErr_Format(PyExc_TypeError, "%s takes %d arguments", name, buffers + others);
    for (all->count = 0; fits && all->count < buffers; all->count++) {
        Py_buffer *view = all->view + all->count;
        const char kind = kinds[all->count], *const formats = kind == 'I' ? "lq" : kind == 'R' ? "T" : "d";
        const int flags = PyBUF_FORMAT | PyBUF_ND | (kind == 'f' ? 0 : PyBUF_WRITABLE);
        if (PyObject_GetBuffer(PyTuple_GetItem(args, all->count), view, flags) < 0) break;
        fits = view->format && *view->format && strchr(formats, *view->format) && (!view->len || (uintptr_t)view->buf % sizeof(double) == 0)
            && (kind == 'R' || (view->itemsize == sizeof(double) && !view->format[1]));
        all->size[all->count] = fits && view->itemsize > 0 ? view->len / view->itemsize : 0;
        if (!fits) PyErr_Format(PyExc_TypeError, "argument %d of %s has elements of another type", all->count + 1, name);
    }
    if (!PyErr_Occurred()) return 1;
    release(all);
    return 0;
}

/* Releases the buffers, and sets an exception: they have the right types, but do not fit one another. */
static PyObject *misfit(Buffers *all, const char *name)
{
    release(all);
    return PyErr_Format(PyExc_ValueError, "the arguments of %s do not fit one another", name);
}
