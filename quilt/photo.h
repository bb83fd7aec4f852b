/* Private to quilt/: pictures of one shape laid onto another. */
#ifndef LF_QUILT_PHOTO_H
#define LF_QUILT_PHOTO_H

#include "quilt/quilt.h"

/* Where a picture lies on a frame, in the frame's unit of length. */
typedef struct lf_photo_place {
    double width, height; /* of the picture */
    double right, down;   /* its middle from that of the frame */
    double beside, above; /* of the border, both sides together; 0: there is none */
    double cut;           /* share of the picture that --photo fill has cut */
} lf_photo_place;

/* A picture of this aspect on a frame. A border of at most slack, both sides together, is not made:
 * the picture covers the frame. */
lf_photo_place lf_photo_lay(const lf_photo *photo, double aspect, double frame_width,
                            double frame_height, double slack_width, double slack_height);

/* The orientation, as lf_orient has it, that a picture of this aspect is turned by. */
int lf_photo_orientation(const lf_photo *photo, double aspect);

/* A picture of packed rows, of 8 bits or of floats: one of both is not NULL. */
typedef struct lf_photo_picture {
    int width, height;
    double aspect; /* as it is meant to be seen */
    const uint8_t *data8;
    const float *data32;
} lf_photo_picture;

/* Scales a picture onto a view of the same kind, [height][width][3], by area where that makes it
 * smaller, else linearly, in linear light; border, black 0 to white 1, where it does not reach.
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_photo_draw(const lf_photo_picture *picture, const lf_photo_place *place,
                                     const lf_layout *view, float border, uint8_t *out8,
                                     float *out32);

#endif
