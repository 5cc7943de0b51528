/* Tests of the scene reader: good scenes are compared with hand-computed numbers, each kind of error with where it is reported.

   Build: cc -std=c11 -Iinclude -Iexamples_c/render tests/host/reader_test.c <the reader's .c files> -lexpat -lassimp -lm
   Writes into a temporary directory and removes it. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "scene.h"

static char folder[] = "/tmp/reader_test_XXXXXX";
static char messages[8192]; /* what the last load printed to stderr */
static int passed, failed;

#define CHECK(condition) check((condition) != 0, #condition, __LINE__)

static void check(int ok, const char *what, int line)
{
    ok ? passed++ : failed++;
    if (!ok) {
        printf("reader_test.c:%d: failed: %s\n", line, what);
    }
}

static void check_near(double value, double expected, int line)
{
    int ok = fabs(value - expected) <= 1e-6 * fmax(1, fabs(expected));
    ok ? passed++ : failed++;
    if (!ok) {
        printf("reader_test.c:%d: failed: %.9g is not %.9g\n", line, value, expected);
    }
}

#define NEAR(value, expected) check_near((value), (expected), __LINE__)
#define NEAR3(v, a, b, c) (check_near((v).x, (a), __LINE__), check_near((v).y, (b), __LINE__), check_near((v).z, (c), __LINE__))

/* --- files ----------------------------------------------------------------------------------------------------------------- */

static const char *path_of(const char *name)
{
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static void write_file(const char *name, const void *content, size_t bytes)
{
    FILE *file = fopen(path_of(name), "wb");
    if (!file || fwrite(content, 1, bytes, file) != bytes || fclose(file) != 0) {
        printf("cannot write %s\n", path_of(name));
        exit(2);
    }
}

static void write_text(const char *name, const char *text)
{
    write_file(name, text, strlen(text));
}

typedef struct {
    char magic[4]; /* the version is the last */
    int32_t encoding, size[3], channels;
    float box[6];
    float values[8];
} vol_image;

/* A 2 x 2 x 2 grid whose sample i is i. As this machine is little endian, the struct is the file. */
static vol_image good_vol(void)
{
    return (vol_image){{'V', 'O', 'L', 3}, 1, {2, 2, 2}, 1, {-1, -2, -3, 1, 2, 5}, {0, 1, 2, 3, 4, 5, 6, 7}};
}

static void write_vol(const char *name, vol_image image)
{
    write_file(name, &image, sizeof image);
}

static void write_meshes(void)
{
    /* A unit triangle, a quad of area 3 and a triangle without area. */
    const char *obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 3 0 1\nv 3 1 1\nv 0 1 1\nf 1 2 3\nf 4 5 6 7\nf 1 2 2\n";
    write_text("mesh.obj", obj);
    write_text("mesh.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
               "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    write_text("broken.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty flo");
    write_text("wrong.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty flo\nend_header\n1 2 3\n");
    write_text("empty.ply", "");
}

static void write_data(void)
{
    vol_image image = good_vol();
    write_vol("good.vol", image);
    write_file("short.vol", &image, sizeof image - 4);
    write_file("header.vol", &image, 20);
    image.magic[0] = 'X';
    write_vol("magic.vol", image);
    image = good_vol();
    image.magic[3] = 2;
    write_vol("version.vol", image);
    image = good_vol();
    image.encoding = 2;
    write_vol("encoding.vol", image);
    image = good_vol();
    image.channels = 3;
    write_vol("channels.vol", image);
    image = good_vol();
    image.size[1] = -2;
    write_vol("side.vol", image);
    image = good_vol();
    image.values[5] = NAN;
    write_vol("nan.vol", image);
    image = good_vol();
    image.values[6] = -1;
    write_vol("negative.vol", image);
    image = good_vol();
    image.box[3] = -1;
    write_vol("flatbox.vol", image);
    write_meshes();
}

static void remove_data(void)
{
    static const char *const names[] = {"good.vol",     "short.vol",  "header.vol", "magic.vol",    "version.vol", "encoding.vol",
                                        "channels.vol", "side.vol",   "nan.vol",    "negative.vol", "flatbox.vol", "mesh.obj",
                                        "mesh.ply",     "broken.ply", "wrong.ply",  "empty.ply",    "scene.xml",   "messages"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        remove(path_of(names[i]));
    }
    rmdir(folder);
}

/* Loads a file with stderr going into `messages`. */
static int load_path(const char *path, scene *out)
{
    char file_path[256];
    snprintf(file_path, sizeof file_path, "%s", path);
    fflush(stderr);
    int saved = dup(STDERR_FILENO);
    if (saved < 0 || !freopen(path_of("messages"), "w+", stderr)) {
        exit(2);
    }
    int ok = scene_load(file_path, out);
    rewind(stderr);
    messages[fread(messages, 1, sizeof messages - 1, stderr)] = '\0';
    fflush(stderr);
    dup2(saved, STDERR_FILENO);
    close(saved);
    return ok;
}

static int load(const char *xml, scene *out)
{
    write_text("scene.xml", xml);
    return load_path(path_of("scene.xml"), out);
}

/* --- scenes ---------------------------------------------------------------------------------------------------------------- */

#define FILM "<film type='hdrfilm'><rfilter type='box'/></film>"
#define SENSOR "<sensor type='perspective'><float name='fov' value='90'/>" FILM "</sensor>"
#define INTEGRATOR "<integrator type='volpath'/>"
#define SKY "<emitter type='constant'><rgb name='radiance' value='1'/></emitter>"

/* The body of every test scene begins in line 5. */
#define SCENE(body) "<scene version='3.0.0'>\n" INTEGRATOR "\n" SENSOR "\n" SKY "\n" body "\n</scene>\n"
#define WITH_SENSOR(sensor) "<scene version='3.0.0'>\n" INTEGRATOR "\n\n" SKY "\n" sensor "\n</scene>\n"
#define SHAPE(type, content) "<shape type='" type "'>" content "</shape>"
#define MAP(operations) "<transform name='to_world'>" operations "</transform>"
#define AREA "<emitter type='area'><rgb name='radiance' value='1, 2, 3'/></emitter>"
#define GRID(file, content)                                                                                                      \
    "<medium type='heterogeneous' id='m'><volume type='gridvolume' name='sigma_t'><string name='filename' value='" file          \
    "'/>" content "</volume></medium>"

#define NVDB(file, content)                                                                                                      \
    "<medium type='heterogeneous' id='m'><volume type='nvdbvolume' name='sigma_t'><string name='filename' value='" file          \
    "'/>" content "</volume></medium>"

static int load_good(const char *xml, scene *out, int line)
{
    int ok = load(xml, out);
    check(ok, messages, line);
    return ok;
}

#define GOOD(xml, s) if (load_good(xml, s, __LINE__))

static volgrad_vec3 cross(volgrad_vec3 a, volgrad_vec3 b)
{
    return (volgrad_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static volgrad_vec3 corner(const shape *s, uint32_t triangle, int i)
{
    const float *p = s->positions + 3 * (size_t)s->triangles[3 * (size_t)triangle + i];
    return (volgrad_vec3){p[0], p[1], p[2]};
}

static volgrad_vec3 minus(volgrad_vec3 a, volgrad_vec3 b)
{
    return (volgrad_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

/* Twice the triangle's area along its normal. */
static volgrad_vec3 triangle_normal(const shape *s, uint32_t triangle)
{
    volgrad_vec3 a = corner(s, triangle, 0);
    return cross(minus(corner(s, triangle, 1), a), minus(corner(s, triangle, 2), a));
}

static void test_defaults(void)
{
    scene s;
    GOOD(SCENE(SHAPE("sphere", "")), &s)
    {
        CHECK(s.desc.struct_size == sizeof s.desc);
        CHECK(s.max_depth == 0 && s.rr_depth == 5 && s.sample_count == 4);
        CHECK(s.desc.camera.width == 768 && s.desc.camera.height == 576 && s.desc.camera.crop_x1 == 768 &&
              s.desc.camera.crop_y1 == 576);
        CHECK(s.desc.camera.medium == VOLGRAD_NONE);
        NEAR(s.desc.camera.near_clip, .01);
        NEAR(s.desc.camera.tan_half_fov_x, 1);
        CHECK(s.shape_count == 1 && s.shapes[0].kind == SHAPE_SPHERE && s.shapes[0].first_light == VOLGRAD_NONE);
        CHECK(s.shapes[0].medium_inside == VOLGRAD_KEEP_MEDIUM && s.shapes[0].medium_outside == VOLGRAD_KEEP_MEDIUM);
        CHECK(s.desc.material_count == 1 && s.desc.materials[0].kind == VOLGRAD_MATERIAL_DIFFUSE);
        NEAR(s.desc.materials[0].reflectance.g, .5);
        CHECK(s.desc.light_count == 1 && s.desc.lights[0].kind == VOLGRAD_LIGHT_ENVIRONMENT);
        NEAR(s.desc.lights[0].emission.b, 1);
        NEAR(s.desc.lights[0].sampling_weight, 1);
        scene_free(&s);
        CHECK(s.shapes == NULL && s.desc.lights == NULL);
    }
    GOOD("<scene version='3.1'><integrator type='volpathmis'><integer name='max_depth' value='7'/><integer name='rr_depth' "
         "value='9'/></integrator>"
         "<sensor type='perspective'><float name='fov' value='9'/><sampler type='independent'><integer name='sample_count' "
         "value='11'/></sampler>" FILM "</sensor>" SKY "</scene>",
         &s)
    {
        CHECK(s.max_depth == 7 && s.rr_depth == 9 && s.sample_count == 11);
        scene_free(&s);
    }
}

static void test_camera(void)
{
    scene s;
    GOOD(WITH_SENSOR("<sensor type='perspective'><float name='fov' value='60'/>" MAP(
             "<lookat origin='1,2,3' target='1, 2, -5' up='0 2 0'/>") FILM "</sensor>"),
         &s)
    {
        NEAR3(s.desc.camera.position, 1, 2, 3);
        NEAR3(s.desc.camera.forward, 0, 0, -1);
        NEAR3(s.desc.camera.up, 0, 1, 0);
        NEAR3(s.desc.camera.right, 1, 0, 0); /* cross(forward, up) */
        scene_free(&s);
    }
    GOOD(WITH_SENSOR("<sensor type='perspective'><float name='fov' value='60'/>" MAP(
             "<scale x='-1'/><lookat origin='0,0,0' target='0,0,1' up='0,1,0'/>") FILM "</sensor>"),
         &s)
    {
        CHECK(s.desc.camera.kind == VOLGRAD_CAMERA_PINHOLE);
        NEAR3(s.desc.camera.forward, 0, 0, 1);
        NEAR3(s.desc.camera.right, 1, 0, 0); /* mirrored: cross(forward, up) is (-1, 0, 0) */
        scene_free(&s);
    }
    GOOD(WITH_SENSOR("<sensor type='thinlens'><float name='fov' value='60'/><float name='aperture_radius' value='.2'/><float "
                     "name='focus_distance' value='3'/>" FILM "</sensor>"),
         &s)
    {
        CHECK(s.desc.camera.kind == VOLGRAD_CAMERA_THIN_LENS);
        NEAR(s.desc.camera.lens_radius, .2), NEAR(s.desc.camera.focal_distance, 3);
        scene_free(&s);
    }
}

/* Expected: x_fov of Mitsuba 3.9.1's perspective sensor for fov = 40. */
static void test_field_of_view(void)
{
    static const struct {
        const char *axis;
        int width, height;
        double fov_x;
    } cases[] = {{"x", 200, 100, 40.0},
                 {"x", 100, 200, 40.0},
                 {"y", 200, 100, 72.10477447509766},
                 {"y", 100, 200, 20.628210067},
                 {"smaller", 200, 100, 72.10477447509766},
                 {"smaller", 100, 200, 40.0},
                 {"larger", 200, 100, 40.0},
                 {"larger", 100, 200, 20.628210067},
                 {"diagonal", 200, 100, 36.064788818359375},
                 {"diagonal", 100, 200, 18.49018669}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char xml[1024];
        snprintf(
            xml, sizeof xml,
            WITH_SENSOR(
                "<sensor type='perspective'><integer name='fov' value='40'/><string name='fov_axis' value='%s'/><film "
                "type='hdrfilm'>"
                "<integer name='width' value='%d'/><integer name='height' value='%d'/><rfilter type='box'/></film></sensor>"),
            cases[i].axis, cases[i].width, cases[i].height);
        scene s;
        GOOD(xml, &s)
        {
            NEAR(s.desc.camera.tan_half_fov_x, tan(cases[i].fov_x / 2 * 3.14159265358979323846 / 180));
            scene_free(&s);
        }
    }
}

static void test_transform_order(void)
{
    scene s;
    GOOD(SCENE(SHAPE(
             "sphere",
             MAP("<translate x='1'/><rotate z='1' angle='90'/><scale value='2'/><translate value='0, 0, 5'/>") "<float "
                                                                                                               "name='radius' "
                                                                                                               "value='.5'/"
                                                                                                               "><point "
                                                                                                               "name='center' "
                                                                                                               "x='0' y='1' "
                                                                                                               "z='0'/>")),
         &s)
    {
        NEAR3(s.shapes[0].center, -2, 2, 5);
        NEAR(s.shapes[0].radius, 1);
        scene_free(&s);
    }
    GOOD(SCENE(SHAPE("sphere",
                     MAP("<matrix value='0 -2 0 1, 2 0 0 2, 0 0 2 3, 0 0 0 1'/>") "<point name='center' value='1, 0, 0'/>")),
         &s)
    {
        NEAR3(s.shapes[0].center, 1, 4, 3);
        NEAR(s.shapes[0].radius, 2);
        scene_free(&s);
    }
}

/* The cube's two kinds of surface: a null container with a medium, and a bounding shape that keeps the medium. */
static void test_media_sides(void)
{
    scene s;
    GOOD(SCENE("<medium type='homogeneous' id='fog'><rgb name='sigma_t' value='.1,.2,.3'/><float name='scale' value='2'/><phase "
               "type='hg'/></medium>"
               "<bsdf type='null' id='none'/>"
               "<shape type='cube'><ref id='none'/><ref name='interior' id='fog'/></shape>"
               "<shape type='sphere'><bsdf type='dielectric'/><ref name='exterior' id='fog'/></shape>"
               "<shape type='rectangle'><medium name='interior' type='homogeneous'/><ref name='exterior' id='fog'/></shape>"),
         &s)
    {
        const shape *cube = &s.shapes[0], *glass = &s.shapes[1], *both = &s.shapes[2];
        CHECK(cube->is_null && cube->medium_inside == 0 && cube->medium_outside == VOLGRAD_NONE);
        CHECK(!glass->is_null && glass->medium_inside == VOLGRAD_NONE && glass->medium_outside == 0);
        CHECK(both->medium_inside == 1 && both->medium_outside == 0);
        CHECK(s.desc.media_count == 2);
        const volgrad_medium *fog = &s.desc.media[0], *plain = &s.desc.media[1];
        CHECK(fog->kind == VOLGRAD_MEDIUM_HOMOGENEOUS && fog->phase.kind == VOLGRAD_PHASE_HENYEY_GREENSTEIN);
        NEAR(fog->phase.g, .8);
        NEAR(fog->sigma_t.r, .2), NEAR(fog->sigma_t.b, .6), NEAR(fog->albedo.r, .75);
        NEAR(plain->sigma_t.g, 1);
        CHECK(plain->phase.kind == VOLGRAD_PHASE_ISOTROPIC);
        NEAR(s.desc.materials[glass->material].eta, 1.504183292388916); /* Mitsuba's default: bk7 in air */
        scene_free(&s);
    }
}

static void test_sensor_medium(void)
{
    scene s;
    GOOD(WITH_SENSOR(
             "<medium type='homogeneous' id='fog'/><sensor type='perspective'><float name='fov' value='9'/><ref id='fog'/>" FILM
             "</sensor>"),
         &s)
    {
        CHECK(s.desc.camera.medium == 0);
        scene_free(&s);
    }
}

static void test_bsdfs(void)
{
    scene s;
    GOOD(SCENE("<bsdf type='diffuse'><rgb name='reflectance' value='.1 .2 .3'/></bsdf><bsdf type='diffuse'><float "
               "name='reflectance' value='.4'/></bsdf>"
               "<bsdf type='conductor'><string name='material' value='none'/></bsdf>"
               "<bsdf type='dielectric'><float name='int_ior' value='1.5'/><string name='ext_ior' value='water'/></bsdf>"),
         &s)
    {
        const volgrad_material *m = s.desc.materials;
        CHECK(s.desc.material_count == 4);
        NEAR(m[0].reflectance.b, .3), NEAR(m[1].reflectance.b, .4);
        CHECK(m[2].kind == VOLGRAD_MATERIAL_CONDUCTOR && m[2].reflectance.r == 1 && m[2].conductor_k.r == 1);
        CHECK(m[3].kind == VOLGRAD_MATERIAL_DIELECTRIC);
        NEAR(m[3].eta, 1.5 / 1.333);
        scene_free(&s);
    }
}

static void test_rough_bsdfs(void)
{
#define GGX "<string name='distribution' value='ggx'/>"
    scene s;
    GOOD(SCENE("<bsdf type='conductor'><rgb name='eta' value='.1,.2,.3'/><rgb name='k' value='4'/></bsdf>"
               "<bsdf type='roughconductor' id='gold'>" GGX "<string name='material' value='Au'/><float name='alpha' value='.2'/>"
               "<rgb name='specular_reflectance' value='.5'/></bsdf>"
               "<bsdf type='roughdielectric'>" GGX "<float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/></bsdf>"
               "<bsdf type='twosided'><ref id='gold'/></bsdf>"
               "<bsdf type='twosided'><bsdf type='diffuse'><rgb name='reflectance' value='.3'/></bsdf></bsdf>"),
         &s)
    {
        const volgrad_material *m = s.desc.materials;
        CHECK(s.desc.material_count == 6); /* the diffuse one in the last stands alone too */
        CHECK(m[0].kind == VOLGRAD_MATERIAL_CONDUCTOR && m[0].roughness == 0 && m[0].flags == 0);
        NEAR(m[0].conductor_eta.g, .2), NEAR(m[0].conductor_k.b, 4), NEAR(m[0].reflectance.g, 1);
        NEAR(m[1].roughness, .2), NEAR(m[1].conductor_eta.b, 1.44205), NEAR(m[1].conductor_k.r, 3.983), NEAR(m[1].reflectance.r, .5);
        CHECK(m[2].kind == VOLGRAD_MATERIAL_DIELECTRIC);
        NEAR(m[2].eta, 1.5), NEAR(m[2].roughness, .1);
        CHECK(m[3].kind == VOLGRAD_MATERIAL_CONDUCTOR && m[3].flags == VOLGRAD_MATERIAL_TWO_SIDED);
        NEAR(m[3].roughness, .2);
        CHECK(m[5].kind == VOLGRAD_MATERIAL_DIFFUSE && m[5].flags == VOLGRAD_MATERIAL_TWO_SIDED && m[4].flags == 0);
        NEAR(m[5].reflectance.r, .3);
        scene_free(&s);
    }
}

/* A light's normal, the one of its triangles and the expected one (the transform's inverse transpose of +z) are the same. */
static void check_rectangle_light(const char *operations, double x, double y, double z, int line)
{
    char xml[1024];
    snprintf(xml, sizeof xml, SCENE(SHAPE("rectangle", "<transform name='to_world'>%s</transform>" AREA)), operations);
    scene s;
    if (!load_good(xml, &s, line)) {
        return;
    }
    const volgrad_light *light = &s.desc.lights[1];
    volgrad_vec3 n = cross(light->edge_u, light->edge_v);
    check_near(n.x, x, line), check_near(n.y, y, line), check_near(n.z, z, line);
    for (uint32_t t = 0; t < 2; t++) {
        volgrad_vec3 own = triangle_normal(&s.shapes[0], t);
        check_near(own.x, x, line), check_near(own.y, y, line), check_near(own.z, z, line);
    }
    check(s.shapes[0].first_light == 1 && s.shapes[0].primitives_per_light == 2, "two triangles, one light", line);
    check_near(s.desc.materials[s.shapes[0].material].reflectance.r, 0, line);
    scene_free(&s);
}

static void test_rectangle_lights(void)
{
    check_rectangle_light("", 0, 0, 4, __LINE__);
    check_rectangle_light("<rotate x='1' angle='90'/><scale x='.5' z='.25'/><translate y='2'/>", 0, -.5, 0, __LINE__);
    check_rectangle_light("<scale x='-1'/>", 0, 0, 4, __LINE__);
    check_rectangle_light("<scale z='-1'/>", 0, 0, -4, __LINE__);
    check_rectangle_light("<scale value='-1'/>", 0, 0, -4, __LINE__);
    check_rectangle_light("<scale x='2'/><lookat origin='0,3,0' target='0,0,0' up='0,0,1'/>", 0, -8, 0, __LINE__);
    scene s;
    GOOD(SCENE(SHAPE("rectangle", MAP("<scale x='2' y='3'/><translate x='1' y='1' z='1'/>") AREA)), &s)
    {
        NEAR3(s.desc.lights[1].position, -1, -2, 1);
        NEAR3(s.desc.lights[1].edge_u, 4, 0, 0);
        NEAR3(s.desc.lights[1].edge_v, 0, 6, 0);
        NEAR(s.desc.lights[1].emission.b, 3);
        scene_free(&s);
    }
}

/* All faces of a cube look away from its centre, also mirrored; its lights share the sampling weight by area. */
static void check_cube(const char *scale, double area, int line)
{
    char xml[1024];
    snprintf(xml, sizeof xml, SCENE(SHAPE("cube", "<transform name='to_world'><scale %s/><translate y='3'/></transform>" AREA)),
             scale);
    scene s;
    if (!load_good(xml, &s, line)) {
        return;
    }
    double weight = 0, sum = 0;
    check(s.desc.light_count == 7 && s.shapes[0].triangle_count == 12, "six lights", line);
    for (uint32_t t = 0; t < 12; t++) {
        volgrad_vec3 n = triangle_normal(&s.shapes[0], t), a = corner(&s.shapes[0], t, 0);
        check(n.x * a.x + n.y * (a.y - 3) + n.z * a.z > 0, "the face looks outwards", line);
        const volgrad_light *light = &s.desc.lights[s.shapes[0].first_light + t / 2];
        volgrad_vec3 m = cross(light->edge_u, light->edge_v);
        check(n.x == m.x && n.y == m.y && n.z == m.z, "light and face look the same way", line);
        weight += light->sampling_weight / 2;
        sum += sqrt(n.x * n.x + n.y * n.y + n.z * n.z) / 2;
    }
    check_near(weight, 1, line);
    check_near(sum, area, line);
    check_near(s.desc.lights[1].sampling_weight, 4 * 2 * 3 / area, line); /* the face towards +x: 2y times 2z */
    scene_free(&s);
}

static void test_cube_lights(void)
{
    check_cube("x='1' y='2' z='3'", 88, __LINE__);
    check_cube("x='-1' y='2' z='3'", 88, __LINE__);
    check_cube("x='-1' y='-2' z='-3'", 88, __LINE__);
}

static void test_spot(void)
{
    scene s;
    GOOD(SCENE("<emitter type='spot'><rgb name='intensity' value='3'/><transform name='to_world'><lookat origin='1,2,3' "
               "target='1,0,3' up='0,0,1'/></transform><float name='cutoff_angle' value='60'/></emitter>"),
         &s)
    {
        const volgrad_light *l = &s.desc.lights[1];
        CHECK(l->kind == VOLGRAD_LIGHT_SPOT);
        NEAR3(l->position, 1, 2, 3), NEAR3(l->direction, 0, -1, 0);
        NEAR(l->cos_outer, .5), NEAR(l->cos_inner, .70710678), NEAR(l->emission.r, 3);
        scene_free(&s);
    }
}

static void test_environment_map(void)
{
    static const float image[2 * 3 * 3] = {1, 2, 3, [15] = .5f};
    const volgrad_exr_layout layout = {.width = 3, .height = 2, .window_width = 3, .window_height = 2};
    CHECK(volgrad_exr_write(path_of("sky.exr"), &layout, image, 18, NULL, 0) == VOLGRAD_OK);
    scene s;
    GOOD("<scene version='3.0.0'>" INTEGRATOR SENSOR
         "<emitter type='envmap'><string name='filename' value='sky.exr'/><float name='scale' value='2'/><transform "
         "name='to_world'><rotate x='1' angle='90'/></transform></emitter></scene>",
         &s)
    {
        const volgrad_light *l = s.desc.lights;
        CHECK(l->kind == VOLGRAD_LIGHT_ENVIRONMENT_MAP && l->image_width == 3 && l->image_height == 2);
        CHECK(l->image[1] == 2 && l->image[15] == .5f && l->emission.r == 2);
        NEAR3(l->edge_u, 1, 0, 0), NEAR3(l->edge_v, 0, 0, 1), NEAR3(l->direction, 0, -1, 0);
        scene_free(&s);
    }
    remove(path_of("sky.exr"));
}

static void test_other_lights(void)
{
    scene s;
    GOOD(SCENE("<emitter type='directional'><vector name='direction' x='0' y='-3' z='4'/><rgb name='irradiance' "
               "value='1,2,3'/></emitter>"
               "<emitter type='point'><point name='position' x='1' y='2' z='3'/><float name='intensity' value='5'/><float "
               "name='sampling_weight' value='2'/></emitter>"
               "<emitter type='point'><transform name='to_world'><translate x='4'/></transform><rgb name='intensity' "
               "value='5'/></emitter>" SHAPE("sphere", "<float name='radius' value='2'/>" AREA)),
         &s)
    {
        const volgrad_light *l = s.desc.lights;
        CHECK(l[1].kind == VOLGRAD_LIGHT_DIRECTIONAL && l[2].kind == VOLGRAD_LIGHT_POINT && l[4].kind == VOLGRAD_LIGHT_SPHERE);
        NEAR3(l[1].direction, 0, -.6, .8);
        NEAR3(l[2].position, 1, 2, 3);
        NEAR(l[2].sampling_weight, 2), NEAR(l[2].emission.g, 5);
        NEAR3(l[3].position, 4, 0, 0);
        NEAR(l[4].radius, 2);
        CHECK(s.shapes[0].first_light == 4 && s.shapes[0].primitives_per_light == 1);
        scene_free(&s);
    }
}

static void test_bounds(void)
{
    scene s;
    GOOD(SCENE(SHAPE("sphere", "<point name='center' x='1' y='2' z='3'/><float name='radius' value='2'/>") SHAPE(
             "rectangle", MAP("<scale x='3' y='4'/><translate x='2' z='3'/>") "<bsdf type='null'/>")),
         &s)
    {
        NEAR3(s.desc.bounds_centre, 2, 0, 3); /* the box: [-1, 5] [-4, 4] [1, 5] */
        NEAR(s.desc.bounds_radius, 5 * 1.001); /* to the rectangle's corners; the sphere reaches sqrt(5) + 2 < 5 */
        scene_free(&s);
    }
    GOOD(SCENE(SHAPE("sphere", "<point name='center' x='-7' y='0' z='0'/>") SHAPE("sphere", "")), &s)
    {
        NEAR3(s.desc.bounds_centre, -3.5, 0, 0);
        NEAR(s.desc.bounds_radius, 4.5 * 1.001);
        scene_free(&s);
    }
    GOOD(SCENE(""), &s)
    {
        CHECK(s.desc.bounds_radius == 0); /* no shapes */
        scene_free(&s);
    }
}

#define FLAT_FACES "<boolean name='face_normals' value='true'/>"

static void test_meshes(void)
{
    scene s;
    GOOD(SCENE(SHAPE("obj", "<string name='filename' value='mesh.obj'/>" FLAT_FACES MAP("<scale z='-1'/>") AREA)), &s)
    {
        const shape *mesh = &s.shapes[0];
        CHECK(mesh->triangle_count == 3 && mesh->primitives_per_light == 1 && s.desc.light_count == 4);
        NEAR3(triangle_normal(mesh, 0), 0, 0, 1); /* as the corners go round after the map, also a mirroring one */
        volgrad_vec3 n = cross(s.desc.lights[2].edge_u, s.desc.lights[2].edge_v);
        NEAR3(n, 0, 0, 3);
        NEAR(corner(mesh, 1, 0).z, -1);
        CHECK(s.desc.lights[1].kind == VOLGRAD_LIGHT_TRIANGLE);
        NEAR(s.desc.lights[1].sampling_weight, .5 / 3.5);
        scene_free(&s);
    }
    GOOD(SCENE(SHAPE("ply", "<string name='filename' value='mesh.ply'/>" FLAT_FACES)), &s)
    {
        CHECK(s.shapes[0].triangle_count == 1 && s.shapes[0].vertex_count == 3);
        NEAR3(triangle_normal(&s.shapes[0], 0), 0, 0, 1);
        scene_free(&s);
    }
}

static void check_map(const volgrad_medium *m, const double *expected, int line)
{
    for (int i = 0; i < 12; i++) {
        check_near(m->local_to_world[i], expected[i], line);
    }
}

static void test_grids(void)
{
    scene s;
    static const double plain[12] = {2, 0, 0, 1, 0, 3, 0, 0, 0, 0, 4, 0};
    static const double boxed[12] = {4, 0, 0, -2, 0, 4, 0, -2, 0, 0, 8, -3};
    GOOD(SCENE(GRID("good.vol", MAP("<scale x='2' y='3' z='4'/><translate x='1'/>"))), &s)
    {
        const volgrad_medium *m = &s.desc.media[0];
        CHECK(m->kind == VOLGRAD_MEDIUM_GRID && m->nx == 2 && m->ny == 2 && m->nz == 2);
        CHECK(m->density[1] == 1 && m->density[7] == 7);
        NEAR(m->sigma_t.g, 1);
        check_map(m, plain, __LINE__);
        CHECK(messages[0] == '\0');
        scene_free(&s);
    }
    GOOD(SCENE(GRID("good.vol", "<boolean name='use_grid_bbox' value='true'/>" MAP("<scale x='2'/>"))), &s)
    {
        check_map(&s.desc.media[0], boxed, __LINE__);
        scene_free(&s);
    }
    GOOD(SCENE(GRID("good.vol", MAP("<rotate y='1' angle='90'/>"))), &s)
    {
        CHECK(messages[0] == '\0');
        scene_free(&s);
    }
    GOOD(SCENE(GRID("good.vol", MAP("<rotate y='1' angle='30'/>"))), &s)
    {
        CHECK(strstr(messages, ":5:37: warning: this grid is not axis-aligned") != NULL);
        scene_free(&s);
    }
}

/* --- errors ---------------------------------------------------------------------------------------------------------------- */

typedef struct {
    const char *xml;
    int line, column;
    const char *message; /* part of it */
} bad_scene;

/* At the start of line 5, or further right. */
#define BAD(body, column, message) {SCENE(body), 5, column, message}
#define BAD_SENSOR(sensor, column, message) {WITH_SENSOR(sensor), 5, column, message}
#define MESH(type, file) SHAPE(type, "<string name='filename' value='" file "'/>" FLAT_FACES)
#define FOV "<float name='fov' value='9'/>"

static const bad_scene BAD_FILES[] = {
    {"", 1, 1, "no element found"},
    {"<scene version='3.0.0'>\n  <shape></scene>", 2, 12, "mismatched tag"},
    {"<mesh/>", 1, 1, "must be <scene"},
    {"<scene version='2.1.0'/>", 1, 1, "version is \"2.1.0\""},
    {"<scene/>", 1, 1, "version is \"\""},
    {"<scene version='3.0.0'>\n" SENSOR SKY "</scene>", 1, 1, "has no integrator"},
    {"<scene version='3.0.0'>\n" INTEGRATOR SKY "</scene>", 1, 1, "has no sensor"},
    {"<scene version='3.0.0'>\n" INTEGRATOR SENSOR "</scene>", 1, 1, "nothing in this scene emits light"},
    BAD("stray", 1, "text between elements"),
    BAD("<default name='spp' value='4'/>", 1, "<default name=\"spp\"> is not supported in this <scene>"),
    BAD("<include filename='x.xml'/>", 1, "<include> is not supported"),
    BAD(INTEGRATOR, 1, "a second <integrator>"),
    BAD(SHAPE("sphere", "<float name='radious' value='1'/>"), 22, "<float name=\"radious\"> is not supported in this <shape>"),
    BAD(SHAPE("sphere", "<float name='radius' value='1'/><float name='radius' value='1'/>"), 54, "given twice"),
    BAD("<shape type='sphere' color='red'/>", 1, "attribute color=\"red\""),
    BAD("<shape/>", 1, "<shape> has no type"),
    BAD("<bsdf type='diffuse' id='a'/><bsdf type='null' id='a'/>", 30, "the id \"a\" is taken since line 5"),
    BAD(SHAPE("sphere", "<ref id='a'/>"), 22, "nothing has the id \"a\""),
    BAD(SHAPE("sphere", "<ref id='a'/>") "<bsdf type='null' id='a'/>", 22, "\"a\" is defined later"),
    BAD(SHAPE("sphere", "<ref/>"), 22, "<ref> has no id"),
    BAD("<shape type='cube' id='a'/>" SHAPE("sphere", "<ref id='a'/>"), 49, "this one is a <shape>"),
};

static const bad_scene BAD_VALUES[] = {
    BAD(SHAPE("sphere", "<float name='radius' value='1x'/>"), 22, "radius is \"1x\"; it must be one number"),
    BAD(SHAPE("sphere", "<float name='radius' value='nan'/>"), 22, "radius is \"nan\""),
    BAD(SHAPE("sphere", "<float name='radius' value='0x1'/>"), 22, "radius is \"0x1\""),
    BAD(SHAPE("sphere", "<float name='radius' value='1e999'/>"), 22, "radius is \"1e999\""),
    BAD(SHAPE("sphere", "<float name='radius' value='-1'/>"), 22, "greater than 0"),
    BAD(SHAPE("sphere", "<float name='radius'/>"), 22, "lacks its value"),
    BAD(SHAPE("sphere", "<string name='radius' value='1'/>"), 22, "radius is given as <string>; write <float"),
    BAD(SHAPE("sphere", "<point name='center' x='1' z='1'/>"), 22, "<point> lacks its y"),
    BAD(SHAPE("sphere", "<vector name='center' x='1' y='1' z='1'/>"), 22, "write <point"),
    BAD("<bsdf type='diffuse'><rgb name='reflectance' value='.1, .2'/></bsdf>", 22, "three linear numbers"),
    BAD("<bsdf type='diffuse'><rgb name='reflectance' value='#ff0000'/></bsdf>", 22, "three linear numbers"),
    BAD("<bsdf type='diffuse'><rgb name='reflectance' value='1, 2, 0'/></bsdf>", 22, "between 0 and 1"),
    BAD("<bsdf type='diffuse'><spectrum name='reflectance' value='1'/></bsdf>", 22,
        "<spectrum name=\"reflectance\"> is not supported"),
    BAD("<bsdf type='plastic'/>", 1, "bsdf \"plastic\" is not supported; write diffuse"),
    BAD("<bsdf type='twosided'/>", 1, "twosided lacks its bsdf"),
    BAD("<bsdf type='twosided'><bsdf type='null'/></bsdf>", 23, "one bsdf that is not null"),
    BAD("<bsdf type='twosided'><bsdf type='dielectric'/></bsdf>", 1, "has two sides already"),
    BAD("<bsdf type='twosided'><bsdf type='diffuse'/><bsdf type='diffuse'/></bsdf>", 45, "a second bsdf in twosided"),
    BAD("<bsdf type='roughconductor'><string name='material' value='Au'/></bsdf>", 1, "default distribution is beckmann"),
    BAD("<bsdf type='roughconductor'><string name='material' value='Au'/><string name='distribution' value='beckmann'/></bsdf>", 65,
        "write ggx"),
    BAD("<bsdf type='roughdielectric'><string name='distribution' value='ggx'/><float name='alpha' value='0'/></bsdf>", 71,
        "1e-4 or greater"),
    BAD("<bsdf type='roughdielectric'><string name='distribution' value='ggx'/><float name='int_ior' value='1'/><float "
        "name='ext_ior' value='1'/></bsdf>", 1, "are the same"),
    BAD("<bsdf type='conductor'><rgb name='eta' value='1'/></bsdf>", 1, "lacks its k"),
    BAD("<bsdf type='conductor'/>", 1, "<bsdf> lacks its material"),
    BAD("<bsdf type='conductor'><string name='material' value='Xx'/></bsdf>", 24, "\"Xx\" is no metal"),
    BAD("<bsdf type='dielectric'><string name='int_ior' value='jelly'/></bsdf>", 25, "no refractive index"),
    BAD("<bsdf type='dielectric'><float name='int_ior' value='0'/></bsdf>", 25, "greater than 0"),
    BAD("<emitter type='projector'/>", 1, "emitter \"projector\" is not supported"),
    BAD("<emitter type='envmap'><string name='filename' value='no.exr'/></emitter>", 24, "no.exr"),
    BAD("<emitter type='envmap'/>", 1, "lacks its filename"),
    BAD("<emitter type='spot'><rgb name='intensity' value='1'/><float name='beam_width' value='30'/></emitter>", 55,
        "more than the cutoff_angle, 20"),
    BAD("<emitter type='spot'><rgb name='intensity' value='1'/>" MAP("<scale value='2'/>") "</emitter>", 55, "scales or shears"),
    BAD("<emitter type='area'/>", 1, "belongs into a <shape>"),
    BAD(SKY, 1, "a second constant emitter"),
    BAD("<emitter type='point'><rgb name='intensity' value='1'/></emitter>", 1, "lacks its position"),
    BAD("<emitter type='point'><rgb name='intensity' value='-1'/><point name='position' value='0'/></emitter>", 23,
        "0 or greater"),
    BAD("<emitter type='point'><point name='position' value='0'/></emitter>", 1, "lacks its intensity"),
    BAD("<emitter type='directional'><rgb name='irradiance' value='1'/><transform name='to_world'/></emitter>", 63,
        "write <vector name=\"direction\""),
    BAD("<emitter type='directional'><rgb name='irradiance' value='1'/><vector name='direction' value='0'/></emitter>", 63,
        "has no length"),
};

static const bad_scene BAD_SHAPES[] = {
    BAD(SHAPE("disk", ""), 1, "shape \"disk\" is not supported"),
    BAD(SHAPE("sphere", MAP("<spin/>")), 49, "<spin> is no transform"),
    BAD(SHAPE("sphere", MAP("<scale x='2'/>")), 22, "stretches or mirrors this sphere"),
    BAD(SHAPE("sphere", MAP("<scale value='-1'/>")), 22, "stretches or mirrors this sphere"),
    BAD(SHAPE("cube", MAP("<scale y='0'/>")), 20, "has no inverse"),
    BAD(SHAPE("cube", MAP("<scale value='1, 2'/>")), 47, "three numbers, or one"),
    BAD(SHAPE("cube", MAP("<rotate y='1'/>")), 47, "needs angle"),
    BAD(SHAPE("cube", MAP("<rotate y='2' angle='9'/>")), 47, "has length 2"),
    BAD(SHAPE("cube", MAP("<lookat origin='0,0,0' target='0,0,1'/>")), 47, "needs up="),
    BAD(SHAPE("cube", MAP("<lookat origin='0,0,0' target='0,1,0' up='0,1,0'/>")), 47, "<lookat> is undefined"),
    BAD(SHAPE("cube", MAP("<matrix value='1 2 3'/>")), 47, "16 (or 9) numbers"),
    BAD(SHAPE("cube", MAP("<matrix value='1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1'/>")), 47, "last row"),
    BAD(SHAPE("cube", "<bsdf type='null'/><bsdf type='null'/>"), 39, "a second bsdf"),
    BAD(SHAPE("cube", "<medium type='homogeneous'/>"), 20, "write name=\"interior\""),
    BAD(SHAPE("cube", "<medium type='homogeneous' name='interior'/><medium type='homogeneous' name='interior'/>"), 64,
        "a second interior medium"),
    BAD(SHAPE("cube", MAP("<scale x='-1'/>") "<medium type='homogeneous' name='interior'/>"), 1, "mirrors this shape"),
    BAD(SHAPE("cube", AREA AREA), 89, "a second emitter"),
    BAD(SHAPE("cube", SKY), 20, "cannot be part of a shape"),
    BAD(SHAPE("cube", "<bsdf type='null'/>" AREA), 1, "a null bsdf cannot emit"),
    BAD(SHAPE("obj", "<string name='filename' value='mesh.obj'/>"), 1, "write <boolean name=\"face_normals\" value=\"true\"/>"),
    BAD(SHAPE("obj", FLAT_FACES), 1, "lacks its filename"),
    BAD(SHAPE("obj", "<boolean name='face_normals' value='yes'/>"), 19, "must be true or false"),
    BAD(MESH("obj", "absent.obj"), 19, "cannot open"),
    BAD(MESH("ply", "broken.ply"), 19, "cannot be read as ply"),
    BAD(MESH("ply", "wrong.ply"), 19, "cannot be read as ply"),
    BAD(MESH("ply", "mesh.obj"), 19, "cannot be read as ply"),
    BAD(MESH("ply", "empty.ply"), 19, "is empty"),
};

static const bad_scene BAD_SENSORS[] = {
    BAD_SENSOR("<sensor type='orthographic'>" FOV FILM "</sensor>", 1, "sensor \"orthographic\" is not supported"),
    BAD_SENSOR("<sensor type='thinlens'>" FOV "<float name='focus_distance' value='1'/>" FILM "</sensor>", 1,
               "lacks its aperture_radius"),
    BAD_SENSOR("<sensor type='perspective'>" FILM "</sensor>", 1, "lacks its fov"),
    BAD_SENSOR("<sensor type='perspective'><float name='fov' value='180'/>" FILM "</sensor>", 28, "between 0 and 180"),
    BAD_SENSOR("<sensor type='perspective'>" FOV "<string name='fov_axis' value='z'/>" FILM "</sensor>", 57,
               "write x, y, smaller"),
    BAD_SENSOR("<sensor type='perspective'>" FOV "<float name='far_clip' value='100'/>" FILM "</sensor>", 57, "far_clip is 100"),
    BAD_SENSOR("<sensor type='perspective'>" FOV "<float name='near_clip' value='0'/>" FILM "</sensor>", 57, "greater than 0"),
    BAD_SENSOR("<sensor type='perspective'>" FOV MAP("<scale value='2'/>") FILM "</sensor>", 57, "scales or shears the camera"),
    BAD_SENSOR("<sensor type='perspective'>" FOV "</sensor>", 1, "has no film"),
    BAD_SENSOR("<sensor type='perspective'>" FOV "<film type='hdrfilm'/></sensor>", 57, "write <rfilter type=\"box\"/>"),
    BAD_SENSOR("<sensor type='perspective'>" FOV "<film type='hdrfilm'><rfilter type='tent'/></film></sensor>", 78,
               "write <rfilter type=\"box\"/>"),
    BAD_SENSOR("<sensor type='perspective'>" FOV
               "<film type='hdrfilm'><integer name='width' value='0'/><rfilter type='box'/></film></sensor>",
               78, "whole number from 1 to"),
    BAD_SENSOR("<sensor type='perspective'>" FOV
               "<film type='hdrfilm'><string name='pixel_format' value='rgba'/><rfilter type='box'/></film></sensor>",
               78, "only \"rgb\" is supported"),
    BAD_SENSOR("<sensor type='perspective'>" FOV "<sampler type='halton'/>" FILM "</sensor>", 57, "sampler \"halton\""),
    BAD_SENSOR("<bsdf type='null' id='n'/><sensor type='perspective'>" FOV "<ref id='n'/>" FILM "</sensor>", 83,
               "this one is a <bsdf>"),
    {"<scene version='3.0.0'>\n<integrator type='path'/>" SENSOR SKY "</scene>", 2, 1, "integrator \"path\""},
    {"<scene version='3.0.0'>\n<integrator type='volpath'><integer name='max_depth' value='0'/></integrator>" SENSOR SKY
     "</scene>",
     2, 28, "max_depth is 0"},
    {"<scene version='3.0.0'>\n<integrator type='volpath'><integer name='rr_depth' value='0'/></integrator>" SENSOR SKY
     "</scene>",
     2, 28, "rr_depth is \"0\""},
};

#define FILE_COLUMN 78 /* of the file name in GRID and NVDB */

static const bad_scene BAD_MEDIA[] = {
    BAD("<medium type='principled'/>", 1, "medium \"principled\" is not supported"),
    BAD("<medium type='homogeneous'><rgb name='sigma_t' value='2, 1, 1'/></medium>", 28, "Mitsuba's rule"),
    BAD("<medium type='homogeneous'><float name='sigma_t' value='-2'/></medium>", 28, "0 or greater"),
    BAD("<medium type='homogeneous'><float name='albedo' value='1.5'/></medium>", 28, "between 0 and 1"),
    BAD("<medium type='homogeneous'><volume type='gridvolume' name='albedo'/></medium>", 28, "an albedo that varies in space"),
    BAD("<medium type='homogeneous'><phase type='rayleigh'/></medium>", 28, "phase function \"rayleigh\""),
    BAD("<medium type='homogeneous'><phase type='hg'><float name='g' value='1'/></phase></medium>", 45, "between -1 and 1"),
    BAD("<medium type='homogeneous'><float name='sigma_t' value='1e38'/><float name='scale' value='1e38'/></medium>", 1,
        "too large"),
    BAD("<medium type='heterogeneous'/>", 1, "needs <volume type=\"gridvolume\""),
    BAD("<medium type='heterogeneous'><float name='sigma_t' value='1'/></medium>", 30, "needs <volume type=\"gridvolume\""),
    BAD("<medium type='heterogeneous'><volume type='constvolume' name='sigma_t'/></medium>", 30, "volume \"constvolume\""),
    BAD("<medium type='heterogeneous'><volume type='gridvolume' name='sigma_t'/></medium>", 30, "lacks its filename"),
    BAD("<medium type='heterogeneous'><volume type='nvdbvolume' name='sigma_t'/></medium>", 30, "lacks its filename"),
    BAD(NVDB("absent.nvdb", ""), FILE_COLUMN, "cannot open"),
    BAD(NVDB("good.vol", ""), FILE_COLUMN, "is no .nvdb file"),
    BAD(NVDB("good.vol", "<boolean name='use_grid_bbox' value='true'/>"), 120, "use_grid_bbox"),
    BAD(GRID("good.vol", "<string name='wrap_mode' value='repeat'/>"), 120, "only \"clamp\""),
    BAD(GRID("good.vol", "<string name='filter_type' value='nearest'/>"), 120, "only \"trilinear\""),
    BAD(GRID("flatbox.vol", "<boolean name='use_grid_bbox' value='true'/>"), 37, "the box in the .vol file is empty"),
    BAD(GRID("absent.vol", ""), FILE_COLUMN, "cannot open"),
    BAD(GRID("header.vol", ""), FILE_COLUMN, "shorter than the 48 bytes"),
    BAD(GRID("short.vol", ""), FILE_COLUMN, "has 28 bytes of values; its 2 x 2 x 2 samples take 32"),
    BAD(GRID("magic.vol", ""), FILE_COLUMN, "does not begin with VOL"),
    BAD(GRID("version.vol", ""), FILE_COLUMN, "version 2; version 3 is needed"),
    BAD(GRID("encoding.vol", ""), FILE_COLUMN, "encoding 2"),
    BAD(GRID("channels.vol", ""), FILE_COLUMN, "has 3 channels; a density has 1"),
    BAD(GRID("side.vol", ""), FILE_COLUMN, "a side of -2 samples"),
    BAD(GRID("nan.vol", ""), FILE_COLUMN, "sample (1, 0, 1) is"),
    BAD(GRID("negative.vol", ""), FILE_COLUMN, "sample (0, 1, 1) is -1"),
};

/* Loading fails, and some line of the messages is `file:line:column: ...` with the expected text. */
static void check_bad(const bad_scene *bad)
{
    char prefix[300];
    scene s;
    if (load(bad->xml, &s)) {
        check(0, bad->message, __LINE__);
        scene_free(&s);
        return;
    }
    snprintf(prefix, sizeof prefix, "%s:%d:%d: ", path_of("scene.xml"), bad->line, bad->column);
    int found = 0;
    for (char *line = strtok(messages, "\n"); line; line = strtok(NULL, "\n")) {
        found |= strncmp(line, prefix, strlen(prefix)) == 0 && strstr(line, bad->message) != NULL;
        if (getenv("READER_TEST_VERBOSE")) {
            printf("%s\n", line);
        }
    }
    check(found, bad->message, bad->line);
    if (!found) {
        printf("    expected at %s\n", prefix);
    }
}

static void check_all_bad(const bad_scene *bad, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        check_bad(&bad[i]);
    }
}

#define CHECK_ALL_BAD(table) check_all_bad(table, sizeof table / sizeof *table)

static void test_several_errors_at_once(void)
{
    scene s;
    CHECK(!load(SCENE("<bsdf type='x'/>\n<medium type='y'/>"), &s));
    CHECK(strstr(messages, ":5:1: bsdf \"x\"") && strstr(messages, ":6:1: medium \"y\""));
}

static void test_missing_file(void)
{
    scene s;
    CHECK(!load_path("no/such/scene.xml", &s));
    CHECK(strncmp(messages, "no/such/scene.xml:1:1: cannot open", 34) == 0);
}

/* Scene files given on the command line must load. */
static void test_files(int count, char **paths)
{
    for (int i = 0; i < count; i++) {
        scene s;
        int ok = load_path(paths[i], &s);
        check(ok, paths[i], __LINE__);
        if (ok) {
            scene_free(&s);
        } else {
            printf("%s", messages);
        }
    }
}

int main(int argc, char **argv)
{
    if (!mkdtemp(folder)) {
        return 2;
    }
    write_data();
    test_defaults();
    test_camera();
    test_field_of_view();
    test_transform_order();
    test_media_sides();
    test_sensor_medium();
    test_bsdfs();
    test_rough_bsdfs();
    test_rectangle_lights();
    test_cube_lights();
    test_spot();
    test_environment_map();
    test_bounds();
    test_other_lights();
    test_meshes();
    test_grids();
    CHECK_ALL_BAD(BAD_FILES);
    CHECK_ALL_BAD(BAD_VALUES);
    CHECK_ALL_BAD(BAD_SHAPES);
    CHECK_ALL_BAD(BAD_SENSORS);
    CHECK_ALL_BAD(BAD_MEDIA);
    test_several_errors_at_once();
    test_missing_file();
    test_files(argc - 1, argv + 1);
    remove_data();
    printf("%d passed, %d failed\n", passed, failed);
    return failed != 0;
}
