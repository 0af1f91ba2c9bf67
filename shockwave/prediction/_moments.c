/* The law of moments for many pulses: `gauss` of gauss_impulses.py, `kernel_force` and `columns` of moments.py in C.

   The functions take buffers of float64 and have no state; the global interpreter lock is released while they run. Sums
   have a fixed order, so that results do not depend on the processor. */

#ifndef Py_LIMITED_API
#define Py_LIMITED_API 0x030B0000
#endif
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Compiled for several instruction sets, with the functions it calls inlined; the loader selects the widest that the
   processor supports. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define WIDE __attribute__((target_clones("avx512f", "avx2", "default"), flatten))
#else
#define WIDE
#endif

#define BLOCK 32         /* partial sums of a long sum, so many that additions need not wait for one another; arrays are
                            padded with zeros to a multiple */
#define PADDED(n) (((n) + BLOCK - 1) / BLOCK * BLOCK)

/* Vectors of eight numbers, a register of AVX-512, and of four. */
#define WIDTH (BLOCK / 4)
typedef double Wide __attribute__((vector_size(WIDTH * sizeof(double)), aligned(sizeof(double)), may_alias));
#define LANES (WIDTH / 2)
typedef double Vector __attribute__((vector_size(LANES * sizeof(double)), aligned(sizeof(double)), may_alias));
typedef long long Whole __attribute__((vector_size(LANES * sizeof(double)), aligned(sizeof(double)), may_alias));
#define VECTOR(address) (*(Vector *)(address))
#define CHOICE(mask, yes, no) ((Vector)(((Whole)(yes) & (mask)) | ((Whole)(no) & ~(mask))))

/* Numbers of several pulses, one in each lane. Loops over the lanes are vectorised for each instruction set. */
typedef double Lanes[LANES];
#define EACH_LANE for (b = 0; b < LANES; b++)

/* See gauss_impulses.py and moments.py for the meaning of the constants of the same names. */
#define ROUNDING 1e-14
#define MOST_STEPS 60
#define SETTLED 1e-9
#define BOUND 1.005 /* largest ratio of the bound of the eigenvalue and the eigenvalue: it may be another one */
#define ABOVE (1 + 1e-9)
#define POWER 2.5
#define COLUMNS 11
#define MOST_TURNS 100   /* largest number of QL iterations for an eigenvalue; two or three suffice */

/* ---------------------------------------------------------------- a pulse as a few impulses */

/* Sum of the products of two arrays of padded length. */
static double dot(const double *one, const double *other, long n)
{
    const Wide *const a = (const Wide *)one, *const b = (const Wide *)other;
    Wide sum = {0}, second = sum, third = sum, fourth = sum;
    long i;
    for (i = 0; i < n / WIDTH; i += 4) {
        sum += a[i] * b[i];
        second += a[i + 1] * b[i + 1];
        third += a[i + 2] * b[i + 2];
        fourth += a[i + 3] * b[i + 3];
    }
    sum = (sum + second) + (third + fourth);
    return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

static void scale_by(double *values, double factor, long n)
{
    long i;
    for (i = 0; i < n; i++) values[i] *= factor;
}

/* The next vector of Lanczos' recurrence before it is normalised; returns the diagonal element. */
static double follow(const double *position, const double *vector, const double *last, double beside, double *next,
                     long n)
{
    double diagonal;
    long i;
    for (i = 0; i < n; i++) next[i] = position[i] * vector[i];
    diagonal = dot(vector, next, n);
    for (i = 0; i < n; i++) next[i] = next[i] - diagonal * vector[i] - beside * last[i];
    return diagonal;
}

/* Rows `last` - 1 to l of the matrices in a QL iteration, in four lanes, in each of them from row m - 1 on. A lane in which
   the matrix falls into two parts stops: its m becomes l. */
static void iterate(long l, long last, Lanes *d, Lanes *e, Lanes *first, long long *m, double *p, double *g)
{
    const Vector one = {1, 1, 1, 1};
    const Whole least = {l, l, l, l};
    Vector s = one, c = one, shift = VECTOR(p), now = VECTOR(g), lower = VECTOR(d[last]), below = VECTOR(first[last]), root;
    Whole start = *(Whole *)m;
    long i;
    int b;
    for (i = last - 1; i >= l; i--) {
        const Vector own = VECTOR(e[i]), f = s * own, h = c * own, square = f * f + now * now;
        const Vector upper = VECTOR(d[i]), above = VECTOR(first[i]), rest = lower - shift;
        const Whole on = start > (Whole){i, i, i, i};
        Vector sine, cosine, turned;
        Whole turns;
        EACH_LANE root[b] = sqrt(square[b]);
        turns = on & (root != 0);
        sine = f * (1 / root);
        cosine = now * (1 / root);
        turned = (upper - rest) * sine + 2 * cosine * h;
        VECTOR(e[i + 1]) = CHOICE(on, root, VECTOR(e[i + 1]));
        VECTOR(d[i + 1]) = CHOICE(turns, rest + sine * turned, CHOICE(on, rest, lower));
        VECTOR(first[i + 1]) = CHOICE(turns, sine * above + cosine * below, below);
        below = CHOICE(turns, cosine * above - sine * below, above);
        now = CHOICE(turns, cosine * turned - h, now);
        shift = CHOICE(turns, sine * turned, shift);
        s = CHOICE(turns, sine, s);
        c = CHOICE(turns, cosine, c);
        start = (start & (turns | ~on)) | (least & on & ~turns);
        lower = upper;
    }
    VECTOR(d[l]) = lower;
    VECTOR(first[l]) = below;
    VECTOR(p) = shift;
    VECTOR(g) = now;
    *(Whole *)m = start;
}

/* Eigenvalues d, in ascending order, of symmetric tridiagonal n x n matrices with the diagonals d and the elements e
   beside them, and the first elements of their eigenvectors, by the implicit QL method. Golub, G. H. & Welsch, J. H.
   (1969). Mathematics of Computation, 23, 221-230. Returns 0 if it does not converge. */
static int tridiagonal(Lanes *d, Lanes *e, Lanes *first, long n)
{
    long l, i;
    int b, turn;
    memset(first, 0, (size_t)n * sizeof *first);
    EACH_LANE {
        first[0][b] = 1;
        e[n - 1][b] = 0;
    }
    for (l = 0; l < n; l++)
        for (turn = 0;; turn++) {
            Lanes p, g;
            long long m[LANES];
            long end[LANES], last = l;
            EACH_LANE {
                long at = l;
                double r;
                while (at < n - 1 && !(fabs(e[at][b]) <= DBL_EPSILON * (fabs(d[at][b]) + fabs(d[at + 1][b])))) at++;
                m[b] = end[b] = at;
                p[b] = g[b] = 0;
                if (at == l) continue;
                if (at > last) last = at;
                g[b] = (d[l + 1][b] - d[l][b]) / (2 * e[l][b]);
                r = hypot(g[b], 1);
                g[b] = d[at][b] - d[l][b] + e[l][b] / (g[b] + copysign(r, g[b]));
            }
            if (last == l) break;
            if (turn == MOST_TURNS) return 0;
            iterate(l, last, d, e, first, m, p, g);
            EACH_LANE {
                if (m[b] > l) {
                    d[l][b] -= p[b];
                    e[l][b] = g[b];
                }
                if (end[b] > l) e[end[b]][b] = 0;
            }
        }
    EACH_LANE
        for (l = 1; l < n; l++) {
            const double value = d[l][b], own = first[l][b];
            for (i = l; i > 0 && d[i - 1][b] > value; i--) {
                d[i][b] = d[i - 1][b];
                first[i][b] = first[i - 1][b];
            }
            d[i][b] = value;
            first[i][b] = own;
        }
    return 1;
}

/* Matrices of the pulses in the lanes, with mean and scale of their times and their total impulses. */
typedef struct {
    Lanes *diagonal, *beside, *first, mean, scale, total;
} Reduced;

/* Lanczos' recurrence for one pulse of `points` impulses: the matrix of `count` rows in lane b. `work` has room for five
   vectors of padded length. */
static void recur(const double *times, const double *impulses, long points, long count, int b, Reduced *to, double *work)
{
    const long n = PADDED(points);
    double *const position = work, *const weight = work + n, *const base = work + 2 * n;
    double *vector = base + n, *last = base, *next, total, mean, scale = 0, step = 0;
    long i, row;
    memset(work, 0, (size_t)(5 * n) * sizeof(double));
    for (i = 0; i < points; i++) {
        weight[i] = impulses[i] > 0 ? impulses[i] : 0;
        position[i] = times[i];
        vector[i] = 1;
    }
    total = dot(weight, vector, n);
    mean = dot(weight, position, n) / total;
    for (i = 0; i < points; i++) {
        position[i] -= mean;
        if (fabs(position[i]) > scale) scale = fabs(position[i]);
    }
    for (i = 0; i < points; i++) {
        position[i] *= 1 / scale;
        vector[i] = sqrt(weight[i] * (1 / total));
    }
    for (row = 0; row < count; row++) {
        next = base + (row + 2) % 3 * n;
        to->diagonal[row][b] = follow(position, vector, last, step, next, n);
        to->beside[row][b] = step = sqrt(dot(next, next, n));
        scale_by(next, 1 / (step > ROUNDING ? step : ROUNDING), n);
        last = vector;
        vector = next;
    }
    to->mean[b] = mean;
    to->scale[b] = scale;
    to->total[b] = total;
}

/* `gauss` for at most as many pulses as there are lanes. `work` has room for three arrays of `count`
   lanes in addition to what `recur` needs. */
WIDE static int reduce(const double *times, const double *impulses, long points, double *instants, double *parts,
                       long count, long pulses, double *work)
{
    Lanes *const matrices = (Lanes *)work;
    Reduced found = {matrices, matrices + count, matrices + 2 * count, {0}, {0}, {0}};
    long i;
    int b;
    memset(work, 0, (size_t)(3 * count) * sizeof *matrices);
    for (b = 0; b < pulses; b++)
        recur(times + b * points, impulses + b * points, points, count, b, &found, work + 3 * count * LANES);
    if (!tridiagonal(found.diagonal, found.beside, found.first, count)) return 0;
    for (b = 0; b < pulses; b++)
        for (i = 0; i < count; i++) {
            instants[b * count + i] = found.mean[b] + found.scale[b] * found.diagonal[i][b];
            parts[b * count + i] = found.total[b] * found.first[i][b] * found.first[i][b];
        }
    return 1;
}

/* ---------------------------------------------------------------- kernel and local measures */

/* The coefficients of the law; see `Law`. */
typedef struct {
    double width, reach, peak, highest; /* peak: value of the kernel at 0; highest: ln of the step limit */
} Law;

/* Pulses of k impulses, one in each lane, in the notation of `kernel_force`. Of the symmetric k x k matrices only a
   part of the upper triangle is used: row i has columns i to end[i] - 1, and end[i] does not decrease with i. The kernels
   beyond are negligible in every lane. */
typedef struct {
    long k, *end;
    Lanes *apart, *kernel, *system, *times, *impulses, *masses, *roots, *vector, *image, *right;
} Kernels;
#define MATRICES 3 /* in `Kernels` */
#define VECTORS 7

#define LOG2_E 1.4426950408889634
#define LN2_HIGH 6.93147180369123816490e-01 /* has trailing zeros, so that its products with small integers are exact */
#define LN2_LOW 1.90821492927058770002e-10
#define SHIFT 6755399441055744.0             /* 1.5 * 2^52: adding it rounds to the nearest integer */
#define NEGLIGIBLE (-40.0)                   /* least exponent of the kernel, whose value is 4e-18 then */

/* exp(factor * values), to a unit in the last place, for arguments from `NEGLIGIBLE` to 0; zero for smaller arguments.
   The function of the C library takes several times as long, and its last digit depends on the processor. */
static void exponentials(const Lanes *restrict values, const double *restrict factor, Lanes *restrict results, long n)
{
    static const double coefficients[] = {1 / 6227020800.0, 1 / 479001600.0, 1 / 39916800.0, 1 / 3628800.0,
                                          1 / 362880.0, 1 / 40320.0, 1 / 5040.0, 1 / 720.0, 1 / 120.0, 1 / 24.0,
                                          1 / 6.0, 0.5, 1, 1};
    long j;
    int b, i;
    for (j = 0; j < n; j++)
        EACH_LANE {
            const double given = values[j][b] * factor[b], x = given < NEGLIGIBLE ? NEGLIGIBLE : given;
            const double shifted = x * LOG2_E + SHIFT, rounded = shifted - SHIFT;
            const double rest = (x - rounded * LN2_HIGH) - rounded * LN2_LOW;
            double sum = coefficients[0], power;
            unsigned long long bits, bias;
            memcpy(&bits, &shifted, sizeof bits);
            memcpy(&bias, &(const double){SHIFT}, sizeof bias);
            bits = (bits - bias + 1023) << 52;
            memcpy(&power, &bits, sizeof power);
            for (i = 1; i < 14; i++) sum = sum * rest + coefficients[i];
            results[j][b] = given < NEGLIGIBLE ? 0 : sum * power;
        }
}

/* The kernels, exp(factor * apart) with negative factors, and the ends of their rows. */
static void exponentiate(Kernels *p, const double *factor)
{
    const long k = p->k;
    long i, end = 0;
    int b;
    for (i = 0; i < k; i++) {
        while (end < k) {
            const double *const apart = p->apart[i * k + end];
            int some = 0;
            EACH_LANE some |= !(apart[b] * factor[b] < NEGLIGIBLE);
            if (!some) break;
            end++;
        }
        p->end[i] = end;
        exponentials(p->apart + i * k + i, factor, p->kernel + i * k + i, end - i);
    }
}

/* The products of the kernels and `right`, as `image`. */
static void apply(Kernels *p)
{
    const long k = p->k;
    Lanes *const image = p->image, *const right = p->right;
    long i, j;
    memset(image, 0, (size_t)k * sizeof *image);
    for (i = 0; i < k; i++) {
        const Lanes *const row = p->kernel + i * k;
        const Vector own = VECTOR(right[i]);
        Vector sum = VECTOR(image[i]) + VECTOR(row[i]) * own;
        for (j = i + 1; j < p->end[i]; j++) {
            sum += VECTOR(row[j]) * VECTOR(right[j]);
            VECTOR(image[j]) += VECTOR(row[j]) * own;
        }
        VECTOR(image[i]) = sum;
    }
}

/* Solves (shift I - R K R) x = `right` in place, with R = diag(roots), by elimination without pivots. Cancellation
   occurs only on the diagonal, because no other element is positive. */
static void solve(Kernels *p, const double *shift)
{
    const long k = p->k, *const end = p->end;
    Lanes *const a = p->system, *const x = p->right;
    long i, j, m;
    for (i = 0; i < k; i++) {
        for (j = i; j < end[i]; j++)
            VECTOR(a[i * k + j]) = -VECTOR(p->kernel[i * k + j]) * VECTOR(p->roots[i]) * VECTOR(p->roots[j]);
        VECTOR(a[i * k + i]) += VECTOR(shift);
    }
    for (m = 0; m < k; m++)
        for (i = m + 1; i < end[m]; i++) {
            const Vector factor = VECTOR(a[m * k + i]) / VECTOR(a[m * k + m]);
            for (j = i; j < end[m]; j++) VECTOR(a[i * k + j]) -= factor * VECTOR(a[m * k + j]);
            VECTOR(x[i]) -= factor * VECTOR(x[m]);
        }
    for (m = k - 1; m >= 0; m--) {
        Vector sum = VECTOR(x[m]);
        for (i = m + 1; i < end[m]; i++) sum -= VECTOR(a[m * k + i]) * VECTOR(x[i]);
        VECTOR(x[m]) = sum / VECTOR(a[m * k + m]);
    }
}

/* The results of `kernel_force`, ln F/F0 and the eigenvectors; ln F/F0 is NaN where the iteration does not converge. */
WIDE static void balance(const Law *law, Kernels *p, double *log_force)
{
    const long k = p->k;
    Lanes *const masses = p->masses, *const vector = p->vector, *const image = p->image, *const right = p->right;
    Lanes active, mass = {0};
    long i, j;
    int b, step, some = 1;
    for (i = 0; i < k; i++) {
        for (j = i; j < k; j++)
            EACH_LANE {
                const double apart = fabs(p->times[i][b] - p->times[j][b]) / law->width;
                p->apart[i * k + j][b] = apart * apart * sqrt(apart);
            }
        EACH_LANE {
            masses[i][b] = law->peak * p->impulses[i][b];
            p->roots[i][b] = sqrt(masses[i][b]);
            vector[i][b] = 1;
            mass[b] += masses[i][b];
        }
    }
    EACH_LANE {
        log_force[b] = 1.2 * log(mass[b]);
        if (!(log_force[b] < law->highest)) log_force[b] = law->highest;
        active[b] = 1;
    }
    for (step = 0; some && step < MOST_STEPS; step++) {
        Lanes factor, shift = {0}, most = {0};
        Vector norm = {0}, eigenvalue = {0}, bends = {0};
        EACH_LANE factor[b] = -exp(log_force[b] * (POWER / 6));
        exponentiate(p, factor);
        for (i = 0; i < k; i++) EACH_LANE right[i][b] = masses[i][b] * vector[i][b];
        apply(p);
        for (i = 0; i < k; i++)
            EACH_LANE {
                const double ratio = image[i][b] / vector[i][b];
                shift[b] = ratio <= shift[b] ? shift[b] : ratio;
            }
        EACH_LANE shift[b] *= ABOVE;
        /* with y = roots x, the solution x of (shift - kernel masses) x = vector is (vector + kernel roots y) / shift */
        for (i = 0; i < k; i++) EACH_LANE right[i][b] = p->roots[i][b] * vector[i][b];
        solve(p, shift);
        for (i = 0; i < k; i++) EACH_LANE right[i][b] *= p->roots[i][b];
        apply(p);
        for (i = 0; i < k; i++)
            EACH_LANE {
                image[i][b] += vector[i][b];
                most[b] = image[i][b] <= most[b] ? most[b] : image[i][b];
            }
        for (i = 0; i < k; i++) {
            EACH_LANE {
                vector[i][b] = active[b] > 0 ? image[i][b] / most[b] : vector[i][b];
                right[i][b] = masses[i][b] * vector[i][b];
            }
            norm += VECTOR(right[i]) * VECTOR(vector[i]);
        }
        for (i = 0; i < k; i++) {
            const Vector own = VECTOR(right[i]);
            Vector row = {0}, bend = {0};
            for (j = i + 1; j < p->end[i]; j++) {
                const Vector part = VECTOR(p->kernel[i * k + j]) * VECTOR(right[j]);
                row += part;
                bend += VECTOR(p->apart[i * k + j]) * part;
            }
            eigenvalue += own * (own + 2 * row);
            bends += 2 * own * bend;
        }
        eigenvalue /= norm;
        some = 0;
        EACH_LANE
            if (active[b] > 0) {
                const double slope = bends[b] * (POWER * factor[b] / (norm[b] * eigenvalue[b]));
                const double change = (1.2 * log(eigenvalue[b]) - log_force[b]) / (1 - 0.2 * slope);
                log_force[b] += change;
                active[b] = !(fabs(change) < SETTLED && shift[b] < BOUND * eigenvalue[b]);
                some |= active[b] > 0;
            }
    }
    EACH_LANE if (active[b] > 0) log_force[b] = NAN;
}

/* The results of `columns`, from the eigenvectors; overwrites the other arrays but `times` and `impulses`. */
WIDE static void measure(const Law *law, Kernels *p, const double *log_force, Lanes *found)
{
    const long k = p->k;
    Lanes *const total = p->masses, *const before = p->roots, *const after = p->image, *const squared = p->right;
    Lanes *const apart = p->system, *const times = p->times, *const impulses = p->impulses, *const vector = p->vector;
    Lanes unit, strength, factor, weights = {0}, mean = {0};
    long i, j;
    int b, c;
    EACH_LANE {
        unit[b] = exp(log_force[b] / 6);
        strength[b] = law->peak * exp(log_force[b] * (-5.0 / 6));
        factor[b] = -1 / (law->reach * law->reach);
    }
    for (i = 0; i < k; i++) {
        EACH_LANE {
            weights[b] += impulses[i][b] * vector[i][b] * vector[i][b];
            total[i][b] = before[i][b] = after[i][b] = squared[i][b] = apart[i][b] = 0;
        }
        for (j = i; j < k; j++)
            EACH_LANE {
                const double off = (times[i][b] - times[j][b]) * unit[b];
                p->apart[i * k + j][b] = off * off;
            }
    }
    exponentiate(p, factor);
    for (i = 0; i < k; i++) {
        EACH_LANE total[i][b] += p->kernel[i * k + i][b] * strength[b] * impulses[i][b];
        for (j = i + 1; j < p->end[i]; j++)
            EACH_LANE {
                const double off = (times[j][b] - times[i][b]) * unit[b], root = sqrt(off);
                const double near = p->kernel[i * k + j][b] * strength[b];
                const double later = near * impulses[j][b], earlier = near * impulses[i][b];
                total[i][b] += later;
                total[j][b] += earlier;
                after[i][b] += later * off;
                before[j][b] += earlier * off;
                squared[i][b] += later * off * off;
                squared[j][b] += earlier * off * off;
                apart[i][b] += later * off * off * root;
                apart[j][b] += earlier * off * off * root;
            }
    }
    for (c = 0; c < COLUMNS; c++) EACH_LANE found[c][b] = 0;
    for (i = 0; i < k; i++)
        EACH_LANE {
            const double rise = before[i][b], decay = after[i][b], directed = rise - decay, square = squared[i][b];
            const double weight = impulses[i][b] * vector[i][b] * vector[i][b] / weights[b], share = total[i][b] - 1;
            mean[b] += weight * share;
            found[0][b] += weight * apart[i][b];
            found[1][b] += weight * rise * rise * sqrt(rise);
            found[2][b] += weight * decay * decay * sqrt(decay);
            found[3][b] += weight * rise * rise * rise * sqrt(rise);
            found[4][b] += weight * decay * decay * decay * sqrt(decay);
            found[5][b] += weight * directed * directed * directed;
            found[6][b] += weight * directed * square;
            found[7][b] += weight * directed * directed;
            found[8][b] += weight * square;
        }
    for (i = 0; i < k; i++)
        EACH_LANE {
            const double weight = impulses[i][b] * vector[i][b] * vector[i][b] / weights[b];
            found[10][b] += weight * (total[i][b] - 1 - mean[b]) * (total[i][b] - 1 - mean[b]);
        }
    EACH_LANE found[9][b] = mean[b];
}

/* Evaluate the law for at most as many pulses of k impulses as there are lanes. */
static void evaluate(const Law *law, const double *times, const double *impulses, long pulses, Kernels *p,
                     double *log_force, double *columns)
{
    const long k = p->k;
    Lanes logarithm, found[COLUMNS];
    long i;
    int b, c;
    EACH_LANE {
        const long row = b < pulses ? b : 0; /* lanes that are left over repeat the first pulse */
        for (i = 0; i < k; i++) {
            p->times[i][b] = times[row * k + i];
            p->impulses[i][b] = impulses[row * k + i];
        }
    }
    balance(law, p, logarithm);
    measure(law, p, logarithm, found);
    for (b = 0; b < pulses; b++) {
        log_force[b] = logarithm[b];
        for (c = 0; c < COLUMNS; c++) columns[b * COLUMNS + c] = found[c][b];
    }
}

/* ---------------------------------------------------------------- Python */

/* Contiguous buffers of float64 of `rows` rows each; `columns` has the length of a row, or 0 for any. The last
   `writable` are writable. Raises and returns 0 otherwise. */
static int buffers_of(PyObject *args, long rows, int count, int writable, long *columns, Py_buffer *views)
{
    const Py_ssize_t unit = (Py_ssize_t)sizeof(double);
    int i, ok = 1;
    for (i = 0; i < count; i++) {
        const int flags = PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (i >= count - writable ? PyBUF_WRITABLE : 0);
        if (PyObject_GetBuffer(PyTuple_GetItem(args, i), views + i, flags) < 0) break;
        ok = ok && views[i].format && !strcmp(views[i].format, "d") && rows > 0 && rows <= PY_SSIZE_T_MAX / unit
            && views[i].len % (rows * unit) == 0;
        if (ok && !columns[i]) columns[i] = (long)(views[i].len / (rows * unit));
        ok = ok && columns[i] > 0 && views[i].len == rows * unit * columns[i];
    }
    if (i == count && ok) return 1;
    if (i == count) PyErr_SetString(PyExc_ValueError, "buffers do not fit one another");
    while (i-- > 0) PyBuffer_Release(views + i);
    return 0;
}

PyDoc_STRVAR(gauss_doc, "gauss(times, impulses, instants, parts, rows)\n--\n\n"
             "Reduce pulses, one in each row, to fewer impulses. Returns whether this succeeded.");

static PyObject *gauss(PyObject *self, PyObject *args)
{
    PyObject *own[5];
    Py_buffer view[4];
    long columns[4] = {0}, rows, row;
    double *work;
    int i, ok = 1;
    (void)self;
    if (!PyArg_UnpackTuple(args, "gauss", 5, 5, own, own + 1, own + 2, own + 3, own + 4)) return NULL;
    rows = PyLong_AsLong(own[4]);
    if (rows == -1 && PyErr_Occurred()) return NULL;
    if (!buffers_of(args, rows, 4, 2, columns, view)) return NULL;
    if (columns[0] != columns[1] || columns[2] != columns[3]) {
        for (i = 0; i < 4; i++) PyBuffer_Release(view + i);
        return PyErr_Format(PyExc_ValueError, "buffers do not fit one another");
    }
    work = malloc((size_t)(5 * PADDED(columns[0]) + 3 * LANES * columns[2]) * sizeof(double));
    if (work) {
        Py_BEGIN_ALLOW_THREADS
        for (row = 0; row < rows; row += LANES)
            ok &= reduce((double *)view[0].buf + row * columns[0], (double *)view[1].buf + row * columns[0], columns[0],
                         (double *)view[2].buf + row * columns[2], (double *)view[3].buf + row * columns[2], columns[2],
                         rows - row < LANES ? rows - row : LANES, work);
        Py_END_ALLOW_THREADS
    }
    for (i = 0; i < 4; i++) PyBuffer_Release(view + i);
    free(work);
    return work ? PyBool_FromLong(ok) : PyErr_NoMemory();
}

PyDoc_STRVAR(law_doc, "law(times, impulses, log_force, columns, rows, width, reach, peak, step_limit)\n--\n\n"
             "Evaluate the kernel and the local measures of pulses, one in each row. The results of a pulse for which the\n"
             "iteration does not converge are NaN.");

static PyObject *law_of(PyObject *self, PyObject *args)
{
    PyObject *own[9];
    Py_buffer view[4];
    long columns[4] = {0, 0, 1, COLUMNS}, rows, row, k, *ends;
    double number[4];
    void *memory;
    int i;
    (void)self;
    if (!PyArg_UnpackTuple(args, "law", 9, 9, own, own + 1, own + 2, own + 3, own + 4, own + 5, own + 6, own + 7, own + 8))
        return NULL;
    rows = PyLong_AsLong(own[4]);
    for (i = 0; i < 4; i++) number[i] = PyFloat_AsDouble(own[5 + i]);
    if (PyErr_Occurred() || !buffers_of(args, rows, 4, 2, columns, view)) return NULL;
    k = columns[0];
    if (columns[1] != k) {
        for (i = 0; i < 4; i++) PyBuffer_Release(view + i);
        return PyErr_Format(PyExc_ValueError, "buffers do not fit one another");
    }
    memory = malloc((size_t)(MATRICES * k * k + VECTORS * k + 1) * sizeof(Lanes));
    ends = malloc((size_t)k * sizeof *ends);
    if (memory && ends) {
        const Law law = {number[0], number[1], number[2], log(number[3])};
        /* aligned, so that no vector crosses a line of the cache */
        Lanes *const matrices = (Lanes *)(((uintptr_t)memory / sizeof(Lanes) + 1) * sizeof(Lanes));
        Lanes *const vectors = matrices + MATRICES * k * k;
        Kernels p = {k, ends, matrices, matrices + k * k, matrices + 2 * k * k, vectors, vectors + k, vectors + 2 * k,
                     vectors + 3 * k, vectors + 4 * k, vectors + 5 * k, vectors + 6 * k};
        Py_BEGIN_ALLOW_THREADS
        for (row = 0; row < rows; row += LANES)
            evaluate(&law, (double *)view[0].buf + row * k, (double *)view[1].buf + row * k,
                     rows - row < LANES ? rows - row : LANES, &p, (double *)view[2].buf + row,
                     (double *)view[3].buf + row * COLUMNS);
        Py_END_ALLOW_THREADS
    }
    for (i = 0; i < 4; i++) PyBuffer_Release(view + i);
    free(memory);
    free(ends);
    if (!memory || !ends) return PyErr_NoMemory();
    Py_RETURN_NONE;
}

static PyMethodDef functions[] = {
    {"gauss", gauss, METH_VARARGS, gauss_doc},
    {"law", law_of, METH_VARARGS, law_doc},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT, "_moments", "Compiled law of moments.", 0, functions, NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__moments(void)
{
    return PyModuleDef_Init(&module);
}
