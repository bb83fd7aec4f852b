#include "render/integrator.h"

#include <stdio.h>
#include <string.h>

#include "render/cameras/any_cameras.h"
#include "render/papers/general.h"
#include "render/papers/restir.h"
#include "render/rows/rows.h"

static const lf_integrator *const table[] = {&lf_integrator_rows, &lf_integrator_general,
                                             &lf_integrator_restir};
#define N_INTEGRATORS (int)(sizeof table / sizeof table[0])

/* Whose entry this is, and which of its own; NULL behind the last. */
static const lf_integrator *whose(int index, int *out_own)
{
    for (int i = 0; i < N_INTEGRATORS; i++) {
        int own = 0;
        while (table[i]->entry(own) && own < index)
            own++;
        if (table[i]->entry(own)) {
            *out_own = own;
            return table[i];
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
