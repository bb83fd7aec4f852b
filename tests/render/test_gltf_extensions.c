/* Every row of the table "Extensions" in docs/reference/formats/gltf.md. */
#include "tests/render/gltf_saying.h"

#include <meshoptimizer.h>

#include "tests/render/gltf_packed.h"

static void draco(const lf_format_row *row)
{
    gltf_text text = {0};
    say_draco(&text, draco_square, sizeof draco_square);
    lf_mesh_data data = gltf_read(&text, DRACO);
    assert_true(data.n_triangles == 2 && data.warnings.n == 0);
    lf_mesh_data_finish(&data);
    text = (gltf_text){0};
    say_draco(&text, draco_square, sizeof draco_square / 2);
    gltf_assert_refused(&text, DRACO, row->name);
}

static void meshopt(const lf_format_row *row)
{
    unsigned char packed[512];
    char more[256];
    gltf_text text = {0};
    (void)row;
    size_t n = meshopt_encodeVertexBuffer(packed, sizeof packed, corners, 4, 12);
    snprintf(more, sizeof more,
             ",'extensions':{'EXT_meshopt_compression':{'buffer':0,'byteOffset':0,'byteLength':%zu,"
             "'byteStride':12,'count':4,'mode':'ATTRIBUTES'}}",
             n);
    gltf_accessor(&text, gltf_view(&text, packed, n, more), 5126, 4, "VEC3", "");
    lf_mesh_data data = gltf_read(
        &text, "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':5}]}]," GLTF_ONE_NODE);
    assert_true(data.n_triangles == 2 && data.positions[11] == 0.5 && data.warnings.n == 0);
    lf_mesh_data_finish(&data);
}

/* Told where none is chosen, used where one is, and refused with the names of those there are. */
static void variants(const lf_format_row *row)
{
    static const char rest[] =
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0,'extensions':{"
        "'KHR_materials_variants':{'mappings':[{'material':1,'variants':[1]}]}}}]}],"
        "'materials':[{'name':'a'},{'name':'b'}],'extensions':{'KHR_materials_variants':{"
        "'variants':[{'name':'day'},{'name':'night'}]}}," GLTF_ONE_NODE;
    gltf_text text = {0};
    lf_mesh_desc desc = gltf_desc();
    lf_error err = {0};
    gltf_put_floats(&text, corners, 3, "VEC3");
    static const char *const names[] = {NULL, "day", "night"};
    for (int i = 0; i < 3; i++) {
        lf_mesh_data data = {0};
        desc.variant = names[i];
        lf_assert_ok(gltf_read_as(&text, rest, &desc, &data, &err), &err);
        assert_int_equal(data.triangle_material[0], i == 2);
        assert_true(gltf_warns(&data, "2 variants: the file's own look is shown") == (i == 0));
        lf_mesh_data_finish(&data);
    }
    lf_mesh_data data = {0};
    desc.variant = "dusk";
    assert_int_equal(gltf_read_as(&text, rest, &desc, &data, &err), LF_E_ARG);
    assert_string_equal(err.what, "no variant \"dusk\"; there are \"day\", \"night\"");
    lf_mesh_data_finish(&data);
    (void)row;
}

/* ------------------------------------------------------------------------------------- table -- */

static const lf_format_row rows[] = {
    ROW("KHR_draco_mesh_compression", "used", draco, "", NULL),
    USED("KHR_materials_anisotropy.anisotropyStrength",
         MATERIAL(",'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':0.5}}"), ""),
    USED("KHR_materials_anisotropy.anisotropyRotation",
         MATERIAL(",'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':0.5,'"
                  "anisotropyRotation':1}}"),
         MATERIAL(",'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':0.5}}")),
    USED("KHR_materials_anisotropy.anisotropyTexture",
         MATERIAL(",'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':0.5,'"
                  "anisotropyTexture':{'index':0}}}"),
         MATERIAL(",'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':0.5}}")),
    USED("KHR_materials_clearcoat.clearcoatFactor",
         MATERIAL(",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5}}"), ""),
    USED("KHR_materials_clearcoat.clearcoatTexture",
         MATERIAL(",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5,'"
                  "clearcoatTexture':{'index':0}}}"),
         MATERIAL(",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5}}")),
    USED("KHR_materials_clearcoat.clearcoatRoughnessFactor",
         MATERIAL(",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5,'"
                  "clearcoatRoughnessFactor':0.5}}"),
         MATERIAL(",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5}}")),
    USED("KHR_materials_clearcoat.clearcoatRoughnessTexture",
         MATERIAL(",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5,'"
                  "clearcoatRoughnessTexture':{'index':0}}}"),
         MATERIAL(",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5}}")),
    USED("KHR_materials_clearcoat.clearcoatNormalTexture",
         MATERIAL(",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5,'"
                  "clearcoatNormalTexture':{'index':0}}}"),
         MATERIAL(",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5}}")),
    TOLD("KHR_materials_diffuse_transmission.diffuseTransmissionFactor",
         MATERIAL(",'extensions':{'KHR_materials_diffuse_transmission':{'diffuseTransmissionFactor'"
                  ":0.5}}"),
         "diffuse transmission is left out"),
    TOLD("KHR_materials_diffuse_transmission.diffuseTransmissionTexture",
         MATERIAL(",'extensions':{'KHR_materials_diffuse_transmission':{'diffuseTransmissionFactor'"
                  ":0.5,'diffuseTransmissionTexture':{'index':0}}}"),
         "diffuse transmission is left out"),
    TOLD("KHR_materials_diffuse_transmission.diffuseTransmissionColorFactor",
         MATERIAL(",'extensions':{'KHR_materials_diffuse_transmission':{'diffuseTransmissionFactor'"
                  ":0.5,'diffuseTransmissionColorFactor':[1,0,0]}}"),
         "diffuse transmission is left out"),
    TOLD("KHR_materials_diffuse_transmission.diffuseTransmissionColorTexture",
         MATERIAL(",'extensions':{'KHR_materials_diffuse_transmission':{'diffuseTransmissionFactor'"
                  ":0.5,'diffuseTransmissionColorTexture':{'index':0}}}"),
         "diffuse transmission is left out"),
    TOLD("KHR_materials_dispersion.dispersion",
         MATERIAL(",'extensions':{'KHR_materials_dispersion':{'dispersion':1}}"),
         "dispersion is left out"),
    USED("KHR_materials_emissive_strength.emissiveStrength",
         MATERIAL(",'emissiveFactor':[1,1,1],'extensions':{'KHR_materials_emissive_strength':{'"
                  "emissiveStrength':9}}"),
         MATERIAL(",'emissiveFactor':[1,1,1]")),
    USED("KHR_materials_ior.ior", MATERIAL(",'extensions':{'KHR_materials_ior':{'ior':0}}"), ""),
    TOLD("KHR_materials_iridescence.iridescenceFactor",
         MATERIAL(",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':0.5}}"),
         "iridescence is left out"),
    TOLD("KHR_materials_iridescence.iridescenceTexture",
         MATERIAL(",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':0.5,'"
                  "iridescenceTexture':{'index':0}}}"),
         "iridescence is left out"),
    TOLD("KHR_materials_iridescence.iridescenceIor",
         MATERIAL(",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':0.5,'"
                  "iridescenceIor':2}}"),
         "iridescence is left out"),
    TOLD("KHR_materials_iridescence.iridescenceThicknessMinimum",
         MATERIAL(",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':0.5,'"
                  "iridescenceThicknessMinimum':9}}"),
         "iridescence is left out"),
    TOLD("KHR_materials_iridescence.iridescenceThicknessMaximum",
         MATERIAL(",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':0.5,'"
                  "iridescenceThicknessMaximum':9}}"),
         "iridescence is left out"),
    TOLD("KHR_materials_iridescence.iridescenceThicknessTexture",
         MATERIAL(",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':0.5,'"
                  "iridescenceThicknessTexture':{'index':0}}}"),
         "iridescence is left out"),
    TOLD("KHR_materials_pbrSpecularGlossiness.diffuseFactor",
         MATERIAL(
             ",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'diffuseFactor':[0,1,0,1]}}"),
         "specular and glossiness are made into"),
    TOLD(
        "KHR_materials_pbrSpecularGlossiness.diffuseTexture",
        MATERIAL(
            ",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'diffuseTexture':{'index':0}}}"),
        "specular and glossiness are made into"),
    TOLD("KHR_materials_pbrSpecularGlossiness.specularFactor",
         MATERIAL(
             ",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'specularFactor':[0,1,0]}}"),
         "specular and glossiness are made into"),
    TOLD("KHR_materials_pbrSpecularGlossiness.glossinessFactor",
         MATERIAL(",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'glossinessFactor':0.5}}"),
         "specular and glossiness are made into"),
    TOLD("KHR_materials_pbrSpecularGlossiness.specularGlossinessTexture",
         MATERIAL(",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'"
                  "specularGlossinessTexture':{'index':0}}}"),
         "textures of thickness, and of specular and glossiness, are not read"),
    USED("KHR_materials_sheen.sheenColorFactor",
         MATERIAL(",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0]}}"), ""),
    USED("KHR_materials_sheen.sheenColorTexture",
         MATERIAL(",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0],'"
                  "sheenColorTexture':{'index':0}}}"),
         MATERIAL(",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0]}}")),
    USED("KHR_materials_sheen.sheenRoughnessFactor",
         MATERIAL(",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0],'"
                  "sheenRoughnessFactor':0.5}}"),
         MATERIAL(",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0]}}")),
    USED("KHR_materials_sheen.sheenRoughnessTexture",
         MATERIAL(",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0],'"
                  "sheenRoughnessTexture':{'index':0}}}"),
         MATERIAL(",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0]}}")),
    USED("KHR_materials_specular.specularFactor",
         MATERIAL(",'extensions':{'KHR_materials_specular':{'specularFactor':0.5}}"), ""),
    USED("KHR_materials_specular.specularTexture",
         MATERIAL(",'extensions':{'KHR_materials_specular':{'specularTexture':{'index':0}}}"), ""),
    USED("KHR_materials_specular.specularColorFactor",
         MATERIAL(",'extensions':{'KHR_materials_specular':{'specularColorFactor':[5,5,5]}}"), ""),
    USED("KHR_materials_specular.specularColorTexture",
         MATERIAL(",'extensions':{'KHR_materials_specular':{'specularColorTexture':{'index':0}}}"),
         ""),
    USED("KHR_materials_transmission.transmissionFactor",
         MATERIAL(",'extensions':{'KHR_materials_transmission':{'transmissionFactor':0.5}}"), ""),
    USED("KHR_materials_transmission.transmissionTexture",
         MATERIAL(",'extensions':{'KHR_materials_transmission':{'transmissionFactor':0.5,'"
                  "transmissionTexture':{'index':0}}}"),
         MATERIAL(",'extensions':{'KHR_materials_transmission':{'transmissionFactor':0.5}}")),
    USED("KHR_materials_unlit", MATERIAL(",'extensions':{'KHR_materials_unlit':{}}"), ""),
    USED("KHR_materials_unlit with COLOR_0",
         ATTRIBUTES(",'COLOR_0':3") MATERIAL(",'extensions':{'KHR_materials_unlit':{}}"),
         MATERIAL(",'extensions':{'KHR_materials_unlit':{}}")),
    ROW("KHR_materials_variants", "warned", variants, "", NULL),
    USED("KHR_materials_volume.thicknessFactor",
         MATERIAL(",'extensions':{'KHR_materials_volume':{'thicknessFactor':0.5}}"), ""),
    TOLD("KHR_materials_volume.thicknessTexture",
         MATERIAL(",'extensions':{'KHR_materials_volume':{'thicknessFactor':0.5,'thicknessTexture':"
                  "{'index':0}}}"),
         "textures of thickness"),
    USED("KHR_materials_volume.attenuationDistance",
         MATERIAL(",'extensions':{'KHR_materials_volume':{'thicknessFactor':0.5,'attenuationColor':"
                  "[1,0.5,0],'attenuationDistance':2}}"),
         MATERIAL(",'extensions':{'KHR_materials_volume':{'thicknessFactor':0.5,'attenuationColor':"
                  "[1,0.5,0]}}")),
    USED("KHR_materials_volume.attenuationColor",
         MATERIAL(",'extensions':{'KHR_materials_volume':{'thicknessFactor':0.5,'attenuationColor':"
                  "[1,0.5,0],'attenuationDistance':2}}"),
         MATERIAL(",'extensions':{'KHR_materials_volume':{'thicknessFactor':0.5,'"
                  "attenuationDistance':2}}")),
    USED("KHR_lights_punctual point",
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}"),
         ""),
    USED("KHR_lights_punctual spot",
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{}}]}}"),
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}")),
    USED("KHR_lights_punctual directional",
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'directional'}]}}"),
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}")),
    TOLD("KHR_lights_punctual other types",
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'area'}]}}"),
         "1 light is left out: no such type"),
    USED("KHR_lights_punctual.color",
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'point','color':[1,0,0]}]}}"),
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}")),
    USED("KHR_lights_punctual.intensity",
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':5}]}}"),
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}")),
    IGNORED("KHR_lights_punctual.range",
            MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                 "extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','range':5}]}}"),
            MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                 "extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}")),
    USED("KHR_lights_punctual.spot.innerConeAngle",
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{'innerConeAngle':0.5}}]}}"),
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{}}]}}")),
    USED("KHR_lights_punctual.spot.outerConeAngle",
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{'outerConeAngle':0.5}}]}}"),
         MORE(",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
              "{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{}}]}}")),
    USED("KHR_mesh_quantization",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':39}}]}],'extensionsUsed':['KHR_"
              "mesh_quantization'],'extensionsRequired':['KHR_mesh_quantization']"),
         ""),
    USED("KHR_node_visibility.visible",
         MORE(",'nodes':[{'mesh':0},{'mesh':0,'extensions':{'KHR_node_visibility':{'visible':false}"
              "}}],'scenes':[{'nodes':[0,1]}]"),
         MORE(",'nodes':[{'mesh':0},{'mesh':0}],'scenes':[{'nodes':[0,1]}]")),
    TOLD("KHR_texture_basisu",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'textures':[{'extensions':{'KHR_texture_basisu':{'source':0}}}]"),
         "textures that are in KTX2 alone are not read"),
    USED("KHR_texture_transform.offset",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_"
                  "texture_transform':{'offset':[0.5,0]}}}}"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_"
                  "texture_transform':{}}}}")),
    USED("KHR_texture_transform.rotation",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_"
                  "texture_transform':{'rotation':1}}}}"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_"
                  "texture_transform':{}}}}")),
    USED("KHR_texture_transform.scale",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_"
                  "texture_transform':{'scale':[2,2]}}}}"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_"
                  "texture_transform':{}}}}")),
    USED("KHR_texture_transform.texCoord",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_"
                  "texture_transform':{'texCoord':1}}}}"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_"
                  "texture_transform':{}}}}")),
    IGNORED("KHR_xmp_json_ld",
            MORE(",'extensionsUsed':['KHR_xmp_json_ld'],'extensions':{'KHR_xmp_json_ld':{'packets':"
                 "[{}]}}"),
            ""),
    USED("EXT_mesh_gpu_instancing TRANSLATION",
         MORE(",'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'"
              "TRANSLATION':12}}}}]"),
         ""),
    USED("EXT_mesh_gpu_instancing ROTATION",
         MORE(",'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'"
              "ROTATION':13}}}}]"),
         ""),
    USED("EXT_mesh_gpu_instancing SCALE",
         MORE(",'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'SCALE':"
              "14}}}}]"),
         ""),
    IGNORED("EXT_mesh_gpu_instancing _X",
            MORE(",'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'"
                 "TRANSLATION':12,'_ID':15}}}}]"),
            MORE(",'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'"
                 "TRANSLATION':12}}}}]")),
    ROW("EXT_meshopt_compression", "used", meshopt, "", NULL),
    ROW("EXT_texture_webp", "used", picture,
        MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
            MORE(",'textures':[{'extensions':{'EXT_texture_webp':{'source':0}}}],'images':[{'uri':'"
                 "data:image/webp;base64,UklGRhoAAABXRUJQVlA4TA0AAAAvAAAAEAcQERGIiP4HAA=='}]"),
        NULL),
    TOLD("EXT_texture_avif",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'extensionsUsed':['EXT_texture_avif'],'textures':[{'extensions':{'EXT_texture_"
                  "avif':{'source':0}}}]"),
         "the extension EXT_texture_avif of 1 texture is not known here"),
    TOLD("MSFT_texture_dds",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'extensionsUsed':['MSFT_texture_dds'],'textures':[{'extensions':{'MSFT_texture_"
                  "dds':{'source':0}}}]"),
         "the extension MSFT_texture_dds of 1 texture is not known here"),
    TOLD("EXT_lights_image_based",
         MORE(",'extensionsUsed':['EXT_lights_image_based'],'scenes':[{'nodes':[0],'extensions':{'"
              "EXT_lights_image_based':{}}}]"),
         "the extension EXT_lights_image_based of 1 scene is not known here"),
    TOLD("EXT_lights_ies",
         MORE(",'extensionsUsed':['EXT_lights_ies'],'nodes':[{'mesh':0,'extensions':{'EXT_lights_"
              "ies':{}}}]"),
         "the extension EXT_lights_ies of 1 node is not known here"),
    TOLD("MSFT_lod",
         MORE(",'extensionsUsed':['MSFT_lod'],'nodes':[{'mesh':0,'extensions':{'MSFT_lod':{}}}]"),
         "the extension MSFT_lod of 1 node is not known here"),
    TOLD("MSFT_packing_normalRoughnessMetallic",
         MATERIAL(",'extensions':{'MSFT_packing_normalRoughnessMetallic':{}}")
             MORE(",'extensionsUsed':['MSFT_packing_normalRoughnessMetallic']"),
         "the extension MSFT_packing_normalRoughnessMetallic of 1 material is not known here"),
    TOLD("MSFT_packing_occlusionRoughnessMetallic",
         MATERIAL(",'extensions':{'MSFT_packing_occlusionRoughnessMetallic':{}}")
             MORE(",'extensionsUsed':['MSFT_packing_occlusionRoughnessMetallic']"),
         "the extension MSFT_packing_occlusionRoughnessMetallic of 1 material is not known here"),
    TOLD("NV_materials_mdl",
         MATERIAL(",'extensions':{'NV_materials_mdl':{}}")
             MORE(",'extensionsUsed':['NV_materials_mdl']"),
         "the extension NV_materials_mdl of 1 material is not known here"),
    TOLD("ADOBE_materials_clearcoat_specular",
         MATERIAL(",'extensions':{'ADOBE_materials_clearcoat_specular':{}}")
             MORE(",'extensionsUsed':['ADOBE_materials_clearcoat_specular']"),
         "the extension ADOBE_materials_clearcoat_specular of 1 material is not known here"),
    TOLD("KHR_materials_subsurface",
         MATERIAL(",'extensions':{'KHR_materials_subsurface':{}}")
             MORE(",'extensionsUsed':['KHR_materials_subsurface']"),
         "the extension KHR_materials_subsurface of 1 material is not known here"),
    TOLD("KHR_materials_volume_scatter",
         MATERIAL(",'extensions':{'KHR_materials_volume_scatter':{}}")
             MORE(",'extensionsUsed':['KHR_materials_volume_scatter']"),
         "the extension KHR_materials_volume_scatter of 1 material is not known here"),
    TOLD("KHR_gaussian_splatting",
         PRIMITIVE(",'extensions':{'KHR_gaussian_splatting':{}}")
             MORE(",'extensionsUsed':['KHR_gaussian_splatting']"),
         "the extension KHR_gaussian_splatting of 1 mesh is not known here"),
    TOLD("EXT_structural_metadata",
         PRIMITIVE(",'extensions':{'EXT_structural_metadata':{}}")
             MORE(",'extensionsUsed':['EXT_structural_metadata']"),
         "the extension EXT_structural_metadata of 1 mesh is not known here"),
    TOLD("EXT_mesh_features",
         PRIMITIVE(",'extensions':{'EXT_mesh_features':{}}")
             MORE(",'extensionsUsed':['EXT_mesh_features']"),
         "the extension EXT_mesh_features of 1 mesh is not known here"),
    TOLD("CESIUM_primitive_outline",
         PRIMITIVE(",'extensions':{'CESIUM_primitive_outline':{}}")
             MORE(",'extensionsUsed':['CESIUM_primitive_outline']"),
         "the extension CESIUM_primitive_outline of 1 mesh is not known here"),
    TOLD("KHR_audio_emitter",
         MORE(",'extensionsUsed':['KHR_audio_emitter'],'extensions':{'KHR_audio_emitter':{}}"),
         "the extension KHR_audio_emitter is not known here"),
    TOLD("KHR_interactivity",
         MORE(",'extensionsUsed':['KHR_interactivity'],'extensions':{'KHR_interactivity':{}}"),
         "the extension KHR_interactivity is not known here"),
    TOLD("KHR_physics_rigid_bodies",
         MORE(",'extensionsUsed':['KHR_physics_rigid_bodies'],'extensions':{'KHR_physics_rigid_"
              "bodies':{}}"),
         "the extension KHR_physics_rigid_bodies is not known here"),
    TOLD("AGI_articulations",
         MORE(",'extensionsUsed':['AGI_articulations'],'extensions':{'AGI_articulations':{}}"),
         "the extension AGI_articulations is not known here"),
};

static void the_table_of_extensions_is_what_the_reader_does(void **state)
{
    (void)state;
    lf_formats_walk("gltf.md", "Extensions", rows, sizeof rows / sizeof *rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_table_of_extensions_is_what_the_reader_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
