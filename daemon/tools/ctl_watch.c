/* quiltctl watch: a status line for people. */
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "base/escape.h"
#include "base/thread.h"
#include "daemon/tools/ctl.h"

#define PERIOD_NS 500000000
#define LOG_SECONDS 30.0 /* between two lines if stdout is not a terminal */

static volatile sig_atomic_t interrupted;

static void on_interrupt(int signal)
{
    (void)signal;
    interrupted = 1;
}

/* ------------------------------------------------------------------------------------ a line -- */

static double number(const json_t *status, const char *key)
{
    return json_number_value(json_object_get(status, key));
}

static const char *text(const json_t *status, const char *key)
{
    const char *value = json_string_value(json_object_get(status, key));
    return value ? value : "";
}

static void add(char *line, const char *words)
{
    const size_t used = strlen(line);
    lf_escape(line + used, LF_CTL_LINE - used, words);
}

char *lf_ctl_time(double seconds, char buf[LF_CTL_TIME])
{
    if (seconds < 90)
        snprintf(buf, LF_CTL_TIME, "%.0f s", seconds);
    else if (seconds < 5400)
        snprintf(buf, LF_CTL_TIME, "%.0f min", seconds / 60);
    else
        snprintf(buf, LF_CTL_TIME, "%.1f h", seconds / 3600);
    return buf;
}

static void add_time(char *line, double seconds)
{
    char words[LF_CTL_TIME];
    add(line, lf_ctl_time(seconds, words));
}

/* The last part of a path. */
static const char *name_of(const json_t *object, const char *key)
{
    const char *path = text(object, key), *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static void add_error(const json_t *status, char *line)
{
    const json_t *error = json_object_get(status, "error_estimate");
    char words[96];
    if (!json_is_number(error))
        return;
    snprintf(words, sizeof words, ", error %.2g", json_number_value(error));
    add(line, words);
    if (number(status, "seconds_left") <= 0)
        return;
    add(line, ", about ");
    add_time(line, number(status, "seconds_left"));
    snprintf(words, sizeof words, " left to %.2g", number(status, "target_error"));
    add(line, words);
}

static void add_work(const json_t *status, char *line)
{
    char words[64];
    const double passes = number(status, "passes");
    add(line, ", ");
    add_time(line, number(status, "seconds"));
    snprintf(words, sizeof words, passes < 10 ? ", %.1f passes" : ", %.0f passes", passes);
    add(line, words);
    add_error(status, line);
}

static void add_reading(const json_t *status, char *line)
{
    const json_t *reading = json_object_get(status, "reading");
    char words[96];
    add(line, "loading");
    if (!json_is_object(reading)) {
        add(line, " ");
        add(line, name_of(json_object_get(status, "load"), "file"));
        return;
    }
    add(line, ": reading ");
    add(line, name_of(reading, "file"));
    snprintf(words, sizeof words, " (%.1f MB) for ", 1e-6 * number(reading, "bytes"));
    add(line, words);
    add_time(line, number(reading, "seconds"));
}

static void add_panel(const json_t *status, char *line)
{
    const json_t *device = json_object_get(status, "device"),
                 *shown = json_object_get(status, "shown");
    const char *problem = text(device, "problem"), *level = text(shown, "level");
    const bool none = strcmp(text(device, "kind"), "none") == 0 || text(device, "kind")[0] == '\0';
    if (problem[0] != '\0') {
        add(line, "; panel: ");
        add(line, problem);
    } else if (!none && number(shown, "generation") < number(status, "generation")) {
        add(line, "; not on the panel yet");
    } else if (!none && strcmp(level, "none") != 0 &&
               !json_is_true(json_object_get(status, "is_quilt"))) {
        add(line, "; on the panel: ");
        add(line, level);
    }
}

/* The entry of a slideshow that is played. */
static void add_entry(const json_t *playlist, char *line)
{
    char words[64];
    if (!json_is_true(json_object_get(playlist, "playing")))
        return;
    snprintf(words, sizeof words, "%sentry %.0f of %.0f, ",
             json_is_true(json_object_get(playlist, "paused")) ? "paused at " : "",
             number(playlist, "index") + 1, number(playlist, "entries"));
    add(line, words);
}

static void add_video(const json_t *video, char *line)
{
    const char *problem = text(video, "problem");
    char words[160];
    snprintf(words, sizeof words, ": video at %.1f s%s, %.0f frames shown, %.0f dropped",
             number(video, "seconds"),
             json_is_true(json_object_get(video, "paused")) ? " (paused)" : "",
             number(video, "shown"), number(video, "dropped"));
    add(line, words);
    if (problem[0] != '\0') {
        add(line, "; stopped: ");
        add(line, problem);
    }
}

static void add_state(const json_t *status, char *line)
{
    const char *state = text(status, "state");
    const bool is_quilt = json_is_true(json_object_get(status, "is_quilt"));
    if (json_is_object(json_object_get(status, "load"))) {
        add_reading(status, line);
    } else if (strcmp(state, "error") == 0) {
        add(line, "error: ");
        add(line, text(json_object_get(status, "error"), "message"));
    } else if (!json_is_string(json_object_get(status, "scene"))) {
        add(line, "no scene");
    } else if (json_is_object(json_object_get(status, "video"))) {
        add_entry(json_object_get(status, "playlist"), line);
        add(line, name_of(status, "scene"));
        add_video(json_object_get(status, "video"), line);
        add_panel(status, line);
    } else {
        add_entry(json_object_get(status, "playlist"), line);
        add(line, name_of(status, "scene"));
        add(line, is_quilt                          ? ": a picture"
                  : strcmp(state, "converged") == 0 ? ": finished"
                  : strcmp(state, "rendering") == 0 ? ": rendering"
                  : strcmp(state, "paused") == 0    ? ": paused"
                                                    : ": not rendering");
        if (!is_quilt)
            add_work(status, line);
        add_panel(status, line);
    }
}

char *lf_ctl_watch_line(const json_t *status, char line[LF_CTL_LINE])
{
    line[0] = '\0';
    add_state(status, line);
    return line;
}

/* ---------------------------------------------------------------------------------- watching -- */

/* The last logged line; a change of state is logged at once. */
typedef struct told {
    char state[32];
    double at; /* 0: none */
} told;

static bool is_due(const json_t *status, const told *last)
{
    return last->at == 0 || lf_time_now() - last->at >= LOG_SECONDS ||
           strcmp(last->state, text(status, "state")) != 0;
}

/* The bytes of a line that fit into this many columns; multi-byte characters stay whole. */
static int fit(const char *line, int columns)
{
    int n = 0;
    for (int at = 0; line[n] != '\0'; n++) {
        at += ((unsigned char)line[n] & 0xc0) != 0x80;
        if (at > columns)
            break;
    }
    return n;
}

static void print_line(const json_t *status, told *last)
{
    char line[LF_CTL_LINE];
    struct winsize window = {0};
    lf_ctl_watch_line(status, line);
    if (isatty(STDOUT_FILENO)) {
        (void)ioctl(STDOUT_FILENO, TIOCGWINSZ, &window);
        printf("\r%.*s\033[K", fit(line, window.ws_col > 1 ? window.ws_col - 1 : 79), line);
    } else if (is_due(status, last)) {
        printf("%s\n", line);
        snprintf(last->state, sizeof last->state, "%s", text(status, "state"));
        last->at = lf_time_now();
    }
    fflush(stdout);
}

lf_status lf_ctl_watch(lf_ctl *ctl, lf_error *err)
{
    struct sigaction action = {.sa_handler = on_interrupt};
    told last = {0};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    lf_status status = LF_OK;
    while (!interrupted && status == LF_OK) {
        json_t *result = NULL;
        status = lf_ctl_call(ctl, "status", json_object(), NULL, 0, &result, NULL, err);
        if (status == LF_OK) {
            print_line(result, &last);
            json_decref(result);
            nanosleep(&(struct timespec){.tv_nsec = PERIOD_NS}, NULL);
        }
    }
    if (isatty(STDOUT_FILENO))
        putchar('\n');
    return interrupted ? LF_OK : status;
}
