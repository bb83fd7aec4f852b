/* What surfaces give back in all, by quadrature in double precision over the half vectors of one
 * direction. The microfacets here are written from the textbook (Walter et al. 2007; Heitz 2014)
 * and share no code with the lobes. */
#include "tests/testing.h"

#include <complex.h>

#include "render/transport/surface/metal.h"
#include "render/transport/surface/surface_lobes.h"
#include "render/transport/surface/surface_sheen.h"

/* ------------------------------------------------------------------------------------ oracle -- */

typedef struct lobe {
    const lf_material *m;
    double alpha, cos_o; /* looked at from (sqrt(1 - cos_o^2), 0, cos_o) */
} lobe;

static double smith_lambda(double alpha, double cosine)
{
    double tangent2 = (1.0 - cosine * cosine) / (cosine * cosine);
    return 0.5 * (sqrt(1.0 + alpha * alpha * tangent2) - 1.0);
}

/* Fresnel's equations for a step from 1 to eta, by amplitudes. */
static double fresnel(double cosine, double eta)
{
    double sine = sqrt(1.0 - cosine * cosine), refracted = cos(asin(sine / eta));
    double s = (cosine - eta * refracted) / (cosine + eta * refracted);
    double p = (refracted - eta * cosine) / (refracted + eta * cosine);
    return 0.5 * (s * s + p * p);
}

/* f(wo, wi) cos_i: what is integrated over wi. */
typedef double (*reflected)(const lobe *l, const double wi[3], double cos_oh, double cos_h);

/* The lobe under test, first channel. */
static double of_eval(const lobe *l, const double wi[3], double cos_oh, double cos_h)
{
    (void)cos_oh, (void)cos_h;
    lf_vec3 f, wo = lf_v3((float)sqrt(1.0 - l->cos_o * l->cos_o), 0.0f, (float)l->cos_o);
    l->m->kind->eval(l->m, lf_v3(0.0f, 0.0f, 1.0f), wo,
                     lf_v3((float)wi[0], (float)wi[1], (float)wi[2]), &f);
    return (double)f.x;
}

/* One reflection off a microfacet. */
static double of_textbook(const lobe *l, const double wi[3], double cos_oh, double cos_h)
{
    double a2 = l->alpha * l->alpha, tangent2 = (1.0 - cos_h * cos_h) / (cos_h * cos_h),
           c4 = cos_h * cos_h * cos_h * cos_h;
    double d = a2 / (M_PI * c4 * (a2 + tangent2) * (a2 + tangent2));
    double g = 1.0 / (1.0 + smith_lambda(l->alpha, l->cos_o) + smith_lambda(l->alpha, wi[2]));
    double f = l->m->kind == &lf_surface_plastic ? fresnel(cos_oh, (double)l->m->ior) : 1.0;
    return f * d * g / (4.0 * l->cos_o);
}

/* Over one half of the half vectors whose tangent is alpha sqrt(e^s - 1), which is even in s for
 * microfacets and for a cosine alike. */
static double around(const lobe *l, reflected f, double s)
{
    enum { N = 96 };
    double tangent = l->alpha * sqrt(expm1(s)), cos_h = 1.0 / sqrt(1.0 + tangent * tangent),
           sin_h = tangent * cos_h, sum = 0.0;
    double sin_o = sqrt(1.0 - l->cos_o * l->cos_o);
    for (int i = 0; i < N; i++) {
        double phi = M_PI * (i + 0.5) / N, h[3] = {sin_h * cos(phi), sin_h * sin(phi), cos_h};
        double oh = sin_o * h[0] + l->cos_o * h[2];
        double wi[3] = {2.0 * oh * h[0] - sin_o, 2.0 * oh * h[1], 2.0 * oh * h[2] - l->cos_o};
        if (oh > 0.0 && wi[2] > 0.0)
            sum += f(l, wi, fmin(oh, 1.0), cos_h) * 4.0 * oh;
    }
    return sum * M_PI / N * l->alpha * l->alpha * exp(s) * cos_h * cos_h * cos_h;
}

static double simpson(const lobe *l, reflected f, double a, double b, const double y[3],
                      double tolerance, int depth)
{
    double m = 0.5 * (a + b), left[3] = {y[0], around(l, f, 0.5 * (a + m)), y[1]},
           right[3] = {y[1], around(l, f, 0.5 * (m + b)), y[2]};
    double whole = (b - a) / 6.0 * (y[0] + 4.0 * y[1] + y[2]);
    double fine = (b - a) / 12.0 * (left[0] + 4.0 * left[1] + 2.0 * y[1] + 4.0 * right[1] + y[2]);
    if (depth == 0 || fabs(fine - whole) < 15.0 * tolerance)
        return fine + (fine - whole) / 15.0;
    return simpson(l, f, a, m, left, 0.5 * tolerance, depth - 1) +
           simpson(l, f, m, b, right, 0.5 * tolerance, depth - 1);
}

/* The integral over the hemisphere. Half vectors beyond a tangent of 3e3 lie within the tolerance.
 */
static double integral(const lf_material *m, double alpha, double cos_o, reflected f)
{
    enum { PIECES = 32 };
    lobe l = {m, alpha, cos_o};
    double end = log1p(9e6 / (alpha * alpha)), sum = 0.0;
    for (int i = 0; i < PIECES; i++) {
        double a = end * i / PIECES, b = end * (i + 1) / PIECES;
        double y[3] = {around(&l, f, a), around(&l, f, 0.5 * (a + b)), around(&l, f, b)};
        sum += simpson(&l, f, a, b, y, 2e-5, 12);
    }
    return sum;
}

/* ------------------------------------------------------------------------------------- cases -- */

static const double cosines[] = {1.0, 0.6, 0.2, 0.05, 0.01, 1e-3};
static const float roughness[] = {0.032f, 0.1f, 0.25f, 0.5f, 0.75f, 1.0f},
                   indices[] = {1.1f, 1.5f, 3.0f};
enum { N_COSINES = 6, N_ROUGHNESS = 6, N_INDICES = 3 };

static lf_material white(const lf_surface_kind *kind, float rough, float ior)
{
    lf_material m = {.kind = kind, .albedo = {1.0f, 1.0f, 1.0f}, .roughness = rough, .ior = ior};
    lf_material_prepare(&m);
    return m;
}

/* i-th of all kinds of rough white material. */
static lf_material nth(int i)
{
    int kind = i / N_ROUGHNESS;
    return white(kind == 0 ? &lf_surface_conductor : &lf_surface_plastic,
                 roughness[i % N_ROUGHNESS], kind ? indices[kind - 1] : 1.5f);
}
enum { N_MATERIALS = (1 + N_INDICES) * N_ROUGHNESS };

static void white_furnaces_are_white_at_every_roughness_and_angle(void **state)
{
    (void)state;
    double worst = 0.0;
    for (int i = 0; i < N_MATERIALS; i++) {
        lf_material m = nth(i);
        for (int j = 0; j < N_COSINES; j++) {
            double got = integral(&m, (double)lf_material_alpha(&m), cosines[j], of_eval);
            worst = fmax(worst, fabs(got - 1.0));
            if (!(fabs(got - 1.0) < 5e-3))
                fail_msg("%s, roughness %g, ior %g, cosine %g: %g", m.kind->name,
                         (double)m.roughness, (double)m.ior, cosines[j], got);
        }
    }
    print_message("worst furnace: off by %.2g\n", worst);
}

/* 1 - E as the textbook has it; and that is less than half for the roughest metal, which without
 * `rest` would be as dark as that. */
static void what_is_not_reflected_at_once_is_known(void **state)
{
    (void)state;
    double worst = 0.0, darkest = 1.0;
    for (int i = 0; i < N_MATERIALS; i++) {
        lf_material m = nth(i);
        for (int j = 0; j < N_COSINES; j++) {
            double e = integral(&m, (double)lf_material_alpha(&m), cosines[j], of_textbook);
            float loss = lf_loss(&m,
                                 m.kind == &lf_surface_plastic
                                     ? lf_coat_transmittance(m.ior, (float)cosines[j])
                                     : 0.0f,
                                 (float)cosines[j]);
            worst = fmax(worst, fabs(1.0 - e - (double)loss));
            darkest = fmin(darkest, m.kind == &lf_surface_conductor ? e : 1.0);
            if (!(fabs(1.0 - e - (double)loss) < 3e-3))
                fail_msg("%s, roughness %g, ior %g, cosine %g: %g is lost, not %g", m.kind->name,
                         (double)m.roughness, (double)m.ior, cosines[j], 1.0 - e, (double)loss);
        }
    }
    print_message("worst loss: off by %.2g; the darkest metal reflects %.3f at once\n", worst,
                  darkest);
    assert_true(darkest < 0.5);
}

/* Fresnel's equations by amplitudes, with a complex index; the worst that floats may make of 1 - R
 * is 1e-3 of it. */
static void metals_reflect_by_fresnel(void **state)
{
    (void)state;
    for (int i = 0; lf_metal_names[i]; i++) {
        lf_material m = {
            .kind = &lf_surface_conductor, .eta = lf_metals[i].eta, .k = lf_metals[i].k};
        lf_material_prepare(&m);
        for (int j = 0; j < N_COSINES; j++) {
            double c = cosines[j];
            double complex n = CMPLX((double)m.eta.y, (double)m.k.y),
                           t = csqrt(1.0 - (1.0 - c * c) / (n * n));
            double s = cabs((c - n * t) / (c + n * t)), p = cabs((t - n * c) / (t + n * c)),
                   r = 0.5 * (s * s + p * p);
            lf_vec3 wo = lf_v3((float)sqrt(1.0 - c * c), 0.0f, (float)c);
            lf_vec3 up = lf_v3(0.0f, 0.0f, 1.0f);
            lf_delta mirrored[LF_MAX_DELTAS];
            assert_int_equal(m.kind->deltas(&m, up, up, wo, true, mirrored), 1);
            double got = (double)mirrored[0].f.y;
            if (!(fabs(got - r) < 1e-3 * (1.0 - r) + 1e-6))
                fail_msg("%s, cosine %g: %.6f, not %.6f", lf_metal_names[i], c, got, r);
        }
    }
}

/* What a rough metal reflects of even light is brighter than one reflection, and never white. */
static void rough_metals_keep_their_colour(void **state)
{
    (void)state;
    for (int i = 0; lf_metal_names[i]; i++) {
        lf_material m = {.kind = &lf_surface_conductor,
                         .eta = lf_metals[i].eta,
                         .k = lf_metals[i].k,
                         .roughness = 1.0f};
        lf_material_prepare(&m);
        double once = integral(&m, 1.0, 0.6, of_textbook), all = integral(&m, 1.0, 0.6, of_eval);
        float r = lf_conductor_fresnel(&m, 1.0f).x;
        assert_true(all > once * (double)r && all < fmax((double)r, 0.7) + 0.02);
    }
}

/* -------------------------------------------------------------------------------- principled -- */

static lf_material layered(float metallic, float rough, float ior, float coat, float coat_rough)
{
    lf_material m = white(&lf_surface_principled, rough, ior);
    m.metallic = metallic;
    m.specular = 1.0f;
    m.specular_tint = lf_v3(1.0f, 1.0f, 1.0f);
    m.coat = coat;
    m.coat_roughness = coat_rough;
    lf_material_prepare(&m);
    return m;
}

/* Of all layers in any shares, rough ones integrated in the half vectors of the narrowest. */
static void white_layers_are_white_at_every_roughness_and_angle(void **state)
{
    (void)state;
    const float metallic[] = {0.0f, 0.5f, 1.0f}, coat[] = {0.0f, 0.0f, 1.0f, 0.5f},
                ior[] = {1.5f, 1.23f, 2.0f};
    double worst = 0.0;
    for (int i = 0; i < N_ROUGHNESS * 9; i++) {
        int share = i / N_ROUGHNESS;
        lf_material m = layered(metallic[share % 3], roughness[i % N_ROUGHNESS], ior[share / 3],
                                coat[i % 4], 0.3f);
        double alpha = fmin((double)lf_material_alpha(&m), m.coat > 0.0f ? 0.09 : 1.0);
        for (int j = 0; j < N_COSINES; j++) {
            double got = integral(&m, alpha, cosines[j], of_eval);
            worst = fmax(worst, fabs(got - 1.0));
            if (!(fabs(got - 1.0) < 5e-3))
                fail_msg("metallic %g, roughness %g, ior %g, coat %g, cosine %g: %g",
                         (double)m.metallic, (double)m.roughness, (double)m.ior, (double)m.coat,
                         cosines[j], got);
        }
    }
    print_message("worst furnace of layers: off by %.2g\n", worst);
}

/* Beyond the index of 3, where less and less goes to the base; from 100 on through one cosine,
 * about 1 / index, alone, which polynomials blur (lf_loss_smooth). */
static void white_layers_are_white_at_every_index(void **state)
{
    (void)state;
    const float ior[] = {3.3f, 4.0f, 12.0f, 100.0f, 1000.0f, 1e6f};
    double worst = 0.0;
    for (int i = 0; i < N_ROUGHNESS * 6; i++) {
        lf_material m = layered(0.0f, roughness[i % N_ROUGHNESS], ior[i / N_ROUGHNESS], 0.0f, 0.0f);
        for (int j = 0; j < N_COSINES; j++) {
            double got = integral(&m, (double)lf_material_alpha(&m), cosines[j], of_eval);
            worst = fmax(worst, fabs(got - 1.0));
            if (!(fabs(got - 1.0) < (m.ior < 100.0f ? 5e-3 : 1e-2)))
                fail_msg("roughness %g, ior %g, cosine %g: %g", (double)m.roughness, (double)m.ior,
                         cosines[j], got);
        }
    }
    print_message("worst furnace of any index: off by %.2g\n", worst);
}

/* An index without end: nothing is left to a base, which is black here; that of glass gives back
 * 0.04, seen straight on. */
static void what_reflects_all_gives_back_all_at_every_roughness_and_angle(void **state)
{
    (void)state;
    for (int i = 0; i < N_ROUGHNESS; i++) {
        lf_material m = layered(0.0f, roughness[i], 1e6f, 0.0f, 0.0f);
        m.albedo = lf_v3(0.0f, 0.0f, 0.0f);
        lf_material_prepare(&m);
        for (int j = 0; j < N_COSINES; j++) {
            double got = integral(&m, (double)lf_material_alpha(&m), cosines[j], of_eval);
            if (!(fabs(got - 1.0) < 5e-3))
                fail_msg("roughness %g, cosine %g: %g", (double)m.roughness, cosines[j], got);
        }
        m.ior = 1.5f;
        lf_material_prepare(&m);
        assert_true(integral(&m, (double)lf_material_alpha(&m), 1.0, of_eval) < 0.041);
    }
}

/* Estevez and Kulla's fibres, in double: at 1 and 0 of alpha, and linear in (1 - alpha)^2. */
static double fibres_lambda(double x, double alpha)
{
    const double t = (1.0 - alpha) * (1.0 - alpha), s = 1.0 - t;
    double a = 21.5473 * s + 25.3245 * t, b = 3.82987 * s + 3.32435 * t,
           c = 0.19823 * s + 0.16801 * t, d = -1.97760 * s - 1.27393 * t,
           e = -4.32054 * s - 4.85967 * t;
    double half = a / (1.0 + b * pow(0.5, c)) + d * 0.5 + e, y = x < 0.5 ? x : 1.0 - x,
           l = a / (1.0 + b * pow(y, c)) + d * y + e;
    return exp(x < 0.5 ? l : 2.0 * half - l);
}

static double fibres_albedo(double rough, double cos_o)
{
    enum { N = 400 };
    double alpha = rough * rough, sin_o = sqrt(1.0 - cos_o * cos_o), sum = 0.0;
    for (int i = 0; i < N * N; i++) {
        double cos_i = pow((i / N + 0.5) / N, 2.0), sin_i = sqrt(1.0 - cos_i * cos_i),
               phi = M_PI * (i % N + 0.5) / N,
               h[3] = {sin_o + sin_i * cos(phi), sin_i * sin(phi), cos_o + cos_i};
        double sine2 = (h[0] * h[0] + h[1] * h[1]) / (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
        double d = (2.0 + 1.0 / alpha) * pow(sine2, 0.5 / alpha) / (2.0 * M_PI);
        double g = 1.0 / (1.0 + fibres_lambda(cos_o, alpha) + fibres_lambda(cos_i, alpha));
        sum += d * g / (4.0 * cos_o) * 2.0 * sqrt(cos_i);
    }
    return sum * 2.0 * M_PI / (N * N);
}

/* Of fibres over black, and what white beneath them makes of the rest. */
static void fibres_reflect_what_the_layers_below_lack(void **state)
{
    (void)state;
    const float fibres[] = {0.2f, 0.35f, 0.5f, 0.77f, 1.0f};
    const double cosine[] = {0.1, 0.3, 0.55, 0.8, 0.98};
    double worst = 0.0;
    for (int i = 0; i < 25; i++) {
        lf_material m = layered(0.0f, 0.6f, 1.5f, 0.0f, 0.0f);
        m.sheen = lf_v3(1.0f, 0.5f, 0.0f);
        m.sheen_roughness = fibres[i / 5];
        lf_material_prepare(&m);
        double want = fibres_albedo((double)m.sheen_roughness, cosine[i % 5]),
               all = integral(&m, 1.0, cosine[i % 5], of_eval);
        lf_assert_close((double)lf_sheen_albedo(m.sheen_roughness, (float)cosine[i % 5]), want, 0,
                        5e-3);
        worst = fmax(worst, fabs(all - 1.0));
        m.albedo = lf_v3(0.0f, 0.0f, 0.0f);
        m.specular = 0.0f;
        lf_material_prepare(&m);
        lf_assert_close(integral(&m, 1.0, cosine[i % 5], of_eval), want, 0, 3e-3);
    }
    print_message("worst furnace of fibres over white: off by %.2g\n", worst);
    assert_true(worst < 5e-3);
}

static void a_metal_is_a_corner_of_the_layers(void **state)
{
    (void)state;
    const lf_vec3 up = lf_v3(0.0f, 0.0f, 1.0f);
    for (int i = 0; i < N_ROUGHNESS; i++) {
        lf_material m = layered(1.0f, roughness[i], 1.5f, 0.0f, 0.0f),
                    metal = white(&lf_surface_conductor, roughness[i], 1.5f);
        m.albedo = metal.albedo = lf_v3(0.9f, 0.5f, 0.1f);
        lf_material_prepare(&m);
        lf_material_prepare(&metal);
        lf_vec3 a, b, wo = lf_v3(0.6f, 0.0f, 0.8f), wi = lf_v3(-0.48f, 0.36f, 0.8f);
        float pdf = m.kind->eval(&m, up, wo, wi, &a);
        assert_float_equal(pdf, metal.kind->eval(&metal, up, wo, wi, &b), 1e-3f * pdf);
        assert_float_equal(a.x, b.x, 3e-3f * b.x);
        assert_float_equal(a.y, b.y, 6e-3f * b.y); /* Schlick's mean in closed form */
        assert_float_equal(a.z, b.z, 2e-2f * b.z);
    }
}

/* Snell's law, Fresnel's equations, and total reflection inside. */
static void glass_bends_light_by_snell_and_shares_it_by_fresnel(void **state)
{
    (void)state;
    const lf_vec3 up = lf_v3(0.0f, 0.0f, 1.0f);
    lf_material m = layered(0.0f, 0.0f, 1.5f, 0.0f, 0.0f);
    m.transmission = 1.0f;
    m.is_solid = true;
    lf_material_prepare(&m);
    assert_true(m.has_delta && !m.has_lobe);
    for (int j = 0; j < N_COSINES - 1; j++) {
        double c = cosines[j], sine = sqrt(1.0 - c * c), f = fresnel(c, 1.5);
        lf_vec3 wo = lf_v3((float)sine, 0.0f, (float)c);
        lf_delta out[LF_MAX_DELTAS];
        assert_int_equal(m.kind->deltas(&m, up, up, wo, true, out), 2);
        assert_true(fabs((double)out[0].f.x - (f)) < 1e-5);
        assert_true(fabs((double)out[1].f.x - (1.0 - f)) < 1e-5);
        assert_true(fabs((double)-out[1].wi.x - (sine / 1.5)) < 1e-6);
        assert_true(out[1].wi.z < 0.0f);
        /* back along the same way */
        assert_int_equal(
            m.kind->deltas(&m, up, up, lf_v3(-out[1].wi.x, 0.0f, -out[1].wi.z), false, out), 2);
        assert_true(fabs((double)out[0].f.x - (f)) < 1e-4);
        assert_true(fabs((double)out[1].wi.x - (-sine)) < 1e-5);
    }
    lf_delta out[LF_MAX_DELTAS];
    assert_int_equal(m.kind->deltas(&m, up, up, lf_v3(0.8f, 0.0f, 0.6f), false, out), 1);
    assert_true(out[0].f.x == 1.0f);
}

/* r + t^2 r + ... of two faces: 2 f / (1 + f); the rest goes straight on, of tinted ones as a lobe.
 */
static void a_pane_reflects_with_both_faces(void **state)
{
    (void)state;
    const lf_vec3 up = lf_v3(0.0f, 0.0f, 1.0f);
    lf_material m = layered(0.0f, 0.0f, 1.5f, 0.0f, 0.0f);
    m.transmission = 1.0f;
    lf_material_prepare(&m);
    lf_material tinted = m;
    tinted.albedo.y = 0.5f;
    lf_material_prepare(&tinted);
    for (int side = 0; side < 2; side++) {
        lf_delta out[LF_MAX_DELTAS];
        assert_int_equal(tinted.kind->deltas(&tinted, up, up, up, side == 0, out), 2);
        assert_true(fabs((double)out[0].f.x - (0.08 / 1.04)) < 1e-6);
        assert_true(fabs((double)out[1].f.x - (0.96 / 1.04)) < 1e-6);
        assert_true(out[1].wi.z == -1.0f);
        /* Of what meets the grey one all is reflected. */
        assert_int_equal(m.kind->deltas(&m, up, up, up, side == 0, out), 1);
        assert_true(fabs((double)out[0].f.x - 1.0) < 1e-6);
        assert_true(fabs((double)lf_thin_passes(&m, 1.0f) - (0.96 / 1.04)) < 1e-6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(white_furnaces_are_white_at_every_roughness_and_angle),
        cmocka_unit_test(metals_reflect_by_fresnel),
        cmocka_unit_test(rough_metals_keep_their_colour),
        cmocka_unit_test(what_is_not_reflected_at_once_is_known),
        cmocka_unit_test(white_layers_are_white_at_every_roughness_and_angle),
        cmocka_unit_test(white_layers_are_white_at_every_index),
        cmocka_unit_test(what_reflects_all_gives_back_all_at_every_roughness_and_angle),
        cmocka_unit_test(fibres_reflect_what_the_layers_below_lack),
        cmocka_unit_test(a_metal_is_a_corner_of_the_layers),
        cmocka_unit_test(glass_bends_light_by_snell_and_shares_it_by_fresnel),
        cmocka_unit_test(a_pane_reflects_with_both_faces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
