/* Every row of docs/formats/gltf.md: a file that says the one thing, and what the reader makes of
 * it. What is used changes the mesh, what says nothing of the picture changes nothing, without a
 * word; values are the matter of test_gltf_read and test_gltf_material. */
#include "tests/formats.h"
#include "tests/render/gltf_text.h"

#include <meshoptimizer.h>

#include "tests/render/gltf_packed.h"

/* Members of a file, each behind a comma. */
typedef struct saying {
    const char *attributes, *primitive, *mesh, *node, *material, *more;
} saying;

typedef struct example {
    saying says, other; /* what it is held against */
    const char *words;  /* of the warning or the error */
} example;

/* ---------------------------------------------------------------------------------- the file -- */

static const float corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5f},
                   normals[12] = {0, 0, 1, 0, 0, 1, 0, 0.6f, 0.8f, 0, 0, 1},
                   uvs[8] = {0, 0, 1, 0, 0, 1, 1, 1},
                   colours[16] = {1, 0.5f, 0, 1, 1, 0.5f, 0, 1, 1, 0.5f, 0, 1, 1, 0.5f, 0, 1},
                   tangents[16] = {0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1},
                   shifts[12] = {0.5f, 0, 1, 0.5f, 0, 1, 0.5f, 0, 1, 0.5f, 0, 1},
                   steps[18] = {0, 0, 0, 4, 2, 1, 0, 8, 0, 0, 5, 0, 1, 2, 3, 0, 0, 7};
static const unsigned char bones[16] = {0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0},
                           others[16] = {1, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 1, 1, 1, 1};

/* One pixel. */
#define BLUE_PNG                                                                                   \
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNg"           \
    "YPgPAAEDAQAIicLsAAAAAElFTkSuQmCC"
static const unsigned char blue_png[69] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
    0x44, 0x52, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x02, 0x00, 0x00,
    0x00, 0x90, 0x77, 0x53, 0xde, 0x00, 0x00, 0x00, 0x0c, 0x49, 0x44, 0x41, 0x54, 0x78,
    0x9c, 0x63, 0x60, 0x60, 0xf8, 0x0f, 0x00, 0x01, 0x03, 0x01, 0x00, 0x08, 0x89, 0xc2,
    0xec, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

/* An accessor of numbers that lie in a view, and more of it. */
static void put(gltf_text *text, const void *data, size_t n, int type, int count, const char *shape,
                const char *more)
{
    gltf_accessor(text, gltf_view(text, data, n, ""), type, count, shape, more);
}

/* 0 to 10: what vertices have, and indices. */
static void put_vertices(gltf_text *text)
{
    static const float weights[16] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    static const uint16_t words[6] = {0, 1, 2, 1, 3, 2};
    static const unsigned char bytes[6] = {0, 1, 2, 1, 3, 2};
    static const uint32_t longs[6] = {0, 1, 2, 1, 3, 2};
    gltf_put_floats(text, corners, 4, "VEC3");
    gltf_put_floats(text, normals, 4, "VEC3");
    gltf_put_floats(text, uvs, 4, "VEC2");
    gltf_put_floats(text, colours, 4, "VEC4");
    put(text, bones, sizeof bones, 5121, 4, "VEC4", "");
    gltf_put_floats(text, weights, 4, "VEC4");
    put(text, words, sizeof words, 5123, 6, "SCALAR", "");
    put(text, bytes, sizeof bytes, 5121, 6, "SCALAR", "");
    put(text, longs, sizeof longs, 5125, 6, "SCALAR", "");
    gltf_put_floats(text, tangents, 4, "VEC4");
    gltf_put_floats(text, shifts, 4, "VEC3");
}

/* 11 to 18: what moves. */
static void put_movement(gltf_text *text)
{
    static const float times[2] = {0, 1}, turns[8] = {0, 0, 0, 1, 0, 0, 0.6f, 0.8f},
                       bindings[32] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1,
                                       1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1};
    gltf_put_floats(text, times, 2, "SCALAR");
    gltf_put_floats(text, steps, 2, "VEC3");
    gltf_put_floats(text, turns, 2, "VEC4");
    gltf_put_floats(text, steps + 3, 2, "VEC3");
    gltf_put_floats(text, times, 2, "SCALAR");
    gltf_put_floats(text, steps, 6, "VEC3");
    gltf_put_floats(text, bindings, 2, "MAT4");
    gltf_put_floats(text, uvs, 4, "VEC2");
}

/* 19 to 28: the same in other ways. */
static void put_ways(gltf_text *text)
{
    static const uint16_t place = 1;
    static const float moved[3] = {3, 0, 0}, later[2] = {0, 4}, none[16] = {0};
    char sparse[256];
    int at = gltf_view(text, &place, sizeof place, ""), to = gltf_view(text, moved, 12, "");
    snprintf(sparse, sizeof sparse,
             ",'sparse':{'count':1,'indices':{'bufferView':%d,'componentType':5123},"
             "'values':{'bufferView':%d}}",
             at, to);
    gltf_accessor(text, 0, 5126, 4, "VEC3", sparse);
    gltf_accessor(text, 0, 5126, 3, "VEC3", "");
    int twice = gltf_view(text, steps, sizeof steps, "");
    gltf_accessor(text, twice, 5126, 3, "VEC3", "");
    gltf_accessor(text, twice, 5126, 3, "VEC3", ",'byteOffset':12");
    gltf_accessor(text, gltf_view(text, steps, sizeof steps, ",'byteStride':24"), 5126, 3, "VEC3",
                  "");
    gltf_put_floats(text, corners, 1, "VEC3");
    gltf_put_floats(text, corners, 1, "VEC3");
    gltf_put_floats(text, later, 2, "SCALAR");
    gltf_put_floats(text, none, 4, "VEC4");
    put(text, others, sizeof others, 5121, 4, "VEC4", "");
}

/* 29 to 39: every type; and view 38, a picture. */
static void put_types(gltf_text *text)
{
    static const int8_t bytes[8] = {0, 0, 127, 0, 0, 127, 127, 127};
    static const int16_t words[16] = {0, 0, 32767, 0, 0, 32767, 32767, 32767};
    static const uint8_t positions[12] = {0, 0, 0, 7, 0, 0, 0, 7, 0, 7, 7, 0};
    put(text, bytes, sizeof bytes, 5120, 4, "VEC2", ",'normalized':true");
    put(text, bones, 8, 5121, 4, "VEC2", ",'normalized':true");
    put(text, words, 16, 5122, 4, "VEC2", ",'normalized':true");
    put(text, words, 16, 5123, 4, "VEC2", ",'normalized':true");
    put(text, words, 16, 5123, 4, "VEC2", "");
    gltf_put_floats(text, shifts, 4, "VEC3");
    put(text, shifts, 16, 5126, 1, "MAT2", "");
    put(text, shifts, 36, 5126, 1, "MAT3", "");
    gltf_accessor(text, 0, 5126, 4, "VEC3", ",'min':[7,7,7],'max':[8,8,8]");
    gltf_accessor(text, gltf_view(text, corners, sizeof corners, ",'target':34962"), 5126, 4,
                  "VEC3", "");
    put(text, positions, sizeof positions, 5121, 4, "VEC3", "");
    assert_int_equal(gltf_view(text, blue_png, sizeof blue_png, ""), 38);
}

static const char *or_none(const char *text)
{
    return text ? text : "";
}

static lf_status read_saying(const saying *says, lf_mesh_data *data, lf_error *err)
{
    gltf_text text = {0};
    char rest[4096];
    lf_mesh_desc desc = gltf_desc();
    desc.clip.seconds = 0.25;
    put_vertices(&text);
    put_movement(&text);
    put_ways(&text);
    put_types(&text);
    int n = snprintf(
        rest, sizeof rest,
        "'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0%s}],'meshes':[{'primitives':[{'attributes':{"
        "'POSITION':0%s},'material':0%s}]%s}],'materials':[{'name':'m'%s}],"
        "'textures':[{'source':0,'sampler':0},{'source':1}],'samplers':[{}],"
        "'images':[{'uri':'" GLTF_PNG "'},{'uri':'" BLUE_PNG "'}]%s",
        or_none(says->node), or_none(says->attributes), or_none(says->primitive),
        or_none(says->mesh), or_none(says->material), or_none(says->more));
    assert_true(n > 0 && (size_t)n < sizeof rest);
    *data = (lf_mesh_data){0};
    return gltf_read_as(&text, rest, &desc, data, err);
}

/* ---------------------------------------------------------------------------------- the mesh -- */

static void say_numbers(FILE *to, const char *name, const float *values, size_t n)
{
    fprintf(to, "%s", name);
    for (size_t i = 0; values && i < n; i++)
        fprintf(to, " %.9g", (double)values[i]);
    fputc('\n', to);
}

static void say_material(FILE *to, const lf_material *m, const lf_texture_set *set)
{
    const float words[] = {m->albedo.x,
                           m->albedo.y,
                           m->albedo.z,
                           m->emission.x,
                           m->emission.y,
                           m->emission.z,
                           m->metallic,
                           m->roughness,
                           m->ior,
                           (float)m->cover,
                           m->alpha,
                           m->cutoff,
                           m->specular,
                           m->specular_tint.x,
                           m->specular_tint.y,
                           m->specular_tint.z,
                           m->coat,
                           m->coat_roughness,
                           m->sheen.x,
                           m->sheen.y,
                           m->sheen.z,
                           m->sheen_roughness,
                           m->transmission,
                           (float)m->is_solid,
                           m->glass.absorption.x,
                           m->glass.absorption.y,
                           m->glass.absorption.z,
                           m->brush.strength,
                           m->brush.turn[0],
                           m->brush.turn[1],
                           (float)m->glows_by_colours};
    say_numbers(to, m->kind->name, words, sizeof words / sizeof *words);
    for (int s = 0; set && s < LF_SLOTS; s++) {
        const lf_texture *t = &set->slot[s];
        fprintf(to, "%u %d %d %d %d %d ", t->picture, t->wrap_u, t->wrap_v, t->set, t->nearest,
                t->finest);
        say_numbers(to, "", t->map[0], 6);
        say_numbers(to, "", &t->scale, 1);
    }
}

/* All that a mesh is, as text. The caller frees it. */
static char *text_of(const lf_mesh_data *data)
{
    char *text = NULL;
    size_t size = 0, n = (size_t)data->n_vertices;
    FILE *to = open_memstream(&text, &size);
    assert_non_null(to);
    for (size_t i = 0; i < 3 * n; i++)
        fprintf(to, "%.9g ", data->positions[i]);
    for (size_t i = 0; i < 3 * (size_t)data->n_triangles; i++)
        fprintf(to, "%u ", data->triangles[i]);
    for (int i = 0; i < data->n_triangles; i++)
        fprintf(to, "%d ", data->triangle_material[i]);
    say_numbers(to, "normals", data->normals, 3 * n);
    say_numbers(to, "uvs", data->uvs, 2 * n * (size_t)data->n_uv_sets);
    say_numbers(to, "colours", data->colours, 4 * n);
    say_numbers(to, "tangents", data->tangents, 4 * n);
    for (int i = 0; i < data->n_materials; i++)
        say_material(to, &data->materials[i], data->textures ? &data->textures[i] : NULL);
    for (int i = 0; i < data->n_pictures; i++)
        fprintf(to, "%dx%d %02x%02x%02x\n", data->pictures[i].width, data->pictures[i].height,
                data->pictures[i].rgba[0], data->pictures[i].rgba[1], data->pictures[i].rgba[2]);
    for (int i = 0; i < data->lights.n; i++) {
        const lf_punctual *l = &data->lights.open[i];
        fprintf(to, "%d %g %g %g %g %g\n", l->kind, l->intensity[0], l->intensity[1],
                l->direction[0], l->inner, l->outer);
    }
    for (int i = 0; i < data->cameras.n; i++)
        fprintf(to, "%g %d\n", data->cameras.open[i].fov_y, data->cameras.open[i].parallel);
    fclose(to);
    return text;
}

static lf_mesh_data read_ok(const lf_format_row *row, const saying *says)
{
    lf_mesh_data data;
    lf_error err = {0};
    if (read_saying(says, &data, &err) != LF_OK)
        fail_msg("%s: %s", row->name, err.what);
    return data;
}

/* ------------------------------------------------------------------------------------ checks -- */

/* Whether it makes another mesh than its other does; without a word that this has not. */
static void compare(const lf_format_row *row, bool other)
{
    const example *e = row->with;
    lf_mesh_data a = read_ok(row, &e->says), b = read_ok(row, &e->other);
    char *said = text_of(&a), *held = text_of(&b);
    if ((strcmp(said, held) != 0) != other)
        fail_msg("%s: %s mesh:\n%s", row->name, other ? "the same" : "another", said);
    if (a.warnings.n > b.warnings.n)
        fail_msg("%s: %s", row->name, lf_warnings_at(&a.warnings, 0));
    free(said);
    free(held);
    lf_mesh_data_finish(&a);
    lf_mesh_data_finish(&b);
}

static void changes(const lf_format_row *row)
{
    compare(row, true);
}

static void changes_nothing(const lf_format_row *row)
{
    compare(row, false);
}

static void is_told(const lf_format_row *row)
{
    const example *e = row->with;
    lf_mesh_data data = read_ok(row, &e->says), plain = read_ok(row, &(saying){0});
    assert_int_equal(plain.warnings.n, 0);
    if (!gltf_warns(&data, e->words))
        fail_msg("%s: no warning says \"%s\"; the first: %s", row->name, e->words,
                 lf_warnings_at(&data.warnings, 0));
    lf_mesh_data_finish(&data);
    lf_mesh_data_finish(&plain);
}

static void is_refused(const lf_format_row *row)
{
    const example *e = row->with;
    lf_mesh_data data;
    lf_error err = {0};
    if (read_saying(&e->says, &data, &err) == LF_OK)
        fail_msg("%s: it is read", row->name);
    if (!strstr(err.what, e->words))
        fail_msg("%s: \"%s\" does not say \"%s\"", row->name, err.what, e->words);
    lf_mesh_data_finish(&data);
}

/* Used: a wrong one is seen. */
static void refused_as_used(const lf_format_row *row)
{
    is_refused(row);
}

/* A picture of one pixel that is not the document's own two. */
static void picture(const lf_format_row *row)
{
    const example *e = row->with;
    lf_mesh_data data = read_ok(row, &e->says);
    assert_int_equal(data.warnings.n, 0);
    assert_int_equal(data.n_pictures, 1);
    assert_true(data.pictures[0].width == 1 && data.pictures[0].height == 1);
    lf_mesh_data_finish(&data);
}

/* camera_frame.c refuses to look through one that is parallel. */
static void orthographic(const lf_format_row *row)
{
    const example *e = row->with;
    lf_mesh_data data = read_ok(row, &e->says);
    assert_int_equal(data.cameras.n, 1);
    assert_true(data.cameras.open[0].parallel);
    lf_mesh_data_finish(&data);
}

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

/* ------------------------------------------------------------------------------------ tables -- */

static const lf_format_row gltf[] = {
    {"asset.version", "refused", is_refused,
     &(const example){.says = {.more = ",'asset':{'version':'1.0'}"},
                      .words = "glTF of version 1.0; expected 2.0"}},
    {"asset.minVersion", "refused", is_refused,
     &(const example){.says = {.more = ",'asset':{'version':'2.0','minVersion':'2.1'}"},
                      .words = "glTF of version 2.1; expected 2.0"}},
    {"asset.generator", "ignored", changes_nothing,
     &(const example){.says = {.more = ",'asset':{'version':'2.0','generator':'x'}"}}},
    {"asset.copyright", "ignored", changes_nothing,
     &(const example){.says = {.more = ",'asset':{'version':'2.0','copyright':'x'}"}}},
    {"extensionsUsed", "told", is_told,
     &(const example){.says = {.more = ",'extensionsUsed':['XX_any']"},
                      .words = "the extension XX_any is not known here"}},
    {"extensionsRequired", "refused", is_refused,
     &(const example){.says = {.more = ",'extensionsRequired':['XX_any']"},
                      .words = "not known here: XX_any"}},
    {"extras", "ignored", changes_nothing,
     &(const example){.says = {.primitive = ",'extras':[4]",
                               .node = ",'extras':{'b':2}",
                               .material = ",'extras':3",
                               .more = ",'extras':{'a':1}"}}},
    {"name", "ignored", changes_nothing,
     &(const example){.says = {.mesh = ",'name':'s'", .node = ",'name':'n'"}}},
    {"scene", "used", changes,
     &(const example){.says = {.more = ",'nodes':[{'mesh':0},{'mesh':0,'translation':[5,0,0]}],'"
                                       "scenes':[{'nodes':[0]},{'nodes':[1]}],'scene':1"},
                      .other = {.more = ",'nodes':[{'mesh':0},{'mesh':0,'translation':[5,0,0]}],'"
                                        "scenes':[{'nodes':[0]},{'nodes':[1]}],'scene':0"}}},
    {"scenes", "told", is_told,
     &(const example){.says = {.more = ",'nodes':[{'mesh':0},{'mesh':0,'translation':[5,0,0]}],'"
                                       "scenes':[{'nodes':[0]},{'nodes':[1]}]"},
                      .words = "2 scenes: the first is shown"}},
    {"scenes.nodes", "used", changes,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0},{'mesh':0}],'scenes':[{'nodes':[0,1]}]"},
         .other = {.more = ",'nodes':[{'mesh':0},{'mesh':0}]"}}},
    {"nodes.children", "used", changes,
     &(const example){
         .says = {.more = ",'nodes':[{'children':[1],'translation':[1,0,0]},{'mesh':0}]"}}},
    {"nodes.mesh", "used", changes,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0},{'mesh':0}],'scenes':[{'nodes':[0,1]}]"},
         .other = {.more = ",'nodes':[{'mesh':0},{}],'scenes':[{'nodes':[0,1]}]"}}},
    {"nodes.matrix", "used", changes,
     &(const example){.says = {.node = ",'matrix':[2,0,0,0,0,1,0,0,0,0,1,0,1,2,3,1]"}}},
    {"nodes.translation", "used", changes,
     &(const example){.says = {.node = ",'translation':[1,2,3]"}}},
    {"nodes.rotation", "used", changes,
     &(const example){.says = {.node = ",'rotation':[0,0,0.6,0.8]"}}},
    {"nodes.scale", "used", changes, &(const example){.says = {.node = ",'scale':[1,2,3]"}}},
    {"nodes.weights", "used", changes,
     &(const example){
         .says = {.primitive = ",'targets':[{'POSITION':10}]", .node = ",'weights':[0.5]"},
         .other = {.primitive = ",'targets':[{'POSITION':10}]"}}},
    {"nodes.skin", "used", changes,
     &(const example){
         .says = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                  .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'"
                          "joints':[1,2]}]"},
         .other =
             {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
              .more =
                  ",'nodes':[{'mesh':0},{'translation':[1,2,3]},{}],'skins':[{'joints':[1,2]}]"}}},
    {"nodes.camera", "used", changes,
     &(const example){.says = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'"
                                       "perspective','perspective':{'yfov':1,'znear':1}}]"}}},
    {"meshes.primitives", "used", changes,
     &(const example){.says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'"
                                       "attributes':{'POSITION':0}}]}]"}}},
    {"meshes.weights", "used", changes,
     &(const example){
         .says = {.primitive = ",'targets':[{'POSITION':10}]", .mesh = ",'weights':[0.5]"},
         .other = {.primitive = ",'targets':[{'POSITION':10}]"}}},
    {"primitives.attributes.POSITION", "used", changes,
     &(const example){
         .says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':20}}]}]"}}},
    {"primitives.attributes.NORMAL", "used", changes,
     &(const example){.says = {.attributes = ",'NORMAL':1"}}},
    {"primitives.attributes.TANGENT", "used", changes,
     &(const example){
         .says = {.attributes = ",'NORMAL':1,'TANGENT':9",
                  .material = ",'normalTexture':{'index':0}"},
         .other = {.attributes = ",'NORMAL':1", .material = ",'normalTexture':{'index':0}"}}},
    {"primitives.attributes.TEXCOORD_0", "used", changes,
     &(const example){
         .says = {.attributes = ",'TEXCOORD_0':2",
                  .material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"}}},
    {"primitives.attributes.TEXCOORD_1", "used", changes,
     &(const example){
         .says = {.attributes = ",'TEXCOORD_1':2",
                  .material =
                      ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1}}"},
         .other = {.material =
                       ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1}}"}}},
    {"primitives.attributes.TEXCOORD_n", "told", is_told,
     &(const example){
         .says = {.material =
                      ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':2}}"},
         .words = "a texture that lies by a third set"}},
    {"primitives.attributes.COLOR_0", "used", changes,
     &(const example){.says = {.attributes = ",'COLOR_0':3"}}},
    {"primitives.attributes.COLOR_n", "told", is_told,
     &(const example){.says = {.attributes = ",'COLOR_0':3,'COLOR_1':3"},
                      .words = "1 part has more colours than COLOR_0"}},
    {"primitives.attributes.JOINTS_0", "used", changes,
     &(const example){.says = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                               .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'"
                                       "skins':[{'joints':[1,2]}]"},
                      .other = {.more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],"
                                        "'skins':[{'joints':[1,2]}]"}}},
    {"primitives.attributes.WEIGHTS_0", "used", changes,
     &(const example){.says = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                               .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'"
                                       "skins':[{'joints':[1,2]}]"},
                      .other = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':27",
                                .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],"
                                        "'skins':[{'joints':[1,2]}]"}}},
    {"primitives.attributes.JOINTS_1", "used", changes,
     &(const example){
         .says = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5,'JOINTS_1':28,'WEIGHTS_1':5",
                  .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'"
                          "joints':[1,2]}]"},
         .other = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                   .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'"
                           "joints':[1,2]}]"}}},
    {"primitives.attributes.WEIGHTS_1", "used", changes,
     &(const example){
         .says = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5,'JOINTS_1':28,'WEIGHTS_1':5",
                  .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'"
                          "joints':[1,2]}]"},
         .other = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5,'JOINTS_1':28,'WEIGHTS_1':27",
                   .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'"
                           "joints':[1,2]}]"}}},
    {"primitives.attributes.JOINTS_n", "told", is_told,
     &(const example){
         .says = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5,'JOINTS_2':4,'WEIGHTS_2':5",
                  .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'"
                          "joints':[1,2]}]"},
         .words = "1 part has more than eight joints a vertex"}},
    {"primitives.attributes.WEIGHTS_n", "told", is_told,
     &(const example){
         .says = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5,'JOINTS_2':4,'WEIGHTS_2':5",
                  .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'skins':[{'"
                          "joints':[1,2]}]"},
         .words = "1 part has more than eight joints a vertex"}},
    {"primitives.attributes._X", "ignored", changes_nothing,
     &(const example){.says = {.attributes = ",'_BATCH':3"}}},
    {"primitives.indices", "used", changes,
     &(const example){.says = {.primitive = ",'indices':6"}}},
    {"primitives.material", "used", changes,
     &(const example){
         .says = {.more = ",'materials':[{'pbrMetallicRoughness':{'metallicFactor':0.25}}]"},
         .other = {.more = ",'materials':[{'name':'x'}]"}}},
    {"primitives.mode 0 (points)", "told", is_told,
     &(const example){.says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'"
                                       "attributes':{'POSITION':0},'mode':0}]}]"},
                      .words = "4 points and lines are left out"}},
    {"primitives.mode 1 (lines)", "told", is_told,
     &(const example){.says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'"
                                       "attributes':{'POSITION':0},'mode':1}]}]"},
                      .words = "2 points and lines are left out"}},
    {"primitives.mode 2 (line loop)", "told", is_told,
     &(const example){.says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'"
                                       "attributes':{'POSITION':0},'mode':2}]}]"},
                      .words = "4 points and lines are left out"}},
    {"primitives.mode 3 (line strip)", "told", is_told,
     &(const example){.says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'"
                                       "attributes':{'POSITION':0},'mode':3}]}]"},
                      .words = "4 points and lines are left out"}},
    {"primitives.mode 4 (triangles)", "used", changes,
     &(const example){.says = {.primitive = ",'mode':4"}, .other = {.primitive = ",'mode':5"}}},
    {"primitives.mode 5 (triangle strip)", "used", changes,
     &(const example){.says = {.primitive = ",'mode':5"}}},
    {"primitives.mode 6 (triangle fan)", "used", changes,
     &(const example){.says = {.primitive = ",'mode':6"}, .other = {.primitive = ",'mode':5"}}},
    {"primitives.targets.POSITION", "used", changes,
     &(const example){
         .says = {.primitive = ",'targets':[{'POSITION':10}]", .node = ",'weights':[0.5]"}}},
    {"primitives.targets.NORMAL", "used", changes,
     &(const example){.says = {.attributes = ",'NORMAL':1",
                               .primitive = ",'targets':[{'NORMAL':10}]",
                               .node = ",'weights':[0.5]"},
                      .other = {.attributes = ",'NORMAL':1"}}},
    {"primitives.targets.TANGENT", "used", changes,
     &(const example){.says = {.attributes = ",'NORMAL':1,'TANGENT':9",
                               .primitive = ",'targets':[{'TANGENT':10}]",
                               .node = ",'weights':[0.5]",
                               .material = ",'normalTexture':{'index':0}"},
                      .other = {.attributes = ",'NORMAL':1,'TANGENT':9",
                                .material = ",'normalTexture':{'index':0}"}}},
    {"primitives.targets.TEXCOORD_n", "told", is_told,
     &(const example){
         .says = {.primitive = ",'targets':[{'TEXCOORD_0':2}]", .node = ",'weights':[0.5]"},
         .words = "1 part has morph targets of texture coordinates or colours"}},
    {"primitives.targets.COLOR_n", "told", is_told,
     &(const example){
         .says = {.primitive = ",'targets':[{'COLOR_0':3}]", .node = ",'weights':[0.5]"},
         .words = "1 part has morph targets of texture coordinates or colours"}},
    {"accessors.bufferView", "used", changes,
     &(const example){
         .says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':21}}]}]"},
         .other = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':20}}]}]"}}},
    {"accessors.byteOffset", "used", changes,
     &(const example){
         .says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':22}}]}]"},
         .other = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':21}}]}]"}}},
    {"accessors.count", "used", changes,
     &(const example){
         .says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':5}]}]"},
         .other = {.more =
                       ",'meshes':[{'primitives':[{'attributes':{'POSITION':20},'mode':5}]}]"}}},
    {"accessors.componentType 5120 (byte)", "used", changes,
     &(const example){
         .says = {.attributes = ",'TEXCOORD_0':29",
                  .material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"}}},
    {"accessors.componentType 5121 (unsigned byte)", "used", changes,
     &(const example){
         .says = {.attributes = ",'TEXCOORD_0':30",
                  .material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"}}},
    {"accessors.componentType 5122 (short)", "used", changes,
     &(const example){
         .says = {.attributes = ",'TEXCOORD_0':31",
                  .material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"}}},
    {"accessors.componentType 5123 (unsigned short)", "used", changes,
     &(const example){
         .says = {.attributes = ",'TEXCOORD_0':32",
                  .material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"}}},
    {"accessors.componentType 5126 (float)", "used", changes,
     &(const example){
         .says = {.attributes = ",'TEXCOORD_0':2",
                  .material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"}}},
    {"accessors.componentType 5125 (unsigned int)", "used", changes,
     &(const example){.says = {.primitive = ",'indices':8"}}},
    {"accessors.normalized", "used", changes,
     &(const example){
         .says = {.attributes = ",'TEXCOORD_0':32",
                  .material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"},
         .other = {.attributes = ",'TEXCOORD_0':33",
                   .material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"}}},
    {"accessors.type SCALAR", "used", changes,
     &(const example){.says = {.primitive = ",'indices':7"}}},
    {"accessors.type VEC2", "used", changes,
     &(const example){
         .says = {.attributes = ",'TEXCOORD_0':2",
                  .material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"}}},
    {"accessors.type VEC3", "used", changes,
     &(const example){.says = {.attributes = ",'COLOR_0':34"}}},
    {"accessors.type VEC4", "used", changes,
     &(const example){.says = {.attributes = ",'COLOR_0':3"}}},
    {"accessors.type MAT2", "refused", is_refused,
     &(const example){.says = {.attributes = ",'NORMAL':35"},
                      .words = "no such type or componentType"}},
    {"accessors.type MAT3", "refused", is_refused,
     &(const example){.says = {.attributes = ",'NORMAL':36"},
                      .words = "no such type or componentType"}},
    {"accessors.type MAT4", "used", changes,
     &(const example){.says = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                               .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'"
                                       "skins':[{'joints':[1,2],'inverseBindMatrices':17}]"},
                      .other = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                                .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],"
                                        "'skins':[{'joints':[1,2]}]"}}},
    {"accessors.min", "ignored", changes_nothing,
     &(const example){
         .says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':37}}]}]"},
         .other = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"}}},
    {"accessors.max", "ignored", changes_nothing,
     &(const example){
         .says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':37}}]}]"},
         .other = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"}}},
    {"accessors.sparse", "used", changes,
     &(const example){
         .says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':19}}]}]"},
         .other = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"}}},
    {"bufferViews.buffer", "used", refused_as_used,
     &(const example){.says = {.more = ",'bufferViews':[{'buffer':9,'byteLength':48}]"},
                      .words = "buffers[9] is not there"}},
    {"bufferViews.byteOffset", "used", changes,
     &(const example){
         .says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"},
         .other = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':21}}]}]"}}},
    {"bufferViews.byteLength", "used", refused_as_used,
     &(const example){.says = {.more = ",'bufferViews':[{'buffer':0,'byteLength':8}]"},
                      .words = "where there are 8"}},
    {"bufferViews.byteStride", "used", changes,
     &(const example){
         .says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':23}}]}]"},
         .other = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':21}}]}]"}}},
    {"bufferViews.target", "ignored", changes_nothing,
     &(const example){
         .says = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':38}}]}]"},
         .other = {.more = ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"}}},
    {"buffers.uri", "used", refused_as_used,
     &(const example){.says = {.more = ",'buffers':[{'uri':'gone.bin','byteLength':36}]"},
                      .words = "\"gone.bin\" is not to be had"}},
    {"buffers.byteLength", "used", refused_as_used,
     &(const example){
         .says = {.more = ",'buffers':[{'uri':'data:;base64,AAAA','byteLength':99999}]"},
         .words = "a buffer of 99999 bytes, where there are 3"}},
    {"textures.source", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'textures':[{'source':0}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'textures':[{'source':1}]"}}},
    {"textures.sampler", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'textures':[{'source':0,'sampler':0}],'samplers':[{'wrapS':33071}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'textures':[{'source':0}],'samplers':[{'wrapS':33071}]"}}},
    {"samplers.magFilter 9728 (nearest)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'magFilter':9728}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'magFilter':9729}]"}}},
    {"samplers.magFilter 9729 (linear)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'magFilter':9729}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'magFilter':9728}]"}}},
    {"samplers.minFilter 9728 (nearest)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'minFilter':9728}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'minFilter':9987}]"}}},
    {"samplers.minFilter 9729 (linear)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'minFilter':9729}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'minFilter':9987}]"}}},
    {"samplers.minFilter 9984 (nearest, mipmap nearest)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'minFilter':9984}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'minFilter':9729}]"}}},
    {"samplers.minFilter 9985 (linear, mipmap nearest)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'minFilter':9985}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'minFilter':9729}]"}}},
    {"samplers.minFilter 9986 (nearest, mipmap linear)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'minFilter':9986}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'minFilter':9729}]"}}},
    {"samplers.minFilter 9987 (linear, mipmap linear)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'minFilter':9987}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'minFilter':9729}]"}}},
    {"samplers.wrapS 10497 (repeat)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'wrapS':10497}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'wrapS':33071}]"}}},
    {"samplers.wrapS 33071 (clamp to edge)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'wrapS':33071}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'wrapS':10497}]"}}},
    {"samplers.wrapS 33648 (mirrored repeat)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'wrapS':33648}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'wrapS':10497}]"}}},
    {"samplers.wrapT 10497 (repeat)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'wrapT':10497}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'wrapT':33071}]"}}},
    {"samplers.wrapT 33071 (clamp to edge)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'wrapT':33071}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'wrapT':10497}]"}}},
    {"samplers.wrapT 33648 (mirrored repeat)", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'samplers':[{'wrapT':33648}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'samplers':[{'wrapT':10497}]"}}},
    {"images.uri", "told", is_told,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'images':[{'uri':'gone.png'},{'uri':'gone.png'}]"},
         .words = "picture \"gone.png\" is not to be had"}},
    {"images.bufferView", "used", picture,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'images':[{'bufferView':38,'mimeType':'image/png'}]"},
         .other = {.more = ",'images':[{'bufferView':38,'mimeType':'image/png'}]"}}},
    {"images.mimeType", "ignored", changes_nothing,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'images':[{'bufferView':38,'mimeType':'image/jpeg'}]"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                   .more = ",'images':[{'bufferView':38}]"}}},
    {"materials.pbrMetallicRoughness.baseColorFactor", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorFactor':[0.1,0.2,0.3,1]}"}}},
    {"materials.pbrMetallicRoughness.baseColorTexture", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"}}},
    {"materials.pbrMetallicRoughness.metallicFactor", "used", changes,
     &(const example){.says = {.material = ",'pbrMetallicRoughness':{'metallicFactor':0.5}"}}},
    {"materials.pbrMetallicRoughness.roughnessFactor", "used", changes,
     &(const example){.says = {.material = ",'pbrMetallicRoughness':{'roughnessFactor':0.5}"}}},
    {"materials.pbrMetallicRoughness.metallicRoughnessTexture", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'metallicRoughnessTexture':{'index':0}}"}}},
    {"materials.normalTexture", "used", changes,
     &(const example){.says = {.material = ",'normalTexture':{'index':0}"}}},
    {"materials.normalTexture.scale", "used", changes,
     &(const example){.says = {.material = ",'normalTexture':{'index':0,'scale':0.5}"},
                      .other = {.material = ",'normalTexture':{'index':0}"}}},
    {"materials.occlusionTexture", "told", is_told,
     &(const example){.says = {.material = ",'occlusionTexture':{'index':0}"},
                      .words = "the occlusion texture is left out"}},
    {"materials.occlusionTexture.strength", "told", is_told,
     &(const example){.says = {.material = ",'occlusionTexture':{'index':0,'strength':0.5}"},
                      .words = "the occlusion texture is left out"}},
    {"materials.emissiveTexture", "used", changes,
     &(const example){
         .says = {.material = ",'emissiveFactor':[1,1,1],'emissiveTexture':{'index':0}"},
         .other = {.material = ",'emissiveFactor':[1,1,1]"}}},
    {"materials.emissiveFactor", "used", changes,
     &(const example){.says = {.material = ",'emissiveFactor':[1,1,1]"}}},
    {"materials.alphaMode OPAQUE", "used", changes,
     &(const example){.says = {.material = ",'alphaMode':'OPAQUE'"},
                      .other = {.material = ",'alphaMode':'BLEND'"}}},
    {"materials.alphaMode MASK", "used", changes,
     &(const example){.says = {.material = ",'alphaMode':'MASK'"}}},
    {"materials.alphaMode BLEND", "used", changes,
     &(const example){.says = {.material = ",'alphaMode':'BLEND'"}}},
    {"materials.alphaCutoff", "used", changes,
     &(const example){.says = {.material = ",'alphaMode':'MASK','alphaCutoff':1.5"},
                      .other = {.material = ",'alphaMode':'MASK','alphaCutoff':1"}}},
    {"materials.doubleSided", "ignored", changes_nothing,
     &(const example){.says = {.material = ",'doubleSided':true"}}},
    {"textureInfo.index", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':1}}"}}},
    {"textureInfo.texCoord", "used", changes,
     &(const example){
         .says = {.material =
                      ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"}}},
    {"animations", "told", is_told,
     &(const example){
         .says =
             {.more =
                  ",'animations':[{'channels':[],'samplers':[]},{'channels':[],'samplers':[]}]"},
         .words = "2 animations: the first is shown"}},
    {"animations.channels.target.path translation", "used", changes,
     &(const example){
         .says = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                          "translation'}}],'samplers':[{'input':11,'output':12}]}]"}}},
    {"animations.channels.target.path rotation", "used", changes,
     &(const example){
         .says = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                          "rotation'}}],'samplers':[{'input':11,'output':13}]}]"},
         .other = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                           "translation'}}],'samplers':[{'input':11,'output':12}]}]"}}},
    {"animations.channels.target.path scale", "used", changes,
     &(const example){
         .says = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                          "scale'}}],'samplers':[{'input':11,'output':14}]}]"},
         .other = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                           "translation'}}],'samplers':[{'input':11,'output':12}]}]"}}},
    {"animations.channels.target.path weights", "used", changes,
     &(const example){
         .says = {.primitive = ",'targets':[{'POSITION':10}]",
                  .more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                          "weights'}}],'samplers':[{'input':11,'output':15}]}]"},
         .other = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                           "weights'}}],'samplers':[{'input':11,'output':15}]}]"}}},
    {"animations.channels.target.node", "used", changes,
     &(const example){
         .says = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                          "translation'}}],'samplers':[{'input':11,'output':12}]}]"},
         .other = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'path':'translation'"
                           "}}],'samplers':[{'input':11,'output':12}]}]"}}},
    {"animations.channels.sampler", "used", changes,
     &(const example){
         .says = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                          "translation'}}],'samplers':[{'input':11,'output':12}]}]"},
         .other =
             {.more =
                  ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'"
                  "}}],'samplers':[{'input':11,'output':14},{'input':11,'output':12}]}]"}}},
    {"animations.samplers.input", "used", changes,
     &(const example){
         .says = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                          "translation'}}],'samplers':[{'input':11,'output':12}]}]"},
         .other = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                           "translation'}}],'samplers':[{'input':26,'output':12}]}]"}}},
    {"animations.samplers.output", "used", changes,
     &(const example){
         .says = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                          "translation'}}],'samplers':[{'input':11,'output':12}]}]"},
         .other = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                           "translation'}}],'samplers':[{'input':11,'output':14}]}]"}}},
    {"animations.samplers.interpolation LINEAR", "used", changes,
     &(const example){
         .says =
             {.more =
                  ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'"
                  "}}],'samplers':[{'input':11,'output':12,'interpolation':'LINEAR'}]}]"},
         .other =
             {.more =
                  ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'"
                  "}}],'samplers':[{'input':11,'output':12,'interpolation':'STEP'}]}]"}}},
    {"animations.samplers.interpolation STEP", "used", changes,
     &(const example){
         .says =
             {.more =
                  ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'"
                  "}}],'samplers':[{'input':11,'output':12,'interpolation':'STEP'}]}]"},
         .other = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                           "translation'}}],'samplers':[{'input':11,'output':12}]}]"}}},
    {"animations.samplers.interpolation CUBICSPLINE", "used", changes,
     &(const example){
         .says =
             {.more =
                  ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'translation'"
                  "}}],'samplers':[{'input':11,'output':16,'interpolation':'CUBICSPLINE'}]}]"},
         .other = {.more = ",'animations':[{'channels':[{'sampler':0,'target':{'node':0,'path':'"
                           "translation'}}],'samplers':[{'input':11,'output':16}]}]"}}},
    {"skins.joints", "used", changes,
     &(const example){.says = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                               .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'"
                                       "skins':[{'joints':[1,2]}]"},
                      .other = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                                .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],"
                                        "'skins':[{'joints':[2,1]}]"}}},
    {"skins.inverseBindMatrices", "used", changes,
     &(const example){.says = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                               .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'"
                                       "skins':[{'joints':[1,2],'inverseBindMatrices':17}]"},
                      .other = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                                .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],"
                                        "'skins':[{'joints':[1,2]}]"}}},
    {"skins.skeleton", "ignored", changes_nothing,
     &(const example){.says = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                               .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],'"
                                       "skins':[{'joints':[1,2],'skeleton':1}]"},
                      .other = {.attributes = ",'JOINTS_0':4,'WEIGHTS_0':5",
                                .more = ",'nodes':[{'mesh':0,'skin':0},{'translation':[1,2,3]},{}],"
                                        "'skins':[{'joints':[1,2]}]"}}},
    {"cameras.perspective.yfov", "used", changes,
     &(const example){.says = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'"
                                       "perspective','perspective':{'yfov':0.5,'znear':1}}]"},
                      .other = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'"
                                        "perspective','perspective':{'yfov':1,'znear':1}}]"}}},
    {"cameras.perspective.aspectRatio", "ignored", changes_nothing,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','"
                          "perspective':{'yfov':1,'znear':1,'aspectRatio':2}}]"},
         .other = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','"
                           "perspective':{'yfov':1,'znear':1}}]"}}},
    {"cameras.perspective.znear", "ignored", changes_nothing,
     &(const example){.says = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'"
                                       "perspective','perspective':{'yfov':1,'znear':2}}]"},
                      .other = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'"
                                        "perspective','perspective':{'yfov':1,'znear':1}}]"}}},
    {"cameras.perspective.zfar", "ignored", changes_nothing,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','"
                          "perspective':{'yfov':1,'znear':1,'zfar':3}}]"},
         .other = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'perspective','"
                           "perspective':{'yfov':1,'znear':1}}]"}}},
    {"cameras.type orthographic", "refused", orthographic,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'orthographic','"
                          "orthographic':{'xmag':1,'ymag':1,'znear':0,'zfar':9}}]"}}},
    {"cameras.orthographic.xmag", "refused", orthographic,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'orthographic','"
                          "orthographic':{'xmag':1,'ymag':1,'znear':0,'zfar':9}}]"}}},
    {"cameras.orthographic.ymag", "refused", orthographic,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'orthographic','"
                          "orthographic':{'xmag':1,'ymag':1,'znear':0,'zfar':9}}]"}}},
    {"cameras.orthographic.znear", "refused", orthographic,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'orthographic','"
                          "orthographic':{'xmag':1,'ymag':1,'znear':0,'zfar':9}}]"}}},
    {"cameras.orthographic.zfar", "refused", orthographic,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'camera':0}],'cameras':[{'type':'orthographic','"
                          "orthographic':{'xmag':1,'ymag':1,'znear':0,'zfar':9}}]"}}},
    {"GLB header", "refused", glb_header, NULL},
    {"GLB JSON chunk", "used", glb_whole, NULL},
    {"GLB BIN chunk", "used", glb_whole, NULL},
    {"GLB chunks of other kinds", "ignored", glb_whole, NULL},
    {"GLB padding", "ignored", glb_whole, NULL},
};

static const lf_format_row extensions[] = {
    {"KHR_draco_mesh_compression", "used", draco, NULL},
    {"KHR_materials_anisotropy.anisotropyStrength", "used", changes,
     &(const example){
         .says = {.material =
                      ",'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':0.5}}"}}},
    {"KHR_materials_anisotropy.anisotropyRotation", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':0.5,"
                              "'anisotropyRotation':1}}"},
         .other = {.material =
                       ",'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':0.5}}"}}},
    {"KHR_materials_anisotropy.anisotropyTexture", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':0.5,"
                              "'anisotropyTexture':{'index':0}}}"},
         .other = {.material =
                       ",'extensions':{'KHR_materials_anisotropy':{'anisotropyStrength':0.5}}"}}},
    {"KHR_materials_clearcoat.clearcoatFactor", "used", changes,
     &(const example){
         .says = {.material =
                      ",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5}}"}}},
    {"KHR_materials_clearcoat.clearcoatTexture", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5,'"
                              "clearcoatTexture':{'index':0}}}"},
         .other = {.material =
                       ",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5}}"}}},
    {"KHR_materials_clearcoat.clearcoatRoughnessFactor", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5,'"
                              "clearcoatRoughnessFactor':0.5}}"},
         .other = {.material =
                       ",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5}}"}}},
    {"KHR_materials_clearcoat.clearcoatRoughnessTexture", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5,'"
                              "clearcoatRoughnessTexture':{'index':0}}}"},
         .other = {.material =
                       ",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5}}"}}},
    {"KHR_materials_clearcoat.clearcoatNormalTexture", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5,'"
                              "clearcoatNormalTexture':{'index':0}}}"},
         .other = {.material =
                       ",'extensions':{'KHR_materials_clearcoat':{'clearcoatFactor':0.5}}"}}},
    {"KHR_materials_diffuse_transmission.diffuseTransmissionFactor", "told", is_told,
     &(const example){.says = {.material = ",'extensions':{'KHR_materials_diffuse_transmission':{'"
                                           "diffuseTransmissionFactor':0.5}}"},
                      .words = "diffuse transmission is left out"}},
    {"KHR_materials_diffuse_transmission.diffuseTransmissionTexture", "told", is_told,
     &(const example){
         .says = {.material =
                      ",'extensions':{'KHR_materials_diffuse_transmission':{'"
                      "diffuseTransmissionFactor':0.5,'diffuseTransmissionTexture':{'index':0}}}"},
         .words = "diffuse transmission is left out"}},
    {"KHR_materials_diffuse_transmission.diffuseTransmissionColorFactor", "told", is_told,
     &(const example){
         .says = {.material =
                      ",'extensions':{'KHR_materials_diffuse_transmission':{'"
                      "diffuseTransmissionFactor':0.5,'diffuseTransmissionColorFactor':[1,0,0]}}"},
         .words = "diffuse transmission is left out"}},
    {"KHR_materials_diffuse_transmission.diffuseTransmissionColorTexture", "told", is_told,
     &(const example){
         .says =
             {.material =
                  ",'extensions':{'KHR_materials_diffuse_transmission':{'diffuseTransmissionFactor'"
                  ":0.5,'diffuseTransmissionColorTexture':{'index':0}}}"},
         .words = "diffuse transmission is left out"}},
    {"KHR_materials_dispersion.dispersion", "told", is_told,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_dispersion':{'dispersion':1}}"},
         .words = "dispersion is left out"}},
    {"KHR_materials_emissive_strength.emissiveStrength", "used", changes,
     &(const example){.says = {.material = ",'emissiveFactor':[1,1,1],'extensions':{'KHR_materials_"
                                           "emissive_strength':{'emissiveStrength':9}}"},
                      .other = {.material = ",'emissiveFactor':[1,1,1]"}}},
    {"KHR_materials_ior.ior", "used", changes,
     &(const example){.says = {.material = ",'extensions':{'KHR_materials_ior':{'ior':0}}"}}},
    {"KHR_materials_iridescence.iridescenceFactor", "told", is_told,
     &(const example){
         .says = {.material =
                      ",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':0.5}}"},
         .words = "iridescence is left out"}},
    {"KHR_materials_iridescence.iridescenceTexture", "told", is_told,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':0.5,"
                              "'iridescenceTexture':{'index':0}}}"},
         .words = "iridescence is left out"}},
    {"KHR_materials_iridescence.iridescenceIor", "told", is_told,
     &(const example){.says = {.material = ",'extensions':{'KHR_materials_iridescence':{'"
                                           "iridescenceFactor':0.5,'iridescenceIor':2}}"},
                      .words = "iridescence is left out"}},
    {"KHR_materials_iridescence.iridescenceThicknessMinimum", "told", is_told,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':0.5,"
                              "'iridescenceThicknessMinimum':9}}"},
         .words = "iridescence is left out"}},
    {"KHR_materials_iridescence.iridescenceThicknessMaximum", "told", is_told,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':0.5,"
                              "'iridescenceThicknessMaximum':9}}"},
         .words = "iridescence is left out"}},
    {"KHR_materials_iridescence.iridescenceThicknessTexture", "told", is_told,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_iridescence':{'iridescenceFactor':0.5,"
                              "'iridescenceThicknessTexture':{'index':0}}}"},
         .words = "iridescence is left out"}},
    {"KHR_materials_pbrSpecularGlossiness.diffuseFactor", "told", is_told,
     &(const example){.says = {.material = ",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'"
                                           "diffuseFactor':[0,1,0,1]}}"},
                      .words = "specular and glossiness are made into"}},
    {"KHR_materials_pbrSpecularGlossiness.diffuseTexture", "told", is_told,
     &(const example){.says = {.material = ",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'"
                                           "diffuseTexture':{'index':0}}}"},
                      .words = "specular and glossiness are made into"}},
    {"KHR_materials_pbrSpecularGlossiness.specularFactor", "told", is_told,
     &(const example){.says = {.material = ",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'"
                                           "specularFactor':[0,1,0]}}"},
                      .words = "specular and glossiness are made into"}},
    {"KHR_materials_pbrSpecularGlossiness.glossinessFactor", "told", is_told,
     &(const example){
         .says =
             {.material =
                  ",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'glossinessFactor':0.5}}"},
         .words = "specular and glossiness are made into"}},
    {"KHR_materials_pbrSpecularGlossiness.specularGlossinessTexture", "told", is_told,
     &(const example){.says = {.material = ",'extensions':{'KHR_materials_pbrSpecularGlossiness':{'"
                                           "specularGlossinessTexture':{'index':0}}}"},
                      .words =
                          "textures of thickness, and of specular and glossiness, are not read"}},
    {"KHR_materials_sheen.sheenColorFactor", "used", changes,
     &(const example){
         .says = {.material =
                      ",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0]}}"}}},
    {"KHR_materials_sheen.sheenColorTexture", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0],'"
                              "sheenColorTexture':{'index':0}}}"},
         .other = {.material =
                       ",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0]}}"}}},
    {"KHR_materials_sheen.sheenRoughnessFactor", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0],'"
                              "sheenRoughnessFactor':0.5}}"},
         .other = {.material =
                       ",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0]}}"}}},
    {"KHR_materials_sheen.sheenRoughnessTexture", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0],'"
                              "sheenRoughnessTexture':{'index':0}}}"},
         .other = {.material =
                       ",'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,0,0]}}"}}},
    {"KHR_materials_specular.specularFactor", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_specular':{'specularFactor':0.5}}"}}},
    {"KHR_materials_specular.specularTexture", "used", changes,
     &(const example){
         .says = {.material =
                      ",'extensions':{'KHR_materials_specular':{'specularTexture':{'index':0}}}"}}},
    {"KHR_materials_specular.specularColorFactor", "used", changes,
     &(const example){
         .says = {.material =
                      ",'extensions':{'KHR_materials_specular':{'specularColorFactor':[5,5,5]}}"}}},
    {"KHR_materials_specular.specularColorTexture", "used", changes,
     &(const example){.says = {.material = ",'extensions':{'KHR_materials_specular':{'"
                                           "specularColorTexture':{'index':0}}}"}}},
    {"KHR_materials_transmission.transmissionFactor", "used", changes,
     &(const example){
         .says = {.material =
                      ",'extensions':{'KHR_materials_transmission':{'transmissionFactor':0.5}}"}}},
    {"KHR_materials_transmission.transmissionTexture", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_transmission':{'transmissionFactor':0."
                              "5,'transmissionTexture':{'index':0}}}"},
         .other = {.material =
                       ",'extensions':{'KHR_materials_transmission':{'transmissionFactor':0.5}}"}}},
    {"KHR_materials_unlit", "used", changes,
     &(const example){.says = {.material = ",'extensions':{'KHR_materials_unlit':{}}"}}},
    {"KHR_materials_unlit with COLOR_0", "used", changes,
     &(const example){.says = {.attributes = ",'COLOR_0':3",
                               .material = ",'extensions':{'KHR_materials_unlit':{}}"},
                      .other = {.material = ",'extensions':{'KHR_materials_unlit':{}}"}}},
    {"KHR_materials_variants", "told", variants, NULL},
    {"KHR_materials_volume.thicknessFactor", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_volume':{'thicknessFactor':0.5}}"}}},
    {"KHR_materials_volume.thicknessTexture", "told", is_told,
     &(const example){.says = {.material = ",'extensions':{'KHR_materials_volume':{'"
                                           "thicknessFactor':0.5,'thicknessTexture':{'index':0}}}"},
                      .words = "textures of thickness"}},
    {"KHR_materials_volume.attenuationDistance", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_volume':{'thicknessFactor':0.5,'"
                              "attenuationColor':[1,0.5,0],'attenuationDistance':2}}"},
         .other = {.material = ",'extensions':{'KHR_materials_volume':{'thicknessFactor':0.5,'"
                               "attenuationColor':[1,0.5,0]}}"}}},
    {"KHR_materials_volume.attenuationColor", "used", changes,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_volume':{'thicknessFactor':0.5,'"
                              "attenuationColor':[1,0.5,0],'attenuationDistance':2}}"},
         .other = {.material = ",'extensions':{'KHR_materials_volume':{'thicknessFactor':0.5,'"
                               "attenuationDistance':2}}"}}},
    {"KHR_lights_punctual point", "used", changes,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                          "extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}"}}},
    {"KHR_lights_punctual spot", "used", changes,
     &(const example){
         .says = {.more =
                      ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                      "extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{}}]}}"},
         .other = {.more = ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],"
                           "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}"}}},
    {"KHR_lights_punctual directional", "used", changes,
     &(const example){
         .says = {.more =
                      ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                      "extensions':{'KHR_lights_punctual':{'lights':[{'type':'directional'}]}}"},
         .other = {.more = ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],"
                           "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}"}}},
    {"KHR_lights_punctual other types", "told", is_told,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                          "extensions':{'KHR_lights_punctual':{'lights':[{'type':'area'}]}}"},
         .words = "1 light is left out: no such type"}},
    {"KHR_lights_punctual.color", "used", changes,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                          "extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','color':["
                          "1,0,0]}]}}"},
         .other = {.more = ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],"
                           "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}"}}},
    {"KHR_lights_punctual.intensity", "used", changes,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                          "extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','"
                          "intensity':5}]}}"},
         .other = {.more = ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],"
                           "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}"}}},
    {"KHR_lights_punctual.range", "ignored", changes_nothing,
     &(const example){
         .says =
             {.more =
                  ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                  "extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','range':5}]}}"},
         .other = {.more = ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],"
                           "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}"}}},
    {"KHR_lights_punctual.spot.innerConeAngle", "used", changes,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                          "extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{'"
                          "innerConeAngle':0.5}}]}}"},
         .other =
             {.more =
                  ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                  "extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{}}]}}"}}},
    {"KHR_lights_punctual.spot.outerConeAngle", "used", changes,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                          "extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{'"
                          "outerConeAngle':0.5}}]}}"},
         .other =
             {.more =
                  ",'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'"
                  "extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{}}]}}"}}},
    {"KHR_mesh_quantization", "used", changes,
     &(const example){
         .says =
             {.more =
                  ",'meshes':[{'primitives':[{'attributes':{'POSITION':39}}]}],'extensionsUsed':['"
                  "KHR_mesh_quantization'],'extensionsRequired':['KHR_mesh_quantization']"}}},
    {"KHR_node_visibility.visible", "used", changes,
     &(const example){
         .says = {.more = ",'nodes':[{'mesh':0},{'mesh':0,'extensions':{'KHR_node_visibility':{'"
                          "visible':false}}}],'scenes':[{'nodes':[0,1]}]"},
         .other = {.more = ",'nodes':[{'mesh':0},{'mesh':0}],'scenes':[{'nodes':[0,1]}]"}}},
    {"KHR_texture_basisu", "told", is_told,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'textures':[{'extensions':{'KHR_texture_basisu':{'source':0}}}]"},
         .words = "textures that are in KTX2 alone are not read"}},
    {"KHR_texture_transform.offset", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':"
                              "{'KHR_texture_transform':{'offset':[0.5,0]}}}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions'"
                               ":{'KHR_texture_transform':{}}}}"}}},
    {"KHR_texture_transform.rotation", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':"
                              "{'KHR_texture_transform':{'rotation':1}}}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions'"
                               ":{'KHR_texture_transform':{}}}}"}}},
    {"KHR_texture_transform.scale", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':"
                              "{'KHR_texture_transform':{'scale':[2,2]}}}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions'"
                               ":{'KHR_texture_transform':{}}}}"}}},
    {"KHR_texture_transform.texCoord", "used", changes,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':"
                              "{'KHR_texture_transform':{'texCoord':1}}}}"},
         .other = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions'"
                               ":{'KHR_texture_transform':{}}}}"}}},
    {"KHR_xmp_json_ld", "ignored", changes_nothing,
     &(const example){.says = {.more = ",'extensionsUsed':['KHR_xmp_json_ld'],'extensions':{'KHR_"
                                       "xmp_json_ld':{'packets':[{}]}}"}}},
    {"EXT_mesh_gpu_instancing TRANSLATION", "used", changes,
     &(const example){.says = {.more = ",'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing'"
                                       ":{'attributes':{'TRANSLATION':12}}}}]"}}},
    {"EXT_mesh_gpu_instancing ROTATION", "used", changes,
     &(const example){.says = {.more = ",'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing'"
                                       ":{'attributes':{'ROTATION':13}}}}]"}}},
    {"EXT_mesh_gpu_instancing SCALE", "used", changes,
     &(const example){.says = {.more = ",'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing'"
                                       ":{'attributes':{'SCALE':14}}}}]"}}},
    {"EXT_mesh_gpu_instancing _X", "ignored", changes_nothing,
     &(const example){.says = {.more = ",'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing'"
                                       ":{'attributes':{'TRANSLATION':12,'_ID':15}}}}]"},
                      .other = {.more = ",'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_"
                                        "instancing':{'attributes':{'TRANSLATION':12}}}}]"}}},
    {"EXT_meshopt_compression", "used", meshopt, NULL},
    {"EXT_texture_webp", "used", picture,
     &(const example){
         .says =
             {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
              .more =
                  ",'textures':[{'extensions':{'EXT_texture_webp':{'source':0}}}],'images':[{'uri':"
                  "'data:image/webp;base64,UklGRhoAAABXRUJQVlA4TA0AAAAvAAAAEAcQERGIiP4HAA=='}]"}}},
    {"EXT_texture_avif", "told", is_told,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'extensionsUsed':['EXT_texture_avif'],'textures':[{'extensions':{'EXT_"
                          "texture_avif':{'source':0}}}]"},
         .words = "the extension EXT_texture_avif of 1 texture is not known here"}},
    {"MSFT_texture_dds", "told", is_told,
     &(const example){
         .says = {.material = ",'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}",
                  .more = ",'extensionsUsed':['MSFT_texture_dds'],'textures':[{'extensions':{'MSFT_"
                          "texture_dds':{'source':0}}}]"},
         .words = "the extension MSFT_texture_dds of 1 texture is not known here"}},
    {"EXT_lights_image_based", "told", is_told,
     &(const example){.says = {.more = ",'extensionsUsed':['EXT_lights_image_based'],'scenes':[{'"
                                       "nodes':[0],'extensions':{'EXT_lights_image_based':{}}}]"},
                      .words =
                          "the extension EXT_lights_image_based of 1 scene is not known here"}},
    {"EXT_lights_ies", "told", is_told,
     &(const example){.says = {.more = ",'extensionsUsed':['EXT_lights_ies'],'nodes':[{'mesh':0,'"
                                       "extensions':{'EXT_lights_ies':{}}}]"},
                      .words = "the extension EXT_lights_ies of 1 node is not known here"}},
    {"MSFT_lod", "told", is_told,
     &(const example){.says = {.more = ",'extensionsUsed':['MSFT_lod'],'nodes':[{'mesh':0,'"
                                       "extensions':{'MSFT_lod':{}}}]"},
                      .words = "the extension MSFT_lod of 1 node is not known here"}},
    {"MSFT_packing_normalRoughnessMetallic", "told", is_told,
     &(const example){
         .says = {.material = ",'extensions':{'MSFT_packing_normalRoughnessMetallic':{}}",
                  .more = ",'extensionsUsed':['MSFT_packing_normalRoughnessMetallic']"},
         .words =
             "the extension MSFT_packing_normalRoughnessMetallic of 1 material is not known here"}},
    {"MSFT_packing_occlusionRoughnessMetallic", "told", is_told,
     &(const example){
         .says = {.material = ",'extensions':{'MSFT_packing_occlusionRoughnessMetallic':{}}",
                  .more = ",'extensionsUsed':['MSFT_packing_occlusionRoughnessMetallic']"},
         .words = "the extension MSFT_packing_occlusionRoughnessMetallic of 1 material is not "
                  "known here"}},
    {"NV_materials_mdl", "told", is_told,
     &(const example){.says = {.material = ",'extensions':{'NV_materials_mdl':{}}",
                               .more = ",'extensionsUsed':['NV_materials_mdl']"},
                      .words = "the extension NV_materials_mdl of 1 material is not known here"}},
    {"ADOBE_materials_clearcoat_specular", "told", is_told,
     &(const example){
         .says = {.material = ",'extensions':{'ADOBE_materials_clearcoat_specular':{}}",
                  .more = ",'extensionsUsed':['ADOBE_materials_clearcoat_specular']"},
         .words =
             "the extension ADOBE_materials_clearcoat_specular of 1 material is not known here"}},
    {"KHR_materials_subsurface", "told", is_told,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_subsurface':{}}",
                  .more = ",'extensionsUsed':['KHR_materials_subsurface']"},
         .words = "the extension KHR_materials_subsurface of 1 material is not known here"}},
    {"KHR_materials_volume_scatter", "told", is_told,
     &(const example){
         .says = {.material = ",'extensions':{'KHR_materials_volume_scatter':{}}",
                  .more = ",'extensionsUsed':['KHR_materials_volume_scatter']"},
         .words = "the extension KHR_materials_volume_scatter of 1 material is not known here"}},
    {"KHR_gaussian_splatting", "told", is_told,
     &(const example){.says = {.primitive = ",'extensions':{'KHR_gaussian_splatting':{}}",
                               .more = ",'extensionsUsed':['KHR_gaussian_splatting']"},
                      .words = "the extension KHR_gaussian_splatting of 1 mesh is not known here"}},
    {"EXT_structural_metadata", "told", is_told,
     &(const example){.says = {.primitive = ",'extensions':{'EXT_structural_metadata':{}}",
                               .more = ",'extensionsUsed':['EXT_structural_metadata']"},
                      .words =
                          "the extension EXT_structural_metadata of 1 mesh is not known here"}},
    {"EXT_mesh_features", "told", is_told,
     &(const example){.says = {.primitive = ",'extensions':{'EXT_mesh_features':{}}",
                               .more = ",'extensionsUsed':['EXT_mesh_features']"},
                      .words = "the extension EXT_mesh_features of 1 mesh is not known here"}},
    {"CESIUM_primitive_outline", "told", is_told,
     &(const example){.says = {.primitive = ",'extensions':{'CESIUM_primitive_outline':{}}",
                               .more = ",'extensionsUsed':['CESIUM_primitive_outline']"},
                      .words =
                          "the extension CESIUM_primitive_outline of 1 mesh is not known here"}},
    {"KHR_audio_emitter", "told", is_told,
     &(const example){
         .says =
             {.more =
                  ",'extensionsUsed':['KHR_audio_emitter'],'extensions':{'KHR_audio_emitter':{}}"},
         .words = "the extension KHR_audio_emitter is not known here"}},
    {"KHR_interactivity", "told", is_told,
     &(const example){
         .says =
             {.more =
                  ",'extensionsUsed':['KHR_interactivity'],'extensions':{'KHR_interactivity':{}}"},
         .words = "the extension KHR_interactivity is not known here"}},
    {"KHR_physics_rigid_bodies", "told", is_told,
     &(const example){.says = {.more = ",'extensionsUsed':['KHR_physics_rigid_bodies'],'extensions'"
                                       ":{'KHR_physics_rigid_bodies':{}}"},
                      .words = "the extension KHR_physics_rigid_bodies is not known here"}},
    {"AGI_articulations", "told", is_told,
     &(const example){
         .says =
             {.more =
                  ",'extensionsUsed':['AGI_articulations'],'extensions':{'AGI_articulations':{}}"},
         .words = "the extension AGI_articulations is not known here"}},
};

static void the_table_of_gltf_is_what_the_reader_does(void **state)
{
    (void)state;
    lf_formats_walk("gltf.md", "glTF 2.0", gltf, sizeof gltf / sizeof *gltf);
}

static void the_table_of_extensions_is_what_the_reader_does(void **state)
{
    (void)state;
    lf_formats_walk("gltf.md", "Extensions", extensions, sizeof extensions / sizeof *extensions);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_table_of_gltf_is_what_the_reader_does),
        cmocka_unit_test(the_table_of_extensions_is_what_the_reader_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
