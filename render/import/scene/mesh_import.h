/* Meshes from files and simple shapes, in world coordinates; private to render/. */
#ifndef LF_RENDER_MESH_IMPORT_H
#define LF_RENDER_MESH_IMPORT_H

#include "base/file.h"
#include "base/sandbox/import.h"
#include "render/import/scene/scene_parse.h"
#include "render/scene/file_camera.h"
#include "render/scene/geometry.h"
#include "render/scene/punctual.h"

#define LF_MAX_TRIANGLES 50000000
#define LF_MESH_MAX_BYTES ((uint64_t)2 << 30)
#define LF_MAX_UV 1e6f /* for a texture coordinate, and for the numbers of a texture's map */
#define LF_MAX_PICTURES 65536
#define LF_MESH_MAX_FILES 256 /* files per mesh: material libraries, buffers, images */

/* Consecutive triangles and vertices in a mesh. */
typedef struct lf_mesh_part {
    uint32_t first_triangle, n_triangles, first_vertex, n_vertices;
} lf_mesh_part;

typedef struct lf_mesh_data {
    const char *name; /* in the scene, borrowed */
    int n_vertices, n_triangles;
    /* triangles dropped for a vertex that is not finite, or too far away */
    int n_broken;
    double *positions;   /* [n_vertices][3] world coordinates, finite */
    float *normals;      /* [n_vertices][3] unit, world; NULL = flat shading */
    uint32_t *triangles; /* [n_triangles][3] */
    /* [n_triangles] index into materials; NULL when n_materials is 0 */
    uint16_t *triangle_material;
    /* Vertex attributes, each absent unless a material needs it: */
    int n_uv_sets;  /* at most LF_UV_SETS */
    float *uvs;     /* [n_uv_sets][n_vertices][2], up to LF_MAX_UV */
    float *colours; /* [n_vertices][4] linear, 0..1: multiplies albedo and alpha */
    /* [n_vertices][4] unit, world, perpendicular to the normal; w = +-1: the bitangent is w
     * cross(normal, tangent) */
    float *tangents;
    int n_materials; /* the file's own; 0 for shapes and when desc names a material */
    lf_material *materials;
    /* [n_materials] names in the file, cut to size; NULL: unnamed */
    char (*names)[LF_MATERIAL_NAME];
    lf_texture_set *textures; /* [n_materials], or NULL: no textures */
    int n_pictures;           /* at most LF_MAX_PICTURES */
    lf_texels *pictures;      /* [n_pictures], with pixels owned by this struct */
    lf_punctuals lights;
    lf_file_cameras cameras;
    double span; /* length of the animation in seconds, up to LF_MAX_SECONDS; 0: none */
    /* Vertex data at shutter close, as above; positions NULL: static (meshes_import.h). */
    struct {
        double *positions;
        float *normals, *tangents;
    } close;
    /* Instance transforms, world to world, applied to the arrays above. n_instances 0: not
     * instanced. */
    int n_instances;
    lf_affine *places;
    /* Parts of an instanced mesh that share no vertex, and [n_instances] the part of each instance;
     * 0 parts: every instance has all of it. */
    int n_parts;
    lf_mesh_part *parts;
    uint32_t *part_of;
    int n_files;
    lf_mesh_file files[LF_MESH_MAX_FILES];
    lf_warnings warnings; /* about features of the file that are lost */
} lf_mesh_data;

/* Reads desc->file or desc->arrays through quiltimport (import.h): OBJ, PLY, STL, glTF, 3DS. Every
 * file that it opens lies under roots (NULL = anywhere); relative names are relative to folder.
 * Applies the file's own node transforms and desc->transform. Drops triangles without area, and,
 * with a warning, triangles with vertices that are not finite or beyond LF_MAX_COORDINATE. A mesh
 * without triangles is an error. Lost features of the file are in out->warnings. Animations are at
 * desc->clip; LF_E_ARG: the file has no such clip. *out must be zeroed; release with
 * lf_mesh_data_finish, also after a failure. Errors: LF_E_IO, LF_E_PATH, LF_E_FORMAT, LF_E_NOMEM,
 * and errors of lf_import_run. Thread: any, several at once. */
LF_NODISCARD lf_status lf_mesh_import(const lf_mesh_desc *desc, const char *folder,
                                      const lf_roots *roots, lf_mesh_data *out, lf_error *err);

/* Whether two meshes from files or arrays make the same request to a reader. If folder and roots
 * are also the same, one reading serves both. */
bool lf_mesh_reads_alike(const lf_mesh_desc *a, const lf_mesh_desc *b);
/* lf_mesh_import for n meshes that all read like desc: reads the file once, and fills each of
 * *out[n] with a copy. On failure some may be filled. */
LF_NODISCARD lf_status lf_mesh_import_alike(const lf_mesh_desc *desc, const char *folder,
                                            const lf_roots *roots, lf_mesh_data *const out[], int n,
                                            lf_error *err);

/* Records a file that was opened for a mesh, once per path. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_note_file(lf_mesh_data *data, const char *path, int fd,
                                         lf_error *err);
/* The same for an array, by its name. */
LF_NODISCARD lf_status lf_mesh_note_array(lf_mesh_data *data, const char *name, int fd,
                                          lf_error *err);
/* Copies the record of a file from another mesh. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_note_same(lf_mesh_data *data, const lf_mesh_file *file,
                                         lf_error *err);
/* The record of a path; NULL: none. */
const lf_mesh_file *lf_mesh_noted(const lf_mesh_data *data, const char *path);

/* Makes the mesh of desc->shape, as lf_mesh_import fills it. LF_E_NOMEM; LF_E_FORMAT: it exceeds
 * LF_MAX_REACH. */
LF_NODISCARD lf_status lf_mesh_shape_make(const lf_mesh_desc *desc, lf_mesh_data *out,
                                          lf_error *err);

/* Extends bounds (minimum, maximum) by the triangles over their whole motion; for an instanced mesh
 * by its transformed boxes. */
void lf_mesh_data_bounds(const lf_mesh_data *data, double bounds[2][3]);
/* Part `number`; all of the mesh if it has no parts. */
lf_mesh_part lf_mesh_data_part(const lf_mesh_data *data, int number);
/* The box of a part's triangles without instance transforms. */
void lf_mesh_data_own_bounds(const lf_mesh_data *data, const lf_mesh_part *part, double out[2][3]);
/* Accepts zeroed structs; leaves them zeroed. */
void lf_mesh_data_finish(lf_mesh_data *data);

#endif
