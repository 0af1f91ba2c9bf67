/* Search for the leading wave of several shocks, one per lane: the algorithm of wave_search_numpy.py in C.

   Scaled units: mass and contact stiffness 1. The contact force is d^p of the overlap d, with Hertz's p = 3/2 unless the
   method is followed by another exponent. Row j of an array contains granule j of all lanes, so that the element
   of granule j is e = j * lanes + lane; neighbours are `lanes` elements apart. The arithmetic does not depend on the
   number of lanes: the results of a shock are identical to the last bit, whether it runs alone or among others (as
   long as the compiler does not fuse products and sums, see setup.py).

   `_window.h` is one step of all lanes, `_lane.h` a shock, `_front.h` the peaks of its leading wave, `_search.h` runs all
   jobs; `_wave.h` measures a wave of any chain. The functions take buffers of float64 and have no state; the global
   interpreter lock is released while they run. */

#ifndef Py_LIMITED_API
#define Py_LIMITED_API 0x030B0000
#endif
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <limits.h>
#include <stdlib.h>
#include "_buffers.h"
#include "_interrupt.h"
#include "_vectors.h"
#include "_free_path.h"
#include "_window.h"
#include "_lane.h"
#include "_front.h"
#include "_search.h"
#include "_septic.h"
#include "_wave.h"

/* Whether all parts of a job exist: its pieces, a stop at its end, the requested contacts. */
static int job_fits(const double *job, const Buffers *all)
{
    const double *stop = all->view[4].buf;
    Py_ssize_t k;
    for (k = 0; k < JOB; k++) if (!(job[k] >= 0 && job[k] < 1e300)) return 0;
    for (k = FIRST_PIECE; k < JOB; k++) if (job[k] > MAX_COUNT) return 0;
    if (!(job[GRANULES] == 0 || (job[GRANULES] >= 2 && job[GRANULES] <= MAX_COUNT))) return 0;
    if (!(job[RISE_TIME] > 0 && job[DURATION] > 0 && job[TOLERANCE] > 0 && job[REAR] >= BLOCK)) return 0;
    if (!pieces_fit(all, 2, job[FIRST_PIECE], job[PIECES], job[FIRST_COEFFICIENT])) return 0;
    if (job[FIRST_WANTED] + job[WANTED] > (double)(all->size[5] / PASSAGE)) return 0;
    for (k = (Py_ssize_t)job[FIRST_STOP]; k < all->size[4]; k++) if (stop[k] >= job[DURATION]) return 1;
    return 0;
}

static int jobs_fit(const Buffers *all)
{
    const Py_ssize_t count = all->size[1] / JOB;
    Py_ssize_t k;
    if (all->size[1] != JOB * count || all->size[6] != FOUND * count) return 0;
    for (k = 0; k < count; k++) if (!job_fits((const double *)all->view[1].buf + JOB * k, all)) return 0;
    return 1;
}

PyDoc_STRVAR(primary_doc, "primary(method, jobs, rows, coefficients, stops, wanted, found, lanes, expired)\n--\n\n"
             "Runs every job (a row of `jobs`) until the leading wave is known; fills `wanted` and `found`.\n"
             "Jobs that have not ended when `expired()` is true are left as they are. See wave_search.py.");

static PyObject *primary(PyObject *self, PyObject *args)
{
    Buffers all;
    Method method;
    Batch batch;
    long lanes;
    int ok;
    (void)self;
    if (!take(&all, args, "primary", "fffffFF", 2)) return NULL;
    lanes = PyLong_AsLong(PyTuple_GetItem(args, 7));
    if (!method_of(all.view[0].buf, all.size[0], &method) || (lanes != 1 && lanes != BLOCK) || !jobs_fit(&all)) {
        PyErr_Clear();
        return misfit(&all, "primary");
    }
    batch = (Batch){
        .jobs = all.view[1].buf, .rows = all.view[2].buf, .coefficients = all.view[3].buf, .stops = all.view[4].buf,
        .wanted = all.view[5].buf, .found = all.view[6].buf, .count = (long)(all.size[1] / JOB),
        .expired = PyTuple_GetItem(args, 8)};
    batch.thread = PyEval_SaveThread();
    ok = run(&method, &batch, lanes);
    PyEval_RestoreThread(batch.thread);
    release(&all);
    if (PyErr_Occurred()) return NULL;
    if (!ok && !batch.stopped) return PyErr_NoMemory();
    Py_RETURN_NONE;
}

PyDoc_STRVAR(read_doc, "read(times, states, wave)\n--\n\n"
             "Measures a wave from positions and velocities of four granules at these times. See wave_properties.py.");

static PyObject *read_one(PyObject *self, PyObject *args)
{
    Buffers all;
    Py_ssize_t count;
    int ok;
    (void)self;
    if (!take(&all, args, "read", "ffF", 0)) return NULL;
    count = all.size[0];
    if (count < 2 || all.size[1] != 8 * count || all.size[2] != WAVE) return misfit(&all, "read");
    ok = read_wave(all.view[0].buf, all.view[1].buf, (double *)all.view[1].buf + 4 * count, (long)count, all.view[2].buf);
    release(&all);
    if (!ok) return PyErr_NoMemory();
    Py_RETURN_NONE;
}

static PyMethodDef functions[] = {
    {"primary", primary, METH_VARARGS, primary_doc},
    {"read", read_one, METH_VARARGS, read_doc},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT, "_lanes", "Compiled search for the leading waves of shocks.", 0, functions, NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__lanes(void)
{
    return PyModuleDef_Init(&module);
}
