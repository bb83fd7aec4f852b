#include "daemon/tools/simulate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "daemon/output/options.h"
#include "daemon/output/output.h"
#include "daemon/output/video.h"
#include "daemon/tools/render_arguments.h"
#include "daemon/tools/simulate_job.h"

/* A moving eye: from one side to the other, by this share of the range of views, and back. */
#define FRAMES 37
#define BEYOND 1.3
#define FPS 12.0
#define MAX_FILM_BYTES 1.5e9
/* Eyes may be this far to the side, and this far away, in mm. */
#define MOST_ASIDE 1e5
#define MOST_AWAY 1e6

static const char *const both_eyes[] = {
    [LF_EYES_SIDE_BY_SIDE] = "side-by-side", [LF_EYES_ANAGLYPH] = "anaglyph", NULL};

/* Those of a print that say something about its sheet, or about a file without a manifest. */
static const char *const sheet_options[] = {
    "print",     "print-size", "stripes",       "phase",     "orientation", "slant",  "lens-grid",
    "view-rows", "phase-down", "map",           "thickness", "index",       "radius", "spot",
    "dot-gain",  "distance",   "viewing-angle", "reverse",   "ink-spread",  "mirror", "copies"};

#define PLACE(field) .place = offsetof(lf_simulate_options, field)

/* clang-format off */
const lf_param lf_simulate_params[] = {
    {.option = "simulate", PLACE(on), .type = LF_PARAM_SWITCH,
     .help = "show what an eye sees of the print SCENE (a .tif) through its sheet"},
    {.option = "eye", .argument = "X,Y,D", PLACE(eye), .type = LF_PARAM_TEXT,
     .help = "with --simulate: position of the eye in mm (0,0 and the print's distance)"},
    {.option = "stereo", .argument = "NAME", PLACE(stereo), .type = LF_PARAM_WORD,
     .words = both_eyes, .optional = true, .has = offsetof(lf_simulate_options, has_stereo),
     .initial = -1, .help = "with --simulate: both eyes"},
    {.option = "eye-distance", .argument = "MM", PLACE(eyes_mm), .unit = "mm", .low = 1,
     .high = 1000, .initial = 63, .help = "with --stereo: from eye to eye"},
    {.option = "width", .argument = "PX", PLACE(width), .type = LF_PARAM_WHOLE, .low = 1,
     .high = LF_PROOF_MAX_SIDE, .help = "with --simulate: width of the image (1 pixel per lens)"},
    {.option = "mark", PLACE(marks), .type = LF_PARAM_SWITCH,
     .help = "with --simulate: hatch too much parallax; outline edges that cut what is in front"},
    {.option = "untrimmed", PLACE(untrimmed), .type = LF_PARAM_SWITCH,
     .help = "with --simulate: show bleed and marks as well"},
    {0},
};
/* clang-format on */

/* ------------------------------------------------------------------------------ command line -- */

bool lf_simulate_is_wanted(int argc, char *const argv[])
{
    static const char word[] = "--simulate";
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++)
        if (strlen(argv[i]) >= sizeof "--sim" - 1 && strncmp(argv[i], word, strlen(argv[i])) == 0)
            return true;
    return false;
}

enum { OPTION_VIEWS = LF_OPTION_OWN };

static void print_help(void)
{
    printf("Usage: quiltrender PRINT.tif --simulate -o OUT [options]\n"
           "Show what an eye sees of a finished print through its lens sheet.\n\n"
           "The ending of OUT chooses the output: .png, .jpg or .exr an image; .gif or .mp4 the "
           "eye moves over the viewing range\nand beyond; .json numbers about views, parallax and "
           "edges.\n\n"
           "The manifest beside PRINT.tif describes the sheet; these options win over it:\n");
    lf_param_print_help(lf_simulate_params, NULL);
    lf_param_print_help(lf_profile_params, NULL);
    lf_param_print_help(lf_print_params, NULL);
    printf("  --views N              number of views under a lens\n" LF_OPTIONS_HELP_LAST);
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    lf_simulate_job *j = context;
    if (code == OPTION_VIEWS)
        return lf_parse_small("--views", text, 1, LF_MAX_VIEWS, &j->print.n_views, err);
    j->out = text;
    return LF_OK;
}

static void taken(void *context, const lf_param *params, const lf_param *row)
{
    lf_simulate_job *j = context;
    bool used = false;
    if (params == lf_simulate_params)
        j->eyes_given |= strcmp(row->option, "eye-distance") == 0;
    if (params != lf_print_params)
        return;
    lf_print_give(&j->given, row);
    for (size_t i = 0; i < sizeof sheet_options / sizeof *sheet_options; i++)
        used |= strcmp(row->option, sheet_options[i]) == 0;
    if (!used && !j->useless)
        j->useless = row->option;
}

static lf_status read_options(lf_simulate_job *j, int argc, char *const argv[], bool *out_done,
                              lf_error *err)
{
    static const struct option table[] = {{"output", required_argument, NULL, 'o'},
                                          {"views", required_argument, NULL, OPTION_VIEWS},
                                          {NULL, 0, NULL, 0}};
    const lf_options_part parts[] = {{lf_simulate_params, NULL, &j->options},
                                     {lf_print_params, NULL, &j->print},
                                     {lf_profile_params, NULL, &j->names},
                                     {0}};
    const lf_options_rules rules = {.program = LF_RENDER_PROGRAM,
                                    .letters = ":o:",
                                    .parts = parts,
                                    .table = table,
                                    .print_help = print_help,
                                    .take = take,
                                    .taken = taken,
                                    .context = j};
    optind = 0; /* getopt starts anew */
    return lf_options_read(argc, argv, &rules, out_done, err);
}

static bool is_film(const char *out)
{
    return lf_path_has_ending(out, ".gif") || lf_path_has_ending(out, ".mp4");
}

static bool is_report(const char *out)
{
    return lf_path_has_ending(out, ".json");
}

static bool is_same_file(const char *a, const char *b)
{
    struct stat of_a, of_b;
    return stat(a, &of_a) == 0 && stat(b, &of_b) == 0 && of_a.st_dev == of_b.st_dev &&
           of_a.st_ino == of_b.st_ino;
}

/* A proof replaces no print, and no manifest. */
static lf_status check_free(const lf_simulate_job *j, lf_error *err)
{
    char *text = NULL;
    size_t size;
    if (is_same_file(j->in, j->out))
        return lf_error_set(err, LF_E_ARG, "-o", "is the print itself; choose another name");
    if (!is_report(j->out) || access(j->out, F_OK) != 0 ||
        lf_file_read(j->out, NULL, LF_PRINT_FILE_MAX_MANIFEST, &text, &size, NULL) != LF_OK)
        return LF_OK;
    json_t *there = json_loadb(text, size, 0, NULL);
    const bool is_manifest = json_object_get(there, "quiltd_print");
    json_decref(there);
    lf_free(text);
    return is_manifest ? lf_error_set(err, LF_E_ARG, j->out,
                                      "is the manifest of a print; choose another name for the "
                                      "numbers")
                       : LF_OK;
}

static lf_status check_operands(lf_simulate_job *j, int argc, char *const argv[], lf_error *err)
{
    struct stat info;
    if (optind >= argc)
        return lf_error_set(err, LF_E_ARG, "PRINT.tif", "is missing; --simulate needs a print");
    if (optind + 1 < argc)
        return lf_error_set(err, LF_E_ARG, argv[optind + 1], "unexpected; give only one print");
    j->in = argv[optind];
    if (lf_path_has_ending(j->in, ".pdf"))
        return lf_error_set(err, LF_E_ARG, j->in,
                            "is a PDF; --simulate reads TIFF, so write the print as .tif, too");
    if (stat(j->in, &info) == 0 && S_ISDIR(info.st_mode))
        return lf_error_set(err, LF_E_ARG, j->in,
                            "is a folder; --simulate takes one interlaced print (.tif), no frame "
                            "set");
    if (!j->out || j->out[0] == '\0')
        return lf_error_set(err, LF_E_ARG, "-o", "is missing; it gives the output file");
    if (!is_film(j->out) && !is_report(j->out) && !lf_output_fits(&lf_output_still, j->out))
        return lf_error_set(err, LF_E_ARG, j->out,
                            "must end in .png, .jpg, .exr, .gif, .mp4 or .json");
    if (j->options.has_stereo && (is_film(j->out) || is_report(j->out)))
        return lf_error_set(err, LF_E_ARG, "--stereo", "is for images: .png, .jpg or .exr");
    if (j->options.marks && (is_film(j->out) || is_report(j->out)))
        return lf_error_set(err, LF_E_ARG, "--mark", "is for images: .png, .jpg or .exr");
    if (j->options.marks && j->options.has_stereo && j->options.stereo == LF_EYES_ANAGLYPH)
        return lf_error_set(err, LF_E_ARG, "--mark",
                            "is red and blue, and so is an anaglyph; leave one of them out");
    if (j->eyes_given && !j->options.has_stereo)
        return lf_error_set(err, LF_E_ARG, "--eye-distance", "needs --stereo");
    if (j->useless)
        return lf_error_set(err, LF_E_ARG, j->useless,
                            "does nothing with --simulate, which shows a finished print; leave it "
                            "out");
    return check_free(j, err);
}

static lf_status take_eye(lf_simulate_job *j, lf_error *err)
{
    const char *text = j->options.eye;
    double at[3] = {0.0, 0.0, j->sheet.distance_mm};
    char part[64];
    lf_status status = LF_OK;
    for (int i = 0; text && i < 3 && status == LF_OK; i++) {
        const size_t n = strcspn(text, ",");
        if ((i < 2) != (text[n] == ',') || n >= sizeof part)
            return lf_error_set(err, LF_E_ARG, "--eye",
                                "must be X,Y,D in mm, such as 0,0,400; D is the distance");
        snprintf(part, sizeof part, "%.*s", (int)n, text);
        status = lf_parse_double("--eye", part, i < 2 ? -MOST_ASIDE : 0.01,
                                 i < 2 ? MOST_ASIDE : MOST_AWAY, &at[i], err);
        text += n + (i < 2);
    }
    j->eye = (lf_eye){at[0], at[1], at[2]};
    return status;
}

/* ----------------------------------------------------------------------------------- opening -- */

static void give(lf_print_given *given, const char *key)
{
    if (given->n < (int)(sizeof given->keys / sizeof *given->keys))
        given->keys[given->n++] = key;
}

/* What a file says of itself holds for any sheet: its raster, and the distance that it was made
 * for. Without a printer, it is the one that the manifest names, if its profile is here. A manifest
 * may be anyone's, so it names profiles, not files. */
static void complete_names(lf_simulate_job *j, double distance_mm)
{
    const char *printer = json_string_value(json_object_get(
        json_object_get(json_object_get(j->manifest, "profiles"), "printer"), "profile"));
    char path[PATH_MAX];
    if (j->print.dpi > 0.0)
        give(&j->given, "dpi");
    if (distance_mm > 0.0)
        give(&j->given, "distance");
    if (j->names.lens && !j->names.printer && printer && !lf_profile_is_path(printer) &&
        lf_profile_find(LF_PROFILE_PRINTER, printer, path, NULL) == LF_OK)
        j->names.printer = printer;
}

/* With a profile of a sheet, nothing is left of the sheet that the print was made for. Phase, rows
 * of views and what the printer does belong to the print. */
static void forget_sheet(lf_print *print)
{
    print->optics.thickness_mm = print->optics.index = print->optics.radius_mm = 0.0;
    print->optics.angle = print->optics.slant = 0.0;
    print->blur.spot_mm = 0.0;
    print->blur.n_crosstalk = 0;
}

/* The manifest first, then profiles, then what the command line has. */
static lf_status open_sheet(lf_simulate_job *j, int argc, char *const argv[], lf_error *err)
{
    bool done;
    lf_status status = lf_proof_print_of(j->file, j->manifest, j->in, &j->print, err);
    j->printed = j->print;
    if (j->names.lens)
        forget_sheet(&j->print);
    if (status == LF_OK)
        status = read_options(j, argc, argv, &done, err);
    if (status == LF_OK)
        complete_names(j, j->printed.optics.distance_mm);
    if (status == LF_OK && j->names.lens && !(j->print.optics.distance_mm > 0.0))
        j->print.optics.distance_mm = LF_PROOF_DISTANCE;
    if (status == LF_OK)
        status = lf_profiles_open(&j->names, NULL, &j->given, &j->print, &j->profiles, err);
    if (status != LF_OK)
        return status;
    if (!(j->print.lpi > 0.0))
        return lf_error_set(err, LF_E_ARG, j->in,
                            "has no manifest beside it; give the pitch by --print LPI@DPI");
    if (!j->manifest)
        j->printed = j->print;
    if (!(j->print.width_mm > 0.0 && j->print.height_mm > 0.0 && j->print.dpi > 0.0))
        return lf_error_set(err, LF_E_ARG, j->in,
                            "does not say its resolution; give --print and --print-size");
    return LF_OK;
}

/* The first copy of a page; with --untrimmed the page, from its middle. */
static lf_status choose_copy(lf_simulate_job *j, lf_error *err)
{
    int columns, rows;
    const lf_print_sheet *page = &j->print.sheet;
    const lf_status status =
        j->options.untrimmed
            ? LF_OK
            : lf_proof_take_copy(j->manifest, j->in, &j->sheet, &columns, &rows, err);
    if (status != LF_OK || j->options.untrimmed)
        return status;
    if (columns * rows > 1)
        lf_image_note(&j->notes, "a page of %dx%d copies; the first one is shown", columns, rows);
    else if (page->columns > 1 || page->rows > 1)
        return lf_error_set(err, LF_E_ARG, j->in,
                            "has no manifest that says where its copies are; put it beside the "
                            "print");
    return LF_OK;
}

static void show_all(lf_simulate_job *j)
{
    const lf_print_tags *tags = lf_print_file_tags(j->file);
    for (int i = 0; i < 2; i++) {
        const double pixel = tags->dpi[i] > 0.0 ? 25.4 / tags->dpi[i] : j->sheet.pixel_mm[i];
        *(i == 0 ? &j->sheet.width_mm : &j->sheet.height_mm) =
            pixel * (i == 0 ? tags->width : tags->height);
    }
}

static lf_status open_job(lf_simulate_job *j, int argc, char *const argv[], lf_error *err)
{
    char line[512];
    lf_status status = lf_print_file_open(j->in, NULL, &j->file, err);
    if (status == LF_OK)
        status = lf_print_file_manifest(j->in, NULL, &j->manifest, err);
    if (status == LF_OK)
        status = open_sheet(j, argc, argv, err);
    if (status != LF_OK)
        return status;
    lf_proof_sheet_of(&j->print, &j->sheet, &j->notes);
    status = choose_copy(j, err);
    if (status != LF_OK)
        return status;
    if (lf_print_file_profile_problem(j->file))
        lf_image_note(&j->notes, "%s; its colours are those of %s",
                      lf_print_file_profile_problem(j->file),
                      lf_print_file_tags(j->file)->samples == 4 ? "ideal inks" : "sRGB");
    for (size_t at = 0; lf_image_notes_next(&j->profiles.told.lines, &at, line, sizeof line);)
        lf_log(LF_LOG_INFO, "%s", line);
    for (size_t at = 0; lf_image_notes_next(&j->profiles.told.warnings, &at, line, sizeof line);)
        lf_log(LF_LOG_WARNING, "%s", line);
    for (size_t at = 0; lf_image_notes_next(&j->notes, &at, line, sizeof line);)
        lf_log(LF_LOG_INFO, "%s: %s", j->in, line);
    if (j->options.untrimmed)
        show_all(j);
    return take_eye(j, err);
}

static void close_job(lf_simulate_job *j)
{
    lf_profiles_finish(&j->profiles);
    lf_print_file_close(j->file);
    json_decref(j->manifest);
}

/* ------------------------------------------------------------------------------------ images -- */

static lf_status see(lf_simulate_job *j, const lf_eye *eye, int width, int height, lf_image32 *out,
                     lf_error *err)
{
    return lf_proof_picture(j->file, &j->sheet, eye, width, height, j->cancel, out, err);
}

/* Left and right beside each other, or red for the left eye and the rest for the right one. */
static lf_status join(const lf_image32 eyes[2], lf_both_eyes how, lf_image32 *out, lf_error *err)
{
    const bool beside = how == LF_EYES_SIDE_BY_SIDE;
    const int width = eyes[0].width, height = eyes[0].height;
    if (lf_image32_init(out, beside ? 2 * width : width, height, 3) != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, "proof", "out of memory");
    for (int y = 0; y < height; y++)
        for (int i = 0; i < 3 * width; i++) {
            const size_t at = (size_t)y * (size_t)width * 3 + (size_t)i;
            float *row = out->data + (size_t)y * (size_t)out->width * 3;
            if (beside) {
                row[i] = eyes[0].data[at];
                row[3 * width + i] = eyes[1].data[at];
            } else {
                row[i] = eyes[i % 3 == 0 ? 0 : 1].data[at];
            }
        }
    return LF_OK;
}

/* marks: for each eye; NULL: none. */
static lf_status see_both(lf_simulate_job *j, int width, int height, const lf_proof_depth *marks,
                          lf_image32 *out, lf_error *err)
{
    lf_image32 eyes[2] = {{0}};
    lf_status status = LF_OK;
    for (int i = 0; i < 2 && status == LF_OK; i++) {
        lf_eye eye = j->eye;
        eye.x_mm += (i - 0.5) * j->options.eyes_mm;
        status = see(j, &eye, width, height, &eyes[i], err);
        if (status == LF_OK && marks)
            lf_proof_depth_mark(marks, &eyes[i]);
    }
    if (status == LF_OK)
        status = join(eyes, j->options.stereo, out, err);
    lf_image32_finish(&eyes[0]);
    lf_image32_finish(&eyes[1]);
    return status;
}

/* A source of n pictures, one after the other. */
static lf_output_source source_of(const lf_image32 *image, const float *data, int n)
{
    const size_t row = 3 * (size_t)image->width;
    return (lf_output_source){
        .is_float = true,
        .views32 = {.n_views = n,
                    .width = image->width,
                    .height = image->height,
                    .view_stride = row * (size_t)image->height,
                    .row_stride = row,
                    .data = data},
        .aspect = (double)image->width / image->height,
    };
}

static lf_layout layout_of(const lf_image32 *image, int n)
{
    return (lf_layout){.columns = 1,
                       .rows = 1,
                       .n_views = n,
                       .view_width = image->width,
                       .view_height = image->height,
                       .aspect = (double)image->width / image->height};
}

static lf_status write_picture(lf_simulate_job *j, int width, int height, lf_error *err)
{
    lf_image32 image = {0};
    lf_proof_depth depth = {0};
    lf_status status = j->options.marks ? lf_simulate_study(j, &depth, err) : LF_OK;
    const lf_proof_depth *marks =
        j->options.marks && depth.measured >= LF_PROOF_FLIP ? &depth : NULL;
    if (status == LF_OK)
        status = j->options.has_stereo ? see_both(j, width, height, marks, &image, err)
                                       : see(j, &j->eye, width, height, &image, err);
    if (status == LF_OK && marks && !j->options.has_stereo)
        lf_proof_depth_mark(marks, &image);
    lf_proof_depth_finish(&depth);
    json_t *settings = lf_simulate_settings(j);
    const lf_output_request request = {.kind = &lf_output_still,
                                       .path = j->out,
                                       .overwrite = true,
                                       .settings = settings,
                                       .layout = layout_of(&image, 1),
                                       .cancel = j->cancel};
    const lf_output_source source = source_of(&image, image.data, 1);
    if (status == LF_OK)
        status = lf_output_write(&request, &source, err);
    json_decref(settings);
    if (status == LF_OK)
        lf_log(LF_LOG_INFO, "wrote %s (%dx%d pixels, eye at %g,%g,%g mm)", j->out, image.width,
               image.height, j->eye.x_mm, j->eye.y_mm, j->eye.distance_mm);
    lf_image32_finish(&image);
    return status;
}

/* -------------------------------------------------------------------------------------- film -- */

static lf_status see_film(lf_simulate_job *j, int width, int height, lf_video *video, lf_error *err)
{
    const double range = BEYOND * lf_proof_view_range(&j->sheet, j->eye.distance_mm);
    const size_t frame = 3 * (size_t)width * (size_t)height;
    float *film = lf_calloc(FRAMES, frame * sizeof *film);
    lf_image32 image = {.width = width, .height = height};
    lf_status status = film ? LF_OK : lf_error_set(err, LF_E_NOMEM, j->out, "out of memory");
    for (int i = 0; i < FRAMES && status == LF_OK; i++) {
        lf_eye eye = j->eye;
        *(j->sheet.horizontal ? &eye.y_mm : &eye.x_mm) += range * ((double)i / (FRAMES - 1) - 0.5);
        lf_image32 one = {0};
        status = see(j, &eye, width, height, &one, err);
        if (status == LF_OK)
            memcpy(film + (size_t)i * frame, one.data, frame * sizeof *film);
        lf_image32_finish(&one);
    }
    const lf_output_request request = {.kind = &lf_output_wiggle,
                                       .path = j->out,
                                       .layout = layout_of(&image, FRAMES),
                                       .cancel = j->cancel};
    const lf_output_source source = source_of(&image, film, FRAMES);
    if (status == LF_OK)
        status = lf_video_add_views(video, &request, &source, err);
    lf_free(film);
    return status;
}

static lf_status write_film(lf_simulate_job *j, int width, int height, lf_error *err)
{
    lf_video *video = NULL;
    const lf_image32 size = {.width = width, .height = height};
    const lf_layout layout = layout_of(&size, 1);
    lf_video_options options;
    lf_param_defaults(lf_video_params, &options);
    options.wiggle = true;
    options.fps = FPS;
    if (3.0 * width * height * FRAMES * sizeof(float) > MAX_FILM_BYTES)
        return lf_error_set(err, LF_E_ARG, "--width",
                            "gives a film of %dx%d pixels; give a smaller width", width, height);
    lf_status status = lf_video_create(j->out, &layout, &options, j->cancel, &video, err);
    if (status == LF_OK)
        status = see_film(j, width, height, video, err);
    if (status == LF_OK)
        status = lf_video_finish(video, err);
    lf_video_destroy(video);
    const double range = lf_proof_view_range(&j->sheet, j->eye.distance_mm);
    if (status == LF_OK)
        lf_log(LF_LOG_INFO, "wrote %s (%dx%d pixels; the eye moves %.0f mm to either side)", j->out,
               width, height, 0.5 * BEYOND * range);
    return status;
}

/* --------------------------------------------------------------------------------------- all -- */

static lf_status run(lf_simulate_job *j, int argc, char *const argv[], lf_error *err)
{
    int width, height;
    lf_status status = open_job(j, argc, argv, err);
    if (status == LF_OK)
        status = lf_proof_size(&j->sheet, j->options.width, &width, &height, err);
    if (status != LF_OK)
        return status;
    lf_simulate_tell(j);
    return is_report(j->out) ? lf_simulate_report(j, err)
           : is_film(j->out) ? write_film(j, width, height, err)
                             : write_picture(j, width, height, err);
}

int lf_simulate_run(int argc, char *const argv[], const lf_cancel *cancel)
{
    lf_simulate_job j = {.cancel = cancel};
    lf_error err = {0};
    bool done = false;
    lf_param_defaults(lf_print_params, &j.print);
    j.options.eyes_mm = 63.0;
    lf_status status = read_options(&j, argc, argv, &done, &err);
    if (status == LF_OK && !done)
        status = check_operands(&j, argc, argv, &err);
    if (status == LF_OK && !done) {
        j.given = (lf_print_given){0};
        status = run(&j, argc, argv, &err);
    }
    close_job(&j);
    if (status == LF_OK)
        return LF_EXIT_OK;
    if (status == LF_E_ARG)
        return lf_usage_error(LF_RENDER_PROGRAM, &err);
    lf_log_error(&err);
    return LF_EXIT_FAILED;
}
