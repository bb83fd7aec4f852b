#include "render/import/scene/mesh_doubles.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/transport/sampler.h"

/* All meshes' triangles, numbered through. */
typedef struct search {
    lf_mesh_data *data;
    int n;
    const double *origin;
    double per_unit; /* steps of the grid that corners are rounded to */
    uint32_t *first; /* [n + 1] number of a mesh's first triangle */
    /* [mask + 1] hash table of triangles that stay: upper half of the hash, number + 1; 0 = free */
    uint64_t *slots;
    uint64_t mask;
    bool *doubled;    /* [triangles] */
    int64_t compared; /* pairs of triangles */
} search;

/* In steps of the grid, in rising order, and without -0. */
typedef struct corners {
    double p[3][3];
} corners;

static int mesh_of(const search *s, uint32_t triangle)
{
    int low = 0, high = s->n - 1;
    while (low < high) {
        int middle = (low + high + 1) / 2;
        if (s->first[middle] <= triangle)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

static void swap_if_above(double a[3], double b[3])
{
    double swap[3];
    int i = 0;
    while (i < 2 && a[i] == b[i])
        i++;
    if (!(a[i] > b[i]))
        return;
    memcpy(swap, a, sizeof swap);
    memcpy(a, b, sizeof swap);
    memcpy(b, swap, sizeof swap);
}

/* Coordinate of a triangle's corner; for moving meshes at an arbitrary fixed time, so that corners
 * that coincide then coincide always. */
static double place_of(const lf_mesh_data *data, size_t number)
{
    const double moment = 0.3819660113;
    double open = data->positions[number];
    return data->close.positions ? open + moment * (data->close.positions[number] - open) : open;
}

static corners corners_of(const search *s, uint32_t triangle)
{
    int mesh = mesh_of(s, triangle);
    const lf_mesh_data *data = &s->data[mesh];
    const uint32_t *corner = data->triangles + 3 * (size_t)(triangle - s->first[mesh]);
    corners out;
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 3; i++)
            out.p[c][i] =
                nearbyint((place_of(data, 3 * (size_t)corner[c] + (size_t)i) - s->origin[i]) *
                          s->per_unit) +
                0.0;
    swap_if_above(out.p[0], out.p[1]);
    swap_if_above(out.p[1], out.p[2]);
    swap_if_above(out.p[0], out.p[1]);
    return out;
}

/* seed: of meshes that are compared */
static uint64_t hash(const corners *c, uint64_t seed)
{
    uint64_t bits[9], h = seed;
    memcpy(bits, c->p, sizeof bits);
    for (int i = 0; i < 9; i++)
        h = (h ^ h >> 32 ^ bits[i]) * 0x9e3779b97f4a7c15u;
    return lf_hash64(h, 0);
}

/* Group of meshes that may coincide: 0 for all except instanced ones, which are compared only with
 * themselves. */
static uint64_t company_of(const search *s, int mesh)
{
    return s->data[mesh].n_instances > 0 ? (uint64_t)mesh + 1 : 0;
}

/* The kept triangle with the same corners, or UINT32_MAX: then this one is kept. No two kept
 * triangles have the same corners and group, so that a search does not grow with the number of
 * duplicates. */
static uint32_t find_or_keep(search *s, uint32_t triangle)
{
    uint64_t company = company_of(s, mesh_of(s, triangle));
    corners own = corners_of(s, triangle);
    uint64_t h = hash(&own, company), at = h & s->mask, tag = h >> 32 << 32;
    for (; s->slots[at] != 0; at = (at + 1) & s->mask) {
        uint32_t other = (uint32_t)s->slots[at] - 1;
        if ((s->slots[at] & ~(uint64_t)UINT32_MAX) != tag)
            continue;
        corners there = corners_of(s, other);
        s->compared++;
        if (memcmp(&own, &there, sizeof own) == 0 && company_of(s, mesh_of(s, other)) == company)
            return other;
    }
    s->slots[at] = tag | (triangle + 1);
    return UINT32_MAX;
}

/* Marks duplicates, with one warning per mesh. */
static void mark(search *s, const char *where)
{
    for (int i = 0; i < s->n; i++) {
        uint32_t count = 0, other = UINT32_MAX;
        /* Parts have separate spaces, so they are skipped. */
        for (uint32_t t = s->first[i]; t < s->first[i + 1] && s->data[i].n_parts == 0; t++) {
            uint32_t found = find_or_keep(s, t);
            s->doubled[t] = found != UINT32_MAX;
            count += s->doubled[t];
            other = other == UINT32_MAX ? found : other;
        }
        if (count > 0)
            lf_warnings_add(
                &s->data[i].warnings, where,
                "mesh \"%s\": %u of its triangles %s left out because \"%s\" has the same",
                s->data[i].name, count, count == 1 ? "is" : "are", s->data[mesh_of(s, other)].name);
    }
}

static void compact(lf_mesh_data *data, const bool *doubled)
{
    int kept = 0;
    for (int t = 0; t < data->n_triangles; t++) {
        if (doubled[t])
            continue;
        memmove(data->triangles + 3 * (size_t)kept, data->triangles + 3 * (size_t)t,
                3 * sizeof *data->triangles);
        if (data->triangle_material)
            data->triangle_material[kept] = data->triangle_material[t];
        kept++;
    }
    data->n_triangles = kept;
}

/* A grid 2^40 times finer than the scene's size: far above the rounding of transforms, far below
 * any detail. */
static double steps_per_unit(const lf_mesh_data *data, int n, const double origin[3])
{
    double largest = 0.0;
    for (int i = 0; i < n; i++)
        for (size_t k = 0; k < 3 * (size_t)data[i].n_vertices; k++)
            largest = fmax(largest, fabs(data[i].positions[k] - origin[k % 3]));
    return largest > 0.0 ? exp2(40.0 - ceil(log2(largest))) : 1.0;
}

lf_status lf_mesh_drop_doubles(lf_mesh_data *data, int n, const double origin[3], const char *where,
                               int64_t *out_compared)
{
    search s = {.data = data,
                .n = n,
                .origin = origin,
                .per_unit = steps_per_unit(data, n, origin),
                .mask = 1};
    s.first = lf_calloc((size_t)n + 1, sizeof *s.first);
    for (int i = 0; s.first && i < n; i++)
        s.first[i + 1] = s.first[i] + (uint32_t)data[i].n_triangles;
    while (s.first && s.mask < (uint64_t)s.first[n] + s.first[n] / 3)
        s.mask = 2 * s.mask + 1;
    s.slots = lf_calloc(s.mask + 1, sizeof *s.slots);
    s.doubled = s.first ? lf_calloc(s.first[n], sizeof *s.doubled) : NULL;
    bool ok = s.first && s.slots && s.doubled;
    if (ok)
        mark(&s, where);
    for (int i = 0; ok && i < n; i++)
        compact(&data[i], s.doubled + s.first[i]);
    lf_free(s.first);
    lf_free(s.slots);
    lf_free(s.doubled);
    if (out_compared)
        *out_compared = s.compared;
    return ok ? LF_OK : LF_E_NOMEM;
}
