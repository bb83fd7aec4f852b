#if defined(__x86_64__)
#define READ_LANES 16
#include "render/reconstruct/kernel_loops.h"

const lf_reconstruct_kernels lf_reconstruct_kernels_avx512 = {
    .read = read, .add = add, .move = move, .solve = solve, .predict = predict, .show = show};
#else
typedef int lf_reconstruct_kernels_avx512_not_here;
#endif
