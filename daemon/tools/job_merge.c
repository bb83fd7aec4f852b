#include "daemon/tools/job_merge.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <zlib.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/number.h"
#include "base/thread.h"

#define REMEDY "; make this part again"

/* What is kept of a part's head. */
typedef struct lf_part_head {
    lf_merging_file film;
    double seconds, cpu_seconds;
    int64_t passes, parts;
    bool complete;
} lf_part_head;

typedef struct lf_job_merging {
    const lf_job_merge *merge;
    lf_merging *films;
    lf_part_head *heads; /* [n_parts] */
    json_t *first;       /* the head of the first part */
    lf_merging_total total;
    double deadline;  /* of waiting */
    bool same_budget; /* of all parts */
} lf_job_merging;

/* ---------------------------------------------------------------------------------- one part -- */

static lf_status open_part(const char *path, int *out_fd, json_t **out, lf_error *err)
{
    lf_error why = {0};
    if (lf_job_state_open(path, out_fd, NULL, out, &why) == LF_OK)
        return LF_OK;
    return lf_error_set(err, why.status, path, "%s%s", why.what,
                        why.status == LF_E_FORMAT ? REMEDY : "");
}

/* Waits until a part is there; opening it tells why it is not. */
static void wait_for(const lf_job_merging *j, const char *path)
{
    const struct timespec pause = {.tv_nsec = 200 * 1000 * 1000};
    while (access(path, F_OK) != 0 && (errno == ENOENT || errno == ESTALE) &&
           lf_time_now() < j->deadline &&
           !(j->merge->cancel && atomic_load_explicit(j->merge->cancel, memory_order_relaxed)))
        nanosleep(&pause, NULL);
}

static lf_status check_output(const lf_job_merge *merge, int fd, const char *path, lf_error *err)
{
    struct stat part, out;
    const bool same = fstat(fd, &part) == 0 && stat(merge->out, &out) == 0 &&
                      part.st_dev == out.st_dev && part.st_ino == out.st_ino;
    return same ? lf_error_set(err, LF_E_ARG, merge->out,
                               "is also the part %s; name another output", path)
                : LF_OK;
}

static uint64_t seed_of(const json_t *head)
{
    const json_t *seed = json_object_get(head, "seed");
    uint64_t x = 0;
    if (json_is_string(seed))
        (void)lf_whole_is(json_string_value(seed), &x);
    else
        x = (uint64_t)json_integer_value(seed);
    return x;
}

static int number_or(const json_t *head, const char *key, int usual)
{
    const json_t *value = json_object_get(head, key);
    return value ? (int)json_integer_value(value) : usual;
}

/* "rows", inclusive. */
static void rows_of(const json_t *head, int out[2])
{
    for (size_t i = 0; i < 2; i++)
        out[i] = (int)json_integer_value(json_array_get(json_object_get(head, "rows"), i));
}

/* A number that only informs, cut to 0 to 1e15. */
static double cut(double x)
{
    return fmin(fmax(x, 0.0), 1e15);
}

/* How the head lies about the film; NULL: it does not. */
static const char *lie_of(const json_t *head, const lf_part_head *part)
{
    const lf_merging_file *film = &part->film;
    int rows[2];
    rows_of(head, rows);
    if (film->n_views != number_or(head, "views", 0) ||
        film->width != number_or(head, "width", 0) || film->height != number_or(head, "height", 0))
        return "the size of the views";
    if (film->n_rows > 0 && (film->first_row < rows[0] || film->last_row > rows[1]))
        return "its rows";
    const int streams = number_or(head, "streams", 1);
    if (film->n_streams > streams || (film->n_rows > 0 && film->n_streams < streams))
        return "its random streams";
    if (film->n_streams == 1 && streams == 1 &&
        (film->seed != seed_of(head) || film->stream != (uint32_t)number_or(head, "stream", 0)))
        return "its seed and stream";
    const bool of_passes = json_object_get(json_object_get(head, "budget"), "passes");
    if (part->complete && (film->n_rows != rows[1] - rows[0] + 1 ||
                           (of_passes && (film->least_passes != (double)part->passes ||
                                          film->most_passes != (double)part->passes))))
        return "being complete";
    return NULL;
}

/* Compares with the first part, except for what parts may have each for themselves. */
static lf_status compare(lf_job_merging *j, const char *path, const json_t *head, lf_error *err)
{
    char words[384] = "";
    json_t *a = json_deep_copy(head), *b = json_deep_copy(j->first);
    json_t *const both[] = {a, b};
    if (!a || !b) {
        json_decref(a);
        json_decref(b);
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    }
    for (int i = 0; i < 2; i++) {
        if (seed_of(head) != seed_of(j->first)) /* which this hash contains */
            json_object_del(json_object_get(both[i], "hashes"), "all");
        json_object_del(both[i], "rows");
        json_object_del(both[i], "stream");
        json_object_del(both[i], "seed");
    }
    lf_job_state_differences(a, b, words, sizeof words);
    j->same_budget &= json_equal(json_object_get(a, "budget"), json_object_get(b, "budget"));
    json_decref(a);
    json_decref(b);
    return words[0] == '\0' ? LF_OK
                            : lf_error_set(err, LF_E_STATE, path,
                                           "is of another job than %s, which differs in %s",
                                           j->merge->parts[0], words);
}

static lf_status keep_head(lf_job_merging *j, int i, json_t *head, uint32_t *out_tie, lf_error *err)
{
    lf_part_head *part = &j->heads[i];
    char *text = json_dumps(head, JSON_COMPACT | JSON_SORT_KEYS);
    if (!text)
        return lf_error_set(err, LF_E_NOMEM, j->merge->parts[i], "out of memory");
    *out_tie = (uint32_t)crc32_z(0, (const unsigned char *)text, strlen(text));
    free(text);
    part->seconds = cut(json_number_value(json_object_get(head, "seconds")));
    part->cpu_seconds = cut(json_number_value(json_object_get(head, "cpu_seconds")));
    part->passes = json_integer_value(json_object_get(head, "passes"));
    part->complete = json_is_true(json_object_get(head, "complete"));
    part->parts = (int64_t)cut((double)number_or(head, "parts", 1));
    if (j->first)
        return compare(j, j->merge->parts[i], head, err);
    j->first = json_incref(head);
    return LF_OK;
}

static lf_status look_at(lf_job_merging *j, int i, int fd, json_t *head, lf_error *err)
{
    const char *path = j->merge->parts[i];
    lf_part_head *part = &j->heads[i];
    uint32_t tie = 0;
    lf_status status = check_output(j->merge, fd, path, err);
    if (status == LF_OK)
        status = keep_head(j, i, head, &tie, err);
    if (status == LF_OK)
        status = lf_merging_add(j->films, fd, path, tie, &part->film, err);
    if (status != LF_OK)
        return status;
    const char *lie = lie_of(head, part);
    if (lie)
        return lf_error_set(err, LF_E_FORMAT, path,
                            "is damaged: its head and its film differ about %s" REMEDY, lie);
    return part->complete || j->merge->partial
               ? LF_OK
               : lf_error_set(err, LF_E_STATE, path,
                              "is not complete (%.4g spp so far); finish it, or merge with "
                              "--partial",
                              (double)part->passes / part->film.n_views);
}

static lf_status look_at_all(lf_job_merging *j, lf_error *err)
{
    lf_status status = LF_OK;
    for (int i = 0; i < j->merge->n_parts && status == LF_OK; i++) {
        json_t *head = NULL;
        int fd = -1;
        wait_for(j, j->merge->parts[i]);
        if (j->merge->cancel && atomic_load_explicit(j->merge->cancel, memory_order_relaxed))
            return lf_error_set(err, LF_E_CANCELLED, j->merge->out, "interrupted");
        status = open_part(j->merge->parts[i], &fd, &head, err);
        if (status != LF_OK)
            return status;
        status = look_at(j, i, fd, head, err);
        close(fd);
        json_decref(head);
    }
    return status;
}

/* --------------------------------------------------------------------------------- all parts -- */

/* Names the first copies, and counts the others. */
static void tell_copies(const lf_job_merging *j)
{
    enum { NAMED = 3 };
    const char *const *parts = j->merge->parts;
    int n = 0;
    for (int i = 0; i < j->merge->n_parts; i++) {
        const int original = lf_merging_copy_of(j->films, i);
        if (original >= 0 && n++ < NAMED)
            lf_log(LF_LOG_WARNING, "%s: has the same samples as %s; they count once", parts[i],
                   parts[original]);
    }
    if (n > NAMED)
        lf_log(LF_LOG_WARNING, "%d more parts have the same samples as others", n - NAMED);
}

static lf_status check_gaps(const lf_job_merging *j, lf_error *err)
{
    char rows[32];
    int first, last;
    if (!lf_merging_gap(j->films, 0, &first, &last) || j->merge->partial)
        return LF_OK;
    return lf_error_set(err, LF_E_STATE, j->merge->out,
                        "no part has %s; name all parts, or merge with --partial",
                        lf_merging_rows_text(first, last, rows, sizeof rows));
}

/* All rows must have the same passes, unless quiltrender can give them the rest. */
static lf_status check_passes(const lf_job_merging *j, lf_error *err)
{
    const lf_merging_total *t = &j->total;
    const char *least = j->merge->parts[lf_merging_holder(j->films, t->least_row)];
    if (j->merge->partial && t->n_streams == 1)
        return LF_OK;
    for (int i = 0; i < j->merge->n_parts; i++)
        if (!j->heads[i].complete)
            return lf_error_set(err, LF_E_STATE, j->merge->parts[i],
                                "is not complete; --partial is for parts of one random stream");
    return t->least_passes == t->most_passes
               ? LF_OK
               : lf_error_set(err, LF_E_STATE, least,
                              "row %d has %.0f passes, but row %d has %.0f; give all rows the same",
                              t->least_row, t->least_passes, t->most_row, t->most_passes);
}

/* The budget of the result: that of the parts, or the sum of their passes. */
static json_t *budget_of(const lf_job_merging *j, const json_t *base)
{
    json_t *budget = json_object_get(base, "budget");
    return j->total.n_streams == 1 && (j->same_budget || j->merge->partial)
               ? json_incref(budget)
               : json_pack("{s:I}", "passes", (json_int_t)cut(j->total.least_passes));
}

static bool is_complete(const lf_job_merging *j, const json_t *budget, int height)
{
    const lf_merging_total *t = &j->total;
    const json_t *passes = json_object_get(budget, "passes");
    bool all = true;
    for (int i = 0; i < j->merge->n_parts; i++)
        all = all && j->heads[i].complete;
    return t->n_rows == height && t->least_passes == t->most_passes &&
           (passes ? (double)json_integer_value(passes) == t->least_passes : all);
}

/* Opens the part whose head is that of the result: the first of the order with samples. */
static lf_status open_base(const lf_job_merging *j, json_t **out, int *out_part, lf_error *err)
{
    int k = 0, fd = -1;
    while (j->heads[lf_merging_at(j->films, k)].film.n_rows == 0)
        k++;
    *out_part = lf_merging_at(j->films, k);
    lf_status status = open_part(j->merge->parts[*out_part], &fd, out, err);
    if (status == LF_OK)
        close(fd);
    return status;
}

/* Sums over the parts, in their order. */
static void add_up(const lf_job_merging *j, double *seconds, double *cpu_seconds, int64_t *parts)
{
    *seconds = *cpu_seconds = 0.0;
    *parts = 0;
    for (int k = 0; k < j->merge->n_parts; k++) {
        const int i = lf_merging_at(j->films, k);
        if (lf_merging_copy_of(j->films, i) >= 0)
            continue;
        *seconds += j->heads[i].seconds;
        *cpu_seconds += j->heads[i].cpu_seconds;
        *parts += j->heads[i].parts;
    }
}

/* The head of the result, a state of all rows; NULL: out of memory. */
static json_t *make_head(const lf_job_merging *j, json_t *base, int part, lf_job_merged *out)
{
    const lf_merging_total *t = &j->total;
    const lf_merging_file *film = &j->heads[part].film;
    json_t *budget = budget_of(j, base);
    double seconds, cpu_seconds;
    int64_t parts;
    add_up(j, &seconds, &cpu_seconds, &parts);
    *out = (lf_job_merged){.n_parts = t->n_files,
                           .n_streams = t->n_streams,
                           .n_rows = t->n_rows,
                           .height = film->height,
                           .spp = t->passes / film->height / film->n_views,
                           .complete = is_complete(j, budget, film->height)};
    json_t *own = json_pack(
        "{s:[i, i], s:I, s:I, s:i, s:O, s:I, s:f, s:f, s:b}", "rows", 0, film->height - 1, "stream",
        t->n_streams == 1 ? (json_int_t)film->stream : 0, "parts", (json_int_t)parts, "streams",
        t->n_streams, "budget", budget, "passes", (json_int_t)cut(t->passes / film->height),
        "seconds", seconds, "cpu_seconds", cpu_seconds, "complete", out->complete);
    json_t *head = own && json_object_update(base, own) == 0 ? json_incref(base) : NULL;
    if (t->n_streams == 1 && head)
        json_object_del(head, "streams");
    json_decref(own);
    json_decref(budget);
    return head;
}

static lf_status write_merged(lf_job_merging *j, lf_job_merged *out, lf_error *err)
{
    const lf_job_merge *m = j->merge;
    lf_outfile file = {.fd = -1};
    json_t *base = NULL;
    int part = 0;
    lf_status status = open_base(j, &base, &part, err);
    if (status != LF_OK)
        return status;
    json_t *head = make_head(j, base, part, out);
    status = head ? lf_outfile_open(&file, m->out, true, err)
                  : lf_error_set(err, LF_E_NOMEM, m->out, "out of memory");
    if (status == LF_OK)
        status = lf_job_state_put(&file, head, err);
    if (status == LF_OK)
        status = lf_merging_write(j->films, &file, m->progress, m->context, m->cancel, err);
    if (status == LF_OK)
        status = lf_outfile_commit(&file, true, err);
    lf_outfile_abandon(&file);
    json_decref(head);
    json_decref(base);
    return status;
}

lf_status lf_job_merge_run(const lf_job_merge *merge, lf_job_merged *out, lf_error *err)
{
    lf_job_merging j = {
        .merge = merge, .deadline = lf_time_now() + merge->wait, .same_budget = true};
    j.heads = lf_calloc((size_t)merge->n_parts, sizeof *j.heads);
    lf_status status = j.heads ? lf_merging_create(&j.films, err)
                               : lf_error_set(err, LF_E_NOMEM, merge->out, "out of memory");
    if (status == LF_OK)
        status = look_at_all(&j, err);
    if (status == LF_OK)
        status = lf_merging_arrange(j.films, &j.total, err);
    if (status == LF_OK)
        tell_copies(&j);
    if (status == LF_OK)
        status = check_gaps(&j, err);
    if (status == LF_OK)
        status = check_passes(&j, err);
    if (status == LF_OK)
        status = write_merged(&j, out, err);
    lf_merging_destroy(j.films);
    lf_free(j.heads);
    json_decref(j.first);
    return status;
}
