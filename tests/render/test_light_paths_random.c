/* Light paths in random scenes: pictures with them, by mvpt and by vpt, of two strengths, against
 * pictures by camera paths alone, tile by tile. Materials, lights, shapes and instances are drawn.
 *
 * Caustics of small lights have heavy tails in pictures by camera paths, which Welch's test does not
 * know. So a scene that is rejected is rendered again from other seeds, eight times as long, and
 * only a scene that is rejected twice fails. Where no camera path finds some light (lights without
 * size in a scene with mirrors), both integrators with light paths are compared alone. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 16, height = 12, block = 4, n_views = 3, blocks_of_views = 12 * n_views + 1 };
enum { REPLICATES = 10, CI_SCENES = 8, LONG_SCENES = 400, TEXT = 8192 };

/* Comparisons of a scene: two integrators with light paths against camera paths, or against each
 * other, and two strengths. */
enum { COMPARISONS = 3 };

/* ------------------------------------------------------------------------------ random scenes -- */

typedef struct drawing {
    uint64_t key;
    unsigned n;
    bool mirrors, points, no_size; /* what has been drawn */
    char text[TEXT];
} drawing;

static double number(drawing *d, double low, double high)
{
    return low + (high - low) * (double)(lf_hash64(d->key, d->n++) >> 11) * 0x1p-53;
}

static int below(drawing *d, int n)
{
    return (int)number(d, 0.0, n);
}

__attribute__((format(printf, 2, 3))) static void say(drawing *d, const char *format, ...)
{
    const size_t at = strlen(d->text);
    va_list list;
    va_start(list, format);
    const int n = vsnprintf(d->text + at, TEXT - at, format, list);
    va_end(list);
    assert_true(n >= 0 && (size_t)n < TEXT - at);
}

static void say_colour(drawing *d, const char *key, double low, double high)
{
    const double r = number(d, low, high), g = number(d, low, high), b = number(d, low, high);
    say(d, ", '%s': [%.3f, %.3f, %.3f]", key, r, g, b);
}

/* Rough layers of the principled model. */
static void say_layers(drawing *d)
{
    say(d, "{'type': 'principled', 'roughness': %.3f", number(d, 0.35, 0.8));
    if (below(d, 2))
        say(d, ", 'metallic': %.3f", number(d, 0.0, 1.0));
    if (below(d, 3) == 0)
        say(d, ", 'anisotropy': %.3f", number(d, 0.2, 0.8));
    if (below(d, 3) == 0)
        say_colour(d, "sheen", 0.0, 1.0);
    if (below(d, 3) == 0)
        say_colour(d, "specular_tint", 0.0, 1.0);
    if (below(d, 2)) {
        const bool smooth = below(d, 3) == 0;
        d->mirrors |= smooth;
        say(d, ", 'coat': %.3f, 'coat_roughness': %.3f", number(d, 0.2, 1.0),
            smooth ? 0.0 : number(d, 0.3, 0.7));
    }
}

static void say_glass(drawing *d)
{
    const bool smooth = below(d, 2);
    d->mirrors |= smooth;
    say(d, "{'type': 'principled', 'glass': 'solid', 'transmission': %.3f, 'roughness': %.3f",
        below(d, 2) ? 1.0 : number(d, 0.3, 1.0), smooth ? 0.0 : number(d, 0.35, 0.7));
    say(d, ", 'ior': %.3f", number(d, 1.1, 1.7));
    if (below(d, 3) == 0)
        say_colour(d, "absorption", 0.0, 2.0);
    if (below(d, 6) == 0)
        say_colour(d, "scattering", 0.0, 1.0);
}

/* closed: of a mesh that may be of glass. */
static void say_material(drawing *d, bool closed)
{
    const int kind = below(d, closed ? 8 : 6);
    if (kind == 0)
        say(d, "{'type': 'diffuse'");
    else if (kind == 1 || kind == 2)
        say(d, "{'type': 'conductor', 'roughness': %.3f", number(d, 0.35, 0.7));
    else if (kind == 3)
        say(d, "{'type': 'plastic', 'roughness': %.3f", number(d, 0.35, 0.7));
    else if (kind == 4)
        say_layers(d);
    else if (kind == 5) {
        say(d, "{'type': 'conductor', 'roughness': 0");
        d->mirrors = true;
    } else
        say_glass(d);
    say_colour(d, "albedo", 0.3, 0.9);
    if (kind < 6 && below(d, 5) == 0)
        say(d, ", 'alpha': %.3f", number(d, 0.3, 0.9));
    if (kind < 5 && below(d, 8) == 0)
        say_colour(d, "emission", 0.0, 1.5);
    say(d, "}");
}

static void say_place(drawing *d, double size)
{
    const double a = number(d, -180, 180), b = number(d, -180, 180), c = number(d, -180, 180),
                 x = number(d, -0.9, 0.9), y = number(d, -0.2, 0.6), z = number(d, -0.7, 0.7);
    const double stretch = below(d, 3) ? 1.0 : number(d, 0.5, 1.5);
    say(d, "{'scale': [%.3f, %.3f, %.3f], 'rotate': [%.1f, %.1f, %.1f], 'translate': [%.3f, %.3f, %.3f]}",
        size, size * stretch, below(d, 6) ? size : -size, a, b, c, x, y, z);
}

static void say_meshes(drawing *d, int n)
{
    static const char *const shapes[] = {"sphere", "cube", "quad", "disk"};
    say(d, "'meshes': {'floor': {'shape': 'quad', 'material': 'floor', 'transform': {'scale': %.2f, "
           "'translate': [0, -0.5, 0]}}",
        number(d, 1.0, 2.0));
    for (int i = 0; i < n; i++) {
        const int shape = below(d, 4);
        say(d, ", 'm%d%s': {'shape': '%s', 'material': 'm%d%s', ", i, shape < 2 ? "c" : "",
            shapes[shape], i, shape < 2 ? "c" : "");
        if (below(d, 4)) {
            say(d, "'transform': ");
            say_place(d, number(d, 0.15, 0.4));
        } else {
            say(d, "'transform': {'scale': %.3f}, 'instances': [", number(d, 0.15, 0.3));
            const int times = 1 + below(d, 3);
            for (int k = 0; k < times; k++) {
                say(d, k ? ", " : "");
                say_place(d, 1.0);
            }
            say(d, "]");
        }
        say(d, "}");
    }
    say(d, "}");
}

static void say_at(drawing *d)
{
    const double x = number(d, -1, 1), y = number(d, 0.7, 1.4), z = number(d, -0.8, 0.8);
    say(d, "'position': [%.3f, %.3f, %.3f]", x, y, z);
}

static void say_towards(drawing *d)
{
    const double x = number(d, -0.8, 0.8), y = number(d, -1, -0.3), z = number(d, -0.8, 0.8);
    say(d, "'direction': [%.3f, %.3f, %.3f]", x, y, z);
}

static void say_light(drawing *d)
{
    switch (below(d, 7)) {
    case 0:
        say(d, "{'type': 'distant', 'angle': 0, ");
        say_towards(d);
        d->no_size = true;
        break;
    case 1:
    case 2:
        say(d, "{'type': 'distant', 'angle': %.2f, ", below(d, 2) ? number(d, 4, 12) : number(d, 12, 90));
        say_towards(d);
        break;
    case 3:
        say(d, "{'type': 'sphere', 'radius': %.3f, 'power': %.2f, ", number(d, 0.08, 0.3), number(d, 5, 20));
        say_at(d);
        break;
    case 4:
        say(d, "{'type': '%s', 'power': %.2f, ", below(d, 2) ? "disk" : "rectangle", number(d, 5, 20));
        if (strstr(d->text + strlen(d->text) - 40, "disk"))
            say(d, "'radius': %.3f, ", number(d, 0.1, 0.4));
        else
            say(d, "'width': %.3f, 'height': %.3f, ", number(d, 0.1, 0.6), number(d, 0.1, 0.6));
        say_at(d);
        say(d, ", ");
        say_towards(d);
        break;
    case 5:
        say(d, "{'type': 'point', 'intensity': %.2f, ", number(d, 0.5, 2));
        say_at(d);
        d->no_size = true;
        break;
    default:
        say(d, "{'type': 'spot', 'intensity': %.2f, 'angle': %.1f, ", number(d, 1, 4), number(d, 20, 120));
        say_at(d);
        say(d, ", ");
        say_towards(d);
        d->no_size = true;
    }
    say(d, "}");
}

static void draw_scene(drawing *d, uint64_t key)
{
    *d = (drawing){.key = key};
    const int meshes = 1 + below(d, 4), lights = 1 + below(d, 3);
    say(d, "{'camera': {'position': [%.2f, 1.2, 4], 'target': [0, -0.05, 0], 'fov_y': 30, 'aspect': "
           "1.3333, 'views': 3, 'cone': %.1f}, ",
        number(d, -1, 1), number(d, 10, 50));
    say_meshes(d, meshes);
    say(d, ", 'materials': {'floor': ");
    say_material(d, false);
    for (int i = 0; i < meshes; i++) {
        char name[40];
        snprintf(name, sizeof name, "'m%dc': {'sh", i);
        const bool closed = strstr(d->text, name);
        say(d, ", 'm%d%s': ", i, closed ? "c" : "");
        say_material(d, closed);
    }
    say(d, "}, 'lights': {'l0': ");
    say_light(d);
    for (int i = 1; i < lights; i++) {
        say(d, ", 'l%d': ", i);
        say_light(d);
    }
    if (below(d, 3) == 0)
        say(d, ", 'sky': {'type': 'environment', 'radiance': %.3f}", number(d, 0.05, 0.5));
    say(d, "}, 'render': {'max_depth': %d}}", 2 + below(d, 5));
}

/* --------------------------------------------------------------------------------- comparing -- */

/* false: light paths do not serve the scene. */
static bool pictures(const char *text, const char *integrator, int paths, int cycles,
                     uint64_t salt, lf_blocks *out)
{
    lf_test_light_paths(paths);
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    const bool served = paths == 0 || lf_test_rows(r)->light.plan.per_pass == paths;
    lf_blocks_init(out, n_views, width, height, block);
    for (int k = 0; k < REPLICATES && served; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        lf_test_cycles(r, cycles);
        lf_blocks_add_picture(out, r, LF_ESTIMATOR_MIS);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return served;
}

typedef struct comparing {
    double p[COMPARISONS];
    int where[COMPARISONS];
    lf_blocks with, strong, alone, without;
    bool served;
} comparing;

static double least_p(const comparing *c)
{
    double least = 1.0;
    for (int i = 0; i < COMPARISONS; i++)
        least = fmin(least, c->p[i]);
    return least;
}

static void compare(const drawing *d, int times, uint64_t salt, comparing *c)
{
    const bool lonely = d->mirrors && d->no_size;
    *c = (comparing){.p = {1.0, 1.0, 1.0}};
    c->served = pictures(d->text, "mvpt", 150, 2 * times, salt + 1, &c->with);
    if (!c->served) {
        lf_blocks_finish(&c->with);
        return;
    }
    pictures(d->text, "mvpt", 1500, times, salt + 2, &c->strong);
    pictures(d->text, "vpt", 300, 4 * times, salt + 3, &c->alone);
    c->p[0] = lf_blocks_welch(&c->with, &c->strong, &c->where[0]);
    c->p[1] = lf_blocks_welch(&c->with, &c->alone, &c->where[1]);
    lf_blocks_init(&c->without, n_views, width, height, block);
    if (!lonely) {
        lf_blocks_finish(&c->without);
        pictures(d->text, "vpt", 0, 12 * times, salt + 4, &c->without);
        c->p[2] = lf_blocks_welch(&c->with, &c->without, &c->where[2]);
    }
}

static void finish(comparing *c)
{
    if (!c->served)
        return;
    lf_blocks_finish(&c->with);
    lf_blocks_finish(&c->strong);
    lf_blocks_finish(&c->alone);
    lf_blocks_finish(&c->without);
}

static void print_block(const char *name, const lf_blocks *b, int where)
{
    if (b->moments[where].n > 0)
        print_message("  %s %.6g +- %.2g", name, b->moments[where].mean,
                      lf_moments_error(&b->moments[where]));
}

static void print_all(const comparing *c)
{
    for (int i = 0; i < COMPARISONS; i++) {
        print_message("p %.2g at block %d:", c->p[i], c->where[i]);
        print_block("with", &c->with, c->where[i]);
        print_block("strong", &c->strong, c->where[i]);
        print_block("alone", &c->alone, c->where[i]);
        print_block("without", &c->without, c->where[i]);
        print_message("\n");
    }
}

static void random_scenes_are_alike_with_and_without(void **state)
{
    (void)state;
    const char *first = getenv("FIRST");
    const int n = lf_test_long() ? LONG_SCENES : CI_SCENES, start = first ? atoi(first) : 0;
    const double level = lf_sidak(LF_FALSE_ALARM, n * COMPARISONS * blocks_of_views);
    static drawing d;
    int served = 0, rejected = 0;
    for (int i = start; i < start + n; i++) {
        comparing c;
        draw_scene(&d, lf_hash64(0x72616e64, (uint64_t)i));
        compare(&d, 1, 100, &c);
        served += c.served;
        double p = least_p(&c);
        if (c.served && !(p > level)) {
            print_message("scene %d: p %.2g\n", i, p);
            print_all(&c);
            finish(&c);
            compare(&d, 8, 200, &c);
            p = least_p(&c);
            print_message("again: p %.2g\n", p);
            print_all(&c);
            if (!(p > level)) {
                rejected++;
                print_message("%s\n", d.text);
            }
        }
        finish(&c);
    }
    print_message("%d of %d scenes have light paths\n", served, n);
    assert_int_equal(rejected, 0);
    assert_true(2 * served > n);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_scenes_are_alike_with_and_without),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
