#include "render/transport/lanes/depth_kernel.h"

#include "base/cpu.h"

static lf_isa_tables tables = {
    [LF_ISA_C] = &lf_depth_kernel_c,
#if defined(__x86_64__)
    [LF_ISA_AVX2] = &lf_depth_kernel_avx2,
#endif
};

const lf_depth_kernel *lf_depth_kernel_at(int index)
{
    return lf_isa_at(tables, (size_t)index);
}

const lf_depth_kernel *lf_depth_kernel_get(void)
{
    return lf_isa_get(tables);
}
