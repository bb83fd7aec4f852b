/* Where profiles lie. */
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/nearest.h"
#include "quilt/profile/profile.h"

enum { FOLDERS = 4 };

static const char *const subfolders[] = {"lenses", "printers"};

const char *lf_profile_kind_name(lf_profile_kind kind)
{
    return kind == LF_PROFILE_LENS ? "lens" : "printer";
}

bool lf_profile_is_name(const char *text)
{
    static const char first[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
    const size_t n = strlen(text);
    if (n == 0 || n >= LF_PROFILE_NAME || strspn(text, first) == 0)
        return false;
    for (const char *c = text; *c != '\0'; c++)
        if (!strchr(first, *c) && !strchr("-+_.", *c))
            return false;
    return true;
}

bool lf_profile_is_path(const char *name)
{
    return strchr(name, '/') || lf_path_has_ending(name, ".json");
}

/* A path that does not fit is empty. */
static void put(char out[static PATH_MAX], const char *folder, const char *below)
{
    if (snprintf(out, PATH_MAX, "%s%s", folder, below) >= PATH_MAX)
        out[0] = '\0';
}

/* The user's folder; empty if no home is known. */
static void own_folder(lf_profile_kind kind, char out[static PATH_MAX])
{
    const char *config = getenv("XDG_CONFIG_HOME"), *home = getenv("HOME");
    char below[64];
    /* relative ones are invalid by the specification */
    const bool has_config = config && config[0] == '/';
    snprintf(below, sizeof below, "%s/quiltd/%s", has_config ? "" : "/.config", subfolders[kind]);
    out[0] = '\0';
    if (has_config || (home && home[0] == '/'))
        put(out, has_config ? config : home, below);
}

lf_status lf_profile_own_folder(lf_profile_kind kind, char out[static PATH_MAX], lf_error *err)
{
    own_folder(kind, out);
    return out[0] != '\0' ? LF_OK
                          : lf_error_set(err, LF_E_STATE, "HOME",
                                         "is not set, so there is no folder for profiles; give one "
                                         "with --folder");
}

/* The folder above that of the program that runs; empty if it is unknown. */
static void above_program(char out[static PATH_MAX])
{
    const ssize_t n = readlink("/proc/self/exe", out, PATH_MAX - 1);
    out[n > 0 ? n : 0] = '\0';
    for (int i = 0; i < 2; i++) {
        char *slash = strrchr(out, '/');
        if (slash)
            *slash = '\0';
    }
}

/* The folders of a kind in their order; empty names are to be left out. */
static void list_folders(lf_profile_kind kind, char folders[FOLDERS][PATH_MAX])
{
    const char *shipped = getenv("QUILTD_PROFILES");
    char above[PATH_MAX], below[64];
    own_folder(kind, folders[0]);
    snprintf(folders[1], PATH_MAX, "/etc/quiltd/%s", subfolders[kind]);
    folders[2][0] = folders[3][0] = '\0';
    snprintf(below, sizeof below, "/%s", subfolders[kind]);
    if (shipped) {
        put(folders[2], shipped, below);
        return;
    }
    above_program(above);
    snprintf(below, sizeof below, "/share/quiltd/%s", subfolders[kind]);
    put(folders[2], above, below);
    snprintf(below, sizeof below, "/profiles/%s", subfolders[kind]);
    put(folders[3], above, below);
}

/* -------------------------------------------------------------------------------------- list -- */

typedef struct listing {
    lf_profile_entry *entries;
    int n, room;
} listing;

static lf_status add(listing *list, const char *folder, const char *file, bool is_own,
                     lf_error *err)
{
    lf_profile_entry entry = {.is_own = is_own};
    snprintf(entry.name, sizeof entry.name, "%.*s", (int)(strlen(file) - strlen(".json")), file);
    for (int i = 0; i < list->n; i++)
        if (strcmp(list->entries[i].name, entry.name) == 0)
            return LF_OK;
    if (snprintf(entry.path, sizeof entry.path, "%s/%s", folder, file) >= (int)sizeof entry.path)
        return LF_OK;
    if (list->n == list->room) {
        const int room = list->room > 0 ? 2 * list->room : 32;
        lf_profile_entry *more = lf_calloc((size_t)room, sizeof *more);
        if (!more)
            return lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
        if (list->n > 0)
            memcpy(more, list->entries, (size_t)list->n * sizeof *more);
        lf_free(list->entries);
        list->entries = more;
        list->room = room;
    }
    list->entries[list->n++] = entry;
    return LF_OK;
}

static bool is_profile_file(const char *file)
{
    char name[LF_PROFILE_NAME];
    const size_t ending = strlen(".json"), n = strlen(file);
    if (n <= ending || n - ending >= sizeof name || strcmp(file + n - ending, ".json") != 0)
        return false;
    snprintf(name, sizeof name, "%.*s", (int)(n - ending), file);
    return lf_profile_is_name(name);
}

/* A folder that cannot be read counts as empty. */
static lf_status add_folder(listing *list, const char *folder, bool is_own, lf_error *err)
{
    DIR *dir = opendir(folder);
    const struct dirent *entry;
    lf_status status = LF_OK;
    for (int n = 0; dir && status == LF_OK && n < LF_PROFILE_ENTRIES && (entry = readdir(dir));)
        if (is_profile_file(entry->d_name)) {
            status = add(list, folder, entry->d_name, is_own, err);
            n++;
        }
    if (dir)
        closedir(dir);
    return status;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const lf_profile_entry *)a)->name, ((const lf_profile_entry *)b)->name);
}

lf_status lf_profile_list(lf_profile_kind kind, lf_profile_entry **out, int *out_n, lf_error *err)
{
    char folders[FOLDERS][PATH_MAX];
    listing list = {0};
    lf_status status = LF_OK;
    list_folders(kind, folders);
    for (int i = 0; i < FOLDERS && status == LF_OK; i++)
        if (folders[i][0] != '\0')
            status = add_folder(&list, folders[i], i == 0, err);
    if (status != LF_OK) {
        lf_free(list.entries);
        return status;
    }
    if (list.n > 0)
        qsort(list.entries, (size_t)list.n, sizeof *list.entries, by_name);
    *out = list.entries;
    *out_n = list.n;
    return LF_OK;
}

/* -------------------------------------------------------------------------------------- find -- */

static lf_status unknown(lf_profile_kind kind, const char *name, lf_error *err)
{
    lf_profile_entry *entries = NULL;
    const char *names[LF_PROFILE_ENTRIES * FOLDERS + 1], *meant;
    int n = 0;
    lf_status status = lf_profile_list(kind, &entries, &n, err);
    if (status != LF_OK)
        return status;
    for (int i = 0; i < n; i++)
        names[i] = entries[i].name;
    names[n] = NULL;
    meant = lf_nearest_name(name, names);
    status =
        meant ? lf_error_set(err, LF_E_ARG, name, "there is no such %s; did you mean %s?",
                             lf_profile_kind_name(kind), meant)
              : lf_error_set(err, LF_E_ARG, name, "there is no such %s; quiltprint list shows all",
                             lf_profile_kind_name(kind));
    lf_free(entries);
    return status;
}

lf_status lf_profile_find(lf_profile_kind kind, const char *name, char out[static PATH_MAX],
                          lf_error *err)
{
    char folders[FOLDERS][PATH_MAX], below[LF_PROFILE_NAME + 8];
    if (lf_profile_is_path(name)) {
        put(out, name, "");
        return out[0] != '\0' ? LF_OK
                              : lf_error_set(err, LF_E_ARG, "profile", "the path is too long");
    }
    if (!lf_profile_is_name(name))
        return lf_error_set(err, LF_E_ARG, name,
                            "is not the name of a %s; names have letters, digits, - + _ and .",
                            lf_profile_kind_name(kind));
    snprintf(below, sizeof below, "/%s.json", name);
    list_folders(kind, folders);
    for (int i = 0; i < FOLDERS; i++) {
        put(out, folders[i], below);
        if (folders[i][0] != '\0' && out[0] != '\0' && access(out, F_OK) == 0)
            return LF_OK;
    }
    return unknown(kind, name, err);
}
