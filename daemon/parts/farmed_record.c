/* What is kept of a job in the folder of --state, so that a restarted quiltd follows it. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "daemon/parts/farmed_internal.h"

#define BEGINNING "farm-"
#define ENDING ".json"
enum { MOST_BYTES = 65536, DIGITS = 16 };

bool lf_farmed_is_record(const char *name)
{
    const size_t n = strlen(BEGINNING),
                 digits = strspn(name + (strlen(name) < n ? 0 : n), "0123456789abcdef");
    return strncmp(name, BEGINNING, n) == 0 && digits == DIGITS &&
           strcmp(name + n + DIGITS, ENDING) == 0;
}

/* FNV-1a: the name only has to differ between the few jobs of a daemon. */
static uint64_t hash_of(const char *text)
{
    uint64_t hash = UINT64_C(14695981039346656037);
    for (; *text != '\0'; text++)
        hash = (hash ^ (unsigned char)*text) * UINT64_C(1099511628211);
    return hash;
}

char *lf_farmed_record_path(const lf_farmed *farmed, const char *folder)
{
    char name[sizeof BEGINNING + DIGITS + sizeof ENDING];
    snprintf(name, sizeof name, BEGINNING "%016" PRIx64 ENDING, hash_of(folder));
    return farmed->home.state_dir ? lf_path_join(farmed->home.state_dir, name) : NULL;
}

void lf_farmed_record_write(const lf_farmed_job *job)
{
    const lf_farmed_order *order = &job->order;
    lf_error err;
    if (!job->record)
        return;
    json_t *said = json_pack("{s:s, s:s, s:s, s:s}", "job", order->folder.path, "engine",
                             order->engine, "kind", order->kind, "file", order->file);
    char *text = said ? json_dumps(said, JSON_INDENT(2)) : NULL;
    lf_status status = text ? lf_outfile_text(job->record, text, &err)
                            : lf_error_set(&err, LF_E_FORMAT, order->folder.path,
                                           "a restarted quiltd will not follow this job, because "
                                           "its name is not UTF-8");
    if (status != LF_OK)
        lf_log_error(&err);
    free(text);
    json_decref(said);
}

/* A static name that equals this one; NULL: none. */
static const char *engine_named(const char *name)
{
    int i = 0;
    while (name && lf_farmed_engine_at(i) && strcmp(lf_farmed_engine_at(i), name) != 0)
        i++;
    return name ? lf_farmed_engine_at(i) : NULL;
}

static const char *kind_named(const char *name)
{
    const lf_output_kind *kind = NULL;
    return name && lf_output_kind_from_name(name, &kind, NULL) == LF_OK ? kind->name : NULL;
}

/* The folder must still be inside --export-dir, which may be another one now. */
static lf_status read_order(const lf_farmed_home *home, const char *path, const json_t *said,
                            lf_farmed_order *out, lf_error *err)
{
    const char *folder = json_string_value(json_object_get(said, "job"));
    const char *file = json_string_value(json_object_get(said, "file"));
    out->engine = engine_named(json_string_value(json_object_get(said, "engine")));
    out->kind = kind_named(json_string_value(json_object_get(said, "kind")));
    if (!folder || !file || !out->engine || !out->kind)
        return lf_error_set(err, LF_E_FORMAT, path, "is no record of a farm job; remove it");
    out->file = lf_strdup(file);
    if (!out->file)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    return lf_held_name_open(home->export_root, "--export-dir", folder, &out->folder, err);
}

lf_status lf_farmed_record_read(const lf_farmed_home *home, const char *path, lf_farmed_order *out,
                                lf_error *err)
{
    char *text = NULL;
    size_t size = 0;
    lf_status status = lf_file_read(path, NULL, MOST_BYTES, &text, &size, err);
    if (status != LF_OK)
        return status;
    json_t *said = json_loadb(text, size, 0, NULL);
    status = read_order(home, path, said, out, err);
    json_decref(said);
    lf_free(text);
    return status;
}
