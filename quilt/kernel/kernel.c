#include "quilt/kernel/kernel.h"

#include "base/cpu.h"

static lf_isa_tables tables = {
    [LF_ISA_C] = &lf_quilt_kernels_c,
#if defined(__x86_64__)
    [LF_ISA_AVX2] = &lf_quilt_kernels_avx2,
#endif
};

const lf_quilt_kernels *lf_quilt_kernels_at(int index)
{
    return lf_isa_at(tables, (size_t)index);
}

const lf_quilt_kernels *lf_quilt_kernels_get(void)
{
    return lf_isa_get(tables);
}
