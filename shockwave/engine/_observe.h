/* Observers of accepted steps: greatest forces, samples, work, losses, arrival. */

/* Change of the force per step at a fraction s of it, by the polynomial of the overlap. */
static double slope_at(const March *m, double h, long j, const double c[6], double s)
{
    double d, w, a;
    motion_at(c, s, &d, &w, &a);
    d += m->base[j];
    if (m->yields && m->plastic.mode[j] > ELASTIC) return h * flow_rate(m, j, d, w / h, a / (h * h));
    return h * rate_1(m, j, stiffness_1(m, m->hertz, j, d), d, w / h, a / (h * h));
}

/* Interval of a step with values and slopes, per step, at its ends. */
typedef struct { double low, f0, r0, high, f1, r1; } Interval;

/* Narrows an interval to that around the maximum of the cubic; whether there may be one above `least` and both ends. */
static int narrow(Interval *of, double least)
{
    const double rise = of->f1 - of->f0, r0 = of->r0, r1 = of->r1, c = 3 * rise - 2 * r0 - r1, e = r0 + r1 - 2 * rise, at = -c / (3 * e);
    const double value = of->f0 + at * (r0 + at * (c + at * e)), middle = r0 + at * (2 * c + at * 3 * e), ends = larger(of->f0, of->f1);
    /* a cubic with slopes of the same sign may have a maximum and a minimum, on both sides of its point of inflection */
    if (r0 > 0 && r1 > 0 && at > 0 && at < 1) { of->high = at; of->f1 = value; of->r1 = middle; }
    else if (r0 <= 0 && r1 <= 0 && at > 0 && at < 1) { of->low = at; of->f0 = value; of->r0 = middle; }
    return of->r0 > 0 && of->r1 <= 0 && larger(of->f0, of->f1) + 0.25 * (of->high - of->low) * (of->r0 - of->r1) > larger(least, ends);
}

/* Place of the maximum of the cubic in a narrowed interval. */
static double top_in(const Interval *of)
{
    const double span = of->high - of->low;
    return of->low + span * top_of(span * of->r0, span * of->r1, of->f1 - of->f0);
}

/* Attempts a step to m->trial of as many bodies as affect contacts low to high. */
static void attempt_near(March *m, double h, double end, long low, long high)
{
    const long reach = m->method.stages + 2, first = low > reach ? (low - reach) / BLOCK * BLOCK : 0;
    const long last = (long)smaller((double)((high + reach + 1 + BLOCK) / BLOCK * BLOCK), (double)m->padded);
    m->kernel.attempt(m, h, end, first, last, &m->trial);
    m->kernel.complete(m, &m->trial, first, last, end);
}

/* Computes the maximum of a contact force within the step, if it may be the greatest so far: at the end of a step to the
   time at which its slope vanishes, by the polynomial of the overlap. */
static void find_peak(March *m, double h, long j)
{
    Interval of = {0, m->start.f[j], h * m->start.slope[j], 1, m->finish.f[j], h * m->finish.slope[j]};
    double c[6], share, left = 0, slope = 0, bend;
    int turn;
    if (!narrow(&of, m->best[j] - m->r->nearly * fabs(m->best[j] + m->still[j]))) return;
    overlap_of(m, h, j, c);
    share = vanish(slope_at, m, h, j, c, of.low, of.high, top_in(&of), &bend);
    if (1 - share < m->r->at_end) {
        raise_best(m, j, m->finish.f[j] + 0.5 * h * m->finish.slope[j] * (share - 1), m->r->time + share * h);
        return;
    }
    for (turn = 0; turn < m->r->most_turns; turn++) {
        const double time = m->r->time + share * h;
        attempt_near(m, share * h, time, j, j);
        slope = h * m->trial.slope[j];
        left = bend < 0 ? -slope / bend : 0;
        left = larger(smaller(left, 1 - share), -share);
        if (fabs(left) < m->r->near) break;
        if (turn + 1 < m->r->most_turns) share += left;
    }
    raise_best(m, j, m->trial.f[j] + 0.5 * slope * left, m->r->time + (share + left) * h);
}

/* Computes all maxima within the step that may be the greatest so far. */
static void find_peaks(March *m, double h)
{
    const long contacts = contacts_of(m);
    long j;
    for (j = 0; (j = m->kernel.turning(m, h, j)) < contacts; j++) find_peak(m, h, j);
}

/* Displacement, acceleration and spring force of a movable end, and their changes in a step of size h. */
static void read_end(const March *m, const End *at, double h, double y[3], double rate[3])
{
    const long j = m->bodies - 1;
    const double v = at->v[j], a = at->a[j], spring = m->r->end_stiffness * v + m->r->end_damping * a;
    y[0] = at->x[j];
    y[1] = a;
    y[2] = at->f[j];
    rate[0] = h * v;
    rate[1] = h * m->inverse[j] * (at->slope[j - 1] - spring);
    rate[2] = h * spring;
}

/* Computes the greatest magnitudes of the motion of a movable end within the step. */
static void find_extremes(March *m, double h)
{
    const long reach = m->bodies - m->method.stages - 3, first = reach > 0 ? reach / BLOCK * BLOCK : 0;
    double y[3][3], r[3][3];
    int i, side, turn;
    if (m->n < m->bodies || m->r->extremes[0] == INFINITY) return; /* there is none */
    read_end(m, &m->start, h, y[0], r[0]);
    read_end(m, &m->finish, h, y[1], r[1]);
    for (i = 0; i < 3; i++) for (side = -1; side <= 1; side += 2) {
        double *best = m->r->extremes + i, *since = m->r->extreme_times + i, share = 0, before = -1;
        Interval of = {0, side * y[0][i], side * r[0][i], 1, side * y[1][i], side * r[1][i]};
        if (of.f0 > *best) { *best = of.f0; *since = m->r->time; }
        if (of.f1 > *best) { *best = of.f1; *since = m->r->time + h; }
        if (!narrow(&of, *best)) continue;
        for (turn = 0; turn < m->r->most_turns && fabs(share - before) >= m->r->near; turn++) {
            before = share;
            share = top_in(&of);
            m->kernel.attempt(m, share * h, m->r->time + share * h, first, m->padded, &m->trial);
            m->kernel.complete(m, &m->trial, first, m->padded, m->r->time + share * h);
            read_end(m, &m->trial, h, y[2], r[2]);
            if (side * r[2][i] > 0) { of.low = share; of.f0 = side * y[2][i]; of.r0 = side * r[2][i]; }
            else { of.high = share; of.f1 = side * y[2][i]; of.r1 = side * r[2][i]; }
        }
        if (side * y[2][i] > *best) { *best = side * y[2][i]; *since = m->r->time + top_in(&of) * h; }
    }
}

/* Impulse at a watched contact within the last attempt, of size h. */
static double impulse_in(const March *m, double h, long watched)
{
    double sum = 0;
    int i;
    for (i = 0; i < m->method.stages; i++) sum += m->method.weights[i] * m->forces[i][1 + watched];
    return h * sum;
}

/* Stores the state at a time of the sampled rows from one of them on that are near each other; returns the next row. */
static long store_rows(March *m, double time, long i)
{
    const long long *const row = m->watched;
    const long sampled = m->watched_count - UNSAMPLED, most = 2 * (m->method.stages + 2) + BLOCK;
    double *const to = m->samples + (4 + m->yields) * sampled * m->sample - UNSAMPLED;
    long after = i + 1;
    while (after < m->watched_count && row[after] - row[after - 1] <= most) after++;
    if (row[i] < m->padded) attempt_near(m, time - m->r->time, time, (long)row[i], (long)row[after - 1]);
    for (; i < after; i++) {
        const long j = (long)row[i];
        const int inside = j < m->padded;
        to[i] = inside ? m->trial.x[j] : 0;
        to[sampled + i] = inside ? m->trial.v[j] : 0;
        to[2 * sampled + i] = (inside ? m->trial.f[j] : 0) + m->still[j];
        to[3 * sampled + i] = m->watched_impulses[i] + (inside ? impulse_in(m, time - m->r->time, i) : 0);
        if (m->yields) to[4 * sampled + i] = inside ? released(m, j, m->trial.d[j], m->trial.f[j] + m->still[j]) : 0;
    }
    return after;
}

/* Stores the sampled rows at the requested times up to the end of the step, and adds its impulses. */
static void store_samples(March *m, double end)
{
    long j;
    for (; m->sample < m->sample_count && m->times[m->sample] <= end; m->sample++) {
        long i = UNSAMPLED;
        while (i < m->watched_count) i = store_rows(m, m->times[m->sample], i);
    }
    for (j = 0; j < m->watched_count; j++) m->watched_impulses[j] += m->gained[j];
}

/* Adds the work of the force, integrated by parts; see chain_run.py. */
static void add_work(March *m, double h, double end)
{
    const double inverse = m->inverse[0], impulse = m->impulses[m->method.stages], *weights = m->method.weights;
    double mean = 0, summed = 0, product = 0, ignored, area = shift(m, h, end, &ignored) / inverse;
    int i;
    for (i = 0; i < m->method.stages; i++) {
        product += weights[i] * m->impulses[i] * m->forces[i][0];
        mean += weights[i] * m->forces[i][0];
        summed += weights[i] * m->impulses[i];
    }
    if (m->r->guided) m->r->work += m->start.v[0] * h * mean; /* the path of body 0 is given: the force on it is that of the contact */
    else m->r->work += impulse * (m->finish.v[0] - inverse * impulse) + 0.5 * inverse * impulse * impulse;
    m->r->work += inverse * (h * product + mean * (area - h * summed));
}

/* Sets the impulses at the watched contacts, and adds the energy that all dissipate. */
static void add_losses(March *m, double h)
{
    const End *s = &m->start, *f = &m->finish;
    long j;
    for (j = 0; j < m->watched_count; j++) m->gained[j] = impulse_in(m, h, j);
    if (m->flows) add_flow(m, h);
    /* a contact that is cut off loses its energy, whatever the length of the step */
    for (j = 0; m->damped && j < m->n; j++) {
        const double p = m->exponents[j] + 1;
        if (m->k[j] > 0 && (s->raw[j] < 0 || s->d[j] < 0) && (f->raw[j] < 0 || f->d[j] < 0))
            m->lost[j] += m->k[j] / p * (pow(larger(s->d[j], 0), p) - pow(larger(f->d[j], 0), p));
        else m->lost[j] += h * m->shares[j];
    }
}

/* Velocity of a striker with a weight when it first leaves the chain. */
static void look_for_rebound(March *m, double h)
{
    const End *s = &m->start, *f = &m->finish;
    if (m->r->weight > 0 && m->r->rebound == 0 && s->d[0] >= 0 && f->d[0] < 0 && f->v[0] < 0)
        m->r->rebound = f->v[0] - m->inverse[0] * m->r->weight * h * (1 - root_of(s->d[0], h * s->w[0], f->d[0], h * f->w[0]));
}

/* Sets the time at which the wave arrives at the last contact, and the end of the run if that depends on it. */
static void look_for_arrival(March *m)
{
    const long last = (long)m->r->contacts - 1;
    if (m->r->arrival >= 0 || m->n <= last || !(m->best[last] > 0)) return;
    if (m->start.f[last] >= m->r->passed * m->best[last]) return;
    /* a wall that oscillates ahead of the wave: that has not passed the contact before */
    if (last && m->start.f[last - 1] >= m->r->passed * m->best[last - 1]) return;
    if (m->best[last] < m->r->noise * m->still[last] || (last && m->best[last] < m->r->wave * m->best[last - 1])) return;
    m->r->arrival = m->since[last];
    if (m->r->until == INFINITY) m->r->until = larger(m->r->duration + 3 * m->r->arrival, m->r->time);
}
