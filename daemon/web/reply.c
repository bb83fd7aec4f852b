#include "daemon/web/reply.h"

#include <nettle/base64.h>
#include <nettle/sha1.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "daemon/web/peer.h"

static enum MHD_Result read_header(void *context, enum MHD_ValueKind kind, const char *key,
                                   const char *value)
{
    (void)kind;
    lf_guard_request *r = context;
    const struct {
        const char *name;
        const char **text;
        int *count;
    } rows[] = {{"Host", &r->host, &r->hosts},
                {"Origin", &r->origin, &r->origins},
                {"Content-Length", &r->length, &r->lengths},
                {"Cookie", &r->cookie, &r->cookies},
                {"Authorization", &r->authorization, &r->authorizations},
                {"Sec-Fetch-Site", &r->site, &r->sites}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (strcasecmp(key, rows[i].name) != 0)
            continue;
        *rows[i].text = value ? value : "";
        ++*rows[i].count;
    }
    r->encoded |= strcasecmp(key, "Transfer-Encoding") == 0;
    return MHD_YES;
}

void lf_reply_read(struct MHD_Connection *connection, const char *target, lf_guard_request *out)
{
    *out = (lf_guard_request){.target = target};
    MHD_get_connection_values(connection, MHD_HEADER_KIND, read_header, out);
}

static void protect(struct MHD_Response *response, const char *type)
{
    static const char *const headers[][2] = {
        {"Content-Security-Policy", "default-src 'self'; base-uri 'none'; form-action 'none'; "
                                    "frame-ancestors 'none'"},
        {"Cross-Origin-Resource-Policy", "same-origin"},
        {"Cross-Origin-Opener-Policy", "same-origin"},
        {"X-Content-Type-Options", "nosniff"},
        {"Referrer-Policy", "no-referrer"},
        {"Cache-Control", "no-store"},
        {"Connection", "close"},
    };
    for (size_t i = 0; i < sizeof headers / sizeof headers[0]; i++)
        MHD_add_response_header(response, headers[i][0], headers[i][1]);
    if (type)
        MHD_add_response_header(response, "Content-Type", type);
}

/* A service of programs answers by the Origin, which caches must know. */
static void share(struct MHD_Response *response, const lf_peer *peer)
{
    if (!peer || peer->service == LF_SERVICE_PAGE)
        return;
    MHD_add_response_header(response, "Vary", "Origin");
    if (peer->origin)
        MHD_add_response_header(response, "Access-Control-Allow-Origin", peer->origin);
}

enum MHD_Result lf_reply_send(struct MHD_Connection *connection, unsigned status,
                              struct MHD_Response *response, const char *type)
{
    if (!response)
        return MHD_NO;
    protect(response, type);
    share(response, lf_peer_of(connection));
    enum MHD_Result sent = MHD_queue_response(connection, status, response);
    MHD_destroy_response(response);
    return sent;
}

static struct MHD_Response *copy_of(const char *text)
{
    char *data;
    memcpy(&data, &text, sizeof data); /* copied by libmicrohttpd, never written to */
    return MHD_create_response_from_buffer(strlen(text), data, MHD_RESPMEM_MUST_COPY);
}

enum MHD_Result lf_reply_text(struct MHD_Connection *connection, unsigned status, const char *text)
{
    char line[640];
    snprintf(line, sizeof line, "%s\n", text);
    return lf_reply_send(connection, status, copy_of(line), "text/plain; charset=utf-8");
}

enum MHD_Result lf_reply_json(struct MHD_Connection *connection, unsigned status,
                              const json_t *json)
{
    char *text = json ? json_dumps(json, JSON_COMPACT) : NULL;
    enum MHD_Result sent =
        lf_reply_send(connection, status, text ? copy_of(text) : NULL, "application/json");
    free(text);
    return sent;
}

enum MHD_Result lf_reply_metrics(struct MHD_Connection *connection, const char *text)
{
    return lf_reply_send(connection, MHD_HTTP_OK, copy_of(text),
                         "text/plain; version=0.0.4; charset=utf-8");
}

enum MHD_Result lf_reply_page(struct MHD_Connection *connection, const lf_page *page)
{
    unsigned char *data;
    memcpy(&data, &page->data, sizeof data); /* persistent, never written to */
    return lf_reply_send(connection, MHD_HTTP_OK,
                         MHD_create_response_from_buffer(page->n, data, MHD_RESPMEM_PERSISTENT),
                         page->type);
}

enum MHD_Result lf_reply_jpeg(struct MHD_Connection *connection, int fd, size_t size)
{
    struct MHD_Response *response = MHD_create_response_from_fd(size, fd);
    if (!response)
        close(fd);
    return lf_reply_send(connection, MHD_HTTP_OK, response, "image/jpeg");
}

enum MHD_Result lf_reply_cookie(struct MHD_Connection *connection, const lf_guard *guard,
                                bool secure)
{
    char cookie[128];
    struct MHD_Response *response = copy_of("");
    snprintf(cookie, sizeof cookie, "%s=%s; SameSite=Strict; HttpOnly; Path=/%s", guard->cookie,
             guard->session.text, secure ? "; Secure" : "");
    if (response)
        MHD_add_response_header(response, "Set-Cookie", cookie);
    return lf_reply_send(connection, MHD_HTTP_NO_CONTENT, response, NULL);
}

enum MHD_Result lf_reply_options(struct MHD_Connection *connection)
{
    struct MHD_Response *response = copy_of("");
    if (response) {
        MHD_add_response_header(response, "Access-Control-Allow-Methods", "GET, PUT");
        MHD_add_response_header(response, "Access-Control-Allow-Headers", "Content-Type");
    }
    return lf_reply_send(connection, MHD_HTTP_NO_CONTENT, response, NULL);
}

/* RFC 6455, section 4.2.2. */
static void accept_key(const char *key, char out[BASE64_ENCODE_RAW_LENGTH(SHA1_DIGEST_SIZE) + 1])
{
    static const char guid[] = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
    struct sha1_ctx sha1;
    uint8_t digest[SHA1_DIGEST_SIZE];
    sha1_init(&sha1);
    sha1_update(&sha1, strlen(key), (const uint8_t *)key);
    sha1_update(&sha1, strlen(guid), (const uint8_t *)guid);
    sha1_digest(&sha1, sizeof digest, digest);
    base64_encode_raw(out, sizeof digest, digest);
    out[BASE64_ENCODE_RAW_LENGTH(SHA1_DIGEST_SIZE)] = '\0';
}

enum MHD_Result lf_reply_upgrade(struct MHD_Connection *connection, const char *key,
                                 const char *protocol, MHD_UpgradeHandler upgraded, void *context)
{
    char accepted[BASE64_ENCODE_RAW_LENGTH(SHA1_DIGEST_SIZE) + 1];
    struct MHD_Response *response = MHD_create_response_for_upgrade(upgraded, context);
    if (!response)
        return MHD_NO;
    accept_key(key, accepted);
    MHD_add_response_header(response, "Upgrade", "websocket");
    MHD_add_response_header(response, "Sec-WebSocket-Accept", accepted);
    if (protocol)
        MHD_add_response_header(response, "Sec-WebSocket-Protocol", protocol);
    enum MHD_Result sent = MHD_queue_response(connection, MHD_HTTP_SWITCHING_PROTOCOLS, response);
    MHD_destroy_response(response);
    return sent;
}
