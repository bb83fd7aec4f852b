/* A path tracer that shares nothing with render/ but the description of a scene: double precision,
 * every quad asked for every ray, no light is looked for (what a path meets by chance is all it
 * finds), no weights but albedos, one view pixel at a time. It reads the little scene below; the
 * same scene as a file is written from it. What it computes is what docs/reference/scene-format.md
 * says. */
#ifndef LF_TESTS_BRUTE_H
#define LF_TESTS_BRUTE_H

#include <stdbool.h>
#include <stdint.h>

enum { LF_BRUTE_QUADS = 12, LF_BRUTE_MEDIA = 3 };

/* Diffuse on both sides: centre + s u + t v, s and t in -1..1. */
typedef struct lf_brute_quad {
    double centre[3], u[3], v[3], albedo[3], emission[3];
} lf_brute_quad;

/* A box around its centre with these half edges, or (grid) the voxels of patterns.vdb
 * (scenes/make_test_vdb.cc) instead of it: voxel (i, j, k) has its middle at centre + (i - 7.5, j
 * - 16.5, k + 0.5) half, and of lf_brute_voxel's value the share `density`. Turned about y by so
 * many degrees, before it is moved to its centre. */
typedef struct lf_brute_medium {
    double centre[3], half[3], turn, density, albedo[3], g;
    bool grid;
    bool nearest; /* of a grid: no interpolation */
} lf_brute_medium;

typedef struct lf_brute_scene {
    /* up is +y; centred placement */
    double position[3], target[3], fov_y, aspect, cone, lens_radius, focus;
    double track;     /* length, each camera with its own window; 0: an arc */
    double view_blur; /* of steps between the cameras, which are set by their tangents */
    int n_views, n_quads, n_media;
    lf_brute_quad quads[LF_BRUTE_QUADS];
    lf_brute_medium media[LF_BRUTE_MEDIA];
    double sky[3];
    double sun_direction[3], sun_angle, sun_irradiance[3]; /* angle 0 = no sun */
} lf_brute_scene;

/* The scene as a file's text, with " as '; vdb is the path of patterns.vdb. The caller frees it. */
char *lf_brute_text(const lf_brute_scene *scene, const char *vdb);

/* A picture as lf_test_picture (fixture.h) has it, out[row][view][column], of strata^2 paths a
 * pixel, each in its own square. */
void lf_brute_picture(const lf_brute_scene *scene, uint64_t seed, int width, int height, int strata,
                      double *out);

#endif
