#include "render/import/scene/volume_place.h"

#include <string.h>

#include "base/alloc.h"
#include "render/import/scene/scene_traits.h"
#include "render/scene/vec_double.h"

/* Volume space -> world. */
static lf_affine volume_to_world(const lf_volume *volume, const lf_volume_desc *desc)
{
    if (volume->kind != LF_VOLUME_GRID)
        return desc->transform;
    lf_affine local;
    memcpy(local.m, volume->grid->local_to_file, sizeof local.m);
    return lf_affine_compose(&desc->transform, &local);
}

/* The box in volume space outside of which the volume is 0, including the filter's footprint. */
static void volume_support(const lf_volume *volume, double lo[3], double hi[3])
{
    for (int i = 0; i < 3; i++) {
        double margin = volume->nearest ? 0.5 : 1.0;
        lo[i] = volume->grid ? -margin : -1.0;
        hi[i] = volume->grid ? volume->grid->size[i] - 1 + margin : 1.0;
    }
}

/* Extends bounds by a volume's support under a map. */
static void extend_by_volume(const lf_volume *volume, const lf_affine *map, double bounds[2][3])
{
    double lo[3], hi[3], middle[3], centre[3];
    volume_support(volume, lo, hi);
    for (int i = 0; i < 3; i++)
        middle[i] = 0.5 * (lo[i] + hi[i]);
    lf_affine_point(map, middle, centre);
    for (int i = 0; i < 3; i++) {
        double row[3];
        for (int j = 0; j < 3; j++)
            row[j] = map->m[i][j] * 0.5 * (hi[j] - lo[j]);
        double reach = lf_shape_reach(volume->kind, row);
        bounds[0][i] = fmin(bounds[0][i], centre[i] - reach);
        bounds[1][i] = fmax(bounds[1][i], centre[i] + reach);
    }
}

static double shortest_edge(const lf_affine *map)
{
    double edge = INFINITY;
    for (int j = 0; j < 3; j++)
        edge = fmin(edge, sqrt(map->m[0][j] * map->m[0][j] + map->m[1][j] * map->m[1][j] +
                               map->m[2][j] * map->m[2][j]));
    return edge;
}

/* The cell size that slices resolve: the shortest edge of a voxel, down to a quarter of it if that
 * is optically thick. (Between planes the density is linear along the ray, so a voxel's own
 * gradient is kept; only its kinks are rounded off.) */
static float slice_cell(const lf_volume *volume)
{
    double edge = (double)volume->voxel;
    return (float)fmax(edge / 4.0, fmin(edge, 2.0 / fmax((double)volume->sigma_max, 1e-30)));
}

/* Volume space -> scene-local at both ends of the shutter. */
static lf_volume_motion motion_of(const lf_volume *volume, const lf_shutter *shutter, int i,
                                  const double origin[3])
{
    lf_volume_motion motion = {volume_to_world(volume, &shutter->desc[0]->volumes[i]),
                               volume_to_world(volume, &shutter->desc[1]->volumes[i])};
    for (int k = 0; k < 3; k++) {
        motion.open.m[k][3] -= origin[k];
        motion.close.m[k][3] -= origin[k];
    }
    return motion;
}

static void set_box(lf_volume *volume, const lf_volume_motion *motion)
{
    double bounds[2][3] = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    double largest = 0;
    extend_by_volume(volume, &motion->open, bounds);
    extend_by_volume(volume, &motion->close, bounds);
    for (int i = 0; i < 3; i++)
        largest = fmax(largest, fmax(fabs(bounds[0][i]), fabs(bounds[1][i])));
    /* Rounding during the transform to volume space must not leave the box. */
    for (int i = 0; i < 3; i++) {
        bounds[0][i] -= 1e-6 * largest;
        bounds[1][i] += 1e-6 * largest;
    }
    volume->bounds_min = lf_to_vec3(bounds[0]);
    volume->bounds_max = lf_to_vec3(bounds[1]);
}

void lf_volume_extend(const lf_volume *volume, const lf_shutter *shutter, int i,
                      double bounds[2][3])
{
    for (int end = 0; end < 2 && lf_volume_is_there(volume); end++) {
        lf_affine map = volume_to_world(volume, &shutter->desc[end]->volumes[i]);
        extend_by_volume(volume, &map, bounds);
    }
}

lf_status lf_volume_check(const lf_volume *volume, const lf_shutter *shutter, int i, lf_error *err)
{
    double bounds[2][3] = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}},
           most = 0.0;
    for (int end = 0; end < 2; end++) {
        lf_affine map = volume_to_world(volume, &shutter->desc[end]->volumes[i]);
        extend_by_volume(volume, &map, bounds);
    }
    if (lf_is_within_reach((const double(*)[3])bounds))
        return LF_OK;
    for (int k = 0; k < 6; k++)
        most = fmax(most, fabs(bounds[k / 3][k % 3]));
    return lf_error_set(err, LF_E_FORMAT, shutter->desc[0]->volumes[i].name,
                        "it has coordinates up to %g; expected at most %g", most, LF_MAX_REACH);
}

lf_status lf_volume_place(lf_volume *volume, const lf_shutter *shutter, int i,
                          const double origin[3], lf_error *err)
{
    const lf_volume_desc *desc = &shutter->desc[0]->volumes[i];
    lf_volume_motion motion = motion_of(volume, shutter, i, origin);
    lf_affine inverse;
    if (!lf_affine_invert(&motion.open, &inverse))
        return lf_error_set(err, LF_E_FORMAT, desc->file ? desc->file : desc->name,
                            "the transform in the file of the grid is singular");
    if (memcmp(&motion.open, &motion.close, sizeof motion.open) != 0) {
        if (!lf_volume_motion_is_sound(&motion))
            return lf_error_set(err, LF_E_FORMAT, desc->name,
                                "it collapses while the shutter is open because points move in "
                                "straight lines; rotate it by less than half a turn");
        volume->motion = lf_calloc(1, sizeof *volume->motion);
        if (!volume->motion)
            return lf_error_set(err, LF_E_NOMEM, desc->name, "out of memory");
        *volume->motion = motion;
    }
    for (int k = 0; k < 3; k++)
        for (int j = 0; j < 4; j++) {
            volume->to_scene[k][j] = (float)motion.open.m[k][j];
            volume->to_volume[k][j] = (float)inverse.m[k][j];
        }
    set_box(volume, &motion);
    if (volume->kind == LF_VOLUME_GRID) {
        volume->voxel = (float)fmin(shortest_edge(&motion.open), shortest_edge(&motion.close));
        volume->slice_cell = slice_cell(volume);
    }
    return LF_OK;
}
