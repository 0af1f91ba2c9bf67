/* A run of `_chains.c`: settings, the state of the chain, and the rows in which it works.

   Body j is at x[j], v[j]; contact j lies between bodies j and j + 1. Rows have BLOCK elements before the first body and
   after the last block, so that the neighbours of every body are in the row; element -1 of the forces is the weight of a
   striker. Bodies beyond the window are at rest: their elements of `mobile` and of the reaches are zero. */

#define HERTZ 1.5     /* exponent of the contact force of spheres */

enum { RUNNING, DONE, TOO_LONG, FAILED, PAUSED };

/* Settings, constants and results of a run, in the order of chain_backend.py. */
typedef struct {
    double tolerance, until, duration, rise_time, peak_force, first, longest, contacts, end_stiffness, end_damping,
        most_work, damped, weight, guided;
    double window, far, largest, min_overlap, growth, margin, at_rest, safety, min_factor, max_factor, min_step, min_first, step_work, interval,
        soon, kink, kink_share, most_cuts, located, rounding, elastic, viscous, nearly, hopeless, most_turns, near, at_end, nudge,
        passed, wave, noise, instant, parts, sharp, finer, fastest;
    double status, time, arrival, work, steps, evaluations, rebound, size, extremes[3], extreme_times[3];
} Run;

/* A maximum of a contact force, a row of the log of peak_log.py. */
typedef struct {
    long long contact, behind, previous;
    double time, force;
} Peak;

/* What is recorded of a whole chain, and how far; see chain_record.py. */
typedef struct { double continues, kinks, since, strongest, peaks, kept, window; } Record;

/* State at one end of a step; see End in chain_forces.py. */
typedef struct { double *x, *v, *u, *d, *w, *f, *raw, *power, *stiffness, *slope, *a; } End;

/* The coefficients of a sum over the stages that are not zero, and the stages to which they belong. */
typedef struct { int count, at[MAX_STAGES]; double a[MAX_STAGES]; } Terms;

/* A method; the terms after those of the stages are those of the end of the step. */
typedef struct {
    int stages, order, damped, last_is_first, jerk, estimates; /* damped: whether stages have velocities; jerk: see nystroem_tableaux.py */
    const double *nodes, *weights;
    Terms positions[MAX_STAGES + 1], velocities[MAX_STAGES + 1], errors[4];
} Method;

/* Rows of properties of elastic-plastic contacts, of their state, and of constants within a step, and pieces of their loading
   curves; see chain_modes.py. */
typedef struct {
    double *softness, *curvature, *rate, *slowness, *curves, *wider, *virgin, *start, *first, *cap, *full, *a, *b, *level, *slope, *yield, *unit;
    double *mode, *reached, *force, *left, *limit, *offset, *tangent, *curved, *ended;
    const double *pieces;
} Plastic;
#define PLASTIC_ROWS 26
#define UNSAMPLED 2

typedef struct March March;

/* The functions over blocks of elements, for the widest vectors of the processor; see `_stage.h`. */
typedef struct {
    void (*attempt)(March *, double h, double end, long low, long high, End *to);
    void (*evaluate)(March *, End *, long low, long high, double time);
    void (*complete)(March *, End *, long low, long high, double time);
    double (*error)(March *, double h);
    long (*near)(const March *, double h, long from), (*changed)(const March *, long from), (*passing)(const March *, long from), (*turning)(const March *, double h, long from),
        (*above)(const March *, long from), (*yielding)(const March *, double h, long from);
    void (*raise_scales)(March *, long high);
} Kernel;

struct March {
    Run *r;
    Kernel kernel;
    Method method;
    const double *stops, *times;
    double *inverse, *k, *gap, *base, *root, *still, *c, *far_w, *far_u, *scale_w, *scale_u, *best, *since, *lost, *both, *on;
    double *exponents, *powers, power; /* p and q of the contacts, and q if all have the same, else -1 */
    double *mobile, *reach_w, *reach_u, *y, *z, *shares, *flowing, *stage[MAX_STAGES], *room[MAX_STAGES], *felt[MAX_STAGES], *samples, *rows;
    End start, finish, trial, scratch;
    const long long *watched; /* contacts whose impulses are summed; after the first UNSAMPLED the rows of the samples, in ascending order */
    double *watched_impulses, *gained, *forces[MAX_STAGES]; /* gained: in the last step; forces: of each stage, at the first contact and those watched */
    long bodies, n, padded, flows, first_flow, after_flow, stop, stop_count, sample, sample_count, watched_count; /* padded: bodies of the window in whole blocks */
    Plastic plastic;
    Record *record; /* NULL unless the peaks are logged */
    Peak *peaks;
    long long *last_peak; /* of each contact, or -1 */
    double *states;
    long most_peaks, most_states;
    int kinks, yields, hertz, damped, loaded, jumps, driven, rejected, cuts, over, at_stop;
    double held, effort, asked, free[2], impulses[MAX_STAGES + 1];
    Path path;
    PyObject *expired;
    PyThreadState *thread;
};

static double larger(double value, double limit) { return value > limit ? value : limit; }
static double smaller(double value, double limit) { return value < limit ? value : limit; }

/* Number of contacts of the window. */
static long contacts_of(const March *m) { return (long)smaller((double)m->n, m->r->contacts); }

/* The power q of d by the C library; by roots where possible: they are the same everywhere. */
static double power_of(double d, double q)
{
    if (q == HERTZ) return d * sqrt(d);
    if (q == 0.5) return sqrt(d);
    if (q == 0.25) return sqrt(sqrt(d));
    return q == 0 ? 1 : pow(d, q);
}

/* Displacement of body 0 by the applied force since the beginning of the step, `passed` before, and the impulse. */
static double shift(March *m, double passed, double time, double *impulse)
{
    double path, all;
    free_path(&m->path, time, &path, &all);
    *impulse = all - m->free[1];
    return m->inverse[0] * ((path - m->free[0]) - passed * m->free[1]);
}

/* Keeps the forces of a stage at the contacts of which the integral is asked. */
static void watch(March *m, const double *f, int stage)
{
    double *const to = m->forces[stage];
    long i;
    to[0] = f[0];
    for (i = 0; i < m->watched_count; i++) to[1 + i] = f[m->watched[i]];
}

/* Applied force, from the difference of its impulse. */
static double applied(March *m, double time)
{
    const double about = m->r->instant * smaller(m->r->longest, m->r->duration), before = larger(time - about, 0), after = smaller(time + about, m->r->duration);
    double path, first, last;
    if (!m->path.pieces || time >= m->r->duration) return 0;
    free_path(&m->path, before, &path, &first);
    free_path(&m->path, after, &path, &last);
    return (last - first) / (after - before);
}

/* Overlap by which a contact with a dashpot may be early or late to close. */
static double late(const March *m, const double *x, double w, long j)
{
    const double most = smaller(m->scale_w[j] / larger(m->both[j] * m->c[j], 1e-300), m->scale_u[j]);
    return larger(most * (m->r->located * m->r->tolerance), m->r->rounding * (fabs(x[j]) + fabs(x[j + 1]) + m->r->time * fabs(w)));
}

/* Impulse that changes the closing velocity of a contact by the tolerance. */
static double allowed(const March *m, long j) { return m->r->tolerance * m->scale_w[j] / m->both[j]; }

/* Closing acceleration of a contact at one end of a step. */
static double closing(March *m, const End *end, long j, double time)
{
    return end->a[j] + (j ? 0 : m->inverse[0] * applied(m, time)) - end->a[j + 1];
}

static void raise_best(March *m, long j, double force, double time)
{
    if (force > m->best[j]) { m->best[j] = force; m->since[j] = time; }
}

/* Coefficients of the polynomial of degree 5 with the changes of an overlap, and their derivatives, at both ends of a step. */
static void overlap_of(March *m, double h, long j, double c[6])
{
    const End *s = &m->start, *f = &m->finish;
    const double w0 = h * s->w[j], a0 = h * h * closing(m, s, j, m->r->time), a1 = h * h * closing(m, f, j, m->r->time + h);
    const double u = f->u[j] - s->u[j] - w0 - a0 / 2, w = h * f->w[j] - w0 - a0, a = a1 - a0;
    c[0] = s->u[j];
    c[1] = w0;
    c[2] = a0 / 2;
    c[3] = 10 * u - 4 * w + a / 2;
    c[4] = -15 * u + 7 * w - a;
    c[5] = 6 * u - 3 * w + a / 2;
}

/* Change of the overlap, closing velocity and acceleration at a fraction s of a step, in units of it. */
static void motion_at(const double c[6], double s, double *u, double *w, double *a)
{
    *u = c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))));
    *w = c[1] + s * (2 * c[2] + s * (3 * c[3] + s * (4 * c[4] + s * 5 * c[5])));
    *a = 2 * c[2] + s * (6 * c[3] + s * (12 * c[4] + s * 20 * c[5]));
}

/* Course of a number of contact j within a step of size h, by the polynomial of its overlap. */
typedef double Course(const March *, double h, long j, const double c[6], double s);

/* Fraction of the step at which a number vanishes, between those where it is positive and where it is not, from a first
   estimate; `bend` receives its derivative there. */
static double vanish(Course *value, const March *m, double h, long j, const double c[6], double low, double high, double at, double *bend)
{
    double here, last = 0, before = 0, next;
    int turn;
    *bend = 0;
    for (turn = 0; turn < m->r->most_turns; turn++, before = at, last = here, at = next) {
        here = value(m, h, j, c, at);
        if (here > 0) low = at; else high = at;
        if (turn && at != before) *bend = (here - last) / (at - before);
        next = *bend < 0 ? at - here / *bend : at + m->r->nudge * (here > 0 ? 1 : -1);
        if (!(next > low && next < high) || (turn && !(*bend < 0))) next = 0.5 * (low + high);
        if (turn && fabs(next - at) < m->r->near) return next;
    }
    return at;
}
