/* Common code of quiltimport, quiltimport-vdb and quiltimport-picture: each reads one external
 * file, confined, and hands over its contents (base/sandbox/import.h). Not for users: quiltd,
 * quiltrender and quiltbench start them. */
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "base/sandbox/reader.h"

static lf_status ask_for(uint32_t step, const char *name, int *out_fd)
{
    lf_import_reply ask = {.step = step};
    lf_import_answer answer = {.status = LF_E_IO};
    *out_fd = -1;
    if (strlen(name) >= sizeof ask.text)
        return LF_E_PATH;
    memcpy(ask.text, name, strlen(name) + 1);
    lf_status status = lf_import_send(LF_IMPORT_SOCKET, &ask, sizeof ask, -1);
    if (status == LF_OK)
        status = lf_import_receive(LF_IMPORT_SOCKET, &answer, sizeof answer, out_fd);
    if (status != LF_OK)
        _exit(1); /* the asker has ended */
    return *out_fd >= 0 ? LF_OK : LF_E_IO;
}

lf_status lf_ask_for_file(const char *name, int *out_fd)
{
    return ask_for(LF_IMPORT_OPEN, name, out_fd);
}

lf_status lf_try_for_file(const char *name, int *out_fd)
{
    return ask_for(LF_IMPORT_TRY, name, out_fd);
}

/* If memory runs out, the kernel ends the reader first, not the program that shows a picture. */
static void go_first(void)
{
    FILE *file = fopen("/proc/self/oom_score_adj", "w");
    if (!file)
        return;
    fputs("1000\n", file);
    fclose(file);
}

static lf_status serve(const lf_import_reader *reader, const lf_import_request *request, int fd,
                       lf_parcel_writer *parcel, lf_landlock *out_landlock, lf_error *err)
{
    if (request->version != LF_IMPORT_VERSION)
        return lf_error_set(err, LF_E_IO, LF_HERE,
                            "quiltimport has another version; install quiltd again");
    if (reader->begin)
        reader->begin();
    go_first();
    lf_status status = lf_parcel_begin(parcel, err); /* the only file it may write */
    if (status == LF_OK)
        status = lf_confine(request->memory, request->seconds, out_landlock, err);
    if (status == LF_OK)
        status = reader->read(request, fd, parcel, err);
    return status;
}

/* A scheduler signals all processes of a job. The asker then ends its reader, or waits for it. */
static void leave_signals_to_the_asker(void)
{
    (void)signal(SIGTERM, SIG_IGN);
    (void)signal(SIGINT, SIG_IGN);
    (void)signal(SIGHUP, SIG_IGN);
}

int lf_reader_main(const lf_import_reader *reader)
{
    lf_import_request request;
    lf_parcel_writer parcel = {.fd = -1};
    lf_import_reply reply = {.step = LF_IMPORT_DONE};
    lf_error err = {0};
    int fd = -1, sealed = -1;
    leave_signals_to_the_asker();
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (lf_import_receive(LF_IMPORT_SOCKET, &request, sizeof request, &fd) != LF_OK || fd < 0) {
        fprintf(stderr,
                "quiltd and quiltrender start this program to read files; it has no use by hand\n");
        return 2;
    }
    if (request.asker != getppid()) /* the asker ended before PR_SET_PDEATHSIG was set */
        return 2;
    lf_landlock landlock = LF_LANDLOCK_UNKNOWN;
    lf_status status = serve(reader, &request, fd, &parcel, &landlock, &err);
    reply.landlock = landlock;
    if (status == LF_OK)
        status = lf_parcel_seal(&parcel, &sealed, &err);
    if (status != LF_OK) {
        reply.step = LF_IMPORT_FAILED;
        reply.status = status;
        snprintf(reply.text, sizeof reply.text, "%s", err.what);
    }
    (void)!lf_import_send(LF_IMPORT_SOCKET, &reply, sizeof reply, sealed);
    _exit(0); /* memory of libraries is freed with the process */
}
