#include "daemon/tools/progress_line.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/thread.h"

static void log_line(lf_progress_line *line, const char *text)
{
    const double now = lf_time_now();
    if (!(line->last > 0.0))
        line->last = now;
    if (now - line->last < line->interval)
        return;
    line->last = now;
    lf_log(LF_LOG_INFO, "%s", text);
}

void lf_progress_line_draw(lf_progress_line *line, const char *text)
{
    double now = lf_time_now();
    if (line->logs)
        log_line(line, text);
    if (!line->on || (line->last > 0 && now - line->last < 0.1))
        return;
    line->last = now;
    fprintf(stderr, "\r%s: %s\033[K", line->program, text);
}

void lf_progress_line_clear(lf_progress_line *line)
{
    if (!line->on)
        return;
    if (line->last > 0)
        fputs("\r\033[K", stderr);
    line->last = 0;
}

void lf_progress_line_reading(void *context, const lf_import_progress *progress)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    lf_progress_line *line = context;
    char text[160];
    const char *slash = strrchr(progress->path, '/');
    if ((!line->on && !line->logs) || progress->ended || progress->seconds < 0.5)
        return;
    snprintf(text, sizeof text, "reading %.60s (%.1f MB), %.0f s",
             slash ? slash + 1 : progress->path, 1e-6 * (double)progress->bytes, progress->seconds);
    pthread_mutex_lock(&lock);
    lf_progress_line_draw(line, text);
    pthread_mutex_unlock(&lock);
}
