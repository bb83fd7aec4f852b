/* EDID: a monitor's description of itself (VESA E-EDID A2). Only the parts needed to find a Looking
 * Glass: name, serial number and native mode. The bytes are untrusted. */
#ifndef LF_DEVICE_EDID_H
#define LF_DEVICE_EDID_H

#include <stdint.h>

#include "base/status.h"

typedef struct lf_edid {
    char name[16];   /* descriptor 0xfc, sanitised, without trailing blanks; "LKG…" on a Looking
                      * Glass; empty = none */
    char serial[16]; /* descriptor 0xff, likewise */
    int width_px, height_px; /* from the preferred timing; 0 = none */
} lf_edid;

/* A detailed timing (VESA E-EDID A2 3.10.2). Horizontal numbers in pixels, vertical ones in lines.
 * blank is everything that is not shown, including front and sync. The numbers are not checked for
 * consistency. */
typedef struct lf_edid_timing {
    int clock_khz;
    int width, h_front, h_sync, h_blank;
    int height, v_front, v_sync, v_blank;
} lf_edid_timing;

/* n: a multiple of 128. LF_E_FORMAT: too short, or wrong header or checksum of the first block;
 * *out is then untouched. Later blocks are not read. */
LF_NODISCARD lf_status lf_edid_parse(const uint8_t *edid, size_t n, lf_edid *out, lf_error *err);
/* The preferred timing; false: none, or one without clock or size. n may be any number; nothing
 * else is checked. */
bool lf_edid_timing_read(const uint8_t *edid, size_t n, lf_edid_timing *out);
/* True if the name is that of a Looking Glass: it starts with "LKG". */
bool lf_edid_is_panel(const lf_edid *edid);

#endif
