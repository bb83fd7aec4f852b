/* The albedo that a film keeps of textured surfaces, and what the reconstruction makes of it. */
#include "tests/render/added.h"
#include "tests/render/reconstruct_testing.h"
#include "tests/scene_file.h"

#include "base/file.h"
#include "base/image_io.h"
#include "render/scene/texture.h"
#include "render/transport/path/face_albedo.h"
#include "render/transport/sampler.h"
#include "render/transport/surface/surface_texture.h"

enum { N = LF_ALBEDO_NUMBERS, METAL = LF_ALBEDO_METAL };

/* Of a colour in [0, 1]: a step of its root. Of metal: a step. */
static double step_of(int number, double x)
{
    return number == METAL ? 1.0 / 31.0 : 2.0 * sqrt(x) / 511.0 + 1.0 / (511.0 * 511.0);
}

/* -------------------------------------------------------------------------------------- film -- */

static void packing_rounds_to_a_neighbour_and_keeps_the_mean(void **state)
{
    (void)state;
    enum { TIMES = 4096 };
    for (int v = 0; v <= 50; v++) {
        const float x = (float)v / 50.0f, albedo[N] = {x, x * x, 1.0f - x, x};
        double root[N] = {0};
        for (int i = 0; i < TIMES; i++) {
            float out[N];
            lf_albedo_unpack(lf_albedo_pack(albedo, (uint32_t)(lf_hash64(1, (uint64_t)i) >> 32)),
                             out);
            for (int c = 0; c < N; c++) {
                lf_assert_close((double)out[c], (double)albedo[c], 0.0,
                                step_of(c, (double)albedo[c]) + 1e-6);
                root[c] += (c == METAL ? (double)out[c] : sqrt((double)out[c])) / TIMES;
            }
        }
        /* what is rounded has no bias: five deviations of a mean of numbers 0 or 1 step apart */
        for (int c = 0; c < N; c++) {
            double step = c == METAL ? 1.0 / 31.0 : 1.0 / 511.0,
                   truth = c == METAL ? (double)albedo[c] : sqrt((double)albedo[c]);
            lf_assert_close(root[c], truth, 0.0, 5.0 * 0.5 * step / sqrt(TIMES) + 1e-6);
        }
    }
}

static const lf_film_layout layout = {
    .n_views = 1, .width = 8, .height = 1, .has_features = true, .has_albedo = true};

static void visit(lf_film *film, lf_film_sums *sums, int half, float q, const float albedo[N])
{
    lf_film_sums_begin(sums);
    for (size_t i = 0; i < 8; i++) {
        lf_film_pivots(sums, i, q);
        lf_film_note(sums, i, (lf_feature){1.0f, 0.0f, 1.0f, 0.0f});
        lf_film_note_albedo(sums, i, albedo);
    }
    lf_film_merge(film, 0, 0, half, sums, 1.0, lf_hash64(film->rows[0].visits[half], 5));
}

static void begin(lf_film *film, lf_film_sums *sums, uint64_t seed)
{
    int stream;
    *film = (lf_film){0};
    lf_assert_ok(lf_film_init(film, &layout), NULL);
    lf_assert_ok(lf_film_sums_init(sums, &layout), NULL);
    lf_assert_ok(lf_film_stream_at(film, seed, 0, &stream), NULL);
}

static void end(lf_film *film, lf_film_sums *sums)
{
    lf_film_sums_finish(sums);
    lf_film_finish(film);
}

static const float dark[N] = {0.04f, 0.09f, 0.25f, 0.0f}, bright[N] = {0.8f, 0.64f, 0.49f, 1.0f};

/* Both halves together, and what meets nothing says nothing. */
static void it_is_a_mean_weighted_by_q(void **state)
{
    (void)state;
    lf_film film;
    lf_film_sums sums;
    float out[N];
    begin(&film, &sums, 1);
    visit(&film, &sums, 0, 0.6f, dark);
    visit(&film, &sums, 1, 0.2f, bright);
    visit(&film, &sums, 1, 0.0f, (const float[N]){1.0f, 1.0f, 1.0f, 0.5f});
    visit(&film, &sums, 0, -0.3f, (const float[N]){1.0f, 1.0f, 1.0f, 0.5f});
    for (size_t i = 0; i < 8; i++) {
        lf_albedo_unpack(lf_film_albedo_at(&film, 0)[i], out);
        for (int c = 0; c < N; c++) {
            double mean = 0.75 * (double)dark[c] + 0.25 * (double)bright[c];
            lf_assert_close((double)out[c], mean, 0.0, 2.0 * step_of(c, 1.0));
        }
    }
    end(&film, &sums);
}

static void the_first_visits_of_a_row_say_it(void **state)
{
    (void)state;
    lf_film film;
    lf_film_sums sums;
    begin(&film, &sums, 1);
    for (int v = 0; v < LF_ALBEDO_VISITS; v++) {
        assert_true(lf_film_wants_albedo(&film, 0));
        visit(&film, &sums, v % 2, 0.5f, dark);
    }
    assert_false(lf_film_wants_albedo(&film, 0));
    const lf_packed_albedo known = lf_film_albedo_at(&film, 0)[3];
    visit(&film, &sums, 0, 0.5f, bright);
    assert_int_equal(lf_film_albedo_at(&film, 0)[3], known);
    end(&film, &sums);
}

static void films_that_are_added_have_the_mean_of_both(void **state)
{
    (void)state;
    lf_film a, b;
    lf_film_sums sums;
    float out[N];
    lf_error err;
    begin(&a, &sums, 1);
    visit(&a, &sums, 0, 0.6f, dark);
    lf_film_sums_finish(&sums);
    begin(&b, &sums, 2);
    visit(&b, &sums, 0, 0.2f, bright);
    lf_assert_ok(added_film(&a, &b, &err), &err);
    lf_albedo_unpack(lf_film_albedo_at(&a, 0)[0], out);
    for (int c = 0; c < N; c++)
        lf_assert_close((double)out[c], 0.75 * (double)dark[c] + 0.25 * (double)bright[c], 0.0,
                        2.0 * step_of(c, 1.0));
    lf_film_finish(&b);
    end(&a, &sums);
}

/* ------------------------------------------------------------------------------------ scenes -- */

enum { SIDE = 8, WIDTH = 48, HEIGHT = 36, VIEWS = 3, VALUES = 3 * WIDTH * HEIGHT * VIEWS };

static char *folder;

static uint8_t code_at(int x, int y, int c)
{
    return (uint8_t)((x + y) % 2 ? 60 + 20 * c : 230 - 30 * c);
}

static int make_picture(void **state)
{
    (void)state;
    lf_image8 image;
    lf_outfile file = {.fd = -1};
    lf_error err;
    folder = lf_test_folder();
    lf_assert_ok(lf_image8_init(&image, SIDE, SIDE, 3), NULL);
    for (int y = 0; y < SIDE; y++)
        for (int i = 0; i < 3 * SIDE; i++)
            image.data[(size_t)y * image.stride + (size_t)i] = code_at(i / 3, y, i % 3);
    lf_assert_ok(lf_outfile_open(&file, lf_test_path(folder, "checker.png"), true, &err), &err);
    lf_assert_ok(lf_png_write(&file, &image, 1, NULL, 0, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_image8_finish(&image);
    return 0;
}

static int remove_picture(void **state)
{
    (void)state;
    lf_test_folder_remove(folder);
    return 0;
}

/* A matt wall that fills the picture, lit by a lamp. */
#define WALL(albedo)                                                                               \
    lf_test_scene_patched("painted-wall", "{'materials': {'paint': {'albedo': " albedo "}}}")
#define CHECKER "{ 'file': 'checker.png' }"

static float *picture(void)
{
    float *x = malloc(VALUES * sizeof *x);
    assert_non_null(x);
    return x;
}

/* After two visits the checker's wall is known as well as a white one; a fit that did not know its
 * colours would smear them, and could be no better than what is not filtered. */
static void a_texture_is_as_sharp_as_its_picture(void **state)
{
    (void)state;
    double error[2];
    const char *const walls[] = {WALL("0.7"), WALL(CHECKER)};
    for (int i = 0; i < 2; i++) {
        lf_renderer *r =
            reconstruct_renderer_of(lf_test_scene_in(folder, walls[i], NULL), WIDTH, HEIGHT, NULL);
        float *truth = picture(), *shown = picture(), *raw = picture();
        assert_true(r->film.layout.has_albedo == (i == 1));
        reconstruct_visits(r, NULL, 2);
        lf_assert_ok(lf_renderer_show(r, shown, NULL), NULL);
        lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, raw, NULL), NULL);
        lf_test_reseed(r, lf_test_seed() + 1000000);
        lf_test_cycles(r, 100);
        lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_CV, truth, NULL), NULL);
        error[i] = lf_test_rel_mse(shown, truth, VALUES);
        print_message("%s wall: shown %.2g, unfiltered %.2g\n", i ? "checker" : "white", error[i],
                      lf_test_rel_mse(raw, truth, VALUES));
        assert_true(error[i] < 0.3 * lf_test_rel_mse(raw, truth, VALUES));
        free(truth);
        free(shown);
        free(raw);
        lf_renderer_destroy(r);
    }
    assert_true(error[1] < 2.0 * error[0]);
}

/* A textured sheet of alpha 0.4 among other veils before a white wall, and the same sheet when it
 * hides all behind it and nothing is before it: of the same points, the first has its share of what
 * the second has. Neither the file nor the tree of the section has them in their order. */

static void a_alpha_has_its_share_of_albedo(void **state)
{
    (void)state;
    lf_renderer *r[2];
    const char *const sheets[] = {lf_test_scene_patched("textured-sheet",
                                                        "{'meshes': {'a': null, 'b': null}, "
                                                        "'materials': {'paint': {'alpha': 1}}}"),
                                  lf_test_scene_text("textured-sheet")};
    double n = 0.0, apart = 0.0;
    for (int i = 0; i < 2; i++) {
        r[i] =
            reconstruct_renderer_of(lf_test_scene_in(folder, sheets[i], NULL), WIDTH, HEIGHT, NULL);
        reconstruct_visits(r[i], NULL, 1);
    }
    for (int row = 0; row < HEIGHT; row++)
        for (int k = 0; k < WIDTH * VIEWS; k++) {
            float sheet[N], both[N];
            lf_albedo_unpack(lf_film_albedo_at(&r[0]->film, row)[k], sheet);
            lf_albedo_unpack(lf_film_albedo_at(&r[1]->film, row)[k], both);
            for (int c = 0; c < 3; c++) {
                const double behind = 0.25 * 0.3 + 0.75 * 0.7,
                             truth = 0.5 * 0.2 + 0.5 * (0.4 * (double)sheet[c] + 0.6 * behind);
                lf_assert_close((double)both[c], truth, 0.0, 3.0 * step_of(c, 1.0));
                apart += fabs((double)sheet[c] - 0.7);
                n += 1.0;
            }
        }
    assert_true(apart / n > 0.05); /* a texture is there to be seen */
    for (int i = 0; i < 2; i++)
        lf_renderer_destroy(r[i]);
}

/* What a hit finds that looks everything up, and a face that is quick. */
static void a_face_says_what_a_hit_does(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene_in(
        folder,
        WALL("{ 'file': 'checker.png', 'transform': { 'scale': [1.5, 0.7], 'rotate': 20 } }"),
        NULL);
    const lf_mesh *mesh = &scene->meshes[0];
    for (uint32_t t = 0; t < (uint32_t)mesh->n_triangles; t++) {
        lf_face face;
        lf_face_albedo albedo;
        lf_face_init(&face, scene, 0, t);
        lf_face_albedo_init(&albedo, &face);
        const uint32_t *corner = mesh->triangles + 3 * (size_t)t;
        for (int i = 0; i < 200; i++) {
            float u = (float)(lf_hash64(t, (uint64_t)i) >> 40) * 0x1p-24f,
                  v = (1.0f - u) * (float)(lf_hash64(t + 9, (uint64_t)i) >> 40) * 0x1p-24f, out[N];
            lf_vec3 a = lf_mesh_vertex(mesh, corner[0]), b = lf_mesh_vertex(mesh, corner[1]),
                    c = lf_mesh_vertex(mesh, corner[2]),
                    p = lf_madd(lf_madd(a, u, lf_sub(b, a)), v, lf_sub(c, a));
            lf_hit hit;
            lf_face_hit(&face, p, lf_v3(0.0f, 0.0f, -1.0f), &hit);
            lf_hit_vary(&hit, 1e-4f);
            lf_face_albedo_at(&albedo, &face, p, 1e-4f, out);
            const float truth[3] = {hit.own.albedo.x, hit.own.albedo.y, hit.own.albedo.z};
            for (int k = 0; k < 3; k++)
                lf_assert_close((double)out[k], (double)truth[k], 0.0, 2e-4);
            assert_true(out[METAL] == 0.0f);
        }
    }
    lf_scene_unref(scene);
}

/* A level of the pyramid is at most half a level from what is asked for: within it, the look-up
 * that is exact between two levels lies between those. */
static void a_glance_takes_the_nearest_level(void **state)
{
    (void)state;
    uint8_t rgba[64 * 64 * 4];
    lf_pyramid p;
    for (size_t i = 0; i < sizeof rgba; i++)
        rgba[i] = (uint8_t)(lf_hash64(4, i) >> 56);
    const lf_texels texels = {64, 64, rgba};
    const lf_texture t = {.picture = 1, .map = {{1, 0, 0}, {0, 1, 0}}, .scale = 1};
    lf_assert_ok(lf_pyramid_make(&texels, LF_TEXELS_COLOURS, 0.5f, &p), NULL);
    for (int i = 0; i < 500; i++) {
        float x = 3.0f * (float)(lf_hash64(1, (uint64_t)i) >> 40) * 0x1p-24f - 1.0f,
              y = 3.0f * (float)(lf_hash64(2, (uint64_t)i) >> 40) * 0x1p-24f - 1.0f, seen[3],
              exact[4];
        for (int level = 0; level < 7; level++)
            for (int off = -1; off <= 1; off++) {
                /* 0.45 of a level to either side is still nearest to it */
                float texels2 = exp2f(2.0f * ((float)level + 0.45f * (float)off));
                lf_texture_glance(&t, &p, x, y, texels2, seen);
                lf_texture_look_up(&t, &p, x, y, (float)level, exact);
                for (int c = 0; c < 3; c++)
                    lf_assert_close((double)seen[c], (double)exact[c], 0.0, 2e-5);
            }
    }
    /* without interpolation */
    const lf_texture sharp = {.picture = 1, .map = {{1, 0, 0}, {0, 1, 0}}, .nearest = true};
    for (int i = 0; i < 500; i++) {
        float x = (float)(lf_hash64(1, (uint64_t)i) >> 40) * 0x1p-24f,
              y = (float)(lf_hash64(2, (uint64_t)i) >> 40) * 0x1p-24f, seen[3], exact[4];
        lf_texture_glance(&sharp, &p, x, y, 0.01f, seen);
        lf_texture_look_up(&sharp, &p, x, y, -3.0f, exact);
        assert_memory_equal(seen, exact, sizeof seen);
    }
    lf_pyramid_finish(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packing_rounds_to_a_neighbour_and_keeps_the_mean),
        cmocka_unit_test(it_is_a_mean_weighted_by_q),
        cmocka_unit_test(the_first_visits_of_a_row_say_it),
        cmocka_unit_test(films_that_are_added_have_the_mean_of_both),
        cmocka_unit_test(a_texture_is_as_sharp_as_its_picture),
        cmocka_unit_test(a_alpha_has_its_share_of_albedo),
        cmocka_unit_test(a_face_says_what_a_hit_does),
        cmocka_unit_test(a_glance_takes_the_nearest_level),
    };
    return cmocka_run_group_tests(tests, make_picture, remove_picture);
}
