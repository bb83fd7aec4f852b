/* quilt: from resolved views to what a panel, a printer or a file takes.
 *
 * layout (presets, names _qsCxRaASPECT) -> fill (coarse frames, on screen only) -> tone (linear
 * float to 8-bit sRGB) -> interlace (one panel's lens) -> changed rectangles; lenticular print;
 * quilt and view files, reading and writing. Views are numbered from the leftmost camera; rows
 * count from the top unless stated (calibration formulas count from the bottom). All functions are
 * pure or work on their own object; thread safe on different objects. */
#ifndef LF_QUILT_H
#define LF_QUILT_H

#include "base/calibration.h"
#include "base/file.h"
#include "base/image.h"
#include "base/image_io.h"
#include "base/param.h"
#include "base/thread.h"

/* ------------------------------------------------------------------------------------ layout -- */

#define LF_MAX_TILES 64 /* a row or column of a quilt */

typedef struct lf_layout {
    int columns, rows; /* tiles of the quilt; columns * rows >= n_views, the rest black */
    int n_views;
    int view_width, view_height; /* pixels of a tile */
    double aspect;               /* width / height of a view as it is meant to be seen */
} lf_layout;

/* Name as in --preset; sources in layout.c. NULL after the last index. */
typedef struct lf_preset {
    const char *name, *model;
    lf_layout layout;
    bool is_plain; /* one view for a display without a lens (daemon/output/hld.h) */
} lf_preset;
const lf_preset *lf_preset_at(int index);
LF_NODISCARD lf_status lf_preset_find(const char *name, const lf_preset **out, lf_error *err);

/* "8x6" -> columns, rows (1..LF_MAX_TILES each). */
LF_NODISCARD lf_status lf_parse_tiles(const char *text, int *out_columns, int *out_rows,
                                      lf_error *err);
/* Tiles for 1..4096 views of this size that nobody said how to lay out: 5x9 for 45, else those of
 * the most nearly square quilt picture, a black tile counting as 4/n_views octaves of its shape. */
void lf_layout_tiles(int n_views, int view_width, int view_height, int *out_columns, int *out_rows);
/* The tiles and aspect of a file name "…_qs8x6a0.75.png" (aspect part optional: 0); false when it
 * has none. The last such part of the name counts. */
bool lf_layout_from_name(const char *path, int *out_columns, int *out_rows, double *out_aspect);
/* Where that part begins; NULL when there is none. */
const char *lf_layout_suffix(const char *path);
/* The name with _qsCxRaA before its ending, added when missing (or when what is there says other
 * tiles); caller frees with lf_free; NULL = out of memory. */
char *lf_layout_name(const char *path, const lf_layout *layout);

/* ----------------------------------------------------------------------------- tone and fill -- */

typedef struct lf_tone lf_tone;
/* exposure in stops, -64..64; tonemap "srgb" (clamp), "filmic" (Narkowicz's fit of the ACES curve,
 * 2015, each channel for itself) or "aces" (Hill's fit of the ACES rendering and output transforms,
 * 2016: bright colours go towards white). LF_E_ARG, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_tone_create(double exposure, const char *tonemap, lf_tone **out,
                                      lf_error *err);
void lf_tone_destroy(lf_tone *tone);
/* n pixels linear float RGB -> 8-bit sRGB RGB, rounded to nearest; NaN becomes 0. */
void lf_tone_map(const lf_tone *tone, size_t n, const float *in, uint8_t *out);
/* The same of the first n pixels of a row of a view, dithered: a value between two codes becomes
 * either, by a fixed 8x8 pattern that each view has in another place, so that the mean over 8x8
 * pixels is the value before rounding. A value that is a code before rounding stays that code. */
void lf_tone_dither(const lf_tone *tone, int view, int row, size_t n, const float *in,
                    uint8_t *out);
/* n pixels linear float RGB -> display light, still linear, 0..1: what lf_tone_map does before the
 * sRGB curve; NaN becomes 0. in may be out. */
void lf_tone_linear(const lf_tone *tone, size_t n, const float *in, float *out);

/* How bright a picture is, of all its views together: how many pixels have which luminance (Rec.
 * 709), in sixteenths of an octave. Zeroed is empty. */
enum { LF_METER_BINS = 4096 };
typedef struct lf_meter {
    int64_t n[LF_METER_BINS];
} lf_meter;
/* n pixels linear float RGB. Black ones, and what is no number, do not count. */
void lf_meter_add(lf_meter *meter, size_t n, const float *rgb);
void lf_meter_add_views(lf_meter *meter, const lf_views32 *views);
/* Adds what another has counted. */
void lf_meter_merge(lf_meter *meter, const lf_meter *other);
/* The exposure that this picture wants, in stops, rounded to an eighth, -32..32: 5 % of what counts
 * is then brighter than 0.8 of the screen's white. 0 when nothing counts. Depends on nothing but
 * the counts. */
double lf_meter_exposure(const lf_meter *meter);

typedef struct lf_fill_counts {
    int64_t unfilled; /* pixels that stayed as they were */
    int64_t far;      /* missing pixels that have none at most `near` pixels away */
} lf_fill_counts;
/* Fills what is missing in 8-bit views laid out [row][view][column], for the eye. A pixel whose
 * flag is nonzero in `missing` is filled from pixels of its own view with flag 0, at most `reach`
 * (0..16) pixels away: linearly between the nearest one straight above and the nearest straight
 * below, where these are at most four rows apart; elsewhere it is the nearest (Euclidean, ties by
 * lower row then column). filled is rgb itself or apart from it. pool may be NULL. Allocates
 * nothing. */
lf_fill_counts lf_fill(int n_views, int width, int height, const uint8_t *rgb,
                       const uint8_t *missing, int near, int reach, uint8_t *filled, lf_pool *pool);
/* The same for a film [row][view][column][3], in place. A pixel between two rows gets the mean of
 * their light, where lf_fill takes the mean of their bytes: a film that is filled and then
 * tone-mapped differs there from one that is tone-mapped and then filled. */
void lf_fill_film(int n_views, int width, int height, float *film, const uint8_t *missing,
                  int reach, lf_pool *pool);

/* --------------------------------------------------------------------------------- interlace -- */

typedef enum lf_invert { LF_INVERT_AUTO, LF_INVERT_YES, LF_INVERT_NO } lf_invert;
typedef enum lf_filter { LF_FILTER_NEAREST, LF_FILTER_LINEAR } lf_filter;

/* View (0..n_views-1) that channel c (0 R, 1 G, 2 B) of the panel pixel shows, x from the left, y
 * from the BOTTOM; *out_z (may be NULL) gets z * n_views. Double precision, the formulas of
 * looking-glass.md sections 3.2 to 3.4: the oracle of lf_interlacer. flipImageX negates both tilt
 * and subpixel step; flipSubp swaps red and blue of stripes (cells say themselves where red is);
 * LF_INVERT_AUTO counts from the right, but honours invView 0 of configVersion "1.0". */
int lf_view_of_subpixel(const lf_calibration *calibration, int n_views, lf_invert invert, int x,
                        int y, int c, double *out_z);

typedef struct lf_interlacer lf_interlacer;
/* Prepares for views of this shape. aspect = width / height the views are meant to be seen with:
 * views are fitted into the panel (black outside); 0 = the panel's. 1..65535 views. Keeps one byte
 * a subpixel of the panel (two over 256 views; none for LF_FILTER_LINEAR). LF_E_ARG, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_interlacer_create(const lf_calibration *calibration, int n_views,
                                            int view_width, int view_height, double aspect,
                                            lf_filter filter, lf_invert invert, lf_interlacer **out,
                                            lf_error *err);
void lf_interlacer_destroy(lf_interlacer *interlacer);
/* Interlaces rows [row0, row1) of the panel into out (screen_width x screen_height, 3 channels).
 * With LF_FILTER_NEAREST values are copied unchanged. LF_FILTER_LINEAR mixes stored values: view
 * floor(z N) and the next (clamped at the end of the cone) by the fraction of z N, each sampled
 * bilinearly (section 3.3, filter mode 1). Thread: any, for different rows at once; allocates
 * nothing. */
void lf_interlace_rows(const lf_interlacer *interlacer, const lf_views8 *views, lf_image8 *out,
                       int row0, int row1);
/* All rows, on pool (may be NULL). */
void lf_interlace(const lf_interlacer *interlacer, const lf_views8 *views, lf_image8 *out,
                  lf_pool *pool);

/* ---------------------------------------------------------------------------------- response -- */

/* What a panel makes of its codes, where it is not sRGB; zeroed is a panel that is. */
typedef struct lf_response {
    double gamma; /* light = code^gamma; 0 or INFINITY: the curve of sRGB */
    /* the panel's own white, that of equal codes: as a colour temperature (daylight; 0 = none), or
     * as chromaticities (0 = none); without either it is D65 */
    double white, white_x, white_y;
} lf_response;

/* The code to send for every sRGB code, of red, green and blue: so that what is seen is what sRGB
 * says, white D65. Gains are linear in light and at most 1, of the primaries of Rec. 709. */
typedef struct lf_codes {
    uint8_t code[3][256];
    bool same; /* all of them are what they were */
} lf_codes;
/* LF_E_ARG: two whites, half of one, or one that Rec. 709's primaries do not add up to. */
LF_NODISCARD lf_status lf_response_codes(const lf_response *response, lf_codes *out, lf_error *err);
/* The last step, in place: 3 channels; pool may be NULL. */
void lf_codes_apply(const lf_codes *codes, lf_image8 *image, lf_pool *pool);

/* ------------------------------------------------------------------------------------- cards -- */

/* A picture of our own with a few words on it, for a panel that has no other to show. */
#define LF_CARD_TEXT 384 /* bytes of the words, their end included */

/* The size of a card for a panel: its aspect, and about as fine as a lens shows. */
void lf_card_size(int panel_width, int panel_height, int *out_width, int *out_height);
/* Light words on dark grey, as large as at most nine lines allow; words too long are cut and end
 * with dots, characters that the font lacks become '?'. It is meant as the only view: the same from
 * everywhere lies in the plane of the glass. *out is the caller's (lf_image8_finish). LF_E_NOMEM.
 */
LF_NODISCARD lf_status lf_card_draw(const char *text, int width, int height, lf_image8 *out);

/* ------------------------------------------------------------------------ changed rectangles -- */

/* Compares two frames of equal shape and writes at most max_rects (>= 1) disjoint rectangles that
 * cover every difference (merged, growing where they would be too many; each touches differences on
 * all four sides); returns their number, 0 = equal. Allocates nothing; 64 KiB of stack. */
int lf_changed_rects(const lf_image8 *before, const lf_image8 *after, lf_rect *out_rects,
                     int max_rects);

/* ------------------------------------------------------------------------------------ photos -- */

typedef enum lf_photo_mode { LF_PHOTO_FIT, LF_PHOTO_FILL } lf_photo_mode;
typedef enum lf_turn { LF_TURN_NONE, LF_TURN_90, LF_TURN_180, LF_TURN_270, LF_TURN_AUTO } lf_turn;

/* How a finished picture is laid onto a view, a panel or a print of another shape. Zeroed: whole,
 * in the middle, as it stands, with borders (black on views and panels, white on prints). */
typedef struct lf_photo {
    lf_photo_mode mode;
    int position;   /* row of a table of words, 0 the middle */
    lf_turn rotate; /* clockwise; auto: by 90 where frame is upright and the picture is not, or the
                       other way round */
    double aspect;  /* of a view as its file has it, width / height; 0: what the files say */
    /* by what it is for, not set by people: */
    double frame;  /* width / height of the panel or print; 0: there is none */
    bool on_paper; /* borders within the views of a folder are white */
} lf_photo;
/* Names, ranges and defaults of what people set (base/param.h): mode and position, and what is of
 * pictures as they are read. */
extern const lf_param lf_photo_params[];
extern const lf_param lf_picture_params[];

/* ------------------------------------------------------------------------------------- files -- */

/* A light field read from a quilt picture or a folder of views. */
typedef struct lf_quilt_file {
    lf_layout layout;
    bool is_float;
    /* owned: the views one below the other, view 0 first (may be taller than a picture); views8
     * points here */
    lf_image8 image8;
    lf_image32 image32;
    lf_views8 views8;   /* valid when !is_float */
    lf_views32 views32; /* valid when is_float */
    /* what the picture's file says and is not used, or those of a folder, each line once, and what
     * was scaled or cut */
    lf_image_notes notes;
} lf_quilt_file;

/* True when path names a picture (PNG, JPEG, EXR by contents) or a folder, and not a scene. */
bool lf_is_quilt(const char *path, const lf_roots *roots);
/* columns, rows 0 = from the name (LF_E_ARG when it has none). Padding at right and top is left
 * out; every tile is a view. The aspect is the name's, else that of a tile's pixels, whose shape
 * the file may say. A folder: its pictures (by their endings, not hidden ones) in name order, all
 * of one kind, at most 4096; those of another size than the first are laid onto one of its size, as
 * photo says (NULL: as a zeroed one does), which a line of notes tells. A picture that is turned
 * changes the aspect, too. LF_E_FORMAT, LF_E_IO, LF_E_PATH, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_quilt_read_photo(const char *path, const lf_roots *roots, int columns,
                                           int rows, const lf_photo *photo, lf_quilt_file *out,
                                           lf_error *err);
LF_NODISCARD lf_status lf_quilt_read(const char *path, const lf_roots *roots, int columns, int rows,
                                     lf_quilt_file *out, lf_error *err);
/* With LF_PHOTO_FILL, and a frame: cuts the views to its aspect, to whole pixels, and notes it. */
void lf_photo_cut(const lf_photo *photo, lf_quilt_file *quilt);
void lf_quilt_finish(lf_quilt_file *quilt);

/* Row y, from the top, of the picture that lf_quilt_write_png makes of the same: 3 bytes a pixel,
 * layout->columns times the views' width of them. */
void lf_quilt_row8(const lf_views8 *views, const lf_layout *layout, int y, uint8_t *out);
/* The quilt picture of 8-bit or float views (view 0 bottom left, tiles without a view black);
 * layers of float views become channels of the file.
 * LF_E_ARG when views and layout do not agree, LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_quilt_write_png(lf_outfile *file, const lf_views8 *views,
                                          const lf_layout *layout, const lf_attribute *attributes,
                                          int n_attributes, lf_error *err);
/* The same picture as a JPEG of this quality (lf_jpeg_write_rows). */
LF_NODISCARD lf_status lf_quilt_write_jpeg(lf_outfile *file, const lf_views8 *views,
                                           const lf_layout *layout, int quality, lf_error *err);
LF_NODISCARD lf_status lf_quilt_write_exr(lf_outfile *file, const lf_views32 *views,
                                          const lf_layout *layout, const lf_attribute *attributes,
                                          int n_attributes, lf_error *err);

/* One view of them, alone. As the picture of one view by lf_quilt_write_png and _exr, it says the
 * shape of its pixels where those of this aspect (0: not known) are not square. */
LF_NODISCARD lf_status lf_view_write_exr(lf_outfile *file, const lf_views32 *views, int view,
                                         double aspect, const lf_attribute *attributes,
                                         int n_attributes, lf_error *err);

/* -------------------------------------------------------------------------- lenticular print -- */

/* Conventions (lenticular.md sections 1.3, 1.4, 1.8): x to the right, y down, seen from the front
 * through the lens sheet, origin in the middle of the print, millimetres. Lens k is centred on
 * phase + k * 25.4/lpi. Its cell is cut into n_views stripes of equal width; from left to right
 * they carry view n_views-1 ... view 0, because the focal spot moves left when the viewer moves
 * right. With horizontal lenses the same holds along y: view 0 is the TOPMOST camera, and from top
 * to bottom of a cell lie view n_views-1 ... 0. Pixel j of the raster covers [j - width/2, j + 1 -
 * width/2] * 25.4/dpi: positions follow from the index and dpi alone, never from the rounded page.
 * Where the raster is not the same both ways, dpi here is that across the lenses: dpi of vertical
 * ones, dpi_down of horizontal ones.
 *
 * Fractional stripes: a pixel is the mix, in linear light after tone mapping, of the stripes it
 * overlaps, by exact area. Nearest: a pixel is the stripe that holds its centre; stripes are
 * half-open [left, right), so that a centre on a border (within 1e-9 stripe) belongs to the stripe
 * on its right (below it, for horizontal lenses). Bleed continues both, to the pixel. */

typedef enum lf_stripes { LF_STRIPES_FRACTIONAL, LF_STRIPES_NEAREST } lf_stripes;
typedef enum lf_compress { LF_COMPRESS_NONE, LF_COMPRESS_LZW, LF_COMPRESS_DEFLATE } lf_compress;

/* Zeroed fields below the line are a valid default. */
typedef struct lf_print {
    double lpi;                 /* measured visual pitch, lenses per inch: 5..600 */
    double dpi;                 /* printer raster, dots per inch across the page: 50..9600 … */
    double dpi_down;            /* … and down the page; 0: the same */
    double width_mm, height_mm; /* trim size, without bleed: 1..5000 */
    double bleed_mm;            /* on each side, rendered, stripes continue: 0..100 */
    /* moves the lens that is centred on the middle of the print, to the right (down): -100..100 */
    double phase_mm;
    /* stripes of a cell: 1..dpi/lpi, rounded to the nearest whole number */
    int n_views;
    bool horizontal; /* lenses run horizontally: views change along y */
    bool reverse;    /* cells run from view 0 to view n_views-1 */
    /* the whole raster mirrored left to right, for printing on the back of the sheet */
    bool mirror;
    /* register and alignment marks in a margin of 8 mm on every side, outside of the bleed */
    bool marks;
    lf_stripes stripes;
    lf_compress compress;
    int bits; /* 8 or 16 */
    /* of a pitch test chart, which lf_chart_write makes: lpi - range to lpi + range, a band a step
     */
    double chart_range, chart_step;
    /* NULL = sRGB; else an RGB or CMYK display, output or colour space profile, at most 16 MiB */
    const char *icc_path;
    /* ---- */
    const lf_roots *icc_roots; /* where icc_path may lie; NULL = anywhere */
    /* horizontal only: views come from a rolled rig, see lf_print_shape_of */
    bool rolled;
    double view_aspect; /* views of another size than the shape's (a quilt picture): width / height
                           they are meant to be seen with; they are laid onto the raster as photo
                           says, with white borders; what shows no border inside of the trim size
                           covers the raster. 0 = stretched over the raster */
    lf_photo photo;     /* its rotate, aspect and frame are not read */
    double parallax_lenses; /* largest shift of a point between neighbouring views, in lens pitches,
                               if known: above 1 is warned of */
} lf_print;

/* What people set of a print, their names, ranges and defaults (base/param.h). */
extern const lf_param lf_print_params[];

/* Range checks with one clear line each (LF_E_ARG); more views than dpi/lpi (to the nearest whole)
 * are refused; *out_warning (may be NULL) gets a static text about ghosting above 0.8 dpi/lpi, else
 * NULL. Does not open the profile. */
LF_NODISCARD lf_status lf_print_check(const lf_print *print, const char **out_warning,
                                      lf_error *err);
/* Sets n_views where it is 0: as many as a lens shows without ghosts, 0.8 dpi/lpi, at least 2, of
 * n_most (1 or more) that there are. LF_E_ARG: more than n_most were asked for, at where and
 * pointer (may be NULL), or a lens has pixels for one view alone, at where. lpi must be set. */
LF_NODISCARD lf_status lf_print_choose_views(lf_print *print, int n_most, const char *where,
                                             const char *pointer, lf_error *err);

/* The shape of the views to render for a print: across the lenses one sample a lens (each lens
 * whose stripes touch the raster, bleed included), along them the printer's rows, and the window
 * that those views must cover. Samples are lens cells: the middle of sample c across is the centre
 * of lens first_lens + c.
 *
 * Vertical lenses: across is x. The rig is the scene's: one mm is s = 2 D tan(fov_y / 2) /
 * height_mm scene units, the views are rendered with fov_y' = 2 atan(s window_height_mm / (2 D))
 * and aspect window_width_mm / window_height_mm, and target and position move together by s
 * window_center_x_mm along the rig's right vector (at most half a lens; nothing when phase is 0).
 *
 * Horizontal lenses, rolled (for rendering): the cameras stand in a column, so the rig is rolled by
 * 90 degrees: its up vector becomes the right vector forward x up of the unrolled rig, and its
 * right vector, from view 0 to the last, then points DOWN. Shape and window are in the rolled
 * camera's own picture: view_width is the number of lenses, view_height the raster's width,
 * window_center_x_mm points down on the print. lf_print_write turns the samples back; nothing needs
 * transposing before. Horizontal lenses, not rolled (pictures that stand upright): view_width is
 * the raster's width, view_height the number of lenses. */
typedef struct lf_print_shape {
    /* pixels of the picture, bleed included: round((size + 2 bleed) * dpi / 25.4), each
     * way by its own dpi */
    int raster_width, raster_height;
    /* pixels of white and marks that the TIFF has on every side of that; 0 without marks */
    int margin_px, margin_down_px; /* at the left and right, above and below */
    int view_width, view_height;   /* samples of a view */
    int n_lenses, n_along;         /* the same two numbers, across the lenses and along them */
    /* number of the lens of sample 0; lens 0 is centred on the middle (plus phase) */
    int first_lens;
    double window_width_mm, window_height_mm;
    double window_center_x_mm,
        /* of the window from the middle of the print, in the views' picture, right and down */
        window_center_y_mm;
} lf_print_shape;
/* print must have passed lf_print_check. */
void lf_print_shape_of(const lf_print *print, lf_print_shape *out);

/* How a print is made, beside what it is. Zeroed is a valid default. */
struct json_t;
typedef struct lf_print_run {
    double exposure;     /* stops */
    const char *tonemap; /* as for lf_tone_create; NULL = "srgb" */
    /* an object that is put into the manifest; may be NULL */
    const struct json_t *settings;
    const lf_image_notes *notes; /* warnings for the manifest, a line each; may be NULL */
    const lf_cancel *cancel;     /* looked at once a strip; may be NULL */
    void (*progress)(void *context, double fraction); /* rising, 0..1; may be NULL */
    void *context;
} lf_print_run;

/* Notes what lf_print_write cuts of these views, how wide their borders are, and a scale along the
 * lenses beyond 2. print must have passed lf_print_check. */
void lf_print_note_laid(const lf_print *print, const lf_views32 *views, lf_image_notes *notes);

/* Interlaces and streams the TIFF onto tiff->fd (seekable, empty), then writes the manifest JSON;
 * neither is committed: the caller commits both, or abandons both on failure. Memory beyond the
 * views is a few MB; BigTIFF where the raster may pass 4 GiB; the bytes depend on the arguments
 * alone (no date). The manifest's sha256 is null when the TIFF's descriptor cannot be read back.
 * Views have the shape's size and are taken as they are, or any other: then they are resampled
 * (area where that makes them smaller, linear where larger), said in the manifest. views->n_views
 * may differ from print->n_views: stripe i then shows view floor((i + 1/2) * views->n_views /
 * print->n_views). Samples that are not finite count as 0. LF_E_ARG, LF_E_IO (disk full), LF_E_PATH
 * and LF_E_FORMAT (profile), LF_E_CANCELLED, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_print_write(const lf_print *print, const lf_views32 *views,
                                      const lf_print_run *run, lf_outfile *tiff,
                                      lf_outfile *manifest, lf_error *err);

/* Writes the pitch test chart of lenticular.md section 1.2 in the size of the print, with its
 * manifest, as lf_print_write does. Of run, exposure and tonemap are not used. LF_E_ARG as for
 * lf_print_check, and for a chart that has no room for its bands; others as lf_print_write. */
LF_NODISCARD lf_status lf_chart_write(const lf_print *print, const lf_print_run *run,
                                      lf_outfile *tiff, lf_outfile *manifest, lf_error *err);
/* What lf_chart_write would refuse. */
LF_NODISCARD lf_status lf_chart_check(const lf_print *print, lf_error *err);

#endif
