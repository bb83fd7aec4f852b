/* Shadows and reflections of catchers in a finished image, pixel by pixel; and in a denoised image,
 * where views share their samples. */
#include <math.h>

#include "render/layers/caught.h"

/* ----------------------------------------------------------------------------- a whole image -- */

typedef struct catch_job {
    const lf_renderer *renderer;
    lf_rig rig;
    float *out;
} catch_job;

static bool was_visited(const lf_film *film, int row)
{
    return row >= 0 && row < film->height && film->rows[row].n[0] + film->rows[row].n[1] > 0.0;
}

/* The nearest visited row; the row itself if there is none. */
static int visited_near(const lf_film *film, int row)
{
    for (int apart = 0; apart < film->height; apart++)
        for (int side = -1; side <= 1; side += 2)
            if (was_visited(film, row + side * apart))
                return row + side * apart;
    return row;
}

static void catch_row(void *context, int row, int worker)
{
    const catch_job *job = context;
    const lf_rig *rig = &job->rig;
    const lf_renderer *renderer = job->renderer;
    const lf_scene *scene = renderer->scene;
    const int near = visited_near(&renderer->film, row);
    const double *native = renderer->film.rows[near].n;
    const int n = lf_catch_points(native[0] + native[1]);
    const lf_vec3 backdrop = lf_catch_behind(scene, rig, row);
    float *out = job->out + (size_t)row * (size_t)rig->n_views * (size_t)rig->width * 3;
    lf_tracer tracer = {.scene = scene};
    (void)worker;
    lf_film_open(&renderer->film, near);
    for (int view = 0; view < rig->n_views; view++)
        for (int column = 0; column < rig->width; column++, out += 3) {
            const lf_catch_pixel pixel = lf_catch_pixel_of(renderer, rig, view, row, column);
            const float open = lf_catch_open(
                scene, lf_catch_met(&renderer->film, near,
                                    (size_t)view * (size_t)rig->width + (size_t)column));
            lf_catch_take(out, (float)lf_catch_shade(&tracer, &pixel, n, open), backdrop);
            if (lf_has(scene, LF_TRAIT_REFLECTIONS))
                lf_catch_put(out, lf_catch_reflection(&tracer, &pixel, n));
        }
    lf_film_close(&renderer->film, near, false);
}

lf_status lf_renderer_catch(const lf_renderer *renderer, float *picture, const lf_cancel *cancel)
{
    catch_job job = {.renderer = renderer};
    job.out = picture;
    if (!lf_catch_shows(renderer->scene))
        return LF_OK;
    lf_status status = lf_rig_init(&job.rig, &renderer->settings, renderer->scene->origin, NULL);
    return status == LF_OK
               ? lf_pool_run(renderer->pool, renderer->film.height, catch_row, &job, cancel)
               : status;
}

/* -------------------------------------------------------------------------- a denoised image -- */

typedef struct sharing_job {
    lf_caught *caught;
    catch_job whole; /* for rows that were not visited */
} sharing_job;

static void add_row(void *context, int row, int worker)
{
    const sharing_job *job = context;
    int before;
    (void)worker;
    if (!lf_film_is_known(&job->whole.renderer->film.rows[row]))
        return;
    do {
        before = lf_caught_samples(job->caught, row);
        lf_caught_add(job->caught, row);
    } while (lf_caught_samples(job->caught, row) > before);
}

static void take_row(void *context, int row, int worker)
{
    sharing_job *job = context;
    const lf_rig *rig = &job->whole.rig;
    if (lf_caught_samples(job->caught, row) == 0)
        catch_row(&job->whole, row, worker);
    else
        lf_caught_take(job->caught, row, true,
                       job->whole.out +
                           (size_t)row * (size_t)rig->n_views * (size_t)rig->width * 3);
}

lf_status lf_renderer_catch_smoothly(const lf_renderer *renderer, float *picture,
                                     const lf_cancel *cancel)
{
    sharing_job job = {.whole = {.renderer = renderer}};
    const int height = renderer->film.height;
    lf_status status = lf_caught_begin(&job.caught, renderer);
    if (!job.caught)
        return status;
    job.whole.out = picture;
    if (status == LF_OK)
        status = lf_rig_init(&job.whole.rig, &renderer->settings, renderer->scene->origin, NULL);
    if (status == LF_OK)
        status = lf_pool_run(renderer->pool, height, add_row, &job, cancel);
    if (status == LF_OK)
        status = lf_caught_smooth(job.caught, cancel);
    if (status == LF_OK)
        status = lf_pool_run(renderer->pool, height, take_row, &job, cancel);
    lf_caught_destroy(job.caught);
    return status;
}
