/* The whole chain, with all its waves: stretches of an integration that Python continues. */

/* The state of an integration of the whole chain, which `march` continues; see simulation/integration_stretches.py. FLYING is the
   number of granules in free flight at the loaded end, whose positions are those at the time FLOWN. */
enum { NOW, STEP_SIZE, UNTIL, STOP, GRANULE_COUNT, FLYING, FLOWN, AGE, TAKEN, KEPT_STEPS, EVALUATED, PEAKS, STRONGEST, ENDED,
       TARGET, RISE, PEAK_FORCE, LENGTH, CHAIN_GRANULES, ALLOWED, KEPT_SINCE, STATE };

#define STRETCH 50.0          /* interval between the ends of integrations after the force has ended */
#define GROWTH 16             /* number of granules by which the window grows */
#define MARGIN 4              /* number of granules at its end that must be at rest */
#define PARTING 16            /* number of steps between the checks for granules in free flight */
/* see peak_log.py */
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
    if (!(force > FLOOR * r->state[STRONGEST])) return 1;
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
            lane->until = lane->t + STRETCH;
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
