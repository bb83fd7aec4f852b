/* Meshes of glTF (specification, section 3.7): the data of their primitives, checked once, so that
 * building a mesh needs no further checks. One thread. */
#ifndef LF_RENDER_GLTF_PRIMITIVE_H
#define LF_RENDER_GLTF_PRIMITIVE_H

#include "render/import/reader/gltf_accessor.h"
#include "render/scene/texture.h"

#define LF_GLTF_JOINT_SETS 2 /* of four joints */
#define LF_GLTF_MOST_TARGETS 4096

/* The offsets of a morph target; each is optional. */
typedef struct lf_gltf_target {
    lf_gltf_accessor position, normal, tangent;
} lf_gltf_target;

/* Features of a primitive that are not read. */
typedef enum lf_gltf_lost {
    LF_GLTF_LOST_COLOURS, /* COLOR_1 and later */
    LF_GLTF_LOST_JOINTS,  /* beyond LF_GLTF_JOINT_SETS */
    LF_GLTF_LOST_MORPHS,  /* morph targets of texture coordinates and colours */
    LF_GLTF_LOST_KINDS
} lf_gltf_lost;

/* Decompressed arrays. */
typedef struct lf_gltf_decoded lf_gltf_decoded;

/* All vertex attributes have the same count, or are absent. */
typedef struct lf_gltf_primitive {
    lf_gltf_accessor position, normal, tangent, uv[LF_UV_SETS], colour;
    lf_gltf_accessor joints[LF_GLTF_JOINT_SETS], weights[LF_GLTF_JOINT_SETS];
    lf_gltf_accessor indices; /* absent: each vertex once */
    unsigned mode;
    uint32_t material;      /* LF_GLTF_NONE */
    bool lacks_material;    /* its material does not exist, and it has none */
    size_t n_wrong_normals; /* indices without a vertex */
    unsigned lost;          /* bits 1 << lf_gltf_lost */
    size_t n_triangles;     /* 0 for points or lines … */
    size_t n_beside;        /* … their number */
    size_t n_targets;
    lf_gltf_target *targets;
    lf_gltf_decoded *decoded;
} lf_gltf_primitive;

typedef struct lf_gltf_mesh {
    size_t n; /* 0: not opened yet */
    lf_gltf_primitive *primitives;
    size_t n_weights;
    float *weights; /* of morph targets, unless a node overrides them */
} lf_gltf_mesh;

/* Opens meshes[number] into a zeroed mesh, with the materials of a variant (LF_GLTF_NONE: the
 * default). LF_E_FORMAT, LF_E_NOMEM. Release with lf_gltf_mesh_close, also after a failure. */
LF_NODISCARD lf_status lf_gltf_mesh_open(lf_gltf *gltf, uint32_t number, uint32_t variant,
                                         lf_gltf_mesh *out, lf_error *err);
/* Accepts a zeroed struct. */
void lf_gltf_mesh_close(lf_gltf_mesh *mesh);

/* The vertices of a triangle. false: one of them does not exist, and all of *out are the first
 * vertex. */
bool lf_gltf_corners(const lf_gltf_primitive *primitive, size_t triangle, uint32_t out[3]);
/* The number of a variant of KHR_materials_variants by its name; NULL: LF_GLTF_NONE, the default.
 * LF_E_ARG: no such variant; the error lists the existing ones. */
LF_NODISCARD lf_status lf_gltf_find_variant(const lf_gltf *gltf, const char *name, uint32_t *out,
                                            lf_error *err);

/* Reads an array of weights from JSON. *out is calloc's; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_weights(const json_t *object, float **out, size_t *out_n,
                                       lf_error *err);

/* gltf_draco.c: reads the compressed attributes of a primitive with KHR_draco_mesh_compression, and
 * its triangles. LF_E_FORMAT, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_draco(lf_gltf *gltf, const json_t *primitive, lf_gltf_primitive *out,
                                     lf_error *err);
/* Accepts NULL. */
void lf_gltf_decoded_free(lf_gltf_decoded *decoded);

/* An attribute of a primitive by its name, with its requirements. */
typedef struct lf_gltf_attribute {
    const char *name;
    lf_gltf_accessor *accessor;
    unsigned least, most; /* number of components */
} lf_gltf_attribute;
#define LF_GLTF_ATTRIBUTES (4 + LF_UV_SETS + 2 * LF_GLTF_JOINT_SETS)
/* All attributes of a primitive; POSITION is the first. */
void lf_gltf_attributes(lf_gltf_primitive *primitive, lf_gltf_attribute out[LF_GLTF_ATTRIBUTES]);

#endif
