/* What the C++ tests share: counted checks, and a small scene, a slab of fog between z = 1 and z = 2 before a sky, a lamp beside it. */

#ifndef FOG_HPP
#define FOG_HPP

#include <cmath>
#include <cstdio>
#include <cstring>
#include <vector>

#include "volgrad.hpp"

extern int checks_passed, checks_failed;

inline void check_that(bool ok, const char *what, const char *file, int line) {
    ++(ok ? checks_passed : checks_failed);
    if (!ok) std::fprintf(stderr, "%s:%d: failed: %s\n", file, line, what);
}
#define CHECK(condition) check_that((condition), #condition, __FILE__, __LINE__)

enum { SIDE = 16, PIXELS = SIDE * SIDE };

/* Points into itself. */
struct fog_desc {
    volgrad_medium medium;
    volgrad_light lights[2];
    volgrad_scene_desc desc;

    fog_desc() : medium(), lights(), desc(volgrad::sized<volgrad_scene_desc>()) {
        const volgrad_rgb white = {1, 1, 1}, bright = {9, 9, 9}, albedo = {0.9f, 0.8f, 0.7f};
        medium.sigma_t = white, medium.albedo = albedo;
        medium.phase.kind = VOLGRAD_PHASE_HENYEY_GREENSTEIN, medium.phase.g = 0.3f;
        lights[0].kind = VOLGRAD_LIGHT_ENVIRONMENT, lights[0].emission = white, lights[0].medium = VOLGRAD_NONE;
        lights[1].kind = VOLGRAD_LIGHT_POINT, lights[1].emission = bright, lights[1].medium = VOLGRAD_NONE;
        lights[1].position.y = 2, lights[1].sampling_weight = lights[0].sampling_weight = 1;
        volgrad_camera &c = desc.camera;
        c.width = c.height = c.crop_x1 = c.crop_y1 = SIDE;
        c.medium = VOLGRAD_NONE;
        c.forward.z = c.right.x = c.up.y = 1, c.tan_half_fov_x = 1;
        desc.media = &medium, desc.media_count = 1;
        desc.lights = lights, desc.light_count = 2;
        desc.bounds_centre.z = 1.5f, desc.bounds_radius = 4;
    }
    fog_desc(const fog_desc &) = delete;
    fog_desc &operator=(const fog_desc &) = delete;
};

/* As C asks. */
inline std::int32_t answer_slab(void *, const volgrad_ray *rays, volgrad_hit *hits, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; i++) {
        const volgrad_ray &ray = rays[i];
        volgrad_hit &hit = hits[i] = volgrad_hit();
        float enter = (1 - ray.origin.z) / ray.direction.z, leave = (2 - ray.origin.z) / ray.direction.z;
        if (enter > leave) std::swap(enter, leave);
        const float ends[3] = {enter, leave, INFINITY};
        for (int k = 0; k < 3; k++) {
            const float end = ends[k] < ray.t_max ? ends[k] : ray.t_max;
            if (!(end > 0)) continue;
            const volgrad_segment segment = {end, k == 1 ? 0u : static_cast<std::uint32_t>(VOLGRAD_NONE), {0, 0, 1}};
            hit.segments[hit.segment_count++] = segment;
        }
    }
    return 0;
}

inline volgrad_queries slab_in_c() {
    volgrad_queries queries = volgrad::sized<volgrad_queries>();
    queries.intersect = queries.occluded = answer_slab;
    return queries;
}

/* The same for C++. */
struct slab {
    void intersect(volgrad::span<const volgrad_ray> rays, volgrad::span<volgrad_hit> hits) const {
        answer_slab(nullptr, rays.data(), hits.data(), static_cast<std::uint32_t>(rays.size()));
    }
    int occluded(volgrad::span<const volgrad_ray> rays, volgrad::span<volgrad_hit> hits) const { return intersect(rays, hits), 0; }
};

#endif
