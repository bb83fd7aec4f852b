/* The lights from which light paths start, and the densities with which they do; private to
 * render/.
 *
 * A start is a light whose kind has `emit` (light_kind.h), or a bright part of a sky's picture
 * (sky_lobe.h). It is picked in proportion to the probability with which light sampling draws it:
 * the light's select probability (light.h), times the share of the part. Densities are for a
 * surface point: per unit area there and per unit solid angle of the direction to the light. For
 * lights that no ray can hit they are per unit area only.
 *
 * Paths from infinity come through a square with cells of different densities (emitter_square.h),
 * which are learned (lf_emitters_learn). */
#ifndef LF_RENDER_EMITTERS_H
#define LF_RENDER_EMITTERS_H

#include "render/transport/light/light_kind.h"
#include "render/transport/light/sky_lobe.h"

typedef struct lf_emitter {
    const lf_light *light;
    float share; /* probability of picking it */
    lf_sky_lobe lobe;
    lf_emitter_square square;
} lf_emitter;

typedef struct lf_emitters {
    const lf_scene *scene;
    int n, n_infinite; /* starts, in the order of the lights; those at infinity are first */
    lf_emitter *of;    /* [n]; NULL: none emits */
    float *cumulative; /* [n + 1] of share */
    int *first;        /* [lights + 1] the first start of a light */
    int n_cells;       /* of all squares */
    float *density;    /* [n_cells] the squares' memory */
    float *cell_sums;  /* [n_cells + one for each square] */
    double *prior;     /* [n_cells] */
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

/* The density with which light paths start at the light and arrive from `end` at p, where the
 * surface has the unit normal ng. */
float lf_emitters_density(const lf_emitters *emitters, const lf_light *light, lf_vec3 p, lf_vec3 ng,
                          const lf_light_end *end);

/* Multiplies radiance that a camera path found at `end` by its balance weight, 1 / (1 + rate
 * density). light: where it comes from; NULL: the sum over all lights at infinity, of which each
 * start has a weight of its own. */
lf_vec3 lf_emitters_weigh(const lf_emitters *emitters, const lf_light *light, lf_vec3 radiance,
                          float rate, lf_vec3 p, lf_vec3 ng, const lf_light_end *end);

/* Teaches the squares from the second moments of what paths through their cells brought
 * (lf_emitter_square_learn). second [n_cells]. */
void lf_emitters_learn(lf_emitters *emitters, const double *second);

#endif
