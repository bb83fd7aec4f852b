/* Divides lf_import_memory among readers that run at once. Each first gets its share; if that is
 * too little, it runs again alone with all of the memory. Readers of quiet groups have a
 * part of their own, which is left out of the others' memory. Thread: any. */
#ifndef LF_BASE_IMPORT_SHARE_H
#define LF_BASE_IMPORT_SHARE_H

#include "base/sandbox/import.h"

typedef struct lf_import_share {
    uint64_t memory; /* bytes for one reader */
    bool is_whole;   /* it gets no more in another attempt */
    bool is_apart;   /* of a quiet group, with a part of its own */
} lf_import_share;

/* To be called before a reader is started. Waits for other readers to end if it runs alone, or if
 * shares would be too small to start with. After the reader has ended, the same thread must call
 * lf_import_share_end. */
lf_import_share lf_import_share_begin(bool alone);
void lf_import_share_end(const lf_import_share *share);

#endif
