/* The camera of a scene: a rig, rows or parts of one, or a list of cameras. Angles in radians. */
#ifndef LF_RENDER_CAMERA_H
#define LF_RENDER_CAMERA_H

#include <stdbool.h>

#include "base/param.h"

/* What is added to numbers of a camera at one end of its shutter. */
typedef struct lf_camera_shift {
    double position[3], target[3], focus_distance;
} lf_camera_shift;

/* One of many cameras, each a pinhole that looks where it likes: world coordinates; radians, the
 * vertical angle of its picture. */
typedef struct lf_view_camera {
    double position[3], target[3], up[3], fov_y;
} lf_view_camera;

/* The rig of a scene's camera block, resolved. */
typedef struct lf_camera {
    double target[3], position[3], up[3];
    /* radians: vertical angle of the window seen from the middle of the rig */
    double fov_y;
    double aspect; /* width / height of the window */
    double cone;   /* radians: total angle of the rig */
    /* Instead of on that arc, cameras at equal distances along X, from the first to the last so
     * many scene units; 0: the arc */
    double track;
    /* A grid is rows of a track's cameras, the lowest first, at equal distances up to rows_height.
     * Each row is a rig of its own, whose cameras stand rise above the track: own windows go along,
     * a shared one stays; view_blur is then as wide up and down as across, rows_step being from row
     * to row. */
    double rows_height, rise, rows_step;
    int n_views; /* of a row: 1..LF_MAX_VIEWS */
    int n_rows;  /* of a grid; 0: it is none */
    /* A track of more cameras than a rig has is parts of as many, from the left on, which stand in
     * for rows. all_views > 0: a part, whose cameras are first_view and the following ones of so
     * many. */
    bool has_parts;
    int first_view, all_views;
    /* placement: a_i = (i/(N-1) - 1/2) cone, else ((i+1/2)/N - 1/2) cone */
    bool inclusive;
    bool own_windows; /* on a track each camera looks straight ahead, through its own window */
    /* scene units; radius 0 = pinhole; focus along the view axis, 0 (of a list): each its target */
    double lens_radius, focus_distance;
    /* A view is the mean of the views from so many times the distance of neighbouring cameras (its
     * mean over the rig) about its own, 0..LF_MAX_VIEW_BLUR: 1 = no gaps, nothing seen twice. Not
     * with a lens_radius */
    double view_blur;
    /* Frames that the shutter stays open, 0..LF_MAX_SHUTTER (0: all stands still), and how long
     * after the frame it opens. What moved when a scene was loaded does so for its pictures. */
    double shutter, shutter_open;
    /* When it opens, and when it closes; in between evenly. All 0 unless it moves. */
    lf_camera_shift shift[2];
    /* Which of aspect, views and cone the scene itself states (the rest are defaults a preset or
     * panel may replace without being a contradiction). */
    bool has_aspect, has_views, has_cone;
    bool moves; /* in the shutter: shift is not all 0 */
    /* In place of a rig, every view's camera: [n_views], the scene's own and valid as long as it.
     * target, position, up and fov_y are then those of the one in the middle. NULL: a rig */
    const lf_view_camera *list;
} lf_camera;

/* Views of a camera: of all rows of a grid. */
static inline int lf_camera_views(const lf_camera *camera)
{
    return camera->n_views * (camera->n_rows > 0 ? camera->n_rows : 1);
}
/* The camera of a grid's row, 0 the lowest, or of a track's part: one rig, of n_views. */
lf_camera lf_camera_row(const lf_camera *camera, int row);

/* What a scene says of it: names, ranges, defaults (base/param.h). A focus_distance of 0 is not
 * given: the distance to the target. */
extern const lf_param lf_camera_params[];

#define LF_MAX_SHUTTER 10
#define LF_MAX_VIEWS 256
#define LF_MAX_TRACK_VIEWS 2048
#define LF_MAX_CAMERA_ROWS 256
#define LF_MAX_VIEW_SIDE 16384
#define LF_MAX_VIEW_BLUR 8

#endif
