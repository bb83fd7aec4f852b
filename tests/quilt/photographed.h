/* Photos of a printed chart under a lens sheet, simulated. Shares no code with the chart or its
 * reader: it knows the TIFF, and optics. For each pixel, a ray of a camera meets the plane of the
 * lenses; the chief ray through the middle of the lens that it meets is refracted into the sheet,
 * and the ink where it arrives is the pixel's light. Fails the running test when anything goes
 * wrong. */
#ifndef LF_TESTS_QUILT_PHOTOGRAPHED_H
#define LF_TESTS_QUILT_PHOTOGRAPHED_H

#include "tests/quilt/printed.h"

/* The print as light that lenses gather, and the page around it. */
typedef struct lf_paper {
    int width, height;
    double right_mm, down_mm; /* size of a pixel */
    float *light;             /* [height][width], averaged over the spot of a lens */
} lf_paper;

typedef enum lf_sheets { LF_ONE_SHEET, LF_NO_SHEET, LF_TURNED_SHEET, LF_TWO_SHEETS } lf_sheets;

typedef struct lf_shot {
    /* the sheet: pitch by a ruler, lens at the middle, clockwise angle */
    lf_sheets sheets;
    double lpi, phase_mm, skew_deg, thickness_mm, index;
    /* the camera: from the point that it looks at, on a ray that leans by `tilt` towards
     * `direction` (0: right, 90: down) */
    double distance_mm, tilt_deg, direction_deg, roll_deg, aim_mm[2];
    double focal_35mm, k1; /* r in units of the focal length */
    int width, height;
    /* light: growth from left to right and top to bottom, loss at the corners, gain */
    double slope[2], vignette, gain, gamma; /* gamma 0: sRGB */
    double blur_px, noise;                  /* standard deviations; noise of linear light */
    int quality;                            /* of JPEG; 0: not compressed */
    bool mirrored;
    uint64_t seed;
} lf_shot;

/* spot_mm: width of a lens's spot. horizontal: lenses run along x. */
void lf_paper_make(const lf_printed *printed, double right_mm, double down_mm, double spot_mm,
                   lf_paper *out);
void lf_paper_finish(lf_paper *paper);
/* [height][width][3]; release by free. */
uint8_t *lf_photograph(const lf_paper *paper, const lf_shot *shot);
/* A JPEG file of the photo, with EXIF data if focal_35mm is not 0. */
void lf_photo_write(const char *path, const uint8_t *photo, const lf_shot *shot, int focal_35mm);
/* Where the camera is: right, down of the middle of the paper, distance from the lenses. */
void lf_shot_eye(const lf_shot *shot, double out[3]);
/* What an eye at a distance sees of the sheet's pitch. */
double lf_shot_visual_lpi(const lf_shot *shot, double distance_mm);

/* A number of a sequence, 0..1. */
double lf_shot_random(uint64_t *state);
/* A usual photo of an upright A4 chart of 60 lpi, 12 MP, different for each seed. */
lf_shot lf_shot_usual(uint64_t seed);

#endif
