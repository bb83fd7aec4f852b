/* Private to quilt/print: the pitch test chart.
 *
 * Bands run across the lenses, one per pitch, the lowest pitch at the top. Each band is a grating
 * of one dark line per lens, half a pitch wide, with a line centred on the middle of the print. The
 * label at both ends of a band is its lines per inch. The printer's raster is printed above the
 * bands, a ruler with a tick every 10 mm below them.
 *
 * Under the sheet, from the distance the print is made for, the band with the sheet's visual pitch
 * is uniformly dark or bright. The others show fringes, 25.4 / |difference| mm apart. For
 * horizontal lenses the chart is rotated by 90 degrees, clockwise. Lengths are millimetres: along
 * the bands from the middle of the print, across them from its top. */
#ifndef LF_QUILT_CHART_H
#define LF_QUILT_CHART_H

#include "quilt/prints.h"

typedef struct lf_chart {
    int n_bands, decimals;
    double lpi, step;        /* of the middle band; from band to band */
    double width, height;    /* along the bands and across them */
    double top, band_height; /* of the first band; the gap below each band is a tenth of it */
    double half_width;       /* half width of the gratings */
    double label_height;
    double half_ruler;
    char dpi[48]; /* text above the bands */
} lf_chart;

/* Lays out the chart of a print; its size is the print's. LF_E_ARG: a value out of its table's
 * range; chart_step not within (0, chart_range]; options that are only for pictures (views, bleed,
 * phase, stripes, reverse, marks); no room for the bands. */
LF_NODISCARD lf_status lf_chart_layout(const lf_print *print, lf_chart *out, lf_error *err);
/* Pitch of a band in lines per inch; band 0 is the topmost. */
double lf_chart_lpi(const lf_chart *chart, int band);
/* Fraction of ink, 0..1, in a pixel from x0 to x1 at y. */
double lf_chart_ink(const lf_chart *chart, double x0, double x1, double y);

#endif
