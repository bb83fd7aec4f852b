/* The panel as a monitor of a desktop: window (the monitor whose name has LKG, else the one of the
 * calibration's size), window:NAME (the monitor whose name has NAME). A borderless full-screen
 * window by SDL2, of which what has changed is uploaded and which is presented at the display's own
 * pace.
 *
 * All of SDL happens in a thread of the device's own. SDL has no descriptor to wait for the
 * desktop's events with: while nothing is pushed they are looked at ten times a second. */
#include <ctype.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "device/device_table.h"
#include "device/find/find.h"
#include "device/handover.h"
#include "device/pixels.h"
#include "device/window/sdl.h"

/* TURN_MS: for a list that looks at the desktop, and is quick. PROBE_MS, DESKTOP_MS, END_MS: for a
 * desktop that is asked for its monitors, for a window, and to take it back. */
enum {
    LOOK_MS = 100,
    NAME = 128,
    TURN_MS = 1000,
    PROBE_MS = 1000,
    DESKTOP_MS = 4000,
    END_MS = 1000
};

typedef struct window_device {
    lf_handover handover; /* first */

    /* immutable after open; monitor is written by the thread before */
    lf_calibration calibration;
    lf_origin origin;   /* of the calibration */
    char wanted[NAME];  /* the argument */
    char monitor[NAME]; /* its name, sanitised */
    lf_sdl sdl;

    /* the device's thread */
    SDL_Window *window;
    SDL_Renderer *renderer;
    SDL_Texture *texture; /* what the panel shows */
    bool lost;            /* the graphics driver has forgotten it */

    /* under handover.lock, told through handover.ended */
    bool left;     /* nobody waits any more: the device is its thread's to free */
    bool over;     /* the thread has given the desktop back */
    bool answered; /* the window is there, or why not */
    lf_status status;
    lf_error why;
} window_device;

static window_device *window_of(lf_device *device)
{
    return (window_device *)(void *)device;
}

static const window_device *const_window_of(const lf_device *device)
{
    return (const window_device *)(const void *)device;
}

/* ---------------------------------------------------------------------------------- monitors -- */

/* Number of the monitor to show on; -1 = none. By its name, then, unless one was asked for, by its
 * size. */
static int choose_monitor(const window_device *w, const lf_sdl_monitor *monitors, int n)
{
    const char *part = w->wanted[0] != 0 ? w->wanted : "LKG";
    for (int i = 0; i < n; i++)
        if (strstr(monitors[i].name, part))
            return i;
    for (int i = 0; i < n && w->wanted[0] == 0; i++)
        if (monitors[i].width_px > 0 && monitors[i].width_px == w->calibration.screen_width_px &&
            monitors[i].height_px == w->calibration.screen_height_px)
            return i;
    return -1;
}

/* When a monitor goes desktops move its windows to another, which may be a Looking Glass too: with
 * a lens of its own. */
static bool monitor_is_there(const window_device *w)
{
    lf_sdl_monitor monitors[LF_SDL_MONITORS];
    int n = lf_sdl_monitors(&w->sdl, monitors), i = w->sdl.GetWindowDisplayIndex(w->window);
    return i >= 0 && i < n && strcmp(monitors[i].name, w->monitor) == 0;
}

static lf_status no_monitor(const window_device *w, const lf_sdl_monitor *monitors, int n,
                            lf_error *err)
{
    char seen[256] = "";
    const lf_calibration *c = &w->calibration;
    for (int i = 0; i < n; i++) {
        size_t used = strlen(seen);
        snprintf(seen + used, sizeof seen - used, "%s%.60s %dx%d", used > 0 ? ", " : "",
                 monitors[i].name, monitors[i].width_px, monitors[i].height_px);
    }
    if (w->wanted[0] != 0)
        return lf_error_set(err, LF_E_NODEV, "window",
                            "no monitor of this desktop has the name %s; found: %s", w->wanted,
                            seen);
    return lf_error_set(
        err, LF_E_NODEV, "window",
        "no monitor of this desktop has the name LKG or the calibration's %dx%d pixels; found: %s",
        c->screen_width_px, c->screen_height_px, seen);
}

/* ----------------------------------------------------------------------- the device's thread -- */

static lf_status sdl_error(const lf_sdl *sdl, const char *what, lf_error *err)
{
    return lf_error_set(err, LF_E_IO, "window", "cannot create %s: %.200s", what, sdl->GetError());
}

static void check_scale(window_device *w)
{
    const lf_calibration *c = &w->calibration;
    int width = 0, height = 0;
    char text[256] = "";
    if (w->sdl.GetRendererOutputSize(w->renderer, &width, &height) != 0)
        return;
    if (width != c->screen_width_px || height != c->screen_height_px)
        snprintf(text, sizeof text,
                 "the window has %dx%d pixels, but the panel %dx%d; set the monitor to native "
                 "mode, 100 %% scale and normal orientation",
                 width, height, c->screen_width_px, c->screen_height_px);
    lf_handover_problem_set(&w->handover, text);
}

static lf_status make_window(window_device *w, lf_error *err)
{
    const lf_sdl *sdl = &w->sdl;
    lf_sdl_monitor monitors[LF_SDL_MONITORS];
    SDL_Rect bounds;
    int n = lf_sdl_monitors(sdl, monitors), i = choose_monitor(w, monitors, n);
    if (i < 0)
        return no_monitor(w, monitors, n, err);
    if (sdl->GetDisplayBounds(i, &bounds) != 0)
        return sdl_error(sdl, "a window", err);
    snprintf(w->monitor, sizeof w->monitor, "%s", monitors[i].name);
    w->window = sdl->CreateWindow("quiltd", bounds.x, bounds.y, bounds.w, bounds.h,
                                  SDL_WINDOW_BORDERLESS | SDL_WINDOW_FULLSCREEN_DESKTOP |
                                      SDL_WINDOW_ALLOW_HIGHDPI);
    if (!w->window)
        return sdl_error(sdl, "a window", err);
    w->renderer = sdl->CreateRenderer(w->window, -1, SDL_RENDERER_PRESENTVSYNC);
    if (!w->renderer)
        w->renderer = sdl->CreateRenderer(w->window, -1, SDL_RENDERER_SOFTWARE);
    if (!w->renderer)
        return sdl_error(sdl, "a renderer", err);
    w->texture =
        sdl->CreateTexture(w->renderer, SDL_PIXELFORMAT_ARGB8888, SDL_TEXTUREACCESS_STREAMING,
                           w->calibration.screen_width_px, w->calibration.screen_height_px);
    if (!w->texture)
        return sdl_error(sdl, "a texture of the panel's size", err);
    sdl->SetTextureBlendMode(w->texture, SDL_BLENDMODE_NONE);
    sdl->ShowCursor(SDL_DISABLE);
    check_scale(w);
    return LF_OK;
}

static void end_window(window_device *w)
{
    if (w->texture)
        w->sdl.DestroyTexture(w->texture);
    if (w->renderer)
        w->sdl.DestroyRenderer(w->renderer);
    if (w->window)
        w->sdl.DestroyWindow(w->window);
    w->texture = NULL;
    w->renderer = NULL;
    w->window = NULL;
}

static bool upload(window_device *w, const lf_rect *r)
{
    const lf_image8 *picture = &w->handover.picture;
    const SDL_Rect rect = {r->x, r->y, r->width, r->height};
    void *to;
    int pitch;
    if (w->sdl.LockTexture(w->texture, &rect, &to, &pitch) != 0)
        return false;
    for (int y = 0; y < r->height; y++)
        lf_pixels_xrgb8888((uint8_t *)to + (size_t)y * (size_t)pitch,
                           picture->data + (size_t)(r->y + y) * picture->stride + (size_t)r->x * 3,
                           r->width);
    w->sdl.UnlockTexture(w->texture);
    return true;
}

/* Pixel for pixel from the top left corner, whatever size the window has. */
static bool present(window_device *w)
{
    const SDL_Rect to = {0, 0, w->calibration.screen_width_px, w->calibration.screen_height_px};
    if (w->sdl.RenderClear(w->renderer) != 0 ||
        w->sdl.RenderCopy(w->renderer, w->texture, NULL, &to) != 0)
        return false;
    w->sdl.RenderPresent(w->renderer);
    return true;
}

static void show_push(window_device *w)
{
    lf_handover *h = &w->handover;
    uint64_t bytes = 0;
    bool good = true;
    for (int i = 0; i < h->n_rects && good; i++) {
        good = upload(w, &h->rects[i]);
        bytes += (uint64_t)h->rects[i].width * (uint64_t)h->rects[i].height * 4;
    }
    if (h->n_rects > 0)
        good = good && present(w);
    if (w->lost) { /* these rectangles are not all that is missing */
        w->lost = false;
        lf_handover_end(h, false, 0);
        return;
    }
    if (!good) {
        char text[256];
        snprintf(text, sizeof text, "the window does not accept images: %.180s", w->sdl.GetError());
        lf_handover_problem_set(h, text);
    }
    lf_handover_end(h, good, bytes);
}

/* False when the monitor is gone. */
static bool read_events(window_device *w)
{
    SDL_Event event;
    bool exposed = false, there = true;
    while (w->sdl.PollEvent(&event) != 0)
        if (event.type == SDL_DISPLAYEVENT)
            there = monitor_is_there(w);
        else if (event.type == SDL_RENDER_TARGETS_RESET || event.type == SDL_RENDER_DEVICE_RESET)
            w->lost = true;
        else if (event.type == SDL_WINDOWEVENT)
            exposed = true;
    if (w->lost)
        w->lost = !lf_handover_lost(&w->handover);
    else if (exposed)
        present(w);
    if (exposed)
        check_scale(w);
    return there;
}

/* Lets open go on; false when that has not waited for it. */
static bool answer(window_device *w, lf_status status, const lf_error *why)
{
    pthread_mutex_lock(&w->handover.lock);
    w->answered = true;
    w->status = status;
    w->why = *why;
    bool wanted = !w->left;
    pthread_cond_broadcast(&w->handover.ended);
    pthread_mutex_unlock(&w->handover.lock);
    return wanted;
}

/* Lets destroy go on; false when nobody has waited for it. */
static bool tell_over(window_device *w)
{
    pthread_mutex_lock(&w->handover.lock);
    w->over = true;
    bool wanted = !w->left;
    pthread_cond_broadcast(&w->handover.ended);
    pthread_mutex_unlock(&w->handover.lock);
    return wanted;
}

static void run(window_device *w)
{
    for (;;) {
        struct pollfd p = {.fd = w->handover.wake_fd, .events = POLLIN};
        poll(&p, 1, LOOK_MS);
        if (!read_events(w)) {
            lf_handover_gone(&w->handover);
            return;
        }
        lf_handover_word word = lf_handover_take(&w->handover);
        if (word == LF_HANDOVER_STOP)
            return;
        if (word == LF_HANDOVER_PUSH)
            show_push(w);
    }
}

static void *thread_main(void *argument)
{
    window_device *w = argument;
    lf_error err = {0};
    lf_status status = lf_sdl_begin(&w->sdl, TURN_MS, &err);
    bool begun = status == LF_OK;
    if (begun)
        status = make_window(w, &err);
    if (answer(w, status, &err) && status == LF_OK)
        run(w);
    if (begun) {
        end_window(w);
        lf_sdl_end(&w->sdl);
    }
    if (!tell_over(w)) {
        lf_handover_finish(&w->handover);
        lf_free(w);
    }
    return NULL;
}

/* -------------------------------------------------------------------------------------- open -- */

static lf_edid edid_of(const lf_sdl_monitor *monitor)
{
    lf_edid edid = {.width_px = monitor->width_px, .height_px = monitor->height_px};
    lf_device_text(edid.name, sizeof edid.name, monitor->name);
    return edid;
}

/* What the desktop says of the monitor that its name stands for; zeroed when there is none. */
static lf_status ask_desktop(const window_device *w, lf_edid *out, lf_error *err)
{
    lf_sdl_monitor monitors[LF_SDL_MONITORS];
    int n = 0;
    lf_status status = lf_sdl_ask_monitors(&w->sdl, TURN_MS, DESKTOP_MS, monitors, &n, err);
    if (status != LF_OK)
        return status;
    int i = choose_monitor(w, monitors, n);
    *out = (lf_edid){0};
    if (i >= 0)
        *out = edid_of(&monitors[i]);
    return LF_OK;
}

/* Before the window is there: its size is the lens's. */
static lf_status find_calibration(window_device *w, const lf_calibration *given, lf_error *err)
{
    lf_edid display;
    if (!given) {
        lf_status status = ask_desktop(w, &display, err);
        return status == LF_OK ? lf_find_for_display(&display, &w->calibration, &w->origin, err)
                               : status;
    }
    w->calibration = *given;
    w->origin = (lf_origin){.words = "given by the caller"};
    return LF_OK;
}

static lf_status take_argument(window_device *w, const char *argument, lf_error *err)
{
    size_t n = strlen(argument);
    bool good = n < sizeof w->wanted;
    for (size_t i = 0; i < n && good; i++)
        good = !iscntrl((unsigned char)argument[i]);
    if (!good)
        return lf_error_set(
            err, LF_E_ARG, "window",
            "\"%.60s\" is not the name of a monitor; expected window or window:NAME", argument);
    memcpy(w->wanted, argument, n);
    return LF_OK;
}

static lf_status take_sdl(window_device *w, const lf_sdl *given, lf_error *err)
{
    if (!given)
        return lf_sdl_load(NULL, &w->sdl, err);
    w->sdl = *given;
    return LF_OK;
}

/* Until the thread has set *word. False: the desktop does not answer, and w now belongs to its
 * thread, which nobody joins. */
static bool wait_for_thread(window_device *w, const bool *word, int timeout_ms)
{
    pthread_t thread = w->handover.thread;
    uint64_t end = lf_time_now_ns() + (uint64_t)timeout_ms * LF_NS_PER_MS;
    bool in_time = true;
    pthread_mutex_lock(&w->handover.lock);
    while (!*word && in_time)
        in_time = lf_cond_wait_until(&w->handover.ended, &w->handover.lock, end);
    bool said = *word;
    w->left = !said;
    pthread_mutex_unlock(&w->handover.lock);
    if (!said)
        pthread_detach(thread);
    return said;
}

/* *out_left: w now belongs to its thread. */
static lf_status wait_for_window(window_device *w, bool *out_left, lf_error *err)
{
    *out_left = !wait_for_thread(w, &w->answered, DESKTOP_MS);
    if (*out_left)
        return lf_sdl_no_answer(DESKTOP_MS, err);
    if (w->status != LF_OK && err)
        *err = w->why;
    return w->status;
}

lf_status lf_window_open(const lf_sdl *sdl, const char *argument, const lf_calibration *calibration,
                         lf_device **out_device, lf_error *err)
{
    window_device *w = lf_calloc(1, sizeof *w);
    if (!w)
        return lf_error_set(err, LF_E_NOMEM, "window", "out of memory");
    w->handover.base.ops = &lf_window_ops;
    bool left = false;
    lf_status status = take_argument(w, argument, err);
    if (status == LF_OK)
        status = take_sdl(w, sdl, err);
    if (status == LF_OK)
        status = find_calibration(w, calibration, err);
    if (status == LF_OK)
        status = lf_handover_init(&w->handover, w->calibration.screen_width_px,
                                  w->calibration.screen_height_px, err);
    if (status == LF_OK)
        status = lf_handover_start(&w->handover, thread_main, w, "lf-window", err);
    if (status == LF_OK)
        status = wait_for_window(w, &left, err);
    if (status == LF_OK)
        *out_device = &w->handover.base;
    else if (!left)
        lf_device_destroy(&w->handover.base);
    return status;
}

static lf_status window_open(const char *argument, const lf_calibration *calibration,
                             lf_device **out_device, lf_error *err)
{
    return lf_window_open(NULL, argument, calibration, out_device, err);
}

/* Monitors that say that they are a Looking Glass; nothing else may "auto" open a window on. */
static int window_probe(lf_device_info *out, int max)
{
    lf_sdl sdl;
    lf_sdl_monitor monitors[LF_SDL_MONITORS];
    int n = 0, n_monitors = 0;
    if (!lf_sdl_has_desktop() || lf_sdl_load(NULL, &sdl, NULL) != LF_OK ||
        lf_sdl_ask_monitors(&sdl, 0, PROBE_MS, monitors, &n_monitors, NULL) != LF_OK)
        return 0;
    for (int i = 0; i < n_monitors && n < max; i++) {
        if (!strstr(monitors[i].name, "LKG"))
            continue;
        lf_device_info *info = &out[n++];
        *info = (lf_device_info){.kind = "window"};
        memcpy(info->model, monitors[i].name, sizeof info->model);
        snprintf(info->spec, sizeof info->spec, "window:%s", info->model);
        if (monitors[i].width_px > 0)
            snprintf(info->output, sizeof info->output, "desktop, %dx%d", monitors[i].width_px,
                     monitors[i].height_px);
        const lf_edid display = edid_of(&monitors[i]);
        if (!lf_find_promise(&display, info->calibration_from))
            snprintf(info->problem, sizeof info->problem,
                     "no calibration was found; connect the panel's USB cable (not only video), or "
                     "pass its visual.json with --calibration");
    }
    return n;
}

/* ----------------------------------------------------------------------------- the other ops -- */

static void window_destroy(lf_device *device)
{
    window_device *w = window_of(device);
    if (w->handover.has_thread) {
        lf_handover_ask_stop(&w->handover);
        if (!wait_for_thread(w, &w->over, END_MS))
            return;
        pthread_join(w->handover.thread, NULL);
    }
    lf_handover_finish(&w->handover);
    lf_free(w);
}

static void window_info(const lf_device *device, lf_device_info *out)
{
    const window_device *w = const_window_of(device);
    *out = (lf_device_info){.kind = "window"};
    lf_device_text(out->model, sizeof out->model, w->monitor);
    char spec[sizeof w->wanted + 8];
    snprintf(spec, sizeof spec, "window%s%s", w->wanted[0] != 0 ? ":" : "", w->wanted);
    lf_device_text(out->spec, sizeof out->spec, spec);
    lf_device_text(out->serial, sizeof out->serial, w->calibration.serial);
    lf_device_text(out->calibration_from, sizeof out->calibration_from, w->origin.words);
    out->calibration_cached = w->origin.cached;
    snprintf(out->output, sizeof out->output, "desktop, %dx%d", w->calibration.screen_width_px,
             w->calibration.screen_height_px);
    lf_handover_problem(&w->handover, out->problem);
}

static const lf_calibration *window_calibration(const lf_device *device)
{
    return &const_window_of(device)->calibration;
}

const lf_device_ops lf_window_ops = {
    .kind = "window",
    .is_panel = true,
    .is_hardware = true,
    .probe = window_probe,
    .open = window_open,
    .destroy = window_destroy,
    .info = window_info,
    .calibration = window_calibration,
    .push = lf_handover_push,
    .poll_fd = lf_handover_poll_fd,
    .dispatch = lf_handover_dispatch,
    .counters = lf_handover_counters,
    .flush = lf_handover_flush,
};
