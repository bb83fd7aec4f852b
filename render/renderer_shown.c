/* The denoised image of a renderer's film. */
#include "render/renderer.h"
#include "render/transport/path/sunlight.h"

#include <math.h>
#include <string.h>

/* ------------------------------------------------------------------------------------- pasts -- */

static void forget(lf_known_past *known)
{
    lf_past_destroy(known->past);
    known->past = NULL;
}

static void take(lf_known_past *to, lf_known_past *from)
{
    forget(to);
    *to = *from;
    from->past = NULL;
}

void lf_renderer_drop_fits(lf_renderer *renderer)
{
    lf_reconstruct_destroy(renderer->shown);
    renderer->shown = NULL;
    forget(&renderer->before);
    forget(&renderer->spare);
}

/* Whether the views are equally far apart: the model of view dependence is a function of the view's
 * position. */
static bool looks_the_same(const lf_camera *a, const lf_camera *b)
{
    double wider = fabs(a->cone - b->cone);
    return a->n_views == b->n_views && a->inclusive == b->inclusive && a->track == b->track &&
           a->own_windows == b->own_windows && a->rise == b->rise &&
           a->first_view == b->first_view && a->all_views == b->all_views && wider <= 1e-9;
}

/* Whether two objects are equal except for position and animation time and, for volumes, file: a
 * sequence has one file per frame. The samples outvote a guess that does not fit another file. */
static bool same_object(json_t *a, json_t *b, bool is_volume)
{
    static const char *const moves[] = {"transform", "animation", "shutter", "flows", "file"};
    const int n = is_volume ? 5 : 4;
    json_t *rest[2] = {json_copy(a), json_copy(b)};
    for (int i = 0; i < 2 * n; i++)
        json_object_del(rest[i / n], moves[i % n]);
    const bool same = rest[0] && rest[1] && json_equal(rest[0], rest[1]);
    json_decref(rest[0]);
    json_decref(rest[1]);
    return same;
}

/* same_object for all objects of a section. */
static bool same_objects(json_t *a, json_t *b, bool are_volumes)
{
    json_t *object;
    const char *name;
    bool same = json_object_size(a) == json_object_size(b);
    json_object_foreach(a, name, object)
    {
        json_t *other = json_object_get(b, name);
        same = same && other && same_object(object, other, are_volumes);
    }
    return same;
}

/* Whether two subjects (scene_subject.h) have the same objects, lights and materials, so that the
 * fit of one is a first guess for the other. Other lights or materials change all of it. */
static bool same_subject(json_t *a, json_t *b)
{
    static const char *const moving[] = {"meshes", "volumes"};
    json_t *rest[2] = {json_copy(a), json_copy(b)};
    bool same = rest[0] && rest[1];
    for (int i = 0; i < 2; i++) {
        same = same &&
               same_objects(json_object_get(a, moving[i]), json_object_get(b, moving[i]), i == 1);
        for (int k = 0; k < 2; k++)
            json_object_del(rest[k], moving[i]);
    }
    same = same && json_equal(rest[0], rest[1]);
    json_decref(rest[0]);
    json_decref(rest[1]);
    return same;
}

static bool shows_the_same(const lf_renderer *r, const lf_scene *scene,
                           const lf_render_settings *settings)
{
    return r->scene && settings->features &&
           looks_the_same(&settings->camera, &r->settings.camera) &&
           lf_max_depth(scene, settings->max_depth) ==
               lf_max_depth(r->scene, r->settings.max_depth) &&
           memcmp(scene->origin, r->scene->origin, sizeof scene->origin) == 0 &&
           same_subject(scene->subject, r->scene->subject);
}

/* Keeps the film's fit, if it has more information than the previous one. */
static void remember(lf_renderer *r)
{
    lf_known_past known = {.past = r->shown ? lf_past_of(r->shown) : NULL};
    if (known.past && lf_rig_init(&known.rig, &r->settings, r->scene->origin, NULL) == LF_OK)
        take(&r->spare, &known);
    forget(&known);
}

void lf_renderer_retire_fit(lf_renderer *renderer, const lf_scene *scene,
                            const lf_render_settings *settings)
{
    if (!shows_the_same(renderer, scene, settings)) {
        lf_renderer_drop_fits(renderer);
        return;
    }
    remember(renderer);
    if (renderer->spare.past)
        take(&renderer->before, &renderer->spare);
    lf_reconstruct_destroy(renderer->shown);
    renderer->shown = NULL;
}

/* -------------------------------------------------------------------------------------- fits -- */

static void follow(const lf_renderer *r, const lf_rig *rig)
{
    /* slopes are not valid for a camera in a completely different position */
    float view = lf_rig_view_between(rig, &r->before.rig);
    lf_past_move move = {.view = fminf(1.0f, fmaxf(-1.0f, view))};
    lf_rig_map_between(rig, &r->before.rig, move.map);
    lf_reconstruct_follow(r->shown, r->before.past, &move);
}

static lf_status create(lf_renderer *renderer)
{
    lf_rig rig;
    float shift[LF_MAX_VIEWS];
    lf_status status = lf_rig_init(&rig, &renderer->settings, renderer->scene->origin, NULL);
    if (status != LF_OK)
        return status;
    for (int k = 0; k < rig.n_views; k++)
        shift[k] = rig.b[k] / rig.dx;
    const bool albedo = renderer->film.layout.has_albedo;
    const lf_reconstruct_view view = {.n_views = rig.n_views,
                                      .width = rig.width,
                                      .height = rig.height,
                                      .shift = shift,
                                      .still = rig.still,
                                      .depth = rig.distance / rig.dx,
                                      .albedo = albedo,
                                      .white = albedo ? lf_sunlight_mean(renderer->scene) : 0.0f};
    status = lf_reconstruct_create(&view, renderer->pool, &renderer->shown);
    if (status == LF_OK && renderer->before.past)
        follow(renderer, &rig);
    return status;
}

static bool is_whole(const lf_film *film)
{
    for (int row = 0; row < film->height; row++)
        if (!lf_film_visited(film->rows[row].visits))
            return false;
    return true;
}

bool lf_renderer_follows(const lf_renderer *renderer)
{
    return renderer->before.past;
}

lf_status lf_renderer_fit(lf_renderer *renderer, const lf_cancel *cancel)
{
    if (!renderer->film.layout.has_features)
        return LF_E_STATE;
    lf_status status = renderer->shown ? LF_OK : create(renderer);
    if (status != LF_OK)
        return status;
    const bool whole = is_whole(&renderer->film);
    if (whole)
        lf_reconstruct_follow(renderer->shown, NULL, NULL);
    if (cancel)
        remember(renderer);
    status = lf_reconstruct_fit(renderer->shown, &renderer->film, cancel);
    if (status == LF_OK) {
        forget(&renderer->spare);
        if (whole)
            forget(&renderer->before);
    }
    return status;
}

lf_status lf_renderer_show_row(const lf_renderer *renderer, int row, float *out)
{
    return renderer->shown ? lf_reconstruct_row(renderer->shown, &renderer->film, row, out)
                           : LF_E_STATE;
}

void lf_renderer_show_flags(const lf_renderer *renderer, int row, uint8_t *flags)
{
    const lf_film *film = &renderer->film;
    const size_t n = (size_t)film->n_views * (size_t)film->width;
    memset(flags, lf_film_is_known(&film->rows[row]) ? 0 : LF_PIXEL_UNSEEN, n);
    if (!film->rows[row].provisional)
        return;
    lf_film_open(film, row);
    const float *q = lf_film_at(film, row, 0).q;
    for (size_t i = 0; i < n; i++)
        flags[i] = q[i] < 0.0f ? LF_PIXEL_UNSEEN : 0;
    lf_film_close(film, row, false);
}

typedef struct lf_show_job {
    const lf_renderer *renderer;
    float *out;
    atomic_int failed;
} lf_show_job;

/* Rows without data have nothing to show. */
static void show_item(void *context, int row, int worker)
{
    lf_show_job *job = context;
    size_t pixels = (size_t)job->renderer->film.n_views * (size_t)job->renderer->film.width;
    (void)worker;
    if (lf_renderer_show_row(job->renderer, row, job->out + 3 * pixels * (size_t)row) == LF_E_NOMEM)
        atomic_store_explicit(&job->failed, 1, memory_order_relaxed);
}

lf_status lf_renderer_show(lf_renderer *renderer, float *out, const lf_cancel *cancel)
{
    lf_show_job job = {.renderer = renderer};
    job.out = out;
    lf_status status = lf_renderer_fit(renderer, cancel);
    if (status == LF_OK)
        status = lf_pool_run(renderer->pool, renderer->film.height, show_item, &job, cancel);
    return atomic_load_explicit(&job.failed, memory_order_relaxed) ? LF_E_NOMEM : status;
}
