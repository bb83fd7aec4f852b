/* Two ways to the same picture: a scene, and the same scene made of other things or put elsewhere. Replicates are seeds, the same for both,
 * and what is compared is the mean of the whole picture by the unbiased answer. Each pair shows its power: 0.3 % more in one of the two
 * is rejected. */
#include "tests/testing.h"

#include <stdarg.h>

#include "tests/stat/fixture.h"

enum { width = 16, height = 12, views = 3, few = 4, many = 24 };

/* What of the scene is said how. */
typedef struct way {
    double scale, moved;   /* lengths; along x, in lengths of the scene */
    bool mirrored, turned; /* left to right; by 180 degrees about y */
    int cuts;              /* the ground in cuts x cuts quads */
    int lamps;             /* the lamp likewise */
    int fogs;              /* as many volumes in one place, their density shared out */
    bool picture;          /* the sky as a picture */
} way;

static const way plain = {.scale = 1, .cuts = 1, .lamps = 1, .fogs = 1};

typedef struct text {
    char data[1 << 16];
    size_t n;
    const way *way;
} text;

static void __attribute__((format(printf, 2, 3))) put(text *t, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    int n = vsnprintf(t->data + t->n, sizeof t->data - t->n, format, list);
    va_end(list);
    assert_true(n >= 0 && (size_t)n < sizeof t->data - t->n);
    t->n += (size_t)n;
}

/* Where a point of the scene is. */
static void put_point(text *t, double x, double y, double z)
{
    const way *w = t->way;
    double across = w->mirrored != w->turned ? -x : x, along = w->turned ? -z : z;
    put(t, "[%.17g, %.17g, %.17g]", w->scale * (across + w->moved), w->scale * y, w->scale * along);
}

/* A level square of this half side, in n x n parts. */
static void put_square(text *t, const char *name, const char *material, int n, double half, double x, double y, double z)
{
    for (int i = 0; i < n * n; i++) {
        put(t, "'%s %d': { 'shape': 'quad', 'material': '%s', 'transform': { 'scale': %.17g, 'translate': ", name, i, material,
            t->way->scale * half / n);
        put_point(t, x + half * ((2 * (i % n) + 1.0) / n - 1), y, z + half * ((2 * (i / n) + 1.0) / n - 1));
        put(t, " } }, ");
    }
}

/* A constant sky as a Radiance picture without run lengths: 128/256 * 2^0 = 0.5. */
static void write_sky(const char *path)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fputs("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n", file);
    for (int i = 0; i < 8 * 16; i++)
        fputs("\x80\x80\x80\x80", file);
    assert_int_equal(fclose(file), 0);
}

static lf_scene *make(const way *w)
{
    static text t;
    char *folder = lf_test_folder();
    t = (text){.way = w};
    put(&t, "{ 'quiltd': 1, 'camera': { 'fov_y': 24, 'aspect': 1.3333333333, 'cone': 20, 'views': 3, 'position': ");
    put_point(&t, 0, 0.8, 5);
    put(&t, ", 'target': ");
    put_point(&t, 0, 0, 0);
    put(&t, " }, 'volumes': { ");
    for (int i = 0; i < w->fogs; i++) {
        put(&t,
            "%s'fog %d': { 'shape': 'sphere', 'density': %.17g, 'albedo': 0.9, 'g': 0.3, 'transform': { 'scale': %.17g, "
            "'translate': ",
            i ? ", " : "", i, 2 / w->scale / w->fogs, 0.5 * w->scale);
        put_point(&t, -0.4, 0.1, 0.3);
        put(&t, " } }");
    }
    put(&t, " }, 'meshes': { ");
    put_square(&t, "ground", "clay", w->cuts, 3, 0, -0.7, 0);
    put_square(&t, "lamp", "lamp", w->lamps, 1, 0.3, 2.5, 0.2);
    put(&t, "'ball': { 'shape': 'sphere', 'material': 'clay', 'transform': { 'scale': %.17g, 'translate': ", 0.5 * w->scale);
    put_point(&t, 0.5, -0.1, -0.2);
    put(&t, " } } }, 'materials': { 'clay': { 'albedo': 0.6 }, 'lamp': { 'albedo': 0, 'emission': 2 } }, ");
    put(&t, "'lights': { 'sky': { 'type': 'environment', ");
    if (w->picture) {
        const char *path = lf_test_path(folder, "sky.hdr");
        write_sky(path);
        put(&t, "'file': '%s' } } }", path);
    } else {
        put(&t, "'radiance': 0.5 } } }");
    }
    lf_scene *scene = lf_test_scene(t.data);
    lf_test_folder_remove(folder);
    return scene;
}

static double mean_of(lf_renderer *r, uint64_t seed)
{
    double sum = 0;
    lf_test_reseed(r, seed);
    lf_test_cycles(r, 16);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_CV);
    for (int i = 0; i < views * width * height; i++)
        sum += picture[i];
    free(picture);
    return sum / (views * width * height);
}

static const struct pair {
    const char *name;
    way other;
    int replicates; /* few where the same numbers lead to the same paths */
} pairs[] = {
    {"a ten thousandth of the size", {.scale = 1e-4, .cuts = 1, .lamps = 1, .fogs = 1}, few},
    {"a million times the size", {.scale = 1e6, .cuts = 1, .lamps = 1, .fogs = 1}, few},
    {"a million away", {.scale = 1, .moved = 1e6, .cuts = 1, .lamps = 1, .fogs = 1}, few},
    {"turned", {.scale = 1, .turned = true, .cuts = 1, .lamps = 1, .fogs = 1}, many},
    {"mirrored", {.scale = 1, .mirrored = true, .cuts = 1, .lamps = 1, .fogs = 1}, many},
    {"the ground in four", {.scale = 1, .cuts = 2, .lamps = 1, .fogs = 1}, few},
    {"the lamp in 100", {.scale = 1, .cuts = 1, .lamps = 10, .fogs = 1}, many},
    {"the fog as two of half the density", {.scale = 1, .cuts = 1, .lamps = 1, .fogs = 2}, many},
    {"the sky as a picture", {.scale = 1, .cuts = 1, .lamps = 1, .fogs = 1, .picture = true}, many},
};

enum { n_pairs = sizeof pairs / sizeof pairs[0] };

static void pairs_are_the_same_picture(void **state)
{
    (void)state;
    double first[many], mean = 0;
    lf_scene *scene = make(&plain);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    for (int k = 0; k < many; k++) {
        first[k] = mean_of(r, lf_hash64(lf_test_seed(), (uint64_t)k));
        mean += first[k] / many;
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    for (int i = 0; i < n_pairs; i++) {
        lf_moments difference = {0};
        scene = make(&pairs[i].other);
        r = lf_test_renderer(scene, "mvpt", width, height, NULL);
        for (int k = 0; k < pairs[i].replicates; k++)
            lf_moments_add(&difference, mean_of(r, lf_hash64(lf_test_seed(), (uint64_t)k)) / mean - first[k] / mean);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
        double error = lf_moments_error(&difference);
        print_message("%-36s %+.2g +- %.2g\n", pairs[i].name, difference.mean, error);
        /* What single precision may round off. */
        double beyond = fmax(fabs(difference.mean) - 2e-5, 0);
        assert_true(lf_p_student(beyond / fmax(error, 1e-9), pairs[i].replicates - 1) > lf_sidak(LF_FALSE_ALARM, n_pairs));
        assert_true(lf_p_student((0.003 - fabs(difference.mean)) / fmax(error, 1e-9), pairs[i].replicates - 1) < 1e-4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pairs_are_the_same_picture),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
