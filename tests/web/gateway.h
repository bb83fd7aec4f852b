/* A gateway in a thread, a quiltd that does not exist behind it, and clients that may say anything.
 */
#ifndef LF_TESTS_WEB_GATEWAY_H
#define LF_TESTS_WEB_GATEWAY_H

#include "tests/testing.h"

#include "tests/web/false_slideshow.h"

/* What the false quiltd renders: 9 views of 60x80 in 3x3 tiles. */
enum { FALSE_COLUMNS = 3, FALSE_VIEWS = 9, FALSE_WIDTH = 60, FALSE_HEIGHT = 80 };

/* Bytes of all uploads. */
enum { GATEWAY_UPLOADS = 3 << 20 };

typedef struct gateway gateway;

/* *state is the gateway. */
int lf_gateway_setup(void **state);
int lf_gateway_teardown(void **state);
/* One with --public https://panel.test. */
int lf_gateway_public_setup(void **state);
/* One with the services of programs, where pages of https://allowed.test may ask. */
int lf_gateway_programs_setup(void **state);
#define lf_gateway_programs_test(test)                                                             \
    cmocka_unit_test_setup_teardown(test, lf_gateway_programs_setup, lf_gateway_teardown)
#define lf_gateway_public_test(test)                                                               \
    cmocka_unit_test_setup_teardown(test, lf_gateway_public_setup, lf_gateway_teardown)
#define lf_gateway_test(test)                                                                      \
    cmocka_unit_test_setup_teardown(test, lf_gateway_setup, lf_gateway_teardown)

int lf_gateway_port(const gateway *g);
int lf_gateway_service_port(const gateway *g, int service);
/* Whether it listens on [::1], too, and not only on 127.0.0.1. */
bool lf_gateway_has_v6(const gateway *g);
const char *lf_gateway_token(const gateway *g);
/* With the token. */
const char *lf_gateway_url(const gateway *g);
/* "quiltweb-PORT=…" as the gateway gives it for the token. */
const char *lf_gateway_cookie(gateway *g);

/* The false quiltd answers each call with {"method": NAME, "params"}, status with its state, and
 * frame.get with an image; scene.load, scene.patch and quilt.show say in "seen" what the passed
 * files are. It refuses quilts of 99 columns and thumbnails of /etc/passwd. Exports are jobs 1, 2 …
 * whose files hold "job 1 file 0". false: it answers no frame.get,
 * library.thumbnail and quilt.show any more. */
void lf_gateway_answer_images(gateway *g, bool answer);
/* Of a gateway with the services of programs: changes the slideshow, or returns it as JSON. */
void lf_gateway_set_slideshow(gateway *g, void (*change)(lf_false_slideshow *));
json_t *lf_gateway_slideshow(gateway *g);
/* Another scene: its images have these columns. */
void lf_gateway_set_columns(gateway *g, int columns);
/* What it knows of rights.limit: all, nothing, all but the method doctor; or it refuses, or does
 * not answer. */
typedef enum lf_gateway_rights {
    LF_RIGHTS_KNOWN,
    LF_RIGHTS_UNKNOWN,
    LF_RIGHTS_LACKING,
    LF_RIGHTS_AGAINST,
    LF_RIGHTS_SILENT,
} lf_gateway_rights;
void lf_gateway_set_rights(gateway *g, lf_gateway_rights rights);
/* How many calls came on connections before their rights were limited, or rights.limit was unknown.
 */
int lf_gateway_unlimited(gateway *g);
/* Makes the first file of the last export so large. */
bool lf_gateway_grow_export(gateway *g, int64_t bytes);
/* How often quiltd was called with this method. */
int lf_gateway_calls(gateway *g, const char *method);
/* Sends a line to all connections. */
void lf_gateway_notify(gateway *g, const char *line);
/* Sends a line (with its newline) to the oldest connection until nobody takes more for a second, or
 * `most` times; the number of lines sent whole. lf_gateway_flood_end sends the rest of the last. */
int lf_gateway_flood(gateway *g, const char *line, int most);
void lf_gateway_flood_end(gateway *g);
/* Closes all connections of quiltd. */
void lf_gateway_hang_up(gateway *g);

/* A TCP connection to the gateway: to its page, or to a service (lf_service). */
int lf_caller_connect(const gateway *g);
int lf_caller_connect_service(const gateway *g, int service);
/* Sends raw[n]; true if all of it was taken. */
bool lf_caller_send(int fd, const char *raw, size_t n);
/* Sends raw[n] until nobody takes more for a second; the number of bytes taken. */
size_t lf_caller_flood(int fd, const char *raw, size_t n);
/* All that comes until the end, terminated, in a static buffer. Closes fd. */
const char *lf_caller_rest(int fd);
/* A request with the token whose body may follow: "METHOD PATH HTTP/1.1" and more headers. */
int lf_caller_begin(const gateway *g, const char *line, const char *headers);
/* PUT with the token; as lf_caller_ask. */
const char *lf_caller_put(const gateway *g, const char *target, const char *body, size_t n);
/* Sends a request and returns all that comes until the end, terminated, in a static buffer. */
const char *lf_caller_ask(const gateway *g, const char *request);
const char *lf_caller_ask_service(const gateway *g, int service, const char *request);
/* As lf_caller_ask, with "METHOD PATH HTTP/1.1", a Host that is right, and more headers (each ended
 * by \r\n). */
const char *lf_caller_get(const gateway *g, const char *line, const char *headers);
/* The status of an answer; 0: none. */
int lf_caller_status(const char *answer);

/* A WebSocket; at the page's service, or of a path at another one. */
int lf_talk_connect(const gateway *g, const char *headers, const char **out_answer);
int lf_talk_connect_service(const gateway *g, int service, const char *path, const char *headers,
                            const char **out_answer);
/* One with the token. */
int lf_talk_open(const gateway *g);
void lf_talk_send(int fd, int opcode, const char *data, size_t n);
void lf_talk_say(int fd, const char *text);
/* The next message that is neither ping nor pong: its opcode, -1 at the end; data in a static
 * buffer of *out_n bytes, terminated. */
int lf_talk_next(int fd, const unsigned char **out_data, size_t *out_n);
/* Waits until the gateway has read all that was sent (a ping). Nothing else may come meanwhile. */
void lf_talk_settle(int fd);
/* Reads until a text message holds this word, and returns it; binary messages are counted. */
const char *lf_talk_until(int fd, const char *word, int *out_binaries);

#endif
