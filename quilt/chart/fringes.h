/* Private to quilt/chart: the fringes of a chart's bands, and the sheet that makes them. Lengths
 * and coordinates as in camera.h. */
#ifndef LF_QUILT_CHART_FRINGES_H
#define LF_QUILT_CHART_FRINGES_H

#include "quilt/chart/camera.h"

/* Sheets that are found: pitches beyond the chart's bands, in lpi, and turns, in degrees. */
#define LF_CHART_BEYOND_LPI 1.5
#define LF_CHART_MOST_SKEW 2.0

/* How the sheet bends the camera's rays. */
typedef struct lf_chart_optics {
    double eye[2], distance; /* of the camera: foot, height */
    double thickness, index;
} lf_chart_optics;

/* The point of the lenses' plane through which a point of the print is seen. */
void lf_chart_through(const lf_chart_optics *optics, double x, double y, double out[2]);
/* thickness / index */
double lf_chart_reach(const lf_chart_optics *optics);

/* A photo's light: linear, as means of small areas. */
typedef struct lf_chart_light {
    const lf_chart_camera *camera;
    int width, height;
    const uint8_t *data; /* [height][width][3] */
    double linear[256];
    double px_per_mm;
    int64_t n_points, n_clipped; /* of all areas so far */
} lf_chart_light;

/* Mean over an area about (x, y); negative: outside the photo. */
double lf_chart_light_at(lf_chart_light *light, double x, double y, double width, double height);

/* The bands' light at a grid of points. */
typedef struct lf_chart_samples {
    int n_bands, rows_of_band, n_columns;
    double *x, *y;     /* [n_columns], [n_bands rows_of_band] */
    double *lens;      /* [rows][n_columns][2]: lf_chart_through */
    double *light;     /* [rows][n_columns] */
    double half_width; /* largest |x| */
} lf_chart_samples;

/* LF_E_FORMAT: the chart is not wholly in the photo. LF_E_NOMEM. Release by
 * lf_chart_samples_finish, also after failure. */
LF_NODISCARD lf_status lf_chart_samples_take(const lf_chart *chart, const lf_chart_optics *optics,
                                             lf_chart_light *light, const char *where,
                                             lf_chart_samples *out, lf_error *err);
void lf_chart_samples_finish(lf_chart_samples *samples);

/* The sheet, by its lenses: lens k is the line u = (k + cycles) / per_mm, u = x cos a + y sin a. */
typedef struct lf_chart_sheet {
    double per_mm, cycles, angle;
    double covariance[3][3]; /* of these three */
    double explained;        /* share of the fringes' variance that the fit explains */
    double contrast;         /* of what is left without fringes, relative to the mean light */
} lf_chart_sheet;

/* LF_E_NOMEM; LF_E_ARG: the chart is too large. Low `explained` means that there is no such
 * sheet. */
LF_NODISCARD lf_status lf_chart_sheet_fit(const lf_chart *chart, const lf_chart_optics *optics,
                                          const lf_chart_samples *samples, lf_chart_sheet *out,
                                          lf_error *err);
/* Which place of the middle band's cells is seen at (x, y), in cells from their middle: -1/2..1/2.
 */
double lf_chart_cell_at(const lf_chart *chart, const lf_chart_optics *optics,
                        const lf_chart_sheet *sheet, double x, double y);

#endif
