#include "base/calibration.h"

#include <jansson.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "base/text.h"

_Static_assert(sizeof(lf_calibration) == 16 + 64 + 5 * sizeof(double) + 12 * sizeof(int) +
                                             sizeof((lf_calibration *)0)->cells,
               "compared as bytes: no padding");

typedef struct parser {
    const char *text, *where;
    size_t n;
    const json_t *root;
    lf_calibration c;
    lf_error *err;
} parser;

/* A number that the formulas use: its member and its plausible range. */
typedef struct number_rule {
    const char *key;
    size_t offset;
    double low, high, absent; /* absent NAN: the key is required */
} number_rule;

#define TO(member) offsetof(lf_calibration, member)

static const number_rule number_rules[] = {
    {"pitch", TO(pitch), 1, 1000, NAN},       {"slope", TO(slope), -1e6, 1e6, NAN},
    {"center", TO(center), -1000, 1000, NAN}, {"viewCone", TO(view_cone_deg), 0, 179, 0},
    {"DPI", TO(dpi), 1, 10000, NAN},
};

static const struct integer_rule {
    const char *key;
    size_t offset;
    int low, high, absent; /* absent -1: the key is required */
} integer_rules[] = {
    {"screenW", TO(screen_width_px), 1, LF_MAX_SIDE, -1},
    {"screenH", TO(screen_height_px), 1, LF_MAX_SIDE, -1},
    {"CellPatternMode", TO(cell_pattern_mode), 0, 4, 0},
};

static const struct flag_rule {
    const char *key;
    size_t offset;
    int absent;
} flag_rules[] = {
    {"invView", TO(inv_view), 1}, /* 1 in every first-generation sample that has the key */
    {"flipImageX", TO(flip_image_x), 0},
    {"flipSubp", TO(flip_subp), 0},
};

/* The line of the first `"key"` in the text. Jansson keeps no positions; each key of this format
 * occurs once. */
static int line_of(const parser *p, const char *key)
{
    char quoted[64];
    int n = snprintf(quoted, sizeof quoted, "\"%s\"", key);
    const char *at = memmem(p->text, p->n, quoted, (size_t)n);
    if (!at)
        return 0;
    int line = 1;
    for (const char *c = p->text; c < at; c++)
        line += *c == '\n';
    return line;
}

static lf_status bad_key(const parser *p, const char *key, const char *expected)
{
    char pointer[80];
    snprintf(pointer, sizeof pointer, "/%s", key);
    return lf_error_set_at(p->err, LF_E_FORMAT, p->where, line_of(p, key), pointer, "expected %s",
                           expected);
}

/* The plain value of {"value": x} or x. */
static const json_t *unwrap(const json_t *value)
{
    return json_is_object(value) ? json_object_get(value, "value") : value;
}

static bool to_number(const json_t *value, double *out)
{
    value = unwrap(value);
    if (json_is_boolean(value))
        *out = json_is_true(value);
    else if (json_is_number(value))
        *out = json_number_value(value);
    else
        return false;
    return isfinite(*out);
}

static lf_status take_number(parser *p, const number_rule *rule)
{
    double *to = (double *)(void *)((char *)&p->c + rule->offset);
    char expected[96];
    snprintf(expected, sizeof expected, "a number from %g to %g", rule->low, rule->high);
    const json_t *value = json_object_get(p->root, rule->key);
    if (!value && !isnan(rule->absent)) {
        *to = rule->absent;
        return LF_OK;
    }
    if (!value || !to_number(value, to) || *to < rule->low || *to > rule->high)
        return bad_key(p, rule->key, expected);
    return LF_OK;
}

static lf_status take_integer(parser *p, const struct integer_rule *rule)
{
    int *to = (int *)(void *)((char *)&p->c + rule->offset);
    double number;
    char expected[96];
    snprintf(expected, sizeof expected, "a whole number from %d to %d", rule->low, rule->high);
    const json_t *value = json_object_get(p->root, rule->key);
    if (!value && rule->absent >= 0) {
        *to = rule->absent;
        return LF_OK;
    }
    if (!value || !to_number(value, &number) || number < rule->low || number > rule->high ||
        number != floor(number))
        return bad_key(p, rule->key, expected);
    *to = (int)number;
    return LF_OK;
}

static lf_status take_flag(parser *p, const struct flag_rule *rule)
{
    int *to = (int *)(void *)((char *)&p->c + rule->offset);
    double number = rule->absent;
    const json_t *value = json_object_get(p->root, rule->key);
    if (value && !to_number(value, &number))
        return bad_key(p, rule->key, "0 or 1");
    *to = number >= 0.5;
    return LF_OK;
}

/* Some of the vendor's programs write the key without its capital. */
static lf_status take_numbers(parser *p)
{
    lf_status status = LF_OK;
    for (size_t i = 0; i < sizeof number_rules / sizeof number_rules[0] && status == LF_OK; i++)
        status = take_number(p, &number_rules[i]);
    for (size_t i = 0; i < sizeof integer_rules / sizeof integer_rules[0] && status == LF_OK; i++) {
        struct integer_rule rule = integer_rules[i];
        if (strcmp(rule.key, "CellPatternMode") == 0 && !json_object_get(p->root, rule.key))
            rule.key = "cellPatternMode";
        status = take_integer(p, &rule);
    }
    for (size_t i = 0; i < sizeof flag_rules / sizeof flag_rules[0] && status == LF_OK; i++)
        status = take_flag(p, &flag_rules[i]);
    /* The formulas divide by slope; a flatter lens is impossible. */
    if (status == LF_OK && fabs(p->c.slope) < 1e-3)
        status = bad_key(p, "slope", "a number that is not 0");
    return status;
}

/* Strings are shown in lists and terminals, so controls (C0, DEL, and C1 in UTF-8) are removed. */
static void remove_controls(char *text)
{
    for (unsigned char *c = (unsigned char *)text; *c != 0; c++)
        if (*c < 0x20 || *c == 0x7f)
            *c = '?';
        else if (c[0] == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0)
            c[0] = c[1] = '?';
}

static lf_status take_text(parser *p, const char *key, char *to, size_t size)
{
    const json_t *value = unwrap(json_object_get(p->root, key));
    if (!value)
        return LF_OK;
    if (!json_is_string(value) || json_string_length(value) >= size)
        return bad_key(p, key, "a short text");
    memcpy(to, json_string_value(value), json_string_length(value));
    remove_controls(to);
    return LF_OK;
}

static const char *const cell_keys[3 /* R, G, B */][2 /* x, y */] = {
    {"ROffsetX", "ROffsetY"}, {"GOffsetX", "GOffsetY"}, {"BOffsetX", "BOffsetY"}};

static lf_status take_cell(parser *p, size_t index, const json_t *cell)
{
    for (int channel = 0; channel < 3; channel++) {
        for (int axis = 0; axis < 2; axis++) {
            double offset;
            const json_t *value = json_object_get(cell, cell_keys[channel][axis]);
            if (!value || !to_number(value, &offset) || fabs(offset) > 16) {
                char pointer[80];
                snprintf(pointer, sizeof pointer, "/subpixelCells/%zu/%s", index,
                         cell_keys[channel][axis]);
                return lf_error_set_at(p->err, LF_E_FORMAT, p->where, line_of(p, "subpixelCells"),
                                       pointer, "expected a number from -16 to 16 (pixels)");
            }
            p->c.cells[index][channel][axis] = (float)offset;
        }
    }
    return LF_OK;
}

static lf_status take_cells(parser *p)
{
    const json_t *cells = json_object_get(p->root, "subpixelCells");
    if (!cells || json_is_null(cells))
        return LF_OK;
    char expected[64];
    snprintf(expected, sizeof expected, "an array of at most %d cells", LF_MAX_CELLS);
    if (!json_is_array(cells) || json_array_size(cells) > LF_MAX_CELLS)
        return bad_key(p, "subpixelCells", expected);
    lf_status status = LF_OK;
    for (size_t i = 0; i < json_array_size(cells) && status == LF_OK; i++)
        status = take_cell(p, i, json_array_get(cells, i));
    p->c.n_cells = (int)json_array_size(cells);
    return status;
}

/* A panel with both sides at the limit would take gigabytes; such sizes are refused. */
static lf_status check_area(const parser *p)
{
    int64_t pixels = (int64_t)p->c.screen_width_px * p->c.screen_height_px;
    if (pixels <= LF_MAX_PANEL_PIXELS)
        return LF_OK;
    return lf_error_set_at(p->err, LF_E_FORMAT, p->where, line_of(p, "screenW"), "/screenW",
                           "%dx%d pixels are too many for a panel; expected at most %d in all",
                           p->c.screen_width_px, p->c.screen_height_px, LF_MAX_PANEL_PIXELS);
}

/* An object, or one parsed from a string; NULL: neither. Release with json_decref. */
static json_t *object_of(const json_t *value)
{
    json_t *parsed = json_is_string(value)
                         ? json_loadb(json_string_value(value), json_string_length(value),
                                      JSON_REJECT_DUPLICATES, NULL)
                         : json_incref((json_t *)(uintptr_t)value);
    if (json_is_object(parsed))
        return parsed;
    json_decref(parsed);
    return NULL;
}

/* A member of a default quilt by its older or newer name, "quiltX" or "quiltWidth". */
static int quilt_member(const json_t *quilt, const char *older, const char *newer, int most)
{
    double number = 0.0;
    const json_t *value = json_object_get(quilt, older);
    if (!to_number(value ? value : json_object_get(quilt, newer), &number) ||
        !(number >= 1 && number <= most && number == floor(number)))
        return 0;
    return (int)number;
}

static void take_quilt(parser *p, const json_t *value)
{
    json_t *quilt = object_of(value);
    int columns = quilt_member(quilt, "tileX", "columns", LF_CALIBRATION_MAX_VIEWS),
        rows = quilt_member(quilt, "tileY", "rows", LF_CALIBRATION_MAX_VIEWS),
        width = quilt_member(quilt, "quiltX", "quiltWidth", LF_MAX_SIDE),
        height = quilt_member(quilt, "quiltY", "quiltHeight", LF_MAX_SIDE);
    json_decref(quilt);
    if (columns > 0 && rows > 0 && width >= columns && height >= rows &&
        columns * rows <= LF_CALIBRATION_MAX_VIEWS &&
        (int64_t)width * height <= LF_MAX_PANEL_PIXELS) {
        p->c.quilt_columns = columns;
        p->c.quilt_rows = rows;
        p->c.quilt_width = width;
        p->c.quilt_height = height;
    } else {
        lf_log(LF_LOG_WARNING,
               "%s: ignored its defaultQuilt; expected at most %d tiles (tileX, tileY) and at most "
               "%d pixels (quiltX, quiltY)",
               p->where, LF_CALIBRATION_MAX_VIEWS, LF_MAX_PANEL_PIXELS);
    }
}

static bool is_known(const char *key)
{
    static const char *const others[] = {"configVersion",   "serial",       "subpixelCells",
                                         "cellPatternMode", "defaultQuilt", "calibration"};
    bool known = false;
    for (size_t i = 0; i < sizeof number_rules / sizeof *number_rules; i++)
        known = known || strcmp(key, number_rules[i].key) == 0;
    for (size_t i = 0; i < sizeof integer_rules / sizeof *integer_rules; i++)
        known = known || strcmp(key, integer_rules[i].key) == 0;
    for (size_t i = 0; i < sizeof flag_rules / sizeof *flag_rules; i++)
        known = known || strcmp(key, flag_rules[i].key) == 0;
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        known = known || strcmp(key, others[i]) == 0;
    return known;
}

/* Warns of unused keys: known ones if they are not 0, unknown ones always. */
static void tell_unused(const parser *p)
{
    static const char *const idle[] = {"fringe", "verticalAngle", "flipImageY", NULL};
    char names[256] = "";
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)p->root, key, value)
    {
        const size_t at = strlen(names);
        double number = 1;
        int i = 0;
        while (idle[i] && strcmp(key, idle[i]) != 0)
            i++;
        if (is_known(key) || (idle[i] && to_number(value, &number) && number == 0.0))
            continue;
        snprintf(names + at, sizeof names - at, "%s%.40s", at ? ", " : "", key);
    }
    remove_controls(names);
    if (names[0])
        lf_log(LF_LOG_WARNING, "%s: these keys have no effect: %s", p->where, names);
}

static lf_status take_all(parser *p)
{
    if (!json_is_object(p->root))
        return lf_error_set(p->err, LF_E_FORMAT, p->where,
                            "expected a JSON object with a panel's calibration");
    lf_status status = take_numbers(p);
    if (status == LF_OK)
        status = check_area(p);
    if (status == LF_OK)
        status = take_text(p, "configVersion", p->c.config_version, sizeof p->c.config_version);
    if (status == LF_OK)
        status = take_text(p, "serial", p->c.serial, sizeof p->c.serial);
    if (status == LF_OK)
        tell_unused(p);
    return status == LF_OK ? take_cells(p) : status;
}

/* Parses a text after lf_text_take. */
static lf_status parse_text(const char *text, size_t n, const char *where, lf_calibration *out,
                            lf_error *err)
{
    json_error_t json;
    json_t *whole = json_loadb(text, n, JSON_REJECT_DUPLICATES, &json), *root = whole;
    if (!root && json_error_code(&json) == json_error_end_of_input_expected)
        return lf_error_set_at(
            err, LF_E_FORMAT, where, json.line > 0 ? json.line : 0, NULL,
            "text follows the JSON object; delete everything after its last brace");
    if (!root)
        return lf_error_set_at(err, LF_E_FORMAT, where, json.line > 0 ? json.line : 0, NULL,
                               "not JSON: %s", json.text);
    parser p = {.text = text, .where = where, .n = n, .root = root, .err = err};
    json_t *inner =
        json_object_get(whole, "pitch") ? NULL : object_of(json_object_get(whole, "calibration"));
    if (inner)
        p.root = inner;
    lf_status status = take_all(&p);
    const json_t *quilt = json_object_get(whole, "defaultQuilt");
    if (status == LF_OK && quilt && !json_is_null(quilt))
        take_quilt(&p, quilt);
    json_decref(inner);
    json_decref(whole);
    if (status == LF_OK)
        *out = p.c;
    return status;
}

lf_status lf_calibration_parse(const char *text, size_t n, const char *where, lf_calibration *out,
                               lf_error *err)
{
    if (n > LF_CALIBRATION_MAX_BYTES)
        return lf_error_set(err, LF_E_FORMAT, where,
                            "%zu bytes are too many for a calibration; expected at most %d", n,
                            LF_CALIBRATION_MAX_BYTES);
    char *own = lf_calloc(n + 1, 1);
    if (!own)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    memcpy(own, text, n);
    lf_status status = lf_text_take(own, &n, where, err);
    if (status == LF_OK)
        status = parse_text(own, n, where, out, err);
    lf_free(own);
    return status;
}

lf_status lf_calibration_load(const char *path, lf_calibration *out, lf_error *err)
{
    char *text = NULL;
    size_t n = 0;
    lf_status status = lf_file_read(path, NULL, LF_CALIBRATION_MAX_BYTES, &text, &n, err);
    if (status == LF_OK)
        status = lf_calibration_parse(text, n, path, out, err);
    lf_free(text);
    return status;
}

static json_t *cell_json(const float cell[3][2])
{
    json_t *json = json_object();
    for (int i = 0; i < 6; i++)
        json_object_set_new(json, cell_keys[i / 2][i % 2], json_real((double)cell[i / 2][i % 2]));
    return json;
}

json_t *lf_calibration_json(const lf_calibration *c)
{
    json_t *cells = json_array();
    for (int i = 0; i < c->n_cells; i++)
        json_array_append_new(cells, cell_json(c->cells[i]));
    json_t *json = json_pack(
        "{s:s, s:s, s:f, s:f, s:f, s:f, s:f, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:o}",
        "configVersion", c->config_version, "serial", c->serial, "pitch", c->pitch, "slope",
        c->slope, "center", c->center, "viewCone", c->view_cone_deg, "DPI", c->dpi, "screenW",
        c->screen_width_px, "screenH", c->screen_height_px, "invView", c->inv_view, "flipImageX",
        c->flip_image_x, "flipImageY", c->flip_image_y, "flipSubp", c->flip_subp, "CellPatternMode",
        c->cell_pattern_mode, "subpixelCells", cells);
    if (json && c->quilt_columns > 0)
        (void)json_object_set_new(json, "defaultQuilt",
                                  json_pack("{s:i, s:i, s:i, s:i}", "quiltX", c->quilt_width,
                                            "quiltY", c->quilt_height, "tileX", c->quilt_columns,
                                            "tileY", c->quilt_rows));
    return json;
}

void lf_calibration_portrait(lf_calibration *out)
{
    *out = (lf_calibration){.config_version = "3.0",
                            .serial = "LKG-PORT-NOMINAL",
                            .pitch = 52,
                            .slope = -7,
                            .center = 0.5,
                            .view_cone_deg = 40,
                            .dpi = 324,
                            .screen_width_px = 1536,
                            .screen_height_px = 2048,
                            .inv_view = 1};
}
