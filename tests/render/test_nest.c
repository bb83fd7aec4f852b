/* Glass in glass: each face parts what is on its two sides. Against closed forms of flat layers,
 * and against a tracer of boxes of its own, in double precision, that looks up at every point which
 * of them is there. */
#include "tests/testing.h"

#include "render/scene/vec_double.h"
#include "render/transport/path/path.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

#define GLASS "'type': 'principled', 'albedo': 1, 'transmission': 1, "

#define WHITE "'type': 'principled', 'albedo': 1, 'transmission': %g, "

static const double clear[3] = {0, 0, 0}, green[3] = {0.5, 0.1, 0.3}, blue[3] = {0.9, 0.3, 0.05};

/* What is found along one ray. */
typedef struct light {
    lf_moments channel[3];
} light;

static void look(lf_scene *scene, lf_vec3 o, lf_vec3 w, int n, light *out)
{
    lf_tracer tracer = {.scene = scene, .rng = lf_test_seed() + 7};
    lf_event event = {.kind = LF_EVENT_SURFACE, .w = w};
    *out = (light){0};
    assert_true(lf_trace_surface(&tracer, o, w, INFINITY, &event.hit));
    event.p = event.hit.p;
    for (int i = 0; i < n; i++) {
        lf_vec3 l = lf_path_scattered(&tracer, &event, 1, 1024);
        lf_moments_add(&out->channel[0], (double)l.x);
        lf_moments_add(&out->channel[1], (double)l.y);
        lf_moments_add(&out->channel[2], (double)l.z);
    }
}

/* ------------------------------------------------------------------------------- flat layers -- */

/* Reflectance from the front and from behind, and transmittance. */
typedef struct layer {
    double front, behind, t;
} layer;

static layer face(double from, double to)
{
    double r = (to - from) / (to + from);
    return (layer){r * r, r * r, 1 - r * r};
}

static layer filling(double sigma, double way)
{
    return (layer){0, 0, exp(-sigma * way)};
}

/* All that goes to and fro between two. */
static layer stacked(layer a, layer b)
{
    double again = 1 / (1 - a.behind * b.front);
    return (layer){a.front + a.t * a.t * b.front * again, b.behind + b.t * b.t * a.behind * again,
                   a.t * b.t * again};
}

/* Straight through a slab 2 thick of glass (1.5) with water (1.33) in its middle, so wide to either
 * side. */
static double through(double half, double of_glass, double of_water)
{
    const layer stack[] = {
        face(1, 1.5),    filling(of_glass, 1 - half), face(1.5, 1.33), filling(of_water, 2 * half),
        face(1.33, 1.5), filling(of_glass, 1 - half), face(1.5, 1)};
    layer all = stack[0];
    for (int i = 1; i < 7; i++)
        all = stacked(all, stack[i]);
    return all.t;
}

#define WALL                                                                                       \
    "'wall': { 'shape': 'quad', 'material': 'wall', 'transform': { 'scale': 90, 'rotate': "        \
    "[90, 0, 0], 'translate': [0, 0, -5] } }"
#define OPEN_LAYERS(meshes, glass, water)                                                          \
    "{ 'meshes': { " meshes ", " WALL " }, 'materials': { 'glass': { " GLASS "'roughness': 0, "    \
    "'ior': 1.5" glass " }, 'water': { " GLASS "'roughness': 0, 'ior': 1.33" water                 \
    " }, 'wall': { 'albedo': 0, 'emission': 1 } }"
#define LAYERS(meshes, glass, water) OPEN_LAYERS(meshes, glass, water) " }"
#define SLAB                                                                                       \
    "'slab': { 'shape': 'cube', 'material': 'glass', 'transform': { 'scale': [40, 40, 1] } }"
#define WATER(half)                                                                                \
    "'water': { 'shape': 'cube', 'material': 'water', 'transform': { 'scale': [20.5, 20.5, " half  \
    "] } }"
#define GREEN ", 'absorption': [0.5, 0.1, 0.3]"
#define BLUE ", 'absorption': [0.9, 0.3, 0.05]"

/* A cube with a hollow one in it, and that as a mesh of its own, inside out. */
static const char outer[] = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\n"
                            "v 1 1 1\nv -1 1 1\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\n"
                            "f 3 4 8 7\nf 4 1 5 8\n",
                  inner[] = "v -.5 -.5 -.5\nv .5 -.5 -.5\nv .5 .5 -.5\nv -.5 .5 -.5\n"
                            "v -.5 -.5 .5\nv .5 -.5 .5\nv .5 .5 .5\nv -.5 .5 .5\n",
                  inside_out[] = "f -8 -7 -6 -5\nf -4 -1 -2 -3\nf -8 -4 -3 -7\nf -7 -3 -2 -6\n"
                                 "f -6 -2 -1 -5\nf -5 -1 -4 -8\n";
#define FILE(name)                                                                                 \
    "'" name "': { 'file': '" name                                                                 \
    ".obj', 'material': 'glass', 'transform': { 'scale': [40, 40, 1] } }"

static void write_bottles(const char *folder)
{
    char text[2048];
    snprintf(text, sizeof text, "%s%s%s", outer, inner, inside_out);
    lf_test_write(folder, "bottle.obj", text);
    lf_test_write(folder, "outside.obj", outer);
    snprintf(text, sizeof text, "%s%s", inner, inside_out);
    lf_test_write(folder, "hollow.obj", text);
}

static void assert_through(const char *folder, const char *text, double half,
                           const double of_glass[3], const double of_water[3])
{
    lf_scene *scene = lf_test_scene_in(folder, text, NULL);
    light seen;
    look(scene, lf_v3(0.3f, 0.2f, 9.0f), lf_v3(0.0f, 0.0f, -1.0f), 100000, &seen);
    for (int c = 0; c < 3; c++) {
        double want = through(half, of_glass[c], of_water[c]);
        print_message("%.4f +- %.4f, %.4f\n", seen.channel[c].mean,
                      lf_moments_error(&seen.channel[c]), want);
        assert_true(lf_p_mean(&seen.channel[c], want) > lf_sidak(LF_FALSE_ALARM, 3 * 10));
        assert_true(lf_p_mean(&seen.channel[c], want * 0.985) < 1e-9); /* the power of it */
    }
    lf_scene_unref(scene);
}

static void water_in_glass_reflects_little(void **state)
{
    assert_through(*state, LAYERS(SLAB ", " WATER("0.5"), "", ""), 0.5, clear, clear);
    assert_through(*state, LAYERS(SLAB ", " WATER("0.5"), GREEN, BLUE), 0.5, green, blue);
}

/* Water that reaches into the wall of its bottle, of which the one is there or the other. */
static void priority_says_which_of_two_is_there(void **state)
{
    write_bottles(*state);
    const char bottle[] = LAYERS(FILE("bottle") ", " WATER("0.6"), GREEN ", 'priority': 1", BLUE),
               water[] = LAYERS(FILE("bottle") ", " WATER("0.6"), GREEN, BLUE ", 'priority': 1"),
               neither[] = LAYERS(FILE("bottle") ", " WATER("0.6"), GREEN, BLUE),
               lower[] = LAYERS(FILE("bottle") ", " WATER("0.6"), GREEN, BLUE ", 'priority': -1");
    assert_through(*state, bottle, 0.5, green, blue);
    assert_through(*state, lower, 0.5, green, blue);
    assert_through(*state, water, 0.6, green, blue);
    assert_through(*state, neither, 0.6, green, blue);
}

static void a_hollow_may_be_a_mesh_of_its_own(void **state)
{
    write_bottles(*state);
    assert_through(*state,
                   LAYERS(FILE("outside") ", " FILE("hollow") ", " WATER("0.6"),
                          GREEN ", 'priority': 1", BLUE),
                   0.5, green, blue);
}

/* Faces in the same place count as one, whichever of them rays meet. */
static void water_may_touch_its_bottle(void **state)
{
    write_bottles(*state);
    assert_through(*state, LAYERS(FILE("bottle") ", " WATER("0.5"), GREEN, BLUE), 0.5, green, blue);
    assert_through(*state, LAYERS(FILE("bottle") ", " WATER("0.5"), GREEN, BLUE ", 'priority': -1"),
                   0.5, green, blue);
}

/* A slab of two halves, one of glass and one of water, is no slab in air and another. */
static void solids_may_stand_side_by_side(void **state)
{
    const char text[] = LAYERS(
        "'a': { 'shape': 'cube', 'material': 'glass', 'transform': { 'scale': [9, 9, 0.5], "
        "'translate': [0, 0, 0.5] } }, 'b': { 'shape': 'cube', 'material': 'water', 'transform': { "
        "'scale': [7, 7, 0.5], 'translate': [0, 0, -0.5] } }",
        GREEN, BLUE);
    lf_scene *scene = lf_test_scene_in(*state, text, NULL);
    light seen;
    look(scene, lf_v3(0.3f, 0.2f, 9.0f), lf_v3(0.0f, 0.0f, -1.0f), 100000, &seen);
    for (int c = 0; c < 3; c++) {
        const layer stack[] = {face(1, 1.5), filling(green[c], 1), face(1.5, 1.33),
                               filling(blue[c], 1), face(1.33, 1)};
        layer all = stack[0];
        for (int i = 1; i < 5; i++)
            all = stacked(all, stack[i]);
        print_message("%.4f +- %.4f, %.4f\n", seen.channel[c].mean,
                      lf_moments_error(&seen.channel[c]), all.t);
        assert_true(lf_p_mean(&seen.channel[c], all.t) > lf_sidak(LF_FALSE_ALARM, 3));
    }
    lf_scene_unref(scene);
}

/* ------------------------------------------------------------------------------------- Snell -- */

/* Along the refracted ray to each of the four faces. */
static void rays_bend_by_what_is_on_both_sides(void **state)
{
    lf_scene *scene = lf_test_scene_in(*state, LAYERS(SLAB ", " WATER("0.5"), "", ""), NULL);
    const double sine = sin(0.9), index[] = {1, 1.5, 1.33, 1.5, 1};
    lf_tracer tracer = {.scene = scene, .rng = 1};
    lf_event events[2] = {
        {.kind = LF_EVENT_SURFACE, .w = lf_v3((float)sine, 0.0f, (float)-cos(0.9))}};
    lf_event *here = &events[0], *next = &events[1];
    assert_true(lf_trace_surface(&tracer, lf_v3(-2.0f, 0.2f, 3.0f), here->w, INFINITY, &here->hit));
    here->p = here->hit.p;
    for (int i = 1; i < 5; i++) {
        lf_shading shading;
        lf_shade(&here->hit, lf_scale(here->w, -1.0f), &shading);
        assert_int_equal(shading.n_deltas, 2);
        lf_assert_close((double)shading.delta[1].wi.x, sine / index[i], 1e-5, 0);
        lf_path_next(&tracer, here, shading.delta[1].wi, next);
        lf_event *swap = here;
        here = next;
        next = swap;
    }
    assert_ptr_equal(here->hit.mesh, &scene->meshes[2]); /* the wall */
    lf_scene_unref(scene);
}

/* ------------------------------------------------------------------------------- brute force -- */

typedef struct box {
    double half[3], middle[3], turn; /* about y, degrees */
    double index, sigma[3];
} box;

/* The first is the one that is there, where both are; against_air: each face by itself. */
typedef struct boxes {
    box item[2];
    bool against_air;
} boxes;

static double draw(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    uint64_t x = (*state ^ *state >> 29) * 0xbf58476d1ce4e5b9u;
    return (double)((x ^ x >> 32) >> 11) * 0x1p-53;
}

static void turned(const box *b, const double v[3], int way, double out[3])
{
    double c = cos(b->turn * M_PI / 180), s = way * sin(b->turn * M_PI / 180);
    out[0] = c * v[0] + s * v[2];
    out[1] = v[1];
    out[2] = c * v[2] - s * v[0];
}

static void to_box(const box *b, const double p[3], double out[3])
{
    double d[3] = {p[0] - b->middle[0], p[1] - b->middle[1], p[2] - b->middle[2]};
    turned(b, d, -1, out);
}

/* 0 or 1; -1: air. */
static int there(const boxes *of, const double p[3])
{
    for (int k = 0; k < 2; k++) {
        double q[3];
        to_box(&of->item[k], p, q);
        if (fabs(q[0]) < of->item[k].half[0] && fabs(q[1]) < of->item[k].half[1] &&
            fabs(q[2]) < of->item[k].half[2])
            return k;
    }
    return -1;
}

/* The nearest face: its distance, normal and whose it is. */
static double meet(const boxes *of, const double p[3], const double w[3], double n[3], int *whose)
{
    double nearest = INFINITY;
    for (int k = 0; k < 2; k++) {
        const box *b = &of->item[k];
        double q[3], d[3];
        to_box(b, p, q);
        turned(b, w, -1, d);
        for (int side = 0; side < 6; side++) {
            int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
            double t = ((side % 2 ? b->half[axis] : -b->half[axis]) - q[axis]) / d[axis];
            if (t < 1e-9 || t >= nearest || fabs(q[u] + t * d[u]) > b->half[u] ||
                fabs(q[v] + t * d[v]) > b->half[v])
                continue;
            double own[3] = {0, 0, 0};
            own[axis] = d[axis] > 0 ? -1 : 1;
            turned(b, own, 1, n);
            nearest = t;
            *whose = k;
        }
    }
    return nearest;
}

/* Reflects or refracts w, by chance. */
static void turn(double eta, const double n[3], double u, double w[3])
{
    double c = -(w[0] * n[0] + w[1] * n[1] + w[2] * n[2]), k = 1 - (1 - c * c) / (eta * eta);
    double f = 1, b = 0;
    if (k > 0) {
        b = sqrt(k);
        double s = (c - eta * b) / (c + eta * b), p = (eta * c - b) / (eta * c + b);
        f = 0.5 * (s * s + p * p);
    }
    for (int i = 0; i < 3; i++)
        w[i] = u < f ? w[i] + 2 * c * n[i] : w[i] / eta + (c / eta - b) * n[i];
}

/* A lamp over it and an even sky. */
enum { LAMP_Y = 3, LAMP_HALF = 2 };
static double found(const double p[3], const double w[3])
{
    double t = (LAMP_Y - p[1]) / w[1];
    return t > 0 && fabs(p[0] + t * w[0]) < LAMP_HALF && fabs(p[2] + t * w[2]) < LAMP_HALF ? 4
                                                                                           : 0.5;
}

static void brute(const boxes *of, const double o[3], const double d[3], int n, uint64_t seed,
                  light *out)
{
    uint64_t state = seed;
    *out = (light){0};
    for (int i = 0; i < n; i++) {
        double p[3] = {o[0], o[1], o[2]}, w[3] = {d[0], d[1], d[2]}, left[3] = {1, 1, 1}, normal[3];
        int whose = 0;
        for (int k = 0; k < 4000; k++) {
            double t = meet(of, p, w, normal, &whose), mid[3], after[3];
            if (isinf(t))
                break;
            for (int a = 0; a < 3; a++) {
                mid[a] = p[a] + 0.5 * t * w[a];
                p[a] += t * w[a];
                after[a] = p[a] + 1e-7 * w[a];
            }
            int here = there(of, mid), beyond = there(of, after);
            for (int c = 0; c < 3 && here >= 0; c++)
                left[c] *= exp(-of->item[here].sigma[c] * t);
            double from = here >= 0 ? of->item[here].index : 1,
                   to = beyond >= 0 ? of->item[beyond].index : 1, q[3];
            to_box(&of->item[whose], mid, q);
            bool within = fabs(q[0]) < of->item[whose].half[0] &&
                          fabs(q[1]) < of->item[whose].half[1] &&
                          fabs(q[2]) < of->item[whose].half[2];
            double own = of->item[whose].index;
            if (of->against_air)
                turn(within ? 1 / own : own, normal, draw(&state), w);
            else if (here != beyond)
                turn(to / from, normal, draw(&state), w);
        }
        double l = found(p, w);
        for (int c = 0; c < 3; c++)
            lf_moments_add(&out->channel[c], left[c] * l);
    }
}

#define BOXES(first, second, place)                                                                \
    "{ 'meshes': { 'glass': { 'shape': 'cube', 'material': 'glass', 'transform': { 'rotate': "     \
    "[0, 20, 0] } }, 'water': { 'shape': 'cube', 'material': 'water', 'transform': { 'scale': "    \
    "[0.5, 0.6, 0.4], 'rotate': [0, -35, 0], 'translate': " place " } }, 'lamp': { 'shape': "      \
    "'quad', 'material': 'lamp', 'transform': { 'scale': 2, 'translate': [0, 3, 0] } } }, "        \
    "'materials': { 'glass': { " GLASS "'roughness': 0, 'ior': 1.5" GREEN first                    \
    " }, 'water': { " GLASS "'roughness': 0, 'ior': 1.33" BLUE second                              \
    " }, 'lamp': { 'albedo': 0, 'emission': 4 } }, 'lights': { 'sky': { 'type': 'environment', "   \
    "'radiance': 0.5 } } }"
#define GLASS_BOX                                                                                  \
    {                                                                                              \
        {1, 1, 1}, {0, 0, 0}, 20, 1.5,                                                             \
        {                                                                                          \
            0.5, 0.1, 0.3                                                                          \
        }                                                                                          \
    }
#define WATER_BOX(...)                                                                             \
    {                                                                                              \
        {0.5, 0.6, 0.4}, __VA_ARGS__, -35, 1.33,                                                   \
        {                                                                                          \
            0.9, 0.3, 0.05                                                                         \
        }                                                                                          \
    }

enum { CASES = 4, RAYS = 6 };
static const struct {
    const char *text;
    boxes as;
} cases[CASES] = {
    {BOXES("", "", "[0.15, -0.1, 0.2]"), {{WATER_BOX({0.15, -0.1, 0.2}), GLASS_BOX}, false}},
    /* the water sticks out of it */
    {BOXES("", "", "[0.4, 0.2, 0.9]"), {{WATER_BOX({0.4, 0.2, 0.9}), GLASS_BOX}, false}},
    {BOXES("", ", 'priority': 2", "[0.4, 0.2, 0.9]"),
     {{WATER_BOX({0.4, 0.2, 0.9}), GLASS_BOX}, false}},
    {BOXES(", 'priority': 2", ", 'priority': 1", "[0.4, 0.2, 0.9]"),
     {{GLASS_BOX, WATER_BOX({0.4, 0.2, 0.9})}, false}},
};

static void boxes_look_as_brute_force_has_them(void **state)
{
    (void)state;
#if defined(__SANITIZE_ADDRESS__)
    print_message("left out here: it repeats, for its statistics, what the others do once\n");
    skip();
#endif
    const int n = lf_test_long() ? 400000 : 40000;
    for (int i = 0; i < CASES; i++) {
        lf_scene *scene = lf_test_scene(cases[i].text);
        boxes wrong = cases[i].as;
        double p_wrong = 1;
        wrong.against_air = true;
        for (int k = 0; k < RAYS; k++) {
            const double w[3] = {0.1 * (k - 2), -0.3, -sqrt(1 - 0.09 - 0.01 * (k - 2) * (k - 2))},
                         o[3] = {0.2 * k - 0.3 - 4 * w[0], 0.15 * k - 0.35 - 4 * w[1], -4 * w[2]};
            light seen, right, other;
            look(scene, lf_to_vec3(o), lf_to_vec3(w), n, &seen);
            brute(&cases[i].as, o, w, n, lf_test_seed() + (uint64_t)k, &right);
            brute(&wrong, o, w, n, lf_test_seed() + 100 + (uint64_t)k, &other);
            for (int c = 0; c < 3; c++) {
                double p = lf_p_welch(&seen.channel[c], &right.channel[c]);
                p_wrong = fmin(p_wrong, lf_p_welch(&seen.channel[c], &other.channel[c]));
                if (!(p > lf_sidak(LF_FALSE_ALARM, CASES * RAYS * 3)))
                    fail_msg("case %d, ray %d, channel %d: %.5g +- %.2g, not %.5g +- %.2g, p %.2g",
                             i, k, c, seen.channel[c].mean, lf_moments_error(&seen.channel[c]),
                             right.channel[c].mean, lf_moments_error(&right.channel[c]), p);
            }
        }
        assert_true(p_wrong < 1e-9);
        lf_scene_unref(scene);
    }
}

/* ---------------------------------------------------------------------------------- pictures -- */

enum { width = 32, height = 24, n_views = 2, tile = 8, blocks_of_all = n_views * 12 + 1 };

static void schedule(lf_renderer *r)
{
    lf_test_passes(r, 8 * n_views);
}

static void pictures(const char *text, const char *integrator, uint64_t seed, lf_blocks *out)
{
    lf_test_pictures_of(lf_test_scene(text), integrator, width, height, schedule, seed, tile, out);
}

static void assert_alike(const char *text, const char *as, const char *other)
{
    lf_blocks a, b, c;
    int where = 0;
    pictures(text, "vpt", 100, &a);
    pictures(as, "mvpt", 200, &b);
    pictures(other, "mvpt", 300, &c);
    double p = lf_blocks_welch(&a, &b, &where);
    if (!(p > lf_sidak(LF_FALSE_ALARM, 5 * blocks_of_all)))
        fail_msg("block %d: %.5g +- %.2g, not %.5g +- %.2g, p %.2g", where, a.moments[where].mean,
                 lf_moments_error(&a.moments[where]), b.moments[where].mean,
                 lf_moments_error(&b.moments[where]), p);
    assert_true(lf_blocks_welch(&a, &c, NULL) < 1e-9);
    lf_blocks_finish(&a);
    lf_blocks_finish(&b);
    lf_blocks_finish(&c);
}

#define LEFT(scale, at) "'left': {'transform': {'scale': " scale ", 'translate': " at "}}"
#define RIGHT(scale, at) "'right': {'transform': {'scale': " scale ", 'translate': " at "}}"
#define ONE(scale) LEFT(scale, "[0, 0, 0]") ", 'right': null"

/* The scene with other blocks. */
static const char *dim(const char *blocks)
{
    return lf_test_scene_patched("dim-blocks", "{'meshes': {%s}}", blocks);
}

/* Light goes from the lamp in one to the card in the other through faces that are not there. */
static void solids_of_one_glass_that_overlap_are_one(void **state)
{
    (void)state;
    const char *one = dim(ONE("[1.5, 1, 1]")), *lower = dim(ONE("[1.5, 0.8, 1]"));
    assert_alike(lf_test_scene_text("dim-blocks"), one, lower);
    assert_alike(dim(RIGHT("[0.9, 1, 1]", "[0.6, 0, 0]")), one, lower);
    assert_alike(
        dim(LEFT("[1.5, 1, 1]", "[0, 0, 0]") ", " RIGHT("[0.6, 0.8, 0.9]", "[0.8, 0.1, 0]")), one,
        lower);
}

/* Each view by itself, and all by the light that they share. */
static void views_share_what_stands_in_rough_glass(void **state)
{
    (void)state;
    const char *right = lf_test_scene_text("frosted-glass"),
               *wrong =
                   lf_test_scene_patched("frosted-glass", "{'materials': {'water': {'ior': 1.6}}}");
    assert_alike(right, right, wrong);
}

/* Lossless glass under an even sky is not seen: smooth, and within what E of rough faces keeps. */
static void glass_in_glass_is_not_seen_under_an_even_sky(void **state)
{
    (void)state;
    for (int i = 0; i < 8; i++) {
        light seen;
        const int rough = i / 2 % 2;
        const double clear_share = i < 4 ? 1.0 : 0.5; /* the rest is white and diffuse */
        lf_scene *scene = lf_test_scene(lf_test_scene_patched(
            "glass-in-glass",
            "{'materials': {'a': {'transmission': %g, 'ior': %g, 'roughness': %g}, "
            "'b': {'transmission': %g, 'ior': %g, 'roughness': %g}}}",
            clear_share, i % 2 ? 1.33 : 2.4, rough * 0.3, clear_share, i % 2 ? 2.0 : 1.05,
            rough * 0.4));
        look(scene, lf_v3(0.2f, 0.3f, 4.0f), lf_v3(0.0f, 0.0f, -1.0f), 40000, &seen);
        print_message("%.4f +- %.4f\n", seen.channel[1].mean, lf_moments_error(&seen.channel[1]));
        lf_assert_close(seen.channel[1].mean, 1.0, i < 2 ? 1e-4 : 1e-2,
                        5 * lf_moments_error(&seen.channel[1]));
        lf_scene_unref(scene);
    }
}

static bool tells(const char *folder, const char *text, const char *what)
{
    lf_scene *scene = lf_test_scene_in(folder, text, NULL);
    bool told = false;
    for (int k = 0; lf_scene_warning(scene, k); k++)
        told |= !!strstr(lf_scene_warning(scene, k), what);
    lf_scene_unref(scene);
    return told;
}

/* What refracts as if in air is told by name. */
static void what_does_not_count_is_told(void **state)
{
    write_bottles(*state);
    lf_test_write(*state, "lid.obj", "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 .1 -1\nf 1 2 3 4\n");
    const char whole[] = LAYERS(FILE("bottle") ", " WATER("0.6"), "", ""),
               open[] = LAYERS(FILE("bottle") ", 'lid': { 'file': 'lid.obj', 'material': 'water' }",
                               "", ""),
               inside[] = OPEN_LAYERS(FILE("bottle") ", " WATER("0.6"), "",
                                      "") ", 'camera': { 'position': [0, 0, 0.2] } }",
               between[] = OPEN_LAYERS(FILE("bottle") ", " WATER("0.3"), "",
                                       "") ", 'camera': { 'position': [0, 0, 0.4] } }";
    assert_false(tells(*state, whole, "as if in air"));
    assert_true(tells(*state, open, "mesh \"lid\" is glass in or around other glass"));
    assert_true(tells(*state, inside, "the camera is inside the mesh \"water\""));
    assert_false(tells(*state, between, "as if in air"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(water_in_glass_reflects_little),
        lf_test_in_folder(priority_says_which_of_two_is_there),
        lf_test_in_folder(a_hollow_may_be_a_mesh_of_its_own),
        lf_test_in_folder(water_may_touch_its_bottle),
        lf_test_in_folder(solids_may_stand_side_by_side),
        lf_test_in_folder(rays_bend_by_what_is_on_both_sides),
        lf_test_in_folder(what_does_not_count_is_told),
        cmocka_unit_test(boxes_look_as_brute_force_has_them),
        cmocka_unit_test(solids_of_one_glass_that_overlap_are_one),
        cmocka_unit_test(views_share_what_stands_in_rough_glass),
        cmocka_unit_test(glass_in_glass_is_not_seen_under_an_even_sky),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
