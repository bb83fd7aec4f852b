/* demo: quilts that quiltweb draws itself, as raw RGB in sealed memory files. Thread: any. */
#ifndef LF_DAEMON_WEB_DEMO_H
#define LF_DAEMON_WEB_DEMO_H

#include "base/status.h"

enum { LF_DEMO_COLUMNS = 8, LF_DEMO_ROWS = 6, LF_DEMO_WIDTH = 960, LF_DEMO_HEIGHT = 960 };

/* Three bars: before the glass, in it and behind it. The caller closes *out_fd. LF_E_IO,
 * LF_E_NOMEM.
 */
LF_NODISCARD lf_status lf_demo_bars(int *out_fd, lf_error *err);
/* One black pixel. The caller closes *out_fd. LF_E_IO. */
LF_NODISCARD lf_status lf_demo_black(int *out_fd, lf_error *err);

#endif
