/* The extinction of a scene's media on one coarse grid, constant in each cell; private to render/.
 * What candidates of restir are drawn from by regular tracking with a density in closed form, and
 * what their target function takes for the transmittance: a function of the path alone, so that no
 * answer depends on how coarse it is. Cells a voxel wide, no more than 2^21 of them and 1024 along
 * an axis. A cell has the mean of its points, and 1/50 of what its media may reach there at least,
 * so that wherever there is extinction there are candidates. */
#ifndef LF_RENDER_COARSE_GRID_H
#define LF_RENDER_COARSE_GRID_H

#include "base/thread.h"
#include "render/papers/cell_walk.h"
#include "render/scene/scene.h"
#include "render/transport/lanes/depth_kernel.h"

typedef struct lf_coarse_grid {
    double min[3], per_cell[3]; /* where it begins; cells per scene unit */
    int n[3];
    uint16_t *sigma; /* per scene unit, lf_cells_at; NULL: the scene has no media */
} lf_coarse_grid;

/* sigma of a cell. */
static inline float lf_coarse_grid_sigma(const lf_coarse_grid *grid, const int cell[3])
{
    return lf_cell_value(grid->sigma[lf_cells_at(grid->n, cell)]);
}

/* Where a collision is. */
typedef struct lf_coarse_point {
    double t;
    float sigma;
} lf_coarse_point;

/* A ray that stops where its depth is `goal` (> 0; INFINITY: never), or at its end. */
typedef struct lf_coarse_ray {
    lf_vec3 o, w; /* w unit */
    double end, goal;
} lf_coarse_ray;

/* What it comes to. */
typedef struct lf_coarse_end {
    double depth;          /* behind it */
    lf_coarse_point point; /* where it stops; sigma 0: it does not */
} lf_coarse_end;

/* The scene's volumes stand still. On the pool. LF_E_NOMEM. grid: zeroed or finished. */
LF_NODISCARD lf_status lf_coarse_grid_init(lf_coarse_grid *grid, const lf_scene *scene,
                                           lf_pool *pool);
void lf_coarse_grid_finish(lf_coarse_grid *grid);

/* Optical depth along o + t w, 0 <= t <= end; w unit. */
double lf_coarse_grid_depth(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, double end);
/* The same for n distances, ascending and finite; what is not above 0 has none. */
void lf_coarse_grid_depths(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, int n,
                           const double *ends, double *out_depths);
/* The point with this optical depth before it (the oracle of lanes); false: the ray leaves the
 * media before it, and *out_depth is what it has. */
bool lf_coarse_grid_at_depth(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, double depth,
                             lf_coarse_point *out, double *out_depth);

/* The same of n rays, side by side in lanes; in float within the grid, by a kernel of
 * depth_kernel.h: within 2e-5 of the two above (3e-5 where a ray crosses a thousand cells), and of
 * the same bits by all of them. */
void lf_coarse_grid_trace(const lf_coarse_grid *grid, const lf_depth_kernel *kernel, int n,
                          const lf_coarse_ray *rays, lf_coarse_end *out);

#endif
