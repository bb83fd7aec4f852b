#include "render/papers/selection.h"

/* Always summed from the first view on, so that rounding gives the same groups for all bases. */
static bool next_group(const lf_selected_views *views, int k, double *line)
{
    double before = floor(*line);
    *line += k > 0 ? views->distance(views->lobes, k - 1, k) : 0.0;
    return floor(*line) != before;
}

static void cut(const lf_selected_views *views, lf_tracer *tracer, bool *out)
{
    double line = (double)lf_rng(tracer);
    int first = 0, end = views->n;
    for (int k = 0; k < views->n && end == views->n; k++) {
        bool cuts = next_group(views, k, &line);
        first = cuts && k <= views->base ? k : first;
        end = cuts && k > views->base ? k : end;
    }
    for (int k = 0; k < views->n; k++)
        out[k] = k >= first && k < end;
}

const lf_selection lf_selection_partition = {"partition", "groups along the cameras' line", cut};
