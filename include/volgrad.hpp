/* volgrad for C++11 and later: volgrad.h with memory that frees itself, arrays that know their length, callbacks that may throw, and
 * errors as exceptions. Header-only; links with the same library. What it does not say, volgrad.h says: volgrad::line_tau is
 * volgrad_line_tau, and structs keep their C names.
 *
 * Errors: every fallible function returns volgrad::result. That is void, and errors are thrown as volgrad::error; or, without exceptions
 * (-fno-exceptions, or VOLGRAD_NO_EXCEPTIONS defined), volgrad_status. Both may be mixed in one program.
 *
 * Hosts: wherever C takes volgrad_queries, this takes any object with
 *     intersect(volgrad::span<const volgrad_ray>, volgrad::span<volgrad_hit>)     and the same named occluded,
 * which return nothing, or 0 to go on and another value to stop. What they throw stops the call, goes no further than volgrad's frames, and
 * is thrown again from the function that was called. make_host makes such an object of two lambdas; a volgrad_queries is one, too.
 * volgrad calls the host from the calling thread; one host may serve many threads if its functions may be called so. */

#ifndef VOLGRAD_HPP
#define VOLGRAD_HPP

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "volgrad.h"

#if !defined(VOLGRAD_NO_EXCEPTIONS) && !defined(__cpp_exceptions) && !defined(__EXCEPTIONS) && !defined(_CPPUNWIND)
#define VOLGRAD_NO_EXCEPTIONS
#endif

namespace volgrad {

/* ---- errors ---- */

/* A status in words. */
inline const char *status_message(volgrad_status status) { return volgrad_status_message(static_cast<std::int32_t>(status)); }

/* Whether header and library belong together. */
inline bool abi_matches() { return volgrad_abi_version() == VOLGRAD_ABI_VERSION; }

inline const char *version() { return volgrad_version(); }

/* A zeroed struct of those that begin with their size. */
template <class T> T sized() {
    T value = T();
    value.struct_size = static_cast<std::uint32_t>(sizeof value);
    return value;
}

/* Two namespaces, so that files with and without exceptions share no function. */
#ifndef VOLGRAD_NO_EXCEPTIONS
inline namespace throwing {

/* What a call of the library returned, and which field of its arguments is to blame, if it says so. */
class error : public std::runtime_error {
  public:
    explicit error(volgrad_status status, const volgrad_error &place = volgrad_error())
        : std::runtime_error(words(status, place)), status_(status), place_(place) {}
    volgrad_status status() const noexcept { return status_; }
    /* NULL if no field is to blame. */
    const char *field() const noexcept { return place_.field; }
    std::uint32_t index() const noexcept { return place_.index; }

  private:
    static std::string words(volgrad_status status, const volgrad_error &place) {
        std::string text = std::string("volgrad: ") + status_message(status);
        return place.field ? text + ": " + place.field + " of number " + std::to_string(place.index) : text;
    }
    volgrad_status status_;
    volgrad_error place_;
};

typedef void result;

namespace detail {
inline void finish(volgrad_status status) {
    if (status != VOLGRAD_OK) throw error(status);
}
inline void finish(volgrad_status status, const volgrad_error &place) {
    if (status != VOLGRAD_OK) throw error(status, place);
}
} // namespace detail
#else
inline namespace returning {

typedef volgrad_status result;

namespace detail {
inline volgrad_status finish(volgrad_status status) { return status; }
inline volgrad_status finish(volgrad_status status, const volgrad_error &) { return status; }
} // namespace detail
#endif

/* ---- arrays ---- */

/* A pointer and a number of values, which belong to somebody else. */
template <class T> class span {
  public:
    span() noexcept : data_(nullptr), size_(0) {}
    span(T *data, std::size_t size) noexcept : data_(data), size_(size) {}
    template <std::size_t N> span(T (&array)[N]) noexcept : data_(array), size_(N) {}
    /* Of std::vector, std::array, another span: whatever has data() and size(). */
    template <class C, class = typename std::enable_if<std::is_convertible<
                           typename std::remove_pointer<decltype(std::declval<C &>().data())>::type (*)[], T (*)[]>::value>::type>
    span(C &&container) noexcept : data_(container.data()), size_(container.size()) {}
    T *data() const noexcept { return data_; }
    std::size_t size() const noexcept { return size_; }
    bool empty() const noexcept { return size_ == 0; }
    T *begin() const noexcept { return data_; }
    T *end() const noexcept { return data_ + size_; }
    T &operator[](std::size_t i) const noexcept { return data_[i]; }

  private:
    T *data_;
    std::size_t size_;
};

namespace detail {

/* Counts that C takes in 32 bits: more is an error there, not another count. */
inline std::uint32_t count32(std::size_t count) {
    const std::size_t most = (std::numeric_limits<std::uint32_t>::max)();
    return static_cast<std::uint32_t>(count < most ? count : most);
}

/* Memory for an object, aligned to 16 bytes in every C++. Moving it does not move what is in it. */
class memory {
  public:
    memory() noexcept : place_(nullptr), bytes_(0) {}
    memory(memory &&other) noexcept : block_(std::move(other.block_)), place_(other.place_), bytes_(other.bytes_) { other.forget(); }
    memory &operator=(memory &&other) noexcept {
        block_ = std::move(other.block_), place_ = other.place_, bytes_ = other.bytes_;
        other.forget();
        return *this;
    }
    void take(std::size_t bytes) {
        enum { ALIGNMENT = 16 };
        block_.reset(), forget();
        if (bytes > SIZE_MAX - ALIGNMENT) return; /* NULL: VOLGRAD_ERROR_NULL */
#ifndef VOLGRAD_NO_EXCEPTIONS
        block_.reset(new unsigned char[bytes + ALIGNMENT]);
#else
        block_.reset(new (std::nothrow) unsigned char[bytes + ALIGNMENT]);
#endif
        const std::size_t over = reinterpret_cast<std::uintptr_t>(block_.get()) % ALIGNMENT;
        place_ = block_ ? block_.get() + (ALIGNMENT - over) % ALIGNMENT : nullptr;
        bytes_ = bytes;
    }
    void *get() const noexcept { return place_; }
    std::size_t size() const noexcept { return bytes_; }

  private:
    void forget() noexcept { place_ = nullptr, bytes_ = 0; }
    std::unique_ptr<unsigned char[]> block_;
    unsigned char *place_;
    std::size_t bytes_;
};

/* An object of the library in memory of its own: movable, not copyable, NULL until made. */
template <class T> class object {
  public:
    object() noexcept : made_(nullptr) {}
    object(object &&other) noexcept : memory_(std::move(other.memory_)), made_(other.made_) { other.made_ = nullptr; }
    object &operator=(object &&other) noexcept {
        memory_ = std::move(other.memory_), made_ = other.made_, other.made_ = nullptr;
        return *this;
    }
    /* `init` makes it in so many bytes, if the size function that told them did not fail. */
    template <class Init> volgrad_status make(volgrad_status size_status, std::size_t bytes, Init init) {
        made_ = nullptr;
        if (size_status != VOLGRAD_OK) return size_status;
        memory_.take(bytes);
        return init(memory_.get(), bytes, &made_);
    }
    T *get() const noexcept { return made_; }

  private:
    memory memory_;
    T *made_;
};

/* ---- hosts ---- */

template <class F, class Rays, class Hits> auto answer(F &&f, Rays rays, Hits hits) ->
    typename std::enable_if<std::is_void<decltype(f(rays, hits))>::value, std::int32_t>::type {
    f(rays, hits);
    return 0;
}
template <class F, class Rays, class Hits> auto answer(F &&f, Rays rays, Hits hits) ->
    typename std::enable_if<!std::is_void<decltype(f(rays, hits))>::value, std::int32_t>::type {
    return static_cast<std::int32_t>(f(rays, hits));
}

template <class Host> struct ask_intersect {
    Host &host;
    auto operator()(span<const volgrad_ray> rays, span<volgrad_hit> hits) const -> decltype(host.intersect(rays, hits)) {
        return host.intersect(rays, hits);
    }
};
template <class Host> struct ask_occluded {
    Host &host;
    auto operator()(span<const volgrad_ray> rays, span<volgrad_hit> hits) const -> decltype(host.occluded(rays, hits)) {
        return host.occluded(rays, hits);
    }
};

/* A C++ host for the time of one call, with what it threw. */
template <class Host> class bridge {
  public:
    explicit bridge(Host &host) : host_(host), queries_(sized<volgrad_queries>()) {
        queries_.user = this;
        queries_.intersect = [](void *user, const volgrad_ray *rays, volgrad_hit *hits, std::uint32_t count) -> std::int32_t {
            bridge &self = *static_cast<bridge *>(user);
            return self.guarded(ask_intersect<Host>{self.host_}, rays, hits, count);
        };
        queries_.occluded = [](void *user, const volgrad_ray *rays, volgrad_hit *hits, std::uint32_t count) -> std::int32_t {
            bridge &self = *static_cast<bridge *>(user);
            return self.guarded(ask_occluded<Host>{self.host_}, rays, hits, count);
        };
    }
    bridge(const bridge &) = delete;
    bridge &operator=(const bridge &) = delete;
    const volgrad_queries *get() const noexcept { return &queries_; }
    result finish(volgrad_status status) const {
#ifndef VOLGRAD_NO_EXCEPTIONS
        if (thrown_) std::rethrow_exception(thrown_);
#endif
        return detail::finish(status);
    }

  private:
    template <class Ask>
    std::int32_t guarded(Ask ask, const volgrad_ray *rays, volgrad_hit *hits, std::uint32_t count) noexcept {
        const span<const volgrad_ray> questions(rays, count);
        const span<volgrad_hit> answers(hits, count);
#ifndef VOLGRAD_NO_EXCEPTIONS
        try {
            return answer(ask, questions, answers);
        } catch (...) {
            thrown_ = std::current_exception();
            return -1;
        }
#else
        return answer(ask, questions, answers);
#endif
    }
    Host &host_;
    volgrad_queries queries_;
#ifndef VOLGRAD_NO_EXCEPTIONS
    std::exception_ptr thrown_;
#endif
};

/* C's own pass through. */
template <> class bridge<const volgrad_queries> {
  public:
    explicit bridge(const volgrad_queries &queries) : queries_(queries) {}
    const volgrad_queries *get() const noexcept { return &queries_; }
    result finish(volgrad_status status) const { return detail::finish(status); }

  private:
    const volgrad_queries &queries_;
};
template <> class bridge<volgrad_queries> : public bridge<const volgrad_queries> {
  public:
    using bridge<const volgrad_queries>::bridge;
};

template <class Host> using bridge_to = bridge<typename std::remove_reference<Host>::type>;

} // namespace detail

/* A host made of two functions. */
template <class Intersect, class Occluded> struct host_of {
    Intersect intersect;
    Occluded occluded;
};
template <class Intersect, class Occluded>
host_of<typename std::decay<Intersect>::type, typename std::decay<Occluded>::type> make_host(Intersect &&f, Occluded &&g) {
    return {std::forward<Intersect>(f), std::forward<Occluded>(g)};
}

/* ---- what a host computes itself ---- */

namespace detail {

inline float no_number() { return std::numeric_limits<float>::quiet_NaN(); }
inline volgrad_vec3 no_vector() { return {no_number(), no_number(), no_number()}; }
inline volgrad_rgb no_colour() { return {no_number(), no_number(), no_number()}; }

/* f(), or if that throws, fail(), for what the library counts as no value. */
template <class F, class Fail> auto guarded(F f, Fail fail) noexcept -> decltype(f()) {
#ifndef VOLGRAD_NO_EXCEPTIONS
    try {
        return f();
    } catch (...) {
        return fail();
    }
#else
    (void)fail;
    return f();
#endif
}

/* A table of C's, whose `user` is an object. */
template <class Table, class Object> class table_of {
  public:
    explicit table_of(Object object) : c_(sized<Table>()), object_(std::move(object)) { c_.user = &object_; }
    table_of(const table_of &) = delete;
    table_of &operator=(const table_of &) = delete;
    const Table *get() const noexcept { return &c_; }

  protected:
    Table c_;
    Object object_;
};

} // namespace detail

/* The next four compute what C asks callbacks for with the functions of an object, which they keep: get() is for the scene's description,
 * and they must stay where they are as long as the scene. All threads that use the scene call the object's functions, which are const.
 * What they throw ends there: the value becomes NaN, which scene::dropped_densities and scene::dropped_values count.
 * Of set_...<Object>(table, 0) the better fit is taken, which is there if the object has the function. */

/* A density, for volgrad_medium.custom. The object has
 *     void density(volgrad::span<const volgrad_vec3> points, volgrad::span<float> densities)
 *     void gradient(volgrad::span<const volgrad_vec3> points, volgrad::span<volgrad_vec3> gradients)
 * and, if it can,
 *     void integrals(const volgrad_stretch &, bool gradients, volgrad_density_integrals &) */
template <class Density> class custom_density : public detail::table_of<volgrad_custom_density, Density> {
  public:
    custom_density(Density object, float step, float majorant) : detail::table_of<volgrad_custom_density, Density>(std::move(object)) {
        volgrad_custom_density &c = this->c_;
        c.step = step, c.majorant = majorant;
        c.density = [](void *user, const volgrad_vec3 *points, float *values, std::uint32_t count) {
            const span<float> what(values, count);
            detail::guarded([&] { at(user).density(span<const volgrad_vec3>(points, count), what); },
                            [&] { for (float &value : what) value = detail::no_number(); });
        };
        c.gradient = [](void *user, const volgrad_vec3 *points, volgrad_vec3 *values, std::uint32_t count) {
            const span<volgrad_vec3> what(values, count);
            detail::guarded([&] { at(user).gradient(span<const volgrad_vec3>(points, count), what); },
                            [&] { for (volgrad_vec3 &value : what) value = detail::no_vector(); });
        };
        set_integrals<Density>(c, 0);
    }

  private:
    static const Density &at(const void *user) { return *static_cast<const Density *>(user); }
    template <class T> static void set_integrals(volgrad_custom_density &, ...) {}
    template <class T> static auto set_integrals(volgrad_custom_density &c, int) -> decltype(void(&T::integrals)) {
        c.integrals = [](void *user, const volgrad_stretch *stretch, std::int32_t gradients, volgrad_density_integrals *sums) {
            detail::guarded([&] { at(user).integrals(*stretch, gradients != 0, *sums); }, [&] { sums->density = detail::no_number(); });
        };
    }
};

/* A BSDF, for volgrad_material.custom; `flags` are C's. The object has
 *     volgrad_rgb eval(const volgrad_surface_point &at, volgrad_vec3 to_camera, volgrad_vec3 to_light)
 *     float pdf(const volgrad_surface_point &at, volgrad_vec3 to_camera, volgrad_vec3 to_light)
 *     bool sample(const volgrad_surface_point &at, volgrad_vec3 to_camera, const double *u, volgrad_vec3 &to_light, float &eta_squared)
 * and, if it can,
 *     void log_gradient(const volgrad_surface_point &at, volgrad_vec3 to_camera, volgrad_vec3 to_light, volgrad_vec3 *by_camera,
 *                       volgrad_vec3 *by_light)
 * A diffuse one with a texture is a custom_texture. */
template <class Bsdf> class custom_bsdf : public detail::table_of<volgrad_custom_bsdf, Bsdf> {
  public:
    explicit custom_bsdf(Bsdf bsdf, std::uint32_t flags = 0) : detail::table_of<volgrad_custom_bsdf, Bsdf>(std::move(bsdf)) {
        volgrad_custom_bsdf &c = this->c_;
        c.flags = flags;
        c.eval = [](void *user, const volgrad_surface_point *at, volgrad_vec3 to_camera, volgrad_vec3 to_light, volgrad_rgb *value) {
            *value = detail::guarded([&] { return object(user).eval(*at, to_camera, to_light); }, detail::no_colour);
        };
        c.pdf = [](void *user, const volgrad_surface_point *at, volgrad_vec3 to_camera, volgrad_vec3 to_light) -> float {
            return detail::guarded([&] { return object(user).pdf(*at, to_camera, to_light); }, detail::no_number);
        };
        c.sample = [](void *user, const volgrad_surface_point *at, volgrad_vec3 to_camera, const double *u, volgrad_vec3 *to_light,
                      float *eta_squared) -> std::int32_t {
            return detail::guarded([&] { return bool(object(user).sample(*at, to_camera, u, *to_light, *eta_squared)); },
                                   [&] { return *to_light = detail::no_vector(), true; });
        };
        set_gradient<Bsdf>(c, 0);
    }

  private:
    static const Bsdf &object(const void *user) { return *static_cast<const Bsdf *>(user); }
    template <class T> static void set_gradient(volgrad_custom_bsdf &, ...) {}
    template <class T> static auto set_gradient(volgrad_custom_bsdf &c, int) -> decltype(void(&T::log_gradient)) {
        c.log_gradient = [](void *user, const volgrad_surface_point *at, volgrad_vec3 to_camera, volgrad_vec3 to_light, volgrad_vec3 *by_camera,
                            volgrad_vec3 *by_light) {
            detail::guarded([&] { object(user).log_gradient(*at, to_camera, to_light, by_camera, by_light); },
                            [&] { by_camera[0] = detail::no_vector(); });
        };
    }
};

/* A diffuse surface with a texture, for volgrad_material.custom. The object has
 *     volgrad_rgb reflectance(const volgrad_surface_point &at) */
template <class Texture> class custom_texture : public detail::table_of<volgrad_custom_bsdf, Texture> {
  public:
    explicit custom_texture(Texture object) : detail::table_of<volgrad_custom_bsdf, Texture>(std::move(object)) {
        this->c_.flags = VOLGRAD_BSDF_LAMBERTIAN;
        this->c_.eval = [](void *user, const volgrad_surface_point *at, volgrad_vec3, volgrad_vec3, volgrad_rgb *value) {
            const float per_steradian = 0.318309886f;
            *value = detail::guarded([&] { return static_cast<const Texture *>(user)->reflectance(*at); }, detail::no_colour);
            value->r *= per_steradian, value->g *= per_steradian, value->b *= per_steradian;
        };
    }
};

/* A phase function, for volgrad_scene_desc.phases. The object has
 *     double eval(double mu)
 *     double sample(double u)
 * and, if it can,
 *     double log_derivative(double mu) */
template <class Phase> class custom_phase : public detail::table_of<volgrad_custom_phase, Phase> {
  public:
    explicit custom_phase(Phase object) : detail::table_of<volgrad_custom_phase, Phase>(std::move(object)) {
        volgrad_custom_phase &c = this->c_;
        c.eval = [](void *user, double mu) -> double {
            return detail::guarded([&] { return double(at(user).eval(mu)); }, detail::no_number);
        };
        c.sample = [](void *user, double u) -> double {
            return detail::guarded([&] { return double(at(user).sample(u)); }, detail::no_number);
        };
        set_derivative<Phase>(c, 0);
    }

  private:
    static const Phase &at(const void *user) { return *static_cast<const Phase *>(user); }
    template <class T> static void set_derivative(volgrad_custom_phase &, ...) {}
    template <class T> static auto set_derivative(volgrad_custom_phase &c, int) -> decltype(void(&T::log_derivative)) {
        c.log_derivative = [](void *user, double mu) -> double {
            return detail::guarded([&] { return double(at(user).log_derivative(mu)); }, detail::no_number);
        };
    }
};

/* A light, for volgrad_light.custom. The object has
 *     volgrad_rgb emission(volgrad_vec3 direction)
 * and, for a sky,
 *     float pdf(volgrad_vec3 to_sky)
 *     bool sample(const double *u, volgrad_vec3 &to_sky)
 * or, for a point, if it can,
 *     void log_gradient(volgrad_vec3 direction, volgrad_vec3 *gradient) */
template <class Light> class custom_light : public detail::table_of<volgrad_custom_light, Light> {
  public:
    explicit custom_light(Light object) : detail::table_of<volgrad_custom_light, Light>(std::move(object)) {
        volgrad_custom_light &c = this->c_;
        c.emission = [](void *user, volgrad_vec3 direction, volgrad_rgb *value) {
            *value = detail::guarded([&] { return at(user).emission(direction); }, detail::no_colour);
        };
        set_sampling<Light>(c, 0);
        set_gradient<Light>(c, 0);
    }

  private:
    static const Light &at(const void *user) { return *static_cast<const Light *>(user); }
    template <class T> static void set_sampling(volgrad_custom_light &, ...) {}
    template <class T> static auto set_sampling(volgrad_custom_light &c, int) -> decltype(void(&T::pdf)) {
        c.pdf = [](void *user, volgrad_vec3 to_sky) -> float {
            return detail::guarded([&] { return at(user).pdf(to_sky); }, detail::no_number);
        };
        c.sample = [](void *user, const double *u, volgrad_vec3 *to_sky) -> std::int32_t {
            return detail::guarded([&] { return bool(at(user).sample(u, *to_sky)); },
                                   [&] { return *to_sky = detail::no_vector(), true; });
        };
    }
    template <class T> static void set_gradient(volgrad_custom_light &, ...) {}
    template <class T> static auto set_gradient(volgrad_custom_light &c, int) -> decltype(void(&T::log_gradient)) {
        c.log_gradient = [](void *user, volgrad_vec3 direction, volgrad_vec3 *gradient) {
            detail::guarded([&] { at(user).log_gradient(direction, gradient); }, [&] { gradient[0] = detail::no_vector(); });
        };
    }
};

/* ---- options, with their defaults ---- */

namespace detail {
template <class T> T defaults(volgrad_status (*fill)(T *, std::size_t)) {
    T options;
    (void)fill(&options, sizeof options); /* fails for no options of this header's size */
    return options;
}
} // namespace detail

inline volgrad_shift_options shift_options_default() { return detail::defaults(volgrad_shift_options_default); }
inline volgrad_path_sampler_options path_sampler_options_default() { return detail::defaults(volgrad_path_sampler_options_default); }
inline volgrad_bidirectional_options bidirectional_options_default() { return detail::defaults(volgrad_bidirectional_options_default); }
inline volgrad_chain_options chain_options_default() { return detail::defaults(volgrad_chain_options_default); }
inline volgrad_transmittance_options transmittance_options_default() { return detail::defaults(volgrad_transmittance_options_default); }

/* ---- objects that own their memory: movable, not copyable, empty until init ---- */

/* A film. */
class film {
  public:
    film() = default;
#ifndef VOLGRAD_NO_EXCEPTIONS
    film(std::uint32_t width, std::uint32_t height) { init(width, height); }
#endif
    result init(std::uint32_t width, std::uint32_t height) { return make(width, height, volgrad_film_init); }
    /* Of which any number of threads may use one reference at a time, to add to it. */
    result init_shared(std::uint32_t width, std::uint32_t height) { return make(width, height, volgrad_film_init_shared); }
    result add(span<const volgrad_splat> splats) { return detail::finish(volgrad_film_add(film_.get(), splats.data(), splats.size())); }
    result merge(const volgrad_film *from) { return detail::finish(volgrad_film_merge(film_.get(), from)); }
    result develop(double scale, span<float> rgb) const {
        return detail::finish(volgrad_film_develop(film_.get(), scale, rgb.data(), rgb.size()));
    }
    result dropped(std::uint64_t &count) const { return detail::finish(volgrad_film_dropped(film_.get(), &count)); }
    /* Wherever C takes a film. */
    operator volgrad_film *() noexcept { return film_.get(); }
    operator const volgrad_film *() const noexcept { return film_.get(); }

  private:
    template <class Init> result make(std::uint32_t width, std::uint32_t height, Init in_memory) {
        std::size_t bytes = 0;
        const volgrad_status status = volgrad_film_size(width, height, &bytes);
        return detail::finish(film_.make(status, bytes, [&](void *memory, std::size_t size, volgrad_film **made) {
            return in_memory(memory, size, width, height, made);
        }));
    }
    detail::object<volgrad_film> film_;
};

/* A scene, or with init_guide a guided one. What volgrad_scene_init borrows must outlive it, and so must the scene that a guided one is made of. */
class scene {
  public:
    scene() = default;
#ifndef VOLGRAD_NO_EXCEPTIONS
    explicit scene(const volgrad_scene_desc &desc) { init(desc); }
#endif
    /* `place`, if not NULL, says which field was wrong; the exception does, too. */
    result init(const volgrad_scene_desc &desc, volgrad_error *place = nullptr) {
        volgrad_error wrong = sized<volgrad_error>();
        std::size_t bytes = 0;
        if (volgrad_scene_size(&desc, &bytes) != VOLGRAD_OK) bytes = 0; /* whatever was wrong with the size, init names it */
        const volgrad_status status = scene_.make(VOLGRAD_OK, bytes, [&](void *memory, std::size_t size, const volgrad_scene **made) {
            return volgrad_scene_init(memory, size, &desc, made, &wrong);
        });
        if (place) *place = wrong;
        return detail::finish(status, wrong);
    }
    /* volgrad_guide_init: `unguided`, with the guides that `lesson` tells. */
    result init_guide(const volgrad_scene *unguided, volgrad_film *lesson) {
        std::size_t bytes = 0;
        const volgrad_status status = volgrad_guide_size(unguided, &bytes);
        return detail::finish(scene_.make(status, bytes, [&](void *memory, std::size_t size, const volgrad_scene **made) {
            return volgrad_guide_init(memory, size, unguided, lesson, made);
        }));
    }
    result dropped_densities(std::uint64_t &count) const { return detail::finish(volgrad_scene_dropped_densities(scene_.get(), &count)); }
    result dropped_values(std::uint64_t &count) const { return detail::finish(volgrad_scene_dropped_values(scene_.get(), &count)); }
    /* Wherever C takes a scene. */
    operator const volgrad_scene *() const noexcept { return scene_.get(); }

  private:
    detail::object<const volgrad_scene> scene_;
};

/* A chain. */
class chain {
  public:
    template <class Host>
    result init(const volgrad_scene *scene, Host &&host, const volgrad_chain_options &options, const volgrad_chain_techniques *techniques,
                const volgrad_chain_start &start, volgrad_chain_stats *stats = nullptr) {
        detail::bridge_to<Host> queries(host);
        std::size_t bytes = 0;
        const volgrad_status status = volgrad_chain_size(&options, &bytes);
        return queries.finish(chain_.make(status, bytes, [&](void *memory, std::size_t size, volgrad_chain **made) {
            return volgrad_chain_init(memory, size, scene, queries.get(), &options, techniques, &start, stats, made);
        }));
    }
    template <class Host>
    result run(const volgrad_scene *scene, Host &&host, std::uint64_t mutations, volgrad_film *film, volgrad_chain_stats *stats = nullptr) {
        detail::bridge_to<Host> queries(host);
        return queries.finish(volgrad_chain_run(chain_.get(), scene, queries.get(), mutations, film, stats));
    }
    template <class Host>
    result flush(const volgrad_scene *scene, Host &&host, volgrad_film *film, volgrad_chain_stats *stats = nullptr) const {
        detail::bridge_to<Host> queries(host);
        return queries.finish(volgrad_chain_flush(chain_.get(), scene, queries.get(), film, stats));
    }
    template <class Host>
    result peek(const volgrad_scene *scene, Host &&host, volgrad_chain_mutation &mutation, span<volgrad_vertex> current,
                span<volgrad_vertex> proposed) const {
        detail::bridge_to<Host> queries(host);
        const std::size_t capacity = current.size() < proposed.size() ? current.size() : proposed.size();
        mutation = sized<volgrad_chain_mutation>();
        return queries.finish(volgrad_chain_peek(chain_.get(), scene, queries.get(), &mutation, current.data(), proposed.data(),
                                                 detail::count32(capacity)));
    }
    operator volgrad_chain *() noexcept { return chain_.get(); }
    operator const volgrad_chain *() const noexcept { return chain_.get(); }

  private:
    detail::object<volgrad_chain> chain_;
};

/* ---- kernels ---- */

/* Views of arrays that must outlive them. A path whose arrays do not fit each other is left to volgrad_path_validate. */
inline volgrad_line line(volgrad_vec3 origin, volgrad_vec3 direction, float length, span<const volgrad_segment> segments) {
    return {origin, direction, length, detail::count32(segments.size()), segments.data()};
}
inline volgrad_path path(span<const volgrad_vertex> vertices, span<const volgrad_segment> segments, span<const std::uint32_t> edge_ends) {
    const std::size_t ended = edge_ends.size() + 1; /* so many vertices have their edges */
    const std::uint32_t count = detail::count32(vertices.size() < ended ? vertices.size() : ended);
    return {vertices.data(), segments.data(), edge_ends.data(), count, detail::count32(segments.size())};
}

inline result line_optical_depth(const volgrad_scene *scene, const volgrad_line &line, volgrad_optical_depth &depth) {
    return detail::finish(volgrad_line_optical_depth(scene, &line, &depth));
}
inline result line_tau(const volgrad_scene *scene, const volgrad_line &line, volgrad_rgb &tau) {
    return detail::finish(volgrad_line_tau(scene, &line, &tau));
}
inline result line_sample_distance(const volgrad_scene *scene, const volgrad_line &line, double u, volgrad_flight &flight) {
    return detail::finish(volgrad_line_sample_distance(scene, &line, u, &flight));
}
inline result line_invert_distance(const volgrad_scene *scene, const volgrad_line &line, double &u) {
    return detail::finish(volgrad_line_invert_distance(scene, &line, &u));
}
inline result line_transmittance_estimate(const volgrad_scene *scene, const volgrad_line &line, const volgrad_transmittance_options &options,
                                          std::uint64_t seed, std::uint64_t index, volgrad_transmittance_estimate &estimate) {
    return detail::finish(volgrad_line_transmittance_estimate(scene, &line, &options, seed, index, &estimate));
}
inline result phase_eval(const volgrad_phase &phase, volgrad_vec3 to_previous, volgrad_vec3 to_next, volgrad_phase_value &value) {
    return detail::finish(volgrad_phase_eval(&phase, to_previous, to_next, &value));
}
inline result phase_sample(const volgrad_phase &phase, volgrad_vec3 to_previous, double u0, double u1, volgrad_vec3 &to_next) {
    return detail::finish(volgrad_phase_sample(&phase, to_previous, u0, u1, &to_next));
}
inline result phase_invert(const volgrad_phase &phase, volgrad_vec3 to_previous, volgrad_vec3 to_next, double &u0, double &u1) {
    return detail::finish(volgrad_phase_invert(&phase, to_previous, to_next, &u0, &u1));
}

namespace detail {
template <class T> result validate(volgrad_status (*check)(const T *, volgrad_error *), const T &options) {
    volgrad_error wrong = sized<volgrad_error>();
    const volgrad_status status = check(&options, &wrong);
    return finish(status, wrong);
}
} // namespace detail

/* Options and answers that are refused; the exception names the field. */
inline result validate(const volgrad_shift_options &options) { return detail::validate(volgrad_shift_options_validate, options); }
inline result validate(const volgrad_path_sampler_options &options) {
    return detail::validate(volgrad_path_sampler_options_validate, options);
}
inline result validate(const volgrad_bidirectional_options &options) {
    return detail::validate(volgrad_bidirectional_options_validate, options);
}
inline result validate(const volgrad_chain_options &options) { return detail::validate(volgrad_chain_options_validate, options); }
inline result hit_validate(const volgrad_scene *scene, const volgrad_ray &ray, const volgrad_hit &hit) {
    volgrad_error wrong = sized<volgrad_error>();
    const volgrad_status status = volgrad_hit_validate(scene, &ray, &hit, &wrong);
    return detail::finish(status, wrong);
}

/* `place`, if not NULL, says which vertex was wrong; the exception does, too. */
inline result path_validate(const volgrad_scene *scene, const volgrad_path &path, volgrad_error *place = nullptr) {
    volgrad_error wrong = sized<volgrad_error>();
    const volgrad_status status = volgrad_path_validate(scene, &path, &wrong);
    if (place) *place = wrong;
    return detail::finish(status, wrong);
}
inline result path_report(const volgrad_scene *scene, const volgrad_path &path, std::string &text) {
    std::size_t length = 0;
    volgrad_status status = volgrad_path_report(scene, &path, nullptr, 0, &length);
    if (status == VOLGRAD_OK) {
        text.resize(length + 1); /* with the 0 that C ends it with */
        status = volgrad_path_report(scene, &path, &text[0], text.size(), &length);
        text.resize(length);
    }
    return detail::finish(status);
}
inline result path_contribution(const volgrad_scene *scene, const volgrad_path &path, double (&rgb)[3]) {
    return detail::finish(volgrad_path_contribution(scene, &path, rgb));
}
inline result path_factors(const volgrad_scene *scene, const volgrad_path &path, span<volgrad_path_factor> factors) {
    return detail::finish(volgrad_path_factors(scene, &path, factors.data(), factors.size()));
}
inline result path_log_gradient(const volgrad_scene *scene, const volgrad_path &path, std::uint32_t vertex, volgrad_gradient &gradient) {
    return detail::finish(volgrad_path_log_gradient(scene, &path, vertex, &gradient));
}
inline result path_run_log_gradient(const volgrad_scene *scene, const volgrad_path &path, std::uint32_t first, std::uint32_t count,
                                    volgrad_gradient &gradient) {
    return detail::finish(volgrad_path_run_log_gradient(scene, &path, first, count, &gradient));
}
inline result path_run_log_derivative(const volgrad_scene *scene, const volgrad_path &path, std::uint32_t first, std::uint32_t count,
                                      volgrad_derivative &derivative) {
    return detail::finish(volgrad_path_run_log_derivative(scene, &path, first, count, &derivative));
}

/* ---- shifts ---- */

/* For modes that ask nothing about the scene's surfaces (volgrad_shift_path): `count` of `splats` are written. */
inline result shift_path(const volgrad_scene *scene, const volgrad_shift_options &options, const volgrad_path &path, volgrad_rgb weight,
                         std::uint64_t seed, std::uint64_t index, span<volgrad_splat> splats, std::uint32_t &count) {
    const std::uint32_t capacity = detail::count32(splats.size());
    return detail::finish(volgrad_shift_path(scene, nullptr, &options, &path, weight, seed, index, splats.data(), capacity, &count));
}
inline result shift_paths(const volgrad_scene *scene, const volgrad_shift_options &options, span<const volgrad_path> paths,
                          span<const volgrad_rgb> weights, std::uint64_t seed, std::uint64_t first_index, span<volgrad_splat> splats,
                          std::uint32_t &count) {
    if (weights.size() < paths.size()) return detail::finish(VOLGRAD_ERROR_TOO_SMALL);
    return detail::finish(volgrad_shift_paths(scene, nullptr, &options, paths.data(), weights.data(), detail::count32(paths.size()), seed,
                                              first_index, splats.data(), detail::count32(splats.size()), &count));
}

/* `count` of `splats` are written. */
template <class Host>
result shift_path(const volgrad_scene *scene, Host &&host, const volgrad_shift_options &options, const volgrad_path &path, volgrad_rgb weight,
                  std::uint64_t seed, std::uint64_t index, span<volgrad_splat> splats, std::uint32_t &count) {
    detail::bridge_to<Host> queries(host);
    const std::uint32_t capacity = detail::count32(splats.size());
    return queries.finish(
        volgrad_shift_path(scene, queries.get(), &options, &path, weight, seed, index, splats.data(), capacity, &count));
}

/* `count` of `splats` are written. */
template <class Host>
result shift_paths(const volgrad_scene *scene, Host &&host, const volgrad_shift_options &options, span<const volgrad_path> paths,
                   span<const volgrad_rgb> weights, std::uint64_t seed, std::uint64_t first_index, span<volgrad_splat> splats,
                   std::uint32_t &count) {
    detail::bridge_to<Host> queries(host);
    if (weights.size() < paths.size()) return queries.finish(VOLGRAD_ERROR_TOO_SMALL);
    return queries.finish(volgrad_shift_paths(scene, queries.get(), &options, paths.data(), weights.data(), detail::count32(paths.size()),
                                              seed, first_index, splats.data(), detail::count32(splats.size()), &count));
}
inline result shift_tile(const volgrad_scene *scene, const volgrad_shift_options &options, std::uint64_t seed, std::uint32_t x,
                         std::uint32_t y, std::uint32_t (&bounds)[4]) {
    return detail::finish(volgrad_shift_tile(scene, &options, seed, x, y, bounds));
}

/* ---- samplers ---- */

template <class Host>
result path_sampler_run(const volgrad_scene *scene, Host &&host, const volgrad_path_sampler_options &options, std::uint64_t pass,
                        std::uint32_t first_pixel, std::uint32_t pixel_count, volgrad_film *film,
                        volgrad_path_sampler_stats *stats = nullptr) {
    detail::bridge_to<Host> queries(host);
    return queries.finish(volgrad_path_sampler_run(scene, queries.get(), &options, pass, first_pixel, pixel_count, film, stats));
}
template <class Host>
result bidirectional_run(const volgrad_scene *scene, Host &&host, const volgrad_bidirectional_options &options, std::uint64_t pass,
                         std::uint32_t first_pixel, std::uint32_t pixel_count, volgrad_film *film,
                         volgrad_path_sampler_stats *stats = nullptr) {
    detail::bridge_to<Host> queries(host);
    return queries.finish(volgrad_bidirectional_run(scene, queries.get(), &options, pass, first_pixel, pixel_count, film, stats));
}
template <class Host>
result bidirectional_run_technique(const volgrad_scene *scene, Host &&host, const volgrad_bidirectional_options &options,
                                   std::uint32_t light_vertices, std::uint32_t camera_vertices, bool weighted, std::uint64_t pass,
                                   std::uint32_t first_pixel, std::uint32_t pixel_count, volgrad_film *film,
                                   volgrad_path_sampler_stats *stats = nullptr) {
    detail::bridge_to<Host> queries(host);
    return queries.finish(volgrad_bidirectional_run_technique(scene, queries.get(), &options, light_vertices, camera_vertices, weighted,
                                                              pass, first_pixel, pixel_count, film, stats));
}

inline result guide_film_size(const volgrad_scene *scene, std::uint32_t &width, std::uint32_t &height) {
    return detail::finish(volgrad_guide_film_size(scene, &width, &height));
}
template <class Host>
result guide_learn(const volgrad_scene *scene, Host &&host, const volgrad_bidirectional_options &options, std::uint64_t pass,
                   std::uint32_t first_pixel, std::uint32_t pixel_count, volgrad_film *lesson,
                   volgrad_path_sampler_stats *stats = nullptr) {
    detail::bridge_to<Host> queries(host);
    return queries.finish(volgrad_guide_learn(scene, queries.get(), &options, pass, first_pixel, pixel_count, lesson, stats));
}

template <class Host>
result chain_bootstrap(const volgrad_scene *scene, Host &&host, const volgrad_chain_options &options,
                       const volgrad_chain_techniques *techniques, std::uint64_t first, span<float> weights,
                       volgrad_chain_stats *stats = nullptr) {
    detail::bridge_to<Host> queries(host);
    const std::uint32_t count = detail::count32(weights.size());
    return queries.finish(volgrad_chain_bootstrap(scene, queries.get(), &options, techniques, first, count, weights.data(), stats));
}
inline result chain_learn(const volgrad_chain_options &options, span<const float> weights, volgrad_chain_techniques &techniques) {
    return detail::finish(volgrad_chain_learn(&options, weights.data(), weights.size(), &techniques));
}
/* Without `starts` only the result. */
inline result chain_plan(const volgrad_chain_options &options, const volgrad_chain_techniques *techniques, span<const float> weights,
                         std::uint32_t wanted, span<volgrad_chain_start> starts, volgrad_chain_plan_result &plan) {
    plan = sized<volgrad_chain_plan_result>();
    return detail::finish(volgrad_chain_plan(&options, techniques, weights.data(), weights.size(), wanted, starts.data(),
                                             detail::count32(starts.size()), &plan));
}

/* ---- images ---- */

inline result exr_write(const char *path, const volgrad_exr_layout &layout, span<const float> rgb,
                        span<const volgrad_exr_attribute> attributes = span<const volgrad_exr_attribute>()) {
    return detail::finish(
        volgrad_exr_write(path, &layout, rgb.data(), rgb.size(), attributes.data(), detail::count32(attributes.size())));
}
inline result exr_read_layout(const char *path, volgrad_exr_layout &layout) {
    return detail::finish(volgrad_exr_read_layout(path, &layout));
}
inline result exr_read(const char *path, span<float> rgb) { return detail::finish(volgrad_exr_read(path, rgb.data(), rgb.size())); }

} // namespace throwing or returning
} // namespace volgrad

#endif
