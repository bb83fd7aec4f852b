/* quilt: from resolved views to the formats of panels, printers and files.
 *
 * layout (presets, names _qsCxRaASPECT) -> fill (coarse frames, on screen only) -> tone (linear
 * float to 8-bit sRGB) -> interlace (one panel's lens) -> changed rectangles. Also reading and
 * writing of quilt and view files. Lenticular prints are in quilt/prints.h.
 *
 * Views are numbered from the leftmost camera. Rows count from the top unless stated (calibration
 * formulas count from the bottom). Functions are pure or work on their own object; thread safe on
 * different objects. */
#ifndef LF_QUILT_H
#define LF_QUILT_H

#include "base/calibration.h"
#include "base/file.h"
#include "base/image.h"
#include "base/image_io.h"
#include "base/param.h"
#include "base/sandbox/raster.h"
#include "base/thread.h"

/* ------------------------------------------------------------------------------------ layout -- */

#define LF_MAX_TILES 64 /* per row or column of a quilt */

typedef struct lf_layout {
    int columns, rows; /* tiles of the quilt; columns * rows >= n_views, the rest black */
    int n_views;
    int view_width, view_height; /* pixels of a tile */
    double aspect;               /* width / height of a displayed view */
} lf_layout;

/* A value of --preset; sources in layout.c. NULL after the last index. */
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
/* Default tiles for 1..4096 views of this size: 5x9 for 45 views, otherwise the tiles of the most
 * nearly square quilt. A black tile counts as 4/n_views octaves of the quilt's shape. */
void lf_layout_tiles(int n_views, int view_width, int view_height, int *out_columns, int *out_rows);
/* The tiles and aspect in a file name "…_qs8x6a0.75.png" (without an aspect: 0); false: none. The
 * last such suffix of the name counts. */
bool lf_layout_from_name(const char *path, int *out_columns, int *out_rows, double *out_aspect);
/* The start of that suffix; NULL: none. */
const char *lf_layout_suffix(const char *path);
/* The name with _qsCxRaA before its ending, added if it is missing or has other tiles; caller frees
 * with lf_free; NULL = out of memory. */
char *lf_layout_name(const char *path, const lf_layout *layout);

/* ----------------------------------------------------------------------------- tone and fill -- */

typedef struct lf_tone lf_tone;
/* exposure in stops, -64..64. tonemap: "srgb" clamps; "filmic" is Narkowicz's fit of the ACES curve
 * (2015), per channel; "aces" is Hill's fit of the ACES rendering and output transforms (2016),
 * which moves bright colours towards white. LF_E_ARG, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_tone_create(double exposure, const char *tonemap, lf_tone **out,
                                      lf_error *err);
void lf_tone_destroy(lf_tone *tone);
/* n pixels linear float RGB -> 8-bit sRGB RGB, rounded to nearest; NaN becomes 0. */
void lf_tone_map(const lf_tone *tone, size_t n, const float *in, uint8_t *out);
/* Like lf_tone_map with ordered dithering, for the first n pixels of a row of a view. A value
 * between two codes becomes one of them by a fixed 8x8 pattern, which is shifted from view to view.
 * The mean over 8x8 pixels is the value before rounding. A value that is exactly a code stays that
 * code. */
void lf_tone_dither(const lf_tone *tone, int view, int row, size_t n, const float *in,
                    uint8_t *out);
/* n pixels linear float RGB -> linear display light, 0..1: lf_tone_map without the sRGB curve; NaN
 * becomes 0. in may be out. */
void lf_tone_linear(const lf_tone *tone, size_t n, const float *in, float *out);

/* A luminance histogram of all views of a picture: pixel counts per Rec. 709 luminance, in
 * sixteenths of an octave. Zeroed is empty. */
enum { LF_METER_BINS = 4096 };
typedef struct lf_meter {
    int64_t n[LF_METER_BINS];
} lf_meter;
/* Adds n pixels of linear float RGB. Black pixels and values that are not finite do not count. */
void lf_meter_add(lf_meter *meter, size_t n, const float *rgb);
void lf_meter_add_views(lf_meter *meter, const lf_views32 *views);
/* Adds another histogram. */
void lf_meter_merge(lf_meter *meter, const lf_meter *other);
/* The automatic exposure of the picture in stops, rounded to an eighth, -32..32: 5 % of the counted
 * pixels are then brighter than 0.8 of the screen's white. 0 if nothing was counted. Depends only
 * on the counts. */
double lf_meter_exposure(const lf_meter *meter);

typedef struct lf_fill_counts {
    int64_t unfilled; /* missing pixels that were not filled */
    int64_t far;      /* missing pixels without a source within `near` pixels */
} lf_fill_counts;
/* Fills missing pixels of 8-bit views [row][view][column] for display. A pixel whose flag in
 * `missing` is nonzero is filled from pixels of its own view with flag 0, at most `reach` (0..16)
 * pixels away.
 *
 * If the nearest sources straight above and straight below are at most four rows apart, it is
 * interpolated linearly between them. Otherwise it is copied from the nearest source (Euclidean;
 * ties go to the lower row, then the lower column). filled may be rgb itself, or must not overlap
 * it. pool may be NULL. Allocates nothing. */
lf_fill_counts lf_fill(int n_views, int width, int height, const uint8_t *rgb,
                       const uint8_t *missing, int near, int reach, uint8_t *filled, lf_pool *pool);
/* Like lf_fill for a film [row][view][column][3], in place. A pixel between two rows gets the mean
 * of their light; lf_fill takes the mean of their bytes. Filling before tone mapping therefore
 * differs there from filling after it. */
void lf_fill_film(int n_views, int width, int height, float *film, const uint8_t *missing,
                  int reach, lf_pool *pool);

/* --------------------------------------------------------------------------------- interlace -- */

typedef enum lf_invert { LF_INVERT_AUTO, LF_INVERT_YES, LF_INVERT_NO } lf_invert;
typedef enum lf_filter { LF_FILTER_NEAREST, LF_FILTER_LINEAR } lf_filter;

/* The view (0..n_views-1) that channel c (0 R, 1 G, 2 B) of a panel pixel shows; x from the left, y
 * from the BOTTOM. *out_z (may be NULL) gets z * n_views. The double precision reference of
 * lf_interlacer.
 *
 * Formulas: LookingGlassConfig.ts of @lookingglass/webxr and weave.py of suchanek/quiltwright.
 * flipImageX negates both tilt and subpixel step. flipSubp swaps red and blue of stripes; cells
 * contain the position of red themselves. LF_INVERT_AUTO counts from the right, except for invView
 * 0 of configVersion "1.0". */
int lf_view_of_subpixel(const lf_calibration *calibration, int n_views, lf_invert invert, int x,
                        int y, int c, double *out_z);

typedef struct lf_interlacer lf_interlacer;
/* Prepares for 1..65535 views of this shape. aspect = width / height of a displayed view: views are
 * fitted into the panel (black outside); 0 = the panel's. Stores one byte per subpixel of the panel
 * (two over 256 views; none for LF_FILTER_LINEAR). LF_E_ARG, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_interlacer_create(const lf_calibration *calibration, int n_views,
                                            int view_width, int view_height, double aspect,
                                            lf_filter filter, lf_invert invert, lf_interlacer **out,
                                            lf_error *err);
void lf_interlacer_destroy(lf_interlacer *interlacer);
/* Interlaces rows [row0, row1) of the panel into out (screen_width x screen_height, 3 channels).
 * LF_FILTER_NEAREST copies values unchanged. LF_FILTER_LINEAR mixes stored values of view floor(z
 * N) and the next one (clamped at the end of the cone) by the fraction of z N, each sampled
 * bilinearly; this is filterMode 1 of Bridge. Thread: any, for different rows at once; allocates
 * nothing. */
void lf_interlace_rows(const lf_interlacer *interlacer, const lf_views8 *views, lf_image8 *out,
                       int row0, int row1);
/* All rows, on pool (may be NULL). */
void lf_interlace(const lf_interlacer *interlacer, const lf_views8 *views, lf_image8 *out,
                  lf_pool *pool);

/* ---------------------------------------------------------------------------------- response -- */

/* A panel's response to codes, if it is not sRGB; zeroed is sRGB. */
typedef struct lf_response {
    double gamma; /* light = code^gamma; 0 or INFINITY: the curve of sRGB */
    /* white point of the panel (equal codes): a colour temperature (daylight; 0 = none) or
     * chromaticities (0 = none); without either D65 */
    double white, white_x, white_y;
} lf_response;

/* The code to send for every sRGB code of red, green and blue, so that the panel shows sRGB with
 * white D65. Gains are linear in light, at most 1, for the primaries of Rec. 709. */
typedef struct lf_codes {
    uint8_t code[3][256];
    bool same; /* all codes are unchanged */
} lf_codes;
/* LF_E_ARG: two whites, incomplete chromaticities, or a white outside the gamut of Rec. 709. */
LF_NODISCARD lf_status lf_response_codes(const lf_response *response, lf_codes *out, lf_error *err);
/* Applies the codes in place, as the last step: 3 channels; pool may be NULL. */
void lf_codes_apply(const lf_codes *codes, lf_image8 *image, lf_pool *pool);

/* ------------------------------------------------------------------------------------ blends -- */

#define LF_BLEND_WHOLE 256
/* Mixes two images of the shape of out (3 channels), in codes: (WHOLE - weight) parts of `from` and
 * `weight` parts of `to`, rounded to nearest. The weights 0 and LF_BLEND_WHOLE copy. Interlacing
 * with LF_FILTER_NEAREST only selects values, so the mix of two interlaced images is the interlaced
 * mix of their views. out may be one of the two; pool may be NULL. Allocates nothing. */
void lf_blend(const lf_image8 *from, const lf_image8 *to, int weight, lf_image8 *out,
              lf_pool *pool);

/* ------------------------------------------------------------------------------------- cards -- */

/* A card: a generated image with a few words, for a panel without a picture. */
#define LF_CARD_TEXT 384 /* bytes of the text, with its end */

/* The size of a card for a panel: the panel's aspect, at about the resolution of a lens. */
void lf_card_size(int panel_width, int panel_height, int *out_width, int *out_height);
/* Draws light text on dark grey, as large as nine lines at most allow. Text that is too long is cut
 * and ends with dots; characters missing in the font become '?'. The card is used as the only view,
 * so it appears in the plane of the glass. The caller owns *out (lf_image8_finish). LF_E_NOMEM. */
LF_NODISCARD lf_status lf_card_draw(const char *text, int width, int height, lf_image8 *out);

/* ------------------------------------------------------------------------ changed rectangles -- */

/* Compares two frames of equal shape. Writes at most max_rects (>= 1) disjoint rectangles that
 * cover every difference, and returns their number; 0 = equal. Each rectangle touches differences
 * on all four sides; if there are too many, they are merged. Allocates nothing; 64 KiB of stack. */
int lf_changed_rects(const lf_image8 *before, const lf_image8 *after, lf_rect *out_rects,
                     int max_rects);

/* ------------------------------------------------------------------------------------ photos -- */

typedef enum lf_photo_mode { LF_PHOTO_FIT, LF_PHOTO_FILL } lf_photo_mode;
typedef enum lf_turn { LF_TURN_NONE, LF_TURN_90, LF_TURN_180, LF_TURN_270, LF_TURN_AUTO } lf_turn;

/* How to place a finished picture on a view, a panel or a print of another shape. Zeroed: whole,
 * centred, unrotated, with borders (black on views and panels, white on prints). */
typedef struct lf_photo {
    lf_photo_mode mode;
    int position;   /* index in a table of words, 0 the middle */
    lf_turn rotate; /* clockwise; auto: by 90 if one of frame and picture is upright and the other
                     * is not */
    double aspect;  /* width / height of a view in the file; 0: from the files */
    int n_views;    /* the first views of a quilt that are used; 0, or more than there are: all */
    /* set by the program, not by users: */
    double frame;  /* width / height of the panel or print; 0: none */
    bool on_paper; /* borders within the views of a folder, or of a picture with depth, are white */
} lf_photo;
/* Names, ranges and defaults of the user's options (base/param.h): mode and position, and options
 * for reading pictures. */
extern const lf_param lf_photo_params[];
extern const lf_param lf_picture_params[];

/* ------------------------------------------------------------------------------------- files -- */

/* A light field read from a quilt picture or a folder of views. */
typedef struct lf_quilt_file {
    lf_layout layout;
    bool is_float;
    double frame_rate; /* as in lf_image_metadata, of a picture; 0: unknown */
    /* owned: the views in a column, view 0 first (may be taller than a picture); views8 points
     * here */
    lf_image8 image8;
    lf_image32 image32;
    lf_views8 views8;   /* valid when !is_float */
    lf_views32 views32; /* valid when is_float */
    /* notes on unused features of the picture's file, or of a folder's files, each line once, and
     * on scaling or cutting */
    lf_image_notes notes;
} lf_quilt_file;

/* True when path names a picture (PNG, JPEG, EXR by contents) or a folder, and not a scene. */
bool lf_is_quilt(const char *path, const lf_roots *roots);
/* Reads a quilt or a folder of views. columns, rows 0 = from the name (LF_E_ARG if it has none).
 * Padding at right and top is skipped; every tile is a view. A note says if columns and rows differ
 * from the name, or leave out pixels. The aspect is that of the name,
 * otherwise that of a tile, with the pixel shape given in the file.
 *
 * A folder: its pictures (by ending, not hidden) in name order, all of one kind, at most 4096.
 * Pictures of another size than the first are placed on its size as photo says (NULL: zeroed), with
 * a line in notes. Rotating a picture also changes the aspect. LF_E_FORMAT, LF_E_IO, LF_E_PATH,
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_quilt_read_photo(const char *path, const lf_roots *roots, int columns,
                                           int rows, const lf_photo *photo, lf_quilt_file *out,
                                           lf_error *err);
LF_NODISCARD lf_status lf_quilt_read(const char *path, const lf_roots *roots, int columns, int rows,
                                     lf_quilt_file *out, lf_error *err);
/* How lf_quilt_read_photo would cut a picture of this size and pixel shape, which has no pixels
 * yet: layout, notes and views8 without data, for views one below the other. *out_orientation: of
 * lf_orient, by which each view is rotated. LF_E_ARG, LF_E_FORMAT. */
LF_NODISCARD lf_status lf_quilt_plan(const char *path, int columns, int rows, const lf_raster *size,
                                     const lf_photo *photo, lf_quilt_file *out,
                                     int *out_orientation, lf_error *err);
/* Tiles of a picture that is no file by name. */
typedef struct lf_quilt_tiles {
    int columns, rows; /* 1..LF_MAX_TILES */
    int n_views;       /* 1..columns * rows; the tiles behind the last view are unused */
} lf_quilt_tiles;
/* LF_E_ARG: the tiles do not divide a picture of this size; err names `where`. */
LF_NODISCARD lf_status lf_quilt_tiles_check(const lf_quilt_tiles *tiles, int width, int height,
                                            const char *where, lf_error *err);
/* Cuts a picture, whose pixels are copied, into views. The aspect is photo's (which is not NULL),
 * otherwise that of a tile with the pixel shape given in the file. name: of the picture, for
 * errors. LF_E_FORMAT, also as lf_quilt_tiles_check; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_quilt_cut(const lf_raster *picture, const char *name,
                                    const lf_quilt_tiles *tiles, const lf_photo *photo,
                                    lf_quilt_file *out, lf_error *err);
/* Leaves out views after the first n_views. With LF_PHOTO_FILL and a frame: cuts the views to its
 * aspect, in whole pixels, and notes it. */
void lf_photo_cut(const lf_photo *photo, lf_quilt_file *quilt);
void lf_quilt_finish(lf_quilt_file *quilt);

/* Scales a view to this smaller size, by area in linear light. The rows of a view must be packed;
 * out is [height][width][3]. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_view_shrink(const lf_views8 *views, int view, int width, int height,
                                      uint8_t *out);
/* The same for float views. */
LF_NODISCARD lf_status lf_view_shrink32(const lf_views32 *views, int view, int width, int height,
                                        float *out);
/* Row y, from the top, of the quilt that lf_quilt_write_png writes: layout->columns times the
 * views' width, 3 bytes per pixel. */
void lf_quilt_row8(const lf_views8 *views, const lf_layout *layout, int y, uint8_t *out);
/* Writes a quilt of 8-bit or float views (view 0 bottom left, unused tiles black); layers of
 * float views become channels of the file. LF_E_ARG: views and layout do not match; LF_E_IO,
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_quilt_write_png(lf_outfile *file, const lf_views8 *views,
                                          const lf_layout *layout, const lf_attribute *attributes,
                                          int n_attributes, lf_error *err);
/* Writes the quilt as a JPEG of this quality (lf_jpeg_write_rows). */
LF_NODISCARD lf_status lf_quilt_write_jpeg(lf_outfile *file, const lf_views8 *views,
                                           const lf_layout *layout, int quality, lf_error *err);
LF_NODISCARD lf_status lf_quilt_write_exr(lf_outfile *file, const lf_views32 *views,
                                          const lf_layout *layout, const lf_attribute *attributes,
                                          int n_attributes, lf_error *err);

/* Writes one view. Like lf_quilt_write_png and _exr for a single view, it records the pixel aspect
 * if this aspect (0: unknown) makes pixels that are not square. */
LF_NODISCARD lf_status lf_view_write_exr(lf_outfile *file, const lf_views32 *views, int view,
                                         double aspect, const lf_attribute *attributes,
                                         int n_attributes, lf_error *err);

#endif
