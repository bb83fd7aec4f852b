/* Buttons over any link: what lf_buttons_open does once the device is open. Private to device/ and
 * its tests. */
#ifndef LF_DEVICE_BUTTONS_LINK_H
#define LF_DEVICE_BUTTONS_LINK_H

#include "device/hid/buttons.h"
#include "device/hid/hid.h"

/* The buttons that went down with a report whose first byte is mask, as a set of bits 1 <<
 * lf_button. *down: those that were down before (0 at first), then those that are. Bits of no
 * button are not looked at. */
unsigned lf_buttons_pressed(unsigned *down, uint8_t mask);

/* As lf_buttons_open. On LF_OK the link is the object's, which uses it in its own thread and closes
 * it; otherwise it stays the caller's. */
LF_NODISCARD lf_status lf_buttons_watch(lf_hid_link *link, lf_buttons **out, lf_error *err);

#endif
