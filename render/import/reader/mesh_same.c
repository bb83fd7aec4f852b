/* Vertices that differ only in attributes. */
#define XXH_INLINE_ALL
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/mesh_build.h"

lf_status lf_mesh_find_same(const lf_mesh_data *data, size_t first, size_t n, uint32_t *same,
                            lf_error *err)
{
    size_t size = 16;
    while (size < 2 * n)
        size *= 2;
    uint32_t *table = lf_calloc(size, sizeof *table); /* 1 + a vertex */
    if (!table)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (size_t v = first; v < first + n; v++) {
        const double *p = data->positions + 3 * v,
                     key[3] = {p[0] + 0.0, p[1] + 0.0, p[2] + 0.0}; /* -0 is 0 */
        size_t at = (size_t)XXH3_64bits(key, sizeof key) & (size - 1);
        for (; table[at] != 0; at = (at + 1) & (size - 1)) {
            const double *q = data->positions + 3 * (size_t)(table[at] - 1);
            if (p[0] == q[0] && p[1] == q[1] && p[2] == q[2])
                break;
        }
        if (table[at] == 0)
            table[at] = (uint32_t)v + 1;
        same[v] = table[at] - 1;
    }
    lf_free(table);
    return LF_OK;
}
