#include "render/integrator.h"

#include <stdio.h>
#include <string.h>

#include "render/cameras/any_cameras.h"
#include "render/rows/rows.h"

static const lf_integrator *const none[] = {NULL};
static const lf_param no_params[] = {{0}};
static const lf_integrator *const *added = none;
static const lf_param *added_params = no_params;

void lf_integrators_add(const lf_integrator *const *list, const lf_param *params)
{
    added = list;
    added_params = params;
}

const lf_param *lf_integrator_params(void)
{
    return added_params;
}

const char *lf_integrator_reference(int index)
{
    static const char *const names[] = {"mvpt2022", "mismvpt", "amvpt2022", "amv2019",
                                        "amv2019k", "restir",  "mvrestir"};
    return index < (int)(sizeof names / sizeof names[0]) ? names[index] : NULL;
}

const lf_param *lf_choices_unfit(const lf_choices *choices, const lf_integrator_entry *entry)
{
    for (int i = 0; added_params[i].option; i++)
        if ((choices->given[i] || choices->of[i]) && !(entry->takes & 1u << i))
            return &added_params[i];
    return NULL;
}

void lf_choices_fit(lf_choices *choices, const lf_integrator_entry *entry)
{
    for (int i = 0; i < LF_MAX_CHOICES; i++)
        if (!(entry->takes & 1u << i)) {
            choices->of[i] = 0;
            choices->given[i] = false;
        }
}

/* The integrator that owns entry `index`, and the entry's own index; NULL after the last. */
static const lf_integrator *whose(int index, int *out_own)
{
    const lf_integrator *integrator = &lf_integrator_rows;
    for (const lf_integrator *const *next = added; integrator; integrator = *next++) {
        int own = 0;
        while (integrator->entry(own) && own < index)
            own++;
        if (integrator->entry(own)) {
            *out_own = own;
            return integrator;
        }
        index -= own;
    }
    return NULL;
}

const lf_integrator_entry *lf_integrator_at(int index)
{
    int own;
    const lf_integrator *integrator = index >= 0 ? whose(index, &own) : NULL;
    return integrator ? integrator->entry(own) : NULL;
}

const lf_integrator_entry *lf_integrator_named(const char *name)
{
    int i = 0;
    while (name && lf_integrator_at(i) && strcmp(lf_integrator_at(i)->name, name) != 0)
        i++;
    return lf_integrator_at(i);
}

/* For cameras listed one by one; its entry names also occur elsewhere. */
static const lf_integrator *const lists = &lf_integrator_any_cameras;

static int index_of(const lf_integrator *integrator, const char *name)
{
    int i = 0;
    while (integrator->entry(i) && strcmp(integrator->entry(i)->name, name) != 0)
        i++;
    return integrator->entry(i) ? i : -1;
}

/* Adds a name to a list of them. */
static void add_name(char *names, size_t size, const char *name)
{
    const size_t used = strlen(names);
    snprintf(names + used, size - used, "%s%s", used ? ", " : "", name);
}

lf_status lf_integrator_find(const lf_render_settings *settings,
                             const lf_integrator **out_integrator, int *out_index, lf_error *err)
{
    const char *name = settings->integrator ? settings->integrator : lf_integrator_at(0)->name;
    const int listed = settings->camera.list ? index_of(lists, name) : -1;
    char known[128] = "";
    if (listed >= 0) {
        *out_integrator = lists;
        *out_index = listed;
        return LF_OK;
    }
    for (int i = 0; lf_integrator_at(i); i++) {
        if (strcmp(name, lf_integrator_at(i)->name) == 0) {
            *out_integrator = whose(i, out_index);
            return LF_OK;
        }
        add_name(known, sizeof known, lf_integrator_at(i)->name);
    }
    return lf_error_set(err, LF_E_ARG, "integrator", "\"%s\" is none of %s", name, known);
}

/* ------------------------------------------------------------------------------------ traits -- */

const lf_integrator_entry *lf_support_at(int index, bool *out_listed)
{
    const lf_integrator_entry *entry = lf_integrator_at(index);
    for (int i = 0; !entry && lf_integrator_at(i); i++)
        index--;
    *out_listed = !entry;
    return entry ? entry : lists->entry(index);
}

lf_traits lf_view_traits(const lf_render_settings *settings)
{
    const lf_camera *camera = &settings->camera;
    return (camera->moves ? LF_TRAIT_MOTION : 0) | (camera->lens_radius > 0.0 ? LF_TRAIT_LENS : 0) |
           (camera->view_blur > 0.0 ? LF_TRAIT_VIEW_BLUR : 0) |
           (camera->list ? LF_TRAIT_LISTED_CAMERAS : 0) |
           (settings->features ? LF_TRAIT_FEATURES : 0);
}

lf_status lf_integrator_check(const lf_integrator_entry *entry, const lf_scene *scene,
                              const lf_render_settings *settings, lf_error *err)
{
    const lf_traits has = scene->traits | lf_view_traits(settings);
    char who[80], text[400], others[128] = "";
    bool listed;
    snprintf(who, sizeof who, "%s%s", entry->name,
             settings->camera.list ? LF_OF_LISTED_CAMERAS : "");
    if (!lf_traits_missing(has, entry->supports, who, text, sizeof text))
        return LF_OK;
    for (int i = 0; (entry = lf_support_at(i, &listed)); i++)
        if (listed == !!settings->camera.list && !(has & ~entry->supports))
            add_name(others, sizeof others, entry->name);
    return lf_error_set(err, LF_E_ARG, "integrator", "%s%s%s", text, *others ? "; use one of " : "",
                        others);
}
