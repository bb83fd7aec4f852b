/* The folder of a fake reader (fake_reader.h) and of the files that it reads: how it is told what
 * to do, and what it tells. */
#ifndef LF_TESTS_FAKE_FOLDER_H
#define LF_TESTS_FAKE_FOLDER_H

#include "tests/testing.h"

#include <time.h>

#include "base/sandbox/import.h"

/* A file beside the mesh's: readers have no environment to be told by. */
static inline FILE *fake_beside(const lf_import_request *request, const char *name, const char *how)
{
    char path[PATH_MAX + 16];
    snprintf(path, sizeof path, "%.*s%s", (int)(strrchr(request->path, '/') + 1 - request->path),
             request->path, name);
    return fopen(path, how);
}

static inline void fake_note_pid(const lf_import_request *request)
{
    FILE *file = fake_beside(request, "pid", "w");
    if (!file)
        return;
    fprintf(file, "%d\n", (int)getpid());
    fclose(file);
}

/* A line for each reader that was begun: the file's name and the seconds that it was given. */
static inline void fake_note_start(const lf_import_request *request)
{
    FILE *file = fake_beside(request, "starts", "a");
    if (!file)
        return;
    fprintf(file, "%s %u\n", strrchr(request->path, '/') + 1, request->seconds);
    fclose(file);
}

/* What the file "mode-NAME" says of the file NAME, else what "mode" says of all. */
static inline bool fake_mode(const lf_import_request *request, char mode[128])
{
    char name[PATH_MAX + 8];
    snprintf(name, sizeof name, "mode-%s", strrchr(request->path, '/') + 1);
    FILE *file = fake_beside(request, name, "r");
    if (!file)
        file = fake_beside(request, "mode", "r");
    bool told = file && fgets(mode, 128, file);
    if (file)
        fclose(file);
    return told;
}

/* "nap-MODE": takes a second longer. */
static inline const char *fake_nap(const char *mode)
{
    if (strncmp(mode, "nap-", 4) != 0)
        return mode;
    nanosleep(&(struct timespec){.tv_sec = 1, .tv_nsec = 100000000}, NULL);
    return mode + 4;
}

/* From here on files are read by this program, as the file "mode" of the folder says; mode NULL: by
 * quiltimport again. */
static inline void fake_use(const char *folder, const char *mode)
{
    static char real[PATH_MAX];
    char self[PATH_MAX] = "";
    if (!real[0])
        snprintf(real, sizeof real, "%s", getenv("QUILTIMPORT"));
    setenv("QUILTIMPORT", mode ? folder : real, 1);
    if (!mode)
        return;
    lf_test_write(folder, "mode", mode);
    assert_true(readlink("/proc/self/exe", self, sizeof self - 1) > 0);
    static const char *const names[] = {"quiltimport", "quiltimport-vdb", "quiltimport-picture"};
    for (int i = 0; i < 3; i++) {
        const char *name = lf_test_path(folder, names[i]);
        (void)unlink(name);
        assert_int_equal(symlink(self, name), 0);
    }
}

#endif
