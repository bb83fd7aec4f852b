/* The kinds of farm. */
#include <string.h>

#include "daemon/parts/farmed.h"

static const char *const engines[] = {"slurm", "parallel", "list", NULL};
enum { N_ENGINES = sizeof engines / sizeof *engines - 1 };

const char *lf_farmed_engine_at(int index)
{
    return index < N_ENGINES ? engines[index] : NULL;
}

lf_status lf_farmed_engines(const char *list, unsigned *out, lf_error *err)
{
    unsigned bits = 0;
    for (const char *at = list;; at++) {
        const size_t n = strcspn(at, ",");
        int i = 0;
        while (i < N_ENGINES && !(strlen(engines[i]) == n && strncmp(engines[i], at, n) == 0))
            i++;
        if (i == N_ENGINES)
            return lf_error_set(err, LF_E_ARG, "--farm",
                                "expects some of slurm, parallel and list, not \"%s\"", list);
        bits |= 1u << i;
        at += n;
        if (*at == '\0')
            break;
    }
    *out = bits;
    return LF_OK;
}
