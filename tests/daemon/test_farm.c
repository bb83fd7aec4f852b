/* The program quiltfarm, with a renderer of the test's own (tests/farm/fake) and without a
 * scheduler. test_farm_slurm.c has one of the test's own; tests/farm.sh has schedulers, faults and
 * the real renderer. */
#include "tests/daemon/quiltfarm_job.h"

/* ----------------------------------------------------------------------------------- results -- */

static void tasks_and_a_merge_make_what_one_run_makes(void **state)
{
    const char *folder = *state;
    plan(folder);
    assert_state(folder, "planned");
    says(folder, "bin/quiltfarm submit job | wc -l", 0, "5\n");
    assert_state(folder, "queued");
    says(folder, "bin/quiltfarm merge job", 1, "5 of 5 tasks are not complete");
    says(folder, "sh -e job/tasks", 0, "task 4 is complete");
    assert_tasks(folder, "complete", 5);
    assert_state(folder, "queued");
    says(folder, "bin/quiltfarm status job", 0, "next: quiltfarm merge");
    says(folder, "bin/quiltfarm merge job", 0, "job: complete");
    assert_state(folder, "complete");
    says(folder, DIRECT " && " SAME, 0, "");
    says(folder, "ls job/states | wc -l", 0, "0\n");
    says(folder, "bin/quiltfarm submit job", 0, "complete");
    json_t *outputs = status_of(folder, "outputs");
    assert_int_equal(json_array_size(outputs), 3);
    says(folder, "bin/quiltfarm status job --json | grep '/out/field_0002.txt'", 0, "\"/");
    json_decref(outputs);
}

static void a_step_is_complete_while_its_files_have_their_sizes(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder, EVERYTHING, 0, "");
    says(folder, "echo more >> out/field_0001.txt", 0, "");
    assert_state(folder, "interrupted");
    says(folder, "bin/quiltfarm submit job", 0, "/job 2\n");
    says(folder, "rm out/field_0001.txt; " EVERYTHING, 0, "");
    assert_state(folder, "complete");
    says(folder, DIRECT " && " SAME, 0, "");
}

/* A disk may change bytes of a file, and keep its size. */
static void a_check_finds_bytes_that_differ_and_resume_repairs_them(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder, EVERYTHING " && bin/quiltfarm status job --check", 0, "complete");
    says(folder, "sed -i 's/^1 3 /1 4 /' out/field_0001.txt; bin/quiltfarm status job", 0,
         "complete");
    says(folder, "bin/quiltfarm status job --check", 1,
         "job: 1 output file is not as rendered; quiltfarm resume --check makes it again");
    says(folder, "bin/quiltfarm status job --check", 1, "/out/field_0001.txt\n");
    says(folder, "bin/quiltfarm status job --check --json 2> /dev/null | tr -d ' \n'", 0,
         "\"differing\":[\"/");
    says(folder, "bin/quiltfarm resume job", 0, "job: complete");
    says(folder, "bin/quiltfarm resume job --check", 0, "is made again");
    assert_non_null(strstr(got.text, "/job 2\n"));
    assert_null(strstr(got.text, "/job 1\n"));
    says(folder, EVERYTHING " && bin/quiltfarm status job --check && " DIRECT " && " SAME, 0, "");
}

/* As after a bad sector: the size is right, and nobody can read the bytes. */
static void a_check_lists_files_that_cannot_be_read(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder, EVERYTHING " && chmod 000 out/field_0001.txt && chmod 755 .", 0, "");
    says(folder,
         getuid() == 0 ? "setpriv --reuid=65534 --clear-groups bin/quiltfarm status job --check"
                       : "bin/quiltfarm status job --check",
         1, "  differs   /");
    assert_non_null(strstr(got.text, "/out/field_0001.txt: cannot be read"));
    says(folder, "bin/quiltfarm status job", 0, "complete");
}

static void only_what_is_missing_is_sent(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder, "bin/quiltfarm task job 1:2 && bin/quiltfarm submit job 2> /dev/null", 0,
         "/job 0\n");
    assert_null(strstr(got.text, "/job 1\n"));
    assert_null(strstr(got.text, "/job 2\n"));
    assert_non_null(strstr(got.text, "/job 3\n"));
    says(folder, "rm job/states/task_2_0001.lfstate; bin/quiltfarm submit job 2> /dev/null", 0,
         "/job 2\n");
}

static void an_older_state_of_a_lost_machine_is_not_merged(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder, "sh -e job/tasks", 0, "");
    /* as long as before, so that sizes do not tell */
    says(folder,
         "sed -i 's/\"complete\": true /\"complete\": false/; s/true,/null,/' "
         "job/states/task_1_0000.lfstate job/states/task_4_0002.lfstate",
         0, "");
    says(folder, "bin/quiltfarm merge job", 1, "task 1: must run again");
    says(folder, "bin/quiltfarm status job", 0, "submit task 4 again");
    assert_false(is_there(folder, "out/field_0000.txt"));
    assert_false(is_there(folder, "out/field_0002.txt"));
    assert_tasks(folder, "complete", 3);
    assert_true(is_there(folder, "job/states/task_1_0000.lfstate"));
    says(folder, "rm job/states/task_1_0000.lfstate", 0, "");
    says(folder, EVERYTHING " && " DIRECT " && " SAME, 0, "");
}

/* Submitting again repairs what is damaged, though sizes are right: by the words of quiltmerge, or
 * of the renderer if there is one part only. */
static void a_damaged_state_is_made_again(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder,
         "sh -e job/tasks && cd job/states && sed -i 's/^{/[/' task_2_0001.lfstate "
         "task_4_0002.lfstate",
         0, "");
    says(folder, "bin/quiltfarm merge job", 1, "task 2: must run again; resume the job");
    assert_non_null(strstr(got.text, "finish_2_0002.lfstate: is damaged"));
    says(folder, "bin/quiltfarm resume job 2> /dev/null | wc -l", 0, "2\n");
    says(folder, EVERYTHING " && " DIRECT " && " SAME, 0, "");
}

/* The states of two scenes: nobody knows which one is right. */
static void states_of_another_job_are_made_again(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder,
         "sh -e job/tasks && sed -i 's/\"passes\": 12/\"passes\": 13/' "
         "job/states/task_0_0000.lfstate",
         0, "");
    says(folder, "bin/quiltfarm merge job", 1, "must run again; resume the job (quiltmerge: ");
    says(folder, "bin/quiltfarm resume job 2> /dev/null", 0, "/job 0\n");
    assert_non_null(strstr(got.text, "/job 1\n"));
    assert_null(strstr(got.text, "/job 2\n"));
    says(folder, EVERYTHING " && " DIRECT " && " SAME, 0, "");
}

static void the_same_task_twice_at_once_is_harmless(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder,
         "bin/quiltfarm task job 0 & a=$!; bin/quiltfarm task job 0 & b=$!; wait $a && wait $b", 0,
         "task 0 is complete");
    says(folder, EVERYTHING " && " DIRECT " && " SAME, 0, "");
}

/* ---------------------------------------------------------------------------------- failures -- */

static void a_task_that_fails_leaves_its_words(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder,
         "cp scene.json good; sed -i '1s/{/{\"fail\": \"cloud.vdb: there is no such file\",/' "
         "scene.json; "
         "bin/quiltfarm task job 2",
         1, "cloud.vdb: there is no such file");
    assert_state(folder, "failed");
    assert_failed(folder, "quiltrender: cloud.vdb: there is no such file");
    says(folder, "bin/quiltfarm status job", 0, "failed    task 2, 1 time: quiltrender: cloud.vdb");
    assert_false(is_there(folder, "out/field_0001.txt"));
    says(folder, "bin/quiltfarm task job 2; bin/quiltfarm submit job", 0, "/job 2\n");
    says(folder, "bin/quiltfarm task job 2; bin/quiltfarm submit job", 0, "1 step is given up");
    assert_null(strstr(got.text, "/job 2\n"));
    /* GNU parallel, which tries again */
    says(folder, "PARALLEL_SEQ=1 bin/quiltfarm task job 2", 1,
         "job: task 2 is given up after 3 failures; use quiltfarm resume when this is mended: ");
    says(folder, "mv good scene.json; bin/quiltfarm resume job", 0, "/job 2\n");
    says(folder, EVERYTHING, 0, "");
    assert_state(folder, "complete");
}

static void a_killed_program_is_told(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder,
         "sed -i 's/\"wait\": 0.01/\"until\": \"now\"/' scene.json; bin/quiltfarm task job 0 & "
         "task=$!; "
         "until grep -qs 'from pass' job/log/task_0.log; do sleep 0.1; done; "
         "for p in /proc/[0-9]*; do [ \"$(readlink $p/cwd)\" != \"$PWD\" ] || "
         "! grep -qs '[q]uiltrender' $p/cmdline || kill -9 ${p#/proc/}; done; wait $task",
         1, "was killed, perhaps because memory was short");
    assert_failed(folder, "its last line: quiltrender: field 0: from pass 0");
    assert_tasks(folder, "failed", 1);
}

static void an_interrupted_task_goes_on_from_its_state(void **state)
{
    const char *folder = *state;
    plan(folder);
    for (int i = 0; i < 2; i++) /* TERM, then a hangup as of a lost ssh */
        says(folder,
             i == 0 ? "sed -i 's/\"wait\": 0.01/\"until\": \"now\"/' scene.json; bin/quiltfarm "
                      "task job 0 & task=$!; "
                      "until grep -qs 'from pass' job/log/task_0.log; do sleep 0.1; done; kill "
                      "-TERM $task; wait $task"
                    : "bin/quiltfarm task job 1 & task=$!; until grep -qs 'from pass' "
                      "job/log/task_1.log; do sleep 0.1; done; "
                      "kill -HUP $task; wait $task",
             75, "interrupted");
    assert_state(folder, "interrupted");
    assert_tasks(folder, "failed", 0);
    assert_true(is_there(folder, "job/states/task_0_0000.lfstate"));
    assert_true(is_there(folder, "job/states/task_1_0000.lfstate"));
    says(folder, "touch now; " EVERYTHING " && rm -r direct; " DIRECT " && " SAME, 0, "");
}

/* A full disk: exit status 75 would send the task back to the queue for ever. */
static void a_task_that_could_not_save_has_failed(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder,
         "sed -i 's/\"wait\": 0.01/\"until\": \"now\"/' scene.json; bin/quiltfarm task job 0 & "
         "task=$!; until grep -qs 'from pass' job/log/task_0.log; do sleep 0.1; done; "
         "mv job/states job/away; kill -TERM $task; wait $task",
         1, "");
    assert_failed(folder, "cannot write");
    says(folder, "mv job/away job/states; touch now; bin/quiltfarm task job 0", 0, "is complete");
}

/* The scheduler often signals every process; the renderer ends at once when a signal comes twice.
 */
static void a_signal_to_all_processes_saves_the_state(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder,
         "sed -i 's/\"wait\": 0.01/\"until\": \"now\"/' scene.json; setsid bin/quiltfarm task job "
         "0 & task=$!; "
         "until grep -qs 'from pass' job/log/task_0.log; do sleep 0.1; done; kill -TERM -$task; "
         "wait $task",
         75, "interrupted");
    assert_true(is_there(folder, "job/states/task_0_0000.lfstate"));
}

/* Hours pass between two tasks. */
static void a_file_that_changed_since_the_plan_is_told(void **state)
{
    const char *folder = *state;
    says(folder,
         "echo one > cloud; sed -i '1s/{/{\"inputs\": [\"scene.json\", \"cloud\"],/' scene.json", 0,
         "");
    plan(folder);
    says(folder, "bin/quiltfarm task job 0", 0, "is complete");
    says(folder, "echo two > cloud; bin/quiltfarm task job 1", 1,
         "cloud: has changed since the job was planned; restore it, or plan a new job");
    assert_failed(folder, "cloud: has changed");
    says(folder, "echo more >> cloud; bin/quiltfarm task job 1", 1, "cloud: has changed");
    says(folder, "rm cloud; bin/quiltfarm task job 1", 1, "cloud: is missing since");
    says(folder, "echo one > cloud; touch -d yesterday scene.json; sh -e job/tasks", 0,
         "task 4 is complete");
    says(folder, "echo ' ' >> scene.json; bin/quiltfarm merge job", 1, "scene.json: has changed");
    assert_false(is_there(folder, "out/field_0000.txt"));
}

static void a_process_asks_for_the_release_once(void **state)
{
    const char *folder = *state;
    says(folder,
         "mv bin/quiltrender bin/own; printf '#!/bin/sh\necho \"$1\" >> \"%s/calls\"\nexec "
         "\"%s/bin/own\" \"$@\"\n' \"$PWD\" \"$PWD\" > bin/quiltrender; chmod +x bin/quiltrender",
         0, "");
    plan(folder);
    says(folder, "bin/quiltfarm task job 0:4", 0, "task 4 is complete");
    says(folder, "grep -c -e --version calls", 0, "1\n");
}

/* It reads frames, which the scene may outlive or not. */
static void a_finish_that_joins_frames_compares_no_files(void **state)
{
    const char *folder = *state;
    says(folder,
         "echo one > cloud; sed -i 's/\"rows\": \\[[0-9, ]*\\]/\"rows\": null/g; s/\"plan\": "
         "{/\"inputs\": [\"cloud\"], \"plan\": {\"join\": [\"scene.json\", \"-o\", \"out\", "
         "\"--camera-rows\", \"0:2\"], /' scene.json",
         0, "");
    plan(folder);
    says(folder, "sh -e job/tasks; rm cloud; bin/quiltfarm merge job", 0, "job: complete");
}

/* A container has the scene under another name: its files mean nothing outside. */
static void files_that_only_the_renderer_sees_are_unknown(void **state)
{
    const char *folder = *state;
    says(folder,
         "echo one > cloud; sed -i '1s/{/{\"inputs\": [\"scene.json\", \"cloud\"],/' scene.json; "
         "mv bin/quiltrender bin/inside; printf '#!/bin/sh\nexec %s \"$@\" | "
         "sed s@\\\"cloud\\\"@\\\"/inside/cloud\\\"@\n' \"$PWD/bin/inside\" > "
         "bin/quiltrender; chmod +x bin/quiltrender",
         0, "");
    says(folder, PLAN, 0, "/inside/cloud: is not the same file outside the renderer");
    says(folder, "bin/quiltfarm task job 0", 0, "is complete");
    says(folder, "echo ' ' >> scene.json; bin/quiltfarm task job 1", 1, "scene.json: has changed");
}

static void another_release_is_told(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder, "echo 1.1 > bin/release; bin/quiltfarm task job 0", 1,
         "quiltrender: is release 1.1, and the job was planned with 1.0; use that release");
    assert_failed(folder, "is release 1.1");
    says(folder, "rm bin/release; bin/quiltfarm task job 0", 0, "is complete");
    says(folder,
         "sed -i '0,/\"quiltd\": \"[0-9.]*\"/s//\"quiltd\": \"0.0.1\"/' job/job.json; "
         "bin/quiltfarm task job 1",
         1, "quiltfarm: is release ");
    says(folder, "bin/quiltfarm submit job", 1, "the job was planned with 0.0.1");
    says(folder, "bin/quiltfarm status job", 0, "1 of 5 complete");
}

/* Time limits, and memory limits of a whole job, kill quiltfarm together with its program. */
static void tasks_that_were_killed_without_a_word_count_as_failed(void **state)
{
    const char *folder = *state;
    plan(folder);
    for (int i = 0; i < 3; i++)
        says(folder,
             "rm -f job/log/task_0.log; sed -i 's/\"wait\": 0.01/\"until\": \"now\"/' scene.json; "
             "bin/quiltfarm task job 0 & task=$!; "
             "until grep -qs 'from pass' job/log/task_0.log; do sleep 0.1; done; "
             "bin/quiltfarm submit job 2> said.busy && exit 3; grep -q '1 of its steps run' "
             "said.busy "
             "|| exit 4; kill -9 $task; wait $task 2> /dev/null; bin/quiltfarm submit job; true",
             0, i < 2 ? "/job 0\n" : "1 step is given up");
    assert_failed(folder, "was killed without a word");
    says(folder, "touch now; bin/quiltfarm resume job", 0, "/job 0\n");
    says(folder, EVERYTHING " && " DIRECT " && " SAME, 0, "");
}

/* A machine that is silent for less than five minutes may still render. */
static void a_step_that_runs_elsewhere_is_not_sent_again(void **state)
{
    const char *folder = *state;
    says(folder, "bin/quiltfarm plan job --engine parallel -- scene.json -o out", 0, "");
    says(folder, "echo '{\"host\": \"elsewhere\", \"pid\": 1}' > job/done/task_1.running", 0, "");
    says(folder, "bin/quiltfarm submit job", 1,
         "job: 1 of its steps run, or were lost in the last");
    assert_state(folder, "running");
    says(folder, "touch -d '6 minutes ago' job/done/task_1.running; bin/quiltfarm submit job", 0,
         "job: complete");
}

/* GNU parallel would try it three times. */
static void a_full_disk_is_not_tried_again(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder,
         "cp scene.json good; sed -i '1s/{/{\"fail\": \"out: No space left on device\",/' "
         "scene.json; "
         "bin/quiltfarm task job 2",
         1, "No space left on device");
    says(folder, "bin/quiltfarm submit job", 0, "1 step is given up");
    says(folder, "bin/quiltfarm status job", 0, "failed    task 2, 1 time: ");
    says(folder, "mv good scene.json; PARALLEL_SEQ=1 bin/quiltfarm task job 2", 1,
         "No space left on device");
    says(folder, "PARALLEL_SEQ=1 bin/quiltfarm task job 1", 0, "is complete");
    says(folder, "bin/quiltfarm resume job && PARALLEL_SEQ=1 bin/quiltfarm task job 2", 0,
         "task 2 is complete");
    /* a state that has no room is not begun */
    says(folder,
         "sed -i 's/\"state_bytes\": 2.*,/\"state_bytes\": 1e18,/' job/job.json; bin/quiltfarm "
         "task job 3",
         1, "and a task needs 1000 PB; make room, and resume the job");
    says(folder, "bin/quiltfarm submit job", 0, "1 step is given up");
    says(folder, "bin/quiltfarm status job", 0, "failed    task 3, 1 time: ");
    assert_false(is_there(folder, "job/log/task_3.log"));
}

/* A finish writes little, and then removes the states that fill the disk. */
static void a_finish_is_not_stopped_for_room(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder,
         "sh -e job/tasks && sed -i 's/\"state_bytes\": 2.*,/\"state_bytes\": 1e18,/' "
         "job/job.json; bin/quiltfarm merge job",
         0, "job: complete");
    says(folder, "ls job/states | wc -l", 0, "0\n");
}

/* The files of this process may have so many blocks: the disk is full as soon as job.json is. */
static void a_plan_that_fails_leaves_no_folder(void **state)
{
    const char *folder = *state;
    says(folder,
         "trap '' XFSZ; ulimit -f 1; bin/quiltfarm plan job --engine list -- scene.json -o out", 1,
         "job");
    assert_false(is_there(folder, "job"));
    says(folder,
         "mkdir job; cp scene.json job/; trap '' XFSZ; ulimit -f 1; bin/quiltfarm plan job "
         "--engine list -- job/scene.json -o out",
         1, "job");
    says(folder, "ls job", 0, "scene.json\n");
    says(folder, "ls job | wc -l", 0, "1\n");
    says(folder, "bin/quiltfarm plan job --engine list -- job/scene.json -o out", 0, "5 tasks");
}

/* ---------------------------------------------------------------------------------- mistakes -- */

static void mistakes_on_the_command_line_are_told(void **state)
{
    const char *folder = *state;
    says(folder, "bin/quiltfarm", 2, "COMMAND: is missing; see --help");
    says(folder, "bin/quiltfarm sbumit job", 2, "did you mean submit?");
    says(folder, "bin/quiltfarm status", 2, "status: expects JOB");
    says(folder, "bin/quiltfarm status a b", 2, "b: is one word too many; status expects JOB");
    says(folder, "bin/quiltfarm status job --slots 3", 2, "status: takes no --slots");
    says(folder, "bin/quiltfarm merge job --check", 2, "merge: takes no --check");
    says(folder, "bin/quiltfarm plan job scene.json -o out", 2,
         "-o: is no word of quiltfarm plan; pass words of quiltrender after --");
    says(folder, "bin/quiltfarm plan job scene.json", 2,
         "scene.json: is no word of quiltfarm plan");
    says(folder, "bin/quiltfarm resume job -p long", 2,
         "-p: is no word of quiltfarm resume; pass words of sbatch or parallel after --");
    says(folder, "bin/quiltfarm plan job -- scene.json -o", 2, "-o: expects an argument");
    says(folder, "bin/quiltfarm plan job -- scene.json -o job/", 2, "is the folder of a job");
    says(folder, "bin/quiltfarm plan job/ -- -ojob scene.json", 2, "is the folder of a job");
    says(folder, "bin/quiltfarm status job -- more", 2, "takes no words after --");
    says(folder, "bin/quiltfarm status job", 1, "there is no such folder");
    says(folder, "bin/quiltfarm plan job", 2, "pass it as -- SCENE -o OUT");
    says(folder, "bin/quiltfarm plan job --engine cloud -- scene.json -o out", 2,
         "expects slurm, parallel or list");
    says(folder, "bin/quiltfarm plan 'a%d' -- scene.json -o out", 2, "choose another name");
    says(folder, "bin/quiltfarm plan job -- gone.json -o out", 1,
         "gone.json: there is no such file");
    says(folder, "bin/quiltfarm plan no/job -- scene.json -o out", 1, "cannot be made");
    says(folder, "mkdir job; bin/quiltfarm status job", 1,
         "is no job, because job.json is missing");
    says(folder, PLAN, 1, "exists; choose a new folder");
    says(folder, "rmdir job", 0, "");
    plan(folder);
    says(folder, PLAN, 1, "exists; choose a new folder");
    says(folder, "bin/quiltfarm plan other -- scene.json -o job/", 2, "is the folder of a job");
    says(folder, "bin/quiltfarm task job 5", 2, "the job has 5, from 0");
    says(folder, "bin/quiltfarm task job 3:2", 2, "is no number of a step");
    says(folder, "bin/quiltfarm task job -- 3", 2, "expects JOB K");
    says(folder, "bin/quiltfarm finish job x", 2, "is no number of a step");
    says(folder, "bin/quiltfarm cancel job", 1, "was not submitted");
    says(folder, "bin/quiltfarm submit job; bin/quiltfarm cancel job", 1, "end the tasks there");
}

/* As quiltd makes it. */
static void a_folder_that_holds_the_scene_becomes_a_job(void **state)
{
    const char *folder = *state;
    says(folder, "mkdir job; cp scene.json job/", 0, "");
    says(folder, PLAN, 1, "exists; choose a new folder");
    says(folder, "touch job/README; bin/quiltfarm plan job --engine list -- job/scene.json -o out",
         1, "exists; choose a new folder");
    says(folder, "[ ! -s job/README ] && rm job/README && touch job/panel.json", 0, "");
    says(folder, "bin/quiltfarm plan job --engine list -- job/scene.json -o out", 0, "for list");
    says(folder, "bin/quiltfarm plan job --engine list -- job/scene.json -o out", 1,
         "exists; choose a new folder");
}

/* The path goes into lines of a shell and options of schedulers, however it was typed. */
static void the_whole_path_is_checked_for_what_schedulers_replace(void **state)
{
    static const char *const names[] = {"y\ntouch PWNED #", "100%a", "a\\b"};
    const char *folder = *state;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const char *there = lf_test_path(folder, names[i]);
        assert_int_equal(mkdir(there, 0755), 0);
        says(there, "../bin/quiltfarm plan job --engine list -- ../scene.json -o out", 2,
             "choose another name");
        assert_false(is_there(there, "job"));
    }
}

/* sent.json holds words that are run. A folder that quiltfarm makes is never so. */
static void a_job_that_others_can_write_is_not_run(void **state)
{
    static const char *const names[] = {"", "/job.json", "/sent.json", "/done", "/log"};
    const char *folder = *state;
    char words[256];
    says(folder, "umask 002; " PLAN " && bin/quiltfarm submit job", 0, "/job 4\n");
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(words, sizeof words, "chmod g+w job%s; bin/quiltfarm resume job", names[i]);
        says(folder, words, 1, "can be written by others");
        says(folder, "bin/quiltfarm task job 0", 1, "can be written by others");
        says(folder, "bin/quiltfarm merge job", 1, "can be written by others");
        says(folder, "chmod -R go-w job; bin/quiltfarm status job", 0, "queued");
    }
    says(folder, "mv job/sent.json s; ln -s ../s job/sent.json; bin/quiltfarm resume job", 1,
         "belongs to another user");
    says(folder, "mv s job/sent.json; echo before > s; ln -s ../../s job/log/task_0.log", 0, "");
    says(folder, "bin/quiltfarm task job 0 && cat s", 0, "before\n");
    says(folder, "cat s", 0, "before\n");
    assert_string_equal(got.text, "before\n");
    if (geteuid() == 0)
        says(folder, "chown 1 job; bin/quiltfarm resume job && exit; chown 0 job; false", 1,
             "belongs to another user");
    /* what programs make keeps the user's umask */
    says(folder, "umask 002; bin/quiltfarm task job 4; stat -c %A job/states/task_4*", 0,
         "-rw-rw-r--");
}

static void words_of_failures_do_not_steer_the_terminal(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder,
         "echo '{\"failures\": 1, \"words\": \"\\u001b]0;pwn\\u0007\"}' > "
         "job/done/task_0.failed; bin/quiltfarm status job",
         0, "\\x1b]0;pwn\\x07");
    assert_null(strchr(got.text, 27));
}

static void a_job_that_was_moved_is_refused(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder, "mv job away; bin/quiltfarm status away", 1, "move it back");
    says(folder, "mv away job; bin/quiltfarm status job", 0, "planned");
    says(folder, "ln -s job link; bin/quiltfarm status link", 0, "/job: planned");
}

/* Plans that are damaged in one place each. */
static void a_damaged_plan_makes_no_job(void **state)
{
    static const char *const changes[] = {
        "s/\"tasks\": \\[{/\"tusks\": [{/",
        "s/\"tasks\": \\[4, 4\\]/\"tasks\": [4, 5]/",
        "s/\"tasks\": \\[4, 4\\]/\"tasks\": [4, 3]/",
        "s/\"tasks\": \\[4, 4\\]/\"tasks\": null/",
        "s/\"rows\": \\[0, 11\\]/\"rows\": [0]/",
        "s/\"rows\": \\[0, 11\\]/\"rows\": [-1, 11]/",
        "s/\"rows\": \\[0, 11\\]/\"rows\": [0, 1e9]/",
        "s/\"rows\": \\[0, 11\\]/\"rows\": [0, \"b\"]/",
        "s/\"field_option\": \"--camera-rows\"/\"field_option\": null/",
        "s/\"cpu_seconds\": 6/\"cpu_seconds\": -6/"};
    const char *folder = *state;
    char words[512];
    says(folder, "cp scene.json good", 0, "");
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        snprintf(words, sizeof words, "sed '%s' good > scene.json; cmp -s good scene.json || " PLAN,
                 changes[i]);
        says(folder, words, 1, "is no plan of this version");
        assert_false(is_there(folder, "job"));
    }
    says(folder, "printf '#!/bin/sh\\necho }' > bin/quiltrender; " PLAN, 1, "its plan is not JSON");
}

static void damaged_files_of_a_job_are_refused_or_missing(void **state)
{
    const char *folder = *state;
    plan(folder);
    says(folder, EVERYTHING, 0, "");
    says(folder, "for f in job/done/*; do echo '{' > $f; done; bin/quiltfarm status job", 0,
         "planned");
    says(folder, "echo '[]' > job/job.json; bin/quiltfarm status job", 1, "job.json: is damaged");
    says(folder, "echo '{}' > job/job.json; bin/quiltfarm status job", 1, "is no plan");
}

static void the_plan_passes_words_on_and_tells_the_cost(void **state)
{
    const char *folder = *state;
    says(folder,
         "bin/quiltfarm plan job --engine list --task-minutes 5 --task-memory 2G --threads 3 "
         "--slots 2 -- scene.json -o out",
         0, "work        21 s of CPU time; the longest task 6.0 s");
    assert_non_null(strstr(got.text, "wall time   3.5 s with 2 tasks at once"));
    assert_non_null(strstr(got.text, "a task      3 threads, at most 30 MB of memory"));
    assert_non_null(strstr(got.text, "a finish    at most 10 MB of memory"));
    says(folder, "tr -d ' \\n' < job/job.json", 0,
         "\"asked\":{\"--task-minutes\":\"5\",\"--task-memory\":\"2G\"}");
    says(folder, "cat job/tasks", 0, "/bin/quiltfarm task /");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        in_folder(tasks_and_a_merge_make_what_one_run_makes),
        in_folder(a_step_is_complete_while_its_files_have_their_sizes),
        in_folder(a_check_finds_bytes_that_differ_and_resume_repairs_them),
        in_folder(a_check_lists_files_that_cannot_be_read),
        in_folder(only_what_is_missing_is_sent),
        in_folder(an_older_state_of_a_lost_machine_is_not_merged),
        in_folder(a_damaged_state_is_made_again),
        in_folder(states_of_another_job_are_made_again),
        in_folder(the_same_task_twice_at_once_is_harmless),
        in_folder(a_task_that_fails_leaves_its_words),
        in_folder(a_killed_program_is_told),
        in_folder(an_interrupted_task_goes_on_from_its_state),
        in_folder(a_task_that_could_not_save_has_failed),
        in_folder(a_signal_to_all_processes_saves_the_state),
        in_folder(a_file_that_changed_since_the_plan_is_told),
        in_folder(a_process_asks_for_the_release_once),
        in_folder(a_finish_that_joins_frames_compares_no_files),
        in_folder(files_that_only_the_renderer_sees_are_unknown),
        in_folder(another_release_is_told),
        in_folder(tasks_that_were_killed_without_a_word_count_as_failed),
        in_folder(a_step_that_runs_elsewhere_is_not_sent_again),
        in_folder(a_full_disk_is_not_tried_again),
        in_folder(a_finish_is_not_stopped_for_room),
        in_folder(a_plan_that_fails_leaves_no_folder),
        in_folder(mistakes_on_the_command_line_are_told),
        in_folder(a_folder_that_holds_the_scene_becomes_a_job),
        in_folder(the_whole_path_is_checked_for_what_schedulers_replace),
        in_folder(a_job_that_others_can_write_is_not_run),
        in_folder(words_of_failures_do_not_steer_the_terminal),
        in_folder(a_job_that_was_moved_is_refused),
        in_folder(a_damaged_plan_makes_no_job),
        in_folder(damaged_files_of_a_job_are_refused_or_missing),
        in_folder(the_plan_passes_words_on_and_tells_the_cost),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
