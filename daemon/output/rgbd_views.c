#include "daemon/output/rgbd_views.h"

#include <math.h>
#include <stdio.h>

lf_status lf_rgbd_layout(const lf_options *options, double aspect,
                         const lf_calibration *calibration, lf_layout *out, lf_error *err)
{
    /* only its aspect and its number of views count */
    const lf_camera camera = {.position = {0, 0, 1},
                              .up = {0, 1, 0},
                              .fov_y = 14 * M_PI / 180,
                              .aspect = aspect,
                              .depthiness = 1};
    lf_render_settings settings;
    return lf_resolve_view(options, &camera, calibration, &settings, out, err);
}

lf_status lf_rgbd_draw(const lf_rgbd_file *file, const char *name, const lf_options *options,
                       const lf_layout *layout, lf_quilt_file *out, lf_error *err)
{
    lf_pool *pool = NULL;
    lf_status status = lf_pool_create(options->threads, &pool);
    if (status != LF_OK)
        return lf_error_set(err, status, name, "cannot start the worker threads");
    status = lf_rgbd_file_draw(file, name, layout, pool, out, err);
    lf_pool_destroy(pool);
    return status;
}

lf_status lf_rgbd_stand(const lf_standing *standing, int threads, const char *name,
                        lf_quilt_file *quilt, lf_error *err)
{
    lf_pool *pool = NULL;
    if (lf_standing_is_plain(standing))
        return LF_OK;
    lf_status status = lf_pool_create(threads, &pool);
    if (status != LF_OK)
        return lf_error_set(err, status, name, "cannot start the worker threads");
    status = lf_quilt_stand(standing, name, quilt, pool, err);
    lf_pool_destroy(pool);
    return status;
}

/* Lenses across the picture. */
static double lenses_of(const lf_rgbd_file *file, const lf_print *print)
{
    lf_print laid = *print;
    laid.view_aspect = file->aspect;
    return lf_print_lenses(&laid);
}

/* At least the samples that the print shows, twice where the picture has them. */
static int samples(double shown, int there)
{
    return (int)fmax(1, fmin(2 * ceil(shown), fmax(ceil(shown), there)));
}

lf_layout lf_rgbd_print_layout(const lf_rgbd_file *file, const lf_print *print)
{
    const double lenses = lenses_of(file, print),
                 rows = print->dpi_down > 0 ? print->dpi_down : print->dpi,
                 down = lenses / print->lpi / file->aspect * rows;
    lf_layout layout = {.n_views = print->n_views, .aspect = file->aspect};
    layout.view_width = (int)fmin(samples(lenses, file->width), LF_MAX_VIEW_SIDE);
    layout.view_height = (int)fmax(1, fmin(fmin(file->height, ceil(down)), LF_MAX_VIEW_SIDE));
    lf_layout_tiles(layout.n_views, layout.view_width, layout.view_height, &layout.columns,
                    &layout.rows);
    return layout;
}

double lf_rgbd_print_depth(lf_rgbd_file *file, const lf_print *print)
{
    lf_rgbd natural = file->rgbd;
    natural.disparity = LF_RGBD_DISPARITY;
    natural.focus = 0;
    const double lenses = lenses_of(file, print) * file->rgbd.zoom,
                 step = lenses * lf_rgbd_step(&natural, print->n_views);
    /* a little more than needed, so that rounding does not exceed the limit */
    if (!file->rgbd.is_known && step > 1)
        file->rgbd.disparity /= step * (1 + 1e-9);
    return lenses * lf_rgbd_step(&file->rgbd, print->n_views);
}

char *lf_rgbd_print_words(const lf_rgbd *rgbd, double depthiness, double shift, char *buf,
                          size_t size)
{
    const double fits = depthiness / shift, digit = pow(10, floor(log10(fits)) - 1);
    char remedy[64];
    if (rgbd->focus == 0 && fits > 0)
        snprintf(remedy, sizeof remedy, "use --depthiness %.2g", floor(fits / digit) * digit);
    else
        snprintf(remedy, sizeof remedy, "use less --depthiness or --focus");
    snprintf(buf, size,
             "too deep for lenses: points shift by up to %.3g lenses between views (limit 1); %s",
             shift, remedy);
    return buf;
}
