/* Converts skies given as six cube faces to latitude-longitude images; private to render/. The
 * faces are stacked in the order +X -X +Y -Y +Z -Z, with the orientation of OpenEXR's ImfEnvmap.h;
 * the axes are the scene's. */
#ifndef LF_RENDER_ENVIRONMENT_CUBE_H
#define LF_RENDER_ENVIRONMENT_CUBE_H

#include <stdbool.h>

/* The size of the image for faces of side x side pixels. The height is twice the side, at least
 * 512, at most 8192, so that a pixel of the cube is at most as large as the distance of two rows.
 * The width is twice the height. */
void lf_cube_unfolded(int side, int *out_width, int *out_height);

/* Fills rgb [height][width][3] from faces [6 * side][side][3], in the layout of lf_environment's
 * file images (-z in the middle, -x at the left quarter). Each pixel is the mean over several
 * directions in it. Values are interpolated between a face's pixels and never across edges: the
 * centres of the outermost pixels are on the edges. false: no memory. */
bool lf_cube_unfold(const float *faces, int side, int width, int height, float *rgb);

#endif
