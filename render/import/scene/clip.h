/* Which animation of a mesh's file is played, and at which time; private to render/. */
#ifndef LF_RENDER_CLIP_H
#define LF_RENDER_CLIP_H

#include <math.h>
#include <stdbool.h>

#define LF_MAX_CLIP 255 /* bytes of a name */
#define LF_MAX_SECONDS 1e6

typedef struct lf_clip {
    const char *name; /* NULL: by number; borrowed */
    int number;       /* 0 = the first */
    bool chosen;      /* chosen by the scene */
    bool once;        /* true: clamp to the first and last pose of the clip; false: loop */
    double seconds;   /* since its start; may be negative or beyond its end */
} lf_clip;

/* Time in a clip of length span, in seconds, 0 to span. Except for rounding, it is the same for all
 * times with the same poses. */
static inline double lf_clip_moment(const lf_clip *clip, double span)
{
    if (!(span > 0))
        return 0;
    if (clip->once)
        return fmin(fmax(clip->seconds, 0), span);
    return clip->seconds - span * floor(clip->seconds / span);
}

#endif
