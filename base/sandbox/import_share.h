/* Divides lf_import_memory among readers that run at once. Each first gets its share; if that is
 * too little, it runs again alone with all of the memory. Thread: any. */
#ifndef LF_BASE_IMPORT_SHARE_H
#define LF_BASE_IMPORT_SHARE_H

#include "base/sandbox/import.h"

typedef struct lf_import_share {
    uint64_t memory; /* bytes for one reader */
    bool is_whole;   /* all of the memory */
} lf_import_share;

/* To be called before a reader is started. Waits for other readers to end if it runs alone, or if
 * shares would be too small to start with. After the reader has ended, the same thread must call
 * lf_import_share_end. */
lf_import_share lf_import_share_begin(bool alone);
void lf_import_share_end(void);

#endif
