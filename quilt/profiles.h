/* Print profiles: lens sheets and printers that are kept in files and chosen by name.
 *
 * A lens profile describes a sheet, and has its calibrations: pitch and phase that were measured
 * with a printer, at a viewing distance. A printer profile has the raster and what ink does. Both
 * are small JSON files (docs/man/quiltprint.1 lists the keys).
 *
 * NAME means the first file lenses/NAME.json or printers/NAME.json in these folders:
 * $XDG_CONFIG_HOME/quiltd (~/.config/quiltd), /etc/quiltd, the shipped folder. The shipped folder
 * is ../share/quiltd or ../profiles beside the program's folder, or $QUILTD_PROFILES. A name with a
 * slash, or one that ends in .json, is the path of a file.
 *
 * Functions are thread safe on different objects. They access files, so the event thread of a
 * daemon does not call them. */
#ifndef LF_QUILT_PROFILES_H
#define LF_QUILT_PROFILES_H

#include <limits.h>

#include "base/image_metadata.h"
#include "quilt/prints.h"

enum {
    LF_PROFILE_NAME = 64,         /* bytes of a name, with the terminating 0 */
    LF_PROFILE_TEXT = 256,        /* bytes of other texts */
    LF_PROFILE_BYTES = 256 << 10, /* of a file, at most */
    LF_PROFILE_CALIBRATIONS = 64, /* of a lens, at most */
    LF_PROFILE_NATIVE = 16,       /* native resolutions of a printer, at most */
    LF_PROFILE_ENTRIES = 1000,    /* files of a folder that are listed, at most */
};

typedef enum lf_profile_kind { LF_PROFILE_LENS, LF_PROFILE_PRINTER } lf_profile_kind;

/* What was read from where. */
typedef struct lf_profile_file {
    char name[LF_PROFILE_NAME]; /* of the file, without folder and ending */
    char path[PATH_MAX];
    char sha256[65]; /* of the file */
} lf_profile_file;

/* A sheet behind a printer's print, as measured. 0 = unknown, except for reverse. */
typedef struct lf_lens_calibration {
    char printer[LF_PROFILE_NAME]; /* a name */
    double visual_lpi;             /* always known */
    double distance_mm;            /* always known: where the pitch was read */
    double phase_mm, skew_deg, error_lpi;
    bool reverse;        /* the views run in reverse order */
    bool horizontal;     /* the lenses that it was measured with: phase_mm is down the page */
    bool has_horizontal; /* the file says so; otherwise they were as the profile's are used */
    int n_crosstalk;     /* as in lf_print_blur */
    double crosstalk[2 * LF_PRINT_CROSSTALK + 1];
    int crosstalk_views;   /* views under a lens that these are shares of: 8 in charts */
    char date[11];         /* "2026-11-29"; "" = unknown */
    char chart_sha256[65]; /* of the chart's file; "" = unknown */
} lf_lens_calibration;

/* Numbers are 0 if they are unknown. */
typedef struct lf_lens_profile {
    lf_profile_file file;
    char title[LF_PROFILE_TEXT]; /* the key "name" */
    char maker[LF_PROFILE_TEXT], source[LF_PROFILE_TEXT];
    double pitch_lpi;    /* mechanical; always known */
    bool horizontal;     /* how the sheet is used */
    bool has_horizontal; /* the file says so */
    lf_optics optics;    /* its distance_mm is 0, its map LF_MAP_AUTO */
    double spot_mm;      /* as in lf_print_blur */
    int n_calibrations;
    lf_lens_calibration calibrations[LF_PROFILE_CALIBRATIONS];
} lf_lens_profile;

typedef struct lf_printer_profile {
    lf_profile_file file;
    char title[LF_PROFILE_TEXT];
    char maker[LF_PROFILE_TEXT], source[LF_PROFILE_TEXT];
    double dpi, dpi_down; /* as in lf_print; dpi is always known */
    int n_native;
    double native_dpi[LF_PROFILE_NATIVE]; /* rasters that its driver does not resample */
    double dot_gain, ink_mm;              /* as in lf_print_blur */
    bool registered;    /* a jig holds sheet and print in one place: phases of calibrations last */
    char icc[PATH_MAX]; /* "" = none; a path relative to the program */
} lf_printer_profile;

/* Reads a profile by name or path. roots (NULL = anywhere) hold for paths alone. LF_E_ARG: there is
 * no such profile, with the nearest name; LF_E_FORMAT with file and pointer: unknown keys, wrong
 * types, numbers out of range; LF_E_IO, LF_E_PATH, LF_E_NOMEM. *out is undefined after a
 * failure. */
LF_NODISCARD lf_status lf_profile_lens_read(const char *name, const lf_roots *roots,
                                            lf_lens_profile *out, lf_error *err);
LF_NODISCARD lf_status lf_profile_printer_read(const char *name, const lf_roots *roots,
                                               lf_printer_profile *out, lf_error *err);

/* ------------------------------------------------------------------------------- for a print -- */

/* The user's names of profiles. */
typedef struct lf_profile_names {
    const char *lens, *printer; /* borrowed; NULL = none */
} lf_profile_names;
/* The options --lens and --printer, and their keys. */
extern const lf_param lf_profile_params[];

/* Keys of lf_print_params that the user gave, each once. They win over profiles. Zeroed: none. */
typedef struct lf_print_given {
    int n;
    /* names of rows, or their options if they have no name; there is room for all rows */
    const char *keys[128];
} lf_print_given;
bool lf_print_is_given(const lf_print_given *given, const char *key);
/* Adds the keys of an option's rows. */
void lf_print_give(lf_print_given *given, const lf_param *row);
/* The rows of lf_print_params that a JSON object has. */
lf_print_given lf_print_given_in(const struct json_t *values);

/* What the profiles gave: one line per profile, and warnings. */
typedef struct lf_profile_told {
    lf_image_notes lines, warnings;
    const char *pitch_kind; /* how the pitch is known, static text; NULL: it was given */
} lf_profile_told;

/* Fills a print from profiles, except for keys that were given. lens or printer may be NULL. The
 * lens is the profile's alone: thickness, index, radius, angle, slant, spot and crosstalk that it
 * does not have are unknown (the slant: 0) afterwards, whatever they were before.
 *
 * The phase is that of the calibration, if the printer is registered and it was measured with
 * lenses that run as those of the print. Otherwise it stays what it was, and told says so.
 *
 * The pitch, unless given, is that of the calibration for this printer which is nearest to
 * print->optics.distance_mm, converted to that distance by lf_profile_pitch. Without a distance
 * there must be one calibration for this printer. Without a calibration the pitch is computed from
 * the mechanical one, with a warning. Afterwards print->optics.distance_mm is the distance that the
 * pitch is for (0 if it was given without one).
 *
 * print->icc_path then points into *printer. LF_E_ARG: pitch or raster remain unknown, or the
 * distance is needed; where: the option. */
LF_NODISCARD lf_status lf_profile_apply(const lf_lens_profile *lens,
                                        const lf_printer_profile *printer,
                                        const lf_print_given *given, lf_print *print,
                                        lf_profile_told *told, lf_error *err);
/* The manifest's account of the profiles: names, hashes, numbers, and told's lines. A new
 * reference; NULL = out of memory. */
struct json_t *lf_profile_account(const lf_lens_profile *lens, const lf_printer_profile *printer,
                                  const lf_profile_told *told);

/* The profiles of a print. Zeroed is a valid start; finish it also after a failure. */
typedef struct lf_profiles {
    lf_lens_profile lens;
    lf_printer_profile printer;
    lf_profile_told told;
    struct json_t *account; /* NULL: no names were given */
} lf_profiles;
/* Reads the named profiles and fills the print (lf_profile_apply), which then borrows the account
 * and the path of the ICC file from *out. Without names does nothing. print->icc_roots does not
 * hold for an ICC file that a profile found by name has. Errors of reading and of applying. */
LF_NODISCARD lf_status lf_profiles_open(const lf_profile_names *names, const lf_roots *roots,
                                        const lf_print_given *given, lf_print *print,
                                        lf_profiles *out, lf_error *err);
void lf_profiles_finish(lf_profiles *profiles);

/* The visual pitch seen from to_mm, of a sheet whose pitch from from_mm is lpi. Distances of 0 are
 * infinite: the mechanical pitch. Pitch = mechanical / (1 + t / (n D)), for a thickness t > 0 and
 * an index n. */
double lf_profile_pitch(double lpi, double from_mm, double to_mm, double thickness_mm,
                        double index);
/* The thickness of a sheet whose lens has this viewing angle in degrees (vertex model): the inverse
 * of 2 asin(n sin(atan(p / 2t))). */
double lf_profile_thickness(double lpi, double angle, double index);
/* And the angle in degrees, at most 180. */
double lf_profile_angle(double lpi, double thickness_mm, double index);

/* ----------------------------------------------------------------------------- files by name -- */

typedef struct lf_profile_entry {
    char name[LF_PROFILE_NAME];
    char path[PATH_MAX];
    bool is_own; /* in the user's folder */
} lf_profile_entry;

/* All profiles by name, sorted; of equal names the first. Caller frees *out with lf_free. Folders
 * that are missing count as empty. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_profile_list(lf_profile_kind kind, lf_profile_entry **out, int *out_n,
                                       lf_error *err);
/* "lens" or "printer". */
const char *lf_profile_kind_name(lf_profile_kind kind);
/* True if text may be the name of a profile: 1 to 63 letters, digits, or -+_. of which the first is
 * a letter or a digit. */
bool lf_profile_is_name(const char *text);
/* True if the name of a profile is the path of a file, for which the rule of readable paths
 * holds. */
bool lf_profile_is_path(const char *name);
/* The user's folder "…/quiltd/lenses" (LF_PROFILE_LENS) in out. LF_E_STATE: no home is known. */
LF_NODISCARD lf_status lf_profile_own_folder(lf_profile_kind kind, char out[static PATH_MAX],
                                             lf_error *err);
/* Finds the file of a name or path. LF_E_ARG as for lf_profile_lens_read. */
LF_NODISCARD lf_status lf_profile_find(lf_profile_kind kind, const char *name,
                                       char out[static PATH_MAX], lf_error *err);

/* Reads the JSON of a file, without checks of its keys. A new reference. LF_E_FORMAT with the line.
 */
LF_NODISCARD lf_status lf_profile_json(const char *path, const lf_roots *roots, struct json_t **out,
                                       lf_error *err);
/* Checks the JSON of a profile, as the readers do; where names it in errors. */
LF_NODISCARD lf_status lf_profile_check(lf_profile_kind kind, const struct json_t *values,
                                        const char *where, lf_error *err);
/* Rows of the plain keys of a profile, and of a calibration. */
const lf_param *lf_profile_rows(lf_profile_kind kind);
extern const lf_param lf_calibration_rows[];

#endif
