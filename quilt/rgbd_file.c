/* Pictures with depth from files and descriptors. */
#include <string.h>

#include "base/alloc.h"
#include "quilt/photo.h"
#include "quilt/rgbd.h"

/* Views of more bytes are refused. */
#define MOST_BYTES ((size_t)1 << 31)

static lf_status check_look(const char *name, lf_rgbd_file *file, lf_error *err)
{
    const lf_rgbd_look look = lf_rgbd_look_at(&file->rgbd, &file->picture);
    if (look.is_flat && !file->rgbd.is_known) /* otherwise it is a plane */
        return lf_error_set(err, LF_E_FORMAT, name,
                            "has no depth: its depth half has one colour; pass rgbd_in off, or "
                            "the side of the depth");
    if (look.is_coloured)
        lf_image_note(&file->notes, "%s",
                      file->rgbd.is_hue
                          ? "the depth half is grey, but chroma_depth reads its hue; it may not be "
                            "depth by hue"
                          : "the depth half has colours; it may not be depth (chroma_depth on "
                            "reads depth by hue)");
    return LF_OK;
}

/* Turns both halves of this size; they then lie one below the other. */
static lf_status turn(int orientation, int width, int height, lf_rgbd_file *file)
{
    lf_rgbd_picture *p = &file->picture;
    const lf_rgbd_in side = file->rgbd.side;
    const bool swaps = lf_orientation_swaps(orientation),
               depth_first = side == LF_RGBD_IN_LEFT || side == LF_RGBD_IN_TOP;
    file->width = swaps ? height : width;
    file->height = swaps ? width : height;
    if (orientation == 1)
        return LF_OK;
    file->turned = lf_calloc((size_t)p->width * (size_t)p->height, 3);
    if (!file->turned)
        return LF_E_NOMEM;
    const uint8_t *first = p->data,
                  *second = p->data +
                            (width == p->width ? (size_t)height * p->stride : (size_t)width * 3);
    lf_orient(orientation, depth_first ? second : first, p->stride, width, height, 3, file->turned);
    lf_orient(orientation, depth_first ? first : second, p->stride, width, height, 3,
              file->turned + 3 * (size_t)width * (size_t)height);
    *p = (lf_rgbd_picture){.width = file->width,
                           .height = 2 * file->height,
                           .stride = 3 * (size_t)file->width,
                           .data = file->turned,
                           .pixel_aspect = swaps ? 1 / p->pixel_aspect : p->pixel_aspect};
    file->rgbd.side = LF_RGBD_IN_BOTTOM;
    return LF_OK;
}

lf_status lf_rgbd_file_take(const lf_raster *raster, const char *name, const lf_standing *standing,
                            lf_rgbd_in side, const lf_photo *photo, lf_rgbd_file *out,
                            lf_error *err)
{
    lf_rgbd_file file = {.rgbd = lf_rgbd_of(standing, side, &raster->meta),
                         .picture = {.width = raster->width,
                                     .height = raster->height,
                                     .stride = 3 * (size_t)raster->width,
                                     .data = raster->data8,
                                     .pixel_aspect = raster->meta.pixel_aspect}};
    int width, height;
    lf_status status = lf_standing_check(standing, name, err);
    if (status == LF_OK && !raster->data8)
        status = lf_error_set(err, LF_E_FORMAT, name,
                              "an image with depth must be PNG or JPEG, not EXR or HDR");
    if (status == LF_OK)
        status = lf_rgbd_size(side, raster->width, raster->height, name, &width, &height, err);
    if (status == LF_OK && lf_rgbd_tiles(&raster->meta.depth, width, height) > 1)
        status = lf_error_set(err, LF_E_FORMAT, name,
                              "is a quilt of %d views with depth; write one view with --rgbd-of "
                              "middle",
                              lf_rgbd_tiles(&raster->meta.depth, width, height));
    if (file.rgbd.is_flattened)
        lf_image_note(&file.notes, "is too deep for its views, and is drawn with less depth; use a "
                                   "smaller cone");
    lf_image_note_lines(&file.notes, raster->meta.notes.text, raster->meta.notes.length);
    if (status == LF_OK)
        status = check_look(name, &file, err);
    if (status != LF_OK)
        return status;
    const double pixel = raster->meta.pixel_aspect > 0 ? raster->meta.pixel_aspect : 1;
    double aspect = photo->aspect > 0 ? photo->aspect : (double)width / height * pixel;
    file.picture.pixel_aspect = aspect * height / width;
    file.rgbd.photo = *photo;
    const int orientation = lf_photo_orientation(photo, aspect);
    file.aspect = lf_orientation_swaps(orientation) ? 1 / aspect : aspect;
    lf_rgbd_turn(&file.rgbd, orientation, aspect);
    if (turn(orientation, width, height, &file) != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, name, "not enough memory for the image");
    *out = file;
    return LF_OK;
}

lf_status lf_rgbd_file_open(const char *path, const lf_roots *roots, const lf_standing *standing,
                            lf_rgbd_in side, const lf_photo *photo, lf_rgbd_file *out,
                            lf_error *err)
{
    lf_raster raster = {0};
    lf_status status = lf_raster_open(path, roots, false, &raster, err);
    if (status == LF_OK)
        status = lf_rgbd_file_take(&raster, path, standing, side, photo, out, err);
    if (status == LF_OK)
        out->raster = raster;
    else
        lf_raster_close(&raster);
    return status;
}

lf_status lf_rgbd_file_draw(const lf_rgbd_file *file, const char *name, const lf_layout *layout,
                            lf_pool *pool, lf_quilt_file *out, lf_error *err)
{
    const size_t row = 3 * (size_t)layout->view_width, view = row * (size_t)layout->view_height;
    if ((size_t)layout->n_views > MOST_BYTES / view)
        return lf_error_set(err, LF_E_ARG, name,
                            "%d views of %dx%d pixels need more than 2 GiB; use fewer or smaller "
                            "views",
                            layout->n_views, layout->view_width, layout->view_height);
    uint8_t *data = lf_calloc((size_t)layout->n_views, view);
    if (!data)
        return lf_error_set(err, LF_E_NOMEM, name, "not enough memory for %d views",
                            layout->n_views);
    lf_status status = lf_rgbd_views(&file->rgbd, &file->picture, layout, pool, name, data, err);
    if (status != LF_OK) {
        lf_free(data);
        return status;
    }
    *out = (lf_quilt_file){
        .layout = *layout,
        .image8 = {.width = layout->view_width,
                   .height = layout->view_height * layout->n_views,
                   .channels = 3,
                   .stride = row,
                   .data = data},
        .views8 = {layout->n_views, layout->view_width, layout->view_height, view, row, data},
        .notes = file->notes};
    return LF_OK;
}

void lf_rgbd_file_close(lf_rgbd_file *file)
{
    lf_free(file->turned);
    lf_raster_close(&file->raster);
    *file = (lf_rgbd_file){0};
}
