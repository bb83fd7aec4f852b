/* Private to check*.c: one run of the checklist. */
#ifndef LF_QUILT_CHECK_INTERNAL_H
#define LF_QUILT_CHECK_INTERNAL_H

#include <jansson.h>

#include "quilt/proof/check.h"
#include "quilt/proof/check_stripes.h"
#include "quilt/proof/print_file.h"

/* The points, in the order of the list. */
enum {
    CHECK_SIZE,
    CHECK_RESOLUTION,
    CHECK_RASTER,
    CHECK_PROFILE,
    CHECK_LOSSLESS,
    CHECK_PITCH,
    CHECK_PHASE,
    CHECK_JITTER,
    CHECK_ORDER,
    CHECK_SHARE,
    CHECK_RESAMPLED,
    CHECK_VIEWS,
    CHECK_DEPTH,
    CHECK_EDGES,
    CHECK_PDF,
    CHECK_MANIFEST,
    CHECK_SAME,
    CHECK_STORED
};

/* Positions measured in the file against what the manifest says, in micrometres. */
typedef struct lf_check_meter {
    const char *what; /* "picture", "strip above" */
    double width_um;  /* over which pitch errors accumulate */
    double pitch_um;  /* accumulated over the width */
    double phase_um;  /* in the middle */
    double jitter_um; /* largest of a block, beyond its own error */
    double error_um;  /* of pitch_um and phase_um, three standard deviations */
} lf_check_meter;

#define CHECK_MAX_METERS 4

/* What the picture's stripes say. */
typedef struct lf_check_grid {
    bool can;        /* stripes share pixels, so that they can be checked */
    bool exact;      /* the noise of the file is known, so that misfit is absolute */
    double misfit;   /* mean square in standard deviations (codes, for nearest); worst block */
    double at_best;  /* the same where the stripes fit best */
    double contrast; /* the same half a stripe away: how much the picture can tell */
} lf_check_grid;

typedef struct lf_check {
    const char *path;
    const lf_print_check_options *options;
    lf_print_report *report;
    lf_print_file *file;       /* NULL: cannot be opened */
    const lf_print_tags *tags; /* NULL: the same */
    char trouble[512];         /* why the file or its rows cannot be read; "": they can */
    bool known;                /* print and shape are those of the manifest */
    bool is_chart;
    lf_print print;
    lf_print_shape shape;
    int width, height; /* raster that the manifest promises, with marks */
    double dpi[2];     /* across the page and down it */
    bool laid;         /* several copies, a label, or a page around the print */
    bool linear;       /* linear lenses, also slanted or with an exact map */
    bool plain;        /* straight linear lenses of one pitch */
    bool fits;         /* rows can be read and have the promised shape */
    bool same_profile; /* the embedded profile is the manifest's */
    lf_check_grid grid;
    lf_check_meter meters[CHECK_MAX_METERS];
    int n_meters;
    int differing; /* rows that differ from the witness; -1: no witness */
} lf_check;

/* Sets a point. limit and remedy may be NULL. */
void lf_check_say(lf_check *check, int point, lf_check_result result, const char *limit,
                  const char *remedy, const char *format, ...) LF_PRINTF(6, 7);
/* Adds a measurement; drops it if there are too many. */
void lf_check_add_meter(lf_check *check, const lf_check_meter *meter);
/* Fits a line to positions of blocks, weighted by their errors (one standard deviation). False:
 * fewer than three blocks, or the error is over limit_um. */
bool lf_check_fit(const double *x_mm, const double *moved_um, const double *error_um, int n,
                  double width_mm, double limit_um, lf_check_meter *out);

/* The stages, in order. Those that allocate may return LF_E_NOMEM; faults of the file are said. */
LF_NODISCARD lf_status lf_check_manifest_read(lf_check *check, lf_error *err);
LF_NODISCARD lf_status lf_check_manifest(lf_check *check, lf_error *err);
void lf_check_tags(lf_check *check);
/* Of a PDF: its page, and the resolution that its matrix gives. Nothing for a TIFF. */
void lf_check_pdf(lf_check *check);
void lf_check_pdf_resolution(lf_check *check);
/* The number of views, once it is known whether the picture's stripes were measured. */
void lf_check_views(lf_check *check);
LF_NODISCARD lf_status lf_check_picture(lf_check *check, lf_error *err);
/* Whether the bleed is filled; for prints without marks. */
LF_NODISCARD lf_status lf_check_bleed(lf_check *check, lf_error *err);
LF_NODISCARD lf_status lf_check_marks(lf_check *check, lf_error *err);
LF_NODISCARD lf_status lf_check_writer(lf_check *check, lf_error *err);

/* Linear light of a stored sRGB value, and its slope per code. */
double lf_check_light(double code, int bits, double *out_slope);

/* A number of the manifest, by its names; NAN: there is none. */
double lf_check_number(const json_t *root, const char *part, const char *name, int i);

#endif
