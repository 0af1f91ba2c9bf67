/* One step of several chains side by side, each in a lane: the arrays, the method, and stages and new states in vectors. */

/* `attempt` selects one of the versions of _step.h when it is called. */
/* Compiled for several vector widths; the loader selects the widest that the processor supports. */
#if defined(X86_VECTORS) && defined(__GLIBC__)
#define WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define WIDE
#endif

/* a block has the lanes of one granule, or eight granules of one lane */
#define MIN_OVERLAP 1e-40 /* smaller overlaps count as zero: arithmetic with subnormal numbers is slow */
#define HERTZ 1.5

/* Half a block as one value. Code for values that are wider than the vectors of the processor would be many times
   slower. */
#define HALF (BLOCK / 2)
typedef double Vector __attribute__((vector_size(HALF * sizeof(double)), aligned(sizeof(double)), may_alias));
typedef long long Choice __attribute__((vector_size(HALF * sizeof(double))));
#define VECTOR(address) (*(Vector *)(address))
#define MAGNITUDE 0x7fffffffffffffffLL
#define ABSOLUTE(v) ((Vector)((Choice)(v) & (Choice){MAGNITUDE, MAGNITUDE, MAGNITUDE, MAGNITUDE}))
/* `other` where it is larger or a NaN, else `one`, so that a NaN is kept; for vectors of floats and of whole numbers */
#define LARGER_OF(Floats, Whole, one, other) \
    ((Floats)(((Whole)(other) & (((other) > (one)) | ((other) != (other)))) \
              | ((Whole)(one) & ~(((other) > (one)) | ((other) != (other))))))
#define GREATER(one, other) LARGER_OF(Vector, Choice, one, other)

/* ---------------------------------------------------------------- the method */

typedef struct {
    int stages, error_order, last_is_first;
    double exponent;
    const double *c, *a, *b, *bp, *e, *ep; /* a: stages x stages, row by row */
} Method;

static int method_of(const double *data, Py_ssize_t size, Method *method)
{
    int s;
    if (size < 3 || !(data[0] >= 2 && data[0] <= MAX_STAGES && data[1] >= 0 && data[1] < 100)) return 0;
    s = (int)data[0];
    if (size != 3 + s * (s + 5) && size != 4 + s * (s + 5)) return 0;
    method->exponent = size == 4 + s * (s + 5) ? data[size - 1] : HERTZ;
    if (!(method->exponent > 1 && method->exponent < 100)) return 0;
    method->stages = s;
    method->error_order = (int)data[1];
    method->last_is_first = data[2] != 0;
    method->c = data + 3;
    method->a = method->c + s;
    method->b = method->a + s * s;
    method->bp = method->b + s;
    method->e = method->bp + s;
    method->ep = method->e + s;
    return 1;
}

/* ---------------------------------------------------------------- one step of all lanes */

/* Arrays of a window, each with at least `lanes` zeros before its first element and spare elements after its last. */
typedef struct {
    long lanes, room, used; /* room: elements of each array; used: leading elements that may be nonzero */
    double exponent;
    double *block;
    double *x, *v, *x1, *v1, *y, *f, *late, *since, *k[MAX_STAGES];
} Window;

static int window_of(Window *w, long lanes, long rows, double exponent)
{
    long pad = (lanes + BLOCK - 1) / BLOCK * BLOCK, i;
    double **const arrays[] = {&w->x, &w->v, &w->x1, &w->v1, &w->y, &w->f, &w->late, &w->since};
    const long named = (long)(sizeof arrays / sizeof *arrays);
    double *at;
    w->block = NULL;
    if (rows > (LONG_MAX / (named + MAX_STAGES) - 3 * pad) / lanes) return 0;
    w->lanes = lanes;
    w->used = 0;
    w->exponent = exponent;
    w->room = (rows * lanes + BLOCK - 1) / BLOCK * BLOCK;
    w->block = calloc((size_t)((named + MAX_STAGES) * (w->room + 3 * pad) + BLOCK), sizeof(double));
    if (!w->block) return 0;
    /* blocks aligned to cache lines, which have the same size, do not straddle two of them */
    at = (double *)(((uintptr_t)w->block / (BLOCK * sizeof(double)) + 1) * (BLOCK * sizeof(double))) + pad;
    for (i = 0; i < named + MAX_STAGES; i++, at += w->room + 3 * pad)
        *(i < named ? arrays[i] : &w->k[i - named]) = at;
    return 1;
}

/* Accelerations k[terms] at the positions y = x + c h v + h^2 sum of a_j k_j, j < terms, with h of shape (BLOCK,), and
   the contact forces f. `shift` is added to the first row. */
static void stage(long n, int terms, double c, const double *a, const double *h, const double *shift, Window *w)
{
    const Vector step = VECTOR(h) * c, square = VECTOR(h) * VECTOR(h);
    const Vector step2 = VECTOR(h + HALF) * c, square2 = VECTOR(h + HALF) * VECTOR(h + HALF);
    const long lanes = w->lanes;
    const double *const x = w->x, *const v = w->v;
    double *const *const k = w->k, *const out = k[terms], *const y = w->y, *const f = w->f;
    long e;
    int j;
    for (e = 0; e < n; e += BLOCK) {
        Vector sum = square - square, sum2 = sum;
        for (j = 0; j < terms; j++) {
            sum += VECTOR(k[j] + e) * a[j];
            sum2 += VECTOR(k[j] + e + HALF) * a[j];
        }
        VECTOR(y + e) = VECTOR(x + e) + step * VECTOR(v + e) + square * sum;
        VECTOR(y + e + HALF) = VECTOR(x + e + HALF) + step2 * VECTOR(v + e + HALF) + square2 * sum2;
    }
    /* granules beyond the window are at rest */
    for (e = n; e < n + lanes; e++) y[e] = x[e];
    for (e = 0; e < lanes; e++) y[e] += shift[e];
    for (e = 0; e < n; e++) {
        const double gap = y[e] - y[e + lanes];
        f[e] = gap > MIN_OVERLAP ? gap : 0;
    }
    if (w->exponent == HERTZ) for (e = 0; e < n; e++) f[e] = f[e] * sqrt(f[e]);
    else for (e = 0; e < n; e++) f[e] = f[e] > 0 ? f[e] * pow(f[e], w->exponent - 1) : 0;
    for (e = 0; e < n; e++) out[e] = f[e - lanes] - f[e];
}

/* The new state x1, v1, and its largest difference from the embedded method for each element of a block. */
static void combine(long n, const Method *m, const double *h, Window *w, double *worst)
{
    double *const *const k = w->k;
    long e, half;
    int j;
    for (half = 0; half < BLOCK; half += HALF) {
        const Vector step = VECTOR(h + half), square = step * step;
        Vector most = step - step;
        for (e = half; e < n; e += BLOCK) {
            const Vector first = VECTOR(k[0] + e);
            Vector b = first * m->b[0], bp = first * m->bp[0], d = first * m->e[0], dp = first * m->ep[0];
            for (j = 1; j < m->stages; j++) {
                const Vector kj = VECTOR(k[j] + e);
                b += kj * m->b[j];
                bp += kj * m->bp[j];
                d += kj * m->e[j];
                dp += kj * m->ep[j];
            }
            VECTOR(w->x1 + e) = VECTOR(w->x + e) + step * VECTOR(w->v + e) + square * b;
            VECTOR(w->v1 + e) = VECTOR(w->v + e) + step * bp;
            d = ABSOLUTE(square * d);
            dp = ABSOLUTE(step * dp);
            most = GREATER(most, d);
            most = GREATER(most, dp);
        }
        VECTOR(worst + half) = most;
    }
}

#ifdef X86_VECTORS
/* in memory, at any element */
typedef Values4 Anywhere4 __attribute__((aligned(8), may_alias));
typedef Values8 Anywhere8 __attribute__((aligned(8), may_alias));

#define WITH_VECTORS __attribute__((target("avx2")))
#define NAME(function) function##_avx2
#define Values Anywhere4
#define Bits Bits4
#define PARTS 2
#define SINGLE(w) ((w)->lanes == 1)
/* A block without a closed contact needs no roots. One lane has many such blocks; with several lanes they are too irregular
   for the branch to be predicted. */
#define FORCES(e) \
    for (i = 0; i < PARTS; i++) force[i] = overlap[i]; \
    if (!single || !_mm256_testz_si256((__m256i)overlap[0] | (__m256i)overlap[1], (__m256i)overlap[0] | (__m256i)overlap[1])) \
        for (i = 0; i < PARTS; i++) force[i] *= (Values)_mm256_sqrt_pd((__m256d)overlap[i]);
#include "_step.h"

/* Square roots by Newton's method instead of the divider, which takes longer than all other arithmetic of a stage. They
   are correctly rounded, like those of the divider (Markstein, IBM Journal of Research and Development 34 (1990) 111). */
__attribute__((target("avx512f"))) static inline __m512d roots(__m512d d)
{
    const __m512d half = _mm512_set1_pd(0.5);
    const __m512d y = _mm512_maskz_rsqrt14_pd(_mm512_test_epi64_mask((__m512i)d, (__m512i)d), d);
    __m512d root = d * y, slope = half * y, rest;
    int i;
    for (i = 0; i < 2; i++) {
        rest = _mm512_fnmadd_pd(root, slope, half);
        root = _mm512_fmadd_pd(root, rest, root);
        slope = _mm512_fmadd_pd(slope, rest, slope);
    }
    return _mm512_fmadd_pd(slope, _mm512_fnmadd_pd(root, root, d), root);
}

#define WITH_VECTORS __attribute__((target("avx512f")))
#define NAME(function) function##_avx512
#define Values Anywhere8
#define Bits Bits8
#define PARTS 1
#define SINGLE(w) 0
/* alternate blocks use the divider, which works in parallel with the arithmetic of `roots` */
#define FORCES(e) force[0] = overlap[0] * (Values)((e) / BLOCK % 2 ? roots((__m512d)overlap[0]) : _mm512_sqrt_pd((__m512d)overlap[0]));
#include "_step.h"
#endif

/* Attempts a step of sizes h from x, v with accelerations k[0]. `shift`, stages x BLOCK, is the free-particle
   displacement at the stages. Sets x1, v1 to the new state and `worst` to the largest error of each element. */
static void attempt(const Method *m, Window *w, long n, const double *h, const double *shift, double *worst)
{
    int i;
#ifdef X86_VECTORS
    if (w->exponent == HERTZ && w->lanes == BLOCK && __builtin_cpu_supports("avx512f")) {
        attempt_avx512(m, w, n, h, shift, worst);
        return;
    }
    if (w->exponent == HERTZ && __builtin_cpu_supports("avx2")) {
        attempt_avx2(m, w, n, h, shift, worst);
        return;
    }
#endif
    for (i = 1; i < m->stages; i++)
        stage(n, i, m->c[i], m->a + i * m->stages, h, shift + i * BLOCK, w);
    combine(n, m, h, w, worst);
}
