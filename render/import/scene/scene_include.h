/* Scene files and their includes; private to render/. */
#ifndef LF_RENDER_SCENE_INCLUDE_H
#define LF_RENDER_SCENE_INCLUDE_H

#include "base/paths.h"
#include "render/import/scene/json_reader.h"

/* Limit for a file, for all includes together, and for a scene's document (lf_json_least_bytes). */
#define LF_SCENE_MAX_BYTES ((uint64_t)16 << 20)

enum { LF_MAX_INCLUDES = 64 }; /* in all, at any depth */

/* One file. */
typedef struct lf_scene_text {
    char *path; /* as opened */
    char *text; /* its content … */
    lf_json_source source;
} lf_scene_text;

/* All includes of a document, without the document itself. */
typedef struct lf_includes {
    int n; /* files */
    lf_scene_text file[LF_MAX_INCLUDES];
    /* the document, then the files: earlier ones win */
    lf_json_source sources[LF_MAX_INCLUDES + 1];
    json_t *merged; /* NULL: the document has no include */
} lf_includes;

/* Reads a JSON file of at most 16 MiB. Release out with lf_scene_text_finish, also after a failure:
 * LF_E_IO, LF_E_PATH, LF_E_NOMEM, LF_E_FORMAT with the line. */
LF_NODISCARD lf_status lf_scene_text_read(const char *path, const lf_roots *roots,
                                          lf_scene_text *out, lf_error *err);
/* Accepts a zeroed struct. */
void lf_scene_text_finish(lf_scene_text *text);

/* Reads the includes of the reader's document, and their includes, and merges them: the last file
 * first, each patched by the one before it (RFC 7396), finally by the document. Names are relative
 * to the folder of the including file (the document's: folder) and below roots. At most 16 MiB are
 * included. Relative file names become relative to folder. Afterwards the reader reports errors at
 * a value's origin. The caller finishes *out after the last error report. Errors are in
 * reader->status: LF_E_FORMAT for files that include themselves. */
void lf_scene_include(lf_reader *reader, const json_t *doc, const char *folder,
                      const lf_roots *roots, lf_includes *out);
/* Accepts a zeroed struct. */
void lf_includes_finish(lf_includes *includes);

#endif
