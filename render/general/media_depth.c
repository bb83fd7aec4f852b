#include "render/general/media_depth.h"

#include "render/general/cell_walk.h"

/* A ray in volume space. */
typedef struct volume_ray {
    double o[3], w[3], end;
} volume_ray;

static volume_ray ray_in(const lf_volume *volume, lf_vec3 o, lf_vec3 w, double end)
{
    volume_ray ray = {.end = end};
    for (int i = 0; i < 3; i++) {
        const float *m = volume->to_volume[i];
        ray.o[i] = (double)m[0] * (double)o.x + (double)m[1] * (double)o.y +
                   (double)m[2] * (double)o.z + (double)m[3];
        ray.w[i] =
            (double)m[0] * (double)w.x + (double)m[1] * (double)w.y + (double)m[2] * (double)w.z;
    }
    return ray;
}

static double depth_of_shape(const lf_volume *volume, const volume_ray *ray)
{
    float o[3], w[3], from, to;
    for (int i = 0; i < 3; i++) {
        o[i] = (float)ray->o[i];
        w[i] = (float)ray->w[i];
    }
    lf_shape_interval(volume->kind, o, w, &from, &to);
    double length = fmin((double)to, ray->end) - fmax((double)from, 0.0);
    return (double)volume->sigma_scale * fmax(length, 0.0);
}

static double value_at(const lf_volume *volume, const volume_ray *ray, double t)
{
    float p[3];
    for (int i = 0; i < 3; i++)
        p[i] = (float)(ray->o[i] + t * ray->w[i]);
    return (double)(volume->nearest ? lf_grid_nearest(volume->grid, p[0], p[1], p[2])
                                    : lf_grid_linear(volume->grid, p[0], p[1], p[2]));
}

/* Whether a cell between voxel centres, the first from -1 to 0, has none but 0. */
static bool is_empty(const lf_grid *grid, const int cell[3])
{
    size_t brick =
        ((size_t)(cell[2] / LF_BRICK) * (size_t)grid->bricks[1] + (size_t)(cell[1] / LF_BRICK)) *
            (size_t)grid->bricks[0] +
        (size_t)(cell[0] / LF_BRICK);
    return grid->index[brick] == 0;
}

static double depth_of_grid(const lf_volume *volume, const volume_ray *ray, int64_t *lookups)
{
    const lf_grid *grid = volume->grid;
    const double shift = volume->nearest ? 0.5 : 1.0, gauss = 0.28867513459481287;
    const double o[3] = {ray->o[0] + shift, ray->o[1] + shift, ray->o[2] + shift};
    int cells[3];
    lf_cell_walk walk;
    lf_cell_part part;
    double sum = 0.0;
    for (int i = 0; i < 3; i++)
        cells[i] = grid->size[i] + !volume->nearest;
    if (!lf_cell_walk_init(&walk, cells, o, ray->w, ray->end))
        return 0.0;
    while (lf_cell_walk_next(&walk, &part)) {
        double middle = 0.5 * (part.from + part.to), length = part.to - part.from;
        if (volume->nearest) {
            sum += length * value_at(volume, ray, middle);
        } else if (!is_empty(grid, part.cell)) {
            sum += 0.5 * length *
                   (value_at(volume, ray, middle - gauss * length) +
                    value_at(volume, ray, middle + gauss * length));
            *lookups += 2;
        }
    }
    return (double)volume->sigma_scale * sum;
}

double lf_media_depth(const lf_scene *scene, lf_vec3 o, lf_vec3 w, double end, int64_t *lookups)
{
    double depth = 0.0;
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *volume = &scene->volumes[i];
        volume_ray ray = ray_in(volume, o, w, end);
        depth += volume->kind == LF_VOLUME_GRID ? depth_of_grid(volume, &ray, lookups)
                                                : depth_of_shape(volume, &ray);
    }
    return depth;
}
