/* quiltctl: one call to quiltd. See docs/man/quiltctl.1. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/frame_name.h"
#include "base/log.h"
#include "daemon/output/options.h"
#include "daemon/server/methods.h"
#include "daemon/tools/ctl.h"
#include "daemon/tools/ctl_files.h"
#include "daemon/tools/ctl_help.h"
#include "daemon/wire/prometheus.h"
#include "device/device.h"

#define PROGRAM "quiltctl"

enum { OPTION_SOCKET = LF_OPTION_OWN, OPTION_JSON, OPTION_FORMAT, OPTION_ALL, OPTION_TIMEOUT };

typedef enum format { FORMAT_TEXT, FORMAT_JSON, FORMAT_PROMETHEUS } format;

/* Names of formats; NULL after the last. */
static const char *format_at(int index)
{
    static const char *const names[] = {"text", "json", "prometheus"};
    return index <= FORMAT_PROMETHEUS ? names[index] : NULL;
}

static const lf_options_words words[] = {{"format", format_at}, {0}};

static const struct option table[] = {
    {"socket", required_argument, NULL, OPTION_SOCKET},   {"json", no_argument, NULL, OPTION_JSON},
    {"format", required_argument, NULL, OPTION_FORMAT},   {"all", no_argument, NULL, OPTION_ALL},
    {"timeout", required_argument, NULL, OPTION_TIMEOUT}, {NULL, 0, NULL, 0},
};

typedef struct arguments {
    const char *socket;
    format format;
    bool all;       /* every field of status */
    double timeout; /* seconds; 0 = none */
    const char *method;
    const char *file;   /* to be written (writes_file) or of quilt.show; NULL: another method */
    char *const *words; /* words after the method and this file */
    int n_words;
} arguments;

static void print_help(void)
{
    printf("Usage: quiltctl [--socket PATH] [--json] METHOD [key=value ...]\n"
           "       quiltctl [--socket PATH] watch\n"
           "       quiltctl [--socket PATH] doctor\n"
           "       quiltctl [--socket PATH] frame.get FILE [key=value ...]\n"
           "       quiltctl [--socket PATH] library.thumbnail FILE file=IMAGE [width=PIXELS]\n"
           "       quiltctl [--socket PATH] quilt.show FILE columns=N rows=N [key=value ...]\n"
           "       quiltctl [--socket PATH] export "
           "quilt|still|views|pictures|panel|print|chart|proof|rgbd|state FILE\n"
           "                [key=value ...]\n"
           "       quiltctl METHOD --help\n"
           "Call a method of a running quiltd and print the result. The method's schema gives the "
           "types; key:=JSON is raw JSON.\n"
           "`quiltctl hello` lists the methods. Examples: status, scene.load file=PATH, "
           "scene.patch patch:=JSON,\n"
           "camera.orbit yaw=5, wait for=complete, render.set paused=true, device.list, shutdown.\n"
           "`quiltctl METHOD --help` prints parameters and results of a method; it needs no "
           "daemon.\n"
           "`quiltctl doctor` checks what this machine needs to show an image on a panel; it needs "
           "no daemon.\n"
           "quiltctl opens exports, scenes and their files with your own rights, in any folder.\n\n"
           "  --socket PATH          socket of the daemon ($QUILTD_SOCKET, "
           "$XDG_RUNTIME_DIR/quiltd.sock,\n"
           "                         /run/quiltd/control.sock)\n"
           "  --json                 print the result as JSON\n"
           "  --format FORMAT        print the result as text (default), json or prometheus\n"
           "                         (status only)\n"
           "  --all                  print all fields of status, one per line\n"
           "  --timeout SECONDS      exit with status 1 if no answer arrives in "
           "time\n" LF_OPTIONS_HELP_LAST LF_OPTIONS_HELP_SHELLS
           "Exit status: 0; 1 if the daemon returned an error; 2 for wrong usage; 3 if no daemon "
           "answers.\n");
}

static lf_status take_format(arguments *a, const char *text, lf_error *err)
{
    for (int i = 0; format_at(i); i++) {
        if (strcmp(text, format_at(i)) == 0) {
            a->format = (format)i;
            return LF_OK;
        }
    }
    return lf_error_set(err, LF_E_ARG, "--format", "\"%.40s\": expected text, json or prometheus",
                        text);
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    arguments *a = context;
    if (code == OPTION_TIMEOUT)
        return lf_parse_double("--timeout", text, 1e-3, 1e9, &a->timeout, err);
    if (code == OPTION_FORMAT)
        return take_format(a, text, err);
    if (code == OPTION_SOCKET)
        a->socket = text;
    else if (code == OPTION_ALL)
        a->all = true;
    else
        a->format = FORMAT_JSON;
    return LF_OK;
}

/* The daemon writes the result of these methods into a file of the caller. */
static bool writes_file(const char *method)
{
    return strcmp(method, "frame.get") == 0 || strcmp(method, "library.thumbnail") == 0;
}

static lf_status read_arguments(int argc, char *const argv[], arguments *a, bool *out_done,
                                lf_error *err)
{
    const lf_options_rules rules = {.program = PROGRAM,
                                    .letters = ":",
                                    .table = table,
                                    .print_help = print_help,
                                    .take = take,
                                    .context = a,
                                    .words = words,
                                    .operand_at = lf_ctl_operand_at,
                                    .follower_at = lf_ctl_follower_at};
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);
    if (status != LF_OK || *out_done)
        return status;
    if (optind >= argc)
        return lf_error_set(err, LF_E_ARG, "METHOD", "is missing; see quiltctl --help");
    a->method = argv[optind];
    a->words = argv + optind + 1;
    a->n_words = argc - optind - 1;
    const bool shows = strcmp(a->method, "quilt.show") == 0;
    if (shows || writes_file(a->method)) {
        if (a->n_words == 0 || strchr(a->words[0], '='))
            return lf_error_set(err, LF_E_ARG, a->method,
                                shows ? "expects the name of an image file first, such as quilt.png"
                                      : "expects the name of a file to write first, such as "
                                        "image.jpg");
        a->file = *a->words++;
        a->n_words--;
    }
    const bool of_status = strcmp(a->method, "status") == 0;
    if (a->all && !of_status)
        return lf_error_set(err, LF_E_ARG, "--all", "is only available for the method status");
    if (a->format == FORMAT_PROMETHEUS && !of_status)
        return lf_error_set(err, LF_E_ARG, "--format",
                            "prometheus is only available for the method status");
    return LF_OK;
}

/* Makes paths absolute, because the daemon has another working folder. */
static void make_absolute(json_t *params, const char *key)
{
    const char *path = json_string_value(json_object_get(params, key));
    char *here = path && path[0] != '\0' && path[0] != '/' ? getcwd(NULL, 0) : NULL;
    char *joined = here ? lf_path_join(here, path) : NULL;
    if (joined)
        json_object_set_new(params, key, json_string(joined));
    lf_free(joined);
    free(here);
}

/* A profile may also be a name. */
static void make_profile_absolute(json_t *params, const char *key)
{
    const char *name = json_string_value(json_object_get(params, key));
    if (name && lf_profile_is_path(name))
        make_absolute(params, key);
}

/* Makes the folder in a device's spec absolute. */
static void make_spec_absolute(json_t *params)
{
    const char *spec = json_string_value(json_object_get(params, "spec"));
    size_t n;
    const char *folder = spec ? lf_device_folder(spec, &n) : NULL;
    char *here = folder && folder[0] != '/' ? getcwd(NULL, 0) : NULL;
    if (here)
        json_object_set_new(params, "spec",
                            json_sprintf("%.*s%s/%s", (int)(folder - spec), spec, here, folder));
    free(here);
}

/* The daemon writes a detached export by name, since quiltctl does not wait for its end. */
static bool is_detached(const json_t *params)
{
    return json_is_true(json_object_get(params, "detach"));
}

static bool is_farmed(const json_t *params)
{
    return json_object_get(params, "farm");
}

/* Also those of the entries of playlist.set. */
static void make_all_absolute(json_t *params)
{
    size_t i;
    json_t *entry;
    if (!is_detached(params) &&
        !is_farmed(params)) /* otherwise relative to the daemon's --export-dir */
        make_absolute(params, "file");
    make_absolute(params, "icc");
    make_profile_absolute(params, "lens");
    make_profile_absolute(params, "printer");
    make_absolute(params, "folder");
    make_spec_absolute(params);
    json_array_foreach(json_object_get(params, "entries"), i, entry)
    {
        make_absolute(entry, "file");
    }
}

/* Parses the words with the method's schema. first: number of positional words (export's kind and
 * file). */
static lf_status read_words(const arguments *a, const json_t *schema, json_t *params, lf_error *err)
{
    static const char *const positional[] = {"kind", "file"};
    bool export = strcmp(a->method, "export") == 0;
    int n_positional = 0;
    for (int i = 0; i < a->n_words; i++) {
        if (export && n_positional < 2 && !strchr(a->words[i], '=')) {
            json_object_set_new(params, positional[n_positional++], json_string(a->words[i]));
            continue;
        }
        lf_status status = lf_schema_argument(schema, a->words[i], params, err);
        if (status != LF_OK)
            return status;
    }
    make_all_absolute(params);
    return lf_schema_check(schema, params, a->method, err);
}

/* The schema of a method in the daemon's `hello`. LF_E_ARG: unknown method. */
static lf_status find_schema(const json_t *hello, const char *method, const json_t **out_schema,
                             lf_error *err)
{
    json_t *methods = json_object_get(hello, "methods");
    *out_schema = json_object_get(json_object_get(methods, method), "params");
    if (*out_schema)
        return LF_OK;
    const char *meant = lf_nearest_key(method, methods);
    return meant ? lf_error_set(err, LF_E_ARG, method,
                                "is not a method of this daemon; did you mean \"%s\"?", meant)
                 : lf_error_set(err, LF_E_ARG, method,
                                "is not a method of this daemon; quiltctl hello lists the methods");
}

/* The shown scene; NULL: none. A new reference. */
static json_t *ask_scene(lf_ctl *ctl)
{
    json_t *status = NULL, *scene = NULL;
    if (lf_ctl_call(ctl, "status", json_object(), NULL, 0, &status, NULL, NULL) == LF_OK)
        scene = json_incref(json_object_get(status, "scene"));
    json_decref(status);
    return scene;
}

/* Makes a call that names files, passing the files that the daemon may not open. Takes ownership of
 * params. */
static lf_status call_with_files(lf_ctl *ctl, const arguments *a, const json_t *hello,
                                 json_t *params, json_t **out_result, lf_error *err)
{
    json_t *patch = json_object_get(params, "patch");
    json_t *named = patch ? patch : json_object_get(params, "file");
    json_t *scene = patch ? ask_scene(ctl) : NULL;
    lf_ctl_files files;
    lf_status status = lf_ctl_files_open(json_object_get(hello, "folders"), named,
                                         json_string_value(scene), &files, err);
    json_decref(scene);
    if (status != LF_OK) {
        json_decref(params);
        return status;
    }
    if (files.n > 0)
        json_object_set(params, "files", files.names);
    status = lf_ctl_call(ctl, a->method, params, files.fd, files.n, out_result, NULL, err);
    lf_ctl_files_close(&files);
    return status;
}

/* Takes ownership of params. */
static lf_status call(lf_ctl *ctl, const arguments *a, const json_t *hello, json_t *params,
                      json_t **out_result, lf_error *err)
{
    if (a->file && strcmp(a->method, "quilt.show") == 0)
        return lf_ctl_show_quilt(ctl, a->file, params, out_result, err);
    if (a->file)
        return lf_ctl_image(ctl, a->method, a->file, params, out_result, err);
    if (strcmp(a->method, "export") == 0 && is_farmed(params))
        return lf_ctl_export_farmed(ctl, params, out_result, err);
    if (strcmp(a->method, "export") == 0 && !is_detached(params))
        return lf_ctl_export(ctl, params, out_result, err);
    /* older daemons accept none */
    if (json_is_array(json_object_get(hello, "folders")) &&
        (strcmp(a->method, "scene.load") == 0 || strcmp(a->method, "scene.patch") == 0))
        return call_with_files(ctl, a, hello, params, out_result, err);
    return lf_ctl_call(ctl, a->method, params, NULL, 0, out_result, NULL, err);
}

/* The daemon says that a file is outside its folders, also if there is none. */
static void explain_missing(const arguments *a, const json_t *params, lf_error *err)
{
    const bool loads = strcmp(a->method, "scene.load") == 0;
    const char *path = loads || strcmp(a->method, "playlist.set") == 0
                           ? json_string_value(json_object_get(params, loads ? "file" : "folder"))
                           : NULL;
    if (path && access(path, F_OK) != 0 && errno == ENOENT && !lf_frame_name_varies(path))
        (void)lf_error_set(err, err->status, path, "%s", lf_errno_text(ENOENT));
}

static lf_status run(lf_ctl *ctl, const arguments *a, json_t **out_result, lf_error *err)
{
    json_t *hello = NULL;
    const json_t *schema;
    if (strcmp(a->method, "watch") == 0)
        return lf_ctl_watch(ctl, err);
    lf_status status = lf_ctl_call(ctl, "hello", json_object(), NULL, 0, &hello, NULL, err);
    if (status == LF_OK)
        status = find_schema(hello, a->method, &schema, err);
    json_t *params = json_object();
    if (status == LF_OK)
        status = read_words(a, schema, params, err);
    if (status == LF_OK)
        status = call(ctl, a, hello, json_incref(params), out_result, err);
    if (status == LF_E_STATE)
        explain_missing(a, params, err);
    json_decref(params);
    json_decref(hello);
    return status;
}

static void print_result(const arguments *a, const json_t *result)
{
    if (a->format == FORMAT_PROMETHEUS) {
        lf_prometheus_write(result, stdout);
    } else if (a->format == FORMAT_JSON) {
        json_dumpf(result, stdout, JSON_ENCODE_ANY | JSON_INDENT(2));
        putchar('\n');
    } else if (strcmp(a->method, "hello") == 0) {
        lf_ctl_print_methods(result);
    } else if (strcmp(a->method, "status") == 0 && !a->all) {
        lf_ctl_print_status(result, stdout);
    } else if (strncmp(a->method, "playlist.", 9) == 0 && strcmp(a->method, "playlist.get") != 0) {
        lf_ctl_print_slideshow(result, stdout);
    } else if (strcmp(a->method, "scene.get") == 0) {
        json_dumpf(json_object_get(result, "scene"), stdout, JSON_ENCODE_ANY | JSON_INDENT(2));
        putchar('\n');
    } else {
        lf_ctl_print(result);
    }
}

/* "METHOD --help": prints the method's help; false: not such a call. */
static bool print_method_help(int argc, char *const argv[])
{
    const char *method = NULL;
    bool help = false;
    for (int i = 1; i < argc; i++) {
        help = help || strcmp(argv[i], "--help") == 0;
        if (!method && json_object_get(lf_methods_json(), argv[i]))
            method = argv[i];
    }
    if (help && method)
        lf_ctl_print_method(method, json_object_get(lf_methods_json(), method));
    return help && method;
}

static int exit_code(lf_status status)
{
    if (status == LF_OK)
        return LF_EXIT_OK;
    return status == LF_E_NODEV ? LF_EXIT_NO_DAEMON
           : status == LF_E_ARG ? LF_EXIT_USAGE
                                : LF_EXIT_FAILED;
}

int main(int argc, char *argv[])
{
    arguments a = {0};
    lf_error err;
    bool done = false;
    lf_log_init(PROGRAM, LF_LOG_INFO);
    if (print_method_help(argc, argv))
        return LF_EXIT_OK;
    if (read_arguments(argc, argv, &a, &done, &err) != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    if (strcmp(a.method, "doctor") == 0 && a.n_words == 0)
        return lf_ctl_doctor(a.socket) ? LF_EXIT_OK : LF_EXIT_FAILED;
    lf_ctl *ctl = NULL;
    json_t *result = NULL;
    lf_status status = lf_ctl_connect(a.socket, &ctl, &err);
    if (status == LF_OK)
        lf_ctl_set_timeout(ctl, a.timeout);
    if (status == LF_OK)
        status = run(ctl, &a, &result, &err);
    if (status != LF_OK)
        lf_log_error(&err);
    if (status == LF_E_NODEV && a.format == FORMAT_PROMETHEUS)
        lf_prometheus_write(NULL, stdout);
    if (status == LF_OK && result)
        print_result(&a, result);
    json_decref(result);
    lf_ctl_close(ctl);
    return exit_code(status);
}
