/* Private to quilt/print: the pitch test chart (lenticular.md section 1.2).
 *
 * Bands across the lenses, one a pitch, the lowest pitch at the top, each a grating of one dark
 * line a lens, half a pitch wide, a line centred on the middle of the print. The label at both ends
 * of a band is its lines per inch. Above the bands stands the printer's raster, below them a ruler
 * with a tick every 10 mm. Under the sheet, from the distance the print is made for, the band of
 * the sheet's visual pitch is dark or bright as a whole; the others show fringes, 25.4 /
 * |difference| mm apart. For horizontal lenses all of it is turned by 90 degrees, clockwise.
 * Lengths are millimetres from the middle of the print along the bands, from its top across them.
 */
#ifndef LF_QUILT_CHART_H
#define LF_QUILT_CHART_H

#include "quilt/quilt.h"

typedef struct lf_chart {
    int n_bands, decimals;
    double lpi, step;        /* of the middle band, and from band to band */
    double width, height;    /* along the bands and across them */
    double top, band_height; /* of the first band; the gap below each is the tenth part of it */
    double half_width;       /* of the gratings */
    double label_height;
    double half_ruler;
    char dpi[48]; /* as it is written above the bands */
} lf_chart;

/* Lays the chart of a print out; its size is the print's. LF_E_ARG where a row of the table is out
 * of range, where chart_step is not within (0, chart_range], for a chart with options that are for
 * pictures (views, bleed, phase, stripes, reverse, marks), or with no room for its bands. */
LF_NODISCARD lf_status lf_chart_layout(const lf_print *print, lf_chart *out, lf_error *err);
/* Pitch of a band, 0 the topmost; in lines per inch. */
double lf_chart_lpi(const lf_chart *chart, int band);
/* How much of a pixel that reaches from x0 to x1 at y is ink, 0..1. */
double lf_chart_ink(const lf_chart *chart, double x0, double x1, double y);

#endif
