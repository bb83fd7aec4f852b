/* The engine as quiltd has it, and a simulated USB display that is given each frame as quiltd gives
 * it: the newest, when the last one is shown. */
#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "base/alloc.h"
#include "bench/usb.h"
#include "daemon/engine/loader.h"
#include "device/model/usb_model.h"
#include "device/usb/gud.h"
#include "device/usb/usb.h"
#include "quilt/quilt.h"

#define PATIENCE_SECONDS 600.0

enum { LAST_MS = 20000 };

typedef struct stream {
    const lf_options *options;
    const char *file;
    lf_calibration calibration;
    int event_fd;
    lf_roots roots;
    lf_inbox inbox;
    bool has_inbox;
    lf_engine *engine;
    lf_loader *loader;
    lf_model_gud *gud;
    lf_device *device;
    bool loaded, busy;
    lf_status load_status;
    lf_error load_error;
    lf_bench_converge *out;
    double first_at, last_at; /* lf_time_now; 0 = no update yet */
} stream;

static void task_done(void *reader, lf_task *task)
{
    stream *s = reader;
    lf_load *load = (lf_load *)task; /* its first member */
    s->load_status = load->status;
    s->load_error = load->err;
    s->loaded = true;
    lf_load_destroy(load);
}

static lf_status send_load(stream *s, lf_error *err)
{
    lf_load *load = lf_load_create(LF_LOAD_FILE);
    char *path = realpath(s->file, NULL);
    if (load)
        load->file = lf_strdup(path ? path : s->file);
    free(path);
    if (!load || !load->file) {
        lf_load_destroy(load);
        return lf_error_set(err, LF_E_NOMEM, s->file, "out of memory");
    }
    load->task.done = task_done;
    load->options = *s->options;
    load->has_calibration = true;
    load->calibration = s->calibration;
    lf_loader_queue(s->loader, load);
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- showing -- */

/* What of frame differs from what the display shows. */
static int rects_for(const stream *s, const lf_frame *frame, lf_rect *rects)
{
    const lf_frame *current = lf_mailbox_current(lf_engine_mailbox(s->engine));
    rects[0] = (lf_rect){.width = frame->image.width, .height = frame->image.height};
    return current ? lf_changed_rects(&current->image, &frame->image, rects, LF_FRAME_MAX_RECTS)
                   : 1;
}

static double bytes_sent(const stream *s)
{
    lf_device_counters counters;
    s->device->ops->counters(s->device, &counters);
    return (double)counters.bytes;
}

static lf_status push_newest(stream *s, lf_error *err)
{
    lf_mailbox *mailbox = lf_engine_mailbox(s->engine);
    lf_rect rects[LF_FRAME_MAX_RECTS];
    if (s->busy && s->device->ops->dispatch(s->device) == LF_DEVICE_BUSY)
        return LF_OK;
    if (s->busy && s->out->updates == 1)
        s->out->first_bytes = bytes_sent(s);
    s->busy = false;
    const lf_frame *frame = lf_mailbox_take(mailbox);
    if (!frame)
        return LF_OK;
    int n = rects_for(s, frame, rects);
    lf_status status = s->device->ops->push(s->device, &frame->image, rects, n, 1);
    if (status != LF_OK)
        return lf_error_set(err, status, "usb", "the simulated display accepts no frame");
    lf_mailbox_shown(mailbox);
    s->busy = true;
    s->last_at = lf_time_now();
    s->first_at = s->out->updates++ == 0 ? s->last_at : s->first_at;
    return LF_OK;
}

static void drain(int fd)
{
    uint64_t count;
    while (read(fd, &count, sizeof count) > 0)
        continue;
}

static lf_status wait_and_push(stream *s, double seconds, lf_error *err)
{
    struct pollfd fds[3] = {{.fd = s->event_fd, .events = POLLIN},
                            {.fd = s->inbox.event_fd, .events = POLLIN},
                            {.fd = s->device->ops->poll_fd(s->device), .events = POLLIN}};
    if (poll(fds, 3, (int)(1e3 * seconds) + 1) < 0 && errno != EINTR)
        return lf_error_set(err, LF_E_IO, "usb", "cannot wait");
    drain(s->event_fd);
    lf_inbox_read(&s->inbox, s);
    if (s->loaded && s->load_status != LF_OK) {
        *err = s->load_error;
        return s->load_status;
    }
    return push_newest(s, err);
}

static lf_status run(stream *s, lf_error *err)
{
    double start = lf_time_now();
    lf_status status = send_load(s, err);
    while (status == LF_OK && (s->first_at <= 0 || lf_time_now() < s->first_at + s->out->seconds)) {
        if (lf_time_now() > start + PATIENCE_SECONDS)
            return lf_error_set(err, LF_E_TIMEOUT, s->file, "there was no frame after %g s",
                                PATIENCE_SECONDS);
        status = wait_and_push(s, 0.1, err);
    }
    s->out->shown_seconds = s->last_at - s->first_at;
    return status;
}

/* The last frame, when the engine rests, and whether the display shows it. */
static lf_status settle(stream *s, lf_error *err)
{
    lf_engine_controls controls = lf_engine_get_controls(s->engine);
    lf_engine_status now;
    double end = lf_time_now() + 1e-3 * LAST_MS;
    lf_status status = LF_OK;
    controls.paused = true;
    lf_engine_set_controls(s->engine, &controls);
    do {
        status = wait_and_push(s, 0.05, err);
        lf_engine_get_status(s->engine, &now);
    } while (status == LF_OK && now.state != LF_STATE_PAUSED && lf_time_now() < end);
    for (int i = 0; i < 2 && status == LF_OK; i++) {
        status = s->device->ops->flush(s->device, LAST_MS);
        if (status == LF_OK)
            status = push_newest(s, err);
    }
    if (status == LF_OK)
        status = s->device->ops->flush(s->device, LAST_MS);
    return status == LF_OK ? LF_OK
                           : lf_error_set(err, status, "usb", "the last frame was not shown");
}

static lf_status compare(stream *s, lf_image8 *out_last, lf_error *err)
{
    const lf_image8 *frame = &lf_mailbox_current(lf_engine_mailbox(s->engine))->image;
    const uint8_t *shown = lf_model_gud_pixels(s->gud);
    size_t row = (size_t)frame->width * 3;
    for (int y = 0; y < frame->height; y++)
        for (size_t i = 0; i < row; i++)
            s->out->differences +=
                shown[(size_t)y * row + i] != frame->data[(size_t)y * frame->stride + i];
    if (lf_image8_init(out_last, frame->width, frame->height, 3) != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, "usb", "out of memory");
    for (int y = 0; y < frame->height; y++)
        memcpy(out_last->data + (size_t)y * out_last->stride,
               frame->data + (size_t)y * frame->stride, row);
    return LF_OK;
}

/* ------------------------------------------------------------------------------------ set-up -- */

static lf_status make_device(stream *s, lf_error *err)
{
    static const uint8_t formats[] = {LF_GUD_RGB888};
    const lf_usb_place place = {.address = "1-1", .product = "simulated"};
    const lf_model_gud_options options = {.width = s->calibration.screen_width_px,
                                          .height = s->calibration.screen_height_px,
                                          .formats = formats,
                                          .n_formats = 1,
                                          .lz4 = s->out->lz4};
    lf_status status = lf_model_gud_create(&options, NULL, &s->gud);
    lf_usb_link *link = status == LF_OK ? lf_usb_model_open(s->gud) : NULL;
    return link ? lf_usb_create(link, &place, &s->calibration, &s->device, err)
                : lf_error_set(err, LF_E_NOMEM, "usb", "out of memory");
}

static lf_status make_engine(stream *s, lf_error *err)
{
    const lf_engine_controls controls = {.estimator = s->options->estimator,
                                         .target_error = 1e-12,
                                         .threads = s->options->threads,
                                         .denoise = s->options->denoise};
    s->event_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    s->has_inbox = s->event_fd >= 0 && lf_inbox_init(&s->inbox) == LF_OK;
    if (!s->has_inbox)
        return lf_error_set(err, LF_E_NOMEM, "usb", "out of file descriptors");
    lf_status status = lf_engine_create(&controls, s->event_fd, &s->engine, err);
    if (status != LF_OK)
        return status;
    lf_engine_set_panel(s->engine, &s->calibration, 1, false);
    status = lf_loader_create(s->engine, &s->roots, &s->inbox, &s->loader);
    return status == LF_OK ? LF_OK : lf_error_set(err, status, "usb", "cannot start the loader");
}

static void finish(stream *s)
{
    lf_loader_destroy(s->loader);
    lf_engine_destroy(s->engine);
    if (s->has_inbox)
        lf_inbox_finish(&s->inbox, s);
    if (s->event_fd >= 0)
        close(s->event_fd);
    lf_device_destroy(s->device);
    lf_model_gud_destroy(s->gud);
}

lf_status lf_bench_usb_converge(const char *file, const lf_options *options,
                                lf_bench_converge *converge, lf_image8 *out_last, lf_error *err)
{
    stream s = {.options = options, .file = file, .event_fd = -1, .out = converge};
    converge->updates = 0;
    converge->differences = 0;
    lf_calibration_portrait(&s.calibration);
    lf_status status = options->calibration
                           ? lf_calibration_load(options->calibration, &s.calibration, err)
                           : LF_OK;
    converge->frame_bytes = 3.0 * s.calibration.screen_width_px * s.calibration.screen_height_px;
    if (status == LF_OK)
        status = make_device(&s, err);
    if (status == LF_OK)
        status = make_engine(&s, err);
    if (status == LF_OK)
        status = run(&s, err);
    if (status == LF_OK)
        status = settle(&s, err);
    if (status == LF_OK) {
        converge->wire_bytes = bytes_sent(&s);
        status = compare(&s, out_last, err);
    }
    finish(&s);
    return status;
}
