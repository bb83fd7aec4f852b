/* Suffixes of many pivots at once, side by side in lanes (lanes.h); private to render/. What path.c
 * does for one, for scenes that lane_scene.h serves: the same estimators from other random numbers,
 * but for shadow rays, which are traced by chance about the control. path.c is the oracle of the
 * mean, suffix_c.c that of the bits: what a job gets is the same for every instruction set, and
 * whatever jobs it is run with. */
#ifndef LF_RENDER_SUFFIX_H
#define LF_RENDER_SUFFIX_H

#include "render/transport/lanes/lane_scene.h"

/* Shadow rays that wait for their turn, and how many more a step may add. */
enum { LF_LANE_SHADOW_RAYS = 1024, LF_LANE_MOST = 64 };

/* A shadow ray; those of a job come in the order of its vertices. */
typedef struct lf_lane_shadow_ray {
    float q[3];         /* where it begins, volume space */
    float weight[3];    /* of what is left of the light beyond `expected` */
    float expected;     /* what the control says */
    uint32_t random[2]; /* key of its numbers */
    int32_t job;
} lf_lane_shadow_ray;

/* A path that has left, and waits for what it finds at infinity. */
typedef struct lf_lane_exit {
    float w[3], beta[3];
    float pdf; /* of w, by scattering */
    int32_t job;
} lf_lane_exit;

/* A segment of a path that may meet a surface. */
typedef struct lf_lane_segment {
    float q[3], w[3]; /* from, volume space; unit, scene */
    float length;     /* INFINITY: it leaves */
    float beta[3];
    int depth, max_depth; /* of what is met, as in lf_path_scattered */
    uint32_t random[2];   /* key of the numbers of what comes behind it */
} lf_lane_segment;

/* Who answers rays in scenes with surfaces. Either's questions come in the order of a job's
 * vertices; those of shadow rays, which wait, behind those of later segments. */
typedef struct lf_lane_surfaces {
    void *of;
    /* Whether the segment meets a surface: the path ends there, and beta times what comes from it
     * is in out. */
    bool (*meet)(void *of, const lf_lane_segment *segment, float out[3]);
    /* What surfaces let through from q to infinity along w. */
    float (*passed)(void *of, const float q[3], const float w[3]);
} lf_lane_surfaces;

/* Memory of a worker. */
typedef struct lf_lane_memory {
    lf_lane_shadow_ray shadow_ray[LF_LANE_SHADOW_RAYS + LF_LANE_MOST];
    float left[LF_LANE_SHADOW_RAYS + LF_LANE_MOST];
    int n; /* shots */
    /* Where the scene `has` LF_LANE_SKY: unit, scene. Of shots with `draws` the way that the path
     * came; of others where to. */
    float w[3][LF_LANE_SHADOW_RAYS + LF_LANE_MOST];
    int32_t draws[LF_LANE_SHADOW_RAYS + LF_LANE_MOST]; /* -1, else 0 */
    lf_lane_exit exit[LF_LANE_SHADOW_RAYS + LF_LANE_MOST];
    int n_unscattered;
    lf_lane_surfaces surfaces; /* looked at where the scene `has` surfaces */
    double cut;                /* adds up what paths carried that max_depth has ended */
} lf_lane_memory;

/* Paths that leave vertex 1, the pivot, each array of n. */
typedef struct lf_lane_paths {
    int n, max_depth;  /* as in lf_path_scattered */
    const float *q[3]; /* where from, volume space */
    const float *w[3]; /* unit directions, scene */
    const uint32_t *random[2];
    float *radiance[3]; /* out: what arrives along w, light met at the first event included … */
    float *lit[3];      /* what shadow rays add to it meanwhile */
    /* … but where the scene `has` LF_LANE_SKY: there that is left to the caller, and this says
     * whether the path met nothing (1, else 0). Elsewhere it is not looked at. */
    float *escaped;
} lf_lane_paths;

/* Points that ask what is left of the light there: pivots, whose shadow rays are all traced. */
typedef struct lf_lane_points {
    int n;
    const float *q[3];
    const float *w[3]; /* unit, scene: where to; read where it `has` LF_LANE_SKY, else `toward` */
    const uint32_t *random[2];
    float *left; /* out: an unbiased estimate, 0..1; 0 without a light */
} lf_lane_points;

/* One instruction set. Both return how often the grid was looked up. Thread: any, with a memory of
 * its own. */
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
