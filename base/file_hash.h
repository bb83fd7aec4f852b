/* The SHA-256 of a file. Thread safe. */
#ifndef LF_BASE_FILE_HASH_H
#define LF_BASE_FILE_HASH_H

#include <stdbool.h>
#include <stdint.h>

/* 64 hexadecimal digits and a 0. */
#define LF_HASH_TEXT 65

/* Hashes a file from its start to its end, whatever the position of the descriptor, which must be
 * readable. *out_size: its bytes. false: it cannot be read, or there is no memory. */
bool lf_file_hash(int fd, char out[static LF_HASH_TEXT], int64_t *out_size);

#endif
