/* The camera of a scene: a rig, rows or parts of a rig, or a list of cameras. Angles are in
 * radians. */
#ifndef LF_RENDER_CAMERA_H
#define LF_RENDER_CAMERA_H

#include <stdbool.h>

#include "base/param.h"

/* Offsets of camera values at one end of the shutter. */
typedef struct lf_camera_shift {
    double position[3], target[3], focus_distance;
} lf_camera_shift;

/* One camera of a list, a pinhole with any direction, in world coordinates. fov_y: vertical angle
 * of its image, radians. */
typedef struct lf_view_camera {
    double position[3], target[3], up[3], fov_y;
} lf_view_camera;

/* The rig of a scene's camera block, resolved. */
typedef struct lf_camera {
    double target[3], position[3], up[3];
    /* radians: vertical angle of the window, seen from the middle of the rig */
    double fov_y;
    double aspect; /* width / height of the window */
    double cone;   /* radians: total angle of the rig (the view cone) */
    /* Factor of the cone in use, or of the track or grid, 0..LF_MAX_DEPTHINESS; lf_camera_deepen
     * applies it. */
    double depthiness;
    /* camera track: length in scene units from the first to the last camera, which are equally
     * spaced along X and not on the arc of the cone; 0: the arc */
    double track;
    /* A grid consists of rows of a track's cameras, the lowest first, equally spaced over
     * rows_height. Each row is a rig of its own, whose cameras lie `rise` above the track. Own
     * windows move with the row; a shared window stays. view_blur then has the same width
     * vertically as horizontally, with rows_step from row to row. */
    double rows_height, rise, rows_step;
    int n_views; /* per row: 1..LF_MAX_VIEWS */
    int n_rows;  /* of a grid; 0: not a grid */
    /* A track with more cameras than a rig can have is split into equal parts from the left, which
     * are handled like rows. all_views > 0: this is a part, with the cameras from first_view on out
     * of all_views. */
    bool has_parts;
    int first_view, all_views;
    /* placement: true: a_i = (i/(N-1) - 1/2) cone; false: ((i+1/2)/N - 1/2) cone */
    bool inclusive;
    bool own_windows; /* on a track, each camera looks straight ahead through its own window */
    /* scene units; radius 0 = pinhole; focus along the view axis, 0 (for a list): each camera's
     * target */
    double lens_radius, focus_distance;
    /* Width of each view's aperture along the camera line, in camera spacings (mean over the rig),
     * 0..LF_MAX_VIEW_BLUR. 1: no gaps between views and no double edges. Excludes lens_radius */
    double view_blur;
    /* Exposure time in frames, 0..LF_MAX_SHUTTER (0: no motion blur), and the time from the frame
     * to the opening, in frames. The motion is the one with which the scene was loaded. */
    double shutter, shutter_open;
    /* Offsets when the shutter opens and when it closes; linear between. All 0 unless the camera
     * moves. */
    lf_camera_shift shift[2];
    /* Which of aspect, views and cone the scene sets. The others are defaults that a preset or
     * panel may replace. */
    bool has_aspect, has_views, has_cone;
    bool moves; /* within the shutter: shift is not all 0 */
    /* The image lies on its side, so its rows are columns of what is shown: a backdrop is its
     * middle colour. */
    bool rolled;
    /* Every view's camera, instead of a rig: [n_views], owned by the scene. target, position, up
     * and fov_y are then copies of the middle camera. NULL: a rig */
    const lf_view_camera *list;
} lf_camera;

/* Number of views, over all rows of a grid. */
static inline int lf_camera_views(const lf_camera *camera)
{
    return camera->n_views * (camera->n_rows > 0 ? camera->n_rows : 1);
}
/* Multiplies the cone, the track and the height of a grid by depthiness, which becomes 1. To be
 * called when the cone in use is known. A list stays. */
void lf_camera_deepen(lf_camera *camera);
/* The camera of row `row` of a grid, 0 the lowest, or of a part of a track: one rig with n_views
 * views. */
lf_camera lf_camera_row(const lf_camera *camera, int row);

/* Names, ranges and defaults of the scene's camera keys (base/param.h). A focus_distance of 0 means
 * not given: the distance to the target. */
extern const lf_param lf_camera_params[];

#define LF_MAX_SHUTTER 10
#define LF_MAX_VIEWS 256
#define LF_MAX_TRACK_VIEWS 2048
#define LF_MAX_CAMERA_ROWS 256
#define LF_MAX_VIEW_SIDE 16384
#define LF_MAX_VIEW_BLUR 8
#define LF_MAX_DEPTHINESS 2

#endif
