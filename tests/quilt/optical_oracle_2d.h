/* What an eye anywhere in front of a lens sheet sees, from optics alone: the ray from the eye to a
 * point on top of a lens, Snell's law in three dimensions, and the mean light of the print about
 * the point that the ray hits. The lenses are cylinders in any direction, or spherical ones on a
 * square or hexagonal grid. Shares no code with what makes the print. Millimetres; x to the right
 * and y down from the middle of the print, distances in front of it. */
#ifndef LF_TESTS_QUILT_OPTICAL_ORACLE_2D_H
#define LF_TESTS_QUILT_OPTICAL_ORACLE_2D_H

typedef enum lf_lenslets { LF_CYLINDERS, LF_SQUARE_LENSLETS, LF_HEXAGON_LENSLETS } lf_lenslets;

typedef struct lf_sheet_2d {
    lf_lenslets kind;
    double pitch_mm; /* mechanical */
    double thickness_mm, index;
    double axis_deg; /* clockwise: of cylinders from upright, of a grid from its upright position */
    double x0_mm;    /* offset of lens 0, across cylinders or along the rows of a grid */
    double y0_mm;    /* grids: down them */
} lf_sheet_2d;

typedef struct lf_eye {
    double x, y, distance;
} lf_eye;

/* Light of a raster whose middle is at the origin; pixels are boxes. Outside it is the edge's. */
typedef struct lf_raster_light {
    int width, height;
    double right_mm, down_mm; /* size of a pixel */
    const double *light;      /* [height][width] */
} lf_raster_light;

/* The point on top of lens i (of row j) at this place along its axis; grids: its middle. */
void lf_lens_top(const lf_sheet_2d *sheet, int i, int j, double along_mm, double out[2]);
/* The point of the print that the eye sees through a point on top of a lens. */
void lf_print_point(const lf_sheet_2d *sheet, const lf_eye *eye, const double top[2],
                    double out[2]);
/* The mean light of a spot of this width about a point: across a cylinder, both ways in a grid. */
double lf_spot_light(const lf_sheet_2d *sheet, const lf_raster_light *raster, const double at[2],
                     double spot_mm);

#endif
