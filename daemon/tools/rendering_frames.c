/* Frame after frame: what is there is kept, what does not change from one to the next is shared. */
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/output/content.h"
#include "daemon/tools/rendering.h"

/* Whether all files of the frame whose name is r->path are there. */
static bool is_there(const lf_rendering *r)
{
    const lf_output_kind *kind = r->arguments->kind;
    int n = lf_output_n_files(kind, lf_camera_views(&r->settings.camera));
    bool there = true;
    for (int i = 0; i < n && there; i++) {
        char *file = lf_output_file_name(kind, r->path, i);
        there = file && access(file, F_OK) == 0;
        lf_free(file);
    }
    return there;
}

/* Takes a frame in hand; *out_kept: it is there and stays. */
static lf_status take_frame(lf_rendering *r, int frame, bool *out_kept, lf_error *err)
{
    r->sequence.frame = frame;
    lf_status status = lf_rendering_name(r, frame, err);
    *out_kept = status == LF_OK && !r->arguments->frames.overwrite && !r->video && is_there(r);
    return status;
}

/* How many frames are wanted. Hours of rendering must not end at a file that is not there. */
static lf_status count_frames(lf_rendering *r, lf_error *err)
{
    const lf_frames *frames = &r->arguments->frames;
    int n_kept = 0;
    for (int frame = frames->first; frame <= frames->last; frame++) {
        bool kept;
        lf_status status = take_frame(r, frame, &kept, err);
        if (status == LF_OK && !kept)
            status = lf_scene_check_frame(r->scene, frame, err);
        if (status != LF_OK)
            return status;
        n_kept += kept;
    }
    r->sequence.n_wanted = lf_frames_count(frames) - n_kept;
    if (n_kept > 0)
        lf_log(LF_LOG_INFO,
               "%d of %d frames were there already and stay (--overwrite renders them"
               " anew)",
               n_kept, lf_frames_count(frames));
    return LF_OK;
}

/* The scene of the frame in hand in place of the one before. camera is that of frame 1. */
static lf_status load_frame(lf_rendering *r, const lf_camera *camera, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    json_t *patch = lf_frames_patch_turned(&a->frames, camera, r->sequence.frame);
    json_t *doc = patch ? lf_json_merge_patch(lf_scene_json(r->scene), patch) : NULL;
    lf_scene *next = NULL;
    lf_status status = LF_OK;
    lf_import_watch(lf_progress_line_reading, &r->line);
    if (doc)
        status = lf_scene_from_json(doc, lf_scene_folder(r->scene), a->scene, NULL, r->scene, &next,
                                    err);
    else
        status = lf_error_set(err, LF_E_NOMEM, a->scene, "out of memory");
    lf_import_watch(NULL, NULL);
    json_decref(doc);
    json_decref(patch);
    if (status != LF_OK)
        return status;
    lf_progress_line_clear(&r->line);
    lf_log_warnings(next, r->scene);
    lf_scene_unref(r->scene);
    r->scene = next;
    return lf_rendering_resolve(r, err);
}

static lf_status make_frame(lf_rendering *r, const lf_camera *camera, lf_error *err)
{
    lf_status status = load_frame(r, camera, err);
    if (status == LF_OK)
        status = lf_rendering_check_outputs(r, err);
    if (status == LF_OK)
        status = lf_rendering_run(r, err);
    if (status == LF_OK)
        status = lf_rendering_write(r, err);
    r->sequence.n_done += status == LF_OK;
    return status;
}

lf_status lf_rendering_frames(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const lf_frames *frames = &a->frames;
    const lf_camera camera = *lf_scene_camera(r->scene);
    lf_status status = LF_OK;
    if (a->kind == &lf_output_video)
        status = lf_video_create(r->path, &r->layout, &a->video, r->cancel, &r->video, err);
    if (status == LF_OK)
        status = count_frames(r, err);
    r->sequence.begun = lf_time_now();
    for (int frame = frames->first; frame <= frames->last && status == LF_OK; frame++) {
        bool kept;
        status = take_frame(r, frame, &kept, err);
        if (status == LF_OK && !kept)
            status = make_frame(r, &camera, err);
    }
    if (status == LF_OK && r->video)
        status = lf_video_finish(r->video, err);
    return status == LF_E_CANCELLED ? lf_rendering_interrupted(r, err) : status;
}
