/* A small scene of numbers, kinds and maps that the bytes choose, of which each is one that a file
 * may say, or little beside it: it is refused with a word, or rendered, and every pixel is then
 * finite. No file is read. */
#include "tests/fuzz/fuzz.h"

#include <math.h>

#include "render/renderer.h"

enum { WIDTH = 3, HEIGHT = 2, MOST_VIEWS = 3, MOST_PIXELS = 3 * WIDTH * HEIGHT * MOST_VIEWS * 2 };

/* --------------------------------------------------------------------------------- the bytes -- */

/* Behind the end there are zeros. */
typedef struct bytes {
    const uint8_t *at, *end;
} bytes;

static unsigned next(bytes *b)
{
    return b->at < b->end ? *b->at++ : 0;
}

static unsigned choose(bytes *b, unsigned n)
{
    return next(b) % n;
}

/* Mostly what scenes say, sometimes what is at the edge of what they may. */
static double number(bytes *b)
{
    static const double sizes[] = {0,    0.1,  0.5,  0.7,   1,     1,     2,     3,
                                   5,    8,    100,  1e-3,  1e3,   1e-6,  1e6,   1e-9,
                                   1e9,  1e9,  3e8,  1e-12, 1e-13, 1e-15, 1e-18, 1e-20,
                                   1e-7, 1e-8, 1e-4, 1e-30, 1e-45, 1,     0,     1e-300};
    const unsigned byte = next(b);
    const double size = sizes[byte % (sizeof sizes / sizeof *sizes)];
    return byte & 0x80 ? -size : size;
}

/* One that a length may be. */
static double length(bytes *b)
{
    return fmax(fabs(number(b)), 1e-9);
}

static json_t *point(bytes *b)
{
    const double x = number(b), y = number(b), z = number(b);
    return json_pack("[fff]", x, y, z);
}

static json_t *angles(bytes *b)
{
    const int x = (int)next(b) * 14, y = (int)next(b), z = (int)choose(b, 4) * 90;
    return json_pack("[iii]", x, y, z);
}

/* One of them, now and then as it moves from frame 1 to frame 2. */
static json_t *moving(bytes *b, json_t *(*make)(bytes *b), bool may)
{
    json_t *first = make(b);
    if (!may || choose(b, 8) != 7)
        return first;
    json_t *second = make(b);
    return json_pack("{s: [[i, o], [i, o]]}", "keys", 1, first, 2, second);
}

static void set(json_t *object, const char *key, json_t *value)
{
    lf_fuzz_require(json_object_set_new(object, key, value) == 0);
}

/* -------------------------------------------------------------------------------------- maps -- */

static json_t *rows(bytes *b, unsigned n)
{
    json_t *m = json_array();
    for (unsigned i = 0; i < n; i++)
        json_array_append_new(m, json_real(i < 12 ? number(b) : i == 15));
    return m;
}

static json_t *map(bytes *b, bool may_move)
{
    const unsigned what = next(b);
    if (what % 4 == 3)
        return json_pack("{s: o}", "matrix", rows(b, 16));
    json_t *t = json_object();
    if (what & 4)
        set(t, "scale", moving(b, point, may_move));
    if (what & 8)
        set(t, "translate", moving(b, point, may_move));
    if (what & 16)
        set(t, "rotate", moving(b, angles, may_move));
    return t;
}

static json_t *places(bytes *b)
{
    json_t *list = json_array();
    for (unsigned n = 1 + choose(b, 3); n > 0; n--)
        json_array_append_new(list, choose(b, 2) ? map(b, false) : rows(b, 12));
    return list;
}

/* ------------------------------------------------------------------------------------ things -- */

static json_t *mesh(bytes *b)
{
    static const char *const shapes[] = {"quad", "cube", "sphere", "disk"}, *const materials[] = {
                                                                                "clay", "glass",
                                                                                "lamp", "metal",
                                                                                "skin"};
    json_t *out = json_pack("{s: s, s: s}", "shape", shapes[choose(b, 4)], "material",
                            materials[choose(b, 5)]);
    const unsigned what = next(b);
    if (what & 1)
        set(out, "transform", map(b, true));
    if (what & 2)
        set(out, "instances", places(b));
    if (what % 16 == 12)
        set(out, "catcher", json_true());
    return out;
}

static json_t *volume(bytes *b)
{
    json_t *out = json_pack("{s: s, s: f, s: o}", "shape", choose(b, 2) ? "box" : "sphere",
                            "density", length(b), "transform", map(b, true));
    const unsigned what = next(b);
    if (what & 1)
        set(out, "emission", json_real(length(b)));
    else if (what & 2)
        set(out, "sigma_t", json_pack("[fff]", 1.0, 0.5, 0.1));
    return out;
}

static json_t *light(bytes *b)
{
    static const char *const kinds[] = {"environment", "distant", "point", "spot",
                                        "rectangle",   "disk",    "sphere"};
    static const char *const lengths[] = {NULL, NULL, NULL, NULL, "width", "radius", "radius"};
    const unsigned kind = choose(b, 7);
    json_t *out = json_pack("{s: s}", "type", kinds[kind]);
    if (kind >= 2)
        set(out, "position", moving(b, point, true));
    if (kind == 1 || (kind >= 3 && kind != 6))
        set(out, "direction", point(b));
    if (lengths[kind])
        set(out, lengths[kind], json_real(length(b)));
    if (kind == 0 || kind >= 4)
        set(out, "radiance", json_real(1));
    return out;
}

/* ------------------------------------------------------------------------------------ camera -- */

static json_t *view(bytes *b)
{
    return json_pack("{s: o, s: o}", "position", point(b), "target", point(b));
}

static json_t *views(bytes *b)
{
    switch (choose(b, 8)) {
    case 0:
        return json_pack("{s: {s: i, s: f, s: s}}", "track", "count", 2, "length", length(b),
                         "window", choose(b, 2) ? "own" : "shared");
    case 1:
        return json_pack("{s: {s: i, s: i, s: f, s: f}}", "grid", "columns", 2, "rows", 2, "width",
                         length(b), "height", length(b));
    case 2:
        return json_pack("{s: [o, o]}", "list", view(b), view(b));
    case 3:
        return json_pack("{s: {s: i, s: [o, o, o]}}", "path", "count", 3, "through", view(b),
                         view(b), view(b));
    case 4:
        return json_pack("{s: {s: i, s: i}}", "circle", "count", 2, "angle", (int)(1 + next(b)));
    default:
        return json_integer(2);
    }
}

static json_t *camera(bytes *b)
{
    json_t *out = json_pack("{s: o}", "views", views(b));
    const unsigned what = next(b), lens = next(b);
    set(out, "position", what & 1 ? moving(b, point, true) : json_pack("[iii]", 0, 0, 8));
    if (what & 2)
        set(out, "target", moving(b, point, true));
    if (lens & 8)
        set(out, "up", point(b));
    set(out, "fov_y", json_real(what & 8 ? 0.1 : what & 16 ? 160 : 30));
    set(out, "cone", json_real(what & 32 ? 160 : 40));
    set(out, "aspect", json_real(what & 64 ? 20 : 1));
    if (what & 128)
        set(out, "shutter", json_integer(1));
    if ((lens & 3) == 3)
        set(out, "view_blur", json_integer(1));
    else if (lens & 1)
        set(out, "lens_radius", json_real(length(b)));
    if (lens & 4)
        set(out, "focus_distance", json_real(length(b)));
    return out;
}

/* --------------------------------------------------------------------------------- the scene -- */

static json_t *things(bytes *b, unsigned n, json_t *(*make)(bytes *b))
{
    static const char *const names[] = {"a", "b", "c"};
    json_t *out = json_object();
    for (unsigned i = 0; i < n; i++)
        set(out, names[i], make(b));
    return out;
}

static json_t *document(bytes *b)
{
    static const char materials[] =
        "{\"clay\": {}, \"lamp\": {\"emission\": 3}, \"metal\": {\"type\": \"conductor\"},"
        " \"glass\": {\"type\": \"principled\", \"transmission\": 1, \"roughness\": 0},"
        " \"skin\": {\"type\": \"principled\", \"subsurface\": 1, \"coat\": 1}}";
    const unsigned n_meshes = choose(b, 4), n_volumes = choose(b, 2), n_lights = choose(b, 3);
    json_t *out = json_pack("{s: {s: i}}", "render", "max_depth", 5);
    set(out, "camera", camera(b));
    set(out, "meshes", things(b, n_meshes, mesh));
    set(out, "volumes", things(b, n_volumes, volume));
    set(out, "lights", things(b, n_lights, light));
    json_object_set_new(json_object_get(out, "lights"), "sky",
                        json_pack("{s: s, s: i}", "type", "environment", "radiance", 1));
    set(out, "materials", json_loads(materials, 0, NULL));
    return out;
}

/* --------------------------------------------------------------------------------- rendering -- */

static void look_at(const lf_renderer *renderer, int n_pixels)
{
    float picture[MOST_PIXELS];
    for (lf_estimator e = LF_ESTIMATOR_MWIS; e <= LF_ESTIMATOR_CV; e++) {
        if (lf_renderer_resolve(renderer, e, picture, NULL) != LF_OK)
            return;
        for (int i = 0; i < 3 * n_pixels; i++)
            lf_fuzz_require(isfinite(picture[i]));
    }
}

static void render(lf_scene *scene, const char *integrator, lf_pool *pool)
{
    lf_render_settings settings = {.camera = *lf_scene_camera(scene),
                                   .width = WIDTH,
                                   .height = HEIGHT,
                                   .integrator = integrator,
                                   .skip = LF_SKIP_ALL};
    lf_renderer *renderer = NULL;
    lf_error err = {0};
    if (settings.camera.n_rows > 0)
        settings.camera = lf_camera_row(&settings.camera, settings.camera.n_rows - 1);
    lf_status status = lf_renderer_create(scene, &settings, pool, &renderer, &err);
    lf_fuzz_require(status == LF_OK || err.what[0] != 0);
    if (status == LF_OK && lf_renderer_passes(renderer, NULL, 2, true, NULL, NULL, NULL) == LF_OK)
        look_at(renderer, WIDTH * HEIGHT * settings.camera.n_views);
    lf_renderer_destroy(renderer);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static lf_pool *pool;
    bytes b = {data, data + size};
    lf_error err = {0};
    lf_scene *scene = NULL;
    const bool alone = choose(&b, 4) == 3;
    json_t *doc = document(&b);
    lf_fuzz_require(pool || lf_pool_create(1, &pool) == LF_OK);
    if (lf_scene_from_json(doc, "/", "fuzz", NULL, NULL, &scene, &err) == LF_OK) {
        render(scene, alone ? "vpt" : "mvpt", pool);
    } else {
        lf_fuzz_require(err.what[0] != 0);
        lf_fuzz_require_text(err.what);
    }
    lf_scene_unref(scene);
    json_decref(doc);
    return 0;
}
