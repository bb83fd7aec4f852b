/* cbor: messages of RFC 8949 to JSON and back, for programs of the older protocol (driver.h).
 *
 * The reader takes a message in parts of any size. The byte string `bin` of the outermost map goes
 * to the caller as it comes and is never kept. What is kept is bounded, so a message of any
 * announced lengths costs little memory. libcbor, the only library in Debian 12, hands a byte
 * string over as a whole. Thread: any; a reader has one at a time. */
#ifndef LF_DAEMON_WEB_CBOR_H
#define LF_DAEMON_WEB_CBOR_H

#include <jansson.h>
#include <stdint.h>

#include "base/status.h"

#define LF_CBOR_MAX_DEPTH 16 /* maps and arrays inside each other */
#define LF_CBOR_MAX_ITEMS 4096
#define LF_CBOR_MAX_TEXT ((size_t)65536) /* bytes of all texts */

typedef struct lf_cbor lf_cbor;

/* The next part of `bin`: data[n], n > 0. */
typedef void (*lf_cbor_bin_fn)(void *context, const uint8_t *data, size_t n);

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_cbor_create(lf_cbor_bin_fn bin, void *context, lf_cbor **out);
/* Accepts NULL. */
void lf_cbor_destroy(lf_cbor *cbor);

/* Takes the next data[n] of the message. After a failure, which lf_cbor_finish reports, the rest is
 * skipped. */
void lf_cbor_take(lf_cbor *cbor, const uint8_t *data, size_t n);
/* The message has ended: its value, a new reference, in which `bin` is the number of its bytes.
 * Tags are left out; undefined is null. LF_E_FORMAT: not one whole value in CBOR, a limit above is
 * exceeded, or JSON has no such value: a key that is no text or stands twice, a byte string other
 * than `bin`, a text with a zero byte, a number that is not finite. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_cbor_finish(lf_cbor *cbor, json_t **out, lf_error *err);

/* Writes a value: *out_data[*out_n], which the caller frees by free(). LF_E_ARG: NULL, or deeper
 * than LF_CBOR_MAX_DEPTH; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_cbor_write(json_t *value, uint8_t **out_data, size_t *out_n);

#endif
