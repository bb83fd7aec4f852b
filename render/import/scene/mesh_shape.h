/* Mesh shapes that need no file; private to render/. A shape is one file (mesh_quad.c, …) that ends
 * in one struct, and one line of LF_MESH_SHAPES. No other code knows its name. */
#ifndef LF_RENDER_MESH_SHAPE_H
#define LF_RENDER_MESH_SHAPE_H

/* A shape consists of patches. Each is a lattice of (across + 1) x (down + 1) corners, of which
 * four form two triangles. */
typedef struct lf_mesh_shape {
    const char *name; /* value of "shape" in a scene file */
    int n_patches, across, down;
    /* Position of the corner (i, j) of a patch, within [-1,1]^3: i to the right and j upwards as
     * seen from outside. If corners of a facet coincide bitwise (at poles), degenerate triangles
     * are dropped. */
    void (*corner)(int patch, int i, int j, double out[3]);
    /* The unit normal at a corner, outwards; NULL: facets are flat. */
    void (*normal)(const double p[3], float out[3]);
    /* Texture coordinates for an image that covers the patch: (0, 0) is the upper left. NULL:
     * uniform over the lattice. */
    void (*place)(int patch, const double p[3], double out[2]);
} lf_mesh_shape;

/* All shapes, one line each. */
#define LF_MESH_SHAPES(SHAPE)                                                                      \
    SHAPE(quad)                                                                                    \
    SHAPE(cube)                                                                                    \
    SHAPE(sphere)                                                                                  \
    SHAPE(disk)

#define LF_DECLARE_MESH_SHAPE(name) extern const lf_mesh_shape lf_mesh_##name;
LF_MESH_SHAPES(LF_DECLARE_MESH_SHAPE)
#undef LF_DECLARE_MESH_SHAPE

/* All shapes as a list, ended by NULL. */
extern const lf_mesh_shape *const lf_mesh_shapes[];

#endif
