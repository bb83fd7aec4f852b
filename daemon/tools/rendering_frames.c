/* Renders frames in order: keeps frames whose files exist, and shares data that does not change
 * between frames. */
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/output/content.h"
#include "daemon/tools/rendering_plate.h"
#include "daemon/tools/rendering_shared.h"

/* True if all files of the frame named r->path exist. */
static bool is_there(const lf_rendering *r)
{
    if (r->sequence.plate)
        return lf_rendering_plate_has(r, r->sequence.frame);
    const lf_output_kind *kind = lf_rendering_kind(r);
    const int views = r->is_quilt ? r->layout.n_views : lf_camera_views(&r->settings.camera),
              n = lf_output_n_files(kind, &r->print, views);
    bool there = true;
    for (int i = 0; i < n && there; i++) {
        char *file = lf_output_file_name(kind, r->path, i);
        there = file && access(file, F_OK) == 0;
        lf_free(file);
    }
    return there;
}

/* Makes a frame the current one; *out_kept: its files exist and stay. */
static lf_status take_frame(lf_rendering *r, int frame, bool *out_kept, lf_error *err)
{
    r->sequence.frame = frame;
    lf_status status = lf_rendering_name(r, frame, err);
    *out_kept = status == LF_OK && !r->arguments->frames.overwrite &&
                r->arguments->kind != &lf_output_video && !lf_state_is_all(&r->arguments->state) &&
                is_there(r);
    return status;
}

/* Checks the files of a frame. */
static lf_status check_frame(const lf_rendering *r, int frame, lf_error *err)
{
    if (lf_rendering_of_pictures(r))
        return lf_rendering_check_picture(r, frame, err);
    return r->arguments->frames.of_rows ? LF_OK : lf_scene_check_frame(r->scene, frame, err);
}

/* Counts and marks the frames to render: out_wanted[frame - first]. Also checks their files, so
 * that hours of rendering do not end at a missing file. */
static lf_status count_frames(lf_rendering *r, bool *out_wanted, lf_error *err)
{
    const lf_frames *frames = &r->arguments->frames;
    int n_kept = 0;
    for (int frame = frames->first; frame <= frames->last; frame++) {
        bool kept;
        lf_status status = take_frame(r, frame, &kept, err);
        if (status == LF_OK && !kept && check_frame(r, frame, err) != LF_OK)
            status = lf_rendering_tell_frame(frame, frames->first, err);
        if (status == LF_OK && kept)
            status = lf_rendering_check_kept(r, err);
        if (status != LF_OK)
            return status;
        n_kept += kept;
        out_wanted[frame - frames->first] = !kept;
    }
    r->sequence.n_wanted = lf_frames_count(frames) - n_kept;
    if (n_kept > 0)
        lf_log(LF_LOG_INFO, "%d of %d %s exist and are kept; use --overwrite to render them again",
               n_kept, lf_frames_count(frames), lf_frames_noun(frames));
    return LF_OK;
}

lf_status lf_rendering_check_all_kept(lf_rendering *r, lf_error *err)
{
    const lf_frames *frames = &r->arguments->frames;
    const int current = r->sequence.frame;
    bool kept;
    lf_status status = LF_OK;
    if (!r->sequence.on || r->sequence.plate)
        return LF_OK;
    for (int frame = frames->first; frame <= frames->last && status == LF_OK; frame++) {
        status = take_frame(r, frame, &kept, err);
        if (kept && status == LF_OK)
            status = lf_rendering_check_kept(r, err);
    }
    return status == LF_OK ? take_frame(r, current, &kept, err) : status;
}

lf_status lf_rendering_patched(lf_rendering *r, const json_t *patch, const lf_scene *previous,
                               lf_scene **out, lf_error *err)
{
    const char *name = r->arguments->scene;
    json_t *doc = patch ? lf_json_merge_patch(lf_scene_json(r->scene), patch) : NULL;
    lf_status status = LF_OK;
    lf_import_watch(lf_progress_line_reading, &r->line);
    if (doc)
        status = lf_scene_from_json(doc, lf_scene_folder(r->scene), name, NULL, previous, out, err);
    else
        status = lf_error_set(err, LF_E_NOMEM, name, "out of memory");
    lf_import_watch(NULL, NULL);
    json_decref(doc);
    if (status == LF_OK)
        lf_progress_line_clear(&r->line);
    return status;
}

/* Loads the scene of the current frame in place of the previous one. camera: of frame 1. */
static lf_status load_frame(lf_rendering *r, const lf_camera *camera, lf_error *err)
{
    json_t *patch = lf_frames_patch_turned(&r->arguments->frames, camera, r->sequence.frame);
    lf_scene *next = NULL;
    lf_status status = lf_rendering_patched(r, patch, r->scene, &next, err);
    json_decref(patch);
    if (status != LF_OK)
        return status;
    lf_log_warnings(next, r->scene);
    lf_scene_unref(r->scene);
    r->scene = next;
    return lf_rendering_resolve(r, err);
}

/* Writes a frame of finished pictures. */
static lf_status take_picture(lf_rendering *r, lf_error *err)
{
    lf_rendering_show_frame(r, 0);
    lf_status status = lf_rendering_take_picture(r, err);
    if (status == LF_OK)
        status = lf_rendering_check_outputs(r, err);
    if (status == LF_OK)
        status = lf_rendering_write(r, err);
    r->sequence.n_done += status == LF_OK;
    return status;
}

/* Whether a state of the current frame is there, of any job. */
static bool has_state(const lf_rendering *r)
{
    bool has = false;
    for (int row = 0; row < lf_rendering_camera_rows(r) && !has; row++) {
        char *path = lf_rendering_state_current(r, row);
        has = path && access(path, F_OK) == 0;
        lf_free(path);
    }
    return has;
}

/* An earlier run may have ended before it removed the states of the current frame, whose files are
 * there. They may be of another job. */
static void remove_kept(lf_rendering *r, const lf_camera *camera)
{
    lf_error err = {0};
    if (!has_state(r))
        return;
    lf_status status =
        r->arguments->frames.of_rows ? lf_rendering_resolve(r, &err) : load_frame(r, camera, &err);
    if (status == LF_OK)
        status = lf_rendering_state_remove_kept(r, &err);
    if (status != LF_OK)
        lf_rendering_state_stays(r, r->arguments->state.file, &err);
}

/* Removes the states of the current frame, whose files are there: written by this run, or kept. */
static void remove_states(lf_rendering *r, lf_shared_frames *shared, const lf_camera *camera,
                          bool kept)
{
    const lf_state_arguments *state = &r->arguments->state;
    if (!state->file || r->video || lf_state_is_all(state))
        return;
    if (shared)
        lf_shared_frames_remove_states(shared, r, kept);
    else if (kept)
        remove_kept(r, camera);
    else
        lf_rendering_state_remove(r);
}

static lf_status make_frame(lf_rendering *r, lf_shared_frames *shared, const lf_camera *camera,
                            lf_error *err)
{
    lf_status status = shared                         ? lf_shared_frames_take(shared, r, err)
                       : r->arguments->frames.of_rows ? lf_rendering_resolve(r, err)
                                                      : load_frame(r, camera, err);
    if (status == LF_OK)
        status = lf_rendering_check_outputs(r, err);
    if (status == LF_OK)
        status = lf_rendering_run(r, err);
    if (status == LF_OK && !lf_state_is_all(&r->arguments->state))
        status = lf_rendering_write(r, err);
    r->sequence.n_done += status == LF_OK;
    return status;
}

/* Parts of shutters have no rows or streams of their own. A part that continues would forget how
 * many passes the first part had time for. */
static lf_status check_shared(const lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    int a_frame;
    if (!a->state.file || lf_rendering_of_pictures(r) || lf_shared_parts(r, &a_frame) == 0)
        return LF_OK;
    if (lf_state_is_all(&a->state))
        return lf_error_set(err, LF_E_ARG, a->state.has_rows ? "--rows" : "--stream",
                            "cannot be combined with shutters that frames share; render whole "
                            "frames");
    return a->budget.seconds > 0
               ? lf_error_set(err, LF_E_ARG, "--time",
                              "cannot be combined with --state if frames share parts of their "
                              "shutters; give --spp or --passes")
               : LF_OK;
}

/* Renders all wanted frames. */
static lf_status make_frames(lf_rendering *r, const bool *wanted, lf_error *err)
{
    const lf_frames *frames = &r->arguments->frames;
    const bool of_pictures = lf_rendering_of_pictures(r);
    lf_camera camera = {0};
    lf_shared_frames *shared = NULL;
    lf_status status = LF_OK;
    if (!of_pictures) {
        camera = *lf_scene_camera(r->scene);
        status = lf_shared_frames_create(r, wanted, &shared, err);
    }
    r->sequence.begun = lf_time_now();
    for (int frame = frames->first; frame <= frames->last && status == LF_OK; frame++) {
        bool kept;
        status = take_frame(r, frame, &kept, err);
        const bool is_made = !kept && wanted[frame - frames->first];
        if (status == LF_OK && is_made)
            status = of_pictures ? take_picture(r, err) : make_frame(r, shared, &camera, err);
        if (status == LF_OK && (kept || is_made))
            remove_states(r, shared, &camera, kept);
    }
    r->gathered = NULL;
    lf_shared_frames_destroy(shared);
    return status;
}

lf_status lf_rendering_frames(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const lf_video_options options = lf_rendering_video_options(r);
    bool *wanted = lf_calloc((size_t)lf_frames_count(&a->frames), sizeof *wanted);
    lf_status status = wanted ? LF_OK : lf_error_set(err, LF_E_NOMEM, a->scene, "out of memory");
    if (status == LF_OK)
        status = check_shared(r, err);
    if (status == LF_OK)
        status = count_frames(r, wanted, err);
    if (status == LF_OK && a->kind == &lf_output_video && !lf_state_is_all(&a->state))
        status = lf_video_create(r->path, &r->layout, &options, r->cancel, &r->video, err);
    if (status == LF_OK)
        status = make_frames(r, wanted, err);
    if (status == LF_OK && r->video)
        status = lf_video_finish(r->video, err);
    if (status == LF_OK)
        status = lf_rendering_plate_finish(r, err);
    lf_free(wanted);
    return status == LF_E_CANCELLED ? lf_rendering_interrupted(r, err) : status;
}
