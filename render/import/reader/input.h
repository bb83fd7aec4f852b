/* A file read from its beginning to its end, by lines or by bytes, in a buffer that grows with its
 * longest line alone. One thread. */
#ifndef LF_RENDER_INPUT_H
#define LF_RENDER_INPUT_H

#include <stdint.h>

#include "base/status.h"

typedef struct lf_input {
    int fd; /* the caller's */
    unsigned char *buffer;
    size_t room, at, end; /* bytes from at to end are not read yet */
    uint64_t before;      /* bytes of the file in front of the buffer */
    uint64_t size;        /* of the file */
    int64_t line;         /* the number of the line that was read last, 1 is the first */
    char ends;            /* what ended the last line (base/text.h) */
    bool is_alone;        /* the CR of the first line is: no LF belongs to one */
    lf_status status;     /* LF_OK, or why there is no more */
} lf_input;

/* Begins at the first byte. Release with lf_input_close in any case. LF_E_IO; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_input_open_bytes(lf_input *in, int fd, lf_error *err);
/* Of one that turns out to be a text: on to behind its byte order mark. LF_E_FORMAT: text that is
 * not UTF-8 (base/text.h). Before anything is read. */
LF_NODISCARD lf_status lf_input_begin_text(lf_input *in, lf_error *err);
/* Both. */
LF_NODISCARD lf_status lf_input_open(lf_input *in, int fd, lf_error *err);
/* Accepts a zeroed one. */
void lf_input_close(lf_input *in);

/* The next n bytes, valid until the next call; NULL: there are fewer, or none can be read. */
const unsigned char *lf_input_bytes(lf_input *in, size_t n);
/* The first bytes of what is not read yet, which stay so: at most n, *out_n of them. */
const unsigned char *lf_input_peek(lf_input *in, size_t n, size_t *out_n);
/* Leaves n bytes out; false: there are fewer. */
bool lf_input_skip(lf_input *in, uint64_t n);
/* The next line as a text that may be written to, valid until the next call; NULL: there is none.
 * joins: one that ends in a backslash goes on in the next, unless it begins as a comment (#). */
char *lf_input_line(lf_input *in, bool joins);

/* Bytes in front of what is not read yet, and behind that. */
uint64_t lf_input_offset(const lf_input *in);
uint64_t lf_input_left(const lf_input *in);
/* Goes on elsewhere, in front of what `line` counts. */
void lf_input_seek(lf_input *in, uint64_t offset, int64_t line);
/* Says why there was no more: what was expected, and where the file ended, or what the system said.
 * Returns the status. */
lf_status lf_input_ended(const lf_input *in, const char *expected, lf_error *err);

/* Makes room for `needed` elements of `each` bytes behind *(void **)array, which is realloc's, with
 * some to spare. false: no memory, all is as it was. */
LF_NODISCARD bool lf_grow(void *array, size_t *room, size_t needed, size_t each);

#endif
