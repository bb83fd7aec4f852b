/* Lights, backdrop, film and ground for a file without a scene; private to render/. */
#ifndef LF_RENDER_ALONE_LOOK_H
#define LF_RENDER_ALONE_LOOK_H

#include <jansson.h>
#include <stdbool.h>

typedef enum lf_alone_look {
    LF_ALONE_STUDIO, /* meshes: a photo studio with a bright backdrop */
    LF_ALONE_DAY,    /* smoke and clouds: a sun and a constant sky, with a blue backdrop */
    LF_ALONE_NIGHT,  /* fire: only its own light, with a dark backdrop */
    LF_ALONE_BARE_MESH,
    LF_ALONE_BARE_VOLUME,
} lf_alone_look;

/* Sets "lights", "backdrop" and "film" of a document; yaw: degrees about +y from +z to the camera;
 * the lights turn with it. false: out of memory. */
bool lf_alone_light(json_t *document, lf_alone_look look, double yaw);

#endif
