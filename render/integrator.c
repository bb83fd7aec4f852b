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

/* Whose entry this is, and which of its own; NULL behind the last. */
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

/* Of cameras listed one by one. */
static lf_status find_of_list(const char *name, int *out_index, lf_error *err)
{
    const lf_integrator *any = &lf_integrator_any_cameras;
    char known[128] = "";
    for (int i = 0; any->entry(i); i++) {
        const char *has = any->entry(i)->name;
        if (!name || strcmp(name, has) == 0) {
            *out_index = i;
            return LF_OK;
        }
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", has);
    }
    return lf_error_set(err, LF_E_ARG, "integrator",
                        "cameras listed one by one are rendered by one of %s, not by \"%s\"", known,
                        name);
}

lf_status lf_integrator_find(const lf_render_settings *settings,
                             const lf_integrator **out_integrator, int *out_index, lf_error *err)
{
    const char *name = settings->integrator;
    char known[128] = "";
    if (settings->camera.list) {
        *out_integrator = &lf_integrator_any_cameras;
        return find_of_list(name, out_index, err);
    }
    for (int i = 0; lf_integrator_at(i); i++) {
        const char *has = lf_integrator_at(i)->name;
        if (!name || strcmp(name, has) == 0) {
            *out_integrator = whose(i, out_index);
            return LF_OK;
        }
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", has);
    }
    return lf_error_set(err, LF_E_ARG, "integrator", "\"%s\" is none of %s", name, known);
}
