/* The header of a PLY file (Turk, The PLY Polygon File Format, 1994). One thread. */
#ifndef LF_RENDER_PLY_HEADER_H
#define LF_RENDER_PLY_HEADER_H

#include "render/import/reader/input.h"
#include "render/import/reader/soup.h"

typedef enum lf_ply_type {
    LF_PLY_INT8,
    LF_PLY_UINT8,
    LF_PLY_INT16,
    LF_PLY_UINT16,
    LF_PLY_INT32,
    LF_PLY_UINT32,
    LF_PLY_FLOAT,
    LF_PLY_DOUBLE,
    LF_PLY_TYPES
} lf_ply_type;

extern const unsigned char lf_ply_sizes[LF_PLY_TYPES]; /* bytes */

/* Use of a property. */
typedef enum lf_ply_role {
    LF_PLY_UNUSED,
    LF_PLY_X, /* and y, z, and so on: groups of three are consecutive */
    LF_PLY_Y,
    LF_PLY_Z,
    LF_PLY_NX,
    LF_PLY_NY,
    LF_PLY_NZ,
    LF_PLY_RED, /* and the following, of a vertex */
    LF_PLY_GREEN,
    LF_PLY_BLUE,
    LF_PLY_ALPHA,
    LF_PLY_U,
    LF_PLY_V,
    LF_PLY_INDICES,
    LF_PLY_UVS, /* of a face's corners, two per corner */
    LF_PLY_MATERIAL_INDEX,
    LF_PLY_TEXTURE_INDEX,
    LF_PLY_DIFFUSE_RED,
    LF_PLY_DIFFUSE_GREEN,
    LF_PLY_DIFFUSE_BLUE,
    LF_PLY_SPECULAR_RED,
    LF_PLY_SPECULAR_GREEN,
    LF_PLY_SPECULAR_BLUE,
    LF_PLY_SPECULAR_POWER,
    LF_PLY_ROLES
} lf_ply_role;

typedef struct lf_ply_property {
    lf_ply_type type, count_type; /* count_type: of a list */
    bool is_list;
    lf_ply_role role;
} lf_ply_property;

typedef enum lf_ply_kind {
    LF_PLY_OTHER,
    LF_PLY_VERTEX,
    LF_PLY_FACE,
    LF_PLY_STRIPS,
    LF_PLY_MATERIAL
} lf_ply_kind;

#define LF_PLY_MAX_PROPERTIES 256
#define LF_PLY_MAX_ELEMENTS 64
#define LF_PLY_MAX_TEXTURES 16
#define LF_PLY_MAX_NAME 256

typedef struct lf_ply_element {
    lf_ply_kind kind;
    uint64_t count;
    int first, n_properties; /* in the header's properties */
} lf_ply_element;

typedef enum lf_ply_encoding { LF_PLY_TEXT, LF_PLY_LITTLE, LF_PLY_BIG } lf_ply_encoding;

typedef struct lf_ply_header {
    lf_ply_encoding encoding;
    int n_elements, n_properties;
    lf_ply_element elements[LF_PLY_MAX_ELEMENTS];
    lf_ply_property properties[LF_PLY_MAX_PROPERTIES];
    /* comment TextureFile NAME, as in MeshLab: the names that fit, and their number in the file */
    int n_textures;
    char textures[LF_PLY_MAX_TEXTURES][LF_PLY_MAX_NAME];
    lf_left_out elements_left, properties_left; /* ignored ones */
} lf_ply_header;

/* Reads the header, up to the first byte after its last line. LF_E_FORMAT: not a header, or it
 * declares more data than the file has. */
LF_NODISCARD lf_status lf_ply_read_header(lf_input *in, lf_ply_header *out, lf_error *err);

#endif
