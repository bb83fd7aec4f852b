#include "device/find/edid.h"

#include <string.h>

#include "device/device_table.h"

/* VESA E-EDID A2, section 3: a block of 128 bytes, four descriptors of 18 bytes from byte 54 on. */
enum {
    BLOCK = 128,
    DESCRIPTORS_AT = 54,
    DESCRIPTOR = 18,
    N_DESCRIPTORS = 4,
    TEXT_AT = 5,
    TEXT = 13
};
enum { TAG_SERIAL = 0xff, TAG_NAME = 0xfc };

/* Text of a descriptor: ends at a line feed, padded with blanks. Bytes beyond ASCII are in a code
 * page that no panel uses. */
static void take_text(const uint8_t *descriptor, char out[16])
{
    char text[TEXT + 1] = {0};
    memcpy(text, descriptor + TEXT_AT, TEXT);
    text[strcspn(text, "\n")] = 0;
    size_t n = strlen(text);
    while (n > 0 && text[n - 1] == ' ')
        text[--n] = 0;
    lf_device_text(out, 16, text);
}

static lf_status check_block(const uint8_t *edid, size_t n, lf_error *err)
{
    static const uint8_t header[8] = {0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0};
    if (n < BLOCK || n % BLOCK != 0)
        return lf_error_set(err, LF_E_FORMAT, "EDID", "%zu bytes, expected a multiple of %d", n,
                            BLOCK);
    if (memcmp(edid, header, sizeof header) != 0)
        return lf_error_set(err, LF_E_FORMAT, "EDID", "does not begin with the header of an EDID");
    unsigned sum = 0;
    for (int i = 0; i < BLOCK; i++)
        sum += edid[i];
    if (sum % 256 != 0)
        return lf_error_set(
            err, LF_E_FORMAT, "EDID",
            "wrong checksum: the bytes of a block add up to %u, expected a multiple of 256", sum);
    return LF_OK;
}

lf_status lf_edid_parse(const uint8_t *edid, size_t n, lf_edid *out, lf_error *err)
{
    lf_status status = check_block(edid, n, err);
    if (status != LF_OK)
        return status;
    lf_edid found = {0};
    lf_edid_timing preferred;
    if (lf_edid_timing_read(edid, n, &preferred)) {
        found.width_px = preferred.width;
        found.height_px = preferred.height;
    }
    for (int i = 0; i < N_DESCRIPTORS; i++) {
        const uint8_t *d = edid + DESCRIPTORS_AT + i * DESCRIPTOR;
        bool timing = d[0] != 0 || d[1] != 0;
        if (!timing && d[3] == TAG_NAME)
            take_text(d, found.name);
        else if (!timing && d[3] == TAG_SERIAL)
            take_text(d, found.serial);
    }
    *out = found;
    return LF_OK;
}

bool lf_edid_timing_read(const uint8_t *edid, size_t n, lf_edid_timing *out)
{
    if (n < BLOCK)
        return false;
    const uint8_t *t = edid + DESCRIPTORS_AT; /* the first descriptor is the preferred timing */
    lf_edid_timing timing = {
        .clock_khz = (t[0] | t[1] << 8) * 10,
        .width = t[2] | (t[4] & 0xf0) << 4,
        .h_front = t[8] | (t[11] & 0xc0) << 2,
        .h_sync = t[9] | (t[11] & 0x30) << 4,
        .h_blank = t[3] | (t[4] & 0x0f) << 8,
        .height = t[5] | (t[7] & 0xf0) << 4,
        .v_front = t[10] >> 4 | (t[11] & 0x0c) << 2,
        .v_sync = (t[10] & 0x0f) | (t[11] & 0x03) << 4,
        .v_blank = t[6] | (t[7] & 0x0f) << 8,
    };
    if (timing.clock_khz == 0 || timing.width == 0 || timing.height == 0)
        return false;
    *out = timing;
    return true;
}

bool lf_edid_is_panel(const lf_edid *edid)
{
    return strncmp(edid->name, "LKG", 3) == 0;
}
