/* Private to check*.c: the stripes that a manifest promises, from their definition in
 * quilt/prints.h alone. Shares no code with the interlacer, so that a mistake there shows here.
 *
 * A line is a row of pixels across the lenses, in the order in which the print is seen from the
 * front, so that a mirrored file is turned back first. Thread: any. */
#ifndef LF_QUILT_CHECK_STRIPES_H
#define LF_QUILT_CHECK_STRIPES_H

#include <stdbool.h>
#include <stddef.h>

#include "quilt/prints.h"

/* The stripes under a line. */
typedef struct lf_check_stripes {
    int n;                     /* pixels of the line */
    int n_views;               /* stripes of a lens */
    double pixel_mm, pitch_mm; /* pitch_mm: of the lenses */
    double phase_mm;           /* of the lens in the middle */
    bool nearest;              /* a pixel takes one stripe; false: it mixes by area */
    /* Slanted lenses: across = x cos + y lean (vertical), y cos + x lean (horizontal) */
    double cosine, lean;
    double along_mm, along_pixel_mm; /* place of the line along the lenses; a pixel's size there */
    /* Exact maps: an eye at this distance in front of the middle sees the print through a sheet of
     * this thickness and index; thickness 0: none */
    double thickness_mm, index, distance_mm;
} lf_check_stripes;

/* The stripes of a print with linear lenses, under a line of n pixels across them. dpi: across the
 * page and down it. */
lf_check_stripes lf_check_stripes_of(const lf_print *print, const double dpi[2], int n);
/* Position of an edge of a pixel (0..n) or of its middle (j + 1/2), in stripes. Whole numbers are
 * borders; stripe 0 is the first one of the middle lens. moved_mm: the stripes are so far to the
 * right. */
double lf_check_stripe_at(const lf_check_stripes *stripes, double edge, double moved_mm);
/* Pixels per stripe, along the line. */
double lf_check_stripe_px(const lf_check_stripes *stripes);
/* Stripes that a pixel reaches over. */
double lf_check_stripe_reach(const lf_check_stripes *stripes);
/* Share of a pixel that lies before a border, from the border's distance to its middle, in
 * stripes. */
double lf_check_stripe_share(const lf_check_stripes *stripes, double distance);

/* Width of a block of lenses that is measured by itself: its first pixel and the one after its
 * last. */
typedef struct lf_check_block {
    int first, end;
    double middle_mm; /* from the middle of the line */
} lf_check_block;

/* Values of a line that stripes are fitted to. */
typedef struct lf_check_line {
    const double *value; /* [n][channels] linear light; stored codes for nearest */
    const double *sigma; /* [n][channels] standard deviation of value; not read for nearest */
    int channels;
} lf_check_line;

/* The misfit of one block of a line: the least sum of squared differences, in standard deviations
 * (codes, for nearest), between its pixels and any stripes so moved. *out_freedom gets the number
 * of values beyond those that the stripes fit. scratch: room for 6 doubles per pixel of the block,
 * and 16 more. */
double lf_check_misfit(const lf_check_stripes *stripes, const lf_check_line *line,
                       const lf_check_block *block, double moved_mm, double *scratch,
                       double *out_freedom);

#endif
