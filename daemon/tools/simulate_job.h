/* Private to daemon/tools: one run of quiltrender --simulate, and what it says in numbers. */
#ifndef LF_TOOLS_SIMULATE_JOB_H
#define LF_TOOLS_SIMULATE_JOB_H

#include <jansson.h>

#include "daemon/tools/simulate.h"
#include "quilt/profiles.h"
#include "quilt/proof/print_file.h"
#include "quilt/proof/simulate.h"
#include "quilt/proof/study.h"

typedef struct lf_simulate_job {
    lf_simulate_options options;
    lf_print print;   /* the sheet, as options and profiles say */
    lf_print printed; /* what was printed, by the manifest */
    lf_profile_names names;
    lf_print_given given;
    const char *useless; /* the first option that does nothing here */
    bool eyes_given;     /* --eye-distance */
    const char *in, *out;
    lf_print_file *file;
    json_t *manifest;
    lf_profiles profiles;
    lf_proof_sheet sheet;
    lf_image_notes notes; /* assumptions */
    lf_eye eye;
    const lf_cancel *cancel;
} lf_simulate_job;

/* The sheet and the eye, for what is written; a new reference. */
json_t *lf_simulate_settings(const lf_simulate_job *job);
/* Prints what is true of the whole print. */
void lf_simulate_tell(const lf_simulate_job *job);
/* lf_proof_depth_of from the eye's distance; prints what it found. */
LF_NODISCARD lf_status lf_simulate_study(lf_simulate_job *job, lf_proof_depth *out, lf_error *err);
/* Writes all numbers to job->out. */
LF_NODISCARD lf_status lf_simulate_report(lf_simulate_job *job, lf_error *err);

#endif
