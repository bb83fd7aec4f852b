/* The file of a volume at a frame; private to render/. */
#ifndef LF_RENDER_FRAME_FILE_H
#define LF_RENDER_FRAME_FILE_H

#include "base/file.h"
#include "render/import/scene/json_reader.h"

#define LF_MAX_FRAME 999999
#define LF_FRAME_RATE 24 /* frames per second, unless the scene gives it */

/* Replacement for a missing file of a sequence between existing ones: the last existing file before
 * it, an empty volume, or an error. */
typedef enum lf_hole { LF_HOLE_HOLD, LF_HOLE_EMPTY, LF_HOLE_ERROR } lf_hole;

/* A file of a sequence. */
typedef struct lf_frame_of {
    const char *pattern; /* its name with a placeholder for the number; NULL: not a sequence */
    int number;
    int back; /* step to the previous number: 1 or -1 */
    lf_hole hole;
} lf_frame_of;

/* The name of a volume's file at a frame, from "file" and "sequence" of node: the placeholder of
 * file replaced by first + (frame - 1) step, rounded down (base/frame_name.h). A name without a
 * placeholder is used as it is; then "sequence" is an error. The caller frees it with lf_free;
 * NULL: see reader->status. */
char *lf_frame_file(lf_reader *reader, const lf_node *node, const char *file, int frame,
                    lf_frame_of *out);

/* The last existing file of a sequence before this one, relative to folder; NULL: the file itself
 * exists, or is not in a gap. The caller frees it with lf_free. */
char *lf_frame_held(const lf_frame_of *of, const char *folder, const lf_roots *roots);

#endif
