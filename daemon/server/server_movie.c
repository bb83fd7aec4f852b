/* The video that is shown, and the slideshow that it may be an entry of. */
#include <stdio.h>

#include "base/log.h"
#include "daemon/server/server_internal.h"

/* Fewer dropped frames are no sign of a video that is too heavy. */
#define MANY_DROPPED 50

void lf_server_hold_movie(lf_server *server)
{
    const lf_playlist_state now = lf_playlist_now(server->gallery.playlist);
    if (now.paused != server->gallery.holds)
        lf_engine_pause_movie(server->engine, now.paused);
    server->gallery.holds = now.paused;
    /* while the next entry loads, the last frame of the one before stays */
    if (server->content && server->content->player && !now.waits)
        lf_player_set_once(server->content->player, now.once);
}

/* One line for each failure: the slideshow has its own. */
static void take_failure(lf_gallery *gallery, int64_t generation, const lf_error *err)
{
    if (lf_playlist_now(gallery->playlist).waits) /* looked at again when the entry is loaded */
        return;
    if (!lf_playlist_played(gallery->playlist, generation, err) && gallery->failed != generation)
        lf_log_error(err);
    gallery->failed = generation;
}

static bool shows_movie(const lf_server *server)
{
    return server->content && server->content->player;
}

bool lf_server_is_paused(const lf_server *server)
{
    lf_movie_status now;
    if (shows_movie(server) && lf_engine_get_movie(server->engine, &now))
        return now.player.paused;
    return lf_engine_get_controls(server->engine).paused;
}

void lf_server_pause(lf_server *server, bool paused)
{
    lf_engine_controls controls = lf_engine_get_controls(server->engine);
    const bool movie = shows_movie(server);
    if (movie && lf_playlist_now(server->gallery.playlist).playing)
        lf_playlist_pause(server->gallery.playlist, paused);
    else if (movie)
        lf_engine_pause_movie(server->engine, paused);
    if (controls.paused == paused || (movie && paused))
        return;
    controls.paused = paused;
    lf_engine_set_controls(server->engine, &controls);
}

void lf_server_look_at_movie(lf_server *server)
{
    lf_gallery *gallery = &server->gallery;
    const int64_t generation = server->last.generation;
    lf_movie_status now;
    if (!lf_engine_get_movie(server->engine, &now))
        return;
    const bool more = generation == gallery->round_of && now.player.rounds > gallery->rounds;
    gallery->round_of = generation;
    gallery->rounds = now.player.rounds;
    if (now.player.still)
        lf_playlist_still(gallery->playlist, generation);
    if (now.player.failed)
        take_failure(gallery, generation, &now.player.err);
    else if (now.player.ended || more)
        (void)lf_playlist_played(gallery->playlist, generation, NULL);
    lf_server_hold_movie(server); /* another load may have replaced the player */
}

void lf_server_entry_loaded(lf_server *server, const lf_load *load)
{
    const bool failed = load->status != LF_OK;
    if (!failed) {
        lf_engine_controls controls = lf_engine_get_controls(server->engine);
        controls.paused = false; /* an entry plays, whatever was paused before it */
        lf_engine_set_controls(server->engine, &controls);
        server->gallery.holds = false;
        lf_server_hold_movie(server);
    }
    lf_playlist_loaded(server->gallery.playlist, load->generation,
                       !failed && server->content->player, failed ? &load->err : NULL);
    lf_server_look_at_movie(server); /* it may have ended already */
}

bool lf_server_movie_warning(const lf_server *server, int index, char out[LF_MOVIE_WARNING])
{
    lf_movie_status now;
    if (!shows_movie(server) || !lf_engine_get_movie(server->engine, &now))
        return false;
    const char *file = server->content->file;
    if (index == 0 && now.is_coloured)
        snprintf(out, LF_MOVIE_WARNING, "%s: the depth half has colours; it may not be depth",
                 file);
    else if (index == 1 && now.dropped >= MANY_DROPPED && now.dropped > now.shown)
        snprintf(out, LF_MOVIE_WARNING,
                 "%s: most frames are dropped, because they come too fast; use a smaller video or "
                 "fewer frames a second",
                 file);
    else
        return false;
    return true;
}

void lf_server_warn_of_movie(lf_server *server)
{
    lf_gallery *gallery = &server->gallery;
    char text[LF_MOVIE_WARNING];
    if (gallery->warned_of != server->generation)
        gallery->warned = 0;
    gallery->warned_of = server->generation;
    for (int i = 0; i < LF_MOVIE_WARNINGS; i++) {
        if ((gallery->warned >> i & 1) != 0 || !lf_server_movie_warning(server, i, text))
            continue;
        lf_log(LF_LOG_WARNING, "%s", text);
        gallery->warned |= 1u << i;
    }
}
