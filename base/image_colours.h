/* What the numbers of a picture mean as colours: from any red, green, blue and white to linear Rec.
 * 709 with its white, D65. Private to base. Thread safe. */
#ifndef LF_BASE_IMAGE_COLOURS_H
#define LF_BASE_IMAGE_COLOURS_H

#include "base/image.h"
#include "base/image_formats.h"

/* CIE 1931 (x, y) of what (1, 0, 0), (0, 1, 0), (0, 0, 1) and (1, 1, 1) look like. */
typedef struct lf_chromaticities {
    double red[2], green[2], blue[2], white[2];
} lf_chromaticities;

extern const lf_chromaticities lf_rec709;
/* Numbers that are CIE X, Y, Z; white is where all three are alike. */
extern const lf_chromaticities lf_xyz;

typedef struct lf_matrix3 {
    double m[3][3]; /* row-major */
} lf_matrix3;

typedef struct lf_image_colours {
    bool converts; /* else the numbers are those of Rec. 709 */
    lf_matrix3 to_rec709;
} lf_image_colours;

/* Rec. 709 within a rounding of four digits: its numbers stay as they are. */
bool lf_is_rec709(const lf_chromaticities *c);

/* The way from numbers of these chromaticities. neutral (NULL: their white) becomes (1, 1, 1) times
 * its luminance, by Bradford's adaptation (K. M. Lam, 1985; the matrix of ICC.1, annex E); D65 is
 * (0.3127, 0.3290). LF_E_FORMAT: they span no colours (a triangle without area, a white outside it
 * or with y not above 0, what is not finite). */
LF_NODISCARD lf_status lf_colours_from(const lf_chromaticities *c, const double neutral[2],
                                       lf_image_colours *out);

/* The last step of every reader of floats. What is not finite is clamped and noted in one line:
 * +Inf to 65504, the largest of half floats, or to the picture's largest finite number where that
 * is more; NaN and -Inf to 0. Then colours are converted. */
void lf_image_settle(const lf_image_source *source, const lf_image_colours *colours,
                     lf_image32 *image);

#endif
