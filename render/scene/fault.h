/* Deliberate mistakes, for the negative controls of tests; private to render/. */
#ifndef LF_RENDER_SCENE_FAULT_H
#define LF_RENDER_SCENE_FAULT_H

#include <stdbool.h>

/* Deliberate mistakes that a test switches on, to show that it detects them. Only a second build of
 * the sources for render's tests contains them, with LF_FAULTS (tests/module.mk); programs do not.
 */
typedef enum lf_fault {
    LF_FAULT_NO_H = 1,          /* h_k left out of D_k: a missing r_j/r_i */
    LF_FAULT_NO_VISIBILITY = 2, /* one view's visibility is ignored */
    LF_FAULT_REALISED = 4,      /* realised instead of expected counts in the weights */
    LF_FAULT_SWAPPED_VIEWS = 8, /* contributions land in mirrored views */
    LF_FAULT_NO_LIGHT_PDF = 16, /* the p_L term left out of the direction's weights */
    /* B and q use another plane of the row than the base samples, with other random numbers */
    LF_FAULT_OTHER_ROW = 32,
    LF_FAULT_NO_COUNTS = 64, /* c_k of an adaptive pass left out of the sums */
    /* directions drawn below a surface's horizon do not count in W' */
    LF_FAULT_HORIZON = 128,
    /* suffixes ignore points drawn around equiangular lights */
    LF_FAULT_NO_EQUIANGULAR_BALANCE = 256,
    LF_FAULT_NO_CORRECTION = 512, /* samples drawn from slices count as if slices were the grid */
    /* rays meet moving meshes at another shutter time than the visibility test of the views */
    LF_FAULT_OTHER_TIME = 1024,
    LF_FAULT_NO_TIME = 2048, /* all visits use the middle of the shutter */
    /* of light paths: camera paths ignore the pdf of scattering towards them, … */
    LF_FAULT_NO_REVERSE_PDF = 4096,
    LF_FAULT_NO_CELL_PDF = 8192, /* … and the densities of a sun's cells */
    /* light paths ignore that a pivot draws several directions, … */
    LF_FAULT_NO_DIRECTIONS = 16384,
    LF_FAULT_NO_LIGHT_VISIBILITY = 32768, /* … and that surfaces hide it from some views */
    LF_FAULT_NO_MEAN = 65536, /* several suffixes of a pivot are not divided by their number */
    /* camera paths ignore that light paths start at bright parts of skies, … */
    LF_FAULT_NO_SKY_STARTS = 131072,
    LF_FAULT_NO_PICTURE_PDF = 262144, /* … and rarely where the picture of a light is dark */
} lf_fault;

#ifdef LF_FAULTS
#define lf_has_fault(holder, fault) (((holder)->faults & (unsigned)(fault)) != 0)
#else
#define lf_has_fault(holder, fault) ((void)(holder), false)
#endif

#endif
