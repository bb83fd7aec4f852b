/* panel_only: quiltweb only answers what panel there is, for programs that draw on it themselves.
 *
 * quiltd lends its panel: it closes it for as long as a connection lasts, and opens it again when
 * the connection ends, however quiltweb ends. Without a quiltd, or without a panel, it is tried
 * again every 2 s. Thread: event. */
#ifndef LF_DAEMON_WEB_PANEL_ONLY_H
#define LF_DAEMON_WEB_PANEL_ONLY_H

#include <jansson.h>
#include <systemd/sd-event.h>

#include "base/status.h"

#define LF_PANEL_ONLY_WORDS "quiltweb runs with --panel-only: the panel belongs to other programs"

typedef struct lf_panel_only lf_panel_only;

/* socket: path of quiltd's, copied. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_panel_only_create(sd_event *event, const char *socket,
                                            lf_panel_only **out, lf_error *err);
/* quiltd opens its panel again. Accepts NULL. */
void lf_panel_only_destroy(lf_panel_only *lent);

/* True: what shows something answers Failure. False for NULL. */
bool lf_panel_only_is_on(const lf_panel_only *lent);
/* The calibration (device.calibration) and the device (`device` of status) of the panel that quiltd
 * has lent, borrowed; NULL: it has lent none yet. */
const json_t *lf_panel_only_calibration(const lf_panel_only *lent);
const json_t *lf_panel_only_device(const lf_panel_only *lent);

#endif
