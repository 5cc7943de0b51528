/* A path tracer with its own rays, volume, free flights, phase functions and light samples, which uses volgrad to get
 * its noise down: the light paths that it finds, tile by tile, are handed to volgrad_shift_paths, and each comes back as splats in all pixels
 * of its tile. Smoke on the ground under an even sky (scenes/smoke.xml), plain and shifted in the same time, beside the reference.
 * cc -O2 -Iinclude examples_c/own_path_tracer.c build/libvolgrad.a -lm -lpthread -ldl -lgcc_s
 * ./a.out [SECONDS [SIDE [LOOSE [EDGES]]]], in the root folder: of each; pixels along a tile; how many times too high the majorant of delta
 * tracking is, to see what a renderer gains whose paths are dearer; edges of the longest paths that are shifted. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <volgrad.h>

/* ---- small vectors, random numbers ---- */

typedef struct { double x, y, z; } vec;

static const double PI = 3.14159265358979323846;

static vec at(vec o, double t, vec d) { return (vec){o.x + t * d.x, o.y + t * d.y, o.z + t * d.z}; }
static double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec cross(vec a, vec b) { return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static vec unit(vec a) { return at((vec){0, 0, 0}, 1 / sqrt(dot(a, a)), a); }
static volgrad_vec3 narrow(vec a) { return (volgrad_vec3){(float)a.x, (float)a.y, (float)a.z}; }
static vec wide(volgrad_vec3 a) { return (vec){a.x, a.y, a.z}; }
static volgrad_rgb times(volgrad_rgb a, volgrad_rgb b) { return (volgrad_rgb){a.r * b.r, a.g * b.g, a.b * b.b}; }
static volgrad_rgb scaled(double s, volgrad_rgb a) { return (volgrad_rgb){(float)(s * a.r), (float)(s * a.g), (float)(s * a.b)}; }

/* PCG32 [O'Neill 2014]. */
static uint64_t state = 1;

static double uniform(void)
{
    uint64_t old = state;
    state = old * 6364136223846793005u + 1442695040888963407u;
    uint32_t word = (uint32_t)(((old >> 18) ^ old) >> 27), turn = (uint32_t)(old >> 59);
    return ((word >> turn | word << ((32 - turn) & 31)) + 0.5) * 0x1p-32;
}

/* A unit vector at an angle of this cosine to `axis`. */
static vec around(vec axis, double cosine)
{
    double sine = sqrt(fmax(0, 1 - cosine * cosine)), angle = 2 * PI * uniform();
    vec u = unit(cross(fabs(axis.x) < 0.5 ? (vec){1, 0, 0} : (vec){0, 1, 0}, axis)), v = cross(axis, u);
    return unit(at(at(at((vec){0, 0, 0}, cosine, axis), sine * cos(angle), u), sine * sin(angle), v));
}

/* ---- the scene: smoke in a box over the ground, nothing else ---- */

enum { SMOKE = 0, GROUND = 0, SKY = 0, SIZE = 128, MAX_EDGES = 32, ROULETTE = 5 };

static const vec LOW = {-1, 0.01, -1}, HIGH = {1, 4.01, 1};
static const volgrad_rgb ALBEDO = {0.62f, 0.58f, 0.52f}, REFLECTANCE = {0.45f, 0.42f, 0.38f}, RADIANCE = {0.75f, 0.9f, 1.1f};
static const double EXTINCTION = 18, G = 0.7, GROUND_EDGE = 30;

static struct {
    float *density;
    double majorant; /* 1/world unit */
    uint32_t n[3];
} grid;

/* Trilinear between samples, constant beyond the outermost. */
static double extinction(vec p)
{
    double c[3] = {(p.x - LOW.x) / 2, (p.y - LOW.y) / 4, (p.z - LOW.z) / 2}, f[3], sum = 0;
    size_t i[3], step[3] = {1, grid.n[0], (size_t)grid.n[0] * grid.n[1]};
    for (int a = 0; a < 3; a++) {
        double s = fmin(fmax(c[a] * grid.n[a] - 0.5, 0), grid.n[a] - 1.000001);
        i[a] = (size_t)s, f[a] = s - (double)i[a];
    }
    const float *corner = grid.density + i[0] + i[1] * step[1] + i[2] * step[2];
    for (int k = 0; k < 8; k++) {
        double weight = (k & 1 ? f[0] : 1 - f[0]) * (k & 2 ? f[1] : 1 - f[1]) * (k & 4 ? f[2] : 1 - f[2]);
        sum += weight * corner[(k & 1 ? step[0] : 0) + (k & 2 ? step[1] : 0) + (k & 4 ? step[2] : 0)];
    }
    return EXTINCTION * sum;
}

/* Where a ray is in the box: from *enter to *leave; and in which axes it passes its faces. */
static int box(vec o, vec d, double *enter, double *leave, int axes[2])
{
    const double from[3] = {o.x, o.y, o.z}, to[3] = {d.x, d.y, d.z};
    const double low[3] = {LOW.x, LOW.y, LOW.z}, high[3] = {HIGH.x, HIGH.y, HIGH.z};
    *enter = 0, *leave = INFINITY;
    for (int a = 0; a < 3; a++) {
        double t0 = (low[a] - from[a]) / to[a], t1 = (high[a] - from[a]) / to[a];
        if (fmin(t0, t1) > *enter) *enter = fmin(t0, t1), axes[0] = a;
        if (fmax(t0, t1) < *leave) *leave = fmax(t0, t1), axes[1] = a;
    }
    return *enter < *leave;
}

/* Distance to the ground, or INFINITY. */
static double ground(vec o, vec d)
{
    double t = -o.y / d.y;
    vec p = at(o, t, d);
    return t > 1e-5 && fabs(p.x) < GROUND_EDGE && fabs(p.z) < GROUND_EDGE ? t : INFINITY;
}

/* Delta tracking: where light is stopped before `length`, or INFINITY. */
static double collide(vec o, vec d, double length)
{
    double t, leave;
    int axes[2];
    if (!box(o, d, &t, &leave, axes)) return INFINITY;
    while ((t -= log(uniform()) / grid.majorant) < fmin(leave, length)) {
        if (uniform() * grid.majorant < extinction(at(o, t, d))) return t;
    }
    return INFINITY;
}

/* Ratio tracking: a transmittance that is right in the mean. */
static double transmittance(vec o, vec d)
{
    double t, leave, result = 1;
    int axes[2];
    if (!box(o, d, &t, &leave, axes)) return 1;
    while ((t -= log(uniform()) / grid.majorant) < leave) result *= 1 - extinction(at(o, t, d)) / grid.majorant;
    return result;
}

/* ---- what volgrad asks about the scene ---- */

static volgrad_vec3 face(int axis) { return (volgrad_vec3){axis == 0, axis == 1, axis == 2}; }

/* The media from `o` on, as far as `length`. What is known of the ends decides over rounding at the box's faces. */
static uint32_t media(vec o, vec d, double length, int starts_inside, int ends_inside, volgrad_segment *to)
{
    double enter, leave;
    int axes[2] = {0, 0};
    uint32_t count = 0;
    int crosses = box(o, d, &enter, &leave, axes) && enter < length;
    if (crosses || starts_inside || ends_inside) {
        if (!crosses) enter = leave = starts_inside ? 0 : length;
        if (!starts_inside && enter > 0) to[count++] = (volgrad_segment){(float)enter, VOLGRAD_NONE, face(axes[0])};
        to[count++] = (volgrad_segment){(float)fmin(ends_inside ? length : leave, length), SMOKE, face(axes[1])};
        if (ends_inside || leave >= length) return count;
    }
    to[count++] = (volgrad_segment){(float)length, VOLGRAD_NONE, {0, 0, 0}};
    return count;
}

static int32_t answer(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    (void)user;
    for (uint32_t i = 0; i < count; i++) {
        const volgrad_ray *ray = &rays[i];
        vec o = wide(ray->origin), d = wide(ray->direction);
        double t = ground(o, d);
        volgrad_hit *hit = &hits[i];
        hit->kind = t >= ray->t_min && t < ray->t_max ? VOLGRAD_HIT_SURFACE : VOLGRAD_HIT_NONE;
        hit->material = GROUND, hit->light = VOLGRAD_NONE;
        hit->t = (float)t;
        hit->normal = hit->shading_normal = (volgrad_vec3){0, 1, 0};
        hit->medium_outside = hit->medium_inside = VOLGRAD_KEEP_MEDIUM;
        hit->segment_count = media(o, d, fmin(t, ray->t_max), ray->medium == SMOKE, 0, hit->segments);
    }
    return 0;
}

/* ---- a path, as volgrad takes it ---- */

typedef struct {
    volgrad_vertex vertices[MAX_EDGES + 1];
    volgrad_segment segments[3 * MAX_EDGES];
    uint32_t edge_ends[MAX_EDGES];
    uint32_t edges;
} path;

/* Goes on from the last vertex for `length`, or to infinity. The new one is where its position says, in single precision. */
static vec add(path *p, uint32_t kind, uint32_t index, vec d, double length)
{
    volgrad_vertex *from = &p->vertices[p->edges], *to = from + 1;
    vec o = wide(from->position), x = kind == VOLGRAD_VERTEX_LIGHT ? d : at(o, length, d);
    uint32_t begin = p->edges == 0 ? 0 : p->edge_ends[p->edges - 1];
    *to = (volgrad_vertex){.kind = kind, .index = index, .position = narrow(x), .normal = {0, 1, 0}, .shading_normal = {0, 1, 0}};
    if (kind == VOLGRAD_VERTEX_SURFACE) to->position.y = 0;
    p->edge_ends[p->edges++] = begin + media(o, d, length, from->kind == VOLGRAD_VERTEX_MEDIUM, kind == VOLGRAD_VERTEX_MEDIUM,
                                             p->segments + begin);
    return wide(to->position);
}

/* ---- the renderer ---- */

static const volgrad_scene *scene;
static const volgrad_queries QUERIES = {.struct_size = sizeof QUERIES, .intersect = answer, .occluded = answer};
static volgrad_shift_options shift;
static uint32_t shifted_edges; /* longer paths stay as they are: one rule for all paths of a length, so that nothing is lost */

enum { KEPT = 256 };

typedef struct {
    volgrad_film *film;
    int is_shifted;
    uint64_t pass, handed_over;
    volgrad_splat at; /* the sample's pixel */
    uint32_t kept;    /* paths that are not handed over yet */
} image;

static void check(volgrad_status status)
{
    if (status == VOLGRAD_OK) return;
    fprintf(stderr, "own_path_tracer: %s\n", volgrad_status_message(status));
    exit(EXIT_FAILURE);
}

static path kept[KEPT];
static volgrad_path light_paths[KEPT];
static volgrad_rgb weights[KEPT];

/* Splats the paths, each in all pixels of its tile. */
static void hand_over(image *out)
{
    static volgrad_splat splats[KEPT * (VOLGRAD_MAX_SHIFTS + 1)];
    uint32_t count;
    check(volgrad_shift_paths(scene, &QUERIES, &shift, light_paths, weights, out->kept, out->pass, out->handed_over, splats,
                              sizeof splats / sizeof *splats, &count));
    check(volgrad_film_add(out->film, splats, count));
    out->handed_over += out->kept;
    out->kept = 0;
}

/* The sky, seen from the path's last vertex in direction d; `weight` is all that this path carries over its density. */
static void splat(image *out, const path *p, vec d, volgrad_rgb weight)
{
    out->at.value = weight;
    if (!out->is_shifted || p->edges == 0 || p->edges >= shifted_edges) {
        check(volgrad_film_add(out->film, &out->at, 1));
        return;
    }
    path *whole = &kept[out->kept];
    *whole = *p;
    add(whole, VOLGRAD_VERTEX_LIGHT, SKY, d, INFINITY);
    light_paths[out->kept] = (volgrad_path){whole->vertices, whole->segments, whole->edge_ends, whole->edges + 1,
                                            whole->edge_ends[whole->edges - 1]};
    weights[out->kept++] = weight;
    if (out->kept == KEPT) hand_over(out);
}

/* By Henyey-Greenstein's phase function or by the cosine to the ground: what scatters is the albedo, whatever the direction. */
static vec scatter(int in_smoke, vec d)
{
    double u = uniform(), s = (1 - G * G) / (1 - G + 2 * G * u);
    return in_smoke ? around(d, (1 + G * G - s * s) / (2 * G)) : around((vec){0, 1, 0}, sqrt(u));
}

/* The sky behind the smoke is no path to shift, so its noise would stay: volgrad's exact line integral has none. */
static double seen_sky(vec o, vec d)
{
    volgrad_segment segments[3];
    volgrad_line line = {narrow(o), narrow(d), INFINITY, media(o, d, INFINITY, 0, 0, segments), segments};
    volgrad_rgb tau;
    check(volgrad_line_tau(scene, &line, &tau));
    return exp(-tau.r);
}

static void trace(image *out, vec o, vec d)
{
    path p = {.vertices = {{.kind = VOLGRAD_VERTEX_CAMERA, .position = narrow(o)}}};
    volgrad_rgb carried = {1, 1, 1};
    if (isinf(ground(o, d))) splat(out, &p, d, scaled(seen_sky(o, d), RADIANCE));
    for (double survival = 1; p.edges < MAX_EDGES - 1 && uniform() < survival;) {
        double to_ground = ground(o, d), t = collide(o, d, to_ground);
        int in_smoke = t < to_ground;
        if (isinf(fmin(t, to_ground))) return;
        vec before = o;
        o = add(&p, in_smoke ? VOLGRAD_VERTEX_MEDIUM : VOLGRAD_VERTEX_SURFACE, in_smoke ? SMOKE : GROUND, d, fmin(t, to_ground));
        if (dot(at(o, -1, before), at(o, -1, before)) == 0) return; /* too near for single precision */
        carried = scaled(1 / survival, times(carried, in_smoke ? ALBEDO : REFLECTANCE));
        vec to_sky = scatter(in_smoke, d);
        if (isinf(ground(o, to_sky))) splat(out, &p, to_sky, scaled(transmittance(o, to_sky), times(carried, RADIANCE)));
        d = scatter(in_smoke, d);
        survival = p.edges < ROULETTE ? 1 : fmin(0.95, fmax(carried.r, fmax(carried.g, carried.b)));
    }
}

/* One path for each pixel, through the same place in all of them: points that fill the pixel evenly [Roberts 2018]. Tile by tile. */
static void render_pass(image *out, const volgrad_camera *camera)
{
    double i = (double)out->pass + 1, in_x = fmod(0.7548776662466927 * i, 1), in_y = fmod(0.5698402909980532 * i, 1);
    vec right = wide(camera->right), up = wide(camera->up);
    uint32_t tile[4]; /* x0, y0, x1, y1 */
    for (uint32_t y0 = 0; y0 < SIZE; y0 = tile[3]) {
        for (uint32_t x0 = 0; x0 < SIZE; x0 = tile[2]) {
            check(volgrad_shift_tile(scene, &shift, out->pass, x0, y0, tile));
            for (uint32_t y = y0; y < tile[3]; y++) {
                for (uint32_t x = x0; x < tile[2]; x++) {
                    double u = 2 * (x + in_x) / SIZE - 1, v = 1 - 2 * (y + in_y) / SIZE, tangent = camera->tan_half_fov_x;
                    out->at.x = (float)(x + in_x), out->at.y = (float)(y + in_y);
                    trace(out, wide(camera->position), unit(at(at(wide(camera->forward), tangent * u, right), tangent * v, up)));
                }
            }
        }
    }
    if (out->kept > 0) hand_over(out);
    out->pass++;
}

/* ---- the comparison ---- */

static void *memory(size_t bytes)
{
    void *block = aligned_alloc(16, (bytes + 15) / 16 * 16);
    if (!block) abort();
    return block;
}

/* scenes/README.md has the format: a head of 48 bytes, then the densities. */
static void load_smoke(const char *name, double looseness)
{
    unsigned char head[48];
    FILE *file = fopen(name, "rb");
    if (!file || fread(head, 1, sizeof head, file) != sizeof head || memcmp(head, "VOL\3", 4) != 0) {
        fprintf(stderr, "own_path_tracer: %s is no .vol file; run this in volgrad's root folder\n", name);
        exit(EXIT_FAILURE);
    }
    memcpy(grid.n, head + 8, sizeof grid.n);
    size_t count = (size_t)grid.n[0] * grid.n[1] * grid.n[2];
    grid.density = memory(count * sizeof *grid.density);
    if (fread(grid.density, sizeof *grid.density, count, file) != count) abort();
    for (size_t i = 0; i < count; i++) grid.majorant = fmax(grid.majorant, looseness * EXTINCTION * grid.density[i]);
    fclose(file);
}

static volgrad_camera look(vec from, vec to)
{
    vec forward = unit(at(to, -1, from)), right = unit(cross(forward, (vec){0, 1, 0}));
    return (volgrad_camera){.width = SIZE, .height = SIZE, .crop_x1 = SIZE, .crop_y1 = SIZE, .medium = VOLGRAD_NONE,
                            .position = narrow(from), .forward = narrow(forward), .right = narrow(right),
                            .up = narrow(cross(right, forward)), .tan_half_fov_x = (float)tan(18 * PI / 180)};
}

/* volgrad needs to know what f is made of: camera, media, materials, lights. */
static void describe(const volgrad_camera *camera)
{
    volgrad_medium smoke = {.kind = VOLGRAD_MEDIUM_GRID, .phase = {VOLGRAD_PHASE_HENYEY_GREENSTEIN, (float)G}, .albedo = ALBEDO,
                            .sigma_t = scaled(EXTINCTION, (volgrad_rgb){1, 1, 1}), .density = grid.density, .nx = grid.n[0],
                            .ny = grid.n[1], .nz = grid.n[2],
                            .local_to_world = {2, 0, 0, (float)LOW.x, 0, 4, 0, (float)LOW.y, 0, 0, 2, (float)LOW.z}};
    volgrad_material floor = {.kind = VOLGRAD_MATERIAL_DIFFUSE, .reflectance = REFLECTANCE};
    volgrad_light sky = {.kind = VOLGRAD_LIGHT_ENVIRONMENT, .emission = RADIANCE, .sampling_weight = 1};
    volgrad_scene_desc desc = {.struct_size = sizeof desc, .media_count = 1, .material_count = 1, .light_count = 1,
                               .camera = *camera, .media = &smoke, .materials = &floor, .lights = &sky};
    size_t bytes;
    check(volgrad_scene_size(&desc, &bytes));
    check(volgrad_scene_init(memory(bytes), bytes, &desc, &scene, NULL));
}

static double cpu_seconds(void) { return (double)clock() / CLOCKS_PER_SEC; }

/* ---- errors ---- */

enum { MOST_PASSES = 4096, BLOCK = 16, BLOCKS = SIZE / BLOCK * (SIZE / BLOCK) };

/* What was rendered in some time: the image, and the means of its blocks in each pass. */
typedef struct {
    double rgb[3 * SIZE * SIZE];
    int passes;
    double blocks[MOST_PASSES][BLOCKS];
} result;

static void add_pass(result *out, const float *rgb)
{
    double *blocks = out->blocks[out->passes++];
    for (int i = 0; i < 3 * SIZE * SIZE; i++) {
        out->rgb[i] += rgb[i];
        blocks[i / 3 / SIZE / BLOCK * (SIZE / BLOCK) + i / 3 % SIZE / BLOCK] += rgb[i] / (3 * BLOCK * BLOCK);
    }
}

/* Renders whole passes for `seconds`, shifted or not with the same paths. */
static void render(double seconds, const volgrad_camera *camera, int is_shifted, result *out)
{
    static float rgb[3 * SIZE * SIZE];
    size_t bytes;
    image target = {.is_shifted = is_shifted};
    check(volgrad_film_size(SIZE, SIZE, &bytes));
    void *film = memory(bytes);
    double start = cpu_seconds();
    for (state = 1; out->passes < MOST_PASSES && (out->passes < 2 || cpu_seconds() - start < seconds);) {
        check(volgrad_film_init(film, bytes, SIZE, SIZE, &target.film));
        render_pass(&target, camera);
        check(volgrad_film_develop(target.film, 1, rgb, 3 * SIZE * SIZE));
        add_pass(out, rgb);
    }
    double samples = (double)out->passes * SIZE * SIZE;
    for (int i = 0; i < 3 * SIZE * SIZE; i++) out->rgb[i] /= out->passes;
    printf("%-8s %4d samples per pixel, %6.2f us each, %.2f paths to shift", is_shifted ? "shifted" : "plain", out->passes,
           (cpu_seconds() - start) * 1e6 / samples, (double)target.handed_over / samples);
    free(film);
}

/* Mean squared difference, without the reference's own noise. */
static double mse(const double *rgb, const float *reference, const float *noise)
{
    double sum = 0;
    for (int i = 0; i < 3 * SIZE * SIZE; i++) {
        double difference = rgb[i] - reference[i];
        sum += difference * difference - noise[i] * noise[i];
    }
    return sum / (3 * SIZE * SIZE);
}

/* By how much shifts change the mean of each block, in standard errors: pass by pass, since both have the same paths. Mean square and largest:
   about 1, and seldom beyond 3.5. A hundred-thousandth of a block's light counts as a standard error too: in smoke as thin as that plain paths
   meet nothing for a long time, so that their noise is not known. */
static void compare(const result *plain, const result *shifted)
{
    int n = plain->passes < shifted->passes ? plain->passes : shifted->passes;
    double sum_of_squares = 0, largest = 0;
    for (int b = 0; b < BLOCKS; b++) {
        double light = 0, sum = 0, squares = 0;
        for (int i = 0; i < n; i++) {
            double difference = shifted->blocks[i][b] - plain->blocks[i][b];
            light += plain->blocks[i][b], sum += difference, squares += difference * difference;
        }
        double variance = fmax(0, squares - sum * sum / n) / (n - 1) * n + 1e-10 * light * light;
        double score = variance > 0 ? sum / sqrt(variance) : 0;
        sum_of_squares += score * score;
        largest = fmax(largest, fabs(score));
    }
    printf("shifts change the means of %d blocks by %.2f standard errors (rms), %.2f at most, in %d passes\n", BLOCKS,
           sqrt(sum_of_squares / BLOCKS), largest, n);
}

int main(int argc, char **argv)
{
    double seconds = argc > 1 ? atof(argv[1]) : 10;
    uint32_t side = argc > 2 ? (uint32_t)atoi(argv[2]) : 4;
    static float reference[3 * SIZE * SIZE], noise[3 * SIZE * SIZE];
    static result plain, shifted;
    load_smoke("scenes/smoke.vol", argc > 3 ? atof(argv[3]) : 1);
    shifted_edges = argc > 4 ? (uint32_t)atoi(argv[4]) : MAX_EDGES;
    check(volgrad_exr_read("scenes/reference/smoke.exr", reference, 3 * SIZE * SIZE));
    check(volgrad_exr_read("scenes/reference/smoke_stderr.exr", noise, 3 * SIZE * SIZE));
    volgrad_camera camera = look((vec){0, 1.7, 7.6}, (vec){0, 1.95, 0});
    describe(&camera);
    check(volgrad_shift_options_default(&shift, sizeof shift));
    shift.mode = VOLGRAD_SHIFT_EXCHANGEABLE, shift.count = side * side - 1, shift.run = 3;
    render(seconds, &camera, 0, &plain);
    double error = mse(plain.rgb, reference, noise);
    printf(", MSE %.3g\n", error);
    render(seconds, &camera, 1, &shifted);
    double shifted_error = mse(shifted.rgb, reference, noise);
    printf(", MSE %.3g\n%.2f times lower in equal time\n", shifted_error, error / shifted_error);
    compare(&plain, &shifted);
    return 0;
}
