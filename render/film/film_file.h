/* A film as a file; private to render/.
 *
 *     "quiltdST", u32 version
 *     "PICT"  u8[32] what it is a picture of (lf_film.picture)
 *     "LAYO"  u32 n_views, width, height, flags, f32[3] sky
 *             flags, from bit 0 on: has_w2, native, known, delta, signed; no native without
 *             known, no delta without native
 *     "STRM"  a random stream: u64 seed, u32 number, then per row f64 n[2], u32 visits[2]
 *     "ROW "  a row that was visited: u32 row, u32 met, f64 passes, f64 n[2], u32 visits[2],
 *             f64 coarse[2], then its numbers of 32 bits as film.h has them: half 0, half 1, known
 * light "END "
 *
 * All little-endian. Each part is its name, u32 CRC-32 (zlib's) of name, size and content, u64 size
 * of the content, the content; streams ascend by seed and number, rows by number, and a film has
 * one file, whatever it was gathered from. What a picture is of goes by what the scene's files
 * hold, not by where they lie (renderer_state.c), so that films of many machines can be added. */
#ifndef LF_RENDER_FILM_FILE_H
#define LF_RENDER_FILM_FILE_H

#include "render/film/film.h"

#define LF_FILM_VERSION 7

/* cancel (may be NULL) is looked at once a row: LF_E_CANCELLED, the file is to be abandoned. */
LF_NODISCARD lf_status lf_film_write(const lf_film *film, lf_outfile *file, const lf_cancel *cancel,
                                     lf_error *err);

/* Makes *out of a file; finish it. like (may be NULL): nothing but this picture in this layout, and
 * under this sky, is wanted. *out must be zeroed or finished, and is so after failure: LF_E_IO,
 * LF_E_FORMAT (no such file, ends too early, changed), LF_E_STATE (another version, or not like),
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_film_read(int fd, const lf_film *like, lf_film *out, lf_error *err);

/* What the head of a file says, read from its start: the layout, and the seed of its first stream
 * (0: nothing has been visited). LF_E_IO, LF_E_FORMAT, LF_E_STATE (another version). */
LF_NODISCARD lf_status lf_film_look(int fd, lf_film_layout *out_layout, uint64_t *out_seed,
                                    lf_error *err);

#endif
