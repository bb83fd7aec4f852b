#if defined(__x86_64__)
#include "render/transport/lanes/lanes_avx2.h"

#include "render/plane/fan_lanes.h"

_Static_assert(LF_WIDTH == 8, "lanes are those of AVX2");

const lf_fans lf_fans_avx2 = LF_FANS("avx2");
#else
typedef int lf_fans_avx2_not_here;
#endif
