#include "render/transport/light/equiangular.h"

#include "render/transport/light/light_kind.h"

static float outside(float x, float min, float max)
{
    return lf_max(0.0f, lf_max(min - x, x - max));
}

/* How far the farthest point of the volumes is. */
static float reach_of(const lf_scene *scene, lf_vec3 p)
{
    lf_vec3 d = lf_v3(lf_max(fabsf(p.x - scene->equiangular.media.min.x),
                             fabsf(p.x - scene->equiangular.media.max.x)),
                      lf_max(fabsf(p.y - scene->equiangular.media.min.y),
                             fabsf(p.y - scene->equiangular.media.max.y)),
                      lf_max(fabsf(p.z - scene->equiangular.media.min.z),
                             fabsf(p.z - scene->equiangular.media.max.z)));
    return lf_length(d);
}

static bool in_media(const lf_scene *scene, lf_vec3 p, float radius)
{
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *v = &scene->volumes[i];
        lf_vec3 d = lf_v3(outside(p.x, v->bounds_min.x, v->bounds_max.x),
                          outside(p.y, v->bounds_min.y, v->bounds_max.y),
                          outside(p.z, v->bounds_min.z, v->bounds_max.z));
        float half = 0.5f * lf_length(lf_sub(v->bounds_max, v->bounds_min));
        if (v->sigma_max > 0.0f && lf_length(d) <= 0.25f * half && radius <= 0.05f * half)
            return true;
    }
    return false;
}

static void set_media_bounds(lf_scene *scene)
{
    lf_vec3 min = lf_v3(INFINITY, INFINITY, INFINITY), max = lf_scale(min, -1.0f);
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *v = &scene->volumes[i];
        if (!(v->sigma_max > 0.0f))
            continue;
        min = lf_v3(lf_min(min.x, v->bounds_min.x), lf_min(min.y, v->bounds_min.y),
                    lf_min(min.z, v->bounds_min.z));
        max = lf_v3(lf_max(max.x, v->bounds_max.x), lf_max(max.y, v->bounds_max.y),
                    lf_max(max.z, v->bounds_max.z));
    }
    scene->equiangular.media.min = min;
    scene->equiangular.media.max = max;
}

/* The strongest light in media that is not an equiangular light yet, or NULL. */
static lf_light *strongest(lf_scene *scene)
{
    lf_light *best = NULL;
    for (int i = 0; i < scene->n_lights; i++) {
        lf_light *light = &scene->lights[i];
        lf_vec3 middle;
        float radius;
        if (!light->kind->extent || light->equiangular > 0 ||
            !(light->select > (best ? best->select : 0.0f)))
            continue;
        light->kind->extent(scene, light, &middle, &radius);
        if (in_media(scene, middle, radius))
            best = light;
    }
    return best;
}

void lf_equiangular_commit(lf_scene *scene)
{
    float sum = 0.0f;
    lf_light *light;
    scene->equiangular.n = 0;
    set_media_bounds(scene);
    while (scene->equiangular.n < LF_MAX_EQUIANGULAR && (light = strongest(scene))) {
        lf_equiangular_light *equiangular = &scene->equiangular.item[scene->equiangular.n++];
        light->kind->extent(scene, light, &equiangular->middle, &equiangular->radius);
        equiangular->reach = reach_of(scene, equiangular->middle);
        equiangular->light = (int)(light - scene->lights);
        light->equiangular = scene->equiangular.n;
        sum += light->select;
    }
    for (int i = 0; i < scene->equiangular.n; i++)
        scene->equiangular.item[i].share =
            scene->lights[scene->equiangular.item[i].light].select / sum;
}

void lf_equiangular_move(lf_scene *scene)
{
    for (int i = 0; i < scene->equiangular.n; i++) {
        lf_equiangular_light *equiangular = &scene->equiangular.item[i];
        const lf_light *light = &scene->lights[equiangular->light];
        bool moves = lf_light_has_faces(light) ? !!scene->meshes[light->mesh].close.vertices
                                               : !!light->motion;
        if (!moves)
            continue;
        light->kind->extent(scene, light, &equiangular->middle, &equiangular->radius);
        equiangular->reach = reach_of(scene, equiangular->middle);
    }
}

static void clip(float o, float w, float min, float max, float *t0, float *t1)
{
    /* A ray along the faces: far outside or far inside, never 0/0. */
    float inverse = 1.0f / (fabsf(w) > 1e-30f ? w : 1e-30f), a = (min - o) * inverse,
          b = (max - o) * inverse;
    *t0 = lf_max(*t0, lf_min(a, b));
    *t1 = lf_min(*t1, lf_max(a, b));
}

bool lf_equiangular_segment_init(lf_equiangular_segment *s, const lf_scene *scene,
                                 const lf_equiangular_light *equiangular, lf_vec3 o, lf_vec3 w)
{
    float t0 = 0.0f, t1 = INFINITY;
    clip(o.x, w.x, scene->equiangular.media.min.x, scene->equiangular.media.max.x, &t0, &t1);
    clip(o.y, w.y, scene->equiangular.media.min.y, scene->equiangular.media.max.y, &t0, &t1);
    clip(o.z, w.z, scene->equiangular.media.min.z, scene->equiangular.media.max.z, &t0, &t1);
    if (!(t1 > t0))
        return false;
    s->start = t0;
    s->middle = lf_dot(lf_sub(equiangular->middle, o), w);
    lf_vec3 across = lf_sub(equiangular->middle, lf_madd(o, s->middle, w));
    float least = 1e-6f * equiangular->reach;
    s->away =
        sqrtf(lf_dot(across, across) + equiangular->radius * equiangular->radius + least * least);
    s->angle = atanf((t0 - s->middle) / s->away);
    s->aperture = atanf((t1 - s->middle) / s->away) - s->angle;
    s->count = lf_min(1.0f, 0.5f * (t1 - t0) / s->away);
    return s->aperture > 0.0f;
}

float lf_equiangular_segment_draw(const lf_equiangular_segment *s, float u)
{
    return lf_max(s->middle + s->away * tanf(s->angle + u * s->aperture), s->start);
}

float lf_equiangular_segment_weight(const lf_equiangular_segment *s, float t, float sigma,
                                    float share, float select, float *out_pdf)
{
    float d = t - s->middle, pdf = s->away / (s->aperture * (s->away * s->away + d * d));
    float here = s->count * share * pdf,
          collisions = select * sigma * expf(-sigma * lf_max(t - s->start, 0.0f));
    if (out_pdf)
        *out_pdf = pdf;
    return here / (here + collisions);
}
