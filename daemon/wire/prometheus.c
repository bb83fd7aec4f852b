#include "daemon/wire/prometheus.h"

#include <string.h>

#define PREFIX "quiltd_"

typedef struct quantity {
    const char *name, *type, *help;
    const char *object, *key; /* path in status; object NULL: top level */
} quantity;

static const quantity quantities[] = {
    {"uptime_seconds", "gauge", "Time since the daemon started.", NULL, "uptime"},
    {"generation", "gauge", "Number of the scene and camera state being rendered.", NULL,
     "generation"},
    {"shown_generation", "gauge", "Number of the scene and camera state on the panel.", "shown",
     "generation"},
    {"passes", "gauge", "Passes rendered for this generation.", NULL, "passes"},
    {"render_seconds", "gauge", "Rendering time of this generation.", NULL, "seconds"},
    {"render_cpu_seconds", "gauge", "CPU time of all threads for this generation.", NULL,
     "cpu_seconds"},
    {"samples_per_pixel", "gauge", "Mean native samples of a view pixel.", NULL, "spp"},
    {"error_estimate", "gauge", "Estimated relative mean squared error of the unfiltered image.",
     NULL, "error_estimate"},
    {"error_bound", "gauge", "Upper bound (95 %) of that error.", NULL, "error_bound"},
    {"seconds_left", "gauge", "Estimated rendering time until the error meets the target.", NULL,
     "seconds_left"},
    {"denoised_error", "gauge", "Estimated relative mean squared error of the denoised image.",
     NULL, "denoised_error"},
    {"denoised_error_bound", "gauge", "Upper bound (95 %) of the error of the denoised image.",
     NULL, "denoised_error_bound"},
    {"shown_error", "gauge", "Former name of denoised_error.", NULL, "denoised_error"},
    {"shown_error_bound", "gauge", "Former name of denoised_error_bound.", NULL,
     "denoised_error_bound"},
    {"target_error", "gauge", "Error at which rendering stops.", NULL, "target_error"},
    {"missing_pixels", "gauge", "View pixels that no path has reached yet.", NULL, "missing"},
    {"views", "gauge", "Views of the light field.", NULL, "views"},
    {"threads", "gauge", "Worker threads.", NULL, "threads"},
    {"paused", "gauge", "Whether rendering is paused.", NULL, "paused"},
    {"device_connected", "gauge", "Whether the panel is connected.", "device", "present"},
    {"frames_pushed_total", "counter", "Frames sent to the panel.", NULL, "updates"},
    {"pushed_bytes_total", "counter", "Bytes of pixels sent to the panel.", NULL, "bytes"},
    {"device_errors_total", "counter", "Frames that the panel did not accept.", NULL,
     "device_errors"},
    {"loads_pending", "gauge", "Loads of scenes and quilts in progress or waiting.", NULL,
     "loading"},
    {"clients", "gauge", "Connected clients, including this one.", NULL, "clients"},
};

static void write_head(FILE *out, const char *name, const char *type, const char *help)
{
    fprintf(out, "# HELP " PREFIX "%s %s\n# TYPE " PREFIX "%s %s\n", name, help, name, type);
}

/* Writes a label's value: escapes backslash, quote and newline, and nothing else. */
static void write_label(FILE *out, const char *name, const json_t *text)
{
    fprintf(out, "%s=\"", name);
    for (const char *c = json_is_string(text) ? json_string_value(text) : ""; *c != '\0'; c++) {
        if (*c == '\n') {
            fputs("\\n", out);
            continue;
        }
        if (*c == '\\' || *c == '"')
            fputc('\\', out);
        fputc(*c, out);
    }
    fputc('"', out);
}

static void write_quantity(FILE *out, const quantity *q, const json_t *status)
{
    const json_t *object = q->object ? json_object_get(status, q->object) : status;
    const json_t *value = json_object_get(object, q->key);
    if (!json_is_number(value) && !json_is_boolean(value))
        return;
    write_head(out, q->name, q->type, q->help);
    if (json_is_real(value))
        fprintf(out, PREFIX "%s %.17g\n", q->name, json_real_value(value));
    else
        fprintf(out, PREFIX "%s %lld\n", q->name,
                json_is_integer(value) ? (long long)json_integer_value(value)
                                       : (long long)json_is_true(value));
}

/* Writes one sample per word, 1 for the current one. */
static void write_words(FILE *out, const char *name, const char *help, const char *label,
                        const char *const *words, const json_t *now)
{
    if (!json_is_string(now))
        return;
    write_head(out, name, "gauge", help);
    for (; *words; words++)
        fprintf(out, PREFIX "%s{%s=\"%s\"} %d\n", name, label, *words,
                strcmp(*words, json_string_value(now)) == 0);
}

static void write_states(FILE *out, const json_t *status)
{
    static const char *const states[] = {"idle", "rendering", "converged", "paused", "error", NULL};
    static const char *const levels[] = {"none", "coarse", "complete", "converged", NULL};
    write_words(out, "state", "State of the daemon: 1 for the current state.", "state", states,
                json_object_get(status, "state"));
    write_words(out, "shown_level", "Level of the image on the panel: 1 for the current level.",
                "level", levels, json_object_get(json_object_get(status, "shown"), "level"));
}

static void write_infos(FILE *out, const json_t *status)
{
    static const char *const labels[] = {"spec", "kind", "model", "serial"};
    const json_t *scene = json_object_get(status, "scene"),
                 *device = json_object_get(status, "device");
    if (json_is_string(scene)) {
        write_head(out, "scene_info", "gauge", "File on display; always 1.");
        fputs(PREFIX "scene_info{", out);
        write_label(out, "file", scene);
        fputs("} 1\n", out);
    }
    if (!json_is_object(device))
        return;
    write_head(out, "device_info", "gauge", "Panel in use; always 1.");
    fputs(PREFIX "device_info{", out);
    for (size_t i = 0; i < sizeof labels / sizeof *labels; i++) {
        fputs(i > 0 ? "," : "", out);
        write_label(out, labels[i], json_object_get(device, labels[i]));
    }
    fputs("} 1\n", out);
}

void lf_prometheus_write(const json_t *status, FILE *out)
{
    write_head(out, "up", "gauge", "Whether a daemon answers.");
    fprintf(out, PREFIX "up %d\n", status ? 1 : 0);
    if (!status)
        return;
    write_states(out, status);
    write_infos(out, status);
    for (size_t i = 0; i < sizeof quantities / sizeof *quantities; i++)
        write_quantity(out, &quantities[i], status);
    write_head(out, "jobs", "gauge", "Exports in progress or waiting.");
    fprintf(out, PREFIX "jobs %zu\n", json_array_size(json_object_get(status, "jobs")));
    write_head(out, "error", "gauge", "Whether the daemon reports an error (quiltctl status).");
    fprintf(out, PREFIX "error %d\n", json_object_get(status, "error") ? 1 : 0);
}
