/* SDL2, loaded on demand: machines without a desktop need none of its libraries. Private to device/
 * and its tests.
 *
 * SDL's video subsystem is global and belongs to one thread at a time: lf_sdl_begin takes it for
 * the calling thread until lf_sdl_end. A desktop that hangs blocks every call, with no way to end
 * them early. Only threads that can be abandoned may call it. */
#ifndef LF_DEVICE_SDL_H
#define LF_DEVICE_SDL_H

#include <SDL2/SDL.h>

#include "device/device.h"

/* The functions used, with names and types of SDL's headers. */
#define LF_SDL_FUNCTIONS(X)                                                                        \
    X(SetHint)                                                                                     \
    X(VideoInit)                                                                                   \
    X(VideoQuit)                                                                                   \
    X(TLSCleanup)                                                                                  \
    X(GetError)                                                                                    \
    X(GetNumVideoDisplays)                                                                         \
    X(GetDisplayName)                                                                              \
    X(GetDisplayBounds)                                                                            \
    X(GetDesktopDisplayMode)                                                                       \
    X(CreateWindow)                                                                                \
    X(DestroyWindow)                                                                               \
    X(GetWindowDisplayIndex)                                                                       \
    X(ShowCursor)                                                                                  \
    X(PollEvent)                                                                                   \
    X(CreateRenderer)                                                                              \
    X(DestroyRenderer)                                                                             \
    X(GetRendererOutputSize)                                                                       \
    X(CreateTexture)                                                                               \
    X(DestroyTexture)                                                                              \
    X(SetTextureBlendMode)                                                                         \
    X(LockTexture)                                                                                 \
    X(UnlockTexture)                                                                               \
    X(RenderClear)                                                                                 \
    X(RenderCopy)                                                                                  \
    X(RenderPresent)

typedef struct lf_sdl {
#define X(name) __typeof__(SDL_##name) *name;
    LF_SDL_FUNCTIONS(X)
#undef X
} lf_sdl;

/* True if this process was started in a desktop (WAYLAND_DISPLAY, DISPLAY; or SDL_VIDEODRIVER names
 * a driver). Without one SDL would take over a display output itself. */
bool lf_sdl_has_desktop(void);
/* Fills *out from a library (NULL = libSDL2-2.0.so.0), which stays loaded. LF_E_NODEV: it is
 * missing; err names the package to install. */
LF_NODISCARD lf_status lf_sdl_load(const char *library, lf_sdl *out, lf_error *err);
/* Connects to the desktop, if no other thread uses SDL or it is released within wait_ms. LF_E_BUSY:
 * still in use; LF_E_NODEV: no desktop. */
LF_NODISCARD lf_status lf_sdl_begin(const lf_sdl *sdl, int wait_ms, lf_error *err);
/* To be called after a successful begin, by the same thread. */
void lf_sdl_end(const lf_sdl *sdl);

/* The error for a desktop that did not answer in time: LF_E_IO. */
LF_NODISCARD lf_status lf_sdl_no_answer(int timeout_ms, lf_error *err);

/* A monitor of the desktop. */
typedef struct lf_sdl_monitor {
    char name[64];           /* sanitised (lf_device_text); empty = none */
    int width_px, height_px; /* of the desktop's mode; 0 = unknown */
} lf_sdl_monitor;

enum { LF_SDL_MONITORS = 16 };

/* To be called between begin and end: fills out in SDL's order and returns the number of
 * monitors. */
int lf_sdl_monitors(const lf_sdl *sdl, lf_sdl_monitor out[LF_SDL_MONITORS]);
/* lf_sdl_monitors outside begin and end, on a thread that is abandoned if the desktop does not
 * answer within timeout_ms. LF_E_BUSY as for begin with wait_ms; LF_E_NODEV: no desktop; LF_E_IO:
 * no answer; LF_E_NOMEM. *out_n is untouched on failure. */
LF_NODISCARD lf_status lf_sdl_ask_monitors(const lf_sdl *sdl, int wait_ms, int timeout_ms,
                                           lf_sdl_monitor out[LF_SDL_MONITORS], int *out_n,
                                           lf_error *err);

/* ---------------------------------------------------------------------------------- window.c -- */

/* lf_device_ops.open over this SDL, which is copied; NULL = the one that lf_sdl_load finds. */
LF_NODISCARD lf_status lf_window_open(const lf_sdl *sdl, const char *argument,
                                      const lf_calibration *calibration, lf_device **out_device,
                                      lf_error *err);

#endif
