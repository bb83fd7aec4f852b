/* Private to quilt/profile/. */
#ifndef LF_QUILT_PROFILE_H
#define LF_QUILT_PROFILE_H

#include <jansson.h>

#include "quilt/profiles.h"

/* Where the rows of a profile put their values. Texts are borrowed from the JSON. */
typedef struct lf_profile_words {
    lf_lens_profile lens;
    lf_printer_profile printer;
    lf_lens_calibration calibration;
    const char *title, *maker, *source, *icc;
    const char *of_printer, *date, *chart_sha256; /* of a calibration */
} lf_profile_words;

#endif
