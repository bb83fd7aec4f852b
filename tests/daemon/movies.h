/* Quilt videos of a test's own, made by ffmpeg: 3 x 2 views of 24 x 32 pixels, as the live scene
 * has. Each pixel follows from the number of its frame, so frames are told apart and compared
 * exactly. */
#ifndef LF_TESTS_DAEMON_MOVIES_H
#define LF_TESTS_DAEMON_MOVIES_H

#include "tests/testing.h"

#include "base/alloc.h"
#include "base/file.h"
#include "base/image_io.h"

enum {
    MOVIE_COLUMNS = 3,
    MOVIE_ROWS = 2,
    MOVIE_VIEW_WIDTH = 24,
    MOVIE_VIEW_HEIGHT = 32,
    MOVIE_WIDTH = MOVIE_COLUMNS * MOVIE_VIEW_WIDTH,
    MOVIE_HEIGHT = MOVIE_ROWS * MOVIE_VIEW_HEIGHT,
};

/* Lossless, for a frame that is to be the same to the byte. */
#define MOVIE_LOSSLESS "-c:v libx264rgb -qp 0 -preset ultrafast -pix_fmt rgb24"

static inline bool movie_programs_exist(void)
{
    return system("command -v ffmpeg > /dev/null && command -v ffprobe > /dev/null") == 0;
}

/* The pixel of a frame of any size. */
static inline void movie_pixel(int frame, int x, int y, uint8_t rgb[3])
{
    rgb[0] = (uint8_t)(16 * frame + x);
    rgb[1] = (uint8_t)(3 * x + 5 * y + frame);
    rgb[2] = (uint8_t)(x * y + 7 * frame);
}

static inline void movie_paint(int frame, int width, int height, uint8_t *out)
{
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            movie_pixel(frame, x, y, out + 3 * ((size_t)y * (size_t)width + (size_t)x));
}

/* Frames first .. first + n - 1 of this size as raw pixels in folder/name. */
static inline void movie_write_raw(const char *folder, const char *name, int first, int n,
                                   int width, int height)
{
    const size_t bytes = (size_t)width * (size_t)height * 3;
    uint8_t *pixels = malloc(bytes);
    FILE *file = fopen(lf_test_path(folder, name), "w");
    assert_true(pixels && file);
    for (int k = first; k < first + n; k++) {
        movie_paint(k, width, height, pixels);
        assert_int_equal(fwrite(pixels, 1, bytes, file), bytes);
    }
    assert_int_equal(fclose(file), 0);
    free(pixels);
}

/* Runs a command in the folder. */
LF_PRINTF(2, 3) static inline void movie_run(const char *folder, const char *fmt, ...)
{
    char line[PATH_MAX + 2048];
    /* an ffmpeg of the test's own makes no videos */
    int n = snprintf(line, sizeof line, "PATH=${PATH#%s:}; cd %s && ", folder, folder);
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(line + n, sizeof line - (size_t)n, fmt, ap);
    va_end(ap);
    assert_int_equal(system(line), 0);
}

#define MOVIE_FFMPEG "ffmpeg -nostdin -v error -y "

/* A video of n frames with these options of its encoder; returns its path in a static buffer. */
static inline const char *movie_make(const char *folder, const char *name, int n, int fps,
                                     const char *options)
{
    movie_write_raw(folder, "frames.raw", 0, n, MOVIE_WIDTH, MOVIE_HEIGHT);
    movie_run(folder, MOVIE_FFMPEG "-f rawvideo -pix_fmt rgb24 -s %dx%d -r %d -i frames.raw %s %s",
              MOVIE_WIDTH, MOVIE_HEIGHT, fps, options, name);
    return lf_test_path(folder, name);
}

static inline void movie_take_row(void *context, int y, uint8_t *row)
{
    memcpy(row, (const uint8_t *)context + (size_t)y * 3 * MOVIE_WIDTH, (size_t)3 * MOVIE_WIDTH);
}

/* A frame as a quilt picture; returns its path in a static buffer. */
static inline const char *movie_frame_png(const char *folder, const char *name, int frame)
{
    static uint8_t pixels[3 * MOVIE_WIDTH * MOVIE_HEIGHT];
    const char *path = lf_test_path(folder, name);
    lf_outfile file;
    movie_paint(frame, MOVIE_WIDTH, MOVIE_HEIGHT, pixels);
    lf_assert_ok(lf_outfile_open(&file, path, true, NULL), NULL);
    lf_assert_ok(lf_png_write_rows(&file, MOVIE_WIDTH, MOVIE_HEIGHT, movie_take_row, pixels, 1,
                                   NULL, 0, NULL),
                 NULL);
    lf_assert_ok(lf_outfile_commit(&file, true, NULL), NULL);
    return path;
}

#endif
