/* Stage and new state of a step for Hertz's exponent: the same arithmetic as in `stage` and `combine` of _window.h, for
   vectors of one width.

   Included once for each width, with these macros: WITH_VECTORS, the attribute of functions that use the vectors;
   NAME(function), the name of a function for this width; Values and Bits, the vectors of floats and of integers; PARTS,
   the number of vectors in a block; SINGLE(window), whether the neighbour of an element is the next element (one lane),
   not that of the next block; and FORCES(e), which sets the contact forces of the block at element e. Positions and
   contact forces remain in registers, one block ahead and one behind. */

#define PART(address, i) (*(Values *)((address) + (i) * (BLOCK / PARTS)))
#define LARGER(one, other) LARGER_OF(Values, Bits, one, other)

/* `single`, and `terms` up to 8, are compile-time constants after inlining, so that the loops over the stages are
   unrolled. `x_end`, if not NULL, receives the positions. */
WITH_VECTORS static inline __attribute__((always_inline)) void NAME(stage_of)(
    const int terms, const int single, long n, double c, const double *a, const double *h, const double *shift,
    double *x_end, Window *w)
{
    const double *const x = w->x, *const v = w->v;
    double *const *const k = w->k, *const out = k[terms];
    Values step[PARTS], square[PARTS], now[PARTS], force[PARTS];
    Bits following, preceding;
    long e;
    int i, j;
    for (i = 0; i < BLOCK / PARTS; i++) {
        following[i] = i + 1;
        preceding[i] = BLOCK / PARTS - 1 + i;
    }
    for (i = 0; i < PARTS; i++) {
        step[i] = PART(h, i) * c;
        square[i] = PART(h, i) * PART(h, i);
        now[i] = PART(shift, i);
        force[i] = (Values){0};
    }
    for (e = -BLOCK; e < n; e += BLOCK) {
        Values next[PARTS], overlap[PARTS], before[PARTS];
        for (i = 0; i < PARTS; i++) next[i] = PART(x + e + BLOCK, i);
        /* granules beyond the window are at rest */
        if (e + BLOCK < n) {
            Values sum[PARTS];
            for (i = 0; i < PARTS; i++) sum[i] = (Values){0};
#pragma GCC unroll 16
            for (j = 0; j < terms; j++)
                for (i = 0; i < PARTS; i++) sum[i] += PART(k[j] + e + BLOCK, i) * a[j];
            for (i = 0; i < PARTS; i++) {
                next[i] = next[i] + step[i] * PART(v + e + BLOCK, i) + square[i] * sum[i];
                if (x_end) PART(x_end + e + BLOCK, i) = next[i];
            }
        }
        if (e < 0) {
            for (i = 0; i < PARTS; i++) now[i] += next[i];
            continue;
        }
        for (i = 0; i < PARTS; i++) {
            const Values after = i + 1 < PARTS ? now[(i + 1) % PARTS] : next[0];
            overlap[i] = now[i] - (single ? __builtin_shuffle(now[i], after, following) : next[i]);
            overlap[i] = (Values)((Bits)overlap[i] & (overlap[i] > MIN_OVERLAP));
            before[i] = force[i];
        }
        FORCES(e)
        for (i = 0; i < PARTS; i++) {
            const Values last = i ? force[(i + PARTS - 1) % PARTS] : before[PARTS - 1];
            PART(out + e, i) = (single ? __builtin_shuffle(last, force[i], preceding) : before[i]) - force[i];
            now[i] = next[i];
        }
    }
}

#define UNROLLED(terms) \
    case terms: \
        if (SINGLE(w)) NAME(stage_of)(terms, 1, n, c, a, h, shift, x_end, w); \
        else NAME(stage_of)(terms, 0, n, c, a, h, shift, x_end, w); \
        break;

WITH_VECTORS static void NAME(stage)(int terms, long n, double c, const double *a, const double *h, const double *shift,
                                     double *x_end, Window *w)
{
    switch (terms) {
    UNROLLED(1) UNROLLED(2) UNROLLED(3) UNROLLED(4) UNROLLED(5) UNROLLED(6) UNROLLED(7) UNROLLED(8)
    default: NAME(stage_of)(terms, SINGLE(w), n, c, a, h, shift, x_end, w);
    }
}

WITH_VECTORS static void NAME(combine)(long n, const Method *m, const double *h, Window *w, double *worst)
{
    double *const *const k = w->k;
    const Bits magnitude = ~(Bits)-(Values){0}; /* all bits except the sign */
    Values most[PARTS];
    long e;
    int begin = 1, end = m->stages, i, j;
    /* stages without weight are left out */
    while (begin < end && m->bp[begin] == 0 && m->ep[begin] == 0) begin++;
    while (begin < end && m->b[end - 1] == 0 && m->e[end - 1] == 0) end--;
    for (i = 0; i < PARTS; i++) most[i] = (Values){0};
    for (e = 0; e < n; e += BLOCK) {
        Values b[PARTS], bp[PARTS], d[PARTS], dp[PARTS];
        for (i = 0; i < PARTS; i++) {
            const Values first = PART(k[0] + e, i);
            b[i] = first * m->b[0];
            bp[i] = first * m->bp[0];
            d[i] = first * m->e[0];
            dp[i] = first * m->ep[0];
        }
        for (j = begin; j < m->stages; j++)
            for (i = 0; i < PARTS; i++) {
                const Values kj = PART(k[j] + e, i);
                bp[i] += kj * m->bp[j];
                dp[i] += kj * m->ep[j];
                if (j < end) d[i] += kj * m->e[j];
                if (j < end && !m->last_is_first) b[i] += kj * m->b[j];
            }
        for (i = 0; i < PARTS; i++) {
            const Values step = PART(h, i), square = step * step;
            if (!m->last_is_first) PART(w->x1 + e, i) = PART(w->x + e, i) + step * PART(w->v + e, i) + square * b[i];
            PART(w->v1 + e, i) = PART(w->v + e, i) + step * bp[i];
            d[i] = (Values)((Bits)(square * d[i]) & magnitude);
            dp[i] = (Values)((Bits)(step * dp[i]) & magnitude);
            most[i] = LARGER(most[i], d[i]);
            most[i] = LARGER(most[i], dp[i]);
        }
    }
    for (i = 0; i < PARTS; i++) PART(worst, i) = most[i];
}

WITH_VECTORS static void NAME(attempt)(const Method *m, Window *w, long n, const double *h, const double *shift,
                                       double *worst)
{
    int i;
    /* the positions of the last stage are those at the end if it is the first stage of the next step */
    for (i = 1; i < m->stages; i++)
        NAME(stage)(i, n, m->c[i], m->a + i * m->stages, h, shift + i * BLOCK,
                    m->last_is_first && i + 1 == m->stages ? w->x1 : NULL, w);
    NAME(combine)(n, m, h, w, worst);
}

#undef PART
#undef LARGER
#undef UNROLLED
#undef WITH_VECTORS
#undef NAME
#undef Values
#undef Bits
#undef PARTS
#undef SINGLE
#undef FORCES
