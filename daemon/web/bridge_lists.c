#include "daemon/web/bridge_lists.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/web/secret.h"

struct lf_orchestration {
    lf_orchestration *next; /* found before this one */
    char token[LF_BRIDGE_TOKEN + 1];
    lf_bridge_list *lists;
};

struct lf_bridge_lists {
    lf_orchestration *latest; /* the one that was found last */
};

/* ---------------------------------------------------------------------------- orchestrations -- */

lf_status lf_bridge_lists_create(lf_bridge_lists **out, lf_error *err)
{
    lf_bridge_lists *lists = lf_calloc(1, sizeof *lists);
    if (!lists)
        return lf_error_set(err, LF_E_NOMEM, "bridge", "out of memory");
    *out = lists;
    return LF_OK;
}

void lf_bridge_lists_destroy(lf_bridge_lists *lists)
{
    while (lists && lists->latest)
        lf_bridge_lists_exit(lists, lists->latest);
    lf_free(lists);
}

static int count_lists(const lf_orchestration *orchestration)
{
    int n = 0;
    for (const lf_bridge_list *list = orchestration->lists; list; list = list->next)
        n++;
    return n;
}

/* Ends the one that was found longest ago, besides the latest and `kept`. with_lists: it must have
 * playlists. False: there is none. */
static bool end_oldest(lf_bridge_lists *lists, const char *kept, bool with_lists)
{
    lf_orchestration *oldest = NULL;
    for (lf_orchestration *o = lists->latest; o; o = o->next)
        if (o != lists->latest && !(kept && strcmp(o->token, kept) == 0) &&
            (!with_lists || o->lists))
            oldest = o;
    if (!oldest)
        return false;
    lf_log(LF_LOG_INFO, "bridge: forgets an orchestration that was not used lately");
    lf_bridge_lists_exit(lists, oldest);
    return true;
}

/* A UUID of version 4. */
static lf_status draw_token(char token[LF_BRIDGE_TOKEN + 1], lf_error *err)
{
    lf_secret drawn;
    lf_status status = lf_secret_draw(&drawn, err);
    if (status != LF_OK)
        return status;
    drawn.text[12] = '4';
    drawn.text[16] = 'a';
    snprintf(token, LF_BRIDGE_TOKEN + 1, "%.8s-%.4s-%.4s-%.4s-%.12s", drawn.text, drawn.text + 8,
             drawn.text + 12, drawn.text + 16, drawn.text + 20);
    return LF_OK;
}

lf_status lf_bridge_lists_enter(lf_bridge_lists *lists, const char *kept, lf_orchestration **out,
                                lf_error *err)
{
    int n = 1;
    lf_orchestration *new = lf_calloc(1, sizeof *new);
    if (!new)
        return lf_error_set(err, LF_E_NOMEM, "bridge", "out of memory");
    lf_status status = draw_token(new->token, err);
    if (status != LF_OK) {
        lf_free(new);
        return status;
    }
    new->next = lists->latest;
    lists->latest = new;
    for (const lf_orchestration *o = new->next; o; o = o->next)
        n++;
    if (n > LF_BRIDGE_ORCHESTRATIONS)
        (void)end_oldest(lists, kept, false);
    *out = new;
    return LF_OK;
}

lf_orchestration *lf_bridge_lists_find(lf_bridge_lists *lists, const char *token)
{
    for (lf_orchestration **at = &lists->latest; *at; at = &(*at)->next) {
        lf_orchestration *found = *at;
        if (strcmp(found->token, token) != 0)
            continue;
        *at = found->next;
        found->next = lists->latest;
        lists->latest = found;
        return found;
    }
    return NULL;
}

void lf_bridge_lists_exit(lf_bridge_lists *lists, lf_orchestration *gone)
{
    lf_orchestration **at = &lists->latest;
    while (*at != gone)
        at = &(*at)->next;
    *at = gone->next;
    while (gone->lists)
        lf_orchestration_drop(gone, gone->lists);
    lf_free(gone);
}

const char *lf_orchestration_token(const lf_orchestration *orchestration)
{
    return orchestration->token;
}

/* --------------------------------------------------------------------------------- playlists -- */

lf_bridge_list *lf_orchestration_list(const lf_orchestration *orchestration, const char *name)
{
    lf_bridge_list *list = orchestration->lists;
    while (list && strcmp(list->name, name) != 0)
        list = list->next;
    return list;
}

void lf_orchestration_drop(lf_orchestration *orchestration, lf_bridge_list *gone)
{
    lf_bridge_list **at = &orchestration->lists;
    while (*at != gone)
        at = &(*at)->next;
    *at = gone->next;
    json_decref(gone->said);
    json_decref(gone->entries);
    json_decref(gone->tags);
    lf_free(gone->name);
    lf_free(gone);
}

/* Room for one more playlist of the latest orchestration. */
static bool make_room(lf_bridge_lists *lists, const char *kept)
{
    for (;;) {
        int n = 0;
        for (const lf_orchestration *o = lists->latest; o; o = o->next)
            n += count_lists(o);
        if (n < LF_BRIDGE_PLAYLISTS)
            return true;
        if (!end_oldest(lists, kept, true))
            return false;
    }
}

static lf_bridge_list *add_list(lf_orchestration *orchestration, const char *name)
{
    lf_bridge_list *new = lf_calloc(1, sizeof *new);
    if (!new)
        return NULL;
    new->next = orchestration->lists;
    orchestration->lists = new;
    new->name = lf_strdup(name);
    new->said = json_array();
    new->entries = json_array();
    new->tags = json_array();
    if (new->name &&new->said &&new->entries &&new->tags)
        return new;
    lf_orchestration_drop(orchestration, new);
    return NULL;
}

lf_status lf_orchestration_make(lf_bridge_lists *lists, lf_orchestration *orchestration,
                                const char *name, bool loop, const char *kept, lf_bridge_list **out,
                                lf_error *err)
{
    lf_bridge_list *list = lf_orchestration_list(orchestration, name);
    if (name[0] == '\0' || strlen(name) > LF_BRIDGE_MAX_NAME)
        return lf_error_set(err, LF_E_ARG, "name", "expects 1 to %d bytes", LF_BRIDGE_MAX_NAME);
    if (list) {
        json_array_clear(list->said);
        json_array_clear(list->entries);
        json_array_clear(list->tags);
    } else if (!make_room(lists, kept)) {
        return lf_error_set(err, LF_E_BUSY, "instance_playlist",
                            "there are %d playlists; delete one first", LF_BRIDGE_PLAYLISTS);
    } else {
        list = add_list(orchestration, name);
    }
    if (!list)
        return lf_error_set(err, LF_E_NOMEM, "instance_playlist", "out of memory");
    list->loop = loop;
    *out = list;
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- entries -- */

static size_t bytes_of(const json_t *json)
{
    return json_dumpb(json, NULL, 0, JSON_COMPACT | JSON_ENCODE_ANY);
}

/* All of a playlist, with `more` bytes and without `less`. */
static lf_status check_bytes(const lf_bridge_list *list, size_t more, size_t less, lf_error *err)
{
    const size_t now = bytes_of(list->said) + bytes_of(list->entries) + bytes_of(list->tags);
    return now - less + more <= LF_BRIDGE_LIST_BYTES
               ? LF_OK
               : lf_error_set(err, LF_E_BUSY, "playlist",
                              "its entries are longer than %zu KiB together",
                              LF_BRIDGE_LIST_BYTES >> 10);
}

int lf_bridge_list_length(const lf_bridge_list *list)
{
    return (int)json_array_size(list->entries);
}

/* Takes all three. */
static bool put(lf_bridge_list *list, size_t at, json_t *said, json_t *entry, json_t *tag)
{
    if (json_array_insert_new(list->said, at, said) != 0) {
        json_decref(entry);
        json_decref(tag);
        return false;
    }
    if (json_array_insert_new(list->entries, at, entry) != 0) {
        json_array_remove(list->said, at);
        json_decref(tag);
        return false;
    }
    if (json_array_insert_new(list->tags, at, tag) == 0)
        return true;
    json_array_remove(list->said, at);
    json_array_remove(list->entries, at);
    return false;
}

lf_status lf_bridge_list_insert(lf_bridge_list *list, int index, json_t *said, json_t *entry,
                                json_t *tag, int *out_index, lf_error *err)
{
    const int n = lf_bridge_list_length(list), at = index < 0 || index > n ? n : index;
    lf_status status = LF_OK;
    if (n == LF_BRIDGE_ENTRIES)
        status = lf_error_set(err, LF_E_BUSY, "playlist", "it has %d entries already", n);
    else
        status = check_bytes(list, bytes_of(said) + bytes_of(entry) + bytes_of(tag), 0, err);
    if (status != LF_OK) {
        json_decref(said);
        json_decref(entry);
        json_decref(tag);
        return status;
    }
    if (!put(list, (size_t)at, said, entry, tag))
        return lf_error_set(err, LF_E_NOMEM, "playlist", "out of memory");
    *out_index = at;
    return LF_OK;
}

lf_status lf_bridge_list_change(lf_bridge_list *list, int index, json_t *said, json_t *entry,
                                lf_error *err)
{
    const size_t at = (size_t)index;
    lf_status status = check_bytes(list, bytes_of(said) + bytes_of(entry),
                                   bytes_of(json_array_get(list->said, at)) +
                                       bytes_of(json_array_get(list->entries, at)),
                                   err);
    if (status != LF_OK) {
        json_decref(said);
        json_decref(entry);
        return status;
    }
    json_array_set_new(list->said, at, said);
    json_array_set_new(list->entries, at, entry);
    return LF_OK;
}
