#include "base/image_exr.h"

#include <stdio.h>
#include <string.h>

/* A layer's name: the part before the last point, "" for none. */
typedef struct layer {
    const char *name;
    int length;
} layer;

typedef struct parts {
    lf_exr_input *in;
    int n;
} parts;

enum { NAME = 160, LIST = 300 };

void lf_exr_list(char *list, size_t size, const char *name)
{
    size_t used = strlen(list), n = strlen(name);
    if (used + n + 8 < size)
        snprintf(list + used, size - used, "%s%s", used ? ", " : "", name);
    else if (used >= 3 && used + 6 < size && strcmp(list + used - 3, "...") != 0)
        snprintf(list + used, size - used, ", ...");
}

/* The channels of a part with flat pixels; NULL: not flat. */
static const exr_attr_chlist_t *channels_of(const lf_exr_input *in, int part)
{
    const exr_attr_chlist_t *channels = NULL;
    exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
    if (exr_get_storage(in->exr, part, &storage) != EXR_ERR_SUCCESS ||
        (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED) ||
        exr_get_channels(in->exr, part, &channels) != EXR_ERR_SUCCESS)
        return NULL;
    return channels;
}

static layer layer_of(const char *channel)
{
    const char *point = strrchr(channel, '.');
    return (layer){channel, point ? (int)(point - channel) : 0};
}

static bool is_in(const char *channel, layer l)
{
    layer own = layer_of(channel);
    return own.length == l.length && memcmp(own.name, l.name, (size_t)l.length) == 0;
}

/* The channel of this name in a layer; NULL: it has none. */
static const char *find(const exr_attr_chlist_t *channels, layer l, const char *name)
{
    for (int i = 0; i < channels->num_channels; i++) {
        const char *channel = channels->entries[i].name.str;
        if (is_in(channel, l) && strcmp(channel + l.length + (l.length > 0), name) == 0)
            return channel;
    }
    return NULL;
}

/* Takes R, G and B of a layer, or its Y. */
static bool take_colours(lf_exr_input *in, int part, layer l, bool grey)
{
    const exr_attr_chlist_t *channels = channels_of(in, part);
    const char *const names[] = {grey ? "Y" : "R", "G", "B"};
    const char *found[3] = {NULL};
    for (int c = 0; c < (grey ? 1 : 3); c++)
        if (!(found[c] = find(channels, l, names[c])))
            return false;
    /* normals and positions also have a Y */
    if (grey && l.length > 0 && (find(channels, l, "X") || find(channels, l, "Z")))
        return false;
    in->part = part;
    in->grey = grey;
    memcpy(in->channel, found, sizeof found);
    in->named = part == 0 && l.length == 0;
    in->chroma = grey && l.length == 0 && find(channels, l, "RY") && find(channels, l, "BY");
    return true;
}

static bool find_named(const parts *p)
{
    for (int part = 0; part < p->n; part++)
        if (channels_of(p->in, part) && (take_colours(p->in, part, (layer){"", 0}, false) ||
                                         take_colours(p->in, part, (layer){"", 0}, true)))
            return true;
    return false;
}

static bool is_first_of_layer(const exr_attr_chlist_t *channels, int at)
{
    layer l = layer_of(channels->entries[at].name.str);
    for (int i = 0; i < at; i++)
        if (is_in(channels->entries[i].name.str, l))
            return false;
    return true;
}

/* Counts the layers with colours; uses the last one. */
static int find_layers(const parts *p, bool grey)
{
    int n = 0;
    for (int part = 0; part < p->n; part++) {
        const exr_attr_chlist_t *channels = channels_of(p->in, part);
        for (int i = 0; channels && i < channels->num_channels; i++)
            if (is_first_of_layer(channels, i))
                n += take_colours(p->in, part, layer_of(channels->entries[i].name.str), grey);
    }
    return n;
}

static bool is_alpha(const char *channel)
{
    static const char *const names[] = {"A", "AR", "AG", "AB"};
    layer l = layer_of(channel);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(channel + l.length + (l.length > 0), names[i]) == 0)
            return true;
    return false;
}

/* Counts the channels, with or without alpha; uses the last one as grey. */
static int find_channels(const parts *p, bool alpha)
{
    int n = 0;
    lf_exr_input *in = p->in;
    for (int part = 0; part < p->n; part++) {
        const exr_attr_chlist_t *channels = channels_of(in, part);
        for (int i = 0; channels && i < channels->num_channels; i++) {
            if (!alpha && is_alpha(channels->entries[i].name.str))
                continue;
            n++;
            in->part = part;
            in->grey = true;
            in->named = in->chroma = false;
            in->channel[0] = channels->entries[i].name.str;
        }
    }
    return n;
}

static bool is_taken(const lf_exr_input *in, const char *channel)
{
    for (int c = 0; c < (in->grey ? 1 : 3); c++)
        if (channel == in->channel[c])
            return true;
    return in->chroma && (strcmp(channel, "RY") == 0 || strcmp(channel, "BY") == 0);
}

/* Appends "DEPTH: Z", with part names if the file has several parts. */
static void list_channel(const parts *p, int part, const char *channel, char list[LIST])
{
    const char *name = NULL;
    char text[NAME];
    bool named = p->n > 1 && exr_get_name(p->in->exr, part, &name) == EXR_ERR_SUCCESS && name;
    snprintf(text, sizeof text, "%.60s%s%.60s", named ? name : "", named ? ": " : "", channel);
    lf_exr_list(list, LIST, text);
}

/* Explains the refusal: there are no suitable channels, or too many to choose from. */
static lf_status refuse(const parts *p)
{
    const lf_exr_session *s = p->in->session;
    char list[LIST] = "";
    bool deep = p->n > 0;
    for (int part = 0; part < p->n; part++) {
        const exr_attr_chlist_t *channels = channels_of(p->in, part);
        deep = deep && !channels;
        for (int i = 0; channels && i < channels->num_channels; i++)
            list_channel(p, part, channels->entries[i].name.str, list);
    }
    if (deep)
        return lf_error_set(s->err, LF_E_FORMAT, s->source->where,
                            "deep EXR files are not supported; save flat scan lines or tiles");
    return lf_error_set(
        s->err, LF_E_FORMAT, s->source->where,
        "the EXR has none of the channels R, G, B and Y; found %s; save the image as R, G, B",
        list[0] ? list : "none");
}

/* The layer of a part's first view, if even that one is a layer (OpenEXR's ImfMultiView.h). */
static bool find_first_view(const parts *p)
{
    for (int part = 0; part < p->n; part++) {
        const exr_attribute_t *views = NULL;
        if (!channels_of(p->in, part) ||
            exr_get_attribute_by_name(p->in->exr, part, "multiView", &views) != EXR_ERR_SUCCESS ||
            !views || views->type != EXR_ATTR_STRING_VECTOR || views->stringvector->n_strings < 1)
            continue;
        const exr_attr_string_t *first = &views->stringvector->strings[0];
        if (take_colours(p->in, part, (layer){first->str, first->length}, false))
            return true;
    }
    return false;
}

static lf_status choose(const parts *p)
{
    if (find_named(p) || find_first_view(p))
        return LF_OK;
    int layers = find_layers(p, false);
    if (layers > 0)
        return layers == 1 ? LF_OK : refuse(p);
    if (find_layers(p, true) == 1 || find_channels(p, false) == 1)
        return LF_OK;
    return find_channels(p, true) == 1 ? LF_OK : refuse(p);
}

/* Unused alpha is not noted: colours are premultiplied, so they are the colours in front of
 * black. */
static void note_others(const parts *p)
{
    const lf_exr_input *in = p->in;
    char list[LIST] = "";
    if (!in->session->source->meta)
        return;
    for (int part = 0; part < p->n; part++) {
        const exr_attr_chlist_t *channels = channels_of(in, part);
        if (!channels)
            list_channel(p, part, "deep pixels", list);
        for (int i = 0; channels && i < channels->num_channels; i++) {
            const char *channel = channels->entries[i].name.str;
            if (part == in->part && (is_taken(in, channel) || is_alpha(channel)))
                continue;
            list_channel(p, part, channel, list);
        }
    }
    if (list[0])
        lf_image_note(&in->session->source->meta->notes, "ignored channels: %s", list);
}

static lf_status check_sampling(lf_exr_input *in)
{
    const exr_attr_chlist_t *channels = channels_of(in, in->part);
    const lf_exr_session *s = in->session;
    for (int i = 0; i < channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *channel = &channels->entries[i];
        in->half = in->half || channel->pixel_type == EXR_PIXEL_HALF;
        if (!in->chroma && (channel->x_sampling != 1 || channel->y_sampling != 1))
            return lf_error_set(
                s->err, LF_E_FORMAT, s->source->where,
                "only Y, RY and BY may be subsampled in an EXR; save it without subsampling");
    }
    return LF_OK;
}

static lf_status check_windows(lf_exr_input *in)
{
    int64_t data_w = (int64_t)in->data.max.x - in->data.min.x + 1,
            data_h = (int64_t)in->data.max.y - in->data.min.y + 1;
    int64_t width = (int64_t)in->display.max.x - in->display.min.x + 1;
    int64_t height = (int64_t)in->display.max.y - in->display.min.y + 1;
    const lf_exr_session *s = in->session;
    lf_status status = lf_image_check_shape(s->source, width, height, 12, s->err);
    if (status == LF_OK)
        status = lf_image_check_shape(s->source, data_w, data_h, 12, s->err);
    in->data_width = (int)data_w;
    in->data_height = (int)data_h;
    return status;
}

lf_status lf_exr_read_header(lf_exr_input *in)
{
    parts p = {.in = in};
    exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
    exr_result_t rv = exr_get_count(in->exr, &p.n);
    if (rv != EXR_ERR_SUCCESS)
        return lf_exr_fail(in->session, rv);
    lf_status status = choose(&p);
    if (status != LF_OK)
        return status;
    in->session->message[0] = 0; /* the library reports missing attributes as errors */
    rv = exr_get_storage(in->exr, in->part, &storage);
    if (rv == EXR_ERR_SUCCESS)
        rv = exr_get_compression(in->exr, in->part, &in->compression);
    if (rv == EXR_ERR_SUCCESS)
        rv = exr_get_data_window(in->exr, in->part, &in->data);
    if (rv == EXR_ERR_SUCCESS)
        rv = exr_get_display_window(in->exr, in->part, &in->display);
    if (rv != EXR_ERR_SUCCESS)
        return lf_exr_fail(in->session, rv);
    in->tiled = storage == EXR_STORAGE_TILED;
    note_others(&p);
    lf_exr_read_attributes(in);
    status = check_windows(in);
    return status == LF_OK ? check_sampling(in) : status;
}
