/* What a host of the fuzzers computes itself: densities, phase functions, materials and lights that are right, or whose values are none,
 * or not twice the same. Part of api.h. */

#ifndef API_HOST_H
#define API_HOST_H

static const double TURN = 6.283185307179586;

/* Of 256 values so many are nonsense; state of the random numbers that decide. */
typedef struct habit {
    float shape;
    int transmits;
    uint32_t nonsense;
    uint32_t random;
} habit;

static inline habit decode_habit(input *in, world *w) {
    habit h = {number(in, -0.9f, 0.9f), 0, pick(in, 3) ? 0 : pick(in, 128), next_byte(in)};
    w->lies |= h.nonsense != 0;
    return h;
}

static inline double habitual(habit *h, double value) {
    static const double odd[] = {NAN, INFINITY, -INFINITY, 0, -0.0, -1, 1, 1e-45, 1e-310, 1e-20, 3.4e38, 1e300, 2};
    h->random = h->random * 1664525u + 1013904223u;
    if ((h->random >> 8) % 256 >= h->nonsense) return value;
    return odd[(h->random >> 16) % (sizeof odd / sizeof *odd)];
}

static inline volgrad_vec3 habitual_vector(habit *h, double x, double y, double z) {
    double scale = habitual(h, 1); /* 0 now and then */
    volgrad_vec3 v = {(float)(scale * habitual(h, x)), (float)(scale * habitual(h, y)), (float)(scale * habitual(h, z))};
    return v;
}

static inline volgrad_rgb habitual_colour(habit *h, double value) {
    volgrad_rgb c = {(float)habitual(h, value), (float)habitual(h, value), (float)habitual(h, value)};
    return c;
}

/* ---- a density, waves: may be NaN or negative ---- */

typedef struct waves {
    float bend[4];
    habit habit;
} waves;

static inline float density_of(const float *bend, volgrad_vec3 p) {
    return bend[3] * (1 + sinf(bend[0] * p.x) * sinf(bend[1] * p.y) * sinf(bend[2] * p.z));
}

static inline volgrad_vec3 density_gradient_of(const float *bend, volgrad_vec3 p) {
    volgrad_vec3 gradient = {bend[3] * bend[0] * cosf(bend[0] * p.x) * sinf(bend[1] * p.y) * sinf(bend[2] * p.z),
        bend[3] * bend[1] * sinf(bend[0] * p.x) * cosf(bend[1] * p.y) * sinf(bend[2] * p.z),
        bend[3] * bend[2] * sinf(bend[0] * p.x) * sinf(bend[1] * p.y) * cosf(bend[2] * p.z)};
    return gradient;
}

static inline void densities(void *user, const volgrad_vec3 *points, float *values, uint32_t count) {
    waves *w = user;
    for (uint32_t i = 0; i < count; i++) values[i] = (float)habitual(&w->habit, density_of(w->bend, points[i]));
}

static inline void density_gradients(void *user, const volgrad_vec3 *points, volgrad_vec3 *values, uint32_t count) {
    waves *w = user;
    for (uint32_t i = 0; i < count; i++) {
        volgrad_vec3 g = density_gradient_of(w->bend, points[i]);
        values[i] = habitual_vector(&w->habit, g.x, g.y, g.z);
    }
}

/* By the midpoint rule: some per cent off, so that the density's slope is not quite what the integrals say. */
static inline void density_integrals(void *user, const volgrad_stretch *s, int32_t gradients, volgrad_density_integrals *result) {
    enum { STEPS = 8 };
    waves *w = user;
    MUST(result->density == 0 && s->start >= 0 && s->end >= s->start && isfinite(s->end));
    for (int i = 0; i < STEPS; i++) {
        double width = (s->end - s->start) / STEPS, t = s->start + (i + 0.5) * width;
        volgrad_vec3 p = {(float)(s->origin[0] + t * s->direction[0]), (float)(s->origin[1] + t * s->direction[1]),
            (float)(s->origin[2] + t * s->direction[2])};
        result->density += width * density_of(w->bend, p);
        if (!gradients) continue;
        volgrad_vec3 g = density_gradient_of(w->bend, p);
        const double by[3] = {g.x, g.y, g.z};
        for (int k = 0; k < 3; k++) result->gradient[k] += width * by[k], result->moment[k] += width * t * by[k];
    }
    result->density = habitual(&w->habit, result->density);
    for (int k = 0; k < 3 && gradients; k++) {
        result->gradient[k] = habitual(&w->habit, result->gradient[k]), result->moment[k] = habitual(&w->habit, result->moment[k]);
    }
}

/* ---- a phase function: Henyey and Greenstein's ---- */

static inline double phase_value(void *user, double mu) {
    habit *h = user;
    double g = h->shape, d = 1 + g * g - 2 * g * mu;
    return habitual(h, (1 - g * g) / (2 * TURN * d * sqrt(d)));
}

static inline double phase_cosine(void *user, double u) {
    habit *h = user;
    double g = h->shape, root = (1 - g * g) / (1 + g * (2 * u - 1));
    MUST(u > 0 && u < 1);
    return habitual(h, g * g < 1e-6 ? 2 * u - 1 : (1 + g * g - root * root) / (2 * g)); /* rounded beyond 1 at times */
}

static inline double phase_slope(void *user, double mu) {
    habit *h = user;
    double g = h->shape;
    return habitual(h, 3 * g / (1 + g * g - 2 * g * mu));
}

/* ---- a material: diffuse, alike on both sides if it transmits ---- */

/* What all hits and vertices say of surfaces. */
#define SAID UINT64_C(0xfedcba9876543210)

static inline void bsdf_value(void *user, const volgrad_surface_point *at, volgrad_vec3 to_camera, volgrad_vec3 to_light,
                              volgrad_rgb *value) {
    habit *h = user;
    MUST(at->user == SAID); /* not that it is a frame: normals of paths that are not valid are anything */
    MUST(value->r == 0 && (h->transmits || (to_camera.z > 0 && to_light.z > 0)));
    *value = habitual_colour(h, fabsf(h->shape) * 2 / TURN);
}

static inline float bsdf_pdf(void *user, const volgrad_surface_point *at, volgrad_vec3 to_camera, volgrad_vec3 to_light) {
    habit *h = user;
    MUST(at->user == SAID);
    MUST(h->transmits || (to_camera.z > 0 && to_light.z > 0));
    return (float)habitual(h, fabsf(to_light.z) * (h->transmits ? 1 : 2) / TURN);
}

static inline int32_t bsdf_sample(void *user, const volgrad_surface_point *at, volgrad_vec3 to_camera, const double *u,
                                  volgrad_vec3 *to_light, float *eta_squared) {
    habit *h = user;
    (void)to_camera;
    MUST(at->user == SAID);
    MUST(*eta_squared == 1 && u[0] > 0 && u[0] < 1 && u[1] > 0 && u[1] < 1 && u[2] > 0 && u[2] < 1);
    double r = sqrt(u[0]), z = sqrt(1 - u[0]);
    *to_light = habitual_vector(h, r * cos(TURN * u[1]), r * sin(TURN * u[1]), h->transmits && u[2] < 0.5 ? -z : z);
    *eta_squared = (float)habitual(h, 1);
    return habitual(h, 1) != 0;
}

static inline void bsdf_gradient(void *user, const volgrad_surface_point *at, volgrad_vec3 to_camera, volgrad_vec3 to_light,
                                 volgrad_vec3 *by_camera, volgrad_vec3 *by_light) {
    habit *h = user;
    (void)to_camera, (void)to_light;
    MUST(at->user == SAID);
    for (int i = 0; i < 3; i++) by_camera[i] = habitual_vector(h, 0, 0, 0), by_light[i] = habitual_vector(h, 0, 0, 0);
}

/* ---- lights: brighter upwards, looked for in all directions alike ---- */

static inline void light_emission(void *user, volgrad_vec3 direction, volgrad_rgb *value) {
    habit *h = user;
    MUST(value->r == 0);
    *value = habitual_colour(h, 1 + h->shape * direction.y);
}

static inline float sky_pdf(void *user, volgrad_vec3 to_sky) {
    (void)to_sky;
    return (float)habitual(user, 0.5 / TURN);
}

static inline int32_t sky_sample(void *user, const double *u, volgrad_vec3 *to_sky) {
    MUST(u[0] > 0 && u[0] < 1 && u[1] > 0 && u[1] < 1);
    double y = 1 - 2 * u[0], r = sqrt(1 - y * y);
    *to_sky = habitual_vector(user, r * cos(TURN * u[1]), y, r * sin(TURN * u[1]));
    return habitual(user, 1) != 0;
}

static inline void light_gradient(void *user, volgrad_vec3 direction, volgrad_vec3 *gradient) {
    habit *h = user;
    double slope = h->shape / (1 + h->shape * direction.y);
    for (int i = 0; i < 3; i++) gradient[i] = habitual_vector(h, 0, slope, 0);
}

#endif
