/* The unit sphere in facets, with smooth normals. */
#include "render/import/scene/mesh_shape.h"

#include <math.h>

#define ACROSS 128
#define DOWN 64

static void corner(int patch, int i, int j, double out[3])
{
    (void)patch;
    double phi = -2 * M_PI * (i % ACROSS) / ACROSS, theta = M_PI * (DOWN - j) / DOWN;
    double ring = j == 0 || j == DOWN ? 0 : sin(theta);
    out[0] = ring * cos(phi);
    out[1] = cos(theta);
    out[2] = ring * sin(phi);
}

/* The point itself. */
static void normal(const double p[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = (float)p[i];
}

const lf_mesh_shape lf_mesh_sphere = {.name = "sphere",
                                      .n_patches = 1,
                                      .across = ACROSS,
                                      .down = DOWN,
                                      .corner = corner,
                                      .normal = normal};
