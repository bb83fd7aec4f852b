/* Grids whose values are carried by velocities, for a shutter that is open; private to render/.
 * What a grid is after a time t is the grid itself, looked up where a point came from
 * (semi-Lagrangian, first order, the velocity taken where that leads back to: Kim and Ko, "Eulerian
 * Motion Blur", 2007; Cycles does the same):
 *
 *     f_t(x) = f(x - t v(x - t v(x)))
 *
 * or by v(x) where nothing is stored there. Where no velocity is stored it is 0, and what is there
 * stands still. docs/developer/estimators/motion.md, "Velocities". */
#ifndef LF_RENDER_GRID_FLOW_H
#define LF_RENDER_GRID_FLOW_H

#include "render/scene/scene.h"

typedef struct lf_flow {
    lf_grid *component[3];     /* velocities (lf_vdb_import_velocity), of one file's world */
    bool of_voxels;            /* in voxels of their own grid in place of that world's lengths */
    bool nearest;              /* values are looked up as voxels, not interpolated */
    bool rounds;               /* lf_grid_shorten */
    int n;                     /* 1..LF_MAX_STEPS */
    double time[LF_MAX_STEPS]; /* in units of the velocities */
} lf_flow;

/* The grid after each of the times, with its key, digest and names of other grids. Runs on all
 * CPUs; the values are the same on any. LF_E_NOMEM: all steps together take more than
 * LF_GRID_MAX_BYTES, too; LF_E_FORMAT: a map that flattens space; LF_E_CANCELLED:
 * lf_import_is_stopped. On LF_OK the caller owns a reference to *out. */
LF_NODISCARD lf_status lf_grid_flow(const lf_grid *grid, const lf_flow *flow, lf_grid_steps **out,
                                    lf_error *err);

#endif
