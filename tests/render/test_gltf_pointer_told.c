/* Channels of animations that move nothing, from files that are wrong or hostile, are told in one
 * line; so is what else a file's animations say and the picture lacks. */
#include "tests/render/pointed.h"

/* Two keys of a number, a colour, and of numbers that are none. */
static void put_hostile(gltf_text *text)
{
    static const float colours[8] = {1, 0, 0, 1, 0, 0, 1, 1}, odd[3] = {NAN, INFINITY, 0},
                       ones[4] = {0, 1, 0, 1};
    put_corners(text);                                   /* 0 to 2 */
    gltf_put_floats(text, two_moments, 2, "SCALAR");     /* 3 */
    gltf_put_floats(text, colours, 2, "VEC4");           /* 4 */
    gltf_put_floats(text, ones, 2, "SCALAR");            /* 5 */
    gltf_put_floats(text, odd, 3, "SCALAR");             /* 6 */
    gltf_put_floats(text, ones, 4, "SCALAR");            /* 7 */
    gltf_accessor(text, 0, 5126, 1000000, "SCALAR", ""); /* 8: ends behind its view */
    gltf_accessor(text, 0, 7, 2, "SCALAR", "");          /* 9: of no type */
}

#define ROUGH "/materials/0/pbrMetallicRoughness/roughnessFactor"
#define NUMBERS "{'input':3,'output':5}"

static void what_a_pointer_cannot_move_is_told_and_stays(void **state)
{
    (void)state;
    static const struct {
        const char *pointer, *sampler, *why;
    } cases[] = {
        {"/materials/1/pbrMetallicRoughness/roughnessFactor", NUMBERS, "no such object"},
        {"/materials/4294967296/alphaCutoff", NUMBERS, "no such object"},
        {"/materials/99999999999999999999999/alphaCutoff", NUMBERS, "no such object"},
        {"/materials/18446744073709551616/alphaCutoff", NUMBERS, "no such object"},
        {"/meshes/0/weights/99999999999999999999999", NUMBERS, "no such morph target"},
        {"/meshes/0/weights/2", NUMBERS, "no such morph target"},
        {"/meshes/1/weights/0", NUMBERS, "no such morph target"},
        {"/meshes/0/weights", NUMBERS, "1 weights for 2 morph targets"},
        {"/materials/-1/alphaCutoff", NUMBERS, "does not read"},
        {"/materials/01/alphaCutoff", NUMBERS, "does not read"},
        {"/materials/0", NUMBERS, "does not read"},
        {"/materials/0/", NUMBERS, "does not read"},
        {"/", NUMBERS, "does not read"},
        {"//", NUMBERS, "does not read"},
        {"/materials/0/~0~1", NUMBERS, "does not read"},
        {BASE "/0", NUMBERS, "does not read"},
        {BASE "/", NUMBERS, "does not read"},
        {"materials/0/alphaCutoff", NUMBERS, "it has no pointer"},
        {"/materials/0/emissiveTexture/extensions/KHR_texture_transform/texCoord", NUMBERS,
         "does not read"},
        {"/materials/0/extensions/KHR_texture_transform/scale", NUMBERS, "does not read"},
        {BASE, NUMBERS, "values have 1 components; expected 4"},
        {ROUGH, "{'input':3,'output':4}", "values have 4 components; expected 1"},
        {ROUGH, "{'input':3,'output':6}", "3 values for 2 times"},
        {ROUGH, "{'input':3,'output':7}", "4 values for 2 times"},
        {ROUGH, "{'input':6,'output':5}", "2 values for 3 times"},
        {ROUGH, "{'input':6,'output':6}", "not finite"},
        {ROUGH, "{'input':3,'output':99}", "accessors[99] does not exist"},
        {ROUGH, "{'input':4294967296,'output':5}", "does not exist"},
        {ROUGH, "{'input':3,'output':8}", "accessors[8] needs"},
        {ROUGH, "{'input':3,'output':9}", "unknown type"},
        {ROUGH, "{}", "does not exist"},
        {ROUGH, "7", "does not exist"},
        {ROUGH, "", "does not exist"},
        {"/nodes/0/extensions/KHR_node_visibility/visible", NUMBERS, "unsigned bytes"},
        {"/nodes/1/extensions/KHR_node_visibility/visible", NUMBERS, "no such object"},
        {"/nodes/1/weights", NUMBERS, "1 weights for 0 morph targets"},
        {"/cameras/1/perspective/yfov", NUMBERS, "no such object"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char channel[512], words[512];
        gltf_text text = {0};
        put_hostile(&text);
        snprintf(channel, sizeof channel, POINTER("%s"), cases[i].pointer);
        lf_mesh_data data = read_channels(&text, channel, cases[i].sampler);
        snprintf(words, sizeof words, "1 animation channel is left out, %s: ", cases[i].pointer);
        if (!gltf_warns(&data, words) || !gltf_warns(&data, cases[i].why))
            fail_msg("%s %s: not %s", cases[i].pointer, cases[i].sampler, cases[i].why);
        assert_true(data.materials[0].roughness == 1 && data.materials[0].alpha_cutoff == 0.5f);
        lf_assert_close(corner_of(&data, 2)[0], 0, 0, 0);
        lf_mesh_data_finish(&data);
    }
}

static void a_name_cannot_end_its_warning(void **state)
{
    (void)state;
    char channel[2048], pointer[1024];
    gltf_text text = {0};
    put_hostile(&text);
    memset(pointer, 'x', sizeof pointer);
    memcpy(pointer, "/a\\nb\\u007f", 11);
    memcpy(pointer + 1000, "", 1);
    snprintf(channel, sizeof channel, POINTER("%s"), pointer);
    lf_mesh_data data = read_channels(&text, channel, NUMBERS);
    assert_true(gltf_warns(&data, "is left out, /a?b?xxx"));
    lf_mesh_data_finish(&data);
}

/* Nowhere, or all to the same place; the last of the latter is not the one that counts. */
static void many_channels_are_one_warning(void **state)
{
    (void)state;
    enum { MANY = 10000 };
    char *channels = calloc(MANY, 160);
    assert_non_null(channels);
    for (int kind = 0; kind < 2; kind++) {
        gltf_text text = {0};
        size_t n = 0;
        put_hostile(&text);
        for (int i = 0; i < MANY; i++)
            n += (size_t)snprintf(channels + n, MANY * 160 - n,
                                  "%s" POINTER("/materials/%d/alphaCutoff"), i ? "," : "",
                                  kind ? 0 : i + 1);
        lf_mesh_data data = read_channels(&text, channels, NUMBERS);
        assert_true(gltf_warns(
            &data, kind ? "9999 animation channels are left out, the first is "
                          "/materials/0/alphaCutoff: another channel animates the same property"
                        : "10000 animation channels are left out, the first is "
                          "/materials/1/alphaCutoff: the file has no such object"));
        lf_assert_close((double)data.materials[0].alpha_cutoff, kind ? 0.25 : 0.5, 0, 1e-6);
        lf_mesh_data_finish(&data);
    }
    free(channels);
}

#define A_TIMES_31 "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
#define A_TIMES_62 A_TIMES_31 A_TIMES_31

/* Whichever way two channels name a node's place, the first counts. */
static void of_channels_that_move_the_same_the_first_counts(void **state)
{
    (void)state;
    static const char pointer[] = POINTER("/nodes/0/translation"),
                      plain[] = "{'sampler':1,'target':{'node':0,'path':'translation'}}";
    for (int first = 0; first < 2; first++) {
        static const float five[3] = {5, 0, 0}, seven[3] = {7, 0, 0};
        char channels[1024];
        gltf_text text = {0};
        put_hostile(&text);
        gltf_put_floats(&text, (float[1]){0}, 1, "SCALAR"); /* 10 */
        gltf_put_floats(&text, five, 1, "VEC3");            /* 11 */
        gltf_put_floats(&text, seven, 1, "VEC3");           /* 12 */
        lf_mesh_data still = read_channels(&text, "", "");
        snprintf(channels, sizeof channels, "%s,%s", first ? plain : pointer,
                 first ? pointer : plain);
        lf_mesh_data data =
            read_channels(&text, channels, "{'input':10,'output':11},{'input':10,'output':12}");
        assert_true(gltf_warns(&data, "1 animation channel is left out, /nodes/0/translation: "
                                      "another channel animates the same property"));
        lf_assert_close(corner_of(&data, 0)[0] - corner_of(&still, 0)[0], first ? 7 : 5, 0, 1e-6);
        lf_mesh_data_finish(&data);
        lf_mesh_data_finish(&still);
    }
}

static void channels_that_name_nodes_are_told_where_they_move_nothing(void **state)
{
    (void)state;
    static const struct {
        const char *target, *words;
    } cases[] = {
        {"'node':0,'path':'colour'", "left out, /nodes/0/colour: quiltd does not read"},
        {"'node':9,'path':'rotation'", "left out, /nodes/9/rotation: the file has no such node"},
        {"'node':-1,'path':'rotation'", "the file has no such node"},
        {"'path':'rotation'", "left out, a channel of path \"rotation\": it names no node"},
        {"'node':2,'path':'weights'", "left out, /nodes/2/weights: the node has no mesh"},
        {"'node':0,'path':'" A_TIMES_62 "aé'", "left out, /nodes/0/" A_TIMES_62 "a: quiltd"},
        {"'path':'pointer'", "left out, a channel of path \"pointer\": it has no pointer"},
        {"", "left out, a channel of path \"\": quiltd does not read"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char channel[256];
        gltf_text text = {0};
        put_hostile(&text);
        snprintf(channel, sizeof channel, "{'sampler':0,'target':{%s}}", cases[i].target);
        lf_mesh_data data = read_channels(&text, channel, NUMBERS);
        if (!gltf_warns(&data, cases[i].words))
            fail_msg("%s: nothing of \"%s\"", cases[i].target, cases[i].words);
        lf_mesh_data_finish(&data);
    }
}

static void interpolations_that_nobody_knows_are_told(void **state)
{
    (void)state;
    gltf_text text = {0};
    put_hostile(&text);
    lf_mesh_data data = follow(&text, BASE, ",'interpolation':'BEZIER'", 0.25);
    assert_true(gltf_warns(
        &data,
        "1 animation channels have unknown interpolations, first \"BEZIER\"; LINEAR is used"));
    lf_assert_close((double)data.materials[0].albedo.z, 0.25, 0, 1e-6);
    lf_mesh_data_finish(&data);
}

static void other_animations_are_told_by_name(void **state)
{
    (void)state;
    gltf_text text = {0};
    put_hostile(&text);
    lf_mesh_data data = read_at(&text, ",'animations':[{'name':'Walk'},{},{'name':'a\\nb'}]", 0);
    assert_true(gltf_warns(&data, "of 3 animations, the first is shown; to choose another, set "
                                  "animation.clip of the mesh: \"Walk\", 1, \"a?b\""));
    lf_mesh_data_finish(&data);
}

static void a_file_that_hides_all_of_its_meshes_is_refused(void **state)
{
    (void)state;
    gltf_text text = {0};
    put_corners(&text);
    gltf_assert_refused(&text,
                        "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'children':[1],'extensions':{"
                        "'KHR_node_visibility':{'visible':false}}},{'mesh':0,'extensions':{"
                        "'KHR_node_visibility':{'visible':true}}}],"
                        "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]",
                        "every mesh is hidden by KHR_node_visibility");
}

/* What is hidden in a still file: a mesh and a light below a hidden node, no camera. */
static void hidden_nodes_have_no_mesh_and_no_light(void **state)
{
    (void)state;
    gltf_text text = {0};
    put_corners(&text);
    lf_mesh_data data = gltf_read(
        &text,
        "'extensionsRequired':['KHR_node_visibility'],'scene':0,'scenes':[{'nodes':[0,3]}],"
        "'nodes':[{'children':[1,2],'extensions':{'KHR_node_visibility':{'visible':false}}},"
        "{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}},{'camera':0},{'mesh':0}],"
        "'cameras':[{'type':'perspective','perspective':{'yfov':1}}],"
        "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}},"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]");
    assert_int_equal(data.n_triangles, 1);
    assert_int_equal(data.lights.n, 0);
    assert_int_equal(data.cameras.n, 1);
    lf_mesh_data_finish(&data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_a_pointer_cannot_move_is_told_and_stays),
        cmocka_unit_test(a_name_cannot_end_its_warning),
        cmocka_unit_test(many_channels_are_one_warning),
        cmocka_unit_test(of_channels_that_move_the_same_the_first_counts),
        cmocka_unit_test(channels_that_name_nodes_are_told_where_they_move_nothing),
        cmocka_unit_test(interpolations_that_nobody_knows_are_told),
        cmocka_unit_test(other_animations_are_told_by_name),
        cmocka_unit_test(a_file_that_hides_all_of_its_meshes_is_refused),
        cmocka_unit_test(hidden_nodes_have_no_mesh_and_no_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
