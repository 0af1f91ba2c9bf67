/* The search for the leading waves: steps of all lanes, one job after the other. */

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
    lane->evaluations += m->stages - m->last_is_first;
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
    for (l = 0; l < w->lanes; l++) any |= lanes[l].job >= 0 && lanes[l].driven;
    if (!any) return;
    find_changes(trial->n, w->lanes, w->x, w->x1, path, trial->kink);
    for (l = (int)w->lanes; l < BLOCK; l++) if (trial->kink[l] > trial->kink[0]) trial->kink[0] = trial->kink[l];
    for (l = 0; l < w->lanes; l++) {
        trial->kink[l] = lanes[l].job >= 0 && lanes[l].driven ? KINK * trial->kink[l] * stiffening(w->exponent, trial->kink[l]) * trial->h[l] : 0;
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
    if (!m->last_is_first) stage(trial->n, 0, 0, m->a, trial->h, trial->shift, w);
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

/* Whether to go on; asks at intervals of work. */
static int go_on(Batch *batch, double work)
{
    if ((batch->work += work) < INTERVAL) return 1;
    batch->work = 0;
    batch->stopped = interrupted(batch->expired, &batch->thread);
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
