#include "quilt/print/flip.h"

#include <stdio.h>
#include <string.h>

int lf_flip_frames(const lf_print *print, int n_images)
{
    return n_images + (n_images - 1) * print->sheet.morph;
}

/* The frame of stripe i of n, evenly chosen. */
static int evenly(int i, int n, int n_frames)
{
    return (int)(((2 * (int64_t)i + 1) * n_frames) / (2 * (int64_t)n));
}

static lf_stripe_content frame_content(const lf_print *print, int n_images, int frame)
{
    const int step = print->sheet.morph + 1, image = frame / step;
    return (lf_stripe_content){.image = image,
                               .next = image + 1 < n_images ? image + 1 : image,
                               .blend = (float)(frame % step) / (float)step};
}

/* Guard g of those behind a frame. */
static lf_stripe_content guard_content(const lf_print *print, int n_images, int frame, int g)
{
    const int n_frames = lf_flip_frames(print, n_images);
    if (print->sheet.guard_kind == LF_GUARD_REPEAT)
        return frame_content(print, n_images,
                             2 * g < print->sheet.guard ? frame : (frame + 1) % n_frames);
    return (lf_stripe_content){.neutral = true,
                               .light = print->sheet.guard_kind == LF_GUARD_WHITE ? 1.0F : 0.0F};
}

lf_stripe_content lf_flip_content(const lf_print *print, int n_images, int i)
{
    const int guard = print->sheet.guard, n_frames = lf_flip_frames(print, n_images);
    const int n_shown = print->n_views - n_frames * guard;
    if (guard == 0)
        return frame_content(print, n_images, evenly(i, print->n_views, n_frames));
    const int lead = guard / 2;
    if (i < lead)
        return guard_content(print, n_images, n_frames - 1, guard - lead + i);
    int at = lead, shown = 0;
    for (int frame = 0; frame < n_frames; frame++) {
        int own = 0;
        while (shown + own < n_shown && evenly(shown + own, n_shown, n_frames) == frame)
            own++;
        if (i < at + own)
            return frame_content(print, n_images, frame);
        if (i < at + own + guard)
            return guard_content(print, n_images, frame, i - at - own);
        at += own + guard;
        shown += own;
    }
    return guard_content(print, n_images, n_frames - 1, 0);
}

lf_status lf_flip_check(const lf_print *print, int n_images, const char *where, lf_error *err)
{
    const int n_frames = lf_flip_frames(print, n_images), guard = print->sheet.guard;
    if (guard == 0 || (int64_t)n_frames * (1 + guard) <= print->n_views)
        return LF_OK;
    return lf_error_set(err, LF_E_ARG, where,
                        "guard: %d frames with %d guard stripes each need %lld stripes per lens, "
                        "but it has %d; use fewer of them",
                        n_frames, guard, (long long)n_frames * (1 + guard), print->n_views);
}

void lf_flip_note(const lf_print *print, int n_images, lf_image_notes *notes)
{
    const int n_frames = lf_flip_frames(print, n_images), guard = print->sheet.guard;
    const int n_shown = print->n_views - n_frames * guard;
    if (guard == 0 && print->sheet.morph == 0)
        return;
    if (n_frames > n_shown)
        lf_image_note(notes, "%d of %d frames are shown, one per stripe; use fewer blended frames",
                      n_shown, n_frames);
    else if (n_shown % n_frames != 0)
        lf_image_note(notes,
                      "%d stripes do not divide evenly among %d frames; %d views give all frames "
                      "the same width",
                      n_shown, n_frames, n_frames * (guard + n_shown / n_frames));
    if (!print->horizontal)
        lf_image_note(notes, "vertical lenses show each eye another frame of a flip; "
                             "--orientation horizontal shows both eyes the same");
}

char *lf_flip_text(const lf_print *print, int n_images, char *buf, size_t size)
{
    buf[0] = '\0';
    const bool is_flip = print->sheet.guard > 0 || print->sheet.morph > 0;
    if (!is_flip && n_images <= print->n_views)
        return buf;
    for (int i = 0; i < print->n_views; i++) {
        const lf_stripe_content content = lf_flip_content(print, n_images, i);
        const size_t n = strlen(buf);
        char word[32];
        snprintf(word, sizeof word, content.neutral ? "-" : "%.3g",
                 content.image + (double)content.blend);
        if (n + strlen(word) + sizeof " ..." > size) {
            snprintf(buf + n, size - n, " ...");
            return buf;
        }
        snprintf(buf + n, size - n, "%s%s", i > 0 ? " " : "", word);
    }
    return buf;
}
