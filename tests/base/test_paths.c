/* The paths rule, with the kernel's own mechanism and with what stands in for it where a sandbox
 * forbids that one; and the same while somebody swaps names between check and use. Every case runs
 * in a process of its own, because a sandbox cannot be left. */
#include "tests/testing.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/openat2.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <signal.h>
#include <stddef.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include "base/alloc.h"
#include "base/file.h"

/* Of a race: so many of either outcome are wanted, in so many attempts at most. */
enum { ENOUGH = 30, ATTEMPTS = 2000000, SKIPPED = 77 };

static int make_folder(void **state)
{
    *state = lf_test_folder();
    return 0;
}

static int remove_folder(void **state)
{
    lf_test_folder_remove(*state);
    return 0;
}

/* -------------------------------------------------------------------------------- mechanisms -- */

/* openat2 fails with `why` from now on; false: this system has no such sandbox. */
static bool forbid_openat2(int why)
{
    struct sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_openat2, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | (uint32_t)why),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    struct sock_fprog program = {.len = sizeof filter / sizeof *filter, .filter = filter};
    struct open_how how = {.flags = O_PATH};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0 &&
           syscall(SYS_openat2, AT_FDCWD, "/", &how, sizeof how) < 0 && errno == why;
}

/* Runs the case in a process of its own, first as the system is, then without openat2 as an older
 * kernel is without it, and as sandboxes forbid it. The case returns what went wrong; NULL =
 * nothing. */
static void with_every_mechanism(const char *folder, const char *(*run)(const char *folder))
{
    static const int why[] = {0, ENOSYS, EPERM};
    for (size_t i = 0; i < sizeof why / sizeof *why; i++) {
        fflush(NULL);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            if (why[i] != 0 && !forbid_openat2(why[i]))
                _exit(SKIPPED);
            const char *wrong = run(folder);
            if (wrong)
                fprintf(stderr, "openat2 %s: %s\n", why[i] != 0 ? strerror(why[i]) : "as it is",
                        wrong);
            _exit(wrong ? 1 : 0);
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFEXITED(status));
        if (WEXITSTATUS(status) == SKIPPED)
            print_message("no sandbox here: the stand-in is tried by itself alone\n");
        else
            assert_int_equal(WEXITSTATUS(status), 0);
    }
}

/* in/file, in/sub/file, in/twin/file; out/file; in/link -> ../out, in/inside -> sub, root -> in */
static void make_tree(const char *folder)
{
    static const char *const folders[] = {"in", "in/sub", "in/twin", "out"};
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++)
        assert_int_equal(mkdir(lf_test_path(folder, folders[i]), 0700), 0);
    lf_test_write(folder, "in/file", "inside");
    lf_test_write(folder, "in/sub/file", "inside");
    lf_test_write(folder, "in/twin/file", "inside");
    lf_test_write(folder, "out/file", "secret");
    assert_int_equal(symlink("../out", lf_test_path(folder, "in/link")), 0);
    assert_int_equal(symlink("sub", lf_test_path(folder, "in/inside")), 0);
    assert_int_equal(symlink("in", lf_test_path(folder, "root")), 0);
}

static bool make_roots(const char *folder, lf_roots *out)
{
    *out = (lf_roots){0};
    return lf_roots_add(out, lf_test_path(folder, "root"), NULL) == LF_OK;
}

/* ----------------------------------------------------------------------------- the mechanism -- */

typedef int (*open_fn)(int folder_fd, const char *name, int flags);

static const char *check_mechanism(const char *folder, open_fn open_name)
{
    static const struct {
        const char *name;
        int flags, why; /* 0 = opens */
    } cases[] = {{"file", O_RDONLY, 0},
                 {"sub/file", O_RDONLY, 0},
                 {"sub", O_PATH | O_DIRECTORY, 0},
                 {".", O_PATH, 0},
                 {"absent", O_RDONLY, ENOENT},
                 {"absent/file", O_RDONLY, ENOENT},
                 {"file/file", O_RDONLY, ENOTDIR},
                 {"", O_RDONLY, EXDEV},
                 {"/etc/passwd", O_RDONLY, EXDEV},
                 {"../out/file", O_RDONLY, EXDEV},
                 {"sub/../file", O_RDONLY, EXDEV},
                 {"./file", O_RDONLY, EXDEV},
                 {"sub//file", O_RDONLY, EXDEV},
                 {"sub/", O_PATH, EXDEV},
                 {"..", O_PATH, EXDEV},
                 {"inside", O_PATH, ELOOP},
                 {"link", O_PATH, ELOOP},
                 {"link", O_PATH | O_NOFOLLOW, ELOOP},
                 {"link", O_RDONLY, ELOOP}};
    static char wrong[128];
    int at = open(lf_test_path(folder, "in"), O_PATH | O_DIRECTORY);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int fd = open_name(at, cases[i].name, cases[i].flags), why = fd < 0 ? errno : 0;
        bool link_flags = fd >= 0 && (fcntl(fd, F_GETFD) & FD_CLOEXEC) == 0;
        if (why != cases[i].why || link_flags) {
            snprintf(wrong, sizeof wrong, "\"%s\": %s", cases[i].name, strerror(why));
            return wrong;
        }
        if (fd >= 0)
            close(fd);
    }
    /* a folder that is a link: the two may say it differently */
    if (open_name(at, "inside/file", O_RDONLY) >= 0 || open_name(at, "link/file", O_RDONLY) >= 0)
        return "a link was followed";
    close(at);
    return NULL;
}

static const char *open_opens_what_it_should(const char *folder)
{
    return check_mechanism(folder, lf_beneath_open);
}

static void names_open_beneath_a_folder_and_links_do_not(void **state)
{
    make_tree(*state);
    with_every_mechanism(*state, open_opens_what_it_should);
    const char *wrong = check_mechanism(*state, lf_beneath_walk);
    if (wrong)
        fail_msg("the stand-in: %s", wrong);
}

/* ----------------------------------------------------------------------------------- reading -- */

static const char *reads_are_as_told(const char *folder)
{
    static const struct {
        const char *name;
        lf_status expected;
    } cases[] = {
        {"in/file", LF_OK},        {"root/sub/file", LF_OK},    {"in/inside/file", LF_OK},
        {"out/../in/file", LF_OK}, {"in/absent", LF_E_IO},      {"in/sub", LF_E_FORMAT},
        {"in", LF_E_FORMAT},       {"in/link/file", LF_E_PATH}, {"in/link/absent", LF_E_PATH},
        {"out/file", LF_E_PATH},   {"out", LF_E_PATH},          {"", LF_E_PATH}};
    lf_roots roots;
    if (!make_roots(folder, &roots))
        return "no roots";
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int fd = -1;
        if (lf_roots_open(&roots, lf_test_path(folder, cases[i].name), &fd, NULL) !=
            cases[i].expected)
            return cases[i].name;
        if ((fd >= 0) != (cases[i].expected == LF_OK))
            return "a descriptor where there is none, or none";
        if (fd >= 0)
            close(fd);
    }
    lf_roots_finish(&roots);
    return NULL;
}

static void reading_stays_beneath_the_roots(void **state)
{
    make_tree(*state);
    with_every_mechanism(*state, reads_are_as_told);
}

static const char *folders_are_as_told(const char *folder)
{
    static const struct {
        const char *name;
        lf_status expected, anywhere;
    } cases[] = {{"in", LF_OK, LF_OK},
                 {"in/sub", LF_OK, LF_OK},
                 {"in/inside/", LF_OK, LF_OK},
                 {"in/file", LF_E_FORMAT, LF_E_IO},
                 {"in/absent", LF_E_IO, LF_E_IO},
                 {"in/link", LF_E_PATH, LF_OK},
                 {"in/link/absent", LF_E_PATH, LF_E_IO},
                 {"out", LF_E_PATH, LF_OK}};
    lf_roots roots, none = {0};
    if (!make_roots(folder, &roots))
        return "no roots";
    const lf_roots *const where[] = {&roots, &none, NULL};
    for (size_t i = 0; i < 3 * sizeof cases / sizeof *cases; i++) {
        const char *name = cases[i / 3].name;
        int fd = -1;
        if (lf_roots_open_folder(where[i % 3], lf_test_path(folder, name), &fd, NULL) !=
            (i % 3 == 0 ? cases[i / 3].expected : cases[i / 3].anywhere))
            return name;
        if (fd >= 0)
            close(fd);
    }
    lf_roots_finish(&roots);
    return NULL;
}

static void folders_are_listed_beneath_the_roots(void **state)
{
    make_tree(*state);
    with_every_mechanism(*state, folders_are_as_told);
}

static void a_name_is_resolved_where_it_may_be_read(void **state)
{
    lf_roots roots;
    lf_error err;
    char *path = NULL;
    make_tree(*state);
    assert_true(make_roots(*state, &roots));
    lf_assert_ok(lf_roots_resolve(&roots, lf_test_path(*state, "root/inside/file"), &path, &err),
                 &err);
    assert_string_equal(path + strlen(path) - strlen("/in/sub/file"), "/in/sub/file");
    lf_free(path);
    lf_assert_ok(lf_roots_resolve(&roots, lf_test_path(*state, "in"), &path, &err), &err);
    lf_free(path);
    path = NULL;
    lf_assert_status(lf_roots_resolve(&roots, lf_test_path(*state, "in/no"), &path, &err), LF_E_IO,
                     NULL);
    lf_assert_status(lf_roots_resolve(&roots, lf_test_path(*state, "out/no"), &path, &err),
                     LF_E_PATH, NULL);
    lf_assert_status(lf_roots_resolve(&roots, lf_test_path(*state, "in/link"), &path, &err),
                     LF_E_PATH, NULL);
    assert_null(path);
    lf_roots_finish(&roots);
}

/* Pairs of names outside of in/, the first of something that is there and the second not. */
static const char *const outside[][2] = {
    {"out/file", "out/absent"},
    {"out/file/x", "absent/x"},
    {"out/sub/x", "out/absent/x"},
    {"in/link/file", "in/nowhere/file"},
    {"in/link", "in/nowhere"},
    {"in/../out/file", "in/../absent/file"},
    {"out/../out/sub/x", "absent/../absent/x"},
    {"out/.././out//sub/x", "absent/.././absent//x"},
};

/* Names that lead through what is outside and come back. */
static const char *const back[][2] = {
    {"out/../in/file", "absent/../in/file"},
    {"out/sub/../../in/file", "out/absent/../../in/file"},
    {"out/file/../../in/file", "absent/absent/../../in/file"},
    {"out/../in/absent", "absent/../in/absent"},
    {"in/../out/../in/sub/file", "in/../absent/../in/sub/file"},
};

static void make_outside(const char *folder)
{
    make_tree(folder);
    assert_int_equal(mkdir(lf_test_path(folder, "out/sub"), 0700), 0);
    assert_int_equal(symlink("../absent", lf_test_path(folder, "in/nowhere")), 0);
}

typedef lf_status (*try_fn)(const char *folder, const char *name, lf_error *err);

static lf_status try_resolve(const char *folder, const char *name, lf_error *err)
{
    lf_roots roots;
    char *path = NULL;
    assert_true(make_roots(folder, &roots));
    lf_status status = lf_roots_resolve(&roots, lf_test_path(folder, name), &path, err);
    lf_free(path);
    lf_roots_finish(&roots);
    return status;
}

static lf_status try_open(const char *folder, const char *name, lf_error *err)
{
    lf_roots roots;
    int fd;
    assert_true(make_roots(folder, &roots));
    lf_status status = lf_roots_open(&roots, lf_test_path(folder, name), &fd, err);
    if (status == LF_OK)
        close(fd);
    lf_roots_finish(&roots);
    return status;
}

static lf_status try_open_folder(const char *folder, const char *name, lf_error *err)
{
    lf_roots roots;
    int fd;
    assert_true(make_roots(folder, &roots));
    lf_status status = lf_roots_open_folder(&roots, lf_test_path(folder, name), &fd, err);
    if (status == LF_OK)
        close(fd);
    lf_roots_finish(&roots);
    return status;
}

static lf_status try_hold(const char *folder, const char *name, lf_error *err)
{
    char root[PATH_MAX];
    lf_held_name held = {.folder_fd = -1};
    assert_non_null(realpath(lf_test_path(folder, "in"), root));
    lf_status status =
        lf_held_name_open(root, "--export-dir", lf_test_path(folder, name), &held, err);
    lf_held_name_finish(&held);
    return status;
}

/* The same status and the same words for both; not LF_OK where they are outside. */
static void assert_alike(const char *folder, try_fn attempt, const char *const pair[2],
                         bool is_outside)
{
    lf_error there = {0}, absent = {0};
    lf_status one = attempt(folder, pair[0], &there), other = attempt(folder, pair[1], &absent);
    if (one != other || (one != LF_OK && strcmp(there.what, absent.what) != 0) ||
        (is_outside && one != LF_E_PATH))
        fail_msg("%s: %d %s; %s: %d %s", pair[0], (int)one, there.what, pair[1], (int)other,
                 absent.what);
}

static void what_is_outside_is_told_the_same_whether_it_exists_or_not(void **state)
{
    const char *folder = *state;
    static const try_fn attempts[] = {try_resolve, try_open, try_open_folder, try_hold};
    make_outside(folder);
    for (size_t i = 0; i < sizeof attempts / sizeof *attempts; i++) {
        for (size_t k = 0; k < sizeof outside / sizeof *outside; k++) {
            /* in/link itself is a name in a folder that may be written to */
            bool named = attempts[i] == try_hold && strcmp(outside[k][0], "in/link") == 0;
            assert_alike(folder, attempts[i], outside[k], !named);
        }
        for (size_t k = 0; k < sizeof back / sizeof *back; k++)
            assert_alike(folder, attempts[i], back[k], false);
    }
    /* what is inside is told as it is */
    lf_error err;
    assert_int_equal(try_open(folder, "in/absent", &err), LF_E_IO);
    assert_int_equal(try_open(folder, "in/sub/../file", &err), LF_OK);
    assert_int_equal(try_open(folder, "in/inside/../file", &err), LF_OK);
    assert_int_equal(try_open(folder, "root/sub/../file", &err), LF_OK);
    assert_int_equal(try_open(folder, "out/../in/file", &err), LF_OK);
}

/* ----------------------------------------------------------------------------------- writing -- */

static void a_name_to_be_written_is_one_line_with_something_before_its_ending(void **state)
{
    static const char *const odd[] = {"x\ny.png",          "x\ry.png", "\x1b[2Jx.png",
                                      "x\x7f.png",         "a\tb.png", "x\xc2\x85y.png",
                                      "x\xe2\x80\xa8y.png"};
    static const char *const bare[] = {".png", "in/.png", "..png", "/tmp/...png"};
    static const char *const fine[] = {"x.png", ".x.png", "a b.png", "\xc3\xa9\xe2\x80\x94.png",
                                       "in/.a/x.png"};
    lf_error err;
    char root[PATH_MAX];
    lf_held_name held = {.folder_fd = -1};
    make_tree(*state);
    assert_non_null(realpath(lf_test_path(*state, "in"), root));
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        lf_assert_status(lf_check_name(odd[i], &err), LF_E_ARG, NULL);
        lf_assert_status(lf_check_stem(odd[i], ".png", &err), LF_E_ARG, NULL);
        lf_assert_status(lf_held_name_open(root, "--export-dir", odd[i], &held, &err), LF_E_ARG,
                         NULL);
    }
    for (size_t i = 0; i < sizeof bare / sizeof *bare; i++)
        lf_assert_status(lf_check_stem(bare[i], ".png", &err), LF_E_ARG, NULL);
    for (size_t i = 0; i < sizeof fine / sizeof *fine; i++)
        lf_assert_ok(lf_check_stem(fine[i], ".png", &err), &err);
}

static const char *writes_are_as_told(const char *folder)
{
    static const struct {
        const char *name;
        bool allowed;
    } cases[] = {{"in/new", true},         {"in/file", true},
                 {"root/sub/new", true},   {"in/sub/new/", true},
                 {"in/sub", true},         {"in/inside/new", true},
                 {"in/link", false},       {"in/inside", false},
                 {"in/link/new", false},   {"in/absent/new", false},
                 {"out/new", false},       {"in/..", false},
                 {"in/.", false},          {"in", false},
                 {"in/../out/new", false}, {"", false}};
    char root[PATH_MAX];
    if (!realpath(lf_test_path(folder, "in"), root))
        return "no root";
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_held_name held = {.folder_fd = -1};
        lf_error err;
        lf_status status = lf_held_name_open(root, "--export-dir",
                                             lf_test_path(folder, cases[i].name), &held, &err);
        if (status != (cases[i].allowed ? LF_OK : LF_E_PATH))
            return cases[i].name;
        if (cases[i].allowed && strncmp(held.path, root, strlen(root)) != 0)
            return "a name that is not told as it is";
        lf_held_name_finish(&held);
        lf_held_name_finish(&held);
    }
    return NULL;
}

static void writing_stays_beneath_its_folder(void **state)
{
    make_tree(*state);
    with_every_mechanism(*state, writes_are_as_told);
}

static void assert_refused(const char *root, const char *path, const char *why)
{
    lf_held_name held = {.folder_fd = -1};
    lf_error err = {0};
    assert_int_equal(lf_held_name_open(root, "--export-dir", path, &held, &err), LF_E_PATH);
    if (!strstr(err.what, why))
        fail_msg("\"%s\" does not say \"%s\"", err.what, why);
}

static void a_name_that_may_not_be_written_is_told_why(void **state)
{
    char root[PATH_MAX];
    struct rlimit before, none = {0};
    make_tree(*state);
    assert_non_null(realpath(lf_test_path(*state, "in"), root));
    assert_refused(root, "../out/new", "outside the --export-dir");
    assert_refused(root, "link/new", "outside the --export-dir");
    assert_refused(root, "link", "symbolic links are not overwritten; use another name");
    assert_refused(root, "absent/new", "No such file or directory");
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &before), 0);
    none.rlim_max = before.rlim_max;
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &none), 0);
    assert_refused(root, "sub/new", "Too many open files");
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &before), 0);
}

/* ------------------------------------------------------------------------------------- races -- */

/* Swaps the folder in/sub and the link in/link over and over, in a process of its own. */
static pid_t begin_swapping(const char *folder)
{
    char one[PATH_MAX], other[PATH_MAX];
    snprintf(one, sizeof one, "%s", lf_test_path(folder, "in/sub"));
    snprintf(other, sizeof other, "%s", lf_test_path(folder, "in/link"));
    pid_t child = fork();
    if (child == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        while (renameat2(AT_FDCWD, one, AT_FDCWD, other, RENAME_EXCHANGE) == 0)
            continue;
        _exit(0);
    }
    return child;
}

static void end_swapping(pid_t child)
{
    if (child > 0) {
        kill(child, SIGKILL);
        waitpid(child, NULL, 0);
    }
}

/* Repeats an attempt, which says whether it was refused, until enough have gone either way. */
static const char *attempt(bool (*once)(const char *root, const char *path), const char *folder,
                           const char *name)
{
    char root[PATH_MAX], path[PATH_MAX], made[PATH_MAX];
    int n[2] = {0, 0};
    if (!realpath(lf_test_path(folder, "in"), root))
        return "no root";
    snprintf(path, sizeof path, "%s", lf_test_path(folder, name));
    snprintf(made, sizeof made, "%s", lf_test_path(folder, "out/new"));
    for (int i = 0; i < ATTEMPTS && (n[0] < ENOUGH || n[1] < ENOUGH); i++) {
        n[once(root, path)]++;
        sched_yield();
    }
    if (access(made, F_OK) == 0)
        return "a file outside was written";
    return n[0] >= ENOUGH && n[1] >= ENOUGH ? NULL : "nothing was swapped";
}

static void assert_inside(int fd)
{
    char text[16] = "";
    ssize_t n = read(fd, text, sizeof text - 1);
    close(fd);
    if (n < 0 || strcmp(text, "inside") != 0) {
        fprintf(stderr, "a file outside was read\n");
        _exit(1);
    }
}

static bool open_once(lf_status (*open_it)(const lf_roots *, const char *, int *, lf_error *),
                      const char *root, const char *path, int *out_fd)
{
    lf_roots roots = {0};
    if (lf_roots_add(&roots, root, NULL) != LF_OK)
        return false;
    bool opened = open_it(&roots, path, out_fd, NULL) == LF_OK;
    lf_roots_finish(&roots);
    return opened;
}

static bool read_once(const char *root, const char *path)
{
    int fd;
    if (!open_once(lf_roots_open, root, path, &fd))
        return false;
    assert_inside(fd);
    return true;
}

static bool open_folder_once(const char *root, const char *path)
{
    int fd;
    if (!open_once(lf_roots_open_folder, root, path, &fd))
        return false;
    assert_inside(openat(fd, "file", O_RDONLY));
    close(fd);
    return true;
}

static bool write_held(int folder_fd)
{
    char *name = lf_held_path(folder_fd, "new");
    bool written = name && lf_outfile_text(name, "text", NULL) == LF_OK;
    lf_free(name);
    return written;
}

static bool write_once(const char *root, const char *path)
{
    lf_held_name held = {.folder_fd = -1};
    bool written = lf_held_name_open(root, "--export-dir", path, &held, NULL) == LF_OK &&
                   write_held(held.folder_fd);
    lf_held_name_finish(&held);
    return written;
}

/* A folder of views, which is a link every other moment. */
static bool write_into_folder_once(const char *root, const char *path)
{
    lf_held_name held = {.folder_fd = -1};
    int fd = -1;
    bool made, written = lf_held_name_open(root, "--export-dir", path, &held, NULL) == LF_OK &&
                         lf_held_folder(held.folder_fd, "sub", &fd, &made, NULL) == LF_OK &&
                         write_held(fd);
    if (fd >= 0)
        close(fd);
    lf_held_name_finish(&held);
    return written;
}

static const char *read_while_swapped(const char *folder)
{
    return attempt(read_once, folder, "in/sub/file");
}

static const char *open_folder_while_swapped(const char *folder)
{
    return attempt(open_folder_once, folder, "in/sub");
}

static const char *write_while_swapped(const char *folder)
{
    return attempt(write_once, folder, "in/sub/new");
}

static const char *write_into_folder_while_swapped(const char *folder)
{
    return attempt(write_into_folder_once, folder, "in/sub/");
}

static void race(const char *folder, const char *(*run)(const char *folder))
{
    make_tree(folder);
    if (renameat2(AT_FDCWD, lf_test_path(folder, "in/sub"), AT_FDCWD,
                  lf_test_path(folder, "in/link"), RENAME_EXCHANGE) != 0) {
        print_message("this file system cannot swap two names\n");
        skip();
    }
    pid_t swapper = begin_swapping(folder);
    assert_true(swapper > 0);
    with_every_mechanism(folder, run);
    end_swapping(swapper);
}

static void a_name_swapped_while_it_is_read_leads_nowhere(void **state)
{
    race(*state, read_while_swapped);
}

static void a_folder_swapped_while_it_is_opened_leads_nowhere(void **state)
{
    race(*state, open_folder_while_swapped);
}

static void a_name_swapped_while_it_is_written_leads_nowhere(void **state)
{
    race(*state, write_while_swapped);
}

static void a_folder_swapped_while_it_is_written_into_leads_nowhere(void **state)
{
    race(*state, write_into_folder_while_swapped);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(names_open_beneath_a_folder_and_links_do_not, make_folder,
                                        remove_folder),
        cmocka_unit_test_setup_teardown(reading_stays_beneath_the_roots, make_folder,
                                        remove_folder),
        cmocka_unit_test_setup_teardown(folders_are_listed_beneath_the_roots, make_folder,
                                        remove_folder),
        cmocka_unit_test_setup_teardown(a_name_is_resolved_where_it_may_be_read, make_folder,
                                        remove_folder),
        cmocka_unit_test_setup_teardown(what_is_outside_is_told_the_same_whether_it_exists_or_not,
                                        make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(
            a_name_to_be_written_is_one_line_with_something_before_its_ending, make_folder,
            remove_folder),
        cmocka_unit_test_setup_teardown(writing_stays_beneath_its_folder, make_folder,
                                        remove_folder),
        cmocka_unit_test_setup_teardown(a_name_that_may_not_be_written_is_told_why, make_folder,
                                        remove_folder),
        cmocka_unit_test_setup_teardown(a_name_swapped_while_it_is_read_leads_nowhere, make_folder,
                                        remove_folder),
        cmocka_unit_test_setup_teardown(a_folder_swapped_while_it_is_opened_leads_nowhere,
                                        make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(a_name_swapped_while_it_is_written_leads_nowhere,
                                        make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(a_folder_swapped_while_it_is_written_into_leads_nowhere,
                                        make_folder, remove_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
