/* Replacements for missing files of a sequence; private to render/. */
#ifndef LF_RENDER_FRAME_HOLD_H
#define LF_RENDER_FRAME_HOLD_H

#include "render/import/scene/scene_parse.h"

/* Volumes whose file is missing between existing files get the one before it or become absent, as
 * their sequence says; adds a warning to desc. Names are relative to folder. false: out of memory.
 */
bool lf_hold_frames(lf_scene_desc *desc, const char *folder, const lf_roots *roots);

#endif
