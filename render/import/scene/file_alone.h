/* A scene around one file: what is shown where a mesh or a volume stands in a scene's place, and
 * nothing says how (docs/reference/scene-format.md, "Files without a scene"); private to render/.
 */
#ifndef LF_RENDER_FILE_ALONE_H
#define LF_RENDER_FILE_ALONE_H

#include "render/render.h"

/* Whether a path ends as the files of meshes and volumes do. */
bool lf_is_file_alone(const char *path);

/* The frame of a sequence ("smoke_%04d.vdb") whose file is the largest, since simulations begin
 * with nothing; -1: it is none. Looks for 10000 files. */
int lf_alone_frame(const char *path);

/* The document of a scene that holds the file, beneath its own folder, and the ground that it
 * stands on, in that frame. grids: names of a volume's grids of numbers, a line each. A new
 * reference; NULL = out of memory. */
json_t *lf_alone_document(const char *path, int frame, const lf_alone *how, const char *grids);

/* The file itself, of a sequence that of the frame. The caller's (lf_free); NULL = out of memory.
 */
char *lf_alone_file(const char *path, int frame);

/* Adds what shows it, by what the scene of that document has come to: a camera before it that has
 * all of it in its views, lights, a backdrop; of a volume a density and a heat that can be seen.
 * false: out of memory. */
bool lf_alone_furnish(json_t *document, const lf_alone *how, const lf_scene *scene);

#endif
