/* Every table of quilt/kernel/kernel.h equals the plain one, bit for bit. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/kernel/kernel_place.h"

#define MOST 1000

static uint32_t random_bits(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*seed >> 32);
}

/* From lengths without a whole vector to several and a rest. */
static size_t length(int i)
{
    return i < 70 ? (size_t)i : (size_t)(MOST - i);
}

static void weaving_is_the_same_copy(void **state)
{
    (void)state;
    static uint8_t from[65536 + LF_INTERLACE_SLACK], view[MOST], expected[MOST], got[MOST + 1];
    static uint16_t place[MOST];
    uint64_t seed = lf_test_seed();
    for (size_t i = 0; i < sizeof from; i++)
        from[i] = (uint8_t)random_bits(&seed);
    for (int t = 1; lf_quilt_kernels_at(t); t++) {
        for (int i = 0; i < 140; i++) {
            uint32_t stride = 1 + random_bits(&seed) % 256;
            for (int k = 0; k < MOST; k++) {
                view[k] = (uint8_t)random_bits(&seed);
                place[k] = (uint16_t)(random_bits(&seed) % (65536 - 255 * stride));
            }
            if (i == 0)
                place[0] = (uint16_t)(65535 - view[0] * stride);
            size_t n = length(i);
            memset(got, 0xcc, sizeof got);
            lf_quilt_kernels_c.interlace(n, view, place, stride, from, expected);
            lf_quilt_kernels_at(t)->interlace(n, view, place, stride, from, got);
            assert_memory_equal(got, expected, n);
            assert_int_equal(got[n], 0xcc);
        }
    }
}

static lf_places random_places(uint64_t *seed, double *across, int i)
{
    lf_places p = {.across = across, .pitch = 1 + random_bits(seed) % 400, .from_right = i % 2};
    p.center = random_bits(seed) % 1000 * 0.01 - 5;
    p.n_views = i % 3 == 0 ? 256 : 1 + (int)(random_bits(seed) % 256);
    for (int k = 0; k < MOST; k++)
        across[k] = random_bits(seed) * (1.0 / 4294967296.0);
    for (int k = 0; k < 6; k++)
        p.along[k] = random_bits(seed) * (0.5 / 4294967296.0) - 0.25;
    if (i % 5 == 0) { /* the very borders of the lens periods */
        p.pitch = 64;
        p.center = 0.5;
        memset(p.along, 0, sizeof p.along);
        for (int k = 0; k < MOST; k++)
            across[k] = (double)(random_bits(seed) % 4096) / 4096;
    }
    return p;
}

static void views_are_the_same(void **state)
{
    (void)state;
    static double across[MOST];
    uint64_t seed = lf_test_seed();
    for (int t = 1; lf_quilt_kernels_at(t); t++) {
        for (int i = 0; i < 140; i++) {
            lf_places p = random_places(&seed, across, i);
            uint8_t expected8[MOST], got8[MOST + 1];
            uint16_t expected16[MOST], got16[MOST + 1];
            size_t n = length(i);
            memset(got8, 0xcc, sizeof got8);
            lf_quilt_kernels_c.views8(&p, n, expected8);
            lf_quilt_kernels_at(t)->views8(&p, n, got8);
            assert_memory_equal(got8, expected8, n);
            assert_int_equal(got8[n], 0xcc);
            p.n_views *= 255;
            memset(got16, 0xcc, sizeof got16);
            lf_quilt_kernels_c.views16(&p, n, expected16);
            lf_quilt_kernels_at(t)->views16(&p, n, got16);
            assert_memory_equal(got16, expected16, n * sizeof *got16);
            assert_int_equal(got16[n], 0xcccc);
        }
    }
}

/* A table of 255 random codes, as tone.c builds it. */
static void random_table(uint64_t *seed, uint32_t *entries, lf_tone_table *out)
{
    *out = (lf_tone_table){
        .entries = entries, .low = 0x3a000000, .high = 0x3a000000 + (255 << 15), .shift = 15};
    for (uint32_t b = 0; b < 256; b++)
        entries[b] = b | (random_bits(seed) % 32769) << 8;
}

static void codes_are_the_same(void **state)
{
    (void)state;
    static const uint32_t corners[] = {0,          0x80000000, 0x7f800000, 0xff800000, 0x7fc00000,
                                       0xffc00000, 0x7f800001, 0x7fffffff, 0xffffffff, 0x00000001,
                                       0x80000001, 0x3a000000, 0x39ffffff, 0x3a7f8000};
    const size_t n_corners = sizeof corners / sizeof corners[0];
    uint64_t seed = lf_test_seed();
    uint32_t entries[256];
    for (int t = 1; lf_quilt_kernels_at(t); t++) {
        for (int i = 0; i < 140; i++) {
            lf_tone_table table;
            random_table(&seed, entries, &table);
            float in[MOST];
            uint8_t expected[MOST], got[MOST + 1];
            size_t n = length(i);
            for (size_t k = 0; k < MOST; k++) {
                uint32_t bits = k % 7 == 0 ? corners[k / 7 % n_corners]
                                           : 0x39f00000 + random_bits(&seed) % 0xa00000;
                memcpy(&in[k], &bits, sizeof bits);
            }
            memset(got, 0xcc, sizeof got);
            lf_quilt_kernels_c.tone(&table, n, in, expected);
            lf_quilt_kernels_at(t)->tone(&table, n, in, got);
            assert_memory_equal(got, expected, n);
            assert_int_equal(got[n], 0xcc);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weaving_is_the_same_copy),
        cmocka_unit_test(views_are_the_same),
        cmocka_unit_test(codes_are_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
