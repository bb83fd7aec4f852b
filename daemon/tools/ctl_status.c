/* quiltctl status: a screen for people. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/escape.h"
#include "daemon/tools/ctl.h"

/* Of problems and warnings: with all other rows, a screen of 24 lines. */
#define MAX_PROBLEMS 6

static double number(const json_t *object, const char *key)
{
    return json_number_value(json_object_get(object, key));
}

static int integer(const json_t *object, const char *key)
{
    return (int)json_integer_value(json_object_get(object, key));
}

static const char *text(const json_t *object, const char *key)
{
    const char *value = json_string_value(json_object_get(object, key));
    return value ? value : "";
}

static bool is_true(const json_t *object, const char *key)
{
    return json_is_true(json_object_get(object, key));
}

static bool is_number(const json_t *object, const char *key)
{
    return json_is_number(json_object_get(object, key));
}

LF_PRINTF(3, 4) static void print_row(FILE *out, const char *name, const char *fmt, ...)
{
    char line[6144], escaped[2 * sizeof line];
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(line, sizeof line, fmt, ap);
    va_end(ap);
    lf_escape(escaped, sizeof escaped, line);
    fprintf(out, "  %-10s %s\n", name, escaped);
}

/* ------------------------------------------------------------------------------------- shown -- */

static void print_views(const json_t *status, FILE *out)
{
    char cameras[64] = "";
    if (is_number(status, "cone"))
        snprintf(cameras, sizeof cameras, ", cone %.4g degrees", number(status, "cone"));
    if (is_number(status, "track"))
        snprintf(cameras, sizeof cameras, ", track of %.4g", number(status, "track"));
    print_row(out, "views", "%d of %dx%d pixels, %dx%d tiles%s", integer(status, "views"),
              integer(status, "view_width"), integer(status, "view_height"),
              integer(status, "columns"), integer(status, "rows"), cameras);
}

static void print_time(const json_t *time, FILE *out)
{
    if (is_true(time, "playing"))
        print_row(out, "frame", "%d, playing %d to %d at %.4g frames per second",
                  integer(time, "frame"), integer(time, "from"), integer(time, "to"),
                  number(time, "fps"));
    else if (json_is_object(time))
        print_row(out, "frame", "%d", integer(time, "frame"));
}

static void print_video(const json_t *video, FILE *out)
{
    char length[48] = "";
    if (!json_is_object(video))
        return;
    if (is_number(video, "duration"))
        snprintf(length, sizeof length, " of %.1f", number(video, "duration"));
    print_row(out, "position", "%.1f%s s, frame %d at %.4g frames per second%s",
              number(video, "seconds"), length, integer(video, "frame"), number(video, "fps"),
              json_is_string(json_object_get(video, "problem")) ? ", stopped"
              : is_true(video, "paused")                        ? ", paused"
                                                                : "");
    print_row(out, "frames", "%.0f shown, %.0f dropped", number(video, "shown"),
              number(video, "dropped"));
}

static void print_depth(const json_t *depth, FILE *out)
{
    char to[40] = " on";
    if (!json_is_object(depth))
        return;
    if (is_number(depth, "sharp_to"))
        snprintf(to, sizeof to, " to %.4g", number(depth, "sharp_to"));
    print_row(out, "depth", "objects from %.4g to %.4g, sharp from %.4g%s",
              number(depth, "nearest"), number(depth, "farthest"), number(depth, "sharp_from"), to);
}

static const char *state_of(const json_t *playlist)
{
    return is_true(playlist, "paused")    ? "paused"
           : is_true(playlist, "playing") ? "playing"
                                          : "stopped";
}

static void print_slideshow(const json_t *playlist, FILE *out)
{
    const char *file = text(playlist, "file"), *slash = strrchr(file, '/');
    print_row(out, "slideshow", "entry %d of %d, %s, %s", integer(playlist, "index") + 1,
              integer(playlist, "entries"), slash ? slash + 1 : file, state_of(playlist));
}

void lf_ctl_print_slideshow(const json_t *list, FILE *out)
{
    char name[512];
    const json_t *entries = json_object_get(list, "entries");
    const json_t *entry = json_array_get(entries, (size_t)integer(list, "index"));
    if (!entry) {
        fprintf(out, "no entries\n");
        return;
    }
    const char *file = text(entry, "file"), *slash = strrchr(file, '/');
    lf_escape(name, sizeof name, slash ? slash + 1 : file);
    fprintf(out, "entry %d of %zu, %s, %s\n", integer(list, "index") + 1, json_array_size(entries),
            name, state_of(list));
}

static void print_shown(const json_t *status, FILE *out)
{
    const json_t *playlist = json_object_get(status, "playlist");
    fprintf(out, "Shown\n");
    if (json_is_string(json_object_get(status, "scene"))) {
        print_row(out,
                  json_is_object(json_object_get(status, "video")) ? "video"
                  : is_true(status, "is_quilt")                    ? "image"
                                                                   : "scene",
                  "%s", text(status, "scene"));
        print_views(status, out);
        print_time(json_object_get(status, "time"), out);
        print_video(json_object_get(status, "video"), out);
        print_depth(json_object_get(status, "depth_budget"), out);
    } else {
        print_row(out, "scene", "none; quiltctl scene.load file=PATH shows one");
    }
    if (json_is_object(playlist))
        print_slideshow(playlist, out);
}

/* ---------------------------------------------------------------------------------- progress -- */

static void print_errors(const json_t *status, FILE *out)
{
    char denoised[48] = "", left[LF_CTL_TIME];
    if (!is_number(status, "error_estimate")) {
        print_row(out, "error", "not known yet, target %.2g", number(status, "target_error"));
        return;
    }
    if (is_number(status, "denoised_error"))
        snprintf(denoised, sizeof denoised, ", denoised %.2g", number(status, "denoised_error"));
    print_row(out, "error", "%.2g%s, target %.2g", number(status, "error_estimate"), denoised,
              number(status, "target_error"));
    if (number(status, "seconds_left") > 0)
        print_row(out, "time left", "about %s", lf_ctl_time(number(status, "seconds_left"), left));
}

static void print_work(const json_t *status, FILE *out)
{
    char seconds[LF_CTL_TIME], spp[48] = "";
    if (is_number(status, "spp"))
        snprintf(spp, sizeof spp, ", %.3g samples per pixel", number(status, "spp"));
    print_row(out, "so far", "%s, %.1f passes%s", lf_ctl_time(number(status, "seconds"), seconds),
              number(status, "passes"), spp);
    print_errors(status, out);
}

static void print_loading(const json_t *status, FILE *out)
{
    const json_t *load = json_object_get(status, "load"),
                 *reading = json_object_get(status, "reading");
    char seconds[LF_CTL_TIME];
    if (json_is_object(reading))
        print_row(out, "loading", "reading %s (%.1f MB) for %s", text(reading, "file"),
                  1e-6 * number(reading, "bytes"),
                  lf_ctl_time(number(reading, "seconds"), seconds));
    else if (json_is_object(load))
        print_row(out, "loading", "%s", text(load, "file"));
}

static void print_farm(const json_t *job, const char *more, FILE *out)
{
    const json_t *farm = json_object_get(job, "farm"), *tasks = json_object_get(farm, "tasks");
    char left[LF_CTL_TIME + 16] = "", seconds[LF_CTL_TIME];
    if (number(farm, "seconds_left") > 0)
        snprintf(left, sizeof left, ", about %s left",
                 lf_ctl_time(number(farm, "seconds_left"), seconds));
    print_row(out, "farm", "%d: %s %s, %s %s, %d of %d tasks%s%s", integer(job, "job"),
              text(job, "kind"), text(job, "file"), text(farm, "engine"), text(farm, "state"),
              integer(tasks, "complete"), integer(tasks, "total"), left, more);
}

static void print_job(const json_t *jobs, FILE *out)
{
    const json_t *job = json_array_get(jobs, 0);
    char more[48] = "";
    if (json_array_size(jobs) > 1)
        snprintf(more, sizeof more, "; %zu more", json_array_size(jobs) - 1);
    if (json_object_get(job, "farm"))
        print_farm(job, more, out);
    else if (job)
        print_row(out, "export", "%d: %s %s, %s, %.0f %%%s", integer(job, "job"), text(job, "kind"),
                  text(job, "file"), text(job, "state"), 100 * number(job, "progress"), more);
}

static void print_progress(const json_t *status, FILE *out)
{
    fprintf(out, "Progress\n");
    print_row(out, "state", "%s, %s", text(status, "state"),
              strcmp(text(status, "denoise"), "on") == 0 ? "denoised" : "unfiltered");
    if (json_is_string(json_object_get(status, "scene")) && !is_true(status, "is_quilt"))
        print_work(status, out);
    print_loading(status, out);
    print_job(json_object_get(status, "jobs"), out);
}

/* ------------------------------------------------------------------------------------- panel -- */

static void print_panel(const json_t *status, FILE *out)
{
    const json_t *device = json_object_get(status, "device"),
                 *shown = json_object_get(status, "shown");
    const char *model = text(device, "model"), *serial = text(device, "serial"),
               *card = text(shown, "card");
    fprintf(out, "Panel\n");
    print_row(out, "device", "%s%s%s%s%s%s", text(device, "spec"), model[0] != '\0' ? ": " : "",
              model, serial[0] != '\0' ? ", serial number " : "", serial,
              is_true(device, "present") ? "" : " (not open)");
    const bool is_old = number(shown, "generation") < number(status, "generation");
    if (card[0] != '\0')
        print_row(out, "message", "%s", card);
    else if (strcmp(text(device, "kind"), "none") == 0)
        return;
    else if (strcmp(text(shown, "level"), "none") == 0)
        print_row(out, "shows", "nothing yet");
    else
        print_row(out, "shows", "%s image%s", text(shown, "level"),
                  is_old ? " of the scene before" : "");
}

/* ---------------------------------------------------------------------------------- problems -- */

/* Rows of problems and warnings; those above the limit are only counted. */
typedef struct problems {
    FILE *out;
    int n, limit;
} problems;

static void add_problem(problems *list, const char *name, const char *words)
{
    if (words[0] == '\0')
        return;
    if (list->n++ < list->limit)
        print_row(list->out, name, "%s", words);
}

static void add_problems(const json_t *status, problems *list)
{
    size_t i;
    json_t *warning, *job;
    add_problem(list, "error", text(json_object_get(status, "error"), "message"));
    json_array_foreach(json_object_get(status, "jobs"), i, job)
    {
        add_problem(list, "farm", text(json_object_get(job, "farm"), "problem"));
    }
    add_problem(list, "video", text(json_object_get(status, "video"), "problem"));
    add_problem(list, "panel", text(json_object_get(status, "device"), "problem"));
    json_array_foreach(json_object_get(status, "warnings"), i, warning)
    {
        add_problem(list, "warning", json_is_string(warning) ? json_string_value(warning) : "");
    }
}

static void print_problems(const json_t *status, FILE *out)
{
    problems all = {.out = out}, list = {.out = out};
    add_problems(status, &all);
    list.limit = all.n > MAX_PROBLEMS ? MAX_PROBLEMS - 1 : MAX_PROBLEMS;
    fprintf(out, "Problems and warnings\n");
    add_problems(status, &list);
    if (list.n == 0)
        fprintf(out, "  none\n");
    if (list.n > list.limit)
        fprintf(out, "  %d more; quiltctl status --all prints them\n", list.n - list.limit);
}

void lf_ctl_print_status(const json_t *status, FILE *out)
{
    print_shown(status, out);
    print_progress(status, out);
    print_panel(status, out);
    print_problems(status, out);
}
