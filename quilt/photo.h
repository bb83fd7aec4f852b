/* Private to quilt/: places pictures on frames of another shape. */
#ifndef LF_QUILT_PHOTO_H
#define LF_QUILT_PHOTO_H

#include "quilt/quilt.h"

/* Position of a picture on a frame, in the frame's unit of length. */
typedef struct lf_photo_place {
    double width, height; /* of the picture */
    double right, down;   /* offset of its middle from the frame's middle */
    double beside, above; /* total width of the borders at the sides; above and below; 0: none */
    double cut;           /* fraction of the picture that --photo fill cuts */
} lf_photo_place;

/* Places a picture of this aspect on a frame. If both borders together are at most slack, there is
 * no border: the picture covers the frame. */
lf_photo_place lf_photo_lay(const lf_photo *photo, double aspect, double frame_width,
                            double frame_height, double slack_width, double slack_height);

/* The orientation for lf_orient by which a picture of this aspect is rotated. */
int lf_photo_orientation(const lf_photo *photo, double aspect);

/* A picture of packed rows, 8-bit or float: exactly one of the pointers is not NULL. */
typedef struct lf_photo_picture {
    int width, height;
    double aspect; /* width / height when displayed */
    const uint8_t *data8;
    const float *data32;
} lf_photo_picture;

/* Scales a picture to a view of the same kind, [height][width][3], in linear light: by area to a
 * smaller size, linearly to a larger one. border, black 0 to white 1, fills the rest.
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_photo_draw(const lf_photo_picture *picture, const lf_photo_place *place,
                                     const lf_layout *view, float border, uint8_t *out8,
                                     float *out32);

#endif
