/* Former names of keys in scene files. Files of every release are read for ever, in silence; the
 * document of a scene (lf_scene_json) has the current names only. One thread per document. */
#ifndef LF_RENDER_FORMER_KEYS_H
#define LF_RENDER_FORMER_KEYS_H

#include <jansson.h>

/* A new reference to a scene's document with current names: `doc` itself if it has no former
 * names, else a copy. A former name next to the current one stays as it is, so that the parser
 * refuses it. NULL: out of memory, or doc is NULL. */
json_t *lf_former_keys_renamed(const json_t *doc);

/* The same of a patch, in which a former name replaces the current one: a client that knows the
 * former name alone may send back a document that it got, with its own change. */
json_t *lf_former_patch_renamed(const json_t *patch);

/* The current name of a former key; NULL: it is not one. */
const char *lf_former_key_now(const char *key);

/* The former name of a key; NULL: it has none. */
const char *lf_former_key(const char *key);

#endif
