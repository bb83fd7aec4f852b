/* A glTF file of everything that animation pointers can name, and what one of its channels makes of
 * it. Read in the test's own process. */
#ifndef LF_TESTS_POINTED_H
#define LF_TESTS_POINTED_H

#include "tests/render/gltf_text.h"
#include "tests/scene_file.h"

#define BASE "/materials/0/pbrMetallicRoughness/baseColorFactor"

/* Three corners, one on each axis, and what two morph targets add: 1 along x, 1 along y. */
static const float corners[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                   along_x[9] = {1, 0, 0, 1, 0, 0, 1, 0, 0},
                   along_y[9] = {0, 1, 0, 0, 1, 0, 0, 1, 0};

/* gltf-everything-pointed-at has everything that the object model names once, at its default or at
 * a value that lets it show; nothing moves its textures. nodes[0] has a mesh, [1] a light, [2] and
 * [3] cameras, [4] a mesh that stays. This is the document and an animation: more, members behind a
 * comma each. */
static inline void put_document(char *out, size_t size, const char *more)
{
    const char *text = lf_test_scene_text("gltf-everything-pointed-at");
    const size_t n = strlen(text) - 2; /* without its braces */
    assert_true(n + strlen(more) < size);
    memcpy(out, text + 1, n);
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
