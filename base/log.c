#include "base/log.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include "base/escape.h"

#define LINE_BYTES 4096

static struct {
    const char *program;
    lf_log_level level;
    bool journal; /* stderr is the journal: lines carry their level */
} log_state = {.program = "quiltd", .level = LF_LOG_INFO};

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

static void write_line(const char *line, size_t n)
{
    /* one write per line keeps lines of several threads whole; a failure cannot be reported */
    ssize_t written = write(STDERR_FILENO, line, n);
    (void)written;
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
    int n = log_state.journal
                ? snprintf(line, sizeof line, "<%d>%s: ", (int)level, log_state.program)
                : snprintf(line, sizeof line, "%s: ", log_state.program);
    size_t used = n < 0 ? 0 : (size_t)n < LINE_BYTES / 4 ? (size_t)n : LINE_BYTES / 4;
    used += lf_escape(line + used, sizeof line - used - 1, text);
    line[used++] = '\n';
    write_line(line, used);
}

void lf_log_error(const lf_error *err)
{
    char text[sizeof(lf_error) + 32];
    lf_log(LF_LOG_ERROR, "%s", lf_error_format(err, text, sizeof text));
}
