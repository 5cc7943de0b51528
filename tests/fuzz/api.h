/* What the fuzzers of the C interface share: numbers, scenes and a host's answers, decoded from bytes. Most are what a host would write;
 * about one in twenty is NaN, infinite, huge, a kind that does not exist or an index past its array. Arrays are as long as they must be
 * and no longer, so that the address sanitizer sees what reads beyond them. */

#ifndef API_H
#define API_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "volgrad.h"

/* What must hold, whatever the input. */
#define MUST(condition) ((condition) ? (void)0 : (fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition), abort()))

/* ---- bytes ---- */

typedef struct input {
    const uint8_t *data;
    size_t size;
} input;

/* 0 after the end. */
static inline uint8_t next_byte(input *in) {
    if (in->size == 0) return 0;
    in->size--;
    return *in->data++;
}

static inline uint32_t pick(input *in, uint32_t choices) { return next_byte(in) % choices; }

static inline uint32_t next_word(input *in) {
    uint32_t word = next_byte(in);
    for (int i = 0; i < 3; i++) word = word << 8 | next_byte(in);
    return word;
}

/* One in twenty or so. */
static inline int hostile(input *in) { return next_byte(in) > 243; }

/* A number in [lo, hi], or one that is none of the kind. */
static inline float number(input *in, float lo, float hi) {
    static const float odd[] = {NAN, INFINITY, -INFINITY, 0, -0.0f, -1, 1, 1e-45f, 1e-38f, 3.4e38f, -3.4e38f, 1e-4f, 1e-7f, 1e9f};
    uint8_t b = next_byte(in);
    if (b < 240) return lo + (hi - lo) * (float)b / 239;
    if (b - 240u < sizeof odd / sizeof *odd) return odd[b - 240];
    uint32_t word = next_word(in);
    float any;
    memcpy(&any, &word, sizeof any);
    return any;
}

/* A kind or an index below `count`, or one that is not. */
static inline uint32_t below(input *in, uint32_t count) {
    static const uint32_t odd[] = {VOLGRAD_NONE, VOLGRAD_KEEP_MEDIUM, 0x7fffffff, 0x80000000, 1000, 65536};
    uint8_t b = next_byte(in);
    if (b >= 250) return odd[b - 250];
    if (b >= 244) return count + (b - 244);
    return count ? b % count : 0;
}

static inline uint32_t size_near(input *in, size_t true_size) {
    static const uint32_t odd[] = {0, 3, 4, 8, 4096, 4097, UINT32_MAX};
    if (!hostile(in)) return (uint32_t)true_size;
    uint32_t i = pick(in, 8);
    return i < 7 ? odd[i] : (uint32_t)true_size - 4;
}

/* The same of a struct behind which nothing is known, or its size before it grew. */
static inline uint32_t known_size(input *in, size_t true_size, size_t older_size) {
    uint32_t size = size_near(in, true_size);
    return size <= true_size ? size : (uint32_t)older_size;
}

static inline volgrad_rgb colour(input *in, float lo, float hi) {
    volgrad_rgb c;
    c.r = number(in, lo, hi);
    c.g = next_byte(in) & 1 ? number(in, lo, hi) : c.r;
    c.b = next_byte(in) & 1 ? number(in, lo, hi) : c.r;
    return c;
}

static inline volgrad_vec3 point(input *in) {
    volgrad_vec3 p = {number(in, -4, 4), number(in, -4, 4), number(in, -4, 4)};
    return p;
}

/* Unit length, but for odd numbers. */
static inline volgrad_vec3 direction(input *in) {
    volgrad_vec3 v = {number(in, -1, 1), number(in, -1, 1), number(in, -1, 1)};
    float length = sqrtf(v.x * v.x + v.y * v.y + v.z * v.z);
    if (!(length > 0) || hostile(in)) return v;
    v.x /= length, v.y /= length, v.z /= length;
    return v;
}

/* ---- memory that is freed at the end of an input ---- */

enum { MOST_BLOCKS = 128 };

typedef struct arena {
    void *blocks[MOST_BLOCKS];
    int count;
} arena;

static inline void *take(arena *a, size_t bytes) {
    MUST(a->count < MOST_BLOCKS);
    void *block = aligned_alloc(16, (bytes + 15) / 16 * 16 + (bytes == 0) * 16);
    MUST(block != NULL);
    memset(block, 0xA5, bytes);
    return a->blocks[a->count++] = block;
}

/* Exactly so many bytes, so that the sanitizer knows the end. */
static inline void *take_array(arena *a, size_t bytes) {
    MUST(a->count < MOST_BLOCKS);
    void *block = calloc(1, bytes ? bytes : 1);
    MUST(block != NULL);
    return a->blocks[a->count++] = block;
}

static inline void release(arena *a) {
    while (a->count > 0) free(a->blocks[--a->count]);
}

/* ---- a scene, and what it is made of ---- */

enum { MOST_MEDIA = 3, MOST_MATERIALS = 4, MOST_LIGHTS = 4, MOST_PHASES = 2, MOST_BALLS = 4, MOST_SIDE = 12 };

/* The geometry: balls, which end a medium, or are surfaces, or lights. */
typedef struct ball {
    volgrad_vec3 centre;
    float radius;
    int is_null;
    uint32_t material, light, inside, outside;
} ball;

typedef struct world {
    arena memory;
    volgrad_scene_desc desc;
    const volgrad_scene *scene;
    volgrad_queries queries;
    ball balls[MOST_BALLS];
    uint32_t ball_count;
    /* Of 256 answers so many are nonsense, or none at all; state of the random numbers that decide. */
    uint32_t nonsense;
    uint32_t random;
    /* Whether some callback of the scene answers nonsense, or not twice the same. */
    int lies;
    /* What is left before every call is stopped, so that no input takes long. */
    uint32_t patience;
} world;

static inline uint32_t next_random(world *w) {
    w->random = w->random * 1664525u + 1013904223u;
    return w->random >> 8;
}

static inline volgrad_camera decode_camera(input *in, uint32_t media_count) {
    volgrad_camera c;
    memset(&c, 0, sizeof c);
    c.kind = below(in, 2);
    c.width = c.height = c.crop_x1 = c.crop_y1 = 1 + pick(in, MOST_SIDE);
    if (hostile(in)) c.height = c.crop_y1 = below(in, MOST_SIDE);
    if (next_byte(in) > 200) c.crop_x0 = below(in, c.width), c.crop_y1 = below(in, c.height + 1);
    c.medium = next_byte(in) & 1 ? VOLGRAD_NONE : below(in, media_count);
    c.position = point(in);
    c.forward.z = c.right.x = c.up.y = 1;
    if (hostile(in)) c.forward = direction(in);
    if (hostile(in)) c.up = direction(in);
    c.tan_half_fov_x = number(in, 0.2f, 2);
    if (next_byte(in) > 200) c.near_clip = number(in, 0, 1);
    if (c.kind == VOLGRAD_CAMERA_THIN_LENS) c.lens_radius = number(in, 0.01f, 0.3f), c.focal_distance = number(in, 0.5f, 4);
    return c;
}

#include "api_host.h"

static inline void decode_box(input *in, volgrad_medium *m) {
    m->local_to_world[0] = m->local_to_world[5] = m->local_to_world[10] = number(in, 0.5f, 4);
    if (next_byte(in) > 200) for (int i = 0; i < 12; i++) m->local_to_world[i] = number(in, -3, 3);
    else m->local_to_world[3] = m->local_to_world[7] = m->local_to_world[11] = -0.5f * m->local_to_world[0];
}

/* Some bytes make all values: most of them are alike, or 0. */
static inline float *decode_densities(input *in, arena *a, uint32_t count) {
    float *values = take_array(a, count * sizeof *values);
    uint32_t sparse = pick(in, 4);
    for (uint32_t i = 0, run = 0; i < count; i++) {
        if (run == 0) values[i] = sparse > 1 && pick(in, 2) ? 0 : number(in, 0, 1), run = 1 + pick(in, 40);
        else values[i] = sparse & 1 ? values[i - 1] : (float)(i * 7 % 13) / 13, run--;
    }
    return values;
}

static inline void decode_grid(input *in, arena *a, volgrad_medium *m) {
    m->nx = 1 + pick(in, 10), m->ny = 1 + pick(in, 10), m->nz = 1 + pick(in, 10);
    uint32_t count = m->nx * m->ny * m->nz;
    m->density = decode_densities(in, a, count);
    if (hostile(in)) m->nx = below(in, 10); /* not larger: what is behind is unknown */
    if ((size_t)m->nx * m->ny * m->nz > count) m->nx = 0;
    if (hostile(in)) m->density = NULL;
}

/* Blocks whose common layers differ, as no header allows, among them. */
static inline void decode_sparse(input *in, arena *a, volgrad_medium *m) {
    enum { MOST = 3, SIDE = 20 };
    m->nx = 1 + pick(in, SIDE), m->ny = 1 + pick(in, SIDE), m->nz = 1 + pick(in, SIDE);
    uint32_t bricks = (m->nx + 8) / 8 * ((m->ny + 8) / 8) * ((m->nz + 8) / 8);
    volgrad_sparse_grid *grid = take_array(a, sizeof *grid);
    uint32_t *blocks = take_array(a, bricks * sizeof *blocks);
    grid->block_count = 1 + pick(in, MOST);
    for (uint32_t i = 0; i < bricks; i++) blocks[i] = below(in, grid->block_count);
    grid->density = decode_densities(in, a, grid->block_count * VOLGRAD_BLOCK_SAMPLES);
    grid->blocks = hostile(in) ? NULL : blocks;
    grid->struct_size = known_size(in, sizeof *grid, 8);
    if (hostile(in)) grid->density = NULL;
    if (hostile(in)) grid->block_count = pick(in, grid->block_count); /* not larger */
    if (hostile(in)) m->nx = pick(in, m->nx);
    m->custom = grid;
}

static inline void decode_custom(input *in, world *w, volgrad_medium *m) {
    volgrad_custom_density *custom = take_array(&w->memory, sizeof *custom);
    waves *user = take_array(&w->memory, sizeof *user);
    for (int i = 0; i < 4; i++) user->bend[i] = number(in, 0.1f, 3);
    custom->struct_size = known_size(in, sizeof *custom, offsetof(volgrad_custom_density, integrals));
    custom->user = user;
    custom->density = hostile(in) ? NULL : densities;
    custom->gradient = hostile(in) ? NULL : density_gradients;
    custom->step = number(in, 0.05f, 1);
    if (custom->step > 0 && custom->step < 0.01f) custom->step = 0.01f; /* time */
    custom->majorant = number(in, 2, 8);
    if (pick(in, 2)) custom->integrals = density_integrals, user->habit = decode_habit(in, w);
    m->custom = custom;
}

static inline void decode_medium(input *in, world *w, volgrad_medium *m) {
    m->kind = below(in, 4);
    m->phase.kind = below(in, 3);
    m->phase.g = number(in, -0.99f, 0.99f);
    if (m->phase.kind == VOLGRAD_PHASE_CUSTOM || hostile(in)) m->custom_phase = below(in, MOST_PHASES);
    m->sigma_t = colour(in, 0, 4);
    m->albedo = colour(in, 0, 1);
    if (m->kind != VOLGRAD_MEDIUM_HOMOGENEOUS) decode_box(in, m);
    if (m->kind == VOLGRAD_MEDIUM_GRID) decode_grid(in, &w->memory, m);
    if (m->kind == VOLGRAD_MEDIUM_CUSTOM) decode_custom(in, w, m);
    if (m->kind == VOLGRAD_MEDIUM_SPARSE_GRID) decode_sparse(in, &w->memory, m);
}

static inline const volgrad_custom_phase *decode_phase(input *in, world *w) {
    volgrad_custom_phase *custom = take_array(&w->memory, sizeof *custom);
    habit *user = take_array(&w->memory, sizeof *user);
    *user = decode_habit(in, w);
    custom->struct_size = known_size(in, sizeof *custom, 8);
    custom->user = user;
    custom->eval = hostile(in) ? NULL : phase_value;
    custom->sample = hostile(in) ? NULL : phase_cosine;
    custom->log_derivative = pick(in, 2) ? phase_slope : NULL;
    return hostile(in) ? NULL : custom;
}

static inline void decode_bsdf(input *in, world *w, volgrad_material *m) {
    volgrad_custom_bsdf *custom = take_array(&w->memory, sizeof *custom);
    habit *user = take_array(&w->memory, sizeof *user);
    *user = decode_habit(in, w);
    custom->struct_size = known_size(in, sizeof *custom, 8);
    custom->flags = below(in, 3);
    if (custom->flags == VOLGRAD_BSDF_TRANSMITS && !hostile(in)) m->flags = 0;
    user->transmits = custom->flags == VOLGRAD_BSDF_TRANSMITS;
    custom->user = user;
    custom->eval = hostile(in) ? NULL : bsdf_value;
    custom->pdf = hostile(in) ? NULL : bsdf_pdf;
    custom->sample = hostile(in) ? NULL : bsdf_sample;
    custom->log_gradient = pick(in, 2) ? bsdf_gradient : NULL;
    m->custom = hostile(in) ? NULL : custom;
}

static inline void decode_material(input *in, world *w, volgrad_material *m) {
    static const float roughnesses[] = {0, 0.1f, 0.5f, 1e-4f};
    m->kind = below(in, 5);
    m->flags = below(in, 2);
    m->reflectance = colour(in, 0, 1);
    m->eta = number(in, 0.5f, 2);
    m->roughness = hostile(in) ? number(in, 0, 1) : roughnesses[pick(in, 4)];
    m->conductor_eta = colour(in, 0, 3);
    m->conductor_k = colour(in, 0, 4);
    if (m->kind == VOLGRAD_MATERIAL_CUSTOM) decode_bsdf(in, w, m);
    else if (hostile(in)) m->custom = (const void *)m;
}

static inline void decode_image(input *in, arena *a, volgrad_light *l) {
    volgrad_vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    l->edge_u = x, l->edge_v = y, l->direction = z;
    l->image_width = 1 + pick(in, 6), l->image_height = 2 + pick(in, 4);
    uint32_t count = 3 * l->image_width * l->image_height;
    float *image = take_array(a, count * sizeof *image);
    for (uint32_t i = 0; i < count; i++) image[i] = i % 5 ? (float)(i % 3) : number(in, 0, 4);
    l->image = hostile(in) ? NULL : image;
    if (hostile(in)) l->image_height = pick(in, 2);
}

static inline void decode_shine(input *in, world *w, volgrad_light *l) {
    volgrad_custom_light *custom = take_array(&w->memory, sizeof *custom);
    habit *user = take_array(&w->memory, sizeof *user);
    *user = decode_habit(in, w);
    custom->struct_size = known_size(in, sizeof *custom, 8);
    custom->user = user;
    custom->emission = hostile(in) ? NULL : light_emission;
    custom->pdf = hostile(in) ? NULL : sky_pdf;
    custom->sample = hostile(in) ? NULL : sky_sample;
    custom->log_gradient = pick(in, 2) ? light_gradient : NULL;
    l->custom = hostile(in) ? NULL : custom;
}

static inline void decode_light(input *in, world *w, volgrad_light *l, uint32_t media_count) {
    l->kind = below(in, 10);
    l->medium = next_byte(in) & 1 ? VOLGRAD_NONE : below(in, media_count);
    l->emission = colour(in, 0, 10);
    l->sampling_weight = number(in, 0.1f, 1);
    l->position = point(in);
    l->edge_u = point(in);
    l->edge_v = point(in);
    l->radius = number(in, 0.1f, 1);
    l->direction = direction(in);
    l->cos_inner = number(in, 0.5f, 1);
    l->cos_outer = number(in, -1, 0.5f);
    if (l->kind == VOLGRAD_LIGHT_ENVIRONMENT_MAP) decode_image(in, &w->memory, l);
    if (l->kind == VOLGRAD_LIGHT_CUSTOM_SKY || l->kind == VOLGRAD_LIGHT_CUSTOM_POINT) decode_shine(in, w, l);
    else if (hostile(in)) l->custom = (const void *)l;
}

static inline void decode_ball(input *in, const volgrad_scene_desc *d, ball *b) {
    b->centre = point(in);
    b->radius = fabsf(number(in, 0.2f, 2));
    b->is_null = next_byte(in) & 1;
    b->material = d->material_count ? pick(in, d->material_count) : 0;
    b->light = next_byte(in) & 1 && d->light_count ? pick(in, d->light_count) : VOLGRAD_NONE;
    uint32_t media = d->media_count + 1;
    b->inside = pick(in, media), b->outside = pick(in, media);
    if (b->inside == d->media_count) b->inside = VOLGRAD_NONE;
    if (b->outside == d->media_count) b->outside = VOLGRAD_NONE;
    if (!b->is_null && d->material_count == 0) b->is_null = 1;
    if (!b->is_null && next_byte(in) & 1) b->inside = b->outside = VOLGRAD_KEEP_MEDIUM;
}

/* ---- the host's answers ---- */

/* Where the ray crosses the ball, after 0. */
static inline int cross(const ball *b, const volgrad_ray *ray, float t[2]) {
    double x = ray->origin.x - b->centre.x, y = ray->origin.y - b->centre.y, z = ray->origin.z - b->centre.z;
    double half = x * ray->direction.x + y * ray->direction.y + z * ray->direction.z;
    double root = half * half - (x * x + y * y + z * z - (double)b->radius * b->radius);
    if (!(root > 0)) return 0;
    root = sqrt(root);
    int n = 0;
    if (-half - root > 0) t[n++] = (float)(-half - root);
    if (-half + root > 0) t[n++] = (float)(-half + root);
    return n;
}

static inline volgrad_vec3 normal_at(const ball *b, const volgrad_ray *ray, float t) {
    volgrad_vec3 n = {ray->origin.x + t * ray->direction.x - b->centre.x, ray->origin.y + t * ray->direction.y - b->centre.y,
        ray->origin.z + t * ray->direction.z - b->centre.z};
    float length = sqrtf(n.x * n.x + n.y * n.y + n.z * n.z);
    n.x /= length, n.y /= length, n.z /= length;
    return n;
}

static inline void answer(const world *w, const volgrad_ray *ray, volgrad_hit *hit) {
    memset(hit, 0xFF, sizeof *hit);
    hit->kind = VOLGRAD_HIT_NONE;
    float end = ray->t_max;
    for (uint32_t i = 0; i < w->ball_count; i++) {
        float t[2];
        const ball *b = &w->balls[i];
        if (b->is_null) continue;
        for (int k = 0, n = cross(b, ray, t); k < n; k++) {
            if (!(t[k] >= ray->t_min && t[k] < end)) continue;
            hit->kind = VOLGRAD_HIT_SURFACE;
            hit->material = b->material, hit->light = b->light, hit->user = SAID;
            hit->t = end = t[k];
            hit->normal = hit->shading_normal = normal_at(b, ray, end);
            hit->medium_inside = b->inside, hit->medium_outside = b->outside;
        }
    }
    uint32_t medium = ray->medium;
    hit->segment_count = 0;
    float from = 0;
    for (;;) { /* the nearest null surface beyond `from` */
        const ball *next = NULL;
        float nearest = end;
        for (uint32_t i = 0; i < w->ball_count; i++) {
            float t[2];
            const ball *b = &w->balls[i];
            for (int k = 0, n = b->is_null ? cross(b, ray, t) : 0; k < n; k++) {
                if (t[k] > from && t[k] < nearest) nearest = t[k], next = b;
            }
        }
        if (hit->segment_count == VOLGRAD_MAX_SEGMENTS) {
            hit->kind = VOLGRAD_HIT_OVERFLOW;
            return;
        }
        volgrad_segment *s = &hit->segments[hit->segment_count++];
        s->end = nearest, s->medium = medium;
        if (next == NULL) return;
        s->normal = normal_at(next, ray, nearest);
        volgrad_vec3 d = ray->direction;
        medium = s->normal.x * d.x + s->normal.y * d.y + s->normal.z * d.z < 0 ? next->inside : next->outside;
        from = nearest;
    }
}

/* What breaks the rules of a hit, or keeps them barely. */
static inline void spoil(world *w, volgrad_hit *hit) {
    static const float odd[] = {NAN, INFINITY, -INFINITY, 0, -1, 1e-45f, 3.4e38f, 1e-20f};
    float number = odd[next_random(w) % 8];
    uint32_t index = next_random(w) % 3 ? next_random(w) % 20 : VOLGRAD_NONE - next_random(w) % 3;
    switch (next_random(w) % 10) {
    case 0: hit->kind = index; break;
    case 1: hit->material = index; break;
    case 2: hit->light = index; break;
    case 3: hit->segment_count = index; break;
    case 4: hit->t = number; break;
    case 5: hit->normal.x = number; break;
    case 6: hit->medium_outside = index; break;
    case 7: hit->medium_inside = index; break;
    case 8: hit->segments[next_random(w) % 2].end = number; break;
    default: hit->segments[next_random(w) % 2].medium = index; break;
    }
}

static inline int32_t ask(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count) {
    world *w = user;
    for (uint32_t i = 0; i < count; i++) {
        if (w->patience == 0) return 1;
        w->patience--;
        answer(w, &rays[i], &hits[i]);
        if (next_random(w) % 256 < w->nonsense) {
            spoil(w, &hits[i]);
            volgrad_hit_validate(w->scene, &rays[i], &hits[i], NULL);
        }
    }
    return 0;
}

/* ---- all of it ---- */

enum { MOST_RAYS = 20000 };

static inline void decode_desc(input *in, world *w) {
    memset(w, 0, sizeof *w);
    volgrad_scene_desc *d = &w->desc;
    d->struct_size = known_size(in, sizeof *d, offsetof(volgrad_scene_desc, phases));
    d->media_count = pick(in, MOST_MEDIA + 1), d->material_count = pick(in, MOST_MATERIALS + 1);
    d->light_count = pick(in, MOST_LIGHTS + 1);
    volgrad_medium *media = take_array(&w->memory, d->media_count * sizeof *media);
    volgrad_material *materials = take_array(&w->memory, d->material_count * sizeof *materials);
    volgrad_light *lights = take_array(&w->memory, d->light_count * sizeof *lights);
    for (uint32_t i = 0; i < d->media_count; i++) decode_medium(in, w, &media[i]);
    for (uint32_t i = 0; i < d->material_count; i++) decode_material(in, w, &materials[i]);
    for (uint32_t i = 0; i < d->light_count; i++) decode_light(in, w, &lights[i], d->media_count);
    d->camera = decode_camera(in, d->media_count);
    d->media = media, d->materials = materials, d->lights = lights;
    if (next_byte(in) & 1) d->bounds_radius = number(in, 1, 10);
    int custom = hostile(in);
    for (uint32_t i = 0; i < d->media_count; i++) custom |= media[i].phase.kind == VOLGRAD_PHASE_CUSTOM;
    if (!custom) return;
    const volgrad_custom_phase **phases = take_array(&w->memory, MOST_PHASES * sizeof *phases);
    for (uint32_t i = 0; i < MOST_PHASES; i++) phases[i] = decode_phase(in, w);
    d->phases = hostile(in) ? NULL : phases;
    d->phase_count = hostile(in) ? pick(in, MOST_PHASES) : MOST_PHASES;
}

/* NULL if the description is refused, as many are. */
static inline const volgrad_scene *decode_world(input *in, world *w) {
    decode_desc(in, w);
    size_t bytes = 0;
    if (volgrad_scene_size(&w->desc, &bytes) != VOLGRAD_OK) return NULL;
    volgrad_error error = {sizeof error, 0, NULL};
    volgrad_status status = volgrad_scene_init(take(&w->memory, bytes), bytes, &w->desc, &w->scene, &error);
    MUST((status == VOLGRAD_OK) == (w->scene != NULL));
    w->ball_count = pick(in, MOST_BALLS + 1);
    for (uint32_t i = 0; i < w->ball_count; i++) decode_ball(in, &w->desc, &w->balls[i]);
    if (pick(in, 3) == 0) w->nonsense = pick(in, 32);
    w->random = next_byte(in);
    w->patience = MOST_RAYS;
    w->queries.struct_size = sizeof w->queries;
    w->queries.user = w;
    w->queries.intersect = w->queries.occluded = ask;
    return w->scene;
}

static inline void decode_shift(input *in, volgrad_shift_options *o) {
    static const uint32_t counts[] = {8, 8, 3, 15, 24, 35, 1, 7};
    MUST(volgrad_shift_options_default(o, sizeof *o) == VOLGRAD_OK);
    o->mode = below(in, 10);
    o->kernel = below(in, 3);
    o->radius_unit = below(in, 2);
    if (o->kernel == VOLGRAD_KERNEL_BALL && !hostile(in)) o->radius_unit = VOLGRAD_RADIUS_WORLD;
    o->radius = number(in, 0.01f, 3);
    o->count = hostile(in) ? below(in, 36) : counts[pick(in, 8)];
    o->run = hostile(in) ? below(in, 9) : 1 + pick(in, 8);
    o->exact_count = hostile(in) ? below(in, 9) : 1;
    o->alpha = number(in, 0, 1);
    o->clamp = pick(in, 2) ? 0 : number(in, 0, 10);
    if (hostile(in)) o->struct_size = 12;
}

static inline volgrad_film *take_film(arena *a, uint32_t width, uint32_t height) {
    size_t bytes = 0;
    volgrad_film *film = NULL;
    if (volgrad_film_size(width, height, &bytes) != VOLGRAD_OK || bytes > 1 << 22) return NULL;
    volgrad_status (*init)(void *, size_t, uint32_t, uint32_t, volgrad_film **) = width % 2 ? volgrad_film_init_shared : volgrad_film_init;
    MUST(init(take(a, bytes), bytes, width, height, &film) == VOLGRAD_OK);
    return film;
}

/* What came out is an image. */
static inline void check_film(arena *a, const volgrad_film *film, uint32_t width, uint32_t height) {
    size_t count = (size_t)3 * width * height;
    float *rgb = take_array(a, count * sizeof *rgb);
    uint64_t dropped;
    MUST(volgrad_film_develop(film, 0.5, rgb, count) == VOLGRAD_OK);
    MUST(volgrad_film_dropped(film, &dropped) == VOLGRAD_OK);
    for (size_t i = 0; i < count; i++) MUST(isfinite(rgb[i]));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Without a fuzzer: the inputs in the files that are named. */
#endif
