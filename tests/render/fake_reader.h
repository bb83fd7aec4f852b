/* A reader that does what it is told, in place of quiltimport: a test program that is started as
 * such calls lf_fake_reader. */
#ifndef LF_TESTS_FAKE_READER_H
#define LF_TESTS_FAKE_READER_H

#include "tests/render/fake_folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>

#include "base/sandbox/import.h"
#include "base/sandbox/reader.h"
#include "render/scene/punctual.h"
#include "render/scene/scene.h"

/* The last message, and the end. */
static inline _Noreturn void fake_last(uint32_t step, lf_status status, const char *text, int fd)
{
    lf_import_reply reply = {.step = step, .status = status};
    snprintf(reply.text, sizeof reply.text, "%s", text);
    (void)!lf_import_send(LF_IMPORT_SOCKET, &reply, sizeof reply, fd);
    _exit(0);
}

static inline _Noreturn void fake_say(const char *text)
{
    fake_last(LF_IMPORT_FAILED, LF_E_FORMAT, text, -1);
}

/* ----------------------------------------------------------------------------------- parcels -- */

/* A triangle with two materials and all that may lie on it. */
typedef struct fake_mesh {
    double positions[9];
    float normals[9], uvs[12], colours[12], tangents[12];
    uint32_t triangles[3];
    uint16_t choice;
    lf_parcel_material materials[2];
    lf_principled scalars[2];
    lf_parcel_picture pictures[2];
    uint8_t texels[12];
    lf_parcel_light lights[3];
    lf_parcel_camera camera;
    size_t n[LF_PARCEL_TAGS]; /* elements that are told of */
} fake_mesh;

static inline fake_mesh fake_true_mesh(void)
{
    const lf_parcel_texture picture = {
        .picture = 2, .wrap_u = 1, .set = 1, .map = {{1, 0, 0}, {0, -1, 1}}, .scale = 0.5f};
    fake_mesh m = {.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0},
                   .normals = {0, 0, 1, 0, 0, 1, 0, 0, 1},
                   .uvs = {0, 0, 1, 0, 0, 1, -2, 0, 1, 0, 0, 7},
                   .colours = {1, 1, 1, 1, 0, 0.5f, 0, 1, 1, 1, 1, 0},
                   .tangents = {1, 0, 0, 1, 0, 1, 0, -1, 1, 0, 0, 1},
                   .triangles = {0, 1, 2},
                   .choice = 1,
                   .materials = {{.kind = 0},
                                 {.kind = 1,
                                  .cover = LF_COVER_BLEND,
                                  .is_solid = 1,
                                  .texture[LF_SLOT_NORMAL] = picture}},
                   .pictures = {{1, 1}, {1, 2}},
                   .texels = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12},
                   .lights = {{.position = {1, 2, 3}, .intensity = {4, 5, 6}},
                              {.direction = {0, 0.6, 0.8},
                               .intensity = {1, 1, 1},
                               .outer = 0.5,
                               .inner = 0.25,
                               .kind = LF_PUNCTUAL_SPOT},
                              {.direction = {0, 0, -1}, .kind = LF_PUNCTUAL_DISTANT}},
                   .camera = {.position = {1, 2, 3},
                              .look = {0, 0.6, 0.8},
                              .up = {1, 0, 0},
                              .fov_y = 0.5,
                              .number = 7,
                              .name = "lens",
                              .node_name = "eye"},
                   .n = {[LF_PARCEL_POSITIONS] = 9,
                         [LF_PARCEL_NORMALS] = 9,
                         [LF_PARCEL_TRIANGLES] = 3,
                         [LF_PARCEL_CHOICES] = 1,
                         [LF_PARCEL_MATERIALS] = 2,
                         [LF_PARCEL_SCALARS] = 2 * LF_PRINCIPLED_FLOATS,
                         [LF_PARCEL_UVS] = 12,
                         [LF_PARCEL_COLOURS] = 12,
                         [LF_PARCEL_TANGENTS] = 12,
                         [LF_PARCEL_PICTURES] = 2,
                         [LF_PARCEL_TEXELS] = 12}};
    m.scalars[0] = m.scalars[1] = lf_principled_usual();
    m.scalars[0].albedo = lf_v3(1, 0, 0);
    m.scalars[1].albedo = lf_v3(0, 1, 0);
    m.scalars[1].emission = lf_v3(1, 1, 1);
    m.scalars[1].alpha = 0.5f;
    m.scalars[1].sheen = lf_v3(0, 0, 0.25f);
    m.scalars[1].absorption = lf_v3(7, 0, 0);
    return m;
}

static inline void fake_lie_of_mesh(const char *lie, fake_mesh *m)
{
    if (strcmp(lie, "index") == 0 || strcmp(lie, "flat index") == 0)
        m->triangles[1] = 3;
    if (strcmp(lie, "nan") == 0)
        m->positions[4] = (double)NAN;
    if (strcmp(lie, "far") == 0)
        m->positions[4] = 1e300;
    if (strcmp(lie, "normal") == 0)
        memset(m->normals, 0, sizeof m->normals);
    if (strcmp(lie, "flat index") == 0)
        m->n[LF_PARCEL_NORMALS] = 0;
    if (strcmp(lie, "short") == 0)
        m->n[LF_PARCEL_NORMALS] = 6;
    if (strcmp(lie, "absent") == 0)
        m->n[LF_PARCEL_TRIANGLES] = 0;
    if (strcmp(lie, "odd") == 0)
        m->n[LF_PARCEL_POSITIONS] = 8;
}

static inline void fake_lie_of_material(const char *lie, fake_mesh *m)
{
    lf_parcel_material *one = &m->materials[1];
    if (strcmp(lie, "choice") == 0)
        m->choice = 2;
    if (strcmp(lie, "kind") == 0)
        one->kind = 1000;
    if (strcmp(lie, "cover") == 0)
        one->cover = LF_COVERS;
    if (strcmp(lie, "solid") == 0)
        one->is_solid = 2;
    if (strcmp(lie, "glow") == 0)
        one->emits_by_colours = 2;
    if (strcmp(lie, "skin") == 0)
        m->scalars[1].subsurface = 0.5f;
    if (strcmp(lie, "milk") == 0)
        m->scalars[1].scattering.y = 0.5f;
    if (strcmp(lie, "first") == 0)
        m->scalars[1].priority = 1.0f;
    if (strcmp(lie, "scalars") == 0)
        m->n[LF_PARCEL_SCALARS]--;
    if (strcmp(lie, "name") == 0)
        memset(one->name, 'x', sizeof one->name);
}

/* "low albedo", "high albedo", "nan albedo": the last float of a row, as little outside of its
 * range as floats are; of an angle the first of two. */
static inline void fake_lie_of_scalar(const char *lie, fake_mesh *m)
{
    for (const lf_param *const *row = lf_principled_rows; *row; row++) {
        const char *name = strchr(lie, ' ');
        int n;
        float *field = lf_principled_at(&m->scalars[1], *row, &n),
              *last = &field[(*row)->type == LF_PARAM_ANGLE ? 0 : n - 1];
        if (!name || strcmp(name + 1, (*row)->name) != 0)
            continue;
        if (strncmp(lie, "low ", 4) == 0)
            *last =
                (*row)->type == LF_PARAM_ANGLE ? 0.99f : nextafterf((float)(*row)->low, -INFINITY);
        if (strncmp(lie, "high ", 5) == 0)
            *last =
                (*row)->type == LF_PARAM_ANGLE ? 1.01f : nextafterf((float)(*row)->high, INFINITY);
        if (strncmp(lie, "nan ", 4) == 0)
            *last = (float)NAN;
    }
}

static const char *const fake_lies_of_looks[] = {
    "name",         "uv nan",        "uv far",       "uv short",     "uv absent",   "uv one",
    "colour",       "colour nan",    "colour short", "tangent long", "tangent nan", "tangent up",
    "tangent side", "tangent short", "picture",      "wrap u",       "wrap v",      "set",
    "set wide",     "nearest",       "map",          "scale",        "size none",   "size wide",
    "size more",    "size less",     "texels",       "sizes"};

static inline void fake_lie_of_looks(const char *lie, fake_mesh *m)
{
    lf_parcel_texture *texture = &m->materials[1].texture[LF_SLOT_NORMAL];
    if (strcmp(lie, "uv nan") == 0)
        m->uvs[11] = (float)NAN;
    if (strcmp(lie, "uv far") == 0)
        m->uvs[3] = -1e7f;
    if (strcmp(lie, "uv short") == 0)
        m->n[LF_PARCEL_UVS] = 11;
    if (strcmp(lie, "uv absent") == 0)
        m->n[LF_PARCEL_UVS] = 0;
    if (strcmp(lie, "uv one") == 0) /* the texture wants the second set */
        m->n[LF_PARCEL_UVS] = 6;
    if (strcmp(lie, "colour") == 0)
        m->colours[4] = 1.25f;
    if (strcmp(lie, "colour nan") == 0)
        m->colours[11] = (float)NAN;
    if (strcmp(lie, "colour short") == 0)
        m->n[LF_PARCEL_COLOURS] = 9;
    if (strcmp(lie, "tangent long") == 0)
        m->tangents[0] = 1.5f;
    if (strcmp(lie, "tangent nan") == 0)
        m->tangents[5] = (float)NAN;
    if (strcmp(lie, "tangent up") == 0)
        memcpy(m->tangents, m->normals, 3 * sizeof(float));
    if (strcmp(lie, "tangent side") == 0)
        m->tangents[7] = 0.5f;
    if (strcmp(lie, "tangent short") == 0)
        m->n[LF_PARCEL_TANGENTS] = 8;
    if (strcmp(lie, "picture") == 0)
        texture->picture = 3;
    if (strcmp(lie, "wrap u") == 0)
        texture->wrap_u = LF_WRAPS;
    if (strcmp(lie, "wrap v") == 0)
        texture->wrap_v = 256;
    if (strcmp(lie, "set") == 0)
        texture->set = 2;
    if (strcmp(lie, "set wide") == 0)
        texture->set = 256;
    if (strcmp(lie, "nearest") == 0)
        texture->nearest = 2;
    if (strcmp(lie, "map") == 0)
        texture->map[1][2] = (float)INFINITY;
    if (strcmp(lie, "scale") == 0)
        texture->scale = (float)NAN;
    if (strcmp(lie, "size none") == 0)
        m->pictures[0].width = 0;
    if (strcmp(lie, "size wide") == 0)
        m->pictures[1].height = 65537;
    if (strcmp(lie, "size more") == 0)
        m->pictures[1].width = 2;
    if (strcmp(lie, "size less") == 0)
        m->pictures[1].height = 1;
    if (strcmp(lie, "texels") == 0)
        m->n[LF_PARCEL_TEXELS] = 0;
    if (strcmp(lie, "sizes") == 0)
        m->n[LF_PARCEL_PICTURES] = 0;
}

static const char *const fake_lies_of_lights[] = {
    "light kind", "light nan",  "light far",  "light dark",   "light bright", "light long",
    "light lost", "light wide", "light shut", "light inside", "light below",  "light many"};

static inline void fake_lie_of_lights(const char *lie, fake_mesh *m)
{
    lf_parcel_light *point = &m->lights[0], *spot = &m->lights[1];
    if (strcmp(lie, "light kind") == 0)
        point->kind = LF_PUNCTUAL_KINDS + UINT64_C(0x100000000);
    if (strcmp(lie, "light nan") == 0)
        point->position[2] = (double)NAN;
    if (strcmp(lie, "light far") == 0)
        point->position[0] = -2e9;
    if (strcmp(lie, "light dark") == 0)
        point->intensity[1] = -1;
    if (strcmp(lie, "light bright") == 0)
        point->intensity[1] = 2e9;
    if (strcmp(lie, "light long") == 0)
        spot->direction[0] = 1;
    if (strcmp(lie, "light lost") == 0)
        m->lights[2].direction[2] = 0;
    if (strcmp(lie, "light wide") == 0)
        spot->outer = 1.6;
    if (strcmp(lie, "light shut") == 0)
        spot->outer = spot->inner = 0;
    if (strcmp(lie, "light inside") == 0)
        spot->inner = 0.75;
    if (strcmp(lie, "light below") == 0)
        spot->inner = -0.25;
}

static const char *const fake_lies_of_cameras[] = {
    "camera nan",  "camera look",   "camera up",     "camera across",
    "camera wide", "camera narrow", "camera number", "camera parallel",
    "camera name", "camera node",   "camera many"};

static inline void fake_lie_of_cameras(const char *lie, lf_parcel_camera *camera)
{
    if (strcmp(lie, "camera nan") == 0)
        camera->position[1] = (double)NAN;
    if (strcmp(lie, "camera look") == 0)
        camera->look[2] = 1;
    if (strcmp(lie, "camera up") == 0)
        camera->up[0] = (double)NAN;
    if (strcmp(lie, "camera across") == 0)
        memcpy(camera->up, (double[3]){0, 1, 0}, sizeof camera->up);
    if (strcmp(lie, "camera wide") == 0)
        camera->fov_y = 3;
    if (strcmp(lie, "camera narrow") == 0)
        camera->fov_y = 0;
    if (strcmp(lie, "camera number") == 0)
        camera->number = UINT32_MAX;
    if (strcmp(lie, "camera parallel") == 0)
        camera->parallel = 2;
    if (strcmp(lie, "camera name") == 0)
        memset(camera->name, 'a', sizeof camera->name);
    if (strcmp(lie, "camera node") == 0)
        memset(camera->node_name, 'a', sizeof camera->node_name);
}

/* What begins with "part", but for "part none". */
static const char *const fake_lies_of_parts[] = {
    "part nan",  "part flat",   "part far",  "part other", "part short",
    "part many", "part beside", "part lost", "part thin",  "part wide"};

/* One part, all of the mesh, in one place, where a lie is about parts. */
static inline bool fake_put_parts(const char *lie, const fake_mesh *m, lf_parcel_writer *writer)
{
    double place[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    uint32_t part[4] = {0, (uint32_t)m->n[LF_PARCEL_TRIANGLES] / 3, 0,
                        (uint32_t)m->n[LF_PARCEL_POSITIONS] / 3},
             part_of[2] = {0};
    if (strncmp(lie, "part", 4) != 0)
        return true;
    if (strcmp(lie, "part nan") == 0)
        place[3] = (double)NAN;
    if (strcmp(lie, "part flat") == 0)
        place[5] = 0;
    if (strcmp(lie, "part thin") == 0)
        place[5] = 1e-20;
    if (strcmp(lie, "part far") == 0)
        place[11] = 2e9;
    if (strcmp(lie, "part wide") == 0)
        place[0] = place[3] = 1e9;
    if (strcmp(lie, "part other") == 0)
        part_of[0] = 1;
    if (strcmp(lie, "part short") == 0)
        part[1]--;
    if (strcmp(lie, "part many") == 0)
        part[1] = UINT32_MAX;
    if (strcmp(lie, "part beside") == 0)
        part[2] = 1;
    return lf_parcel_put(writer, LF_PARCEL_INSTANCES, place, 12, NULL) == LF_OK &&
           lf_parcel_put(writer, LF_PARCEL_PARTS, part, 4, NULL) == LF_OK &&
           lf_parcel_put(writer, LF_PARCEL_PART_OF, part_of, strcmp(lie, "part lost") ? 1 : 2,
                         NULL) == LF_OK;
}

/* lie: what is wrong with it, "" = nothing; "plain": nothing that materials look at,
 * but for the section whose number is behind it. */
static inline int fake_parcel(const char *lie)
{
    fake_mesh m = fake_true_mesh();
    const struct {
        lf_parcel_tag tag;
        const void *data;
    } sections[] = {{LF_PARCEL_POSITIONS, m.positions},
                    {LF_PARCEL_NORMALS, m.normals},
                    {LF_PARCEL_TRIANGLES, m.triangles},
                    {LF_PARCEL_CHOICES, &m.choice},
                    {LF_PARCEL_UVS, m.uvs},
                    {LF_PARCEL_COLOURS, m.colours},
                    {LF_PARCEL_TANGENTS, m.tangents},
                    {LF_PARCEL_PICTURES, m.pictures},
                    {LF_PARCEL_TEXELS, m.texels}};
    bool many = strcmp(lie, "light many") == 0, eyes = strcmp(lie, "camera many") == 0;
    lf_parcel_writer writer;
    int fd = -1;
    fake_lie_of_mesh(lie, &m);
    fake_lie_of_material(lie, &m);
    fake_lie_of_scalar(lie, &m);
    fake_lie_of_looks(lie, &m);
    fake_lie_of_lights(lie, &m);
    fake_lie_of_cameras(lie, &m.camera);
    bool plain = strncmp(lie, "plain", 5) == 0;
    for (lf_parcel_tag tag = LF_PARCEL_CHOICES; tag <= LF_PARCEL_TEXELS && plain; tag++)
        m.n[tag] = lie[5] == '\0' || atoi(lie + 5) != (int)tag ? 0 : m.n[tag];
    if (lf_parcel_begin(&writer, NULL) != LF_OK)
        _exit(3);
    for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
        if (lf_parcel_put(&writer, sections[i].tag, sections[i].data, m.n[sections[i].tag], NULL) !=
            LF_OK)
            _exit(3);
    for (int i = 0; i < (many ? 100 : 1); i++)
        if (lf_parcel_append(&writer, LF_PARCEL_LIGHTS, m.lights, 3, NULL) != LF_OK)
            _exit(3);
    for (int i = 0; i < (eyes ? 300 : 1); i++)
        if (lf_parcel_append(&writer, LF_PARCEL_CAMERAS, &m.camera, 1, NULL) != LF_OK)
            _exit(3);
    if (!fake_put_parts(lie, &m, &writer))
        _exit(3);
    if ((m.n[LF_PARCEL_MATERIALS] > 0 &&
         (lf_parcel_append(&writer, LF_PARCEL_MATERIALS, m.materials, 1, NULL) != LF_OK ||
          lf_parcel_append(&writer, LF_PARCEL_MATERIALS, m.materials + 1, 1, NULL) != LF_OK)) ||
        lf_parcel_put(&writer, LF_PARCEL_SCALARS, m.scalars, m.n[LF_PARCEL_SCALARS], NULL) !=
            LF_OK ||
        lf_parcel_put(&writer, LF_PARCEL_WARNINGS, "one\ntwo\n", 8, NULL) != LF_OK ||
        lf_parcel_seal(&writer, &fd, NULL) != LF_OK)
        _exit(3);
    return fd;
}

/* Two bricks of a grid of 3 x 1 x 1; lie as above. */
static inline int fake_grid(const char *lie)
{
    int64_t size[3] = {20, 4, 4};
    double map[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    uint32_t places[2] = {0, 2};
    float values[2 * LF_BRICK_STRIDE] = {[5] = 1.0f, [LF_BRICK_STRIDE + 5] = 2.0f};
    bool is_short = strcmp(lie, "short") == 0, absent = strcmp(lie, "absent") == 0;
    lf_parcel_writer writer;
    int fd = -1;
    if (strcmp(lie, "beyond") == 0)
        places[1] = 3;
    if (strcmp(lie, "far") == 0)
        places[1] = UINT32_MAX;
    if (strcmp(lie, "twice") == 0)
        places[1] = 0;
    if (strcmp(lie, "back") == 0)
        memcpy(places, (uint32_t[2]){2, 0}, sizeof places);
    if (strcmp(lie, "nan") == 0)
        values[7] = (float)NAN;
    if (strcmp(lie, "negative") == 0)
        values[7] = -1.0f;
    if (strcmp(lie, "infinite") == 0)
        values[7] = (float)INFINITY;
    if (strcmp(lie, "nothing") == 0)
        size[1] = 0;
    if (strcmp(lie, "wide") == 0)
        size[1] = (int64_t)1 << 32;
    if (strcmp(lie, "less") == 0)
        size[1] = -4;
    if (strcmp(lie, "map") == 0)
        map[3] = (double)NAN;
    if (lf_parcel_begin(&writer, NULL) != LF_OK ||
        lf_parcel_put(&writer, LF_PARCEL_SIZE, size, absent ? 0 : 3, NULL) != LF_OK ||
        lf_parcel_put(&writer, LF_PARCEL_MAP, map, 12, NULL) != LF_OK ||
        lf_parcel_put(&writer, LF_PARCEL_BRICKS, places, 2, NULL) != LF_OK ||
        lf_parcel_put(&writer, LF_PARCEL_VALUES, values, (size_t)(2 * LF_BRICK_STRIDE - is_short),
                      NULL) != LF_OK ||
        lf_parcel_put(&writer, LF_PARCEL_OTHERS, "no end", 6, NULL) != LF_OK ||
        lf_parcel_seal(&writer, &fd, NULL) != LF_OK)
        _exit(3);
    return fd;
}

/* A picture of 2 x 3 pixels; lie as above. */
static inline int fake_picture(const char *lie)
{
    int64_t shape[2] = {2, 3};
    float floats[18] = {[17] = 4.0f};
    uint8_t bytes[18] = {[17] = 9};
    bool both = strcmp(lie, "both") == 0, is_short = strcmp(lie, "short") == 0,
         shapeless = strcmp(lie, "shapeless") == 0, none = strcmp(lie, "none") == 0,
         is_8bit = strcmp(lie, "bytes") == 0;
    lf_parcel_writer writer;
    int fd = -1;
    if (strcmp(lie, "nan") == 0)
        floats[7] = (float)NAN;
    if (strcmp(lie, "infinite") == 0)
        floats[7] = -(float)INFINITY;
    if (strcmp(lie, "wide") == 0)
        memcpy(shape, (int64_t[2]){(int64_t)1 << 32, (int64_t)1 << 32}, sizeof shape);
    if (strcmp(lie, "less") == 0)
        memcpy(shape, (int64_t[2]){-2, -3}, sizeof shape);
    if (strcmp(lie, "other") == 0)
        shape[1] = 4;
    if (lf_parcel_begin(&writer, NULL) != LF_OK ||
        lf_parcel_put(&writer, LF_PARCEL_SHAPE, shape, shapeless ? 0 : 2, NULL) != LF_OK ||
        lf_parcel_put(&writer, LF_PARCEL_PIXELS8, bytes, is_8bit || both ? 18 : 0, NULL) != LF_OK ||
        lf_parcel_put(&writer, LF_PARCEL_PIXELS32, floats,
                      is_8bit || none ? 0
                      : is_short      ? 17
                                      : 18,
                      NULL) != LF_OK ||
        lf_parcel_seal(&writer, &fd, NULL) != LF_OK)
        _exit(3);
    return fd;
}

/* A copy of a parcel, changed by edit, cut to a size, with these seals. */
static inline int fake_copy(int from, void (*edit)(unsigned char *data, size_t size, void *context),
                            void *context, size_t cut, int seals)
{
    int to = memfd_create("copy", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    size_t size = (size_t)lseek(from, 0, SEEK_END);
    unsigned char *data = malloc(size);
    if (to < 0 || !data || pread(from, data, size, 0) != (ssize_t)size)
        _exit(3);
    if (edit)
        edit(data, size, context);
    size = cut < size ? cut : size;
    if (pwrite(to, data, size, 0) != (ssize_t)size || fcntl(to, F_ADD_SEALS, seals) != 0)
        _exit(3);
    free(data);
    close(from);
    return to;
}

/* Eight bytes or words somewhere behind the magic number. */
static inline void fake_random_edit(unsigned char *data, size_t size, void *context)
{
    uint64_t state = *(const uint64_t *)context * UINT64_C(0x9e3779b97f4a7c15) + 1;
    for (int i = 0; i < 8; i++) {
        state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        size_t at = 8 + (size_t)(state >> 33) % (size - 16);
        if (state & 1)
            data[at] = (unsigned char)(state >> 20);
        else
            memcpy(data + at / 4 * 4, &(uint32_t){(uint32_t)(state >> 13) & 0xff}, 4);
    }
}

enum { FAKE_SEALS = F_SEAL_SEAL | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE };

static inline int fake_random_parcel(uint64_t seed)
{
    return fake_copy(fake_parcel(""), fake_random_edit, &seed, SIZE_MAX, FAKE_SEALS);
}

/* ------------------------------------------------------------------------------------ rights -- */

static inline _Noreturn void fake_list_descriptors(void)
{
    char text[256] = "";
    DIR *folder = opendir("/proc/self/fd");
    for (int fd = 0; folder && fd < 64; fd++)
        if (fd != dirfd(folder) && fcntl(fd, F_GETFD) != -1)
            snprintf(text + strlen(text), sizeof text - strlen(text), "%d ", fd);
    fake_say(text);
}

static inline void *fake_thread(void *context)
{
    *(int *)context = 1;
    return NULL;
}

static inline _Noreturn void fake_confined(const char *what)
{
    int ran = 0, fd = -1, own = memfd_create("own", 0);
    pthread_t thread;
    lf_landlock landlock;
    if (lf_confine((uint64_t)256 << 20, 60, &landlock, NULL) != LF_OK)
        fake_say("not confined");
    errno = 0;
    if (strcmp(what, "socket") == 0)
        (void)!socket(AF_INET, SOCK_STREAM, 0);
    if (strcmp(what, "exec") == 0)
        execl("/bin/true", "true", (char *)NULL);
    if (strcmp(what, "fork") == 0)
        (void)syscall(SYS_clone, SIGCHLD, NULL, NULL, NULL, 0);
    if (strcmp(what, "kill") == 0)
        (void)kill(getppid(), 0);
    if (strcmp(what, "tgkill") == 0)
        (void)syscall(SYS_tgkill, getppid(), getppid(), SIGCONT);
    if (strcmp(what, "owner") == 0)
        (void)fcntl(LF_IMPORT_SOCKET, F_SETOWN, getppid());
    if (strcmp(what, "memfd") == 0)
        fd = memfd_create("more", 0);
    if (strcmp(what, "code") == 0)
        fake_say(mmap(NULL, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS,
                      -1, 0) == MAP_FAILED
                     ? "no code"
                     : "code");
    if (strcmp(what, "environment") == 0)
        fake_say(getenv("LF_SECRET") ? "told" : "no word");
    if (strcmp(what, "unlink") == 0)
        (void)unlink("/nowhere/at/all");
    if (strcmp(what, "open") == 0)
        fd = open("/etc/passwd", O_RDONLY);
    if (strcmp(what, "create") == 0)
        fd = open("created", O_WRONLY | O_CREAT, 0600);
    if (strcmp(what, "memory") == 0)
        fake_say(malloc((size_t)512 << 20) ? "memory" : "no memory");
    if (strcmp(what, "thread") == 0 && pthread_create(&thread, NULL, fake_thread, &ran) == 0)
        pthread_join(thread, NULL);
    if (ran)
        fake_say("a thread ran");
    if (strcmp(what, "file") == 0)
        fd = ftruncate(own, (off_t)512 << 20) == 0 ? own : -1;
    fake_say(fd >= 0 ? "it was let" : strerror(errno));
}

/* ------------------------------------------------------------------------------ what it does -- */

static inline void fake_misbehave(const char *mode)
{
    if (strcmp(mode, "abort") == 0)
        abort();
    if (strcmp(mode, "segv") == 0)
        (void)(signal(SIGSEGV, SIG_DFL), raise(SIGSEGV));
    if (strcmp(mode, "exit") == 0)
        _exit(0);
    if (strcmp(mode, "garbage") == 0 && write(LF_IMPORT_SOCKET, "hello", 5) == 5)
        pause();
    if (strcmp(mode, "nothing") == 0)
        fake_last(LF_IMPORT_DONE, LF_OK, "", -1);
    if (strcmp(mode, "unsealed") == 0)
        fake_last(LF_IMPORT_DONE, LF_OK, "", memfd_create("open", 0));
    if (strcmp(mode, "status") == 0)
        fake_last(LF_IMPORT_FAILED, (lf_status)77, "", -1);
    if (strcmp(mode, "words") == 0)
        fake_last(LF_IMPORT_FAILED, LF_E_NOMEM, "too much \x1b[2J of it", -1);
    while (strcmp(mode, "sleep") == 0)
        pause();
    for (volatile int i = 0; strcmp(mode, "spin") == 0;)
        i++;
}

/* More descriptors than were agreed on. */
static inline _Noreturn void fake_send_two(void)
{
    lf_import_reply reply = {.step = LF_IMPORT_DONE};
    union {
        struct cmsghdr header;
        char bytes[CMSG_SPACE(2 * sizeof(int))];
    } room = {.bytes = {0}};
    int fds[2] = {fake_parcel(""), fake_parcel("")};
    struct iovec data = {&reply, sizeof reply};
    struct msghdr message = {.msg_iov = &data,
                             .msg_iovlen = 1,
                             .msg_control = room.bytes,
                             .msg_controllen = sizeof room.bytes};
    struct cmsghdr *with = CMSG_FIRSTHDR(&message);
    with->cmsg_level = SOL_SOCKET;
    with->cmsg_type = SCM_RIGHTS;
    with->cmsg_len = CMSG_LEN(sizeof fds);
    memcpy(CMSG_DATA(with), fds, sizeof fds);
    (void)!sendmsg(LF_IMPORT_SOCKET, &message, 0);
    pause();
    _exit(0);
}

/* Asks and asks, and never listens. */
static inline _Noreturn void fake_ask_only(void)
{
    lf_import_reply ask = {.step = LF_IMPORT_OPEN, .text = "/etc/passwd"};
    for (;;)
        (void)!send(LF_IMPORT_SOCKET, &ask, sizeof ask, 0);
}

/* For a file beside the mesh's, or anywhere; once or for ever. */
static inline _Noreturn void fake_ask(const char *path, const char *name, uint32_t step,
                                      bool for_ever)
{
    int beside = name[0] == '/' ? 0 : (int)(strrchr(path, '/') + 1 - path);
    do {
        lf_import_reply ask = {.step = step};
        lf_import_answer answer;
        int fd;
        snprintf(ask.text, sizeof ask.text, "%.*s%s", beside, path, name);
        if (lf_import_send(LF_IMPORT_SOCKET, &ask, sizeof ask, -1) != LF_OK ||
            lf_import_receive(LF_IMPORT_SOCKET, &answer, sizeof answer, &fd) != LF_OK)
            _exit(3);
        if (fd >= 0)
            close(fd);
    } while (for_ever);
    fake_last(LF_IMPORT_DONE, LF_OK, "", fake_parcel(""));
}

static inline int lf_fake_reader(void)
{
    char told[128] = "";
    lf_import_request request;
    int fd;
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (lf_import_receive(LF_IMPORT_SOCKET, &request, sizeof request, &fd) != LF_OK)
        return 3;
    fake_note_start(&request);
    fake_note_pid(&request);
    if (!fake_mode(&request, told))
        return 3;
    const char *mode = fake_nap(told);
    fake_misbehave(mode);
    if (strcmp(mode, "descriptors") == 0)
        fake_list_descriptors();
    if (strncmp(mode, "confined-", 9) == 0)
        fake_confined(mode + 9);
    if (strncmp(mode, "ask", 3) == 0 || strncmp(mode, "beg", 3) == 0)
        fake_ask(request.path, mode + 3, LF_IMPORT_OPEN, mode[0] == 'b');
    if (strncmp(mode, "try", 3) == 0)
        fake_ask(request.path, mode + 3, LF_IMPORT_TRY, false);
    if (strcmp(mode, "two") == 0)
        fake_send_two();
    if (strcmp(mode, "deaf") == 0)
        fake_ask_only();
    if (strncmp(mode, "grid-", 5) == 0)
        fake_last(LF_IMPORT_DONE, LF_OK, "", fake_grid(mode + 5));
    if (strncmp(mode, "picture-", 8) == 0)
        fake_last(LF_IMPORT_DONE, LF_OK, "", fake_picture(mode + 8));
    if (strncmp(mode, "random", 6) == 0)
        fake_last(LF_IMPORT_DONE, LF_OK, "", fake_random_parcel((uint64_t)atoi(mode + 6)));
    fake_last(LF_IMPORT_DONE, LF_OK, "", fake_parcel(strcmp(mode, "parcel") == 0 ? "" : mode));
}

#endif
