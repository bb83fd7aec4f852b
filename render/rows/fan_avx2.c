#if defined(__x86_64__)
#include "render/rows/fan_lanes.h"
#include "render/transport/lanes_avx2.h"

const lf_fans lf_fans_avx2 = LF_FANS("avx2");
#else
typedef int lf_fans_avx2_not_here;
#endif
