#include "render/general/depth_lanes.h"

const lf_depth_kernel lf_depth_kernel_c = {.name = "c", .trace = trace};
