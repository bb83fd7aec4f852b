/* Private to quilt/print: which images the stripes of a lens show. A flip or an animation may have
 * blended frames between its images, and guard stripes between its frames. Pure functions.
 *
 * Between two images, --morph M puts M frames, which mix the two in equal steps of linear light: n
 * images are n + (n - 1) M frames. Each frame of f has the same number of the n_views - f G stripes
 * that are not guards, to one. Behind each frame there are G guards, also behind the last one,
 * because the next lens begins with the first frame: half of those, rounded down, are at the
 * beginning of the lens. */
#ifndef LF_QUILT_FLIP_H
#define LF_QUILT_FLIP_H

#include "quilt/prints.h"

typedef struct lf_stripe_content {
    bool neutral; /* a guard of one light, no image */
    float light;  /* of a neutral one: 0 black, 1 white */
    int image;
    int next;    /* the image that is mixed in … */
    float blend; /* … and its share, 0 up to 1 */
} lf_stripe_content;

/* Frames that n images make. */
int lf_flip_frames(const lf_print *print, int n_images);
/* What stripe view i of 0..n_views-1 shows. print must have passed lf_flip_check. */
lf_stripe_content lf_flip_content(const lf_print *print, int n_images, int i);
/* LF_E_ARG: guards leave no stripe for some of the frames. */
LF_NODISCARD lf_status lf_flip_check(const lf_print *print, int n_images, const char *where,
                                     lf_error *err);
/* Notes what may surprise: frames that are not shown, frames of unlike width, lenses that show each
 * eye another frame. */
void lf_flip_note(const lf_print *print, int n_images, lf_image_notes *notes);
/* The stripes of a lens from first to last, "0 0 - 1 1 -", in buf; "" if they show all images, one
 * after the other, without guards and blends.
 * Returns buf. */
char *lf_flip_text(const lf_print *print, int n_images, char *buf, size_t size);

#endif
