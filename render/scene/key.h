/* What a scene file may say of a kind of thing, as data; private to render/. A kind (of lights, of
 * surfaces) lists its keys once; the parser, docs/scene.schema.json (by a test) and the kind's own
 * file go by the list. */
#ifndef LF_RENDER_KEY_H
#define LF_RENDER_KEY_H

#include <stdbool.h>

#define LF_MAX_COORDINATE 1e9
#define LF_MAX_RADIANCE 1e9
#define LF_MAX_KEYS 8 /* of a kind */

typedef enum lf_key_type {
    LF_KEY_NUMBER,
    LF_KEY_ANGLE,     /* in degrees; the value is in radians */
    LF_KEY_COLOUR,    /* one number or three */
    LF_KEY_POINT,     /* world coordinates, within LF_MAX_COORDINATE */
    LF_KEY_DIRECTION, /* any length but 0; the value is unit */
    LF_KEY_CHOICE,    /* one of words */
    LF_KEY_FILE,      /* whose name ends in a dot and one of words */
} lf_key_type;

typedef struct lf_key {
    const char *name; /* NULL ends a list */
    lf_key_type type;
    /* Kinds that are said in one of two ways: 0, the key belongs to both; 1 or 2, to that one. The
     * first key of each must be there when the other's is not, and never beside it. */
    int form;
    bool exclusive;           /* an error where a thing of another kind says it (surfaces) */
    double lo, hi;            /* numbers, angles (degrees) and the parts of colours: closed */
    double fallback[3];       /* where the file says nothing, in the file's units */
    const char *const *words; /* ended by NULL */
} lf_key;

/* What the file says of one key. */
typedef struct lf_value {
    bool given;
    /* numbers and angles: the first; a choice: its place in words */
    double number[3];
    const char *text; /* of a file's name; NULL where none is given */
} lf_value;

#endif
