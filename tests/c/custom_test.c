/* Materials, phase functions, lights and line integrals through callbacks: what volgrad_scene_init checks, what becomes of bad values, what
 * is refused without a gradient, and that copies of built-in kinds give the same images. */

#include "small_scene.h"

enum { IMAGE = 16, PASSES = 8, VALUES = 3 * IMAGE * IMAGE };
static const double TAU = 6.283185307179586;

/* Lambert's, with the numbers used as the library uses them. */
typedef struct paint { float albedo, bad; } paint;

/* What hits and vertices on the floor say. */
static const uint64_t FLOOR_USER = 0x1234567890abcdef;

static uint32_t points;

static void check_point(const volgrad_surface_point *at) {
    points++;
    CHECK(at->user == FLOOR_USER && at->z.y == 1 && at->z.x == 0 && at->z.z == 0);
    CHECK_NEAR(at->position.y, -1, 1e-5);
    CHECK_NEAR(at->x.y, 0, 1e-6);
    CHECK_NEAR(at->y.y, 0, 1e-6);
    CHECK_NEAR(at->x.z * at->y.x - at->x.x * at->y.z, 1, 1e-6); /* x cross y is z */
}

static void paint_eval(void *user, const volgrad_surface_point *at, volgrad_vec3 c, volgrad_vec3 l, volgrad_rgb *value) {
    const paint *p = user;
    (void)c, (void)l;
    check_point(at);
    value->r = value->g = value->b = p->bad != 0 ? p->bad : p->albedo * (float)(2 / TAU);
}

static float paint_pdf(void *user, const volgrad_surface_point *at, volgrad_vec3 c, volgrad_vec3 l) {
    (void)user, (void)c;
    check_point(at);
    return l.z * (float)(2 / TAU);
}

static int32_t paint_sample(void *user, const volgrad_surface_point *at, volgrad_vec3 c, const double *u, volgrad_vec3 *l, float *eta_squared) {
    (void)user, (void)c;
    check_point(at);
    double r = sqrt(u[0]), angle = TAU * u[1];
    CHECK(*eta_squared == 1 && u[0] > 0 && u[0] < 1 && u[1] >= 0 && u[1] < 1 && u[2] > 0 && u[2] < 1);
    *l = vec((float)(r * cos(angle)), (float)(r * sin(angle)), (float)sqrt(1 - u[0]));
    return 1;
}

static void paint_gradient(void *user, const volgrad_surface_point *at, volgrad_vec3 c, volgrad_vec3 l, volgrad_vec3 *by_c, volgrad_vec3 *by_l) {
    (void)user, (void)c, (void)l;
    check_point(at);
    CHECK(by_c[2].z == 0 && by_l[2].z == 0);
    by_c[0] = by_c[1] = by_c[2] = vec(0, 0, 1); /* of exp(c.z), to be told from nothing */
}

static void unasked_gradient(void *user, const volgrad_surface_point *at, volgrad_vec3 c, volgrad_vec3 l, volgrad_vec3 *by_c, volgrad_vec3 *by_l) {
    (void)user, (void)at, (void)c, (void)l;
    by_c[0].x = by_l[0].x = NAN;
}

/* Henyey-Greenstein. */
static double fog_eval(void *user, double mu) {
    double g = *(double *)user, d = 1 + g * g - 2 * g * mu;
    return (1 - g * g) / (2 * TAU * d * sqrt(d));
}

static double fog_sample(void *user, double u) {
    double g = *(double *)user, root = (1 - g * g) / (1 + g * (2 * u - 1));
    return fmax(-1, fmin(1, (1 + g * g - root * root) / (2 * g)));
}

static double fog_log_derivative(void *user, double mu) {
    double g = *(double *)user;
    return 3 * g / (1 + g * g - 2 * g * mu);
}

/* Sends nothing to the side: its logarithm has no derivative there. */
static double lobes_eval(void *user, double mu) {
    (void)user;
    return 1.5 * mu * mu / TAU;
}

static double lobes_sample(void *user, double u) {
    (void)user;
    return cbrt(2 * u - 1);
}

static double lobes_log_derivative(void *user, double mu) {
    (void)user;
    return 2 / mu;
}

/* A lamp alike in all directions; and a sky of radiance 1, looked for in the upper half more often. */
static void one(void *user, volgrad_vec3 direction, volgrad_rgb *value) {
    (void)direction;
    value->r = value->g = value->b = *(float *)user;
}

static float sky_pdf(void *user, volgrad_vec3 w) {
    (void)user;
    return (w.y > 0 ? 1.5f : 0.5f) / (float)(2 * TAU);
}

static int32_t sky_sample(void *user, const double *u, volgrad_vec3 *w) {
    (void)user;
    double y = u[0] < 0.75 ? u[0] / 0.75 : (0.75 - u[0]) / 0.25, r = sqrt(1 - y * y);
    *w = vec((float)(r * cos(TAU * u[1])), (float)y, (float)(r * sin(TAU * u[1])));
    return 1;
}

/* Density z/4, and its integrals. */
static void slope_density(void *user, const volgrad_vec3 *points, float *densities, uint32_t count) {
    (void)user;
    for (uint32_t i = 0; i < count; i++) densities[i] = 0.25f * points[i].z;
}

static void slope_gradient(void *user, const volgrad_vec3 *points, volgrad_vec3 *gradients, uint32_t count) {
    (void)user, (void)points;
    for (uint32_t i = 0; i < count; i++) gradients[i] = vec(0, 0, 0.25f);
}

static void slope_integrals(void *user, const volgrad_stretch *s, int32_t gradients, volgrad_density_integrals *result) {
    double length = s->end - s->start, middle = 0.5 * (s->start + s->end);
    (void)user;
    CHECK(result->density == 0 && s->start >= 0 && s->end >= s->start);
    result->density = 0.25 * length * (s->origin[2] + middle * s->direction[2]);
    if (gradients) result->gradient[2] = 0.25 * length, result->moment[2] = 0.25 * length * middle;
}

static paint floor_paint;
static double mean_cosine = 0.6;
static float unit = 1;
static small_scene s;
static volgrad_custom_bsdf bsdf;
static volgrad_custom_phase phase;
static const volgrad_custom_phase *phases[1];
static volgrad_custom_light light;
static volgrad_custom_density density;
static alignas(16) unsigned char memory[1 << 14];
static const volgrad_scene *scene;

/* Camera, fog, floor, lamp. */
static volgrad_vertex vertices[4];
static const volgrad_segment EDGES[] = {{INFINITY, 0, {0, 0, 0}}, {INFINITY, 0, {0, 0, 0}}, {INFINITY, 0, {0, 0, 0}}};
static const uint32_t ENDS[] = {1, 2, 3};
static const volgrad_path PATH = {vertices, EDGES, ENDS, 4, 3};

/* A floor in fog under a lamp and a sky, of built-in kinds. */
static void fill(void) {
    small_scene_fill(&s);
    floor_paint = (paint){0.5f, 0};
    bsdf = (volgrad_custom_bsdf){sizeof bsdf, 0, &floor_paint, paint_eval, paint_pdf, paint_sample, paint_gradient};
    phase = (volgrad_custom_phase){sizeof phase, 0, &mean_cosine, fog_eval, fog_sample, fog_log_derivative};
    light = (volgrad_custom_light){sizeof light, 0, &unit, one, sky_pdf, sky_sample, NULL};
    density = (volgrad_custom_density){sizeof density, 0, NULL, slope_density, slope_gradient, 0, 1, slope_integrals};
    phases[0] = &phase;
    s.desc.camera.width = s.desc.camera.height = s.desc.camera.crop_x1 = s.desc.camera.crop_y1 = IMAGE;
    s.media[0].sigma_t = (volgrad_rgb){0.1f, 0.2f, 0.3f};
    s.media[0].phase = (volgrad_phase){VOLGRAD_PHASE_HENYEY_GREENSTEIN, 0.6f};
    s.desc.bounds_radius = 4;
    const volgrad_vec3 up = vec(0, 1, 0);
    vertices[0] = (volgrad_vertex){VOLGRAD_VERTEX_CAMERA, 0, 0, vec(0, 0, 0), up, up, 0};
    vertices[1] = (volgrad_vertex){VOLGRAD_VERTEX_MEDIUM, 0, 0, vec(0, 0, 1), up, up, 0};
    vertices[2] = (volgrad_vertex){VOLGRAD_VERTEX_SURFACE, DIFFUSE, FLOOR_USER, vec(0.5f, -1, 2), up, up, 0};
    vertices[3] = (volgrad_vertex){VOLGRAD_VERTEX_LIGHT, POINT_LIGHT, 0, s.lights[POINT_LIGHT].position, up, up, 0};
}

static volgrad_status init(void) {
    return volgrad_scene_init(memory, sizeof memory, &s.desc, &scene, NULL);
}

static void custom_material(void) {
    s.materials[DIFFUSE].kind = VOLGRAD_MATERIAL_CUSTOM;
    s.materials[DIFFUSE].custom = &bsdf;
}

static void custom_phase(void) {
    s.media[0].phase.kind = VOLGRAD_PHASE_CUSTOM;
    s.desc.phases = phases;
    s.desc.phase_count = 1;
}

static void custom_light(int index, uint32_t kind) {
    s.lights[index].kind = kind;
    s.lights[index].custom = &light;
}

static void refuse(volgrad_status status, const char *name, const char *what, int line) {
    volgrad_error error = {sizeof error, 77, NULL};
    check_status(volgrad_scene_init(memory, sizeof memory, &s.desc, &scene, &error), status, what, __FILE__, line);
    int named = error.field != NULL && strcmp(error.field, name) == 0;
    check_that(named, what, __FILE__, line);
    if (!named) fprintf(stderr, "  blamed: %s %u\n", error.field ? error.field : "NULL", (unsigned)error.index);
    fill();
}

#define BAD(set, status, name) ((set), refuse((status), (name), #set, __LINE__))
#define BAD_BSDF(set, status, name) BAD((custom_material(), (set)), status, name)
#define BAD_PHASE(set, status, name) BAD((custom_phase(), (set)), status, name)
#define BAD_SKY(set, status, name) BAD((custom_light(SKY, VOLGRAD_LIGHT_CUSTOM_SKY), (set)), status, name)

static void test_descriptions(void) {
    const char *functions = "materials.custom.pdf, materials.custom.sample";
    custom_material(), custom_phase(), custom_light(SKY, VOLGRAD_LIGHT_CUSTOM_SKY), custom_light(POINT_LIGHT, VOLGRAD_LIGHT_CUSTOM_POINT);
    CHECK_STATUS(init(), VOLGRAD_OK);
    fill();
    BAD(s.materials[DIFFUSE].custom = &bsdf, VOLGRAD_ERROR_RANGE, "materials.custom");
    BAD_BSDF(s.materials[DIFFUSE].custom = NULL, VOLGRAD_ERROR_NULL, "materials.custom");
    BAD_BSDF(bsdf.struct_size = 40, VOLGRAD_ERROR_STRUCT_SIZE, "materials.custom");
    BAD_BSDF(bsdf.eval = NULL, VOLGRAD_ERROR_NULL, "materials.custom.eval");
    BAD_BSDF(bsdf.pdf = NULL, VOLGRAD_ERROR_NULL, functions);
    BAD_BSDF(bsdf.sample = NULL, VOLGRAD_ERROR_NULL, functions);
    BAD_BSDF((bsdf.flags = VOLGRAD_BSDF_LAMBERTIAN, bsdf.eval = NULL), VOLGRAD_ERROR_NULL, "materials.custom.eval");
    BAD_BSDF(bsdf.flags = 4, VOLGRAD_ERROR_KIND, "materials.custom.flags");
    BAD_BSDF(bsdf.flags = VOLGRAD_BSDF_TRANSMITS | VOLGRAD_BSDF_LAMBERTIAN, VOLGRAD_ERROR_KIND, "materials.custom.flags");
    BAD_BSDF(s.materials[DIFFUSE].flags = 2, VOLGRAD_ERROR_KIND, "materials.flags");
    BAD_BSDF((bsdf.flags = VOLGRAD_BSDF_TRANSMITS, s.materials[DIFFUSE].flags = VOLGRAD_MATERIAL_TWO_SIDED), VOLGRAD_ERROR_KIND, "materials.flags");
    BAD_PHASE(s.media[0].custom_phase = 1, VOLGRAD_ERROR_INDEX, "media.custom_phase");
    BAD_PHASE(phases[0] = NULL, VOLGRAD_ERROR_NULL, "phases");
    BAD_PHASE(s.desc.phases = NULL, VOLGRAD_ERROR_NULL, "phases");
    BAD_PHASE(phase.struct_size = 8, VOLGRAD_ERROR_STRUCT_SIZE, "phases");
    BAD_PHASE(phase.eval = NULL, VOLGRAD_ERROR_NULL, "phases.eval, phases.sample");
    BAD_PHASE(phase.sample = NULL, VOLGRAD_ERROR_NULL, "phases.eval, phases.sample");
    BAD(s.lights[SKY].custom = &light, VOLGRAD_ERROR_RANGE, "lights.custom");
    BAD_SKY(s.lights[SKY].custom = NULL, VOLGRAD_ERROR_NULL, "lights.custom");
    BAD_SKY(light.emission = NULL, VOLGRAD_ERROR_NULL, "lights.custom.emission");
    BAD_SKY(light.pdf = NULL, VOLGRAD_ERROR_NULL, "lights.custom.pdf, lights.custom.sample");
    BAD_SKY(light.sample = NULL, VOLGRAD_ERROR_NULL, "lights.custom.pdf, lights.custom.sample");
    BAD_SKY(s.lights[SKY].emission.g = -1, VOLGRAD_ERROR_RANGE, "lights.emission");
    BAD_SKY(s.lights[POINT_LIGHT].kind = VOLGRAD_LIGHT_ENVIRONMENT, VOLGRAD_ERROR_RANGE, "lights.kind");
    BAD((custom_light(POINT_LIGHT, VOLGRAD_LIGHT_CUSTOM_POINT), s.lights[POINT_LIGHT].sampling_weight = 0), VOLGRAD_ERROR_RANGE, "lights.sampling_weight");

    BAD(s.desc.reserved = 1, VOLGRAD_ERROR_RANGE, "reserved");
    BAD_PHASE(phase.reserved = 1, VOLGRAD_ERROR_RANGE, "phases.reserved");
    BAD_SKY(light.reserved = 1, VOLGRAD_ERROR_RANGE, "lights.custom.reserved");
    BAD((s.media[0].kind = VOLGRAD_MEDIUM_CUSTOM, s.media[0].custom = &density, density.reserved = 1), VOLGRAD_ERROR_RANGE, "media.custom.reserved");

    /* The struct as it was before it had phase functions. */
    s.desc.struct_size = offsetof(volgrad_scene_desc, phases);
    CHECK_STATUS(init(), VOLGRAD_OK);
    custom_phase();
    BAD((void)0, VOLGRAD_ERROR_INDEX, "media.custom_phase");
    volgrad_phase_value value;
    const volgrad_phase custom = {VOLGRAD_PHASE_CUSTOM, 0};
    REFUSED(value, volgrad_phase_eval(&custom, vec(1, 0, 0), vec(0, 1, 0), &value), VOLGRAD_ERROR_KIND);
}

/* The floor y = -1, seen from above; fog everywhere. */
static int32_t answer_floor(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count) {
    (void)user;
    for (uint32_t i = 0; i < count; i++) {
        float t = (-1 - rays[i].origin.y) / rays[i].direction.y;
        float x = rays[i].origin.x + t * rays[i].direction.x, z = rays[i].origin.z + t * rays[i].direction.z;
        int hit = t > 0 && t >= rays[i].t_min && t < rays[i].t_max && x * x + z * z < 9;
        hits[i] = (volgrad_hit){.kind = hit ? VOLGRAD_HIT_SURFACE : VOLGRAD_HIT_NONE, .material = DIFFUSE, .light = VOLGRAD_NONE,
            .segment_count = 1, .user = FLOOR_USER, .t = t, .normal = {0, 1, 0}, .shading_normal = {0, 1, 0}, .medium_outside = VOLGRAD_KEEP_MEDIUM,
            .medium_inside = VOLGRAD_KEEP_MEDIUM};
        hits[i].segments[0] = (volgrad_segment){.end = hit ? t : rays[i].t_max};
    }
    return 0;
}

static const volgrad_queries QUERIES = {sizeof QUERIES, 0, NULL, answer_floor, answer_floor};

typedef struct film { void *memory; volgrad_film *film; } film;

static film film_make(void) {
    film f;
    size_t bytes;
    CHECK_STATUS(volgrad_film_size(IMAGE, IMAGE, &bytes), VOLGRAD_OK);
    f.memory = aligned_alloc(16, (bytes + 15) / 16 * 16);
    CHECK_STATUS(volgrad_film_init(f.memory, bytes, IMAGE, IMAGE, &f.film), VOLGRAD_OK);
    return f;
}

static volgrad_status render(uint32_t mode, int bidirectional, float *image) {
    film f = film_make();
    volgrad_path_sampler_options paths;
    volgrad_bidirectional_options both;
    volgrad_status status = VOLGRAD_OK;
    CHECK_STATUS(volgrad_path_sampler_options_default(&paths, sizeof paths), VOLGRAD_OK);
    CHECK_STATUS(volgrad_bidirectional_options_default(&both, sizeof both), VOLGRAD_OK);
    paths.max_depth = both.max_length = 4;
    paths.shift.mode = both.shift.mode = mode;
    for (uint64_t pass = 0; pass < PASSES && status == VOLGRAD_OK; pass++) {
        status = bidirectional ? volgrad_bidirectional_run(scene, &QUERIES, &both, pass, 0, IMAGE * IMAGE, f.film, NULL)
                               : volgrad_path_sampler_run(scene, &QUERIES, &paths, pass, 0, IMAGE * IMAGE, f.film, NULL);
    }
    if (image != NULL) CHECK_STATUS(volgrad_film_develop(f.film, 1.0 / PASSES, image, VALUES), VOLGRAD_OK);
    free(f.memory);
    return status;
}

static double mean(const float *image) {
    double sum = 0;
    for (int i = 0; i < VALUES; i++) sum += image[i];
    return sum / VALUES;
}

static double difference(const float *a, const float *b) {
    double most = 0;
    for (int i = 0; i < VALUES; i++) most = fmax(most, fabs(a[i] - b[i]));
    return most / mean(a);
}

static uint64_t dropped_values(void) {
    uint64_t dropped = 1;
    CHECK_STATUS(volgrad_scene_dropped_values(scene, &dropped), VOLGRAD_OK);
    return dropped;
}

/* Single precision passes the border: some 1e-7 of each direction, which few bounces make more of. */
static void test_copies(void) {
    static float original[VALUES], copy[VALUES];
    const uint32_t modes[] = {VOLGRAD_SHIFT_NONE, VOLGRAD_SHIFT_LOG_LINEAR, VOLGRAD_SHIFT_NONE, VOLGRAD_SHIFT_EXCHANGEABLE, VOLGRAD_SHIFT_EXACT};
    for (int kind = 0; kind < 5; kind++) {
        for (int bidirectional = 0; bidirectional < 2; bidirectional++) {
            uint32_t mode = modes[kind]; /* links end at a custom floor that is Lambertian, at no other and no custom lamp */
            fill();
            CHECK_STATUS(init(), VOLGRAD_OK);
            CHECK_STATUS(render(mode, bidirectional, original), VOLGRAD_OK);
            if (kind == 0 || kind >= 3) custom_material();
            if (kind == 4) s.materials[DIFFUSE].flags = VOLGRAD_MATERIAL_TWO_SIDED;
            if (kind >= 3) bsdf = (volgrad_custom_bsdf){sizeof bsdf, VOLGRAD_BSDF_LAMBERTIAN, &floor_paint, paint_eval, NULL, NULL, NULL};
            if (kind == 1) custom_phase();
            if (kind == 2) custom_light(POINT_LIGHT, VOLGRAD_LIGHT_CUSTOM_POINT);
            CHECK_STATUS(init(), VOLGRAD_OK);
            CHECK_STATUS(render(mode, bidirectional, copy), VOLGRAD_OK);
            CHECK(mean(original) > 0.001);
            CHECK_NEAR(difference(original, copy), 0, 1e-3);
            CHECK(dropped_values() == 0);
        }
    }
    fill();
}

/* In a furnace of albedo 1 everything is as bright as the sky, whoever computes it. */
static void test_furnace(void) {
    static float image[VALUES];
    custom_material(), custom_phase(), custom_light(SKY, VOLGRAD_LIGHT_CUSTOM_SKY);
    floor_paint.albedo = 1;
    s.media[0].sigma_t = (volgrad_rgb){0, 0, 0};
    s.lights[0] = s.lights[SKY];
    s.desc.light_count = 1;
    CHECK_STATUS(init(), VOLGRAD_OK);
    CHECK_STATUS(render(VOLGRAD_SHIFT_EXCHANGEABLE, 0, image), VOLGRAD_OK);
    CHECK_NEAR(mean(image), 1, 0.03);
    fill();
}

/* What needs a derivative that is not there says so; what does not, goes on. */
static void test_without_gradients(void) {
    const uint32_t by_gradient[] = {VOLGRAD_SHIFT_FIRST_ORDER, VOLGRAD_SHIFT_HALF_ORDER, VOLGRAD_SHIFT_LOG_LINEAR};
    const uint32_t others[] = {VOLGRAD_SHIFT_NONE, VOLGRAD_SHIFT_EXACT, VOLGRAD_SHIFT_EXCHANGEABLE, VOLGRAD_SHIFT_TWO_LEVEL, VOLGRAD_SHIFT_LINEAR_DEPTH};
    custom_material(), custom_phase(), custom_light(POINT_LIGHT, VOLGRAD_LIGHT_CUSTOM_POINT);
    bsdf.log_gradient = NULL, phase.log_derivative = NULL;
    CHECK_STATUS(init(), VOLGRAD_OK);
    for (int bidirectional = 0; bidirectional < 2; bidirectional++) {
        for (int i = 0; i < 3; i++) CHECK_STATUS(render(by_gradient[i], bidirectional, NULL), VOLGRAD_ERROR_NO_GRADIENT);
        for (int i = 0; i < 5; i++) CHECK_STATUS(render(others[i], bidirectional, NULL), VOLGRAD_OK);
    }
    fill();

    volgrad_gradient plain, found;
    CHECK_STATUS(init(), VOLGRAD_OK);
    CHECK_STATUS(volgrad_path_log_gradient(scene, &PATH, 1, &plain), VOLGRAD_OK);
    custom_material(), custom_phase();
    CHECK_STATUS(init(), VOLGRAD_OK);
    CHECK_STATUS(volgrad_path_log_gradient(scene, &PATH, 1, &found), VOLGRAD_OK);
    CHECK_NEAR(found.phase_apex.x, plain.phase_apex.x, 1e-6);
    CHECK(plain.profile_next[0].y == 0 && fabsf(plain.phase_apex.x) > 0.1f);
    CHECK_NEAR(found.profile_next[0].y, 10 / 27.0, 1e-6); /* (I - ww^T) y / d for w = (1, -2, 2)/3, d = 3/2 */
    bsdf.log_gradient = NULL;
    CHECK_STATUS(init(), VOLGRAD_OK);
    REFUSED(found, volgrad_path_log_gradient(scene, &PATH, 1, &found), VOLGRAD_ERROR_NO_GRADIENT);
    bsdf.flags = VOLGRAD_BSDF_LAMBERTIAN;
    CHECK_STATUS(init(), VOLGRAD_OK);
    CHECK_STATUS(volgrad_path_log_gradient(scene, &PATH, 1, &found), VOLGRAD_OK);
    CHECK_NEAR(found.phase_apex.x, plain.phase_apex.x, 1e-6);
    CHECK(found.profile_next[0].y == 0);
    bsdf.flags = 0, bsdf.log_gradient = paint_gradient, phase.log_derivative = NULL;
    CHECK_STATUS(init(), VOLGRAD_OK);
    REFUSED(found, volgrad_path_log_gradient(scene, &PATH, 1, &found), VOLGRAD_ERROR_NO_GRADIENT);

    /* Batches of a path of the host's own. */
    volgrad_shift_options options;
    volgrad_splat splats[VOLGRAD_MAX_SHIFTS + 1];
    uint32_t count;
    CHECK_STATUS(volgrad_shift_options_default(&options, sizeof options), VOLGRAD_OK);
    options.mode = VOLGRAD_SHIFT_LOG_LINEAR;
    REFUSED(count, volgrad_shift_path(scene, &QUERIES, &options, &PATH, WHITE, 0, 0, splats, VOLGRAD_MAX_SHIFTS + 1, &count), VOLGRAD_ERROR_NO_GRADIENT);
    options.mode = VOLGRAD_SHIFT_EXCHANGEABLE;
    CHECK_STATUS(volgrad_shift_path(scene, &QUERIES, &options, &PATH, WHITE, 0, 0, splats, VOLGRAD_MAX_SHIFTS + 1, &count), VOLGRAD_OK);
    fill();
}

/* A path of the host's own that begins on the floor, which moves: what its vertex says comes back, and what hits say of the other members. */
static void test_surface_first(void) {
    static const uint32_t ends[] = {1, 2};
    const volgrad_vertex on_floor[] = {vertices[0], vertices[2], vertices[3]};
    const volgrad_path path = {on_floor, EDGES, ends, 3, 2};
    volgrad_shift_options options;
    volgrad_splat splats[VOLGRAD_MAX_SHIFTS + 1];
    uint32_t count = 0;
    custom_material();
    CHECK_STATUS(init(), VOLGRAD_OK);
    CHECK_STATUS(volgrad_shift_options_default(&options, sizeof options), VOLGRAD_OK);
    options.mode = VOLGRAD_SHIFT_EXCHANGEABLE;
    points = 0;
    CHECK_STATUS(volgrad_shift_path(scene, &QUERIES, &options, &path, WHITE, 0, 0, splats, VOLGRAD_MAX_SHIFTS + 1, &count), VOLGRAD_OK);
    CHECK(count > 3 && points >= count); /* its tile is cut by the image's border */
    fill();
}

/* Paths of chains have what the hits say. */
static void test_peeked_vertices(void) {
    enum { SAMPLES = 2000, LONGEST = 4, CHAINS = 64, ROOM = CHAINS + VOLGRAD_MAX_LENGTH };
    static alignas(16) unsigned char chain_memory[1 << 13];
    static float weights[SAMPLES];
    static volgrad_chain_start starts[ROOM];
    static volgrad_chain_techniques techniques;
    volgrad_chain_plan_result plan = {sizeof plan, 0, 0, 0};
    volgrad_chain_options options;
    volgrad_chain_mutation next = {.struct_size = sizeof next};
    volgrad_vertex current[LONGEST + 1], proposed[LONGEST + 1];
    volgrad_chain *chain;
    int surfaces = 0;
    custom_material();
    CHECK_STATUS(init(), VOLGRAD_OK);
    CHECK_STATUS(volgrad_chain_options_default(&options, sizeof options), VOLGRAD_OK);
    options.max_length = LONGEST;
    CHECK_STATUS(volgrad_chain_bootstrap(scene, &QUERIES, &options, NULL, 0, SAMPLES, weights, NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_chain_learn(&options, weights, SAMPLES, &techniques), VOLGRAD_OK);
    CHECK_STATUS(volgrad_chain_bootstrap(scene, &QUERIES, &options, &techniques, 0, SAMPLES, weights, NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_chain_plan(&options, &techniques, weights, SAMPLES, CHAINS, starts, ROOM, &plan), VOLGRAD_OK);
    for (uint32_t i = 0; i < plan.chain_count; i++) {
        CHECK_STATUS(volgrad_chain_init(chain_memory, sizeof chain_memory, scene, &QUERIES, &options, &techniques, &starts[i], NULL, &chain), VOLGRAD_OK);
        CHECK_STATUS(volgrad_chain_peek(chain, scene, &QUERIES, &next, current, proposed, LONGEST + 1), VOLGRAD_OK);
        for (uint32_t k = 0; k < next.current.vertex_count; k++) {
            int on_surface = current[k].kind == VOLGRAD_VERTEX_SURFACE;
            CHECK(current[k].user == (on_surface ? FLOOR_USER : 0));
            surfaces += on_surface;
        }
    }
    CHECK(surfaces > 3);
    fill();
}

/* Derivatives are asked for where there is light only. */
static void test_dark_paths(void) {
    volgrad_gradient found;
    char report[4096];
    size_t length;
    custom_material();
    floor_paint.albedo = 0;
    bsdf.log_gradient = unasked_gradient;
    CHECK_STATUS(init(), VOLGRAD_OK);
    REFUSED(found, volgrad_path_log_gradient(scene, &PATH, 1, &found), VOLGRAD_ERROR_ZERO_CONTRIBUTION);
    CHECK_STATUS(volgrad_path_report(scene, &PATH, report, sizeof report, &length), VOLGRAD_OK);
    CHECK(dropped_values() == 0);
    bsdf.log_gradient = NULL;
    CHECK_STATUS(init(), VOLGRAD_OK);
    REFUSED(found, volgrad_path_log_gradient(scene, &PATH, 1, &found), VOLGRAD_ERROR_ZERO_CONTRIBUTION);
    fill();

    custom_phase();
    phase = (volgrad_custom_phase){sizeof phase, 0, NULL, lobes_eval, lobes_sample, lobes_log_derivative};
    CHECK_STATUS(init(), VOLGRAD_OK);
    CHECK_STATUS(render(VOLGRAD_SHIFT_LOG_LINEAR, 0, NULL), VOLGRAD_OK);
    CHECK(dropped_values() == 0);
    fill();
}

static void test_misplaced(void) {
    for (int custom = 0; custom < 2; custom++) {
        if (custom) custom_light(POINT_LIGHT, VOLGRAD_LIGHT_CUSTOM_POINT);
        CHECK_STATUS(init(), VOLGRAD_OK);
        CHECK_STATUS(volgrad_path_validate(scene, &PATH, NULL), VOLGRAD_OK);
        vertices[3].position.x += 0.5f;
        CHECK_STATUS(volgrad_path_validate(scene, &PATH, NULL), VOLGRAD_ERROR_RANGE);
        fill();
    }
}

static void test_bad_values(void) {
    const float bad[] = {NAN, INFINITY, -1};
    static float image[VALUES];
    uint64_t dropped, before = 0;
    custom_material(), custom_light(SKY, VOLGRAD_LIGHT_CUSTOM_SKY);
    CHECK_STATUS(init(), VOLGRAD_OK);
    for (int i = 0; i < 3; i++) {
        floor_paint.bad = bad[i];
        CHECK_STATUS(render(VOLGRAD_SHIFT_EXCHANGEABLE, 0, image), VOLGRAD_OK);
        CHECK(isfinite(mean(image)) && mean(image) > 0);
        CHECK_STATUS(volgrad_scene_dropped_values(scene, &dropped), VOLGRAD_OK);
        CHECK(dropped > before);
        before = dropped;
    }
    floor_paint.bad = 0, unit = NAN;
    CHECK_STATUS(render(VOLGRAD_SHIFT_NONE, 1, image), VOLGRAD_OK);
    CHECK_STATUS(volgrad_scene_dropped_values(scene, &dropped), VOLGRAD_OK);
    CHECK(dropped > before && isfinite(mean(image)));
    REFUSED(dropped, volgrad_scene_dropped_values(NULL, &dropped), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_scene_dropped_values(scene, NULL), VOLGRAD_ERROR_NULL);
    unit = 1;
    fill();
}

/* tau of density z/4 from z = 0 on is z^2/8, at any step, and so is its inverse. */
static void test_integrals(void) {
    static const float box[12] = {2, 0, 0, -1, 0, 2, 0, -1, 0, 0, 4, 0};
    const volgrad_segment segment = {INFINITY, 0, {0, 0, 0}};
    const volgrad_line up = {{0, 0, -1}, {0, 0, 1}, 4, 1, &segment};
    volgrad_optical_depth depth;
    volgrad_flight flight;
    s.media[0].kind = VOLGRAD_MEDIUM_CUSTOM;
    s.media[0].custom = &density;
    s.media[0].sigma_t = WHITE;
    memcpy(s.media[0].local_to_world, box, sizeof box);
    CHECK_STATUS(init(), VOLGRAD_OK);
    CHECK_STATUS(volgrad_line_optical_depth(scene, &up, &depth), VOLGRAD_OK);
    CHECK_NEAR(depth.tau.r, 9 / 8.0, 1e-6);
    CHECK_NEAR(depth.end_gradient[0].z, 3 / 4.0, 1e-6);
    CHECK_STATUS(volgrad_line_sample_distance(scene, &up, 0.4, &flight), VOLGRAD_OK);
    CHECK_NEAR(flight.t, 1 + sqrt(-8 * log(0.6)), 1e-6);
    CHECK_NEAR(flight.pdf, 0.25 * (flight.t - 1) * 0.6, 1e-6);
    /* The struct as it was before it had integrals: panels, for which a step is needed. */
    density.struct_size = offsetof(volgrad_custom_density, integrals);
    CHECK_STATUS(init(), VOLGRAD_ERROR_RANGE);
    density.step = 0.1f;
    CHECK_STATUS(init(), VOLGRAD_OK);
    CHECK_STATUS(volgrad_line_optical_depth(scene, &up, &depth), VOLGRAD_OK);
    CHECK_NEAR(depth.tau.r, 9 / 8.0, 1e-6); /* linear along the line */
    fill();
}

int main(void) {
    fill();
    test_descriptions();
    test_copies();
    test_furnace();
    test_without_gradients();
    test_surface_first();
    test_peeked_vertices();
    test_dark_paths();
    test_misplaced();
    test_bad_values();
    test_integrals();
    return check_end();
}
