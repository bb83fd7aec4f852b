/* Light, backdrop, film and ground of a file without a scene; private to render/. */
#ifndef LF_RENDER_ALONE_LOOK_H
#define LF_RENDER_ALONE_LOOK_H

#include <jansson.h>
#include <stdbool.h>

typedef enum lf_alone_look {
    LF_ALONE_STUDIO, /* meshes: a photographer's studio with a light backdrop */
    LF_ALONE_DAY,    /* smoke and clouds: a sun and an even sky before a blue backdrop */
    LF_ALONE_NIGHT,  /* fire: its own light before a dark backdrop */
    LF_ALONE_BARE_MESH,
    LF_ALONE_BARE_VOLUME,
} lf_alone_look;

/* Sets "lights", "backdrop" and "film" of a document; yaw: degrees about +y by which the camera
 * stands to the right of +z, and the lights with it. false: out of memory. */
bool lf_alone_light(json_t *document, lf_alone_look look, double yaw);

#endif
