/* What the file's tags say, against the manifest and against what printers want. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/proof/check_internal.h"

static const char rewrite[] = "Write the print again; let no other program save it.";

static void check_size(lf_check *check)
{
    const lf_print_tags *tags = check->tags;
    const bool same = tags->width == check->width && tags->height == check->height;
    char limit[64];
    snprintf(limit, sizeof limit, "%d x %d pixels", check->width, check->height);
    lf_check_say(check, CHECK_SIZE, same ? LF_CHECK_PASS : LF_CHECK_FAIL, limit,
                 "Something has cropped or resized the file; write the print again.",
                 "%d x %d pixels", tags->width, tags->height);
}

/* a / b is exactly the number that a decimal option means. */
static bool is_exactly(const uint32_t fraction[2], double dpi)
{
    return fraction[1] > 0 &&
           fabs((double)fraction[0] - dpi * fraction[1]) <= 1e-9 * dpi * fraction[1];
}

static void check_resolution(lf_check *check)
{
    if (lf_print_file_boxes(check->file)) {
        lf_check_pdf_resolution(check);
        return;
    }
    const uint32_t(*at)[2] = check->tags->resolution;
    const bool inch = check->tags->unit == 2;
    const bool same = is_exactly(at[0], check->dpi[0]) && is_exactly(at[1], check->dpi[1]);
    char limit[96];
    snprintf(limit, sizeof limit, "%.10g x %.10g per inch, exactly", check->dpi[0], check->dpi[1]);
    lf_check_say(check, CHECK_RESOLUTION, inch && same ? LF_CHECK_PASS : LF_CHECK_FAIL, limit,
                 "A program has changed the resolution, and the print gets a wrong size; write "
                 "it again.",
                 "%u/%u x %u/%u per %s", at[0][0], at[0][1], at[1][0], at[1][1],
                 inch                     ? "inch"
                 : check->tags->unit == 3 ? "centimetre"
                                          : "unknown unit");
}

/* The resolutions that the printer's profile names, which the manifest keeps; NULL: it names none.
 */
static const json_t *natives_of(const lf_check *check)
{
    const json_t *printer =
        json_object_get(json_object_get(check->report->manifest, "profiles"), "printer");
    const json_t *list = json_object_get(printer, "native_dpi");
    return json_array_size(list) > 0 ? list : NULL;
}

/* list: NULL: those of common printers. */
static bool is_native(const json_t *list, double dpi)
{
    static const double rasters[] = {300, 360, 600, 720, 1200, 1440, 2400, 2880};
    const size_t n = list ? json_array_size(list) : sizeof rasters / sizeof rasters[0];
    for (size_t i = 0; i < n; i++)
        if (dpi == (list ? json_number_value(json_array_get(list, i)) : rasters[i]))
            return true;
    return false;
}

static void check_raster(lf_check *check)
{
    const json_t *list = natives_of(check);
    const bool native = is_native(list, check->dpi[0]) && is_native(list, check->dpi[1]);
    char limit[96];
    size_t used = 0;
    for (size_t i = 0; i < json_array_size(list) && used < sizeof limit; i++)
        used += (size_t)snprintf(limit + used, sizeof limit - used, "%s%.6g", i > 0 ? ", " : "",
                                 json_number_value(json_array_get(list, i)));
    if (list && used < sizeof limit)
        snprintf(limit + used, sizeof limit - used, " dpi, by the printer's profile");
    lf_check_say(check, CHECK_RASTER, native ? LF_CHECK_PASS : LF_CHECK_WARN,
                 list ? limit : "300, 360, 600, 720, 1200, 1440, 2400 or 2880 dpi",
                 list ? "The driver resamples this raster; print at one of the profile's."
                      : "Drivers resample other rasters, unless this is your printer's own.",
                 "%.10g x %.10g dpi", check->dpi[0], check->dpi[1]);
}

static void check_profile(lf_check *check)
{
    static const char limit[] = "the manifest's ICC profile, of the file's channels";
    const lf_print_tags *tags = check->tags;
    const char *problem = lf_print_file_profile_problem(check->file);
    const int samples = tags->photometric == 5 ? 4 : 3;
    if (tags->icc_bytes == 0)
        lf_check_say(check, CHECK_PROFILE, LF_CHECK_FAIL, limit, rewrite,
                     "there is no ICC profile in the file");
    else if (problem)
        lf_check_say(check, CHECK_PROFILE, LF_CHECK_FAIL, limit, rewrite, "%s", problem);
    else if (tags->samples - tags->extra_samples != samples)
        lf_check_say(check, CHECK_PROFILE, LF_CHECK_FAIL, limit, rewrite,
                     "%d channels, which do not match the colour space", tags->samples);
    else if (!check->same_profile)
        lf_check_say(check, CHECK_PROFILE, LF_CHECK_FAIL, limit, rewrite,
                     "the profile \"%.80s\" is not the manifest's", check->report->profile_name);
    else
        lf_check_say(check, CHECK_PROFILE, LF_CHECK_PASS, limit, NULL, "\"%.80s\", %s",
                     check->report->profile_name, samples == 4 ? "CMYK" : "RGB");
}

/* What is not plain about the raster; NULL: nothing. */
static const char *odd_storage(const lf_print_tags *tags)
{
    if (tags->compression == 6 || tags->compression == 7 || tags->compression == 34712)
        return "a compression with losses";
    if (tags->compression != 1 && tags->compression != 5 && tags->compression != 8 &&
        tags->compression != 32946)
        return "an unusual compression";
    if (tags->palette)
        return "a palette";
    if (tags->photometric == 6)
        return "luma and chroma instead of colours";
    if (tags->photometric != 2 && !(tags->photometric == 5 && tags->ink_set == 1))
        return "neither RGB nor CMYK";
    if (tags->extra_samples > 0)
        return "an alpha or extra channel";
    if (tags->planar != 1)
        return "one plane per channel";
    if (tags->orientation != 1)
        return "an orientation that turns or mirrors it";
    if (tags->bits != 8 && tags->bits != 16)
        return "neither 8 nor 16 bits";
    if (tags->sample_format != 1)
        return "values that are not whole numbers";
    if (tags->tiled)
        return "tiles";
    return tags->more_pages ? "more than one page" : NULL;
}

/* The manifest's words for what the file has. */
static bool stored_as_said(const lf_check *check, char *said, size_t size)
{
    static const struct {
        lf_compress compress;
        int tags[2];
        const char *name;
    } ways[] = {{LF_COMPRESS_NONE, {1, 1}, "no compression"},
                {LF_COMPRESS_LZW, {5, 5}, "LZW"},
                {LF_COMPRESS_DEFLATE, {8, 32946}, "deflate"}};
    const lf_print_tags *tags = check->tags;
    bool same = tags->bits == check->print.bits;
    if (lf_print_file_boxes(check->file)) { /* quiltrender's have no other compression */
        snprintf(said, size, "%d bits, deflate", tags->bits);
        return same;
    }
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++) {
        if (tags->compression == ways[i].tags[0] || tags->compression == ways[i].tags[1]) {
            snprintf(said, size, "%d bits, %s", tags->bits, ways[i].name);
            same = same && check->print.compress == ways[i].compress;
        }
    }
    return same;
}

void lf_check_tags(lf_check *check)
{
    static const char limit[] = "lossless, upright, no palette, no alpha, as in the manifest";
    const char *odd = odd_storage(check->tags), *why = lf_print_file_unreadable(check->file);
    const lf_print_boxes *boxes = lf_print_file_boxes(check->file);
    if (!odd && boxes && boxes->turned)
        odd = "a page that is turned or scaled";
    char said[64] = "";
    check_profile(check);
    if (odd || why)
        lf_check_say(check, CHECK_LOSSLESS, LF_CHECK_FAIL, limit, rewrite, "the file has %s",
                     odd ? odd : why);
    if (!check->known)
        return;
    check_size(check);
    check_resolution(check);
    check_raster(check);
    if (odd || why)
        return;
    const bool same = stored_as_said(check, said, sizeof said);
    lf_check_say(check, CHECK_LOSSLESS, same ? LF_CHECK_PASS : LF_CHECK_FAIL, limit, rewrite, "%s",
                 said);
}
