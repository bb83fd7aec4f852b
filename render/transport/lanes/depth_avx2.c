#if defined(__x86_64__)
#include "render/transport/lanes/lanes_avx2.h"

#include "render/transport/lanes/cell_lanes.h"
#include "render/transport/lanes/depth_lanes.h"

_Static_assert(LF_WIDTH == 8, "lanes are those of AVX2");

const lf_depth_kernel lf_depth_kernel_avx2 = {
    .name = "avx2", .trace = trace, .trace_cells = trace_cells};
#else
typedef int lf_depth_avx2_not_here;
#endif
