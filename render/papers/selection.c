#include "render/papers/selection.h"

static void all(const lf_selected_views *views, lf_tracer *tracer, bool *out)
{
    (void)tracer;
    for (int k = 0; k < views->n; k++)
        out[k] = true;
}

const lf_selection lf_selection_none = {"none", "all views", all};

static const lf_selection *const table[] = {&lf_selection_tv, &lf_selection_none,
                                            &lf_selection_partition};
#define N_SELECTIONS (int)(sizeof table / sizeof table[0])

const lf_selection *lf_selection_at(int index)
{
    return index >= 0 && index < N_SELECTIONS ? table[index] : NULL;
}

const char *lf_selection_name(int selection)
{
    return lf_selection_at(selection) ? lf_selection_at(selection)->name : NULL;
}
