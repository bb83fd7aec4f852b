#if defined(__x86_64__)
#include "render/reconstruct/kernel_loops.h"

const lf_reconstruct_kernels lf_reconstruct_kernels_avx2 = {
    .read = read, .add = add, .move = move, .solve = solve, .predict = predict, .show = show};
#else
typedef int lf_reconstruct_kernels_avx2_not_here;
#endif
