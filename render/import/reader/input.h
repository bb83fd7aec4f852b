/* A file read from start to end, by lines or by bytes. The buffer grows only with the longest line.
 * One thread. */
#ifndef LF_RENDER_INPUT_H
#define LF_RENDER_INPUT_H

#include <stdint.h>

#include "base/status.h"

typedef struct lf_input {
    int fd; /* owned by the caller */
    unsigned char *buffer;
    size_t room, at, end; /* bytes from at to end are unread */
    uint64_t before;      /* bytes of the file before the buffer */
    uint64_t size;        /* of the file */
    int64_t line;         /* number of the last line read, 1 is the first */
    char ends;            /* terminator of the last line (base/text.h) */
    bool is_alone;        /* the first line ends in CR only, so no LF belongs to a CR */
    lf_status status;     /* LF_OK, or the reason why reading ended */
} lf_input;

/* Starts at the first byte. Release with lf_input_close, also after a failure. LF_E_IO; LF_E_NOMEM.
 */
LF_NODISCARD lf_status lf_input_open_bytes(lf_input *in, int fd, lf_error *err);
/* For a text file, before reading: skips its byte order mark. LF_E_FORMAT: text that is not UTF-8
 * (base/text.h). */
LF_NODISCARD lf_status lf_input_begin_text(lf_input *in, lf_error *err);
/* lf_input_open_bytes and lf_input_begin_text. */
LF_NODISCARD lf_status lf_input_open(lf_input *in, int fd, lf_error *err);
/* Accepts a zeroed struct. */
void lf_input_close(lf_input *in);

/* The next n bytes, valid until the next call; NULL: there are fewer, or a read error. */
const unsigned char *lf_input_bytes(lf_input *in, size_t n);
/* The first unread bytes, without consuming them: at most n, *out_n of them. */
const unsigned char *lf_input_peek(lf_input *in, size_t n, size_t *out_n);
/* Skips n bytes; false: there are fewer. */
bool lf_input_skip(lf_input *in, uint64_t n);
/* The next line as a writable string, valid until the next call; NULL: none left. joins: a line
 * that ends in a backslash continues in the next one, unless it begins as a comment (#). */
char *lf_input_line(lf_input *in, bool joins);

/* Number of bytes before the first unread one, and of unread bytes. */
uint64_t lf_input_offset(const lf_input *in);
uint64_t lf_input_left(const lf_input *in);
/* Continues at offset, with `line` as the number of the line before it. */
void lf_input_seek(lf_input *in, uint64_t offset, int64_t line);
/* Reports why reading ended: what was expected, and where the file ended, or the system's error.
 * Returns the status. */
lf_status lf_input_ended(const lf_input *in, const char *expected, lf_error *err);

/* Makes room for `needed` elements of `each` bytes in *(void **)array, which is realloc's, with
 * reserve. false: no memory, nothing changed. */
LF_NODISCARD bool lf_grow(void *array, size_t *room, size_t needed, size_t each);

#endif
