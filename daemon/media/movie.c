#include "daemon/media/movie.h"

#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "daemon/media/probe.h"

#define HEAD 16

static const char *const endings[] = {".mp4", ".m4v", ".mov", ".webm",
                                      ".mkv", ".avi", ".gif", NULL};

const char *lf_movie_demuxer(const uint8_t *head, size_t n)
{
    static const struct {
        size_t at;
        const char *magic, *demuxer;
    } rows[] = {{4, "ftyp", "mov"},   {4, "moov", "mov"},
                {4, "mdat", "mov"},   {4, "wide", "mov"},
                {4, "free", "mov"},   {4, "skip", "mov"},
                {8, "AVI ", "avi"},   {0, "GIF87a", "gif"},
                {0, "GIF89a", "gif"}, {0, "\x1a\x45\xdf\xa3", "matroska"}};
    if (lf_image_foreign(head, n)) /* HEIC and AVIF look like MP4 */
        return NULL;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const size_t length = strlen(rows[i].magic);
        if (rows[i].at + length <= n && memcmp(head + rows[i].at, rows[i].magic, length) == 0)
            return rows[i].at == 8 && memcmp(head, "RIFF", 4) != 0 ? NULL : rows[i].demuxer;
    }
    return NULL;
}

bool lf_movie_ending(const char *name)
{
    for (int i = 0; endings[i]; i++)
        if (lf_path_has_ending(name, endings[i]))
            return true;
    return false;
}

static const char *demuxer_of(int fd)
{
    uint8_t head[HEAD];
    ssize_t n = pread(fd, head, sizeof head, 0);
    return n > 0 ? lf_movie_demuxer(head, (size_t)n) : NULL;
}

bool lf_is_movie(const char *path, const lf_roots *roots)
{
    int fd;
    if (lf_file_open(path, roots, UINT64_MAX, &fd, NULL, NULL) != LF_OK)
        return false;
    const bool is = demuxer_of(fd);
    close(fd);
    return is;
}

/* --------------------------------------------------------------------------------------- cut -- */

/* The orientation by which `first` and then `second` rotate; both are 1, 3, 6 or 8. */
static int both(int first, int second)
{
    static const int turns[] = {[1] = 0, [3] = 2, [6] = 1, [8] = 3}, orientations[] = {1, 6, 3, 8};
    return orientations[(turns[first] + turns[second]) % 4];
}

/* View of the tile in column c and row r from the top, after each view was rotated with the whole
 * picture. columns and rows: before. */
static int view_at(int c, int r, int columns, int rows, int orientation)
{
    int column = c, row = r;
    switch (orientation) {
    case 3:
        column = columns - 1 - c;
        row = rows - 1 - r;
        break;
    case 6:
        column = r;
        row = rows - 1 - c;
        break;
    case 8:
        column = columns - 1 - r;
        row = c;
        break;
    default:
        break;
    }
    return (rows - 1 - row) * columns + column;
}

/* Where the kept part begins in the picture before it was rotated. After it, the padding is at the
 * right and at the top. */
static void find_corner(int orientation, int beside, int above, lf_movie_cut *cut)
{
    cut->left = orientation == 3 ? beside : orientation == 6 ? above : 0;
    cut->top = orientation == 1 ? above : orientation == 6 ? beside : 0;
}

static void make_cut(lf_movie *movie, const lf_quilt_file *plan, int orientation)
{
    const lf_layout *l = &plan->layout;
    const bool swaps = lf_orientation_swaps(orientation);
    lf_movie_cut *cut = &movie->cut;
    cut->orientation = both(movie->info.orientation, orientation);
    cut->columns = swaps ? l->rows : l->columns;
    cut->rows = swaps ? l->columns : l->rows;
    cut->tile_width = l->view_width;
    cut->tile_height = l->view_height;
    cut->width = cut->columns * cut->tile_width;
    cut->height = cut->rows * cut->tile_height;
    for (int r = 0, i = 0; r < cut->rows; r++)
        for (int c = 0; c < cut->columns; c++, i++)
            cut->view_of[i] = (uint16_t)view_at(c, r, l->columns, l->rows, orientation);
}

/* Plans the views of the picture as players show it: rotated by the file's own word. */
static lf_status plan(lf_movie *movie, int columns, int rows, const lf_photo *photo, lf_error *err)
{
    const lf_movie_info *info = &movie->info;
    const bool swaps = lf_orientation_swaps(info->orientation);
    const lf_raster size = {
        .width = swaps ? info->height : info->width,
        .height = swaps ? info->width : info->height,
        .meta = {.pixel_aspect = swaps ? 1 / info->pixel_aspect : info->pixel_aspect}};
    lf_quilt_file plan;
    int orientation;
    lf_status status =
        lf_quilt_plan(movie->file, columns, rows, &size, photo, &plan, &orientation, err);
    if (status != LF_OK)
        return status;
    make_cut(movie, &plan, orientation);
    find_corner(info->orientation, size.width % plan.layout.columns, size.height % plan.layout.rows,
                &movie->cut);
    movie->frame_bytes = (size_t)plan.views8.n_views * plan.views8.view_stride;
    uint8_t *frame = lf_calloc(movie->frame_bytes, 1); /* its pages are never touched */
    if (!frame)
        return lf_error_set(err, LF_E_NOMEM, movie->file, "not enough memory for %d views",
                            plan.layout.n_views);
    plan.views8.data = frame;
    lf_photo_cut(photo, &plan);
    movie->first = (size_t)(plan.views8.data - frame);
    movie->layout = plan.layout;
    movie->views = plan.views8;
    movie->views.data = NULL;
    movie->notes = plan.notes;
    lf_free(frame);
    return LF_OK;
}

lf_status lf_movie_open(const char *path, const lf_roots *roots, int columns, int rows,
                        const lf_photo *photo, bool (*stopped)(void), lf_movie *out, lf_error *err)
{
    lf_movie movie = {.fd = -1, .file = lf_strdup(path)};
    lf_status status = movie.file ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    if (status == LF_OK)
        status = lf_file_open(path, roots, UINT64_MAX, &movie.fd, NULL, err);
    if (status == LF_OK)
        movie.demuxer = demuxer_of(movie.fd);
    if (status == LF_OK && !movie.demuxer)
        status =
            lf_error_set(err, LF_E_FORMAT, path,
                         "is not a video; expected MP4, QuickTime, WebM, Matroska, AVI or GIF");
    if (status == LF_OK)
        status = lf_probe_run(movie.fd, movie.demuxer, path, stopped, &movie.info, err);
    if (status == LF_OK)
        status = plan(&movie, columns, rows, photo, err);
    if (status == LF_OK)
        *out = movie;
    else
        lf_movie_finish(&movie);
    return status;
}

void lf_movie_finish(lf_movie *movie)
{
    if (movie->fd >= 0)
        close(movie->fd);
    lf_free(movie->file);
    *movie = (lf_movie){.fd = -1};
}
