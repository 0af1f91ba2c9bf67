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
#include <stdlib.h>
#include <string.h>

/* Compiled for several vector widths; the loader selects the widest that the processor supports. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define WIDE
#endif

#define BLOCK 32         /* partial sums of a long sum, so many that additions need not wait for one another; arrays are
                            padded with zeros to a multiple */
#define PADDED(n) (((n) + BLOCK - 1) / BLOCK * BLOCK)

/* Several numbers as one value: a vector of the widest processors, and half of one. */
#define LANES (BLOCK / 4)
typedef double Wide __attribute__((vector_size(LANES * sizeof(double)), aligned(sizeof(double)), may_alias));
#define HALF (LANES / 2)
typedef double Vector __attribute__((vector_size(HALF * sizeof(double)), aligned(sizeof(double)), may_alias));
typedef long long Whole __attribute__((vector_size(HALF * sizeof(double)), aligned(sizeof(double)), may_alias));
#define VECTOR(address) (*(Vector *)(address))
#define CHOICE(mask, yes, no) ((Vector)(((Whole)(yes) & (mask)) | ((Whole)(no) & ~(mask))))

/* See gauss_impulses.py and moments.py for the meaning of the constants of the same names. */
#define STABLE 32
#define ORTHOGONAL 32
#define ROUNDING 1e-14
#define MOST_STEPS 60
#define SETTLED 1e-9
#define ABOVE (1 + 1e-9)
#define POWER 2.5
#define COLUMNS 11
#define MOST_TURNS 100   /* largest number of QL iterations for an eigenvalue; two or three suffice */

/* ---------------------------------------------------------------- a pulse as a few impulses */

/* Sum of the products of two arrays of padded length. */
WIDE static double dot(const double *one, const double *other, long n)
{
    const Wide *const a = (const Wide *)one, *const b = (const Wide *)other;
    Wide sum = {0}, second = sum, third = sum, fourth = sum;
    long i;
    for (i = 0; i < n / LANES; i += 4) {
        sum += a[i] * b[i];
        second += a[i + 1] * b[i + 1];
        third += a[i + 2] * b[i + 2];
        fourth += a[i + 3] * b[i + 3];
    }
    sum = (sum + second) + (third + fourth);
    return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

WIDE static void subtract(double *from, double factor, const double *values, long n)
{
    long i;
    for (i = 0; i < n; i++) from[i] -= factor * values[i];
}

WIDE static void scale_by(double *values, double factor, long n)
{
    long i;
    for (i = 0; i < n; i++) values[i] *= factor;
}

/* The next vector of Lanczos' recurrence before it is normalised; returns the diagonal element. */
WIDE static double follow(const double *position, const double *vector, const double *last, double beside, double *next,
                          long n)
{
    double diagonal;
    long i;
    for (i = 0; i < n; i++) next[i] = position[i] * vector[i];
    diagonal = dot(vector, next, n);
    for (i = 0; i < n; i++) next[i] = next[i] - diagonal * vector[i] - beside * last[i];
    return diagonal;
}

/* Numbers of four matrices, one in each lane. */
typedef double Lanes[HALF];

/* Rows `last` - 1 to l of the matrices in a QL iteration, in four lanes, in each of them from row m - 1 on. A lane in which
   the matrix falls into two parts stops: its m becomes l. */
WIDE static void iterate(long l, long last, Lanes *d, Lanes *e, Lanes *first, long long *m, double *p, double *g)
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
        for (b = 0; b < HALF; b++) root[b] = sqrt(square[b]);
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
    for (b = 0; b < HALF; b++) {
        first[0][b] = 1;
        e[n - 1][b] = 0;
    }
    for (l = 0; l < n; l++)
        for (turn = 0;; turn++) {
            Lanes p, g;
            long long m[HALF];
            long end[HALF], last = l;
            for (b = 0; b < HALF; b++) {
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
            for (b = 0; b < HALF; b++) {
                if (m[b] > l) {
                    d[l][b] -= p[b];
                    e[l][b] = g[b];
                }
                if (end[b] > l) e[end[b]][b] = 0;
            }
        }
    for (b = 0; b < HALF; b++)
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

/* Number of vectors that the recurrence needs: all if earlier ones are used again, otherwise three. */
static long vectors_of(long count) { return count > STABLE ? count + 2 : 3; }

/* Matrices of the pulses in the lanes, with mean and scale of their times and their total impulses. */
typedef struct {
    Lanes *diagonal, *beside, *first, mean, scale, total;
} Reduced;

/* Lanczos' recurrence for one pulse of `points` impulses: the matrix of `count` rows in lane b. `work` has room for two
   vectors of padded length and those of the recurrence. */
WIDE static void recur(const double *times, const double *impulses, long points, long count, int b, Reduced *to, double *work)
{
    const long n = PADDED(points);
    double *const position = work, *const weight = work + n, *const base = work + 2 * n;
    double *vector = base + n, *last = base, *next, total, mean, scale = 0, step = 0;
    long i, row;
    memset(work, 0, (size_t)(4 * n) * sizeof(double));
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
        next = count > STABLE ? vector + n : base + (row + 2) % 3 * n;
        to->diagonal[row][b] = follow(position, vector, last, step, next, n);
        if (count > STABLE && row % ORTHOGONAL < 2)
            for (i = row; i >= 0; i--) {
                const double *const earlier = base + (i + 1) * n;
                subtract(next, dot(earlier, next, n), earlier, n);
            }
        to->beside[row][b] = step = sqrt(dot(next, next, n));
        scale_by(next, 1 / (step > ROUNDING ? step : ROUNDING), n);
        last = vector;
        vector = next;
    }
    to->mean[b] = mean;
    to->scale[b] = scale;
    to->total[b] = total;
}

/* `gauss` for at most four pulses. `work` has also room for three matrices of `count` rows of four numbers. */
static int reduce(const double *times, const double *impulses, long points, double *instants, double *parts, long count,
                  long pulses, double *work)
{
    Lanes *const matrices = (Lanes *)work;
    Reduced found = {matrices, matrices + count, matrices + 2 * count, {0}, {0}, {0}};
    long i;
    int b;
    memset(work, 0, (size_t)(3 * count) * sizeof *matrices);
    for (b = 0; b < pulses; b++)
        recur(times + b * points, impulses + b * points, points, count, b, &found, work + 3 * count * HALF);
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

/* One pulse of k impulses in the notation of `kernel_force`; square matrices, row by row. Row i of the kernel has values
   from column first[i] to before column last[i], which both increase with i; elsewhere it is negligible. */
typedef struct {
    long k, *first, *last;
    double *apart, *kernel, *system, *masses, *roots, *vector, *image, *right;
} Kernel;

#define LOG2_E 1.4426950408889634
#define LN2_HIGH 6.93147180369123816490e-01 /* so many digits that its products with whole numbers are exact */
#define LN2_LOW 1.90821492927058770002e-10
#define SHIFT 6755399441055744.0             /* 1.5 * 2^52: a sum with it is rounded to a whole number */
#define LEAST (-708.0)                       /* smaller exponents count as this one, for which the exponential is 3e-308 */
#define NEGLIGIBLE (-50.0)                   /* an element of the kernel is 2e-22 then, and 1 on the diagonal */

/* Replaces n values of at most zero by their exponentials, to a unit in the last place. The function of the C library
   takes several times as long, and its last digit depends on the processor. */
WIDE static void exponentials(double *values, long n)
{
    static const double factors[] = {1 / 6227020800.0, 1 / 479001600.0, 1 / 39916800.0, 1 / 3628800.0, 1 / 362880.0,
                                     1 / 40320.0, 1 / 5040.0, 1 / 720.0, 1 / 120.0, 1 / 24.0, 1 / 6.0, 0.5, 1, 1};
    const Vector zero = {0}, least = zero + LEAST, shift = zero + SHIFT;
    const Whole bias = (Whole)shift - 1023;
    double rest[HALF] = {0};
    long e;
    int i;
    for (e = 0; e < n; e += HALF) {
        const size_t open = (size_t)(n - e) * sizeof(double);
        double *const at = open < sizeof rest ? memcpy(rest, values + e, open) : values + e;
        const Vector given = VECTOR(at);
        const Whole small = given < least;
        const Vector x = (Vector)(((Whole)least & small) | ((Whole)given & ~small));
        const Vector shifted = x * LOG2_E + shift, whole = shifted - shift;
        const Vector left = (x - whole * LN2_HIGH) - whole * LN2_LOW;
        const Whole power = ((Whole)shifted - bias) << 52;
        Vector sum = zero + factors[0];
        for (i = 1; i < 14; i++) sum = sum * left + factors[i];
        VECTOR(at) = sum * (Vector)power;
        if (at == rest) memcpy(values + e, rest, open);
    }
}

/* The kernel: exponentials of `factor`, which is negative, times `apart`, where these are not negligible. */
static void exponentiate(Kernel *p, double factor)
{
    const long k = p->k;
    long i, j, begin = 0, end = 0;
    for (i = 0; i < k; i++) {
        const long from = i - i % HALF; /* whole vectors */
        double *const row = p->kernel + i * k;
        while (end < k && !(p->apart[i * k + end] * factor < NEGLIGIBLE)) end++;
        p->last[i] = end;
        while (p->last[begin] <= i) begin++;
        p->first[i] = begin;
        for (j = from; j < end; j++) row[j] = p->apart[i * k + j] * factor;
        exponentials(row + from, end - from);
    }
    for (i = 0; i < k; i++)
        for (j = i + 1; j < p->last[i]; j++) p->kernel[j * k + i] = p->kernel[i * k + j];
}

static double total_mass(const double *values, long k)
{
    double sum = 0;
    long i;
    for (i = 0; i < k; i++) sum += values[i];
    return sum;
}

/* The image of the right side by the kernel. The matrix is symmetric, so that its rows serve as columns. */
WIDE static void apply(Kernel *p)
{
    const long k = p->k;
    double *const image = p->image;
    long i, j;
    for (i = 0; i < k; i++) image[i] = 0;
    for (j = 0; j < k; j++)
        for (i = p->first[j]; i < p->last[j]; i++) image[i] += p->kernel[j * k + i] * p->right[j];
}

/* Solves the system of shift - roots_i kernel_ij roots_j for `right`, by elimination. There is no pivoting and no
   cancellation except on the diagonal, because all other elements are negative. */
WIDE static void solve(Kernel *p, double shift)
{
    const long k = p->k, row = k + HALF, *const last = p->last;
    double *const a = p->system, *const x = p->right;
    long i, j, m;
    for (i = 0; i < k; i++) {
        for (j = i; j < last[i]; j++) a[i * row + j] = -p->kernel[i * k + j] * p->roots[i] * p->roots[j];
        for (j = last[i]; j < last[i] + HALF; j++) a[i * row + j] = 0; /* so that all vectors are whole */
        a[i * row + i] += shift;
    }
    for (m = 0; m < k; m++)
        for (i = m + 1; i < last[m]; i++) {
            const double factor = a[m * row + i] / a[m * row + m];
            for (j = i; j < last[m]; j += HALF) VECTOR(a + i * row + j) -= factor * VECTOR(a + m * row + j);
            x[i] -= factor * x[m];
        }
    for (m = k - 1; m >= 0; m--) {
        for (i = m + 1; i < last[m]; i++) x[m] -= a[m * row + i] * x[i];
        x[m] /= a[m * row + m];
    }
}

/* `kernel_force` for one pulse; returns 0 if the iteration does not converge. It starts from `log_force` and the present
   vector if the last pulse was `similar`. */
static int balance(const Law *law, const double *times, const double *impulses, int similar, Kernel *p, double *log_force)
{
    const long k = p->k;
    double force;
    long i, j;
    int step;
    for (i = 0; i < k; i++) {
        p->masses[i] = law->peak * impulses[i];
        p->roots[i] = sqrt(p->masses[i]);
        if (!similar) p->vector[i] = 1;
        for (j = i - i % HALF; j < k; j++) { /* only these are used */
            const double apart = fabs(times[i] - times[j]) / law->width;
            p->apart[i * k + j] = apart * apart * sqrt(apart);
        }
    }
    force = 1.2 * log(total_mass(p->masses, k));
    if (!(force < law->highest)) force = law->highest;
    if (similar) force = *log_force;
    for (step = 0; step < MOST_STEPS; step++) {
        const double growth = exp(force * (POWER / 6));
        double shift = 0, most = 0, norm = 0, value = 0, slope = 0, change;
        exponentiate(p, -growth);
        for (i = 0; i < k; i++) p->right[i] = p->masses[i] * p->vector[i];
        apply(p);
        for (i = 0; i < k; i++) {
            const double ratio = p->image[i] / p->vector[i];
            if (!(ratio <= shift)) shift = ratio;
        }
        shift *= ABOVE;
        /* with y = roots x, the solution x of (shift - kernel masses) x = vector is (vector + kernel roots y) / shift */
        for (i = 0; i < k; i++) p->right[i] = p->roots[i] * p->vector[i];
        solve(p, shift);
        for (i = 0; i < k; i++) p->right[i] *= p->roots[i];
        apply(p);
        for (i = 0; i < k; i++) {
            p->vector[i] += p->image[i];
            if (!(p->vector[i] <= most)) most = p->vector[i];
        }
        for (i = 0; i < k; i++) {
            p->vector[i] /= most;
            p->right[i] = p->masses[i] * p->vector[i];
            norm += p->right[i] * p->vector[i];
        }
        for (i = 0; i < k; i++) {
            double row = 0, bent = 0;
            for (j = i + 1; j < p->last[i]; j++) {
                const double part = p->kernel[i * k + j] * p->right[j];
                row += part;
                bent += p->apart[i * k + j] * part;
            }
            value += p->right[i] * (p->right[i] + 2 * row);
            slope += 2 * p->right[i] * bent;
        }
        value /= norm;
        slope *= -POWER * growth / (norm * value);
        change = (1.2 * log(value) - force) / (1 - 0.2 * slope);
        force += change;
        if (fabs(change) < SETTLED) {
            *log_force = force;
            return 1;
        }
    }
    return 0;
}

/* `columns` for one pulse. */
static void measure(const Law *law, const double *times, const double *impulses, Kernel *p, double log_force, double *found)
{
    const long k = p->k;
    const double unit = exp(log_force / 6), strength = law->peak * exp(log_force * (-5.0 / 6)), reach = law->reach;
    double whole = 0, mean = 0;
    long i, j;
    int c;
    for (i = 0; i < k; i++) whole += impulses[i] * p->vector[i] * p->vector[i];
    for (i = 0; i < k; i++)
        for (j = i - i % HALF; j < k; j++) {
            const double off = (times[i] - times[j]) * unit;
            p->apart[i * k + j] = off * off;
        }
    exponentiate(p, -1 / (reach * reach));
    for (c = 0; c < COLUMNS; c++) found[c] = 0;
    for (i = 0; i < k; i++) {
        double total = 0, before = 0, after = 0, squared = 0, apart = 0, directed, weight, share;
        for (j = p->first[i]; j < p->last[i]; j++) {
            const double off = (times[i] - times[j]) * unit, size = fabs(off);
            const double near = p->kernel[i * k + j] * strength * impulses[j];
            total += near;
            if (off > 0) before += near * size; else after += near * size;
            squared += near * off * off;
            apart += near * off * off * sqrt(size);
        }
        directed = before - after;
        weight = impulses[i] * p->vector[i] * p->vector[i] / whole;
        share = p->image[i] = total - 1;
        p->right[i] = weight;
        mean += weight * share;
        found[0] += weight * apart;
        found[1] += weight * before * before * sqrt(before);
        found[2] += weight * after * after * sqrt(after);
        found[3] += weight * before * before * before * sqrt(before);
        found[4] += weight * after * after * after * sqrt(after);
        found[5] += weight * directed * directed * directed;
        found[6] += weight * directed * squared;
        found[7] += weight * directed * directed;
        found[8] += weight * squared;
    }
    found[9] = mean;
    for (i = 0; i < k; i++) found[10] += p->right[i] * (p->image[i] - mean) * (p->image[i] - mean);
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
    work = malloc((size_t)(PADDED(columns[0]) * (vectors_of(columns[2]) + 2) + 3 * HALF * columns[2]) * sizeof(double));
    if (work) {
        Py_BEGIN_ALLOW_THREADS
        for (row = 0; row < rows; row += HALF)
            ok &= reduce((double *)view[0].buf + row * columns[0], (double *)view[1].buf + row * columns[0], columns[0],
                         (double *)view[2].buf + row * columns[2], (double *)view[3].buf + row * columns[2], columns[2],
                         rows - row < HALF ? rows - row : HALF, work);
        Py_END_ALLOW_THREADS
    }
    for (i = 0; i < 4; i++) PyBuffer_Release(view + i);
    free(work);
    return work ? PyBool_FromLong(ok) : PyErr_NoMemory();
}

PyDoc_STRVAR(law_doc, "law(times, impulses, log_force, columns, rows, width, reach, peak, step_limit, similar)\n--\n\n"
             "Evaluate the kernel and the local measures of pulses, one in each row; each is similar to the one before if\n"
             "`similar` is true. The results of a pulse for which the iteration does not converge are NaN.");

static PyObject *law_of(PyObject *self, PyObject *args)
{
    PyObject *own[10];
    Py_buffer view[4];
    long columns[4] = {0, 0, 1, COLUMNS}, rows, row, k, square, *ends;
    double number[4], *work;
    int i, similar, done;
    (void)self;
    if (!PyArg_UnpackTuple(args, "law", 10, 10, own, own + 1, own + 2, own + 3, own + 4, own + 5, own + 6, own + 7, own + 8,
                           own + 9))
        return NULL;
    similar = PyObject_IsTrue(own[9]);
    rows = PyLong_AsLong(own[4]);
    for (i = 0; i < 4; i++) number[i] = PyFloat_AsDouble(own[5 + i]);
    if (PyErr_Occurred() || !buffers_of(args, rows, 4, 2, columns, view)) return NULL;
    k = columns[0];
    if (columns[1] != k) {
        for (i = 0; i < 4; i++) PyBuffer_Release(view + i);
        return PyErr_Format(PyExc_ValueError, "buffers do not fit one another");
    }
    square = k * k;
    work = calloc((size_t)(3 * square + (HALF + 5) * k), sizeof(double));
    ends = calloc((size_t)(2 * k), sizeof(long));
    if (work && ends) {
        const Law law = {number[0], number[1], number[2], log(number[3])};
        double *const vectors = work + 3 * square + HALF * k;
        Kernel p = {k, ends, ends + k, work, work + square, work + 2 * square, vectors, vectors + k, vectors + 2 * k,
                    vectors + 3 * k, vectors + 4 * k};
        Py_BEGIN_ALLOW_THREADS
        for (row = 0; row < rows; row++) {
            const double *const times = (double *)view[0].buf + row * k, *const impulses = (double *)view[1].buf + row * k;
            double *const force = (double *)view[2].buf + row;
            if (similar && row) *force = force[-1];
            double *const found = (double *)view[3].buf + row * COLUMNS;
            if (balance(&law, times, impulses, similar && row, &p, force)) measure(&law, times, impulses, &p, *force, found);
            else {
                *force = NAN;
                for (i = 0; i < COLUMNS; i++) found[i] = NAN;
            }
        }
        Py_END_ALLOW_THREADS
    }
    for (i = 0; i < 4; i++) PyBuffer_Release(view + i);
    done = work && ends;
    free(work);
    free(ends);
    if (!done) return PyErr_NoMemory();
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
