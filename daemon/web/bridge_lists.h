/* bridge_lists: what programs of Bridge have put together: orchestrations, playlists, entries. All
 * of it is bounded. Nothing here knows quiltd. Thread: event. */
#ifndef LF_DAEMON_WEB_BRIDGE_LISTS_H
#define LF_DAEMON_WEB_BRIDGE_LISTS_H

#include <jansson.h>

#include "base/status.h"

#define LF_BRIDGE_ORCHESTRATIONS 8
#define LF_BRIDGE_PLAYLISTS 16 /* of all orchestrations */
#define LF_BRIDGE_ENTRIES 1000
#define LF_BRIDGE_LIST_BYTES ((size_t)256 << 10) /* of the entries of a playlist, as JSON */
#define LF_BRIDGE_MAX_NAME 256
#define LF_BRIDGE_TOKEN 36 /* characters of a UUID */

typedef struct lf_bridge_lists lf_bridge_lists;
typedef struct lf_orchestration lf_orchestration;

typedef struct lf_bridge_list {
    struct lf_bridge_list *next;
    char *name;
    bool loop;
    json_t *said;    /* array: what was said of each entry (lf_bridge_entry_make) */
    json_t *entries; /* array: the same as quiltd takes it */
    json_t *tags;    /* array of strings, which events repeat */
} lf_bridge_list;

LF_NODISCARD lf_status lf_bridge_lists_create(lf_bridge_lists **out, lf_error *err);
/* Accepts NULL. */
void lf_bridge_lists_destroy(lf_bridge_lists *lists);

/* A new orchestration. If there are too many, the one that was found longest ago ends, unless it is
 * the one with the token `kept` (NULL: none). LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bridge_lists_enter(lf_bridge_lists *lists, const char *kept,
                                             lf_orchestration **out, lf_error *err);
/* NULL: there is none with this token. */
lf_orchestration *lf_bridge_lists_find(lf_bridge_lists *lists, const char *token);
/* Ends it, with its playlists. */
void lf_bridge_lists_exit(lf_bridge_lists *lists, lf_orchestration *gone);
const char *lf_orchestration_token(const lf_orchestration *orchestration);

/* NULL: it has no such playlist. */
lf_bridge_list *lf_orchestration_list(const lf_orchestration *orchestration, const char *name);
/* A new playlist without entries. One of the same name is emptied. If there are too many, other
 * orchestrations end, as in lf_bridge_lists_enter. LF_E_ARG: the name is empty or too long;
 * LF_E_BUSY: this orchestration has too many; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_orchestration_make(lf_bridge_lists *lists,
                                             lf_orchestration *orchestration, const char *name,
                                             bool loop, const char *kept, lf_bridge_list **out,
                                             lf_error *err);
void lf_orchestration_drop(lf_orchestration *orchestration, lf_bridge_list *gone);

/* Puts an entry before the one with this index, or at the end. said, entry, tag: taken, also on
 * failure. LF_E_BUSY: there are too many, or they are too long together; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bridge_list_insert(lf_bridge_list *list, int index, json_t *said,
                                             json_t *entry, json_t *tag, int *out_index,
                                             lf_error *err);
/* Replaces an entry that is there. The same errors. */
LF_NODISCARD lf_status lf_bridge_list_change(lf_bridge_list *list, int index, json_t *said,
                                             json_t *entry, lf_error *err);
int lf_bridge_list_length(const lf_bridge_list *list);

#endif
