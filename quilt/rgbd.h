/* rgbd: pictures with depth (RGBD) become the views of a light field, and how finished pictures
 * stand: depth, focus, zoom.
 *
 * An RGBD picture is two halves of the same size: the colours of one view, and its depth as codes
 * from 0, far, to 1, near. Nearness 1/Z is linear in the code, as `export rgbd` writes it. Then a
 * plane in space is linear in the code over the pixels, and so is the shift between views:
 *
 *     camera i of a line of length B stands b_i to the right of its middle, the picture's camera b
 *     the window that all cameras share is at the distance D, W wide
 *     a point at the distance Z moves by (b_i - b) (1 - D/Z) / W of the view's width
 *     1/Z = 1/far + c (1/near - 1/far)
 *
 *     shift_i(c) = (beta_i - beta) disparity (plane - c)      (lf_rgbd_shift)
 *     disparity  = B D (1/near - 1/far) / W
 *     plane      = (1/D - 1/far) / (1/near - 1/far)           the code that stands in the glass
 *
 * beta_i = b_i / B: from -1/2 to 1/2. Near points move to the left from view 0 to the last one.
 * docs/developer/rgbd.md derives this, and says how steps and holes are handled.
 *
 * Functions are pure or work on their own object; thread safe on different objects. */
#ifndef LF_QUILT_RGBD_H
#define LF_QUILT_RGBD_H

#include "quilt/quilt.h"

/* ----------------------------------------------------------------------------------- options -- */

/* Where the depth half is. */
typedef enum lf_rgbd_in {
    LF_RGBD_IN_AUTO, /* right, if the name says RGBD (lf_rgbd_named) */
    LF_RGBD_IN_OFF,
    LF_RGBD_IN_RIGHT,
    LF_RGBD_IN_LEFT,
    LF_RGBD_IN_TOP,
    LF_RGBD_IN_BOTTOM,
} lf_rgbd_in;

/* How a finished picture stands. Fill it with lf_param_defaults(lf_standing_params, …). Zeroed is
 * valid, too: zoom 0 says that it was not filled, and then depthiness counts as 1. */
typedef struct lf_standing {
    lf_rgbd_in rgbd_in;
    int depth_inversion; /* 1: near is black */
    int chroma_depth;    /* 1: depth is a hue, red near to blue far */
    double depthiness;   /* factor of the depth */
    double depth_cutoff; /* smaller codes (farther points) count as this code */
    double focus;        /* view i of N moves to the right by (2 i/(N-1) - 1) focus of its width */
    double zoom;
    double crop_x, crop_y; /* half widths, half heights of the picture */
    /* no key: borders of a finished picture are white, not black (lf_photo's is for a picture with
     * depth) */
    bool on_paper;
} lf_standing;
/* Its keys and options (base/param.h). */
extern const lf_param lf_standing_params[];
/* LF_E_ARG: a value is out of range or not a number. */
LF_NODISCARD lf_status lf_standing_check(const lf_standing *standing, const char *where,
                                         lf_error *err);
/* True if the name ends with _rgbd before its ending, in any case: "photo_rgbd.png". */
bool lf_rgbd_named(const char *path);
/* Where the depth is, by option and name: LF_RGBD_IN_OFF, or a side. */
lf_rgbd_in lf_rgbd_side_of(const lf_standing *standing, const char *path);

/* ------------------------------------------------------------------------------------- views -- */

/* The total disparity at depthiness 1 of a picture without known geometry: the shift of the nearest
 * code against the farthest one between the first and the last view, in widths of the picture. With
 * it no point moves by more than about one pixel from view to view in the quilt of a Portrait (48
 * views, 420 pixels wide), wherever the plane of the glass is. At depthiness 4 this is four pixels,
 * the least limit of lf_depth. */
#define LF_RGBD_DISPARITY (1.0 / 9.0)

/* A difference of codes between neighbouring pixels above this is a step: the surface is cut. */
#define LF_RGBD_STEP (1.0 / 12.0)

/* Positions within a pixel at which views are sampled along a row: edges are exact to an eighth of
 * a pixel of a view. */
#define LF_RGBD_SAMPLES 4

/* A picture with depth, and how it becomes views. */
typedef struct lf_rgbd {
    lf_rgbd_in side; /* not AUTO or OFF */
    bool near_is_black;
    bool is_hue;
    bool is_known;           /* the geometry is the file's, not LF_RGBD_DISPARITY */
    bool is_flattened;       /* the file's disparity is larger than can be drawn */
    double disparity, plane; /* see above; in widths of the picture; plane may be outside 0..1 */
    double offset;           /* beta of the picture's own camera; 0: the middle */
    double cone;             /* radians: cameras stand at tan((t - 1/2) cone); 0: evenly spaced */
    bool centred;            /* t = (i + 1/2)/N; otherwise i/(N - 1) */
    double cutoff;           /* lf_standing.depth_cutoff */
    double focus;            /* lf_standing.focus */
    double zoom, crop_x, crop_y;
    lf_photo photo; /* mode and position: a view of another shape than the picture */
} lf_rgbd;

/* A rgbd for this side, or of known geometry (meta->depth; otherwise LF_RGBD_DISPARITY with the
 * middle code in the glass). A disparity of more than four widths at depthiness 1 is drawn as four
 * widths, with the same code in the glass. meta may be NULL. */
lf_rgbd lf_rgbd_of(const lf_standing *standing, lf_rgbd_in side, const lf_image_metadata *meta);
/* Makes the angle between the outer cameras smaller, factor 0..1; the picture's own camera stays
 * where it is. */
void lf_rgbd_narrow(lf_rgbd *rgbd, double factor);
/* Follows the picture's turn to an EXIF orientation (1..8). Views differ along the new width: after
 * a quarter turn the picture's camera is in the middle, and known disparity counts in new widths.
 * aspect: width / height before the turn. */
void lf_rgbd_turn(lf_rgbd *rgbd, int orientation, double aspect);
/* How many views a colour half of width x height pixels has: 1, or more if the file says that the
 * views of its scene are smaller (rgbd-of quilt). */
int lf_rgbd_tiles(const lf_image_depth *depth, int width, int height);

/* The size of the colour half of a picture. LF_E_FORMAT: the picture has no such halves. */
LF_NODISCARD lf_status lf_rgbd_size(lf_rgbd_in side, int width, int height, const char *where,
                                    int *out_width, int *out_height, lf_error *err);

/* Position beta of a camera of n_views: -1/2 leftmost to 1/2; the picture's own for one view. */
double lf_rgbd_camera(const lf_rgbd *rgbd, int view, int n_views);
/* How far a point with this code moves to the right in a view, in widths of the picture (focus is
 * in widths of the view and not included). */
double lf_rgbd_shift(const lf_rgbd *rgbd, int view, int n_views, double code);

/* The largest shift of any code from the cutoff to 1 between neighbouring views, with focus, in
 * widths of the picture; 0 for one view. */
double lf_rgbd_step(const lf_rgbd *rgbd, int n_views);

/* A packed picture with both halves, 8 bits, display encoded. Borrowed. */
typedef struct lf_rgbd_picture {
    int width, height; /* with both halves */
    size_t stride;     /* bytes from row to row */
    const uint8_t *data;
    double pixel_aspect; /* width / height of a pixel; 0: square */
} lf_rgbd_picture;

/* What a picture's depth half looks like; for a warning or an error. */
typedef struct lf_rgbd_look {
    bool is_flat;     /* all codes are the same */
    bool is_coloured; /* the depth half has colours, which its codes do not use (is_hue: has no
                       * colours) */
} lf_rgbd_look;
lf_rgbd_look lf_rgbd_look_at(const lf_rgbd *rgbd, const lf_rgbd_picture *picture);

/* Everything that does not depend on the pixels of a picture, for many pictures (a video) of one
 * size. */
typedef struct lf_rgbd_warp lf_rgbd_warp;
/* Views as in layout: n_views of view_width x view_height pixels, displayed with its aspect. The
 * picture is placed on them as rgbd->photo says, with borders of black, or white on paper; where it
 * ends at the side of its own frame it goes on mirrored. pool may be NULL and must be the one of
 * lf_rgbd_warp_run. picture->data is not read. LF_E_ARG (options, not numbers), LF_E_FORMAT (no
 * halves; err names `where`), LF_E_NOMEM. */
LF_NODISCARD lf_status lf_rgbd_warp_create(const lf_rgbd *rgbd, const lf_rgbd_picture *picture,
                                           const lf_layout *layout, const lf_pool *pool,
                                           const char *where, lf_rgbd_warp **out, lf_error *err);
void lf_rgbd_warp_destroy(lf_rgbd_warp *warp);
/* Draws all views of a picture of that size to out, [view][row][column][3]. Rows run on the pool;
 * the bytes do not depend on the number of threads. Allocates nothing. One run at a time. */
void lf_rgbd_warp_run(lf_rgbd_warp *warp, const lf_rgbd_picture *picture, uint8_t *out,
                      lf_pool *pool);
/* Create, run and destroy. */
LF_NODISCARD lf_status lf_rgbd_views(const lf_rgbd *rgbd, const lf_rgbd_picture *picture,
                                     const lf_layout *layout, lf_pool *pool, const char *where,
                                     uint8_t *out, lf_error *err);

/* ------------------------------------------------------------------------------------- files -- */

/* A picture with depth from a file. Release with lf_rgbd_file_close; zeroed is empty. */
typedef struct lf_rgbd_file {
    lf_raster raster; /* owned; zeroed if the pixels are a caller's */
    uint8_t *turned;  /* owned: both halves after photo_rotate; NULL: they are the raster's */
    lf_rgbd rgbd;
    lf_rgbd_picture picture;
    int width, height;    /* of the colour half as it is shown */
    double aspect;        /* width / height of the colour half as it is shown */
    lf_image_notes notes; /* on features of the file, and on a depth half with colours */
} lf_rgbd_file;
/* Takes a decoded picture, which is borrowed until lf_rgbd_file_close. photo: as for lf_quilt_cut,
 * with its mode and position on the views. name: of the picture, for errors. LF_E_FORMAT: no depth
 * (no halves, a depth half of one colour), or floats; LF_E_ARG, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_rgbd_file_take(const lf_raster *raster, const char *name,
                                         const lf_standing *standing, lf_rgbd_in side,
                                         const lf_photo *photo, lf_rgbd_file *out, lf_error *err);
/* Reads a file by name, inside roots (NULL: anywhere). Errors of lf_raster_open, too. */
LF_NODISCARD lf_status lf_rgbd_file_open(const char *path, const lf_roots *roots,
                                         const lf_standing *standing, lf_rgbd_in side,
                                         const lf_photo *photo, lf_rgbd_file *out, lf_error *err);
/* Draws its views as a finished light field. The caller owns *out. LF_E_ARG, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_rgbd_file_draw(const lf_rgbd_file *file, const char *name,
                                         const lf_layout *layout, lf_pool *pool, lf_quilt_file *out,
                                         lf_error *err);
void lf_rgbd_file_close(lf_rgbd_file *file);

/* ---------------------------------------------------------------------------- finished views -- */

/* True if focus, zoom and crop leave a finished picture as it is. */
bool lf_standing_is_plain(const lf_standing *standing);
/* Moves (focus), scales (zoom) and shifts (crop) finished 8-bit views into out,
 * [view][row][column][3] of the same size, which must not overlap them. Linear interpolation of
 * codes along x and y; borders are black, or white on paper, and where focus moves a view's own
 * side into the picture it goes on mirrored. pool may be NULL. Allocates nothing. */
void lf_standing_views8(const lf_standing *standing, const lf_views8 *views, uint8_t *out,
                        lf_pool *pool);

/* Does the same to a quilt file's views, which it replaces. LF_E_ARG: float views; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_quilt_stand(const lf_standing *standing, const char *where,
                                      lf_quilt_file *quilt, lf_pool *pool, lf_error *err);

#endif
