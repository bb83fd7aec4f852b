/* The surface of [-1,1]^3. */
#include "render/load/mesh_shape.h"

/* Faces -x, +x, -y, … seen from outside. */
static void corner(int patch, int i, int j, double out[3])
{
    int axis = patch / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    double sign = patch % 2 ? 1 : -1;
    out[axis] = sign;
    out[u] = sign * (2 * i - 1);
    out[v] = 2 * j - 1;
}

const lf_mesh_shape lf_mesh_cube = {
    .name = "cube", .n_patches = 6, .across = 1, .down = 1, .corner = corner};
