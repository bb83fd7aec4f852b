#include "base/array.h"

#include <stdio.h>
#include <string.h>

static const struct {
    const char *name;
    size_t bytes;
} types[] = {[LF_ARRAY_FLOAT32] = {"float32", 4},
             [LF_ARRAY_UINT32] = {"uint32", 4},
             [LF_ARRAY_UINT8] = {"uint8", 1}};

const char *lf_array_type_name(int index)
{
    return index < (int)(sizeof types / sizeof *types) ? types[index].name : NULL;
}

uint64_t lf_array_bytes(const lf_array *array)
{
    uint64_t n = types[array->type].bytes;
    for (int i = 0; i < array->n_axes; i++) {
        if (array->length[i] < 1 || (uint64_t)array->length[i] > (uint64_t)INT64_MAX / n)
            return 0;
        n *= (uint64_t)array->length[i];
    }
    return n;
}

bool lf_array_is(const lf_array *array, const lf_array *wanted)
{
    bool fits = array->type == wanted->type && array->n_axes == wanted->n_axes;
    for (int i = 0; i < wanted->n_axes && fits; i++)
        fits = wanted->length[i] == 0 || wanted->length[i] == array->length[i];
    return fits;
}

char *lf_array_text(const lf_array *array, char out[LF_ARRAY_TEXT])
{
    static const char *const letters[] = {"nz", "ny", "nx"};
    int used = snprintf(out, LF_ARRAY_TEXT, "%s values of shape [", types[array->type].name);
    for (int i = 0; i < array->n_axes; i++) {
        const char *next = i + 1 < array->n_axes ? ", " : "]";
        char *at = out + used;
        const size_t room = (size_t)(LF_ARRAY_TEXT - used);
        used += array->length[i] != 0
                    ? snprintf(at, room, "%lld%s", (long long)array->length[i], next)
                    : snprintf(at, room, "%s%s", array->n_axes == 3 ? letters[i] : "n", next);
    }
    return out;
}
