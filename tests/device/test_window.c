/* The window device over SDL's dummy driver, which saves every picture that it shows, and over an X
 * server without a screen. */
#include "tests/device/device_testing.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>

#include "base/image_io.h"
#include "device/device_table.h"
#include "device/window/sdl.h"

enum { WIDTH = 1024, HEIGHT = 768 /* the dummy's only mode */ };

static bool has_sdl(void)
{
    lf_sdl sdl;
    if (lf_sdl_load(NULL, &sdl, NULL) == LF_OK)
        return true;
    print_message("absent: libSDL2-2.0.so.0\n");
    return false;
}

static lf_status try_open(const char *spec, int width, int height, lf_device **out, lf_error *err)
{
    lf_calibration c = device_lens(width, height);
    return lf_device_open(spec, &c, out, err);
}

/* Opens when SDL is free: whoever was left behind has it until its desktop answers. */
static lf_device *open_when_it_is_free(int width, int height)
{
    lf_device *device = NULL;
    lf_error err = {0};
    lf_status status = LF_E_BUSY;
    for (int i = 0; i < 100 && status == LF_E_BUSY; i++)
        status = try_open("window", width, height, &device, &err);
    lf_assert_ok(status, &err);
    return device;
}

static const lf_rect whole = {0, 0, WIDTH, HEIGHT};

static void scribble(lf_image8 *frame, const lf_rect *r, int seed)
{
    for (int y = r->y; y < r->y + r->height; y++)
        for (int i = r->x * 3; i < (r->x + r->width) * 3; i++)
            frame->data[(size_t)y * frame->stride + (size_t)i] =
                (uint8_t)(seed * 37 + y * 5 + i * 3);
}

static uint32_t le32(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* Name of the last picture that was saved, by SDL's pattern SDL_windowID-NUMBER.bmp; false = none.
 */
static bool last_picture(char *out, size_t size)
{
    for (int id = 20; id > 0; id--)
        for (int number = 40; number >= 0; number--) {
            snprintf(out, size, "SDL_window%d-%08d.bmp", id, number);
            if (access(out, R_OK) == 0)
                return true;
        }
    return false;
}

/* Whether the last picture saved is the frame: a BMP of 24 or 32 bits, the last row first. */
static bool shows(const lf_image8 *frame)
{
    char name[64];
    static uint8_t bmp[4 * WIDTH * HEIGHT + 1024];
    if (!last_picture(name, sizeof name))
        return false;
    FILE *file = fopen(name, "rb");
    size_t n = file ? fread(bmp, 1, sizeof bmp, file) : 0;
    if (file)
        fclose(file);
    size_t bytes = bmp[28] / 8u, pitch = (WIDTH * bytes + 3) / 4 * 4, start = le32(bmp + 10);
    if (n < 54 || le32(bmp + 18) != WIDTH || le32(bmp + 22) != HEIGHT || bytes < 3 ||
        start + pitch * HEIGHT > n)
        return false;
    for (size_t y = 0; y < HEIGHT; y++)
        for (size_t x = 0; x < WIDTH; x++) {
            const uint8_t *bgr = bmp + start + (HEIGHT - 1 - y) * pitch + x * bytes,
                          *rgb = frame->data + y * frame->stride + x * 3;
            if (bgr[0] != rgb[2] || bgr[1] != rgb[1] || bgr[2] != rgb[0])
                return false;
        }
    return true;
}

static void forget_pictures(void)
{
    char name[64];
    while (last_picture(name, sizeof name))
        assert_int_equal(remove(name), 0);
}

static void rectangles_make_the_frame(void **state)
{
    (void)state;
    lf_device *device = NULL;
    lf_error err = {0};
    lf_image8 frame = {0};
    lf_device_info info;
    lf_device_counters counters;
    if (!has_sdl())
        skip();
    lf_assert_ok(try_open("window", WIDTH, HEIGHT, &device, &err), &err);
    lf_assert_ok(lf_image8_init(&frame, WIDTH, HEIGHT, 3), NULL);
    device->ops->info(device, &info);
    assert_string_equal(info.spec, "window");
    assert_string_equal(info.problem, "");
    scribble(&frame, &whole, 1);
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    assert_true(shows(&frame));
    for (int i = 2; i < 8; i++) {
        lf_rect rects[5];
        for (int k = 0; k < 5; k++) {
            rects[k] = (lf_rect){(i * 211 + k * 97) % WIDTH, (i * 89 + k * 131) % HEIGHT, 1, 1};
            rects[k].width = 1 + (i * 31 + k) % (WIDTH - rects[k].x);
            rects[k].height = 1 + (i * 17 + k) % (HEIGHT - rects[k].y);
            scribble(&frame, &rects[k], i);
        }
        assert_int_equal(device_push(device, &frame, rects, i == 5 ? 0 : 5), LF_DEVICE_READY);
        if (i == 5) /* nothing was told, so nothing has changed */
            for (int k = 0; k < 5; k++)
                assert_int_equal(device_push(device, &frame, &rects[k], 1), LF_DEVICE_READY);
        assert_true(shows(&frame));
        forget_pictures();
    }
    frame.data[5] ^= 1;
    assert_int_equal(device_push(device, &frame, &(lf_rect){0, 1, 1, 1}, 1), LF_DEVICE_READY);
    assert_false(shows(&frame));
    device->ops->counters(device, &counters);
    assert_int_equal(counters.updates, 1 + 30 + 1);
    assert_int_equal(counters.errors, 0);
    lf_device_destroy(device);
    lf_image8_finish(&frame);
    forget_pictures();
}

/* Puts an event into SDL's own queue. */
static void tell(SDL_Event event)
{
    __typeof__(SDL_PushEvent) *push_event;
    void *library = dlopen("libSDL2-2.0.so.0", RTLD_NOW),
         *address = dlsym(library, "SDL_PushEvent");
    memcpy(&push_event, &address, sizeof address);
    assert_int_equal(push_event(&event), 1);
    dlclose(library);
}

/* What a graphics driver that was reset tells. */
static void lost_picture_is_asked_for_again(void **state)
{
    (void)state;
    lf_device *device = NULL;
    lf_error err = {0};
    lf_image8 frame = {0};
    if (!has_sdl())
        skip();
    lf_assert_ok(try_open("window", WIDTH, HEIGHT, &device, &err), &err);
    lf_assert_ok(lf_image8_init(&frame, WIDTH, HEIGHT, 3), NULL);
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    tell((SDL_Event){.type = SDL_RENDER_DEVICE_RESET});
    assert_true(device_rings(device, DEVICE_WAIT_MS));
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_RETRY);
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_READY);
    scribble(&frame, &whole, 4);
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    assert_true(shows(&frame));
    lf_device_destroy(device);
    lf_image8_finish(&frame);
    forget_pictures();
}

/* --------------------------------------------------------------- a desktop of the test's own -- */

/* Monitors side by side, by name; the window is on the first of them, wherever the desktop has
 * moved it from. */
static struct desk {
    pthread_mutex_t lock;
    int n;
    const char *names[2];
} desk = {.lock = PTHREAD_MUTEX_INITIALIZER};

static void set_desk(int n, const char *first, const char *second)
{
    pthread_mutex_lock(&desk.lock);
    desk.n = n;
    desk.names[0] = first;
    desk.names[1] = second;
    pthread_mutex_unlock(&desk.lock);
}

static int desk_count(void)
{
    pthread_mutex_lock(&desk.lock);
    int n = desk.n;
    pthread_mutex_unlock(&desk.lock);
    return n;
}

static const char *desk_name(int i)
{
    pthread_mutex_lock(&desk.lock);
    const char *name = desk.names[i];
    pthread_mutex_unlock(&desk.lock);
    return name;
}

static int desk_mode(int i, SDL_DisplayMode *out)
{
    (void)i;
    *out = (SDL_DisplayMode){.w = WIDTH, .h = HEIGHT};
    return 0;
}

static int desk_bounds(int i, SDL_Rect *out)
{
    (void)i;
    *out = (SDL_Rect){0, 0, WIDTH, HEIGHT};
    return 0;
}

static int desk_of_window(SDL_Window *window)
{
    (void)window;
    return 0;
}

static void window_that_is_moved_to_another_looking_glass_is_gone(void **state)
{
    (void)state;
    const SDL_Event news = {.type = SDL_DISPLAYEVENT};
    lf_device *device = NULL;
    lf_error err = {0};
    lf_image8 frame = {0};
    lf_calibration c = device_lens(WIDTH, HEIGHT);
    lf_sdl sdl;
    if (!has_sdl())
        skip();
    lf_assert_ok(lf_sdl_load(NULL, &sdl, NULL), NULL);
    sdl.GetNumVideoDisplays = desk_count;
    sdl.GetDisplayName = desk_name;
    sdl.GetDesktopDisplayMode = desk_mode;
    sdl.GetDisplayBounds = desk_bounds;
    sdl.GetWindowDisplayIndex = desk_of_window;
    set_desk(2, "LKG-A", "LKG-B");
    lf_assert_ok(lf_window_open(&sdl, "", &c, &device, &err), &err);
    assert_string_equal(device_info_of(device).model, "LKG-A");
    lf_assert_ok(lf_image8_init(&frame, WIDTH, HEIGHT, 3), NULL);
    set_desk(1, "LKG-A", NULL);
    tell(news);
    for (int i = 0; i < 3; i++)
        assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    set_desk(1, "LKG-B", NULL);
    tell(news);
    assert_int_equal(device_outcome(device), LF_DEVICE_GONE);
    lf_device_destroy(device);
    lf_image8_finish(&frame);
    forget_pictures();
}

/* ------------------------------------------------------------------------------- an X server -- */

enum { X_WIDTH = 480, X_HEIGHT = 640 };

typedef struct libraries {
    const char *names[256];
    int n;
} libraries;

static int add_library(struct dl_phdr_info *info, size_t size, void *context)
{
    libraries *all = context;
    (void)size;
    if (all->n < (int)(sizeof all->names / sizeof all->names[0]))
        all->names[all->n++] = info->dlpi_name;
    return 0;
}

/* Graphics drivers are unloaded with the window. What one keeps until the process ends would then
 * look lost to a sanitizer, with no name to know it by (tests/lsan.supp): all that are there stay.
 */
static void keep_libraries(void)
{
    libraries all = {.n = 0};
    dl_iterate_phdr(add_library, &all);
    for (int i = 0; i < all.n; i++)
        /* cppcheck-suppress leakReturnValNotUsed */
        (void)dlopen(all.names[i], RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE);
}

/* Starts Xvfb, whose screen is the file Xvfb_screen0 here, and points DISPLAY at it. Returns its
 * process, -1 = there is none. */
static pid_t start_server(void)
{
    int ready[2];
    char number[16] = "", mode[32], display[20];
    assert_int_equal(pipe(ready), 0);
    snprintf(mode, sizeof mode, "%dx%dx24", X_WIDTH, X_HEIGHT);
    pid_t server = fork();
    assert_true(server >= 0);
    if (server == 0) {
        int nowhere = open("/dev/null", O_RDWR);
        dup2(nowhere, STDOUT_FILENO);
        dup2(nowhere, STDERR_FILENO);
        dup2(ready[1], STDIN_FILENO);
        execlp("Xvfb", "Xvfb", "-displayfd", "0", "-screen", "0", mode, "-fbdir", ".", "-nolisten",
               "tcp", "-noreset", NULL);
        _exit(127);
    }
    close(ready[1]);
    ssize_t n = read(ready[0], number, sizeof number - 1);
    close(ready[0]);
    if (n > 0) {
        snprintf(display, sizeof display, ":%.*s", (int)strcspn(number, "\n"), number);
        setenv("DISPLAY", display, 1);
        return server;
    }
    waitpid(server, NULL, 0);
    return -1;
}

static uint32_t be32(const uint8_t *b)
{
    return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | (uint32_t)b[3];
}

/* The screen is a window dump: 25 numbers, a name, colours of 12 bytes, rows. */
static bool screen_shows(const lf_image8 *frame)
{
    static uint8_t dump[4 * X_WIDTH * X_HEIGHT + 16384];
    FILE *file = fopen("Xvfb_screen0", "rb");
    size_t n = file ? fread(dump, 1, sizeof dump, file) : 0;
    if (file)
        fclose(file);
    size_t start = be32(dump) + 12 * (size_t)be32(dump + 76), pitch = be32(dump + 48);
    if (n < 100 || be32(dump + 44) != 32 || start > n || pitch < 4 * X_WIDTH ||
        pitch * X_HEIGHT > n - start)
        return false;
    for (size_t y = 0; y < X_HEIGHT; y++)
        for (size_t x = 0; x < X_WIDTH; x++) {
            const uint8_t *bgr = dump + start + y * pitch + x * 4,
                          *rgb = frame->data + y * frame->stride + x * 3;
            if (bgr[0] != rgb[2] || bgr[1] != rgb[1] || bgr[2] != rgb[0])
                return false;
        }
    return true;
}

/* The server shows a little later than it is told. */
static bool screen_comes_to_show(const lf_image8 *frame)
{
    bool shown = screen_shows(frame);
    for (int i = 0; i < DEVICE_WAIT_MS / 20 && !shown; i++) {
        usleep(20000);
        shown = screen_shows(frame);
    }
    return shown;
}

static void screen_shows_the_frame_pixel_for_pixel(void **state)
{
    (void)state;
    const lf_rect all = {0, 0, X_WIDTH, X_HEIGHT}, part = {100, 333, 77, 55};
    lf_device *device = NULL;
    lf_device_info info;
    lf_error err = {0};
    lf_image8 frame = {0};
    pid_t server = has_sdl() ? start_server() : -1;
    if (server < 0) {
        print_message("absent: Xvfb\n");
        skip();
    }
    unsetenv("SDL_VIDEODRIVER");
    lf_assert_ok(try_open("window", X_WIDTH, X_HEIGHT, &device, &err), &err);
    keep_libraries();
    lf_assert_ok(lf_image8_init(&frame, X_WIDTH, X_HEIGHT, 3), NULL);
    scribble(&frame, &all, 1);
    assert_int_equal(device_push(device, &frame, &all, 1), LF_DEVICE_READY);
    assert_true(screen_comes_to_show(&frame));
    scribble(&frame, &part, 9);
    assert_false(screen_shows(&frame));
    assert_int_equal(device_push(device, &frame, &part, 1), LF_DEVICE_READY);
    assert_true(screen_comes_to_show(&frame));
    device->ops->info(device, &info);
    assert_string_equal(info.problem, "");
    lf_device_destroy(device);
    lf_image8_finish(&frame);
    assert_int_equal(lf_window_ops.probe(&info, 1), 0);
    kill(server, SIGTERM);
    waitpid(server, NULL, 0);
    unsetenv("DISPLAY");
    setenv("SDL_VIDEODRIVER", "dummy", 1);
}

/* Lets a stopped process go on when whoever waits for it has waited longer than any machine takes;
 * returns the process that does. */
static pid_t start_rescue(pid_t server)
{
    pid_t rescue = fork();
    assert_true(rescue >= 0);
    if (rescue == 0) {
        sleep(DEVICE_WAIT_MS / 1000);
        kill(server, SIGCONT);
        _exit(0);
    }
    return rescue;
}

static void window_of_a_desktop_that_hangs_is_left_behind(void **state)
{
    (void)state;
    const lf_rect all = {0, 0, X_WIDTH, X_HEIGHT};
    pid_t server = has_sdl() ? start_server() : -1;
    if (server < 0) {
        print_message("absent: Xvfb\n");
        skip();
    }
    unsetenv("SDL_VIDEODRIVER");
    /* the threads of graphics drivers are nothing that a sanitizer can follow */
    setenv("SDL_RENDER_DRIVER", "software", 1);
    for (int pushing = 0; pushing < 2; pushing++) {
        lf_device *device = NULL;
        lf_error err = {0};
        lf_image8 frame = {0};
        int ended;
        lf_assert_ok(try_open("window", X_WIDTH, X_HEIGHT, &device, &err), &err);
        keep_libraries();
        lf_assert_ok(lf_image8_init(&frame, X_WIDTH, X_HEIGHT, 3), NULL);
        assert_int_equal(device_push(device, &frame, &all, 1), LF_DEVICE_READY);
        assert_int_equal(kill(server, SIGSTOP), 0);
        assert_int_equal(waitpid(server, &ended, WUNTRACED), server);
        pid_t rescue = start_rescue(server);
        if (pushing != 0)
            lf_assert_ok(device->ops->push(device, &frame, &all, 1, 2), NULL);
        lf_device_destroy(device);
        lf_assert_status(try_open("window", X_WIDTH, X_HEIGHT, &device, &err), LF_E_BUSY, &err);
        kill(rescue, SIGKILL);
        assert_int_equal(waitpid(rescue, &ended, 0), rescue);
        assert_true(WIFSIGNALED(ended)); /* it was not needed */
        assert_int_equal(kill(server, SIGCONT), 0);
        lf_image8_finish(&frame);
        lf_device_destroy(open_when_it_is_free(X_WIDTH, X_HEIGHT));
    }
    kill(server, SIGTERM);
    waitpid(server, NULL, 0);
    unsetenv("DISPLAY");
    unsetenv("SDL_RENDER_DRIVER");
    setenv("SDL_VIDEODRIVER", "dummy", 1);
}

static void output_that_is_not_the_panels_size_is_told(void **state)
{
    (void)state;
    lf_device *device = NULL;
    lf_error err = {0};
    lf_sdl sdl;
    char name[64], spec[80];
    if (!has_sdl())
        skip();
    lf_assert_ok(lf_sdl_load(NULL, &sdl, NULL), NULL);
    lf_assert_ok(lf_sdl_begin(&sdl, 0, NULL), NULL);
    snprintf(name, sizeof name, "%s", sdl.GetDisplayName(0));
    lf_sdl_end(&sdl);
    lf_assert_status(try_open("window", 1536, 2048, &device, &err), LF_E_NODEV, &err);
    assert_non_null(strstr(err.what, "1536x2048 pixels; found: "));
    assert_non_null(strstr(err.what, " 1024x768"));
    lf_assert_status(try_open("window:LKG", WIDTH, HEIGHT, &device, &err), LF_E_NODEV, &err);
    assert_non_null(strstr(err.what, "has the name LKG"));
    assert_null(device);
    snprintf(spec, sizeof spec, "window:%s", name);
    lf_assert_ok(try_open(spec, 1536, 2048, &device, &err), &err);
    lf_device_info info;
    device->ops->info(device, &info);
    assert_string_equal(info.spec, spec);
    assert_non_null(
        strstr(info.problem, "the window has 1024x768 pixels, but the panel 1536x2048"));
    lf_device_destroy(device);
}

static void sdl_belongs_to_one_at_a_time(void **state)
{
    (void)state;
    lf_device *device = NULL, *second = NULL;
    lf_device_info info[4];
    lf_error err = {0};
    if (!has_sdl())
        skip();
    lf_assert_ok(try_open("window", WIDTH, HEIGHT, &device, &err), &err);
    lf_assert_status(try_open("window", WIDTH, HEIGHT, &second, &err), LF_E_BUSY, &err);
    assert_null(second);
    assert_int_equal(lf_window_ops.probe(info, 4), 0);
    lf_device_destroy(device);
    lf_assert_ok(try_open("window", WIDTH, HEIGHT, &second, &err), &err);
    lf_device_destroy(second);
}

static void probe_opens_nothing_on_ordinary_monitors(void **state)
{
    (void)state;
    lf_device_info info[4];
    char name[64];
    forget_pictures();
    assert_int_equal(lf_window_ops.probe(info, 4), 0);
    assert_false(last_picture(name, sizeof name));
}

static void what_is_missing_is_told(void **state)
{
    (void)state;
    lf_sdl sdl;
    lf_error err = {0};
    lf_device *device = NULL;
    lf_assert_status(lf_sdl_load("libnone-of-that-name.so.7", &sdl, &err), LF_E_NODEV, &err);
    assert_non_null(strstr(err.what, "apt-get install libsdl2-2.0-0"));
    lf_assert_status(lf_sdl_load("libc.so.6", &sdl, &err), LF_E_NODEV, &err);
    assert_non_null(strstr(err.what, "has no SDL_"));
    lf_assert_status(try_open("window:a\nb", WIDTH, HEIGHT, &device, &err), LF_E_ARG, &err);
    if (!has_sdl())
        skip();
    setenv("CACHE_DIRECTORY", ".", 1);
    lf_assert_status(lf_device_open("window", NULL, &device, &err), LF_E_NODEV, &err);
    unsetenv("SDL_VIDEODRIVER");
    lf_assert_status(try_open("window", WIDTH, HEIGHT, &device, &err), LF_E_NODEV, &err);
    assert_non_null(strstr(err.what, "--device drm"));
    assert_int_equal(lf_window_ops.probe(NULL, 0), 0);
    setenv("SDL_VIDEODRIVER", "no-such-driver", 1);
    lf_assert_status(try_open("window", WIDTH, HEIGHT, &device, &err), LF_E_NODEV, &err);
    setenv("SDL_VIDEODRIVER", "dummy", 1);
    assert_null(device);
}

/* An X server that takes calls and never says a word; its number is in $DISPLAY. -1 = there is no
 * place for one. */
static int start_silent_server(void)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    char display[16];
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0), number = 600;
    assert_true(fd >= 0);
    mkdir("/tmp/.X11-unix", 01777);
    for (; number < 700; number++) {
        snprintf(at.sun_path, sizeof at.sun_path, "/tmp/.X11-unix/X%d", number);
        if (bind(fd, (const struct sockaddr *)&at, sizeof at) == 0 && listen(fd, 8) == 0)
            break;
    }
    if (number == 700) {
        close(fd);
        return -1;
    }
    snprintf(display, sizeof display, ":%d", number);
    setenv("DISPLAY", display, 1);
    setenv("SDL_VIDEODRIVER", "x11", 1);
    return fd;
}

static void stop_silent_server(int fd)
{
    struct sockaddr_un at;
    socklen_t n = sizeof at;
    assert_int_equal(getsockname(fd, (struct sockaddr *)&at, &n), 0);
    unlink(at.sun_path);
    close(fd);
    unsetenv("DISPLAY");
    setenv("SDL_VIDEODRIVER", "dummy", 1);
}

static void a_desktop_that_hangs_is_left_behind(void **state)
{
    (void)state;
    lf_device *device = NULL;
    lf_device_info info[4];
    lf_error err = {0};
    if (!has_sdl())
        skip();
#ifdef __SANITIZE_ADDRESS__
    print_message("libX11 forgets some memory when its server goes, which would count\n");
    skip();
#endif
    int fd = start_silent_server();
    if (fd < 0) {
        print_message("no socket can be made in /tmp/.X11-unix\n");
        skip();
    }
    assert_int_equal(lf_window_ops.probe(info, 4), 0);
    /* until the one that was left behind has ended, SDL is its */
    lf_assert_status(try_open("window", WIDTH, HEIGHT, &device, &err), LF_E_BUSY, &err);
    stop_silent_server(fd);
    lf_device_destroy(open_when_it_is_free(WIDTH, HEIGHT));
    fd = start_silent_server();
    assert_true(fd >= 0);
    lf_assert_status(try_open("window", WIDTH, HEIGHT, &device, &err), LF_E_IO, &err);
    assert_non_null(strstr(err.what, "has not answered"));
    assert_null(device);
    stop_silent_server(fd);
    lf_device_destroy(open_when_it_is_free(WIDTH, HEIGHT));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rectangles_make_the_frame),
        cmocka_unit_test(lost_picture_is_asked_for_again),
        cmocka_unit_test(window_that_is_moved_to_another_looking_glass_is_gone),
        cmocka_unit_test(screen_shows_the_frame_pixel_for_pixel),
        cmocka_unit_test(window_of_a_desktop_that_hangs_is_left_behind),
        cmocka_unit_test(output_that_is_not_the_panels_size_is_told),
        cmocka_unit_test(sdl_belongs_to_one_at_a_time),
        cmocka_unit_test(probe_opens_nothing_on_ordinary_monitors),
        cmocka_unit_test(what_is_missing_is_told),
        cmocka_unit_test(a_desktop_that_hangs_is_left_behind),
    };
    char *dir = lf_test_folder();
    unsetenv("WAYLAND_DISPLAY");
    unsetenv("DISPLAY");
    setenv("SDL_VIDEODRIVER", "dummy", 1);
    setenv("SDL_VIDEO_DUMMY_SAVE_FRAMES", "1", 1);
    int failed = chdir(dir) == 0 ? cmocka_run_group_tests(tests, NULL, NULL) : 1;
    lf_test_folder_remove(dir);
    return failed;
}
