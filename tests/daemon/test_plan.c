/* --plan of quiltrender as JSON, and receipts: what programs read. */
#include <jansson.h>
#include <nettle/sha2.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "tests/daemon/quiltrender.h"

#define SIZE "--view-size 8x6 --seed 5 "

static const char *grid_of(const qr_files *f)
{
    return lf_test_write(
        f->folder, "grid.json",
        "{ \"include\": \"fog.json\", \"camera\": { \"views\": { \"grid\": { \"columns\": 2, "
        "\"rows\": 3, \"width\": 1, \"height\": 1.5 } } } }\n");
}

static json_t *plan_of(const char *line)
{
    qr_outcome o;
    json_error_t error;
    qr_run_limited(&o, line, RLIM_INFINITY);
    if (o.code != 0)
        fail_msg("%s: exit %d, %s", line, o.code, o.err);
    json_t *plan = json_loads(o.out, 0, &error);
    if (!plan)
        fail_msg("%s: %s: %s", line, error.text, o.out);
    return plan;
}

static json_t *plan(const char *fmt, ...) LF_PRINTF(1, 2);
static json_t *plan(const char *fmt, ...)
{
    char line[4 * PATH_MAX];
    va_list args;
    va_start(args, fmt);
    vsnprintf(line, sizeof line, fmt, args);
    va_end(args);
    return plan_of(line);
}

static json_int_t whole_of(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    assert_true(json_is_integer(value));
    return json_integer_value(value);
}

/* Compares a member with JSON text. */
static void assert_member(const json_t *object, const char *key, const char *expected)
{
    char *text = json_dumps(json_object_get(object, key), JSON_ENCODE_ANY | JSON_COMPACT);
    assert_non_null(text);
    assert_string_equal(text, expected);
    free(text);
}

static const json_t *item(const json_t *object, const char *list, size_t i)
{
    const json_t *entry = json_array_get(json_object_get(object, list), i);
    assert_non_null(entry);
    return entry;
}

static size_t count(const json_t *object, const char *list)
{
    return json_array_size(json_object_get(object, list));
}

static bool has_word(const json_t *object, const char *list, const char *word)
{
    size_t i;
    const json_t *entry;
    json_array_foreach(json_object_get(object, list), i, entry)
    {
        if (strcmp(json_string_value(entry), word) == 0)
            return true;
    }
    return false;
}

static void rows_of_cameras_are_tasks(void **state)
{
    const qr_files *f = *state;
    json_t *p = plan("--plan --json --task-minutes=0 %s -o %s/r_%%d/ --camera-rows=1:2 --spp 1 "
                     "--threads 1 " SIZE,
                     grid_of(f), f->folder);
    assert_member(p, "field_option", "\"--camera-rows\"");
    assert_member(p, "fields", "[1,2]");
    assert_member(p, "kind", "\"views\"");
    assert_member(p, "finishes", "[]");
    assert_member(p, "frames_output", "null");
    assert_int_equal(whole_of(p, "views"), 2);
    assert_int_equal(whole_of(p, "width"), 8);
    assert_int_equal(whole_of(p, "height"), 6);
    assert_int_equal(whole_of(p, "light_fields"), 2);
    assert_int_equal(whole_of(p, "threads"), 1);
    assert_int_equal(whole_of(p, "files_bytes"), 2 * 2 * 8 * 6 * 12);
    assert_int_equal(count(p, "tasks"), 2);
    assert_member(item(p, "tasks", 1), "fields", "[2,2]");
    assert_member(item(p, "tasks", 1), "rows", "null");
    assert_true(json_is_real(json_object_get(item(p, "tasks", 0), "cpu_seconds")));
    assert_true(whole_of(p, "memory") >= whole_of(item(p, "tasks", 0), "memory"));
    assert_true(whole_of(p, "state_bytes") > 0);
    assert_string_equal(json_string_value(item(p, "command", 0)), "quiltrender");
    assert_true(has_word(p, "command", "--threads"));
    for (const char *const *word = (const char *const[]){"--plan", "--json", "--task-minutes=0",
                                                         "--camera-rows=1:2", NULL};
         *word; word++)
        assert_false(has_word(p, "command", *word));
    json_decref(p);
}

/* The note of a file among the inputs of a plan; NULL: it is not there. */
static const json_t *input(const json_t *p, const char *folder, const char *name)
{
    const char *path = lf_test_path(folder, name);
    size_t i;
    const json_t *entry;
    json_array_foreach(json_object_get(p, "inputs"), i, entry)
    {
        if (strcmp(json_string_value(json_object_get(entry, "name")), path) == 0)
            return entry;
    }
    return NULL;
}

/* Tasks see by these notes whether a file has changed: of the scene, of what it includes and reads.
 */
static void a_plan_notes_the_files_that_it_has_read(void **state)
{
    const qr_files *f = *state;
    const char *scene = lf_test_write(
        f->folder, "shown.json",
        "{ \"include\": \"fog.json\", \"meshes\": { \"one\": { \"file\": \"one.obj\" } } }\n");
    lf_test_write(f->folder, "one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    json_t *p = plan("--plan --json %s -o %s/one.png --spp 1 " SIZE, scene, f->folder);
    assert_int_equal(count(p, "inputs"), 3);
    assert_non_null(input(p, f->folder, "shown.json"));
    assert_non_null(input(p, f->folder, "fog.json"));
    const json_t *mesh = input(p, f->folder, "one.obj");
    assert_int_equal(whole_of(mesh, "bytes"), 32);
    assert_string_equal(json_string_value(json_object_get(mesh, "sha256")),
                        "697b00ab13410c52a542d2e9c63711fcc04e9cbf6c0d3439a9b43cc812e6e713");
    assert_true(json_is_string(json_object_get(p, "quiltd")));
    /* a large file has no hash, so that tasks do not read it twice */
    assert_int_equal(truncate(lf_test_path(f->folder, "one.obj"), (16 << 20) + 1), 0);
    json_decref(p);
    p = plan("--plan --json %s -o %s/one.png --spp 1 " SIZE, scene, f->folder);
    mesh = input(p, f->folder, "one.obj");
    assert_int_equal(whole_of(mesh, "bytes"), (16 << 20) + 1);
    assert_null(json_object_get(mesh, "sha256"));
    json_decref(p);
}

/* What a job has written is no input of the next plan: a missing row would never be made again. */
static void outputs_are_no_inputs(void **state)
{
    const qr_files *f = *state;
    char scene[PATH_MAX];
    snprintf(scene, sizeof scene, "%s", grid_of(f));
    for (int is_all = 0; is_all < 2; is_all++) {
        qr_succeed("%s -o %s/plate/ --hologram views --spp 1 %s " SIZE, scene, f->folder,
                   is_all ? "" : "--camera-rows 1:1");
        json_t *p =
            plan("--plan --json %s -o %s/plate/ --hologram views --spp 1 " SIZE, scene, f->folder);
        assert_int_equal(count(p, "inputs"), 2);
        assert_non_null(input(p, f->folder, "fog.json"));
        json_decref(p);
    }
}

/* A triangle, and 12 MiB of comments. */
static void write_large(const char *path)
{
    char line[1024];
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    memset(line, '#', sizeof line);
    line[sizeof line - 1] = '\n';
    fputs("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", file);
    for (int i = 0; i < 12 << 10; i++)
        assert_int_equal(fwrite(line, sizeof line, 1, file), 1);
    assert_int_equal(fclose(file), 0);
}

/* Every process of a farm reads what has a hash. */
static void hashes_are_of_the_smaller_files_up_to_a_sum(void **state)
{
    const qr_files *f = *state;
    char scene[2048], path[32];
    size_t n = (size_t)snprintf(scene, sizeof scene, "{ \"include\": \"fog.json\", \"meshes\": { ");
    for (int i = 0; i < 6; i++) {
        snprintf(path, sizeof path, "large_%d.obj", i);
        write_large(lf_test_path(f->folder, path));
        n += (size_t)snprintf(scene + n, sizeof scene - n, "%s\"m%d\": { \"file\": \"%s\" }",
                              i > 0 ? ", " : "", i, path);
    }
    snprintf(scene + n, sizeof scene - n, " } }\n");
    json_t *p = plan("--plan --json %s -o %s/one.png --spp 1 " SIZE,
                     lf_test_write(f->folder, "sum.json", scene), f->folder);
    assert_int_equal(count(p, "inputs"), 8);
    assert_true(json_is_string(json_object_get(input(p, f->folder, "sum.json"), "sha256")));
    assert_true(json_is_string(json_object_get(input(p, f->folder, "large_4.obj"), "sha256")));
    assert_null(json_object_get(input(p, f->folder, "large_5.obj"), "sha256"));
    json_decref(p);
}

/* The highest row of cameras, the last, meets a fog with many collisions, the lowest nothing: the
 * work of their tasks differs by more than ten, which the plan must tell to a factor of two. */
static void rows_that_see_less_take_less_time(void **state)
{
    const qr_files *f = *state;
    const char *scene = lf_test_write(
        f->folder, "high.json",
        "{ \"quiltd\": 1, \"camera\": { \"position\": [0, 0, 3], \"target\": [0, 0, 0], "
        "\"fov_y\": 30, \"views\": { \"grid\": { \"columns\": 3, \"rows\": 3, \"width\": 1, "
        "\"height\": 20, \"window\": \"own\" } } }, \"volumes\": { \"fog\": { \"shape\": "
        "\"sphere\", \"transform\": { \"translate\": [0, 10, 0] }, \"density\": 20, \"albedo\": "
        "0.99 } }, \"lights\": { \"sky\": { \"type\": \"environment\", \"radiance\": 1 } } }\n");
    json_t *p = plan("--plan --json --task-minutes 0 %s -o %s/r_%%d/ --spp 64 --camera-rows 0:2 "
                     "--view-size 24x16",
                     scene, f->folder);
    double cpu[3];
    assert_int_equal(count(p, "tasks"), 3);
    for (size_t i = 0; i < 3; i++)
        cpu[i] = json_number_value(json_object_get(item(p, "tasks", i), "cpu_seconds"));
    if (!(cpu[2] > 2 * cpu[0]))
        fail_msg("rows of cameras: %g, %g and %g s", cpu[0], cpu[1], cpu[2]);
    json_decref(p);
}

/* CPU seconds of the programs so far. */
static double spent(void)
{
    struct rusage of;
    getrusage(RUSAGE_CHILDREN, &of);
    return (double)(of.ru_utime.tv_sec + of.ru_stime.tv_sec) +
           1e-6 * (double)(of.ru_utime.tv_usec + of.ru_stime.tv_usec);
}

/* Each strip of rows that a plan renders traces the light paths of the whole image: counted for
 * each row, they would make ten times what the job takes. */
static void light_paths_count_once(void **state)
{
    const qr_files *f = *state;
    const char *scene = lf_test_write(f->folder, "sun.json", lf_test_scene_text("sun-off-mirror"));
    const char *words = "--spp 4 --light-paths 4000 --denoise off --threads 1 --view-size 8x160";
    json_t *p = plan("--plan --json %s -o %s/sun.exr %s", scene, f->folder, words);
    const double planned = json_number_value(json_object_get(p, "cpu_seconds")), before = spent();
    qr_succeed("%s -o %s/sun.exr %s", scene, f->folder, words);
    const double taken = spent() - before;
    if (!(planned < 3 * taken && taken < 3 * planned))
        fail_msg("%g s planned, %g s taken", planned, taken);
    json_decref(p);
}

/* Without a limit the job is one task, which names its light fields. */
static void a_short_job_is_one_task(void **state)
{
    const qr_files *f = *state;
    json_t *p = plan("--plan --json %s -o %s/r_%%d/ --camera-rows 0:2 --spp 1 " SIZE, grid_of(f),
                     f->folder);
    assert_int_equal(count(p, "tasks"), 1);
    assert_member(item(p, "tasks", 0), "fields", "[0,2]");
    json_decref(p);
    p = plan("--plan --json %s -o %s/one.png --spp 1 " SIZE, f->scene, f->folder);
    assert_int_equal(count(p, "tasks"), 1);
    assert_member(p, "field_option", "null");
    assert_member(p, "fields", "null");
    assert_member(item(p, "tasks", 0), "fields", "null");
    assert_member(item(p, "tasks", 0), "rows", "null");
    json_decref(p);
}

/* Too large for a task: bands of image rows, whose states a finish merges. */
static void a_large_light_field_is_bands(void **state)
{
    const qr_files *f = *state;
    json_t *p =
        plan("--plan --json --task-memory 1K %s -o %s/one.png --spp 2 " SIZE, f->scene, f->folder);
    assert_int_equal(count(p, "tasks"), 6);
    for (size_t i = 0; i < 6; i++) {
        char rows[16];
        snprintf(rows, sizeof rows, "[%zu,%zu]", i, i);
        assert_member(item(p, "tasks", i), "rows", rows);
        assert_member(item(p, "tasks", i), "fields", "null");
    }
    assert_int_equal(count(p, "finishes"), 1);
    assert_member(item(p, "finishes", 0), "tasks", "[0,5]");
    assert_true(whole_of(item(p, "finishes", 0), "memory") >
                whole_of(item(p, "tasks", 0), "memory"));
    json_decref(p);
}

/* Bands need passes that are known, and rows that know nothing of each other. */
static void other_light_fields_stay_whole(void **state)
{
    const qr_files *f = *state;
    const char *const options[] = {"--time 1", "--target-denoised-error 0.01 --denoise on",
                                   "--target-error 0.01", "--integrator amvpt --spp 1"};
    for (size_t i = 0; i < sizeof options / sizeof *options; i++) {
        json_t *p = plan("--plan --json --task-memory 1K %s -o %s/one.png %s " SIZE, f->scene,
                         f->folder, options[i]);
        assert_int_equal(count(p, "tasks"), 1);
        assert_member(item(p, "tasks", 0), "rows", "null");
        if (strncmp(options[i], "--target", 8) == 0)
            assert_member(p, "cpu_seconds", "null");
        else
            assert_true(json_is_real(json_object_get(p, "cpu_seconds")));
        json_decref(p);
    }
}

/* A grid that becomes one output: states of camera rows, and one finish. */
static void a_grid_in_one_output_is_joined(void **state)
{
    const qr_files *f = *state;
    json_t *p = plan("--plan --json --task-minutes 0 --files s %s -o %s/all/ --spp 1 " SIZE,
                     grid_of(f), f->folder);
    assert_member(p, "field_option", "\"--camera-rows\"");
    assert_member(p, "fields", "[0,2]");
    assert_int_equal(whole_of(p, "views"), 6);
    assert_int_equal(count(p, "tasks"), 3);
    assert_member(item(p, "tasks", 2), "fields", "[2,2]");
    assert_member(item(p, "tasks", 2), "rows", "[0,5]");
    assert_int_equal(count(p, "finishes"), 1);
    assert_member(item(p, "finishes", 0), "fields", "null");
    assert_member(item(p, "finishes", 0), "tasks", "[0,2]");
    assert_false(has_word(p, "command", "--files"));
    json_decref(p);
    p = plan("--plan --json --task-minutes 0 %s -o %s/all.png --spp 1 " SIZE, grid_of(f),
             f->folder);
    assert_member(p, "kind", "\"quilt\"");
    assert_int_equal(whole_of(p, "views"), 6);
    json_decref(p);
}

/* Runs the commands of a plan as a shell does. */
static void run_all(const char *text)
{
    char line[8192];
    for (const char *at = text; *at; at = strchr(at, '\n') + 1) {
        assert_non_null(strchr(at, '\n'));
        snprintf(line, sizeof line, "%.*s 2> /dev/null", (int)strcspn(at, "\n"), at);
        if (at[0] != '#' && system(line) != 0)
            fail_msg("failed: %s", line);
    }
}

/* Bands of rows, their merge and the finish make the file of one run; so do the rows of a grid. */
static void the_commands_of_bands_make_the_same_file(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    char scene[PATH_MAX], a[PATH_MAX], b[PATH_MAX];
    snprintf(scene, sizeof scene, "%s", grid_of(f));
    qr_run(&o, "%s -o %s/band.exr --spp 2 --plan --task-memory 1K " SIZE, f->scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.out, "\n# after all of these:\n"));
    run_all(o.out);
    qr_succeed("%s -o %s/whole.exr --spp 2 " SIZE, f->scene, f->folder);
    snprintf(a, sizeof a, "%s/band_qs2x3a0.75.exr", f->folder);
    snprintf(b, sizeof b, "%s/whole_qs2x3a0.75.exr", f->folder);
    qr_assert_same_files(a, b);
    qr_run(&o, "%s -o %s/tasks/ --spp 2 --plan --task-minutes 0 " SIZE, scene, f->folder);
    assert_int_equal(o.code, 0);
    run_all(o.out);
    qr_succeed("%s -o %s/grid/ --spp 2 " SIZE, scene, f->folder);
    for (int i = 0; i < 6; i++) {
        snprintf(a, sizeof a, "%s/tasks/view_%03d.exr", f->folder, i);
        snprintf(b, sizeof b, "%s/grid/view_%03d.exr", f->folder, i);
        qr_assert_same_files(a, b);
    }
}

/* A whole plate of a hologram: rows, and a last finish. */
static void a_plate_is_completed_in_the_end(void **state)
{
    const qr_files *f = *state;
    json_t *p =
        plan("--plan --json --task-minutes 0 %s -o %s/plate/ --hologram views --spp 1 " SIZE,
             grid_of(f), f->folder);
    assert_member(p, "kind", "\"hologram\"");
    assert_int_equal(count(p, "tasks"), 3);
    assert_member(item(p, "tasks", 2), "fields", "[2,2]");
    assert_member(item(p, "tasks", 2), "rows", "null");
    assert_member(p, "frames_output", "null");
    assert_int_equal(count(p, "finishes"), 1);
    assert_member(item(p, "finishes", 0), "fields", "null");
    assert_member(item(p, "finishes", 0), "tasks", "[0,2]");
    json_decref(p);
}

/* A video: tasks write frames, which a finish joins. */
static void a_video_is_frames_and_a_finish(void **state)
{
    const qr_files *f = *state;
    json_t *p = plan("--plan --json --task-minutes 0 %s -o %s/turn.mp4 --turntable 4 --crf 20 "
                     "--codec=h265 --spp 1 --quilt 3x2 --views 6 " SIZE,
                     f->scene, f->folder);
    assert_member(p, "field_option", "\"--frames\"");
    assert_member(p, "fields", "[1,4]");
    assert_int_equal(count(p, "tasks"), 4);
    assert_member(item(p, "tasks", 3), "fields", "[4,4]");
    assert_member(item(p, "tasks", 3), "rows", "null");
    assert_int_equal(count(p, "finishes"), 1);
    const char *frames = json_string_value(json_object_get(p, "frames_output"));
    assert_non_null(frames);
    assert_int_equal(strncmp(frames, "frames/turn_%04d_qs3x2a", 23), 0);
    assert_true(has_word(p, "command", frames));
    assert_true(has_word(p, "command", "--turntable"));
    assert_false(has_word(p, "command", "--crf") || has_word(p, "command", "20") ||
                 has_word(p, "command", "--codec=h265"));
    assert_true(has_word(p, "join", frames) && has_word(p, "join", "--crf") &&
                has_word(p, "join", "20") && has_word(p, "join", "--codec=h265") &&
                has_word(p, "join", "1:4"));
    json_decref(p);
}

static json_int_t size_of(const char *folder, const char *name)
{
    struct stat st;
    assert_int_equal(stat(lf_test_path(folder, name), &st), 0);
    return st.st_size;
}

/* The planned size of a state is that of its sums; a head and a few numbers a row come on top. */
static void sizes_of_states_are_exact(void **state)
{
    const qr_files *f = *state;
    json_t *band = plan("--plan --json --task-memory 1K %s -o %s/one.png --spp 2 " SIZE, f->scene,
                        f->folder),
           *all = plan("--plan --json %s -o %s/one.png --spp 2 " SIZE, f->scene, f->folder);
    const json_int_t row = whole_of(band, "state_bytes"), image = whole_of(all, "state_bytes");
    assert_true(row > 0);
    assert_int_equal(image, 6 * row);
    qr_succeed("%s -o %s/one.png --spp 2 --state %s/all.lfstate " SIZE, f->scene, f->folder,
               f->folder);
    qr_succeed("%s -o %s/one.png --spp 2 --rows 0:2 --state %s/half.lfstate " SIZE, f->scene,
               f->folder, f->folder);
    const json_int_t whole = size_of(f->folder, "all.lfstate"),
                     half = size_of(f->folder, "half.lfstate");
    assert_in_range(whole - image, 1, 4096);
    assert_in_range(whole - half - 3 * row, 0, 3 * 128);
    json_decref(band);
    json_decref(all);
}

/* A task with more rows needs more memory, by what their sums take, and a finish most. */
static void memory_grows_with_rows(void **state)
{
    const qr_files *f = *state;
    json_t *p = plan("--plan --json --task-memory 1K %s -o %s/large.exr --spp 1 --denoise off "
                     "--views 40 --view-size 160x64 --threads 1 ",
                     f->scene, f->folder);
    const json_int_t row = whole_of(p, "state_bytes") / 4, image = 40 * 160 * 64 * 12,
                     all = whole_of(item(p, "finishes", 0), "memory"),
                     band = whole_of(item(p, "tasks", 0), "memory");
    assert_int_equal(count(p, "tasks"), 16);
    assert_true(all - band >= 60 * row + image);
    assert_true(whole_of(p, "memory") == all);
    json_decref(p);
}

static void memory_that_cannot_be_met_is_told(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_run(&o, "--plan --json --task-memory 1K %s -o %s/one.png --spp 2 " SIZE, f->scene,
           f->folder);
    assert_int_equal(o.code, 0);
    if (!strstr(o.err, "--task-memory: the smallest task needs ") ||
        !strstr(o.err, " MB, and 0 MB were asked for"))
        fail_msg("\"%s\"", o.err);
    qr_run(&o, "--plan --json --task-memory 1000G %s -o %s/one.png --spp 2 " SIZE, f->scene,
           f->folder);
    assert_null(strstr(o.err, "the smallest task"));
    qr_run(&o, "--plan --task-memory 1K %s -o %s/one.png --spp 2 " SIZE, f->scene, f->folder);
    assert_non_null(strstr(o.out, "# memory of a task "));
    assert_non_null(strstr(o.out, "# memory of a finish "));
}

static void wrong_plans_are_one_line(void **state)
{
    const qr_files *f = *state;
    static const struct {
        const char *options, *words;
    } wrong[] = {
        {"--json", "--json: needs --plan"},
        {"--task-minutes 5", "--task-minutes: needs --plan"},
        {"--task-memory 5G", "--task-memory: needs --plan"},
        {"--plan --task-minutes -1", "--task-minutes: expects a number from 0 to 1e+06"},
        {"--plan --task-memory 5X", "--task-memory: expects a size such as 500M or 2G, not"},
        {"--plan --task-memory 0", "--task-memory: expects a size such as 500M or 2G, not"},
        {"--plan --task-memory G", "--task-memory: expects a size such as 500M or 2G, not"},
    };
    qr_outcome o;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        qr_run(&o, "%s -o %s/w.png %s", f->scene, f->folder, wrong[i].options);
        qr_assert_fails(&o, 2, wrong[i].words);
    }
}

/* Its tasks would refuse them. Those that are kept are outputs, and no inputs. */
static void frames_that_tasks_would_refuse_are_told(void **state)
{
    const char *how = "--turntable 3 --quilt 3x2 " SIZE;
    const qr_files *f = *state;
    qr_outcome o;
    json_t *before = plan("%s -o %s/k.png --passes 2 --plan --json %s", f->scene, f->folder, how);
    qr_succeed("%s -o %s/k.png --frames 2:2 --passes 2 %s", f->scene, f->folder, how);
    for (int json = 0; json < 2; json++) {
        qr_run(&o, "%s -o %s/k.png --passes 9 --plan %s %s", f->scene, f->folder,
               json ? "--json" : "", how);
        qr_assert_fails(&o, 1,
                        "k_0002_qs3x2a0.75.png: exists and was rendered with budget passes 2, not "
                        "passes 9; remove it, or keep it with --mixed");
    }
    qr_succeed("%s -o %s/k.png --passes 9 --mixed --plan %s", f->scene, f->folder, how);
    json_t *after = plan("%s -o %s/k.png --passes 2 --plan --json %s", f->scene, f->folder, how);
    assert_true(count(before, "inputs") > 0);
    assert_true(json_equal(json_object_get(before, "inputs"), json_object_get(after, "inputs")));
    json_decref(before);
    json_decref(after);
}

/* ---------------------------------------------------------------------------------- receipts -- */

/* The entry of a file is true, by another reading of it. */
static void assert_entry(const json_t *entry)
{
    char *data = NULL, hex[2 * SHA256_DIGEST_SIZE + 1];
    size_t n = 0;
    lf_error err = {0};
    uint8_t digest[SHA256_DIGEST_SIZE];
    struct sha256_ctx hash;
    const char *name = json_string_value(json_object_get(entry, "name"));
    lf_assert_ok(lf_file_read(name, NULL, 1 << 30, &data, &n, &err), &err);
    sha256_init(&hash);
    sha256_update(&hash, n, (const uint8_t *)data);
    sha256_digest(&hash, sizeof digest, digest);
    for (size_t i = 0; i < sizeof digest; i++)
        snprintf(hex + 2 * i, 3, "%02x", digest[i]);
    assert_int_equal(whole_of(entry, "bytes"), n);
    assert_string_equal(json_string_value(json_object_get(entry, "sha256")), hex);
    lf_free(data);
}

/* Reads a receipt whose n entries are true. */
static json_t *receipt(const char *path, size_t n)
{
    json_t *r = json_load_file(path, 0, NULL);
    assert_non_null(r);
    assert_true(json_is_string(json_object_get(r, "quiltd")));
    assert_int_equal(count(r, "files"), n);
    for (size_t i = 0; i < n; i++)
        assert_entry(item(r, "files", i));
    return r;
}

static void a_receipt_names_every_file(void **state)
{
    const qr_files *f = *state;
    char path[PATH_MAX], name[PATH_MAX];
    snprintf(path, sizeof path, "%s/receipt.json", f->folder);
    qr_succeed("%s -o %s/r_%%d/ --camera-rows 0:1 --spp 1 --files %s " SIZE, grid_of(f), f->folder,
               path);
    json_t *r = receipt(path, 4);
    snprintf(name, sizeof name, "%s/r_1/view_001.exr", f->folder);
    assert_string_equal(json_string_value(json_object_get(item(r, "files", 3), "name")), name);
    json_decref(r);
    /* files that were kept are in it, too */
    qr_succeed("%s -o %s/r_%%d/ --camera-rows 0:2 --spp 1 --files %s " SIZE, grid_of(f), f->folder,
               path);
    json_decref(receipt(path, 6));
    qr_succeed("%s -o %s/one.png --spp 1 --stats %s/stats.json --files %s " SIZE, f->scene,
               f->folder, f->folder, path);
    json_decref(receipt(path, 2));
    qr_succeed("%s -o %s/again.png --files %s", f->quilt, f->folder, path);
    json_decref(receipt(path, 1));
}

static void a_receipt_names_what_is_beside_a_print(void **state)
{
    const qr_files *f = *state;
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/receipt.json", f->folder);
    qr_succeed("%s -o %s/print.tif --print 40@240 --print-size 30x20 --files %s", f->quilt,
               f->folder, path);
    json_decref(receipt(path, 5)); /* print, manifest, two reports, job sheet */
}

static void a_failed_run_leaves_no_receipt(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_run(&o, "%s/none.json -o %s/none.png --files %s/none-receipt.json", f->folder, f->folder,
           f->folder);
    assert_int_equal(o.code, 1);
    assert_false(qr_exists(f->folder, "none-receipt.json"));
    qr_run(&o, "%s -o %s/one.png --spp 1 --files %s/none/receipt.json " SIZE, f->scene, f->folder,
           f->folder);
    qr_assert_fails(&o, 1, "none/receipt.json: cannot write to the folder");
    qr_run(&o, "%s -o %s/one.png --spp 1 --files %s " SIZE, f->scene, f->folder, f->scene);
    qr_assert_fails(&o, 2, "fog.json: is the input; choose another output name");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(rows_of_cameras_are_tasks, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_plan_notes_the_files_that_it_has_read, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(outputs_are_no_inputs, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(hashes_are_of_the_smaller_files_up_to_a_sum, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(rows_that_see_less_take_less_time, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(light_paths_count_once, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_short_job_is_one_task, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_large_light_field_is_bands, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(other_light_fields_stay_whole, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_grid_in_one_output_is_joined, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(the_commands_of_bands_make_the_same_file, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(a_plate_is_completed_in_the_end, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_video_is_frames_and_a_finish, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(sizes_of_states_are_exact, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(memory_grows_with_rows, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(memory_that_cannot_be_met_is_told, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(wrong_plans_are_one_line, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(frames_that_tasks_would_refuse_are_told, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(a_receipt_names_every_file, qr_set_up, qr_tear_down),
        cmocka_unit_test_setup_teardown(a_receipt_names_what_is_beside_a_print, qr_set_up,
                                        qr_tear_down),
        cmocka_unit_test_setup_teardown(a_failed_run_leaves_no_receipt, qr_set_up, qr_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
