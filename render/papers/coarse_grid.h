/* The extinction of a scene's media on one coarse grid, constant in each cell; private to render/.
 * restir draws candidates from it by regular tracking, with a density in closed form. Its target
 * function uses it for the transmittance. This is a function of the path alone, so that the
 * resolution of the grid does not bias any result. Cells are a voxel wide, but at most 2^21 in all
 * and 1024 along an axis. A cell has the mean of its points, at least 1/50 of the maximum of its
 * media, so that there are candidates wherever there is extinction. */
#ifndef LF_RENDER_COARSE_GRID_H
#define LF_RENDER_COARSE_GRID_H

#include "base/thread.h"
#include "render/papers/cell_walk.h"
#include "render/scene/scene.h"
#include "render/transport/lanes/depth_kernel.h"

typedef struct lf_coarse_grid {
    double min[3], per_cell[3]; /* the grid's corner; cells per scene unit */
    int n[3];
    uint16_t *sigma; /* per scene unit, index by lf_cells_at; NULL: the scene has no media */
} lf_coarse_grid;

/* sigma of a cell. */
static inline float lf_coarse_grid_sigma(const lf_coarse_grid *grid, const int cell[3])
{
    return lf_cell_value(grid->sigma[lf_cells_at(grid->n, cell)]);
}

/* A collision point. */
typedef struct lf_coarse_point {
    double t;
    float sigma;
} lf_coarse_point;

/* A ray that stops when its optical depth reaches `goal` (> 0; INFINITY: never), or at its end. */
typedef struct lf_coarse_ray {
    lf_vec3 o, w; /* w unit */
    double end, goal;
} lf_coarse_ray;

/* The result of such a ray. */
typedef struct lf_coarse_end {
    double depth;          /* up to the end of the walk */
    lf_coarse_point point; /* where it stops; sigma 0: it does not */
} lf_coarse_end;

/* Makes the grid on the pool. The scene's volumes must not move. LF_E_NOMEM. grid: zeroed or
 * finished. */
LF_NODISCARD lf_status lf_coarse_grid_init(lf_coarse_grid *grid, const lf_scene *scene,
                                           lf_pool *pool);
void lf_coarse_grid_finish(lf_coarse_grid *grid);

/* Optical depth along o + t w, 0 <= t <= end; w unit. */
double lf_coarse_grid_depth(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, double end);
/* lf_coarse_grid_depth for n distances, ascending and finite; a distance that is not above 0 gives
 * 0. */
void lf_coarse_grid_depths(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, int n,
                           const double *ends, double *out_depths);
/* The point at this optical depth (the reference for lanes); false: the ray leaves the media
 * before, and *out_depth is its whole depth. */
bool lf_coarse_grid_at_depth(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, double depth,
                             lf_coarse_point *out, double *out_depth);

/* The same for n rays in lanes, in float within the grid, by a kernel of depth_kernel.h. Within
 * 2e-5 of the two functions above (3e-5 if a ray crosses a thousand cells), and bitwise the same
 * for all kernels. */
void lf_coarse_grid_trace(const lf_coarse_grid *grid, const lf_depth_kernel *kernel, int n,
                          const lf_coarse_ray *rays, lf_coarse_end *out);

#endif
