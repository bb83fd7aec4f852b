/* Suffixes in lanes from places in a small grid, and the same by path.c. */
#ifndef LF_TESTS_RENDER_SUFFIXES_H
#define LF_TESTS_RENDER_SUFFIXES_H

#include "tests/testing.h"

#include "base/alloc.h"
#include "render/plane/kernel.h"
#include "render/renderer.h"
#include "render/rows/queue.h"
#include "render/rows/rows.h"
#include "render/transport/lanes/lane_surfaces.h"
#include "render/transport/lanes/lanes.h"
#include "render/transport/lanes/suffix.h"
#include "render/transport/path/path.h"
#include "tests/render/grids.h"
#include "tests/stat/kept.h"
#include "tests/stat/uniform.h"

enum { n_jobs = 4096 };

#define SKY "'sky': { 'type': 'environment', 'radiance': [0.4, 0.5, 0.7] }"
#define SUN                                                                                        \
    "'sun': { 'type': 'distant', 'direction': [0.5, -0.7, -0.5], 'irradiance': [2, 1.7, 1.5] }"
#define SCENE(volume, lights)                                                                      \
    "{ 'quiltd': 1, 'volumes': { 'v': { 'shape': 'box', 'density': 1, " volume " } }, "            \
    "'lights': { " lights " } }"

#define AMONG(volume, lights, meshes)                                                              \
    "{ 'quiltd': 1, 'volumes': { 'v': { 'shape': 'box', 'density': 1, " volume " } }, "            \
    "'meshes': { " meshes " }, 'lights': { " lights " } }"
/* In the grid, and sticking out of it. */
#define BALL                                                                                       \
    "'ball': { 'shape': 'sphere', 'transform': { 'scale': 0.6, 'translate': [0.5, 0.1, 0.2] } }"

/* Jobs of all kinds in the arrays that lanes want. */
typedef struct jobs {
    float q[3][n_jobs], w[3][n_jobs], radiance[3][n_jobs], lit[3][n_jobs], left[n_jobs],
        escaped[n_jobs];
    uint32_t random[2][n_jobs];
    lf_vec3 p[n_jobs]; /* of q, scene-local */
} jobs;

typedef struct rig {
    lf_scene *scene;
    lf_pool *pool;
    lf_lane_scene lanes;
    lf_lane_memory *memory;
    lf_tracer tracer; /* of rays to surfaces */
} rig;

/* Soft, with holes: 0 in a third of the bricks. */
static inline float soft(int x, int y, int z)
{
    return x / 8 % 3 == 1 ? 0.0f
                          : 0.5f + 0.5f * sinf(0.7f * (float)x) * sinf(0.9f * (float)(y + z));
}

static inline lf_scene *make_scene(const char *text, float sigma)
{
    return lf_test_grid_scene(text, lf_test_grid(soft, 30, 17, 12), 0.1, 0.4, sigma, false);
}

/* The same grid, rounded to what it keeps in 16 bits. */
static inline lf_scene *make_short_scene(const char *text, float sigma)
{
    lf_grid *grid = lf_test_grid(soft, 30, 17, 12);
    lf_grid_shorten(grid, true);
    assert_true(grid->shorts && !grid->values);
    return lf_test_grid_scene(text, grid, 0.1, 0.4, sigma, false);
}

/* Takes the scene. */
static inline rig rig_of(lf_scene *scene)
{
    rig r = {.scene = scene, .memory = calloc(1, sizeof *r.memory), .tracer = {.scene = scene}};
    assert_non_null(r.memory);
    assert_int_equal(lf_pool_create(2, &r.pool), LF_OK);
    assert_true(lf_lane_scene_serves(r.scene));
    assert_int_equal(lf_lane_scene_init(&r.lanes, r.scene, NULL, r.pool), LF_OK);
    assert_non_null(r.lanes.field);
    return r;
}

static inline rig make_rig(const char *text, float sigma)
{
    return rig_of(make_scene(text, sigma));
}

static inline void drop_rig(rig *r)
{
    lf_lane_scene_finish(&r->lanes);
    lf_pool_destroy(r->pool);
    lf_scene_unref(r->scene);
    free(r->memory);
}

static inline void put_key(jobs *j, int i, uint64_t key)
{
    j->random[0][i] = (uint32_t)key;
    j->random[1][i] = (uint32_t)(key >> 32);
}

/* Places all over the grid and a little beyond its edge, directions all around. */
static inline void draw_jobs(const rig *r, uint64_t seed, int n, jobs *out)
{
    const lf_volume *v = &r->scene->volumes[0];
    uint64_t state = lf_hash64(lf_test_seed(), seed);
    for (int i = 0; i < n; i++) {
        for (int a = 0; a < 3; a++)
            out->q[a][i] =
                (lf_test_uniform(&state) * 1.02f - 0.01f) * (float)(v->grid->size[a] + 1) - 1.0f;
        float p[3];
        for (int a = 0; a < 3; a++)
            p[a] = v->to_scene[a][0] * (out->q[0][i] - v->to_volume[0][3]) +
                   v->to_scene[a][1] * (out->q[1][i] - v->to_volume[1][3]) +
                   v->to_scene[a][2] * (out->q[2][i] - v->to_volume[2][3]);
        out->p[i] = lf_v3(p[0], p[1], p[2]);
        const float u[2] = {lf_test_uniform(&state), lf_test_uniform(&state)};
        lf_vec3 w = lf_phase_sample(0.0f, lf_v3(0.0f, 0.0f, 1.0f), u);
        out->w[0][i] = i % 50 == 0 ? 0.0f : w.x; /* some along two axes alone */
        out->w[1][i] = w.y;
        out->w[2][i] = w.z;
        float length = sqrtf(out->w[0][i] * out->w[0][i] + w.y * w.y + w.z * w.z);
        for (int a = 0; a < 3; a++)
            out->w[a][i] /= length;
        put_key(out, i, state);
    }
}

static inline int64_t trace(const lf_suffixes *s, rig *r, jobs *j, int first, int n, int max_depth)
{
    const lf_lane_paths paths = {
        .n = n,
        .max_depth = max_depth,
        .q = {j->q[0] + first, j->q[1] + first, j->q[2] + first},
        .w = {j->w[0] + first, j->w[1] + first, j->w[2] + first},
        .random = {j->random[0] + first, j->random[1] + first},
        .radiance = {j->radiance[0] + first, j->radiance[1] + first, j->radiance[2] + first},
        .lit = {j->lit[0], j->lit[1], j->lit[2]},
        .escaped = j->escaped + first};
    r->memory->surfaces = lf_lane_surfaces_of(&r->tracer);
    return s->trace(&r->lanes, &paths, r->memory);
}

static inline int64_t light(const lf_suffixes *s, rig *r, jobs *j, int first, int n)
{
    const lf_lane_points points = {.n = n,
                                   .q = {j->q[0] + first, j->q[1] + first, j->q[2] + first},
                                   .w = {j->w[0] + first, j->w[1] + first, j->w[2] + first},
                                   .random = {j->random[0] + first, j->random[1] + first},
                                   .left = j->left + first};
    r->memory->surfaces = lf_lane_surfaces_of(&r->tracer);
    return s->light(&r->lanes, &points, r->memory);
}

/* The best that this machine has: the others are the same to the bit. */
static inline const lf_suffixes *best(void)
{
    return lf_kernels_get()->suffixes;
}

/* Sum over channels of what arrives along each job's direction, one suffix each. */
static inline void single(const rig *r, jobs *j, int max_depth, double *out)
{
    lf_tracer tracer = {.scene = r->scene};
    for (int i = 0; i < n_jobs; i++) {
        lf_event event = {.kind = LF_EVENT_MEDIUM, .p = j->p[i], .w = lf_v3(0.0f, 0.0f, 1.0f)},
                 next;
        float pdf;
        tracer.rng = (uint64_t)j->random[0][i] | (uint64_t)j->random[1][i] << 32;
        lf_path_next(&tracer, &event, lf_v3(j->w[0][i], j->w[1][i], j->w[2][i]), &next);
        lf_vec3 found = lf_path_light_found(r->scene, &event, &next, &pdf);
        if (r->lanes.has & LF_LANE_SKY) /* as lanes leave it to their caller */
            found = lf_v3(0.0f, 0.0f, 0.0f);
        found = lf_add(found, lf_path_arriving(&tracer, &next, 2, max_depth));
        out[i] = (double)found.x + (double)found.y + (double)found.z;
    }
}

/* exp(-depth) from p along w, by the trapezoidal rule in steps of 1/50 of a voxel. */
static inline double left_beyond(const rig *r, lf_vec3 p, lf_vec3 w)
{
    const double step = 0.002;
    double depth = 0.0;
    for (int i = 0; i < 3000; i++) {
        lf_vec3 at = lf_madd(p, (float)((i + 0.5) * step), w);
        depth += step * (double)lf_volume_sigma_t(&r->scene->volumes[0], at);
    }
    return exp(-depth);
}

/* Fails the test unless batches of any size, by whatever instruction set is there, find the same to
 * the bit. has: what the scene must have, of lf_lane_scene's. Takes the scene. */
static inline void assert_same_bits(lf_scene *scene, unsigned has)
{
    static jobs first, other;
    rig r = rig_of(scene);
    assert_true(r.lanes.has == has);
    draw_jobs(&r, 1, n_jobs, &first);
    memcpy(&other, &first, sizeof first);
    int64_t lookups = trace(&lf_suffixes_c, &r, &first, 0, n_jobs, 40) +
                      light(&lf_suffixes_c, &r, &first, 0, n_jobs);
    assert_true(lookups > 10 * n_jobs);
    static const int sizes[] = {n_jobs, 1024, 64, 17, 1};
    for (int k = 0; lf_kernels_at(k); k++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
            const lf_suffixes *suffixes = lf_kernels_at(k)->suffixes;
            int64_t found = 0;
            for (int at = 0; at < n_jobs; at += sizes[s]) {
                int n = n_jobs - at < sizes[s] ? n_jobs - at : sizes[s];
                found += trace(suffixes, &r, &other, at, n, 40);
                found += light(suffixes, &r, &other, at, n);
            }
            assert_memory_equal(first.radiance, other.radiance, sizeof first.radiance);
            assert_memory_equal(first.escaped, other.escaped, sizeof first.escaped);
            assert_memory_equal(first.left, other.left, sizeof first.left);
            assert_true(found == lookups);
            memset(other.radiance, 0, sizeof other.radiance);
            memset(other.escaped, 0, sizeof other.escaped);
            memset(other.left, 0, sizeof other.left);
        }
    drop_rig(&r);
}

enum { PIECES = 4 };

/* Means over replicates of what arrives: of each quarter of the grid, then of all. */
typedef struct comparison {
    lf_moments lanes[PIECES + 1], single[PIECES + 1];
    lf_moments off[PIECES + 1]; /* lanes less path.c, who have their places in common */
} comparison;

static inline void piece_means(const rig *r, const jobs *j, const double *value,
                               double out[PIECES + 1])
{
    const float length = (float)(r->scene->volumes[0].grid->size[0] + 1);
    int count[PIECES] = {0};
    memset(out, 0, (PIECES + 1) * sizeof *out);
    for (int i = 0; i < n_jobs; i++) {
        int piece = (int)(PIECES * lf_min(lf_max((j->q[0][i] + 1.0f) / length, 0.0f), 0.99f));
        count[piece]++;
        out[piece] += value[i];
        out[PIECES] += value[i] / n_jobs;
    }
    for (int k = 0; k < PIECES; k++)
        out[k] /= count[k];
}

/* By path.c only every so many rounds. */
static inline void compare_under(rig *r, int max_depth, int rounds, int every, comparison *out)
{
    static jobs j;
    static double value[n_jobs];
    double lanes_found[PIECES + 1], found[PIECES + 1];
    memset(out, 0, sizeof *out);
    for (int round = 0; round < rounds; round++) {
        draw_jobs(r, 200 + (uint64_t)round, n_jobs, &j);
        trace(best(), r, &j, 0, n_jobs, max_depth);
        for (int i = 0; i < n_jobs; i++)
            value[i] =
                (double)j.radiance[0][i] + (double)j.radiance[1][i] + (double)j.radiance[2][i];
        piece_means(r, &j, value, lanes_found);
        const bool both = round % every == 0;
        if (both) {
            single(r, &j, max_depth, value);
            piece_means(r, &j, value, found);
        }
        for (int k = 0; k <= PIECES; k++) {
            lf_moments_add(&out->lanes[k], lanes_found[k]);
            if (both) {
                lf_moments_add(&out->single[k], found[k]);
                lf_moments_add(&out->off[k], lanes_found[k] - found[k]);
            }
        }
    }
}

/* How many p-values a case below looks at. */
enum { LOOKS = 3 * (PIECES + 1) };

/* Fails the test unless means of `rounds` replicates in lanes are those of path.c that are kept
 * (tests/stat/kept.h), by all that the level lets them be off, and a relative bias of twice `bias`
 * in the whole would be seen. A fourth of the rounds is drawn by path.c too, and must agree with
 * both; under QUILTD_LONG four times as many by each. */
static inline void assert_mean_of_single_paths(rig *r, const char *name, int max_depth, int rounds,
                                               double bias, double level)
{
    const bool whole = lf_test_long() || lf_test_keeping();
    comparison c;
    lf_moments kept[PIECES + 1];
    compare_under(r, max_depth, whole ? 4 * rounds : rounds, whole ? 1 : 4, &c);
    if (lf_test_keeping())
        lf_kept_write(name, PIECES + 1, c.single);
    lf_kept_read(name, PIECES + 1, kept);
    for (int k = 0; k <= PIECES; k++)
        if (!(lf_p_welch(&c.lanes[k], &kept[k]) > level &&
              lf_p_welch(&c.single[k], &kept[k]) > level && lf_p_mean(&c.off[k], 0.0) > level))
            fail_msg("%s, piece %d: %.5g +- %.2g, path.c %.5g +- %.2g, kept as %.5g +- %.2g", name,
                     k, c.lanes[k].mean, lf_moments_error(&c.lanes[k]), c.single[k].mean,
                     lf_moments_error(&c.single[k]), kept[k].mean, lf_moments_error(&kept[k]));
    lf_moments *mean = &c.lanes[PIECES], *all = &kept[PIECES];
    print_message("%s: %.5g +- %.2g, by path.c %.5g +- %.2g\n", name, mean->mean,
                  lf_moments_error(mean), all->mean, lf_moments_error(all));
    mean->mean += 2.0 * bias * all->mean;
    if (!(lf_p_welch(mean, all) < level))
        fail_msg("%s: %.2g of %.5g is too much noise", name, lf_moments_error(mean), all->mean);
}

#endif
