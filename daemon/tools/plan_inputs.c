#include "daemon/tools/plan_inputs.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/file_hash.h"

/* The keys of `names`, without values, are the files so far. */
static struct {
    pthread_mutex_t lock;
    json_t *names;
    bool failed;
} inputs = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* Files of this process and of its machine mean nothing elsewhere. */
static bool is_of_machine(const char *path)
{
    return strncmp(path, "/proc/", 6) == 0 || strncmp(path, "/dev/", 5) == 0;
}

static void note(void *context, const char *path)
{
    (void)context;
    if (is_of_machine(path))
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

void lf_plan_inputs_listen(bool on)
{
    if (inputs.names)
        lf_file_on_open(on ? note : NULL, NULL);
}

static int compare(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static lf_status add_file(json_t *list, const char *name, lf_error *err)
{
    char hash[LF_HASH_TEXT];
    uint64_t size = 0;
    int64_t hashed = 0;
    int fd = -1;
    lf_status status = lf_file_open(name, NULL, UINT64_MAX, &fd, &size, err);
    if (status != LF_OK)
        return status;
    const bool is_small = size <= LF_PLAN_HASHED_BYTES,
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
    const char **names = lf_calloc(n + 1, sizeof *names), *name;
    json_t *list = json_array(), *value;
    size_t i = 0;
    lf_file_on_open(NULL, NULL);
    lf_status status = names && list && !inputs.failed
                           ? LF_OK
                           : lf_error_set(err, LF_E_NOMEM, "--plan", "out of memory");
    if (names) {
        json_object_foreach(inputs.names, name, value) names[i++] = name;
        qsort((void *)names, n, sizeof *names, compare);
    }
    for (i = 0; i < n && status == LF_OK; i++)
        status = add_file(list, names[i], err);
    lf_free((void *)names);
    json_decref(inputs.names);
    inputs.names = NULL;
    if (status == LF_OK)
        *out = list;
    else
        json_decref(list);
    return status;
}
