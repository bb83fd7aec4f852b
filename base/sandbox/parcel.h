/* The result of a reader (import.h): plain arrays in one sealed memfd, after a header with their
 * positions. The receiver treats it as hostile, because the reader has read an untrusted file and
 * may be compromised.
 *
 *     header, 64 bytes a section: lf_parcel_header
 *     sections, each at a multiple of 64 bytes, in any order
 *
 * Numbers are in native byte order: both sides are from one build. */
#ifndef LF_BASE_PARCEL_H
#define LF_BASE_PARCEL_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#include "base/status.h"

#define LF_PARCEL_MAGIC UINT64_C(0x396c637270746c71) /* "qltprcl9" */

/* The content of a section, and the type of its elements. */
typedef enum lf_parcel_tag {
    LF_PARCEL_WARNINGS,  /* char: lines for people, each ended by a newline */
    LF_PARCEL_POSITIONS, /* double: x, y, z of each vertex, in world coordinates */
    LF_PARCEL_NORMALS,   /* float: x, y, z at a vertex; absent: flat shading */
    LF_PARCEL_TRIANGLES, /* uint32_t: three vertices of a triangle */
    LF_PARCEL_CHOICES,   /* uint16_t: the material of each triangle; absent: not from the file */
    LF_PARCEL_MATERIALS, /* lf_parcel_material */
    LF_PARCEL_SCALARS,   /* float: lf_principled (render/scene/principled.h) of each material */
    LF_PARCEL_UVS,       /* float: u, v of each vertex; the sets follow each other */
    LF_PARCEL_COLOURS,   /* float: red, green, blue, alpha at a vertex, linear */
    LF_PARCEL_TANGENTS,  /* float: x, y, z, side at a vertex */
    LF_PARCEL_PICTURES,  /* lf_parcel_picture */
    LF_PARCEL_TEXELS,    /* uint8_t: red, green, blue, alpha; the pictures follow each other */
    LF_PARCEL_SIZE,      /* int64_t: voxels of a grid along x, y, z */
    LF_PARCEL_MAP,       /* double: 3x4, row-major, from voxels to the file's world */
    LF_PARCEL_BRICKS,    /* uint32_t: positions of bricks (lf_grid_put), ascending */
    LF_PARCEL_VALUES,    /* float: their values, LF_BRICK_STRIDE each */
    LF_PARCEL_OTHERS,    /* char: names of the file's other grids (render/scene/scene.h) */
    /* int64_t: width, height, lf_image_layout, pixel aspect in millionths, focal_35mm, frame rate
     * in millionths */
    LF_PARCEL_SHAPE,
    LF_PARCEL_PIXELS8,   /* uint8_t: [height][width][3], display encoded */
    LF_PARCEL_PIXELS32,  /* float: the same, linear; a picture has one of the two */
    LF_PARCEL_SPAN,      /* double: duration of an animation in seconds; absent: nothing moves */
    LF_PARCEL_LIGHTS,    /* lf_parcel_light */
    LF_PARCEL_CAMERAS,   /* lf_parcel_camera */
    LF_PARCEL_INSTANCES, /* double: 3x4, row-major, of each instance */
    LF_PARCEL_PARTS, /* uint32_t: first triangle, triangles, first vertex, vertices of each part */
    LF_PARCEL_PART_OF, /* uint32_t: the part of each instance */
    LF_PARCEL_ODD,     /* double: four, lf_grid_odd (render/scene/grid.h); absent: none */
    LF_PARCEL_DEPTH,   /* double: lf_image_depth; absent: unknown */
    LF_PARCEL_TAGS
} lf_parcel_tag;

typedef struct lf_parcel_section {
    uint64_t count, offset; /* elements; bytes from the beginning. count 0: absent */
} lf_parcel_section;

typedef struct lf_parcel_header {
    uint64_t magic;
    lf_parcel_section section[LF_PARCEL_TAGS];
} lf_parcel_header;

typedef struct lf_parcel_texture {
    uint32_t picture; /* 1 + its number; 0: none */
    uint32_t wrap_u, wrap_v, set, nearest, finest;
    float map[2][3], scale;
} lf_parcel_texture;

/* The members of a material that are not scalars. */
typedef struct lf_parcel_material {
    uint32_t kind;  /* index in lf_surface_kinds */
    uint32_t cover; /* lf_cover */
    uint32_t is_solid;
    uint32_t emits_by_colours;
    lf_parcel_texture texture[13]; /* one per slot (render/scene/texture.h) */
    char name[128];                /* terminated */
} lf_parcel_material;

typedef struct lf_parcel_picture {
    uint32_t width, height;
} lf_parcel_picture;

/* lf_punctual (render/scene/punctual.h). */
typedef struct lf_parcel_light {
    double position[3], direction[3], intensity[3], outer, inner;
    uint64_t kind;
} lf_parcel_light;

/* lf_file_camera (render/scene/file_camera.h). */
typedef struct lf_parcel_camera {
    double position[3], look[3], up[3], fov_y;
    uint32_t number, parallel;
    char name[128], node_name[128]; /* terminated */
} lf_parcel_camera;

/* Bytes of one element of a section. */
size_t lf_parcel_element_size(lf_parcel_tag tag);

/* ------------------------------------------------------------------------------- writing one -- */

typedef struct lf_parcel_writer {
    int fd;
    uint64_t size;
    lf_parcel_header header;
} lf_parcel_writer;

/* Begins a parcel. LF_E_IO: no memfd. Release with lf_parcel_abandon unless it was sealed. */
LF_NODISCARD lf_status lf_parcel_begin(lf_parcel_writer *writer, lf_error *err);
/* Appends a section of count elements. LF_E_NOMEM: no space, or more than the process may write. */
LF_NODISCARD lf_status lf_parcel_put(lf_parcel_writer *writer, lf_parcel_tag tag, const void *data,
                                     size_t count, lf_error *err);
/* Appends count elements to a section that is written in several consecutive calls. */
LF_NODISCARD lf_status lf_parcel_append(lf_parcel_writer *writer, lf_parcel_tag tag,
                                        const void *data, size_t count, lf_error *err);
/* Writes the header and seals the file. The caller owns *out_fd. */
LF_NODISCARD lf_status lf_parcel_seal(lf_parcel_writer *writer, int *out_fd, lf_error *err);
void lf_parcel_abandon(lf_parcel_writer *writer);

/* ---------------------------------------------------------------------------- taking it over -- */

typedef struct lf_parcel {
    const unsigned char *data; /* mapped */
    size_t size;
} lf_parcel;

/* Maps the parcel behind fd (which stays the caller's) after checking that it is sealed and that
 * every section is within it. LF_E_FORMAT: not a valid parcel; err names the first fault;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_parcel_open(int fd, lf_parcel *out, lf_error *err);
/* The elements of a section and their number; NULL: absent. Valid until the parcel is closed. */
const void *lf_parcel_get(const lf_parcel *parcel, lf_parcel_tag tag, size_t *out_count);
/* Accepts a zeroed parcel. */
void lf_parcel_close(lf_parcel *parcel);

#ifdef __cplusplus
}
#endif
#endif
