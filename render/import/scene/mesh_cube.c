/* The surface of [-1,1]^3. */
#include "render/import/scene/mesh_shape.h"

/* Faces -x, +x, -y, … seen from outside. */
static void corner(int patch, int i, int j, double out[3])
{
    int axis = patch / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    double sign = patch % 2 ? 1 : -1;
    out[axis] = sign;
    out[u] = sign * (2 * i - 1);
    out[v] = 2 * j - 1;
}

/* Upright on all sides; the top as seen from above with -z up, the bottom as its mirror image. */
static void place(int patch, const double p[3], double out[2])
{
    const double sign = patch % 2 ? 1 : -1;
    const double right = patch / 2 == 0   ? -sign * p[2]
                         : patch / 2 == 1 ? p[0]
                                          : sign * p[0],
                 below = patch / 2 == 1 ? sign * p[2] : -p[1];
    out[0] = 0.5 * (1 + right);
    out[1] = 0.5 * (1 + below);
}

const lf_mesh_shape lf_mesh_cube = {
    .name = "cube", .n_patches = 6, .across = 1, .down = 1, .corner = corner, .place = place};
