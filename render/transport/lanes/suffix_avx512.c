#if defined(__x86_64__)
#define LF_LANES_AVX512
#include "render/transport/lanes/suffix_lanes.h"

const lf_suffixes lf_suffixes_avx512 = {.name = "avx512", .trace = trace, .light = light};
#else
typedef int lf_suffixes_avx512_not_here;
#endif
