/* Which file a volume is in a frame; private to render/. */
#ifndef LF_RENDER_FRAME_FILE_H
#define LF_RENDER_FRAME_FILE_H

#include "render/load/json_reader.h"

#define LF_MAX_FRAME 999999
#define LF_FRAME_RATE 24 /* frames a second, where a scene says no other */

/* The name of a volume's file in a frame, from what node says as "file" and "sequence": that of
 * file with the number first + (frame - 1) step, rounded down, in its place (base/frame_name.h).
 * A name without such a place is itself, and "sequence" beside it an error. Caller frees with
 * lf_free; NULL: reader->status says why. */
char *lf_frame_file(lf_reader *reader, const lf_node *node, const char *file, int frame);

#endif
