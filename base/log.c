#include "base/log.h"

#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

#include "base/escape.h"

#define LINE_BYTES 4096

static struct {
    const char *program;
    lf_log_level level;
    bool journal; /* stderr is the journal: lines carry their level */
    void (*taken)(void *context, lf_log_level level, const char *text); /* NULL: stderr */
    void *context;
} log_state = {.program = "quiltd", .level = LF_LOG_INFO};

/* The last lines; line n is at n % LF_LOG_KEPT. */
static struct {
    pthread_mutex_t lock;
    lf_log_line line[LF_LOG_KEPT];
    int64_t last;
    void (*told)(void *context);
    void *context;
} kept = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* systemd.exec(5): $JOURNAL_STREAM is "DEVICE:INODE" of the stream that stdout or stderr was
 * connected to */
static bool stderr_is_journal(void)
{
    const char *stream = getenv("JOURNAL_STREAM");
    struct stat st;
    if (!stream || fstat(STDERR_FILENO, &st) != 0)
        return false;
    char mine[64];
    snprintf(mine, sizeof mine, "%ju:%ju", (uintmax_t)st.st_dev, (uintmax_t)st.st_ino);
    return strcmp(stream, mine) == 0;
}

void lf_log_init(const char *program, lf_log_level level)
{
    const char *debug = getenv("QUILTD_DEBUG");
    log_state.program = program;
    log_state.level = debug && strcmp(debug, "1") == 0 ? LF_LOG_DEBUG : level;
    log_state.journal = stderr_is_journal();
}

void lf_log_take(void (*taken)(void *context, lf_log_level level, const char *text), void *context)
{
    log_state.taken = taken;
    log_state.context = context;
}

static void write_line(const char *line, size_t n)
{
    /* one write per line keeps lines of several threads whole; a failure cannot be reported */
    ssize_t written = write(STDERR_FILENO, line, n);
    (void)written;
}

static void keep(lf_log_level level, const char *text)
{
    struct timespec now = {0};
    pthread_mutex_lock(&kept.lock);
    clock_gettime(CLOCK_REALTIME, &now);
    lf_log_line *line = &kept.line[++kept.last % LF_LOG_KEPT];
    line->number = kept.last;
    line->time = (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
    line->level = level;
    lf_escape(line->text, sizeof line->text, text);
    if (kept.told)
        kept.told(kept.context);
    pthread_mutex_unlock(&kept.lock);
}

int64_t lf_log_last(void)
{
    pthread_mutex_lock(&kept.lock);
    int64_t last = kept.last;
    pthread_mutex_unlock(&kept.lock);
    return last;
}

bool lf_log_line_at(int64_t number, lf_log_line *out)
{
    pthread_mutex_lock(&kept.lock);
    bool found = number >= 1 && number <= kept.last && number > kept.last - LF_LOG_KEPT;
    if (found)
        *out = kept.line[number % LF_LOG_KEPT];
    pthread_mutex_unlock(&kept.lock);
    return found;
}

void lf_log_tell(void (*told)(void *context), void *context)
{
    pthread_mutex_lock(&kept.lock);
    kept.told = told;
    kept.context = context;
    pthread_mutex_unlock(&kept.lock);
}

void lf_log(lf_log_level level, const char *fmt, ...)
{
    if (level > log_state.level)
        return;
    char text[LINE_BYTES / 2], line[LINE_BYTES];
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(text, sizeof text, fmt, ap);
    va_end(ap);
    if (log_state.taken) {
        log_state.taken(log_state.context, level, text);
        return;
    }
    int n = log_state.journal
                ? snprintf(line, sizeof line, "<%d>%s: ", (int)level, log_state.program)
                : snprintf(line, sizeof line, "%s: ", log_state.program);
    size_t used = n < 0 ? 0 : (size_t)n < LINE_BYTES / 4 ? (size_t)n : LINE_BYTES / 4;
    used += lf_escape(line + used, sizeof line - used - 1, text);
    line[used++] = '\n';
    write_line(line, used);
    keep(level, text);
}

void lf_log_error(const lf_error *err)
{
    char text[sizeof(lf_error) + 32];
    lf_log(LF_LOG_ERROR, "%s", lf_error_format(err, text, sizeof text));
}
