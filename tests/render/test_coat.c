/* A coat over a base whose normals a picture bends: it lies about its own normal, which is that of
 * the mesh or of a picture of its own. */
#include "tests/testing.h"

#include "render/transport/surface/surface_texture.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 24, height = 16, tile = 8, tiles = 19 };
#define LEVEL lf_sidak(LF_FALSE_ALARM, 4 * tiles)

/* What tests put on a mesh: normals of a base and of a coat that lean by 30 degrees, one to the
 * right in its picture and one upwards; of the second picture's other half they lean down. */
static struct {
    uint8_t base[4], coat[8];
    lf_pyramid pyramid[2];
    lf_textures textures;
    float uvs[8], tangents[16];
} dress;

static void dress_up(bool base, bool coat)
{
    const uint8_t half = 128, up = 237 /* cos 30 */, aside = 191 /* sin 30 */, other = 64;
    const lf_texture plain = {
        .picture = 1, .map = {{1, 0, 0}, {0, 1, 0}}, .nearest = true, .scale = 1};
    memcpy(dress.base, (const uint8_t[4]){aside, half, up, 255}, 4);
    memcpy(dress.coat, (const uint8_t[8]){half, aside, up, 255, half, other, up, 255}, 8);
    const lf_texels texels[2] = {{1, 1, dress.base}, {2, 1, dress.coat}};
    const lf_slot slots[2] = {LF_SLOT_NORMAL, LF_SLOT_COAT_NORMAL};
    dress.textures = (lf_textures){.layered = true};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(lf_pyramid_make(&texels[i], LF_TEXELS_NORMALS, 0, &dress.pyramid[i]),
                         LF_OK);
        if (i == 0 ? base : coat) {
            dress.textures.set.slot[slots[i]] = plain;
            dress.textures.pyramid[slots[i]] = &dress.pyramid[i];
        }
    }
}

static void undress(void)
{
    for (int i = 0; i < 2; i++)
        lf_pyramid_finish(&dress.pyramid[i]);
}

static lf_material coated(float roughness, bool black)
{
    lf_material m = {.kind = &lf_surface_principled,
                     .albedo = black ? lf_v3(0, 0, 0) : lf_v3(0.7f, 0.2f, 0.1f),
                     .roughness = 0.5f,
                     .ior = 1.5f,
                     .specular = black ? 0.0f : 1.0f,
                     .specular_tint = {1, 1, 1},
                     .coat = 1,
                     .coat_roughness = roughness,
                     .textures = &dress.textures};
    lf_material_prepare(&m);
    return m;
}

/* In the xy plane, facing +z. */
static lf_hit hit_on(lf_mesh *mesh, const lf_material *m, bool front)
{
    static const float vertices[10] = {0, 0, 0, 1, 0, 0, 0, 1, 0},
                       uvs[6] = {0, 0, 0.4f, 0, 0, 0.4f},
                       tangents[12] = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
    static const uint32_t corners[3] = {0, 1, 2};
    *mesh = (lf_mesh){.n_vertices = 3,
                      .n_triangles = 1,
                      .vertices = vertices,
                      .triangles = corners,
                      .uvs = uvs,
                      .tangents = tangents};
    lf_vec3 n = lf_v3(0, 0, front ? 1 : -1);
    return (lf_hit){
        .mesh = mesh, .material = m, .u = 0.3f, .v = 0.3f, .front = front, .ng = n, .ns = n};
}

static lf_vec3 coat_normal_of(const lf_hit *hit)
{
    lf_vec3 x, y;
    lf_tangents(hit->ns, &x, &y);
    return lf_from_frame(x, y, hit->ns, hit->own.coat_normal);
}

static void assert_vector(lf_vec3 v, double x, double y, double z)
{
    lf_assert_close((double)v.x, x, 0, 0.01);
    lf_assert_close((double)v.y, y, 0, 0.01);
    lf_assert_close((double)v.z, z, 0, 0.01);
}

static void a_coat_has_the_normal_of_the_mesh_or_its_own(void **state)
{
    (void)state;
    const double c = sqrt(0.75);
    lf_mesh mesh;
    for (int front = 0; front < 2; front++) {
        const double side = front ? 1 : -1;
        dress_up(true, false);
        lf_material m = coated(0.0f, false);
        lf_hit hit = hit_on(&mesh, &m, front);
        lf_hit_vary(&hit, 0.0f);
        assert_vector(hit.ns, side * 0.5, 0, side * c);
        assert_vector(coat_normal_of(&hit), 0, 0, side);
        undress();
        dress_up(true, true);
        m = coated(0.0f, false);
        hit = hit_on(&mesh, &m, front);
        lf_hit_vary(&hit, 0.0f);
        assert_vector(hit.ns, side * 0.5, 0, side * c);
        assert_vector(coat_normal_of(&hit), 0, side * 0.5, side * c);
        undress();
        dress_up(false, true);
        m = coated(0.0f, false);
        hit = hit_on(&mesh, &m, front);
        lf_hit_vary(&hit, 0.0f);
        assert_vector(hit.ns, 0, 0, side);
        assert_vector(coat_normal_of(&hit), 0, side * 0.5, side * c);
        undress();
    }
}

static void a_smooth_coat_mirrors_about_the_meshs_normal(void **state)
{
    (void)state;
    lf_mesh mesh;
    lf_delta out[LF_MAX_DELTAS];
    dress_up(true, false);
    const lf_material m = coated(0.0f, false);
    lf_hit hit = hit_on(&mesh, &m, true);
    lf_hit_vary(&hit, 0.0f);
    const lf_vec3 wo = lf_normalize(lf_v3(0.6f, 0.3f, 0.8f));
    assert_int_equal(m.kind->deltas(&hit.own, hit.ng, hit.ns, wo, true, out), 1);
    assert_vector(out[0].wi, -(double)wo.x, -(double)wo.y, (double)wo.z);
    undress();
}

/* A coat on what is black, over bent normals, is a coat over straight ones. */
static void what_lies_below_does_not_turn_a_coat(void **state)
{
    (void)state;
    int compared = 0;
    lf_mesh mesh;
    dress_up(true, false);
    const lf_material m = coated(0.3f, true);
    lf_material flat = m;
    flat.textures = NULL;
    flat.roughness = 0.5f;
    lf_material_prepare(&flat);
    lf_hit hit = hit_on(&mesh, &m, true);
    lf_hit_vary(&hit, 0.0f);
    for (int i = 0; i < 400; i++) {
        float a = 0.05f + 0.9f * (float)(i % 20) / 20.0f,
              b = 0.05f + 0.9f * (float)(i / 20) / 20.0f, sa = sqrtf(1.0f - a * a),
              sb = sqrtf(1.0f - b * b), p = 0.7f * (float)i, q = 1.9f * (float)i;
        lf_vec3 wo = lf_v3(sa * cosf(p), sa * sinf(p), a),
                wi = lf_v3(sb * cosf(q), sb * sinf(q), b), f, g;
        (void)m.kind->eval(&hit.own, hit.ns, wo, wi, &f);
        (void)m.kind->eval(&flat, lf_v3(0, 0, 1), wo, wi, &g);
        if (lf_dot(hit.ns, wo) > 1e-3f) {
            lf_assert_close((double)f.x, (double)g.x, 1e-3, 1e-6);
            compared += g.x > 1e-3f;
        }
    }
    assert_true(compared > 50);
    undress();
}

/* ---------------------------------------------------------------------------------- pictures -- */

/* The card of lacquered-card, whose base leans to its right. */
static lf_scene *lacquered(bool coat)
{
    lf_scene *scene = lf_test_scene(lf_test_scene_text("lacquered-card"));
    lf_mesh *mesh = &scene->meshes[0];
    lf_material *m = &scene->materials[mesh->material];
    dress_up(true, coat);
    lf_vec3 a = lf_mesh_vertex(mesh, 0), x = lf_normalize(lf_sub(lf_mesh_vertex(mesh, 1), a));
    for (int v = 0; v < 4; v++) {
        lf_vec3 p = lf_sub(lf_mesh_vertex(mesh, (uint32_t)v), a);
        memcpy(dress.tangents + 4 * v, (const float[4]){x.x, x.y, x.z, 1}, 4 * sizeof(float));
        dress.uvs[2 * v] = 0.5f * lf_dot(p, x);
        dress.uvs[2 * v + 1] = 0.0f;
    }
    mesh->uvs = dress.uvs;
    mesh->tangents = dress.tangents;
    m->textures = &dress.textures;
    lf_material_prepare(m);
    scene->traits |= LF_TRAIT_VARYING;
    return scene;
}

/* The second is another picture: its coat leans as well. */
static void both_integrators_show_the_same(void **state)
{
    lf_blocks truth[2], seen[2];
    (void)state;
    lf_test_two_answers(lacquered(false), "vpt", width, height, tile, 1, truth);
    undress();
    for (int i = 0; i < 2; i++) {
        lf_test_two_answers(lacquered(i == 1), "mvpt", width, height, tile, 2, seen);
        undress();
        lf_test_assert_answers(seen, &truth[1], LEVEL, i == 0);
    }
    for (int j = 0; j < 2; j++)
        lf_blocks_finish(&truth[j]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_coat_has_the_normal_of_the_mesh_or_its_own),
        cmocka_unit_test(a_smooth_coat_mirrors_about_the_meshs_normal),
        cmocka_unit_test(what_lies_below_does_not_turn_a_coat),
        cmocka_unit_test(both_integrators_show_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
