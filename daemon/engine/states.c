#include "daemon/engine/states.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/list.h"
#include "base/log.h"

#define BEGINNING "film"
#define OLD_NAME "film.lfstate"
#define PATTERN "film-xxxxxxxx-xxxxxxxx-xxxxxxxx.lfstate"
/* Offsets in a name. */
enum { SCENE_AT = 5, CAMERA_AT = 14, WHOLE_AT = 23, NAME_SIZE = sizeof PATTERN };

struct lf_states {
    char *folder;
    pthread_mutex_t lock;
    char used[NAME_SIZE]; /* under lock; "" = none yet */
    bool spared;          /* under lock: the existing file of that name must not be overwritten */
};

/* A state in the folder. */
typedef struct kept {
    char name[NAME_SIZE];
    struct timespec at; /* time of the last use */
    uint64_t bytes;
} kept;

lf_status lf_states_create(const char *folder, lf_states **out_states, lf_error *err)
{
    lf_states *states = lf_calloc(1, sizeof *states);
    if (states)
        states->folder = lf_strdup(folder);
    if (!states || !states->folder) {
        lf_free(states);
        return lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    }
    pthread_mutex_init(&states->lock, NULL);
    lf_outfile_clean(folder, BEGINNING);
    *out_states = states;
    return LF_OK;
}

void lf_states_destroy(lf_states *states)
{
    if (!states)
        return;
    pthread_mutex_destroy(&states->lock);
    lf_free(states->folder);
    lf_free(states);
}

/* ------------------------------------------------------------------------------------- names -- */

static void put_hash(char *at, const uint8_t hash[LF_STATE_HASH])
{
    static const char digits[] = "0123456789abcdef";
    for (int i = 0; i < LF_STATE_HASH; i++) {
        at[2 * i] = digits[hash[i] >> 4];
        at[2 * i + 1] = digits[hash[i] & 15];
    }
}

static void name_of(const lf_state_id *id, char out[static NAME_SIZE])
{
    memcpy(out, PATTERN, NAME_SIZE);
    put_hash(out + SCENE_AT, id->scene);
    put_hash(out + CAMERA_AT, id->camera);
    put_hash(out + WHOLE_AT, id->whole);
}

static bool is_name(const char *name)
{
    if (strlen(name) != NAME_SIZE - 1)
        return false;
    for (int i = 0; i < NAME_SIZE - 1; i++)
        if (PATTERN[i] == 'x' ? !strchr("0123456789abcdef", name[i]) : name[i] != PATTERN[i])
            return false;
    return true;
}

static bool same_part(const char *a, const char *b, int at)
{
    return memcmp(a + at, b + at, 2 * (size_t)LF_STATE_HASH) == 0;
}

/* True if the existing file may be overwritten. */
static bool use(lf_states *states, const char *name)
{
    pthread_mutex_lock(&states->lock);
    states->spared = states->spared && strcmp(states->used, name) == 0;
    memcpy(states->used, name, NAME_SIZE);
    bool spared = states->spared;
    pthread_mutex_unlock(&states->lock);
    return !spared;
}

static void spare(lf_states *states, bool spared)
{
    pthread_mutex_lock(&states->lock);
    states->spared = spared;
    pthread_mutex_unlock(&states->lock);
}

/* ---------------------------------------------------------------------------------- the list -- */

static int by_use(const void *a, const void *b)
{
    const kept *x = a, *y = b;
    if (x->at.tv_sec != y->at.tv_sec)
        return x->at.tv_sec < y->at.tv_sec ? 1 : -1;
    if (x->at.tv_nsec != y->at.tv_nsec)
        return x->at.tv_nsec < y->at.tv_nsec ? 1 : -1;
    return strcmp(x->name, y->name);
}

static int is_state(const struct dirent *entry)
{
    return is_name(entry->d_name);
}

/* The state files, most recently used first, in *out (lf_free); returns their number. */
static int list(const lf_states *states, kept **out)
{
    struct dirent **entries = NULL;
    int dir = open(states->folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC), n = 0;
    int n_entries = dir >= 0 ? scandirat(dir, ".", &entries, is_state, NULL) : -1;
    *out = lf_calloc(n_entries > 0 ? (size_t)n_entries : 1, sizeof **out);
    for (int i = 0; i < n_entries; i++) {
        struct stat st;
        if (*out && fstatat(dir, entries[i]->d_name, &st, AT_SYMLINK_NOFOLLOW) == 0 &&
            S_ISREG(st.st_mode)) {
            kept *one = &(*out)[n++];
            memcpy(one->name, entries[i]->d_name, NAME_SIZE);
            one->at = st.st_mtim;
            one->bytes = (uint64_t)st.st_size;
        }
        free(entries[i]);
    }
    free(entries);
    if (dir >= 0)
        close(dir);
    if (n > 1)
        qsort(*out, (size_t)n, sizeof **out, by_use);
    return n;
}

/* The limit on the bytes of all files. */
static uint64_t most_bytes(const lf_states *states, uint64_t taken)
{
    struct statvfs fs;
    if (statvfs(states->folder, &fs) != 0)
        return LF_STATES_BYTES;
    uint64_t half = (taken + (uint64_t)fs.f_bavail * fs.f_frsize) / 2;
    return half < LF_STATES_BYTES ? half : LF_STATES_BYTES;
}

static void remove_state(const lf_states *states, const char *name)
{
    char *path = lf_path_join(states->folder, name);
    if (path && unlink(path) == 0)
        lf_log(LF_LOG_INFO, "%s: removed; newer states take its place", path);
    else if (path)
        lf_log(LF_LOG_WARNING, "%s: cannot remove the old state: %s", path, lf_errno_text(errno));
    lf_free(path);
}

void lf_states_trim(lf_states *states)
{
    kept *all;
    uint64_t taken = 0, bytes = 0;
    int n = list(states, &all), count = 0;
    for (int i = 0; i < n; i++)
        taken += all[i].bytes;
    const uint64_t most = most_bytes(states, taken);
    pthread_mutex_lock(&states->lock);
    for (int i = 0; i < n; i++)
        if (strcmp(all[i].name, states->used) == 0) {
            bytes = all[i].bytes;
            count = 1;
        }
    for (int i = 0; i < n; i++) {
        if (strcmp(all[i].name, states->used) == 0)
            continue;
        bytes += all[i].bytes;
        if (++count > LF_STATES_MOST || bytes > most)
            remove_state(states, all[i].name);
    }
    pthread_mutex_unlock(&states->lock);
    lf_free(all);
}

/* ----------------------------------------------------------------------------------- restore -- */

static lf_status open_state(const char *path, int *out_fd, lf_error *err)
{
    return lf_file_open(path, NULL, UINT64_MAX, out_fd, NULL, err);
}

/* Restores the state and marks it as used. */
static lf_status go_on_with(lf_renderer *renderer, const char *path, lf_error *err)
{
    int fd = -1;
    lf_status status = open_state(path, &fd, err);
    if (status != LF_OK)
        return status;
    status = lf_renderer_restore(renderer, fd, err);
    if (status == LF_OK)
        (void)futimens(fd, NULL);
    close(fd);
    return status;
}

static lf_status look_at(const char *path, lf_state_id *out, lf_error *err)
{
    int fd = -1;
    lf_status status = open_state(path, &fd, err);
    if (status != LF_OK)
        return status;
    status = lf_state_look(fd, out, err);
    close(fd);
    return status;
}

static void tell_left_aside(const char *path, const lf_error *err)
{
    lf_log(LF_LOG_WARNING, "%s: the saved state is not used: %s", path, err->what);
}

/* Describes how the state `name` differs from the one of `id`, named `wanted`. */
static void differences(const char *name, const lf_state_id *there, const char *wanted,
                        const lf_state_id *id, char *words, size_t size)
{
    bool known = is_name(name);
    words[0] = '\0';
    if (known && !same_part(name, wanted, SCENE_AT))
        lf_list_add(words, size, "the scene");
    if (known && !same_part(name, wanted, CAMERA_AT))
        lf_list_add(words, size, "the camera");
    if (there->n_views != id->n_views)
        lf_list_add(words, size, "the number of views (%d, now %d)", there->n_views, id->n_views);
    if (there->width != id->width || there->height != id->height)
        lf_list_add(words, size, "the view size (%dx%d, now %dx%d)", there->width, there->height,
                    id->width, id->height);
    if (there->seed != id->seed)
        lf_list_add(words, size, "the seed (%" PRIu64 ", now %" PRIu64 ")", there->seed, id->seed);
    if (words[0] == '\0')
        lf_list_add(words, size, "%sthe render settings", known ? "" : "the scene, the camera or ");
}

/* Resumes from the single state of older versions and renames it; false: it does not fit. */
static bool go_on_with_old(const lf_states *states, lf_renderer *renderer, const char *path,
                           const lf_state_id *id)
{
    char *old = lf_path_join(states->folder, OLD_NAME);
    lf_state_id there;
    bool fits = old && path && look_at(old, &there, NULL) == LF_OK && there.seed == id->seed &&
                go_on_with(renderer, old, NULL) == LF_OK;
    if (fits && rename(old, path) != 0)
        lf_log(LF_LOG_WARNING, "%s: cannot rename the state: %s", old, lf_errno_text(errno));
    lf_free(old);
    return fits;
}

static void tell_newest(const lf_states *states, const char *wanted, const lf_state_id *id)
{
    kept *all;
    char words[256];
    const char *name = list(states, &all) > 0 ? all[0].name : OLD_NAME;
    char *path = lf_path_join(states->folder, name);
    lf_state_id there;
    lf_error err;
    if (path && access(path, F_OK) == 0) {
        if (look_at(path, &there, &err) == LF_OK) {
            differences(name, &there, wanted, id, words, sizeof words);
            lf_log(LF_LOG_INFO,
                   "rendering starts from the beginning; the newest saved state differs in %s: %s",
                   words, path);
        } else {
            tell_left_aside(path, &err);
        }
    }
    lf_free(path);
    lf_free(all);
}

/* Finds a free name: NAME.aside, NAME.aside.2, … False: none, with errno. */
static bool find_aside(const char *path, char out[static PATH_MAX])
{
    struct stat st;
    for (int i = 1; i <= LF_STATES_ASIDE; i++) {
        int n = i == 1 ? snprintf(out, PATH_MAX, "%s.aside", path)
                       : snprintf(out, PATH_MAX, "%s.aside.%d", path, i);
        errno = n < PATH_MAX ? 0 : ENAMETOOLONG;
        if (errno != 0 || lstat(out, &st) != 0)
            return errno == ENOENT;
    }
    errno = EEXIST;
    return false;
}

static bool put_aside(const char *path)
{
    char aside[PATH_MAX];
    if (!find_aside(path, aside)) {
        if (errno == EEXIST)
            lf_log(LF_LOG_WARNING,
                   "%s: cannot set the state aside, %d are set aside already; remove some, then "
                   "load the scene again",
                   path, LF_STATES_ASIDE);
        else
            lf_log(LF_LOG_WARNING, "%s: cannot set the state aside: %s", path,
                   lf_errno_text(errno));
        return false;
    }
    if (rename(path, aside) != 0) {
        lf_log(LF_LOG_WARNING, "%s: cannot rename the state: %s", path, lf_errno_text(errno));
        return false;
    }
    lf_log(LF_LOG_INFO, "the state is kept as %s", aside);
    return true;
}

/* Handles an unusable state of this picture. A damaged one is put aside. One that cannot be read
 * now, for lack of memory or because of the disk, stays and is not overwritten by later saves. */
static void keep_useless(lf_states *states, const char *path, const lf_error *err)
{
    tell_left_aside(path, err);
    bool is_damaged = err->status == LF_E_FORMAT || err->status == LF_E_STATE;
    if (is_damaged && put_aside(path))
        return;
    spare(states, true);
    lf_log(LF_LOG_WARNING, "%s: the file stays unchanged, and the current image is not saved",
           path);
}

bool lf_states_restore(lf_states *states, lf_renderer *renderer, bool tells)
{
    char name[NAME_SIZE];
    lf_state_id id;
    lf_error err;
    if (lf_renderer_state_id(renderer, &id) != LF_OK)
        return false;
    name_of(&id, name);
    (void)use(states, name);
    spare(states, false);
    char *path = lf_path_join(states->folder, name);
    bool is_there = path && access(path, F_OK) == 0, fits = false;
    if (is_there) {
        fits = go_on_with(renderer, path, &err) == LF_OK;
        if (!fits)
            keep_useless(states, path, &err);
    } else if (tells) {
        fits = go_on_with_old(states, renderer, path, &id);
        if (!fits)
            tell_newest(states, name, &id);
    }
    lf_free(path);
    return fits;
}

/* -------------------------------------------------------------------------------------- save -- */

lf_status lf_states_begin(lf_states *states, const lf_renderer *renderer, lf_outfile *file,
                          lf_error *err)
{
    char name[NAME_SIZE];
    lf_state_id id;
    lf_status status = lf_renderer_state_id(renderer, &id);
    if (status != LF_OK)
        return lf_error_set(err, status, states->folder, "out of memory");
    name_of(&id, name);
    if (!use(states, name))
        return lf_error_set(
            err, LF_E_STATE, states->folder,
            "the saved state of this image cannot be read, so it is not overwritten");
    char *path = lf_path_join(states->folder, name);
    status = path ? lf_outfile_open(file, path, true, err)
                  : lf_error_set(err, LF_E_NOMEM, states->folder, "out of memory");
    lf_free(path);
    return status;
}
