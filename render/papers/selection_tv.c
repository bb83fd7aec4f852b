#include "render/papers/selection.h"

static void accept(const lf_selected_views *views, lf_tracer *tracer, bool *out)
{
    for (int k = 0; k < views->n; k++)
        out[k] = k == views->base ||
                 (double)lf_rng(tracer) >= views->distance(views->lobes, views->base, k);
}

const lf_selection lf_selection_tv = {"tv", "by total variation, as printed: biased", accept};
