/* Indices of a plate: between rendered pictures and the written field. */
#include "quilt/hologram/plate.h"

#include <string.h>

const char *const lf_plate_forms[] = {
    [LF_PLATE_VIEWS] = "views", [LF_PLATE_HOGELS] = "hogels", [LF_PLATE_RAW] = "raw", NULL};
const char *const lf_plate_formats[] = {
    [LF_PLATE_PNG] = "png", [LF_PLATE_TIFF] = "tiff", [LF_PLATE_EXR] = "exr", NULL};

/* ------------------------------------------------------------------------------------- flips -- */

/* Applies a word to the written axes. False: unknown. */
static bool apply(const char *word, size_t n, lf_plate_flips *flips)
{
    static const char *const words[] = {"u", "v", "hx", "hy", "transpose", "rotate180", NULL};
    int i = 0;
    while (words[i] && (strlen(words[i]) != n || strncmp(words[i], word, n) != 0))
        i++;
    switch (i) {
    case 0:
    case 1: { /* once transposed, the written u is the v of the cameras */
        bool *axis = (i == 0) == flips->transpose ? &flips->v : &flips->u;
        *axis = !*axis;
        return true;
    }
    case 2:
        flips->hx = !flips->hx;
        return true;
    case 3:
        flips->hy = !flips->hy;
        return true;
    case 4:
        flips->transpose = !flips->transpose;
        return true;
    case 5:
        flips->u = !flips->u;
        flips->v = !flips->v;
        return true;
    default:
        return false;
    }
}

lf_status lf_plate_flips_read(const char *text, lf_plate_flips *out, lf_error *err)
{
    lf_plate_flips flips = {0};
    for (const char *word = text; *word;) {
        const size_t n = strcspn(word, ",");
        if (!apply(word, n, &flips))
            return lf_error_set(err, LF_E_ARG, "--flip",
                                "unknown word \"%.*s\"; expected u, v, hx, hy, transpose or "
                                "rotate180, separated by commas",
                                (int)(n < 32 ? n : 32), word);
        word += n + (word[n] == ',' ? 1 : 0);
    }
    *out = flips;
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- indices -- */

/* The numbers of cells and directions before flips. */
static lf_plate_place plain_size(const lf_plate *p)
{
    if (p->camera_is_cell)
        return (lf_plate_place){p->rows, p->columns, p->height, p->width};
    return (lf_plate_place){p->height, p->width, p->rows, p->columns};
}

static lf_plate_place transposed(lf_plate_place place)
{
    return (lf_plate_place){place.hy, place.hx, place.u, place.v};
}

lf_plate_place lf_plate_size(const lf_plate *plate)
{
    const lf_plate_place size = plain_size(plate);
    return plate->flips.transpose ? transposed(size) : size;
}

static int reversed(bool is_flipped, int i, int n)
{
    return is_flipped ? n - 1 - i : i;
}

static lf_plate_place flipped(const lf_plate *p, lf_plate_place place)
{
    const lf_plate_place n = plain_size(p);
    return (lf_plate_place){reversed(p->flips.hy, place.hy, n.hy),
                            reversed(p->flips.hx, place.hx, n.hx),
                            reversed(p->flips.v, place.v, n.v), reversed(p->flips.u, place.u, n.u)};
}

lf_plate_place lf_plate_place_of(const lf_plate *p, lf_plate_sample s)
{
    const int row = p->rows - 1 - s.row;
    const lf_plate_place plain =
        p->camera_is_cell ? (lf_plate_place){row, s.column, p->height - 1 - s.y, p->width - 1 - s.x}
                          : (lf_plate_place){s.y, s.x, row, s.column};
    const lf_plate_place place = flipped(p, plain);
    return p->flips.transpose ? transposed(place) : place;
}

lf_plate_sample lf_plate_sample_at(const lf_plate *p, lf_plate_place place)
{
    const lf_plate_place plain = flipped(p, p->flips.transpose ? transposed(place) : place);
    if (p->camera_is_cell)
        return (lf_plate_sample){p->rows - 1 - plain.hy, plain.hx, p->height - 1 - plain.v,
                                 p->width - 1 - plain.u};
    return (lf_plate_sample){p->rows - 1 - plain.v, plain.u, plain.hy, plain.hx};
}

/* ---------------------------------------------------------------------------------- pictures -- */

bool lf_plate_is_direct(const lf_plate *plate)
{
    return plate->form == (plate->camera_is_cell ? LF_PLATE_HOGELS : LF_PLATE_VIEWS);
}

void lf_plate_pictures(const lf_plate *plate, int *out_rows, int *out_columns)
{
    const lf_plate_place n = lf_plate_size(plate);
    const bool is_view = plate->form == LF_PLATE_VIEWS;
    *out_rows = is_view ? n.v : n.hy;
    *out_columns = is_view ? n.u : n.hx;
}

lf_plate_picture lf_plate_picture_of(const lf_plate *plate, lf_plate_place place)
{
    const lf_plate_place n = lf_plate_size(plate);
    if (plate->form == LF_PLATE_VIEWS)
        return (lf_plate_picture){place.v, place.u, n.hy, n.hx};
    return (lf_plate_picture){place.hy, place.hx, n.v, n.u};
}

/* ------------------------------------------------------------------------------------- tasks -- */

int lf_plate_tasks(const lf_plate *plate)
{
    return plate->rows * plate->parts;
}

int lf_plate_task_row(const lf_plate *plate, int task)
{
    return task / plate->parts;
}

int lf_plate_task_cameras(const lf_plate *plate)
{
    return plate->columns / plate->parts;
}

int lf_plate_task_first(const lf_plate *plate, int task)
{
    return task % plate->parts * lf_plate_task_cameras(plate);
}
