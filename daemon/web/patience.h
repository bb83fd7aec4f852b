/* patience: how long a connection may take. When its time is over, its socket is shut down, and
 * who serves it sees the end. Thread: event. */
#ifndef LF_DAEMON_WEB_PATIENCE_H
#define LF_DAEMON_WEB_PATIENCE_H

#include <stdint.h>
#include <systemd/sd-event.h>

#include "base/status.h"

/* What a client that sends or takes much has to move in each period … */
#define LF_PATIENCE_BYTES ((size_t)65536)
/* … and in the mean in each second after the first LF_PATIENCE_FREE_S. */
#define LF_PATIENCE_RATE ((uint64_t)65536)
#define LF_PATIENCE_FREE_S 60

typedef struct lf_patience lf_patience;

/* fd: a connected socket, which stays the caller's. It has usec for all that follows. LF_E_NOMEM.
 */
LF_NODISCARD lf_status lf_patience_create(sd_event *event, int fd, uint64_t usec,
                                          lf_patience **out);
/* Accepts NULL. */
void lf_patience_destroy(lf_patience *patience);

/* All that follow accept NULL.
 * From now on the connection has usec for all that follows. */
void lf_patience_wait(lf_patience *patience, uint64_t usec);
/* From now on LF_PATIENCE_BYTES must be moved in each period of usec, and LF_PATIENCE_RATE in the
 * mean. */
void lf_patience_pace(lf_patience *patience, uint64_t usec);
/* n bytes were moved. */
void lf_patience_note(lf_patience *patience, size_t n);
/* The connection has no time any more. */
void lf_patience_end(lf_patience *patience);
/* Its time was over. False for NULL. */
bool lf_patience_is_over(const lf_patience *patience);
/* From now on somebody else looks after the connection. */
void lf_patience_stop(lf_patience *patience);

#endif
