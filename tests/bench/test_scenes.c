/* The shipped scenes are fixed: numbers that were published belong to these bytes, and a change
 * that moves code about leaves their films as they were. Who changes a scene or what is drawn from
 * it on purpose changes the hash here and measures anew. */
#include "tests/testing.h"

#include <gnu/libc-version.h>

#include <nettle/sha2.h>

#include "base/alloc.h"
#include "base/file.h"
#include "render/render.h"

static const struct {
    const char *name, *sha256;
} files[] = {
    {"bench/checker.json", "d1c3439155befb8bca1931313b8caceb6d45be5fe09c69adb94fec7e35a5119e"},
    {"bench/checker.png", "f2b3e276ab0e8b04f53641501eb3032d40cbad508fe55fb312c8ccaaa1dd3f3e"},
    {"bench/cloud-dense.json", "712a2fc2b490e798900d70545f5ed5292758b66922fcaae3121266fdf24fcbc6"},
    {"bench/cloud-g060.json", "5364f70b750aa13b40cdbe27f084ac12830df709be99b86b9d5a26dae9c1a1e8"},
    {"bench/cloud-g085.json", "c362a8f3126ae679abcc819d6ace1d004176ccbabb2208e7d2273beda254870e"},
    {"bench/cloud-g098.json", "06fc1387960f5f9e0e80bea069cb3060c399b6ee2c08efadf0654ec51ee7a35e"},
    {"bench/cloud-mesh.json", "ed4be306921f2aa794ff244ef412daeec942a4bfc2d20e7004cc11153027a261"},
    {"bench/cloud-thin.json", "20c54a0d45937bb9dcb3ea249a55daf0cecba075510699930662ce0027a45999"},
    {"bench/fog-post.json", "c054438b6ecaba4b0c48ce872b03cafac8060896a1b0d227e4b0c1b6efa138bd"},
    {"bench/glass-sun.json", "893de4882af76d632e7add762cad7af893d7076679c2b77f6f239e34d0f8b0f9"},
    {"bench/meshes-diffuse.json",
     "8086eb865b1db88c8e827e16e865e393c987cee7f73b691fe949728644c84142"},
    {"bench/meshes-glossy-ground-sky.json",
     "b7e72569a51b90c6198fa1d8bba53b1f693bd8182b01498e58b52bcf2748ba03"},
    {"bench/meshes-glossy-ground.json",
     "4ed0173d5fc27b53ab993cffb7b166e522bb5d8a88172841d0b99fb1e1d952e1"},
    {"bench/meshes-glossy-sky.json",
     "8a2b7a0528c5461ba2e559a5c0fefb1ced04f259e1a5cd4079fa8e36fdde5cbf"},
    {"bench/meshes-glossy.json",
     "0dab115fd9b1981007dc863b03e3d82fdab1977dc7738c4ea89263dbe3bdf91e"},
    {"bench/meshes-mirror.json",
     "8eee579a78160c5776c425e0b5f4d07f494029f7d14616da7d3de61b1c7c8b8d"},
    {"bench/mirror-sun.json", "87346b781cbbb1fc80391ae8df64cf10fc2ee8fac97ff859eec31e1b1859a96d"},
    {"bench/mixed-cubes.json", "5b7656255fb4033af0aa0be456a8b34b26751b76e22594eff0120bfb9702dd5e"},
    {"bench/room-shade.json", "026175545ed2622209dbdb8f049783870cfee17a73d4737c6ee0f0c91f2c0df1"},
    {"bench/room-window.json", "0e968875cd1f0e4d7076d0e8ce2e7d9eaf6c149c12c6d5ff252e13025a0e1412"},
    {"bench/rough-mirror-sun.json",
     "c33e38ce688899a6fc3217f593d80c128744cacbd38216aa8dec2aeddd70aa99"},
    {"bench/textured-sky.json", "6119b35025f758d08232d6601188229f2df0e8fdbe5809f1856084956f9dca6e"},
    {"bench/turning.json", "97bc7f20d96645c1e49e7b852d27f8273e7adb23009a648325bd8267b7b9072c"},
    {"cloud.json", "ab33be9b975ba3be6a611615c5d5afbdb8f24430c6109120dc41ef87a1858942"},
    {"cloud.vdb", "7171f8d1f6b5174c02a4314223f9ad852514e6f75c948dff386a72736e5e0a45"},
    {"fire.json", "75011805ba6a73708458587b4fa615fa2f2988c41cf51c08b429b62f26c87f9f"},
    {"fire.vdb", "adee497445590f06f15cf1aeb5906dbbf38cea74126e9083c199c6bc485079f7"},
    {"knot.obj", "ffdb70025bfa3b984d985ede28f137367750adee10f20645aaeb3f9c8f989009"},
    {"sky.hdr", "4dafa27dee2e28532877242fd9921971597f894a4f154631885b478bc082bdf8"},
    {"still.glb", "f9912a19293ae9bc350ca6a5b0433062a69ff1ac51c9034387722b4d3f6fc1fc"},
};

/* Where make puts scenes: beside the folder of the variant, or in the one O= names. */
static const char *scene_file(const char *name)
{
    char relative[PATH_MAX];
    snprintf(relative, sizeof relative, "../scenes/%s", name);
    const char *beside = lf_test_built(relative);
    return access(beside, R_OK) == 0 ? beside : lf_test_built(relative + 3);
}

static void hash(const char *data, size_t size, char out[2 * SHA256_DIGEST_SIZE + 1])
{
    uint8_t digest[SHA256_DIGEST_SIZE];
    struct sha256_ctx context;
    sha256_init(&context);
    sha256_update(&context, size, (const uint8_t *)data);
    sha256_digest(&context, sizeof digest, digest);
    for (size_t i = 0; i < sizeof digest; i++)
        snprintf(out + 2 * i, 3, "%02x", digest[i]);
}

static void scenes_of_the_benchmarks_are_fixed(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        char *data = NULL;
        size_t size = 0;
        lf_error err = {0};
        char text[2 * SHA256_DIGEST_SIZE + 1];
        lf_assert_ok(lf_file_read(scene_file(files[i].name), NULL, 1 << 26, &data, &size, &err),
                     &err);
        hash(data, size, text);
        if (strcmp(text, files[i].sha256) != 0)
            fail_msg("%s: sha256 is %s, not %s", files[i].name, text, files[i].sha256);
        if (i == 0) { /* a single bit shows */
            data[size / 2] ^= 1;
            hash(data, size, text);
            assert_string_not_equal(text, files[i].sha256);
        }
        lf_free(data);
    }
}

enum { MACHINES = 4 };
static const bool is_wide[MACHINES] = {false, true, false, true};
/* From glibc 2.41 on expm1f, log1pf, atan2f and others are rounded correctly (Debian 13).
 * Embree 3.13 and 4.3 give the same bytes. */
static const bool is_exact[MACHINES] = {false, false, false, true};

/* Films of 24 x 18 pixels and all views: one and a half cycles of passes, then what the live
 * picture adds. */
static const struct {
    const char *scene, *integrator;
    /* By machine: AVX2 (which one was not written down), AVX-512 (Zen 5), AVX2 (Zen 3), AVX-512 and
     * exact functions (Zen 5). The last bits of a hit differ by what Embree chooses; what differs
     * between the two with AVX2 is not known. NULL: no such machine has been there since the film
     * changed; the test then says what it is. */
    const char *sha256[MACHINES];
} films[] = {
    {"first-light.json",
     "mvpt",
     {NULL, "d00aa9b163c9088f0bf3c4e26751c9d5494f1fb6580b4992616236b49ab9e340", NULL, NULL}},
    {"first-light.json",
     "vpt",
     {NULL, "ce0800f43abf2f8d9991cfa11ed8b50df3318b0c282e1479a81178443f1a63b8", NULL, NULL}},
    {"first-light.json",
     "amvpt",
     {NULL, "d00aa9b163c9088f0bf3c4e26751c9d5494f1fb6580b4992616236b49ab9e340", NULL, NULL}},
    {"cloud.json",
     "mvpt",
     {NULL, "cf0213e4b5300a70362acb99c2ebbefc09fe133fd2aefd9bab335b4a46b4349e", NULL, NULL}},
    {"fog.json",
     "mvpt",
     {NULL, "3ac984ab05bafd3fd2fe89c8ef7764885be8e94ea90e3eab74ce4205182ff94b", NULL, NULL}},
    {"fog.json",
     "vpt",
     {NULL, "8da8cc807d1c67a464ed0dc2304f7c5d45f0917aa03072552d471421ed563743", NULL, NULL}},
    {"spheres.json",
     "mvpt",
     {NULL, "5ee8f0e2a64a26c2846a09d95fd6df7a265823ea127534008664a69c91bf602e", NULL, NULL}},
    {"motion.json",
     "mvpt",
     {NULL, "322d349b445aad540a138a352a07b6b6240647c1f73be3c94d50659548c82556", NULL, NULL}},
    {"bench/cloud-g085.json",
     "mvpt",
     {NULL, "09a92dbafb483febfa6cc50418c11f02d87c99d0ede7cd9f6cb1e92c6516b6d1", NULL, NULL}},
    {"bench/cloud-mesh.json",
     "mvpt",
     {NULL, "64420fd8e25a6205c46908d1c8c026b411fc4e5542460090ab61b9d2d9facd64", NULL, NULL}},
    {"bench/meshes-glossy-ground-sky.json",
     "mvpt",
     {NULL, "d0a2de8909b7aa980b43ccbad135ba1b5b21a74f604996896ea070f86534c61c", NULL, NULL}},
    {"bench/meshes-glossy.json",
     "vpt",
     {NULL, "f5c2e50e5cfc17875b7100cc51e8e589e85cdefec3995675645e6af619ef29ba", NULL, NULL}},
    {"bench/meshes-mirror.json",
     "mvpt",
     {NULL, "95db4d80446442ff5710f253926976784d24cc66df89b67dc8772ec1101d6bf8", NULL, NULL}},
    {"bench/mixed-cubes.json",
     "mvpt",
     {NULL, "b5503b993858bad378b3b88b5fbdd85f8bf277d14f7bea4317e4b53a0f0c1b46", NULL, NULL}},
};

/* What all estimators answer and what is said of their error, in one run of bytes; free(). */
static char *answers(const lf_renderer *renderer, size_t pixels, size_t *out_size)
{
    size_t picture = pixels * 3 * sizeof(float) + pixels;
    char *out = calloc(3, picture + sizeof(double)), *p = out;
    assert_non_null(out);
    for (int e = LF_ESTIMATOR_MWIS; e <= LF_ESTIMATOR_CV; e++, p += picture + sizeof(double)) {
        uint8_t *flags = (uint8_t *)p + pixels * 3 * sizeof(float);
        lf_assert_ok(lf_renderer_resolve(renderer, (lf_estimator)e, (float *)(void *)p, flags),
                     NULL);
        double bound = lf_renderer_error_bound(renderer, (lf_estimator)e, LF_ERROR_ALPHA, NULL);
        memcpy(p + picture, &bound, sizeof bound);
    }
    *out_size = 3 * (picture + sizeof(double));
    return out;
}

static void hash_film(lf_pool *pool, const char *name, const char *integrator, uint64_t seed,
                      char out[2 * SHA256_DIGEST_SIZE + 1])
{
    lf_scene *scene = NULL;
    lf_renderer *renderer = NULL;
    lf_error err = {0};
    size_t size = 0;
    lf_assert_ok(lf_scene_load(scene_file(name), NULL, NULL, &scene, &err), &err);
    lf_render_settings settings = {.skip = LF_SKIP_ALL,
                                   .camera = *lf_scene_camera(scene),
                                   .width = 24,
                                   .height = 18,
                                   .integrator = integrator};
    settings.seed = seed;
    lf_assert_ok(lf_renderer_create(scene, &settings, pool, &renderer, &err), &err);
    int n_views = settings.camera.n_views;
    lf_assert_ok(lf_renderer_passes(renderer, NULL, n_views * 3 / 2, true, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_renderer_pass_filling(renderer, &(lf_part){.row_step = 2}, n_views / 3, 0, NULL,
                                          NULL, NULL),
                 NULL);
    char *bytes = answers(renderer, (size_t)n_views * 24 * 18, &size);
    hash(bytes, size, out);
    free(bytes);
    lf_renderer_destroy(renderer);
    lf_scene_unref(scene);
}

static bool has_exact_functions(void)
{
    int major = 0, minor = 0;
    assert_int_equal(sscanf(gnu_get_libc_version(), "%d.%d", &major, &minor), 2);
    return major > 2 || minor >= 41;
}

static void films_of_the_shipped_scenes_are_fixed(void **state)
{
    (void)state;
    lf_pool *pool = NULL;
    char text[2 * SHA256_DIGEST_SIZE + 1], other[2 * SHA256_DIGEST_SIZE + 1];
    bool same[MACHINES];
#ifdef __x86_64__
    if (!__builtin_cpu_supports("avx2"))
        skip();
    bool wide = __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
#else
    bool wide = false;
    skip();
#endif
    const bool exact = has_exact_functions();
    bool any = false;
    for (int k = 0; k < MACHINES; k++) {
        same[k] = is_wide[k] == wide && is_exact[k] == exact;
        any = any || same[k];
    }
    if (!any)
        skip(); /* nobody has written down what such a machine makes */
    lf_assert_ok(lf_pool_create(2, &pool), NULL);
    hash_film(pool, films[0].scene, films[0].integrator, 2, other);
    for (size_t i = 0; i < sizeof films / sizeof films[0]; i++) {
        hash_film(pool, films[i].scene, films[i].integrator, 1, text);
        bool agrees = false;
        for (int k = 0; k < MACHINES; k++) {
            const char *known = films[i].sha256[k];
            const bool is_it = known && strcmp(text, known) == 0;
            agrees = agrees || (is_it && same[k]);
            same[k] = same[k] && (is_it || !known);
        }
        if (!agrees)
            print_error("{\"%s\", \"%s\", \"%s\"},\n", films[i].scene, films[i].integrator, text);
        if (i == 0) /* another seed shows */
            assert_string_not_equal(text, other);
    }
    lf_pool_destroy(pool);
    any = false;
    for (int k = 0; k < MACHINES; k++)
        any = any || same[k];
    assert_true(any);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_of_the_benchmarks_are_fixed),
        cmocka_unit_test(films_of_the_shipped_scenes_are_fixed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
