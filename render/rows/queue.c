#include "render/rows/queue.h"

void lf_queue_push(lf_queue *queue, lf_visit *visit, int view, int column, const lf_pivot *pivot)
{
    const lf_batch_pivot waits = {.p = pivot->event.p,
                                  .w = pivot->event.w,
                                  .volume = pivot->event.volume,
                                  .rng = visit->worker->tracer.rng};
    const int at = lf_suffix_batch_add(&queue->batch, visit->scene, &waits, pivot->sampler);
    queue->item[at] = (lf_queued){.x = pivot->x,
                                  .z = pivot->z,
                                  .lx = pivot->lx,
                                  .forced_weight = pivot->forced_weight,
                                  .alone = visit->alone,
                                  .medium = pivot->medium,
                                  .view = view,
                                  .column = column};
    lf_suffix_batch_keep_up(&queue->batch, &visit->worker->tracer, visit->max_depth);
    if (lf_suffix_batch_is_full(&queue->batch))
        lf_queue_flush(queue, visit);
}

/* The suffix of a pivot that sends the same to every view: the mean over its directions, whose
 * light is weighted against the light sample. */
static void take_mean(const lf_queue *queue, const lf_scene *scene, int at, lf_suffix *out)
{
    const lf_batch_pivot *pivot = &queue->batch.pivot[at];
    const lf_volume *volume = &scene->volumes[pivot->volume];
    const float n = (float)queue->batch.each;
    for (int k = 0; k < queue->batch.each; k++) {
        lf_suffix one = {0};
        lf_suffix_batch_direction(&queue->batch, scene, at, k, &one);
        if (one.found_pdf > 0.0f) {
            float density = n * lf_volume_phase(volume, pivot->w, one.wi);
            one.found = lf_scale(one.found, density / (density + one.found_pdf));
        }
        out->scattered = lf_madd(out->scattered, 1.0f / n, lf_add(one.scattered, one.found));
        out->wi = k == 0 ? one.wi : out->wi;
    }
    out->has_direction = true;
    if (pivot->has_light && !pivot->light.delta) /* one of n is accounted for when it is spread */
        out->light.pdf += (n - 1.0f) * lf_volume_phase(volume, pivot->w, pivot->light.wi);
}

/* The suffix of a pivot: one if it sends the same to every view; else a chain of suffixes. */
static void take_suffixes(const lf_queue *queue, const lf_scene *scene, int at, bool same,
                          lf_suffix out[LF_BATCH_EACH])
{
    const lf_batch_pivot *pivot = &queue->batch.pivot[at];
    out[0] = (lf_suffix){.has_light = pivot->has_light,
                         .light = pivot->light,
                         .light_visible = queue->batch.left[at]};
    if (same) {
        take_mean(queue, scene, at, &out[0]);
        return;
    }
    for (int k = 0; k < queue->batch.each; k++) {
        if (k > 0) {
            out[k] = (lf_suffix){0};
            out[k - 1].next = &out[k];
        }
        lf_suffix_batch_direction(&queue->batch, scene, at, k, &out[k]);
    }
}

static void spread(const lf_queue *queue, lf_visit *visit, int at)
{
    const lf_queued *item = &queue->item[at];
    const lf_batch_pivot *waits = &queue->batch.pivot[at];
    /* a view's own lobe is divided out */
    bool same = !visit->acting->entry.shares ||
                lf_volume_is_isotropic(&visit->scene->volumes[waits->volume]);
    lf_pivot pivot;
    lf_suffix suffix[LF_BATCH_EACH];
    lf_pivot_begin(&pivot, waits->w, item->lx, NULL);
    pivot.event.kind = LF_EVENT_MEDIUM;
    pivot.event.p = waits->p;
    pivot.event.volume = waits->volume;
    pivot.medium = item->medium;
    pivot.x = item->x;
    pivot.z = item->z;
    pivot.forced_weight = item->forced_weight;
    take_suffixes(queue, visit->scene, at, same, suffix);
    visit->alone = item->alone;
    visit->worker->tracer.rng = waits->rng;
    visit->acting->pivot(visit, item->view, item->column, &pivot, suffix);
}

void lf_queue_flush(lf_queue *queue, lf_visit *visit)
{
    lf_suffix_batch_trace(&queue->batch, &visit->worker->tracer, visit->max_depth);
    const float alone = visit->alone;
    for (int i = 0; i < queue->batch.n; i++)
        spread(queue, visit, i);
    visit->alone = alone;
    lf_suffix_batch_clear(&queue->batch);
}
