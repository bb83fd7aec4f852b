/* Crossfades: the panel's image turns into the image of another content. */
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/thread.h"
#include "daemon/engine/engine_internal.h"

/* Shortest interval between the mixed images. Where mixing takes longer, at least a fifth of the
 * time is left for the engine's other work. */
#define STEP_NS (LF_NS_PER_S / 60)
#define OTHER_WORK 4

static void release(engine_fade *fade)
{
    lf_image8_finish(&fade->from);
    lf_image8_finish(&fade->to);
}

void engine_fade_end(lf_engine *engine)
{
    engine_fade *fade = &engine->frames.fade;
    fade->runs = fade->defers = false;
    if (!(fade->seconds > 0))
        release(fade);
}

void engine_take_fade(lf_engine *engine, double seconds)
{
    engine->frames.fade.seconds = seconds;
    if (!engine->frames.fade.runs)
        engine_fade_end(engine);
}

void engine_fade_commit(lf_engine *engine, const lf_content *before, const lf_content *content)
{
    if (before && strcmp(before->file, content->file) == 0)
        return;
    engine->frames.fade.next =
        engine->frames.fade.seconds > 0 && !content->is_frame ? ENGINE_FADES : ENGINE_CUTS;
}

bool engine_fade_waits(const lf_engine *engine)
{
    return engine->frames.fade.next == ENGINE_FADES && engine->now.panel.present &&
           engine->level < LF_LEVEL_COARSE;
}

uint64_t engine_fade_due_ns(const lf_engine *engine)
{
    return engine->frames.fade.runs ? engine->frames.fade.next_ns : 0;
}

/* --------------------------------------------------------------------------------- its start -- */

static bool has_shape(const lf_image8 *image, const lf_image8 *other)
{
    return image->data && image->width == other->width && image->height == other->height;
}

static lf_status make_room(lf_image8 *image, const lf_image8 *shape)
{
    if (has_shape(image, shape))
        return LF_OK;
    lf_image8_finish(image);
    return lf_image8_init(image, shape->width, shape->height, 3);
}

/* Begins with the image that was posted last, which may be a mixed one. */
static void start(lf_engine *engine, const lf_image8 *to)
{
    engine_fade *fade = &engine->frames.fade;
    const lf_frame *last = lf_mailbox_last(engine->mailbox);
    engine_fade_end(engine);
    if (!last || last->card[0] != '\0' || last->panel != engine->now.panel.number ||
        !has_shape(&last->image, to))
        return;
    if (make_room(&fade->from, to) != LF_OK || make_room(&fade->to, to) != LF_OK) {
        lf_log(LF_LOG_ERROR, "out of memory for a crossfade; the image changes at once");
        release(fade);
        return;
    }
    memcpy(fade->from.data, last->image.data, fade->from.stride * (size_t)fade->from.height);
    fade->runs = true;
    fade->since = lf_time_now();
    fade->lasts = fade->seconds;
}

/* -------------------------------------------------------------------------------- its images -- */

static int weight_now(const engine_fade *fade)
{
    const double share = (lf_time_now() - fade->since) / fade->lasts;
    return (int)(fmin(share, 1) * LF_BLEND_WHOLE);
}

static void mix(lf_engine *engine, lf_frame *frame, int weight)
{
    engine_fade *fade = &engine->frames.fade;
    fade->weight = weight;
    lf_blend(&fade->from, &fade->to, weight, &frame->image, engine->pool);
    frame->fades = weight < LF_BLEND_WHOLE;
    if (!frame->fades)
        engine_fade_end(engine);
}

/* When the next image is due, after one that was begun then. */
static void set_next(engine_fade *fade, uint64_t begun)
{
    const uint64_t end = lf_time_now_ns(), next = end + (end - begun) / OTHER_WORK;
    fade->next_ns = next > begun + STEP_NS ? next : begun + STEP_NS;
}

static void keep_head(engine_faded *head, const lf_frame *frame)
{
    *head = (engine_faded){.generation = frame->generation,
                           .level = frame->level,
                           .passes = frame->passes,
                           .reconstructed = frame->reconstructed,
                           .columns = frame->columns,
                           .rows = frame->rows};
}

void engine_fade_frame(lf_engine *engine, lf_frame *frame)
{
    engine_fade *fade = &engine->frames.fade;
    const bool fits = frame->card[0] == '\0' && frame->level >= LF_LEVEL_COARSE;
    if (fade->next == ENGINE_FADES && fits)
        start(engine, &frame->image);
    else if (fade->next == ENGINE_CUTS || !fits)
        engine_fade_end(engine);
    if (fits || fade->next == ENGINE_CUTS)
        fade->next = ENGINE_KEEPS;
    if (!fade->runs)
        return;
    keep_head(&fade->head, frame);
    const lf_image8 whole = frame->image;
    frame->image = fade->to;
    fade->to = whole;
    mix(engine, frame, weight_now(fade));
    set_next(fade, lf_time_now_ns());
}

/* Views that the frame's picture should have come with. */
static bool lacks_views(const lf_engine *engine)
{
    const engine_look *look = &engine->look;
    const engine_faded *head = &engine->frames.fade.head;
    return engine->now.panel.views &&
           (look->views_generation != head->generation || look->views_level != head->level);
}

/* Posts the last whole image mixed anew; NULL: out of memory. */
static lf_frame *begin(lf_engine *engine)
{
    const engine_faded *head = &engine->frames.fade.head;
    const lf_image8 *to = &engine->frames.fade.to;
    lf_frame *frame = lf_mailbox_begin(engine->mailbox, to->width, to->height);
    if (!frame)
        return NULL;
    frame->generation = head->generation;
    frame->level = head->level;
    frame->passes = head->passes;
    frame->reconstructed = head->reconstructed;
    frame->columns = head->columns;
    frame->rows = head->rows;
    frame->panel = engine->now.panel.number;
    frame->lacks_views = lacks_views(engine);
    return frame;
}

void engine_fade_step(lf_engine *engine)
{
    engine_fade *fade = &engine->frames.fade;
    const int weight = weight_now(fade);
    const bool waits = lf_mailbox_waiting(engine->mailbox);
    const uint64_t begun = lf_time_now_ns();
    set_next(fade, begun);
    if (weight < LF_BLEND_WHOLE && (waits || weight == fade->weight))
        return;
    if (waits && fade->next == ENGINE_KEEPS) { /* it may have views that must not be lost */
        engine_fade_end(engine);
        engine->owed = true;
        return;
    }
    lf_frame *frame = begin(engine);
    if (!frame) {
        lf_log(LF_LOG_ERROR, "out of memory for a crossfade; the image changes at once");
        engine_fade_end(engine);
        engine->owed = true;
        return;
    }
    mix(engine, frame, weight);
    engine_fade_limit(frame);
    lf_mailbox_compare(engine->mailbox, frame);
    engine->frames.n++;
    if (fade->next != ENGINE_KEEPS) /* a frame of the content before */
        engine->frames.n_before++;
    engine_publish(engine);
    lf_mailbox_post(engine->mailbox, frame);
    set_next(fade, begun);
}

void engine_fade_limit(lf_frame *frame)
{
    if (frame->fades && frame->level > LF_LEVEL_COARSE)
        frame->level = LF_LEVEL_COARSE;
}

void lf_engine_set_fade(lf_engine *engine, double seconds)
{
    pthread_mutex_lock(&engine->lock);
    engine->wanted.fade = fmax(0, fmin(seconds, LF_MAX_FADE));
    engine->news.fade = true;
    pthread_cond_broadcast(&engine->wake);
    pthread_mutex_unlock(&engine->lock);
}
