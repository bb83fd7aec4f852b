/* Common part of quiltimport, quiltimport-vdb and quiltimport-picture: readers of external files,
 * each in a sandboxed process (base/sandbox/import.h). Errors do not name the file: the asker knows
 * it. One thread. */
#ifndef LF_BASE_READER_H
#define LF_BASE_READER_H

#include "base/sandbox/import.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Used instead of the file's name in errors and warnings. */
#define LF_HERE "file"

/* The functions of a reader. */
typedef struct lf_import_reader {
    void (*begin)(void); /* preparation of its libraries before they are confined; may be NULL */
    /* Reads the file behind fd (the caller's) into sections of parcel. LF_E_FORMAT, LF_E_NOMEM,
     * LF_E_IO. */
    lf_status (*read)(const lf_import_request *request, int fd, lf_parcel_writer *parcel,
                      lf_error *err);
} lf_import_reader;

/* The body of main. Not for users: quiltd, quiltrender and quiltbench start these programs. */
int lf_reader_main(const lf_import_reader *reader);

/* Requests a file that the current file names from the asker (reader.c). On LF_OK the caller owns
 * *out_fd. LF_E_PATH, LF_E_IO, …: not available. */
LF_NODISCARD lf_status lf_ask_for_file(const char *name, int *out_fd);
/* Like lf_ask_for_file, for an optional file such as a texture. If it is not available, only the
 * reader's warnings report it. */
LF_NODISCARD lf_status lf_try_for_file(const char *name, int *out_fd);

/* Confines the process permanently. Only reading, writing and sending of open descriptors
 * remain, without capabilities, with at most `memory` bytes (a third of them for a file) and
 * `seconds` of CPU time. *out_landlock: whether Landlock is in force. LF_E_IO: the system cannot
 * enforce this. */
LF_NODISCARD lf_status lf_confine(uint64_t memory, unsigned seconds, lf_landlock *out_landlock,
                                  lf_error *err);

#ifdef __cplusplus
}
#endif
#endif
