/* All meshes of a scene and Embree's BVH over them, shared between scenes as long as nothing of it
 * changes; private to render/. Immutable once built. */
#ifndef LF_RENDER_GEOMETRY_H
#define LF_RENDER_GEOMETRY_H

#include <sys/stat.h>

#include "render/scene/file_camera.h"
#include "render/scene/large.h"
#include "render/scene/punctual.h"
#include "render/scene/scene.h"

/* One file that was opened for a mesh, to see later whether it changed, and to say
 * what the mesh is. */
typedef struct lf_mesh_file {
    char *path;
    struct timespec modified;
    off_t size;
    ino_t inode;
    lf_digest digest;
    int mesh; /* index into meshes */
} lf_mesh_file;

/* Of a mesh: seconds that what moves in its file takes (0: nothing does), and where it stands when
 * the shutter opens and when it closes; the same where there is none. */
typedef struct lf_mesh_motion {
    double span, moment, close;
} lf_mesh_motion;

#define LF_MATERIAL_NAME 128 /* bytes of a material's name in a file, with its end */

typedef struct lf_geometry {
    atomic_int refs;
    RTCDevice device;
    RTCScene embree;
    float offset;   /* within this distance of a surface a ray may find it on either side */
    lf_large large; /* met in double precision: Embree's geometry number n_meshes */
    int n_meshes, n_materials;
    uint32_t n_instances; /* of all meshes that stand in many (instances.h) */
    /* owner of their arrays; .material is left 0: the scene fills it in its own copy */
    lf_mesh *meshes;
    lf_mesh_motion *motions;                  /* [n_meshes] */
    lf_punctuals *lights;                     /* [n_meshes] of their files */
    lf_file_cameras *cameras;                 /* [n_meshes] */
    lf_material *materials;                   /* the files' own, which triangle_material numbers */
    int *first_material;                      /* [n_meshes + 1] where those of a mesh begin */
    char (*material_names)[LF_MATERIAL_NAME]; /* [n_materials] "": it has none */
    lf_textures *textures;                    /* [n_materials] theirs; NULL: none has any */
    int n_pictures, n_pyramids;
    lf_texels *pictures;
    lf_pyramid *pyramids;
    double origin[3];    /* what was taken off the vertices */
    double bounds[2][3]; /* world: least, greatest */
    json_t *key;         /* the JSON that shaped it */
    int n_files;
    lf_mesh_file *files;  /* everything that was read */
    lf_warnings warnings; /* of the meshes */
} lf_geometry;

/* One with room for so many meshes, none of which is there yet: what moves, lights and cameras are
 * empty, Embree's scene is not committed. key (may be NULL) gets a reference more. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_geometry_create(int most_meshes, const double origin[3], json_t *key,
                                          lf_geometry **out, lf_error *err);
lf_geometry *lf_geometry_ref(lf_geometry *geometry);
/* The path of a mesh's file; "" where it has none. */
const char *lf_geometry_file(const lf_geometry *geometry, int mesh);
/* Accepts NULL. */
void lf_geometry_unref(lf_geometry *geometry);

#endif
