#include "daemon/web/demo.h"

#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "daemon/web/memory.h"

enum { TILE_WIDTH = LF_DEMO_WIDTH / LF_DEMO_COLUMNS, TILE_HEIGHT = LF_DEMO_HEIGHT / LF_DEMO_ROWS };
enum { VIEWS = LF_DEMO_COLUMNS * LF_DEMO_ROWS };

/* A bar, in shares of a view's width. */
typedef struct bar {
    double middle, half;
    double
        nearness; /* it moves so far from the first view to the middle one; before the glass: > 0 */
    uint8_t rgb[3];
} bar;

/* The nearest is the last. */
static const bar bars[] = {{0.75, 0.09, -0.08, {60, 110, 230}},
                           {0.50, 0.09, 0.00, {70, 200, 110}},
                           {0.25, 0.09, 0.08, {240, 120, 50}}};

static void draw_pixel(int view, int x, uint8_t *out)
{
    static const uint8_t ground[3] = {16, 16, 20};
    const double from_left = 2.0 * view / (VIEWS - 1) - 1, at = (x + 0.5) / TILE_WIDTH;
    memcpy(out, ground, 3);
    for (size_t i = 0; i < sizeof bars / sizeof bars[0]; i++)
        if (fabs(at - bars[i].middle + bars[i].nearness * from_left) < bars[i].half)
            memcpy(out, bars[i].rgb, 3);
}

static lf_status keep(const uint8_t *rgb, size_t n, int *out_fd, lf_error *err)
{
    int fd = -1;
    lf_status status = lf_memory_create(&fd, err);
    for (size_t done = 0; done < n && status == LF_OK;) {
        const ssize_t more = write(fd, rgb + done, n - done);
        if (more <= 0)
            status = lf_error_set(err, LF_E_IO, "demo", "cannot keep the image: %s",
                                  lf_errno_text(errno));
        done += more > 0 ? (size_t)more : 0;
    }
    if (status == LF_OK)
        status = lf_memory_seal(fd, err);
    if (status == LF_OK)
        *out_fd = fd;
    else if (fd >= 0)
        close(fd);
    return status;
}

lf_status lf_demo_bars(int *out_fd, lf_error *err)
{
    const size_t n = (size_t)3 * LF_DEMO_WIDTH * LF_DEMO_HEIGHT;
    uint8_t *rgb = lf_calloc(n, 1);
    if (!rgb)
        return lf_error_set(err, LF_E_NOMEM, "demo", "out of memory");
    for (int y = 0; y < LF_DEMO_HEIGHT; y++)
        for (int x = 0; x < LF_DEMO_WIDTH; x++) {
            const int row = LF_DEMO_ROWS - 1 - y / TILE_HEIGHT; /* from the bottom */
            draw_pixel(row * LF_DEMO_COLUMNS + x / TILE_WIDTH, x % TILE_WIDTH,
                       rgb + 3 * ((size_t)y * LF_DEMO_WIDTH + (size_t)x));
        }
    lf_status status = keep(rgb, n, out_fd, err);
    lf_free(rgb);
    return status;
}

lf_status lf_demo_black(int *out_fd, lf_error *err)
{
    static const uint8_t black[3] = {0};
    return keep(black, sizeof black, out_fd, err);
}
