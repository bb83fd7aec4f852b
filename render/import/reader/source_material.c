#include "render/import/reader/source_material.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/reader.h"

lf_source_material lf_source_material_begin(const char *name)
{
    lf_source_material source = {.name = lf_strdup(name), .p = lf_principled_usual()};
    source.roughness = 1.0f;
    source.ior = 0.0f;
    return source;
}

/* Out-of-range values of a material, and the limits that they are clamped to, as text. */
typedef struct cuts {
    char text[256];
} cuts;

/* NaN gives the lowest. */
static float clamp(float v, const lf_param *row)
{
    return v > (float)row->low ? fminf(v, (float)row->high) : (float)row->low;
}

/* Ignores rounding. */
static bool differs(float source, float kept)
{
    return !(fabsf(source - kept) <= 1e-4f * fmaxf(kept, 1.0f));
}

static void LF_PRINTF(2, 3) tell(cuts *c, const char *format, ...)
{
    size_t at = strlen(c->text);
    va_list arguments;
    if (at > 0)
        at += (size_t)snprintf(c->text + at, sizeof c->text - at, ", ");
    if (at >= sizeof c->text)
        return;
    va_start(arguments, format);
    (void)vsnprintf(c->text + at, sizeof c->text - at, format, arguments);
    va_end(arguments);
}

static void tell_number(cuts *c, const char *what, float source, float kept)
{
    if (differs(source, kept))
        tell(c, "%s %g to %g", what, (double)source, (double)kept);
}

static void tell_colour(cuts *c, const char *what, const float source[3], const float kept[3])
{
    if (differs(source[0], kept[0]) || differs(source[1], kept[1]) || differs(source[2], kept[2]))
        tell(c, "%s (%g, %g, %g) to (%g, %g, %g)", what, (double)source[0], (double)source[1],
             (double)source[2], (double)kept[0], (double)kept[1], (double)kept[2]);
}

/* Angles have no range. */
static void cut(cuts *c, const lf_param *row, lf_principled *p)
{
    int n;
    float *field = lf_principled_at(p, row, &n), source[3] = {0};
    memcpy(source, field, (size_t)n * sizeof *source);
    for (int i = 0; i < n && row->type != LF_PARAM_ANGLE; i++)
        field[i] = clamp(source[i], row);
    if (row == &lf_principled_ior && !(source[0] >= 1.0f)) /* invalid index */
        field[0] = (float)row->initial;
    if (row->help && n == 1)
        tell_number(c, row->help, source[0], field[0]);
    else if (row->help && n == 3)
        tell_colour(c, row->help, source, field);
}

/* Phong's Kd, Ks, Ns: a highlight without a diffuse part is a metal, with one a coat. */
static void convert_phong(const lf_source_material *source, lf_material *out, cuts *c)
{
    const lf_vec3 s = source->highlight;
    const lf_param *share = &lf_principled_albedo;
    lf_vec3 specular = lf_v3(clamp(s.x, share), clamp(s.y, share), clamp(s.z, share));
    if (!(lf_max3(specular) > 0.0f) || !(source->exponent > 0.0f) || !isfinite(source->exponent))
        return;
    /* alpha = sqrt(2 / (Ns + 2)) (Walter et al. 2007, section 5), roughness = sqrt(alpha). */
    out->roughness = clamp(powf(2.0f / (source->exponent + 2.0f), 0.25f), &lf_principled_roughness);
    if (source->ior > 1.0f && isfinite(source->ior)) {
        out->ior = source->ior;
        cut(c, &lf_principled_ior, &out->p);
    }
    out->kind = &lf_surface_plastic;
    if (!(lf_max3(out->albedo) > 0.0f)) {
        out->kind = &lf_surface_conductor;
        out->albedo = specular;
    }
}

/* Sets values that the source model lacks, and constraints beyond ranges. */
static void settle(const lf_source_material *source, lf_principled *p)
{
    const lf_principled usual = lf_principled_usual();
    if (!source->is_metallic || source->ior == 0.0f)
        p->ior = usual.ior;
    if (!source->is_metallic) {
        p->roughness = usual.roughness;
        p->metallic = p->anisotropy = 0.0f;
    }
    if (source->cover == LF_COVER_OPAQUE)
        p->alpha = clamp(p->alpha, &lf_principled_alpha); /* of no matter */
    else if (source->cover == LF_COVER_MASK && p->alpha_cutoff > 1.0f)
        p->alpha = 0.0f;                       /* no alpha reaches the cutoff */
    if (source->lost & 1u << LF_LOST_EMISSION) /* which is black nearly everywhere */
        p->emission = usual.emission;
}

static bool has_texture(const lf_source_material *source)
{
    bool any = false;
    for (int s = 0; s < LF_SLOTS; s++)
        any = any || source->textures.slot[s].picture != 0;
    return any;
}

static lf_material convert_source(const lf_source_material *source, cuts *c)
{
    lf_material out = {.kind = &lf_surface_diffuse, .p = lf_principled_usual()};
    if (source->is_none)
        return out;
    out.p = source->p;
    out.cover = source->cover;
    out.is_solid = source->is_solid;
    out.tint = source->emits_by_colours ? LF_TINT_ALL : LF_TINT_ALBEDO;
    settle(source, &out.p);
    for (const lf_param *const *row = lf_principled_rows; *row; row++)
        cut(c, *row, &out.p);
    if (source->is_metallic)
        out.kind = &lf_surface_principled;
    else
        convert_phong(source, &out, c);
    if (has_texture(source))
        lf_material_make_pictured(&out);
    return out;
}

/* For materials of triangles. false: no memory. */
static bool convert_textures(const lf_source_material *source, size_t n, const bool *used,
                             lf_mesh_data *out)
{
    for (size_t i = 0; i < n; i++)
        for (int s = 0; s < LF_SLOTS; s++) {
            if (!used[i] || source[i].textures.slot[s].picture == 0)
                continue;
            if (!out->textures)
                out->textures = lf_calloc(n, sizeof *out->textures);
            if (!out->textures)
                return false;
            out->textures[i].slot[s] = source[i].textures.slot[s];
        }
    return true;
}

/* ----------------------------------------------------------------------------- lost features -- */

static const char *const losses[LF_LOST_KINDS] = {
    [LF_LOST_TEXTURES] = "textures are not supported; the material is used without them",
    [LF_LOST_TEXTURE] = "a missing texture is left out; the material is used without it",
    [LF_LOST_UV_SET] =
        "a texture with a third set of coordinates, or with coordinates out of range, is left out",
    [LF_LOST_MAPS] = "only textures of colour, emission, normals and opacity are supported",
    [LF_LOST_MAP_OPTIONS] = "texture options are left out, except position and size",
    [LF_LOST_EMISSION] = "the emission texture is not supported, so nothing is emitted",
    [LF_LOST_TRANSPARENCY] = "transparency is left out; the material is opaque",
    [LF_LOST_COAT] = "the clear coat is left out",
    [LF_LOST_SHEEN] = "the sheen is left out",
    [LF_LOST_ANISOTROPY] = "anisotropy is left out",
    [LF_LOST_UNLIT] = "illum 0 (unlit) is not supported; the material is lit",
    [LF_LOST_UNLIT_TEXTURE] = "unlit textures are not supported; the material is lit",
    [LF_LOST_KTX2] = "textures in KTX2 only are not supported",
    [LF_LOST_MORE_TEXTURES] = "textures of thickness and of specular-glossiness are not supported",
    [LF_LOST_OCCLUSION] =
        "the ambient occlusion texture is ignored: path tracing computes occlusion",
    [LF_LOST_IRIDESCENCE] = "iridescence is left out (KHR_materials_iridescence)",
    [LF_LOST_DISPERSION] = "dispersion is left out (KHR_materials_dispersion)",
    [LF_LOST_TRANSLUCENCE] =
        "diffuse transmission is left out (KHR_materials_diffuse_transmission)",
    [LF_LOST_ALPHA_MODE] = "its alphaMode is unknown; the material is opaque",
    [LF_LOST_GLOSSINESS] = "specular-glossiness is converted to metallic-roughness",
};

/* The names of materials in one line; only a few are listed. */
typedef struct name_list {
    int n;
    char text[256];
} name_list;

static void list_name(const lf_source_material *source, size_t number, name_list *out)
{
    enum { TOLD = 3 };
    size_t at = strlen(out->text), size = sizeof out->text - at;
    char *end = out->text + at;
    if (out->n < TOLD && source->name[0])
        snprintf(end, size, "%s\"%.40s\"", out->n ? ", " : "", source->name);
    else if (out->n < TOLD)
        snprintf(end, size, "%snumber %zu", out->n ? ", " : "", number);
    else if (out->n == TOLD)
        snprintf(end, size, " ...");
    out->n++;
}

static void warn_of(const name_list *names, const char *what, lf_warnings *warnings)
{
    char number[16] = "";
    if (names->n > 1)
        snprintf(number, sizeof number, "%d ", names->n);
    if (names->n > 0)
        lf_warnings_add(warnings, LF_HERE, "%s%s %s: %s", number,
                        names->n == 1 ? "material" : "materials", names->text, what);
}

static void warn_of_cuts(const lf_source_material *source, size_t number, const char *what,
                         lf_warnings *warnings)
{
    name_list name = {0};
    list_name(source, number, &name);
    lf_warnings_add(warnings, LF_HERE, "material %s: values out of range are clamped: %s",
                    name.text, what);
}

/* Cut between characters if it is too long. */
static void copy_name(const char *name, char out[LF_MATERIAL_NAME])
{
    size_t n = strlen(name);
    if (n >= LF_MATERIAL_NAME)
        for (n = LF_MATERIAL_NAME - 1; n > 0 && ((unsigned char)name[n] & 0xc0u) == 0x80u;)
            n--;
    memcpy(out, name, n);
}

lf_status lf_source_materials_convert(const lf_source_material *source, size_t n, const bool *used,
                                      lf_mesh_data *out, lf_error *err)
{
    if (n == 0 || n > LF_MAX_MATERIALS)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "the file has %zu materials; expected 1 to %d", n, LF_MAX_MATERIALS);
    out->materials = lf_calloc(n, sizeof *out->materials);
    if (!out->materials)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    out->n_materials = (int)n;
    out->names = lf_calloc(n, sizeof *out->names);
    if (!out->names)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (size_t i = 0; i < n; i++) {
        cuts c = {""};
        copy_name(source[i].name, out->names[i]);
        out->materials[i] = convert_source(&source[i], &c);
        if (used[i] && c.text[0])
            warn_of_cuts(&source[i], i, c.text, &out->warnings);
    }
    if (!convert_textures(source, n, used, out))
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (unsigned kind = 0; kind < LF_LOST_KINDS; kind++) {
        name_list names = {0};
        for (size_t i = 0; i < n; i++)
            if (used[i] && source[i].lost & 1u << kind)
                list_name(&source[i], i, &names);
        warn_of(&names, losses[kind], &out->warnings);
    }
    return LF_OK;
}

void lf_source_materials_warn_of_missing(const lf_source_material *source, size_t n,
                                         const bool *used, lf_warnings *warnings)
{
    name_list names = {0};
    for (size_t i = 0; i < n; i++)
        if (used[i] && source[i].is_missing)
            list_name(&source[i], i, &names);
    warn_of(&names, "not in the file's material libraries; grey is used", warnings);
}
