/* Makes, changes and removes profiles. */
#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file.h"
#include "base/log.h"
#include "base/nearest.h"
#include "base/number.h"
#include "daemon/tools/print_profiles_internal.h"

/* Distances that differ by less are one. */
#define SAME_MM 0.05
/* A pitch that differs by more is that of another sheet. */
#define SAME_SHEET 0.05

static const char *const versions[] = {"quiltd_lens", "quiltd_printer"};
static const char *const subfolders[] = {"lenses", "printers"};

/* ------------------------------------------------------------------------------------ places -- */

static bool kind_of_word(const char *word, lf_profile_kind *out)
{
    *out = strcmp(word, "printer") == 0 ? LF_PROFILE_PRINTER : LF_PROFILE_LENS;
    return strcmp(word, lf_profile_kind_name(*out)) == 0;
}

/* The folder that is written to. */
static lf_status folder_of(const lf_profiles_command *command, lf_profile_kind kind,
                           char out[static PATH_MAX], lf_error *err)
{
    if (!command->folder)
        return lf_profile_own_folder(kind, out, err);
    return snprintf(out, PATH_MAX, "%s/%s", command->folder, subfolders[kind]) < PATH_MAX
               ? LF_OK
               : lf_error_set(err, LF_E_ARG, "--folder", "the path is too long");
}

/* The file that is written: in the user's folder, or a path as given. */
static lf_status target_of(const lf_profiles_command *command, lf_profile_kind kind,
                           const char *name, char out[static PATH_MAX], lf_error *err)
{
    char folder[PATH_MAX];
    if (!lf_profile_is_name(name) || lf_path_has_ending(name, ".json"))
        return lf_error_set(
            err, LF_E_ARG, name,
            "is not a name; names have letters, digits, - + _ and ., without .json");
    lf_status status = folder_of(command, kind, folder, err);
    if (status == LF_OK && snprintf(out, PATH_MAX, "%s/%s.json", folder, name) >= PATH_MAX)
        status = lf_error_set(err, LF_E_ARG, name, "the path is too long");
    return status;
}

/* The file that is read: the one in the folder that is written to, then by name. */
static lf_status origin_of(const lf_profiles_command *command, lf_profile_kind kind,
                           const char *name, char out[static PATH_MAX], lf_error *err)
{
    lf_error none;
    if (command->folder && target_of(command, kind, name, out, &none) == LF_OK &&
        access(out, F_OK) == 0)
        return LF_OK;
    return lf_profile_find(kind, name, out, err);
}

lf_status lf_profile_place_of(const lf_profiles_command *command, lf_profile_place *out,
                              lf_error *err)
{
    lf_error other;
    char path[PATH_MAX];
    const bool has_kind = command->n == 2 && kind_of_word(command->words[0], &out->kind);
    if (command->n < 1 || command->n > 2 || (command->n == 2 && !has_kind))
        return lf_error_set(err, LF_E_ARG, "NAME", "expected [lens|printer] NAME");
    out->name = command->words[command->n - 1];
    if (has_kind)
        return origin_of(command, out->kind, out->name, out->path, err);
    const bool printer = origin_of(command, LF_PROFILE_PRINTER, out->name, path, &other) == LF_OK;
    out->kind = LF_PROFILE_LENS;
    lf_status status = origin_of(command, LF_PROFILE_LENS, out->name, out->path, err);
    if (strchr(out->name, '/') || lf_path_has_ending(out->name, ".json")) {
        json_t *values = NULL;
        status = lf_profile_json(out->path, NULL, &values, err);
        if (json_object_get(values, versions[LF_PROFILE_PRINTER]))
            out->kind = LF_PROFILE_PRINTER;
        json_decref(values);
        return status;
    }
    if (status == LF_OK && printer)
        return lf_error_set(err, LF_E_ARG, out->name,
                            "is both a lens and a printer; write lens or printer before it");
    if (status == LF_OK || !printer)
        return status;
    out->kind = LF_PROFILE_PRINTER;
    memcpy(out->path, path, sizeof path);
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- writing -- */

/* Makes a folder and those above it. */
static lf_status make_folder(const char *folder, lf_error *err)
{
    char part[PATH_MAX];
    struct stat st;
    for (size_t i = 1; i <= strlen(folder); i++) {
        if (folder[i] != '/' && folder[i] != '\0')
            continue;
        snprintf(part, sizeof part, "%.*s", (int)i, folder);
        if (mkdir(part, 0755) != 0 && errno != EEXIST)
            return lf_error_set(err, LF_E_IO, part, "cannot make the folder: %s",
                                lf_errno_text(errno));
    }
    if (stat(folder, &st) != 0 || !S_ISDIR(st.st_mode))
        return lf_error_set(err, LF_E_IO, folder, "is not a folder");
    if (st.st_uid != geteuid() || (st.st_mode & S_IWOTH) != 0)
        return lf_error_set(err, LF_E_PATH, folder,
                            st.st_uid != geteuid() ? "belongs to another user"
                                                   : "can be written to by everybody");
    return LF_OK;
}

/* Checks a profile and writes it; origin: the file it was read from, "" for a new one. */
static lf_status write_profile(const lf_profiles_command *command, lf_profile_kind kind,
                               const char *name, const json_t *values, const char *origin,
                               lf_error *err)
{
    char path[PATH_MAX], folder[PATH_MAX];
    char *text = NULL, *line = NULL;
    lf_status status = target_of(command, kind, name, path, err);
    if (status == LF_OK)
        status = lf_profile_check(kind, values, name, err);
    if (status == LF_OK)
        status = folder_of(command, kind, folder, err);
    if (status == LF_OK)
        status = make_folder(folder, err);
    if (status != LF_OK)
        return status;
    text = json_dumps(values, JSON_INDENT(2) | JSON_REAL_PRECISION(10));
    line = text ? lf_calloc(strlen(text) + 2, 1) : NULL;
    if (line) {
        memcpy(line, text, strlen(text));
        line[strlen(text)] = '\n';
    }
    status = line ? lf_outfile_text(path, line, err)
                  : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    free(text);
    lf_free(line);
    if (status == LF_OK && origin[0] != '\0' && strcmp(origin, path) != 0)
        lf_log(LF_LOG_INFO, "wrote %s, a copy of %s with your changes", path, origin);
    else if (status == LF_OK)
        lf_log(LF_LOG_INFO, "wrote %s", path);
    return status;
}

/* --------------------------------------------------------------------------------- KEY=VALUE -- */

static const lf_param *row_of(const lf_param *rows, const char *key)
{
    for (; rows->name; rows++)
        if (strcmp(rows->name, key) == 0)
            return rows;
    return NULL;
}

static json_t *number_of(double value)
{
    return value == floor(value) && fabs(value) < 1e9 ? json_integer((json_int_t)value)
                                                      : json_real(value);
}

/* "300,600" as an array; what is no number becomes a string, which the check refuses. */
static json_t *list_of(const char *text)
{
    json_t *list = json_array();
    char one[64];
    double number;
    while (*text != '\0') {
        const size_t n = strcspn(text, ",");
        snprintf(one, sizeof one, "%.*s", (int)n, text);
        json_array_append_new(list,
                              lf_decimal_is(one, &number) ? number_of(number) : json_string(one));
        text += n + (text[n] == ',');
    }
    return list;
}

static json_t *value_of(const lf_param *row, const char *key, const char *text)
{
    double number;
    if (strcmp(key, "native_dpi") == 0 || strcmp(key, "crosstalk") == 0)
        return list_of(text);
    if (row && row->type == LF_PARAM_SWITCH && !row->words &&
        (strcmp(text, "true") == 0 || strcmp(text, "false") == 0))
        return json_boolean(text[0] == 't');
    return row && row->type != LF_PARAM_TEXT && lf_decimal_is(text, &number) ? number_of(number)
                                                                             : json_string(text);
}

/* Takes "KEY=VALUE" into values; without a VALUE the key is removed. A number that changes loses
 * its source. */
static lf_status take_pair(const lf_param *rows, json_t *values, const char *word, lf_error *err)
{
    char key[64];
    const size_t n = strcspn(word, "=");
    json_t *value;
    if (word[n] != '=' || n == 0 || n >= sizeof key)
        return lf_error_set(err, LF_E_ARG, word, "expected KEY=VALUE");
    memcpy(key, word, n);
    key[n] = '\0';
    json_object_del(json_object_get(values, "sources"), key);
    if (word[n + 1] == '\0') {
        json_object_del(values, key);
        return LF_OK;
    }
    value = value_of(row_of(rows, key), key, word + n + 1);
    if (!value)
        return lf_error_set(err, LF_E_ARG, key, "is not UTF-8");
    return json_object_set_new(values, key, value) == 0
               ? LF_OK
               : lf_error_set(err, LF_E_NOMEM, key, "out of memory");
}

/* A mistake in a word is one of usage. */
static lf_status as_usage(lf_status status, lf_error *err)
{
    if (status == LF_E_FORMAT)
        err->status = LF_E_ARG;
    return status == LF_E_FORMAT ? LF_E_ARG : status;
}

/* The profile as it is, or a new one. origin: its file; empty for a new one. */
static lf_status start_of(const lf_profiles_command *command, lf_profile_kind kind,
                          const char *name, char origin[static PATH_MAX], json_t **out,
                          lf_error *err)
{
    lf_error none;
    if (target_of(command, kind, name, origin, err) != LF_OK)
        return err->status;
    if (origin_of(command, kind, name, origin, &none) != LF_OK) {
        origin[0] = '\0';
        *out = json_pack("{s:i}", versions[kind], 1);
        return *out ? LF_OK : lf_error_set(err, LF_E_NOMEM, name, "out of memory");
    }
    lf_status status = lf_profile_json(origin, NULL, out, err);
    return status == LF_OK ? lf_profile_check(kind, *out, origin, err) : status;
}

lf_status lf_profiles_set(const lf_profiles_command *command, lf_error *err)
{
    lf_profile_kind kind;
    char origin[PATH_MAX] = "";
    json_t *values = NULL;
    if (command->n < 3 || !kind_of_word(command->words[0], &kind))
        return lf_error_set(err, LF_E_ARG, "set", "expected lens|printer NAME KEY=VALUE");
    const char *name = command->words[1];
    lf_status status = start_of(command, kind, name, origin, &values, err);
    for (int i = 2; i < command->n && status == LF_OK; i++)
        status = take_pair(lf_profile_rows(kind), values, command->words[i], err);
    if (status == LF_OK)
        status = as_usage(write_profile(command, kind, name, values, origin, err), err);
    json_decref(values);
    return status;
}

/* ------------------------------------------------------------------------------- calibrating -- */

/* Copies what a calibration keeps from the reading of a chart. */
static lf_status take_reading(const char *path, json_t *out, lf_error *err)
{
    json_t *reading = NULL, *line;
    size_t i;
    lf_status status = lf_profile_json(path, NULL, &reading, err);
    if (status != LF_OK)
        return status;
    if (json_integer_value(json_object_get(reading, "quiltd_chart_reading")) != 1) {
        json_decref(reading);
        return lf_error_set(err, LF_E_FORMAT, path,
                            "is not the reading of a chart; make one with quiltrender "
                            "--read-chart");
    }
    for (const lf_param *row = lf_calibration_rows; row->name; row++) {
        json_t *value = json_object_get(reading, row->name);
        if (value && !json_is_null(value) && strcmp(row->name, "printer") != 0)
            json_object_set(out, row->name, value);
    }
    json_t *crosstalk = json_object_get(reading, "crosstalk");
    if (json_array_size(crosstalk) > 0)
        json_object_set(out, "crosstalk", crosstalk);
    json_array_foreach(json_object_get(reading, "warnings"), i, line)
    {
        if (json_is_string(line))
            lf_log(LF_LOG_WARNING, "%s: %s", path, json_string_value(line));
    }
    json_decref(reading);
    return LF_OK;
}

static void set_today(json_t *calibration)
{
    char date[32];
    const time_t now = time(NULL);
    struct tm day;
    if (json_object_get(calibration, "date") || !gmtime_r(&now, &day))
        return;
    strftime(date, sizeof date, "%Y-%m-%d", &day);
    json_object_set_new(calibration, "date", json_string(date));
}

/* How the lenses ran that a calibration was measured with. */
static const char *axis_of(const json_t *lens, const json_t *calibration)
{
    const char *own = json_string_value(json_object_get(calibration, "orientation")),
               *sheet = json_string_value(json_object_get(lens, "orientation"));
    return own ? own : sheet ? sheet : "vertical";
}

/* Replaces the calibration with the same printer, distance and run of lenses, or adds one. */
static void put_calibration(json_t *lens, const json_t *calibration)
{
    json_t *list = json_object_get(lens, "calibrations"), *one;
    const char *printer = json_string_value(json_object_get(calibration, "printer"));
    const double distance = json_number_value(json_object_get(calibration, "distance_mm"));
    size_t i;
    if (!list) {
        list = json_array();
        json_object_set_new(lens, "calibrations", list);
    }
    json_array_foreach(list, i, one)
    {
        const char *other = json_string_value(json_object_get(one, "printer"));
        const double at = json_number_value(json_object_get(one, "distance_mm"));
        if (strcmp(other, printer) != 0 || fabs(at - distance) > SAME_MM ||
            strcmp(axis_of(lens, one), axis_of(lens, calibration)) != 0)
            continue;
        json_array_set(list, i, (json_t *)(uintptr_t)calibration);
        return;
    }
    json_array_append(list, (json_t *)(uintptr_t)calibration);
}

static lf_status check_sheet(const json_t *lens, const json_t *calibration, const char *name,
                             lf_error *err)
{
    const double pitch = json_number_value(json_object_get(lens, "pitch_lpi")),
                 visual = json_number_value(json_object_get(calibration, "visual_lpi"));
    return fabs(visual / pitch - 1) <= SAME_SHEET
               ? LF_OK
               : lf_error_set(err, LF_E_ARG, name,
                              "has %g lpi, but %g were measured; it is another sheet, or set its "
                              "pitch_lpi",
                              pitch, visual);
}

/* Reads the words after LENS PRINTER. */
static lf_status take_words(const lf_profiles_command *command, json_t *calibration, lf_error *err)
{
    const char *file = NULL;
    lf_status status = LF_OK;
    for (int i = 2; i < command->n; i++) {
        const char *word = command->words[i];
        if (strchr(word, '='))
            continue;
        if (file)
            return lf_error_set(err, LF_E_ARG, word, "unexpected; give one file");
        file = word;
    }
    if (file)
        status = take_reading(file, calibration, err);
    for (int i = 2; i < command->n && status == LF_OK; i++)
        if (strchr(command->words[i], '='))
            status = take_pair(lf_calibration_rows, calibration, command->words[i], err);
    return status;
}

/* The calibration of the words, alone in a lens, so that its errors have a short pointer. */
static lf_status check_calibration(const json_t *calibration, lf_error *err)
{
    json_t *alone = json_pack("{s:i, s:i, s:[O]}", "quiltd_lens", 1, "pitch_lpi", 60,
                              "calibrations", calibration);
    static const char in[] = "/calibrations/0";
    lf_status status = alone ? lf_profile_check(LF_PROFILE_LENS, alone, "calibrate", err)
                             : lf_error_set(err, LF_E_NOMEM, "calibrate", "out of memory");
    json_decref(alone);
    if (status != LF_OK && strncmp(err->pointer, in, strlen(in)) == 0)
        memmove(err->pointer, err->pointer + strlen(in), strlen(err->pointer + strlen(in)) + 1);
    return as_usage(status, err);
}

lf_status lf_profiles_calibrate(const lf_profiles_command *command, lf_error *err)
{
    char origin[PATH_MAX], printer[PATH_MAX];
    json_t *lens = NULL, *calibration = NULL;
    if (command->n < 3)
        return lf_error_set(err, LF_E_ARG, "calibrate",
                            "expected LENS PRINTER RESULT.json, or KEY=VALUE");
    const char *name = command->words[0];
    lf_status status = target_of(command, LF_PROFILE_LENS, name, origin, err);
    if (status == LF_OK)
        status = origin_of(command, LF_PROFILE_LENS, name, origin, err);
    if (status == LF_OK)
        status = origin_of(command, LF_PROFILE_PRINTER, command->words[1], printer, err);
    if (status == LF_OK)
        status = lf_profile_json(origin, NULL, &lens, err);
    if (status == LF_OK)
        status = lf_profile_check(LF_PROFILE_LENS, lens, origin, err);
    if (status == LF_OK) {
        calibration = json_pack("{s:s}", "printer", command->words[1]);
        status = take_words(command, calibration, err);
    }
    if (status == LF_OK)
        set_today(calibration);
    if (status == LF_OK)
        status = check_calibration(calibration, err);
    if (status == LF_OK)
        status = check_sheet(lens, calibration, name, err);
    if (status == LF_OK) {
        put_calibration(lens, calibration);
        status = write_profile(command, LF_PROFILE_LENS, name, lens, origin, err);
    }
    json_decref(calibration);
    json_decref(lens);
    return status;
}

/* ---------------------------------------------------------------------------------- removing -- */

lf_status lf_profiles_remove(const lf_profiles_command *command, lf_error *err)
{
    lf_profile_place place;
    char path[PATH_MAX];
    lf_error none;
    lf_status status = lf_profile_place_of(command, &place, err);
    if (status == LF_OK)
        status = target_of(command, place.kind, place.name, path, err);
    if (status != LF_OK)
        return status;
    if (unlink(path) != 0)
        return errno == ENOENT
                   ? lf_error_set(err, LF_E_ARG, place.name,
                                  "is in %s; only profiles of yours can be removed", place.path)
                   : lf_error_set(err, LF_E_IO, path, "cannot remove: %s", lf_errno_text(errno));
    lf_log(LF_LOG_INFO, "removed %s", path);
    if (lf_profile_find(place.kind, place.name, path, &none) == LF_OK)
        lf_log(LF_LOG_INFO, "%s is now %s", place.name, path);
    return LF_OK;
}
