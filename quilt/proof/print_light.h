/* Private to quilt/proof: stored values of a print to linear light, by the file's profile. */
#ifndef LF_QUILT_PRINT_LIGHT_H
#define LF_QUILT_PRINT_LIGHT_H

#include "quilt/proof/print_file.h"

typedef struct lf_print_light lf_print_light;

/* For values of 8 or 16 bits and 3 (RGB) or 4 (CMYK) channels. icc (NULL: none) is any bytes; a
 * profile that cannot be used is told by lf_print_light_problem. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_print_light_create(int channels, int bits, const void *icc, size_t size,
                                             lf_print_light **out);
void lf_print_light_destroy(lf_print_light *light); /* accepts NULL */
const char *lf_print_light_name(const lf_print_light *light);
const char *lf_print_light_problem(const lf_print_light *light); /* NULL: the profile is used */
/* n pixels of channels values -> [n][3]. Thread safe. */
void lf_print_light_decode(const lf_print_light *light, const void *raw, size_t n, float *out);

#endif
