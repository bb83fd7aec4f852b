/* Private to quilt/chart: the pitch test chart.
 *
 * Bands run across the lenses, one per pitch, the lowest pitch at the top. Each band is a grating
 * of one dark line per lens, half a pitch wide, with a line centred on the middle of the print. The
 * label at both ends of a band is its lines per inch. The printer's raster is printed above the
 * bands, a ruler with a tick every 10 mm below them.
 *
 * Under the sheet, from the distance the print is made for, the band with the sheet's visual pitch
 * is uniformly dark or bright. The others show fringes, 25.4 / |difference| mm apart. For
 * horizontal lenses the chart is rotated by 90 degrees, clockwise.
 *
 * A chart with room for them has two strips, above and below the bands. At their ends (and in their
 * middle, on a wide chart) are marks that a camera finds: tags of the family tag36h11 of
 * libapriltag. Their numbers follow from the chart (lf_chart_first_tag). Between the tags are
 * patches (chart_patch.c), as far as there is room. A ruler runs down the left edge.
 *
 * Lengths are millimetres: along the bands from the middle of the print, across them from its top.
 */
#ifndef LF_QUILT_CHART_H
#define LF_QUILT_CHART_H

#include "quilt/prints.h"

#define LF_CHART_GAP 0.1      /* below each band, as a fraction of it */
#define LF_CHART_TAG_CELLS 10 /* of a tag with its white border */

enum { LF_CHART_TAGS = 6 };

/* Groups of patches in the strips. */
typedef enum lf_chart_group {
    LF_CHART_CODE_PATCHES,  /* only the stripe of one view of LF_CHART_CODES is white */
    LF_CHART_PIXEL_PATCHES, /* one-pixel lines across and down; gratings for lenses that run the
                             * wrong way; white and black */
    LF_CHART_ORDER_PATCHES, /* 1, 2, 3: seen from the left, the middle and the right */
    LF_CHART_PHASE_PATCHES, /* gratings of three pitches and eight phases */
    LF_CHART_GROUPS
} lf_chart_group;

typedef struct lf_chart_place {
    bool present;
    double x, y; /* left, top */
} lf_chart_place;

typedef struct lf_chart {
    int n_bands, decimals;
    double lpi, step;        /* of the middle band; from band to band */
    double width, height;    /* along the bands and across them */
    double top, band_height; /* of the first band */
    double half_width;       /* half width of the gratings */
    double label_height;
    double half_ruler;
    double pixel_along, pixel_across; /* size of a printed pixel: along the bands, across them */
    char dpi[48];                     /* text above the bands */
    /* marks for a camera; zeroed on a chart without room for them */
    bool is_marked;
    double cell, strip; /* of a tag; height of a strip */
    int first_tag;      /* number of tag 0 */
    bool has_middle_tags;
    lf_chart_place groups[LF_CHART_GROUPS];
    uint8_t tags[LF_CHART_TAGS][LF_CHART_TAG_CELLS * LF_CHART_TAG_CELLS]; /* 1: ink; chart_tag.c */
} lf_chart;

/* A pixel of the chart; y from the top. */
typedef struct lf_chart_box {
    double x0, x1, y0, y1;
} lf_chart_box;

/* Lays out the chart of a print; its size is the print's. LF_E_ARG: a value out of its table's
 * range; chart_step not within (0, chart_range]; options that are only for pictures (views, bleed,
 * phase, stripes, reverse, marks); no room for the bands. `tags` stay empty. */
LF_NODISCARD lf_status lf_chart_layout(const lf_print *print, lf_chart *out, lf_error *err);
/* Pitch of a band in lines per inch; band 0 is the topmost. */
double lf_chart_lpi(const lf_chart *chart, int band);
/* Notes the parts for which the chart has no room; nothing for a complete one. */
void lf_chart_note_left_out(const lf_chart *chart, lf_image_notes *notes);
/* Fraction of ink, 0..1, in a pixel. */
double lf_chart_ink(const lf_chart *chart, const lf_chart_box *box);

/* ------------------------------------------------------------------------------------- parts -- */

/* Ink to the left of x on stripes that cover [from, to) of each cell; cell k is [k, k + 1) pitch.
 */
double lf_chart_stripes_before(double x, double pitch, double from, double to);
/* Width and height of a group. */
double lf_chart_group_width(lf_chart_group group);
double lf_chart_group_height(const lf_chart *chart);
/* Ink of the patches, in a box within the strips. */
double lf_chart_patch_ink(const lf_chart *chart, const lf_chart_box *box);
/* The places of single patches within their group, from its left edge. Code patches do not follow
 * each other in the order of their views: otherwise fringes of one pitch could hide most of them.
 */
double lf_chart_code_at(int place, int *out_view, double *out_width);
/* Part 0 and 1: one-pixel lines; 2 to 5: gratings across the lenses' usual direction, each a
 * quarter of a pitch further; 6: white; 7: black. */
double lf_chart_pixel_patch_at(int part, double *out_width);

/* Draws the tags' bits by the family's table. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_chart_draw_tags(lf_chart *chart, lf_error *err);
/* True if the chart has tag i; its left and top edge with the white border. */
bool lf_chart_tag_place(const lf_chart *chart, int i, double *out_x, double *out_y);
double lf_chart_tag_ink(const lf_chart *chart, const lf_chart_box *box);

#endif
