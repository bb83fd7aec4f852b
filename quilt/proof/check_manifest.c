/* The manifest: the settings that everything else is measured against, whether it is complete and
 * agrees with itself and the file, and what it says about views and depth. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <nettle/sha2.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "quilt/proof/check_internal.h"

#define READ_BYTES (64 << 10)
#define HEX_SIZE (2 * SHA256_DIGEST_SIZE + 1)
#define MARGIN_MM 8.0 /* of marks; not LF_MARKS_MM, since checks share no numbers with writers */

static const char limit[] = "complete, agrees with itself, and has the file's SHA-256";
static const char rewrite[] = "Write the print again, and hand over both files together.";

double lf_check_number(const json_t *root, const char *part, const char *name, int i)
{
    const json_t *value = json_object_get(json_object_get(root, part), name);
    if (json_is_array(value))
        value = json_array_get(value, (size_t)i);
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

static const char *text_of(const json_t *root, const char *part, const char *name)
{
    return json_string_value(json_object_get(json_object_get(root, part), name));
}

/* ---------------------------------------------------------------------------------- settings -- */

/* Options that were not given are outside their ranges; they are left out. */
static lf_status take_options(const json_t *options, lf_print *print, lf_error *err)
{
    lf_param_defaults(lf_print_params, print);
    for (const lf_param *row = lf_print_params; row->name || row->option; row++) {
        const json_t *value = row->name ? json_object_get(options, row->name) : NULL;
        if (!value || json_is_null(value) ||
            (!row->required && json_is_number(value) && json_number_value(value) == 0.0))
            continue;
        json_t *one = json_pack("{s:O}", row->name, value);
        const lf_status status =
            one ? lf_param_from_json(lf_print_params, one, print, "manifest", err) : LF_E_NOMEM;
        json_decref(one);
        if (status != LF_OK)
            return status;
    }
    return LF_OK;
}

static int pixels(double mm, double dpi)
{
    return (int)lround(mm * dpi / 25.4);
}

/* The raster of the file by its definition: (trim + 2 bleed) and the margin of the marks. */
static void size_of(lf_check *check)
{
    const lf_print *print = &check->print;
    const double margin = print->marks ? MARGIN_MM : 0.0, bleed = 2.0 * print->bleed_mm;
    check->dpi[0] = print->dpi;
    check->dpi[1] = print->dpi_down > 0.0 ? print->dpi_down : print->dpi;
    check->width =
        pixels(print->width_mm + bleed, check->dpi[0]) + 2 * pixels(margin, check->dpi[0]);
    check->height =
        pixels(print->height_mm + bleed, check->dpi[1]) + 2 * pixels(margin, check->dpi[1]);
    if (!check->is_chart)
        lf_print_shape_of(print, &check->shape);
    if (check->laid) { /* the page is as large as the manifest says */
        const json_t *root = check->report->manifest;
        check->width = (int)fmin(fmax(lf_check_number(root, "size", "raster_px", 0), 0.0), 1e9);
        check->height = (int)fmin(fmax(lf_check_number(root, "size", "raster_px", 1), 0.0), 1e9);
    }
}

static lf_status fail(lf_check *check, const char *text)
{
    lf_check_say(check, CHECK_MANIFEST, LF_CHECK_FAIL, limit, rewrite, "%s", text);
    return LF_OK;
}

lf_status lf_check_manifest_read(lf_check *check, lf_error *err)
{
    const char *named = check->options->manifest;
    const char *name = named ? named : check->path;
    json_t **root = &check->report->manifest;
    lf_error problem = {0};
    lf_status status = lf_print_file_manifest(name, check->options->roots, root, &problem);
    if (status == LF_E_NOMEM || (named && status != LF_OK && status != LF_E_FORMAT)) {
        if (err)
            *err = problem;
        return status;
    }
    if (status == LF_OK && !*root && named)
        return lf_error_set(err, LF_E_IO, named, "there is no manifest with this name");
    if (status != LF_OK)
        return fail(check, problem.what);
    if (!*root)
        return fail(check, "there is no manifest beside the file");
    check->is_chart = json_is_object(json_object_get(*root, "chart"));
    status = take_options(json_object_get(*root, "options"), &check->print, &problem);
    if (status == LF_OK)
        status = lf_print_take_crosstalk(*root, "manifest", &check->print.blur, &problem);
    if (status == LF_OK)
        status = check->is_chart ? lf_chart_check(&check->print, &problem)
                                 : lf_print_check(&check->print, NULL, &problem);
    if (status != LF_OK)
        return fail(check, problem.what);
    check->known = true;
    const lf_print_sheet *sheet = &check->print.sheet;
    check->laid = sheet->columns > 1 || sheet->rows > 1 || sheet->paper_width_mm > 0.0 ||
                  sheet->paper_height_mm > 0.0 || sheet->label;
    check->linear = !lf_print_is_micro(&check->print) && !check->laid;
    check->plain =
        check->linear && check->print.optics.slant == 0.0 && !lf_print_is_exact(&check->print);
    size_of(check);
    return LF_OK;
}

/* ------------------------------------------------------------------------------------ agrees -- */

static bool near(double a, double b)
{
    return fabs(a - b) <= 1e-9 * fmax(1.0, fabs(b));
}

/* The first member that is missing, "" if none is. */
static const char *missing_from(const lf_check *check)
{
    static const char *const needed[][2] = {
        {"file", "name"},      {"file", "bytes"},         {"file", "sha256"},
        {"size", "trim_mm"},   {"size", "bleed_mm"},      {"size", "dpi"},
        {"size", "raster_px"}, {"size", "trim_box_px"},   {"colour", "space"},
        {"colour", "bits"},    {"colour", "compression"}, {"colour", "profile"}};
    static const char *const picture[][2] = {
        {"lens", "lpi"},         {"lens", "pitch_mm"}, {"lens", "phase_mm"},
        {"lens", "orientation"}, {"lens", "n_lenses"}, {"stripes", "views"},
        {"stripes", "order"},    {"stripes", "kind"},  {"stripes", "reverse"},
        {"stripes", "mirror"},   {"source", "views"}};
    const json_t *root = check->report->manifest;
    if (!json_is_string(json_object_get(root, "software")))
        return "software";
    if (!json_is_string(json_object_get(root, "print_at")))
        return "print_at";
    for (size_t i = 0; i < sizeof needed / sizeof needed[0]; i++)
        if (!json_object_get(json_object_get(root, needed[i][0]), needed[i][1]))
            return needed[i][1];
    for (size_t i = 0; i < sizeof picture / sizeof picture[0] && !check->is_chart; i++)
        if (!json_object_get(json_object_get(root, picture[i][0]), picture[i][1]))
            return picture[i][1];
    return "";
}

/* The views of a cell of the file, from left to right or top to bottom. */
static bool order_agrees(const lf_check *check)
{
    const lf_print *print = &check->print;
    const json_t *stripes = json_object_get(check->report->manifest, "stripes");
    const json_t *order = json_object_get(stripes, "order");
    const bool falls = print->reverse == (print->mirror && !print->horizontal);
    bool same = json_array_size(order) == (size_t)print->n_views &&
                json_boolean_value(json_object_get(stripes, "reverse")) == print->reverse &&
                json_boolean_value(json_object_get(stripes, "mirror")) == print->mirror;
    for (int m = 0; m < print->n_views && same; m++)
        same = json_integer_value(json_array_get(order, (size_t)m)) ==
               (falls ? print->n_views - 1 - m : m);
    return same;
}

/* What contradicts the options; "" if nothing does. */
static const char *contradiction(const lf_check *check)
{
    const json_t *root = check->report->manifest;
    const lf_print *print = &check->print;
    if (!near(lf_check_number(root, "size", "dpi", 0), check->dpi[0]) ||
        !near(lf_check_number(root, "size", "dpi", 1), check->dpi[1]))
        return "dpi";
    if (!near(lf_check_number(root, "size", "raster_px", 0), check->width) ||
        !near(lf_check_number(root, "size", "raster_px", 1), check->height))
        return "raster_px";
    if (!near(lf_check_number(root, "size", "trim_mm", 0), print->width_mm) ||
        !near(lf_check_number(root, "size", "trim_mm", 1), print->height_mm))
        return "trim_mm";
    if (!check->laid && !near(lf_check_number(root, "size", "trim_box_px", 0),
                              0.5 * check->width - 0.5 * print->width_mm * check->dpi[0] / 25.4))
        return "trim_box_px";
    if (check->is_chart)
        return "";
    if (!near(lf_check_number(root, "lens", "lpi", 0), print->lpi) ||
        !near(lf_check_number(root, "lens", "pitch_mm", 0), 25.4 / print->lpi))
        return "lpi";
    if (!near(lf_check_number(root, "lens", "phase_mm", 0), print->phase_mm))
        return "phase_mm";
    if (!near(lf_check_number(root, "stripes", "views", 0), print->n_views))
        return "views";
    return lf_print_is_micro(print) || order_agrees(check) ? "" : "order";
}

/* -------------------------------------------------------------------------------------- hash -- */

static lf_status hash_file(lf_check *check, lf_error *err)
{
    lf_print_report *report = check->report;
    uint8_t *buffer = lf_calloc(1, READ_BYTES), digest[SHA256_DIGEST_SIZE];
    struct sha256_ctx hash;
    int fd = -1;
    ssize_t n = 0;
    lf_status status = buffer ? lf_file_open(check->path, check->options->roots, UINT64_MAX, &fd,
                                             &report->bytes, err)
                              : lf_error_set(err, LF_E_NOMEM, check->path, "out of memory");
    sha256_init(&hash);
    while (status == LF_OK && ((n = read(fd, buffer, READ_BYTES)) > 0 || (n < 0 && errno == EINTR)))
        if (n > 0)
            sha256_update(&hash, (size_t)n, buffer);
    if (status == LF_OK && n == 0) {
        sha256_digest(&hash, sizeof digest, digest);
        for (size_t i = 0; i < sizeof digest; i++)
            snprintf(report->sha256 + 2 * i, 3, "%02x", digest[i]);
    }
    if (fd >= 0)
        close(fd);
    lf_free(buffer);
    return status;
}

static void hash_profile(const void *profile, size_t size, char out[static HEX_SIZE])
{
    uint8_t digest[SHA256_DIGEST_SIZE];
    struct sha256_ctx hash;
    sha256_init(&hash);
    sha256_update(&hash, size, profile);
    sha256_digest(&hash, sizeof digest, digest);
    for (size_t i = 0; i < sizeof digest; i++)
        snprintf(out + 2 * i, 3, "%02x", digest[i]);
}

static void compare_profile(lf_check *check)
{
    size_t size = 0;
    char hash[HEX_SIZE] = "";
    const void *profile = lf_print_file_icc(check->file, &size);
    const json_t *colour = json_object_get(check->report->manifest, "colour");
    const char *said = text_of(colour, "profile", "sha256");
    if (!profile)
        return;
    hash_profile(profile, size, hash);
    check->same_profile = said && strcmp(said, hash) == 0;
}

/* --------------------------------------------------------------------------- views and depth -- */

/* True if a picture's stripes lie where so many views have them. */
static bool has_measured_stripes(const lf_check *check)
{
    for (int i = 0; i < check->n_meters; i++)
        if (strcmp(check->meters[i].what, "picture") == 0)
            return true;
    return false;
}

void lf_check_views(lf_check *check)
{
    const lf_print *print = &check->print;
    if (!check->known || check->is_chart)
        return;
    const double pixels_a_lens = check->dpi[print->horizontal ? 1 : 0] / print->lpi /
                                 cos(print->optics.slant * acos(-1.0) / 180.0);
    const int columns = print->n_views / lf_print_view_rows(print);
    const double ratio = columns / pixels_a_lens;
    const bool fine = columns <= 2 || ratio <= 0.8 + 1e-9;
    const bool seen = check->differing == 0 || has_measured_stripes(check);
    lf_check_say(check, CHECK_VIEWS,
                 !fine  ? LF_CHECK_WARN
                 : seen ? LF_CHECK_PASS
                        : LF_CHECK_NONE,
                 "at most 0.8 views per pixel of a lens",
                 "Neighbouring views show as ghosts; use fewer views or a higher resolution.",
                 "%d views in %.5g pixels: %.2f%s", columns, pixels_a_lens, ratio,
                 seen ? "" : ", by the options alone");
}

static void judge_depth(lf_check *check)
{
    static const char at_most[] = "1 lens between neighbouring views";
    const double shift = lf_check_number(check->report->manifest, "source", "parallax_lenses", 0);
    if (!(shift > 0.0))
        lf_check_say(check, CHECK_DEPTH, LF_CHECK_NONE, at_most, NULL,
                     "the views' depth is not known");
    else
        lf_check_say(check, CHECK_DEPTH, shift <= 1.0 ? LF_CHECK_PASS : LF_CHECK_WARN, at_most,
                     "Deep parts look broken; narrow the cone, or make the scene shallower.",
                     "points shift by up to %.2f lenses", shift);
}

lf_status lf_check_manifest(lf_check *check, lf_error *err)
{
    const json_t *root = check->report->manifest;
    const lf_status status = hash_file(check, err);
    if (status != LF_OK)
        return status;
    if (check->file)
        compare_profile(check);
    if (!check->known)
        return LF_OK;
    const char *missing = missing_from(check), *wrong = contradiction(check);
    const char *hash = text_of(root, "file", "sha256");
    const double bytes = lf_check_number(root, "file", "bytes", 0);
    if (missing[0])
        lf_check_say(check, CHECK_MANIFEST, LF_CHECK_FAIL, limit, rewrite, "it lacks \"%s\"",
                     missing);
    else if (wrong[0])
        lf_check_say(check, CHECK_MANIFEST, LF_CHECK_FAIL, limit, rewrite,
                     "\"%s\" contradicts its options", wrong);
    else if (!hash)
        lf_check_say(check, CHECK_MANIFEST, LF_CHECK_WARN, limit,
                     "The file could not be hashed when it was written; write it to a disk.",
                     "it has no SHA-256 of the file");
    else if (strcmp(hash, check->report->sha256) != 0 || bytes != (double)check->report->bytes)
        lf_check_say(check, CHECK_MANIFEST, LF_CHECK_FAIL, limit, rewrite,
                     "the file's SHA-256 differs: it was changed after it was written, or is "
                     "another file");
    else
        lf_check_say(check, CHECK_MANIFEST, LF_CHECK_PASS, limit, NULL,
                     "complete; SHA-256 %.16s ...", hash);
    if (!check->is_chart)
        judge_depth(check);
    return LF_OK;
}
