/* Lanes of 8, of AVX2; for files that are compiled for it. */
#ifndef LF_RENDER_LANES_AVX2_H
#define LF_RENDER_LANES_AVX2_H

#define LF_LANES_AVX2
#include "render/transport/lanes.h"

#endif
