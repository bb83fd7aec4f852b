#include "daemon/tools/receipt.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file_hash.h"
#include "base/version.h"
#include "daemon/tools/rendering_plate.h"

/* Adds a file to the list. */
static lf_status add_file(json_t *list, const char *name, lf_error *err)
{
    char hash[LF_HASH_TEXT];
    int64_t size = 0;
    int fd = -1;
    lf_status status = lf_file_open(name, NULL, UINT64_MAX, &fd, NULL, err);
    if (status != LF_OK)
        return status;
    const bool is_read = lf_file_hash(fd, hash, &size);
    close(fd);
    if (!is_read)
        return lf_error_set(err, LF_E_IO, name, "cannot read it back for --files");
    json_t *entry =
        json_pack("{s:s, s:I, s:s}", "name", name, "bytes", (json_int_t)size, "sha256", hash);
    return json_array_append_new(list, entry) == 0
               ? LF_OK
               : lf_error_set(err, LF_E_NOMEM, name, "out of memory");
}

/* Adds the files of the output r->path. */
static lf_status add_output(const lf_rendering *r, json_t *list, lf_error *err)
{
    const lf_output_kind *kind = lf_rendering_kind(r);
    const int n_views = r->is_quilt ? r->layout.n_views : lf_camera_views(&r->settings.camera),
              n = lf_output_n_files(kind, &r->print, n_views);
    lf_status status = LF_OK;
    for (int i = 0; i < n && status == LF_OK; i++) {
        char *name = lf_output_file_name(kind, r->path, i);
        status = name ? add_file(list, name, err)
                      : lf_error_set(err, LF_E_NOMEM, r->path, "out of memory");
        lf_free(name);
    }
    return status;
}

/* Adds the reports and the job sheet beside a print that was checked. */
static lf_status add_reports(const lf_rendering *r, json_t *list, lf_error *err)
{
    lf_status status = LF_OK;
    const char *ending;
    if (!lf_rendering_kind(r)->check_print ||
        !lf_print_check_wanted(&r->arguments->of_print.check, r->path))
        return LF_OK;
    for (int i = 0; status == LF_OK && (ending = lf_print_check_ending(i)); i++) {
        char *name = lf_path_beside(r->path, ending);
        if (!name)
            return lf_error_set(err, LF_E_NOMEM, r->path, "out of memory");
        if (access(name, F_OK) == 0)
            status = add_file(list, name, err);
        lf_free(name);
    }
    return status;
}

static lf_status add_plate(const lf_rendering *r, json_t *list, lf_error *err)
{
    lf_status status = LF_OK;
    for (int i = 0; i < lf_rendering_plate_files(r) && status == LF_OK; i++) {
        char *name = lf_rendering_plate_file(r, i);
        status = name ? add_file(list, name, err)
                      : lf_error_set(err, LF_E_NOMEM, r->path, "out of memory");
        lf_free(name);
    }
    return status;
}

static lf_status add_outputs(lf_rendering *r, json_t *list, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const bool is_one = !r->sequence.on || a->kind == &lf_output_video;
    lf_status status = LF_OK;
    if (r->sequence.plate)
        return add_plate(r, list, err);
    for (int i = a->frames.first; i <= a->frames.last && !is_one && status == LF_OK; i++) {
        status = lf_rendering_name(r, i, err);
        if (status == LF_OK)
            status = add_output(r, list, err);
        if (status == LF_OK)
            status = add_reports(r, list, err);
    }
    if (is_one)
        status = add_output(r, list, err);
    if (status == LF_OK && is_one)
        status = add_reports(r, list, err);
    if (status == LF_OK && a->stats && strcmp(a->stats, "-") != 0)
        status = add_file(list, a->stats, err);
    return status;
}

static lf_status put(const char *path, const json_t *object, lf_error *err)
{
    char *text = object ? json_dumps(object, JSON_INDENT(2)) : NULL, *lines = NULL;
    if (!text || asprintf(&lines, "%s\n", text) < 0) {
        free(text);
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    }
    const lf_status status = lf_outfile_text(path, lines, err);
    free(lines);
    free(text);
    return status;
}

lf_status lf_receipt_write(lf_rendering *r, lf_error *err)
{
    json_t *list = json_array(),
           *object = json_pack("{s:s, s:O?}", "quiltd", LF_VERSION, "files", list);
    lf_status status =
        list ? LF_OK : lf_error_set(err, LF_E_NOMEM, r->arguments->files, "out of memory");
    if (status == LF_OK)
        status = add_outputs(r, list, err);
    if (status == LF_OK)
        status = put(r->arguments->files, object, err);
    json_decref(list);
    json_decref(object);
    return status;
}
