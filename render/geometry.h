/* All meshes of a scene and Embree's BVH over them, shared between scenes as long as nothing of it changes; private to
 * render/. Immutable once built. */
#ifndef LF_RENDER_GEOMETRY_H
#define LF_RENDER_GEOMETRY_H

#include "render/large.h"
#include "render/mesh_import.h"
#include "render/scene.h"

typedef struct lf_geometry {
    atomic_int refs;
    RTCDevice device;
    RTCScene embree;
    float offset;   /* within this distance of a surface a ray may find it on either side */
    lf_large large; /* met in double precision: Embree's geometry number n_meshes */
    int n_meshes, n_materials;
    lf_mesh *meshes;        /* owner of their arrays; .material is left 0: the scene fills it in its own copy */
    lf_material *materials; /* the files' own, which triangle_material numbers */
    double origin[3];       /* what was taken off the vertices */
    double bounds[2][3];    /* world: least, greatest */
    json_t *key;            /* the JSON that shaped it */
    int n_files;
    lf_mesh_file *files;  /* everything that was read */
    lf_warnings warnings; /* of the meshes */
} lf_geometry;

/* What decides about the meshes' shape: names, files, shapes, transforms, normals, and whether each has a material of its own
 * (which one it is does not matter). A new reference; NULL = out of memory. */
json_t *lf_geometry_key(const json_t *doc, const char *folder);

/* Whether geometry was made from the same key and its files, opened again under roots, are unchanged. */
bool lf_geometry_matches(const lf_geometry *geometry, const json_t *key, const lf_roots *roots);

/* Takes the vertices of n meshes into Embree, origin subtracted in double. data is used up (arrays are taken over, the rest
 * released by the caller); key gets a reference more. LF_E_NOMEM. On LF_OK the caller owns a reference. */
LF_NODISCARD lf_status lf_geometry_build(lf_mesh_data *data, int n, const double origin[3], json_t *key, lf_geometry **out_geometry,
                                         lf_error *err);

lf_geometry *lf_geometry_ref(lf_geometry *geometry);
/* Accepts NULL. */
void lf_geometry_unref(lf_geometry *geometry);

#endif
