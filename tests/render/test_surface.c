#include "tests/testing.h"

#include "render/plane/kernel.h"
#include "render/transport/sampler.h"
#include "tests/stat/chi2.h"
#include "tests/stat/stat.h"

typedef struct setup {
    lf_material m, claimed; /* what is drawn, and whose pdf is claimed */
    lf_vec3 ns, wo;
} setup;

/* What the first delta lobe reflects, 0 where there is none. */
static lf_vec3 delta_of(const lf_material *m, lf_vec3 ns, lf_vec3 wo)
{
    lf_delta lobe[LF_MAX_DELTAS];
    int n = m->kind->deltas ? m->kind->deltas(m, ns, ns, wo, true, lobe) : 0;
    return n > 0 ? lobe[0].f : lf_v3(0.0f, 0.0f, 0.0f);
}

static lf_material material(const lf_surface_kind *kind, float roughness, float albedo)
{
    lf_material m = {
        .kind = kind, .albedo = {albedo, albedo, albedo}, .roughness = roughness, .ior = 1.5f};
    lf_material_prepare(&m);
    return m;
}

/* Layers in many shares, from the n-th on. */
static int make_layered(lf_material *m, int n)
{
    const float metallic[] = {0.0f, 0.4f, 1.0f}, roughness[] = {0.0f, 0.1f, 0.5f};
    for (int i = 0; i < 9; i++) {
        m[n] = material(&lf_surface_principled, roughness[i % 3], 0.6f);
        m[n].metallic = metallic[i / 3];
        m[n].specular = i % 2 ? 0.5f : 1.0f;
        m[n].specular_tint = lf_v3(1.0f, 1.0f, 1.0f);
        m[n].coat = i % 2 ? 0.7f : 0.0f;
        m[n].coat_roughness = 0.5f;
        m[n].transmission = i == 3 ? 0.5f : 0.0f;
        m[n].sheen = i == 5 || i == 8 ? lf_v3(0.9f, 0.5f, 0.0f) : lf_v3(0.0f, 0.0f, 0.0f);
        m[n].sheen_roughness = 0.3f;
        lf_material_prepare(&m[n]);
        n += m[n].has_lobe;
    }
    return n;
}

/* Grooves as a hit has them. */
static lf_material anisotropic(float metallic, float along, float across, float angle)
{
    lf_material m = material(&lf_surface_principled, 0.5f, 0.6f);
    m.metallic = metallic;
    m.specular = 1.0f;
    m.specular_tint = lf_v3(1.0f, 1.0f, 1.0f);
    m.roughness = sqrtf(sqrtf(0.5f * (along * along + across * across)));
    m.anisotropy = 1.0f;
    m.anisotropy_rotation[0] = 1.0f;
    m.anisotropic = (lf_anisotropy){.alpha = {along, across}, .along = {cosf(angle), sinf(angle)}};
    lf_material_prepare(&m);
    return m;
}

/* Flesh that is met from within. */
static lf_material from_within(float metallic)
{
    lf_material m = material(&lf_surface_principled, 0.5f, 0.6f);
    m.metallic = metallic;
    m.specular = 1.0f;
    m.specular_tint = lf_v3(1.0f, 1.0f, 1.0f);
    m.subsurface = 0.7f;
    m.subsurface_radius = lf_v3(1.0f, 1.0f, 1.0f);
    m.glass.is_inside = true;
    lf_material_prepare(&m);
    return m;
}

/* A rough coat that leans off its base. */
static lf_material leaning(float metallic, float tilt)
{
    lf_material m = anisotropic(metallic, 0.5f, 0.1f, 0.7f);
    m.anisotropy = 0.0f;
    m.anisotropic = (lf_anisotropy){0};
    m.coat = 0.8f;
    m.coat_roughness = 0.5f;
    m.coat_normal = lf_v3(sinf(tilt) * 0.6f, sinf(tilt) * 0.8f, cosf(tilt));
    lf_material_prepare(&m);
    return m;
}

/* Of a high index. */
static lf_material dense(float roughness, float ior)
{
    lf_material m = material(&lf_surface_principled, roughness, 0.6f);
    m.specular = 1.0f;
    m.specular_tint = lf_v3(1.0f, 1.0f, 1.0f);
    m.ior = ior;
    lf_material_prepare(&m);
    return m;
}

/* Every kind of lobe that can be sampled. */
static int make_materials(lf_material *m)
{
    const float roughness[] = {0.04f, 0.1f, 0.3f, 0.6f, 1.0f};
    int n = 0;
    m[n++] = material(&lf_surface_diffuse, 0.0f, 0.8f);
    m[n++] = material(&lf_surface_plastic, 0.0f, 0.5f);
    for (int i = 0; i < 5; i++) {
        m[n++] = material(&lf_surface_conductor, roughness[i], 0.9f);
        m[n++] = material(&lf_surface_plastic, roughness[i], 0.5f);
    }
    m[n++] = material(&lf_surface_plastic, 0.3f, 0.0f);
    m[n] = material(&lf_surface_conductor, 0.3f, 0.0f);
    m[n].eta = lf_v3(0.2f, 0.9f, 1.3f);
    m[n].k = lf_v3(3.3f, 2.6f, 2.4f);
    lf_material_prepare(&m[n++]);
    m[n++] = anisotropic(1.0f, 0.5f, 0.1f, 0.7f);
    m[n++] = anisotropic(0.3f, 0.9f, 0.2f, 2.0f);
    m[n++] = leaning(0.0f, 0.5f);
    m[n++] = leaning(1.0f, 0.6f);
    m[n++] = dense(0.3f, 4.0f);
    m[n++] = dense(0.6f, 1e6f);
    return make_layered(m, n);
}
enum { max_materials = 34 };

static const lf_vec3 normals[] = {{0.0f, 0.0f, 1.0f}, {0.48f, 0.64f, -0.6f}};
static const float cosines[] = {1.0f, 0.7f, 0.25f, 0.02f};

/* A direction at this cosine to ns. */
static lf_vec3 at_cosine(lf_vec3 ns, float cosine, float phi)
{
    lf_vec3 t, b;
    float sine = sqrtf(1.0f - cosine * cosine);
    lf_tangents(ns, &t, &b);
    return lf_from_frame(t, b, ns, lf_v3(sine * cosf(phi), sine * sinf(phi), cosine));
}

static bool draw(const void *context, const float u[3], lf_vec3 *w)
{
    const setup *s = context;
    lf_vec3 f;
    return s->m.kind->sample(&s->m, s->ns, s->wo, u, w, &f) > 0.0f;
}

static double pdf(const void *context, lf_vec3 w)
{
    const setup *s = context;
    lf_vec3 f;
    return (double)s->claimed.kind->eval(&s->claimed, s->ns, s->wo, w, &f);
}

/* Narrow lobes are binned about the mirror direction, wide ones about the normal, where the horizon
 * is an edge of bins. */
static double p_value(const setup *s, double *mass)
{
    double alpha = (double)(s->m.roughness * s->m.roughness);
    bool narrow = s->m.kind != &lf_surface_diffuse && alpha > 0.0 && alpha < 0.05;
    lf_vec3 mirror = lf_normalize(lf_sub(lf_scale(s->ns, 2.0f * lf_dot(s->ns, s->wo)), s->wo));
    lf_chi2_sphere q = {
        .sample = draw, .pdf = pdf, .context = s, .n_t = 30, .n_phi = 30, .n_samples = 400000};
    q.axis = narrow ? mirror : s->ns;
    q.m_max = 2.0;
    q.warp = narrow ? log(1.0 / (alpha * alpha)) : 1e-6;
    q.seed = lf_test_seed();
    return lf_chi2_sphere_p(&q, mass);
}

/* Over the whole sphere: what microfacets send below the horizon is drawn and counts. */
static void samplers_follow_their_pdfs_which_integrate_to_one(void **state)
{
    (void)state;
    lf_material m[max_materials];
    int n = make_materials(m);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < 4; j++) {
            double mass;
            lf_vec3 ns = normals[(i + j) % 2];
            setup s = {m[i], m[i], ns, at_cosine(ns, cosines[j], 1.0f + (float)j)};
            double p = p_value(&s, &mass);
            if (!(p > lf_sidak(LF_FALSE_ALARM, 4 * n)) || fabs(mass - 1.0) > 1e-4)
                fail_msg("%s, roughness %g, cosine %g: p %g, integral %g", m[i].kind->name,
                         (double)m[i].roughness, (double)cosines[j], p, mass);
        }
    }
}

/* No lobe is left to another's tail: what f a direction has is drawn with a pdf that is no fraction
 * of it. */
static void what_is_reflected_can_be_drawn(void **state)
{
    (void)state;
    lf_material m[max_materials + 1];
    int n = make_materials(m);
    m[n] = material(&lf_surface_principled, 0.1f, 0.0f); /* fibres over frosted glass */
    m[n].transmission = 1.0f;
    m[n].is_solid = true;
    m[n].sheen = lf_v3(1.0f, 1.0f, 1.0f);
    m[n].sheen_roughness = 0.5f;
    lf_material_prepare(&m[n++]);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < 4 * 64; j++) {
            lf_vec3 ns = normals[0], wo = at_cosine(ns, cosines[j % 4], 0.3f), f,
                    wi = at_cosine(ns, 0.02f + 0.06f * (float)(j / 4 % 16), 1.6f * (float)(j / 64));
            float pdf = m[i].kind->eval(&m[i], ns, wo, wi, &f);
            if (!(lf_max3(f) <= 60.0f * pdf))
                fail_msg("%s %d, cosine %g: f %g, pdf %g", m[i].kind->name, i,
                         (double)cosines[j % 4], (double)lf_max3(f), (double)pdf);
        }
    }
}

static void a_wrong_roughness_is_rejected(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        lf_material m = material(i & 1 ? &lf_surface_plastic : &lf_surface_conductor,
                                 i & 2 ? 0.6f : 0.1f, 0.5f),
                    wrong = m;
        wrong.roughness *= 1.05f;
        lf_material_prepare(&wrong);
        setup s = {m, wrong, normals[1], at_cosine(normals[1], 0.25f, 2.0f)};
        assert_true(p_value(&s, NULL) < 1e-6);
    }
}

/* Mean and error of f / pdf: the share of light from wo that is reflected; and what eval says at
 * what sample drew. */
static lf_moments reflectance(const lf_material *m, lf_vec3 ns, lf_vec3 wo, int n_samples)
{
    lf_moments sum = {0};
    for (int i = 0; i < n_samples; i++) {
        lf_sampler s;
        float u[3];
        lf_vec3 wi, f, again;
        lf_sampler_init(&s, LF_SAMPLER_OWEN, lf_test_seed() + 3, (uint32_t)i);
        lf_sampler_2d(&s, u);
        u[2] = lf_sampler_1d(&s);
        float p = m->kind->sample(m, ns, wo, u, &wi, &f);
        assert_true(isfinite(p) && p >= 0.0f && isfinite(f.x) && f.x >= 0.0f);
        lf_moments_add(&sum, p > 0.0f ? (double)(f.x / p) : 0.0);
        if (p > 0.0f && lf_dot(wi, ns) > 1e-3f) {
            float q = m->kind->eval(m, ns, wo, wi, &again);
            assert_true(fabsf(q - p) < 0.02f * p && fabsf(again.x - f.x) <= 0.02f * f.x);
        }
    }
    return sum;
}

/* White furnace: nothing gives back more than it gets. */
static void no_surface_makes_energy(void **state)
{
    (void)state;
    lf_material m[max_materials];
    int n = make_materials(m);
    for (int i = 0; i < 2 * n; i++) {
        lf_material white = m[i % n];
        white.albedo = lf_v3(1.0f, 1.0f, 1.0f);
        white.ior = i < n ? 1.5f : 1.3f;
        lf_material_prepare(&white);
        for (int j = 0; j < 4 && !(white.anisotropy > 0.0f); j++) {
            lf_vec3 wo = at_cosine(normals[1], cosines[j], 1.0f);
            lf_moments r = reflectance(&white, normals[1], wo, 16384);
            double delta = 0.0;
            if (white.kind->deltas)
                delta = (double)delta_of(&white, normals[1], wo).x;
            if (r.mean + delta > 1.0 + 3e-4 + 4.0 * lf_moments_error(&r))
                fail_msg("%s, roughness %g, cosine %g: reflects %g", white.kind->name,
                         (double)white.roughness, (double)cosines[j], r.mean + delta);
        }
    }
}

/* E is that of a round lobe (surface_principled.c): what that comes to. */
static void grooves_make_little_energy_in_the_mean(void **state)
{
    (void)state;
    const float alphas[][2] = {{0.3f, 0.1f}, {0.5f, 0.25f}, {1.0f, 0.1f}};
    const double mean_off[] = {0.015, 0.01, 0.07}, most_off[] = {0.02, 0.04, 0.1};
    for (int a = 0; a < 3; a++)
        for (int j = 0; j < 4; j++) {
            lf_material white = anisotropic(1.0f, alphas[a][0], alphas[a][1], 0.0f);
            lf_moments mean = {0};
            white.albedo = lf_v3(1.0f, 1.0f, 1.0f);
            lf_material_prepare(&white);
            for (int k = 0; k < 8; k++) {
                lf_vec3 wo = at_cosine(normals[0], cosines[j], ((float)k + 0.5f) * LF_PI / 4.0f);
                lf_moments r = reflectance(&white, normals[0], wo, 4096);
                lf_moments_add(&mean, r.mean);
                if (!(fabs(r.mean - 1.0) < most_off[a]))
                    fail_msg("alphas %g, %g, cosine %g: reflects %g", (double)alphas[a][0],
                             (double)alphas[a][1], (double)cosines[j], r.mean);
            }
            if (!(fabs(mean.mean - 1.0) < mean_off[a]))
                fail_msg("alphas %g, %g, cosine %g: reflects %g in the mean", (double)alphas[a][0],
                         (double)alphas[a][1], (double)cosines[j], mean.mean);
        }
}

/* Seen from above, mirrored upwards: D / 4 of normals that are all upright, 1 / (4 pi ax ay).
 * Slopes of what is drawn spread by the two alphas along the two axes, of which the first is
 * turned. */
static void grooves_spread_along_their_direction(void **state)
{
    (void)state;
    const lf_vec3 n = normals[0];
    lf_material m = anisotropic(1.0f, 0.2f, 0.05f, LF_PI / 6.0f);
    lf_vec3 f, wi;
    float wide = 0.0f, narrow = 0.0f;
    m.albedo = lf_v3(1.0f, 1.0f, 1.0f);
    m.rest = lf_v3(0.0f, 0.0f, 0.0f);
    m.kind->eval(&m, n, n, n, &f);
    lf_assert_close((double)f.x, 0.25 / ((double)LF_PI * 0.2 * 0.05), 1e-4, 0);
    const int n_samples = 4096;
    int within[2] = {0};
    for (int i = 0; i < n_samples; i++) {
        float u[3];
        lf_sampler s;
        lf_sampler_init(&s, LF_SAMPLER_OWEN, lf_test_seed() + 5, (uint32_t)i);
        lf_sampler_2d(&s, u);
        u[2] = 0.5f;
        assert_true(m.kind->sample(&m, n, n, u, &wi, &f) > 0.0f);
        lf_vec3 h = lf_normalize(lf_add(wi, n));
        wide = (h.x * sqrtf(0.75f) + h.y * 0.5f) / h.z;
        narrow = (h.y * sqrtf(0.75f) - h.x * 0.5f) / h.z;
        within[0] += fabsf(wide) < 0.2f;
        within[1] += fabsf(narrow) < 0.05f;
    }
    /* one slope of GGX lies within its alpha with the probability 1 / sqrt 2, seen from above */
    for (int k = 0; k < 2; k++)
        lf_assert_close((double)within[k] / n_samples, sqrt(0.5), 0, 0.02);
}

/* Two equal alphas are the round lobe. */
static void even_grooves_are_none(void **state)
{
    (void)state;
    lf_material even = anisotropic(0.5f, 0.3f, 0.3f, 1.0f), none = even;
    none.anisotropy = 0.0f;
    none.anisotropic = (lf_anisotropy){0};
    lf_material_prepare(&none);
    for (int i = 0; i < 64; i++) {
        lf_vec3 f, g, wo = at_cosine(normals[1], 0.02f + 0.015f * (float)i, 0.3f * (float)i),
                      wi = at_cosine(normals[1], 1.0f - 0.014f * (float)i, 1.1f * (float)i);
        float p = even.kind->eval(&even, normals[1], wo, wi, &f),
              q = none.kind->eval(&none, normals[1], wo, wi, &g);
        lf_assert_close((double)p, (double)q, 1e-4, 1e-6);
        lf_assert_close((double)f.y, (double)g.y, 1e-4, 1e-6);
    }
}

static void white_surfaces_lose_little_when_smooth(void **state)
{
    (void)state;
    for (int j = 0; j < 3; j++) {
        lf_vec3 wo = at_cosine(normals[0], cosines[j], 0.0f);
        lf_material diffuse = material(&lf_surface_diffuse, 0.0f, 1.0f),
                    metal = material(&lf_surface_conductor, 0.2f, 1.0f);
        lf_material coated = material(&lf_surface_plastic, 0.0f, 1.0f);
        assert_true(fabs(reflectance(&diffuse, normals[0], wo, 4096).mean - 1.0) < 1e-4);
        assert_true(reflectance(&metal, normals[0], wo, 4096).mean > 0.98);
        double base = reflectance(&coated, normals[0], wo, 16384).mean;
        double coat = (double)delta_of(&coated, normals[0], wo).x;
        assert_true(fabs(base + coat - 1.0) < 5e-4);
    }
}

/* Metals are not, nor what becomes one with its index: surface_energy.c; nor is what lies below a
 * coat: surface_principled.c. */
static void surfaces_without_metal_are_reciprocal(void **state)
{
    (void)state;
    lf_material m[max_materials];
    int n = make_materials(m);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < 64 && m[i].kind != &lf_surface_conductor && m[i].metallic == 0.0f &&
                        m[i].coat == 0.0f && m[i].ior <= 3.0f;
             j++) {
            float a = 0.05f + 0.015f * (float)j, b = 1.0f - 0.014f * (float)j;
            lf_vec3 ns = normals[1], wo = at_cosine(ns, a, 0.3f), wi = at_cosine(ns, b, 3.4f), f, g;
            m[i].kind->eval(&m[i], ns, wo, wi, &f);
            m[i].kind->eval(&m[i], ns, wi, wo, &g);
            assert_true(fabsf(f.x / b - g.x / a) <= 2e-3f * (f.x / b) + 1e-6f);
        }
    }
}

/* 0.6 below and 0.5 above: the microfacet between them lies below the horizon, where there is none
 * but of a coat that leans. */
static void directions_below_the_surface_get_nothing(void **state)
{
    (void)state;
    lf_material m[max_materials];
    int n = make_materials(m);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < 3 && !(m[i].coat_normal.z > 0.0f); j++) {
            lf_vec3 f = {1.0f, 1.0f, 1.0f}, wi, ns = normals[1];
            lf_vec3 up = at_cosine(ns, 0.5f, 0.0f), down = at_cosine(ns, -0.6f, 2.0f);
            const float u[3] = {0.3f, 0.7f, 0.1f};
            const lf_surface_kind *lobes = m[i].kind;
            /* 0: both below, 1: wi below, 2: wo below, which is nothing to lobes that do not look
             * at wo */
            float p = lobes->eval(&m[i], ns, j & 1 ? up : down, j & 2 ? up : down, &f);
            bool dark = j < 2 || lobes->view_dependent;
            assert_true((p == 0.0f) == dark && (f.x == 0.0f) == dark && (f.y == 0.0f) == dark &&
                        (f.z == 0.0f) == dark);
            assert_true((lobes->sample(&m[i], ns, down, u, &wi, &f) == 0.0f) ==
                        lobes->view_dependent);
        }
    }
}

/* Every power of ten down to the smallest cosines, both ways, and the corners of the unit cube. */
static void grazing_directions_give_finite_values(void **state)
{
    (void)state;
    lf_material m[max_materials];
    int n = make_materials(m);
    for (int i = 0; i < n; i++) {
        const lf_surface_kind *ops = m[i].kind;
        for (int j = 0; j < 12 * 12; j++) {
            float co = powf(10.0f, -(float)(j % 12)), ci = powf(10.0f, -(float)(j / 12));
            lf_vec3 ns = normals[j % 2], wo = at_cosine(ns, co, 0.0f),
                    wi = at_cosine(ns, ci, LF_PI), f;
            float p = ops->eval(&m[i], ns, wo, wi, &f);
            assert_true(isfinite(p) && p >= 0.0f && isfinite(f.x) && f.x >= 0.0f);
            for (int k = 0; k < 8; k++) {
                const float end = 0x1.fffffep-1f,
                            u[3] = {k & 1 ? end : 0.0f, k & 2 ? end : 0.0f, k & 4 ? end : 0.0f};
                p = ops->sample(&m[i], ns, wo, u, &wi, &f);
                assert_true(isfinite(p) && p >= 0.0f && isfinite(f.x) && f.x >= 0.0f);
                assert_true(p == 0.0f || fabsf(lf_length(wi) - 1.0f) < 1e-5f);
            }
        }
    }
}

static void mirrors_are_delta_lobes_and_nothing_else(void **state)
{
    (void)state;
    lf_vec3 ns = normals[0], wo = at_cosine(ns, 0.6f, 0.0f), mirror = at_cosine(ns, 0.6f, LF_PI), f,
            wi;
    lf_material smooth = material(&lf_surface_conductor, 0.0f, 0.7f),
                rough = material(&lf_surface_conductor, 0.5f, 0.7f);
    const float u[3] = {0.5f, 0.5f, 0.5f};
    const lf_surface_kind *ops = &lf_surface_conductor;
    assert_true(ops->eval(&smooth, ns, wo, mirror, &f) == 0.0f && f.x == 0.0f);
    assert_true(ops->sample(&smooth, ns, wo, u, &wi, &f) == 0.0f);
    assert_true(fabsf(delta_of(&smooth, ns, wo).x - (0.7f + 0.3f * powf(0.4f, 5.0f))) < 1e-5f);
    assert_true(delta_of(&rough, ns, wo).x == 0.0f);
    assert_true(!smooth.has_lobe && smooth.has_delta);
    assert_true(rough.has_lobe && !rough.has_delta);
}

static void coat_reflects_by_fresnel(void **state)
{
    (void)state;
    lf_material coat = material(&lf_surface_plastic, 0.0f, 0.5f), none = coat,
                black = material(&lf_surface_plastic, 0.0f, 0.0f);
    none.ior = 1.0f;
    lf_material_prepare(&none);
    assert_true(fabsf(delta_of(&coat, normals[0], normals[0]).x - 0.04f) < 1e-6f);
    /* Brewster's angle, tan = 1.5: only the s half is reflected, ((1 - 2.25) / (1 + 2.25))^2 / 2.
     */
    assert_true(
        fabsf(delta_of(&coat, normals[0], at_cosine(normals[0], 1.0f / sqrtf(3.25f), 0.0f)).x -
              0.0739645f) < 1e-5f);
    assert_true(coat.has_lobe && coat.has_delta);
    assert_true(none.has_lobe && !none.has_delta);
    assert_true(!black.has_lobe && black.has_delta);
}

/* Without a coat's step in the index it is a diffuse surface. */
static void coat_of_index_one_is_not_there(void **state)
{
    (void)state;
    lf_material plastic = material(&lf_surface_plastic, 0.0f, 0.5f),
                diffuse = material(&lf_surface_diffuse, 0.0f, 0.5f);
    plastic.ior = 1.0f;
    lf_material_prepare(&plastic);
    lf_vec3 f, g, wo = at_cosine(normals[0], 0.4f, 0.0f), wi = at_cosine(normals[0], 0.8f, 2.0f);
    lf_surface_plastic.eval(&plastic, normals[0], wo, wi, &f);
    lf_surface_diffuse.eval(&diffuse, normals[0], wo, wi, &g);
    assert_true(fabsf(f.x / g.x - 1.0f) < 3e-4f);
}

/* Every instruction set answers the bits of plain C, which are in `fan`. */
static void assert_same_everywhere(const lf_material *m, lf_vec3 wi, int n, const float *const o[3],
                                   const lf_fan_lobes *fan)
{
    enum { most = 48 };
    float pdf_of[most], f_of[3][most];
    for (int i = 1; lf_kernels_at(i); i++) {
        lf_fan_lobes own = {.pdf = pdf_of, .f = {f_of[0], f_of[1], f_of[2]}};
        lf_kernels_at(i)->surfaces->of[m->kind->fan](m, wi, n, o[0], o[1], o[2], &own);
        assert_memory_equal(own.pdf, fan->pdf, sizeof *own.pdf * (size_t)n);
        for (int c = 0; c < 3; c++)
            assert_memory_equal(own.f[c], fan->f[c], sizeof *own.f[c] * (size_t)n);
    }
}

/* A fan of directions, some below the horizon, one in the mirror direction. */
static void fans_answer_as_single_directions_do(void **state)
{
    (void)state;
    enum { n = 48 };
    lf_material m[max_materials + 2];
    int n_materials = make_materials(m), compared = 0;
    m[n_materials++] = from_within(0.0f);
    m[n_materials++] = from_within(1.0f);
    for (int i = 0; i < n_materials; i++) {
        if (!m[i].kind->view_dependent)
            continue;
        m[i].albedo = lf_v3(0.9f * m[i].albedo.x, 0.5f * m[i].albedo.y, m[i].albedo.z);
        lf_material_prepare(&m[i]);
        for (int c = 0; c < 5; c++) {
            float x[n], y[n], z[n], pdf_of[n], f_of[3][n];
            lf_vec3 ns = lf_v3(0.0f, 0.0f, 1.0f),
                    wi = at_cosine(ns, c < 4 ? cosines[c] : -0.1f, 1.0f);
            lf_fan_lobes fan = {.pdf = pdf_of, .f = {f_of[0], f_of[1], f_of[2]}};
            for (int k = 0; k < n; k++) {
                lf_vec3 wo = k == 0 ? lf_v3(-wi.x, -wi.y, wi.z)
                                    : at_cosine(ns, 1.0f - (float)k / 40.0f, 0.3f * (float)k);
                x[k] = wo.x;
                y[k] = wo.y;
                z[k] = wo.z;
            }
            lf_surface_fans_c.of[m[i].kind->fan](&m[i], wi, n, x, y, z, &fan);
            assert_same_everywhere(&m[i], wi, n, (const float *[3]){x, y, z}, &fan);
            for (int k = 0; k < n; k++) {
                lf_vec3 f, g = {f_of[0][k], f_of[1][k], f_of[2][k]};
                float p = m[i].kind->eval(&m[i], ns, lf_v3(x[k], y[k], z[k]), wi, &f);
                lf_assert_close((double)pdf_of[k], (double)p, 1e-5, 1e-7);
                lf_assert_close((double)g.x, (double)f.x, 1e-5, 1e-7);
                lf_assert_close((double)g.y, (double)f.y, 1e-5, 1e-7);
                lf_assert_close((double)g.z, (double)f.z, 1e-5, 1e-7);
                compared += p > 0.0f;
            }
        }
    }
    assert_true(compared > 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samplers_follow_their_pdfs_which_integrate_to_one),
        cmocka_unit_test(what_is_reflected_can_be_drawn),
        cmocka_unit_test(a_wrong_roughness_is_rejected),
        cmocka_unit_test(no_surface_makes_energy),
        cmocka_unit_test(grooves_make_little_energy_in_the_mean),
        cmocka_unit_test(grooves_spread_along_their_direction),
        cmocka_unit_test(even_grooves_are_none),
        cmocka_unit_test(white_surfaces_lose_little_when_smooth),
        cmocka_unit_test(surfaces_without_metal_are_reciprocal),
        cmocka_unit_test(directions_below_the_surface_get_nothing),
        cmocka_unit_test(grazing_directions_give_finite_values),
        cmocka_unit_test(mirrors_are_delta_lobes_and_nothing_else),
        cmocka_unit_test(fans_answer_as_single_directions_do),
        cmocka_unit_test(coat_reflects_by_fresnel),
        cmocka_unit_test(coat_of_index_one_is_not_there),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
