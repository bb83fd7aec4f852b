/* Cameras listed one by one (render/cameras/any_cameras.h): points land where a pinhole's own words
 * say; the densities that weights are made of are those of a rectified rig, to 1e-5, where the list
 * is one; pictures by the general way and by rows agree, tile by tile, and W is n q everywhere;
 * pictures do not depend on the number of threads. */
#include "tests/testing.h"

#include "render/cameras/pinhole.h"
#include "render/renderer.h"
#include "render/transport/lanes/depth.h"
#include "tests/render/grids.h"
#include "tests/scene_file.h"
#include "tests/stat/kept.h"

enum { width = 48, height = 36, tile = 12, n_views = 3, tiles = n_views * 12 + 1 };

static int replicates(void)
{
    return getenv("QUILTD_LONG") ? 96 : 12;
}

/* --------------------------------------------------------------------------- where they look -- */

/* Patches of three-colours, whose cameras look here and there: the list of the file, a circle and a
 * path. */
static const char *const looks[] = {
    "{}",
    "{'camera': {'position': [0.2, 1, 5], 'target': [0.1, 0, 0.1], 'views': {'list': null, "
    "'circle': {'count': 7}}}}",
    "{'camera': {'target': null, 'fov_y': 24, 'views': {'list': null, 'path': {'count': 6, "
    "'through': [{'position': [-4, 0, 3]}, {'position': [-1, 1, 5], 'target': [0.1, 0, 0]}, "
    "{'position': [2, 0.5, 5], 'fov_y': 20}, {'position': [4, 0, 2]}]}}}}"};

/* Where a camera of 120 x 80 pixels has a point. */
static void project(const lf_view_camera *c, double aspect, const double p[3], double out[2])
{
    double z[3], x[3], y[3], d[3], lz = 0, lx = 0, ly = 0, at[3] = {0};
    for (int i = 0; i < 3; i++) {
        z[i] = c->target[i] - c->position[i];
        d[i] = p[i] - c->position[i];
    }
    for (int i = 0; i < 3; i++)
        x[i] = z[(i + 1) % 3] * c->up[(i + 2) % 3] - z[(i + 2) % 3] * c->up[(i + 1) % 3];
    for (int i = 0; i < 3; i++)
        y[i] = x[(i + 1) % 3] * z[(i + 2) % 3] - x[(i + 2) % 3] * z[(i + 1) % 3];
    for (int i = 0; i < 3; i++) {
        lx += x[i] * x[i];
        ly += y[i] * y[i];
        lz += z[i] * z[i];
        at[0] += x[i] * d[i];
        at[1] += y[i] * d[i];
        at[2] += z[i] * d[i];
    }
    const double half = tan(0.5 * c->fov_y), deep = at[2] / sqrt(lz);
    out[0] = 120 * (0.5 + 0.5 * at[0] / sqrt(lx) / deep / (half * aspect));
    out[1] = 80 * (0.5 - 0.5 * at[1] / sqrt(ly) / deep / half);
}

/* Mean column and row of a colour in a view of 120 x 80. */
static void centre_of(const float *picture, int views, int view, int channel, double out[2])
{
    double sum = 0.0, along = 0.0, down = 0.0;
    for (int row = 0; row < 80; row++)
        for (int column = 0; column < 120; column++) {
            const size_t pixel =
                ((size_t)row * (size_t)views + (size_t)view) * 120 + (size_t)column;
            const double v = (double)picture[3 * pixel + (size_t)channel];
            sum += v;
            along += v * (column + 0.5);
            down += v * (row + 0.5);
        }
    assert_true(sum > 5.0);
    out[0] = along / sum;
    out[1] = down / sum;
}

static void points_land_where_each_camera_has_them(void **state)
{
    (void)state;
    static const double balls[3][3] = {{0.3, 0.1, 0}, {-0.2, 0.3, 0.6}, {0.1, -0.3, -0.7}};
    for (size_t i = 0; i < sizeof looks / sizeof looks[0]; i++) {
        lf_scene *scene = lf_test_scene(lf_test_scene_patched("three-colours", "%s", looks[i]));
        lf_renderer *r = lf_test_renderer(scene, i == 1 ? "vpt" : "mvpt", 120, 80, NULL);
        const lf_camera *camera = lf_scene_camera(scene);
        const int views = camera->n_views;
        float *picture = calloc((size_t)views * 120 * 80 * 3, sizeof *picture);
        lf_test_passes(r, 8 * views);
        lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MIS, picture, NULL), NULL);
        for (int view = 0; view < views; view++)
            for (int ball = 0; ball < 3; ball++) {
                double seen[2], said[2];
                centre_of(picture, views, view, ball, seen);
                project(&camera->list[view], camera->aspect, balls[ball], said);
                lf_assert_close(seen[0], said[0], 0, 0.15);
                lf_assert_close(seen[1], said[1], 0, 0.15);
            }
        free(picture);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
}

/* --------------------------------------------------------------------------------- densities -- */

/* The list of listed-cameras as a track. */
#define TRACK "'target': [0, 0.1, 0], 'views': {'list': null, 'track': {'count': 3, 'length': 1.5}}"
/* Without what they see. */
#define NOTHING "'volumes': null, 'meshes': null, 'materials': null, 'lights': null"

static const float centre[2] = {0.0f, 0.0f};

/* Where a view has a point, and the density of its samples over that of view 0, as the rig's
 * formulas have them (docs/developer/estimators.md, "4. How a pivot is shared"): r_k in media. What
 * is sampled of a pixel's solid angle is the same. */
static void densities_are_those_of_the_rig(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_patched("listed-cameras", "{" NOTHING "}")),
             *track = lf_test_scene(
                 lf_test_scene_patched("listed-cameras", "{'camera': {" TRACK "}, " NOTHING "}"));
    lf_render_settings settings = {.camera = *lf_scene_camera(scene), .width = 40, .height = 30},
                       rectified = settings;
    lf_pinhole views[LF_MAX_VIEWS];
    lf_rig rig;
    rectified.camera = *lf_scene_camera(track);
    lf_assert_ok(lf_pinholes_init(views, &settings, scene->origin, NULL), NULL);
    lf_assert_ok(lf_rig_init(&rig, &rectified, scene->origin, NULL), NULL);
    for (int i = 0; i < 500; i++) {
        const uint64_t h = lf_hash64(91, (uint64_t)i);
        const float x = (float)(h % 1000) * 0.002f - 1.0f, y = (float)(h / 1000 % 1000) * 0.001f,
                    z = 2.0f + (float)(h / 1000000 % 1000) * 0.004f;
        const lf_vec3 p = lf_rig_point(&rig, x, y - 0.5f, z);
        double area[3], r[3];
        for (int k = 0; k < 3; k++) {
            lf_pinhole_sight sight;
            assert_true(lf_pinhole_see(&views[k], centre, p, &sight));
            r[k] = (double)lf_length(lf_sub(p, lf_rig_point(&rig, rig.b[k], 0.0f, 0.0f)));
            area[k] = sight.area;
            lf_assert_close(
                (double)sight.u,
                (double)(((x - rig.b[k]) * rig.distance / z - rig.x0 + rig.skew[k]) / rig.dx), 0,
                2e-4);
            lf_assert_close((double)sight.v,
                            (double)(((y - 0.5f) * rig.distance / z - rig.y0) / rig.dy), 0, 2e-4);
            lf_assert_close((double)sight.distance, r[k], 1e-6, 0);
        }
        for (int k = 1; k < 3; k++)
            lf_assert_close(area[0] / area[k], r[k] / r[0], 1e-5, 0);
    }
    lf_scene_unref(track);
    lf_scene_unref(scene);
}

/* A ray back through every film point meets it again, whatever point of the lens it has left, and
 * pixels' areas are what finite differences say. Rays meet at the distance of focus. */
static void areas_are_those_of_pixels(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("three-colours"));
    lf_render_settings settings = {.camera = *lf_scene_camera(scene), .width = 60, .height = 40};
    lf_pinhole views[LF_MAX_VIEWS];
    settings.camera.lens_radius = 0.3;
    settings.camera.focus_distance = 2.0;
    lf_assert_ok(lf_pinholes_init(views, &settings, scene->origin, NULL), NULL);
    for (int k = 0; k < 5; k++)
        for (int i = 0; i < 50; i++) {
            const float u = 1.3f * (float)i - 2.0f, v = 0.9f * (float)i, step = 0.05f, far = 3.0f,
                        place[2] = {0.02f * (float)i, (float)(7 * i % 50) * 0.02f};
            float lens[2];
            lf_pinhole_lens(&views[k], place, lens);
            lf_assert_close((double)hypotf(lens[0], lens[1]), 0.3 * sqrt((double)place[0]), 1e-6,
                            0);
            const lf_vec3 eye = lf_pinhole_eye(&views[k], lens),
                          w = lf_pinhole_ray(&views[k], lens, u, v), p = lf_madd(eye, far, w),
                          a = lf_sub(lf_pinhole_ray(&views[k], lens, u + step, v),
                                     lf_pinhole_ray(&views[k], lens, u - step, v)),
                          b = lf_sub(lf_pinhole_ray(&views[k], lens, u, v + step),
                                     lf_pinhole_ray(&views[k], lens, u, v - step)),
                          straight = lf_pinhole_ray(&views[k], centre, u, v);
            const float z = lf_dot(w, views[k].forward),
                        z_straight = lf_dot(straight, views[k].forward);
            lf_assert_close(
                (double)lf_length(lf_sub(lf_madd(eye, 2.0f / z, w),
                                         lf_madd(views[k].eye, 2.0f / z_straight, straight))),
                0, 0, 1e-5);
            lf_pinhole_sight sight;
            assert_true(lf_pinhole_see(&views[k], lens, p, &sight));
            lf_assert_close((double)sight.u, (double)u, 0, 1e-3);
            lf_assert_close((double)sight.v, (double)v, 0, 1e-3);
            lf_assert_close(sight.area,
                            (double)(lf_length(lf_cross(a, b)) * far * far / (4 * step * step)),
                            1e-3, 0);
        }
    lf_pinhole_sight sight;
    assert_false(
        lf_pinhole_see(&views[0], centre, lf_madd(views[0].eye, -1.0f, views[0].forward), &sight));
    lf_scene_unref(scene);
}

/* The integral of a volume along a ray by very many points. */
static double by_points(const lf_scene *scene, lf_vec3 o, lf_vec3 w, double end)
{
    enum { POINTS = 20000 };
    double sum = 0.0;
    for (int i = 0; i < POINTS; i++) {
        const lf_vec3 p = lf_madd(o, (float)(end * (i + 0.5) / POINTS), w);
        for (int k = 0; k < scene->n_volumes; k++)
            sum += (double)lf_volume_sigma_t(&scene->volumes[k], p);
    }
    return sum * end / POINTS;
}

static lf_scene *rough_voxels(bool nearest)
{
    return lf_test_grid_scene(lf_test_scene_text("listed-voxels"),
                              lf_test_grid(lf_test_rough, 23, 18, 11), 0.1, 0.4, 3.0f, nearest);
}

static void depths_are_integrals(void **state)
{
    (void)state;
    for (int nearest = 0; nearest < 2; nearest++) {
        lf_scene *scene = rough_voxels(nearest);
        lf_tracer tracer = {.scene = scene};
        double most = 0.0;
        for (int i = 0; i < 16; i++) {
            const uint64_t h = lf_hash64(17, (uint64_t)i);
            const lf_vec3 o = lf_v3(3.0f * cosf((float)i), 2.0f * sinf(2.0f * (float)i), 3.0f),
                          to = lf_v3((float)(h % 100) * 0.01f - 0.5f, 0.2f,
                                     (float)(h / 100 % 100) * 0.01f - 0.5f),
                          w = i == 0 ? lf_v3(0.0f, 0.0f, -1.0f) : lf_normalize(lf_sub(to, o));
            const double end = i % 3 ? 3.5 : 20.0;
            const double depth = lf_depth_along(&tracer, o, w, i % 3 ? end : (double)INFINITY);
            lf_assert_close(depth, by_points(scene, o, w, end), 0, nearest ? 5e-3 : 3e-4);
            most = fmax(most, depth);
        }
        assert_true(most > 1.0);
        lf_scene_unref(scene);
    }
}

/* ---------------------------------------------------------------------------------- pictures -- */

/* Suns with a disk are found by light samples and by directions. */
#define WIDE_SUNS                                                                                  \
    "'sky': {'radiance': 0.2}, 'sun': {'direction': [0.4, -0.8, -0.5], 'irradiance': 2, 'angle': " \
    "40}"

static lf_scene *things(const char *camera)
{
    return lf_test_grid_scene(camera, lf_test_grid(lf_test_rough, 9, 8, 7), 0.2, 0.4, 3.0f, false);
}

/* Takes the renderer. */
static void pictures_of(lf_renderer *r, int passes, uint64_t salt, lf_blocks out[3])
{
    lf_render_stats stats;
    for (int i = 0; i < 3; i++)
        lf_blocks_init(&out[i], n_views, width, height, tile);
    for (int k = 0; k < replicates(); k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        lf_test_passes(r, passes);
        lf_blocks_add_picture(&out[0], r, LF_ESTIMATOR_MIS);
        lf_blocks_add_picture(&out[1], r, LF_ESTIMATOR_CV);
        lf_blocks_add_picture(&out[2], r, LF_ESTIMATOR_MWIS);
    }
    lf_renderer_stats(r, &stats);
    assert_int_equal(stats.nonfinite_dropped, 0);
    lf_renderer_destroy(r);
}

static void pictures(lf_scene *scene, const char *integrator, int passes, uint64_t salt,
                     lf_blocks out[3])
{
    pictures_of(lf_test_renderer(scene, integrator, width, height, NULL), passes, salt, out);
}

/* What others are compared with. Takes the renderer. */
static lf_blocks reference(lf_renderer *r, const char *name, int cycles, int parts, double level)
{
    const int n = lf_test_long() ? 24 : 12;
    lf_blocks out;
    lf_test_kept(r, &(lf_kept){name, n, cycles, 1, LF_ESTIMATOR_MIS, tile, level, parts}, &out);
    return out;
}

static void finish(lf_blocks blocks[3])
{
    for (int i = 0; i < 3; i++)
        lf_blocks_finish(&blocks[i]);
}

/* The smallest p of all tiles and the whole. Where there is nothing but sky, means are rounded. */
static double least_p(const lf_blocks *a, const lf_blocks *b, int *out_where)
{
    double least = 1.0;
    *out_where = 0;
    for (int j = 0; j < tiles; j++) {
        const lf_moments *x = &a->moments[j], *y = &b->moments[j];
        const double p = lf_close(x->mean, y->mean, 1e-6, 0) ? 1.0 : lf_p_welch(x, y);
        *out_where = p < least ? j : *out_where;
        least = fmin(least, p);
    }
    return least;
}

/* With what the test would see. */
static void assert_agreement(const lf_blocks *a, const lf_blocks *b, const char *what, double level)
{
    int where = 0, found = 0;
    const double p = least_p(a, b, &where);
    const lf_moments *x = &a->moments[where], *y = &b->moments[where];
    for (int j = 0; j < tiles - 1; j++)
        found += lf_blocks_welch_injected(a, b, j, 1.05) < level;
    const lf_moments *all = &a->moments[tiles - 1];
    print_message("%s: p %.2g; the whole %.6f +- %.6f, by rows %.6f +- %.6f; 5 %% would be seen in "
                  "%d of %d tiles\n",
                  what, p, all->mean, lf_moments_error(all), b->moments[tiles - 1].mean,
                  lf_moments_error(&b->moments[tiles - 1]), found, tiles - 1);
    if (!(p > level))
        fail_msg("%s: tile %d of view %d: %.6g +- %.2g, by rows %.6g +- %.2g, p %.2g", what,
                 where % 12, where / 12, x->mean, lf_moments_error(x), y->mean, lf_moments_error(y),
                 p);
    assert_true(2 * found >= tiles - 1);
    assert_true(lf_blocks_welch_injected(a, b, tiles - 1, 1.008) < level);
    assert_true(lf_blocks_welch_injected(a, b, tiles - 1, 0.992) < level);
}

/* Scenes seen by rows and by a list, with more keys of the camera. */
static void assert_as_rows(const char *name, const char *lens)
{
    static const char *const names[] = {"mis", "cv"};
    const double level = lf_sidak(0.2 * LF_FALSE_ALARM, 4 * tiles);
    lf_blocks seen[3];
    lf_scene *track =
                 things(lf_test_scene_patched("listed-cameras", "{'camera': {" TRACK "%s}}", lens)),
             *list = things(
                 lf_test_scene_patched("listed-cameras", "{'camera': {'views': {}%s}}", lens));
    lf_blocks rows =
        reference(lf_test_renderer(track, "mvpt", width, height, NULL), name, 20, 4, level);
    pictures(list, "mvpt", 6 * n_views, 2, seen);
    for (int i = 0; i < 2; i++)
        assert_agreement(&seen[i], &rows, names[i], level);
    /* consistent: what thin fog has not scattered yet is missing */
    lf_assert_close(seen[2].moments[tiles - 1].mean, rows.moments[tiles - 1].mean, 5e-3, 0);
    finish(seen);
    pictures(list, "vpt", 10 * n_views, 3, seen);
    assert_agreement(&seen[0], &rows, "vpt", level);
    finish(seen);
    lf_blocks_finish(&rows);
    lf_scene_unref(list);
    lf_scene_unref(track);
}

static void the_general_way_agrees_with_rows(void **state)
{
    (void)state;
    assert_as_rows("any_cameras-rows", "");
}

/* A lens as wide as the ball's half, which is out of focus. */
#define LENS ", 'lens_radius': 0.25, 'focus_distance': 6"

static void lenses_agree_with_those_of_rows(void **state)
{
    (void)state;
    assert_as_rows("any_cameras-lens", LENS);
}

/* What each gets from the paths of all is what it finds alone. */
static void cameras_all_around_agree_with_each_alone(void **state)
{
    (void)state;
    static const char *const names[] = {"all around, mis", "all around, cv"};
    const double level = lf_sidak(0.2 * LF_FALSE_ALARM, 3 * tiles);
    lf_blocks seen[3];
    lf_scene *scene =
        things(lf_test_scene_patched("cameras-all-around", "{'lights': {" WIDE_SUNS "}}"));
    lf_blocks alone = reference(lf_test_renderer(scene, "vpt", width, height, NULL),
                                "any_cameras-around", 24, 4, level);
    pictures(scene, "mvpt", 6 * n_views, 5, seen);
    for (int i = 0; i < 2; i++)
        assert_agreement(&seen[i], &alone, names[i], level);
    finish(seen);
    lf_blocks_finish(&alone);
    lf_scene_unref(scene);
}

static lf_renderer *with_suffixes(lf_scene *scene, const char *integrator, bool in_lanes,
                                  lf_pool *pool)
{
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, pool);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.skip = in_lanes ? LF_SKIP_ALL : LF_SKIP_ALL & ~LF_SKIP_PATHS;
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    assert_true(in_lanes ? (bool)r->lanes : !r->lanes);
    return r;
}

/* What paths bring side by side is what each brings alone: under a sun that light samples and
 * directions find, one that has no width, and a picture of the sky. */
static void lanes_bring_what_single_paths_do(void **state)
{
    (void)state;
    static const struct {
        const char *patch;   /* of cloud-all-around */
        int alone, lanes[2]; /* cycles */
    } cases[] = {
        {"{'volumes': {'v': {'g': 0}}, 'lights': {" WIDE_SUNS "}}", 8, {3, 5}},
        {"{}", 8, {3, 5}},
        {"{'volumes': {'v': {'g': 0.3}}, 'meshes': {'ball': {'shape': 'sphere', 'transform': "
         "{'scale': 0.6}}}, 'lights': {" WIDE_SUNS "}}",
         8,
         {3, 5}},
        {"{'lights': {'sky': null, 'sun': null, 'day': {'type': 'sky', 'elevation': 14}}}",
         24,
         {16, 24}}};
    static const char *const names[] = {"mvpt", "vpt"};
    enum { N = sizeof cases / sizeof *cases };
    const double level = lf_sidak(0.2 * LF_FALSE_ALARM, 3 * N * tiles);
    for (int i = 0; i < N; i++) {
        char what[64], name[64];
        lf_blocks lanes[3];
        lf_scene *scene = things(lf_test_scene_patched("cloud-all-around", "%s", cases[i].patch));
        snprintf(name, sizeof name, "any_cameras-alone-%d", i);
        lf_blocks alone =
            reference(with_suffixes(scene, "vpt", false, NULL), name, cases[i].alone, 2, level);
        for (int j = 0; j < 2; j++) {
            pictures_of(with_suffixes(scene, names[j], true, NULL), cases[i].lanes[j] * n_views, 7,
                        lanes);
            snprintf(what, sizeof what, "lanes, scene %d, %s", i, names[j]);
            assert_agreement(&lanes[1], &alone, what, level);
            finish(lanes);
        }
        lf_blocks_finish(&alone);
        lf_scene_unref(scene);
    }
}

static void whole_passes(lf_renderer *r)
{
    lf_test_cycles(r, 4);
}

/* Visits of a view's worth, of parts of the picture: each shares among its own rows. */
static void passes_of_parts(lf_renderer *r)
{
    for (int i = 0; i < 12; i++)
        for (int part = 0; part < 3; part++) {
            const lf_part rows = {.first_row = part, .row_step = 3};
            lf_assert_ok(lf_renderer_pass(r, &rows, 1, NULL, NULL, NULL), NULL);
        }
}

/* The balance over all cameras comes to the samples of each, in every tile. */
static void weights_come_to_samples(void **state)
{
    (void)state;
    static const lf_test_schedule schedules[] = {whole_passes, passes_of_parts};
    const double level = lf_sidak(0.2 * LF_FALSE_ALARM, 2 * (tiles - 1));
    for (int i = 0; i < 2; i++) {
        lf_blocks seen[3];
        double worst = 1.0;
        int found = 0;
        lf_scene *scene = things(lf_test_scene_text("cameras-all-around"));
        lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
        lf_test_weight_blocks(r, schedules[i], replicates(), tile, seen);
        lf_renderer_destroy(r);
        for (int k = 0; k < tiles - 1; k++) {
            const lf_moments *at = &seen[0].moments[k];
            const double q = seen[2].moments[k].mean;
            if (q * 4 * tile * tile * replicates() < 30)
                continue; /* so few pivots have no normal mean */
            worst = fmin(worst, lf_p_mean(at, 0.0));
            found += lf_p_mean(at, (at->mean < 0 ? 0.05 : -0.05) * q) < level;
        }
        print_message("W/n is q with p %.2g; 5 %% would be seen in %d of %d tiles\n", worst, found,
                      tiles - 1);
        assert_true(worst > level);
        assert_true(3 * found >= tiles - 1);
        finish(seen);
        lf_scene_unref(scene);
    }
}

/* In a world of radiance 1 that absorbs nothing all that is scattered is 1, whatever it weighs. */
static void assert_white(lf_renderer *r)
{
    const lf_render_settings *settings = lf_renderer_settings(r);
    const int row = settings->camera.n_views * settings->width;
    int found = 0;
    lf_test_cycles(r, 2);
    for (int i = 0; i < 2 * settings->height * row; i++) {
        const lf_film_half half = lf_film_at(&r->film, i / 2 / row, i % 2);
        const lf_film_scattered *at = &half.scattered[i / 2 % row];
        for (int k = 0; k < 3; k++)
            lf_assert_close((double)at->n[k], (double)at->w, 1e-5, 1e-6);
        found += at->w > 0.1f;
    }
    print_message("%d pixels scatter\n", found);
    assert_true(found > 500);
    lf_renderer_destroy(r);
}

static void a_white_world_is_white(void **state)
{
    (void)state;
    lf_scene *ball = lf_test_scene(
        "{ 'camera': { 'views': { 'circle': { 'count': 5 } } }, 'volumes': { 'v': { 'shape': "
        "'sphere', 'density': 3, 'albedo': 1, 'transform': { 'scale': 0.6 } } }, "
        "'lights': { 'sky': { 'type': 'environment', 'radiance': 1 } } }");
    lf_scene *grid = things(lf_test_scene_patched(
        "cameras-all-around", "{'volumes': {'fog': null}, 'meshes': null, 'materials': null, "
                              "'lights': {'sky': {'radiance': 1}, 'sun': null}}"));
    assert_white(lf_test_renderer(ball, "mvpt", 24, 32, NULL));
    assert_white(with_suffixes(grid, "mvpt", true, NULL));
    assert_white(with_suffixes(grid, "mvpt", false, NULL));
    lf_scene_unref(grid);
    lf_scene_unref(ball);
}

static double *by_threads(lf_scene *scene, const char *integrator, bool in_lanes, int threads)
{
    lf_pool *pool = NULL;
    lf_assert_ok(lf_pool_create(threads, &pool), NULL);
    lf_renderer *r = with_suffixes(scene, integrator, in_lanes, pool);
    lf_test_cycles(r, 1);
    passes_of_parts(r);
    double *seen = lf_test_picture(r, LF_ESTIMATOR_MWIS);
    lf_renderer_destroy(r);
    lf_pool_destroy(pool);
    return seen;
}

/* Edges that a lens makes wide: who knows of a surface has found it, also at one sample. */
static void surfaces_leave_no_holes(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("listed-edges"));
    lf_renderer *r = lf_test_renderer(scene, "vpt", width, height, NULL);
    uint8_t flags[n_views * width * height];
    float *picture = calloc((size_t)n_views * width * height * 3, sizeof *picture);
    int edges = 0;
    lf_test_cycles(r, 2);
    lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, picture, flags), NULL);
    for (int i = 0; i < n_views * width * height; i++) {
        assert_false(flags[i] & LF_PIXEL_HOLE);
        edges += picture[3 * i] > 0.55f && picture[3 * i] < 0.95f;
    }
    print_message("%d pixels of edges\n", edges);
    assert_true(edges > 50);
    free(picture);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* With a mesh, and in lanes: more of a row wait than there is room for at first. */
static const char *const of_both_ways[] = {"cameras-all-around", "cloud-all-around"};

static void pictures_do_not_depend_on_the_number_of_threads(void **state)
{
    (void)state;
    static const char *const names[] = {"mvpt", "vpt"};
    for (int i = 0; i < 4; i++) {
        const bool in_lanes = i / 2;
        lf_scene *scene = things(lf_test_scene_text(of_both_ways[in_lanes]));
        double *one = by_threads(scene, names[i % 2], in_lanes, 1);
        for (int threads = 2; threads <= 7; threads += 5) {
            double *many = by_threads(scene, names[i % 2], in_lanes, threads);
            assert_memory_equal(one, many, sizeof *one * n_views * width * height);
            free(many);
        }
        free(one);
        lf_scene_unref(scene);
    }
}

typedef struct interruption {
    lf_cancel cancel;
    int after;
} interruption;

static void interrupt(void *context, int row, int worker)
{
    interruption *i = context;
    (void)row, (void)worker;
    if (--i->after == 0)
        atomic_store(&i->cancel, 1);
}

/* What a pass that was interrupted had found is forgotten, and the next one is what it would have
 * been. */
static void a_cancelled_pass_leaves_nothing(void **state)
{
    (void)state;
    for (int in_lanes = 0; in_lanes < 2; in_lanes++) {
        lf_scene *scene = things(lf_test_scene_text(of_both_ways[in_lanes]));
        double *seen[2];
        for (int way = 0; way < 2; way++) {
            lf_renderer *r = with_suffixes(scene, "mvpt", in_lanes, NULL);
            interruption early = {.after = 5};
            lf_test_cycles(r, 1);
            if (way == 1)
                lf_assert_status(
                    lf_renderer_pass(r, NULL, n_views, interrupt, &early, &early.cancel),
                    LF_E_CANCELLED, NULL);
            lf_test_cycles(r, 1);
            seen[way] = lf_test_picture(r, LF_ESTIMATOR_MIS);
            lf_renderer_destroy(r);
        }
        assert_memory_equal(seen[0], seen[1], sizeof *seen[0] * n_views * width * height);
        free(seen[0]);
        free(seen[1]);
        lf_scene_unref(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_land_where_each_camera_has_them),
        cmocka_unit_test(densities_are_those_of_the_rig),
        cmocka_unit_test(areas_are_those_of_pixels),
        cmocka_unit_test(depths_are_integrals),
        cmocka_unit_test(the_general_way_agrees_with_rows),
        cmocka_unit_test(lenses_agree_with_those_of_rows),
        cmocka_unit_test(cameras_all_around_agree_with_each_alone),
        cmocka_unit_test(lanes_bring_what_single_paths_do),
        cmocka_unit_test(weights_come_to_samples),
        cmocka_unit_test(a_white_world_is_white),
        cmocka_unit_test(surfaces_leave_no_holes),
        cmocka_unit_test(pictures_do_not_depend_on_the_number_of_threads),
        cmocka_unit_test(a_cancelled_pass_leaves_nothing),
    };
    return cmocka_run_group_tests_name("any_cameras", tests, NULL, lf_test_finish);
}
