/* Two ways to the same picture: a scene, and the same scene made of other things or put elsewhere.
 * Replicates are seeds, the same for both, and what is compared is the mean of the whole picture by
 * the unbiased answer. Each pair shows its power: its standard error is so small that 0.3 % more in
 * one of the two is rejected. */
#include "tests/testing.h"

#include <stdarg.h>

#include "tests/render/grids.h"

enum { width = 16, height = 12, views = 3, few = 4, many = 24, most = 48 };

/* Of the box of fog, about y. */
static const double tilt = 0.4;

/* What of the scene is said how. */
typedef struct way {
    double scale, moved;   /* lengths; along x, in lengths of the scene */
    bool mirrored, turned; /* left to right; by 180 degrees about y */
    int cuts;              /* the ground in cuts x cuts quads */
    int lamps;             /* the lamp likewise */
    /* > 0: either as one mesh of cells x cells x 4 triangles, the corners of the cells and their
     * middles */
    int cells, lamp_cells;
    int fogs;           /* as many volumes in one place, their density shared out */
    bool picture, dome; /* the sky as a picture; as a box of lamps around everything */
    bool box, voxels;   /* the fog as a box in the middle; the same as a grid */
} way;

static const way plain = {.scale = 1, .cuts = 1, .lamps = 1, .fogs = 1},
                 box = {.scale = 1, .cuts = 1, .lamps = 1, .fogs = 1, .box = true};

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
static void put_square(text *t, const char *name, const char *material, int n, double half,
                       double x, double y, double z)
{
    for (int i = 0; i < n * n; i++) {
        put(t,
            "'%s %d': { 'shape': 'quad', 'material': '%s', 'transform': { 'scale': %.17g, "
            "'translate': ",
            name, i, material, t->way->scale * half / n);
        put_point(t, x + half * ((2 * (i % n) + 1.0) / n - 1), y,
                  z + half * ((2 * (i / n) + 1.0) / n - 1));
        put(t, " } }, ");
    }
}

/* The same, as a file. */
static void put_mesh(text *t, const char *name, const char *path, const char *material, int n,
                     double half, double x, double y, double z)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int i = 0; i <= n; i++) {
        for (int j = 0; j <= n; j++)
            fprintf(file, "v %.9g 0 %.9g\nv %.9g 0 %.9g\n", 2.0 * i / n - 1, 2.0 * j / n - 1,
                    (2 * i + 1.0) / n - 1, (2 * j + 1.0) / n - 1);
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            int near = 2 * (i * (n + 1) + j) + 1, far = near + 2 * (n + 1),
                ring[] = {near, near + 2, far + 2, far, near};
            for (int k = 0; k < 4; k++)
                fprintf(file, "f %d %d %d\n", ring[k], ring[k + 1], near + 1);
        }
    }
    assert_int_equal(fclose(file), 0);
    put(t, "'%s': { 'file': '%s', 'material': '%s', 'transform': { 'scale': %.17g, 'translate': ",
        name, path, material, t->way->scale * half);
    put_point(t, x, y, z);
    put(t, " } }, ");
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

static void put_fogs(text *t)
{
    const way *w = t->way;
    put(t, "'volumes': { ");
    for (int i = 0; i < w->fogs; i++) {
        put(t,
            "%s'fog %d': { 'shape': '%s', 'density': %.17g, 'albedo': 0.9, 'g': 0.3, 'transform': "
            "{ 'scale': %.17g, "
            "'rotate': [0, %.17g, 0], 'translate': ",
            i ? ", " : "", i, w->box ? "box" : "sphere", 2 / w->scale / w->fogs, 0.5 * w->scale,
            tilt * 180 / M_PI);
        if (w->box)
            put_point(t, 0, 0, 0);
        else
            put_point(t, -0.4, 0.1, 0.3);
        put(t, " } }");
    }
    put(t, " }, ");
}

static void put_meshes(text *t, const char *folder)
{
    const way *w = t->way;
    put(t, "'meshes': { ");
    if (w->cells)
        put_mesh(t, "ground", lf_test_path(folder, "ground.obj"), "clay", w->cells, 3, 0, -0.7, 0);
    else
        put_square(t, "ground", "clay", w->cuts, 3, 0, -0.7, 0);
    if (w->lamp_cells)
        put_mesh(t, "lamp", lf_test_path(folder, "lamp.obj"), "lamp", w->lamp_cells, 1, 0.3, 2.5,
                 0.2);
    else
        put_square(t, "lamp", "lamp", w->lamps, 1, 0.3, 2.5, 0.2);
    if (w->dome)
        put(t, "'dome': { 'shape': 'cube', 'material': 'sky', 'transform': { 'scale': 12 } }, ");
    put(t,
        "'ball': { 'shape': 'sphere', 'material': 'clay', 'transform': { 'scale': %.17g, "
        "'translate': ",
        0.5 * w->scale);
    put_point(t, 0.5, -0.1, -0.2);
    put(t, " } } }, 'materials': { 'clay': { 'albedo': 0.6 }, 'lamp': { 'albedo': 0, 'emission': 2 "
           "}, 'sky': { 'albedo': 0, "
           "'emission': 0.5 } }");
}

static void put_sky(text *t, const char *folder)
{
    if (t->way->dome)
        return;
    put(t, ", 'lights': { 'sky': { 'type': 'environment', ");
    if (t->way->picture) {
        const char *path = lf_test_path(folder, "sky.hdr");
        write_sky(path);
        put(t, "'file': '%s' } }", path);
    } else {
        put(t, "'radiance': 0.5 } }");
    }
}

static lf_scene *make(const way *w)
{
    enum { side = 20 };
    static text t;
    char *folder = lf_test_folder();
    t = (text){.way = w};
    put(&t, "{ 'quiltd': 1, 'camera': { 'fov_y': 24, 'aspect': 1.3333333333, 'cone': 20, 'views': "
            "3, 'position': ");
    put_point(&t, 0, 0.8, 5);
    put(&t, ", 'target': ");
    put_point(&t, 0, 0, 0);
    put(&t, " }, ");
    put_fogs(&t);
    put_meshes(&t, folder);
    put_sky(&t, folder);
    put(&t, " }");
    lf_scene *scene = w->voxels
                          ? lf_test_grid_scene(t.data, lf_test_grid(lf_test_full, side, side, side),
                                               1.0 / side, tilt, 2.0f, true)
                          : lf_test_scene(t.data);
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

/* The means of seeds 0 to n - 1. */
static void means(const way *w, const char *integrator, int n, double *out)
{
    lf_scene *scene = make(w);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    for (int k = 0; k < n; k++)
        out[k] = mean_of(r, lf_hash64(lf_test_seed(), (uint64_t)k));
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
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
    {"the ground as four triangles", {.scale = 1, .cells = 1, .lamps = 1, .fogs = 1}, few},
    {"the ground as 4096 triangles", {.scale = 1, .cells = 32, .lamps = 1, .fogs = 1}, few},
    {"the lamp in 100", {.scale = 1, .cuts = 1, .lamps = 10, .fogs = 1}, many},
    {"the lamp as 10000 triangles", {.scale = 1, .cuts = 1, .lamp_cells = 50, .fogs = 1}, many},
    {"the fog as two of half the density", {.scale = 1, .cuts = 1, .lamps = 1, .fogs = 2}, many},
    {"the sky as a picture", {.scale = 1, .cuts = 1, .lamps = 1, .fogs = 1, .picture = true}, most},
    {"the sky as a dome of lamps",
     {.scale = 1, .cuts = 1, .lamps = 1, .fogs = 1, .dome = true},
     most},
};
static const struct pair lamp_by_vpt = {
    "the lamp as 10000 triangles, vpt", {.scale = 1, .cuts = 1, .lamp_cells = 50, .fogs = 1}, many};
static const struct pair box_of_voxels = {
    "a box of fog as voxels",
    {.scale = 1, .cuts = 1, .lamps = 1, .fogs = 1, .box = true, .voxels = true},
    many};

enum { n_pairs = sizeof pairs / sizeof pairs[0] + 2 };

/* 0.3 % in one of the two ways would have this p on average, far below what is rejected: it is, in
 * at least nine of ten runs. */
#define POWER 1e-5

/* Against the means of the first way, of at least as many seeds. */
static void assert_same(const struct pair *pair, const char *integrator, const double first[most])
{
    double other[most], mean = 0;
    lf_moments difference = {0};
    means(&pair->other, integrator, pair->replicates, other);
    for (int k = 0; k < pair->replicates; k++)
        mean += first[k] / pair->replicates;
    for (int k = 0; k < pair->replicates; k++)
        lf_moments_add(&difference, (other[k] - first[k]) / mean);
    double error = lf_moments_error(&difference);
    print_message("%-36s %+.2g +- %.2g\n", pair->name, difference.mean, error);
    /* What single precision may round off. */
    double beyond = fmax(fabs(difference.mean) - 2e-5, 0);
    assert_true(lf_p_student(beyond / fmax(error, 1e-9), pair->replicates - 1) >
                lf_sidak(LF_FALSE_ALARM, n_pairs));
    assert_true(lf_p_student(0.003 / fmax(error, 1e-9), pair->replicates - 1) < POWER);
}

static void pairs_are_the_same_picture(void **state)
{
    (void)state;
    double first[most];
    means(&plain, "mvpt", most, first);
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++)
        assert_same(&pairs[i], "mvpt", first);
}

static void a_lamp_of_many_triangles_is_the_same_lamp_by_vpt(void **state)
{
    (void)state;
    double first[most];
    means(&plain, "vpt", many, first);
    assert_same(&lamp_by_vpt, "vpt", first);
}

static void a_box_is_the_same_fog_as_voxels(void **state)
{
    (void)state;
    double first[most];
    means(&box, "mvpt", many, first);
    assert_same(&box_of_voxels, "mvpt", first);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pairs_are_the_same_picture),
        cmocka_unit_test(a_lamp_of_many_triangles_is_the_same_lamp_by_vpt),
        cmocka_unit_test(a_box_is_the_same_fog_as_voxels),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
