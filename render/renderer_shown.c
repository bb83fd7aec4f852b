/* The reconstructed picture of a renderer's film. */
#include "render/renderer.h"

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

/* Views that are as far apart: what depends on the view is known as it changes from one to the
 * next.
 */
static bool looks_the_same(const lf_camera *a, const lf_camera *b)
{
    double wider = fabs(a->cone - b->cone);
    return a->n_views == b->n_views && a->inclusive == b->inclusive && a->track == b->track &&
           a->own_windows == b->own_windows && a->rise == b->rise &&
           a->first_view == b->first_view && a->all_views == b->all_views && wider <= 1e-9;
}

/* Whether two subjects (scene_subject.h) are of the same objects: meshes of the same names and
 * files, volumes of the same names. Where these stand, what they are made of, what lights them and
 * which moment it is may differ: what is known of one is a first guess of the other. */
static bool same_objects(const json_t *a, const json_t *b)
{
    static const char *const sections[] = {"meshes", "volumes"};
    for (int i = 0; i < 2; i++) {
        json_t *of_a = json_object_get(a, sections[i]), *of_b = json_object_get(b, sections[i]),
               *object;
        const char *name;
        if (json_object_size(of_a) != json_object_size(of_b))
            return false;
        json_object_foreach(of_a, name, object)
        {
            json_t *other = json_object_get(of_b, name);
            const json_t *file = json_object_get(object, "file"),
                         *other_file = json_object_get(other, "file");
            if (!other || (i == 0 && file != other_file && !json_equal(file, other_file)))
                return false;
        }
    }
    return true;
}

static bool shows_the_same(const lf_renderer *r, const lf_scene *scene,
                           const lf_render_settings *settings)
{
    return r->scene && settings->features &&
           looks_the_same(&settings->camera, &r->settings.camera) &&
           lf_max_depth(scene, settings->max_depth) ==
               lf_max_depth(r->scene, r->settings.max_depth) &&
           memcmp(scene->origin, r->scene->origin, sizeof scene->origin) == 0 &&
           same_objects(scene->subject, r->scene->subject);
}

/* What there is to know of the film, if there is more than of the one before it. */
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

/* ------------------------------------------------------------------------------------- fits -- */

static void follow(const lf_renderer *r, const lf_rig *rig)
{
    /* slopes are not for who stands somewhere else altogether */
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
    const lf_reconstruct_view view = {.n_views = rig.n_views,
                                      .width = rig.width,
                                      .height = rig.height,
                                      .shift = shift,
                                      .still = rig.still,
                                      .depth = rig.distance / rig.dx};
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
    const float *q = lf_film_at(film, row, 0).q;
    for (size_t i = 0; i < n && film->rows[row].provisional; i++)
        flags[i] = q[i] < 0.0f ? LF_PIXEL_UNSEEN : 0;
}

typedef struct lf_show_job {
    const lf_renderer *renderer;
    float *out;
    atomic_int failed;
} lf_show_job;

/* Rows of which nothing is known are none to show. */
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
