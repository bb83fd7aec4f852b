/* All meshes of a scene and Embree's BVH over them; private to render/. Scenes share it while none
 * of it changes. Immutable once built. */
#ifndef LF_RENDER_GEOMETRY_H
#define LF_RENDER_GEOMETRY_H

#include <sys/stat.h>

#include "render/scene/file_camera.h"
#include "render/scene/large.h"
#include "render/scene/punctual.h"
#include "render/scene/scene.h"

/* One file that was opened for a mesh. Used to detect later changes, and to identify the mesh. */
typedef struct lf_mesh_file {
    char *path;    /* or the name of an array */
    bool is_array; /* passed in memory (base/passed.h) */
    struct timespec modified;
    off_t size;
    ino_t inode;
    lf_digest digest;
    int mesh; /* index into meshes */
} lf_mesh_file;

/* Animation of a mesh: its length in seconds (0: none), and its time when the shutter opens and
 * when it closes. The last two are equal without a shutter. */
typedef struct lf_mesh_motion {
    double span, moment, close;
} lf_mesh_motion;

#define LF_MATERIAL_NAME 128 /* bytes of a material's name in a file, including its end */

typedef struct lf_geometry {
    atomic_int refs;
    RTCDevice device;
    RTCScene embree;
    float offset; /* rays that start within this distance of a surface may find it on either side */
    lf_large large; /* tested in double precision: Embree's geometry number n_meshes */
    int n_meshes, n_materials;
    uint32_t n_instances; /* of all instanced meshes (instances.h) */
    /* owner of their arrays; .material is left 0: the scene fills it in its own copy */
    lf_mesh *meshes;
    lf_mesh_motion *motions;  /* [n_meshes] */
    lf_punctuals *lights;     /* [n_meshes] lights in their files */
    lf_file_cameras *cameras; /* [n_meshes] */
    lf_material *materials;   /* the files' materials, which triangle_material numbers */
    int *first_material;      /* [n_meshes + 1] index of a mesh's first material */
    char (*material_names)[LF_MATERIAL_NAME]; /* [n_materials] "": unnamed */
    lf_textures *textures;                    /* [n_materials] their textures; NULL: no textures */
    int n_pictures, n_pyramids;
    lf_texels *pictures;
    lf_pyramid *pyramids;
    double origin[3];    /* subtracted from the vertices */
    double bounds[2][3]; /* world: minimum, maximum */
    json_t *key;         /* the JSON that defines it */
    int n_files;
    lf_mesh_file *files;  /* all files that were read */
    lf_warnings warnings; /* of the meshes */
} lf_geometry;

/* Allocates room for most_meshes meshes. There are no meshes, animations, lights and cameras yet,
 * and Embree's scene is not committed. Takes a reference to key (may be NULL). LF_E_NOMEM. */
LF_NODISCARD lf_status lf_geometry_create(int most_meshes, const double origin[3], json_t *key,
                                          lf_geometry **out, lf_error *err);
lf_geometry *lf_geometry_ref(lf_geometry *geometry);
/* The path of a mesh's file; "" for a mesh without a file. */
const char *lf_geometry_file(const lf_geometry *geometry, int mesh);
/* Accepts NULL. */
void lf_geometry_unref(lf_geometry *geometry);

#endif
