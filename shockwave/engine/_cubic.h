/* Cubic interpolation: the algorithms of cubic_interpolation.py. */

/* Root in (0, 1) of the cubic with values y0, y1 of opposite signs and slopes b0, b1 at 0 and 1, from that of a parabola. */
static double root_of(double y0, double b0, double y1, double b1)
{
    const double c = 3 * (y1 - y0) - 2 * b0 - b1, e = b0 + b1 - 2 * (y1 - y0);
    double at = 2 * y0 / (copysign(sqrt((b0 + 2 * y0) * (b0 + 2 * y0) - 4 * y0 * y1), y0) - b0);
    int i;
    for (i = 0; i < 3; i++) at -= (y0 + at * (b0 + at * (c + at * e))) / (b0 + at * (2 * c + at * 3 * e));
    return at > 0 && at < 1 ? at : y0 / (y0 - y1);
}

/* Position of the maximum in (0, 1) of a cubic that rises by `rise`, with slopes r0 > 0 and r1 <= 0 at its ends. */
static double top_of(double r0, double r1, double rise)
{
    const double at = root_of(r0, 6 * rise - 4 * r0 - 2 * r1, r1, 2 * r0 + 4 * r1 - 6 * rise);
    return at < 1 ? at : 0.5;
}
