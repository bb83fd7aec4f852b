/* The commands of the older protocol. */
#include "daemon/web/driver_internal.h"

#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "daemon/web/demo.h"
#include "daemon/web/panel_info.h"
#include "daemon/wire/rpc.h"

#define ASK_S 8u
#define SHOW_S 60u
#define MAX_TILES 64

/* -------------------------------------------------------------------------------------- info -- */

static void begin_init(lf_driver_client *client)
{
    lf_driver_answer(client, json_object());
}

/* panel: taken; NULL: there is none. */
static void answer_info(lf_driver_client *client, json_t *panel)
{
    json_t *devices = json_array();
    if (panel)
        json_array_append_new(devices, panel);
    lf_driver_answer(client, json_pack("{s:o}", "devices", devices));
}

static void begin_info(lf_driver_client *client)
{
    const lf_panel_only *lent = client->driver->panel_only;
    const json_t *calibration = lf_panel_only_calibration(lent);
    if (calibration)
        answer_info(client, lf_panel_info(calibration, lf_panel_only_device(lent)));
    else
        lf_driver_ask(client, "device.calibration", NULL, -1, ASK_S);
}

/* First the calibration has come, then the status. */
static void go_on_info(lf_driver_client *client)
{
    const json_t *result = NULL;
    int code = 0;
    lf_error err = {0};
    lf_status status = lf_driver_result(client, &result, &code, &err);
    if (status != LF_OK && code == LF_RPC_NO_DEVICE)
        answer_info(client, NULL);
    else if (status != LF_OK)
        lf_driver_fail(client, LF_DRIVER_FAILED, err.what, json_pack("{s:[]}", "devices"));
    else if (client->calibration)
        answer_info(client, lf_panel_info(client->calibration, json_object_get(result, "device")));
    else {
        client->calibration = json_deep_copy(result);
        lf_driver_ask(client, "status", NULL, -1, ASK_S);
    }
}

/* ---------------------------------------------------------------------------------- settings -- */

/* Fails with the name of the key. */
static void fail_key(lf_driver_client *client, const char *key, const char *expected)
{
    char words[160];
    snprintf(words, sizeof words, "%s: expects %s", key, expected);
    lf_driver_fail(client, LF_DRIVER_BAD_COMMAND, words, NULL);
}

/* A whole number, which programs also send as a float. False: it is another thing, or out of
 * range. Without the key *out stays. */
static bool read_whole(const json_t *settings, const char *key, int max, int *out)
{
    const json_t *value = json_object_get(settings, key);
    const double number = json_number_value(value);
    if (!value)
        return true;
    if (!json_is_number(value) || number != floor(number) || number < 1 || number > max)
        return false;
    *out = (int)number;
    return true;
}

static bool is_set(const json_t *value)
{
    return json_is_true(value) || json_number_value(value) != 0;
}

/* The parameters of quilt.show. NULL: the command has failed. */
static json_t *read_settings(lf_driver_client *client, const json_t *settings, const lf_bin *bin)
{
    int columns = 0, rows = 0, views = 0;
    const json_t *aspect = json_object_get(settings, "aspect");
    const bool tiles = read_whole(settings, "vx", MAX_TILES, &columns) &&
                       read_whole(settings, "vy", MAX_TILES, &rows) && columns > 0 && rows > 0;
    if (!tiles) {
        fail_key(client, "vx and vy", "the columns and rows of the quilt, 1 to 64");
        return NULL;
    }
    views = columns * rows;
    if (!read_whole(settings, "vtotal", columns * rows, &views)) {
        fail_key(client, "vtotal", "at most vx times vy views");
        return NULL;
    }
    if (aspect && !json_is_null(aspect) &&
        (!json_is_number(aspect) || !(json_number_value(aspect) >= 0))) {
        fail_key(client, "aspect", "a number above 0");
        return NULL;
    }
    json_t *params = json_pack("{s:i, s:i, s:i}", "columns", columns, "rows", rows, "views", views);
    if (params && json_number_value(aspect) > 0)
        json_object_set_new(params, "aspect", json_real(json_number_value(aspect)));
    if (params && lf_bin_width(bin) > 0) {
        json_object_set_new(params, "width", json_integer(lf_bin_width(bin)));
        json_object_set_new(params, "height", json_integer(lf_bin_height(bin)));
    }
    if (!params)
        lf_driver_fail(client, LF_DRIVER_FAILED, "out of memory", NULL);
    return params;
}

/* quiltd shows on one panel: -1 and 0 mean it. */
static bool means_our_panel(const lf_driver_client *client)
{
    const json_t *target = json_object_get(client->params, "targetDisplay");
    if (!target)
        target = json_object_get(json_object_get(client->message, "cmd"), "targetDisplay");
    return !json_is_number(target) || json_number_value(target) <= 0;
}

static void fail_target(lf_driver_client *client)
{
    lf_driver_fail(client, LF_DRIVER_NO_PANEL,
                   "targetDisplay: there is only one panel, which has the number 0", NULL);
}

/* -------------------------------------------------------------------------------------- show -- */

/* Shows a quilt if there is a panel: without one quiltd takes it, too. params: taken. fd: kept. */
static void look_and_show(lf_driver_client *client, json_t *params, int fd)
{
    client->quilt = params;
    client->quilt_fd = fcntl(fd, F_DUPFD_CLOEXEC, 0);
    if (!params || client->quilt_fd < 0)
        lf_driver_fail(client, LF_DRIVER_FAILED, "out of memory or of files", NULL);
    else
        lf_driver_ask(client, "device.calibration", NULL, -1, ASK_S);
}

static void ask_show(lf_driver_client *client, const json_t *settings, const lf_bin *bin)
{
    json_t *params = read_settings(client, settings, bin);
    if (params)
        look_and_show(client, params, lf_bin_fd(bin));
}

/* Shows a quilt of our own. */
static void ask_show_own(lf_driver_client *client, bool demo)
{
    lf_error err = {0};
    int fd = -1;
    if ((demo ? lf_demo_bars(&fd, &err) : lf_demo_black(&fd, &err)) != LF_OK) {
        lf_driver_fail(client, LF_DRIVER_FAILED, err.what, NULL);
        return;
    }
    json_t *params = demo ? json_pack("{s:i, s:i, s:i, s:i, s:s}", "columns", LF_DEMO_COLUMNS,
                                      "rows", LF_DEMO_ROWS, "width", LF_DEMO_WIDTH, "height",
                                      LF_DEMO_HEIGHT, "name", "demo")
                          : json_pack("{s:i, s:i, s:i, s:i, s:s}", "columns", 1, "rows", 1, "width",
                                      1, "height", 1, "name", "black");
    look_and_show(client, params, fd);
    close(fd);
}

/* The image of the message; false: the command has failed. */
static bool take_bin(lf_driver_client *client)
{
    lf_error err = {0};
    lf_status status = client->bin
                           ? lf_bin_finish(client->bin, &err)
                           : lf_error_set(&err, LF_E_ARG, "bin", "the message has no image");
    if (status == LF_OK)
        return true;
    lf_driver_fail(
        client, status == LF_E_ARG || status == LF_E_FORMAT ? LF_DRIVER_NO_IMAGE : LF_DRIVER_FAILED,
        err.what, NULL);
    return false;
}

static const char *name_of(const lf_driver_client *client)
{
    const char *name =
        json_string_value(json_object_get(json_object_get(client->params, "quilt"), "name"));
    return name ? name : json_string_value(json_object_get(client->params, "name"));
}

static void show_cached(lf_driver_client *client, const json_t *settings)
{
    const char *name = name_of(client);
    const lf_bin *bin = NULL;
    const json_t *kept = NULL;
    if (!name || !lf_cache_find(client->driver, name, &bin, &kept))
        lf_driver_fail(client, LF_DRIVER_NOT_CACHED, "no image of this name is kept", NULL);
    else
        ask_show(client, json_object_get(settings, "vx") ? settings : kept, bin);
}

static void begin_show(lf_driver_client *client)
{
    const json_t *quilt = json_object_get(client->params, "quilt"),
                 *settings = json_object_get(quilt, "settings");
    const char *source = json_string_value(json_object_get(client->params, "source"));
    if (!means_our_panel(client))
        fail_target(client);
    else if (!quilt && !client->bin)
        ask_show_own(client, true);
    else if (source && strcmp(source, "cache") == 0)
        show_cached(client, settings);
    else if (source && strcmp(source, "bindata") != 0)
        fail_key(client, "source", "bindata or cache");
    else if (take_bin(client))
        ask_show(client, settings, client->bin);
}

/* There is a panel. */
static void send_quilt(lf_driver_client *client)
{
    json_t *params = client->quilt;
    const int fd = client->quilt_fd;
    client->quilt = NULL;
    client->quilt_fd = -1;
    lf_driver_ask(client, "quilt.show", params, fd, SHOW_S);
    close(fd);
}

/* First the calibration has come, then quiltd has taken the quilt, and at last it shows it, or what
 * was shown after it. */
static void go_on_show(lf_driver_client *client)
{
    const json_t *result = NULL;
    int code = 0;
    lf_error err = {0};
    lf_status status = lf_driver_result(client, &result, &code, &err);
    if (status != LF_OK && client->quilt && code == LF_RPC_NO_DEVICE)
        lf_driver_fail(client, LF_DRIVER_NO_PANEL, "no panel is connected to quiltd", NULL);
    else if (status != LF_OK)
        lf_driver_fail(client,
                       code == LF_RPC_INVALID_PARAMS || code == LF_RPC_BAD_SCENE
                           ? LF_DRIVER_NO_IMAGE
                           : LF_DRIVER_FAILED,
                       err.what, NULL);
    else if (client->quilt)
        send_quilt(client);
    else if (client->is_taken)
        lf_driver_answer(client, json_object());
    else {
        client->is_taken = true;
        lf_driver_ask(client, "wait",
                      json_pack("{s:O, s:s, s:i}", "generation",
                                json_object_get(result, "generation"), "for", "coarse", "timeout",
                                SHOW_S - 2),
                      -1, SHOW_S);
    }
}

static void begin_wipe(lf_driver_client *client)
{
    if (means_our_panel(client))
        ask_show_own(client, false);
    else
        fail_target(client);
}

/* ------------------------------------------------------------------------------------- cache -- */

static void begin_cache(lf_driver_client *client)
{
    const json_t *quilt = json_object_get(client->params, "quilt"),
                 *settings = json_object_get(quilt, "settings");
    const char *name = name_of(client);
    lf_error err = {0};
    if (!name) {
        fail_key(client, "name", "the name of the image");
        return;
    }
    if (!take_bin(client))
        return;
    if (lf_cache_put(client->driver, name, client->bin, settings, &err) != LF_OK) {
        lf_driver_fail(client, LF_DRIVER_BAD_COMMAND, err.what, NULL);
        return;
    }
    const lf_bin *bin = client->bin;
    client->bin = NULL; /* the cache's */
    if (is_set(json_object_get(client->params, "show")))
        ask_show(client, settings, bin);
    else
        lf_driver_answer(client, json_object());
}

/* Not a failure: programs ask in order to know. */
static void answer_found(lf_driver_client *client, bool found)
{
    lf_driver_answer(client, found ? json_object()
                                   : json_pack("{s:i, s:s}", "error", LF_DRIVER_NOT_CACHED,
                                               "message", "no image of this name is kept"));
}

static void begin_check(lf_driver_client *client)
{
    const char *name = name_of(client);
    const lf_bin *bin = NULL;
    const json_t *settings = NULL;
    answer_found(client, name && lf_cache_find(client->driver, name, &bin, &settings));
}

static void begin_delete(lf_driver_client *client)
{
    const char *name = name_of(client);
    answer_found(client, name && lf_cache_drop(client->driver, name));
}

/* ------------------------------------------------------------------------------------- table -- */

static const lf_command commands[] = {
    {.name = "init", .begin = begin_init},
    {.name = "info", .begin = begin_info, .go_on = go_on_info},
    {.name = "show", .begin = begin_show, .go_on = go_on_show, .shows = true},
    {.name = "cache", .begin = begin_cache, .go_on = go_on_show, .shows = true},
    {.name = "check", .begin = begin_check},
    {.name = "delete", .begin = begin_delete},
    {.name = "wipe", .begin = begin_wipe, .go_on = go_on_show, .shows = true},
    {.name = "hide", .begin = begin_wipe, .go_on = go_on_show, .shows = true},
};

const lf_command *lf_command_find(const json_t *message, const json_t **out_params)
{
    const json_t *cmd = json_object_get(message, "cmd");
    const lf_command *found = NULL;
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        const json_t *params = json_object_get(cmd, commands[i].name);
        if (!params)
            continue;
        if (found)
            return NULL; /* which of both is done would be a secret */
        *out_params = params;
        found = &commands[i];
    }
    return found;
}
