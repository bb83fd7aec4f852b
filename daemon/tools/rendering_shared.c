#include "daemon/tools/rendering_shared.h"

#include <assert.h>
#include <math.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/output/content.h"

/* A frame of which some parts have been rendered. */
typedef struct open_frame {
    int frame;
    bool is_open, alone; /* alone: its parts cannot be combined */
    lf_scene *scene;
    lf_renderer *renderer; /* may be reused from an earlier frame */
    lf_render_settings settings;
    lf_render_times times;
} open_frame;

struct lf_shared_frames {
    int n_parts, a_frame;
    double shutter_open;
    const bool *wanted;
    int64_t passes;        /* passes per part; 0: not known yet */
    int64_t next;          /* next part to render: part p begins p / a_frame frames after the
                            * first */
    lf_scene *scene;       /* scene of the last part */
    lf_renderer *renderer; /* renderer of all parts */
    int n_open;            /* most frames that contain a part */
    open_frame *open;      /* [n_open], indexed by frame number */
};

int lf_shared_parts(const lf_rendering *r, int *out_a_frame)
{
    const lf_render_arguments *a = r->arguments;
    const lf_camera *camera = &r->settings.camera;
    const bool by_error = a->budget.target_error > 0 || a->budget.target_denoised_error > 0;
    if (!r->sequence.on || a->frames.turntable > 0 || a->frames.of_rows || camera->n_rows > 0 ||
        by_error || a->options.layers || a->options.guides || lf_scene_has_catchers(r->scene))
        return 0;
    return lf_frames_parts(camera->shutter, out_a_frame);
}

/* The most frames that contain a part. */
static int most_open(int n_parts, int a_frame)
{
    return (n_parts - 1) / a_frame + 1;
}

int lf_shared_renderers(int n_parts, int a_frame)
{
    return most_open(n_parts, a_frame) + 2; /* one for parts, and one for the frame being written */
}

lf_status lf_shared_frames_create(const lf_rendering *r, const bool *wanted, lf_shared_frames **out,
                                  lf_error *err)
{
    int a_frame;
    const int n_parts = lf_shared_parts(r, &a_frame);
    *out = NULL;
    if (n_parts == 0)
        return LF_OK;
    lf_shared_frames *s = lf_calloc(1, sizeof *s);
    if (s) {
        *s = (lf_shared_frames){.n_parts = n_parts,
                                .a_frame = a_frame,
                                .shutter_open = r->settings.camera.shutter_open,
                                .wanted = wanted,
                                .next = INT64_MIN,
                                .n_open = most_open(n_parts, a_frame)};
        s->open = lf_calloc((size_t)s->n_open, sizeof *s->open);
    }
    if (!s || !s->open) {
        lf_shared_frames_destroy(s);
        return lf_error_set(err, LF_E_NOMEM, r->arguments->scene, "out of memory");
    }
    *out = s;
    return LF_OK;
}

void lf_shared_frames_destroy(lf_shared_frames *shared)
{
    for (int i = 0; shared && shared->open && i < shared->n_open; i++) {
        lf_renderer_destroy(shared->open[i].renderer);
        lf_scene_unref(shared->open[i].scene);
    }
    if (shared) {
        lf_renderer_destroy(shared->renderer);
        lf_scene_unref(shared->scene);
        lf_free(shared->open);
    }
    lf_free(shared);
}

/* ------------------------------------------------------------------------------------- parts -- */

/* Resolves the options for another scene's camera. Films store known light, since some parts might
 * need it and others not. */
static lf_status resolve(lf_rendering *r, lf_scene *scene, lf_render_settings *out, lf_error *err)
{
    lf_scene *const before = r->scene;
    r->scene = scene;
    const lf_status status = lf_rendering_resolve(r, err);
    r->scene = before;
    *out = r->settings;
    out->skip &= ~(unsigned)LF_SKIP_KNOWN_LIGHT;
    return status;
}

/* The frame that a part takes its static data from: the one nearest to `middle` whose files
 * exist. */
static int frame_of(const lf_rendering *r, double middle)
{
    const int nearest = (int)floor(middle + 0.5);
    for (int far = 0; far <= 2 * LF_MAX_SHUTTER; far++)
        for (int sign = 1; sign >= -1; sign -= 2) {
            const int frame = nearest + sign * far;
            if (frame >= 0 && lf_scene_check_frame(r->scene, frame, NULL) == LF_OK)
                return frame;
        }
    return nearest > 0 ? nearest : 0;
}

/* Creates the scene of a part and its empty renderer. */
static lf_status begin_part(lf_shared_frames *s, lf_rendering *r, int64_t part, lf_error *err)
{
    const double length = 1.0 / s->a_frame, opens = s->shutter_open + (double)part * length;
    const int frame = frame_of(r, opens + 0.5 * length);
    json_t *patch = json_pack("{s:i, s:{s:f, s:f}}", "frame", frame, "camera", "shutter", length,
                              "shutter_open", opens - frame);
    lf_scene *scene = NULL;
    lf_render_settings settings;
    lf_status status = lf_rendering_patched(r, patch, s->scene ? s->scene : r->scene, &scene, err);
    json_decref(patch);
    if (status != LF_OK)
        return status;
    lf_scene_unref(s->scene);
    s->scene = scene;
    status = resolve(r, scene, &settings, err);
    settings.seed = lf_parts_seed(r->arguments->options.seed, part);
    if (status != LF_OK)
        return status;
    return s->renderer ? lf_renderer_restart(s->renderer, scene, &settings, err)
                       : lf_renderer_create(scene, &settings, r->pool, &s->renderer, err);
}

lf_budget lf_shared_budget(const lf_rendering *r, int n_parts)
{
    lf_budget budget = lf_rendering_budget(r);
    budget.passes = (budget.passes + 2 * n_parts - 1) / (2 * n_parts) * 2;
    budget.seconds /= n_parts;
    budget.cpu_seconds /= n_parts;
    return budget;
}

/* Parts have equal shares of a frame: with a time budget, all get as many passes as the first
 * needed. */
static lf_budget budget_of(const lf_shared_frames *s, const lf_rendering *r)
{
    const lf_budget timed = lf_shared_budget(r, s->n_parts);
    return s->passes > 0 ? (lf_budget){.passes = s->passes, .reconstructed = timed.reconstructed}
                         : timed;
}

/* ------------------------------------------------------------------------------------ frames -- */

/* The entry of a wanted frame, with its scene and an empty renderer. */
static lf_status open_of(lf_shared_frames *s, lf_rendering *r, int frame, open_frame **out,
                         lf_error *err)
{
    open_frame *f = &s->open[frame % s->n_open];
    *out = f;
    if (f->is_open && f->frame == frame)
        return LF_OK;
    json_t *patch = lf_frames_patch(frame);
    lf_scene *scene = NULL;
    lf_status status = lf_rendering_patched(r, patch, f->scene ? f->scene : r->scene, &scene, err);
    json_decref(patch);
    if (status != LF_OK)
        return status;
    lf_log_warnings(scene, r->scene);
    lf_scene_unref(f->scene);
    f->scene = scene;
    status = resolve(r, scene, &f->settings, err);
    f->settings.seed = lf_frames_seed(r->arguments->options.seed, frame);
    if (status == LF_OK)
        status = f->renderer ? lf_renderer_restart(f->renderer, scene, &f->settings, err)
                             : lf_renderer_create(scene, &f->settings, r->pool, &f->renderer, err);
    f->frame = frame;
    f->times = (lf_render_times){0};
    f->is_open = status == LF_OK;
    f->alone = false;
    return status;
}

/* Adds the current part's film to a frame that contains it. */
static lf_status give(lf_shared_frames *s, lf_rendering *r, int frame, const lf_render_times *times,
                      lf_error *err)
{
    open_frame *f;
    lf_status status = open_of(s, r, frame, &f, err);
    if (status != LF_OK || f->alone)
        return status;
    status = lf_renderer_mix(f->renderer, s->renderer, err);
    f->alone = status == LF_E_STATE;
    f->times.passes += times->passes;
    f->times.seconds += times->seconds;
    f->times.cpu_seconds += times->cpu_seconds;
    if (!f->alone)
        return status;
    lf_progress_line_clear(&r->line);
    lf_log(LF_LOG_WARNING,
           "frame %d: the kind of its objects changes while the shutter is open, so it is rendered "
           "alone and shares no samples",
           frame);
    return LF_OK;
}

/* Adds it to all frames that contain it, from the current one on. */
static lf_status share(lf_shared_frames *s, lf_rendering *r, int64_t part,
                       const lf_render_times *times, lf_error *err)
{
    const lf_frames *frames = &r->arguments->frames;
    lf_status status = LF_OK;
    for (int frame = r->sequence.frame; frame <= frames->last && status == LF_OK; frame++) {
        const int64_t first = (int64_t)frame * s->a_frame;
        if (first > part)
            break;
        if (part < first + s->n_parts && s->wanted[frame - frames->first])
            status = give(s, r, frame, times, err);
    }
    return status;
}

/* The current part of the current frame, for progress. */
typedef struct progress_of {
    lf_rendering *rendering;
    int64_t part;
    int n_parts;
} progress_of;

static void show_part(void *context, const lf_render_progress *progress)
{
    const progress_of *of = context;
    lf_rendering_state_look(of->rendering, progress);
    lf_rendering_show_frame(of->rendering, ((double)of->part + progress->fraction) / of->n_parts);
}

static lf_status spend(lf_shared_frames *s, lf_rendering *r, int64_t part, const lf_budget *budget,
                       progress_of *of, lf_render_times *out_times, lf_error *err)
{
    const lf_saved_field field = {s->renderer, (int)(part / s->a_frame), (int)(part % s->a_frame),
                                  show_part, of};
    if (r->arguments->state.file) {
        const lf_status status = lf_rendering_state_spend(r, &field, budget, NULL, err);
        *out_times = r->state.times;
        return status;
    }
    const lf_status status = lf_render_spend(s->renderer, budget, r->arguments->options.estimator,
                                             NULL, show_part, of, r->cancel, out_times);
    return status == LF_OK ? LF_OK
                           : lf_error_set(err, status, r->arguments->out, "rendering failed");
}

static lf_status render_part(lf_shared_frames *s, lf_rendering *r, int64_t part, lf_error *err)
{
    const lf_budget budget = budget_of(s, r);
    progress_of of = {r, part - (int64_t)r->sequence.frame * s->a_frame, s->n_parts};
    lf_render_times times;
    lf_status status = begin_part(s, r, part, err);
    if (status != LF_OK)
        return status;
    status = spend(s, r, part, &budget, &of, &times, err);
    if (status != LF_OK)
        return status;
    s->passes = times.passes;
    return share(s, r, part, &times, err);
}

/* The first wanted frame after the current one, or one far behind it. */
static int next_wanted(const lf_shared_frames *s, const lf_rendering *r)
{
    const lf_frames *frames = &r->arguments->frames;
    int frame = r->sequence.frame + 1;
    while (frame <= frames->last && !s->wanted[frame - frames->first])
        frame++;
    return frame <= frames->last ? frame : frame + s->n_parts;
}

/* A part of kept frames. */
static void remove_kept(lf_shared_frames *s, lf_rendering *r, int64_t part)
{
    const int frame = (int)(part / s->a_frame), number = (int)(part % s->a_frame);
    char *path = lf_rendering_state_path(r, frame, -1, number);
    lf_error err = {0};
    if (path && access(path, F_OK) == 0) {
        if (begin_part(s, r, part, &err) == LF_OK) {
            const lf_saved_field field = {s->renderer, frame, number, NULL, NULL};
            const lf_budget budget = budget_of(s, r);
            lf_rendering_state_remove_known(r, &field, &budget);
        } else {
            lf_rendering_state_stays(r, path, &err);
        }
    }
    lf_free(path);
}

void lf_shared_frames_remove_states(lf_shared_frames *shared, lf_rendering *r, bool kept)
{
    const int64_t first = (int64_t)r->sequence.frame * shared->a_frame,
                  next = (int64_t)next_wanted(shared, r) * shared->a_frame;
    for (int64_t part = first; part < first + shared->n_parts && part < next; part++)
        if (kept)
            remove_kept(shared, r, part);
        else
            lf_rendering_state_remove_at(r, (int)(part / shared->a_frame), -1,
                                         (int)(part % shared->a_frame));
}

lf_status lf_shared_frames_take(lf_shared_frames *shared, lf_rendering *r, lf_error *err)
{
    lf_shared_frames *s = shared;
    const int64_t first = (int64_t)r->sequence.frame * s->a_frame, end = first + s->n_parts;
    lf_status status = LF_OK;
    for (s->next = s->next > first ? s->next : first; s->next < end && status == LF_OK; s->next++)
        status = render_part(s, r, s->next, err);
    if (status != LF_OK)
        return status;
    open_frame *f = &s->open[r->sequence.frame % s->n_open];
    assert(f->is_open && f->frame == r->sequence.frame);
    lf_scene *const scene = r->scene;
    lf_renderer *const renderer = r->renderer;
    r->scene = f->scene;
    r->renderer = f->renderer;
    r->settings = f->settings;
    r->gathered = f->alone ? NULL : &f->times;
    f->scene = scene;
    f->renderer = renderer;
    f->is_open = false;
    return LF_OK;
}
