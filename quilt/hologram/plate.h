/* Parts of quilt/holograms.h that its files share. */
#ifndef LF_QUILT_PLATE_H
#define LF_QUILT_PLATE_H

#include "base/file_hash.h"
#include "quilt/holograms.h"

/* Room for the name of a file, relative to the plate's folder. */
#define LF_PLATE_NAME 64

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

/* The same into an open file, for LF_PLATE_TIFF: with the resolution of the plate, if it is known,
 * and an ICC profile, sRGB or linear grey. LF_E_ARG: too large for a TIFF. */
LF_NODISCARD lf_status lf_plate_tiff_write(const lf_plate *plate, lf_outfile *file, int width,
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

/* plate.json and manifest.json, without the list of files: facts and conventions. A new reference;
 * NULL = out of memory. */
json_t *lf_plate_describe(const lf_plate *plate, const json_t *facts);
/* Objects in files: NULL = missing or no object. LF_E_IO, LF_E_NOMEM (also for object = NULL). */
json_t *lf_plate_load(const char *folder, const char *name);
LF_NODISCARD lf_status lf_plate_save(const char *folder, const char *name, const json_t *object,
                                     lf_error *err);
/* Appends {name, bytes, sha256} of a file. sha256: what it must be; may be NULL. LF_E_IO,
 * LF_E_NOMEM; LF_E_FORMAT: the file is another. */
LF_NODISCARD lf_status lf_plate_add_file(const char *folder, const char *name, const char *sha256,
                                         json_t *files, lf_error *err);
/* True if the file of such an entry is there with its size. */
bool lf_plate_is_file(const char *folder, const json_t *file);

/* Receipts: rows/r%03d.json has the files of a task, and the hash of facts and conventions. It is
 * written after the files, and removed before they are written again. */
LF_NODISCARD lf_status lf_plate_receipt_write(const lf_plate *plate, const char *folder,
                                              const json_t *facts, int task, lf_error *err);
LF_NODISCARD lf_status lf_plate_receipt_remove(const char *folder, int task, lf_error *err);
/* The hash of each file, by name, from the receipts of all tasks. A new reference. LF_E_NOMEM;
 * LF_E_FORMAT: a receipt is missing or of another plate. */
LF_NODISCARD lf_status lf_plate_receipts(const lf_plate *plate, const char *folder,
                                         const json_t *facts, json_t **out_hashes, lf_error *err);

/* What plate.json or, without one, manifest.json says of the plate in a folder. A new reference;
 * NULL: the folder has no file that a plate can have, or is not there. LF_E_EXISTS: it has such
 * files, and they are of no plate; LF_E_IO: a folder in it is a link or cannot be read. */
LF_NODISCARD lf_status lf_plate_find(const char *folder, json_t **out, bool *out_is_manifest,
                                     lf_error *err);
/* Removes the files that a plate with this description can have, except plate.json; then empty
 * folders. LF_E_EXISTS: it describes no plate; LF_E_IO: as above, and nothing is removed. */
LF_NODISCARD lf_status lf_plate_clear(const char *folder, const json_t *plate, lf_error *err);
/* Removes a file if it is there. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_plate_remove_file(const char *folder, const char *name, lf_error *err);

/* Writes manifest.json from the files in the folder. hashes: of lf_plate_receipts. LF_E_FORMAT: a
 * file is not what its receipt says. */
LF_NODISCARD lf_status lf_plate_manifest_write(const lf_plate *plate, const char *folder,
                                               const json_t *facts, const json_t *hashes,
                                               const lf_plate_run *run, lf_error *err);

#endif
