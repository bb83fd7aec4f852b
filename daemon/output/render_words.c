#include "daemon/output/render_words.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/alloc.h"
#include "daemon/output/options.h"

void lf_render_words_finish(lf_render_words *words)
{
    for (int i = 0; i < words->n; i++)
        lf_free(words->list[i]);
    *words = (lf_render_words){0};
}

/* Takes ownership of word; NULL: out of memory. */
static void take(lf_render_words *words, char *word)
{
    if (word && words->n < LF_RENDER_WORDS) {
        words->list[words->n++] = word;
        return;
    }
    words->failed = true;
    lf_free(word);
}

void lf_render_words_add(lf_render_words *words, const char *format, ...)
{
    va_list ap;
    va_start(ap, format);
    const int n = vsnprintf(NULL, 0, format, ap);
    va_end(ap);
    char *word = n < 0 ? NULL : lf_calloc((size_t)n + 1, 1);
    va_start(ap, format);
    if (word)
        (void)vsnprintf(word, (size_t)n + 1, format, ap);
    va_end(ap);
    take(words, word);
}

void lf_render_words_row(lf_render_words *words, const lf_param *row, const void *object)
{
    take(words, lf_param_word(row, object));
}

static bool is_end(const lf_param *row)
{
    return !row->name && !row->option;
}

void lf_render_words_differing(lf_render_words *words, const lf_param *params, const char *names,
                               const void *object, const void *plain)
{
    for (const lf_param *row = params; !is_end(row); row = lf_param_next(row))
        if (lf_param_among(row, names) && !row->former && lf_param_differs(row, object, plain))
            lf_render_words_row(words, row, object);
}

static bool is_given(const lf_param *row, const json_t *given)
{
    const lf_param *end = lf_param_next(row);
    while (row < end && !(row->name && json_object_get(given, row->name)))
        row++;
    return row < end;
}

void lf_render_words_given(lf_render_words *words, const lf_param *params, const json_t *given,
                           const void *object)
{
    for (const lf_param *row = params; !is_end(row); row = lf_param_next(row))
        if (row->option && is_given(row, given))
            lf_render_words_row(words, row, object);
}

void lf_render_words_settings(lf_render_words *words, const lf_render_settings *settings,
                              lf_estimator estimator, bool denoise)
{
    static const lf_options none;
    const lf_options options = {
        .integrator = settings->integrator,
        .has_estimator = estimator != LF_ESTIMATOR_MWIS,
        .estimator = estimator,
        .sampler = settings->sampler,
        .seed = settings->seed,
        .max_depth = settings->max_depth,
        .tracing.has_light_paths = settings->light_paths != LF_LIGHT_PATHS_AUTO,
        .tracing.light_paths =
            settings->light_paths > 0 ? settings->light_paths : (double)-INFINITY,
        .tracing.suffixes = lf_suffixes_word(settings->suffixes),
        .tracing.has_skip = settings->skip != LF_SKIP_ALL,
        .tracing.skip = settings->skip,
        .denoise = denoise ? LF_DENOISE_ON : LF_DENOISE_OFF};
    lf_render_words_differing(
        words, lf_option_params,
        "integrator estimator sampler max-depth light-paths suffixes skip seed denoise", &options,
        &none);
    for (const lf_param *row = lf_integrator_params(); !is_end(row); row = lf_param_next(row))
        if (lf_param_differs(row, &settings->choices, &none.choices))
            lf_render_words_row(words, row, &settings->choices);
}
