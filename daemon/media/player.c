#include "daemon/media/player.h"

#include <limits.h>
#include <poll.h>
#include <pthread.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/thread.h"
#include "base/wakeup.h"
#include "daemon/media/decoder.h"
#include "daemon/media/movie_clock.h"

#define N_FRAMES 3
#define LOOK_MS 50
/* The next round's ffmpeg is started this long before the end, in seconds. */
#define AHEAD_S 1
#define NEVER UINT64_MAX
/* A video that ends earlier than it says is told of. */
#define SHORT_S 1
#define SHORT_SHARE 0.9

/* A frame in memory. */
typedef struct slot {
    int at;         /* index in player->frames; -1: none */
    int64_t number; /* since the start, for the clock */
    int64_t in_round, round;
} slot;

static const slot no_slot = {.at = -1};

struct lf_player {
    lf_movie movie;
    uint8_t *frames[N_FRAMES];
    pthread_t thread;
    void (*news)(void *context);
    void *context;
    int wakeup;
    bool started;

    /* owned by the thread */
    bool is_full;    /* filling is whole */
    bool is_over;    /* no more frames follow */
    bool is_late;    /* ffmpeg was not started ahead of this round */
    bool is_endless; /* decoder plays all further rounds */
    bool is_next_endless;
    bool told_of_waiting;
    lf_decoder *decoder, *next; /* of this round, of the next one */
    slot filling;
    int64_t n_read;   /* frames read since the start */
    int64_t in_round; /* of them, in this round */
    int64_t n_round;  /* frames of a whole round; 0: not known yet */
    int64_t round;    /* of the frames that are read */

    pthread_mutex_t lock;
    /* under lock */
    lf_movie_clock clock;
    slot waiting; /* until it is due */
    slot newest;  /* due and not taken */
    slot held;    /* taken */
    lf_player_status status;
    bool once, stop;
};

/* ------------------------------------------------------------------------------------ frames -- */

static slot free_slot(const lf_player *player)
{
    slot found = no_slot;
    for (int i = 0; i < N_FRAMES; i++)
        if (i != player->waiting.at && i != player->newest.at && i != player->held.at)
            found.at = i;
    return found;
}

/* A frame becomes the newest one. */
static void hand_over(lf_player *player)
{
    lf_player_status *s = &player->status;
    if (player->newest.at >= 0)
        s->dropped++;

    player->newest = player->waiting;
    player->waiting = no_slot;
    s->due++;
    s->rounds = player->newest.round;
    s->frame = player->newest.in_round;
    s->seconds = (double)s->frame / s->fps;
}

/* Looks at the frame that waits. True: something has changed. */
static bool judge(lf_player *player, uint64_t now, bool *out_moved)
{
    switch (lf_movie_clock_judge(&player->clock, player->waiting.number, now, out_moved)) {
    case LF_CLOCK_SHOW:
        hand_over(player);
        return true;
    case LF_CLOCK_DROP:
        player->waiting = no_slot;
        player->status.due++;
        player->status.dropped++;
        return true;
    case LF_CLOCK_WAIT:
        break;
    }
    return false;
}

/* After the last frame's time a video that does not loop has ended. */
static bool end_in_time(lf_player *player, uint64_t now)
{
    if (!player->is_over || player->status.ended || player->status.failed ||
        player->waiting.at >= 0 || player->clock.paused > 0 ||
        now < lf_movie_clock_due(&player->clock, player->n_read))
        return false;
    player->status.rounds = player->round + 1;
    player->status.ended = true;
    return true;
}

static void tell_news(lf_player *player)
{
    player->news(player->context);
}

/* ------------------------------------------------------------------------------------ rounds -- */

static void fail(lf_player *player, const lf_error *err)
{
    player->is_over = true;
    player->is_full = false;
    pthread_mutex_lock(&player->lock);
    player->waiting = no_slot;
    player->status.failed = true;
    player->status.err = *err;
    pthread_mutex_unlock(&player->lock);
    tell_news(player);
}

static void tell_short(const lf_player *player, int64_t n)
{
    const lf_movie_info *info = &player->movie.info;
    if (n < SHORT_SHARE * (double)info->n_frames &&
        (double)(info->n_frames - n) > SHORT_S * lf_movie_fps(&player->movie))
        lf_log(LF_LOG_WARNING,
               "%s: the video ends after %lld of %lld frames; its file may be incomplete",
               player->movie.file, (long long)n, (long long)info->n_frames);
}

static bool plays_once(lf_player *player)
{
    pthread_mutex_lock(&player->lock);
    const bool once = player->once;
    pthread_mutex_unlock(&player->lock);
    return once;
}

/* One ffmpeg plays all rounds of n frames that are shorter than its start may take. */
static bool is_short(const lf_player *player, int64_t n)
{
    return (double)n <= AHEAD_S * lf_movie_fps(&player->movie);
}

/* Starts ffmpeg for the next round shortly before the end of this one. A round's length is known
 * only after it; before, the file's word counts. */
static void look_ahead(lf_player *player)
{
    const int64_t n = player->n_round > 0 ? player->n_round : player->movie.info.n_frames;
    if (player->next || player->is_endless || n < 2 || !is_short(player, n - player->in_round) ||
        plays_once(player))
        return;
    player->is_next_endless = is_short(player, n);
    if (lf_decoder_create(&player->movie, player->is_next_endless, &player->next, NULL) != LF_OK)
        player->next = NULL; /* tried again at the end, where it is an error */
}

/* A round begins, by the ffmpeg that was started ahead if there is one. */
static void begin_round(lf_player *player)
{
    lf_error err;
    player->is_over = false;
    player->round++;
    player->in_round = 0;
    player->is_late = !player->next;
    player->is_endless =
        player->is_late ? is_short(player, player->n_round) : player->is_next_endless;
    player->decoder = player->next;
    player->next = NULL;
    if (!player->is_late ||
        lf_decoder_create(&player->movie, player->is_endless, &player->decoder, &err) == LF_OK)
        return;
    player->decoder = NULL;
    fail(player, &err);
}

static void end_round(lf_player *player)
{
    lf_decoder_destroy(player->decoder);
    player->decoder = NULL;
    if (player->n_round == 0)
        tell_short(player, player->in_round);
    player->n_round = player->in_round;
    player->is_over = player->n_round < 2 || plays_once(player);
    if (!player->is_over) {
        begin_round(player);
        return;
    }
    lf_decoder_destroy(player->next);
    player->next = NULL;
    if (player->n_round > 1)
        return;
    pthread_mutex_lock(&player->lock);
    player->status.still = true;
    pthread_mutex_unlock(&player->lock);
    tell_news(player);
}

/* After the last frame of a round of an endless ffmpeg. */
static void turn(lf_player *player)
{
    if (plays_once(player)) {
        end_round(player);
    } else {
        player->round++;
        player->in_round = 0;
    }
}

/* Reads what ffmpeg has delivered. */
static void read_frame(lf_player *player)
{
    lf_error err;
    lf_decoder_state state;
    if (lf_decoder_read(player->decoder, player->frames[player->filling.at], &state, &err) !=
        LF_OK) {
        fail(player, &err);
        return;
    }
    if (state == LF_DECODER_END) {
        end_round(player);
    } else if (state == LF_DECODER_FRAME) {
        player->filling.number = player->n_read++;
        player->filling.in_round = player->in_round++;
        player->filling.round = player->round;
        player->is_full = true;
        look_ahead(player);
        if (player->is_endless && player->in_round == player->n_round)
            turn(player);
    }
}

/* ------------------------------------------------------------------------------------ thread -- */

/* What the thread waits for. */
typedef struct agenda {
    bool stops, reads, changed, begins;
    uint64_t wait_ns; /* NEVER: without a limit */
} agenda;

/* A video that has ended is to loop after all. */
static bool begins_again(lf_player *player)
{
    if (!player->is_over || player->once || player->status.failed || player->n_round < 2)
        return false;
    player->status.ended = false;
    return true;
}

/* The whole frame waits until it is due. */
static void pass_on(lf_player *player, uint64_t now)
{
    player->waiting = player->filling;
    player->filling = no_slot;
    player->is_full = false;
    if (player->is_late)
        lf_movie_clock_resume(&player->clock, player->waiting.number, now);
    player->is_late = false;
}

/* Until the next frame is due, or the end of the last one. */
static uint64_t time_left(const lf_player *player, uint64_t now)
{
    const bool waits = player->waiting.at >= 0,
               ends = player->is_over && !player->status.ended && !player->status.failed;
    if (player->clock.paused > 0 || (!waits && !ends))
        return NEVER;
    const uint64_t due =
        lf_movie_clock_due(&player->clock, waits ? player->waiting.number : player->n_read);
    return due > now ? due - now : 0;
}

static agenda plan(lf_player *player)
{
    bool moved = false;
    pthread_mutex_lock(&player->lock);
    const uint64_t now = lf_time_now_ns();
    agenda a = {.stops = player->stop, .begins = begins_again(player)};
    if (player->is_full && player->waiting.at < 0)
        pass_on(player, now);
    if (player->waiting.at >= 0)
        a.changed = judge(player, now, &moved);
    if (!a.begins)
        a.changed |= end_in_time(player, now);
    if (player->filling.at < 0)
        player->filling = free_slot(player);
    a.reads = player->decoder && !player->is_over && !player->is_full && player->filling.at >= 0;
    a.wait_ns = time_left(player, now);
    if (a.reads && a.wait_ns > LOOK_MS * LF_NS_PER_MS)
        a.wait_ns = LOOK_MS * LF_NS_PER_MS;
    pthread_mutex_unlock(&player->lock);
    if (moved && !player->told_of_waiting) {
        lf_log(LF_LOG_WARNING,
               "%s: ffmpeg decodes it more slowly than %.4g frames a second; use a smaller video",
               player->movie.file, lf_movie_fps(&player->movie));
        player->told_of_waiting = true;
    }
    return a;
}

static void wait_and_read(lf_player *player, const agenda *a)
{
    struct pollfd fds[2] = {{player->wakeup, POLLIN, 0},
                            {a->reads ? lf_decoder_fd(player->decoder) : -1, POLLIN, 0}};
    const struct timespec wait = {(time_t)(a->wait_ns / LF_NS_PER_S),
                                  (long)(a->wait_ns % LF_NS_PER_S)};
    lf_error err;
    const int n = ppoll(fds, 2, a->wait_ns == NEVER ? NULL : &wait, NULL);
    if (fds[0].revents)
        lf_wakeup_clear(player->wakeup);
    if (!a->reads)
        return;
    read_frame(player);
    if (n == 0 && player->decoder && !player->is_over && !player->is_full &&
        lf_decoder_waited(player->decoder, (int)(a->wait_ns / LF_NS_PER_MS), &err) != LF_OK)
        fail(player, &err);
}

static void *player_main(void *context)
{
    lf_player *player = context;
    for (;;) {
        const agenda a = plan(player);
        if (a.stops)
            break;
        if (a.begins)
            begin_round(player);
        if (a.changed)
            tell_news(player);
        else if (!a.begins)
            wait_and_read(player, &a);
    }
    lf_decoder_destroy(player->decoder);
    lf_decoder_destroy(player->next);
    player->decoder = player->next = NULL;
    return NULL;
}

/* -------------------------------------------------------------------------------- the public -- */

/* Waits for the first frame. */
static lf_status read_first(lf_player *player, bool (*stopped)(void), lf_error *err)
{
    lf_decoder_state state = LF_DECODER_MORE;
    for (;;) {
        lf_status status = lf_decoder_read(player->decoder, player->frames[0], &state, err);
        if (status != LF_OK || state == LF_DECODER_FRAME)
            return status;
        if (stopped && stopped())
            return lf_error_set(err, LF_E_CANCELLED, player->movie.file, "cancelled");
        struct pollfd ready = {lf_decoder_fd(player->decoder), POLLIN, 0};
        if (poll(&ready, 1, LOOK_MS) == 0)
            status = lf_decoder_waited(player->decoder, LOOK_MS, err);
        if (status != LF_OK)
            return status;
    }
}

static lf_status allocate(lf_player *player, lf_error *err)
{
    for (int i = 0; i < N_FRAMES; i++)
        if (!(player->frames[i] = lf_calloc(player->movie.frame_bytes, 1)))
            return lf_error_set(err, LF_E_NOMEM, player->movie.file,
                                "not enough memory for three frames of %zu MB",
                                player->movie.frame_bytes / 1000000);
    player->wakeup = lf_wakeup_make();
    return player->wakeup >= 0
               ? LF_OK
               : lf_error_set(err, LF_E_NOMEM, player->movie.file, "no descriptors are left");
}

static void describe(lf_player *player)
{
    const lf_movie *movie = &player->movie;
    const bool swaps = lf_orientation_swaps(movie->info.orientation);
    player->status = (lf_player_status){.width = swaps ? movie->info.height : movie->info.width,
                                        .height = swaps ? movie->info.width : movie->info.height,
                                        .fps = lf_movie_fps(movie),
                                        .duration = movie->info.seconds};
}

lf_status lf_player_create(const char *path, const lf_roots *roots, int columns, int rows,
                           const lf_photo *photo, bool (*stopped)(void), lf_player **out_player,
                           lf_error *err)
{
    lf_player *player = lf_calloc(1, sizeof *player);
    if (!player)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    player->movie.fd = player->wakeup = -1;
    player->filling = player->waiting = player->newest = player->held = no_slot;
    pthread_mutex_init(&player->lock, NULL);
    lf_status status =
        lf_movie_open(path, roots, columns, rows, photo, stopped, &player->movie, err);
    if (status == LF_OK)
        status = allocate(player, err);
    if (status == LF_OK)
        status = lf_decoder_create(&player->movie, false, &player->decoder, err);
    if (status == LF_OK)
        status = read_first(player, stopped, err);
    if (status != LF_OK) {
        lf_player_destroy(player);
        return status;
    }
    player->newest.at = 0;
    player->n_read = player->in_round = 1;
    describe(player);
    *out_player = player;
    return LF_OK;
}

void lf_player_destroy(lf_player *player)
{
    if (!player)
        return;
    lf_player_stop(player);
    for (int i = 0; i < N_FRAMES; i++)
        lf_free(player->frames[i]);
    if (player->wakeup >= 0)
        close(player->wakeup);
    lf_movie_finish(&player->movie);
    pthread_mutex_destroy(&player->lock);
    lf_free(player);
}

const lf_movie *lf_player_movie(const lf_player *player)
{
    return &player->movie;
}

void lf_player_set_once(lf_player *player, bool once)
{
    pthread_mutex_lock(&player->lock);
    const bool changes = player->once != once;
    player->once = once;
    pthread_mutex_unlock(&player->lock);
    if (changes)
        lf_wakeup_signal(player->wakeup);
}

lf_status lf_player_start(lf_player *player, void (*news)(void *context), void *context)
{
    if (player->started)
        return LF_OK;
    player->news = news;
    player->context = context;
    pthread_mutex_lock(&player->lock); /* others may ask already */
    lf_movie_clock_start(&player->clock, player->movie.info.rate, player->movie.info.per,
                         lf_time_now_ns());
    lf_movie_clock_pause(&player->clock, player->status.paused, lf_time_now_ns());
    player->status.due = 1;
    pthread_mutex_unlock(&player->lock);
    lf_status status = lf_thread_start("lf-player", player_main, player, &player->thread);
    player->started = status == LF_OK;
    return status;
}

void lf_player_stop(lf_player *player)
{
    pthread_mutex_lock(&player->lock);
    player->stop = true;
    pthread_mutex_unlock(&player->lock);
    if (player->started) {
        lf_wakeup_signal(player->wakeup);
        pthread_join(player->thread, NULL);
        player->started = false;
    }
    lf_decoder_destroy(player->decoder);
    player->decoder = NULL;
}

void lf_player_pause(lf_player *player, bool paused)
{
    pthread_mutex_lock(&player->lock);
    lf_movie_clock_pause(&player->clock, paused, lf_time_now_ns());
    player->status.paused = paused;
    pthread_mutex_unlock(&player->lock);
    lf_wakeup_signal(player->wakeup);
}

bool lf_player_take(lf_player *player, lf_views8 *out)
{
    pthread_mutex_lock(&player->lock);
    const slot newest = player->newest;
    if (newest.at >= 0) {
        player->held = newest;
        player->newest = no_slot;
    }
    pthread_mutex_unlock(&player->lock);
    if (newest.at < 0)
        return false;
    *out = player->movie.views;
    out->data = player->frames[newest.at] + player->movie.first;
    lf_wakeup_signal(player->wakeup); /* a frame is free */
    return true;
}

void lf_player_get_status(lf_player *player, lf_player_status *out)
{
    pthread_mutex_lock(&player->lock);
    *out = player->status;
    pthread_mutex_unlock(&player->lock);
}
