/* Lights of mesh files as lights of the scene; private to render/. */
#ifndef LF_RENDER_FILE_LIGHTS_H
#define LF_RENDER_FILE_LIGHTS_H

#include "render/import/scene/shutter.h"
#include "render/scene/geometry.h"

/* Lumens of a watt, as glTF's exporters count them: candela and lux of a file are so many times
 * what they shine in watts. (The most that a watt can have, at 555 nm; the lamps' own spectra are
 * not told.) */
#define LF_LUMENS_PER_WATT 683.0

/* How many of them shine: those of meshes that say so, and of meshes that say nothing where the
 * scene has no lights of its own; at most LF_MAX_LIGHTS. geometry may be NULL. */
int lf_file_lights_count(const lf_scene_desc *desc, const lf_geometry *geometry);
/* Appends those of scene->geometry to scene->lights, which has room for them; their ways, where
 * what moves in the files moves while the shutter is open. Spots fall off as ours do
 * (light_spot.c). false = out of memory. */
bool lf_file_lights_add(const lf_shutter *shutter, lf_scene *scene);
/* Of those that do not shine although nobody said so. */
void lf_file_lights_warn(const lf_scene_desc *desc, lf_scene *scene);

#endif
