/* Radiosity of diffuse rectangles by brute force, in double: it shares nothing with render/. Form
 * factors from a point to a patch are Lambert's closed form, also behind the one shade, whose
 * shadow on the patch is cut out of it. The radiosity of a patch is constant, which is the only
 * error; it falls with the square of the size of the patches. */
#ifndef LF_TESTS_RADIOSITY_H
#define LF_TESTS_RADIOSITY_H

#include <stdbool.h>

enum { LF_ROOM_QUADS = 16 };

/* One side: centre + s u + t v, s and t in -1..1; it faces u x v. */
typedef struct lf_room_quad {
    double centre[3], u[3], v[3], albedo;
    double emission;  /* radiance */
    int across, down; /* patches along u and v, times the fineness */
} lf_room_quad;

typedef struct lf_room {
    lf_room_quad quads[LF_ROOM_QUADS];
    int n_quads;
    int shade; /* quad that hides others; its other side may be a quad in the same place */
} lf_room;

typedef struct lf_radiosity lf_radiosity;

/* Radiosities of paths of at most max_depth vertices between light and camera, the one that the
 * camera sees included: 1 = no patch reflects to another. The room is copied. */
lf_radiosity *lf_radiosity_solve(const lf_room *room, int fineness, int max_depth);
void lf_radiosity_free(lf_radiosity *radiosity);

/* Irradiance at p with the normal n: from quads that emit, and from all that reflect. */
double lf_radiosity_direct(const lf_radiosity *radiosity, const double p[3], const double n[3]);
double lf_radiosity_indirect(const lf_radiosity *radiosity, const double p[3], const double n[3]);

/* The form factor of a quad from p: what a white sky in its place would give, 1 all around. */
double lf_room_factor(const lf_room *room, int quad, const double p[3], const double n[3]);

#endif
