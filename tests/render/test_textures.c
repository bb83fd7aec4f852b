/* Pictures on surfaces, and surfaces that are not there whole: means of pictures, what a view sees
 * of them in closed form, and mvpt against vpt, which traces rays where mvpt asks the section. */
#include "tests/testing.h"

#include "base/image.h"
#include "render/transport/surface/surface.h"
#include "render/transport/surface/surface_texture.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { SIDE = 16 };

/* What tests put on a mesh; one at a time. */
static struct {
    uint8_t rgba[SIDE * SIDE * 4];
    lf_pyramid pyramid[3];
    lf_textures textures;
    float uvs[2 * 64];
} dress;

static const lf_texture plain = {.picture = 1, .map = {{1, 0, 0}, {0, 1, 0}}, .scale = 1};

/* Bright and dark, and a coverage that has every share, 0 and 1. */
static void paint(void)
{
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            uint8_t *texel = dress.rgba + 4 * (y * SIDE + x);
            int checker = (x / 4 + y / 4) % 2;
            texel[0] = (uint8_t)(checker ? 250 : 40 + 8 * x);
            texel[1] = (uint8_t)(checker ? 30 + 10 * y : 200);
            texel[2] = 120;
            texel[3] = (uint8_t)(x < 4 ? 0 : x >= 12 ? 255 : 32 * (x - 4));
        }
}

/* Gives a quad of a scene that is not rendered yet a picture: once across its box. */
static void clothe(lf_scene *scene, int number, lf_cover cover, const lf_texture *texture)
{
    lf_mesh *mesh = &scene->meshes[number];
    lf_material *m = &scene->materials[mesh->material];
    const lf_texels texels = {SIDE, SIDE, dress.rgba};
    lf_texels_use use = cover == LF_COVER_OPAQUE ? LF_TEXELS_COLOURS
                        : cover == LF_COVER_MASK ? LF_TEXELS_CUTS
                                                 : LF_TEXELS_COVERS;
    paint();
    for (int v = 0; v < mesh->n_vertices; v++) {
        lf_vec3 p = lf_sub(lf_mesh_vertex(mesh, (uint32_t)v), mesh->box.min),
                size = lf_sub(mesh->box.max, mesh->box.min);
        dress.uvs[2 * v] = p.x / size.x;
        dress.uvs[2 * v + 1] = size.z > size.y ? p.z / size.z : p.y / size.y;
    }
    assert_int_equal(lf_pyramid_make(&texels, use, 0.5f, &dress.pyramid[0]), LF_OK);
    dress.textures = (lf_textures){.set.slot[LF_SLOT_BASE] = *texture,
                                   .pyramid[LF_SLOT_BASE] = &dress.pyramid[0]};
    mesh->uvs = dress.uvs;
    m->textures = &dress.textures;
    m->cover = cover;
    m->alpha = 1.0f;
    m->alpha_cutoff = 0.5f;
    scene->traits &= ~LF_TRAIT_ALPHA;
    scene->traits |= LF_TRAIT_VARYING | (cover != LF_COVER_OPAQUE ? LF_TRAIT_ALPHA : 0);
}

static void undress(lf_scene *scene)
{
    lf_scene_unref(scene);
    lf_pyramid_finish(&dress.pyramid[0]);
}

/* ---------------------------------------------------------------------------------- pictures -- */

/* rgba must outlive it. */
static lf_pyramid pyramid_of(int width, int height, uint8_t *rgba, lf_texels_use use)
{
    const lf_texels texels = {width, height, rgba};
    lf_pyramid p;
    assert_int_equal(lf_pyramid_make(&texels, use, 0.5f, &p), LF_OK);
    return p;
}

static void mean_of(const lf_pyramid *p, int level, double out[4])
{
    for (int c = 0; c < 4; c++)
        out[c] = 0.0;
    for (int y = 0; y < p->height[level]; y++)
        for (int x = 0; x < p->width[level]; x++) {
            float texel[4];
            lf_texture_look_up(&plain, p, ((float)x + 0.5f) / (float)p->width[level],
                               ((float)y + 0.5f) / (float)p->height[level], (float)level, texel);
            for (int c = 0; c < 4; c++)
                out[c] += (double)texel[c] / (p->width[level] * p->height[level]);
        }
}

/* Whatever its sides are. */
static void every_level_has_the_pictures_mean(void **state)
{
    (void)state;
    static const int sides[][2] = {{16, 16}, {13, 7}, {1, 16}, {16, 3}, {1, 1}};
    paint();
    for (int i = 0; i < 5; i++) {
        const lf_texels texels = {sides[i][0], sides[i][1], dress.rgba};
        lf_pyramid p;
        double want[4], got[4];
        assert_int_equal(lf_pyramid_make(&texels, LF_TEXELS_COLOURS, 0, &p), LF_OK);
        mean_of(&p, 0, want);
        for (int level = 1; level < p.n_levels; level++) {
            mean_of(&p, level, got);
            for (int c = 0; c < 4; c++)
                lf_assert_close(got[c], want[c], 0, 2e-5);
        }
        assert_int_equal(p.width[p.n_levels - 1] * p.height[p.n_levels - 1], 1);
        lf_pyramid_finish(&p);
    }
}

/* Light, not codes, is averaged: 0 and 255 make 0.5, whose code is 188. */
static void means_are_taken_of_light(void **state)
{
    (void)state;
    uint8_t two[8] = {0, 0, 0, 255, 255, 255, 255, 255};
    lf_pyramid p = pyramid_of(2, 1, two, LF_TEXELS_COLOURS);
    float out[4];
    lf_texture_look_up(&plain, &p, 0.3f, 0.3f, 5.0f, out);
    lf_assert_close((double)out[0], 0.5, 0, 1e-5);
    lf_pyramid_finish(&p);
}

/* What is not there has no colour: the edge of a leaf does not turn black. */
static void colours_count_by_what_is_covered(void **state)
{
    (void)state;
    uint8_t two[8] = {0, 0, 0, 0, 255, 255, 255, 255};
    lf_pyramid p = pyramid_of(2, 1, two, LF_TEXELS_COVERS);
    float out[4];
    lf_texture_look_up(&plain, &p, 0.3f, 0.3f, 5.0f, out);
    assert_true(out[0] == 1.0f);
    lf_assert_close((double)out[3], 0.5, 0, 1e-5);
    lf_pyramid_finish(&p);
}

/* A frame a texel thick is a share of what it is averaged with, not nothing: a mean of 0.25 would
 * not reach the threshold. Colours are those of what is there. */
static void cut_outs_are_cut_before_they_are_averaged(void **state)
{
    (void)state;
    uint8_t four[16] = {9, 9, 9, 100, 255, 0, 0, 130, 9, 9, 9, 0, 9, 9, 9, 126};
    lf_pyramid p = pyramid_of(2, 2, four, LF_TEXELS_CUTS);
    float out[4];
    lf_texture_look_up(&plain, &p, 0.3f, 0.3f, 1.0f, out);
    lf_assert_close((double)out[3], 0.25, 0, 1e-5);
    lf_assert_close((double)out[0], 1.0, 0, 1e-5);
    lf_texture_look_up(&plain, &p, 0.75f, 0.25f, 0.0f, out);
    assert_true(out[3] == 1.0f);
    lf_texture_look_up(&plain, &p, 0.75f, 0.75f, 0.0f, out); /* 126 is below */
    assert_true(out[3] == 0.0f);
    lf_texture_look_up(&plain, &p, 0.75f, 0.25f, 0.5f, out);
    lf_assert_close((double)out[3], 0.625, 0, 1e-5);
    lf_pyramid_finish(&p);
}

/* Two that lean by 30 degrees either way: their mean has the length cos 30. */
static void a_mean_of_normals_knows_how_far_they_spread(void **state)
{
    (void)state;
    uint8_t two[8] = {191, 128, 238, 255, 64, 128, 238, 255};
    lf_pyramid p = pyramid_of(2, 1, two, LF_TEXELS_NORMALS);
    float out[4];
    lf_texture_look_up(&plain, &p, 0.3f, 0.3f, 1.0f, out);
    lf_assert_close((double)out[3], 1.0 - sqrt(0.75), 0, 3e-3);
    lf_texture_look_up(&plain, &p, 0.3f, 0.3f, 0.0f, out);
    assert_true(out[3] == 0.0f);
    lf_pyramid_finish(&p);
}

/* Density of GGX normals about n, in double, at h. */
static double ggx_at(lf_vec3 n, lf_vec3 h, double alpha)
{
    double c = (double)lf_dot(n, h), k = c * c * (alpha * alpha - 1.0) + 1.0;
    return alpha * alpha / (M_PI * k * k);
}

/* The i-th of n normals whose slopes are Gaussian, by the inverse of their distribution. */
static lf_vec3 bump(int i, int n, double sigma)
{
    double phi = 2.399963 * i, r = sigma * sqrt(-2.0 * log(1.0 - (i + 0.5) / n));
    return lf_normalize(lf_v3((float)(r * cos(phi)), (float)(r * sin(phi)), 1.0f));
}

/* What a hit makes of a texture of normals that covers a triangle of `width`. */
static lf_material seen_from_afar(const uint8_t *rgba, int side, float alpha, float width)
{
    static const float vertices[10] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, uvs[6] = {0, 0, 1, 0, 0, 1},
                       tangents[12] = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
    static const uint32_t corners[3] = {0, 1, 2};
    const lf_texels texels = {side, side, (uint8_t *)(uintptr_t)rgba};
    lf_textures textures = {.set.slot[LF_SLOT_NORMAL] = plain};
    lf_pyramid p;
    assert_int_equal(lf_pyramid_make(&texels, LF_TEXELS_NORMALS, 0, &p), LF_OK);
    textures.pyramid[LF_SLOT_NORMAL] = &p;
    lf_mesh mesh = {.n_vertices = 3,
                    .n_triangles = 1,
                    .vertices = vertices,
                    .triangles = corners,
                    .uvs = uvs,
                    .tangents = tangents};
    lf_material m = {.kind = &lf_surface_principled,
                     .albedo = {1, 1, 1},
                     .roughness = sqrtf(alpha),
                     .metallic = 1,
                     .textures = &textures};
    lf_material_prepare(&m);
    lf_hit hit = {.mesh = &mesh,
                  .material = &m,
                  .u = 0.3f,
                  .v = 0.3f,
                  .front = true,
                  .ng = {0, 0, 1},
                  .ns = {0, 0, 1}};
    lf_hit_vary(&hit, width);
    lf_pyramid_finish(&p);
    hit.own.textures = NULL;
    return hit.own;
}

/* Seen from so far that all of a map's normals are one, the lobe is that of all of them, but for
 * its shape, which stays GGX's: an eighth apart at its peak, a quarter at one and two thirds of
 * their spread. By their mean alone its peak is eight times as high. */
static void normals_far_away_make_a_wider_lobe(void **state)
{
    (void)state;
    enum { N = 64 };
    static uint8_t bumps[N * N * 4];
    const double sigma = 0.12, alpha = 0.04;
    for (int i = 0; i < N * N; i++) {
        lf_vec3 n = bump(i, N * N, sigma);
        bumps[4 * i] = (uint8_t)(127.5f * n.x + 128.0f);
        bumps[4 * i + 1] = (uint8_t)(127.5f * n.y + 128.0f);
        bumps[4 * i + 2] = (uint8_t)(127.5f * n.z + 128.0f);
    }
    lf_material near = seen_from_afar(bumps, N, (float)alpha, 0.0f),
                far = seen_from_afar(bumps, N, (float)alpha, 8.0f);
    const lf_vec3 up = lf_v3(0, 0, 1);
    double wide = (double)(far.roughness * far.roughness);
    lf_assert_close((double)(near.roughness * near.roughness), alpha, 1e-5, 0);
    for (int k = 0; k < 3; k++) {
        lf_vec3 h = lf_normalize(lf_v3(0.04f * (float)k, 0, 1));
        double all = 0.0;
        for (int i = 0; i < N * N; i++)
            all += ggx_at(bump(i, N * N, sigma), h, alpha) / (N * N);
        lf_assert_close(ggx_at(up, h, wide), all, k == 0 ? 0.125 : 0.25, 0);
    }
    assert_true(ggx_at(up, up, alpha) > 8.0 * ggx_at(up, up, wide));
}

static void edges_repeat_mirror_and_stay(void **state)
{
    (void)state;
    uint8_t four[16] = {0};
    for (int i = 0; i < 4; i++)
        four[4 * i] = (uint8_t)(50 * i + 50);
    const lf_texels texels = {4, 1, four};
    lf_pyramid p;
    assert_int_equal(lf_pyramid_make(&texels, LF_TEXELS_NUMBERS, 0, &p), LF_OK);
    /* middles of texels -1 to 8, by number */
    static const int want[LF_WRAPS][10] = {[LF_WRAP_REPEAT] = {3, 0, 1, 2, 3, 0, 1, 2, 3, 0},
                                           [LF_WRAP_MIRROR] = {0, 0, 1, 2, 3, 3, 2, 1, 0, 0},
                                           [LF_WRAP_CLAMP] = {0, 0, 1, 2, 3, 3, 3, 3, 3, 3}};
    for (int wrap = 0; wrap < LF_WRAPS; wrap++)
        for (int i = 0; i < 10; i++) {
            lf_texture t = plain;
            float out[4];
            t.wrap_u = t.wrap_v = (uint8_t)wrap;
            lf_texture_look_up(&t, &p, ((float)i - 0.5f) / 4.0f, 0.5f, 0.0f, out);
            lf_assert_close((double)out[0] * 255.0, 50.0 * want[wrap][i] + 50.0, 0, 1e-3);
            t.nearest = true;
            lf_texture_look_up(&t, &p, ((float)i - 0.7f) / 4.0f, 0.5f, 0.0f, out);
            lf_assert_close((double)out[0] * 255.0, 50.0 * want[wrap][i] + 50.0, 0, 1e-3);
        }
    lf_pyramid_finish(&p);
}

/* ---------------------------------------------------------------------------- in the picture -- */

enum { WIDTH = 24, HEIGHT = 20, VIEWS = 3, BLOCK = 8 };

/* Colour of the poster at a window point, by the means of the tests' pictures; the sky beside it.
 */
static double seen_at(const lf_renderer *r, int view, double x, double y)
{
    double mx, my;
    lf_test_slopes(r, view, x, y, &mx, &my);
    double b = 4.0 * ((view - 1.0) * tan(20.0 / 3.0 * M_PI / 180.0)), px = b + 4.0 * mx,
           py = 4.0 * my;
    float texel[4];
    if (fabs(px) > 1.0 || fabs(py) > 1.0)
        return 1.0;
    lf_texture_look_up(&plain, &dress.pyramid[0], (float)(0.5 + 0.5 * px), (float)(0.5 + 0.5 * py),
                       0.0f, texel);
    return 0.5 * (double)texel[0] + 0.3 * (double)texel[1] + 0.2 * (double)texel[2];
}

static double *poster_truth(const lf_renderer *r)
{
    enum { FINE = 8 };
    double *truth = calloc((size_t)HEIGHT * VIEWS * WIDTH, sizeof *truth), *out = truth;
    for (int row = 0; row < HEIGHT; row++)
        for (int view = 0; view < VIEWS; view++)
            for (int column = 0; column < WIDTH; column++, out++)
                for (int i = 0; i < FINE * FINE; i++)
                    *out += seen_at(r, view, column + (i % FINE + 0.5) / FINE,
                                    row + (i / FINE + 0.5) / FINE) /
                            (FINE * FINE);
    return truth;
}

static void cycles(lf_renderer *r)
{
    lf_test_cycles(r, 8);
}

/* The level looked up is what a pixel averages: here less than a texel. */
static void a_poster_under_an_even_sky_shows_its_picture(void **state)
{
    (void)state;
    static const char *const integrators[] = {"vpt", "mvpt"};
    for (int i = 0; i < 2; i++) {
        lf_scene *scene = lf_test_scene(lf_test_scene_text("poster"));
        clothe(scene, 0, LF_COVER_OPAQUE, &plain);
        lf_renderer *r = lf_test_renderer(scene, integrators[i], WIDTH, HEIGHT, NULL);
        double *truth = poster_truth(r);
        lf_blocks blocks;
        int where = 0;
        lf_test_pictures(r, cycles, LF_ESTIMATOR_CV, 16, 1, BLOCK, &blocks);
        double p = lf_blocks_p(&blocks, truth, 2e-3, &where);
        if (!(p > lf_sidak(LF_FALSE_ALARM, 2 * blocks.n)))
            fail_msg("%s: block %d is %.5f +- %.1g, p %.2g", integrators[i], where,
                     blocks.moments[where].mean, lf_moments_error(&blocks.moments[where]), p);
        /* A negative control: the picture upside down. */
        for (int row = 0; row < HEIGHT / 2; row++)
            for (int k = 0; k < VIEWS * WIDTH; k++) {
                double *a = &truth[row * VIEWS * WIDTH + k],
                       *b = &truth[(HEIGHT - 1 - row) * VIEWS * WIDTH + k], swap = *a;
                *a = *b;
                *b = swap;
            }
        assert_true(lf_blocks_p(&blocks, truth, 2e-3, NULL) < 1e-12);
        lf_blocks_finish(&blocks);
        free(truth);
        lf_renderer_destroy(r);
        undress(scene);
    }
}

/* ------------------------------------------------------------------------------------- veils -- */

/* Black sheets one behind the other, of which a half and a quarter are there, before a sky of 1:
 * (1 - 1/2) (1 - 1/4) come through, from wherever one looks. */
static void sheets_let_through_the_product_of_what_they_lack(void **state)
{
    (void)state;
    static const char *const integrators[] = {"vpt", "mvpt"};
    for (int i = 0; i < 2; i++) {
        lf_scene *scene = lf_test_scene(lf_test_scene_text("two-sheets"));
        for (int m = 0; m < 2; m++) {
            scene->materials[m].cover = LF_COVER_BLEND;
            scene->materials[m].alpha = m == 0 ? 0.5f : 0.25f;
            lf_material_prepare(&scene->materials[m]);
        }
        scene->traits |= LF_TRAIT_ALPHA;
        lf_renderer *r = lf_test_renderer(scene, integrators[i], 16, 12, NULL);
        lf_test_cycles(r, 2);
        double *picture = lf_test_picture(r, LF_ESTIMATOR_MWIS);
        for (int k = 0; k < 16 * 12 * 3; k++)
            lf_assert_close(picture[k], 0.375, 0, 1e-5);
        free(picture);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
}

typedef struct curtain {
    const char *camera, *type, *more, *media;
    lf_cover cover;
} curtain;

static const curtain curtains[] = {
    {"", "diffuse", "'emission': 0", "", LF_COVER_BLEND},
    {"'lens_radius': 0.1, 'focus_distance': 4.2", "principled",
     "'roughness': 0.4, 'metallic': 0.5, 'emission': [0.2, 0.1, 0]", "", LF_COVER_BLEND},
    {"", "principled", "'roughness': 0.2, 'coat': 1", "", LF_COVER_MASK},
    {"", "diffuse", "'emission': 0",
     ", 'volumes': { 'fog': { 'shape': 'box', 'density': 0.5, 'g': 0.3, "
     "'transform': { 'scale': 1.5 } } }",
     LF_COVER_BLEND},
    {"", "principled", "'roughness': 0, 'transmission': 0.5, 'glass': 'sheet'", "", LF_COVER_BLEND},
};

static lf_scene *hang(const curtain *c)
{
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(
        "curtain", "{'camera': {%s}, 'materials': {'cloth': {'type': '%s', %s}}%s}", c->camera,
        c->type, c->more, c->media));
    clothe(scene, 0, c->cover, &plain);
    lf_material_prepare(&scene->materials[scene->meshes[0].material]);
    scene->traits |= scene->materials[scene->meshes[0].material].has_delta ? LF_TRAIT_MIRRORS : 0;
    return scene;
}

static void native(lf_renderer *r)
{
    lf_test_passes(r, 36);
}

static void shared(lf_renderer *r)
{
    lf_test_passes(r, 18);
}

/* Blocks are a sixth of a view wide; 2 % in the whole picture would be seen. */
static void curtains_hide_from_each_view_what_they_cover(void **state)
{
    (void)state;
    static const lf_estimator answers[] = {LF_ESTIMATOR_MIS, LF_ESTIMATOR_CV, LF_ESTIMATOR_MWIS};
    enum { CURTAINS = sizeof curtains / sizeof *curtains };
    for (int i = 0; i < CURTAINS; i++) {
        lf_scene *scene = hang(&curtains[i]);
        lf_renderer *v = lf_test_renderer(scene, "vpt", WIDTH, HEIGHT, NULL),
                    *m = lf_test_renderer(scene, "mvpt", WIDTH, HEIGHT, NULL);
        lf_blocks truth;
        lf_test_pictures(v, native, LF_ESTIMATOR_MIS, 16, 1, BLOCK, &truth);
        for (int a = 0; a < 3; a++) {
            lf_blocks mine;
            int where = 0;
            lf_test_pictures(m, shared, answers[a], 12, 2, BLOCK, &mine);
            double level = lf_sidak(LF_FALSE_ALARM, CURTAINS * 3 * truth.n),
                   p = lf_blocks_welch(&mine, &truth, &where);
            if (!(p > level))
                fail_msg("curtain %d, answer %d: block %d is %.5f +- %.1g, natively %.5f +- %.1g, "
                         "p %.2g",
                         i, a, where, mine.moments[where].mean,
                         lf_moments_error(&mine.moments[where]), truth.moments[where].mean,
                         lf_moments_error(&truth.moments[where]), p);
            assert_true(lf_blocks_welch_injected(&mine, &truth, truth.n - 1, 1.02) < level);
            lf_blocks_finish(&mine);
        }
        lf_blocks_finish(&truth);
        lf_renderer_destroy(v);
        lf_renderer_destroy(m);
        undress(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_level_has_the_pictures_mean),
        cmocka_unit_test(means_are_taken_of_light),
        cmocka_unit_test(colours_count_by_what_is_covered),
        cmocka_unit_test(cut_outs_are_cut_before_they_are_averaged),
        cmocka_unit_test(a_mean_of_normals_knows_how_far_they_spread),
        cmocka_unit_test(normals_far_away_make_a_wider_lobe),
        cmocka_unit_test(edges_repeat_mirror_and_stay),
        cmocka_unit_test(a_poster_under_an_even_sky_shows_its_picture),
        cmocka_unit_test(sheets_let_through_the_product_of_what_they_lack),
        cmocka_unit_test(curtains_hide_from_each_view_what_they_cover),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
