#if defined(__x86_64__)
#include "render/reconstruct/kernel_loops.h"

const lf_reconstruct_kernels lf_reconstruct_kernels_avx512 = {
    .read = read, .add = add, .move = move, .solve = solve, .predict = predict};
#else
typedef int lf_reconstruct_kernels_avx512_not_here;
#endif
