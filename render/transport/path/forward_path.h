/* Light paths: from a light over surfaces, each vertex behind the first a pivot for every view that
 * sees it; private to render/. emitters.h has their starts, light_balance.h their balance with
 * camera paths.
 *
 * A path ends in a medium, behind rough glass, where it escapes, and after max_depth vertices. It
 * passes alpha surfaces with the probability of camera paths, which cancels in the balance.
 * Scattering at shading normals is that of camera paths, with the ratio of geometric cosines that
 * makes it light's (Veach 1997, 5.3). */
#ifndef LF_RENDER_FORWARD_PATH_H
#define LF_RENDER_FORWARD_PATH_H

#include "render/transport/path/path.h"

/* A vertex of a light path that may be a pivot. */
typedef struct lf_forward_vertex {
    const lf_event *event; /* on a surface with a lobe */
    lf_vec3 back;          /* unit, towards the vertex before */
    /* the radiance that it sends to a camera is f(camera, back) times this, per unit area */
    lf_vec3 flux;
    /* p_light over p_suffix: the density of this path for each light path, over that of the part
     * behind the pivot's first direction by a camera path. INFINITY: no camera path finds it */
    float rate;
    int cell; /* lf_emitters_draw */
} lf_forward_vertex;

typedef void (*lf_forward_fn)(void *context, const lf_forward_vertex *vertex);

/* Traces the light path of the tracer's random numbers. */
void lf_forward_trace(lf_tracer *tracer, const lf_emitters *emitters, int max_depth,
                      lf_forward_fn fn, void *context);

#endif
