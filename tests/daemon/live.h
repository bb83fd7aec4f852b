/* A quiltd of the test's own: started in a temporary folder with a small scene and a small
 * simulated panel, talked to over its socket, ended and judged. Everything fails the test by
 * itself; nothing here asserts how fast something is. */
#ifndef LF_TESTS_DAEMON_LIVE_H
#define LF_TESTS_DAEMON_LIVE_H

#include "tests/testing.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <time.h>

#include "tests/scene_file.h"

#include <jansson.h>

/* A daemon under a sanitizer on a busy machine takes minutes for its first picture. */
#define LIVE_PATIENCE_S 600

/* live-fog has 6 views: their quilt, 3x2, has no black tile, so that reading it gives the same
 * views. The panel has 96 x 128 pixels: every frame is quick. */
#define LIVE_SCENE lf_test_scene_text("live-fog")
#define LIVE_CALIBRATION lf_test_scene_text("panel")

typedef struct live {
    char *folder;
    char scene[PATH_MAX / 4], socket[PATH_MAX / 4], sim[PATH_MAX / 4], panel[PATH_MAX / 4],
        exports[PATH_MAX / 4], state[PATH_MAX / 4], log[PATH_MAX / 4];
    pid_t pid;
} live;

typedef struct live_client {
    int fd;
    json_int_t ids;
    char *buffer;
    size_t used, size;
} live_client;

static inline void live_nap(long ms)
{
    nanosleep(&(struct timespec){.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000}, NULL);
}

/* The folder with its scene and panel; no daemon yet. */
static inline void live_prepare(live *l)
{
    memset(l, 0, sizeof *l);
    l->folder = lf_test_folder();
    snprintf(l->scene, sizeof l->scene, "%s/scene/fog.json", l->folder);
    snprintf(l->socket, sizeof l->socket, "%s/s", l->folder);
    snprintf(l->sim, sizeof l->sim, "sim:%s/sim", l->folder);
    snprintf(l->panel, sizeof l->panel, "%s/sim/panel.png", l->folder);
    snprintf(l->exports, sizeof l->exports, "%s/exports", l->folder);
    snprintf(l->state, sizeof l->state, "%s/state", l->folder);
    snprintf(l->log, sizeof l->log, "%s/log", l->folder);
    assert_int_equal(mkdir(lf_test_path(l->folder, "scene"), 0700), 0);
    assert_int_equal(mkdir(lf_test_path(l->folder, "sim"), 0700), 0);
    lf_test_write(l->folder, "scene/fog.json", LIVE_SCENE);
    lf_test_write(l->folder, "sim/calibration.json", LIVE_CALIBRATION);
}

/* A child with stderr in the log; args end with NULL. */
static inline pid_t live_spawn(const live *l, char *const args[])
{
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL); /* a test that fails leaves nothing behind */
        int fd = open(l->log, O_WRONLY | O_CREAT | O_APPEND, 0600);
        dup2(fd, STDERR_FILENO);
        dup2(fd, STDOUT_FILENO);
        execv(args[0], args);
        _exit(127);
    }
    return pid;
}

/* The exit code; a child that does not end is killed and fails the test. */
static inline int live_reap(pid_t pid)
{
    int status = 0;
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++) {
        pid_t done = waitpid(pid, &status, WNOHANG);
        if (done == pid)
            return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        live_nap(20);
    }
    kill(pid, SIGKILL);
    waitpid(pid, &status, 0);
    fail_msg("a program did not end");
    return -1;
}

/* Of the daemon. */
static inline long live_resident_kib(const live *l)
{
    char path[64];
    long all, pages = 0;
    snprintf(path, sizeof path, "/proc/%d/statm", (int)l->pid);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%ld %ld", &all, &pages), 2);
    fclose(file);
    return pages * (sysconf(_SC_PAGESIZE) / 1024);
}

static inline int live_connect_fd(const live *l)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "%.100s", l->socket);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        close(fd);
        fd = -1;
    }
    if (fd >= 0) {
        struct timeval patience = {.tv_sec = LIVE_PATIENCE_S};
        setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    }
    return fd;
}

static inline void live_show_log(const live *l)
{
    FILE *file = fopen(l->log, "r");
    char line[512];
    while (file && fgets(line, sizeof line, file))
        print_error("| %s", line);
    if (file)
        fclose(file);
}

static inline void live_wait_for_file(const char *path)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (access(path, F_OK) == 0)
            return;
    fail_msg("%s does not appear", path);
}

/* True when the daemon's log holds this text. */
static inline bool live_logged(const live *l, const char *text)
{
    FILE *file = fopen(l->log, "r");
    char line[1024];
    bool found = false;
    while (file && !found && fgets(line, sizeof line, file))
        found = strstr(line, text);
    if (file)
        fclose(file);
    return found;
}

/* Waits until the daemon's log holds this text. */
static inline void live_await_logged(const live *l, const char *text)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (live_logged(l, text))
            return;
    fail_msg("\"%s\" is not logged", text);
}

static inline void live_connect(const live *l, live_client *c)
{
    *c = (live_client){.fd = -1, .size = (size_t)3 << 20};
    c->buffer = malloc(c->size);
    assert_non_null(c->buffer);
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && c->fd < 0; i++) {
        c->fd = live_connect_fd(l);
        if (c->fd < 0) {
            siginfo_t info = {0};
            if (l->pid > 0 &&
                waitid(P_PID, (id_t)l->pid, &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
                info.si_pid == l->pid)
                break;
            live_nap(20);
        }
    }
    if (c->fd < 0) {
        live_show_log(l);
        fail_msg("the daemon does not answer at %s", l->socket);
    }
}

static inline void live_close(live_client *c)
{
    close(c->fd);
    free(c->buffer);
}

/* Starts quiltd with the usual options and these (NULL ends them); the scene is the first, NULL =
 * none. */
static inline void live_start(live *l, const char *scene, ...)
{
    char *args[40];
    int n = 0;
    char program[PATH_MAX];
    snprintf(program, sizeof program, "%s", lf_test_built("quiltd"));
    args[n++] = program;
    char *usual[] = {(char *)(uintptr_t)scene,
                     (char *)(uintptr_t) "--socket",
                     l->socket,
                     (char *)(uintptr_t) "--export-dir",
                     l->exports,
                     (char *)(uintptr_t) "--view-size",
                     (char *)(uintptr_t) "24x32",
                     (char *)(uintptr_t) "--threads",
                     (char *)(uintptr_t) "2"};
    for (size_t i = !scene ? 1 : 0; i < sizeof usual / sizeof *usual; i++)
        args[n++] = usual[i];
    va_list more;
    va_start(more, scene);
    for (const char *arg = va_arg(more, const char *); arg && n < 39;
         arg = va_arg(more, const char *))
        args[n++] = (char *)(uintptr_t)arg;
    va_end(more);
    args[n] = NULL;
    l->pid = live_spawn(l, args);
    live_client c;
    live_connect(l, &c);
    live_close(&c);
}

/* Ends it with TERM; its exit code. What it said is shown when that is not 0. */
static inline int live_stop(live *l)
{
    kill(l->pid, SIGTERM);
    int code = live_reap(l->pid);
    l->pid = 0;
    if (code != 0)
        live_show_log(l);
    return code;
}

/* Ends and removes everything; accepts what was never started. */
static inline void live_finish(live *l)
{
    if (l->pid > 0)
        assert_int_equal(live_stop(l), 0);
    lf_test_folder_remove(l->folder);
}

static inline void live_send(const live_client *c, const char *text, size_t n)
{
    while (n > 0) {
        ssize_t done = send(c->fd, text, n, MSG_NOSIGNAL);
        assert_true(done > 0);
        text += done;
        n -= (size_t)done;
    }
}

/* The next line as JSON; NULL at the connection's end. */
static inline json_t *live_receive(live_client *c)
{
    for (;;) {
        char *end = memchr(c->buffer, '\n', c->used);
        if (end) {
            json_t *message = json_loadb(c->buffer, (size_t)(end - c->buffer), 0, NULL);
            c->used -= (size_t)(end + 1 - c->buffer);
            memmove(c->buffer, end + 1, c->used);
            assert_non_null(message);
            return message;
        }
        assert_true(c->used < c->size);
        ssize_t n = recv(c->fd, c->buffer + c->used, c->size - c->used, 0);
        if (n < 0 && (errno == EAGAIN || errno == EINTR))
            fail_msg("no answer");
        if (n <= 0)
            return NULL;
        c->used += (size_t)n;
    }
}

/* A call that passes n descriptors, which stay the caller's. params are taken over (NULL = {}). */
static inline void live_ask_with(live_client *c, const char *method, json_t *params, const int *fds,
                                 int n)
{
    enum { MOST = 100 };
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(MOST * sizeof(int))];
    } control = {.bytes = {0}};
    json_t *request = json_pack("{s:s, s:I, s:s, s:o}", "jsonrpc", "2.0", "id", ++c->ids, "method",
                                method, "params", params ? params : json_object());
    char *text = json_dumps(request, JSON_COMPACT);
    struct iovec first = {.iov_base = text, .iov_len = 1};
    struct msghdr message = {.msg_iov = &first, .msg_iovlen = 1};
    json_decref(request);
    assert_true(n <= MOST);
    if (n > 0) {
        message.msg_control = &control;
        message.msg_controllen = CMSG_SPACE((size_t)n * sizeof(int));
        struct cmsghdr *head = CMSG_FIRSTHDR(&message);
        head->cmsg_level = SOL_SOCKET;
        head->cmsg_type = SCM_RIGHTS;
        head->cmsg_len = CMSG_LEN((size_t)n * sizeof(int));
        memcpy(CMSG_DATA(head), fds, (size_t)n * sizeof(int));
    }
    assert_int_equal(sendmsg(c->fd, &message, MSG_NOSIGNAL), 1);
    live_send(c, text + 1, strlen(text) - 1);
    live_send(c, "\n", 1);
    free(text);
}

/* Sends a call and does not wait for its answer. params are taken over (NULL = {}). */
static inline void live_ask(live_client *c, const char *method, json_t *params)
{
    live_ask_with(c, method, params, NULL, 0);
}

/* The whole answer to what was asked last; notifications are skipped. */
static inline json_t *live_answer(live_client *c)
{
    for (;;) {
        json_t *message = live_receive(c);
        if (!message)
            fail_msg("the daemon closed the connection");
        if (json_integer_value(json_object_get(message, "id")) == c->ids)
            return message;
        json_decref(message);
    }
}

/* The whole answer to a call. params are taken over (NULL = {}). */
static inline json_t *live_call(live_client *c, const char *method, json_t *params)
{
    live_ask(c, method, params);
    return live_answer(c);
}

/* The error code of a call's answer; 0 = it went well. */
static inline int live_code(live_client *c, const char *method, json_t *params)
{
    json_t *answer = live_call(c, method, params);
    int code = (int)json_integer_value(json_object_get(json_object_get(answer, "error"), "code"));
    json_decref(answer);
    return code;
}

/* A number of a call's result; the call must go well. */
static inline double live_number(live_client *c, const char *method, json_t *params,
                                 const char *key)
{
    json_t *answer = live_call(c, method, params);
    const json_t *value = json_object_get(json_object_get(answer, "result"), key);
    if (!json_is_number(value)) {
        char *text = json_dumps(answer, 0);
        print_error("%s: no %s in %s\n", method, key, text);
        free(text);
        fail();
    }
    double number = json_number_value(value);
    json_decref(answer);
    return number;
}

/* A text of the status. */
static inline const char *live_status_text(live_client *c, const char *key)
{
    json_t *answer = live_call(c, "status", NULL);
    const char *value = json_string_value(json_object_get(json_object_get(answer, "result"), key));
    char *buffer = lf_test_buffer();
    snprintf(buffer, PATH_MAX, "%s", value ? value : "");
    json_decref(answer);
    return buffer;
}

/* Waits until the panel shows the newest generation at this level. */
static inline void live_wait(live_client *c, const char *level)
{
    json_t *answer = live_call(c, "wait", json_pack("{s:s}", "for", level));
    assert_non_null(json_object_get(answer, "result"));
    json_decref(answer);
}

/* Follows a job's notifications to its end: "done", "failed", "cancelled". */
static inline const char *live_job_end(live_client *c, json_int_t job)
{
    for (;;) {
        json_t *message = live_receive(c);
        assert_non_null(message);
        const json_t *params = json_object_get(message, "params");
        const char *state = json_string_value(json_object_get(params, "state"));
        bool ours = state && json_integer_value(json_object_get(params, "job")) == job;
        char *buffer = lf_test_buffer();
        snprintf(buffer, PATH_MAX, "%s", state ? state : "");
        json_decref(message);
        if (ours && strcmp(buffer, "running") != 0)
            return buffer;
    }
}

/* Runs a program to its end; its exit code. args end with NULL. */
static inline int live_run(const live *l, const char *program, ...)
{
    char *args[40];
    char path[PATH_MAX];
    int n = 0;
    snprintf(path, sizeof path, "%s", lf_test_built(program));
    args[n++] = path;
    va_list more;
    va_start(more, program);
    for (const char *arg = va_arg(more, const char *); arg && n < 39;
         arg = va_arg(more, const char *))
        args[n++] = (char *)(uintptr_t)arg;
    va_end(more);
    args[n] = NULL;
    return live_reap(live_spawn(l, args));
}

#endif
