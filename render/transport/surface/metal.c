#include "render/transport/surface/metal.h"

#include <stddef.h>

const char *const lf_metal_names[] = {"aluminium", "chromium", "copper",   "gold", "iron",
                                      "nickel",    "silver",   "titanium", NULL};

const lf_metal lf_metals[] = {
    {{1.322f, 1.011f, 0.683f}, {7.311f, 6.617f, 5.625f}}, /* aluminium */
    {{3.178f, 3.180f, 2.449f}, {3.300f, 3.330f, 3.206f}}, /* chromium */
    {{0.362f, 1.015f, 1.246f}, {3.127f, 2.579f, 2.453f}}, /* copper */
    {{0.222f, 0.428f, 1.335f}, {3.208f, 2.461f, 1.872f}}, /* gold */
    {{2.890f, 2.950f, 2.643f}, {3.040f, 2.930f, 2.803f}}, /* iron */
    {{1.985f, 1.920f, 1.763f}, {3.985f, 3.611f, 3.042f}}, /* nickel */
    {{0.058f, 0.060f, 0.046f}, {4.106f, 3.590f, 2.795f}}, /* silver */
    {{2.659f, 2.540f, 2.303f}, {3.698f, 3.430f, 3.080f}}, /* titanium */
};
