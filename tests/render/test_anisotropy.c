/* Grooves of surfaces: where they go on a mesh, and that both integrators show the same of them. */
#include "tests/testing.h"

#include "render/transport/surface/surface_texture.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 24, height = 16, tile = 8, tiles = 19 };
#define LEVEL lf_sidak(LF_FALSE_ALARM, 6 * tiles)

/* -------------------------------------------------------------------------------------- hits -- */

/* The unit triangle of the xz plane that faces +y: tangent along x, bitangent by `side` along -z or
 * z; seen from above or below. */
static lf_hit hit_of(lf_mesh *mesh, const lf_material *m, bool tangents, float side, bool front)
{
    static const float vertices[10] = {0, 0, 0, 0, 0, 1, 1, 0, 0}, uvs[6] = {0, 0, 0, 1, 1, 0};
    static float t[12];
    static const uint32_t corners[3] = {0, 1, 2};
    for (int i = 0; i < 3; i++)
        memcpy(t + 4 * i, (const float[4]){1, 0, 0, side}, 4 * sizeof *t);
    *mesh = (lf_mesh){.n_vertices = 3,
                      .n_triangles = 1,
                      .vertices = vertices,
                      .triangles = corners,
                      .uvs = uvs,
                      .tangents = tangents ? t : NULL};
    lf_vec3 n = lf_v3(0, front ? 1 : -1, 0);
    return (lf_hit){
        .mesh = mesh, .material = m, .u = 0.3f, .v = 0.3f, .front = front, .ng = n, .ns = n};
}

static lf_material grooved(float strength, float turn)
{
    lf_material m = {.kind = &lf_surface_principled,
                     .albedo = {1, 1, 1},
                     .roughness = 0.4f,
                     .metallic = 1,
                     .ior = 1.5f,
                     .specular = 1,
                     .anisotropy = strength,
                     .anisotropy_rotation = {cosf(turn), sinf(turn)}};
    lf_material_prepare(&m);
    return m;
}

/* The direction in space along which the lobe of a hit is wider. */
static lf_vec3 wider(const lf_hit *hit)
{
    lf_vec3 x, y;
    lf_tangents(hit->ns, &x, &y);
    return lf_madd(lf_scale(x, hit->own.anisotropic.along[0]), hit->own.anisotropic.along[1], y);
}

static void assert_along(const lf_hit *hit, float x, float z)
{
    lf_vec3 w = wider(hit);
    float same = w.x * x + w.z * z;
    lf_assert_close(fabs((double)same), 1, 1e-5, 0);
    lf_assert_close((double)hit->own.anisotropic.alpha[0], 0.16 + 0.84 * 0.25, 1e-5, 0);
    lf_assert_close((double)hit->own.anisotropic.alpha[1], 0.16, 1e-5, 0);
}

static void they_go_by_the_tangents_and_their_angle(void **state)
{
    (void)state;
    const float turn = LF_PI / 6.0f, c = cosf(turn), s = sinf(turn);
    lf_material straight = grooved(0.5f, 0.0f), turned = grooved(0.5f, turn);
    lf_mesh mesh;
    for (int front = 0; front < 2; front++) {
        lf_hit hit = hit_of(&mesh, &straight, true, 1.0f, front);
        assert_true(lf_is_varied(&mesh, &straight));
        lf_hit_vary(&hit, 0.0f);
        assert_along(&hit, 1, 0);
        /* the bitangent is cross(+y, x) = -z on both sides of the surface */
        hit = hit_of(&mesh, &turned, true, 1.0f, front);
        lf_hit_vary(&hit, 0.0f);
        assert_along(&hit, c, -s);
        hit = hit_of(&mesh, &turned, true, -1.0f, front);
        lf_hit_vary(&hit, 0.0f);
        assert_along(&hit, c, s);
    }
}

/* A picture whose direction is (0, 1) and whose depth is a half of all. */
static void a_picture_turns_and_weakens_them(void **state)
{
    (void)state;
    const uint8_t texel[4] = {128, 255, 128, 255};
    const lf_texels texels = {1, 1, (uint8_t *)(uintptr_t)texel};
    lf_textures textures = {
        .set.slot[LF_SLOT_ANISOTROPY] = {.picture = 1, .map = {{1, 0, 0}, {0, 1, 0}}}};
    lf_pyramid p;
    lf_mesh mesh;
    lf_material m = grooved(1.0f, LF_PI / 2.0f);
    assert_int_equal(lf_pyramid_make(&texels, LF_TEXELS_NUMBERS, 0, &p), LF_OK);
    textures.pyramid[LF_SLOT_ANISOTROPY] = &p;
    m.textures = &textures;
    lf_hit hit = hit_of(&mesh, &m, true, 1.0f, true);
    lf_hit_vary(&hit, 0.0f);
    lf_vec3 w = wider(&hit); /* half a turn from the tangent */
    lf_assert_close(fabs((double)w.x), 1, 1e-3, 0);
    lf_assert_close((double)hit.own.anisotropic.alpha[0], 0.16 + 0.84 * pow(128.0 / 255.0, 2.0),
                    1e-4, 0);
    lf_pyramid_finish(&p);
}

/* A wall without tangents: level. A ground without: nothing to go by. */
static void without_tangents_they_are_level(void **state)
{
    (void)state;
    lf_material m = grooved(0.5f, 0.0f);
    lf_mesh mesh;
    lf_hit hit = hit_of(&mesh, &m, false, 1.0f, true);
    lf_hit_vary(&hit, 0.0f);
    assert_true(hit.own.anisotropic.alpha[0] == 0.0f);
    lf_assert_close((double)hit.own.roughness, 0.4, 1e-6, 0);
    hit = hit_of(&mesh, &m, false, 1.0f, true);
    hit.ns = lf_normalize(lf_v3(0.6f, 0.5f, 0.3f));
    lf_hit_vary(&hit, 0.0f);
    lf_vec3 w = wider(&hit);
    lf_assert_close((double)w.y, 0, 0, 1e-5);
    lf_assert_close((double)lf_dot(w, hit.ns), 0, 0, 1e-5);
}

/* ---------------------------------------------------------------------------------- pictures -- */

/* A patch of the ball and the wall of brushed-steel. */
#define SCENE(steel) "{'materials': {'steel': {" steel "}}}"

/* The same by both integrators; other angles or none are other pictures. */
static void both_integrators_show_the_same(void **state)
{
    static const struct {
        const char *patch, *integrator;
        bool same;
    } cases[] = {{"{}", "mvpt", true},
                 {SCENE("'anisotropy_rotation': -60"), "mvpt", false},
                 {SCENE("'anisotropy': null, 'anisotropy_rotation': null"), "mvpt", false}};
    lf_blocks truth[2], seen[2];
    (void)state;
    lf_test_two_answers(lf_test_scene(lf_test_scene_text("brushed-steel")), "vpt", width, height,
                        tile, 1, truth);
    for (int i = 0; i < 3; i++) {
        lf_test_two_answers(
            lf_test_scene(lf_test_scene_patched("brushed-steel", "%s", cases[i].patch)),
            cases[i].integrator, width, height, tile, 2, seen);
        lf_test_assert_answers(seen, &truth[1], LEVEL, cases[i].same);
    }
    for (int j = 0; j < 2; j++)
        lf_blocks_finish(&truth[j]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(they_go_by_the_tangents_and_their_angle),
        cmocka_unit_test(a_picture_turns_and_weakens_them),
        cmocka_unit_test(without_tangents_they_are_level),
        cmocka_unit_test(both_integrators_show_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
