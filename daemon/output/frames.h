/* Frames of a sequence: their numbers, file names and cameras. In this header a row of a camera
 * grid, which is one light field, counts as a frame; rows are numbered from 0.
 *
 * A scene defines the content of a frame (docs/reference/scene-format.md, "Frames"). A turntable
 * of N frames, 1 to N, moves its camera once around the target. Functions keep no state. Thread:
 * any. */
#ifndef LF_DAEMON_FRAMES_H
#define LF_DAEMON_FRAMES_H

#include "render/render.h"

/* The options of a sequence; zeroed: a single picture. */
typedef struct lf_frames {
    int turntable; /* frames of a full turn; 0: no turntable */
    int first, last;
    bool has_range; /* first and last were given */
    bool of_rows;   /* first and last are rows of cameras */
    bool overwrite; /* render frames again whose files exist */
    bool mixed;     /* accept files that were rendered with other settings */
} lf_frames;
extern const lf_param lf_frames_params[];

/* True if a sequence is requested. */
bool lf_frames_wanted(const lf_frames *frames);
/* The option that requests it; the plural noun for its members. */
const char *lf_frames_option(const lf_frames *frames);
const char *lf_frames_noun(const lf_frames *frames);
/* Completes first and last; without a range: the whole turntable. LF_E_ARG: the range is reversed
 * or outside the turntable, or rows are combined with frames. */
LF_NODISCARD lf_status lf_frames_check(lf_frames *frames, lf_error *err);
int lf_frames_count(const lf_frames *frames);

/* The output name of a frame. The number replaces the number field of path (base/frame_name.h).
 * Without such a field, "_0001" is inserted before _qsCxRaA or, without that, before the ending.
 * Caller frees with lf_free; NULL = out of memory. */
char *lf_frames_path(const char *path, int frame);

/* The seed of a frame. Frames do not share their noise; frame 1 has `seed` itself. */
uint64_t lf_frames_seed(uint64_t seed, int frame);
/* The seed of a row of cameras; row 0 has `seed` itself. */
uint64_t lf_rows_seed(uint64_t seed, int row);

/* The seed of a part of a shutter, independent of the frames that contain it. */
uint64_t lf_parts_seed(uint64_t seed, int64_t part);

/* Divides a shutter of `shutter` frames into equal parts that the frames before and after also
 * contain. Returns the number of parts; *out_a_frame: parts per frame, 1 to 4. 0: no parts, because
 * the shutter is open for at most a frame, or not for a whole number of frames, halves, thirds or
 * quarters. */
int lf_frames_parts(double shutter, int *out_a_frame);

/* The merge patch (RFC 7396) that selects a frame in a scene's document. A new reference; NULL =
 * out of memory. */
json_t *lf_frames_patch(int frame);
/* Like lf_frames_patch, with the camera of a turntable if there is one. camera: the scene's own,
 * used for frame 1. */
json_t *lf_frames_patch_turned(const lf_frames *frames, const lf_camera *camera, int frame);

#endif
