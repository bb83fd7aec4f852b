/* Skies that come as the six faces of a cube, as pictures by latitude and longitude; private to
 * render/. The faces lie one below the other, +X -X +Y -Y +Z -Z, turned as OpenEXR's ImfEnvmap.h
 * says; its axes are the scene's. */
#ifndef LF_RENDER_ENVIRONMENT_CUBE_H
#define LF_RENDER_ENVIRONMENT_CUBE_H

#include <stdbool.h>

/* The size of the picture that is made of faces of side x side pixels: twice the side and more rows
 * (a pixel of the cube is at most as large as two rows are apart), at least 512, at most 8192. */
void lf_cube_unfolded(int side, int *out_width, int *out_height);

/* Fills rgb [height][width][3], which lies as lf_environment's file pictures do (-z in the middle,
 * -x at the left quarter), from faces [6 * side][side][3]. Each pixel is the mean over several
 * directions in it; between a face's pixels numbers are interpolated, and never across edges: the
 * outermost pixels' centres lie on the edges. false: no memory. */
bool lf_cube_unfold(const float *faces, int side, int width, int height, float *rgb);

#endif
