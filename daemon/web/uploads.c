#include "daemon/web/uploads.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "daemon/web/memory.h"
#include "daemon/web/secret.h"

#define PREFIX "/upload/"
#define KEPT_USEC ((uint64_t)LF_UPLOADS_KEPT_S * 1000000)

static const char where[] = "upload";

struct lf_upload {
    lf_upload *next;
    lf_uploads *uploads;
    int writer;          /* -1: the body is complete */
    int reader;          /* -1: it is not */
    uint64_t size, used; /* announced; received */
    char *path;          /* NULL: it does not wait yet */
    sd_event_source *expiry;
};

struct lf_uploads {
    sd_event *event;
    uint64_t limit, bytes;
    lf_upload *first;
};

lf_status lf_uploads_create(sd_event *event, uint64_t limit, lf_uploads **out, lf_error *err)
{
    lf_uploads *uploads = lf_calloc(1, sizeof *uploads);
    if (!uploads)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    *uploads = (lf_uploads){.event = event, .limit = limit};
    *out = uploads;
    return LF_OK;
}

void lf_uploads_destroy(lf_uploads *uploads)
{
    while (uploads && uploads->first)
        lf_upload_drop(uploads->first);
    lf_free(uploads);
}

uint64_t lf_uploads_bytes(const lf_uploads *uploads)
{
    return uploads->bytes;
}

int lf_uploads_count(const lf_uploads *uploads)
{
    int n = 0;
    for (const lf_upload *u = uploads->first; u; u = u->next)
        n++;
    return n;
}

/* ------------------------------------------------------------------------------------ a body -- */

static lf_status check_room(const lf_uploads *uploads, uint64_t size, lf_error *err)
{
    int n = 0, receiving = 0;
    for (const lf_upload *u = uploads->first; u; u = u->next) {
        n++;
        receiving += u->writer >= 0;
    }
    if (receiving >= LF_UPLOADS_AT_ONCE || n >= LF_UPLOADS_MOST)
        return lf_error_set(err, LF_E_BUSY, where, "too many uploads; try again later");
    if (size > uploads->limit || uploads->bytes > uploads->limit - size)
        return lf_error_set(err, LF_E_BUSY, where,
                            "the uploads that wait leave no room for %llu bytes; use them first",
                            (unsigned long long)size);
    return LF_OK;
}

lf_status lf_uploads_begin(lf_uploads *uploads, uint64_t size, lf_upload **out, lf_error *err)
{
    lf_status status = check_room(uploads, size, err);
    if (status != LF_OK)
        return status;
    lf_upload *upload = lf_calloc(1, sizeof *upload);
    if (!upload)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    *upload = (lf_upload){.uploads = uploads, .writer = -1, .reader = -1, .size = size};
    status = lf_memory_create(&upload->writer, err);
    if (status != LF_OK) {
        lf_free(upload);
        return status;
    }
    upload->next = uploads->first;
    uploads->first = upload;
    uploads->bytes += size;
    *out = upload;
    return LF_OK;
}

lf_status lf_upload_append(lf_upload *upload, const void *data, size_t n, lf_error *err)
{
    if (n > upload->size - upload->used)
        return lf_error_set(err, LF_E_ARG, where, "the body is longer than announced");
    for (size_t done = 0; done < n;) {
        ssize_t more = write(upload->writer, (const char *)data + done, n - done);
        if (more <= 0)
            return lf_error_set(err, LF_E_IO, where, "cannot keep the body: %s",
                                lf_errno_text(errno));
        done += (size_t)more;
    }
    upload->used += n;
    return LF_OK;
}

/* Seals the body. */
static lf_status complete(lf_upload *upload, lf_error *err)
{
    if (upload->reader >= 0)
        return LF_OK;
    if (upload->used != upload->size)
        return lf_error_set(err, LF_E_ARG, where, "the body is shorter than announced");
    lf_status status = lf_memory_seal(upload->writer, err);
    if (status == LF_OK)
        status = lf_memory_reopen(upload->writer, &upload->reader, err);
    if (status != LF_OK)
        return status;
    close(upload->writer);
    upload->writer = -1;
    return LF_OK;
}

static lf_status copy_reader(const lf_upload *upload, int *out_fd, lf_error *err)
{
    int fd = fcntl(upload->reader, F_DUPFD_CLOEXEC, 0);
    if (fd < 0)
        return lf_error_set(err, LF_E_IO, where, "cannot pass the file: %s", lf_errno_text(errno));
    *out_fd = fd;
    return LF_OK;
}

lf_status lf_upload_open(lf_upload *upload, int *out_fd, lf_error *err)
{
    lf_status status = complete(upload, err);
    return status == LF_OK ? copy_reader(upload, out_fd, err) : status;
}

void lf_upload_drop(lf_upload *upload)
{
    if (!upload)
        return;
    for (lf_upload **at = &upload->uploads->first; *at; at = &(*at)->next) {
        if (*at != upload)
            continue;
        *at = upload->next;
        break;
    }
    upload->uploads->bytes -= upload->size;
    sd_event_source_disable_unref(upload->expiry);
    if (upload->writer >= 0)
        close(upload->writer);
    if (upload->reader >= 0)
        close(upload->reader);
    lf_free(upload->path);
    lf_free(upload);
}

/* ------------------------------------------------------------------------------------- names -- */

static lf_upload *find(const lf_uploads *uploads, const char *path)
{
    for (lf_upload *u = uploads->first; u; u = u->next)
        if (u->path && strcmp(u->path, path) == 0)
            return u;
    return NULL;
}

static bool is_name(const char *name)
{
    const size_t n = strlen(name);
    json_t *text = json_stringn(name, n); /* NULL: not UTF-8 */
    json_decref(text);
    if (!text || n < 1 || n > LF_UPLOADS_MAX_NAME)
        return false;
    for (size_t i = 0; i < n; i++)
        if ((unsigned char)name[i] < ' ' || name[i] == 0x7f)
            return false;
    for (const char *part = name; part; part = strchr(part, '/')) {
        part += part != name;
        const size_t length = strcspn(part, "/");
        if (length == 0 || (length == 1 && part[0] == '.') ||
            (length == 2 && part[0] == '.' && part[1] == '.'))
            return false;
    }
    return true;
}

/* "/upload/ID/NAME". */
static bool write_path(const char *folder, const char *name, char *out, size_t size)
{
    return (size_t)snprintf(out, size, PREFIX "%s/%s", folder, name) < size;
}

enum { MAX_PATH_BYTES = sizeof PREFIX + LF_UPLOADS_FOLDER + 1 + LF_UPLOADS_MAX_NAME };

lf_status lf_uploads_check_name(const lf_uploads *uploads, const char *folder, const char *name,
                                lf_error *err)
{
    char path[MAX_PATH_BYTES];
    if (!is_name(name))
        return lf_error_set(err, LF_E_ARG, "name",
                            "expects a file name such as a.glb or textures/a.png, without \"..\"");
    if (folder && (strlen(folder) != LF_UPLOADS_FOLDER ||
                   strspn(folder, "0123456789abcdef") != LF_UPLOADS_FOLDER))
        return lf_error_set(err, LF_E_ARG, "folder", "expects the folder of another upload");
    if (folder && write_path(folder, name, path, sizeof path) && find(uploads, path))
        return lf_error_set(err, LF_E_EXISTS, path, "such an upload waits already");
    return LF_OK;
}

static int on_expiry(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_upload_drop(context);
    return 0;
}

lf_status lf_upload_keep(lf_upload *upload, const char *folder, const char *name, char *out_folder,
                         lf_error *err)
{
    lf_secret drawn;
    char path[MAX_PATH_BYTES];
    lf_status status = lf_uploads_check_name(upload->uploads, folder, name, err);
    if (status == LF_OK)
        status = complete(upload, err);
    if (status == LF_OK && !folder) {
        status = lf_secret_draw(&drawn, err);
        drawn.text[LF_UPLOADS_FOLDER] = '\0';
        folder = drawn.text;
    }
    if (status != LF_OK)
        return status;
    write_path(folder, name, path, sizeof path);
    upload->path = lf_strdup(path);
    if (!upload->path ||
        sd_event_add_time_relative(upload->uploads->event, &upload->expiry, CLOCK_MONOTONIC,
                                   KEPT_USEC, 0, on_expiry, upload) < 0)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    memcpy(out_folder, folder, LF_UPLOADS_FOLDER + 1);
    return LF_OK;
}

const char *lf_upload_path(const lf_upload *upload)
{
    return upload->path;
}

/* ------------------------------------------------------------------------------------ taking -- */

static lf_status find_all(const lf_uploads *uploads, const json_t *paths,
                          lf_upload *out[LF_UPLOADS_A_CALL], int *out_n, lf_error *err)
{
    const size_t n = json_array_size(paths);
    *out_n = 0;
    if (!json_is_array(paths) || n > LF_UPLOADS_A_CALL)
        return lf_error_set(err, LF_E_ARG, "files", "expects an array of at most %d paths",
                            LF_UPLOADS_A_CALL);
    for (size_t i = 0; i < n; i++) {
        const char *path = json_string_value(json_array_get(paths, i));
        out[i] = path ? find(uploads, path) : NULL;
        if (!out[i])
            return lf_error_set(err, LF_E_ARG, path ? path : "files",
                                "no such upload waits; send the file by PUT /api/upload first");
        for (size_t k = 0; k < i; k++)
            if (out[k] == out[i])
                return lf_error_set(err, LF_E_ARG, path, "the file stands twice in files");
        *out_n = (int)i + 1;
    }
    return LF_OK;
}

/* What was passed stays in memory and in descriptors until quiltd reads it. */
static lf_status check_passed(const lf_uploads *uploads, lf_upload *const taken[], int n,
                              const lf_uploads_passed *passed, lf_error *err)
{
    uint64_t bytes = passed->bytes;
    for (int i = 0; i < n; i++)
        bytes += taken[i]->size;
    if (passed->files + n <= LF_UPLOADS_MOST && bytes <= uploads->limit)
        return LF_OK;
    return lf_error_set(err, LF_E_BUSY, where,
                        "quiltd has not yet taken the files passed before; try again later");
}

lf_status lf_uploads_take(lf_uploads *uploads, const json_t *paths, const lf_uploads_passed *passed,
                          int out_fds[LF_UPLOADS_A_CALL], int *out_n, lf_error *err)
{
    lf_upload *taken[LF_UPLOADS_A_CALL];
    int n = 0, opened = 0;
    lf_status status = find_all(uploads, paths, taken, &n, err);
    if (status == LF_OK)
        status = check_passed(uploads, taken, n, passed, err);
    while (status == LF_OK && opened < n) {
        status = copy_reader(taken[opened], &out_fds[opened], err);
        opened += status == LF_OK;
    }
    while (status != LF_OK && opened > 0)
        close(out_fds[--opened]);
    if (status != LF_OK)
        return status;
    for (int i = 0; i < n; i++)
        lf_upload_drop(taken[i]);
    *out_n = n;
    return LF_OK;
}
