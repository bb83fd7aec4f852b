#include "daemon/tools/print_check.h"

#include <getopt.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "daemon/output/options.h"

#define PROGRAM "quiltprint"

static const char *const on_off[] = {"on", "off", NULL};

const lf_param lf_check_params[] = {
    {.name = "check",
     .option = "check",
     .argument = "NAME",
     .place = offsetof(lf_check_arguments, off),
     .type = LF_PARAM_SWITCH,
     .words = on_off,
     .help = "read a print back and check it; a report and a job sheet go beside it"},
    {0},
};

/* sheet.check.txt for sheet.tif. */
static char *beside(const char *path, const char *ending)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    const size_t stem = dot && (!slash || dot > slash) ? (size_t)(dot - path) : strlen(path);
    char *name = lf_calloc(stem + strlen(ending) + 1, 1);
    if (name) {
        memcpy(name, path, stem);
        memcpy(name + stem, ending, strlen(ending));
    }
    return name;
}

static lf_status write_text(const char *path, const char *ending, const char *text, lf_error *err)
{
    char *name = beside(path, ending);
    const lf_status status = name && text ? lf_outfile_text(name, text, err)
                                          : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    lf_free(name);
    return status;
}

/* The JSON of a report, with a line feed; release with lf_free. */
static char *json_text(const lf_print_report *report)
{
    json_t *root = lf_print_report_json(report);
    char *text = root ? json_dumps(root, JSON_INDENT(2)) : NULL;
    const size_t n = text ? strlen(text) : 0;
    char *line = text ? lf_calloc(n + 2, 1) : NULL;
    if (line) {
        memcpy(line, text, n);
        line[n] = '\n';
    }
    free(text);
    json_decref(root);
    return line;
}

static lf_status write_sheet(const char *path, const lf_print_report *report, lf_error *err)
{
    char *name = beside(path, ".job.pdf");
    lf_outfile file = {0};
    lf_status status = name ? lf_outfile_open(&file, name, true, err)
                            : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    if (status == LF_OK) {
        status = lf_print_report_sheet(report, &file, err);
        if (status == LF_OK)
            status = lf_outfile_commit(&file, true, err);
        else
            lf_outfile_abandon(&file);
    }
    lf_free(name);
    return status;
}

lf_status lf_print_check_written(const char *path, const lf_print_witness *witness,
                                 bool *out_failed, lf_error *err)
{
    const lf_print_check_options options = {.witness = witness};
    lf_print_report report;
    char line[2048];
    lf_status status = lf_print_check_file(path, &options, &report, err);
    if (status != LF_OK)
        return status;
    *out_failed = lf_print_report_count(&report, LF_CHECK_FAIL) > 0;
    lf_log(*out_failed ? LF_LOG_ERROR : LF_LOG_INFO, "checked %s: %s", path,
           lf_print_report_line(&report, line, sizeof line));
    char *text = lf_print_report_text(&report), *json = json_text(&report);
    status = write_text(path, ".check.txt", text, err);
    if (status == LF_OK)
        status = write_text(path, ".check.json", json, err);
    if (status == LF_OK)
        status = write_sheet(path, &report, err);
    lf_free(text);
    lf_free(json);
    lf_print_report_finish(&report);
    return status;
}

/* ------------------------------------------------------------------------------ quiltprint check
 */

static void print_help(void)
{
    puts("usage: quiltprint check FILE.tif [--manifest FILE] [--json]\n"
         "\n"
         "Reads a print back from disk and checks 18 points against its manifest.\n"
         "\n"
         "  --manifest FILE  the manifest; default: FILE.json beside FILE.tif\n"
         "  --json           print JSON instead of text\n"
         "  --help           print this help and exit\n"
         "\n"
         "Exit status: 0 if all points hold or only warn, 1 if one fails, 2 for a usage error.");
}

typedef struct check_arguments {
    lf_print_check_options options;
    const char *path;
    bool json, help;
} check_arguments;

static lf_status parse(int argc, char *const argv[], check_arguments *out, lf_error *err)
{
    static const struct option options[] = {{"manifest", required_argument, NULL, 'm'},
                                            {"json", no_argument, NULL, 'j'},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    int option;
    *out = (check_arguments){0};
    opterr = 0;
    optind = 0;
    while ((option = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (option == 'm')
            out->options.manifest = optarg;
        else if (option == 'j')
            out->json = true;
        else if (option == 'h')
            out->help = true;
        else
            return lf_error_set(err, LF_E_ARG, argv[optind - 1],
                                "unknown option or missing value; expected --manifest FILE or "
                                "--json");
    }
    if (out->help)
        return LF_OK;
    if (argc - optind != 1)
        return lf_error_set(err, LF_E_ARG, "check", "expected one FILE.tif, got %d names",
                            argc - optind);
    out->path = argv[optind];
    return LF_OK;
}

int lf_print_check_command(int argc, char *const argv[])
{
    check_arguments a;
    lf_print_report report;
    lf_error err = {0};
    if (parse(argc, argv, &a, &err) != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    if (a.help) {
        print_help();
        return LF_EXIT_OK;
    }
    if (lf_print_check_file(a.path, &a.options, &report, &err) != LF_OK) {
        lf_log_error(&err);
        return LF_EXIT_FAILED;
    }
    char *text = a.json ? json_text(&report) : lf_print_report_text(&report);
    const bool failed = !text || lf_print_report_count(&report, LF_CHECK_FAIL) > 0;
    fputs(text ? text : "out of memory\n", stdout);
    lf_free(text);
    lf_print_report_finish(&report);
    return fflush(stdout) != 0 || failed ? LF_EXIT_FAILED : LF_EXIT_OK;
}
