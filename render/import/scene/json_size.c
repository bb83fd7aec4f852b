#include "render/import/scene/json_size.h"

#include <stdint.h>

/* "1.0" and "1e9": a text of two bytes is a whole number's. */
#define LEAST_REAL 3

static size_t digits_of(json_int_t value)
{
    size_t n = value < 0 ? 2 : 1;
    while (value /= 10)
        n++;
    return n;
}

/* Commas and brackets for this number of members. */
static size_t frame_of(size_t members)
{
    return members > 0 ? members + 1 : 2;
}

static size_t bytes_of_object(json_t *object)
{
    size_t bytes = frame_of(json_object_size(object));
    for (void *it = json_object_iter(object); it; it = json_object_iter_next(object, it))
        bytes += json_object_iter_key_len(it) + sizeof "\"\":" - 1 +
                 lf_json_least_bytes(json_object_iter_value(it));
    return bytes;
}

static size_t bytes_of_array(const json_t *array)
{
    size_t bytes = frame_of(json_array_size(array)), i;
    const json_t *item;
    json_array_foreach(array, i, item)
    {
        bytes += lf_json_least_bytes(item);
    }
    return bytes;
}

size_t lf_json_least_bytes(const json_t *value)
{
    if (!value)
        return 0;
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        return bytes_of_object((json_t *)(uintptr_t)value);
    case JSON_ARRAY:
        return bytes_of_array(value);
    case JSON_STRING:
        return json_string_length(value) + 2;
    case JSON_INTEGER:
        return digits_of(json_integer_value(value));
    case JSON_REAL:
        return LEAST_REAL;
    case JSON_TRUE:
    case JSON_NULL:
        return 4;
    case JSON_FALSE:
        break;
    }
    return 5;
}
