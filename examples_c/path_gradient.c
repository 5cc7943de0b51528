/* One light path through a cloud of smoke: how much light it carries, the gradient of that when one or both of its vertices move, and
 * how far the gradient can be trusted. cc -std=c99 -Iinclude examples_c/path_gradient.c libvolgrad.a -lm -lpthread -ldl -lgcc_s */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <volgrad.h>

enum { N = 8 };

static void check(volgrad_status status)
{
    if (status == VOLGRAD_OK) return;
    fprintf(stderr, "path_gradient: %s\n", volgrad_status_message(status));
    exit(EXIT_FAILURE);
}

int main(void)
{
    /* Smoke in a cube of side 2 around the origin: dense in the middle of its floor, thin towards the top. */
    float density[N * N * N];
    for (int i = 0; i < N * N * N; i++) {
        float x = (float)(i % N) - 3.5f, y = (float)(i / N % N), z = (float)(i / (N * N)) - 3.5f;
        density[i] = expf(-0.05f * (x * x + z * z) - 0.3f * y);
    }
    volgrad_medium smoke = {
        .kind = VOLGRAD_MEDIUM_GRID, .phase = { VOLGRAD_PHASE_HENYEY_GREENSTEIN, 0.4f },
        .sigma_t = { 3, 3, 3 }, .albedo = { 0.9f, 0.9f, 0.9f }, .density = density, .nx = N, .ny = N, .nz = N,
        .local_to_world = { 2, 0, 0, -1,  0, 2, 0, -1,  0, 0, 2, -1 } };
    volgrad_light lamp = {
        .kind = VOLGRAD_LIGHT_POINT, .medium = 0, .emission = { 50, 50, 50 }, .sampling_weight = 1, .position = { 1, 3, -1 } };
    volgrad_camera camera = {
        .kind = VOLGRAD_CAMERA_PINHOLE, .width = 640, .height = 480, .crop_x1 = 640, .crop_y1 = 480, .medium = 0,
        .position = { 0, 0, -4 }, .forward = { 0, 0, 1 }, .right = { 1, 0, 0 }, .up = { 0, 1, 0 }, .tan_half_fov_x = 0.5f };
    volgrad_scene_desc desc = { .struct_size = sizeof desc, .camera = camera,
        .media = &smoke, .media_count = 1, .lights = &lamp, .light_count = 1 };

    /* The scene lives in memory of ours; malloc's is aligned enough. */
    size_t bytes;
    check(volgrad_scene_size(&desc, &bytes));
    void *memory = malloc(bytes);
    const volgrad_scene *scene;
    check(volgrad_scene_init(memory, bytes, &desc, &scene, NULL));

    /* Camera, two points in the smoke, lamp. The smoke's grid covers all space, with density 0 outside its cube: one segment per edge. */
    volgrad_vertex vertices[] = {
        { .kind = VOLGRAD_VERTEX_CAMERA, .position = camera.position },
        { .kind = VOLGRAD_VERTEX_MEDIUM, .position = { 0.1f, -0.2f, -0.3f } },
        { .kind = VOLGRAD_VERTEX_MEDIUM, .position = { 0.4f, 0.3f, 0.2f } },
        { .kind = VOLGRAD_VERTEX_LIGHT, .position = lamp.position } };
    volgrad_segment segments[] = { { .end = INFINITY }, { .end = INFINITY }, { .end = INFINITY } };
    uint32_t edge_ends[] = { 1, 2, 3 };
    volgrad_path path = { vertices, segments, edge_ends, 4, 3 };
    check(volgrad_path_validate(scene, &path, NULL));

    /* f, and the gradient of log f when vertex 1 moves alone, and when 1 and 2 move together. Smoke and lamp are grey: the three
     * channels are alike. */
    double f[3];
    check(volgrad_path_contribution(scene, &path, f));
    printf("contribution f    %.6g\n", f[0]);
    for (uint32_t count = 1; count <= 2; count++) {
        volgrad_gradient gradient;
        check(volgrad_path_run_log_gradient(scene, &path, 1, count, &gradient));
        volgrad_vec3 g = gradient.luminance;
        printf("\nvertices that move %d\ngradient of log f (%.4f, %.4f, %.4f)\n", (int)count, g.x, g.y, g.z);
        printf("offset d               exp(<g, d>)  f(x + d) / f(x)\n");
        for (float step = -0.16f; step < 0.2f; step += 0.04f) {
            volgrad_vec3 d = { step, step / 2, 0 };
            volgrad_vertex moved[4];
            for (uint32_t i = 0; i < 4; i++) {
                moved[i] = vertices[i];
                if (i < 1 || i > count) continue;
                moved[i].position.x += d.x, moved[i].position.y += d.y, moved[i].position.z += d.z;
            }
            volgrad_path other = { moved, segments, edge_ends, 4, 3 };
            double there[3];
            check(volgrad_path_contribution(scene, &other, there));
            double estimate = exp(g.x * d.x + g.y * d.y + g.z * d.z);
            printf("(%5.2f, %5.2f, %5.2f)  %11.4f  %15.4f\n", d.x, d.y, d.z, estimate, there[0] / f[0]);
        }
    }
    free(memory);
    return EXIT_SUCCESS;
}
