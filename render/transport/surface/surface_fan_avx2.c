#if defined(__x86_64__)
#include "render/transport/surface/surface_fan_loops.h"

const lf_surface_fans lf_surface_fans_avx2 = LF_SURFACE_FANS;
#else
typedef int lf_surface_fans_avx2_not_here;
#endif
