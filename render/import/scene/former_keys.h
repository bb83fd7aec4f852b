/* Former names of keys in scene files. Files of every release are read for ever, in silence; the
 * document of a scene (lf_scene_json) has the current names only. One thread per document. */
#ifndef LF_RENDER_FORMER_KEYS_H
#define LF_RENDER_FORMER_KEYS_H

#include <jansson.h>

/* A new reference to a scene's document, or to a patch of one, with current names: `doc` itself if
 * it has no former names, else a copy. A former name next to the current one stays as it is, so
 * that the parser refuses it. NULL: out of memory, or doc is NULL. */
json_t *lf_former_keys_renamed(const json_t *doc);

/* The former name of a key; NULL: it has none. */
const char *lf_former_key(const char *key);

#endif
