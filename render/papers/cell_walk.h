/* Regular tracking: the cells of a regular grid along a ray, in order (Amanatides and Woo 1987);
 * private to render/. In the grid's own coordinates: cells are unit cubes, the first begins at 0.
 */
#ifndef LF_RENDER_CELL_WALK_H
#define LF_RENDER_CELL_WALK_H

#include <math.h>
#include <stdbool.h>
#include <string.h>

typedef struct lf_cell_walk {
    double t, end;        /* entry into the current cell, and end of the ray */
    double next[3];       /* entry into the next cell along each axis … */
    double stride[3];     /* … the distance from there to the following one … */
    int cell[3], step[3]; /* … and the step of the cell's index */
    int left[3];          /* number of cells after this one */
} lf_cell_walk;

/* One cell's part of the ray. */
typedef struct lf_cell_part {
    double from, to;
    int cell[3];
} lf_cell_part;

/* Starts the walk of the ray o + t w, 0 <= t <= end (which may be infinite), through n cells per
 * axis; w need not be unit. false: no intersection. */
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
        const int cell = (int)fmin(fmax(floor(o[i] + t0 * w[i]), 0.0), (double)(n[i] - 1));
        walk->cell[i] = cell;
        walk->step[i] = w[i] > 0.0 ? 1 : -1;
        walk->left[i] = w[i] > 0.0 ? n[i] - 1 - cell : cell;
        walk->next[i] =
            w[i] == 0.0 ? (double)INFINITY : ((double)(cell + (w[i] > 0.0)) - o[i]) / w[i];
        walk->stride[i] = fabs(1.0 / w[i]);
    }
    walk->t = t0;
    walk->end = t1;
    return true;
}

/* false: no more cells. */
static inline bool lf_cell_walk_next(lf_cell_walk *walk, lf_cell_part *out)
{
    if (!(walk->t < walk->end))
        return false;
    int axis = walk->next[0] < walk->next[1] ? 0 : 1;
    if (walk->next[2] < walk->next[axis])
        axis = 2;
    const double next = walk->next[axis];
    out->from = walk->t;
    memcpy(out->cell, walk->cell, sizeof out->cell);
    if (next < walk->end && walk->left[axis] > 0) {
        out->to = next > walk->t ? next : walk->t;
        walk->t = out->to;
        walk->cell[axis] += walk->step[axis];
        walk->left[axis]--;
        walk->next[axis] = next + walk->stride[axis];
    } else {
        out->to = walk->t = walk->end;
    }
    return true;
}

#endif
