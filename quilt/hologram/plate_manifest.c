/* plate.json and manifest.json of a plate. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file_hash.h"
#include "quilt/hologram/plate.h"

#define MOST_JSON_BYTES ((uint64_t)1 << 30)

/* ----------------------------------------------------------------------------- what is there -- */

lf_status lf_plate_save(const char *folder, const char *name, const json_t *object, lf_error *err)
{
    char *text = object ? json_dumps(object, JSON_INDENT(1)) : NULL,
         *path = lf_path_join(folder, name);
    lf_status status = text && path ? lf_outfile_text(path, text, err)
                                    : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    free(text);
    lf_free(path);
    return status;
}

json_t *lf_plate_load(const char *folder, const char *name)
{
    char *path = lf_path_join(folder, name), *text = NULL;
    size_t size = 0;
    json_t *object = NULL;
    if (path && lf_file_read(path, NULL, MOST_JSON_BYTES, &text, &size, NULL) == LF_OK)
        object = json_loadb(text, size, 0, NULL);
    lf_free(text);
    lf_free(path);
    return object;
}

/* The first member of wanted that another object has not; NULL: none. Both have been through a
 * file, so equal numbers are equal. */
static const char *first_difference(const json_t *wanted, const json_t *there)
{
    json_t *object = (json_t *)(uintptr_t)wanted; /* jansson's iteration wants it mutable */
    const char *key = NULL;
    json_t *value = NULL;
    json_object_foreach(object, key, value)
    {
        if (!json_equal(value, json_object_get(there, key)))
            return key;
    }
    return NULL;
}

/* The same object as it is after it was in a file. Takes ownership. */
static json_t *as_in_file(json_t *object)
{
    char *text = object ? json_dumps(object, 0) : NULL;
    json_t *again = text ? json_loads(text, 0, NULL) : NULL;
    free(text);
    json_decref(object);
    return again;
}

/* What is in a folder is of this plate. A folder without plate.json must have no pictures: they
 * would be of another plate. */
static lf_status compare(const char *folder, const json_t *wanted, const char *remedy,
                         bool *out_there, lf_error *err)
{
    bool is_manifest;
    json_t *there;
    lf_status status = lf_plate_find(folder, &there, &is_manifest, err);
    const char *key = there ? first_difference(wanted, there) : NULL;
    *out_there = there;
    if (is_manifest)
        status = lf_error_set(err, LF_E_EXISTS, folder,
                              "has manifest.json of a plate without plate.json; choose another "
                              "folder, or %s",
                              remedy);
    else if (key)
        status = lf_error_set(err, LF_E_EXISTS, folder,
                              "the plate there has another \"%s\" (plate.json); choose another "
                              "folder, or %s",
                              key, remedy);
    json_decref(there);
    return status;
}

/* The new plate.json is written beside the old one first: if that fails, nothing is lost. */
static lf_status replace_plate(const char *folder, const json_t *wanted, lf_error *err)
{
    bool is_manifest;
    json_t *there;
    lf_outfile file = {.fd = -1};
    char *text = json_dumps(wanted, JSON_INDENT(1)), *path = lf_path_join(folder, "plate.json");
    lf_status status = lf_plate_find(folder, &there, &is_manifest, err);
    if (status == LF_OK)
        status = text && path ? lf_outfile_open(&file, path, true, err)
                              : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    if (status == LF_OK)
        status = lf_outfile_write(&file, text, strlen(text), err);
    if (status == LF_OK && fsync(file.fd) != 0)
        status = lf_error_set(err, LF_E_IO, path, "cannot write: %s", lf_errno_text(errno));
    if (status == LF_OK && there)
        status = lf_plate_clear(folder, there, err);
    if (status == LF_OK)
        status = lf_outfile_commit(&file, true, err);
    else
        lf_outfile_abandon(&file);
    json_decref(there);
    free(text);
    lf_free(path);
    return status;
}

lf_status lf_plate_check(const lf_plate *plate, const char *folder, const json_t *facts,
                         lf_error *err)
{
    json_t *wanted = as_in_file(lf_plate_describe(plate, facts));
    bool there;
    const lf_status status = wanted ? compare(folder, wanted, "remove this one", &there, err)
                                    : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    json_decref(wanted);
    return status;
}

lf_status lf_plate_begin(const lf_plate *plate, const char *folder, const json_t *facts,
                         bool replace, lf_error *err)
{
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return lf_error_set(err, LF_E_IO, folder, "cannot make the folder: %s",
                            lf_errno_text(errno));
    json_t *wanted = as_in_file(lf_plate_describe(plate, facts));
    bool there = replace;
    lf_status status = wanted ? LF_OK : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    if (status == LF_OK)
        status =
            replace ? replace_plate(folder, wanted, err)
                    : compare(folder, wanted, "use --overwrite without --camera-rows", &there, err);
    if (status == LF_OK && !there)
        status = lf_plate_save(folder, "plate.json", wanted, err);
    json_decref(wanted);
    return status;
}

/* ------------------------------------------------------------------------------------- files -- */

static lf_status hash_file(const char *path, char out[static LF_HASH_TEXT], int64_t *out_size,
                           lf_error *err)
{
    int fd;
    const lf_status status = lf_file_open(path, NULL, UINT64_MAX, &fd, NULL, err);
    if (status != LF_OK)
        return status;
    const bool is_read = lf_file_hash(fd, out, out_size);
    close(fd);
    return is_read ? LF_OK : lf_error_set(err, LF_E_IO, path, "cannot read it for the manifest");
}

lf_status lf_plate_add_file(const char *folder, const char *name, const char *sha256, json_t *files,
                            lf_error *err)
{
    char hash[LF_HASH_TEXT];
    int64_t size = 0;
    char *path = lf_path_join(folder, name);
    lf_status status = path ? hash_file(path, hash, &size, err)
                            : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    if (status == LF_OK && sha256 && strcmp(sha256, hash) != 0)
        status = lf_error_set(err, LF_E_FORMAT, path,
                              "was changed after it was rendered; remove it and run the command "
                              "again");
    if (status == LF_OK &&
        json_array_append_new(files, json_pack("{s:s, s:I, s:s}", "name", name, "bytes",
                                               (json_int_t)size, "sha256", hash)) != 0)
        status = lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    lf_free(path);
    return status;
}

static lf_status add_file(const lf_plate *plate, const char *folder, int i, const json_t *hashes,
                          json_t *files, lf_error *err)
{
    char *name = lf_plate_file(plate, i);
    const lf_status status =
        name ? lf_plate_add_file(folder, name, json_string_value(json_object_get(hashes, name)),
                                 files, err)
             : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    lf_free(name);
    return status;
}

lf_status lf_plate_manifest_write(const lf_plate *plate, const char *folder, const json_t *facts,
                                  const json_t *hashes, const lf_plate_run *run, lf_error *err)
{
    json_t *made = lf_plate_describe(plate, facts), *files = json_array();
    lf_status status = LF_OK;
    for (int i = 0; i < lf_plate_n_files(plate) && status == LF_OK; i++)
        status = run->cancel && atomic_load_explicit(run->cancel, memory_order_relaxed)
                     ? lf_error_set(err, LF_E_CANCELLED, folder, "cancelled")
                     : add_file(plate, folder, i, hashes, files, err);
    if (made && (json_object_set(made, "files", files) != 0 ||
                 json_object_set_new(made, "missing", json_array()) != 0))
        status = lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    if (status == LF_OK)
        status = lf_plate_save(folder, "manifest.json", made, err);
    json_decref(files);
    json_decref(made);
    return status;
}

bool lf_plate_is_file(const char *folder, const json_t *file)
{
    const char *name = json_string_value(json_object_get(file, "name"));
    char *path = name ? lf_path_join(folder, name) : NULL;
    struct stat facts;
    const bool there = path && stat(path, &facts) == 0 &&
                       facts.st_size == json_integer_value(json_object_get(file, "bytes"));
    lf_free(path);
    return there;
}

bool lf_plate_is_finished(const lf_plate *plate, const char *folder, const json_t *facts)
{
    json_t *there = lf_plate_load(folder, "manifest.json"),
           *wanted = there ? as_in_file(lf_plate_describe(plate, facts)) : NULL;
    const json_t *files = json_object_get(there, "files");
    bool is_finished = wanted && !first_difference(wanted, there) &&
                       json_array_size(files) == (size_t)lf_plate_n_files(plate);
    for (size_t i = 0; is_finished && i < json_array_size(files); i++)
        is_finished = lf_plate_is_file(folder, json_array_get(files, i));
    json_decref(wanted);
    json_decref(there);
    return is_finished;
}
