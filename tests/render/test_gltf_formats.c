/* Every row of the table "glTF 2.0" in docs/reference/formats/gltf.md. */
#include "tests/render/gltf_saying.h"

/* camera_frame.c refuses to look through one that is parallel. */
static void orthographic(const lf_format_row *row)
{
    const example *e = row->with;
    lf_mesh_data data = read_ok(row, e->says);
    assert_int_equal(data.cameras.n, 1);
    assert_true(data.cameras.open[0].parallel);
    lf_mesh_data_finish(&data);
}

/* --------------------------------------------------------------------------------------- GLB -- */

static void put_word(unsigned char *to, size_t *at, uint32_t word)
{
    memcpy(to + *at, &word, sizeof word);
    *at += sizeof word;
}

/* Appends a chunk: a length, a kind, bytes, and padding that the length may count. */
static void put_chunk(unsigned char *glb, size_t *at, const char *kind, const void *data, size_t n,
                      size_t padding, bool counted)
{
    put_word(glb, at, (uint32_t)(n + (counted ? padding : 0)));
    memcpy(glb + *at, kind, 4);
    *at += 4;
    memcpy(glb + *at, data, n);
    memset(glb + *at + n, kind[0] == 'J' ? ' ' : 0, padding);
    *at += n + padding;
}

typedef struct way {
    bool padded, counted, binary, stranger, trailing;
    uint32_t version;
} way;

/* One triangle, its vertices in the BIN chunk, or at zero where there is none. */
static lf_status read_glb(way how, lf_mesh_data *out, lf_error *err)
{
    unsigned char glb[2048] = {0};
    char json[512];
    size_t at = 0;
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"},%s\"accessors\":[{\"componentType\":5126,"
             "\"count\":3,\"type\":\"VEC3\",\"bufferView\":0}],\"meshes\":[{\"primitives\":[{"
             "\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0}]}",
             how.binary ? "\"buffers\":[{\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,"
                          "\"byteLength\":36}],"
                        : "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:;base64,"
                          "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],\"bufferViews\":[{"
                          "\"buffer\":0,\"byteLength\":36}],");
    while (strlen(json) % 4 != 2) /* two bytes of padding are wanted */
        strcat(json, " ");
    memcpy(glb, "glTF", 4);
    at = 4;
    put_word(glb, &at, how.version);
    put_word(glb, &at, 0);
    put_chunk(glb, &at, "JSON", json, strlen(json), how.padded ? 2 : 0, how.counted);
    if (how.stranger)
        put_chunk(glb, &at, "ODD!", "abcd", 4, 0, true);
    if (how.binary)
        put_chunk(glb, &at, "BIN", corners, 36, 0, true);
    if (how.trailing)
        put_chunk(glb, &at, "\xff\xff\xff\xff", "\xff\xff\xff", 3, 0, true);
    if (how.trailing)
        memset(glb + at - 11, 0xff, 8); /* its length, too, says too much */
    uint32_t size = (uint32_t)at;
    memcpy(glb + 8, &size, sizeof size);
    int fd = memfd_create("glb", 0);
    assert_true(write(fd, glb, at) == (ssize_t)at);
    lf_mesh_desc desc = gltf_desc();
    *out = (lf_mesh_data){0};
    lf_status status = lf_gltf_read(&desc, fd, out, err);
    close(fd);
    return status;
}

static void glb_whole(const lf_format_row *row)
{
    for (int i = 0; i < 32; i++) {
        const way how = {.padded = i & 1,
                         .counted = i & 2,
                         .binary = i & 4,
                         .stranger = i & 8,
                         .trailing = i & 16,
                         .version = 2};
        lf_mesh_data data;
        lf_error err = {0};
        if (how.stranger && how.padded && !how.counted) /* which nothing tells from its kind */
            continue;
        if (read_glb(how, &data, &err) != LF_OK)
            fail_msg("%s, %d: %s", row->name, i, err.what);
        assert_true(data.n_triangles == 1 && data.positions[3] == 1 && data.warnings.n == 0);
        lf_mesh_data_finish(&data);
    }
}

static void glb_header(const lf_format_row *row)
{
    lf_mesh_data data;
    lf_error err = {0};
    (void)row;
    assert_int_equal(read_glb((way){.binary = true, .version = 3}, &data, &err), LF_E_FORMAT);
    assert_non_null(strstr(err.what, "GLB of version 3; expected 2"));
}

/* ------------------------------------------------------------------------------------- table -- */

static const lf_format_row rows[] = {
    REFUSED("asset.version", MORE(",'asset':{'version':'1.0'}"),
            "glTF of version 1.0; expected 2.0"),
    REFUSED("asset.minVersion", MORE(",'asset':{'version':'2.0','minVersion':'2.1'}"),
            "glTF of version 2.1; expected 2.0"),
    IGNORED("asset.generator", MORE(",'asset':{'version':'2.0','generator':'x'}"), ""),
    IGNORED("asset.copyright", MORE(",'asset':{'version':'2.0','copyright':'x'}"), ""),
    TOLD("extensionsUsed", MORE(",'extensionsUsed':['XX_any']"),
         "the extension XX_any is not known here"),
    REFUSED("extensionsRequired", MORE(",'extensionsRequired':['XX_any']"),
            "not known here: XX_any"),
    IGNORED("extras",
            PRIMITIVE(",'extras':[4]") NODE(",'extras':{'b':2}") MATERIAL(",'extras':3")
                MORE(",'extras':{'a':1}"),
            ""),
    IGNORED("name", MESH(",'name':'s'") NODE(",'name':'n'"), ""),
    USED("scene",
         MORE(",'nodes':[{'mesh':0},{'mesh':0,'translation':[5,0,0]}],'scenes':[{'nodes':[0]},{'"
              "nodes':[1]}],'scene':1"),
         MORE(",'nodes':[{'mesh':0},{'mesh':0,'translation':[5,0,0]}],'scenes':[{'nodes':[0]},{'"
              "nodes':[1]}],'scene':0")),
    TOLD("scenes",
         MORE(",'nodes':[{'mesh':0},{'mesh':0,'translation':[5,0,0]}],'scenes':[{'nodes':[0]},{'"
              "nodes':[1]}]"),
         "2 scenes: the first is shown"),
    USED("scenes.nodes", MORE(",'nodes':[{'mesh':0},{'mesh':0}],'scenes':[{'nodes':[0,1]}]"),
         MORE(",'nodes':[{'mesh':0},{'mesh':0}]")),
    USED("nodes.children", MORE(",'nodes':[{'children':[1],'translation':[1,0,0]},{'mesh':0}]"),
         ""),
    USED("nodes.mesh", MORE(",'nodes':[{'mesh':0},{'mesh':0}],'scenes':[{'nodes':[0,1]}]"),
         MORE(",'nodes':[{'mesh':0},{}],'scenes':[{'nodes':[0,1]}]")),
    USED("nodes.matrix", NODE(",'matrix':[2,0,0,0,0,1,0,0,0,0,1,0,1,2,3,1]"), ""),
    USED("nodes.translation", NODE(",'translation':[1,2,3]"), ""),
    USED("nodes.rotation", NODE(",'rotation':[0,0,0.6,0.8]"), ""),
    USED("nodes.scale", NODE(",'scale':[1,2,3]"), ""),
    USED("nodes.weights", PRIMITIVE(",'targets':[{'POSITION':10}]") NODE(",'weights':[0.5]"),
         PRIMITIVE(",'targets':[{'POSITION':10}]")),
    USED(
        "nodes.skin",
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5") MORE(
            ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,2]}]"),
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5")
            MORE(",'nodes':[{'mesh':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,2]}]")),
    USED("nodes.camera",
         MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','perspective':{'"
              "yfov':1,'znear':1}}]"),
         ""),
    USED("meshes.primitives",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'attributes':{'POSITION':0}"
              "}]}]"),
         ""),
    USED("meshes.weights", PRIMITIVE(",'targets':[{'POSITION':10}]") MESH(",'weights':[0.5]"),
         PRIMITIVE(",'targets':[{'POSITION':10}]")),
    USED("primitives.attributes.POSITION",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':20}}]}]"), ""),
    USED("primitives.attributes.NORMAL", ATTRIBUTES(",'NORMAL':1"), ""),
    USED("primitives.attributes.TANGENT",
         ATTRIBUTES(",'NORMAL':1,'TANGENT':9") MATERIAL(",'normalTexture':{'index':0}"),
         ATTRIBUTES(",'NORMAL':1") MATERIAL(",'normalTexture':{'index':0}")),
    USED("primitives.attributes.TEXCOORD_0",
         ATTRIBUTES(",'TEXCOORD_0':2")
             MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"),
         ATTRIBUTES("," BARE) MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")),
    TOLD("primitives.attributes without the TEXCOORD_n of a texture",
         ATTRIBUTES("," BARE) MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"),
         "1 part lacks the texture coordinates of its pictures: they count as 0"),
    USED("primitives.attributes.TEXCOORD_1",
         ATTRIBUTES(",'TEXCOORD_1':2")
             MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1}}"),
         ATTRIBUTES("," BARE)
             MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1}}")),
    TOLD("primitives.attributes.TEXCOORD_n",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':2}}"),
         "a texture by a third set"),
    USED("primitives.attributes.COLOR_0", ATTRIBUTES(",'COLOR_0':3"), ""),
    TOLD("primitives.attributes.COLOR_n", ATTRIBUTES(",'COLOR_0':3,'COLOR_1':3"),
         "1 part has more colours than COLOR_0"),
    USED(
        "primitives.attributes.JOINTS_0",
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5") MORE(
            ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,2]}]"),
        MORE(",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,2]}"
             "]")),
    USED(
        "primitives.attributes.WEIGHTS_0",
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5") MORE(
            ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,2]}]"),
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':27")
            MORE(",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,"
                 "2]}]")),
    USED(
        "primitives.attributes.JOINTS_1",
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5,'JOINTS_1':28,'WEIGHTS_1':5") MORE(
            ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,2]}]"),
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5")
            MORE(",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,"
                 "2]}]")),
    USED(
        "primitives.attributes.WEIGHTS_1",
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5,'JOINTS_1':28,'WEIGHTS_1':5") MORE(
            ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,2]}]"),
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5,'JOINTS_1':28,'WEIGHTS_1':27")
            MORE(",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,"
                 "2]}]")),
    TOLD(
        "primitives.attributes.JOINTS_n",
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5,'JOINTS_2':4,'WEIGHTS_2':5") MORE(
            ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,2]}]"),
        "1 part has more than eight joints a vertex"),
    TOLD(
        "primitives.attributes.WEIGHTS_n",
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5,'JOINTS_2':4,'WEIGHTS_2':5") MORE(
            ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,2]}]"),
        "1 part has more than eight joints a vertex"),
    IGNORED("primitives.attributes._X", ATTRIBUTES(",'_BATCH':3"), ""),
    USED("primitives.indices", PRIMITIVE(",'indices':6"), ""),
    USED("primitives.material",
         MORE(",'materials':[{'pbrMetallicRoughness':{'metallicFactor':0.25}}]"),
         MORE(",'materials':[{'name':'x'}]")),
    TOLD("primitives.mode 0 (points)",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'attributes':{'POSITION':0}"
              ",'mode':0}]}]"),
         "4 points and lines are left out"),
    TOLD("primitives.mode 1 (lines)",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'attributes':{'POSITION':0}"
              ",'mode':1}]}]"),
         "2 points and lines are left out"),
    TOLD("primitives.mode 2 (line loop)",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'attributes':{'POSITION':0}"
              ",'mode':2}]}]"),
         "4 points and lines are left out"),
    TOLD("primitives.mode 3 (line strip)",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'attributes':{'POSITION':0}"
              ",'mode':3}]}]"),
         "4 points and lines are left out"),
    USED("primitives.mode 4 (triangles)", PRIMITIVE(",'mode':4"), PRIMITIVE(",'mode':5")),
    USED("primitives.mode 5 (triangle strip)", PRIMITIVE(",'mode':5"), ""),
    USED("primitives.mode 6 (triangle fan)", PRIMITIVE(",'mode':6"), PRIMITIVE(",'mode':5")),
    USED("primitives.targets.POSITION",
         PRIMITIVE(",'targets':[{'POSITION':10}]") NODE(",'weights':[0.5]"), ""),
    USED("primitives.targets.NORMAL",
         ATTRIBUTES(",'NORMAL':1") PRIMITIVE(",'targets':[{'NORMAL':10}]") NODE(",'weights':[0.5]"),
         ATTRIBUTES(",'NORMAL':1")),
    USED("primitives.targets.TANGENT",
         ATTRIBUTES(",'NORMAL':1,'TANGENT':9") PRIMITIVE(",'targets':[{'TANGENT':10}]")
             NODE(",'weights':[0.5]") MATERIAL(",'normalTexture':{'index':0}"),
         ATTRIBUTES(",'NORMAL':1,'TANGENT':9") MATERIAL(",'normalTexture':{'index':0}")),
    TOLD("primitives.targets.TEXCOORD_n",
         PRIMITIVE(",'targets':[{'TEXCOORD_0':2}]") NODE(",'weights':[0.5]"),
         "1 part has morph targets of texture coordinates or colours"),
    TOLD("primitives.targets.COLOR_n",
         PRIMITIVE(",'targets':[{'COLOR_0':3}]") NODE(",'weights':[0.5]"),
         "1 part has morph targets of texture coordinates or colours"),
    USED("accessors.bufferView",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':21}}]}]"),
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':20}}]}]")),
    USED("accessors.byteOffset",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':22}}]}]"),
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':21}}]}]")),
    USED("accessors.count",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':5}]}]"),
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':20},'mode':5}]}]")),
    USED("accessors.componentType 5120 (byte)",
         ATTRIBUTES(",'TEXCOORD_0':29")
             MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"),
         ATTRIBUTES("," BARE) MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")),
    USED("accessors.componentType 5121 (unsigned byte)",
         ATTRIBUTES(",'TEXCOORD_0':30")
             MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"),
         ATTRIBUTES("," BARE) MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")),
    USED("accessors.componentType 5122 (short)",
         ATTRIBUTES(",'TEXCOORD_0':31")
             MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"),
         ATTRIBUTES("," BARE) MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")),
    USED("accessors.componentType 5123 (unsigned short)",
         ATTRIBUTES(",'TEXCOORD_0':32")
             MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"),
         ATTRIBUTES("," BARE) MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")),
    USED("accessors.componentType 5126 (float)",
         ATTRIBUTES(",'TEXCOORD_0':2")
             MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"),
         ATTRIBUTES("," BARE) MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")),
    USED("accessors.componentType 5125 (unsigned int)", PRIMITIVE(",'indices':8"), ""),
    USED("accessors.normalized",
         ATTRIBUTES(",'TEXCOORD_0':32")
             MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"),
         ATTRIBUTES(",'TEXCOORD_0':33")
             MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")),
    USED("accessors.type SCALAR", PRIMITIVE(",'indices':7"), ""),
    USED("accessors.type VEC2",
         ATTRIBUTES(",'TEXCOORD_0':2")
             MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"),
         ATTRIBUTES("," BARE) MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")),
    USED("accessors.type VEC3", ATTRIBUTES(",'COLOR_0':34"), ""),
    USED("accessors.type VEC4", ATTRIBUTES(",'COLOR_0':3"), ""),
    REFUSED("accessors.type MAT2", ATTRIBUTES(",'NORMAL':35"), "no such type or componentType"),
    REFUSED("accessors.type MAT3", ATTRIBUTES(",'NORMAL':36"), "no such type or componentType"),
    USED("accessors.type MAT4",
         ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5")
             MORE(",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,"
                  "2],'inverseBindMatrices':17}]"),
         ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5")
             MORE(",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,"
                  "2]}]")),
    IGNORED("accessors.min", MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':37}}]}]"),
            MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]")),
    IGNORED("accessors.max", MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':37}}]}]"),
            MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]")),
    USED("accessors.sparse", MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':19}}]}]"),
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]")),
    ROW("bufferViews.buffer", "used", refused_as_used,
        MORE(",'bufferViews':[{'buffer':9,'byteLength':48}]"), "buffers[9] is not there"),
    USED("bufferViews.byteOffset",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"),
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':21}}]}]")),
    ROW("bufferViews.byteLength", "used", refused_as_used,
        MORE(",'bufferViews':[{'buffer':0,'byteLength':8}]"), "where there are 8"),
    USED("bufferViews.byteStride",
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':23}}]}]"),
         MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':21}}]}]")),
    IGNORED("bufferViews.target",
            MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':38}}]}]"),
            MORE(",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]")),
    ROW("buffers.uri", "used", refused_as_used,
        MORE(",'buffers':[{'uri':'gone.bin','byteLength':36}]"), "\"gone.bin\" is not to be had"),
    ROW("buffers.byteLength", "used", refused_as_used,
        MORE(",'buffers':[{'uri':'data:;base64,AAAA','byteLength':99999}]"),
        "a buffer of 99999 bytes, where there are 3"),
    USED("textures.source",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'textures':[{'source':0}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'textures':[{'source':1}]")),
    USED("textures.sampler",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'textures':[{'source':0,'sampler':0}],'samplers':[{'wrapS':33071}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'textures':[{'source':0}],'samplers':[{'wrapS':33071}]")),
    USED("samplers.magFilter 9728 (nearest)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'magFilter':9728}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'magFilter':9729}]")),
    USED("samplers.magFilter 9729 (linear)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'magFilter':9729}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'magFilter':9728}]")),
    USED("samplers.minFilter 9728 (nearest)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9728}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9987}]")),
    USED("samplers.minFilter 9729 (linear)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9729}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9987}]")),
    USED("samplers.minFilter 9984 (nearest, mipmap nearest)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9984}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9729}]")),
    USED("samplers.minFilter 9985 (linear, mipmap nearest)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9985}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9729}]")),
    USED("samplers.minFilter 9986 (nearest, mipmap linear)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9986}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9729}]")),
    USED("samplers.minFilter 9987 (linear, mipmap linear)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9987}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'minFilter':9729}]")),
    USED("samplers.wrapS 10497 (repeat)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapS':10497}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapS':33071}]")),
    USED("samplers.wrapS 33071 (clamp to edge)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapS':33071}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapS':10497}]")),
    USED("samplers.wrapS 33648 (mirrored repeat)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapS':33648}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapS':10497}]")),
    USED("samplers.wrapT 10497 (repeat)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapT':10497}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapT':33071}]")),
    USED("samplers.wrapT 33071 (clamp to edge)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapT':33071}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapT':10497}]")),
    USED("samplers.wrapT 33648 (mirrored repeat)",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapT':33648}]"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'samplers':[{'wrapT':10497}]")),
    TOLD("images.uri",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
             MORE(",'images':[{'uri':'gone.png'},{'uri':'gone.png'}]"),
         "picture \"gone.png\" is not to be had"),
    ROW("images.bufferView", "used", picture,
        MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
            MORE(",'images':[{'bufferView':38,'mimeType':'image/png'}]"),
        NULL),
    IGNORED("images.mimeType",
            MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
                MORE(",'images':[{'bufferView':38,'mimeType':'image/jpeg'}]"),
            MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")
                MORE(",'images':[{'bufferView':38}]")),
    USED("materials.pbrMetallicRoughness.baseColorFactor",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorFactor':[0.1,0.2,0.3,1]}"), ""),
    USED("materials.pbrMetallicRoughness.baseColorTexture",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"), ""),
    USED("materials.pbrMetallicRoughness.metallicFactor",
         MATERIAL(",'pbrMetallicRoughness':{'metallicFactor':0.5}"), ""),
    USED("materials.pbrMetallicRoughness.roughnessFactor",
         MATERIAL(",'pbrMetallicRoughness':{'roughnessFactor':0.5}"), ""),
    USED("materials.pbrMetallicRoughness.metallicRoughnessTexture",
         MATERIAL(",'pbrMetallicRoughness':{'metallicRoughnessTexture':{'index':0}}"), ""),
    USED("materials.normalTexture", MATERIAL(",'normalTexture':{'index':0}"), ""),
    USED("materials.normalTexture.scale", MATERIAL(",'normalTexture':{'index':0,'scale':0.5}"),
         MATERIAL(",'normalTexture':{'index':0}")),
    TOLD("materials.occlusionTexture", MATERIAL(",'occlusionTexture':{'index':0}"),
         "the ambient occlusion texture is ignored"),
    TOLD("materials.occlusionTexture.strength",
         MATERIAL(",'occlusionTexture':{'index':0,'strength':0.5}"),
         "the ambient occlusion texture is ignored"),
    USED("materials.emissiveTexture",
         MATERIAL(",'emissiveFactor':[1,1,1],'emissiveTexture':{'index':0}"),
         MATERIAL(",'emissiveFactor':[1,1,1]")),
    USED("materials.emissiveFactor", MATERIAL(",'emissiveFactor':[1,1,1]"), ""),
    USED("materials.alphaMode OPAQUE", MATERIAL(",'alphaMode':'OPAQUE'"),
         MATERIAL(",'alphaMode':'BLEND'")),
    TOLD("materials.alphaMode of any other name", MATERIAL(",'alphaMode':'WEIRD'"),
         "its alphaMode is not known here: opaque"),
    USED("materials.alphaMode MASK", MATERIAL(",'alphaMode':'MASK'"), ""),
    USED("materials.alphaMode BLEND", MATERIAL(",'alphaMode':'BLEND'"), ""),
    USED("materials.alphaCutoff", MATERIAL(",'alphaMode':'MASK','alphaCutoff':1.5"),
         MATERIAL(",'alphaMode':'MASK','alphaCutoff':1")),
    IGNORED("materials.doubleSided", MATERIAL(",'doubleSided':true"), ""),
    USED("textureInfo.index", MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':1}}")),
    USED("textureInfo.texCoord",
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1}}"),
         MATERIAL(",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}")),
    TOLD("animations",
         MORE(",'animations':[{'channels':[],'samplers':[]},{'channels':[],'samplers':[]}]"),
         "2 animations: the first is shown"),
    USED("animations.channels.target.path translation",
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':12}]}]"),
         ""),
    USED("animations.channels.target.path rotation",
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'rotation'}}],'"
              "samplers':[{'input':11,'output':13}]}]"),
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':12}]}]")),
    USED("animations.channels.target.path scale",
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'scale'}}],'"
              "samplers':[{'input':11,'output':14}]}]"),
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':12}]}]")),
    USED("animations.channels.target.path weights",
         PRIMITIVE(",'targets':[{'POSITION':10}]")
             MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'weights'}}],"
                  "'samplers':[{'input':11,'output':15}]}]"),
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'weights'}}],'"
              "samplers':[{'input':11,'output':15}]}]")),
    USED("animations.channels.target.node",
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':12}]}]"),
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'path':'translation'}}],'"
              "samplers':[{'input':11,'output':12}]}]")),
    USED("animations.channels.sampler",
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':12}]}]"),
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':14},{'input':11,'output':12}]}]")),
    USED("animations.samplers.input",
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':12}]}]"),
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':26,'output':12}]}]")),
    USED("animations.samplers.output",
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':12}]}]"),
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':14}]}]")),
    USED("animations.samplers.interpolation LINEAR",
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':12,'interpolation':'LINEAR'}]}]"),
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':12,'interpolation':'STEP'}]}]")),
    USED("animations.samplers.interpolation STEP",
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':12,'interpolation':'STEP'}]}]"),
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':12}]}]")),
    USED("animations.samplers.interpolation CUBICSPLINE",
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':16,'interpolation':'CUBICSPLINE'}]}]"),
         MORE(",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
              "'samplers':[{'input':11,'output':16}]}]")),
    USED(
        "skins.joints",
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5") MORE(
            ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,2]}]"),
        ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5")
            MORE(",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[2,"
                 "1]}]")),
    USED("skins.inverseBindMatrices",
         ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5")
             MORE(",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,"
                  "2],'inverseBindMatrices':17}]"),
         ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5")
             MORE(",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,"
                  "2]}]")),
    IGNORED("skins.skeleton",
            ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5")
                MORE(",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':"
                     "[1,2],'skeleton':1}]"),
            ATTRIBUTES(",'JOINTS_0':4,'WEIGHTS_0':5")
                MORE(",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'joints':"
                     "[1,2]}]")),
    USED("cameras.perspective.yfov",
         MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','perspective':{'"
              "yfov':0.5,'znear':1}}]"),
         MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','perspective':{'"
              "yfov':1,'znear':1}}]")),
    IGNORED("cameras.perspective.aspectRatio",
            MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','perspective':{"
                 "'yfov':1,'znear':1,'aspectRatio':2}}]"),
            MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','perspective':{"
                 "'yfov':1,'znear':1}}]")),
    IGNORED("cameras.perspective.znear",
            MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','perspective':{"
                 "'yfov':1,'znear':2}}]"),
            MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','perspective':{"
                 "'yfov':1,'znear':1}}]")),
    IGNORED("cameras.perspective.zfar",
            MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','perspective':{"
                 "'yfov':1,'znear':1,'zfar':3}}]"),
            MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','perspective':{"
                 "'yfov':1,'znear':1}}]")),
    ROW("cameras.type orthographic", "refused", orthographic,
        MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'orthographic','orthographic':{'"
             "xmag':1,'ymag':1,'znear':0,'zfar':9}}]"),
        NULL),
    ROW("cameras.orthographic.xmag", "refused", orthographic,
        MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'orthographic','orthographic':{'"
             "xmag':1,'ymag':1,'znear':0,'zfar':9}}]"),
        NULL),
    ROW("cameras.orthographic.ymag", "refused", orthographic,
        MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'orthographic','orthographic':{'"
             "xmag':1,'ymag':1,'znear':0,'zfar':9}}]"),
        NULL),
    ROW("cameras.orthographic.znear", "refused", orthographic,
        MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'orthographic','orthographic':{'"
             "xmag':1,'ymag':1,'znear':0,'zfar':9}}]"),
        NULL),
    ROW("cameras.orthographic.zfar", "refused", orthographic,
        MORE(",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'orthographic','orthographic':{'"
             "xmag':1,'ymag':1,'znear':0,'zfar':9}}]"),
        NULL),
    ROW("GLB header", "refused", glb_header, "", NULL),
    ROW("GLB JSON chunk", "used", glb_whole, "", NULL),
    ROW("GLB BIN chunk", "used", glb_whole, "", NULL),
    ROW("GLB chunks of other kinds", "ignored", glb_whole, "", NULL),
    ROW("GLB padding", "ignored", glb_whole, "", NULL),
};

static void the_table_of_gltf_is_what_the_reader_does(void **state)
{
    (void)state;
    lf_formats_walk("gltf.md", "glTF 2.0", rows, sizeof rows / sizeof *rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_table_of_gltf_is_what_the_reader_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
