/* Files beside what was noted of them: {"name": path, "bytes": n, "sha256": digits or missing}, as
 * in receipts and in the inputs of a plan. Thread: any. */
#ifndef LF_DAEMON_FARM_FILE_H
#define LF_DAEMON_FARM_FILE_H

#include "daemon/farm/farm_job.h"

typedef enum lf_farm_file {
    LF_FARM_FILE_SAME,
    LF_FARM_FILE_MISSING,    /* or no regular file */
    LF_FARM_FILE_OTHER_SIZE, /* also: the note is damaged */
    LF_FARM_FILE_OTHER_BYTES,
    LF_FARM_FILE_UNREADABLE
} lf_farm_file;

/* folder: of names that are relative. reads: compare the hash, too, if there is one. */
lf_farm_file lf_farm_file_compare(const char *folder, const json_t *note, bool reads);

/* Whether a step would render here what was planned. A process reads files and asks the renderer
 * once, and then compares sizes only. LF_E_STATE, in words: a file that the plan has read is
 * another one now, or the programs are of another release. */
LF_NODISCARD lf_status lf_farm_check_same(const lf_farm_job *job, int step, lf_error *err);
/* Only whether this program is of the job's release. LF_E_STATE. */
LF_NODISCARD lf_status lf_farm_check_release(const lf_farm_job *job, lf_error *err);

#endif
