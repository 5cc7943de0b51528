/* A lamp over a ball, in fog, from C++: a host that answers rays, two threads that render with shifts, and the image in characters.
 * c++ -std=c++11 -Iinclude examples_c/fog.cpp libvolgrad.a -lm -lpthread -ldl -lgcc_s */

#include <cmath>
#include <cstdio>
#include <exception>
#include <thread>
#include <vector>
#include <volgrad.hpp>

namespace {

enum { WIDTH = 64, HEIGHT = 32, PASSES = 32, THREADS = 2 };

/* All of the geometry: a diffuse ball of radius 1 at the origin. The fog is everywhere, so every ray stays in the medium that it starts in. */
struct ball_in_fog {
    void intersect(volgrad::span<const volgrad_ray> rays, volgrad::span<volgrad_hit> hits) const {
        for (std::size_t i = 0; i < rays.size(); i++) hits[i] = answer(rays[i]);
    }
    void occluded(volgrad::span<const volgrad_ray> rays, volgrad::span<volgrad_hit> hits) const { intersect(rays, hits); }

    static volgrad_hit answer(const volgrad_ray &ray) {
        volgrad_hit hit = volgrad_hit();
        const volgrad_vec3 o = ray.origin, d = ray.direction;
        const float half = o.x * d.x + o.y * d.y + o.z * d.z;
        const float inside_root = half * half - (o.x * o.x + o.y * o.y + o.z * o.z - 1);
        const float t = inside_root > 0 ? -half - std::sqrt(inside_root) : -1;
        hit.segment_count = 1;
        hit.segments[0].end = ray.t_max;
        hit.segments[0].medium = ray.medium;
        if (!(t >= ray.t_min && t < ray.t_max)) return hit;
        hit.kind = VOLGRAD_HIT_SURFACE;
        hit.t = hit.segments[0].end = t;
        hit.light = VOLGRAD_NONE;
        hit.medium_outside = hit.medium_inside = VOLGRAD_KEEP_MEDIUM;
        const volgrad_vec3 normal = {o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
        hit.normal = hit.shading_normal = normal;
        return hit;
    }
};

void render() {
    volgrad_medium fog = volgrad_medium();
    fog.sigma_t = {0.08f, 0.08f, 0.08f}, fog.albedo = {0.9f, 0.9f, 0.9f};
    fog.phase = {VOLGRAD_PHASE_HENYEY_GREENSTEIN, 0.5f};
    volgrad_material white = volgrad_material();
    white.kind = VOLGRAD_MATERIAL_DIFFUSE, white.reflectance = {0.8f, 0.8f, 0.8f};
    volgrad_light lamp = volgrad_light();
    lamp.kind = VOLGRAD_LIGHT_POINT, lamp.medium = 0, lamp.emission = {60, 60, 60}, lamp.sampling_weight = 1, lamp.position = {2, 2, -2};
    volgrad_scene_desc desc = volgrad::sized<volgrad_scene_desc>();
    desc.media = &fog, desc.materials = &white, desc.lights = &lamp;
    desc.media_count = desc.material_count = desc.light_count = 1;
    volgrad_camera &camera = desc.camera;
    camera.width = camera.crop_x1 = WIDTH, camera.height = camera.crop_y1 = HEIGHT;
    camera.position = {0, 0, -4}, camera.forward = {0, 0, 1}, camera.right = {1, 0, 0}, camera.up = {0, 1, 0};
    camera.tan_half_fov_x = 0.7f;

    const volgrad::scene scene(desc); /* its memory is freed with it */
    const ball_in_fog host;
    volgrad_path_sampler_options options = volgrad::path_sampler_options_default();
    options.shift.mode = VOLGRAD_SHIFT_EXCHANGEABLE;

    /* The scene and the host are shared; every thread has a film, and sums are exact in any order. */
    std::vector<volgrad::film> films;
    std::vector<std::exception_ptr> errors(THREADS);
    std::vector<std::thread> threads;
    for (int i = 0; i < THREADS; i++) films.emplace_back(WIDTH, HEIGHT);
    for (int i = 0; i < THREADS; i++) {
        threads.emplace_back([&, i] {
            try {
                for (std::uint64_t pass = i; pass < PASSES; pass += THREADS)
                    volgrad::path_sampler_run(scene, host, options, pass, 0, WIDTH * HEIGHT, films[i]);
            } catch (...) {
                errors[i] = std::current_exception();
            }
        });
    }
    for (std::thread &thread : threads) thread.join();
    for (const std::exception_ptr &error : errors)
        if (error) std::rethrow_exception(error);
    for (int i = 1; i < THREADS; i++) films[0].merge(films[i]);
    std::vector<float> image(3 * WIDTH * HEIGHT);
    films[0].develop(1.0 / PASSES, image);

    for (int y = 0; y < HEIGHT; y += 2) { /* characters are twice as high as wide */
        for (int x = 0; x < WIDTH; x++) {
            const float value = 0.5f * (image[3 * (y * WIDTH + x)] + image[3 * ((y + 1) * WIDTH + x)]);
            std::putchar(" .:-=+*#%@"[value < 2 ? static_cast<int>(9.99f * std::sqrt(value / 2)) : 9]);
        }
        std::putchar('\n');
    }
}

} // namespace

int main() {
    try {
        render();
        return 0;
    } catch (const std::exception &e) {
        std::fprintf(stderr, "fog: %s\n", e.what());
        return 1;
    }
}
