#include "render/reconstruct/kernel_loops.h"

const lf_reconstruct_kernels lf_reconstruct_kernels_c = {
    .read = read, .add = add, .move = move, .solve = solve, .predict = predict, .show = show};
