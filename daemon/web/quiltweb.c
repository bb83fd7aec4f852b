/* quiltweb: quiltd in a browser. See docs/man/quiltweb.1. */
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/stat.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/file.h"
#include "base/log.h"
#include "base/number.h"
#include "daemon/output/options.h"
#include "daemon/web/listen.h"
#include "daemon/web/web.h"
#include "daemon/wire/listen.h"

#define PROGRAM "quiltweb"
#define V4 "127.0.0.1:8033"
#define V6 "[::1]:8033"
#define MAX_UPLOAD_MIB 65536
#define TEXT_OF(number) #number
#define TEXT(number) TEXT_OF(number)

enum {
    OPTION_SOCKET = LF_OPTION_OWN,
    OPTION_LISTEN,
    OPTION_URL_FILE,
    OPTION_PUBLIC,
    OPTION_UPLOAD_LIMIT,
    OPTION_UNTIL,
};

static const struct option table[] = {
    {"socket", required_argument, NULL, OPTION_SOCKET},
    {"listen", required_argument, NULL, OPTION_LISTEN},
    {"url-file", required_argument, NULL, OPTION_URL_FILE},
    {"public", required_argument, NULL, OPTION_PUBLIC},
    {"upload-limit", required_argument, NULL, OPTION_UPLOAD_LIMIT},
    {"until-input-ends", no_argument, NULL, OPTION_UNTIL},
    {0},
};

typedef struct arguments {
    const char *socket, *url_file, *public_origin;
    const char *listen[LF_WEB_MAX_LISTENERS];
    int n_listen;
    uint64_t upload_mib;
    bool until_input_ends;
} arguments;

static void print_help(void)
{
    printf(
        "Usage: quiltweb [--socket PATH] [--listen ADDRESS] [--url-file FILE]\n"
        "                [--public ORIGIN] [--upload-limit MIB]\n"
        "Show what quiltd shows in a browser of this machine, and steer it there.\n"
        "Prints the URL of the page, with a token that opens it.\n"
        "\n"
        "  --socket PATH          socket of quiltd ($QUILTD_SOCKET, $XDG_RUNTIME_DIR/"
        "quiltd.sock,\n"
        "                         /run/quiltd/control.sock)\n"
        "  --listen ADDRESS       127.0.0.1:PORT or [::1]:PORT; port 0: any free one; may be\n"
        "                         given for both (" V4 " and " V6 ")\n"
        "  --public ORIGIN        the page is reached as https://NAME, through a server with TLS\n"
        "                         on this machine that keeps the Host header\n"
        "  --url-file FILE        write the URL into this file instead of printing it\n"
        "  --until-input-ends     exit when standard input is closed\n"
        "  --upload-limit MIB     memory of all uploads together, 1 to " TEXT(
            MAX_UPLOAD_MIB) "\n"
                            "                         (" TEXT(
                                LF_WEB_UPLOAD_LIMIT_MIB) ")\n"
                                                         "\n" LF_OPTIONS_HELP_LAST
                                                             LF_OPTIONS_HELP_SHELLS);
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

/* systemd's sockets, or our own. */
static lf_status open_listeners(const arguments *a, int fds[LF_WEB_MAX_LISTENERS], int *out_n,
                                lf_error *err)
{
    static const char *const both[] = {V4, V6};
    const int n = sd_listen_fds(1);
    if (n > LF_WEB_MAX_LISTENERS || (n > 0 && a->n_listen > 0))
        return lf_error_set(err, LF_E_ARG, "systemd",
                            "expects one or two sockets from the socket unit, and then no "
                            "--listen");
    if (n < 1)
        return a->n_listen > 0 ? lf_web_listen_all(a->listen, a->n_listen, fds, out_n, err)
                               : lf_web_listen_all(both, 2, fds, out_n, err);
    for (int i = 0; i < n; i++)
        fds[i] = SD_LISTEN_FDS_START + i;
    *out_n = n;
    return LF_OK;
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

static void close_all(const int *fds, int n)
{
    for (int i = 0; i < n; i++)
        close(fds[i]);
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

static lf_status run(const arguments *a, lf_error *err)
{
    char path[512];
    int fds[LF_WEB_MAX_LISTENERS];
    sd_event *event = NULL;
    lf_web *web = NULL;
    lf_web_config config = {.listen_fds = fds,
                            .socket = find_socket(a->socket, path, sizeof path),
                            .public_origin = a->public_origin,
                            .upload_limit = a->upload_mib << 20};
    lf_status status = open_listeners(a, fds, &config.n_listen_fds, err);
    if (status != LF_OK)
        return status;
    if (sd_event_new(&event) < 0 || sd_event_add_signal(event, NULL, SIGINT, NULL, NULL) < 0 ||
        sd_event_add_signal(event, NULL, SIGTERM, NULL, NULL) < 0) {
        close_all(fds, config.n_listen_fds);
        sd_event_unref(event);
        return lf_error_set(err, LF_E_NOMEM, "", "out of memory");
    }
    status = lf_web_create(event, &config, &web, err);
    if (status == LF_OK && a->until_input_ends)
        status = watch_input(event, err);
    if (status == LF_OK)
        status = announce(web, a->url_file, err);
    if (status == LF_OK) {
        sd_notify(0, "READY=1");
        sd_event_loop(event);
        sd_notify(0, "STOPPING=1");
    }
    lf_web_destroy(web);
    sd_event_unref(event);
    return status;
}

int main(int argc, char *argv[])
{
    arguments a = {.upload_mib = LF_WEB_UPLOAD_LIMIT_MIB};
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
