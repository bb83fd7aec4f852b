/* One panel's lens calibration, as the vendor's JSON carries it (looking-glass.md section 2: every
 * number may be wrapped as
 * {"value": x} or plain, integers may come as floats, keys may be missing). A plain struct that
 * crosses rooms; what a parser made may be compared as bytes. */
#ifndef LF_BASE_CALIBRATION_H
#define LF_BASE_CALIBRATION_H

#include "base/status.h"

/* pixels: no panel is wider or higher, so nothing is allocated for one that claims to be */
#define LF_MAX_SIDE 16384
#define LF_MAX_PANEL_PIXELS (8192 * 8192) /* twice the largest panel there is */
#define LF_MAX_CELLS 16
#define LF_CALIBRATION_MAX_BYTES 65536
/* of a default quilt: as many views, and pixels in all as a panel */
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
    /* the panel's own default quilt: its tiles, and all of its pixels; 0 when absent */
    int quilt_columns, quilt_rows, quilt_width, quilt_height;
    float cells[LF_MAX_CELLS][3 /* R, G, B */][2 /* x, y */]; /* offsets in PIXELS */
} lf_calibration;

/* Parses JSON text of length n (at most LF_CALIBRATION_MAX_BYTES): the vendor's visual.json, or
 * what Bridge says of a device, {"calibration": …, "defaultQuilt": …}, each an object or a text of
 * one. A defaultQuilt that is none is left out with a warning. where names it in errors.
 * Control characters in texts become '?'. LF_E_FORMAT with line and pointer for anything missing
 * that the formulas need, non-finite or out of range; *out untouched then. */
LF_NODISCARD lf_status lf_calibration_parse(const char *text, size_t n, const char *where,
                                            lf_calibration *out, lf_error *err);
/* The same from a file. */
LF_NODISCARD lf_status lf_calibration_load(const char *path, lf_calibration *out, lf_error *err);
/* What parses as the same calibration: an object (a json_t of Jansson) of the vendor's keys with
 * bare values. NULL = out of memory; released with json_decref. */
struct json_t *lf_calibration_json(const lf_calibration *c) __attribute__((warn_unused_result));
/* A nominal Portrait (1536x2048), what the simulated device has when nothing else is said. */
void lf_calibration_portrait(lf_calibration *out);

#endif
