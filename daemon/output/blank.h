/* Pictures in which nothing is to be seen. Thread: any. */
#ifndef LF_DAEMON_BLANK_H
#define LF_DAEMON_BLANK_H

#include "quilt/quilt.h"
#include "render/render.h"

/* All pixels of all views are below half a code, or of the same code. */
typedef enum lf_blank { LF_BLANK_NOT, LF_BLANK_BLACK, LF_BLANK_PLAIN } lf_blank;

lf_blank lf_blank_of_views8(const lf_views8 *views);
/* As film shows them. Takes as long as reading them only where they are blank. */
lf_blank lf_blank_of_views32(const lf_views32 *views, const lf_film_settings *film);

/* What is to be said, in the words of quiltrender or of the daemon; NULL: nothing. */
const char *lf_blank_words(lf_blank blank, bool of_daemon);
/* The same where lf_scene_is_seen says that no object is. */
const char *lf_unseen_words(bool of_daemon);

#endif
