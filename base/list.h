/* list: comma-separated lists in texts. Thread safe. */
#ifndef LF_BASE_LIST_H
#define LF_BASE_LIST_H

#include "base/status.h"

/* Appends an entry to a text that was empty at first; cuts it at `size`. */
void lf_list_add(char *list, size_t size, const char *format, ...) LF_PRINTF(3, 4);

#endif
