/* EDID: what a monitor says of itself (VESA E-EDID A2). Only what finding a Looking Glass takes:
 * its name, serial number and native mode. The bytes come from outside and are trusted with
 * nothing. */
#ifndef LF_DEVICE_EDID_H
#define LF_DEVICE_EDID_H

#include <stdint.h>

#include "base/status.h"

typedef struct lf_edid {
    char name[16]; /* descriptor 0xfc, sanitised, trailing blanks off; "LKG…" on a Looking Glass;
                      empty = none */
    char serial[16];         /* descriptor 0xff, likewise */
    int width_px, height_px; /* of the preferred timing; 0 = none */
} lf_edid;

/* A detailed timing (VESA E-EDID A2 3.10.2). Horizontal numbers in pixels, vertical ones in lines;
 * blank is all that is not shown, front and sync are parts of it, but nobody has checked that they
 * fit. */
typedef struct lf_edid_timing {
    int clock_khz;
    int width, h_front, h_sync, h_blank;
    int height, v_front, v_sync, v_blank;
} lf_edid_timing;

/* n: a multiple of 128. LF_E_FORMAT: too short, wrong header or checksum of the first block; *out
 * is untouched then. Blocks behind the first are not read. */
LF_NODISCARD lf_status lf_edid_parse(const uint8_t *edid, size_t n, lf_edid *out, lf_error *err);
/* The preferred timing; false when there is none, or one without clock or size. n may be anything,
 * and nothing else is looked at. */
bool lf_edid_timing_read(const uint8_t *edid, size_t n, lf_edid_timing *out);
/* True when the name is a Looking Glass's (looking-glass.md 1.3). */
bool lf_edid_is_panel(const lf_edid *edid);

#endif
