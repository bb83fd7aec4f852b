#include "render/import/scene/mesh_take.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "render/import/scene/instances_import.h"
#include "render/scene/vec_double.h"
#include "render/transport/surface/surface.h"

/* Rounding of a unit vector, with room; and how far from across a normal a tangent may lie. */
#define UNIT_SLACK 1e-3f
#define ACROSS_SLACK 1e-2f
/* Half of a spot's cone, radians. */
#define MOST_OUTER 1.5708

static lf_status no_memory(lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, "", "out of memory");
}

static bool within(float x, double low, double high)
{
    return (double)x >= low && (double)x <= high; /* false for NaN */
}

/* ---------------------------------------------------------------------------------- sections -- */

/* Copies a section of n elements of `each` bytes; *out stays NULL if there is none. */
static lf_status copy(const lf_parcel *parcel, lf_parcel_tag tag, size_t n, size_t each, void *out,
                      lf_error *err)
{
    size_t count;
    const void *data = lf_parcel_get(parcel, tag, &count);
    if (!data)
        return LF_OK;
    void *own = lf_calloc(n, each);
    if (!own)
        return no_memory(err);
    memcpy(own, data, n * each);
    *(void **)out = own;
    return LF_OK;
}

static size_t count_of(const lf_parcel *parcel, lf_parcel_tag tag)
{
    size_t n;
    (void)lf_parcel_get(parcel, tag, &n);
    return n;
}

/* Checks vertex data for materials. */
static bool looks_fit(const lf_parcel *parcel, size_t n_vertices, lf_mesh_asked asked)
{
    size_t uvs = count_of(parcel, LF_PARCEL_UVS), colours = count_of(parcel, LF_PARCEL_COLOURS),
           tangents = count_of(parcel, LF_PARCEL_TANGENTS),
           pictures = count_of(parcel, LF_PARCEL_PICTURES),
           texels = count_of(parcel, LF_PARCEL_TEXELS);
    if (!asked.materials && colours + tangents + pictures + texels + (asked.uvs ? 0 : uvs) > 0)
        return false;
    return uvs % (2 * n_vertices) == 0 && uvs / (2 * n_vertices) <= LF_UV_SETS &&
           (colours == 0 || colours == 4 * n_vertices) &&
           (tangents == 0 || tangents == 4 * n_vertices) && pictures <= LF_MAX_PICTURES;
}

/* Whether the sections fit together. */
static bool counts_fit(const lf_parcel *parcel, lf_mesh_asked asked)
{
    size_t positions = count_of(parcel, LF_PARCEL_POSITIONS),
           normals = count_of(parcel, LF_PARCEL_NORMALS),
           triangles = count_of(parcel, LF_PARCEL_TRIANGLES),
           choices = count_of(parcel, LF_PARCEL_CHOICES),
           kinds = count_of(parcel, LF_PARCEL_MATERIALS),
           scalars = count_of(parcel, LF_PARCEL_SCALARS);
    return positions > 0 && positions % 3 == 0 && positions / 3 <= 3 * (size_t)LF_MAX_TRIANGLES &&
           triangles > 0 && triangles % 3 == 0 && triangles / 3 <= LF_MAX_TRIANGLES &&
           (normals == 0 || normals == positions) &&
           (asked.materials ? kinds > 0 && kinds <= LF_MAX_MATERIALS && choices == triangles / 3
                            : kinds == 0 && choices == 0) &&
           scalars == LF_PRINCIPLED_FLOATS * kinds && looks_fit(parcel, positions / 3, asked);
}

/* --------------------------------------------------------------------------------- materials -- */

static const lf_surface_kind *kind_at(uint32_t place)
{
    const lf_surface_kind *const *kind = lf_surface_kinds;
    for (uint32_t i = 0; *kind && i < place; i++)
        kind++;
    return *kind;
}

/* Values that only scene files can set have their defaults: interior media, and priority. */
static bool says_what_files_say(const lf_principled *p)
{
    static const lf_param *const rows[] = {
        &lf_principled_scattering, &lf_principled_g, &lf_principled_subsurface,
        &lf_principled_subsurface_radius, &lf_principled_priority};
    lf_principled said = *p, usual = lf_principled_usual();
    bool same = true;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        int n;
        const float *a = lf_principled_at(&said, rows[i], &n);
        same = same && memcmp(a, lf_principled_at(&usual, rows[i], &n), (size_t)n * sizeof *a) == 0;
    }
    return same;
}

static bool take_material(const lf_parcel_material *from, const float scalars[], lf_material *out)
{
    *out = (lf_material){.kind = kind_at(from->kind),
                         .cover = from->cover < LF_COVERS ? (lf_cover)from->cover : LF_COVER_OPAQUE,
                         .is_solid = from->is_solid == 1,
                         .tint = from->emits_by_colours == 1 ? LF_TINT_ALL : LF_TINT_ALBEDO};
    memcpy(&out->p, scalars, sizeof out->p);
    return out->kind && from->cover < LF_COVERS && from->is_solid <= 1 &&
           from->emits_by_colours <= 1 && !lf_principled_wrong(&out->p) &&
           says_what_files_say(&out->p);
}

static bool take_texture(const lf_parcel_texture *from, const lf_mesh_data *data, lf_texture *out)
{
    if (from->picture == 0)
        return true;
    if (from->picture > (uint32_t)data->n_pictures || from->wrap_u >= LF_WRAPS ||
        from->wrap_v >= LF_WRAPS || from->set >= (uint32_t)data->n_uv_sets || from->nearest > 1 ||
        from->finest > 1 || !within(from->scale, -(double)LF_MAX_UV, (double)LF_MAX_UV))
        return false;
    for (int i = 0; i < 6; i++)
        if (!within(from->map[i / 3][i % 3], -(double)LF_MAX_UV, (double)LF_MAX_UV))
            return false;
    *out = (lf_texture){.picture = from->picture,
                        .wrap_u = (uint8_t)from->wrap_u,
                        .wrap_v = (uint8_t)from->wrap_v,
                        .set = (uint8_t)from->set,
                        .nearest = from->nearest == 1,
                        .finest = from->finest == 1,
                        .scale = from->scale};
    memcpy(out->map, from->map, sizeof out->map);
    return true;
}

static bool has_texture(const lf_parcel_material *from, size_t n)
{
    for (size_t i = 0; i < n; i++)
        for (int s = 0; s < LF_SLOTS; s++)
            if (from[i].texture[s].picture > 0)
                return true;
    return false;
}

/* Images are taken already. */
static lf_status take_materials(const lf_parcel *parcel, lf_mesh_data *out, lf_error *err)
{
    _Static_assert(sizeof((lf_parcel_material *)0)->name == LF_MATERIAL_NAME, "names fit");
    _Static_assert(LF_SLOTS == sizeof((lf_parcel_material *)0)->texture / sizeof(lf_parcel_texture),
                   "a texture for every slot");
    size_t n;
    const lf_parcel_material *from = lf_parcel_get(parcel, LF_PARCEL_MATERIALS, &n);
    const float *scalars = lf_parcel_get(parcel, LF_PARCEL_SCALARS, &(size_t){0});
    if (n == 0)
        return LF_OK;
    out->materials = lf_calloc(n, sizeof *out->materials);
    if (!out->materials)
        return no_memory(err);
    out->n_materials = (int)n;
    out->names = lf_calloc(n, sizeof *out->names);
    if (!out->names)
        return no_memory(err);
    if (has_texture(from, n)) {
        out->textures = lf_calloc(n, sizeof *out->textures);
        if (!out->textures)
            return no_memory(err);
    }
    for (size_t i = 0; i < n; i++) {
        bool fits =
            take_material(&from[i], scalars + i * LF_PRINCIPLED_FLOATS, &out->materials[i]) &&
            memchr(from[i].name, 0, sizeof from[i].name);
        memcpy(out->names[i], from[i].name, sizeof out->names[i]);
        for (int s = 0; s < LF_SLOTS && fits && out->textures; s++)
            fits = take_texture(&from[i].texture[s], out, &out->textures[i].slot[s]);
        if (!fits)
            return lf_error_set(err, LF_E_FORMAT, "",
                                "the reader's answer has an invalid material");
    }
    return LF_OK;
}

/* ------------------------------------------------------------------------------------ images -- */

/* Whether the images' sizes are valid, and the number of texels matches. */
static bool sizes_fit(const lf_parcel_picture *sizes, size_t n, size_t n_texels)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < n; i++) {
        const lf_parcel_picture *p = &sizes[i];
        if (p->width < 1 || p->width > LF_IMAGE_MAX_SIDE || p->height < 1 ||
            p->height > LF_IMAGE_MAX_SIDE)
            return false;
        sum += (uint64_t)4 * p->width * p->height; /* no overflow: LF_MAX_PICTURES of 2^34 */
    }
    return sum == n_texels;
}

lf_status lf_mesh_take_pictures(const lf_parcel *parcel, lf_mesh_data *out, lf_error *err)
{
    size_t n, n_texels;
    const lf_parcel_picture *sizes = lf_parcel_get(parcel, LF_PARCEL_PICTURES, &n);
    const uint8_t *texels = lf_parcel_get(parcel, LF_PARCEL_TEXELS, &n_texels);
    if (!sizes_fit(sizes, n, n_texels))
        return lf_error_set(err, LF_E_FORMAT, "", "the reader's answer has invalid textures");
    if (n == 0)
        return LF_OK;
    out->pictures = lf_calloc(n, sizeof *out->pictures);
    if (!out->pictures)
        return no_memory(err);
    for (size_t i = 0; i < n; i++) {
        size_t size = (size_t)4 * sizes[i].width * sizes[i].height;
        uint8_t *rgba = lf_calloc(size, 1);
        if (!rgba)
            return no_memory(err);
        memcpy(rgba, texels, size);
        texels += size;
        out->pictures[out->n_pictures++] =
            (lf_texels){(int)sizes[i].width, (int)sizes[i].height, rgba};
    }
    return LF_OK;
}

/* ---------------------------------------------------------------------------------- vertices -- */

static bool positions_fit(const lf_mesh_data *data)
{
    for (size_t i = 0; i < 3 * (size_t)data->n_vertices; i++)
        if (!(fabs(data->positions[i]) <= LF_MAX_COORDINATE))
            return false;
    return true;
}

static bool triangles_fit(const lf_mesh_data *data)
{
    for (size_t i = 0; i < 3 * (size_t)data->n_triangles; i++)
        if (data->triangles[i] >= (uint32_t)data->n_vertices)
            return false;
    for (int i = 0; data->triangle_material && i < data->n_triangles; i++)
        if (data->triangle_material[i] >= data->n_materials)
            return false;
    return true;
}

static float dot(const float *a, const float *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool is_unit(const float *v)
{
    return fabsf(dot(v, v) - 1.0f) <= UNIT_SLACK; /* false for NaN */
}

/* Checks the tangents that are used: at corners of triangles. */
static bool frames_fit(const lf_mesh_data *data)
{
    for (size_t i = 0; i < 3 * (size_t)data->n_triangles; i++) {
        size_t v = data->triangles[i];
        const float *n = data->normals ? data->normals + 3 * v : NULL,
                    *t = data->tangents ? data->tangents + 4 * v : NULL;
        if ((n && !is_unit(n)) || (t && (!is_unit(t) || fabsf(t[3]) != 1.0f)) ||
            (n && t && fabsf(dot(n, t)) > ACROSS_SLACK))
            return false;
    }
    return true;
}

static bool all_within(const float *values, size_t n, float low, float high)
{
    for (size_t i = 0; i < n; i++)
        if (!(values[i] >= low && values[i] <= high))
            return false;
    return true;
}

static bool looks_are_sound(const lf_mesh_data *data)
{
    size_t n = (size_t)data->n_vertices;
    return all_within(data->uvs, 2 * n * (size_t)data->n_uv_sets, -LF_MAX_UV, LF_MAX_UV) &&
           all_within(data->colours, data->colours ? 4 * n : 0, 0.0f, 1.0f);
}

static lf_status take_vertices(const lf_parcel *parcel, lf_mesh_data *out, lf_error *err)
{
    const size_t n = (size_t)out->n_vertices, sets = (size_t)out->n_uv_sets;
    const struct {
        lf_parcel_tag tag;
        size_t each;
        void *out;
    } sections[] = {{LF_PARCEL_POSITIONS, 3 * sizeof(double), &out->positions},
                    {LF_PARCEL_NORMALS, 3 * sizeof(float), &out->normals},
                    {LF_PARCEL_UVS, 2 * sets * sizeof(float), &out->uvs},
                    {LF_PARCEL_COLOURS, 4 * sizeof(float), &out->colours},
                    {LF_PARCEL_TANGENTS, 4 * sizeof(float), &out->tangents}};
    lf_status status = LF_OK;
    for (size_t i = 0; i < sizeof sections / sizeof *sections && status == LF_OK; i++)
        status = copy(parcel, sections[i].tag, n, sections[i].each, sections[i].out, err);
    return status;
}

static lf_status take_span(const lf_parcel *parcel, lf_mesh_data *out, lf_error *err)
{
    size_t n;
    const double *span = lf_parcel_get(parcel, LF_PARCEL_SPAN, &n);
    if (n > 1 || (n == 1 && !(*span > 0 && *span <= LF_MAX_SECONDS)))
        return lf_error_set(err, LF_E_FORMAT, "", "the reader's answer has an invalid animation");
    out->span = n == 1 ? *span : 0;
    return LF_OK;
}

/* ------------------------------------------------------------------------------------ lights -- */

/* false: a field that its kind uses is out of range. */
static bool take_light(const lf_parcel_light *from, lf_punctual *out)
{
    double length2 = 0;
    bool fits = from->kind < LF_PUNCTUAL_KINDS;
    *out = (lf_punctual){
        .kind = (lf_punctual_kind)from->kind, .outer = from->outer, .inner = from->inner};
    for (int i = 0; i < 3; i++) {
        out->position[i] = from->position[i];
        out->direction[i] = from->direction[i];
        out->intensity[i] = from->intensity[i];
        length2 += from->direction[i] * from->direction[i];
        fits = fits && fabs(from->position[i]) <= LF_MAX_COORDINATE && from->intensity[i] >= 0 &&
               from->intensity[i] <= LF_MAX_RADIANCE;
    }
    if (from->kind != LF_PUNCTUAL_POINT)
        fits = fits && fabs(length2 - 1) <= (double)UNIT_SLACK;
    if (from->kind == LF_PUNCTUAL_SPOT)
        fits = fits && from->outer > 0 && from->outer <= MOST_OUTER && from->inner >= 0 &&
               from->inner <= from->outer;
    return fits;
}

static lf_status take_lights(const lf_parcel *parcel, lf_mesh_data *out, lf_error *err)
{
    size_t n;
    const lf_parcel_light *from = lf_parcel_get(parcel, LF_PARCEL_LIGHTS, &n);
    bool fits = n <= LF_MAX_PUNCTUAL;
    if (n == 0)
        return LF_OK;
    out->lights.open = lf_calloc(fits ? n : 1, sizeof *out->lights.open);
    if (!out->lights.open)
        return no_memory(err);
    for (size_t i = 0; i < n && fits; i++)
        fits = take_light(&from[i], &out->lights.open[out->lights.n++]);
    return fits ? LF_OK
                : lf_error_set(err, LF_E_FORMAT, "", "the reader's answer has invalid lights");
}

/* ----------------------------------------------------------------------------------- cameras -- */

static bool is_unit_double(const double v[3])
{
    return fabs(lf_dot_double(v, v) - 1) <= (double)UNIT_SLACK;
}

static bool take_camera(const lf_parcel_camera *from, lf_file_camera *out)
{
    bool fits = is_unit_double(from->look) && is_unit_double(from->up) &&
                fabs(lf_dot_double(from->look, from->up)) <= (double)UNIT_SLACK &&
                from->fov_y >= LF_FILE_CAMERA_LEAST_FOV && from->fov_y <= LF_FILE_CAMERA_MOST_FOV &&
                from->number <= INT32_MAX && from->parallel <= 1 &&
                memchr(from->name, 0, sizeof from->name) &&
                memchr(from->node_name, 0, sizeof from->node_name);
    for (int i = 0; i < 3; i++)
        fits = fits && fabs(from->position[i]) <= LF_MAX_COORDINATE;
    if (!fits)
        return false;
    *out = (lf_file_camera){
        .number = (int)from->number, .parallel = from->parallel == 1, .fov_y = from->fov_y};
    memcpy(out->name, from->name, sizeof out->name);
    memcpy(out->node_name, from->node_name, sizeof out->node_name);
    memcpy(out->position, from->position, sizeof out->position);
    memcpy(out->look, from->look, sizeof out->look);
    memcpy(out->up, from->up, sizeof out->up);
    return true;
}

static lf_status take_cameras(const lf_parcel *parcel, lf_mesh_data *out, lf_error *err)
{
    size_t n;
    const lf_parcel_camera *from = lf_parcel_get(parcel, LF_PARCEL_CAMERAS, &n);
    bool fits = n <= LF_MAX_FILE_CAMERAS;
    if (n == 0)
        return LF_OK;
    out->cameras.open = lf_calloc(fits ? n : 1, sizeof *out->cameras.open);
    if (!out->cameras.open)
        return no_memory(err);
    for (size_t i = 0; i < n && fits; i++)
        fits = take_camera(&from[i], &out->cameras.open[out->cameras.n++]);
    return fits ? LF_OK
                : lf_error_set(err, LF_E_FORMAT, "", "the reader's answer has invalid cameras");
}

/* Whether parts follow each other, to the last triangle, and no triangle has a vertex of another
 * part. */
static bool parts_fit(const lf_mesh_data *data)
{
    uint64_t triangle = 0, vertex = 0;
    for (int i = 0; i < data->n_parts; i++) {
        const lf_mesh_part *part = &data->parts[i];
        if (part->first_triangle != triangle || part->first_vertex < vertex ||
            part->n_triangles == 0)
            return false;
        triangle += part->n_triangles;
        vertex = (uint64_t)part->first_vertex + part->n_vertices;
        if (triangle > (uint64_t)data->n_triangles || vertex > (uint64_t)data->n_vertices)
            return false;
        for (uint64_t c = 3 * (uint64_t)part->first_triangle; c < 3 * triangle; c++)
            if (data->triangles[c] < part->first_vertex || data->triangles[c] >= vertex)
                return false;
    }
    return triangle == (uint64_t)data->n_triangles;
}

static lf_status take_parts(const lf_parcel *parcel, lf_mesh_data *out, lf_error *err)
{
    const size_t n = count_of(parcel, LF_PARCEL_PARTS),
                 n_instances = count_of(parcel, LF_PARCEL_PART_OF);
    if (n == 0 || n % 4 != 0 || n / 4 > INT_MAX ||
        12 * n_instances != count_of(parcel, LF_PARCEL_INSTANCES))
        return lf_error_set(err, LF_E_FORMAT, "", "the reader's answer has invalid parts");
    lf_status status = copy(parcel, LF_PARCEL_PARTS, n / 4, sizeof *out->parts, &out->parts, err);
    if (status == LF_OK)
        status = lf_instances_take(parcel, "", out, err);
    if (status == LF_OK)
        status =
            copy(parcel, LF_PARCEL_PART_OF, n_instances, sizeof *out->part_of, &out->part_of, err);
    if (status != LF_OK)
        return status;
    out->n_parts = (int)(n / 4);
    bool fit = parts_fit(out);
    for (size_t i = 0; i < n_instances && fit; i++) /* instances of a part are consecutive */
        fit = out->part_of[i] < (uint32_t)out->n_parts &&
              (i == 0 || out->part_of[i - 1] <= out->part_of[i]);
    return fit && lf_instances_check(out, "", NULL) == LF_OK
               ? LF_OK
               : lf_error_set(err, LF_E_FORMAT, "", "the reader's answer has invalid parts");
}

lf_status lf_mesh_take(const lf_parcel *parcel, lf_mesh_asked asked, lf_mesh_data *out,
                       lf_error *err)
{
    if (!counts_fit(parcel, asked))
        return lf_error_set(err, LF_E_FORMAT, "", "the reader's answer has no mesh");
    size_t n_vertices = count_of(parcel, LF_PARCEL_POSITIONS) / 3,
           n_triangles = count_of(parcel, LF_PARCEL_TRIANGLES) / 3;
    out->n_vertices = (int)n_vertices;
    out->n_triangles = (int)n_triangles;
    out->n_uv_sets = (int)(count_of(parcel, LF_PARCEL_UVS) / (2 * n_vertices));
    lf_status status = take_vertices(parcel, out, err);
    if (status == LF_OK)
        status = copy(parcel, LF_PARCEL_TRIANGLES, n_triangles, 3 * sizeof(uint32_t),
                      &out->triangles, err);
    if (status == LF_OK)
        status = copy(parcel, LF_PARCEL_CHOICES, n_triangles, sizeof(uint16_t),
                      &out->triangle_material, err);
    if (status == LF_OK)
        status = lf_mesh_take_pictures(parcel, out, err);
    if (status == LF_OK)
        status = take_materials(parcel, out, err);
    if (status == LF_OK)
        status = take_span(parcel, out, err);
    if (status == LF_OK)
        status = take_lights(parcel, out, err);
    if (status == LF_OK)
        status = take_cameras(parcel, out, err);
    if (status == LF_OK && count_of(parcel, LF_PARCEL_INSTANCES) > 0)
        status = take_parts(parcel, out, err);
    if (status == LF_OK &&
        !(positions_fit(out) && triangles_fit(out) && frames_fit(out) && looks_are_sound(out)))
        status = lf_error_set(err, LF_E_FORMAT, "", "the reader's answer is not a valid mesh");
    return status;
}
