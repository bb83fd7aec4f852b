/* Suffixes of many pivots at once, in lanes (lanes.h); private to render/. They do the work of
 * path.c for scenes that lane_scene.h supports. The estimators are the same, with other random
 * numbers, except for shadow rays, which are traced with some probability around the control. The
 * reference for the mean is path.c, and for the bits suffix_c.c. The result of a job is the same
 * for every instruction set and does not depend on the other jobs. */
#ifndef LF_RENDER_SUFFIX_H
#define LF_RENDER_SUFFIX_H

#include "render/transport/lanes/lane_scene.h"

/* Capacity of the queue of shadow rays, and the most that one step may add to it. */
enum { LF_LANE_SHADOW_RAYS = 1024, LF_LANE_MOST = 64 };

/* A shadow ray; the rays of a job are in the order of its vertices. */
typedef struct lf_lane_shadow_ray {
    float q[3];         /* origin, volume space */
    float weight[3];    /* factor of (transmittance - `expected`) */
    float expected;     /* the control's value */
    uint32_t random[2]; /* key of its random numbers */
    int32_t job;
} lf_lane_shadow_ray;

/* A path that has left the scene; its light at infinity is looked up later. */
typedef struct lf_lane_exit {
    float w[3], beta[3];
    float pdf; /* of w, by scattering */
    int32_t job;
} lf_lane_exit;

/* A segment of a path that may meet a surface. */
typedef struct lf_lane_segment {
    float q[3], w[3]; /* origin, volume space; unit direction, scene */
    float length;     /* INFINITY: it leaves the scene */
    float beta[3];
    int depth, max_depth; /* of the hit, as in lf_path_scattered */
    uint32_t random[2];   /* key of the random numbers after the hit */
} lf_lane_segment;

/* Callbacks that trace rays in scenes with surfaces. The calls of one callback come in the order of
 * a job's vertices. Calls for shadow rays, which are queued, come after calls for later segments.
 */
typedef struct lf_lane_surfaces {
    void *of;
    /* Whether the segment meets a surface: the path ends there, and out is beta times the light
     * from it. */
    bool (*meet)(void *of, const lf_lane_segment *segment, float out[3]);
    /* The transmittance of surfaces from q to infinity along w. */
    float (*passed)(void *of, const float q[3], const float w[3]);
} lf_lane_surfaces;

/* A worker's memory. */
typedef struct lf_lane_memory {
    lf_lane_shadow_ray shadow_ray[LF_LANE_SHADOW_RAYS + LF_LANE_MOST];
    float left[LF_LANE_SHADOW_RAYS + LF_LANE_MOST];
    int n; /* shadow rays */
    /* If the scene `has` LF_LANE_SKY: unit directions, scene. For shadow rays with `draws` the
     * direction of travel of the path; for others the direction of the shadow ray. */
    float w[3][LF_LANE_SHADOW_RAYS + LF_LANE_MOST];
    int32_t draws[LF_LANE_SHADOW_RAYS + LF_LANE_MOST]; /* -1, else 0 */
    lf_lane_exit exit[LF_LANE_SHADOW_RAYS + LF_LANE_MOST];
    int n_unscattered;
    lf_lane_surfaces surfaces; /* used if the scene `has` surfaces */
    double cut;                /* sum of the throughput of paths that max_depth has ended */
} lf_lane_memory;

/* Paths that leave vertex 1, the pivot; each array has n entries. */
typedef struct lf_lane_paths {
    int n, max_depth;  /* as in lf_path_scattered */
    const float *q[3]; /* origin, volume space */
    const float *w[3]; /* unit directions, scene */
    const uint32_t *random[2];
    float *radiance[3]; /* out: radiance along w, including light met at the first event … */
    float *lit[3];      /* out: contributions of shadow rays to it during the call */
    /* … except if the scene `has` LF_LANE_SKY: then the caller adds light at the first event, and
     * escaped is 1 for a path that met nothing, else 0. Otherwise escaped is unused. */
    float *escaped;
} lf_lane_paths;

/* Points for which the transmittance towards the light is estimated: pivots, whose shadow rays are
 * all traced. */
typedef struct lf_lane_points {
    int n;
    const float *q[3];
    /* unit direction, scene; read if the scene `has` LF_LANE_SKY, else `toward` is used */
    const float *w[3];
    const uint32_t *random[2];
    float *left; /* out: an unbiased estimate, mean in 0..1; 0 without a light */
} lf_lane_points;

/* The functions of one instruction set. Both return the number of grid look-ups. Thread: any, each
 * with its own memory. */
typedef struct lf_suffixes {
    const char *name;
    int64_t (*trace)(const lf_lane_scene *scene, const lf_lane_paths *paths,
                     lf_lane_memory *memory);
    int64_t (*light)(const lf_lane_scene *scene, const lf_lane_points *points,
                     lf_lane_memory *memory);
} lf_suffixes;

extern const lf_suffixes lf_suffixes_c;
#if defined(__x86_64__)
extern const lf_suffixes lf_suffixes_avx2, lf_suffixes_avx512;
#endif

#endif
