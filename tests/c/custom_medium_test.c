/* Media through callbacks: what volgrad_scene_init checks, and what the callbacks' values become. */

#include "open_queries.h"

/* Density z/4 in the box [-1, 1]^2 x [0, 4], the same as a host's function. */
typedef struct slope {
    float scale;   /* of the density */
    float bad;     /* if not 0: this instead, beyond z = 2 */
    uint32_t most; /* points in one call so far */
} slope;

static void slope_density(void *user, const volgrad_vec3 *points, float *densities, uint32_t count) {
    slope *s = user;
    if (count > s->most) s->most = count;
    for (uint32_t i = 0; i < count; i++) densities[i] = s->bad != 0 && points[i].z > 2 ? s->bad : s->scale * points[i].z;
}

static void slope_gradient(void *user, const volgrad_vec3 *points, volgrad_vec3 *gradients, uint32_t count) {
    slope *s = user;
    for (uint32_t i = 0; i < count; i++) gradients[i] = vec(0, 0, s->bad != 0 && points[i].z > 2 ? s->bad : s->scale);
}

static slope field;
static small_scene s;
static struct {
    volgrad_custom_density custom;
    unsigned char newer[8];
} custom;
static alignas(16) unsigned char memory[1 << 14];
static const volgrad_scene *scene;

static void fill(void) {
    static const float box[12] = {2, 0, 0, -1, 0, 2, 0, -1, 0, 0, 4, 0};
    memset(&custom, 0, sizeof custom);
    field = (slope){0.25f, 0, 0};
    custom.custom = (volgrad_custom_density){sizeof(volgrad_custom_density), 0, &field, slope_density, slope_gradient, 0.1f, 1, NULL};
    small_scene_fill(&s);
    s.media[0].kind = VOLGRAD_MEDIUM_CUSTOM;
    s.media[0].custom = &custom.custom;
    memcpy(s.media[0].local_to_world, box, sizeof box);
}

static volgrad_status init(volgrad_error *error) {
    return volgrad_scene_init(memory, sizeof memory, &s.desc, &scene, error);
}

static void refuse(volgrad_status status, const char *name, const char *what, int line) {
    volgrad_error error = {sizeof error, 77, NULL};
    check_status(init(&error), status, what, __FILE__, line);
    int named = error.field != NULL && strcmp(error.field, name) == 0 && error.index == 0;
    check_that(named, what, __FILE__, line);
    if (!named) fprintf(stderr, "  blamed: %s %u\n", error.field ? error.field : "NULL", (unsigned)error.index);
    fill();
}

#define BAD(set, status, name) ((set), refuse((status), (name), #set, __LINE__))

static void test_description(void) {
    volgrad_custom_density *c = &custom.custom;
    const char *functions = "media.custom.density, media.custom.gradient";
    size_t with, without;
    CHECK_STATUS(init(NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_scene_size(&s.desc, &with), VOLGRAD_OK);
    s.media[0].kind = VOLGRAD_MEDIUM_HOMOGENEOUS;
    CHECK_STATUS(volgrad_scene_size(&s.desc, &without), VOLGRAD_OK);
    CHECK(with > without && with <= without + 64); /* a table and a counter */
    BAD(s.media[0].kind = VOLGRAD_MEDIUM_HOMOGENEOUS, VOLGRAD_ERROR_RANGE, "media.custom");
    BAD(s.media[0].custom = NULL, VOLGRAD_ERROR_NULL, "media.custom");
    BAD(s.media[0].custom = memory + 1, VOLGRAD_ERROR_MISALIGNED, "media.custom");
    BAD(c->struct_size = 0, VOLGRAD_ERROR_STRUCT_SIZE, "media.custom");
    BAD(c->struct_size = sizeof *c - 1, VOLGRAD_ERROR_STRUCT_SIZE, "media.custom");
    BAD((c->struct_size = sizeof custom, custom.newer[7] = 1), VOLGRAD_ERROR_STRUCT_SIZE, "media.custom");
    BAD(c->density = NULL, VOLGRAD_ERROR_NULL, functions);
    BAD(c->gradient = NULL, VOLGRAD_ERROR_NULL, functions);
    BAD(c->step = 0, VOLGRAD_ERROR_RANGE, "media.custom.step");
    BAD(c->step = -1, VOLGRAD_ERROR_RANGE, "media.custom.step");
    BAD(c->step = 1e-6f, VOLGRAD_ERROR_RANGE, "media.custom.step");
    BAD(c->step = NAN, VOLGRAD_ERROR_NOT_FINITE, "media.custom.step");
    BAD(c->majorant = -1, VOLGRAD_ERROR_RANGE, "media.custom.majorant");
    BAD(c->majorant = INFINITY, VOLGRAD_ERROR_NOT_FINITE, "media.custom.majorant");
    BAD(s.media[0].local_to_world[10] = 0, VOLGRAD_ERROR_RANGE, "media.local_to_world");
    c->struct_size = sizeof custom; /* newer, with nothing new set */
    CHECK_STATUS(init(NULL), VOLGRAD_OK);
    fill();
}

/* A density that is linear along a line is integrated exactly at any step. */
static void test_line(void) {
    volgrad_segment segment = {INFINITY, 0, {0, 0, 0}};
    const volgrad_line up = {{0, 0, -1}, {0, 0, 1}, 3, 1, &segment}, down = {{0, 0, 2}, {0, 0, -1}, 3, 1, &segment};
    volgrad_optical_depth there, back;
    CHECK_STATUS(init(NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_line_optical_depth(scene, &up, &there), VOLGRAD_OK);
    CHECK_STATUS(volgrad_line_optical_depth(scene, &down, &back), VOLGRAD_OK);
    CHECK_NEAR(there.tau.r, 0.5, 1e-6);
    CHECK_NEAR(back.tau.r, 0.5, 1e-6);
    CHECK_NEAR(there.end_gradient[0].z, 0.5, 1e-6);
    CHECK_NEAR(back.origin_gradient[0].z, 0.5, 1e-6);
    CHECK(field.most > 1 && field.most <= 64);

    volgrad_flight flight;
    for (int i = 1; i < 4; i++) {
        volgrad_line part = up;
        double u = i / 10.0, again = 0;
        CHECK_STATUS(volgrad_line_sample_distance(scene, &up, u, &flight), VOLGRAD_OK);
        CHECK(flight.medium == 0);
        CHECK_NEAR(flight.t, 1 + sqrt(-8 * log(1 - u)), 1e-6);
        CHECK_NEAR(flight.pdf, 0.25 * (flight.t - 1) * (1 - u), 1e-6);
        part.length = flight.t;
        CHECK_STATUS(volgrad_line_invert_distance(scene, &part, &again), VOLGRAD_OK);
        CHECK_NEAR(again, u, 1e-6);
    }

    const float bad[] = {NAN, INFINITY, -INFINITY, -1};
    uint64_t dropped = 1, before = 0;
    CHECK_STATUS(volgrad_scene_dropped_densities(scene, &dropped), VOLGRAD_OK);
    CHECK(dropped == 0);
    REFUSED(dropped, volgrad_scene_dropped_densities(NULL, &dropped), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_scene_dropped_densities(scene, NULL), VOLGRAD_ERROR_NULL);
    volgrad_line beyond = up;
    beyond.length = 5; /* through all of the box */
    for (int i = 0; i < 4; i++) {
        field.bad = bad[i];
        CHECK_STATUS(volgrad_line_optical_depth(scene, &beyond, &there), VOLGRAD_OK);
        CHECK_NEAR(there.tau.r, 0.5, 0.05); /* nothing beyond z = 2, but for one panel */
        CHECK(isfinite(there.end_gradient[0].z) && isfinite(there.origin_gradient[0].z));
        /* The ends of 20 panels of 0.1 are beyond, some asked for twice: their densities, and gradients if those are not finite. */
        CHECK_STATUS(volgrad_scene_dropped_densities(scene, &dropped), VOLGRAD_OK);
        uint64_t kinds = isfinite(bad[i]) ? 1 : 2;
        CHECK(dropped >= before + 20 * kinds && dropped <= before + 22 * kinds);
        before = dropped;
    }
    fill();
}

/* A guided scene asks the same callbacks. */
static void test_guided(void) {
    size_t film_bytes, bytes;
    uint32_t width, height;
    volgrad_film *film;
    const volgrad_scene *guided;
    CHECK_STATUS(init(NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_guide_film_size(scene, &width, &height), VOLGRAD_OK);
    CHECK_STATUS(volgrad_film_size(width, height, &film_bytes), VOLGRAD_OK);
    CHECK_STATUS(volgrad_guide_size(scene, &bytes), VOLGRAD_OK);
    void *film_memory = aligned_alloc(16, (film_bytes + 15) / 16 * 16), *guide_memory = aligned_alloc(16, (bytes + 15) / 16 * 16);
    CHECK_STATUS(volgrad_film_init(film_memory, film_bytes, width, height, &film), VOLGRAD_OK);
    CHECK_STATUS(volgrad_guide_init(guide_memory, bytes, scene, film, &guided), VOLGRAD_OK);

    volgrad_segment segment = {INFINITY, 0, {0, 0, 0}};
    const volgrad_line line = {{0, 0, -1}, {0, 0, 1}, 5, 1, &segment};
    volgrad_optical_depth depth;
    uint64_t of_guided = 0, of_both = 0;
    field.bad = NAN;
    CHECK_STATUS(volgrad_line_optical_depth(guided, &line, &depth), VOLGRAD_OK);
    CHECK_STATUS(volgrad_scene_dropped_densities(guided, &of_guided), VOLGRAD_OK);
    CHECK_STATUS(volgrad_line_optical_depth(scene, &line, &depth), VOLGRAD_OK);
    CHECK_STATUS(volgrad_scene_dropped_densities(scene, &of_both), VOLGRAD_OK);
    CHECK(of_guided > 0 && of_both == 2 * of_guided);
    free(guide_memory);
    free(film_memory);
    fill();
}

/* All densities at once, by paths: in a furnace of albedo 1 every pixel sees the sky. */
static void test_furnace(void) {
    open_queries open;
    void *film_memory;
    size_t bytes;
    volgrad_film *film;
    volgrad_path_sampler_options options;
    static float image[3 * 8 * 8];
    s.media[0].albedo = WHITE;
    s.desc.camera.width = s.desc.camera.height = s.desc.camera.crop_x1 = s.desc.camera.crop_y1 = 8;
    s.desc.camera.position = vec(0, 0, -2), s.desc.camera.tan_half_fov_x = 0.4f;
    s.lights[POINT_LIGHT] = s.lights[SKY];
    s.desc.light_count = 1;
    CHECK_STATUS(init(NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_film_size(8, 8, &bytes), VOLGRAD_OK);
    film_memory = aligned_alloc(16, (bytes + 15) / 16 * 16);
    CHECK_STATUS(volgrad_film_init(film_memory, bytes, 8, 8, &film), VOLGRAD_OK);
    CHECK_STATUS(volgrad_path_sampler_options_default(&options, sizeof options), VOLGRAD_OK);
    options.shift.mode = VOLGRAD_SHIFT_EXCHANGEABLE;
    const volgrad_queries *queries = queries_answer(&open, FOG, 0, FOG);
    for (uint64_t pass = 0; pass < 200; pass++) {
        CHECK_STATUS(volgrad_path_sampler_run(scene, queries, &options, pass, 0, 64, film, NULL), VOLGRAD_OK);
    }
    CHECK_STATUS(volgrad_film_develop(film, 1.0 / 200, image, 3 * 64), VOLGRAD_OK);
    double sum = 0;
    for (int i = 0; i < 64; i++) sum += image[3 * i];
    CHECK_NEAR(sum / 64, 1, 0.02);
    free(film_memory);
    fill();
}

int main(void) {
    fill();
    test_description();
    test_line();
    test_guided();
    test_furnace();
    return check_end();
}
