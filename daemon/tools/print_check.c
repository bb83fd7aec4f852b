#include "daemon/tools/print_check.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"

#define MOST_BYTES ((size_t)4 << 20) /* of reports and job sheets */

static const char *const on_off[] = {"on", "off", NULL};

const lf_param lf_check_params[] = {
    {.name = "check",
     .option = "check",
     .argument = "on|off",
     .place = offsetof(lf_check_arguments, off),
     .type = LF_PARAM_SWITCH,
     .words = on_off,
     .help = "read a written print back and check it; adds a report and a job sheet"},
    {0},
};

/* What is written beside a print, and a text that only such a file has. */
static const struct {
    const char *ending, *mark;
} written[] = {{".check.txt", "of 18 points hold"},
               {".check.json", "\"quiltd_check\""},
               {".job.pdf", "(Lenticular print: job sheet)"}};

enum { N_WRITTEN = sizeof written / sizeof written[0] };

/* True if there is no such file, or one of an earlier check. */
static bool may_replace(const char *name, const char *mark)
{
    char *data = NULL;
    size_t size = 0;
    if (access(name, F_OK) != 0)
        return true;
    const bool is_ours = lf_file_read(name, NULL, MOST_BYTES, &data, &size, NULL) == LF_OK &&
                         memmem(data, size, mark, strlen(mark));
    lf_free(data);
    return is_ours;
}

bool lf_print_check_wanted(const lf_check_arguments *arguments, const char *path)
{
    return !arguments->off &&
           (lf_path_has_ending(path, ".tif") || lf_path_has_ending(path, ".tiff") ||
            lf_path_has_ending(path, ".pdf"));
}

const char *lf_print_check_ending(int index)
{
    return index < N_WRITTEN ? written[index].ending : NULL;
}

lf_status lf_print_check_room_beside(const char *path, lf_error *err)
{
    lf_status status = LF_OK;
    for (int i = 0; i < N_WRITTEN && status == LF_OK; i++) {
        char *name = lf_path_beside(path, written[i].ending);
        if (!name)
            return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
        if (!may_replace(name, written[i].mark))
            status = lf_error_set(err, LF_E_ARG, name,
                                  "exists and is not of a print's checklist; move it away, or give "
                                  "--check off");
        lf_free(name);
    }
    return status;
}

void lf_print_check_forget(const char *path)
{
    for (int i = 0; i < N_WRITTEN; i++) {
        char *name = lf_path_beside(path, written[i].ending);
        if (name && access(name, F_OK) == 0 && may_replace(name, written[i].mark) &&
            unlink(name) == 0)
            lf_log(LF_LOG_INFO, "removed %s, which is of an earlier print", name);
        lf_free(name);
    }
}

static lf_status write_text(const char *path, const char *ending, const char *text, lf_error *err)
{
    char *name = lf_path_beside(path, ending);
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
    char *name = lf_path_beside(path, ".job.pdf");
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

lf_status lf_print_check_command(const lf_profiles_command *command, lf_error *err)
{
    const lf_print_check_options options = {.manifest = command->manifest};
    lf_print_report report;
    if (command->n != 1)
        return lf_error_set(err, LF_E_ARG, "check", "expects one PRINT.tif or .pdf, got %d names",
                            command->n);
    const char *path = command->words[0];
    lf_status status = lf_print_check_file(path, &options, &report, err);
    if (status != LF_OK)
        return status;
    char *text = command->json ? json_text(&report) : lf_print_report_text(&report);
    const int n_failed = lf_print_report_count(&report, LF_CHECK_FAIL);
    if (!text)
        status = lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    else if (fputs(text, stdout) >= 0 && n_failed > 0)
        status = lf_error_set(err, LF_E_FORMAT, path, "%d of %d points fail; see their remedies",
                              n_failed, LF_CHECK_POINTS);
    lf_free(text);
    lf_print_report_finish(&report);
    return status;
}
