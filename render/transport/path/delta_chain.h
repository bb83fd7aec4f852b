/* Light that reaches a camera only through smooth surfaces, mirrors and clear glass (a delta
 * chain). Both branches of every smooth dielectric are followed and weighted by Fresnel's
 * equations, instead of a random choice of one. Private to render/.
 * docs/developer/estimators/surfaces.md, "Both branches".
 *
 * A chain branches after the camera's first surface as long as surfaces have only delta lobes. Each
 * branch ends at the sky, in a medium, or at the first surface that scatters. The light of area
 * lights and skies along the chain is exact; only light scattered at the ends is random. */
#ifndef LF_RENDER_DELTA_CHAIN_H
#define LF_RENDER_DELTA_CHAIN_H

#include "render/transport/path/face_albedo.h"
#include "render/transport/path/path.h"
#include "render/transport/path/sunlight.h"

typedef struct lf_delta_chain {
    /* Input: */
    lf_tracer *tracer;
    int max_depth;               /* of vertices, as in lf_path_scattered */
    const lf_sunlight *sunlight; /* NULL: no look-up */
    bool apart;                  /* store scattered light separately from the rest */
    bool tinted; /* the film stores albedo: sum it separately, not as a part of weight */
    /* of the first surface: D, Z, and Z per unit length of the camera's ray */
    float distance, z, forward;
    /* Sums, zeroed by the caller. Radiance at the first surface: */
    lf_vec3 known; /* of area lights and skies, and all other light that is not stored separately */
    lf_vec3 scattered; /* at the ends of branches */
    /* Properties of the ends, known without sampling paths. Sums over the branches: weight is the
     * transmittance times a rough albedo, 0..1. nearness is weight times D/Z of the unfolded chain,
     * nearness2 weight times its square. light is the transmittance times the reflected sunlight
     * (sunlight.h). If tinted, weight uses an albedo of 1, and albedo is the sum of albedo times
     * transmittance. */
    float weight, nearness, nearness2, light, albedo[LF_ALBEDO_NUMBERS];
} lf_delta_chain;

/* Adds the light from one delta lobe of the camera's first surface, times `share`. */
void lf_delta_chain_follow(lf_delta_chain *chain, const lf_event *first, const lf_delta *lobe,
                           float share);

#endif
