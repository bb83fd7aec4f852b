#include "device/usb/gud_host.h"

#include <assert.h>
#include <lz4.h>
#include <string.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "device/usb/gud_plan.h"

#define WHERE "GUD display"

enum {
    ASK_MS = 1000,        /* for a question */
    OPEN_MS = 3000,       /* for all questions together */
    STOP_MS = 200,        /* for switching off, which nobody waits for */
    SET_MS = 5000,        /* for what may switch a panel on: as the kernel's driver */
    MOVE_MS = 3000,       /* without a byte moved: as the kernel's driver */
    BAND_BYTES = 4 << 20, /* as most displays' buffers; a larger one would not go faster */
    MAX_ANSWER = LF_GUD_MAX_MODES * LF_GUD_MODE_BYTES + 1,
};

/* A band on its way. */
typedef struct packet {
    int band;
    lf_gud_buffer announce;
    const uint8_t *data; /* one of the two below */
    size_t n;
    uint8_t *raw, *packed; /* [capacity] */
} packet;

struct lf_gud_host {
    lf_usb_link *link;
    double open_until; /* lf_time_now at which asking ends */
    bool stopping;
    lf_gud_descriptor descriptor;
    lf_gud_format format;
    uint8_t connector;
    size_t n_edid;
    uint8_t edid[LF_GUD_MAX_EDID + 1];
    int n_modes;
    lf_gud_mode modes[LF_GUD_MAX_MODES];
    lf_gud_state state; /* properties from open on; mode from choose on */
    lf_gud_plan *plan;
    size_t capacity;   /* bytes of a packet */
    packet packets[2]; /* one is filled while the other is on the wire */
    void *lz4_state;
    bool announce; /* a display of whole frames must be told again what comes */
    lf_gud_host_counters counters;
};

/* ---------------------------------------------------------------------------------- requests -- */

static lf_status failed(lf_usb_result result, const char *what, lf_error *err)
{
    return lf_error_set(err, lf_usb_result_status(result), WHERE, "%s: %s", what,
                        lf_usb_result_text(result));
}

/* The display's own word for what went wrong with `what`; LF_OK when it has nothing against it. */
static lf_status check_status(lf_gud_host *host, const char *what, lf_error *err)
{
    uint8_t status = 0;
    size_t n = 0;
    int timeout_ms = host->stopping ? STOP_MS : ASK_MS;
    lf_usb_result result = host->link->ops->control(host->link, true, LF_GUD_GET_STATUS, 0, &status,
                                                    1, &n, timeout_ms);
    if (result != LF_USB_OK || n != 1)
        return failed(result != LF_USB_OK ? result : LF_USB_IO, "reading the display's status",
                      err);
    if (status >= LF_GUD_STATUSES)
        return lf_error_set(err, LF_E_FORMAT, WHERE,
                            "%s failed: the display returned status %d, expected 0..%d", what,
                            status, LF_GUD_STATUSES - 1);
    if (status != LF_GUD_STATUS_OK)
        return lf_error_set(err, LF_E_IO, WHERE, "%s failed: the display refused the request (%s)",
                            what, lf_gud_status_text(status));
    return LF_OK;
}

/* After a STALL the status tells why. */
static lf_status refused(lf_gud_host *host, lf_usb_result result, const char *what, lf_error *err)
{
    lf_status status = result == LF_USB_STALL ? check_status(host, what, err) : LF_OK;
    return status != LF_OK ? status : failed(result, what, err);
}

/* data[n] holds one byte more than is allowed, so that too long answers show. */
static lf_usb_result ask(lf_gud_host *host, uint8_t request, uint8_t *data, size_t n, size_t *out_n)
{
    uint16_t connector = request >= LF_GUD_GET_CONNECTOR_PROPERTIES ? host->connector : 0;
    *out_n = 0;
    /* a display may take its time, but not over every answer */
    if (lf_time_now() > host->open_until)
        return LF_USB_TIMEOUT;
    return host->link->ops->control(host->link, true, request, connector, data, n, out_n, ASK_MS);
}

static lf_status get(lf_gud_host *host, uint8_t request, const char *what, uint8_t *data, size_t n,
                     size_t *out_n, lf_error *err)
{
    lf_usb_result result = ask(host, request, data, n, out_n);
    return result == LF_USB_OK ? LF_OK : refused(host, result, what, err);
}

/* As get, for what small displays do not have: a refusal is an empty answer. */
static lf_status get_optional(lf_gud_host *host, uint8_t request, const char *what, uint8_t *data,
                              size_t n, size_t *out_n, lf_error *err)
{
    lf_usb_result result = ask(host, request, data, n, out_n);
    return result == LF_USB_OK || result == LF_USB_STALL ? LF_OK : failed(result, what, err);
}

static lf_status set(lf_gud_host *host, uint8_t request, const char *what, uint8_t *data, size_t n,
                     lf_error *err)
{
    int timeout_ms = host->stopping ? STOP_MS : SET_MS;
    lf_usb_result result =
        host->link->ops->control(host->link, false, request, 0, data, n, NULL, timeout_ms);
    if (result != LF_USB_OK)
        return refused(host, result, what, err);
    return (host->descriptor.flags & LF_GUD_FLAG_STATUS_ON_SET) != 0 ? check_status(host, what, err)
                                                                     : LF_OK;
}

/* -------------------------------------------------------------------------------------- open -- */

static lf_status ask_display(lf_gud_host *host, lf_error *err)
{
    uint8_t data[MAX_ANSWER];
    size_t n;
    lf_status status = get(host, LF_GUD_GET_DESCRIPTOR, "reading the display's descriptor", data,
                           LF_GUD_DESCRIPTOR_BYTES + 1, &n, err);
    if (status == LF_OK)
        status = lf_gud_descriptor_read(data, n, &host->descriptor, err);
    if (status == LF_OK)
        status = get(host, LF_GUD_GET_FORMATS, "reading the display's formats", data,
                     LF_GUD_MAX_FORMATS + 1, &n, err);
    if (status == LF_OK)
        status = lf_gud_formats_choose(data, n, &host->format, err);
    return status;
}

static lf_status find_connector(lf_gud_host *host, lf_error *err)
{
    uint8_t data[LF_GUD_MAX_CONNECTORS * LF_GUD_CONNECTOR_BYTES + 1];
    size_t n;
    int count = 0;
    lf_status status = get(host, LF_GUD_GET_CONNECTORS, "reading the display's connectors", data,
                           sizeof data, &n, err);
    if (status == LF_OK)
        status = lf_gud_connectors_count(data, n, &count, err);
    for (int i = 0; status == LF_OK && i < count; i++) {
        host->connector = (uint8_t)i;
        status = get(host, LF_GUD_GET_CONNECTOR_STATUS, "reading a connector's status", data, 1, &n,
                     err);
        if (status == LF_OK && n == 1 &&
            (data[0] & LF_GUD_CONNECTOR_STATUS_MASK) != LF_GUD_DISCONNECTED)
            return LF_OK;
    }
    return status != LF_OK
               ? status
               : lf_error_set(err, LF_E_NODEV, WHERE,
                              "the USB display has no panel connected; plug the panel into it");
}

static lf_status ask_edid(lf_gud_host *host, lf_error *err)
{
    size_t n;
    lf_status status = get_optional(host, LF_GUD_GET_CONNECTOR_EDID, "reading the display's EDID",
                                    host->edid, sizeof host->edid, &n, err);
    if (status != LF_OK)
        return status;
    if (n % 128 != 0 || n > LF_GUD_MAX_EDID)
        return lf_error_set(err, LF_E_FORMAT, WHERE,
                            "the EDID has %zu bytes, expected a multiple of 128, at most %d", n,
                            LF_GUD_MAX_EDID);
    host->n_edid = n;
    return LF_OK;
}

static lf_status ask_connector(lf_gud_host *host, lf_error *err)
{
    uint8_t data[MAX_ANSWER];
    size_t n;
    lf_status status = get_optional(host, LF_GUD_GET_CONNECTOR_PROPERTIES,
                                    "reading a connector's properties", data, sizeof data, &n, err);
    if (status == LF_OK)
        status = lf_gud_properties_read(data, n, &host->state, err);
    if (status == LF_OK)
        status = get_optional(host, LF_GUD_GET_PROPERTIES, "reading the display's properties", data,
                              sizeof data, &n, err);
    if (status == LF_OK)
        status = lf_gud_properties_read(data, n, &host->state, err);
    if (status == LF_OK)
        status = ask_edid(host, err);
    if (status == LF_OK)
        status = get(host, LF_GUD_GET_CONNECTOR_MODES, "reading the display's modes", data,
                     sizeof data, &n, err);
    if (status == LF_OK)
        status = lf_gud_modes_read(data, n, host->modes, &host->n_modes, err);
    if (status == LF_OK && host->n_modes == 0 &&
        lf_gud_mode_from_edid(host->edid, host->n_edid, &host->modes[0]))
        host->n_modes = 1;
    return status;
}

lf_status lf_gud_host_open(lf_usb_link *link, lf_gud_host **out, lf_error *err)
{
    lf_gud_host *host = lf_calloc(1, sizeof *host);
    if (!host)
        return lf_error_set(err, LF_E_NOMEM, WHERE, "out of memory");
    host->link = link;
    host->open_until = lf_time_now() + OPEN_MS / 1e3;
    lf_status status = ask_display(host, err);
    if (status == LF_OK)
        status = find_connector(host, err);
    if (status == LF_OK)
        status = ask_connector(host, err);
    if (status != LF_OK) {
        lf_gud_host_destroy(host);
        return status;
    }
    *out = host;
    return LF_OK;
}

void lf_gud_host_destroy(lf_gud_host *host)
{
    if (!host)
        return;
    for (int i = 0; i < 2; i++) {
        lf_free(host->packets[i].raw);
        lf_free(host->packets[i].packed);
    }
    lf_free(host->lz4_state);
    lf_gud_plan_destroy(host->plan);
    lf_free(host);
}

const uint8_t *lf_gud_host_edid(const lf_gud_host *host, size_t *out_n)
{
    *out_n = host->n_edid;
    return host->edid;
}

/* -------------------------------------------------------------------------------------- mode -- */

static bool wants_whole_frames(const lf_gud_host *host)
{
    return (host->descriptor.flags & LF_GUD_FLAG_FULL_UPDATE) != 0;
}

static bool takes_lz4(const lf_gud_host *host)
{
    return (host->descriptor.compression & LF_GUD_COMPRESSION_LZ4) != 0;
}

static lf_status choose_capacity(lf_gud_host *host, lf_error *err)
{
    const lf_gud_mode *mode = &host->state.mode;
    size_t row = mode->hdisplay * (size_t)lf_gud_format_bytes(host->format),
           frame = row * mode->vdisplay;
    size_t limit =
        host->descriptor.max_buffer_size != 0 ? host->descriptor.max_buffer_size : SIZE_MAX;
    size_t least = wants_whole_frames(host) ? frame : row;
    if (limit < least)
        return lf_error_set(
            err, LF_E_FORMAT, WHERE,
            "the display's buffer of %zu bytes is smaller than a %s of %dx%d %s (%zu bytes)", limit,
            wants_whole_frames(host) ? "frame" : "row", mode->hdisplay, mode->vdisplay,
            lf_gud_format_name(host->format), least);
    host->capacity = wants_whole_frames(host) ? frame : limit < BAND_BYTES ? limit : BAND_BYTES;
    if (host->capacity > frame)
        host->capacity = frame;
    return LF_OK;
}

static bool make_buffers(lf_gud_host *host)
{
    if (lf_gud_plan_create(host->state.mode.hdisplay, host->state.mode.vdisplay, &host->plan) !=
        LF_OK)
        return false;
    bool lz4 = takes_lz4(host);
    host->lz4_state = lz4 ? lf_calloc((size_t)LZ4_sizeofState(), 1) : NULL;
    bool ok = !lz4 || host->lz4_state;
    for (int i = 0; i < 2 && ok; i++) {
        packet *p = &host->packets[i];
        p->raw = lf_calloc(host->capacity, 1);
        p->packed = lz4 ? lf_calloc(host->capacity, 1) : NULL;
        ok = p->raw && (!lz4 || p->packed);
    }
    return ok;
}

bool lf_gud_host_preferred(const lf_gud_host *host, lf_gud_mode *out)
{
    return lf_gud_mode_choose(&host->descriptor, host->modes, host->n_modes, 0, 0, out, NULL) ==
           LF_OK;
}

lf_status lf_gud_host_choose(lf_gud_host *host, int width, int height, lf_error *err)
{
    assert(!host->plan);
    lf_status status = lf_gud_mode_choose(&host->descriptor, host->modes, host->n_modes, width,
                                          height, &host->state.mode, err);
    if (status == LF_OK)
        status = choose_capacity(host, err);
    if (status != LF_OK)
        return status;
    host->state.format = (uint8_t)host->format;
    host->state.connector = host->connector;
    if (!make_buffers(host))
        return lf_error_set(err, LF_E_NOMEM, WHERE, "out of memory for frames of %dx%d",
                            host->state.mode.hdisplay, host->state.mode.vdisplay);
    return LF_OK;
}

const lf_gud_mode *lf_gud_host_mode(const lf_gud_host *host)
{
    return &host->state.mode;
}

lf_gud_format lf_gud_host_format(const lf_gud_host *host)
{
    return host->format;
}

lf_status lf_gud_host_start(lf_gud_host *host, lf_error *err)
{
    uint8_t state[LF_GUD_STATE_MAX_BYTES], on = 1;
    assert(host->plan);
    lf_gud_plan_forget(host->plan);
    size_t n = lf_gud_state_write(&host->state, state);
    lf_status status =
        set(host, LF_GUD_SET_STATE_CHECK, "checking the display's mode", state, n, err);
    if (status == LF_OK)
        status = set(host, LF_GUD_SET_CONTROLLER_ENABLE, "switching the display's controller on",
                     &on, 1, err);
    if (status == LF_OK)
        status = set(host, LF_GUD_SET_STATE_COMMIT, "setting the display's mode", NULL, 0, err);
    if (status == LF_OK)
        status = set(host, LF_GUD_SET_DISPLAY_ENABLE, "switching the display on", &on, 1, err);
    return status;
}

void lf_gud_host_stop(lf_gud_host *host)
{
    uint8_t off = 0;
    host->stopping = true;
    lf_status status =
        set(host, LF_GUD_SET_DISPLAY_ENABLE, "switching the display off", &off, 1, NULL);
    if (status == LF_OK)
        status = set(host, LF_GUD_SET_CONTROLLER_ENABLE, "switching the display's controller off",
                     &off, 1, NULL);
    (void)status;
    host->stopping = false;
}

lf_status lf_gud_host_alive(lf_gud_host *host)
{
    uint8_t status;
    lf_usb_result result =
        host->link->ops->control(host->link, true, LF_GUD_GET_STATUS, 0, &status, 1, NULL, ASK_MS);
    return result == LF_USB_GONE ? LF_E_NODEV : LF_OK;
}

/* ----------------------------------------------------------------------------------- updates -- */

/* Fills a packet with a band: compressed where that is shorter. */
static void pack(lf_gud_host *host, const lf_image8 *frame, int band, packet *p)
{
    lf_rect r = lf_gud_plan_band(host->plan, band);
    size_t length = (size_t)r.width * (size_t)r.height * (size_t)lf_gud_format_bytes(host->format);
    assert(length <= host->capacity);
    lf_gud_pixels_write(host->format, frame, r, p->raw);
    p->band = band;
    p->data = p->raw;
    p->n = length;
    p->announce = (lf_gud_buffer){
        .x = (uint32_t)r.x,
        .y = (uint32_t)r.y,
        .width = (uint32_t)r.width,
        .height = (uint32_t)r.height,
        .length = (uint32_t)length,
    };
    if (!takes_lz4(host) || length > LZ4_MAX_INPUT_SIZE)
        return;
    int packed = LZ4_compress_fast_extState(host->lz4_state, (const char *)p->raw,
                                            (char *)p->packed, (int)length, (int)length - 1, 1);
    if (packed <= 0)
        return;
    p->data = p->packed;
    p->n = (size_t)packed;
    p->announce.compression = LF_GUD_COMPRESSION_LZ4;
    p->announce.compressed_length = (uint32_t)packed;
}

/* Announces a packet and puts it on the wire. */
static lf_status begin(lf_gud_host *host, const packet *p, lf_error *err)
{
    if (!wants_whole_frames(host) || host->announce) {
        uint8_t data[LF_GUD_BUFFER_BYTES];
        lf_gud_buffer_write(&p->announce, data);
        lf_status status =
            set(host, LF_GUD_SET_BUFFER, "announcing pixels", data, sizeof data, err);
        if (status != LF_OK)
            return status;
    }
    host->link->ops->bulk_begin(host->link, p->data, p->n);
    return LF_OK;
}

static lf_status end(lf_gud_host *host, const packet *p, lf_error *err)
{
    lf_usb_result result = host->link->ops->bulk_end(host->link, MOVE_MS);
    if (result != LF_USB_OK)
        return refused(host, result, "sending pixels", err);
    host->announce = false;
    host->counters.bands++;
    host->counters.compressed += p->announce.compression != 0;
    host->counters.bytes += p->n;
    lf_gud_plan_shown(host->plan, p->band);
    return LF_OK;
}

/* Packs each band while the one before it is on the wire. */
static lf_status send_bands(lf_gud_host *host, const lf_image8 *frame, int n, lf_error *err)
{
    lf_status status = LF_OK;
    for (int i = 0; i < n; i++) {
        packet *p = &host->packets[i % 2];
        pack(host, frame, i, p);
        if (i > 0)
            status = end(host, &host->packets[(i - 1) % 2], err);
        if (status == LF_OK)
            status = begin(host, p, err);
        if (status != LF_OK)
            return status;
    }
    return n > 0 ? end(host, &host->packets[(n - 1) % 2], err) : LF_OK;
}

lf_status lf_gud_host_update(lf_gud_host *host, const lf_image8 *frame, const lf_rect *rects, int n,
                             lf_error *err)
{
    size_t pixels = host->capacity / (size_t)lf_gud_format_bytes(host->format);
    int bands = wants_whole_frames(host) ? lf_gud_plan_update_whole(host->plan, frame)
                                         : lf_gud_plan_update(host->plan, frame, rects, n, pixels);
    lf_status status = send_bands(host, frame, bands, err);
    if (status != LF_OK) {
        lf_gud_plan_failed(host->plan);
        host->announce = true;
        host->counters.failures++;
    }
    return status;
}

void lf_gud_host_counters_get(const lf_gud_host *host, lf_gud_host_counters *out)
{
    *out = host->counters;
}
