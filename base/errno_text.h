/* The system's text for an errno value, without the shared buffer of strerror. */
#ifndef LF_BASE_ERRNO_TEXT_H
#define LF_BASE_ERRNO_TEXT_H

#include <string.h>

static inline const char *lf_errno_text(int e)
{
    const char *text = strerrordesc_np(e);
    return text ? text : "unknown error";
}

#endif
