/* pages: the files of the web page (web/page/) and the schema of scenes, compiled in: no request
 * reaches a file system. Thread: any. */
#ifndef LF_DAEMON_WEB_PAGES_H
#define LF_DAEMON_WEB_PAGES_H

#include <stddef.h>

typedef struct lf_page {
    const char *path; /* of the request: "/", "/main.js" */
    const char *type; /* Content-Type */
    const unsigned char *data;
    size_t n;
} lf_page;

/* Also finds the schema of scenes. NULL: no such page. */
const lf_page *lf_page_find(const char *path);
/* The file of the web page with this index; NULL after the last. */
const lf_page *lf_page_at(int index);

#endif
