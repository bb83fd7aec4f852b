/* Private to the print_*.c files: the parts of the lenticular print (quilt.h has the conventions).
 *
 *   views -> lines of display light at lens resolution (print_views.c) -> stripes
 *   (print_stripes.c) -> device colour (print_colour.c) -> TIFF (print_tiff.c) and manifest
 *   (print_manifest.c).
 *
 * All steps are run by print.c; the pitch test chart (quilt/chart) is drawn on a page of its own.
 * Objects are used by one thread. */
#ifndef LF_QUILT_PRINT_H
#define LF_QUILT_PRINT_H

#include <jansson.h>

#include "quilt/axis.h"
#include "quilt/lens.h"
#include "quilt/photo.h"
#include "quilt/print/pdf.h"
#include "quilt/prints.h"

/* ------------------------------------------------------------------------------------ raster -- */

/* Dots per inch down the page, across the lenses and along them. */
static inline double lf_print_dpi_down(const lf_print *print)
{
    return print->dpi_down > 0.0 ? print->dpi_down : print->dpi;
}

static inline double lf_print_dpi_across(const lf_print *print)
{
    return print->horizontal ? lf_print_dpi_down(print) : print->dpi;
}

static inline double lf_print_dpi_along(const lf_print *print)
{
    return print->horizontal ? print->dpi : lf_print_dpi_down(print);
}

static inline double lf_print_pitch_mm(const lf_print *print)
{
    return 25.4 / print->lpi;
}

/* True if all rows (columns) have the same stripes. */
static inline bool lf_print_is_separable(const lf_print *print)
{
    return print->optics.slant == 0.0 && !lf_print_is_micro(print) && !lf_print_is_exact(print);
}

/* Printer pixels of a lens, along a row for vertical lenses and along a column for horizontal
 * ones. */
double lf_print_pixels_per_lens(const lf_print *print);

/* "600", "720x1440", as options have it; returns buf. */
char *lf_print_dpi_text(const lf_print *print, char *buf, size_t size);

/* ----------------------------------------------------------------------------------- stripes -- */

/* The content of one printer pixel: at most three stripes with weights of sum 1. Unused entries
 * repeat the first with weight 0. */
typedef struct lf_stripe_mix {
    int32_t lens[3]; /* 0..n_lenses-1 */
    int32_t view[3]; /* 0..n_views-1 */
    float weight[3];
} lf_stripe_mix;

/* pixel: index across the lenses (x for vertical ones, y for horizontal), before mirroring. */
void lf_stripe_mix_at(const lf_print *print, const lf_print_shape *shape, int pixel,
                      lf_stripe_mix *out);

/* ----------------------------------------------------------------------------------- leaning -- */

/* How a linear coordinate is distributed over a pixel: a trapezoid, the convolution of two boxes
 * with these half widths, wide >= narrow >= 0, wide > 0. */
typedef struct lf_pixel_spread {
    double wide, narrow;
} lf_pixel_spread;

/* From the change of the coordinate over the pixel's width and over its height. */
lf_pixel_spread lf_pixel_spread_of(double change_right, double change_down);
/* The fraction of the pixel's area whose coordinate is below that of its middle + t; exact. */
double lf_pixel_share(const lf_pixel_spread *spread, double t);

/* ------------------------------------------------------------------------------------- views -- */

/* The source of display light for the interlacer. */
typedef struct lf_print_source {
    const lf_print *print;
    const lf_views32 *views;
    const lf_tone *tone;
    bool resampled; /* views do not have the print's shape; `place` positions them, in mm */
    lf_photo_place place;
    /* floats from sample to sample of a view, across the lenses and along them */
    size_t across_step, along_step;
    int n_across_in, n_along_in; /* samples of a view in these directions */
    lf_axis_filter across, along;
    float *line; /* scratch: one line of a view, room for line_pixels */
    size_t line_pixels;
} lf_print_source;

/* Borrows print, views and tone. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_print_source_init(lf_print_source *source, const lf_print *print,
                                            const lf_print_shape *shape, const lf_views32 *views,
                                            const lf_tone *tone);
void lf_print_source_finish(lf_print_source *source);
/* Gives a copy of a source a line of its own, so that another thread can use it. The caller frees
 * the copy's line, and finishes the original last. LF_E_NOMEM, with line NULL. */
LF_NODISCARD lf_status lf_print_source_share(lf_print_source *copy);
/* Linear display light of stripe view i. across: at printer row (column) `along`, all lenses
 * [n_lenses][3]. along: of one lens, all rows (columns) [n_along][3]. */
void lf_print_source_across(const lf_print_source *source, int i, int along, float *out);
void lf_print_source_along(const lf_print_source *source, int i, int lens, float *out);
/* The n rows (columns) of that line from the first on alone, with the same values. */
void lf_print_source_part(const lf_print_source *source, int i, int lens, int first, int n,
                          float *out);
/* One sample, [3]. */
void lf_print_source_point(const lf_print_source *source, int i, int across, int along, float *out);

/* ------------------------------------------------------------------------------------ colour -- */

typedef struct lf_print_colour lf_print_colour;

/* Loads the profile or creates sRGB's. LF_E_FORMAT, LF_E_PATH, LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_print_colour_create(const lf_print *print, lf_print_colour **out,
                                              lf_error *err);
void lf_print_colour_destroy(lf_print_colour *colour);
int lf_print_colour_channels(const lf_print_colour *colour); /* 3 RGB, 4 CMYK */
/* The name in the profile: printable ASCII, "unnamed" if it has none. */
const char *lf_print_colour_name(const lf_print_colour *colour);
const void *lf_print_colour_profile(const lf_print_colour *colour, size_t *out_size);
/* n pixels of linear display light (Rec. 709, 0..1) -> device values of print->bits bits, native
 * byte order. */
void lf_print_colour_encode(const lf_print_colour *colour, size_t n, const float *in, void *out);

/* ---------------------------------------------------------------------------- general sheets -- */

/* Rows of prints that are not separable. All references are borrowed. */

/* Linear sheets, slanted or with an exact map. */
typedef struct lf_slanted lf_slanted;
LF_NODISCARD lf_status lf_slanted_create(const lf_print *print, const lf_print_shape *shape,
                                         const lf_print_source *source, lf_slanted **out);
void lf_slanted_destroy(lf_slanted *slanted);
/* Linear light of row y of the picture, [raster_width][3]. Rows in any order. */
void lf_slanted_row(lf_slanted *slanted, int y, float *row);
/* Vertical lenses: the samples of the last row, [n_views][n_lenses][3]. */
const float *lf_slanted_samples(const lf_slanted *slanted);

/* Micro sheets. */
typedef struct lf_micro lf_micro;
LF_NODISCARD lf_status lf_micro_create(const lf_print *print, const lf_print_shape *shape,
                                       const lf_print_source *source, lf_micro **out);
void lf_micro_destroy(lf_micro *micro);
void lf_micro_row(lf_micro *micro, int y, float *row);

/* -------------------------------------------------------------------------------------- page -- */

/* The most strips of a page that are made at the same time. */
#define LF_PRINT_MAX_HANDS 16

/* The content of a file. */
typedef struct lf_print_page {
    const lf_print *print; /* dpi, bits, compression, mirror; trim size and bleed for the boxes */
    int width, height;     /* pixels */
    const char *description;
    /* linear light of row y, [width][3], before mirroring. The rows of a strip come in order. */
    void (*draw)(void *context, int y, float *row);
    void *context;
    /* Contexts for strips that are drawn at the same time, each by one thread. n_hands 0: `context`
     * alone. */
    void *const *hands;
    int n_hands;
    const struct lf_sheet *sheet; /* the copies; NULL: one in the middle */
} lf_print_page;

/* How many hands a page can use in this run: 1..LF_PRINT_MAX_HANDS. */
int lf_print_hands(const lf_print_run *run);

/* Writes a whole page as run->format says. colour NULL: a TIFF of 16-bit grey; rows are then
 * [width], 0..1, and are not mirrored. The bytes do not depend on the hands. rows_per_strip 0 =
 * chosen from the row's size. LF_E_ARG (the page is too large for PDF), LF_E_IO (also: no room on
 * the disk, checked first), LF_E_NOMEM, LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_print_page_write(const lf_print_page *page, const lf_print_colour *colour,
                                           const lf_print_run *run, int rows_per_strip,
                                           lf_outfile *file, lf_error *err);

/* Rows of a page on their way to the file. */
typedef struct lf_print_strip {
    int index, n_rows;
    bool is_last;
    unsigned char *data; /* device values, native byte order, without gaps */
    size_t size;
    lf_pdf_strip packed; /* PDF only */
} lf_print_strip;

/* A format of files. */
typedef struct lf_print_sink {
    /* Starts the file; *out_state is released by close or abandon. */
    lf_status (*open)(lf_outfile *file, const lf_print_page *page, const lf_print_colour *colour,
                      int rows_per_strip, void **out_state, lf_error *err);
    int (*strip_rows)(const void *state);
    /* Prepares a strip, on any thread, in any order; NULL: nothing to prepare. */
    lf_status (*pack)(const void *state, lf_print_strip *strip);
    /* Takes the strips in order. */
    lf_status (*write)(void *state, lf_print_strip *strip, lf_error *err);
    /* Ends the file and releases the state, also on failure. */
    lf_status (*close)(void *state, lf_error *err);
    void (*abandon)(void *state); /* accepts NULL */
} lf_print_sink;

extern const lf_print_sink lf_print_tiff_sink, lf_print_pdf_sink;

/* LF_E_IO: the disk of an open file has no room for a raster of so many bytes (print_room.c). */
LF_NODISCARD lf_status lf_print_room_for(const lf_print *print, lf_print_format format,
                                         double raster_bytes, const lf_outfile *file,
                                         lf_error *err);

/* -------------------------------------------------------------------------------------- tiff -- */

typedef struct lf_print_tiff lf_print_tiff;

/* Sets every tag. rows_per_strip 0 = chosen from the row's size. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_print_tiff_open(lf_outfile *file, const lf_print_page *page,
                                          const lf_print_colour *colour, int rows_per_strip,
                                          lf_print_tiff **out, lf_error *err);
int lf_print_tiff_strip_rows(const lf_print_tiff *tiff);
/* Writes a strip, in rising order, with all of its rows. */
LF_NODISCARD lf_status lf_print_tiff_strip(lf_print_tiff *tiff, int strip, void *data, size_t size,
                                           lf_error *err);
/* Writes the directory and releases *tiff, also on failure. */
LF_NODISCARD lf_status lf_print_tiff_close(lf_print_tiff *tiff, lf_error *err);
/* Releases it without finishing the file; accepts NULL. */
void lf_print_tiff_abandon(lf_print_tiff *tiff);

/* Begins to keep rows of a file of this height; releases earlier ones. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_print_witness_begin(lf_print_witness *witness, int height,
                                              size_t row_bytes);
/* Offers rows y .. y + n - 1 as they are stored; the witness copies those that it keeps. Any
 * thread, for different rows. */
void lf_print_witness_see(lf_print_witness *witness, int y, int n, const void *rows);

/* ---------------------------------------------------------------------------------- manifest -- */

typedef struct lf_print_facts {
    const lf_print *print;
    const lf_print_shape *shape;
    const struct lf_sheet *sheet;  /* for a picture; NULL for a chart */
    const lf_print_source *source; /* the same */
    const lf_print_colour *colour;
    const lf_print_run *run;
    const char *warning; /* may be NULL */
    lf_print_left left;
    json_t *chart; /* description of a chart, ownership taken; NULL for a picture */
    const struct lf_relief *relief; /* NULL: none */
    double ink;                     /* of CMYK: lf_print_run.out_ink */
} lf_print_facts;

/* LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_print_manifest_write(const lf_print_facts *facts, const lf_outfile *tiff,
                                               lf_outfile *manifest, lf_error *err);

/* --------------------------------------------------------------------------------------- all -- */

/* lf_print_write with a given strip height (0 = default), which must not change the picture. */
LF_NODISCARD lf_status lf_print_write_strips(const lf_print *print, const lf_views32 *views,
                                             const lf_print_run *run, int rows_per_strip,
                                             lf_outfile *tiff, lf_outfile *manifest, lf_error *err);

/* One view as an upright picture of a print without lenses, without a manifest (frame_set.c). */
LF_NODISCARD lf_status lf_print_write_frame(const lf_print *print, const lf_views32 *view,
                                            const lf_print_run *run, const char *description,
                                            lf_outfile *tiff, lf_error *err);

/* The SHA-256 and the size of a file that was written, as {name, bytes, sha256}; nulls if it cannot
 * be read back. */
json_t *lf_print_file_json(const lf_outfile *file);

#endif
