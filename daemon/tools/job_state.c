#include "daemon/tools/job_state.h"

#include <endian.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "base/alloc.h"
#include "base/list.h"
#include "base/version.h"

#define VERSION 1
#define MOST_TEXT (UINT32_C(1) << 20)
#define MOST_PASSES (INT64_C(1) << 40) /* limit of --passes */

static const char magic[8] = "quiltdJB";

typedef struct head {
    char magic[sizeof magic];
    uint32_t version, n, crc; /* little-endian */
} head;
_Static_assert(sizeof(head) == sizeof magic + 12, "as it lies in files");

static uint32_t checksum(const head *h, const char *text)
{
    uLong crc = crc32_z(0, (const unsigned char *)&h->n, sizeof h->n);
    return htole32((uint32_t)crc32_z(crc, (const unsigned char *)text, le32toh(h->n)));
}

/* ----------------------------------------------------------------------------- what it is of -- */

static json_t *hash_words(const uint8_t bytes[LF_STATE_HASH])
{
    char text[2 * LF_STATE_HASH + 1];
    for (size_t i = 0; i < LF_STATE_HASH; i++)
        snprintf(text + 2 * i, 3, "%02x", bytes[i]);
    return json_string(text);
}

/* JSON integers do not hold unsigned 64-bit numbers. */
static json_t *seed_words(uint64_t seed)
{
    char text[24];
    if (seed <= INT64_MAX)
        return json_integer((json_int_t)seed);
    snprintf(text, sizeof text, "%" PRIu64, seed);
    return json_string(text);
}

static json_t *budget_words(const lf_budget *b)
{
    return b->passes > 0    ? json_pack("{s:I}", "passes", (json_int_t)b->passes)
           : b->seconds > 0 ? json_pack("{s:f}", "seconds", b->seconds)
           : b->target_error > 0
               ? json_pack("{s:f}", "target_error", b->target_error)
               : json_pack("{s:f}", "target_denoised_error", b->target_denoised_error);
}

/* Optional numbers: "s:o*" omits NULL. */
static json_t *number_words(int number)
{
    return number >= 0 ? json_integer(number) : NULL;
}

json_t *lf_job_state_of(const char *scene, const lf_renderer *renderer, const lf_budget *budget,
                        const lf_job_place *place)
{
    const lf_render_settings *s = lf_renderer_settings(renderer);
    lf_state_id id;
    if (lf_renderer_state_id(renderer, &id) != LF_OK)
        return NULL;
    return json_pack("{s:s, s:s, s:i, s:i, s:i, s:[i, i], s:I, s:o*, s:o*, s:o*, s:o, s:s, s:b, "
                     "s:b, s:{s:o, s:o, s:o}, s:o}",
                     "quiltd", LF_VERSION, "scene", scene, "views", s->camera.n_views, "width",
                     s->width, "height", s->height, "rows", place->first_row, place->last_row,
                     "stream", (json_int_t)place->stream, "frame", number_words(place->frame),
                     "camera_row", number_words(place->camera_row), "shutter_part",
                     number_words(place->shutter_part), "seed", seed_words(s->seed), "integrator",
                     s->integrator, "reconstruct", s->features, "denoise", s->features, "hashes",
                     "scene", hash_words(id.scene), "camera", hash_words(id.camera), "all",
                     hash_words(id.whole), "budget", budget_words(budget));
}

/* ------------------------------------------------------------------------------------ differ -- */

static bool differs(const json_t *a, const json_t *b, const char *key)
{
    const json_t *of_a = json_object_get(a, key), *of_b = json_object_get(b, key);
    return (of_a || of_b) && !json_equal(of_a, of_b);
}

/* The member as JSON text; returns buf. */
static const char *said(const json_t *object, const char *key, char *buf, size_t size)
{
    char *text = json_dumps(json_object_get(object, key), JSON_ENCODE_ANY);
    snprintf(buf, size, "%s", text ? text : "nothing");
    free(text);
    return buf;
}

static void add_said(char *words, size_t size, const char *what, const json_t *there,
                     const json_t *of, const char *key)
{
    char a[64], b[64];
    lf_list_add(words, size, "%s (%s, not %s)", what, said(there, key, a, sizeof a),
                said(of, key, b, sizeof b));
}

void lf_job_state_differences(const json_t *there, const json_t *of, char *words, size_t size)
{
    static const char *const keys[][2] = {
        {"quiltd", "the release of quiltd"},  {"frame", "the frame"},
        {"camera_row", "the row of cameras"}, {"shutter_part", "the part of the shutter"},
        {"rows", "the image rows"},           {"stream", "the random stream"},
        {"views", "the number of views"},     {"width", "the views' width"},
        {"height", "the views' height"},      {"seed", "the seed"},
        {"integrator", "the integrator"},     {"reconstruct", "--denoise"}};
    const json_t *hashes = json_object_get(there, "hashes"), *ours = json_object_get(of, "hashes");
    words[0] = '\0';
    if (differs(hashes, ours, "scene"))
        lf_list_add(words, size, "the scene");
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++)
        if (differs(there, of, keys[i][0]))
            add_said(words, size, keys[i][1], there, of, keys[i][0]);
    if (differs(hashes, ours, "camera"))
        lf_list_add(words, size, "the camera");
    if (words[0] == '\0' && differs(hashes, ours, "all"))
        lf_list_add(words, size, "the render settings");
}

/* ------------------------------------------------------------------------------------- write -- */

/* The whole head; NULL: out of memory. */
static json_t *words_of(const json_t *of, const lf_job_progress *p)
{
    json_t *all = json_copy((json_t *)(uintptr_t)of),
           *progress = json_pack("{s:I, s:f, s:f, s:b}", "passes", (json_int_t)p->times.passes,
                                 "seconds", p->times.seconds, "cpu_seconds", p->times.cpu_seconds,
                                 "complete", p->complete);
    if (!all || !progress || json_object_update(all, progress) != 0) {
        json_decref(all);
        all = NULL;
    }
    json_decref(progress);
    return all;
}

lf_status lf_job_state_put(lf_outfile *file, const json_t *words, lf_error *err)
{
    char *text = words ? json_dumps(words, JSON_COMPACT) : NULL;
    if (!text)
        return lf_error_set(err, LF_E_NOMEM, file->path, "out of memory");
    head h = {.version = htole32(VERSION), .n = htole32((uint32_t)strlen(text))};
    memcpy(h.magic, magic, sizeof magic);
    h.crc = checksum(&h, text);
    lf_status status = lf_outfile_write(file, &h, sizeof h, err);
    if (status == LF_OK)
        status = lf_outfile_write(file, text, strlen(text), err);
    free(text);
    return status;
}

lf_status lf_job_state_write(const char *path, const json_t *of, const lf_renderer *renderer,
                             const lf_job_progress *progress, lf_error *err)
{
    lf_outfile file = {.fd = -1};
    json_t *words = words_of(of, progress);
    lf_status status = lf_outfile_open(&file, path, true, err);
    if (status == LF_OK)
        status = lf_job_state_put(&file, words, err);
    if (status == LF_OK)
        status = lf_renderer_save(renderer, &file, NULL, err);
    if (status == LF_OK)
        status = lf_outfile_commit(&file, true, err);
    lf_outfile_abandon(&file);
    json_decref(words);
    return status;
}

/* -------------------------------------------------------------------------------------- read -- */

#define REMEDY "; remove it or pass another --state FILE"

static lf_status damaged(const char *path, const char *what, lf_error *err)
{
    return lf_error_set(err, LF_E_FORMAT, path, "is damaged (%s)", what);
}

/* An error of lf_job_state_open with what to do about it. */
static lf_status with_remedy(const lf_error *why, lf_error *err)
{
    const bool bad = why->status == LF_E_FORMAT || why->status == LF_E_STATE;
    return lf_error_set(err, why->status, why->where, "%s%s", why->what, bad ? REMEDY : "");
}

static lf_status read_all(int fd, const char *path, void *data, size_t n, lf_error *err)
{
    char *p = data;
    while (n > 0) {
        const ssize_t got = read(fd, p, n);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return lf_error_set(err, LF_E_IO, path, "cannot read: %s", strerror(errno));
        if (got == 0)
            return damaged(path, "the file ends too early", err);
        p += got;
        n -= (size_t)got;
    }
    return LF_OK;
}

static bool is_progress(const json_t *words, lf_job_progress *out)
{
    const json_t *passes = json_object_get(words, "passes"),
                 *seconds = json_object_get(words, "seconds"),
                 *cpu = json_object_get(words, "cpu_seconds"),
                 *complete = json_object_get(words, "complete"),
                 *streams = json_object_get(words, "streams");
    out->times = (lf_render_times){.passes = json_integer_value(passes),
                                   .seconds = json_number_value(seconds),
                                   .cpu_seconds = json_number_value(cpu)};
    out->complete = json_is_true(complete);
    out->n_streams = streams ? (int)json_integer_value(streams) : 1;
    return out->n_streams >= 1 && json_is_integer(passes) && json_is_number(seconds) &&
           json_is_number(cpu) && json_is_boolean(complete) && out->times.passes >= 0 &&
           out->times.passes <= MOST_PASSES && out->times.seconds >= 0 &&
           out->times.cpu_seconds >= 0;
}

static bool is_number(const json_t *value, json_int_t low, json_int_t high)
{
    return json_is_integer(value) && json_integer_value(value) >= low &&
           json_integer_value(value) <= high;
}

/* Checks rows and stream; older files are of all rows and stream 0. */
static bool complete_place(json_t *words)
{
    const json_t *height = json_object_get(words, "height");
    if (!is_number(height, 1, LF_MAX_VIEW_SIDE))
        return false;
    const json_int_t last = json_integer_value(height) - 1;
    if (!json_object_get(words, "rows"))
        json_object_set_new(words, "rows", json_pack("[i, I]", 0, last));
    if (!json_object_get(words, "stream"))
        json_object_set_new(words, "stream", json_integer(0));
    const json_t *rows = json_object_get(words, "rows");
    return is_number(json_array_get(rows, 0), 0, last) &&
           is_number(json_array_get(rows, 1), json_integer_value(json_array_get(rows, 0)), last) &&
           json_array_size(rows) == 2 &&
           is_number(json_object_get(words, "stream"), 0, LF_MAX_STREAM);
}

/* Reads the header, up to the film. */
static lf_status read_head(int fd, const char *path, json_t **out, lf_error *err)
{
    head h;
    lf_job_progress progress;
    lf_status status = read_all(fd, path, &h, sizeof h, err);
    if (status != LF_OK)
        return status;
    if (memcmp(h.magic, magic, sizeof magic) != 0)
        return lf_error_set(err, LF_E_FORMAT, path, "is not the state of a job");
    if (le32toh(h.version) != VERSION)
        return lf_error_set(err, LF_E_STATE, path,
                            "is a state of version %" PRIu32 ", but this program reads version "
                            "%d",
                            le32toh(h.version), VERSION);
    const uint32_t n = le32toh(h.n);
    if (n > MOST_TEXT)
        return damaged(path, "its head is too long", err);
    char *text = lf_calloc((size_t)n + 1, 1);
    if (!text)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    status = read_all(fd, path, text, n, err);
    if (status == LF_OK && checksum(&h, text) != h.crc)
        status = damaged(path, "the checksum of its head is wrong", err);
    json_t *words = status == LF_OK ? json_loadb(text, n, 0, NULL) : NULL;
    if (status == LF_OK && (!is_progress(words, &progress) || !complete_place(words)))
        status = damaged(path, "its head describes no job", err);
    lf_free(text);
    if (status == LF_OK)
        *out = words;
    else
        json_decref(words);
    return status;
}

lf_status lf_job_state_open(const char *path, int *out_fd, uint64_t *out_size, json_t **out,
                            lf_error *err)
{
    int fd = -1;
    lf_status status = lf_file_open(path, NULL, UINT64_MAX, &fd, out_size, err);
    if (status != LF_OK)
        return status;
    status = read_head(fd, path, out, err);
    if (status == LF_OK)
        *out_fd = fd;
    else
        close(fd);
    return status;
}

/* An error of a film, which names this file. */
static lf_status of_film(const char *path, const lf_error *why, lf_error *err)
{
    const bool bad = why->status == LF_E_FORMAT;
    return lf_error_set(err, why->status, path, "%s%s%s%s", bad ? "is damaged (" : "", why->what,
                        bad ? ")" : "", bad || why->status == LF_E_STATE ? REMEDY : "");
}

/* renderer NULL: only the head. */
static lf_status restore(const char *path, const json_t *of, lf_renderer *renderer,
                         lf_job_progress *out_progress, lf_error *err)
{
    json_t *there = NULL;
    char words[384];
    int fd = -1;
    lf_error why = {0};
    lf_status status = lf_job_state_open(path, &fd, NULL, &there, &why);
    if (status != LF_OK)
        return with_remedy(&why, err);
    lf_job_state_differences(there, of, words, sizeof words);
    if (words[0] != '\0')
        status = lf_error_set(err, LF_E_STATE, path,
                              "is the state of another job, which differs in %s" REMEDY, words);
    if (status == LF_OK && renderer && lf_renderer_restore(renderer, fd, &why) != LF_OK)
        status = of_film(path, &why, err);
    if (status == LF_OK) {
        (void)is_progress(there, out_progress);
        out_progress->complete &= !differs(there, of, "budget");
    }
    close(fd);
    json_decref(there);
    return status;
}

lf_status lf_job_state_check(const char *path, const json_t *of, lf_job_progress *out_progress,
                             lf_error *err)
{
    return restore(path, of, NULL, out_progress, err);
}

lf_status lf_job_state_restore(const char *path, const json_t *of, lf_renderer *renderer,
                               lf_job_progress *out_progress, lf_error *err)
{
    return restore(path, of, renderer, out_progress, err);
}

lf_status lf_job_state_info(const char *path, json_t **out, lf_error *err)
{
    json_t *there = NULL;
    uint64_t size = 0;
    int film_rows = 0;
    lf_error why = {0};
    int fd = -1;
    lf_status status = lf_job_state_open(path, &fd, &size, &there, &why);
    if (status != LF_OK)
        return with_remedy(&why, err);
    status = lf_state_rows(fd, &film_rows, &why);
    close(fd);
    if (status != LF_OK) {
        json_decref(there);
        return of_film(path, &why, err);
    }
    json_object_set_new(there, "film_rows", json_integer(film_rows));
    json_object_set_new(there, "bytes", json_integer((json_int_t)size));
    *out = there;
    return LF_OK;
}
