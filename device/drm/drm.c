/* The panel on a display output without a desktop: drm (the first Looking Glass), drm:DP-1,
 * drm:card1/HDMI-A-1. Kernel mode setting: the native mode, two buffers in video memory, flips at
 * the display's own pace.
 *
 * A thread of the device's own copies what has changed into the buffer that is not shown, flips,
 * and waits for the kernel to tell that the flip has happened. The console comes back in two ways:
 * destroy shows again what was there; when the program dies the kernel takes its pictures away and,
 * if nobody else has the card open, restores the console by itself. */
#include <errno.h>
#include <inttypes.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/thread.h"
#include "device/device_table.h"
#include "device/drm/drm.h"
#include "device/find/find.h"
#include "device/handover.h"

/* A flip without an end is given up; a failing display is not tried more often than this; where the
 * kernel announces nothing it is asked for the monitor. */
enum { FLIP_MS = 1000, PAUSE_MS = 250, LOOK_MS = 1000 };

typedef enum drm_phase {
    DRM_IDLE,
    DRM_FLIPPING, /* the event is to come before until_ns */
    DRM_PAUSING,  /* the push has failed, which is told at until_ns */
} drm_phase;

typedef struct drm_device {
    lf_handover handover; /* first */

    /* immutable after open */
    const lf_kms_calls *kms;
    lf_calibration calibration;
    lf_origin origin;    /* of the calibration */
    lf_device_info info; /* all but the problem */
    char name[LF_KMS_NAME];
    uint32_t connector;
    uint8_t edid_block[LF_DRM_EDID_BLOCK]; /* of the monitor that the calibration is for */
    int card, fd;
    int watch_fd; /* -1 = none */

    /* the device's thread */
    lf_drm_output output;
    lf_drm_buffer buffers[2];
    int back;       /* the buffer that is not shown */
    bool has_shown; /* the other one is */
    bool relight;   /* the mode is to be set again, with the picture that is shown */
    drm_phase phase;
    uint64_t until_ns;
    uint64_t bytes; /* of the push under way */
} drm_device;

static drm_device *drm_of(lf_device *device)
{
    return (drm_device *)(void *)device;
}

static const drm_device *const_drm_of(const lf_device *device)
{
    return (const drm_device *)(const void *)device;
}

/* ----------------------------------------------------------------------- the device's thread -- */

static void enter(drm_device *drm, drm_phase phase, uint64_t wait_ms)
{
    drm->phase = phase;
    drm->until_ns = lf_time_now_ns() + wait_ms * LF_NS_PER_MS;
}

/* What was shown last is on the glass. */
static void shown(drm_device *drm)
{
    drm->back = 1 - drm->back;
    drm->has_shown = true;
    drm->phase = DRM_IDLE;
    lf_handover_problem_set(&drm->handover, lf_drm_output_problem(&drm->output));
    lf_handover_end(&drm->handover, true, drm->bytes);
}

static void failed(drm_device *drm, const char *why)
{
    char text[256];
    snprintf(text, sizeof text, "%s does not accept images: %s", drm->name, why);
    lf_handover_problem_set(&drm->handover, text);
    drm->output.lit = false;
    enter(drm, DRM_PAUSING, PAUSE_MS);
}

/* False when the display is gone. */
static bool show_push(drm_device *drm)
{
    lf_drm_buffer *back = &drm->buffers[drm->back];
    const lf_handover *h = &drm->handover;
    const lf_rect whole = {0, 0, h->picture.width, h->picture.height};
    for (int i = 0; i < 2; i++)
        lf_drm_buffer_age(&drm->buffers[i], h->rects, h->n_rects);
    drm->bytes = 0;
    if (h->n_rects == 0 && !drm->relight) {
        lf_handover_end(&drm->handover, true, 0);
        return true;
    }
    /* Painting empties the list but leaves its entries. They are all that this buffer missed, the
     * last push included: what a driver needs that uploads buffers one by one, and more than one
     * needs that compares with what is shown. */
    const lf_rect *clips = back->all_stale ? &whole : back->stale;
    int n_clips = back->all_stale ? 1 : back->n_stale;
    drm->bytes = lf_drm_buffer_paint(back, &h->picture);
    drm->relight = false;
    int e = lf_drm_output_show(&drm->output, back->fb, clips, n_clips);
    if (e == LF_DRM_NOW)
        shown(drm);
    else if (e == LF_DRM_LATER)
        enter(drm, DRM_FLIPPING, FLIP_MS);
    else if (e == -ENODEV)
        return false;
    else
        failed(drm, lf_errno_text(-e));
    return true;
}

/* Sets the mode again under the picture that is shown: the cable's link has failed, or the monitor
 * was away for a moment. */
static void relight(drm_device *drm)
{
    drm->relight = false;
    drm->output.lit = false;
    if (drm->has_shown &&
        lf_drm_output_show(&drm->output, drm->buffers[1 - drm->back].fb, NULL, 0) < 0)
        drm->relight = true;
}

static bool link_is_bad(const drm_device *drm)
{
    lf_kms_property *properties = lf_calloc(LF_KMS_PROPERTIES, sizeof *properties);
    int n = properties ? drm->kms->properties(drm->fd, drm->connector, DRM_MODE_OBJECT_CONNECTOR,
                                              properties)
                       : 0;
    bool bad = false;
    for (int i = 0; i < n; i++)
        bad = bad || (strcmp(properties[i].name, "link-status") == 0 &&
                      properties[i].value == DRM_MODE_LINK_STATUS_BAD);
    lf_free(properties);
    return bad;
}

/* Whether the connector has another monitor now, without a moment without one: swapped during a
 * suspend, by a switch, in a dock. An EDID that cannot be read says nothing: monitors that sleep
 * may not tell it. */
static bool is_another(const drm_device *drm)
{
    lf_edid edid;
    uint8_t block[LF_DRM_EDID_BLOCK];
    return lf_drm_read_edid(drm->kms, drm->fd, drm->connector, &edid, block) &&
           memcmp(block, drm->edid_block, sizeof block) != 0;
}

/* False when the monitor is gone. look: ask it, not the kernel's memory. */
static bool check_connector(drm_device *drm, bool look)
{
    lf_kms_connector connector;
    int e = drm->kms->connector(drm->fd, drm->connector, look, &connector);
    if (e == -ENODEV || e == -ENOENT || (e == 0 && connector.known && !connector.connected) ||
        is_another(drm))
        return false;
    drm->relight = drm->relight || (look && link_is_bad(drm));
    return true;
}

static bool read_events(drm_device *drm)
{
    int flips = drm->kms->events(drm->fd);
    if (flips < 0)
        return flips != -ENODEV && flips != -EIO;
    if (flips > 0 && drm->phase == DRM_FLIPPING)
        shown(drm);
    return true;
}

static void time_is_up(drm_device *drm)
{
    if (drm->phase == DRM_FLIPPING) {
        failed(drm, "an image was accepted but not shown within a second");
    } else if (drm->phase == DRM_PAUSING) {
        drm->phase = DRM_IDLE;
        lf_handover_end(&drm->handover, false, 0);
    }
}

static int wait_ms(const drm_device *drm)
{
    if (drm->phase == DRM_IDLE)
        return drm->watch_fd >= 0 && !drm->relight ? -1 : LOOK_MS;
    uint64_t now = lf_time_now_ns();
    return drm->until_ns > now ? (int)((drm->until_ns - now) / LF_NS_PER_MS + 1) : 0;
}

/* Waits for something to happen and deals with it; false when the display is gone. */
static bool turn(drm_device *drm, bool *out_stop)
{
    struct pollfd p[3] = {{.fd = drm->handover.wake_fd, .events = POLLIN},
                          {.fd = drm->fd, .events = POLLIN},
                          {.fd = drm->watch_fd, .events = POLLIN}};
    int n = poll(p, 3, wait_ms(drm));
    bool there = true;
    if (p[2].revents != 0 && drm->kms->watch_read(drm->watch_fd))
        there = check_connector(drm, true);
    else if (n == 0 && drm->watch_fd < 0 && drm->phase == DRM_IDLE)
        there = check_connector(drm, false);
    if (there && p[1].revents != 0)
        there = (p[1].revents & (POLLERR | POLLHUP)) == 0 && read_events(drm);
    if (!there)
        return false;
    if (drm->phase != DRM_IDLE && lf_time_now_ns() >= drm->until_ns)
        time_is_up(drm);
    if (drm->relight && drm->phase == DRM_IDLE)
        relight(drm);
    lf_handover_word word = lf_handover_take(&drm->handover);
    *out_stop = word == LF_HANDOVER_STOP;
    return word != LF_HANDOVER_PUSH || show_push(drm);
}

static void *thread_main(void *argument)
{
    drm_device *drm = argument;
    bool stop = false;
    while (!stop) {
        if (turn(drm, &stop))
            continue;
        lf_handover_gone(&drm->handover);
        break;
    }
    return NULL;
}

/* -------------------------------------------------------------------------------------- open -- */

static lf_status take_display(drm_device *drm, lf_error *err)
{
    char who[64] = "another program, perhaps a desktop,";
    int e = lf_drm_become_master(drm->kms, drm->fd);
    if (e == 0)
        return LF_OK;
    if (e != -EBUSY && e != -EACCES)
        return lf_error_set(err, LF_E_IO, drm->name, "cannot take over the display: %s",
                            lf_errno_text(-e));
    drm->kms->master_name(drm->card, who, sizeof who);
    return lf_error_set(
        err, LF_E_BUSY, drm->name,
        "%s uses /dev/dri/card%d; on a desktop use --device window, else stop that program", who,
        drm->card);
}

static lf_status find_calibration(drm_device *drm, const lf_calibration *given,
                                  const lf_drm_found *found, lf_error *err)
{
    if (!given)
        return lf_find_for_display(&found->edid, &drm->calibration, &drm->origin, err);
    drm->calibration = *given;
    drm->origin = (lf_origin){.words = "given by the caller"};
    return LF_OK;
}

static lf_status check_size(const drm_device *drm, const struct drm_mode_modeinfo *mode,
                            lf_error *err)
{
    const lf_calibration *c = &drm->calibration;
    if (mode->hdisplay == c->screen_width_px && mode->vdisplay == c->screen_height_px)
        return LF_OK;
    bool turned = mode->hdisplay == c->screen_height_px && mode->vdisplay == c->screen_width_px;
    return lf_error_set(
        err, LF_E_ARG, drm->name,
        "the native mode has %dx%d pixels, but the calibration (%.80s) is for %dx%d%s",
        mode->hdisplay, mode->vdisplay, drm->origin.words, c->screen_width_px, c->screen_height_px,
        turned ? "; it is for another model or another orientation"
               : "; pass the calibration of this panel");
}

static void describe(drm_device *drm, const lf_drm_found *found)
{
    lf_device_info *info = &drm->info;
    *info = (lf_device_info){.kind = "drm"};
    snprintf(info->spec, sizeof info->spec, "drm:card%d/%s", found->card, found->connector.name);
    snprintf(info->output, sizeof info->output, "card%d/%s %dx%d at %u Hz", found->card,
             found->connector.name, found->mode.hdisplay, found->mode.vdisplay,
             found->mode.vrefresh);
    lf_device_text(info->model, sizeof info->model,
                   found->edid.name[0] != 0 ? found->edid.name : "a monitor without a name");
    lf_device_text(info->serial, sizeof info->serial,
                   drm->calibration.serial[0] != 0 ? drm->calibration.serial : found->edid.serial);
    lf_device_text(info->calibration_from, sizeof info->calibration_from, drm->origin.words);
    info->calibration_cached = drm->origin.cached;
}

/* Everything on the card: the display is ours, and would take pictures. */
static lf_status set_up(drm_device *drm, const lf_drm_found *found, const lf_calibration *given,
                        lf_error *err)
{
    /* Before it is taken: looking for the calibration may take seconds, which must not be at the
     * cost of a desktop that starts meanwhile. */
    lf_status status = find_calibration(drm, given, found, err);
    if (status == LF_OK)
        status = check_size(drm, &found->mode, err);
    if (status == LF_OK)
        status = take_display(drm, err);
    if (status == LF_OK)
        status = lf_drm_output_init(drm->kms, found, &drm->output, err);
    for (int i = 0; i < 2 && status == LF_OK; i++)
        status = lf_drm_buffer_init(drm->kms, drm->fd, found->mode.hdisplay, found->mode.vdisplay,
                                    &drm->buffers[i], err);
    if (status == LF_OK)
        status = lf_drm_output_test(&drm->output, drm->buffers[0].fb, err);
    if (status == LF_OK)
        status = lf_handover_init(&drm->handover, found->mode.hdisplay, found->mode.vdisplay, err);
    return status;
}

lf_status lf_drm_open(const lf_kms_calls *kms, const char *argument,
                      const lf_calibration *calibration, lf_device **out_device, lf_error *err)
{
    lf_drm_name name;
    drm_device *drm = lf_calloc(1, sizeof *drm);
    if (!drm)
        return lf_error_set(err, LF_E_NOMEM, "drm", "out of memory");
    drm->handover.base.ops = &lf_drm_ops;
    drm->kms = kms;
    drm->fd = drm->watch_fd = -1;
    lf_drm_found *found = lf_calloc(1, sizeof *found);
    lf_status status = found ? lf_drm_name_parse(argument, &name, err)
                             : lf_error_set(err, LF_E_NOMEM, "drm", "out of memory");
    if (status == LF_OK)
        status = lf_drm_find(kms, &name, found, err);
    if (status != LF_OK)
        goto fail;
    drm->card = found->card;
    drm->fd = found->fd;
    drm->connector = found->connector.id;
    memcpy(drm->edid_block, found->edid_block, sizeof drm->edid_block);
    snprintf(drm->name, sizeof drm->name, "%s", found->connector.name);
    status = set_up(drm, found, calibration, err);
    if (status != LF_OK)
        goto fail;
    describe(drm, found);
    drm->watch_fd = kms->watch();
    status = lf_handover_start(&drm->handover, thread_main, drm, "lf-drm", err);
    if (status != LF_OK)
        goto fail;
    lf_free(found);
    *out_device = &drm->handover.base;
    return LF_OK;
fail:
    lf_free(found);
    lf_device_destroy(&drm->handover.base);
    return status;
}

static lf_status drm_open(const char *argument, const lf_calibration *calibration,
                          lf_device **out_device, lf_error *err)
{
    return lf_drm_open(&lf_kms_kernel, argument, calibration, out_device, err);
}

static int drm_probe(lf_device_info *out, int max)
{
    return lf_drm_probe(&lf_kms_kernel, out, max);
}

/* ----------------------------------------------------------------------------- the other ops -- */

static void drm_destroy(lf_device *device)
{
    drm_device *drm = drm_of(device);
    lf_handover_stop(&drm->handover);
    lf_drm_output_finish(&drm->output);
    for (int i = 0; i < 2; i++)
        lf_drm_buffer_finish(drm->kms, drm->fd, &drm->buffers[i]);
    if (drm->watch_fd >= 0)
        drm->kms->close(drm->watch_fd);
    if (drm->fd >= 0)
        drm->kms->close(drm->fd);
    lf_handover_finish(&drm->handover);
    lf_free(drm);
}

static void drm_info(const lf_device *device, lf_device_info *out)
{
    const drm_device *drm = const_drm_of(device);
    *out = drm->info;
    lf_handover_problem(&drm->handover, out->problem);
}

static const lf_calibration *drm_calibration(const lf_device *device)
{
    return &const_drm_of(device)->calibration;
}

const lf_device_ops lf_drm_ops = {
    .kind = "drm",
    .is_panel = true,
    .is_hardware = true,
    .probe = drm_probe,
    .open = drm_open,
    .destroy = drm_destroy,
    .info = drm_info,
    .calibration = drm_calibration,
    .push = lf_handover_push,
    .poll_fd = lf_handover_poll_fd,
    .dispatch = lf_handover_dispatch,
    .counters = lf_handover_counters,
    .flush = lf_handover_flush,
};
