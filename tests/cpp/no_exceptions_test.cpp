/* The same header where exceptions are off: statuses are returned. Linked into one program with files that throw. */

#include "fog.hpp"

void test_without_exceptions();

struct even_fog {
    void density(volgrad::span<const volgrad_vec3>, volgrad::span<float> values) const {
        for (float &value : values) value = 1;
    }
    void gradient(volgrad::span<const volgrad_vec3>, volgrad::span<volgrad_vec3> values) const {
        for (volgrad_vec3 &value : values) value = volgrad_vec3();
    }
};

void test_without_exceptions() {
    fog_desc fog;
    volgrad::scene scene;
    volgrad::film film;
    const volgrad_path_sampler_options options = volgrad::path_sampler_options_default();
    CHECK(volgrad::path_sampler_run(scene, slab(), options, 0, 0, 1, film) == VOLGRAD_ERROR_NULL);
    CHECK(scene.init(fog.desc) == VOLGRAD_OK);
    CHECK(film.init(0, 1) == VOLGRAD_ERROR_RANGE);
    CHECK(film.init(SIDE, SIDE) == VOLGRAD_OK);
    CHECK(volgrad::path_sampler_run(scene, slab(), options, 0, 0, PIXELS, film) == VOLGRAD_OK);
    auto stop = [](volgrad::span<const volgrad_ray>, volgrad::span<volgrad_hit>) { return 1; };
    CHECK(volgrad::path_sampler_run(scene, volgrad::make_host(stop, stop), options, 0, 0, 1, film) == VOLGRAD_ERROR_CALLBACK);
    std::vector<float> rgb(3 * PIXELS);
    CHECK(film.develop(1, rgb) == VOLGRAD_OK);
    double sum = 0;
    for (float pixel : rgb) sum += pixel;
    CHECK(sum > 0);
    const volgrad::custom_density<even_fog> custom(even_fog(), 0.1f, 1);
    CHECK(custom.get()->integrals == nullptr);
    volgrad_vec3 where = {0, 0, 0};
    float value = 0;
    custom.get()->density(custom.get()->user, &where, &value, 1);
    CHECK(value == 1);
    volgrad_error place = volgrad::sized<volgrad_error>();
    fog.medium.albedo.r = 2;
    CHECK(scene.init(fog.desc, &place) == VOLGRAD_ERROR_RANGE && std::strcmp(place.field, "media.albedo") == 0);
}
