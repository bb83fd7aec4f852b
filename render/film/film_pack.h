/* Rows of large films are kept packed, without loss: most views of a pixel meet the same (a sky, an
 * opaque surface), so that a third to a half of the bytes repeats. Private to render/film/; others
 * use lf_film_open and lf_film_close (film.h).
 *
 * A row is arranged so that more of it repeats, and packed in lines of LF_PACK_LINE bytes; lines
 * that equal the one before are left out. Few rows are open at a time, in memory that all share; a
 * closed row stays there until another row needs it. */
#ifndef LF_RENDER_FILM_FILM_PACK_H
#define LF_RENDER_FILM_FILM_PACK_H

#include "render/film/film.h"

#define LF_PACK_LINE ((size_t)64)
/* Most bytes of n lines when packed. */
size_t lf_pack_most(size_t lines);
/* Packs n lines; returns the bytes written to `out`, at most lf_pack_most(lines). Both pointers
 * are aligned to 8 bytes and do not overlap. */
size_t lf_pack_lines(const unsigned char *in, size_t lines, unsigned char *out);
/* The inverse. in: of lf_pack_lines with as many lines. */
void lf_unpack_lines(const unsigned char *in, size_t lines, unsigned char *out);

/* What of a row is arranged before it is packed: W' without the bits of W, which it mostly equals,
 * and features by number in place of pixel. */
typedef struct lf_pack_planes {
    size_t pixels;
    size_t half_bytes; /* of both halves, at the start of the row */
    bool w2, features;
} lf_pack_planes;
/* Bytes of `spare`. */
size_t lf_pack_spare(const lf_pack_planes *planes);
/* Arranges a row; lf_pack_restore undoes it, and both leave the arranged features in `spare`.
 * known: they are there. */
void lf_pack_arrange(const lf_pack_planes *planes, unsigned char *row, unsigned char *spare);
void lf_pack_restore(const lf_pack_planes *planes, unsigned char *row, unsigned char *spare,
                     bool known);

/* Rows that a thread has open at most: one and its neighbours, and one more. */
#define LF_PACK_ROWS_OF_A_THREAD 4
/* Rows that have memory at once. */
static inline int lf_pack_open_rows(int n_threads)
{
    return LF_PACK_ROWS_OF_A_THREAD * (n_threads + 1);
}

lf_film_packed *lf_film_packed_create(const lf_pack_planes *planes, size_t row_bytes, int height,
                                      int n_threads);
void lf_film_packed_destroy(lf_film_packed *packed);
/* Forgets the content of all rows; none is open. */
void lf_film_packed_clear(lf_film_packed *packed);
/* Memory of an open row. */
unsigned char *lf_film_packed_row(const lf_film_packed *packed, int row);
/* Threads that it was created for. */
int lf_film_packed_threads(const lf_film_packed *packed);
void lf_film_packed_open(lf_film_packed *packed, int row);
void lf_film_packed_close(lf_film_packed *packed, int row, bool changed);

#endif
