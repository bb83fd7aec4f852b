#include "render/transport/lanes/suffix_lanes.h"

const lf_suffixes lf_suffixes_c = {.name = "c", .trace = trace, .light = light};
