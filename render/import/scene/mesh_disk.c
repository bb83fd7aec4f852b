/* The disk of radius 1 in the xz plane in a fan of triangles, facing +y. */
#include "render/import/scene/mesh_shape.h"

#include <math.h>

#define ACROSS 128

static void corner(int patch, int i, int j, double out[3])
{
    (void)patch;
    double phi = 2 * M_PI * (i % ACROSS) / ACROSS, ring = 1 - j;
    out[0] = ring * cos(phi);
    out[1] = 0;
    out[2] = -ring * sin(phi);
}

/* The circle in the image's square, with -z up. */
static void place(int patch, const double p[3], double out[2])
{
    (void)patch;
    out[0] = 0.5 * (1 + p[0]);
    out[1] = 0.5 * (1 + p[2]);
}

const lf_mesh_shape lf_mesh_disk = {
    .name = "disk", .n_patches = 1, .across = ACROSS, .down = 1, .corner = corner, .place = place};
