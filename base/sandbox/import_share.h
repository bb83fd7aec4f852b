/* The memory of readers that run at once: together they have what lf_import_memory says. Each gets
 * its part first, and where that does not do the whole, alone. Thread: any. */
#ifndef LF_BASE_IMPORT_SHARE_H
#define LF_BASE_IMPORT_SHARE_H

#include "base/sandbox/import.h"

typedef struct lf_import_share {
    uint64_t memory; /* bytes for one reader */
    bool is_whole;   /* more is not to be had */
} lf_import_share;

/* Before a reader is started; waits until others have ended where that is necessary: for alone, and
 * where parts would be too small to start with. Each is followed by lf_import_share_end, on the
 * same thread, when the reader has ended. */
lf_import_share lf_import_share_begin(bool alone);
void lf_import_share_end(void);

#endif
