/* What eyes see of a plate, put together from its hogels, against boxes that are traced by their
 * equations. No code is shared with the renderer or with the plate; the raw file is read as the
 * reference page says. */
#include "tests/daemon/quiltrender.h"

/* ------------------------------------------------------------------------------------- world -- */

/* Boxes that emit light, with sides along the axes, seen against black. Colours are 0 or 1. */
typedef struct box {
    double middle[3], half[3];
    int colour[3];
} box;

/* The plate is z = 0 and eyes are at z > 0: one box in front of it, the others behind. */
static const box boxes[] = {
    {{0.35, 0.25, 0.7}, {0.16, 0.12, 0.05}, {0, 1, 0}},
    {{-0.5, -0.3, -0.6}, {0.3, 0.22, 0.05}, {1, 0, 0}},
    {{0.4, -0.45, -1.5}, {0.5, 0.3, 0.1}, {0, 0, 1}},
    {{-0.2, 0.6, -2.2}, {0.55, 0.35, 0.1}, {1, 1, 0}},
};
enum { N_BOXES = sizeof boxes / sizeof *boxes, FRONT = 1 };

/* The colour that comes along a line from an eye or camera, as bits of red, green and blue, with
 * 8 * (1 + the box). */
static int seen(const double from[3], const double towards[3], int first_box)
{
    double nearest = INFINITY;
    int found = 0;
    for (int i = first_box; i < N_BOXES; i++) {
        double enter = 0, leave = INFINITY;
        for (int a = 0; a < 3; a++) {
            const double d = towards[a] - from[a],
                         low = boxes[i].middle[a] - boxes[i].half[a] - from[a],
                         high = boxes[i].middle[a] + boxes[i].half[a] - from[a];
            if (fabs(d) < 1e-12) {
                if (low > 0 || high < 0)
                    leave = -1;
                continue;
            }
            enter = fmax(enter, fmin(low / d, high / d));
            leave = fmin(leave, fmax(low / d, high / d));
        }
        if (enter <= leave && enter < nearest) {
            const int *c = boxes[i].colour;
            nearest = enter;
            found = 8 * (1 + i) + c[0] + 2 * c[1] + 4 * c[2];
        }
    }
    return found;
}

/* Writes the scene with this camera. */
static const char *scene_of(const qr_files *f, const char *name, const char *camera)
{
    char text[4096];
    size_t n = (size_t)snprintf(text, sizeof text,
                                "{\"quiltd\": 1, \"camera\": {%s}, "
                                "\"materials\": {",
                                camera);
    for (int i = 0; i < N_BOXES; i++)
        n += (size_t)snprintf(text + n, sizeof text - n,
                              "%s\"m%d\": {\"type\": \"diffuse\", \"albedo\": 0, \"emission\": "
                              "[%d, %d, %d]}",
                              i ? ", " : "", i, boxes[i].colour[0], boxes[i].colour[1],
                              boxes[i].colour[2]);
    n += (size_t)snprintf(text + n, sizeof text - n, "}, \"meshes\": {");
    for (int i = 0; i < N_BOXES; i++)
        n += (size_t)snprintf(
            text + n, sizeof text - n,
            "%s\"b%d\": {\"shape\": \"cube\", \"material\": \"m%d\", \"transform\": {\"scale\": "
            "[%g, %g, %g], \"translate\": [%g, %g, %g]}}",
            i ? ", " : "", i, i, boxes[i].half[0], boxes[i].half[1], boxes[i].half[2],
            boxes[i].middle[0], boxes[i].middle[1], boxes[i].middle[2]);
    snprintf(text + n, sizeof text - n, "}}\n");
    return lf_test_write(f->folder, name, text);
}

/* --------------------------------------------------------------------------------- raw files -- */

typedef struct field {
    int n[4]; /* Hy, Hx, V, U */
    char *bytes;
} field;

static field read_field(const char *folder)
{
    field f = {0};
    size_t size = 0;
    lf_error err = {0};
    lf_assert_ok(
        lf_file_read(lf_test_path(folder, "plate.raw"), NULL, 1 << 26, &f.bytes, &size, &err),
        &err);
    for (int i = 0; i < 4; i++)
        for (int b = 3; b >= 0; b--)
            f.n[i] = f.n[i] << 8 | (uint8_t)f.bytes[16 + 4 * i + b];
    assert_int_equal(size, 64 + 3 * f.n[0] * f.n[1] * f.n[2] * f.n[3]);
    return f;
}

static const uint8_t *sample(const field *f, int hy, int hx, int v, int u)
{
    return (const uint8_t *)f->bytes + 64 + 3 * (((hy * f->n[1] + hx) * f->n[2] + v) * f->n[3] + u);
}

/* --------------------------------------------------------------------------- eyes and plates -- */

/* A plate of this many scene units. Directions are eyes at this distance, equally spaced; or, for
 * cells, slopes (distance 1, spacing of slopes), the same for all cells. Aperture: the part of a
 * spacing over which a direction, or a cell, is averaged. */
typedef struct plate {
    double width, height;
    double distance, spacing[2], aperture;
    double lift; /* height of the middle of the plate … */
    double rise; /* … and of the only row of eyes */
    bool of_cells;
} plate;

/* How an eye reads the plate; controls read it wrongly. */
typedef struct reading {
    bool u, v, hx, hy, swapped;
} reading;

static int nearest(double at, int n)
{
    const int i = (int)lround(at);
    return i < 0 ? 0 : i >= n ? n - 1 : i;
}

/* The middle of a cell. */
static void cell_middle(const plate *p, const field *f, int hy, int hx, double out[3])
{
    out[0] = ((hx + 0.5) / f->n[1] - 0.5) * p->width;
    out[1] = (0.5 - (hy + 0.5) / f->n[0]) * p->height + p->lift;
    out[2] = 0;
}

/* The direction, as a number of spacings from the middle, from a cell to an eye. False: beyond the
 * plate's directions. */
static bool direction_to(const plate *p, const field *f, const double cell[3], const double eye[3],
                         int out[2])
{
    bool there = true;
    for (int a = 0; a < 2; a++) {
        const int n = a == 0 ? f->n[3] : f->n[2];
        double at = cell[a] + (eye[a] - cell[a]) * p->distance / eye[2];
        if (p->of_cells)
            at = (eye[a] - cell[a]) / eye[2];
        if (n == 1)
            at = 0;
        at = (a == 0 ? at : -at) / (n == 1 ? 1 : p->spacing[a]) + 0.5 * (n - 1);
        there = there && at > -0.5 && at < n - 0.5;
        out[a] = nearest(at, n);
    }
    return there;
}

/* The colour of all lines of a cell and direction, and of the line to the eye; -1: it is not the
 * same for all. A box is wider than the distance between the lines that are tried, so it cannot lie
 * between them. */
static int colour_of(const plate *p, const field *f, const double cell[3], const double eye[3],
                     const int direction[2], int first_box)
{
    enum { STEPS = 3 };
    const double pitch[2] = {p->width / f->n[1], p->height / f->n[0]};
    int colour = eye ? seen(eye, cell, first_box) : -1;
    for (int k = 0; k < STEPS * STEPS * STEPS * STEPS; k++) {
        const int step[4] = {k % STEPS, k / STEPS % STEPS, k / STEPS / STEPS % STEPS,
                             k / STEPS / STEPS / STEPS};
        double from[3] = {0, 0, 1}, to[3] = {0, 0, 0};
        for (int a = 0; a < 2; a++) {
            const int n = a == 0 ? f->n[3] : f->n[2];
            /* a little beyond the cell and the direction */
            const double in_cell = 1.2 * (step[a] / (STEPS - 1.0) - 0.5),
                         in_direction = 1.2 * (step[2 + a] / (STEPS - 1.0) - 0.5);
            const double middle = (direction[a] - 0.5 * (n - 1)) * (a == 0 ? 1 : -1);
            to[a] = cell[a] + pitch[a] * in_cell * (p->of_cells ? p->aperture : 1);
            from[a] = p->spacing[a] * (middle + in_direction * (p->of_cells ? 1 : p->aperture));
            from[a] += p->of_cells ? to[a] : a == 1 ? p->rise : 0;
        }
        from[2] = p->of_cells ? 1 : p->distance;
        const int here = seen(from, to, first_box);
        if (k == 0 && colour < 0)
            colour = here;
        if (here != colour)
            return -1;
    }
    return colour;
}

/* Pixels of an eye's picture that have one colour: how many of each box (the last: background) are
 * right, and how many are wrong. */
typedef struct outcome {
    int right[N_BOXES + 1], wrong;
} outcome;

static outcome look(const plate *p, const field *f, const double eye[3], reading r)
{
    outcome o = {0};
    for (int hy = 0; hy < f->n[0]; hy++)
        for (int hx = 0; hx < f->n[1]; hx++) {
            double cell[3];
            int to[2], at[2];
            cell_middle(p, f, hy, hx, cell);
            if (!direction_to(p, f, cell, eye, to))
                continue;
            const int colour = colour_of(p, f, cell, eye, to, p->of_cells ? FRONT : 0);
            if (colour < 0)
                continue;
            at[0] = r.u ? f->n[3] - 1 - to[0] : to[0];
            at[1] = r.v ? f->n[2] - 1 - to[1] : to[1];
            if (r.swapped) {
                const int other = at[0];
                at[0] = at[1] * f->n[3] / f->n[2];
                at[1] = other * f->n[2] / f->n[3];
            }
            const uint8_t *rgb =
                sample(f, r.hy ? f->n[0] - 1 - hy : hy, r.hx ? f->n[1] - 1 - hx : hx, at[1], at[0]);
            bool same = true;
            for (int c = 0; c < 3; c++)
                same = same && rgb[c] == (colour >> c & 1 ? 255 : 0);
            if (same)
                o.right[colour ? colour / 8 - 1 : N_BOXES]++;
            else
                o.wrong++;
        }
    return o;
}

/* The eye sees every box, and no pixel is wrong. */
static void assert_sees(const plate *p, const field *f, const double eye[3])
{
    const outcome o = look(p, f, eye, (reading){0});
    if (o.wrong > 0)
        fail_msg("%d pixels are wrong from %g, %g, %g", o.wrong, eye[0], eye[1], eye[2]);
    for (int i = p->of_cells ? FRONT : 0; i <= N_BOXES; i++)
        if (o.right[i] < 6)
            fail_msg("%d pixels of box %d from %g, %g, %g", o.right[i], i, eye[0], eye[1], eye[2]);
}

static const double eyes[][3] = {{0, 0, 5}, {0.7, 0.3, 4}, {-0.9, -0.4, 7}, {0.5, -0.6, 5}};
enum { N_EYES = sizeof eyes / sizeof *eyes };

/* Each wrong reading is noticed by some eye. */
static void assert_controls_fail(const plate *p, const field *f)
{
    static const reading wrong[] = {{.u = true, .v = true}, {.u = true},  {.v = true},
                                    {.hx = true},           {.hy = true}, {.swapped = true}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        int n = 0;
        for (int k = 0; k < N_EYES; k++)
            n += look(p, f, eyes[k], wrong[i]).wrong;
        if (n < 10)
            fail_msg("wrong reading %zu: only %d pixels differ", i, n);
    }
}

/* ------------------------------------------------------------------------------------- tests -- */

#define QUICK " --hologram raw --spp 2 --denoise off --seed 3 "

static void eyes_see_what_eyes_rendered(void **state)
{
    const qr_files *f = *state;
    for (int blurs = 0; blurs < 2; blurs++) {
        char camera[512], folder[PATH_MAX];
        snprintf(camera, sizeof camera,
                 "\"position\": [0, 0, 5], \"fov_y\": 22, \"aspect\": 1.25, \"view_blur\": %d, "
                 "\"views\": {\"grid\": {\"columns\": 15, \"rows\": 9, \"width\": 4.2, "
                 "\"height\": 2.4}}",
                 blurs);
        const char *scene = scene_of(f, "v.json", camera);
        snprintf(folder, sizeof folder, "%s", lf_test_path(f->folder, blurs ? "v1" : "v0"));
        qr_succeed("%s -o %s/" QUICK "--view-size 50x40", scene, folder);
        field read = read_field(folder);
        const double height = 2 * 5 * tan(11 * M_PI / 180);
        const plate p = {1.25 * height, height, 5, {0.3, 0.3}, blurs, 0, 0, false};
        assert_int_equal(read.n[0], 40);
        assert_int_equal(read.n[1], 50);
        assert_int_equal(read.n[2], 9);
        assert_int_equal(read.n[3], 15);
        for (int k = 0; k < N_EYES; k++)
            assert_sees(&p, &read, eyes[k]);
        assert_controls_fail(&p, &read);
        lf_free(read.bytes);
    }
}

static void eyes_see_what_cells_rendered(void **state)
{
    const qr_files *f = *state;
    for (int blurs = 0; blurs < 2; blurs++) {
        char camera[512], folder[PATH_MAX];
        snprintf(camera, sizeof camera,
                 "\"position\": [0, 0, 0], \"target\": [0, 0, -1], \"fov_y\": 44, \"aspect\": "
                 "1.25, \"view_blur\": %d, \"views\": {\"grid\": {\"columns\": 48, \"rows\": 38, "
                 "\"width\": 2.35, \"height\": 1.85, \"window\": \"own\"}}",
                 blurs);
        const char *scene = scene_of(f, "h.json", camera);
        snprintf(folder, sizeof folder, "%s", lf_test_path(f->folder, blurs ? "h1" : "h0"));
        qr_succeed("%s -o %s/" QUICK "--view-size 30x24", scene, folder);
        field read = read_field(folder);
        const double slope = 2 * tan(22 * M_PI / 180) / 24;
        const plate p = {48 * 0.05, 38 * 0.05, 1, {slope, slope}, blurs, 0, 0, true};
        assert_int_equal(read.n[0], 38);
        assert_int_equal(read.n[1], 48);
        assert_int_equal(read.n[2], 24);
        assert_int_equal(read.n[3], 30);
        for (int k = 0; k < N_EYES; k++)
            assert_sees(&p, &read, eyes[k]);
        assert_controls_fail(&p, &read);
        lf_free(read.bytes);
    }
}

/* With one row of eyes, the vertical perspective is that of the height of the cameras, at their
 * distance, from wherever the plate is seen. */
static void one_row_of_eyes_has_its_own_vertical_centre(void **state)
{
    static const double at[] = {-1.6, 0, 0.9};
    const qr_files *f = *state;
    char camera[512], folder[PATH_MAX];
    int n_higher = 0, n_lower = 0;
    snprintf(camera, sizeof camera,
             "\"position\": [0, 0.4, 5], \"target\": [0, 0.4, 0], \"fov_y\": 22, \"aspect\": "
             "1.25, \"view_blur\": 1, \"views\": {\"grid\": {\"columns\": 15, \"rows\": 1, "
             "\"width\": 4.2, \"height\": 0}}");
    const char *scene = scene_of(f, "hpo.json", camera);
    snprintf(folder, sizeof folder, "%s", lf_test_path(f->folder, "hpo"));
    qr_succeed("%s -o %s/" QUICK "--view-size 50x40", scene, folder);
    field read = read_field(folder);
    const double height = 2 * 5 * tan(11 * M_PI / 180);
    plate p = {1.25 * height, height, 5, {0.3, 0}, 1, 0.4, 0.4, false};
    for (size_t i = 0; i < sizeof at / sizeof *at; i++) {
        const double eye[3] = {at[i], 0.4, 5}, higher[3] = {at[i], 1.2, 5};
        assert_sees(&p, &read, eye);
        p.rise = 1.2;
        n_higher += look(&p, &read, higher, (reading){0}).wrong;
        p.rise = -0.4;
        n_lower += look(&p, &read, (const double[3]){at[i], -0.4, 5}, (reading){0}).wrong;
        p.rise = 0.4;
    }
    assert_true(n_higher > 10 && n_lower > 10); /* other centres are noticed */
    lf_free(read.bytes);
}

/* How far the pixels of a colour move from the first to the last direction along an axis of the
 * written field (2: v, 3: u), to the right or down. */
static double shift(const field *f, int colour, int axis, bool down)
{
    double sum[2] = {0, 0};
    for (int end = 0; end < 2; end++) {
        int n = 0, at[2] = {f->n[2] / 2, f->n[3] / 2};
        at[axis - 2] = end ? f->n[axis] - 1 : 0;
        for (int k = 0; k < f->n[0] * f->n[1]; k++) {
            const uint8_t *rgb = sample(f, k / f->n[1], k % f->n[1], at[0], at[1]);
            if (rgb[0] / 255 + 2 * (rgb[1] / 255) + 4 * (rgb[2] / 255) != colour)
                continue;
            sum[end] += down ? k / f->n[1] : k % f->n[1];
            n++;
        }
        assert_true(n > 0);
        sum[end] /= n;
    }
    return sum[1] - sum[0];
}

/* In front of the plate, things move against the eye, and behind it with the eye. A flip of an axis
 * of cells or directions turns that round along this axis. */
static void flips_turn_depth_round_as_they_say(void **state)
{
    static const struct {
        const char *flip;
        int right, down; /* signs of what is behind */
    } cases[] = {{"hx,hx", 1, 1},        {"u", -1, 1},          {"v", 1, -1},
                 {"hx", -1, 1},          {"hy", 1, -1},         {"rotate180", -1, -1},
                 {"u,hx", 1, 1},         {"hx,hy", -1, -1},     {"transpose", 1, 1},
                 {"transpose,u", 1, -1}, {"u,transpose", -1, 1}};
    const qr_files *f = *state;
    const char *scene = scene_of(f, "signs.json",
                                 "\"position\": [0, 0, 5], \"fov_y\": 22, \"aspect\": 1.25, "
                                 "\"views\": {\"grid\": {\"columns\": 3, \"rows\": 3, "
                                 "\"width\": 1, \"height\": 1}}");
    char copy[PATH_MAX];
    snprintf(copy, sizeof copy, "%s", scene);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char folder[PATH_MAX];
        snprintf(folder, sizeof folder, "%s/signs_%zu", f->folder, i);
        qr_succeed("%s -o %s/" QUICK "--view-size 50x40 --flip %s", copy, folder, cases[i].flip);
        field read = read_field(folder);
        const bool turned = strstr(cases[i].flip, "transpose");
        const int across = turned ? 2 : 3, along = turned ? 3 : 2;
        for (int front = 0; front < 2; front++) {
            const int colour = front ? 2 : 4, sign = front ? -1 : 1;
            const double right = shift(&read, colour, across, false),
                         down = shift(&read, colour, along, true);
            if (!(sign * cases[i].right * right > 1 && sign * cases[i].down * down > 1))
                fail_msg("--flip %s: %s moves %g to the right and %g down", cases[i].flip,
                         front ? "the front" : "the back", right, down);
            lf_assert_close(shift(&read, colour, across, true), 0, 0, 0.5);
        }
        lf_free(read.bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eyes_see_what_eyes_rendered),
        cmocka_unit_test(eyes_see_what_cells_rendered),
        cmocka_unit_test(one_row_of_eyes_has_its_own_vertical_centre),
        cmocka_unit_test(flips_turn_depth_round_as_they_say),
    };
    return cmocka_run_group_tests_name("hologram_optics", tests, qr_set_up, qr_tear_down);
}
