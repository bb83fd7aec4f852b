/* Paths of light through media as restir keeps, moves and weighs them (Lin, Wyman and Yuksel 2021,
 * supplement, algorithms 3 and 4); private to render/.
 *
 * A path is lambda = (z_1, w_1, z_2, w_2, ... z_n, end): distances and directions, not points.
 * Another ray takes all of them as they are (direction reuse), which moves the path in space, and
 * whose Jacobian is 1 in these coordinates; vertex_reuse.h has the other way. It ends
 *
 *     in a light sample, by the three numbers u of [0,1)^3 that it was drawn with: the ray that
 *     takes the path draws its own light with them, so that lights of any kind, points too, are
 *     reused, and their density is part of what the path brings; or
 *     at infinity, along w_n, where it finds skies and suns.
 *
 * n >= 1: what the camera sees behind the media (n = 0) is no path to be drawn but known for every
 * ray (lf_camera_ray.sky), and all walks scatter.
 *
 * What both ways could have found is shared between them by the balance heuristic, as a function of
 * the path (of where it is moved to): each way is an integral of its own. */
#ifndef LF_RENDER_LIGHT_PATH_H
#define LF_RENDER_LIGHT_PATH_H

#include "render/papers/coarse_grid.h"
#include "render/papers/path_vertex.h"
#include "render/transport/lanes/depth.h"

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

/* What a path brings along a ray, its transmittance apart: F = f exp(-depth). */
typedef struct lf_path_value {
    lf_vec3 f;
    double depth; /* of the coarse grid, all along the path */
} lf_path_value;

/* From the camera to the path's first vertex. */
static inline float lf_light_path_first(const lf_camera_ray *ray, const lf_light_path *path)
{
    return path->vertex[0].z + ray->from;
}

/* p-hat: the mean of F's channels, by the coarse grid's depth. 0 exactly where F is 0. */
static inline double lf_path_target(const lf_path_value *value)
{
    return (double)lf_mean3(value->f) * exp(-value->depth);
}

/* look-ups: the tracer's. */
lf_path_value lf_light_path_value(const lf_path_space *space, const lf_camera_ray *ray,
                                  const lf_light_path *path, lf_tracer *tracer);
/* How the path leaves its vertex i, if that is at p: by its direction, or its light sample. */
lf_leaving lf_light_path_leaving(const lf_path_space *space, const lf_light_path *path, int i,
                                 lf_vec3 p);
/* Its n + 1 segments along a ray along which it brings something. */
void lf_light_path_segments(const lf_path_space *space, const lf_camera_ray *ray,
                            const lf_light_path *path, lf_depth_ray *out);

/* A path that a walk has found: its first n vertices, and this end. */
typedef struct lf_path_candidate {
    int n, escape;
    float u[3];
    lf_path_value value;
    double weight; /* p-hat/p; 0: nothing */
} lf_path_candidate;

/* A random walk from a ray, collisions drawn on the coarse grid: a light sample at each vertex, and
 * what it finds where it escapes. The first collision is the one of those along the ray that the
 * number u of (0, 1) stands for. */
typedef struct lf_light_walk {
    const lf_camera_ray *ray;
    double u;
    uint64_t random; /* of its other random numbers */
    /* out: */
    lf_light_path path; /* all its vertices; no end */
    int n_candidates;
    lf_path_candidate candidates[LF_MAX_PATH_VERTICES + 1];
    /* while it goes on: where it is, and which way on */
    lf_vec3 p, w, f; /* f: what the path so far brings, without transmittance */
    float pdf;       /* of w, where it scattered */
    double inverse;  /* 1 / its density without transmittance, which p-hat has, too */
    double depth;
} lf_light_walk;

#define LF_MAX_WALKS 64

/* Takes n <= LF_MAX_WALKS walks, whose rays meet something (depth > 0): a step of all, and again.
 * The tracer's random state is lost. */
void lf_light_path_walk(const lf_path_space *space, int n, lf_light_walk *walks, lf_tracer *tracer);
/* What a candidate of the walk is. */
void lf_light_walk_path(const lf_light_walk *walk, const lf_path_candidate *candidate,
                        lf_light_path *out);

#endif
