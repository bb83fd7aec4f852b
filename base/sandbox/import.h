/* Reading external files in a sandboxed process.
 *
 * Libraries that read meshes, volumes and pictures may crash, hang or exhaust memory on damaged or
 * malicious files. They run in a separate process per file, the reader (base/sandbox/reader.h). It
 * has only a socket (SOCK_SEQPACKET) as descriptor LF_IMPORT_SOCKET, and the file. It requests the
 * files that its file names, and gets descriptors if the paths rule allows. At the end it hands
 * over a parcel or an error. It has limits of memory and time, cannot create files, connections or
 * processes (base/sandbox/confine.c), and ends when the asker ends.
 *
 *     asker                         reader
 *     lf_import_request, fd   ->
 *                             <-    lf_import_reply {OPEN or TRY, name}  any number of times
 *     lf_import_answer (, fd) ->
 *                             <-    lf_import_reply {DONE}, memfd        or {FAILED, status, what}
 */
#ifndef LF_BASE_IMPORT_H
#define LF_BASE_IMPORT_H

#include <limits.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#include "base/sandbox/parcel.h"

/* Default time limit of reading. */
#define LF_IMPORT_SECONDS 120

/* Sets the limits of reading, for the whole process. memory: bytes for all files that are read at
 * once; 0: half of the memory of the machine or of the process's cgroup. seconds: for all files of
 * one scene (import_group.h). Thread: any. */
void lf_import_limit(uint64_t memory, int seconds);
/* Announces that `more` additional files will be read at once, besides the one that may always be
 * read; negative: fewer. Each reader first gets its share of the memory, then, if it needs more,
 * all of it, alone. Thread: any. */
void lf_import_expect(int more);
/* Announces that quiet groups (import_group.h) may read `more` files at once; negative: fewer. From
 * then on each of them has an eighth of the memory, at most 1 GiB, which other readers never have;
 * if that is too little for a reader, it runs alone. Thread: any. */
void lf_import_expect_quiet(int more);
/* For the end of the program: reading in progress ends within a tenth of a second, and new reading
 * fails: LF_E_CANCELLED. Signal handlers may call it. Thread: any. */
void lf_import_stop(void);
/* A file that is being read. */
typedef struct lf_import_progress {
    const char *path;
    uint64_t bytes; /* size of the file */
    double seconds; /* time taken so far */
    bool ended;     /* the last report about it, successful or not */
} lf_import_progress;

/* Called on the thread that waits for a reader: when it begins, about 20 times a second, and at the
 * end. Several files may be read at once. It must not block. */
typedef void (*lf_import_watch_fn)(void *context, const lf_import_progress *progress);
/* Sets the callback of the whole process, while nothing is being read; watch NULL: none. */
void lf_import_watch(lf_import_watch_fn watch, void *context);

/* The limits. */
uint64_t lf_import_memory(void); /* for all files that are read at once */
unsigned lf_import_seconds(void);
/* True if lf_import_stop was called, or the reading of this thread was cancelled (import_group.h).
 * For long loops. */
bool lf_import_is_stopped(void);

#define LF_IMPORT_SOCKET 3
#define LF_IMPORT_VERSION UINT32_C(10)
/* minimum of a reader: OpenVDB needs 128 MB to start */
#define LF_IMPORT_LEAST_MEMORY ((uint64_t)192 << 20)
#define LF_IMPORT_MAX_NAME 256
#define LF_IMPORT_MAX_FILES 64 /* open at once in a reader */

typedef enum lf_import_kind {
    LF_IMPORT_MESH,
    LF_IMPORT_GRID,
    LF_IMPORT_PICTURE,
    LF_IMPORT_INSTANCES, /* the transforms of an instanced mesh */
    LF_IMPORT_TEXTURE    /* a texture with alpha (base/image_rgba.h) */
} lf_import_kind;

typedef struct lf_import_request {
    uint32_t version, kind;
    int64_t asker;    /* process of the asker */
    uint64_t memory;  /* memory limit of the reader, bytes */
    uint32_t seconds; /* CPU time left, at least 1 */
    /* for a mesh */
    uint32_t normals;                   /* lf_normals (render/render.h) */
    uint32_t materials;                 /* 1: use the file's materials */
    uint32_t emits;                     /* 1: it is a light, so no part of it is returned as
                                         * instances */
    uint32_t wants_uvs, wants_tangents; /* lf_mesh_wants (render/import/scene/scene_parse.h) */
    /* its arrays instead of a file: 1 << lf_mesh_array of each; the reader gets the positions, and
     * asks for the others by their keys */
    uint32_t arrays;
    double transform[12];
    /* animation by name, or ("") by number; play once or loop; seconds since its start */
    char clip[LF_IMPORT_MAX_NAME];
    uint32_t clip_number, clip_chosen, once;
    double seconds_in;
    char variant[LF_IMPORT_MAX_NAME]; /* material variant; "": the default */
    /* for a picture: 1: return linear floats, whatever the file holds */
    uint32_t floats;
    /* for a picture of bytes: 1: white shows through its transparent parts */
    uint32_t on_white;
    /* for a grid: 1: velocities, which may be negative */
    uint32_t is_velocity;
    uint32_t lists; /* 1: return only the names of its numeric grids */
    char grid[LF_IMPORT_MAX_NAME];
    char path[PATH_MAX]; /* name of the file, to which names in it are relative */
} lf_import_request;

/* Whether the kernel's Landlock denies all file access to readers, in addition to seccomp. */
typedef enum lf_landlock {
    LF_LANDLOCK_UNKNOWN, /* no file was read yet */
    LF_LANDLOCK_ON,
    LF_LANDLOCK_OFF,     /* not in this kernel */
    LF_LANDLOCK_REFUSED, /* in the kernel, but forbidden */
    LF_N_LANDLOCK
} lf_landlock;
/* State of the last reader, as it reported, and the state's name. A refusal is logged once. Thread:
 * any. */
lf_landlock lf_import_landlock(void);
const char *lf_landlock_name(lf_landlock which);

typedef enum lf_import_step {
    LF_IMPORT_OPEN,
    LF_IMPORT_TRY, /* like OPEN, for an optional file: the reader reports a missing one */
    LF_IMPORT_DONE,
    LF_IMPORT_FAILED
} lf_import_step;

typedef struct lf_import_reply {
    uint32_t step;
    int32_t status;      /* FAILED: lf_status */
    uint32_t landlock;   /* DONE, FAILED: lf_landlock */
    char text[PATH_MAX]; /* OPEN, TRY: a name; FAILED: the error text */
} lf_import_reply;

typedef struct lf_import_answer {
    int32_t status; /* LF_OK: a descriptor comes with it */
} lf_import_answer;

/* Sends a message, and fd with it unless it is negative. Never waits: each side has at most one
 * message to answer. LF_E_IO: the other side has ended or does not read. */
LF_NODISCARD lf_status lf_import_send(int socket, const void *message, size_t size, int fd);
/* Receives a message of exactly this size. *out_fd is the descriptor that came with it, owned by
 * the caller, otherwise -1. LF_E_IO: none, or another size. */
LF_NODISCARD lf_status lf_import_receive(int socket, void *message, size_t size, int *out_fd);

/* Opens a file that the file names, for the reader: LF_OK and a descriptor. needed: requested by
 * OPEN. */
typedef lf_status (*lf_import_open_fn)(void *context, const char *name, bool needed, int *out_fd);

/* Readers are in the program's folder, in ../libexec/quiltd, or in the folder of the environment
 * variable QUILTIMPORT.
 *
 * Runs the reader on the file behind fd; fills version and limits of request. Requests of the
 * reader are answered by open; NULL: all are refused. The file's name in messages is `where`. On
 * LF_OK the caller closes *out. Thread: any, several at once.
 *
 * Errors of the reader: LF_E_FORMAT, LF_E_NOMEM, …; LF_E_ARG: the file lacks what the request
 * names. LF_E_FORMAT is also returned if the reader ended without a reply, or if the system killed
 * it for lack of memory, which looks the same. LF_E_NOMEM, LF_E_TIMEOUT: it reached a limit.
 * LF_E_CANCELLED: lf_import_is_stopped. LF_E_IO: no reader was found, or no process could be
 * started. */
LF_NODISCARD lf_status lf_import_run(lf_import_request *request, int fd, const char *where,
                                     lf_import_open_fn open, void *context, lf_parcel *out,
                                     lf_error *err);

#ifdef __cplusplus
}
#endif
#endif
