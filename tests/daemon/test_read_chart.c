/* quiltrender --read-chart: a chart that it wrote, a photo of it, and the result that quiltprint
 * keeps. */
#include "tests/testing.h"

#include <fcntl.h>
#include <jansson.h>
#include <math.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "tests/quilt/photographed.h"

enum { WORDS = 40 };

static char said_text[16384];

/* Runs a program; its words are parted by blanks. What it prints is in said_text. */
static int run(const char *folder, const char *program, const char *line)
{
    char path[PATH_MAX], said[PATH_MAX], copy[2048];
    char *argv[WORDS] = {path};
    int n = 1, status = 0;
    assert_non_null(realpath(lf_test_built(program), path));
    snprintf(said, sizeof said, "%s", lf_test_path(folder, "said"));
    snprintf(copy, sizeof copy, "%s", line);
    for (char *word = strtok(copy, " "); word && n < WORDS - 1; word = strtok(NULL, " "))
        argv[n++] = word;
    const pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        const int fd = open(said, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
        if (chdir(folder) != 0)
            _exit(126);
        dup2(fd, STDOUT_FILENO);
        dup2(fd, STDERR_FILENO);
        execv(path, argv);
        _exit(127);
    }
    assert_int_equal(waitpid(pid, &status, 0), pid);
    FILE *file = fopen(said, "r");
    assert_non_null(file);
    said_text[fread(said_text, 1, sizeof said_text - 1, file)] = '\0';
    fclose(file);
    return WEXITSTATUS(status);
}

static void says(const char *folder, const char *line, int code, const char *words)
{
    const int got = run(folder, "quiltrender", line);
    if (got != code || !strstr(said_text, words))
        fail_msg("quiltrender %s: exit status %d, \"%s\"; expected %d, \"%s\"", line, got,
                 said_text, code, words);
}

/* A chart of 120 x 170 mm at 300 dpi from 250 mm, 3 MP. */
static lf_shot take_photo(const char *folder)
{
    const lf_print print = {.lpi = 60.0,
                            .chart_range = 0.5,
                            .chart_step = 0.1,
                            .dpi = 300,
                            .width_mm = 120.0,
                            .height_mm = 170.0,
                            .bits = 8};
    lf_shot shot = {.lpi = 60.2,
                    .phase_mm = 0.07,
                    .skew_deg = 0.2,
                    .thickness_mm = 0.6,
                    .index = 1.56,
                    .distance_mm = 250.0,
                    .tilt_deg = 6.0,
                    .direction_deg = 30.0,
                    .focal_35mm = 28.0,
                    .width = 1512,
                    .height = 2016,
                    .gain = 0.7,
                    .blur_px = 0.6,
                    .noise = 0.004};
    lf_printed printed;
    lf_paper paper;
    lf_printed_chart(&print, &printed);
    lf_paper_make(&printed, 25.4 / 300.0, 25.4 / 300.0, 0.1, &paper);
    uint8_t *photo = lf_photograph(&paper, &shot);
    lf_photo_write(lf_test_path(folder, "photo.jpg"), photo, &shot, 28);
    lf_photo_write(lf_test_path(folder, "bare.jpg"), photo, &shot, 0);
    free(photo);
    lf_paper_finish(&paper);
    lf_printed_finish(&printed);
    return shot;
}

static double number_of(const json_t *json, const char *key)
{
    assert_true(json_is_number(json_object_get(json, key)));
    return json_number_value(json_object_get(json, key));
}

static void a_photo_becomes_a_calibration(void **state)
{
    const char *f = *state;
    const lf_shot shot = take_photo(f);
    says(f, "--chart 60+-0.5/0.1@300 --print-size 120x170 -o chart.tif", 0, "wrote chart.tif");
    says(f, "--read-chart photo.jpg --thickness 0.6 --index 1.56 --distance 400 -o result.json", 0,
         "next   quiltprint calibrate LENS PRINTER result.json");
    json_t *json = json_load_file(lf_test_path(f, "result.json"), 0, NULL);
    json_t *chart = json_load_file(lf_test_path(f, "chart.json"), 0, NULL);
    assert_true(json && chart);
    lf_assert_close(number_of(json, "visual_lpi"), lf_shot_visual_lpi(&shot, 400.0), 0.0, 0.004);
    lf_assert_close(number_of(json, "phase_mm"), 0.07, 0.0, 0.01);
    lf_assert_close(number_of(json, "skew_deg"), 0.2, 0.0, 0.01);
    lf_assert_close(number_of(json, "distance_mm"), 400.0, 0.0, 1e-9);
    assert_string_equal(
        json_string_value(json_object_get(json, "chart_sha256")),
        json_string_value(json_object_get(json_object_get(chart, "file"), "sha256")));
    assert_int_equal(json_array_size(json_object_get(json, "warnings")), 0);
    assert_string_equal(json_string_value(json_object_get(json, "orientation")), "vertical");
    json_decref(json);
    json_decref(chart);
    setenv("XDG_CONFIG_HOME", f, 1);
    assert_int_equal(
        run(f, "quiltprint", "set lens acme pitch_lpi=60.2 thickness_mm=0.6 index=1.56"), 0);
    assert_int_equal(run(f, "quiltprint", "set printer studio dpi=300"), 0);
    if (run(f, "quiltprint", "calibrate acme studio result.json") != 0)
        fail_msg("calibrate: %s", said_text);
    says(f, "--read-chart photo.jpg --lens acme --printer studio -o again.json", 0,
         "calibrate acme studio again.json");
    unsetenv("XDG_CONFIG_HOME");
}

/* Views of one grey each, as files. */
static void write_views(const char *folder, int n)
{
    const lf_shot shot = {.width = 96, .height = 96};
    static uint8_t pixels[96 * 96 * 3];
    assert_int_equal(mkdir(lf_test_path(folder, "views"), 0700), 0);
    for (int view = 0; view < n; view++) {
        char name[32];
        const double light = 0.1 + 0.8 * view / (n - 1);
        memset(pixels, (int)lround(255.0 * (1.055 * pow(light, 1.0 / 2.4) - 0.055)), sizeof pixels);
        snprintf(name, sizeof name, "views/%d.jpg", view);
        lf_photo_write(lf_test_path(folder, name), pixels, &shot, 0);
    }
}

enum { N_VIEWS = 4, N_ZONES = 5 };

/* What an eye sees of a print under the sheet of a shot: the mean view of the middle, and of the
 * parts above, below, left and right of it. */
static void look_at(const char *path, const lf_shot *sheet, double eye_right, double out[N_ZONES])
{
    static const int at[N_ZONES][2] = {{0, 0}, {0, -36}, {0, 36}, {-36, 0}, {36, 0}};
    lf_shot shot = *sheet;
    lf_printed printed = {0};
    lf_paper paper;
    lf_printed_read(path, &printed);
    lf_paper_make(&printed, 25.4 / 300.0, 25.4 / 300.0, 0.1, &paper);
    shot.distance_mm = hypot(400.0, eye_right);
    shot.tilt_deg = atan2(eye_right, 400.0) * 180.0 / M_PI;
    shot.direction_deg = 0.0;
    shot.focal_35mm = 60.0;
    shot.width = shot.height = 480;
    shot.gain = 1.0;
    shot.blur_px = shot.noise = 0.0;
    uint8_t *photo = lf_photograph(&paper, &shot);
    const double px_per_mm = 60.0 / 43.2666 * hypot(480.0, 480.0) / shot.distance_mm;
    for (int zone = 0; zone < N_ZONES; zone++) {
        double sum = 0.0;
        const int half = 16, x = 240 + (int)(at[zone][0] * px_per_mm),
                  y = 240 + (int)(at[zone][1] * px_per_mm);
        for (int j = y - half; j < y + half; j++)
            for (int i = x - half; i < x + half; i++)
                sum += lf_srgb_to_linear(photo[3 * (480 * j + i)] / 255.0);
        const double light = (sum / (4.0 * half * half) - 0.03) / 0.87;
        out[zone] = (light - 0.1) / 0.8 * (N_VIEWS - 1);
    }
    free(photo);
    lf_paper_finish(&paper);
    lf_printed_finish(&printed);
}

static void print_with(const char *folder, double phase_mm, double slant)
{
    char line[512];
    snprintf(line, sizeof line,
             "views -o sheet.tif --lens acme --printer studio --print-size 100x100 --views %d "
             "--phase %.5f --slant %.5f --check off",
             N_VIEWS, phase_mm, slant);
    says(folder, line, 0, "wrote sheet.tif");
}

/* From chart to print: under the sheet that lay on the chart, the middle of the views is in front,
 * everywhere. A wrong sign of phase or skew is not. */
static void the_print_is_centred_under_the_sheet_of_the_photo(void **state)
{
    const char *f = *state;
    const lf_shot shot = take_photo(f);
    const double middle = 0.5 * (N_VIEWS - 1);
    double seen[N_ZONES];
    write_views(f, N_VIEWS);
    setenv("XDG_CONFIG_HOME", f, 1);
    assert_int_equal(
        run(f, "quiltprint", "set lens acme pitch_lpi=60.2 thickness_mm=0.6 index=1.56"), 0);
    assert_int_equal(run(f, "quiltprint", "set printer studio dpi=300"), 0);
    says(f, "--chart 60+-0.5/0.1@300 --print-size 120x170 -o chart.tif", 0, "wrote chart.tif");
    says(f, "--read-chart photo.jpg --lens acme --printer studio --distance 400 -o r.json", 0,
         "next   quiltprint calibrate acme studio r.json");
    assert_int_equal(run(f, "quiltprint", "calibrate acme studio r.json"), 0);
    json_t *json = json_load_file(lf_test_path(f, "r.json"), 0, NULL);
    assert_non_null(json);
    const double phase = number_of(json, "phase_mm"), skew = number_of(json, "skew_deg");
    json_decref(json);
    print_with(f, phase, skew);
    look_at(lf_test_path(f, "sheet.tif"), &shot, 0.0, seen);
    for (int zone = 0; zone < N_ZONES; zone++)
        lf_assert_close(seen[zone], middle, 0.0, 0.15);
    look_at(lf_test_path(f, "sheet.tif"), &shot, 60.0, seen);
    /* a view is n D p / (t N) wide */
    lf_assert_close(seen[0], middle + 60.0 / (1.56 * 400.0 * 25.4 / 60.2 / (0.6 * N_VIEWS)), 0.0,
                    0.15);
    print_with(f, -phase, skew);
    look_at(lf_test_path(f, "sheet.tif"), &shot, 0.0, seen);
    assert_true(fabs(seen[0] - middle) > 0.5);
    print_with(f, phase, -skew);
    look_at(lf_test_path(f, "sheet.tif"), &shot, 0.0, seen);
    lf_assert_close(seen[0], middle, 0.0, 0.15);
    assert_true(fabs(seen[1] - middle) > 0.5 || fabs(seen[2] - middle) > 0.5);
    unsetenv("XDG_CONFIG_HOME");
}

static void mistakes_are_told(void **state)
{
    static const char *const lines[][2] = {
        {"--read-chart photo.jpg", "--chart-file: is missing"},
        {"--chart-file chart.json", "--chart-file: needs --read-chart"},
        {"--read-chart none.jpg --chart-file sound.json", "none.jpg"},
        {"--read-chart scene.json --chart-file sound.json", "scene.json"},
        {"--read-chart photo.jpg --chart-file scene.json", "is not the manifest of a chart"},
        {"--read-chart photo.jpg --chart-file damaged.json", "expected a number from 50 to 9600"},
        {"--read-chart photo.jpg --chart-file sound.json -o out.tif", "must end in .json"},
        {"--read-chart photo.jpg --chart-file sound.json -o sound.json", "choose another name"},
        {"scene.json --read-chart photo.jpg", "cannot be combined with a scene"},
        {"--read-chart photo.jpg --print 60@600", "cannot be combined with --print"},
        {"--read-chart photo.jpg --preset portrait", "cannot be combined with --preset"},
        {"--read-chart photo.jpg --check off", "cannot be combined with --check"},
        {"--read-chart photo.jpg --stereo", "cannot be combined with --stereo"},
        {"--read-chart photo.jpg --slant 3", "--slant: has no effect on --read-chart"},
        {"--read-chart photo.jpg --bleed 3", "--bleed: has no effect on --read-chart"},
        {"--read-chart photo.jpg --spp 4", "cannot be combined with --spp"},
        {"--read-chart photo.jpg --chart-file sound.json --lens none", "there is no such lens"},
    };
    const char *f = *state;
    lf_error err;
    take_photo(f);
    lf_assert_ok(lf_outfile_text(lf_test_path(f, "scene.json"), "{}", &err), &err);
    lf_assert_ok(lf_outfile_text(lf_test_path(f, "damaged.json"),
                                 "{\"chart\": {}, \"options\": {\"lpi\": 60, \"dpi\": 1}}", &err),
                 &err);
    says(f, "--chart 60+-0.5/0.1@300 --print-size 120x170 -o sound.tif", 0, "wrote");
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        const int code = run(f, "quiltrender", lines[i][0]);
        if (code == 0 || code > 2 || !strstr(said_text, lines[i][1]))
            fail_msg("quiltrender %s: exit status %d, \"%s\"; expected \"%s\"", lines[i][0], code,
                     said_text, lines[i][1]);
    }
}

/* The reader process reads the focal length from EXIF data. Without it, the tilt tells it less
 * exactly. */
static void the_focal_length_of_a_photo_is_used(void **state)
{
    const char *f = *state;
    const lf_shot shot = take_photo(f);
    double error[2];
    says(f, "--chart 60+-0.5/0.1@300 --print-size 120x170 -o chart.tif", 0, "wrote");
    for (int i = 0; i < 2; i++) {
        char line[128];
        snprintf(line, sizeof line,
                 "--read-chart %s --thickness 0.6 --index 1.56 --distance 1000 -o r.json",
                 i ? "bare.jpg" : "photo.jpg");
        says(f, line, 0, "pitch");
        json_t *json = json_load_file(lf_test_path(f, "r.json"), 0, NULL);
        assert_non_null(json);
        error[i] = number_of(json, "error_lpi");
        lf_assert_close(number_of(json, "visual_lpi"), lf_shot_visual_lpi(&shot, 1000.0), 0.0,
                        i ? 3.0 * error[i] : 0.004);
        json_decref(json);
    }
    assert_true(error[1] > 1.01 * error[0]);
}

int main(void)
{
#define IN_FOLDER(test)                                                                            \
    cmocka_unit_test_setup_teardown(test, lf_test_folder_setup, lf_test_folder_teardown)
    const struct CMUnitTest tests[] = {
        IN_FOLDER(a_photo_becomes_a_calibration),
        IN_FOLDER(the_print_is_centred_under_the_sheet_of_the_photo),
        IN_FOLDER(mistakes_are_told),
        IN_FOLDER(the_focal_length_of_a_photo_is_used),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
