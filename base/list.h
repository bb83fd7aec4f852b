/* list: things that are said one after the other in a line, with commas between. Thread safe. */
#ifndef LF_BASE_LIST_H
#define LF_BASE_LIST_H

#include "base/status.h"

/* Adds one more to a text that was empty at first; what does not fit into size is cut. */
void lf_list_add(char *list, size_t size, const char *format, ...) LF_PRINTF(3, 4);

#endif
