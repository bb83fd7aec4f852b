/* Frames of a sequence: which of them there are, what they are called, where the camera stands.
 * Rows of a grid of cameras, a light field each, are frames in all that follows, but for their
 * numbers, which begin with 0.
 *
 * Frames have numbers. A scene says what is there in a frame (docs/reference/scene-format.md,
 * "Frames"); a turntable of N frames, 1 to N, takes its camera once round the target. Nothing here
 * keeps state. Thread: any. */
#ifndef LF_DAEMON_FRAMES_H
#define LF_DAEMON_FRAMES_H

#include "render/render.h"

/* What the options say; zeroed: one picture and no sequence. */
typedef struct lf_frames {
    int turntable; /* frames of a whole turn; 0: the camera stands */
    int first, last;
    bool has_range; /* first and last were given */
    bool of_rows;   /* first and last are rows of cameras */
    bool overwrite; /* frames whose files are there are rendered anew */
} lf_frames;
extern const lf_param lf_frames_params[];

/* Whether a sequence is wanted. */
bool lf_frames_wanted(const lf_frames *frames);
/* The option that asks for it; what it is made of, in the plural. */
const char *lf_frames_option(const lf_frames *frames);
const char *lf_frames_noun(const lf_frames *frames);
/* Completes first and last: without a range all of the turntable. LF_E_ARG: they are the wrong way
 * round, or not of the turntable; rows beside frames. */
LF_NODISCARD lf_status lf_frames_check(lf_frames *frames, lf_error *err);
int lf_frames_count(const lf_frames *frames);

/* The name of a frame's output: the number in the places that path has for it
 * (base/frame_name.h), else "_0001" before its _qsCxRaA or, without that, before its ending. Caller
 * frees with lf_free; NULL = out of memory. */
char *lf_frames_path(const char *path, int frame);

/* The random choices of a frame follow from this: frames do not share their noise, and frame 1 has
 * the seed itself. */
uint64_t lf_frames_seed(uint64_t seed, int frame);
/* The same of a row of cameras; row 0 has the seed itself. */
uint64_t lf_rows_seed(uint64_t seed, int row);

/* The same of a part of a shutter, whichever frames have it. */
uint64_t lf_parts_seed(uint64_t seed, int64_t part);

/* The parts of a shutter that stays open for so many frames which the frames before and after have,
 * too: of one length, *out_a_frame of them in a frame, 1 to 4. 0: there are none, since it stays
 * open for a frame at most, or for no whole number of frames, halves, thirds or quarters. */
int lf_frames_parts(double shutter, int *out_a_frame);

/* What makes a scene's document (RFC 7396) that of a frame. A new reference; NULL = out of memory.
 */
json_t *lf_frames_patch(int frame);
/* The same with the camera of a turntable, where there is one; camera is the scene's own, that of
 * frame 1. */
json_t *lf_frames_patch_turned(const lf_frames *frames, const lf_camera *camera, int frame);

#endif
