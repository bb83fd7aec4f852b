#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/farm/farm_process.h"
#include "daemon/farm/farm_slurm_internal.h"

/* ----------------------------------------------------------------------------------- program -- */

/* The user's filters of squeue and scancel would hide jobs. */
static void forget_filters(void)
{
    static const char *const names[] = {
        "ACCOUNT", "FORMAT", "NAME",  "NAMES", "PARTITION", "QOS",  "STATE",   "STATES",     "USER",
        "USERS",   "WCKEY",  "BATCH", "FULL",  "HURRY",     "CTLD", "SIBLING", "INTERACTIVE"};
    char name[32];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(name, sizeof name, "SQUEUE_%s", names[i]);
        (void)unsetenv(name);
        snprintf(name, sizeof name, "SCANCEL_%s", names[i]);
        (void)unsetenv(name);
    }
}

lf_status lf_farm_slurm_call(lf_farm_words *words, char **out_text, lf_error *err)
{
    int code = 0;
    forget_filters();
    lf_status status = words->failed ? lf_farm_no_memory("slurm", err)
                                     : lf_farm_process_read(words->list, out_text, &code, err);
    if (status == LF_E_IO)
        return lf_error_set(err, status, words->list[0],
                            "not found; go to a machine with Slurm, or plan with --engine list");
    if (status == LF_OK && code != 0) {
        status = lf_error_set(err, LF_E_IO, words->list[0],
                              "ended with status %d, as it says above", code);
        lf_free(*out_text);
        *out_text = NULL;
    }
    return status;
}

/* What the names of all plans of a folder begin with. Returns its length. */
static int name_of_folder(const lf_farm_job *job, char buf[LF_FARM_SLURM_NAME])
{
    uint32_t hash = 2166136261U; /* FNV-1a */
    const char *folder = strrchr(job->path, '/');
    char plain[64];
    size_t n = 0;
    for (const char *c = job->path; *c; c++)
        hash = (hash ^ (unsigned char)*c) * 16777619U;
    for (const char *c = folder ? folder + 1 : job->path; *c && n < sizeof plain - 1; c++)
        plain[n++] = isalnum((unsigned char)*c) ? *c : '_';
    plain[n] = '\0';
    return snprintf(buf, LF_FARM_SLURM_NAME, "%s-%08x-", plain, hash);
}

void lf_farm_slurm_name(const lf_farm_job *job, char buf[LF_FARM_SLURM_NAME])
{
    const int n = name_of_folder(job, buf);
    if (job->id[0] != '\0')
        snprintf(buf + n, LF_FARM_SLURM_NAME - (size_t)n, "%s", job->id);
    else
        buf[n - 1] = '\0';
}

static bool has_word(const lf_farm_words *words, const char *word)
{
    for (int i = 0; i < words->n; i++)
        if (strcmp(words->list[i], word) == 0)
            return true;
    return false;
}

lf_status lf_farm_slurm_older(const lf_farm_job *job, const json_t *sent, lf_farm_words *out,
                              lf_error *err)
{
    char own[LF_FARM_SLURM_NAME], folder[LF_FARM_SLURM_NAME];
    const size_t n = (size_t)name_of_folder(job, folder) - 1;
    lf_farm_words words = {0};
    char *text = NULL, *rest = NULL;
    lf_farm_slurm_name(job, own);
    lf_farm_words_add(&words, "squeue");
    lf_farm_words_add(&words, "--noheader");
    lf_farm_slurm_sent_cluster(sent, &words);
    lf_farm_words_add(&words, "--user=%ld", (long)lf_farm_slurm_owner(sent));
    lf_farm_words_add(&words, "--format=%%j");
    lf_status status = lf_farm_slurm_call(&words, &text, err);
    lf_farm_words_finish(&words);
    *out = (lf_farm_words){0};
    for (char *name = text ? strtok_r(text, "\n", &rest) : NULL; name;
         name = strtok_r(NULL, "\n", &rest))
        if (strncmp(name, folder, n) == 0 && (name[n] == '-' || name[n] == '\0') &&
            strcmp(name, own) != 0 && !has_word(out, name))
            lf_farm_words_add(out, "%s", name);
    lf_free(text);
    if (status == LF_OK && out->failed)
        status = lf_farm_no_memory("squeue", err);
    return status;
}

/* ------------------------------------------------------------------------------------- words -- */

/* The value of an option in the words for sbatch: "-M x", "-Mx", "--clusters x" or "--clusters=x",
 * also abbreviated. NULL: they do not have it. */
static const char *value_of(char *const *words, char letter, const char *name)
{
    const char *value = NULL;
    for (; *words; words++) {
        const char *word = *words;
        const size_t n = strcspn(word, "=");
        const bool is_short = word[0] == '-' && word[1] == letter;
        if (!is_short && (n < 5 || strncmp(word, name, n) != 0))
            continue;
        if (is_short ? word[2] != '\0' : word[n] == '=')
            value = word + (is_short ? 2 : n + 1);
        else
            value = words[1] ? *++words : "";
    }
    return value;
}

void lf_farm_slurm_cluster(char *const *given, lf_farm_words *words)
{
    const char *cluster = value_of(given, 'M', "--clusters");
    if (cluster)
        lf_farm_words_add(words, "--clusters=%s", cluster);
}

void lf_farm_slurm_sent_cluster(const json_t *sent, lf_farm_words *words)
{
    lf_farm_words given = {0};
    lf_farm_words_add_json(&given, json_object_get(sent, "words"), 0);
    if (given.list)
        lf_farm_slurm_cluster(given.list, words);
    words->failed |= given.failed;
    lf_farm_words_finish(&given);
}

lf_status lf_farm_slurm_check_words(char *const *words, lf_error *err)
{
    static const struct {
        char letter;
        const char *name;
    } own[] = {{'J', "--job-name"}, {'a', "--array"}, {'d', "--dependency"}};
    for (size_t i = 0; i < sizeof own / sizeof *own; i++)
        if (value_of(words, own[i].letter, own[i].name))
            return lf_error_set(err, LF_E_ARG, own[i].name,
                                "is set by quiltfarm; leave it out behind --");
    return LF_OK;
}

uid_t lf_farm_slurm_owner(const json_t *sent)
{
    const json_t *uid = json_object_get(sent, "uid");
    return json_is_integer(uid) ? (uid_t)json_integer_value(uid) : getuid();
}
