/* Search for the leading wave of several shocks, one per lane: the algorithm of wave_search_numpy.py in C.

   Scaled units: mass and contact stiffness 1. The contact force is d^p of the overlap d, with Hertz's p = 3/2 unless the
   method is followed by another exponent. Row j of an array contains granule j of all lanes, so that the element
   of granule j is e = j * lanes + lane; neighbours are `lanes` elements apart. The arithmetic does not depend on the
   number of lanes: the results of a shock are identical to the last bit, whether it runs alone or among others (as
   long as the compiler does not fuse products and sums, see setup.py).

   The functions take buffers of float64 and have no state; the global interpreter lock is released while they run. */

#ifndef Py_LIMITED_API
#define Py_LIMITED_API 0x030B0000
#endif
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <limits.h>
#include <stdlib.h>
#include "_buffers.h"
#include "_free_path.h"

/* `attempt` selects one of the versions of _step.h when it is called. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define X86_VECTORS
#include <immintrin.h>
#endif
/* Compiled for several vector widths; the loader selects the widest that the processor supports. */
#if defined(X86_VECTORS) && defined(__GLIBC__)
#define WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define WIDE
#endif

#define BLOCK 8           /* elements processed at a time: the lanes of one granule, or eight granules of one lane */
#define MIN_OVERLAP 1e-40 /* smaller overlaps count as zero: arithmetic with subnormal numbers is slow */
#define MAX_STAGES 17
#define HERTZ 1.5

/* Half a block as one value. Code for values that are wider than the vectors of the processor would be many times
   slower. */
#define HALF (BLOCK / 2)
typedef double Vector __attribute__((vector_size(HALF * sizeof(double)), aligned(sizeof(double)), may_alias));
typedef long long Choice __attribute__((vector_size(HALF * sizeof(double))));
#define VECTOR(address) (*(Vector *)(address))
#define MAGNITUDE 0x7fffffffffffffffLL
#define ABSOLUTE(v) ((Vector)((Choice)(v) & (Choice){MAGNITUDE, MAGNITUDE, MAGNITUDE, MAGNITUDE}))
/* `other` where it is larger or a NaN, else `one`, so that a NaN is kept; for vectors of floats and of whole numbers */
#define LARGER_OF(Floats, Whole, one, other) \
    ((Floats)(((Whole)(other) & (((other) > (one)) | ((other) != (other)))) \
              | ((Whole)(one) & ~(((other) > (one)) | ((other) != (other))))))
#define GREATER(one, other) LARGER_OF(Vector, Choice, one, other)

/* ---------------------------------------------------------------- the method */

typedef struct {
    int stages, error_order, last_is_next;
    double exponent;
    const double *c, *a, *b, *bp, *e, *ep; /* a: stages x stages, row by row */
} Method;

static int method_of(const double *data, Py_ssize_t size, Method *method)
{
    int s;
    if (size < 3 || !(data[0] >= 2 && data[0] <= MAX_STAGES && data[1] >= 0 && data[1] < 100)) return 0;
    s = (int)data[0];
    if (size != 3 + s * (s + 5) && size != 4 + s * (s + 5)) return 0;
    method->exponent = size == 4 + s * (s + 5) ? data[size - 1] : HERTZ;
    if (!(method->exponent > 1 && method->exponent < 100)) return 0;
    method->stages = s;
    method->error_order = (int)data[1];
    method->last_is_next = data[2] != 0;
    method->c = data + 3;
    method->a = method->c + s;
    method->b = method->a + s * s;
    method->bp = method->b + s;
    method->e = method->bp + s;
    method->ep = method->e + s;
    return 1;
}

/* ---------------------------------------------------------------- one step of all lanes */

/* Arrays of a window, each with at least `lanes` zeros before its first element and spare elements after its last. */
typedef struct {
    long lanes, room, used; /* room: elements of each array; used: leading elements that may be nonzero */
    double exponent;
    double *block;
    double *x, *v, *x1, *v1, *y, *f, *late, *since, *k[MAX_STAGES];
} Window;

static int window_of(Window *w, long lanes, long rows, double exponent)
{
    long pad = (lanes + BLOCK - 1) / BLOCK * BLOCK, i;
    double **const arrays[] = {&w->x, &w->v, &w->x1, &w->v1, &w->y, &w->f, &w->late, &w->since};
    const long named = (long)(sizeof arrays / sizeof *arrays);
    double *at;
    w->block = NULL;
    if (rows > (LONG_MAX / (named + MAX_STAGES) - 3 * pad) / lanes) return 0;
    w->lanes = lanes;
    w->used = 0;
    w->exponent = exponent;
    w->room = (rows * lanes + BLOCK - 1) / BLOCK * BLOCK;
    w->block = calloc((size_t)((named + MAX_STAGES) * (w->room + 3 * pad) + BLOCK), sizeof(double));
    if (!w->block) return 0;
    /* blocks aligned to cache lines, which have the same size, do not straddle two of them */
    at = (double *)(((uintptr_t)w->block / (BLOCK * sizeof(double)) + 1) * (BLOCK * sizeof(double))) + pad;
    for (i = 0; i < named + MAX_STAGES; i++, at += w->room + 3 * pad)
        *(i < named ? arrays[i] : &w->k[i - named]) = at;
    return 1;
}

/* Accelerations k[terms] at the positions y = x + c h v + h^2 sum of a_j k_j, j < terms, with h of shape (BLOCK,), and
   the contact forces f. `shift` is added to the first row. */
static void stage(long n, int terms, double c, const double *a, const double *h, const double *shift, Window *w)
{
    const Vector step = VECTOR(h) * c, square = VECTOR(h) * VECTOR(h);
    const Vector step2 = VECTOR(h + HALF) * c, square2 = VECTOR(h + HALF) * VECTOR(h + HALF);
    const long lanes = w->lanes;
    const double *const x = w->x, *const v = w->v;
    double *const *const k = w->k, *const out = k[terms], *const y = w->y, *const f = w->f;
    long e;
    int j;
    for (e = 0; e < n; e += BLOCK) {
        Vector sum = square - square, sum2 = sum;
        for (j = 0; j < terms; j++) {
            sum += VECTOR(k[j] + e) * a[j];
            sum2 += VECTOR(k[j] + e + HALF) * a[j];
        }
        VECTOR(y + e) = VECTOR(x + e) + step * VECTOR(v + e) + square * sum;
        VECTOR(y + e + HALF) = VECTOR(x + e + HALF) + step2 * VECTOR(v + e + HALF) + square2 * sum2;
    }
    /* granules beyond the window are at rest */
    for (e = n; e < n + lanes; e++) y[e] = x[e];
    for (e = 0; e < lanes; e++) y[e] += shift[e];
    for (e = 0; e < n; e++) {
        const double gap = y[e] - y[e + lanes];
        f[e] = gap > MIN_OVERLAP ? gap : 0;
    }
    if (w->exponent == HERTZ) for (e = 0; e < n; e++) f[e] = f[e] * sqrt(f[e]);
    else for (e = 0; e < n; e++) f[e] = f[e] > 0 ? f[e] * pow(f[e], w->exponent - 1) : 0;
    for (e = 0; e < n; e++) out[e] = f[e - lanes] - f[e];
}

/* The new state x1, v1, and its largest difference from the embedded method for each element of a block. */
static void combine(long n, const Method *m, const double *h, Window *w, double *worst)
{
    double *const *const k = w->k;
    long e, half;
    int j;
    for (half = 0; half < BLOCK; half += HALF) {
        const Vector step = VECTOR(h + half), square = step * step;
        Vector most = step - step;
        for (e = half; e < n; e += BLOCK) {
            const Vector first = VECTOR(k[0] + e);
            Vector b = first * m->b[0], bp = first * m->bp[0], d = first * m->e[0], dp = first * m->ep[0];
            for (j = 1; j < m->stages; j++) {
                const Vector kj = VECTOR(k[j] + e);
                b += kj * m->b[j];
                bp += kj * m->bp[j];
                d += kj * m->e[j];
                dp += kj * m->ep[j];
            }
            VECTOR(w->x1 + e) = VECTOR(w->x + e) + step * VECTOR(w->v + e) + square * b;
            VECTOR(w->v1 + e) = VECTOR(w->v + e) + step * bp;
            d = ABSOLUTE(square * d);
            dp = ABSOLUTE(step * dp);
            most = GREATER(most, d);
            most = GREATER(most, dp);
        }
        VECTOR(worst + half) = most;
    }
}

#ifdef X86_VECTORS
typedef double Values4 __attribute__((vector_size(32), aligned(8), may_alias));
typedef long long Bits4 __attribute__((vector_size(32)));
typedef double Values8 __attribute__((vector_size(64), aligned(8), may_alias));
typedef long long Bits8 __attribute__((vector_size(64)));

#define WITH_VECTORS __attribute__((target("avx2")))
#define NAME(function) function##_avx2
#define Values Values4
#define Bits Bits4
#define PARTS 2
#define SINGLE(w) ((w)->lanes == 1)
/* A block without a closed contact needs no roots. One lane has many such blocks; with several lanes they are too irregular
   for the branch to be predicted. */
#define FORCES(e) \
    for (i = 0; i < PARTS; i++) force[i] = overlap[i]; \
    if (!single || !_mm256_testz_si256((__m256i)overlap[0] | (__m256i)overlap[1], (__m256i)overlap[0] | (__m256i)overlap[1])) \
        for (i = 0; i < PARTS; i++) force[i] *= (Values)_mm256_sqrt_pd((__m256d)overlap[i]);
#include "_step.h"

/* Square roots by Newton's method instead of the divider, which takes longer than all other arithmetic of a stage. They
   are correctly rounded, like those of the divider (Markstein, IBM Journal of Research and Development 34 (1990) 111). */
__attribute__((target("avx512f"))) static inline __m512d roots(__m512d d)
{
    const __m512d half = _mm512_set1_pd(0.5);
    const __m512d y = _mm512_maskz_rsqrt14_pd(_mm512_test_epi64_mask((__m512i)d, (__m512i)d), d);
    __m512d root = d * y, slope = half * y, rest;
    int i;
    for (i = 0; i < 2; i++) {
        rest = _mm512_fnmadd_pd(root, slope, half);
        root = _mm512_fmadd_pd(root, rest, root);
        slope = _mm512_fmadd_pd(slope, rest, slope);
    }
    return _mm512_fmadd_pd(slope, _mm512_fnmadd_pd(root, root, d), root);
}

#define WITH_VECTORS __attribute__((target("avx512f")))
#define NAME(function) function##_avx512
#define Values Values8
#define Bits Bits8
#define PARTS 1
#define SINGLE(w) 0
/* alternate blocks use the divider, which works in parallel with the arithmetic of `roots` */
#define FORCES(e) force[0] = overlap[0] * (Values)((e) / BLOCK % 2 ? roots((__m512d)overlap[0]) : _mm512_sqrt_pd((__m512d)overlap[0]));
#include "_step.h"
#endif

/* Attempts a step of sizes h from x, v with accelerations k[0]. `shift`, stages x BLOCK, is the free-particle
   displacement at the stages. Sets x1, v1 to the new state and `worst` to the largest error of each element. */
static void attempt(const Method *m, Window *w, long n, const double *h, const double *shift, double *worst)
{
    int i;
#ifdef X86_VECTORS
    if (w->exponent == HERTZ && w->lanes == BLOCK && __builtin_cpu_supports("avx512f")) {
        attempt_avx512(m, w, n, h, shift, worst);
        return;
    }
    if (w->exponent == HERTZ && __builtin_cpu_supports("avx2")) {
        attempt_avx2(m, w, n, h, shift, worst);
        return;
    }
#endif
    for (i = 1; i < m->stages; i++)
        stage(n, i, m->c[i], m->a + i * m->stages, h, shift + i * BLOCK, w);
    combine(n, m, h, w, worst);
}


/* ---------------------------------------------------------------- a lane: one shock */

/* Columns of a job and of its result; see wave_search.py. */
enum { RISE_TIME, FORCE, DURATION, GRANULES, TOLERANCE, DOUBT, MAX_CONTACTS, MAX_WORK, REAR, EARLIEST_TIME,
       GROWING, ABOVE, FIRST_PIECE = ABOVE + 10, PIECES,
       FIRST_COEFFICIENT, FIRST_STOP, FIRST_WANTED, WANTED, JOB };
enum { WANTED_CONTACT, WANTED_TIME, WANTED_FORCE, PASSAGE };   /* contacts in ascending order */
enum { STATUS, PEAK, LAST, CONTACT, TIME, DOUBT_LEFT, SPEED, MOMENTUM, ENERGY, FOOT, CHAIN_MOMENTUM, CHAIN_ENERGY, WORK,
       IMPULSE, FREE_PATH, STEPS, EVALUATIONS, FOUND };
enum { RUNNING, KNOWN, TOO_LONG, AT_END, FAILED };   /* STATUS */

/* See peak_limit.py and wave_search_numpy.py for the meaning of the constants of the same names. */
#define MAX_COUNT ((double)(LONG_MAX / 8)) /* largest valid count or index */
#define STRIDE 4       /* contacts between the peaks that are used for the limit */
#define KEPT 5         /* number of these peaks */
#define SLOW 200       /* assumed sum of a slowly converging series, in units of its last term */
#define NOISE 0.2      /* fraction of the permitted uncertainty below which alternating differences are noise */
#define STEADY 1.002   /* apparent growth of the ratio that counts as noise */
#define MAX_RATIO 0.98 /* largest ratio of consecutive differences */
#define AT_REST 1e-16  /* largest displacement and velocity of a granule at rest */
#define FAR 1e30       /* position of the granule beyond a free end, out of reach */
#define FEW 5          /* largest number of lanes that run faster one by one */
#define FLOOR 1e-4     /* smallest peak force */
#define WEAK 0.2       /* smallest overlap of a peak behind the front */
#define REACH 8        /* number of contacts that a free end affects */
#define FORMING 6.0    /* time after the force in which a last blow forms its wave */
#define FIRST_STEP 0.05
#define LONGEST_STEP 1.0
#define SAFETY 0.9     /* safety factor of the step size */
#define SLACK 0.1      /* largest force of a contact at which the chain may be cut, over that of the front */
#define TREND 4        /* number of contacts over which the growth of a wave is measured */
#define RECENT 6.0     /* longest time in which a wave passes from one contact to the next */
/* error of a step in which a contact opens or closes, over its length and the force at the change of the overlap: the
   force has no second derivative there, which the embedded method may not detect */
#define KINK 0.03
#define TALLER 0.999   /* fraction of the peak force of the front above which a wave may be as strong */
#define RIVAL 2.0      /* error of the front, over the amount by which another wave exceeds it */
#define INTERVAL 2e6   /* number of contact forces between two calls of `expired`: tens of milliseconds */

/* kinks: whether they count when the force has ended, too; tried: contact of the front at the last attempt to cut */
typedef struct {
    long job, base, count, head, tried, granules, stop, wanted, last_wanted, steps, evaluations;
    int driven, kinks, status, kept, rejected;
    double t, h, until, impulse, free_path, duration, tolerance;
    double effort, removed_momentum, removed_energy, work;
    double peak[KEPT], time[KEPT];
    long contact[KEPT];
    Path path;
} Lane;

typedef struct {
    const double *jobs, *rows, *coefficients, *stops;
    double *wanted, *found, work;
    long count, next;
    PyObject *expired;
    PyThreadState *thread;
    int stopped;
} Batch;

/* d^(p - 1) */
static double stiffening(double exponent, double d) { return exponent == HERTZ ? sqrt(d) : pow(d, exponent - 1); }

static double overlap_force(const Window *w, double d) { return d > 0 ? d * stiffening(w->exponent, d) : 0; }

/* Enlarges the arrays to this number of rows, and keeps their contents. */
static int make_room(Window *w, long rows)
{
    Window larger;
    long i;
    const size_t size = (size_t)w->room * sizeof(double);
    if (rows <= w->room / w->lanes) return 1;
    if (!window_of(&larger, w->lanes, rows + rows / 2, w->exponent)) return 0;
    if (!w->block) { *w = larger; return 1; }
    memcpy(larger.x, w->x, size);
    memcpy(larger.v, w->v, size);
    memcpy(larger.x1, w->x1, size);
    memcpy(larger.v1, w->v1, size);
    memcpy(larger.late, w->late, size);
    memcpy(larger.since, w->since, size);
    for (i = 0; i < MAX_STAGES; i++) memcpy(larger.k[i], w->k[i], size);
    larger.used = w->used;
    free(w->block);
    *w = larger;
    return 1;
}

/* Sets lane l to zero from a row on, in the present and the new state. */
static void clear(const Method *m, Window *w, long row, int l)
{
    double *const arrays[] = {w->x, w->v, w->k[0], w->x1, w->v1, w->k[m->stages - 1], w->late, w->since};
    long e;
    int i;
    for (i = 0; i < 8; i++)
        for (e = row * w->lanes + l; e < w->used; e += w->lanes) arrays[i][e] = 0;
}

/* Moves the elements beyond a free end out of reach. */
static void set_free_end(Window *w, const Lane *lane, int l)
{
    const long row = lane->granules - lane->base;
    long e;
    if (!lane->granules || row >= w->room / w->lanes) return;
    for (e = row * w->lanes + l; e < w->room; e += w->lanes) w->x[e] = w->x1[e] = FAR;
    w->used = w->room;
}

/* Starts the next job in lane l, or leaves the lane idle. */
static void start_job(const Method *m, Batch *batch, Window *w, Lane *lane, int l)
{
    const double *job;
    clear(m, w, 0, l);
    memset(lane, 0, sizeof *lane);
    lane->job = -1;
    if (batch->next >= batch->count) return;
    lane->job = batch->next++;
    job = batch->jobs + JOB * lane->job;
    lane->granules = (long)job[GRANULES];
    lane->count = lane->granules && lane->granules < 8 ? lane->granules : 8;
    lane->head = -1;
    lane->driven = 1;
    lane->h = FIRST_STEP;
    lane->duration = job[DURATION];
    lane->tolerance = job[TOLERANCE];
    lane->path.rows = batch->rows + ROW * (long)job[FIRST_PIECE];
    lane->path.coefficients = batch->coefficients + 2 * (long)job[FIRST_COEFFICIENT];
    lane->path.pieces = (long)job[PIECES];
    lane->path.rise_time = job[RISE_TIME];
    lane->path.force = job[FORCE];
    lane->stop = (long)job[FIRST_STOP];
    lane->until = batch->stops[lane->stop];
    lane->wanted = (long)job[FIRST_WANTED];
    lane->last_wanted = lane->wanted + (long)job[WANTED];
    set_free_end(w, lane, l);
}

/* Force at contact j of lane l in state x. */
static double contact_force(const Window *w, const double *x, long j, int l)
{
    return overlap_force(w, x[j * w->lanes + l] - x[(j + 1) * w->lanes + l]);
}

/* Peak force that a wave behind the front may reach, over that of the front. */
static double strongest_behind(const double *job, const Window *w, const Lane *lane, int l)
{
    const long front = lane->head - lane->base - 2;
    double most = 0;
    long j;
    for (j = 0; j < front; j++) {
        const long e = j * w->lanes + l;
        const double force = contact_force(w, w->x, j, l);
        /* largest peak force the wave may reach, from its change over the last contacts */
        long back = 0;
        double change, grown;
        while (back < TREND && j > back && w->since[e - (back + 1) * w->lanes] < w->since[e - back * w->lanes]
               && w->late[e - (back + 1) * w->lanes] > 0) back++;
        change = back ? fabs(w->late[e] - w->late[e - back * w->lanes]) / (double)back : 0;
        grown = w->late[e] + (job[GROWING] * change < w->late[e] ? job[GROWING] * change : w->late[e]);
        if (lane->t - w->since[e] < RECENT && grown > most) most = grown;
        if (force > most) most = force;
    }
    return most / lane->peak[KEPT - 1];
}

/* Number of granules to keep behind the front. A constant force f makes a first wave of about 2.33 f and others that
   are nearly as strong, which interact for as long as the force exceeds 1/2.33 of the peak of the front. */
static long rear_of(const double *job, const Lane *lane)
{
    const double level = 0.9 * lane->peak[KEPT - 1] / (2.33 * job[FORCE]);
    const int tenth = level < 0.9 ? (int)(10 * level) : 8;
    const double share = level < 0.9 ? 10 * level - tenth : 1, *above = job + ABOVE + tenth;
    const double rear = job[REAR] + 1.25 * (above[0] + share * (above[1] - above[0]));
    return rear < MAX_COUNT ? (long)rear : (long)MAX_COUNT;
}

/* Removes granules far behind the front, and adds up their momentum and energy: at a contact with almost no force, so
   that they have no influence, and only if no wave behind the front can become stronger than it. It is attempted once
   for each contact that the front passes. */
static void cut(const Method *m, const double *job, Window *w, Lane *lane, int l)
{
    double *const state[] = {w->x, w->v, w->late, w->since, w->k[0]};
    const long lanes = w->lanes;
    double least = SLACK * lane->peak[KEPT - 1];
    long most, rows = 0, j;
    int i;
    if (lane->tried == lane->head || lane->t < job[DURATION] + FORMING) return;
    lane->tried = lane->head;
    most = lane->head - lane->base - rear_of(job, lane);
    if (most < BLOCK || strongest_behind(job, w, lane, l) > TALLER) return;
    for (j = most; j > most - BLOCK; j--) {
        const double force = contact_force(w, w->x, j - 1, l);
        if (force < least) { least = force; rows = j; }
    }
    if (!rows) return;
    for (j = 0; j < rows; j++) {
        const double v = w->v[j * lanes + l], d = w->x[j * lanes + l] - w->x[(j + 1) * lanes + l];
        lane->removed_momentum += v;
        lane->removed_energy += 0.5 * v * v + 1 / (w->exponent + 1) * overlap_force(w, d) * (d > 0 ? d : 0);
    }
    for (i = 0; i < 5; i++)
        for (j = l; j < (lane->count - rows) * lanes; j += lanes) state[i][j] = state[i][j + rows * lanes];
    clear(m, w, lane->count - rows, l);
    w->k[0][l] = -contact_force(w, w->x, 0, l); /* no neighbour behind */
    lane->base += rows;
    lane->count -= rows;
    set_free_end(w, lane, l);
}

/* ---------------------------------------------------------------- peaks */

/* Fraction of a step at which a contact stops closing, and its closure up to then, over the size of the step. The
   velocity is interpolated by the cubic through values and slopes at both ends. */
static double crossing(double v0, double v1, double slope0, double slope1, double *closed)
{
    const double c = 3 * (v1 - v0) - 2 * slope0 - slope1, d = slope0 + slope1 - 2 * (v1 - v0);
    double share = v0 / (v0 - v1), low = 0, high = 1;
    int i;
    for (i = 0; i < 2; i++) {
        const double v = v0 + share * (slope0 + share * (c + share * d));
        const double slope = slope0 + share * (2 * c + share * 3 * d);
        if (v > 0) low = share; else high = share;
        share -= v / slope;
        if (!(share > low && share < high)) share = (low + high) / 2;
    }
    *closed = share * (v0 + share * (slope0 / 2 + share * (c / 3 + share * d / 4)));
    return share;
}

/* Applied force at time t in a step of size h, from the difference of the impulse. */
static double applied(Lane *lane, double t, double h)
{
    const double about = 1e-4 * h, end = lane->t + h;
    const double from = t - about > lane->t ? t - about : lane->t, to = t + about < end ? t + about : end;
    double g, before, after;
    free_path(&lane->path, from, &g, &before);
    free_path(&lane->path, to, &g, &after);
    return to > from ? (after - before) / (to - from) : 0;
}

/* Computes the peak at local contact j of lane l by repeated steps, from the state before a step of size h to the time
   at which the contact stops closing, by Newton's method with bisections; the last shift is at most `near` and is made
   by a parabola. The domain of dependence of a step is one granule per stage, so a part of the window is sufficient; what
   its outermost granules contribute is far below rounding. */
static int read_peak(const Method *m, Window *w, Window *part, Lane *lane, int l, long j, double h, double share,
                     double near, double *time, double *force)
{
    const long n = (2 * m->stages - 2 + BLOCK - 1) / BLOCK * BLOCK, reach = n / 2 - 1;
    const long first = j > reach ? j - reach : 0, at = j - first;
    double step[BLOCK], worst[BLOCK], shift[MAX_STAGES * BLOCK] = {0}, g = 0, impulse = 0, d, v, a, left, low = 0, high = 1.5;
    long r;
    int i, turn;
    if (!make_room(part, n)) return 0;
    for (r = 0; r < part->room; r++) {
        const long e = (first + r) * w->lanes + l;
        const int inside = e < w->room;
        part->x[r] = inside ? w->x[e] : 0;
        part->v[r] = inside ? w->v[e] : 0;
        part->k[0][r] = inside ? w->k[0][e] : 0;
    }
    for (turn = 0; turn < 60; turn++) {
        for (i = 0; i < BLOCK; i++) step[i] = share * h;
        if (lane->driven && first == 0)
            for (i = 1; i < m->stages; i++) {
                free_path(&lane->path, lane->t + m->c[i] * share * h, &g, &impulse);
                shift[i * BLOCK] = g;
            }
        attempt(m, part, n, step, shift, worst);
        lane->evaluations += m->stages - m->last_is_next;
        part->x1[0] += g;
        part->v1[0] += impulse;
        d = part->x1[at] - part->x1[at + 1];
        v = part->v1[at] - part->v1[at + 1];
        a = (at > 0 ? contact_force(part, part->x1, at - 1, 0) : 0) + contact_force(part, part->x1, at + 1, 0)
            - 2 * overlap_force(w, d);
        if (lane->driven && j == 0) a += applied(lane, lane->t + share * h, h);
        left = a < 0 ? -v / a : h;
        *time = lane->t + share * h + left;
        *force = overlap_force(w, d + 0.5 * v * left);
        if (fabs(left) < near) return 1;
        *time = lane->t + share * h;
        *force = overlap_force(w, d);
        if (v > 0) low = share;
        else high = share;
        share += left / h;
        if (!(share > low && share < high)) share = (low + (low < 1 && high > 1 ? 1 : high)) / 2;
    }
    return 1;
}

/* Distance to the limit of four peaks with geometric differences, whose ratio decreases if it `bends`. */
static double rest(const double *p, int bends)
{
    const double second = p[2] - p[1], last = p[3] - p[2], older = second / (p[1] - p[0]), newer = last / second;
    const double fall = bends && newer < older ? newer / older : 1;
    double sum = 0, term = last, ratio = newer;
    int i;
    if (!(older > 0 && newer > 0 && newer < MAX_RATIO)) return INFINITY;
    for (i = 0; i < 100 && fabs(term) > 1e-17; i++) {
        ratio *= fall;
        term *= ratio;
        sum += term;
    }
    return sum;
}

/* Uncertainty of the limit of the last peaks p, and the distance `left` to it; see peak_limit.py. */
static double doubt_of(const double *p, double *left, int *steady)
{
    const double first = p[2] - p[1], second = p[3] - p[2], last = p[4] - p[3];
    double doubt = fabs(last) + fabs(second);
    *left = 0;
    *steady = first * second > 0 && second * last > 0;
    if (!*steady) return doubt;
    if (!(last / second < MAX_RATIO)) return SLOW * fabs(last);
    *left = rest(p + 1, 1);
    doubt = 0.5 * fabs(last + *left - rest(p, 1)) + 0.5 * fabs(*left - rest(p + 1, 0)) + 0.01 * fabs(*left);
    /* the ratio has not yet settled */
    return last * first > STEADY * second * second ? doubt + fabs(*left) : doubt;
}

/* Checks whether the peaks of the front have reached their limit; at the `end` states how near they are. */
static void judge(const double *job, const Window *w, Lane *lane, int l, double *found, int end)
{
    const double *p = lane->peak, allowed = job[DOUBT] * p[KEPT - 1];
    double left, doubt, other;
    int steady;
    if (lane->kept < KEPT || lane->driven || lane->t < job[EARLIEST_TIME]) return;
    doubt = doubt_of(p, &left, &steady);
    if (!end && !(doubt <= (steady ? allowed : NOISE * allowed))) return;
    other = strongest_behind(job, w, lane, l) - TALLER;
    if (end) doubt = doubt / NOISE + (other > 0 ? RIVAL * other * p[KEPT - 1] : 0);
    if (end ? !(doubt < p[KEPT - 1]) : other > 0) return;
    found[PEAK] = p[KEPT - 1] + left;
    found[LAST] = p[KEPT - 1];
    found[DOUBT_LEFT] = doubt / p[KEPT - 1];
    found[CONTACT] = (double)lane->contact[KEPT - 1];
    found[TIME] = lane->time[KEPT - 1];
    found[SPEED] = STRIDE / (lane->time[KEPT - 1] - lane->time[KEPT - 2]);
    if (!end) lane->status = KNOWN;
}

/* Checks whether the force at local contact j has a maximum within a step of size h, and processes it. `before` and
   `after` are displacement and impulse of the free granule at the ends of the step. Returns 0 without memory. */
static int observe(const Method *m, const Batch *batch, Window *w, Window *part, Lane *lane, int l, long j, double h,
                   const double *before, const double *after)
{
    const double *job = batch->jobs + JOB * lane->job;
    const long e = j * w->lanes + l, next = e + w->lanes, contact = lane->base + j;
    const double v0 = w->v[e] - w->v[next] + (j ? 0 : before[1]), v1 = w->v1[e] - w->v1[next] + (j ? 0 : after[1]);
    const double *first = w->k[0], *last = w->k[m->stages - 1];
    double overlap, share, closed, force, time;
    long next_wanted = lane->wanted;
    int i, wanted;
    if (!(v0 > 0 && v1 <= 0)) return 1;
    overlap = w->x1[e] - w->x1[next] + (j ? 0 : after[0]);
    if (contact <= lane->head && overlap < WEAK) return 1;
    while (next_wanted < lane->last_wanted && batch->wanted[PASSAGE * next_wanted] < contact) next_wanted++;
    wanted = next_wanted < lane->last_wanted && batch->wanted[PASSAGE * next_wanted] == contact;
    /* the limit does not use the peak of this contact: the front moves on without it */
    if (contact > lane->head && (contact + 1) % STRIDE && !wanted && overlap_force(w, overlap) > FLOOR) {
        lane->head = contact;
        lane->wanted = next_wanted;
        return 1;
    }
    share = crossing(v0, v1, h * (first[e] - first[next]), h * (last[e] - last[next]), &closed);
    force = overlap_force(w, w->x[e] - w->x[next] + (j ? 0 : before[0]) + h * closed);
    if (force < FLOOR) return 1;
    time = lane->t + share * h;
    if (contact <= lane->head) {
        w->late[e] = force;
        w->since[e] = time;
        return 1;
    }
    lane->head = contact;
    lane->wanted = next_wanted;
    if ((contact + 1) % STRIDE && !wanted) return 1;
    if (!read_peak(m, w, part, lane, l, j, h, share, wanted ? 1e-6 : 1e-4, &time, &force)) return 0;
    if (wanted) {
        batch->wanted[PASSAGE * lane->wanted + WANTED_TIME] = time;
        batch->wanted[PASSAGE * lane->wanted + WANTED_FORCE] = force;
    }
    if ((contact + 1) % STRIDE) return 1;
    for (i = 0; i + 1 < KEPT; i++) {
        lane->peak[i] = lane->peak[i + 1];
        lane->time[i] = lane->time[i + 1];
        lane->contact[i] = lane->contact[i + 1];
    }
    lane->peak[i] = force;
    lane->time[i] = time;
    lane->contact[i] = contact;
    if (lane->kept < KEPT) lane->kept++;
    judge(job, w, lane, l, batch->found + FOUND * lane->job, 0);
    return 1;
}

/* Sets `mark` to 1 for contacts, except in the first row, that stop closing within a step with at least this overlap. */
WIDE static void passed(long n, long lanes, const double *v, const double *v1, const double *x1, double least,
                        double *mark)
{
    long e;
    for (e = 0; e < n; e++)
        mark[e] = ((v[e] > v[e + lanes]) & (v1[e] <= v1[e + lanes]) & (x1[e] - x1[e + lanes] > least)) ? 1 : 0;
}

/* ---------------------------------------------------------------- integration */

/* Writes the result of a lane. */
static void finish(const Batch *batch, const Window *w, Lane *lane, int l)
{
    double *found = batch->found + FOUND * lane->job, momentum = lane->removed_momentum, energy = lane->removed_energy;
    double wave_momentum = 0, wave_energy = 0;
    long j, from = lane->head - lane->base;
    while (from > 0 && contact_force(w, w->x, from - 1, l) < contact_force(w, w->x, from, l)) from--;
    for (j = 0; j < lane->count; j++) {
        const double v = w->v[j * w->lanes + l], d = w->x[j * w->lanes + l] - w->x[(j + 1) * w->lanes + l];
        const double held = 0.5 * v * v + 1 / (w->exponent + 1) * overlap_force(w, d) * (d > 0 ? d : 0);
        momentum += v;
        energy += held;
        if (j > from) { wave_momentum += v; wave_energy += held; }
    }
    found[STATUS] = lane->status;
    if (lane->status != KNOWN) {
        found[PEAK] = found[LAST] = lane->peak[KEPT - 1];
        found[CONTACT] = (double)lane->contact[KEPT - 1];
        found[TIME] = lane->time[KEPT - 1];
        found[SPEED] = lane->kept < 2 ? 0 : STRIDE / (lane->time[KEPT - 1] - lane->time[KEPT - 2]);
        found[DOUBT_LEFT] = 1;
        judge(batch->jobs + JOB * lane->job, w, lane, l, found, 1);
    }
    found[MOMENTUM] = wave_momentum;
    found[ENERGY] = wave_energy;
    found[FOOT] = from >= 0 ? contact_force(w, w->x, from, l) : 0;
    found[CHAIN_MOMENTUM] = momentum;
    found[CHAIN_ENERGY] = energy;
    found[WORK] = lane->work;
    found[IMPULSE] = lane->impulse;
    found[FREE_PATH] = lane->free_path;
    found[STEPS] = (double)lane->steps;
    found[EVALUATIONS] = (double)lane->evaluations;
}

/* Size of the next step, which avoids a very short step before the next stop. */
static double next_size(const Lane *lane)
{
    const double left = lane->until - lane->t;
    if (lane->h >= left) return left;
    return lane->h > left / 2 ? left / 2 : lane->h;
}

/* Accepts the step of size h in lane l; `after` are displacement and impulse of the free granule at its end. */
static void accept(const Method *m, const Batch *batch, Window *w, Lane *lane, int l, double h, int at_stop,
                   const double *after)
{
    const double *job = batch->jobs + JOB * lane->job;
    long e;
    lane->t = at_stop ? lane->until : lane->t + h;
    lane->steps++;
    if (at_stop && lane->t >= lane->duration) {
        lane->driven = 0;
        lane->until = INFINITY;
        lane->free_path = after[0];
        lane->impulse = after[1];
        lane->work += after[1] * w->v[l] + 0.5 * after[1] * after[1];
        w->x[l] += after[0];
        w->v[l] += after[1];
    } else if (at_stop) lane->until = batch->stops[++lane->stop];
    e = (lane->count - 2) * w->lanes + l;
    if ((fabs(w->x[e]) > AT_REST || fabs(w->v[e]) > AT_REST)
        && (!lane->granules || lane->base + lane->count < lane->granules)) {
        lane->count += w->lanes == 1 ? BLOCK : 2;
        if (lane->granules && lane->base + lane->count > lane->granules) lane->count = lane->granules - lane->base;
    }
    if (!lane->driven) cut(m, job, w, lane, l);
    if (lane->status != RUNNING) return;
    if (lane->granules && lane->head >= lane->granules - 1 - REACH) lane->status = AT_END;
    if ((double)lane->head > job[MAX_CONTACTS] || lane->effort > job[MAX_WORK]) lane->status = TOO_LONG;
}

/* Chooses the next step size in a lane from the errors of the last; returns whether the last step is accepted. */
static int control(const Method *m, const double *job, Lane *lane, double h, double worst, double kink, int at_stop)
{
    const double error = worst / lane->tolerance, jolt = kink / lane->tolerance;
    double factor = SAFETY * pow(error > 1e-12 ? error : 1e-12, -1.0 / (m->error_order + 1));
    lane->effort += (double)lane->count * m->stages;
    lane->evaluations += m->stages - m->last_is_next;
    if (error <= 1 && jolt > 1) {
        lane->h = h * (jolt < 300 ? pow(jolt, -1 / (m->exponent + 1)) : 0.1); /* both velocity and length of the step make the change */
        lane->rejected = 1;
        return 0;
    }
    if (!(error <= 1)) {
        lane->h = h * (factor > 0.2 && factor < 1 ? factor : 0.2);
        lane->rejected = 1;
        if (lane->effort > job[MAX_WORK]) lane->status = TOO_LONG;
        if (lane->h < 1e-14 * (1 + lane->t)) lane->status = FAILED;
        return 0;
    }
    if (factor > 3) factor = 3;
    if (factor > 1 && lane->rejected) factor = 1;
    lane->rejected = 0;
    if (!(at_stop && h * factor < lane->h)) lane->h = h * factor;
    if (lane->h > LONGEST_STEP) lane->h = LONGEST_STEP;
    return 1;
}

static void swap(double **one, double **other)
{
    double *kept = *one;
    *one = *other;
    *other = kept;
}

/* A trial step of all lanes: sizes, whether it ends at a stop, whether it is accepted, and the free granules. */
typedef struct {
    double h[BLOCK], worst[BLOCK], kink[BLOCK], paths[MAX_STAGES * BLOCK], impulses[MAX_STAGES * BLOCK];
    const double *shift; /* `paths`, or zeros if no force acts */
    int stop[BLOCK], accepted[BLOCK];
    long n;
} Trial;

/* Displacements and impulses of the free granules at the stages, and in `path` at beginning and end of the step. */
static void drive(const Method *m, const Window *w, Lane *lanes, double (*path)[4], Trial *trial)
{
    static const double zeros[MAX_STAGES * BLOCK];
    int i, l;
    trial->shift = zeros;
    for (l = 0; l < w->lanes; l++) {
        Lane *lane = lanes + l;
        path[l][2] = path[l][3] = 0;
        if (lane->job < 0 || !lane->driven) continue;
        if (trial->shift == zeros) memset(trial->paths, 0, (size_t)(m->stages * BLOCK) * sizeof(double));
        trial->shift = trial->paths;
        trial->paths[l] = path[l][0];
        trial->impulses[l] = path[l][1];
        for (i = 1; i < m->stages; i++) {
            const double t = trial->stop[l] && m->c[i] == 1 ? lane->until : lane->t + m->c[i] * trial->h[l];
            double *const g = trial->paths + i * BLOCK + l, *const impulse = trial->impulses + i * BLOCK + l;
            if (m->c[i] != m->c[i - 1]) free_path(&lane->path, t, g, impulse);
            else { *g = g[-BLOCK]; *impulse = impulse[-BLOCK]; }
        }
        path[l][2] = trial->paths[(m->stages - 1) * BLOCK + l];
        path[l][3] = trial->impulses[(m->stages - 1) * BLOCK + l];
    }
}

/* Sets `most` to the largest change of the overlap of contacts that open or close between x and x1, for each element of
   a block; `path` are the displacements of the first granules at both times. */
WIDE static void find_changes(long n, long lanes, const double *x, const double *x1, double (*path)[4], double *most)
{
    Vector greatest = {0}, greatest2 = {0};
    long e;
    for (e = lanes; e < n; e += BLOCK) {
        const Vector before = VECTOR(x + e) - VECTOR(x + e + lanes), after = VECTOR(x1 + e) - VECTOR(x1 + e + lanes);
        const Vector before2 = VECTOR(x + e + HALF) - VECTOR(x + e + HALF + lanes);
        const Vector after2 = VECTOR(x1 + e + HALF) - VECTOR(x1 + e + HALF + lanes);
        const Vector change = (Vector)((Choice)ABSOLUTE(after - before) & (before * after < 0));
        const Vector change2 = (Vector)((Choice)ABSOLUTE(after2 - before2) & (before2 * after2 < 0));
        greatest = GREATER(greatest, change);
        greatest2 = GREATER(greatest2, change2);
    }
    VECTOR(most) = greatest;
    VECTOR(most + HALF) = greatest2;
    for (e = 0; e < lanes; e++) {
        const double before = x[e] - x[e + lanes] + path[e][0], after = x1[e] - x1[e + lanes] + path[e][2];
        if (before * after < 0 && fabs(after - before) > most[e]) most[e] = fabs(after - before);
    }
}

/* Errors due to contacts that open or close within the step, by lanes. They are needed only while the force acts: nothing
   catches up with a wave from the contacts that open behind it. */
static void find_kinks(const Window *w, const Lane *lanes, double (*path)[4], Trial *trial)
{
    int l, any = 0;
    memset(trial->kink, 0, sizeof trial->kink);
    for (l = 0; l < w->lanes; l++) any |= lanes[l].job >= 0 && (lanes[l].driven || lanes[l].kinks);
    if (!any) return;
    find_changes(trial->n, w->lanes, w->x, w->x1, path, trial->kink);
    for (l = (int)w->lanes; l < BLOCK; l++) if (trial->kink[l] > trial->kink[0]) trial->kink[0] = trial->kink[l];
    for (l = 0; l < w->lanes; l++) {
        const int counts = lanes[l].job >= 0 && (lanes[l].driven || lanes[l].kinks);
        trial->kink[l] = counts ? KINK * trial->kink[l] * stiffening(w->exponent, trial->kink[l]) * trial->h[l] : 0;
    }
}

/* Chooses the step sizes and attempts the steps. Returns 0 without memory. */
static int try_steps(const Method *m, Window *w, Lane *lanes, double (*path)[4], Trial *trial)
{
    const int width = (int)w->lanes;
    long rows = 0;
    int l;
    memset(trial->h, 0, sizeof trial->h);
    for (l = 0; l < width; l++) {
        if (lanes[l].job < 0) continue;
        if (lanes[l].count > rows) rows = lanes[l].count;
        trial->h[l] = next_size(lanes + l);
        trial->stop[l] = trial->h[l] >= lanes[l].until - lanes[l].t;
    }
    for (l = width; l < BLOCK; l++) trial->h[l] = trial->h[0];
    if ((rows + 24) * width > w->room) {
        if (!make_room(w, rows + 24)) return 0;
        for (l = 0; l < width; l++) if (lanes[l].job >= 0) set_free_end(w, lanes + l, l);
    }
    trial->n = ((rows + 1) * width + BLOCK - 1) / BLOCK * BLOCK;
    if (trial->n > w->used) w->used = trial->n;
    drive(m, w, lanes, path, trial);
    if (!m->last_is_next) stage(trial->n, 0, 0, m->a, trial->h, trial->shift, w);
    attempt(m, w, trial->n, trial->h, trial->shift, trial->worst);
    for (l = width; l < BLOCK; l++) if (!(trial->worst[l] <= trial->worst[0])) trial->worst[0] = trial->worst[l];
    find_kinks(w, lanes, path, trial);
    return 1;
}

/* Finds peaks in the lanes whose step is accepted. Returns 0 without memory. */
static int find_peaks(const Method *m, const Batch *batch, Window *w, Window *part, Lane *lanes, double (*path)[4],
                 const Trial *trial)
{
    const int width = (int)w->lanes;
    long e, j;
    int l, b;
    for (l = 0; l < width; l++)
        if (trial->accepted[l]
            && !observe(m, batch, w, part, lanes + l, l, 0, trial->h[l], path[l], path[l] + 2)) return 0;
    passed(trial->n, width, w->v, w->v1, w->x1, 1e-3, w->f);
    for (e = 0; e < trial->n; e += BLOCK) {
        const Vector marks = VECTOR(w->f + e) + VECTOR(w->f + e + HALF);
        const double any = marks[0] + marks[1] + marks[2] + marks[3];
        for (b = 0; any > 0 && b < BLOCK; b++) {
            if (w->f[e + b] == 0) continue;
            j = (e + b) / width;
            l = (int)((e + b) % width);
            if (j == 0 || j + 1 >= lanes[l].count || !trial->accepted[l]) continue;
            if (!observe(m, batch, w, part, lanes + l, l, j, trial->h[l], path[l], path[l])) return 0;
        }
    }
    return 1;
}

/* Replaces the state by the new state, except in lanes whose step is rejected. */
static void replace_state(const Method *m, Window *w, const Trial *trial)
{
    long e;
    int l;
    for (l = 0; l < w->lanes; l++)
        for (e = l; !trial->accepted[l] && e < trial->n; e += w->lanes) {
            w->x1[e] = w->x[e];
            w->v1[e] = w->v[e];
            w->k[m->stages - 1][e] = w->k[0][e];
        }
    swap(&w->x, &w->x1);
    swap(&w->v, &w->v1);
    swap(&w->k[0], &w->k[m->stages - 1]);
}

/* Adds the work of the force, integrated by parts: I u1 + I^2/2 minus the integral of I a1. With the mean acceleration,
   the quadrature of I over the stages is replaced by its exact integral. */
static void add_work(const Method *m, const Window *w, Lane *lane, int l, const Trial *trial, const double *path)
{
    double mean = 0, summed = 0;
    int i;
    for (i = 0; i < m->stages; i++) {
        const double impulse = trial->impulses[i * BLOCK + l], a = w->k[i][l];
        lane->work -= trial->h[l] * m->bp[i] * impulse * a;
        mean += m->bp[i] * a;
        summed += m->bp[i] * impulse;
    }
    lane->work -= mean * ((path[2] - path[0]) - trial->h[l] * summed);
}

/* Asks Python at intervals of work whether to stop: at the time limit, or after Ctrl-C. Returns 0 if so. */
static int go_on(Batch *batch, double work)
{
    PyObject *answer;
    if ((batch->work += work) < INTERVAL) return 1;
    batch->work = 0;
    PyEval_RestoreThread(batch->thread);
    answer = PyErr_CheckSignals() < 0 ? NULL : PyObject_CallFunctionObjArgs(batch->expired, NULL);
    batch->stopped = !answer || PyObject_IsTrue(answer);
    Py_XDECREF(answer);
    batch->thread = PyEval_SaveThread();
    return !batch->stopped;
}

/* Attempts a step in all lanes and processes it. Returns 0 without memory, or if the computation is to stop. */
static int step_lanes(const Method *m, Batch *batch, Window *w, Window *part, Lane *lanes, double (*path)[4])
{
    Trial trial;
    int l;
    if (!try_steps(m, w, lanes, path, &trial)) return 0;
    for (l = 0; l < w->lanes; l++) {
        Lane *lane = lanes + l;
        trial.accepted[l] = lane->job >= 0
            && control(m, batch->jobs + JOB * lane->job, lane, trial.h[l], trial.worst[l], trial.kink[l], trial.stop[l]);
        if (trial.accepted[l] && lane->driven) add_work(m, w, lane, l, &trial, path[l]);
    }
    if (!find_peaks(m, batch, w, part, lanes, path, &trial)) return 0;
    replace_state(m, w, &trial);
    for (l = 0; l < w->lanes; l++) {
        Lane *lane = lanes + l;
        if (lane->job < 0) continue;
        if (trial.accepted[l]) {
            accept(m, batch, w, lane, l, trial.h[l], trial.stop[l], path[l] + 2);
            path[l][0] = lane->driven ? path[l][2] : 0;
            path[l][1] = lane->driven ? path[l][3] : 0;
        }
        if (lane->status == RUNNING) continue;
        finish(batch, w, lane, l);
        lane->job = -1;
    }
    return go_on(batch, (double)(trial.n * m->stages));
}

/* Copies lane l of a wide window to a window of its own. */
static int copy_lane(const Window *wide, int l, Window *w)
{
    const long rows = wide->room / wide->lanes;
    long j;
    memset(w, 0, sizeof *w);
    if (!window_of(w, 1, rows, wide->exponent)) return 0;
    for (j = 0; j < rows; j++) {
        const long e = j * wide->lanes + l;
        w->x[j] = wide->x[e];
        w->v[j] = wide->v[e];
        w->k[0][j] = wide->k[0][e];
        w->late[j] = wide->late[e];
        w->since[j] = wide->since[e];
    }
    w->used = w->room;
    return 1;
}

/* Runs all jobs. Returns 0 without memory, or if the computation is to stop. */
static int run(const Method *m, Batch *batch, long width)
{
    Window w, part, single;
    Lane lanes[BLOCK];
    double path[BLOCK][4] = {{0}};
    int l, busy, ok;
    memset(&part, 0, sizeof part);
    part.lanes = 1;
    part.exponent = m->exponent;
    ok = window_of(&w, width, 64, m->exponent);
    while (ok && batch->next < batch->count) {
        for (l = busy = 0; l < width; l++) {
            start_job(m, batch, &w, lanes + l, l);
            busy += lanes[l].job >= 0;
        }
        memset(path, 0, sizeof path);
        /* the last few shocks run faster one by one */
        while (ok && (width == 1 ? busy : busy > FEW)) {
            ok = step_lanes(m, batch, &w, &part, lanes, path);
            for (l = busy = 0; l < width; l++) busy += lanes[l].job >= 0;
        }
        for (l = 0; ok && l < width; l++) {
            if (lanes[l].job < 0) continue;
            ok = copy_lane(&w, l, &single);
            if (ok) set_free_end(&single, lanes + l, 0);
            while (ok && lanes[l].job >= 0) ok = step_lanes(m, batch, &single, &part, lanes + l, path + l);
            free(single.block);
        }
    }
    free(w.block);
    free(part.block);
    return ok;
}

/* ---------------------------------------------------------------- the whole chain */

/* The state of an integration of the whole chain, which `march` continues; see simulation/integration_stretches.py. FLYING is the
   number of granules in free flight at the loaded end, whose positions are those at the time FLOWN. */
enum { NOW, STEP_SIZE, UNTIL, STOP, GRANULE_COUNT, FLYING, FLOWN, AGE, TAKEN, KEPT_STEPS, EVALUATED, PEAKS, STRONGEST, ENDED,
       TARGET, RISE, PEAK_FORCE, LENGTH, CHAIN_GRANULES, ALLOWED, KEPT_SINCE, STATE };

#define INTERVAL_FREE 50.0    /* interval between the ends of integrations after the force has ended */
#define GROWTH 16             /* number of granules by which the window grows */
#define MARGIN 4              /* number of granules at its end that must be at rest */
#define PARTING 16            /* number of steps between the checks for granules in free flight */
/* see peak_log.py */
#define LEAST_PEAK 1e-4
#define LOSS 6e-5
#define NEGLIGIBLE 0.1
#define SAME_WAVE 0.5
#define CORRECTIONS 4
#define NEAR 1e-5

typedef struct {
    long long contact, behind, previous;
    double time, force;
} Peak;

typedef struct {
    const Method *method;
    const double *stops;
    double *state, *x, *v, *a;        /* all granules, those in the window included after `store` */
    double *times, *xs, *vs;          /* the ends of the steps: `kept` rows of `capacity` granules */
    Peak *peaks;
    long long *last;                  /* the last peak of each contact, or -1 */
    long capacity, rows, most_peaks;
    Batch batch;
    Lane lane;
    Window w, part;
    double path[1][4];
} March;

/* Copies the window to the arrays of all granules, and moves those in free flight. */
static void store(March *r)
{
    const Lane *lane = &r->lane;
    long j;
    for (j = 0; j < lane->base; j++) r->x[j] += (lane->t - r->state[FLOWN]) * r->v[j];
    r->state[FLOWN] = lane->t;
    memcpy(r->x + lane->base, r->w.x, (size_t)lane->count * sizeof(double));
    memcpy(r->v + lane->base, r->w.v, (size_t)lane->count * sizeof(double));
    memcpy(r->a + lane->base, r->w.k[0], (size_t)lane->count * sizeof(double));
}

/* Begins an integration with new accelerations of the granules in the window. */
static void restart(March *r)
{
    const double zero[BLOCK] = {0};
    double shift[BLOCK] = {0};
    shift[0] = r->path[0][0];
    r->state[AGE] = 0;
    stage((r->lane.count + BLOCK) / BLOCK * BLOCK, 0, 0, r->method->a, zero, shift, &r->w);
}

/* Fills the window with the granules from `base` on. Returns 0 without memory. */
static int load(March *r, long base, long all)
{
    Lane *lane = &r->lane;
    lane->base = base;
    lane->count = all - base;
    if (!make_room(&r->w, lane->count + 24)) return 0;
    clear(r->method, &r->w, 0, 0);
    if (lane->count + BLOCK > r->w.used) r->w.used = lane->count + BLOCK; /* as far as `restart` */
    memcpy(r->w.x, r->x + base, (size_t)lane->count * sizeof(double));
    memcpy(r->w.v, r->v + base, (size_t)lane->count * sizeof(double));
    memcpy(r->w.k[0], r->a + base, (size_t)lane->count * sizeof(double));
    set_free_end(&r->w, lane, 0);
    return 1;
}

/* Keeps the true positions and velocities at the present time, if they are wanted. */
static void keep(March *r)
{
    const Lane *lane = &r->lane;
    const long row = (long)r->state[KEPT_STEPS];
    double *x = r->xs + row * r->capacity, *v = r->vs + row * r->capacity;
    long j;
    if (!r->rows || lane->t < r->state[KEPT_SINCE]) return;
    r->times[row] = lane->t;
    for (j = 0; j < lane->base; j++) x[j] = r->x[j] + (lane->t - r->state[FLOWN]) * r->v[j];
    memcpy(v, r->v, (size_t)lane->base * sizeof(double));
    memcpy(x + lane->base, r->w.x, (size_t)lane->count * sizeof(double));
    memcpy(v + lane->base, r->w.v, (size_t)lane->count * sizeof(double));
    x[0] += r->path[0][0];
    v[0] += r->path[0][1];
    r->state[KEPT_STEPS]++;
}

/* Whether no two granules of local contact j can meet in free flight. */
static int apart(const Window *w, long j)
{
    return w->x[j] - w->x[j + 1] <= 0 && w->v[j] <= w->v[j + 1];
}

/* Removes granules in free flight from the window, in which at least two remain. Returns 0 without memory. */
static int part_granules(March *r)
{
    Lane *lane = &r->lane;
    const long before = lane->base, all = before + lane->count;
    long free = 0;
    while (free < lane->count - 2 && apart(&r->w, free)) free++;
    if (!free) return 1;
    if (before) {
        const double x = r->x[before - 1] + (lane->t - r->state[FLOWN]) * r->v[before - 1];
        if (x > r->w.x[0] || r->v[before - 1] > r->w.v[0]) return 1;
    }
    store(r);
    return load(r, before + free, all);
}

/* Moves all granules of a finite chain to their next contact, if no contact is closed. Returns 0 without memory. */
static int coast(March *r)
{
    Lane *lane = &r->lane;
    const long all = lane->base + lane->count;
    double least = INFINITY;
    long j;
    if (all != lane->granules) return 1;
    store(r);
    for (j = 0; j + 1 < all; j++) {
        const double gap = r->x[j + 1] - r->x[j], closing = r->v[j] - r->v[j + 1];
        if (gap < 0) return 1;
        if (closing > 0 && gap / closing < least) least = gap / closing;
    }
    if (!(least > LONGEST_STEP && least < INFINITY)) return 1; /* as for a gap due to rounding */
    for (j = 0; j < all; j++) r->x[j] += least * r->v[j];
    lane->t += least;
    r->state[FLOWN] = lane->t;
    r->state[TAKEN]++;
    if (!load(r, 0, all)) return 0;
    restart(r);
    keep(r);
    return 1;
}

/* Whether the last granule in free flight may be hit within the step by the next. */
static int meets(const March *r, double h)
{
    const long last = r->lane.base - 1;
    double gap, slower;
    if (last < 0) return 0;
    gap = r->w.x1[0] - r->x[last] - (r->lane.t + h - r->state[FLOWN]) * r->v[last];
    slower = r->w.v[0] < r->w.v1[0] ? r->w.v[0] : r->w.v1[0];
    return r->v[last] > slower && gap < h * (r->v[last] - slower);
}

/* Overlap at local contact j and its first three derivatives, from positions and velocities whose first granule is
   displaced by `shift`. */
static void jet(const double *x, const double *v, const double *shift, long j, double exponent, double *derivatives)
{
    double force[3], rate[3];
    long i;
    for (i = 0; i < 3; i++) {
        const long k = j + i - 1;
        const double d = k < 0 ? 0 : x[k] + (k ? 0 : shift[0]) - x[k + 1], u = k < 0 ? 0 : v[k] + (k ? 0 : shift[1]) - v[k + 1];
        const double root = d > 0 ? stiffening(exponent, d) : 0;
        force[i] = exponent == HERTZ ? root * root * root : root * d;
        rate[i] = exponent * root * u;
        if (i == 1) { derivatives[0] = d; derivatives[1] = u; }
    }
    derivatives[2] = force[0] - 2 * force[1] + force[2];
    derivatives[3] = rate[0] - 2 * rate[1] + rate[2];
}

/* Polynomial of degree 7 in the fraction of a step of size h, lowest power first, through value and three derivatives at
   both ends. */
static void powers_between(const double *begin, const double *end, double h, double *p)
{
    static const double powers[4][8] = {{-35, -20, -10, -4, 35, -15, 5, -1}, {84, 45, 20, 6, -84, 39, -14, 3},
                                        {-70, -36, -15, -4, 70, -34, 13, -3}, {20, 10, 4, 1, -20, 10, -4, 1}};
    const double *ends[] = {begin, end};
    double known[8];
    int i, j;
    for (i = 0; i < 2; i++)
        for (j = 0; j < 4; j++) known[4 * i + j] = ends[i][j] * (j == 0 ? 1 : j == 1 ? h : j == 2 ? h * h / 2 : h * h * h / 6);
    for (j = 0; j < 4; j++) p[j] = known[j];
    for (j = 4; j < 8; j++)
        for (p[j] = 0, i = 0; i < 8; i++) p[j] += powers[j - 4][i] * known[i];
}

/* Fraction of a step of size h at which the overlap is largest, and that overlap, from the polynomial. */
static double summit(const double *begin, const double *end, double h, double *overlap)
{
    double p[8], share = begin[1] / (begin[1] - end[1]), value, slope, bend;
    int i, j;
    powers_between(begin, end, h, p);
    for (i = 0; i <= CORRECTIONS; i++) {
        for (value = slope = bend = 0, j = 7; j >= 0; j--) {
            bend = bend * share + 2 * slope;
            slope = slope * share + value;
            value = value * share + p[j];
        }
        if (i == CORRECTIONS) break;
        share -= slope / (bend < -1e-300 ? bend : -1e-300);
        share = share > 0 ? share < 1 ? share : 1 : 0;
    }
    *overlap = value;
    return share;
}

/* Logs a maximum, with the last peak of the same wave at the preceding contact. */
static void log_peak(March *r, long contact, double time, double force)
{
    Peak *peak = r->peaks + (long)r->state[PEAKS];
    long long behind = contact ? r->last[contact - 1] : -1;
    while (behind >= 0 && !(r->peaks[behind].force > SAME_WAVE * force && r->peaks[behind].time < time))
        behind = r->peaks[behind].previous;
    peak->contact = contact;
    peak->behind = behind;
    peak->previous = r->last[contact];
    peak->time = time;
    peak->force = force;
    r->last[contact] = (long long)r->state[PEAKS]++;
}

/* Logs the maximum of the force at local contact j within a step of size h, if there is one. Returns 0 without memory. */
static int log_maximum(March *r, long j, double h)
{
    Window *w = &r->w;
    Lane *lane = &r->lane;
    const double none[2] = {0};
    const double *before = j < 2 ? r->path[0] : none, *after = j < 2 ? r->path[0] + 2 : none;
    const double slowing = -(w->exponent - 1) / (2 * w->exponent);
    double begin[4], end[4], share, overlap, time, force;
    jet(w->x, w->v, before, j, w->exponent, begin);
    jet(w->x1, w->v1, after, j, w->exponent, end);
    if (!(begin[1] > 0 && end[1] <= 0)) return 1;
    force = overlap_force(w, begin[0] > end[0] ? begin[0] : end[0]);
    if (force > r->state[STRONGEST]) r->state[STRONGEST] = force;
    if (!(force > LEAST_PEAK * r->state[STRONGEST])) return 1;
    share = summit(begin, end, h, &overlap);
    force = overlap_force(w, overlap);
    time = lane->t + share * h;
    /* the shock acts on one of the granules of the first contact, which the polynomial does not include */
    if ((lane->base + j == 0 || LOSS * force * pow(h / pow(force > 1e-30 ? force : 1e-30, slowing), 8)
                                    > NEGLIGIBLE * lane->tolerance)
        && !read_peak(r->method, w, &r->part, lane, 0, j, h, share, NEAR, &time, &force)) return 0;
    log_peak(r, lane->base + j, time, force);
    return 1;
}

/* Logs the maxima of an attempted step. Returns 0 without memory. */
static int log_maxima(March *r, const Trial *trial)
{
    Window *w = &r->w;
    const long contacts = r->lane.count - 1;
    long j;
    passed(trial->n, 1, w->v, w->v1, w->x1, -INFINITY, w->f);
    for (j = 0; j < contacts; j++)
        if ((w->f[j] != 0 || (j == 0 && r->lane.driven)) && !log_maximum(r, j, trial->h[0])) return 0;
    return 1;
}

/* Processes an accepted step. Returns 0 without memory. */
static int advance(March *r, Trial *trial)
{
    const double drive[2] = {r->path[0][2], r->path[0][3]};
    Lane *lane = &r->lane;
    Window *w = &r->w;
    int begins = trial->stop[0];
    long last, j, room = GROWTH;
    trial->accepted[0] = 1;
    if (!log_maxima(r, trial)) return 0;
    replace_state(r->method, w, trial);
    lane->t = trial->stop[0] ? lane->until : lane->t + trial->h[0];
    r->state[TAKEN]++;
    r->path[0][0] = r->path[0][1] = 0;
    if (trial->stop[0] && lane->driven && lane->t >= lane->duration) {
        lane->driven = 0;
        w->x[0] += drive[0];
        w->v[0] += drive[1];
    } else if (lane->driven) {
        if (trial->stop[0]) lane->until = r->stops[++lane->stop];
        r->path[0][0] = drive[0];
        r->path[0][1] = drive[1];
    }
    keep(r);
    if (!lane->driven && ++r->state[AGE] >= PARTING) {
        begins = 1;
        if (!part_granules(r)) return 0;
    }
    last = lane->count > MARGIN ? lane->count - MARGIN : 0;
    if (lane->granules && room > lane->granules - lane->base - lane->count) room = lane->granules - lane->base - lane->count;
    if (room > 0 && (fabs(w->x[last]) > AT_REST || fabs(w->v[last]) > AT_REST)) {
        begins = 1;
        for (j = 0; j < r->state[KEPT_STEPS]; j++) {
            memset(r->xs + j * r->capacity + lane->base + lane->count, 0, (size_t)room * sizeof(double));
            memset(r->vs + j * r->capacity + lane->base + lane->count, 0, (size_t)room * sizeof(double));
        }
        lane->count += room;
        if (!make_room(w, lane->count + 24)) return 0;
        set_free_end(w, lane, 0);
    }
    if (begins) restart(r);
    return 1;
}

/* Steps until the target or the end of the buffers. Returns 0 without memory, or if the computation is to stop. */
static int march_on(March *r)
{
    const double job[JOB] = {[MAX_WORK] = INFINITY};
    Lane *lane = &r->lane;
    Trial trial;
    keep(r);
    while (lane->t < r->state[TARGET] && (!r->rows || r->state[KEPT_STEPS] + 2 <= (double)r->rows)
           && r->state[PEAKS] + (double)lane->count <= (double)r->most_peaks
           && lane->base + lane->count + GROWTH <= r->capacity) {
        double size, jolt;
        if (!lane->driven && lane->t >= lane->until) {
            if (!coast(r)) return 0;
            lane->until = lane->t + INTERVAL_FREE;
            restart(r);
        }
        size = next_size(lane);
        if (size < lane->until - lane->t) lane->h = (lane->t + size) - lane->t; /* the difference of its ends */
        if (!try_steps(r->method, &r->w, lane, r->path, &trial)) return 0;
        /* the waves of an endless chain forget what happens to the granules behind them */
        jolt = lane->kinks ? trial.kink[0] / lane->tolerance : 0;
        if (jolt > 1) {
            jolt = lane->tolerance * pow(jolt, 1 / (r->method->exponent + 1) * (r->method->error_order + 1));
            if (jolt > trial.worst[0]) trial.worst[0] = jolt;
        }
        if (control(r->method, job, lane, trial.h[0], trial.worst[0], 0, trial.stop[0])) {
            if (meets(r, trial.h[0])) {
                store(r);
                if (!load(r, 0, lane->base + lane->count)) return 0;
                restart(r);
                lane->h = trial.h[0];
            } else if (!advance(r, &trial)) return 0;
        }
        if (lane->status == FAILED) return 1;
        if (!go_on(&r->batch, (double)(trial.n * r->method->stages))) return 0;
    }
    return 1;
}

/* ---------------------------------------------------------------- a wave at a contact */

/* Columns of the data of a wave; see wave_properties.py. */
enum { AFTER, BEFORE, ARRIVAL, HEIGHT, WAVE_MOMENTUM, WAVE_ENERGY, WAVE_WIDTH, FASTEST, WAVE_FOOT, WAVE };

#define NODES 8        /* Gauss nodes of a step */
#define NEIGHBOURS 4   /* number of samples on each side of a crossing that its polynomial interpolates */
#define TURNS 3        /* number of Newton steps to a maximum of the velocity */
#define EDGE 0.1       /* how far it may be from its step, over the size of the step */

static const double node[NODES] = {0.019855071751231912, 0.10166676129318664, 0.2372337950418355, 0.4082826787521751,
                                   0.5917173212478248, 0.7627662049581645, 0.8983332387068134, 0.9801449282487681};
static const double node_weight[NODES] = {0.05061426814518853, 0.11119051722668721, 0.15685332293894344, 0.18134189168918083,
                                          0.18134189168918083, 0.15685332293894344, 0.11119051722668721, 0.05061426814518853};

/* Motion of the contact between the second and third of four granules, with the state x, v at the end of a step: the
   overlap, and the position of the third granule from `origin`, each with three derivatives. */
static void contact_jets(const double *x, const double *v, double origin, double *overlap, double *position)
{
    double force[3], rate[3];
    int i;
    for (i = 0; i < 3; i++) {
        const double d = x[i] - x[i + 1], root = d > 0 ? sqrt(d) : 0;
        force[i] = root * root * root;
        rate[i] = 1.5 * root * (v[i] - v[i + 1]);
    }
    overlap[0] = x[1] - x[2];
    overlap[1] = v[1] - v[2];
    overlap[2] = force[0] - 2 * force[1] + force[2];
    overlap[3] = rate[0] - 2 * rate[1] + rate[2];
    position[0] = x[2] - origin;
    position[1] = v[2];
    position[2] = force[1] - force[2];
    position[3] = rate[1] - rate[2];
}

/* Time at which the force passes `level` upwards between samples `from` and `to`, in this direction of time, by inverse
   interpolation. */
static double level_time(const double *time, const double *force, long from, long to, double level)
{
    const long way = to < from ? -1 : 1, count = way * (to - from) + 1;
    long last = count, i, j, begin, end;
    double sum = 0;
    while (last > 0 && !(force[from + way * (last - 1)] < level)) last--;
    if (last == 0 || last == count) return time[from]; /* the force jumps across the level between two samples */
    begin = last > NEIGHBOURS ? last - NEIGHBOURS : 0;
    end = last + NEIGHBOURS < count ? last + NEIGHBOURS : count;
    for (i = begin; i < end; i++) {
        const double own = force[from + way * i];
        double product = 1;
        for (j = begin; j < end; j++) {
            const double other = force[from + way * j];
            if (other != own) product *= (level - other) / (own - other);
        }
        sum += (time[from + way * i] - time[from + way * last]) * product;
    }
    return time[from + way * last] + sum;
}

/* Maximum of the rate of change of the polynomial p near `share` of a step; 0 if it is outside. */
static double greatest_slope(const double *p, double share)
{
    double value, slope = 0, bend, curve;
    int turn, j;
    for (turn = 0; turn < TURNS; turn++) {
        for (value = slope = bend = curve = 0, j = 7; j >= 0; j--) {
            curve = curve * share + bend;
            bend = bend * share + slope;
            slope = slope * share + value;
            value = value * share + p[j];
        }
        if (!(curve < 0)) break;
        share -= bend / (3 * curve);
    }
    return share > -EDGE && share < 1 + EDGE ? slope : 0;
}

/* Measures a wave between the force minima around its peak, from `count` states of four granules at the ends of steps.
   Returns 0 without memory. */
static int read_wave(const double *times, const double *x, const double *v, long count, double *wave)
{
    const long samples = NODES * (count - 1);
    double *const time = malloc(4 * (size_t)samples * sizeof(double)), *force, *velocity, *weight;
    double last[8], next[8], p[8], q[8], momentum = 0, energy = 0;
    long i, j, k, top = 0, left = 0, right = 0, begin, end, fastest;
    if (!time) return 0;
    force = time + samples;
    velocity = force + samples;
    weight = velocity + samples;
    contact_jets(x, v, x[2], last, last + 4);
    for (i = 0; i + 1 < count; i++) {
        const double size = times[i + 1] - times[i];
        contact_jets(x + 4 * (i + 1), v + 4 * (i + 1), x[4 * i + 2], next, next + 4);
        last[4] = 0;
        powers_between(last, next, size, p);
        powers_between(last + 4, next + 4, size, q);
        for (k = 0; k < NODES; k++) {
            double overlap = p[7], slope = 7 * q[7];
            for (j = 6; j >= 0; j--) overlap = overlap * node[k] + p[j];
            for (j = 6; j >= 1; j--) slope = slope * node[k] + (double)j * q[j];
            time[NODES * i + k] = times[i] + size * node[k];
            force[NODES * i + k] = overlap > 0 ? overlap * sqrt(overlap) : 0;
            velocity[NODES * i + k] = slope / size;
            weight[NODES * i + k] = size * node_weight[k];
        }
        memcpy(last, next, sizeof last);
    }
    for (i = 1; i < samples; i++) if (fabs(time[i] - wave[ARRIVAL]) < fabs(time[top] - wave[ARRIVAL])) top = i;
    while (left < top && time[left] < wave[AFTER]) left++;
    while (right < samples && time[right] < wave[BEFORE]) right++;
    for (begin = left, i = left + 1; i <= top; i++) if (force[i] < force[begin]) begin = i;
    for (end = top, i = top + 1; i < right; i++) if (force[i] < force[end]) end = i;
    for (fastest = i = begin; i <= end; i++) {
        momentum += weight[i] * force[i];
        energy += weight[i] * force[i] * velocity[i];
        if (velocity[i] > velocity[fastest]) fastest = i;
    }
    wave[WAVE_MOMENTUM] = momentum;
    wave[WAVE_ENERGY] = energy;
    wave[WAVE_WIDTH] = level_time(time, force, end, top, wave[HEIGHT] / 2) - level_time(time, force, begin, top, wave[HEIGHT] / 2);
    wave[WAVE_FOOT] = (force[begin] > force[end] ? force[begin] : force[end]) / wave[HEIGHT];
    i = fastest / NODES;
    contact_jets(x + 4 * i, v + 4 * i, x[4 * i + 2], last, last + 4);
    contact_jets(x + 4 * (i + 1), v + 4 * (i + 1), x[4 * i + 2], next, next + 4);
    powers_between(last + 4, next + 4, times[i + 1] - times[i], q);
    wave[FASTEST] = greatest_slope(q, node[fastest % NODES]) / (times[i + 1] - times[i]);
    if (velocity[fastest] > wave[FASTEST]) wave[FASTEST] = velocity[fastest];
    free(time);
    return 1;
}

/* ---------------------------------------------------------------- Python interface */

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

/* Whether the buffers of `march` fit one another. */
static int march_fits(const Buffers *all, const March *r)
{
    const double *state = r->state;
    const Py_ssize_t *size = all->size;
    Py_ssize_t k;
    if (size[4] != STATE || size[5] != 3 * r->capacity || size[10] < r->capacity || r->capacity < 2) return 0;
    if (size[6] && (size[7] != size[6] * r->capacity || size[8] != size[7])) return 0;
    if (all->view[9].itemsize != sizeof(Peak)) return 0;
    for (k = 0; k < STATE; k++) if (!(state[k] >= 0)) return 0;
    if (!(state[STOP] < MAX_COUNT && state[PEAKS] < MAX_COUNT)) return 0;
    if (!(state[GRANULE_COUNT] <= (double)r->capacity && state[GRANULE_COUNT] - state[FLYING] >= 2)) return 0;
    if (!(state[RISE] > 0 && state[LENGTH] > 0 && state[ALLOWED] > 0 && state[CHAIN_GRANULES] < MAX_COUNT)) return 0;
    if (state[CHAIN_GRANULES] > 0 && state[GRANULE_COUNT] > state[CHAIN_GRANULES]) return 0;
    if (state[PEAKS] > (double)r->most_peaks) return 0;
    for (k = 0; k < r->capacity; k++) if (r->last[k] < -1 || r->last[k] >= (long long)state[PEAKS]) return 0;
    for (k = 0; k < (Py_ssize_t)state[PEAKS]; k++) if (r->peaks[k].previous >= k) return 0;
    if (!r->lane.path.pieces) return 0;
    for (k = (Py_ssize_t)state[STOP]; k < size[3]; k++) if (r->stops[k] >= state[LENGTH]) return 1;
    return 0;
}

PyDoc_STRVAR(march_doc, "march(method, rows, coefficients, stops, state, chain, times, x, v, peaks, last, expired)\n--\n\n"
             "Continues the integration of a whole chain to a target time, or until a buffer is full. Keeps the states at the\n"
             "ends of the steps if `times` is not empty, and logs the maxima of the contact forces. See integration_stretches.py.");

static PyObject *march(PyObject *self, PyObject *args)
{
    Buffers all;
    Method method;
    March r;
    int ok;
    (void)self;
    if (!take(&all, args, "march", "ffffFFFFFRI", 1)) return NULL;
    r = (March){
        .method = &method, .stops = all.view[3].buf, .state = all.view[4].buf, .x = all.view[5].buf, .times = all.view[6].buf,
        .xs = all.view[7].buf, .vs = all.view[8].buf, .peaks = all.view[9].buf, .last = all.view[10].buf,
        .capacity = (long)(all.size[5] / 3), .rows = (long)all.size[6], .most_peaks = (long)all.size[9],
        .lane = {.path = path_of(&all, 1, 0, 0)}};
    r.v = r.x + r.capacity;
    r.a = r.v + r.capacity;
    ok = method_of(all.view[0].buf, all.size[0], &method) && march_fits(&all, &r);
    if (ok) {
        Lane *lane = &r.lane;
        double *state = r.state;
        lane->path.rise_time = state[RISE];
        lane->path.force = state[PEAK_FORCE];
        lane->t = state[NOW];
        lane->h = state[STEP_SIZE];
        lane->until = state[UNTIL];
        lane->stop = (long)state[STOP];
        lane->duration = state[LENGTH];
        lane->driven = lane->t < lane->duration;
        lane->granules = (long)state[CHAIN_GRANULES];
        lane->kinks = lane->granules > 0;
        lane->tolerance = state[ALLOWED];
        state[KEPT_STEPS] = 0;
        if (lane->driven) free_path(&lane->path, lane->t, &r.path[0][0], &r.path[0][1]);
        r.batch.expired = PyTuple_GetItem(args, 11);
        r.w.lanes = r.part.lanes = 1;
        r.w.exponent = r.part.exponent = method.exponent;
        r.batch.thread = PyEval_SaveThread();
        ok = load(&r, (long)state[FLYING], (long)state[GRANULE_COUNT]) && march_on(&r) ? 2 : 1;
        PyEval_RestoreThread(r.batch.thread);
        if (ok == 2 || r.batch.stopped) store(&r);
        free(r.w.block);
        free(r.part.block);
        state[NOW] = lane->t;
        state[STEP_SIZE] = lane->h;
        state[UNTIL] = lane->until;
        state[STOP] = (double)lane->stop;
        state[GRANULE_COUNT] = (double)(lane->base + lane->count);
        state[FLYING] = (double)lane->base;
        state[EVALUATED] += (double)lane->evaluations;
        state[ENDED] = r.batch.stopped ? RUNNING : lane->status == FAILED ? FAILED : KNOWN;
    }
    if (!ok) return misfit(&all, "march");
    release(&all);
    if (PyErr_Occurred()) return NULL;
    if (ok == 1 && !r.batch.stopped) return PyErr_NoMemory();
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

PyDoc_STRVAR(attempt_doc, "attempt(method, rows, coefficients, state, after, time, size, rise_time, force)\n--\n\n"
             "One step of a chain; `state` and `after` contain x, v and the accelerations, one after the other.\n"
             "Without rows there is no force. Returns the largest difference from the embedded method.");

static PyObject *attempt_once(PyObject *self, PyObject *args)
{
    Buffers all;
    Method m;
    Window w;
    Path path;
    double number[4], h[BLOCK], shift[MAX_STAGES * BLOCK] = {0}, worst[BLOCK], impulse, *state, *after;
    long n, padded;
    int i;
    (void)self;
    for (i = 0; i < 4 && PyTuple_Size(args) == 9; i++) number[i] = PyFloat_AsDouble(PyTuple_GetItem(args, 5 + i));
    if (PyErr_Occurred() || !take(&all, args, "attempt", "ffffF", 4)) return NULL;
    n = (long)(all.size[3] / 3);
    path = path_of(&all, 1, number[2], number[3]);
    if (!method_of(all.view[0].buf, all.size[0], &m) || n < 2 || all.size[3] != 3 * n || all.size[4] != 3 * n
        || (all.size[1] && !path.pieces)) return misfit(&all, "attempt");
    padded = (n + BLOCK) / BLOCK * BLOCK;
    if (!window_of(&w, 1, padded + BLOCK, m.exponent)) {
        release(&all);
        return PyErr_NoMemory();
    }
    state = all.view[3].buf;
    after = all.view[4].buf;
    memcpy(w.x, state, (size_t)n * sizeof(double));
    memcpy(w.v, state + n, (size_t)n * sizeof(double));
    memcpy(w.k[0], state + 2 * n, (size_t)n * sizeof(double));
    for (i = 0; n + i < w.room; i++) w.x[n + i] = FAR;
    for (i = 0; i < BLOCK; i++) h[i] = number[1];
    for (i = 1; i < m.stages && path.pieces; i++)
        free_path(&path, number[0] + m.c[i] * number[1], shift + i * BLOCK, &impulse);
    attempt(&m, &w, padded, h, shift, worst);
    for (i = 1; i < BLOCK; i++) if (!(worst[i] <= worst[0])) worst[0] = worst[i];
    if (!m.last_is_next) {
        /* accelerations at the end of the step */
        swap(&w.x, &w.x1);
        stage(padded, 0, 0, m.a, h, shift + (m.stages - 1) * BLOCK, &w);
        swap(&w.x, &w.x1);
        memcpy(w.k[m.stages - 1], w.k[0], (size_t)n * sizeof(double));
    }
    memcpy(after, w.x1, (size_t)n * sizeof(double));
    memcpy(after + n, w.v1, (size_t)n * sizeof(double));
    memcpy(after + 2 * n, w.k[m.stages - 1], (size_t)n * sizeof(double));
    free(w.block);
    release(&all);
    return PyFloat_FromDouble(worst[0]);
}

static PyMethodDef functions[] = {
    {"primary", primary, METH_VARARGS, primary_doc},
    {"attempt", attempt_once, METH_VARARGS, attempt_doc},
    {"march", march, METH_VARARGS, march_doc},
    {"read", read_one, METH_VARARGS, read_doc},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT, "_compiled", "Compiled search for the leading waves of shocks.", 0, functions, NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__compiled(void)
{
    return PyModuleDef_Init(&module);
}
