/* quiltsim: a simulated Looking Glass on USB. See docs/man/quiltsim.1. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/calibration.h"
#include "base/log.h"
#include "daemon/output/options.h"
#include "daemon/tools/simulator.h"
#include "device/model/usbip.h"
#include "device/usb/gud.h"

#define PROGRAM "quiltsim"

/* The type of an option's value. */
typedef enum option_kind {
    FLAG,    /* bool, without an argument */
    FILE_OF, /* const char * */
    PORT,    /* int */
    INT,     /* int */
    U32,     /* uint32_t */
    U64,     /* uint64_t */
    SIZE,    /* width_px and height_px */
    FORMATS, /* formats and n_formats */
    FAULT,   /* int */
} option_kind;

static const struct option_rule {
    const char *name;
    option_kind kind;
    size_t offset; /* offset in lf_simulator_config */
} rules[] = {
#define TO(member) offsetof(lf_simulator_config, member)
    {"listen", PORT, TO(port)},
    {"attach", FLAG, TO(attach)},
    {"calibration", FILE_OF, TO(calibration)},
    {"size", SIZE, TO(width_px)},
    {"no-hid", FLAG, TO(no_hid)},
    {"no-display", FLAG, TO(no_display)},
    {"formats", FORMATS, TO(formats)},
    {"buffer", U32, TO(buffer_bytes)},
    {"lz4", FLAG, TO(lz4)},
    {"full-update", FLAG, TO(full_update)},
    {"panel-png", FILE_OF, TO(panel_png)},
    {"stall-every", U64, TO(gud.stall_every)},
    {"fail-every", U64, TO(gud.fail_every)},
    {"hang-every", U64, TO(gud.hang_every)},
    {"unplug-after", U64, TO(gud.unplug_after)},
    {"bytes-per-second", U64, TO(gud.bytes_per_s)},
    {"fault", FAULT, TO(gud.fault)},
    {"hid-split", FLAG, TO(hid.split)},
    {"hid-stale", INT, TO(hid.stale)},
    {"hid-mute-every", INT, TO(hid.mute_every)},
    {"hid-stall-every", INT, TO(hid.stall_every)},
    {"hid-short-every", INT, TO(hid.short_every)},
    {"hid-press-every", INT, TO(hid.press_every)},
    {"hid-wrong-echo", FLAG, TO(hid.wrong_echo)},
#undef TO
};

enum { N_RULES = sizeof rules / sizeof rules[0] };

static const char *const former[][2] = {{"lie", "fault"}, {NULL, NULL}};

static const char *const faults[LF_GUD_FAULTS] = {
    [LF_GUD_HONEST] = "none",
    [LF_GUD_WRONG_MAGIC] = "wrong-magic",
    [LF_GUD_VERSION_0] = "version-0",
    [LF_GUD_VERSION_9] = "version-9",
    [LF_GUD_SHORT_DESCRIPTOR] = "short-descriptor",
    [LF_GUD_NO_FORMATS] = "no-formats",
    [LF_GUD_UNKNOWN_FORMATS] = "unknown-formats",
    [LF_GUD_MANY_FORMATS] = "many-formats",
    [LF_GUD_NO_CONNECTORS] = "no-connectors",
    [LF_GUD_MODE_0X0] = "mode-0x0",
    [LF_GUD_MODE_65535] = "mode-65535",
    [LF_GUD_MODES_CUT] = "modes-cut",
    [LF_GUD_TINY_BUFFER] = "tiny-buffer",
    [LF_GUD_SHORT_EDID] = "short-edid",
    [LF_GUD_NO_MODES] = "no-modes",
    [LF_GUD_COMPRESSED_FULL] = "compressed-full",
    [LF_GUD_BAD_STATUS] = "bad-status",
};

static const lf_gud_format known_formats[] = {LF_GUD_RGB888, LF_GUD_XRGB8888, LF_GUD_RGB565};

static void print_help(void)
{
    printf(
        "Usage: quiltsim [--listen PORT | --attach] [options]\n"
        "Simulate a Looking Glass on USB through USB/IP: calibration and buttons by HID, pixels "
        "by GUD.\n"
        "\n"
        "  --listen PORT          wait on 127.0.0.1 for usbip attach; 0: any free port (%d)\n"
        "  --attach               plug the panel into this machine with vhci_hcd; needs root\n"
        "  --calibration FILE     contents of the EEPROM, byte by byte (a nominal Portrait)\n"
        "  --size WxH             pixels of the display (the calibration's)\n"
        "  --no-hid               omit the calibration and the buttons\n"
        "  --no-display           omit the display\n"
        "  --formats LIST         pixel formats of rgb888, xrgb8888, rgb565, best first (rgb888)\n"
        "  --buffer BYTES         buffer size of the display; 0: no limit (0)\n"
        "  --lz4                  accept compressed rectangles\n"
        "  --full-update          require whole frames\n"
        "  --panel-png FILE       write the displayed image on SIGUSR1, on \"picture\" and at the "
        "end\n"
        "\n"
        "Faults of the display (N = 0: never):\n"
        "  --stall-every N        refuse every Nth rectangle\n"
        "  --fail-every N         break off every Nth rectangle half way\n"
        "  --hang-every N         never accept every Nth rectangle\n"
        "  --unplug-after N       unplug the panel after N rectangles\n"
        "  --bytes-per-second N   limit the speed\n"
        "  --fault NAME           give a wrong answer, one of:",
        LF_USBIP_PORT);
    for (int i = 0; i < LF_GUD_FAULTS; i++)
        printf("%s%s", i % 6 == 0 ? "\n                         " : " ", faults[i]);
    printf("\n"
           "\n"
           "Faults of the calibration and the buttons (N = 0: never):\n"
           "  --hid-split            send each reply in two parts\n"
           "  --hid-stale N          send N old replies before each reply\n"
           "  --hid-mute-every N     never answer every Nth request\n"
           "  --hid-stall-every N    refuse every Nth request\n"
           "  --hid-short-every N    cut off every Nth reply\n"
           "  --hid-press-every N    send a button report before every Nth reply\n"
           "  --hid-wrong-echo       answer with another page\n"
           "\n"
           "Commands on standard input: press square|left|right|circle, unplug, replug, picture, "
           "counters, quit.\n"
           "\n" LF_OPTIONS_HELP_LAST LF_OPTIONS_HELP_SHELLS);
}

static lf_status take_whole(const struct option_rule *rule, const char *where, const char *text,
                            void *to, lf_error *err)
{
    static const int64_t most[] = {
        [PORT] = 65535, [INT] = 1000000, [U32] = UINT32_MAX, [U64] = INT64_MAX};
    int64_t value;
    lf_status status = lf_parse_int(where, text, 0, most[rule->kind], &value, err);
    if (status != LF_OK)
        return status;
    if (rule->kind == U64)
        *(uint64_t *)to = (uint64_t)value;
    else if (rule->kind == U32)
        *(uint32_t *)to = (uint32_t)value;
    else
        *(int *)to = (int)value;
    return LF_OK;
}

static lf_status take_size(lf_simulator_config *config, const char *text, lf_error *err)
{
    double pair[2];
    lf_status status = lf_parse_pair("--size", text, 'x', 1, LF_MAX_SIDE, pair, err);
    if (status != LF_OK)
        return status;
    if (pair[0] != floor(pair[0]) || pair[1] != floor(pair[1]))
        return lf_error_set(err, LF_E_ARG, "--size", "expects whole numbers, got \"%s\"", text);
    config->width_px = (int)pair[0];
    config->height_px = (int)pair[1];
    return LF_OK;
}

/* The format named by the first n characters, in any case. */
static lf_gud_format format_of(const char *word, size_t n)
{
    for (size_t i = 0; i < sizeof known_formats / sizeof known_formats[0]; i++) {
        const char *name = lf_gud_format_name(known_formats[i]);
        if (strncasecmp(word, name, n) == 0 && name[n] == 0)
            return known_formats[i];
    }
    return LF_GUD_NO_FORMAT;
}

static lf_status take_formats(lf_simulator_config *config, const char *text, lf_error *err)
{
    uint8_t formats[sizeof config->formats] = {0};
    int n = 0;
    for (const char *word = text; word; n++) {
        size_t length = strcspn(word, ",");
        lf_gud_format format = length > 0 ? format_of(word, length) : LF_GUD_NO_FORMAT;
        if (format == LF_GUD_NO_FORMAT || n == (int)sizeof formats)
            return lf_error_set(err, LF_E_ARG, "--formats",
                                "expects at most %zu of rgb888, xrgb8888, rgb565, got \"%s\"",
                                sizeof formats, text);
        formats[n] = (uint8_t)format;
        word = word[length] == ',' ? word + length + 1 : NULL;
    }
    memcpy(config->formats, formats, sizeof formats);
    config->n_formats = n;
    return LF_OK;
}

static lf_status take_fault(const char *text, int *out, lf_error *err)
{
    for (int i = 0; i < LF_GUD_FAULTS; i++) {
        if (strcmp(text, faults[i]) == 0) {
            *out = i;
            return LF_OK;
        }
    }
    return lf_error_set(err, LF_E_ARG, "--fault",
                        "unknown fault \"%s\"; quiltsim --help lists the faults", text);
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    lf_simulator_config *config = context;
    const struct option_rule *rule = &rules[code - LF_OPTION_OWN];
    char where[64];
    void *to = (char *)config + rule->offset;
    snprintf(where, sizeof where, "--%s", rule->name);
    switch (rule->kind) {
    case FLAG:
        *(bool *)to = true;
        return LF_OK;
    case FILE_OF:
        *(const char **)to = text;
        return LF_OK;
    case SIZE:
        return take_size(config, text, err);
    case FORMATS:
        return take_formats(config, text, err);
    case FAULT:
        return take_fault(text, to, err);
    default:
        return take_whole(rule, where, text, to, err);
    }
}

/* Reads the command line; *out_done: only help or version was requested. */
static lf_status read_arguments(int argc, char *const argv[], lf_simulator_config *config,
                                bool *out_done, lf_error *err)
{
    struct option table[N_RULES + 1] = {0};
    for (int i = 0; i < N_RULES; i++)
        table[i] =
            (struct option){rules[i].name, rules[i].kind == FLAG ? no_argument : required_argument,
                            NULL, LF_OPTION_OWN + i};
    const lf_options_rules reading = {.program = PROGRAM,
                                      .letters = ":",
                                      .table = table,
                                      .former = former,
                                      .print_help = print_help,
                                      .take = take,
                                      .context = config};
    lf_status status = lf_options_read(argc, argv, &reading, out_done, err);
    if (status != LF_OK || *out_done)
        return status;
    return optind < argc
               ? lf_error_set(err, LF_E_ARG, argv[optind],
                              "unexpected argument; quiltsim takes only options (see --help)")
               : LF_OK;
}

int main(int argc, char *argv[])
{
    lf_simulator_config config = {.port = LF_USBIP_PORT};
    lf_error err = {0};
    bool done = false;
    lf_log_init(PROGRAM, LF_LOG_INFO);
    if (read_arguments(argc, argv, &config, &done, &err) != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    lf_status status = lf_simulator_run(&config, &err);
    if (status == LF_E_ARG)
        return lf_usage_error(PROGRAM, &err);
    if (status != LF_OK)
        lf_log_error(&err);
    return status == LF_OK ? LF_EXIT_OK : LF_EXIT_FAILED;
}
