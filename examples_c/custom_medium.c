/* A cloud that exists only as a function: its optical depth and gradient at several steps, checked by ratio tracking, which has no
 * step; and a picture of it. cc -std=c99 -Iinclude examples_c/custom_medium.c libvolgrad.a -lm -lpthread -ldl -lgcc_s */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <volgrad.h>

enum { WIDTH = 64, HEIGHT = 32, PASSES = 64, SAMPLES = 100000 };

static void check(volgrad_status status)
{
    if (status == VOLGRAD_OK) return;
    fprintf(stderr, "custom_medium: %s\n", volgrad_status_message(status));
    exit(EXIT_FAILURE);
}

/* A unit ball (1 - r^2)^2 that fades out, times waves 1 + a sin(kx) sin(ky) sin(kz). `user` holds a and k. */
typedef struct cloud { float a, k; } cloud;

static void density(void *user, const volgrad_vec3 *points, float *densities, uint32_t count)
{
    const cloud *c = user;
    for (uint32_t i = 0; i < count; i++) {
        const volgrad_vec3 p = points[i];
        float ball = fmaxf(0, 1 - p.x * p.x - p.y * p.y - p.z * p.z);
        densities[i] = ball * ball * (1 + c->a * sinf(c->k * p.x) * sinf(c->k * p.y) * sinf(c->k * p.z));
    }
}

static void gradient(void *user, const volgrad_vec3 *points, volgrad_vec3 *gradients, uint32_t count)
{
    const cloud *c = user;
    for (uint32_t i = 0; i < count; i++) {
        const volgrad_vec3 p = points[i];
        float ball = fmaxf(0, 1 - p.x * p.x - p.y * p.y - p.z * p.z);
        float sx = sinf(c->k * p.x), sy = sinf(c->k * p.y), sz = sinf(c->k * p.z);
        float fade = -4 * ball * (1 + c->a * sx * sy * sz), wave = ball * ball * c->a * c->k;
        gradients[i].x = fade * p.x + wave * cosf(c->k * p.x) * sy * sz;
        gradients[i].y = fade * p.y + wave * sx * cosf(c->k * p.y) * sz;
        gradients[i].z = fade * p.z + wave * sx * sy * cosf(c->k * p.z);
    }
}

/* Nothing but air: every ray goes on in the medium that it starts in. The cloud's box keeps it finite. */
static int32_t open_air(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    (void)user;
    for (uint32_t i = 0; i < count; i++) {
        hits[i] = (volgrad_hit){ .kind = VOLGRAD_HIT_NONE, .segment_count = 1 };
        hits[i].segments[0] = (volgrad_segment){ .end = rays[i].t_max, .medium = rays[i].medium };
    }
    return 0;
}

static void show(const volgrad_scene *scene)
{
    volgrad_queries queries = { .struct_size = sizeof queries, .intersect = open_air, .occluded = open_air };
    volgrad_path_sampler_options options;
    check(volgrad_path_sampler_options_default(&options, sizeof options));
    options.shift.mode = VOLGRAD_SHIFT_EXCHANGEABLE;
    size_t bytes;
    check(volgrad_film_size(WIDTH, HEIGHT, &bytes));
    void *memory = malloc(bytes);
    volgrad_film *film;
    check(volgrad_film_init(memory, bytes, WIDTH, HEIGHT, &film));
    for (uint64_t pass = 0; pass < PASSES; pass++) {
        check(volgrad_path_sampler_run(scene, &queries, &options, pass, 0, WIDTH * HEIGHT, film, NULL));
    }
    static float image[3 * WIDTH * HEIGHT];
    check(volgrad_film_develop(film, 1.0 / PASSES, image, 3 * WIDTH * HEIGHT));
    for (int y = 0; y < HEIGHT; y += 2) { /* characters are twice as high as wide */
        for (int x = 0; x < WIDTH; x++) {
            float value = 0.5f * (image[3 * (y * WIDTH + x)] + image[3 * ((y + 1) * WIDTH + x)]);
            putchar(" .:-=+*#%@"[value < 1 ? (int)(9.99f * sqrtf(value)) : 9]);
        }
        putchar('\n');
    }
    free(memory);
}

int main(void)
{
    cloud waves = { 0.9f, 7 };
    volgrad_custom_density custom = { .struct_size = sizeof custom, .user = &waves, .density = density, .gradient = gradient,
        .majorant = 1.9f };
    volgrad_medium medium = { /* its box: [-1, 1]^3 */
        .kind = VOLGRAD_MEDIUM_CUSTOM, .phase = { VOLGRAD_PHASE_HENYEY_GREENSTEIN, 0.5f }, .sigma_t = { 8, 8, 8 },
        .albedo = { 0.95f, 0.95f, 0.95f }, .local_to_world = { 2, 0, 0, -1,  0, 2, 0, -1,  0, 0, 2, -1 }, .custom = &custom };
    volgrad_light lamp = {
        .kind = VOLGRAD_LIGHT_POINT, .medium = 0, .emission = { 60, 60, 60 }, .sampling_weight = 1, .position = { 2, 3, -2 } };
    volgrad_camera camera = {
        .kind = VOLGRAD_CAMERA_PINHOLE, .width = WIDTH, .height = HEIGHT, .crop_x1 = WIDTH, .crop_y1 = HEIGHT,
        .position = { 0, 0, -4 }, .forward = { 0, 0, 1 }, .right = { 1, 0, 0 }, .up = { 0, 1, 0 }, .tan_half_fov_x = 0.6f };
    volgrad_scene_desc desc = { .struct_size = sizeof desc, .camera = camera,
        .media = &medium, .media_count = 1, .lights = &lamp, .light_count = 1 };

    volgrad_segment segment = { .end = INFINITY };
    volgrad_line line = { { -0.9f, -0.3f, 0 }, { 0.8f, 0.36f, 0.48f }, 1.2f, 1, &segment };
    void *memory = NULL;
    const volgrad_scene *scene;
    for (custom.step = 0.2f; custom.step > 0.04f; custom.step /= 2) {
        size_t bytes;
        check(volgrad_scene_size(&desc, &bytes));
        memory = realloc(memory, bytes);
        check(volgrad_scene_init(memory, bytes, &desc, &scene, NULL));
        volgrad_optical_depth depth;
        check(volgrad_line_optical_depth(scene, &line, &depth));
        volgrad_vec3 g = depth.end_gradient[0];
        printf("step %.2f:      optical depth %.4f, gradient (%.3f, %.3f, %.3f)\n", custom.step, depth.tau.r, g.x, g.y, g.z);
    }

    volgrad_transmittance_options options;
    check(volgrad_transmittance_options_default(&options, sizeof options));
    double sum = 0, x = 0, y = 0, z = 0;
    for (uint64_t i = 0; i < SAMPLES; i++) {
        volgrad_transmittance_estimate e;
        check(volgrad_line_transmittance_estimate(scene, &line, &options, 1, i, &e));
        sum += e.transmittance.r, x += e.end_gradient[0].x, y += e.end_gradient[0].y, z += e.end_gradient[0].z;
    }
    printf("ratio tracking: optical depth %.4f, gradient (%.3f, %.3f, %.3f)\n\n", -log(sum / SAMPLES), -x / sum, -y / sum, -z / sum);
    show(scene);
    free(memory);
    return EXIT_SUCCESS;
}
