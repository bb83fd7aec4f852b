/* Any bytes, as they are and with header and checksum put right, so that what lies behind those
 * checks is reached. */
#include "tests/fuzz/fuzz.h"

#include <string.h>

#include "device/find/edid.h"

enum { BLOCK = 128 };

static void parse(const uint8_t *data, size_t size)
{
    lf_edid e = {0};
    lf_error err = {0};
    if (lf_edid_parse(data, size, &e, &err) != LF_OK) {
        lf_fuzz_require_text(err.what);
        return;
    }
    lf_fuzz_require(e.width_px >= 0 && e.width_px < 4096 && e.height_px >= 0 && e.height_px < 4096);
    lf_fuzz_require_text(e.name);
    lf_fuzz_require_text(e.serial);
    lf_edid_is_panel(&e);
}

static void mend(uint8_t block[BLOCK])
{
    static const uint8_t header[8] = {0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0};
    unsigned sum = 0;
    memcpy(block, header, sizeof header);
    for (int i = 0; i < BLOCK - 1; i++)
        sum += block[i];
    block[BLOCK - 1] = (uint8_t)(256 - sum % 256);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t block[BLOCK];
    parse(data, size);
    if (size < BLOCK)
        return 0;
    memcpy(block, data, BLOCK);
    mend(block);
    parse(block, BLOCK);
    return 0;
}
