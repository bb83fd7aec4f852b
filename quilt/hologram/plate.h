/* Parts of quilt/holograms.h that its files share. */
#ifndef LF_QUILT_PLATE_H
#define LF_QUILT_PLATE_H

#include "quilt/holograms.h"

/* The first camera of a task, and the number of its cameras. */
int lf_plate_task_row(const lf_plate *plate, int task);
int lf_plate_task_first(const lf_plate *plate, int task);
int lf_plate_task_cameras(const lf_plate *plate);

/* The picture of a form to which a place belongs, as rows and columns of pictures and of pixels. */
typedef struct lf_plate_picture {
    int i, j; /* of the picture */
    int rows, columns;
} lf_plate_picture;
lf_plate_picture lf_plate_picture_of(const lf_plate *plate, lf_plate_place place);
/* The number of pictures in rows and columns. */
void lf_plate_pictures(const lf_plate *plate, int *out_rows, int *out_columns);
/* The place of a pixel of the picture that has this place. */
static inline lf_plate_place lf_plate_pixel(const lf_plate *plate, lf_plate_place place, int y,
                                            int x)
{
    if (plate->form == LF_PLATE_VIEWS) {
        place.hy = y;
        place.hx = x;
    } else {
        place.v = y;
        place.u = x;
    }
    return place;
}

/* The name of a picture, relative to the plate's folder. Caller frees; NULL = out of memory. */
char *lf_plate_picture_name(const lf_plate *plate, int i, int j);

/* Writes a picture in the plate's format; samples: [height][width] pixels. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_plate_picture_write(const lf_plate *plate, const char *path, int width,
                                              int height, const uint8_t *samples, lf_error *err);

/* Half floats, rounded to nearest, ties to even. Beyond the range: the largest; NaN: 0. */
uint16_t lf_plate_half(float value);
float lf_plate_half_value(uint16_t half);

/* Headers of raw files: of the field, and of a task. */
void lf_plate_field_header(const lf_plate *plate, uint8_t out[LF_PLATE_HEADER]);
void lf_plate_task_header(const lf_plate *plate, int task, uint8_t out[LF_PLATE_HEADER]);
/* Bytes of samples of the field. */
uint64_t lf_plate_field_bytes(const lf_plate *plate);

/* Opens the raw file of a task for reading. LF_E_IO; LF_E_FORMAT: another header or size. */
LF_NODISCARD lf_status lf_plate_task_open(const lf_plate *plate, const char *folder, int task,
                                          int *out_fd, lf_error *err);

/* Makes the folders of folder/name. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_plate_make_folders(const char *folder, const char *name, lf_error *err);

/* Writes manifest.json from the files in the folder. */
LF_NODISCARD lf_status lf_plate_manifest_write(const lf_plate *plate, const char *folder,
                                               const json_t *facts, const lf_plate_run *run,
                                               lf_error *err);

#endif
