/* EDID: what a monitor says of itself (VESA E-EDID A2). Only what finding a Looking Glass takes: its name, serial number and native
 * mode. The bytes come from outside and are trusted with nothing. */
#ifndef LF_DEVICE_EDID_H
#define LF_DEVICE_EDID_H

#include <stdint.h>

#include "base/status.h"

typedef struct lf_edid {
    char name[16];           /* descriptor 0xfc, sanitised, trailing blanks off; "LKG…" on a Looking Glass; empty = none */
    char serial[16];         /* descriptor 0xff, likewise */
    int width_px, height_px; /* of the preferred timing; 0 = none */
} lf_edid;

/* n: a multiple of 128. LF_E_FORMAT: too short, wrong header or checksum of the first block; *out is untouched then. Blocks behind the
 * first are not read. */
LF_NODISCARD lf_status lf_edid_parse(const uint8_t *edid, size_t n, lf_edid *out, lf_error *err);
/* True when the name is a Looking Glass's (looking-glass.md 1.3). */
bool lf_edid_is_panel(const lf_edid *edid);

#endif
