#include "render/transport/lanes/cell_lanes.h"
#include "render/transport/lanes/depth_lanes.h"

const lf_depth_kernel lf_depth_kernel_c = {.name = "c", .trace = trace, .trace_cells = trace_cells};
