/* The square through which light paths of a light at infinity start; private to render/.
 *
 * It lies across one direction of the light and covers the scene's bounding ball from every
 * direction of it. It has cells of different densities, which are learned from the light that paths
 * through them brought. */
#ifndef LF_RENDER_EMITTER_SQUARE_H
#define LF_RENDER_EMITTER_SQUARE_H

#include "render/scene/scene.h"

enum { LF_EMITTER_GRID = 64, LF_EMITTER_CELLS = LF_EMITTER_GRID * LF_EMITTER_GRID };

typedef struct lf_emitter_square {
    lf_vec3 middle, right, up;
    lf_vec3 axis;                   /* unit, across it, towards the light */
    float half;                     /* half of its side */
    int first;                      /* its first cell among those of all squares */
    float *density;                 /* [cells] relative to an even one; NULL: even */
    float *cumulative;              /* [cells + 1] probabilities; NULL: there is no square */
    double *prior;                  /* [cells] probabilities before any path */
    const struct lf_sky_lobe *lobe; /* the directions of a sky (sky_lobe.h); NULL: of the light */
} lf_emitter_square;

/* Places the square across axis for directions with at least this cosine to it, and sets its cells
 * as before any path: half is even, and half goes to the shadows of meshes. first, density,
 * cumulative and prior are set. */
void lf_emitter_square_place(lf_emitter_square *square, const lf_scene *scene, lf_vec3 axis,
                             float least_cosine);

/* Draws a point. *out_area: one over its density per unit area. */
lf_vec3 lf_emitter_square_draw(const lf_emitter_square *square, const float u[3], int *out_cell,
                               float *out_area);
/* The density per unit area across wi with which paths come to p from wi, the direction to the
 * light. */
float lf_emitter_square_density(const lf_emitter_square *square, lf_vec3 p, lf_vec3 wi);

/* Sets the densities of the cells from the second moments of what paths through them brought: a
 * tenth as at first, the rest in proportion to the roots of the moments, each averaged with its
 * neighbours. second [cells]. */
void lf_emitter_square_learn(lf_emitter_square *square, const double *second);

#endif
