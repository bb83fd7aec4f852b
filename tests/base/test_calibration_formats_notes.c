/* The table of docs/reference/formats/calibrations.md: each key in a calibration that is made here,
 * and what the reader makes of it. */
#include "tests/formats.h"

#include <fcntl.h>

#include "base/calibration.h"

/* A key and its value as JSON, in place of one that is there already or beside the others; and the
 * words of a warning or an error. whole: the file, where that is not enough. */
typedef struct meta {
    const char *key, *value, *words, *whole;
    size_t n; /* bytes of whole; 0: up to its end */
} meta;

static const struct {
    const char *key, *value;
} usual[] = {{"pitch", "50.5"}, {"slope", "-7"},     {"center", "0.25"},
             {"DPI", "324"},    {"screenW", "1536"}, {"screenH", "2048"}};

static void text_of(const meta *s, char *out, size_t size)
{
    size_t n = (size_t)snprintf(out, size, "{");
    bool there = false;
    for (size_t i = 0; i < sizeof usual / sizeof *usual; i++) {
        const bool own = s && s->key && strcmp(usual[i].key, s->key) == 0;
        there = there || own;
        if (!own || s->value)
            n += (size_t)snprintf(out + n, size - n, "%s\"%s\": %s", n > 1 ? ", " : "",
                                  usual[i].key, own ? s->value : usual[i].value);
    }
    snprintf(out + n, size - n, s && s->key && !there ? ", \"%s\": %s}" : "}", s ? s->key : "",
             s ? s->value : "");
}

/* *out_log: what was logged meanwhile. */
static lf_status read_said(const meta *s, lf_calibration *out, char *log, size_t size,
                           lf_error *err)
{
    char text[2048], path[] = "/tmp/quiltd-said-XXXXXX";
    const int before = dup(STDERR_FILENO), file = mkstemp(path);
    size_t n;
    assert_true(before >= 0 && file >= 0);
    unlink(path);
    text_of(s, text, sizeof text);
    const char *whole = s && s->whole ? s->whole : text;
    n = s && s->n > 0 ? s->n : strlen(whole);
    memset(out, 0, sizeof *out);
    *err = (lf_error){0};
    fflush(stderr);
    assert_true(dup2(file, STDERR_FILENO) >= 0);
    lf_status status = lf_calibration_parse(whole, n, "visual.json", out, err);
    fflush(stderr);
    assert_true(dup2(before, STDERR_FILENO) >= 0);
    close(before);
    ssize_t got = pread(file, log, size - 1, 0);
    close(file);
    log[got > 0 ? got : 0] = '\0';
    return status;
}

static void check_row(const lf_format_row *row)
{
    const meta *s = row->with;
    lf_calibration with, without;
    lf_error err;
    char log[1024], none[1024];
    lf_assert_ok(read_said(NULL, &without, none, sizeof none, &err), &err);
    lf_status status = read_said(s, &with, log, sizeof log, &err);
    if (strcmp(row->verdict, "refused") == 0) {
        if (status != LF_E_FORMAT || !strstr(err.what, s->words))
            fail_msg("%s: %s \"%s\"", row->name, lf_status_name(status), err.what);
        return;
    }
    if (status != LF_OK)
        fail_msg("%s: \"%s\"", row->name, err.what);
    const bool same = memcmp(&with, &without, sizeof with) == 0,
               used = strcmp(row->verdict, "used") == 0, told = strcmp(row->verdict, "warned") == 0;
    if (same == used || (told ? !strstr(log, s->words) : log[0] != '\0'))
        fail_msg("%s: %s, log \"%s\"", row->name, same ? "the same" : "another calibration", log);
}

#define CELL(rx, ry, gx, gy, bx, by)                                                               \
    "[{\"ROffsetX\": " rx ", \"ROffsetY\": " ry ", \"GOffsetX\": " gx ", \"GOffsetY\": " gy        \
    ", \"BOffsetX\": " bx ", \"BOffsetY\": " by "}]"
#define QUILT(a, b, c, d) "{\"" a "\": 4096, \"" b "\": 4096, \"" c "\": 5, \"" d "\": 9}"
#define PLAIN                                                                                      \
    "{\"pitch\": 50.5, \"slope\": -7, \"center\": 0.25, \"DPI\": 324, \"screenW\": 1536, "         \
    "\"screenH\": 2048}"
#define OTHER                                                                                      \
    "{\"pitch\": 40.5, \"slope\": -7, \"center\": 0.25, \"DPI\": 324, \"screenW\": 1536, "         \
    "\"screenH\": 2048}"

/* clang-format off */
#define KEY(name, verdict, ...) {name, verdict, check_row, &(const meta){__VA_ARGS__}}
#define SAID(key_, value_) .key = key_, .value = value_

static const lf_format_row rows[] = {
    KEY("configVersion", "used", SAID("configVersion", "\"3.0\"")),
    KEY("serial", "used", SAID("serial", "\"LKG-P00655\"")),
    KEY("pitch", "used", SAID("pitch", "52")),
    KEY("slope", "used", SAID("slope", "-6")),
    KEY("center", "used", SAID("center", "0.5")),
    KEY("viewCone", "used", SAID("viewCone", "40")),
    KEY("DPI", "used", SAID("DPI", "338")),
    KEY("screenW", "used", SAID("screenW", "2560")),
    KEY("screenH", "used", SAID("screenH", "1600")),
    KEY("invView", "used", SAID("invView", "0")),
    KEY("flipImageX", "used", SAID("flipImageX", "1")),
    KEY("flipImageY", "warned", SAID("flipImageY", "1"),
        "what it says of flipImageY has no effect"),
    KEY("flipImageY 0", "ignored", SAID("flipImageY", "{\"value\": 0.0}")),
    KEY("flipSubp", "used", SAID("flipSubp", "1")),
    KEY("fringe", "warned", SAID("fringe", "2"), "what it says of fringe has no effect"),
    KEY("fringe 0", "ignored", SAID("fringe", "0.0")),
    KEY("verticalAngle", "warned", SAID("verticalAngle", "3"),
        "what it says of verticalAngle has no effect"),
    KEY("verticalAngle 0", "ignored", SAID("verticalAngle", "0")),
    KEY("CellPatternMode", "used", SAID("CellPatternMode", "2")),
    KEY("cellPatternMode", "used", SAID("cellPatternMode", "2")),
    KEY("subpixelCells", "used", SAID("subpixelCells", CELL("1", "0", "0", "0", "0", "0"))),
    KEY("subpixelCells []", "ignored", SAID("subpixelCells", "[]")),
    KEY("ROffsetX", "used", SAID("subpixelCells", CELL("2", "0", "0", "0", "0", "0"))),
    KEY("ROffsetY", "used", SAID("subpixelCells", CELL("0", "2", "0", "0", "0", "0"))),
    KEY("GOffsetX", "used", SAID("subpixelCells", CELL("0", "0", "2", "0", "0", "0"))),
    KEY("GOffsetY", "used", SAID("subpixelCells", CELL("0", "0", "0", "2", "0", "0"))),
    KEY("BOffsetX", "used", SAID("subpixelCells", CELL("0", "0", "0", "0", "2", "0"))),
    KEY("BOffsetY", "used", SAID("subpixelCells", CELL("0", "0", "0", "0", "0", "2"))),
    KEY("an offset that is missing", "refused", SAID("subpixelCells", "[{\"ROffsetX\": 1}]"),
        "expected a number from -16 to 16"),
    KEY("{\"value\": x}", "used", SAID("pitch", "{\"value\": 52}")),
    KEY("true and false", "used", SAID("flipSubp", "true")),
    KEY("defaultQuilt", "used", SAID("defaultQuilt", QUILT("quiltX", "quiltY", "tileX", "tileY"))),
    KEY("quiltX, quiltY, tileX, tileY", "used",
        SAID("defaultQuilt", QUILT("quiltX", "quiltY", "tileX", "tileY"))),
    KEY("quiltWidth, quiltHeight, columns, rows", "used",
        SAID("defaultQuilt", QUILT("quiltWidth", "quiltHeight", "columns", "rows"))),
    KEY("a defaultQuilt that is none", "warned", SAID("defaultQuilt", "{\"tileX\": 5}"),
        "its defaultQuilt is not used"),
    KEY("calibration", "used", .whole = "{\"calibration\": " OTHER "}"),
    KEY("calibration as a text", "used",
        .whole = "{\"calibration\": \"{\\\"pitch\\\": 40, \\\"slope\\\": -7, "
                 "\\\"center\\\": 0, \\\"DPI\\\": 324, \\\"screenW\\\": 1536, "
                 "\\\"screenH\\\": 2048}\"}"),
    KEY("any other key", "warned", SAID("lensRadius", "3"),
        "what it says of lensRadius has no effect"),
    KEY("a key that is missing", "refused", SAID("pitch", NULL),
        "expected a number from 1 to 1000"),
    KEY("a number out of range", "refused", SAID("DPI", "0"), "expected a number from 1 to 10000"),
    KEY("a text in place of a number", "refused", SAID("pitch", "\"50\""), "expected a number"),
    KEY("a key twice", "refused", SAID("fringe", "0, \"fringe\": 0"), "duplicate"),
    KEY("no JSON", "refused", .whole = "pitch=50", .words = "not JSON"),
    KEY("a byte order mark", "ignored", .whole = "\xef\xbb\xbf" PLAIN),
    KEY("NUL bytes behind", "ignored", .whole = PLAIN "\0\0\0", .n = sizeof PLAIN + 2),
    KEY("UTF-16", "refused", .whole = "\xff\xfe{", .words = "is UTF-16 text; save it as UTF-8"),
};
/* clang-format on */

static void every_key_is_what_the_table_says(void **state)
{
    (void)state;
    lf_formats_walk("calibrations.md", "visual.json", rows, sizeof rows / sizeof *rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_key_is_what_the_table_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
