#include "render/load/frame_file.h"

#include <math.h>

#include "base/alloc.h"
#include "base/frame_name.h"

/* 0.29 * 100 is less than 29. */
#define ROUNDING 1e-6

char *lf_frame_file(lf_reader *reader, const lf_node *node, const char *file, int frame)
{
    static const char *const keys[] = {"first", "step", NULL};
    const lf_node sequence = lf_node_child(node, "sequence");
    bool stated = lf_read_object(reader, &sequence, keys), varies = lf_frame_name_varies(file);
    int first = lf_read_int(reader, &sequence, "first", 1, 0, LF_MAX_FRAME);
    double step = lf_read_number(reader, &sequence, "step", 1, -1000, 1000),
           number = varies ? floor(first + (frame - 1) * step + ROUNDING) : 0;
    if (stated && !varies)
        lf_read_fail(reader, &sequence,
                     "the file's name has no place for a number, such as %%04d: %s", file);
    else if (number < 0 || number > INT32_MAX)
        lf_read_fail(reader, node, "in frame %d the file's number would be %.0f", frame, number);
    if (reader->status != LF_OK)
        return NULL;
    char *name = lf_frame_name(file, (int)number);
    if (!name)
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    return name;
}
