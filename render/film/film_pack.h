/* Rows of large films are kept packed, without loss: most views of a pixel meet the same (a sky, an
 * opaque surface), so that a third to a half of the bytes repeats. Private to render/film/; others
 * use lf_film_open and lf_film_close (film.h).
 *
 * A row is packed in lines of LF_PACK_LINE bytes; lines that equal the one before are left out. Few
 * rows are open at a time, in memory that all share; a closed row stays there until another row
 * needs it. */
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

lf_film_packed *lf_film_packed_create(size_t row_bytes, int height, int n_threads);
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
