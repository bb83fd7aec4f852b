/* Which file a volume is in a frame; private to render/. */
#ifndef LF_RENDER_FRAME_FILE_H
#define LF_RENDER_FRAME_FILE_H

#include "base/file.h"
#include "render/import/scene/json_reader.h"

#define LF_MAX_FRAME 999999
#define LF_FRAME_RATE 24 /* frames a second, where a scene says no other */

/* What stands for a file of a sequence that is not there while one before and one behind it are:
 * the last one before it, an empty volume, or an error. */
typedef enum lf_hole { LF_HOLE_HOLD, LF_HOLE_EMPTY, LF_HOLE_ERROR } lf_hole;

/* Which file of a sequence it is. */
typedef struct lf_frame_of {
    const char *pattern; /* its name with a place for the number; NULL: it is no sequence */
    int number;
    int back; /* what leads to the number before it: 1 or -1 */
    lf_hole hole;
} lf_frame_of;

/* The name of a volume's file in a frame, from what node says as "file" and "sequence": that of
 * file with the number first + (frame - 1) step, rounded down, in its place (base/frame_name.h).
 * A name without such a place is itself, and "sequence" beside it an error. Caller frees with
 * lf_free; NULL: reader->status says why. */
char *lf_frame_file(lf_reader *reader, const lf_node *node, const char *file, int frame,
                    lf_frame_of *out);

/* The name of the file before the one of a sequence, beneath folder, that is there; NULL: the file
 * itself is there, or lies in no hole. Caller frees with lf_free. */
char *lf_frame_held(const lf_frame_of *of, const char *folder, const lf_roots *roots);

#endif
