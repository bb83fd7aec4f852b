/* A scene around one file: what is shown where a mesh or a volume stands in a scene's place, and
 * nothing says how; private to render/. */
#ifndef LF_RENDER_BARE_FILE_H
#define LF_RENDER_BARE_FILE_H

#include "render/render.h"

/* Whether a path ends as the files of meshes and volumes do. */
bool lf_is_bare_file(const char *path);

/* The document of a scene that holds the file, beneath its own folder, and nothing else;
 * of a sequence ("smoke_%04d.vdb") in the frame whose file is the largest, since simulations begin
 * with nothing. A new reference; NULL = out of memory. */
json_t *lf_bare_document(const char *path);

/* Adds what shows it, by what the scene of that document has come to: a camera before it that has
 * all of it in its views, lights, a backdrop; of a volume a density that can be
 * seen. false: out of memory. */
bool lf_bare_furnish(json_t *document, const lf_scene *scene);

#endif
