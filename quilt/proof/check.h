/* The checklist of a print: 18 points, measured on the written file that is read back from disk.
 *
 * What a file can say about itself differs. Its tags, size, profile, hash and manifest are always
 * checked. Pitch, phase and jitter are measured in the picture, from the stripes that share pixels,
 * and in the alignment strips. A picture whose views are equal, or with more views than 0.95 dpi /
 * lpi, tells nothing about them; the point then says so and does not apply. Nor does a compensated
 * picture, whose pixels are no plain mixtures of their stripes. The order of views
 * and the own share are measured on a strip of code views, which the same writer makes from the
 * manifest's options. They prove the writer. For the file itself they follow from a witness: rows
 * kept while it was written.
 *
 * Thread: any; a report belongs to its caller. */
#ifndef LF_QUILT_CHECK_H
#define LF_QUILT_CHECK_H

#include "base/paths.h"
#include "quilt/prints.h"

#define LF_CHECK_POINTS 18

typedef enum lf_check_result {
    LF_CHECK_PASS,
    LF_CHECK_WARN,
    LF_CHECK_FAIL,
    LF_CHECK_NONE /* the point does not apply, or cannot be measured in this file */
} lf_check_result;

/* All texts are plain ASCII, except names that come from the file. */
typedef struct lf_check_point {
    lf_check_result result;
    char measured[200]; /* what was found, or why the point does not apply */
    char limit[96];
    char remedy[160]; /* at most 20 words; empty for a point that holds */
} lf_check_point;

struct json_t;
/* Release with lf_print_report_finish, also when half built. */
typedef struct lf_print_report {
    char *file;              /* path of the TIFF */
    char sha256[65];         /* of its bytes; "" if it cannot be read */
    uint64_t bytes;          /* of it */
    struct json_t *manifest; /* NULL: there is none */
    char profile_name[128];  /* of the embedded profile; "" without one */
    lf_check_point points[LF_CHECK_POINTS];
} lf_print_report;

/* Zeroed is a valid default. */
typedef struct lf_print_check_options {
    const char *manifest;            /* NULL: beside the TIFF, sheet.json for sheet.tif */
    const lf_roots *roots;           /* folders that may be read; NULL: anywhere */
    const lf_print_witness *witness; /* rows of the same print, kept while it was written */
    int n_rows;                      /* rows that are measured; 0: 24, evenly spaced */
} lf_print_check_options;

/* Runs the checklist. Faults of the file are points of the report, also damage. Takes time for
 * hashing the file and for n_rows rows; memory is a few rows beside a strip of code views. LF_E_IO
 * and LF_E_PATH: the TIFF or the named manifest cannot be opened; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_print_check_file(const char *path, const lf_print_check_options *options,
                                           lf_print_report *out, lf_error *err);
void lf_print_report_finish(lf_print_report *report);

/* "pitch over the sheet"; point counts from 0. */
const char *lf_check_point_name(int point);
/* "PASS", "WARN", "FAIL", "----". */
const char *lf_check_result_name(lf_check_result result);
/* The number of points with a result. */
int lf_print_report_count(const lf_print_report *report, lf_check_result result);
/* One line without the file: "18 of 18 points hold", or "16 of 18 points hold, 1 does not apply, 1
 * fails: resolution (…)". Returns buf. */
char *lf_print_report_line(const lf_print_report *report, char *buf, size_t size);
/* The whole report as text, one paragraph a point; caller frees with lf_free; NULL = out of
 * memory. */
char *lf_print_report_text(const lf_print_report *report);
/* The same as an object with "quiltd_check": 1. A new reference; NULL = out of memory. */
struct json_t *lf_print_report_json(const lf_print_report *report);
/* The job sheet: one page A4 for whoever prints. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_print_report_sheet(const lf_print_report *report, lf_outfile *pdf,
                                             lf_error *err);

#endif
