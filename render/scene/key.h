/* What a scene file says of a thing that comes in several kinds (lights, surfaces), key by key;
 * private to render/. A kind lists its keys once, as rows of base/param.h, of which those of
 * materials have a place (principled.h); the parser, docs/scene.schema.json (by a test) and the
 * kind's own file go by the list. */
#ifndef LF_RENDER_KEY_H
#define LF_RENDER_KEY_H

#include "base/param.h"
#include "render/scene/limits.h"

#define LF_MAX_RADIANCE 1e9
/* Of refraction: all but 4e-6 of light straight on is reflected. */
#define LF_MAX_INDEX 1e6
#define LF_MAX_TEMPERATURE_SCALE 1e6 /* per unit of a grid's value */
#define LF_MAX_KEYS 32               /* of a kind */

/* The range of a row of coordinates. */
#define LF_COORDINATES .low = -LF_MAX_COORDINATE, .high = LF_MAX_COORDINATE

/* What the file says of one key, or its initial value. */
typedef struct lf_value {
    double number[3]; /* numbers and angles: the first */
    const char *text; /* of a file's name; NULL where none is given */
    int word;         /* its place in words */
    bool on;          /* of a switch */
    bool given;
} lf_value;

#endif
