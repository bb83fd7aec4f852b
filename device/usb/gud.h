/* The Generic USB Display (GUD) protocol, version 1: its numbers, and conversion of its structures
 * to and from bytes on the wire. Source: include/drm/gud.h of Linux. Host and simulated display
 * share only this header. Readers get data of an unknown device or host and check lengths, counts
 * and magic numbers. Bytes are little-endian and unpadded.
 *
 * Threads: any; no state. Readers leave their outputs untouched on failure. Private to device/ and
 * its tests. */
#ifndef LF_DEVICE_GUD_H
#define LF_DEVICE_GUD_H

#include <stdint.h>

#include "base/image.h"

/* Limits on the lists of a device, and the size of one entry in bytes. */
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
    LF_GUD_STATE_BYTES = 26, /* plus LF_GUD_PROPERTY_BYTES per property */
    LF_GUD_STATE_MAX_BYTES = LF_GUD_STATE_BYTES + 2 * LF_GUD_MAX_PROPERTIES * LF_GUD_PROPERTY_BYTES,
};

/* bRequest. wValue is the connector's index for connector requests, otherwise 0. */
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

/* GET_STATUS: the result of the last request. */
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
    LF_GUD_FLAG_STATUS_ON_SET = 1 << 0, /* GET_STATUS after every set request returns its result */
    /* whole frames only, never compressed; SET_BUFFER announces them only after a failure */
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

/* The content of the next bulk transfers. */
typedef struct lf_gud_buffer {
    uint32_t x, y, width, height;
    uint32_t length; /* bytes before compression */
    /* 0, or LF_GUD_COMPRESSION_LZ4: a block without frame header */
    uint8_t compression;
    uint32_t compressed_length; /* 0 when not compressed */
} lf_gud_buffer;

typedef struct lf_gud_state {
    lf_gud_mode mode;
    uint8_t format, connector;
    int n_properties;
    lf_gud_property properties[2 * LF_GUD_MAX_PROPERTIES];
} lf_gud_state;

/* The name of a format, "RGB888"; "none" for formats that quiltd cannot send. */
const char *lf_gud_format_name(lf_gud_format format);
/* Bytes per pixel; 0 for formats that quiltd cannot send. */
int lf_gud_format_bytes(lf_gud_format format);
/* A status in words, "busy"; "an unknown status" for numbers outside the list. */
const char *lf_gud_status_text(uint8_t status);

/* -------------------------------------------------------------- what a device says of itself -- */

/* LF_E_FORMAT: not 30 bytes, wrong magic or version, FULL_UPDATE together with compression, minimum
 * size above the maximum. */
LF_NODISCARD lf_status lf_gud_descriptor_read(const uint8_t *data, size_t n, lf_gud_descriptor *out,
                                              lf_error *err);
void lf_gud_descriptor_write(const lf_gud_descriptor *descriptor,
                             uint8_t out[LF_GUD_DESCRIPTOR_BYTES]);

/* The best listed format: RGB888 (exact and smallest), XRGB8888, RGB565. LF_E_FORMAT: none of them,
 * or more than the protocol allows. */
LF_NODISCARD lf_status lf_gud_formats_choose(const uint8_t *data, size_t n, lf_gud_format *out,
                                             lf_error *err);

/* The number of connectors in data[n]. LF_E_FORMAT: none, too many, or an incomplete one. */
LF_NODISCARD lf_status lf_gud_connectors_count(const uint8_t *data, size_t n, int *out_n,
                                               lf_error *err);

/* Appends the properties that quiltd knows to state, with their current values (rotation: none).
 * LF_E_FORMAT as above. */
LF_NODISCARD lf_status lf_gud_properties_read(const uint8_t *data, size_t n, lf_gud_state *state,
                                              lf_error *err);

/* Decodes at most LF_GUD_MAX_MODES modes without checking them. LF_E_FORMAT: too many, or an
 * incomplete one. */
LF_NODISCARD lf_status lf_gud_modes_read(const uint8_t *data, size_t n,
                                         lf_gud_mode out[LF_GUD_MAX_MODES], int *out_n,
                                         lf_error *err);
void lf_gud_mode_write(const lf_gud_mode *mode, uint8_t out[LF_GUD_MODE_BYTES]);
/* The preferred timing of an EDID (lf_edid_timing_read) as a mode; false: none. */
bool lf_gud_mode_from_edid(const uint8_t *edid, size_t n, lf_gud_mode *out);

/* Chooses a mode of this size, or of any size if width and height are 0: the preferred one first,
 * then the first listed. Only modes within the descriptor's limits and 1..LF_MAX_SIDE are usable.
 * LF_E_FORMAT: no usable mode; LF_E_ARG: usable ones, but none of this size. */
LF_NODISCARD lf_status lf_gud_mode_choose(const lf_gud_descriptor *descriptor,
                                          const lf_gud_mode *modes, int n, int width, int height,
                                          lf_gud_mode *out, lf_error *err);

/* ------------------------------------------------------------------------- what a host sends -- */

/* False: not 25 bytes. */
bool lf_gud_buffer_read(const uint8_t *data, size_t n, lf_gud_buffer *out);
void lf_gud_buffer_write(const lf_gud_buffer *buffer, uint8_t out[LF_GUD_BUFFER_BYTES]);
/* False: not a state, or incomplete properties. */
bool lf_gud_state_read(const uint8_t *data, size_t n, lf_gud_state *out);
/* Returns the bytes written. */
size_t lf_gud_state_write(const lf_gud_state *state, uint8_t out[LF_GUD_STATE_MAX_BYTES]);
void lf_gud_property_write(const lf_gud_property *property, uint8_t out[LF_GUD_PROPERTY_BYTES]);

/* ------------------------------------------------------------------------------------ pixels -- */

/* Converts rect of an RGB frame to `format`, rows packed, into out[rect.width * rect.height *
 * bytes]. RGB565 rounds to nearest. */
void lf_gud_pixels_write(lf_gud_format format, const lf_image8 *frame, lf_rect rect, uint8_t *out);
/* Converts n pixels back to r, g, b bytes; RGB565 is widened by repeating its high bits. */
void lf_gud_pixels_read(lf_gud_format format, const uint8_t *data, size_t n, uint8_t *out_rgb);

#endif
