/* The video that is shown, and the slideshow that it may be an entry of. */
#include "daemon/server/server_internal.h"

void lf_server_hold_movie(lf_server *server)
{
    const bool paused = lf_playlist_now(server->gallery.playlist).paused;
    if (paused != server->gallery.holds)
        lf_engine_pause_movie(server->engine, paused);
    server->gallery.holds = paused;
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
    if (now.player.failed || now.player.ended || more)
        lf_playlist_played(gallery->playlist, generation,
                           now.player.failed ? &now.player.err : NULL);
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
