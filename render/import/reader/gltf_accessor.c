#include "render/import/reader/gltf_accessor.h"

#include <string.h>

#include "base/sandbox/reader.h"
#include "render/import/scene/mesh_import.h"

#define MOST_ELEMENTS (3 * (uint64_t)LF_MAX_TRIANGLES)
/* Zeros are not stored in the file, so their number must be limited. */
#define MOST_ZEROS ((uint64_t)1 << 22)
#define FEW_ZEROS 65536

static size_t size_of(lf_gltf_type type)
{
    switch (type) {
    case LF_GLTF_INT8:
    case LF_GLTF_UINT8:
        return 1;
    case LF_GLTF_INT16:
    case LF_GLTF_UINT16:
        return 2;
    case LF_GLTF_UINT32:
    case LF_GLTF_FLOAT:
        return 4;
    default:
        return 0;
    }
}

static unsigned components_of(const char *type)
{
    static const struct {
        const char *name;
        unsigned n;
    } shapes[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++)
        if (strcmp(type, shapes[i].name) == 0)
            return shapes[i].n;
    return 0;
}

/* count elements of `each` bytes in a view. *out_stride is how far they lie from each other. */
static lf_status find_elements(lf_gltf *gltf, const json_t *place, uint64_t accessor,
                               uint64_t count, size_t each, bool strided, const unsigned char **out,
                               size_t *out_stride, lf_error *err)
{
    lf_gltf_view view;
    uint64_t offset = lf_gltf_whole(place, "byteOffset", 0);
    lf_status status =
        lf_gltf_view_open(gltf, lf_gltf_whole(place, "bufferView", LF_GLTF_NONE), &view, err);
    if (status != LF_OK)
        return status;
    size_t stride = strided && view.stride > 0 ? view.stride : each;
    uint64_t end = offset + (count - 1) * (uint64_t)stride + each;
    if (stride < each)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "accessors[%llu] has elements of %zu bytes, but a stride of %zu bytes",
                            (unsigned long long)accessor, each, stride);
    if (end > view.size)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "cannot be read as a mesh: accessors[%llu] needs %llu bytes, but its "
                            "buffer view has %zu",
                            (unsigned long long)accessor, (unsigned long long)end, view.size);
    *out = view.data + offset;
    *out_stride = stride;
    return LF_OK;
}

static uint32_t whole_at(const unsigned char *at, lf_gltf_type type)
{
    uint16_t half;
    uint32_t word;
    switch (type) {
    case LF_GLTF_UINT8:
        return *at;
    case LF_GLTF_UINT16:
        memcpy(&half, at, sizeof half);
        return half;
    default:
        memcpy(&word, at, sizeof word);
        return word;
    }
}

static uint32_t sparse_place(const lf_gltf_accessor *a, size_t i)
{
    return whole_at(a->sparse_places + i * size_of(a->sparse_type), a->sparse_type);
}

static bool is_unsigned(lf_gltf_type type)
{
    return type == LF_GLTF_UINT8 || type == LF_GLTF_UINT16 || type == LF_GLTF_UINT32;
}

static lf_status check_places(const lf_gltf_accessor *a, uint64_t number, lf_error *err)
{
    for (size_t i = 0; i < a->n_sparse; i++)
        if (sparse_place(a, i) >= a->count ||
            (i > 0 && sparse_place(a, i) <= sparse_place(a, i - 1)))
            return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                                "accessors[%llu]: its sparse indices must ascend and be below %zu",
                                (unsigned long long)number, a->count);
    return LF_OK;
}

static lf_status open_sparse(lf_gltf *gltf, const json_t *sparse, uint64_t number,
                             lf_gltf_accessor *a, lf_error *err)
{
    const json_t *places = json_object_get(sparse, "indices"),
                 *values = json_object_get(sparse, "values");
    uint64_t count = lf_gltf_whole(sparse, "count", 0);
    size_t stride, each = a->components * size_of(a->type);
    a->sparse_type = (lf_gltf_type)lf_gltf_whole(places, "componentType", 0);
    if (count == 0 || count > a->count || !is_unsigned(a->sparse_type))
        return lf_error_set(
            err, LF_E_FORMAT, LF_HERE,
            "accessors[%llu]: invalid sparse elements; expected 1 to %zu with unsigned indices",
            (unsigned long long)number, a->count);
    lf_status status = find_elements(gltf, places, number, count, size_of(a->sparse_type), false,
                                     &a->sparse_places, &stride, err);
    if (status == LF_OK)
        status = find_elements(gltf, values, number, count, each, false, &a->sparse_values, &stride,
                               err);
    a->n_sparse = status == LF_OK ? (size_t)count : 0;
    return status == LF_OK ? check_places(a, number, err) : status;
}

static lf_status open_elements(lf_gltf *gltf, const json_t *json, uint64_t number,
                               lf_gltf_accessor *a, lf_error *err)
{
    const json_t *sparse = json_object_get(json, "sparse");
    size_t each = a->components * size_of(a->type);
    lf_status status = LF_OK;
    a->stride = each;
    if (json_object_get(json, "bufferView"))
        status = find_elements(gltf, json, number, a->count, each, true, &a->data, &a->stride, err);
    else if (a->count > MOST_ZEROS)
        return lf_error_set(
            err, LF_E_FORMAT, LF_HERE,
            "accessors[%llu] has %zu elements without a bufferView; expected at most %llu",
            (unsigned long long)number, a->count, (unsigned long long)MOST_ZEROS);
    return status == LF_OK && sparse ? open_sparse(gltf, sparse, number, a, err) : status;
}

lf_status lf_gltf_accessor_open(lf_gltf *gltf, uint64_t number, lf_gltf_accessor *out,
                                lf_error *err)
{
    const json_t *json = lf_gltf_element(gltf->json, "accessors", number);
    uint64_t count = lf_gltf_whole(json, "count", 0);
    lf_gltf_accessor a = {.components = components_of(lf_gltf_text(json, "type")),
                          .type = (lf_gltf_type)lf_gltf_whole(json, "componentType", 0),
                          .normalised = json_is_true(json_object_get(json, "normalized"))};
    if (!json)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "accessors[%llu] does not exist; the file has %zu",
                            (unsigned long long)number, lf_gltf_count(gltf->json, "accessors"));
    if (count == 0 || count > MOST_ELEMENTS)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "accessors[%llu] has %llu elements; expected 1 to %llu",
                            (unsigned long long)number, (unsigned long long)count,
                            (unsigned long long)MOST_ELEMENTS);
    if (a.components == 0 || size_of(a.type) == 0)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "accessors[%llu] has an unknown type or componentType",
                            (unsigned long long)number);
    a.count = (size_t)count;
    lf_status status = open_elements(gltf, json, number, &a, err);
    if (status == LF_OK)
        *out = a;
    return status;
}

bool lf_gltf_is_there(const lf_gltf_accessor *accessor)
{
    return accessor->data || accessor->count <= FEW_ZEROS;
}

/* ------------------------------------------------------------------------------- one element -- */

static float component_at(const unsigned char *at, lf_gltf_type type, bool normalised)
{
    int16_t half;
    float value;
    switch (type) {
    case LF_GLTF_INT8:
        value = (float)(int8_t)*at;
        return normalised ? (value < -127.0f ? -1.0f : value / 127.0f) : value;
    case LF_GLTF_INT16:
        memcpy(&half, at, sizeof half);
        value = (float)half;
        return normalised ? (value < -32767.0f ? -1.0f : value / 32767.0f) : value;
    case LF_GLTF_UINT8:
        return normalised ? (float)*at / 255.0f : (float)*at;
    case LF_GLTF_UINT16:
        value = (float)whole_at(at, type);
        return normalised ? value / 65535.0f : value;
    case LF_GLTF_UINT32:
        value = (float)whole_at(at, type);
        return normalised ? value / 4294967295.0f : value;
    default:
        memcpy(&value, at, sizeof value);
        return value;
    }
}

/* The sparse value that replaces an element; NULL: none. */
static const unsigned char *find_sparse(const lf_gltf_accessor *a, size_t element)
{
    size_t low = 0, high = a->n_sparse;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (sparse_place(a, middle) < element)
            low = middle + 1;
        else
            high = middle;
    }
    return low < a->n_sparse && sparse_place(a, low) == element
               ? a->sparse_values + low * a->components * size_of(a->type)
               : NULL;
}

/* NULL: it is zero. */
static const unsigned char *bytes_of(const lf_gltf_accessor *a, size_t element)
{
    const unsigned char *sparse = a->n_sparse > 0 ? find_sparse(a, element) : NULL;
    return sparse ? sparse : a->data ? a->data + element * a->stride : NULL;
}

void lf_gltf_floats(const lf_gltf_accessor *accessor, size_t element, unsigned n, float *out)
{
    const unsigned char *at = bytes_of(accessor, element);
    size_t each = size_of(accessor->type);
    if (n > accessor->components)
        n = accessor->components;
    if (!at)
        memset(out, 0, n * sizeof *out);
    else if (accessor->type == LF_GLTF_FLOAT)
        memcpy(out, at, n * sizeof *out);
    else
        for (unsigned i = 0; i < n; i++)
            out[i] = component_at(at + i * each, accessor->type, accessor->normalised);
}

uint32_t lf_gltf_integer(const lf_gltf_accessor *accessor, size_t element)
{
    const unsigned char *at = bytes_of(accessor, element);
    return at ? whole_at(at, accessor->type) : 0;
}
