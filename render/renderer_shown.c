/* The reconstructed picture of a renderer's film. */
#include "render/renderer.h"
#include "render/rows/rig.h"

static lf_status create(lf_renderer *renderer)
{
    lf_rig rig;
    float shift[LF_MAX_VIEWS];
    lf_status status = lf_rig_init(&rig, &renderer->settings, renderer->scene->origin, NULL);
    if (status != LF_OK)
        return status;
    for (int k = 0; k < rig.n_views; k++)
        shift[k] = rig.b[k] / rig.dx;
    const lf_reconstruct_view view = {rig.n_views, rig.width, rig.height, shift,
                                      rig.distance / rig.dx};
    return lf_reconstruct_create(&view, renderer->pool, &renderer->shown);
}

lf_status lf_renderer_fit(lf_renderer *renderer, const lf_cancel *cancel)
{
    if (!renderer->film.layout.has_features)
        return LF_E_STATE;
    lf_status status = renderer->shown ? LF_OK : create(renderer);
    return status == LF_OK ? lf_reconstruct_fit(renderer->shown, &renderer->film, cancel) : status;
}

lf_status lf_renderer_show_row(const lf_renderer *renderer, int row, float *out)
{
    return renderer->shown ? lf_reconstruct_row(renderer->shown, &renderer->film, row, out)
                           : LF_E_STATE;
}

typedef struct lf_show_job {
    const lf_renderer *renderer;
    float *out;
    atomic_int failed;
} lf_show_job;

/* Rows that nothing has visited are none to show. */
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
