/* When an accumulation is saved, and whose folder it is, without an engine: what there is to save,
 * and what becomes of it, is the test's. */
#include "tests/testing.h"

#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>

#include "daemon/parts/saver.h"
#include "tests/daemon/soon.h"

typedef struct owner {
    char *folder;
    sd_event *event;
    lf_inbox inbox;
    lf_saver *saver;
    pthread_t thread;
    lf_saved now; /* what there is; generation 0: nothing */
    int asked, ended;
    atomic_int saves;
    bool holds; /* a save, until may_end */
    sem_t may_end;
    atomic_bool here; /* the last was made on this thread */
    _Atomic lf_status status;
} owner;

static bool on_asked(void *context, lf_saved *out_now)
{
    owner *o = context;
    o->asked++;
    *out_now = o->now;
    return o->now.generation > 0;
}

static lf_status on_save(void *context, lf_error *err)
{
    owner *o = context;
    o->saves++;
    o->here = pthread_equal(pthread_self(), o->thread);
    if (o->holds)
        sem_wait(&o->may_end);
    return o->status == LF_OK ? LF_OK : lf_error_set(err, o->status, "state", "not now");
}

static void on_ended(void *context)
{
    owner *o = context;
    assert_false(lf_saver_is_busy(o->saver));
    o->ended++;
}

static int on_inbox(sd_event_source *source, int fd, uint32_t events, void *context)
{
    owner *o = context;
    (void)source, (void)fd, (void)events;
    lf_inbox_read(&o->inbox, NULL);
    return 0;
}

static lf_status make(owner *o, const char *folder, lf_saver **out, lf_error *err)
{
    static const lf_saver_events events = {.asked = on_asked, .save = on_save, .ended = on_ended};
    const lf_saver_home home = {
        .folder = folder, .usec = LF_SAVE_USEC, .event = o->event, .inbox = &o->inbox};
    return lf_saver_create(&home, &events, o, out, err);
}

static int set_up(void **state)
{
    lf_error err;
    owner *o = *state = calloc(1, sizeof *o);
    assert_non_null(o);
    o->folder = lf_test_folder();
    o->thread = pthread_self();
    o->now = (lf_saved){.generation = 1, .passes = 1};
    sem_init(&o->may_end, 0, 0);
    lf_assert_ok(lf_inbox_init(&o->inbox), NULL);
    assert_true(sd_event_new(&o->event) >= 0);
    assert_true(sd_event_add_io(o->event, NULL, o->inbox.event_fd, 1, on_inbox, o) >= 0);
    lf_assert_ok(make(o, o->folder, &o->saver, &err), &err);
    return 0;
}

static int tear_down(void **state)
{
    owner *o = *state;
    lf_saver_destroy(o->saver);
    lf_inbox_finish(&o->inbox, NULL);
    sd_event_unref(o->event);
    sem_destroy(&o->may_end);
    lf_test_folder_remove(o->folder);
    free(o);
    return 0;
}

/* Runs the loop until a count is so high, which it may be already. */
static void await(owner *o, const int *count, int expected)
{
    for (int i = 0; *count < expected && i < SOON_WAIT_S * 1000; i++)
        assert_true(sd_event_run(o->event, 1000000) >= 0);
    assert_true(*count >= expected);
}

/* The timer was due so many times more. */
static void await_asked(owner *o, int more)
{
    await(o, &o->asked, o->asked + more);
}

static void what_has_grown_is_saved_on_a_thread(void **state)
{
    owner *o = *state;
    for (int i = 0; i < 5; i++)
        assert_true(sd_event_run(o->event, 2 * SOON_USEC) >= 0);
    assert_int_equal(o->asked, 0); /* nothing was shown yet */
    lf_saver_begin(o->saver);
    await(o, &o->ended, 1);
    assert_false(o->here);
    await_asked(o, 3);
    assert_int_equal(o->saves, 1);
    o->now.passes = 2;
    await(o, &o->ended, 2);
    o->now = (lf_saved){.generation = 2, .passes = 1};
    await(o, &o->ended, 3);
    await_asked(o, 3);
    assert_int_equal(o->saves, 3);
}

static void nothing_is_not_saved_and_what_was_restored_is_not_either(void **state)
{
    owner *o = *state;
    o->now.generation = 0;
    lf_saver_begin(o->saver);
    await_asked(o, 3);
    o->now = (lf_saved){.generation = 7, .passes = 20};
    lf_saver_restored(o->saver, &o->now);
    await_asked(o, 3);
    lf_saver_save_now(o->saver);
    assert_int_equal(o->saves, 0);
    o->now.passes = 21;
    await(o, &o->ended, 1);
}

static void a_save_that_failed_is_made_again(void **state)
{
    owner *o = *state;
    o->status = LF_E_STATE;
    lf_saver_begin(o->saver);
    await(o, &o->ended, 3);
    o->status = LF_OK;
    await(o, &o->ended, o->ended + 1);
    int saves = o->saves;
    await_asked(o, 3);
    assert_int_equal(o->saves, saves);
}

static void one_save_is_under_way(void **state)
{
    owner *o = *state;
    o->holds = true;
    lf_saver_begin(o->saver);
    for (int i = 0; !lf_saver_is_busy(o->saver) && i < SOON_WAIT_S * 1000; i++)
        assert_true(sd_event_run(o->event, 1000000) >= 0);
    assert_true(lf_saver_is_busy(o->saver));
    o->now.passes = 2;
    for (int i = 0; i < 3; i++)
        assert_true(sd_event_run(o->event, 1000000) >= 0);
    assert_int_equal(o->ended, 0);
    sem_post(&o->may_end);
    sem_post(&o->may_end);
    await(o, &o->ended, 2);
    assert_int_equal(o->saves, 2);
}

static void from_its_stop_on_only_the_last_save_is_made(void **state)
{
    owner *o = *state;
    lf_saver_begin(o->saver);
    lf_saver_stop(o->saver);
    lf_saver_begin(o->saver);
    for (int i = 0; i < 5; i++)
        assert_true(sd_event_run(o->event, 2 * SOON_USEC) >= 0);
    assert_int_equal(o->saves, 0);
    lf_saver_save_now(o->saver);
    assert_int_equal(o->saves, 1);
    assert_true(o->here);
    assert_int_equal(o->ended, 0);
}

static void a_folder_is_one_savers_alone(void **state)
{
    owner *o = *state;
    lf_saver *other = NULL;
    lf_error err;
    lf_assert_status(make(o, o->folder, &other, &err), LF_E_BUSY, &err);
    lf_assert_status(make(o, lf_test_path(o->folder, "gone"), &other, &err), LF_E_IO, &err);
    lf_saver_destroy(o->saver);
    o->saver = NULL;
    lf_assert_ok(make(o, o->folder, &other, &err), &err);
    assert_non_null(lf_saver_states(other));
    lf_saver_destroy(other);
}

static void without_a_folder_nothing_is_saved(void **state)
{
    owner *o = *state;
    lf_saver *saver = NULL;
    lf_error err;
    lf_assert_ok(make(o, NULL, &saver, &err), &err);
    assert_null(lf_saver_states(saver));
    lf_saver_begin(saver);
    for (int i = 0; i < 5; i++)
        assert_true(sd_event_run(o->event, 2 * SOON_USEC) >= 0);
    lf_saver_save_now(saver);
    assert_int_equal(o->asked, 0);
    assert_int_equal(o->saves, 0);
    lf_saver_destroy(saver);
}

#define saver_test(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        saver_test(what_has_grown_is_saved_on_a_thread),
        saver_test(nothing_is_not_saved_and_what_was_restored_is_not_either),
        saver_test(a_save_that_failed_is_made_again),
        saver_test(one_save_is_under_way),
        saver_test(from_its_stop_on_only_the_last_save_is_made),
        saver_test(a_folder_is_one_savers_alone),
        saver_test(without_a_folder_nothing_is_saved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
