/* Private to quilt/chart: the tags of a chart in a photo, and the camera that took it.
 *
 * Chart coordinates are millimetres from the middle of the chart: x to the right, y down, z away
 * from the viewer. Pixels have their integer coordinates at their corners. */
#ifndef LF_QUILT_CHART_CAMERA_H
#define LF_QUILT_CHART_CAMERA_H

#include "quilt/chart/chart.h"

enum { LF_CHART_CORNERS = 4 * LF_CHART_TAGS };

typedef struct lf_chart_corners {
    int n, n_tags;
    double at[LF_CHART_CORNERS][2];   /* mm */
    double side[LF_CHART_CORNERS][2]; /* from the tag's middle: -1 or 1 */
    double px[LF_CHART_CORNERS][2];
} lf_chart_corners;

typedef struct lf_chart_grey {
    int width, height;
    const uint8_t *data; /* [height][width] */
} lf_chart_grey;

/* Finds the chart's tags. LF_E_FORMAT: none, or of another chart, or mirrored, or too few;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_chart_find_tags(const lf_chart *chart, const lf_chart_grey *grey,
                                          const char *where, lf_chart_corners *out, lf_error *err);

typedef struct lf_chart_camera {
    double middle[2]; /* of the photo, px */
    double focal;     /* px */
    double k1;        /* radial distortion: (1 + k1 r^2), r in units of the focal length */
    /* mm by which all tags seem to reach out on each side: lenses cut them into columns */
    double growth[2];
    double turn[3][3], move[3];
    double eye[3];      /* eye[2] < 0: the distance from the chart, negated */
    double sd_distance; /* standard errors: of the distance, as a fraction of it */
    double sd_aside;    /* … of eye[0] / distance */
    double sd_roll;     /* … of the turn about the chart's normal, radians */
    double rms_px;      /* how far corners are from their places */
} lf_chart_camera;

/* What is known of the camera; 0: unknown. */
typedef struct lf_chart_hint {
    int width, height;
    double focal, sd_focal; /* px; standard error, as a fraction of it */
    double distance;
} lf_chart_hint;

/* LF_E_FORMAT: the corners are not those of a flat chart. */
LF_NODISCARD lf_status lf_chart_camera_fit(const lf_chart_corners *corners,
                                           const lf_chart_hint *hint, const char *where,
                                           lf_chart_camera *out, lf_error *err);
/* The pixel that shows (x, y); false: behind the camera. */
bool lf_chart_project(const lf_chart_camera *camera, double x, double y, double *out_px,
                      double *out_py);

/* Solves the n x n system a x = b in place (b becomes x) by Gauss's method; false: singular. */
bool lf_chart_solve(int n, int m, double *a, double *b);

#endif
