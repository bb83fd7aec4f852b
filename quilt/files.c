#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "quilt/photo.h"

#define MAX_FOLDER_VIEWS 4096
#define MAX_SAMPLES ((size_t)1 << 31)
/* Deflate's fastest level: noisy quilts hardly shrink more at higher ones, and the simulated panel
 * writes them live. */
#define PNG_LEVEL 1

/* A passed path is a file, whatever is on disk under its name. */
static bool is_folder(const char *path, const lf_roots *roots)
{
    struct stat st;
    return !(roots && lf_passed_has(roots->passed, path)) && stat(path, &st) == 0 &&
           S_ISDIR(st.st_mode);
}

bool lf_is_quilt(const char *path, const lf_roots *roots)
{
    lf_image_kind kind;
    return is_folder(path, roots) || lf_image_probe(path, roots, &kind, NULL) == LF_OK;
}

/* ------------------------------------------------------------------------------------- views -- */

/* Allocates the views in a column, view 0 first. It may be taller than pictures are allowed to be,
 * as it is never used as one. */
static lf_status allocate_views(lf_quilt_file *q, const char *where, lf_error *err)
{
    const lf_layout *l = &q->layout;
    size_t row = (size_t)l->view_width * 3, n_rows = (size_t)l->view_height * (size_t)l->n_views;
    size_t view = row * (size_t)l->view_height;
    if (n_rows > MAX_SAMPLES / row)
        return lf_error_set(
            err, LF_E_FORMAT, where,
            "%d views of %dx%d pixels have more than 2^31 samples; use fewer or smaller views",
            l->n_views, l->view_width, l->view_height);
    void *data = lf_calloc(n_rows * row, q->is_float ? sizeof(float) : 1);
    if (!data)
        return lf_error_set(err, LF_E_NOMEM, where, "not enough memory for %d views", l->n_views);
    if (q->is_float) {
        q->image32 = (lf_image32){
            .width = l->view_width, .height = (int)n_rows, .channels = 3, .data = data};
        q->views32 = (lf_views32){.n_views = l->n_views,
                                  .width = l->view_width,
                                  .height = l->view_height,
                                  .view_stride = view,
                                  .row_stride = row,
                                  .data = data};
    } else {
        q->image8 = (lf_image8){.width = l->view_width,
                                .height = (int)n_rows,
                                .channels = 3,
                                .stride = row,
                                .data = data};
        q->views8 = (lf_views8){l->n_views, l->view_width, l->view_height, view, row, data};
    }
    return LF_OK;
}

/* Copies the part of a picture at (x, y), rotated, to a view. */
static void take_view(lf_quilt_file *q, int view, const lf_raster *p, int x, int y, int orientation)
{
    const lf_layout *l = &q->layout;
    const bool swaps = lf_orientation_swaps(orientation);
    const int width = swaps ? l->view_height : l->view_width,
              height = swaps ? l->view_width : l->view_height;
    const size_t row = (size_t)p->width * 3, from = (size_t)y * row + (size_t)x * 3,
                 to = (size_t)view * (size_t)width * (size_t)height * 3;
    if (q->is_float)
        lf_orient(orientation, p->data32 + from, row * sizeof(float), width, height,
                  3 * sizeof(float), q->image32.data + to);
    else
        lf_orient(orientation, p->data8 + from, row, width, height, 3, q->image8.data + to);
}

void lf_quilt_finish(lf_quilt_file *q)
{
    lf_image8_finish(&q->image8);
    lf_image32_finish(&q->image32);
    *q = (lf_quilt_file){0};
}

/* ------------------------------------------------------------------------------------- quilt -- */

/* Applies the rotation to the shape of a view. */
static void turn_layout(lf_layout *l, int orientation)
{
    const int width = l->view_width;
    if (!lf_orientation_swaps(orientation))
        return;
    l->view_width = l->view_height;
    l->view_height = width;
    l->aspect = 1 / l->aspect;
}

/* The aspect when displayed. */
static double aspect_of(int width, int height, const lf_raster *p)
{
    return (double)width / height * (p->meta.pixel_aspect > 0 ? p->meta.pixel_aspect : 1);
}

/* Sets the shape of the views and the orientation by which they are rotated. */
static lf_status shape_quilt(const char *path, const lf_raster *p, const lf_photo *photo,
                             lf_quilt_file *q, int *out_orientation, lf_error *err)
{
    lf_layout *l = &q->layout;
    if (p->width < l->columns || p->height < l->rows)
        return lf_error_set(err, LF_E_FORMAT, path, "%dx%d pixels are too few for %dx%d views",
                            p->width, p->height, l->columns, l->rows);
    if (l->n_views == 0)
        l->n_views = l->columns * l->rows;
    l->view_width = p->width / l->columns;
    l->view_height = p->height / l->rows;
    if (photo->aspect > 0)
        l->aspect = photo->aspect;
    if (!(l->aspect > 0))
        l->aspect = aspect_of(l->view_width, l->view_height, p);
    *out_orientation = lf_photo_orientation(photo, l->aspect);
    turn_layout(l, *out_orientation);
    return LF_OK;
}

static lf_status cut_quilt(const char *path, const lf_raster *p, const lf_photo *photo,
                           lf_quilt_file *q, lf_error *err)
{
    const lf_layout *l = &q->layout;
    int orientation = 1;
    lf_status status = shape_quilt(path, p, photo, q, &orientation, err);
    if (status != LF_OK)
        return status;
    const int width = p->width / l->columns, height = p->height / l->rows;
    q->is_float = p->data32;
    q->frame_rate = p->meta.frame_rate;
    status = allocate_views(q, path, err);
    for (int view = 0; view < l->n_views && status == LF_OK; view++)
        take_view(q, view, p, view % l->columns * width,
                  p->height - (view / l->columns + 1) * height, orientation);
    return status;
}

lf_status lf_quilt_tiles_check(const lf_quilt_tiles *tiles, int width, int height,
                               const char *where, lf_error *err)
{
    return width % tiles->columns == 0 && height % tiles->rows == 0
               ? LF_OK
               : lf_error_set(err, LF_E_ARG, where,
                              "%dx%d tiles do not divide %dx%d pixels; expected a width and height "
                              "that are multiples of columns and rows",
                              tiles->columns, tiles->rows, width, height);
}

lf_status lf_quilt_cut(const lf_raster *picture, const char *name, const lf_quilt_tiles *tiles,
                       const lf_photo *photo, lf_quilt_file *out, lf_error *err)
{
    lf_quilt_file q = {
        .layout = {.columns = tiles->columns, .rows = tiles->rows, .n_views = tiles->n_views}};
    lf_error why;
    if (lf_quilt_tiles_check(tiles, picture->width, picture->height, name, &why) != LF_OK)
        return lf_error_set(err, LF_E_FORMAT, name, "%s", why.what);
    lf_status status = cut_quilt(name, picture, photo, &q, err);
    lf_image_note_lines(&q.notes, picture->meta.notes.text, picture->meta.notes.length);
    if (status == LF_OK)
        *out = q;
    else
        lf_quilt_finish(&q);
    return status;
}

/* Refuses a name without tiles; shows a suffix that only starts like one. */
static lf_status refuse_name(const char *path, lf_error *err)
{
    const char *slash = strrchr(path, '/'), *part = strstr(slash ? slash : path, "_qs");
    if (part && part[3] >= '0' && part[3] <= '9')
        return lf_error_set(err, LF_E_ARG, path,
                            "\"%.40s\" in the file name is not a quilt suffix such as _qs8x6a0.75; "
                            "rename the file or pass --quilt COLUMNSxROWS (scene.load: quilt)",
                            part);
    return lf_error_set(err, LF_E_ARG, path,
                        "the file name has no quilt suffix such as _qs8x6a0.75; rename it or pass "
                        "--quilt COLUMNSxROWS (scene.load: quilt), 1x1 for one view");
}

/* Notes that a requested layout fits neither the name (0: says none) nor the image. */
static void note_layout(lf_quilt_file *q, int named_columns, int named_rows, const lf_raster *p)
{
    const lf_layout *l = &q->layout;
    const int beside = p->width % l->columns, above = p->height % l->rows;
    if (named_columns > 0 && (named_columns != l->columns || named_rows != l->rows))
        lf_image_note(&q->notes, "is cut into %dx%d views, but its name says %dx%d", l->columns,
                      l->rows, named_columns, named_rows);
    if (beside > 0 || above > 0)
        lf_image_note(&q->notes,
                      "%dx%d pixels are no multiple of %dx%d views; %d columns at the right and %d "
                      "rows at the top are left out",
                      p->width, p->height, l->columns, l->rows, beside, above);
}

/* Finds the tiles of a quilt: as requested, otherwise from its name. */
static lf_status find_tiles(const char *path, int columns, int rows, lf_layout *named,
                            lf_layout *out, lf_error *err)
{
    const bool has_name = lf_layout_from_name(path, &named->columns, &named->rows, &named->aspect);
    if (columns == 0 || rows == 0) {
        if (!has_name)
            return refuse_name(path, err);
        columns = named->columns;
        rows = named->rows;
    }
    *out = (lf_layout){.columns = columns, .rows = rows, .aspect = named->aspect};
    return LF_OK;
}

static lf_status read_quilt(const char *path, const lf_roots *roots, int columns, int rows,
                            const lf_photo *photo, lf_quilt_file *q, lf_error *err)
{
    lf_layout named = {0};
    lf_status status = find_tiles(path, columns, rows, &named, &q->layout, err);
    if (status != LF_OK)
        return status;
    lf_raster p = {0};
    status = photo->on_paper ? lf_raster_open_on_white(path, roots, &p, err)
                             : lf_raster_open(path, roots, false, &p, err);
    if (status == LF_OK)
        status = cut_quilt(path, &p, photo, q, err);
    if (status == LF_OK && columns > 0 && rows > 0)
        note_layout(q, named.columns, named.rows, &p);
    lf_image_note_lines(&q->notes, p.meta.notes.text, p.meta.notes.length);
    lf_raster_close(&p);
    return status;
}

lf_status lf_quilt_plan(const char *path, int columns, int rows, const lf_raster *size,
                        const lf_photo *photo, lf_quilt_file *out, int *out_orientation,
                        lf_error *err)
{
    lf_quilt_file q = {0};
    lf_layout named = {0}, *l = &q.layout;
    lf_status status = find_tiles(path, columns, rows, &named, l, err);
    if (status == LF_OK)
        status = shape_quilt(path, size, photo, &q, out_orientation, err);
    if (status != LF_OK)
        return status;
    if (columns > 0 && rows > 0)
        note_layout(&q, named.columns, named.rows, size);
    const size_t row = (size_t)l->view_width * 3;
    q.views8 = (lf_views8){l->n_views, l->view_width, l->view_height, row * (size_t)l->view_height,
                           row,        NULL};
    *out = q;
    return LF_OK;
}

/* ------------------------------------------------------------------------------------ folder -- */

typedef struct name_list {
    char **names;
    int n;
} name_list;

static void name_list_finish(name_list *list)
{
    for (int i = 0; i < list->n; i++)
        lf_free(list->names[i]);
    lf_free(list->names);
}

/* Sorts view_999 before view_1000. */
static int by_name(const void *a, const void *b)
{
    return strverscmp(*(char *const *)a, *(char *const *)b);
}

/* Lists the folder that was checked, whatever its name leads to now. */
static lf_status open_folder(const char *folder, const lf_roots *roots, DIR **out, lf_error *err)
{
    int fd;
    lf_status status = lf_roots_open_folder(roots, folder, &fd, err);
    if (status != LF_OK)
        return status;
    *out = fdopendir(fd);
    if (*out)
        return LF_OK;
    close(fd);
    return lf_error_set(err, LF_E_NOMEM, folder, "no memory");
}

static lf_status list_pictures(const char *folder, const lf_roots *roots, name_list *list,
                               lf_error *err)
{
    DIR *dir;
    lf_status status = open_folder(folder, roots, &dir, err);
    if (status != LF_OK)
        return status;
    list->names = lf_calloc(MAX_FOLDER_VIEWS, sizeof *list->names);
    if (!list->names)
        status = lf_error_set(err, LF_E_NOMEM, folder, "no memory");
    const struct dirent *entry;
    while (status == LF_OK && (entry = readdir(dir))) {
        if (entry->d_name[0] == '.' || !lf_image_ending(entry->d_name))
            continue;
        if (list->n == MAX_FOLDER_VIEWS)
            status = lf_error_set(err, LF_E_FORMAT, folder, "the folder has more than %d images",
                                  MAX_FOLDER_VIEWS);
        else if (!(list->names[list->n] = lf_path_join(folder, entry->d_name)))
            status = lf_error_set(err, LF_E_NOMEM, folder, "no memory");
        else
            list->n++;
    }
    closedir(dir);
    if (status == LF_OK && list->n == 0)
        return lf_error_set(err, LF_E_FORMAT, folder,
                            "the folder has no images; expected one per view");
    if (status == LF_OK)
        qsort(list->names, (size_t)list->n, sizeof *list->names, by_name);
    return status;
}

/* The picture of a folder with the largest value, and their number. */
typedef struct most {
    int n;
    double by;
    char name[64];
} most;

/* State of reading a folder. */
typedef struct folder {
    const char *path;
    const lf_roots *roots;
    name_list list;
    lf_photo photo; /* its frame is the first picture's if there is no other */
    lf_quilt_file *q;
    int width, height;  /* size of the first picture as stored */
    int n_odd;          /* pictures of another size */
    char odd[200];      /* their names and sizes */
    bool odd_is_full;   /* not all are listed */
    most cut, up, down; /* fractions cut; scales and inverse scales over 2 */
} folder;

static lf_status begin_folder(folder *f, const lf_raster *first, double aspect, lf_error *err)
{
    const int orientation = lf_photo_orientation(&f->photo, aspect);
    lf_quilt_file *q = f->q;
    q->is_float = first->data32;
    q->layout = (lf_layout){.n_views = f->list.n,
                            .view_width = first->width,
                            .view_height = first->height,
                            .aspect = aspect};
    turn_layout(&q->layout, orientation);
    f->width = first->width;
    f->height = first->height;
    if (!(f->photo.frame > 0))
        f->photo.frame = q->layout.aspect;
    lf_layout_tiles(f->list.n, q->layout.view_width, q->layout.view_height, &q->layout.columns,
                    &q->layout.rows);
    return allocate_views(q, f->path, err);
}

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static void count(most *m, const char *name, double by)
{
    m->n++;
    if (by > m->by) {
        m->by = by;
        snprintf(m->name, sizeof m->name, "%s", name);
    }
}

/* Records a picture of another size, and how much of it is cut. */
static void count_odd(folder *f, const char *path, const lf_raster *p,
                      const lf_photo_picture *turned, const lf_photo_place *place)
{
    const size_t used = strlen(f->odd);
    const char *name = base_name(path);
    const double scale = place->height * f->q->layout.view_height / turned->height;
    const int n = snprintf(f->odd + used, sizeof f->odd - used, "%s%.60s (%dx%d)", used ? ", " : "",
                           name, p->width, p->height);
    if (n < 0 || (size_t)n >= sizeof f->odd - used) {
        f->odd[used] = '\0';
        f->odd_is_full = true;
    }
    f->n_odd++;
    if (place->cut > 0)
        count(&f->cut, name, place->cut);
    if (scale > 2)
        count(&f->up, name, scale);
    if (scale < 0.5)
        count(&f->down, name, 1 / scale);
}

/* Added before the files' own notes, which may exceed the space. */
static void note_folder(const folder *f)
{
    lf_image_notes *notes = &f->q->notes, meta = *notes;
    if (f->n_odd == 0)
        return;
    notes->length = 0;
    lf_image_note(
        notes, "%d of %d images do not have the %dx%d pixels of %.60s: %s%s; they are scaled %s",
        f->n_odd, f->list.n, f->width, f->height, base_name(f->list.names[0]), f->odd,
        f->odd_is_full ? " ..." : "",
        f->photo.mode == LF_PHOTO_FIT ? "to fit, with borders (photo fill crops them instead)"
                                      : "and cropped (photo fit shows them whole)");
    if (f->cut.n > 0)
        lf_image_note(notes, "%d of them are cropped, %s most, by %.0f %%", f->cut.n, f->cut.name,
                      100 * f->cut.by);
    if (f->up.n > 0)
        lf_image_note(notes, "%d of them are scaled up by more than 2, %s most, by %.3g", f->up.n,
                      f->up.name, f->up.by);
    if (f->down.n > 0)
        lf_image_note(notes, "%d of them are scaled down by more than 2, %s most, by %.3g",
                      f->down.n, f->down.name, f->down.by);
    lf_image_note_lines(notes, meta.text, meta.length);
}

/* Scales a picture of another size than the first; shape: after rotation. */
static lf_status scale_picture(folder *f, int view, const lf_raster *p, const lf_layout *shape,
                               int orientation, lf_error *err)
{
    const lf_layout *l = &f->q->layout;
    const char *name = f->list.names[view];
    const size_t pixel = 3 * (p->data32 ? sizeof(float) : 1),
                 to = (size_t)view * (size_t)l->view_width * (size_t)l->view_height * 3;
    const void *in = p->data32 ? (const void *)p->data32 : p->data8;
    void *turned = lf_calloc((size_t)p->width * (size_t)p->height, pixel);
    if (!turned)
        return lf_error_set(err, LF_E_NOMEM, name, "not enough memory for the image");
    lf_orient(orientation, in, (size_t)p->width * pixel, p->width, p->height, pixel, turned);
    const lf_photo_picture picture = {.width = shape->view_width,
                                      .height = shape->view_height,
                                      .aspect = shape->aspect,
                                      .data8 = p->data32 ? NULL : turned,
                                      .data32 = p->data32 ? turned : NULL};
    const lf_photo_place place = lf_photo_lay(&f->photo, picture.aspect, l->aspect, 1,
                                              l->aspect / l->view_width, 1.0 / l->view_height);
    count_odd(f, name, p, &picture, &place);
    lf_status status = lf_photo_draw(&picture, &place, l, f->photo.on_paper ? 1 : 0,
                                     f->q->is_float ? NULL : f->q->image8.data + to,
                                     f->q->is_float ? f->q->image32.data + to : NULL);
    lf_free(turned);
    return status == LF_OK ? status
                           : lf_error_set(err, status, name, "not enough memory for the image");
}

static lf_status take_raster(folder *f, int view, const lf_raster *p, lf_error *err)
{
    const double aspect = f->photo.aspect > 0 ? f->photo.aspect : aspect_of(p->width, p->height, p);
    lf_status status = view == 0 ? begin_folder(f, p, aspect, err) : LF_OK;
    if (status == LF_OK && !p->data32 == f->q->is_float)
        return lf_error_set(err, LF_E_FORMAT, f->list.names[view],
                            "the folder mixes 8-bit and floating-point images; use one kind, or "
                            "show them in turn with quiltd --playlist");
    if (status != LF_OK)
        return status;
    const int orientation = lf_photo_orientation(&f->photo, aspect);
    lf_layout turned = {.view_width = p->width, .view_height = p->height, .aspect = aspect};
    turn_layout(&turned, orientation);
    const lf_layout *l = &f->q->layout;
    if (turned.view_width != l->view_width || turned.view_height != l->view_height ||
        fabs(turned.aspect / l->aspect - 1) > 1e-3)
        return scale_picture(f, view, p, &turned, orientation, err);
    take_view(f->q, view, p, 0, 0, orientation);
    return LF_OK;
}

static lf_status take_picture(folder *f, int view, lf_error *err)
{
    lf_raster p = {0};
    const char *name = f->list.names[view];
    lf_status status = f->photo.on_paper ? lf_raster_open_on_white(name, f->roots, &p, err)
                                         : lf_raster_open(name, f->roots, false, &p, err);
    if (status == LF_OK)
        status = take_raster(f, view, &p, err);
    lf_image_note_lines(&f->q->notes, p.meta.notes.text, p.meta.notes.length);
    lf_raster_close(&p);
    return status;
}

static lf_status read_folder(const char *path, const lf_roots *roots, const lf_photo *photo,
                             lf_quilt_file *q, lf_error *err)
{
    folder f = {.path = path, .roots = roots, .photo = *photo, .q = q};
    lf_status status = list_pictures(path, roots, &f.list, err);
    for (int view = 0; view < f.list.n && status == LF_OK; view++)
        status = take_picture(&f, view, err);
    if (status == LF_OK)
        note_folder(&f);
    name_list_finish(&f.list);
    return status;
}

lf_status lf_quilt_read_photo(const char *path, const lf_roots *roots, int columns, int rows,
                              const lf_photo *photo, lf_quilt_file *out, lf_error *err)
{
    static const lf_photo plain = {0};
    const lf_photo *how = photo ? photo : &plain;
    lf_quilt_file q = {0};
    lf_status status = is_folder(path, roots)
                           ? read_folder(path, roots, how, &q, err)
                           : read_quilt(path, roots, columns, rows, how, &q, err);
    if (status == LF_OK)
        *out = q;
    else
        lf_quilt_finish(&q);
    return status;
}

lf_status lf_quilt_read(const char *path, const lf_roots *roots, int columns, int rows,
                        lf_quilt_file *out, lf_error *err)
{
    return lf_quilt_read_photo(path, roots, columns, rows, NULL, out, err);
}

/* ------------------------------------------------------------------------------------- write -- */

typedef struct quilt_rows8 {
    const lf_views8 *views;
    const lf_layout *layout;
} quilt_rows8;

typedef struct quilt_rows32 {
    const lf_views32 *views;
    const lf_layout *layout;
} quilt_rows32;

/* The view in a tile column of the quilt's picture row y, -1 if the tile is empty; *row: the row in
 * the view. */
static int view_at(const lf_layout *l, int y, int column, int *row)
{
    *row = y % l->view_height;
    int view = (l->rows - 1 - y / l->view_height) * l->columns + column;
    return view < l->n_views ? view : -1;
}

void lf_quilt_row8(const lf_views8 *views, const lf_layout *layout, int y, uint8_t *out)
{
    size_t n = (size_t)layout->view_width * 3;
    for (int column = 0; column < layout->columns; column++, out += n) {
        int row, view = view_at(layout, y, column, &row);
        if (view < 0)
            memset(out, 0, n);
        else
            memcpy(out, lf_views8_row(views, view, row), n);
    }
}

static void row8(void *context, int y, uint8_t *out)
{
    const quilt_rows8 *q = context;
    lf_quilt_row8(q->views, q->layout, y, out);
}

/* Copies a row of a view, with layers after the colours of each pixel; returns the end. */
static float *view_row(const lf_views32 *views, int view, int row, float *out)
{
    const lf_layers32 *layers = views->layers;
    size_t width = (size_t)views->width, n = layers ? (size_t)layers->n : 0;
    if (views->codes) {
        const uint8_t *code = lf_views32_codes(views, view, row);
        for (size_t i = 0; i < 3 * width; i++)
            out[i] = views->light[code[i]];
        return out + 3 * width;
    }
    const float *colour = lf_views32_row(views, view, row);
    if (!layers) {
        memcpy(out, colour, 3 * width * sizeof *out);
        return out + 3 * width;
    }
    const float *beside = lf_layers32_row(layers, view, row);
    for (size_t x = 0; x < width; x++, out += 3 + n, colour += 3, beside += n) {
        memcpy(out, colour, 3 * sizeof *out);
        memcpy(out + 3, beside, n * sizeof *out);
    }
    return out;
}

static void row32(void *context, int y, float *out)
{
    const quilt_rows32 *q = context;
    const lf_layers32 *layers = q->views->layers;
    size_t n = (size_t)q->layout->view_width * (3 + (layers ? (size_t)layers->n : 0));
    for (int column = 0; column < q->layout->columns; column++) {
        int row, view = view_at(q->layout, y, column, &row);
        if (view < 0) {
            memset(out, 0, n * sizeof *out);
            out += n;
        } else {
            out = view_row(q->views, view, row, out);
        }
    }
}

static lf_status check_layout(const lf_layout *l, int n_views, int width, int height, lf_error *err)
{
    if (l->n_views != n_views || l->view_width != width || l->view_height != height)
        return lf_error_set(
            err, LF_E_ARG, "quilt",
            "%d views of %dx%d pixels do not match the layout for %d views of %dx%d pixels",
            n_views, width, height, l->n_views, l->view_width, l->view_height);
    if (l->columns < 1 || l->rows < 1 || l->columns * l->rows < n_views)
        return lf_error_set(err, LF_E_ARG, "quilt", "%dx%d tiles are too few for %d views",
                            l->columns, l->rows, n_views);
    if (l->columns > 65536 / width || l->rows > 65536 / height)
        return lf_error_set(
            err, LF_E_ARG, "quilt",
            "%dx%d tiles of %dx%d pixels exceed 65536 pixels per side; use fewer or smaller views",
            l->columns, l->rows, width, height);
    return LF_OK;
}

/* Pixel aspect of a picture of one view: a quilt records it in its name, a view only in its pixels.
 * 0: square. */
static double pixel_aspect_of(const lf_layout *l)
{
    const double aspect = l->aspect * l->view_height / l->view_width;
    return l->columns * l->rows == 1 && fabs(aspect - 1) > 1e-3 && aspect >= 0.01 && aspect <= 100
               ? aspect
               : 0;
}

lf_status lf_quilt_write_png(lf_outfile *file, const lf_views8 *views, const lf_layout *layout,
                             const lf_attribute *attributes, int n_attributes, lf_error *err)
{
    lf_status status = check_layout(layout, views->n_views, views->width, views->height, err);
    if (status != LF_OK)
        return status;
    quilt_rows8 rows = {views, layout};
    const lf_png_size size = {layout->columns * views->width, layout->rows * views->height,
                              pixel_aspect_of(layout)};
    return lf_png_write_oblong(file, size, row8, &rows, PNG_LEVEL, attributes, n_attributes, err);
}

lf_status lf_quilt_write_jpeg(lf_outfile *file, const lf_views8 *views, const lf_layout *layout,
                              int quality, lf_error *err)
{
    lf_status status = check_layout(layout, views->n_views, views->width, views->height, err);
    if (status != LF_OK)
        return status;
    quilt_rows8 rows = {views, layout};
    return lf_jpeg_write_rows(file, layout->columns * views->width, layout->rows * views->height,
                              row8, &rows, quality, err);
}

lf_status lf_quilt_write_exr(lf_outfile *file, const lf_views32 *views, const lf_layout *layout,
                             const lf_attribute *attributes, int n_attributes, lf_error *err)
{
    lf_status status = check_layout(layout, views->n_views, views->width, views->height, err);
    if (status != LF_OK)
        return status;
    quilt_rows32 rows = {views, layout};
    const char *names[LF_EXR_MAX_CHANNELS] = {"R", "G", "B"};
    int n = 3;
    for (int i = 0; views->layers && i < views->layers->n && n < LF_EXR_MAX_CHANNELS; i++)
        names[n++] = views->layers->names[i];
    const lf_channels32 channels = {names, n, row32, &rows, pixel_aspect_of(layout), false};
    return lf_exr_write_channels(file, layout->columns * views->width, layout->rows * views->height,
                                 &channels, attributes, n_attributes, err);
}

lf_status lf_view_write_exr(lf_outfile *file, const lf_views32 *views, int view, double aspect,
                            const lf_attribute *attributes, int n_attributes, lf_error *err)
{
    lf_views32 one = *views;
    lf_layers32 layers;
    if (views->codes)
        one.codes = lf_views32_codes(views, view, 0);
    else
        one.data = lf_views32_row(views, view, 0);
    one.n_views = 1;
    if (views->layers) {
        layers = *views->layers;
        layers.data = lf_layers32_row(views->layers, view, 0);
        one.layers = &layers;
    }
    lf_layout layout = {.columns = 1,
                        .rows = 1,
                        .n_views = 1,
                        .view_width = views->width,
                        .view_height = views->height,
                        .aspect = aspect};
    return lf_quilt_write_exr(file, &one, &layout, attributes, n_attributes, err);
}
