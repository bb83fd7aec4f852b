#include "tests/web/false_slideshow.h"

#include <stdio.h>
#include <string.h>

static bool is_below(const char *file, const char *folder)
{
    return file && strncmp(file, folder, strlen(folder)) == 0;
}

json_t *lf_false_notification(const char *method, json_t *params)
{
    return json_pack("{s:s, s:s, s:o}", "jsonrpc", "2.0", "method", method, "params", params);
}

json_t *lf_false_slideshow_json(const lf_false_slideshow *s)
{
    return json_pack("{s:o, s:i, s:i, s:b, s:b, s:b}", "entries",
                     s->entries ? json_deep_copy(s->entries) : json_array(), "index", s->index,
                     "turn", s->turn, "playing", s->playing, "paused", s->paused, "loop", s->loop);
}

static const char *file_at(const lf_false_slideshow *s, int index)
{
    return json_string_value(json_object_get(json_array_get(s->entries, (size_t)index), "file"));
}

static void note(json_t **notes, json_t *notification)
{
    *notes = *notes ? *notes : json_array();
    json_array_append_new(*notes, notification);
}

static void note_list(const lf_false_slideshow *s, json_t **notes)
{
    note(notes, lf_false_notification("playlist", lf_false_slideshow_json(s)));
}

/* Shows the current entry, or the first of the others that can be shown. */
static void show(lf_false_slideshow *s, lf_false_answer *out)
{
    const int n = (int)json_array_size(s->entries), first = s->index;
    s->playing = true;
    s->turn++;
    note_list(s, &out->before);
    out->result = lf_false_slideshow_json(s);
    if (s->is_hanging)
        return;
    for (int i = 0; i < n; i++) {
        const char *file = file_at(s, (first + i) % n);
        char words[80];
        if (!is_below(file, "/bad") && !s->is_spoilt) {
            s->index = (first + i) % n;
            note(&out->after,
                 lf_false_notification("scene", json_pack("{s:i, s:s, s:i}", "generation", 8,
                                                          "file", file, "turn", s->turn)));
            if (i > 0)
                note_list(s, &out->after);
            return;
        }
        snprintf(words, sizeof words, "playlist: entry %d is skipped: it is not an image at all",
                 (first + i) % n);
        note(&out->after, lf_false_notification(
                              "log", json_pack("{s:s, s:s}", "level", "warning", "text", words)));
    }
    s->playing = false;
    note_list(s, &out->after);
}

static const char *check(const json_t *entries)
{
    size_t i;
    json_t *entry;
    json_array_foreach(entries, i, entry)
    {
        const char *file = json_string_value(json_object_get(entry, "file"));
        const json_t *zoom = json_object_get(entry, "zoom");
        if (is_below(file, "/refused"))
            return "the file is outside the folders that quiltd may read";
        if (is_below(file, "/missing"))
            return "No such file or directory";
        if (zoom && json_number_value(zoom) > 4)
            return "zoom: expects 0.1 to 4";
    }
    return NULL;
}

static void set(lf_false_slideshow *s, const json_t *params, lf_false_answer *out)
{
    json_t *entries = json_object_get(params, "entries");
    out->message = check(entries);
    if (out->message)
        return;
    if (json_is_true(json_object_get(params, "check"))) {
        out->result = json_pack("{s:O}", "entries", entries);
        return;
    }
    json_decref(s->entries);
    s->entries = json_deep_copy(entries);
    s->loop = json_is_true(json_object_get(params, "loop"));
    s->index = 0;
    note_list(s, &out->before);
}

static void change(lf_false_slideshow *s, json_t *params, lf_false_answer *out)
{
    const json_t *index = json_object_get(params, "index");
    json_t *entry = json_array_get(s->entries, (size_t)(index ? json_integer_value(index) : 0));
    json_t *changed = json_pack("[O]", params);
    out->message = check(changed);
    json_decref(changed);
    if (out->message)
        return;
    json_t *before = json_copy(entry);
    json_object_update(entry, params);
    json_object_del(entry, "index");
    if (s->playing && json_integer_value(index) == s->index && !json_equal(before, entry))
        show(s, out);
    json_decref(before);
}

static void play(lf_false_slideshow *s, const json_t *params, lf_false_answer *out)
{
    const json_t *index = json_object_get(params, "index");
    if (json_array_size(s->entries) == 0) {
        out->message = "the playlist has no entries";
        return;
    }
    s->index = index ? (int)json_integer_value(index) : s->index;
    s->paused = false;
    show(s, out);
}

bool lf_false_slideshow_answer(lf_false_slideshow *s, const char *method, json_t *params,
                               lf_false_answer *out)
{
    const int n = (int)json_array_size(s->entries);
    *out = (lf_false_answer){.result = NULL};
    if (!s->on || (strncmp(method, "playlist.", 9) != 0 && strcmp(method, "status") != 0 &&
                   strcmp(method, "device.calibration") != 0))
        return false;
    if (strcmp(method, "status") == 0)
        out->result = json_pack("{s:{s:b}}", "device", "present", !s->no_panel);
    else if (strcmp(method, "device.calibration") == 0 && s->no_panel)
        out->message = "no calibration is known";
    else if (strcmp(method, "device.calibration") == 0)
        out->result = json_pack("{s:s, s:i, s:i, s:f}", "serial", "LKG-P00000", "screenW", 1536,
                                "screenH", 2048, "pitch", 52.0);
    else if (strcmp(method, "playlist.set") == 0)
        set(s, params, out);
    else if (strcmp(method, "playlist.play") == 0)
        play(s, params, out);
    else if (strcmp(method, "playlist.change") == 0)
        change(s, params, out);
    else if (strcmp(method, "playlist.pause") == 0)
        s->paused = s->playing && json_is_true(json_object_get(params, "paused"));
    else if (strcmp(method, "playlist.stop") == 0)
        s->playing = s->paused = false;
    else if (n > 1) {
        s->index = (s->index + (strcmp(method, "playlist.next") == 0 ? 1 : n - 1)) % n;
        show(s, out);
    }
    if (!out->result && !out->message)
        out->result = lf_false_slideshow_json(s);
    return true;
}

void lf_false_slideshow_finish(lf_false_slideshow *s)
{
    json_decref(s->entries);
    s->entries = NULL;
}
