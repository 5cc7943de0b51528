/* Structs that are frozen per VOLGRAD_ABI_VERSION keep their layout on 64-bit machines. src/ffi/types.rs asserts the same sizes. */
#include <assert.h>
#include <stddef.h>
#include <stdio.h>

#include "volgrad.h"

static_assert(VOLGRAD_ABI_VERSION == 1, "a new version may change what follows");

#define SIZE(type, size) static_assert(sizeof(type) == (size), #type " changed its size")
#define OFFSET(type, field, offset) static_assert(offsetof(type, field) == (offset), #type "." #field " moved")

SIZE(volgrad_vec3, 12);
SIZE(volgrad_rgb, 12);
SIZE(volgrad_camera, 96);
OFFSET(volgrad_camera, position, 32);
OFFSET(volgrad_camera, tan_half_fov_x, 80);
OFFSET(volgrad_camera, lens_radius, 88);
SIZE(volgrad_phase, 8);
SIZE(volgrad_medium, 120);
OFFSET(volgrad_medium, custom_phase, 36);
OFFSET(volgrad_medium, density, 40);
OFFSET(volgrad_medium, local_to_world, 60);
OFFSET(volgrad_medium, custom, 112);
SIZE(volgrad_custom_density, 48);
OFFSET(volgrad_custom_density, integrals, 40);
SIZE(volgrad_stretch, 64);
SIZE(volgrad_density_integrals, 56);
SIZE(volgrad_custom_bsdf, 48);
SIZE(volgrad_custom_phase, 40);
SIZE(volgrad_custom_light, 48);
SIZE(volgrad_sparse_grid, 24);
SIZE(volgrad_material, 64);
OFFSET(volgrad_material, eta, 20);
OFFSET(volgrad_material, custom, 56);
SIZE(volgrad_light, 112);
OFFSET(volgrad_light, medium, 4);
OFFSET(volgrad_light, position, 24);
OFFSET(volgrad_light, direction, 64);
OFFSET(volgrad_light, cos_inner, 76);
OFFSET(volgrad_light, image, 88);
SIZE(volgrad_scene_desc, 168);
OFFSET(volgrad_scene_desc, phases, 152);
OFFSET(volgrad_scene_desc, bounds_centre, 136);
SIZE(volgrad_segment, 20);
SIZE(volgrad_vertex, 44);
SIZE(volgrad_path, 32);
SIZE(volgrad_gradient, 312);
SIZE(volgrad_derivative, 116);
SIZE(volgrad_ray, 36);
SIZE(volgrad_hit, 372);
OFFSET(volgrad_hit, normal, 20);
OFFSET(volgrad_hit, segments, 52);
SIZE(volgrad_line, 40);
SIZE(volgrad_splat, 20);
SIZE(volgrad_transmittance_options, 16);
SIZE(volgrad_transmittance_estimate, 88);
SIZE(volgrad_shift_options, 40);
OFFSET(volgrad_shift_options, run, 24);
OFFSET(volgrad_shift_options, clamp, 36);
SIZE(volgrad_path_sampler_options, 72);
OFFSET(volgrad_path_sampler_options, shift, 24);
OFFSET(volgrad_path_sampler_options, left_out_first, 64);
SIZE(volgrad_bidirectional_options, 72);
OFFSET(volgrad_bidirectional_options, seed, 16);
OFFSET(volgrad_bidirectional_options, roulette, 28);
OFFSET(volgrad_bidirectional_options, shift, 32);
SIZE(volgrad_chain_options, 72);
OFFSET(volgrad_chain_options, seed, 24);
OFFSET(volgrad_chain_options, shift, 32);
SIZE(volgrad_chain_techniques, 4 * 65 * 66);
SIZE(volgrad_chain_start, 48);
OFFSET(volgrad_chain_start, share, 16);
OFFSET(volgrad_chain_start, brightness, 32);
SIZE(volgrad_chain_plan_result, 24);
OFFSET(volgrad_chain_plan_result, relative_error, 16);
SIZE(volgrad_chain_stats, 120);
OFFSET(volgrad_chain_stats, rays, 72);

int main(void)
{
    puts("1 passed, 0 failed");
    return 0;
}
