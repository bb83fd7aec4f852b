#include "device/usb/gud.h"

#include <assert.h>
#include <string.h>

#include "base/calibration.h"
#include "device/find/edid.h"

#define MAGIC UINT32_C(0x1d50614d)
#define WHERE "GUD display"

enum { VERSION = 1 };

/* ----------------------------------------------------------------------------------- numbers -- */

static uint16_t read16(const uint8_t *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}

static uint32_t read32(const uint8_t *p)
{
    return read16(p) | (uint32_t)read16(p + 2) << 16;
}

static uint64_t read64(const uint8_t *p)
{
    return read32(p) | (uint64_t)read32(p + 4) << 32;
}

static void write16(uint8_t *p, uint16_t value)
{
    p[0] = (uint8_t)value;
    p[1] = (uint8_t)(value >> 8);
}

static void write32(uint8_t *p, uint32_t value)
{
    write16(p, (uint16_t)value);
    write16(p + 2, (uint16_t)(value >> 16));
}

static void write64(uint8_t *p, uint64_t value)
{
    write32(p, (uint32_t)value);
    write32(p + 4, (uint32_t)(value >> 32));
}

/* A list of entries of `size` bytes, at most max of them. */
static lf_status count_entries(const char *what, size_t n, size_t size, size_t max, int *out_n,
                               lf_error *err)
{
    if (n % size != 0)
        return lf_error_set(err, LF_E_FORMAT, WHERE,
                            "the display's list of %s is cut off (%zu bytes, %zu bytes per entry)",
                            what, n, size);
    if (n / size > max)
        return lf_error_set(err, LF_E_FORMAT, WHERE,
                            "the display lists more than %zu %s, the limit of the protocol", max,
                            what);
    *out_n = (int)(n / size);
    return LF_OK;
}

const char *lf_gud_format_name(lf_gud_format format)
{
    return format == LF_GUD_RGB888     ? "RGB888"
           : format == LF_GUD_XRGB8888 ? "XRGB8888"
           : format == LF_GUD_RGB565   ? "RGB565"
                                       : "none";
}

int lf_gud_format_bytes(lf_gud_format format)
{
    return format == LF_GUD_RGB888     ? 3
           : format == LF_GUD_XRGB8888 ? 4
           : format == LF_GUD_RGB565   ? 2
                                       : 0;
}

const char *lf_gud_status_text(uint8_t status)
{
    static const char *const texts[LF_GUD_STATUSES] = {
        "no error",          "busy", "request not supported", "protocol error",
        "invalid parameter", "error"};
    return status < LF_GUD_STATUSES ? texts[status] : "an unknown status";
}

/* -------------------------------------------------------------------------------- descriptor -- */

lf_status lf_gud_descriptor_read(const uint8_t *data, size_t n, lf_gud_descriptor *out,
                                 lf_error *err)
{
    if (n != LF_GUD_DESCRIPTOR_BYTES)
        return lf_error_set(err, LF_E_FORMAT, WHERE,
                            "the display's descriptor has %zu bytes, expected %d", n,
                            LF_GUD_DESCRIPTOR_BYTES);
    if (read32(data) != MAGIC)
        return lf_error_set(err, LF_E_FORMAT, WHERE,
                            "the display's descriptor begins with 0x%08x, expected 0x%08x",
                            read32(data), MAGIC);
    lf_gud_descriptor d = {
        .version = data[4],
        .flags = read32(data + 5),
        .compression = data[9],
        .max_buffer_size = read32(data + 10),
        .min_width = read32(data + 14),
        .max_width = read32(data + 18),
        .min_height = read32(data + 22),
        .max_height = read32(data + 26),
    };
    if (d.version != VERSION)
        return lf_error_set(err, LF_E_FORMAT, WHERE,
                            "the display uses version %d of the protocol, expected %d", d.version,
                            VERSION);
    if ((d.flags & LF_GUD_FLAG_FULL_UPDATE) != 0 && d.compression != 0)
        return lf_error_set(
            err, LF_E_FORMAT, WHERE,
            "the display asks for both whole frames and compression, which exclude each other");
    if (d.min_width > d.max_width || d.min_height > d.max_height)
        return lf_error_set(err, LF_E_FORMAT, WHERE,
                            "the display's minimum size %ux%u exceeds its maximum size %ux%u",
                            d.min_width, d.min_height, d.max_width, d.max_height);
    *out = d;
    return LF_OK;
}

void lf_gud_descriptor_write(const lf_gud_descriptor *d, uint8_t out[LF_GUD_DESCRIPTOR_BYTES])
{
    write32(out, MAGIC);
    out[4] = d->version;
    write32(out + 5, d->flags);
    out[9] = d->compression;
    write32(out + 10, d->max_buffer_size);
    write32(out + 14, d->min_width);
    write32(out + 18, d->max_width);
    write32(out + 22, d->min_height);
    write32(out + 26, d->max_height);
}

/* ------------------------------------------------------------------------------------- lists -- */

lf_status lf_gud_formats_choose(const uint8_t *data, size_t n, lf_gud_format *out, lf_error *err)
{
    static const lf_gud_format by_merit[] = {LF_GUD_RGB888, LF_GUD_XRGB8888, LF_GUD_RGB565};
    int count = 0;
    lf_status status = count_entries("formats", n, 1, LF_GUD_MAX_FORMATS, &count, err);
    if (status != LF_OK)
        return status;
    for (size_t i = 0; i < sizeof by_merit / sizeof *by_merit; i++)
        if (memchr(data, by_merit[i], n)) {
            *out = by_merit[i];
            return LF_OK;
        }
    return lf_error_set(err, LF_E_FORMAT, WHERE,
                        "none of the display's %d pixel formats is RGB888, XRGB8888 or RGB565",
                        count);
}

lf_status lf_gud_connectors_count(const uint8_t *data, size_t n, int *out_n, lf_error *err)
{
    (void)data; /* type and flags decide nothing here */
    int count = 0;
    lf_status status =
        count_entries("connectors", n, LF_GUD_CONNECTOR_BYTES, LF_GUD_MAX_CONNECTORS, &count, err);
    if (status != LF_OK)
        return status;
    if (count == 0)
        return lf_error_set(err, LF_E_FORMAT, WHERE, "the display has no connector");
    *out_n = count;
    return LF_OK;
}

/* Others would not know what a property means whose value quiltd gives back. */
static bool known_property(uint16_t id)
{
    return (id >= 1 && id <= LF_GUD_PROPERTY_BACKLIGHT) || id == LF_GUD_PROPERTY_ROTATION;
}

lf_status lf_gud_properties_read(const uint8_t *data, size_t n, lf_gud_state *state, lf_error *err)
{
    int count = 0;
    lf_status status =
        count_entries("properties", n, LF_GUD_PROPERTY_BYTES, LF_GUD_MAX_PROPERTIES, &count, err);
    if (status != LF_OK)
        return status;
    assert(state->n_properties + count <= 2 * LF_GUD_MAX_PROPERTIES);
    for (int i = 0; i < count; i++) {
        const uint8_t *p = data + i * LF_GUD_PROPERTY_BYTES;
        lf_gud_property property = {read16(p), read64(p + 2)};
        if (property.id == LF_GUD_PROPERTY_ROTATION)
            property.value = LF_GUD_ROTATE_0; /* what was listed is the set of what it can do */
        if (known_property(property.id))
            state->properties[state->n_properties++] = property;
    }
    return LF_OK;
}

void lf_gud_property_write(const lf_gud_property *property, uint8_t out[LF_GUD_PROPERTY_BYTES])
{
    write16(out, property->id);
    write64(out + 2, property->value);
}

/* ------------------------------------------------------------------------------------- modes -- */

static lf_gud_mode mode_read(const uint8_t *p)
{
    return (lf_gud_mode){
        .clock_khz = read32(p),
        .hdisplay = read16(p + 4),
        .hsync_start = read16(p + 6),
        .hsync_end = read16(p + 8),
        .htotal = read16(p + 10),
        .vdisplay = read16(p + 12),
        .vsync_start = read16(p + 14),
        .vsync_end = read16(p + 16),
        .vtotal = read16(p + 18),
        .flags = read32(p + 20),
    };
}

void lf_gud_mode_write(const lf_gud_mode *mode, uint8_t out[LF_GUD_MODE_BYTES])
{
    write32(out, mode->clock_khz);
    write16(out + 4, mode->hdisplay);
    write16(out + 6, mode->hsync_start);
    write16(out + 8, mode->hsync_end);
    write16(out + 10, mode->htotal);
    write16(out + 12, mode->vdisplay);
    write16(out + 14, mode->vsync_start);
    write16(out + 16, mode->vsync_end);
    write16(out + 18, mode->vtotal);
    write32(out + 20, mode->flags);
}

lf_status lf_gud_modes_read(const uint8_t *data, size_t n, lf_gud_mode out[LF_GUD_MAX_MODES],
                            int *out_n, lf_error *err)
{
    int count = 0;
    lf_status status = count_entries("modes", n, LF_GUD_MODE_BYTES, LF_GUD_MAX_MODES, &count, err);
    if (status != LF_OK)
        return status;
    for (int i = 0; i < count; i++)
        out[i] = mode_read(data + i * LF_GUD_MODE_BYTES);
    *out_n = count;
    return LF_OK;
}

bool lf_gud_mode_from_edid(const uint8_t *edid, size_t n, lf_gud_mode *out)
{
    lf_edid_timing t;
    if (!lf_edid_timing_read(edid, n, &t))
        return false;
    *out = (lf_gud_mode){
        .clock_khz = (uint32_t)t.clock_khz,
        .hdisplay = (uint16_t)t.width,
        .hsync_start = (uint16_t)(t.width + t.h_front),
        .hsync_end = (uint16_t)(t.width + t.h_front + t.h_sync),
        .htotal = (uint16_t)(t.width + t.h_blank),
        .vdisplay = (uint16_t)t.height,
        .vsync_start = (uint16_t)(t.height + t.v_front),
        .vsync_end = (uint16_t)(t.height + t.v_front + t.v_sync),
        .vtotal = (uint16_t)(t.height + t.v_blank),
        .flags = LF_GUD_MODE_PREFERRED,
    };
    return true;
}

static bool usable(const lf_gud_descriptor *d, const lf_gud_mode *m)
{
    return m->hdisplay >= 1 && m->hdisplay <= LF_MAX_SIDE && m->vdisplay >= 1 &&
           m->vdisplay <= LF_MAX_SIDE && m->hdisplay >= d->min_width &&
           m->hdisplay <= d->max_width && m->vdisplay >= d->min_height &&
           m->vdisplay <= d->max_height;
}

lf_status lf_gud_mode_choose(const lf_gud_descriptor *descriptor, const lf_gud_mode *modes, int n,
                             int width, int height, lf_gud_mode *out, lf_error *err)
{
    const lf_gud_mode *best = NULL, *any = NULL;
    for (int i = 0; i < n; i++) {
        const lf_gud_mode *m = &modes[i];
        if (!usable(descriptor, m))
            continue;
        if (!any)
            any = m;
        if ((width != 0 && m->hdisplay != width) || (height != 0 && m->vdisplay != height))
            continue;
        if (!best ||
            ((m->flags & LF_GUD_MODE_PREFERRED) != 0 && (best->flags & LF_GUD_MODE_PREFERRED) == 0))
            best = m;
    }
    if (best) {
        *out = *best;
        return LF_OK;
    }
    if (any)
        return lf_error_set(
            err, LF_E_ARG, WHERE,
            "the display has %dx%d pixels, but the calibration is for a panel of %dx%d",
            any->hdisplay, any->vdisplay, width, height);
    if (n == 0)
        return lf_error_set(err, LF_E_FORMAT, WHERE,
                            "the display has neither modes nor an EDID with a timing");
    return lf_error_set(
        err, LF_E_FORMAT, WHERE,
        "the display has no usable mode: the first is %dx%d, expected 1..%d within %ux%u to %ux%u",
        modes[0].hdisplay, modes[0].vdisplay, LF_MAX_SIDE, descriptor->min_width,
        descriptor->min_height, descriptor->max_width, descriptor->max_height);
}

/* ------------------------------------------------------------------------- what a host sends -- */

bool lf_gud_buffer_read(const uint8_t *data, size_t n, lf_gud_buffer *out)
{
    if (n != LF_GUD_BUFFER_BYTES)
        return false;
    *out = (lf_gud_buffer){
        .x = read32(data),
        .y = read32(data + 4),
        .width = read32(data + 8),
        .height = read32(data + 12),
        .length = read32(data + 16),
        .compression = data[20],
        .compressed_length = read32(data + 21),
    };
    return true;
}

void lf_gud_buffer_write(const lf_gud_buffer *buffer, uint8_t out[LF_GUD_BUFFER_BYTES])
{
    write32(out, buffer->x);
    write32(out + 4, buffer->y);
    write32(out + 8, buffer->width);
    write32(out + 12, buffer->height);
    write32(out + 16, buffer->length);
    out[20] = buffer->compression;
    write32(out + 21, buffer->compressed_length);
}

bool lf_gud_state_read(const uint8_t *data, size_t n, lf_gud_state *out)
{
    if (n < LF_GUD_STATE_BYTES || n > LF_GUD_STATE_MAX_BYTES ||
        (n - LF_GUD_STATE_BYTES) % LF_GUD_PROPERTY_BYTES != 0)
        return false;
    *out = (lf_gud_state){.mode = mode_read(data), .format = data[24], .connector = data[25]};
    for (const uint8_t *p = data + LF_GUD_STATE_BYTES; p < data + n; p += LF_GUD_PROPERTY_BYTES)
        out->properties[out->n_properties++] = (lf_gud_property){read16(p), read64(p + 2)};
    return true;
}

size_t lf_gud_state_write(const lf_gud_state *state, uint8_t out[LF_GUD_STATE_MAX_BYTES])
{
    assert(state->n_properties <= 2 * LF_GUD_MAX_PROPERTIES);
    lf_gud_mode_write(&state->mode, out);
    out[24] = state->format;
    out[25] = state->connector;
    uint8_t *p = out + LF_GUD_STATE_BYTES;
    for (int i = 0; i < state->n_properties; i++, p += LF_GUD_PROPERTY_BYTES)
        lf_gud_property_write(&state->properties[i], p);
    return (size_t)(p - out);
}

/* ------------------------------------------------------------------------------------ pixels -- */

/* v in 0..255 on a scale of max, to the nearest. */
static unsigned int narrow(unsigned int v, unsigned int max)
{
    return (v * max + 127) / 255;
}

static void write_row(lf_gud_format format, const uint8_t *rgb, int n, uint8_t *out)
{
    switch (format) {
    case LF_GUD_RGB888:
        for (int i = 0; i < n; i++, rgb += 3, out += 3) {
            out[0] = rgb[2];
            out[1] = rgb[1];
            out[2] = rgb[0];
        }
        break;
    case LF_GUD_XRGB8888:
        for (int i = 0; i < n; i++, rgb += 3, out += 4)
            write32(out, (uint32_t)(rgb[2] | rgb[1] << 8 | rgb[0] << 16));
        break;
    default:
        assert(format == LF_GUD_RGB565);
        for (int i = 0; i < n; i++, rgb += 3, out += 2)
            write16(out, (uint16_t)(narrow(rgb[0], 31) << 11 | narrow(rgb[1], 63) << 5 |
                                    narrow(rgb[2], 31)));
    }
}

void lf_gud_pixels_write(lf_gud_format format, const lf_image8 *frame, lf_rect rect, uint8_t *out)
{
    size_t pitch = (size_t)rect.width * (size_t)lf_gud_format_bytes(format);
    for (int y = rect.y; y < rect.y + rect.height; y++, out += pitch)
        write_row(format, frame->data + (size_t)y * frame->stride + (size_t)rect.x * 3, rect.width,
                  out);
}

void lf_gud_pixels_read(lf_gud_format format, const uint8_t *data, size_t n, uint8_t *out_rgb)
{
    size_t step = (size_t)lf_gud_format_bytes(format);
    for (size_t i = 0; i < n; i++, data += step, out_rgb += 3) {
        if (format == LF_GUD_RGB565) {
            unsigned int r = data[1] >> 3, g = read16(data) >> 5 & 63, b = data[0] & 31;
            out_rgb[0] = (uint8_t)(r << 3 | r >> 2);
            out_rgb[1] = (uint8_t)(g << 2 | g >> 4);
            out_rgb[2] = (uint8_t)(b << 3 | b >> 2);
        } else {
            out_rgb[0] = data[2];
            out_rgb[1] = data[1];
            out_rgb[2] = data[0];
        }
    }
}
