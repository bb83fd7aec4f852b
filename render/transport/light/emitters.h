/* The lights from which light paths start, and the densities with which they do; private to
 * render/.
 *
 * A light is picked in proportion to its select probability (light.h) among those whose kind has
 * `emit` (light_kind.h). Densities are for a surface point: per unit area there and per unit solid
 * angle of the direction to the light. For lights that no ray can hit they are per unit area only.
 *
 * A distant light sends paths through a square across its direction that covers the scene's
 * bounding ball. The square has cells of different densities, which are learned (lf_emitters_learn)
 * from the light that paths through them brought. */
#ifndef LF_RENDER_EMITTERS_H
#define LF_RENDER_EMITTERS_H

#include "render/transport/light/light_kind.h"

enum { LF_EMITTER_GRID = 64, LF_EMITTER_CELLS = LF_EMITTER_GRID * LF_EMITTER_GRID };

typedef struct lf_emitter {
    float share; /* probability of picking it; 0: light paths do not start there */
    lf_emitter_square square;
} lf_emitter;

typedef struct lf_emitters {
    const lf_scene *scene;
    int n;             /* lights of the scene */
    lf_emitter *of;    /* [n]; NULL: none emits */
    float *cumulative; /* [n + 1] of share */
    int n_cells;       /* of all squares */
    float *density;    /* [n_cells] the squares' memory */
    float *cell_sums;  /* [n_cells + one for each square] */
    unsigned faults;   /* lf_fault (fault.h) */
} lf_emitters;

/* emitters must be zeroed. It borrows the scene. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_emitters_init(lf_emitters *emitters, const lf_scene *scene);
void lf_emitters_finish(lf_emitters *emitters);
static inline bool lf_emitters_any(const lf_emitters *emitters)
{
    return emitters->of;
}

/* Random numbers of a start. */
enum { LF_EMITTER_NUMBERS = 7 };
/* Draws the start of a light path; *out_cell is the index of its cell among all, -1: none. NULL: no
 * path. */
const lf_light *lf_emitters_draw(const lf_emitters *emitters, const float u[LF_EMITTER_NUMBERS],
                                 lf_emitted *out, int *out_cell);

/* The density with which light paths start at the light and arrive at p from wi (unit, towards the
 * light, `distance` away), where the surface has the unit normal ng. */
float lf_emitters_density(const lf_emitters *emitters, const lf_light *light, lf_vec3 p, lf_vec3 ng,
                          lf_vec3 wi, float distance);

/* Multiplies radiance that a camera path found along wi by its balance weight, 1 / (1 + rate
 * density). light: where it comes from; NULL: the sum over all lights at infinity, of which each
 * distant light has a weight of its own. */
lf_vec3 lf_emitters_weigh(const lf_emitters *emitters, const lf_light *light, lf_vec3 radiance,
                          float rate, lf_vec3 p, lf_vec3 ng, lf_vec3 wi, float distance);

/* Sets the densities of the cells from the second moments of what paths through them brought: a
 * tenth as at first, the rest in proportion to the roots of the moments, each averaged with its
 * neighbours. second [n_cells]. */
void lf_emitters_learn(lf_emitters *emitters, const double *second);

#endif
