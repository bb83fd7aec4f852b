/* What readers that run at once may take together, and what each has given up. This program is
 * started as a reader of its own, too. */
#include "tests/render/fake_reader.h"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <stddef.h>
#include <sys/file.h>
#include <sys/wait.h>

#include "base/sandbox/import_group.h"
#include "render/import/scene/mesh_import.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED true
#else
#define SANITIZED false
#endif

enum { MIB = 1 << 20 };

/* --------------------------------------------------------------------------------- as reader -- */

/* Notes what it may have, in MiB, and gets on with no less than `needed`. One that has the whole is
 * alone: others hold a lock that it cannot have. */
static _Noreturn void take_share(const lf_import_request *request, const char *needed)
{
    const uint64_t memory = request->memory / MIB, whole = 1024;
    FILE *told = fake_beside(request, "told", "a"), *lock = fake_beside(request, "lock", "a");
    if (!told || !lock)
        fake_say("no file");
    fprintf(told, "%d ", (int)memory);
    fclose(told);
    if (flock(fileno(lock), (memory == whole ? LOCK_EX : LOCK_SH) | LOCK_NB) != 0)
        fake_say("it is not alone");
    usleep(20000); /* for others to meet it */
    if (memory < strtoull(needed, NULL, 10))
        fake_last(LF_IMPORT_FAILED, LF_E_NOMEM, "too little", -1);
    fake_say("enough");
}

/* Ends without a word, as libraries do that get no memory. */
static _Noreturn void die_of_less(const lf_import_request *request)
{
    if (request->memory / MIB < 1024)
        abort();
    fake_say("enough");
}

/* A line of a file of /proc about this process once it is confined. */
static _Noreturn void confined_line(const char *file, const char *const begin[])
{
    char text[4096] = "", said[512] = "";
    lf_landlock landlock;
    int fd = open(file, O_RDONLY | O_CLOEXEC);
    if (lf_confine((uint64_t)300 * MIB, 60, &landlock, NULL) != LF_OK)
        fake_say("not confined");
    ssize_t n = pread(fd, text, sizeof text - 1, 0);
    for (char *line = n > 0 ? strtok(text, "\n") : NULL; line; line = strtok(NULL, "\n"))
        for (int i = 0; begin[i]; i++)
            if (strncmp(line, begin[i], strlen(begin[i])) == 0)
                snprintf(said + strlen(said), sizeof said - strlen(said), "%s;", line);
    fake_say(said);
}

static int read_as_told(void)
{
    static const char *const sets[] = {"CapInh", "CapPrm",     "CapEff", "CapBnd",
                                       "CapAmb", "NoNewPrivs", NULL},
                             *const limits[] = {"Max file size", "Max address space", NULL};
    char mode[64] = "";
    lf_import_request request;
    int fd;
    if (lf_import_receive(LF_IMPORT_SOCKET, &request, sizeof request, &fd) != LF_OK)
        return 3;
    FILE *file = fake_beside(&request, "mode", "r");
    if (!file || !fgets(mode, sizeof mode, file))
        return 3;
    if (strcmp(mode, "dies") == 0)
        die_of_less(&request);
    if (strcmp(mode, "capabilities") == 0)
        confined_line("/proc/self/status", sets);
    if (strcmp(mode, "limits") == 0)
        confined_line("/proc/self/limits", limits);
    take_share(&request, mode);
}

/* ---------------------------------------------------------------------------------- as asker -- */

/* From here on files in the folder are read by this program, as mode says; NULL: by quiltimport. */
static void use_reader(const char *folder, const char *mode)
{
    static char real[PATH_MAX];
    char self[PATH_MAX] = "";
    if (!real[0])
        snprintf(real, sizeof real, "%s", getenv("QUILTIMPORT"));
    setenv("QUILTIMPORT", mode ? folder : real, 1);
    lf_test_write(folder, "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    if (!mode)
        return;
    lf_test_write(folder, "mode", mode);
    assert_true(readlink("/proc/self/exe", self, sizeof self - 1) > 0);
    (void)unlink(lf_test_path(folder, "quiltimport"));
    assert_int_equal(symlink(self, lf_test_path(folder, "quiltimport")), 0);
}

typedef struct importing {
    const char *folder;
    lf_status status;
    lf_error err;
} importing;

static void *import_one(void *context)
{
    importing *one = context;
    lf_mesh_desc desc = {.name = "m", .file = "a.obj", .transform = lf_affine_identity()};
    lf_mesh_data data = {0};
    one->status = lf_mesh_import(&desc, one->folder, NULL, &data, &one->err);
    lf_mesh_data_finish(&data);
    return NULL;
}

/* Reads by this program; what it said. */
static const char *said_by(const char *folder, const char *mode)
{
    importing one = {.folder = folder};
    char *said = lf_test_buffer();
    use_reader(folder, mode);
    (void)import_one(&one);
    use_reader(folder, NULL);
    assert_int_not_equal(one.status, LF_OK);
    snprintf(said, PATH_MAX, "%s", one.err.what);
    return said;
}

/* What the readers were given one after the other. */
static const char *told(const char *folder)
{
    char *text = lf_test_buffer();
    FILE *file = fopen(lf_test_path(folder, "told"), "r");
    text[0] = '\0';
    if (file && !fgets(text, PATH_MAX, file))
        text[0] = '\0';
    if (file)
        fclose(file);
    (void)unlink(lf_test_path(folder, "told"));
    return text;
}

static void count_ends(void *context, const lf_import_progress *progress)
{
    *(int *)context += progress->ended ? 1 : 0;
}

static void a_file_has_its_part_first_and_then_the_whole_alone(void **state)
{
    const char *folder = *state;
    int ends = 0;
    lf_import_watch(count_ends, &ends);
    lf_import_limit((uint64_t)1024 * MIB, 120);
    assert_string_equal(said_by(folder, "1000"), "enough"); /* alone from the beginning */
    assert_string_equal(told(folder), "1024 ");
    lf_import_expect(3);
    assert_string_equal(said_by(folder, "200"), "enough");
    assert_string_equal(told(folder), "256 ");
    assert_string_equal(said_by(folder, "1000"), "enough");
    assert_string_equal(told(folder), "256 1024 ");
    assert_string_equal(said_by(folder, "2000"), "too little");
    assert_string_equal(told(folder), "256 1024 ");
    assert_string_equal(said_by(folder, "dies"), "enough");
    /* a part that no reader can start with is none */
    lf_import_expect(4);
    assert_string_equal(said_by(folder, "1000"), "enough");
    assert_string_equal(told(folder), "1024 ");
    lf_import_expect(-7);
    lf_import_limit(0, 120);
    lf_import_watch(NULL, NULL);
    assert_int_equal(ends, 6); /* of each file one, however often it was read */
}

static void quiet_files_have_memory_that_others_never_use(void **state)
{
    const char *folder = *state;
    lf_import_group group = {0};
    lf_import_limit((uint64_t)4096 * MIB, 120);
    assert_string_equal(said_by(folder, "4000"), "enough"); /* no thumbnails are made */
    lf_import_expect_quiet(2);
    assert_string_equal(said_by(folder, "200"), "enough");
    lf_import_expect(1);
    assert_string_equal(said_by(folder, "3000"), "enough");
    assert_string_equal(told(folder), "4096 3072 1536 3072 ");
    (void)lf_import_group_begin(&group);
    group.is_quiet = true;
    assert_string_equal(said_by(folder, "500"), "enough");
    assert_string_equal(said_by(folder, "600"), "too little");
    lf_import_limit((uint64_t)16384 * MIB, 120);
    assert_string_equal(said_by(folder, "600"), "enough");
    assert_string_equal(told(folder), "512 512 1024 ");
    lf_import_limit((uint64_t)1024 * MIB, 120); /* too little for parts: alone */
    assert_string_equal(said_by(folder, "600"), "enough");
    (void)lf_import_group_enter(NULL);
    lf_import_expect(-1);
    assert_string_equal(said_by(folder, "600"), "enough");
    assert_string_equal(told(folder), "1024 1024 ");
    lf_import_expect_quiet(-2);
    lf_import_limit(0, 120);
}

static void what_has_the_whole_is_alone(void **state)
{
    enum { N = 4 };
    const char *folder = *state;
    importing all[N];
    pthread_t thread[N];
    lf_import_limit((uint64_t)1024 * MIB, 120);
    lf_import_expect(N - 1);
    use_reader(folder, "1000");
    for (int i = 0; i < N; i++) {
        all[i] = (importing){.folder = folder};
        assert_int_equal(pthread_create(&thread[i], NULL, import_one, &all[i]), 0);
    }
    for (int i = 0; i < N; i++) {
        pthread_join(thread[i], NULL);
        assert_string_equal(all[i].err.what, "enough");
    }
    use_reader(folder, NULL);
    int n = 0;
    for (const char *at = told(folder); (at = strchr(at, ' ')); at++)
        n++;
    assert_int_equal(n, 2 * N); /* a part and the whole, each */
    lf_import_expect(1 - N);
    lf_import_limit(0, 120);
}

/* ------------------------------------------------------------------------------------ rights -- */

/* The bounding set can be lowered by whoever may set capabilities. */
static bool may_set_capabilities(void)
{
    unsigned long long effective = 0;
    char line[256];
    FILE *file = fopen("/proc/self/status", "r");
    while (file && fgets(line, sizeof line, file))
        (void)sscanf(line, "CapEff: %llx", &effective);
    if (file)
        fclose(file);
    return (effective >> 8 & 1) != 0; /* CAP_SETPCAP */
}

static void a_reader_has_no_capabilities(void **state)
{
    static const char *const sets[] = {"CapInh", "CapPrm", "CapEff", "CapAmb", "CapBnd"};
    const char *said = said_by(*state, "capabilities");
    if (strstr(said, "confined")) /* a sandbox that has no seccomp */
        fail_msg("%s", said);
    for (int i = 0; i < (may_set_capabilities() ? 5 : 4); i++) {
        char expected[64];
        snprintf(expected, sizeof expected, "%s:\\t0000000000000000;", sets[i]);
        if (!strstr(said, expected))
            fail_msg("no \"%s\" in %s", expected, said);
    }
    assert_non_null(strstr(said, "NoNewPrivs:\\t1"));
}

static void memory_and_the_memory_file_are_not_twice_the_limit(void **state)
{
    if (SANITIZED) {
        print_message("readers under a sanitizer may map terabytes\n");
        skip();
    }
    const char *said = said_by(*state, "limits"), *file = strstr(said, "Max file size"),
               *space = strstr(said, "Max address space");
    unsigned long long in_file = 0, in_space = 0;
    assert_true(file && space);
    assert_int_equal(sscanf(file, "Max file size %llu", &in_file), 1);
    assert_int_equal(sscanf(space, "Max address space %llu", &in_space), 1);
    assert_int_equal(in_file + in_space, 300 * MIB);
    assert_int_equal(in_file, 100 * MIB);
}

/* ---------------------------------------------------------------------------------- Landlock -- */

/* As readers find it. */
static lf_landlock landlock_here(void)
{
    if (syscall(SYS_landlock_create_ruleset, NULL, 0, LANDLOCK_CREATE_RULESET_VERSION) >= 1)
        return LF_LANDLOCK_ON;
    return errno == ENOSYS || errno == EOPNOTSUPP ? LF_LANDLOCK_OFF : LF_LANDLOCK_REFUSED;
}

static bool forbid_landlock(int why)
{
    struct sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_landlock_create_ruleset, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | (uint32_t)why),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    struct sock_fprog program = {.len = sizeof filter / sizeof *filter, .filter = filter};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

/* Reads two files in a process where Landlock fails so; what it knows then, *out_log: its lines. */
static lf_landlock where_it_fails(const char *folder, int why, char *out_log, size_t size)
{
    int ends[2], status = 0;
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        importing one = {.folder = folder};
        dup2(ends[1], STDERR_FILENO);
        if (!forbid_landlock(why))
            _exit(LF_N_LANDLOCK);
        for (int i = 0; i < 2; i++)
            (void)import_one(&one);
        _exit(one.status == LF_OK ? (int)lf_import_landlock() : LF_N_LANDLOCK + 1);
    }
    close(ends[1]);
    size_t used = 0;
    for (ssize_t n; used + 1 < size && (n = read(ends[0], out_log + used, size - 1 - used)) > 0;)
        used += (size_t)n;
    out_log[used] = '\0';
    close(ends[0]);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return (lf_landlock)WEXITSTATUS(status);
}

static int count_of(const char *text, const char *word)
{
    int n = 0;
    for (const char *at = text; (at = strstr(at, word)); at++)
        n++;
    return n;
}

static void whether_landlock_helps_is_told(void **state)
{
    const char *folder = *state;
    char log[4096];
    use_reader(folder, NULL);
    importing one = {.folder = folder};
    (void)import_one(&one);
    lf_assert_ok(one.status, &one.err);
    /* Readers with a sanitizer go without; a test with one may have the release's (make READERS).
     */
    assert_true(lf_import_landlock() == landlock_here() ||
                (SANITIZED && lf_import_landlock() == LF_LANDLOCK_OFF));
    assert_string_equal(lf_landlock_name(LF_LANDLOCK_REFUSED), "refused");
    if (SANITIZED)
        return;
    lf_landlock known = where_it_fails(folder, EPERM, log, sizeof log);
    if (known == LF_N_LANDLOCK) {
        print_message("no sandbox here that forbids it\n");
        skip();
    }
    assert_int_equal(known, LF_LANDLOCK_REFUSED);
    assert_int_equal(count_of(log, "file readers run without Landlock"), 1);
    assert_int_equal(where_it_fails(folder, ENOSYS, log, sizeof log), LF_LANDLOCK_OFF);
    assert_int_equal(where_it_fails(folder, EOPNOTSUPP, log, sizeof log), LF_LANDLOCK_OFF);
    assert_int_equal(count_of(log, "Landlock"), 0);
}

int main(int argc, char **argv)
{
    (void)argc;
    if (strcmp(argv[0], "quiltimport") == 0)
        return read_as_told();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_has_its_part_first_and_then_the_whole_alone),
        cmocka_unit_test(quiet_files_have_memory_that_others_never_use),
        cmocka_unit_test(what_has_the_whole_is_alone),
        cmocka_unit_test(a_reader_has_no_capabilities),
        cmocka_unit_test(memory_and_the_memory_file_are_not_twice_the_limit),
        cmocka_unit_test(whether_landlock_helps_is_told),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
