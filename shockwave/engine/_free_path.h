/* Free-particle displacement and impulse, from the table of free_path.py. */

#include <math.h>

#define ROW 8 /* columns of a piece of the table */

typedef struct {
    const double *rows, *coefficients;
    long pieces, at;
    double rise_time, force;
} Path;

/* Displacement and impulse at time t: a Chebyshev series (Clenshaw) and a power on each piece. */
static void free_path(Path *path, double t, double *g, double *impulse)
{
    double s = t / path->rise_time, z, b1 = 0, b2 = 0, d1 = 0, d2 = 0, next;
    const double *row, *c;
    long k = path->at, low, high, i;

    if (s < path->rows[ROW * k] || (k + 1 < path->pieces && s >= path->rows[ROW * (k + 1)])) {
        for (low = 0, high = path->pieces; high - low > 1;) {
            k = (low + high) / 2;
            if (s >= path->rows[ROW * k]) low = k; else high = k;
        }
        path->at = k = low;
    }
    row = path->rows + ROW * k;
    c = path->coefficients + 2 * (long)row[2];
    z = ((s - row[0]) - (row[1] - s)) / (row[1] - row[0]);
    for (i = (long)row[3] - 1; i > 0; i--) {
        next = c[2 * i] + 2 * z * b1 - b2;
        b2 = b1; b1 = next;
        next = c[2 * i + 1] + 2 * z * d1 - d2;
        d2 = d1; d1 = next;
    }
    if (row[3] > 0) {
        b1 = c[0] + z * b1 - b2;
        d1 = c[1] + z * d1 - d2;
    }
    if (row[4] != 0) {
        const double u = fabs(s - row[6]) / row[7], power = row[4] * pow(u, row[5] - 1);
        b1 += power * u;
        d1 += (row[6] <= row[0] ? power : -power) * row[5] / row[7];
    }
    *g = path->force * path->rise_time * path->rise_time * b1;
    *impulse = path->force * path->rise_time * d1;
}

/* Whether `count` pieces from `first` are in the table, buffer `rows`, and their series, of which the first begins at
   `offset`, in the following buffer of coefficients. */
static int pieces_fit(const Buffers *all, int rows, double first, double count, double offset)
{
    const Py_ssize_t pieces = all->size[rows] / ROW, terms = all->size[rows + 1] / 2;
    Py_ssize_t k;
    if (all->size[rows] % ROW || all->size[rows + 1] % 2) return 0;
    if (!(first >= 0 && count >= 1 && first + count <= (double)pieces && offset >= 0)) return 0;
    for (k = 0; k < (Py_ssize_t)count; k++) {
        const double *row = (double *)all->view[rows].buf + ROW * ((Py_ssize_t)first + k);
        if (!(row[2] >= 0 && row[3] >= 0 && offset + row[2] + row[3] <= (double)terms)) return 0;
    }
    return 1;
}
