/* Light that comes to a camera by way of smooth surfaces, mirrors and clear glass alone (a delta
 * chain): both branches of every smooth dielectric are followed and weighed by Fresnel's equations,
 * instead of one that chance picks. Private to render/. docs/developer/estimators/surfaces.md,
 * "Both branches".
 *
 * A chain branches behind the camera's first surface as long as surfaces have nothing but delta
 * lobes. Each branch ends at the sky, in a medium, or at the first surface that scatters. The light
 * of lamps and skies is found exactly on the way; only what is scattered at the ends is random. */
#ifndef LF_RENDER_DELTA_CHAIN_H
#define LF_RENDER_DELTA_CHAIN_H

#include "render/transport/path/face_albedo.h"
#include "render/transport/path/path.h"
#include "render/transport/path/sunlight.h"

typedef struct lf_delta_chain {
    /* Given: */
    lf_tracer *tracer;
    int max_depth;               /* of vertices, as in lf_path_scattered */
    const lf_sunlight *sunlight; /* NULL: none is looked up */
    bool apart;                  /* what is scattered is to be told from the rest */
    bool tinted;                 /* the film keeps albedo: it is summed up, not a part of weight */
    /* of the first surface: D, Z, and how much Z a unit of length along the camera's ray is */
    float distance, z, forward;
    /* Summed up, to begin with zeros. Radiance at the first surface: */
    lf_vec3 known;     /* of lamps and skies, and all of it but what stands apart */
    lf_vec3 scattered; /* at the ends of branches */
    /* What there is to scatter there, known without any path. Sums over the branches: weight, what
     * comes through times a rough albedo, 0..1; weight times D/Z of the unfolded chain, and times
     * its square; what comes through times the reflected sunlight (sunlight.h). tinted: weight
     * counts the albedo as 1, and the albedo times what comes through is summed up by itself. */
    float weight, nearness, nearness2, light, albedo[LF_ALBEDO_NUMBERS];
} lf_delta_chain;

/* Adds what one delta lobe of the camera's first surface brings, times `share`. */
void lf_delta_chain_follow(lf_delta_chain *chain, const lf_event *first, const lf_delta *lobe,
                           float share);

#endif
