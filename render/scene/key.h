/* Values of scene keys for objects of several kinds (lights, surfaces); private to render/. A kind
 * lists its keys once, as rows of base/param.h. Rows of materials also have a place (principled.h).
 * The parser, docs/scene.schema.json (checked by a test) and the kind's own file follow this list.
 */
#ifndef LF_RENDER_KEY_H
#define LF_RENDER_KEY_H

#include "base/param.h"
#include "render/scene/limits.h"

#define LF_MAX_RADIANCE 1e9
/* Index of refraction: at normal incidence all but 4e-6 of light is reflected. */
#define LF_MAX_INDEX 1e6
#define LF_MAX_TEMPERATURE_SCALE 1e6 /* per unit of a grid's value */
#define LF_MAX_KEYS 32               /* per kind */

/* Range of coordinates in a row. */
#define LF_COORDINATES .low = -LF_MAX_COORDINATE, .high = LF_MAX_COORDINATE

/* The value of one key in the file, or its default. */
typedef struct lf_value {
    double number[3]; /* numbers and angles: the first */
    const char *text; /* a file name; NULL: not given */
    int word;         /* its index in words */
    bool on;          /* of a switch */
    bool given;
} lf_value;

#endif
