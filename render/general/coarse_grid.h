/* The extinction of a scene's media on one coarse grid, constant in each cell; private to render/.
 * What candidates of restir are drawn from by regular tracking with a density in closed form, and
 * what their target function takes for the transmittance: a function of the path alone, so that no
 * answer depends on how coarse it is. Cells a voxel wide, no more than 2^21 of them. A
 * cell has the mean of its points, and 1/50 of what its media may reach there at least, so that
 * wherever there is extinction there are candidates. */
#ifndef LF_RENDER_COARSE_GRID_H
#define LF_RENDER_COARSE_GRID_H

#include "render/general/cell_walk.h"
#include "render/scene/scene.h"

typedef struct lf_coarse_grid {
    double min[3], per_cell[3]; /* where it begins; cells per scene unit */
    int n[3];
    float *sigma; /* [z][y][x] per scene unit; NULL: the scene has no media */
} lf_coarse_grid;

/* Where a collision is. */
typedef struct lf_coarse_point {
    double t;
    float sigma;
} lf_coarse_point;

/* The scene's volumes stand still. On the pool. LF_E_NOMEM. grid: zeroed or finished. */
LF_NODISCARD lf_status lf_coarse_grid_init(lf_coarse_grid *grid, const lf_scene *scene,
                                           lf_pool *pool);
void lf_coarse_grid_finish(lf_coarse_grid *grid);

/* Optical depth along o + t w, 0 <= t <= end; w unit. */
double lf_coarse_grid_depth(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, double end);
/* The point with this optical depth before it; false: the ray leaves the media before it, and
 * *out_depth is what it has. */
bool lf_coarse_grid_at_depth(const lf_coarse_grid *grid, lf_vec3 o, lf_vec3 w, double depth,
                             lf_coarse_point *out, double *out_depth);

#endif
