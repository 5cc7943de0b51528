/* volgrad.hpp makes, bit by bit, what the same calls in C make; what a host throws comes out where it should; memory moves. */

#include "fog.hpp"

int checks_passed, checks_failed;
void test_without_exceptions(); /* no_exceptions_test.cpp */

typedef std::vector<float> image;

static image developed(const volgrad_film *film) {
    image rgb(3 * PIXELS);
    CHECK(volgrad_film_develop(film, 1, rgb.data(), rgb.size()) == VOLGRAD_OK);
    return rgb;
}

static bool same(const image &a, const image &b) { return std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0; }

/* An object of C's in memory of malloc's, which 16 bytes align. */
struct block {
    std::vector<volgrad_splat> storage; /* any type */
    void *get(std::size_t bytes) {
        storage.resize(bytes / sizeof(volgrad_splat) + 2);
        return reinterpret_cast<void *>((reinterpret_cast<std::size_t>(storage.data()) + 15) / 16 * 16);
    }
};

struct c_film {
    block memory;
    volgrad_film *film;
    c_film(std::uint32_t width, std::uint32_t height) : film(nullptr) {
        std::size_t bytes = 0;
        CHECK(volgrad_film_size(width, height, &bytes) == VOLGRAD_OK);
        CHECK(volgrad_film_init(memory.get(bytes), bytes, width, height, &film) == VOLGRAD_OK);
    }
};

/* ---- samplers ---- */

static void test_samplers() {
    const fog_desc fog;
    const volgrad_queries queries = slab_in_c();
    block memory;
    std::size_t bytes = 0;
    const volgrad_scene *in_c = nullptr;
    CHECK(volgrad_scene_size(&fog.desc, &bytes) == VOLGRAD_OK);
    CHECK(volgrad_scene_init(memory.get(bytes), bytes, &fog.desc, &in_c, nullptr) == VOLGRAD_OK);
    const volgrad::scene scene(fog.desc);
    slab host;

    volgrad_path_sampler_options paths = volgrad::path_sampler_options_default();
    paths.shift.mode = VOLGRAD_SHIFT_EXCHANGEABLE;
    c_film a(SIDE, SIDE), b(SIDE, SIDE);
    volgrad_path_sampler_stats stats = volgrad::sized<volgrad_path_sampler_stats>();
    CHECK(volgrad_path_sampler_run(in_c, &queries, &paths, 3, 0, PIXELS, a.film, nullptr) == VOLGRAD_OK);
    volgrad::film film(SIDE, SIDE), other(SIDE, SIDE);
    volgrad::path_sampler_run(scene, host, paths, 3, 0, PIXELS, film, &stats);
    CHECK(stats.paths == PIXELS);
    CHECK(same(developed(a.film), developed(film)));
    volgrad::path_sampler_run(scene, queries, paths, 3, 0, PIXELS / 2, other); /* a host in C; in two parts; moved; merged */
    volgrad::film rest(SIDE, SIDE), moved, shared;
    shared.init_shared(SIDE, SIDE);
    volgrad::path_sampler_run(scene, slab(), paths, 3, PIXELS / 2, PIXELS / 2, rest);
    moved = std::move(rest);
    other.merge(moved);
    image pixels(3 * PIXELS);
    other.develop(1, pixels);
    CHECK(same(developed(a.film), pixels));
    for (std::uint32_t first = 0; first < PIXELS; first += PIXELS / 2) {
        volgrad::path_sampler_run(scene, host, paths, 3, first, PIXELS / 2, shared);
    }
    CHECK(same(developed(a.film), developed(shared)));

    volgrad_bidirectional_options both = volgrad::bidirectional_options_default();
    both.max_length = 5;
    CHECK(volgrad_bidirectional_run(in_c, &queries, &both, 0, 0, PIXELS, b.film, nullptr) == VOLGRAD_OK);
    volgrad::film twice(SIDE, SIDE);
    volgrad::bidirectional_run(scene, host, both, 0, 0, PIXELS, twice);
    CHECK(same(developed(b.film), developed(twice)));
    CHECK(volgrad_bidirectional_run_technique(in_c, &queries, &both, 1, 2, 1, 1, 0, PIXELS, b.film, nullptr) == VOLGRAD_OK);
    volgrad::bidirectional_run_technique(scene, host, both, 1, 2, true, 1, 0, PIXELS, twice);
    CHECK(same(developed(b.film), developed(twice)));
}

static void test_guides_and_chains() {
    const fog_desc fog;
    const volgrad_queries queries = slab_in_c();
    const volgrad::scene scene(fog.desc);
    volgrad_bidirectional_options both = volgrad::bidirectional_options_default();
    std::uint32_t width = 0, height = 0;
    volgrad::guide_film_size(scene, width, height);
    c_film in_c(width, height);
    volgrad::film lesson(width, height);
    CHECK(volgrad_guide_learn(scene, &queries, &both, 0, 0, PIXELS, in_c.film, nullptr) == VOLGRAD_OK);
    volgrad::guide_learn(scene, slab(), both, 0, 0, PIXELS, lesson);
    image a(3 * width * height), b(a);
    CHECK(volgrad_film_develop(in_c.film, 1, a.data(), a.size()) == VOLGRAD_OK);
    lesson.develop(1, b);
    CHECK(same(a, b));
    volgrad::scene guided;
    guided.init_guide(scene, lesson);

    volgrad_chain_options options = volgrad::chain_options_default();
    options.max_length = 4;
    volgrad_chain_techniques techniques;
    std::vector<float> weights(2000), expected(2000);
    volgrad::chain_bootstrap(guided, slab(), options, nullptr, 0, weights);
    CHECK(volgrad_chain_bootstrap(guided, &queries, &options, nullptr, 0, 2000, expected.data(), nullptr) == VOLGRAD_OK);
    CHECK(same(weights, expected));
    volgrad::chain_learn(options, weights, techniques);
    volgrad::chain_bootstrap(guided, slab(), options, &techniques, 0, weights);
    std::vector<volgrad_chain_start> starts(8 + VOLGRAD_MAX_LENGTH);
    volgrad_chain_plan_result plan;
    volgrad::chain_plan(options, &techniques, weights, 8, starts, plan);
    CHECK(plan.chain_count > 0);

    block memory;
    std::size_t bytes = 0;
    volgrad_chain *chain = nullptr;
    c_film by_c(SIDE, SIDE);
    CHECK(volgrad_chain_size(&options, &bytes) == VOLGRAD_OK);
    CHECK(volgrad_chain_init(memory.get(bytes), bytes, guided, &queries, &options, &techniques, &starts[0], nullptr, &chain) == VOLGRAD_OK);
    CHECK(volgrad_chain_run(chain, guided, &queries, 500, by_c.film, nullptr) == VOLGRAD_OK);
    CHECK(volgrad_chain_flush(chain, guided, &queries, by_c.film, nullptr) == VOLGRAD_OK);
    volgrad::chain first, second;
    volgrad::film film(SIDE, SIDE);
    first.init(guided, slab(), options, &techniques, starts[0]);
    first.run(guided, slab(), 200, film);
    second = std::move(first);
    volgrad_chain_mutation next, next_in_c = volgrad::sized<volgrad_chain_mutation>();
    std::vector<volgrad_vertex> current(5), proposed(6), vertices(10);
    second.peek(guided, slab(), next, current, proposed);
    CHECK(volgrad_chain_peek(second, guided, &queries, &next_in_c, &vertices[0], &vertices[5], 5) == VOLGRAD_OK);
    CHECK(std::memcmp(&next, &next_in_c, sizeof next) == 0 && next.current.vertex_count >= 3);
    CHECK(std::memcmp(current.data(), &vertices[0], next.current.vertex_count * sizeof vertices[0]) == 0);
    second.run(guided, slab(), 300, film);
    second.flush(guided, slab(), film);
    CHECK(same(developed(by_c.film), developed(film)));
}

/* ---- kernels and paths ---- */

static void test_kernels() {
    const fog_desc fog;
    const volgrad::scene scene(fog.desc);
    const volgrad_vec3 origin = {0, 0, 0}, forward = {0, 0, 1}, up = {0, 1, 0};
    const volgrad_segment segments[] = {{1, VOLGRAD_NONE, {0, 0, 1}}, {3, 0, {0, 0, 1}}};
    const volgrad_line line = volgrad::line(origin, forward, 3, segments);
    volgrad_rgb tau;
    volgrad_optical_depth depth;
    volgrad_flight flight;
    volgrad_transmittance_estimate estimate;
    volgrad::line_tau(scene, line, tau);
    volgrad::line_optical_depth(scene, line, depth);
    CHECK(tau.r == 2 && depth.tau.g == 2 && depth.end_gradient[0].z == 1);
    double u = 0;
    volgrad::line_invert_distance(scene, line, u);
    CHECK(std::fabs(u - (1 - std::exp(-2.0))) < 1e-12);
    volgrad::line_sample_distance(scene, line, u / 2, flight);
    CHECK(flight.medium == 0 && flight.t > 1 && flight.t < 3);
    volgrad::line_transmittance_estimate(scene, line, volgrad::transmittance_options_default(), 0, 0, estimate);
    CHECK(std::fabs(estimate.transmittance.b - std::exp(-2.0f)) < 1e-6f);
    const volgrad_phase &phase = fog.medium.phase;
    volgrad_phase_value value;
    volgrad_vec3 next;
    double v = 0;
    volgrad::phase_eval(phase, up, forward, value);
    volgrad::phase_sample(phase, up, 0.25, 0.5, next);
    volgrad::phase_invert(phase, up, next, u, v);
    CHECK(value.value > 0 && std::fabs(u - 0.25) < 1e-5 && std::fabs(v - 0.5) < 1e-5);
}

static void test_paths() {
    const fog_desc fog;
    const volgrad::scene scene(fog.desc);
    const std::vector<volgrad_vertex> vertices = {{VOLGRAD_VERTEX_CAMERA, 0, 0, {0, 0, 0}, {}, {}, 0},
        {VOLGRAD_VERTEX_MEDIUM, 0, 0, {0, 0.1f, 1.5f}, {}, {}, 0}, {VOLGRAD_VERTEX_LIGHT, 1, 0, {0, 2, 0}, {}, {}, 0}};
    const volgrad_vec3 z = {0, 0, 1};
    const std::uint32_t air = VOLGRAD_NONE, edge_ends[] = {2, 4};
    const float enter = std::sqrt(1.5f * 1.5f + 0.01f) / 1.5f, leave = std::sqrt(1.9f * 1.9f + 2.25f) / 3;
    const volgrad_segment segments[] = {{enter, air, z}, {INFINITY, 0, z}, {leave, 0, z}, {INFINITY, air, z}};
    const volgrad_path path = volgrad::path(vertices, segments, edge_ends);
    CHECK(path.vertex_count == 3 && path.segment_count == 4);
    double f[3], product[3] = {1, 1, 1};
    volgrad_path_factor factors[3];
    volgrad_gradient gradient, run;
    volgrad::path_validate(scene, path);
    volgrad::validate(volgrad::shift_options_default());
    volgrad::validate(volgrad::path_sampler_options_default());
    volgrad::validate(volgrad::bidirectional_options_default());
    volgrad::validate(volgrad::chain_options_default());
    const volgrad_ray ray = {{0, 0, 0}, z, 0, 1, 0};
    volgrad_hit hit = {};
    hit.segment_count = 1, hit.segments[0] = {1, 0, {}};
    volgrad::hit_validate(scene, ray, hit);
    volgrad::path_contribution(scene, path, f);
    volgrad::path_factors(scene, path, factors);
    for (const volgrad_path_factor &p : factors) product[0] *= static_cast<double>(p.vertex.r * p.transmittance.r) * p.geometry;
    CHECK(f[0] > 0 && std::fabs(product[0] / f[0] - 1) < 1e-6);
    volgrad::path_log_gradient(scene, path, 1, gradient);
    volgrad::path_run_log_gradient(scene, path, 1, 1, run);
    CHECK(gradient.luminance.y == run.luminance.y && run.luminance.y != 0);

    volgrad_shift_options options = volgrad::shift_options_default();
    options.mode = VOLGRAD_SHIFT_EXACT;
    volgrad_splat in_c[VOLGRAD_MAX_SHIFTS + 1], splats[VOLGRAD_MAX_SHIFTS + 1];
    std::uint32_t expected = 0, count = 0;
    const volgrad_queries queries = slab_in_c();
    const volgrad_rgb weight = {1, 2, 3};
    CHECK(volgrad_shift_path(scene, &queries, &options, &path, weight, 1, 2, in_c, VOLGRAD_MAX_SHIFTS + 1, &expected) == VOLGRAD_OK);
    volgrad::shift_path(scene, slab(), options, path, weight, 1, 2, splats, count);
    CHECK(count == expected && count == 9 && std::memcmp(in_c, splats, count * sizeof *splats) == 0);

    const volgrad_path paths[] = {path, path};
    const volgrad_rgb weights[] = {weight, weight};
    std::vector<volgrad_splat> many(2 * 9), many_in_c(2 * 9);
    CHECK(volgrad_shift_paths(scene, &queries, &options, paths, weights, 2, 1, 2, many_in_c.data(), 18, &expected) == VOLGRAD_OK);
    volgrad::shift_paths(scene, slab(), options, paths, weights, 1, 2, many, count);
    CHECK(count == expected && count > 0 && std::memcmp(many_in_c.data(), many.data(), count * sizeof *splats) == 0);

    // Without a host, where none is asked.
    volgrad_shift_options cheap = options;
    cheap.mode = VOLGRAD_SHIFT_FIRST_ORDER, cheap.kernel = VOLGRAD_KERNEL_DISK;
    CHECK(volgrad_shift_path(scene, nullptr, &cheap, &path, weight, 1, 2, in_c, VOLGRAD_MAX_SHIFTS + 1, &expected) == VOLGRAD_OK);
    volgrad::shift_path(scene, cheap, path, weight, 1, 2, splats, count);
    CHECK(count == expected && count == 9 && std::memcmp(in_c, splats, count * sizeof *splats) == 0);
    CHECK(volgrad_shift_paths(scene, nullptr, &cheap, paths, weights, 2, 1, 2, many_in_c.data(), 18, &expected) == VOLGRAD_OK);
    volgrad::shift_paths(scene, cheap, paths, weights, 1, 2, many, count);
    CHECK(count == expected && count > 0 && std::memcmp(many_in_c.data(), many.data(), count * sizeof *splats) == 0);
    volgrad_status asks = VOLGRAD_OK;
    try {
        volgrad::shift_path(scene, options, path, weight, 1, 2, splats, count);
    } catch (const volgrad::error &e) {
        asks = e.status();
    }
    CHECK(asks == VOLGRAD_ERROR_NULL);

    std::uint32_t tile_in_c[4], tile[4];
    CHECK(volgrad_shift_tile(scene, &options, 1, 3, 4, tile_in_c) == VOLGRAD_OK);
    volgrad::shift_tile(scene, options, 1, 3, 4, tile);
    CHECK(std::memcmp(tile, tile_in_c, sizeof tile) == 0 && tile[0] <= 3 && tile[2] > 3);
    std::string report;
    std::size_t length = 0;
    std::vector<char> report_in_c(1 << 14);
    CHECK(volgrad_path_report(scene, &path, report_in_c.data(), report_in_c.size(), &length) == VOLGRAD_OK);
    volgrad::path_report(scene, path, report);
    CHECK(report.size() == length && report == report_in_c.data() && length > 100);
    volgrad_status few = VOLGRAD_OK;
    try {
        volgrad::shift_paths(scene, slab(), options, paths, volgrad::span<const volgrad_rgb>(weights, 1), 1, 2, many, count);
    } catch (const volgrad::error &e) {
        few = e.status();
    }
    CHECK(few == VOLGRAD_ERROR_TOO_SMALL);

    volgrad_derivative derivative;
    volgrad_status status = VOLGRAD_OK;
    try {
        volgrad::path_run_log_derivative(scene, path, 1, 1, derivative);
    } catch (const volgrad::error &e) {
        status = e.status();
    }
    CHECK(status == VOLGRAD_ERROR_NOT_MOVABLE); /* nothing specular here */
}

/* ---- errors and exceptions ---- */

struct out_of_geometry {
    int ray;
};

/* Each question goes to its own function. */
static void test_hosts() {
    const fog_desc fog;
    const volgrad::scene scene(fog.desc);
    std::uint64_t rays = 0, occlusion_rays = 0;
    auto counted = [](std::uint64_t &count) {
        return [&count](volgrad::span<const volgrad_ray> asked, volgrad::span<volgrad_hit> hits) {
            count += asked.size();
            slab().intersect(asked, hits);
        };
    };
    volgrad_path_sampler_stats stats = volgrad::sized<volgrad_path_sampler_stats>();
    volgrad::film film(SIDE, SIDE);
    const auto host = volgrad::make_host(counted(rays), counted(occlusion_rays));
    volgrad::path_sampler_run(scene, host, volgrad::path_sampler_options_default(), 0, 0, PIXELS, film, &stats);
    CHECK(rays == stats.rays && occlusion_rays == stats.occlusion_rays && rays > 0 && occlusion_rays > 0 && rays != occlusion_rays);
}

static void test_exceptions() {
    const fog_desc fog;
    const volgrad::scene scene(fog.desc);
    const volgrad_path_sampler_options options = volgrad::path_sampler_options_default();
    int left = 40;
    auto answer = [&left](volgrad::span<const volgrad_ray> rays, volgrad::span<volgrad_hit> hits) {
        if (left-- == 0) throw out_of_geometry{17};
        slab().intersect(rays, hits);
    };
    auto host = volgrad::make_host(answer, answer);
    volgrad::film film(SIDE, SIDE), whole(SIDE, SIDE);
    volgrad_path_sampler_stats stats = volgrad::sized<volgrad_path_sampler_stats>();
    int caught = 0;
    try {
        volgrad::path_sampler_run(scene, host, options, 0, 0, PIXELS, film, &stats);
    } catch (const out_of_geometry &e) {
        caught = e.ray;
    }
    CHECK(caught == 17 && stats.paths > 0 && stats.paths < 40);
    left = -1; /* the next call goes on */
    const std::uint32_t done = static_cast<std::uint32_t>(stats.paths);
    volgrad::path_sampler_run(scene, host, options, 0, done, PIXELS - done, film);
    volgrad::path_sampler_run(scene, slab(), options, 0, 0, PIXELS, whole);
    CHECK(same(developed(film), developed(whole)));

    auto stop = [](volgrad::span<const volgrad_ray>, volgrad::span<volgrad_hit>) { return 7; };
    volgrad_status status = VOLGRAD_OK;
    try {
        volgrad::path_sampler_run(scene, volgrad::make_host(stop, stop), options, 0, 0, 1, film);
    } catch (const volgrad::error &e) {
        status = e.status();
    }
    CHECK(status == VOLGRAD_ERROR_CALLBACK);
}

static void test_errors() {
    fog_desc fog;
    fog.lights[1].emission.g = -1;
    volgrad_error place = volgrad::sized<volgrad_error>();
    int caught = 0;
    volgrad::scene scene;
    try {
        scene.init(fog.desc, &place);
    } catch (const volgrad::error &e) {
        caught++;
        CHECK(e.status() == VOLGRAD_ERROR_RANGE && std::strcmp(e.field(), "lights.emission") == 0 && e.index() == 1);
        CHECK(std::strstr(e.what(), "lights.emission") != nullptr && std::strcmp(place.field, "lights.emission") == 0);
    }
    fog.desc.struct_size = 5; /* even its size is unknown */
    try {
        volgrad::scene failed(fog.desc);
    } catch (const std::runtime_error &) {
        caught++;
    }
    volgrad::film film(SIDE, SIDE), taken(std::move(film));
    volgrad_splat splat = {1, 1, {1, 1, 1}};
    taken.add(volgrad::span<const volgrad_splat>(&splat, 1));
    std::uint64_t dropped = 9;
    taken.dropped(dropped);
    CHECK(dropped == 0);
    try {
        film.dropped(dropped); /* nothing is there any more */
    } catch (const volgrad::error &e) {
        caught += e.status() == VOLGRAD_ERROR_NULL;
    }
    CHECK(caught == 3);
    CHECK(volgrad::abi_matches() && std::strlen(volgrad::version()) >= 5);
}

/* ---- what a host computes itself ---- */

static bool throws;
static void may_throw() {
    if (throws) throw out_of_geometry{1};
}

/* The density x. */
struct ramp {
    void density(volgrad::span<const volgrad_vec3> points, volgrad::span<float> values) const {
        may_throw();
        for (std::size_t i = 0; i < points.size(); i++) values[i] = points[i].x;
    }
    void gradient(volgrad::span<const volgrad_vec3>, volgrad::span<volgrad_vec3> values) const {
        may_throw();
        for (volgrad_vec3 &value : values) value.x = 1, value.y = value.z = 0;
    }
};
struct exact_ramp : ramp {
    void integrals(const volgrad_stretch &s, bool gradients, volgrad_density_integrals &result) const {
        may_throw();
        const double length = s.end - s.start, middle = (s.start + s.end) / 2;
        result.density = length * (s.origin[0] + middle * s.direction[0]);
        if (gradients) result.gradient[0] = length, result.moment[0] = length * middle;
    }
};

/* A density that throws is 0 there, and counted. */
template <class Density> static void test_custom_density(std::uint64_t least_dropped) {
    volgrad::custom_density<Density> custom(Density(), 0.1f, 1);
    fog_desc fog;
    fog.medium.kind = VOLGRAD_MEDIUM_CUSTOM;
    fog.medium.custom = custom.get();
    fog.medium.local_to_world[0] = fog.medium.local_to_world[5] = fog.medium.local_to_world[10] = 1;
    volgrad::scene scene(fog.desc);
    const volgrad_segment segment = {INFINITY, 0, {}};
    const volgrad_vec3 origin = {0, 0.5f, 0.5f}, along = {1, 0, 0};
    const volgrad_line line = volgrad::line(origin, along, 0.5f, volgrad::span<const volgrad_segment>(&segment, 1));
    volgrad_optical_depth depth;
    std::uint64_t dropped = 0;
    volgrad::line_optical_depth(scene, line, depth);
    CHECK(std::fabs(depth.tau.r - 0.125f) < 1e-6f && std::fabs(depth.end_gradient[0].x - 0.5f) < 1e-6f);
    throws = true;
    volgrad::line_optical_depth(scene, line, depth);
    scene.dropped_densities(dropped);
    throws = false;
    CHECK(depth.tau.r == 0 && dropped >= least_dropped);
}

static const float PI = 3.14159265f;
static volgrad_vec3 around(double z, double u) {
    const double r = std::sqrt(1 - z * z), angle = 2 * static_cast<double>(PI) * u;
    return {static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle)), static_cast<float>(z)};
}

/* Of two halves, as the wall's hits tell them apart. */
static volgrad_rgb reflectance(const volgrad_surface_point &at, float scale) {
    const float value = scale * (at.user == 1 ? 0.8f : 0.3f);
    CHECK((at.user == 1) == (at.position.x < 0));
    return {value, value, value};
}

struct paint {
    volgrad_rgb eval(const volgrad_surface_point &at, volgrad_vec3, volgrad_vec3) const { return may_throw(), reflectance(at, 1 / PI); }
    float pdf(const volgrad_surface_point &, volgrad_vec3, volgrad_vec3 to_light) const { return may_throw(), to_light.z / PI; }
    bool sample(const volgrad_surface_point &, volgrad_vec3, const double *u, volgrad_vec3 &to_light, float &) const {
        may_throw();
        to_light = around(std::sqrt(1 - u[0]), u[1]);
        return true;
    }
    void log_gradient(const volgrad_surface_point &, volgrad_vec3, volgrad_vec3, volgrad_vec3 *by_camera, volgrad_vec3 *) const {
        may_throw();
        for (int i = 0; i < 3; i++) by_camera[i].x = 1;
    }
};
struct tiles {
    volgrad_rgb reflectance(const volgrad_surface_point &at) const { return may_throw(), ::reflectance(at, 1); }
};
struct droplets { /* scatter alike in all directions */
    double eval(double) const { return may_throw(), 1 / (4 * static_cast<double>(PI)); }
    double sample(double u) const { return may_throw(), 2 * u - 1; }
    double log_derivative(double) const { return may_throw(), 0.; }
};
struct sky {
    volgrad_rgb emission(volgrad_vec3) const { return may_throw(), volgrad_rgb{1, 1, 1}; }
    float pdf(volgrad_vec3) const { return may_throw(), 1 / (4 * PI); }
    bool sample(const double *u, volgrad_vec3 &to_sky) const { return may_throw(), to_sky = around(2 * u[0] - 1, u[1]), true; }
};
struct lamp {
    volgrad_rgb emission(volgrad_vec3) const { return may_throw(), volgrad_rgb{9, 9, 9}; }
    void log_gradient(volgrad_vec3, volgrad_vec3 *gradient) const {
        may_throw();
        gradient[0].x = gradient[1].x = gradient[2].x = 1;
    }
};

static const volgrad_vec3 UP = {0, 0, 1};
static const volgrad_surface_point LEFT = {1, {-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* The same objects, as C would call them. */
struct tables_in_c {
    volgrad_custom_bsdf bsdf;
    volgrad_custom_phase phase;
    volgrad_custom_light light;
    tables_in_c()
        : bsdf(volgrad::sized<volgrad_custom_bsdf>()), phase(volgrad::sized<volgrad_custom_phase>()),
          light(volgrad::sized<volgrad_custom_light>()) {
        using point = const volgrad_surface_point *;
        bsdf.eval = [](void *, point at, volgrad_vec3 a, volgrad_vec3 b, volgrad_rgb *value) { *value = paint().eval(*at, a, b); };
        bsdf.pdf = [](void *, point at, volgrad_vec3 a, volgrad_vec3 b) { return paint().pdf(*at, a, b); };
        bsdf.sample = [](void *, point at, volgrad_vec3 a, const double *u, volgrad_vec3 *b, float *eta_squared) -> std::int32_t {
            return paint().sample(*at, a, u, *b, *eta_squared);
        };
        phase.eval = [](void *, double mu) { return droplets().eval(mu); };
        phase.sample = [](void *, double u) { return droplets().sample(u); };
        light.emission = [](void *, volgrad_vec3 direction, volgrad_rgb *value) { *value = sky().emission(direction); };
        light.pdf = [](void *, volgrad_vec3 to_sky) { return sky().pdf(to_sky); };
        light.sample = [](void *, const double *u, volgrad_vec3 *to_sky) -> std::int32_t { return sky().sample(u, *to_sky); };
    }
};

/* Paint on the plane z = 3 behind the fog. */
struct wall {
    void intersect(volgrad::span<const volgrad_ray> rays, volgrad::span<volgrad_hit> hits) const {
        slab().intersect(rays, hits);
        for (std::size_t i = 0; i < rays.size(); i++) {
            const float t = (3 - rays[i].origin.z) / rays[i].direction.z;
            if (!(t > rays[i].t_min && t < rays[i].t_max)) continue;
            hits[i].kind = VOLGRAD_HIT_SURFACE, hits[i].t = t, hits[i].light = VOLGRAD_NONE;
            hits[i].user = rays[i].origin.x + t * rays[i].direction.x < 0 ? 1 : 2;
            hits[i].normal.z = hits[i].shading_normal.z = -1;
            hits[i].medium_inside = hits[i].medium_outside = VOLGRAD_KEEP_MEDIUM;
        }
    }
    void occluded(volgrad::span<const volgrad_ray> rays, volgrad::span<volgrad_hit> hits) const { intersect(rays, hits); }
};

static image painted(const volgrad_custom_bsdf *bsdf, const volgrad_custom_phase *phase, const volgrad_custom_light *light,
                     std::uint64_t &dropped) {
    fog_desc fog;
    volgrad_material material = volgrad_material();
    material.kind = VOLGRAD_MATERIAL_CUSTOM, material.custom = bsdf;
    fog.medium.phase.kind = VOLGRAD_PHASE_CUSTOM;
    fog.lights[0].kind = VOLGRAD_LIGHT_CUSTOM_SKY, fog.lights[0].custom = light;
    fog.desc.materials = &material, fog.desc.material_count = 1;
    fog.desc.phases = &phase, fog.desc.phase_count = 1;
    const volgrad::scene scene(fog.desc);
    volgrad::film film(SIDE, SIDE);
    volgrad::path_sampler_run(scene, wall(), volgrad::path_sampler_options_default(), 0, 0, PIXELS, film);
    scene.dropped_values(dropped);
    return developed(film);
}

static double sum(const image &values) {
    double sum = 0;
    for (float value : values) sum += static_cast<double>(value);
    return sum;
}

static void test_custom() {
    const volgrad::custom_bsdf<paint> bsdf{paint()};
    const volgrad::custom_phase<droplets> phase{droplets()};
    const volgrad::custom_light<sky> light{sky()};
    const volgrad::custom_light<lamp> point{lamp()};
    const tables_in_c c;
    CHECK(light.get()->log_gradient == nullptr && point.get()->pdf == nullptr && point.get()->sample == nullptr);
    std::uint64_t dropped = 9, dropped_in_c = 9;
    const image in_c = painted(&c.bsdf, &c.phase, &c.light, dropped_in_c);
    CHECK(same(in_c, painted(bsdf.get(), phase.get(), light.get(), dropped)));
    CHECK(dropped == 0 && dropped_in_c == 0);
    const volgrad::custom_texture<tiles> texture{tiles()};
    const image textured = painted(texture.get(), phase.get(), light.get(), dropped);
    CHECK(dropped == 0 && texture.get()->pdf == nullptr && std::fabs(sum(textured) / sum(in_c) - 1) < 0.1);
    throws = true;
    CHECK(sum(painted(texture.get(), phase.get(), light.get(), dropped)) == 0 && dropped > 0);
    const image black = painted(bsdf.get(), phase.get(), light.get(), dropped);
    CHECK(sum(black) == 0 && dropped > 0);

    /* Every function, with what throws and with what does not. */
    const double u[3] = {0.3, 0.4, 0.5};
    for (int i = 0; i < 2; i++) {
        throws = i == 0;
        volgrad_vec3 direction = {}, sampled = {}, gradient[3] = {}, by_camera[3] = {}, by_light[3] = {};
        volgrad_rgb value = {}, radiance = {};
        float eta_squared = 1;
        CHECK(bsdf.get()->sample(bsdf.get()->user, &LEFT, UP, u, &sampled, &eta_squared) == 1);
        CHECK(light.get()->sample(light.get()->user, u, &direction) == 1);
        bsdf.get()->eval(bsdf.get()->user, &LEFT, UP, UP, &value);
        bsdf.get()->log_gradient(bsdf.get()->user, &LEFT, UP, UP, by_camera, by_light);
        point.get()->emission(point.get()->user, UP, &radiance);
        point.get()->log_gradient(point.get()->user, UP, gradient);
        const double numbers[] = {static_cast<double>(bsdf.get()->pdf(bsdf.get()->user, &LEFT, UP, UP)), phase.get()->eval(phase.get()->user, 0),
            phase.get()->sample(phase.get()->user, 0.5), phase.get()->log_derivative(phase.get()->user, 0),
            static_cast<double>(light.get()->pdf(light.get()->user, UP)), static_cast<double>(value.g), static_cast<double>(sampled.z),
            static_cast<double>(by_camera[0].x), static_cast<double>(gradient[0].x), static_cast<double>(radiance.b),
            static_cast<double>(direction.z)};
        for (double number : numbers) CHECK(std::isnan(number) == throws);
    }
}

static void test_images() {
    const char *file = "volgrad_test.exr";
    const volgrad_exr_layout layout = {2, 1, 0, 0, 2, 1};
    const float rgb[] = {1, 2, 3, 4, 5, 6};
    float back[6];
    volgrad_exr_layout found;
    const volgrad_exr_attribute attributes[] = {{"host", "test", 0}};
    volgrad::exr_write(file, layout, rgb, attributes);
    volgrad::exr_read_layout(file, found);
    volgrad::exr_read(file, back);
    CHECK(found.width == 2 && found.window_height == 1 && std::memcmp(rgb, back, sizeof rgb) == 0);
    std::remove(file);
}

int main() {
    test_samplers();
    test_guides_and_chains();
    test_kernels();
    test_paths();
    test_hosts();
    test_exceptions();
    test_errors();
    test_custom_density<ramp>(2);
    test_custom_density<exact_ramp>(1);
    test_custom();
    test_images();
    test_without_exceptions();
    std::printf("%d passed, %d failed\n", checks_passed, checks_failed);
    return checks_failed != 0;
}
