/* How much light passes 4 units of fog, by volgrad as an installed library. */
#include <math.h>
#include <stdio.h>
#include <volgrad.h>

int main(void)
{
    volgrad_medium fog = { .kind = VOLGRAD_MEDIUM_HOMOGENEOUS, .sigma_t = { 0.5f, 0.5f, 0.5f }, .albedo = { 1, 1, 1 } };
    volgrad_camera camera = { .width = 1, .height = 1, .crop_x1 = 1, .crop_y1 = 1, .forward = { 0, 0, 1 }, .right = { 1, 0, 0 },
        .up = { 0, 1, 0 }, .tan_half_fov_x = 1 };
    volgrad_scene_desc desc = { .struct_size = sizeof desc, .media_count = 1, .camera = camera, .media = &fog };
    static _Alignas(16) char memory[4096];
    const volgrad_scene *scene;
    if (volgrad_scene_init(memory, sizeof memory, &desc, &scene, NULL) != VOLGRAD_OK) return 1;

    volgrad_segment in_fog = { .end = 4, .medium = 0 };
    volgrad_line line = { .direction = { 0, 0, 1 }, .length = 4, .segments = &in_fog, .segment_count = 1 };
    volgrad_rgb tau;
    if (volgrad_line_tau(scene, &line, &tau) != VOLGRAD_OK) return 1;
    printf("volgrad %s in C: %.4f of the light passes\n", volgrad_version(), exp(-tau.g));
    return 0;
}
