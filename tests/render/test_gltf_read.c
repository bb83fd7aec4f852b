/* Geometry of glTF against triangles that are known: every way in which numbers may lie in a file,
 * nodes, skins, morph targets; what is refused, in words. */
#include "tests/render/gltf_packed.h"

#include <meshoptimizer.h>

#include "render/scene/vec_double.h"

static const float corner3[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
static const float quad[12] = {0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0};

static void corner(const lf_mesh_data *data, int triangle, int which, double out[3])
{
    memcpy(out, data->positions + 3 * (size_t)data->triangles[3 * triangle + which],
           3 * sizeof *out);
}

/* Twice the area, along the normal. */
static void area_vector(const lf_mesh_data *data, int triangle, double out[3])
{
    double a[3], b[3], c[3];
    corner(data, triangle, 0, a);
    corner(data, triangle, 1, b);
    corner(data, triangle, 2, c);
    lf_sub_double(b, a, b);
    lf_sub_double(c, a, c);
    lf_cross_double(b, c, out);
}

static void assert_corner(const lf_mesh_data *data, int triangle, int which, double x, double y,
                          double z)
{
    double p[3];
    corner(data, triangle, which, p);
    lf_assert_close(p[0], x, 0, 1e-5);
    lf_assert_close(p[1], y, 0, 1e-5);
    lf_assert_close(p[2], z, 0, 1e-5);
}

/* One triangle, whose other attributes and members are given. */
static lf_mesh_data read_one(gltf_text *text, const char *attributes, const char *more,
                             const char *rest)
{
    char all[4096];
    snprintf(all, sizeof all, "'meshes':[{'primitives':[{'attributes':{%s}%s}]}],%s", attributes,
             more, rest);
    return gltf_read(text, all);
}

/* --------------------------------------------------------------------------------- accessors -- */

static void quantised_positions_and_normalised_attributes_are_what_they_mean(void **state)
{
    (void)state;
    static const int16_t positions[12] = {0, 0, 0, 0, 32767, 0, 0, 0, 0, -32768, 0, 0};
    static const uint8_t colours[12] = {255, 0, 51, 0, 0, 255, 0, 0, 0, 0, 255, 0};
    gltf_text text = {0};
    int p = gltf_view(&text, positions, sizeof positions, ",'byteStride':8"),
        c = gltf_view(&text, colours, sizeof colours, ",'byteStride':4");
    gltf_accessor(&text, p, 5122, 3, "VEC3", ",'normalized':true");
    gltf_accessor(&text, c, 5121, 3, "VEC3", ",'normalized':true");
    lf_mesh_data data =
        read_one(&text, "'POSITION':0,'COLOR_0':1", "",
                 "'extensionsRequired':['KHR_mesh_quantization'],'scenes':[{'nodes':[0]}],"
                 "'nodes':[{'mesh':0,'scale':[3,3,3]}]");
    assert_int_equal(data.n_triangles, 1);
    assert_corner(&data, 0, 0, 0, 0, 0);
    assert_corner(&data, 0, 1, 3, 0, 0);
    assert_corner(&data, 0, 2, 0, -3, 0);
    const float *k = data.colours + 4 * (size_t)data.triangles[0];
    lf_assert_close((double)k[2], 0.2, 1e-6, 0);
    assert_true(k[0] == 1 && k[1] == 0 && k[3] == 1);
    lf_mesh_data_finish(&data);
}

static void sparse_elements_stand_in_place_of_others(void **state)
{
    (void)state;
    static const uint8_t places[4] = {2};
    static const float value[3] = {0, 5, 0};
    for (int zeros = 0; zeros < 2; zeros++) {
        static const uint8_t two[4] = {1, 2};
        static const float values[6] = {1, 0, 0, 0, 5, 0};
        gltf_text text = {0};
        int v = gltf_view(&text, corner3, sizeof corner3, "");
        int at = zeros ? gltf_view(&text, two, 2, "") : gltf_view(&text, places, 1, ""),
            to = zeros ? gltf_view(&text, values, sizeof values, "")
                       : gltf_view(&text, value, sizeof value, "");
        char sparse[256];
        snprintf(sparse, sizeof sparse,
                 ",'sparse':{'count':%d,'indices':{'bufferView':%d,'componentType':5121},"
                 "'values':{'bufferView':%d}}",
                 zeros ? 2 : 1, at, to);
        gltf_accessor(&text, zeros ? -1 : v, 5126, 3, "VEC3", sparse);
        lf_mesh_data data = read_one(&text, "'POSITION':0", "", GLTF_ONE_NODE);
        assert_corner(&data, 0, 1, 1, 0, 0);
        assert_corner(&data, 0, 2, 0, 5, 0);
        lf_mesh_data_finish(&data);
    }
}

static void indices_of_every_type_name_the_same_vertices(void **state)
{
    (void)state;
    static const uint8_t bytes[8] = {0, 1, 2, 0, 2, 3};
    uint16_t halves[6];
    uint32_t words[6];
    for (int i = 0; i < 6; i++)
        words[i] = halves[i] = bytes[i];
    const struct {
        const void *data;
        size_t n;
        int type;
    } kinds[] = {{bytes, 6, 5121}, {halves, sizeof halves, 5123}, {words, sizeof words, 5125}};
    for (size_t k = 0; k < 3; k++) {
        gltf_text text = {0};
        gltf_put_floats(&text, quad, 4, "VEC3");
        gltf_accessor(&text, gltf_view(&text, kinds[k].data, kinds[k].n, ""), kinds[k].type, 6,
                      "SCALAR", "");
        lf_mesh_data data = read_one(&text, "'POSITION':0", ",'indices':1", GLTF_ONE_NODE);
        assert_int_equal(data.n_triangles, 2);
        assert_int_equal(data.n_vertices, 4);
        assert_corner(&data, 1, 2, 0, 1, 0);
        lf_mesh_data_finish(&data);
    }
}

static void strips_and_fans_face_one_way(void **state)
{
    (void)state;
    static const uint16_t strip[5] = {0, 1, 3, 2}, fan[5] = {0, 1, 2, 3};
    for (int mode = 5; mode <= 6; mode++) {
        char more[64];
        gltf_text text = {0};
        gltf_put_floats(&text, quad, 4, "VEC3");
        gltf_accessor(&text, gltf_view(&text, mode == 5 ? strip : fan, 8, ""), 5123, 4, "SCALAR",
                      "");
        snprintf(more, sizeof more, ",'indices':1,'mode':%d", mode);
        lf_mesh_data data = read_one(&text, "'POSITION':0", more, GLTF_ONE_NODE);
        assert_int_equal(data.n_triangles, 2);
        for (int t = 0; t < 2; t++) {
            double n[3];
            area_vector(&data, t, n);
            assert_true(n[0] == 0 && n[1] == 0 && n[2] == 2);
        }
        lf_mesh_data_finish(&data);
    }
}

static void what_meshoptimizer_packed_is_unpacked(void **state)
{
    (void)state;
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    unsigned char packed[512];
    char more[256];
    gltf_text text = {0};
    size_t n = meshopt_encodeVertexBuffer(packed, sizeof packed, quad, 4, 12);
    snprintf(more, sizeof more,
             ",'extensions':{'EXT_meshopt_compression':{'buffer':0,'byteOffset':%zu,"
             "'byteLength':%zu,'byteStride':12,'count':4,'mode':'ATTRIBUTES'}}",
             text.n, n);
    gltf_accessor(&text, gltf_view(&text, packed, n, more), 5126, 4, "VEC3", "");
    n = meshopt_encodeIndexBuffer(packed, sizeof packed, indices, 6);
    snprintf(more, sizeof more,
             ",'extensions':{'EXT_meshopt_compression':{'buffer':0,'byteOffset':%zu,"
             "'byteLength':%zu,'byteStride':4,'count':6,'mode':'TRIANGLES'}}",
             text.n, n);
    gltf_accessor(&text, gltf_view(&text, packed, n, more), 5125, 6, "SCALAR", "");
    lf_mesh_data data = read_one(&text, "'POSITION':0", ",'indices':1", GLTF_ONE_NODE);
    double area = 0, a[3];
    for (int t = 0; t < data.n_triangles; t++) {
        area_vector(&data, t, a);
        area += a[2] / 2;
    }
    lf_assert_close(area, 2, 1e-6, 0);
    lf_mesh_data_finish(&data);
}

static void what_draco_packed_is_unpacked(void **state)
{
    (void)state;
    gltf_text text = {0};
    say_draco(&text, draco_square, sizeof draco_square);
    lf_mesh_data data = gltf_read(&text, DRACO);
    assert_int_equal(data.n_triangles, 2);
    assert_int_equal(data.n_vertices, 4);
    double a[3];
    area_vector(&data, 1, a);
    assert_true(a[2] == 2);
    for (uint32_t v = 0; v < 4; v++) {
        const double *p = data.positions + 3 * v;
        const float *k = data.colours + 4 * v;
        lf_assert_close((double)k[0], p[0] == 0 ? p[1] == 0 ? 1 : 0.2 : 0, 1e-6, 1e-6);
    }
    lf_mesh_data_finish(&data);
}

static void what_is_packed_badly_is_refused(void **state)
{
    (void)state;
    unsigned char spoiled[sizeof draco_square];
    for (size_t cut = 0; cut < sizeof draco_square - 8; cut += 7) {
        gltf_text text = {0};
        say_draco(&text, draco_square, cut > 0 ? cut : 1);
        gltf_assert_refused(&text, DRACO, "KHR_draco_mesh_compression");
    }
    for (size_t at = 11; at < sizeof draco_square; at++) { /* in words, or read: never a crash */
        lf_mesh_desc desc = gltf_desc();
        lf_mesh_data data = {0};
        lf_error err = {0};
        gltf_text text = {0};
        memcpy(spoiled, draco_square, sizeof spoiled);
        spoiled[at] ^= 0x55;
        say_draco(&text, spoiled, sizeof spoiled);
        if (gltf_read_as(&text, DRACO, &desc, &data, &err) != LF_OK)
            assert_true(err.what[0]);
        lf_mesh_data_finish(&data);
    }
    gltf_text text = {0};
    gltf_accessor(&text,
                  gltf_view(&text, quad, sizeof quad,
                            ",'extensions':{'EXT_meshopt_compression':{'buffer':0,'byteLength':48,"
                            "'byteStride':12,'count':4000000,'mode':'ATTRIBUTES'}}"),
                  5126, 4, "VEC3", "");
    gltf_assert_refused(&text,
                        "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]," GLTF_ONE_NODE,
                        "EXT_meshopt_compression");
}

/* ------------------------------------------------------------------------------------- nodes -- */

static void nodes_stand_where_their_parents_and_matrices_say(void **state)
{
    (void)state;
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    /* a quarter turn about z, then 2 up; both ways of saying so */
    lf_mesh_data data =
        read_one(&text, "'POSITION':0", "",
                 "'scene':1,'scenes':[{'nodes':[]},{'nodes':[0]}],'nodes':[{'translation':[10,0,0],"
                 "'children':[1,2]},{'mesh':0,'translation':[0,2,0],"
                 "'rotation':[0,0,0.70710678,0.70710678],'scale':[3,1,1]},"
                 "{'mesh':0,'matrix':[0,3,0,0,-1,0,0,0,0,0,1,0,0,2,0,1]},{'mesh':0}]");
    assert_int_equal(data.n_triangles, 2);
    for (int t = 0; t < 2; t++) {
        assert_corner(&data, t, 0, 10, 2, 0);
        assert_corner(&data, t, 1, 10, 5, 0);
        assert_corner(&data, t, 2, 9, 2, 0);
    }
    lf_mesh_data_finish(&data);
}

static void a_mirrored_node_keeps_faces_with_their_normals(void **state)
{
    (void)state;
    static const float normals[9] = {0, 0, 1, 0, 0, 1, 0, 0, 1};
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    gltf_put_floats(&text, normals, 3, "VEC3");
    lf_mesh_data data = read_one(&text, "'POSITION':0,'NORMAL':1", "",
                                 "'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'scale':[-1,1,1]}]");
    double n[3];
    area_vector(&data, 0, n);
    assert_true(n[2] == 1 && data.normals[2] == 1);
    lf_mesh_data_finish(&data);
}

static void instances_stand_in_their_node(void **state)
{
    (void)state;
    static const float places[6] = {0, 0, 0, 0, 0, 4};
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    gltf_put_floats(&text, places, 2, "VEC3");
    lf_mesh_data data = read_one(
        &text, "'POSITION':0", "",
        "'extensionsRequired':['EXT_mesh_gpu_instancing'],'scenes':[{'nodes':[0]}],'nodes':[{"
        "'mesh':0,'translation':[1,0,0],"
        "'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':1}}}}]");
    assert_int_equal(data.n_triangles, 2);
    assert_corner(&data, 0, 0, 1, 0, 0);
    assert_corner(&data, 1, 0, 1, 0, 4);
    lf_mesh_data_finish(&data);
    gltf_accessor(&text, -1, 5126, 60000, "VEC3", "");
    gltf_assert_refused(
        &text,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],'nodes':[{'mesh':0,"
        "'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':2}}}}]",
        "EXT_mesh_gpu_instancing: TRANSLATION has 60000 elements");
}

static void a_part_without_normals_is_flat_beside_one_that_has_some(void **state)
{
    (void)state;
    static const float folded[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1},
                       normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    static const uint8_t indices[8] = {0, 1, 2, 0, 3, 1};
    gltf_text text = {0};
    gltf_put_floats(&text, folded, 4, "VEC3");
    gltf_put_floats(&text, normals, 4, "VEC3");
    gltf_accessor(&text, gltf_view(&text, indices, 6, ""), 5121, 6, "SCALAR", "");
    lf_mesh_data data =
        gltf_read(&text, "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':2},"
                         "{'attributes':{'POSITION':0,'NORMAL':1},'indices':2}]}]," GLTF_ONE_NODE);
    assert_int_equal(data.n_triangles, 4);
    for (int t = 0; t < 2; t++) {
        double n[3];
        area_vector(&data, t, n);
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < 3; i++)
                assert_true((double)data.normals[3 * data.triangles[3 * t + c] + (uint32_t)i] ==
                            n[i]);
    }
    assert_true(data.normals[3 * data.triangles[11] + 2] == 1);
    lf_mesh_data_finish(&data);
}

static void smooth_normals_go_over_seams_of_textures(void **state)
{
    (void)state;
    /* two faces that fold along x and share no vertex */
    static const float roof[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0};
    gltf_text text = {0};
    lf_mesh_desc desc = gltf_desc();
    lf_mesh_data data = {0};
    lf_error err;
    gltf_put_floats(&text, roof, 6, "VEC3");
    desc.normals = LF_NORMALS_SMOOTH;
    assert_int_equal(
        gltf_read_as(&text,
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]," GLTF_ONE_NODE,
                     &desc, &data, &err),
        LF_OK);
    lf_assert_close((double)data.normals[1], sqrt(0.5), 1e-6, 0);
    lf_assert_close((double)data.normals[2], sqrt(0.5), 1e-6, 0);
    assert_memory_equal(data.normals, data.normals + 9, 3 * sizeof(float));
    lf_mesh_data_finish(&data);
}

/* ----------------------------------------------------------------------------- what is moved -- */

static const float up[9] = {0, 0, 0, 0, 0, 0, 0, 4, 0};

static void morph_targets_add_by_the_nearest_weights(void **state)
{
    (void)state;
    static const float moments[2] = {1, 2}, weights[2] = {0.75f, 0};
    static const struct {
        const char *mesh, *node, *rest;
        double y;
    } cases[] = {{"", "", "", 1},
                 {",'weights':[0.5]", "", "", 3},
                 {",'weights':[0.5]", ",'weights':[0.25]", "", 2},
                 {",'weights':[0.5]", ",'weights':[0.25]",
                  ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'weights'}}],"
                  "'samplers':[{'input':2,'output':3}]}]",
                  4}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char rest[1024];
        gltf_text text = {0};
        gltf_put_floats(&text, corner3, 3, "VEC3");
        gltf_put_floats(&text, up, 3, "VEC3");
        gltf_put_floats(&text, moments, 2, "SCALAR");
        gltf_put_floats(&text, weights, 2, "SCALAR");
        snprintf(rest, sizeof rest,
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':1}]"
                 "}]%s}],'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0%s}]%s",
                 cases[i].mesh, cases[i].node, cases[i].rest);
        lf_mesh_data data = gltf_read(&text, rest);
        assert_corner(&data, 0, 2, 0, cases[i].y, 0);
        lf_mesh_data_finish(&data);
    }
}

static void nodes_stand_where_an_animation_begins(void **state)
{
    (void)state;
    static const float moments[2] = {-1, 1}, places[6] = {0, 0, 0, 8, 0, 0},
                       /* before, value, after: of each */
        curve[18] = {0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 0, 0, 8, 0, 0, 0, 0, 0};
    static const struct {
        const char *words;
        double x;
    } cases[] = {{"'output':2", 4},
                 {"'output':2,'interpolation':'STEP'", 0},
                 /* (1/2 - 3/4 + ... ) (1 + 1) * 4 * () + 8 / 2, at t = 1/2 */
                 {"'output':3,'interpolation':'CUBICSPLINE'", 5}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char rest[1024];
        gltf_text text = {0};
        gltf_put_floats(&text, corner3, 3, "VEC3");
        gltf_put_floats(&text, moments, 2, "SCALAR");
        gltf_put_floats(&text, places, 2, "VEC3");
        gltf_put_floats(&text, curve, 6, "VEC3");
        snprintf(rest, sizeof rest,
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],'animations':[{"
                 "'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
                 "'samplers':[{'input':1,%s}]}]," GLTF_ONE_NODE,
                 cases[i].words);
        lf_mesh_data data = gltf_read(&text, rest);
        assert_corner(&data, 0, 0, cases[i].x, 0, 0);
        assert_false(gltf_warns(&data, "animations"));
        assert_true(data.span == 1);
        lf_mesh_data_finish(&data);
    }
}

static void vertices_follow_their_bones(void **state)
{
    (void)state;
    /* the first vertex on one bone, the second half way, the third on the other */
    static const uint8_t joints[12] = {0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0};
    static const float weights[12] = {1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 2, 0, 0, 0},
                       bound[32] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0,  1,
                                    1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1};
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    gltf_accessor(&text, gltf_view(&text, joints, sizeof joints, ""), 5121, 3, "VEC4", "");
    gltf_put_floats(&text, weights, 3, "VEC4");
    gltf_put_floats(&text, bound, 2, "MAT4");
    lf_mesh_data data =
        read_one(&text, "'POSITION':0,'JOINTS_0':1,'WEIGHTS_0':2", "",
                 "'skins':[{'joints':[1,2],'inverseBindMatrices':3}],'scenes':[{'nodes':[0,1]}],"
                 "'nodes':[{'mesh':0,'skin':0,'translation':[99,0,0]},{'translation':[0,0,2],"
                 "'children':[2]},{'translation':[0,4,1]}]");
    assert_corner(&data, 0, 0, 0, 0, 2);
    assert_corner(&data, 0, 1, 1, 2, 2);
    assert_corner(&data, 0, 2, 0, 5, 2);
    lf_mesh_data_finish(&data);
}

/* --------------------------------------------------------------------------- what is refused -- */

#define ONE_MESH "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"

static void what_points_beyond_is_refused_in_words(void **state)
{
    (void)state;
    static const uint16_t indices[4] = {0, 1, 3};
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    gltf_accessor(&text, gltf_view(&text, indices, 6, ""), 5123, 3, "SCALAR", "");
    gltf_accessor(&text, 0, 5126, 4, "VEC3", "");
    gltf_accessor(&text, 7, 5126, 3, "VEC3", "");
    gltf_accessor(&text, 0, 5126, 2, "VEC3", "");
    gltf_accessor(&text, -1, 5126, 5000000, "VEC3", "");
    gltf_accessor(&text, -1, 5126, 70000, "VEC3", "");
    gltf_accessor(&text, gltf_view(&text, corner3, sizeof corner3, ",'byteStride':4"), 5126, 3,
                  "VEC3", "");
    static const struct {
        const char *primitive, *words;
    } cases[] = {
        {"'attributes':{'POSITION':0},'indices':1", "missing or non-finite vertices"},
        {"'attributes':{'POSITION':2}", "needs 48 bytes, but its buffer view has 36"},
        {"'attributes':{'POSITION':3}", "bufferViews[7] does not exist"},
        {"'attributes':{'POSITION':9}", "accessors[9] does not exist"},
        {"'attributes':{'POSITION':-1}", "does not exist"},
        {"'attributes':{'POSITION':0,'NORMAL':4}", "NORMAL has 2 elements"},
        {"'attributes':{'POSITION':0,'TEXCOORD_0':0}", "TEXCOORD_0 has 3 components; expected 2"},
        {"'attributes':{'POSITION':5}", "5000000 elements without a bufferView"},
        {"'attributes':{'POSITION':6}", "some of 70000 positions and 0 indices have no bufferView"},
        {"'attributes':{'POSITION':7}", "elements of 12 bytes, but a stride of 4 bytes"},
        {"'attributes':{'POSITION':0},'mode':7", "unknown mode"},
        {"'attributes':{}", "no triangles"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char rest[512];
        snprintf(rest, sizeof rest, "'meshes':[{'primitives':[{%s}]}]," GLTF_ONE_NODE,
                 cases[i].primitive);
        gltf_assert_refused(&text, rest, cases[i].words);
    }
}

/* One odd thing does not stop a file. */
static void what_is_odd_is_left_out_or_cut_and_counted(void **state)
{
    (void)state;
    static const float positions[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, NAN, 0, 0, 2, 0, 0},
                       uvs[12] = {0, 0, NAN, 1, 1e9f, 0, -1e9f, 1, 0, 0, 0, 0},
                       colours[18] = {1, 1, 1, 2, 0, 0, -1, 0, 0, 0, NAN, 0, 1, 1, 1, 1, 1, 1};
    static const uint16_t indices[12] = {0, 1, 2, 1, 3, 2, 1, 9, 2, 0, 4, 2};
    gltf_text text = {0};
    gltf_put_floats(&text, positions, 6, "VEC3");
    gltf_put_floats(&text, uvs, 6, "VEC2");
    gltf_put_floats(&text, colours, 6, "VEC3");
    gltf_accessor(&text, gltf_view(&text, indices, sizeof indices, ""), 5123, 12, "SCALAR", "");
    lf_mesh_data data = gltf_read(
        &text, "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':1,'COLOR_0':2},"
               "'indices':3,'material':0},{'attributes':{'POSITION':0},'material':7}]}],"
               "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}}],"
               "'textures':[{'source':0}],'images':[{'uri':'" GLTF_PNG "'}]," GLTF_ONE_NODE);
    assert_int_equal(data.n_triangles, 3); /* two of four, one of two */
    assert_true(gltf_warns(&data, "1 triangle is left out: an index has no vertex"));
    assert_true(gltf_warns(&data, "2 of 6 triangles are left out: a vertex is not finite"));
    assert_true(gltf_warns(
        &data,
        "3 vertices have normals, texture coordinates or colours out of range; they are clamped"));
    assert_true(gltf_warns(&data, "1 part has a missing material; it is grey"));
    assert_int_equal(data.warnings.n, 4);
    assert_true(data.uvs[2] == 0 && data.uvs[4] == LF_MAX_UV && data.uvs[6] == -LF_MAX_UV);
    assert_true(data.colours[4] == 1 && data.colours[8] == 0 && data.colours[13] == 0);
    lf_mesh_data_finish(&data);
}

static void nodes_that_are_no_tree_are_refused(void **state)
{
    (void)state;
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    static const struct {
        const char *nodes, *words;
    } cases[] = {
        {"{'mesh':0,'children':[1]},{'children':[0]}", "in a loop"},
        {"{'mesh':0,'children':[0]}", "in a loop"},
        {"{'children':[2]},{'children':[2]},{'mesh':0}", "nodes[2] is a child of two others"},
        {"{'mesh':0,'children':[7]}", "a node index is out of range; the file has 1 nodes"},
        {"{'mesh':3}", "nodes[0]: meshes[3] does not exist; the file has 1"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char rest[512];
        snprintf(rest, sizeof rest, ONE_MESH ",'scenes':[{'nodes':[0]}],'nodes':[%s]",
                 cases[i].nodes);
        gltf_assert_refused(&text, rest, cases[i].words);
    }
}

static void extensions_that_it_requires_must_be_known(void **state)
{
    (void)state;
    gltf_text text = {0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    gltf_assert_refused(&text,
                        ONE_MESH ",'extensionsRequired':['KHR_materials_ior','XX_a','YY_b']"
                                 "," GLTF_ONE_NODE,
                        "glTF extensions that are not supported: XX_a, YY_b");
    lf_mesh_data data =
        gltf_read(&text, ONE_MESH ",'extensionsRequired':['KHR_materials_ior']," GLTF_ONE_NODE);
    assert_int_equal(data.n_triangles, 1);
    lf_mesh_data_finish(&data);
}

/* Two animations of one node: along x in 2 seconds, "up" along y in 4. */
static void put_two_clips(gltf_text *text, char rest[2048])
{
    static const float two[2] = {0, 2}, four[2] = {0, 4}, along[6] = {0, 0, 0, 8, 0, 0},
                       upwards[6] = {0, 0, 0, 0, 4, 0};
    *text = (gltf_text){0};
    gltf_put_floats(text, corner3, 3, "VEC3");
    gltf_put_floats(text, two, 2, "SCALAR");
    gltf_put_floats(text, along, 2, "VEC3");
    gltf_put_floats(text, four, 2, "SCALAR");
    gltf_put_floats(text, upwards, 2, "VEC3");
    snprintf(rest, 2048,
             "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],'animations':[{"
             "'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
             "'samplers':[{'input':1,'output':2}]},{'name':'up',"
             "'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}],"
             "'samplers':[{'input':3,'output':4}]}]," GLTF_ONE_NODE);
}

static void a_clip_is_at_its_moment_and_begins_anew_unless_it_is_shown_once(void **state)
{
    (void)state;
    static const struct {
        lf_clip clip;
        double x, y, span;
    } cases[] = {{{0}, 0, 0, 2},
                 {{.seconds = 0.5}, 2, 0, 2},
                 {{.seconds = 2.5}, 2, 0, 2},
                 {{.seconds = 2}, 0, 0, 2},
                 {{.seconds = -0.5}, 6, 0, 2},
                 {{.seconds = 2.5, .once = true}, 8, 0, 2},
                 {{.seconds = -0.5, .once = true}, 0, 0, 2},
                 {{.seconds = 1, .name = "up", .chosen = true}, 0, 1, 4},
                 {{.seconds = 5, .number = 1, .chosen = true}, 0, 1, 4}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        gltf_text text;
        char rest[2048];
        lf_mesh_desc desc = gltf_desc();
        lf_mesh_data data = {0};
        lf_error err = {0};
        put_two_clips(&text, rest);
        desc.clip = cases[i].clip;
        lf_assert_ok(gltf_read_as(&text, rest, &desc, &data, &err), &err);
        assert_corner(&data, 0, 0, cases[i].x, cases[i].y, 0);
        lf_assert_close(data.span, cases[i].span, 0, 1e-6);
        assert_true(gltf_warns(&data, "2 animations") == !cases[i].clip.chosen);
        lf_mesh_data_finish(&data);
    }
}

static void a_clip_that_is_not_there_is_refused_with_those_that_are(void **state)
{
    (void)state;
    static const lf_clip clips[] = {{.name = "down", .chosen = true},
                                    {.number = 2, .chosen = true}};
    static const char *const words[] = {"no animation \"down\"; expected one of 0, \"up\"",
                                        "no animation 2; expected one of 0, \"up\""};
    lf_mesh_desc desc = gltf_desc();
    lf_mesh_data data = {0};
    lf_error err = {0};
    gltf_text text;
    char rest[2048];
    for (size_t i = 0; i < 2; i++) {
        put_two_clips(&text, rest);
        desc.clip = clips[i];
        assert_int_equal(gltf_read_as(&text, rest, &desc, &data, &err), LF_E_ARG);
        assert_string_equal(err.what, words[i]);
        lf_mesh_data_finish(&data);
    }
    text = (gltf_text){0};
    gltf_put_floats(&text, corner3, 3, "VEC3");
    static const char still[] =
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]," GLTF_ONE_NODE;
    assert_int_equal(gltf_read_as(&text, still, &desc, &data, &err), LF_E_ARG);
    assert_string_equal(err.what, "no animation 2; the file has no animations");
    lf_mesh_data_finish(&data);
    desc.clip = (lf_clip){.seconds = 3};
    lf_assert_ok(gltf_read_as(&text, still, &desc, &data, &err), &err);
    assert_true(data.span == 0);
    lf_mesh_data_finish(&data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quantised_positions_and_normalised_attributes_are_what_they_mean),
        cmocka_unit_test(sparse_elements_stand_in_place_of_others),
        cmocka_unit_test(indices_of_every_type_name_the_same_vertices),
        cmocka_unit_test(strips_and_fans_face_one_way),
        cmocka_unit_test(what_meshoptimizer_packed_is_unpacked),
        cmocka_unit_test(what_draco_packed_is_unpacked),
        cmocka_unit_test(what_is_packed_badly_is_refused),
        cmocka_unit_test(nodes_stand_where_their_parents_and_matrices_say),
        cmocka_unit_test(a_mirrored_node_keeps_faces_with_their_normals),
        cmocka_unit_test(instances_stand_in_their_node),
        cmocka_unit_test(a_part_without_normals_is_flat_beside_one_that_has_some),
        cmocka_unit_test(smooth_normals_go_over_seams_of_textures),
        cmocka_unit_test(morph_targets_add_by_the_nearest_weights),
        cmocka_unit_test(nodes_stand_where_an_animation_begins),
        cmocka_unit_test(a_clip_is_at_its_moment_and_begins_anew_unless_it_is_shown_once),
        cmocka_unit_test(a_clip_that_is_not_there_is_refused_with_those_that_are),
        cmocka_unit_test(vertices_follow_their_bones),
        cmocka_unit_test(what_points_beyond_is_refused_in_words),
        cmocka_unit_test(what_is_odd_is_left_out_or_cut_and_counted),
        cmocka_unit_test(nodes_that_are_no_tree_are_refused),
        cmocka_unit_test(extensions_that_it_requires_must_be_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
