/* make_sky FILE.hdr: writes the sky of the shipped scenes: a clear evening as a latitude-longitude
 * picture of 256 x 128 texels in Radiance's format, blue above, warm towards the horizon and one
 * side of it, dim ground below. No sun: scenes bring their own. */
#include <math.h>
#include <stdio.h>

#define WIDTH 256
#define HEIGHT 128
#define PI 3.14159265358979323846

/* Radiance from a direction given by its height (-1..1) and its angle about the vertical. */
static void sky(double height, double phi, double rgb[3])
{
    static const double zenith[3] = {0.16, 0.32, 0.75}, horizon[3] = {0.95, 0.80, 0.62},
                        ground[3] = {0.16, 0.14, 0.12};
    double glow = 0.5 + 0.5 * cos(phi);
    double up = height > 0 ? pow(1 - height, 4) : exp(30 * height);
    for (int i = 0; i < 3; i++) {
        double warm = horizon[i] * (0.45 + 0.9 * glow * glow);
        double far = height > 0 ? zenith[i] : ground[i];
        rgb[i] = far + up * (warm - far);
    }
}

/* Ward's shared-exponent pixel. */
static void write_rgbe(FILE *file, const double rgb[3])
{
    double largest = fmax(rgb[0], fmax(rgb[1], rgb[2]));
    int exponent;
    double scale = frexp(largest, &exponent) * 256 / largest;
    for (int i = 0; i < 3; i++)
        fputc((int)(rgb[i] * scale), file);
    fputc(exponent + 128, file);
}

int main(int argc, char **argv)
{
    FILE *file = argc == 2 ? fopen(argv[1], "wb") : NULL;
    if (!file) {
        fprintf(stderr, argc == 2 ? "make_sky: cannot write %s\n" : "usage: make_sky FILE.hdr\n",
                argv[1]);
        return 2;
    }
    fprintf(file, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", HEIGHT, WIDTH);
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            double rgb[3];
            sky(cos(PI * (y + 0.5) / HEIGHT), 2 * PI * (x + 0.5) / WIDTH - 0.6 * PI, rgb);
            write_rgbe(file, rgb);
        }
    }
    return fclose(file) == 0 ? 0 : 1;
}
