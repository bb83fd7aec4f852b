/* frame.get: checks the call, and answers it when the image is written (daemon/parts/previews.h).
 */
#include <string.h>
#include <unistd.h>

#include "daemon/server/server_internal.h"

static lf_preview_format format_of(const json_t *params)
{
    const char *word = json_string_value(json_object_get(params, "format"));
    int format = LF_PREVIEW_JPEG;
    while (word && lf_preview_format_name(format) &&
           strcmp(word, lf_preview_format_name(format)) != 0)
        format++;
    return (lf_preview_format)format;
}

static lf_status check(const lf_call *call, lf_error *err)
{
    const lf_server *server = call->server;
    if (server->shown.card[0] != '\0')
        return lf_error_set(err, LF_E_STATE, call->method,
                            "the panel shows a card instead of an image");
    if (!server->content)
        return lf_error_set(err, LF_E_STATE, call->method,
                            "there is no image; call scene.load first");
    return lf_previews_check_room(server->gallery.previews, lf_client_serial(call->client), err);
}

void lf_server_preview(lf_call *call)
{
    const json_t *params = call->params;
    lf_error err;
    lf_preview what = {.client = lf_client_serial(call->client),
                       .n_views = lf_param_integer(params, "views", 0),
                       .options = {.width = lf_param_integer(params, "width", 0),
                                   .format = format_of(params),
                                   .quality = lf_param_integer(params, "quality", 75)}};
    lf_deferred *deferred = NULL;
    if (!lf_client_take_fds(call->client, &what.fd, 1)) {
        (void)lf_error_set(&err, LF_E_ARG, call->method,
                           "expects a file descriptor to write to; none came with the call");
        lf_fail(call, &err, false);
        return;
    }
    if (check(call, &err) != LF_OK)
        lf_fail(call, &err, false);
    else
        deferred = lf_defer(call);
    what.call = deferred;
    if (!deferred)
        close(what.fd);
    else if (lf_previews_add(call->server->gallery.previews, &what, &err) != LF_OK)
        lf_deferred_fail(deferred, &err, false);
}

static json_t *written_json(const lf_preview_written *written, lf_preview_format format)
{
    const lf_layout *layout = &written->layout;
    return json_pack("{s:I, s:s, s:f, s:s, s:s, s:i, s:i, s:i, s:i, s:i, s:I}", "generation",
                     (json_int_t)written->generation, "level", lf_level_name(written->level),
                     "passes", written->passes, "image",
                     written->reconstructed ? "denoised" : "unfiltered", "format",
                     lf_preview_format_name((int)format), "columns", layout->columns, "rows",
                     layout->rows, "views", layout->n_views, "width", layout->view_width, "height",
                     layout->view_height, "bytes", (json_int_t)written->bytes);
}

static void on_ended(void *context, const lf_preview *asked, const lf_preview_written *written,
                     const lf_error *err)
{
    lf_server *server = context;
    if (written)
        lf_deferred_reply(asked->call, written_json(written, asked->options.format));
    else
        lf_deferred_fail(asked->call, err, false);
    if (lf_server_is_stopping(server))
        lf_server_shutdown(server);
}

lf_status lf_server_make_previews(lf_server *server)
{
    return lf_previews_create(&server->inbox, server->engine, on_ended, server,
                              &server->gallery.previews);
}
