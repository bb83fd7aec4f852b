/* Grids advected by velocities while the shutter is open; private to render/. The value after a
 * time t is looked up at the point of origin (semi-Lagrangian, first order, with the velocity at
 * the backtracked point: Kim and Ko, "Eulerian Motion Blur", 2007; Cycles does the same):
 *
 *     f_t(x) = f(x - t v(x - t v(x)))
 *
 * If no velocity is stored at that point, v(x) is used. Where no velocity is stored at all it is 0,
 * and the values do not move. docs/developer/estimators/motion.md, "Velocities". */
#ifndef LF_RENDER_GRID_FLOW_H
#define LF_RENDER_GRID_FLOW_H

#include "render/scene/scene.h"

typedef struct lf_flow {
    lf_grid *component[3];     /* velocities (lf_vdb_import_velocity), in one file's world */
    bool of_voxels;            /* in voxels of their own grid, not in world lengths */
    bool nearest;              /* values are looked up per voxel, not interpolated */
    bool rounds;               /* lf_grid_shorten */
    int n;                     /* 1..LF_MAX_STEPS */
    double time[LF_MAX_STEPS]; /* in units of the velocities */
} lf_flow;

/* The grid after each of the times, with its key, digest and names of other grids. Uses all CPUs;
 * the values do not depend on the machine. LF_E_NOMEM (also if all steps together exceed
 * LF_GRID_MAX_BYTES); LF_E_FORMAT: singular map; LF_E_CANCELLED: lf_import_is_stopped. On LF_OK the
 * caller owns a reference to *out. */
LF_NODISCARD lf_status lf_grid_flow(const lf_grid *grid, const lf_flow *flow, lf_grid_steps **out,
                                    lf_error *err);

#endif
