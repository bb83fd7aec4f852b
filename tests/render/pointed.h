/* A glTF file of everything that animation pointers can name, and what one of its channels makes of
 * it. Read in the test's own process. */
#ifndef LF_TESTS_POINTED_H
#define LF_TESTS_POINTED_H

#include "tests/render/gltf_text.h"

#define BASE "/materials/0/pbrMetallicRoughness/baseColorFactor"

/* Three corners, one on each axis, and what two morph targets add: 1 along x, 1 along y. */
static const float corners[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                   along_x[9] = {1, 0, 0, 1, 0, 0, 1, 0, 0},
                   along_y[9] = {0, 1, 0, 0, 1, 0, 0, 1, 0};

/* Everything that the object model names is there once, at its default or at a value that lets it
 * show. nodes[0] has a mesh, [1] a light, [2] and [3] cameras, [4] a mesh that stays. @: a texture
 * that is moved by nothing. */
static const char document[] =
    "'scene':0,'scenes':[{'nodes':[0,1,2,3,4]}],'nodes':[{'mesh':0,'extensions':{"
    "'KHR_node_visibility':{},'KHR_node_hoverability':{},'KHR_node_selectability':{},"
    "'EXT_lights_ies':{'light':0}}},"
    "{'extensions':{'KHR_lights_punctual':{'light':0}}},{'camera':0},{'camera':1},{'mesh':1}],"
    "'cameras':[{'type':'perspective','perspective':{'yfov':1,'znear':0.1,'zfar':9}},"
    "{'type':'orthographic','orthographic':{'xmag':1,'ymag':1,'znear':0,'zfar':9}}],"
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0,"
    "'targets':[{'POSITION':1},{'POSITION':2}]}]},{'primitives':[{'attributes':{'POSITION':0}}]}],"
    "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','intensity':10,'spot':{}}]},"
    "'EXT_lights_image_based':{'lights':[{}]}},"
    "'textures':[{'source':0}],'images':[{'uri':'" GLTF_PNG "'}],"
    "'materials':[{'name':'m','alphaMode':'MASK','emissiveFactor':[0.5,0.5,0.5],"
    "'emissiveTexture':@,'normalTexture':@,'occlusionTexture':@,"
    "'pbrMetallicRoughness':{'baseColorTexture':@,'metallicRoughnessTexture':@},'extensions':{"
    "'KHR_materials_anisotropy':{'anisotropyStrength':1,'anisotropyTexture':@},"
    "'KHR_materials_clearcoat':{'clearcoatFactor':1,'clearcoatTexture':@,"
    "'clearcoatRoughnessTexture':@,'clearcoatNormalTexture':@},"
    "'KHR_materials_diffuse_transmission':{'diffuseTransmissionTexture':@,"
    "'diffuseTransmissionColorTexture':@},'KHR_materials_dispersion':{},"
    "'KHR_materials_emissive_strength':{},'KHR_materials_ior':{},"
    "'KHR_materials_iridescence':{'iridescenceTexture':@,'iridescenceThicknessTexture':@},"
    "'KHR_materials_sheen':{'sheenColorTexture':@,'sheenRoughnessTexture':@},"
    "'KHR_materials_specular':{'specularTexture':@,'specularColorTexture':@},"
    "'KHR_materials_transmission':{'transmissionTexture':@},"
    "'KHR_materials_volume':{'thicknessFactor':1,'thicknessTexture':@,'attenuationDistance':1,"
    "'attenuationColor':[0.5,0.5,0.5]}}}]";

/* The document and an animation: more, members behind a comma each. */
static inline void put_document(char *out, size_t size, const char *more)
{
    static const char texture[] = "{'index':0,'extensions':{'KHR_texture_transform':{}}}";
    size_t n = 0;
    for (const char *c = document; *c; c++) {
        size_t length = *c == '@' ? sizeof texture - 1 : 1;
        assert_true(n + length < size);
        memcpy(out + n, *c == '@' ? texture : c, length);
        n += length;
    }
    assert_true(n + strlen(more) < size);
    strcpy(out + n, more);
}

static inline void put_corners(gltf_text *text)
{
    gltf_put_floats(text, corners, 3, "VEC3");
    gltf_put_floats(text, along_x, 3, "VEC3");
    gltf_put_floats(text, along_y, 3, "VEC3");
}

/* What a document comes to at so many seconds of its animation, whose keys lie in text. */
static inline lf_mesh_data read_at(const gltf_text *text, const char *animation, double seconds)
{
    static char rest[1 << 22];
    lf_mesh_desc desc = gltf_desc();
    lf_mesh_data data = {0};
    lf_error err = {0};
    put_document(rest, sizeof rest, animation);
    desc.clip = (lf_clip){.seconds = seconds, .once = true};
    lf_assert_ok(gltf_read_as(text, rest, &desc, &data, &err), &err);
    return data;
}

#define POINTER(pointer)                                                                           \
    "{'sampler':0,'target':{'path':'pointer','extensions':{'KHR_animation_pointer':{'pointer':'"   \
    "" pointer "'}}}}"

/* One pointer; words: of its sampler, behind a comma. */
static inline lf_mesh_data follow(const gltf_text *text, const char *pointer, const char *words,
                                  double seconds)
{
    char animation[1024];
    snprintf(animation, sizeof animation,
             ",'animations':[{'channels':[" POINTER("%s") "],'samplers':[{'input':3,'output':4%s}]}"
                                                          "]",
             pointer, words);
    return read_at(text, animation, seconds);
}

/* A pattern's pointer: of the first thing of its kind that has it, of the second weight. */
static inline void name_one(const char *pattern, char out[256])
{
    const char *first = strstr(pattern, "orthographic") ? "1" : "0";
    size_t n = 0;
    for (; *pattern; pattern++) {
        assert_true(n + 2 < 256);
        out[n++] = *pattern == '{' ? *first : *pattern;
        if (*pattern == '{') {
            pattern++;
            first = "1";
        }
    }
    out[n] = '\0';
}

static const float two_moments[2] = {0, 1};

static inline lf_mesh_data read_channels(const gltf_text *text, const char *channels,
                                         const char *samplers)
{
    static char animation[1 << 21];
    int n = snprintf(animation, sizeof animation,
                     ",'animations':[{'channels':[%s],'samplers':[%s]}]", channels, samplers);
    assert_true(n > 0 && (size_t)n < sizeof animation);
    return read_at(text, animation, 0.25);
}

static inline const double *corner_of(const lf_mesh_data *data, int corner)
{
    return data->positions + 3 * (size_t)data->triangles[corner];
}

#endif
