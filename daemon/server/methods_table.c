#include "daemon/server/methods_internal.h"

#include <pthread.h>
#include <string.h>

/* JSON Schemas as text, formatted by hand */
/* clang-format off */
#define OBJECT(properties)                                                                         \
    "{\"type\":\"object\",\"additionalProperties\":false,\"properties\":{" properties "}}"
#define OBJECT_WITH(required, properties)                                                          \
    "{\"type\":\"object\",\"additionalProperties\":false,\"required\":[" required                  \
    "],\"properties\":{" properties "}}"
#define KEY(name, rest, about) "\"" name "\":{" rest ",\"description\":\"" about "\"}"
#define FORMER_OF(now) ",\"deprecated\":true,\"former_name_of\":\"" now "\""
#define FORMER(name, rest, now) KEY(name, rest FORMER_OF(now), "former name of " now)
#define STRING "\"type\":\"string\""
#define NUMBER(unit) "\"type\":\"number\",\"unit\":\"" unit "\""
#define INTEGER(unit) "\"type\":\"integer\",\"unit\":\"" unit "\""
#define BOOLEAN(initial) "\"type\":\"boolean\",\"default\":" initial
#define RANGE(low, high) ",\"minimum\":" low ",\"maximum\":" high
#define DEFAULT(value) ",\"default\":" value
#define FRAME INTEGER("frames") RANGE("0", "999999")
#define ENUM(words) STRING ",\"enum\":[" words "]"
#define LIST(items) "\"type\":\"array\",\"items\":{" items "}"

#define FILES                                                                                      \
    KEY("files", LIST(STRING) ",\"maxItems\":64",                                                  \
        "absolute names of the passed files, in the order of their descriptors (SCM_RIGHTS, "      \
        "read-only); quiltctl fills this in")

#define ARRAYS                                                                                     \
    KEY("arrays", "\"type\":\"object\",\"additionalProperties\":true",                             \
        "arrays of the scene by name, each {shape, type}; their descriptors come after the "       \
        "descriptors of files")

#define EXPORT_KEYS                                                                                \
    KEY("kind", STRING, "kind of output, see Export kinds") ","                                    \
    KEY("file", STRING,                                                                            \
        "name of the file, or of a folder with a final slash, below --export-dir; with fds any "   \
        "name: only its ending counts") ","                                                        \
    KEY("wait", ENUM("\"coarse\",\"complete\",\"converged\"") DEFAULT("\"coarse\""),               \
        "write as soon as the image has this level; state: at once") ","                           \
    KEY("detach", BOOLEAN("false"), "continue after the client disconnects") ","                   \
    KEY("overwrite", BOOLEAN("false"), "replace an existing file") ","                             \
    KEY("denoise", ENUM("\"auto\",\"off\",\"on\"") DEFAULT("\"auto\""),                            \
        "write the denoised image; auto: as on the panel, but EXR files unfiltered") ","           \
    FORMER("reconstruct", ENUM("\"auto\",\"off\",\"on\""), "denoise") ","                          \
    KEY("farm", ENUM("\"slurm\",\"parallel\",\"list\""),                                          \
        "farm that renders the scene again, see Farms; quiltd needs --farm") ","                   \
    KEY("job", STRING,                                                                             \
        "farm: new folder below --export-dir, for scene, tasks and states of the job") ","         \
    KEY("spp", INTEGER("samples per pixel") RANGE("1", "1000000000"),                              \
        "farm: base paths per view pixel (as quiltrender)") ","                                    \
    KEY("passes", INTEGER("passes") RANGE("1", "1000000000000"),                                   \
        "farm: base paths per pixel of one view (as quiltrender)") ","                             \
    KEY("fds", "\"type\":\"integer\"" RANGE("0", "253") DEFAULT("0"),                              \
        "number of descriptors (SCM_RIGHTS) that come with the call; quiltd writes to them "       \
        "instead of opening file")

/* Of an entry of the slideshow. */
#define ENTRY_KEYS                                                                                 \
    KEY("seconds", NUMBER("seconds") RANGE("0.1", "86400"),                                        \
        "time from the first frame that is shown (a video once through; others the list's)") ","   \
    KEY("quilt", STRING, "tiles COLUMNSxROWS of an image or video whose name has no _qs suffix")

static const lf_method methods[] = {
    {"hello", "return version, protocol, methods and notifications", "hello", OBJECT(""),
     lf_method_hello},
    {"status", "return the state of the daemon", "status", OBJECT(""), lf_method_status},
    {"scene.load", "show a scene file, a model, a volume or a quilt image",
     "scene.load file=/home/me/helmet.glb",
     OBJECT(
         KEY("file", STRING,
             "path of a scene, model, volume, quilt image, quilt video or folder of views; "
             "quiltctl makes it absolute") ","
         KEY("scene", "\"type\":\"object\",\"additionalProperties\":true",
             "scene document, instead of file; its paths are absolute") ","
         KEY("scene_fd", BOOLEAN("false"),
             "the scene document comes as the first descriptor, instead of file; at most 16 "
             "MiB") ","
         KEY("name", STRING,
             "name of scene or scene_fd in messages, at most 128 bytes without / (scene)") ","
         ARRAYS ","
         KEY("quilt", STRING, "tiles COLUMNSxROWS of an image whose name has no _qs suffix") ","
         FILES),
     lf_method_scene_load},
    {"scene.get", "return the current scene", "scene.get", OBJECT(""), lf_method_scene_get},
    {"scene.patch", "change the current scene with a JSON Merge Patch (RFC 7396)",
     "scene.patch patch:={\"lights\":{\"sky\":null}}",
     OBJECT_WITH("\"patch\"",
         KEY("patch", "\"type\":\"object\",\"additionalProperties\":true",
             "keys of the scene file with their new values; null removes a key") ","
         FILES ","
         ARRAYS),
     lf_method_scene_patch},
    {"quilt.show", "show a quilt that comes by a passed descriptor, as raw pixels or an image file",
     "quilt.show photo.png columns=8 rows=6",
     OBJECT(
         KEY("columns", INTEGER("count") RANGE("1", "64"),
             "columns of tiles; they divide the width; required, except with rgbd_in") ","
         KEY("rows", INTEGER("count") RANGE("1", "64"),
             "rows of tiles; they divide the height; required, except with rgbd_in") ","
         KEY("views", INTEGER("count") RANGE("1", "4096"), "number of views (columns x rows)") ","
         KEY("aspect", NUMBER("width / height") RANGE("0.01", "100"), "aspect of a view (a tile's)")
         ","
         KEY("width", INTEGER("pixels") RANGE("1", "16384"),
             "width of the whole quilt in raw pixels; without it the descriptor is an image file")
         ","
         KEY("height", INTEGER("pixels") RANGE("1", "16384"), "its height") ","
         KEY("name", STRING, "name in messages, at most 128 bytes without / (quilt)")),
     lf_method_quilt_show},
    {"camera.set", "set keys of the camera; other keys keep their values",
     "camera.set fov_y=20 target=0,1,0", OBJECT(""), lf_method_camera_set},
    {"camera.orbit", "orbit the camera around its target", "camera.orbit yaw=15 pitch=-5",
     OBJECT(KEY("yaw", NUMBER("degrees") DEFAULT("0"), "rotation to the right around the target")
            ","
            KEY("pitch", NUMBER("degrees") DEFAULT("0"), "rotation upwards around the target") ","
            KEY("zoom", "\"type\":\"number\"" RANGE("1e-3", "1e3") DEFAULT("1"),
                "how many times nearer to the target")),
     lf_method_camera_orbit},
    {"camera.fit", "move the camera so that the scene, or a part of it, fills the views",
     "camera.fit name=model fill=0.8",
     OBJECT(KEY("name", STRING, "mesh or volume to frame (the scene except its grounds)")
            ","
            KEY("fill", NUMBER("share of the window") RANGE("0.01", "1") DEFAULT("0.9"),
                "share of the window's width or height that it fills in every view") ","
            KEY("steps", NUMBER("pixels") RANGE("0.01", "10000"),
                "largest shift of any of its points between neighbouring views (no limit)")),
     lf_method_camera_fit},
    {"time.set", "show a frame of the scene", "time.set frame=24",
     OBJECT_WITH("\"frame\"", KEY("frame", FRAME, "number of the frame")), lf_method_time_set},
    {"time.play", "play frames of the scene", "time.play from=1 to=48",
     OBJECT_WITH("\"to\"", KEY("from", FRAME, "first frame (the frame that is shown)") ","
                 KEY("to", FRAME, "last frame, not before from") ","
                 KEY("loop", BOOLEAN("true"), "start again after the last frame") ","
                 KEY("fps", NUMBER("frames per second") RANGE("0.01", "1000"),
                     "playback speed (the scene's fps)") ","
                 FORMER("rate", NUMBER("frames per second") RANGE("0.01", "1000"), "fps")),
     lf_method_time_play},
    {"time.stop", "stop at the current frame", "time.stop", OBJECT(""),
     lf_method_time_stop},
    {"playlist.set", "replace the entries of the slideshow",
     "playlist.set entries:=[{\"file\":\"/srv/a.png\",\"seconds\":10}]",
     OBJECT(
         KEY("entries", "\"type\":\"array\",\"maxItems\":1000,\"items\":"
             OBJECT_WITH("\"file\"",
                 KEY("file", STRING, "absolute path of a scene, model, volume or image") ","
                 ENTRY_KEYS),
             "what to show, in this order: each {file} and the keys of playlist.change; an empty "
             "list stops") ","
         KEY("folder", STRING,
             "folder whose pictures, quilts, videos, scenes, models and volumes are shown in "
             "natural order, instead of entries") ","
         KEY("seconds", NUMBER("seconds") RANGE("0.1", "86400") DEFAULT("10"),
             "default time of an entry; a video plays once through") ","
         KEY("loop", BOOLEAN("true"), "start again after the last entry") ","
         KEY("crossfade", NUMBER("seconds") RANGE("0", "10") DEFAULT("0"),
             "time in which an image turns into the next one") ","
         KEY("check", BOOLEAN("false"), "check all and answer as usual, but change nothing")),
     lf_server_playlist_set},
    {"playlist.get", "return the slideshow", "playlist.get", OBJECT(""), lf_server_playlist_get},
    {"playlist.play", "start the slideshow, or go to an entry", "playlist.play index=0",
     OBJECT(KEY("index", INTEGER("count") RANGE("0", "999"),
                "entry to begin with, from 0 (where it stopped; after its end the first)")),
     lf_server_playlist_play},
    {"playlist.stop", "stop the slideshow at the current entry", "playlist.stop", OBJECT(""),
     lf_server_playlist_stop},
    {"playlist.pause", "pause the slideshow, or let it go on", "playlist.pause paused=true",
     OBJECT(KEY("paused", BOOLEAN("true"),
                "true: the entry stays, and a video holds its frame; false: its time goes on")),
     lf_server_playlist_pause},
    {"playlist.change", "change keys of an entry of the slideshow",
     "playlist.change index=0 seconds=20",
     OBJECT(KEY("index", INTEGER("count") RANGE("0", "999"),
                "entry to change, from 0 (the current one)") ","
            ENTRY_KEYS),
     lf_server_playlist_change},
    {"playlist.next", "show the next entry of the slideshow", "playlist.next", OBJECT(""),
     lf_server_playlist_next},
    {"playlist.previous", "show the previous entry of the slideshow", "playlist.previous",
     OBJECT(""), lf_server_playlist_previous},
    {"wait", "wait until the panel shows the image", "wait for=complete timeout=60",
     OBJECT(KEY("generation", "\"type\":\"integer\",\"unit\":\"count\",\"minimum\":0",
                "wait for this generation or a later one (the newest)") ","
            KEY("for", ENUM("\"coarse\",\"complete\",\"converged\"") DEFAULT("\"coarse\""),
                "level that the panel must show") ","
            KEY("timeout", NUMBER("seconds") RANGE("1e-3", "1e9"),
                "fail with -32004 after this time (never)")),
     lf_method_wait},
    {"render.set", "set how to render; other settings keep their values",
     "render.set denoise=on threads=4",
     OBJECT(KEY("paused", "\"type\":\"boolean\"",
                "stop rendering, or hold the frame of a video, or continue")),
     lf_method_render_set},
    {"frame.get", "write the image that is shown, as a quilt, to a passed descriptor",
     "frame.get image.jpg width=210",
     OBJECT(KEY("views", "\"type\":\"integer\"" RANGE("1", "4096"),
                "number of views, evenly spaced; 1: the middle one (all)") ","
            KEY("width", INTEGER("pixels") RANGE("1", "65536"),
                "width of a view, at most as rendered; the height follows (as rendered)") ","
            KEY("format", ENUM("\"jpeg\",\"raw\"") DEFAULT("\"jpeg\""),
                "raw: RGB, 3 bytes per pixel, rows from the top") ","
            KEY("quality", "\"type\":\"integer\"" RANGE("1", "100") DEFAULT("75"),
                "quality of the JPEG")),
     lf_server_preview},
    {"library.list", "list a readable folder: scenes, models, volumes, images and folders",
     "library.list folder=/srv/scenes",
     OBJECT(KEY("folder", STRING, "folder to list (the folders that quiltd may read)")),
     lf_server_library_list},
    {"library.thumbnail", "write a small JPEG of an image file to a passed descriptor",
     "library.thumbnail small.jpg file=/srv/scenes/photo.png",
     OBJECT_WITH("\"file\"", KEY("file", STRING, "image or quilt; of a quilt the middle view") ","
                 KEY("width", INTEGER("pixels") RANGE("16", "512") DEFAULT("160"),
                     "width of the JPEG, at most the width of the image; the height follows")),
     lf_server_thumbnail},
    {"export", "write a quilt, views, panel image, print, pitch test chart or state",
     "export kind=quilt file=cloud.png wait=converged",
     OBJECT_WITH("\"kind\",\"file\"", EXPORT_KEYS), lf_server_export},
    {"job.cancel", "cancel an export or a load", "job.cancel job=3",
     OBJECT_WITH("\"job\"", KEY("job", INTEGER("count"),
                                "number of the export or load, from its answer or from status")),
     lf_method_job_cancel},
    {"device.list", "list the devices that can be opened", "device.list", OBJECT(""),
     lf_method_device_list},
    {"device.set", "open another device and set the panel's response",
     "device.set spec=auto gamma=2.2",
     OBJECT_WITH("\"spec\"", KEY("spec", STRING,
                                 "device as in --device: auto, none, sim:DIR, drm, window, usb") ","
                 KEY("lend", BOOLEAN("false"),
                     "with spec none: when this connection ends, open the panel again")),
     lf_method_device_set},
    {"device.calibration", "return the lens calibration of the panel", "device.calibration",
     OBJECT(""), lf_method_device_calibration},
    {"doctor", "check what this machine needs to show an image on a panel", "doctor", OBJECT(""),
     lf_server_doctor},
    {"button", "trigger the action of a panel button", "button name=right",
     OBJECT_WITH("\"name\"", KEY("name", ENUM("\"square\",\"left\",\"right\",\"circle\""),
                                 "button of a first-generation panel")),
     lf_method_button},
    {"log.tail", "return the last lines of the log", "log.tail lines=20",
     OBJECT(KEY("lines", "\"type\":\"integer\"" RANGE("1", "200") DEFAULT("200"),
                "number of lines, at most")),
     lf_server_log_tail},
    {"subscribe", "choose the notifications for this client", "subscribe events=scene,frame",
     OBJECT_WITH("\"events\"",
         KEY("events", LIST(ENUM("\"frame\",\"converged\",\"device\",\"scene\",\"export\","
                                 "\"button\",\"log\",\"playlist\"")) ",\"maxItems\":16",
             "events to send; an empty list: none, except the progress of your own exports")),
     lf_method_subscribe},
    {"rights.limit", "allow this connection only these methods from now on",
     "rights.limit methods=hello,status,camera.orbit",
     OBJECT_WITH("\"methods\"",
         KEY("methods", LIST(STRING) ",\"maxItems\":64",
             "methods that stay allowed; each must be allowed before")),
     lf_method_rights_limit},
    {"shutdown", "shut down the daemon", "shutdown", OBJECT(""), lf_method_shutdown},
};
/* clang-format on */

enum { N_METHODS = sizeof methods / sizeof *methods };
_Static_assert(N_METHODS <= LF_MAX_METHODS, "a bit for each");

/* Parsed once and never freed: constant like the texts. */
static json_t *schemas[N_METHODS];
static pthread_once_t parsed = PTHREAD_ONCE_INIT;

/* Methods with parameters from a struct's table. keeps: missing parameters keep their values, so
 * there is no default. */
static const struct {
    const char *method;
    const lf_param *params;
    bool keeps;
} tables[] = {{"export", lf_print_params, false},       {"export", lf_panel_params, false},
              {"export", lf_profile_params, false},     {"export", lf_response_params, true},
              {"export", lf_rgbd_params, false},        {"export", lf_photo_params, false},
              {"scene.load", lf_alone_params, false},   {"scene.load", lf_photo_params, false},
              {"scene.load", lf_picture_params, false}, {"scene.load", lf_standing_params, true},
              {"quilt.show", lf_standing_params, true}, {"device.set", lf_response_params, true},
              {"camera.set", lf_camera_params, true},   {"render.set", lf_option_params, true}};

/* Words with an error text of their own. */
static json_t *refused_words(const lf_param *row)
{
    json_t *words = json_object();
    for (int i = 0; row->refused_at(i); i++)
        json_object_set_new(words, row->refused_at(i), json_string(row->refusal));
    return words;
}

static json_t *table_schema(const lf_param *params, bool keeps)
{
    json_t *schema = lf_param_schema(params), *property;
    const char *key;
    json_object_foreach(schema, key, property)
    {
        if (keeps)
            json_object_del(property, "default");
    }
    for (const lf_param *row = params; row->name || row->option; row++)
        if (row->name && row->refused_at)
            json_object_set_new(json_object_get(schema, row->name), "refused", refused_words(row));
    return schema;
}

/* What a file looks like in a slideshow, as with scene.load. */
static const lf_param *const entry_tables[] = {lf_alone_params, lf_photo_params, lf_picture_params,
                                               lf_standing_params, NULL};

static void add_properties(const char *method, json_t *schema)
{
    json_t *properties = json_object_get(schema, "properties"),
           *items = json_object_get(json_object_get(properties, "entries"), "items");
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        if (strcmp(tables[i].method, method) == 0)
            json_object_update_new(properties, table_schema(tables[i].params, tables[i].keeps));
    if (items || strcmp(method, "playlist.change") == 0)
        for (int i = 0; entry_tables[i]; i++)
            json_object_update_new(items ? json_object_get(items, "properties") : properties,
                                   table_schema(entry_tables[i], true));
}

/* The kinds of export: kinds of pictures, and the daemon's own. */
static void add_kinds(json_t *schema)
{
    json_t *names = json_array();
    for (int i = 0; lf_output_kinds[i]; i++)
        json_array_append_new(names, json_string(lf_output_kinds[i]->name));
    json_array_append_new(names, json_string("state"));
    json_object_set_new(json_object_get(json_object_get(schema, "properties"), "kind"), "enum",
                        names);
}

static void parse(void)
{
    for (int i = 0; i < N_METHODS; i++) {
        schemas[i] = json_loads(methods[i].schema, JSON_REJECT_DUPLICATES, NULL);
        add_properties(methods[i].name, schemas[i]);
        if (methods[i].run == lf_server_export)
            add_kinds(schemas[i]);
    }
}

const lf_method *lf_method_at(int index)
{
    return index < N_METHODS ? &methods[index] : NULL;
}

json_t *lf_method_schema(int index)
{
    pthread_once(&parsed, parse);
    return index < N_METHODS ? schemas[index] : NULL;
}
