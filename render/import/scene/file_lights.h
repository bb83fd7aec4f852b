/* Lights of mesh files as lights of the scene; private to render/. */
#ifndef LF_RENDER_FILE_LIGHTS_H
#define LF_RENDER_FILE_LIGHTS_H

#include "render/import/scene/shutter.h"
#include "render/scene/geometry.h"

/* Lumens per watt, as glTF exporters convert: candela and lux in a file are this factor times the
 * radiant values. (It is the maximum, at 555 nm; files do not contain the spectra of lights.) */
#define LF_LUMENS_PER_WATT 683.0

/* The number of enabled ones: of meshes that enable them, and of meshes without the key if the
 * scene has no lights of its own; at most LF_MAX_LIGHTS. geometry may be NULL. */
int lf_file_lights_count(const lf_scene_desc *desc, const lf_geometry *geometry);
/* Appends the lights of scene->geometry to scene->lights, which must have room, with their motion
 * while the shutter is open. Spots have our falloff (light_spot.c). false = out of memory. */
bool lf_file_lights_add(const lf_shutter *shutter, lf_scene *scene);
/* Warns of lights that are disabled although the scene did not disable them. */
void lf_file_lights_warn(const lf_scene_desc *desc, lf_scene *scene);

#endif
