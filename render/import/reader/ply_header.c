#include "render/import/reader/ply_header.h"

#include <stdio.h>
#include <string.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/words.h"

const unsigned char lf_ply_sizes[LF_PLY_TYPES] = {1, 1, 2, 2, 4, 4, 4, 8};

typedef struct named {
    const char *name;
    int value;
} named;

static const named types[] = {{"char", LF_PLY_INT8},
                              {"int8", LF_PLY_INT8},
                              {"uchar", LF_PLY_UINT8},
                              {"uint8", LF_PLY_UINT8},
                              {"short", LF_PLY_INT16},
                              {"int16", LF_PLY_INT16},
                              {"ushort", LF_PLY_UINT16},
                              {"uint16", LF_PLY_UINT16},
                              {"int", LF_PLY_INT32},
                              {"int32", LF_PLY_INT32},
                              {"uint", LF_PLY_UINT32},
                              {"uint32", LF_PLY_UINT32},
                              {"float", LF_PLY_FLOAT},
                              {"float32", LF_PLY_FLOAT},
                              {"double", LF_PLY_DOUBLE},
                              {"float64", LF_PLY_DOUBLE},
                              {NULL, 0}};

static const named encodings[] = {{"ascii", LF_PLY_TEXT},
                                  {"binary_little_endian", LF_PLY_LITTLE},
                                  {"binary_big_endian", LF_PLY_BIG},
                                  {NULL, 0}};

static const named kinds[] = {{"vertex", LF_PLY_VERTEX},
                              {"face", LF_PLY_FACE},
                              {"tristrips", LF_PLY_STRIPS},
                              {"material", LF_PLY_MATERIAL},
                              {NULL, 0}};

static const named vertex_roles[] = {{"x", LF_PLY_X},
                                     {"y", LF_PLY_Y},
                                     {"z", LF_PLY_Z},
                                     {"nx", LF_PLY_NX},
                                     {"ny", LF_PLY_NY},
                                     {"nz", LF_PLY_NZ},
                                     {"red", LF_PLY_RED},
                                     {"green", LF_PLY_GREEN},
                                     {"blue", LF_PLY_BLUE},
                                     {"alpha", LF_PLY_ALPHA},
                                     {"r", LF_PLY_RED},
                                     {"g", LF_PLY_GREEN},
                                     {"b", LF_PLY_BLUE},
                                     {"a", LF_PLY_ALPHA},
                                     {"diffuse_red", LF_PLY_RED},
                                     {"diffuse_green", LF_PLY_GREEN},
                                     {"diffuse_blue", LF_PLY_BLUE},
                                     {"s", LF_PLY_U},
                                     {"t", LF_PLY_V},
                                     {"u", LF_PLY_U},
                                     {"v", LF_PLY_V},
                                     {"texture_u", LF_PLY_U},
                                     {"texture_v", LF_PLY_V},
                                     {NULL, 0}};

static const named face_roles[] = {{"vertex_indices", LF_PLY_INDICES},
                                   {"vertex_index", LF_PLY_INDICES},
                                   {"texcoord", LF_PLY_UVS},
                                   {"material_index", LF_PLY_MATERIAL_INDEX},
                                   {"texnumber", LF_PLY_TEXTURE_INDEX},
                                   {NULL, 0}};

static const named material_roles[] = {
    {"diffuse_red", LF_PLY_DIFFUSE_RED},       {"diffuse_green", LF_PLY_DIFFUSE_GREEN},
    {"diffuse_blue", LF_PLY_DIFFUSE_BLUE},     {"specular_red", LF_PLY_SPECULAR_RED},
    {"specular_green", LF_PLY_SPECULAR_GREEN}, {"specular_blue", LF_PLY_SPECULAR_BLUE},
    {"specular_power", LF_PLY_SPECULAR_POWER}, {NULL, 0}};

static const named *const roles[] = {[LF_PLY_VERTEX] = vertex_roles,
                                     [LF_PLY_FACE] = face_roles,
                                     [LF_PLY_STRIPS] = face_roles,
                                     [LF_PLY_MATERIAL] = material_roles};

/* The value of a name, or none_value. */
static int value_of(const named *list, const char *word, size_t n, int none_value)
{
    for (; list && list->name; list++)
        if (lf_word_is(word, n, list->name))
            return list->value;
    return none_value;
}

static lf_status bad_line(const lf_input *in, const char *what, lf_error *err)
{
    return lf_error_set(err, LF_E_FORMAT, LF_HERE, "line %lld of the PLY header: %s",
                        (long long)in->line, what);
}

static lf_status read_format(const lf_input *in, const char *at, lf_ply_header *out, lf_error *err)
{
    size_t n;
    const char *word = lf_word(&at, &n);
    int encoding = value_of(encodings, word, n, -1);
    if (encoding < 0)
        return bad_line(in, "expected ascii, binary_little_endian or binary_big_endian", err);
    out->encoding = (lf_ply_encoding)encoding;
    return LF_OK;
}

static lf_status read_element(const lf_input *in, const char *at, lf_ply_header *out, lf_error *err)
{
    size_t n;
    int64_t count;
    const char *word = lf_word(&at, &n);
    if (n == 0 || !lf_integer(&at, &count) || count < 0)
        return bad_line(in, "expected the name and the number of an element", err);
    if (out->n_elements == LF_PLY_MAX_ELEMENTS)
        return bad_line(in, "too many elements; expected at most 64", err);
    int kind = value_of(kinds, word, n, LF_PLY_OTHER);
    if (kind == LF_PLY_OTHER && count > 0)
        lf_leave_out(&out->elements_left, word, n);
    out->elements[out->n_elements++] = (lf_ply_element){
        .kind = (lf_ply_kind)kind, .count = (uint64_t)count, .first = out->n_properties};
    return LF_OK;
}

/* Properties of measuring or editing, which are not visible; for materials, ambient light. */
static bool is_quiet(const char *word, size_t n)
{
    static const char *const names[] = {"confidence",    "intensity",    "quality",
                                        "flags",         "curvature",    "ambient_red",
                                        "ambient_green", "ambient_blue", "ambient_power"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (lf_word_is(word, n, names[i]))
            return true;
    return false;
}

/* A property without a role; reported for elements with a role. */
static void leave_property(const lf_ply_element *element, const char *word, size_t n,
                           lf_ply_header *out)
{
    static const char *const of[] = {[LF_PLY_VERTEX] = "vertex",
                                     [LF_PLY_FACE] = "face",
                                     [LF_PLY_STRIPS] = "tristrips",
                                     [LF_PLY_MATERIAL] = "material"};
    char name[64];
    if (element->kind == LF_PLY_OTHER || element->count == 0 || is_quiet(word, n))
        return;
    int length =
        snprintf(name, sizeof name, "%.*s of %s", (int)(n < 24 ? n : 24), word, of[element->kind]);
    lf_leave_out(&out->properties_left, name, (size_t)length);
}

static lf_status read_property(const lf_input *in, const char *at, lf_ply_header *out,
                               lf_error *err)
{
    size_t n;
    lf_ply_property p = {0};
    const char *word = lf_word(&at, &n);
    int type;
    if (out->n_elements == 0)
        return bad_line(in, "a property before the first element", err);
    if (out->n_properties == LF_PLY_MAX_PROPERTIES)
        return bad_line(in, "too many properties; expected at most 256", err);
    p.is_list = lf_word_is(word, n, "list");
    if (p.is_list) {
        word = lf_word(&at, &n);
        type = value_of(types, word, n, -1);
        if (type < 0 || type >= LF_PLY_FLOAT)
            return bad_line(in, "expected an integer type for the length of a list", err);
        p.count_type = (lf_ply_type)type;
        word = lf_word(&at, &n);
    }
    type = value_of(types, word, n, -1);
    word = lf_word(&at, &n);
    if (type < 0 || n == 0)
        return bad_line(in, "expected a type, such as float or uchar, and a name", err);
    p.type = (lf_ply_type)type;
    lf_ply_element *element = &out->elements[out->n_elements - 1];
    p.role = (lf_ply_role)value_of(
        (size_t)element->kind < sizeof roles / sizeof *roles ? roles[element->kind] : NULL, word, n,
        LF_PLY_UNUSED);
    if (p.is_list != (p.role == LF_PLY_INDICES || p.role == LF_PLY_UVS))
        p.role = LF_PLY_UNUSED;
    if (p.role == LF_PLY_UNUSED)
        leave_property(element, word, n, out);
    out->properties[out->n_properties++] = p;
    element->n_properties++;
    return LF_OK;
}

/* Bytes that an element takes at the least: a digit and a separator for each in text. */
static uint64_t least_size(const lf_ply_header *header, const lf_ply_element *element)
{
    uint64_t size = 0;
    for (int i = 0; i < element->n_properties; i++) {
        const lf_ply_property *p = &header->properties[element->first + i];
        size += header->encoding == LF_PLY_TEXT ? 2
                : p->is_list                    ? lf_ply_sizes[p->count_type]
                                                : lf_ply_sizes[p->type];
    }
    return size;
}

/* The last separator of a text may be missing. */
static lf_status check_promise(const lf_input *in, const lf_ply_header *header, lf_error *err)
{
    uint64_t promised = 0;
    for (int i = 0; i < header->n_elements; i++) {
        uint64_t size;
        if (__builtin_mul_overflow(header->elements[i].count,
                                   least_size(header, &header->elements[i]), &size) ||
            __builtin_add_overflow(promised, size, &promised))
            promised = UINT64_MAX;
        if (promised > in->size + 1)
            return lf_error_set(
                err, LF_E_FORMAT, LF_HERE,
                "the header announces at least %llu bytes of elements, but the file has %llu",
                (unsigned long long)promised, (unsigned long long)in->size);
    }
    return LF_OK;
}

static void read_comment(const char *at, lf_ply_header *out)
{
    size_t n;
    const char *word = lf_word(&at, &n), *name = lf_skip_blanks(at);
    size_t length = strlen(name);
    while (length > 0 && lf_is_blank(name[length - 1]))
        length--;
    if (!lf_word_is(word, n, "TextureFile") || length == 0 || length >= LF_PLY_MAX_NAME)
        return;
    if (out->n_textures < LF_PLY_MAX_TEXTURES)
        memcpy(out->textures[out->n_textures], name, length);
    out->n_textures += out->n_textures < LF_PLY_MAX_PROPERTIES;
}

/* One line; *ended: it was the last one. */
static lf_status read_line(const lf_input *in, const char *line, lf_ply_header *out, bool *ended,
                           lf_error *err)
{
    size_t n;
    const char *word = lf_word(&line, &n);
    *ended = lf_word_is(word, n, "end_header");
    if (lf_word_is(word, n, "format"))
        return read_format(in, line, out, err);
    if (lf_word_is(word, n, "element"))
        return read_element(in, line, out, err);
    if (lf_word_is(word, n, "property"))
        return read_property(in, line, out, err);
    if (lf_word_is(word, n, "comment"))
        read_comment(line, out);
    return LF_OK; /* comments, also those that some programs write without that word */
}

lf_status lf_ply_read_header(lf_input *in, lf_ply_header *out, lf_error *err)
{
    char *line = lf_input_line(in, false);
    bool ended = false;
    lf_status status = LF_OK;
    *out = (lf_ply_header){0};
    if (!line || strcmp(lf_rest(line), "ply") != 0)
        return lf_error_set(
            err, LF_E_FORMAT, LF_HERE,
            "cannot be read as a mesh: not a PLY file, because its first line is not \"ply\"");
    while (status == LF_OK && !ended) {
        line = lf_input_line(in, false);
        if (!line)
            return lf_input_ended(in, "the rest of the PLY header", err);
        status = read_line(in, line, out, &ended, err);
    }
    return status == LF_OK ? check_promise(in, out, err) : status;
}
