/* Images that a mesh file names, with their use and mapping. One thread. */
#ifndef LF_RENDER_MAPS_H
#define LF_RENDER_MAPS_H

#include "render/import/reader/source_material.h"

typedef enum lf_map_use {
    LF_MAP_BASE,
    LF_MAP_EMISSION,
    LF_MAP_NORMAL,
    /* heights; if the image is not grey it is a normal map, as many programs write it */
    LF_MAP_BUMP,
    LF_MAP_COVER,
    LF_MAP_USES
} lf_map_use;

typedef struct lf_map {
    unsigned source; /* index of the material */
    lf_map_use use;
    char *path;   /* path of the image … */
    char *beside; /* … or an alternative: in the folder of the file that names it; both owned */
    lf_texture texture; /* its mapping, without an image */
} lf_map;

/* Starts a map of this name, relative to folder, with the default mapping and v pointing up (the
 * first row of an image is the top). Release with lf_map_finish. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_map_begin(unsigned source, lf_map_use use, const char *folder,
                                    const char *name, lf_map *out, lf_error *err);
/* Accepts a zeroed struct; leaves it zeroed. */
void lf_map_finish(lf_map *map);

/* Decodes the image in a file, from its first byte on. LF_E_IO, LF_E_FORMAT: the reason;
 * LF_E_NOMEM. The caller releases *out. */
LF_NODISCARD lf_status lf_map_decode(int fd, lf_texels *out, lf_error *err);

/* Requests the images of used materials and reads them into out->pictures, each file once. It
 * changes source[n] accordingly: textures, cover, and black colours next to an image. For each
 * material, an image that is not accessible or not an image is a warning in out->warnings, and only
 * the material's colour counts. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_maps_read(const lf_map *maps, size_t n_maps, lf_source_material *source,
                                    const bool *used, lf_mesh_data *out, lf_error *err);
/* Replaces lf_maps_read if the mesh has no texture coordinates: warns, and disables emission by
 * textures. */
void lf_maps_drop(const lf_map *maps, size_t n_maps, lf_source_material *source, const bool *used,
                  lf_warnings *warnings);

#endif
