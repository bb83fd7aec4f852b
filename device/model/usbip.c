#include "device/model/usbip.h"

#include <assert.h>
#include <endian.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/thread.h"

enum {
    VERSION = 0x0111,
    OP_REQ_DEVLIST = 0x8005,
    OP_REP_DEVLIST = 0x0005,
    OP_REQ_IMPORT = 0x8003,
    OP_REP_IMPORT = 0x0003
};
enum { CMD_SUBMIT = 1, CMD_UNLINK = 2, RET_SUBMIT = 3, RET_UNLINK = 4 };
enum {
    OP_SIZE = 8,
    BUSID_SIZE = 32,
    RECORD_SIZE = 312,
    URB_HEADER = 48,
    MAX_INTERFACES = 8,
    NOT_ISO = -1
};
enum { MAX_IN = 65536, REPLY_MAX = URB_HEADER + MAX_IN, OUTPUT_SIZE = 4 * REPLY_MAX, ROUNDS = 256 };
#define NEVER UINT64_MAX

/* A request that waits for its answer, or for the rest of its own data. */
typedef struct urb {
    struct urb *next; /* the one that came after it */
    uint32_t seqnum, length;
    uint8_t endpoint; /* address with the direction bit; 0 for control in either direction */
    bool in;
    bool started;    /* the endpoint has begun with it: due_ns is set */
    bool dead;       /* the device never answers */
    uint64_t due_ns; /* when the device has taken the data */
    uint8_t setup[8];
    uint8_t data[]; /* OUT: [length] */
} urb;

/* What the next bytes from the peer are. */
typedef enum input_state {
    READ_OP,     /* the common header of the handshake */
    READ_BUSID,  /* the rest of an import request */
    READ_HEADER, /* a URB's header */
    READ_DATA,   /* the data of `incoming` */
    SKIP_DATA,   /* data of a URB that was refused */
    READ_NOTHING /* the last answer is on its way */
} input_state;

struct lf_usbip {
    lf_usbip_device *device; /* borrowed */
    int fd;
    bool holds; /* device->taken is by us */
    input_state state;
    uint8_t header[URB_HEADER];
    size_t n_read;  /* bytes of the header, or of the data of incoming */
    size_t to_skip; /* SKIP_DATA: bytes */
    urb *incoming;  /* READ_DATA */
    urb *first, **last;
    int n_urbs;
    size_t waiting; /* bytes of their data */
    uint64_t due_ns;
    size_t out_begin, out_end; /* of out, what is not sent yet */
    uint8_t out[OUTPUT_SIZE];
    uint8_t skipped[MAX_IN];
};

static uint32_t get32(const uint8_t *at)
{
    uint32_t v;
    memcpy(&v, at, sizeof v);
    return be32toh(v);
}

static void put32(uint8_t *at, uint32_t v)
{
    v = htobe32(v);
    memcpy(at, &v, sizeof v);
}

static void put16(uint8_t *at, unsigned v)
{
    at[0] = (uint8_t)(v >> 8);
    at[1] = (uint8_t)v;
}

/* ------------------------------------------------------------------------------------ output -- */

/* Room for one more answer of any kind? */
static bool has_room(const lf_usbip *usbip)
{
    return OUTPUT_SIZE - (usbip->out_end - usbip->out_begin) >= REPLY_MAX;
}

/* Where an answer is written to; put_end takes it. */
static uint8_t *put_begin(lf_usbip *usbip)
{
    assert(has_room(usbip));
    if (OUTPUT_SIZE - usbip->out_end < REPLY_MAX) {
        memmove(usbip->out, usbip->out + usbip->out_begin, usbip->out_end - usbip->out_begin);
        usbip->out_end -= usbip->out_begin;
        usbip->out_begin = 0;
    }
    return usbip->out + usbip->out_end;
}

static void put_end(lf_usbip *usbip, size_t n)
{
    assert(n <= REPLY_MAX);
    usbip->out_end += n;
}

static lf_status flush(lf_usbip *usbip, lf_error *err)
{
    while (usbip->out_begin < usbip->out_end) {
        ssize_t n = send(usbip->fd, usbip->out + usbip->out_begin,
                         usbip->out_end - usbip->out_begin, MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0 && errno == EAGAIN)
            return LF_OK;
        if (n < 0 && (errno == EPIPE || errno == ECONNRESET))
            return LF_E_NODEV;
        if (n < 0)
            return lf_error_set(err, LF_E_IO, "usbip", "sending failed: %s", lf_errno_text(errno));
        usbip->out_begin += (size_t)n;
    }
    usbip->out_begin = usbip->out_end = 0;
    return usbip->state == READ_NOTHING ? LF_E_NODEV : LF_OK;
}

/* --------------------------------------------------------------------------------- handshake -- */

static void put_op(uint8_t *at, unsigned code, uint32_t status)
{
    put16(at, VERSION);
    put16(at + 2, code);
    put32(at + 4, status);
}

static int get_descriptor(lf_model *model, unsigned kind, uint8_t *out, size_t n)
{
    const uint8_t setup[8] = {0x80, 6, 0, (uint8_t)kind, 0, 0, (uint8_t)n, (uint8_t)(n >> 8)};
    return lf_model_control(model, setup, out, n);
}

/* The record of the device, from its own descriptors, and what follows it in a list: 4 bytes an
 * interface. Returns both sizes. */
static size_t put_record(lf_model *model, uint8_t *at, bool with_interfaces)
{
    uint8_t device[18] = {0}, configuration[256] = {0};
    int n = get_descriptor(model, 1, device, sizeof device);
    int size = get_descriptor(model, 2, configuration, sizeof configuration);
    assert(n == (int)sizeof device && size > 9);
    memset(at, 0, RECORD_SIZE);
    snprintf((char *)at, 256, "/sys/devices/quiltsim/usb1/%s", LF_USBIP_BUSID);
    snprintf((char *)at + 256, BUSID_SIZE, "%s", LF_USBIP_BUSID);
    put32(at + 288, LF_USBIP_DEVID >> 16);
    put32(at + 292, LF_USBIP_DEVID & 0xffff);
    put32(at + 296, LF_USBIP_HIGH_SPEED);
    for (int i = 0; i < 3; i++) /* vendor, product, version: little-endian there */
        put16(at + 300 + 2 * i, (unsigned)device[8 + 2 * i] | (unsigned)device[9 + 2 * i] << 8);
    memcpy(at + 306, device + 4, 3);
    at[309] = configuration[5];
    at[310] = device[17];
    at[311] = configuration[4];
    if (!with_interfaces)
        return RECORD_SIZE;
    uint8_t *to = at + RECORD_SIZE;
    for (int i = 0; i + 8 < size && configuration[i] > 0; i += configuration[i])
        if (configuration[i + 1] == 4 && to < at + RECORD_SIZE + 4 * (size_t)MAX_INTERFACES) {
            memcpy(to, configuration + i + 5, 3);
            to[3] = 0;
            to += 4;
        }
    return (size_t)(to - at);
}

static void answer_list(lf_usbip *usbip)
{
    uint8_t *at = put_begin(usbip);
    size_t n = OP_SIZE + 4;
    put_op(at, OP_REP_DEVLIST, 0);
    put32(at + OP_SIZE, !!usbip->device->model);
    if (usbip->device->model)
        n += put_record(usbip->device->model, at + n, true);
    put_end(usbip, n);
    usbip->state = READ_NOTHING;
}

static void answer_import(lf_usbip *usbip)
{
    uint8_t *at = put_begin(usbip);
    size_t n = OP_SIZE;
    bool named = strncmp((const char *)usbip->header, LF_USBIP_BUSID, BUSID_SIZE) == 0;
    bool given = named && usbip->device->model && !usbip->device->taken;
    put_op(at, OP_REP_IMPORT, given ? 0 : 1);
    if (given) {
        n += put_record(usbip->device->model, at + n, false);
        usbip->device->taken = usbip->holds = true;
    }
    put_end(usbip, n);
    usbip->state = given ? READ_HEADER : READ_NOTHING;
}

static lf_status take_op(lf_usbip *usbip, lf_error *err)
{
    unsigned version = (unsigned)usbip->header[0] << 8 | usbip->header[1],
             code = (unsigned)usbip->header[2] << 8 | usbip->header[3];
    if (version != VERSION)
        return lf_error_set(err, LF_E_FORMAT, "usbip", "the peer speaks version %x, expected %x",
                            version, VERSION);
    if (code == OP_REQ_DEVLIST)
        answer_list(usbip);
    else if (code == OP_REQ_IMPORT)
        usbip->state = READ_BUSID;
    else
        return lf_error_set(err, LF_E_FORMAT, "usbip", "request %04x is unknown", code);
    return LF_OK;
}

/* -------------------------------------------------------------------------------------- URBs -- */

static void put_return(uint8_t *at, uint32_t command, uint32_t seqnum, int status)
{
    memset(at, 0, URB_HEADER);
    put32(at, command);
    put32(at + 4, seqnum);
    put32(at + 20, (uint32_t)status);
}

/* result: bytes or a negative errno. data_n bytes of IN data lie behind the header already. */
static void put_submit(lf_usbip *usbip, uint8_t *at, uint32_t seqnum, int result, size_t data_n)
{
    put_return(at, RET_SUBMIT, seqnum, result < 0 ? result : 0);
    put32(at + 24, result < 0 ? 0 : (uint32_t)result);
    put32(at + 32, (uint32_t)NOT_ISO);
    put_end(usbip, URB_HEADER + data_n);
}

static void enqueue(lf_usbip *usbip, urb *u)
{
    *usbip->last = u;
    usbip->last = &u->next;
    usbip->n_urbs++;
    usbip->waiting += u->in ? 0 : u->length;
}

static void drop(lf_usbip *usbip, urb **link)
{
    urb *u = *link;
    *link = u->next;
    if (usbip->last == &u->next)
        usbip->last = link;
    usbip->n_urbs--;
    usbip->waiting -= u->in ? 0 : u->length;
    lf_free(u);
}

/* What the device says to a URB: bytes or a negative errno. IN data goes to in_data[MAX_IN]. */
static int ask_model(lf_usbip *usbip, urb *u, uint8_t *in_data)
{
    uint8_t *data = u->in ? in_data : u->data;
    size_t n = u->in && u->length > MAX_IN ? MAX_IN : u->length;
    if (u->endpoint != 0)
        return lf_model_transfer(usbip->device->model, u->endpoint, data, n);
    size_t wanted = (size_t)u->setup[6] | (size_t)u->setup[7] << 8;
    if (n > 0 && u->in != ((u->setup[0] & 0x80) != 0))
        return -EPIPE;
    return lf_model_control(usbip->device->model, u->setup, data, n < wanted ? n : wanted);
}

/* The first URB of an endpoint. False: it waits on. */
static bool try_urb(lf_usbip *usbip, urb *u, uint64_t now_ns, lf_status *status)
{
    if (u->dead)
        return false;
    if (!u->started) {
        bool timed = u->endpoint == LF_MODEL_GUD_ENDPOINT && usbip->device->gud;
        u->due_ns = now_ns + (timed ? lf_model_gud_delay_ns(usbip->device->gud, u->length) : 0);
        u->started = true;
    }
    if (u->due_ns > now_ns) {
        usbip->due_ns = u->due_ns < usbip->due_ns ? u->due_ns : usbip->due_ns;
        return false;
    }
    uint8_t *at = put_begin(usbip);
    int result = ask_model(usbip, u, at + URB_HEADER);
    u->dead = result == -ETIMEDOUT;
    if (result == -ENODEV)
        *status = LF_E_NODEV;
    if (result == -EAGAIN || u->dead || *status != LF_OK)
        return false;
    put_submit(usbip, at, u->seqnum, result, u->in && result > 0 ? (size_t)result : 0);
    return true;
}

/* Answers what can be answered. A control transfer may make an input report, so that all are looked
 * at again then. */
static lf_status pump(lf_usbip *usbip, uint64_t now_ns)
{
    bool again = true;
    lf_status status = LF_OK;
    while (again && status == LF_OK) {
        uint32_t busy = 0; /* endpoints whose first URB waits: bit = number, + 16 for IN */
        again = false;
        usbip->due_ns = NEVER;
        for (urb **link = &usbip->first; *link && status == LF_OK;) {
            urb *u = *link;
            if (!has_room(usbip)) {
                usbip->due_ns = now_ns; /* the rest once the peer has read */
                return LF_OK;
            }
            uint32_t bit = 1u << ((u->endpoint & 0x0f) + (u->endpoint & 0x80 ? 16 : 0));
            if (!(busy & bit) && try_urb(usbip, u, now_ns, &status)) {
                again = again || u->endpoint == 0;
                drop(usbip, link);
            } else {
                busy |= bit;
                link = &u->next;
            }
        }
    }
    return status;
}

static lf_status take_submit(lf_usbip *usbip, lf_error *err)
{
    const uint8_t *h = usbip->header;
    uint32_t length = get32(h + 24), number = get32(h + 16), packets = get32(h + 32);
    bool in = get32(h + 12) == 1;
    if (number > 15 || get32(h + 12) > 1 || (packets != 0 && packets != (uint32_t)NOT_ISO))
        return lf_error_set(err, LF_E_FORMAT, "usbip",
                            "unexpected transfer: endpoint %u, direction %u, %u packets", number,
                            get32(h + 12), packets);
    bool refused =
        usbip->n_urbs >= LF_USBIP_MAX_URBS ||
        (!in && (length > LF_USBIP_MAX_TRANSFER || length > LF_USBIP_MAX_WAITING - usbip->waiting));
    urb *u = refused ? NULL : lf_calloc(1, sizeof *u + (in ? 0 : length));
    if (!u) {
        put_submit(usbip, put_begin(usbip), get32(h + 4), -ENOMEM, 0);
        usbip->to_skip = in ? 0 : length;
        usbip->state = usbip->to_skip > 0 ? SKIP_DATA : READ_HEADER;
        return LF_OK;
    }
    u->seqnum = get32(h + 4);
    u->length = length;
    u->in = in;
    u->endpoint = (uint8_t)(number | (in && number != 0 ? 0x80 : 0));
    memcpy(u->setup, h + 40, sizeof u->setup);
    if (in || length == 0) {
        enqueue(usbip, u);
    } else {
        usbip->incoming = u;
        usbip->state = READ_DATA;
    }
    return LF_OK;
}

static void take_unlink(lf_usbip *usbip)
{
    uint32_t seqnum = get32(usbip->header + 20);
    urb **link = &usbip->first;
    while (*link && (*link)->seqnum != seqnum)
        link = &(*link)->next;
    bool pending = *link;
    if (pending)
        drop(usbip, link);
    put_return(put_begin(usbip), RET_UNLINK, get32(usbip->header + 4), pending ? -ECONNRESET : 0);
    put_end(usbip, URB_HEADER);
}

static lf_status take_command(lf_usbip *usbip, lf_error *err)
{
    uint32_t command = get32(usbip->header), devid = get32(usbip->header + 8);
    if (command == CMD_UNLINK) {
        take_unlink(usbip);
        return LF_OK;
    }
    if (command != CMD_SUBMIT || devid != LF_USBIP_DEVID)
        return lf_error_set(err, LF_E_FORMAT, "usbip",
                            "unexpected command %u to device %x; expected a transfer to device %x",
                            command, devid, (unsigned)LF_USBIP_DEVID);
    return take_submit(usbip, err);
}

/* ------------------------------------------------------------------------------------- input -- */

/* Where the next bytes go, and how many there are at most. */
static size_t input_target(lf_usbip *usbip, uint8_t **out)
{
    static const size_t sizes[] = {
        [READ_OP] = OP_SIZE, [READ_BUSID] = BUSID_SIZE, [READ_HEADER] = URB_HEADER};
    if (usbip->state == SKIP_DATA) {
        *out = usbip->skipped;
        return usbip->to_skip < sizeof usbip->skipped ? usbip->to_skip : sizeof usbip->skipped;
    }
    if (usbip->state == READ_DATA) {
        *out = usbip->incoming->data + usbip->n_read;
        return usbip->incoming->length - usbip->n_read;
    }
    *out = usbip->header + usbip->n_read;
    return sizes[usbip->state] - usbip->n_read;
}

/* n bytes have come to the target; `whole` = all it wanted. */
static lf_status take_input(lf_usbip *usbip, size_t n, bool whole, lf_error *err)
{
    if (usbip->state == SKIP_DATA) {
        usbip->to_skip -= n;
        usbip->state = usbip->to_skip > 0 ? SKIP_DATA : READ_HEADER;
        return LF_OK;
    }
    usbip->n_read = whole ? 0 : usbip->n_read + n;
    if (!whole)
        return LF_OK;
    switch (usbip->state) {
    case READ_OP:
        return take_op(usbip, err);
    case READ_BUSID:
        answer_import(usbip);
        return LF_OK;
    case READ_DATA:
        enqueue(usbip, usbip->incoming);
        usbip->incoming = NULL;
        usbip->state = READ_HEADER;
        return LF_OK;
    default:
        return take_command(usbip, err);
    }
}

/* One read. *out_more: there may be more to read. */
static lf_status receive(lf_usbip *usbip, bool *out_more, lf_error *err)
{
    uint8_t *to;
    *out_more = false;
    if (usbip->state == READ_NOTHING || !has_room(usbip))
        return LF_OK;
    size_t wanted = input_target(usbip, &to);
    ssize_t n = recv(usbip->fd, to, wanted, 0);
    if (n == 0 || (n < 0 && errno == ECONNRESET))
        return LF_E_NODEV;
    if (n < 0 && errno != EAGAIN && errno != EINTR)
        return lf_error_set(err, LF_E_IO, "usbip", "receiving failed: %s", lf_errno_text(errno));
    if (n < 0)
        return LF_OK;
    *out_more = true;
    return take_input(usbip, (size_t)n, (size_t)n == wanted, err);
}

lf_status lf_usbip_run(lf_usbip *usbip, uint64_t now_ns, lf_error *err)
{
    lf_status status = flush(usbip, err);
    bool more = true;
    for (int i = 0; i < ROUNDS && more && status == LF_OK; i++)
        status = receive(usbip, &more, err);
    if (status == LF_OK && usbip->holds && !usbip->device->model)
        status = LF_E_NODEV;
    if (status == LF_OK && usbip->holds)
        status = pump(usbip, now_ns);
    return status == LF_OK ? flush(usbip, err) : status;
}

int lf_usbip_poll(const lf_usbip *usbip, uint64_t now_ns, struct pollfd *out)
{
    bool writes = usbip->out_begin < usbip->out_end,
         reads = usbip->state != READ_NOTHING && has_room(usbip);
    *out = (struct pollfd){.fd = usbip->fd,
                           .events = (short)((reads ? POLLIN : 0) | (writes ? POLLOUT : 0))};
    if (usbip->due_ns == NEVER || !has_room(usbip))
        return -1;
    if (usbip->due_ns <= now_ns)
        return 0;
    uint64_t ms = (usbip->due_ns - now_ns + LF_NS_PER_MS - 1) / LF_NS_PER_MS;
    return ms < 60000 ? (int)ms : 60000;
}

bool lf_usbip_imported(const lf_usbip *usbip)
{
    return usbip->holds;
}

/* -------------------------------------------------------------------------------------- life -- */

lf_status lf_usbip_create(lf_usbip_device *device, int fd, bool imported, lf_usbip **out)
{
    assert(!imported || (device->model && !device->taken));
    int flags = fcntl(fd, F_GETFL);
    if (flags < 0 || fcntl(fd, F_SETFL, flags | O_NONBLOCK) < 0)
        return LF_E_IO;
    lf_usbip *usbip = lf_calloc(1, sizeof *usbip);
    if (!usbip)
        return LF_E_NOMEM;
    usbip->device = device;
    usbip->fd = fd;
    usbip->last = &usbip->first;
    usbip->due_ns = NEVER;
    usbip->state = imported ? READ_HEADER : READ_OP;
    usbip->holds = imported;
    if (imported)
        device->taken = true;
    *out = usbip;
    return LF_OK;
}

void lf_usbip_destroy(lf_usbip *usbip)
{
    if (!usbip)
        return;
    while (usbip->first)
        drop(usbip, &usbip->first);
    lf_free(usbip->incoming);
    if (usbip->holds)
        usbip->device->taken = false;
    close(usbip->fd);
    lf_free(usbip);
}
