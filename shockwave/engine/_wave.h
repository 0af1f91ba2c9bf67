/* Momentum, energy, width and speed of a wave at a contact. */

/* Columns of the data of a wave; see wave_properties.py. */
enum { AFTER, BEFORE, ARRIVAL, HEIGHT, WAVE_MOMENTUM, WAVE_ENERGY, WAVE_WIDTH, FASTEST, WAVE_FOOT, WAVE };

#define NODES 8        /* Gauss nodes of a step */
#define NEIGHBOURS 4   /* number of samples on each side of a crossing that its polynomial interpolates */
#define TURNS 3        /* number of Newton steps to a maximum of the velocity */
#define EDGE 0.1       /* how far it may be from its step, over the size of the step */

static const double node[NODES] = {0.019855071751231912, 0.10166676129318664, 0.2372337950418355, 0.4082826787521751,
                                   0.5917173212478248, 0.7627662049581645, 0.8983332387068134, 0.9801449282487681};
static const double node_weight[NODES] = {0.05061426814518853, 0.11119051722668721, 0.15685332293894344, 0.18134189168918083,
                                          0.18134189168918083, 0.15685332293894344, 0.11119051722668721, 0.05061426814518853};

/* Motion of the contact between the second and third of four granules, with the state x, v at the end of a step: the
   overlap, and the position of the third granule from `origin`, each with three derivatives. */
static void contact_jets(const double *x, const double *v, double origin, double *overlap, double *position)
{
    double force[3], rate[3];
    int i;
    for (i = 0; i < 3; i++) {
        const double d = x[i] - x[i + 1], root = d > 0 ? sqrt(d) : 0;
        force[i] = root * d;
        rate[i] = 1.5 * root * (v[i] - v[i + 1]);
    }
    overlap[0] = x[1] - x[2];
    overlap[1] = v[1] - v[2];
    overlap[2] = force[0] - 2 * force[1] + force[2];
    overlap[3] = rate[0] - 2 * rate[1] + rate[2];
    position[0] = x[2] - origin;
    position[1] = v[2];
    position[2] = force[1] - force[2];
    position[3] = rate[1] - rate[2];
}

/* Time at which the force passes `level` upwards between samples `from` and `to`, in this direction of time, by inverse
   interpolation. */
static double level_time(const double *time, const double *force, long from, long to, double level)
{
    const long way = to < from ? -1 : 1, count = way * (to - from) + 1;
    long last = count, i, j, begin, end;
    double sum = 0;
    while (last > 0 && !(force[from + way * (last - 1)] < level)) last--;
    if (last == 0 || last == count) return time[from]; /* the force jumps across the level between two samples */
    begin = last > NEIGHBOURS ? last - NEIGHBOURS : 0;
    end = last + NEIGHBOURS < count ? last + NEIGHBOURS : count;
    for (i = begin; i < end; i++) {
        const double own = force[from + way * i];
        double product = 1;
        for (j = begin; j < end; j++) {
            const double other = force[from + way * j];
            if (other != own) product *= (level - other) / (own - other);
        }
        sum += (time[from + way * i] - time[from + way * last]) * product;
    }
    return time[from + way * last] + sum;
}

/* Maximum of the rate of change of the polynomial p near `share` of a step; 0 if it is outside. */
static double greatest_slope(const double *p, double share)
{
    double value, slope = 0, bend, curve;
    int turn, j;
    for (turn = 0; turn < TURNS; turn++) {
        for (value = slope = bend = curve = 0, j = 7; j >= 0; j--) {
            curve = curve * share + bend;
            bend = bend * share + slope;
            slope = slope * share + value;
            value = value * share + p[j];
        }
        if (!(curve < 0)) break;
        share -= bend / (3 * curve);
    }
    return share > -EDGE && share < 1 + EDGE ? slope : 0;
}

/* Measures a wave between the force minima around its peak, from `count` states of four granules at the ends of steps.
   Returns 0 without memory. */
static int read_wave(const double *times, const double *x, const double *v, long count, double *wave)
{
    const long samples = NODES * (count - 1);
    double *const time = malloc(4 * (size_t)samples * sizeof(double)), *force, *velocity, *weight;
    double last[8], next[8], p[8], q[8], momentum = 0, energy = 0;
    long i, j, k, top = 0, left = 0, right = 0, begin, end, fastest;
    if (!time) return 0;
    force = time + samples;
    velocity = force + samples;
    weight = velocity + samples;
    contact_jets(x, v, x[2], last, last + 4);
    for (i = 0; i + 1 < count; i++) {
        const double size = times[i + 1] - times[i];
        contact_jets(x + 4 * (i + 1), v + 4 * (i + 1), x[4 * i + 2], next, next + 4);
        last[4] = 0;
        powers_between(last, next, size, p);
        powers_between(last + 4, next + 4, size, q);
        for (k = 0; k < NODES; k++) {
            double overlap = p[7], slope = 7 * q[7];
            for (j = 6; j >= 0; j--) overlap = overlap * node[k] + p[j];
            for (j = 6; j >= 1; j--) slope = slope * node[k] + (double)j * q[j];
            time[NODES * i + k] = times[i] + size * node[k];
            force[NODES * i + k] = overlap > 0 ? overlap * sqrt(overlap) : 0;
            velocity[NODES * i + k] = slope / size;
            weight[NODES * i + k] = size * node_weight[k];
        }
        memcpy(last, next, sizeof last);
    }
    for (i = 1; i < samples; i++) if (fabs(time[i] - wave[ARRIVAL]) < fabs(time[top] - wave[ARRIVAL])) top = i;
    while (left < top && time[left] < wave[AFTER]) left++;
    while (right < samples && time[right] < wave[BEFORE]) right++;
    for (begin = left, i = left + 1; i <= top; i++) if (force[i] < force[begin]) begin = i;
    for (end = top, i = top + 1; i < right; i++) if (force[i] < force[end]) end = i;
    for (fastest = i = begin; i <= end; i++) {
        momentum += weight[i] * force[i];
        energy += weight[i] * force[i] * velocity[i];
        if (velocity[i] > velocity[fastest]) fastest = i;
    }
    wave[WAVE_MOMENTUM] = momentum;
    wave[WAVE_ENERGY] = energy;
    wave[WAVE_WIDTH] = level_time(time, force, end, top, wave[HEIGHT] / 2) - level_time(time, force, begin, top, wave[HEIGHT] / 2);
    wave[WAVE_FOOT] = (force[begin] > force[end] ? force[begin] : force[end]) / wave[HEIGHT];
    i = fastest / NODES;
    contact_jets(x + 4 * i, v + 4 * i, x[4 * i + 2], last, last + 4);
    contact_jets(x + 4 * (i + 1), v + 4 * (i + 1), x[4 * i + 2], next, next + 4);
    powers_between(last + 4, next + 4, times[i + 1] - times[i], q);
    wave[FASTEST] = greatest_slope(q, node[fastest % NODES]) / (times[i + 1] - times[i]);
    if (velocity[fastest] > wave[FASTEST]) wave[FASTEST] = velocity[fastest];
    free(time);
    return 1;
}
