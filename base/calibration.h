/* A panel's lens calibration, in the format of the vendor's JSON
 * (docs/reference/formats/calibrations.md). Numbers may be wrapped as {"value": x} or plain,
 * integers may be written as floats, keys may be missing. A plain struct shared by all modules;
 * parsed calibrations can be compared as bytes. */
#ifndef LF_BASE_CALIBRATION_H
#define LF_BASE_CALIBRATION_H

#include "base/status.h"

/* pixels: larger panels are refused, so that nothing is allocated for a false size */
#define LF_MAX_SIDE 16384
#define LF_MAX_PANEL_PIXELS (8192 * 8192) /* twice the largest known panel */
#define LF_MAX_CELLS 16
#define LF_CALIBRATION_MAX_BYTES 65536
/* limit of views in a default quilt; its pixels are limited like those of a panel */
#define LF_CALIBRATION_MAX_VIEWS 256

typedef struct lf_calibration {
    char config_version[16]; /* "1.0", "3.0"; empty when absent */
    char serial[64];         /* "LKG-..."; empty when absent */
    double pitch;            /* lenses per inch across the lens; > 0 */
    /* run over rise of the lens axis, signed; != 0 */
    double slope;
    double center; /* phase in lens periods */
    /* total angle of the optics; 0 when absent */
    double view_cone_deg;
    double dpi; /* panel pixels per inch; > 0 */
    /* native pixels; 1..LF_MAX_SIDE, at most LF_MAX_PANEL_PIXELS in all */
    int screen_width_px, screen_height_px;
    int inv_view, flip_image_x, flip_image_y, flip_subp; /* 0 or 1 (>= 0.5 test) */
    int cell_pattern_mode;                               /* 0..4 */
    int n_cells;                                         /* 0 = plain RGB stripes */
    /* the panel's default quilt: tiles, and total size in pixels; 0 when absent */
    int quilt_columns, quilt_rows, quilt_width, quilt_height;
    float cells[LF_MAX_CELLS][3 /* R, G, B */][2 /* x, y */]; /* offsets in PIXELS */
} lf_calibration;

/* Parses JSON text of length n (at most LF_CALIBRATION_MAX_BYTES). Accepts the vendor's
 * visual.json, and Bridge's description of a device: {"calibration": …, "defaultQuilt": …}, each an
 * object or a string of JSON. An invalid defaultQuilt is skipped with a warning. `where` names the
 * source in errors. Control characters in strings become '?'. LF_E_FORMAT, with line and pointer: a
 * required number is missing, not finite or out of range; *out is then untouched. */
LF_NODISCARD lf_status lf_calibration_parse(const char *text, size_t n, const char *where,
                                            lf_calibration *out, lf_error *err);
/* Parses a file. */
LF_NODISCARD lf_status lf_calibration_load(const char *path, lf_calibration *out, lf_error *err);
/* JSON that parses to the same calibration: an object (a json_t of Jansson) of the vendor's keys
 * with plain values. NULL = out of memory; release with json_decref. */
struct json_t *lf_calibration_json(const lf_calibration *c) __attribute__((warn_unused_result));
/* A nominal Portrait (1536x2048), the default of the simulated device. */
void lf_calibration_portrait(lf_calibration *out);

#endif
