/* The states that a daemon keeps: which is gone on with, which go, and what is left of one that was
 * being saved when its process was killed. That process is this program again. */
#include "tests/testing.h"

#include <dirent.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "daemon/engine/states.h"
#include "daemon/output/content.h"
#include "tests/scene_file.h"

#define MOMENTS 20
#define MANY_MOMENTS 200

static lf_status restore_fails; /* LF_OK: it does not */

lf_status __real_lf_renderer_restore(lf_renderer *renderer, int fd, lf_error *err);
lf_status __wrap_lf_renderer_restore(lf_renderer *renderer, int fd, lf_error *err);

lf_status __wrap_lf_renderer_restore(lf_renderer *renderer, int fd, lf_error *err)
{
    return restore_fails == LF_OK ? __real_lf_renderer_restore(renderer, fd, err)
                                  : lf_error_set(err, restore_fails, "state", "not now");
}

/* ------------------------------------------------------------------------------- the picture -- */

typedef struct picture {
    lf_pool *pool;
    lf_renderer *renderer;
} picture;

/* The scene with this patch (NULL: none), of views that are so wide. */
static picture begun(const char *patch_text, int width, uint64_t seed)
{
    const lf_options options = {
        .views = 6, .view_width = width, .view_height = width / 3 * 4, .seed = seed, .threads = 1};
    lf_calibration calibration;
    lf_content *content = NULL;
    lf_scene *scene = NULL;
    lf_error err = {0};
    picture made = {0};
    json_t *doc = lf_test_scene_document("live-fog"),
           *patch = json_loads(patch_text ? patch_text : "{}", 0, NULL),
           *patched = lf_json_merge_patch(doc, patch);
    lf_calibration_portrait(&calibration);
    lf_assert_ok(lf_scene_from_json(patched, ".", "fog", NULL, NULL, &scene, &err), &err);
    lf_assert_ok(lf_content_from_scene(scene, "fog", &options, &calibration, &content, &err), &err);
    lf_assert_ok(lf_pool_create(1, &made.pool), NULL);
    lf_assert_ok(lf_renderer_create(scene, &content->settings, made.pool, &made.renderer, &err),
                 &err);
    lf_content_unref(content);
    lf_scene_unref(scene);
    json_decref(doc);
    json_decref(patch);
    json_decref(patched);
    return made;
}

static void end(const picture *p)
{
    lf_renderer_destroy(p->renderer);
    lf_pool_destroy(p->pool);
}

static void render(const picture *p, int passes)
{
    lf_assert_ok(lf_renderer_pass(p->renderer, NULL, passes, NULL, NULL, NULL), NULL);
}

static double passes_of(const picture *p)
{
    lf_render_stats stats;
    lf_renderer_stats(p->renderer, &stats);
    return stats.passes;
}

/* -------------------------------------------------------------------------------- the states -- */

static lf_states *states_in(const char *folder)
{
    lf_states *states = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_states_create(folder, &states, &err), &err);
    return states;
}

static void save(lf_states *states, const picture *p)
{
    lf_outfile file = {.fd = -1};
    lf_error err = {0};
    lf_assert_ok(lf_states_begin(states, p->renderer, &file, &err), &err);
    lf_assert_ok(lf_renderer_save(p->renderer, &file, NULL, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
}

static void assert_not_saved(lf_states *states, const picture *p)
{
    lf_outfile file = {.fd = -1};
    lf_assert_status(lf_states_begin(states, p->renderer, &file, NULL), LF_E_STATE, NULL);
}

/* How far the picture had come in the folder; 0 = it has no state there. */
static double kept(const char *folder, const char *patch, int width, uint64_t seed)
{
    lf_states *states = states_in(folder);
    const picture p = begun(patch, width, seed);
    bool found = lf_states_restore(states, p.renderer, true);
    double passes = passes_of(&p);
    assert_int_equal(found, passes > 0);
    end(&p);
    lf_states_destroy(states);
    return passes;
}

/* The names in a folder that contain this; *last (may be NULL) is one of them. */
static int count(const char *folder, const char *part, char last[NAME_MAX + 1])
{
    DIR *dir = opendir(folder);
    int n = 0;
    assert_non_null(dir);
    for (const struct dirent *entry; (entry = readdir(dir));)
        if (strstr(entry->d_name, part)) {
            n++;
            if (last)
                snprintf(last, NAME_MAX + 1, "%s", entry->d_name);
        }
    closedir(dir);
    return n;
}

#define OTHER_FOG "{\"volumes\":{\"fog\":{\"density\":5}}}"
#define OTHER_CAMERA "{\"camera\":{\"position\":[1,0.4,9]}}"

static void every_picture_has_a_state_of_its_own(void **state)
{
    static const struct {
        const char *patch;
        int width;
        uint64_t seed;
    } all[] = {
        {NULL, 24, 1}, {NULL, 30, 1}, {NULL, 24, 2}, {OTHER_FOG, 24, 1}, {OTHER_CAMERA, 24, 1}};
    const char *folder = *state;
    const int n = (int)(sizeof all / sizeof all[0]);
    lf_states *states = states_in(folder);
    for (int i = 0; i < n; i++) {
        const picture p = begun(all[i].patch, all[i].width, all[i].seed);
        assert_false(lf_states_restore(states, p.renderer, true));
        render(&p, 2 + i);
        save(states, &p);
        lf_states_trim(states);
        end(&p);
    }
    lf_states_destroy(states);
    assert_int_equal(count(folder, ".lfstate", NULL), n);
    for (int i = 0; i < n; i++)
        assert_true(kept(folder, all[i].patch, all[i].width, all[i].seed) == 2 + i);
    /* how it is shown is no part of the picture */
    assert_true(kept(folder, "{\"film\":{\"exposure\":1}}", 24, 1) == 2);
}

static void a_state_of_before_gets_its_name_where_it_fits(void **state)
{
    const char *folder = *state;
    char name[NAME_MAX + 1];
    lf_states *states = states_in(folder);
    const picture p = begun(NULL, 24, 1);
    render(&p, 3);
    save(states, &p);
    end(&p);
    lf_states_destroy(states);
    assert_int_equal(count(folder, ".lfstate", name), 1);
    char *old = strdup(lf_test_path(folder, "film.lfstate"));
    assert_int_equal(rename(lf_test_path(folder, name), old), 0);
    assert_true(kept(folder, NULL, 30, 1) == 0);
    assert_true(kept(folder, NULL, 24, 2) == 0);
    assert_true(kept(folder, OTHER_FOG, 24, 1) == 0);
    assert_int_equal(access(old, F_OK), 0);
    assert_true(kept(folder, NULL, 24, 1) == 3);
    assert_int_not_equal(access(old, F_OK), 0);
    assert_int_equal(access(lf_test_path(folder, name), F_OK), 0);
    lf_test_write(folder, "film.lfstate", "no state at all");
    assert_true(kept(folder, NULL, 30, 1) == 0);
    assert_int_equal(access(old, F_OK), 0);
    free(old);
}

static void what_is_damaged_is_left_aside(void **state)
{
    const char *folder = *state;
    char name[NAME_MAX + 1];
    lf_states *states = states_in(folder);
    const picture p = begun(NULL, 24, 1);
    render(&p, 3);
    save(states, &p);
    assert_int_equal(count(folder, ".lfstate", name), 1);
    assert_int_equal(truncate(lf_test_path(folder, name), 5000), 0);
    assert_true(kept(folder, NULL, 24, 1) == 0);
    save(states, &p);
    assert_true(kept(folder, NULL, 24, 1) == 3);
    /* nor is it written over */
    struct stat st;
    char aside[NAME_MAX + 16];
    snprintf(aside, sizeof aside, "%s.aside", name);
    assert_int_equal(stat(lf_test_path(folder, aside), &st), 0);
    assert_int_equal(st.st_size, 5000);
    end(&p);
    lf_states_destroy(states);
}

static void all_that_are_damaged_are_kept_up_to_a_number(void **state)
{
    const char *folder = *state;
    char name[NAME_MAX + 1], aside[NAME_MAX + 16];
    struct stat st;
    lf_states *states = states_in(folder);
    const picture p = begun(NULL, 24, 1);
    render(&p, 3);
    save(states, &p);
    assert_int_equal(count(folder, ".lfstate", name), 1);
    for (int i = 1; i <= LF_STATES_ASIDE + 1; i++) {
        assert_int_equal(truncate(lf_test_path(folder, name), 5000 + i), 0);
        assert_true(kept(folder, NULL, 24, 1) == 0);
        if (i <= LF_STATES_ASIDE)
            save(states, &p);
    }
    for (int i = 1; i <= LF_STATES_ASIDE; i++) {
        snprintf(aside, sizeof aside, i == 1 ? "%s.aside" : "%s.aside.%d", name, i);
        assert_int_equal(stat(lf_test_path(folder, aside), &st), 0);
        assert_int_equal(st.st_size, 5000 + i);
    }
    assert_int_equal(count(folder, ".aside", NULL), LF_STATES_ASIDE);
    /* the last one stays, and is not written over */
    assert_int_equal(stat(lf_test_path(folder, name), &st), 0);
    assert_int_equal(st.st_size, 5000 + LF_STATES_ASIDE + 1);
    assert_false(lf_states_restore(states, p.renderer, true));
    assert_not_saved(states, &p);
    assert_int_equal(unlink(lf_test_path(folder, aside)), 0);
    assert_false(lf_states_restore(states, p.renderer, true));
    save(states, &p);
    assert_true(kept(folder, NULL, 24, 1) == 3);
    end(&p);
    lf_states_destroy(states);
}

/* There is no memory for it, or its disk fails. */
static void what_cannot_be_read_now_stays_and_is_gone_on_with_later(void **state)
{
    static const lf_status why[] = {LF_E_NOMEM, LF_E_IO};
    const char *folder = *state;
    lf_states *states = states_in(folder);
    const picture p = begun(NULL, 24, 1), other = begun(NULL, 30, 1);
    render(&p, 3);
    render(&other, 2);
    save(states, &p);
    for (int i = 0; i < 2; i++) {
        restore_fails = why[i];
        assert_false(lf_states_restore(states, p.renderer, true));
        restore_fails = LF_OK;
        assert_int_equal(count(folder, ".aside", NULL), 0);
        assert_not_saved(states, &p);
        /* another picture is saved, and this one again when it could be read */
        assert_true(lf_states_restore(states, other.renderer, true) == (i > 0));
        save(states, &other);
        assert_true(lf_states_restore(states, p.renderer, true));
        assert_true(passes_of(&p) == 3);
        save(states, &p);
    }
    end(&p);
    end(&other);
    lf_states_destroy(states);
}

/* ------------------------------------------------------------------------------------ limits -- */

/* A file of this size that was used so many seconds after the others. */
static const char *old_file(const char *folder, const char *name, off_t size, int seconds)
{
    const char *path = lf_test_write(folder, name, "quiltdST");
    const struct timespec times[] = {{.tv_sec = 1000 + seconds}, {.tv_sec = 1000 + seconds}};
    assert_int_equal(truncate(path, size), 0);
    assert_int_equal(utimensat(AT_FDCWD, path, times, AT_SYMLINK_NOFOLLOW), 0);
    return path;
}

static bool is_there(const char *folder, const char *name)
{
    return access(lf_test_path(folder, name), F_OK) == 0;
}

/* A saved picture, which is the one in use, but older than everything else. */
static lf_states *with_one_in_use(const char *folder, char name[NAME_MAX + 1])
{
    const struct timespec times[] = {{.tv_sec = 1}, {.tv_sec = 1}};
    lf_states *states = states_in(folder);
    const picture p = begun(NULL, 24, 1);
    render(&p, 3);
    save(states, &p);
    end(&p);
    assert_int_equal(count(folder, ".lfstate", name), 1);
    assert_int_equal(utimensat(AT_FDCWD, lf_test_path(folder, name), times, 0), 0);
    return states;
}

static void the_least_recently_used_go_but_never_the_one_in_use(void **state)
{
    const char *folder = *state;
    char used[NAME_MAX + 1], name[NAME_MAX + 1];
    lf_states *states = with_one_in_use(folder, used);
    for (int i = 0; i < LF_STATES_MOST + 2; i++) {
        snprintf(name, sizeof name, "film-0000000%x-00000000-00000000.lfstate", i);
        old_file(folder, name, 100, (7 * i) % (LF_STATES_MOST + 2));
    }
    lf_states_trim(states);
    lf_states_destroy(states);
    assert_int_equal(count(folder, ".lfstate", NULL), LF_STATES_MOST);
    assert_true(is_there(folder, used));
    for (int i = 0; i < LF_STATES_MOST + 2; i++) {
        snprintf(name, sizeof name, "film-0000000%x-00000000-00000000.lfstate", i);
        assert_int_equal(is_there(folder, name), (7 * i) % (LF_STATES_MOST + 2) >= 3);
    }
}

static void together_they_take_no_more_than_the_limit(void **state)
{
    const char *folder = *state;
    const off_t third = (off_t)(LF_STATES_BYTES / 3 + LF_STATES_BYTES / 24);
    char used[NAME_MAX + 1], name[NAME_MAX + 1];
    lf_states *states = with_one_in_use(folder, used);
    for (int i = 0; i < 4; i++) {
        snprintf(name, sizeof name, "film-0000000%x-00000000-00000000.lfstate", i);
        old_file(folder, name, third, i);
    }
    lf_states_trim(states);
    lf_states_destroy(states);
    assert_true(is_there(folder, used));
    assert_int_equal(count(folder, ".lfstate", NULL), 3);
    assert_true(is_there(folder, "film-00000003-00000000-00000000.lfstate"));
    assert_true(is_there(folder, "film-00000002-00000000-00000000.lfstate"));
}

static void other_files_are_never_touched(void **state)
{
    static const char *const names[] = {"film.lfstate",
                                        "film-mine.lfstate",
                                        "film-0000000G-00000000-00000000.lfstate",
                                        "film-00000000-00000000-00000000.lfstates",
                                        "notes",
                                        ".notes.quiltd-abcdef",
                                        ".film.lfstate.quiltd-abcde"};
    const char *folder = *state;
    char used[NAME_MAX + 1], name[NAME_MAX + 1];
    lf_states *states = with_one_in_use(folder, used);
    const int n = (int)(sizeof names / sizeof names[0]);
    for (int i = 0; i < n; i++)
        old_file(folder, names[i], 10, 0);
    assert_int_equal(mkdir(lf_test_path(folder, "film-aaaaaaaa-00000000-00000000.lfstate"), 0700),
                     0);
    assert_int_equal(
        symlink("notes", lf_test_path(folder, "film-bbbbbbbb-00000000-00000000.lfstate")), 0);
    for (int i = 0; i < LF_STATES_MOST; i++) {
        snprintf(name, sizeof name, "film-0000000%x-00000000-00000000.lfstate", i);
        old_file(folder, name, 100, 10 + i);
    }
    lf_states_trim(states);
    lf_states_destroy(states);
    lf_states_destroy(states_in(folder));
    for (int i = 0; i < n; i++)
        assert_true(is_there(folder, names[i]));
    assert_true(is_there(folder, "film-aaaaaaaa-00000000-00000000.lfstate"));
    assert_true(is_there(folder, "film-bbbbbbbb-00000000-00000000.lfstate"));
    assert_int_equal(count(folder, "-00000000.lfstate", NULL) - 4, LF_STATES_MOST - 1);
}

/* ----------------------------------------------------------------------------------- kill -9 -- */

static void what_killed_saves_left_is_removed_at_the_start(void **state)
{
    static const char dead[] = ".film-00000000-00000000-00000000.lfstate.quiltd-abcdef",
                      old[] = ".film.lfstate.quiltd-abcdef",
                      living[] = ".film-00000000-00000000-00000001.lfstate.quiltd-abcdef";
    const char *folder = *state;
    lf_test_write(folder, dead, "half a state");
    lf_test_write(folder, old, "half a state");
    int fd = open(lf_test_write(folder, living, "being written"), O_RDONLY | O_CLOEXEC);
    assert_int_equal(flock(fd, LOCK_EX | LOCK_NB), 0);
    lf_states_destroy(states_in(folder));
    assert_false(is_there(folder, dead));
    assert_false(is_there(folder, old));
    assert_true(is_there(folder, living));
    close(fd);
}

/* Goes on from what lies there and saves after every pass, for ever; says so before and after. */
static _Noreturn void save_for_ever(const char *folder)
{
    lf_states *states = states_in(folder);
    const picture p = begun(NULL, 96, 1);
    (void)lf_states_restore(states, p.renderer, false);
    for (;;) {
        render(&p, 1);
        dprintf(STDOUT_FILENO, "begin %.17g\n", passes_of(&p));
        save(states, &p);
        dprintf(STDOUT_FILENO, "end %.17g\n", passes_of(&p));
    }
}

typedef struct saves {
    double begun, ended;
} saves;

static void read_line(FILE *said, saves *out)
{
    char line[64];
    if (!fgets(line, sizeof line, said))
        return;
    if (strncmp(line, "begin ", 6) == 0)
        out->begun = strtod(line + 6, NULL);
    else if (strncmp(line, "end ", 4) == 0)
        out->ended = strtod(line + 4, NULL);
}

/* Kills one that saves, so long after a later save has begun; what it had begun and ended. */
static saves killed_after(const char *folder, long microseconds)
{
    int ends[2], status = 0;
    saves done = {-1, -1};
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        dup2(ends[1], STDOUT_FILENO);
        execl("/proc/self/exe", "test_states", "save", folder, NULL);
        _exit(3);
    }
    close(ends[1]);
    FILE *said = fdopen(ends[0], "r");
    while ((done.ended < 0 || done.begun <= done.ended) && !feof(said))
        read_line(said, &done);
    usleep((useconds_t)microseconds);
    assert_int_equal(kill(child, SIGKILL), 0);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    while (!feof(said))
        read_line(said, &done);
    fclose(said);
    return done;
}

static void a_kill_costs_no_more_than_the_save_in_progress(void **state)
{
    const char *folder = *state;
    int moments = lf_test_long() ? MANY_MOMENTS : MOMENTS, in_the_middle = 0;
    unsigned short random[3];
    uint64_t seed = lf_test_seed();
    memcpy(random, &seed, sizeof random);
    double before = 0;
    for (int i = 0; i < moments; i++) {
        const saves done = killed_after(folder, nrand48(random) % 3000);
        double now = kept(folder, NULL, 96, 1);
        assert_true(done.ended > before);
        assert_true(now == done.ended || now == done.begun);
        assert_int_equal(count(folder, "film", NULL), 1);
        in_the_middle += done.begun > done.ended;
        before = now;
    }
    print_message("%d of %d were killed in the middle of a save\n", in_the_middle, moments);
}

int main(int argc, char *argv[])
{
    if (argc == 3 && strcmp(argv[1], "save") == 0)
        save_for_ever(argv[2]);
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(every_picture_has_a_state_of_its_own),
        lf_test_in_folder(a_state_of_before_gets_its_name_where_it_fits),
        lf_test_in_folder(what_is_damaged_is_left_aside),
        lf_test_in_folder(all_that_are_damaged_are_kept_up_to_a_number),
        lf_test_in_folder(what_cannot_be_read_now_stays_and_is_gone_on_with_later),
        lf_test_in_folder(the_least_recently_used_go_but_never_the_one_in_use),
        lf_test_in_folder(together_they_take_no_more_than_the_limit),
        lf_test_in_folder(other_files_are_never_touched),
        lf_test_in_folder(what_killed_saves_left_is_removed_at_the_start),
        lf_test_in_folder(a_kill_costs_no_more_than_the_save_in_progress),
    };
    return cmocka_run_group_tests_name("states", tests, NULL, NULL);
}
