/* Holographic stereograms: the pictures of a grid of cameras as exposure pictures of a plate.
 *
 * A plate has Hx x Hy cells (hogels). Each sends another colour in each of U x V directions. The
 * field is [hy][hx][v][u]: hx counts cells from the left and hy from the top, as seen by the
 * viewer; u counts directions from the leftmost eye and v from the topmost eye.
 *
 * Two kinds of cameras make a field. V: a camera is an eye in front of the plate, which is the
 * window of all cameras; its pixels are cells. H: a camera is a cell, and its pixels are
 * directions. Such a camera sees to the right what it sends to eyes at the left. So its picture is
 * turned by 180 degrees in the field.
 *
 * Flips change the field that is written, for the optics of a printer. All functions are pure or
 * work on their own files. Thread: any. */
#ifndef LF_QUILT_HOLOGRAMS_H
#define LF_QUILT_HOLOGRAMS_H

#include <jansson.h>

#include "quilt/quilt.h"

/* What is written: a picture for each direction (of all cells), a picture for each cell (of all
 * directions), or the field in one file. */
typedef enum lf_plate_form { LF_PLATE_VIEWS, LF_PLATE_HOGELS, LF_PLATE_RAW } lf_plate_form;
/* Samples: 8-bit sRGB, 16-bit sRGB, or linear halfs. */
typedef enum lf_plate_format { LF_PLATE_PNG, LF_PLATE_TIFF, LF_PLATE_EXR } lf_plate_format;
/* Their names, NULL after the last. */
extern const char *const lf_plate_forms[], *const lf_plate_formats[];

/* What becomes of the field. First its axes are reversed, then each cell's picture is transposed
 * (u and v change places). */
typedef struct lf_plate_flips {
    bool u, v, hx, hy, transpose;
} lf_plate_flips;
/* Reads words separated by commas: u, v, hx, hy, transpose, rotate180 (u and v). They apply from
 * left to right, each to the axes as they are by then. "" is none. LF_E_ARG. */
LF_NODISCARD lf_status lf_plate_flips_read(const char *text, lf_plate_flips *out, lf_error *err);

/* Sizes and conventions of a plate. Rows of cameras count from the lowest, pixels from the top
 * left. */
typedef struct lf_plate {
    int columns, rows; /* cameras */
    int width, height; /* of a camera's picture, in pixels */
    int parts;         /* a row of cameras is rendered in this many equal parts, from the left */
    int microns[2];    /* size of the plate; 0: unknown */
    lf_plate_form form;
    lf_plate_format format;
    lf_plate_flips flips;
    bool camera_is_cell; /* kind H; otherwise V */
    bool is_grey;        /* linear luminance instead of RGB; not for LF_PLATE_PNG */
} lf_plate;

/* ----------------------------------------------------------------------------------- indices -- */

/* A sample of the written field, or its numbers of cells and directions. */
typedef struct lf_plate_place {
    int hy, hx, v, u;
} lf_plate_place;
/* A sample of the rendered pictures. */
typedef struct lf_plate_sample {
    int row, column, y, x; /* camera and pixel */
} lf_plate_sample;

/* The numbers of cells and directions, as written. */
lf_plate_place lf_plate_size(const lf_plate *plate);
/* The place of a sample in the written field, and the way back. */
lf_plate_place lf_plate_place_of(const lf_plate *plate, lf_plate_sample sample);
lf_plate_sample lf_plate_sample_at(const lf_plate *plate, lf_plate_place place);

/* ------------------------------------------------------------------------------------- files -- */

/* Bytes of a pixel: 1 or 3 channels of 1 or 2 bytes. */
size_t lf_plate_pixel_bytes(const lf_plate *plate);
/* Encodes n pixels of linear RGB. tone: for 16-bit samples; NULL for halfs. 8-bit samples come from
 * lf_tone_map or lf_tone_dither, and are not made here. */
void lf_plate_encode(const lf_plate *plate, const lf_tone *tone, size_t n, const float *rgb,
                     uint8_t *out);

/* True if pictures of cameras are files of the plate. */
bool lf_plate_is_direct(const lf_plate *plate);
/* Bytes of samples of a task. */
uint64_t lf_plate_task_bytes(const lf_plate *plate);
/* Tasks, 0 to rows * parts - 1, from the lowest row of cameras up. Each is rendered by itself and
 * has files of its own. Pictures of cameras are the plate's files if the form asks for them. If
 * not, or for one file, a task has one file rows/r%03d.raw until all tasks are there. */
int lf_plate_tasks(const lf_plate *plate);
int lf_plate_task_files(const lf_plate *plate);
/* The i-th file of a task; the name is relative to the plate's folder. Caller frees with lf_free;
 * NULL = out of memory. */
char *lf_plate_task_file(const lf_plate *plate, int task, int i);
/* The files of a finished plate, in the order of the manifest. The i-th name, relative to the
 * folder; i = lf_plate_n_files: manifest.json. Caller frees; NULL = out of memory. */
int lf_plate_n_files(const lf_plate *plate);
char *lf_plate_file(const lf_plate *plate, int i);
/* True if the folder has the receipt of a task, rows/r%03d.json, it is of these facts, and all its
 * files are there with their sizes. Of rows/r%03d.raw the header is checked, too. */
bool lf_plate_has_task(const lf_plate *plate, const char *folder, const json_t *facts, int task);

/* How files are written. */
typedef struct lf_plate_run {
    const lf_cancel *cancel; /* may be NULL */
    lf_pool *pool;           /* may be NULL */
    /* may be NULL; called from the calling thread with rising values */
    void (*progress)(void *context, double fraction);
    void *context;
} lf_plate_run;

/* Writes the files of a task, then its receipt, which has the hash of each file and of the facts;
 * samples: [camera of the task][y][x] in the plate's encoding. The folder must exist. LF_E_IO,
 * LF_E_NOMEM, LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_plate_write_task(const lf_plate *plate, const char *folder,
                                           const json_t *facts, int task, const uint8_t *samples,
                                           const lf_plate_run *run, lf_error *err);
/* Once all tasks are there: writes the other files of the plate, then manifest.json. The manifest
 * has the members of facts, the conventions of the plate, and all files with their SHA-256. Memory
 * (lf_plate_finish_memory): at most 256 MiB, or one row of pixels of every camera. LF_E_FORMAT: a
 * file of a task is not what its receipt says, or the receipt is not of these facts. */
size_t lf_plate_finish_memory(const lf_plate *plate);
LF_NODISCARD lf_status lf_plate_finish(const lf_plate *plate, const char *folder,
                                       const json_t *facts, const lf_plate_run *run, lf_error *err);

/* True if manifest.json is that of these facts, and all its files are there with their sizes. */
bool lf_plate_is_finished(const lf_plate *plate, const char *folder, const json_t *facts);

/* Ensures that all tasks in a folder are parts of one plate. The first one makes the folder and
 * writes facts and conventions to plate.json. Later ones compare. replace: first removes the files
 * of the plate that plate.json or manifest.json describes. LF_E_EXISTS: plate.json differs, and err
 * names the first member that does; or there are files of no plate, which are never removed.
 * LF_E_IO: also if a folder in it is a link, or cannot be read. */
LF_NODISCARD lf_status lf_plate_begin(const lf_plate *plate, const char *folder,
                                      const json_t *facts, bool replace, lf_error *err);
/* The same comparison, for plans: writes nothing, and the folder need not exist. */
LF_NODISCARD lf_status lf_plate_check(const lf_plate *plate, const char *folder,
                                      const json_t *facts, lf_error *err);

/* --------------------------------------------------------------------------------- raw files -- */

/* A raw file: this many bytes of header, then samples [hy][hx][v][u][channel], little-endian.
 *
 *      0  8 bytes  "LFPLATE1"
 *      8  uint32   64, the size of the header
 *     12  uint32   order: 0 the field; 1 pictures of cameras, [camera][y][x][channel]
 *     16  uint32   Hy, Hx, V, U; in order 1: task, cameras, height, width
 *     32  uint32   channels: 3 (RGB) or 1 (Y)
 *     36  uint32   type: 0 uint8, 1 uint16, 2 half (IEEE 754 binary16)
 *     40  uint32   encoding: 0 sRGB, 1 linear
 *     44  uint32   0
 *     48  uint64   bytes of samples
 *     56  uint64   0 */
#define LF_PLATE_HEADER 64

#endif
