/* Private to quilt/print: the lens sheet of a print as a height map, for printers that build lenses
 * of clear ink on top of the interlaced picture.
 *
 * A lens is a part of a cylinder of radius r (micro sheets: of a sphere). At the distance u from
 * its axis it is sqrt(r^2 - u^2) - sqrt(r^2 - reach^2) high, where reach is the distance of the
 * farthest point of its cell. Seen from the front, never mirrored. */
#ifndef LF_QUILT_RELIEF_H
#define LF_QUILT_RELIEF_H

#include "quilt/print/print.h"

typedef struct lf_relief {
    const lf_print *print;
    double pitch_mm;    /* of the sheet: mechanical if is_mechanical, otherwise visual */
    bool is_mechanical; /* thickness and distance are known */
    double radius_mm;
    const char *from;    /* the option that the radius follows from */
    double focal_mm;     /* behind the top of a lens, inside the material: n r / (n - 1) */
    double thickness_mm; /* from the top of a lens to the print; the focal length if unknown */
    double reach_mm, sag_mm;
    double cosine, sine; /* of the slant */
} lf_relief;

/* print must have passed lf_print_check. LF_E_ARG: radius, thickness and viewing angle are all
 * unknown; a lens of this radius is narrower than the pitch; lenses are higher than the sheet is
 * thick. */
LF_NODISCARD lf_status lf_relief_of(const lf_print *print, lf_relief *out, lf_error *err);
/* Height of a point above the feet of the lenses: x right, y down, mm from the middle of the print.
 */
double lf_relief_height(const lf_relief *relief, double x, double y);
/* Width of the spot that a lens images onto the print from far away, by its paraxial focus. */
double lf_relief_spot(const lf_relief *relief);
/* Notes a spot wider than a stripe, and a pitch that is not the sheet's. */
void lf_relief_note(const lf_relief *relief, lf_image_notes *notes);

/* Writes the raster of the print as 16-bit grey: white is sag_mm, black is the feet, and so is the
 * margin of the marks. Errors of lf_print_page_write. */
LF_NODISCARD lf_status lf_relief_write(const lf_relief *relief, const lf_print_run *run,
                                       lf_outfile *file, lf_error *err);

#endif
