#include "device/window/sdl.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "device/device_table.h"

/* Who has SDL. */
static pthread_mutex_t turn_lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t turn_over = PTHREAD_COND_INITIALIZER;
static bool in_use;

static uint64_t in_ms(int ms)
{
    return lf_time_now_ns() + (uint64_t)ms * LF_NS_PER_MS;
}

static bool take_turn(int wait_ms)
{
    uint64_t end = in_ms(wait_ms);
    const struct timespec until = {.tv_sec = (time_t)(end / LF_NS_PER_S),
                                   .tv_nsec = (long)(end % LF_NS_PER_S)};
    int e = 0;
    pthread_mutex_lock(&turn_lock);
    /* a condition that is made by its initializer knows no other clock by itself */
    while (in_use && e == 0)
        e = pthread_cond_clockwait(&turn_over, &turn_lock, CLOCK_MONOTONIC, &until);
    bool mine = !in_use;
    in_use = true;
    pthread_mutex_unlock(&turn_lock);
    return mine;
}

static void end_turn(void)
{
    pthread_mutex_lock(&turn_lock);
    in_use = false;
    pthread_cond_signal(&turn_over);
    pthread_mutex_unlock(&turn_lock);
}

static bool is_set(const char *variable)
{
    const char *value = getenv(variable);
    return value && value[0] != 0;
}

bool lf_sdl_has_desktop(void)
{
    return is_set("WAYLAND_DISPLAY") || is_set("DISPLAY") || is_set("SDL_VIDEODRIVER");
}

lf_status lf_sdl_load(const char *library, lf_sdl *out, lf_error *err)
{
    lf_sdl sdl;
    const char *missing = NULL;
    void *handle = dlopen(library ? library : "libSDL2-2.0.so.0", RTLD_NOW | RTLD_LOCAL);
    if (!handle)
        return lf_error_set(err, LF_E_NODEV, "window",
                            "SDL2 is not installed; run apt-get install libsdl2-2.0-0");
        /* C has no conversion from an object's address to a function's; POSIX promises this one. */
#define X(name)                                                                                    \
    do {                                                                                           \
        void *address = dlsym(handle, "SDL_" #name);                                               \
        memcpy(&sdl.name, &address, sizeof address);                                               \
        if (!address)                                                                              \
            missing = #name;                                                                       \
    } while (0);
    LF_SDL_FUNCTIONS(X)
#undef X
    if (missing)
        return lf_error_set(
            err, LF_E_NODEV, "window",
            "SDL has no SDL_%s, because it is older than 2.0.16; run apt-get install libsdl2-2.0-0",
            missing);
    *out = sdl;
    return LF_OK;
}

lf_status lf_sdl_no_answer(int timeout_ms, lf_error *err)
{
    return lf_error_set(err, LF_E_IO, "window",
                        "the desktop has not answered for %d ms and may have stopped responding",
                        timeout_ms);
}

/* The driver of the desktop that is there, never another: SDL's last resort is to take a display
 * output over. */
static int connect_desktop(const lf_sdl *sdl)
{
    if (is_set("SDL_VIDEODRIVER"))
        return sdl->VideoInit(NULL);
    if (is_set("WAYLAND_DISPLAY") && sdl->VideoInit("wayland") == 0)
        return 0;
    return is_set("DISPLAY") ? sdl->VideoInit("x11") : -1;
}

lf_status lf_sdl_begin(const lf_sdl *sdl, int wait_ms, lf_error *err)
{
    static const char *const hints[][2] = {
        {SDL_HINT_NO_SIGNAL_HANDLERS, "1"},
        {SDL_HINT_VIDEO_MINIMIZE_ON_FOCUS_LOSS, "0"},
        {SDL_HINT_RENDER_SCALE_QUALITY, "nearest"},
    };
    if (!lf_sdl_has_desktop())
        return lf_error_set(err, LF_E_NODEV, "window",
                            "no desktop was found (WAYLAND_DISPLAY and DISPLAY are not set); start "
                            "quiltd in a desktop session, or use --device drm");
    if (!take_turn(wait_ms))
        return lf_error_set(err, LF_E_BUSY, "window",
                            "this program already has a window, or is waiting for the desktop");
    for (size_t i = 0; i < sizeof hints / sizeof *hints; i++)
        sdl->SetHint(hints[i][0], hints[i][1]);
    if (connect_desktop(sdl) == 0)
        return LF_OK;
    lf_status status = lf_error_set(err, LF_E_NODEV, "window",
                                    "cannot connect to the desktop: %.200s", sdl->GetError());
    sdl->TLSCleanup();
    end_turn();
    return status;
}

void lf_sdl_end(const lf_sdl *sdl)
{
    sdl->VideoQuit();
    sdl->TLSCleanup(); /* the thread is none of SDL's making */
    end_turn();
}

/* ---------------------------------------------------------------------------------- monitors -- */

int lf_sdl_monitors(const lf_sdl *sdl, lf_sdl_monitor out[LF_SDL_MONITORS])
{
    int n = sdl->GetNumVideoDisplays();
    if (n > LF_SDL_MONITORS)
        n = LF_SDL_MONITORS;
    for (int i = 0; i < n; i++) {
        SDL_DisplayMode mode = {0};
        const char *name = sdl->GetDisplayName(i);
        out[i] = (lf_sdl_monitor){0};
        lf_device_text(out[i].name, sizeof out[i].name, name ? name : "");
        if (sdl->GetDesktopDisplayMode(i, &mode) == 0) {
            out[i].width_px = mode.w;
            out[i].height_px = mode.h;
        }
    }
    return n > 0 ? n : 0;
}

/* A question, which belongs to who asks and to the thread that finds out; the last of the two frees
 * it. */
typedef struct question {
    lf_sdl sdl;
    int wait_ms;
    pthread_mutex_t lock;
    pthread_cond_t answered;
    /* under lock */
    bool done, left;
    lf_status status;
    lf_error err;
    int n;
    lf_sdl_monitor monitors[LF_SDL_MONITORS];
} question;

static void free_question(question *q)
{
    pthread_cond_destroy(&q->answered);
    pthread_mutex_destroy(&q->lock);
    lf_free(q);
}

static void *find_out(void *context)
{
    question *q = context;
    lf_sdl_monitor monitors[LF_SDL_MONITORS];
    lf_error err = {0};
    int n = 0;
    lf_status status = lf_sdl_begin(&q->sdl, q->wait_ms, &err);
    if (status == LF_OK) {
        n = lf_sdl_monitors(&q->sdl, monitors);
        lf_sdl_end(&q->sdl);
    }
    pthread_mutex_lock(&q->lock);
    q->done = true;
    q->status = status;
    q->err = err;
    q->n = n;
    memcpy(q->monitors, monitors, (size_t)n * sizeof *monitors);
    bool left = q->left;
    pthread_cond_signal(&q->answered);
    pthread_mutex_unlock(&q->lock);
    if (left)
        free_question(q);
    return NULL;
}

/* NULL = out of memory. Nobody joins the thread: it may never end. */
static question *make_question(const lf_sdl *sdl, int wait_ms)
{
    pthread_t thread;
    question *q = lf_calloc(1, sizeof *q);
    if (!q || lf_cond_init(&q->answered) != LF_OK) {
        lf_free(q);
        return NULL;
    }
    pthread_mutex_init(&q->lock, NULL);
    q->sdl = *sdl;
    q->wait_ms = wait_ms;
    if (lf_thread_start("lf-desktop", find_out, q, &thread) != LF_OK) {
        free_question(q);
        return NULL;
    }
    pthread_detach(thread);
    return q;
}

lf_status lf_sdl_ask_monitors(const lf_sdl *sdl, int wait_ms, int timeout_ms,
                              lf_sdl_monitor out[LF_SDL_MONITORS], int *out_n, lf_error *err)
{
    uint64_t end = in_ms(timeout_ms);
    bool in_time = true;
    question *q = make_question(sdl, wait_ms);
    if (!q)
        return lf_error_set(err, LF_E_NOMEM, "window",
                            "out of memory, or no thread can be started");
    pthread_mutex_lock(&q->lock);
    while (!q->done && in_time)
        in_time = lf_cond_wait_until(&q->answered, &q->lock, end);
    bool done = q->done;
    q->left = !done;
    pthread_mutex_unlock(&q->lock);
    if (!done)
        return lf_sdl_no_answer(timeout_ms, err);
    lf_status status = q->status;
    if (status == LF_OK) {
        memcpy(out, q->monitors, (size_t)q->n * sizeof *out);
        *out_n = q->n;
    } else if (err) {
        *err = q->err;
    }
    free_question(q);
    return status;
}
