/* Lights that the file of a mesh holds (KHR_lights_punctual of glTF), in world coordinates; private
 * to render/. */
#ifndef LF_RENDER_PUNCTUAL_H
#define LF_RENDER_PUNCTUAL_H

#define LF_MAX_PUNCTUAL 256 /* of a file */

typedef enum lf_punctual_kind {
    LF_PUNCTUAL_POINT,
    LF_PUNCTUAL_SPOT,
    LF_PUNCTUAL_DISTANT,
    LF_PUNCTUAL_KINDS
} lf_punctual_kind;

typedef struct lf_punctual {
    lf_punctual_kind kind;
    double position[3];  /* of no meaning where it is distant */
    double direction[3]; /* unit: where it shines; of no meaning where it is a point */
    double intensity[3]; /* as the file has it: candela, lux where it is distant */
    double outer, inner; /* radians: half of a spot's cone, and of its even part */
} lf_punctual;

/* Of one mesh, when the shutter opens and when it closes. */
typedef struct lf_punctuals {
    int n;
    lf_punctual *open, *close; /* [n]; close NULL: they stand still */
} lf_punctuals;

#endif
