/* Asking for what is in a file from outside.
 *
 * The libraries that read meshes, volumes and pictures crash, hang and eat memory on files that are
 * damaged or made to do that. They run in a process of its own, one a file, which has nothing but
 * this conversation (base/sandbox/reader.h is its other end): a socket (SOCK_SEQPACKET) as
 * descriptor LF_IMPORT_SOCKET, and the file. It asks for the files that the file names, and gets
 * descriptors if the paths rule allows; in the end it hands a parcel over, or says what is wrong.
 * It is held to limits of memory and time, may make no file, connection or process
 * (base/sandbox/confine.c), and goes when who asked goes.
 *
 *     asker                         reader
 *     lf_import_request, fd   ->
 *                             <-    lf_import_reply {OPEN or TRY, name}  as often as it likes
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

/* What reading may take where nobody says otherwise. */
#define LF_IMPORT_SECONDS 120

/* What reading may take from now on: bytes for all files that are read at once (0: half of the
 * memory that there is, of the machine or for the group that the process runs in) and seconds for
 * all files of one scene (import_group.h). Of the whole process. Thread: any. */
void lf_import_limit(uint64_t memory, int seconds);
/* So many more files will be read at once from now on, besides the one that may be anyway (below 0:
 * so many fewer): each gets its part of the memory first, and the whole, alone, where it needs
 * more. Thread: any. */
void lf_import_expect(int more);
/* At the end of the program: reading that is in progress ends within a tenth of a second, and what
 * would begin does not: LF_E_CANCELLED. Signal handlers may call it. Thread: any. */
void lf_import_stop(void);
/* A file that is being read. */
typedef struct lf_import_progress {
    const char *path;
    uint64_t bytes; /* of the file */
    double seconds; /* that it has taken */
    bool ended;     /* well or not: the last word about it */
} lf_import_progress;

/* Called on the thread that waits for a reader: when it begins, about 20 times a second, at the
 * end. Several files may be read at once. It must not wait for anything itself. */
typedef void (*lf_import_watch_fn)(void *context, const lf_import_progress *progress);
/* Of the whole process, while nothing is being read; watch NULL: nobody looks. */
void lf_import_watch(lf_import_watch_fn watch, void *context);

/* The limits. */
uint64_t lf_import_memory(void); /* of all files that are read at once */
unsigned lf_import_seconds(void);
/* Whether lf_import_stop was called, or what this thread reads was cancelled (import_group.h): for
 * loops that take long. */
bool lf_import_is_stopped(void);

#define LF_IMPORT_SOCKET 3
#define LF_IMPORT_VERSION UINT32_C(9)
#define LF_IMPORT_LEAST_MEMORY ((uint64_t)192 << 20) /* of a reader: OpenVDB starts with 128 MB */
#define LF_IMPORT_MAX_NAME 256
#define LF_IMPORT_MAX_FILES 64 /* that a reader has open at once */

typedef enum lf_import_kind {
    LF_IMPORT_MESH,
    LF_IMPORT_GRID,
    LF_IMPORT_PICTURE,
    LF_IMPORT_INSTANCES, /* where a mesh stands, of many places */
    LF_IMPORT_TEXTURE    /* a picture for surfaces, with its alpha (base/image_rgba.h) */
} lf_import_kind;

typedef struct lf_import_request {
    uint32_t version, kind;
    int64_t asker;    /* its process */
    uint64_t memory;  /* bytes that the reader may have */
    uint32_t seconds; /* of CPU time: what is left, at least 1 */
    /* of a mesh */
    uint32_t normals;                   /* lf_normals (render/render.h) */
    uint32_t materials;                 /* 1: the file's own are wanted */
    uint32_t emits;                     /* 1: it is a light: nothing of it is told as places */
    uint32_t wants_uvs, wants_tangents; /* lf_mesh_wants (render/import/scene/scene_parse.h) */
    double transform[12];
    /* which of its animations, by name or ("") by number; whether it is not repeated; seconds since
     * its beginning */
    char clip[LF_IMPORT_MAX_NAME];
    uint32_t clip_number, clip_chosen, once;
    double seconds_in;
    char variant[LF_IMPORT_MAX_NAME]; /* of its materials; "": its own look */
    /* of a picture: 1: as linear floats, whatever the file holds */
    uint32_t floats;
    /* of a grid; 1: of velocities, which are of either sign */
    uint32_t is_velocity;
    uint32_t lists; /* 1: only the names of its grids of numbers are wanted */
    char grid[LF_IMPORT_MAX_NAME];
    char path[PATH_MAX]; /* what the file is called, and names in it are relative to */
} lf_import_request;

/* Whether the kernel's Landlock keeps readers from all files, besides seccomp. */
typedef enum lf_landlock {
    LF_LANDLOCK_UNKNOWN, /* nothing was read yet */
    LF_LANDLOCK_ON,
    LF_LANDLOCK_OFF,     /* the kernel does not have it */
    LF_LANDLOCK_REFUSED, /* it has, and something forbids to use it */
    LF_N_LANDLOCK
} lf_landlock;
/* Of the reader that ended last, as it says; and its name. The log has a line when it was refused,
 * once. Thread: any. */
lf_landlock lf_import_landlock(void);
const char *lf_landlock_name(lf_landlock which);

typedef enum lf_import_step {
    LF_IMPORT_OPEN,
    LF_IMPORT_TRY, /* the same of a file that can be done without: the reader tells of it */
    LF_IMPORT_DONE,
    LF_IMPORT_FAILED
} lf_import_step;

typedef struct lf_import_reply {
    uint32_t step;
    int32_t status;      /* FAILED: lf_status */
    uint32_t landlock;   /* DONE, FAILED: lf_landlock */
    char text[PATH_MAX]; /* OPEN, TRY: a name; FAILED: what is wrong */
} lf_import_reply;

typedef struct lf_import_answer {
    int32_t status; /* LF_OK: a descriptor comes with it */
} lf_import_answer;

/* Sends a message, and with it fd unless that is below 0. Never waits: each side has one message to
 * answer at most. LF_E_IO: the other side is gone, or does not listen. */
LF_NODISCARD lf_status lf_import_send(int socket, const void *message, size_t size, int fd);
/* Takes a message of exactly this size; *out_fd is what came with it (the caller's), else -1.
 * LF_E_IO: none came, or another one. */
LF_NODISCARD lf_status lf_import_receive(int socket, void *message, size_t size, int *out_fd);

/* Opens what a file names, for the reader: LF_OK and a descriptor. needed: it asked by OPEN. */
typedef lf_status (*lf_import_open_fn)(void *context, const char *name, bool needed, int *out_fd);

/* The readers stand beside the program or in ../libexec/quiltd, or in the folder that the
 * environment's QUILTIMPORT names.
 *
 * Has the file behind fd read as request says (version and limits are filled in); open answers what
 * it asks for, NULL: nothing. On LF_OK the caller closes *out. where names the file in messages.
 * Errors: the reader's own (LF_E_FORMAT, LF_E_NOMEM, …; LF_E_ARG: the file has not got what
 * the request names); LF_E_FORMAT: it ended without a word
 * (also when the system ended it for want of memory, which is not told from that); LF_E_NOMEM,
 * LF_E_TIMEOUT: it reached a limit; LF_E_CANCELLED: lf_import_is_stopped; LF_E_IO: there is
 * no reader, or no process to be had. Thread: any, several at once. */
LF_NODISCARD lf_status lf_import_run(lf_import_request *request, int fd, const char *where,
                                     lf_import_open_fn open, void *context, lf_parcel *out,
                                     lf_error *err);

#ifdef __cplusplus
}
#endif
#endif
