/* The camera with its film and sampler, and the integrator. */
#include <limits.h>
#include <math.h>
#include <string.h>

#include "reader.h"

/* Mitsuba's defaults. */
static const double DEFAULT_NEAR_CLIP = .01, DEFAULT_FAR_CLIP = 1e4;
static const long DEFAULT_WIDTH = 768, DEFAULT_HEIGHT = 576, DEFAULT_SAMPLE_COUNT = 4, DEFAULT_MAX_DEPTH = -1,
                  DEFAULT_RR_DEPTH = 5;
#define MAX_SIDE 65536

static const double RADIANS_PER_DEGREE = 3.14159265358979323846 / 180.0;

static void read_filter(xml_node *film)
{
    xml_node *filter = param_object(film, "rfilter");
    const char *type = filter ? param_type(filter) : NULL;
    if (type && strcmp(type, "box") == 0) {
        return;
    }
    if (type) {
        xml_error(filter, "reconstruction filter \"%s\" is not supported; write <rfilter type=\"box\"/>", type);
    } else {
        xml_error(film,
                  "the film has no reconstruction filter, and Mitsuba's default is gaussian; write <rfilter type=\"box\"/>");
    }
}

static void read_component_format(xml_node *film)
{
    const char *format = param_string(film, "component_format", 0);
    if (!format || strcmp(format, "float32") == 0) {
        return;
    }
    xml_node *node = param_find(film, "component_format");
    if (strcmp(format, "float16") == 0) {
        xml_warning(node, "images are written as float32");
    } else {
        xml_error(node, "component_format is \"%s\"; write float32", format);
    }
}

static void read_film(xml_node *sensor, volgrad_camera *camera)
{
    camera->width = (uint32_t)DEFAULT_WIDTH;
    camera->height = (uint32_t)DEFAULT_HEIGHT;
    xml_node *film = param_object(sensor, "film");
    if (!film) {
        xml_error(sensor, "the sensor has no film; add <film type=\"hdrfilm\"> with width, height and <rfilter type=\"box\"/>");
        return;
    }
    const char *type = param_type(film);
    if (strcmp(type, "hdrfilm") != 0) {
        xml_error(film, "film \"%s\" is not supported; write hdrfilm", type);
    }
    camera->width = (uint32_t)param_integer(film, "width", &DEFAULT_WIDTH, 1, MAX_SIDE);
    camera->height = (uint32_t)param_integer(film, "height", &DEFAULT_HEIGHT, 1, MAX_SIDE);
    param_only_string(film, "pixel_format", "rgb");
    param_only_string(film, "file_format", "openexr");
    read_component_format(film);
    read_filter(film);
}

static uint32_t read_sampler(xml_node *sensor)
{
    xml_node *sampler = param_object(sensor, "sampler");
    if (!sampler) {
        return (uint32_t)DEFAULT_SAMPLE_COUNT;
    }
    const char *type = param_type(sampler);
    if (strcmp(type, "independent") != 0) {
        xml_error(sampler, "sampler \"%s\" is not supported; write independent", type);
    }
    return (uint32_t)param_integer(sampler, "sample_count", &DEFAULT_SAMPLE_COUNT, 1, INT_MAX);
}

/* Tangent of half the horizontal field of view, from that along `axis`. */
static double half_fov_tangent_x(xml_node *sensor, const char *axis, double half, double aspect)
{
    if (strcmp(axis, "smaller") == 0) {
        axis = aspect > 1 ? "y" : "x";
    } else if (strcmp(axis, "larger") == 0) {
        axis = aspect > 1 ? "x" : "y";
    }
    if (strcmp(axis, "y") == 0) {
        return half * aspect;
    }
    if (strcmp(axis, "diagonal") == 0) {
        return half / sqrt(1 + 1 / (aspect * aspect));
    }
    if (strcmp(axis, "x") != 0) {
        xml_error(param_find(sensor, "fov_axis"), "fov_axis is \"%s\"; write x, y, smaller, larger or diagonal", axis);
    }
    return half;
}

static void read_field_of_view(xml_node *sensor, volgrad_camera *camera)
{
    static const param_range angle = {1e-3, 179.999, "between 0 and 180 degrees (exclusive)"};
    const char *axis = param_string(sensor, "fov_axis", 0);
    double fov = param_float(sensor, "fov", PARAM_REQUIRED, angle), aspect = (double)camera->width / camera->height;
    camera->tan_half_fov_x = (float)half_fov_tangent_x(sensor, axis ? axis : "x", tan(fov / 2 * RADIANS_PER_DEGREE), aspect);
}

static void read_clip_planes(xml_node *sensor, volgrad_camera *camera)
{
    camera->near_clip = (float)param_float(sensor, "near_clip", &DEFAULT_NEAR_CLIP, PARAM_POSITIVE);
    double far_clip = param_float(sensor, "far_clip", &DEFAULT_FAR_CLIP, PARAM_POSITIVE);
    if (far_clip < DEFAULT_FAR_CLIP) {
        xml_error(param_find(sensor, "far_clip"),
                  "far_clip is %g, but nothing is clipped far away here; leave it away, or write 10000 or more", far_clip);
    }
}

/* Local +z is the view, +y is up and +x points left in the image (without a mirroring scale). */
static void read_pose(xml_node *sensor, volgrad_camera *camera)
{
    transform to_world = param_transform(sensor, "to_world");
    if (!transform_is_rigid(&to_world)) {
        xml_error(param_find(sensor, "to_world"),
                  "to_world scales or shears the camera; write rotations and translations (lookat) only");
        return;
    }
    vec3d forward = vec3d_unit(transform_axis(&to_world, 2)), up = transform_axis(&to_world, 1);
    up = vec3d_unit(vec3d_along(up, -vec3d_dot(up, forward), forward));
    vec3d right = vec3d_cross(forward, up);
    if (transform_determinant(&to_world) < 0) {
        right = vec3d_scaled(right, -1);
    }
    camera->position = vec3d_round(transform_translation(&to_world));
    camera->forward = vec3d_round(forward);
    camera->up = vec3d_round(up);
    camera->right = vec3d_round(right);
}

static void read_lens(xml_node *sensor, volgrad_camera *camera)
{
    camera->kind = VOLGRAD_CAMERA_THIN_LENS;
    camera->lens_radius = (float)param_float(sensor, "aperture_radius", PARAM_REQUIRED, PARAM_POSITIVE);
    camera->focal_distance = (float)param_float(sensor, "focus_distance", PARAM_REQUIRED, PARAM_POSITIVE);
}

static uint32_t sensor_medium(reader *r, xml_node *child)
{
    xml_node *definition = reader_resolve(r, child);
    if (!definition) {
        return VOLGRAD_NONE;
    }
    if (definition == child) {
        reader_medium(r, child);
    } else if (strcmp(definition->name, "medium") != 0) {
        xml_error(child, "a <ref> in a sensor may name a medium; this one is a <%s>", definition->name);
    }
    return definition->object;
}

static void read_medium_around(reader *r, xml_node *sensor, volgrad_camera *camera)
{
    int found = 0;
    camera->medium = VOLGRAD_NONE;
    for (xml_node *child = sensor->first_child; child; child = child->next) {
        if (strcmp(child->name, "ref") != 0 && strcmp(child->name, "medium") != 0) {
            continue;
        }
        camera->medium = sensor_medium(r, child);
        if (found++) {
            xml_error(child, "a second medium around the sensor; there can be only one");
        }
    }
}

void reader_sensor(reader *r, xml_node *node)
{
    volgrad_camera *camera = &r->scene->desc.camera;
    const char *type = param_type(node);
    *camera = (volgrad_camera){.kind = VOLGRAD_CAMERA_PINHOLE};
    if (strcmp(type, "thinlens") == 0) {
        read_lens(node, camera);
    } else if (strcmp(type, "perspective") != 0) {
        xml_error(node, "sensor \"%s\" is not supported; write perspective or thinlens", type);
    }
    read_film(node, camera);
    camera->crop_x1 = camera->width;
    camera->crop_y1 = camera->height;
    read_field_of_view(node, camera);
    read_clip_planes(node, camera);
    read_pose(node, camera);
    read_medium_around(r, node, camera);
    r->scene->sample_count = read_sampler(node);
}

void reader_integrator(reader *r, xml_node *node)
{
    const char *type = param_type(node);
    if (strcmp(type, "volpath") != 0 && strcmp(type, "volpathmis") != 0) {
        xml_error(node, "integrator \"%s\" is not supported; write volpath", type);
    }
    long depth = param_integer(node, "max_depth", &DEFAULT_MAX_DEPTH, -1, INT_MAX);
    if (depth == 0) {
        xml_error(param_find(node, "max_depth"), "max_depth is 0, a black image; write -1 (no limit) or at least 1");
    }
    r->scene->max_depth = depth > 0 ? (uint32_t)depth : 0;
    r->scene->rr_depth = (uint32_t)param_integer(node, "rr_depth", &DEFAULT_RR_DEPTH, 1, INT_MAX);
    if (param_boolean(node, "hide_emitters", 0)) {
        xml_error(param_find(node, "hide_emitters"), "hide_emitters is not supported; write false");
    }
}
