/* Optical depths of many rays through one grid, side by side in lanes (transport/lanes/lanes.h);
 * private to render/. depth_lanes.h and cell_lanes.h are the algorithms, compiled once an
 * instruction set: a ray's depth has the same bits in all of them, and whatever rays it is taken
 * with. Which is in use base/cpu.h says. */
#ifndef LF_RENDER_DEPTH_KERNEL_H
#define LF_RENDER_DEPTH_KERNEL_H

#include "render/scene/scene.h"
#include "render/transport/lanes/cells.h"

enum { LF_DEPTH_MOST = LF_MAX_VIEWS };

/* Rays as a grid sees them: in units of voxels, from a point in one of its bricks. */
typedef struct lf_depth_jobs {
    int n, of[LF_DEPTH_MOST];  /* of: whose they are, which is the caller's */
    float p[3][LF_DEPTH_MOST]; /* where they begin: in the brick, 0 to LF_BRICK along each axis */
    int32_t brick[3][LF_DEPTH_MOST]; /* which is one of the grid's */
    float d[3][LF_DEPTH_MOST];       /* finite */
    float end[LF_DEPTH_MOST];        /* in units of d, above 0 */
    float sum[LF_DEPTH_MOST];        /* out: the integral of the values, in units of d */
} lf_depth_jobs;

enum { LF_CELL_MOST = 256 };

/* Rays through a regular grid of cells, as lf_cell_walk (cell_walk.h) has them where they enter it;
 * distances are from there. Each goes on until what lies behind it is `goal`, or it ends. */
typedef struct lf_cell_jobs {
    int n;
    float next[3][LF_CELL_MOST], stride[3][LF_CELL_MOST];
    int32_t cell[3][LF_CELL_MOST], step[3][LF_CELL_MOST], left[3][LF_CELL_MOST];
    float end[LF_CELL_MOST], goal[LF_CELL_MOST]; /* goal: above 0, may be infinite */
    /* out: where it is, what is behind it; the value there if it is `goal`, else 0 */
    float at[LF_CELL_MOST], sum[LF_CELL_MOST], sigma[LF_CELL_MOST];
} lf_cell_jobs;

typedef struct lf_depth_kernel {
    const char *name;
    /* Rays end where their sum is above `most`. Returns how many cells were looked up. */
    int64_t (*trace)(const lf_grid *grid, bool nearest, float most, lf_depth_jobs *jobs);
    /* values: of n cells an axis, as cells.h has them. */
    void (*trace_cells)(const int n[3], const uint16_t *values, lf_cell_jobs *jobs);
} lf_depth_kernel;

extern const lf_depth_kernel lf_depth_kernel_c;
#if defined(__x86_64__)
extern const lf_depth_kernel lf_depth_kernel_avx2;
#endif

/* The one in use. Thread safe. */
const lf_depth_kernel *lf_depth_kernel_get(void);

/* Those that this CPU can run, plain C first; NULL behind the last. */
const lf_depth_kernel *lf_depth_kernel_at(int index);

#endif
