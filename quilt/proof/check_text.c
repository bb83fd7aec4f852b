/* The report as a line, a text and JSON. */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/list.h"
#include "base/version.h"
#include "quilt/proof/check.h"

const char *lf_check_result_name(lf_check_result result)
{
    static const char *const names[] = {[LF_CHECK_PASS] = "PASS",
                                        [LF_CHECK_WARN] = "WARN",
                                        [LF_CHECK_FAIL] = "FAIL",
                                        [LF_CHECK_NONE] = "----"};
    return names[result];
}

int lf_print_report_count(const lf_print_report *report, lf_check_result result)
{
    int n = 0;
    for (int point = 0; point < LF_CHECK_POINTS; point++)
        n += report->points[point].result == result;
    return n;
}

char *lf_print_report_line(const lf_print_report *report, char *buf, size_t size)
{
    const int none = lf_print_report_count(report, LF_CHECK_NONE);
    buf[0] = '\0';
    lf_list_add(buf, size, "%d of %d points hold", lf_print_report_count(report, LF_CHECK_PASS),
                LF_CHECK_POINTS);
    if (none > 0)
        lf_list_add(buf, size, "%d %s not apply", none, none == 1 ? "does" : "do");
    for (int point = 0; point < LF_CHECK_POINTS; point++) {
        const lf_check_point *at = &report->points[point];
        if (at->result == LF_CHECK_FAIL || at->result == LF_CHECK_WARN)
            lf_list_add(buf, size, "%s %s (%s)", lf_check_point_name(point),
                        at->result == LF_CHECK_FAIL ? "fails" : "warns", at->measured);
    }
    return buf;
}

static void print_point(FILE *out, int point, const lf_check_point *at)
{
    fprintf(out, "%2d %s  %s: %s\n", point + 1, lf_check_result_name(at->result),
            lf_check_point_name(point), at->measured);
    if (at->limit[0])
        fprintf(out, "         limit: %s\n", at->limit);
    if (at->remedy[0])
        fprintf(out, "         remedy: %s\n", at->remedy);
}

char *lf_print_report_text(const lf_print_report *report)
{
    char line[2048], *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    fprintf(out, "%s\n%s\n", report->file, lf_print_report_line(report, line, sizeof line));
    if (report->sha256[0])
        fprintf(out, "SHA-256 %s\n", report->sha256);
    fputc('\n', out);
    for (int point = 0; point < LF_CHECK_POINTS; point++)
        print_point(out, point, &report->points[point]);
    fprintf(out,
            "\n---- does not apply, or cannot be measured in this file. Checked by quiltd %s.\n",
            LF_VERSION);
    if (fclose(out) != 0) {
        free(text);
        return NULL;
    }
    char *copy = lf_strdup(text);
    free(text);
    return copy;
}

/* A text that may hold any bytes of a file. */
static json_t *plain(const char *text)
{
    json_t *out = json_string(text);
    return out ? out : json_string("not UTF-8");
}

static json_t *point_json(int point, const lf_check_point *at)
{
    static const char *const results[] = {[LF_CHECK_PASS] = "pass",
                                          [LF_CHECK_WARN] = "warn",
                                          [LF_CHECK_FAIL] = "fail",
                                          [LF_CHECK_NONE] = "none"};
    return json_pack("{s:i, s:s, s:s, s:o, s:o, s:s}", "point", point + 1, "name",
                     lf_check_point_name(point), "result", results[at->result], "measured",
                     plain(at->measured), "limit", plain(at->limit), "remedy", at->remedy);
}

json_t *lf_print_report_json(const lf_print_report *report)
{
    json_t *points = json_array();
    for (int point = 0; points && point < LF_CHECK_POINTS; point++)
        json_array_append_new(points, point_json(point, &report->points[point]));
    return json_pack("{s:i, s:s, s:o, s:s, s:I, s:i, s:i, s:i, s:i, s:o}", "quiltd_check", 1,
                     "software", "quiltd " LF_VERSION, "file", plain(report->file), "sha256",
                     report->sha256, "bytes", (json_int_t)report->bytes, "passed",
                     lf_print_report_count(report, LF_CHECK_PASS), "warned",
                     lf_print_report_count(report, LF_CHECK_WARN), "failed",
                     lf_print_report_count(report, LF_CHECK_FAIL), "do_not_apply",
                     lf_print_report_count(report, LF_CHECK_NONE), "points", points);
}
