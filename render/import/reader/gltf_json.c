#include "render/import/reader/gltf_json.h"

#include <math.h>
#include <string.h>

uint64_t lf_gltf_whole(const json_t *object, const char *key, uint64_t unsaid)
{
    const json_t *value = json_object_get(object, key);
    if (!json_is_number(value))
        return unsaid;
    double number = json_number_value(value);
    if (number != floor(number) || number < 0)
        return LF_GLTF_NONE;
    return number < 0x1p53 ? (uint64_t)number : UINT64_C(1) << 53;
}

uint32_t lf_gltf_index(const json_t *object, const char *key)
{
    uint64_t number = lf_gltf_whole(object, key, LF_GLTF_NONE);
    return number < LF_GLTF_NONE ? (uint32_t)number : LF_GLTF_NONE;
}

float lf_gltf_number(const json_t *object, const char *key, float unsaid)
{
    const json_t *value = json_object_get(object, key);
    float number = json_is_number(value) ? (float)json_number_value(value) : unsaid;
    return isfinite(number) ? number : unsaid;
}

bool lf_gltf_numbers(const json_t *object, const char *key, size_t n, double *out)
{
    const json_t *array = json_object_get(object, key);
    if (json_array_size(array) != n)
        return false;
    for (size_t i = 0; i < n; i++)
        if (!json_is_number(json_array_get(array, i)))
            return false;
    for (size_t i = 0; i < n; i++)
        out[i] = json_number_value(json_array_get(array, i));
    return true;
}

const char *lf_gltf_text(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

const json_t *lf_gltf_extension(const json_t *object, const char *name)
{
    const json_t *extension = json_object_get(json_object_get(object, "extensions"), name);
    return json_is_object(extension) ? extension : NULL;
}

const json_t *lf_gltf_element(const json_t *document, const char *array, uint64_t number)
{
    const json_t *elements = json_object_get(document, array);
    return number < json_array_size(elements) ? json_array_get(elements, (size_t)number) : NULL;
}

size_t lf_gltf_count(const json_t *document, const char *array)
{
    return json_array_size(json_object_get(document, array));
}

void lf_gltf_line(const char *text, char *out, size_t size)
{
    size_t n = strlen(text);
    if (n >= size)
        for (n = size - 1; n > 0 && ((unsigned char)text[n] & 0xc0) == 0x80; n--)
            continue;
    for (size_t i = 0; i < n; i++)
        out[i] = (unsigned char)text[i] < ' ' || text[i] == 0x7f ? '?' : text[i];
    out[n] = '\0';
}
