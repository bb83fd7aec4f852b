#include "daemon/web/bridge_entry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "base/number.h"

#define DEPTHINESS 1.5 /* of Bridge */
#define MAX_TILES 1000 /* far above what quiltd takes: no sum overflows */

/* ------------------------------------------------------------------------------------ values -- */

bool lf_bridge_number(const json_t *value, double *out)
{
    const char *text = json_string_value(value);
    double number;
    if (json_is_number(value))
        number = json_number_value(value);
    else if (json_is_boolean(value) || (text && strcasecmp(text, "true") == 0))
        number = !json_is_false(value);
    else if (text && strcasecmp(text, "false") == 0)
        number = 0;
    else if (!text || !lf_decimal_is(text, &number))
        return false;
    *out = number;
    return true;
}

bool lf_bridge_whole(const json_t *value, int *out)
{
    double number;
    if (!lf_bridge_number(value, &number) || number != floor(number) || fabs(number) > 1e9)
        return false;
    *out = (int)number;
    return true;
}

static double number_of(const json_t *said, const char *key)
{
    return json_number_value(json_object_get(said, key));
}

/* -------------------------------------------------------------------------------------- path -- */

static int digit(char c)
{
    static const char digits[] = "0123456789abcdef";
    const char *at = c ? strchr(digits, c >= 'A' && c <= 'F' ? c - 'A' + 'a' : c) : NULL;
    return at ? (int)(at - digits) : -1;
}

/* Decodes %XX in place. False: no two digits follow, or a zero byte is meant. */
static bool decode(char *text)
{
    char *to = text;
    for (const char *at = text; *at; to++) {
        const bool coded = *at == '%';
        const int high = coded ? digit(at[1]) : 0;
        const int low = coded && high >= 0 ? digit(at[2]) : 0;
        if (high < 0 || low < 0 || (coded && high + low == 0))
            return false;
        *to = coded ? (char)(high * 16 + low) : *at;
        at += coded ? 3 : 1;
    }
    *to = '\0';
    return true;
}

static bool begins(const char *text, const char *start)
{
    return strncasecmp(text, start, strlen(start)) == 0;
}

/* The text after file:// and an empty or local host; NULL: another host. */
static const char *local_path(const char *uri)
{
    static const char scheme[] = "file://", host[] = "localhost";
    const char *path = uri + strlen(scheme);
    if (begins(path, host) && path[strlen(host)] == '/')
        path += strlen(host);
    return path[0] == '/' ? path : NULL;
}

static lf_status refuse_uri(const char *uri, lf_error *err)
{
    if (begins(uri, "http:") || begins(uri, "https:"))
        return lf_error_set(err, LF_E_ARG, "uri",
                            "quiltd reads nothing from the network; download the file and give its "
                            "path");
    if (begins(uri, "data:") || begins(uri, "blob:"))
        return lf_error_set(err, LF_E_ARG, "uri",
                            "quiltd reads only files; save the data into one and give its path");
    return lf_error_set(err, LF_E_ARG, "uri", "expects an absolute path, or file:// with one");
}

/* The path that a uri means, a new reference. */
static lf_status read_uri(const char *uri, json_t **out, lf_error *err)
{
    const bool is_url = begins(uri, "file://");
    const char *path = is_url ? local_path(uri) : uri;
    if (!path || path[0] != '/')
        return refuse_uri(uri, err);
    char *text = lf_strdup(path);
    if (!text)
        return lf_error_set(err, LF_E_NOMEM, "uri", "out of memory");
    json_t *made = !is_url || decode(text) ? json_string(text) : NULL; /* NULL: it is not UTF-8 */
    lf_free(text);
    if (!made)
        return lf_error_set(err, LF_E_ARG, "uri", "is not a path in UTF-8, coded with %%XX");
    *out = made;
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- entry -- */

/* Numbers that are known. As in TOOLKIT of the vendor, viewCount is view_count. */
static const struct parameter {
    const char *name, *key;
} parameters[] = {
    {"isRGBD", "isRGBD"},
    {"cols", "cols"},
    {"rows", "rows"},
    {"view_count", "views"},
    {"viewCount", "views"},
    {"aspect", "aspect"},
    {"durationMS", "durationMS"},
    {"depth_loc", "depth_loc"},
    {"depth_inversion", "depth_inversion"},
    {"chroma_depth", "chroma_depth"},
    {"depthiness", "depthiness"},
    {"depth_cutoff", "depth_cutoff"},
    {"focus", "focus"},
    {"zoom", "zoom"},
    {"crop_pos_x", "crop_x"},
    {"crop_pos_y", "crop_y"},
};

enum { N_PARAMETERS = sizeof parameters / sizeof parameters[0] };

static lf_status merge(json_t *said, const json_t *body, lf_error *err)
{
    const char *uri = json_string_value(json_object_get(body, "uri"));
    json_t *path = NULL;
    if (uri) {
        lf_status status = read_uri(uri, &path, err);
        if (status != LF_OK)
            return status;
        json_object_set_new(said, "file", path);
    }
    for (int i = 0; i < N_PARAMETERS; i++) {
        const json_t *value = json_object_get(body, parameters[i].name);
        double number;
        if (!value || json_is_null(value))
            continue;
        if (!lf_bridge_number(value, &number))
            return lf_error_set(err, LF_E_ARG, parameters[i].name, "is no number");
        json_object_set_new(said, parameters[i].key, json_real(number));
    }
    return json_object_get(said, "file")
               ? LF_OK
               : lf_error_set(err, LF_E_ARG, "uri", "is missing; give the path of a file");
}

static void copy(json_t *entry, const json_t *said, const char *key)
{
    json_t *value = json_object_get(said, key);
    if (value)
        json_object_set(entry, key, value);
}

static lf_status set_switch(json_t *entry, const json_t *said, const char *key, lf_error *err)
{
    const json_t *value = json_object_get(said, key);
    int on = 0;
    if (!value)
        return LF_OK;
    if (!lf_bridge_whole(value, &on) || on < 0 || on > 1)
        return lf_error_set(err, LF_E_ARG, key, "expects 0 or 1");
    json_object_set_new(entry, key, json_string(on ? "on" : "off"));
    return LF_OK;
}

static lf_status set_depth(json_t *entry, const json_t *said, lf_error *err)
{
    static const char *const sides[] = {"top", "bottom", "right", "left"};
    const json_t *depthiness = json_object_get(said, "depthiness");
    const json_t *where = json_object_get(said, "depth_loc");
    int side = 2;
    if (where && (!lf_bridge_whole(where, &side) || side < 0 || side > 3))
        return lf_error_set(err, LF_E_ARG, "depth_loc",
                            "expects 0 (top), 1 (bottom), 2 (right) or 3 (left)");
    json_object_set_new(entry, "rgbd_in", json_string(sides[side]));
    json_object_set_new(entry, "depthiness",
                        json_real(depthiness ? json_number_value(depthiness) : DEPTHINESS));
    copy(entry, said, "depth_cutoff");
    lf_status status = set_switch(entry, said, "depth_inversion", err);
    return status == LF_OK ? set_switch(entry, said, "chroma_depth", err) : status;
}

static lf_status set_quilt(json_t *entry, const json_t *said, lf_error *err)
{
    const json_t *columns = json_object_get(said, "cols"), *rows = json_object_get(said, "rows"),
                 *views = json_object_get(said, "views");
    int n_columns = 0, n_rows = 0, n_views = 0;
    char tiles[32];
    if (json_object_get(said, "isRGBD")) /* whatever the name of the file says */
        json_object_set_new(entry, "rgbd_in", json_string("off"));
    if (!columns != !rows)
        return lf_error_set(err, LF_E_ARG, columns ? "rows" : "cols",
                            "is missing; a quilt needs cols and rows");
    if (columns && (!lf_bridge_whole(columns, &n_columns) || !lf_bridge_whole(rows, &n_rows) ||
                    n_columns < 1 || n_rows < 1 || n_columns > MAX_TILES || n_rows > MAX_TILES))
        return lf_error_set(err, LF_E_ARG, "cols and rows", "expect whole numbers from 1 to %d",
                            MAX_TILES);
    if (views && (!lf_bridge_whole(views, &n_views) || n_views < 0))
        return lf_error_set(err, LF_E_ARG, "view_count", "expects a whole number from 1");
    if (columns && n_views > n_columns * n_rows)
        return lf_error_set(err, LF_E_ARG, "view_count", "expects at most %d, which is cols x rows",
                            n_columns * n_rows);
    if (columns && n_views > 0 && n_views < n_columns * n_rows)
        json_object_set_new(entry, "views", json_integer(n_views));
    snprintf(tiles, sizeof tiles, "%dx%d", n_columns, n_rows);
    if (columns)
        json_object_set_new(entry, "quilt", json_string(tiles));
    if (number_of(said, "aspect") != 0)
        copy(entry, said, "aspect");
    return LF_OK;
}

static lf_status make(json_t *entry, const json_t *said, lf_error *err)
{
    static const char *const both[] = {"file", "focus", "zoom", "crop_x", "crop_y"};
    const double ms = number_of(said, "durationMS");
    for (size_t i = 0; i < sizeof both / sizeof both[0]; i++)
        copy(entry, said, both[i]);
    if (ms < 0)
        return lf_error_set(err, LF_E_ARG, "durationMS", "expects milliseconds from 0");
    if (ms > 0)
        json_object_set_new(entry, "seconds", json_real(ms / 1000));
    return number_of(said, "isRGBD") != 0 ? set_depth(entry, said, err)
                                          : set_quilt(entry, said, err);
}

lf_status lf_bridge_entry_make(json_t *said, const json_t *body, json_t **out_said,
                               json_t **out_entry, lf_error *err)
{
    json_t *merged = json_object(), *entry = json_object();
    lf_status status = merged && entry ? LF_OK : LF_E_NOMEM;
    const char *key;
    json_t *value;
    json_object_foreach(said, key, value) json_object_set(merged, key, value);
    if (status == LF_OK)
        status = merge(merged, body, err);
    if (status == LF_OK)
        status = make(entry, merged, err);
    if (status == LF_OK) {
        *out_said = merged;
        *out_entry = entry;
        return LF_OK;
    }
    json_decref(merged);
    json_decref(entry);
    return status;
}

json_t *lf_bridge_entry_changes(json_t *entry, const json_t *before)
{
    json_t *changes = json_object(), *value;
    const char *key;
    json_object_foreach(entry, key, value)
    {
        if (!json_equal(value, json_object_get(before, key)))
            json_object_set(changes, key, value);
    }
    return changes;
}
