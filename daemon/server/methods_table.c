#include "daemon/server/methods.h"

#include <pthread.h>
#include <string.h>

/* JSON Schemas as text: laid out by hand */
/* clang-format off */
#define OBJECT(properties)                                                                         \
    "{\"type\":\"object\",\"additionalProperties\":false,\"properties\":{" properties "}}"
#define OBJECT_WITH(required, properties)                                                          \
    "{\"type\":\"object\",\"additionalProperties\":false,\"required\":[" required                  \
    "],\"properties\":{" properties "}}"
#define STRING "{\"type\":\"string\"}"
#define NUMBER "{\"type\":\"number\"}"
#define BOOLEAN "{\"type\":\"boolean\"}"
#define FRAME "{\"type\":\"integer\",\"minimum\":0,\"maximum\":999999}"
#define ENUM(words) "{\"type\":\"string\",\"enum\":[" words "]}"

#define EXPORT_KEYS                                                                                \
    "\"kind\":" STRING ",\"file\":" STRING                                                         \
    ",\"wait\":" ENUM("\"coarse\",\"complete\",\"converged\"") ",\"detach\":" BOOLEAN              \
    ",\"overwrite\":" BOOLEAN                                                                      \
    ",\"reconstruct\":" ENUM("\"auto\",\"off\",\"on\"")                                            \
    ",\"fds\":{\"type\":\"integer\",\"minimum\":0,\"maximum\":253}"

/* clang-format on */

static const lf_method methods[] = {
    {"hello", "version, protocol and methods", OBJECT(""), lf_method_hello},
    {"status", "what the daemon is doing", OBJECT(""), lf_method_status},
    {"scene.load", "show a scene file or a quilt picture",
     OBJECT_WITH("\"file\"", "\"file\":" STRING), lf_method_scene_load},
    {"scene.get", "the scene that is shown", OBJECT(""), lf_method_scene_get},
    {"scene.patch", "JSON Merge Patch (RFC 7396) on the scene that is shown",
     OBJECT_WITH("\"patch\"", "\"patch\":{\"type\":\"object\",\"additionalProperties\":true}"),
     lf_method_scene_patch},
    {"camera.set", "keys of the scene's camera", OBJECT(""), lf_method_camera_set},
    {"camera.orbit", "move the camera around its target: degrees, and how many times nearer",
     OBJECT("\"yaw\":" NUMBER ",\"pitch\":" NUMBER
            ",\"zoom\":{\"type\":\"number\",\"minimum\":1e-3,\"maximum\":1e3}"),
     lf_method_camera_orbit},
    {"camera.fit", "move the camera to where the scene, or the thing of a name, fills the window",
     OBJECT("\"name\":" STRING ",\"fill\":{\"type\":\"number\",\"minimum\":0.01,\"maximum\":1},"
            "\"steps\":{\"type\":\"number\",\"minimum\":0.01,\"maximum\":10000}"),
     lf_method_camera_fit},
    {"time.set", "show a frame of the scene", OBJECT_WITH("\"frame\"", "\"frame\":" FRAME),
     lf_method_time_set},
    {"time.play", "show one frame of the scene after the other",
     OBJECT_WITH("\"to\"", "\"from\":" FRAME ",\"to\":" FRAME ",\"loop\":" BOOLEAN
                           ",\"rate\":{\"type\":\"number\",\"minimum\":0.01,\"maximum\":1000}"),
     lf_method_time_play},
    {"time.stop", "stay at the frame that is shown", OBJECT(""), lf_method_time_stop},
    {"wait", "answers when the panel shows it, at most timeout seconds later",
     OBJECT("\"generation\":{\"type\":\"integer\",\"minimum\":0},\"for\":" ENUM(
         "\"coarse\",\"complete\",\"converged\"") ",\"timeout\":{\"type\":\"number\","
                                                  "\"minimum\":1e-3,\"maximum\":1e9}"),
     lf_method_wait},
    {"render.set", "how to render", OBJECT("\"paused\":" BOOLEAN), lf_method_render_set},
    {"export", "write a quilt, views, panel picture, print, pitch test chart or state",
     OBJECT_WITH("\"kind\",\"file\"", EXPORT_KEYS), lf_server_export},
    {"job.cancel", "end an export, or the load that status shows",
     OBJECT_WITH("\"job\"", "\"job\":{\"type\":\"integer\"}"), lf_method_job_cancel},
    {"device.list", "devices that could be opened", OBJECT(""), lf_method_device_list},
    {"device.set", "show on another device", OBJECT_WITH("\"spec\"", "\"spec\":" STRING),
     lf_method_device_set},
    {"device.calibration", "the lens calibration of the panel", OBJECT(""),
     lf_method_device_calibration},
    {"button", "do what a button of the panel does",
     OBJECT_WITH("\"name\"", "\"name\":" ENUM("\"square\",\"left\",\"right\",\"circle\"")),
     lf_method_button},
    {"subscribe", "which notifications to send to this client",
     OBJECT_WITH("\"events\"", "\"events\":{\"type\":\"array\",\"items\":" ENUM(
                                   "\"frame\",\"converged\",\"device\",\"scene\",\"export\","
                                   "\"button\"") ",\"maxItems\":16}"),
     lf_method_subscribe},
    {"shutdown", "end the daemon", OBJECT(""), lf_method_shutdown},
};

enum { N_METHODS = sizeof methods / sizeof *methods };

/* Parsed once, never freed: as much a constant as the texts. */
static json_t *schemas[N_METHODS];
static pthread_once_t parsed = PTHREAD_ONCE_INIT;

/* Methods that take the fields of a struct, and the struct's table. */
static const struct {
    const char *method;
    const lf_param *params;
} tables[] = {{"export", lf_print_params},       {"export", lf_panel_params},
              {"export", lf_response_params},    {"export", lf_rgbd_params},
              {"export", lf_photo_params},       {"scene.load", lf_photo_params},
              {"scene.load", lf_picture_params}, {"device.set", lf_response_params},
              {"camera.set", lf_camera_params},  {"render.set", lf_option_params}};

static void add_properties(const char *method, json_t *schema)
{
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        if (strcmp(tables[i].method, method) == 0)
            json_object_update_new(json_object_get(schema, "properties"),
                                   lf_param_schema(tables[i].params));
}

/* export's kinds: those of pictures, and the daemon's own. */
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
