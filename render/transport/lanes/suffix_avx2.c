#if defined(__x86_64__)
#include "render/transport/lanes/lanes_avx2.h"

#include "render/transport/lanes/suffix_lanes.h"

_Static_assert(LF_WIDTH == 8, "lanes are those of AVX2");

const lf_suffixes lf_suffixes_avx2 = {.name = "avx2", .trace = trace, .light = light};
#else
typedef int lf_suffixes_avx2_not_here;
#endif
