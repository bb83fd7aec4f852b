#include "daemon/tools/plan_inputs.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/file_hash.h"

/* The keys of `names`, without values, are the files so far. */
static struct {
    pthread_mutex_t lock;
    json_t *names;
    bool failed, paused;
} inputs = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* Files of this process and of its machine mean nothing elsewhere. */
static bool is_of_machine(const char *path)
{
    return strncmp(path, "/proc/", 6) == 0 || strncmp(path, "/dev/", 5) == 0;
}

static void note(void *context, const char *path)
{
    (void)context;
    if (inputs.paused || is_of_machine(path))
        return;
    pthread_mutex_lock(&inputs.lock);
    inputs.failed |= json_object_set_new(inputs.names, path, json_null()) != 0;
    pthread_mutex_unlock(&inputs.lock);
}

void lf_plan_inputs_begin(void)
{
    inputs.names = json_object();
    inputs.failed = !inputs.names;
    lf_file_on_open(note, NULL);
}

void lf_plan_inputs_pause(bool on)
{
    inputs.paused = on;
}

typedef struct input {
    const char *name;
    int64_t bytes;
    bool has_hash;
} input;

static int by_name(const void *a, const void *b)
{
    return strcmp(((const input *)a)->name, ((const input *)b)->name);
}

static int by_size(const void *a, const void *b)
{
    const int64_t x = ((const input *)a)->bytes, y = ((const input *)b)->bytes;
    return x != y ? (x > y) - (x < y) : by_name(a, b);
}

/* Leaves the files in the order of names. */
static void choose_hashed(input *files, size_t n)
{
    int64_t sum = 0;
    struct stat found;
    for (size_t i = 0; i < n; i++)
        files[i].bytes = stat(files[i].name, &found) == 0 ? found.st_size : 0;
    qsort(files, n, sizeof *files, by_size);
    for (size_t i = 0; i < n; i++) {
        sum += files[i].bytes;
        files[i].has_hash = files[i].bytes <= LF_PLAN_HASHED_BYTES && sum <= LF_PLAN_HASHED_SUM;
    }
    qsort(files, n, sizeof *files, by_name);
}

static lf_status add_file(json_t *list, const input *file, lf_error *err)
{
    const char *name = file->name;
    char hash[LF_HASH_TEXT];
    uint64_t size = 0;
    int64_t hashed = 0;
    int fd = -1;
    lf_status status = lf_file_open(name, NULL, UINT64_MAX, &fd, &size, err);
    if (status != LF_OK)
        return status;
    const bool is_small = file->has_hash && size <= LF_PLAN_HASHED_BYTES,
               is_read = !is_small || lf_file_hash(fd, hash, &hashed);
    close(fd);
    if (!is_read)
        return lf_error_set(err, LF_E_IO, name, "cannot be read again for the plan");
    json_t *entry = json_pack("{s:s, s:I, s:s*}", "name", name, "bytes",
                              (json_int_t)(is_small ? (uint64_t)hashed : size), "sha256",
                              is_small ? hash : NULL);
    return json_array_append_new(list, entry) == 0
               ? LF_OK
               : lf_error_set(err, LF_E_NOMEM, name, "out of memory");
}

lf_status lf_plan_inputs_end(json_t **out, lf_error *err)
{
    const size_t n = json_object_size(inputs.names);
    input *files = lf_calloc(n + 1, sizeof *files);
    const char *name;
    json_t *list = json_array(), *value;
    size_t i = 0;
    lf_file_on_open(NULL, NULL);
    lf_status status = files && list && !inputs.failed
                           ? LF_OK
                           : lf_error_set(err, LF_E_NOMEM, "--plan", "out of memory");
    if (files) {
        json_object_foreach(inputs.names, name, value) files[i++].name = name;
        choose_hashed(files, n);
    }
    for (i = 0; i < n && status == LF_OK; i++)
        status = add_file(list, &files[i], err);
    lf_free(files);
    json_decref(inputs.names);
    inputs.names = NULL;
    if (status == LF_OK)
        *out = list;
    else
        json_decref(list);
    return status;
}
