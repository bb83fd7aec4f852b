/* What stands for files that a sequence lacks; private to render/. */
#ifndef LF_RENDER_FRAME_HOLD_H
#define LF_RENDER_FRAME_HOLD_H

#include "render/import/scene/scene_parse.h"

/* Volumes whose file is not there, between others that are, get the one before it or become absent,
 * as their sequence says; a warning of desc says so. folder is what names are relative to. false:
 * out of memory. */
bool lf_hold_frames(lf_scene_desc *desc, const char *folder, const lf_roots *roots);

#endif
