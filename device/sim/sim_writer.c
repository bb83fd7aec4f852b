#include <assert.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "base/log.h"
#include "base/thread.h"
#include "base/wakeup.h"
#include "device/device_table.h"
#include "device/sim/optics.h"
#include "device/sim/sim.h"

#define LEAST_PAUSE_NS (LF_NS_PER_S / 2)
#define PAUSE_PER_WORK 5 /* pictures use at most a sixth of one core */
#define LAST_PICTURES_NS (LF_NS_PER_S / 2)

enum { PNG_LEVEL = 1, RING = 16384, BATCH = 256, MAX_QUILT = 16384, NICER = 5 };

/* Counts of lf_sim_writer_shown: all; those with all pictures on disk; those for which writing was
 * attempted. */
typedef struct progress {
    uint64_t shown, written, attempted;
    uint64_t awaited; /* count that a client waits for; 0 = none */
} progress;

/* Lines not yet written to the log. */
typedef struct owed_lines {
    uint64_t n, start;
    lf_sim_update *ring; /* [RING] */
    bool failed;         /* a line was lost since the last flush */
    char problem[256];
} owed_lines;

struct lf_sim_writer {
    /* immutable after create */
    char dir[512]; /* for messages */
    int folder_fd, news_fd;
    bool has_lock, has_wake, has_idle, has_thread;
    pthread_t thread;

    /* writer thread only */
    lf_sim_log log;
    lf_sim_optics *optics; /* NULL: this calibration cannot be simulated */
    lf_image8 snapshot, view, quilt;
    uint64_t snapshot_generation;

    pthread_mutex_t lock;
    pthread_cond_t wake; /* for the thread: there is work */
    pthread_cond_t idle; /* for flush: a round has ended */

    /* under lock */
    lf_image8 panel;      /* what the panel shows */
    lf_image8 next_quilt; /* newest views */
    uint64_t generation;  /* generation of the panel's picture */
    progress progress;
    /* next_quilt is new: written with the panel's next picture, or alone at the end */
    bool quilt_new;
    bool hurry, stop;
    uint64_t stop_ns; /* time of destroy */
    uint64_t due_ns;  /* earliest time of the next picture */
    owed_lines owed;
    uint64_t errors;
    char picture_problem[256];
};

static uint64_t thread_cpu_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (uint64_t)t.tv_sec * LF_NS_PER_S + (uint64_t)t.tv_nsec;
}

/* Sets the problem from err, which is about a file in the folder. */
static void set_problem(const lf_sim_writer *w, char *out, size_t size, const lf_error *err)
{
    char text[256];
    const char *slash = strrchr(err->where, '/');
    snprintf(text, sizeof text, "%.90s/%.20s: %.110s; the files are out of date", w->dir,
             slash ? slash + 1 : err->where, err->what);
    lf_device_text(out, size, text);
}

/* Logs a problem once until it is over, because nobody may query it. `known`: the last problem
 * logged. Called without the lock, so that the panel never waits for it; only this thread writes
 * problems. */
static void tell_problem(const lf_sim_writer *w, const char *known, const char *problem)
{
    if (problem[0] != 0 && known[0] == 0 &&
        !lf_sim_removed(w->folder_fd)) /* the device reports that */
        lf_log(LF_LOG_WARNING, "sim: %s", problem);
}

/* ------------------------------------------------------------------------ pictures and lines -- */

static lf_status write_png(const lf_sim_writer *w, const char *name, const lf_image8 *image,
                           lf_error *err)
{
    char number[32];
    snprintf(number, sizeof number, "%" PRIu64, w->snapshot_generation);
    const lf_attribute attribute = {"generation", number};
    lf_outfile file = {.fd = -1};
    char *path = lf_held_path(w->folder_fd, name);
    lf_status status = path ? lf_outfile_open(&file, path, true, err)
                            : lf_error_set(err, LF_E_NOMEM, name, "out of memory");
    lf_free(path);
    if (status != LF_OK)
        return status;
    status = lf_png_write(&file, image, PNG_LEVEL, &attribute, 1, err);
    if (status == LF_OK)
        status = lf_outfile_commit(&file, true, err);
    lf_outfile_abandon(&file);
    return status;
}

/* True: destroy has waited so long that optional work is skipped. */
static bool too_late(lf_sim_writer *w)
{
    pthread_mutex_lock(&w->lock);
    bool late = w->stop && lf_time_now_ns() > w->stop_ns + LAST_PICTURES_NS;
    pthread_mutex_unlock(&w->lock);
    return late;
}

/* Copies the panel's current state and the newest views to the thread's own pictures. */
static bool take_pictures(lf_sim_writer *w)
{
    memcpy(w->snapshot.data, w->panel.data, w->panel.stride * (size_t)w->panel.height);
    w->snapshot_generation = w->generation;
    bool quilt_new = w->quilt_new;
    if (quilt_new) {
        lf_image8 old = w->quilt;
        w->quilt = w->next_quilt;
        w->next_quilt = old;
        w->quilt_new = false;
    }
    return quilt_new;
}

/* Called and left with the lock held. */
static void write_pictures(lf_sim_writer *w, bool *quilt_owed)
{
    uint64_t taken = w->progress.shown;
    *quilt_owed = take_pictures(w) || *quilt_owed;
    pthread_mutex_unlock(&w->lock);

    uint64_t began = thread_cpu_ns();
    lf_error err = {0};
    lf_status status = write_png(w, "panel.png", &w->snapshot, &err);
    if (status == LF_OK && w->optics && !too_late(w)) {
        lf_optics_view(w->optics, &w->snapshot, &w->view);
        status = write_png(w, "view.png", &w->view, &err);
    }
    if (status == LF_OK && *quilt_owed && !too_late(w)) {
        status = write_png(w, "quilt.png", &w->quilt, &err);
        *quilt_owed = status != LF_OK;
    }
    uint64_t pause = (thread_cpu_ns() - began) * PAUSE_PER_WORK;
    char problem[sizeof w->picture_problem] = "";
    if (status != LF_OK)
        set_problem(w, problem, sizeof problem, &err);
    tell_problem(w, w->picture_problem, problem);

    pthread_mutex_lock(&w->lock);
    w->progress.attempted = taken;
    memcpy(w->picture_problem, problem, sizeof problem);
    if (status == LF_OK)
        w->progress.written = taken;
    else
        w->errors++;
    w->due_ns = lf_time_now_ns() + (pause > LEAST_PAUSE_NS ? pause : LEAST_PAUSE_NS);
    if (w->progress.awaited > 0 && w->progress.awaited <= taken) {
        w->progress.awaited = 0;
        lf_wakeup_signal(w->news_fd);
    }
}

/* Called and left with the lock held. */
static void write_lines(lf_sim_writer *w)
{
    lf_sim_update batch[BATCH];
    int n = 0;
    for (; n < BATCH && w->owed.n > 0; n++, w->owed.n--, w->owed.start++)
        batch[n] = w->owed.ring[w->owed.start % RING];
    pthread_mutex_unlock(&w->lock);
    lf_error err = {0};
    lf_status status = lf_sim_log_append(&w->log, batch, n, &err);
    pthread_mutex_lock(&w->lock);
    w->owed.problem[0] = 0;
    if (status != LF_OK) {
        w->errors++;
        w->owed.failed = true;
        set_problem(w, w->owed.problem, sizeof w->owed.problem, &err);
    }
}

/* -------------------------------------------------------------------------------- the thread -- */

/* True if there is work that flush waits for. */
static bool untried(const lf_sim_writer *w)
{
    return w->progress.shown != w->progress.attempted || w->quilt_new;
}

static bool picture_due(const lf_sim_writer *w)
{
    if (w->hurry || w->stop)
        return untried(w);
    return w->progress.awaited > w->progress.attempted ||
           (w->progress.shown != w->progress.written && lf_time_now_ns() >= w->due_ns);
}

static void wait_for_work(lf_sim_writer *w)
{
    if (w->progress.shown == w->progress.written || w->hurry) {
        pthread_cond_wait(&w->wake, &w->lock);
        return;
    }
    lf_cond_wait_until(&w->wake, &w->lock, w->due_ns);
}

static void *writer_main(void *context)
{
    lf_sim_writer *w = context;
    bool quilt_owed = false;
    /* Encoding yields to commands, and shares time with rendering, because a client may wait for
     * the files. On Linux the priority is per thread. */
    (void)setpriority(PRIO_PROCESS, (id_t)gettid(), getpriority(PRIO_PROCESS, 0) + NICER);
    pthread_mutex_lock(&w->lock);
    for (;;) {
        if (w->owed.n > 0)
            write_lines(w);
        else if (picture_due(w))
            write_pictures(w, &quilt_owed);
        else if (w->stop)
            break;
        else
            wait_for_work(w);
        pthread_cond_broadcast(&w->idle);
    }
    pthread_mutex_unlock(&w->lock);
    return NULL;
}

/* ------------------------------------------------------------------ from the device's thread -- */

void lf_sim_writer_pixels(lf_sim_writer *w, const lf_image8 *frame, const lf_rect *rects, int n)
{
    pthread_mutex_lock(&w->lock);
    for (int i = 0; i < n; i++) {
        lf_rect r = rects[i];
        for (int y = r.y; y < r.y + r.height; y++)
            memcpy(w->panel.data + (size_t)y * w->panel.stride + (size_t)r.x * 3,
                   frame->data + (size_t)y * frame->stride + (size_t)r.x * 3, (size_t)r.width * 3);
    }
    pthread_mutex_unlock(&w->lock);
}

void lf_sim_writer_shown(lf_sim_writer *w, const lf_sim_update *updates, int n, uint64_t generation)
{
    pthread_mutex_lock(&w->lock);
    w->generation = generation;
    w->progress.shown++;
    for (int i = 0; i < n; i++) {
        if (w->owed.n == RING) { /* the disk is too slow: drops the oldest line */
            w->owed.start++;
            w->owed.n--;
            w->errors++;
            w->owed.failed = true;
            snprintf(w->owed.problem, sizeof w->owed.problem,
                     "the disk is too slow for updates.jsonl, so lines are missing");
        }
        w->owed.ring[(w->owed.start + w->owed.n++) % RING] = updates[i];
    }
    pthread_cond_signal(&w->wake);
    pthread_mutex_unlock(&w->lock);
}

/* Makes `quilt` a black picture of this size, unless it has the size. */
static lf_status shape_quilt(lf_image8 *quilt, int width, int height)
{
    if (quilt->data && quilt->width == width && quilt->height == height)
        return LF_OK;
    lf_image8_finish(quilt);
    return lf_image8_init(quilt, width, height, 3);
}

/* Copies a view to its tile, or blackens a tile after the last view (the previous quilt of this
 * size may have had more). */
static void fill_tile(const lf_views8 *views, int tile, int x, int y, lf_image8 *quilt)
{
    for (int row = 0; row < views->height; row++) {
        uint8_t *out = quilt->data + (size_t)(y + row) * quilt->stride + (size_t)x * 3;
        if (tile < views->n_views)
            memcpy(out, lf_views8_row(views, tile, row), (size_t)views->width * 3);
        else
            memset(out, 0, (size_t)views->width * 3);
    }
}

void lf_sim_writer_views(lf_sim_writer *w, const lf_views8 *views, int columns, int rows)
{
    if (columns < 1 || rows < 1 || views->width < 1 || views->height < 1 ||
        columns > MAX_QUILT / views->width || rows > MAX_QUILT / views->height)
        return;
    pthread_mutex_lock(&w->lock);
    if (shape_quilt(&w->next_quilt, columns * views->width, rows * views->height) == LF_OK) {
        for (int tile = 0; tile < columns * rows; tile++)
            fill_tile(views, tile, tile % columns * views->width,
                      (rows - 1 - tile / columns) * views->height, &w->next_quilt);
        w->quilt_new = true;
    }
    pthread_mutex_unlock(&w->lock);
}

lf_status lf_sim_writer_flush(lf_sim_writer *w, int timeout_ms)
{
    uint64_t end = lf_time_now_ns() + (uint64_t)(timeout_ms > 0 ? timeout_ms : 0) * LF_NS_PER_MS;
    bool in_time = true;
    pthread_mutex_lock(&w->lock);
    w->hurry = true;
    if (w->progress.written != w->progress.shown)
        w->progress.attempted = w->progress.written; /* retries what failed before */
    pthread_cond_signal(&w->wake);
    while ((w->owed.n > 0 || untried(w)) && in_time)
        in_time = lf_cond_wait_until(&w->idle, &w->lock, end);
    w->hurry = false;
    bool done = w->owed.n == 0 && !untried(w);
    bool failed = w->owed.failed || w->progress.written != w->progress.shown;
    if (done)
        w->owed.failed = false;
    pthread_cond_signal(&w->wake); /* while hurrying it waits without a due time */
    pthread_mutex_unlock(&w->lock);
    return !done ? LF_E_TIMEOUT : failed ? LF_E_IO : LF_OK;
}

lf_status lf_sim_writer_kept(lf_sim_writer *w, bool awaited, uint64_t *out_shown)
{
    pthread_mutex_lock(&w->lock);
    progress *p = &w->progress;
    if (awaited && p->written < p->shown) {
        p->awaited = p->shown;
        pthread_cond_signal(&w->wake);
    }
    *out_shown = p->written;
    const bool failed = p->attempted != p->written && p->attempted >= p->awaited;
    pthread_mutex_unlock(&w->lock);
    return failed ? LF_E_IO : LF_OK;
}

uint64_t lf_sim_writer_problem(lf_sim_writer *w, char *out, size_t size)
{
    pthread_mutex_lock(&w->lock);
    const char *problem = w->picture_problem[0] != 0 ? w->picture_problem : w->owed.problem;
    if (problem[0] == 0 && !w->optics)
        problem = "view.png is not written, because the panel's pixels are too coarse for the "
                  "lenses of this calibration";
    snprintf(out, size, "%s", problem);
    uint64_t errors = w->errors;
    pthread_mutex_unlock(&w->lock);
    return errors;
}

/* --------------------------------------------------------------------------- create, destroy -- */

static lf_status make_pictures(lf_sim_writer *w, const lf_calibration *c, double eye_deg)
{
    lf_status status = lf_image8_init(&w->panel, c->screen_width_px, c->screen_height_px, 3);
    if (status == LF_OK)
        status = lf_image8_init(&w->snapshot, c->screen_width_px, c->screen_height_px, 3);
    if (status != LF_OK)
        return status;
    status = lf_optics_create(c, eye_deg, &w->optics, NULL);
    if (status != LF_OK)
        return status == LF_E_ARG ? LF_OK : status; /* lf_sim_writer_problem reports it */
    int width, height;
    lf_optics_size(w->optics, &width, &height);
    return lf_image8_init(&w->view, width, height, 3);
}

static bool make_locks(lf_sim_writer *w)
{
    w->has_lock = pthread_mutex_init(&w->lock, NULL) == 0;
    w->has_wake = lf_cond_init(&w->wake) == LF_OK;
    w->has_idle = lf_cond_init(&w->idle) == LF_OK;
    return w->has_lock && w->has_wake && w->has_idle;
}

lf_status lf_sim_writer_create(const lf_sim_options *options, int folder_fd, int news_fd,
                               const lf_calibration *calibration, lf_sim_writer **out,
                               lf_error *err)
{
    lf_status status = LF_E_NOMEM;
    lf_sim_writer *w = lf_calloc(1, sizeof *w);
    if (!w)
        goto fail;
    snprintf(w->dir, sizeof w->dir, "%s", options->dir);
    w->folder_fd = folder_fd;
    w->news_fd = news_fd;
    lf_sim_log_init(&w->log, folder_fd, options->rotate_bytes);
    w->owed.ring = lf_calloc(RING, sizeof *w->owed.ring);
    if (!w->owed.ring || !make_locks(w))
        goto fail;
    status = make_pictures(w, calibration, options->eye_deg);
    if (status != LF_OK)
        goto fail;
    status = lf_thread_start("lf-sim", writer_main, w, &w->thread);
    if (status != LF_OK)
        goto fail;
    w->has_thread = true;
    *out = w;
    return LF_OK;
fail:
    lf_sim_writer_destroy(w);
    return lf_error_set(err, status, options->dir, "cannot create the simulated panel: %s",
                        lf_status_name(status));
}

static void end_thread(lf_sim_writer *w)
{
    pthread_mutex_lock(&w->lock);
    w->stop = true;
    w->stop_ns = lf_time_now_ns();
    if (w->progress.written != w->progress.shown)
        w->progress.attempted = w->progress.written;
    pthread_cond_signal(&w->wake);
    pthread_mutex_unlock(&w->lock);
    pthread_join(w->thread, NULL);
}

void lf_sim_writer_destroy(lf_sim_writer *w)
{
    if (!w)
        return;
    if (w->has_thread)
        end_thread(w);
    lf_sim_log_finish(&w->log);
    lf_optics_destroy(w->optics);
    lf_image8_finish(&w->panel);
    lf_image8_finish(&w->snapshot);
    lf_image8_finish(&w->view);
    lf_image8_finish(&w->quilt);
    lf_image8_finish(&w->next_quilt);
    lf_free(w->owed.ring);
    if (w->has_idle)
        pthread_cond_destroy(&w->idle);
    if (w->has_wake)
        pthread_cond_destroy(&w->wake);
    if (w->has_lock)
        pthread_mutex_destroy(&w->lock);
    lf_free(w);
}
