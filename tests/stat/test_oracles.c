/* The oracles of light paths on cases whose answers are known: form factors, closed rooms, the
 * energy of a mirror. */
#include "tests/testing.h"

#include "tests/stat/mirror_sun.h"
#include "tests/stat/shaded_room.h"

static void assert_near(double is, double known, double tolerance)
{
    if (!(fabs(is - known) <= tolerance))
        fail_msg("%.12g, not %.12g", is, known);
}

/* A box of side 2 with a plate in the middle; all quads as the caller sets them. */
static lf_room closed_box(double albedo, double emission)
{
    static const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1}, px[3] = {0.4, 0, 0},
                        pz[3] = {0, 0, 0.5};
    lf_room room = {.n_quads = 0};
    lf_shaded_room_add(&room, (double[]){0, -1, 0}, z, x, albedo, 4, 4);
    lf_shaded_room_add(&room, (double[]){0, 1, 0}, x, z, albedo, 4, 4);
    lf_shaded_room_add(&room, (double[]){0, 0, -1}, x, y, albedo, 4, 4);
    lf_shaded_room_add(&room, (double[]){0, 0, 1}, y, x, albedo, 4, 4);
    lf_shaded_room_add(&room, (double[]){-1, 0, 0}, y, z, albedo, 4, 4);
    lf_shaded_room_add(&room, (double[]){1, 0, 0}, z, y, albedo, 4, 4);
    room.shade = room.n_quads;
    lf_shaded_room_add(&room, (double[]){0.1, 0.3, 0}, pz, px, albedo, 2, 2);
    lf_shaded_room_add(&room, (double[]){0.1, 0.3, 0}, px, pz, albedo, 2, 2);
    for (int i = 0; i < room.n_quads; i++)
        room.quads[i].emission = emission;
    return room;
}

static void a_square_above_a_point_has_the_factor_of_the_books(void **state)
{
    (void)state;
    /* a corner of a rectangle a x b at the distance 1 (Howell, configuration 10) */
    lf_room room = {.shade = -1};
    const double a = 0.7, b = 1.9, p[3] = {0, 0, 0}, n[3] = {0, 1, 0};
    lf_shaded_room_add(&room, (double[]){a / 2, 1, b / 2}, (double[]){a / 2, 0, 0},
                       (double[]){0, 0, b / 2}, 0, 1, 1);
    double of_a = a / sqrt(1 + a * a), of_b = b / sqrt(1 + b * b),
           known =
               (of_a * atan(b / sqrt(1 + a * a)) + of_b * atan(a / sqrt(1 + b * b))) / (2 * M_PI);
    assert_near(lf_room_factor(&room, 0, p, n), known, 1e-12);
}

/* Whatever a plate hides of a wall it shows of itself. */
static void factors_of_a_closed_room_add_up_to_1(void **state)
{
    (void)state;
    lf_room room = closed_box(0.5, 0);
    static const double places[4][3] = {{0.3, -1, 0.2},
                                        {-1, 0.9, 0.4},
                                        {0.2, 0.3, 0.1},
                                        {0, 0, -1}},
                        normals[4][3] = {{0, 1, 0}, {1, 0, 0}, {0, -1, 0}, {0, 0, 1}};
    for (int k = 0; k < 4; k++) {
        double sum = 0.0;
        for (int i = 0; i < room.n_quads; i++)
            sum += lf_room_factor(&room, i, places[k], normals[k]);
        assert_near(sum, 1.0, 1e-9);
        room.shade = -1; /* and without its shadow to more */
        sum = 0.0;
        for (int i = 0; i < room.n_quads; i++)
            sum += lf_room_factor(&room, i, places[k], normals[k]);
        room.shade = 6;
        assert_true(k == 2 || sum > 1.001);
    }
}

/* Where everything emits 1 and reflects half, k vertices make pi (1 + 1/2 + ... + 2^-(k - 1)). */
static void a_furnace_of_walls_is_even(void **state)
{
    (void)state;
    const lf_room room = closed_box(0.5, 1);
    const double p[3] = {0.3, -1, 0.2}, n[3] = {0, 1, 0};
    for (int depth = 1; depth <= 4; depth++) {
        lf_radiosity *r = lf_radiosity_solve(&room, 1, depth);
        double known = M_PI * (2.0 - pow(0.5, depth - 1));
        assert_near(lf_radiosity_direct(r, p, n) + lf_radiosity_indirect(r, p, n), known, 1e-9);
        lf_radiosity_free(r);
    }
}

/* Two finenesses extrapolated, as test_shaded_room takes them, against what 6 and 8 gave
 * (QUILTD_LONG=1 finds those again, in half a minute). */
static void the_shaded_room_is_known_to_a_thousandth(void **state)
{
    (void)state;
    static const double known[4] = {0.112863, 0.132847, 0.166525, 0.332880};
    const lf_room room = lf_shaded_room();
    const double n[3] = {0, 0, 1};
    int fine = lf_test_long() ? 8 : 3, coarse = lf_test_long() ? 6 : 2;
    lf_radiosity *r[2] = {lf_radiosity_solve(&room, coarse, LF_SHADED_ROOM_DEPTH),
                          lf_radiosity_solve(&room, fine, LF_SHADED_ROOM_DEPTH)};
    double share = fine * fine / (double)(fine * fine - coarse * coarse);
    for (int i = 0; i < 4; i++) {
        const double p[3] = {0.3, -0.9 + 0.3 * i, -1};
        double is = lf_radiosity_direct(r[0], p, n) + share * lf_radiosity_indirect(r[1], p, n) +
                    (1.0 - share) * lf_radiosity_indirect(r[0], p, n);
        assert_true(fabs(is / known[i] - 1.0) < (lf_test_long() ? 1e-5 : 1e-3));
    }
    lf_radiosity_free(r[0]);
    lf_radiosity_free(r[1]);
}

/* What falls on the wall is what falls on the mirror, times its reflectance. */
static void a_mirror_keeps_the_energy_of_a_sun(void **state)
{
    (void)state;
    static const double angles[3] = {0.0, 0.53, 3.0};
    for (int k = 0; k < 3; k++) {
        lf_mirror_sun sun = lf_mirror_sun_scene(angles[k]);
        double sum = 0.0, step = 0.01;
        sun.rings = 4;
        for (int i = 0; i < 200; i++)
            for (int j = 0; j < 160; j++)
                sum += lf_mirror_sun_reflected(&sun, -0.9 + step * i, -0.8 + step * j);
        assert_true(fabs(sum * step * step / lf_mirror_sun_power(&sun) - 1.0) < 2e-3);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_square_above_a_point_has_the_factor_of_the_books),
        cmocka_unit_test(factors_of_a_closed_room_add_up_to_1),
        cmocka_unit_test(a_furnace_of_walls_is_even),
        cmocka_unit_test(the_shaded_room_is_known_to_a_thousandth),
        cmocka_unit_test(a_mirror_keeps_the_energy_of_a_sun),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
