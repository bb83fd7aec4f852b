/* Light paths through media, as restir stores, moves and weights them (Lin, Wyman and Yuksel 2021,
 * supplement, algorithms 3 and 4); private to render/.
 *
 * A path is lambda = (z_1, w_1, z_2, w_2, ... z_n, end): distances and directions, not points.
 * Another ray uses the same distances and directions (direction reuse). This moves the path in
 * space, with a Jacobian of 1 in these coordinates; vertex_reuse.h has the alternative. A path ends
 *
 *     in a light sample, given by the three numbers u of [0,1)^3 that it was drawn with: the ray
 *     that takes the path draws its own light with them. So lights of any kind, also points, are
 *     reused, and their density is part of the path's value; or
 *     at infinity, along w_n, where it finds skies and suns.
 *
 * n >= 1: light that the camera sees behind the media (n = 0) is not sampled, but known for every
 * ray (lf_camera_ray.sky). All walks scatter.
 *
 * The balance heuristic combines both kinds of ends, as a function of the moved path: each kind is
 * an integral of its own. */
#ifndef LF_RENDER_LIGHT_PATH_H
#define LF_RENDER_LIGHT_PATH_H

#include "render/papers/coarse_grid.h"
#include "render/papers/path_vertex.h"
#include "render/transport/lanes/depth.h"

#define LF_MAX_PATH_VERTICES 16

typedef struct lf_path_vertex {
    lf_vec3 w; /* unit, direction in which the path leaves it; for the last one: where it escapes */
    float z;   /* distance from the previous vertex; for the first: from lf_camera_ray.from */
} lf_path_vertex;

typedef struct lf_light_path {
    int n;      /* vertices */
    int escape; /* 1: it ends at infinity */
    float u[3]; /* otherwise: its light sample */
    lf_path_vertex vertex[LF_MAX_PATH_VERTICES];
} lf_light_path;

/* A pixel's ray in one visit, the start of its paths. */
typedef struct lf_camera_ray {
    lf_vec3 o, w; /* w unit */
    lf_vec3 sky;  /* the light if it meets nothing */
    float from;   /* distance from which z of the first vertex is counted */
    double depth; /* in the coarse grid, over its whole length */
} lf_camera_ray;

/* A scene with the data for drawing paths. */
typedef struct lf_path_space {
    const lf_scene *scene;
    const lf_coarse_grid *coarse;
    int max_depth; /* <= LF_MAX_PATH_VERTICES */
} lf_path_space;

/* The value of a path along a ray, without its transmittance: F = f exp(-depth). */
typedef struct lf_path_value {
    lf_vec3 f;
    double depth; /* in the coarse grid, over the whole path */
} lf_path_value;

/* Distance from the camera to the path's first vertex. */
static inline float lf_light_path_first(const lf_camera_ray *ray, const lf_light_path *path)
{
    return path->vertex[0].z + ray->from;
}

/* p-hat: the mean of F's channels, with the coarse grid's depth. 0 exactly if F is 0. */
static inline double lf_path_target(const lf_path_value *value)
{
    return (double)lf_mean3(value->f) * exp(-value->depth);
}

/* Look-ups are counted in the tracer. */
lf_path_value lf_light_path_value(const lf_path_space *space, const lf_camera_ray *ray,
                                  const lf_light_path *path, lf_tracer *tracer);
/* How the path leaves its vertex i at position p: by its direction, or its light sample. */
lf_leaving lf_light_path_leaving(const lf_path_space *space, const lf_light_path *path, int i,
                                 lf_vec3 p);
/* Its n + 1 segments along a ray for which its value is not 0. */
void lf_light_path_segments(const lf_path_space *space, const lf_camera_ray *ray,
                            const lf_light_path *path, lf_depth_ray *out);

/* A path found by a walk: its first n vertices, and this end. */
typedef struct lf_path_candidate {
    int n, escape;
    float u[3];
    lf_path_value value;
    double weight; /* p-hat/p; 0: none */
} lf_path_candidate;

/* A random walk from a ray, with collisions drawn on the coarse grid: a light sample at each
 * vertex, and the light where it escapes. u in (0, 1) determines the first collision along the ray.
 */
typedef struct lf_light_walk {
    const lf_camera_ray *ray;
    double u;
    uint64_t random; /* key of its other random numbers */
    /* Output: */
    lf_light_path path; /* all its vertices, without an end */
    int n_candidates;
    lf_path_candidate candidates[LF_MAX_PATH_VERTICES + 1];
    /* During the walk: its position and direction. */
    lf_vec3 p, w, f; /* f: the path's value so far, without transmittance */
    float pdf;       /* of w, by scattering */
    double inverse;  /* 1 / its density without transmittance, which p-hat also contains */
    double depth;
} lf_light_walk;

#define LF_MAX_WALKS 64

/* Traces n <= LF_MAX_WALKS walks, whose rays meet media (depth > 0), one step of all at a time.
 * Changes the tracer's random state. */
void lf_light_path_walk(const lf_path_space *space, int n, lf_light_walk *walks, lf_tracer *tracer);
/* Copies the path of a candidate of the walk. */
void lf_light_walk_path(const lf_light_walk *walk, const lf_path_candidate *candidate,
                        lf_light_path *out);

#endif
