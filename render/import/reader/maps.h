/* Pictures that a mesh file names, for what they are used, and how they lie. One thread. */
#ifndef LF_RENDER_MAPS_H
#define LF_RENDER_MAPS_H

#include "render/import/reader/source_material.h"

typedef enum lf_map_use {
    LF_MAP_BASE,
    LF_MAP_EMISSION,
    LF_MAP_NORMAL,
    LF_MAP_BUMP, /* heights; where it is no grey, normals all the same, as many programs write it */
    LF_MAP_COVER,
    LF_MAP_USES
} lf_map_use;

typedef struct lf_map {
    unsigned source; /* the number of the material */
    lf_map_use use;
    char *path;         /* where its picture is … */
    char *beside;       /* … or else may be: in the folder of whoever named it; both owned */
    lf_texture texture; /* how it lies, of no picture yet */
} lf_map;

/* A picture of this name, for a folder of whoever says it, that lies as it is with v growing
 * upwards (the first row of a picture is above). Release with lf_map_finish. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_map_begin(unsigned source, lf_map_use use, const char *folder,
                                    const char *name, lf_map *out, lf_error *err);
/* Accepts a zeroed one, and leaves it so. */
void lf_map_finish(lf_map *map);

/* The picture that a file holds, from its first byte on. LF_E_IO, LF_E_FORMAT: why it is none;
 * LF_E_NOMEM. *out: the caller's to release. */
LF_NODISCARD lf_status lf_map_decode(int fd, lf_texels *out, lf_error *err);

/* Asks for the pictures of those materials that are used, and reads them into out->pictures, each
 * file once; what said[n] says changes with it: its textures, its cover, black that stands beside a
 * picture. Of what is not to be had, or no picture, there is a warning a material in out->warnings,
 * and what stands beside it counts alone. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_maps_read(const lf_map *maps, size_t n_maps, lf_source_material *source,
                                    const bool *used, lf_mesh_data *out, lf_error *err);
/* Instead, where the mesh has no texture coordinates: a warning, and nothing glows by a picture. */
void lf_maps_drop(const lf_map *maps, size_t n_maps, lf_source_material *source, const bool *used,
                  lf_warnings *warnings);

#endif
