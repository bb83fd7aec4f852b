/* Lanes of 8, of AVX2; for files that are compiled for it. */
#ifndef LF_RENDER_LANES_AVX2_H
#define LF_RENDER_LANES_AVX2_H

#ifdef __AVX2__ /* alone it is nothing */
#define LF_LANES_AVX2
#include "render/transport/lanes/lanes.h"
#endif

#endif
