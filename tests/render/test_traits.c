/* What works with what. A scene of each trait is rendered by each integrator, and by paths in lanes
 * where they serve it: either the picture is right, or it is refused by name. Right is what vpt
 * has: Welch's test on blocks of 8 x 8 pixels of three views of 16 x 12 crops, replicates being
 * seeds. The test shows its power in every case: the same scene without the trait, which is what an
 * integrator would render that did not know it, is told from what it renders. That is the negative
 * control as well. A trait without a scene here fails. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "base/file.h"
#include "render/papers/papers.h"
#include "render/transport/lanes/lane_scene.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum {
    width = 16,
    height = 12,
    n_views = 3,
    side = 8,
    replicates = 10,
    passes = 4 * n_views,
    blocks_of_all = 4 * n_views + 1,
    most_integrators = 16
};

/* Of every trait, integrator and block. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, LF_N_TRAITS *most_integrators *blocks_of_all)

/* clang-format off */

/* Of a list the cameras are those of the track: rows and lists have the same pictures. */
#define TRACK "'target': [0, 0.1, 0], 'views': { 'track': { 'count': 3, 'length': 1.5 } }"
#define LIST                                                                                       \
    "'views': { 'list': [ { 'position': [-0.75, 0.6, 5], 'target': [-0.75, 0.1, 0] }, "            \
    "{ 'position': [0, 0.6, 5], 'target': [0, 0.1, 0] }, "                                         \
    "{ 'position': [0.75, 0.6, 5], 'target': [0.75, 0.1, 0] } ] }"

#define SKY "'sky': { 'type': 'environment', 'radiance': [0.4, 0.5, 0.7] }"
#define SUN SKY ", 'sun': { 'type': 'distant', 'direction': [0.5, -0.7, 0.5], 'irradiance': " \
    "2, 'angle': 8 }"
#define BEHIND SKY ", 'sun': { 'type': 'distant', 'direction': [0.2, -0.2, -1], 'irradiance': 6 }"
#define POINT(at, bright) \
    SKY ", 'lamp': { 'type': 'point', 'position': " at ", 'intensity': " bright " }"
#define RECTANGLE(seen) \
    SKY ", 'lamp': { 'type': 'rectangle', 'position': [0, 0.5, 0], 'direction': [0, -0.7, " \
    "0.7], 'radiance': 3, 'visible': " seen " }"

#define GROUND "'ground': { 'shape': 'quad', 'material': 'clay', 'transform': { 'scale': 4, " \
    "'translate': [0, -1, 0] } }"
#define BALL(of) GROUND ", 'ball': { 'shape': 'sphere', 'material': '" of "', 'transform': { " \
    "'scale': 0.7 } }"
#define CARD(of) GROUND ", 'card': { 'shape': 'quad', 'material': '" of "', 'transform': { " \
    "'rotate': [80, 0, 0], 'scale': 0.8 } }"
#define CATCHER(what) \
    "'ground': { 'shape': 'quad', 'material': 'glaze', 'catcher': " what ", 'transform': { " \
    "'scale': 4, 'translate': [0, -0.7, 0] } }, " \
    "'ball': { 'shape': 'sphere', 'material': 'clay', 'transform': { 'scale': 0.6 } }"
#define QUADS(of, more) \
    GROUND ", 'a': { 'shape': 'quad', 'material': '" of "', 'transform': { 'rotate': [180, " \
    "0, 0], 'scale': 0.6, 'translate': [0, 0.9, 0] } }" more

/* @m: a box, or where lanes are to serve it a grid of a box */
#define FOG(words) "'fog': { @m, 'albedo': 0.8" words " }"
#define GRID(words) "'block': { 'file': '@g'" words ", 'transform': { 'scale': 0.2, " \
    "'translate': [-0.7, -0.7, -0.7] } }"

/* Parts of a scene; NULL: nothing, of light the sky. */
typedef struct parts {
    const char *volumes, *meshes, *lights, *camera, *more;
} parts;

static const struct {
    lf_traits bits;
    parts with, without;
} rows[] = {
    {LF_TRAIT_SURFACES, {.meshes = GROUND}, {0}},
    {LF_TRAIT_INSTANCES,
     {.meshes = "'ball': { 'shape': 'sphere', 'material': 'clay', 'instances': [{ 'scale': "
    "0.4, 'translate': [-0.6, 0, 0] }, "
                "{ 'scale': 0.4, 'translate': [0.6, 0, 0] }] }"},
     {.meshes = BALL("clay")}},
    {LF_TRAIT_HIDDEN_MESHES, {.meshes = GROUND, .lights = RECTANGLE("false")},
    {.meshes = GROUND, .lights = RECTANGLE("true")}},
    {LF_TRAIT_VARYING | LF_TRAIT_VARYING_ALBEDO | LF_TRAIT_VERTEX_COLOURS,
     {.meshes = "'c': { 'file': '@c' }"}, {.meshes = "'c': { 'file': '@p' }"}},
    {LF_TRAIT_VARYING, {.meshes = BALL("brushed"), .lights = SUN}, {.meshes = BALL("metal"),
    .lights = SUN}},
    {LF_TRAIT_MIRRORS, {.meshes = BALL("mirror")}, {.meshes = BALL("whole")}},
    {LF_TRAIT_MIRRORS, {.meshes = CARD("tinted")}, {.meshes = GROUND}},
    {LF_TRAIT_VIEW_LOBES, {.meshes = BALL("glaze"), .lights = SUN}, {.meshes = BALL("clay"),
    .lights = SUN}},
    {LF_TRAIT_VIEW_LOBES, {.meshes = CARD("frosted")}, {.meshes = GROUND}},
    {LF_TRAIT_VIEW_LOBES, {.volumes = FOG(", 'g': -0.8"), .lights = BEHIND},
    {.volumes = FOG(""), .lights = BEHIND}},
    {LF_TRAIT_EMISSION, {.meshes = BALL("shining")}, {.meshes = BALL("clay")}},
    {LF_TRAIT_OVERLAPS,
     {.meshes = QUADS("lamp", ", 'b': { 'shape': 'quad', 'material': 'lamp', 'transform': { "
    "'scale': 0.6, 'translate': [0, 0.9, 0] } }")},
     {.meshes = QUADS("bright", "")}},
    {LF_TRAIT_ALPHA, {.meshes = CARD("half")}, {.meshes = CARD("whole")}},
    {LF_TRAIT_THIN_GLASS, {.meshes = CARD("sheet")}, {.meshes = GROUND}},
    {LF_TRAIT_ROUGH_GLASS, {.meshes = BALL("rough")}, {.meshes = BALL("whole")}},
    {LF_TRAIT_FILLED_GLASS, {.meshes = BALL("dark")}, {.meshes = BALL("clear")}},
    {LF_TRAIT_NESTED_GLASS,
     {.meshes = BALL("clear") ", 'in': { 'shape': 'sphere', 'material': 'water', "
    "'transform': { 'scale': 0.6 } }"},
     {.meshes = BALL("clear")}},
    {LF_TRAIT_SUBSURFACE, {.meshes = BALL("skin"), .lights = SUN}, {.meshes = BALL("stone"),
    .lights = SUN}},
    {LF_TRAIT_CATCHERS, {.meshes = CATCHER("true"), .more = ", 'backdrop': 0.8"},
    {.meshes = CATCHER("false"), .more = ", 'backdrop': 0.8"}},
    /* what they reflect is found beside the picture, whose integrator sees a catcher */
    {LF_TRAIT_REFLECTIONS, {.meshes = CATCHER("'reflection'"), .more = ", 'backdrop': 0.8"},
    {.meshes = CATCHER("false"), .more = ", 'backdrop': 0.8"}},
    {LF_TRAIT_MEDIA, {.volumes = GRID(", 'scale': 2, 'albedo': 0.8")}, {0}},
    {LF_TRAIT_HOMOGENEOUS_MEDIA, {.volumes = FOG("")}, {0}},
    {LF_TRAIT_NEAREST_VOXELS,
     {.volumes = GRID(", 'albedo': 0.1, 'scale': 50, 'interpolation': 'nearest'")},
     {.volumes = GRID(", 'albedo': 0.1, 'scale': 50")}},
    {LF_TRAIT_CHROMATIC_MEDIA, {.volumes = FOG(", 'sigma_t': [0.2, 0.6, 2]")},
    {.volumes = FOG(", 'sigma_t': 2")}},
    {LF_TRAIT_VARYING_MEDIA, {.volumes = GRID(", 'scale': 2, 'albedo': { 'grid': 'Cd' }")},
    {.volumes = GRID(", 'scale': 2, 'albedo': 0.1")}},
    {LF_TRAIT_TWO_LOBES,
     {.volumes = FOG(", 'g': 0.8, 'second_g': -0.8, 'second_share': 0.7"), .lights = BEHIND},
     {.volumes = FOG(", 'g': 0.8"), .lights = BEHIND}},
    {LF_TRAIT_VOLUME_EMISSION, {.volumes = FOG(", 'emission': @e")}, {.volumes = FOG("")}},
    {LF_TRAIT_SUNS, {.volumes = FOG(""), .lights = SUN}, {.volumes = FOG("")}},
    {LF_TRAIT_SKY_PICTURES, {.volumes = FOG(""), .lights = "'s': { 'type': 'studio' }"},
    {.volumes = FOG("")}},
    {LF_TRAIT_SKY_PICTURES, {.meshes = BALL("clay"), .lights = "'s': { 'type': 'studio' }"},
    {.meshes = BALL("clay")}},
    {LF_TRAIT_AREA_LIGHTS, {.volumes = FOG(""), .lights = POINT("[0.5, 2, 1]", "12")},
    {.volumes = FOG("")}},
    {LF_TRAIT_EQUIANGULAR, {.volumes = FOG(""), .lights = POINT("[0, 0, 0]", "6")},
    {.volumes = FOG("")}},
    {LF_TRAIT_BACKDROP, {.volumes = FOG(""), .more = ", 'backdrop': 1.5"}, {.volumes = FOG("")}},
    {LF_TRAIT_MOTION,
     {.meshes = GROUND ", 'ball': { 'shape': 'sphere', 'material': 'whole', 'transform': { "
    "'scale': 0.5, 'translate': "
                "{ 'keys': [[1, [-0.5, 0, 0]], [2, [0.9, 0, 0]]] } } }", .camera = ", "
    "'shutter': 1"},
     {.meshes = GROUND ", 'ball': { 'shape': 'sphere', 'material': 'whole', 'transform': { "
    "'scale': 0.5, 'translate': [-0.5, 0, 0] } }"}},
    {LF_TRAIT_LENS, {.volumes = FOG(""), .camera = ", 'lens_radius': 1, 'focus_distance': "
    "1.5"}, {.volumes = FOG("")}},
    {LF_TRAIT_VIEW_BLUR, {.volumes = FOG(""), .camera = ", 'view_blur': 4"}, {.volumes = FOG("")}},
    {LF_TRAIT_LENS | LF_TRAIT_BACKDROP, {.meshes = BALL("clay"), .camera = ", 'lens_radius': 1, "
    "'focus_distance': 1.5", .more = ", 'backdrop': 1.5"}, {.meshes = BALL("clay")}},
    {LF_TRAIT_VIEW_BLUR, {.meshes = BALL("clay"), .camera = ", 'view_blur': 4"},
    {.meshes = BALL("clay")}},
    {LF_TRAIT_LISTED_CAMERAS, {.volumes = FOG("")}, {.volumes = FOG(""), .camera = ", "
    "'fov_y': 30"}},
    {LF_TRAIT_FEATURES, {.volumes = FOG("")}, {0}},
};
/* clang-format on */
#define N_ROWS (int)(sizeof rows / sizeof rows[0])

/* ------------------------------------------------------------------------------------ scenes -- */

static char folder_of[PATH_MAX];

/* A card whose vertices have colours, and one that is as grey as those are bright in the mean. */
static void write_cards(const char *folder)
{
    static const char *const names[] = {"coloured.ply", "plain.ply"};
    for (int i = 0; i < 2; i++) {
        char text[1024];
        const char *colours = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
        const char *c[] = {" 250 20 20", " 20 20 20", " 20 20 250", " 250 250 20"};
        snprintf(text, sizeof text,
                 "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                 "property float z\n%selement face 1\nproperty list uchar int vertex_indices\n"
                 "end_header\n-1 -1 0%s\n1 -1 0%s\n1 1 0%s\n-1 1 0%s\n4 0 1 2 3\n",
                 i ? "" : colours, i ? "" : c[0], i ? "" : c[1], i ? "" : c[2], i ? "" : c[3]);
        lf_test_write(folder, names[i], text);
    }
    snprintf(folder_of, sizeof folder_of, "%s", folder);
}

/* What stands for @g, @c, @p, @m and @e: names of files, the medium and its emission. */
static void expand(char mark, bool grid, char *out, size_t size)
{
    char file[PATH_MAX];
    assert_non_null(realpath(lf_test_built("testdata/colours.vdb"), file));
    if (mark == 'm' && grid)
        snprintf(out, size,
                 "'file': '%s', 'scale': 1.5, 'transform': { 'scale': 0.18, "
                 "'translate': [-0.63, -0.63, -0.63] }",
                 file);
    else if (mark == 'm')
        snprintf(out, size, "'shape': 'box', 'density': 1.5, 'transform': { 'scale': 0.7 }");
    else
        snprintf(out, size, "%s",
                 mark == 'g'           ? file
                 : mark == 'c'         ? "coloured.ply"
                 : mark == 'p'         ? "plain.ply"
                 : mark == 'e' && grid ? "{ 'grid': 'density' }"
                                       : "0.5");
}

static void fill(const char *text, bool grid, char *out, size_t size)
{
    size_t n = 0;
    for (; *text && n + 1 < size; text++)
        if (*text == '@') {
            expand(*++text, grid, out + n, size - n);
            n += strlen(out + n);
        } else
            out[n++] = *text;
    assert_true(n + 1 < size);
    out[n] = '\0';
}

static const char *given(const char *text, const char *other)
{
    return text ? text : other;
}

/* What a scene is made of besides its parts. */
typedef struct setting {
    bool listed, grid; /* its cameras, its medium */
} setting;

static const char *text_of(const parts *p, setting in)
{
    char patch[8192], filled[16384];
    snprintf(patch, sizeof patch,
             "{ 'camera': { %s%s }, 'volumes': { %s }, 'meshes': { %s }, 'lights': { %s }%s }",
             in.listed ? LIST : TRACK, given(p->camera, ""), given(p->volumes, ""),
             given(p->meshes, ""), given(p->lights, SKY), given(p->more, ""));
    fill(patch, in.grid, filled, sizeof filled);
    return lf_test_scene_patched("traits", "%s", filled);
}

static lf_scene *scene_of(const parts *p, setting in)
{
    return lf_test_scene_in(folder_of, text_of(p, in), NULL);
}

/* ---------------------------------------------------------------------------------- pictures -- */

static lf_render_settings settings_of(const lf_scene *scene, const char *name, lf_traits bit)
{
    return (lf_render_settings){.skip = LF_SKIP_ALL,
                                .camera = *lf_scene_camera(scene),
                                .width = width,
                                .height = height,
                                .integrator = name,
                                .features = bit == LF_TRAIT_FEATURES};
}

static lf_pool *pool;

/* NULL: it is refused, *err says how. */
static lf_renderer *renderer_of(lf_scene *scene, const lf_render_settings *settings, lf_error *err)
{
    lf_renderer *r = NULL;
    const lf_status status = lf_renderer_create(scene, settings, pool, &r, err);
    assert_true(status == LF_OK || status == LF_E_ARG);
    return r;
}

/* The answer that is right: N/n, but of those whose weights are of views that they have selected,
 * which are right as N/W alone. */
static lf_estimator answer_of(const lf_renderer *r)
{
    const char *name = lf_renderer_settings(r)->integrator;
    const bool selects = lf_integrator_named(name)->takes & LF_PAPERS_TAKES(SELECTION);
    return selects ? LF_ESTIMATOR_MWIS : LF_ESTIMATOR_MIS;
}

/* Blocks of replicates; salt keeps their seeds from others'. */
static void render(lf_renderer *r, uint64_t salt, lf_blocks *out)
{
    lf_blocks_init(out, n_views, width, height, side);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        lf_test_passes(r, passes);
        lf_blocks_add_picture(out, r, answer_of(r));
    }
}

/* By vpt, path by path. */
static void reference(const parts *p, setting in, uint64_t salt, lf_blocks *out)
{
    lf_scene *scene = scene_of(p, in);
    lf_render_settings settings = settings_of(scene, "vpt", 0);
    settings.skip &= ~(unsigned)LF_SKIP_PATHS;
    lf_error err = {0};
    lf_renderer *r = renderer_of(scene, &settings, &err);
    if (!r)
        fail_msg("%s", err.what);
    render(r, salt, out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* What all pictures of a row are compared with. */
typedef struct truth {
    lf_blocks with, without;
    const char *trait;
    double weakest; /* the greatest p of a picture that has the trait against one without it */
} truth;

/* "amv2019k" is biased, as its paper has it: its picture is only nearer to the right one than to
 * that without the trait. */
static void assert_right(const lf_blocks *seen, truth *t, const char *who)
{
    int where = 0;
    const double p = lf_blocks_welch(seen, &t->with, &where),
                 ignored = lf_blocks_welch(seen, &t->without, NULL);
    const lf_moments *a = &seen->moments[where], *b = &t->with.moments[where];
    if (strcmp(who, "amv2019k") != 0 && !(p > LEVEL))
        fail_msg("%s by %s: block %d: %.5g +- %.2g, by vpt %.5g +- %.2g, p %.2g"
                 "\n",
                 t->trait, who, where, a->mean, lf_moments_error(a), b->mean, lf_moments_error(b),
                 p);
    t->weakest = fmax(t->weakest, ignored);
    if (!(ignored < LEVEL))
        fail_msg("%s by %s: without it the picture would be the same, p %.2g"
                 "\n",
                 t->trait, who, ignored);
}

/* ------------------------------------------------------------------------------------- tests -- */

static void assert_refused(const lf_error *err, const char *who, lf_traits missing,
                           const char *trait)
{
    char words[512] = "";
    assert_true(lf_traits_missing(missing, 0, who, words, sizeof words));
    if (strncmp(err->what, words, strlen(words)) != 0)
        fail_msg("%s: \"%s\" does not begin with \"%s\"", trait, err->what, words);
}

static bool is_list(int row)
{
    return rows[row].bits == LF_TRAIT_LISTED_CAMERAS;
}

static void assert_not_read(const parts *p, setting in, const char *pointer)
{
    lf_test_assert_refused(folder_of, text_of(p, in), pointer, "");
}

/* What each integrator has rendered. */
static lf_traits rendered_by[most_integrators];

/* Renders it where it is supported, and looks at the error where it is not. */
static bool hold(int row, int n, const lf_integrator_entry *entry, bool listed, truth *t)
{
    lf_scene *scene = scene_of(&rows[row].with, (setting){.listed = listed || is_list(row)});
    const lf_render_settings settings = settings_of(scene, entry->name, rows[row].bits);
    const lf_traits has = scene->traits | lf_view_traits(&settings);
    const bool view = rows[row].bits == LF_TRAIT_FEATURES;
    char who[80];
    lf_error err = {0};
    lf_blocks seen = {0};
    lf_renderer *r = renderer_of(scene, &settings, &err);
    const lf_integrator *taken;
    int index;
    lf_assert_ok(lf_integrator_find(&settings, &taken, &index, &err), &err);
    entry = taken->entry(index); /* of a list another one of that name */
    assert_true((has & rows[row].bits) == rows[row].bits);
    if (!!r != !(has & ~entry->supports))
        fail_msg("%s by %s: %s", t->trait, entry->name, r ? "rendered" : err.what);
    snprintf(who, sizeof who, "%s%s", entry->name,
             settings.camera.list ? " with cameras listed one by one" : "");
    if (!r)
        assert_refused(&err, who, has & ~entry->supports, t->trait);
    if (r && view)
        assert_true(lf_film_at(&r->film, 0, 0).feature);
    if (r) {
        render(r, 3, &seen);
        assert_right(&seen, t, entry->name);
        rendered_by[n] |= settings.camera.list && !listed ? 0 : has;
        lf_blocks_finish(&seen);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return r;
}

/* The first of them. */
static const char *name_of(lf_traits bits)
{
    int i = 0;
    while (!(lf_trait_at(i)->bit & bits))
        i++;
    return lf_trait_at(i)->name;
}

static void every_trait_is_rendered_right_or_refused(void **state)
{
    (void)state;
    for (int row = 0; row < N_ROWS; row++) {
        truth t = {.trait = name_of(rows[row].bits)};
        int rendered = 0, n = 0;
        bool listed;
        reference(&rows[row].with, (setting){0}, 1, &t.with);
        reference(&rows[row].without, (setting){0}, 2, &t.without);
        for (const lf_integrator_entry *entry; (entry = lf_support_at(n, &listed)); n++)
            if (listed && rows[row].bits == LF_TRAIT_VIEW_BLUR)
                assert_not_read(&rows[row].with, (setting){.listed = true}, "/camera/view_blur");
            else
                rendered += hold(row, n, entry, listed, &t);
        print_message("%s: rendered by %d of %d, told from its absence at p < %.1g\n", t.trait,
                      rendered, n, t.weakest);
        assert_true(rendered > 0 && n <= most_integrators);
        lf_blocks_finish(&t.with);
        lf_blocks_finish(&t.without);
    }
}

/* After the test above. */
static void nothing_is_supported_that_was_not_rendered(void **state)
{
    (void)state;
    bool listed;
    char words[512];
    for (int n = 0; lf_support_at(n, &listed); n++)
        if (lf_traits_missing(lf_support_at(n, &listed)->supports, rendered_by[n],
                              lf_support_at(n, &listed)->name, words, sizeof words))
            fail_msg("never rendered: %s", words);
}

/* The row's scene, with a medium of one grid where it has none. */
static parts with_grid(const parts *p)
{
    parts out = *p;
    out.volumes = given(p->volumes, FOG(""));
    return out;
}

/* Lanes draw the suffixes of pivots in media alone: they are held to what vpt is without them. */
static void lanes_serve_what_they_support(void **state)
{
    (void)state;
    lf_traits seen_before = 0;
    for (int row = 0; row < N_ROWS; row++) {
        if (!(rows[row].bits & ~seen_before))
            continue;
        seen_before |= rows[row].bits;
        const parts with = with_grid(&rows[row].with),
                    without =
                        rows[row].with.volumes ? rows[row].without : with_grid(&rows[row].without);
        truth t = {.trait = name_of(rows[row].bits)};
        const setting in = {.listed = is_list(row),
                            .grid = rows[row].bits != LF_TRAIT_HOMOGENEOUS_MEDIA};
        lf_scene *scene = scene_of(&with, in);
        const bool serves = !(scene->traits & ~LF_LANES_SUPPORT);
        const lf_render_settings settings = settings_of(scene, "mvpt", rows[row].bits);
        const lf_traits has = scene->traits | lf_view_traits(&settings);
        lf_error err = {0};
        lf_blocks seen;
        print_message("%s: %s lanes\n", t.trait, serves ? "in" : "not in");
        assert_true((has & rows[row].bits) == rows[row].bits);
        assert_true(lf_lane_scene_serves(scene) == serves);
        if (serves) {
            lf_renderer *r = renderer_of(scene, &settings, &err);
            reference(&with, in, 4, &t.with);
            reference(&without, in, 5, &t.without);
            assert_non_null(r->lanes);
            render(r, 6, &seen);
            assert_right(&seen, &t, "lanes");
            lf_renderer_destroy(r);
            lf_blocks_finish(&seen);
            lf_blocks_finish(&t.with);
            lf_blocks_finish(&t.without);
        }
        lf_scene_unref(scene);
    }
}

static void every_trait_has_a_scene_that_has_it(void **state)
{
    (void)state;
    lf_traits seen = 0, all = 0;
    for (int i = 0; lf_trait_at(i); i++) {
        assert_true(lf_trait_at(i)->bit == LF_TRAIT(i));
        all |= lf_trait_at(i)->bit;
    }
    for (int row = 0; row < N_ROWS; row++) {
        lf_scene *with = scene_of(&rows[row].with, (setting){.listed = is_list(row)}),
                 *without = scene_of(&rows[row].without, (setting){0});
        const lf_render_settings a = settings_of(with, "vpt", rows[row].bits),
                                 b = settings_of(without, "vpt", 0);
        if (~(with->traits | lf_view_traits(&a)) & rows[row].bits ||
            (without->traits | lf_view_traits(&b)) & rows[row].bits)
            fail_msg("%s: not what parts the two scenes", name_of(rows[row].bits));
        seen |= rows[row].bits;
        lf_scene_unref(with);
        lf_scene_unref(without);
    }
    for (int i = 0; lf_trait_at(i); i++)
        if (!(seen & lf_trait_at(i)->bit))
            fail_msg("%s: no scene has it", lf_trait_at(i)->name);
    assert_true(seen == all);
}

/* ------------------------------------------------------------------------------------ manual -- */

/* A column of the table: those beside each other that support the same. */
static int end_of_column(int first)
{
    bool listed, next_listed;
    const lf_integrator_entry *entry = lf_support_at(first, &listed), *next;
    int i = first + 1;
    while ((next = lf_support_at(i, &next_listed)) && next->supports == entry->supports &&
           next_listed == listed)
        i++;
    return i;
}

static void add(char *text, size_t size, const char *words)
{
    assert_true(strlen(text) + strlen(words) < size);
    strcat(text, words);
}

static void add_head(char *text, size_t size)
{
    bool listed;
    add(text, size, "| |");
    for (int i = 0; lf_support_at(i, &listed); i = end_of_column(i)) {
        const int end = end_of_column(i);
        for (int k = i; k < end; k++) {
            add(text, size, k > i ? ", `" : " `");
            add(text, size, lf_support_at(k, &listed)->name);
            add(text, size, "`");
        }
        add(text, size, listed ? " of listed cameras |" : " |");
    }
    add(text, size, " lanes |\n|---|");
    for (int i = 0; lf_support_at(i, &listed); i = end_of_column(i))
        add(text, size, "---|");
    add(text, size, "---|\n");
}

static void the_table_of_the_manual_is_that_of_the_masks(void **state)
{
    (void)state;
    char table[8192] = "", *page = NULL;
    size_t n = 0;
    bool listed;
    lf_error err = {0};
    add_head(table, sizeof table);
    for (int t = 0; lf_trait_at(t); t++) {
        add(table, sizeof table, "| ");
        add(table, sizeof table, lf_trait_at(t)->name);
        add(table, sizeof table, " |");
        for (int i = 0; lf_support_at(i, &listed); i = end_of_column(i))
            add(table, sizeof table,
                lf_support_at(i, &listed)->supports & lf_trait_at(t)->bit ? " yes |" : " |");
        add(table, sizeof table, lf_trait_at(t)->bit & LF_LANES_SUPPORT ? " yes |\n" : " |\n");
    }
    lf_assert_ok(
        lf_file_read(lf_test_source("docs/developer/traits.md"), NULL, 1 << 20, &page, &n, &err),
        &err);
    if (!strstr(page, table)) {
        fputs(table, stdout);
        fail_msg("docs/developer/traits.md has another table than this");
    }
    lf_free(page);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_trait_has_a_scene_that_has_it),
        cmocka_unit_test(every_trait_is_rendered_right_or_refused),
        cmocka_unit_test(nothing_is_supported_that_was_not_rendered),
        cmocka_unit_test(lanes_serve_what_they_support),
        cmocka_unit_test(the_table_of_the_manual_is_that_of_the_masks),
    };
    char *folder = lf_test_folder();
    lf_papers_add();
    write_cards(folder);
    assert_int_equal(lf_pool_create(2, &pool), LF_OK);
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    lf_pool_destroy(pool);
    lf_test_folder_remove(folder);
    return failed;
}
