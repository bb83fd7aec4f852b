/* Base samples: a ray of one view, from its film point to its pivot. */
#include "render/rows/extinction.h"
#include "render/rows/native.h"
#include "render/rows/queue.h"
#include "render/rows/visit_steps.h"

/* A base ray while it is traced. */
typedef struct base_ray {
    lf_sampler sampler;
    float u[2]; /* position in the pixel; the second number is reused for media */
    lf_media_ray line;
    lf_vec3 eye;
    lf_pivot pivot;
    bool surface; /* it ends on a surface … */
    bool thin;    /* … of thin glass */
    bool shared;  /* its pivot is shared */
} base_ray;

void lf_pivot_begin(lf_pivot *pivot, lf_vec3 w, float lens, lf_sampler *sampler)
{
    lf_event *event = &pivot->event;
    event->w = w;
    event->from = event->channels = event->left = lf_v3(0.0f, 0.0f, 0.0f);
    event->t = event->surface = 0.0f;
    event->interior = NULL;
    event->nest.n = 0;
    event->subsurface = (lf_subsurface){0};
    pivot->lx = lens;
    pivot->forced_weight = 0.0f;
    pivot->is_thin = false;
    pivot->sampler = sampler;
}

/* The ray's line in the row's plane. */
static void aim(const lf_visit *visit, const lf_base *base, base_ray *ray)
{
    const lf_rig *rig = visit->rig;
    float lens = 0.0f;
    lf_sampler_2d(&ray->sampler, ray->u);
    if (visit->plane.lens_chord > 0.0f)
        lens = (2.0f * lf_sampler_1d(&ray->sampler) - 1.0f) * visit->plane.lens_chord;
    const float u = (float)base->column + (base->film < 0.0f ? ray->u[0] : base->film),
                my = visit->plane.my;
    lf_media_ray *line = &ray->line;
    line->x0 = rig->b[base->view] + lens;
    line->slope = lf_rig_slope(rig, base->view, u) - lens / rig->focus;
    line->length = sqrtf(1.0f + line->slope * line->slope + my * my);
    line->z_end = INFINITY;
    ray->eye = lf_rig_point(rig, line->x0, visit->plane.ly, 0.0f);
    const lf_vec3 along = lf_rig_direction(rig, line->slope, my, 1.0f);
    lf_pivot_begin(&ray->pivot, lf_scale(along, 1.0f / line->length), lens, &ray->sampler);
}

/* Finds the surface on which it ends, unless it scatters before. */
static void meet(const lf_visit *visit, base_ray *ray)
{
    lf_tracer *tracer = &visit->worker->tracer;
    lf_event *event = &ray->pivot.event;
    tracer->width = 0.0f;
    tracer->spread = lf_rig_spread(visit->rig) / ray->line.length;
    ray->surface = lf_trace_seen(tracer, ray->eye, event->w, INFINITY, &event->hit);
    ray->thin = ray->surface && event->hit.material->glass.is_thin;
    ray->shared = ray->surface && (event->hit.material->has_lobe || ray->thin);
    if (ray->surface)
        ray->line.z_end = event->hit.t / ray->line.length;
}

/* Whether collisions in front of the surface are forced: not if the surface, or thin glass in front
 * of it, reflects. */
static bool is_forced(const lf_visit *visit, const base_ray *ray)
{
    const lf_event *event = &ray->pivot.event;
    const float t_end = ray->surface ? event->hit.t : INFINITY;
    lf_hit first;
    if (!visit->plan->order.cover || ray->shared ||
        (ray->surface && event->hit.material->has_delta))
        return false;
    return !lf_has(visit->scene, LF_TRAIT_THIN_GLASS) ||
           !lf_trace_thin(&visit->worker->tracer, ray->eye, event->w, 0.0f, t_end, &first);
}

/* The first collision before the surface, in the extinction of one channel (coloured media: drawn).
 */
static lf_collision collide(const lf_visit *visit, base_ray *ray)
{
    lf_scratch *w = visit->worker;
    const bool forced = is_forced(visit, ray);
    const int channel =
        visit->extinction->channels > 1 ? (int)(3.0f * lf_sampler_1d(&ray->sampler)) : 0;
    return lf_media_collide(&w->media, &ray->line, channel, ray->u[1], forced, &w->tracer);
}

/* Makes the collision the pivot, and spreads it over the views, or queues it for lanes. */
static void end_in_medium(lf_visit *visit, const lf_base *base, base_ray *ray,
                          const lf_collision *at)
{
    lf_pivot *pivot = &ray->pivot;
    pivot->event.kind = LF_EVENT_MEDIUM;
    pivot->z = at->z;
    pivot->x = ray->line.x0 + ray->line.slope * pivot->z;
    pivot->medium = at->medium;
    pivot->forced_weight = at->forced_weight * visit->weight;
    pivot->event.p =
        lf_rig_point(visit->rig, pivot->x, visit->plane.ly + visit->plane.my * pivot->z, pivot->z);
    pivot->event.volume = visit->worker->media.item[at->medium].volume;
    if (visit->queue)
        lf_queue_push(visit->queue, visit, base->view, base->column, pivot);
    else
        visit->acting->pivot(visit, base->view, base->column, pivot, NULL);
}

/* Makes the surface the pivot. Its delta lobes become native samples, if base samples of the pixel
 * draw them; a shared surface is spread over the views. */
static void end_on_surface(lf_visit *visit, const lf_base *base, base_ray *ray, bool natives)
{
    lf_pivot *pivot = &ray->pivot;
    const lf_vec3 d = lf_sub(pivot->event.hit.p, visit->rig->eye);
    pivot->event.kind = LF_EVENT_SURFACE;
    pivot->event.p = pivot->event.hit.p;
    pivot->is_thin = ray->thin;
    pivot->forced_weight = visit->weight;
    pivot->x = lf_dot(d, visit->rig->right);
    pivot->z = lf_dot(d, visit->rig->forward);
    if (natives && !ray->thin)
        lf_natives_of_surface(visit, base->view, base->column, pivot);
    if (ray->shared && !base->native_only)
        visit->acting->pivot(visit, base->view, base->column, pivot, NULL);
}

void lf_base_sample(lf_visit *visit, const lf_base *base)
{
    lf_scratch *w = visit->worker;
    const int view = base->view, column = base->column;
    base_ray ray;
    w->base_paths++;
    if (column < w->reach.first[view] || column >= w->reach.end[view])
        return; /* it escapes */
    const uint64_t pixel =
        lf_hash64(base->key, (uint64_t)view * (uint64_t)visit->rig->width + (uint64_t)column + 16);
    lf_sampler_init(&ray.sampler, visit->plan->sampler, pixel, base->index);
    w->tracer.rng = lf_hash64(pixel ^ visit->random, ~(uint64_t)base->index);
    aim(visit, base, &ray);
    meet(visit, &ray);
    const lf_collision at = collide(visit, &ray);
    const bool collides = at.z < INFINITY,
               natives = base->native_only || lf_natives_by_base(visit, view, column);
    if (lf_has(visit->scene, LF_TRAIT_THIN_GLASS) && natives && visit->sums.native) {
        const float t_end = collides      ? at.z * ray.line.length
                            : ray.surface ? ray.pivot.event.hit.t
                                          : INFINITY;
        lf_natives_of_thin_glass(visit, view, column, &ray.pivot, ray.eye, t_end);
    }
    if (collides && !base->native_only)
        end_in_medium(visit, base, &ray, &at);
    else if (ray.surface && !collides)
        end_on_surface(visit, base, &ray, natives);
}
