/* camera.shutter: what moves against closed forms and against still pictures of many moments; that
 * what views share is of one moment; and what it says of what stands still. QUILTD_LONG=1 takes
 * eight times the replicates. */
#include "tests/testing.h"

#include <stdarg.h>

#include "render/scene/geometry.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

/* ----------------------------------------------------------------------------------- an edge -- */

enum { side = 24, edge_views = 3 };

#define DISTANCE 5.0
#define FOV 20.0
#define CONE 30.0

static const double half_window = 0.8816349035423249; /* DISTANCE tan(FOV / 2) */

/* A black wall before a white sky, far beyond the window but for one edge, which moves across the
 * columns (or, level, across the rows) from one place to another at depth z while the shutter is
 * open, or past which the cameras move; fog: of a medium in place of a surface. Nothing scatters:
 * what is seen is known light. Mean over what lies along the edge: [view][across]. */
static void look_at_edge(double z, bool level, double from, double to, bool camera, bool fog,
                         unsigned faults, double *out)
{
    /* It opens in frame 5 and a half and closes in frame 6.75. */
    double speed = (to - from) / 1.25, at = from - 4.5 * speed;
    double first[2] = {0}, last[2] = {0}, eye[2][2] = {{0}, {0}};
    first[level] = at - 40;
    last[level] = at + 10 * speed - 40;
    if (camera) { /* the other way, and the wall stands still */
        eye[0][level] = from - at;
        eye[1][level] = from - at - 10 * speed;
        first[level] = last[level] = from - 40;
    }
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(
        fog ? "edge-of-fog" : "edge-of-wall",
        "{'camera': {'position': {'keys': [[1, [%.17g, %.17g, 5]], [11, [%.17g, %.17g, 5]]]}, "
        "'target': {'keys': [[1, [%.17g, %.17g, 0]], [11, [%.17g, %.17g, 0]]]}, 'fov_y': %g, "
        "'cone': %g}, '%s': {'wall': {'transform': {'translate': {'keys': "
        "[[1, [%.17g, %.17g, %.17g]], [11, [%.17g, %.17g, %.17g]]]}}}}}",
        eye[0][0], eye[0][1], eye[1][0], eye[1][1], eye[0][0], eye[0][1], eye[1][0], eye[1][1], FOV,
        CONE, fog ? "volumes" : "meshes", first[0], first[1], DISTANCE - z, last[0], last[1],
        DISTANCE - z));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", side, side, NULL);
    r->faults = faults;
    lf_test_cycles(r, 192);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS);
    for (int i = 0; i < edge_views * side; i++)
        out[i] = 0;
    for (int i = 0; i < side * edge_views * side; i++) {
        int row = i / (edge_views * side), view = i / side % edge_views, column = i % side;
        out[view * side + (level ? side - 1 - row : column)] += picture[i] / side;
    }
    free(picture);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* The share of a step from u to u + 1 that lies above an edge that goes evenly from a to b. */
static double above(double u, double a, double b)
{
    enum { TIMES = 2000 };
    double sum = 0;
    for (int i = 0; i < TIMES; i++) {
        double edge = a + (b - a) * (i + 0.5) / TIMES;
        sum += fmin(fmax(u + 1 - edge, 0), 1);
    }
    return sum / TIMES;
}

/* How far the picture is off the edge's ramp. */
static double worst_of_edge(double z, bool level, double from, double to, bool camera, bool fog,
                            unsigned faults)
{
    double out[edge_views * side], worst = 0, pixel = 2 * half_window / side;
    look_at_edge(z, level, from, to, camera, fog, faults, out);
    for (int i = 0; i < edge_views * side; i++) {
        int view = i / side;
        double b = level ? 0 : (view - 1) * DISTANCE * tan(CONE / 3 * M_PI / 180);
        /* where the window has the edge: X_w = b + (X - b) D/Z */
        double a = (b + (from - b) * DISTANCE / z + half_window) / pixel,
               e = (b + (to - b) * DISTANCE / z + half_window) / pixel;
        worst = fmax(worst, fabs(out[i] - above(i % side, a, e)));
    }
    return worst;
}

static void an_edge_is_a_ramp_as_wide_as_it_moves(void **state)
{
    (void)state;
    const struct {
        double z, from, to;
        bool level, camera, fog; /* of fog there are a third of the visits */
    } cases[] = {
        {DISTANCE, -0.31, 0.27, false, false, false}, {DISTANCE, 0.4, -0.2, true, false, false},
        {3.5, -0.1, 0.3, false, false, false},        {7, -0.4, 0.5, true, false, false},
        {3.5, 0.2, -0.3, false, true, false},         {7, -0.4, 0.5, true, true, false},
        {3.5, -0.1, 0.3, false, false, true},         {7, -0.4, 0.5, true, true, true}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double worst = worst_of_edge(cases[i].z, cases[i].level, cases[i].from, cases[i].to,
                                     cases[i].camera, cases[i].fog, 0);
        print_message("depth %g: %.4f off\n", cases[i].z, worst);
        assert_true(worst < (cases[i].fog ? 0.04 : 0.02));
    }
    /* A picture of the middle alone would be seen. */
    assert_true(worst_of_edge(DISTANCE, false, -0.31, 0.27, false, true, LF_FAULT_NO_TIME) > 0.2);
}

/* ---------------------------------------------------------------------------- still pictures -- */

enum { width = 32, height = 24, n_views = 3, block = 8, blocks = n_views * 12 + 1 };

/* Numbers that go from a to b, as they are at one moment, or as keys of frames 1 and 2. */
typedef struct writer {
    char data[4096 + PATH_MAX];
    size_t n;
    double time; /* < 0: keys */
} writer;

static void __attribute__((format(printf, 2, 3))) put(writer *w, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    w->n += (size_t)vsnprintf(w->data + w->n, sizeof w->data - w->n, format, list);
    va_end(list);
    assert_true(w->n < sizeof w->data);
}

static void put_list(writer *w, const double *a, const double *b, int n, double t)
{
    for (int i = 0; i < n; i++)
        put(w, "%s%.17g", i ? ", " : "[", a[i] + t * (b[i] - a[i]));
    put(w, "]");
}

static void put_moving(writer *w, const char *key, const double *a, const double *b, int n)
{
    put(w, "'%s': ", key);
    if (w->time >= 0) {
        put_list(w, a, b, n, w->time);
        return;
    }
    put(w, "{'keys': [[1, ");
    put_list(w, a, b, n, 0);
    put(w, "], [2, ");
    put_list(w, a, b, n, 1);
    put(w, "]]}");
}

/* A disk of glaze that grows as it flies, a box that shears and turns, a lamp of faces on its way
 * through fog that spreads and voxels that rise, a bulb in the fog that lights up, a lit pane
 * behind, a sun and a sky, past which the camera goes round and comes nearer: in keys, or as they
 * are at a moment. All goes along straight lines. */
static void write_scene(writer *w, double time)
{
    static const double disk[2][3] = {{-1.1, -0.3, 0.6}, {-0.5, 0.1, 0.2}},
                        size[2][3] = {{0.4, 0.4, 0.4}, {0.5, 0.5, 0.5}},
                        box[2][16] = {{0.3, 0, 0, 0.7, 0, 0.3, 0, -0.6, 0, 0, 0.3, 0.3, 0, 0, 0, 1},
                                      {0.1, -0.3, 0, 1, 0.3, 0.2, 0, -0.4, 0, 0, 0.4, 0.7, 0, 0, 0,
                                       1}},
                        lamp[2][3] = {{0.1, 1.2, 1}, {0.8, 0.7, 1.4}},
                        thin[2][3] = {{-1, 1.2, -1}, {-0.4, 1, -1}},
                        eye[2][3] = {{-0.3, 0.5, 5}, {0.5, 0.8, 4.6}},
                        target[2][3] = {{0, 0, 0}, {0.1, 0, 0.1}},
                        sky[2][3] = {{0.3, 0.4, 0.6}, {0.5, 0.5, 0.7}},
                        sun[2][3] = {{0.6, -0.8, 0}, {0, -0.8, -0.6}},
                        bulb[2][3] = {{0.2, 0.1, 0.6}, {0.7, 0.4, 0.7}},
                        power[2][3] = {{0, 0, 0}, {0.4, 0.3, 0.3}},
                        wide[2][3] = {{0.6, 0.6, 0.5}, {0.9, 0.7, 0.7}},
                        fog[2][3] = {{0.2, 0.1, 0.6}, {0.6, 0.3, 0.6}},
                        voxels[2][3] = {{-0.7, -0.4, 0.8}, {-0.4, 0.1, 0.6}};
    char vdb[PATH_MAX];
    assert_non_null(realpath(lf_test_built("testdata/patterns.vdb"), vdb));
    w->time = time;
    put(w, "{'camera': {");
    put_moving(w, "position", eye[0], eye[1], 3);
    put(w, ", ");
    put_moving(w, "target", target[0], target[1], 3);
    put(w,
        ", 'fov_y': 24, 'aspect': 1.3333333333, 'cone': 30, 'views': 3%s}, 'volumes': {'fog': "
        "{'shape': 'sphere', 'density': 1.2, 'albedo': [0.95, 0.9, 0.8], 'g': 0.4, 'transform': {",
        time < 0 ? ", 'shutter': 1" : "");
    put_moving(w, "scale", wide[0], wide[1], 3);
    put(w, ", ");
    put_moving(w, "translate", fog[0], fog[1], 3);
    put(w,
        "}}, 'voxels': {'file': '%s', 'grid': 'half', 'scale': 3, 'albedo': 0.8, 'transform': "
        "{'scale': 0.05, 'rotate': [0, 30, 0], ",
        vdb);
    put_moving(w, "translate", voxels[0], voxels[1], 3);
    put(w, "}}}, 'meshes': {'ground': {'shape': 'quad', 'material': 'clay', "
           "'transform': {'scale': 4, 'translate': [0, -1, 0]}}, 'disk': {'shape': 'disk', "
           "'material': 'glaze', 'transform': {");
    put_moving(w, "scale", size[0], size[1], 3);
    put(w, ", ");
    put_moving(w, "translate", disk[0], disk[1], 3);
    put(w, "}}, 'box': {'shape': 'cube', 'material': 'clay', 'transform': {");
    put_moving(w, "matrix", box[0], box[1], 16);
    put(w, "}}, 'glowing': {'shape': 'quad', 'material': 'glow', 'transform': {'scale': [0.5, 1, "
           "0.3], 'rotate': [70, 0, 0], ");
    put_moving(w, "translate", thin[0], thin[1], 3);
    put(w, "}}}, 'materials': {'clay': {'albedo': [0.5, 0.45, 0.4]}, 'glaze': {'type': 'plastic', "
           "'albedo': [0.6, 0.3, 0.2], 'roughness': 0.5}, 'glow': {'albedo': 0.2, 'emission': 2}}, "
           "'lights': {'sky': {'type': 'environment', ");
    put_moving(w, "radiance", sky[0], sky[1], 3);
    put(w, "}, 'sun': {'type': 'distant', 'irradiance': 1, ");
    put_moving(w, "direction", sun[0], sun[1], 3);
    put(w, "}, 'bulb': {'type': 'point', ");
    put_moving(w, "position", bulb[0], bulb[1], 3);
    put(w, ", ");
    put_moving(w, "intensity", power[0], power[1], 3);
    put(w, "}, 'lamp': {'type': 'disk', 'radius': 0.3, 'radiance': 4, ");
    put_moving(w, "position", lamp[0], lamp[1], 3);
    put(w, "}}}");
}

static lf_scene *before;

static lf_renderer *renderer_of(double time, const char *integrator)
{
    writer w = {.n = 0};
    write_scene(&w, time);
    lf_scene *scene = lf_test_scene_in(".", w.data, before); /* does not read the voxels again */
    lf_scene_unref(before);
    before = scene;
    return lf_test_renderer(scene, integrator, width, height, NULL);
}

static int long_or(int replicates)
{
    return getenv("QUILTD_LONG") ? 8 * replicates : replicates;
}

static void six_cycles(lf_renderer *r)
{
    lf_test_cycles(r, 6);
}

static void blurred(const char *integrator, unsigned faults, uint64_t salt, lf_blocks *out)
{
    lf_renderer *r = renderer_of(-1, integrator);
    r->faults = faults;
    lf_test_pictures(r, six_cycles, LF_ESTIMATOR_MIS, long_or(16), salt, block, out);
    lf_renderer_destroy(r);
}

/* Replicates of the mean over still scenes, one in each sixth of the shutter. */
static void stills(uint64_t salt, lf_blocks *out)
{
    enum { MOMENTS = 6 };
    const int replicates = long_or(12);
    lf_blocks_init(out, n_views, width, height, block);
    for (int k = 0; k < replicates; k++) {
        double mean[width * height * n_views] = {0};
        for (int m = 0; m < MOMENTS; m++) {
            uint64_t seed = lf_hash64(lf_test_seed() + salt, (uint64_t)(k * MOMENTS + m));
            lf_renderer *r =
                renderer_of((m + (double)(lf_hash64(seed, 1) >> 11) * 0x1p-53) / MOMENTS, "vpt");
            lf_test_reseed(r, seed);
            lf_test_cycles(r, 2);
            double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS);
            for (int i = 0; i < width * height * n_views; i++)
                mean[i] += picture[i] / MOMENTS;
            free(picture);
            lf_renderer_destroy(r);
        }
        lf_blocks_add(out, mean);
    }
}

/* What the sound estimators may fail by. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 5 * blocks)
/* What a mistake must be rejected with. */
#define CERTAIN 1e-9

static void a_blurred_picture_is_the_mean_of_still_ones(void **state)
{
    (void)state;
    lf_blocks still, open, fault;
    int where = 0;
    stills(10, &still);
    blurred("mvpt", 0, 20, &open);
    double p = lf_blocks_welch(&open, &still, &where);
    const lf_moments *a = &open.moments[where], *b = &still.moments[where];
    print_message("block %d: %.5g +- %.2g, stills %.5g +- %.2g, p %.2g\n", where, a->mean,
                  lf_moments_error(a), b->mean, lf_moments_error(b), p);
    assert_true(p > LEVEL);
    /* 4 % of the whole picture would be seen. */
    assert_true(lf_blocks_welch_injected(&open, &still, blocks - 1, 1.04) < LEVEL);
    assert_true(lf_blocks_welch_injected(&open, &still, blocks - 1, 0.96) < LEVEL);
    lf_blocks_finish(&open);
    blurred("mvpt", LF_FAULT_NO_TIME, 30, &fault);
    assert_true(lf_blocks_welch(&fault, &still, NULL) < CERTAIN);
    lf_blocks_finish(&fault);
    lf_blocks_finish(&still);
}

static void what_views_share_is_of_one_moment(void **state)
{
    (void)state;
    lf_blocks native, shared;
    blurred("vpt", 0, 40, &native);
    blurred("mvpt", 0, 50, &shared);
    double sound = lf_blocks_welch(&shared, &native, NULL);
    lf_blocks_finish(&shared);
    blurred("mvpt", LF_FAULT_OTHER_TIME, 50, &shared);
    double wrong = lf_blocks_welch(&shared, &native, NULL);
    print_message("p %.2g, with rays of another moment %.2g\n", sound, wrong);
    assert_true(sound > LEVEL);
    assert_true(wrong < CERTAIN);
    lf_blocks_finish(&shared);
    lf_blocks_finish(&native);
}

/* Smallest p of W - n q and of W' - n q. */
static double p_of_weights(unsigned faults)
{
    lf_blocks found[3];
    lf_renderer *r = renderer_of(-1, "mvpt");
    r->faults = faults;
    lf_test_weight_blocks(r, six_cycles, 16, block, found);
    double p = fmin(lf_blocks_p_zero(&found[0], NULL), lf_blocks_p_zero(&found[1], NULL));
    for (int i = 0; i < 3; i++)
        lf_blocks_finish(&found[i]);
    lf_renderer_destroy(r);
    return p;
}

static void weights_are_what_is_expected(void **state)
{
    (void)state;
    assert_true(p_of_weights(0) > LEVEL);
    assert_true(p_of_weights(LF_FAULT_OTHER_TIME) < CERTAIN);
}

/* Volumes that emit and go from the left to the right: all of the light is there, along the way. */
static void flames_take_their_light_along(void **state)
{
    (void)state;
    static const struct {
        bool grid;
        const char *more;
    } kinds[] = {{false, "'shape': 'box', 'density': 0, 'emission': 1"},
                 {true, "'scale': 0, 'emission': {'grid': 'half'}"},
                 {true, "'scale': 0, 'emission': {'grid': 'half'}, 'interpolation': 'nearest'"}};
    char vdb[PATH_MAX], text[PATH_MAX + 1024];
    assert_non_null(realpath(lf_test_built("testdata/patterns.vdb"), vdb));
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        bool grid = kinds[i].grid;
        double sum[2][2] = {{0}}; /* [moves][half of the view] */
        for (int moves = 0; moves < 2; moves++) {
            snprintf(text, sizeof text,
                     "{'camera': {'fov_y': 24, 'views': 1, 'cone': 0, 'shutter': 1}, 'volumes': "
                     "{'flame': {%s%s%s%s, 'transform': {'scale': %g, 'translate': {'keys': [[1, "
                     "[-0.5, 0, 0]], [2, [%g, 0, 0]]]}}}}}",
                     grid ? "'file': '" : "", grid ? vdb : "", grid ? "', " : "", kinds[i].more,
                     grid ? 0.02 : 0.2, moves ? 0.1 : -0.5);
            lf_scene *scene = lf_test_scene(text);
            lf_renderer *r = lf_test_renderer(scene, "mvpt", 32, 24, NULL);
            lf_test_cycles(r, 64);
            double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS);
            for (int k = 0; k < 32 * 24; k++)
                sum[moves][k % 32 >= 14] += picture[k];
            free(picture);
            lf_renderer_destroy(r);
            lf_scene_unref(scene);
        }
        print_message("%.4f %.4f, moving %.4f %.4f\n", sum[0][0], sum[0][1], sum[1][0], sum[1][1]);
        lf_assert_close(sum[0][0] + sum[0][1], sum[1][0] + sum[1][1], 0.02, 0);
        assert_true(sum[1][1] > 0.2 * sum[1][0] && sum[0][1] < 0.02 * sum[0][0]);
    }
}

/* ------------------------------------------------------------------------------------- words -- */

static void the_number_of_threads_changes_nothing(void **state)
{
    (void)state;
    writer w = {.n = 0};
    write_scene(&w, -1);
    lf_scene *scene = lf_test_scene(w.data);
    double *one = lf_test_picture_by(scene, width, height, 1),
           *three = lf_test_picture_by(scene, width, height, 3);
    assert_memory_equal(one, three, width * height * n_views * sizeof *one);
    free(one);
    free(three);
    lf_scene_unref(scene);
}

/* A scene whose meshes are these, with the camera's shutter open or not. */
static lf_scene *scene_of(const char *shutter, const char *meshes, const char *more,
                          const lf_scene *previous)
{
    char text[2048];
    snprintf(text, sizeof text,
             "{'frame': 3, 'camera': {'views': 3, 'position': [0, 0, 5]%s}, 'meshes': {%s}%s, "
             "'lights': {'sky': {'type': 'environment', 'radiance': 1}}}",
             shutter, meshes, more);
    return lf_test_scene_in(".", text, previous);
}

#define STILL "'a': {'shape': 'cube'}"
#define MOVING                                                                                     \
    STILL ", 'b': {'shape': 'cube', 'transform': {'translate': {'keys': [[1, [1, 3, 0]], [9, "     \
          "[17, 3, 0]]]}}}"

static void what_stands_still_is_the_same_with_a_shutter(void **state)
{
    (void)state;
    lf_scene *closed = scene_of("", STILL, "", NULL),
             *open = scene_of(", 'shutter': 0.5", STILL, "", closed);
    assert_ptr_equal(open->geometry, closed->geometry);
    assert_true(json_equal(open->subject, closed->subject));
    assert_false(lf_has(open, LF_TRAIT_MOTION));
    double *a = lf_test_picture_by(closed, width, height, 2),
           *b = lf_test_picture_by(open, width, height, 2);
    assert_memory_equal(a, b, width * height * n_views * sizeof *a);
    free(a);
    free(b);
    lf_scene_unref(closed);
    lf_scene_unref(open);
}

static void a_mesh_is_read_where_it_is_at_both_ends(void **state)
{
    (void)state;
    lf_scene *closed = scene_of("", MOVING, "", NULL),
             *open = scene_of(", 'shutter': 0.5, 'shutter_open': -0.25", MOVING, "", closed),
             *longer = scene_of(", 'shutter': 0.75, 'shutter_open': -0.25", MOVING, "", open),
             *again = scene_of(", 'shutter': 0.5, 'shutter_open': -0.25", MOVING, "", open);
    assert_true(lf_has(open, LF_TRAIT_MOTION));
    assert_false(lf_has(closed, LF_TRAIT_MOTION));
    const lf_mesh *mesh = &open->meshes[1];
    assert_null(open->meshes[0].close.vertices);
    for (int i = 0; i < 3 * mesh->n_vertices; i++)
        lf_assert_close((double)(mesh->close.vertices[i] - mesh->vertices[i]), i % 3 ? 0 : 1, 0,
                        1e-5);
    lf_assert_close(open->geometry->bounds[0][0], -1, 0, 1e-6);
    lf_assert_close(open->geometry->bounds[1][0], 1 + 1 + 2 * 2 + 0.5, 0, 1e-6);
    assert_ptr_equal(again->geometry, open->geometry);
    assert_ptr_not_equal(longer->geometry, open->geometry);
    assert_false(json_equal(longer->subject, open->subject));
    assert_false(json_equal(closed->subject, open->subject));
    lf_scene_unref(closed);
    lf_scene_unref(open);
    lf_scene_unref(longer);
    lf_scene_unref(again);
}

/* Films of two ways through one place are not of one picture. */
static void the_subject_knows_where_a_volume_goes(void **state)
{
    (void)state;
    static const char fog[] = ", 'volumes': {'fog': {'shape': 'sphere', 'transform': {'translate': "
                              "{'keys': [[2, [%d, 0, 0]], [3, [0, 0, 0]], [4, [%d, 0, 0]]]}}}}";
    char right[256], left[256];
    snprintf(right, sizeof right, fog, -1, 1);
    snprintf(left, sizeof left, fog, 1, -1);
    lf_scene *closed = scene_of("", STILL, right, NULL), *shut = scene_of("", STILL, left, NULL),
             *open = scene_of(", 'shutter': 0.5", STILL, right, NULL),
             *other = scene_of(", 'shutter': 0.5", STILL, left, NULL);
    assert_true(lf_has(open, LF_TRAIT_MOTION) && !lf_has(closed, LF_TRAIT_MOTION));
    assert_true(json_equal(closed->subject, shut->subject));
    assert_false(json_equal(open->subject, closed->subject));
    assert_false(json_equal(open->subject, other->subject));
    lf_scene_unref(closed);
    lf_scene_unref(shut);
    lf_scene_unref(open);
    lf_scene_unref(other);
}

static void faces_that_part_are_both_kept(void **state)
{
    (void)state;
    /* in one place when the shutter opens; all the time */
    static const char parting[] = STILL ", 'b': {'shape': 'cube', 'transform': {'translate': "
                                        "{'keys': [[3, [0, 0, 0]], [9, [17, 3, 0]]]}}}",
                      together[] =
                          "'a': {'shape': 'cube', 'transform': {'translate': {'keys': [[3, [0, 0, "
                          "0]], [9, [17, 3, 0]]]}}}, 'b': {'shape': 'cube', 'transform': "
                          "{'translate': {'keys': [[3, [0, 0, 0]], [9, [17, 3, 0]]]}}}";
    lf_scene *scene = scene_of(", 'shutter': 1", parting, "", NULL);
    assert_int_equal(scene->meshes[1].n_triangles, 12);
    lf_scene_unref(scene);
    scene = scene_of(", 'shutter': 1", together, "", NULL);
    assert_int_equal(scene->meshes[1].n_triangles, 0);
    lf_scene_unref(scene);
}

static void volumes_that_flatten_are_refused(void **state)
{
    (void)state;
    static const char format[] =
        "{\"camera\": {\"shutter\": 1}, \"volumes\": {\"v\": {\"shape\": \"box\", \"transform\": "
        "{\"rotate\": {\"keys\": [[1, [0, 0, 0]], [2, [0, %d, 0]]]}}}}}";
    for (int turn = 90; turn <= 180; turn += 90) {
        char text[256];
        lf_error err = {0};
        lf_scene *scene = NULL;
        snprintf(text, sizeof text, format, turn);
        json_t *doc = json_loads(text, 0, NULL);
        lf_status status = lf_scene_from_json(doc, ".", "t", NULL, NULL, &scene, &err);
        assert_int_equal(status, turn == 90 ? LF_OK : LF_E_FORMAT);
        assert_true(turn == 90 || strstr(err.what, "collapses while the shutter is open"));
        lf_scene_unref(scene);
        json_decref(doc);
    }
}

static void what_has_keys_and_stands_still_is_told(void **state)
{
    (void)state;
    static const struct {
        const char *shutter, *more, *words;
    } cases[] = {
        {"", ", 'backdrop': {'keys': [[1, 0], [9, 1]]}", NULL},
        {", 'shutter': 0.5", "", NULL},
        {", 'shutter': 0.5", ", 'backdrop': {'keys': [[1, 0], [3, 1]]}", NULL},
        {", 'shutter': 0.5", ", 'backdrop': {'keys': [[1, 0], [9, 1]]}", ": backdrop"},
        {", 'shutter': 0.5, 'fov_y': {'keys': [[1, 9], [9, 12]]}", "", ": camera"},
        {", 'shutter': 0.5",
         ", 'volumes': {'fog': {'shape': 'box', 'density': {'keys': [[1, 9], [9, 12]]}}, 'mist': "
         "{'shape': 'box'}}",
         ": volumes.fog"},
        {", 'shutter': 0.5",
         ", 'volumes': {'fog': {'shape': 'box', 'transform': {'translate': {'keys': [[1, [0, 0, "
         "0]], [9, [1, 0, 0]]]}}}}",
         NULL},
        {", 'shutter': 0.5", ", 'materials': {'m': {'albedo': {'keys': [[1, 0], [9, 1]]}}}",
         ": materials.m"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_scene *scene = scene_of(cases[i].shutter, MOVING, cases[i].more, NULL);
        const char *found = NULL;
        for (int w = 0; w < scene->warnings.n; w++)
            if (strstr(scene->warnings.line[w], "shutter"))
                found = scene->warnings.line[w];
        if (!found != !cases[i].words || (found && !strstr(found, cases[i].words)))
            fail_msg("case %d: %s", (int)i, found ? found : "nothing is said");
        lf_scene_unref(scene);
    }
    lf_scene *scene = lf_test_scene(
        "{'camera': {'shutter': 0.5}, 'meshes': {" STILL "}, 'lights': {'day': {'type': 'sky', "
        "'elevation': {'keys': [[1, 10], [9, 60]]}}, 'noon': {'type': 'sky', 'azimuth': {'keys': "
        "[[1, 10], [9, 60]]}}}}");
    assert_non_null(strstr(scene->warnings.line[0], ": lights.day"));
    assert_null(strstr(scene->warnings.line[0], "noon"));
    lf_scene_unref(scene);
}

/* ------------------------------------------------------------------------------------- lamps -- */

/* What is drawn of lamps that shrink and stretch lies where rays of that moment find it, with the
 * pdf that they find. */
static void lamps_are_found_as_they_are_drawn(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("shrinking-lights"));
    const lf_vec3 p = {0.2f, 0.1f, 0.3f};
    lf_shutter_time shutter = {0};
    int drawn = 0;
    const lf_moving moving = {.scene = scene};
    assert_int_equal(lf_shutter_time_init(&shutter, &moving), LF_OK);
    for (uint32_t i = 0; i < 600; i++) {
        const float time = lf_sampler_radical(4, i),
                    u[3] = {lf_sampler_radical(1, i), lf_sampler_radical(2, i),
                            lf_sampler_radical(3, i)};
        lf_light_sample sample;
        lf_hit hit;
        float pdf;
        lf_shutter_time_set(&shutter, &moving, time);
        lf_tracer tracer = {.scene = &shutter.scene, .time = time};
        if (!lf_light_draw(&shutter.scene, p, u, &sample))
            continue;
        assert_true(lf_trace_surface(&tracer, p, sample.wi, INFINITY, &hit));
        if (hit.mesh != sample.mesh || hit.triangle != sample.triangle)
            continue; /* an edge, or another one before it */
        lf_light_hit(&shutter.scene, p, &hit, &pdf);
        lf_assert_close((double)pdf, (double)sample.pdf, 2e-3, 0);
        lf_assert_close((double)lf_length(lf_sub(hit.p, sample.point)), 0, 0, 1e-5);
        drawn++;
    }
    assert_true(drawn > 300);
    lf_shutter_time_finish(&shutter);
    lf_scene_unref(scene);
}

/* A sky that changes is known light of every pixel, whether or not anything is before it. */
static void a_sky_that_changes_is_its_mean(void **state)
{
    (void)state;
    lf_scene *scene =
        lf_test_scene("{'camera': {'views': 3, 'shutter': 0.5, 'shutter_open': 1}, 'lights': "
                      "{'sky': {'type': 'environment', 'radiance': {'keys': [[1, 0], [9, 8]]}}}}");
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_test_cycles(r, 32);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_MWIS);
    for (int i = 0; i < width * height * n_views; i++)
        lf_assert_close(picture[i], 1.25, 0, 0.01);
    free(picture);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static int finish(void **state)
{
    lf_scene_unref(before);
    return lf_test_finish(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_edge_is_a_ramp_as_wide_as_it_moves),
        cmocka_unit_test(a_blurred_picture_is_the_mean_of_still_ones),
        cmocka_unit_test(what_views_share_is_of_one_moment),
        cmocka_unit_test(weights_are_what_is_expected),
        cmocka_unit_test(flames_take_their_light_along),
        cmocka_unit_test(the_number_of_threads_changes_nothing),
        cmocka_unit_test(lamps_are_found_as_they_are_drawn),
        cmocka_unit_test(a_sky_that_changes_is_its_mean),
        cmocka_unit_test(what_stands_still_is_the_same_with_a_shutter),
        cmocka_unit_test(a_mesh_is_read_where_it_is_at_both_ends),
        cmocka_unit_test(the_subject_knows_where_a_volume_goes),
        cmocka_unit_test(faces_that_part_are_both_kept),
        cmocka_unit_test(volumes_that_flatten_are_refused),
        cmocka_unit_test(what_has_keys_and_stands_still_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, finish);
}
