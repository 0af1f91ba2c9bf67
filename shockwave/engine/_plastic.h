/* Elastic-plastic contacts: the algorithm of chain_modes.py, which explains it. The mode of a contact is fixed
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
    return m->plastic.rate[j] != 0 && times > 1 ? m->plastic.rate[j] * smaller(log(times), m->r->fastest) : 0;
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

/* The part of the loading curve at an overlap. Of a contact with rate also the force, that at the end `of` a step if it flows
   in that part, its time derivative, and its excess over Hertz's. */
static int region(const March *m, long j, double d, double w, double a, const End *of, double *force, double *rate, double *excess)
{
    const Plastic *p = &m->plastic;
    const double faster = d > p->cap[j] ? faster_by(m, j, w) : 0, growth = 1 + faster / m->r->finer;
    const int mode = !(d > p->cap[j]) ? CAPPED : d > p->full[j] + p->wider[j] * faster ? FULL : MIDDLE;
    double hertz;
    *excess = 0;
    if (mode == CAPPED) *force = load(m, j, mode, d, w, a, 0, rate);
    if (p->rate[j] == 0 || mode == CAPPED) return mode;
    *force = of && mode == (int)p->mode[j] ? of->f[j] + m->still[j] : load(m, j, mode, d, w, a, faster, rate);
    if (of && mode == (int)p->mode[j]) *rate = of->slope[j];
    hertz = p->virgin[j] * (d * sqrt(d));
    *excess = *force - hertz;
    if (mode == FULL || (d > p->first[j] * (growth * growth) && *force < hertz)) return mode;
    *force = hertz;
    return CAPPED;
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

/* Mode of a contact at an overlap, closing velocity and acceleration, or at the end `of` a step; `margin` becomes
   negative where the mode ends. */
static int next_mode(const March *m, long j, double d, double w, double a, const End *of, double *margin)
{
    const Plastic *p = &m->plastic;
    const int mode = (int)p->mode[j];
    int next;
    double force = 0, slope = 0, excess;
    *margin = 0;
    if (mode == CAPPED && !(d > p->first[j])) return mode;
    if (mode == ELASTIC && !(w > 0)) return ELASTIC;
    if (mode != ELASTIC && w < 0) return ELASTIC;
    if (mode == ELASTIC) d += p->left[j];
    next = region(m, j, d, w, a, of, &force, &slope, &excess);
    if (p->rate[j] == 0) return next;
    *margin = mode == CAPPED ? excess : mode == PLATEAU ? p->force[j] - force : slope;
    if ((mode == ELASTIC || mode == PLATEAU) && !(force > p->force[j])) return PLATEAU;
    if (mode == ELASTIC) {
        const double depth = d - p->left[j];
        *margin = force - m->k[j] * (depth * sqrt(depth));
        if (*margin > 0) return ELASTIC;
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
    region(m, j, d, w, a, NULL, &loading, &ignored, &ignored);
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
    const long contacts = contacts_of(m);
    double ignored;
    int changed = 0;
    long j;
    for (j = 0; (j = m->kernel.yielding(m, 0, j)) < contacts; j++) {
        if (!(m->start.u[j] > m->plastic.limit[j])) continue;
        const double a = closing(m, &m->start, j, m->r->time);
        const int next = next_mode(m, j, m->start.d[j], m->start.w[j], a, &m->start, &ignored);
        if (next != (int)m->plastic.mode[j]) {
            change_mode(m, j, next, a);
            changed = 1;
        } else if (m->plastic.curved[j] > 1) m->plastic.force[j] = larger(m->plastic.force[j], m->start.f[j] + m->still[j]);
        else if (next == ELASTIC && !(m->start.w[j] > 0)) m->plastic.limit[j] = m->start.u[j]; /* turned at the limit */
    }
    return changed;
}

/* Lists the contacts that flow, and bounds the blocks with their bodies. */
static void list_flows(March *m)
{
    long j;
    m->flows = 0;
    for (j = 0; m->yields && j < (long)m->r->contacts; j++)
        if (m->plastic.mode[j] > ELASTIC) m->flowing[m->flows++] = (double)j;
    m->first_flow = m->flows ? (long)m->flowing[0] / BLOCK * BLOCK : 0;
    m->after_flow = m->flows ? ((long)m->flowing[m->flows - 1] + 1) / BLOCK * BLOCK + BLOCK : 0;
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
static void flow(March *m, int whole, const double *x, const double *v, long low, long high, int stage, End *to)
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
        if (stage > 0) m->felt[stage][j] = to->f[j];
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

/* Overlap, as change, at which unloading, Hertz's law or the middle of the curve ends. */
static double greatest_overlap(const March *m, long j)
{
    const Plastic *p = &m->plastic;
    const int mode = (int)p->mode[j];
    return mode == ELASTIC ? p->limit[j] : (mode == CAPPED ? p->cap[j] : p->full[j]) - m->base[j];
}

/* Courses within a step: of what is left to that overlap, of the closing velocity, and of a number that is positive while
   contact j keeps its mode, up to where it turns. */
static double left_at(const March *m, double h, long j, const double c[6], double s)
{
    double d, w, a;
    (void)h;
    motion_at(c, s, &d, &w, &a);
    return greatest_overlap(m, j) - d;
}

static double closing_at(const March *m, double h, long j, const double c[6], double s)
{
    double d, w, a;
    (void)m, (void)h, (void)j;
    motion_at(c, s, &d, &w, &a);
    return w;
}

static double keeps_mode(const March *m, double h, long j, const double c[6], double s)
{
    double d, w, a, margin;
    motion_at(c, s, &d, &w, &a);
    if (next_mode(m, j, d + m->base[j], larger(w / h, 0), a / (h * h), s == 1 ? &m->finish : NULL, &margin) == (int)m->plastic.mode[j])
        return margin > 0 ? margin : 1;
    return margin < 0 ? margin : -1;
}

/* Adds the work on contacts that flow with rate, from the forces at the stages; the velocities there are less accurate. */
static void add_flow(March *m, double h)
{
    long i, j;
    int k;
    for (i = 0; i < m->flows; i++) {
        double c[6];
        j = (long)m->flowing[i];
        if (m->plastic.curved[j] < 2) continue;
        overlap_of(m, h, j, c);
        for (k = 0; k < m->method.stages; k++) if (m->method.weights[k] != 0)
            m->lost[j] += m->method.weights[k] * ((k ? m->felt[k][j] : m->start.f[j]) + m->still[j]) * closing_at(m, h, j, c, m->method.nodes[k]);
    }
}

/* Where between low and high a polynomial with these Bernstein coefficients, evaluated by `value`, is first negative; 2 if
   nowhere. */
static double first_negative(Course *value, const March *m, double h, long j, const double c[6], const double *b, int degree,
                             double low, double high)
{
    double left[6], right[6], ignored;
    const double middle = 0.5 * (low + high);
    int i, k, changes = b[0] < 0;
    for (i = 0; i < degree; i++) changes += (b[i] < 0) != (b[i + 1] < 0);
    if (!changes) return 2;
    if (b[0] > 0 && changes == 1) return vanish(value, m, h, j, c, low, high, low + (high - low) * (b[0] / (b[0] - b[degree])), &ignored);
    if (high - low < m->r->near) return low;
    memcpy(right, b, sizeof *b * (size_t)(degree + 1));
    for (i = 0; i <= degree; i++) {
        left[i] = right[0];
        for (k = 0; k < degree - i; k++) right[k] = 0.5 * (right[k] + right[k + 1]);
    }
    {
        const double at = first_negative(value, m, h, j, c, left, degree, low, middle);
        return at <= 1 ? at : first_negative(value, m, h, j, c, right, degree, middle, high);
    }
}

/* Where between low and high the mode of a contact with rate ends; 2 if it does not. */
static double mode_ends(const March *m, double h, long j, const double c[6], double low, double high)
{
    const double r0 = m->start.slope[j], r1 = m->finish.slope[j], about = (m->plastic.ended[j] - m->r->time) / h;
    /* a force of flow that rises steadily falls nowhere within the step */
    const int parts = m->plastic.curved[j] > 1 && r0 < 2 * r1 && r1 < 2 * r0 ? 1 : (int)m->r->parts;
    double before = low, at, ignored;
    int i;
    for (i = 1; i <= parts; i++, before = at) {
        at = low + i * ((high - low) / parts);
        if (keeps_mode(m, h, j, c, at) < 0)
            return vanish(keeps_mode, m, h, j, c, before, at, about > before && about < at ? about : 0.5 * (before + at), &ignored);
    }
    return 2;
}

/* Fraction of the step at which the mode of contact j ends; 2 if it does not. `c`: the polynomial of the overlap. */
static double leaves(const March *m, double h, long j, const double c[6])
{
    const Plastic *p = &m->plastic;
    const int mode = (int)p->mode[j], rate = p->rate[j] != 0;
    const double end = greatest_overlap(m, j);
    const double b[6] = {c[0], c[0] + c[1] / 5, c[0] + (4 * c[1] + c[2]) / 10, c[0] + (6 * c[1] + 3 * c[2] + c[3]) / 10,
                         c[0] + (4 * c[1] + 3 * c[2] + 2 * c[3] + c[4]) / 5, c[0] + c[1] + c[2] + c[3] + c[4] + c[5]};
    double rest[6], at = 2, passes = 2, ignored;
    int i;
    if (mode != ELASTIC) {
        for (i = 0; i < 5; i++) rest[i] = b[i + 1] - b[i];
        at = first_negative(closing_at, m, h, j, c, rest, 4, 0, 1);
        if (mode == CAPPED && at <= 1 && !(end - left_at(m, h, j, c, at) > p->limit[j])) at = 2;
    }
    if (mode == ELASTIC || (!rate && mode != FULL)) {
        for (i = 0; i < 6; i++) rest[i] = end - b[i];
        passes = first_negative(left_at, m, h, j, c, rest, 5, 0, 1);
    }
    if (!rate) return smaller(at, passes);
    if (mode == ELASTIC && passes > 1) return 2;
    if (mode == ELASTIC) return mode_ends(m, h, j, c, passes, closing_at(m, h, j, c, 1) > 0 ? 1 : vanish(closing_at, m, h, j, c, passes, 1, 0.5 * (passes + 1), &ignored));
    for (i = 0; mode == CAPPED && i < 6; i++) passes = b[i] > end ? 0 : passes;
    return mode == CAPPED && passes > 0 ? at : smaller(mode_ends(m, h, j, c, 0, smaller(at, 1)), at);
}

/* Time after the end of a mode in which the impulse that a step misses is small. */
static double delay(const March *m, long j, double force, double w, double a)
{
    const double yield = m->plastic.yield[j], most = m->r->kink_share * allowed(m, j);
    const double stiffness = 1.5 * sqrt((2 * larger(force + m->still[j], yield) + yield) / m->plastic.softness[j]);
    const double late = smaller(sqrt(most / (stiffness * fabs(w))), cbrt(most / (stiffness * fabs(a))));
    return m->plastic.rate[j] != 0 ? late * m->r->sharp : late;
}

/* Fraction of the step at which it should end because the mode of contact j ends; `share` if it need not. */
static double mode_end(March *m, double h, long j, double share)
{
    double c[6], at, d, w, a, late;
    if (!(larger(m->start.u[j], m->finish.u[j]) + 2 * h * larger(fabs(m->start.w[j]), fabs(m->finish.w[j])) > m->plastic.limit[j])) return share;
    overlap_of(m, h, j, c);
    at = leaves(m, h, j, c);
    m->plastic.ended[j] = m->r->time + smaller(at, 1) * h;
    if (at >= share) return share;
    motion_at(c, at, &d, &w, &a);
    late = delay(m, j, larger(m->start.f[j], m->finish.f[j]), w / h, a / (h * h));
    if ((1 - at) * h <= late || at + 0.5 * late / h >= share) return share;
    return at * h + 0.5 * late > m->r->min_step * larger(m->r->time, m->r->first) ? at + 0.5 * late / h : share;
}

/* Size of the next step that ends after contact j turns, whose flow does not depend on the rate. */
static double turns_after(March *m, long j)
{
    const End *s = &m->start;
    const double w = s->w[j], a = closing(m, s, j, m->r->time), before = j ? s->slope[j - 1] : 0;
    const double jerk = m->mobile[j] * (before - s->slope[j]) - m->mobile[j + 1] * (s->slope[j] - s->slope[j + 1]);
    const double last = sqrt(larger(a * a - 2 * jerk * w, 0));
    if (m->plastic.curved[j] > 1 || !(w > 0 && a < 0 && last > 0)) return INFINITY;
    return 2 * w / (last - a) + 0.5 * delay(m, j, s->f[j], 0, last);
}
