/* Rough glass: its lobe against Walter's equations, written from the paper in double precision; its
 * furnace; and what paths through a slab find, against a brute force walk that draws microfacets
 * from all of them instead of the visible ones. */
#include "tests/testing.h"

#include "render/transport/path/path.h"
#include "render/transport/sampler.h"
#include "render/transport/surface/surface_glass.h"
#include "tests/scene_file.h"
#include "tests/stat/chi2.h"
#include "tests/stat/fixture.h"

static const lf_vec3 up = {0.0f, 0.0f, 1.0f};
static const float cosines[] = {1.0f, 0.7f, 0.25f, 0.02f},
                   roughness[] = {0.032f, 0.1f, 0.3f, 0.6f, 1.0f};
enum { N_COSINES = 4, N_ROUGHNESS = 5, N_SIDES = 3 };

/* side: 0 a solid from outside, 1 from within, 2 a sheet. */
static lf_material glass(float rough, float ior, int side)
{
    lf_material m = {.kind = &lf_surface_principled,
                     .albedo = {1.0f, 1.0f, 1.0f},
                     .roughness = rough,
                     .ior = ior,
                     .specular = 1.0f,
                     .specular_tint = {1.0f, 1.0f, 1.0f},
                     .transmission = 1.0f,
                     .is_solid = side < 2};
    lf_material_prepare(&m);
    m.glass.is_inside = side == 1;
    return m;
}

static lf_vec3 at_cosine(float cosine, float phi)
{
    float sine = sqrtf(1.0f - cosine * cosine);
    return lf_v3(sine * cosf(phi), sine * sinf(phi), cosine);
}

/* ------------------------------------------------------------------------------ the textbook -- */

static double fresnel(double cos_o, double eta)
{
    double sine2 = (1.0 - cos_o * cos_o) / (eta * eta);
    if (sine2 >= 1.0)
        return 1.0;
    double cos_t = sqrt(1.0 - sine2), s = (cos_o - eta * cos_t) / (cos_o + eta * cos_t),
           p = (eta * cos_o - cos_t) / (eta * cos_o + cos_t);
    return 0.5 * (s * s + p * p);
}

static double tangent2(double cosine)
{
    return (1.0 - cosine * cosine) / (cosine * cosine);
}

static double smith(double alpha, double cosine)
{
    return 2.0 / (1.0 + sqrt(1.0 + alpha * alpha * tangent2(cosine)));
}

static double ggx(double alpha, double cos_h)
{
    double k = cos_h * cos_h * (alpha * alpha + tangent2(cos_h));
    return alpha * alpha / (M_PI * k * k);
}

/* Walter et al. 2007, eq. 21 times |cos_i|, radiance counted as eta_i^2 and eta_o^2 have it. */
static double walter(double alpha, double eta, const double o[3], const double i[3])
{
    double h[3], length = 0.0, oh = 0.0, ih = 0.0;
    for (int a = 0; a < 3; a++) {
        h[a] = -(o[a] + eta * i[a]);
        length += h[a] * h[a];
    }
    length = sqrt(length) * (h[2] < 0.0 ? -1.0 : 1.0);
    for (int a = 0; a < 3; a++) {
        h[a] /= length;
        oh += o[a] * h[a];
        ih += i[a] * h[a];
    }
    if (oh <= 0.0 || ih >= 0.0 || i[2] >= 0.0)
        return 0.0;
    double d = oh + eta * ih;
    return oh * -ih / o[2] * (1.0 - fresnel(oh, eta)) * smith(alpha, o[2]) * smith(alpha, -i[2]) *
           ggx(alpha, h[2]) * eta * eta / (d * d);
}

/* ---------------------------------------------------------------------------------- the lobe -- */

/* But for one factor a direction, which makes good what further facets would bring. */
static void what_is_refracted_follows_walter(void **state)
{
    (void)state;
    int compared = 0;
    for (int c = 0; c < N_ROUGHNESS * N_COSINES * 2; c++) {
        lf_material m = glass(roughness[c % N_ROUGHNESS], 1.5f, c / (N_ROUGHNESS * N_COSINES));
        double eta = m.glass.is_inside ? 1.0 / 1.5 : 1.5, first = 0.0;
        lf_vec3 wo = at_cosine(cosines[c / N_ROUGHNESS % N_COSINES], 0.4f);
        for (int j = 0; j < 200; j++) {
            lf_sampler s;
            float u[3];
            lf_vec3 wi, f;
            lf_sampler_init(&s, LF_SAMPLER_OWEN, lf_test_seed(), (uint32_t)j);
            lf_sampler_2d(&s, u);
            u[2] = lf_sampler_1d(&s);
            if (!(m.kind->sample(&m, up, wo, u, &wi, &f) > 0.0f) || wi.z > -0.01f)
                continue;
            const double o[3] = {(double)wo.x, (double)wo.y, (double)wo.z},
                         i[3] = {(double)wi.x, (double)wi.y, (double)wi.z};
            double want = walter((double)lf_material_alpha(&m), eta, o, i);
            if (!(want > 1e-3))
                continue;
            double ratio = (double)f.x / want;
            first = first > 0.0 ? first : ratio;
            lf_assert_close(ratio, first, 0.02, 0); /* floats, of a peak 1e-3 wide */
            assert_true(ratio > 0.98 && ratio < 3.0);
            compared++;
        }
    }
    assert_true(compared > 3000);
}

/* f over what it gets back, both ways, but for that factor: in the ratio of the indices squared.
 */
static void refraction_is_reciprocal_in_the_indices_squared(void **state)
{
    (void)state;
    int compared = 0;
    for (int c = 0; c < N_ROUGHNESS; c++) {
        lf_material out = glass(roughness[c], 1.5f, 0), in = glass(roughness[c], 1.5f, 1);
        for (int k = 0; k < LF_GLASS_NODES; k++)
            out.glass.kept[0][k] = in.glass.kept[1][k] = 1.0f;
        for (int j = 0; j < 400; j++) {
            lf_vec3 wo = at_cosine(0.1f + 0.002f * (float)j, 0.0f), f, g,
                    straight = at_cosine(sqrtf(1.0f - (1.0f - wo.z * wo.z) / 2.25f), 0.0f);
            lf_vec3 wi = lf_normalize(lf_v3(-straight.x + 0.1f * roughness[c] * sinf((float)j),
                                            0.05f * roughness[c] * cosf((float)j), -straight.z));
            float pdf = out.kind->eval(&out, up, wo, wi, &f);
            in.kind->eval(&in, up, lf_v3(-wi.x, wi.y, -wi.z), lf_v3(-wo.x, wo.y, -wo.z), &g);
            if (!(pdf > 0.0f) || !(f.x > 1e-2f))
                continue;
            lf_assert_close((double)(f.x / -wi.z), 2.25 * (double)(g.x / wo.z), 2e-2, 0);
            compared++;
        }
    }
    assert_true(compared > 1000);
}

typedef struct setup {
    lf_material m, claimed;
    lf_vec3 wo;
} setup;

static bool draw(const void *context, const float u[3], lf_vec3 *w)
{
    const setup *s = context;
    lf_vec3 f;
    return s->m.kind->sample(&s->m, up, s->wo, u, w, &f) > 0.0f;
}

static double pdf(const void *context, lf_vec3 w)
{
    const setup *s = context;
    lf_vec3 f;
    return (double)s->claimed.kind->eval(&s->claimed, up, s->wo, w, &f);
}

static double p_value(const setup *s, double *mass)
{
    lf_chi2_sphere q = {.sample = draw,
                        .pdf = pdf,
                        .context = s,
                        .axis = up,
                        .m_max = 2.0,
                        .warp = 1e-6,
                        .n_t = 30,
                        .n_phi = 30,
                        .n_samples = 100000,
                        .seed = lf_test_seed()};
    return lf_chi2_sphere_p(&q, mass);
}

/* Narrow ones are narrower than bins about the normal: from a roughness of 0.3 on. The last are
 * half glass. */
static void directions_are_drawn_by_a_pdf_that_integrates_to_one(void **state)
{
    (void)state;
    enum { N = 2 * (N_SIDES + 1) * 2 };
    for (int c = 0; c < N; c++) {
        int side = c / 2 % (N_SIDES + 1);
        float rough = roughness[2 + 2 * (c / 2 / (N_SIDES + 1))], cosine = cosines[1 + c % 2];
        setup s = {.m = glass(rough, 1.5f, side % N_SIDES), .wo = at_cosine(cosine, 1.0f)};
        if (side == N_SIDES) {
            s.m.transmission = 0.5f;
            s.m.metallic = 0.3f;
            s.m.coat = 0.5f;
            s.m.coat_roughness = 0.5f;
            lf_material_prepare(&s.m);
        }
        s.claimed = s.m;
        double mass, p = p_value(&s, &mass);
        if (!(p > lf_sidak(LF_FALSE_ALARM, N)) || fabs(mass - 1.0) > 1e-3)
            fail_msg("side %d, roughness %g, cosine %g: p %g, integral %g", side, (double)rough,
                     (double)cosine, p, mass);
    }
    setup wrong = {glass(0.3f, 1.5f, 0), glass(0.3f, 1.52f, 0), at_cosine(0.7f, 1.0f)};
    assert_true(p_value(&wrong, NULL) < 1e-6);
}

/* Mean of f / pdf over a net, and of the part that goes through; *out_way is where that goes. */
static double given_back(const lf_material *m, lf_vec3 wo, double *out_through, lf_vec3 *out_way)
{
    const int n = m->roughness < 0.8f ? 1 << 15 : 1 << 18;
    double sum = 0.0;
    *out_through = 0.0;
    *out_way = lf_v3(0.0f, 0.0f, 0.0f);
    for (int j = 0; j < n; j++) {
        lf_sampler s;
        float u[3];
        lf_vec3 wi, f;
        lf_sampler_init(&s, LF_SAMPLER_OWEN, lf_test_seed() + 1, (uint32_t)j);
        lf_sampler_2d(&s, u);
        u[2] = lf_sampler_1d(&s);
        float p = m->kind->sample(m, up, wo, u, &wi, &f);
        assert_true(isfinite(p) && p >= 0.0f && isfinite(f.x) && f.x >= 0.0f);
        double weight = p > 0.0f ? (double)(f.x / p) / n : 0.0;
        sum += weight;
        *out_through += wi.z < 0.0f ? weight : 0.0;
        if (wi.z < 0.0f)
            *out_way = lf_madd(*out_way, (float)weight, wi);
    }
    return sum;
}

static void white_glass_gives_back_all_at_every_roughness_and_angle(void **state)
{
    (void)state;
    static const float indices[] = {1.1f, 1.33f, 2.4f, 4.0f, 1e6f};
    double worst = 0.0, through;
    lf_vec3 way;
    for (int c = 0; c < 5 * N_SIDES * N_ROUGHNESS * N_COSINES; c++) {
        float ior = indices[c / (N_SIDES * N_ROUGHNESS * N_COSINES)];
        int side = c / (N_ROUGHNESS * N_COSINES) % N_SIDES;
        lf_material m = glass(roughness[c / N_COSINES % N_ROUGHNESS], ior, side);
        double got = given_back(&m, at_cosine(cosines[c % N_COSINES], 0.0f), &through, &way);
        worst = fmax(worst, fabs(got - 1.0));
        if (!(fabs(got - 1.0) < 5e-3))
            fail_msg("side %d, roughness %g, ior %g, cosine %g: %g", side, (double)m.roughness,
                     (double)ior, (double)cosines[c % N_COSINES], got);
    }
    print_message("worst furnace of rough glass: off by %.2g\n", worst);
}

static void the_table_says_what_the_integral_does(void **state)
{
    (void)state;
    double worst = 0.0;
    for (int i = 0; i < 24; i++) {
        float fitted[LF_GLASS_NODES], table[LF_GLASS_NODES], rough = 0.032f + 0.04f * (float)i;
        lf_glass_fit(1.5f, i % 2, rough, fitted);
        lf_glass_look_up(1.5f, i % 2, rough, table);
        for (int k = 0; k < LF_GLASS_NODES; k++)
            worst = fmax(worst, fabs((double)(fitted[k] - table[k])));
    }
    print_message("worst of the table: off by %.2g\n", worst);
    assert_true(worst < 5e-3);
}

/* Fresnel's shares and Snell's angle, from both sides; beyond the critical angle nothing. */
static void the_least_rough_glass_is_nearly_smooth(void **state)
{
    (void)state;
    for (int side = 0; side < N_SIDES; side++) {
        for (int c = 0; c < 3; c++) {
            lf_material m = glass(LF_LEAST_ROUGHNESS, 1.5f, side);
            double cosine = (double)cosines[c], eta = side == 1 ? 1.0 / 1.5 : 1.5, through,
                   f = fresnel(cosine, eta), sine = sqrt(1.0 - cosine * cosine);
            lf_vec3 way, wo = at_cosine(cosines[c], 0.0f);
            double all = given_back(&m, wo, &through, &way);
            if (side == 2)
                f = 2.0 * f / (1.0 + f);
            lf_assert_close(all, 1.0, 2e-3, 0);
            lf_assert_close(through, 1.0 - f, 3e-3, 1e-3);
            if (f < 1.0)
                lf_assert_close((double)-way.x / through, side < 2 ? sine / eta : sine, 0, 2e-3);
        }
    }
}

static void a_solid_of_almost_no_index_is_clear(void **state)
{
    (void)state;
    lf_material m = glass(0.5f, 1.005f, 0);
    lf_delta lobe[LF_MAX_DELTAS];
    assert_true(!m.glass.is_rough && m.has_delta);
    assert_int_equal(m.kind->deltas(&m, up, up, up, true, lobe), 1);
    assert_true(lobe[0].wi.z == -1.0f && lobe[0].f.x > 0.999f);
}

/* Every power of ten down to the smallest cosines, on both sides. */
static void grazing_directions_give_finite_values(void **state)
{
    (void)state;
    for (int c = 0; c < N_SIDES * N_ROUGHNESS; c++) {
        lf_material m = glass(roughness[c % N_ROUGHNESS], 1.5f, c / N_ROUGHNESS);
        for (int j = 0; j < 12 * 12; j++) {
            float co = powf(10.0f, -(float)(j % 12)), ci = powf(10.0f, -(float)(j / 12));
            lf_vec3 wo = at_cosine(co, 0.0f), wi = at_cosine(ci, LF_PI), f;
            wi.z = j % 2 ? wi.z : -wi.z;
            float p = m.kind->eval(&m, up, wo, wi, &f);
            assert_true(isfinite(p) && p >= 0.0f && isfinite(f.x) && f.x >= 0.0f);
            p = m.kind->eval(&m, up, wo, lf_scale(wo, -1.0f), &f);
            assert_true(isfinite(p) && p >= 0.0f && isfinite(f.x) && f.x >= 0.0f);
            for (int k = 0; k < 8; k++) {
                const float end = 0x1.fffffep-1f,
                            u[3] = {k & 1 ? end : 0.0f, k & 2 ? end : 0.0f, k & 4 ? end : 0.0f};
                p = m.kind->sample(&m, up, wo, u, &wi, &f);
                assert_true(isfinite(p) && p >= 0.0f && isfinite(f.x) && f.x >= 0.0f);
                assert_true(p == 0.0f || fabsf(lf_length(wi) - 1.0f) < 1e-5f);
            }
        }
    }
}

/* Above and below. */
static void fans_answer_as_single_directions_do(void **state)
{
    (void)state;
    enum { n = 32 };
    int compared = 0;
    for (int c = 0; c < N_SIDES * N_ROUGHNESS * 8; c++) {
        lf_material m = glass(roughness[c / 8 % N_ROUGHNESS], 1.5f, c / 8 / N_ROUGHNESS);
        m.transmission = c % 2 ? 1.0f : 0.6f;
        m.albedo = lf_v3(0.9f, 0.5f, 0.2f);
        float x[n], y[n], z[n], pdf_of[n], f_of[3][n];
        lf_fan_lobes fan = {.pdf = pdf_of, .f = {f_of[0], f_of[1], f_of[2]}};
        lf_vec3 wi = at_cosine(cosines[c / 2 % 4], 1.0f);
        wi.z = c % 8 < 6 ? -wi.z : wi.z;
        for (int k = 0; k < n; k++) {
            lf_vec3 wo = at_cosine(1.0f - (float)k / 25.0f, 4.0f + 0.1f * (float)k);
            x[k] = wo.x;
            y[k] = wo.y;
            z[k] = wo.z;
        }
        lf_surface_fans_c.of[m.kind->fan](&m, wi, n, x, y, z, &fan);
        for (int k = 0; k < n; k++) {
            lf_vec3 f, g = {f_of[0][k], f_of[1][k], f_of[2][k]};
            float p = m.kind->eval(&m, up, lf_v3(x[k], y[k], z[k]), wi, &f);
            lf_assert_close((double)pdf_of[k], (double)p, 2e-3, 1e-6);
            lf_assert_close((double)g.x, (double)f.x, 2e-3, 1e-6);
            lf_assert_close((double)g.z, (double)f.z, 2e-3, 1e-6);
            compared += p > 0.0f;
        }
    }
    assert_true(compared > 1000);
}

/* ---------------------------------------------------------------------------------- the slab -- */

typedef struct walk {
    uint64_t n;
    double alpha;
} walk;

static double uniform(walk *w)
{
    return (double)(lf_hash64(lf_test_seed() + 77, w->n++) >> 11) * 0x1p-53;
}

/* Light that comes along -o to a rough face seen from above: a facet from those of all slopes,
 * weighed by |oh| G1(o) / (cos_o cos_h) and G1 of where it goes (Walter et al., eq. 41); without
 * what further facets would bring. Returns the weight; i is where to. */
static double bounce(walk *w, double eta, const double o[3], double i[3])
{
    double u = uniform(w), phi = 2.0 * M_PI * uniform(w), oh = 0.0;
    double t = w->alpha * sqrt(u / (1.0 - u)), c = 1.0 / sqrt(1.0 + t * t);
    const double h[3] = {t * c * cos(phi), t * c * sin(phi), c};
    for (int a = 0; a < 3; a++)
        oh += o[a] * h[a];
    if (oh <= 0.0)
        return 0.0;
    double f = fresnel(oh, eta);
    bool mirrored = uniform(w) < f;
    double k = mirrored ? 2.0 * oh : oh / eta - sqrt(1.0 - (1.0 - oh * oh) / (eta * eta));
    for (int a = 0; a < 3; a++)
        i[a] = k * h[a] - (mirrored ? o[a] : o[a] / eta);
    if ((i[2] > 0.0) != mirrored)
        return 0.0;
    double lo = 1.0 / smith(w->alpha, o[2]) - 1.0, li = 1.0 / smith(w->alpha, fabs(i[2])) - 1.0,
           g = mirrored ? 1.0 / (1.0 + lo + li) : 1.0 / ((1.0 + lo) * (1.0 + li));
    return g * oh / (o[2] * c);
}

/* What a face gives back in all of what comes along a direction of this cosine. */
static double kept(walk *w, double eta, double cosine)
{
    enum { N = 20000 };
    double sum = 0.0, i[3];
    const double o[3] = {sqrt(1.0 - cosine * cosine), 0.0, cosine};
    for (int k = 0; k < N; k++)
        sum += bounce(w, eta, o, i) / N;
    return sum;
}

enum { KEPT = 48 };
static double kept_at(const double table[KEPT + 1], double cosine)
{
    double x = sqrt(cosine) * KEPT;
    int k = x < KEPT - 1 ? (int)x : KEPT - 1;
    return table[k] + (table[k + 1] - table[k]) * (x - k);
}

/* Light from behind a slab of this thickness that absorbs 1 a unit, seen from above along a cosine.
 */
static lf_moments behind_slab(walk *w, double thickness, double cosine, int n)
{
    double table[2][KEPT + 1];
    lf_moments m = {0};
    for (int k = 0; k <= KEPT; k++)
        for (int side = 0; side < 2; side++)
            table[side][k] =
                kept(w, side ? 1.0 / 1.5 : 1.5, fmax((double)k * k / (KEPT * KEPT), 1e-4));
    for (int j = 0; j < n; j++) {
        double o[3] = {sqrt(1.0 - cosine * cosine), 0.0, cosine}, i[3], weight = 1.0, got = 0.0;
        weight *= bounce(w, 1.5, o, i) / kept_at(table[0], cosine);
        bool above = true;
        while (weight > 1e-4 && !(above && i[2] > 0.0)) {
            weight *= exp(-thickness / fabs(i[2]));
            above = !above;
            for (int a = 0; a < 3; a++)
                o[a] = -i[a];
            o[2] = fabs(o[2]);
            weight *= bounce(w, 1.0 / 1.5, o, i) / kept_at(table[1], o[2]);
            if (i[2] < 0.0) { /* out: below, or above where it began */
                got = above ? 0.0 : weight;
                break;
            }
            i[2] = -1.0 * i[2]; /* on to the other face, which is looked at from within too */
        }
        lf_moments_add(&m, got);
    }
    return m;
}

static void light_through_a_rough_slab_is_what_a_walk_finds(void **state)
{
    (void)state;
    enum { N = 60000 };
    lf_scene *scene = lf_test_scene(lf_test_scene_text("slab-over-light"));
    for (int c = 0; c < 2; c++) {
        walk w = {.alpha = 0.25};
        float cosine = c ? 0.4f : 1.0f;
        lf_moments want = behind_slab(&w, 0.5, (double)cosine, N), got = {0};
        lf_tracer tracer = {.scene = scene, .rng = lf_test_seed() + 7};
        lf_event event = {.kind = LF_EVENT_SURFACE,
                          .w = lf_v3(sqrtf(1.0f - cosine * cosine), -cosine, 0.0f)};
        assert_true(
            lf_trace_surface(&tracer, lf_v3(0.2f, 1.0f, 0.3f), event.w, INFINITY, &event.hit));
        event.p = event.hit.p;
        for (int j = 0; j < N; j++)
            lf_moments_add(&got, (double)lf_path_scattered(&tracer, &event, 1, 64).y);
        double error = hypot(lf_moments_error(&got), lf_moments_error(&want));
        print_message("cosine %.1f: %.4f, walk %.4f, standard error %.4f\n", (double)cosine,
                      got.mean, want.mean, error);
        /* Four errors, and what the table of what is kept is off by. */
        lf_assert_close(got.mean, want.mean, 5e-3, 4.0 * error);
    }
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_refracted_follows_walter),
        cmocka_unit_test(refraction_is_reciprocal_in_the_indices_squared),
        cmocka_unit_test(directions_are_drawn_by_a_pdf_that_integrates_to_one),
        cmocka_unit_test(white_glass_gives_back_all_at_every_roughness_and_angle),
        cmocka_unit_test(the_table_says_what_the_integral_does),
        cmocka_unit_test(the_least_rough_glass_is_nearly_smooth),
        cmocka_unit_test(a_solid_of_almost_no_index_is_clear),
        cmocka_unit_test(grazing_directions_give_finite_values),
        cmocka_unit_test(fans_answer_as_single_directions_do),
        cmocka_unit_test(light_through_a_rough_slab_is_what_a_walk_finds),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
