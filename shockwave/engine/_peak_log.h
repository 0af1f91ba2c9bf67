/* Log of the maxima of the contact forces, and states at the ends of the steps; see chain_record.py. */

/* see peak_log.py */
#define FLOOR 1e-4
#define LOSS 6e-5
#define NEGLIGIBLE 0.1
#define SAME_WAVE 0.5
#define CORRECTIONS 4
#define NEAR 1e-5

/* Overlap of contact j and its first three derivatives at one end of a step, without the applied force. */
static void overlap_jet(const March *m, const End *end, long j, double jet[4])
{
    double rate[3];
    long i;
    for (i = 0; i < 3; i++) {
        const long k = j + i - 1;
        rate[i] = k < 0 ? 0 : end->stiffness[k] * (end->v[k] - end->v[k + 1]);
    }
    jet[0] = end->d[j];
    jet[1] = end->v[j] - end->v[j + 1];
    jet[2] = end->a[j] - end->a[j + 1];
    jet[3] = m->inverse[j] * (rate[0] - rate[1]) - m->inverse[j + 1] * (rate[1] - rate[2]);
}

/* Fraction of a step of size h at which the overlap is largest, and that overlap, from the polynomial. */
static double top(const double *begin, const double *end, double h, double *overlap)
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

/* Time at which the overlap is largest, near `time`, and that overlap, by repeated steps: Newton's method with bisections. */
static double locate_top(March *m, long j, double h, double time, double *overlap)
{
    double low = m->r->time, high = low + h, w = 0, slowing = 0, next = time;
    int turn;
    for (turn = 0; turn < m->r->most_turns; turn++) {
        attempt_near(m, time - m->r->time, time, j, j);
        w = m->trial.v[j] - m->trial.v[j + 1];
        slowing = -closing(m, &m->trial, j, time);
        next = slowing > 0 ? time + w / slowing : INFINITY;
        if (fabs(next - time) < NEAR) break;
        if (w > 0) low = time; else high = time;
        if (!(next > low && next < high)) next = (low + high) / 2;
        if (turn + 1 < m->r->most_turns) time = next;
    }
    *overlap = m->trial.d[j] + (next - time) * (w - (next - time) * slowing / 2);
    return next;
}

/* Force at contact j, of spheres or of another power of the overlap. */
static double force_at(const March *m, long j, double overlap)
{
    return overlap > 0 ? m->k[j] * power_of(overlap, m->exponents[j]) : 0;
}

/* Adds a maximum to the log, with the last peak of the same wave at the preceding contact. */
static void log_peak(March *m, long j, double time, double force)
{
    Peak *const peaks = m->peaks, *const peak = peaks + (long)m->record->peaks;
    long long behind = j ? m->last_peak[j - 1] : -1;
    while (behind >= 0 && !(peaks[behind].force > SAME_WAVE * force && peaks[behind].time < time)) behind = peaks[behind].previous;
    *peak = (Peak){j, behind, m->last_peak[j], time, force};
    m->last_peak[j] = (long long)m->record->peaks++;
}

/* Logs the maximum of the force at contact j within a step, if there is one above the noise. */
static void log_maximum(March *m, double h, long j)
{
    const double slowing = -(m->exponents[j] - 1) / (2 * m->exponents[j]);
    double begin[4], end[4], time, overlap, force;
    overlap_jet(m, &m->start, j, begin);
    overlap_jet(m, &m->finish, j, end);
    if (!(begin[1] > 0 && end[1] <= 0)) return;
    force = force_at(m, j, larger(begin[0], end[0]));
    m->record->strongest = larger(force, m->record->strongest);
    if (!(force > FLOOR * m->record->strongest)) return;
    time = m->r->time + top(begin, end, h, &overlap) * h;
    force = force_at(m, j, overlap);
    /* the shock acts on a body of the first contact, which the polynomial does not include */
    if (j == 0 || LOSS * force * pow(h / pow(larger(force, 1e-30), slowing), 8) > NEGLIGIBLE * m->r->tolerance)
        time = locate_top(m, j, h, time, &overlap);
    log_peak(m, j, time, force_at(m, j, overlap));
}

/* Logs the maxima within a step. */
static void log_maxima(March *m, double h)
{
    const long contacts = contacts_of(m);
    long j;
    for (j = 0; (j = m->kernel.passing(m, j)) < contacts; j++) log_maximum(m, h, j);
}

/* Keeps the state at the beginning of a step, if it is wanted. */
static void keep_state(March *m)
{
    double *row = m->states + (2 * m->bodies + 1) * (long)m->record->kept;
    if (!m->most_states || m->r->time < m->record->since) return;
    *row++ = m->r->time;
    memcpy(row, m->start.x, (size_t)m->bodies * sizeof *row);
    memcpy(row + m->bodies, m->start.v, (size_t)m->bodies * sizeof *row);
    m->record->kept++;
}

/* Whether the record has room for the next step, and the chain for the front. */
static int has_room(const March *m)
{
    const Record *const record = m->record;
    return !record || ((!m->most_states || record->kept < (double)m->most_states) && record->peaks + (double)m->n <= (double)m->most_peaks
        && (!record->continues || m->n < m->bodies));
}
