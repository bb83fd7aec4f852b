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
#define LF_MAX_UV 1e6f /* of a texture coordinate, and of the numbers of a texture's map */
#define LF_MAX_PICTURES 65536
#define LF_MESH_MAX_FILES 256 /* files behind one mesh: material libraries, buffers, pictures */

/* Triangles and vertices that follow each other in a mesh. */
typedef struct lf_mesh_part {
    uint32_t first_triangle, n_triangles, first_vertex, n_vertices;
} lf_mesh_part;

typedef struct lf_mesh_data {
    const char *name; /* the scene's, borrowed */
    int n_vertices, n_triangles;
    /* triangles left out for a vertex that is not finite, or too far away */
    int n_broken;
    double *positions;   /* [n_vertices][3] world coordinates, finite */
    float *normals;      /* [n_vertices][3] unit, world; NULL = flat shading */
    uint32_t *triangles; /* [n_triangles][3] */
    /* [n_triangles] index into materials; NULL when n_materials is 0 */
    uint16_t *triangle_material;
    /* What lies at vertices, each absent where no material wants it: */
    int n_uv_sets;   /* at most LF_UV_SETS */
    float *uvs;      /* [n_uv_sets][n_vertices][2], up to LF_MAX_UV */
    float *colours;  /* [n_vertices][4] linear, 0..1: multiplies albedo, and a coverage */
    float *tangents; /* [n_vertices][4] unit, world, across the normal; w = +-1: the bitangent's
                        side, w cross(normal, tangent) */
    int n_materials; /* the file's own; 0 for shapes and when desc names a material */
    lf_material *materials;
    /* [n_materials] what the file calls them, cut to size; NULL: they have no names */
    char (*names)[LF_MATERIAL_NAME];
    lf_texture_set *textures; /* [n_materials], or NULL: none has any */
    int n_pictures;           /* at most LF_MAX_PICTURES */
    lf_texels *pictures;      /* [n_pictures], their pixels this struct's */
    lf_punctuals lights;
    lf_file_cameras cameras;
    double span; /* seconds that what moves takes, up to LF_MAX_SECONDS; 0: nothing does */
    /* Of the mesh when the shutter closes, as above; positions NULL: it stands still
     * (meshes_import.h). */
    struct {
        double *positions;
        float *normals, *tangents;
    } close;
    /* Where it stands, if it is given once for many places: maps of the world, after which the
     * arrays above are what stands there. 0: it stands where they say. */
    int n_instances;
    lf_affine *places;
    /* What stands there, where that is not all of it: parts that share no vertex, and [n_instances]
     * which of them; 0 parts: all of it. */
    int n_parts;
    lf_mesh_part *parts;
    uint32_t *part_of;
    int n_files;
    lf_mesh_file files[LF_MESH_MAX_FILES];
    lf_warnings warnings; /* what the file holds and the mesh lacks */
} lf_mesh_data;

/* Has desc->file read by quiltimport (import.h): OBJ, PLY, STL, glTF, 3DS. Every file it opens lies
 * under roots (NULL = anywhere). Applies the file's own node transforms and desc->transform.
 * Triangles with vertices that are not finite or lie beyond LF_MAX_COORDINATE, and those without
 * area, are dropped (of the former a warning); a mesh without triangles is an error. What the file
 * holds and the mesh lacks is in out->warnings. folder is what relative names are relative to.
 * What moves stands where desc->clip has it; LF_E_ARG: the file has no such clip.
 * Zeroed *out is filled; release with lf_mesh_data_finish in any case. Errors: LF_E_IO, LF_E_PATH,
 * LF_E_FORMAT, LF_E_NOMEM, and what lf_import_run gives. Thread: any, several at once. */
LF_NODISCARD lf_status lf_mesh_import(const lf_mesh_desc *desc, const char *folder,
                                      const lf_roots *roots, lf_mesh_data *out, lf_error *err);

/* Whether a reader is asked for the same by two meshes of files: with the same folder and roots,
 * one reading is enough for both. */
bool lf_mesh_reads_alike(const lf_mesh_desc *a, const lf_mesh_desc *b);
/* As lf_mesh_import for n meshes that all read like desc: the file is read once, and each of
 * *out[n] gets a copy of its own. On failure some may be filled. */
LF_NODISCARD lf_status lf_mesh_import_alike(const lf_mesh_desc *desc, const char *folder,
                                            const lf_roots *roots, lf_mesh_data *const out[], int n,
                                            lf_error *err);

/* Notes a file that was opened for a mesh, once a path. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_note_file(lf_mesh_data *data, const char *path, int fd,
                                         lf_error *err);
/* Notes what was noted of a file for another mesh. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_note_same(lf_mesh_data *data, const lf_mesh_file *file,
                                         lf_error *err);
/* What was noted of a path; NULL: nothing. */
const lf_mesh_file *lf_mesh_noted(const lf_mesh_data *data, const char *path);

/* The mesh of desc->shape, as lf_mesh_import fills it. LF_E_NOMEM; LF_E_FORMAT: it goes beyond
 * LF_MAX_REACH. */
LF_NODISCARD lf_status lf_mesh_shape_make(const lf_mesh_desc *desc, lf_mesh_data *out,
                                          lf_error *err);

/* Grows bounds (least, greatest) by all that the triangles pass through; of a mesh that stands in
 * many places by the boxes of its box there. */
void lf_mesh_data_bounds(const lf_mesh_data *data, double bounds[2][3]);
/* Its part of a number; the whole where it has none. */
lf_mesh_part lf_mesh_data_part(const lf_mesh_data *data, int number);
/* The box of a part's own triangles, wherever they stand. */
void lf_mesh_data_own_bounds(const lf_mesh_data *data, const lf_mesh_part *part, double out[2][3]);
/* Accepts zeroed structs; leaves them zeroed. */
void lf_mesh_data_finish(lf_mesh_data *data);

#endif
