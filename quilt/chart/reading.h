/* Reads a photo of a printed pitch test chart with the lens sheet on it.
 *
 * The tags of the chart give the camera's place. A line of the print at s is seen through the lens
 * at P, where s = P + t tan(asin(sin(theta) / n)) away from the foot of the camera, and theta is
 * the angle of the ray to the sheet's normal. A band of pitch f (lines per mm) then shows the
 * fringe cos(2 pi (f s - (u - phase) / p)), where u is P across the lenses and p the mechanical
 * pitch. One least squares fit over all bands gives p, phase and the angle of u; brightness and
 * contrast of each band are polynomials of the place. Pure; thread safe on different objects. */
#ifndef LF_QUILT_CHART_READING_H
#define LF_QUILT_CHART_READING_H

#include "quilt/prints.h"

struct json_t;

#define LF_CHART_KERNEL 3 /* views on each side of the own one */

/* A photo and what is known of it. Zeroed members are unknown. */
typedef struct lf_chart_photo {
    const uint8_t *data; /* [height][width][3], sRGB, upright */
    int width, height;
    double focal_35mm;   /* focal length, as if the diagonal were 43.27 mm */
    double distance_mm;  /* of the viewer; of the camera, too, if the photo does not tell it */
    double thickness_mm; /* of the sheet, from a lens's vertex to the print */
    double index;        /* refractive index of the sheet; 0: 1.56 */
} lf_chart_photo;

typedef struct lf_chart_reading {
    double visual_lpi, error_lpi;        /* at distance_mm; standard error */
    double camera_lpi, error_camera_lpi; /* the same at the camera's distance */
    double mechanical_lpi;               /* of the sheet; 0: thickness unknown */
    double distance_mm;
    double phase_mm, error_phase_mm; /* of the lens at the middle, to the right: +- half a pitch */
    double skew_deg, error_skew_deg; /* clockwise */
    double camera_mm[3]; /* right and down from the middle of the chart, distance from its plane */
    /* has_order false: seen from where both orders look alike */
    bool has_order, is_reversed;
    int n_crosstalk;                           /* 2 LF_CHART_KERNEL + 1, or 0: unknown */
    double crosstalk[2 * LF_CHART_KERNEL + 1]; /* share of view i + k, k = -LF_CHART_KERNEL … */
    double fit;           /* share of the fringes' variance that the model explains */
    double px_per_mm;     /* of the photo, at the middle of the chart */
    lf_image_notes notes; /* warnings */
} lf_chart_reading;

/* Reads a photo of the chart that lf_chart_write writes for this print. where names the photo in
 * errors. LF_E_FORMAT: nothing can be read from the photo, with the reason; LF_E_ARG: no such
 * chart, or the camera's distance is needed; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_chart_read(const lf_print *print, const lf_chart_photo *photo,
                                     const char *where, lf_chart_reading *out, lf_error *err);
/* The reading as quiltprint calibrate takes it. sha256: of the chart's file; may be NULL. A new
 * reference; NULL: out of memory. */
struct json_t *lf_chart_reading_json(const lf_chart_reading *reading, const char *sha256);

#endif
