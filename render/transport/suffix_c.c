#include "render/transport/suffix_lanes.h"

const lf_suffixes lf_suffixes_c = {.name = "c", .trace = trace, .light = light};
#include <stdlib.h>
float PICTURE_SHARE = 1.0f;
__attribute__((constructor)) static void init_share(void) { if (getenv("PSHARE")) PICTURE_SHARE = (float)atof(getenv("PSHARE")); }
