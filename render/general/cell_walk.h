/* Regular tracking: the cells of a regular grid along a ray, one after the other (Amanatides and
 * Woo 1987); private to render/. Coordinates are the grid's own: cells are unit cubes, the first
 * begins at 0. */
#ifndef LF_RENDER_CELL_WALK_H
#define LF_RENDER_CELL_WALK_H

#include <math.h>
#include <stdbool.h>

typedef struct lf_cell_walk {
    double t, end;    /* where the next cell is entered, and where the way ends */
    double next[3];   /* where the next cell along each axis is entered … */
    double stride[3]; /* … and the one behind that, from there */
    int cell[3], step[3], n[3];
} lf_cell_walk;

/* One cell's part of the ray. */
typedef struct lf_cell_part {
    double from, to;
    int cell[3];
} lf_cell_part;

/* Of the ray o + t w, 0 <= t <= end (which may be infinite), through n cells an axis; w need not be
 * unit. false: it passes by. */
static inline bool lf_cell_walk_init(lf_cell_walk *walk, const int n[3], const double o[3],
                                     const double w[3], double end)
{
    double t0 = 0.0, t1 = end;
    for (int i = 0; i < 3; i++) {
        double a = -o[i] / w[i], b = ((double)n[i] - o[i]) / w[i];
        if (w[i] == 0.0 && !(o[i] >= 0.0 && o[i] < (double)n[i]))
            return false;
        t0 = w[i] == 0.0 ? t0 : fmax(t0, fmin(a, b));
        t1 = w[i] == 0.0 ? t1 : fmin(t1, fmax(a, b));
    }
    if (!(t0 < t1))
        return false;
    for (int i = 0; i < 3; i++) {
        int cell = (int)fmin(fmax(floor(o[i] + t0 * w[i]), 0.0), (double)(n[i] - 1));
        walk->n[i] = n[i];
        walk->cell[i] = cell;
        walk->step[i] = w[i] > 0.0 ? 1 : -1;
        walk->next[i] =
            w[i] == 0.0 ? (double)INFINITY : ((double)(cell + (w[i] > 0.0)) - o[i]) / w[i];
        walk->stride[i] = fabs(1.0 / w[i]);
    }
    walk->t = t0;
    walk->end = t1;
    return true;
}

/* false: there are no more. */
static inline bool lf_cell_walk_next(lf_cell_walk *walk, lf_cell_part *out)
{
    int axis = walk->next[0] < walk->next[1] ? 0 : 1;
    if (walk->next[2] < walk->next[axis])
        axis = 2;
    if (!(walk->t < walk->end))
        return false;
    out->from = walk->t;
    out->to = fmax(walk->t, fmin(walk->next[axis], walk->end));
    for (int i = 0; i < 3; i++)
        out->cell[i] = walk->cell[i];
    walk->t = out->to;
    walk->cell[axis] += walk->step[axis];
    if (!(walk->next[axis] < walk->end) || walk->cell[axis] < 0 ||
        walk->cell[axis] >= walk->n[axis])
        walk->t = walk->end;
    walk->next[axis] += walk->stride[axis];
    return true;
}

#endif
