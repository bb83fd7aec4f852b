#include "device/hid/hid.h"

#include <assert.h>
#include <string.h>

/* A reader of hidraw finds at most 64 reports waiting; a device that fills them faster than they
 * are read is not waited for. */
#define MAX_REPORTS 256

enum { COMMAND_READ_PAGE = 0 };
/* Offsets in a request (behind the report number) and in a reply (behind the buttons): the echo is
 * at the same place. */
enum { COMMAND_AT = 1, PAGE_HIGH_AT = 2, PAGE_LOW_AT = 3, DATA_AT = 4, LENGTH_BYTES = 4 };

const lf_hid_patience lf_hid_patient = {
    .reply_ms = 1000, .rest_ms = 10, .attempts = 3, .total_ms = 4000};

/* A reading under way. */
typedef struct reading {
    const lf_hid_link *link;
    const lf_hid_patience *patience;
    const char *where;
    uint64_t end_ms;
    lf_error *err;
} reading;

static uint64_t now_ms(const lf_hid_link *link)
{
    return link->now_ms(link->context);
}

static int until(const lf_hid_link *link, uint64_t end_ms)
{
    uint64_t now = now_ms(link);
    return now < end_ms ? (int)(end_ms - now) : 0;
}

int lf_hid_read_report(const lf_hid_link *link, int timeout_ms, int rest_ms,
                       uint8_t out[LF_HID_REPORT])
{
    uint8_t part[LF_HID_REPORT];
    size_t have = 0;
    uint64_t end = 0; /* of the rest */
    for (int parts = 0; parts < LF_HID_REPORT; parts++) {
        int n = link->read(link->context, part, sizeof part,
                           parts == 0 ? timeout_ms : until(link, end));
        if (n <= 0)
            return n < 0 ? -1 : 0;
        assert((size_t)n <= sizeof part);
        if (parts == 0)
            end = now_ms(link) + (uint64_t)rest_ms;
        if (have + (size_t)n > LF_HID_REPORT)
            have = 0; /* what came before was the torso of another report */
        memcpy(out + have, part, (size_t)n);
        have += (size_t)n;
        if (have == LF_HID_REPORT)
            return 1;
    }
    return 0;
}

static lf_status gone(const reading *r)
{
    return lf_error_set(r->err, LF_E_NODEV, r->where,
                        "the panel was unplugged while quiltd read its calibration");
}

/* What was asked before, by whomever, and buttons. */
static lf_status flush(const reading *r)
{
    uint8_t dropped[LF_HID_REPORT];
    for (int i = 0; i < MAX_REPORTS; i++) {
        int n = r->link->read(r->link->context, dropped, sizeof dropped, 0);
        if (n < 0)
            return gone(r);
        if (n == 0)
            break;
    }
    return LF_OK;
}

static bool send_request(const reading *r, unsigned page)
{
    uint8_t report[LF_HID_FEATURE] = {0};
    report[COMMAND_AT] = COMMAND_READ_PAGE;
    report[PAGE_HIGH_AT] = (uint8_t)(page >> 8);
    report[PAGE_LOW_AT] = (uint8_t)page;
    return r->link->send(r->link->context, report, sizeof report) >= 0;
}

static bool echoes(const uint8_t report[LF_HID_REPORT], unsigned page)
{
    return report[COMMAND_AT] == COMMAND_READ_PAGE && report[PAGE_HIGH_AT] == page >> 8 &&
           report[PAGE_LOW_AT] == (page & 0xff);
}

/* Reads until a report answers the request: LF_OK, LF_E_TIMEOUT (no words yet), LF_E_NODEV. */
static lf_status await_page(const reading *r, unsigned page, uint8_t out[LF_HID_PAGE])
{
    uint8_t report[LF_HID_REPORT];
    uint64_t end = now_ms(r->link) + (uint64_t)r->patience->reply_ms;
    if (end > r->end_ms)
        end = r->end_ms;
    for (int i = 0; i < MAX_REPORTS; i++) {
        int got = lf_hid_read_report(r->link, until(r->link, end), r->patience->rest_ms, report);
        if (got < 0)
            return gone(r);
        if (got > 0 && echoes(report, page)) {
            memcpy(out, report + DATA_AT, LF_HID_PAGE);
            return LF_OK;
        }
        if (now_ms(r->link) >= end)
            break;
    }
    return LF_E_TIMEOUT;
}

static lf_status read_page(const reading *r, unsigned page, uint8_t out[LF_HID_PAGE])
{
    int refused = 0, tried = 0;
    for (; tried < r->patience->attempts && until(r->link, r->end_ms) > 0; tried++) {
        lf_status status = flush(r);
        if (status != LF_OK)
            return status;
        if (!send_request(r, page)) {
            refused++;
            continue;
        }
        status = await_page(r, page, out);
        if (status != LF_E_TIMEOUT)
            return status;
    }
    if (tried > 0 && refused == tried)
        return lf_error_set(r->err, LF_E_IO, r->where,
                            "the panel refused to send calibration page %u; unplug its USB cable "
                            "and plug it in again",
                            page);
    return lf_error_set(
        r->err, LF_E_TIMEOUT, r->where,
        "the panel did not send calibration page %u; unplug its USB cable and plug it in again",
        page);
}

/* The length before the text: big-endian, not counting itself. */
static lf_status take_length(const reading *r, const uint8_t page[LF_HID_PAGE], size_t *out)
{
    uint32_t n =
        (uint32_t)page[0] << 24 | (uint32_t)page[1] << 16 | (uint32_t)page[2] << 8 | page[3];
    if (n == UINT32_MAX)
        return lf_error_set(
            r->err, LF_E_FORMAT, r->where,
            "the panel's EEPROM is blank; pass the panel's visual.json with --calibration");
    if (n == 0 || n > LF_HID_MAX_JSON)
        return lf_error_set(r->err, LF_E_FORMAT, r->where,
                            "the panel's EEPROM is damaged (a calibration of %ju bytes, expected 1 "
                            "to %d); pass the panel's visual.json with --calibration",
                            (uintmax_t)n, LF_HID_MAX_JSON);
    *out = n;
    return LF_OK;
}

static lf_status read_text(const reading *r, char out[LF_HID_MAX_JSON], size_t *out_n)
{
    uint8_t page[LF_HID_PAGE];
    size_t n = 0, have = LF_HID_PAGE - LENGTH_BYTES;
    lf_status status = read_page(r, 0, page);
    if (status == LF_OK)
        status = take_length(r, page, &n);
    if (status != LF_OK)
        return status;
    if (have > n)
        have = n;
    memcpy(out, page + LENGTH_BYTES, have);
    for (unsigned number = 1; have < n; number++) {
        status = read_page(r, number, page);
        if (status != LF_OK)
            return status;
        size_t take = n - have < LF_HID_PAGE ? n - have : LF_HID_PAGE;
        memcpy(out + have, page, take);
        have += take;
    }
    *out_n = n;
    return LF_OK;
}

static lf_status read_once(const reading *r, lf_calibration *out)
{
    char text[LF_HID_MAX_JSON];
    size_t n = 0;
    lf_error why = {0};
    lf_status status = read_text(r, text, &n);
    if (status != LF_OK)
        return status;
    status = lf_calibration_parse(text, n, r->where, out, &why);
    if (status == LF_OK)
        return LF_OK;
    return lf_error_set_at(r->err, status, r->where, why.line, why.pointer,
                           "the calibration in the panel's EEPROM is damaged: %.120s; pass the "
                           "panel's visual.json with --calibration",
                           why.what);
}

lf_status lf_hid_read_calibration(const lf_hid_link *link, const lf_hid_patience *patience,
                                  const char *where, lf_calibration *out, lf_error *err)
{
    lf_error why = {0};
    reading r = {link, patience, where, now_ms(link) + (uint64_t)patience->total_ms, &why};
    lf_status status = read_once(&r, out);
    if (status == LF_E_FORMAT)
        status = read_once(&r, out);
    if (status != LF_OK && err)
        *err = why;
    return status;
}
