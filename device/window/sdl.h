/* SDL2, loaded when it is wanted: machines without a desktop need none of its libraries. Private to
 * device/ and its tests.
 *
 * SDL's video part is one for the whole process and belongs to one thread at a time: lf_sdl_begin
 * takes it for the calling thread until lf_sdl_end. A desktop that hangs holds every call up, and
 * nothing ends them early: only threads that can be left behind may talk to it. */
#ifndef LF_DEVICE_SDL_H
#define LF_DEVICE_SDL_H

#include <SDL2/SDL.h>

#include "device/device.h"

/* The functions used, named and typed as in SDL's headers. */
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

/* Whether this process was started within a desktop (WAYLAND_DISPLAY, DISPLAY; or SDL_VIDEODRIVER
 * names a driver): without one SDL would take over a display output by itself. */
bool lf_sdl_has_desktop(void);
/* Fills *out from a library (NULL = libSDL2-2.0.so.0), which stays loaded. LF_E_NODEV: it is not
 * there, with the package to install. */
LF_NODISCARD lf_status lf_sdl_load(const char *library, lf_sdl *out, lf_error *err);
/* Connects to the desktop, when no other thread has SDL, or has given it back within wait_ms.
 * LF_E_BUSY: it has not; LF_E_NODEV: no desktop. */
LF_NODISCARD lf_status lf_sdl_begin(const lf_sdl *sdl, int wait_ms, lf_error *err);
/* After a begin that succeeded, by the same thread. */
void lf_sdl_end(const lf_sdl *sdl);

/* The error for a desktop that is not waited for any more: LF_E_IO. */
LF_NODISCARD lf_status lf_sdl_no_answer(int timeout_ms, lf_error *err);

/* A monitor of the desktop. */
typedef struct lf_sdl_monitor {
    char name[64];           /* sanitised (lf_device_text); empty = it has none */
    int width_px, height_px; /* of the desktop's mode; 0 = unknown */
} lf_sdl_monitor;

enum { LF_SDL_MONITORS = 16 };

/* Between begin and end: fills out, by SDL's numbers, and returns how many there are. */
int lf_sdl_monitors(const lf_sdl *sdl, lf_sdl_monitor out[LF_SDL_MONITORS]);
/* The same from outside, by a thread that is left behind when the desktop has not answered in
 * timeout_ms. LF_E_BUSY as begin with wait_ms; LF_E_NODEV: no desktop; LF_E_IO: it does not answer;
 * LF_E_NOMEM. *out_n is untouched on failure. */
LF_NODISCARD lf_status lf_sdl_ask_monitors(const lf_sdl *sdl, int wait_ms, int timeout_ms,
                                           lf_sdl_monitor out[LF_SDL_MONITORS], int *out_n,
                                           lf_error *err);

/* ---------------------------------------------------------------------------------- window.c -- */

/* lf_device_ops.open over this SDL, of which a copy is kept; NULL = the one that lf_sdl_load finds.
 */
LF_NODISCARD lf_status lf_window_open(const lf_sdl *sdl, const char *argument,
                                      const lf_calibration *calibration, lf_device **out_device,
                                      lf_error *err);

#endif
