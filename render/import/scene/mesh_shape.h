/* Shapes of meshes that need no file; private to render/. A shape is one file (mesh_quad.c, …) that
 * ends in one struct, and one line of LF_MESH_SHAPES: nothing else knows its name. */
#ifndef LF_RENDER_MESH_SHAPE_H
#define LF_RENDER_MESH_SHAPE_H

/* Patches of facets: each a lattice of (across + 1) x (down + 1) corners, of which four make two
 * triangles. */
typedef struct lf_mesh_shape {
    const char *name; /* what "shape" says in a scene file */
    int n_patches, across, down;
    /* Where the corner (i, j) of a patch lies, within [-1,1]^3: i to the right and j upwards as
     * seen from outside. Where corners of a facet are the same point to the last bit (at poles),
     * what is left of it counts. */
    void (*corner)(int patch, int i, int j, double out[3]);
    /* The unit normal at a corner, outwards; NULL: facets are flat. */
    void (*normal)(const double p[3], float out[3]);
    /* Where it lies in a picture that covers the patch: (0, 0) is the upper left. NULL: a patch's
     * lattice is evenly the picture. */
    void (*place)(int patch, const double p[3], double out[2]);
} lf_mesh_shape;

/* All shapes, a line each. */
#define LF_MESH_SHAPES(SHAPE)                                                                      \
    SHAPE(quad)                                                                                    \
    SHAPE(cube)                                                                                    \
    SHAPE(sphere)                                                                                  \
    SHAPE(disk)

#define LF_DECLARE_MESH_SHAPE(name) extern const lf_mesh_shape lf_mesh_##name;
LF_MESH_SHAPES(LF_DECLARE_MESH_SHAPE)
#undef LF_DECLARE_MESH_SHAPE

/* The same as a list, ended by NULL. */
extern const lf_mesh_shape *const lf_mesh_shapes[];

#endif
