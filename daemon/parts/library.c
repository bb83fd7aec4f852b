#include "daemon/parts/library.h"

#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/sandbox/import.h"
#include "base/sandbox/import_group.h"
#include "daemon/output/thumbnail.h"
#include "daemon/parts/library_list.h"
#include "daemon/threads/errands.h"

/* Of each kind, so that a slow picture delays no listing. Each thumbnail holds a picture, and its
 * reader has memory that the scene's readers lack. */
#define LISTS_AT_ONCE 4
#define THUMBNAILS_AT_ONCE 2

typedef struct request {
    lf_errand errand;
    const lf_library *library;
    void *call;
    char *path;
    int width, fd; /* of a thumbnail */
    lf_import_group group;
    json_t *result;
} request;

struct lf_library {
    lf_errands *lists, *thumbnails;
    const lf_roots *roots;
    lf_library_ended_fn ended;
    void *context;
};

lf_status lf_library_create(lf_inbox *inbox, const lf_roots *roots, lf_library_ended_fn ended,
                            void *context, lf_library **out_library)
{
    lf_library *library = lf_calloc(1, sizeof *library);
    if (!library)
        return LF_E_NOMEM;
    *library = (lf_library){NULL, NULL, roots, ended, context};
    lf_import_expect_quiet(THUMBNAILS_AT_ONCE);
    if (lf_errands_create("lf-list", LISTS_AT_ONCE, library, inbox, &library->lists) != LF_OK ||
        lf_errands_create("lf-thumbnail", THUMBNAILS_AT_ONCE, library, inbox,
                          &library->thumbnails) != LF_OK) {
        lf_library_destroy(library);
        return LF_E_NOMEM;
    }
    *out_library = library;
    return LF_OK;
}

void lf_library_destroy(lf_library *library)
{
    if (!library)
        return;
    lf_errands_destroy(library->lists);
    lf_errands_destroy(library->thumbnails);
    lf_import_expect_quiet(-THUMBNAILS_AT_ONCE);
    lf_free(library);
}

lf_status lf_library_check_room(const lf_library *library, uint64_t client, const char *method,
                                lf_error *err)
{
    const int n = lf_errands_count_of(library->lists, client) +
                  lf_errands_count_of(library->thumbnails, client);
    return n == 0
               ? LF_OK
               : lf_error_set(err, LF_E_BUSY, method,
                              "another library call of this client is open; wait for its answer");
}

/* ------------------------------------------------------------------------------- the threads -- */

/* The remedies for scenes do not help here. */
static lf_status reword(lf_status status, const char *path, lf_error *err)
{
    return status == LF_E_PATH ? lf_say_outside(path, err) : status;
}

static lf_status list(lf_errand *errand, lf_error *err)
{
    request *r = (request *)(void *)errand;
    lf_status status =
        lf_library_list_of(r->library->roots, r->path, &errand->cancel, &r->result, err);
    return reword(status, r->path, err);
}

static lf_status write_thumbnail(request *r, lf_outfile *file, lf_error *err)
{
    int width, height;
    struct stat st;
    lf_status status =
        lf_thumbnail_write(r->path, r->library->roots, r->width, file, &width, &height, err);
    if (status != LF_OK)
        return reword(status, r->path, err);
    if (fstat(file->fd, &st) != 0)
        return lf_error_set(err, LF_E_IO, "descriptor", "cannot be read back");
    r->result = json_pack("{s:i, s:i, s:I}", "width", width, "height", height, "bytes",
                          (json_int_t)st.st_size);
    return r->result ? LF_OK : lf_error_set(err, LF_E_NOMEM, r->path, "out of memory");
}

/* Its reader has memory of its own, and is no reading of the scene. */
static lf_status read_picture(request *r, lf_outfile *file, lf_error *err)
{
    lf_import_group *before = lf_import_group_begin(&r->group);
    r->group.is_quiet = true;
    lf_status status = atomic_load(&r->errand.cancel)
                           ? lf_error_set(err, LF_E_CANCELLED, r->path, "cancelled")
                           : write_thumbnail(r, file, err);
    (void)lf_import_group_enter(before);
    return status;
}

static lf_status make_thumbnail(lf_errand *errand, lf_error *err)
{
    request *r = (request *)(void *)errand;
    lf_outfile file = {.fd = -1};
    lf_status status = lf_outfile_adopt(&file, r->fd, err);
    if (status != LF_OK)
        return status;
    r->fd = -1;
    status = read_picture(r, &file, err);
    if (status == LF_OK)
        return lf_outfile_commit(&file, true, err);
    lf_outfile_abandon(&file);
    return status;
}

static void stop_reading(lf_errand *errand)
{
    lf_import_group_cancel(&((request *)(void *)errand)->group);
}

/* ------------------------------------------------------------------------------------ asking -- */

static void free_request(request *r)
{
    if (r->fd >= 0)
        close(r->fd);
    lf_free(r->path);
    lf_free(r);
}

static void on_done(void *context, lf_errand *errand)
{
    const lf_library *library = context;
    request *r = (request *)(void *)errand;
    const bool ok = errand->status == LF_OK;
    if (!ok)
        json_decref(r->result);
    library->ended(library->context, r->call, ok ? r->result : NULL, ok ? NULL : &errand->err);
    free_request(r);
}

/* Takes ownership of what; NULL: out of memory. */
static lf_status add(lf_errands *errands, request *what, const char *method, lf_error *err)
{
    lf_error why = {.what = "out of memory"};
    lf_status status = what ? lf_errands_add(errands, &what->errand, &why) : LF_E_NOMEM;
    if (status == LF_OK)
        return LF_OK;
    if (what)
        free_request(what);
    return lf_error_set(err, status, method, "%s", why.what);
}

lf_status lf_library_list(lf_library *library, uint64_t client, char *folder, void *call,
                          lf_error *err)
{
    request *r = lf_calloc(1, sizeof *r);
    if (r)
        *r = (request){.errand = {.client = client, .run = list, .done = on_done},
                       .library = library,
                       .call = call,
                       .path = folder,
                       .fd = -1};
    else
        lf_free(folder);
    return add(library->lists, r, "library.list", err);
}

lf_status lf_library_thumbnail(lf_library *library, uint64_t client, char *file, int width, int fd,
                               void *call, lf_error *err)
{
    request *r = lf_calloc(1, sizeof *r);
    if (r) {
        *r = (request){.errand = {.client = client,
                                  .run = make_thumbnail,
                                  .stop = stop_reading,
                                  .done = on_done},
                       .library = library,
                       .call = call,
                       .path = file,
                       .width = width,
                       .fd = fd};
    } else {
        lf_free(file);
        close(fd);
    }
    return add(library->thumbnails, r, "library.thumbnail", err);
}

bool lf_library_busy(const lf_library *library)
{
    return lf_errands_count(library->lists) + lf_errands_count(library->thumbnails) > 0;
}

void lf_library_end_of(lf_library *library, uint64_t client)
{
    lf_errands_end_of(library->lists, client);
    lf_errands_end_of(library->thumbnails, client);
}

void lf_library_end(lf_library *library)
{
    lf_errands_end(library->lists);
    lf_errands_end(library->thumbnails);
}
