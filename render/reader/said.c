#include "render/reader/said.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/reader/reader.h"

/* Of a dielectric that does not say. */
#define USUAL_INDEX 1.5f

lf_said lf_said_begin(const char *name)
{
    return (lf_said){.name = lf_strdup(name),
                     .diffuse = {0.5f, 0.5f, 0.5f},
                     .roughness = 1.0f,
                     .alpha = 1.0f,
                     .cutoff = 0.5f,
                     .specular = 1.0f,
                     .specular_tint = {1.0f, 1.0f, 1.0f}};
}

static float clamp_unit(float v)
{
    return v > 0.0f ? fminf(v, 1.0f) : 0.0f; /* NaN gives 0 */
}

static lf_vec3 clamp_colour(lf_vec3 c)
{
    return lf_v3(clamp_unit(c.x), clamp_unit(c.y), clamp_unit(c.z));
}

static float clamp_radiance(float v)
{
    return v > 0.0f ? fminf(v, (float)LF_MAX_RADIANCE) : 0.0f;
}

static lf_vec3 clamp_radiances(lf_vec3 v)
{
    return lf_v3(clamp_radiance(v.x), clamp_radiance(v.y), clamp_radiance(v.z));
}

/* glTF's metallic-roughness model, and that of newer MTL files. */
static void convert_metallic(const lf_said *said, lf_material *out)
{
    out->kind = &lf_surface_principled;
    out->roughness = clamp_unit(said->roughness);
    out->metallic = clamp_unit(said->metallic);
    out->ior = said->ior >= 1.0f ? fminf(said->ior, 3.0f) : USUAL_INDEX;
    out->brush.strength = clamp_unit(said->brush);
    out->brush.turn[0] = cosf(said->brush_turn);
    out->brush.turn[1] = sinf(said->brush_turn);
}

/* Phong's Kd, Ks, Ns: a highlight without a diffuse part is a metal, with one a coat. */
static void convert_phong(const lf_said *said, lf_material *out)
{
    lf_vec3 specular = clamp_colour(said->highlight);
    if (!(lf_max3(specular) > 0.0f) || !(said->exponent > 0.0f) || !isfinite(said->exponent))
        return;
    /* alpha = sqrt(2 / (Ns + 2)) (Walter et al. 2007, section 5), roughness = sqrt(alpha). */
    out->roughness = clamp_unit(powf(2.0f / (said->exponent + 2.0f), 0.25f));
    if (said->ior > 1.0f && isfinite(said->ior))
        out->ior = fminf(said->ior, 3.0f);
    out->kind = &lf_surface_plastic;
    if (!(lf_max3(out->albedo) > 0.0f)) {
        out->kind = &lf_surface_conductor;
        out->albedo = specular;
    }
}

/* What layered surfaces have, and every kind of cover. */
static void convert_layers(const lf_said *said, lf_material *out)
{
    out->cover = said->cover < LF_COVERS ? said->cover : LF_COVER_OPAQUE;
    out->alpha = clamp_unit(said->alpha);
    out->cutoff = clamp_unit(said->cutoff);
    out->specular = clamp_unit(said->specular);
    out->specular_tint = clamp_colour(said->specular_tint);
    out->coat = clamp_unit(said->coat);
    out->coat_roughness = clamp_unit(said->coat_roughness);
    out->sheen = clamp_colour(said->sheen);
    out->sheen_roughness = clamp_unit(said->sheen_roughness);
    out->transmission = clamp_unit(said->transmission);
    out->is_solid = said->is_solid;
    out->glass.absorption = clamp_radiances(said->absorption);
}

static bool has_texture(const lf_said *said)
{
    bool any = false;
    for (int s = 0; s < LF_SLOTS; s++)
        any = any || said->textures.slot[s].picture != 0;
    return any;
}

/* Of all kinds those that are ready for a picture's values: coats and metals by their layers. */
static void make_pictured(lf_material *m)
{
    if (m->kind == &lf_surface_diffuse || m->kind == &lf_surface_principled)
        return;
    m->metallic = (float)(m->kind == &lf_surface_conductor);
    m->kind = &lf_surface_principled;
}

static lf_material convert_said(const lf_said *said)
{
    lf_material out = {.kind = &lf_surface_diffuse,
                       .albedo = {0.5f, 0.5f, 0.5f},
                       .roughness = 0.3f,
                       .ior = USUAL_INDEX,
                       .alpha = 1.0f,
                       .cutoff = 0.5f,
                       .specular = 1.0f,
                       .specular_tint = {1.0f, 1.0f, 1.0f}};
    if (said->is_none)
        return out;
    convert_layers(said, &out);
    out.albedo = clamp_colour(said->diffuse);
    if (said->is_metallic)
        convert_metallic(said, &out);
    else
        convert_phong(said, &out);
    if (has_texture(said))
        make_pictured(&out);
    if (!(said->lost & 1u << LF_LOST_GLOW)) /* which is black nearly everywhere */
        out.emission = clamp_radiances(said->emission);
    return out;
}

/* Of materials that triangles have. false: no memory. */
static bool convert_textures(const lf_said *said, size_t n, const bool *used, lf_mesh_data *out)
{
    for (size_t i = 0; i < n; i++)
        for (int s = 0; s < LF_SLOTS; s++) {
            if (!used[i] || said[i].textures.slot[s].picture == 0)
                continue;
            if (!out->textures)
                out->textures = lf_calloc(n, sizeof *out->textures);
            if (!out->textures)
                return false;
            out->textures[i].slot[s] = said[i].textures.slot[s];
        }
    return true;
}

/* ------------------------------------------------------------------------------ what is lost -- */

static const char *const losses[LF_LOST_KINDS] = {
    [LF_LOST_TEXTURES] = "textures are not read, the colours beside them alone count",
    [LF_LOST_MAPS] = "textures of anything but colour, glow, normals, coverage are not read",
    [LF_LOST_MAP_OPTIONS] = "options of its textures are left out, but for their place and size",
    [LF_LOST_GLOW] = "the texture of what glows is not read, so nothing of it does",
    [LF_LOST_TRANSPARENCY] = "transparency is left out: opaque",
    [LF_LOST_COAT] = "the clear coat is left out",
    [LF_LOST_SHEEN] = "the sheen is left out",
    [LF_LOST_BRUSHED] = "anisotropy is left out",
    [LF_LOST_UNLIT] = "unlit is not possible: lit as others are",
    [LF_LOST_KTX2] = "textures that are in KTX2 alone are not read",
    [LF_LOST_MORE_TEXTURES] = "textures of thickness, and of specular and glossiness, are not read",
    [LF_LOST_OCCLUSION] = "the occlusion texture is left out, light is followed instead",
    [LF_LOST_IRIDESCENCE] = "iridescence is left out",
    [LF_LOST_DISPERSION] = "dispersion is left out",
    [LF_LOST_TRANSLUCENCE] = "diffuse transmission is left out",
    [LF_LOST_GLOSSINESS] = "specular and glossiness are made into metallic and roughness",
    [LF_LOST_OTHERS] = "extensions that are not known here are left out",
};

/* The names of materials in one line, of which a few are told. */
typedef struct name_list {
    int n;
    char text[256];
} name_list;

static void list_name(const lf_said *said, size_t number, name_list *out)
{
    enum { TOLD = 3 };
    size_t at = strlen(out->text), size = sizeof out->text - at;
    char *end = out->text + at;
    if (out->n < TOLD && said->name[0])
        snprintf(end, size, "%s\"%.40s\"", out->n ? ", " : "", said->name);
    else if (out->n < TOLD)
        snprintf(end, size, "%snumber %zu", out->n ? ", " : "", number);
    else if (out->n == TOLD)
        snprintf(end, size, " ...");
    out->n++;
}

static void warn_of(const name_list *names, const char *what, lf_warnings *warnings)
{
    if (names->n > 0)
        lf_warnings_add(warnings, LF_HERE, "%s %s: %s", names->n == 1 ? "material" : "materials",
                        names->text, what);
}

lf_status lf_said_convert(const lf_said *said, size_t n, const bool *used, lf_mesh_data *out,
                          lf_error *err)
{
    if (n == 0 || n > LF_MAX_MATERIALS)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "%zu materials; 1 to %d are possible", n,
                            LF_MAX_MATERIALS);
    out->materials = lf_calloc(n, sizeof *out->materials);
    if (!out->materials)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    out->n_materials = (int)n;
    for (size_t i = 0; i < n; i++)
        out->materials[i] = convert_said(&said[i]);
    if (!convert_textures(said, n, used, out))
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (unsigned kind = 0; kind < LF_LOST_KINDS; kind++) {
        name_list names = {0};
        for (size_t i = 0; i < n; i++)
            if (used[i] && said[i].lost & 1u << kind)
                list_name(&said[i], i, &names);
        warn_of(&names, losses[kind], &out->warnings);
    }
    return LF_OK;
}

void lf_said_warn_of_missing(const lf_said *said, size_t n, const bool *used, lf_warnings *warnings)
{
    name_list names = {0};
    for (size_t i = 0; i < n; i++)
        if (used[i] && said[i].is_missing)
            list_name(&said[i], i, &names);
    warn_of(&names, "not in the file's material libraries, so it is grey", warnings);
}
