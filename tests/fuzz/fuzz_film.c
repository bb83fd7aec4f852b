/* The file of a film: refused with a word, or a sound film, which can be written and read again,
 * resolved and added. Behind an odd first byte the parts get checksums that fit, so that more is
 * met than those. */
#include "tests/fuzz/fuzz.h"

#include <string.h>

#include "base/alloc.h"
#include "render/film/film_file.h"
#include "tests/fuzz/film_checksums.h"

enum { MAX_BYTES = 1 << 16, MAX_VALUES = 1 << 14, MAX_ROWS = 16 };

static lf_status read_film(const uint8_t *bytes, size_t size, lf_film *out, lf_error *err)
{
    int fd = lf_fuzz_file(bytes, size);
    lf_status status = lf_film_read(fd, NULL, out, err);
    close(fd);
    return status;
}

/* Its bytes in `out`; how many. */
static size_t write_film(const lf_film *film, uint8_t out[MAX_BYTES])
{
    lf_outfile file;
    int fd = memfd_create("film", MFD_CLOEXEC);
    lf_fuzz_require(fd >= 0 && lf_outfile_adopt(&file, fd, NULL) == LF_OK);
    lf_fuzz_require(lf_film_write(film, &file, NULL, NULL) == LF_OK);
    ssize_t size = pread(fd, out, MAX_BYTES, 0);
    lf_fuzz_require(size > 0 && size < MAX_BYTES);
    lf_outfile_abandon(&file);
    return (size_t)size;
}

static void check_layout(const lf_film_layout *l)
{
    lf_fuzz_require(l->n_views >= 1 && l->n_views <= LF_MAX_VIEWS);
    lf_fuzz_require(l->width >= 1 && l->width <= LF_MAX_VIEW_SIDE);
    lf_fuzz_require(l->height >= 1 && l->height <= LF_MAX_VIEW_SIDE);
    lf_fuzz_require(l->has_known || !l->has_native);
    lf_fuzz_require(l->has_native || !l->has_delta);
}

/* The rows' counts are the sums over streams, which ascend. */
static void check_counts(const lf_film *film)
{
    for (int row = 0; row < film->height; row++) {
        uint64_t visits[2] = {0};
        for (int i = 0; i < film->n_streams; i++)
            for (int h = 0; h < 2; h++)
                visits[h] += film->streams[i].rows[row].visits[h];
        for (int h = 0; h < 2; h++) {
            lf_fuzz_require(film->rows[row].visits[h] == visits[h]);
            lf_fuzz_require((film->rows[row].n[h] > 0.0) == (visits[h] > 0));
        }
    }
    for (int i = 1; i < film->n_streams; i++) {
        const lf_film_stream *a = &film->streams[i - 1], *b = &film->streams[i];
        lf_fuzz_require(a->seed < b->seed || (a->seed == b->seed && a->number < b->number));
    }
}

/* Whatever numbers are in it, answers are made of them. */
static void resolve(const lf_film *film)
{
    static float out[MAX_VALUES];
    static uint8_t flags[MAX_VALUES / 3];
    lf_row_error known;
    if (3 * (size_t)film->n_views * (size_t)film->width > MAX_VALUES)
        return;
    for (int row = 0; row < film->height && row < MAX_ROWS; row++) {
        for (int e = 0; e <= LF_ESTIMATOR_CV; e++) {
            lf_status status = lf_film_resolve_row(film, (lf_estimator)e, row, out, flags);
            lf_fuzz_require((status == LF_OK) == lf_film_visited(film->rows[row].visits));
        }
        lf_film_row_differences(film, LF_ESTIMATOR_MWIS, row, out, &known);
    }
}

/* Whether a film can be that has every sample twice. */
static bool has_double(const lf_film *film)
{
    bool possible = true;
    for (int row = 0; row < film->height; row++) {
        lf_film_row twice = film->rows[row];
        for (int h = 0; h < 2; h++) {
            twice.n[h] *= 2;
            twice.visits[h] *= 2;
        }
        twice.passes *= 2;
        possible = possible && lf_film_row_possible(&twice);
    }
    return possible;
}

/* Twice the same samples are refused; by streams of other seeds they are added where they have a
 * sum, which can be written and read. */
static void add(lf_film *film, lf_film *same)
{
    static uint8_t bytes[MAX_BYTES];
    bool visited = false, possible = has_double(film);
    for (int row = 0; row < film->height; row++)
        visited = visited || lf_film_visited(film->rows[row].visits);
    lf_fuzz_require(lf_film_mix(film, same, NULL) == (visited ? LF_E_STATE : LF_OK));
    if (film->n_streams != 1)
        return;
    same->streams[0].seed ^= 1;
    lf_fuzz_require(lf_film_mix(film, same, NULL) == (possible ? LF_OK : LF_E_STATE));
    lf_fuzz_require(film->n_streams == (possible ? 1 + same->n_streams : 1));
    check_counts(film);
    size_t size = write_film(film, bytes);
    lf_film_finish(same);
    lf_fuzz_require(read_film(bytes, size, same, NULL) == LF_OK);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t bytes[MAX_BYTES], again[MAX_BYTES];
    lf_film film = {0}, same = {0};
    lf_error err = {0};
    if (size < 1 || size > MAX_BYTES / 2)
        return 0;
    memcpy(bytes, data + 1, --size);
    if (data[0] % 2)
        mend_checksums(bytes, size);
    if (read_film(bytes, size, &film, &err) != LF_OK) {
        lf_fuzz_require(err.what[0] && !film.data);
        lf_fuzz_require_text(err.what);
        return 0;
    }
    check_layout(&film.layout);
    check_counts(&film);
    size = write_film(&film, bytes);
    lf_fuzz_require(read_film(bytes, size, &same, NULL) == LF_OK);
    lf_fuzz_require(write_film(&same, again) == size && memcmp(bytes, again, size) == 0);
    resolve(&film);
    add(&film, &same);
    lf_film_finish(&same);
    lf_film_finish(&film);
    return 0;
}
