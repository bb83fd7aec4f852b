/* The scenes of `quiltbench table` and `quiltbench views` are fixed: numbers that were published belong to these bytes. Who changes one on
 * purpose changes its hash here and measures anew. */
#include "tests/testing.h"

#include <nettle/sha2.h>

#include "base/alloc.h"
#include "base/file.h"

static const struct {
    const char *name, *sha256;
} files[] = {
    {"bench/cloud-dense.json", "712a2fc2b490e798900d70545f5ed5292758b66922fcaae3121266fdf24fcbc6"},
    {"bench/cloud-g060.json", "5364f70b750aa13b40cdbe27f084ac12830df709be99b86b9d5a26dae9c1a1e8"},
    {"bench/cloud-g085.json", "c362a8f3126ae679abcc819d6ace1d004176ccbabb2208e7d2273beda254870e"},
    {"bench/cloud-g098.json", "06fc1387960f5f9e0e80bea069cb3060c399b6ee2c08efadf0654ec51ee7a35e"},
    {"bench/cloud-mesh.json", "ed4be306921f2aa794ff244ef412daeec942a4bfc2d20e7004cc11153027a261"},
    {"bench/cloud-thin.json", "20c54a0d45937bb9dcb3ea249a55daf0cecba075510699930662ce0027a45999"},
    {"bench/meshes-diffuse.json", "8086eb865b1db88c8e827e16e865e393c987cee7f73b691fe949728644c84142"},
    {"bench/meshes-glossy-ground.json", "4ed0173d5fc27b53ab993cffb7b166e522bb5d8a88172841d0b99fb1e1d952e1"},
    {"bench/meshes-glossy.json", "0dab115fd9b1981007dc863b03e3d82fdab1977dc7738c4ea89263dbe3bdf91e"},
    {"bench/meshes-glossy-ground-sky.json", "b7e72569a51b90c6198fa1d8bba53b1f693bd8182b01498e58b52bcf2748ba03"},
    {"bench/meshes-glossy-sky.json", "8a2b7a0528c5461ba2e559a5c0fefb1ced04f259e1a5cd4079fa8e36fdde5cbf"},
    {"bench/meshes-mirror.json", "8eee579a78160c5776c425e0b5f4d07f494029f7d14616da7d3de61b1c7c8b8d"},
    {"bench/mixed-cubes.json", "5b7656255fb4033af0aa0be456a8b34b26751b76e22594eff0120bfb9702dd5e"},
    {"cloud.json", "31a78b7de5f891b1c18e9404644fdc498433f28d15a1a6ecf685c126dee99459"},
    {"cloud.vdb", "7171f8d1f6b5174c02a4314223f9ad852514e6f75c948dff386a72736e5e0a45"},
    {"knot.obj", "ffdb70025bfa3b984d985ede28f137367750adee10f20645aaeb3f9c8f989009"},
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

        lf_assert_ok(lf_file_read(scene_file(files[i].name), NULL, 1 << 26, &data, &size, &err), &err);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_of_the_benchmarks_are_fixed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
