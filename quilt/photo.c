#include "quilt/photo.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/axis.h"

/* Aspects closer than this are equal: file names round them. */
#define SLACK 1e-3

/* -------------------------------------------------------------------------------- parameters -- */

static const char *const modes[] = {[LF_PHOTO_FIT] = "fit", [LF_PHOTO_FILL] = "fill", NULL};
static const char *const turns[] = {
    [LF_TURN_NONE] = "0",  [LF_TURN_90] = "90",     [LF_TURN_180] = "180",
    [LF_TURN_270] = "270", [LF_TURN_AUTO] = "auto", NULL};

/* Fractions of the free space at the left and at the top. */
static const struct {
    const char *name;
    double left, top;
} positions[] = {{"center", 0.5, 0.5}, {"left", 0, 0.5},      {"right", 1, 0.5},
                 {"top", 0.5, 0},      {"bottom", 0.5, 1},    {"top-left", 0, 0},
                 {"top-right", 1, 0},  {"bottom-left", 0, 1}, {"bottom-right", 1, 1}};

enum { N_POSITIONS = sizeof positions / sizeof *positions };

static const char *position_at(int index)
{
    return index < N_POSITIONS ? positions[index].name : NULL;
}

#define PLACE(field) .place = offsetof(lf_photo, field)

/* clang-format off */
const lf_param lf_photo_params[] = {
    {.name = "photo", .option = "photo", .argument = "fit|fill", PLACE(mode),
     .type = LF_PARAM_WORD, .words = modes,
     .help = "image of another shape: whole with borders, or cut to cover the view",
     .about = "image of another shape: show it whole with borders, or cut it to cover the view"},
    {.name = "photo_position", .option = "photo-position", .argument = "WHERE", PLACE(position),
     .type = LF_PARAM_WORD, .word_at = position_at,
     .help = "position of the image, or the part of it that is kept"},
    {0},
};

const lf_param lf_picture_params[] = {
    {.name = "photo_rotate", .option = "photo-rotate", .argument = "DEGREES", PLACE(rotate),
     .type = LF_PARAM_WORD, .words = turns,
     .help = "turn each image clockwise; auto: by 90 if only one of image and output is upright"},
    {.name = "aspect", .option = "aspect", .argument = "A", PLACE(aspect), .low = 0.01, .high = 100,
     .help = "width / height of the views of a quilt or folder (from its name or pixels)",
     .about = "width / height of the views of a finished quilt or folder (from its name, images "
              "or pixels)"},
    {.name = "views", PLACE(n_views), .type = LF_PARAM_WHOLE, .low = 1, .high = 4096,
     .help = "number of views of a quilt image or video; further tiles are unused (all tiles)"},
    {0},
};
/* clang-format on */

/* ---------------------------------------------------------------------------------- geometry -- */

lf_photo_place lf_photo_lay(const lf_photo *photo, double aspect, double frame_width,
                            double frame_height, double slack_width, double slack_height)
{
    const double whole = fmin(frame_width, frame_height * aspect);
    const bool fits =
        frame_width - whole <= slack_width && frame_height - whole / aspect <= slack_height;
    const bool covers = fits || photo->mode == LF_PHOTO_FILL;
    lf_photo_place place = {.width = covers ? fmax(frame_width, frame_height * aspect) : whole};
    place.height = place.width / aspect;
    place.right = (frame_width - place.width) * (positions[photo->position].left - 0.5);
    place.down = (frame_height - place.height) * (positions[photo->position].top - 0.5);
    if (!covers && frame_width > frame_height * aspect)
        place.beside = frame_width - place.width;
    else if (!covers)
        place.above = frame_height - place.height;
    if (covers && !fits)
        place.cut = 1 - frame_width * frame_height / (place.width * place.height);
    return place;
}

int lf_photo_orientation(const lf_photo *photo, double aspect)
{
    static const int orientations[] = {
        [LF_TURN_NONE] = 1, [LF_TURN_90] = 6, [LF_TURN_180] = 3, [LF_TURN_270] = 8};
    if (photo->rotate != LF_TURN_AUTO)
        return orientations[photo->rotate];
    return photo->frame > 0 && (aspect - 1) * (photo->frame - 1) < 0 ? 6 : 1;
}

/* The whole number of pixels to keep for a fraction `part`, starting at *first. */
static int kept(int n, double part, double share, int *first)
{
    const int keep = (int)fmin(fmax(round(n * part), 1), n);
    *first = (int)lround((n - keep) * share);
    return keep;
}

/* Leaves out the views of unused tiles. */
static void leave_out(int n_views, lf_quilt_file *quilt)
{
    if (n_views == 0 || n_views >= quilt->layout.n_views)
        return;
    quilt->layout.n_views = n_views;
    if (quilt->is_float)
        quilt->views32.n_views = n_views;
    else
        quilt->views8.n_views = n_views;
}

void lf_photo_cut(const lf_photo *photo, lf_quilt_file *quilt)
{
    lf_layout *l = &quilt->layout;
    int x, y;
    leave_out(photo->n_views, quilt);
    if (!(photo->frame > 0))
        return;
    const lf_photo_place place =
        lf_photo_lay(photo, l->aspect, photo->frame, 1, SLACK * photo->frame, SLACK);
    if (photo->position != 0 && (place.beside > 0 || place.above > 0))
        lf_image_note(&quilt->notes, "the photo position is ignored because a panel shows whole "
                                     "images in its centre; use photo fill to crop");
    if (!(place.cut > 0))
        return;
    lf_image_note(&quilt->notes,
                  "%.0f %% of the image (aspect %.4g) is cropped for the aspect %.4g (photo fit "
                  "shows it whole)",
                  100 * place.cut, l->aspect, photo->frame);
    l->view_width =
        kept(l->view_width, photo->frame / place.width, positions[photo->position].left, &x);
    l->view_height = kept(l->view_height, 1 / place.height, positions[photo->position].top, &y);
    l->aspect = photo->frame;
    if (quilt->is_float) {
        quilt->views32.data += (size_t)y * quilt->views32.row_stride + 3 * (size_t)x;
        quilt->views32.width = l->view_width;
        quilt->views32.height = l->view_height;
    } else {
        quilt->views8.data += (size_t)y * quilt->views8.row_stride + 3 * (size_t)x;
        quilt->views8.width = l->view_width;
        quilt->views8.height = l->view_height;
    }
}

/* ----------------------------------------------------------------------------------- scaling -- */

/* Sets up the axis for a picture of n_in samples on its part of n_out samples. */
static lf_status init_axis(lf_axis_filter *filter, int n_in, int n_out, double frame,
                           double picture, double offset, double border)
{
    const double scale = n_in / picture, step = frame / n_out;
    lf_status status = lf_axis_filter_init(
        filter, n_in, n_out, (0.5 * step - 0.5 * frame - offset + 0.5 * picture) * scale,
        step * scale, step * scale);
    for (int i = 0; i < n_out && status == LF_OK && !(border > 0); i++)
        filter->inside[i] = 1;
    return status;
}

static void add_row(const lf_photo_picture *p, int y, const float light[256], float weight,
                    float *line)
{
    const size_t n = 3 * (size_t)p->width, at = (size_t)y * n;
    for (size_t i = 0; i < n; i++)
        line[i] += weight * (p->data32 ? p->data32[at + i] : light[p->data8[at + i]]);
}

static void draw_row(const lf_photo_picture *p, const lf_axis_filter *columns,
                     const lf_axis_filter *rows, int y, const float light[256], float border,
                     float *line, float *out)
{
    const float *weight = rows->weight + (size_t)y * (size_t)rows->max_taps;
    memset(line, 0, 3 * (size_t)p->width * sizeof *line);
    for (int t = 0; t < rows->n_taps[y]; t++)
        add_row(p, rows->first[y] + t, light, weight[t], line);
    lf_axis_filter_line(columns, line, out);
    for (int x = 0; x < columns->n_out; x++) {
        const float inside = columns->inside[x] * rows->inside[y];
        for (int c = 0; c < 3; c++)
            out[3 * x + c] = inside * out[3 * x + c] + (1 - inside) * border;
    }
}

lf_status lf_photo_draw(const lf_photo_picture *p, const lf_photo_place *place,
                        const lf_layout *view, float border, uint8_t *out8, float *out32)
{
    const size_t n = 3 * (size_t)view->view_width;
    float light[256];
    lf_axis_filter columns = {0}, rows = {0};
    lf_tone *tone = NULL;
    float *line = lf_calloc((size_t)p->width, 3 * sizeof *line), *row = lf_calloc(n, sizeof *row);
    lf_status status = line && row ? lf_tone_create(0, "srgb", &tone, NULL) : LF_E_NOMEM;
    if (status == LF_OK)
        status = init_axis(&columns, p->width, view->view_width, view->aspect, place->width,
                           place->right, place->beside);
    if (status == LF_OK)
        status = init_axis(&rows, p->height, view->view_height, 1, place->height, place->down,
                           place->above);
    lf_srgb_light(light);
    for (int y = 0; y < view->view_height && status == LF_OK; y++) {
        float *to = out32 ? out32 + (size_t)y * n : row;
        draw_row(p, &columns, &rows, y, light, border, line, to);
        if (out8)
            lf_tone_map(tone, (size_t)view->view_width, to, out8 + (size_t)y * n);
    }
    lf_axis_filter_finish(&columns);
    lf_axis_filter_finish(&rows);
    lf_tone_destroy(tone);
    lf_free(row);
    lf_free(line);
    return status;
}

static lf_status shrink(const lf_photo_picture *picture, int width, int height, uint8_t *out8,
                        float *out32)
{
    const lf_photo_place whole = {.width = 1, .height = 1};
    const lf_layout to = {.view_width = width, .view_height = height, .aspect = 1};
    assert(picture->data8 || picture->data32);
    return lf_photo_draw(picture, &whole, &to, 0, out8, out32);
}

lf_status lf_view_shrink(const lf_views8 *views, int view, int width, int height, uint8_t *out)
{
    const lf_photo_picture picture = {views->width, views->height, 1, lf_views8_row(views, view, 0),
                                      NULL};
    return shrink(&picture, width, height, out, NULL);
}

lf_status lf_view_shrink32(const lf_views32 *views, int view, int width, int height, float *out)
{
    const lf_photo_picture picture = {views->width, views->height, 1, NULL,
                                      lf_views32_row(views, view, 0)};
    return shrink(&picture, width, height, NULL, out);
}
