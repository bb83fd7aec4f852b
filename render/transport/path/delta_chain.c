#include "render/transport/path/delta_chain.h"

/* Branches with less than this share continue at random, and survivors have this share. */
#define LEAST_BRANCH 0.02f
/* At the end of a branch with less than a quarter of the light, a path is drawn with some
 * probability, because it costs much more than the branch. */
#define PATHS_A_SHARE 4.0f
/* Depth limit of branching after the first vertex; deeper vertices follow one branch. */
#define DEEPEST_SPLIT 8
static void arrive(lf_delta_chain *c, const lf_event *from, lf_vec3 wi, lf_vec3 beta, float way,
                   int depth);

/* Whether a path with this share continues, and with which throughput. */
static bool survives(lf_tracer *tracer, float probability, lf_vec3 *beta)
{
    if (probability >= 1.0f)
        return true;
    if (lf_rng(tracer) >= probability)
        return false;
    *beta = lf_scale(*beta, 1.0f / probability);
    return true;
}

static void branch(lf_delta_chain *c, const lf_event *event, const lf_delta *lobe, lf_vec3 beta,
                   float way, int depth)
{
    const float spread = c->tracer->spread;
    beta = lf_mul(beta, lobe->f);
    if (survives(c->tracer, lf_max3(beta) * (1.0f / LEAST_BRANCH), &beta))
        arrive(c, event, lobe->wi, beta, way, depth + 1);
    c->tracer->spread = spread;
}

/* Whether an event scatters, so that it has features. */
static bool scatters(const lf_event *event)
{
    return event->kind == LF_EVENT_MEDIUM || lf_hit_material(&event->hit)->has_lobe;
}

/* Approximate albedo there, including transmission. */
static void albedo_at(const lf_scene *scene, const lf_event *end, float out[LF_ALBEDO_NUMBERS])
{
    lf_vec3 a = lf_v3(1.0f, 1.0f, 1.0f);
    if (end->kind == LF_EVENT_SURFACE) {
        const lf_material *m = lf_hit_material(&end->hit);
        lf_material_albedo(m, m->albedo, m->metallic, out);
        return;
    }
    if (end->volume != LF_INTERIOR)
        a = lf_volume_albedo(&scene->volumes[end->volume], end->p);
    out[0] = lf_max(a.x, LF_LEAST_ALBEDO);
    out[1] = lf_max(a.y, LF_LEAST_ALBEDO);
    out[2] = lf_max(a.z, LF_LEAST_ALBEDO);
    out[LF_ALBEDO_METAL] = 0.0f;
}

/* Adds the features of the end of a branch. */
static void note_end(lf_delta_chain *c, const lf_event *end, lf_vec3 beta, float way)
{
    const bool surface = end->kind == LF_EVENT_SURFACE;
    float albedo[LF_ALBEDO_NUMBERS];
    albedo_at(c->tracer->scene, end, albedo);
    const float share = lf_mean3(beta), mean = (albedo[0] + albedo[1] + albedo[2]) * (1.0f / 3.0f),
                weight = share * (c->tinted ? 1.0f : mean),
                nearness = c->distance / (c->z + way * c->forward);
    const float tint[LF_ALBEDO_NUMBERS] = {beta.x, beta.y, beta.z, share};
    for (int i = 0; i < LF_ALBEDO_NUMBERS; i++)
        c->albedo[i] += tint[i] * albedo[i];
    c->weight += weight;
    c->nearness += weight * nearness;
    c->nearness2 += weight * nearness * nearness;
    if (surface && c->sunlight) {
        lf_sunlight_face face;
        lf_sunlight_face_init(&face, c->sunlight, end->hit.ng);
        c->light +=
            share * lf_sunlight_reflected(c->sunlight, &face, &end->hit, lf_scale(end->w, -1.0f));
    }
}

/* Adds the light scattered at the end of a branch. */
static void scatter(lf_delta_chain *c, const lf_event *end, lf_vec3 beta, float way, int depth)
{
    const bool apart = c->apart && scatters(end);
    const double cut = c->tracer->suffixes_cut;
    if (apart)
        note_end(c, end, beta, way);
    if (!survives(c->tracer, PATHS_A_SHARE * lf_max3(beta), &beta))
        return;
    lf_vec3 light = lf_mul(beta, lf_path_scattered(c->tracer, end, depth, c->max_depth)),
            *to = apart ? &c->scattered : &c->known;
    c->tracer->suffixes_cut = cut + (c->tracer->suffixes_cut - cut) * (double)lf_max3(beta);
    *to = lf_add(*to, light);
}

/* Whether the chain branches at an event, and into what. */
static bool splits(const lf_delta_chain *c, const lf_event *event, int depth, lf_shading *out)
{
    if (event->kind != LF_EVENT_SURFACE || lf_hit_material(&event->hit)->has_lobe ||
        depth > c->max_depth || depth > 1 + DEEPEST_SPLIT)
        return false;
    lf_shade(&event->hit, lf_scale(event->w, -1.0f), out);
    return out->n_deltas > 0;
}

static void arrive(lf_delta_chain *c, const lf_event *from, lf_vec3 wi, lf_vec3 beta, float way,
                   int depth)
{
    const lf_scene *scene = c->tracer->scene;
    lf_event next;
    lf_shading shading;
    float light_pdf;
    lf_path_next(c->tracer, from, wi, &next);
    lf_vec3 left = lf_path_absorbed(scene, &next),
            found = lf_mul(lf_path_light_found(scene, from, &next, &light_pdf), left);
    found = lf_add(found, lf_path_along(c->tracer, &next, depth <= c->max_depth));
    c->known = lf_add(c->known, lf_mul(beta, found));
    if (next.kind == LF_EVENT_ESCAPE)
        return;
    beta = lf_mul(beta, left);
    way += lf_min(next.t, next.surface);
    if (!splits(c, &next, depth, &shading)) {
        scatter(c, &next, beta, way, depth);
        return;
    }
    if (lf_has(scene, LF_TRAIT_CHROMATIC_MEDIA))
        beta = lf_mul(beta, next.channels);
    for (int i = 0; i < shading.n_deltas; i++)
        branch(c, &next, &shading.delta[i], beta, way, depth);
}

void lf_delta_chain_follow(lf_delta_chain *chain, const lf_event *first, const lf_delta *lobe,
                           float share)
{
    lf_tracer *tracer = chain->tracer;
    const double cut = tracer->suffixes_cut, all = (double)(share * lf_max3(lobe->f));
    branch(chain, first, lobe, lf_v3(share, share, share), 0.0f, 1);
    tracer->suffixes++;
    tracer->suffixes_cut = cut + (all > 0.0 ? (tracer->suffixes_cut - cut) / all : 0.0);
}
