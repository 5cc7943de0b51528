/* A small scene for the C tests: fog of extinction 1 and albedo 1/2 around a camera at the origin that looks along +z. */

#ifndef SMALL_SCENE_H
#define SMALL_SCENE_H

#include "check.h"

enum { DIFFUSE, MIRROR, GLASS, MATERIALS };
enum { POINT_LIGHT, SKY, LIGHTS };
enum { SIDE = 64 };

static const volgrad_rgb WHITE = {1, 1, 1};
static const volgrad_rgb GREY = {0.5f, 0.5f, 0.5f};

/* A description and its arrays; `desc` points to the others, so it must not be copied. */
typedef struct small_scene {
    volgrad_scene_desc desc;
    volgrad_medium media[2];
    volgrad_material materials[MATERIALS];
    volgrad_light lights[LIGHTS];
} small_scene;

static inline volgrad_vec3 vec(float x, float y, float z) {
    volgrad_vec3 v = {x, y, z};
    return v;
}

static inline volgrad_scene_desc *small_scene_fill(small_scene *s) {
    memset(s, 0, sizeof *s);
    volgrad_camera *camera = &s->desc.camera;
    camera->width = camera->height = camera->crop_x1 = camera->crop_y1 = SIDE;
    camera->forward = vec(0, 0, 1);
    camera->right = vec(1, 0, 0);
    camera->up = vec(0, 1, 0);
    camera->tan_half_fov_x = 1;
    for (int i = 0; i < 2; i++) {
        s->media[i].sigma_t = WHITE;
        s->media[i].albedo = GREY;
    }
    s->materials[MIRROR].kind = VOLGRAD_MATERIAL_MIRROR;
    s->materials[GLASS].kind = VOLGRAD_MATERIAL_DIELECTRIC;
    s->materials[GLASS].eta = 1.5f;
    s->materials[DIFFUSE].reflectance = s->materials[MIRROR].reflectance = GREY;
    s->lights[POINT_LIGHT].kind = VOLGRAD_LIGHT_POINT;
    s->lights[POINT_LIGHT].medium = 0;
    s->lights[POINT_LIGHT].position = vec(0, 2, 3);
    s->lights[SKY].kind = VOLGRAD_LIGHT_ENVIRONMENT;
    for (int i = 0; i < LIGHTS; i++) {
        s->lights[i].emission = WHITE;
        s->lights[i].sampling_weight = 1;
    }
    s->desc.struct_size = sizeof s->desc;
    s->desc.media_count = 1;
    s->desc.material_count = MATERIALS;
    s->desc.light_count = LIGHTS;
    s->desc.media = s->media;
    s->desc.materials = s->materials;
    s->desc.lights = s->lights;
    return &s->desc;
}

/* s->media[1] becomes a grid of 2 x 2 x 2 densities in the unit cube. */
static inline void small_scene_add_grid(small_scene *s, const float *densities) {
    volgrad_medium *grid = &s->media[1];
    s->desc.media_count = 2;
    grid->kind = VOLGRAD_MEDIUM_GRID;
    grid->density = densities;
    grid->nx = grid->ny = grid->nz = 2;
    grid->local_to_world[0] = grid->local_to_world[5] = grid->local_to_world[10] = 1;
}

/* Makes the scene; `*memory` is to be freed. */
static inline const volgrad_scene *scene_make(const volgrad_scene_desc *desc, void **memory) {
    size_t bytes = 0;
    const volgrad_scene *scene = NULL;
    CHECK_STATUS(volgrad_scene_size(desc, &bytes), VOLGRAD_OK);
    *memory = aligned_alloc(16, (bytes + 15) / 16 * 16);
    CHECK_STATUS(volgrad_scene_init(*memory, bytes, desc, &scene, NULL), VOLGRAD_OK);
    return scene;
}

#endif
