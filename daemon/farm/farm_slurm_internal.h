/* What farm_slurm.c says to Slurm's programs. Thread: as farm_engine.h. */
#ifndef LF_DAEMON_FARM_SLURM_INTERNAL_H
#define LF_DAEMON_FARM_SLURM_INTERNAL_H

#include <sys/types.h>

#include "daemon/farm/farm_job.h"

/* Runs one of Slurm's programs; *out_text (lf_free): what it prints. The user's filters of squeue
 * and scancel in the environment are forgotten. LF_E_IO: it is not there, or failed. */
LF_NODISCARD lf_status lf_farm_slurm_call(lf_farm_words *words, char **out_text, lf_error *err);
/* The name of the job in the queue: of its folder, with hashes of its path and of its plan. */
#define LF_FARM_SLURM_NAME 128
void lf_farm_slurm_name(const lf_farm_job *job, char buf[LF_FARM_SLURM_NAME]);
/* The names in the queue of older plans of the folder, each once: it was removed while Slurm had
 * them. Release with lf_farm_words_finish. LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_farm_slurm_older(const lf_farm_job *job, const json_t *sent,
                                           lf_farm_words *out, lf_error *err);

/* Adds the cluster that the words for sbatch name, if they do. */
void lf_farm_slurm_cluster(char *const *given, lf_farm_words *words);
/* The same for the words of sent.json. */
void lf_farm_slurm_sent_cluster(const json_t *sent, lf_farm_words *words);
/* LF_E_ARG: words that quiltfarm needs itself. A job of another name could not be found again. */
LF_NODISCARD lf_status lf_farm_slurm_check_words(char *const *words, lf_error *err);
/* The user whose jobs they are: who sent them; else this one. */
uid_t lf_farm_slurm_owner(const json_t *sent);

#endif
