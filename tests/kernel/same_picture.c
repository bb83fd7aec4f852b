/* same_picture PICTURE.png DISPLAY.ppm: whether they are the same, pixel for pixel. Exit status 0
 * or 1. */
#include "base/image_io.h"
#include "tests/kernel/ppm.h"

int main(int argc, char **argv)
{
    lf_image8 picture = {0};
    lf_error err = {0};
    char text[sizeof err + 32];
    if (argc != 3)
        return 2;
    if (lf_image8_read(argv[1], NULL, &picture, &err) != LF_OK) {
        printf("%s\n", lf_error_format(&err, text, sizeof text));
        return 1;
    }
    bool same = lf_ppm_compare(argv[2], &picture);
    lf_image8_finish(&picture);
    return same ? 0 : 1;
}
