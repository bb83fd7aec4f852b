/* Buttons over any link: lf_buttons_open after it has opened the device. Private to device/ and its
 * tests. */
#ifndef LF_DEVICE_BUTTONS_LINK_H
#define LF_DEVICE_BUTTONS_LINK_H

#include "device/hid/buttons.h"
#include "device/hid/hid.h"

/* The buttons that went down with a report whose first byte is mask, as bits 1 << lf_button. *down:
 * the buttons that were down before (0 at first); becomes those that are down now. Other bits are
 * ignored. */
unsigned lf_buttons_pressed(unsigned *down, uint8_t mask);

/* Like lf_buttons_open. On LF_OK the object owns the link, uses it in its own thread and closes it;
 * otherwise the caller keeps it. */
LF_NODISCARD lf_status lf_buttons_watch(lf_hid_link *link, lf_buttons **out, lf_error *err);

#endif
