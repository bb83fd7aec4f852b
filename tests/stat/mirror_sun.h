/* Irradiance of the wall of tests/scenes/sun-off-mirror.json by brute force, in double: it shares
 * nothing with render/. The reflected sun is found by straight lines from a point of the wall to
 * the mirrored sun, one for each part of its disk. The sun may be a texel of a sky picture. */
#ifndef LF_TESTS_MIRROR_SUN_H
#define LF_TESTS_MIRROR_SUN_H

#define LF_MIRROR_SUN_WALL 0.6 /* albedo */
#define LF_MIRROR_SUN_MIRROR 0.8

typedef struct lf_mirror_sun {
    double centre[3], u[3], v[3]; /* mirror: centre + s u + t v, s and t in -1..1 */
    double direction[3];          /* of the sun's light, of any length */
    double irradiance;            /* across it */
    double angle;                 /* diameter of the sun in degrees; 0: a point */
    int rings;                    /* of its disk, of six parts more each */
} lf_mirror_sun;

lf_mirror_sun lf_mirror_sun_scene(double angle);

/* At (x, y) on the wall z = 0: from the sun itself, and through the mirror. */
double lf_mirror_sun_direct(const lf_mirror_sun *scene);
double lf_mirror_sun_reflected(const lf_mirror_sun *scene, double x, double y);

/* The integral of the reflected irradiance over the whole wall, in closed form: exact for a point,
 * to the square of the sun's radius for a disk. */
double lf_mirror_sun_power(const lf_mirror_sun *scene);

/* A black sky picture, 2 rows x rows, with one bright texel. It is looked up bilinearly: the light
 * is a tent two texels wide. */
typedef struct lf_mirror_sky {
    int rows, row, column;
    double radiance; /* at the middle of the texel */
    int parts;       /* of the tent, each way */
} lf_mirror_sky;

/* Such a sky with its texel where the sun of the scene is. */
lf_mirror_sky lf_mirror_sky_scene(void);

/* As above. */
double lf_mirror_sky_direct(const lf_mirror_sky *sky);
double lf_mirror_sky_reflected(const lf_mirror_sun *scene, const lf_mirror_sky *sky, double x,
                               double y);

#endif
