#include "tests/stat/fixture.h"

#include "tests/scene_file.h"

static lf_pool *own_pool;

lf_scene *lf_test_scene(const char *text)
{
    return lf_test_scene_in(".", text, NULL);
}

lf_scene *lf_test_scene_in(const char *folder, const char *text, const lf_scene *previous)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    json_t *doc = lf_test_json("test.json", text);
    if (lf_scene_from_json(doc, folder, "test.json", NULL, previous, &scene, &err) != LF_OK)
        fail_msg("%s: %s", err.pointer, err.what);
    json_decref(doc);
    return scene;
}

void lf_test_assert_refused(const char *folder, const char *text, const char *pointer,
                            const char *words)
{
    lf_scene *scene = NULL;
    lf_error err = {0};
    json_t *doc = lf_test_json("test", text);
    lf_assert_status(lf_scene_from_json(doc, folder, "test", NULL, NULL, &scene, &err), LF_E_FORMAT,
                     &err);
    json_decref(doc);
    assert_string_equal(err.pointer, pointer);
    if (!strstr(err.what, words))
        fail_msg("%s", err.what);
}

static int light_paths;

void lf_test_light_paths(int n)
{
    light_paths = n;
}

static struct {
    int n;
    bool one_light, early_roulette;
} suffixes;

void lf_test_suffixes(int n, bool one_light, bool early_roulette)
{
    suffixes.n = n;
    suffixes.one_light = one_light;
    suffixes.early_roulette = early_roulette;
}

lf_renderer *lf_test_renderer(lf_scene *scene, const char *integrator, int width, int height,
                              lf_pool *pool)
{
    lf_renderer *renderer = NULL;
    lf_error err = {0};
    lf_render_settings settings = {.skip = LF_SKIP_ALL,
                                   .camera = *lf_scene_camera(scene),
                                   .width = width,
                                   .height = height,
                                   .integrator = integrator,
                                   .light_paths = light_paths,
                                   .suffixes = suffixes.n,
                                   .one_light = suffixes.one_light,
                                   .early_roulette = suffixes.early_roulette};
    settings.seed = lf_test_seed();
    if (!pool && !own_pool)
        lf_assert_ok(lf_pool_create(2, &own_pool), NULL);
    pool = pool ? pool : own_pool;
    if (lf_renderer_create(scene, &settings, pool, &renderer, &err) != LF_OK)
        fail_msg("%s: %s", err.where, err.what);
    return renderer;
}

int lf_test_finish(void **state)
{
    (void)state;
    lf_pool_destroy(own_pool);
    own_pool = NULL;
    return 0;
}

void lf_test_reseed(lf_renderer *renderer, uint64_t seed)
{
    lf_render_settings settings = *lf_renderer_settings(renderer);
    settings.seed = seed;
    assert_int_equal(lf_renderer_restart(renderer, lf_renderer_scene(renderer), &settings, NULL),
                     LF_OK);
}

void lf_test_same_films(const lf_renderer *a, const lf_renderer *b)
{
    for (int row = 0; row < a->film.height; row++)
        assert_memory_equal(a->film.data + (size_t)row * a->film.row_bytes,
                            b->film.data + (size_t)row * b->film.row_bytes,
                            lf_film_used_bytes(&a->film.layout));
}

void lf_test_passes(lf_renderer *renderer, int64_t n_passes)
{
    assert_int_equal(lf_renderer_passes(renderer, NULL, n_passes, true, NULL, NULL, NULL), LF_OK);
}

double *lf_test_picture_by(lf_scene *scene, int width, int height, int threads)
{
    lf_pool *pool = NULL;
    assert_int_equal(lf_pool_create(threads, &pool), LF_OK);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, pool);
    for (int i = 0; i < 4; i++)
        assert_int_equal(lf_renderer_pass_filling(r, NULL, 1, 2, NULL, NULL, NULL), LF_OK);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_MWIS);
    lf_renderer_destroy(r);
    lf_pool_destroy(pool);
    return picture;
}

void lf_test_cycles(lf_renderer *r, int n)
{
    lf_test_passes(r, (int64_t)n * r->film.n_views);
}

double *lf_test_picture(const lf_renderer *renderer, lf_estimator estimator)
{
    const lf_render_settings *s = lf_renderer_settings(renderer);
    size_t n = (size_t)s->camera.n_views * (size_t)s->width * (size_t)s->height;
    float *rgb = malloc(3 * n * sizeof *rgb);
    double *out = malloc(n * sizeof *out);
    assert_non_null(rgb);
    assert_non_null(out);
    assert_int_equal(lf_renderer_resolve(renderer, estimator, rgb, NULL), LF_OK);
    for (size_t i = 0; i < n; i++)
        out[i] =
            0.5 * (double)rgb[3 * i] + 0.3 * (double)rgb[3 * i + 1] + 0.2 * (double)rgb[3 * i + 2];
    free(rgb);
    return out;
}

double lf_test_rel_mse(const float *values, const float *truth, size_t n)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++) {
        double t = (double)truth[i], d = (double)values[i] - t;
        sum += d * d / (t * t + 1e-2);
    }
    return sum / (double)n;
}

void lf_blocks_init(lf_blocks *b, int n_views, int width, int height, int block)
{
    int across = (width + block - 1) / block, down = (height + block - 1) / block;
    *b =
        (lf_blocks){n_views, width, height, block, across, n_views * across * down + 1, NULL, NULL};
    b->moments = calloc((size_t)b->n, sizeof *b->moments);
    b->last = calloc((size_t)b->n, sizeof *b->last);
    assert_non_null(b->moments);
    assert_non_null(b->last);
}

void lf_blocks_finish(lf_blocks *b)
{
    free(b->moments);
    free(b->last);
    *b = (lf_blocks){0};
}

static void block_means(const lf_blocks *b, const double *picture, double *out)
{
    int down = (b->n - 1) / b->n_views / b->across;
    double *pixels = calloc((size_t)b->n, sizeof *pixels);
    memset(out, 0, (size_t)b->n * sizeof *out);
    for (int row = 0; row < b->height; row++) {
        for (int view = 0; view < b->n_views; view++) {
            for (int column = 0; column < b->width; column++) {
                int i = (view * down + row / b->block) * b->across + column / b->block;
                double x = *picture++;
                /* NaN would pass every comparison of p-values. */
                if (!isfinite(x))
                    fail_msg("view %d, row %d, column %d: %g", view, row, column, x);
                out[i] += x;
                pixels[i] += 1.0;
                out[b->n - 1] += x;
                pixels[b->n - 1] += 1.0;
            }
        }
    }
    for (int i = 0; i < b->n; i++)
        out[i] /= pixels[i];
    free(pixels);
}

void lf_blocks_add(lf_blocks *b, const double *picture)
{
    block_means(b, picture, b->last);
    for (int i = 0; i < b->n; i++)
        lf_moments_add(&b->moments[i], b->last[i]);
}

void lf_blocks_add_picture(lf_blocks *b, const lf_renderer *renderer, lf_estimator estimator)
{
    double *picture = lf_test_picture(renderer, estimator);
    lf_blocks_add(b, picture);
    free(picture);
}

void lf_blocks_mirror(lf_blocks *b)
{
    int per_view = (b->n - 1) / b->n_views, down = per_view / b->across;
    lf_moments *flipped = malloc((size_t)b->n * sizeof *flipped);
    assert_int_equal(b->width % b->block, 0);
    for (int view = 0; view < b->n_views; view++) {
        for (int i = 0; i < per_view; i++) {
            int from = ((b->n_views - 1 - view) * down + i / b->across) * b->across + b->across -
                       1 - i % b->across;
            flipped[view * per_view + i] = b->moments[from];
        }
    }
    flipped[b->n - 1] = b->moments[b->n - 1];
    free(b->moments);
    b->moments = flipped;
}

/* The truth moved towards the estimate by no more than rounding may. */
static double nearest_truth(double truth, double mean, double rounding)
{
    double d = rounding * fabs(truth);
    return fmin(fmax(mean, truth - d), truth + d);
}

double lf_blocks_p(const lf_blocks *b, const double *truth, double rounding, int *out_where)
{
    double *means = calloc((size_t)b->n, sizeof *means), least = 2.0;
    block_means(b, truth, means);
    for (int i = 0; i < b->n; i++) {
        double p = lf_p_mean(&b->moments[i], nearest_truth(means[i], b->moments[i].mean, rounding));
        if (out_where && p < least)
            *out_where = i;
        least = p < least ? p : least;
    }
    free(means);
    return least;
}

double lf_blocks_p_zero(const lf_blocks *b, int *out_where)
{
    double *zero = calloc((size_t)b->n_views * (size_t)b->width * (size_t)b->height, sizeof *zero);
    double p = lf_blocks_p(b, zero, 0.0, out_where);
    free(zero);
    return p;
}

double lf_blocks_welch(const lf_blocks *a, const lf_blocks *b, int *out_where)
{
    double least = 2.0;
    for (int i = 0; i < a->n; i++) {
        double p = lf_p_welch(&a->moments[i], &b->moments[i]);
        if (out_where && p < least)
            *out_where = i;
        least = p < least ? p : least;
    }
    return least;
}

double lf_blocks_welch_injected(const lf_blocks *a, const lf_blocks *b, int which, double factor)
{
    lf_moments m = a->moments[which];
    m.mean *= factor;
    return lf_p_welch(&m, &b->moments[which]);
}

void lf_test_slopes(const lf_renderer *renderer, int view, double column, double row,
                    double *out_mx, double *out_my)
{
    const lf_rig *rig = &lf_test_rows(renderer)->rig;
    *out_mx =
        ((double)rig->x0 + column * (double)rig->dx - (double)rig->b[view]) / (double)rig->distance;
    *out_my = ((double)rig->y0 + row * (double)rig->dy) / (double)rig->distance;
}

/* Sums over both halves of one view pixel. */
static void weight_sums(const lf_renderer *r, int row, int pixel, bool second, double *out_w,
                        double *out_q)
{
    const lf_film_row *state = &r->film.rows[row];
    *out_w = *out_q = 0.0;
    for (int h = 0; h < 2; h++) {
        if (state->n[h] == 0.0)
            continue;
        lf_film_half half = lf_film_at(&r->film, row, h);
        *out_w += (double)(second && half.w2 ? half.w2[pixel] : half.scattered[pixel].w);
        *out_q += state->n[h] * (double)half.q[pixel];
    }
}

void lf_test_weights(const lf_renderer *r, bool second, double *out_difference, double *out_q)
{
    for (int row = 0; row < r->film.height; row++) {
        int pixels = r->film.n_views * r->film.width;
        double n = r->film.rows[row].n[0] + r->film.rows[row].n[1];
        for (int i = 0; i < pixels; i++) {
            double w, q;
            weight_sums(r, row, i, second, &w, &q);
            out_difference[row * pixels + i] = (w - q) / n;
            out_q[row * pixels + i] = q / n;
        }
    }
}

void lf_test_weight_blocks(lf_renderer *r, lf_test_schedule schedule, int replicates, int block,
                           lf_blocks blocks[3])
{
    const lf_film *film = &r->film;
    size_t pixels = (size_t)film->n_views * (size_t)film->width * (size_t)film->height;
    double *d = malloc(pixels * sizeof *d), *q = malloc(pixels * sizeof *q);
    for (int i = 0; i < 3; i++)
        lf_blocks_init(&blocks[i], film->n_views, film->width, film->height, block);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
        schedule(r);
        for (int second = 0; second < 2; second++) {
            lf_test_weights(r, second, d, q);
            lf_blocks_add(&blocks[second], d);
        }
        lf_blocks_add(&blocks[2], q);
    }
    free(q);
    free(d);
}

/* Smallest p of "the difference is 0", a millionth of q being left to rounding. */
static double least_p(const lf_blocks *difference, const lf_blocks *q, int *out_where)
{
    double least = 2.0;
    for (int i = 0; i < q->n; i++) {
        double slack = 1e-6 * q->moments[i].mean, mean = difference->moments[i].mean;
        double p = lf_p_mean(&difference->moments[i], fmin(fmax(mean, -slack), slack));
        if (p < least)
            *out_where = i;
        least = p < least ? p : least;
    }
    return least;
}

void lf_test_assert_weights(const char *text, int width, int height, lf_test_schedule schedule,
                            int replicates, int block, double level)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_render_stats stats;
    lf_blocks blocks[3];
    lf_test_weight_blocks(r, schedule, replicates, block, blocks);
    lf_renderer_stats(r, &stats);
    assert_true(stats.nonfinite_dropped == 0);
    for (int second = 0; second < 2; second++) {
        int where = 0;
        double p = least_p(&blocks[second], &blocks[2], &where);
        if (!(p > level))
            fail_msg("W%s/n - q is %.3g +- %.2g in block %d where q is %.3g: p %.2g",
                     second ? "'" : "", blocks[second].moments[where].mean,
                     lf_moments_error(&blocks[second].moments[where]), where,
                     blocks[2].moments[where].mean, p);
    }
    for (int i = 0; i < 3; i++)
        lf_blocks_finish(&blocks[i]);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

void lf_test_pictures(lf_renderer *r, lf_test_schedule schedule, lf_estimator estimator,
                      int replicates, uint64_t salt, int block, lf_blocks *out)
{
    lf_blocks_init(out, r->film.n_views, r->film.width, r->film.height, block);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        schedule(r);
        lf_blocks_add_picture(out, r, estimator);
    }
}

void lf_test_sampled_pictures(lf_renderer *r, int n_samples, int replicates, uint64_t salt,
                              int block, lf_blocks *out)
{
    lf_blocks_init(out, r->film.n_views, r->film.width, r->film.height, block);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        lf_test_cycles(r, n_samples);
        lf_blocks_add_picture(out, r, LF_ESTIMATOR_MIS);
    }
}

void lf_test_pictures_of(lf_scene *scene, const char *integrator, int width, int height,
                         lf_test_schedule schedule, uint64_t salt, int block, lf_blocks *out)
{
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    lf_test_pictures(r, schedule, LF_ESTIMATOR_MIS, 12, salt, block, out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

void lf_test_two_answers(lf_scene *scene, const char *integrator, int width, int height, int block,
                         uint64_t salt, lf_blocks out[2])
{
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    for (int i = 0; i < 2; i++)
        lf_blocks_init(&out[i], r->film.n_views, width, height, block);
    for (int k = 0; k < (lf_test_long() ? 48 : 12); k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        lf_test_passes(r, 18);
        lf_blocks_add_picture(&out[0], r, LF_ESTIMATOR_MIS);
        lf_blocks_add_picture(&out[1], r, LF_ESTIMATOR_CV);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

void lf_test_assert_answers(lf_blocks seen[2], const lf_blocks *truth, double level, bool same)
{
    for (int i = 0; i < 2; i++) {
        int where = 0;
        double p = lf_blocks_welch(&seen[i], truth, &where);
        print_message("tile %d: %.5f +- %.5f, truth %.5f +- %.5f, p %.2g\n", where,
                      seen[i].moments[where].mean, lf_moments_error(&seen[i].moments[where]),
                      truth->moments[where].mean, lf_moments_error(&truth->moments[where]), p);
        assert_int_equal(p > level, same);
        lf_blocks_finish(&seen[i]);
    }
}
