/* Lights in the file of a mesh (KHR_lights_punctual of glTF), in world coordinates; private to
 * render/. */
#ifndef LF_RENDER_PUNCTUAL_H
#define LF_RENDER_PUNCTUAL_H

#define LF_MAX_PUNCTUAL 256 /* per file */

typedef enum lf_punctual_kind {
    LF_PUNCTUAL_POINT,
    LF_PUNCTUAL_SPOT,
    LF_PUNCTUAL_DISTANT,
    LF_PUNCTUAL_KINDS
} lf_punctual_kind;

typedef struct lf_punctual {
    lf_punctual_kind kind;
    double position[3];  /* unused for distant lights */
    double direction[3]; /* unit, direction of emission; unused for point lights */
    double intensity[3]; /* as in the file: candela; lux for distant lights */
    double outer, inner; /* radians: half of a spot's cone, and of its uniform part */
} lf_punctual;

/* The lights of one mesh, when the shutter opens and when it closes. */
typedef struct lf_punctuals {
    int n;
    lf_punctual *open, *close; /* [n]; close NULL: static */
} lf_punctuals;

#endif
