/* Shows profiles. */
#include "daemon/tools/print_profiles.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/escape.h"
#include "base/log.h"
#include "daemon/tools/print_profiles_internal.h"

/* -------------------------------------------------------------------------------------- list -- */

/* "60 lpi, 0.6 mm, 54 degrees" */
static void describe_lens(const lf_lens_profile *lens, char *out, size_t size)
{
    const lf_optics *o = &lens->optics;
    int used = snprintf(out, size, "%.6g lpi", lens->pitch_lpi);
    if (o->thickness_mm > 0)
        used += snprintf(out + used, size - (size_t)used, ", %.4g mm", o->thickness_mm);
    if (o->angle > 0)
        used += snprintf(out + used, size - (size_t)used, ", %.4g degrees", o->angle);
    if (lens->n_calibrations > 0)
        snprintf(out + used, size - (size_t)used, ", %d calibration%s", lens->n_calibrations,
                 lens->n_calibrations == 1 ? "" : "s");
}

static lf_status describe(lf_profile_kind kind, const lf_profile_entry *entry, char *title,
                          char *out, size_t size, lf_error *err)
{
    static lf_lens_profile lens; /* large */
    static lf_printer_profile printer;
    lf_status status = kind == LF_PROFILE_LENS
                           ? lf_profile_lens_read(entry->path, NULL, &lens, err)
                           : lf_profile_printer_read(entry->path, NULL, &printer, err);
    if (status != LF_OK)
        return status;
    if (kind == LF_PROFILE_LENS)
        describe_lens(&lens, out, size);
    else if (printer.dpi_down > 0 && printer.dpi_down != printer.dpi)
        snprintf(out, size, "%gx%g dpi", printer.dpi, printer.dpi_down);
    else
        snprintf(out, size, "%g dpi", printer.dpi);
    snprintf(title, LF_PROFILE_TEXT, "%s", kind == LF_PROFILE_LENS ? lens.title : printer.title);
    return LF_OK;
}

/* Lists a kind; *out_bad counts profiles that cannot be read. */
static lf_status list_kind(lf_profile_kind kind, json_t *json, int *out_bad, lf_error *err)
{
    lf_profile_entry *entries = NULL;
    char title[LF_PROFILE_TEXT], what[256];
    int n = 0;
    lf_error bad;
    lf_status status = lf_profile_list(kind, &entries, &n, err);
    for (int i = 0; i < n && status == LF_OK; i++) {
        const lf_profile_entry *entry = &entries[i];
        if (describe(kind, entry, title, what, sizeof what, &bad) != LF_OK) {
            lf_log_error(&bad);
            ++*out_bad;
        } else if (json) {
            json_array_append_new(json, json_pack("{s:s, s:s, s:s, s:s, s:b}", "kind",
                                                  lf_profile_kind_name(kind), "profile",
                                                  entry->name, "name", title, "file", entry->path,
                                                  "own", entry->is_own));
        } else {
            printf("%-8s %-18s %-40s %s%s\n", lf_profile_kind_name(kind), entry->name, what, title,
                   entry->is_own ? " (yours)" : "");
        }
    }
    lf_free(entries);
    return status;
}

lf_status lf_profiles_list(const lf_profiles_command *command, lf_error *err)
{
    const char *word = command->n > 0 ? command->words[0] : NULL;
    const bool lenses = !word || strcmp(word, "lenses") == 0,
               printers = !word || strcmp(word, "printers") == 0;
    int n_bad = 0;
    if ((!lenses && !printers) || command->n > 1)
        return lf_error_set(err, LF_E_ARG, "list", "expects lenses, printers or nothing");
    json_t *json = command->json ? json_array() : NULL;
    lf_status status = lenses ? list_kind(LF_PROFILE_LENS, json, &n_bad, err) : LF_OK;
    if (status == LF_OK && printers)
        status = list_kind(LF_PROFILE_PRINTER, json, &n_bad, err);
    if (status == LF_OK && json) {
        json_dumpf(json, stdout, JSON_INDENT(2));
        putchar('\n');
    }
    json_decref(json);
    return status == LF_OK && n_bad > 0
               ? lf_error_set(err, LF_E_FORMAT, "list", "%d profile%s cannot be read", n_bad,
                              n_bad == 1 ? "" : "s")
               : status;
}

/* -------------------------------------------------------------------------------------- show -- */

static void show_text(const char *text)
{
    char escaped[1024];
    lf_escape(escaped, sizeof escaped, text);
    fputs(escaped, stdout);
}

static void show_value(const json_t *value)
{
    char *text = json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(10));
    if (json_is_string(value))
        show_text(json_string_value(value));
    else
        fputs(text ? text : "", stdout);
    free(text);
}

static void show_calibrations(const json_t *list)
{
    size_t i;
    json_t *one, *value;
    const char *key;
    json_array_foreach(list, i, one)
    {
        printf("calibration   ");
        json_object_foreach(one, key, value)
        {
            printf(" %s=", key);
            show_value(value);
        }
        putchar('\n');
    }
}

static void show_keys(json_t *values)
{
    const json_t *sources = json_object_get(values, "sources");
    const char *key, *source;
    json_t *value;
    json_object_foreach(values, key, value)
    {
        if (strcmp(key, "sources") == 0 || strcmp(key, "calibrations") == 0 ||
            strncmp(key, "quiltd_", 7) == 0)
            continue;
        printf("%-14s ", key);
        show_value(value);
        source = json_string_value(json_object_get(sources, key));
        if (source) {
            printf("  (");
            show_text(source);
            putchar(')');
        }
        putchar('\n');
    }
    show_calibrations(json_object_get(values, "calibrations"));
}

lf_status lf_profiles_show(const lf_profiles_command *command, lf_error *err)
{
    lf_profile_place place;
    json_t *values = NULL;
    lf_status status = lf_profile_place_of(command, &place, err);
    if (status == LF_OK)
        status = lf_profile_json(place.path, NULL, &values, err);
    if (status == LF_OK)
        status = lf_profile_check(place.kind, values, place.path, err);
    if (status == LF_OK && command->json) {
        json_dumpf(values, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(10));
        putchar('\n');
    } else if (status == LF_OK) {
        printf("%-14s ", lf_profile_kind_name(place.kind));
        show_text(place.path);
        putchar('\n');
        show_keys(values);
    }
    json_decref(values);
    return status;
}
