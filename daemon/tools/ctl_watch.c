#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "daemon/tools/ctl.h"

#define PERIOD_NS 500000000

static volatile sig_atomic_t interrupted;

static void on_interrupt(int signal)
{
    (void)signal;
    interrupted = 1;
}

static double number(const json_t *status, const char *key)
{
    return json_number_value(json_object_get(status, key));
}

/* Of the unbiased picture, and of the one that is shown. */
static void name_errors(const json_t *status, char out[64])
{
    const json_t *error = json_object_get(status, "error_estimate"),
                 *shown = json_object_get(status, "shown_error");
    int n = json_is_number(error) ? snprintf(out, 64, "%.3g", json_number_value(error))
                                  : snprintf(out, 64, "-");
    if (json_is_number(shown))
        snprintf(out + n, (size_t)(64 - n), ", shown %.3g", json_number_value(shown));
}

static void print_line(const json_t *status)
{
    const json_t *shown = json_object_get(status, "shown");
    const char *state = json_string_value(json_object_get(status, "state"));
    const char *level = json_string_value(json_object_get(shown, "level"));
    char errors[64];
    name_errors(status, errors);
    printf("%s%s  generation %.0f (shown %.0f, %s)  %.1f passes, %.2f spp  error %s  %.0f updates, "
           "%.1f MB%s",
           isatty(STDOUT_FILENO) ? "\r\033[K" : "", state ? state : "?",
           number(status, "generation"), number(shown, "generation"), level ? level : "?",
           number(status, "passes"), number(status, "spp"), errors, number(status, "updates"),
           number(status, "bytes") * 1e-6, isatty(STDOUT_FILENO) ? "" : "\n");
    fflush(stdout);
}

lf_status lf_ctl_watch(lf_ctl *ctl, lf_error *err)
{
    struct sigaction action = {.sa_handler = on_interrupt};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    lf_status status = LF_OK;
    while (!interrupted && status == LF_OK) {
        json_t *result = NULL;
        status = lf_ctl_call(ctl, "status", json_object(), NULL, 0, &result, NULL, err);
        if (status == LF_OK) {
            print_line(result);
            json_decref(result);
            nanosleep(&(struct timespec){.tv_nsec = PERIOD_NS}, NULL);
        }
    }
    if (isatty(STDOUT_FILENO))
        putchar('\n');
    return interrupted ? LF_OK : status;
}
