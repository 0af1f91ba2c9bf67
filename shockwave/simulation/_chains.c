/* Integration of chains of mixed granules: the algorithm of chain_march.py in C, operation by operation.

   Body j is at x[j], v[j]; element j + 1 of an array of forces belongs to the contact between bodies j and j + 1, so that
   the neighbours of body j are elements j and j + 1. The function takes buffers of float64 and has no state; the global
   interpreter lock is released while it runs. */

#ifndef Py_LIMITED_API
#define Py_LIMITED_API 0x030B0000
#endif
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Compiled for several vector widths; the loader selects the widest that the processor supports. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define WIDE
#endif
#define INLINE static inline __attribute__((always_inline))

/* See chain_march.py for the meaning of the constants of the same names. */
#define MIN_OVERLAP 1e-60
#define WINDOW 12
#define GROWTH 8
#define MARGIN 4
#define AT_REST 1e-40
#define SAFETY 0.6
#define MIN_FACTOR 0.2
#define MAX_FACTOR 3.0
#define MIN_STEP 1e-15
#define MIN_FIRST 1e-13
#define SOON 1e-3
#define KINK 0.1
#define KINK_SHARE 0.1
#define MOST_CUTS 8
#define LOCATED 0.1
#define ROUNDING 1e-14
#define NEARLY 0.1
#define HOPELESS 1e6
#define MOST_TURNS 30
#define NEAR 1e-7
#define PASSED 0.99
#define WAVE 1e-3
#define MAX_STAGES 17
#define ROW 8        /* columns of a piece of the table of the free-particle displacement */
#define INTERVAL 2e6 /* number of contact forces between two calls of `expired`: tens of milliseconds */

enum { RUNNING, DONE, TOO_LONG, FAILED };
enum { EXPONENT, DAMPING_POWER, TOLERANCE, UNTIL, DURATION, RISE_TIME, PEAK_FORCE, FIRST, LONGEST, CONTACTS,
       END_STIFFNESS, END_DAMPING, MOST_STEPS, MOST_WORK, DAMPED, SETTINGS };
enum { INVERSE, STIFFNESS, GAP, BASE, ROOT, STATIC, DAMPING, REACH_W, REACH_U, COLUMNS };
enum { STATUS, TIME, ARRIVAL, WORK, STEPS, EVALUATIONS, FOUND };

/* State at one end of a step; see _End. */
typedef struct {
    double *x, *v, *d, *w, *f, *raw, *power, *slope;
} End;

typedef struct {
    const double *settings, *rows, *coefficients, *stops, *times;
    const double *nodes, *positions, *velocities, *weights; /* the method: weights is 6 x stages */
    const double *inverse, *k, *gap, *base, *root, *still, *c, *reach_w, *reach_u;
    double *scale_w, *scale_u, *best, *since, *impulse, *lost, *samples;
    long bodies, contacts, n, pieces, piece, stop, stop_count, sample, sample_count, steps, evaluations;
    int stages, order, moves, damped, jumps, driven, rejected, stopped; /* moves: whether stages have velocities */
    double p, q, tolerance, until, duration, time, size, held, work, arrival, effort, asked, free[2];
    double impulses[MAX_STAGES + 1];
    double *block, *y, *z, *tx, *tv, *tf, *traw, *tpower, *sum, *sum2, *on, *both, *stage[MAX_STAGES], *powers[MAX_STAGES];
    End start, finish;
    PyObject *expired;
    PyThreadState *thread;
} March;

/* ---------------------------------------------------------------- free-particle displacement */

/* Displacement and impulse of a free granule of mass 1 at time t: a Chebyshev series (Clenshaw) and a power on each piece. */
static void free_granule(March *m, double t, double *path, double *impulse)
{
    const double rise = m->settings[RISE_TIME], force = m->settings[PEAK_FORCE];
    double s = t / rise, z, b1 = 0, b2 = 0, d1 = 0, d2 = 0, next;
    const double *row, *c;
    long k = m->piece, low, high, i;
    if (s < m->rows[ROW * k] || (k + 1 < m->pieces && s >= m->rows[ROW * (k + 1)])) {
        for (low = 0, high = m->pieces; high - low > 1;) {
            k = (low + high) / 2;
            if (s >= m->rows[ROW * k]) low = k; else high = k;
        }
        m->piece = k = low;
    }
    row = m->rows + ROW * k;
    c = m->coefficients + 2 * (long)row[2];
    z = ((s - row[0]) - (row[1] - s)) / (row[1] - row[0]);
    for (i = (long)row[3] - 1; i > 0; i--) {
        next = c[2 * i] + 2 * z * b1 - b2;
        b2 = b1; b1 = next;
        next = c[2 * i + 1] + 2 * z * d1 - d2;
        d2 = d1; d1 = next;
    }
    if (row[3] > 0) {
        b1 = c[0] + z * b1 - b2;
        d1 = c[1] + z * d1 - d2;
    }
    if (row[4] != 0) {
        const double u = fabs(s - row[6]) / row[7], power = row[4] * pow(u, row[5] - 1);
        b1 += power * u;
        d1 += (row[6] <= row[0] ? power : -power) * row[5] / row[7];
    }
    *path = force * rise * rise * b1;
    *impulse = force * rise * d1;
}

/* Displacement of body 0 by the applied force since the beginning of the step, `passed` before, and the impulse. */
static double shift(March *m, double passed, double time, double *impulse)
{
    double path, all;
    free_granule(m, time, &path, &all);
    *impulse = all - m->free[1];
    return m->inverse[0] * ((path - m->free[0]) - passed * m->free[1]);
}

/* Applied force, from the difference of its impulse. */
static double applied(March *m, double time)
{
    const double about = 1e-4 * m->settings[LONGEST];
    const double before = time - about > 0 ? time - about : 0, after = time + about < m->duration ? time + about : m->duration;
    double path, first, last;
    if (!m->pieces || time >= m->duration) return 0;
    free_granule(m, before, &path, &first);
    free_granule(m, after, &path, &last);
    return (last - first) / (after - before);
}

/* ---------------------------------------------------------------- forces */

INLINE double power_of(double d, double q)
{
    return q == 0 ? 1 : q == 0.5 ? sqrt(d) : q == 0.25 ? sqrt(sqrt(d)) : pow(d, q);
}

/* Forces minus static ones f[1...], powers of the damping, forces before they are cut off, of contacts low to high. */
INLINE void contact_forces(const March *m, const double p, const double q, const int damped, const double *restrict x,
                           const double *restrict v, long low, long high, double *restrict f, double *restrict power,
                           double *restrict raw)
{
    const double *restrict const k = m->k, *restrict const gap = m->gap, *restrict const base = m->base;
    const double *restrict const root = m->root, *restrict const still = m->still, *restrict const c = m->c;
    const double *restrict const on = m->on;
    long j;
    for (j = low; j < high; j++) {
        const double stretch = (x[j] - x[j + 1]) + gap[j], d = stretch + base[j];
        const int closed = d > MIN_OVERLAP;
        const double inside = closed ? d : 1;
        double elastic, all, total;
        if (p == 1.5) {
            const double r = sqrt(inside);
            elastic = k[j] * (stretch * (d + r * root[j] + base[j]) / (r + root[j]));
        } else elastic = base[j] > 0 ? still[j] * expm1(p * log1p((closed ? stretch : 0) / base[j])) : k[j] * pow(inside, p);
        elastic = closed ? elastic : -still[j];
        all = total = elastic;
        if (damped) {
            const double w = v[j] - v[j + 1], viscous = c[j] * power_of(inside, q) * w;
            /* only the dashpot of a contact that is off does not act: its force would jump within the step */
            const int acts = q == 0 ? on[j] != 0 : closed;
            all = elastic + (q == 0 || closed ? viscous : 0);
            total = acts ? all : elastic;
            total = total <= -still[j] ? -still[j] : total;
            power[j] = (total - elastic) * w;
        }
        f[j + 1] = total;
        raw[j] = all + still[j];
    }
}

WIDE static void forces(const March *m, const double *x, const double *v, long low, long high, double *f, double *power,
                        double *raw)
{
    const double stiffness = m->settings[END_STIFFNESS], damping = m->settings[END_DAMPING];
    if (m->p != 1.5) contact_forces(m, m->p, m->q, m->damped, x, v, low, high, f, power, raw);
    else if (!m->damped) contact_forces(m, 1.5, 0, 0, x, v, low, high, f, power, raw);
    else if (m->q == 0) contact_forces(m, 1.5, 0, 1, x, v, low, high, f, power, raw);
    else if (m->q == 0.25) contact_forces(m, 1.5, 0.25, 1, x, v, low, high, f, power, raw);
    else if (m->q == 0.5) contact_forces(m, 1.5, 0.5, 1, x, v, low, high, f, power, raw);
    else contact_forces(m, 1.5, m->q, 1, x, v, low, high, f, power, raw);
    if (high == m->bodies && (stiffness != 0 || damping != 0)) {
        f[high] = stiffness * x[high - 1] + damping * v[high - 1];
        power[high - 1] = damping * v[high - 1] * v[high - 1];
    }
}

/* Time derivatives of the forces of closed contacts, before they are cut off. */
static void slopes(March *m, const double *x, const double *v, const double *f, const double *raw, long low, long high,
                   double time, double *slope)
{
    long j;
    for (j = low; j < high; j++) {
        const double d = (x[j] - x[j + 1]) + m->gap[j] + m->base[j], w = v[j] - v[j + 1];
        slope[j] = 0;
        if (!(d > MIN_OVERLAP && raw[j] > 0)) continue;
        slope[j] = m->p * m->k[j] * power_of(d, m->p - 1) * w;
        if (m->damped) {
            double a = m->inverse[j] * (f[j] - f[j + 1]);
            const double next = j + 1 < m->bodies ? m->inverse[j + 1] * (f[j + 1] - f[j + 2]) : 0;
            if (j == 0) a += m->inverse[0] * applied(m, time);
            slope[j] += m->c[j] * power_of(d, m->q) * (m->q / d * w * w + (a - next));
        }
    }
}

/* Everything at one end of a step, from positions and velocities. */
static void complete(March *m, End *end, double time)
{
    long j;
    forces(m, end->x, end->v, 0, m->n, end->f, end->power, end->raw);
    end->f[m->n + 1] = 0;
    for (j = 0; j < m->n; j++) {
        end->d[j] = (end->x[j] - end->x[j + 1]) + m->gap[j] + m->base[j];
        end->w[j] = end->v[j] - end->v[j + 1];
    }
    slopes(m, end->x, end->v, end->f, end->raw, 0, m->n, time, end->slope);
}

/* ---------------------------------------------------------------- steps */

/* sum[j] = sum of a[i] f_i[j], i < terms, of elements low to high. */
WIDE static void combine(double *const *stage, const double *a, int terms, long low, long high, double *restrict sum)
{
    long j;
    int i;
    for (j = low; j < high; j++) sum[j] = stage[0][j] * a[0];
    for (i = 1; i < terms; i++) {
        const double *restrict const f = stage[i];
        const double weight = a[i];
        if (weight == 0) continue;
        for (j = low; j < high; j++) sum[j] += weight * f[j];
    }
}

/* y = x + t v + factor (inverse mass) (difference of the sums), of bodies low to high; without v if t is 0. */
WIDE static void displace(const March *m, const double *restrict x, double t, const double *restrict v, double factor,
                          const double *restrict sum, long low, long high, double *restrict y)
{
    const double *restrict const inverse = m->inverse;
    long j;
    for (j = low; j < high; j++) y[j] = (x[j] + t * v[j]) + factor * (inverse[j] * (sum[j] - sum[j + 1]));
    y[high] = x[high];
}

/* Attempts a step of bodies low to high from m->start; the new state is valid one body per stage inside the range. */
static void attempt(March *m, double h, double end, long low, long high, double *x1, double *v1)
{
    const End *s = &m->start;
    const double square = h * h;
    double impulse;
    int i;
    m->stage[0] = s->f;
    m->powers[0] = s->power;
    for (i = 1; i < m->stages; i++) {
        const double t = m->nodes[i] * h;
        combine(m->stage, m->positions + i * m->stages, i, low, high + 1, m->sum);
        displace(m, s->x, t, s->v, square, m->sum, low, high, m->y);
        if (m->moves) {
            combine(m->stage, m->velocities + i * m->stages, i, low, high + 1, m->sum);
            displace(m, s->v, 0, s->v, h, m->sum, low, high, m->z);
        }
        if (m->driven && low == 0) {
            m->y[0] += shift(m, t, m->nodes[i] == 1 ? end : m->time + t, &impulse);
            m->z[0] += m->inverse[0] * impulse;
            m->impulses[i] = impulse;
        }
        forces(m, m->y, m->z, low, high, m->stage[i], m->powers[i], m->traw);
    }
    combine(m->stage, m->weights, m->stages, low, high + 1, m->sum);
    displace(m, s->x, h, s->v, square, m->sum, low, high, x1);
    combine(m->stage, m->weights + m->stages, m->stages, low, high + 1, m->sum);
    displace(m, s->v, 0, s->v, h, m->sum, low, high, v1);
    if (m->driven && low == 0) {
        x1[0] += shift(m, h, end, &impulse);
        v1[0] += m->inverse[0] * impulse;
        m->impulses[m->stages] = impulse;
    }
    m->evaluations += m->stages;
}

/* Largest change between neighbours of factor (inverse mass) (difference of the sums) over the scale. */
static double largest(const March *m, const double *sum, double factor, const double *scale)
{
    double most = 0, before = factor * (m->inverse[0] * (sum[0] - sum[1])), next, error;
    long j;
    for (j = 0; j < m->n; j++, before = next) {
        next = j + 1 < m->n ? factor * (m->inverse[j + 1] * (sum[j + 1] - sum[j + 2])) : 0;
        error = fabs(before - next) / scale[j];
        if (!(error < 1e300)) return INFINITY;
        if (error > most) most = error;
    }
    return most;
}

/* Largest error of the last attempt, over the tolerance. */
static double error_of(March *m, double h)
{
    double found[2] = {0, 0};
    int i;
    for (i = 0; i < 2; i++) {
        const double *weights = m->weights + (2 + 2 * i) * m->stages;
        double overlap, velocity;
        if (i && !m->moves) break;
        combine(m->stage, weights, m->stages, 0, m->n + 1, m->sum);
        combine(m->stage, weights + m->stages, m->stages, 0, m->n + 1, m->sum2);
        overlap = largest(m, m->sum, h * h, m->scale_u);
        velocity = largest(m, m->sum2, h, m->scale_w);
        found[i] = overlap > velocity ? overlap : velocity;
    }
    if (found[1] != 0) found[0] = found[0] * found[0] / sqrt(found[0] * found[0] + 0.01 * found[1] * found[1]);
    return found[0] / m->tolerance;
}

static double next_stop(const March *m)
{
    return m->stop < m->stop_count && m->stops[m->stop] < m->until ? m->stops[m->stop] : m->until;
}

/* Overlap by which a contact with a dashpot may be early or late to close. */
static double late(const March *m, const double *x, double w, long j)
{
    const double rate = m->both[j] * m->c[j], allowed = LOCATED * m->tolerance * m->scale_w[j] / (rate > 1e-300 ? rate : 1e-300);
    const double least = ROUNDING * (fabs(x[j]) + fabs(x[j + 1]) + m->time * fabs(w));
    return allowed > least ? allowed : least;
}

/* Size and end of the next step. */
static double next_size(const March *m, double *end)
{
    const double stop = next_stop(m), left = stop - m->time;
    double size = m->driven && m->size > m->settings[LONGEST] ? m->settings[LONGEST] : m->size, soon = INFINITY;
    long j;
    for (j = 0; j < m->n; j++) {
        const double d = m->start.d[j], w = m->start.w[j];
        if (d < 0 && w > 0 && -d / w < soon) soon = -d / w;
    }
    if (SOON * size < soon && soon < size) size = soon;
    *end = stop;
    if (size >= left) return left;
    if (size > left / 2) size = left / 2; /* avoids a very short last step */
    *end = m->time + size;
    return size;
}

/* Root in [0, 1] of the cubic with values d0, d1 of opposite signs and slopes m0, m1 at the ends. */
static double root_of(double d0, double d1, double m0, double m1)
{
    const double c = 3 * (d1 - d0) - 2 * m0 - m1, e = m0 + m1 - 2 * (d1 - d0);
    double low = 0, high = 1, at = d0 / (d0 - d1);
    int i;
    for (i = 0; i < 6; i++) {
        const double value = d0 + at * (m0 + at * (c + at * e)), slope = m0 + at * (2 * c + at * 3 * e);
        if (value * d0 > 0) low = at; else high = at;
        at = slope != 0 ? at - value / slope : -1;
        if (!(low <= at && at <= high)) at = (low + high) / 2;
    }
    return at;
}

/* Place in (0, 1) of the maximum of the cubic that rises by `rise`, with slopes r0 > 0 and r1 <= 0 at the ends. */
static double top_of(double r0, double r1, double rise)
{
    const double b = 6 * rise - 4 * r0 - 2 * r1, c = 3 * (r0 + r1) - 6 * rise, square = b * b - 4 * c * r0;
    const double at = square > 0 && sqrt(square) > b ? 2 * r0 / (sqrt(square) - b) : r0 / (r0 - r1);
    return at > 0 && at < 1 ? at : 0.5;
}

/* Fraction of the step at which it should end because a contact closes, opens or is cut off; 1 if it need not. */
static double kink(const March *m, double h)
{
    const End *s = &m->start, *f = &m->finish;
    double share = 1;
    long j;
    for (j = 0; j < m->n; j++) {
        const double d0 = s->d[j], d1 = f->d[j], raw0 = s->raw[j], raw1 = f->raw[j];
        const int acts = (m->jumps ? m->on[j] != 0 : d0 >= 0) && raw0 >= 0;
        double at, error, active, idle;
        int jumps;
        if (acts == (d1 >= 0 && raw1 >= 0)) continue;
        at = (d0 < 0) != (d1 < 0) ? root_of(d0, d1, h * s->w[j], h * f->w[j]) : 0.5;
        jumps = !acts && m->jumps && d0 < 0;
        if (m->damped && d0 >= 0 && raw0 * raw1 < 0 && (d1 >= 0 || m->q == 0)) at = raw0 / (raw0 - raw1);
        else if (m->damped && acts) at *= 0.5; /* the force ends before the contact opens */
        active = acts ? at : 1 - at;
        idle = acts ? 1 - at : at;
        error = KINK * h * (raw0 > raw1 ? raw0 : raw1) * (idle < active ? idle / active : 1);
        if (jumps) {
            const double w = s->w[j] > f->w[j] ? s->w[j] : f->w[j];
            error += m->c[j] * w * (1 - at) * h;
            if (w > 0) at += 0.5 * late(m, f->x, f->w[j], j) / (h * w);
        }
        if (error > KINK_SHARE * m->tolerance * m->scale_w[j] / m->both[j] && at < share
            && at * h > MIN_STEP * (m->time > m->settings[FIRST] ? m->time : m->settings[FIRST])) share = at;
    }
    return share;
}

/* ---------------------------------------------------------------- peaks and samples */

static void raise_best(March *m, long j, double force, double time)
{
    if (force > m->best[j]) { m->best[j] = force; m->since[j] = time; }
}

/* Computes the maximum of a contact force within the step, if it may be the greatest so far: repeated steps end at the
   time at which its slope vanishes, from cubic interpolation of the force. */
static void find_peak(March *m, double h, long j)
{
    const long reach = m->stages + 2, first = j > reach ? j - reach : 0, last = j + reach + 1 < m->n ? j + reach + 1 : m->n;
    const long near = j ? j - 1 : 0, after = j + 2 < m->n ? j + 2 : m->n;
    double low = 0, f0 = m->start.f[j + 1], r0 = h * m->start.slope[j];
    double high = 1, f1 = m->finish.f[j + 1], r1 = h * m->finish.slope[j];
    double share = low + (high - low) * top_of(r0, r1, f1 - f0), time = m->time, here = f0, slope, following, left;
    int turn;
    if ((f0 > f1 ? f0 : f1) + 0.25 * (r0 - r1) <= m->best[j] - NEARLY * fabs(m->best[j] + m->still[j])) return;
    for (turn = 0; turn < MOST_TURNS; turn++) {
        time = m->time + share * h;
        attempt(m, share * h, time, first, last, m->tx, m->tv);
        forces(m, m->tx, m->tv, near, after, m->tf, m->tpower, m->traw);
        m->tf[after + 1] = 0;
        if (!near) m->tf[0] = 0;
        slopes(m, m->tx, m->tv, m->tf, m->traw, j, j + 1, time, m->sum);
        slope = h * m->sum[j];
        here = m->tf[j + 1];
        if (slope > 0) { low = share; f0 = here; r0 = slope; }
        else { high = share; f1 = here; r1 = slope; }
        following = low + (high - low) * top_of((high - low) * r0, (high - low) * r1, f1 - f0);
        left = following - share;
        if (fabs(left) < NEAR || high - low < NEAR) {
            raise_best(m, j, here + 0.5 * slope * left, time + left * h);
            return;
        }
        share = following;
    }
    raise_best(m, j, here, time);
}

/* Stores the states at the requested times up to the end of the step. */
static void store_samples(March *m, double end)
{
    const size_t size = (size_t)(m->bodies + 1) * sizeof(double);
    for (; m->sample < m->sample_count && m->times[m->sample] <= end; m->sample++) {
        const double time = m->times[m->sample];
        double *row = m->samples + 3 * (m->bodies + 1) * m->sample;
        long j;
        memcpy(m->tx, m->start.x, size);
        memcpy(m->tv, m->start.v, size);
        if (time > m->time) attempt(m, time - m->time, time, 0, m->n, m->tx, m->tv);
        memcpy(row, m->tx, size);
        memcpy(row + m->bodies + 1, m->tv, size);
        forces(m, m->tx, m->tv, 0, m->bodies, m->tf, m->tpower, m->traw);
        for (j = 0; j < m->bodies; j++) row[2 * (m->bodies + 1) + j] = m->tf[j + 1] + m->still[j];
    }
}

/* ---------------------------------------------------------------- integration */

/* Begins the next step at m->start; contacts with a dashpot close here. */
static void begin(March *m)
{
    const double *x = m->start.x, *v = m->start.v;
    long j;
    for (j = 0; m->jumps && j < m->n; j++) {
        const double d = (x[j] - x[j + 1]) + m->gap[j] + m->base[j];
        m->on[j] = d >= 0 || (v[j] > v[j + 1] && d >= -late(m, x, v[j] - v[j + 1], j));
    }
    complete(m, &m->start, m->time);
    for (j = 0; j < m->n && j < m->contacts; j++) raise_best(m, j, m->start.f[j + 1], m->time);
}

/* Adds the work of the force, integrated by parts; see chain_march.py. */
static void add_work(March *m, double h, double end)
{
    const double inverse = m->inverse[0], impulse = m->impulses[m->stages], *weights = m->weights + m->stages;
    double mean = 0, summed = 0, product = 0, area, ignored;
    int i;
    for (i = 0; i < m->stages; i++) {
        product += weights[i] * m->impulses[i] * m->stage[i][1];
        mean += weights[i] * m->stage[i][1];
        summed += weights[i] * m->impulses[i];
    }
    area = shift(m, h, end, &ignored) / inverse;
    m->work += impulse * (m->finish.v[0] - inverse * impulse) + 0.5 * inverse * impulse * impulse;
    m->work += inverse * (h * product + mean * (area - h * summed));
}

/* Whether no contact force acts and none can follow. */
static int is_over(const March *m)
{
    long j;
    if (m->time < m->duration) return 0;
    for (j = 0; j < m->n; j++) if (m->start.f[j + 1] != 0 || m->start.w[j] > 0) return 0;
    return 1;
}

/* Sets the time at which the wave arrives at the last contact, and the end of the run if that depends on it. */
static void look_for_arrival(March *m)
{
    const long last = m->contacts - 1;
    if (m->arrival >= 0 || m->n <= last || !(m->best[last] > 0)) return;
    if (m->start.f[last + 1] < PASSED * m->best[last] && (last == 0 || m->best[last] >= WAVE * m->best[last - 1])) {
        m->arrival = m->since[last];
        if (m->until == INFINITY) {
            m->until = m->duration + 3 * m->arrival;
            if (m->until < m->time) m->until = m->time;
        }
    }
}

/* Elastic energy of a contact at an overlap. */
static double stored(const March *m, long j, double d)
{
    return d > 0 ? m->k[j] / (m->p + 1) * pow(d, m->p + 1) : 0;
}

/* Raises the scales of the errors to what was reached by n contacts, or is expected next to it. */
static void raise_scales(March *m, long n)
{
    double least_w = 0, least_u = 0;
    long j;
    for (j = 0; j < m->n; j++) {
        const double d = m->finish.d[j], w = j < n ? fabs(m->finish.w[j]) : 0, u = j < n ? fabs((d > 0 ? d : 0) - m->base[j]) : 0;
        if (m->reach_w[j] * least_w > m->scale_w[j]) m->scale_w[j] = m->reach_w[j] * least_w;
        if (m->reach_u[j] * least_u > m->scale_u[j]) m->scale_u[j] = m->reach_u[j] * least_u;
        if (w > m->scale_w[j]) m->scale_w[j] = w;
        if (u > m->scale_u[j]) m->scale_u[j] = u;
        least_w = m->scale_w[j];
        least_u = m->scale_u[j];
    }
}

/* Processes an accepted step and begins the next one. */
static void accept(March *m, double h, double end)
{
    const double *weights = m->weights + m->stages;
    const long n = m->n, last = n > MARGIN ? n - MARGIN : 0;
    End swapped = m->start;
    long j;
    combine(m->stage, weights, m->stages, 1, n + 1, m->sum);
    for (j = 0; j < n; j++) m->impulse[j] += h * m->sum[j + 1];
    if (m->damped) {
        combine(m->powers, weights, m->stages, 0, n, m->sum);
        for (j = 0; j < n; j++) {
            const End *s = &m->start, *f = &m->finish;
            /* a contact that is cut off loses its energy, whatever the length of the step */
            if (m->k[j] > 0 && (s->raw[j] < 0 || s->d[j] < 0) && (f->raw[j] < 0 || f->d[j] < 0)) m->lost[j] += stored(m, j, s->d[j]) - stored(m, j, f->d[j]);
            else m->lost[j] += h * m->sum[j];
        }
    }
    if (m->driven) add_work(m, h, end);
    for (j = 0; j < n; j++) if (m->start.slope[j] > 0 && m->finish.slope[j] <= 0) find_peak(m, h, j);
    store_samples(m, end);
    m->time = end;
    m->steps++;
    if (m->stop < m->stop_count && end == m->stops[m->stop]) m->stop++;
    if (m->driven) {
        free_granule(m, end, &m->free[0], &m->free[1]);
        m->driven = end < m->duration;
    }
    if (n < m->bodies && (fabs(m->finish.x[last]) > AT_REST || fabs(m->finish.v[last]) > AT_REST))
        m->n = n + GROWTH < m->bodies ? n + GROWTH : m->bodies;
    raise_scales(m, n);
    m->start = m->finish;
    m->finish = swapped;
    begin(m);
    look_for_arrival(m);
}

/* Checks from time to time for signals and for the end of the time limit; whether to go on. */
static int go_on(March *m)
{
    PyObject *answer;
    if (m->effort < m->asked) return 1;
    m->asked = m->effort + INTERVAL;
    PyEval_RestoreThread(m->thread);
    answer = PyErr_CheckSignals() < 0 ? NULL : PyObject_CallFunctionObjArgs(m->expired, NULL);
    m->stopped = !answer || PyObject_IsTrue(answer);
    Py_XDECREF(answer);
    m->thread = PyEval_SaveThread();
    return !m->stopped;
}

/* Integrates to the end; returns the status. */
static int integrate(March *m)
{
    const double first = m->settings[FIRST];
    int status = RUNNING, cuts = 0;
    begin(m);
    store_samples(m, 0);
    while (status == RUNNING && go_on(m)) {
        double end, h = next_size(m, &end), error, share = 1, factor;
        const int at_stop = end == next_stop(m);
        attempt(m, h, end, 0, m->n, m->finish.x, m->finish.v);
        error = error_of(m, h);
        complete(m, &m->finish, end);
        m->effort += (double)m->stages * (double)m->n;
        if (error < HOPELESS && cuts < MOST_CUTS) share = kink(m, h);
        factor = SAFETY * pow(error > 1e-12 ? error : 1e-12, -1.0 / (m->order + 1));
        if (share < 1) {
            if (!cuts++) m->held = error <= 1 ? m->size : h * (factor > MIN_FACTOR ? factor : MIN_FACTOR);
            m->size = h * share;
        } else if (!(error <= 1)) {
            const double least = MIN_STEP * m->time > MIN_FIRST * first ? MIN_STEP * m->time : MIN_FIRST * first;
            m->size = h * (factor > MIN_FACTOR && factor < 1 ? factor : MIN_FACTOR);
            m->rejected = 1;
            m->held = 0;
            if (m->size < least) status = FAILED;
        } else {
            /* a step that was shortened to end here does not shorten the next one */
            const double most = m->rejected ? 1 : MAX_FACTOR, kept = at_stop || h < m->size ? m->size : 0;
            m->size = h * (factor < most ? factor : most);
            if (m->held > m->size) m->size = m->held;
            if (kept > m->size) m->size = kept;
            m->rejected = cuts = 0;
            m->held = 0;
            accept(m, h, end);
            if (m->time >= m->until || (m->until == INFINITY && is_over(m))) status = DONE;
        }
        if (status == RUNNING && ((double)m->steps >= m->settings[MOST_STEPS] || m->effort > m->settings[MOST_WORK]))
            status = TOO_LONG;
    }
    return status;
}

/* Allocates the arrays; returns 0 without memory. */
static int make_room(March *m)
{
    const size_t row = (size_t)m->bodies + 2;
    double **const arrays[] = {&m->y, &m->z, &m->tx, &m->tv, &m->tf, &m->traw, &m->tpower, &m->sum, &m->sum2, &m->on, &m->both,
        &m->start.x, &m->start.v, &m->start.d, &m->start.w, &m->start.f, &m->start.raw, &m->start.power, &m->start.slope,
        &m->finish.x, &m->finish.v, &m->finish.d, &m->finish.w, &m->finish.f, &m->finish.raw, &m->finish.power,
        &m->finish.slope};
    const size_t named = sizeof arrays / sizeof *arrays;
    size_t i;
    double *at = m->block = calloc((named + 2 * (size_t)m->stages) * row, sizeof(double));
    if (!at) return 0;
    for (i = 0; i < named; i++, at += row) *arrays[i] = at;
    for (i = 0; i < (size_t)m->stages; i++, at += 2 * row) {
        m->stage[i] = at;
        m->powers[i] = at + row;
    }
    return 1;
}

/* ---------------------------------------------------------------- Python interface */

enum { V_METHOD, V_ROWS, V_COEFFICIENTS, V_STOPS, V_TIMES, V_SETTINGS, V_CHAIN, V_X, V_V, V_SCALES, V_PEAKS, V_SUMS, V_SAMPLES,
       V_FOUND, VIEWS };

static Py_ssize_t count_of(const Py_buffer *view) { return view->len / (Py_ssize_t)sizeof(double); }

/* Sets up a run from the buffers; returns 0 if they do not fit one another. */
static int set_up(March *m, const Py_buffer *view)
{
    const double *method = view[V_METHOD].buf, *chain = view[V_CHAIN].buf, *s = view[V_SETTINGS].buf;
    const Py_ssize_t bodies = count_of(view + V_X) - 1, pieces = count_of(view + V_ROWS) / ROW;
    Py_ssize_t k;
    if (count_of(view + V_METHOD) < 3 || !(method[0] >= 2 && method[0] <= MAX_STAGES)) return 0;
    m->stages = (int)method[0];
    if (count_of(view + V_METHOD) != 3 + m->stages * (2 * m->stages + 7)) return 0;
    if (bodies < 1 || count_of(view + V_V) != bodies + 1 || count_of(view + V_CHAIN) != COLUMNS * bodies) return 0;
    if (count_of(view + V_SCALES) != 2 * bodies || count_of(view + V_PEAKS) != 2 * bodies
        || count_of(view + V_SUMS) != 2 * bodies || count_of(view + V_SETTINGS) != SETTINGS
        || count_of(view + V_FOUND) != FOUND || count_of(view + V_SAMPLES) != 3 * (bodies + 1) * count_of(view + V_TIMES)) return 0;
    if (!(s[CONTACTS] >= 1 && s[CONTACTS] <= (double)bodies)) return 0;
    for (k = 0; k < pieces; k++) {
        const double *row = (const double *)view[V_ROWS].buf + ROW * k;
        if (!(row[2] >= 0 && row[3] >= 0 && row[2] + row[3] <= (double)(count_of(view + V_COEFFICIENTS) / 2))) return 0;
    }
    m->order = (int)method[1];
    m->moves = method[2] != 0;
    m->nodes = method + 3;
    m->positions = m->nodes + m->stages;
    m->velocities = m->positions + m->stages * m->stages;
    m->weights = m->velocities + m->stages * m->stages;
    m->settings = s;
    m->rows = view[V_ROWS].buf;
    m->coefficients = view[V_COEFFICIENTS].buf;
    m->pieces = (long)pieces;
    m->stops = view[V_STOPS].buf;
    m->stop_count = (long)count_of(view + V_STOPS);
    m->times = view[V_TIMES].buf;
    m->sample_count = (long)count_of(view + V_TIMES);
    m->samples = view[V_SAMPLES].buf;
    m->bodies = (long)bodies;
    m->contacts = (long)s[CONTACTS];
    m->inverse = chain + INVERSE * bodies;
    m->k = chain + STIFFNESS * bodies;
    m->gap = chain + GAP * bodies;
    m->base = chain + BASE * bodies;
    m->root = chain + ROOT * bodies;
    m->still = chain + STATIC * bodies;
    m->c = chain + DAMPING * bodies;
    m->reach_w = chain + REACH_W * bodies;
    m->reach_u = chain + REACH_U * bodies;
    m->scale_w = view[V_SCALES].buf;
    m->scale_u = m->scale_w + bodies;
    m->best = view[V_PEAKS].buf;
    m->since = m->best + bodies;
    m->impulse = view[V_SUMS].buf;
    m->lost = m->impulse + bodies;
    m->p = s[EXPONENT];
    m->q = s[DAMPING_POWER];
    m->tolerance = s[TOLERANCE];
    m->until = s[UNTIL];
    m->duration = s[DURATION];
    m->size = s[FIRST];
    m->damped = s[DAMPED] != 0;
    m->jumps = m->damped && m->q == 0;
    m->driven = pieces > 0;
    m->arrival = -1;
    m->n = m->bodies < WINDOW ? m->bodies : WINDOW;
    return 1;
}

PyDoc_STRVAR(run_doc, "run(method, rows, coefficients, stops, times, settings, chain, x, v, scales, peaks, sums, samples, found,"
             " expired)\n--\n\nIntegrates a chain of mixed granules, in place. See chain_march.py.");

static PyObject *run(PyObject *self, PyObject *args)
{
    Py_buffer view[VIEWS];
    March m;
    int i = 0, ok = 0, status = RUNNING;
    (void)self;
    memset(&m, 0, sizeof m);
    if (PyTuple_Size(args) != VIEWS + 1) return PyErr_Format(PyExc_TypeError, "run takes %d arguments", VIEWS + 1);
    for (; i < VIEWS; i++)
        if (PyObject_GetBuffer(PyTuple_GetItem(args, i), view + i, i >= V_X ? PyBUF_WRITABLE : PyBUF_SIMPLE) < 0) goto done;
    if (!set_up(&m, view)) PyErr_SetString(PyExc_ValueError, "buffers do not fit one another");
    else if (!make_room(&m)) PyErr_NoMemory();
    else {
        const size_t size = (size_t)(m.bodies + 1) * sizeof(double);
        double *found = view[V_FOUND].buf;
        long j;
        for (j = 0; j < m.bodies; j++) {
            m.both[j] = m.inverse[j] + (j + 1 < m.bodies ? m.inverse[j + 1] : 0);
            m.on[j] = 1;
        }
        memcpy(m.start.x, view[V_X].buf, size);
        memcpy(m.start.v, view[V_V].buf, size);
        m.expired = PyTuple_GetItem(args, VIEWS);
        m.thread = PyEval_SaveThread();
        status = integrate(&m);
        PyEval_RestoreThread(m.thread);
        memcpy(view[V_X].buf, m.start.x, size);
        memcpy(view[V_V].buf, m.start.v, size);
        found[STATUS] = status;
        found[TIME] = m.time;
        found[ARRIVAL] = m.arrival;
        found[WORK] = m.work;
        found[STEPS] = (double)m.steps;
        found[EVALUATIONS] = (double)m.evaluations;
        ok = !PyErr_Occurred();
    }
    free(m.block);
done:
    while (i-- > 0) PyBuffer_Release(view + i);
    if (!ok) return NULL;
    Py_RETURN_NONE;
}

static PyMethodDef functions[] = {{"run", run, METH_VARARGS, run_doc}, {NULL, NULL, 0, NULL}};

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT, "_chains", "Compiled integration of chains of mixed granules.", 0, functions, NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__chains(void)
{
    return PyModuleDef_Init(&module);
}
