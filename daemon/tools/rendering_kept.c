/* Compares frames that exist with what this job renders. */
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/tools/rendering.h"

static json_t *budget_words(const lf_budget *budget)
{
    const struct {
        const char *key;
        double value;
    } all[] = {{"passes", (double)budget->passes},
               {"seconds", budget->seconds},
               {"target_error", budget->target_error},
               {"target_denoised_error", budget->target_denoised_error}};
    char text[64];
    size_t i = 0;
    while (i < sizeof all / sizeof *all - 1 && !(all[i].value > 0))
        i++;
    snprintf(text, sizeof text, "%s %.9g", all[i].key, all[i].value);
    return json_string(text);
}

/* Whether the exposure differs from frame to frame. */
static bool has_exposure_keys(const lf_rendering *r)
{
    const json_t *film = json_object_get(lf_scene_json(r->scene), "film");
    return !r->arguments->options.has_exposure && json_is_object(json_object_get(film, "exposure"));
}

void lf_rendering_note_made(const lf_rendering *r, json_t *made)
{
    const lf_budget budget = lf_rendering_budget(r);
    json_object_set_new(made, "budget", budget_words(&budget));
    if (has_exposure_keys(r))
        json_object_set_new(made, "exposure_keys", json_true());
}

/* The settings of the current frame before it is rendered. NULL = out of memory. */
static json_t *settings_of(const lf_rendering *r)
{
    const lf_options *o = &r->arguments->options;
    lf_film_settings film = *lf_scene_film_settings(r->scene);
    if (o->has_exposure)
        film = lf_exposed_film(&film, o->exposure);
    json_t *made = lf_output_settings(r->arguments->scene, &r->settings, NULL, o->estimator,
                                      r->reconstructs, -1, &film);
    if (made)
        lf_rendering_note_made(r, made);
    return made;
}

lf_status lf_rendering_check_kept(const lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    char words[3 * LF_PNG_TEXT];
    lf_made_with is, expected;
    if (a->frames.mixed || r->sequence.plate || lf_rendering_of_pictures(r))
        return LF_OK;
    char *file = lf_output_file_name(lf_rendering_kind(r), r->path, 0);
    json_t *settings = file ? settings_of(r) : NULL;
    lf_status status = settings ? LF_OK : lf_error_set(err, LF_E_NOMEM, a->out, "out of memory");
    if (status == LF_OK) {
        lf_made_with_read(file, &is);
        lf_made_with_settings(settings, &expected);
        if (lf_made_with_differs(&is, &expected, words, sizeof words))
            status =
                lf_error_set(err, LF_E_STATE, file,
                             "exists and was rendered with %s; %s, or keep it with --mixed", words,
                             a->state.file || a->plan.on ? "remove it" : "use --overwrite");
    }
    json_decref(settings);
    lf_free(file);
    return status;
}
