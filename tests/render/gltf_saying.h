/* Files that say one thing of glTF each, for tests of docs/reference/formats/gltf.md: what is used
 * changes the mesh, what says nothing of the picture changes nothing, without a word. Values are
 * the matter of test_gltf_read and test_gltf_material. */
#ifndef LF_TESTS_GLTF_SAYING_H
#define LF_TESTS_GLTF_SAYING_H

#include "tests/formats.h"
#include "tests/render/gltf_text.h"

/* Where in the file something is said, as members, each behind a comma: of a primitive's
 * attributes, of the primitive, of its mesh, its node, its material, of the document. */
#define ATTRIBUTES(words) "\1a" words
#define PRIMITIVE(words) "\1p" words
#define MESH(words) "\1t" words
#define NODE(words) "\1n" words
#define MATERIAL(words) "\1m" words
#define MORE(words) "\1d" words

/* An attribute of a primitive whose textures lack coordinates. */
#define BARE "'_BARE':2"

typedef struct example {
    const char *says, *other; /* what it is held against */
    const char *words;        /* of the warning or the error */
} example;

#define USED(name, says, other)                                                                    \
    {                                                                                              \
        name, "used", changes, &(const example)                                                    \
        {                                                                                          \
            says, other, NULL                                                                      \
        }                                                                                          \
    }
#define IGNORED(name, says, other)                                                                 \
    {                                                                                              \
        name, "ignored", changes_nothing, &(const example)                                         \
        {                                                                                          \
            says, other, NULL                                                                      \
        }                                                                                          \
    }
#define TOLD(name, says, words)                                                                    \
    {                                                                                              \
        name, "warned", is_told, &(const example)                                                  \
        {                                                                                          \
            says, "", words                                                                        \
        }                                                                                          \
    }
#define REFUSED(name, says, words)                                                                 \
    {                                                                                              \
        name, "refused", is_refused, &(const example)                                              \
        {                                                                                          \
            says, "", words                                                                        \
        }                                                                                          \
    }
/* By a check of its own. */
#define ROW(name, verdict, check, says, words)                                                     \
    {                                                                                              \
        name, verdict, check, &(const example)                                                     \
        {                                                                                          \
            says, "", words                                                                        \
        }                                                                                          \
    }

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
static inline void put(gltf_text *text, const void *data, size_t n, int type, int count,
                       const char *shape, const char *more)
{
    gltf_accessor(text, gltf_view(text, data, n, ""), type, count, shape, more);
}

/* 0 to 10: what vertices have, and indices. */
static inline void put_vertices(gltf_text *text)
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
static inline void put_movement(gltf_text *text)
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
static inline void put_ways(gltf_text *text)
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
static inline void put_types(gltf_text *text)
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

/* The part of a saying that belongs to one place of the file. */
static inline void part_of(const char *says, char place, char out[1024])
{
    out[0] = '\0';
    for (const char *at = strchr(says, '\1'); at; at = strchr(at + 1, '\1'))
        if (at[1] == place)
            snprintf(out + strlen(out), 1024 - strlen(out), "%.*s", (int)strcspn(at + 2, "\1"),
                     at + 2);
}

static inline lf_status read_saying(const char *says, lf_mesh_data *data, lf_error *err)
{
    enum { PLACES = 6 };
    gltf_text text = {0};
    char rest[8192], part[PLACES][1024];
    lf_mesh_desc desc = gltf_desc();
    desc.clip.seconds = 0.25;
    put_vertices(&text);
    put_movement(&text);
    put_ways(&text);
    put_types(&text);
    for (int i = 0; i < PLACES; i++)
        part_of(says, "naptmd"[i], part[i]);
    /* who says nothing of them has coordinates for its textures */
    if (strstr(part[4], "Texture'") && !strstr(part[1], "TEXCOORD_") && !strstr(part[1], BARE))
        strcat(part[1], ",'TEXCOORD_0':2,'TEXCOORD_1':2");
    int n = snprintf(
        rest, sizeof rest,
        "'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0%s}],'meshes':[{'primitives':[{'attributes':{"
        "'POSITION':0%s},'material':0%s}]%s}],'materials':[{'name':'m'%s}],"
        "'textures':[{'source':0,'sampler':0},{'source':1}],'samplers':[{}],"
        "'images':[{'uri':'" GLTF_PNG "'},{'uri':'" BLUE_PNG "'}]%s",
        part[0], part[1], part[2], part[3], part[4], part[5]);
    assert_true(n > 0 && (size_t)n < sizeof rest);
    *data = (lf_mesh_data){0};
    return gltf_read_as(&text, rest, &desc, data, err);
}

/* ---------------------------------------------------------------------------------- the mesh -- */

static inline void say_numbers(FILE *to, const char *name, const float *values, size_t n)
{
    fprintf(to, "%s", name);
    for (size_t i = 0; values && i < n; i++)
        fprintf(to, " %.9g", (double)values[i]);
    fputc('\n', to);
}

static inline void say_material(FILE *to, const lf_material *m, const lf_texture_set *set)
{
    const float words[] = {(float)m->cover, (float)m->is_solid, (float)(m->tint == LF_TINT_ALL)};
    say_numbers(to, m->kind->name, (const float *)&m->p, LF_PRINCIPLED_FLOATS);
    say_numbers(to, "", words, sizeof words / sizeof *words);
    for (int s = 0; set && s < LF_SLOTS; s++) {
        const lf_texture *t = &set->slot[s];
        fprintf(to, "%u %d %d %d %d %d ", t->picture, t->wrap_u, t->wrap_v, t->set, t->nearest,
                t->finest);
        say_numbers(to, "", t->map[0], 6);
        say_numbers(to, "", &t->scale, 1);
    }
}

/* All that a mesh is, as text. The caller frees it. */
static inline char *text_of(const lf_mesh_data *data)
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

static inline lf_mesh_data read_ok(const lf_format_row *row, const char *says)
{
    lf_mesh_data data;
    lf_error err = {0};
    if (read_saying(says, &data, &err) != LF_OK)
        fail_msg("%s: %s", row->name, err.what);
    return data;
}

/* ------------------------------------------------------------------------------------ checks -- */

/* Whether it makes another mesh than its other does; without a word that this has not. */
static inline void compare(const lf_format_row *row, bool other)
{
    const example *e = row->with;
    lf_mesh_data a = read_ok(row, e->says), b = read_ok(row, e->other);
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

static inline void changes(const lf_format_row *row)
{
    compare(row, true);
}

static inline void changes_nothing(const lf_format_row *row)
{
    compare(row, false);
}

static inline void is_told(const lf_format_row *row)
{
    const example *e = row->with;
    lf_mesh_data data = read_ok(row, e->says), plain = read_ok(row, "");
    assert_int_equal(plain.warnings.n, 0);
    if (!gltf_warns(&data, e->words))
        fail_msg("%s: no warning says \"%s\"; the first: %s", row->name, e->words,
                 lf_warnings_at(&data.warnings, 0));
    lf_mesh_data_finish(&data);
    lf_mesh_data_finish(&plain);
}

static inline void is_refused(const lf_format_row *row)
{
    const example *e = row->with;
    lf_mesh_data data;
    lf_error err = {0};
    if (read_saying(e->says, &data, &err) == LF_OK)
        fail_msg("%s: it is read", row->name);
    if (!strstr(err.what, e->words))
        fail_msg("%s: \"%s\" does not say \"%s\"", row->name, err.what, e->words);
    lf_mesh_data_finish(&data);
}

/* Used: a wrong one is seen. */
static inline void refused_as_used(const lf_format_row *row)
{
    is_refused(row);
}

/* A picture of one pixel that is not the document's own two. */
static inline void picture(const lf_format_row *row)
{
    const example *e = row->with;
    lf_mesh_data data = read_ok(row, e->says);
    assert_int_equal(data.warnings.n, 0);
    assert_int_equal(data.n_pictures, 1);
    assert_true(data.pictures[0].width == 1 && data.pictures[0].height == 1);
    lf_mesh_data_finish(&data);
}

#endif
