/* The square [-1,1]^2 in the xz plane, facing +y. */
#include "render/import/scene/mesh_shape.h"

static void corner(int patch, int i, int j, double out[3])
{
    (void)patch;
    out[0] = 2 * i - 1;
    out[1] = 0;
    out[2] = 1 - 2 * j;
}

const lf_mesh_shape lf_mesh_quad = {
    .name = "quad", .n_patches = 1, .across = 1, .down = 1, .corner = corner};
