/* Prints a hash of what each portable part makes of pseudo-random inputs: one line each, the same
 * on every machine (tests/arm64.sh compares). On standard error, the kernels that were in use. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/quilt.h"
#include "render/transport/lanes/depth_kernel.h"
#include "tests/render/fans.h"

enum { VIEWS = 45, WIDTH = 60, HEIGHT = 80, PIXELS = 100 };

/* FNV-1a. */
static uint64_t mix(uint64_t hash, const void *data, size_t n)
{
    const unsigned char *bytes = data;
    for (size_t i = 0; i < n; i++)
        hash = (hash ^ bytes[i]) * 0x100000001b3u;
    return hash;
}

static const uint64_t start = 0xcbf29ce484222325u;

static void say(const char *what, uint64_t hash)
{
    printf("%-24s %016llx\n", what, (unsigned long long)hash);
}

static void demand(bool holds, const char *what)
{
    if (holds)
        return;
    fprintf(stderr, "results: %s\n", what);
    exit(2);
}

static void samplers(void)
{
    uint64_t hash = start;
    for (uint32_t i = 0; i < 4096; i++) {
        lf_sampler s;
        lf_sampler_init(&s, i % 2 ? LF_SAMPLER_OWEN : LF_SAMPLER_INDEPENDENT, 77 + i / 512, i);
        for (int d = 0; d < LF_SAMPLER_DIMENSIONS + 8; d++) {
            float x = lf_sampler_1d(&s);
            hash = mix(hash, &x, sizeof x);
        }
    }
    say("sampler", hash);
}

static void densities(void)
{
    uint64_t seed = 3, hash = start;
    for (int trial = 0; trial < 4000; trial++) {
        float scale[LANES], tau[LANES], d[LANES], spread = ldexpf(1.0f, trial % 16 - 6);
        for (int k = 0; k < LANES; k++) {
            scale[k] = k % 7 == trial % 7 ? 0.0f : 9.0f * lf_test_uniform(&seed);
            tau[k] = spread * lf_test_uniform(&seed);
        }
        float sum = lf_kernels_get()->densities(LANES, scale, tau, d);
        hash = mix(mix(hash, &sum, sizeof sum), d, sizeof d);
    }
    say("densities", hash);
}

static void depths(void)
{
    lf_slice slice;
    demand(make_slice(&slice, 23), "no memory");
    uint64_t seed = 29, hash[3] = {start, start, start};
    for (int trial = 0; trial < 2000; trial++) {
        lf_fan fan;
        float tau[LANES] = {0}, sigma[LANES] = {0}, z;
        bool pivot = trial % 2 == 0;
        lf_body body = make_body(&seed);
        make_fan(&fan, pivot, &seed);
        lf_kernels_get()->march(&slice, LANES, fan.x0, fan.slope, fan.z_end, tau,
                                pivot ? sigma : NULL);
        hash[0] = mix(mix(hash[0], tau, sizeof tau), sigma, sizeof sigma);
        lf_kernels_get()->through(&body, LANES, fan.x0, fan.slope, fan.z_end, tau);
        hash[1] = mix(hash[1], tau, sizeof tau);
        float reached = lf_slice_march(&slice, fan.x0[7], fan.slope[7], fan.z_end[7],
                                       10.0f * lf_test_uniform(&seed), &z);
        hash[2] = mix(mix(hash[2], &reached, sizeof reached), &z, sizeof z);
    }
    say("march", hash[0]);
    say("through", hash[1]);
    say("slice march", hash[2]);
    lf_slice_finish(&slice);
}

/* Every float there is, one in 4099, NaN and denormals among them. */
static void tones(void)
{
    const char *const maps[] = {"srgb", "filmic", "aces", "neutral"};
    for (int m = 0; m < 4; m++) {
        lf_tone *tone = NULL;
        demand(lf_tone_create(0.37, maps[m], &tone, NULL) == LF_OK, "no tone map");
        uint64_t hash = start;
        for (uint64_t bits = 0; bits < 1ull << 32;) {
            float in[PIXELS * 3];
            uint8_t out[PIXELS * 3];
            for (int i = 0; i < PIXELS * 3; i++, bits += 4099)
                memcpy(&in[i], &(uint32_t){(uint32_t)bits}, sizeof in[i]);
            lf_tone_map(tone, PIXELS, in, out);
            hash = mix(hash, out, sizeof out);
        }
        say(maps[m], hash);
        lf_tone_destroy(tone);
    }
}

/* Calibrations as panels have them, and one with cells. */
static const lf_calibration panels[] = {
    {.config_version = "3.0",
     .pitch = 52.594383239746094,
     .slope = -7.21152925491333,
     .center = 0.40277382731437683,
     .dpi = 324,
     .screen_width_px = 1536,
     .screen_height_px = 2048,
     .inv_view = 1},
    {.config_version = "1.0",
     .pitch = 47.56401443481445,
     .slope = -5.480000019073486,
     .center = 0.374184787273407,
     .dpi = 338,
     .screen_width_px = 2560,
     .screen_height_px = 1600,
     .inv_view = 1,
     .flip_subp = 1},
    {.config_version = "3.0",
     .pitch = 44.72,
     .slope = -7.45,
     .center = 0,
     .dpi = 283,
     .screen_width_px = 1080,
     .screen_height_px = 1920,
     .inv_view = 1,
     .cell_pattern_mode = 4,
     .n_cells = 2,
     .cells = {{{-0.25f, -0.31f}, {-0.25f, 0.28f}, {0.25f, 0}},
               {{0.25f, -0.31f}, {0.25f, 0.28f}, {-0.25f, 0}}}},
};

static void panel(const char *what, const lf_calibration *calibration, lf_filter filter,
                  const lf_views8 *views)
{
    lf_interlacer *it = NULL;
    lf_image8 out = {0};
    demand(lf_interlacer_create(calibration, VIEWS, WIDTH, HEIGHT, 0.75, filter, LF_INVERT_AUTO,
                                &it, NULL) == LF_OK,
           "no interlacer");
    demand(lf_image8_init(&out, calibration->screen_width_px, calibration->screen_height_px, 3) ==
               LF_OK,
           "no picture");
    /* of the slower filter, every 16th row */
    uint64_t hash = start;
    for (int row = 0; row < out.height; row += filter == LF_FILTER_LINEAR ? 16 : 1) {
        lf_interlace_rows(it, views, &out, row, row + 1);
        hash = mix(hash, out.data + (size_t)row * out.stride, (size_t)out.width * 3);
    }
    say(what, hash);
    lf_image8_finish(&out);
    lf_interlacer_destroy(it);
}

static void interlacers(void)
{
    size_t n = (size_t)VIEWS * WIDTH * HEIGHT * 3;
    uint8_t *data = lf_calloc(n, 1);
    demand(data, "no memory");
    for (size_t i = 0; i < n; i++)
        data[i] = (uint8_t)lf_hash64(5, i);
    lf_views8 views = {.n_views = VIEWS,
                       .width = WIDTH,
                       .height = HEIGHT,
                       .view_stride = (size_t)WIDTH * HEIGHT * 3,
                       .row_stride = (size_t)WIDTH * 3,
                       .data = data};
    for (size_t p = 0; p < sizeof panels / sizeof panels[0]; p++) {
        char what[32];
        snprintf(what, sizeof what, "panel %zu nearest", p);
        panel(what, &panels[p], LF_FILTER_NEAREST, &views);
        snprintf(what, sizeof what, "panel %zu linear", p);
        panel(what, &panels[p], LF_FILTER_LINEAR, &views);
    }
    lf_free(data);
}

/* A field of random bricks, some of them empty, and of random light. */
enum { BRICKS = 4, FRAMED = BRICKS + 2, NODES = 9, JOBS = 777 };
static uint16_t values[(BRICKS * BRICKS * BRICKS + 1) * LF_BRICK_STRIDE + 2];
static uint16_t left[NODES * NODES * NODES + 1];
static float majorant[FRAMED * FRAMED * FRAMED];
static int32_t first[FRAMED * FRAMED * FRAMED];

/* Of shares, or of a grid's own 16 bits: of the four highest powers of two. */
static lf_lane_scene make_lanes(lf_lane_field *field, bool own)
{
    uint64_t seed = 21;
    int brick = 0;
    *field = (lf_lane_field){.values = own ? NULL : values,
                             .shorts = values,
                             .scale = 0x1p62f,
                             .majorant = majorant,
                             .first = first,
                             .framed = {FRAMED, FRAMED, FRAMED},
                             .left = left,
                             .nodes = {NODES, NODES, NODES}};
    lf_lane_scene lanes = {.field = field,
                           .g = 0.4f,
                           .albedo = {0.95f, 0.8f, 0.6f},
                           .sky = {0.4f, 0.5f, 0.7f},
                           .toward = {0.48f, 0.6f, 0.64f},
                           .irradiance = {3.0f, 2.0f, 1.0f}};
    for (int i = 0; i < 3; i++) {
        lanes.size[i] = BRICKS * LF_BRICK - 1;
        lanes.to_volume[i][i] = 7.0f;
        field->to_nodes[i][i] = (NODES - 1.0f) / (BRICKS * LF_BRICK);
    }
    for (int z = 1; z <= BRICKS; z++)
        for (int y = 1; y <= BRICKS; y++)
            for (int x = 1; x <= BRICKS; x++) {
                const int at = (z * FRAMED + y) * FRAMED + x;
                majorant[at] = lf_max(9.0f * lf_test_uniform(&seed) - 1.0f, 0.0f);
                first[at] = majorant[at] > 0.0f ? ++brick * LF_BRICK_STRIDE : 0;
            }
    for (size_t i = LF_BRICK_STRIDE; i < sizeof values / sizeof *values; i++)
        values[i] = (uint16_t)(own ? 0xf000 + (int)(4095.0f * lf_test_uniform(&seed))
                                   : (int)(65535.0f * lf_test_uniform(&seed)));
    for (size_t i = 0; i < sizeof left / sizeof *left; i++)
        left[i] = (uint16_t)(65535.0f * lf_test_uniform(&seed));
    return lanes;
}

static void suffixes(bool own)
{
    static float q[3][JOBS], w[3][JOBS], out[4][JOBS], lit[3][JOBS];
    static uint32_t random[2][JOBS];
    static lf_lane_memory memory;
    lf_lane_field field;
    const lf_lane_scene lanes = make_lanes(&field, own);
    uint64_t seed = 22;
    for (int i = 0; i < JOBS; i++) {
        float length = 0.0f;
        for (int a = 0; a < 3; a++) {
            q[a][i] = (float)(BRICKS * LF_BRICK) * lf_test_uniform(&seed) - 1.0f;
            w[a][i] = lf_test_uniform(&seed) - 0.5f;
            length += w[a][i] * w[a][i];
        }
        for (int a = 0; a < 3; a++)
            w[a][i] /= sqrtf(length);
        random[0][i] = (uint32_t)lf_hash64(23, (uint64_t)i);
        random[1][i] = (uint32_t)lf_hash64(24, (uint64_t)i);
    }
    const lf_lane_paths paths = {.n = JOBS,
                                 .max_depth = 100,
                                 .q = {q[0], q[1], q[2]},
                                 .w = {w[0], w[1], w[2]},
                                 .random = {random[0], random[1]},
                                 .radiance = {out[0], out[1], out[2]},
                                 .lit = {lit[0], lit[1], lit[2]}};
    const lf_lane_points points = {
        .n = JOBS, .q = {q[0], q[1], q[2]}, .random = {random[0], random[1]}, .left = out[3]};
    const lf_suffixes *s = lf_kernels_get()->suffixes;
    int64_t lookups = s->trace(&lanes, &paths, &memory) + s->light(&lanes, &points, &memory);
    demand(lookups > (own ? 10 : 20) * JOBS, "suffixes look nothing up");
    say(own ? "suffixes of a grid in 16 bits" : "suffixes",
        mix(mix(start, &lookups, sizeof lookups), out, sizeof out));
}

/* Rays through such a field as a grid has it, in 32 bits and in 16. */
static void depths_of_rays(void)
{
    enum { N = BRICKS * BRICKS * BRICKS, SIDE = BRICKS * LF_BRICK - 1 };
    static float floats[(N + 1) * LF_BRICK_STRIDE];
    static uint16_t shorts[(N + 1) * LF_BRICK_STRIDE];
    static uint32_t index[N];
    static lf_depth_jobs jobs = {.n = LF_DEPTH_MOST};
    lf_grid grid = {.size = {SIDE, SIDE, SIDE},
                    .bricks = {BRICKS, BRICKS, BRICKS},
                    .index = index,
                    .shorts = shorts,
                    .short_scale = 0x1p64f};
    uint64_t seed = 31, hash = start;
    int64_t lookups = 0;
    for (uint32_t i = 0; i < N; i++)
        index[i] = lf_test_uniform(&seed) < 0.7f ? i + 1 : 0;
    for (size_t i = LF_BRICK_STRIDE; i < sizeof floats / sizeof *floats; i++) {
        floats[i] = lf_test_uniform(&seed);
        shorts[i] = (uint16_t)(65535.0f * lf_test_uniform(&seed));
    }
    for (int i = 0; i < LF_DEPTH_MOST; i++) {
        jobs.end[i] = 60.0f * lf_test_uniform(&seed);
        for (int a = 0; a < 3; a++) {
            jobs.p[a][i] = (float)LF_BRICK * lf_test_uniform(&seed);
            jobs.brick[a][i] = (int32_t)((float)BRICKS * lf_test_uniform(&seed));
            jobs.d[a][i] = i % 5 == a ? 0.0f : lf_test_uniform(&seed) - 0.5f;
        }
    }
    for (int way = 0; way < 4; way++) {
        grid.values = way < 2 ? NULL : floats;
        lookups += lf_depth_kernel_get()->trace(&grid, way % 2, 20.0f, &jobs);
        hash = mix(hash, jobs.sum, sizeof jobs.sum);
    }
    demand(lookups > 20 * LF_DEPTH_MOST, "rays meet nothing");
    say("depths of rays", mix(hash, &lookups, sizeof lookups));
}

static void fills_and_rectangles(void)
{
    size_t n = (size_t)VIEWS * WIDTH * HEIGHT;
    uint8_t *rgb = lf_calloc(3 * n, 1), *missing = lf_calloc(n, 1), *filled = lf_calloc(3 * n, 1);
    demand(rgb && missing && filled, "no memory");
    for (size_t i = 0; i < n; i++) {
        missing[i] = lf_hash64(8, i) % 3 != 0;
        for (size_t c = 0; c < 3; c++)
            rgb[3 * i + c] = (uint8_t)lf_hash64(9, 3 * i + c);
    }
    lf_fill_counts counts = lf_fill(VIEWS, WIDTH, HEIGHT, rgb, missing, 1, 4, filled, NULL);
    say("fill", mix(mix(start, &counts, sizeof counts), filled, 3 * n));
    lf_image8 a = {.width = WIDTH,
                   .height = HEIGHT * VIEWS,
                   .channels = 3,
                   .stride = (size_t)WIDTH * 3,
                   .data = rgb};
    lf_image8 b = a;
    b.data = filled;
    lf_rect rects[32];
    int n_rects = lf_changed_rects(&a, &b, rects, 32);
    say("rectangles", mix(start, rects, (size_t)n_rects * sizeof rects[0]));
    lf_free(rgb);
    lf_free(missing);
    lf_free(filled);
}

/* With an argument, what the kernels do alone. */
int main(int argc, char **argv)
{
    (void)argv;
    fprintf(stderr, "kernels: %s\n", lf_kernels_get()->name);
    densities();
    depths();
    suffixes(false);
    suffixes(true);
    depths_of_rays();
    if (argc > 1)
        return 0;
    samplers();
    tones();
    interlacers();
    fills_and_rectangles();
    return 0;
}
