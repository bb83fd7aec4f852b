/* Finding the tags of a chart in a photo, by libapriltag. */
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include "base/alloc.h"
#include "quilt/chart/camera.h"

#define MOST_WRONG_BITS 1
#define LEAST_TAGS 4
#define LARGE_PX 2000 /* quads of larger photos are looked for at half the size */

typedef struct finder {
    apriltag_detector_t *detector;
    apriltag_family_t *family;
} finder;

static zarray_t *detect(finder *f, const lf_chart_grey *grey)
{
    f->detector = apriltag_detector_create();
    f->family = tag36h11_create();
    if (!f->detector || !f->family)
        return NULL;
    apriltag_detector_add_family_bits(f->detector, f->family, MOST_WRONG_BITS);
    f->detector->quad_decimate = grey->width > LARGE_PX || grey->height > LARGE_PX ? 2.0f : 1.0f;
    f->detector->nthreads = 1;
    /* it does not write into the image */
    image_u8_t image = {.width = grey->width,
                        .height = grey->height,
                        .stride = grey->width,
                        .buf = (uint8_t *)(uintptr_t)grey->data};
    return apriltag_detector_detect(f->detector, &image);
}

static void finish(finder *f, zarray_t *found)
{
    if (found)
        apriltag_detections_destroy(found);
    if (f->detector)
        apriltag_detector_destroy(f->detector);
    if (f->family)
        tag36h11_destroy(f->family);
}

static void take_tag(const lf_chart *chart, const apriltag_detection_t *tag, int i,
                     lf_chart_corners *out)
{
    static const int side[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}}; /* order of the library */
    double x, y;
    if (!lf_chart_tag_place(chart, i, &x, &y))
        return;
    for (int corner = 0; corner < 4; corner++) {
        const double length = (LF_CHART_TAG_CELLS - 2) * chart->cell;
        double *at = out->at[out->n], *px = out->px[out->n];
        for (int k = 0; k < 2; k++)
            out->side[out->n][k] = 2 * side[corner][k] - 1;
        at[0] = x + chart->cell + side[corner][0] * length;
        at[1] = y + chart->cell + side[corner][1] * length - 0.5 * chart->height;
        px[0] = tag->p[corner][0];
        px[1] = tag->p[corner][1];
        out->n++;
    }
    out->n_tags++;
}

/* Takes each tag of the chart once; returns the number of tags of other charts. */
static int take_tags(const lf_chart *chart, zarray_t *found, lf_chart_corners *out)
{
    bool taken[LF_CHART_TAGS] = {false};
    int n_other = 0;
    *out = (lf_chart_corners){0};
    for (int k = 0; k < zarray_size(found); k++) {
        apriltag_detection_t *tag;
        zarray_get(found, k, &tag);
        const int i = tag->id - chart->first_tag;
        if (i < 0 || i >= LF_CHART_TAGS) {
            n_other++;
            continue;
        }
        if (!taken[i])
            take_tag(chart, tag, i, out);
        taken[i] = true;
    }
    return n_other;
}

static lf_status look(const lf_chart *chart, const lf_chart_grey *grey, lf_chart_corners *out,
                      int *out_other)
{
    finder f = {0};
    zarray_t *found = detect(&f, grey);
    if (found)
        *out_other = take_tags(chart, found, out);
    finish(&f, found);
    return found ? LF_OK : LF_E_NOMEM;
}

static bool is_mirrored(const lf_chart *chart, const lf_chart_grey *grey)
{
    uint8_t *turned = lf_calloc((size_t)grey->width, (size_t)grey->height);
    lf_chart_corners corners = {0};
    int n_other = 0;
    if (!turned)
        return false;
    for (int y = 0; y < grey->height; y++)
        for (int x = 0; x < grey->width; x++)
            turned[(size_t)y * (size_t)grey->width + (size_t)x] =
                grey->data[(size_t)(y + 1) * (size_t)grey->width - 1 - (size_t)x];
    const lf_chart_grey mirrored = {grey->width, grey->height, turned};
    const lf_status status = look(chart, &mirrored, &corners, &n_other);
    lf_free(turned);
    return status == LF_OK && corners.n_tags > 0;
}

lf_status lf_chart_find_tags(const lf_chart *chart, const lf_chart_grey *grey, const char *where,
                             lf_chart_corners *out, lf_error *err)
{
    lf_chart_corners corners;
    int n_other = 0;
    if (look(chart, grey, &corners, &n_other) != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, where, "not enough memory to look for marks");
    if (corners.n_tags >= LEAST_TAGS) {
        *out = corners;
        return LF_OK;
    }
    if (corners.n_tags > 0)
        return lf_error_set(err, LF_E_FORMAT, where,
                            "only %d of the chart's marks are visible; at least %d are needed, so "
                            "show the whole chart",
                            corners.n_tags, LEAST_TAGS);
    if (n_other > 0)
        return lf_error_set(err, LF_E_FORMAT, where,
                            "the marks are those of another chart; give its manifest by "
                            "--chart-file");
    if (is_mirrored(chart, grey))
        return lf_error_set(err, LF_E_FORMAT, where,
                            "the photo is mirrored; turn it back, or print the chart without "
                            "--mirror");
    return lf_error_set(err, LF_E_FORMAT, where,
                        "no marks of a chart were found; show the whole chart, sharp and large");
}
