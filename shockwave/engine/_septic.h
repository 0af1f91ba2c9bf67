/* Polynomial of degree 7 in the fraction of a step of size h, lowest power first, through value and three derivatives at
   both ends. */
static void powers_between(const double *begin, const double *end, double h, double *p)
{
    static const double powers[4][8] = {{-35, -20, -10, -4, 35, -15, 5, -1}, {84, 45, 20, 6, -84, 39, -14, 3},
                                        {-70, -36, -15, -4, 70, -34, 13, -3}, {20, 10, 4, 1, -20, 10, -4, 1}};
    const double *ends[] = {begin, end};
    double known[8];
    int i, j;
    for (i = 0; i < 2; i++)
        for (j = 0; j < 4; j++) known[4 * i + j] = ends[i][j] * (j == 0 ? 1 : j == 1 ? h : j == 2 ? h * h / 2 : h * h * h / 6);
    for (j = 0; j < 4; j++) p[j] = known[j];
    for (j = 4; j < 8; j++)
        for (p[j] = 0, i = 0; i < 8; i++) p[j] += powers[j - 4][i] * known[i];
}
