/* The accumulation as a file (film_file.h): saved, continued, added to another renderer's. */
#include <nettle/sha2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render/film/film_file.h"
#include "render/renderer.h"
#include "render/rows/light_paths.h"
#include "render/scene/scene.h"

static json_t *numbers(const double *x, int n)
{
    json_t *list = json_array();
    for (int i = 0; i < n; i++)
        json_array_append_new(list, json_real(x[i]));
    return list;
}

/* Everything that the image depends on, except its random numbers. */
static json_t *describe(const lf_scene *scene, const lf_render_settings *s, const char *integrator)
{
    const lf_camera *c = &s->camera;
    const double rig[] = {c->target[0],   c->target[1],     c->target[2], c->position[0],
                          c->position[1], c->position[2],   c->up[0],     c->up[1],
                          c->up[2],       c->fov_y,         c->aspect,    c->cone,
                          c->lens_radius, c->focus_distance};
    json_t *words = json_pack(
        "{s:O, s:s, s:i, s:i, s:o, s:b, s:o, s:i, s:i, s:i}", "scene", scene->subject, "integrator",
        integrator, "sampler", (int)s->sampler, "max_depth", lf_max_depth(scene, s->max_depth),
        "rig", numbers(rig, sizeof rig / sizeof rig[0]), "inclusive", c->inclusive, "window",
        numbers(s->window, 4), "n_views", c->n_views, "width", s->width, "height", s->height);
    if (c->view_blur > 0.0)
        json_object_set_new(words, "view_blur", json_real(c->view_blur));
    if (c->view_blur > 0.0 && c->rows_step > 0.0)
        json_object_set_new(words, "rows_step", json_real(c->rows_step));
    if (c->track > 0.0) {
        const double track[] = {c->track, c->own_windows, c->rise};
        json_object_set_new(words, "track", numbers(track, c->rise != 0.0 ? 3 : 2));
    }
    if (c->all_views > 0)
        json_object_set_new(words, "part", json_pack("[i, i]", c->first_view, c->all_views));
    if (c->list)
        json_object_set_new(words, "list", numbers((const double *)c->list, 10 * c->n_views));
    for (int i = 0; lf_integrator_params()[i].option; i++)
        if (s->choices.of[i])
            json_object_set_new(words, lf_integrator_params()[i].option,
                                json_integer(s->choices.of[i]));
    const lf_integrator_entry *entry = lf_integrator_named(integrator);
    if (s->light_paths != 0 && entry && entry->takes_light_paths && lf_light_paths_serve(scene, s))
        json_object_set_new(words, "light_paths", json_integer(s->light_paths));
    if (s->suffixes != 0 && entry && entry->splits && lf_splitting_serves(scene, s))
        json_object_set_new(words, "suffixes",
                            json_pack("[i, b, b]", s->suffixes, s->one_light, s->early_roulette));
    for (int i = 0; i < 2 && c->moves; i++) {
        const lf_camera_shift *t = &c->shift[i];
        const double shift[] = {t->position[0], t->position[1], t->position[2],   t->target[0],
                                t->target[1],   t->target[2],   t->focus_distance};
        json_object_set_new(words, i ? "close" : "open", numbers(shift, 7));
    }
    return words;
}

/* The hash of JSON values (NULL: out of memory). */
static lf_status hash_of(const json_t *words, size_t n, uint8_t *out)
{
    struct sha256_ctx hash;
    char *text = words ? json_dumps(words, JSON_COMPACT | JSON_SORT_KEYS) : NULL;
    if (!text)
        return LF_E_NOMEM;
    sha256_init(&hash);
    sha256_update(&hash, strlen(text), (const uint8_t *)text);
    sha256_digest(&hash, n, out);
    free(text);
    return LF_OK;
}

lf_status lf_renderer_identify(const lf_scene *scene, const lf_render_settings *settings,
                               const char *integrator, uint8_t out[LF_PICTURE_BYTES])
{
    json_t *words = describe(scene, settings, integrator);
    lf_status status = hash_of(words, LF_PICTURE_BYTES, out);
    json_decref(words);
    return status;
}

/* Everything in which a film must agree to be continued. */
static json_t *describe_film(const lf_renderer *r)
{
    char picture[2 * LF_PICTURE_BYTES + 1];
    const lf_film_layout *l = &r->film.layout;
    const float *sky = r->film.sky;
    for (int i = 0; i < LF_PICTURE_BYTES; i++)
        snprintf(picture + 2 * (size_t)i, 3, "%02x", r->film.picture[i]);
    return json_pack("{s:i, s:s, s:I, s:[f,f,f], s:[b,b,b,b,b,b,b]}", "version", LF_FILM_VERSION,
                     "picture", picture, "seed", (json_int_t)r->settings.seed, "sky",
                     (double)sky[0], (double)sky[1], (double)sky[2], "layout", l->has_w2,
                     l->has_native, l->has_known, l->has_delta, l->has_signed, l->has_features,
                     l->has_albedo);
}

lf_status lf_renderer_state_id(const lf_renderer *renderer, lf_state_id *out)
{
    const lf_render_settings *s = &renderer->settings;
    json_t *words = describe(renderer->scene, s, s->integrator),
           *camera = json_pack(
               "{s:O, s:O, s:O, s:f, s:O*, s:O*, s:O*, s:O*}", "rig", json_object_get(words, "rig"),
               "inclusive", json_object_get(words, "inclusive"), "window",
               json_object_get(words, "window"), "view_blur", s->camera.view_blur, "track",
               json_object_get(words, "track"), "list", json_object_get(words, "list"), "rows_step",
               json_object_get(words, "rows_step"), "part", json_object_get(words, "part")),
           *film = describe_film(renderer);
    *out = (lf_state_id){
        .n_views = s->camera.n_views, .width = s->width, .height = s->height, .seed = s->seed};
    lf_status status = hash_of(json_object_get(words, "scene"), LF_STATE_HASH, out->scene);
    if (status == LF_OK)
        status = hash_of(camera, LF_STATE_HASH, out->camera);
    if (status == LF_OK)
        status = hash_of(film, LF_STATE_HASH, out->whole);
    json_decref(words);
    json_decref(camera);
    json_decref(film);
    return status;
}

lf_status lf_state_look(int fd, lf_state_id *out, lf_error *err)
{
    lf_film_layout layout;
    uint64_t seed;
    lf_status status = lf_film_look(fd, &layout, &seed, err);
    if (status == LF_OK)
        *out = (lf_state_id){.n_views = layout.n_views,
                             .width = layout.width,
                             .height = layout.height,
                             .seed = seed};
    return status;
}

lf_status lf_state_rows(int fd, int *out_rows, lf_error *err)
{
    return lf_film_count_rows(fd, out_rows, err);
}

bool lf_same_picture(const lf_scene *a, const lf_render_settings *of_a, const lf_scene *b,
                     const lf_render_settings *of_b)
{
    uint8_t pictures[2][LF_PICTURE_BYTES];
    return lf_renderer_identify(a, of_a, of_a->integrator ? of_a->integrator : "", pictures[0]) ==
               LF_OK &&
           lf_renderer_identify(b, of_b, of_b->integrator ? of_b->integrator : "", pictures[1]) ==
               LF_OK &&
           memcmp(pictures[0], pictures[1], LF_PICTURE_BYTES) == 0;
}

lf_status lf_picture_hash(const lf_scene *scene, const lf_render_settings *settings,
                          char out[static LF_PICTURE_HASH])
{
    uint8_t picture[LF_PICTURE_BYTES];
    const lf_status status = lf_renderer_identify(
        scene, settings, settings->integrator ? settings->integrator : "", picture);
    for (size_t i = 0; i < LF_PICTURE_BYTES && status == LF_OK; i++)
        snprintf(out + 2 * i, 3, "%02x", picture[i]);
    return status;
}

lf_status lf_renderer_save(const lf_renderer *renderer, lf_outfile *file, const lf_cancel *cancel,
                           lf_error *err)
{
    return lf_film_write(&renderer->film, file, cancel, err);
}

lf_status lf_renderer_restore(lf_renderer *renderer, int fd, lf_error *err)
{
    lf_film restored = {0};
    lf_status status = lf_film_read(fd, &renderer->film, &restored, err);
    if (status != LF_OK)
        return status;
    lf_film_finish(&renderer->film);
    renderer->film = restored;
    return LF_OK;
}

lf_status lf_renderer_mix(lf_renderer *renderer, const lf_renderer *from, lf_error *err)
{
    return lf_film_mix(&renderer->film, &from->film, err);
}
