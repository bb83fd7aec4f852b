#include "daemon/web/allow.h"

#include <string.h>

static const struct allowed {
    const char *method;
    const char *without[5]; /* parameters that are not allowed */
} table[] = {
    {.method = "hello"},
    {.method = "status"},
    {.method = "scene.load", .without = {"arrays", "scene_fd"}},
    {.method = "scene.get"},
    {.method = "scene.patch", .without = {"arrays"}},
    {.method = "camera.set"},
    {.method = "camera.orbit"},
    {.method = "camera.fit"},
    {.method = "time.set"},
    {.method = "time.play"},
    {.method = "time.stop"},
    {.method = "wait"},
    {.method = "render.set", .without = {"threads"}},
    {.method = "export", .without = {"fds", "detach", "overwrite", "farm", "job"}},
    {.method = "job.cancel"},
    {.method = "library.list"},
    {.method = "playlist.set"},
    {.method = "playlist.get"},
    {.method = "playlist.play"},
    {.method = "playlist.stop"},
    {.method = "playlist.pause"},
    {.method = "playlist.change"},
    {.method = "playlist.next"},
    {.method = "playlist.previous"},
    {.method = "device.list"},
    {.method = "device.calibration"},
    {.method = "doctor"},
    {.method = "log.tail"},
    {.method = "subscribe"},
};

enum { N_ALLOWED = sizeof table / sizeof table[0] };

lf_status lf_allow_check(const char *method, const json_t *params, lf_error *err)
{
    for (int i = 0; i < N_ALLOWED; i++) {
        if (strcmp(table[i].method, method) != 0)
            continue;
        for (int k = 0; k < 5 && table[i].without[k]; k++)
            if (json_object_get(params, table[i].without[k]))
                return lf_error_set(err, LF_E_ARG, method,
                                    "quiltweb does not allow the parameter %s",
                                    table[i].without[k]);
        return LF_OK;
    }
    return lf_error_set(err, LF_E_STATE, method, "quiltweb does not allow this method");
}

const char *lf_allow_at(int index)
{
    return index < N_ALLOWED ? table[index].method : NULL;
}
