#include "daemon/web/guard.h"

#include <stdio.h>
#include <string.h>

#include "base/number.h"

static const char https[] = "https://";
static const char *const names[LF_GUARD_NAMES] = {"localhost", "127.0.0.1", "[::1]"};

static void set_hosts(lf_guard *guard, int port)
{
    for (int i = 0; i < LF_GUARD_NAMES; i++)
        /* browsers leave out the port of http */
        snprintf(guard->hosts[i], sizeof guard->hosts[i], port == 80 ? "%s" : "%s:%d", names[i],
                 port);
}

lf_status lf_guard_init(lf_guard *guard, int port, lf_error *err)
{
    *guard = (lf_guard){.allowed = NULL};
    set_hosts(guard, port);
    snprintf(guard->cookie, sizeof guard->cookie, "quiltweb-%d", port);
    lf_status status = lf_secret_draw(&guard->token, err);
    return status == LF_OK ? lf_secret_draw(&guard->session, err) : status;
}

void lf_guard_init_programs(lf_guard *guard, int port, const lf_origins *allowed)
{
    *guard = (lf_guard){.allowed = allowed};
    set_hosts(guard, port);
}

lf_status lf_guard_set_public(lf_guard *guard, const char *origin, lf_error *err)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz0123456789-.";
    const size_t scheme = strlen(https);
    const bool is_https = strncmp(origin, https, scheme) == 0;
    const char *name = origin + (is_https ? scheme : 0);
    const size_t n = strspn(name, letters);
    lf_guard named = *guard;
    uint64_t port = 0;
    const bool has_port = name[n] == ':';
    if (!is_https || n == 0 || strchr(".-", name[0]) || strchr(".-", name[n - 1]) ||
        strlen(origin) >= sizeof guard->public_origin || (name[n] && !has_port) ||
        (has_port &&
         (!lf_whole_is(name + n + 1, &port) || port < 1 || port > 65535 || name[n + 1] == '0')))
        return lf_error_set(err, LF_E_ARG, "--public",
                            "expects https://NAME or https://NAME:PORT, without a path, got \"%s\"",
                            origin);
    /* browsers leave out the port of https */
    snprintf(named.public_origin, sizeof named.public_origin, "%.*s",
             (int)(port == 443 ? scheme + n : strlen(origin)), origin);
    for (int i = 0; i < LF_GUARD_NAMES; i++)
        if (strcmp(named.public_origin + scheme, guard->hosts[i]) == 0)
            return lf_error_set(err, LF_E_ARG, "--public",
                                "expects another name or port than quiltweb's own, got \"%s\"",
                                origin);
    *guard = named;
    return LF_OK;
}

bool lf_guard_is_public(const lf_guard *guard, const lf_guard_request *request)
{
    return guard->public_origin[0] && request->hosts == 1 &&
           strcmp(request->host, guard->public_origin + strlen(https)) == 0;
}

static bool is_our_host(const lf_guard *guard, const lf_guard_request *request)
{
    if (request->hosts != 1)
        return false;
    if (lf_guard_is_public(guard, request))
        return true;
    for (int i = 0; i < LF_GUARD_NAMES; i++)
        if (strcmp(request->host, guard->hosts[i]) == 0)
            return true;
    return false;
}

/* The page's origin has the name under which the page was opened. */
static bool is_our_origin(const lf_guard *guard, const lf_guard_request *request)
{
    if (guard->allowed)
        return request->origins == 1 && lf_origins_have(guard->allowed, request->origin);
    const char *scheme = lf_guard_is_public(guard, request) ? https : "http://";
    return request->origins == 1 && strncmp(request->origin, scheme, strlen(scheme)) == 0 &&
           strcmp(request->origin + strlen(scheme), request->host) == 0;
}

static int refuse(int status, const char *why, const char **out_why)
{
    *out_why = why;
    return status;
}

static int check_body(const lf_guard_request *request, const char **out_why)
{
    uint64_t length = 0;
    if (!request->length)
        return request->takes_body ? refuse(411, "a Content-Length is needed", out_why) : 0;
    if (!lf_whole_is(request->length, &length))
        return refuse(400, "the length of the body is no number", out_why);
    if (!request->takes_body && length > 0)
        return refuse(413, "this request takes no body", out_why);
    if (request->takes_body && length > request->body_limit)
        return refuse(413, request->too_long, out_why);
    return 0;
}

int lf_guard_check(const lf_guard *guard, const lf_guard_request *request, const char **out_why)
{
    if (!is_our_host(guard, request))
        return refuse(421, "the Host header does not name this server", out_why);
    if (request->target[0] != '/' || request->zero)
        return refuse(400, "the target is not a path", out_why);
    if (request->encoded || request->lengths > 1)
        return refuse(400, "the length of the body is ambiguous", out_why);
    if (request->cookies > 1 || request->authorizations > 1)
        return refuse(400, "a header occurs twice", out_why);
    const int body = check_body(request, out_why);
    if (body != 0)
        return body;
    if (request->origins > 0 && !is_our_origin(guard, request))
        return refuse(403, "the request comes from a page of another origin", out_why);
    return 0;
}

bool lf_guard_has_token(const lf_guard *guard, const lf_guard_request *request)
{
    static const char scheme[] = "Bearer ";
    const char *text = request->authorization;
    if (!text || strncmp(text, scheme, strlen(scheme)) != 0)
        return false;
    text += strlen(scheme);
    return lf_secret_equals(&guard->token, text, strlen(text));
}

bool lf_guard_has_cookie(const lf_guard *guard, const lf_guard_request *request)
{
    const size_t length = strlen(guard->cookie);
    for (const char *at = request->cookie; at && *at;) {
        at += strspn(at, "; ");
        const size_t n = strcspn(at, ";");
        if (n > length && at[length] == '=' && strncmp(at, guard->cookie, length) == 0 &&
            lf_secret_equals(&guard->session, at + length + 1, n - length - 1))
            return true;
        at += n;
    }
    return false;
}

bool lf_guard_may_read(const lf_guard *guard, const lf_guard_request *request)
{
    const bool from_page =
        request->sites == 0 || (request->sites == 1 && (strcmp(request->site, "same-origin") == 0 ||
                                                        strcmp(request->site, "none") == 0));
    return lf_guard_has_token(guard, request) || (from_page && lf_guard_has_cookie(guard, request));
}

bool lf_guard_may_write(const lf_guard *guard, const lf_guard_request *request)
{
    return lf_guard_has_token(guard, request) ||
           (request->origins > 0 && lf_guard_has_cookie(guard, request));
}

bool lf_guard_may_connect(const lf_guard *guard, const lf_guard_request *request)
{
    return request->origins > 0 ? lf_guard_has_cookie(guard, request)
                                : lf_guard_has_token(guard, request);
}
