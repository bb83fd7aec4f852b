#include "daemon/output/blank.h"

#include <string.h>

#include "base/alloc.h"

/* True if all n pixels equal first. */
static bool is_plain(const uint8_t *rgb, size_t n, const uint8_t first[3])
{
    for (size_t i = 0; i < n; i++)
        if (memcmp(rgb + 3 * i, first, 3) != 0)
            return false;
    return true;
}

static lf_blank blank_of(const uint8_t first[3])
{
    return first[0] == 0 && first[1] == 0 && first[2] == 0 ? LF_BLANK_BLACK : LF_BLANK_PLAIN;
}

lf_blank lf_blank_of_views8(const lf_views8 *views)
{
    const uint8_t *first = lf_views8_row(views, 0, 0);
    for (int view = 0; view < views->n_views; view++)
        for (int row = 0; row < views->height; row++)
            if (!is_plain(lf_views8_row(views, view, row), (size_t)views->width, first))
                return LF_BLANK_NOT;
    return blank_of(first);
}

lf_blank lf_blank_of_views32(const lf_views32 *views, const lf_film_settings *film)
{
    const size_t width = (size_t)views->width;
    uint8_t *row8 = lf_calloc(width, 3), first[3];
    lf_tone *tone = NULL;
    lf_blank blank = LF_BLANK_NOT;
    bool plain = row8 && lf_tone_create(film->exposure, film->tonemap[0] ? film->tonemap : "srgb",
                                        &tone, NULL) == LF_OK;
    if (plain) {
        lf_tone_map(tone, 1, lf_views32_row(views, 0, 0), first);
        blank = blank_of(first);
    }
    for (int view = 0; view < views->n_views && plain; view++)
        for (int row = 0; row < views->height && plain; row++) {
            lf_tone_map(tone, width, lf_views32_row(views, view, row), row8);
            plain = is_plain(row8, width, first);
        }
    lf_tone_destroy(tone);
    lf_free(row8);
    return plain ? blank : LF_BLANK_NOT;
}

const char *lf_blank_words(lf_blank blank, bool of_daemon)
{
    if (blank == LF_BLANK_BLACK)
        return of_daemon ? "the image is black in all views; check the lights, the exposure "
                           "(film.exposure) and the camera position (camera.fit)"
                         : "the image is black in all views; check the lights, the exposure "
                           "(--exposure) and the camera position (--fit)";
    if (blank == LF_BLANK_PLAIN)
        return of_daemon ? "the image has a single colour in all views; check the exposure "
                           "(film.exposure) and the camera position (camera.fit)"
                         : "the image has a single colour in all views; check the exposure "
                           "(--exposure) and the camera position (--fit)";
    return NULL;
}

const char *lf_unseen_words(bool of_daemon)
{
    return of_daemon
               ? "the camera sees no mesh and no volume of the scene; use camera.fit to frame them"
               : "the camera sees no mesh and no volume of the scene; use --fit to frame them";
}
