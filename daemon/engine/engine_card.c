/* Cards: text on the panel if there is no picture. */
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/thread.h"
#include "daemon/engine/engine_internal.h"

/* Largest code of a picture that looks black. */
enum { BLACK = 1 };

/* Draws a card with this text for the panel, or reuses the last one. */
static lf_status draw(lf_engine *engine, const char *words)
{
    const lf_calibration *panel = &engine->now.panel.calibration;
    int width, height;
    lf_card_size(panel->screen_width_px, panel->screen_height_px, &width, &height);
    if (engine->lens.card.image.data && engine->lens.card.image.width == width &&
        engine->lens.card.image.height == height && strcmp(engine->lens.card.words, words) == 0)
        return LF_OK;
    lf_image8_finish(&engine->lens.card.image);
    snprintf(engine->lens.card.words, sizeof engine->lens.card.words, "%s", words);
    return lf_card_draw(words, width, height, &engine->lens.card.image);
}

/* Interlaces the card as the only view. Linear filter, because its edges are a few lenses wide. */
static lf_status interlace(const lf_engine *engine, const lf_views8 *views, lf_image8 *out)
{
    lf_interlacer *interlacer;
    lf_error err;
    lf_status status =
        lf_interlacer_create(&engine->now.panel.calibration, 1, views->width, views->height, 0,
                             LF_FILTER_LINEAR, LF_INVERT_AUTO, &interlacer, &err);
    if (status != LF_OK) {
        lf_log_error(&err);
        return status;
    }
    lf_interlace(interlacer, views, out, engine->pool);
    lf_interlacer_destroy(interlacer);
    return LF_OK;
}

static void post(lf_engine *engine, const char *words)
{
    const bool present = engine->now.panel.present;
    lf_views8 views = {.n_views = 1};
    engine->frames.at = lf_time_now();
    if (present && draw(engine, words) != LF_OK) {
        lf_log(LF_LOG_ERROR, "out of memory for a card");
        return;
    }
    if (present) {
        views.width = engine->lens.card.image.width;
        views.height = engine->lens.card.image.height;
        views.row_stride = engine->lens.card.image.stride;
        views.data = engine->lens.card.image.data;
    }
    lf_frame *frame = engine_begin_frame(engine, present);
    if (!frame || (present && interlace(engine, &views, &frame->image) != LF_OK))
        return;
    snprintf(frame->card, sizeof frame->card, "%s", words);
    frame->reconstructed = false;
    frame->columns = frame->rows = 1;
    engine_end_frame(engine, frame, present ? &views : NULL, true);
}

void engine_post_waiting_card(lf_engine *engine)
{
    const char *words = engine->now.card.words;
    if (words[0] != '\0' && (!engine->content || !engine->frames.has_picture))
        post(engine, words);
}

void engine_take_card(lf_engine *engine, const engine_card *card)
{
    const bool news = strcmp(engine->now.card.words, card->words) != 0;
    engine->now.card = *card;
    if (news)
        engine_post_waiting_card(engine);
}

static bool is_black(const lf_views8 *views)
{
    for (int y = 0; y < views->height; y++) {
        for (int v = 0; v < views->n_views; v++) {
            const uint8_t *row = lf_views8_row(views, v, y);
            for (int i = 0; i < views->width * 3; i++)
                if (row[i] > BLACK)
                    return false;
        }
    }
    return true;
}

bool engine_post_dark_card(lf_engine *engine, const lf_views8 *views)
{
    const lf_content *content = engine->content;
    if (!content->scene || content->is_frame || engine->level < LF_LEVEL_COARSE || !is_black(views))
        return false;
    char words[LF_CARD_TEXT];
    const char *slash = strrchr(content->file, '/');
    snprintf(words, sizeof words,
             "%.120s: the image is black. No light reaches what the camera sees, or the exposure "
             "is too low.",
             slash ? slash + 1 : content->file);
    post(engine, words);
    return true;
}

void lf_engine_set_card(lf_engine *engine, const char *words)
{
    pthread_mutex_lock(&engine->lock);
    snprintf(engine->wanted.card.words, sizeof engine->wanted.card.words, "%s", words);
    engine->news.card = true;
    pthread_cond_broadcast(&engine->wake);
    pthread_mutex_unlock(&engine->lock);
}
