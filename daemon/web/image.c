#include "daemon/web/image.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"

static const char where[] = "frame.get";
static const char *const levels[] = {"none", "coarse", "complete", "converged"};
enum { N_LEVELS = 4, COMPLETE = 2, JPEG = 1, ACROSS = 16, DOWN = 8 };

int lf_web_image_level(const char *name)
{
    for (int i = 0; name && i < N_LEVELS; i++)
        if (strcmp(levels[i], name) == 0)
            return i;
    return 0;
}

static bool take_int(const json_t *result, const char *key, int64_t most, int64_t *out)
{
    const json_t *value = json_object_get(result, key);
    *out = json_integer_value(value);
    return json_is_integer(value) && *out >= 1 && *out <= most;
}

lf_status lf_web_image_read(const json_t *result, int fd, lf_web_image *out, lf_error *err)
{
    static const struct {
        const char *key;
        int64_t most;
    } rows[] = {{"columns", UINT16_MAX}, {"rows", UINT16_MAX},   {"views", UINT16_MAX},
                {"width", UINT16_MAX},   {"height", UINT16_MAX}, {"bytes", INT32_MAX}};
    int64_t numbers[6];
    struct stat st;
    for (int i = 0; i < 6; i++)
        if (!take_int(result, rows[i].key, rows[i].most, &numbers[i]))
            return lf_error_set(err, LF_E_FORMAT, where, "%s is not from 1 to %lld", rows[i].key,
                                (long long)rows[i].most);
    if (fstat(fd, &st) != 0 || st.st_size != numbers[5])
        return lf_error_set(err, LF_E_FORMAT, where, "the image has another size than said");
    *out = (lf_web_image){
        .generation = (uint32_t)json_integer_value(json_object_get(result, "generation")),
        .level = lf_web_image_level(json_string_value(json_object_get(result, "level"))),
        .columns = (int)numbers[0],
        .rows = (int)numbers[1],
        .views = (int)numbers[2],
        .width_px = (int)numbers[3],
        .height_px = (int)numbers[4],
        .bytes = (size_t)numbers[5],
    };
    return LF_OK;
}

/* The largest width up to `most` at which blocks of a JPEG end where views do, also down the quilt
 * if a width near to it allows this. */
static int whole_blocks(int most, int width_px, int height_px)
{
    if (most < ACROSS)
        return most < 1 ? 1 : most;
    for (int w = most / ACROSS * ACROSS; w >= ACROSS && w > most * 3 / 4; w -= ACROSS)
        if ((int64_t)w * height_px % ((int64_t)DOWN * width_px) == 0)
            return w;
    return most / ACROSS * ACROSS;
}

int lf_web_image_width(const lf_web_image *rendered, int level)
{
    if (rendered->width_px == 0)
        return 0;
    const int across = LF_WEB_IMAGE_MAX_SIDE / rendered->columns;
    const int64_t down = (int64_t)(LF_WEB_IMAGE_MAX_SIDE / rendered->rows) * rendered->width_px /
                         rendered->height_px;
    int most = down < across ? (int)down : across;
    if (level >= COMPLETE && rendered->width_px <= most)
        return 0;
    if (level < COMPLETE && rendered->width_px / 2 < most)
        most = rendered->width_px / 2;
    most = most > rendered->width_px ? rendered->width_px : most;
    return whole_blocks(most, rendered->width_px, rendered->height_px);
}

bool lf_web_image_is_like(const lf_web_image *image, const lf_web_image *rendered)
{
    /* heights are rounded to whole pixels */
    const int64_t off = (int64_t)image->height_px * rendered->width_px -
                        (int64_t)image->width_px * rendered->height_px;
    return image->columns == rendered->columns && image->rows == rendered->rows &&
           image->views == rendered->views && off <= rendered->width_px &&
           off >= -rendered->width_px;
}

static void put(uint8_t *to, int bytes, uint32_t value)
{
    for (int i = 0; i < bytes; i++)
        to[i] = (uint8_t)(value >> 8 * i);
}

void lf_web_image_header(const lf_web_image *preview, uint8_t out[LF_WEB_IMAGE_HEADER])
{
    put(out, 4, preview->generation);
    put(out + 4, 1, (uint32_t)preview->level);
    put(out + 5, 1, JPEG);
    put(out + 6, 2, (uint32_t)preview->columns);
    put(out + 8, 2, (uint32_t)preview->rows);
    put(out + 10, 2, (uint32_t)preview->views);
    put(out + 12, 2, (uint32_t)preview->width_px);
    put(out + 14, 2, (uint32_t)preview->height_px);
}

lf_status lf_web_image_message(const lf_web_image *preview, int fd, uint8_t **out_data,
                               size_t *out_n, lf_error *err)
{
    if (preview->bytes > LF_WEB_IMAGE_MAX_BYTES)
        return lf_error_set(err, LF_E_NOMEM, where, "an image of %zu bytes is not passed on",
                            preview->bytes);
    uint8_t *data = lf_calloc(LF_WEB_IMAGE_HEADER + preview->bytes, 1);
    if (!data)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    lf_web_image_header(preview, data);
    for (size_t at = 0; at < preview->bytes;) {
        ssize_t n = pread(fd, data + LF_WEB_IMAGE_HEADER + at, preview->bytes - at, (off_t)at);
        if (n <= 0) {
            lf_free(data);
            return lf_error_set(err, LF_E_IO, where, "the image became shorter");
        }
        at += (size_t)n;
    }
    *out_data = data;
    *out_n = LF_WEB_IMAGE_HEADER + preview->bytes;
    return LF_OK;
}
