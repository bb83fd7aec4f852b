#include "daemon/button_actions.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file.h"
#include "daemon/output_internal.h"

static const char *const action_names[LF_ACTIONS_N] = {"none", "next", "previous", "pause", "reset"};

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
    while (button < LF_BUTTONS_N && strcmp(lf_button_name(button), name) != 0) {
        button++;
    }
    return button;
}

static lf_action action_of_name(const char *name)
{
    lf_action action = 0;
    while (action < LF_ACTIONS_N && strcmp(action_names[action], name) != 0) {
        action++;
    }
    return action;
}

/* One "button=action". */
static lf_status take_word(char *word, lf_button_actions *actions, lf_error *err)
{
    char *equals = strchr(word, '=');
    if (equals == NULL) {
        return lf_error_set(err, LF_E_ARG, "--buttons", "expected BUTTON=ACTION, got \"%s\"", word);
    }
    *equals = '\0';
    lf_button button = lf_button_of_name(word);
    lf_action action = action_of_name(equals + 1);
    if (button == LF_BUTTONS_N) {
        return lf_error_set(err, LF_E_ARG, "--buttons", "there is no button \"%s\"; expected square, left, right or circle", word);
    }
    if (action == LF_ACTIONS_N) {
        return lf_error_set(err, LF_E_ARG, "--buttons", "a button cannot do \"%s\"; expected none, next, previous, pause or reset",
                            equals + 1);
    }
    actions->of[button] = action;
    return LF_OK;
}

lf_status lf_button_actions_parse(const char *text, lf_button_actions *out, lf_error *err)
{
    lf_button_actions actions = *out;
    char *words = lf_strdup(text), *rest = words, *word;
    lf_status status = words != NULL ? LF_OK : lf_error_set(err, LF_E_NOMEM, "--buttons", "out of memory");
    while (status == LF_OK && (word = strsep(&rest, ",")) != NULL) {
        status = take_word(word, &actions, err);
    }
    lf_free(words);
    if (status == LF_OK) {
        *out = actions;
    }
    return status;
}

/* ---------------------------------------------------------------------------------------------------- neighbours -- */

static bool is_shown_by_name(const char *name)
{
    static const char *const pictures[] = {".png", ".jpg", ".jpeg", ".exr"};
    if (name[0] == '.') {
        return false;
    }
    if (output_has_ending(name, ".json")) {
        return true;
    }
    int columns, rows;
    double aspect;
    bool picture = false;
    for (size_t i = 0; i < sizeof pictures / sizeof *pictures; i++) {
        picture = picture || output_has_ending(name, pictures[i]);
    }
    return picture && lf_layout_from_name(name, &columns, &rows, &aspect);
}

static int to_show(const struct dirent *entry)
{
    return is_shown_by_name(entry->d_name) ? 1 : 0;
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

/* Index of the entry `step` (not 0) after `name`, which may be missing. */
static int neighbour(struct dirent *const *entries, int n, const char *name, int step)
{
    int at = 0;
    while (at < n && strcmp(entries[at]->d_name, name) < 0) {
        at++;
    }
    bool there = at < n && strcmp(entries[at]->d_name, name) == 0;
    int next = at + step % n - (step > 0 && !there ? 1 : 0);
    return (next % n + n) % n;
}

lf_status lf_folder_neighbour(const char *file, int step, char **out_path, lf_error *err)
{
    const char *slash = strrchr(file, '/');
    const char *name = slash != NULL ? slash + 1 : file;
    char *folder = lf_path_folder(file);
    if (folder == NULL) {
        return lf_error_set(err, LF_E_NOMEM, file, "out of memory");
    }
    struct dirent **entries = NULL;
    int n = scandir(folder, &entries, to_show, by_name);
    if (n < 0) {
        lf_status status = lf_error_set(err, LF_E_IO, folder, "cannot be read: %s", lf_errno_text(errno));
        lf_free(folder);
        return status;
    }
    char *path = n > 0 ? lf_path_join(folder, entries[neighbour(entries, n, name, step)]->d_name) : lf_strdup(file);
    for (int i = 0; i < n; i++) {
        free(entries[i]);
    }
    free(entries);
    lf_free(folder);
    if (path == NULL) {
        return lf_error_set(err, LF_E_NOMEM, file, "out of memory");
    }
    *out_path = path;
    return LF_OK;
}
