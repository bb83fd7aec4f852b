/* The thread of a job: plan, submit, look until it has ended. */
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "daemon/parts/farmed_internal.h"

#define NAP_MS 20
/* Looks in a row at an interrupted job: a scheduler may be silent for a while. */
#define MOST_IDLE 30
enum { MOST_WORDS = LF_RENDER_WORDS + 16 };

/* Hands a look to the event thread. */
static void publish(lf_farmed_job *job, const lf_farmed_look *look, bool has_ended)
{
    pthread_mutex_lock(&job->lock);
    const bool posts = !job->posted;
    job->look = *look;
    job->has_ended = has_ended;
    job->posted = true;
    pthread_mutex_unlock(&job->lock);
    if (posts)
        lf_inbox_post(job->farmed->home.inbox, &job->news);
}

/* True if the job is to end before its time. */
static bool is_stopped(const lf_farmed_job *job)
{
    return atomic_load(&job->cancel) || atomic_load(&job->leave);
}

/* Waits until this time (lf_time_now_ns), or until the job is to end. */
static void wait_until(lf_farmed_job *job, uint64_t end_ns)
{
    pthread_mutex_lock(&job->lock);
    bool on = true;
    while (on && !is_stopped(job))
        on = lf_cond_wait_until(&job->wake, &job->lock, end_ns);
    pthread_mutex_unlock(&job->lock);
}

static void nap(void)
{
    nanosleep(&(struct timespec){.tv_nsec = NAP_MS * 1000000L}, NULL);
}

static lf_status out_of_memory(const lf_farmed_job *job, lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, job->order.folder.path, "out of memory");
}

static lf_status stopped(lf_error *err)
{
    return lf_error_set(err, LF_E_CANCELLED, "export", "cancelled");
}

static void set_state(lf_farmed_job *job, const char *state)
{
    lf_farmed_look look = job->look;
    snprintf(look.state, sizeof look.state, "%s", state);
    publish(job, &look, false);
}

/* ---------------------------------------------------------------------------------- children -- */

/* Runs quiltfarm to its end. what: the command. is_last: a job that is to end lets it run on.
 * *out_said (may be NULL) is what it printed. */
static lf_status call(lf_farmed_job *job, const char *what, const char *const words[],
                      double limit_s, bool is_last, char **out_said, lf_error *err)
{
    lf_farmed_child child;
    int ended = 0;
    lf_status status = lf_farmed_start(words, &child, err);
    if (status != LF_OK)
        return status;
    const double end = lf_time_now() + limit_s;
    while (status == LF_OK && !lf_farmed_has_ended(&child, &ended))
        if (is_last ? atomic_load(&job->leave) : is_stopped(job))
            status = stopped(err);
        else if (lf_time_now() >= end)
            status = lf_error_set(err, LF_E_TIMEOUT, LF_FARMED_PROGRAM,
                                  "%s has not ended within %.4g s", what, limit_s);
        else
            nap();
    if (status == LF_OK)
        status = lf_farmed_judge(&child, what, ended, err);
    if (status == LF_OK && out_said && !(*out_said = lf_farmed_said(&child)))
        status = lf_error_set(err, LF_E_FORMAT, LF_FARMED_PROGRAM, "%s prints too much", what);
    lf_farmed_drop(&child, status == LF_E_CANCELLED && is_last ? 0 : SIGKILL);
    return status;
}

/* -------------------------------------------------------------------------------- the folder -- */

static lf_status write_json(const lf_farmed_job *job, int folder_fd, const char *name, json_t *what,
                            lf_error *err)
{
    char *text = what ? json_dumps(what, JSON_INDENT(1)) : NULL;
    char *path = lf_held_path(folder_fd, name);
    lf_status status = text && path ? lf_outfile_text(path, text, err) : out_of_memory(job, err);
    free(text);
    lf_free(path);
    json_decref(what);
    return status;
}

/* The document as it is shown, for another folder. */
static json_t *make_scene(const lf_farmed_order *order)
{
    json_t *scene = lf_scene_json_absolute(order->content->scene);
    json_t *camera = json_object_get(scene, "camera");
    if (!scene || !order->camera)
        return scene;
    const int failed = json_is_object(camera) ? json_object_update(camera, order->camera)
                                              : json_object_set(scene, "camera", order->camera);
    if (failed == 0)
        return scene;
    json_decref(scene);
    return NULL;
}

static lf_status fill_folder(lf_farmed_job *job, int folder_fd, lf_error *err)
{
    lf_farmed_order *order = &job->order;
    lf_status status = write_json(job, folder_fd, LF_FARMED_SCENE, make_scene(order), err);
    if (status == LF_OK && order->has_calibration)
        status = write_json(job, folder_fd, LF_FARMED_PANEL,
                            lf_calibration_json(&order->calibration), err);
    lf_content_unref(order->content); /* the farm has its own */
    order->content = NULL;
    return status;
}

/* Of a job that was not planned; files of others in it stay. */
static void remove_folder(int parent_fd, const char *name, int folder_fd)
{
    (void)unlinkat(folder_fd, LF_FARMED_SCENE, 0);
    (void)unlinkat(folder_fd, LF_FARMED_PANEL, 0);
    (void)unlinkat(parent_fd, name, AT_REMOVEDIR);
}

/* ------------------------------------------------------------------------------ plan, submit -- */

static lf_status check_output(const lf_farmed_order *order, lf_error *err)
{
    return order->overwrite || access(order->file, F_OK) != 0
               ? LF_OK
               : lf_error_set(err, LF_E_EXISTS, order->file,
                              "exists; choose another name or set overwrite");
}

static lf_status plan(lf_farmed_job *job, lf_error *err)
{
    const lf_farmed_order *order = &job->order;
    const char *words[MOST_WORDS] = {LF_FARMED_PROGRAM, "plan",        order->folder.path,
                                     "--engine",        order->engine, "--"};
    char *scene = lf_path_join(order->folder.path, LF_FARMED_SCENE);
    int n = 6;
    if (!scene)
        return out_of_memory(job, err);
    words[n++] = scene;
    words[n++] = "-o";
    words[n++] = order->file;
    for (int i = 0; i < order->words.n; i++)
        words[n++] = order->words.list[i];
    lf_status status = call(job, "plan", words, job->farmed->home.plan_s, false, NULL, err);
    lf_free(scene);
    return status;
}

static lf_status prepare(lf_farmed_job *job, lf_error *err)
{
    const lf_held_name *folder = &job->order.folder;
    const char *name = strrchr(folder->path, '/') + 1;
    int fd = -1;
    bool made = false;
    lf_status status = check_output(&job->order, err);
    if (status == LF_OK)
        status = lf_held_folder(folder->folder_fd, name, &fd, &made, err);
    if (status == LF_OK && !made)
        status =
            lf_error_set(err, LF_E_EXISTS, folder->path, "exists; choose another name for the job");
    if (status == LF_OK)
        status = fill_folder(job, fd, err);
    if (status == LF_OK)
        status = plan(job, err);
    if (status != LF_OK && made)
        remove_folder(folder->folder_fd, name, fd);
    if (fd >= 0)
        close(fd);
    return status;
}

static lf_status begin_submit(lf_farmed_job *job, lf_error *err)
{
    const char *const words[] = {LF_FARMED_PROGRAM, "submit", job->order.folder.path, NULL};
    set_state(job, "submitting");
    lf_farmed_record_write(job);
    return lf_farmed_start(words, &job->submit, err);
}

/* ----------------------------------------------------------------------------------- looking -- */

/* Waits for the next look, which is due as soon as submit has ended. LF_E_IO: submit has failed. */
static lf_status wait_for_look(lf_farmed_job *job, lf_error *err)
{
    const double interval = job->farmed->home.interval_s;
    const uint64_t end = lf_time_now_ns() + (uint64_t)(interval * (double)LF_NS_PER_S);
    int ended = 0;
    if (job->submit.pid == 0) {
        wait_until(job, end);
        return LF_OK;
    }
    while (lf_time_now_ns() < end && !is_stopped(job)) {
        if (lf_farmed_has_ended(&job->submit, &ended))
            return lf_farmed_judge(&job->submit, "submit", ended, err);
        nap();
    }
    return LF_OK;
}

/* A look that failed: the farm goes on, and the next look may succeed. */
static lf_status note_vain(lf_farmed_job *job, lf_error *err)
{
    lf_farmed_look look = job->look;
    char words[sizeof look.problem + sizeof *err];
    (void)lf_error_format(err, words, sizeof words);
    snprintf(look.problem, sizeof look.problem, "%.*s", (int)sizeof look.problem - 1, words);
    publish(job, &look, false);
    if (++job->vain < job->farmed->home.most_vain)
        return LF_OK;
    return lf_error_set(err, LF_E_IO, job->order.folder.path,
                        "quiltfarm status has failed %d times: %s", job->vain, look.problem);
}

/* GNU parallel ended with an earlier quiltd, if that was a service, and goes on here. */
static lf_status resume(lf_farmed_job *job, lf_error *err)
{
    const char *const words[] = {LF_FARMED_PROGRAM, "resume", job->order.folder.path, NULL};
    job->is_submitted = false; /* once */
    return lf_farmed_start(words, &job->submit, err);
}

/* Judges a look. *out_over: the job has ended. */
static lf_status judge_look(lf_farmed_job *job, const lf_farmed_look *look, const char *words,
                            bool *out_over, lf_error *err)
{
    const char *folder = job->order.folder.path;
    *out_over = strcmp(look->state, "complete") == 0;
    if (strcmp(look->state, "failed") == 0)
        return lf_error_set(err, LF_E_IO, folder,
                            "a task has failed: %.200s; mend it and run quiltfarm resume",
                            words ? words : "its words are in the folder log");
    const bool rests = strcmp(look->state, "interrupted") == 0 && job->submit.pid == 0;
    if (rests && job->is_submitted && strcmp(job->order.engine, "parallel") == 0)
        return resume(job, err);
    job->idle = rests ? job->idle + 1 : 0;
    return job->idle < MOST_IDLE ? LF_OK
                                 : lf_error_set(err, LF_E_IO, folder,
                                                "the farm has lost tasks; run quiltfarm resume");
}

static lf_status look_once(lf_farmed_job *job, bool *out_over, lf_error *err)
{
    const char *const words[] = {LF_FARMED_PROGRAM, "status", job->order.folder.path, "--json",
                                 NULL};
    char *said = NULL, *failed = NULL;
    lf_farmed_look look;
    lf_status status = call(job, "status", words, job->farmed->home.call_s, false, &said, err);
    if (status == LF_OK)
        status = lf_farmed_look_read(said, &look, &failed, err);
    lf_free(said);
    if (status == LF_E_CANCELLED)
        return status;
    if (status != LF_OK)
        return note_vain(job, err);
    job->vain = 0;
    publish(job, &look, false);
    status = judge_look(job, &look, failed, out_over, err);
    lf_free(failed);
    return status;
}

static lf_status follow(lf_farmed_job *job, lf_error *err)
{
    lf_status status = LF_OK;
    bool over = false;
    while (status == LF_OK && !over) {
        if (is_stopped(job))
            status = stopped(err);
        else
            status = look_once(job, &over, err);
        if (status == LF_OK && !over)
            status = wait_for_look(job, err);
    }
    return status;
}

/* ----------------------------------------------------------------------------------- the end -- */

/* Lets quiltfarm cancel the job. Its tasks may run on if that fails, which the error says. A submit
 * in progress gets TERM only then, since a second one would end tasks before they save. */
static lf_status cancel(lf_farmed_job *job, lf_error *err)
{
    const char *const words[] = {LF_FARMED_PROGRAM, "cancel", job->order.folder.path, NULL};
    lf_status status = call(job, "cancel", words, job->farmed->home.call_s, true, NULL, err);
    if (status != LF_OK && job->submit.pid > 0 && kill(-job->submit.pid, SIGTERM) == 0)
        status = LF_OK;
    return status == LF_OK ? stopped(err) : status;
}

/* Waits for the end of a submit that is not needed any more, so that no zombie stays. */
static void finish_submit(lf_farmed_job *job)
{
    const double end = lf_time_now() + job->farmed->home.call_s;
    int ended = 0;
    while (job->submit.pid > 0 && lf_time_now() < end && !atomic_load(&job->leave) &&
           !lf_farmed_has_ended(&job->submit, &ended))
        nap();
    lf_farmed_drop(&job->submit, 0);
}

void lf_farmed_run(lf_farmed_job *job)
{
    lf_error *err = &job->err;
    lf_status status = LF_OK;
    bool is_submitted = job->is_submitted;
    if (!is_submitted) {
        publish(job, &job->look, false);
        status = prepare(job, err);
        is_submitted = status == LF_OK && !is_stopped(job);
        status = is_submitted ? begin_submit(job, err) : status == LF_OK ? stopped(err) : status;
        if (status == LF_OK)
            status = wait_for_look(job, err);
    }
    if (status == LF_OK)
        status = follow(job, err);
    if (is_submitted && atomic_load(&job->cancel) && status == LF_E_CANCELLED)
        status = cancel(job, err);
    finish_submit(job);
    lf_content_unref(job->order.content);
    job->order.content = NULL;
    if (job->record && is_submitted && !atomic_load(&job->leave))
        (void)unlink(job->record);
    job->status = status;
    publish(job, &job->look, true);
}
