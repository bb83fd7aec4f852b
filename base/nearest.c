#include "base/nearest.h"

#include <stddef.h>
#include <string.h>

/* Optimal string alignment distance, up to 63 bytes per word: swapped neighbours count once, like a
 * typing error. */
static int edit_distance(const char *a, const char *b)
{
    size_t na = strlen(a), nb = strlen(b);
    if (na > 63 || nb > 63)
        return 64;
    int row[3][64] = {{0}};
    for (size_t j = 0; j <= nb; j++)
        row[0][j] = (int)j;
    for (size_t i = 1; i <= na; i++) {
        int *now = row[i % 3], *last = row[(i + 2) % 3], *before = row[(i + 1) % 3];
        now[0] = (int)i;
        for (size_t j = 1; j <= nb; j++) {
            int best = last[j - 1] + (a[i - 1] != b[j - 1]);
            best = last[j] + 1 < best ? last[j] + 1 : best;
            best = now[j - 1] + 1 < best ? now[j - 1] + 1 : best;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] &&
                before[j - 2] + 1 < best)
                best = before[j - 2] + 1;
            now[j] = best;
        }
    }
    return row[na % 3][nb];
}

const char *lf_nearest_name(const char *word, const char *const names[])
{
    const char *nearest = NULL;
    int best = 1 + (int)(strlen(word) < 63 ? strlen(word) : 63) / 3;
    for (; *names; names++) {
        int distance = edit_distance(word, *names);
        if (distance <= best && distance < (int)strlen(*names) && (!nearest || distance < best)) {
            nearest = *names;
            best = distance;
        }
    }
    return nearest;
}

lf_status lf_nearest_refuse(const char *word, const char *what, const char *const names[],
                            lf_error *err)
{
    const char *meant = lf_nearest_name(word, names);
    return meant ? lf_error_set(err, LF_E_ARG, word, "unknown %s; did you mean %s?", what, meant)
                 : lf_error_set(err, LF_E_ARG, word, "unknown %s; see --help", what);
}
