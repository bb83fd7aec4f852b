/* A film as a file; private to render/.
 *
 *     "quiltdST", u32 version
 *     "PICT"  u8[32] identity of the image (lf_film.picture)
 *     "LAYO"  u32 n_views, width, height, flags, f32[3] sky
 *             flags, from bit 0 on: has_w2, native, known, delta, signed; no native without
 *             known, no delta without native
 *     "STRM"  a random stream: u64 seed, u32 number, then per row f64 n[2], u32 visits[2]
 *     "ROW "  a visited row: u32 row, u32 met, f64 passes, f64 n[2], u32 visits[2],
 *             f64 coarse[2], then its 32-bit numbers as in film.h: half 0, half 1, known light
 *     "END "  u32 CRC-32 of the heads (name, checksum, size) of all parts before it
 *
 * All little-endian. Each part is its name, u32 CRC-32 (zlib's) of name, size and content, u64 size
 * of the content, the content. Streams are sorted by seed and number, rows by number. The bytes of
 * a file do not depend on how the film was gathered. The identity depends on the content of the
 * scene's files, not on their paths (renderer_state.c), so that films of many machines can be
 * added. */
#ifndef LF_RENDER_FILM_FILE_H
#define LF_RENDER_FILM_FILE_H

#include "render/film/film.h"

#define LF_FILM_VERSION 8

/* cancel (may be NULL) is checked once per row: LF_E_CANCELLED, and the caller must abandon the
 * file. */
LF_NODISCARD lf_status lf_film_write(const lf_film *film, lf_outfile *file, const lf_cancel *cancel,
                                     lf_error *err);

/* Makes *out from a file; release it with lf_film_finish. If `like` is not NULL, only a film of
 * this image with this layout and sky is accepted. *out must be zeroed or finished, and is so after
 * a failure. Errors: LF_E_IO, LF_E_FORMAT (not a film, truncated or changed), LF_E_STATE (another
 * version, or not like), LF_E_NOMEM. */
LF_NODISCARD lf_status lf_film_read(int fd, const lf_film *like, lf_film *out, lf_error *err);

/* Reads the head of a file from its start: the layout, and the seed of its first stream (0: no
 * visits). LF_E_IO, LF_E_FORMAT, LF_E_STATE (another version). */
LF_NODISCARD lf_status lf_film_look(int fd, lf_film_layout *out_layout, uint64_t *out_seed,
                                    lf_error *err);
/* Counts the rows with visits, from the streams at the start of a file; no row is read. LF_E_IO,
 * LF_E_FORMAT, LF_E_STATE, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_film_count_rows(int fd, int *out_rows, lf_error *err);

#endif
