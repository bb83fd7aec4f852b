#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <nettle/sha2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file_hash.h"
#include "base/version.h"
#include "quilt/print/blur.h"
#include "quilt/print/flip.h"
#include "quilt/print/relief.h"
#include "quilt/print/sheet.h"

/* ------------------------------------------------------------------------------------ hashes -- */

static void hex_digest(struct sha256_ctx *hash, char out[static LF_HASH_TEXT])
{
    uint8_t digest[SHA256_DIGEST_SIZE];
    sha256_digest(hash, sizeof digest, digest);
    for (size_t i = 0; i < sizeof digest; i++)
        snprintf(out + 2 * i, 3, "%02x", digest[i]);
}

static void hash_bytes(const void *data, size_t size, char out[static LF_HASH_TEXT])
{
    struct sha256_ctx hash;
    sha256_init(&hash);
    sha256_update(&hash, size, data);
    hex_digest(&hash, out);
}

/* A readable descriptor of the file; a write-only one is opened again. -1: not possible. */
static int open_to_read(const lf_outfile *file)
{
    const int flags = fcntl(file->fd, F_GETFL);
    char path[32];
    if (flags >= 0 && (flags & O_ACCMODE) == O_RDWR)
        return fcntl(file->fd, F_DUPFD_CLOEXEC, 0);
    snprintf(path, sizeof path, "/proc/self/fd/%d", file->fd);
    return open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
}

/* False: the file cannot be read back. */
static bool hash_file(const lf_outfile *file, char out[static LF_HASH_TEXT], int64_t *out_size)
{
    const int fd = open_to_read(file);
    const bool is_read = fd >= 0 && lf_file_hash(fd, out, out_size);
    if (fd >= 0)
        close(fd);
    return is_read;
}

/* ------------------------------------------------------------------------------------- parts -- */

json_t *lf_print_file_json(const lf_outfile *file)
{
    const char *slash = file->path ? strrchr(file->path, '/') : NULL;
    const char *name = slash ? slash + 1 : file->path;
    char hash[LF_HASH_TEXT];
    int64_t size = 0;
    if (!hash_file(file, hash, &size))
        return json_pack("{s:s?, s:n, s:n}", "name", name, "bytes", "sha256");
    return json_pack("{s:s?, s:I, s:s}", "name", name, "bytes", (json_int_t)size, "sha256", hash);
}

/* One number if both are equal, as an integer if possible. */
static json_t *both_ways(double right, double down)
{
    if (right != down)
        return json_pack("[f,f]", right, down);
    return right == floor(right) ? json_integer((json_int_t)right) : json_real(right);
}

/* The trim edges around a copy in the final file, with marks, in pixels. */
static void trim_box(const lf_print *print, const lf_sheet *sheet, const lf_copy *copy,
                     double out[static 4])
{
    const double right_mm = 25.4 / print->dpi, down_mm = 25.4 / lf_print_dpi_down(print);
    const double right = (print->mirror ? -copy->right_mm : copy->right_mm) / right_mm;
    out[0] = 0.5 * (sheet->width - print->width_mm / right_mm) + right;
    out[1] = 0.5 * (sheet->height - print->height_mm / down_mm) + copy->down_mm / down_mm;
    out[2] = 0.5 * (sheet->width + print->width_mm / right_mm) + right;
    out[3] = 0.5 * (sheet->height + print->height_mm / down_mm) + copy->down_mm / down_mm;
}

/* The same around all copies. */
static void whole_box(const lf_print *print, const lf_sheet *sheet, double out[static 4])
{
    trim_box(print, sheet, &sheet->copies[0], out);
    for (int i = 1; i < sheet->n_rows * sheet->n_columns; i++) {
        double box[4];
        trim_box(print, sheet, &sheet->copies[i], box);
        for (int k = 0; k < 4; k++)
            out[k] = k < 2 ? fmin(out[k], box[k]) : fmax(out[k], box[k]);
    }
}

/* The members trim_box_px and trim_box_mm, added to object. */
static json_t *with_box(json_t *object, const lf_print *print, const double box[static 4])
{
    const double right_mm = 25.4 / print->dpi, down_mm = 25.4 / lf_print_dpi_down(print);
    json_t *boxes = json_pack("{s:[f,f,f,f], s:[f,f,f,f]}", "trim_box_px", box[0], box[1], box[2],
                              box[3], "trim_box_mm", box[0] * right_mm, box[1] * down_mm,
                              box[2] * right_mm, box[3] * down_mm);
    if (object && json_object_update_new(object, boxes) == 0)
        return object;
    json_decref(object);
    return NULL;
}

/* Boxes are in the final file, with marks. A chart has no sheet. */
static json_t *size_part(const lf_print_facts *facts)
{
    const lf_print *print = facts->print;
    const lf_print_shape *shape = facts->shape;
    const double right_mm = 25.4 / print->dpi, down_mm = 25.4 / lf_print_dpi_down(print);
    lf_copy middle = {0};
    const lf_sheet alone = {shape->raster_width, shape->raster_height, 1, 1, .copies = &middle};
    const lf_sheet *sheet = facts->sheet ? facts->sheet : &alone;
    const double margin_mm[2] = {shape->margin_px * right_mm, shape->margin_down_px * down_mm};
    double box[4];
    whole_box(print, sheet, box);
    return with_box(
        json_pack("{s:[f,f], s:f, s:o, s:o, s:[i,i], s:[f,f]}", "trim_mm", print->width_mm,
                  print->height_mm, "bleed_mm", print->bleed_mm, "marks_mm",
                  margin_mm[0] == margin_mm[1] ? json_real(margin_mm[0])
                                               : both_ways(margin_mm[0], margin_mm[1]),
                  "dpi", both_ways(print->dpi, lf_print_dpi_down(print)), "raster_px", sheet->width,
                  sheet->height, "raster_mm", sheet->width * right_mm, sheet->height * down_mm),
        print, box);
}

static json_t *copy_parts(const lf_print_facts *facts)
{
    const lf_sheet *sheet = facts->sheet;
    const double side = facts->print->mirror ? -1.0 : 1.0;
    json_t *copies = json_array();
    for (int i = 0; copies && i < sheet->n_rows * sheet->n_columns; i++) {
        const lf_copy *copy = &sheet->copies[i];
        double box[4];
        trim_box(facts->print, sheet, copy, box);
        json_t *part = json_pack("{s:i, s:i, s:[f,f], s:i}", "column", i % sheet->n_columns, "row",
                                 i / sheet->n_columns, "middle_mm", side * copy->right_mm,
                                 copy->down_mm, "lens", copy->lens);
        json_array_append_new(copies, with_box(part, facts->print, box));
    }
    return copies;
}

/* The page: its copies, from the middle of the file; NULL for one print alone. */
static json_t *sheet_part(const lf_print_facts *facts)
{
    const lf_sheet *sheet = facts->sheet;
    if (sheet->n_rows * sheet->n_columns == 1 && sheet->label_mm == 0.0 &&
        facts->print->sheet.paper_width_mm == 0.0)
        return NULL;
    return json_pack("{s:i, s:i, s:[f,f], s:f, s:s, s:o?, s:f, s:o}", "columns", sheet->n_columns,
                     "rows", sheet->n_rows, "step_mm", sheet->step_right_mm, sheet->step_down_mm,
                     "mechanical_pitch_mm", sheet->mechanical_mm, "mechanical_pitch_kind",
                     sheet->mechanical_known ? "from thickness, index and distance"
                                             : "unknown, the visual pitch is used",
                     "label", sheet->label_mm > 0.0 ? json_string(sheet->label) : NULL, "label_mm",
                     sheet->label_mm, "copies", copy_parts(facts));
}

/* Views, or columns of views, in their order in a cell of the final file, from left to right (top
 * to bottom for horizontal lenses). */
static json_t *order_part(int n, bool rising)
{
    json_t *order = json_array();
    for (int m = 0; order && m < n; m++)
        json_array_append_new(order, json_integer(rising ? m : n - 1 - m));
    return order;
}

/* A number of the sheet; null if it is unknown. */
static json_t *known(double value)
{
    return value > 0.0 ? json_real(value) : json_null();
}

/* What is known of the sheet's optics. */
static json_t *optics_part(const lf_print *print, const json_t *options)
{
    const lf_optics *o = &print->optics;
    const bool has_optics = o->thickness_mm > 0.0 && o->distance_mm > 0.0;
    const double enlarged = has_optics ? lf_lens_enlargement_of(print) : 0.0;
    return json_pack("{s:f, s:O, s:s, s:o, s:o, s:b, s:o, s:o, s:o}", "slant", o->slant, "grid",
                     json_object_get(options, "lens_grid"), "map",
                     lf_print_is_exact(print) ? "exact" : "uniform", "thickness_mm",
                     known(o->thickness_mm), "index",
                     o->thickness_mm > 0.0 ? json_real(lf_optics_index(o)) : known(o->index),
                     "index_is_assumed", o->thickness_mm > 0.0 && !(o->index > 0.0), "distance_mm",
                     known(o->distance_mm), "mechanical_lpi", known(print->lpi * enlarged),
                     "mechanical_pitch_mm",
                     has_optics ? json_real(lf_print_pitch_mm(print) / enlarged) : json_null());
}

static json_t *lens_part(const lf_print *print, const lf_print_shape *shape, const json_t *options)
{
    json_t *lens =
        json_pack("{s:f, s:f, s:s, s:f, s:f, s:O, s:i, s:i, s:f}", "lpi", print->lpi, "pitch_mm",
                  lf_print_pitch_mm(print), "pitch_kind", "visual, as measured", "pixels_per_lens",
                  lf_print_pixels_per_lens(print), "phase_mm", print->phase_mm, "orientation",
                  json_object_get(options, "orientation"), "n_lenses", shape->n_lenses,
                  "first_lens", shape->first_lens, "first_lens_mm", shape->first_across_mm);
    json_t *optics = optics_part(print, options);
    if (!lens || !optics || json_object_update(lens, optics) != 0) {
        json_decref(lens);
        lens = NULL;
    }
    json_decref(optics);
    return lens;
}

static json_t *stripe_part(const lf_print *print, const json_t *options)
{
    const int rows = lf_print_view_rows(print), columns = print->n_views / rows;
    const bool rising = print->reverse != (print->mirror && !print->horizontal);
    json_t *part =
        json_pack("{s:i, s:O, s:b, s:b, s:o, s:s, s:s}", "views", print->n_views, "kind",
                  json_object_get(options, "stripes"), "reverse", print->reverse, "mirror",
                  print->mirror, "order", order_part(columns, rising), "order_runs",
                  print->horizontal ? "top to bottom within a cell of the file"
                                    : "left to right within a cell of the file",
                  "view_0",
                  lf_print_is_micro(print) ? "lowest row, leftmost camera"
                  : print->horizontal      ? "topmost camera"
                                           : "leftmost camera");
    if (part && lf_print_is_micro(print)) {
        json_object_set_new(part, "rows", json_integer(rows));
        json_object_set_new(part, "row_order", order_part(rows, !print->reverse));
        json_object_set_new(part, "row_order_runs",
                            json_string("top to bottom within a cell of the file"));
    }
    return part;
}

/* Placement of a picture of another shape: its size, and its middle relative to the print's. */
static json_t *photo_part(const lf_print_source *source)
{
    const lf_photo_place *place = &source->place;
    if (!source->resampled)
        return NULL;
    return json_pack("{s:[f,f], s:[f,f], s:[f,f], s:f}", "size_mm", place->width, place->height,
                     "middle_mm", place->right, place->down, "border_mm", place->beside,
                     place->above, "cut", place->cut);
}

static const char *sampling_of(const lf_print *print)
{
    if (lf_print_is_micro(print))
        return "one sample per lens";
    return print->optics.slant == 0.0 ? "one sample per lens, the printer's rows"
                                      : "at the axis of each lens, the printer's rows";
}

/* Which image each stripe shows; a blend of images 2 and 3 is 2.5; null is a guard of one light. */
static json_t *shown_part(const lf_print_facts *facts)
{
    const int n_images = facts->source->views->n_views;
    json_t *shown = json_array();
    for (int i = 0; shown && i < facts->print->n_views; i++) {
        const lf_stripe_content content = lf_flip_content(facts->print, n_images, i);
        json_array_append_new(shown, content.neutral ? json_null()
                                     : content.blend > 0.0F
                                         ? json_real(content.image + (double)content.blend)
                                         : json_integer(content.image));
    }
    return shown;
}

static json_t *source_part(const lf_print_facts *facts)
{
    const lf_views32 *views = facts->source->views;
    return json_pack(
        "{s:i, s:[i,i], s:b, s:s, s:i, s:o, s:o?, s:f, s:s, s:o}", "views", views->n_views,
        "view_px", views->width, views->height, "resampled", facts->source->resampled, "sampling",
        facts->source->resampled ? "area average where smaller, linear where larger"
                                 : sampling_of(facts->print),
        "frames", lf_flip_frames(facts->print, views->n_views), "shown", shown_part(facts), "photo",
        photo_part(facts->source), "exposure", facts->run->exposure, "tonemap",
        facts->run->tonemap ? facts->run->tonemap : "srgb", "parallax_lenses",
        facts->print->parallax_lenses > 0.0 ? json_real(facts->print->parallax_lenses)
                                            : json_null());
}

static json_t *colour_part(const lf_print_facts *facts, const json_t *options)
{
    size_t size;
    const void *profile = lf_print_colour_profile(facts->colour, &size);
    char hash[LF_HASH_TEXT];
    hash_bytes(profile, size, hash);
    const bool is_cmyk = lf_print_colour_channels(facts->colour) == 4;
    return json_pack("{s:s, s:O, s:O, s:{s:s, s:s, s:I}, s:o*}", "space", is_cmyk ? "CMYK" : "RGB",
                     "bits", json_object_get(options, "bits"), "compression",
                     json_object_get(options, "compress"), "profile", "name",
                     lf_print_colour_name(facts->colour), "sha256", hash, "bytes", (json_int_t)size,
                     "most_ink_percent",
                     is_cmyk && facts->ink > 0.0 ? json_real(facts->ink) : NULL);
}

/* A line that may contain a file name, which may be any bytes. */
static json_t *line_of(char *text)
{
    json_t *line = json_string(text);
    for (char *c = text; !line && *c; c++)
        if ((unsigned char)*c >= 0x80)
            *c = '?';
    return line ? line : json_string(text);
}

static json_t *warning_part(const lf_print_facts *facts)
{
    json_t *warnings = json_array();
    char text[512];
    if (warnings && facts->warning)
        json_array_append_new(warnings, json_string(facts->warning));
    if (warnings && facts->print->parallax_lenses > 1.0) {
        snprintf(text, sizeof text,
                 "points shift by up to %.2f lenses between views; objects that shift by more than "
                 "1 look broken",
                 facts->print->parallax_lenses);
        json_array_append_new(warnings, json_string(text));
    }
    json_t *of_profiles = json_object_get(facts->print->profiles, "warnings");
    if (warnings && of_profiles)
        json_array_extend(warnings, of_profiles);
    const lf_image_notes *notes = facts->run->notes;
    for (size_t at = 0; warnings && notes && lf_image_notes_next(notes, &at, text, sizeof text);)
        json_array_append_new(warnings, line_of(text));
    return warnings;
}

static json_t *compensation_part(const lf_print_left *left)
{
    return left->compensated
               ? json_pack("{s:{s:f, s:f}, s:{s:f, s:f}, s:{s:f, s:f}, s:f, s:{s:f, s:f}}",
                           "own_share_before", "mean", left->own_share, "worst",
                           left->own_share_worst, "ghost_before", "mean", left->ghost_before,
                           "worst", left->worst_before, "ghost_left", "mean", left->ghost, "worst",
                           left->worst, "clamped", left->clamped, "between_views", "before",
                           left->between_before, "left", left->between)
               : NULL;
}

static json_t *relief_part(const lf_print_facts *facts)
{
    const lf_relief *relief = facts->relief;
    if (!relief)
        return NULL;
    return json_pack("{s:o, s:[f,f], s:f, s:f, s:s, s:f, s:s, s:f, s:f, s:f, s:f, s:s}", "file",
                     lf_print_file_json(facts->run->relief), "height_mm", 0.0, relief->sag_mm,
                     "base_mm", relief->thickness_mm - relief->sag_mm, "pitch_mm", relief->pitch_mm,
                     "pitch_kind", relief->is_mechanical ? "mechanical" : "visual, as measured",
                     "radius_mm", relief->radius_mm, "radius_from", relief->from, "index",
                     lf_optics_index(&facts->print->optics), "focal_mm", relief->focal_mm,
                     "thickness_mm", relief->thickness_mm, "spot_mm", lf_relief_spot(relief),
                     "code",
                     "16 bits: black is height_mm[0], white height_mm[1]; seen from the front");
}

/* The members of a print that a chart does not have. */
static json_t *picture_parts(const lf_print_facts *facts, const json_t *options)
{
    return json_pack("{s:o, s:o, s:o, s:o*, s:o*, s:o*, s:o*}", "lens",
                     lens_part(facts->print, facts->shape, options), "stripes",
                     stripe_part(facts->print, options), "source", source_part(facts), "relief",
                     relief_part(facts), "sheet", sheet_part(facts), "crosstalk",
                     lf_blur_crosstalk_json(&facts->print->blur), "compensation",
                     compensation_part(&facts->left));
}

/* Adds the account of profiles; its warnings are among all. */
static void add_profiles(json_t *root, const lf_print *print)
{
    json_t *account = json_copy((json_t *)(uintptr_t)print->profiles);
    json_t *kind = json_object_get(account, "pitch_kind");
    if (kind)
        json_object_set(json_object_get(root, "lens"), "pitch_kind", kind);
    json_object_del(account, "pitch_kind");
    json_object_del(account, "warnings");
    json_object_set_new(root, "profiles", account);
}

lf_status lf_print_manifest_write(const lf_print_facts *facts, const lf_outfile *tiff,
                                  lf_outfile *manifest, lf_error *err)
{
    static const char advice[] =
        "Print at 100 %, without scaling, fit to page, borderless enlargement, sharpening or "
        "colour adjustment by the driver. The raster is the printer's own.";
    const char *where = manifest->path ? manifest->path : "print manifest";
    json_t *options = lf_param_json(lf_print_params, facts->print);
    json_t *settings = facts->run->settings ? json_deep_copy(facts->run->settings) : NULL;
    json_t *root = json_pack("{s:i, s:s, s:s, s:o, s:O?, s:o, s:o, s:o, s:o?}", "quiltd_print", 1,
                             "software", "quiltd " LF_VERSION, "print_at", advice, "file",
                             lf_print_file_json(tiff), "options", options, "size", size_part(facts),
                             "colour", colour_part(facts, options), "warnings", warning_part(facts),
                             "settings", settings);
    if (facts->chart)
        json_object_set_new(root, "chart", facts->chart);
    else if (json_object_update_new(root, picture_parts(facts, options)) != 0) {
        json_decref(root);
        root = NULL;
    }
    if (root && facts->print->profiles)
        add_profiles(root, facts->print);
    char *text = root ? json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(15)) : NULL;
    lf_status status = LF_OK;

    json_decref(root);
    json_decref(options);
    if (!text)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory, or a name is not UTF-8");
    status = lf_outfile_write(manifest, text, strlen(text), err);
    if (status == LF_OK)
        status = lf_outfile_write(manifest, "\n", 1, err);
    free(text);
    return status;
}
