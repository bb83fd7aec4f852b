/* memory: files in memory that the gateway and quiltd hand to each other. Thread: any. */
#ifndef LF_DAEMON_WEB_MEMORY_H
#define LF_DAEMON_WEB_MEMORY_H

#include <stdint.h>

#include "base/status.h"

/* A new empty file, open for reading and writing; the caller closes it. LF_E_IO. */
LF_NODISCARD lf_status lf_memory_create(int *out_fd, lf_error *err);
/* Nobody can change the file any more. LF_E_IO. */
LF_NODISCARD lf_status lf_memory_seal(int fd, lf_error *err);
/* Opens the same file for reading only, as quiltd wants passed files to be; the caller closes it.
 * LF_E_IO. */
LF_NODISCARD lf_status lf_memory_reopen(int fd, int *out_fd, lf_error *err);
/* Size of the file in bytes; 0 also if it has none. */
uint64_t lf_memory_bytes(int fd);

#endif
