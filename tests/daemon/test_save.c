/* The daemon's end while it saves its accumulation on a slow disk. The daemon is this program
 * again, with a disk and a clock of its own (see wrap_test_save). */
#include "tests/daemon/live.h"

#include <dirent.h>
#include <stdatomic.h>
#include <systemd/sd-event.h>

#include "base/log.h"
#include "daemon/parts/saver.h"
#include "daemon/server/server.h"

/* ----------------------------------------------------------------------- the disk, the clock -- */

#define SOON_USEC UINT64_C(300000)
#define SLOW_SECONDS 2

static atomic_int syncs, at_once;

int __wrap_fsync(int fd);
int __wrap_fsync(int fd)
{
    (void)fd;
    if (atomic_fetch_add(&at_once, 1) > 0)
        lf_log(LF_LOG_WARNING, "two saves at once");
    if (atomic_fetch_add(&syncs, 1) == 0) {
        lf_log(LF_LOG_WARNING, "the first save begins");
        sleep(SLOW_SECONDS);
        lf_log(LF_LOG_WARNING, "the first save is on the disk");
    }
    atomic_fetch_sub(&at_once, 1);
    return 0;
}

int __real_sd_event_add_time_relative(sd_event *event, sd_event_source **source, clockid_t clock,
                                      uint64_t usec, uint64_t accuracy,
                                      sd_event_time_handler_t callback, void *context);
int __wrap_sd_event_add_time_relative(sd_event *event, sd_event_source **source, clockid_t clock,
                                      uint64_t usec, uint64_t accuracy,
                                      sd_event_time_handler_t callback, void *context);
int __wrap_sd_event_add_time_relative(sd_event *event, sd_event_source **source, clockid_t clock,
                                      uint64_t usec, uint64_t accuracy,
                                      sd_event_time_handler_t callback, void *context)
{
    return __real_sd_event_add_time_relative(
        event, source, clock, usec == LF_SAVE_USEC ? SOON_USEC : usec, accuracy, callback, context);
}

/* -------------------------------------------------------------------------------- the daemon -- */

/* args: what start gives. */
static int run_server(char *args[])
{
    lf_server_config config = {
        .scene = args[1], .socket = args[2], .device = "none", .state_dir = args[3]};
    lf_log_init("quiltd", LF_LOG_INFO);
    lf_button_actions_default(&config.buttons);
    config.options.view_width = 24;
    config.options.view_height = 32;
    config.options.threads = 2;
    int code = lf_server_run(&config);
    lf_log(LF_LOG_WARNING, "nothing was left to the kernel");
    return code;
}

static void start(live *l)
{
    live_prepare(l);
    char *args[] = {(char *)(uintptr_t) "/proc/self/exe", l->scene, l->socket, l->state, NULL};
    l->pid = live_spawn(l, args);
}

static bool await_line(const live *l, const char *text)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && !live_logged(l, text); i++)
        live_nap(20);
    return live_logged(l, text);
}

static void a_save_under_way_ends_before_the_last_one(void **state)
{
    (void)state;
    live l;
    start(&l);
    assert_true(await_line(&l, "the first save begins"));
    assert_int_equal(live_stop(&l), 0);
    assert_true(live_logged(&l, "the first save is on the disk"));
    assert_false(live_logged(&l, "two saves at once"));
    assert_true(live_logged(&l, "nothing was left to the kernel"));
    DIR *dir = opendir(l.state);
    int n = 0;
    assert_non_null(dir);
    for (const struct dirent *entry; (entry = readdir(dir));)
        n += strstr(entry->d_name, ".lfstate") ? 1 : 0;
    closedir(dir);
    assert_int_equal(n, 1);
    live_finish(&l);
}

int main(int argc, char *argv[])
{
    if (argc > 1)
        return run_server(argv);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_save_under_way_ends_before_the_last_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
