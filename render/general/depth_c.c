#include "render/general/cell_lanes.h"
#include "render/general/depth_lanes.h"

const lf_depth_kernel lf_depth_kernel_c = {.name = "c", .trace = trace, .trace_cells = trace_cells};
