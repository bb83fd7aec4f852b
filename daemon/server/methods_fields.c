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
    {"hello", "folders", "[string]", NULL, "folders from which clients may name files"},
    {"hello", "farms", "[string]", NULL, "farms that an export may name"},
    {"hello", "methods", "object", NULL,
     "methods by name, each with summary, params and result (JSON Schemas) and example"},
    {"hello", "events", "object", NULL,
     "notifications by name, each with summary, event (for subscribe) and params (JSON Schema)"},
    {"hello", "limited", "boolean", NULL,
     "true: this connection may call only some of quiltd's methods"},

    {"status", "state", "string", NULL, "rendering, converged, paused, idle or error"},
    {"status", "error", "@error", NULL,
     "why the scene could not be loaded; absent if it was loaded"},
    {"status", "scene", "string|null", NULL, "file on display"},
    {"status", "passed", "[string]", NULL,
     "files and arrays of the scene that clients passed as descriptors"},
    {"status", "is_quilt", "boolean", NULL,
     "true: a finished image is on display, not a rendering"},
    {"status", "is_rgbd", "boolean", NULL,
     "true: its views were drawn from an image with depth; only with is_quilt"},
    {"status", "standing", "object", NULL,
     "how the finished image stands, as the keys of scene.load; only with is_quilt"},
    {"status", "views", "integer", COUNT, "number of views"},
    {"status", "columns", "integer", COUNT, "columns of the quilt"},
    {"status", "rows", "integer", COUNT, "rows of the quilt"},
    {"status", "view_width", "integer", "pixels", "width of one view"},
    {"status", "view_height", "integer", "pixels", "height of one view"},
    {"status", "aspect", "number", "width over height", "aspect of the focal plane"},
    {"status", "cone", "number", "degrees",
     "total angle over which the cameras are spread, seen from the target"},
    {"status", "track", "number", "scene units", "length of the camera track"},
    {"status", "time", "@time", NULL, "current frame, and playback"},
    {"status", "depth_budget", "@depth|null", NULL, "whether the scene is too deep for a panel"},
    {"status", "seed", "integer|string", COUNT, "random seed; a string if it exceeds 2^63 - 1"},
    {"status", "integrator", "string", NULL, "name of the integrator"},
    {"status", "generation", "integer", COUNT, "number of the scene and camera state"},
    {"status", "level", "string", NULL,
     "level of the image: none, coarse, complete or converged"},
    {"status", "passes", "number", "passes", "passes rendered so far"},
    {"status", "seconds", "number", "seconds", "rendering time so far"},
    {"status", "cpu_seconds", "number", "seconds", "CPU time of all threads so far"},
    {"status", "spp", "number|null", "samples per pixel", "mean native samples of a view pixel"},
    {"status", "error_estimate", "number|null", "relMSE",
     "estimated error of the unfiltered image"},
    {"status", "error_bound", "number|null", "relMSE", "95 % upper bound of this error"},
    {"status", "seconds_left", "number|null", "seconds",
     "estimated rendering time until the error meets target_error"},
    {"status", "denoised_error", "number|null", "relMSE", "error of the denoised image"},
    {"status", "denoised_error_bound", "number|null", "relMSE", "95 % upper bound of this error"},
    {"status", "shown_error", "number|null", "relMSE", "former name of denoised_error"},
    {"status", "shown_error_bound", "number|null", "relMSE", "former name of denoised_error_bound"},
    {"status", "coarse_cost", "@cost|null", NULL,
     "cost of the last image up to its first coarse frame; null: none yet"},
    {"status", "complete_cost", "@cost|null", NULL,
     "cost of the last image up to its first complete frame, the coarse one included"},
    {"status", "missing", "integer", "pixels", "view pixels that no path has reached yet"},
    {"status", "threads", "integer", COUNT, "number of worker threads"},
    {"status", "estimator", "string", NULL, "name of the estimator"},
    {"status", "target_error", "number", "relMSE", "error at which rendering stops; 0: never"},
    {"status", "paused", "boolean", NULL,
     "true: rendering is paused; of a video: it holds the current frame"},
    {"status", "guides", "boolean", NULL, "true: what is too near or too far is tinted"},
    {"status", "denoise", "string", NULL,
     "on: the denoised image is shown, once there is one; off: the unfiltered"},
    {"status", "reconstruct", "string", NULL, "former name of denoise"},
    {"status", "exposure", "@exposure", NULL, "exposure and tone curve"},
    {"status", "shown", "@shown", NULL, "the frame on the panel"},
    {"status", "warnings", "[string]", NULL, "warnings about the scene and its image"},
    {"status", "device", "@device", NULL, "the panel that is open"},
    {"status", "updates", "integer", COUNT, "updates pushed to the panel"},
    {"status", "bytes", "integer", "bytes", "bytes pushed to the panel"},
    {"status", "device_errors", "integer", COUNT, "updates that the panel did not accept"},
    {"status", "loading", "integer", COUNT, "number of loads waiting or in progress"},
    {"status", "load", "@load|null", NULL, "the load in progress"},
    {"status", "reading", "@reading|null", NULL, "file being read"},
    {"status", "landlock", "string", NULL,
     "Landlock confinement of the file readers: on, off, refused or unknown"},
    {"status", "clients", "integer", COUNT, "number of connected clients"},
    {"status", "lines", "integer", COUNT, "number of client lines handled so far"},
    {"status", "jobs", "[@job]", NULL, "exports waiting or running"},
    {"status", "playlist", "@slideshow|null", NULL, "the slideshow; null: no entries"},
    {"status", "video", "@video|null", NULL, "the video on display; null: none"},
    {"status", "uptime", "number", "seconds", "time since the daemon started"},
    {"status", "longest_turn", "number", "seconds",
     "longest CPU time of the event thread for one event"},

    {"@cost", "paths", "number", "CPU seconds", "all threads: rows with paths"},
    {"@cost", "fans", "number", "CPU seconds", "all threads: rows without paths yet"},
    {"@cost", "fit", "number", "CPU seconds", "all threads: fitting the denoiser"},
    {"@cost", "answer", "number", "CPU seconds", "all threads: denoised rows"},
    {"@cost", "compose", "number", "CPU seconds", "all threads: tone mapping and interlacing"},

    {"@error", "code", "integer", COUNT, "error code, as in an error response"},
    {"@error", "message", "string", NULL, "what is wrong and what to do, in one line"},
    {"@error", "data", "@place", NULL, "where the error is, if known"},
    {"@place", "file", "string", NULL, "file or option with the error"},
    {"@place", "line", "integer", COUNT, "line in this file, from 1"},
    {"@place", "pointer", "string", NULL, "JSON pointer of the value"},
    {"@time", "frame", "integer", "frames", "frame number"},
    {"@time", "playing", "boolean", NULL, "true: frames are being played"},
    {"@time", "fps", "number", "frames per second", "playback speed; absent unless playing"},
    {"@time", "rate", "number", "frames per second", "former name of fps"},
    {"@time", "from", "integer", "frames", "first frame, during playback"},
    {"@time", "to", "integer", "frames", "last frame, during playback"},
    {"@time", "loop", "boolean", NULL, "true: loop, during playback"},
    {"@depth", "nearest", "number", "scene units", "distance of the nearest point"},
    {"@depth", "farthest", "number", "scene units", "distance of the farthest point"},
    {"@depth", "nearest_step", "number|null", "pixels", "shift of this point between views"},
    {"@depth", "farthest_step", "number", "pixels", "shift of this point between views"},
    {"@depth", "limit", "number", "pixels", "largest shift that the panel shows sharply"},
    {"@depth", "sharp_from", "number", "scene units", "nearest sharp distance"},
    {"@depth", "sharp_to", "number|null", "scene units",
     "farthest sharp distance; null: no limit"},
    {"@depth", "exceeded", "boolean", NULL,
     "true: the scene exceeds these distances and has no view_blur"},
    {"@exposure", "stops", "number", "stops", "exposure in use"},
    {"@exposure", "auto", "boolean", NULL, "true: quiltd chose it from the image"},
    {"@exposure", "tonemap", "string", NULL, "name of the tone curve"},
    {"@shown", "generation", "integer", COUNT, "number of the scene and camera state"},
    {"@shown", "level", "string", NULL, "none, coarse, complete or converged"},
    {"@shown", "image", "string", NULL, "denoised, unfiltered or card"},
    {"@shown", "picture", "string", NULL, "former image: reconstructed, unfiltered or card"},
    {"@shown", "card", "string|null", NULL, "text on the card; null: no card"},
    {"@device", "spec", "string", NULL, "device spec for --device and device.set"},
    {"@device", "kind", "string", NULL, "kind of device, such as sim or none"},
    {"@device", "model", "string", NULL, "name of the display, if it has one"},
    {"@device", "serial", "string", NULL, "serial number of the panel"},
    {"@device", "calibration_from", "string", NULL, "where the calibration came from"},
    {"@device", "output", "string", NULL, "file, connector or USB address"},
    {"@device", "problem", "string", NULL, "what is wrong and what to do; empty if all is well"},
    {"@device", "present", "boolean", NULL, "true: the device is open; absent in lists"},
    {"@device", "response", "@response", NULL, "response of the panel; absent in lists"},
    {"@response", "gamma", "number|string", "exponent", "gamma: a number or srgb"},
    {"@response", "white", "number", "kelvin", "colour temperature of the white; 0: not set"},
    {"@response", "white_x", "number", "CIE x", "chromaticity of the white; 0: not set"},
    {"@response", "white_y", "number", "CIE y", "chromaticity of the white; 0: not set"},
    {"@load", "job", "integer", COUNT, "job number of the load, for job.cancel"},
    {"@load", "kind", "string", NULL, "file, patch, orbit, fit or settings"},
    {"@load", "file", "string|null", NULL, "file being loaded"},
    {"@reading", "file", "string", NULL, "file being read, one of the scene's files"},
    {"@reading", "bytes", "integer", "bytes", "size of this file"},
    {"@reading", "seconds", "number", "seconds", "time spent on this file so far"},
    {"@reading", "files_read", "integer", COUNT, "number of files read before"},
    {"@job", "job", "integer", COUNT, "job number of the export"},
    {"@job", "kind", "string", NULL, "kind of the export"},
    {"@job", "file", "string", NULL, "file being written"},
    {"@job", "state", "string", NULL, "waiting, running, done, failed or cancelled"},
    {"@job", "progress", "number", "share",
     "share written, or of a farm's tasks that are complete, from 0 to 1"},
    {"@job", "farm", "@farm", NULL, "the farm that renders it; absent if quiltd does"},
    {"@farm", "engine", "string", NULL, "slurm, parallel or list"},
    {"@farm", "folder", "string", NULL, "folder of the job, for quiltfarm"},
    {"@farm", "state", "string", NULL,
     "planning, submitting, planned, queued, running, merging, interrupted, failed or complete"},
    {"@farm", "tasks", "@tasks", NULL, "its tasks"},
    {"@tasks", "total", "integer", COUNT, "all tasks; 0: not known yet"},
    {"@tasks", "complete", "integer", COUNT, "tasks whose results are there"},
    {"@tasks", "running", "integer", COUNT, "tasks that run"},
    {"@tasks", "failed", "integer", COUNT, "tasks that have failed"},
    {"@tasks", "missing", "integer", COUNT, "tasks that have no result yet"},
    {"@farm", "cpu_seconds", "@spending", NULL, "CPU time of all tasks"},
    {"@spending", "planned", "number|null", "seconds", "what quiltfarm expects; null: unknown"},
    {"@spending", "spent", "number|null", "seconds", "what was used so far; null: unknown"},
    {"@farm", "seconds_left", "number|null", "seconds", "time to its end; null: unknown"},
    {"@farm", "problem", "string|null", NULL,
     "why quiltfarm did not say how far it is; null: it did"},

    {"scene.load", "generation", "integer", COUNT, "generation of the scene on display"},
    {"scene.load", "warnings", "[string]", NULL, "features of its files that the image lacks"},
    {"scene.get", "file", "string", NULL, "file of the scene"},
    {"scene.get", "generation", "integer", COUNT, "generation of the scene"},
    {"scene.get", "bounds", "@bounds|null", NULL, "bounding box of the scene without its grounds"},
    {"scene.get", "scene", "object|null", NULL,
     "scene document; null: a finished image is on display"},
    {"@bounds", "min", "[number]", "scene units", "minimum x, y and z"},
    {"@bounds", "max", "[number]", "scene units", "maximum x, y and z"},
    {"quilt.show", "generation", "integer", COUNT, "generation of the quilt on display"},
    {"quilt.show", "warnings", "[string]", NULL, "features of its file that the image lacks"},
    {"scene.patch", "generation", "integer", COUNT, "generation of the scene on display"},
    {"scene.patch", "warnings", "[string]", NULL, "features of its files that the image lacks"},
    {"camera.set", "generation", "integer", COUNT, "generation of the scene on display"},
    {"camera.set", "warnings", "[string]", NULL, "features of its files that the image lacks"},
    {"camera.orbit", "generation", "integer", COUNT, "generation of the scene on display"},
    {"camera.fit", "generation", "integer", COUNT, "generation of the scene on display"},
    {"time.set", "generation", "integer", COUNT, "generation of the scene on display"},
    {"time.set", "warnings", "[string]", NULL, "features of its files that the image lacks"},
    {"time.play", "", "@time", NULL, ""},
    {"time.stop", "", "@time", NULL, ""},
    {"playlist.set", "", "@playlist", NULL, ""},
    {"playlist.get", "", "@playlist", NULL, ""},
    {"playlist.play", "", "@playlist", NULL, ""},
    {"playlist.stop", "", "@playlist", NULL, ""},
    {"playlist.pause", "", "@playlist", NULL, ""},
    {"playlist.change", "", "@playlist", NULL, ""},
    {"playlist.next", "", "@playlist", NULL, ""},
    {"playlist.previous", "", "@playlist", NULL, ""},
    {"@playlist", "entries", "[@part]", NULL, "what is shown, in this order"},
    {"@playlist", "folder", "string|null", NULL, "folder that the entries are from; null: none"},
    {"@playlist", "more", "boolean", NULL, "true: the folder has more files than entries"},
    {"@playlist", "index", "integer", COUNT, "number of the current entry, from 0"},
    {"@playlist", "turn", "integer", COUNT, "times that the slideshow has begun to load an entry"},
    {"@playlist", "playing", "boolean", NULL, "true: the entries are shown in turn"},
    {"@playlist", "paused", "boolean", NULL, "true: the time of the current entry is stopped"},
    {"@playlist", "loop", "boolean", NULL, "true: starts again after the last entry"},
    {"@playlist", "seconds", "number", "seconds",
     "default time of an entry; a video plays once through"},
    {"@playlist", "crossfade", "number", "seconds",
     "time in which an image turns into the next one"},
    {"@part", "file", "string", NULL, "path of the file"},
    {"@part", "seconds", "number", "seconds",
     "time from the first frame that is shown; absent: not given"},
    {"@part", "quilt", "string", NULL, "tiles COLUMNSxROWS; absent: not given"},
    {"@part", "yaw", "number", "degrees", "as of scene.load; this and all below absent: not given"},
    {"@part", "pitch", "number", "degrees", "as of scene.load"},
    {"@part", "up", "string", NULL, "as of scene.load"},
    {"@part", "bare", "boolean", NULL, "as of scene.load"},
    {"@part", "photo", "string", NULL, "as of scene.load"},
    {"@part", "photo_position", "string", NULL, "as of scene.load"},
    {"@part", "photo_rotate", "string", NULL, "as of scene.load"},
    {"@part", "aspect", "number", "width over height", "as of scene.load"},
    {"@part", "views", "integer", COUNT, "as of scene.load"},
    {"@part", "rgbd_in", "string", NULL, "as of scene.load"},
    {"@part", "depth_inversion", "string", NULL, "as of scene.load"},
    {"@part", "chroma_depth", "string", NULL, "as of scene.load"},
    {"@part", "depthiness", "number", "factor", "as of scene.load"},
    {"@part", "depth_cutoff", "number", "code", "as of scene.load"},
    {"@part", "focus", "number", "widths", "as of scene.load"},
    {"@part", "zoom", "number", "factor", "as of scene.load"},
    {"@part", "crop_x", "number", "half widths", "as of scene.load"},
    {"@part", "crop_y", "number", "half heights", "as of scene.load"},
    {"@slideshow", "index", "integer", COUNT, "number of the current entry, from 0"},
    {"@slideshow", "playing", "boolean", NULL, "true: the entries are shown in turn"},
    {"@slideshow", "paused", "boolean", NULL, "true: the time of the current entry is stopped"},
    {"@slideshow", "entries", "integer", COUNT, "number of entries"},
    {"@slideshow", "file", "string", NULL, "file of the current entry"},
    {"@video", "file", "string", NULL, "its file"},
    {"@video", "width", "integer", "pixels", "width of its images"},
    {"@video", "height", "integer", "pixels", "height of its images"},
    {"@video", "fps", "number", "frames per second", "its rate"},
    {"@video", "seconds", "number", "seconds", "position of the current frame"},
    {"@video", "duration", "number|null", "seconds", "its length; null: unknown"},
    {"@video", "frame", "integer", "frames", "number of the current frame, from 0 in each round"},
    {"@video", "shown", "integer", "frames", "frames that the panel took"},
    {"@video", "dropped", "integer", "frames",
     "frames that were late, or that the panel did not take"},
    {"@video", "paused", "boolean", NULL, "true: it holds the current frame"},
    {"@video", "problem", "string|null", NULL,
     "why it has stopped and holds its last frame; null: it plays"},
    {"wait", "generation", "integer", COUNT, "generation of the scene on the panel"},
    {"wait", "level", "string", NULL, "coarse, complete or converged"},
    {"render.set", "generation", "integer", COUNT,
     "generation of the image; a new one if the image restarts"},
    {"frame.get", "generation", "integer", COUNT, "number of the scene and camera state"},
    {"frame.get", "level", "string", NULL, "none, coarse, complete or converged"},
    {"frame.get", "passes", "number", "passes", "passes in the image"},
    {"frame.get", "image", "string", NULL, "denoised or unfiltered"},
    {"frame.get", "format", "string", NULL, "jpeg or raw"},
    {"frame.get", "columns", "integer", "tiles", "columns of the quilt"},
    {"frame.get", "rows", "integer", "tiles", "rows of the quilt"},
    {"frame.get", "views", "integer", COUNT, "number of views"},
    {"frame.get", "width", "integer", "pixels", "width of one view"},
    {"frame.get", "height", "integer", "pixels", "height of one view"},
    {"frame.get", "bytes", "integer", "bytes", "size of the written file"},
    {"library.list", "folder", "string|null", NULL, "folder that is listed; null: none"},
    {"library.list", "folders", "[string]", NULL, "folders that may be read by name"},
    {"library.list", "entries", "[@entry]", NULL, "what is in the folder, folders first"},
    {"library.list", "more", "boolean", NULL, "true: further entries are left out"},
    {"@entry", "name", "string", NULL, "name without the folder"},
    {"@entry", "path", "string", NULL, "absolute path, for scene.load"},
    {"@entry", "kind", "string", NULL,
     "folder, scene, model, volume, environment, quilt, video or image"},
    {"@entry", "bytes", "integer", "bytes", "size of the file; 0: a folder"},
    {"@entry", "modified", "number", "seconds", "time of the last change since 1970 (UTC)"},
    {"library.thumbnail", "width", "integer", "pixels", "width of the JPEG"},
    {"library.thumbnail", "height", "integer", "pixels", "height of the JPEG"},
    {"library.thumbnail", "bytes", "integer", "bytes", "size of the written file"},
    {"export", "job", "integer", COUNT,
     "job number of the export; a notification reports its end"},
    {"export", "file", "string", NULL, "file to be written; with fds the name of the call"},
    {"export", "warnings", "[string]", NULL, "print: whether the scene is too deep for the sheet"},
    {"job.cancel", NULL, NULL, NULL, NULL},
    {"device.list", "devices", "[@device]", NULL, "devices that can be opened"},
    {"device.list", "present", "@device", NULL, "device that is open"},
    {"device.set", "", "@device", NULL, ""},
    {"device.calibration", "configVersion", "string", NULL, "version of the calibration format"},
    {"device.calibration", "serial", "string", NULL, "serial number of the panel"},
    {"device.calibration", "pitch", "number", "lenses per inch", "pitch of the lenses"},
    {"device.calibration", "slope", "number", "rise over run", "slant of the lenses"},
    {"device.calibration", "center", "number", "lens periods", "phase of the lenses"},
    {"device.calibration", "viewCone", "number", "degrees",
     "view cone of the optics; 0: not given"},
    {"device.calibration", "DPI", "number", "pixels per inch", "resolution of the panel"},
    {"device.calibration", "screenW", "integer", "pixels", "width of the panel"},
    {"device.calibration", "screenH", "integer", "pixels", "height of the panel"},
    {"device.calibration", "invView", "integer", COUNT, "1: the order of the views is reversed"},
    {"device.calibration", "flipImageX", "integer", COUNT, "1: mirrored horizontally"},
    {"device.calibration", "flipImageY", "integer", COUNT, "1: mirrored vertically"},
    {"device.calibration", "flipSubp", "integer", COUNT,
     "1: the subpixel order is blue, green, red"},
    {"device.calibration", "CellPatternMode", "integer", COUNT, "number of the subpixel layout"},
    {"device.calibration", "subpixelCells", "[object]", NULL, "positions of the subpixels"},
    {"device.calibration", "defaultQuilt", "@tiles", NULL, "quilt layout of the panel, if given"},
    {"@tiles", "quiltX", "integer", "pixels", "width of the quilt"},
    {"@tiles", "quiltY", "integer", "pixels", "height of the quilt"},
    {"@tiles", "tileX", "integer", "tiles", "columns of the quilt"},
    {"@tiles", "tileY", "integer", "tiles", "rows of the quilt"},
    {"doctor", "findings", "[@finding]", NULL, "what was found, in order"},
    {"@finding", "level", "string", NULL, "ok: works; note: may matter; fail: must be fixed"},
    {"@finding", "text", "string", NULL, "what was found and what to do, in one line"},
    {"button", "action", "string", NULL, "action of the button, as in --buttons"},
    {"log.tail", "lines", "[@line]", NULL, "lines of the log, oldest first"},
    {"@line", "number", "integer", COUNT, "number of the line since the daemon started"},
    {"@line", "time", "number", "seconds", "time of the line since 1970 (UTC)"},
    {"@line", "level", "string", NULL, "error, warning, info or debug"},
    {"@line", "text", "string", NULL, "text of the line, at most 1023 bytes"},
    {"subscribe", "events", "[string]", NULL, "events that this client now receives"},
    {"rights.limit", "methods", "[string]", NULL, "methods that this connection may call now"},
    {"shutdown", NULL, NULL, NULL, NULL},

    {"!frame", "generation", "integer", COUNT, "number of the scene and camera state"},
    {"!frame", "level", "string", NULL, "none, coarse, complete or converged"},
    {"!frame", "passes", "number", "passes", "passes in the image"},
    {"!frame", "image", "string", NULL, "denoised, unfiltered or card"},
    {"!frame", "picture", "string", NULL, "former image: reconstructed, unfiltered or card"},
    {"!frame", "card", "string", NULL, "text on the card, if one is shown"},
    {"!converged", "generation", "integer", COUNT, "number of the scene and camera state"},
    {"!converged", "passes", "number", "passes", "passes in the image"},
    {"!device", "", "@device", NULL, ""},
    {"!scene", "generation", "integer", COUNT, "generation of the scene on display"},
    {"!scene", "file", "string", NULL, "file of the scene"},
    {"!scene", "turn", "integer", COUNT,
     "turn of the slideshow that loaded it; absent: loaded otherwise"},
    {"!scene.load", "", "@reading", NULL, ""},
    {"!scene.load", "job", "integer", COUNT, "job number of the load, for job.cancel"},
    {"!export", "", "@job", NULL, ""},
    {"!export", "error", "@error", NULL, "why it failed; absent if it did not"},
    {"!export", "used", "[string]", NULL, "print by profiles: what they gave"},
    {"!export", "warnings", "[string]", NULL, "print by profiles: what they lack"},
    {"!log", "", "@line", NULL, ""},
    {"!playlist", "", "@playlist", NULL, ""},
    {"!button", "button", "string", NULL, "square, left, right or circle"},
    {"!button", "action", "string", NULL, "action of the button, as in --buttons"},
};

static const lf_notification events[] = {
    {"frame", "frame", "the panel shows a new frame"},
    {"converged", "converged", "the image has reached the target error"},
    {"device", "device", "the panel was connected, disconnected or changed"},
    {"scene", "scene", "the scene was replaced or changed"},
    {"scene.load", "scene", "progress of reading a scene file, sent twice per second"},
    {"export", "export", "progress and end of an export; the client that started it always "
                         "receives it"},
    {"log", "log", "the daemon has logged a line"},
    {"playlist", "playlist", "the slideshow started, stopped, changed or shows another entry"},
    {"button", "button", "a button on the panel was pressed"},
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
