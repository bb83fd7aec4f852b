/* The Generic USB Display protocol, version 1: its numbers, and its structures to and from the
 * bytes on the wire (usb.md 1). Host and simulated display share this page and nothing else. Every
 * reader gets what an unknown device (or host) sent and checks it: lengths, counts, magic numbers.
 * Bytes are little-endian and unpadded.
 *
 * Threads: any; nothing is kept. Readers leave their outputs untouched on failure. Private to
 * device/ and its tests. */
#ifndef LF_DEVICE_GUD_H
#define LF_DEVICE_GUD_H

#include <stdint.h>

#include "base/image.h"

/* Most of what a device may list, and the sizes of one entry in bytes. */
enum {
    LF_GUD_MAX_FORMATS = 32,
    LF_GUD_MAX_PROPERTIES = 32,
    LF_GUD_MAX_CONNECTORS = 32,
    LF_GUD_MAX_MODES = 128,
    LF_GUD_MAX_EDID = 2048,
    LF_GUD_DESCRIPTOR_BYTES = 30,
    LF_GUD_PROPERTY_BYTES = 10,
    LF_GUD_CONNECTOR_BYTES = 5,
    LF_GUD_MODE_BYTES = 24,
    LF_GUD_BUFFER_BYTES = 25,
    LF_GUD_STATE_BYTES = 26, /* and LF_GUD_PROPERTY_BYTES a property */
    LF_GUD_STATE_MAX_BYTES = LF_GUD_STATE_BYTES + 2 * LF_GUD_MAX_PROPERTIES * LF_GUD_PROPERTY_BYTES,
};

/* bRequest. wValue is the connector's index for those of connectors, else 0. */
typedef enum lf_gud_request {
    LF_GUD_GET_STATUS = 0x00,
    LF_GUD_GET_DESCRIPTOR = 0x01,
    LF_GUD_GET_FORMATS = 0x40,
    LF_GUD_GET_PROPERTIES = 0x41,
    LF_GUD_GET_CONNECTORS = 0x50,
    LF_GUD_GET_CONNECTOR_PROPERTIES = 0x51,
    LF_GUD_GET_CONNECTOR_TV_MODE_VALUES = 0x52,
    LF_GUD_SET_CONNECTOR_FORCE_DETECT = 0x53,
    LF_GUD_GET_CONNECTOR_STATUS = 0x54,
    LF_GUD_GET_CONNECTOR_MODES = 0x55,
    LF_GUD_GET_CONNECTOR_EDID = 0x56,
    LF_GUD_SET_BUFFER = 0x60,
    LF_GUD_SET_STATE_CHECK = 0x61,
    LF_GUD_SET_STATE_COMMIT = 0x62,
    LF_GUD_SET_CONTROLLER_ENABLE = 0x63,
    LF_GUD_SET_DISPLAY_ENABLE = 0x64,
} lf_gud_request;

/* What GET_STATUS says of the last request. */
typedef enum lf_gud_status {
    LF_GUD_STATUS_OK,
    LF_GUD_STATUS_BUSY,
    LF_GUD_STATUS_NOT_SUPPORTED,
    LF_GUD_STATUS_PROTOCOL_ERROR,
    LF_GUD_STATUS_INVALID_PARAMETER,
    LF_GUD_STATUS_ERROR,
    LF_GUD_STATUSES,
} lf_gud_status;

enum {
    LF_GUD_FLAG_STATUS_ON_SET = 1 << 0, /* GET_STATUS after every set tells whether it worked */
    /* whole frames, announced by SET_BUFFER only after a failure; never compressed */
    LF_GUD_FLAG_FULL_UPDATE = 1 << 1,
    LF_GUD_COMPRESSION_LZ4 = 1 << 0,
    LF_GUD_MODE_PREFERRED = 1 << 10,
    LF_GUD_CONNECTOR_STATUS_MASK = 3,
    LF_GUD_DISCONNECTED = 0,
    LF_GUD_CONNECTED = 1,
    LF_GUD_PROPERTY_BACKLIGHT = 12,
    LF_GUD_PROPERTY_ROTATION = 50,
    LF_GUD_ROTATE_0 = 1,
};

/* Pixel formats that quiltd can send; rows are packed without padding. */
typedef enum lf_gud_format {
    LF_GUD_NO_FORMAT = 0,
    LF_GUD_RGB565 = 0x40,
    LF_GUD_RGB888 = 0x50, /* bytes B, G, R */
    LF_GUD_XRGB8888 = 0x80,
} lf_gud_format;

typedef struct lf_gud_descriptor {
    uint8_t version; /* 1 */
    uint32_t flags;
    uint8_t compression;      /* LF_GUD_COMPRESSION_… */
    uint32_t max_buffer_size; /* bytes; 0 = no limit */
    uint32_t min_width, max_width, min_height, max_height;
} lf_gud_descriptor;

typedef struct lf_gud_mode {
    uint32_t clock_khz;
    uint16_t hdisplay, hsync_start, hsync_end, htotal;
    uint16_t vdisplay, vsync_start, vsync_end, vtotal;
    uint32_t flags;
} lf_gud_mode;

typedef struct lf_gud_property {
    uint16_t id;
    uint64_t value;
} lf_gud_property;

/* What the next bulk transfers carry. */
typedef struct lf_gud_buffer {
    uint32_t x, y, width, height;
    uint32_t length; /* bytes before compression */
    /* 0, or LF_GUD_COMPRESSION_LZ4: a block without a frame around it */
    uint8_t compression;
    uint32_t compressed_length; /* 0 when not compressed */
} lf_gud_buffer;

typedef struct lf_gud_state {
    lf_gud_mode mode;
    uint8_t format, connector;
    int n_properties;
    lf_gud_property properties[2 * LF_GUD_MAX_PROPERTIES];
} lf_gud_state;

/* The name of a format, "RGB888"; "none" for what quiltd cannot send. */
const char *lf_gud_format_name(lf_gud_format format);
/* Bytes a pixel; 0 for what quiltd cannot send. */
int lf_gud_format_bytes(lf_gud_format format);
/* A status in words, "busy"; "an unknown status" beyond the list. */
const char *lf_gud_status_text(uint8_t status);

/* -------------------------------------------------------------- what a device says of itself -- */

/* LF_E_FORMAT: not 30 bytes, wrong magic or version, FULL_UPDATE together with compression, least
 * size above the greatest. */
LF_NODISCARD lf_status lf_gud_descriptor_read(const uint8_t *data, size_t n, lf_gud_descriptor *out,
                                              lf_error *err);
void lf_gud_descriptor_write(const lf_gud_descriptor *descriptor,
                             uint8_t out[LF_GUD_DESCRIPTOR_BYTES]);

/* The best listed format: RGB888 (exact and smallest), XRGB8888, RGB565. LF_E_FORMAT: none of them,
 * or more than the protocol allows. */
LF_NODISCARD lf_status lf_gud_formats_choose(const uint8_t *data, size_t n, lf_gud_format *out,
                                             lf_error *err);

/* How many connectors data[n] lists. LF_E_FORMAT: none, too many, or a part of one. */
LF_NODISCARD lf_status lf_gud_connectors_count(const uint8_t *data, size_t n, int *out_n,
                                               lf_error *err);

/* Appends the properties that quiltd knows to state, with the values that they have (rotation:
 * none). LF_E_FORMAT as above. */
LF_NODISCARD lf_status lf_gud_properties_read(const uint8_t *data, size_t n, lf_gud_state *state,
                                              lf_error *err);

/* Decodes at most LF_GUD_MAX_MODES modes as they are, plausible or not. LF_E_FORMAT: too many, or a
 * part of one. */
LF_NODISCARD lf_status lf_gud_modes_read(const uint8_t *data, size_t n,
                                         lf_gud_mode out[LF_GUD_MAX_MODES], int *out_n,
                                         lf_error *err);
void lf_gud_mode_write(const lf_gud_mode *mode, uint8_t out[LF_GUD_MODE_BYTES]);
/* The preferred timing of an EDID (lf_edid_timing_read) as a mode, false when it has none. */
bool lf_gud_mode_from_edid(const uint8_t *edid, size_t n, lf_gud_mode *out);

/* The mode to show in: of this size, or of any when width and height are 0; the preferred one
 * first, then the first listed. A mode counts only when it lies within the descriptor's limits and
 * within 1..LF_MAX_SIDE. LF_E_FORMAT: no usable mode; LF_E_ARG: usable ones, but none of this size.
 */
LF_NODISCARD lf_status lf_gud_mode_choose(const lf_gud_descriptor *descriptor,
                                          const lf_gud_mode *modes, int n, int width, int height,
                                          lf_gud_mode *out, lf_error *err);

/* ------------------------------------------------------------------------- what a host sends -- */

/* False: not 25 bytes. */
bool lf_gud_buffer_read(const uint8_t *data, size_t n, lf_gud_buffer *out);
void lf_gud_buffer_write(const lf_gud_buffer *buffer, uint8_t out[LF_GUD_BUFFER_BYTES]);
/* False: not a state with whole properties. */
bool lf_gud_state_read(const uint8_t *data, size_t n, lf_gud_state *out);
/* Returns the bytes written. */
size_t lf_gud_state_write(const lf_gud_state *state, uint8_t out[LF_GUD_STATE_MAX_BYTES]);
void lf_gud_property_write(const lf_gud_property *property, uint8_t out[LF_GUD_PROPERTY_BYTES]);

/* ------------------------------------------------------------------------------------ pixels -- */

/* rect of an RGB frame in `format`, rows packed, into out[rect.width * rect.height * bytes]. RGB565
 * rounds to the nearest. */
void lf_gud_pixels_write(lf_gud_format format, const lf_image8 *frame, lf_rect rect, uint8_t *out);
/* n pixels back to r, g, b bytes; RGB565 widened by repeating its high bits. */
void lf_gud_pixels_read(lf_gud_format format, const uint8_t *data, size_t n, uint8_t *out_rgb);

#endif
