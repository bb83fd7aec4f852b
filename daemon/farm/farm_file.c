#include "daemon/farm/farm_file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/file_hash.h"
#include "base/version.h"
#include "daemon/farm/farm_process.h"

#define RENDERER "quiltrender"

/* ----------------------------------------------------------------------------------- compare -- */

/* What a call says that has just failed. */
static lf_farm_file why_not(void)
{
    return errno == ENOENT || errno == ENOTDIR ? LF_FARM_FILE_MISSING : LF_FARM_FILE_UNREADABLE;
}

static lf_farm_file compare_hash(const char *path, const char *hash)
{
    char found[LF_HASH_TEXT];
    int64_t size = 0;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return why_not();
    const bool is_read = lf_file_hash(fd, found, &size);
    close(fd);
    if (!is_read)
        return LF_FARM_FILE_UNREADABLE;
    return strcmp(found, hash) == 0 ? LF_FARM_FILE_SAME : LF_FARM_FILE_OTHER_BYTES;
}

static lf_farm_file compare(const char *path, const json_t *note, bool reads)
{
    const json_t *bytes = json_object_get(note, "bytes");
    const char *hash = json_string_value(json_object_get(note, "sha256"));
    struct stat found;
    if (stat(path, &found) != 0)
        return why_not();
    if (!S_ISREG(found.st_mode))
        return LF_FARM_FILE_MISSING;
    if (!json_is_integer(bytes) || found.st_size != json_integer_value(bytes))
        return LF_FARM_FILE_OTHER_SIZE;
    return reads && hash ? compare_hash(path, hash) : LF_FARM_FILE_SAME;
}

lf_farm_file lf_farm_file_compare(const char *folder, const json_t *note, bool reads)
{
    const char *name = json_string_value(json_object_get(note, "name"));
    char *path = name ? lf_path_join(folder, name) : NULL;
    const lf_farm_file result = path ? compare(path, note, reads) : LF_FARM_FILE_MISSING;
    lf_free(path);
    return result;
}

/* ----------------------------------------------------------------------------------- release -- */

static lf_status other_release(const char *program, const char *here, const char *planned,
                               lf_error *err)
{
    return lf_error_set(err, LF_E_STATE, program,
                        "is release %.40s, and the job was planned with %.40s; use that release, "
                        "or plan a new job",
                        here, planned);
}

lf_status lf_farm_check_release(const lf_farm_job *job, lf_error *err)
{
    const char *planned = json_string_value(json_object_get(job->json, "quiltd"));
    if (job->id[0] == '\0')
        return lf_error_set(err, LF_E_STATE, job->path,
                            "was planned by an earlier build; use that build, or plan a new job");
    return planned && strcmp(planned, LF_VERSION) == 0
               ? LF_OK
               : other_release("quiltfarm", LF_VERSION, planned ? planned : "none", err);
}

/* Asks the renderer that would run here. One that does not answer says more when it runs. */
static lf_status check_renderer(const lf_farm_job *job, lf_error *err)
{
    const char *planned = json_string_value(json_object_get(job->plan, "quiltd"));
    char path[PATH_MAX];
    char *text = NULL;
    int code = 0;
    lf_status status = lf_farm_find(RENDERER, path, err);
    if (status != LF_OK || !planned)
        return status;
    lf_farm_words words = {0};
    lf_farm_words_add(&words, "%s", path);
    lf_farm_words_add(&words, "--version");
    status = words.failed ? lf_farm_no_memory(RENDERER, err)
                          : lf_farm_process_read(words.list, &text, &code, err);
    lf_farm_words_finish(&words);
    if (status == LF_OK && code == 0) {
        char *number = strchr(text, ' '); /* "quiltrender 1.2.3" */
        number = number ? number + 1 : text;
        number[strcspn(number, " \n")] = '\0';
        if (strcmp(number, planned) != 0)
            status = other_release(RENDERER, number, planned, err);
    }
    lf_free(text);
    return status;
}

/* ------------------------------------------------------------------------------------ inputs -- */

static const char *words_of(lf_farm_file found)
{
    if (found == LF_FARM_FILE_UNREADABLE)
        return "cannot be read";
    return found == LF_FARM_FILE_MISSING ? "is missing since the job was planned"
                                         : "has changed since the job was planned";
}

static lf_status check_inputs(const lf_farm_job *job, bool reads, lf_error *err)
{
    const json_t *note;
    size_t i;
    json_array_foreach(json_object_get(job->plan, "inputs"), i, note)
    {
        const char *name = json_string_value(json_object_get(note, "name"));
        const lf_farm_file found = lf_farm_file_compare(job->folder, note, reads);
        if (found != LF_FARM_FILE_SAME)
            return lf_error_set(err, LF_E_STATE, name ? name : job->path,
                                "%s; restore it, or plan a new job", words_of(found));
    }
    return LF_OK;
}

/* A finish that joins the frames of a film reads nothing else. */
static bool reads_scene(const lf_farm_job *job, int step)
{
    return step < job->n_tasks || !job->join;
}

lf_status lf_farm_check_same(const lf_farm_job *job, int step, lf_error *err)
{
    static bool has_read, has_asked; /* by this process, and all was well */
    lf_status status = lf_farm_check_release(job, err);
    if (status == LF_OK && reads_scene(job, step)) {
        status = check_inputs(job, !has_read, err);
        has_read |= status == LF_OK;
    }
    if (status == LF_OK && !has_asked) {
        status = check_renderer(job, err);
        has_asked = status == LF_OK;
    }
    return status;
}
