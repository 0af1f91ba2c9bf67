/* The peaks of the leading wave, and the limit that they approach. */

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
        lane->evaluations += m->stages - m->last_is_first;
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
