/* Receipts: what a task wrote, and of which plate. */
#include <nettle/sha2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "quilt/hologram/plate.h"

/* The hash of all facts and conventions. A new reference; NULL = out of memory. */
static json_t *key_of(const lf_plate *plate, const json_t *facts)
{
    uint8_t digest[SHA256_DIGEST_SIZE];
    char hash[LF_HASH_TEXT];
    struct sha256_ctx context;
    json_t *all = lf_plate_describe(plate, facts);
    char *text = all ? json_dumps(all, JSON_COMPACT | JSON_SORT_KEYS) : NULL;
    json_decref(all);
    if (!text)
        return NULL;
    sha256_init(&context);
    sha256_update(&context, strlen(text), (const uint8_t *)text);
    sha256_digest(&context, sizeof digest, digest);
    free(text);
    for (size_t i = 0; i < sizeof digest; i++)
        snprintf(hash + 2 * i, 3, "%02x", digest[i]);
    return json_string(hash);
}

static void name_of(int task, char out[static 32])
{
    snprintf(out, 32, "rows/r%03d.json", task);
}

/* The receipt of a task if it is of this plate and lists the task's files; otherwise NULL. */
static json_t *receipt_of(const lf_plate *plate, const char *folder, const json_t *key, int task)
{
    char name[32];
    name_of(task, name);
    json_t *receipt = lf_plate_load(folder, name);
    const json_t *files = json_object_get(receipt, "files");
    const int n = lf_plate_task_files(plate);
    bool is_right = key && json_equal(json_object_get(receipt, "plate"), key) &&
                    json_array_size(files) == (size_t)n;
    for (int i = 0; i < n && is_right; i++) {
        char *wanted = lf_plate_task_file(plate, task, i);
        const char *there =
            json_string_value(json_object_get(json_array_get(files, (size_t)i), "name"));
        is_right = wanted && there && strcmp(wanted, there) == 0;
        lf_free(wanted);
    }
    if (is_right)
        return receipt;
    json_decref(receipt);
    return NULL;
}

bool lf_plate_has_task(const lf_plate *plate, const char *folder, const json_t *facts, int task)
{
    json_t *key = key_of(plate, facts), *receipt = receipt_of(plate, folder, key, task);
    const json_t *files = json_object_get(receipt, "files");
    bool there = receipt;
    for (size_t i = 0; i < json_array_size(files) && there; i++)
        there = lf_plate_is_file(folder, json_array_get(files, i));
    json_decref(receipt);
    json_decref(key);
    int fd = -1;
    if (there && !lf_plate_is_direct(plate)) {
        there = lf_plate_task_open(plate, folder, task, &fd, NULL) == LF_OK;
        if (there)
            close(fd);
    }
    return there;
}

lf_status lf_plate_receipt_remove(const char *folder, int task, lf_error *err)
{
    char name[32];
    name_of(task, name);
    return lf_plate_remove_file(folder, name, err);
}

lf_status lf_plate_receipt_write(const lf_plate *plate, const char *folder, const json_t *facts,
                                 int task, lf_error *err)
{
    char name[32];
    json_t *files = json_array(), *receipt = NULL;
    lf_status status = LF_OK;
    name_of(task, name);
    for (int i = 0; i < lf_plate_task_files(plate) && status == LF_OK; i++) {
        char *file = lf_plate_task_file(plate, task, i);
        status = file ? lf_plate_add_file(folder, file, NULL, files, err)
                      : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
        lf_free(file);
    }
    if (status == LF_OK) {
        receipt = json_pack("{s:o, s:O}", "plate", key_of(plate, facts), "files", files);
        status = lf_plate_make_folders(folder, name, err);
    }
    if (status == LF_OK)
        status = lf_plate_save(folder, name, receipt, err);
    json_decref(receipt);
    json_decref(files);
    return status;
}

/* Notes the hashes of a receipt. */
static void note(const json_t *receipt, json_t *hashes)
{
    const json_t *files = json_object_get(receipt, "files");
    for (size_t i = 0; i < json_array_size(files); i++) {
        const json_t *file = json_array_get(files, i);
        json_object_set(hashes, json_string_value(json_object_get(file, "name")),
                        json_object_get(file, "sha256"));
    }
}

lf_status lf_plate_receipts(const lf_plate *plate, const char *folder, const json_t *facts,
                            json_t **out_hashes, lf_error *err)
{
    json_t *key = key_of(plate, facts), *hashes = json_object();
    lf_status status =
        key && hashes ? LF_OK : lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    for (int task = 0; task < lf_plate_tasks(plate) && status == LF_OK; task++) {
        json_t *receipt = receipt_of(plate, folder, key, task);
        if (receipt)
            note(receipt, hashes);
        else
            status = lf_error_set(err, LF_E_FORMAT, folder,
                                  "rows/r%03d.json is missing or of another plate; run the command "
                                  "again",
                                  task);
        json_decref(receipt);
    }
    json_decref(key);
    if (status != LF_OK) {
        json_decref(hashes);
        hashes = NULL;
    }
    *out_hashes = hashes;
    return status;
}
