/* quilt.show: a quilt that comes by a descriptor. */
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/server/methods_internal.h"

static lf_status refuse(const lf_call *call, const char *pointer, const char *what, lf_error *err)
{
    return lf_error_set_at(err, LF_E_ARG, call->method, 0, pointer, "%s", what);
}

/* The tiles, and the size of raw pixels. */
static lf_status take_shape(const lf_call *call, bool is_rgbd, lf_sent_quilt *out, lf_error *err)
{
    const json_t *params = call->params;
    const int columns = lf_param_integer(params, "columns", 0),
              rows = lf_param_integer(params, "rows", 0),
              views = lf_param_integer(params, "views", 0),
              width = lf_param_integer(params, "width", 0),
              height = lf_param_integer(params, "height", 0);
    *out = (lf_sent_quilt){true, {columns, rows, views ? views : columns * rows}, width, height};
    if (is_rgbd && (columns || rows || views))
        return refuse(call,
                      columns ? "/columns"
                      : rows  ? "/rows"
                              : "/views",
                      "an image with depth has no tiles; omit columns, rows and views", err);
    if (!is_rgbd && (!columns || !rows))
        return refuse(call, columns ? "/rows" : "/columns",
                      "required parameter is missing, except with rgbd_in", err);
    if (views > columns * rows)
        return lf_error_set_at(err, LF_E_ARG, call->method, 0, "/views",
                               "%d views do not fit into %dx%d tiles", views, columns, rows);
    if (!width != !height)
        return refuse(call, width ? "/width" : "/height",
                      "raw pixels need both width and height; an image file needs neither", err);
    return width && !is_rgbd ? lf_quilt_tiles_check(&out->tiles, width, height, call->method, err)
                             : LF_OK;
}

/* Takes the one descriptor of the call. */
static lf_status take_descriptor(const lf_call *call, lf_load *load, lf_error *err)
{
    const int n = lf_client_count_fds(call->client);
    lf_error inner;
    int fd;
    if (n != 1 || !lf_client_take_fds(call->client, &fd, 1))
        return lf_error_set(err, LF_E_ARG, call->method,
                            "expects one descriptor, of the quilt, but %d came with the call", n);
    load->sent.passed = lf_passed_create();
    lf_status status = load->sent.passed
                           ? lf_sent_quilt_add(&load->words.quilt, load->sent.passed, fd, &inner)
                           : lf_error_set(&inner, LF_E_NOMEM, "", "out of memory");
    if (status == LF_OK)
        return LF_OK;
    close(fd);
    return lf_error_set(err, status, call->method, "%s", inner.what);
}

static lf_status take_quilt(const lf_call *call, lf_load *load, lf_error *err)
{
    const json_t *aspect = json_object_get(call->params, "aspect");
    load->words.said = true;
    load->words.alone = call->server->config.options.alone;
    load->words.photo = call->server->options.photo;
    load->words.photo.aspect = json_number_value(aspect); /* 0: that of a tile */
    load->words.standing = call->server->config.options.standing;
    load->words.standing.rgbd_in = LF_RGBD_IN_AUTO;
    lf_status status = lf_param_from_json(lf_standing_params, call->params, &load->words.standing,
                                          call->method, err);
    if (status == LF_OK)
        status = lf_method_name(call, "quilt", &load->file, err);
    if (status == LF_OK)
        status =
            take_shape(call, lf_rgbd_side_of(&load->words.standing, load->file) != LF_RGBD_IN_OFF,
                       &load->words.quilt, err);
    return status == LF_OK ? take_descriptor(call, load, err) : status;
}

void lf_method_quilt_show(lf_call *call)
{
    lf_error err;
    lf_load *load = lf_load_create(LF_LOAD_FILE);
    if (load && take_quilt(call, load, &err) != LF_OK) {
        lf_method_refuse(call, load, &err, false);
        return;
    }
    lf_method_queue(call, load);
}
