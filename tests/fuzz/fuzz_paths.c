/* Names beneath a folder with links in it: as bytes, and as parts of the folder's own names, so
 * that what is there is met. The kernel's mechanism and its stand-in open the same, and neither
 * reading nor writing leads outside. */
#include "tests/fuzz/fuzz.h"

#include <fcntl.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/paths.h"

static char top[] = "/tmp/fuzz_paths.XXXXXX", root[sizeof top + 8], outside[sizeof top + 8];
static int root_fd;
static lf_roots roots;

static void make_link(const char *target, const char *name)
{
    lf_fuzz_require(symlinkat(target, root_fd, name) == 0);
}

static void make_file(int folder_fd, const char *name)
{
    int fd = openat(folder_fd, name, O_WRONLY | O_CREAT | O_EXCL, 0600);
    lf_fuzz_require(fd >= 0);
    close(fd);
}

static void remove_tree(void)
{
    char command[sizeof top + 16];
    snprintf(command, sizeof command, "rm -rf %s", top);
    lf_fuzz_require(system(command) == 0);
}

/* in/a, in/s/a, in/s/t/a, out/a; links in/l -> ../out, in/m -> s, in/n -> /, in/o -> o */
static void make_tree(void)
{
    lf_fuzz_require(mkdtemp(top));
    atexit(remove_tree);
    snprintf(root, sizeof root, "%s/in", top);
    snprintf(outside, sizeof outside, "%s/out", top);
    lf_fuzz_require(mkdir(root, 0700) == 0 && mkdir(outside, 0700) == 0);
    root_fd = open(root, O_RDONLY | O_DIRECTORY);
    int outside_fd = open(outside, O_RDONLY | O_DIRECTORY);
    lf_fuzz_require(mkdirat(root_fd, "s", 0700) == 0 && mkdirat(root_fd, "s/t", 0700) == 0);
    make_file(root_fd, "a");
    make_file(root_fd, "s/a");
    make_file(root_fd, "s/t/a");
    make_file(outside_fd, "a");
    make_link("../out", "l");
    make_link("s", "m");
    make_link("/", "n");
    make_link("o", "o");
    close(outside_fd);
    lf_fuzz_require(lf_roots_add(&roots, root, NULL) == LF_OK);
}

/* Where a descriptor's file lies, as the kernel tells it. */
static bool lies_inside(int fd)
{
    char link[64], name[PATH_MAX] = "";
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t n = readlink(link, name, sizeof name - 1);
    return n > 0 && strncmp(name, root, strlen(root)) == 0 &&
           (name[strlen(root)] == '/' || name[strlen(root)] == '\0');
}

static void check_mechanisms(const char *name)
{
    struct stat one, other;
    int fd = lf_beneath_open(root_fd, name, O_PATH),
        walked = lf_beneath_walk(root_fd, name, O_PATH);
    lf_fuzz_require((fd >= 0) == (walked >= 0));
    if (fd < 0)
        return;
    lf_fuzz_require(lies_inside(fd) && lies_inside(walked));
    lf_fuzz_require(fstat(fd, &one) == 0 && fstat(walked, &other) == 0);
    lf_fuzz_require(one.st_ino == other.st_ino && one.st_dev == other.st_dev);
    close(fd);
    close(walked);
}

static void check_rule(const char *path)
{
    lf_error err = {0};
    lf_held_name held = {.folder_fd = -1};
    char *resolved = NULL;
    int fd = -1;
    lf_status status = lf_roots_open(&roots, path, &fd, &err);
    lf_fuzz_require_text(err.what);
    lf_fuzz_require((status == LF_OK) == (fd >= 0));
    if (fd >= 0) {
        lf_fuzz_require(lies_inside(fd));
        close(fd);
    }
    if (lf_roots_resolve(&roots, path, &resolved, &err) == LF_OK)
        lf_fuzz_require(strncmp(resolved, root, strlen(root)) == 0);
    lf_free(resolved);
    if (lf_held_name_open(root, "--export-dir", path, &held, &err) == LF_OK) {
        lf_fuzz_require(lies_inside(held.folder_fd));
        lf_fuzz_require(strncmp(held.path, root, strlen(root)) == 0);
    }
    lf_held_name_finish(&held);
}

/* Bytes, or from 'A' on parts of names that are there. */
static void make_name(const uint8_t *data, size_t size, char *out, size_t out_size)
{
    static const char *const parts[] = {"a", "s", "t", "l", "m", "n", "o", "..", ".", "/", "out"};
    size_t n = 0;
    for (size_t i = 0; i < size && n + 8 < out_size; i++) {
        const char *part = data[i] >= 'A' && data[i] < 'A' + 11 ? parts[data[i] - 'A'] : NULL;
        if (part)
            n += (size_t)snprintf(out + n, out_size - n, "%s", part);
        else
            out[n++] = (char)data[i];
    }
    out[n] = '\0';
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char name[1024], path[sizeof name + sizeof root + 1];
    if (root_fd == 0)
        make_tree();
    make_name(data, size, name, sizeof name);
    check_mechanisms(name);
    snprintf(path, sizeof path, "%s/%s", root, name);
    check_rule(path);
    if (name[0] == '/')
        check_rule(name);
    return 0;
}
