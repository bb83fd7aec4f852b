/* Frames for the panel, and their views. */
#include "base/log.h"
#include "base/thread.h"
#include "daemon/engine/engine_internal.h"

/* Shortest interval between copies of views of one generation and level, for devices that show
 * views. */
#define VIEWS_SECONDS 0.45
/* Delay until the views of a final frame are offered again, if the device refused them because it
 * still reads the last ones. */
#define VIEWS_AGAIN_NS (LF_NS_PER_S / 50)

void engine_drop_interlacer(lf_engine *engine)
{
    lf_interlacer_destroy(engine->lens.interlacer);
    engine->lens.interlacer = NULL;
}

static bool same_views(const lf_layout *a, const lf_layout *b)
{
    return a->n_views == b->n_views && a->view_width == b->view_width &&
           a->view_height == b->view_height && a->aspect == b->aspect;
}

const lf_interlacer *engine_interlacer_now(lf_engine *engine)
{
    const lf_layout *layout = &engine->content->layout;
    if (engine->lens.interlacer && !same_views(layout, &engine->lens.layout))
        engine_drop_interlacer(engine);
    if (!engine->lens.interlacer && engine->now.panel.present) {
        lf_error err;
        engine->lens.layout = *layout;
        lf_status status =
            lf_interlacer_create(&engine->now.panel.calibration, layout->n_views,
                                 layout->view_width, layout->view_height, layout->aspect,
                                 LF_FILTER_NEAREST, LF_INVERT_AUTO, &engine->lens.interlacer, &err);
        if (status != LF_OK) {
            lf_log_error(&err);
            engine->now.panel.present = false;
        }
    }
    return engine->lens.interlacer;
}

lf_frame *engine_begin_frame(lf_engine *engine, bool interlaced)
{
    const lf_calibration *panel = &engine->now.panel.calibration;
    lf_frame *frame = lf_mailbox_begin(engine->mailbox, interlaced ? panel->screen_width_px : 0,
                                       interlaced ? panel->screen_height_px : 0);
    if (!frame) {
        lf_log(LF_LOG_ERROR, "out of memory for a panel frame");
        return NULL;
    }
    frame->generation = engine->generation;
    frame->level = engine->level;
    frame->passes = engine->spent.passes;
    frame->reconstructed = engine->renderer && engine->fit.passes > 0;
    frame->panel = engine->now.panel.number;
    frame->moves = engine->movie.is_moving;
    return frame;
}

/* Copies the first views of every generation and level, and later ones at intervals. */
static void attach_views(lf_engine *engine, lf_frame *frame, const lf_views8 *views, bool final)
{
    engine_look *look = &engine->look;
    /* its views would be lost if this frame replaced it */
    const lf_frame *waiting = lf_mailbox_waiting(engine->mailbox);
    double now = lf_time_now();
    bool news = frame->generation != look->views_generation || frame->level != look->views_level;
    if (!views || !engine->now.panel.views ||
        !(final || news || now - look->views_at > VIEWS_SECONDS || (waiting && waiting->has_views)))
        return;
    look->views_at = now;
    if (lf_mailbox_attach(engine->mailbox, frame, views)) {
        look->views_generation = frame->generation;
        look->views_level = frame->level;
        return;
    }
    frame->lacks_views = news || frame->lacks_views;
    if (final)
        engine->frames.again_ns = lf_time_now_ns() + VIEWS_AGAIN_NS;
}

void engine_end_frame(lf_engine *engine, lf_frame *frame, const lf_views8 *views, bool final)
{
    if (frame->image.data) {
        if (engine->now.controls.has_codes)
            lf_codes_apply(&engine->now.controls.codes, &frame->image, engine->pool);
        engine_fade_frame(engine, frame);
        lf_mailbox_compare(engine->mailbox, frame);
    }
    attach_views(engine, frame, views, final);
    engine_fade_limit(frame);
    frame->counts = engine->movie.is_fresh;
    engine->movie.is_fresh = false;
    engine->frames.n++;
    engine->frames.cost = lf_time_now() - engine->frames.at;
    engine_publish(engine); /* before the frame, because its receiver may query the status next */
    lf_mailbox_post(engine->mailbox, frame);
}
