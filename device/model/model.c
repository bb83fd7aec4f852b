#include "device/model/model.h"

#include <assert.h>
#include <errno.h>
#include <string.h>

#include "base/alloc.h"

/* USB 2.0 chapter 9, HID 1.11 chapter 7: the numbers of requests, descriptors and features. */
enum {
    GET_STATUS = 0,
    CLEAR_FEATURE = 1,
    SET_FEATURE = 3,
    GET_DESCRIPTOR = 6,
    GET_CONFIGURATION = 8,
    SET_CONFIGURATION = 9,
    GET_INTERFACE = 10,
    SET_INTERFACE = 11,
    HID_GET_IDLE = 2,
    HID_SET_REPORT = 9,
    HID_SET_IDLE = 10,
    DEVICE_DESCRIPTOR = 1,
    CONFIGURATION_DESCRIPTOR = 2,
    STRING_DESCRIPTOR = 3,
    HID_DESCRIPTOR = 0x21,
    REPORT_DESCRIPTOR = 0x22,
    FEATURE_REPORT = 3,
    ENDPOINT_HALT = 0,
};

/* Kinds of setup packets: bmRequestType without the direction. */
enum {
    TO_DEVICE = 0x00,
    TO_INTERFACE = 0x01,
    TO_ENDPOINT = 0x02,
    CLASS_INTERFACE = 0x21,
    VENDOR_INTERFACE = 0x41
};

enum {
    CONFIGURATION_SIZE = 9 + (9 + 9 + 7) + (9 + 7),
    HID_DESCRIPTOR_AT = 9 + 9,
    EDID_SIZE = 128,
    MAX_DTD_SIDE = 4095
};

/* Unnumbered reports: 68 bytes in, 67 bytes as a feature, on a vendor-defined usage page. */
static const uint8_t report_descriptor[] = {
    0x06, 0x00,
    0xff, /* usage page: vendor */
    0x09, 0x01,
    0xa1, 0x01, /* usage 1, collection: application */
    0x15, 0x00,
    0x26, 0xff,
    0x00,                 /* logical range 0 to 255 */
    0x75, 0x08,           /* bytes */
    0x95, LF_MODEL_INPUT, /* count */
    0x09, 0x02,
    0x81, 0x02,             /* usage 2, input: variable */
    0x95, LF_MODEL_FEATURE, /* count */
    0x09, 0x03,
    0xb1, 0x02, /* usage 3, feature: variable */
    0xc0,       /* end of the collection */
};

struct lf_model {
    lf_model_hid *hid; /* borrowed */
    lf_model_gud *gud; /* borrowed */
    int hid_interface, gud_interface, n_interfaces;
    uint8_t device[18];
    uint8_t configuration[CONFIGURATION_SIZE];
    size_t n_configuration;
    uint8_t configured; /* bConfigurationValue, 0 = not */
    uint8_t idle;       /* value of SET_IDLE */
    bool in_halted, out_halted;
};

typedef struct setup_packet {
    bool in;
    uint8_t kind, request;
    uint16_t value, index, length;
} setup_packet;

/* ------------------------------------------------------------------------------- descriptors -- */

static uint8_t *append(lf_model *model, const uint8_t *bytes, size_t n)
{
    uint8_t *at = model->configuration + model->n_configuration;
    assert(model->n_configuration + n <= sizeof model->configuration);
    memcpy(at, bytes, n);
    model->n_configuration += n;
    return at;
}

static void append_hid(lf_model *model)
{
    const uint8_t interface[] = {9, 4, 0, 0, 1, 3 /* HID */, 0, 0, 0};
    const uint8_t hid[] = {
        9, HID_DESCRIPTOR, 0x11, 0x01, 0, 1, REPORT_DESCRIPTOR, sizeof report_descriptor, 0};
    /* 2^(4-1) microframes: 1 ms */
    const uint8_t endpoint[] = {7, 5, LF_MODEL_HID_ENDPOINT, 3 /* interrupt */, 64, 0, 4};
    model->hid_interface = model->n_interfaces++;
    append(model, interface, sizeof interface)[2] = (uint8_t)model->hid_interface;
    append(model, hid, sizeof hid);
    append(model, endpoint, sizeof endpoint);
}

static void append_gud(lf_model *model)
{
    const uint8_t interface[] = {9, 4, 0, 0, 1, 0xff /* vendor */, 0, 0, 0};
    const uint8_t endpoint[] = {7, 5, LF_MODEL_GUD_ENDPOINT, 2 /* bulk */, 0x00, 0x02 /* 512 */, 0};
    model->gud_interface = model->n_interfaces++;
    append(model, interface, sizeof interface)[2] = (uint8_t)model->gud_interface;
    append(model, endpoint, sizeof endpoint);
}

static void make_descriptors(lf_model *model)
{
    const uint8_t looking_glass[] = {0xd8, 0x04, 0x7e, 0xef}, display[] = {0x50, 0x1d, 0x4d, 0x61};
    const uint8_t device[18] = {
        18, DEVICE_DESCRIPTOR, 0x00, 0x02, 0, 0, 0, 64, 0, 0, 0, 0, 0x00, 0x01, 1, 2, 3, 1};
    /* self-powered; requests 100 mA */
    const uint8_t head[9] = {9, CONFIGURATION_DESCRIPTOR, 0, 0, 0, 1, 0, 0xc0, 50};
    memcpy(model->device, device, sizeof device);
    memcpy(model->device + 8, model->hid ? looking_glass : display, 4);
    append(model, head, sizeof head);
    if (model->hid)
        append_hid(model);
    if (model->gud)
        append_gud(model);
    model->configuration[2] = (uint8_t)model->n_configuration;
    model->configuration[4] = (uint8_t)model->n_interfaces;
}

static int answer(uint8_t *data, size_t n, const void *bytes, size_t size)
{
    size_t taken = size < n ? size : n;
    memcpy(data, bytes, taken);
    return (int)taken;
}

static int answer_string(const lf_model *model, int index, uint8_t *data, size_t n)
{
    const char *const texts[] = {NULL, "Looking Glass Factory",
                                 model->hid ? "HoloPlay" : "Looking Glass display", "simulated"};
    uint8_t bytes[64] = {4, STRING_DESCRIPTOR, 0x09, 0x04}; /* the list of languages: English */
    if (index >= (int)(sizeof texts / sizeof texts[0]))
        return -EPIPE;
    if (index > 0) {
        size_t length = strlen(texts[index]);
        assert(2 + 2 * length <= sizeof bytes);
        bytes[0] = (uint8_t)(2 + 2 * length);
        for (size_t i = 0; i < length; i++) {
            bytes[2 + 2 * i] = (uint8_t)texts[index][i];
            bytes[3 + 2 * i] = 0;
        }
    }
    return answer(data, n, bytes, bytes[0]);
}

static int answer_descriptor(const lf_model *model, uint16_t value, uint8_t *data, size_t n)
{
    switch (value >> 8) {
    case DEVICE_DESCRIPTOR:
        return answer(data, n, model->device, sizeof model->device);
    case CONFIGURATION_DESCRIPTOR:
        return (value & 0xff) == 0 ? answer(data, n, model->configuration, model->n_configuration)
                                   : -EPIPE;
    case STRING_DESCRIPTOR:
        return answer_string(model, value & 0xff, data, n);
    default:
        return -EPIPE; /* no other speed, no capabilities */
    }
}

/* ---------------------------------------------------------------------------------- requests -- */

static int control_device(lf_model *model, const setup_packet *setup, uint8_t *data, size_t n)
{
    const uint8_t self_powered[2] = {1, 0};
    switch (setup->request) {
    case GET_STATUS:
        return setup->in ? answer(data, n, self_powered, 2) : -EPIPE;
    case GET_DESCRIPTOR:
        return setup->in ? answer_descriptor(model, setup->value, data, n) : -EPIPE;
    case GET_CONFIGURATION:
        return setup->in ? answer(data, n, &model->configured, 1) : -EPIPE;
    case SET_CONFIGURATION:
        if (setup->in || setup->value > 1)
            return -EPIPE;
        model->configured = (uint8_t)setup->value;
        model->in_halted = model->out_halted = false;
        return 0;
    default:
        return -EPIPE;
    }
}

/* HID descriptors are read with requests to the interface. */
static int answer_hid_descriptor(const lf_model *model, uint16_t value, uint8_t *data, size_t n)
{
    switch (value >> 8) {
    case HID_DESCRIPTOR:
        return answer(data, n, model->configuration + HID_DESCRIPTOR_AT, 9);
    case REPORT_DESCRIPTOR:
        return answer(data, n, report_descriptor, sizeof report_descriptor);
    default:
        return -EPIPE;
    }
}

static int control_interface(lf_model *model, const setup_packet *setup, uint8_t *data, size_t n)
{
    const uint8_t zeros[2] = {0, 0};
    if (setup->index >= model->n_interfaces)
        return -EPIPE;
    switch (setup->request) {
    case GET_STATUS:
        return setup->in ? answer(data, n, zeros, 2) : -EPIPE;
    case GET_INTERFACE:
        return setup->in ? answer(data, n, zeros, 1) : -EPIPE;
    case SET_INTERFACE:
        return !setup->in && setup->value == 0 ? 0 : -EPIPE;
    case GET_DESCRIPTOR:
        return setup->in && setup->index == model->hid_interface
                   ? answer_hid_descriptor(model, setup->value, data, n)
                   : -EPIPE;
    default:
        return -EPIPE;
    }
}

static bool *halt_of(lf_model *model, unsigned endpoint)
{
    if (endpoint == LF_MODEL_HID_ENDPOINT && model->hid)
        return &model->in_halted;
    return endpoint == LF_MODEL_GUD_ENDPOINT && model->gud ? &model->out_halted : NULL;
}

static int control_endpoint(lf_model *model, const setup_packet *setup, uint8_t *data, size_t n)
{
    bool *halted = halt_of(model, setup->index);
    if (!halted)
        return -EPIPE;
    if (setup->request == GET_STATUS && setup->in)
        return answer(data, n, (const uint8_t[2]){*halted, 0}, 2);
    if ((setup->request != CLEAR_FEATURE && setup->request != SET_FEATURE) || setup->in ||
        setup->value != ENDPOINT_HALT)
        return -EPIPE;
    *halted = setup->request == SET_FEATURE;
    return 0;
}

/* GET_REPORT is refused: replies and buttons come on the interrupt endpoint. */
static int control_hid(lf_model *model, const setup_packet *setup, uint8_t *data, size_t n)
{
    if (!model->hid || setup->index != model->hid_interface)
        return -EPIPE;
    if (setup->request == HID_SET_REPORT && !setup->in)
        return setup->value == FEATURE_REPORT << 8 ? lf_model_hid_feature(model->hid, data, n)
                                                   : -EPIPE;
    if (setup->request == HID_GET_IDLE && setup->in)
        return answer(data, n, &model->idle, 1);
    if (setup->request != HID_SET_IDLE || setup->in)
        return -EPIPE;
    model->idle = (uint8_t)(setup->value >> 8);
    return 0;
}

int lf_model_control(lf_model *model, const uint8_t setup[8], uint8_t *data, size_t n)
{
    const setup_packet s = {
        .in = (setup[0] & 0x80) != 0,
        .kind = setup[0] & 0x7f,
        .request = setup[1],
        .value = (uint16_t)(setup[2] | setup[3] << 8),
        .index = (uint16_t)(setup[4] | setup[5] << 8),
        .length = (uint16_t)(setup[6] | setup[7] << 8),
    };
    size_t most = n < s.length ? n : s.length;
    switch (s.kind) {
    case TO_DEVICE:
        return control_device(model, &s, data, most);
    case TO_INTERFACE:
        return control_interface(model, &s, data, most);
    case TO_ENDPOINT:
        return control_endpoint(model, &s, data, most);
    case CLASS_INTERFACE:
        return control_hid(model, &s, data, most);
    case VENDOR_INTERFACE:
        if (!model->gud || s.index != model->gud_interface)
            return -EPIPE;
        return lf_model_gud_control(model->gud, s.in, s.request, s.value, data, most);
    default:
        return -EPIPE;
    }
}

int lf_model_transfer(lf_model *model, uint8_t endpoint, uint8_t *data, size_t n)
{
    bool *halted = halt_of(model, endpoint);
    if (!halted || *halted)
        return -EPIPE;
    int result = endpoint == LF_MODEL_HID_ENDPOINT ? lf_model_hid_input(model->hid, data, n)
                                                   : lf_model_gud_bulk(model->gud, data, n);
    *halted = result == -EPIPE;
    return result;
}

/* -------------------------------------------------------------------------------------- life -- */

lf_status lf_model_create(lf_model_hid *hid, lf_model_gud *gud, lf_model **out)
{
    assert(hid || gud);
    lf_model *model = lf_calloc(1, sizeof *model);
    if (!model)
        return LF_E_NOMEM;
    model->hid = hid;
    model->gud = gud;
    model->hid_interface = model->gud_interface = -1;
    make_descriptors(model);
    *out = model;
    return LF_OK;
}

void lf_model_destroy(lf_model *model)
{
    lf_free(model);
}

/* A display descriptor with text: ends with a line feed, padded with blanks. */
static void put_text(uint8_t *at, uint8_t tag, const char *text)
{
    size_t n = strlen(text) < 13 ? strlen(text) : 13;
    memset(at, 0, 5);
    at[3] = tag;
    memset(at + 5, ' ', 13);
    memcpy(at + 5, text, n);
    if (n < 13)
        at[5 + n] = '\n';
}

/* The preferred timing at 60 Hz, with blanking of a tenth; the clock is clamped to 16 bits. */
static void put_timing(uint8_t *at, unsigned width, unsigned height)
{
    unsigned blank_x = width / 10 < 64 ? 64 : width / 10,
             blank_y = height / 10 < 8 ? 8 : height / 10;
    uint64_t clock = (uint64_t)(width + blank_x) * (height + blank_y) * 60 / 10000;
    clock = clock > 0xffff ? 0xffff : clock;
    const uint8_t timing[18] = {
        (uint8_t)clock,
        (uint8_t)(clock >> 8),
        (uint8_t)width,
        (uint8_t)blank_x,
        (uint8_t)((width >> 8) << 4 | blank_x >> 8),
        (uint8_t)height,
        (uint8_t)blank_y,
        (uint8_t)((height >> 8) << 4 | blank_y >> 8),
        16,
        16,
        0x44,
        [17] = 0x1e,
    };
    memcpy(at, timing, sizeof timing);
}

void lf_model_edid(const char *name, const char *serial, int width, int height, uint8_t out[128])
{
    const uint8_t header[] = {0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0, 0x31 /* "LKG" */, 0x67};
    unsigned sum = 0;
    memset(out, 0, EDID_SIZE);
    memcpy(out, header, sizeof header);
    out[17] = 30; /* made in 2020 */
    out[18] = 1;  /* EDID 1.4 */
    out[19] = 4;
    out[20] = 0xa5; /* digital, 8 bits, DisplayPort */
    if (width <= MAX_DTD_SIDE && height <= MAX_DTD_SIDE)
        put_timing(out + 54, (unsigned)width, (unsigned)height);
    else
        put_text(out + 54, 0x10, "");
    put_text(out + 72, 0xfc, name);
    put_text(out + 90, 0xff, serial);
    put_text(out + 108, 0x10, "");
    for (int i = 0; i < EDID_SIZE - 1; i++)
        sum += out[i];
    out[EDID_SIZE - 1] = (uint8_t)(0u - sum);
}
