#include "daemon/output/frames.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/frame_name.h"
#include "daemon/output/orbit.h"
#include "quilt/quilt.h"

#define MOST_FRAME 999999
/* Most parts per frame of overlapping shutters. */
#define MOST_PARTS 4

#define PLACE(field) .place = offsetof(lf_frames, field)

/* clang-format off */
const lf_param lf_frames_params[] = {
    {.option = "turntable", .argument = "N", PLACE(turntable), .type = LF_PARAM_WHOLE, .low = 1,
     .high = MOST_FRAME, .help = "render N frames of one camera orbit around the target"},
    {.option = "frames", .joined = ":", .argument = "A", PLACE(first), .type = LF_PARAM_WHOLE,
     .has = offsetof(lf_frames, has_range), .high = MOST_FRAME,
     .help = "render frames A to B of an animated scene or turntable, or take these images"},
    {.option = "frames", .argument = "B", PLACE(last), .type = LF_PARAM_WHOLE, .high = MOST_FRAME},
    {.option = "camera-rows", .joined = ":", .argument = "A", PLACE(first), .type = LF_PARAM_WHOLE,
     .has = offsetof(lf_frames, of_rows), .high = LF_MAX_CAMERA_ROWS - 1,
     .help = "render rows A to B of a camera grid, one output per row"},
    {.option = "camera-rows", .argument = "B", PLACE(last), .type = LF_PARAM_WHOLE,
     .high = LF_MAX_CAMERA_ROWS - 1},
    {.option = "overwrite", PLACE(overwrite), .type = LF_PARAM_SWITCH,
     .help = "re-render frames whose files exist"},
    {.option = "mixed", PLACE(mixed), .type = LF_PARAM_SWITCH,
     .help = "keep or join frames that were rendered with other settings"},
    {0},
};
/* clang-format on */

bool lf_frames_wanted(const lf_frames *frames)
{
    return frames->turntable > 0 || frames->has_range || frames->of_rows;
}

const char *lf_frames_option(const lf_frames *frames)
{
    return frames->of_rows ? "--camera-rows" : frames->turntable > 0 ? "--turntable" : "--frames";
}

const char *lf_frames_noun(const lf_frames *frames)
{
    return frames->of_rows ? "rows" : "frames";
}

lf_status lf_frames_check(lf_frames *frames, lf_error *err)
{
    if (!lf_frames_wanted(frames))
        return LF_OK;
    if (frames->of_rows && (frames->has_range || frames->turntable > 0))
        return lf_error_set(err, LF_E_ARG, "--camera-rows", "cannot be combined with %s",
                            frames->turntable > 0 ? "--turntable" : "--frames");
    if (!frames->has_range && !frames->of_rows) {
        frames->first = 1;
        frames->last = frames->turntable;
    }
    if (frames->first > frames->last)
        return lf_error_set(err, LF_E_ARG, lf_frames_option(frames),
                            "%d:%d ends before it begins; expected FIRST:LAST with FIRST <= LAST",
                            frames->first, frames->last);
    if (frames->turntable > 0 && (frames->first < 1 || frames->last > frames->turntable))
        return lf_error_set(err, LF_E_ARG, "--frames",
                            "%d:%d is outside --turntable %d; expected frames within 1:%d",
                            frames->first, frames->last, frames->turntable, frames->turntable);
    return LF_OK;
}

int lf_frames_count(const lf_frames *frames)
{
    return frames->last - frames->first + 1;
}

/* The offset at which "_0001" is inserted. */
static size_t place_in(const char *path)
{
    const char *suffix = lf_layout_suffix(path), *slash = strrchr(path, '/');
    if (suffix)
        return (size_t)(suffix - path);
    if (slash && slash[1] == '\0')
        return (size_t)(slash - path);
    const char *dot = strrchr(slash ? slash : path, '.');
    return dot ? (size_t)(dot - path) : strlen(path);
}

char *lf_frames_path(const char *path, int frame)
{
    if (lf_frame_name_varies(path))
        return lf_frame_name(path, frame);
    size_t place = place_in(path), size = strlen(path) + 32;
    char *name = lf_calloc(size, 1);
    if (name)
        snprintf(name, size, "%.*s_%04d%s", (int)place, path, frame, path + place);
    return name;
}

uint64_t lf_frames_seed(uint64_t seed, int frame)
{
    return seed + (uint64_t)(int64_t)(frame - 1);
}

/* Rows and frames do not share noise. */
uint64_t lf_rows_seed(uint64_t seed, int row)
{
    return seed + (uint64_t)row * UINT64_C(0x9e3779b97f4a7c15);
}

uint64_t lf_parts_seed(uint64_t seed, int64_t part)
{
    return seed + UINT64_C(0xd1b54a32d192ed03) + (uint64_t)part;
}

int lf_frames_parts(double shutter, int *out_a_frame)
{
    for (int n = 1; n <= MOST_PARTS && shutter > 1.0; n++) {
        const double parts = shutter * n;
        *out_a_frame = n;
        if (fabs(parts - round(parts)) < 1e-6 && parts > n + 0.5)
            return (int)round(parts);
    }
    return 0;
}

json_t *lf_frames_patch(int frame)
{
    return json_pack("{s:i}", "frame", frame);
}

/* Frame 1 has the scene's own camera, to the last bit. */
json_t *lf_frames_patch_turned(const lf_frames *frames, const lf_camera *camera, int frame)
{
    double p[3];
    if (frames->turntable == 0)
        return lf_frames_patch(frame);
    memcpy(p, camera->position, sizeof p);
    if (frame > 1)
        lf_orbit_camera(camera, 360.0 * (frame - 1) / frames->turntable, 0, 1, p);
    return json_pack("{s:i, s:{s:[f,f,f]}}", "frame", frame, "camera", "position", p[0], p[1],
                     p[2]);
}
