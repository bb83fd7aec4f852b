/* Profiles from JSON: every key is known and in range, or the file is refused. */
#include <math.h>
#include <nettle/sha2.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/nearest.h"
#include "base/text.h"
#include "quilt/profile/profile.h"

/* A part of a file that is being read; pointers in errors begin with `at`. */
typedef struct part {
    const char *where, *at;
    lf_error *err;
} part;

static lf_status wrong(const part *p, const char *key, const char *what)
{
    char pointer[128];
    snprintf(pointer, sizeof pointer, "%s/%.64s", p->at, key);
    return lf_error_set_at(p->err, LF_E_FORMAT, p->where, 0, pointer, "%s", what);
}

static bool has_control(const char *text)
{
    for (; *text != '\0'; text++)
        if ((unsigned char)*text < ' ' || *text == 0x7f)
            return true;
    return false;
}

/* Refuses keys that have no row and are not among `others`, ended by NULL. */
static lf_status check_keys(const part *p, const json_t *values, const lf_param *rows,
                            const char *const *others)
{
    const char *names[32], *key;
    const json_t *value;
    char what[256];
    int n = 0;
    for (const lf_param *row = rows; row->name; row++)
        names[n++] = row->name;
    for (; *others; others++)
        names[n++] = *others;
    names[n] = NULL;
    json_object_foreach((json_t *)(uintptr_t)values, key, value)
    {
        int i = 0;
        while (i < n && strcmp(names[i], key) != 0)
            i++;
        if (i < n)
            continue;
        const char *meant = lf_nearest_name(key, names);
        snprintf(what, sizeof what, "unknown key%s%s%s", meant ? "; did you mean \"" : "",
                 meant ? meant : "", meant ? "\"?" : "");
        return wrong(p, key, what);
    }
    return LF_OK;
}

/* Reads the keys that have rows. */
static lf_status take_rows(const part *p, const json_t *values, const lf_param *rows,
                           lf_profile_words *words)
{
    lf_error err;
    const char *missing = lf_param_missing(rows, values);
    if (missing)
        return wrong(p, missing, "is missing");
    if (lf_param_from_json(rows, values, words, p->where, &err) != LF_OK)
        return wrong(p, err.pointer + 1, err.what);
    for (const lf_param *row = rows; row->name; row++) {
        const char *text = json_string_value(json_object_get(values, row->name));
        if (row->type == LF_PARAM_TEXT && text && has_control(text))
            return wrong(p, row->name, "holds a control character");
    }
    return LF_OK;
}

/* text NULL: leaves out as it is. */
static lf_status take_text(const part *p, const char *key, const char *text, char *out, size_t size)
{
    char what[64];
    if (!text)
        return LF_OK;
    if (strlen(text) >= size) {
        snprintf(what, sizeof what, "expected at most %zu bytes", size - 1);
        return wrong(p, key, what);
    }
    memcpy(out, text, strlen(text) + 1);
    return LF_OK;
}

/* ------------------------------------------------------------------------------ calibrations -- */

static bool is_hash(const char *text)
{
    return strlen(text) == 64 && strspn(text, "0123456789abcdef") == 64;
}

static bool is_date(const char *text)
{
    static const char form[] = "0000-00-00";
    for (size_t i = 0; i < sizeof form; i++)
        if (form[i] == '0' ? text[i] < '0' || text[i] > '9' : text[i] != form[i])
            return false;
    return true;
}

/* Shares from view -n to n of light seen at a view. */
static lf_status take_crosstalk(const part *p, const json_t *list, lf_lens_calibration *out)
{
    const size_t n = json_array_size(list);
    double sum = 0;
    if (!list)
        return LF_OK;
    if (n % 2 == 0 || n > sizeof out->crosstalk / sizeof *out->crosstalk)
        return wrong(p, "crosstalk", "expected an odd number of shares, at most 17");
    for (size_t i = 0; i < n; i++) {
        const json_t *share = json_array_get(list, i);
        out->crosstalk[i] = json_number_value(share);
        sum += out->crosstalk[i];
        if (!json_is_number(share) || !(out->crosstalk[i] >= 0 && out->crosstalk[i] <= 1))
            return wrong(p, "crosstalk", "expected numbers from 0 to 1");
    }
    out->n_crosstalk = (int)n / 2;
    return fabs(sum - 1) <= 0.01 ? LF_OK : wrong(p, "crosstalk", "the shares must sum to 1");
}

static lf_status take_calibration(const part *p, const json_t *values, lf_profile_words *words,
                                  lf_lens_calibration *out)
{
    static const char *const others[] = {"crosstalk", NULL};
    lf_lens_calibration *c = &words->calibration;
    if (!json_is_object(values))
        return lf_error_set_at(p->err, LF_E_FORMAT, p->where, 0, p->at, "expected an object");
    *c = (lf_lens_calibration){.crosstalk_views = LF_CHART_CODES};
    words->of_printer = words->date = words->chart_sha256 = NULL;
    lf_status status = check_keys(p, values, lf_calibration_rows, others);
    if (status == LF_OK)
        status = take_rows(p, values, lf_calibration_rows, words);
    if (status != LF_OK)
        return status;
    if (!lf_profile_is_name(words->of_printer))
        return wrong(p, "printer", "expected the name of a printer profile");
    if (words->date && !is_date(words->date))
        return wrong(p, "date", "expected a day, as 2026-11-29");
    if (words->chart_sha256 && !is_hash(words->chart_sha256))
        return wrong(p, "chart_sha256", "expected 64 hexadecimal digits");
    c->has_horizontal = json_object_get(values, "orientation");
    status = take_text(p, "printer", words->of_printer, c->printer, sizeof c->printer);
    if (status == LF_OK)
        status = take_text(p, "date", words->date, c->date, sizeof c->date);
    if (status == LF_OK)
        status = take_text(p, "chart_sha256", words->chart_sha256, c->chart_sha256,
                           sizeof c->chart_sha256);
    if (status == LF_OK)
        status = take_crosstalk(p, json_object_get(values, "crosstalk"), c);
    if (status == LF_OK)
        *out = *c;
    return status;
}

static lf_status take_calibrations(const part *p, const json_t *list, lf_profile_words *words)
{
    lf_lens_profile *lens = &words->lens;
    char at[64];
    const part child = {p->where, at, p->err};
    if (list && !json_is_array(list))
        return wrong(p, "calibrations", "expected an array");
    if (json_array_size(list) > LF_PROFILE_CALIBRATIONS)
        return wrong(p, "calibrations", "expected at most 64 calibrations");
    for (size_t i = 0; i < json_array_size(list); i++) {
        snprintf(at, sizeof at, "/calibrations/%zu", i);
        lf_status status =
            take_calibration(&child, json_array_get(list, i), words, &lens->calibrations[i]);
        if (status != LF_OK)
            return status;
        lens->n_calibrations++;
    }
    return LF_OK;
}

/* ---------------------------------------------------------------------------------- profiles -- */

static lf_status take_native(const part *p, const json_t *list, lf_printer_profile *out)
{
    if (list && (!json_is_array(list) || json_array_size(list) > LF_PROFILE_NATIVE))
        return wrong(p, "native_dpi", "expected an array of at most 16 numbers");
    for (size_t i = 0; i < json_array_size(list); i++) {
        const double dpi = json_number_value(json_array_get(list, i));
        if (!(dpi >= 50 && dpi <= 9600))
            return wrong(p, "native_dpi", "expected numbers from 50 to 9600 dpi");
        out->native_dpi[out->n_native++] = dpi;
    }
    return LF_OK;
}

/* {key: where its number comes from}, for people; every key must have a number. */
static lf_status check_sources(const part *p, const json_t *values)
{
    json_t *sources = json_object_get(values, "sources"), *text;
    const char *key;
    const part child = {p->where, "/sources", p->err};
    if (sources && !json_is_object(sources))
        return wrong(p, "sources", "expected an object");
    json_object_foreach(sources, key, text)
    {
        if (!json_is_string(text) || has_control(json_string_value(text)))
            return wrong(&child, key, "expected a string");
        if (!json_object_get(values, key))
            return wrong(&child, key, "the profile has no such key");
    }
    return LF_OK;
}

/* The key that says what a file is, with the version of its format. */
static lf_status check_version(const part *p, const json_t *values, lf_profile_kind kind)
{
    static const char *const keys[] = {"quiltd_lens", "quiltd_printer"};
    char what[96];
    if (!json_is_object(values))
        return lf_error_set(p->err, LF_E_FORMAT, p->where, "expected a JSON object");
    if (!json_object_get(values, keys[kind]) && json_object_get(values, keys[1 - kind])) {
        snprintf(what, sizeof what, "is the profile of a %s; expected that of a %s",
                 lf_profile_kind_name(1 - kind), lf_profile_kind_name(kind));
        return lf_error_set(p->err, LF_E_FORMAT, p->where, "%s", what);
    }
    const json_t *version = json_object_get(values, keys[kind]);
    if (!json_is_integer(version) || json_integer_value(version) != 1)
        return wrong(p, keys[kind], "expected 1; the file is no profile, or of a later format");
    return LF_OK;
}

/* Everything of a profile but its name and hash. */
static lf_status take_profile(lf_profile_kind kind, const json_t *values, const char *where,
                              lf_profile_words *words, lf_error *err)
{
    static const char *const of_lens[] = {"quiltd_lens", "calibrations", "sources", NULL};
    static const char *const of_printer[] = {"quiltd_printer", "native_dpi", "sources", NULL};
    const part p = {where, "", err};
    const lf_param *rows = lf_profile_rows(kind);
    lf_status status = check_version(&p, values, kind);
    if (status == LF_OK)
        status = check_keys(&p, values, rows, kind == LF_PROFILE_LENS ? of_lens : of_printer);
    if (status == LF_OK)
        status = take_rows(&p, values, rows, words);
    if (status == LF_OK)
        status = check_sources(&p, values);
    words->lens.has_horizontal = json_object_get(values, "orientation");
    if (status == LF_OK && kind == LF_PROFILE_LENS)
        return take_calibrations(&p, json_object_get(values, "calibrations"), words);
    return status == LF_OK ? take_native(&p, json_object_get(values, "native_dpi"), &words->printer)
                           : status;
}

static lf_status take_titles(const lf_profile_words *words, const char *where, char *title,
                             char *maker, char *source, lf_error *err)
{
    const part p = {where, "", err};
    lf_status status = take_text(&p, "name", words->title, title, LF_PROFILE_TEXT);
    if (status == LF_OK)
        status = take_text(&p, "maker", words->maker, maker, LF_PROFILE_TEXT);
    return status == LF_OK ? take_text(&p, "source", words->source, source, LF_PROFILE_TEXT)
                           : status;
}

/* A relative path is relative to the profile's folder. */
static lf_status take_icc(const lf_profile_words *words, const char *where, char *out,
                          lf_error *err)
{
    const part p = {where, "", err};
    if (!words->icc || words->icc[0] == '\0')
        return LF_OK;
    char *folder = lf_path_folder(where), *path = folder ? lf_path_join(folder, words->icc) : NULL;
    lf_status status = path ? take_text(&p, "icc", path, out, PATH_MAX)
                            : lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    lf_free(path);
    lf_free(folder);
    return status;
}

static lf_status fill(lf_profile_kind kind, const json_t *values, const char *where,
                      lf_profile_words *words, lf_error *err)
{
    lf_status status = take_profile(kind, values, where, words, err);
    if (status != LF_OK)
        return status;
    if (kind == LF_PROFILE_LENS)
        return take_titles(words, where, words->lens.title, words->lens.maker, words->lens.source,
                           err);
    status = take_titles(words, where, words->printer.title, words->printer.maker,
                         words->printer.source, err);
    return status == LF_OK ? take_icc(words, where, words->printer.icc, err) : status;
}

/* ------------------------------------------------------------------------------------- files -- */

/* The name of a file without folder and ending. */
static void name_of(const char *path, char out[static LF_PROFILE_NAME])
{
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    size_t n = strlen(name);
    if (lf_path_has_ending(name, ".json"))
        n -= strlen(".json");
    snprintf(out, LF_PROFILE_NAME, "%.*s", (int)(n < LF_PROFILE_NAME ? n : LF_PROFILE_NAME - 1),
             name);
}

static void hash_text(const char *text, size_t n, char out[static 65])
{
    struct sha256_ctx hash;
    uint8_t digest[SHA256_DIGEST_SIZE];
    sha256_init(&hash);
    sha256_update(&hash, n, (const uint8_t *)text);
    sha256_digest(&hash, sizeof digest, digest);
    for (size_t i = 0; i < sizeof digest; i++)
        snprintf(out + 2 * i, 3, "%02x", digest[i]);
}

/* sha256 may be NULL. */
static lf_status load(const char *path, const lf_roots *roots, char *sha256, json_t **out,
                      lf_error *err)
{
    char *text = NULL;
    size_t n = 0;
    json_error_t bad;
    lf_status status = lf_file_read(path, roots, LF_PROFILE_BYTES, &text, &n, err);
    if (status == LF_OK && sha256)
        hash_text(text, n, sha256);
    if (status == LF_OK)
        status = lf_text_take(text, &n, path, err);
    if (status == LF_OK) {
        *out = json_loadb(text, n, JSON_REJECT_DUPLICATES, &bad);
        if (!*out)
            status = lf_error_set_at(err, LF_E_FORMAT, path, bad.line, "", "%s", bad.text);
    }
    lf_free(text);
    return status;
}

lf_status lf_profile_json(const char *path, const lf_roots *roots, json_t **out, lf_error *err)
{
    return load(path, roots, NULL, out, err);
}

lf_status lf_profile_check(lf_profile_kind kind, const json_t *values, const char *where,
                           lf_error *err)
{
    lf_profile_words *words = lf_calloc(1, sizeof *words);
    lf_status status = words ? fill(kind, values, where, words, err)
                             : lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    lf_free(words);
    return status;
}

/* Fills *words, which the caller frees, and *out_file. */
static lf_status read_profile(lf_profile_kind kind, const char *name, const lf_roots *roots,
                              lf_profile_words **out, lf_profile_file *out_file, lf_error *err)
{
    json_t *values = NULL;
    lf_profile_words *words = lf_calloc(1, sizeof *words);
    lf_status status = words ? lf_profile_find(kind, name, out_file->path, err)
                             : lf_error_set(err, LF_E_NOMEM, name, "out of memory");
    if (status == LF_OK)
        status = load(out_file->path, lf_profile_is_path(name) ? roots : NULL, out_file->sha256,
                      &values, err);
    if (status == LF_OK)
        status = fill(kind, values, out_file->path, words, err);
    json_decref(values);
    if (status == LF_OK) {
        name_of(out_file->path, out_file->name);
        *out = words;
    } else {
        lf_free(words);
    }
    return status;
}

lf_status lf_profile_lens_read(const char *name, const lf_roots *roots, lf_lens_profile *out,
                               lf_error *err)
{
    lf_profile_words *words;
    lf_profile_file file = {0};
    lf_status status = read_profile(LF_PROFILE_LENS, name, roots, &words, &file, err);
    if (status != LF_OK)
        return status;
    *out = words->lens;
    out->file = file;
    lf_free(words);
    return LF_OK;
}

lf_status lf_profile_printer_read(const char *name, const lf_roots *roots, lf_printer_profile *out,
                                  lf_error *err)
{
    lf_profile_words *words;
    lf_profile_file file = {0};
    lf_status status = read_profile(LF_PROFILE_PRINTER, name, roots, &words, &file, err);
    if (status != LF_OK)
        return status;
    *out = words->printer;
    out->file = file;
    lf_free(words);
    return LF_OK;
}
