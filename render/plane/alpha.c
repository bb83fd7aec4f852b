#include "render/plane/alpha.h"

#include "render/plane/fan.h"
#include "render/plane/section_cut.h"
#include "render/plane/section_rays.h"
#include "render/transport/surface/surface_texture.h"

enum { WIDE = LF_SECTION_WIDE };

/* 1 - alpha where the line of view c meets the face at depth d. */
static float passes(const lf_row_cut *alphas, const lf_face *face, float c, float s, float d)
{
    const lf_rig *rig = alphas->rig;
    float z = lf_cut_depth(rig, d);
    lf_vec3 p = lf_rig_point(rig, s * z, alphas->plane->ly + alphas->plane->my * z, z);
    lf_vec3 along = lf_sub(p, lf_rig_point(rig, c, alphas->plane->ly, 0.0f));
    lf_hit hit;
    lf_face_hit(face, p, along, &hit);
    return 1.0f - lf_hit_stops(&hit, along, lf_rig_spread(rig) * z);
}

/* A segment, seen from a point through which all lines go: at (d, s). */
typedef struct alpha {
    lf_face face;
    float d0, s0, d1, s1;
} alpha;

static alpha alpha_of(const lf_row_cut *alphas, int segment)
{
    const lf_section_leaf *leaf = &alphas->section->leaves[segment / WIDE];
    int i = segment % WIDE;
    alpha out = {.d0 = leaf->d0[i], .s0 = leaf->s0[i], .d1 = leaf->d1[i], .s1 = leaf->s1[i]};
    lf_section_face(alphas, segment, &out.face);
    return out;
}

/* ---------------------------------------------------------------------------- before a point -- */

static void segment_before(const lf_row_cut *alphas, const lf_question *q, int segment, float lo,
                           float hi)
{
    alpha v = alpha_of(alphas, segment);
    for (int k = q->first; k <= q->last; k++) {
        float c = q->c[k];
        if (!(q->scale[k] > 0.0f) || !(c >= lo) || !(c <= hi))
            continue;
        float across = (v.s1 - v.s0) - c * (v.d1 - v.d0),
              t = across != 0.0f ? (q->s - v.s0 + c * (v.d0 - q->d)) / across : 0.0f;
        t = lf_min(lf_max(t, 0.0f), 1.0f);
        q->scale[k] *= passes(alphas, &v.face, c, lf_lerp(v.s0, v.s1, t), lf_lerp(v.d0, v.d1, t));
    }
}

static void node_before(const lf_row_cut *alphas, int node, const lf_question *q)
{
    const lf_section *section = alphas->section;
    for (unsigned in = section->fans->meets(&section->nodes[node], q); in; in &= in - 1) {
        const int leaf = WIDE * node + __builtin_ctz(in);
        float lo[WIDE], hi[WIDE];
        unsigned hit = section->fans->intervals(&section->leaves[leaf], q, lo, hi);
        for (; hit; hit &= hit - 1) {
            const int i = __builtin_ctz(hit);
            segment_before(alphas, q, WIDE * leaf + i, lo[i], hi[i]);
        }
    }
}

void lf_alphas_before(const lf_row_cut *alphas, lf_vec3 p, const lf_hit *on, int n, const float *c,
                      float *scale)
{
    if (alphas->section->rays.on) {
        lf_section_hide_by_rays(alphas, p, on, n, c, scale);
        return;
    }
    lf_question q = lf_section_ask(alphas, p, on, n, c, scale);
    if (!lf_question_narrow(&q))
        return;
    const lf_section *section = alphas->section;
    for (int root = 0; root < section->n_roots; root++)
        for (unsigned in = section->fans->meets(&section->roots[root], &q); in; in &= in - 1)
            node_before(alphas, WIDE * root + __builtin_ctz(in), &q);
}

/* ------------------------------------------------------------------------------- along a fan -- */

typedef struct line_fan {
    lf_lines lines;
    const float *z_end;
    float *through; /* NULL: only crossings are needed */
    bool *mirrors;
    lf_alpha_crossings *kept; /* NULL: not needed */
} line_fan;

static bool may_meet(const lf_section_node *node, int i, const line_fan *f)
{
    float d0 = node->d0[i], d1 = node->d1[i], first = f->lines.c[0],
          last = f->lines.c[f->lines.n - 1];
    float below = lf_min(lf_min(first * d0, first * d1), lf_min(last * d0, last * d1)),
          above = lf_max(lf_max(first * d0, first * d1), lf_max(last * d0, last * d1));
    return d1 > -LF_SECTION_FAR && node->s0[i] - f->lines.s0 <= above &&
           node->s1[i] - f->lines.s0 >= below;
}

/* Whether an opaque crossing lies in front of depth z. */
static bool is_hidden(const lf_alpha_crossings *ray, float z)
{
    return ray->n > 0 && ray->z[ray->n - 1] < z && !(ray->passes[ray->n - 1] > 0.0f);
}

static bool is_asked(const line_fan *f, int k, float z)
{
    if (!(z < f->z_end[k]))
        return false;
    if (f->through && f->through[k] > 0.0f)
        return true;
    return f->kept && f->kept[k].wanted && z >= f->kept[k].first && !is_hidden(&f->kept[k], z);
}

/* Rays that have its ends on different sides meet a segment, as in lf_section_nearest. */
static void segment_along(const lf_row_cut *alphas, int segment, const line_fan *f)
{
    const lf_section_leaf *leaf = &alphas->section->leaves[segment / WIDE];
    const int i = segment % WIDE;
    const float d0 = leaf->d0[i], d1 = leaf->d1[i], s0 = leaf->s0[i] - f->lines.s0,
                s1 = leaf->s1[i] - f->lines.s0;
    alpha v;
    bool is_loaded = false;
    for (int k = 0; k < f->lines.n; k++) {
        float c = f->lines.c[k], a = s0 - c * d0, b = s1 - c * d1;
        if ((a >= 0.0f) == (b >= 0.0f))
            continue;
        float d = d0 + (d1 - d0) * (a / (a - b)), z = lf_cut_depth(alphas->rig, d);
        if (!is_asked(f, k, z))
            continue;
        if (!is_loaded)
            v = alpha_of(alphas, segment);
        is_loaded = true;
        float passed = passes(alphas, &v.face, c, f->lines.s0 + c * d, d);
        if (f->kept)
            lf_alpha_keep(&f->kept[k], z, passed, segment);
        if (!f->through)
            continue;
        f->through[k] *= passed;
        f->mirrors[k] |= lf_has_mirror(v.face.material);
    }
}

static void leaf_along(const lf_row_cut *alphas, int leaf, const line_fan *f)
{
    for (int i = 0; i < WIDE; i++)
        if (alphas->section->leaves[leaf].d1[i] > -LF_SECTION_FAR)
            segment_along(alphas, WIDE * leaf + i, f);
}

static void all_along(const lf_row_cut *alphas, const line_fan *f)
{
    const lf_section *section = alphas->section;
    for (int root = 0; root < section->n_roots; root++)
        for (int i = 0; i < WIDE; i++) {
            const lf_section_node *inner = &section->nodes[WIDE * root + i];
            if (!may_meet(&section->roots[root], i, f))
                continue;
            for (int j = 0; j < WIDE; j++)
                if (may_meet(inner, j, f))
                    leaf_along(alphas, WIDE * (WIDE * root + i) + j, f);
        }
}

static void want_from_the_cameras_on(lf_alpha_crossings *ray)
{
    ray->first = 0.0f;
    ray->known = INFINITY;
    ray->n = ray->next = 0;
    ray->wanted = true;
}

void lf_alphas_along(const lf_row_cut *alphas, const lf_lines *lines, const float *z_end,
                     float *through, bool *mirrors, lf_alpha_crossings *kept)
{
    for (int k = 0; k < lines->n && kept; k++)
        want_from_the_cameras_on(&kept[k]);
    if (alphas->section->rays.on) {
        lf_section_alphas_by_rays(alphas, lines, z_end, through, mirrors, kept);
        return;
    }
    line_fan f = {.lines = *lines, .z_end = z_end, .kept = kept};
    f.through = through;
    f.mirrors = mirrors;
    all_along(alphas, &f);
}

/* ------------------------------------------------------------------------- depth after depth -- */

void lf_alpha_keep(lf_alpha_crossings *ray, float z, float passes, int segment)
{
    int i = ray->n;
    if (is_hidden(ray, z))
        return;
    while (i > 0 && ray->z[i - 1] > z)
        i--;
    if (i > 0 && ray->z[i - 1] == z) {
        ray->passes[i - 1] *= passes;
        return;
    }
    if (ray->n == LF_ALPHA_CROSSINGS_KEPT) {
        ray->known = lf_min(ray->known, i < ray->n ? ray->z[ray->n - 1] : z);
        if (i == ray->n)
            return;
        ray->n--;
    }
    for (int k = ray->n; k > i; k--) {
        ray->z[k] = ray->z[k - 1];
        ray->passes[k] = ray->passes[k - 1];
        ray->segment[k] = ray->segment[k - 1];
    }
    ray->z[i] = z;
    ray->passes[i] = passes;
    ray->segment[i] = segment;
    ray->n = passes > 0.0f ? ray->n + 1 : i + 1;
}

void lf_alphas_begin(lf_alpha_walk *walk, const lf_row_cut *alphas, const lf_lines *lines,
                     const float *z_end)
{
    walk->alphas = *alphas;
    walk->lines = *lines;
    walk->z_end = z_end;
    for (int k = 0; k < lines->n; k++) {
        lf_alpha_crossings *ray = &walk->ray[k];
        ray->first = ray->known = 0.0f;
        ray->n = ray->next = 0;
        ray->wanted = false;
    }
}

void lf_alphas_rewind(lf_alpha_walk *walk)
{
    for (int k = 0; k < walk->lines.n; k++) {
        lf_alpha_crossings *ray = &walk->ray[k];
        ray->next = 0;
        if (ray->first > 0.0f) {
            ray->first = ray->known = 0.0f;
            ray->n = 0;
        }
    }
}

/* Finds the next crossings of all rays that need them. */
static void look_farther(lf_alpha_walk *walk)
{
    const lf_row_cut *alphas = &walk->alphas;
    for (int k = 0; k < walk->lines.n; k++) {
        lf_alpha_crossings *ray = &walk->ray[k];
        if (!ray->wanted)
            continue;
        ray->first = ray->known;
        ray->known = INFINITY;
        ray->n = ray->next = 0;
    }
    if (alphas->section->rays.on) {
        lf_section_crossings_by_rays(alphas, &walk->lines, walk->z_end, walk->ray);
        return;
    }
    const line_fan f = {.lines = walk->lines, .z_end = walk->z_end, .kept = walk->ray};
    all_along(alphas, &f);
}

/* Counts the known crossings in front of z; true: there may be more of them. */
static bool count(lf_alpha_crossings *ray, float z, float *through)
{
    for (; ray->next < ray->n && ray->z[ray->next] < z; ray->next++)
        *through *= ray->passes[ray->next];
    return ray->known < z && *through != 0.0f;
}

void lf_alphas_to(lf_alpha_walk *walk, const float *z, float *through)
{
    bool more = true;
    while (more) {
        more = false;
        for (int k = 0; k < walk->lines.n; k++)
            more |= walk->ray[k].wanted = count(&walk->ray[k], z[k], &through[k]);
        if (more)
            look_farther(walk);
    }
}
