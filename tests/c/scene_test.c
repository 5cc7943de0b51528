/* Scenes: what volgrad_scene_size and volgrad_scene_init accept, and what they say about the rest. */

#include "small_scene.h"

static const float densities[8] = {0, 1, 2, 3, 4, 5, 6, 7};
static small_scene s;
static alignas(16) unsigned char memory[1 << 16];

/* s.media[1] becomes a grid. */
static void fill(void) {
    small_scene_fill(&s);
    small_scene_add_grid(&s, densities);
}

/* Refuses the description `s` with `status`, blames `field` and `index`; then resets it. */
static void refuse(volgrad_status status, const char *field, uint32_t index, const char *what, int line) {
    const volgrad_scene *scene;
    volgrad_error error = {sizeof error, 77, NULL};
    FILL(scene);
    check_status(volgrad_scene_init(memory, sizeof memory, &s.desc, &scene, &error), status, what, __FILE__, line);
    check_that(UNTOUCHED(scene), what, __FILE__, line);
    int named = error.field != NULL && strcmp(error.field, field) == 0 && error.index == index;
    check_that(named && error.struct_size == sizeof error, what, __FILE__, line);
    if (!named) fprintf(stderr, "  blamed: %s %u\n", error.field ? error.field : "NULL", (unsigned)error.index);
    check_status(volgrad_scene_init(memory, sizeof memory, &s.desc, &scene, NULL), status, what, __FILE__, line);
    check_that(UNTOUCHED(scene), what, __FILE__, line);
    fill();
}

#define BAD(set, status, field, index) ((set), refuse((status), (field), (index), #set, __LINE__))

/* NaN and both infinities. */
#define NOT_FINITE(place, field, index) \
    (BAD(place = NAN, VOLGRAD_ERROR_NOT_FINITE, field, index), BAD(place = INFINITY, VOLGRAD_ERROR_NOT_FINITE, field, index), \
     BAD(place = -INFINITY, VOLGRAD_ERROR_NOT_FINITE, field, index))
#define NOT_FINITE_3(place, a, b, c, field, index) \
    (NOT_FINITE(place.a, field, index), NOT_FINITE(place.b, field, index), NOT_FINITE(place.c, field, index))
#define NOT_FINITE_VEC(place, field, index) NOT_FINITE_3(place, x, y, z, field, index)
#define NOT_FINITE_RGB(place, field, index) NOT_FINITE_3(place, r, g, b, field, index)
#define RANGE(set, field, index) BAD(set, VOLGRAD_ERROR_RANGE, field, index)
#define KIND(set, field, index) BAD(set, VOLGRAD_ERROR_KIND, field, index)

static void test_camera(void) {
    volgrad_camera *c = &s.desc.camera;
    KIND(c->kind = 2, "camera.kind", 0);
    KIND(c->kind = UINT32_MAX, "camera.kind", 0);
    const char *size = "camera.width, camera.height", *crop = "camera.crop_x0 ... camera.crop_y1";
    RANGE(c->width = 0, size, 0);
    RANGE(c->height = 0, size, 0);
    RANGE(c->width = UINT32_MAX, size, 0);
    RANGE(c->height = 1u << 16, size, 0);
    RANGE(c->crop_x1 = 0, crop, 0);
    RANGE(c->crop_x0 = SIDE, crop, 0);
    RANGE(c->crop_x1 = SIDE + 1, crop, 0);
    RANGE(c->crop_y0 = UINT32_MAX, crop, 0);
    RANGE(c->crop_y1 = UINT32_MAX, crop, 0);
    BAD(c->medium = 2, VOLGRAD_ERROR_INDEX, "camera.medium", 0);
    BAD(c->medium = VOLGRAD_KEEP_MEDIUM, VOLGRAD_ERROR_INDEX, "camera.medium", 0);
    NOT_FINITE_VEC(c->position, "camera.position", 0);
    NOT_FINITE_VEC(c->forward, "camera.forward", 0);
    NOT_FINITE_VEC(c->right, "camera.right", 0);
    NOT_FINITE_VEC(c->up, "camera.up", 0);
    BAD(c->forward.z = 2, VOLGRAD_ERROR_NOT_FINITE, "camera.forward", 0);
    BAD(c->right.x = 0, VOLGRAD_ERROR_NOT_FINITE, "camera.right", 0);
    BAD(c->up.y = 0.9f, VOLGRAD_ERROR_NOT_FINITE, "camera.up", 0);
    RANGE(c->up = vec(1, 0, 0), "camera.forward, camera.right, camera.up", 0);
    NOT_FINITE(c->tan_half_fov_x, "camera.tan_half_fov_x", 0);
    RANGE(c->tan_half_fov_x = 0, "camera.tan_half_fov_x", 0);
    RANGE(c->tan_half_fov_x = -1, "camera.tan_half_fov_x", 0);
    NOT_FINITE(c->near_clip, "camera.near_clip", 0);
    RANGE(c->near_clip = -1e-6f, "camera.near_clip", 0);
    RANGE(c->lens_radius = 0.1f, "camera.lens_radius", 0); /* a pinhole has none */
#define THIN_LENS (c->kind = VOLGRAD_CAMERA_THIN_LENS, c->lens_radius = 0.1f, c->focal_distance = 2)
    RANGE((THIN_LENS, c->lens_radius = 0), "camera.lens_radius", 0);
    BAD((THIN_LENS, c->lens_radius = INFINITY), VOLGRAD_ERROR_NOT_FINITE, "camera.lens_radius", 0);
    RANGE((THIN_LENS, c->focal_distance = 0), "camera.focal_distance", 0);
    BAD((THIN_LENS, c->focal_distance = NAN), VOLGRAD_ERROR_NOT_FINITE, "camera.focal_distance", 0);
}

static void test_media(void) {
    volgrad_medium *m = s.media;
    KIND(m[1].kind = 4, "media.kind", 1);
    KIND(m[0].kind = UINT32_MAX, "media.kind", 0);
    KIND(m[0].phase.kind = 3, "media.phase", 0);
    m[1].phase.kind = VOLGRAD_PHASE_HENYEY_GREENSTEIN;
    BAD(m[1].phase.g = NAN, VOLGRAD_ERROR_NOT_FINITE, "media.phase", 1);
    m[1].phase.kind = VOLGRAD_PHASE_HENYEY_GREENSTEIN;
    RANGE(m[1].phase.g = 1, "media.phase", 1);
    m[1].phase.kind = VOLGRAD_PHASE_HENYEY_GREENSTEIN;
    RANGE(m[1].phase.g = -1, "media.phase", 1);
    NOT_FINITE_RGB(m[0].sigma_t, "media.sigma_t", 0);
    NOT_FINITE_RGB(m[1].albedo, "media.albedo", 1);
    RANGE(m[1].sigma_t.g = -1, "media.sigma_t", 1);
    RANGE(m[0].albedo.b = 1.0001f, "media.albedo", 0);
    RANGE(m[0].albedo.r = -0.0001f, "media.albedo", 0);

    const char *sides = "media.nx, media.ny, media.nz", *map = "media.local_to_world";
    RANGE(m[1].nx = 0, sides, 1);
    RANGE(m[1].ny = 0, sides, 1);
    RANGE(m[1].nz = UINT32_MAX, sides, 1);
    RANGE((m[1].nx = 2048, m[1].ny = 2048, m[1].nz = 2048), sides, 1);
    BAD(m[1].density = NULL, VOLGRAD_ERROR_NULL, "media.density", 1);
    BAD(m[1].density = (const float *)(const void *)(memory + 1), VOLGRAD_ERROR_MISALIGNED, "media.density", 1);
    float bad[8] = {0, 0, 0, 0, 0, 0, 0, -1e-20f};
    RANGE(m[1].density = bad, "media.density", 1);
    bad[7] = NAN;
    BAD(m[1].density = bad, VOLGRAD_ERROR_NOT_FINITE, "media.density", 1);
    bad[7] = INFINITY;
    BAD(m[1].density = bad, VOLGRAD_ERROR_NOT_FINITE, "media.density", 1);
    for (int i = 0; i < 12; i++) {
        NOT_FINITE(m[1].local_to_world[i], map, 1);
    }
    RANGE(m[1].local_to_world[5] = 0, map, 1);
    RANGE((m[1].local_to_world[0] = 1e-38f, m[1].local_to_world[5] = 0), map, 1);
}

static void test_materials_and_lights(void) {
    volgrad_material *m = s.materials;
    KIND(m[GLASS].kind = 5, "materials.kind", GLASS);
    NOT_FINITE_RGB(m[DIFFUSE].reflectance, "materials.reflectance", DIFFUSE);
    NOT_FINITE_RGB(m[MIRROR].reflectance, "materials.reflectance", MIRROR);
    RANGE(m[DIFFUSE].reflectance.r = 1.5f, "materials.reflectance", DIFFUSE);
    RANGE(m[MIRROR].reflectance.b = -0.5f, "materials.reflectance", MIRROR);
    NOT_FINITE(m[GLASS].eta, "materials.eta", GLASS);
    RANGE(m[GLASS].eta = 0, "materials.eta", GLASS);
    RANGE(m[GLASS].eta = -1.5f, "materials.eta", GLASS);

    KIND(m[GLASS].flags = 2, "materials.flags", GLASS);
    NOT_FINITE(m[GLASS].roughness, "materials.roughness", GLASS);
    RANGE(m[GLASS].roughness = -0.1f, "materials.roughness", GLASS);
    RANGE(m[GLASS].roughness = 0.9e-4f, "materials.roughness", GLASS);
    RANGE((m[GLASS].roughness = 0.1f, m[GLASS].eta = 1), "materials.eta", GLASS);
    RANGE((m[GLASS].roughness = 0.1f, m[GLASS].eta = 0), "materials.eta", GLASS);
#define METAL m[MIRROR].kind = VOLGRAD_MATERIAL_CONDUCTOR
    BAD((METAL, m[MIRROR].conductor_eta.g = NAN), VOLGRAD_ERROR_NOT_FINITE, "materials.conductor_eta", MIRROR);
    RANGE((METAL, m[MIRROR].conductor_eta.r = -1), "materials.conductor_eta", MIRROR);
    RANGE((METAL, m[MIRROR].conductor_k.b = -1), "materials.conductor_k", MIRROR);
    RANGE((METAL, m[MIRROR].roughness = -1), "materials.roughness", MIRROR);
    RANGE((METAL, m[MIRROR].reflectance.r = 2), "materials.reflectance", MIRROR);

    volgrad_light *l = s.lights;
    KIND(l[SKY].kind = 10, "lights.kind", SKY);
    RANGE(l[POINT_LIGHT].kind = VOLGRAD_LIGHT_ENVIRONMENT, "lights.kind", 1); /* the second environment is one too many */
    for (uint32_t i = 0; i < LIGHTS; i++) {
        NOT_FINITE_RGB(l[i].emission, "lights.emission", i);
        NOT_FINITE(l[i].sampling_weight, "lights.sampling_weight", i);
        RANGE(l[i].emission.g = -1, "lights.emission", i);
        RANGE(l[i].sampling_weight = -1, "lights.sampling_weight", i);
    }
    BAD(l[POINT_LIGHT].medium = 2, VOLGRAD_ERROR_INDEX, "lights.medium", POINT_LIGHT);
    BAD(l[POINT_LIGHT].medium = VOLGRAD_KEEP_MEDIUM, VOLGRAD_ERROR_INDEX, "lights.medium", POINT_LIGHT);
    RANGE(l[POINT_LIGHT].sampling_weight = 0, "lights.sampling_weight", POINT_LIGHT);
    NOT_FINITE_VEC(l[POINT_LIGHT].position, "lights.position", POINT_LIGHT);
    BAD(l[0].kind = VOLGRAD_LIGHT_DIRECTIONAL, VOLGRAD_ERROR_NOT_FINITE, "lights.direction", 0); /* of length 0 */
    BAD((l[0].kind = VOLGRAD_LIGHT_DIRECTIONAL, l[0].direction.y = NAN), VOLGRAD_ERROR_NOT_FINITE, "lights.direction", 0);
    RANGE((l[0].kind = VOLGRAD_LIGHT_DIRECTIONAL, l[0].direction.y = -1, l[0].sampling_weight = 0), "lights.sampling_weight", 0);
    RANGE(l[0].kind = VOLGRAD_LIGHT_SPHERE, "lights.radius", 0);
    BAD((l[0].kind = VOLGRAD_LIGHT_SPHERE, l[0].radius = INFINITY), VOLGRAD_ERROR_NOT_FINITE, "lights.radius", 0);
    for (uint32_t kind = VOLGRAD_LIGHT_PARALLELOGRAM; kind <= VOLGRAD_LIGHT_TRIANGLE; kind++) {
#define AREA_LIGHT (l[0].kind = kind, l[0].edge_u = vec(1, 0, 0), l[0].edge_v = vec(0, 1, 0))
        RANGE((AREA_LIGHT, l[0].edge_v = vec(2, 0, 0)), "lights.edge_u, lights.edge_v", 0);
        BAD((AREA_LIGHT, l[0].edge_u.z = NAN), VOLGRAD_ERROR_NOT_FINITE, "lights.edge_u", 0);
        BAD((AREA_LIGHT, l[0].edge_v.x = -INFINITY), VOLGRAD_ERROR_NOT_FINITE, "lights.edge_v", 0);
        BAD((AREA_LIGHT, l[0].position.x = NAN), VOLGRAD_ERROR_NOT_FINITE, "lights.position", 0);
    }

#define SPOT (l[0].kind = VOLGRAD_LIGHT_SPOT, l[0].direction.y = -1, l[0].cos_inner = 0.9f, l[0].cos_outer = 0.8f)
    BAD((SPOT, l[0].direction.y = 2), VOLGRAD_ERROR_NOT_FINITE, "lights.direction", 0);
    BAD((SPOT, l[0].cos_outer = NAN), VOLGRAD_ERROR_NOT_FINITE, "lights.cos_outer", 0);
    RANGE((SPOT, l[0].cos_inner = 1.01f), "lights.cos_inner", 0);
    RANGE((SPOT, l[0].cos_outer = 0.91f), "lights.cos_outer", 0);
    RANGE((SPOT, l[0].cos_outer = -1.01f), "lights.cos_outer", 0);
    RANGE((SPOT, l[0].sampling_weight = 0), "lights.sampling_weight", 0);

    float texels[2 * 2 * 3] = {1, 2, 3};
#define MAP \
    (l[SKY].kind = VOLGRAD_LIGHT_ENVIRONMENT_MAP, l[SKY].edge_u.x = l[SKY].edge_v.y = l[SKY].direction.z = 1, \
     l[SKY].image = texels, l[SKY].image_width = l[SKY].image_height = 2)
    const char *image_size = "lights.image_width, lights.image_height";
    RANGE((MAP, l[SKY].image_width = 0), image_size, SKY);
    RANGE((MAP, l[SKY].image_height = 1), image_size, SKY);
    RANGE((MAP, l[SKY].image_height = 1u << 16), image_size, SKY);
    BAD((MAP, l[SKY].image = NULL), VOLGRAD_ERROR_NULL, "lights.image", SKY);
    BAD((MAP, l[SKY].image = (const float *)(const void *)(memory + 1)), VOLGRAD_ERROR_MISALIGNED, "lights.image", SKY);
    BAD((MAP, l[SKY].edge_u.x = 0), VOLGRAD_ERROR_NOT_FINITE, "lights.edge_u", SKY);
    BAD((MAP, l[SKY].edge_v.y = NAN), VOLGRAD_ERROR_NOT_FINITE, "lights.edge_v", SKY);
    BAD((MAP, l[SKY].direction.z = 3), VOLGRAD_ERROR_NOT_FINITE, "lights.direction", SKY);
    RANGE((MAP, l[SKY].edge_v = vec(1, 0, 0)), "lights.edge_u, lights.edge_v, lights.direction", SKY);
    RANGE((MAP, l[0].kind = VOLGRAD_LIGHT_ENVIRONMENT), "lights.kind", SKY); /* one environment too many */
    texels[11] = -1;
    RANGE(MAP, "lights.image", SKY);
    texels[11] = INFINITY;
    BAD(MAP, VOLGRAD_ERROR_NOT_FINITE, "lights.image", SKY);

    BAD(s.desc.media = NULL, VOLGRAD_ERROR_NULL, "media", 0);
    BAD(s.desc.materials = NULL, VOLGRAD_ERROR_NULL, "materials", 0);
    BAD(s.desc.lights = NULL, VOLGRAD_ERROR_NULL, "lights", 0);
    BAD(s.desc.lights = (const void *)(memory + 2), VOLGRAD_ERROR_MISALIGNED, "lights", 0);
}

/* An environment map's sums need memory. */
static void test_environment_map(void) {
    static const float texels[5 * 7 * 3] = {[40] = 1};
    const volgrad_scene *scene;
    size_t without, with;
    CHECK_STATUS(volgrad_scene_size(&s.desc, &without), VOLGRAD_OK);
    volgrad_light *sky = &s.lights[SKY];
    sky->kind = VOLGRAD_LIGHT_ENVIRONMENT_MAP;
    sky->edge_u.x = sky->edge_v.y = sky->direction.z = 1;
    sky->image = texels, sky->image_width = 5, sky->image_height = 7;
    CHECK_STATUS(volgrad_scene_size(&s.desc, &with), VOLGRAD_OK);
    CHECK(with >= without + 6 * 6 * sizeof(double));
    FILL(memory);
    CHECK_STATUS(volgrad_scene_init(memory, with, &s.desc, &scene, NULL), VOLGRAD_OK);
    CHECK(untouched(memory + with, sizeof memory - with));
    fill();
}

static void test_pointers(void) {
    const volgrad_scene *scene;
    size_t bytes = 0, other;
    volgrad_scene_desc *desc = &s.desc;
    CHECK_STATUS(volgrad_scene_size(desc, &bytes), VOLGRAD_OK);
    CHECK(bytes > 0 && bytes <= sizeof memory - 64);
    CHECK_STATUS(volgrad_scene_size(desc, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(other, volgrad_scene_size(NULL, &other), VOLGRAD_ERROR_NULL);
    REFUSED(other, volgrad_scene_size((const void *)(memory + 4), &other), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(volgrad_scene_size(desc, (void *)(memory + 1)), VOLGRAD_ERROR_MISALIGNED);

    CHECK_STATUS(volgrad_scene_init(memory, bytes, desc, NULL, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(scene, volgrad_scene_init(NULL, bytes, desc, &scene, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(scene, volgrad_scene_init(memory, bytes, NULL, &scene, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(scene, volgrad_scene_init(memory + 8, bytes, desc, &scene, NULL), VOLGRAD_ERROR_MISALIGNED);
    REFUSED(scene, volgrad_scene_init(memory, bytes, (const void *)(memory + 4), &scene, NULL), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(volgrad_scene_init(memory, bytes, desc, (void *)(memory + 4), NULL), VOLGRAD_ERROR_MISALIGNED);
    REFUSED(scene, volgrad_scene_init(memory, bytes - 1, desc, &scene, NULL), VOLGRAD_ERROR_TOO_SMALL);
    REFUSED(scene, volgrad_scene_init(memory, 0, desc, &scene, NULL), VOLGRAD_ERROR_TOO_SMALL);

    /* It keeps within its memory, and says nothing on success. */
    volgrad_error error = {sizeof error, 77, "untouched"};
    FILL(memory);
    CHECK_STATUS(volgrad_scene_init(memory, bytes, desc, &scene, &error), VOLGRAD_OK);
    CHECK(scene != NULL && untouched(memory + bytes, sizeof memory - bytes));
    CHECK(error.index == 77 && strcmp(error.field, "untouched") == 0);

    /* A caller with a smaller error struct, and one whose size makes no sense. */
    volgrad_error small = {offsetof(volgrad_error, field), 77, "untouched"};
    CHECK_STATUS(volgrad_scene_init(memory, 1, desc, &scene, &small), VOLGRAD_ERROR_TOO_SMALL);
    CHECK(small.struct_size == offsetof(volgrad_error, field) && small.index == 0 && strcmp(small.field, "untouched") == 0);
    small.struct_size = small.index = 0;
    CHECK_STATUS(volgrad_scene_init(memory, 1, desc, &scene, &small), VOLGRAD_ERROR_TOO_SMALL);
    CHECK(small.struct_size == 0 && strcmp(small.field, "untouched") == 0);

    /* Without media, materials and lights; arrays may be NULL then, in a zeroed medium index even. */
    desc->media_count = desc->material_count = desc->light_count = 0;
    desc->media = NULL, desc->materials = NULL, desc->lights = NULL;
    desc->camera.medium = VOLGRAD_NONE;
    CHECK_STATUS(volgrad_scene_init(memory, sizeof memory, desc, &scene, NULL), VOLGRAD_OK);
    fill();
}

static void test_struct_size(void) {
    struct {
        volgrad_scene_desc desc;
        unsigned char tail[4200];
    } larger;
    size_t bytes;
    memset(&larger, 0, sizeof larger);
    larger.desc = s.desc;
    const struct {
        size_t size;
        volgrad_status status;
    } cases[] = {
        {0, VOLGRAD_ERROR_STRUCT_SIZE},
        {3, VOLGRAD_ERROR_STRUCT_SIZE},
        {sizeof s.desc + 8, VOLGRAD_OK},
        {4096, VOLGRAD_OK},
        {4097, VOLGRAD_ERROR_STRUCT_SIZE},
        {UINT32_MAX, VOLGRAD_ERROR_STRUCT_SIZE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const volgrad_scene *scene;
        larger.desc.struct_size = (uint32_t)cases[i].size;
        FILL(bytes), FILL(scene);
        CHECK_STATUS(volgrad_scene_size(&larger.desc, &bytes), cases[i].status);
        CHECK_STATUS(volgrad_scene_init(memory, sizeof memory, &larger.desc, &scene, NULL), cases[i].status);
        CHECK(UNTOUCHED(bytes) == (cases[i].status != VOLGRAD_OK) && UNTOUCHED(scene) == (cases[i].status != VOLGRAD_OK));
    }
    larger.desc.struct_size = sizeof s.desc + 8;
    larger.tail[7] = 1;
    REFUSED(bytes, volgrad_scene_size(&larger.desc, &bytes), VOLGRAD_ERROR_STRUCT_SIZE);
    larger.tail[7] = 0, larger.tail[8] = 1; /* past its end */
    CHECK_STATUS(volgrad_scene_size(&larger.desc, &bytes), VOLGRAD_OK);

    /* Ends within a pointer: no such version existed. */
    s.desc.struct_size = offsetof(volgrad_scene_desc, lights) + 4;
    REFUSED(bytes, volgrad_scene_size(&s.desc, &bytes), VOLGRAD_ERROR_STRUCT_SIZE);
    fill();
}

static void test_bounds(void) {
    const volgrad_scene *scene;
    NOT_FINITE_VEC(s.desc.bounds_centre, "bounds_centre", 0);
    NOT_FINITE(s.desc.bounds_radius, "bounds_radius", 0);
    RANGE(s.desc.bounds_radius = -1, "bounds_radius", 0);
    s.desc.bounds_centre = vec(1, 2, 3), s.desc.bounds_radius = 4;
    CHECK_STATUS(volgrad_scene_init(memory, sizeof memory, &s.desc, &scene, NULL), VOLGRAD_OK);
    fill();
}

/* Any index will do at a light that has no place, and NONE for one that has. */
static void test_media_of_lights(void) {
    const volgrad_scene *scene;
    s.lights[SKY].medium = 77, s.lights[POINT_LIGHT].medium = VOLGRAD_NONE;
    CHECK_STATUS(volgrad_scene_init(memory, sizeof memory, &s.desc, &scene, NULL), VOLGRAD_OK);
    fill();
}

int main(void) {
    fill();
    test_pointers();
    test_struct_size();
    test_camera();
    test_media();
    test_materials_and_lights();
    test_environment_map();
    test_bounds();
    test_media_of_lights();
    return check_end();
}
