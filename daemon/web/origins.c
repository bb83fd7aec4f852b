#include "daemon/web/origins.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "base/number.h"

static const char *after(const char *text, const char *start)
{
    const size_t n = strlen(start);
    return strncmp(text, start, n) == 0 ? text + n : NULL;
}

/* "" or ":PORT", as browsers write it. */
static bool is_port(const char *text)
{
    uint64_t port = 0;
    return text[0] == '\0' ||
           (text[0] == ':' && text[1] != '0' && lf_whole_is(text + 1, &port) && port <= UINT16_MAX);
}

/* Browsers write names in lower case. */
static bool is_origin(const char *text)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz0123456789-.";
    const char *name = after(text, "https://");
    name = name ? name : after(text, "http://");
    if (!name)
        return false;
    const char *end = after(name, "[::1]");
    const char *port = end ? end : name + strspn(name, letters);
    const char *left_out = after(text, "https://") ? ":443" : ":80"; /* by browsers */
    return port > name && is_port(port) && strcmp(port, left_out) != 0;
}

lf_status lf_origins_add(lf_origins *origins, const char *text, lf_error *err)
{
    if (strcmp(text, LF_ORIGINS_LOCAL) == 0) {
        origins->local = true;
        return LF_OK;
    }
    if (!is_origin(text) || strlen(text) >= sizeof origins->text[0])
        return lf_error_set(err, LF_E_ARG, "--allow-origin",
                            "expects http://NAME, https://NAME, either with :PORT, or "
                            "http://localhost:*, got \"%s\"",
                            text);
    if (origins->n == LF_ORIGINS_MOST)
        return lf_error_set(err, LF_E_ARG, "--allow-origin", "may be given %d times at most",
                            LF_ORIGINS_MOST);
    memcpy(origins->text[origins->n++], text, strlen(text) + 1);
    return LF_OK;
}

static bool is_local(const char *origin)
{
    static const char *const names[] = {"http://localhost", "http://127.0.0.1", "http://[::1]"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        const char *port = after(origin, names[i]);
        if (port && is_port(port))
            return true;
    }
    return false;
}

bool lf_origins_have(const lf_origins *origins, const char *origin)
{
    for (int i = 0; i < origins->n; i++)
        if (strcmp(origins->text[i], origin) == 0)
            return true;
    return origins->local && is_local(origin);
}

bool lf_strangers_meet(lf_strangers *strangers, int service, const char *origin)
{
    char start[sizeof strangers->told[0].origin];
    snprintf(start, sizeof start, "%s", origin);
    for (int i = 0; i < strangers->n; i++)
        if (strangers->told[i].service == service && strcmp(strangers->told[i].origin, start) == 0)
            return false;
    if (strangers->n == LF_STRANGERS_MOST)
        return false;
    strangers->told[strangers->n].service = service;
    memcpy(strangers->told[strangers->n++].origin, start, sizeof start);
    return true;
}

void lf_origins_refusal(const char *origin, lf_error *out)
{
    if (is_origin(origin))
        (void)lf_error_set(out, LF_E_STATE, "",
                           "pages of %.80s may not ask; start quiltweb with --allow-origin %.80s",
                           origin, origin);
    else
        (void)lf_error_set(out, LF_E_STATE, "",
                           "pages of the origin %.80s may never ask; open the page by http or "
                           "https",
                           origin);
}
