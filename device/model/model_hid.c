#include <assert.h>
#include <errno.h>
#include <string.h>

#include "base/alloc.h"
#include "device/model/model.h"

/* The kernel's queue length for a reader of hidraw; when it is full the newest are dropped. */
#define MAX_PACKETS 64
#define SPLIT_AT 64
#define SHORT_REPLY 10
#define ECHO 1 /* offset of the request's echo in a reply */
#define DATA 4

typedef struct packet {
    size_t n;
    uint8_t data[LF_MODEL_INPUT];
} packet;

struct lf_model_hid {
    lf_model_hid_faults faults;
    uint8_t buttons;
    uint8_t reply[LF_MODEL_INPUT]; /* the last reply, repeated in button reports */
    int requests, replies;
    uint64_t violations;
    int first, n_packets;
    packet packets[MAX_PACKETS];
    uint8_t eeprom[LF_MODEL_EEPROM_MAX];
};

lf_status lf_model_hid_create(const void *eeprom, size_t n, const lf_model_hid_faults *faults,
                              lf_model_hid **out)
{
    if (n > LF_MODEL_EEPROM_MAX)
        return LF_E_ARG;
    lf_model_hid *hid = lf_calloc(1, sizeof *hid);
    if (!hid)
        return LF_E_NOMEM;
    memset(hid->eeprom, 0xff, sizeof hid->eeprom);
    if (n > 0)
        memcpy(hid->eeprom, eeprom, n);
    if (faults)
        hid->faults = *faults;
    *out = hid;
    return LF_OK;
}

size_t lf_model_hid_eeprom(const char *json, size_t n, uint8_t *out, size_t max)
{
    if (max < 4 || n > max - 4)
        return 0;
    for (int i = 0; i < 4; i++)
        out[i] = (uint8_t)(n >> (24 - 8 * i));
    memcpy(out + 4, json, n);
    return n + 4;
}

void lf_model_hid_destroy(lf_model_hid *hid)
{
    lf_free(hid);
}

static void queue_packet(lf_model_hid *hid, const uint8_t *data, size_t n)
{
    if (hid->n_packets == MAX_PACKETS)
        return;
    packet *p = &hid->packets[(hid->first + hid->n_packets++) % MAX_PACKETS];
    p->n = n;
    memcpy(p->data, data, n);
}

static void queue_report(lf_model_hid *hid, const uint8_t *report, size_t n)
{
    if (hid->faults.split && n > SPLIT_AT) {
        queue_packet(hid, report, SPLIT_AT);
        queue_packet(hid, report + SPLIT_AT, n - SPLIT_AT);
    } else {
        queue_packet(hid, report, n);
    }
}

static bool every(int n, int count)
{
    return n > 0 && count % n == 0;
}

static void fill_reply(const lf_model_hid *hid, unsigned page, uint8_t reply[LF_MODEL_INPUT])
{
    unsigned echo = hid->faults.wrong_echo ? page ^ 0x8000u : page;
    memset(reply, 0xff, LF_MODEL_INPUT);
    reply[0] = hid->buttons;
    reply[ECHO] = 0;
    reply[ECHO + 1] = (uint8_t)(echo >> 8);
    reply[ECHO + 2] = (uint8_t)echo;
    if (page < LF_MODEL_EEPROM_MAX / LF_MODEL_PAGE)
        memcpy(reply + DATA, hid->eeprom + (size_t)page * LF_MODEL_PAGE, LF_MODEL_PAGE);
}

static void answer(lf_model_hid *hid, unsigned page)
{
    uint8_t stale[LF_MODEL_INPUT];
    hid->replies++;
    fill_reply(hid, (page - 1) & 0xffff, stale);
    for (int i = 0; i < hid->faults.stale; i++)
        queue_report(hid, stale, sizeof stale);
    if (every(hid->faults.press_every, hid->replies))
        lf_model_hid_press(hid, hid->buttons ^ 1);
    fill_reply(hid, page, hid->reply);
    queue_report(hid, hid->reply,
                 every(hid->faults.short_every, hid->replies) ? SHORT_REPLY : LF_MODEL_INPUT);
}

/* True if this is exactly the page read of the known readers. */
static bool is_page_request(const uint8_t *data, size_t n)
{
    if (n != LF_MODEL_FEATURE || data[0] != 0)
        return false;
    for (size_t i = 3; i < n; i++)
        if (data[i] != 0)
            return false;
    return true;
}

int lf_model_hid_feature(lf_model_hid *hid, const uint8_t *data, size_t n)
{
    if (!is_page_request(data, n)) {
        hid->violations++;
        return -EPIPE;
    }
    hid->requests++;
    if (every(hid->faults.stall_every, hid->requests))
        return -EPIPE;
    if (!every(hid->faults.mute_every, hid->requests))
        answer(hid, (unsigned)data[1] << 8 | data[2]);
    return (int)n;
}

int lf_model_hid_input(lf_model_hid *hid, uint8_t *out, size_t max)
{
    if (hid->n_packets == 0)
        return -EAGAIN;
    packet *p = &hid->packets[hid->first];
    size_t n = p->n < max ? p->n : max;
    memcpy(out, p->data, n);
    p->n -= n;
    memmove(p->data, p->data + n, p->n);
    if (p->n == 0) {
        hid->first = (hid->first + 1) % MAX_PACKETS;
        hid->n_packets--;
    }
    return (int)n;
}

void lf_model_hid_press(lf_model_hid *hid, uint8_t buttons)
{
    hid->buttons = buttons;
    hid->reply[0] = buttons;
    queue_report(hid, hid->reply, sizeof hid->reply);
}

uint64_t lf_model_hid_violations(const lf_model_hid *hid)
{
    return hid->violations;
}
