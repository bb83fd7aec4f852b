/* Pictures of the guest's display, as QEMU writes them. */
#ifndef LF_TESTS_KERNEL_PPM_H
#define LF_TESTS_KERNEL_PPM_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/image.h"

/* Whether a file of binary PPM is this picture of 3 channels; says on the standard output "equal"
 * or where it differs. */
static inline bool lf_ppm_compare(const char *path, const lf_image8 *expected)
{
    int width = 0, height = 0, y = 0;
    size_t n = (size_t)expected->width * 3;
    uint8_t *row = malloc(n);
    FILE *file = fopen(path, "rb");
    bool good = row && file && fscanf(file, "P6 %d %d 255", &width, &height) == 2 &&
                fgetc(file) == '\n' && width == expected->width && height == expected->height;
    while (good && y < height) {
        good = fread(row, 1, n, file) == n &&
               memcmp(row, expected->data + (size_t)y * expected->stride, n) == 0;
        y += good;
    }
    if (good)
        printf("equal\n");
    else
        printf("differs: %dx%d, row %d\n", width, height, y);
    if (file)
        fclose(file);
    free(row);
    return good;
}

#endif
