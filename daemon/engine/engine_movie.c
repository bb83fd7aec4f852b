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
    if (!engine->movie.player)
        return;
    lf_player_pause(engine->movie.player, engine->movie.is_held);
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

static void drop_drawing(engine_drawing *drawing)
{
    lf_rgbd_warp_destroy(drawing->warp);
    lf_free(drawing->data);
    *drawing = (engine_drawing){0};
}

/* A decoded picture with both halves. */
static lf_rgbd_picture picture_of(const lf_content *content, const lf_views8 *views)
{
    return (lf_rgbd_picture){views->width, views->height, views->row_stride, views->data,
                             content->pixel_aspect};
}

lf_status engine_prepare_movie(lf_engine *engine, const lf_content *content, lf_error *err)
{
    engine_drawing drawing = {0};
    lf_status status = LF_OK;
    drop_drawing(&engine->movie.next);
    if (!content->player || (!content->is_rgbd && lf_standing_is_plain(&content->standing)))
        return LF_OK;
    const lf_layout *layout = &content->layout;
    const lf_rgbd_picture picture = picture_of(content, &lf_player_movie(content->player)->views);
    drawing.data = lf_calloc((size_t)layout->n_views * (size_t)layout->view_height,
                             3 * (size_t)layout->view_width);
    if (!drawing.data)
        status = lf_error_set(err, LF_E_NOMEM, content->file, "not enough memory for %d views",
                              layout->n_views);
    else if (content->is_rgbd)
        status = lf_rgbd_warp_create(&content->rgbd, &picture, layout, engine->pool, content->file,
                                     &drawing.warp, err);
    if (status == LF_OK)
        engine->movie.next = drawing;
    else
        drop_drawing(&drawing);
    return status;
}

/* Draws the views of the current frame, if they do not stand as decoded. */
static void draw(lf_engine *engine)
{
    const lf_content *content = engine->content;
    const engine_drawing *drawing = &engine->movie.drawing;
    const lf_layout *layout = &content->layout;
    const lf_views8 *frame = &engine->movie.frame;
    engine->movie.views = *frame;
    if (!drawing->data)
        return;
    const lf_rgbd_picture picture = picture_of(content, frame);
    if (drawing->warp)
        lf_rgbd_warp_run(drawing->warp, &picture, drawing->data, engine->pool);
    else
        lf_standing_views8(&content->standing, frame, drawing->data, engine->pool);
    const size_t row = 3 * (size_t)layout->view_width;
    engine->movie.views = (lf_views8){layout->n_views,
                                      layout->view_width,
                                      layout->view_height,
                                      row * (size_t)layout->view_height,
                                      row,
                                      drawing->data};
}

static bool take_frame(lf_engine *engine, lf_player *player)
{
    const bool news = lf_player_take(player, &engine->movie.frame);
    if (news)
        draw(engine);
    return news;
}

void engine_keep_movie(lf_engine *engine)
{
    drop_drawing(&engine->movie.drawing);
    engine->movie.drawing = engine->movie.next;
    engine->movie.next = (engine_drawing){0};
    if (engine->content->player)
        draw(engine);
}

void engine_take_movie(lf_engine *engine)
{
    lf_player *player = engine->content ? engine->content->player : NULL;
    lf_player_status now;
    if (!player)
        return;
    lf_player_get_status(player, &now);
    look_at_motion(engine, &now);
    if (now.ended || now.still || now.failed)
        lf_wakeup_signal(engine->event_fd);
    if (!take_frame(engine, player))
        return;
    engine->movie.is_fresh = true;
    engine_post_frame(engine, !engine->movie.is_moving);
    if (engine->movie.is_fresh)
        engine->movie.lost++;
    engine->movie.is_fresh = false;
}

static void look_at_depth(lf_engine *engine)
{
    const lf_content *content = engine->content;
    if (!content->is_rgbd)
        return;
    const lf_rgbd_picture picture = picture_of(content, &engine->movie.frame);
    const bool is_coloured = lf_rgbd_look_at(&content->rgbd, &picture).is_coloured;
    pthread_mutex_lock(&engine->lock);
    engine->movie.is_coloured = is_coloured;
    pthread_mutex_unlock(&engine->lock);
}

void engine_begin_movie(lf_engine *engine)
{
    lf_player *player = engine->content->player;
    lf_mailbox_count(engine->mailbox, engine->generation);
    pthread_mutex_lock(&engine->lock);
    engine->movie = (engine_movie){.player = player, .drawing = engine->movie.next};
    engine_hold_movie(engine);
    pthread_mutex_unlock(&engine->lock);
    if (!player)
        return;
    if (lf_player_start(player, on_news, engine) != LF_OK)
        lf_log(LF_LOG_ERROR, "%s: out of memory for a thread; only the first frame is shown",
               engine->content->file);
    engine->movie.is_fresh = take_frame(engine, player);
    if (engine->movie.is_fresh)
        look_at_depth(engine);
    engine->movie.is_moving = true;
}

void engine_end_movie(lf_engine *engine)
{
    lf_player *player = engine->movie.player;
    pthread_mutex_lock(&engine->lock);
    engine->movie.player = NULL;
    engine->news.movie = false;
    pthread_mutex_unlock(&engine->lock);
    if (player)
        lf_player_stop(player);
    engine->movie.is_moving = false;
    drop_drawing(&engine->movie.drawing);
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
    const bool shown = engine->movie.player;
    if (shown) {
        lf_player_get_status(engine->movie.player, &out->player);
        const lf_mailbox_counts counts = lf_mailbox_counted(engine->mailbox);
        out->shown = counts.taken;
        out->is_coloured = engine->movie.is_coloured;
        out->dropped = out->player.dropped + counts.replaced + engine->movie.told_lost;
    }
    pthread_mutex_unlock(&engine->lock);
    return shown;
}

void lf_engine_pause_movie(lf_engine *engine, bool paused)
{
    pthread_mutex_lock(&engine->lock);
    engine->movie.is_held = paused;
    engine_hold_movie(engine);
    pthread_cond_broadcast(&engine->wake);
    pthread_mutex_unlock(&engine->lock);
}
