/* The simulated panel: sim:DIR[,option=value…]. It writes into DIR, which is created if missing:
 *
 *   panel.png, view.png, quilt.png   the panel's pixels, the image for an eye in front of it, the
 *                                    views. Each is whole at any time, with the generation as a
 *                                    text chunk. Written at once, then at most twice a second (and
 *                                    with at most a sixth of one core), when a client waits for
 *                                    them, and at the end
 *   updates.jsonl, updates.jsonl.1   one line per rectangle shown: seq (of the push), x, y, width,
 *                                    height, bytes, time_ns
 *   calibration.json                 read at open if it exists; otherwise the panel is a nominal
 *                                    Portrait
 *   .unplugged                       written when the unplug option takes effect
 *
 * The folder is held open and locked (flock), so that two daemons never share a panel. All files
 * are in the folder that was opened, whatever its name leads to now. Options: lf_sim_options in
 * device/sim/sim.h.
 *
 * If the folder is not writable, errors are counted and reported in info.problem, and the device
 * continues. If it is removed, the device ends (LF_DEVICE_LOST); opening it again creates a new
 * folder.
 *
 * This file is the state machine of pushes; a timerfd expires when the push in progress ends. */
#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/file.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/paths.h"
#include "base/thread.h"
#include "base/wakeup.h"
#include "device/device_table.h"
#include "device/sim/sim.h"

#define DESTROY_WAIT_NS LF_NS_PER_S

typedef struct sim_device {
    lf_device base;
    /* immutable after open */
    lf_sim_options options;
    lf_calibration calibration;
    char calibration_from[256];
    char spec[512];
    int dir_fd;            /* holds the lock; all files are opened through it */
    int timer_fd, news_fd; /* expires when a push ends; signals that the writer has written */
    int removed_fd;        /* inotify: removals in the parent folder; -1 = none */
    int poll_fd;           /* epoll of the three */
    lf_sim_writer *writer;
    /* event thread */
    bool may_unplug; /* the unplug option has not taken effect yet in this process */
    bool gone;
    bool busy;       /* a push is in progress … */
    bool fails;      /* … and will not be shown … */
    uint64_t end_ns; /* … and ends at this time (LF_SIM_NEVER) */
    bool retry;      /* a failed push is to be reported */
    bool given_up;   /* flush has timed out: destroy does not wait again */
    uint64_t pushes; /* pushes begun so far; the number of the last one */
    uint64_t generation;
    int n_pending;
    lf_sim_update *pending; /* [LF_DEVICE_MAX_RECTS] rectangles of the push in progress */
    lf_device_counters counters;
    char unplug_problem[256];
} sim_device;

static sim_device *sim_of(lf_device *device)
{
    return (sim_device *)(void *)device;
}

static const sim_device *const_sim_of(const lf_device *device)
{
    return (const sim_device *)(const void *)device;
}

/* -------------------------------------------------------------------------------------- open -- */

/* Creates a folder, whose parent must exist. */
static lf_status make_folder(const char *dir, lf_error *err)
{
    char parent[sizeof((lf_sim_options *)0)->dir];
    size_t n = strlen(dir);
    if (mkdir(dir, 0777) == 0 || errno == EEXIST)
        return LF_OK;
    if (errno != ENOENT)
        return lf_error_set(err, LF_E_IO, dir, "cannot make the folder: %s", lf_errno_text(errno));
    while (n > 1 && dir[n - 1] == '/')
        n--;
    while (n > 0 && dir[n - 1] != '/')
        n--;
    snprintf(parent, sizeof parent, "%.*s", n > 0 ? (int)n : 1, n > 0 ? dir : ".");
    return lf_error_set(err, LF_E_IO, dir, "the folder %s does not exist; make it first", parent);
}

static lf_status cannot_open(const char *dir, lf_error *err)
{
    return lf_error_set(err, LF_E_IO, dir, "cannot open the folder: %s", lf_errno_text(errno));
}

/* Opens the folder; creates it if only the last part is missing. */
static lf_status open_folder(const char *dir, int *out_fd, lf_error *err)
{
    int fd = open(dir, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0 && errno == ENOENT) {
        lf_status status = make_folder(dir, err);
        if (status != LF_OK)
            return status;
        fd = open(dir, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    }
    if (fd < 0)
        return cannot_open(dir, err);
    *out_fd = fd;
    return LF_OK;
}

/* The parent folder of the canonical name, O_PATH; -1 and errno. */
static int open_above(const char *dir, const char *last)
{
    char above[sizeof((lf_sim_options *)0)->dir];
    const char *start = dir + (dir[0] == '/');
    snprintf(above, sizeof above, "%.*s", last > start ? (int)(last - start - 1) : 0, start);
    int top = open(dir[0] == '/' ? "/" : ".", O_PATH | O_DIRECTORY | O_CLOEXEC);
    int fd = top >= 0 ? lf_beneath_open(top, above[0] ? above : ".", O_PATH | O_DIRECTORY) : -1;
    int why = errno;
    if (top >= 0)
        close(top);
    errno = why;
    return fd;
}

/* Opens the folder by its canonical name, following no link; creates it if only the last part is
 * missing. */
static lf_status open_canonical(const char *dir, int *out_fd, lf_error *err)
{
    const char *slash = strrchr(dir, '/'), *last = slash ? slash + 1 : dir;
    int held = -1, above = open_above(dir, last);
    bool made;
    if (above < 0)
        return cannot_open(dir, err);
    lf_status status = lf_held_folder(above, last, &held, &made, err);
    close(above);
    if (status != LF_OK)
        return status;
    int fd = openat(held, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        status = cannot_open(dir, err);
    else
        *out_fd = fd;
    close(held);
    return status;
}

static lf_status lock_folder(sim_device *sim, lf_error *err)
{
    const char *dir = sim->options.dir;
    lf_status status = sim->options.no_links ? open_canonical(dir, &sim->dir_fd, err)
                                             : open_folder(dir, &sim->dir_fd, err);
    if (status != LF_OK)
        return status;
    if (flock(sim->dir_fd, LOCK_EX | LOCK_NB) == 0)
        return LF_OK;
    if (errno == EWOULDBLOCK)
        return lf_error_set(err, LF_E_BUSY, dir,
                            "another quiltd uses this simulated panel; choose another folder");
    return lf_error_set(err, LF_E_IO, dir, "cannot lock the folder: %s", lf_errno_text(errno));
}

static lf_status find_calibration(sim_device *sim, const lf_calibration *override, lf_error *err)
{
    if (override) {
        sim->calibration = *override;
        snprintf(sim->calibration_from, sizeof sim->calibration_from, "given by the caller");
        return LF_OK;
    }
    static const char name[] = "calibration.json";
    char path[512], link[64];
    int fd = sim->options.no_links ? lf_beneath_open(sim->dir_fd, name, O_PATH)
                                   : openat(sim->dir_fd, name, O_PATH | O_CLOEXEC);
    if (fd < 0 && errno != ENOENT)
        return lf_error_set(err, LF_E_IO, name, "cannot open: %s", lf_errno_text(errno));
    if (fd < 0) {
        lf_calibration_portrait(&sim->calibration);
        snprintf(sim->calibration_from, sizeof sim->calibration_from, "nominal Portrait");
        return LF_OK;
    }
    snprintf(path, sizeof path, "%.480s/%s", sim->options.dir, name);
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    lf_device_text(sim->calibration_from, sizeof sim->calibration_from, path);
    lf_status status = lf_calibration_load(link, &sim->calibration, err);
    if (status != LF_OK && err)
        snprintf(err->where, sizeof err->where, "%s", path);
    close(fd);
    return status;
}

static lf_status check_plug(sim_device *sim, lf_error *err)
{
    const lf_sim_options *o = &sim->options;
    if (o->unplug_updates == 0) {
        lf_sim_plug_clear(sim->dir_fd);
        return LF_OK;
    }
    lf_sim_plug plug = lf_sim_plug_state(sim->dir_fd, lf_time_now_ns());
    if (plug == LF_SIM_UNPLUGGED)
        return lf_error_set(err, LF_E_NODEV, o->dir, "the simulated panel is unplugged");
    sim->may_unplug = plug == LF_SIM_PLUGGED;
    return LF_OK;
}

static bool add_to_poll(const sim_device *sim, int fd)
{
    struct epoll_event event = {.events = EPOLLIN};
    return fd >= 0 && epoll_ctl(sim->poll_fd, EPOLL_CTL_ADD, fd, &event) == 0;
}

/* Watches the parent, since a folder that is held open gets no event about its own removal. Without
 * this, the next picture detects it. */
static void watch_removal(sim_device *sim)
{
    char above[64];
    snprintf(above, sizeof above, "/proc/self/fd/%d/..", sim->dir_fd);
    sim->removed_fd = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
    if (sim->removed_fd < 0)
        return;
    (void)inotify_add_watch(sim->removed_fd, above, IN_DELETE | IN_ONLYDIR);
    (void)add_to_poll(sim, sim->removed_fd);
}

static bool make_descriptors(sim_device *sim)
{
    sim->timer_fd = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    sim->news_fd = lf_wakeup_make();
    sim->poll_fd = epoll_create1(EPOLL_CLOEXEC);
    if (!add_to_poll(sim, sim->timer_fd) || !add_to_poll(sim, sim->news_fd))
        return false;
    watch_removal(sim);
    return true;
}

static lf_status sim_open(const char *argument, const lf_calibration *calibration,
                          lf_device **out_device, lf_error *err)
{
    lf_status status;
    sim_device *sim = lf_calloc(1, sizeof *sim);
    if (!sim)
        return lf_error_set(err, LF_E_NOMEM, "sim", "out of memory");
    sim->base.ops = &lf_sim_ops;
    sim->dir_fd = sim->timer_fd = sim->news_fd = sim->removed_fd = sim->poll_fd = -1;
    status = lf_sim_options_parse(argument, &sim->options, err);
    if (status != LF_OK)
        goto fail;
    snprintf(sim->spec, sizeof sim->spec, "sim:%.500s", argument);
    status = lock_folder(sim, err);
    if (status != LF_OK)
        goto fail;
    status = check_plug(sim, err);
    if (status != LF_OK)
        goto fail;
    status = find_calibration(sim, calibration, err);
    if (status != LF_OK)
        goto fail;
    sim->pending = lf_calloc(LF_DEVICE_MAX_RECTS, sizeof *sim->pending);
    if (!sim->pending || !make_descriptors(sim)) {
        status = lf_error_set(err, LF_E_NOMEM, "sim", "out of memory or descriptors");
        goto fail;
    }
    status = lf_sim_writer_create(&sim->options, sim->dir_fd, sim->news_fd, &sim->calibration,
                                  &sim->writer, err);
    if (status != LF_OK)
        goto fail;
    *out_device = &sim->base;
    return LF_OK;
fail:
    lf_device_destroy(&sim->base);
    return status;
}

/* -------------------------------------------------------------------------------------- push -- */

/* True if an option makes the current push fail. */
static bool push_fails(const sim_device *sim)
{
    const lf_sim_options *o = &sim->options;
    return sim->pushes == o->error_push ||
           (o->error_every > 0 && sim->pushes % o->error_every == 0);
}

static uint64_t push_duration_ns(const sim_device *sim, uint64_t bytes)
{
    const lf_sim_options *o = &sim->options;
    uint64_t duration = o->latency_ms * LF_NS_PER_MS;
    if (o->bandwidth > 0)
        duration += (uint64_t)((double)bytes / (double)o->bandwidth * (double)LF_NS_PER_S);
    if (sim->pushes != o->stall_push)
        return duration;
    return o->stall_ms == LF_SIM_NEVER ? LF_SIM_NEVER : duration + o->stall_ms * LF_NS_PER_MS;
}

/* Sets the timer to end_ns; LF_SIM_NEVER: never. */
static void set_timer(const sim_device *sim, uint64_t end_ns)
{
    if (end_ns == LF_SIM_NEVER)
        return;
    struct itimerspec at = {.it_value = {.tv_sec = (time_t)(end_ns / LF_NS_PER_S),
                                         .tv_nsec = (long)(end_ns % LF_NS_PER_S)}};
    timerfd_settime(sim->timer_fd, TFD_TIMER_ABSTIME, &at, NULL);
}

static lf_status sim_push(lf_device *device, const lf_image8 *frame, const lf_rect *rects, int n,
                          uint64_t generation)
{
    sim_device *sim = sim_of(device);
    if (sim->gone)
        return LF_E_NODEV;
    if (sim->busy || sim->retry)
        return LF_E_STATE;
    if (!lf_device_push_fits(sim->calibration.screen_width_px, sim->calibration.screen_height_px,
                             frame, rects, n))
        return LF_E_ARG;
    uint64_t bytes = 0;
    sim->pushes++;
    for (int i = 0; i < n; i++) {
        uint64_t size = (uint64_t)rects[i].width * (uint64_t)rects[i].height * 3;
        sim->pending[i] = (lf_sim_update){.seq = sim->pushes, .rect = rects[i], .bytes = size};
        bytes += size;
    }
    uint64_t duration = push_duration_ns(sim, bytes);
    sim->n_pending = n;
    sim->generation = generation;
    sim->busy = true;
    sim->fails = push_fails(sim);
    sim->end_ns = duration == LF_SIM_NEVER ? LF_SIM_NEVER : lf_time_now_ns() + duration;
    if (!sim->fails && duration != LF_SIM_NEVER)
        lf_sim_writer_pixels(sim->writer, frame, rects, n);
    set_timer(sim, sim->end_ns);
    return LF_OK;
}

static void unplug(sim_device *sim)
{
    lf_error err = {0};
    uint64_t away = sim->options.replug_ms;
    uint64_t back_ns = away == LF_SIM_NEVER ? LF_SIM_NEVER : lf_time_now_ns() + away * LF_NS_PER_MS;
    sim->gone = true;
    if (lf_sim_plug_out(sim->dir_fd, back_ns, &err) != LF_OK) {
        char text[512];
        snprintf(text, sizeof text, "cannot record that the panel was unplugged: %.200s", err.what);
        lf_device_text(sim->unplug_problem, sizeof sim->unplug_problem, text);
        sim->counters.errors++;
    }
}

/* Ends the push in progress: successfully, or with its fault. */
static void end_push(sim_device *sim)
{
    sim->busy = false;
    if (sim->fails) {
        sim->retry = true;
        sim->counters.errors++;
        return;
    }
    uint64_t now = lf_time_now_ns();
    for (int i = 0; i < sim->n_pending; i++) {
        sim->pending[i].time_ns = now;
        sim->counters.bytes += sim->pending[i].bytes;
    }
    sim->counters.updates += (uint64_t)sim->n_pending;
    lf_sim_writer_shown(sim->writer, sim->pending, sim->n_pending, sim->generation);
    if (sim->may_unplug && sim->counters.updates >= sim->options.unplug_updates)
        unplug(sim);
}

/* ----------------------------------------------------------------------------- the other ops -- */

/* Waits until the push in progress has ended, at most until `until`; false: it has not. */
static bool wait_for_push(sim_device *sim, uint64_t until)
{
    if (!sim->busy)
        return true;
    uint64_t end = sim->end_ns < until ? sim->end_ns : until;
    struct timespec at = {.tv_sec = (time_t)(end / LF_NS_PER_S),
                          .tv_nsec = (long)(end % LF_NS_PER_S)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL) == EINTR)
        ;
    if (sim->end_ns > until)
        return false;
    end_push(sim);
    return true;
}

static void sim_destroy(lf_device *device)
{
    sim_device *sim = sim_of(device);
    if (sim->writer && !sim->given_up)
        wait_for_push(sim, lf_time_now_ns() + DESTROY_WAIT_NS);
    lf_sim_writer_destroy(sim->writer);
    /* the folder last: its lock covers all files */
    const int fds[] = {sim->poll_fd, sim->removed_fd, sim->news_fd, sim->timer_fd, sim->dir_fd};
    for (size_t i = 0; i < sizeof fds / sizeof *fds; i++)
        if (fds[i] >= 0)
            close(fds[i]);
    lf_free(sim->pending);
    lf_free(sim);
}

static void sim_info(const lf_device *device, lf_device_info *out)
{
    const sim_device *sim = const_sim_of(device);
    const lf_calibration *c = &sim->calibration;
    *out = (lf_device_info){.kind = "sim", .output = "file"};
    lf_device_text(out->spec, sizeof out->spec, sim->spec);
    snprintf(out->model, sizeof out->model, "simulated panel, %dx%d", c->screen_width_px,
             c->screen_height_px);
    lf_device_text(out->serial, sizeof out->serial, c->serial);
    memcpy(out->calibration_from, sim->calibration_from, sizeof out->calibration_from);
    lf_sim_writer_problem(sim->writer, out->problem, sizeof out->problem);
    if (sim->unplug_problem[0] != 0)
        memcpy(out->problem, sim->unplug_problem, sizeof out->problem);
}

static const lf_calibration *sim_calibration(const lf_device *device)
{
    return &const_sim_of(device)->calibration;
}

static void sim_views(lf_device *device, const lf_views8 *views, int columns, int rows)
{
    sim_device *sim = sim_of(device);
    if (!sim->gone)
        lf_sim_writer_views(sim->writer, views, columns, rows);
}

static int sim_poll_fd(const lf_device *device)
{
    return const_sim_of(device)->poll_fd;
}

static lf_device_event sim_dispatch(lf_device *device)
{
    sim_device *sim = sim_of(device);
    uint64_t rings;
    char events[4096]; /* a removal; lf_sim_removed checks which */
    /* Reading nothing is not an error: only the clock decides. */
    if (read(sim->timer_fd, &rings, sizeof rings) < 0)
        assert(errno == EAGAIN || errno == EINTR || errno == ECANCELED);
    lf_wakeup_clear(sim->news_fd);
    while (sim->removed_fd >= 0 && read(sim->removed_fd, events, sizeof events) > 0)
        ;
    if (sim->busy && lf_time_now_ns() >= sim->end_ns)
        end_push(sim);
    if (sim->gone)
        return LF_DEVICE_GONE;
    if (lf_sim_removed(sim->dir_fd))
        return LF_DEVICE_LOST;
    if (sim->busy)
        return LF_DEVICE_BUSY;
    if (!sim->retry)
        return LF_DEVICE_READY;
    sim->retry = false;
    return LF_DEVICE_RETRY;
}

static lf_status sim_kept(lf_device *device, bool awaited, uint64_t *out_pushes)
{
    sim_device *sim = sim_of(device);
    lf_status status = lf_sim_writer_kept(sim->writer, awaited, out_pushes);
    if (!lf_sim_removed(sim->dir_fd))
        return status;
    lf_wakeup_signal(sim->news_fd); /* dispatch reports it */
    return LF_E_NODEV;
}

static void sim_counters(const lf_device *device, lf_device_counters *out)
{
    const sim_device *sim = const_sim_of(device);
    char problem[256];
    *out = sim->counters;
    out->errors += lf_sim_writer_problem(sim->writer, problem, sizeof problem);
}

static lf_status sim_flush(lf_device *device, int timeout_ms)
{
    sim_device *sim = sim_of(device);
    uint64_t began = lf_time_now_ns(),
             limit = (uint64_t)(timeout_ms > 0 ? timeout_ms : 0) * LF_NS_PER_MS;
    sim->given_up = !wait_for_push(sim, began + limit);
    if (sim->given_up)
        return LF_E_TIMEOUT;
    uint64_t used = lf_time_now_ns() - began;
    lf_status status =
        lf_sim_writer_flush(sim->writer, used < limit ? (int)((limit - used) / LF_NS_PER_MS) : 0);
    return status == LF_OK && sim->gone ? LF_E_NODEV : status;
}

/* The folder of a spec: up to the first comma. */
static size_t sim_folder(const char *argument)
{
    return strcspn(argument, ",");
}

/* The canonical folder, malloced; NULL = it does not exist yet. */
static char *real_folder(const char *argument)
{
    char folder[sizeof((lf_sim_options *)0)->dir];
    snprintf(folder, sizeof folder, "%.*s", (int)sim_folder(argument), argument);
    return realpath(folder, NULL);
}

static bool sim_same(const char *argument, const char *other)
{
    char *ours = real_folder(argument), *theirs = real_folder(other);
    bool same = ours && theirs && strcmp(ours, theirs) == 0;
    free(ours);
    free(theirs);
    return same;
}

const lf_device_ops lf_sim_ops = {
    .kind = "sim",
    .is_panel = true,
    .same = sim_same,
    .folder = sim_folder,
    .no_links = ",links=no",
    .open = sim_open,
    .destroy = sim_destroy,
    .info = sim_info,
    .calibration = sim_calibration,
    .push = sim_push,
    .views = sim_views,
    .poll_fd = sim_poll_fd,
    .dispatch = sim_dispatch,
    .kept = sim_kept,
    .counters = sim_counters,
    .flush = sim_flush,
};
