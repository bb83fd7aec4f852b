#include "render/rows/outlines.h"

#include <string.h>

#include "base/alloc.h"

lf_status lf_outlines_init(lf_outlines *out, const lf_row_triangles *rows, bool has_alphas,
                           const lf_film_layout *layout)
{
    const size_t columns = (size_t)layout->width;
    out->groups = lf_calloc(columns, sizeof *out->groups);
    out->views = lf_calloc(columns * (size_t)layout->n_views, sizeof *out->views);
    if (!out->groups || !out->views)
        return LF_E_NOMEM;
    lf_status status = lf_section_init(&out->edge, rows->longest, rows->n_instances);
    return status == LF_OK
               ? lf_section_init(&out->alphas, has_alphas ? rows->longest : 0, rows->n_instances)
               : status;
}

void lf_outlines_finish(lf_outlines *outlines)
{
    lf_section_finish(&outlines->edge);
    lf_section_finish(&outlines->alphas);
    lf_free(outlines->groups);
    lf_free(outlines->views);
}

/* ----------------------------------------------------------------------------------- the map -- */

enum { NOT_LOOKED_AT, NONE, SOME };

lf_status lf_outline_map_init(lf_outline_map *out, const lf_film_layout *layout)
{
    const size_t rows = (size_t)layout->height,
                 pixels = (size_t)layout->width * (size_t)layout->n_views;
    out->words = (pixels + 31) / 32;
    out->bits = lf_calloc(rows * out->words, sizeof *out->bits);
    out->found = lf_calloc(rows, sizeof *out->found);
    return out->bits && out->found ? LF_OK : LF_E_NOMEM;
}

void lf_outline_map_finish(lf_outline_map *map)
{
    lf_free(map->bits);
    lf_free(map->found);
    *map = (lf_outline_map){0};
}

/* The groups of these views. */
static uint32_t groups_of(const bool *views, int n)
{
    uint32_t out = 0;
    for (int k = 0; k < n; k++)
        out |= (uint32_t)views[k] << (k / LF_LANES);
    return out;
}

static void keep(const lf_outline_map *map, int row, size_t pixels, const lf_outlines *of, bool any)
{
    uint32_t *bits = map->bits + (size_t)row * map->words;
    for (size_t i = 0; i < pixels && any; i++)
        bits[i / 32] |= (uint32_t)of->views[i] << (i % 32);
    map->found[row] = any ? SOME : NONE;
}

static bool recall(const lf_outline_map *map, int row, const lf_rig *rig, lf_outlines *out)
{
    const uint32_t *bits = map->bits + (size_t)row * map->words;
    const size_t views = (size_t)rig->n_views, pixels = (size_t)rig->width * views;
    for (size_t i = 0; i < pixels && map->found[row] == SOME; i++)
        out->views[i] = bits[i / 32] >> (i % 32) & 1;
    for (size_t column = 0; column < (size_t)rig->width && map->found[row] == SOME; column++)
        out->groups[column] = groups_of(out->views + column * views, rig->n_views);
    return map->found[row] == SOME;
}

/* -------------------------------------------------------------------------- finding outlines -- */

#define NO_TRIANGLE UINT32_MAX

/* Hits of a corner's rays. */
typedef struct corner {
    int material[LF_MAX_LANES];
    uint32_t triangle[LF_MAX_LANES]; /* NO_TRIANGLE: not known, or none */
    float nearness[LF_MAX_LANES];
    float through[LF_MAX_LANES]; /* transmittance of alpha surfaces */
} corner;

/* An edge of the row, upper or lower: the sections cut by its plane. */
enum { EDGES = 2 };
typedef struct row_edge {
    lf_row_plane plane;
    lf_section *section, *alphas; /* alpha surfaces: NULL if there are none */
} row_edge;

static void cut_edge(const lf_visit *visit, int edge, row_edge *out)
{
    static const float no_lens[2] = {0.5f, 0.5f};
    const bool has_alphas = lf_has(visit->scene, LF_TRAITS_SEEN_THROUGH);
    lf_scratch *w = visit->worker;
    out->section = edge == 0 ? &w->section : &w->met.outlines.edge;
    out->alphas = edge == 0 ? &w->alpha.section : &w->met.outlines.alphas;
    lf_rig_row_plane(visit->rig, (float)(visit->row + edge), no_lens, &out->plane);
    lf_section_cut(out->section, visit->triangles, visit->scene, visit->rig, visit->row,
                   &out->plane, has_alphas ? LF_CUT_OPAQUE : LF_CUT_ALL);
    if (has_alphas)
        lf_section_cut(out->alphas, visit->triangles, visit->scene, visit->rig, visit->row,
                       &out->plane, LF_CUT_ALPHAS);
    else
        out->alphas = NULL;
}

/* comparable: triangles from this number on are not identified. */
static void look(const lf_visit *visit, const row_edge *edge, int column, uint32_t comparable,
                 corner *out)
{
    const lf_rig *rig = visit->rig;
    lf_scratch *w = visit->worker;
    const int lanes = lf_rig_lanes(rig);
    const float s = (rig->x0 + (float)column * rig->dx) / rig->distance;
    lf_row_cut cut = {edge->section, visit->triangles, visit->scene, rig, &edge->plane};
    const lf_lines lines = {s, lanes, rig->b};
    lf_section_nearest(&cut, &lines, w->z_end, w->met.segment);
    for (int k = 0; k < lanes; k++)
        out->through[k] = 1.0f;
    if (edge->alphas) {
        cut.section = edge->alphas;
        lf_alphas_along(&cut, &lines, w->z_end, out->through, w->alpha.mirrored, NULL);
    }
    for (int k = 0; k < rig->n_views; k++) {
        const int segment = w->met.segment[k];
        const uint32_t triangle =
            segment < 0 ? NO_TRIANGLE : lf_section_triangle(edge->section, segment);
        out->material[k] = segment < 0 ? -1 : lf_section_material(edge->section, segment);
        out->triangle[k] = triangle < comparable ? triangle : NO_TRIANGLE;
        out->nearness[k] = lf_nearness(rig->distance, w->z_end[k]);
    }
}

/* Marks the views whose rays at two corners meet other surfaces, depths that no surface between
 * could have (unless it is one triangle), or very different transmittances of alpha surfaces. */
static void mark_torn(const lf_rig *rig, const corner *a, const corner *b, bool *out)
{
    const float steepest = 3.0f, apart = steepest * rig->dx / rig->distance, most_alpha = 0.25f;
    for (int k = 0; k < rig->n_views; k++)
        out[k] |= (a->material[k] != b->material[k]) |
                  ((fabsf(a->nearness[k] - b->nearness[k]) > apart) &
                   !(a->triangle[k] == b->triangle[k] && a->triangle[k] != NO_TRIANGLE)) |
                  (fabsf(a->through[k] - b->through[k]) > most_alpha);
}

/* Two corners on one triangle have no outline between them. Exception: a ground seen at a low angle
 * varies within a pixel, and under suns it has shadow edges. */
static uint32_t comparable_triangles(const lf_visit *visit)
{
    const bool suns =
        visit->plan->order.sunlight && lf_sunlight_has_suns(visit->plan->order.sunlight);
    return suns ? 0 : visit->triangles->mesh_start[visit->scene->n_meshes];
}

static bool look_at_row(const lf_visit *visit)
{
    const lf_rig *rig = visit->rig;
    const size_t views = (size_t)rig->n_views;
    lf_outlines *outlines = &visit->worker->met.outlines;
    const uint32_t comparable = comparable_triangles(visit);
    uint32_t any = 0;
    corner at[2][EDGES];
    row_edge edges[EDGES];
    bool between[2][LF_MAX_LANES]; /* of the upper corner and of the lower one */
    memset(at, 0, sizeof at);
    for (int edge = 0; edge < EDGES; edge++)
        cut_edge(visit, edge, &edges[edge]);
    for (int column = 0; column <= rig->width; column++) {
        corner *here = at[column % 2], *last = at[(column + 1) % 2];
        bool *now = between[column % 2], *before = between[(column + 1) % 2];
        for (int edge = 0; edge < EDGES; edge++)
            look(visit, &edges[edge], column, comparable, &here[edge]);
        memset(now, 0, views * sizeof *now);
        mark_torn(rig, &here[0], &here[1], now);
        if (column == 0)
            continue;
        bool *view = outlines->views + (size_t)(column - 1) * views;
        for (int k = 0; k < rig->n_views; k++)
            view[k] = before[k] | now[k];
        for (int edge = 0; edge < EDGES; edge++)
            mark_torn(rig, &last[edge], &here[edge], view);
        outlines->groups[column - 1] = groups_of(view, rig->n_views);
        any |= outlines->groups[column - 1];
    }
    return any != 0;
}

bool lf_outlines_find(const lf_visit *visit)
{
    const lf_outline_map *map = &visit->plan->outlines;
    lf_outlines *outlines = &visit->worker->met.outlines;
    if (map->found && map->found[visit->row] != NOT_LOOKED_AT)
        return recall(map, visit->row, visit->rig, outlines);
    const bool any = look_at_row(visit);
    if (map->found)
        keep(map, visit->row, (size_t)visit->rig->width * (size_t)visit->rig->n_views, outlines,
             any);
    return any;
}

/* ------------------------------------------------------------------------- their film points -- */

/* Sums over a pixel's film points. */
typedef struct lf_unscattered_pixel {
    float q, known[3], albedo[LF_ALBEDO_NUMBERS];
    lf_feature feature;
    bool mirror;
} lf_unscattered_pixel;

static void take_pixel(const lf_visit *visit, size_t i, lf_unscattered_pixel *out)
{
    const lf_film_sums *sums = &visit->sums;
    *out = (lf_unscattered_pixel){.q = sums->half.q[i], .feature = sums->feature[i]};
    if (sums->known)
        memcpy(out->known, sums->known[i], sizeof out->known);
    if (sums->albedo)
        memcpy(out->albedo, sums->albedo[i], sizeof out->albedo);
    if (visit->worker->mirrors)
        out->mirror = visit->worker->mirrors[i];
}

/* The mean of a pixel's new and old values; the old one has weight n. */
static void mix_pixel(const lf_visit *visit, size_t i, const lf_unscattered_pixel *had, float n)
{
    const lf_film_sums *sums = &visit->sums;
    const float share = 1.0f / (n + 1.0f), now = lf_max(share * sums->half.q[i], 0.0f),
                before = lf_max((1.0f - share) * had->q, 0.0f);
    if (now + before > 0.0f) {
        sums->feature[i] =
            lf_feature_mix(&sums->feature[i], (double)now, &had->feature, (double)before);
        for (int c = 0; c < LF_ALBEDO_NUMBERS && sums->albedo; c++)
            sums->albedo[i][c] = lf_lerp(had->albedo[c], sums->albedo[i][c], now / (now + before));
    }
    sums->half.q[i] = lf_lerp(had->q, sums->half.q[i], share);
    for (int c = 0; c < 3 && sums->known; c++)
        sums->known[i][c] = lf_lerp(had->known[c], sums->known[i][c], share);
    if (visit->worker->mirrors)
        visit->worker->mirrors[i] |= had->mirror;
}

/* Takes one more film point for each of the views [first, end) of a column that needs it and has
 * had n. */
static void take_point(const lf_unscattered *e, int column, int first, int end, int n)
{
    const lf_visit *visit = e->visit;
    const size_t width = (size_t)visit->rig->width;
    lf_unscattered_pixel had[LF_MAX_LANES];
    const int there = end < visit->rig->n_views ? end : visit->rig->n_views;
    for (int k = first; k < there; k++)
        if (e->only[k])
            take_pixel(visit, (size_t)k * width + (size_t)column, &had[k - first]);
    lf_unscattered_fan(e, column, first, end);
    for (int k = first; k < there; k++)
        if (e->only[k])
            mix_pixel(visit, (size_t)k * width + (size_t)column, &had[k - first], (float)n);
}

/* -------------------------------------------------------------------------------- the planes -- */

enum { FIRST_PLANES = 4 };

int lf_outlines_planes(uint32_t index)
{
    if (index >= LF_OUTLINE_VISITS)
        return 1;
    return index < 2 ? FIRST_PLANES : 2;
}

/* x moved into the quarter in which the first two visits' point lies that is in the other half. */
static float across_from(float x, const float first[2])
{
    const int half = (int)(2.0f * x);
    const float other = (int)(2.0f * first[0]) != half ? first[0] : first[1];
    return 0.25f * (floorf(4.0f * other) + (4.0f * x - floorf(4.0f * x)));
}

/* x and how many quarters farther, from the end to the beginning. */
static float quarters_on(float x, int quarters)
{
    const float sum = x + 0.25f * (float)quarters;
    return sum < 1.0f ? sum : sum - 1.0f;
}

/* Order across the pixel, chosen so that the first visit's film points do not lie on a line. */
static const int quarters_across[FIRST_PLANES] = {0, 2, 1, 3};

float lf_outlines_row(uint64_t offsets, uint32_t index, int plane)
{
    const float own = lf_sampler_radical(offsets, index);
    if (plane == 0 || index < 2)
        return quarters_on(own, plane);
    const float first[2] = {lf_sampler_radical(offsets, 0), lf_sampler_radical(offsets, 1)};
    return across_from(own, first);
}

float lf_outlines_column(uint64_t key, int column, uint32_t index, int plane)
{
    const float own = lf_unscattered_film_point(key, column, index);
    if (plane == 0 || index < 2)
        return quarters_on(own, quarters_across[plane]);
    const float first[2] = {lf_unscattered_film_point(key, column, 0),
                            lf_unscattered_film_point(key, column, 1)};
    return across_from(own, first);
}

float lf_outlines_lens(uint64_t key, int column, uint32_t index, int plane)
{
    const uint64_t sequence = lf_hash64(lf_hash64(key, 10), (uint64_t)column);
    const float own = lf_sampler_radical(sequence, index);
    if (plane == 0 || index < 2)
        return quarters_on(own, quarters_across[plane]);
    const float first[2] = {lf_sampler_radical(sequence, 0), lf_sampler_radical(sequence, 1)};
    return across_from(own, first);
}

void lf_outlines_take(lf_unscattered *e, int plane)
{
    const lf_rig *rig = e->visit->rig;
    const lf_outlines *outlines = &e->visit->worker->met.outlines;
    e->plane = plane;
    for (int column = 0; column < rig->width; column++) {
        uint32_t groups = outlines->groups[column];
        e->only = outlines->views + (size_t)column * (size_t)rig->n_views;
        for (int first, end;
             groups && lf_unscattered_next_groups(&groups, rig->n_views, &first, &end);)
            take_point(e, column, first, end, plane);
    }
    e->plane = 0;
    e->only = NULL;
}
