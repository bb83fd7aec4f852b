/* Lenticular prints: views to the stripes behind a lens sheet, as files for printers, and pitch
 * test charts.
 *
 * Functions are pure or work on their own object; thread safe on different objects. */
#ifndef LF_QUILT_PRINTS_H
#define LF_QUILT_PRINTS_H

#include "quilt/quilt.h"

struct json_t;

/* Conventions: x to the right, y down, seen from the front through the lens sheet, origin in the
 * middle of the print, millimetres. Lens k is centred on phase + k * 25.4/lpi. Its cell is divided
 * into n_views stripes of equal width. From left to right they carry view n_views-1 ... view 0,
 * because the focal spot moves left when the viewer moves right.
 *
 * With horizontal lenses the same holds along y: view 0 is the TOPMOST camera, and a cell holds
 * view n_views-1 ... 0 from top to bottom.
 *
 * Pixel j of the raster covers [j - width/2, j + 1 - width/2] * 25.4/dpi. Positions follow only
 * from the index and dpi, never from the rounded page. If the raster is not the same both ways, dpi
 * here is the one across the lenses: dpi for vertical lenses, dpi_down for horizontal ones.
 *
 * Fractional stripes: a pixel mixes the stripes it overlaps, by exact area, in linear light after
 * tone mapping. Nearest: a pixel takes the stripe that holds its centre. Stripes are half-open
 * [left, right), so a centre on a border (within 1e-9 stripe) belongs to the stripe on its right
 * (below it, for horizontal lenses). Both continue into the bleed, to the pixel.
 *
 * Lens sheets (lf_optics). Lenses may lean: u = x cos(slant) + y sin(slant) across vertical lenses,
 * and -x sin(slant) + y cos(slant) across horizontal ones, so that the top of a vertical lens leans
 * to the right. Lens k then has its axis at u = phase + k * 25.4/lpi. A fractional pixel weighs
 * each stripe by the exact area of the leaning band in the pixel.
 *
 * Exact map: lpi is the pitch in the middle, and an eye at distance_mm in front of it sees the
 * point P of the lens plane at r = |P| from the middle on the print at
 * r + t tan(asin(sin(atan(r / D)) / n)) in the same direction. Pitch of the lenses themselves
 * (mechanical): 25.4/lpi / (1 + t / (n D)).
 *
 * Micro sheets: one lens per point, of pitch 25.4/lpi along its rows. Square: lenses at (i, j) p.
 * Hexagonal: at ((i + (j mod 2) / 2) p, j p sqrt(3) / 2), cells are the Voronoi hexagons. The grid
 * is turned clockwise by the slant. View v is in column v mod columns from the left, and in row
 * v / columns from the bottom, like the tiles of a quilt. A cell of p x p (hexagonal: p x
 * 2p/sqrt(3)) is divided into columns x rows rectangles; from left to right they carry the last to
 * the first column, from top to bottom the first to the last row: the picture under a lens is
 * upside down and mirrored. */

typedef enum lf_stripes { LF_STRIPES_FRACTIONAL, LF_STRIPES_NEAREST } lf_stripes;
typedef enum lf_compress { LF_COMPRESS_NONE, LF_COMPRESS_LZW, LF_COMPRESS_DEFLATE } lf_compress;

typedef enum lf_guard_kind { LF_GUARD_REPEAT, LF_GUARD_WHITE, LF_GUARD_BLACK } lf_guard_kind;
enum { LF_COPIES_MOST = 100, LF_LABEL_MOST = 200 };

/* The page around a print, and what is between the images of a flip. Zeroed is one print without
 * anything. */
typedef struct lf_print_sheet {
    /* Copies of the print, for one lens sheet over all of them. Each is centred on a lens of it:
     * the steps are whole lenses. 0: 1. */
    int columns, rows;
    double gutter_mm; /* least distance between the bleeds of two copies: 0..500 */
    /* page on which the copies are centred; 0: as large as they, their labels and marks are */
    double paper_width_mm, paper_height_mm;
    const char *label; /* UTF-8 text below each copy, outside its bleed; NULL: none */
    double label_mm;   /* height of a capital letter: 0.8..20; 0: 2.5 */
    int guard;         /* stripes between two frames: 0..64 */
    lf_guard_kind guard_kind;
    int morph; /* frames blended between two images: 0..256 */
} lf_print_sheet;

/* How a sheet and a printer blur the stripes. Zeroed: unknown. */
enum { LF_PRINT_CROSSTALK = 8, LF_PRINT_CROSSTALK_VIEWS = 64 };
typedef struct lf_print_blur {
    double spot_mm;  /* width of the spot that a lens images onto the print, across the lenses (a
                      * box); 0: half a stripe */
    double dot_gain; /* at 50 %: 0.15 means that 50 % prints as 65 % dark; a prints as
                      * a + 4 gain a (1 - a); 0: none */
    double ink_mm;   /* standard deviation of the printer's lateral spread of ink (Gaussian, across
                      * the lenses); 0: none */
    int n_crosstalk; /* measured: crosstalk[n + k] is the share of view i + k that is seen at view
                      * i, for k = -n to n; sum 1. 0: unknown */
    double crosstalk[2 * LF_PRINT_CROSSTALK + 1];
    int crosstalk_views; /* views under a lens that these are shares of, 2..64; 0: as many as the
                          * print. A chart with the print's raster is taken to have shown them */
} lf_print_blur;

typedef enum lf_lens_grid { LF_LENS_LINEAR, LF_LENS_SQUARE, LF_LENS_HEXAGONAL } lf_lens_grid;
typedef enum lf_lens_map { LF_MAP_AUTO, LF_MAP_UNIFORM, LF_MAP_EXACT } lf_lens_map;

/* Zeroed: a straight linear sheet whose optics are unknown. */
typedef struct lf_optics {
    double slant;        /* degrees, of the axis of the lenses, clockwise: -60..60 */
    lf_lens_grid grid;   /* square and hexagonal: one lens per point, views in both axes */
    lf_lens_map map;     /* auto: exact if thickness and distance are known */
    double thickness_mm; /* from the top of a lens to the print; 0: unknown */
    double index;        /* refractive index; 0: unknown, LF_USUAL_INDEX */
    double radius_mm;    /* of the lens surface; 0: unknown */
    double angle;        /* viewing angle in degrees as the maker says; 0: unknown */
    double distance_mm;  /* viewing distance for which lpi was measured; 0: unknown */
    /* Micro sheets (square and hexagonal) only: rows of views, 0 = as many as columns; and the
     * offset down of the lens at the middle, -100..100 */
    int view_rows;
    double phase_down_mm;
} lf_optics;

#define LF_USUAL_INDEX 1.56

static inline double lf_optics_index(const lf_optics *optics)
{
    return optics->index > 0.0 ? optics->index : LF_USUAL_INDEX;
}

/* What sheet and printer do wrong, as far as lf_print_blur knows it, is taken back before printing.
 * Zeroed: off. */
typedef struct lf_compensation {
    bool on;         /* needs one known value of lf_print_blur, and straight linear lenses */
    double headroom; /* linear light is pressed into headroom..1 - headroom first: 0..0.4 */
} lf_compensation;

/* What eyes at the views see otherwise than wanted, by the model of lf_print_blur: ghosts, as
 * fractions of white. */
typedef struct lf_print_left {
    bool compensated;           /* false: nothing else is set */
    double own_share;           /* of an eye's light that its own view gives uncompensated, … */
    double own_share_worst;     /* … mean of all stripes and least of one */
    double ghost_before, ghost; /* mean, without compensation and with it */
    double worst_before, worst; /* largest */
    double between_before,
        between;    /* mean of eyes halfway between two views, who should see both */
    double clamped; /* fraction of the pixels' channels that would leave the gamut, 0..1 */
} lf_print_left;

/* Zeroed members after the line are a valid default. */
typedef struct lf_print {
    double lpi;                 /* measured visual pitch, lenses per inch: 5..600 */
    double dpi;                 /* printer raster, dots per inch across the page: 50..9600 … */
    double dpi_down;            /* … and down the page; 0: the same */
    double width_mm, height_mm; /* trim size, without bleed: 1..5000 */
    double bleed_mm;            /* on each side, rendered, stripes continue: 0..100 */
    /* offset of the lens at the middle of the print, to the right (down): -100..100 */
    double phase_mm;
    /* stripes of a cell: 1..dpi/lpi, rounded to the nearest whole number */
    int n_views;
    bool horizontal; /* lenses run horizontally: views change along y */
    bool reverse;    /* cells run from view 0 to view n_views-1 */
    /* mirror the raster left to right, for printing on the back of the sheet */
    bool mirror;
    /* register and alignment marks in a margin of 8 mm on every side, outside the bleed */
    bool marks;
    double frame_ppi; /* pixels per inch of a frame set, 50..600; 0: interlaced */
    bool relief;      /* also write the lens sheet as a height map, from optics */
    lf_stripes stripes;
    lf_compress compress;
    int bits; /* 8 or 16 */
    /* for a pitch test chart (lf_chart_write): lpi - range to lpi + range, one band per step */
    double chart_range, chart_step;
    lf_print_sheet sheet;
    lf_print_blur blur;
    /* NULL = sRGB; otherwise an RGB or CMYK display, output or colour space profile, at most 16
     * MiB */
    const char *icc_path;
    /* ---- */
    const lf_roots *icc_roots; /* folders allowed for icc_path; NULL = anywhere */
    /* horizontal only: views come from a rolled rig, see lf_print_shape_of */
    bool rolled;
    /* For views of another size than the shape's (a quilt): width / height of a displayed view.
     * They are placed on the raster as photo says, with white borders. A view without a border
     * inside the trim size covers the whole raster. 0 = stretched over the raster. */
    double view_aspect;
    lf_photo photo; /* its rotate, aspect and frame are not read */
    lf_optics optics;
    lf_compensation compensation;
    double parallax_lenses; /* largest shift of a point between neighbouring views, in lens pitches,
                             * if known; above 1 gives a warning */
    /* lf_profile_apply's account of profiles, for the manifest; NULL = none */
    const struct json_t *profiles;
} lf_print;

/* True if the pitch varies over the sheet by exact refraction (lf_lens_map). */
static inline bool lf_print_is_exact(const lf_print *print)
{
    const lf_optics *o = &print->optics;
    return o->map != LF_MAP_UNIFORM && o->thickness_mm > 0.0 && o->distance_mm > 0.0;
}

static inline bool lf_print_is_micro(const lf_print *print)
{
    return print->optics.grid != LF_LENS_LINEAR;
}

/* Rows of views under a lens; 1 for linear sheets. n_views must be set. */
int lf_print_view_rows(const lf_print *print);

/* The user's options of a print: names, ranges and defaults (base/param.h). */
extern const lf_param lf_print_params[];

/* Checks ranges, with one line per error (LF_E_ARG). Refuses more views than dpi/lpi (to the
 * nearest whole). *out_warning (may be NULL): static text about ghosting above 0.8 dpi/lpi,
 * otherwise NULL. Does not open the profile. */
LF_NODISCARD lf_status lf_print_check(const lf_print *print, const char **out_warning,
                                      lf_error *err);
/* Sets n_views if it is 0: as many as a lens shows without ghosting, 0.8 dpi/lpi, at least 2, at
 * most n_most (>= 1), the number available. Blended frames add to those; with guard stripes, all
 * frames get the same number of stripes. LF_E_ARG, with where and pointer (may be NULL): more than
 * n_most were requested. LF_E_ARG, with where: a lens has pixels for only one view, or too few for
 * the guards. lpi must be set. */
LF_NODISCARD lf_status lf_print_choose_views(lf_print *print, int n_most, const char *where,
                                             const char *pointer, lf_error *err);

/* Takes the measured crosstalk of a print from its manifest, if it has one. LF_E_FORMAT, with
 * where: it is damaged. */
LF_NODISCARD lf_status lf_print_take_crosstalk(const struct json_t *manifest, const char *where,
                                               lf_print_blur *out, lf_error *err);

/* The shape of the views to render for a print. Across the lenses there is one sample per lens
 * (each lens whose stripes touch the raster, with bleed). Along them there is one sample per
 * printer row. The window must be covered by those views. Samples are lens cells: the middle of
 * sample c across is the centre of lens first_lens + c.
 *
 * Vertical lenses: across is x. The rig is the scene's: one mm is s = 2 D tan(fov_y / 2) /
 * height_mm scene units. The views are rendered with fov_y' = 2 atan(s window_height_mm / (2 D))
 * and aspect window_width_mm / window_height_mm. Target and position move together by s
 * window_center_x_mm along the rig's right vector (at most half a lens; 0 if phase is 0).
 *
 * Horizontal lenses, rolled (for rendering): the cameras are in a column, so the rig is rolled by
 * 90 degrees. Its up vector becomes the right vector forward x up of the unrolled rig. Its right
 * vector, from view 0 to the last, then points DOWN. Shape and window are in the rolled camera's
 * picture: view_width is the number of lenses, view_height the raster's width, and
 * window_center_x_mm points down on the print. lf_print_write rotates the samples back; the caller
 * need not transpose them.
 *
 * Horizontal lenses, not rolled (upright pictures): view_width is the raster's width, view_height
 * the number of lenses.
 *
 * Slanted lenses: the same with samples 25.4/lpi / cos(slant) apart across the lenses. Sample c is
 * the lens first_lens + c where its axis crosses the middle row (column). The samples reach half a
 * lens further than the lenses that touch the raster. In other rows the lens's sample is
 * interpolated between two, at the axis.
 *
 * Micro sheets: one sample per lens both ways; hexagonal sheets have two per lens along a row. They
 * are interpolated at the middle of a lens where the sheet leans. */
typedef struct lf_print_shape {
    /* pixels of the picture with bleed: round((size + 2 bleed) * dpi / 25.4), each way by its own
     * dpi */
    int raster_width, raster_height;
    /* margin of white and marks around the picture in the TIFF, in pixels: left and right, above
     * and below; 0 without marks */
    int margin_px, margin_down_px; /* left and right; above and below */
    int view_width, view_height;   /* samples of a view */
    int n_lenses, n_along;         /* the same two numbers, across and along the lenses */
    /* lens number of sample 0; lens 0 is centred on the middle (plus phase) */
    int first_lens;
    /* Position of the middle of sample 0 and distance of samples, across and along, on the print */
    double first_across_mm, first_along_mm, step_across_mm, step_along_mm;
    double window_width_mm, window_height_mm;
    /* the print's middle from the middle of its pixels: for copies on a page; else 0 */
    double shift_right_mm, shift_down_mm;
    double window_center_x_mm,
        /* middle of the window from the middle of the print, in the views' picture, right and
         * down */
        window_center_y_mm;
} lf_print_shape;
/* print must have passed lf_print_check. */
void lf_print_shape_of(const lf_print *print, lf_print_shape *out);

/* Rows of a file, kept while it is written, so that what lies on the disk can be compared with what
 * was meant. Set n_rows; the writer does the rest. Release with lf_print_witness_finish. */
typedef struct lf_print_witness {
    int n_rows;          /* rows to keep; fewer if the file has fewer */
    int height;          /* rows of the file; 0: nothing is kept */
    size_t row_bytes;    /* of a row as it is stored, before compression */
    unsigned char *rows; /* [n_rows][row_bytes]; row i is lf_print_witness_at(i) of the file */
} lf_print_witness;
/* The file's row that row i of the witness holds. */
int lf_print_witness_at(const lf_print_witness *witness, int i);
void lf_print_witness_finish(lf_print_witness *witness); /* accepts NULL */
typedef enum lf_print_format { LF_PRINT_TIFF, LF_PRINT_PDF } lf_print_format;

/* Parameters of making a print, independent of its content. Zeroed is a valid default. */
typedef struct lf_print_run {
    lf_print_format format;
    lf_outfile *relief;  /* of a print with relief, empty; the caller commits or abandons it */
    lf_pool *pool;       /* makes strips at the same time, with the same bytes; may be NULL */
    double *out_ink;     /* CMYK: the densest pixel, the sum of its inks in percent; may be NULL */
    double exposure;     /* stops */
    const char *tonemap; /* as for lf_tone_create; NULL = "srgb" */
    /* an object to include in the manifest; may be NULL */
    const struct json_t *settings;
    const lf_image_notes *notes; /* warnings for the manifest, one line each; may be NULL */
    lf_print_witness *witness;   /* is filled; may be NULL */
    const lf_cancel *cancel;     /* checked once per strip; may be NULL */
    void (*progress)(void *context, double fraction); /* rising, 0..1; may be NULL */
    void *context;
    lf_print_left *out_left; /* set by lf_print_write; may be NULL */
} lf_print_run;

/* Notes how much lf_print_write cuts from these views, how wide their borders are, a scale along
 * the lenses over 2, and what a relief may lack. print must have passed lf_print_check. */
void lf_print_note_laid(const lf_print *print, const lf_views32 *views, lf_image_notes *notes);
/* Notes what may surprise in the layout of the sheet and of a flip of n images. print must have
 * passed lf_print_check. */
void lf_print_note_sheet(const lf_print *print, int n_images, lf_image_notes *notes);
/* One line about the copies of a sheet and about the stripes of a flip of n images, or of more
 * images than a lens shows, in buf; "" for a print without. Images count from 0; "-" is a guard of
 * one light. Returns buf. */
char *lf_print_layout_text(const lf_print *print, int n_images, char *buf, size_t size);
/* Lenses across a picture of the aspect print->view_aspect, where the print places it, with what it
 * cuts. print must have passed lf_print_check. */
double lf_print_lenses(const lf_print *print);

/* Checks that the disk has room for the whole page, or for all frames of a set, so that nobody
 * renders in vain. A compressed file counts as a tenth of its raster. path: its name, in a folder
 * that exists. print must have passed lf_print_check. LF_E_IO: it does not fit. LF_E_ARG: the page
 * cannot be laid out. */
LF_NODISCARD lf_status lf_print_check_room(const lf_print *print, lf_print_format format,
                                           const char *path, lf_error *err);

/* Interlaces and streams the TIFF or PDF to tiff->fd (seekable, empty), then writes the manifest
 * JSON. The caller commits both, or abandons both on failure. Memory in addition to the views is a
 * few MB; BigTIFF if the raster may exceed 4 GiB. The bytes depend only on the arguments (no date).
 * The manifest's sha256 is null if the TIFF's descriptor cannot be read back. With print->relief,
 * the height map is written to run->relief first; LF_E_ARG: the sheet's optics give no lens.
 *
 * Views of the shape's size are used unchanged. Others are resampled (by area to a smaller size,
 * linearly to a larger one), which the manifest records. views->n_views may differ from
 * print->n_views: stripe i then shows view floor((i + 1/2) * views->n_views / print->n_views).
 * Samples that are not finite count as 0. LF_E_ARG, LF_E_IO (disk full), LF_E_PATH and LF_E_FORMAT
 * (profile), LF_E_CANCELLED, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_print_write(const lf_print *print, const lf_views32 *views,
                                      const lf_print_run *run, lf_outfile *tiff,
                                      lf_outfile *manifest, lf_error *err);

/* Frames for shops that interlace themselves (print->frame_ppi): every view as a TIFF of the
 * print's size with its bleed, upright, with square pixels.
 *
 * lf_frame_set_print: the print whose shape the views and frames have (lf_print_shape_of); one for
 * all frames. lf_frame_set_check: lf_print_check, and what frames cannot have; LF_E_ARG.
 * lf_frame_set_write: files[0] is order.txt for people, files[1] the manifest, then one TIFF per
 * view of the print, from the leftmost (topmost) camera. Errors of lf_print_write. */
enum { LF_FRAME_SET_TOLD = 2 };
lf_print lf_frame_set_print(const lf_print *print);
LF_NODISCARD lf_status lf_frame_set_check(const lf_print *print, lf_error *err);
LF_NODISCARD lf_status lf_frame_set_write(const lf_print *print, const lf_views32 *views,
                                          const lf_print_run *run, lf_outfile *files,
                                          lf_error *err);

/* Views under a lens in the patches of a chart, whose crosstalk is read. */
enum { LF_CHART_CODES = 8 };

/* Writes a pitch test chart (quilt/chart/chart.h) of the print's size and its manifest, like
 * lf_print_write. exposure and tonemap of run are not used. LF_E_ARG as for lf_print_check, and if
 * a chart has no room for its bands; other errors of lf_print_write. */
LF_NODISCARD lf_status lf_chart_write(const lf_print *print, const lf_print_run *run,
                                      lf_outfile *tiff, lf_outfile *manifest, lf_error *err);
/* The checks of lf_chart_write alone. */
LF_NODISCARD lf_status lf_chart_check(const lf_print *print, lf_error *err);
/* Notes the parts for which the chart of a print has no room, as its manifest's warnings do. */
void lf_chart_note(const lf_print *print, lf_image_notes *notes);

#endif
