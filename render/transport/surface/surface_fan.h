/* The lobes of a surface for all views of a pivot at once, as a table of functions: one file per
 * instruction set. surface_fan_loops.h holds the loops. All give bitwise the same results. Private
 * to render/. */
#ifndef LF_RENDER_SURFACE_FAN_H
#define LF_RENDER_SURFACE_FAN_H

#include "render/transport/surface/surface.h"

/* lf_surface_kind.eval towards one wi for n directions wo = (x[k], y[k], z[k]), all in the frame
 * whose z axis is ns. n is a multiple of 8. Writes out->pdf and out->f, three different arrays; the
 * colour is 1. */
typedef void lf_surface_fan(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
                            const float *z, lf_fan_lobes *out);

/* By lf_surface_kind.fan; NULL: nothing depends on the view. */
typedef struct lf_surface_fans {
    lf_surface_fan *of[LF_FAN_KINDS];
} lf_surface_fans;

extern const lf_surface_fans lf_surface_fans_c;
#if defined(__x86_64__)
extern const lf_surface_fans lf_surface_fans_avx2, lf_surface_fans_avx512;
#endif

#endif
