#include "daemon/web/downloads.h"

#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/web/memory.h"
#include "daemon/web/secret.h"

#define KEPT_USEC ((uint64_t)LF_DOWNLOADS_KEPT_S * 1000000)
#define LOOK_USEC ((uint64_t)500000)

static const char where[] = "export";

struct lf_download {
    lf_download *next; /* older */
    lf_downloads *downloads;
    lf_secret id;
    int n;
    struct {
        char name[LF_DOWNLOADS_MAX_NAME + 1];
        int fd;
    } file[LF_DOWNLOADS_FILES];
    lf_download_over_fn over; /* NULL: ready */
    void *context;
    int readers;
    sd_event_source *expiry; /* of a ready one */
    bool expired;            /* while it was read */
};

struct lf_downloads {
    sd_event *event;
    uint64_t limit;
    lf_download *first;    /* the newest */
    sd_event_source *look; /* on while something is written */
};

/* --------------------------------------------------------------------------------- the store -- */

static uint64_t bytes_of(const lf_download *download)
{
    uint64_t bytes = 0;
    for (int i = 0; i < download->n; i++)
        bytes += lf_memory_bytes(download->file[i].fd);
    return bytes;
}

uint64_t lf_downloads_bytes(const lf_downloads *downloads)
{
    uint64_t bytes = 0;
    for (const lf_download *d = downloads->first; d; d = d->next)
        bytes += bytes_of(d);
    return bytes;
}

int lf_downloads_count(const lf_downloads *downloads)
{
    int n = 0;
    for (const lf_download *d = downloads->first; d; d = d->next)
        n += d->n;
    return n;
}

void lf_download_drop(lf_download *download)
{
    if (!download)
        return;
    for (lf_download **at = &download->downloads->first; *at; at = &(*at)->next) {
        if (*at != download)
            continue;
        *at = download->next;
        break;
    }
    sd_event_source_disable_unref(download->expiry);
    for (int i = 0; i < download->n; i++)
        close(download->file[i].fd);
    lf_free(download);
}

/* The oldest export that is ready and not read; NULL: none. */
static lf_download *find_oldest(const lf_downloads *downloads)
{
    lf_download *oldest = NULL;
    for (lf_download *d = downloads->first; d; d = d->next)
        if (!d->over && d->readers == 0)
            oldest = d;
    return oldest;
}

static lf_download *find_largest_unfinished(const lf_downloads *downloads)
{
    lf_download *largest = NULL;
    for (lf_download *d = downloads->first; d; d = d->next)
        if (d->over && (!largest || bytes_of(d) > bytes_of(largest)))
            largest = d;
    return largest;
}

static void keep_limit(lf_downloads *downloads)
{
    lf_download *old;
    while (lf_downloads_bytes(downloads) > downloads->limit && (old = find_oldest(downloads)))
        lf_download_drop(old);
    lf_download *large = find_largest_unfinished(downloads);
    if (large && lf_downloads_bytes(downloads) > downloads->limit)
        large->over(large->context, large);
}

static int on_look(sd_event_source *source, uint64_t usec, void *context)
{
    (void)usec;
    lf_downloads *downloads = context;
    keep_limit(downloads);
    sd_event_source_set_time_relative(source, LOOK_USEC);
    sd_event_source_set_enabled(source, find_largest_unfinished(downloads) ? SD_EVENT_ONESHOT
                                                                           : SD_EVENT_OFF);
    return 0;
}

lf_status lf_downloads_create(sd_event *event, uint64_t limit, lf_downloads **out, lf_error *err)
{
    lf_downloads *downloads = lf_calloc(1, sizeof *downloads);
    if (!downloads)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    *downloads = (lf_downloads){.event = event, .limit = limit};
    if (sd_event_add_time_relative(event, &downloads->look, CLOCK_MONOTONIC, LOOK_USEC, 0, on_look,
                                   downloads) < 0) {
        lf_free(downloads);
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    }
    sd_event_source_set_enabled(downloads->look, SD_EVENT_OFF);
    *out = downloads;
    return LF_OK;
}

void lf_downloads_destroy(lf_downloads *downloads)
{
    if (!downloads)
        return;
    while (downloads->first)
        lf_download_drop(downloads->first);
    sd_event_source_disable_unref(downloads->look);
    lf_free(downloads);
}

/* --------------------------------------------------------------------------------- an export -- */

bool lf_download_is_name(const char *name)
{
    const size_t n = strlen(name);
    return n >= 1 && n <= LF_DOWNLOADS_MAX_NAME && name[0] != '.' && name[0] != '-' &&
           strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+.") == n;
}

static lf_status check_room(lf_downloads *downloads, int n, lf_error *err)
{
    lf_download *old;
    while (lf_downloads_count(downloads) + n > LF_DOWNLOADS_MOST && (old = find_oldest(downloads)))
        lf_download_drop(old);
    if (lf_downloads_count(downloads) + n > LF_DOWNLOADS_MOST)
        return lf_error_set(err, LF_E_BUSY, where, "too many exports at once; try again later");
    return LF_OK;
}

lf_status lf_download_create(lf_downloads *downloads, const char *const names[], int n,
                             lf_download_over_fn over, void *context, lf_download **out,
                             lf_error *err)
{
    for (int i = 0; i < n; i++)
        if (!lf_download_is_name(names[i]))
            return lf_error_set(err, LF_E_ARG, "file",
                                "expects 1 to %d letters, digits, \"_\", \"-\", \"+\" and \".\"",
                                LF_DOWNLOADS_MAX_NAME);
    lf_status status = check_room(downloads, n, err);
    if (status != LF_OK)
        return status;
    lf_download *download = lf_calloc(1, sizeof *download);
    if (!download)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    *download = (lf_download){
        .downloads = downloads, .next = downloads->first, .over = over, .context = context};
    downloads->first = download;
    status = lf_secret_draw(&download->id, err);
    for (int i = 0; i < n && status == LF_OK; i++) {
        snprintf(download->file[i].name, sizeof download->file[i].name, "%s", names[i]);
        status = lf_memory_create(&download->file[i].fd, err);
        download->n += status == LF_OK;
    }
    if (status != LF_OK) {
        lf_download_drop(download);
        return status;
    }
    sd_event_source_set_time_relative(downloads->look, LOOK_USEC);
    sd_event_source_set_enabled(downloads->look, SD_EVENT_ONESHOT);
    *out = download;
    return LF_OK;
}

int lf_download_fd(const lf_download *download, int i)
{
    return i < download->n ? download->file[i].fd : -1;
}

static int on_expiry(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_download *download = context;
    if (download->readers == 0)
        lf_download_drop(download);
    else
        download->expired = true;
    return 0;
}

lf_status lf_download_finish(lf_download *download, json_t **out_files, lf_error *err)
{
    char path[sizeof LF_DOWNLOADS_PREFIX + LF_SECRET_DIGITS + 1 + LF_DOWNLOADS_MAX_NAME];
    lf_downloads *downloads = download->downloads;
    if (bytes_of(download) > downloads->limit) {
        lf_download_drop(download);
        return lf_error_set(err, LF_E_NOMEM, where, LF_DOWNLOADS_TOO_LARGE);
    }
    json_t *files = json_array();
    int n = 0;
    for (; n < download->n; n++) {
        snprintf(path, sizeof path, LF_DOWNLOADS_PREFIX "%s/%s", download->id.text,
                 download->file[n].name);
        const json_int_t bytes = (json_int_t)lf_memory_bytes(download->file[n].fd);
        if (json_array_append_new(files,
                                  json_pack("{s:s, s:I, s:s}", "name", download->file[n].name,
                                            "bytes", bytes, "path", path)) != 0)
            break;
    }
    if (n < download->n ||
        sd_event_add_time_relative(downloads->event, &download->expiry, CLOCK_MONOTONIC, KEPT_USEC,
                                   0, on_expiry, download) < 0) {
        json_decref(files);
        lf_download_drop(download);
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    }
    download->over = NULL;
    download->readers++; /* its path is told: others go before it */
    keep_limit(downloads);
    download->readers--;
    if (lf_downloads_bytes(downloads) > downloads->limit) {
        json_decref(files);
        lf_download_drop(download);
        return lf_error_set(err, LF_E_NOMEM, where, LF_DOWNLOADS_TOO_LARGE);
    }
    *out_files = files;
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- reading -- */

static bool has_file(const lf_download *download, const char *path, int *out_i)
{
    const size_t digits = strlen(download->id.text);
    if (strlen(path) <= digits || path[digits] != '/' ||
        !lf_secret_equals(&download->id, path, digits))
        return false;
    for (int i = 0; i < download->n; i++)
        if (strcmp(download->file[i].name, path + digits + 1) == 0) {
            *out_i = i;
            return true;
        }
    return false;
}

bool lf_download_open(lf_downloads *downloads, const char *path, lf_download_read *out)
{
    int i = 0;
    for (lf_download *d = downloads->first; d; d = d->next) {
        if (d->over || d->expired || !has_file(d, path, &i))
            continue;
        d->readers++;
        *out = (lf_download_read){.download = d,
                                  .fd = d->file[i].fd,
                                  .bytes = lf_memory_bytes(d->file[i].fd),
                                  .name = d->file[i].name};
        return true;
    }
    return false;
}

void lf_download_close(const lf_download_read *read)
{
    lf_download *download = read->download;
    if (--download->readers == 0 && download->expired)
        lf_download_drop(download);
}
