#include "render/transport/surface/surface_fan_loops.h"

const lf_surface_fans lf_surface_fans_c = LF_SURFACE_FANS;
