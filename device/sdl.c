#include "device/sdl.h"

#include <dlfcn.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static atomic_flag in_use = ATOMIC_FLAG_INIT;

static bool is_set(const char *variable)
{
    const char *value = getenv(variable);
    return value != NULL && value[0] != 0;
}

bool lf_sdl_has_desktop(void)
{
    return is_set("WAYLAND_DISPLAY") || is_set("DISPLAY") || is_set("SDL_VIDEODRIVER");
}

lf_status lf_sdl_load(const char *library, lf_sdl *out, lf_error *err)
{
    lf_sdl sdl;
    const char *missing = NULL;
    void *handle = dlopen(library != NULL ? library : "libSDL2-2.0.so.0", RTLD_NOW | RTLD_LOCAL);
    if (handle == NULL)
        return lf_error_set(err, LF_E_NODEV, "window", "SDL2 is not installed: apt-get install libsdl2-2.0-0");
        /* C has no conversion from an object's address to a function's; POSIX promises this one. */
#define X(name)                                                                                                                    \
    do {                                                                                                                           \
        void *address = dlsym(handle, "SDL_" #name);                                                                               \
        memcpy(&sdl.name, &address, sizeof address);                                                                               \
        if (address == NULL)                                                                                                       \
            missing = #name;                                                                                                       \
    } while (0);
    LF_SDL_FUNCTIONS(X)
#undef X
    if (missing != NULL)
        return lf_error_set(err, LF_E_NODEV, "window",
                            "this SDL has no SDL_%s; 2.0.16 or later is wanted: apt-get install libsdl2-2.0-0", missing);
    *out = sdl;
    return LF_OK;
}

/* The driver of the desktop that is there, never another: SDL's last resort is to take a display output over. */
static int connect_desktop(const lf_sdl *sdl)
{
    if (is_set("SDL_VIDEODRIVER"))
        return sdl->VideoInit(NULL);
    if (is_set("WAYLAND_DISPLAY") && sdl->VideoInit("wayland") == 0)
        return 0;
    return is_set("DISPLAY") ? sdl->VideoInit("x11") : -1;
}

lf_status lf_sdl_begin(const lf_sdl *sdl, lf_error *err)
{
    static const char *const hints[][2] = {
        {SDL_HINT_NO_SIGNAL_HANDLERS, "1"},
        {SDL_HINT_VIDEO_MINIMIZE_ON_FOCUS_LOSS, "0"},
        {SDL_HINT_RENDER_SCALE_QUALITY, "nearest"},
    };
    if (!lf_sdl_has_desktop())
        return lf_error_set(
            err, LF_E_NODEV, "window",
            "no desktop: neither WAYLAND_DISPLAY nor DISPLAY is set; start quiltd within one, or take --device drm");
    if (atomic_flag_test_and_set(&in_use))
        return lf_error_set(err, LF_E_BUSY, "window", "this program has a window already");
    for (size_t i = 0; i < sizeof hints / sizeof *hints; i++)
        sdl->SetHint(hints[i][0], hints[i][1]);
    if (connect_desktop(sdl) == 0)
        return LF_OK;
    lf_status status = lf_error_set(err, LF_E_NODEV, "window", "the desktop cannot be reached: %.200s", sdl->GetError());
    sdl->TLSCleanup();
    atomic_flag_clear(&in_use);
    return status;
}

void lf_sdl_end(const lf_sdl *sdl)
{
    sdl->VideoQuit();
    sdl->TLSCleanup(); /* the thread is none of SDL's making */
    atomic_flag_clear(&in_use);
}
