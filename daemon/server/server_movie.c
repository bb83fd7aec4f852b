/* The video that is shown, and the slideshow that it may be an entry of. */
#include "daemon/server/server_internal.h"

#include "base/log.h"

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
        server->gallery.holds = false;
        lf_server_hold_movie(server);
    }
    lf_playlist_loaded(server->gallery.playlist, load->generation,
                       !failed && server->content->player, failed ? &load->err : NULL);
    lf_server_look_at_movie(server); /* it may have ended already */
}
