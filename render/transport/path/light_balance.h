/* The balance between camera paths and light paths; private to render/.
 * docs/developer/estimators/light-paths.md has the derivation.
 *
 * A path of the shared class leads from a light over at least one more vertex to the pivot, the
 * first vertex that a camera sees. Camera paths draw the pivot and the first direction from there
 * with the density `over`, per unit area and solid angle, and the rest of the path with p_suffix.
 * M light paths draw all of it with M p_light. Both get weights of the balance heuristic, the same
 * function of the path on both sides: over / (over + a) and a / (over + a), with
 * a = M p_light / p_suffix. */
#ifndef LF_RENDER_LIGHT_BALANCE_H
#define LF_RENDER_LIGHT_BALANCE_H

#include "render/transport/light/emitters.h"

typedef struct lf_light_balance {
    const lf_emitters *emitters;
    float scale;     /* M / over */
    float cosine;    /* |ng.wi| at the pivot */
    unsigned faults; /* lf_fault (fault.h) */
} lf_light_balance;

/* scale for M light paths and the density over. */
static inline float lf_light_balance_scale(float m, float over)
{
    return over > 0.0f ? lf_min(m / over, 1e30f) : 1e30f;
}

/* The part of a camera path up to its current vertex, for p_light / p_suffix. */
typedef struct lf_reverse {
    float rate;   /* p_light / p_suffix of the vertices before; 0: no light path comes here */
    float cosine; /* |ng.w| of the segment to this vertex, at its start */
    /* The path is inside of a solid, as seen from the pivot: an odd number of refractions. Light
     * paths leave such paths to the camera. */
    bool is_inside;
} lf_reverse;

#endif
