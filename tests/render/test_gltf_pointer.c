/* What animation pointers of glTF (KHR_animation_pointer) move is what a still file would say there
 * at that moment; what they cannot move is told. docs/reference/formats/gltf-pointers.md, row by
 * row. */
#include "tests/formats.h"
#include "tests/render/pointed.h"

/* --------------------------------------------------------------------------- the page's rows -- */

typedef void look_fn(const lf_mesh_data *data, double out[4]);

/* Two keys at 0 and 1 s, of n numbers each; what a look at the mesh must find after a quarter of
 * a second: a quarter of the way, or is[] where that is given. */
typedef struct moved {
    look_fn *look;
    int n, n_is;
    const char *shape; /* NULL: that of n */
    float from[4], to[4];
    double is[4];
} moved;

static void put_keys(const moved *m, gltf_text *text)
{
    static const char *const shapes[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    float values[8];
    for (int i = 0; i < m->n; i++) {
        values[i] = m->from[i];
        values[m->n + i] = m->to[i];
    }
    gltf_put_floats(text, two_moments, 2, "SCALAR");
    gltf_put_floats(text, values, m->shape ? 2 * m->n : 2, m->shape ? m->shape : shapes[m->n]);
}

static void check_used(const lf_format_row *row)
{
    const moved *m = row->with;
    char pointer[256];
    double found[4];
    gltf_text text = {0};
    put_corners(&text);
    put_keys(m, &text);
    name_one(row->name, pointer);
    lf_mesh_data data = follow(&text, pointer, "", 0.25);
    m->look(&data, found);
    for (int i = 0; i < (m->n_is ? m->n_is : m->n); i++) {
        double is = m->n_is ? m->is[i] : (double)(m->from[i] + 0.25f * (m->to[i] - m->from[i]));
        if (fabs(found[i] - is) > 2e-6)
            fail_msg("%s: number %d is %g, not %g", row->name, i, found[i], is);
    }
    assert_false(gltf_warns(&data, "animation channel"));
    lf_assert_close(data.span, 1, 0, 0);
    lf_mesh_data_finish(&data);
}

/* Moves nothing; says so, or need not. */
static void check_unused(const lf_format_row *row)
{
    const moved m = {.n = 1, .to = {1}};
    bool told = strcmp(row->verdict, "warned") == 0;
    char pointer[256], words[512];
    gltf_text text = {0};
    put_corners(&text);
    put_keys(&m, &text);
    name_one(row->name, pointer);
    lf_mesh_data data = follow(&text, pointer, "", 0.25);
    snprintf(words, sizeof words,
             "1 animation channel is left out, %s: quiltd does not read this property", pointer);
    if (gltf_warns(&data, words) != told || gltf_warns(&data, "animation channel") != told)
        fail_msg("%s: not %s", pointer, row->verdict);
    lf_mesh_data_finish(&data);
}

static void look_base(const lf_mesh_data *data, double out[4])
{
    const lf_material *m = &data->materials[0];
    const double found[4] = {(double)m->albedo.x, (double)m->albedo.y, (double)m->albedo.z,
                             (double)m->alpha};
    memcpy(out, found, sizeof found);
}

static void put_vector(lf_vec3 v, double out[4])
{
    out[0] = (double)v.x;
    out[1] = (double)v.y;
    out[2] = (double)v.z;
}

/* Of a number of a material. */
#define LOOK(name, number)                                                                         \
    static void look_##name(const lf_mesh_data *data, double out[4])                               \
    {                                                                                              \
        const lf_material *m = &data->materials[0];                                                \
        out[0] = (double)(number);                                                                 \
    }
/* clang-format off */
LOOK(cutoff, m->alpha_cutoff)
LOOK(metallic, m->metallic)
LOOK(roughness, m->roughness)
LOOK(anisotropic, m->anisotropy)
LOOK(anisotropy_turn, atan2f(m->anisotropy_rotation[1], m->anisotropy_rotation[0]))
LOOK(coat, m->coat)
LOOK(coat_roughness, m->coat_roughness)
LOOK(strength, m->emission.y / 0.5f)
LOOK(ior, m->ior)
LOOK(sheen_roughness, m->sheen_roughness)
LOOK(specular, m->specular)
LOOK(transmission, m->transmission)
LOOK(solid, m->is_solid)
LOOK(distance, log(2) / (double)m->absorption.x)
/* clang-format on */

static void look_emission(const lf_mesh_data *data, double out[4])
{
    put_vector(data->materials[0].emission, out);
}

static void look_sheen(const lf_mesh_data *data, double out[4])
{
    put_vector(data->materials[0].sheen, out);
}

static void look_tint(const lf_mesh_data *data, double out[4])
{
    put_vector(data->materials[0].specular_tint, out);
}

/* After one unit of length. */
static void look_attenuation(const lf_mesh_data *data, double out[4])
{
    put_vector(data->materials[0].absorption, out);
    for (int i = 0; i < 3; i++)
        out[i] = exp(-out[i]);
}

static void look_normal_scale(const lf_mesh_data *data, double out[4])
{
    out[0] = (double)data->textures[0].slot[LF_SLOT_NORMAL].scale;
}

static void look_coat_normal_scale(const lf_mesh_data *data, double out[4])
{
    out[0] = (double)data->textures[0].slot[LF_SLOT_COAT_NORMAL].scale;
}

static void look_fov(const lf_mesh_data *data, double out[4])
{
    out[0] = data->cameras.open[0].fov_y;
}

static void look_light(const lf_mesh_data *data, double out[4])
{
    out[0] = data->lights.open[0].intensity[0];
}

static void look_light_colour(const lf_mesh_data *data, double out[4])
{
    for (int i = 0; i < 3; i++)
        out[i] = data->lights.open[0].intensity[i] / 10;
}

static void look_inner(const lf_mesh_data *data, double out[4])
{
    out[0] = data->lights.open[0].inner;
}

static void look_outer(const lf_mesh_data *data, double out[4])
{
    out[0] = data->lights.open[0].outer;
}

static void look_translation(const lf_mesh_data *data, double out[4])
{
    for (int i = 0; i < 3; i++)
        out[i] = corner_of(data, 0)[i] - (i == 0);
}

static void look_rotation(const lf_mesh_data *data, double out[4])
{
    out[0] = atan2(corner_of(data, 0)[1], corner_of(data, 0)[0]);
}

static void look_scale(const lf_mesh_data *data, double out[4])
{
    for (int i = 0; i < 3; i++)
        out[i] = corner_of(data, i)[i];
}

static void look_weights(const lf_mesh_data *data, double out[4])
{
    out[0] = corner_of(data, 2)[0];
    out[1] = corner_of(data, 2)[1];
}

static void look_weight(const lf_mesh_data *data, double out[4])
{
    out[0] = corner_of(data, 2)[1];
}

#define SOME .from = {0.125f, 0.25f, 0.5f, 0.75f}, .to = {0.625f, 0.75f, 0.25f, 0.5f}
#define WITH(pointer, ...)                                                                         \
    {                                                                                              \
        pointer, "used", check_used, &(const moved)                                                \
        {                                                                                          \
            __VA_ARGS__                                                                            \
        }                                                                                          \
    }
#define USED(pointer, count, ...) WITH(pointer, .n = count, SOME, .look = __VA_ARGS__)
#define TOLD(pointer)                                                                              \
    {                                                                                              \
        pointer, "warned", check_unused, NULL                                                      \
    }
#define IGNORED(pointer)                                                                           \
    {                                                                                              \
        pointer, "ignored", check_unused, NULL                                                     \
    }

/* -------------------------------------------------------------------------------- transforms -- */

/* After a quarter of a second: a texture is turned by 0.25, or lies at or is stretched by
 * (0.25, 0.5). */
typedef struct transform {
    lf_slot slot;
    int what; /* 0: offset, 1: rotation, 2: scale */
} transform;

static void check_transform(const lf_format_row *row)
{
    const transform *t = row->with;
    const moved keys = {.n = t->what == 1 ? 1 : 2, .from = {0, 1}, .to = {1, -1}};
    char pointer[256];
    gltf_text text = {0};
    put_corners(&text);
    put_keys(&keys, &text);
    name_one(row->name, pointer);
    lf_mesh_data data = follow(&text, pointer, "", 0.25);
    const double maps[3][2][3] = {{{1, 0, 0.25}, {0, 1, 0.5}},
                                  {{cos(0.25), sin(0.25), 0}, {-sin(0.25), cos(0.25), 0}},
                                  {{0.25, 0, 0}, {0, 0.5, 0}}};
    for (int i = 0; i < 6; i++)
        if (fabs((double)data.textures[0].slot[t->slot].map[i / 3][i % 3] -
                 maps[t->what][i / 3][i % 3]) > 1e-6)
            fail_msg("%s: map[%d][%d] is %g", row->name, i / 3, i % 3,
                     (double)data.textures[0].slot[t->slot].map[i / 3][i % 3]);
    assert_false(gltf_warns(&data, "animation channel"));
    lf_mesh_data_finish(&data);
}

/* Hidden from 0.2 s on: the other mesh is left, and the light is out where it is the light's. */
static void check_visibility(const lf_format_row *row)
{
    static const float moments[2] = {0, 0.2f};
    const unsigned char visible[8] = {1, 0, 0, 0, 0, 0, 0, 0};
    char pointer[256];
    gltf_text text = {0};
    put_corners(&text);
    gltf_put_floats(&text, moments, 2, "SCALAR");
    gltf_accessor(&text, gltf_view(&text, visible, 2, ""), 5121, 2, "SCALAR", "");
    name_one(row->name, pointer);
    for (int hidden = 0; hidden < 2; hidden++) {
        lf_mesh_data data = follow(&text, pointer, ",'interpolation':'STEP'", hidden ? 0.2 : 0.1);
        assert_int_equal(data.n_triangles, hidden ? 1 : 2);
        assert_int_equal(data.lights.n, 1);
        assert_false(gltf_warns(&data, "animation channel"));
        lf_mesh_data_finish(&data);
    }
}

#define MATERIAL "/materials/{}/"
#define EXTENSION(name) "/materials/{}/extensions/KHR_materials_" name "/"
#define LIGHT "/extensions/KHR_lights_punctual/lights/{}/"
#define MOVED "/extensions/KHR_texture_transform/"
#define TEXTURE(pointer, slot)                                                                     \
    {pointer MOVED "offset", "used", check_transform, &(const transform){slot, 0}},                \
        {pointer MOVED "rotation", "used", check_transform, &(const transform){slot, 1}},          \
    {                                                                                              \
        pointer MOVED "scale", "used", check_transform, &(const transform)                         \
        {                                                                                          \
            slot, 2                                                                                \
        }                                                                                          \
    }
#define TOLD_TEXTURE(pointer)                                                                      \
    TOLD(pointer MOVED "offset"), TOLD(pointer MOVED "rotation"), TOLD(pointer MOVED "scale")

static const lf_format_row rows[] = {
    USED("/cameras/{}/perspective/yfov", 1, look_fov),
    TOLD("/cameras/{}/perspective/aspectRatio"),
    IGNORED("/cameras/{}/perspective/zfar"),
    IGNORED("/cameras/{}/perspective/znear"),
    TOLD("/cameras/{}/orthographic/xmag"),
    TOLD("/cameras/{}/orthographic/ymag"),
    IGNORED("/cameras/{}/orthographic/zfar"),
    IGNORED("/cameras/{}/orthographic/znear"),
    USED(MATERIAL "alphaCutoff", 1, look_cutoff),
    USED(MATERIAL "emissiveFactor", 3, look_emission),
    USED(MATERIAL "normalTexture/scale", 1, look_normal_scale),
    TOLD(MATERIAL "occlusionTexture/strength"),
    USED(MATERIAL "pbrMetallicRoughness/baseColorFactor", 4, look_base),
    USED(MATERIAL "pbrMetallicRoughness/metallicFactor", 1, look_metallic),
    USED(MATERIAL "pbrMetallicRoughness/roughnessFactor", 1, look_roughness),
    USED("/meshes/{}/weights", 2, look_weights, .shape = "SCALAR"),
    USED("/meshes/{}/weights/{}", 1, look_weight),
    USED("/nodes/{}/translation", 3, look_translation),
    WITH("/nodes/{}/rotation", .n = 4, .look = look_rotation, .from = {0, 0, 0, 1},
         .to = {0, 0, 0.70710678f, 0.70710678f}, .n_is = 1, .is = {0.39269908}),
    USED("/nodes/{}/scale", 3, look_scale),
    USED("/nodes/{}/weights", 2, look_weights, .shape = "SCALAR"),
    USED("/nodes/{}/weights/{}", 1, look_weight),
    TOLD("/nodes/{}/matrix"),
    TOLD("/nodes/{}/globalMatrix"),
    TOLD("/nodes/{}/weights.length"),
    TOLD("/meshes/{}/weights.length"),
    TOLD("/animations.length"),
    TOLD("/cameras.length"),
    TOLD("/materials.length"),
    TOLD("/meshes.length"),
    TOLD("/nodes.length"),
    TOLD("/scenes.length"),
    {"/nodes/{}/extensions/KHR_node_visibility/visible", "used", check_visibility, NULL},
    IGNORED("/nodes/{}/extensions/KHR_node_hoverability/hoverable"),
    IGNORED("/nodes/{}/extensions/KHR_node_selectability/selectable"),
    USED(LIGHT "color", 3, look_light_colour),
    USED(LIGHT "intensity", 1, look_light),
    IGNORED(LIGHT "range"),
    USED(LIGHT "spot/innerConeAngle", 1, look_inner),
    USED(LIGHT "spot/outerConeAngle", 1, look_outer),
    TOLD("/extensions/KHR_lights_punctual/lights.length"),
    USED(EXTENSION("anisotropy") "anisotropyStrength", 1, look_anisotropic),
    USED(EXTENSION("anisotropy") "anisotropyRotation", 1, look_anisotropy_turn),
    USED(EXTENSION("clearcoat") "clearcoatFactor", 1, look_coat),
    USED(EXTENSION("clearcoat") "clearcoatRoughnessFactor", 1, look_coat_roughness),
    USED(EXTENSION("clearcoat") "clearcoatNormalTexture/scale", 1, look_coat_normal_scale),
    TOLD(EXTENSION("diffuse_transmission") "diffuseTransmissionFactor"),
    TOLD(EXTENSION("diffuse_transmission") "diffuseTransmissionColorFactor"),
    TOLD(EXTENSION("dispersion") "dispersion"),
    USED(EXTENSION("emissive_strength") "emissiveStrength", 1, look_strength),
    WITH(EXTENSION("ior") "ior", .n = 1, .look = look_ior, .from = {1.25f}, .to = {2.25f}),
    TOLD(EXTENSION("iridescence") "iridescenceFactor"),
    TOLD(EXTENSION("iridescence") "iridescenceIor"),
    TOLD(EXTENSION("iridescence") "iridescenceThicknessMinimum"),
    TOLD(EXTENSION("iridescence") "iridescenceThicknessMaximum"),
    USED(EXTENSION("sheen") "sheenColorFactor", 3, look_sheen),
    USED(EXTENSION("sheen") "sheenRoughnessFactor", 1, look_sheen_roughness),
    USED(EXTENSION("specular") "specularFactor", 1, look_specular),
    USED(EXTENSION("specular") "specularColorFactor", 3, look_tint),
    USED(EXTENSION("transmission") "transmissionFactor", 1, look_transmission),
    WITH(EXTENSION("volume") "thicknessFactor", .n = 1, .look = look_solid, .from = {0}, .to = {0}),
    USED(EXTENSION("volume") "attenuationDistance", 1, look_distance),
    USED(EXTENSION("volume") "attenuationColor", 3, look_attenuation),
    TEXTURE(MATERIAL "normalTexture", LF_SLOT_NORMAL),
    TOLD_TEXTURE(MATERIAL "occlusionTexture"),
    TEXTURE(MATERIAL "emissiveTexture", LF_SLOT_EMISSION),
    TEXTURE(MATERIAL "pbrMetallicRoughness/baseColorTexture", LF_SLOT_BASE),
    TEXTURE(MATERIAL "pbrMetallicRoughness/metallicRoughnessTexture", LF_SLOT_METAL_ROUGH),
    TEXTURE(EXTENSION("anisotropy") "anisotropyTexture", LF_SLOT_ANISOTROPY),
    TEXTURE(EXTENSION("clearcoat") "clearcoatTexture", LF_SLOT_COAT),
    TEXTURE(EXTENSION("clearcoat") "clearcoatRoughnessTexture", LF_SLOT_COAT_ROUGH),
    TEXTURE(EXTENSION("clearcoat") "clearcoatNormalTexture", LF_SLOT_COAT_NORMAL),
    TOLD_TEXTURE(EXTENSION("diffuse_transmission") "diffuseTransmissionTexture"),
    TOLD_TEXTURE(EXTENSION("diffuse_transmission") "diffuseTransmissionColorTexture"),
    TOLD_TEXTURE(EXTENSION("iridescence") "iridescenceTexture"),
    TOLD_TEXTURE(EXTENSION("iridescence") "iridescenceThicknessTexture"),
    TEXTURE(EXTENSION("sheen") "sheenColorTexture", LF_SLOT_SHEEN),
    TEXTURE(EXTENSION("sheen") "sheenRoughnessTexture", LF_SLOT_SHEEN_ROUGH),
    TEXTURE(EXTENSION("specular") "specularTexture", LF_SLOT_SPECULAR),
    TEXTURE(EXTENSION("specular") "specularColorTexture", LF_SLOT_SPECULAR_TINT),
    TEXTURE(EXTENSION("transmission") "transmissionTexture", LF_SLOT_TRANSMISSION),
    TOLD_TEXTURE(EXTENSION("volume") "thicknessTexture"),
    TOLD("/nodes/{}/extensions/EXT_lights_ies/multiplier"),
    TOLD("/nodes/{}/extensions/EXT_lights_ies/color"),
    TOLD("/extensions/EXT_lights_ies/lights.length"),
    TOLD("/extensions/EXT_lights_image_based/lights/{}/rotation"),
    TOLD("/extensions/EXT_lights_image_based/lights/{}/intensity"),
    TOLD("/extensions/EXT_lights_image_based/lights.length"),
    TOLD(MATERIAL "extensions/ADOBE_materials_clearcoat_specular/clearcoatIor"),
    TOLD(MATERIAL "extensions/ADOBE_materials_clearcoat_specular/clearcoatSpecularFactor"),
    TOLD_TEXTURE(MATERIAL "extensions/ADOBE_materials_clearcoat_specular/clearcoatSpecularTexture"),
    TOLD(MATERIAL "extensions/ADOBE_materials_clearcoat_tint/clearcoatTintFactor"),
    TOLD_TEXTURE(MATERIAL "extensions/ADOBE_materials_clearcoat_tint/clearcoatTintTexture"),
    TOLD(MATERIAL "extras/{}"),
};

static void pointers_move_what_the_page_says(void **state)
{
    (void)state;
    lf_formats_walk("gltf-pointers.md", "Animation pointers", rows, sizeof rows / sizeof *rows);
}

/* ----------------------------------------------------------------------------- interpolation -- */

/* Keys at 1, 2 and 4 s of a colour: v; with tangents where they are cubic, which are a of each key
 * and b. */
static void put_colours(gltf_text *text, bool cubic)
{
    static const float moments[3] = {1, 2, 4};
    static const float v[3][4] = {{1, 0, 0, 1}, {0, 0, 1, 1}, {0.5f, 1, 0, 0}},
                       in[4] = {0.25f, 0, 0, 0}, out[4] = {0, 0.5f, 0, 0};
    float values[36];
    for (int k = 0; k < 3; k++) {
        float *at = cubic ? values + 12 * k : values + 4 * k;
        if (cubic) {
            memcpy(at, in, sizeof in);
            memcpy(at + 8, out, sizeof out);
            at += 4;
        }
        memcpy(at, v[k], sizeof v[k]);
    }
    put_corners(text);
    gltf_put_floats(text, moments, 3, "SCALAR");
    gltf_put_floats(text, values, cubic ? 9 : 3, "VEC4");
}

static void a_colour_goes_from_key_to_key_as_its_sampler_says(void **state)
{
    (void)state;
    /* CUBICSPLINE at a share s of d seconds: (2s3 - 3s2 + 1) v + d (s3 - 2s2 + s) out +
     * (3s2 - 2s3) v' + d (s3 - s2) in; at s = 1/2 1/2, d/8, 1/2, -d/8 */
    static const struct {
        const char *words;
        double seconds, is[4];
    } cases[] = {
        {"", 0, {1, 0, 0, 1}},
        {"", 1, {1, 0, 0, 1}},
        {"", 1.5, {0.5, 0, 0.5, 1}}, /* on a sphere it would be 0.707 */
        {",'interpolation':'LINEAR'", 1.25, {0.75, 0, 0.25, 1}},
        {"", 3.5, {0.375, 0.75, 0.25, 0.25}},
        {"", 9, {0.5, 1, 0, 0}},
        {",'interpolation':'STEP'", 1.99, {1, 0, 0, 1}},
        {",'interpolation':'STEP'", 2, {0, 0, 1, 1}},
        {",'interpolation':'CUBICSPLINE'", 0.5, {1, 0, 0, 1}},
        {",'interpolation':'CUBICSPLINE'", 1.5, {0.5 - 0.25 / 8, 0.5 / 8, 0.5, 1}},
        {",'interpolation':'CUBICSPLINE'", 3, {0.25 - 0.25 / 4, 0.5 + 0.5 / 4, 0.5, 0.5}},
        {",'interpolation':'CUBICSPLINE'", 4, {0.5, 1, 0, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        gltf_text text = {0};
        double found[4];
        put_colours(&text, strstr(cases[i].words, "CUBIC"));
        lf_mesh_data data = follow(&text, BASE, cases[i].words, cases[i].seconds);
        look_base(&data, found);
        for (int c = 0; c < 4; c++)
            if (fabs(found[c] - cases[i].is[c]) > 1e-6)
                fail_msg("%s at %g s: %d is %g", cases[i].words, cases[i].seconds, c, found[c]);
        lf_assert_close(data.span, 4, 0, 0);
        lf_mesh_data_finish(&data);
    }
}

/* Of a half turn about z in a quarter of the way, and of numbers that are no unit quaternion. */
static void turns_are_unit_quaternions(void **state)
{
    (void)state;
    static const struct {
        const char *words;
        float values[24];
        double angle;
    } cases[] = {
        {"", {0, 0, 0, 1, 0, 0, 1, 0}, 0.78539816},
        {"", {0, 0, 0, 1, 0, 0, -1, 0}, -0.78539816},
        {"", {0, 0, 0, -1, 0, 0, 0.70710678f, 0.70710678f}, 0.39269908}, /* the shorter way */
        {",'interpolation':'STEP'", {0, 0, 3, 3, 0, 0, 0, 1}, 1.57079633},
        /* s = 1/4: 0.84375 (0, 1) + 0.15625 (1, 0), not of length 1 */
        {",'interpolation':'CUBICSPLINE'",
         {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0},
         0.36622163},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const double *corner;
        gltf_text text = {0};
        put_corners(&text);
        gltf_put_floats(&text, two_moments, 2, "SCALAR");
        gltf_put_floats(&text, cases[i].values, strstr(cases[i].words, "CUBIC") ? 6 : 2, "VEC4");
        lf_mesh_data data = follow(&text, "/nodes/0/rotation", cases[i].words, 0.25);
        corner = corner_of(&data, 0);
        lf_assert_close(atan2(corner[1], corner[0]), cases[i].angle, 0, 1e-6);
        lf_assert_close(hypot(corner[0], corner[1]), 1, 0, 1e-6);
        lf_mesh_data_finish(&data);
    }
}

/* 0 to 255, normalised or not, of two keys. */
static void whole_numbers_are_converted_before_they_are_interpolated(void **state)
{
    (void)state;
    static const struct {
        unsigned char bytes[8];
        int type;
        const char *more;
        double is;
    } cases[] = {{{51, 255}, 5121, ",'normalized':true", 0.4},
                 {{0, 1}, 5121, "", 0.25},
                 {{0, 0, 255, 255}, 5123, ",'normalized':true", 0.25},
                 {{127, 0}, 5120, ",'normalized':true", 0.75},
                 {{0, 0, 255, 127}, 5122, ",'normalized':true", 0.25}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        gltf_text text = {0};
        put_corners(&text);
        gltf_put_floats(&text, two_moments, 2, "SCALAR");
        gltf_accessor(&text, gltf_view(&text, cases[i].bytes, 8, ""), cases[i].type, 2, "SCALAR",
                      cases[i].more);
        lf_mesh_data data =
            follow(&text, "/materials/0/pbrMetallicRoughness/metallicFactor", "", 0.25);
        lf_assert_close((double)data.materials[0].metallic, cases[i].is, 0, 1e-6);
        lf_mesh_data_finish(&data);
    }
}

/* ----------------------------------------------------------------------- with other channels -- */

/* A node's own channel moves it along x, a pointer bends it and another turns a joint. */
static void pointers_go_with_channels_that_name_nodes(void **state)
{
    (void)state;
    static const float way[6] = {0, 0, 0, 4, 0, 0}, bend[4] = {0, 0, 1, 1};
    gltf_text text = {0};
    put_corners(&text);
    gltf_put_floats(&text, two_moments, 2, "SCALAR");
    gltf_put_floats(&text, way, 2, "VEC3");
    gltf_put_floats(&text, bend, 4, "SCALAR");
    lf_mesh_data data = read_channels(
        &text,
        "{'sampler':0,'target':{'node':0,'path':'translation'}},"
        "{'sampler':1,'target':{'path':'pointer','extensions':{'KHR_animation_pointer':{"
        "'pointer':'/nodes/0/weights'}}}}",
        "{'input':3,'output':4},{'input':3,'output':5}");
    lf_assert_close(corner_of(&data, 2)[0], 1 + 0.25, 0, 1e-6);
    lf_assert_close(corner_of(&data, 2)[1], 0.25, 0, 1e-6);
    assert_false(gltf_warns(&data, "animation channel"));
    lf_mesh_data_finish(&data);
}

static void a_joint_that_a_pointer_moves_takes_its_skin_along(void **state)
{
    (void)state;
    static const float way[6] = {0, 0, 0, 4, 0, 0},
                       weights[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    static const unsigned char joints[12] = {0};
    lf_mesh_desc desc = gltf_desc();
    lf_mesh_data data = {0};
    lf_error err = {0};
    gltf_text text = {0};
    put_corners(&text);
    gltf_put_floats(&text, two_moments, 2, "SCALAR");
    gltf_put_floats(&text, way, 2, "VEC3");
    gltf_put_floats(&text, weights, 3, "VEC4");
    gltf_accessor(&text, gltf_view(&text, joints, 12, ""), 5121, 3, "VEC4", "");
    desc.clip.seconds = 0.25;
    lf_assert_ok(
        gltf_read_as(&text,
                     "'extensionsRequired':['KHR_animation_pointer'],"
                     "'scene':0,'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0,'skin':0},"
                     "{'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,7,7,7,1]}],'skins':[{'joints':[1]}],"
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'JOINTS_0':6,"
                     "'WEIGHTS_0':5}}]}],'animations':[{'channels':[" POINTER(
                         "/nodes/1/translation") "],'samplers':[{'input':3,'output':4}]}]",
                     &desc, &data, &err),
        &err);
    lf_assert_close(corner_of(&data, 0)[0], 2, 0, 1e-6);
    lf_assert_close(corner_of(&data, 0)[1], 0, 0, 1e-6);
    lf_mesh_data_finish(&data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pointers_move_what_the_page_says),
        cmocka_unit_test(a_colour_goes_from_key_to_key_as_its_sampler_says),
        cmocka_unit_test(turns_are_unit_quaternions),
        cmocka_unit_test(whole_numbers_are_converted_before_they_are_interpolated),
        cmocka_unit_test(pointers_go_with_channels_that_name_nodes),
        cmocka_unit_test(a_joint_that_a_pointer_moves_takes_its_skin_along),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
