#include "render/plane/kernel.h"

#include "base/cpu.h"

static lf_isa_tables tables = {
    [LF_ISA_C] = &lf_kernels_c,
#if defined(__x86_64__)
    [LF_ISA_AVX2] = &lf_kernels_avx2,
    [LF_ISA_AVX512] = &lf_kernels_avx512,
#elif defined(__aarch64__)
    [LF_ISA_NEON] = &lf_kernels_neon,
#endif
};

const lf_kernels *lf_kernels_at(int index)
{
    return lf_isa_at(tables, (size_t)index);
}

const lf_kernels *lf_kernels_get(void)
{
    return lf_isa_get(tables);
}
