/* The tables of docs/reference/formats/: what a format can say, and what quiltd makes of it. A test
 * lists the same rows, each with a check that makes a file which says that one thing.
 * lf_formats_walk holds the page and the list to each other, and runs the checks. */
#ifndef LF_TESTS_FORMATS_H
#define LF_TESTS_FORMATS_H

#include "tests/testing.h"

/* One row: `| \`name\` | verdict | words |`, below a heading of a page. */
typedef struct lf_format_row {
    const char *name; /* the first cell, without backticks */
    const char
        *verdict; /* "used", "warned", "refused", or "ignored": it says nothing of the picture */
    void (*check)(const struct lf_format_row *row); /* fails unless the verdict is true */
    const void *with;                               /* the check's own */
} lf_format_row;

enum { LF_FORMATS_CELL = 256 };

/* The n-th cell of a row (0 is the first) without blanks and backticks around it, into out. */
static inline bool lf_formats_cell(const char *line, int n, char out[LF_FORMATS_CELL])
{
    for (; n >= 0; n--) {
        line = strchr(line, '|');
        if (!line)
            return false;
        line++;
    }
    line += strspn(line, " `");
    size_t length = strcspn(line, "|\n");
    while (length > 0 && strchr(" `", line[length - 1]))
        length--;
    if (length >= LF_FORMATS_CELL)
        fail_msg("a cell of more than %d bytes: %s", LF_FORMATS_CELL - 1, line);
    memcpy(out, line, length);
    out[length] = '\0';
    return true;
}

/* The row of the list that a line of the page is; fails for one that the list lacks. */
static inline size_t lf_formats_find(const char *line, const lf_format_row *rows, size_t count)
{
    char name[LF_FORMATS_CELL] = "", verdict[LF_FORMATS_CELL] = "";
    lf_formats_cell(line, 0, name);
    lf_formats_cell(line, 1, verdict);
    for (size_t i = 0; i < count; i++)
        if (strcmp(rows[i].name, name) == 0) {
            if (strcmp(rows[i].verdict, verdict) != 0)
                fail_msg("%s: the page says %s, the test %s", name, verdict, rows[i].verdict);
            return i;
        }
    fail_msg("%s: the page has this row, the test does not", name);
    return 0;
}

/* Holds the table below "## heading" of docs/reference/formats/PAGE and the rows to each other,
 * then runs every row's check. At most 512 rows. */
static inline void lf_formats_walk(const char *page, const char *heading, const lf_format_row *rows,
                                   size_t count)
{
    char path[256], line[4096];
    snprintf(path, sizeof path, "docs/reference/formats/%s", page);
    FILE *f = fopen(lf_test_source(path), "r");
    if (!f)
        fail_msg("docs/reference/formats/%s is not there", page);
    bool within = false, seen[512] = {0};
    assert_true(count <= 512);
    while (fgets(line, sizeof line, f)) {
        if (strncmp(line, "## ", 3) == 0)
            within = strncmp(line + 3, heading, strlen(heading)) == 0 &&
                     line[3 + strlen(heading)] == '\n';
        if (!within || strncmp(line, "| `", 3) != 0)
            continue;
        size_t row = lf_formats_find(line, rows, count);
        if (seen[row])
            fail_msg("%s: twice on the page", rows[row].name);
        seen[row] = true;
    }
    fclose(f);
    for (size_t i = 0; i < count; i++) {
        if (!seen[i])
            fail_msg("%s: the test has this row, docs/reference/formats/%s does not", rows[i].name,
                     page);
        print_message("%s: %s\n", rows[i].name, rows[i].verdict);
        rows[i].check(&rows[i]);
    }
}

#endif
