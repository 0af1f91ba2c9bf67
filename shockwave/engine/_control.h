/* The step controller: size, cuts at kinks, and acceptance of a step. */

/* Impulse that a step misses if no force acts in a fraction of it. */
static double kink_error(const March *m, double h, double force, double idle)
{
    return m->r->kink * h * force * smaller(1, idle / larger(1 - idle, 1e-300));
}

/* Shortens `size` to end where contact j, which is `near`, is predicted to close or, without damping, to open, and m->r->size
   after it has closed: the force is a power of the time. */
static double predict(March *m, long j, double h, double size)
{
    const double d = m->start.d[j], w = m->start.w[j], at = -d / w / h, p = m->exponents[j] + 1, q = m->powers[j] + 1;
    double most = m->r->size;
    if (at > m->r->soon && (d < 0 || (m->c[j] == 0 && kink_error(m, h, m->start.raw[j], 1 - at) > m->r->kink_share * allowed(m, j))))
        size = smaller(size, at * h);
    if (w > 0 && fabs(d) < m->r->soon * h * w) {
        most = smaller(most, pow(allowed(m, j) / (m->r->elastic * m->k[j] * pow(w, p - 1)), 1 / p));
        if (q > 1) most = smaller(most, pow(allowed(m, j) / (m->r->viscous * m->c[j] * pow(w, q)), 1 / q));
        m->r->size = most;
    }
    return size;
}

/* Size and end of the next step. */
static double next_size(March *m, double *end)
{
    const double stop = m->stop < m->stop_count ? smaller(m->stops[m->stop], m->r->until) : m->r->until;
    const double left = stop - m->r->time, h = m->r->size;
    double size = m->driven || !m->kinks ? m->r->longest : INFINITY;
    long j;
    for (j = 0; m->kinks && (j = m->kernel.near(m, h, j)) < m->n; j++) size = predict(m, j, h, size);
    for (j = 0; j < m->flows; j++) size = smaller(size, turns_after(m, (long)m->flowing[j]));
    m->at_stop = smaller(size, m->r->size) >= left;
    size = m->at_stop ? left : smaller(smaller(size, m->r->size), left / 2); /* avoids a very short last step */
    *end = m->at_stop ? stop : m->r->time + size;
    return size;
}

/* Fraction of the step at which it should end because contact j closes, opens or is cut off; `share` if it need not. */
static double kink_at(const March *m, double h, long j, double share)
{
    const End *s = &m->start, *f = &m->finish;
    const double d0 = s->d[j], d1 = f->d[j], raw0 = s->raw[j], raw1 = f->raw[j], w = larger(s->w[j], f->w[j]);
    const double change = raw1 - raw0, rate = raw0 > 0 ? h * s->slope[j] : change;
    /* without damping the force has the sign of the overlap, but for rounding under a static force */
    const int damped = m->c[j] != 0, acts = (m->jumps ? m->on[j] != 0 : d0 >= 0) && (!damped || raw0 >= 0);
    double at, error;
    if (acts == (d1 >= 0 && (!damped || raw1 >= 0))) return share;
    at = (d0 < 0) != (d1 < 0) ? root_of(d0, h * s->w[j], d1, h * f->w[j]) : 0.5;
    if (damped && d0 >= 0 && raw0 * raw1 < 0 && (d1 >= 0 || m->powers[j] == 0))
        at = smaller(d1 >= 0 ? 1 : at, root_of(raw0, rate, raw1, 2 * change - rate));
    else if (damped && acts) at *= 0.5; /* the force ends before the contact opens */
    error = kink_error(m, h, larger(raw0, raw1), acts ? 1 - at : at);
    if (!acts && m->jumps && m->powers[j] == 0 && d0 < 0) {
        error += m->c[j] * w * (1 - at) * h;
        if (w > 0) at += 0.5 * late(m, f->x, f->w[j], j) / (h * w);
    }
    if (error > m->r->kink_share * allowed(m, j) && at * h > m->r->min_step * larger(m->r->time, m->r->first)) return smaller(share, at);
    return share;
}

/* Fraction of the step at which it should end because a contact closes, opens or is cut off; 1 if it need not. */
static double kink(March *m, double h)
{
    const long contacts = contacts_of(m);
    double share = 1;
    long j;
    for (j = 0; (j = m->kernel.changed(m, j)) < m->n; j++) share = kink_at(m, h, j, share);
    for (j = 0; m->yields && (j = m->kernel.yielding(m, h, j)) < contacts; j++) share = mode_end(m, h, j, share);
    return share;
}

/* Widens the window: bodies up to n move. */
static void widen(March *m, long n)
{
    for (; m->n < n; m->n++) {
        m->mobile[m->n] = m->inverse[m->n];
        m->reach_w[m->n] = m->far_w[m->n];
        m->reach_u[m->n] = m->far_u[m->n];
    }
    m->padded = (n + BLOCK) / BLOCK * BLOCK; /* at least one body at rest */
}

/* Begins the next step at m->start, whose forces are known unless they have `changed`; contacts with a dashpot close here.
   The motion is over if no contact force acts and none can follow: beyond the last contact a body flies off freely. */
static void begin(March *m, int changed)
{
    const double *x = m->start.x, *v = m->start.v;
    const long contacts = contacts_of(m);
    long j;
    int turn;
    for (j = 0; m->jumps && j < m->n; j++) {
        const double d = (x[j] - x[j + 1]) + m->gap[j] + m->base[j], w = v[j] - v[j + 1], before = m->on[j];
        m->on[j] = d >= 0 || (m->powers[j] == 0 && w > 0 && d >= -late(m, x, w, j));
        changed = changed || m->on[j] != before;
    }
    if (changed) m->kernel.evaluate(m, &m->start, 0, m->padded, m->r->time);
    for (turn = 0; m->yields && turn < MOST_CHANGES && change_modes(m); turn++) {
        list_flows(m);
        m->kernel.evaluate(m, &m->start, 0, m->padded, m->r->time);
    }
    for (j = 0; !m->record && (j = m->kernel.above(m, j)) < contacts; j++) raise_best(m, j, m->start.f[j], m->r->time);
    m->over = m->r->until == INFINITY && m->r->time >= m->r->duration;
    for (j = 0; m->over && j < contacts; j++) m->over = m->start.f[j] == 0 && !(m->start.w[j] > 0);
}

/* Processes an accepted step and begins the next one. */
static void accept(March *m, double h, double end)
{
    const End s = m->start, f = m->finish;
    const long n = m->n, padded = m->padded, last = n > m->r->margin ? n - (long)m->r->margin : 0;
    add_losses(m, h);
    if (m->driven) add_work(m, h, end);
    if (m->record) log_maxima(m, end - m->r->time); else find_peaks(m, h);
    find_extremes(m, h);
    store_samples(m, end);
    look_for_rebound(m, h);
    m->r->time = end;
    m->r->steps++;
    if (m->stop < m->stop_count && end == m->stops[m->stop]) m->stop++;
    if (m->driven) free_path(&m->path, end, &m->free[0], &m->free[1]);
    m->driven = m->driven && end < m->r->duration;
    if (n < m->bodies && (fabs(f.x[last]) > m->r->at_rest || fabs(f.v[last]) > m->r->at_rest))
        widen(m, (long)smaller((double)n + m->r->growth, (double)m->bodies));
    if (!m->record) m->kernel.raise_scales(m, padded);
    m->start = f;
    m->finish = s;
    begin(m, n < m->n);
    if (m->record) keep_state(m); else look_for_arrival(m);
}

/* Checks from time to time for signals and for the end of the time limit; whether to go on. */
static int go_on(March *m)
{
    if (m->effort < m->asked) return 1;
    m->asked = m->effort + m->r->interval;
    return !interrupted(m->expired, &m->thread);
}

/* Sets the size of the next step, from the error over the tolerance; whether this one, of size h, is accepted. `share` is the
   fraction at which it should end. */
static int resize(March *m, double h, double error, double share)
{
    Run *r = m->r;
    const double factor = r->safety * pow(larger(error, 1e-12), -1.0 / (m->method.order + 1));
    /* a step that was shortened to end here does not shorten the next one */
    const double kept = m->at_stop || h < r->size ? r->size : 0;
    if (share < 1) {
        if (!m->cuts++) m->held = error <= 1 ? r->size : h * larger(factor, r->min_factor);
        r->size = h * share;
        return 0;
    }
    if (!(error <= 1)) {
        r->size = h * (factor > r->min_factor && factor < 1 ? factor : r->min_factor);
        m->rejected = 1;
        m->held = 0;
        return 0;
    }
    r->size = larger(larger(h * smaller(factor, m->rejected ? 1 : r->max_factor), m->held), kept);
    m->held = m->rejected = m->cuts = 0;
    return 1;
}

/* Integrates to the end; returns the status. */
static int integrate(March *m)
{
    const Run *r = m->r;
    int status = RUNNING;
    begin(m, 1);
    store_samples(m, 0);
    if (m->record) keep_state(m);
    while (status == RUNNING && go_on(m)) {
        double end, h, error, share = 1;
        if (!has_room(m)) return PAUSED;
        h = next_size(m, &end);
        m->kernel.attempt(m, h, end, 0, m->padded, &m->finish);
        error = m->kernel.error(m, h);
        if (m->kinks) m->kernel.complete(m, &m->finish, 0, m->padded, end);
        m->effort += (double)m->method.stages * ((double)m->n + r->step_work);
        if (m->kinks && error < r->hopeless && m->cuts < r->most_cuts) share = kink(m, h);
        if (resize(m, h, error, share)) {
            accept(m, h, end);
            if (r->time >= r->until || (r->until == INFINITY && m->over)) status = DONE;
        } else if (share == 1 && r->size < larger(r->min_step * r->time, r->min_first * r->first)) status = FAILED;
        if (status == RUNNING && m->effort > r->most_work) status = TOO_LONG;
    }
    return status;
}
