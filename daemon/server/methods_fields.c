/* The fields of results and notifications. */
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "daemon/server/methods.h"

/* A field of a result, of a notification ("!" and its name) or of a nested object ("@" and its
 * name). key NULL: no fields. type: "string", "[string]" for an array, "@NAME", "…|null" if it may
 * be null. */
typedef struct field {
    const char *of, *key, *type;
    const char *unit; /* unit of a number */
    const char *about;
} field;

#define COUNT "count"

/* clang-format off */
static const field fields[] = {
    {"hello", "name", "string", NULL, "name of the program: quiltd"},
    {"hello", "version", "string", NULL, "version of quiltd"},
    {"hello", "protocol", "integer", COUNT, "version of the protocol"},
    {"hello", "folders", "[string]", NULL, "folders from which quiltd reads files by their names"},
    {"hello", "methods", "object", NULL,
     "methods by name, each with summary, params (a JSON Schema), result (likewise) and example"},
    {"hello", "events", "object", NULL,
     "notifications by name, each with summary, event (for subscribe) and params (a JSON Schema)"},

    {"status", "state", "string", NULL, "rendering, converged, paused, idle or error"},
    {"status", "error", "@error", NULL, "why the scene could not be loaded; left out: it could"},
    {"status", "scene", "string|null", NULL, "file that is shown"},
    {"status", "passed", "[string]", NULL, "files of the scene that clients have passed"},
    {"status", "is_quilt", "boolean", NULL, "true: a picture is shown, which is not rendered"},
    {"status", "views", "integer", COUNT, "views of the picture"},
    {"status", "columns", "integer", COUNT, "tiles of its quilt across"},
    {"status", "rows", "integer", COUNT, "tiles of its quilt upwards"},
    {"status", "view_width", "integer", "pixels", "width of one view"},
    {"status", "view_height", "integer", "pixels", "height of one view"},
    {"status", "aspect", "number", "width over height", "shape of the window"},
    {"status", "cone", "number", "degrees", "angle over which the cameras are spread"},
    {"status", "track", "number", "scene units", "length of a straight line of cameras"},
    {"status", "time", "@time", NULL, "frame that is shown, and what is played"},
    {"status", "depth_budget", "@depth|null", NULL, "whether the scene is too deep for a panel"},
    {"status", "seed", "integer|string", COUNT, "random seed; a string where it exceeds 2^63 - 1"},
    {"status", "integrator", "string", NULL, "name of the integrator"},
    {"status", "generation", "integer", COUNT, "number of the scene and camera"},
    {"status", "level", "string", NULL,
     "quality of the picture now: none, coarse, complete or converged"},
    {"status", "passes", "number", "passes", "passes rendered so far"},
    {"status", "seconds", "number", "seconds", "time rendered so far"},
    {"status", "cpu_seconds", "number", "seconds", "the same in CPU time of all threads"},
    {"status", "spp", "number|null", "samples a pixel", "mean native samples of a view pixel"},
    {"status", "error_estimate", "number|null", "relMSE", "error of the unfiltered picture"},
    {"status", "error_bound", "number|null", "relMSE", "95 % bound of this error"},
    {"status", "shown_error", "number|null", "relMSE", "error of the reconstructed picture"},
    {"status", "shown_error_bound", "number|null", "relMSE", "95 % bound of this error"},
    {"status", "coarse_cost", "@cost|null", NULL,
     "what the last picture took to its first coarse frame; null: there was none yet"},
    {"status", "complete_cost", "@cost|null", NULL,
     "what the last one took to its first complete frame, the coarse one included"},
    {"status", "missing", "integer", "pixels", "view pixels that no path has reached"},
    {"status", "threads", "integer", COUNT, "threads that render"},
    {"status", "estimator", "string", NULL, "name of the estimator"},
    {"status", "target_error", "number", "relMSE", "error at which rendering ends; 0: never"},
    {"status", "paused", "boolean", NULL, "no further passes are rendered"},
    {"status", "guides", "boolean", NULL, "what is too near or too far is marked"},
    {"status", "reconstruct", "string", NULL, "on: the reconstructed picture is shown, else off"},
    {"status", "exposure", "@exposure", NULL, "how bright the picture is shown"},
    {"status", "shown", "@shown", NULL, "what the panel shows"},
    {"status", "warnings", "[string]", NULL, "what is to be said of what is shown"},
    {"status", "device", "@device", NULL, "the panel"},
    {"status", "updates", "integer", COUNT, "updates pushed to the panel"},
    {"status", "bytes", "integer", "bytes", "bytes pushed to the panel"},
    {"status", "device_errors", "integer", COUNT, "errors of the panel"},
    {"status", "loading", "integer", COUNT, "loads that wait or are in progress"},
    {"status", "load", "@load|null", NULL, "the load in progress"},
    {"status", "reading", "@reading|null", NULL, "the file that is being read"},
    {"status", "landlock", "string", NULL,
     "whether Landlock confines what reads files: on, off, refused or unknown"},
    {"status", "clients", "integer", COUNT, "clients that are connected"},
    {"status", "lines", "integer", COUNT, "lines of clients handled so far"},
    {"status", "jobs", "[@job]", NULL, "exports that wait or run"},
    {"status", "uptime", "number", "seconds", "time since the daemon was started"},
    {"status", "longest_turn", "number", "seconds",
     "most CPU time that the event thread has spent on one thing"},

    {"@cost", "paths", "number", "CPU seconds", "of all threads, for rows with paths"},
    {"@cost", "fans", "number", "CPU seconds", "for rows that have no paths yet"},
    {"@cost", "fit", "number", "CPU seconds", "for fits of the reconstruction"},
    {"@cost", "answer", "number", "CPU seconds", "for rows shown by them"},
    {"@cost", "compose", "number", "CPU seconds", "for interlacing, and what it shows"},

    {"@error", "code", "integer", COUNT, "code of the error, as in an answer"},
    {"@error", "message", "string", NULL, "what is wrong, in one line"},
    {"@error", "data", "@place", NULL, "where it is wrong, as far as it is known"},
    {"@place", "file", "string", NULL, "file or option with the mistake"},
    {"@place", "line", "integer", COUNT, "line of this file, counted from 1"},
    {"@place", "pointer", "string", NULL, "JSON pointer of the value"},
    {"@time", "frame", "integer", "frames", "number of the frame"},
    {"@time", "playing", "boolean", NULL, "frames are being played"},
    {"@time", "rate", "number", "frames a second", "how fast, while they are played"},
    {"@time", "from", "integer", "frames", "first frame, while they are played"},
    {"@time", "to", "integer", "frames", "last frame, while they are played"},
    {"@time", "loop", "boolean", NULL, "begins again behind the last, while they are played"},
    {"@depth", "nearest", "number", "scene units", "distance of the nearest point"},
    {"@depth", "farthest", "number", "scene units", "distance of the farthest point"},
    {"@depth", "nearest_step", "number|null", "pixels", "shift of this point between views"},
    {"@depth", "farthest_step", "number", "pixels", "shift of this point between views"},
    {"@depth", "limit", "number", "pixels", "largest shift that a panel shows sharply"},
    {"@depth", "sharp_from", "number", "scene units", "nearest distance that is sharp"},
    {"@depth", "sharp_to", "number|null", "scene units", "farthest one; null: any"},
    {"@depth", "exceeded", "boolean", NULL, "something lies outside of these, with no view_blur"},
    {"@exposure", "stops", "number", "stops", "exposure in use"},
    {"@exposure", "auto", "boolean", NULL, "it was chosen by the picture"},
    {"@exposure", "tonemap", "string", NULL, "name of the tone curve"},
    {"@shown", "generation", "integer", COUNT, "number of the scene and camera"},
    {"@shown", "level", "string", NULL, "none, coarse, complete or converged"},
    {"@shown", "picture", "string", NULL, "reconstructed, unfiltered or card"},
    {"@shown", "card", "string|null", NULL, "line on the card; null: no card"},
    {"@device", "spec", "string", NULL, "what --device and device.set take to get this one"},
    {"@device", "kind", "string", NULL, "kind of device, such as sim or none"},
    {"@device", "model", "string", NULL, "the display's own name, if it has one"},
    {"@device", "serial", "string", NULL, "serial number of the panel"},
    {"@device", "calibration_from", "string", NULL, "where the calibration came from"},
    {"@device", "output", "string", NULL, "file, connector or USB address"},
    {"@device", "problem", "string", NULL, "what is wrong and what to do; empty: nothing"},
    {"@device", "present", "boolean", NULL, "it is open; not said in lists"},
    {"@device", "response", "@response", NULL, "how it responds to its codes; not said in lists"},
    {"@response", "gamma", "number|string", "exponent", "response to codes: a number, or srgb"},
    {"@response", "white", "number", "kelvin", "colour temperature of its white; 0: not said"},
    {"@response", "white_x", "number", "CIE x", "chromaticity of its white; 0: not said"},
    {"@response", "white_y", "number", "CIE y", "chromaticity of its white; 0: not said"},
    {"@load", "job", "integer", COUNT, "number of the load, for job.cancel"},
    {"@load", "kind", "string", NULL, "file, patch, orbit, fit or settings"},
    {"@load", "file", "string|null", NULL, "file that is loaded"},
    {"@reading", "file", "string", NULL, "file that is read, one of several"},
    {"@reading", "bytes", "integer", "bytes", "size of this file"},
    {"@reading", "seconds", "number", "seconds", "time that it has taken"},
    {"@reading", "files_read", "integer", COUNT, "files that were read before"},
    {"@job", "job", "integer", COUNT, "number of the export"},
    {"@job", "kind", "string", NULL, "kind of the export"},
    {"@job", "file", "string", NULL, "file that is written"},
    {"@job", "state", "string", NULL, "waiting, running, done, failed or cancelled"},
    {"@job", "progress", "number", "share", "how much is written, from 0 to 1"},

    {"scene.load", "generation", "integer", COUNT, "number of the scene that is shown now"},
    {"scene.load", "warnings", "[string]", NULL, "what its files hold and the picture lacks"},
    {"scene.get", "file", "string", NULL, "file that the scene came from"},
    {"scene.get", "generation", "integer", COUNT, "number of the scene"},
    {"scene.get", "bounds", "@bounds|null", NULL, "box around the scene without its grounds"},
    {"scene.get", "scene", "object|null", NULL, "the scene's document; null: a picture is shown"},
    {"@bounds", "min", "[number]", "scene units", "least x, y and z"},
    {"@bounds", "max", "[number]", "scene units", "greatest x, y and z"},
    {"scene.patch", "generation", "integer", COUNT, "number of the scene that is shown now"},
    {"scene.patch", "warnings", "[string]", NULL, "what its files hold and the picture lacks"},
    {"camera.set", "generation", "integer", COUNT, "number of the scene that is shown now"},
    {"camera.set", "warnings", "[string]", NULL, "what its files hold and the picture lacks"},
    {"camera.orbit", "generation", "integer", COUNT, "number of the scene that is shown now"},
    {"camera.fit", "generation", "integer", COUNT, "number of the scene that is shown now"},
    {"time.set", "generation", "integer", COUNT, "number of the scene that is shown now"},
    {"time.set", "warnings", "[string]", NULL, "what its files hold and the picture lacks"},
    {"time.play", "", "@time", NULL, ""},
    {"time.stop", "", "@time", NULL, ""},
    {"wait", "generation", "integer", COUNT, "number of the scene that the panel shows"},
    {"wait", "level", "string", NULL, "coarse, complete or converged"},
    {"render.set", "generation", "integer", COUNT, "number of the picture, which may be a new one"},
    {"export", "job", "integer", COUNT, "number of the export; its end comes as a notification"},
    {"export", "file", "string", NULL, "file that will be written"},
    {"job.cancel", NULL, NULL, NULL, NULL},
    {"device.list", "devices", "[@device]", NULL, "devices that could be opened"},
    {"device.list", "present", "@device", NULL, "the one that is open"},
    {"device.set", "", "@device", NULL, ""},
    {"device.calibration", "configVersion", "string", NULL, "version of the calibration's format"},
    {"device.calibration", "serial", "string", NULL, "serial number of the panel"},
    {"device.calibration", "pitch", "number", "lenses an inch", "pitch of the lenses across them"},
    {"device.calibration", "slope", "number", "rise over run", "slant of the lenses"},
    {"device.calibration", "center", "number", "lens periods", "phase of the lenses"},
    {"device.calibration", "viewCone", "number", "degrees", "angle of the optics; 0: not said"},
    {"device.calibration", "DPI", "number", "pixels an inch", "resolution of the panel"},
    {"device.calibration", "screenW", "integer", "pixels", "width of the panel"},
    {"device.calibration", "screenH", "integer", "pixels", "height of the panel"},
    {"device.calibration", "invView", "integer", COUNT, "1: views run the other way"},
    {"device.calibration", "flipImageX", "integer", COUNT, "1: mirrored from left to right"},
    {"device.calibration", "flipImageY", "integer", COUNT, "1: mirrored from top to bottom"},
    {"device.calibration", "flipSubp", "integer", COUNT, "1: subpixels run blue, green, red"},
    {"device.calibration", "CellPatternMode", "integer", COUNT, "number of the subpixel layout"},
    {"device.calibration", "subpixelCells", "[object]", NULL, "places of subpixels"},
    {"device.calibration", "defaultQuilt", "@tiles", NULL, "the panel's own quilt, if it says one"},
    {"@tiles", "quiltX", "integer", "pixels", "width of the quilt"},
    {"@tiles", "quiltY", "integer", "pixels", "height of the quilt"},
    {"@tiles", "tileX", "integer", "tiles", "tiles across"},
    {"@tiles", "tileY", "integer", "tiles", "tiles upwards"},
    {"button", "action", "string", NULL, "what the button does, as --buttons has it"},
    {"subscribe", "events", "[string]", NULL, "events that this client gets from now on"},
    {"shutdown", NULL, NULL, NULL, NULL},

    {"!frame", "generation", "integer", COUNT, "number of the scene and camera"},
    {"!frame", "level", "string", NULL, "none, coarse, complete or converged"},
    {"!frame", "passes", "number", "passes", "passes that the picture is made of"},
    {"!frame", "picture", "string", NULL, "reconstructed, unfiltered or card"},
    {"!frame", "card", "string", NULL, "line on the card, if one is shown"},
    {"!converged", "generation", "integer", COUNT, "number of the scene and camera"},
    {"!converged", "passes", "number", "passes", "passes that the picture is made of"},
    {"!device", "", "@device", NULL, ""},
    {"!scene", "generation", "integer", COUNT, "number of the scene that is shown now"},
    {"!scene", "file", "string", NULL, "file that it came from"},
    {"!scene.load", "", "@reading", NULL, ""},
    {"!scene.load", "job", "integer", COUNT, "number of the load, for job.cancel"},
    {"!export", "", "@job", NULL, ""},
    {"!export", "error", "@error", NULL, "why it failed; left out: it did not"},
    {"!button", "button", "string", NULL, "square, left, right or circle"},
    {"!button", "action", "string", NULL, "what it does, as --buttons has it"},
};

static const lf_notification events[] = {
    {"frame", "frame", "another picture is shown"},
    {"converged", "converged", "the picture has reached the target error"},
    {"device", "device", "the panel came, went or changed"},
    {"scene", "scene", "another scene is shown, or the same one changed"},
    {"scene.load", "scene", "a file of a scene is being read, twice a second"},
    {"export", "export", "how far an export is, and its end; whoever asked for it gets it anyway"},
    {"button", "button", "a button of the panel was pressed"},
};
/* clang-format on */

const lf_notification *lf_notification_at(int index)
{
    return index < (int)(sizeof events / sizeof *events) ? &events[index] : NULL;
}

/* ----------------------------------------------------------------------------------- schemas -- */

/* Adds the fields of an object to properties; false: not in the table. */
static bool add_fields(const char *of, json_t *properties);

static json_t *object_schema(const char *of)
{
    json_t *properties = json_object();
    if (add_fields(of, properties))
        return json_pack("{s:s, s:o}", "type", "object", "properties", properties);
    json_decref(properties);
    return NULL;
}

static json_t *type_schema(const char *type)
{
    char word[32];
    if (type[0] == '[')
        return json_pack("{s:s, s:o}", "type", "array", "items", type_schema(type + 1));
    const size_t n = strcspn(type, "|]");
    snprintf(word, sizeof word, "%.*s", (int)n, type);
    json_t *schema = word[0] == '@' ? object_schema(word) : json_pack("{s:s}", "type", word);
    if (type[n] == '|')
        json_object_set_new(schema, "type",
                            json_pack("[O, s]", json_object_get(schema, "type"), type + n + 1));
    return schema;
}

static bool add_fields(const char *of, json_t *properties)
{
    bool found = false;
    for (const field *f = fields; f < fields + sizeof fields / sizeof *fields; f++) {
        if (strcmp(f->of, of) != 0)
            continue;
        found = true;
        if (f->key && f->key[0] == '\0') {
            add_fields(f->type, properties); /* all fields of that object */
        } else if (f->key) {
            json_t *schema = type_schema(f->type);
            json_object_set_new(schema, "description", json_string(f->about));
            if (f->unit)
                json_object_set_new(schema, "unit", json_string(f->unit));
            json_object_set_new(properties, f->key, schema);
        }
    }
    return found;
}

/* Built once and never freed: constant like the tables. */
static json_t *all_methods, *all_events;
static pthread_once_t made = PTHREAD_ONCE_INIT;

static void make(void)
{
    all_methods = json_object();
    for (int i = 0; lf_method_at(i); i++) {
        const lf_method *method = lf_method_at(i);
        json_t *entry = json_pack("{s:s, s:O, s:o*, s:s}", "summary", method->summary, "params",
                                  lf_method_schema(i), "result", object_schema(method->name),
                                  "example", method->example);
        json_object_set_new(all_methods, method->name, entry);
    }
    all_events = json_object();
    for (int i = 0; lf_notification_at(i); i++) {
        char of[32];
        snprintf(of, sizeof of, "!%s", events[i].name);
        json_t *entry = json_pack("{s:s, s:s, s:o*}", "summary", events[i].summary, "event",
                                  events[i].event, "params", object_schema(of));
        json_object_set_new(all_events, events[i].name, entry);
    }
}

json_t *lf_methods_json(void)
{
    pthread_once(&made, make);
    return all_methods;
}

json_t *lf_events_json(void)
{
    pthread_once(&made, make);
    return all_events;
}
