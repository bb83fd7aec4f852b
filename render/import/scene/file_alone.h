/* A scene for one file: used if a mesh or a volume is given instead of a scene
 * (docs/reference/scene-format.md, "Files without a scene"); private to render/. */
#ifndef LF_RENDER_FILE_ALONE_H
#define LF_RENDER_FILE_ALONE_H

#include "render/render.h"

/* Whether a path has the ending of a mesh or volume file. */
bool lf_is_file_alone(const char *path);

/* The frame of a sequence ("smoke_%04d.vdb") with the largest file, because simulations start
 * empty; -1: not a sequence. Searches 10000 files. */
int lf_alone_frame(const char *path);

/* The document of a scene with the file, relative to its own folder, and a ground below it, at that
 * frame. grids: names of a volume's number grids, one per line. A new reference; NULL = out of
 * memory. */
json_t *lf_alone_document(const char *path, int frame, const lf_alone *how, const char *grids);

/* The path of the file; for a sequence the path at the frame. The caller frees it (lf_free); NULL =
 * out of memory. */
char *lf_alone_file(const char *path, int frame);

/* Adds a camera that has the whole file in its views, lights and a backdrop, and for a volume a
 * visible density and temperature. Uses the scene made of that document. false: out of memory. */
bool lf_alone_furnish(json_t *document, const lf_alone *how, const lf_scene *scene);

#endif
