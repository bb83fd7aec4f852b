/* What quiltimport, quiltimport-vdb and quiltimport-picture are made of: readers of what comes from
 * outside, each in a process that has nothing to lose (base/sandbox/import.h). Errors name no file:
 * who asked knows it. One thread. */
#ifndef LF_BASE_READER_H
#define LF_BASE_READER_H

#include "base/sandbox/import.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where the file's name would stand in errors and warnings. */
#define LF_HERE "file"

/* What a program reads. */
typedef struct lf_import_reader {
    void (*begin)(void); /* what its libraries do before they are confined; may be NULL */
    /* The file behind fd (the caller's), into sections of parcel. LF_E_FORMAT, LF_E_NOMEM, LF_E_IO.
     */
    lf_status (*read)(const lf_import_request *request, int fd, lf_parcel_writer *parcel,
                      lf_error *err);
} lf_import_reader;

/* All that main does. Not for people: quiltd, quiltrender and quiltbench start these programs. */
int lf_reader_main(const lf_import_reader *reader);

/* Asks whoever asked for a file that the one at hand names (reader.c). On LF_OK the caller
 * owns *out_fd. LF_E_PATH, LF_E_IO, …: it is not to be had. */
LF_NODISCARD lf_status lf_ask_for_file(const char *name, int *out_fd);
/* The same of one that can be done without, as pictures can: where it is not to be had nobody hears
 * of it but by the reader's warnings. */
LF_NODISCARD lf_status lf_try_for_file(const char *name, int *out_fd);

/* Gives up the right to all but reading, writing and sending what is open already, all
 * capabilities, and more than `memory` bytes, of which a third may be of a file, and `seconds` of
 * CPU time: for good. *out_landlock: whether that helps. LF_E_IO: the system cannot hold us to
 * that.
 */
LF_NODISCARD lf_status lf_confine(uint64_t memory, unsigned seconds, lf_landlock *out_landlock,
                                  lf_error *err);

#ifdef __cplusplus
}
#endif
#endif
