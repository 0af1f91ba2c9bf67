/* Integration of chains of mixed granules: the algorithm of mixed_chain_run.py in C, operation by operation.

   Body j is at x[j], v[j]; element j + 1 of an array of forces belongs to the contact between bodies j and j + 1, so that
   the neighbours of body j are elements j and j + 1; element 0 is the weight of a striker. The function takes buffers of
   float64 and has no state; the global interpreter lock is released while it runs. */

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include "_buffers.h"
#include "_free_path.h"

/* Compiled for several vector widths; the loader selects the widest that the processor supports. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define WIDE
#endif
#define INLINE static inline __attribute__((always_inline))
typedef long long __attribute__((may_alias)) Bits;

#define MAX_STAGES 17
#define STEP 32 /* work on a stage besides that on the contacts, in contact forces */
#define INTERVAL 2e6 /* number of contact forces between two calls of `expired`: tens of milliseconds */

enum { RUNNING, DONE, TOO_LONG, FAILED };

/* Settings, constants and results of a run, in the order of mixed_chain_run.py, which explains them. */
typedef struct {
    double p, q, tolerance, until, duration, rise_time, peak_force, first, longest, contacts, end_stiffness, end_damping,
        most_work, damped, weight;
    double min_overlap, window, growth, margin, at_rest, safety, min_factor, max_factor, min_step, min_first, soon, kink,
        kink_share, most_cuts, located, rounding, elastic, viscous, nearly, hopeless, most_turns, near, passed, wave, noise;
    double status, time, arrival, work, steps, evaluations, rebound, size;
} Run;

/* State at one end of a step; see End in mixed_chain_forces.py. */
typedef struct { double *x, *v, *d, *w, *f, *raw, *power, *slope; } End;

typedef struct {
    Run *r;
    const double *stops, *times, *nodes, *positions, *velocities, *weights, *errors; /* of the method; weights: of the velocity */
    double *inverse, *k, *gap, *base, *root, *still, *c, *reach_w, *reach_u, *scale_w, *scale_u, *best, *since, *impulse, *lost;
    double *both, *on, *y, *z, *tx, *tv, *tf, *traw, *tpower, *sum, *stage[MAX_STAGES], *powers[MAX_STAGES], *samples;
    End start, finish;
    long bodies, n, stop, stop_count, sample, sample_count;
    int stages, order, moves, damped, loaded, jumps, driven, rejected, over, at_stop; /* moves: whether stages have velocities */
    double held, effort, asked, free[2], impulses[MAX_STAGES + 1];
    Path path;
    PyObject *expired;
    PyThreadState *thread;
} March;

static double larger(double one, double other) { return one > other ? one : other; }
static double smaller(double one, double other) { return one < other ? one : other; }

/* Displacement of body 0 by the applied force since the beginning of the step, `passed` before, and the impulse. */
static double shift(March *m, double passed, double time, double *impulse)
{
    double path, all;
    free_path(&m->path, time, &path, &all);
    *impulse = all - m->free[1];
    return m->inverse[0] * ((path - m->free[0]) - passed * m->free[1]);
}

/* Applied force, from the difference of its impulse. */
static double applied(March *m, double time)
{
    const double about = 1e-4 * m->r->longest, before = larger(time - about, 0), after = smaller(time + about, m->r->duration);
    double path, first, last;
    if (!m->path.pieces || time >= m->r->duration) return 0;
    free_path(&m->path, before, &path, &first);
    free_path(&m->path, after, &path, &last);
    return (last - first) / (after - before);
}

/* ---------------------------------------------------------------- forces */

INLINE double power_of(double d, double q)
{
    return q == 0 ? 1 : q == 0.5 ? sqrt(d) : q == 0.25 ? sqrt(sqrt(d)) : pow(d, q);
}

/* Forces minus static ones f[1...], powers of the damping, forces before they are cut off, of contacts low to high. */
INLINE void contact_forces(const March *m, const double p, const double q, const int damped, const int loaded,
                           const double *restrict x, const double *restrict v, long low, long high, double *restrict f,
                           double *restrict power, double *restrict raw)
{
    const double *restrict const k = m->k, *restrict const gap = m->gap, *restrict const base = m->base;
    const double *restrict const root = m->root, *restrict const still = m->still, *restrict const c = m->c;
    const double *restrict const on = m->on, least = m->r->min_overlap;
    long j;
    for (j = low; j < high; j++) {
        const double stretch = (x[j] - x[j + 1]) + gap[j], d = stretch + base[j], inside = d > least ? d : 1, r = sqrt(inside);
        double elastic = p == 1.5 && !loaded ? k[j] * (d * r) : p == 1.5 ? k[j] * (stretch * (d + r * root[j] + base[j]) / (r + root[j]))
            : base[j] > 0 ? still[j] * expm1(p * log1p((d > least ? stretch : 0) / base[j])) : k[j] * pow(inside, p);
        double all = elastic = d > least ? elastic : -still[j], total = all;
        if (damped) {
            const double w = v[j] - v[j + 1], viscous = c[j] * power_of(inside, q) * w;
            all = elastic + (q == 0 || d > least ? viscous : 0);
            /* only the dashpot of a contact that is off does not act: its force would jump within the step */
            total = larger(-still[j], (q == 0 ? on[j] != 0 : d > least) ? all : elastic);
            power[j] = (total - elastic) * w;
        }
        f[j + 1] = total;
        raw[j] = all + still[j];
    }
}

WIDE static void forces(const March *m, const double *x, const double *v, long low, long high, double *f, double *power,
                        double *raw)
{
    const double p = m->r->p, q = m->r->q, stiffness = m->r->end_stiffness, damping = m->r->end_damping;
#define FORCES(p, q, damped, loaded) contact_forces(m, p, q, damped, loaded, x, v, low, high, f, power, raw)
    if (p == 1.5 && !m->damped && !m->loaded) FORCES(1.5, 0, 0, 0);
    else if (p == 1.5 && !m->damped) FORCES(1.5, 0, 0, 1);
    else if (p == 1.5 && q == 0 && !m->loaded) FORCES(1.5, 0, 1, 0);
    else if (p == 1.5 && q == 0.25 && !m->loaded) FORCES(1.5, 0.25, 1, 0);
    else if (p == 1.5 && q == 0.5 && !m->loaded) FORCES(1.5, 0.5, 1, 0);
    else FORCES(p, q, m->damped, m->loaded);
    if (high == m->bodies && (stiffness != 0 || damping != 0)) {
        f[high] = stiffness * x[high - 1] + damping * v[high - 1];
        power[high - 1] = damping * v[high - 1] * v[high - 1];
    }
}

/* Time derivative of the force of contact j before it is cut off, from its overlap and closing velocity; 0 if it is open. */
INLINE double slope_of(const March *m, const double p, const double q, const int damped, double d, double w, const double *f,
                       double raw, long j, double push)
{
    const double least = m->r->min_overlap, inside = d > least ? d : 1;
    double all = p * m->k[j] * power_of(inside, p - 1) * w;
    if (damped) {
        const double a = m->inverse[j] * (f[j] - f[j + 1]) + (j ? 0 : push), next = m->inverse[j + 1] * (f[j + 1] - f[j + 2]);
        all += m->c[j] * power_of(inside, q) * (q / inside * w * w + (a - next));
    }
    return d > least && raw > 0 ? all : 0;
}

/* Everything at one end of a step, from positions and velocities. */
WIDE static void complete(March *m, End *end, double time)
{
    const double *restrict const x = end->x, *restrict const v = end->v, *restrict const raw = end->raw;
    double *restrict const d = end->d, *restrict const w = end->w, *restrict const slope = end->slope;
    const double p = m->r->p, q = m->r->q, push = m->damped ? m->inverse[0] * applied(m, time) : 0;
    long j;
    forces(m, x, v, 0, m->n, end->f, end->power, end->raw);
    end->f[m->n + 1] = 0;
    for (j = 0; j < m->n; j++) {
        d[j] = (x[j] - x[j + 1]) + m->gap[j] + m->base[j];
        w[j] = v[j] - v[j + 1];
    }
    if (p == 1.5 && !m->damped) for (j = 0; j < m->n; j++) slope[j] = slope_of(m, 1.5, 0, 0, d[j], w[j], end->f, raw[j], j, 0);
    else for (j = 0; j < m->n; j++) slope[j] = slope_of(m, p, q, m->damped, d[j], w[j], end->f, raw[j], j, push);
}

/* ---------------------------------------------------------------- steps */

/* sum[j] = sum of a[i] f_i[j], i < terms, of elements low to high. */
WIDE static void combine(double *const *f, const double *a, int terms, long low, long high, double *restrict sum)
{
    const double *each[MAX_STAGES + 1], *const first = f[0];
    double weight[MAX_STAGES + 1];
    int i, count = 0;
    long j;
    for (i = 1; i < terms; i++) if (a[i] != 0) { each[count] = f[i]; weight[count++] = a[i]; }
    for (j = low; j < high; j++) sum[j] = first[j] * a[0];
    for (i = 0; i + 1 < count; i += 2) { /* two at a time: fewer accesses to the sum */
        const double *restrict const one = each[i], *restrict const other = each[i + 1], w = weight[i], u = weight[i + 1];
        for (j = low; j < high; j++) sum[j] = (sum[j] + w * one[j]) + u * other[j];
    }
    if (i < count) for (j = low; j < high; j++) sum[j] += weight[i] * each[i][j];
}

/* y = x + t v + factor (inverse mass) (difference of the sums of the forces), of bodies low to high. */
WIDE static void displace(March *m, const double *restrict x, double t, const double *restrict v, double factor,
                          const double *weights, int terms, long low, long high, double *restrict y)
{
    const double *restrict const inverse = m->inverse, *restrict const sum = m->sum;
    long j;
    combine(m->stage, weights, terms, low, high + 1, m->sum);
    for (j = low; j < high; j++) y[j] = (x[j] + t * v[j]) + factor * (inverse[j] * (sum[j] - sum[j + 1]));
    y[high] = x[high];
}

/* Attempts a step of bodies low to high from m->start; the new state is valid one body per stage inside the range. */
static void attempt(March *m, double h, double end, long low, long high, double *x1, double *v1)
{
    const End *s = &m->start;
    const int stages = m->stages;
    int i;
    m->stage[0] = s->f;
    m->powers[0] = s->power;
    for (i = 1; i <= stages; i++) {
        const double t = m->nodes[i] * h;
        double *const y = i < stages ? m->y : x1, *const z = i < stages ? m->z : v1;
        displace(m, s->x, t, s->v, h * h, m->positions + i * stages, i, low, high, y);
        if (i == stages || m->moves) displace(m, s->v, 0, s->v, h, m->velocities + i * stages, i, low, high, z);
        if (m->driven && low == 0) {
            y[0] += shift(m, t, m->nodes[i] == 1 ? end : m->r->time + t, m->impulses + i);
            z[0] += m->inverse[0] * m->impulses[i];
        }
        if (i < stages) forces(m, y, z, low, high, m->stage[i], m->powers[i], m->traw);
    }
    m->r->evaluations += stages;
}

/* Largest change between neighbours of factor (inverse mass) (difference of the sums) over the scale. */
WIDE static double largest(March *m, const double *weights, double factor, const double *restrict scale)
{
    const double *restrict const sum = m->sum, *restrict const inverse = m->inverse;
    double *restrict const change = m->y, *restrict const error = m->z, greatest;
    Bits *const bits = (Bits *)error, most = 0;
    long j;
    combine(m->stage, weights, m->stages, 0, m->n + 1, m->sum);
    for (j = 0; j < m->n; j++) change[j] = factor * (inverse[j] * (sum[j] - sum[j + 1]));
    change[m->n] = 0;
    for (j = 0; j < m->n; j++) error[j] = fabs(change[j] - change[j + 1]) / scale[j];
    /* positive numbers are in the order of their bits, and a NaN is beyond all of them */
    for (j = 0; j < m->n; j++) most = bits[j] > most ? bits[j] : most;
    memcpy(&greatest, &most, sizeof greatest);
    return greatest < 1e300 ? greatest : INFINITY;
}

/* Largest error of the last attempt, over the tolerance. */
static double error_of(March *m, double h)
{
    const double *w = m->errors, *u = w + 2 * m->stages;
    const double second = m->moves ? larger(largest(m, u, h * h, m->scale_u), largest(m, u + m->stages, h, m->scale_w)) : 0;
    const double first = larger(largest(m, w, h * h, m->scale_u), largest(m, w + m->stages, h, m->scale_w));
    const double rough = 0.01 * second * second;
    return (rough != 0 ? first * first / sqrt(first * first + rough) : first) / m->r->tolerance;
}

/* Overlap by which a contact with a dashpot may be early or late to close. */
static double late(const March *m, const double *x, double w, long j)
{
    const double most = smaller(m->scale_w[j] / larger(m->both[j] * m->c[j], 1e-300), m->scale_u[j]);
    return larger(most * (m->r->located * m->r->tolerance), m->r->rounding * (fabs(x[j]) + fabs(x[j + 1]) + m->r->time * fabs(w)));
}

/* Impulse that changes the closing velocity of a contact by the tolerance. */
static double allowed(const March *m, long j) { return m->r->tolerance * m->scale_w[j] / m->both[j]; }

/* Impulse that a step misses if no force acts in a fraction of it. */
static double kink_error(const March *m, double h, double force, double idle)
{
    return m->r->kink * h * force * smaller(1, idle / larger(1 - idle, 1e-300));
}

/* Size and end of the next step, which ends where a contact is predicted to close or, without damping, to open. */
static double next_size(March *m, double *end)
{
    const double stop = m->stop < m->stop_count ? smaller(m->stops[m->stop], m->r->until) : m->r->until;
    const double left = stop - m->r->time, p = m->r->p + 1, q = m->r->q + 1, h = m->r->size;
    double most = h, size = m->driven ? m->r->longest : INFINITY;
    long j;
    for (j = 0; j < m->n; j++) {
        const double d = m->start.d[j], w = m->start.w[j], at = -d / w / h;
        if (!(fabs(d) < h * fabs(w))) continue;
        if (at > m->r->soon && (d < 0 || (!m->damped && kink_error(m, h, m->start.raw[j], 1 - at) > m->r->kink_share * allowed(m, j))))
            size = smaller(size, at * h);
        if (w > 0 && fabs(d) < m->r->soon * h * w) { /* it has just closed: the force is a power of the time */
            most = smaller(most, pow(allowed(m, j) / (m->r->elastic * m->k[j] * pow(w, p - 1)), 1 / p));
            if (q > 1) most = smaller(most, pow(allowed(m, j) / (m->r->viscous * m->c[j] * pow(w, q)), 1 / q));
        }
    }
    m->r->size = most;
    m->at_stop = smaller(size, most) >= left;
    size = m->at_stop ? left : smaller(smaller(size, most), left / 2); /* avoids a very short last step */
    *end = m->at_stop ? stop : m->r->time + size;
    return size;
}

/* Root in (0, 1) of the cubic with values y0, y1 of opposite signs and slopes b0, b1 at 0 and 1, from that of a parabola. */
static double root_of(double y0, double b0, double y1, double b1)
{
    const double c = 3 * (y1 - y0) - 2 * b0 - b1, e = b0 + b1 - 2 * (y1 - y0);
    double at = 2 * y0 / (copysign(sqrt((b0 + 2 * y0) * (b0 + 2 * y0) - 4 * y0 * y1), y0) - b0);
    int i;
    for (i = 0; i < 3; i++) at -= (y0 + at * (b0 + at * (c + at * e))) / (b0 + at * (2 * c + at * 3 * e));
    return at > 0 && at < 1 ? at : y0 / (y0 - y1);
}

/* Position of the maximum in (0, 1) of a cubic that rises by `rise`, with slopes r0 > 0 and r1 <= 0 at its ends. */
static double top_of(double r0, double r1, double rise)
{
    const double at = root_of(r0, 6 * rise - 4 * r0 - 2 * r1, r1, 2 * r0 + 4 * r1 - 6 * rise);
    return at < 1 ? at : 0.5;
}

/* Fraction of the step at which it should end because a contact closes, opens or is cut off; 1 if it need not. */
static double kink(const March *m, double h)
{
    const End *s = &m->start, *f = &m->finish;
    double share = 1;
    long j;
    for (j = 0; j < m->n; j++) {
        const double d0 = s->d[j], d1 = f->d[j], raw0 = s->raw[j], raw1 = f->raw[j], w = larger(s->w[j], f->w[j]);
        const double change = raw1 - raw0, rate = raw0 > 0 ? h * s->slope[j] : change;
        const int acts = (m->jumps ? m->on[j] != 0 : d0 >= 0) && raw0 >= 0;
        double at, error;
        if (acts == (d1 >= 0 && raw1 >= 0)) continue;
        at = (d0 < 0) != (d1 < 0) ? root_of(d0, h * s->w[j], d1, h * f->w[j]) : 0.5;
        if (m->damped && d0 >= 0 && raw0 * raw1 < 0 && (d1 >= 0 || m->r->q == 0))
            at = smaller(d1 >= 0 ? 1 : at, root_of(raw0, rate, raw1, 2 * change - rate));
        else if (m->damped && acts) at *= 0.5; /* the force ends before the contact opens */
        error = kink_error(m, h, larger(raw0, raw1), acts ? 1 - at : at);
        if (!acts && m->jumps && d0 < 0) {
            error += m->c[j] * w * (1 - at) * h;
            if (w > 0) at += 0.5 * late(m, f->x, f->w[j], j) / (h * w);
        }
        if (error > m->r->kink_share * allowed(m, j) && at * h > m->r->min_step * larger(m->r->time, m->r->first))
            share = smaller(share, at);
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
    const double rise = f1 - f0, c = 3 * rise - 2 * r0 - r1, e = r0 + r1 - 2 * rise, at = -c / (3 * e), ends = larger(f0, f1);
    const double value = f0 + at * (r0 + at * (c + at * e)), middle = r0 + at * (2 * c + at * 3 * e);
    double left, share = 0, time = m->r->time, here = f0, slope = r0, d, w, push, turn;
    /* a cubic with slopes of the same sign may have a maximum and a minimum, on both sides of its point of inflection */
    if (r0 > 0 && r1 > 0 && at > 0 && at < 1) { high = at; f1 = value; r1 = middle; }
    else if (r0 <= 0 && r1 <= 0 && at > 0 && at < 1) { low = at; f0 = value; r0 = middle; }
    if (r0 <= 0 || r1 > 0 || larger(f0, f1) + 0.25 * (high - low) * (r0 - r1)
        <= larger(m->best[j] - m->r->nearly * fabs(m->best[j] + m->still[j]), ends)) return;
    for (turn = 0; left = low + (high - low) * top_of((high - low) * r0, (high - low) * r1, f1 - f0) - share,
        turn < m->r->most_turns && fabs(left) >= m->r->near && high - low >= m->r->near; turn++) {
        time = m->r->time + (share += left) * h;
        attempt(m, share * h, time, first, last, m->tx, m->tv);
        forces(m, m->tx, m->tv, near, after, m->tf, m->tpower, m->traw);
        m->tf[near] = near ? 0 : m->r->weight;
        m->tf[after + 1] = 0;
        push = j ? 0 : m->inverse[0] * applied(m, time);
        d = (m->tx[j] - m->tx[j + 1]) + m->gap[j] + m->base[j];
        w = m->tv[j] - m->tv[j + 1];
        slope = h * slope_of(m, m->r->p, m->r->q, m->damped, d, w, m->tf, m->traw[j], j, push);
        here = m->tf[j + 1];
        if (slope > 0) { low = share; f0 = here; r0 = slope; }
        else { high = share; f1 = here; r1 = slope; }
    }
    raise_best(m, j, here + 0.5 * slope * left, time + left * h);
}

/* Stores the states at the requested times up to the end of the step. */
static void store_samples(March *m, double end)
{
    const long row = m->bodies + 1;
    for (; m->sample < m->sample_count && m->times[m->sample] <= end; m->sample++) {
        const double time = m->times[m->sample];
        double *x = m->samples + 3 * row * m->sample, *v = x + row;
        long j;
        attempt(m, time - m->r->time, time, 0, m->n, x, v);
        forces(m, x, v, 0, m->bodies, m->tf, m->tpower, m->traw);
        for (j = 0; j < m->bodies; j++) v[row + j] = m->tf[j + 1] + m->still[j];
    }
}

/* ---------------------------------------------------------------- integration */

/* Begins the next step at m->start, whose forces of n contacts are known; contacts with a dashpot close here. The motion
   is over if no contact force acts and none can follow: beyond the last contact a granule flies off freely. */
static void begin(March *m, long n)
{
    const double *x = m->start.x, *v = m->start.v;
    int changed = n < m->n;
    long j;
    for (j = 0; m->jumps && j < m->n; j++) {
        const double d = (x[j] - x[j + 1]) + m->gap[j] + m->base[j], w = v[j] - v[j + 1], before = m->on[j];
        m->on[j] = d >= 0 || (w > 0 && d >= -late(m, x, w, j));
        changed = changed || m->on[j] != before;
    }
    if (changed) complete(m, &m->start, m->r->time);
    m->over = m->r->time >= m->r->duration;
    for (j = 0; j < m->n && j < m->r->contacts; j++) {
        raise_best(m, j, m->start.f[j + 1], m->r->time);
        m->over = m->over && m->start.f[j + 1] == 0 && !(m->start.w[j] > 0);
    }
}

/* Adds the work of the force, integrated by parts; see mixed_chain_run.py. */
static void add_work(March *m, double h, double end)
{
    const double inverse = m->inverse[0], impulse = m->impulses[m->stages], *weights = m->weights;
    double mean = 0, summed = 0, product = 0, ignored, area = shift(m, h, end, &ignored) / inverse;
    int i;
    for (i = 0; i < m->stages; i++) {
        product += weights[i] * m->impulses[i] * m->stage[i][1];
        mean += weights[i] * m->stage[i][1];
        summed += weights[i] * m->impulses[i];
    }
    m->r->work += impulse * (m->finish.v[0] - inverse * impulse) + 0.5 * inverse * impulse * impulse;
    m->r->work += inverse * (h * product + mean * (area - h * summed));
}

/* Sets the time at which the wave arrives at the last contact, and the end of the run if that depends on it. */
static void look_for_arrival(March *m)
{
    const long last = (long)m->r->contacts - 1;
    if (m->r->arrival >= 0 || m->n <= last || !(m->best[last] > 0)) return;
    if (m->start.f[last + 1] >= m->r->passed * m->best[last]) return;
    /* a wall that oscillates ahead of the wave: that has not passed the contact before */
    if (last && m->start.f[last] >= m->r->passed * m->best[last - 1]) return;
    if (m->best[last] < m->r->noise * m->still[last] || (last && m->best[last] < m->r->wave * m->best[last - 1])) return;
    m->r->arrival = m->since[last];
    if (m->r->until == INFINITY) m->r->until = larger(m->r->duration + 3 * m->r->arrival, m->r->time);
}

/* Raises the scales of the errors to what was reached by n contacts, or is expected next to it. */
WIDE static void raise_scales(March *m, long n)
{
    const End *f = &m->finish;
    long j;
    for (j = 0; j < n; j++) {
        /* the change of the overlap, not the difference of overlaps: ahead of the wave that is below their rounding errors */
        const double u = fabs((f->x[j] - f->x[j + 1]) + m->gap[j]);
        m->scale_w[j] = larger(m->scale_w[j], fabs(f->w[j]));
        m->scale_u[j] = larger(m->scale_u[j], f->d[j] > 0 ? u : m->base[j]);
    }
    for (j = m->n - 1; j > 0; j--) {
        m->scale_w[j] = larger(m->scale_w[j], m->reach_w[j] * m->scale_w[j - 1]);
        m->scale_u[j] = larger(m->scale_u[j], m->reach_u[j] * m->scale_u[j - 1]);
    }
}

/* Processes an accepted step and begins the next one. */
static void accept(March *m, double h, double end)
{
    const End s = m->start, f = m->finish;
    const double p = m->r->p + 1;
    const long n = m->n, last = n > m->r->margin ? n - (long)m->r->margin : 0;
    long j;
    combine(m->stage, m->weights, m->stages, 1, n + 1, m->sum);
    for (j = 0; j < n; j++) m->impulse[j] += h * m->sum[j + 1];
    if (m->damped) combine(m->powers, m->weights, m->stages, 0, n, m->sum);
    /* a contact that is cut off loses its energy, whatever the length of the step */
    for (j = 0; m->damped && j < n; j++)
        if (m->k[j] > 0 && (s.raw[j] < 0 || s.d[j] < 0) && (f.raw[j] < 0 || f.d[j] < 0))
            m->lost[j] += m->k[j] / p * (pow(larger(s.d[j], 0), p) - pow(larger(f.d[j], 0), p));
        else m->lost[j] += h * m->sum[j];
    if (m->driven) add_work(m, h, end);
    for (j = 0; j < n; j++) find_peak(m, h, j);
    store_samples(m, end);
    if (m->r->weight > 0 && m->r->rebound == 0 && s.d[0] >= 0 && f.d[0] < 0 && f.v[0] < 0) /* the velocity at the opening */
        m->r->rebound = f.v[0] - m->inverse[0] * m->r->weight * h * (1 - root_of(s.d[0], h * s.w[0], f.d[0], h * f.w[0]));
    m->r->time = end;
    m->r->steps++;
    if (m->stop < m->stop_count && end == m->stops[m->stop]) m->stop++;
    if (m->driven) free_path(&m->path, end, &m->free[0], &m->free[1]);
    m->driven = m->driven && end < m->r->duration;
    if (n < m->bodies && (fabs(f.x[last]) > m->r->at_rest || fabs(f.v[last]) > m->r->at_rest))
        m->n = (long)smaller((double)n + m->r->growth, (double)m->bodies);
    raise_scales(m, n);
    m->start = f;
    m->finish = s;
    begin(m, n);
    look_for_arrival(m);
}

/* Checks from time to time for signals and for the end of the time limit; whether to go on. */
static int go_on(March *m)
{
    PyObject *answer;
    int end;
    if (m->effort < m->asked) return 1;
    m->asked = m->effort + INTERVAL;
    PyEval_RestoreThread(m->thread);
    answer = PyErr_CheckSignals() < 0 ? NULL : PyObject_CallFunctionObjArgs(m->expired, NULL);
    end = !answer || PyObject_IsTrue(answer);
    Py_XDECREF(answer);
    m->thread = PyEval_SaveThread();
    return !end;
}

/* Integrates to the end; returns the status. */
static int integrate(March *m)
{
    const Run *r = m->r;
    int status = RUNNING, cuts = 0;
    begin(m, 0);
    store_samples(m, 0);
    while (status == RUNNING && go_on(m)) {
        double end, h = next_size(m, &end), error, share = 1, factor;
        attempt(m, h, end, 0, m->n, m->finish.x, m->finish.v);
        error = error_of(m, h);
        complete(m, &m->finish, end);
        m->effort += (double)m->stages * ((double)m->n + STEP);
        if (error < r->hopeless && cuts < r->most_cuts) share = kink(m, h);
        factor = r->safety * pow(larger(error, 1e-12), -1.0 / (m->order + 1));
        if (share < 1) {
            if (!cuts++) m->held = error <= 1 ? m->r->size : h * larger(factor, r->min_factor);
            m->r->size = h * share;
        } else if (!(error <= 1)) {
            m->r->size = h * (factor > r->min_factor && factor < 1 ? factor : r->min_factor);
            m->rejected = 1;
            m->held = 0;
            if (m->r->size < larger(r->min_step * r->time, r->min_first * r->first)) status = FAILED;
        } else {
            /* a step that was shortened to end here does not shorten the next one */
            const double kept = m->at_stop || h < m->r->size ? m->r->size : 0;
            m->r->size = larger(larger(h * smaller(factor, m->rejected ? 1 : r->max_factor), m->held), kept);
            m->held = m->rejected = cuts = 0;
            accept(m, h, end);
            if (r->time >= r->until || (r->until == INFINITY && m->over)) status = DONE;
        }
        if (status == RUNNING && m->effort > r->most_work) status = TOO_LONG;
    }
    return status;
}

/* ---------------------------------------------------------------- Python interface */

enum { METHOD, ROWS, COEFFICIENTS, STOPS, TIMES, RUN, TABLE, SAMPLES, VIEWS };

/* Sets up a run from the buffers; returns 0 if they do not fit one another. The rows of the table are listed here. */
static int set_up(March *m, const Buffers *all)
{
    double **const rows[] = {&m->inverse, &m->k, &m->gap, &m->base, &m->root, &m->still, &m->c, &m->reach_w, &m->reach_u,
        &m->scale_w, &m->scale_u, &m->best, &m->since, &m->impulse, &m->lost, &m->start.x, &m->start.v, &m->both, &m->on, &m->y,
        &m->z, &m->tx, &m->tv, &m->tf, &m->traw, &m->tpower, &m->sum, &m->start.d, &m->start.w, &m->start.f,
        &m->start.raw, &m->start.power, &m->start.slope, &m->finish.x, &m->finish.v, &m->finish.d, &m->finish.w, &m->finish.f,
        &m->finish.raw, &m->finish.power, &m->finish.slope};
    const Py_ssize_t named = sizeof rows / sizeof *rows;
    const Py_buffer *view = all->view;
    const Py_ssize_t *count = all->size;
    const double *method = view[METHOD].buf, *setting;
    Run *r = view[RUN].buf;
    Py_ssize_t width, s, i;
    if (count[METHOD] < 3 || !(method[0] >= 2 && method[0] <= MAX_STAGES && method[1] >= 0 && method[1] < 100)) return 0;
    s = (Py_ssize_t)method[0];
    width = count[TABLE] / (named + 2 * s);
    if (count[METHOD] != 4 + s * (2 * s + 7) || view[RUN].len != sizeof(Run) || width < 3 || count[TABLE] % (named + 2 * s)
        || !(r->contacts >= 1 && r->contacts <= (double)width - 2) || !(r->window >= 1 && r->growth >= 1)
        || count[SAMPLES] != 3 * (width - 1) * count[TIMES]) return 0;
    for (setting = &r->p; setting < &r->status; setting++) if (!(*setting >= 0)) return 0;
    *m = (March){
        .r = r, .stops = view[STOPS].buf, .stop_count = (long)count[STOPS], .times = view[TIMES].buf,
        .sample_count = (long)count[TIMES], .samples = view[SAMPLES].buf, .stages = (int)s, .order = (int)method[1],
        .nodes = method + 3, .positions = method + 4 + s, .velocities = method + 4 + s * (s + 2),
        .weights = method + 4 + s * (2 * s + 2), .errors = method + 4 + s * (2 * s + 3), .moves = method[2] != 0, .damped = r->damped != 0,
        .jumps = r->damped != 0 && r->q == 0, .driven = count[ROWS] > 0, .bodies = (long)width - 2,
        .n = (long)smaller((double)width - 2, r->window),
        .path = path_of(all, ROWS, r->rise_time, r->peak_force)};
    if (m->driven && !m->path.pieces) return 0;
    for (i = 0; i < named; i++) *rows[i] = (double *)view[TABLE].buf + i * width;
    for (i = 0; i < s; i++) {
        m->stage[i] = (double *)view[TABLE].buf + (named + 2 * i) * width;
        m->powers[i] = m->stage[i] + width;
        m->stage[i][0] = r->weight;
    }
    m->start.f[0] = m->finish.f[0] = r->weight;
    for (i = 0; i < m->bodies; i++) m->loaded = m->loaded || m->base[i] > 0;
    if (m->driven && m->r->time > 0) free_path(&m->path, m->r->time, &m->free[0], &m->free[1]);
    return 1;
}

PyDoc_STRVAR(run_doc, "run(method, rows, coefficients, stops, times, settings, table, samples, expired)\n--\n\n"
             "Integrates a chain of mixed granules, in place. See mixed_chain_run.py.");

static PyObject *run(PyObject *self, PyObject *args)
{
    Buffers all;
    March m;
    End first;
    (void)self;
    if (!take(&all, args, "run", "fffffFFF", 1)) return NULL;
    if (!set_up(&m, &all)) return misfit(&all, "run");
    first = m.start;
    m.expired = PyTuple_GetItem(args, VIEWS);
    m.thread = PyEval_SaveThread();
    m.r->status = integrate(&m);
    PyEval_RestoreThread(m.thread);
    /* the two ends of a step change places */
    memmove(first.x, m.start.x, (size_t)(m.bodies + 1) * sizeof(double));
    memmove(first.v, m.start.v, (size_t)(m.bodies + 1) * sizeof(double));
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
