/* downloads: files in memory that quiltd writes exports into, and that browsers fetch later.
 *
 * An export is being written by quiltd, then ready, then gone. All files together have limits of
 * number and bytes. quiltd decides how much it writes, so the sizes are looked at twice a second:
 * above the limit the oldest ready exports go, then whoever asked for the largest unfinished one is
 * told. A ready export is dropped after LF_DOWNLOADS_KEPT_S, and none while it is read.
 * Thread: event. */
#ifndef LF_DAEMON_WEB_DOWNLOADS_H
#define LF_DAEMON_WEB_DOWNLOADS_H

#include <jansson.h>
#include <stdint.h>
#include <systemd/sd-event.h>

#include "base/status.h"

#define LF_DOWNLOADS_MOST 16 /* files */
#define LF_DOWNLOADS_LIMIT ((uint64_t)1 << 30)
#define LF_DOWNLOADS_KEPT_S 600
#define LF_DOWNLOADS_FILES 2 /* of an export */
#define LF_DOWNLOADS_MAX_NAME 100
#define LF_DOWNLOADS_TOO_LARGE                                                                     \
    "the files are larger than quiltweb's memory for exports; use quiltctl export"
/* GET LF_DOWNLOADS_PREFIX ID/NAME */
#define LF_DOWNLOADS_PREFIX "/api/download/"

typedef struct lf_downloads lf_downloads;
typedef struct lf_download lf_download; /* the files of one export */

/* limit: bytes of all files. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_downloads_create(sd_event *event, uint64_t limit, lf_downloads **out,
                                           lf_error *err);
/* To be called when nobody writes or reads any more. Accepts NULL. */
void lf_downloads_destroy(lf_downloads *downloads);
/* Bytes and number of all files, as of the last look. */
uint64_t lf_downloads_bytes(const lf_downloads *downloads);
int lf_downloads_count(const lf_downloads *downloads);

/* True for a name of 1 to LF_DOWNLOADS_MAX_NAME letters, digits, "_", "-", "+" and ".", which does
 * not begin with "." or "-". */
bool lf_download_is_name(const char *name);

/* The export has grown too large and must be ended (lf_download_drop). Called from the event loop,
 * until the export is ready. */
typedef void (*lf_download_over_fn)(void *context, lf_download *download);

/* New empty files with these names. LF_E_ARG: a name is none; LF_E_BUSY: all exports that are there
 * are written or read; LF_E_IO; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_download_create(lf_downloads *downloads, const char *const names[], int n,
                                          lf_download_over_fn over, void *context,
                                          lf_download **out, lf_error *err);
/* The file to be written; -1 after the last. It stays the download's. */
int lf_download_fd(const lf_download *download, int i);
/* quiltd has written the files: the store owns the export now. *out_files: an array of {name,
 * bytes, path}, a new reference. LF_E_NOMEM, also if it finds no room because of
 * others that are read: the export is dropped. */
LF_NODISCARD lf_status lf_download_finish(lf_download *download, json_t **out_files, lf_error *err);
/* Forgets an export that is not ready. Accepts NULL. */
void lf_download_drop(lf_download *download);

/* A file that is being sent. */
typedef struct lf_download_read {
    lf_download *download;
    int fd; /* the download's */
    uint64_t bytes;
    const char *name;
} lf_download_read;

/* Finds a file by the part of the path after LF_DOWNLOADS_PREFIX, and keeps it until
 * lf_download_close. False: no such file. */
bool lf_download_open(lf_downloads *downloads, const char *path, lf_download_read *out);
void lf_download_close(const lf_download_read *read);

#endif
