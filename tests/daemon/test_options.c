/* The shared command line: what is taken, what is refused and with which words, and which source of
 * a value wins. */
#include "tests/testing.h"

#include "daemon/output/options.h"

static const char shared[] = LF_OPTIONS_VIEWS " " LF_OPTIONS_RENDER " target-error panel fit";
static const struct option table[] = {
    {"own", required_argument, NULL, LF_OPTION_OWN},
    {NULL, 0, NULL, 0},
};

/* What was handed to the program itself. */
typedef struct own {
    int n, last_code, n_taken;
    const char *last;
    bool done;
    int helps;
} own;

static own got;

static void count_help(void)
{
    got.helps++;
}

static lf_status take_own(void *context, int code, const char *text, lf_error *err)
{
    own *o = context;
    if (text && strcmp(text, "bad") == 0)
        return lf_error_set(err, LF_E_ARG, "--own", "is bad");
    o->n++;
    o->last_code = code;
    o->last = text;
    return LF_OK;
}

static void count_taken(void *context, const lf_param *params, const lf_param *row)
{
    own *o = context;
    o->n_taken++;
    assert_ptr_equal(params, lf_option_params);
    assert_true(lf_param_among(row, shared));
}

/* Reads a whole command line (words parted by blanks); the first status that is not LF_OK. */
static lf_status read_line(const char *text, lf_options *options, lf_error *err)
{
    static char copy[1024];
    char *argv[32] = {(char[]){"program"}};
    const lf_options_part parts[] = {{lf_option_params, shared, options}, {0}};
    const lf_options_rules rules = {.program = "program",
                                    .letters = ":o:",
                                    .parts = parts,
                                    .table = table,
                                    .print_help = count_help,
                                    .take = take_own,
                                    .taken = count_taken,
                                    .context = &got};
    int argc = 1;
    *options = (lf_options){0};
    *err = (lf_error){0};
    got = (own){0};
    snprintf(copy, sizeof copy, "%s", text);
    for (char *word = strtok(copy, " "); word && argc < 31; word = strtok(NULL, " "))
        argv[argc++] = word;
    optind = 0; /* GNU: start over */
    return lf_options_read(argc, argv, &rules, &got.done, err);
}

static void options_of_the_program_itself_are_handed_to_it_until_one_is_bad(void **state)
{
    lf_options o;
    lf_error err;
    (void)state;
    lf_assert_ok(read_line("--own one --views 7 -o two operand", &o, &err), &err);
    assert_int_equal(got.n, 2);
    assert_int_equal(got.last_code, 'o');
    assert_string_equal(got.last, "two");
    assert_int_equal(got.n_taken, 1);
    assert_int_equal(o.views, 7);
    assert_false(got.done);
    assert_int_equal(optind, 7); /* the operand */
    lf_assert_status(read_line("--own bad --own behind", &o, &err), LF_E_ARG, &err);
    assert_string_equal(err.what, "is bad");
    assert_int_equal(got.n, 0);
}

/* What looks like a file is an operand. */
static void a_name_may_stand_behind_fit(void **state)
{
    static const struct {
        const char *line, *name;
    } cases[] = {
        {"a.json --fit", NULL},      {"--fit a.json", NULL},
        {"--fit folder/a", NULL},    {"--fit cow a.json", "cow"},
        {"a.json --fit cow", "cow"}, {"a.json --fit --views 7", NULL},
        {"--fit=a.b a.json", "a.b"}, {"a.json b.json --fit cow --views 7", "cow"},
    };
    lf_options o;
    lf_error err;
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_assert_ok(read_line(cases[i].line, &o, &err), &err);
        assert_true(o.fit.on);
        if (cases[i].name)
            assert_string_equal(o.fit.name, cases[i].name);
        else
            assert_null(o.fit.name);
    }
    lf_assert_ok(read_line("a.json cow", &o, &err), &err);
    assert_false(o.fit.on);
}

static void nothing_is_read_behind_help_and_version(void **state)
{
    lf_options o;
    lf_error err;
    (void)state;
    lf_assert_ok(read_line("--views 7 --help --own bad --unknown", &o, &err), &err);
    assert_true(got.done);
    assert_int_equal(got.helps, 1);
    assert_int_equal(o.views, 7);
    lf_assert_ok(read_line("--version --unknown", &o, &err), &err);
    assert_true(got.done);
    assert_int_equal(got.helps, 0);
    lf_assert_status(read_line("--unknown --help", &o, &err), LF_E_ARG, &err);
    assert_false(got.done);
}

static void every_shared_option_is_taken(void **state)
{
    lf_options o;
    lf_error err;
    (void)state;
    lf_assert_ok(read_line("--preset portrait --views 7 --quilt 8x6 --view-size 640x480 "
                           "--integrator vpt --estimator cv "
                           "--sampler independent --threads 3 --seed 18446744073709551615 "
                           "--max-depth 12 --skip none "
                           "--target-error 1e-3 --panel p.json operand",
                           &o, &err),
                 &err);
    assert_string_equal(o.preset, "portrait");
    assert_string_equal(lf_options_preset(&o)->name, "portrait");
    assert_int_equal(o.views, 7);
    assert_int_equal(o.columns, 8);
    assert_int_equal(o.rows, 6);
    assert_int_equal(o.view_width, 640);
    assert_int_equal(o.view_height, 480);
    assert_string_equal(o.integrator, "vpt");
    assert_true(o.has_estimator && o.estimator == LF_ESTIMATOR_CV);
    assert_true(o.sampler == LF_SAMPLER_INDEPENDENT);
    assert_int_equal(o.threads, 3);
    assert_true(o.seed == UINT64_MAX);
    assert_int_equal(o.max_depth, 12);
    assert_true(o.tracing.has_skip && o.tracing.skip == 0);
    lf_assert_close(o.target_error, 1e-3, 0, 0);
    assert_string_equal(o.calibration, "p.json");
    lf_assert_ok(read_line("", &o, &err), &err);
    assert_true(!o.preset && !o.views && !o.integrator && !o.tracing.has_skip && !o.has_estimator);
    assert_null(lf_options_preset(&o));
}

static void wrong_words_are_refused_with_the_option_and_what_it_expects(void **state)
{
    static const struct {
        const char *line, *where, *what;
    } cases[] = {
        {"--views 0", "--views", "from 1 to 256"},
        {"--views 257", "--views", "not \"257\""},
        {"--views 4x", "--views", "whole number"},
        {"--views 1e1", "--views", "whole number"},
        {"--views", "--views", "expects an argument"},
        {"--quilt 5", "--quilt", "CxR"},
        {"--quilt 0x5", "--quilt", "from 1 to 64"},
        {"--quilt 65x1", "--quilt", "65x1"},
        {"--view-size 10", "--view-size", "WxH"},
        {"--view-size 10.5x10", "--view-size", "whole number"},
        {"--view-size 0x10", "--view-size", "from 1"},
        {"--view-size 10x20000", "--view-size", "16384"},
        {"--view-size nanx10", "--view-size", "whole number"},
        {"--preset moon", "--preset", "kiosk or hld, not \"moon\""},
        {"--integrator bdpt", "--integrator", "mvpt"},
        {"--estimator best", "--estimator", "mwis, mis or cv"},
        {"--sampler halton", "--sampler", "owen or independent"},
        {"--threads -1", "--threads", "from 0 to 256"},
        {"--threads 1000", "--threads", "from 0 to 256"},
        {"--seed -1", "--seed", "from 0"},
        {"--seed 18446744073709551616", "--seed", "whole number"},
        {"--target-error 0", "--target-error", "number"},
        {"--target-error nan", "--target-error", "number"},
        {"--target-error inf", "--target-error", "number"},
        {"--target-error 0x1p-3", "--target-error", "number"},
        {"--max-depth 0", "--max-depth", "from 1"},
        {"--skip backgrund", "--skip", "all, none or some of surfaces, background"},
        {"--calibration c.json", "--calibration", "unknown option"}, /* not among shared */
        {"--colour red", "--colour", "unknown option"},
        {"--sede 3", "--sede", "did you mean --seed?"},
        {"--view-zise=3x4", "--view-zise=3x4", "did you mean --view-size?"},
        {"--view", "--view", "ambiguous"},
        {"--help=now", "--help", "takes no argument"},
        {"-z", "-z", "unknown option"},
        {"-o", "-o", "expects an argument"},
    };
    lf_options o;
    lf_error err;
    (void)state;

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        print_message("%s\n", cases[i].line);
        assert_int_equal(read_line(cases[i].line, &o, &err), LF_E_ARG);
        assert_string_equal(err.where, cases[i].where);
        assert_non_null(strstr(err.what, cases[i].what));
        assert_null(strchr(err.what, '\n'));
    }
}

static void pairs_and_numbers_read_what_was_typed(void **state)
{
    double pair[2] = {0};
    double x = 0;
    int64_t n = 0;
    lf_error err;
    (void)state;
    lf_assert_ok(lf_parse_pair("--print", "60.13@600", '@', 0, 1000, pair, &err), &err);
    lf_assert_close(pair[0], 60.13, 1e-15, 0);
    lf_assert_close(pair[1], 600, 0, 0);
    lf_assert_ok(lf_parse_pair("--print-size", "0x12.5", 'x', 0, 1000, pair, &err), &err);
    lf_assert_close(pair[1], 12.5, 0, 0);
    lf_assert_ok(lf_parse_double("--phase", "-1.25", -10, 10, &x, &err), &err);
    lf_assert_close(x, -1.25, 0, 0);
    lf_assert_ok(lf_parse_int("--n", "-7", -10, 10, &n, &err), &err);
    assert_int_equal(n, -7);
    assert_int_equal(lf_parse_pair("--print", "60.13@", '@', 0, 1000, pair, &err), LF_E_ARG);
    assert_int_equal(lf_parse_pair("--print", "60@600@2", '@', 0, 1000, pair, &err), LF_E_ARG);
    assert_int_equal(lf_parse_double("--phase", " 1", -10, 10, &x, &err), LF_E_ARG);
    assert_int_equal(lf_parse_double("--phase", "", -10, 10, &x, &err), LF_E_ARG);
}

/* -------------------------------------------------------------------------------- precedence -- */

static lf_camera scene_camera(void)
{
    return (lf_camera){.fov_y = 0.25,
                       .aspect = 1.25,
                       .n_views = 12,
                       .cone = 0.5,
                       .depthiness = 1,
                       .has_aspect = true,
                       .has_views = true,
                       .has_cone = true};
}

static lf_calibration panel(void)
{
    lf_calibration c;
    lf_calibration_portrait(&c);
    c.screen_width_px = 1000;
    c.screen_height_px = 500;
    c.view_cone_deg = 90;
    return c;
}

static void resolve(const char *line, const lf_camera *camera, const lf_calibration *calibration,
                    lf_render_settings *settings, lf_layout *layout)
{
    lf_options o;
    lf_error err;
    lf_assert_ok(read_line(line, &o, &err), &err);
    lf_assert_ok(lf_resolve_view(&o, camera, calibration, settings, layout, &err), &err);
    assert_int_equal(settings->width, layout->view_width);
    assert_int_equal(settings->height, layout->view_height);
    assert_int_equal(settings->camera.n_views, layout->n_views);
    lf_assert_close(settings->camera.aspect, layout->aspect, 0, 0);
    assert_true(layout->columns * layout->rows >= layout->n_views);
}

static void command_line_beats_preset_beats_panel_beats_scene(void **state)
{
    static const struct {
        const char *line;
        bool scene_says, with_panel; /* the scene states 12 views, aspect 1.25, cone 0.5 */
        int views, columns, rows, width, height;
        double aspect, cone;
    } cases[] = {
        {"", false, false, 45, 5, 9, 420, 560, 0.75, 0.7},
        {"", true, false, 12, 3, 4, 700, 560, 1.25, 0.5},
        {"", true, true, 12, 0, 0, 1120, 560, 2, M_PI / 2},
        {"--preset portrait", true, false, 48, 8, 6, 420, 560, 0.75, 0.5},
        {"--preset portrait", true, true, 48, 8, 6, 420, 560, 0.75, M_PI / 2},
        {"--preset portrait --views 45", true, true, 45, 5, 9, 420, 560, 0.75, M_PI / 2},
        {"--preset portrait --quilt 7x7", true, true, 48, 7, 7, 420, 560, 0.75, M_PI / 2},
        {"--preset portrait --view-size 100x200", true, true, 48, 8, 6, 100, 200, 0.75, M_PI / 2},
        {"--views 45", true, true, 45, 5, 9, 1120, 560, 2, M_PI / 2},
        {"--views 9 --quilt 3x3", true, false, 9, 3, 3, 700, 560, 1.25, 0.5},
        {"--quilt 4x4", true, false, 12, 4, 4, 700, 560, 1.25, 0.5},
        {"--view-size 64x48", true, false, 12, 0, 0, 64, 48, 1.25, 0.5},
        {"--view-size 64x48", false, false, 45, 5, 9, 64, 48, 64.0 / 48, 0.7},
    };
    (void)state;

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_camera camera = scene_camera();
        lf_calibration calibration = panel();
        lf_render_settings settings;
        lf_layout layout;
        if (!cases[i].scene_says)
            camera = (lf_camera){
                .fov_y = 0.25, .aspect = 0.75, .n_views = 45, .cone = 0.7, .depthiness = 1};
        print_message("case %zu: \"%s\"\n", i, cases[i].line);
        resolve(cases[i].line, &camera, cases[i].with_panel ? &calibration : NULL, &settings,
                &layout);
        assert_int_equal(layout.n_views, cases[i].views);
        if (cases[i].columns > 0) {
            assert_int_equal(layout.columns, cases[i].columns);
            assert_int_equal(layout.rows, cases[i].rows);
        }
        assert_int_equal(layout.view_width, cases[i].width);
        assert_int_equal(layout.view_height, cases[i].height);
        lf_assert_close(layout.aspect, cases[i].aspect, 1e-12, 0);
        lf_assert_close(settings.camera.cone, cases[i].cone, 1e-12, 0);
        lf_assert_close(settings.camera.fov_y, 0.25, 0, 0);
    }
}

/* A camera after lf_resolve_view, of this cone or track. */
static lf_camera resolved(double cone, double track, double depthiness,
                          const lf_calibration *calibration)
{
    lf_camera camera = scene_camera();
    lf_render_settings settings;
    lf_layout layout;
    camera.cone = cone;
    camera.track = track;
    camera.rows_height = track;
    camera.depthiness = depthiness;
    resolve("", &camera, calibration, &settings, &layout);
    return settings.camera;
}

static void depthiness_is_a_factor_of_the_cone_in_use(void **state)
{
    (void)state;
    const double rad = M_PI / 180;
    const lf_calibration of_panel = panel();
    const lf_camera half = resolved(40 * rad, 0, 0.5, NULL),
                    narrow = resolved(20 * rad, 0, 1, NULL);
    assert_memory_equal(&half, &narrow, sizeof half);
    /* a panel's cone is 90 degrees */
    lf_assert_close(resolved(40 * rad, 0, 0.5, &of_panel).cone, 45 * rad, 1e-12, 0);
    lf_assert_close(resolved(40 * rad, 3, 0.5, &of_panel).cone, 45 * rad, 1e-12, 0);
    lf_assert_close(resolved(40 * rad, 0, 0, &of_panel).cone, 0, 0, 0);
    lf_assert_close(resolved(40 * rad, 0, 2, NULL).cone, 80 * rad, 1e-12, 0);
    lf_assert_close(resolved(40 * rad, 3, 0.5, NULL).track, 1.5, 1e-12, 0);
    lf_assert_close(resolved(40 * rad, 3, 0.5, NULL).rows_height, 1.5, 1e-12, 0);
    /* a track without length is an arc without an angle */
    lf_assert_close(resolved(40 * rad, 3, 0, NULL).track, 0, 0, 0);
    lf_assert_close(resolved(40 * rad, 3, 0, NULL).cone, 0, 0, 0);
}

/* What the panel says of itself stands where a preset would. */
static void a_panel_may_say_its_own_quilt(void **state)
{
    static const struct {
        const char *line;
        int views, columns, rows, width, height;
        bool differs;
    } cases[] = {
        {"", 48, 8, 6, 120, 90, false},
        {"--preset portrait", 48, 8, 6, 420, 560, false},
        {"--preset go", 66, 11, 6, 372, 682, true},
        {"--views 45", 45, 5, 9, 120, 90, false},
        {"--quilt 7x7", 48, 7, 7, 120, 90, false},
        {"--quilt 4x4", 12, 4, 4, 1120, 560, false}, /* has no room for the panel's */
        {"--view-size 100x200", 48, 8, 6, 100, 200, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_camera camera = scene_camera();
        lf_calibration calibration = panel();
        lf_render_settings settings;
        lf_layout layout;
        lf_options o;
        lf_error err;
        char words[256] = "";
        calibration.quilt_columns = 8;
        calibration.quilt_rows = 6;
        calibration.quilt_width = 965; /* five more than its tiles have */
        calibration.quilt_height = 540;
        print_message("case %zu: \"%s\"\n", i, cases[i].line);
        resolve(cases[i].line, &camera, &calibration, &settings, &layout);
        assert_int_equal(layout.n_views, cases[i].views);
        assert_int_equal(layout.columns, cases[i].columns);
        assert_int_equal(layout.rows, cases[i].rows);
        assert_int_equal(layout.view_width, cases[i].width);
        assert_int_equal(layout.view_height, cases[i].height);
        lf_assert_ok(read_line(cases[i].line, &o, &err), &err);
        assert_int_equal(lf_options_preset_differs(&o, &calibration, words, sizeof words),
                         cases[i].differs);
        assert_int_equal(strstr(words, "11x6") && strstr(words, "8x6"), cases[i].differs);
        calibration.quilt_columns = 0;
        assert_false(lf_options_preset_differs(&o, &calibration, words, sizeof words));
        assert_false(lf_options_preset_differs(&o, NULL, words, sizeof words));
    }
}

static void a_panel_without_a_cone_leaves_the_scenes(void **state)
{
    lf_camera camera = scene_camera();
    lf_calibration calibration = panel();
    lf_render_settings settings;
    lf_layout layout;
    (void)state;
    calibration.view_cone_deg = 0;
    resolve("", &camera, &calibration, &settings, &layout);
    lf_assert_close(settings.camera.cone, 0.5, 0, 0);
}

static void render_options_reach_the_settings(void **state)
{
    lf_camera camera = scene_camera();
    lf_render_settings settings;
    lf_layout layout;
    (void)state;
    resolve("--integrator vpt --sampler independent --seed 9 --max-depth 3", &camera, NULL,
            &settings, &layout);
    assert_string_equal(settings.integrator, "vpt");
    assert_int_equal(settings.sampler, LF_SAMPLER_INDEPENDENT);
    assert_int_equal(settings.seed, 9);
    assert_int_equal(settings.max_depth, 3);
    for (int i = 0; i < 4; i++)
        lf_assert_close(settings.window[i], 0, 0, 0);
}

static void too_few_tiles_are_refused(void **state)
{
    lf_camera camera = scene_camera();
    lf_render_settings settings = {.width = -1};
    lf_layout layout = {.columns = -1};
    lf_options o;
    lf_error err;
    (void)state;
    lf_assert_ok(read_line("--views 45 --quilt 5x8", &o, &err), &err);
    assert_int_equal(lf_resolve_view(&o, &camera, NULL, &settings, &layout, &err), LF_E_ARG);
    assert_string_equal(err.where, "--quilt");
    assert_non_null(strstr(err.what, "40"));
    assert_non_null(strstr(err.what, "45"));
    assert_int_equal(settings.width, -1);
    assert_int_equal(layout.columns, -1);
}

/* What needs a rig says so; what needs none has one view for each camera. */
static void cameras_listed_one_by_one_are_no_rig(void **state)
{
    static const char *const refused[] = {"--preset portrait", "--views 5", "--denoise on"};
    static const lf_view_camera list[12] = {{.fov_y = 0.25}};
    lf_camera camera = scene_camera();
    lf_render_settings settings;
    lf_layout layout;
    lf_options o;
    lf_error err;
    (void)state;
    camera.list = list;
    lf_assert_ok(read_line("", &o, &err), &err);
    assert_int_equal(lf_resolve_view(&o, &camera, NULL, &settings, &layout, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "need an arc, a track or a grid"));
    lf_assert_ok(lf_resolve_rows(&o, &camera, NULL, &settings, &layout, &err), &err);
    assert_true(layout.n_views == 12 && settings.camera.list == list && !settings.features);
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        lf_assert_ok(read_line(refused[i], &o, &err), &err);
        assert_int_equal(lf_resolve_rows(&o, &camera, NULL, &settings, &layout, &err), LF_E_ARG);
        assert_non_null(strstr(err.where, "--"));
        assert_non_null(strstr(refused[i], err.where));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_of_the_program_itself_are_handed_to_it_until_one_is_bad),
        cmocka_unit_test(a_name_may_stand_behind_fit),
        cmocka_unit_test(nothing_is_read_behind_help_and_version),
        cmocka_unit_test(every_shared_option_is_taken),
        cmocka_unit_test(wrong_words_are_refused_with_the_option_and_what_it_expects),
        cmocka_unit_test(pairs_and_numbers_read_what_was_typed),
        cmocka_unit_test(command_line_beats_preset_beats_panel_beats_scene),
        cmocka_unit_test(depthiness_is_a_factor_of_the_cone_in_use),
        cmocka_unit_test(a_panel_may_say_its_own_quilt),
        cmocka_unit_test(a_panel_without_a_cone_leaves_the_scenes),
        cmocka_unit_test(render_options_reach_the_settings),
        cmocka_unit_test(too_few_tiles_are_refused),
        cmocka_unit_test(cameras_listed_one_by_one_are_no_rig),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
