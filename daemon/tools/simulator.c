#include "daemon/tools/simulator.h"

#include <arpa/inet.h>
#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/calibration.h"
#include "base/errno_text.h"
#include "base/image_io.h"
#include "base/log.h"
#include "base/thread.h"
#include "device/hid/buttons.h"
#include "device/model/usbip.h"
#include "device/model/vhci.h"
#include "device/usb/gud.h"

enum { MAX_CONNECTIONS = 16, MAX_LINE = 256, BACKLOG = 8 };

/* A factory-new panel, made again at every replug. */
typedef struct panel {
    lf_model_hid *hid;
    lf_model_gud *gud;
    lf_model *model;
} panel;

typedef struct simulator {
    const lf_simulator_config *config;
    lf_calibration calibration; /* size and name of the display */
    uint8_t eeprom[LF_MODEL_EEPROM_MAX];
    size_t n_eeprom;
    panel panel;
    lf_usbip_device device;
    int listen_fd, signal_fd; /* -1 = none */
    bool reads_stdin, ends;
    lf_usbip *connections[MAX_CONNECTIONS]; /* oldest first */
    int n_connections;
    char line[MAX_LINE];
    size_t n_line;
    bool line_too_long;
    uint64_t plugged_ns; /* time at which the current panel was plugged in */
    int64_t first_ms;    /* time from then to its first rectangle; -1 = none shown */
} simulator;

static void LF_PRINTF(1, 2) say(const char *fmt, ...)
{
    va_list arguments;
    va_start(arguments, fmt);
    vprintf(fmt, arguments);
    va_end(arguments);
    putchar('\n');
    fflush(stdout);
}

/* ------------------------------------------------------------------------------------- panel -- */

/* Numbers are wrapped as {"value": x}, as in real EEPROMs. NULL = out of memory; release with
 * free. */
static char *eeprom_text(const lf_calibration *c)
{
    const char *key;
    json_t *value, *wrapped = json_object(), *bare = lf_calibration_json(c);
    json_object_foreach(bare, key, value) json_object_set_new(
        wrapped, key,
        json_is_number(value) ? json_pack("{s:O}", "value", value) : json_incref(value));
    char *text = bare ? json_dumps(wrapped, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(bare);
    json_decref(wrapped);
    return text;
}

static lf_status fill_eeprom(simulator *s, const char *json, size_t n, const char *where,
                             lf_error *err)
{
    s->n_eeprom = lf_model_hid_eeprom(json, n, s->eeprom, sizeof s->eeprom);
    if (s->n_eeprom == 0)
        return lf_error_set(err, LF_E_FORMAT, where, "%zu bytes do not fit into an EEPROM of %d", n,
                            LF_MODEL_EEPROM_MAX);
    return LF_OK;
}

static lf_status fill_nominal(simulator *s, lf_error *err)
{
    char *text = eeprom_text(&s->calibration);
    if (!text)
        return lf_error_set(err, LF_E_NOMEM, "eeprom", "out of memory");
    lf_status status = fill_eeprom(s, text, strlen(text), "eeprom", err);
    free(text);
    return status;
}

/* The EEPROM accepts any file, also one that is not a calibration; the display's size must then be
 * given. */
static lf_status load_calibration(simulator *s, lf_error *err)
{
    const lf_simulator_config *config = s->config;
    char *text = NULL;
    size_t n = 0;
    lf_calibration_portrait(&s->calibration);
    if (config->width_px > 0) {
        s->calibration.screen_width_px = config->width_px;
        s->calibration.screen_height_px = config->height_px;
    }
    if (!config->calibration)
        return fill_nominal(s, err);
    lf_status status =
        lf_file_read(config->calibration, NULL, LF_CALIBRATION_MAX_BYTES, &text, &n, err);
    if (status == LF_OK)
        status = fill_eeprom(s, text, n, config->calibration, err);
    lf_calibration read;
    if (status == LF_OK) {
        lf_status parsed = lf_calibration_parse(text, n, config->calibration, &read, err);
        if (parsed == LF_OK && config->width_px == 0)
            s->calibration = read;
        else if (parsed == LF_OK)
            memcpy(s->calibration.serial, read.serial, sizeof read.serial);
        else if (config->width_px == 0 && !config->no_display)
            status = parsed;
    }
    lf_free(text);
    return status;
}

static lf_status make_display(const simulator *s, lf_model_gud **out)
{
    static const uint8_t rgb888 = LF_GUD_RGB888;
    const lf_simulator_config *config = s->config;
    uint8_t edid[128];
    char name[14];
    snprintf(name, sizeof name, "%.13s",
             strncmp(s->calibration.serial, "LKG", 3) == 0 ? s->calibration.serial
                                                           : "LKG-SIMULATED");
    lf_model_edid(name, name, s->calibration.screen_width_px, s->calibration.screen_height_px,
                  edid);
    const lf_model_gud_options options = {
        .width = s->calibration.screen_width_px,
        .height = s->calibration.screen_height_px,
        .formats = config->n_formats > 0 ? config->formats : &rgb888,
        .n_formats = config->n_formats > 0 ? config->n_formats : 1,
        .max_buffer_size = config->buffer_bytes,
        .lz4 = config->lz4,
        .full_update = config->full_update,
        .status_on_set = true,
        .edid = edid,
        .n_edid = sizeof edid,
    };
    return lf_model_gud_create(&options, &config->gud, out);
}

static void panel_finish(simulator *s)
{
    s->device = (lf_usbip_device){0};
    lf_model_destroy(s->panel.model);
    lf_model_gud_destroy(s->panel.gud);
    lf_model_hid_destroy(s->panel.hid);
    s->panel = (panel){0};
}

static lf_status panel_init(simulator *s, lf_error *err)
{
    lf_status status = LF_OK;
    if (!s->config->no_hid)
        status = lf_model_hid_create(s->eeprom, s->n_eeprom, &s->config->hid, &s->panel.hid);
    if (status == LF_OK && !s->config->no_display)
        status = make_display(s, &s->panel.gud);
    if (status == LF_OK)
        status = lf_model_create(s->panel.hid, s->panel.gud, &s->panel.model);
    if (status == LF_OK) {
        s->device = (lf_usbip_device){.model = s->panel.model, .gud = s->panel.gud};
        s->plugged_ns = lf_time_now_ns();
        s->first_ms = -1;
        return LF_OK;
    }
    panel_finish(s);
    return lf_error_set(err, status, "panel",
                        status == LF_E_NOMEM ? "out of memory"
                                             : "the display cannot have these properties");
}

typedef struct picture_rows {
    const uint8_t *pixels;
    size_t row_bytes;
} picture_rows;

static void copy_row(void *context, int y, uint8_t *row)
{
    const picture_rows *rows = context;
    memcpy(row, rows->pixels + (size_t)y * rows->row_bytes, rows->row_bytes);
}

/* Writes the panel's picture to the file. */
static lf_status write_picture(const simulator *s, lf_error *err)
{
    const char *path = s->config->panel_png;
    int width = s->calibration.screen_width_px, height = s->calibration.screen_height_px;
    if (!path || !s->panel.gud)
        return LF_OK;
    lf_outfile file;
    picture_rows rows = {lf_model_gud_pixels(s->panel.gud), (size_t)width * 3};
    lf_status status = lf_outfile_open(&file, path, true, err);
    if (status != LF_OK)
        return status;
    status = lf_png_write_rows(&file, width, height, copy_row, &rows, 1, NULL, 0, err);
    if (status == LF_OK)
        return lf_outfile_commit(&file, true, err);
    lf_outfile_abandon(&file);
    return status;
}

/* ------------------------------------------------------------------------------- connections -- */

static void drop_connection(simulator *s, int i)
{
    lf_usbip_destroy(s->connections[i]);
    s->n_connections--;
    memmove(&s->connections[i], &s->connections[i + 1],
            (size_t)(s->n_connections - i) * sizeof s->connections[0]);
}

/* Takes ownership of fd. If there are too many connections, closes the one that has waited longest
 * without importing. */
static lf_status add_connection(simulator *s, int fd, bool imported)
{
    lf_usbip *connection = NULL;
    int oldest = 0;
    while (s->n_connections == MAX_CONNECTIONS && lf_usbip_imported(s->connections[oldest]))
        oldest++; /* at most one has imported */
    if (s->n_connections == MAX_CONNECTIONS)
        drop_connection(s, oldest);
    lf_status status = lf_usbip_create(&s->device, fd, imported, &connection);
    if (status != LF_OK)
        close(fd);
    else
        s->connections[s->n_connections++] = connection;
    return status;
}

static lf_status plug_in(simulator *s, lf_error *err)
{
    int fd;
    if (!s->config->attach)
        return LF_OK;
    lf_status status = lf_vhci_attach(LF_VHCI_FOLDER, &fd, err);
    if (status == LF_OK && add_connection(s, fd, true) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, "usbip", "out of memory");
    return status;
}

static void run_connections(simulator *s)
{
    for (int i = 0; i < s->n_connections;) {
        lf_error err = {0};
        bool imported = lf_usbip_imported(s->connections[i]);
        lf_status status = lf_usbip_run(s->connections[i], lf_time_now_ns(), &err);
        if (!imported && lf_usbip_imported(s->connections[i]))
            say("attached");
        if (status == LF_OK) {
            i++;
            continue;
        }
        if (status != LF_E_NODEV)
            lf_log(LF_LOG_WARNING, "a connection ended: %s", err.what);
        drop_connection(s, i);
        if (imported)
            say("detached");
    }
}

static void take_connection(simulator *s)
{
    int fd = accept4(s->listen_fd, NULL, NULL, SOCK_CLOEXEC), on = 1;
    if (fd < 0)
        return; /* the peer has already gone */
    if (setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on) < 0)
        lf_log(LF_LOG_DEBUG, "cannot set TCP_NODELAY: %s", lf_errno_text(errno));
    if (add_connection(s, fd, false) != LF_OK)
        lf_log(LF_LOG_WARNING, "a connection was refused: out of memory");
}

static lf_status start_listening(simulator *s, int *out_port, lf_error *err)
{
    int on = 1;
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_port = htons((uint16_t)s->config->port)};
    socklen_t size = sizeof at;
    char where[64];
    snprintf(where, sizeof where, "127.0.0.1:%d", s->config->port);
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    s->listen_fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (s->listen_fd < 0 ||
        setsockopt(s->listen_fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) < 0 ||
        bind(s->listen_fd, (const struct sockaddr *)&at, sizeof at) < 0 ||
        listen(s->listen_fd, BACKLOG) < 0 ||
        getsockname(s->listen_fd, (struct sockaddr *)&at, &size) < 0)
        return lf_error_set(err, LF_E_IO, where, "cannot listen: %s", lf_errno_text(errno));
    *out_port = ntohs(at.sin_port);
    return LF_OK;
}

/* ---------------------------------------------------------------------------------- commands -- */

/* Records the time until the first picture. */
static void note_first(simulator *s)
{
    lf_model_gud_counters c;
    if (s->first_ms >= 0 || !s->panel.gud)
        return;
    lf_model_gud_counters_get(s->panel.gud, &c);
    if (c.rects > 0)
        s->first_ms = (int64_t)((lf_time_now_ns() - s->plugged_ns) / LF_NS_PER_MS);
}

static void unplug(simulator *s)
{
    for (int i = s->n_connections - 1; i >= 0; i--)
        if (lf_usbip_imported(s->connections[i]))
            drop_connection(s, i);
    panel_finish(s);
}

static lf_status replug(simulator *s, lf_error *err)
{
    unplug(s);
    lf_status status = panel_init(s, err);
    return status == LF_OK ? plug_in(s, err) : status;
}

static lf_status press(const simulator *s, const char *name, lf_error *err)
{
    for (int i = 0; i < LF_BUTTONS_N; i++) {
        if (strcmp(name, lf_button_name((lf_button)i)) != 0)
            continue;
        if (!s->panel.hid)
            return lf_error_set(err, LF_E_NODEV, "press",
                                "the panel is unplugged or has no buttons");
        lf_model_hid_press(s->panel.hid, (uint8_t)(1u << i));
        lf_model_hid_press(s->panel.hid, 0);
        return LF_OK;
    }
    return lf_error_set(err, LF_E_ARG, "press", "expects square, left, right or circle");
}

static void say_counters(const simulator *s)
{
    lf_model_gud_counters c = {0};
    if (s->panel.gud)
        lf_model_gud_counters_get(s->panel.gud, &c);
    say("lit=%d rects=%" PRIu64 " bytes=%" PRIu64 " compressed=%" PRIu64 " refused=%" PRIu64
        " violations=%" PRIu64 " first_ms=%" PRId64,
        s->panel.gud && lf_model_gud_lit(s->panel.gud), c.rects, c.bytes, c.compressed_rects,
        c.refused, s->panel.hid ? lf_model_hid_violations(s->panel.hid) : 0, s->first_ms);
}

static void take_line(simulator *s, const char *line)
{
    lf_error err = {0};
    lf_status status = LF_OK;
    if (strncmp(line, "press ", 6) == 0)
        status = press(s, line + 6, &err);
    else if (strcmp(line, "unplug") == 0)
        unplug(s);
    else if (strcmp(line, "replug") == 0)
        status = replug(s, &err);
    else if (strcmp(line, "picture") == 0)
        status = write_picture(s, &err);
    else if (strcmp(line, "counters") == 0)
        say_counters(s);
    else if (strcmp(line, "quit") == 0)
        s->ends = true;
    else
        status = lf_error_set(
            &err, LF_E_ARG, "stdin",
            "unknown command; expected press BUTTON, unplug, replug, picture, counters or quit");
    if (status == LF_OK)
        say("ok");
    else
        say("error: %s: %s", err.where, err.what);
}

static void read_commands(simulator *s)
{
    char bytes[512];
    ssize_t n = read(STDIN_FILENO, bytes, sizeof bytes);
    if (n < 0 && (errno == EAGAIN || errno == EINTR))
        return;
    if (n <= 0)
        s->reads_stdin = false;
    for (ssize_t i = 0; i < n; i++) {
        if (bytes[i] == '\n') {
            s->line[s->n_line] = 0;
            take_line(s, s->line_too_long ? "" : s->line);
            s->n_line = 0;
            s->line_too_long = false;
        } else if (s->n_line + 1 < sizeof s->line) {
            s->line[s->n_line++] = bytes[i];
        } else {
            s->line_too_long = true;
        }
    }
}

static void read_signals(simulator *s)
{
    struct signalfd_siginfo info;
    lf_error err;
    if (read(s->signal_fd, &info, sizeof info) != (ssize_t)sizeof info)
        return;
    if (info.ssi_signo != SIGUSR1)
        s->ends = true;
    else if (write_picture(s, &err) != LF_OK)
        lf_log_error(&err);
}

/* -------------------------------------------------------------------------------------- life -- */

static lf_status take_signals(simulator *s, lf_error *err)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGUSR1);
    s->signal_fd = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
    if (s->signal_fd < 0 || sigprocmask(SIG_BLOCK, &set, NULL) < 0)
        return lf_error_set(err, LF_E_IO, "signals", "%s", lf_errno_text(errno));
    return LF_OK;
}

static void loop(simulator *s)
{
    while (!s->ends) {
        struct pollfd fds[3 + MAX_CONNECTIONS] = {
            {.fd = s->reads_stdin ? STDIN_FILENO : -1, .events = POLLIN},
            {.fd = s->signal_fd, .events = POLLIN},
            {.fd = s->listen_fd, .events = POLLIN},
        };
        int timeout_ms = -1;
        uint64_t now = lf_time_now_ns();
        for (int i = 0; i < s->n_connections; i++) {
            int ms = lf_usbip_poll(s->connections[i], now, &fds[3 + i]);
            if (ms >= 0 && (timeout_ms < 0 || ms < timeout_ms))
                timeout_ms = ms;
        }
        if (poll(fds, 3 + (nfds_t)s->n_connections, timeout_ms) < 0)
            continue; /* EINTR */
        if (fds[1].revents)
            read_signals(s);
        if (fds[0].revents)
            read_commands(s);
        if (fds[2].revents)
            take_connection(s);
        run_connections(s);
        note_first(s);
    }
}

static lf_status start(simulator *s, lf_error *err)
{
    int port = 0;
    lf_status status = load_calibration(s, err);
    if (status == LF_OK)
        status = take_signals(s, err);
    if (status == LF_OK)
        status = panel_init(s, err);
    if (status == LF_OK)
        status = s->config->attach ? plug_in(s, err) : start_listening(s, &port, err);
    if (status != LF_OK)
        return status;
    if (s->config->attach)
        say("attached to %s", LF_VHCI_FOLDER);
    else if (port == LF_USBIP_PORT)
        say("as root: modprobe vhci_hcd && usbip attach -r 127.0.0.1 -b %s", LF_USBIP_BUSID);
    else
        say("as root: modprobe vhci_hcd && usbip --tcp-port %d attach -r 127.0.0.1 -b %s", port,
            LF_USBIP_BUSID);
    return LF_OK;
}

lf_status lf_simulator_run(const lf_simulator_config *config, lf_error *err)
{
    if (config->no_hid && config->no_display)
        return lf_error_set(
            err, LF_E_ARG, "--no-hid",
            "cannot be combined with --no-display, because no part of the panel would remain");
    simulator *s = lf_calloc(1, sizeof *s);
    if (!s)
        return lf_error_set(err, LF_E_NOMEM, "quiltsim", "out of memory");
    s->config = config;
    s->listen_fd = s->signal_fd = -1;
    s->reads_stdin = true;
    lf_status status = start(s, err);
    if (status == LF_OK) {
        loop(s);
        status = write_picture(s, err);
    }
    while (s->n_connections > 0)
        drop_connection(s, s->n_connections - 1);
    panel_finish(s);
    if (s->listen_fd >= 0)
        close(s->listen_fd);
    if (s->signal_fd >= 0)
        close(s->signal_fd);
    lf_free(s);
    return status;
}
