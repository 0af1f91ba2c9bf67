/* A lane: one shock and the part of its chain around the leading wave. */

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

/* tried: contact of the front at the last attempt to cut */
typedef struct {
    long job, base, count, head, tried, granules, stop, wanted, last_wanted, steps, evaluations;
    int driven, status, kept, rejected;
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
