/* AVX2 lanes of 8; for files that are compiled for AVX2. */
#ifndef LF_RENDER_LANES_AVX2_H
#define LF_RENDER_LANES_AVX2_H

#ifdef __AVX2__ /* nothing is defined without it */
#define LF_LANES_AVX2
#include "render/transport/lanes/lanes.h"
#endif

#endif
