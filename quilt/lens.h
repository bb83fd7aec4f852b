/* The phase of a lens sheet: where a point lies under its lens. Panels and prints share it.
 *
 * The phase counts lenses across the sheet. It is affine in the place and the channel of a
 * subpixel. Prints seen close add a radial map: an eye in front of the middle sees a point of the
 * print through a lens that lies nearer to the middle. Pure functions; thread safe. */
#ifndef LF_QUILT_LENS_H
#define LF_QUILT_LENS_H

#include "quilt/prints.h"

/* phase = (x * right + channel + y * down) * scale - offset, with the operations in this order. */
typedef struct lf_lens {
    double right, down;   /* weights of x and y */
    double channel[3];    /* of red, green and blue, added to x * right */
    double scale, offset; /* lenses per unit of place; lenses */
    bool from_right;      /* views count from the right (lower) end of a lens */
    /* Radial map, in units of place; thickness 0: none. */
    double thickness, index, distance;
} lf_lens;

/* The two terms of the place; a caller may tabulate them. */
static inline double lf_lens_across(const lf_lens *lens, double x, int channel)
{
    return x * lens->right + lens->channel[channel];
}

static inline double lf_lens_along(const lf_lens *lens, double y)
{
    return y * lens->down;
}

/* The phase without the radial map. */
static inline double lf_lens_flat(const lf_lens *lens, double x, double y, int channel)
{
    return (lf_lens_across(lens, x, channel) + lf_lens_along(lens, y)) * lens->scale - lens->offset;
}

/* The phase at (x, y) in lenses, not wrapped. channel: 0 red, 1 green, 2 blue. */
double lf_lens_phase(const lf_lens *lens, double x, double y, int channel);

/* The radial map: the factor of a point at this distance from the middle. Point times factor is
 * the point of the lens plane through which the eye sees it, by Snell's law; 1 without a map. */
double lf_lens_factor(const lf_lens *lens, double radius);
/* How far off, in units of place, a point of the lens plane is at most, when its factor is
 * interpolated linearly between two points of a straight line that are `step` apart. */
double lf_lens_factor_error(const lf_lens *lens, double step);

#define LF_DEGREE (3.14159265358979323846 / 180.0) /* in radians */

/* By how much a sheet's lines on the print are wider than its lenses, for an eye at this distance:
 * 1 + t / (n D), from rays through the top of a lens. Distances of 0 are infinite: 1. */
static inline double lf_lens_enlargement(double thickness, double index, double distance)
{
    return distance > 0.0 ? 1.0 + thickness / (index * distance) : 1.0;
}

/* The same for a print; 1 if thickness or distance is unknown. */
static inline double lf_lens_enlargement_of(const lf_print *print)
{
    const lf_optics *o = &print->optics;
    return o->thickness_mm > 0.0
               ? lf_lens_enlargement(o->thickness_mm, lf_optics_index(o), o->distance_mm)
               : 1.0;
}

/* Cosine and sine of the slant; exactly 1 and 0 without one. */
double lf_print_cos(const lf_print *print);
double lf_print_sin(const lf_print *print);

/* Panels: x in panel widths from the left, y in panel heights from the bottom, both at the middle
 * of the pixel. With subpixel cells, channel is 0 and the caller adds the cell's offsets. */
lf_lens lf_lens_of_panel(const lf_calibration *calibration, lf_invert invert);

/* Prints: x right, y down, mm from the middle of the print. Lens k has its axis at the phase k.
 * print must have passed lf_print_check. */
lf_lens lf_lens_of_print(const lf_print *print);
/* Micro sheets: the phase down the rows of lenses, in rows. */
lf_lens lf_lens_of_print_rows(const lf_print *print);

#endif
