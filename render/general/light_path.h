/* Paths of light through media as restir keeps, moves and weighs them (Lin, Wyman and Yuksel 2021,
 * supplement, algorithms 3 and 4); private to render/.
 *
 * A path is lambda = (z_1, w_1, z_2, w_2, ... z_n, end): distances and directions, not points.
 * Another ray takes all of them as they are (direction reuse), which moves the path in space, and
 * whose Jacobian is 1 in these coordinates. It ends
 *
 *     in a light sample, by the three numbers u of [0,1)^3 that it was drawn with: the ray that
 *     takes the path draws its own light with them, so that lights of any kind, points too, are
 *     reused, and their density is part of what the path brings; or
 *     at infinity, along w_n, where it finds skies and suns.
 *
 * n >= 1: what the camera sees behind the media (n = 0) is no path to be drawn but known for every
 * ray (lf_camera_ray_behind), and all walks scatter.
 *
 * What both ways could have found is shared between them by the balance heuristic, as a function of
 * the path (of where it is moved to): each way is an integral of its own. Media overlap freely;
 * which of them scattered is not kept but summed over. */
#ifndef LF_RENDER_LIGHT_PATH_H
#define LF_RENDER_LIGHT_PATH_H

#include "render/general/coarse_grid.h"
#include "render/transport/track.h"

#define LF_MAX_PATH_VERTICES 16

typedef struct lf_path_vertex {
    lf_vec3 w; /* unit, direction in which it is left; of the last one: where it escapes */
    float z;   /* how far it is from the one before; the first: from lf_camera_ray.from */
} lf_path_vertex;

typedef struct lf_light_path {
    int n;      /* vertices */
    int escape; /* 1: it ends at infinity */
    float u[3]; /* else: its light sample */
    lf_path_vertex vertex[LF_MAX_PATH_VERTICES];
} lf_light_path;

/* A pixel's ray in one visit: what its paths begin with. */
typedef struct lf_camera_ray {
    lf_vec3 o, w; /* w unit */
    lf_vec3 sky;  /* what it finds where it meets nothing */
    float from;   /* distance from which z of the first vertex counts */
    double depth; /* of the coarse grid, all along it */
} lf_camera_ray;

/* A scene with what its paths are drawn by. */
typedef struct lf_path_space {
    const lf_scene *scene;
    const lf_coarse_grid *coarse;
    int max_depth; /* <= LF_MAX_PATH_VERTICES */
} lf_path_space;

/* What the ray sees behind the media, times their exact transmittance. */
lf_vec3 lf_camera_ray_behind(const lf_camera_ray *ray, lf_tracer *tracer);

/* What the path brings along a ray: the integrand F, its transmittances exact. look-ups: the
 * tracer's. */
lf_vec3 lf_light_path_radiance(const lf_path_space *space, const lf_camera_ray *ray,
                               const lf_light_path *path, lf_tracer *tracer);
/* p-hat: the mean of its channels with the transmittances of the coarse grid. 0 exactly where F is
 * 0. */
double lf_light_path_target(const lf_path_space *space, const lf_camera_ray *ray,
                            const lf_light_path *path, lf_tracer *tracer);

/* Gets the candidates of a walk, one after the other: target and weight p-hat/p. The path is
 * borrowed. */
typedef void (*lf_candidate_fn)(void *context, const lf_light_path *path, double target,
                                double weight);

/* A random walk from the ray, collisions drawn on the coarse grid: a light sample at each vertex,
 * and what it finds where it escapes. The first collision is the one of those along the ray that
 * the number u of (0, 1) stands for; other random numbers are the tracer's. */
void lf_light_path_walk(const lf_path_space *space, const lf_camera_ray *ray, double u,
                        lf_tracer *tracer, lf_candidate_fn found, void *context);

#endif
