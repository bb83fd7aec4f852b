/* ffmpeg: one of ffmpeg's programs as a child process with a pipe, a file and a place for its
 * messages. It gets no other descriptors. Its messages go to a memory file of fixed size.
 *
 * The caller must ignore SIGPIPE. Thread: one at a time. */
#ifndef LF_DAEMON_FFMPEG_H
#define LF_DAEMON_FFMPEG_H

#include <sys/types.h>

#include "base/status.h"

#define LF_FFMPEG_FILE "/dev/fd/3" /* the file, as words of its command line name it */

/* How long a child that a signal has stopped is waited for, in seconds. */
#define LF_FFMPEG_STOPPED_S 60

/* How long a child that opens a file may sleep, in seconds: disks take long to start. */
#define LF_FFMPEG_IDLE_S 20

typedef struct lf_ffmpeg {
    const char *program; /* "ffmpeg" or "ffprobe" */
    int64_t worked_ns;   /* its processor time when it was last waited for */
    pid_t pid;           /* 0: none, or it has ended */
    int pipe;            /* our end: its standard input or output; does not block */
    int said;            /* its standard error */
    int stopped_ms;      /* time spent waiting for the stopped process */
    int idle_ms;         /* time spent waiting since it has last worked */
    bool told;           /* the stop was reported */
} lf_ffmpeg;

/* The words of a command line. Too many are a programming error. */
typedef struct lf_ffmpeg_words {
    int n;
    const char *list[64]; /* ends with NULL */
} lf_ffmpeg_words;
/* Adds words up to NULL; they are borrowed. */
void lf_ffmpeg_add(lf_ffmpeg_words *words, const char *const more[]);

typedef enum lf_ffmpeg_flow { LF_FFMPEG_WRITES, LF_FFMPEG_READS } lf_ffmpeg_flow;

/* What a child that reads foreign files may use; zeroed: no limits of its own. */
typedef struct lf_ffmpeg_limits {
    bool given;
    size_t memory; /* bytes of address space */
} lf_ffmpeg_limits;

/* A child that was not started; lf_ffmpeg_end accepts it. */
#define LF_FFMPEG_NONE ((lf_ffmpeg){.pipe = -1, .said = -1})

/* Starts a program that is found in PATH. flow: it writes into our pipe, or reads from it. file
 * stays the caller's. With limits it writes no file larger than its messages, and opens few.
 * purpose completes the remedy "install the package ffmpeg, which …". LF_E_IO: it is not in PATH,
 * or cannot be started; *child is then as LF_FFMPEG_NONE. */
LF_NODISCARD lf_status lf_ffmpeg_start(const char *program, const lf_ffmpeg_words *words,
                                       lf_ffmpeg_flow flow, int file,
                                       const lf_ffmpeg_limits *limits, const char *purpose,
                                       lf_ffmpeg *child, lf_error *err);
/* To be called after waiting in vain. LF_E_TIMEOUT: a signal has stopped the child for too long.
 * However slow a machine is, a stopped program makes no progress. Only our own waiting counts, so
 * time in which this program was stopped does not. The log reports a stop once. */
LF_NODISCARD lf_status lf_ffmpeg_waited(lf_ffmpeg *child, int ms, lf_error *err);
/* The same, while it opens a file. LF_E_TIMEOUT also: it has used no processor time for so long
 * that it hangs. A slow machine is no reason. */
LF_NODISCARD lf_status lf_ffmpeg_opening(lf_ffmpeg *child, int ms, lf_error *err);
/* Whether the child has ended, without waiting; *out_status is then waitpid's. */
bool lf_ffmpeg_ended(lf_ffmpeg *child, int *out_status);
/* Waits until it has ended. stopped (may be NULL) is asked meanwhile: LF_E_CANCELLED, with where.
 * LF_E_TIMEOUT: lf_ffmpeg_waited. */
LF_NODISCARD lf_status lf_ffmpeg_await(lf_ffmpeg *child, bool (*stopped)(const void *context),
                                       const void *context, const char *where, int *out_status,
                                       lf_error *err);
/* What the child has said, as text; at most size - 1 bytes, from this offset. */
size_t lf_ffmpeg_said(const lf_ffmpeg *child, size_t offset, char *text, size_t size);
/* The first line that names an error, without its prefixes; otherwise the first line. Changes
 * text. */
const char *lf_ffmpeg_first_line(char *text);
/* Judges its end: LF_OK, or LF_E_IO with its first line. */
LF_NODISCARD lf_status lf_ffmpeg_judge(const lf_ffmpeg *child, int status, lf_error *err);
/* Ends it at once if it still runs, and closes its descriptors. */
void lf_ffmpeg_end(lf_ffmpeg *child);

#endif
