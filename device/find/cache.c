#include <dirent.h>
#include <jansson.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "device/device_table.h"
#include "device/find/find.h"

#define SUFFIX ".json"
#define DISPLAY "display" /* a key that calibrations do not have */

/* The folder of the cache; false when there is no place for one. */
static bool cache_folder(char *out, size_t size)
{
    static const struct {
        const char *variable, *below;
    } places[] = {{"CACHE_DIRECTORY", "panels"},
                  {"XDG_CACHE_HOME", "quiltd/panels"},
                  {"HOME", ".cache/quiltd/panels"}};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        const char *base = getenv(places[i].variable);
        if (!base || base[0] != '/')
            continue;
        /* systemd separates several cache directories by colons; the first is ours */
        int n = snprintf(out, size, "%.*s/%s", (int)strcspn(base, i == 0 ? ":" : ""), base,
                         places[i].below);
        return n > 0 && (size_t)n < size;
    }
    return false;
}

/* A file's name from a panel's, which comes from a device: nothing that leads elsewhere or hides.
 */
static bool file_name(const char *panel, char *out, size_t size)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
    if (panel[0] == 0)
        return false;
    int n = snprintf(out, size, "%s%s", panel, SUFFIX);
    if (n < 0 || (size_t)n >= size)
        return false;
    for (size_t i = 0; i < (size_t)n - strlen(SUFFIX); i++)
        if (!strchr(plain, out[i]))
            out[i] = '_';
    return true;
}

/* The text of a calibration and of its display; NULL = out of memory. Released with free. */
static char *to_text(const lf_found *found)
{
    json_t *root = lf_calibration_json(&found->calibration);
    if (root && found->display.name[0] != 0)
        json_object_set_new(
            root, DISPLAY,
            json_pack("{s:s,s:s}", "name", found->display.name, "serial", found->display.serial));
    char *text = root ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(root);
    return text;
}

static void make_folders(char *path)
{
    for (char *p = path + 1; *p != 0; p++) {
        if (*p != '/')
            continue;
        *p = 0;
        mkdir(path, 0700);
        *p = '/';
    }
    mkdir(path, 0700);
}

static void take_display(const char *text, size_t n, lf_edid *out)
{
    json_t *root = json_loadb(text, n, 0, NULL);
    const json_t *display = json_object_get(root, DISPLAY);
    const char *name = json_string_value(json_object_get(display, "name"));
    const char *serial = json_string_value(json_object_get(display, "serial"));
    *out = (lf_edid){0};
    if (name && serial) {
        lf_device_text(out->name, sizeof out->name, name);
        lf_device_text(out->serial, sizeof out->serial, serial);
    }
    json_decref(root);
}

/* Calibration and display of a file; false = there is none, or it is damaged. */
static bool load(const char *path, lf_found *out)
{
    char *text = NULL;
    size_t n = 0;
    if (lf_file_read(path, NULL, LF_CALIBRATION_MAX_BYTES, &text, &n, NULL) != LF_OK)
        return false;
    bool good = lf_calibration_parse(text, n, path, &out->calibration, NULL) == LF_OK;
    if (good)
        take_display(text, n, &out->display);
    lf_free(text);
    return good;
}

static bool is_cached(const char *path, const lf_found *found)
{
    lf_found old = {0};
    return load(path, &old) &&
           memcmp(&old.calibration, &found->calibration, sizeof old.calibration) == 0 &&
           strcmp(old.display.name, found->display.name) == 0 &&
           strcmp(old.display.serial, found->display.serial) == 0;
}

void lf_cache_store(const lf_found *found)
{
    char folder[PATH_MAX], name[sizeof found->label + sizeof SUFFIX], path[PATH_MAX + sizeof name];
    lf_error err = {0};
    if (!cache_folder(folder, sizeof folder) || !file_name(lf_found_name(found), name, sizeof name))
        return;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    if (is_cached(path, found))
        return;
    char *text = to_text(found);
    if (!text)
        return;
    make_folders(folder);
    if (lf_outfile_text(path, text, &err) != LF_OK)
        lf_log(LF_LOG_DEBUG, "%s: cannot cache the calibration: %s", path, err.what);
    free(text);
}

int lf_cache_list(lf_found *out, int max)
{
    char folder[PATH_MAX];
    if (!cache_folder(folder, sizeof folder))
        return 0;
    DIR *dir = opendir(folder);
    if (!dir)
        return 0;
    int n = 0;
    for (struct dirent *e = readdir(dir); e && n < max; e = readdir(dir)) {
        size_t length = strlen(e->d_name);
        char path[PATH_MAX + sizeof e->d_name + 1];
        if (e->d_name[0] == '.' || length <= strlen(SUFFIX) ||
            strcmp(e->d_name + length - strlen(SUFFIX), SUFFIX) != 0)
            continue;
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        lf_found found = {.source = LF_SOURCE_CACHE};
        /* a damaged one is no news to anybody: it is written anew when its panel is read */
        if (!load(path, &found))
            continue;
        lf_device_text(found.path, sizeof found.path, path);
        e->d_name[length - strlen(SUFFIX)] = 0;
        lf_device_text(found.label, sizeof found.label, e->d_name);
        out[n++] = found;
    }
    closedir(dir);
    return n;
}
