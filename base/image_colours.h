/* Colour spaces of pictures: conversion from any red, green, blue and white to linear Rec. 709 with
 * its white, D65. Private to base. Thread safe. */
#ifndef LF_BASE_IMAGE_COLOURS_H
#define LF_BASE_IMAGE_COLOURS_H

#include "base/image.h"
#include "base/image_formats.h"

/* CIE 1931 (x, y) of the colours (1, 0, 0), (0, 1, 0), (0, 0, 1) and (1, 1, 1). */
typedef struct lf_chromaticities {
    double red[2], green[2], blue[2], white[2];
} lf_chromaticities;

extern const lf_chromaticities lf_rec709;
/* CIE X, Y, Z; white has equal values. */
extern const lf_chromaticities lf_xyz;

typedef struct lf_matrix3 {
    double m[3][3]; /* row-major */
} lf_matrix3;

typedef struct lf_image_colours {
    bool converts; /* otherwise the numbers are Rec. 709 already */
    lf_matrix3 to_rec709;
} lf_image_colours;

/* True if equal to Rec. 709 within a rounding of four digits: the numbers then stay unchanged. */
bool lf_is_rec709(const lf_chromaticities *c);

/* The conversion from these chromaticities. neutral (NULL: their white) becomes (1, 1, 1) times its
 * luminance, by Bradford's adaptation (K. M. Lam, 1985; the matrix of ICC.1, annex E). D65 is
 * (0.3127, 0.3290). LF_E_FORMAT: they span no colours: a triangle without area, a white outside it
 * or with y <= 0, or numbers that are not finite. */
LF_NODISCARD lf_status lf_colours_from(const lf_chromaticities *c, const double neutral[2],
                                       lf_image_colours *out);

/* The last step of every reader of float pictures. Values that are not finite are clamped and noted
 * in one line. +Inf becomes 65504, the largest half float, or the picture's largest finite number
 * if that is greater. NaN and -Inf become 0. Then colours are converted. */
void lf_image_settle(const lf_image_source *source, const lf_image_colours *colours,
                     lf_image32 *image);

#endif
