/* Playing: one frame after the other, at the clock's pace, and never more than one on its way. */
#include <math.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/thread.h"
#include "daemon/server/server.h"

/* A frame that is not even coarse behind that long is given up for the next. */
#define PATIENCE_SECONDS 3.0

/* A moment that is a frame's own is that frame's, whatever the clock rounds. */
#define ROUNDING 1e-6

struct lf_play {
    sd_event_source *timer;
    bool on;
    lf_play_range range;
    double begun;       /* lf_time_now, of the first frame */
    int frame;          /* sent last; below 0: none was */
    bool on_its_way;    /* to the loader; then it is … */
    int64_t generation; /* … this, … */
    double loaded;      /* … from then on */
};

static void send_frame(lf_server *server, int frame)
{
    lf_play *play = server->play;
    lf_load *load = lf_server_frame_load(frame);
    if (!load) {
        play->on = false;
        return;
    }
    load->played = true;
    play->frame = frame;
    play->on_its_way = true;
    lf_server_load(server, load, NULL);
}

static void wake_at(const lf_play *play, double time)
{
    double seconds = fmax(time - lf_time_now(), 0);
    (void)sd_event_source_set_time_relative(play->timer, (uint64_t)ceil(seconds * 1e6));
    (void)sd_event_source_set_enabled(play->timer, SD_EVENT_ONESHOT);
}

/* To the frame that is due, if the one before has been shown. */
static void go_on(lf_server *server)
{
    lf_play *play = server->play;
    const lf_play_range *r = &play->range;
    if (!play->on || play->on_its_way || lf_server_is_stopping(server))
        return;
    double now = lf_time_now(), n = r->to - r->from + 1.0,
           k = floor((now - play->begun) * r->rate + ROUNDING);
    bool shown =
        server->shown.generation >= play->generation && server->shown.level >= LF_LEVEL_COARSE;
    if (play->frame >= 0 && !shown && now < play->loaded + PATIENCE_SECONDS) {
        wake_at(play, play->loaded + PATIENCE_SECONDS);
        return;
    }
    int due = r->from + (int)(r->once ? fmin(k, n - 1) : fmod(k, n));
    bool last = r->once && due == r->to;
    if (due != play->frame)
        send_frame(server, due);
    else if (!last)
        wake_at(play, play->begun + (k + 1) / r->rate);
    play->on = play->on && !last;
}

static int on_time(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    go_on(context);
    return 0;
}

lf_load *lf_server_frame_load(int frame)
{
    lf_load *load = lf_load_create(LF_LOAD_PATCH);
    if (load)
        load->patch = json_pack("{s:i}", "frame", frame);
    if (load && !load->patch) {
        lf_load_destroy(load);
        return NULL;
    }
    return load;
}

void lf_server_begin_playing(lf_server *server, const lf_play_range *range)
{
    lf_play *play = server->play;
    play->on = true;
    play->range = *range;
    play->begun = lf_time_now();
    play->frame = -1;
    go_on(server);
}

void lf_server_stop_playing(lf_server *server)
{
    server->play->on = false;
    (void)sd_event_source_set_enabled(server->play->timer, SD_EVENT_OFF);
}

void lf_server_played(lf_server *server, const lf_load *load)
{
    lf_play *play = server->play;
    play->on_its_way = false;
    play->generation = load->generation;
    play->loaded = lf_time_now();
    if (load->status == LF_OK) {
        go_on(server);
        return;
    }
    if (load->status != LF_E_CANCELLED)
        lf_log_error(&load->err);
    lf_server_stop_playing(server);
}

void lf_server_play_shown(lf_server *server)
{
    go_on(server);
}

void lf_server_play_file(lf_server *server, bool same)
{
    lf_play *play = server->play;
    play->frame = -1;
    if (same && server->content->scene && lf_scene_has_frames(server->content->scene))
        go_on(server);
    else
        lf_server_stop_playing(server);
}

json_t *lf_server_time_json(const lf_server *server)
{
    const lf_play *play = server->play;
    const lf_play_range *r = &play->range;
    const lf_scene *scene = server->content ? server->content->scene : NULL;
    if (!scene)
        return json_null();
    json_t *time =
        json_pack("{s:i, s:b}", "frame", lf_scene_frame(scene), "playing", (int)play->on);
    if (play->on)
        json_object_update_new(time, json_pack("{s:f, s:i, s:i, s:b}", "rate", r->rate, "from",
                                               r->from, "to", r->to, "loop", (int)!r->once));
    return time;
}

lf_status lf_server_make_play(lf_server *server)
{
    lf_play *play = server->play = lf_calloc(1, sizeof *play);
    if (!play || sd_event_add_time_relative(server->event, &play->timer, CLOCK_MONOTONIC, 0, 0,
                                            on_time, server) < 0)
        return LF_E_NOMEM;
    (void)sd_event_source_set_enabled(play->timer, SD_EVENT_OFF);
    return LF_OK;
}

void lf_server_drop_play(lf_server *server)
{
    if (server->play)
        sd_event_source_disable_unref(server->play->timer);
    lf_free(server->play);
    server->play = NULL;
}
