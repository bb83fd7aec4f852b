/* Unsupported extensions of a glTF file. One thread. */
#ifndef LF_RENDER_GLTF_EXTENSIONS_H
#define LF_RENDER_GLTF_EXTENSIONS_H

#include "render/import/reader/gltf_file.h"
#include "render/scene/warnings.h"

/* Warns of each: of those in extensionsUsed, and of those that an object has although the file does
 * not list them; names the object. At most 64 warnings. */
void lf_gltf_warn_of_extensions(const lf_gltf *gltf, lf_warnings *warnings);

#endif
