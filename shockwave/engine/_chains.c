/* Integration of chains of mixed granules: the algorithm of chain_run.py in C, operation by operation.

   `_march.h` describes a run, `_law.h` and `_stage.h` compute in blocks of elements, `_control.h` chooses and accepts the
   steps, `_observe.h` reads them. The function takes buffers of float64 and has no state; the global interpreter lock is
   released while it runs. Without the vectors of x86 it is plain C. */

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdlib.h>
#include "_buffers.h"
#include "_interrupt.h"
#include "_vectors.h"
#include "_free_path.h"
#include "_cubic.h"
#include "_septic.h"
#include "_march.h"
#include "_plastic.h"

#ifdef __GNUC__
#define INLINE TARGET static inline __attribute__((always_inline))
#else
#define INLINE static inline
#endif

#ifdef X86_VECTORS
#define WIDTH 8
#define TARGET __attribute__((target("avx512f")))
#define NAME(function) function##_8
#include "_block.h"
#define WIDTH 4
#define TARGET __attribute__((target("avx2")))
#define NAME(function) function##_4
#include "_block.h"
#endif
#define WIDTH 1
#define TARGET
#define NAME(function) function##_1
#include "_block.h"

#include "_observe.h"
#include "_peak_log.h"
#include "_control.h"

/* ---------------------------------------------------------------- Python interface */

enum { METHOD, ROWS, COEFFICIENTS, STOPS, TIMES, WATCHED, IMPULSES, RUN, TABLE, SAMPLES, PLASTIC, CURVES, RECORD, STATES, PEAKS, LAST, VIEWS };
#define SHARED 20 /* rows of the table */

#define KERNEL(width) \
    (Kernel){attempt_##width, evaluate_##width, complete_##width, error_##width, near_##width, changed_##width, passing_##width, \
             turning_##width, above_##width, yielding_##width, raise_scales_##width}

static Kernel widest(void)
{
#ifdef X86_VECTORS
    if (__builtin_cpu_supports("avx512f")) return KERNEL(8);
    if (__builtin_cpu_supports("avx2")) return KERNEL(4);
#endif
    return KERNEL(1);
}

/* Collects the coefficients of a sum that are not zero, and the first. */
static Terms terms_of(const double *a, int stages)
{
    Terms t = {1, {0}, {a[0]}};
    int i;
    for (i = 1; i < stages; i++) if (a[i] != 0) { t.at[t.count] = i; t.a[t.count++] = a[i]; }
    return t;
}

/* Reads a method from its buffer; returns 0 if that is another's. */
static int read_method(Method *method, const double *from, Py_ssize_t count)
{
    const double *positions, *velocities;
    int s, i;
    if (count < 4 || !(from[0] >= 2 && from[0] <= MAX_STAGES && from[1] >= 0 && from[1] < 100)) return 0;
    s = (int)from[0];
    if (count != 5 + s * (2 * s + 7)) return 0;
    positions = from + 5 + s;
    velocities = positions + s * (s + 1);
    *method = (Method){.stages = s, .order = (int)from[1], .damped = from[2] != 0, .last_is_first = from[3] != 0, .jerk = from[5] == 0,
                       .nodes = from + 4, .weights = velocities + s * s};
    for (i = 0; i <= s; i++) {
        method->positions[i] = terms_of(positions + i * s, s);
        method->velocities[i] = terms_of(velocities + i * s, s);
    }
    for (i = 0; i < 4; i++) method->errors[i] = terms_of(velocities + (s + 1 + i) * s, s);
    for (i = 0; i < 2 * s; i++) if (velocities[(s + 3) * s + i] != 0) method->estimates = 4;
    return 1;
}

/* Rows of a run: copies of those of the table, in its order, and those of the work. */
static int make_rows(March *m, const double *table, const double *plastic)
{
    double **const rows[] = {&m->inverse, &m->k, &m->gap, &m->base, &m->root, &m->still, &m->c, &m->far_w, &m->far_u,
        &m->scale_w, &m->scale_u, &m->best, &m->since, &m->lost, &m->start.x, &m->start.v, &m->both, &m->on, &m->exponents,
        &m->powers, &m->mobile, &m->reach_w, &m->reach_u, &m->y, &m->z, &m->shares, &m->flowing, &m->gained, &m->scratch.f};
    End *const ends[] = {&m->start, &m->finish, &m->trial};
    enum { NAMED = sizeof rows / sizeof *rows, OTHERS = 11 };
    const size_t width = (size_t)(m->bodies + BLOCK) / BLOCK * BLOCK + 2 * BLOCK;
    const size_t count = NAMED + 3 * OTHERS + 2 * (size_t)m->method.stages + (m->yields ? PLASTIC_ROWS + (size_t)m->method.stages : 0);
    double *row;
    int i, j;
    m->rows = calloc(count * width + BLOCK, sizeof *row);
    if (!m->rows) return 0;
    row = m->rows + BLOCK + (BLOCK - (uintptr_t)m->rows / sizeof *row % BLOCK) % BLOCK;
    for (i = 0; i < NAMED; i++, row += width) {
        *rows[i] = row;
        if (i < SHARED) memcpy(row, table + i * (m->bodies + 1), (size_t)(m->bodies + 1) * sizeof *row);
    }
    for (i = 0; i < 3; i++) {
        End *const end = ends[i];
        double **const others[OTHERS] = {&end->x, &end->v, &end->u, &end->d, &end->w, &end->f, &end->raw, &end->power, &end->stiffness,
                                         &end->slope, &end->a};
        for (j = i ? 0 : 2; j < OTHERS; j++, row += width) *others[j] = row;
        end->f[-1] = m->r->weight;
    }
    for (i = 0; i < m->method.stages; i++, row += width) m->room[i] = row;
    for (i = 0; i < m->method.stages; i++, row += width) m->forces[i] = row;
    for (i = 0; m->yields && i < m->method.stages; i++, row += width) m->felt[i] = row;
    for (i = 0; m->yields && i < PLASTIC_ROWS; i++, row += width) {
        (&m->plastic.softness)[i] = row;
        memcpy(row, plastic + i * (m->bodies + 1), (size_t)(m->bodies + 1) * sizeof *row);
    }
    m->scratch.f[-1] = m->r->weight;
    return 1;
}

/* Fills the rows beyond the chain, and opens the window. */
static void fill_rows(March *m)
{
    const long end = (m->bodies + BLOCK) / BLOCK * BLOCK + BLOCK;
    long j;
    for (j = (long)m->r->contacts; j < end; j++) m->best[j] = m->r->largest;
    for (j = m->bodies; j < end; j++) {
        m->gap[j] = -m->r->far;
        m->scale_w[j] = m->scale_u[j] = m->r->largest;
    }
    m->hertz = 1;
    m->power = m->powers[0];
    for (j = 0; j < m->bodies; j++) {
        m->loaded = m->loaded || m->base[j] > 0;
        m->hertz = m->hertz && m->exponents[j] == HERTZ;
        m->jumps = m->jumps || (m->damped && m->powers[j] == 0);
        if (m->powers[j] != m->power) m->power = -1;
    }
    list_flows(m);
    widen(m, (long)smaller((double)m->bodies, m->record ? m->record->window : m->r->window));
    if (m->r->guided) m->mobile[0] = 0;
}

/* Copies the results of a run into its tables. */
static void give_rows(const March *m, double *table, double *plastic)
{
    const double *const constants[] = {m->k, m->gap, m->base, m->root};
    const double *const rows[] = {m->scale_w, m->scale_u, m->best, m->since, m->lost, m->start.x, m->start.v};
    const long width = m->bodies + 1;
    int i;
    for (i = 0; i < 7; i++) /* of the greatest forces, only those of contacts */
        memcpy(table + (9 + i) * width, rows[i], (size_t)(i == 2 ? (long)m->r->contacts : m->bodies) * sizeof *table);
    for (i = 0; m->yields && i < 4; i++) memcpy(table + (1 + i) * width, constants[i], (size_t)m->bodies * sizeof *table);
    for (i = 0; m->yields && i < PLASTIC_ROWS; i++)
        memcpy(plastic + i * width, (&m->plastic.softness)[i], (size_t)m->bodies * sizeof *table);
}

/* Whether the rows of elastic-plastic contacts have their number, and each contact with rate its pieces. */
static int curves_fit(const Run *r, const double *plastic, Py_ssize_t count, Py_ssize_t width, Py_ssize_t pieces)
{
    const double *const rate = plastic + 2 * width, *const first = plastic + 4 * width;
    Py_ssize_t j;
    if (count != PLASTIC_ROWS * width) return 0;
    for (j = 0; j < width; j++)
        if (rate[j] != 0 && !(rate[j] > 0 && first[j] >= 0 && first[j] + rate[j] * r->fastest < (double)pieces)) return 0;
    return 1;
}

/* The table of the free-particle displacement; without pieces if it does not fit. */
static Path path_of(const Buffers *all, double rise_time, double force)
{
    const Py_ssize_t pieces = all->size[ROWS] / ROW;
    return (Path){all->view[ROWS].buf, all->view[COEFFICIENTS].buf,
                  pieces_fit(all, ROWS, 0, (double)pieces, 0) ? (long)pieces : 0, 0, rise_time, force};
}

/* Takes the buffers of a record, if there is one; returns 0 if they do not fit one another. */
static int take_record(March *m, const Buffers *all)
{
    const Py_ssize_t *count = all->size, row = 2 * m->bodies + 1;
    Record *const record = all->view[RECORD].buf;
    double *number;
    Py_ssize_t j;
    m->kinks = 1;
    if (!count[RECORD]) return 1;
    if (count[RECORD] != sizeof(Record) / sizeof(double) || all->view[PEAKS].itemsize != sizeof(Peak)) return 0;
    m->record = record;
    m->peaks = all->view[PEAKS].buf;
    m->last_peak = all->view[LAST].buf;
    m->states = all->view[STATES].buf;
    m->most_peaks = (long)count[PEAKS];
    m->most_states = (long)(count[STATES] / row);
    m->kinks = record->kinks != 0;
    for (number = &record->continues; number <= &record->window; number++) if (!(*number >= 0)) return 0;
    if (count[STATES] % row || record->kept != 0 || record->peaks > (double)m->most_peaks || count[LAST] < (Py_ssize_t)m->r->contacts) return 0;
    for (j = 0; j < count[LAST]; j++) if (m->last_peak[j] < -1 || m->last_peak[j] >= (long long)record->peaks) return 0;
    for (j = 0; j < (Py_ssize_t)record->peaks; j++) if (m->peaks[j].previous >= j) return 0;
    return 1;
}

/* Whether the watched contacts are in the chain, those of samples in ascending order, and have their impulses and samples. */
static int watched_fit(const Buffers *all, Py_ssize_t width)
{
    const long long *const watched = all->view[WATCHED].buf;
    const Py_ssize_t *count = all->size, sampled = count[WATCHED] - UNSAMPLED;
    Py_ssize_t i;
    if (sampled < 0 || count[IMPULSES] != count[WATCHED] || count[SAMPLES] != (count[PLASTIC] ? 5 : 4) * sampled * count[TIMES]) return 0;
    for (i = 0; i < count[WATCHED]; i++)
        if (watched[i] < 0 || watched[i] >= width - 1 || (i > UNSAMPLED && watched[i] <= watched[i - 1])) return 0;
    return 1;
}

/* Sets up a run from the buffers; returns 0 if they do not fit one another. */
static int set_up(March *m, const Buffers *all)
{
    const Py_buffer *view = all->view;
    const Py_ssize_t *count = all->size, width = count[TABLE] / SHARED;
    const double *setting;
    Run *r = view[RUN].buf;
    if (view[RUN].len != sizeof(Run) || width < 2 || count[TABLE] % SHARED || !(r->contacts >= 1 && r->contacts <= (double)width - 1)
        || !(r->window >= 1 && r->growth >= 1) || !watched_fit(all, width)) return 0;
    if (count[PLASTIC] && !curves_fit(r, view[PLASTIC].buf, count[PLASTIC], width, count[CURVES] / PIECE)) return 0;
    for (setting = &r->tolerance; setting < &r->status; setting++) if (!(*setting >= 0)) return 0;
    *m = (March){
        .r = r, .kernel = widest(), .stops = view[STOPS].buf, .stop_count = (long)count[STOPS], .times = view[TIMES].buf,
        .sample_count = (long)count[TIMES], .samples = view[SAMPLES].buf, .watched = view[WATCHED].buf, .watched_impulses = view[IMPULSES].buf,
        .watched_count = (long)count[WATCHED], .damped = r->damped != 0, .yields = count[PLASTIC] > 0,
        .plastic.pieces = view[CURVES].buf, .driven = count[ROWS] > 0 && r->time < r->duration, .bodies = (long)width - 1,
        .path = path_of(all, r->rise_time, r->peak_force)};
    if (!take_record(m, all)) return 0;
    if (!read_method(&m->method, view[METHOD].buf, count[METHOD]) || (m->driven && !m->path.pieces)) return 0;
    while (m->stop < m->stop_count && m->stops[m->stop] <= r->time) m->stop++;
    if (m->driven && m->r->time > 0) free_path(&m->path, m->r->time, &m->free[0], &m->free[1]);
    return 1;
}

PyDoc_STRVAR(run_doc, "run(method, rows, coefficients, stops, times, watched, impulses, settings, table, samples, plastic, curves, record,\n"
             "    states, peaks, last, expired)\n--\n\n"
             "Integrates a chain of mixed granules, in place. See chain_backend.py.");

static PyObject *run(PyObject *self, PyObject *args)
{
    Buffers all;
    March m;
    (void)self;
    if (!take(&all, args, "run", "fffffIFFFFFfFFRI", 1)) return NULL;
    if (!set_up(&m, &all)) return misfit(&all, "run");
    if (make_rows(&m, all.view[TABLE].buf, all.view[PLASTIC].buf)) {
        fill_rows(&m);
        m.expired = PyTuple_GetItem(args, VIEWS);
        m.thread = PyEval_SaveThread();
        m.r->status = integrate(&m);
        if (m.record) m.record->window = (double)m.n;
        PyEval_RestoreThread(m.thread);
        give_rows(&m, all.view[TABLE].buf, all.view[PLASTIC].buf);
        free(m.rows);
    } else PyErr_NoMemory();
    release(&all);
    return PyErr_Occurred() ? NULL : Py_NewRef(Py_None);
}

static PyMethodDef functions[] = {{"run", run, METH_VARARGS, run_doc}, {NULL, NULL, 0, NULL}};

static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "_chains", "Compiled integration of chains of mixed granules.",
                                    0, functions, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__chains(void)
{
    return PyModuleDef_Init(&module);
}
