/* Elastic-plastic contacts: the algorithm of mixed_chain_modes.py, which explains it. The mode of a contact is fixed
   within a step, so that its force is smooth. */

#define MOST_CHANGES 4 /* of the mode of a contact at one time */
#define BEGINNING 2 /* times the speed at which the strength grows: a contact outrun below was outrun at that speed */
#define DEGREE 4 /* of a piece of the curves, of which there are four */
#define PIECE (4 * (DEGREE + 1))

enum { CAPPED, ELASTIC, MIDDLE, FULL, PLATEAU };

/* Increase of the strength by a closing velocity, in pieces of the curves. */
static inline double faster_by(const March *m, long j, double w)
{
    const double times = w * m->plastic.slowness[j];
    return m->plastic.rate[j] != 0 && times > 1 ? m->plastic.rate[j] * smaller(log(times), m->r->quickest) : 0;
}

/* Force of loading in a mode, and its time derivative from overlap, closing velocity and acceleration. */
static inline double load(const March *m, long j, int mode, double d, double w, double a, double faster, double *rate)
{
    const Plastic *p = &m->plastic;
    const double e = d * p->curvature[j], stretch = w * p->curvature[j], share = faster - (double)(long)faster;
    const double *piece;
    double value[2], change[2] = {0, 0}, grows, logarithm;
    int i, k;
    *rate = 0;
    if (mode == PLATEAU) return p->force[j];
    if (mode == CAPPED) return p->virgin[j] * (d * sqrt(d));
    if (faster == 0 && mode == FULL) {
        *rate = w * p->slope[j];
        return p->level[j] + p->slope[j] * d;
    }
    if (faster == 0) {
        logarithm = log(d);
        *rate = w * (p->a[j] + p->b[j] * (1 + logarithm));
        return d * (p->a[j] + p->b[j] * logarithm);
    }
    piece = p->pieces + PIECE * ((long)p->curves[j] + (long)faster) + (mode == FULL ? 2 : 0);
    for (i = 0; i < 2; i++) value[i] = piece[4 * DEGREE + i];
    for (k = DEGREE - 1; k >= 0; k--)
        for (i = 0; i < 2; i++) {
            change[i] = change[i] * share + value[i];
            value[i] = value[i] * share + piece[4 * k + i];
        }
    grows = p->rate[j] * a / w;
    if (mode == FULL) {
        *rate = p->unit[j] * (value[1] * stretch + (change[0] + change[1] * e) * grows);
        return p->unit[j] * (value[0] + value[1] * e);
    }
    logarithm = log(e);
    *rate = p->unit[j] * ((value[0] + value[1] * (1 + logarithm)) * stretch + e * (change[0] + change[1] * logarithm) * grows);
    return p->unit[j] * (e * (value[0] + value[1] * logarithm));
}

/* The part of the loading curve at an overlap; `force`, `rate`: those of a contact with rate. */
static int region(const March *m, long j, double d, double w, double a, double *force, double *rate)
{
    const Plastic *p = &m->plastic;
    const double faster = faster_by(m, j, w), growth = 1 + faster / m->r->finer;
    int mode = d > p->full[j] + p->wider[j] * faster ? FULL : MIDDLE;
    if (!(d > p->cap[j])) mode = CAPPED;
    if (p->rate[j] == 0) return mode;
    *force = load(m, j, mode, d, w, a, faster, rate);
    if (mode == MIDDLE) {
        const double hertz = p->virgin[j] * (d * sqrt(d));
        if (d > p->first[j] * (growth * growth) && *force < hertz) return MIDDLE;
        *force = hertz;
        return CAPPED;
    }
    return mode;
}

/* Time derivative of the force of a contact that flows. */
static double flow_rate(const March *m, long j, double d, double w, double a)
{
    double rate;
    load(m, j, (int)m->plastic.mode[j], d, w, a, faster_by(m, j, w), &rate);
    return rate;
}

/* Overlap above the residual one where unloading from a force begins; see elastic_plastic.py. */
static double depth_of(const Plastic *p, long j, double force)
{
    return force * sqrt(p->softness[j] / (2 * force + p->yield[j]));
}

/* Mode of a contact at an overlap, closing velocity and acceleration. */
static int next_mode(const March *m, long j, double d, double w, double a)
{
    const Plastic *p = &m->plastic;
    const int mode = (int)p->mode[j];
    int next;
    double force = 0, slope = 0;
    if (mode == CAPPED && !(d > p->first[j])) return mode;
    if (mode == ELASTIC && !(w > 0)) return ELASTIC;
    if (mode != ELASTIC && w < 0) return ELASTIC;
    if (mode == ELASTIC) d += p->left[j];
    next = region(m, j, d, w, a, &force, &slope);
    if (p->rate[j] == 0) return next;
    if ((mode == ELASTIC || mode == PLATEAU) && !(force > p->force[j])) return PLATEAU;
    if (mode == ELASTIC) {
        const double depth = d - p->left[j];
        if (m->k[j] * (depth * sqrt(depth)) < force) return ELASTIC;
    }
    if (next == CAPPED) return next;
    force = 2 * larger(force, p->force[j]) + p->yield[j];
    /* faster loading outruns the stiffer unloading, which has the slope 1.5 sqrt(force/softness) w */
    if (slope > 0 && slope * slope * p->softness[j] > 2.25 * force * (w * w)) return ELASTIC;
    return mode != PLATEAU && slope < 0 ? PLATEAU : next;
}

/* Energy that a contact releases, or has taken up since zero overlap in its mode; zero where that is integrated. */
static double stored(const March *m, long j, double d)
{
    const Plastic *p = &m->plastic;
    const int mode = (int)p->mode[j];
    const double depth = mode == ELASTIC ? d - p->left[j] : d;
    if (mode <= ELASTIC) return depth > 0 ? 0.4 * m->k[j] * (depth * depth * sqrt(depth)) : 0;
    if (mode == PLATEAU) return p->force[j] * d;
    if (p->rate[j] != 0) return 0;
    return mode == MIDDLE ? 0.5 * d * d * (p->a[j] + p->b[j] * (log(d) - 0.5)) : d * (p->level[j] + 0.5 * p->slope[j] * d);
}

/* Energy that a contact releases from an overlap and force on. */
static double released(const March *m, long j, double d, double force)
{
    const Plastic *p = &m->plastic;
    const int flows = p->mode[j] > ELASTIC || (p->mode[j] == CAPPED && d > p->first[j]);
    return 0.4 * force * (flows ? depth_of(p, j, force) : larger(d, 0));
}

/* Sets what the kernel needs of the mode of a contact, of which k is known. */
static void set_constants(March *m, long j)
{
    Plastic *p = &m->plastic;
    const int mode = (int)p->mode[j], smooth = mode <= ELASTIC, rate = p->rate[j] != 0;
    const double start = p->start[j] - (mode == ELASTIC ? p->left[j] : 0), level = mode == PLATEAU ? p->force[j] : p->level[j];
    m->base[j] = larger(start, 0);
    m->gap[j] = smaller(start, 0);
    m->root[j] = sqrt(m->base[j]);
    p->curved[j] = mode == MIDDLE || (mode == FULL && rate) ? 1 + rate : 0;
    p->tangent[j] = mode == FULL && !rate ? p->slope[j] : 0;
    p->offset[j] = (smooth ? m->k[j] * (m->base[j] * m->root[j]) : level + p->tangent[j] * m->base[j]) - m->still[j];
    if (p->curved[j] > 0) p->offset[j] = 0;
    /* of the change of the overlap, which is exact ahead of a wave */
    p->limit[j] = smooth ? (mode == CAPPED ? p->first[j] : p->reached[j] - p->left[j]) - m->base[j] : -m->r->largest;
}

/* Force of the plateau that begins where unloading or Hertz's law meets the falling curve of loading, or this falls: the
   step has ended slightly later. */
static double corner(const March *m, long j, double d, double a)
{
    const Plastic *p = &m->plastic;
    const double w = m->start.w[j], force = m->start.f[j] + m->still[j];
    const int mode = (int)p->mode[j];
    double loading, ignored;
    if (mode > ELASTIC) return larger(p->force[j], force);
    region(m, j, d, w, a, &loading, &ignored);
    if (mode == ELASTIC && !(loading > p->force[j])) return p->force[j];
    return force - m->start.slope[j] * (m->r->time - p->ended[j]);
}

/* Changes the mode of a contact at the beginning of a step. */
static void change_mode(March *m, long j, int next, double a)
{
    Plastic *p = &m->plastic;
    const int mode = (int)p->mode[j];
    const double w = m->start.w[j];
    double d = m->start.d[j] + (mode == ELASTIC ? p->left[j] : 0), force = m->start.f[j] + m->still[j], depth, ignored;
    m->lost[j] += stored(m, j, d);
    if (next == ELASTIC) {
        /* the contact has turned just before */
        p->reached[j] = d + (a < 0 ? smaller(0.5 * w * w / -a, m->r->nudge * d) : 0);
        if (mode != PLATEAU && p->curved[j] > 1 && w > 0 && w * p->slowness[j] < BEGINNING)
            force = smaller(force, load(m, j, mode, d, w, a, 0, &ignored)); /* outrun where the strength began to grow */
        if (mode != PLATEAU) p->force[j] = p->curved[j] > 1 ? larger(p->force[j], force) : load(m, j, mode, p->reached[j], w, a, 0, &ignored);
        depth = depth_of(p, j, p->force[j]);
        m->k[j] = p->force[j] / (depth * sqrt(depth));
        p->left[j] = p->reached[j] - depth;
    } else {
        p->force[j] = next == PLATEAU ? corner(m, j, d, a) : larger(p->force[j], force);
        if (next == PLATEAU && mode <= ELASTIC) raise_best(m, j, p->force[j] - m->still[j], p->ended[j]);
        m->k[j] = next == CAPPED ? p->virgin[j] : 0;
    }
    p->mode[j] = next;
    set_constants(m, j);
    m->lost[j] -= stored(m, j, d);
}

/* Changes the modes that end at the beginning of a step; whether there are any. */
static int change_modes(March *m)
{
    const long contacts = (long)m->r->contacts;
    int changed = 0;
    long j;
    for (j = 0; j < m->n && j < contacts; j++)
        if (m->start.u[j] > m->plastic.limit[j]) {
            const double a = closing(m, &m->start, j, m->r->time);
            const int next = next_mode(m, j, m->start.d[j], m->start.w[j], a);
            if (next != (int)m->plastic.mode[j]) {
                change_mode(m, j, next, a);
                changed = 1;
            } else if (m->plastic.curved[j] > 1) m->plastic.force[j] = larger(m->plastic.force[j], m->start.f[j] + m->still[j]);
        }
    return changed;
}

/* Lists the contacts that flow, and chooses the method of the next steps. */
static void list_flows(March *m)
{
    const Plastic *p = &m->plastic;
    int rates = 0;
    long j;
    m->flows = 0;
    for (j = 0; m->yields && j < (long)m->r->contacts; j++)
        if (p->mode[j] > ELASTIC) {
            m->flowing[m->flows++] = (double)j;
            rates = rates || p->curved[j] > 1;
        }
    m->method = m->damped || rates || !m->swift.stages ? &m->careful : &m->swift;
}

/* Force of a contact that flows along a curve, less the static one: ahead of a wave their difference is rounding error. */
static double flow_force(const March *m, long j, double u, double d, double w)
{
    const Plastic *p = &m->plastic;
    const int mode = (int)p->mode[j];
    const double faster = faster_by(m, j, w), base = m->base[j];
    double ignored;
    if (mode == MIDDLE && faster == 0 && base > p->cap[j] && base <= p->full[j])
        return u * (p->a[j] + p->b[j] * log(d)) + base * p->b[j] * log1p(u / base);
    return load(m, j, mode, d, w, 0, faster, &ignored) - m->still[j];
}

/* Replaces the forces of the contacts that flow along a curve between low and high, and the accelerations of their bodies. */
static void flow(March *m, int whole, const double *x, const double *v, long low, long high, double weight, End *to)
{
    const Plastic *p = &m->plastic;
    long i, j;
    for (i = 0; i < m->flows; i++) {
        double u, w;
        j = (long)m->flowing[i];
        if (p->curved[j] == 0 || j < low || j >= high) continue;
        u = (x[j] - x[j + 1]) + m->gap[j];
        w = v[j] - v[j + 1];
        to->f[j] = flow_force(m, j, u, u + m->base[j], w);
        if (whole) to->raw[j] = to->f[j] + m->still[j];
        if (p->curved[j] > 1) {
            m->shares[j] += weight * ((to->f[j] + m->still[j]) * w);
            if (whole) to->power[j] = (to->f[j] + m->still[j]) * w;
        }
    }
    for (i = 0; i < m->flows; i++) {
        j = (long)m->flowing[i];
        if (j >= low && j < high) to->a[j] = m->mobile[j] * (to->f[j - 1] - to->f[j]);
        if (j >= low && j + 1 < high) to->a[j + 1] = m->mobile[j + 1] * (to->f[j] - to->f[j + 1]);
    }
}

/* Sets the time derivatives of the forces of the contacts that flow between low and high. */
static void set_flow_rates(const March *m, End *end, long low, long high)
{
    long i;
    for (i = 0; i < m->flows; i++) {
        const long j = (long)m->flowing[i];
        if (j >= low && j < high) end->slope[j] = flow_rate(m, j, end->d[j], end->w[j], end->a[j] - end->a[j + 1]);
    }
}

/* First place between low and high where a polynomial with these coefficients of Bernstein is negative; 2 if nowhere. */
static double first_negative(const double *b, int degree, double low, double high, double near)
{
    double left[6], right[6];
    const double middle = 0.5 * (low + high);
    int i, k, positive = 1;
    for (i = 0; i <= degree; i++) positive = positive && b[i] >= 0;
    if (positive) return 2;
    if (high - low < near) return b[0] > 0 && b[degree] < 0 ? low + (high - low) * b[0] / (b[0] - b[degree]) : low;
    memcpy(right, b, sizeof *b * (size_t)(degree + 1));
    for (i = 0; i <= degree; i++) {
        left[i] = right[0];
        for (k = 0; k < degree - i; k++) right[k] = 0.5 * (right[k] + right[k + 1]);
    }
    {
        const double at = first_negative(left, degree, low, middle, near);
        return at <= 1 ? at : first_negative(right, degree, middle, high, near);
    }
}

/* Mode of contact j at a fraction s of the step. */
static int mode_at(const March *m, double h, long j, const double c[6], double s)
{
    double d, w, a;
    motion_at(c, s, &d, &w, &a);
    return next_mode(m, j, d + m->base[j], w / h, a / (h * h));
}

/* Where between low and high the mode of a contact with rate ends; 2 if it does not. */
static double mode_ends(const March *m, double h, long j, const double c[6], double low, double high)
{
    const int mode = (int)m->plastic.mode[j];
    const double begin = low, part = (high - low) / m->r->parts;
    double before = low, at;
    int i;
    for (i = 1; i <= (int)m->r->parts; i++, before = at) {
        at = begin + i * part;
        if (mode_at(m, h, j, c, at) == mode) continue;
        while (at - before > m->r->near) {
            const double middle = 0.5 * (before + at);
            if (mode_at(m, h, j, c, middle) == mode) before = middle; else at = middle;
        }
        return at;
    }
    return 2;
}

/* Place up to which a contact that closes at `low` closes. */
static double closes_until(const March *m, const double c[6], double low)
{
    double d, w, a, high = 1;
    motion_at(c, high, &d, &w, &a);
    if (w > 0) return high;
    while (high - low > m->r->near) {
        const double middle = 0.5 * (low + high);
        motion_at(c, middle, &d, &w, &a);
        if (w > 0) low = middle; else high = middle;
    }
    return low;
}

/* Fraction of the step at which the mode of contact j ends; 2 if it does not. `c`: the polynomial of the overlap. */
static double leaves(const March *m, double h, long j, const double c[6])
{
    const Plastic *p = &m->plastic;
    const int mode = (int)p->mode[j], rate = p->rate[j] != 0;
    const double end = mode == ELASTIC ? p->limit[j] : (mode == CAPPED ? p->cap[j] : p->full[j]) - m->base[j];
    const double b[6] = {c[0], c[0] + c[1] / 5, c[0] + (4 * c[1] + c[2]) / 10, c[0] + (6 * c[1] + 3 * c[2] + c[3]) / 10,
                         c[0] + (4 * c[1] + 3 * c[2] + 2 * c[3] + c[4]) / 5, c[0] + c[1] + c[2] + c[3] + c[4] + c[5]};
    double rest[6], at = 2, passes = 2, d, w, a;
    int i;
    if (mode != ELASTIC) {
        for (i = 0; i < 5; i++) rest[i] = b[i + 1] - b[i];
        at = first_negative(rest, 4, 0, 1, m->r->near);
        if (mode == CAPPED && at <= 1) {
            motion_at(c, at, &d, &w, &a);
            if (!(d > p->limit[j])) at = 2;
        }
    }
    if (mode == ELASTIC || (!rate && mode != FULL)) {
        for (i = 0; i < 6; i++) rest[i] = end - b[i];
        passes = first_negative(rest, 5, 0, 1, m->r->near);
    }
    if (!rate) return smaller(at, passes);
    if (mode == ELASTIC) return passes > 1 ? 2 : mode_ends(m, h, j, c, passes, closes_until(m, c, passes));
    return smaller(mode_ends(m, h, j, c, 0, smaller(at, 1)), at);
}

/* Fraction of the step at which it should end because the mode of contact j ends; `share` if it need not. */
static double mode_end(March *m, double h, long j, double share)
{
    const double force = larger(m->start.f[j], m->finish.f[j]) + m->still[j], most = m->r->kink_share * allowed(m, j);
    double c[6], at, d, w, a, stiffness, late;
    if (!(larger(m->start.u[j], m->finish.u[j]) + 2 * h * larger(fabs(m->start.w[j]), fabs(m->finish.w[j])) > m->plastic.limit[j])) return share;
    overlap_of(m, h, j, c);
    at = leaves(m, h, j, c);
    m->plastic.ended[j] = m->r->time + smaller(at, 1) * h;
    if (at >= share) return share;
    motion_at(c, at, &d, &w, &a);
    stiffness = 1.5 * sqrt((2 * larger(force, m->plastic.yield[j]) + m->plastic.yield[j]) / m->plastic.softness[j]);
    /* the impulse that a step misses this long after the end of a mode */
    late = smaller(sqrt(most / (stiffness * fabs(w / h))), cbrt(most / (stiffness * fabs(a / (h * h)))));
    if (m->plastic.rate[j] != 0) late *= m->r->sharp;
    if ((1 - at) * h <= late || at + 0.5 * late / h >= share) return share;
    return at * h + 0.5 * late > m->r->min_step * larger(m->r->time, m->r->first) ? at + 0.5 * late / h : share;
}
