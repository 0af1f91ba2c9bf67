/* The contact law F = max(k d^p + c d^q d', 0) where d > 0, else 0, of WIDTH contacts at a time. The forces of this file are
   less the static one, and computed without the difference of both. */

/* What is known of closed contacts at element e: d, or 1 where a contact is open. */
INLINE V NAME(inside)(const March *m, V d, Mask *closed)
{
    *closed = NAME(exceeds)(d, NAME(set)(m->r->min_overlap));
    return NAME(pick)(*closed, d, NAME(set)(1));
}

/* k d^p of contacts with or without a static overlap, for any exponents. */
INLINE V NAME(power_law)(const March *m, long e, V stretch, V inside, Mask closed)
{
    double s[WIDTH], d[WIDTH], f[WIDTH];
    int i;
    NAME(store)(s, NAME(pick)(closed, stretch, NAME(set)(0)));
    NAME(store)(d, inside);
    for (i = 0; i < WIDTH; i++) {
        const double base = m->base[e + i], p = m->exponents[e + i], before = m->root[e + i], root = sqrt(d[i]);
        if (base > 0 && p != HERTZ) f[i] = m->still[e + i] * expm1(p * log1p(s[i] / base));
        else if (base > 0) f[i] = m->k[e + i] * (s[i] * (d[i] + root * before + base) / (root + before));
        else f[i] = m->k[e + i] * power_of(d[i], p);
    }
    return NAME(load)(f);
}

/* Elastic force, with the overlap as change since the beginning and in all; that of plastic flow if the chain `yields`,
   unless it is curved. */
INLINE V NAME(elastic)(const March *m, const int hertz, const int loaded, const int yields, long e, V stretch, V d)
{
    Mask closed;
    const V inside = NAME(inside)(m, d, &closed), k = NAME(load)(m->k + e), open = -NAME(load)(m->still + e);
    V force;
    if (!NAME(any)(closed)) return open; /* without roots */
    if (hertz && !loaded) force = k * (d * NAME(square_root)(d)); /* of d, which is known before `inside` */
    else if (hertz) {
        const V base = NAME(load)(m->base + e), before = NAME(load)(m->root + e), root = NAME(square_root)(d);
        force = k * (stretch * (d + root * before + base) / (root + before));
    } else force = NAME(power_law)(m, e, stretch, inside, closed);
    if (yields) force += NAME(load)(m->plastic.offset + e) + NAME(load)(m->plastic.tangent + e) * stretch;
    return NAME(pick)(closed, force, open);
}

/* Force with damping, from the elastic one; `raw` is that before it is cut off. */
INLINE V NAME(damp)(const March *m, long e, V elastic, V d, V w, V *raw)
{
    const double q = m->power;
    const Mask closed = NAME(exceeds)(d, NAME(set)(m->r->min_overlap));
    const V viscous = NAME(load)(m->c + e) * NAME(powers)(m, e, d) * w, zero = NAME(set)(0);
    Mask acts;
    /* only the dashpot of a contact that is off does not act: its force would jump within the step */
    if (q > 0) {
        acts = closed;
        *raw = elastic + NAME(pick)(closed, viscous, zero);
    } else {
        const V on = NAME(load)(m->on + e), one = NAME(set)(1);
        const Mask jumps = NAME(reaches)(zero, NAME(load)(m->powers + e));
        acts = NAME(exceeds)(NAME(pick)(jumps, on, NAME(pick)(closed, one, zero)), zero);
        *raw = elastic + NAME(pick)(jumps, viscous, NAME(pick)(closed, viscous, zero));
    }
    return NAME(greater)(NAME(pick)(acts, *raw, elastic), -NAME(load)(m->still + e));
}

/* Derivative of the elastic force by the overlap; 0 if the contact is open. */
INLINE V NAME(stiffness)(const March *m, const int hertz, long e, V d)
{
    Mask closed;
    const V inside = NAME(inside)(m, d, &closed), p = hertz ? NAME(set)(HERTZ) : NAME(load)(m->exponents + e);
    double each[WIDTH];
    V rate;
    int i;
    if (hertz) rate = NAME(square_root)(d);
    else {
        NAME(store)(each, inside);
        for (i = 0; i < WIDTH; i++) each[i] = power_of(each[i], m->exponents[e + i] - 1);
        rate = NAME(load)(each);
    }
    return NAME(pick)(closed, p * NAME(load)(m->k + e) * rate, NAME(set)(0));
}

/* Time derivative of the force before it is cut off, from stiffness, overlap, closing velocity and its derivative. */
INLINE V NAME(rate)(const March *m, long e, V stiffness, V d, V w, V closing)
{
    Mask closed;
    const V inside = NAME(inside)(m, d, &closed), elastic = stiffness * w;
    if (!m->damped) return elastic;
    return NAME(pick)(closed, elastic + NAME(load)(m->c + e) * NAME(powers)(m, e, inside)
                      * (NAME(load)(m->powers + e) / inside * w * w + closing), NAME(set)(0));
}
