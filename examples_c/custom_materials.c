/* A scene in which the host computes everything that light meets: a rough floor of tiles (Oren-Nayar), a ball of air (Rayleigh), a sky and a
 * lamp with a profile. Two samplers that use the callbacks in different ways agree on it; that is the test for callbacks of your own.
 * cc -std=c99 -Iinclude examples_c/custom_materials.c libvolgrad.a -lm -lpthread -ldl -lgcc_s */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <volgrad.h>

enum { WIDTH = 64, HEIGHT = 32, PASSES = 64 };
static const float PI = 3.14159265f;

static void check(volgrad_status status)
{
    if (status == VOLGRAD_OK) return;
    fprintf(stderr, "custom_materials: %s\n", volgrad_status_message(status));
    exit(EXIT_FAILURE);
}

/* The floor's BSDF in its own frame, z being the normal. What the hit said of the point comes with it: here which tile it is on; it could
 * be a triangle's number, to find a texture's coordinates with. M. Oren, S. Nayar, Generalization of Lambert's Reflectance Model, 1994. */
static void paint_eval(void *user, const volgrad_surface_point *at, volgrad_vec3 c, volgrad_vec3 l, volgrad_rgb *value)
{
    static const volgrad_rgb tiles[2] = { { 0.8f, 0.7f, 0.6f }, { 0.2f, 0.25f, 0.3f } };
    volgrad_rgb tile = tiles[at->user & 1];
    const float *sigma = user, s2 = *sigma * *sigma;
    float sine_c = sqrtf(fmaxf(0, 1 - c.z * c.z)), sine_l = sqrtf(fmaxf(0, 1 - l.z * l.z));
    float across = fmaxf(0, c.x * l.x + c.y * l.y); /* both sines times the cosine between the azimuths */
    float slope = sine_c > 0 && sine_l > 0 ? across / fmaxf(c.z, l.z) : 0;
    float f = (1 - s2 / (2 * (s2 + 0.33f)) + 0.45f * s2 / (s2 + 0.09f) * slope) / PI;
    *value = (volgrad_rgb){ tile.r * f, tile.g * f, tile.b * f };
}

static float paint_pdf(void *user, const volgrad_surface_point *at, volgrad_vec3 c, volgrad_vec3 l)
{
    (void)user, (void)at, (void)c;
    return l.z / PI;
}

static int32_t paint_sample(void *user, const volgrad_surface_point *at, volgrad_vec3 c, const double *u, volgrad_vec3 *l, float *eta_squared)
{
    (void)user, (void)at, (void)c, (void)eta_squared; /* nothing is refracted */
    float r = sqrtf((float)u[0]), angle = 2 * PI * (float)u[1];
    *l = (volgrad_vec3){ r * cosf(angle), r * sinf(angle), sqrtf(1 - (float)u[0]) };
    return 1;
}

/* Air: 3/(16 pi) (1 + mu^2). Its integral from -1 is a cubic in mu, whose root Cardano knows. */
static double air_eval(void *user, double mu)
{
    (void)user;
    return 3 / (16 * (double)PI) * (1 + mu * mu);
}

static double air_sample(void *user, double u)
{
    (void)user;
    double q = 4 * u - 2, root = cbrt(q + sqrt(q * q + 1));
    return root - 1 / root;
}

static double air_log_derivative(void *user, double mu)
{
    (void)user;
    return 2 * mu / (1 + mu * mu);
}

/* A sky that is white at the horizon and blue above; nothing comes from below. */
static void sky_radiance(void *user, volgrad_vec3 w, volgrad_rgb *value)
{
    (void)user;
    if (w.y > 0) *value = (volgrad_rgb){ 0.5f - 0.4f * w.y, 0.5f - 0.2f * w.y, 0.6f };
}

static float sky_pdf(void *user, volgrad_vec3 w)
{
    (void)user;
    return w.y > 0 ? 1 / (2 * PI) : 0;
}

static int32_t sky_sample(void *user, const double *u, volgrad_vec3 *w)
{
    (void)user;
    float y = (float)u[0], r = sqrtf(1 - y * y), angle = 2 * PI * (float)u[1];
    *w = (volgrad_vec3){ r * cosf(angle), y, r * sinf(angle) };
    return 1;
}

/* A lamp that shines downwards, in a wide lobe. */
static void lamp_intensity(void *user, volgrad_vec3 w, volgrad_rgb *value)
{
    (void)user;
    float lobe = w.y < 0 ? w.y * w.y : 0;
    *value = (volgrad_rgb){ lobe, 0.8f * lobe, 0.5f * lobe };
}

/* The floor, a disc of radius 4 at y = 0, and a ball of air of radius 1 above it that bends no light. */
static int32_t look(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    (void)user;
    for (uint32_t i = 0; i < count; i++) {
        volgrad_vec3 o = rays[i].origin, d = rays[i].direction;
        volgrad_hit *hit = &hits[i];
        float end = rays[i].t_max, t = -o.y / d.y;
        *hit = (volgrad_hit){ .kind = VOLGRAD_HIT_NONE, .light = VOLGRAD_NONE, .normal = { 0, 1, 0 }, .shading_normal = { 0, 1, 0 },
            .medium_outside = VOLGRAD_KEEP_MEDIUM, .medium_inside = VOLGRAD_KEEP_MEDIUM };
        float x = o.x + t * d.x, z = o.z + t * d.z;
        if (t > 0 && t >= rays[i].t_min && t < end && x * x + z * z < 16) {
            hit->kind = VOLGRAD_HIT_SURFACE;
            hit->t = end = t;
            hit->user = (uint64_t)((int)floorf(2 * x) + (int)floorf(2 * z)) & 1;
        }
        float b = o.x * d.x + (o.y - 1) * d.y + o.z * d.z, c = o.x * o.x + (o.y - 1) * (o.y - 1) + o.z * o.z - 1;
        float root = b * b - c > 0 ? sqrtf(b * b - c) : 0, ends[3] = { fminf(-b - root, end), fminf(-b + root, end), end };
        for (int j = 0; j < 3; j++) {
            volgrad_vec3 normal = { o.x + ends[j] * d.x, o.y + ends[j] * d.y - 1, o.z + ends[j] * d.z }; /* of the ball */
            volgrad_segment segment = { .end = ends[j], .medium = j == 1 ? 0 : VOLGRAD_NONE, .normal = normal };
            if (ends[j] > 0) hit->segments[hit->segment_count++] = segment;
        }
    }
    return 0;
}

static volgrad_film *film_in(void **memory)
{
    size_t bytes;
    volgrad_film *film;
    check(volgrad_film_size(WIDTH, HEIGHT, &bytes));
    *memory = malloc(bytes);
    check(volgrad_film_init(*memory, bytes, WIDTH, HEIGHT, &film));
    return film;
}

static double show(const char *sampler, const volgrad_film *film, int picture)
{
    static float image[3 * WIDTH * HEIGHT];
    double sum = 0;
    check(volgrad_film_develop(film, 1.0 / PASSES, image, 3 * WIDTH * HEIGHT));
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) sum += image[i];
    for (int y = 0; picture && y < HEIGHT; y += 2) { /* characters are twice as high as wide */
        for (int x = 0; x < WIDTH; x++) {
            float value = 0.5f * (image[3 * (y * WIDTH + x)] + image[3 * ((y + 1) * WIDTH + x)]);
            putchar(" .:-=+*#%@"[value < 1 ? (int)(9.99f * value) : 9]);
        }
        putchar('\n');
    }
    printf("%s: mean %.3f\n", sampler, sum / (3 * WIDTH * HEIGHT));
    return sum;
}

int main(void)
{
    float roughness = 0.5f;
    volgrad_custom_bsdf paint = { .struct_size = sizeof paint, .user = &roughness,
        .eval = paint_eval, .pdf = paint_pdf, .sample = paint_sample };
    volgrad_custom_phase rayleigh = { .struct_size = sizeof rayleigh,
        .eval = air_eval, .sample = air_sample, .log_derivative = air_log_derivative };
    volgrad_custom_light heaven = { .struct_size = sizeof heaven, .emission = sky_radiance, .pdf = sky_pdf, .sample = sky_sample };
    volgrad_custom_light shade = { .struct_size = sizeof shade, .emission = lamp_intensity };

    const volgrad_custom_phase *phases[] = { &rayleigh };
    volgrad_material floor = { .kind = VOLGRAD_MATERIAL_CUSTOM, .custom = &paint };
    volgrad_medium air = { .kind = VOLGRAD_MEDIUM_HOMOGENEOUS, .phase = { .kind = VOLGRAD_PHASE_CUSTOM }, .custom_phase = 0,
        .sigma_t = { 0.5f, 1, 2 }, .albedo = { 0.99f, 0.99f, 0.99f } };
    volgrad_light lights[] = {
        { .kind = VOLGRAD_LIGHT_CUSTOM_SKY, .emission = { 1, 1, 1 }, .sampling_weight = 1, .custom = &heaven },
        { .kind = VOLGRAD_LIGHT_CUSTOM_POINT, .medium = VOLGRAD_NONE, .emission = { 4, 4, 4 }, .sampling_weight = 1,
            .position = { 1.5f, 2.5f, 0 }, .custom = &shade } };
    volgrad_camera camera = {
        .kind = VOLGRAD_CAMERA_PINHOLE, .width = WIDTH, .height = HEIGHT, .crop_x1 = WIDTH, .crop_y1 = HEIGHT,
        .medium = VOLGRAD_NONE, .position = { 0, 1.2f, -4 }, .forward = { 0, 0, 1 }, .right = { 1, 0, 0 }, .up = { 0, 1, 0 },
        .tan_half_fov_x = 0.7f };
    volgrad_scene_desc desc = { .struct_size = sizeof desc, .camera = camera, .media = &air, .media_count = 1,
        .materials = &floor, .material_count = 1, .lights = lights, .light_count = 2, .phases = phases, .phase_count = 1,
        .bounds_centre = { 0, 0, 0 }, .bounds_radius = 4.1f };
    size_t bytes;
    check(volgrad_scene_size(&desc, &bytes));
    void *memory = malloc(bytes);
    const volgrad_scene *scene;
    check(volgrad_scene_init(memory, bytes, &desc, &scene, NULL));

    volgrad_queries queries = { .struct_size = sizeof queries, .intersect = look, .occluded = look };
    volgrad_path_sampler_options options;
    volgrad_bidirectional_options both;
    check(volgrad_path_sampler_options_default(&options, sizeof options));
    check(volgrad_bidirectional_options_default(&both, sizeof both));
    options.max_depth = both.max_length = 8;
    options.shift.mode = VOLGRAD_SHIFT_EXCHANGEABLE;
    volgrad_path_sampler_options direct = options; /* light that the camera sees directly is the path sampler's */
    direct.shift.mode = VOLGRAD_SHIFT_NONE, direct.left_out_first = 2, direct.left_out_last = 8;
    void *films[2];
    volgrad_film *by_paths = film_in(&films[0]), *bidirectionally = film_in(&films[1]);
    for (uint64_t pass = 0; pass < PASSES; pass++) {
        check(volgrad_path_sampler_run(scene, &queries, &options, pass, 0, WIDTH * HEIGHT, by_paths, NULL));
        check(volgrad_path_sampler_run(scene, &queries, &direct, pass, 0, WIDTH * HEIGHT, bidirectionally, NULL));
        check(volgrad_bidirectional_run(scene, &queries, &both, pass, 0, WIDTH * HEIGHT, bidirectionally, NULL));
    }
    double difference = show("paths", by_paths, 1) - show("bidirectional", bidirectionally, 0);
    uint64_t dropped;
    check(volgrad_scene_dropped_values(scene, &dropped));
    printf("they %s; %d bad values\n", fabs(difference) < 0.01 * 3 * WIDTH * HEIGHT * 0.5 ? "agree" : "differ", (int)dropped);
    free(memory), free(films[0]), free(films[1]);
    return EXIT_SUCCESS;
}
