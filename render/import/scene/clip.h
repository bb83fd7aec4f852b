/* Which animation of a mesh's file is shown, and at which moment; private to render/. */
#ifndef LF_RENDER_CLIP_H
#define LF_RENDER_CLIP_H

#include <math.h>
#include <stdbool.h>

#define LF_MAX_CLIP 255 /* bytes of a name */
#define LF_MAX_SECONDS 1e6

typedef struct lf_clip {
    const char *name; /* NULL: by its number; borrowed */
    int number;       /* 0 = the first */
    bool chosen;      /* the scene says which */
    bool once;        /* behind its end it stands still; else it begins anew */
    double seconds;   /* since its beginning, which may be before or behind it */
} lf_clip;

/* Seconds since the beginning of a clip that is span long, 0 to span. The same for every moment at
 * which all stands in the same places, but for rounding. */
static inline double lf_clip_moment(const lf_clip *clip, double span)
{
    if (!(span > 0))
        return 0;
    if (clip->once)
        return fmin(fmax(clip->seconds, 0), span);
    return clip->seconds - span * floor(clip->seconds / span);
}

#endif
