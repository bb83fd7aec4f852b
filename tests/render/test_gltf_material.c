/* Materials of glTF, word for word: factors, extensions, textures and how they lie, tangents, and
 * what is lost, in words. */
#include "tests/render/gltf_text.h"

#include "render/scene/vec_double.h"

static const float corner3[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/* A triangle of a material, whose first texture is sampled so; more: members of the document, each
 * behind a comma. */
static lf_mesh_data read_sampled(const char *material, const char *sampler, const char *more)
{
    char rest[4096];
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    gltf_put_floats(&text, corner3, 3, "VEC2");
    snprintf(rest, sizeof rest,
             "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':1,'TEXCOORD_1':1},"
             "'material':0}]}],"
             "'textures':[{'source':0,'sampler':0},{'source':1},"
             "{'extensions':{'KHR_texture_basisu':{'source':0}}}],'samplers':[{%s}],"
             "'images':[{'uri':'%s'},{'uri':'data:;base64,AAAA'}]"
             ",'materials':[{%s}]%s," GLTF_ONE_NODE,
             sampler, GLTF_PNG, material, more);
    return gltf_read(&text, rest);
}

static lf_mesh_data read_material(const char *material, const char *more)
{
    return read_sampled(material, "'wrapS':33648,'wrapT':33071,'magFilter':9728", more);
}

static void assert_vec(lf_vec3 v, double x, double y, double z)
{
    lf_assert_close((double)v.x, x, 1e-5, 1e-6);
    lf_assert_close((double)v.y, y, 1e-5, 1e-6);
    lf_assert_close((double)v.z, z, 1e-5, 1e-6);
}

static void factors_are_words_of_the_material(void **state)
{
    (void)state;
    lf_mesh_data data = read_material(
        "'pbrMetallicRoughness':{'baseColorFactor':[0.1,0.2,0.3,0.4],'metallicFactor':0.25,"
        "'roughnessFactor':0.75},'emissiveFactor':[1,0.5,0],'alphaMode':'MASK','alphaCutoff':0.3,"
        "'doubleSided':true,'extensions':{'KHR_materials_emissive_strength':{"
        "'emissiveStrength':4}}",
        "");
    const lf_material *m = &data.materials[0];
    assert_vec(m->albedo, 0.1, 0.2, 0.3);
    assert_vec(m->emission, 4, 2, 0);
    assert_true(m->metallic == 0.25f && m->roughness == 0.75f && m->ior == 1.5f);
    assert_true(m->cover == LF_COVER_MASK && m->alpha == 0.4f && m->alpha_cutoff == 0.3f);
    assert_true(m->specular == 1 && m->coat == 0 && m->transmission == 0 && !m->is_solid);
    assert_null(data.textures);
    assert_int_equal(data.warnings.n, 0);
    lf_mesh_data_finish(&data);
}

static void what_is_not_said_is_as_the_specification_has_it(void **state)
{
    (void)state;
    lf_mesh_data data = read_material("'name':'plain'", "");
    const lf_material *m = &data.materials[0];
    assert_vec(m->albedo, 1, 1, 1);
    assert_true(m->metallic == 1 && m->roughness == 1 && m->alpha == 1 &&
                m->cover == LF_COVER_OPAQUE && m->alpha_cutoff == 0.5f);
    lf_mesh_data_finish(&data);
    data = read_material("", ""); /* nameless, and says nothing: grey, as without any */
    assert_vec(data.materials[0].albedo, 0.5, 0.5, 0.5);
    assert_true(data.materials[0].metallic == 0);
    lf_mesh_data_finish(&data);
}

static void extensions_are_words_of_the_material(void **state)
{
    (void)state;
    lf_mesh_data data = read_material(
        "'name':'x','extensions':{'KHR_materials_ior':{'ior':1.8},'KHR_materials_specular':{"
        "'specularFactor':0.5,'specularColorFactor':[1,0.5,0.25]},'KHR_materials_clearcoat':{"
        "'clearcoatFactor':0.7,'clearcoatRoughnessFactor':0.2},'KHR_materials_sheen':{"
        "'sheenColorFactor':[0.1,0.2,0.3],'sheenRoughnessFactor':0.6},"
        "'KHR_materials_transmission':{'transmissionFactor':0.9},'KHR_materials_volume':{"
        "'thicknessFactor':0.1,'attenuationDistance':2,'attenuationColor':[1,0.5,0.25]}}",
        "");
    const lf_material *m = &data.materials[0];
    assert_true(m->ior == 1.8f && m->specular == 0.5f && m->coat == 0.7f &&
                m->coat_roughness == 0.2f && m->sheen_roughness == 0.6f);
    assert_vec(m->specular_tint, 1, 0.5, 0.25);
    assert_vec(m->sheen, 0.1, 0.2, 0.3);
    assert_true(m->transmission == 0.9f && m->is_solid);
    assert_vec(m->absorption, 0, log(2) / 2, log(4) / 2);
    assert_int_equal(data.warnings.n, 0);
    lf_mesh_data_finish(&data);
}

static void layers_have_pictures_of_their_own(void **state)
{
    (void)state;
    lf_mesh_data data = read_material(
        "'name':'x','extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.7,"
        "'clearcoatNormalTexture':{'index':0},'clearcoatTexture':{'index':0,'texCoord':1},'"
        "clearcoatRoughnessTexture':{'index':0}},"
        "'KHR_materials_sheen':{'sheenColorTexture':{'index':0},'sheenRoughnessTexture':{'index':"
        "0}},'KHR_materials_transmission':{'transmissionTexture':{'index':0}},"
        "'KHR_materials_specular':{'specularTexture':{'index':0},'specularColorTexture':{'index':"
        "0}},'KHR_materials_anisotropy':{'anisotropyStrength':0.5,'anisotropyTexture':{'index':0}}"
        "}",
        "");
    const lf_texture_set *set = &data.textures[0];
    for (int slot = 0; slot < LF_SLOTS; slot++)
        assert_int_equal(set->slot[slot].picture, slot >= LF_SLOT_COAT);
    assert_int_equal(set->slot[LF_SLOT_COAT].set, 1);
    assert_int_equal(data.warnings.n, 0);
    lf_mesh_data_finish(&data);
}

/* NEAREST and LINEAR have no smaller copies; the other words, and none, do. */
static void smaller_copies_are_a_matter_of_the_sampler(void **state)
{
    (void)state;
    static const char *const words[] = {"", ",'minFilter':9728", ",'minFilter':9729",
                                        ",'minFilter':9984", ",'minFilter':9987"};
    for (int i = 0; i < 5; i++) {
        char more[64];
        snprintf(more, sizeof more, "'magFilter':9729%s", words[i]);
        lf_mesh_data data = read_sampled(
            "'name':'x','pbrMetallicRoughness':{'baseColorTexture':{'index':0}}", more, "");
        assert_int_equal(data.textures[0].slot[LF_SLOT_BASE].finest, i == 1 || i == 2);
        lf_mesh_data_finish(&data);
    }
}

/* Tangents lie along the first coordinates where the file has none, and nothing else wants some. */
static void grooves_want_tangents(void **state)
{
    (void)state;
    lf_mesh_data data = read_material(
        "'name':'x','extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':0.5,"
        "'anisotropyRotation':1.5}}",
        "");
    const lf_material *m = &data.materials[0];
    lf_assert_close((double)m->anisotropy, 0.5, 0, 0);
    lf_assert_close((double)m->anisotropy_rotation[0], cos(1.5), 1e-6, 0);
    lf_assert_close((double)m->anisotropy_rotation[1], sin(1.5), 1e-6, 0);
    assert_true(data.n_uv_sets == 1 && data.tangents && !data.textures);
    assert_int_equal(data.warnings.n, 0);
    lf_mesh_data_finish(&data);
    data = read_material("'name':'x','extensions':{'KHR_materials_anisotropy':{}}", "");
    assert_true(data.materials[0].anisotropy == 0.0f && !data.tangents);
    lf_mesh_data_finish(&data);
}

static void absorption_is_per_unit_of_the_scene(void **state)
{
    (void)state;
    gltf_text text = {0};
    lf_mesh_desc desc = gltf_desc();
    lf_mesh_data data = {0};
    lf_error err;
    gltf_put_floats(&text, corner3, 3, "VEC3");
    for (int i = 0; i < 3; i++)
        desc.transform.m[i][i] = 10;
    assert_int_equal(
        gltf_read_as(&text,
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],"
                     "'materials':[{'extensions':{'KHR_materials_volume':{'thicknessFactor':1,"
                     "'attenuationDistance':1,'attenuationColor':[0.5,0.5,0.5]}}}]," GLTF_ONE_NODE,
                     &desc, &data, &err),
        LF_OK);
    lf_assert_close((double)data.materials[0].absorption.x, log(2) / 10, 1e-5, 0);
    lf_mesh_data_finish(&data);
}

static void a_sheet_absorbs_nothing_inside(void **state)
{
    (void)state;
    lf_mesh_data data = read_material(
        "'extensions':{'KHR_materials_transmission':{'transmissionFactor':1},"
        "'KHR_materials_volume':{'attenuationDistance':2,'attenuationColor':[0.5,0.5,0.5]}}",
        "");
    assert_false(data.materials[0].is_solid);
    assert_vec(data.materials[0].absorption, 0, 0, 0);
    lf_mesh_data_finish(&data);
}

static void an_index_of_zero_leaves_reflectance_to_the_tint(void **state)
{
    (void)state;
    lf_mesh_data data =
        read_material("'extensions':{'KHR_materials_ior':{'ior':0},'KHR_materials_specular':{"
                      "'specularColorFactor':[0.04,0.02,0]}}",
                      "");
    const lf_material *m = &data.materials[0];
    lf_assert_close((double)m->ior, 1.5, 1e-5, 0);
    assert_vec(m->specular_tint, 1, 0.5, 0);
    lf_mesh_data_finish(&data);
}

/* What a material reflects straight on, of the second channel: KHR_materials_ior and _specular,
 * specular min(f0 colour, 1) of f0 = ((ior - 1) / (ior + 1))^2, and 1 for the index 0. */
static void assert_reflects(const char *extensions, double right)
{
    char material[512];
    snprintf(material, sizeof material, "'name':'x','extensions':{%s}", extensions);
    lf_mesh_data data = read_material(material, "");
    const lf_material *m = &data.materials[0];
    double r = ((double)m->ior - 1) / ((double)m->ior + 1),
           got = r * r * (double)m->specular * (double)m->specular_tint.y;
    if (!(fabs(got - right) < 1e-5))
        fail_msg("%s: reflects %g, not %g", extensions, got, right);
    if (data.warnings.n > 0)
        fail_msg("%s: %s", extensions, lf_warnings_at(&data.warnings, 0));
    lf_mesh_data_finish(&data);
}

static void any_index_and_tint_that_gltf_allows_reflects_what_it_says(void **state)
{
    (void)state;
#define INDEX(i) "'KHR_materials_ior':{'ior':" i "}"
#define TINT(t) "'KHR_materials_specular':{'specularColorFactor':[" t "]}"
    assert_reflects(INDEX("1.5"), 0.04);
    assert_reflects(INDEX("4"), 0.36);
    assert_reflects(INDEX("1000"), 0.996008);
    assert_reflects(INDEX("0"), 1);
    assert_reflects(INDEX("0") ",'KHR_materials_specular':{'specularFactor':0.5}", 0.5);
    assert_reflects(INDEX("0") "," TINT("0.9,0.9,0.9"), 0.9);
    assert_reflects(INDEX("1000") "," TINT("0.9,0.9,0.9"), 0.896407);
    assert_reflects(TINT("5,5,5"), 0.2);
    assert_reflects(TINT("0,5,10"), 0.2);
    assert_reflects(TINT("100,30,0"), 1);
    assert_reflects(INDEX("2") "," TINT("1.5,0.5,0.5"), 1.0 / 18);
#undef INDEX
#undef TINT
}

/* Of glass the index bends light, and is not what a tint above 1 becomes: it is told. */
static void values_beyond_what_can_be_shown_are_cut_and_told(void **state)
{
    (void)state;
    lf_mesh_data data = read_material(
        "'name':'lens','extensions':{'KHR_materials_transmission':{'transmissionFactor':1},"
        "'KHR_materials_specular':{'specularColorFactor':[2,2,2]},'KHR_materials_ior':{'ior':1.7}}",
        "");
    assert_true(data.materials[0].ior == 1.7f);
    assert_true(gltf_warns(&data, "material \"lens\": values out of range are clamped: specular "
                                  "colour (2, 2, 2) to (1, 1, 1)"));
    lf_mesh_data_finish(&data);
    data = read_material("'name':'x','pbrMetallicRoughness':{'roughnessFactor':1.5,"
                         "'metallicFactor':-1},'extensions':{'KHR_materials_ior':{'ior':0.5}}",
                         "");
    assert_true(gltf_warns(&data, "roughness 1.5 to 1, metallic -1 to 0, index of refraction 0.5 "
                                  "to 1.5"));
    assert_int_equal(data.warnings.n, 1);
    lf_mesh_data_finish(&data);
}

static void a_cutoff_above_one_hides_all(void **state)
{
    (void)state;
    lf_mesh_data data = read_material("'alphaMode':'MASK','alphaCutoff':1.1", "");
    const lf_material *m = &data.materials[0];
    assert_true(m->cover == LF_COVER_MASK && m->alpha < m->alpha_cutoff);
    assert_int_equal(data.warnings.n, 0);
    lf_mesh_data_finish(&data);
}

static void what_lets_no_light_through_is_black_at_any_depth(void **state)
{
    (void)state;
    lf_mesh_data data = read_material(
        "'extensions':{'KHR_materials_volume':{'thicknessFactor':1,'attenuationDistance':2,"
        "'attenuationColor':[0,1,1]},'KHR_materials_transmission':{'transmissionFactor':1}}",
        "");
    lf_assert_close((double)data.materials[0].absorption.x, 1e9, 0, 1);
    lf_assert_close((double)data.materials[0].absorption.y, 0, 0, 0);
    lf_mesh_data_finish(&data);
}

static void the_older_model_becomes_the_newer(void **state)
{
    (void)state;
    lf_mesh_data data = read_material(
        "'extensions':{'KHR_materials_pbrSpecularGlossiness':{'diffuseFactor':[0.5,0.4,0.3,1],"
        "'specularFactor':[0.04,0.04,0.04],'glossinessFactor':0.75}}",
        "");
    assert_true(data.materials[0].metallic == 0 && data.materials[0].roughness == 0.25f);
    assert_vec(data.materials[0].albedo, 0.5, 0.4, 0.3);
    assert_true(gltf_warns(&data, "is converted to metallic-roughness"));
    lf_mesh_data_finish(&data);
    data = read_material("'extensions':{'KHR_materials_pbrSpecularGlossiness':{"
                         "'diffuseFactor':[0,0,0,1],'specularFactor':[0.9,0.6,0.2]}}",
                         "");
    assert_true(data.materials[0].metallic > 0.99f);
    lf_assert_close((double)data.materials[0].albedo.x, 0.9, 0.02, 0);
    lf_assert_close((double)data.materials[0].albedo.z, 0.2, 0.02, 0);
    lf_mesh_data_finish(&data);
}

static void what_is_unlit_emits_its_colour(void **state)
{
    (void)state;
    lf_mesh_data data =
        read_material("'pbrMetallicRoughness':{'baseColorFactor':[0.5,0.25,0,1],"
                      "'baseColorTexture':{'index':0}},'extensions':{'KHR_materials_unlit':{}}",
                      "");
    assert_vec(data.materials[0].albedo, 0, 0, 0);
    assert_vec(data.materials[0].emission, 0.5, 0.25, 0);
    assert_int_equal(data.textures[0].slot[LF_SLOT_EMISSION].picture, 1);
    assert_int_equal(data.textures[0].slot[LF_SLOT_BASE].picture, 0);
    lf_mesh_data_finish(&data);
    data = read_material(/* neither black nor white where its picture is not to be had */
                         "'pbrMetallicRoughness':{'baseColorFactor':[0.5,0.25,0,1],"
                         "'baseColorTexture':{'index':1}},'extensions':{'KHR_materials_unlit':{}}",
                         "");
    assert_vec(data.materials[0].albedo, 0.5, 0.25, 0);
    assert_vec(data.materials[0].emission, 0, 0, 0);
    assert_true(gltf_warns(&data, "texture 1 (images[1]): "));
    assert_true(gltf_warns(&data, "unlit textures are not supported; the material is lit"));
    lf_mesh_data_finish(&data);
}

/* Colours of vertices count for what is unlit as for what is lit. */
static void what_is_unlit_emits_the_colours_of_its_vertices(void **state)
{
    (void)state;
    static const float green[12] = {0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1};
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    gltf_put_floats(&text, green, 3, "VEC4");
    lf_mesh_data data = gltf_read(
        &text, "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':1},'material':0}]}],"
               "'materials':[{'extensions':{'KHR_materials_unlit':{}}}]," GLTF_ONE_NODE);
    assert_vec(data.materials[0].emission, 1, 1, 1);
    assert_vec(data.materials[0].albedo, 0, 0, 0);
    assert_true(data.materials[0].tint == LF_TINT_ALL);
    assert_memory_equal(data.colours, green, sizeof green);
    assert_int_equal(data.warnings.n, 0);
    lf_mesh_data_finish(&data);
}

/* ---------------------------------------------------------------------------------- textures -- */

static void textures_lie_as_they_are_told(void **state)
{
    (void)state;
    lf_mesh_data data = read_material(
        "'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':0,'extensions':{"
        "'KHR_texture_transform':{'offset':[0.5,0.25],'rotation':1.57079633,'scale':[2,3],"
        "'texCoord':1}}},'metallicRoughnessTexture':{'index':0}},"
        "'normalTexture':{'index':0,'scale':0.5}",
        "");
    const lf_texture *base = &data.textures[0].slot[LF_SLOT_BASE],
                     *metal = &data.textures[0].slot[LF_SLOT_METAL_ROUGH],
                     *normal = &data.textures[0].slot[LF_SLOT_NORMAL];
    /* scaled, turned against the clock (v points down), moved */
    static const float expected[2][3] = {{0, 3, 0.5f}, {-2, 0, 0.25f}};
    for (int i = 0; i < 6; i++)
        lf_assert_close((double)base->map[i / 3][i % 3], (double)expected[i / 3][i % 3], 0, 1e-6);
    assert_true(base->picture == 1 && base->set == 1 && base->nearest);
    assert_true(base->wrap_u == LF_WRAP_MIRROR && base->wrap_v == LF_WRAP_CLAMP);
    assert_true(metal->picture == 1 && metal->set == 0 && metal->map[0][0] == 1 &&
                metal->map[0][1] == 0 && metal->map[1][1] == 1);
    assert_true(normal->picture == 1 && normal->scale == 0.5f);
    assert_int_equal(data.textures[0].slot[LF_SLOT_EMISSION].picture, 0);
    assert_int_equal(data.n_pictures, 1); /* once, however often it is named */
    assert_true(data.pictures[0].width == 1 && data.pictures[0].height == 1);
    assert_int_equal(data.n_uv_sets, 2);
    assert_non_null(data.tangents);
    lf_mesh_data_finish(&data);
}

static void pictures_that_cannot_be_read_leave_the_factors(void **state)
{
    (void)state;
    lf_mesh_data data = read_material(
        "'name':'m','pbrMetallicRoughness':{'baseColorFactor':[0.5,0.5,0.5,1],"
        "'baseColorTexture':{'index':1}},'emissiveTexture':{'index':1},'emissiveFactor':[1,1,1]",
        "");
    assert_vec(data.materials[0].albedo, 0.5, 0.5, 0.5);
    assert_vec(data.materials[0].emission, 0, 0, 0); /* never white all over */
    assert_null(data.textures);
    assert_null(data.pictures);
    assert_true(gltf_warns(&data, "texture 1 (images[1]): "));
    assert_true(gltf_warns(&data, "the material is used without it"));
    assert_true(gltf_warns(&data, "the emission texture is not supported"));
    lf_mesh_data_finish(&data);
    data = read_material("'emissiveTexture':{'index':2},'emissiveFactor':[1,1,1]", "");
    assert_vec(data.materials[0].emission, 0, 0, 0);
    assert_true(gltf_warns(&data, "textures in KTX2 only are not supported"));
    lf_mesh_data_finish(&data);
}

static void what_has_no_place_is_told(void **state)
{
    (void)state;
    static const char *const words[] = {
        "the ambient occlusion texture is ignored",
        "iridescence is left out",
        "dispersion is left out",
        "diffuse transmission is left out",
        "the extension KHR_materials_whatever of 1 material is not supported",
        "textures of thickness"};
    lf_mesh_data data = read_material(
        "'name':'m','occlusionTexture':{'index':0},'extensions':{'KHR_materials_iridescence':{"
        "'iridescenceFactor':1},"
        "'KHR_materials_dispersion':{'dispersion':0.1},'KHR_materials_diffuse_transmission':{"
        "'diffuseTransmissionFactor':0.1},'KHR_materials_whatever':{},"
        "'KHR_materials_volume':{'thicknessFactor':1,'thicknessTexture':{'index':0}}}",
        "");
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!gltf_warns(&data, words[i]))
            fail_msg("no warning says \"%s\"", words[i]);
    assert_int_equal(data.warnings.n, 6);
    lf_mesh_data_finish(&data);
}

static void materials_that_nothing_uses_are_not_looked_at(void **state)
{
    (void)state;
    lf_mesh_data data = read_material("'name':'used'", "");
    lf_mesh_data_finish(&data);
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    data = gltf_read(&text,
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],"
                     "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"
                     "}],'textures':[{'source':0}],'images':[{'uri':'gone.png'}]," GLTF_ONE_NODE);
    assert_int_equal(data.n_pictures, 0);
    assert_int_equal(data.warnings.n, 0);
    assert_int_equal(data.triangle_material[0], 1); /* made up: grey */
    assert_vec(data.materials[1].albedo, 0.5, 0.5, 0.5);
    lf_mesh_data_finish(&data);
}

static void two_sets_of_coordinates_lie_one_behind_the_other(void **state)
{
    (void)state;
    static const float first[6] = {0, 0, 0.25f, 0, 0, 0.5f};
    static const uint16_t second[6] = {65535, 0, 0, 65535, 0, 0};
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    gltf_put_floats(&text, first, 3, "VEC2");
    gltf_accessor(&text, gltf_view(&text, second, sizeof second, ""), 5123, 3, "VEC2",
                  ",'normalized':true");
    lf_mesh_data data = gltf_read(
        &text,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':1,'TEXCOORD_1':2},"
        "'material':0},{'attributes':{'POSITION':0}}]}],'materials':[{'pbrMetallicRoughness':{"
        "'baseColorTexture':{'index':0,'texCoord':1}}}],'textures':[{'source':0}],"
        "'images':[{'uri':'" GLTF_PNG "'}]," GLTF_ONE_NODE);
    assert_int_equal(data.n_uv_sets, 2);
    assert_int_equal(data.n_vertices, 6);
    assert_memory_equal(data.uvs, first, sizeof first);
    assert_true(data.uvs[12] == 1 && data.uvs[13] == 0 && data.uvs[15] == 1);
    for (int i = 6; i < 12; i++) /* of the part that has none */
        assert_true(data.uvs[i] == 0 && data.uvs[12 + i] == 0);
    assert_null(data.colours);
    assert_null(data.tangents);
    lf_mesh_data_finish(&data);
}

static void colours_of_vertices_make_white_of_no_material(void **state)
{
    (void)state;
    static const float colours[12] = {1, 0.5f, 0, 0.25f, 2, -1, 0, 1, 0, 0, 0, 0};
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    gltf_put_floats(&text, colours, 3, "VEC4");
    lf_mesh_data data =
        gltf_read(&text, "'meshes':[{'primitives':[{'attributes':{'POSITION':0}},"
                         "{'attributes':{'POSITION':0,'COLOR_0':1}}]}]," GLTF_ONE_NODE);
    assert_vec(data.materials[data.triangle_material[0]].albedo, 0.5, 0.5, 0.5);
    assert_vec(data.materials[data.triangle_material[1]].albedo, 1, 1, 1);
    assert_true(data.colours[0] == 1 && data.colours[3] == 1); /* of the part that has none */
    assert_true(data.colours[13] == 0.5f && data.colours[15] == 0.25f);
    assert_true(data.colours[16] == 1 && data.colours[17] == 0);
    lf_mesh_data_finish(&data);
}

/* ---------------------------------------------------------------------------------- tangents -- */

#define BUMPY                                                                                      \
    "'materials':[{'normalTexture':{'index':0}}],'textures':[{'source':0}],"                       \
    "'images':[{'uri':'" GLTF_PNG "'}]"

/* Two triangles that face z: u goes right in the first and left in the second, v down in both. */
static void say_mirrored(gltf_text *text)
{
    static const float positions[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0},
                       normals[18] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1},
                       uvs[12] = {0, 1, 1, 1, 0, 0, 1, 1, 0, 1, 1, 0};
    gltf_put_floats(text, positions, 6, "VEC3");
    gltf_put_floats(text, normals, 6, "VEC3");
    gltf_put_floats(text, uvs, 6, "VEC2");
}

static void tangents_follow_u_and_know_their_side(void **state)
{
    (void)state;
    gltf_text text = {0};
    say_mirrored(&text);
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        char rest[2048];
        snprintf(rest, sizeof rest,
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':2},"
                 "'material':0}]}],%s,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,"
                 "'scale':[%d,1,1]}]",
                 BUMPY, mirrored ? -1 : 1);
        lf_mesh_data data = gltf_read(&text, rest);
        for (size_t v = 0; v < 6; v++) {
            const float *t = data.tangents + 4 * v;
            float right = (v < 3) != (mirrored != 0) ? 1.0f : -1.0f;
            lf_assert_close((double)t[0], (double)right, 0, 1e-6);
            /* its bitangent is where green points: up, against v */
            assert_true(t[3] == right);
        }
        lf_mesh_data_finish(&data);
    }
}

static void tangents_of_the_file_flip_where_it_is_mirrored(void **state)
{
    (void)state;
    static const float tangents[24] = {0, 2, 0, 1, 0, 2, 0, 1, 0, 2, 0, 1,
                                       0, 2, 0, 1, 0, 2, 1, 1, 0, 2, 0, -1};
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        char rest[2048];
        gltf_text text = {0};
        say_mirrored(&text);
        gltf_put_floats(&text, tangents, 6, "VEC4");
        snprintf(rest, sizeof rest,
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':2,"
                 "'TANGENT':3},'material':0}]}],%s,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,"
                 "'scale':[%d,1,1]}]",
                 BUMPY, mirrored ? -1 : 1);
        lf_mesh_data data = gltf_read(&text, rest);
        for (size_t v = 0; v < 6; v++) {
            const float *t = data.tangents + 4 * v;
            lf_assert_close((double)t[1], 1, 0, 1e-6); /* across the normal, of unit length */
            lf_assert_close((double)t[2], 0, 0, 1e-6);
            assert_true(t[3] == ((v == 5) == (mirrored != 0) ? 1.0f : -1.0f));
        }
        lf_mesh_data_finish(&data);
    }
}

static void without_coordinates_a_tangent_is_some_unit_vector(void **state)
{
    (void)state;
    gltf_text text = {0};
    say_mirrored(&text);
    lf_mesh_data data = gltf_read(
        &text,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1},'material':0}]}]," BUMPY
        "," GLTF_ONE_NODE);
    for (size_t v = 0; v < 6; v++) {
        const float *t = data.tangents + 4 * v;
        lf_assert_close((double)(t[0] * t[0] + t[1] * t[1]), 1, 0, 1e-6);
        assert_true(t[2] == 0 && fabsf(t[3]) == 1);
    }
    lf_mesh_data_finish(&data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(factors_are_words_of_the_material),
        cmocka_unit_test(what_is_not_said_is_as_the_specification_has_it),
        cmocka_unit_test(extensions_are_words_of_the_material),
        cmocka_unit_test(layers_have_pictures_of_their_own),
        cmocka_unit_test(smaller_copies_are_a_matter_of_the_sampler),
        cmocka_unit_test(grooves_want_tangents),
        cmocka_unit_test(absorption_is_per_unit_of_the_scene),
        cmocka_unit_test(a_sheet_absorbs_nothing_inside),
        cmocka_unit_test(an_index_of_zero_leaves_reflectance_to_the_tint),
        cmocka_unit_test(any_index_and_tint_that_gltf_allows_reflects_what_it_says),
        cmocka_unit_test(values_beyond_what_can_be_shown_are_cut_and_told),
        cmocka_unit_test(a_cutoff_above_one_hides_all),
        cmocka_unit_test(what_lets_no_light_through_is_black_at_any_depth),
        cmocka_unit_test(the_older_model_becomes_the_newer),
        cmocka_unit_test(what_is_unlit_emits_its_colour),
        cmocka_unit_test(what_is_unlit_emits_the_colours_of_its_vertices),
        cmocka_unit_test(textures_lie_as_they_are_told),
        cmocka_unit_test(pictures_that_cannot_be_read_leave_the_factors),
        cmocka_unit_test(what_has_no_place_is_told),
        cmocka_unit_test(materials_that_nothing_uses_are_not_looked_at),
        cmocka_unit_test(two_sets_of_coordinates_lie_one_behind_the_other),
        cmocka_unit_test(colours_of_vertices_make_white_of_no_material),
        cmocka_unit_test(tangents_follow_u_and_know_their_side),
        cmocka_unit_test(tangents_of_the_file_flip_where_it_is_mirrored),
        cmocka_unit_test(without_coordinates_a_tangent_is_some_unit_vector),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
