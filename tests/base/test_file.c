#include "tests/testing.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "base/alloc.h"
#include "base/file.h"

/* Number of entries of a folder. */
static int entries(const char *folder)
{
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    int n = 0;
    while (readdir(dir))
        n++;
    closedir(dir);
    return n - 2;
}

static void assert_contents(const char *path, const char *expected)
{
    lf_error err;
    char *data;
    size_t size;
    lf_assert_ok(lf_file_read(path, NULL, 1 << 20, &data, &size, &err), &err);
    assert_int_equal(size, strlen(expected));
    assert_string_equal(data, expected);
    lf_free(data);
}

/* ----------------------------------------------------------------------------------- reading -- */

static void a_file_is_read_whole_and_terminated(void **state)
{
    lf_error err;
    char *data;
    size_t size;
    const char *path = lf_test_write(*state, "a", "some text");
    lf_assert_ok(lf_file_read(path, NULL, 9, &data, &size, &err), &err);
    assert_int_equal(size, 9);
    assert_string_equal(data, "some text");
    lf_free(data);
    lf_assert_ok(lf_file_read(lf_test_write(*state, "empty", ""), NULL, 0, &data, &size, &err),
                 &err);
    assert_int_equal(size, 0);
    assert_string_equal(data, "");
    lf_free(data);
}

static void size_limits_hold(void **state)
{
    lf_error err;
    char *data = NULL;
    size_t size = 77;
    const char *path = lf_test_write(*state, "a", "some text");
    lf_assert_status(lf_file_read(path, NULL, 8, &data, &size, &err), LF_E_FORMAT, NULL);
    assert_non_null(strstr(err.what, "the file has 9 bytes; expected at most 8"));
    assert_null(data);
    assert_int_equal(size, 77);
}

static void only_regular_files_are_opened(void **state)
{
    lf_error err;
    int fd = -1;
    const char *fifo = lf_test_path(*state, "fifo");
    assert_int_equal(mkfifo(fifo, 0600), 0);
    lf_roots roots = {0};
    lf_assert_ok(lf_roots_add(&roots, *state, &err), &err);
    /* without O_NONBLOCK this would wait for a writer for ever */
    lf_assert_status(lf_file_open(fifo, NULL, 100, &fd, NULL, &err), LF_E_FORMAT, NULL);
    lf_assert_status(lf_file_open(fifo, &roots, 100, &fd, NULL, &err), LF_E_FORMAT, NULL);
    lf_assert_status(lf_file_open(*state, NULL, 100, &fd, NULL, &err), LF_E_FORMAT, NULL);
    lf_assert_status(lf_file_open(*state, &roots, 100, &fd, NULL, &err), LF_E_FORMAT, NULL);
    lf_assert_status(lf_file_open("/dev/null", NULL, 100, &fd, NULL, &err), LF_E_FORMAT, NULL);
    lf_assert_status(lf_file_open(lf_test_path(*state, "absent"), NULL, 100, &fd, NULL, &err),
                     LF_E_IO, NULL);
    lf_assert_status(lf_file_open(lf_test_path(*state, "absent"), &roots, 100, &fd, NULL, &err),
                     LF_E_IO, NULL);
    assert_int_equal(fd, -1);
    lf_roots_finish(&roots);
}

static void a_web_page_is_called_one(void **state)
{
    static const char *const pages[] = {"<!DOCTYPE html>\n<html>404</html>", "\n <HTML><body>",
                                        "<!doctype HTML"};
    static const char *const others[] = {"<?xml version=\"1.0\"?>", "<ht", "", "v 0 0 0\n<html>"};
    lf_error err;
    int fd;
    for (size_t i = 0; i < sizeof pages / sizeof *pages; i++) {
        const char *path = lf_test_write(*state, "page.obj", pages[i]);
        lf_assert_status(lf_file_open(path, NULL, 1 << 20, &fd, NULL, &err), LF_E_FORMAT, &err);
        assert_non_null(strstr(err.what, "a web page"));
    }
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        const char *path = lf_test_write(*state, "other", others[i]);
        lf_assert_ok(lf_file_open(path, NULL, 1 << 20, &fd, NULL, &err), &err);
        assert_int_equal(lseek(fd, 0, SEEK_CUR), 0); /* as if nobody had looked */
        close(fd);
    }
}

static void descriptors_are_not_inherited(void **state)
{
    lf_error err;
    int fd;
    uint64_t size;
    lf_roots roots = {0};
    lf_assert_ok(lf_roots_add(&roots, *state, &err), &err);
    const char *path = lf_test_write(*state, "a", "abc");
    for (int i = 0; i < 2; i++) {
        lf_assert_ok(lf_file_open(path, i ? &roots : NULL, 100, &fd, &size, &err), &err);
        assert_int_equal(size, 3);
        assert_int_equal(fcntl(fd, F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
        close(fd);
    }
    lf_roots_finish(&roots);
}

/* ------------------------------------------------------------------------------------- roots -- */

/* in/file, in/sub/file, out/secret, in/link -> out/secret, in/folder -> out, in/inside -> sub/file,
 * inner (a name that only begins like in) */
static void make_tree(const char *folder)
{
    assert_int_equal(mkdir(lf_test_path(folder, "in"), 0700), 0);
    assert_int_equal(mkdir(lf_test_path(folder, "in/sub"), 0700), 0);
    assert_int_equal(mkdir(lf_test_path(folder, "out"), 0700), 0);
    assert_int_equal(mkdir(lf_test_path(folder, "inner"), 0700), 0);
    lf_test_write(folder, "in/file", "1");
    lf_test_write(folder, "in/sub/file", "2");
    lf_test_write(folder, "out/secret", "3");
    lf_test_write(folder, "inner/file", "4");
    assert_int_equal(symlink("../out/secret", lf_test_path(folder, "in/link")), 0);
    assert_int_equal(symlink(lf_test_path(folder, "out"), lf_test_path(folder, "in/folder")), 0);
    assert_int_equal(symlink("sub/file", lf_test_path(folder, "in/inside")), 0);
    assert_int_equal(symlink("in", lf_test_path(folder, "alias")), 0);
}

static void reading_stays_beneath_the_roots(void **state)
{
    static const struct {
        const char *name;
        lf_status expected;
    } cases[] = {
        {"in/file", LF_OK},
        {"in/sub/file", LF_OK},
        {"in/sub/../file", LF_OK},
        {"in/inside", LF_OK},
        {"alias/file", LF_OK},
        {"out/../in/file", LF_OK},
        {"in/absent", LF_E_IO},
        {"in/absent/../absent", LF_E_IO},
        {"out/secret", LF_E_PATH},
        {"in/../out/secret", LF_E_PATH},
        {"in/link", LF_E_PATH},
        {"in/folder/secret", LF_E_PATH},
        {"inner/file", LF_E_PATH},
        /* whether a file exists outside is not told either */
        {"out/absent", LF_E_PATH},
        {"in/folder/absent", LF_E_PATH},
        {"absent/absent", LF_E_PATH},
        {"in/../../../../../../../../../etc/passwd", LF_E_PATH},
    };
    lf_error err;
    make_tree(*state);
    lf_roots roots = {0};
    lf_assert_ok(lf_roots_add(&roots, lf_test_path(*state, "alias"), &err), &err);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int fd = -1;
        lf_status got =
            lf_file_open(lf_test_path(*state, cases[i].name), &roots, 100, &fd, NULL, &err);
        if (got != cases[i].expected)
            fail_msg("%s: %s, expected %s", cases[i].name, lf_status_name(got),
                     lf_status_name(cases[i].expected));
        if (fd >= 0)
            close(fd);
    }
    lf_roots_finish(&roots);
    /* the same paths are all right for a program without roots */
    assert_contents(lf_test_path(*state, "in/link"), "3");
    assert_contents(lf_test_path(*state, "inner/file"), "4");
}

static void several_roots_add_up(void **state)
{
    lf_error err;
    int fd;
    make_tree(*state);
    lf_roots roots = {0};
    lf_assert_ok(lf_roots_add(&roots, lf_test_path(*state, "in"), &err), &err);
    lf_assert_ok(lf_roots_add(&roots, lf_test_path(*state, "out"), &err), &err);
    lf_assert_ok(lf_roots_add(&roots, lf_test_path(*state, "in/../in"), &err), &err);
    assert_int_equal(roots.n_roots, 2);
    lf_assert_ok(lf_file_open(lf_test_path(*state, "in/link"), &roots, 100, &fd, NULL, &err), &err);
    close(fd);
    lf_assert_status(lf_file_open(lf_test_path(*state, "inner/file"), &roots, 100, &fd, NULL, &err),
                     LF_E_PATH, NULL);
    lf_roots_finish(&roots);
    lf_roots_finish(&roots);
}

static void roots_are_folders_and_not_endless(void **state)
{
    lf_error err;
    lf_roots roots = {0};
    lf_assert_status(lf_roots_add(&roots, lf_test_write(*state, "a", ""), &err), LF_E_ARG, NULL);
    lf_assert_status(lf_roots_add(&roots, lf_test_path(*state, "absent"), &err), LF_E_IO, NULL);
    for (int i = 0; i <= LF_MAX_ROOTS; i++) {
        char name[16];
        snprintf(name, sizeof name, "d%d", i);
        assert_int_equal(mkdir(lf_test_path(*state, name), 0700), 0);
        lf_assert_status(lf_roots_add(&roots, lf_test_path(*state, name), &err),
                         i < LF_MAX_ROOTS ? LF_OK : LF_E_ARG, NULL);
    }
    lf_roots_finish(&roots);
}

/* ------------------------------------------------------------------------------------- names -- */

static void assert_joined(const char *folder, const char *relative, const char *expected)
{
    char *path = lf_path_join(folder, relative);
    assert_string_equal(path, expected);
    lf_free(path);
}

static void assert_folder(const char *path, const char *expected)
{
    char *folder = lf_path_folder(path);
    assert_string_equal(folder, expected);
    lf_free(folder);
}

static void assert_beside(const char *path, const char *expected)
{
    char *name = lf_path_beside(path, ".json");
    assert_string_equal(name, expected);
    lf_free(name);
}

static void names_are_joined_and_taken_apart(void **state)
{
    (void)state;
    assert_joined("a", "b", "a/b");
    assert_joined("a/", "b", "a/b");
    assert_joined("/", "b", "/b");
    assert_joined("a", "/b", "/b");
    assert_joined("", "b", "b");
    assert_beside("a/sheet.tif", "a/sheet.json");
    assert_beside("a.b/sheet", "a.b/sheet.json");
    assert_beside("sheet.v2.tif", "sheet.v2.json");
    assert_folder("a/b", "a");
    assert_folder("/b", "/");
    assert_folder("b", ".");
    assert_folder("/a/b/c", "/a/b");
}

/* ----------------------------------------------------------------------------------- writing -- */

static lf_status write_text(const char *path, bool overwrite, const char *text, lf_error *err)
{
    lf_outfile file;
    lf_status status = lf_outfile_open(&file, path, overwrite, err);
    if (status == LF_OK)
        status = lf_outfile_write(&file, text, strlen(text), err);
    if (status == LF_OK)
        status = lf_outfile_commit(&file, overwrite, err);
    lf_outfile_abandon(&file);
    return status;
}

static void a_file_appears_whole_with_the_commit(void **state)
{
    lf_error err;
    lf_outfile file;
    const char *path = lf_test_path(*state, "out.png");
    lf_assert_ok(lf_outfile_open(&file, path, false, &err), &err);
    lf_assert_ok(lf_outfile_write(&file, "half", 4, &err), &err);
    assert_int_not_equal(access(path, F_OK), 0);
    lf_assert_ok(lf_outfile_write(&file, " whole", 6, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, false, &err), &err);
    assert_contents(path, "half whole");
    assert_int_equal(entries(*state), 1);
    lf_outfile_abandon(&file); /* a finished one: nothing happens */
    assert_contents(path, "half whole");
}

static void the_mode_follows_the_umask(void **state)
{
    lf_error err;
    struct stat st;
    mode_t before = umask(027);
    const char *path = lf_test_path(*state, "out");
    lf_assert_ok(write_text(path, false, "x", &err), &err);
    umask(before);
    assert_int_equal(stat(path, &st), 0);
    assert_int_equal(st.st_mode & 0777, 0640);
}

static void an_abandoned_file_leaves_nothing(void **state)
{
    lf_error err;
    lf_outfile file;
    const char *path = lf_test_write(*state, "out", "old");
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_assert_ok(lf_outfile_write(&file, "new", 3, &err), &err);
    lf_outfile_abandon(&file);
    lf_outfile_abandon(&file);
    assert_contents(path, "old");
    assert_int_equal(entries(*state), 1);
    lf_outfile zeroed = {0};
    lf_outfile_abandon(&zeroed);
    assert_int_not_equal(fcntl(0, F_GETFD), -1); /* descriptor 0 was not taken for its own */
}

static void an_existing_file_is_kept_unless_asked(void **state)
{
    lf_error err;
    lf_outfile file;
    const char *path = lf_test_write(*state, "out", "old");
    lf_assert_status(write_text(path, false, "new", &err), LF_E_EXISTS, NULL);
    assert_contents(path, "old");
    lf_assert_ok(write_text(path, true, "new", &err), &err);
    assert_contents(path, "new");

    /* one that comes between open and commit */
    const char *late = lf_test_path(*state, "late");
    lf_assert_ok(lf_outfile_open(&file, late, false, &err), &err);
    lf_test_write(*state, "late", "first");
    lf_assert_status(lf_outfile_commit(&file, false, &err), LF_E_EXISTS, NULL);
    assert_contents(late, "first");
    assert_int_equal(entries(*state), 2);
}

static void a_link_is_replaced_and_not_followed(void **state)
{
    lf_error err;
    struct stat st;
    const char *victim = lf_test_write(*state, "victim", "precious"),
               *path = lf_test_path(*state, "out");
    assert_int_equal(symlink("victim", path), 0);
    lf_assert_status(write_text(path, false, "new", &err), LF_E_EXISTS, NULL);
    lf_assert_ok(write_text(path, true, "new", &err), &err);
    assert_int_equal(lstat(path, &st), 0);
    assert_true(S_ISREG(st.st_mode));
    assert_contents(victim, "precious");
}

static void what_is_not_a_file_is_not_replaced(void **state)
{
    lf_error err;
    const char *folder = lf_test_path(*state, "folder"), *fifo = lf_test_path(*state, "fifo");
    assert_int_equal(mkdir(folder, 0700), 0);
    assert_int_equal(mkfifo(fifo, 0600), 0);
    lf_assert_status(write_text(folder, true, "x", &err), LF_E_IO, NULL);
    lf_assert_status(write_text(fifo, true, "x", &err), LF_E_IO, NULL);
    lf_assert_status(write_text("", true, "x", &err), LF_E_ARG, NULL);
    lf_assert_status(write_text(lf_test_path(*state, "new/"), true, "x", &err), LF_E_ARG, NULL);
    lf_assert_status(write_text(lf_test_path(*state, "absent/new"), true, "x", &err), LF_E_IO,
                     NULL);
}

/* ---------------------------------------- with and without unnamed files, as file systems go -- */

static bool refuse_tmpfile;
int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);

int __wrap_open(const char *path, int flags, ...)
{
    mode_t mode = 0;
    if ((flags & O_CREAT) || (flags & O_TMPFILE) == O_TMPFILE) {
        va_list ap;
        va_start(ap, flags);
        mode = va_arg(ap, mode_t);
        va_end(ap);
    }
    if (refuse_tmpfile && (flags & O_TMPFILE) == O_TMPFILE) {
        errno = EOPNOTSUPP;
        return -1;
    }
    return __real_open(path, flags, mode);
}

static int make_folder_named(void **state)
{
    refuse_tmpfile = true;
    return lf_test_folder_setup(state);
}

static int remove_folder_named(void **state)
{
    refuse_tmpfile = false;
    return lf_test_folder_teardown(state);
}

static void a_named_file_lies_beside_until_the_commit(void **state)
{
    lf_error err;
    lf_outfile file;
    const char *path = lf_test_path(*state, "out");
    lf_assert_ok(lf_outfile_open(&file, path, false, &err), &err);
    assert_non_null(file.temporary);
    assert_int_equal(entries(*state), 1);
    assert_int_equal(strncmp(strrchr(file.temporary, '/'), "/.out.quiltd-", 13), 0);
    lf_assert_ok(lf_outfile_write(&file, "x", 1, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, false, &err), &err);
    assert_int_equal(entries(*state), 1);
    assert_contents(path, "x");
}

static void leftovers_of_the_dead_go_and_of_the_living_stay(void **state)
{
    lf_error err;
    lf_test_write(*state, ".out.quiltd-abcdef", "dead");
    lf_test_write(*state, ".out.quiltd-abcdefg", "of another form");
    lf_test_write(*state, ".other.quiltd-abcdef", "of another file");
    lf_outfile living;
    refuse_tmpfile = true;
    lf_assert_ok(lf_outfile_open(&living, lf_test_path(*state, "out"), false, &err), &err);
    assert_int_not_equal(access(lf_test_path(*state, ".out.quiltd-abcdef"), F_OK), 0);
    assert_int_equal(access(lf_test_path(*state, ".out.quiltd-abcdefg"), F_OK), 0);
    assert_int_equal(access(lf_test_path(*state, ".other.quiltd-abcdef"), F_OK), 0);
    lf_assert_ok(lf_outfile_write(&living, "late", 4, &err), &err);
    lf_assert_ok(write_text(lf_test_path(*state, "out"), false, "quick", &err), &err);
    assert_int_equal(access(living.temporary, F_OK), 0);
    lf_assert_ok(lf_outfile_commit(&living, true, &err), &err);
    assert_contents(lf_test_path(*state, "out"), "late");
}

static void a_writer_killed_leaves_nothing_that_stays(void **state)
{
    lf_error err;
    const char *path = lf_test_path(*state, "out");
    for (int i = 0; i < 2; i++) {
        refuse_tmpfile = i == 1;
        pid_t child = fork();
        if (child == 0) {
            lf_outfile file;
            if (lf_outfile_open(&file, path, true, NULL) == LF_OK &&
                lf_outfile_write(&file, "half", 4, NULL) == LF_OK)
                kill(getpid(), SIGKILL);
            _exit(1);
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFSIGNALED(status));
        /* the named one is still there, until somebody writes again */
        assert_int_equal(entries(*state), i);
    }
    lf_assert_ok(write_text(path, false, "whole", &err), &err);
    assert_int_equal(entries(*state), 1);
    assert_contents(path, "whole");
}

static void a_name_as_long_as_names_can_be_works(void **state)
{
    lf_error err;
    char name[256];
    memset(name, 'n', 255);
    name[255] = 0;
    const char *path = lf_test_path(*state, name);
    lf_assert_ok(write_text(path, false, "x", &err), &err);
    lf_assert_ok(write_text(path, true, "y", &err), &err);
    assert_contents(path, "y");
    assert_int_equal(entries(*state), 1);
}

/* The limit on a file's size stands for a full disk. */
static void a_text_replaces_a_file_as_a_whole(void **state)
{
    char path[PATH_MAX];
    lf_error err;
    snprintf(path, sizeof path, "%s", lf_test_path(*state, "text"));
    lf_assert_ok(lf_outfile_text(path, "a first text\n", &err), &err);
    assert_contents(path, "a first text\n");
    lf_assert_ok(lf_outfile_text(path, "", &err), &err);
    assert_contents(path, "");
    lf_assert_status(lf_outfile_text(lf_test_path(*state, "absent/text"), "x", &err), LF_E_IO,
                     &err);
}

static void a_full_disk_is_an_error_and_leaves_nothing(void **state)
{
    lf_error err;
    struct rlimit before, small;
    char block[4096] = {0};
    const char *path = lf_test_write(*state, "out", "old");
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 6000;
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    lf_outfile file;
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    lf_status first = lf_outfile_write(&file, block, sizeof block, &err);
    lf_status second = lf_outfile_write(&file, block, sizeof block, &err);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, handler);
    lf_outfile_abandon(&file);
    lf_assert_status(first, LF_OK, NULL);
    lf_assert_status(second, LF_E_IO, NULL);
    assert_contents(path, "old");
    assert_int_equal(entries(*state), 1);
}

/* --------------------------------------------------------------- descriptors of other people -- */

static void an_adopted_descriptor_is_emptied_filled_and_closed(void **state)
{
    lf_error err;
    lf_outfile file;
    const char *path = lf_test_write(*state, "out", "what was there before");
    int fd = open(path, O_RDWR);
    assert_true(fd >= 0);
    lseek(fd, 5, SEEK_SET);
    lf_assert_ok(lf_outfile_adopt(&file, fd, &err), &err);
    assert_true(file.borrowed);
    lf_assert_ok(lf_outfile_write(&file, "new", 3, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, false, &err), &err);
    assert_contents(path, "new");
    assert_int_equal(fcntl(fd, F_GETFD), -1);
}

static void an_adopted_descriptor_given_up_is_empty(void **state)
{
    lf_error err;
    lf_outfile file;
    const char *path = lf_test_write(*state, "out", "");
    int fd = open(path, O_RDWR);
    lf_assert_ok(lf_outfile_adopt(&file, fd, &err), &err);
    lf_assert_ok(lf_outfile_write(&file, "half", 4, &err), &err);
    lf_outfile_abandon(&file);
    assert_contents(path, "");
    assert_int_equal(fcntl(fd, F_GETFD), -1);
}

static void descriptors_that_cannot_be_written_stay_their_owners(void **state)
{
    lf_error err;
    lf_outfile file;
    const char *path = lf_test_write(*state, "out", "kept");
    int ends[2], read_only = open(path, O_RDONLY), handle = open(path, O_PATH);
    assert_int_equal(pipe(ends), 0);
    const int bad[] = {read_only, handle, ends[1]};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lf_assert_status(lf_outfile_adopt(&file, bad[i], &err), LF_E_ARG, NULL);
        lf_outfile_abandon(&file);
        assert_int_not_equal(fcntl(bad[i], F_GETFD), -1);
        close(bad[i]);
    }
    lf_assert_status(lf_outfile_adopt(&file, 1000000, &err), LF_E_IO, NULL);
    close(ends[0]);
    assert_contents(path, "kept");
}

/* once with unnamed files, once without */
#define BOTH_WAYS(test)                                                                            \
    lf_test_in_folder(test),                                                                       \
    {                                                                                              \
#test " (named)", test, make_folder_named, remove_folder_named, NULL                       \
    }

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(a_file_is_read_whole_and_terminated),
        lf_test_in_folder(size_limits_hold),
        lf_test_in_folder(only_regular_files_are_opened),
        lf_test_in_folder(a_web_page_is_called_one),
        lf_test_in_folder(descriptors_are_not_inherited),
        lf_test_in_folder(reading_stays_beneath_the_roots),
        lf_test_in_folder(several_roots_add_up),
        lf_test_in_folder(roots_are_folders_and_not_endless),
        cmocka_unit_test(names_are_joined_and_taken_apart),
        BOTH_WAYS(a_file_appears_whole_with_the_commit),
        BOTH_WAYS(the_mode_follows_the_umask),
        BOTH_WAYS(an_abandoned_file_leaves_nothing),
        BOTH_WAYS(an_existing_file_is_kept_unless_asked),
        BOTH_WAYS(a_link_is_replaced_and_not_followed),
        BOTH_WAYS(what_is_not_a_file_is_not_replaced),
        BOTH_WAYS(a_name_as_long_as_names_can_be_works),
        BOTH_WAYS(a_text_replaces_a_file_as_a_whole),
        BOTH_WAYS(a_full_disk_is_an_error_and_leaves_nothing),
        {"a_named_file_lies_beside_until_the_commit", a_named_file_lies_beside_until_the_commit,
         make_folder_named, remove_folder_named, NULL},
        cmocka_unit_test_setup_teardown(leftovers_of_the_dead_go_and_of_the_living_stay,
                                        lf_test_folder_setup, remove_folder_named),
        cmocka_unit_test_setup_teardown(a_writer_killed_leaves_nothing_that_stays,
                                        lf_test_folder_setup, remove_folder_named),
        lf_test_in_folder(an_adopted_descriptor_is_emptied_filled_and_closed),
        lf_test_in_folder(an_adopted_descriptor_given_up_is_empty),
        lf_test_in_folder(descriptors_that_cannot_be_written_stay_their_owners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
