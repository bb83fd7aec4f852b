/* Which pixels of a row have base samples in a visit. */
#include "render/rows/visit_steps.h"

static int gcd(int a, int b)
{
    return b ? gcd(b, a % b) : a;
}

int lf_lattice_step(int n)
{
    int step = (int)(0.381966 * n);
    while (gcd(step, n) != 1)
        step++;
    return step;
}

int lf_lattice_inverse(int step, int n)
{
    int inverse = 1;
    while ((int64_t)step * inverse % n != 1 % n)
        inverse++;
    return inverse;
}

bool lf_lattice_has(const lf_visit *visit, int view, int column)
{
    for (int j = 0; j < visit->subsets; j++)
        if (lf_visit_lattice_view(&visit->lattice, column, j) == view)
            return true;
    return false;
}
