/* The rectified rig in camera space; private to render/.
 *
 * Camera space: X right, Y up, Z forward (positive), origin at the middle of the rig. Camera k is
 * at (b_k, 0, 0). A film point is (u, v) in pixels of a view. On the plane Z = D it is at X_w = x0
 * + u dx, Y_w = y0 + v dy. Z0 is the depth at which a point stays in place from view to view. All
 * cameras share this window, so Z0 = D. On a camera track, each camera instead looks straight ahead
 * through a window of its own, as if all shared one at infinity, Z0 = inf. X_w is then counted from
 * b_k - e_k; e_k = b_k D/Z0 is the distance of the camera from the middle of its window. A row of a
 * camera grid lies above or below the middle of the grid. Its origin and window are its own; if all
 * rows share a window, y0 places it lower.
 *
 * Thin lens (all views have the same radius): a ray leaves (b_k + lx, ly, 0) towards the point of
 * the focus plane Z = F that the pinhole ray of its film point hits. All rays of a row, in every
 * view, have the same v and ly. So they lie in one plane Y = ly + my Z
 * (docs/developer/estimators.md, "2. The rig and its row planes"):
 *
 *     X(Z) = b_k + lx + mx Z,   mx = (X_w - e_k)/D - lx/F,   my = Y_w/D - ly/F
 *     X_w  = e_k + D ((X - b_k - lx)/Z + lx/F)
 *
 * view_blur is a lens with a width along X only (ly = 0), in focus at Z0 (F = Z0). lx is
 * uniform within half of view_blur steps from camera to camera, so a view is the mean of pinhole
 * views along that line. In a row of a grid, ly is uniform, too, within half of view_blur steps
 * from row to row; a view is then the mean over that cell.
 *
 * The length of a part of such a ray is sqrt(1 + mx^2 + my^2) times its extent in Z. */
#ifndef LF_RENDER_RIG_H
#define LF_RENDER_RIG_H

#include "render/film/film_feature.h"
#include "render/render.h"
#include "render/scene/scene.h"

/* Views are processed by the kernels in groups of 8 lanes. */
#define LF_LANES 8
#define LF_MAX_LANES ((LF_MAX_VIEWS + LF_LANES - 1) / LF_LANES * LF_LANES)

/* Z0 of cameras with windows of their own: a finite substitute for infinity. */
#define LF_FAR_WINDOW 1e20f

typedef struct lf_rig {
    int n_views, width, height;
    lf_vec3 eye, right, up, forward; /* scene-local */
    float distance, window;          /* D, Z0 */
    float focus, lens_radius;        /* F (= Z0 for pinholes); radius 0 = pinhole */
    float blur,
        blur_up; /* half the width of a view's line or cell of cameras, and half its height */
    /* window coordinates of film point (0, 0) and of one pixel; dy < 0 */
    float x0, dx, y0, dy;
    /* slope of the window's upper edge seen from the middle; the lower edge has minus this.
     * INFINITY: the image lies on its side, and all rows count as its middle */
    float tangent;
    float sink;  /* subtracted from both slopes if the rig lies above the middle */
    float still; /* D/Z0, 1 or 0: the nearness of points that do not move from view to view */
    /* camera positions along X, increasing, and e; lanes after n_views repeat the last */
    float b[LF_MAX_LANES], skew[LF_MAX_LANES];
} lf_rig;

/* The plane of one row in one visit. */
typedef struct lf_row_plane {
    float ly, my;     /* Y = ly + my Z */
    float lens_chord; /* lx is uniform in [-lens_chord, lens_chord] */
} lf_row_plane;

/* LF_E_ARG if the number of views, the view size or the aspect is out of range; for any cameras. */
LF_NODISCARD lf_status lf_rig_check_size(const lf_render_settings *settings, lf_error *err);
/* LF_E_ARG: settings out of range. origin is the scene's (world = local + origin). */
LF_NODISCARD lf_status lf_rig_init(lf_rig *rig, const lf_render_settings *settings,
                                   const double origin[3], lf_error *err);

/* Number of shutter times at which the field of view of a moving rig is sampled in advance. */
#define LF_RIG_MOMENTS 17

/* The rig with its camera at a shutter time: 0 when the shutter opens, 1 when it closes. LF_E_ARG
 * if the rig is invalid at that time. */
LF_NODISCARD lf_status lf_rig_init_at(lf_rig *rig, const lf_render_settings *settings,
                                      const double origin[3], double time, lf_error *err);

/* v in [0, height): the row's film coordinate. u_lens[2] in [0,1): point of the lens (only its
 * height is used). */
void lf_rig_row_plane(const lf_rig *rig, float v, const float u_lens[2], lf_row_plane *out);

/* D/Z, with points nearer than D/8 treated as at D/8: the depth in features (film_feature.h). */
static inline float lf_nearness(float distance, float z)
{
    float y = distance / lf_max(z, 1e-30f);
    return y < LF_NEARNESS_MAX ? y : LF_NEARNESS_MAX;
}

/* Sets out to the matrix that maps (column, row, nearness D/Z, 1), of a point in front of the
 * middle of `from`, columns and rows in film coordinates, to the coordinates seen from the middle
 * of `to`. The result is multiplied by Z there times D/Z here. Rows of the matrix come first. */
void lf_rig_map_between(const lf_rig *from, const lf_rig *to, double out[4][4]);

/* Where the line from the middle of from's window through its eye meets the camera line of `to`, as
 * distance from its middle over the length of its n_views cameras; 0 if it does not. */
float lf_rig_view_between(const lf_rig *from, const lf_rig *to);

/* Position of a row plane's my between the window's upper edge, 0, and lower edge, 1. The same for
 * all views, whatever part of the window is rendered. */
static inline float lf_rig_height_between(const lf_rig *rig, float my)
{
    return lf_min(lf_max(0.5f - 0.5f * (my + rig->sink) / rig->tangent, 0.0f), 1.0f);
}

static inline lf_vec3 lf_rig_point(const lf_rig *rig, float x, float y, float z)
{
    return lf_madd(lf_madd(lf_madd(rig->eye, x, rig->right), y, rig->up), z, rig->forward);
}

static inline lf_vec3 lf_rig_direction(const lf_rig *rig, float x, float y, float z)
{
    return lf_madd(lf_madd(lf_scale(rig->right, x), y, rig->up), z, rig->forward);
}

/* mx of a view's pinhole ray through u, in columns. */
static inline float lf_rig_slope(const lf_rig *rig, int view, float u)
{
    return (rig->x0 + u * rig->dx - rig->skew[view]) / rig->distance;
}

/* Half a pixel's extent on a plane across the view, per unit of its depth Z; the same in all views.
 * A ray filters textures over it; the pixel averages its rays. */
static inline float lf_rig_spread(const lf_rig *rig)
{
    return 0.5f * lf_min(rig->dx, fabsf(rig->dy)) / rig->distance;
}

/* Rays X(Z) = x0[k] + slope[k] Z of a row's plane up to z_end[k], for the features of their
 * collisions. */
typedef struct lf_feature_rays {
    int n; /* as for lf_kernels.march */
    const float *x0, *slope, *z_end;
    const float *length; /* per unit of Z */
    float distance;      /* nearness is distance / Z (film_feature.h) */
} lf_feature_rays;

/* Lanes that hold all views: a multiple of LF_LANES. */
static inline int lf_rig_lanes(const lf_rig *rig)
{
    return (rig->n_views + LF_LANES - 1) / LF_LANES * LF_LANES;
}

#endif
