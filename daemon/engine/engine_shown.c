/* Copies of the shown views for other threads. */
#include <string.h>

#include "base/alloc.h"
#include "daemon/engine/engine_internal.h"

void lf_shown_views_finish(lf_shown_views *shown)
{
    lf_free(shown->rgb);
    *shown = (lf_shown_views){0};
}

bool engine_may_run_shown(const lf_engine *engine, const engine_request *request)
{
    const bool comes = engine->content && !engine->spoiled && !engine->frames.shows &&
                       engine->level < LF_LEVEL_COARSE && (engine_has_work(engine) || engine->owed);
    return !comes || atomic_load_explicit(request->cancel, memory_order_relaxed);
}

static lf_status check(const lf_engine *engine, const engine_request *request)
{
    if (atomic_load_explicit(request->cancel, memory_order_relaxed))
        return lf_error_set(request->err, LF_E_CANCELLED, "", "cancelled");
    if (!engine->content || engine->spoiled)
        return lf_error_set(request->err, LF_E_STATE, "",
                            "there is no image; call scene.load first");
    if (!engine->frames.shows)
        return engine->level < LF_LEVEL_COARSE
                   ? lf_error_set(request->err, LF_E_STATE, "",
                                  "nothing has been rendered yet; rendering is paused")
                   : lf_error_set(request->err, LF_E_STATE, "",
                                  "the panel shows a card instead of an image");
    if (request->n_views > engine->content->layout.n_views)
        return lf_error_set_at(request->err, LF_E_ARG, "", 0, "/views",
                               "the image has %d views, not %d", engine->content->layout.n_views,
                               request->n_views);
    return LF_OK;
}

/* Copies n views, evenly spaced. */
static void copy_views(const lf_views8 *views, int n, uint8_t *out)
{
    const size_t row = (size_t)views->width * 3;
    for (int i = 0; i < n; i++) {
        const int view = (int)((2 * (int64_t)i + 1) * views->n_views / (2 * (int64_t)n));
        for (int y = 0; y < views->height; y++, out += row)
            memcpy(out, lf_views8_row(views, view, y), row);
    }
}

lf_status engine_run_shown(lf_engine *engine, engine_request *request)
{
    lf_shown_views *out = request->shown;
    lf_status status = check(engine, request);
    if (status != LF_OK)
        return status;
    int64_t blank;
    const lf_level before = engine->level; /* of the frame that was posted last */
    const lf_views8 views = engine_views_now(engine, &blank);
    out->level = engine->level;
    engine->level = before;
    if (blank > 0)
        return lf_error_set(request->err, LF_E_STATE, "", "the image has unfilled pixels yet");
    const int n = request->n_views > 0 ? request->n_views : views.n_views;
    out->rgb = lf_calloc((size_t)n * (size_t)views.height, (size_t)views.width * 3);
    if (!out->rgb)
        return lf_error_set(request->err, LF_E_NOMEM, "", "out of memory for %d views", n);
    copy_views(&views, n, out->rgb);
    out->layout = engine->content->layout;
    out->layout.n_views = n;
    if (n < views.n_views)
        lf_layout_tiles(n, views.width, views.height, &out->layout.columns, &out->layout.rows);
    out->generation = engine->generation;
    out->passes = engine->spent.passes;
    out->reconstructed = engine->renderer && engine->fit.passes > 0;
    return LF_OK;
}
