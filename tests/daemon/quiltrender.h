/* quiltrender as a program: files for it to read, and what it said and wrote. Fails the running
 * test when that does not come about. */
#ifndef LF_TESTS_DAEMON_QUILTRENDER_H
#define LF_TESTS_DAEMON_QUILTRENDER_H

#include <dirent.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>

#include "base/alloc.h"
#include "base/file.h"
#include "quilt/quilt.h"
#include "tests/testing.h"

#include "tests/scene_file.h"

#define VIEWS 6
#define WIDTH 20
#define HEIGHT 12

typedef struct qr_files {
    char *folder;
    char scene[PATH_MAX];       /* fog-over-clay */
    char quilt[PATH_MAX];       /* a small 8-bit quilt picture */
    char large[PATH_MAX];       /* one that takes a while to write */
    char calibration[PATH_MAX]; /* a small panel */
} qr_files;

static inline void qr_write_quilt(char *path, const char *folder, const char *name, int view_width,
                                  int view_height)
{
    lf_error err = {0};
    lf_outfile file;
    size_t row = (size_t)view_width * 3;
    uint8_t *data = lf_calloc(VIEWS * (size_t)view_height, row);
    const lf_views8 views = {VIEWS, view_width, view_height, row * (size_t)view_height, row, data};
    const lf_layout layout = {3, 2, VIEWS, view_width, view_height, 1.5};
    assert_non_null(data);
    for (size_t i = 0; i < VIEWS * (size_t)view_height * row; i++)
        data[i] = (uint8_t)((i * 2654435761u) >> 13);
    snprintf(path, PATH_MAX, "%s/%s", folder, name);
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_assert_ok(lf_quilt_write_png(&file, &views, &layout, NULL, 0, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_free(data);
}

static inline int qr_set_up(void **state)
{
    static qr_files f;
    f.folder = lf_test_folder();
    snprintf(f.scene, sizeof f.scene, "%s",
             lf_test_write(f.folder, "fog.json", lf_test_scene_text("fog-over-clay")));
    snprintf(f.calibration, sizeof f.calibration, "%s",
             lf_test_write(f.folder, "panel.json",
                           lf_test_scene_patched(
                               "panel",
                               "{'configVersion': null, 'serial': null, 'center': {'value': 0.5}, "
                               "'screenW': {'value': 90}, 'screenH': {'value': 60}}")));
    qr_write_quilt(f.quilt, f.folder, "card_qs3x2a1.5.png", WIDTH, HEIGHT);
    qr_write_quilt(f.large, f.folder, "large_qs3x2a1.5.png", 240, 160);
    *state = &f;
    return 0;
}

static inline int qr_tear_down(void **state)
{
    qr_files *f = *state;
    lf_test_folder_remove(f->folder);
    return 0;
}

/* -------------------------------------------------------------------------- running programs -- */

static inline void qr_nap(double seconds)
{
    const struct timespec time = {(time_t)seconds, (long)((seconds - floor(seconds)) * 1e9)};
    nanosleep(&time, NULL);
}

typedef struct qr_outcome {
    int code; /* exit code, or 1000 + the signal's number */
    char out[32768], err[8192];
} qr_outcome;

/* Starts quiltrender with its words in `line` (parted by single blanks); stderr goes to err_fd,
 * stdout to out_fd. */
static inline pid_t qr_start(const char *line, int out_fd, int err_fd, rlim_t file_limit)
{
    static char copy[8 * PATH_MAX];
    char program[PATH_MAX];
    char *argv[64] = {program};
    int argc = 1;
    snprintf(program, sizeof program, "%s", lf_test_built("quiltrender"));
    snprintf(copy, sizeof copy, "%s", line);
    for (char *word = strtok(copy, " "); word && argc < 63; word = strtok(NULL, " "))
        argv[argc++] = word;
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        const struct rlimit limit = {file_limit, file_limit};
        if (file_limit != RLIM_INFINITY)
            setrlimit(RLIMIT_FSIZE, &limit);
        dup2(out_fd, STDOUT_FILENO);
        dup2(err_fd, STDERR_FILENO);
        execv(program, argv);
        _exit(127);
    }
    return pid;
}

static inline int qr_ended(pid_t pid)
{
    int status = 0;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

static inline void qr_read_back(int fd, char *text, size_t size)
{
    ssize_t n = pread(fd, text, size - 1, 0);
    text[n > 0 ? n : 0] = '\0';
    close(fd);
}

static inline void qr_run_limited(qr_outcome *o, const char *line, rlim_t file_limit)
{
    int out = memfd_create("stdout", 0);
    int err = memfd_create("stderr", 0);
    assert_true(out >= 0 && err >= 0);
    o->code = qr_ended(qr_start(line, out, err, file_limit));
    qr_read_back(out, o->out, sizeof o->out);
    qr_read_back(err, o->err, sizeof o->err);
}

static inline void qr_run(qr_outcome *o, const char *fmt, ...) LF_PRINTF(2, 3);
static inline void qr_run(qr_outcome *o, const char *fmt, ...)
{
    char line[8 * PATH_MAX];
    va_list args;
    va_start(args, fmt);
    vsnprintf(line, sizeof line, fmt, args);
    va_end(args);
    qr_run_limited(o, line, RLIM_INFINITY);
}

static inline void qr_succeed(const char *fmt, ...) LF_PRINTF(1, 2);
static inline void qr_succeed(const char *fmt, ...)
{
    char line[8 * PATH_MAX];
    qr_outcome o;
    va_list args;
    va_start(args, fmt);
    vsnprintf(line, sizeof line, fmt, args);
    va_end(args);
    qr_run_limited(&o, line, RLIM_INFINITY);
    if (o.code != 0)
        fail_msg("quiltrender %s: exit %d, %s", line, o.code, o.err);
}

/* One line "quiltrender: WHERE: WHAT", exit `code`, holding `words`. */
static inline void qr_assert_fails(const qr_outcome *o, int code, const char *words)
{
    if (o->code != code || strncmp(o->err, "quiltrender: ", 13) != 0 || !strstr(o->err, words))
        fail_msg("exit %d with \"%s\", expected exit %d with \"%s\"", o->code, o->err, code, words);
    const char *end = strchr(o->err, '\n');
    assert_non_null(end);
    if (end[1] != '\0')
        fail_msg("more than a line: %s", o->err);
    assert_string_equal(o->out, "");
}

static inline bool qr_exists(const char *folder, const char *name)
{
    return access(lf_test_path(folder, name), F_OK) == 0;
}

static inline int qr_count_files(const char *folder)
{
    DIR *dir = opendir(folder);
    int n = 0;
    assert_non_null(dir);
    for (const struct dirent *entry = readdir(dir); entry; entry = readdir(dir))
        n += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(dir);
    return n;
}

static inline void qr_assert_same_files(const char *a, const char *b)
{
    char *x = NULL;
    char *y = NULL;
    size_t n = 0;
    size_t m = 0;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(a, NULL, UINT64_C(1) << 30, &x, &n, &err), &err);
    lf_assert_ok(lf_file_read(b, NULL, UINT64_C(1) << 30, &y, &m, &err), &err);
    assert_int_equal(n, m);
    assert_memory_equal(x, y, n);
    lf_free(x);
    lf_free(y);
}

static inline void qr_assert_different_files(const char *a, const char *b)
{
    char *x = NULL;
    char *y = NULL;
    size_t n = 0;
    size_t m = 0;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(a, NULL, UINT64_C(1) << 30, &x, &n, &err), &err);
    lf_assert_ok(lf_file_read(b, NULL, UINT64_C(1) << 30, &y, &m, &err), &err);
    assert_true(n != m || memcmp(x, y, n) != 0);
    lf_free(x);
    lf_free(y);
}

#endif
