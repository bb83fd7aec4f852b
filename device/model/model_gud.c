#include <assert.h>
#include <errno.h>
#include <lz4.h>
#include <string.h>

#include "base/alloc.h"
#include "base/calibration.h"
#include "base/thread.h"
#include "device/model/model.h"
#include "device/usb/gud.h"

enum {
    MAX_OPTION_FORMATS = 8,
    MANY_FORMATS = 200,
    SHORT_EDID = 100,
    MAX_ANSWER = 4096,
    ODD_STATUS = 200
};

struct lf_model_gud {
    lf_model_gud_options options;
    lf_model_gud_faults faults;
    uint8_t formats[MAX_OPTION_FORMATS];
    uint8_t edid[LF_GUD_MAX_EDID];
    lf_gud_mode mode;
    uint8_t status; /* result of GET_STATUS */
    lf_gud_state checked, state;
    bool has_checked, has_state, controller, display, gone;
    bool announced; /* a SET_BUFFER waits for its data */
    /* the last rectangle failed: even whole frames need SET_BUFFER again */
    bool must_announce;
    lf_gud_buffer buffer; /* … described by this */
    size_t expected;      /* bytes expected on the bulk endpoint */
    size_t received;
    size_t capacity; /* size of the two buffers below */
    uint8_t *in, *unpacked;
    uint8_t *pixels; /* [height][width][3] */
    uint64_t n_buffers, n_bulks;
    lf_model_gud_counters counters;
};

/* --------------------------------------------------------------------------- create, destroy -- */

static bool good_options(const lf_model_gud_options *o)
{
    if (o->width < 1 || o->width > LF_MAX_SIDE || o->height < 1 || o->height > LF_MAX_SIDE)
        return false;
    if (o->n_formats < 1 || o->n_formats > MAX_OPTION_FORMATS || !o->formats)
        return false;
    for (int i = 0; i < o->n_formats; i++)
        if (lf_gud_format_bytes(o->formats[i]) == 0)
            return false;
    return o->n_edid <= LF_GUD_MAX_EDID && o->n_edid % 128 == 0 && (o->edid || o->n_edid == 0);
}

static lf_gud_mode mode_of(int width, int height)
{
    lf_gud_mode m = {
        .hdisplay = (uint16_t)width,
        .hsync_start = (uint16_t)(width + 8),
        .hsync_end = (uint16_t)(width + 16),
        .htotal = (uint16_t)(width + 24),
        .vdisplay = (uint16_t)height,
        .vsync_start = (uint16_t)(height + 2),
        .vsync_end = (uint16_t)(height + 4),
        .vtotal = (uint16_t)(height + 6),
        .flags = LF_GUD_MODE_PREFERRED,
    };
    m.clock_khz = (uint32_t)((uint64_t)m.htotal * m.vtotal * 60 / 1000);
    return m;
}

lf_status lf_model_gud_create(const lf_model_gud_options *options,
                              const lf_model_gud_faults *faults, lf_model_gud **out)
{
    if (!good_options(options))
        return LF_E_ARG;
    lf_model_gud *gud = lf_calloc(1, sizeof *gud);
    if (!gud)
        return LF_E_NOMEM;
    gud->options = *options;
    if (faults)
        gud->faults = *faults;
    memcpy(gud->formats, options->formats, (size_t)options->n_formats);
    if (options->n_edid > 0)
        memcpy(gud->edid, options->edid, options->n_edid);
    gud->mode = mode_of(options->width, options->height);
    size_t frame = (size_t)options->width * (size_t)options->height;
    gud->capacity = frame * 4;
    if (options->max_buffer_size > 0 && options->max_buffer_size < gud->capacity)
        gud->capacity = options->max_buffer_size;
    gud->in = lf_calloc(gud->capacity, 1);
    gud->unpacked = options->lz4 ? lf_calloc(gud->capacity, 1) : NULL;
    gud->pixels = lf_calloc(frame, 3);
    if (!gud->in || (options->lz4 && !gud->unpacked) || !gud->pixels) {
        lf_model_gud_destroy(gud);
        return LF_E_NOMEM;
    }
    *out = gud;
    return LF_OK;
}

void lf_model_gud_destroy(lf_model_gud *gud)
{
    if (!gud)
        return;
    lf_free(gud->in);
    lf_free(gud->unpacked);
    lf_free(gud->pixels);
    lf_free(gud);
}

/* True if a fault is due. */
static bool nth(uint64_t count, uint64_t every)
{
    return every > 0 && count % every == 0;
}

/* -------------------------------------------------------------------- what it says of itself -- */

static size_t answer_descriptor(const lf_model_gud *gud, uint8_t *out)
{
    const lf_model_gud_options *o = &gud->options;
    lf_gud_descriptor d = {
        .version = gud->faults.fault == LF_GUD_VERSION_0   ? 0
                   : gud->faults.fault == LF_GUD_VERSION_9 ? 9
                                                           : 1,
        .flags = (o->status_on_set ? LF_GUD_FLAG_STATUS_ON_SET : 0u) |
                 (o->full_update ? LF_GUD_FLAG_FULL_UPDATE : 0u),
        .compression = o->lz4 ? LF_GUD_COMPRESSION_LZ4 : 0,
        .max_buffer_size = o->max_buffer_size,
        .min_width = (uint32_t)o->width,
        .max_width = (uint32_t)o->width,
        .min_height = (uint32_t)o->height,
        .max_height = (uint32_t)o->height,
    };
    if (gud->faults.fault == LF_GUD_TINY_BUFFER)
        d.max_buffer_size = (uint32_t)o->width * 2 - 1;
    if (gud->faults.fault == LF_GUD_COMPRESSED_FULL) {
        d.flags |= LF_GUD_FLAG_FULL_UPDATE;
        d.compression = LF_GUD_COMPRESSION_LZ4;
    }
    if (gud->faults.fault == LF_GUD_MODE_65535 || gud->faults.fault == LF_GUD_MODE_0X0) {
        d.min_width = d.min_height = 0;
        d.max_width = d.max_height = UINT32_MAX;
    }
    lf_gud_descriptor_write(&d, out);
    if (gud->faults.fault == LF_GUD_WRONG_MAGIC)
        out[0] ^= 1;
    return gud->faults.fault == LF_GUD_SHORT_DESCRIPTOR ? LF_GUD_DESCRIPTOR_BYTES - 7
                                                        : LF_GUD_DESCRIPTOR_BYTES;
}

static size_t answer_formats(const lf_model_gud *gud, uint8_t *out)
{
    static const uint8_t unknown[] = {0x01, 0x08, 0x30, 0xfe};
    switch (gud->faults.fault) {
    case LF_GUD_NO_FORMATS:
        return 0;
    case LF_GUD_UNKNOWN_FORMATS:
        memcpy(out, unknown, sizeof unknown);
        return sizeof unknown;
    case LF_GUD_MANY_FORMATS:
        memset(out, gud->formats[0], MANY_FORMATS);
        return MANY_FORMATS;
    default:
        memcpy(out, gud->formats, (size_t)gud->options.n_formats);
        return (size_t)gud->options.n_formats;
    }
}

static size_t answer_modes(const lf_model_gud *gud, uint8_t *out)
{
    lf_gud_mode mode = gud->mode;
    if (gud->faults.fault == LF_GUD_MODE_0X0)
        mode.hdisplay = mode.vdisplay = 0;
    if (gud->faults.fault == LF_GUD_MODE_65535)
        mode.hdisplay = mode.vdisplay = UINT16_MAX;
    lf_gud_mode_write(&mode, out);
    return gud->faults.fault == LF_GUD_NO_MODES    ? 0
           : gud->faults.fault == LF_GUD_MODES_CUT ? LF_GUD_MODE_BYTES - 3
                                                   : LF_GUD_MODE_BYTES;
}

static size_t answer_edid(const lf_model_gud *gud, uint8_t *out)
{
    memcpy(out, gud->edid, gud->options.n_edid);
    if (gud->faults.fault == LF_GUD_SHORT_EDID) {
        memset(out, 0, SHORT_EDID);
        memcpy(out, gud->edid, gud->options.n_edid < SHORT_EDID ? gud->options.n_edid : SHORT_EDID);
        return SHORT_EDID;
    }
    return gud->faults.fault == LF_GUD_NO_MODES ? 0 : gud->options.n_edid;
}

/* One property of the plane and one of the connector; a host must return both in every state. */
static size_t answer_property(uint16_t id, uint64_t value, uint8_t *out)
{
    const lf_gud_property property = {id, value};
    lf_gud_property_write(&property, out);
    return LF_GUD_PROPERTY_BYTES;
}

static size_t answer_connectors(const lf_model_gud *gud, uint8_t *out)
{
    memset(out, 0, LF_GUD_CONNECTOR_BYTES);
    return gud->faults.fault == LF_GUD_NO_CONNECTORS ? 0 : LF_GUD_CONNECTOR_BYTES;
}

/* Writes the answer; returns bytes in out[MAX_ANSWER], -1 = unknown request. */
static int answer(const lf_model_gud *gud, uint8_t request, uint8_t *out)
{
    switch (request) {
    case LF_GUD_GET_DESCRIPTOR:
        return (int)answer_descriptor(gud, out);
    case LF_GUD_GET_FORMATS:
        return (int)answer_formats(gud, out);
    case LF_GUD_GET_PROPERTIES:
        return (int)answer_property(LF_GUD_PROPERTY_ROTATION, 0x3f, out);
    case LF_GUD_GET_CONNECTORS:
        return (int)answer_connectors(gud, out);
    case LF_GUD_GET_CONNECTOR_PROPERTIES:
        return (int)answer_property(LF_GUD_PROPERTY_BACKLIGHT, 80, out);
    case LF_GUD_GET_CONNECTOR_STATUS:
        out[0] = LF_GUD_CONNECTED;
        return 1;
    case LF_GUD_GET_CONNECTOR_MODES:
        return (int)answer_modes(gud, out);
    case LF_GUD_GET_CONNECTOR_EDID:
        return (int)answer_edid(gud, out);
    default:
        return -1;
    }
}

/* ------------------------------------------------------------------------------- what is set -- */

static uint8_t check_state(lf_model_gud *gud, const uint8_t *data, size_t n)
{
    lf_gud_state s;
    if (!lf_gud_state_read(data, n, &s))
        return LF_GUD_STATUS_PROTOCOL_ERROR;
    uint8_t wanted[LF_GUD_MODE_BYTES];
    lf_gud_mode_write(&gud->mode, wanted);
    bool good = memcmp(data, wanted, sizeof wanted) == 0 && s.connector == 0 &&
                memchr(gud->formats, s.format, (size_t)gud->options.n_formats) &&
                s.n_properties == 2;
    for (int i = 0; good && i < 2; i++) {
        bool plane = s.properties[i].id == LF_GUD_PROPERTY_ROTATION &&
                     s.properties[i].value == LF_GUD_ROTATE_0;
        bool connector =
            s.properties[i].id == LF_GUD_PROPERTY_BACKLIGHT && s.properties[i].value <= 100;
        good = (plane || connector) && s.properties[0].id != s.properties[1].id;
    }
    if (!good)
        return LF_GUD_STATUS_INVALID_PARAMETER;
    gud->checked = s;
    gud->has_checked = true;
    return LF_GUD_STATUS_OK;
}

static uint8_t commit_state(lf_model_gud *gud, size_t n)
{
    if (n != 0 || !gud->has_checked || !gud->controller)
        return LF_GUD_STATUS_PROTOCOL_ERROR;
    gud->state = gud->checked;
    gud->has_state = true;
    gud->has_checked = gud->announced = false;
    return LF_GUD_STATUS_OK;
}

static uint8_t set_switch(bool *out, const uint8_t *data, size_t n)
{
    if (n != 1 || data[0] > 1)
        return LF_GUD_STATUS_INVALID_PARAMETER;
    *out = data[0] == 1;
    return LF_GUD_STATUS_OK;
}

static bool running(const lf_model_gud *gud)
{
    return gud->has_state && gud->controller;
}

/* Products in 64 bits, because a host's data is untrusted too. */
static bool buffer_fits(const lf_model_gud *gud, const lf_gud_buffer *b)
{
    const lf_model_gud_options *o = &gud->options;
    uint64_t width = (uint64_t)o->width, height = (uint64_t)o->height;
    if (b->width == 0 || b->height == 0 || (uint64_t)b->x + b->width > width ||
        (uint64_t)b->y + b->height > height)
        return false;
    uint64_t length =
        (uint64_t)b->width * b->height * (uint64_t)lf_gud_format_bytes(gud->state.format);
    if (b->length != length || length > gud->capacity)
        return false;
    if (o->full_update && (b->width != width || b->height != height))
        return false;
    if (b->compression == 0)
        return b->compressed_length == 0;
    return b->compression == LF_GUD_COMPRESSION_LZ4 && o->lz4 && b->compressed_length > 0 &&
           b->compressed_length <= b->length;
}

static void expect(lf_model_gud *gud, const lf_gud_buffer *b)
{
    gud->buffer = *b;
    gud->expected = b->compression != 0 ? b->compressed_length : b->length;
    gud->received = 0;
    gud->announced = true;
    gud->must_announce = false;
}

static uint8_t set_buffer(lf_model_gud *gud, const uint8_t *data, size_t n)
{
    lf_gud_buffer b;
    gud->announced = false;
    if (!running(gud) || !lf_gud_buffer_read(data, n, &b))
        return LF_GUD_STATUS_PROTOCOL_ERROR;
    if (!buffer_fits(gud, &b))
        return LF_GUD_STATUS_INVALID_PARAMETER;
    gud->n_buffers++;
    if (nth(gud->n_buffers, gud->faults.stall_every))
        return LF_GUD_STATUS_BUSY;
    expect(gud, &b);
    return LF_GUD_STATUS_OK;
}

static uint8_t take(lf_model_gud *gud, uint8_t request, const uint8_t *data, size_t n)
{
    switch (request) {
    case LF_GUD_SET_BUFFER:
        return set_buffer(gud, data, n);
    case LF_GUD_SET_STATE_CHECK:
        return check_state(gud, data, n);
    case LF_GUD_SET_STATE_COMMIT:
        return commit_state(gud, n);
    case LF_GUD_SET_CONTROLLER_ENABLE:
        return set_switch(&gud->controller, data, n);
    case LF_GUD_SET_DISPLAY_ENABLE:
        return set_switch(&gud->display, data, n);
    case LF_GUD_SET_CONNECTOR_FORCE_DETECT:
        return n == 0 ? LF_GUD_STATUS_OK : LF_GUD_STATUS_PROTOCOL_ERROR;
    default:
        return LF_GUD_STATUS_NOT_SUPPORTED;
    }
}

/* ----------------------------------------------------------------------------------- control -- */

static int refuse(lf_model_gud *gud, uint8_t status)
{
    gud->status = status;
    if (status != LF_GUD_STATUS_BUSY)
        gud->counters.refused++;
    return -EPIPE;
}

static int get(lf_model_gud *gud, uint8_t request, uint8_t *data, size_t n)
{
    uint8_t all[MAX_ANSWER];
    if (request == LF_GUD_GET_STATUS) {
        if (n == 0)
            return 0;
        data[0] = gud->faults.fault == LF_GUD_BAD_STATUS ? ODD_STATUS : gud->status;
        return 1;
    }
    int length = answer(gud, request, all);
    if (length < 0)
        return refuse(gud, LF_GUD_STATUS_NOT_SUPPORTED);
    gud->status = LF_GUD_STATUS_OK;
    size_t given = (size_t)length < n ? (size_t)length : n;
    if (given > 0)
        memcpy(data, all, given);
    return (int)given;
}

int lf_model_gud_control(lf_model_gud *gud, bool in, uint8_t request, uint16_t value, uint8_t *data,
                         size_t n)
{
    if (gud->gone)
        return -ENODEV;
    if (value != 0) /* 0 is the only connector, and the value of all other requests */
        return refuse(gud, LF_GUD_STATUS_INVALID_PARAMETER);
    if (in)
        return get(gud, request, data, n);
    uint8_t status = take(gud, request, data, n);
    if (status == LF_GUD_STATUS_OK) {
        gud->status = status;
        return (int)n;
    }
    refuse(gud, status);
    /* with status_on_set the device takes the data before it checks them, so it cannot stall */
    return gud->options.status_on_set && status != LF_GUD_STATUS_NOT_SUPPORTED ? (int)n : -EPIPE;
}

/* -------------------------------------------------------------------------------------- bulk -- */

/* Simulates a display without a second buffer after half of a rectangle: corrupts its upper
 * half. */
static void spoil(lf_model_gud *gud)
{
    const lf_gud_buffer *b = &gud->buffer;
    for (uint32_t y = b->y; y < b->y + (b->height + 1) / 2; y++)
        for (size_t i = 0; i < (size_t)b->width * 3; i++)
            gud->pixels[((size_t)y * (size_t)gud->options.width + b->x) * 3 + i] ^= 0xff;
}

static int drop(lf_model_gud *gud, uint8_t status, int why)
{
    if (gud->announced)
        spoil(gud);
    gud->announced = false;
    gud->must_announce = true;
    gud->status = status;
    return why;
}

static void show(lf_model_gud *gud, const uint8_t *data)
{
    const lf_gud_buffer *b = &gud->buffer;
    size_t pitch = (size_t)b->width * (size_t)lf_gud_format_bytes(gud->state.format);
    for (uint32_t y = 0; y < b->height; y++) {
        uint8_t *row = gud->pixels + ((size_t)(b->y + y) * (size_t)gud->options.width + b->x) * 3;
        lf_gud_pixels_read(gud->state.format, data + y * pitch, b->width, row);
    }
    gud->counters.rects++;
    gud->counters.compressed_rects += b->compression != 0;
    gud->gone = gud->faults.unplug_after > 0 && gud->counters.rects >= gud->faults.unplug_after;
}

/* All bytes of a rectangle have arrived. */
static int finish(lf_model_gud *gud, size_t n)
{
    const uint8_t *data = gud->in;
    if (gud->buffer.compression != 0) {
        int length = LZ4_decompress_safe((const char *)gud->in, (char *)gud->unpacked,
                                         (int)gud->expected, (int)gud->buffer.length);
        if (length < 0 || (uint32_t)length != gud->buffer.length) {
            gud->counters.refused++;
            return drop(gud, LF_GUD_STATUS_ERROR, -EPIPE);
        }
        data = gud->unpacked;
    }
    gud->announced = false;
    gud->status = LF_GUD_STATUS_OK;
    show(gud, data);
    return (int)n;
}

int lf_model_gud_bulk(lf_model_gud *gud, const uint8_t *data, size_t n)
{
    if (gud->gone)
        return -ENODEV;
    if (!gud->announced && !gud->must_announce && gud->options.full_update && running(gud)) {
        lf_gud_buffer whole = {.width = (uint32_t)gud->options.width,
                               .height = (uint32_t)gud->options.height};
        whole.length =
            whole.width * whole.height * (uint32_t)lf_gud_format_bytes(gud->state.format);
        if (whole.length <= gud->capacity)
            expect(gud, &whole);
    }
    if (!gud->announced || n > gud->expected - gud->received) {
        gud->counters.refused++;
        return drop(gud, LF_GUD_STATUS_PROTOCOL_ERROR, -EPIPE);
    }
    gud->n_bulks++;
    if (nth(gud->n_bulks, gud->faults.hang_every))
        return drop(gud, LF_GUD_STATUS_ERROR, -ETIMEDOUT);
    if (nth(gud->n_bulks, gud->faults.fail_every))
        return drop(gud, LF_GUD_STATUS_ERROR, -EPIPE);
    if (n > 0)
        memcpy(gud->in + gud->received, data, n);
    gud->received += n;
    gud->counters.bytes += n;
    return gud->received == gud->expected ? finish(gud, n) : (int)n;
}

uint64_t lf_model_gud_delay_ns(const lf_model_gud *gud, size_t n)
{
    uint64_t speed = gud->faults.bytes_per_s;
    return speed == 0 ? 0 : (uint64_t)((double)n / (double)speed * (double)LF_NS_PER_S);
}

/* ----------------------------------------------------------------------------------- looking -- */

const uint8_t *lf_model_gud_pixels(const lf_model_gud *gud)
{
    return gud->pixels;
}

bool lf_model_gud_lit(const lf_model_gud *gud)
{
    return running(gud) && gud->display;
}

void lf_model_gud_counters_get(const lf_model_gud *gud, lf_model_gud_counters *out)
{
    *out = gud->counters;
}
