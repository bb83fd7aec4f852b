/* What tiles of single views lack: a brightness that one view alone sees is in no feature, and yet
 * is shown; how far off it is falls as the noise does. */
#include "tests/render/reconstruct_testing.h"
#include "tests/scene_file.h"

#include <math.h>
#include <string.h>

#include "render/reconstruct/residual.h"
#include "render/transport/sampler.h"

enum { width = 32, height = 32, views = 9, SEEDS = 4, LEVELS = 3 };
/* Of the last view: bright. */
enum { from = 8, to = 16 };

static bool is_bright(int row, int view, int column)
{
    return view == views - 1 && row >= from && row < to && column >= from && column < to;
}

static float uniform(uint64_t salt, int row, int half, int i)
{
    uint64_t place = (uint64_t)((row * 2 + half) * views * width + i);
    return (float)(lf_hash64(lf_hash64(lf_test_seed(), salt), place) >> 40) * 0x1p-24f;
}

/* In place of what was found: N = R W times a noise of the mean 1, R = 1 and `bright` of the last
 * view's middle; nothing else is known. */
static void make_film(lf_renderer *r, float bright, float noise, uint64_t salt)
{
    for (int row = 0; row < height; row++) {
        lf_film_known *known = lf_film_known_at(&r->film, row);
        for (int h = 0; h < 2; h++) {
            const lf_film_half half = lf_film_at(&r->film, row, h);
            for (int i = 0; i < views * width; i++) {
                const float truth = is_bright(row, i / width, i % width) ? bright : 1.0f,
                            off = noise * sqrtf(3.0f) * (2.0f * uniform(salt, row, h, i) - 1.0f);
                half.scattered[i].w = (float)r->film.rows[row].n[h] * half.q[i];
                if (half.w2)
                    half.w2[i] = half.scattered[i].w;
                for (int c = 0; c < 3; c++)
                    half.scattered[i].n[c] = truth * (1.0f + off) * half.scattered[i].w;
            }
        }
        for (int i = 0; known && i < views * width; i++)
            memset(known[i].b, 0, sizeof known[i].b);
    }
}

/* The mean of the middle of a view over the truth, less 1. */
static double off_by(const float *x, int view, double truth)
{
    double sum = 0.0;
    for (int row = from; row < to; row++)
        for (int column = from; column < to; column++)
            sum += (double)x[3 * ((row * views + view) * width + column)];
    return sum / ((to - from) * (to - from)) / truth - 1.0;
}

static float *shown(lf_renderer *r)
{
    float *x = malloc((size_t)3 * width * height * views * sizeof *x);
    assert_non_null(x);
    lf_assert_ok(lf_renderer_show(r, x, NULL), NULL);
    return x;
}

static lf_renderer *wall(void)
{
    lf_renderer *r = reconstruct_renderer(lf_test_scene_text("metal-wall"), width, height, NULL);
    reconstruct_visits(r, NULL, 4);
    return r;
}

/* Without noise. */
static void what_one_view_alone_sees_is_shown(void **state)
{
    (void)state;
    lf_renderer *r = wall();
    make_film(r, 1.5f, 0.0f, 0);
    float *x = shown(r);
    print_message("bright tile off by %.4f, others by %.4f and %.4f\n", off_by(x, views - 1, 1.5),
                  off_by(x, views - 2, 1.0), off_by(x, 0, 1.0));
    assert_true(fabs(off_by(x, views - 1, 1.5)) < 0.01);
    assert_true(fabs(off_by(x, views - 2, 1.0)) < 0.01);
    assert_true(fabs(off_by(x, 0, 1.0)) < 0.01);
    free(x);
    lf_renderer_destroy(r);
}

/* A sixteenth of the noise is a sixteenth of the error (n^-0.5), with half as much more for chance.
 * Measured: 0.22, 0.066, 0.0094; with what tiles lack left out 0.31, 0.27, 0.20. */
static void a_tile_converges_as_its_noise_does(void **state)
{
    (void)state;
    lf_renderer *r = wall();
    double rms[LEVELS];
    for (int l = 0; l < LEVELS; l++) {
        double sum = 0.0;
        for (uint64_t k = 0; k < SEEDS; k++) {
            make_film(r, 1.5f, powf(0.25f, (float)l), k);
            float *x = shown(r);
            sum += pow(off_by(x, views - 1, 1.5), 2.0);
            free(x);
        }
        rms[l] = sqrt(sum / SEEDS);
        print_message("noise %.4f: tile off by %.4f\n", pow(0.25, l), rms[l]);
    }
    assert_true(rms[2] < rms[0] / 16.0 * 1.5);
    lf_renderer_destroy(r);
}

/* No tile lacks anything where the picture is what was found. */
static void what_is_right_is_left_alone(void **state)
{
    (void)state;
    float times[width][3];
    lf_renderer *r = wall();
    make_film(r, 1.0f, 0.0f, 0);
    lf_assert_ok(lf_renderer_fit(r, NULL), NULL);
    for (int row = 0; row < height; row++)
        for (int k = 0; k < views; k++)
            if (lf_residual_row(r->shown, row, k, LF_BOTH, times))
                for (int i = 0; i < width; i++)
                    assert_true(fabsf(times[i][0] - 1.0f) < 1e-4f);
    lf_renderer_destroy(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_one_view_alone_sees_is_shown),
        cmocka_unit_test(a_tile_converges_as_its_noise_does),
        cmocka_unit_test(what_is_right_is_left_alone),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
