#include "render/plane/fan_lanes.h"

const lf_fans lf_fans_c = LF_FANS("c");
