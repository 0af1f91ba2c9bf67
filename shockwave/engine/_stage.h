/* Stages of a step, and scans of the contacts, in blocks of WIDTH elements. The sums have the order of chain_run.py. */

/* Calls a function with the number of terms as a constant, so that its loops are unrolled. */
#define CASE(terms, call) case terms: { enum { TERMS = terms }; call; } break;
#define UNROLLED(count, call) \
    switch (count) { CASE(1, call) CASE(2, call) CASE(3, call) CASE(4, call) CASE(5, call) CASE(6, call) CASE(7, call) CASE(8, call) CASE(9, call) \
    default: { const int TERMS = count; call; } }

/* Takes stages and coefficients of a sum out of the structures, of which a store of doubles could change any. */
INLINE void NAME(take_terms)(const March *m, const Terms *t, const int terms, const double **stage, V *a)
{
    int i;
    for (i = 0; i < terms; i++) {
        stage[i] = m->stage[t->at[i]];
        a[i] = NAME(set)(t->a[i]);
    }
}

/* Sum of the terms at element e. */
INLINE V NAME(sum)(const double *const *stage, const V *a, const int terms, long e)
{
    V sum = NAME(load)(stage[0] + e) * a[0];
    int i;
    for (i = 1; i < terms; i++) sum += NAME(load)(stage[i] + e) * a[i];
    return sum;
}

INLINE void NAME(displace_by)(const March *m, const Terms *t, const int terms, const double *x, double time, const double *v,
                              double factor, long low, long high, double *y)
{
    const double *stage[MAX_STAGES];
    V a[MAX_STAGES];
    long e;
    NAME(take_terms)(m, t, terms, stage, a);
    for (e = low; e < high; e += WIDTH)
        NAME(store)(y + e, (NAME(load)(x + e) + time * NAME(load)(v + e)) + factor * NAME(sum)(stage, a, terms, e));
}

/* y = x + time v + factor (sum over the stages); the block behind remains at x. */
INLINE void NAME(displace)(const March *m, const Terms *t, const double *x, double time, const double *v,
                                  double factor, long low, long high, double *y)
{
    UNROLLED(t->count, NAME(displace_by)(m, t, TERMS, x, time, v, factor, low, high, y))
    memcpy(y + high, x + high, BLOCK * sizeof *y);
}

/* Forces of the contacts, and accelerations of the bodies without the applied force, from low to high; `whole`: all that
   belongs to the end of a step. The power of the damping is added to its sum with a weight. */
INLINE void NAME(forces_of)(const March *m, const int hertz, const int damped, const int loaded, const int yields, const int whole,
                            const double *x, const double *v, long low, long high, double weight, End *to)
{
    V here = NAME(load)(x + low), speed = damped ? NAME(load)(v + low) : here, before = NAME(load)(to->f + low - WIDTH);
    long e;
    for (e = low; e < high; e += WIDTH) {
        const V after = NAME(load)(x + e + WIDTH), u = (here - NAME(next)(here, after)) + NAME(load)(m->gap + e);
        const V d = loaded ? u + NAME(load)(m->base + e) : u;
        const V elastic = NAME(elastic)(m, hertz, loaded, yields, e, u, d);
        V f = elastic, raw = elastic;
        if (damped) {
            const V following = NAME(load)(v + e + WIDTH), w = speed - NAME(next)(speed, following);
            f = NAME(damp)(m, e, elastic, d, w, &raw);
            if (weight != 0) NAME(store)(m->shares + e, NAME(load)(m->shares + e) + weight * ((f - elastic) * w));
            if (whole) NAME(store)(to->power + e, (f - elastic) * w);
            speed = following;
        }
        NAME(store)(to->f + e, f);
        NAME(store)(to->a + e, NAME(load)(m->mobile + e) * (NAME(previous)(before, f) - f));
        if (whole) {
            NAME(store)(to->u + e, u);
            NAME(store)(to->d + e, d);
            NAME(store)(to->raw + e, raw + NAME(load)(m->still + e));
            NAME(store)(to->stiffness + e, NAME(stiffness)(m, hertz, e, d));
        }
        before = f;
        here = after;
    }
}

/* The spring and the dashpot of a movable end act on the last body as the contact behind it. */
static void NAME(add_end)(const March *m, const double *x, const double *v, long high, double weight, End *to)
{
    const long last = m->bodies - 1;
    const double stiffness = m->r->end_stiffness, damping = m->r->end_damping, power = damping != 0 ? damping * v[last] * v[last] : 0;
    if (high <= last || (stiffness == 0 && damping == 0)) return;
    to->f[last] = stiffness * x[last] + (damping != 0 ? damping * v[last] : 0);
    to->a[last] = m->mobile[last] * (to->f[last - 1] - to->f[last]);
    if (m->damped) m->shares[last] += weight * power;
    if (to->power) to->power[last] = power;
}

/* Forces and accelerations; stage is that of the sums of the impulses, or negative. */
INLINE void NAME(forces)(March *m, const int whole, const double *x, const double *v, long low, long high, int stage, End *to)
{
    const double weight = m->damped && stage >= 0 ? m->method.weights[stage] : 0;
#define FORCES(hertz, damped, loaded, yields) \
    if (whole) NAME(forces_of)(m, hertz, damped, loaded, yields, 1, x, v, low, high, weight, to); \
    else NAME(forces_of)(m, hertz, damped, loaded, yields, 0, x, v, low, high, weight, to);
    if (m->yields && m->hertz && !m->damped && !m->loaded) { FORCES(1, 0, 0, 1) }
    else if (m->yields) { FORCES(m->hertz, m->damped, m->loaded, 1) }
    else if (m->hertz && !m->damped && !m->loaded) { FORCES(1, 0, 0, 0) }
    else if (m->hertz && !m->damped) { FORCES(1, 0, 1, 0) }
    else if (m->hertz && !m->loaded) { FORCES(1, 1, 0, 0) }
    else { FORCES(m->hertz, m->damped, m->loaded, 0) }
#undef FORCES
    if (m->flows) flow(m, whole, x, v, low, high, stage, to);
    NAME(add_end)(m, x, v, high, weight, to);
    if (stage < 0) return;
    watch(m, to->f, stage);
}

/* Closing velocities at the end of a step, and the time derivatives of its forces before they are cut off. */
TARGET static void NAME(complete)(March *m, End *end, long low, long high, double time)
{
    const double push = (m->damped || m->flows) && low == 0 ? m->inverse[0] * applied(m, time) : 0;
    V speed = NAME(load)(end->v + low), a;
    long e;
    if (push != 0) end->a[0] += push;
    a = NAME(load)(end->a + low);
    for (e = low; e < high; e += WIDTH) {
        const V following = NAME(load)(end->v + e + WIDTH), after = NAME(load)(end->a + e + WIDTH), w = speed - NAME(next)(speed, following);
        const V change = a - NAME(next)(a, after), d = NAME(load)(end->d + e);
        const V slope = NAME(rate)(m, e, NAME(load)(end->stiffness + e), d, w, change);
        NAME(store)(end->w + e, w);
        NAME(store)(end->slope + e, NAME(pick)(NAME(exceeds)(NAME(load)(end->raw + e), NAME(set)(0)), slope, NAME(set)(0)));
        speed = following;
        a = after;
    }
    if (m->flows) set_flow_rates(m, end, low, high);
    if (push != 0) end->a[0] = m->mobile[0] * (end->f[-1] - end->f[0]);
}

/* Everything at one end of a step, from positions and velocities. */
TARGET static void NAME(evaluate)(March *m, End *end, long low, long high, double time)
{
    NAME(forces)(m, 1, end->x, end->v, low, high, -1, end);
    NAME(complete)(m, end, low, high, time);
}

/* Attempts a step of bodies low to high from m->start; the new state is valid one body per stage inside the range. */
TARGET static void NAME(attempt)(March *m, double h, double end, long low, long high, End *to)
{
    const Method *method = &m->method;
    const End *s = &m->start;
    const int stages = method->stages, driven = m->driven && low == 0;
    /* bodies of which forces within the step need the velocities */
    const long first = m->damped || m->first_flow < low ? low : m->first_flow, after = m->damped || m->after_flow > high ? high : m->after_flow;
    long e;
    int i;
    m->stage[0] = s->a;
    watch(m, s->f, 0);
    for (e = low; m->damped && e < high; e += WIDTH) NAME(store)(m->shares + e, method->weights[0] * NAME(load)(s->power + e));
    for (e = first; method->jerk && e < after; e += WIDTH)
        NAME(store)(m->room[1] + e, h * (NAME(load)(m->mobile + e) * (NAME(load)(s->slope + e - 1) - NAME(load)(s->slope + e))));
    m->stage[1] = m->room[1];
    for (i = 1 + method->jerk; i <= stages; i++) {
        const int ends = i == stages, last = ends || (method->last_is_first && i == stages - 1);
        const double t = method->nodes[i] * h;
        double *const y = last ? to->x : m->y, *const z = ends ? to->v : m->z;
        if (!ends || !method->last_is_first) NAME(displace)(m, method->positions + i, s->x, t, s->v, h * h, low, high, y);
        if (ends) NAME(displace)(m, method->velocities + i, s->v, 0, s->v, h, low, high, z);
        else if (method->damped && first < after) NAME(displace)(m, method->velocities + i, s->v, 0, s->v, h, first, after, z);
        if (driven) {
            const double way = shift(m, t, method->nodes[i] == 1 ? end : m->r->time + t, m->impulses + i);
            if (!ends || !method->last_is_first) y[0] += way;
            z[0] += m->inverse[0] * m->impulses[i];
        }
        m->scratch.a = m->room[i < stages ? i : 0];
        if (i < stages) m->stage[i] = last ? to->a : m->scratch.a;
        if (last && !(ends && method->last_is_first)) NAME(forces)(m, 1, y, z, low, high, ends ? -1 : i, to);
        else if (!last) NAME(forces)(m, 0, y, z, low, high, i, &m->scratch);
    }
    m->r->evaluations += stages - method->last_is_first - method->jerk;
}

/* Largest changes between neighbours of factor (sum over the stages), over the scale. */
INLINE V NAME(largest_by)(const March *m, const Terms *t, const int terms, double factor, const double *scale)
{
    const double *stage[MAX_STAGES];
    V a[MAX_STAGES], most = NAME(set)(0), change;
    Mask finite = NAME(reaches)(most, most);
    long e;
    NAME(take_terms)(m, t, terms, stage, a);
    change = factor * NAME(sum)(stage, a, terms, 0);
    for (e = 0; e < m->padded; e += WIDTH) {
        const V after = e + WIDTH < m->padded ? factor * NAME(sum)(stage, a, terms, e + WIDTH) : NAME(set)(0);
        const V error = NAME(magnitude)(change - NAME(next)(change, after)) / NAME(load)(scale + e);
        most = NAME(greater)(error, most);
        finite &= NAME(exceeds)(NAME(set)(m->r->largest), error);
        change = after;
    }
    return NAME(pick)(finite, most, NAME(set)(INFINITY));
}

TARGET static V NAME(largest)(const March *m, const Terms *t, double factor, const double *scale)
{
    V most = NAME(set)(0);
    UNROLLED(t->count, most = NAME(largest_by)(m, t, TERMS, factor, scale))
    return most;
}

/* Largest change of overlaps or closing velocities by two of the sums, over the scales. */
TARGET static double NAME(change)(const March *m, const Terms *t, double h)
{
    double each[WIDTH];
    int i, j;
    NAME(store)(each, NAME(greater)(NAME(largest)(m, t, h * h, m->scale_u), NAME(largest)(m, t + 1, h, m->scale_w)));
    for (i = WIDTH / 2; i > 0; i /= 2) for (j = 0; j < i; j++) each[j] = larger(each[j], each[j + i]);
    return each[0];
}

/* Largest error of the last attempt, over the tolerance. */
static double NAME(error)(March *m, double h)
{
    const double first = NAME(change)(m, m->method.errors, h), second = m->method.estimates < 4 ? 0 : NAME(change)(m, m->method.errors + 2, h);
    const double rough = 0.01 * second * second;
    return (rough != 0 ? first * first / sqrt(first * first + rough) : first) / m->r->tolerance;
}

/* ---------------------------------------------------------------- scans: the next contact from `from` ... */

#define SCAN(from, ...) \
    long e; \
    for (e = (from); e < m->padded; e += WIDTH) { \
        Mask hits; \
        __VA_ARGS__ \
        if (NAME(any)(hits)) return e + NAME(first)(hits); \
    } \
    return m->padded;

/* ... that is predicted to close or to open within a step; */
TARGET static long NAME(near)(const March *m, double h, long from)
{
    const V size = NAME(set)(h);
    SCAN(from, hits = NAME(exceeds)(size * NAME(magnitude)(NAME(load)(m->start.w + e)), NAME(magnitude)(NAME(load)(m->start.d + e)));)
}

/* ... that closes, opens, or is cut off; */
TARGET static long NAME(changed)(const March *m, long from)
{
    const double *const start = m->jumps ? m->on : m->start.d;
    const V zero = NAME(set)(0), least = NAME(set)(m->jumps ? 0.5 : 0);
    SCAN(from,
        Mask before = NAME(reaches)(NAME(load)(start + e), least), after = NAME(reaches)(NAME(load)(m->finish.d + e), zero);
        if (m->damped) {
            const Mask elastic = NAME(reaches)(zero, NAME(load)(m->c + e));
            before &= NAME(reaches)(NAME(load)(m->start.raw + e), zero) | elastic;
            after &= NAME(reaches)(NAME(load)(m->finish.raw + e), zero) | elastic;
        }
        hits = before ^ after;)
}

/* ... that stops closing within a step; */
TARGET static long NAME(passing)(const March *m, long from)
{
    const double *const v = m->start.v, *const v1 = m->finish.v;
    const V zero = NAME(set)(0);
    SCAN(from,
        const Mask closes = NAME(exceeds)(NAME(load)(v + e) - NAME(load)(v + e + 1), zero);
        hits = closes & NAME(reaches)(zero, NAME(load)(v1 + e) - NAME(load)(v1 + e + 1));)
}

/* ... whose force may have its greatest maximum so far within the step; see find_peak. */
TARGET static long NAME(turning)(const March *m, double h, long from)
{
    const V zero = NAME(set)(0);
    SCAN(from,
        const V f0 = NAME(load)(m->start.f + e), f1 = NAME(load)(m->finish.f + e), r0 = h * NAME(load)(m->start.slope + e);
        const V r1 = h * NAME(load)(m->finish.slope + e), middle = 3.0 * (f1 - f0) - r0 - r1, best = NAME(load)(m->best + e);
        const V least = best - m->r->nearly * NAME(magnitude)(best + NAME(load)(m->still + e)), ends = NAME(greater)(f0, f1);
        const Mask rises = NAME(exceeds)(r0, zero), falls = NAME(reaches)(zero, r1);
        const Mask high = NAME(exceeds)(ends + 0.25 * (r0 - r1), least) & rises & falls;
        /* slopes of the same sign, with another in between */
        const Mask bends = (rises & NAME(exceeds)(zero, middle)) | (falls & NAME(exceeds)(middle, zero));
        const Mask twice = (rises ^ falls) & bends & NAME(exceeds)(middle * middle, r0 * r1);
        hits = high | twice;)
}

/* ... whose force exceeds its greatest so far. */
TARGET static long NAME(above)(const March *m, long from)
{
    SCAN(from, hits = NAME(exceeds)(NAME(load)(m->start.f + e), NAME(load)(m->best + e));)
}

/* ... whose mode may end within a step; */
TARGET static long NAME(yielding)(const March *m, double h, long from)
{
    const V span = NAME(set)(2 * h);
    SCAN(from,
        const V w = NAME(greater)(NAME(magnitude)(NAME(load)(m->start.w + e)), NAME(magnitude)(NAME(load)(m->finish.w + e)));
        const V u = NAME(greater)(NAME(load)(m->start.u + e), NAME(load)(m->finish.u + e));
        hits = NAME(exceeds)(u + span * w, NAME(load)(m->plastic.limit + e));)
}

/* Raises the scales of the errors to what was reached before `high` at the end of the step, or is expected next to it. */
TARGET static void NAME(raise_scales)(March *m, long high)
{
    const V zero = NAME(set)(0);
    V before_w = NAME(load)(m->scale_w - WIDTH), before_u = NAME(load)(m->scale_u - WIDTH);
    long e;
    for (e = 0; e < m->padded; e += WIDTH) {
        V w = NAME(load)(m->scale_w + e), u = NAME(load)(m->scale_u + e);
        if (e < high) {
            /* the accumulated change, not the difference of two overlaps: ahead of the wave it is below their rounding errors */
            const V reached = NAME(pick)(NAME(exceeds)(NAME(load)(m->finish.d + e), zero), NAME(magnitude)(NAME(load)(m->finish.u + e)), NAME(load)(m->base + e));
            w = NAME(greater)(w, NAME(magnitude)(NAME(load)(m->finish.w + e)));
            u = NAME(greater)(u, reached);
        }
        NAME(store)(m->scale_w + e, NAME(greater)(w, NAME(load)(m->reach_w + e) * NAME(previous)(before_w, w)));
        NAME(store)(m->scale_u + e, NAME(greater)(u, NAME(load)(m->reach_u + e) * NAME(previous)(before_u, u)));
        before_w = w;
        before_u = u;
    }
}

#undef CASE
#undef UNROLLED
#undef SCAN
