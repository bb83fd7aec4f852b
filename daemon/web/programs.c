#include "daemon/web/programs.h"

#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/web/nng.h"
#include "daemon/wire/listen.h"

struct lf_programs {
    lf_panel_only *panel;
    lf_driver *driver;
    lf_nng *nng;
    lf_listener listener;
};

static lf_status open_nng(lf_programs *programs, sd_event *event, const lf_programs_config *config,
                          lf_error *err)
{
    int fd = config->nng_fd;
    lf_status status = LF_OK;
    if (fd < 0)
        status = lf_listen_at(config->nng_path, "--nng=PATH", &programs->listener, &fd, err);
    if (status == LF_E_BUSY)
        status = lf_error_set(err, LF_E_BUSY, config->nng_path,
                              "another quiltweb, or a program like it, uses this socket; choose "
                              "another --nng=PATH");
    if (status == LF_OK)
        status = lf_nng_create(event, fd, programs->driver, &programs->nng, err);
    if (status == LF_OK)
        lf_log(LF_LOG_INFO, "nng: %s",
               programs->listener.path ? programs->listener.path : "the socket from systemd");
    return status;
}

static lf_status set_up(lf_programs *programs, sd_event *event, const lf_programs_config *config,
                        lf_error *err)
{
    lf_status status = LF_OK;
    if (config->panel_only)
        status = lf_panel_only_create(event, config->socket, &programs->panel, err);
    const lf_driver_config driver = {.event = event,
                                     .socket = config->socket,
                                     .version = config->version,
                                     .image_limit = config->image_limit,
                                     .panel_only = programs->panel};
    return status == LF_OK ? lf_driver_create(&driver, &programs->driver, err) : status;
}

lf_status lf_programs_create(sd_event *event, const lf_programs_config *config, lf_programs **out,
                             lf_error *err)
{
    lf_programs *programs = lf_calloc(1, sizeof *programs);
    lf_status status = LF_OK;
    const bool passed = config->nng_fd >= 0;
    if (!programs)
        status = lf_error_set(err, LF_E_NOMEM, "programs", "out of memory");
    else
        programs->listener = (lf_listener){.lock_fd = -1};
    if (status == LF_OK && passed && config->nng_path)
        status = lf_error_set(err, LF_E_ARG, "--nng", "systemd passes a socket; leave it out");
    if (status == LF_OK)
        status = set_up(programs, event, config, err);
    if (status != LF_OK && passed)
        close(config->nng_fd);
    if (status == LF_OK && (passed || config->nng_path))
        status = open_nng(programs, event, config, err);
    if (status == LF_OK)
        *out = programs;
    else
        lf_programs_destroy(programs);
    return status;
}

void lf_programs_destroy(lf_programs *programs)
{
    if (!programs)
        return;
    lf_nng_destroy(programs->nng);
    lf_unlisten(&programs->listener);
    lf_driver_destroy(programs->driver);
    lf_panel_only_destroy(programs->panel);
    lf_free(programs);
}

lf_driver *lf_programs_driver(const lf_programs *programs)
{
    return programs->driver;
}

lf_panel_only *lf_programs_panel(const lf_programs *programs)
{
    return programs->panel;
}
