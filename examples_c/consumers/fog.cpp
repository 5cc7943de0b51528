// How much light passes 4 units of fog, by volgrad as an installed library.
#include <cmath>
#include <cstdio>
#include <volgrad.h>

int main()
{
    volgrad_medium fog = {};
    fog.kind = VOLGRAD_MEDIUM_HOMOGENEOUS;
    fog.sigma_t = {0.5f, 0.5f, 0.5f};
    fog.albedo = {1, 1, 1};
    volgrad_scene_desc desc = {};
    desc.struct_size = sizeof desc;
    desc.media_count = 1;
    desc.media = &fog;
    desc.camera.width = desc.camera.height = desc.camera.crop_x1 = desc.camera.crop_y1 = 1;
    desc.camera.forward = {0, 0, 1};
    desc.camera.right = {1, 0, 0};
    desc.camera.up = {0, 1, 0};
    desc.camera.tan_half_fov_x = 1;
    alignas(16) static char memory[4096];
    const volgrad_scene *scene;
    if (volgrad_scene_init(memory, sizeof memory, &desc, &scene, nullptr) != VOLGRAD_OK) return 1;

    volgrad_segment in_fog = {};
    in_fog.end = 4;
    volgrad_line line = {};
    line.direction = {0, 0, 1};
    line.length = 4;
    line.segments = &in_fog;
    line.segment_count = 1;
    volgrad_rgb tau;
    if (volgrad_line_tau(scene, &line, &tau) != VOLGRAD_OK) return 1;
    std::printf("volgrad %s in C++: %.4f of the light passes\n", volgrad_version(), std::exp(-tau.g));
}
