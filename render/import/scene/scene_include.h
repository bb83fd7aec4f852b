/* Scene files, and those that they include; private to render/. */
#ifndef LF_RENDER_SCENE_INCLUDE_H
#define LF_RENDER_SCENE_INCLUDE_H

#include "base/paths.h"
#include "render/import/scene/json_reader.h"

/* Of a file, of all that are included, and of a scene's document (lf_json_least_bytes). */
#define LF_SCENE_MAX_BYTES ((uint64_t)16 << 20)

enum { LF_MAX_INCLUDES = 64 }; /* in all, however they include each other */

/* One file. */
typedef struct lf_scene_text {
    char *path; /* as it was opened */
    char *text; /* what was read … */
    lf_json_source source;
} lf_scene_text;

/* All that a document includes, without the document. */
typedef struct lf_includes {
    int n; /* files */
    lf_scene_text file[LF_MAX_INCLUDES];
    /* the document, then the files: what comes first wins */
    lf_json_source sources[LF_MAX_INCLUDES + 1];
    json_t *merged; /* NULL: the document includes nothing */
} lf_includes;

/* Reads a JSON file of at most 16 MiB. out is released with lf_scene_text_finish, also behind an
 * error: LF_E_IO, LF_E_PATH, LF_E_NOMEM, LF_E_FORMAT with the line. */
LF_NODISCARD lf_status lf_scene_text_read(const char *path, const lf_roots *roots,
                                          lf_scene_text *out, lf_error *err);
/* Accepts one that is all zero. */
void lf_scene_text_finish(lf_scene_text *text);

/* Reads what the document of reader says with "include", and what that includes in turn, relative
 * to the folder of whoever includes it (the document's: folder) and beneath roots, and merges it
 * all: the last file first and each patched by what stands before it (RFC 7396), in the end by the
 * document. At most 16 MiB are included. Relative names of files become relative to folder. From
 * then on the reader reports errors where a value comes from; *out is finished by the caller behind
 * the last of them. Whatever is wrong is in reader->status: LF_E_FORMAT for files that include
 * themselves. */
void lf_scene_include(lf_reader *reader, const json_t *doc, const char *folder,
                      const lf_roots *roots, lf_includes *out);
/* Accepts one that is all zero. */
void lf_includes_finish(lf_includes *includes);

#endif
