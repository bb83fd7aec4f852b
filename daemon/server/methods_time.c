/* Methods for the shown frame and for playback. */
#include "daemon/server/methods_internal.h"

json_t *lf_time_json(const lf_server *server)
{
    const lf_play_range *played = lf_play_now(server->play);
    const lf_scene *scene = server->content ? server->content->scene : NULL;
    if (!scene)
        return json_null();
    json_t *time =
        json_pack("{s:i, s:b}", "frame", lf_scene_frame(scene), "playing", (int)!!played);
    if (played)
        json_object_update_new(time, json_pack("{s:f, s:f, s:i, s:i, s:b}", "fps", played->rate,
                                               "rate", played->rate, "from", played->from, "to",
                                               played->to, "loop", (int)!played->once));
    return time;
}

/* True if the scene has animation; otherwise the call fails. */
static bool check_moves(lf_call *call)
{
    const lf_content *content = call->server->content;
    lf_error err;
    if (content && content->scene && lf_scene_has_frames(content->scene))
        return true;
    (void)lf_error_set(&err, LF_E_STATE, content ? content->file : call->method, "%s",
                       !content          ? "no scene is loaded; call scene.load first"
                       : content->player ? "a video plays by itself; use render.set paused=true "
                                           "or false"
                       : content->scene  ? "the scene has no animation"
                                         : "a finished picture has no animation");
    lf_fail(call, &err, false);
    return false;
}

void lf_method_time_set(lf_call *call)
{
    lf_play_stop(call->server->play);
    int frame = (int)json_number_value(json_object_get(call->params, "frame"));
    lf_method_queue(call, lf_server_frame_load(frame));
}

void lf_method_time_play(lf_call *call)
{
    const json_t *rate = lf_param_or_former(call->params, "fps", "rate"),
                 *from = json_object_get(call->params, "from"),
                 *loop = json_object_get(call->params, "loop");
    lf_error err;
    if (!check_moves(call))
        return;
    const lf_scene *scene = call->server->content->scene;
    lf_play_range range = {
        .rate = rate ? json_number_value(rate) : lf_scene_rate(scene),
        .from = from ? (int)json_number_value(from) : lf_scene_frame(scene),
        .to = (int)json_number_value(json_object_get(call->params, "to")),
        .once = json_is_false(loop),
    };
    if (range.from > range.to) {
        (void)lf_error_set_at(&err, LF_E_ARG, call->method, 0, "/to",
                              "the range %d to %d ends before it begins; expected from <= to",
                              range.from, range.to);
        lf_fail(call, &err, false);
        return;
    }
    lf_play_begin(call->server->play, &range);
    lf_reply(call, lf_time_json(call->server));
}

void lf_method_time_stop(lf_call *call)
{
    lf_play_stop(call->server->play);
    lf_reply(call, lf_time_json(call->server));
}
