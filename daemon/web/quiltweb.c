/* quiltweb: quiltd in a browser. See docs/man/quiltweb.1. */
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/stat.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/file.h"
#include "base/log.h"
#include "base/number.h"
#include "daemon/output/options.h"
#include "daemon/web/bin.h"
#include "daemon/web/bridge.h"
#include "daemon/web/listen.h"
#include "daemon/web/nng.h"
#include "daemon/web/programs.h"
#include "daemon/web/web.h"
#include "daemon/wire/listen.h"

#define PROGRAM "quiltweb"
#define PAGE_PORT 8033
#define BRIDGE_PORT 33334
#define EVENTS_PORT 9724
#define WEBXR_PORT 11222
#define MAX_UPLOAD_MIB 65536
#define MAX_IMAGE_MIB 4096

enum {
    OPTION_SOCKET = LF_OPTION_OWN,
    OPTION_LISTEN,
    OPTION_URL_FILE,
    OPTION_PUBLIC,
    OPTION_UPLOAD_LIMIT,
    OPTION_UNTIL,
    OPTION_BRIDGE,
    OPTION_WEBXR,
    OPTION_ALLOW_ORIGIN,
    OPTION_NNG,
    OPTION_IMAGE_LIMIT,
    OPTION_PANEL_ONLY,
    OPTION_BRIDGE_VERSION,
};

static const struct option table[] = {
    {"socket", required_argument, NULL, OPTION_SOCKET},
    {"listen", required_argument, NULL, OPTION_LISTEN},
    {"url-file", required_argument, NULL, OPTION_URL_FILE},
    {"public", required_argument, NULL, OPTION_PUBLIC},
    {"upload-limit", required_argument, NULL, OPTION_UPLOAD_LIMIT},
    {"until-input-ends", no_argument, NULL, OPTION_UNTIL},
    {"bridge", optional_argument, NULL, OPTION_BRIDGE},
    {"webxr", optional_argument, NULL, OPTION_WEBXR},
    {"allow-origin", required_argument, NULL, OPTION_ALLOW_ORIGIN},
    {"nng", optional_argument, NULL, OPTION_NNG},
    {"image-limit", required_argument, NULL, OPTION_IMAGE_LIMIT},
    {"panel-only", no_argument, NULL, OPTION_PANEL_ONLY},
    {"bridge-version", required_argument, NULL, OPTION_BRIDGE_VERSION},
    {0},
};

typedef struct arguments {
    const char *socket, *url_file, *public_origin, *bridge_version;
    const char *listen[LF_WEB_MAX_LISTENERS];
    int n_listen;
    uint64_t upload_mib;
    bool until_input_ends;
    bool wanted[LF_SERVICES]; /* services of programs … */
    int ports[LF_SERVICES];   /* … and their ports */
    lf_origins allowed;
    const char *nng; /* path; NULL: none */
    uint64_t image_mib;
    bool panel_only;
} arguments;

static void print_help(void)
{
    printf("Usage: quiltweb [--socket PATH] [--listen ADDRESS] [--url-file FILE]\n"
           "                [--public ORIGIN] [--upload-limit MIB]\n"
           "                [--bridge[=PORT,PORT]] [--webxr[=PORT]] [--allow-origin ORIGIN]\n"
           "                [--bridge-version VERSION] [--nng[=PATH]] [--image-limit MIB]\n"
           "                [--panel-only]\n"
           "Show what quiltd shows in a browser of this machine, and steer it there.\n"
           "Prints the URL of the page, with a token that opens it.\n"
           "\n"
           "  --socket PATH          socket of quiltd ($QUILTD_SOCKET, $XDG_RUNTIME_DIR/"
           "quiltd.sock,\n"
           "                         /run/quiltd/control.sock)\n"
           "  --listen ADDRESS       127.0.0.1:PORT or [::1]:PORT; port 0: any free one; may be\n"
           "                         given for both (127.0.0.1:%d and [::1]:%d)\n"
           "  --public ORIGIN        the page is reached as https://NAME; a server with TLS here\n"
           "                         keeps the Host header\n"
           "  --url-file FILE        write the URL into this file instead of printing it\n"
           "  --until-input-ends     exit when standard input is closed\n"
           "  --upload-limit MIB     memory of all uploads together, 1 to %d\n"
           "                         (%d)\n",
           PAGE_PORT, PAGE_PORT, MAX_UPLOAD_MIB, LF_WEB_UPLOAD_LIMIT_MIB);
    printf("  --bridge[=PORT,PORT]   answer programs that speak to Looking Glass Bridge: requests\n"
           "                         and events (%d,%d)\n"
           "  --webxr[=PORT]         answer WebXR pages (%d)\n"
           "  --allow-origin ORIGIN  let pages of ORIGIN ask there; repeatable;\n"
           "                         http://localhost:* is any port of this machine (none)\n"
           "  --nng[=PATH]           answer programs by nng's ipc, such as AliceLG\n"
           "                         (%s)\n"
           "  --image-limit MIB      largest image that a program may send, 1 to %d (%d)\n"
           "  --panel-only           only answer what panel there is; quiltd lends it meanwhile\n"
           "  --bridge-version VERSION\n"
           "                         version of Bridge that programs are told (" LF_BRIDGE_VERSION
           ")\n"
           "\n" LF_OPTIONS_HELP_LAST LF_OPTIONS_HELP_SHELLS,
           BRIDGE_PORT, EVENTS_PORT, WEBXR_PORT, LF_NNG_PATH, MAX_IMAGE_MIB, LF_BIN_LIMIT_MIB);
}

/* "PORT", or "PORT,PORT" for two services. */
static lf_status take_ports(arguments *a, const char *option, const char *text, lf_service first,
                            lf_service last, lf_error *err)
{
    char part[8];
    for (int i = first; i <= (int)last; i++)
        a->wanted[i] = true;
    for (int i = first; text; i++) {
        const size_t n = strcspn(text, ",");
        uint64_t port = 0;
        snprintf(part, sizeof part, "%.*s", (int)(n < sizeof part ? n : sizeof part - 1), text);
        if (!lf_whole_is(part, &port) || port > UINT16_MAX || (text[n] == ',') != (i < (int)last))
            return lf_error_set(err, LF_E_ARG, option, "expects %s, got \"%s\"",
                                first < last ? "PORT,PORT" : "PORT", text);
        a->ports[i] = (int)port;
        text = text[n] ? text + n + 1 : NULL;
    }
    return LF_OK;
}

/* bridge.js reads the first two numbers. */
static lf_status take_version(arguments *a, const char *text, lf_error *err)
{
    const size_t n = strlen(text);
    if (n < 1 || n > 31 || strspn(text, "0123456789.") != n || text[0] == '.')
        return lf_error_set(err, LF_E_ARG, "--bridge-version",
                            "expects numbers with points, for example 2.6.3, got \"%s\"", text);
    a->bridge_version = text;
    return LF_OK;
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    arguments *a = context;
    if (code == OPTION_SOCKET)
        a->socket = text;
    else if (code == OPTION_UNTIL)
        a->until_input_ends = true;
    else if (code == OPTION_PUBLIC)
        a->public_origin = text;
    else if (code == OPTION_URL_FILE)
        a->url_file = text;
    else if (code == OPTION_UPLOAD_LIMIT && (!lf_whole_is(text, &a->upload_mib) ||
                                             a->upload_mib < 1 || a->upload_mib > MAX_UPLOAD_MIB))
        return lf_error_set(err, LF_E_ARG, "--upload-limit", "expects 1 to %d MiB, got \"%s\"",
                            MAX_UPLOAD_MIB, text);
    else if (code == OPTION_NNG && text && text[0] == '\0')
        return lf_error_set(err, LF_E_ARG, "--nng", "expects a path, or no \"=\" at all");
    else if (code == OPTION_NNG)
        a->nng = text ? text : LF_NNG_PATH;
    else if (code == OPTION_PANEL_ONLY)
        a->panel_only = true;
    else if (code == OPTION_IMAGE_LIMIT && (!lf_whole_is(text, &a->image_mib) || a->image_mib < 1 ||
                                            a->image_mib > MAX_IMAGE_MIB))
        return lf_error_set(err, LF_E_ARG, "--image-limit", "expects 1 to %d MiB, got \"%s\"",
                            MAX_IMAGE_MIB, text);
    else if (code == OPTION_BRIDGE)
        return take_ports(a, "--bridge", text, LF_SERVICE_BRIDGE, LF_SERVICE_EVENTS, err);
    else if (code == OPTION_WEBXR)
        return take_ports(a, "--webxr", text, LF_SERVICE_WEBXR, LF_SERVICE_WEBXR, err);
    else if (code == OPTION_BRIDGE_VERSION)
        return take_version(a, text, err);
    else if (code == OPTION_ALLOW_ORIGIN)
        return lf_origins_add(&a->allowed, text, err);
    else if (code == OPTION_LISTEN && a->n_listen == LF_WEB_MAX_LISTENERS)
        return lf_error_set(err, LF_E_ARG, "--listen", "may be given twice at most");
    else if (code == OPTION_LISTEN)
        a->listen[a->n_listen++] = text;
    return LF_OK;
}

static lf_status read_arguments(int argc, char *const argv[], arguments *a, bool *out_done,
                                lf_error *err)
{
    const lf_options_rules rules = {.program = PROGRAM,
                                    .letters = ":",
                                    .table = table,
                                    .print_help = print_help,
                                    .take = take,
                                    .context = a};
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);
    if (status != LF_OK || *out_done || optind == argc)
        return status;
    return lf_error_set(err, LF_E_ARG, argv[optind],
                        "unexpected argument; quiltweb takes only options (see --help)");
}

/* The first default socket that exists, else the first of all. */
static const char *find_socket(const char *given, char *path, size_t size)
{
    if (given)
        return given;
    for (int i = 0; lf_default_socket(i, path, size); i++)
        if (access(path, F_OK) == 0)
            return path;
    (void)lf_default_socket(0, path, size);
    return path;
}

/* The sockets that systemd passes, by their names. */
static lf_status take_sockets(lf_web_sockets services[LF_SERVICES], int *out_nng, lf_error *err)
{
    static const char *const names[LF_SERVICES] = {"page", "bridge", "events", "webxr"};
    char **given = NULL;
    const int n = sd_listen_fds_with_names(1, &given);
    lf_status status = LF_OK;
    for (int i = 0; i < n; i++) {
        lf_service service = LF_SERVICES - 1;
        if (*out_nng < 0 && given && strcmp(given[i], "nng") == 0) {
            *out_nng = SD_LISTEN_FDS_START + i;
            continue;
        }
        while (service > LF_SERVICE_PAGE && (!given || strcmp(names[service], given[i]) != 0))
            service--; /* the page's are without a name, too */
        if (status == LF_OK && services[service].n == LF_WEB_MAX_LISTENERS)
            status = lf_error_set(err, LF_E_ARG, "systemd",
                                  "expects one or two sockets named %s from the socket unit",
                                  names[service]);
        if (status == LF_OK)
            services[service].fd[services[service].n++] = SD_LISTEN_FDS_START + i;
        else
            close(SD_LISTEN_FDS_START + i);
    }
    for (int i = 0; given && i < n; i++)
        free(given[i]);
    free(given);
    return status;
}

/* A service that is wanted has systemd's sockets, or our own, but not both. */
static lf_status open_service(lf_web_sockets *sockets, bool asked, int port, lf_error *err)
{
    if (asked && sockets->n > 0)
        return lf_error_set(
            err, LF_E_ARG, "systemd",
            "passes sockets for a service; leave out its option (--listen, --bridge, "
            "--webxr)");
    return asked ? lf_web_listen_port(port, sockets, err) : LF_OK;
}

static lf_status open_services(const arguments *a, lf_web_sockets services[LF_SERVICES],
                               int *out_nng, lf_error *err)
{
    lf_web_sockets *page = &services[LF_SERVICE_PAGE];
    lf_status status = take_sockets(services, out_nng, err);
    const bool passed = page->n > 0;
    if (status == LF_OK && a->n_listen > 0)
        status = passed ? open_service(page, true, 0, err)
                        : lf_web_listen_all(a->listen, a->n_listen, page->fd, &page->n, err);
    else if (status == LF_OK && !passed)
        status = open_service(page, true, PAGE_PORT, err);
    for (int i = LF_SERVICE_PAGE + 1; i < LF_SERVICES && status == LF_OK; i++)
        status = open_service(&services[i], a->wanted[i], a->ports[i], err);
    int n_programs = 0;
    for (int i = LF_SERVICE_PAGE + 1; i < LF_SERVICES; i++)
        n_programs += services[i].n;
    if (status == LF_OK && n_programs == 0 && (a->allowed.n > 0 || a->allowed.local))
        lf_log(LF_LOG_WARNING, "--allow-origin: has no effect without --bridge or --webxr");
    for (int i = 0; i < LF_SERVICES && status != LF_OK; i++)
        lf_web_sockets_close(&services[i]);
    if (status != LF_OK && *out_nng >= 0)
        close(*out_nng);
    return status;
}

/* The ports of the services of programs, which may be any free ones. */
static void log_services(const lf_web *web)
{
    static const char *const words[LF_SERVICES] = {NULL, "requests of Bridge", "events of Bridge",
                                                   "WebXR"};
    for (lf_service service = LF_SERVICE_PAGE + 1; service < LF_SERVICES; service++)
        if (lf_web_port(web, service) > 0)
            lf_log(LF_LOG_INFO, "%s: port %d", words[service], lf_web_port(web, service));
}

static lf_status announce(const lf_web *web, const char *file, lf_error *err)
{
    char line[LF_WEB_URL_SIZE + 1];
    snprintf(line, sizeof line, "%s\n", lf_web_url(web));
    if (file)
        return lf_outfile_text(file, line, err);
    if (fputs(line, stdout) < 0 || fflush(stdout) != 0)
        return lf_error_set(err, LF_E_IO, "standard output", "cannot write the URL");
    return LF_OK;
}

static int on_input(sd_event_source *source, int fd, uint32_t what, void *context)
{
    char ignored[512];
    (void)what;
    (void)context;
    const ssize_t n = read(fd, ignored, sizeof ignored);
    if (n > 0 || (n < 0 && (errno == EAGAIN || errno == EINTR)))
        return 0;
    return sd_event_exit(sd_event_source_get_event(source), 0);
}

static lf_status watch_input(sd_event *event, lf_error *err)
{
    return sd_event_add_io(event, NULL, STDIN_FILENO, EPOLLIN, on_input, NULL) >= 0
               ? LF_OK
               : lf_error_set(err, LF_E_ARG, "--until-input-ends",
                              "expects a pipe or a terminal as standard input");
}

/* What runs until the end of the loop. */
typedef struct running {
    lf_programs *programs;
    lf_web *web;
} running;

/* Takes the sockets of the services, and nng. */
static lf_status begin(const arguments *a, sd_event *event, lf_web_config *config, int nng,
                       running *out, lf_error *err)
{
    const lf_programs_config programs = {.socket = config->socket,
                                         .version = a->bridge_version ? a->bridge_version
                                                                      : LF_BRIDGE_VERSION,
                                         .image_limit = a->image_mib << 20,
                                         .panel_only = a->panel_only,
                                         .nng_path = a->nng,
                                         .nng_fd = nng};
    lf_status status = lf_programs_create(event, &programs, &out->programs, err);
    if (status != LF_OK) {
        for (int i = 0; i < LF_SERVICES; i++)
            lf_web_sockets_close(&config->services[i]);
        return status;
    }
    config->driver = lf_programs_driver(out->programs);
    config->panel_only = lf_programs_panel(out->programs);
    return lf_web_create(event, config, &out->web, err);
}

static lf_status run(const arguments *a, lf_error *err)
{
    char path[512];
    sd_event *event = NULL;
    running s = {0};
    int nng = -1;
    lf_web_config config = {.allowed = &a->allowed,
                            .bridge_version = a->bridge_version,
                            .socket = find_socket(a->socket, path, sizeof path),
                            .public_origin = a->public_origin,
                            .upload_limit = a->upload_mib << 20};
    if (sd_event_new(&event) < 0 || sd_event_add_signal(event, NULL, SIGINT, NULL, NULL) < 0 ||
        sd_event_add_signal(event, NULL, SIGTERM, NULL, NULL) < 0) {
        sd_event_unref(event);
        return lf_error_set(err, LF_E_NOMEM, "", "out of memory");
    }
    lf_status status = open_services(a, config.services, &nng, err);
    if (status == LF_OK)
        status = begin(a, event, &config, nng, &s, err);
    if (status == LF_OK && a->until_input_ends)
        status = watch_input(event, err);
    if (status == LF_OK)
        status = announce(s.web, a->url_file, err);
    if (status == LF_OK) {
        log_services(s.web);
        sd_notify(0, "READY=1");
        sd_event_loop(event);
        sd_notify(0, "STOPPING=1");
    }
    lf_web_destroy(s.web);
    lf_programs_destroy(s.programs);
    sd_event_unref(event);
    return status;
}

int main(int argc, char *argv[])
{
    arguments a = {.upload_mib = LF_WEB_UPLOAD_LIMIT_MIB,
                   .image_mib = LF_BIN_LIMIT_MIB,
                   .ports = {PAGE_PORT, BRIDGE_PORT, EVENTS_PORT, WEBXR_PORT}};
    lf_error err = {0};
    bool done = false;
    sigset_t signals;
    lf_log_init(PROGRAM, LF_LOG_INFO);
    if (read_arguments(argc, argv, &a, &done, &err) != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    umask(077); /* the URL is for its user alone */
    signal(SIGPIPE, SIG_IGN);
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    sigprocmask(SIG_BLOCK, &signals, NULL);
    lf_status status = run(&a, &err);
    if (status == LF_E_ARG)
        return lf_usage_error(PROGRAM, &err);
    if (status != LF_OK)
        lf_log_error(&err);
    return status == LF_OK ? LF_EXIT_OK : LF_EXIT_FAILED;
}
