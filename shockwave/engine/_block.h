/* Values of WIDTH neighbouring elements at a time. Included once for each width; a width of 1 is plain C. Every width gives
   the same results. */

#if WIDTH == 1
#define V double
#define Mask int
INLINE double NAME(load)(const double *from) { return *from; }
INLINE void NAME(store)(double *to, double v) { *to = v; }
INLINE double NAME(set)(double v) { return v; }
INLINE int NAME(exceeds)(double v, double limit) { return v > limit; }
INLINE int NAME(reaches)(double v, double limit) { return v >= limit; }
INLINE double NAME(pick)(int mask, double v, double otherwise) { return mask ? v : otherwise; }
INLINE int NAME(any)(int mask) { return mask; }
INLINE int NAME(first)(int mask) { (void)mask; return 0; }
INLINE double NAME(square_root)(double v) { return sqrt(v); }
INLINE double NAME(magnitude)(double v) { return fabs(v); }
INLINE double NAME(greater)(double v, double limit) { return v > limit ? v : limit; }
INLINE double NAME(next)(double v, double following) { (void)v; return following; }
INLINE double NAME(previous)(double preceding, double v) { (void)v; return preceding; }
#elif WIDTH == 8
#define V Values8
#define Mask __mmask8
INLINE V NAME(load)(const double *from) { return *(const Row8 *)from; }
INLINE void NAME(store)(double *to, V v) { *(Row8 *)to = v; }
INLINE V NAME(set)(double v) { return (V)_mm512_set1_pd(v); }
INLINE Mask NAME(exceeds)(V v, V limit) { return _mm512_cmp_pd_mask((__m512d)v, (__m512d)limit, _CMP_GT_OQ); }
INLINE Mask NAME(reaches)(V v, V limit) { return _mm512_cmp_pd_mask((__m512d)v, (__m512d)limit, _CMP_GE_OQ); }
INLINE V NAME(pick)(Mask mask, V v, V otherwise) { return (V)_mm512_mask_blend_pd(mask, (__m512d)otherwise, (__m512d)v); }
INLINE int NAME(any)(Mask mask) { return mask != 0; }
INLINE int NAME(first)(Mask mask) { return __builtin_ctz(mask); }
INLINE V NAME(square_root)(V v) { return (V)_mm512_sqrt_pd((__m512d)v); }
INLINE V NAME(magnitude)(V v) { return (V)_mm512_abs_pd((__m512d)v); }
INLINE V NAME(greater)(V v, V limit) { return (V)_mm512_max_pd((__m512d)v, (__m512d)limit); }
INLINE V NAME(next)(V v, V following) { return (V)_mm512_castsi512_pd(_mm512_alignr_epi64((__m512i)following, (__m512i)v, 1)); }
INLINE V NAME(previous)(V preceding, V v) { return (V)_mm512_castsi512_pd(_mm512_alignr_epi64((__m512i)v, (__m512i)preceding, 7)); }
#else
#define V Values4
#define Mask Bits4
INLINE V NAME(load)(const double *from) { return *(const Row4 *)from; }
INLINE void NAME(store)(double *to, V v) { *(Row4 *)to = v; }
INLINE V NAME(set)(double v) { return (V)_mm256_set1_pd(v); }
INLINE Mask NAME(exceeds)(V v, V limit) { return v > limit; }
INLINE Mask NAME(reaches)(V v, V limit) { return v >= limit; }
INLINE V NAME(pick)(Mask mask, V v, V otherwise) { return (V)_mm256_blendv_pd((__m256d)otherwise, (__m256d)v, (__m256d)mask); }
INLINE int NAME(any)(Mask mask) { return !_mm256_testz_si256((__m256i)mask, (__m256i)mask); }
INLINE int NAME(first)(Mask mask) { return __builtin_ctz((unsigned)_mm256_movemask_pd((__m256d)mask)); }
INLINE V NAME(square_root)(V v) { return (V)_mm256_sqrt_pd((__m256d)v); }
INLINE V NAME(magnitude)(V v) { return (V)_mm256_andnot_pd(_mm256_set1_pd(-0.0), (__m256d)v); }
INLINE V NAME(greater)(V v, V limit) { return (V)_mm256_max_pd((__m256d)v, (__m256d)limit); }
INLINE V NAME(next)(V v, V following) { return __builtin_shuffle(v, following, (Bits4){1, 2, 3, 4}); }
INLINE V NAME(previous)(V preceding, V v) { return __builtin_shuffle(preceding, v, (Bits4){3, 4, 5, 6}); }
#endif

/* d to the power of the damping. */
INLINE V NAME(powers)(const March *m, long e, V d)
{
    double each[WIDTH];
    int i;
    if (m->power == 0) return NAME(set)(1);
    if (m->power == 0.5) return NAME(square_root)(d);
    if (m->power == 0.25) return NAME(square_root)(NAME(square_root)(d));
    NAME(store)(each, d);
    for (i = 0; i < WIDTH; i++) each[i] = power_of(each[i], m->powers[e + i]);
    return NAME(load)(each);
}

#include "_law.h"
#include "_stage.h"

#undef V
#undef Mask
#undef WIDTH
#undef TARGET
#undef NAME
