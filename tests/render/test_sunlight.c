/* Sunlight by look-ups: shadows stand where geometry says, half-shadows are as wide as the sun's
 * disk, media take away what they do along rays; and all of it is what rays find. */
#include "tests/testing.h"

#include "render/transport/light/light_kind.h"
#include "render/transport/path/sunlight.h"
#include "render/transport/path/track.h"
#include "tests/render/grids.h"
#include "tests/scene_file.h"

#define HEAD "{'quiltd': 1, 'camera': {'position': [0, 1, 9], 'fov_y': 20, 'aspect': 1}, "
#define GROUND "'ground': {'shape': 'quad', 'material': 'm', 'transform': {'scale': 4}}"
#define BOARD(more) "'board': {'shape': 'quad', 'material': 'm', 'transform': {" more "}}"
#define SUN(more)                                                                                  \
    "'materials': {'m': {'albedo': 0.5}}, 'lights': {'sun': {'type': 'distant', 'irradiance': 2, " \
    "'direction': " more "}}}"

typedef struct bench {
    lf_scene *scene;
    lf_pool *pool;
    lf_sunlight *sunlight;
} bench;

static void light(bench *b, lf_scene *scene, int texels, int threads)
{
    b->scene = scene;
    lf_assert_status(lf_pool_create(threads, &b->pool), LF_OK, NULL);
    lf_assert_status(lf_sunlight_create(scene, texels, b->pool, NULL, &b->sunlight), LF_OK, NULL);
}

static void set_up(bench *b, const char *text, int texels)
{
    light(b, lf_test_scene(text), texels, 2);
}

static void tear_down(bench *b)
{
    lf_sunlight_destroy(b->sunlight);
    lf_pool_destroy(b->pool);
    lf_scene_unref(b->scene);
}

/* On what looks up, at a place of the file's world. */
static double share_at(const bench *b, double x, double y, double z)
{
    const double *origin = b->scene->origin;
    const lf_light *which;
    float share = -1.0f;
    assert_true(lf_sunlight_share(
        b->sunlight, 0,
        lf_v3((float)(x - origin[0]), (float)(y - origin[1]), (float)(z - origin[2])),
        lf_v3(0, 1, 0), &share, &which));
    return (double)share;
}

/* Where the share passes a half between two places on the ground. */
static double edge_between(const bench *b, double from, double to, double z)
{
    bool lit = share_at(b, from, 0, z) > 0.5;
    assert_true(lit != (share_at(b, to, 0, z) > 0.5));
    for (int i = 0; i < 40; i++) {
        double middle = 0.5 * (from + to);
        if ((share_at(b, middle, 0, z) > 0.5) == lit)
            from = middle;
        else
            to = middle;
    }
    return from;
}

/* A board of side 1 one above the ground, the sun 3/4 to the side of upright. */
static const char board[] =
    HEAD "'meshes': {" GROUND
         ", " BOARD("'scale': 0.5, 'translate': [0, 1, 0]") "}, " SUN("[0.6, -0.8, 0]");

static void shadow_of_a_board_is_the_board_moved(void **state)
{
    (void)state;
    bench b;
    set_up(&b, board, 512);
    /* the board is small beside the ground, and has texels of its own */
    double texel = 1.0 / 510;
    for (int i = -4; i <= 4; i++) {
        double z = 0.11 * i;
        lf_assert_close(edge_between(&b, 0.75, -0.5, z), 0.25, 0, 1.3 * texel);
        lf_assert_close(edge_between(&b, 0.75, 2.0, z), 1.25, 0, 1.3 * texel);
    }
    double area = 0.0;
    for (int i = 0; i < 300; i++)
        for (int j = 0; j < 300; j++)
            area += 1.0 - share_at(&b, 0.0013 + 0.005 * i, 0, -0.7487 + 0.005 * j);
    lf_assert_close(area * 0.005 * 0.005, 1.0, 0, 2 * texel);
    /* nothing else is dark: not the board, not the ground far away, not what lies beside it */
    for (int i = 0; i < 400; i++) {
        lf_assert_close(share_at(&b, -0.497 + 0.0025 * i, 1, 0.3), 1, 0, 0);
        lf_assert_close(share_at(&b, -3.99 + 0.01 * i, 0, 3.9), 1, 0, 0);
    }
    lf_assert_close(share_at(&b, 100, 0, 0), 1, 0, 0);
    /* and what looks away from the sun has none of it */
    float share = -1.0f;
    const lf_light *which;
    assert_true(lf_sunlight_share(b.sunlight, 0, lf_v3(2, 0, 0), lf_v3(0, -1, 0), &share, &which));
    assert_true(share == 0.0f && which->kind == &lf_light_distant);
    assert_false(lf_sunlight_share(b.sunlight, 1, lf_v3(2, 0, 0), lf_v3(0, 1, 0), &share, &which));
    tear_down(&b);
}

/* Under an edge at x = 0, a disk's part on the side of x > 0. */
static double disk_share(double u)
{
    u = fmin(fmax(u, -1), 1);
    return 0.5 + (u * sqrt(1 - u * u) + asin(u)) / M_PI;
}

static double worst_beside_disk(const char *text, double radius)
{
    bench b;
    double worst = 0.0;
    set_up(&b, text, 1024);
    for (int i = -30; i <= 30; i++)
        for (int j = 0; j < 5; j++)
            worst = fmax(
                worst, fabs(share_at(&b, 0.05 * i * radius, 0, 0.1234 * j) - disk_share(0.05 * i)));
    tear_down(&b);
    return worst;
}

static void half_shadow_of_an_edge_is_a_part_of_the_disk(void **state)
{
    (void)state;
    static const char low[] = HEAD "'meshes': {" GROUND ", " BOARD(
        "'scale': [1, 1, 2], 'translate': [-1, 1, 0]") "}, " SUN("[0, -1, 0], 'angle': 4");
    static const char high[] = HEAD "'meshes': {" GROUND ", " BOARD(
        "'scale': [1, 1, 2], 'translate': [-1, 3, 0]") "}, " SUN("[0, -1, 0], 'angle': 10");
    static const char sharp[] =
        HEAD "'meshes': {" GROUND
             ", " BOARD("'scale': [1, 1, 2], 'translate': [-1, 3, 0]") "}, " SUN("[0, -1, 0]");
    double radius = tan(2 * M_PI / 180), wide = 3 * tan(5 * M_PI / 180);
    double a = worst_beside_disk(low, radius), b = worst_beside_disk(high, wide);
    print_message("off a disk's part by at most %.3f (4.5 texels), %.3f (34 texels)\n", a, b);
    assert_true(a < 0.01 && b < 0.04);
    /* a sun without a disk, or one of another size, is seen to be that */
    assert_true(worst_beside_disk(sharp, wide) > 0.4);
    assert_true(worst_beside_disk(high, 1.5 * wide) > 0.12);
}

static void media_take_away_what_lies_between(void **state)
{
    (void)state;
    const char *text = lf_test_scene_text("shapes-in-sun");
    bench b;
    set_up(&b, text, 256);
    /* through lid and floor of the box, whose sides are 1 and 0.6 */
    lf_assert_close(share_at(&b, 0.75, 0, 0), exp(-0.7 * 0.6 / 0.8), 1e-5, 0);
    /* in the middle of it: from there on only */
    lf_assert_close(share_at(&b, 0, 1, 0), exp(-0.7 * 0.3 / 0.8), 1e-5, 0);
    /* the ball's middle, and a chord 0.3 beside it, which is across the light as z is */
    lf_assert_close(share_at(&b, 2.75, 0, 0), exp(-2 * 0.8), 1e-5, 0);
    lf_assert_close(share_at(&b, 2.75, 0, 0.3), exp(-2 * 2 * sqrt(0.16 - 0.09)), 1e-4, 0);
    lf_assert_close(share_at(&b, -2, 0, 0), 1, 0, 0);
    tear_down(&b);
}

/* Optical depth by many small steps. */
static double marched(const lf_scene *scene, lf_vec3 p, lf_vec3 w)
{
    double depth = 0.0, step = 1e-3;
    for (int i = 0; i < 6000; i++)
        depth += step * (double)lf_volume_sigma_t(&scene->volumes[0],
                                                  lf_madd(p, (float)((i + 0.5) * step), w));
    return depth;
}

static float smooth(int x, int y, int z)
{
    return (float)(0.5 + 0.5 * sin(0.4 * x) * cos(0.3 * y + 0.2 * z));
}

static void grids_take_away_what_is_marched_through(void **state)
{
    (void)state;
    static const char text[] = HEAD LF_TEST_VOLUMES("") ", 'meshes': {" BOARD(
        "'scale': 4, 'translate': [0, -1.5, 0]") "}, " SUN("[0.5, -0.8, 0.1]");
    bench b;
    light(&b, lf_test_grid_scene(text, lf_test_grid(smooth, 14, 12, 13), 0.15, 0.3, 1.1f, false),
          256, 2);
    lf_vec3 toward = lf_scale(b.scene->lights[0].direction, -1.0f);
    double square = 0.0, least = 1.0;
    for (int i = 0; i < 400; i++) {
        const int down = i / 20;
        double x = -1.5 + 0.15 * (i % 20), z = -1.5 + 0.15 * down, y = i % 3 ? -1.5 : -0.1;
        double truth = exp(-marched(b.scene, lf_v3((float)x, (float)y, (float)z), toward));
        double off =
            share_at(&b, x + b.scene->origin[0], y + b.scene->origin[1], z + b.scene->origin[2]) -
            truth;
        square += off * off / 400;
        least = fmin(least, truth);
    }
    print_message("a grid's transmittance down to %.2f: off by %.4f\n", least, sqrt(square));
    assert_true(least < 0.4 && sqrt(square) < 0.01);
    tear_down(&b);
}

/* The share of the sun's disk that rays find, in 64 directions; through media by tracking. */
static double traced(lf_tracer *tracer, const lf_light *sun, const lf_hit *hit)
{
    double sum = 0.0;
    for (int i = 0; i < 64; i++) {
        const int row = i / 8;
        const float u[2] = {((float)row + lf_rng(tracer)) / 8,
                            ((float)(i % 8) + lf_rng(tracer)) / 8};
        lf_light_sample to;
        if (!sun->kind->draw(tracer->scene, sun, hit->p, 0.5, u, &to) ||
            !(lf_dot(to.wi, hit->ng) > 0.0f))
            continue;
        lf_vec3 o = lf_offset(tracer->scene, hit->p, hit->ng, to.wi, 0.0f);
        if (!lf_trace_occluded(tracer, o, to.wi, INFINITY))
            sum += (double)lf_track_transmittance(tracer, o, to.wi, INFINITY) / 64;
    }
    return sum;
}

/* Root mean square of look-ups beside rays where random rays through the middle of the scene meet
 * surfaces, times the cosine; the look-ups ask so far beside. */
static double off_rays(const bench *b, double moved)
{
    lf_tracer tracer = {.scene = b->scene, .rng = lf_test_seed()};
    double square = 0.0;
    int n = 0;
    while (n < 4000) {
        lf_vec3 o = lf_v3(6 * lf_rng(&tracer) - 3, 3, 6 * lf_rng(&tracer) - 3),
                to = lf_v3(4 * lf_rng(&tracer) - 2, 2 * lf_rng(&tracer) - 1.5f,
                           4 * lf_rng(&tracer) - 2);
        lf_hit hit;
        if (!lf_trace_surface(&tracer, o, lf_normalize(lf_sub(to, o)), INFINITY, &hit))
            continue;
        const lf_light *sun;
        float share;
        lf_vec3 p = lf_madd(hit.p, (float)moved, lf_v3(1, 0, 0));
        assert_true(lf_sunlight_share(b->sunlight, 0, p, hit.ng, &share, &sun));
        double cosine = fmax(-(double)lf_dot(hit.ng, sun->direction), 0);
        double off = cosine * ((double)share - traced(&tracer, sun, &hit));
        square += off * off;
        n++;
    }
    return sqrt(square / n);
}

static void look_ups_find_what_rays_find(void **state)
{
    (void)state;
    bench b;
    set_up(&b, lf_test_scene_views("mixed", 8), 0);
    double off = off_rays(&b, 0), moved = off_rays(&b, 0.05);
    print_message("beside rays: %.4f; moved by 0.05: %.4f\n", off, moved);
    assert_true(off < 0.03 && moved > 0.1);
    tear_down(&b);
}

static void threads_do_not_change_a_bit(void **state)
{
    (void)state;
    bench one, three;
    light(&one, lf_test_scene(lf_test_scene_views("mixed", 8)), 300, 1);
    light(&three, lf_test_scene(lf_test_scene_views("mixed", 8)), 300, 3);
    uint64_t random = lf_test_seed();
    for (int i = 0; i < 20000; i++) {
        double p[3];
        for (int k = 0; k < 3; k++) {
            random = lf_hash64(random, 3);
            p[k] = (double)(random >> 11) * 0x1p-53 * 4 - 2;
        }
        assert_true(share_at(&one, p[0], p[1], p[2]) == share_at(&three, p[0], p[1], p[2]));
    }
    tear_down(&one);
    tear_down(&three);
}

/* A pixel's mean, over film points where there is a surface, of what it reflects; by rays. */
static double reflected_by_rays(lf_tracer *tracer, const lf_rig *rig, int view, int row, int column)
{
    enum { POINTS = 32 };
    double sum = 0.0, met = 0.0;
    for (int i = 0; i < POINTS; i++) {
        const float lens[2] = {0.5f, 0.5f};
        lf_row_plane plane;
        lf_hit hit;
        lf_vec3 f;
        lf_rig_row_plane(rig, (float)row + lf_rng(tracer), lens, &plane);
        float slope =
            (rig->x0 + ((float)column + lf_rng(tracer)) * rig->dx - rig->b[view]) / rig->distance;
        lf_vec3 w = lf_normalize(lf_rig_direction(rig, slope, plane.my, 1.0f));
        if (!lf_trace_surface(tracer, lf_rig_point(rig, rig->b[view], 0.0f, 0.0f), w, INFINITY,
                              &hit))
            continue;
        const lf_light *sun = &tracer->scene->lights[tracer->scene->n_lights_infinite - 1];
        (void)hit.material->kind->eval(hit.material, hit.ns, lf_scale(w, -1.0f),
                                       lf_scale(sun->direction, -1.0f), &f);
        sum += (double)lf_mean3(lf_mul(f, sun->irradiance)) * traced(tracer, sun, &hit);
        met++;
    }
    return sum / met;
}

/* Where nothing scatters before surfaces: there the feature is of them alone. */
static void features_of_pictures_are_what_rays_find(void **state)
{
    (void)state;
    enum { VIEWS = 8, WIDTH = 40, HEIGHT = 30, VISITS = 32 };
    lf_scene *scene = lf_test_scene(lf_test_scene_views("mixed", 8));
    lf_render_settings settings = {.skip = LF_SKIP_ALL,
                                   .camera = *lf_scene_camera(scene),
                                   .width = WIDTH,
                                   .height = HEIGHT,
                                   .seed = lf_test_seed(),
                                   .features = true};
    lf_renderer *renderer;
    lf_pool *pool;
    lf_assert_status(lf_pool_create(2, &pool), LF_OK, NULL);
    lf_assert_status(lf_renderer_create(scene, &settings, pool, &renderer, NULL), LF_OK, NULL);
    for (int i = 0; i < 2 * VISITS; i++)
        lf_assert_status(lf_renderer_pass(renderer, NULL, 1, NULL, NULL, NULL), LF_OK, NULL);
    lf_tracer tracer = {.scene = scene, .rng = lf_test_seed()};
    double square = 0.0, wrong = 0.0, mean = 0.0;
    int n = 0;
    for (int i = 0; i < VIEWS * WIDTH * HEIGHT; i += 3) {
        int row = i / (VIEWS * WIDTH), pixel = i % (VIEWS * WIDTH);
        lf_feature f = lf_feature_unpack(lf_film_at(&renderer->film, row, 0).feature[pixel]);
        if (f.surface < 0.9999f || lf_film_at(&renderer->film, row, 0).q[pixel] < 0.5f)
            continue;
        double truth = reflected_by_rays(&tracer, &lf_test_rows(renderer)->rig, pixel / WIDTH, row,
                                         pixel % WIDTH);
        square += ((double)f.light - truth) * ((double)f.light - truth);
        wrong += truth * truth;
        mean += (double)f.light - truth;
        n++;
    }
    print_message("of %d pixels: off by %.4f of the feature, mean %.4f\n", n, sqrt(square / wrong),
                  mean / sqrt(wrong * n));
    assert_true(n > 1000 && square < 0.1 * 0.1 * wrong && fabs(mean) < 0.01 * sqrt(wrong * n));
    lf_renderer_destroy(renderer);
    lf_pool_destroy(pool);
    lf_scene_unref(scene);
}

/* The ground's corners are up to 1e11 texels of the cube's own map away, farther than an int
 * reaches, to all sides. */
static void ground_may_reach_far_beyond_the_texels_of_what_is_small(void **state)
{
    (void)state;
    static const char scene[] =
        HEAD "'meshes': {'cube': {'shape': 'cube', 'material': 'm', 'transform': {'scale': 1e-3}}, "
             "'ground': {'shape': 'quad', 'material': 'm', 'transform': {'scale': 1e5, "
             "'translate': [%d, 0, %d]}}}, " SUN("%s, 'angle': 0.5");
    static const int places[][2] = {{0, 0},          {35000, 0},      {-35000, 0}, {0, 35000},
                                    {0, -35000},     {-30000, 10000}, {70000, 0},  {60000, -60000},
                                    {-60000, 60000}, {99000, 99000}};
    static const char *const suns[] = {"[0, -1, 0]", "[0.1, -0.9, 0.6]", "[-0.7, -0.3, 0.2]"};
    for (int i = 0; i < 30; i++) {
        const int *place = places[i / 3];
        char text[1000];
        bench b;
        snprintf(text, sizeof text, scene, place[0], place[1], suns[i % 3]);
        set_up(&b, text, 1024);
        for (int k = 0; k < 1000; k++) {
            double far = pow(10, 0.01 * k - 4);
            double share = share_at(&b, k % 2 ? far : -far, 0.01, k % 3 ? far : -0.5 * far);
            assert_true(share >= 0 && share <= 1);
        }
        tear_down(&b);
    }
}

/* Colours may change, places may not. */
static void maps_go_over_to_scenes_that_cast_the_same_shadows(void **state)
{
    (void)state;
    static const char brighter[] = HEAD "'meshes': {" GROUND ", " BOARD(
        "'scale': 0.5, 'translate': [0, 1, 0]") "}, 'materials': {'m': {'albedo': 0.1}}, 'lights': "
                                                "{'sun': {'type': 'distant', 'irradiance': 5, "
                                                "'direction': [0.6, -0.8, 0]}}}";
    static const char turned[] =
        HEAD "'meshes': {" GROUND
             ", " BOARD("'scale': 0.5, 'translate': [0, 1, 0]") "}, " SUN("[0.5, -0.8, 0]");
    static const char hazy[] =
        HEAD "'volumes': {'v': {'shape': 'box', 'density': 1}}, 'meshes': {" GROUND
             ", " BOARD("'scale': 0.5, 'translate': [0, 1, 0]") "}, " SUN("[0.6, -0.8, 0]");
    static const char moved[] =
        HEAD "'meshes': {" GROUND
             ", " BOARD("'scale': 0.5, 'translate': [0, 2, 0]") "}, " SUN("[0.6, -0.8, 0]");
    static const char *const others[] = {brighter, turned, hazy, moved};
    bench b;
    set_up(&b, board, 256);
    for (int i = 0; i < 4; i++) {
        lf_scene *other = lf_test_scene_in(".", others[i], b.scene);
        const lf_light *which;
        float share;
        assert_int_equal(lf_sunlight_adopt(b.sunlight, other), i == 0);
        assert_true(
            lf_sunlight_share(b.sunlight, 0, lf_v3(0.5f, 0, 0), lf_v3(0, 1, 0), &share, &which));
        assert_true(which->irradiance.x == 5.0f);
        lf_scene_unref(other);
    }
    tear_down(&b);
}

/* What the normal tells of a sky is kept for that sky alone. */
static void skies_are_not_taken_over(void **state)
{
    (void)state;
#define UNDER(radiance)                                                                            \
    HEAD "'meshes': {" GROUND "}, 'materials': {'m': {'albedo': 0.5}, 'dark': {'albedo': 0.1}}, "  \
         "'lights': {'sky': {'type': 'environment', 'radiance': " radiance "}}}"
    bench b;
    lf_scene *other = lf_test_scene(UNDER("2"));
    set_up(&b, UNDER("1"), 64);
    assert_true(lf_sunlight_needed(b.scene));
    assert_true(lf_sunlight_adopt(b.sunlight, b.scene));
    assert_false(lf_sunlight_adopt(b.sunlight, other));
#undef UNDER
    lf_scene_unref(other);
    tear_down(&b);
}

/* What a diffuse ground reflects of two suns. */
static void lights_add_up(void **state)
{
    (void)state;
    const char *text = lf_test_scene_text("three-suns");
    bench b;
    set_up(&b, text, 64);
    lf_hit hit = {.ng = lf_v3(0, 1, 0), .ns = lf_v3(0, 1, 0)};
    hit.material = &b.scene->materials[b.scene->meshes[0].material];
    double expected = (0.8 * (0.5 * 1 + 0.4 * 2 + 0.3 * 3) + 4 * (0.5 + 0.4 + 0.3)) / (3 * M_PI);
    lf_sunlight_face face;
    lf_sunlight_face_init(&face, b.sunlight, hit.ng);
    lf_assert_close((double)lf_sunlight_reflected(b.sunlight, &face, &hit, lf_v3(0, 1, 0)),
                    expected, 1e-5, 0);
    tear_down(&b);
}

static void scenes_without_sun_or_surfaces_need_none(void **state)
{
    (void)state;
    static const char *const texts[] = {
        board, HEAD "'volumes': {'v': {'shape': 'box'}}, " SUN("[0, -1, 0]"),
        HEAD "'meshes': {" GROUND "}, 'materials': {'m': {}}, 'lights': {'sky': {'type': "
             "'environment', 'radiance': 1}}}",
        HEAD "'meshes': {" GROUND "}, 'materials': {'m': {}}, 'lights': {'sun': {'type': "
             "'distant', 'irradiance': 0}}}"};
    for (int i = 0; i < 4; i++) {
        lf_scene *scene = lf_test_scene(texts[i]);
        assert_int_equal(lf_sunlight_needed(scene), i == 0);
        lf_scene_unref(scene);
    }
}

static void cancelling_leaves_nothing(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(board);
    lf_sunlight *sunlight = NULL;
    lf_cancel cancel;
    lf_pool *pool;
    atomic_init(&cancel, 1);
    lf_assert_status(lf_pool_create(2, &pool), LF_OK, NULL);
    lf_assert_status(lf_sunlight_create(scene, 0, pool, &cancel, &sunlight), LF_E_CANCELLED, NULL);
    assert_null(sunlight);
    lf_sunlight_destroy(NULL);
    lf_pool_destroy(pool);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shadow_of_a_board_is_the_board_moved),
        cmocka_unit_test(half_shadow_of_an_edge_is_a_part_of_the_disk),
        cmocka_unit_test(media_take_away_what_lies_between),
        cmocka_unit_test(grids_take_away_what_is_marched_through),
        cmocka_unit_test(look_ups_find_what_rays_find),
        cmocka_unit_test(threads_do_not_change_a_bit),
        cmocka_unit_test(features_of_pictures_are_what_rays_find),
        cmocka_unit_test(ground_may_reach_far_beyond_the_texels_of_what_is_small),
        cmocka_unit_test(maps_go_over_to_scenes_that_cast_the_same_shadows),
        cmocka_unit_test(skies_are_not_taken_over),
        cmocka_unit_test(lights_add_up),
        cmocka_unit_test(scenes_without_sun_or_surfaces_need_none),
        cmocka_unit_test(cancelling_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
