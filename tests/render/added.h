/* Adds films of one image, as quiltmerge adds their files. */
#ifndef LF_TESTS_RENDER_ADDED_H
#define LF_TESTS_RENDER_ADDED_H

#include "render/film/film_file.h"
#include "render/renderer.h"

/* LF_E_STATE also if they are of different images. */
static inline lf_status added_film(lf_film *film, const lf_film *from, lf_error *err)
{
    const char *refusal = lf_film_refusal(film, from);
    return refusal ? lf_error_set(err, LF_E_STATE, "film", "cannot add a film %s", refusal)
                   : lf_film_mix(film, from, err);
}

/* Adds a saved state to the film of a renderer. */
static inline lf_status added_state(lf_renderer *renderer, int fd, lf_error *err)
{
    lf_film other = {0};
    lf_status status = lf_film_read(fd, &renderer->film, &other, err);
    if (status == LF_OK)
        status = lf_film_mix(&renderer->film, &other, err);
    lf_film_finish(&other);
    return status;
}

#endif
