/* WebSockets of the page: each is a session. */
#include "daemon/web/web_internal.h"

#include "daemon/web/reply.h"
#include "daemon/web/session.h"

static void on_session_end(void *context, lf_session *session)
{
    (void)session;
    lf_seat_leave(context);
}

static void destroy(void *guest)
{
    lf_session_destroy(guest);
}

static lf_status create(lf_seat *seat, int fd, const void *early, size_t n, void **out_guest,
                        lf_error *err);

static const lf_seat_kind session_kind = {.create = create, .destroy = destroy};

static lf_uploads_passed sum_passed(void *context)
{
    const lf_web *web = context;
    lf_uploads_passed sum = {0};
    for (const lf_seat *seat = web->seats; seat; seat = seat->next)
        if (seat->kind == &session_kind)
            lf_session_add_passed(seat->guest, &sum);
    return sum;
}

static lf_status create(lf_seat *seat, int fd, const void *early, size_t n, void **out_guest,
                        lf_error *err)
{
    lf_web *web = seat->web;
    lf_session *session = NULL;
    const lf_session_home home = {.event = web->event,
                                  .socket = web->socket,
                                  .uploads = web->uploads,
                                  .downloads = web->downloads,
                                  .passed = sum_passed,
                                  .context = web};
    lf_status status = lf_session_create(&home, fd, early, n, &session, err);
    if (status != LF_OK)
        return status;
    lf_session_on_end(session, on_session_end, seat);
    *out_guest = session;
    return LF_OK;
}

enum MHD_Result lf_sessions_answer(lf_request *r)
{
    lf_guard_request headers;
    lf_reply_read(r->connection, r->path, &headers);
    if (lf_guard_may_connect(&r->web->services[r->service].guard, &headers))
        return lf_seats_answer(r, &session_kind);
    r->web->counts.refused++;
    return lf_request_refuse(r, 401, "the token is missing or wrong");
}
