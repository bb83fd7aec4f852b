/* Blank pictures: all pixels of all views have the same code. Thread: any. */
#ifndef LF_DAEMON_BLANK_H
#define LF_DAEMON_BLANK_H

#include "quilt/quilt.h"
#include "render/render.h"

/* BLACK: all pixels of all views are below half a code. PLAIN: all have the same other code. */
typedef enum lf_blank { LF_BLANK_NOT, LF_BLANK_BLACK, LF_BLANK_PLAIN } lf_blank;

lf_blank lf_blank_of_views8(const lf_views8 *views);
/* The views as film tone-maps them. Reads all pixels only if they are blank. */
lf_blank lf_blank_of_views32(const lf_views32 *views, const lf_film_settings *film);

/* The warning for a blank picture, worded for quiltrender or for the daemon; NULL: none. */
const char *lf_blank_words(lf_blank blank, bool of_daemon);
/* The warning if lf_scene_is_seen finds that the camera sees no object. */
const char *lf_unseen_words(bool of_daemon);

#endif
