/* Videos: their frames on the engine's thread. */
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/wakeup.h"
#include "daemon/engine/engine_internal.h"

/* On the player's thread. */
static void on_news(void *context)
{
    lf_engine *engine = context;
    pthread_mutex_lock(&engine->lock);
    engine->news.movie = true;
    pthread_cond_broadcast(&engine->wake);
    pthread_mutex_unlock(&engine->lock);
}

void engine_hold_movie(lf_engine *engine)
{
    if (!engine->player)
        return;
    lf_player_pause(engine->player, engine->holds_movie || engine->wanted.controls.paused);
    engine->news.movie = true;
}

/* Frames of a video that moves on are offered to devices that show views only from time to time;
 * the last one, when it pauses or ends, is offered again. */
static void look_at_motion(lf_engine *engine, const lf_player_status *now)
{
    const bool moves = !now->paused && !now->ended && !now->failed;
    engine->owed = engine->owed || (engine->movie.is_moving && !moves);
    engine->movie.is_moving = moves;
}

static void tell_failure(lf_engine *engine, const lf_player_status *now)
{
    if (!now->failed || engine->movie.told)
        return;
    engine->movie.told = true;
    lf_log_error(&now->err);
    lf_wakeup_signal(engine->event_fd);
}

void engine_take_movie(lf_engine *engine)
{
    lf_player *player = engine->content ? engine->content->player : NULL;
    lf_player_status now;
    if (!player)
        return;
    lf_player_get_status(player, &now);
    look_at_motion(engine, &now);
    tell_failure(engine, &now);
    if (now.ended)
        lf_wakeup_signal(engine->event_fd);
    if (!lf_player_take(player, &engine->movie.views))
        return;
    engine->movie.is_fresh = true;
    engine_post_frame(engine, !engine->movie.is_moving);
    if (engine->movie.is_fresh)
        engine->movie.lost++;
    engine->movie.is_fresh = false;
}

void engine_begin_movie(lf_engine *engine)
{
    lf_player *player = engine->content->player;
    engine->movie = (engine_movie){0};
    lf_mailbox_count(engine->mailbox, engine->generation);
    if (!player)
        return;
    pthread_mutex_lock(&engine->lock);
    engine->player = player;
    engine->holds_movie = false;
    engine_hold_movie(engine);
    pthread_mutex_unlock(&engine->lock);
    if (lf_player_start(player, on_news, engine) != LF_OK)
        lf_log(LF_LOG_ERROR, "%s: out of memory for a thread; only the first frame is shown",
               engine->content->file);
    engine->movie.is_fresh = lf_player_take(player, &engine->movie.views);
    engine->movie.is_moving = true;
}

void engine_end_movie(lf_engine *engine)
{
    lf_player *player = engine->player;
    pthread_mutex_lock(&engine->lock);
    engine->player = NULL;
    engine->news.movie = false;
    pthread_mutex_unlock(&engine->lock);
    if (player)
        lf_player_stop(player);
    engine->movie.is_moving = false;
}

lf_status engine_snapshot_movie(const lf_engine *engine, lf_snapshot *out, lf_error *err)
{
    const lf_views8 *from = &engine->movie.views;
    const size_t row = (size_t)from->width * 3, height = (size_t)from->height;
    out->frame = lf_calloc((size_t)from->n_views * height, row);
    if (!out->frame)
        return lf_error_set(err, LF_E_NOMEM, "", "out of memory for the views");
    uint8_t *to = out->frame;
    for (int view = 0; view < from->n_views; view++)
        for (int y = 0; y < from->height; y++, to += row)
            memcpy(to, lf_views8_row(from, view, y), row);
    out->source.views8 =
        (lf_views8){from->n_views, from->width, from->height, row * height, row, out->frame};
    return LF_OK;
}

bool lf_engine_get_movie(lf_engine *engine, lf_movie_status *out)
{
    pthread_mutex_lock(&engine->lock);
    const bool shown = engine->player;
    if (shown) {
        lf_player_get_status(engine->player, &out->player);
        const lf_mailbox_counts counts = lf_mailbox_counted(engine->mailbox);
        out->shown = counts.taken;
        out->dropped = out->player.dropped + counts.replaced + engine->lost;
    }
    pthread_mutex_unlock(&engine->lock);
    return shown;
}

void lf_engine_pause_movie(lf_engine *engine, bool paused)
{
    pthread_mutex_lock(&engine->lock);
    engine->holds_movie = paused;
    engine_hold_movie(engine);
    pthread_cond_broadcast(&engine->wake);
    pthread_mutex_unlock(&engine->lock);
}
