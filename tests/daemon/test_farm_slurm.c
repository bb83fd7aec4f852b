/* The program quiltfarm with programs of Slurm that are the test's own (tests/farm/fake-slurm). */
#include "tests/daemon/quiltfarm.h"

/* For the shell: the id of the plan. */
#define ID "\"$(sed -n 's/^ \"id\": \"\\(.*\\)\",/\\1/p' job/job.json)\""

/* Runs shell words with programs of Slurm that are the test's own (tests/farm/fake-slurm). */
static void slurm_says(const char *folder, const char *line, int code, const char *words)
{
    char source[PATH_MAX], all[2 * PATH_MAX];
    assert_non_null(realpath(lf_test_source("tests/farm/fake-slurm"), source));
    snprintf(all, sizeof all, "PATH=%s:$PATH; %s", source, line);
    says(folder, all, code, words);
}

static void plan_slurm(const char *folder, const char *config)
{
    says(folder, "bin/quiltfarm plan job --engine slurm --threads 3 -- scene.json -o out", 0,
         "for slurm");
    lf_test_write(folder, "config", config);
}

/* Slurm's programs are called in this test's folder. */
static void assert_sent(const char *folder, int line, const char *words)
{
    char command[256];
    snprintf(command, sizeof command, "sed -n %dp sbatch.log", line);
    says(folder, command, 0, words);
}

static void arrays_and_dependencies_fit_the_limits_of_the_cluster(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "MaxArraySize            = 3\nMaxJobCount             = 10000\n");
    slurm_says(folder, "bin/quiltfarm submit job --slots 4 -- -p render", 0,
               "sent to Slurm as job-");
    assert_sent(folder, 1, "--array=0-2%2 ");
    assert_sent(folder, 1, "--cpus-per-task=3 ");
    assert_sent(folder, 1, "--mem=321M "); /* 1.25 times 256 MiB and 1 */
    assert_sent(folder, 1, "--time=10 -p render ");
    assert_sent(folder, 1, "task.sbatch task 0 1 ");
    assert_sent(folder, 2, "--array=0-1%2 ");
    assert_sent(folder, 2, "task.sbatch task 3 1 ");
    assert_sent(folder, 3, "--dependency=afterok:11_0:11_1 --kill-on-invalid-dep=yes");
    assert_sent(folder, 3, "task.sbatch finish 0 1 ");
    assert_sent(folder, 4, "--dependency=afterok:11_2:12_0 ");
    assert_sent(folder, 5, "--dependency=afterok:12_1 ");
    says(folder, "wc -l < sbatch.log", 0, "5\n");
}

static void a_nearly_full_cluster_gets_several_tasks_in_a_job(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "MaxArraySize = 1001\nMaxJobCount = 24\n");
    lf_test_write(folder, "others", "R\nR\nPD\nCD\n");
    slurm_says(folder, "bin/quiltfarm submit job", 0, "sent to Slurm");
    assert_sent(folder, 1, "--array=0-2 ");
    assert_sent(folder, 1, "task.sbatch task 0 2 ");
    assert_sent(folder, 2, "--dependency=afterok:11 ");
    assert_sent(folder, 2, "task.sbatch finish 0 3 ");
    lf_test_write(folder, "queue", "11 1 RUNNING None\n");
    slurm_says(folder, "bin/quiltfarm status job", 0, "0 of 5 complete, 2 running");
    says(folder, "rm queue; echo R >> others", 0, "");
    slurm_says(folder, "bin/quiltfarm submit job", 1, "Slurm holds 5 jobs, and takes no more now");
    says(folder, "wc -l < sbatch.log", 0, "2\n");
}

static void the_queue_is_shown_and_not_sent_twice(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "");
    lf_test_write(folder, "queue", "7 0 PENDING PartitionConfig\n"); /* of a removed job */
    slurm_says(folder, "bin/quiltfarm submit job", 1, "slurm has 1 of its steps");
    says(folder, "rm queue", 0, "");
    slurm_says(folder, "bin/quiltfarm submit job", 0, "sent to Slurm");
    lf_test_write(folder, "queue", "11 0 PENDING PartitionConfig\n");
    slurm_says(folder, "bin/quiltfarm status job", 0, "the processors of --threads?");
    lf_test_write(folder, "queue",
                  "11 0 RUNNING None\n11 1 COMPLETING None\n11 2 PENDING JobArrayTaskLimit\n"
                  "11 3 PENDING launch failed requeued held\n12 N/A PENDING Dependency\n");
    slurm_says(folder, "bin/quiltfarm status job", 0, "0 of 5 complete, 2 running");
    slurm_says(folder, "bin/quiltfarm status job", 0,
               "note      Slurm keeps 11_3 waiting: launch failed requeued held");
    slurm_says(folder, "bin/quiltfarm submit job", 1, "slurm has 5 of its steps");
    slurm_says(folder, "bin/quiltfarm resume job", 1, "slurm has 5 of its steps");
    slurm_says(folder, "bin/quiltfarm cancel job && cat scancel.log", 0, "--name=job-");
    /* what fails in the middle is known later */
    says(folder, "rm queue calls sbatch.log; echo 2 > full", 0, "");
    slurm_says(folder, "bin/quiltfarm submit job", 1, "sbatch: ended with status 1");
    says(folder, "cat job/sent.json", 0, "\"id\": 11");
    lf_test_write(folder, "queue", "11 0 PENDING Priority\n");
    slurm_says(folder, "bin/quiltfarm submit job", 1, "slurm has 1 of its steps");
    says(folder, "PATH=/nowhere; bin/quiltfarm submit job", 1,
         "squeue: not found; go to a machine with Slurm");
    says(folder, "PATH=/nowhere; bin/quiltfarm status job", 0, "showing only what is on the disk");
}

/* The script that Slurm runs is told to end in the states that Slurm may show then. */
static void script_says(const char *folder, const char *before, const char *slurm_state,
                        const char *requeued)
{
    char line[1024];
    snprintf(line, sizeof line,
             "rm -f requeue.log job/log/task_0.log; %s; echo '%s' > state; "
             "export SLURM_ARRAY_JOB_ID=11 SLURM_ARRAY_TASK_ID=0; "
             "sh job/task.sbatch task 0 1 \"$PWD/job\" \"$PWD/bin/quiltfarm\" " ID " & script=$!; "
             "until grep -qs 'from pass' job/log/task_0.log || ! kill -0 $script; do sleep 0.1; "
             "done; touch told; kill -TERM $script; wait $script; code=$?; "
             "echo \"ended with $code\"; cat requeue.log || echo 'not requeued'",
             before, slurm_state);
    slurm_says(folder, line, 0, "ended with 75");
    if (!strstr(got.text, requeued))
        fail_msg("%s, \"%s\": \"%s\" lacks \"%s\"", before, slurm_state, got.text, requeued);
}

static void a_task_that_was_cancelled_does_not_return_to_the_queue(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "");
    slurm_says(folder,
               "sed -i 's/\"wait\": 0.01/\"until\": \"now\"/' scene.json; bin/quiltfarm submit job",
               0, "sent to Slurm");
    script_says(folder, "true", "RUNNING None", "\n11_0\n");
    script_says(folder, "true", "COMPLETING TimeLimit", "\n11_0\n");
    script_says(folder, "true", "", "\n11_0\n"); /* Slurm is silent */
    script_says(folder, "true", "COMPLETING None", "not requeued");
    script_says(folder, "true", "CANCELLED None", "not requeued");
    /* before it begins, whatever Slurm shows, and while it runs */
    slurm_says(folder, "bin/quiltfarm cancel job", 0, "cancelled; running tasks save first");
    slurm_says(folder,
               "rm -f requeue.log; sh job/task.sbatch task 0 1 \"$PWD/job\" /bin/false " ID
               "; echo $?; ls "
               "requeue.log",
               2, "75\n");
    slurm_says(folder, "bin/quiltfarm resume job; ls job/log/cancelled", 2, "sent to Slurm");
    says(folder, "printf '#!/bin/sh\\ntouch job/log/cancelled; exit 75\\n' > own; chmod +x own", 0,
         "");
    slurm_says(folder,
               "echo RUNNING > state; sh job/task.sbatch task 0 1 \"$PWD/job\" ./own " ID
               "; echo $?; ls "
               "requeue.log",
               2, "75\n");
}

/* Slurm does not know what somebody runs by hand. */
static void a_task_that_runs_by_hand_is_not_sent(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "");
    slurm_says(
        folder,
        "sed -i 's/\"wait\": 0.01/\"until\": \"now\"/' scene.json; bin/quiltfarm task job 0 & "
        "task=$!; until grep -qs 'from pass' job/log/task_0.log; do sleep 0.1; done; "
        "bin/quiltfarm submit job; echo \"submit: $?\"; ls job/done; "
        "bin/quiltfarm status job; touch now; wait $task",
        0, "1 of its steps run, or were lost in the last 5 minutes");
    assert_non_null(strstr(got.text, "submit: 1\ntask_0.running\n"));
    assert_non_null(strstr(got.text, "0 of 5 complete, 1 running, 0 failed"));
    slurm_says(folder, "bin/quiltfarm submit job", 0, "sent to Slurm");
    says(folder, "echo '{\"host\": \"elsewhere\", \"pid\": 1}' > job/done/task_1.running", 0, "");
    slurm_says(folder, "bin/quiltfarm status job", 0, "1 of 5 complete, 1 running, 0 failed");
}

/* A job of an earlier build, whose plans had no id, may still be queued. */
static void a_job_without_an_id_can_be_cancelled(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "");
    slurm_says(folder, "bin/quiltfarm submit job", 0, "sent to Slurm as job-");
    says(folder,
         "sed -i '/^ \"id\": /d' job/job.json; sed -n 's/.*--job-name=\\(job-[0-9a-f]*\\)-.*/"
         "\\1/p' sbatch.log | sort -u > names",
         0, "");
    slurm_says(folder, "bin/quiltfarm status job", 0, "0 of 5 complete");
    slurm_says(folder, "bin/quiltfarm submit job", 1, "was planned by an earlier build");
    slurm_says(folder, "bin/quiltfarm task job 0", 1, "was planned by an earlier build");
    slurm_says(folder, "bin/quiltfarm cancel job", 0, "cancelled; running tasks save first");
    says(folder, "grep -q -e \"--name=$(cat names) \" scancel.log", 0, "");
    says(folder, "grep -q -e \"--name=$(cat names) \" squeue.log", 0, "");
    says(folder, "rm -r job", 0, "");
    plan_slurm(folder, "");
    slurm_says(folder, "bin/quiltfarm submit job", 1, "of an older plan");
}

/* Who does not like a plan removes its folder, and plans again under the same name. */
static void jobs_of_a_removed_folder_are_told_and_cancelled(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "");
    slurm_says(folder, "bin/quiltfarm submit job", 0, "sent to Slurm as job-");
    says(folder, "sed -n 's/.*--job-name=\\([^ ]*\\) .*/\\1/p' sbatch.log | sort -u > old", 0, "");
    says(folder,
         "cp job/task.sbatch old.sbatch; cp old names; echo job-12345678-0 >> names; cat old >> "
         "names; rm -r job",
         0, "");
    plan_slurm(folder, "");
    slurm_says(folder, "bin/quiltfarm submit job", 1, "of an older plan; quiltfarm cancel ends it");
    slurm_says(folder, "bin/quiltfarm submit job 2>&1 | grep -F -f old", 0, "Slurm still has job-");
    /* a task of the old plan that begins now */
    slurm_says(folder,
               "sh old.sbatch task 0 1 \"$PWD/job\" \"$PWD/bin/quiltfarm\" $(sed 's/.*-//' old); "
               "ls job/done",
               0, "/job: is not the job that was sent\n");
    slurm_says(folder, "bin/quiltfarm cancel job", 0, "an older plan is cancelled, job-");
    says(folder, "wc -l < scancel.log", 0, "1\n");
    says(folder, "grep -F -f old scancel.log", 0, "--name=job-");
    says(folder, "rm names", 0, "");
    slurm_says(folder, "bin/quiltfarm cancel job", 1, "was not submitted");
    slurm_says(folder, "bin/quiltfarm submit job", 0, "sent to Slurm as job-");
    says(folder, "tail -n 1 sbatch.log | grep -F -f old", 1, "");
    says(folder, "tail -n 1 sbatch.log | sed 's/.* \\([^ ]*\\) [0-9a-f]*$/\\1/'", 0,
         "/bin/quiltfarm\n");
}

static void a_submission_ends_when_it_is_cancelled(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "MaxArraySize = 2\nMaxJobCount = 10000\n");
    slurm_says(
        folder,
        "touch slow; bin/quiltfarm submit job & submit=$!; "
        "until [ -e sbatch.log ]; do sleep 0.1; done; "
        "bin/quiltfarm cancel job & cancel=$!; until [ -e scancel.log ]; do sleep 0.1; done; "
        "rm slow; wait $cancel || exit 3; wait $submit",
        75, "was cancelled");
    says(folder, "wc -l < sbatch.log", 0, "1\n");
    says(folder, "wc -l < scancel.log", 0, "2\n"); /* and after the submission */
    says(folder, "cat job/sent.json", 0, "\"id\": 11");
}

static void slots_hold_for_all_arrays_together(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "MaxArraySize = 2\nMaxJobCount = 10000\n");
    slurm_says(folder, "bin/quiltfarm submit job --slots 2", 0, "sent to Slurm");
    assert_sent(folder, 1, "--array=0-1%1 ");
    assert_sent(folder, 1, "task.sbatch task 0 2 ");
    assert_sent(folder, 2, "--array=0%1 ");
    assert_sent(folder, 2, "task.sbatch task 4 2 ");
    says(folder, "rm sbatch.log", 0, "");
    slurm_says(folder, "bin/quiltfarm submit job --slots 1", 0, "sent to Slurm");
    assert_sent(folder, 1, "%1 ");
    assert_sent(folder, 2, "task.sbatch finish ");
    says(folder, "rm sbatch.log", 0, "");
    slurm_says(folder, "bin/quiltfarm submit job --slots 4", 0, "sent to Slurm");
    assert_sent(folder, 1, "--array=0-1%2 ");
    assert_sent(folder, 2, "--array=0-1%1 ");
    assert_sent(folder, 3, "--array=0%1 ");
}

/* One task is missing, and there is room for a few jobs. */
static void the_missing_steps_decide_what_is_asked_for(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "MaxArraySize = 1001\nMaxJobCount = 20\n");
    says(folder,
         "sed -i 's/\"cpu_seconds\": 3[.0]*,/\"cpu_seconds\": 7200.0,/' job/job.json; "
         "bin/quiltfarm task job 0:1 && bin/quiltfarm task job 3:4 && bin/quiltfarm finish "
         "job 0 && bin/quiltfarm finish job 2",
         0, "");
    slurm_says(folder, "bin/quiltfarm submit job", 0, "sent to Slurm");
    assert_sent(folder, 1, "--array=2 ");
    assert_sent(folder, 1, "--time=130 "); /* 10 and 3 times 7200 s of 3 threads */
    assert_sent(folder, 1, "task.sbatch task 0 1 ");
    assert_sent(folder, 2, "--dependency=afterok:11_2 ");
    assert_sent(folder, 2, "task.sbatch finish ");
    says(folder, "wc -l < sbatch.log", 0, "2\n");
}

static void a_large_state_has_more_time_to_be_saved(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "");
    slurm_says(folder, "bin/quiltfarm submit job", 0, "sent to Slurm");
    assert_sent(folder, 1, "--signal=B:TERM@120 ");
    says(folder,
         "sed -i 's/\"state_bytes\": 2.*,/\"state_bytes\": 20e9,/' job/job.json; rm sbatch.log", 0,
         "");
    slurm_says(folder, "bin/quiltfarm submit job", 0, "sent to Slurm");
    assert_sent(folder, 1, "--signal=B:TERM@420 ");
    assert_sent(folder, 1, "--time=15 ");
}

static void words_and_environment_of_the_user_hide_no_job(void **state)
{
    const char *folder = *state;
    plan_slurm(folder, "");
    slurm_says(folder, "bin/quiltfarm submit job -- -J mine", 2, "is set by quiltfarm");
    slurm_says(folder, "bin/quiltfarm submit job -- --array=3", 2, "is set by quiltfarm");
    slurm_says(folder, "ls job/sent.json", 2, "No such file");
    slurm_says(folder, "bin/quiltfarm submit job -- -M other -p long", 0, "sent to Slurm");
    assert_sent(folder, 1, "-M other -p long ");
    says(folder, "cat scontrol.log", 0, "--clusters=other show config");
    lf_test_write(folder, "queue", "CLUSTER: other\n11 0 RUNNING None\n");
    lf_test_write(folder, "others", "11 1 COMPLETED None\n11 2 COMPLETED None\n");
    slurm_says(folder, "rm squeue.log; export SQUEUE_STATES=all; bin/quiltfarm submit job", 1,
               "slurm has 1 of its steps");
    says(folder, "cat squeue.log", 0, "--clusters=other --name=job-");
    says(folder, "grep -F -e \"--user=$(id -u),$(id -u) \" squeue.log", 0, "--user=");
    slurm_says(folder, "bin/quiltfarm cancel job", 0, "cancelled");
    says(folder, "cat scancel.log", 0, "--clusters=other --name=job-");
    says(folder, "grep -e \"--user=$(id -u)\" scancel.log", 0, "--user=");
    says(folder, "sed -i 's/\"uid\": [0-9]*/\"uid\": 4000000/' job/sent.json", 0, "");
    if (getuid() != 0)
        slurm_says(folder, "bin/quiltfarm cancel job", 1, "was submitted by user 4000000");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        in_folder(arrays_and_dependencies_fit_the_limits_of_the_cluster),
        in_folder(a_nearly_full_cluster_gets_several_tasks_in_a_job),
        in_folder(the_queue_is_shown_and_not_sent_twice),
        in_folder(a_task_that_was_cancelled_does_not_return_to_the_queue),
        in_folder(a_task_that_runs_by_hand_is_not_sent),
        in_folder(a_job_without_an_id_can_be_cancelled),
        in_folder(jobs_of_a_removed_folder_are_told_and_cancelled),
        in_folder(a_submission_ends_when_it_is_cancelled),
        in_folder(slots_hold_for_all_arrays_together),
        in_folder(the_missing_steps_decide_what_is_asked_for),
        in_folder(a_large_state_has_more_time_to_be_saved),
        in_folder(words_and_environment_of_the_user_hide_no_job),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
