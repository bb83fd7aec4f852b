/* The parts of a film's file (film_file.h), read and written one by one; private to render/film/.
 *
 * heads: CRC-32 of the heads of all parts so far, from 0. The end of a file has it, so that parts
 * of other files are noticed.
 *
 * Functions read from the position of fd. Errors are about "state", for the caller to name the
 * file: LF_E_IO, LF_E_FORMAT (truncated or changed), LF_E_STATE (another version). */
#ifndef LF_RENDER_FILM_PART_H
#define LF_RENDER_FILM_PART_H

#include "render/film/film.h"

enum {
    LF_FILM_START_BYTES = 12,
    LF_FILM_HEAD_BYTES = 16, /* of a part: name, checksum, size */
    LF_FILM_ROW_BYTES = 56   /* of a row, before its numbers */
};

/* Content in two pieces: what was made for it, and memory as it lies. */
typedef struct lf_film_part {
    const char *name; /* four letters */
    unsigned char *made;
    size_t n_made;
    unsigned char *bulk;
    size_t n_bulk;
} lf_film_part;

LF_NODISCARD lf_status lf_film_part_write(lf_outfile *file, const lf_film_part *part,
                                          uint32_t *heads, lf_error *err);
void lf_film_heads_add(uint32_t *heads, const unsigned char head[LF_FILM_HEAD_BYTES]);
/* Reads the head of the next part. */
LF_NODISCARD lf_status lf_film_part_next(int fd, unsigned char head[LF_FILM_HEAD_BYTES],
                                         lf_error *err);
bool lf_film_part_is(const unsigned char head[LF_FILM_HEAD_BYTES], const char *name);
bool lf_film_part_has_size(const unsigned char head[LF_FILM_HEAD_BYTES], uint64_t size);
/* Reads the content of a part whose head has been read, and checks name, size and checksum. */
LF_NODISCARD lf_status lf_film_part_read(int fd, const unsigned char head[LF_FILM_HEAD_BYTES],
                                         const lf_film_part *part, lf_error *err);
/* Reads n bytes that no checksum covers yet. */
LF_NODISCARD lf_status lf_film_bytes_read(int fd, void *data, size_t n, lf_error *err);

/* Start, identity and layout. Reads and writes only picture, layout and sky of the film. */
LF_NODISCARD lf_status lf_film_identity_write(lf_outfile *file, const lf_film *film,
                                              uint32_t *heads, lf_error *err);
LF_NODISCARD lf_status lf_film_identity_read(int fd, lf_film *out, uint32_t *heads, lf_error *err);

/* One random stream; rows are [height]. Nothing is written of a stream without visits. */
LF_NODISCARD lf_status lf_film_stream_write(lf_outfile *file, const lf_film_stream *stream,
                                            int height, uint32_t *heads, lf_error *err);
/* Reads a stream whose part's head has been read, into out->rows [height]. Refuses counts that no
 * visits lead to. */
LF_NODISCARD lf_status lf_film_stream_read(int fd, const unsigned char head[LF_FILM_HEAD_BYTES],
                                           int height, lf_film_stream *out, lf_error *err);
/* The size of the content of a stream's part. */
size_t lf_film_stream_bytes(int height);

/* The counts of a row, before its numbers. */
void lf_film_row_put(uint32_t number, const lf_film_row *row, unsigned char out[LF_FILM_ROW_BYTES]);
/* Any bytes are accepted: see lf_film_row_possible. */
lf_film_row lf_film_row_get(const unsigned char bytes[LF_FILM_ROW_BYTES], uint32_t *out_number);

LF_NODISCARD lf_status lf_film_end_write(lf_outfile *file, uint32_t heads, lf_error *err);
/* Reads the end, whose head has been read and is not in `heads`; nothing may follow it. */
LF_NODISCARD lf_status lf_film_end_read(int fd, const unsigned char head[LF_FILM_HEAD_BYTES],
                                        uint32_t heads, lf_error *err);

#endif
