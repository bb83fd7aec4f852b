/* Optical depths of many rays through one grid, in lanes (transport/lanes/lanes.h); private to
 * render/. depth_lanes.h and cell_lanes.h hold the algorithms, compiled once per instruction set. A
 * ray's depth is bitwise the same in all of them, and does not depend on the other rays. base/cpu.h
 * chooses the instruction set. */
#ifndef LF_RENDER_DEPTH_KERNEL_H
#define LF_RENDER_DEPTH_KERNEL_H

#include "render/scene/scene.h"
#include "render/transport/lanes/cells.h"

enum { LF_DEPTH_MOST = LF_MAX_VIEWS };

/* Rays in the grid's coordinates, in units of voxels, relative to a point in one of its bricks. */
typedef struct lf_depth_jobs {
    int n, of[LF_DEPTH_MOST];        /* of: the caller's ray number */
    float p[3][LF_DEPTH_MOST];       /* start, in the brick: 0 to LF_BRICK along each axis */
    int32_t brick[3][LF_DEPTH_MOST]; /* coordinates of that brick */
    float d[3][LF_DEPTH_MOST];       /* finite */
    float end[LF_DEPTH_MOST];        /* in units of d, above 0 */
    float sum[LF_DEPTH_MOST];        /* out: the integral of the values, in units of d */
} lf_depth_jobs;

enum { LF_CELL_MOST = 256 };

/* Rays through a regular grid of cells, in the form of lf_cell_walk (cell_walk.h) at the point
 * where they enter it; distances are counted from there. Each ray continues until its integral
 * reaches `goal`, or it ends. */
typedef struct lf_cell_jobs {
    int n;
    float next[3][LF_CELL_MOST], stride[3][LF_CELL_MOST];
    int32_t cell[3][LF_CELL_MOST], step[3][LF_CELL_MOST], left[3][LF_CELL_MOST];
    float end[LF_CELL_MOST], goal[LF_CELL_MOST]; /* goal: above 0, may be infinite */
    /* out: the end, the integral there, and the value there if the goal was reached, else 0 */
    float at[LF_CELL_MOST], sum[LF_CELL_MOST], sigma[LF_CELL_MOST];
} lf_cell_jobs;

typedef struct lf_depth_kernel {
    const char *name;
    /* Rays end when their sum exceeds `most`. Returns the number of cells looked up. */
    int64_t (*trace)(const lf_grid *grid, bool nearest, float most, lf_depth_jobs *jobs);
    /* values: of n cells per axis, in the layout of cells.h. */
    void (*trace_cells)(const int n[3], const uint16_t *values, lf_cell_jobs *jobs);
} lf_depth_kernel;

extern const lf_depth_kernel lf_depth_kernel_c;
#if defined(__x86_64__)
extern const lf_depth_kernel lf_depth_kernel_avx2;
#endif

/* The instruction set in use. Thread safe. */
const lf_depth_kernel *lf_depth_kernel_get(void);

/* Those that this CPU can run, plain C first; NULL after the last. */
const lf_depth_kernel *lf_depth_kernel_at(int index);

#endif
