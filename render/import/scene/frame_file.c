#include "render/import/scene/frame_file.h"

#include <math.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/frame_name.h"

/* 0.29 * 100 is less than 29. */
#define ROUNDING 1e-6

/* Maximum number of missing files on either side of a gap. */
#define MOST_MISSING 1000

char *lf_frame_file(lf_reader *reader, const lf_node *node, const char *file, int frame,
                    lf_frame_of *out)
{
    static const char *const keys[] = {"first", "step", "missing", NULL}, *const holes[] = {
                                                                              "hold", "empty",
                                                                              "error", NULL};
    const lf_node sequence = lf_node_child(node, "sequence");
    bool stated = lf_read_object(reader, &sequence, keys), varies = lf_frame_name_varies(file);
    int first = lf_read_int(reader, &sequence, "first", 1, 0, LF_MAX_FRAME);
    double step = lf_read_number(reader, &sequence, "step", 1, -1000, 1000),
           number = varies ? floor(first + (frame - 1) * step + ROUNDING) : 0;
    const int hole = lf_read_choice(reader, &sequence, "missing", holes, LF_HOLE_HOLD);
    if (stated && !varies)
        lf_read_fail(reader, &sequence,
                     "the file name needs a field for the frame number, such as %%04d: %s", file);
    else if (number < 0 || number > INT32_MAX)
        lf_read_fail(reader, node, "the number of the file would be out of range in frame %d: %.0f",
                     frame, number);
    if (reader->status != LF_OK)
        return NULL;
    *out = (lf_frame_of){varies ? file : NULL, (int)number, step < 0 ? 1 : -1, (lf_hole)hole};
    char *name = lf_frame_name(file, (int)number);
    if (!name)
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    return name;
}

static bool is_there(const char *file, const char *folder, const lf_roots *roots)
{
    char *path = lf_path_join(folder, file);
    int fd = -1;
    const bool opened = path && lf_file_open(path, roots, INT64_MAX, &fd, NULL, NULL) == LF_OK;
    if (opened)
        close(fd);
    lf_free(path);
    return opened;
}

/* The nearest existing file in steps of `step`; NULL: none. */
static char *nearest(const lf_frame_of *of, int step, const char *folder, const lf_roots *roots)
{
    for (int i = 1, number = of->number; i <= MOST_MISSING; i++) {
        if (step > 0 ? number > INT32_MAX - step : number + step < 0)
            return NULL;
        number += step;
        char *file = lf_frame_name(of->pattern, number);
        if (file && is_there(file, folder, roots))
            return file;
        lf_free(file);
    }
    return NULL;
}

char *lf_frame_held(const lf_frame_of *of, const char *folder, const lf_roots *roots)
{
    char *file = of->pattern ? lf_frame_name(of->pattern, of->number) : NULL;
    const bool lacks = file && !is_there(file, folder, roots);
    lf_free(file);
    if (!lacks)
        return NULL;
    char *before = nearest(of, of->back, folder, roots),
         *behind = before ? nearest(of, -of->back, folder, roots) : NULL;
    if (!behind) {
        lf_free(before);
        return NULL;
    }
    lf_free(behind);
    return before;
}
