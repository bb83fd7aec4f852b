/* Extensions that a glTF file uses and nobody here knows. One thread. */
#ifndef LF_RENDER_GLTF_EXTENSIONS_H
#define LF_RENDER_GLTF_EXTENSIONS_H

#include "render/import/reader/gltf_file.h"
#include "render/scene/warnings.h"

/* A warning for each: of those in extensionsUsed, and of those that something has although the file
 * does not say so; with what has it. At most 64 of them. */
void lf_gltf_warn_of_extensions(const lf_gltf *gltf, lf_warnings *warnings);

#endif
