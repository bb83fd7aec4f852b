#include "daemon/server/button_actions.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

static const char *const action_names[LF_ACTIONS_N] = {"none", "next", "previous", "pause",
                                                       "reset"};

const char *lf_action_name(lf_action action)
{
    return action_names[action];
}

void lf_button_actions_default(lf_button_actions *out)
{
    *out = (lf_button_actions){.of = {[LF_BUTTON_SQUARE] = LF_ACTION_PAUSE,
                                      [LF_BUTTON_LEFT] = LF_ACTION_PREVIOUS,
                                      [LF_BUTTON_RIGHT] = LF_ACTION_NEXT,
                                      [LF_BUTTON_CIRCLE] = LF_ACTION_RESET}};
}

lf_button lf_button_of_name(const char *name)
{
    lf_button button = 0;
    while (button < LF_BUTTONS_N && strcmp(lf_button_name(button), name) != 0)
        button++;
    return button;
}

static lf_action action_of_name(const char *name)
{
    lf_action action = 0;
    while (action < LF_ACTIONS_N && strcmp(action_names[action], name) != 0)
        action++;
    return action;
}

/* One "button=action". */
static lf_status take_word(char *word, lf_button_actions *actions, lf_error *err)
{
    char *equals = strchr(word, '=');
    if (!equals)
        return lf_error_set(err, LF_E_ARG, "--buttons", "expected BUTTON=ACTION, got \"%s\"", word);
    *equals = '\0';
    lf_button button = lf_button_of_name(word);
    lf_action action = action_of_name(equals + 1);
    if (button == LF_BUTTONS_N)
        return lf_error_set(err, LF_E_ARG, "--buttons",
                            "unknown button \"%s\"; expected square, left, right or circle", word);
    if (action == LF_ACTIONS_N)
        return lf_error_set(err, LF_E_ARG, "--buttons",
                            "unknown action \"%s\"; expected none, next, previous, pause or reset",
                            equals + 1);
    actions->of[button] = action;
    return LF_OK;
}

lf_status lf_button_actions_parse(const char *text, lf_button_actions *out, lf_error *err)
{
    lf_button_actions actions = *out;
    char *words = lf_strdup(text), *rest = words, *word;
    lf_status status = words ? LF_OK : lf_error_set(err, LF_E_NOMEM, "--buttons", "out of memory");
    while (status == LF_OK && (word = strsep(&rest, ",")))
        status = take_word(word, &actions, err);
    lf_free(words);
    if (status == LF_OK)
        *out = actions;
    return status;
}
