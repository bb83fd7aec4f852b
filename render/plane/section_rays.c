#include "render/plane/section_rays.h"

#include "render/transport/surface/surface_texture.h"

enum { WIDE = LF_SECTION_WIDE };

/* The next hit of the section's kind, beyond t. */
static bool next(const lf_section_rays *rays, lf_vec3 o, lf_vec3 w, float t, float t_max,
                 lf_hit *hit)
{
    bool wanted = false;
    while (!wanted && lf_trace_next(rays->tracer, o, w, t, t_max, hit)) {
        wanted = !hit->mesh->hidden &&
                 (rays->what == LF_CUT_ALL ||
                  lf_is_alpha_surface(hit->material) == (rays->what == LF_CUT_ALPHAS));
        t = lf_behind(hit->t);
    }
    return wanted;
}

/* The fraction of a camera ray that an alpha surface stops, as in sections. */
static float stopped(const lf_rig *rig, const lf_hit *hit, lf_vec3 w)
{
    float z = lf_dot(lf_sub(hit->p, rig->eye), rig->forward);
    return lf_hit_stops(hit, w, lf_rig_spread(rig) * z);
}

void lf_section_hide_by_rays(const lf_row_cut *cut, lf_vec3 p, const lf_hit *on, int n,
                             const float *c, float *scale)
{
    const lf_section_rays *rays = &cut->section->rays;
    const lf_rig *rig = cut->rig;
    for (int k = 0; k < n; k++) {
        if (!(scale[k] > 0.0f))
            continue;
        lf_vec3 eye = lf_rig_point(rig, c[k], rays->plane.ly, 0.0f), to = lf_sub(eye, p);
        lf_vec3 o = on ? lf_offset(rays->tracer->scene, p, on->ng, to, lf_length(to)) : p;
        lf_vec3 w = lf_sub(eye, o);
        lf_hit hit;
        float t = 0.0f;
        while (scale[k] > 0.0f && next(rays, o, w, t, 1.0f - 1e-6f, &hit)) {
            scale[k] *= rays->what == LF_CUT_ALPHAS ? 1.0f - stopped(rig, &hit, w) : 0.0f;
            t = lf_behind(hit.t);
        }
    }
}

/* Ray k, s0 + c d, with Z for t. */
static void ray_of(const lf_row_cut *cut, const lf_lines *lines, int k, lf_vec3 *out_o,
                   lf_vec3 *out_w)
{
    const lf_row_plane *plane = &cut->section->rays.plane;
    *out_o = lf_rig_point(cut->rig, lines->c[k], plane->ly, 0.0f);
    *out_w =
        lf_rig_direction(cut->rig, lines->s0 - lines->c[k] / cut->rig->window, plane->my, 1.0f);
}

/* Segment k is what a ray has met: a slot each. */
static void put(lf_section_instances *places, lf_section_leaf *leaves, const lf_row_triangles *rows,
                const lf_scene *scene, int k, const lf_hit *hit)
{
    lf_section_leaf *leaf = &leaves[k / WIDE];
    leaf->material[k % WIDE] = (int)(hit->material - scene->materials);
    leaf->triangle[k % WIDE] = rows->mesh_start[hit->mesh->geom_id] + hit->triangle;
    if (!hit->mesh->instances)
        return;
    leaf->triangle[k % WIDE] = places->first + (uint32_t)k;
    places->triangle[k] = hit->triangle;
    places->slot[places->n++] = (lf_section_slot){hit->mesh->geom_id, hit->place, (uint32_t)k};
}

void lf_section_nearest_by_rays(const lf_row_cut *cut, const lf_lines *lines, float *z,
                                int *segment)
{
    const lf_section *section = cut->section;
    /* The section belongs to the calling worker. */
    lf_section_instances *places = (lf_section_instances *)(uintptr_t)&section->places;
    places->n = 0;
    for (int k = 0; k < lines->n; k++) {
        lf_vec3 o, w;
        lf_hit hit;
        ray_of(cut, lines, k, &o, &w);
        bool found = next(&section->rays, o, w, 0.0f, INFINITY, &hit);
        z[k] = found ? hit.t : INFINITY;
        segment[k] = found ? k : -1;
        if (found)
            put(places, section->leaves, cut->rows, section->rays.tracer->scene, k, &hit);
    }
}

void lf_section_alphas_by_rays(const lf_row_cut *alphas, const lf_lines *lines, const float *z_end,
                               float *through, bool *mirrors, lf_alpha_crossings *kept)
{
    const lf_section_rays *rays = &alphas->section->rays;
    for (int k = 0; k < lines->n; k++) {
        lf_vec3 o, w;
        lf_hit hit;
        float t = 0.0f;
        ray_of(alphas, lines, k, &o, &w);
        while (through[k] > 0.0f && next(rays, o, w, t, z_end[k] * (1.0f - 1e-6f), &hit)) {
            const float passed = 1.0f - stopped(alphas->rig, &hit, w);
            if (kept)
                lf_alpha_keep(&kept[k], hit.t, passed, -1);
            through[k] *= passed;
            mirrors[k] |= lf_has_mirror(hit.material);
            t = lf_behind(hit.t);
        }
    }
}

void lf_section_crossings_by_rays(const lf_row_cut *alphas, const lf_lines *lines,
                                  const float *z_end, lf_alpha_crossings *ray)
{
    const lf_section_rays *rays = &alphas->section->rays;
    for (int k = 0; k < lines->n; k++) {
        lf_vec3 o, w;
        lf_hit hit;
        if (!ray[k].wanted)
            continue;
        float t = ray[k].first;
        ray_of(alphas, lines, k, &o, &w);
        while (ray[k].n < LF_ALPHA_CROSSINGS_KEPT &&
               next(rays, o, w, t, z_end[k] * (1.0f - 1e-6f), &hit)) {
            lf_alpha_keep(&ray[k], hit.t, 1.0f - stopped(alphas->rig, &hit, w), -1);
            t = lf_behind(hit.t);
        }
        if (ray[k].n == LF_ALPHA_CROSSINGS_KEPT)
            ray[k].known = t;
    }
}
