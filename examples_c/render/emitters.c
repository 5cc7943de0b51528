/* Emitters: area lights belong to shapes, the others stand alone. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reader.h"

static const double DEFAULT_WEIGHT = 1;

static float read_weight(xml_node *node, param_range range)
{
    return (float)param_float(node, "sampling_weight", &DEFAULT_WEIGHT, range);
}

area_emission reader_area_emitter(xml_node *node)
{
    area_emission emission = {{0, 0, 0}, 1};
    const char *type = param_type(node);
    if (strcmp(type, "area") != 0) {
        xml_error(node, "emitter \"%s\" cannot be part of a shape; write area, or move it into <scene>", type);
        return emission;
    }
    emission.radiance = param_color(node, "radiance", PARAM_REQUIRED, PARAM_NOT_NEGATIVE);
    emission.sampling_weight = read_weight(node, PARAM_NOT_NEGATIVE);
    return emission;
}

static int is_environment(const volgrad_light *light)
{
    return light->kind == VOLGRAD_LIGHT_ENVIRONMENT || light->kind == VOLGRAD_LIGHT_ENVIRONMENT_MAP;
}

static void check_only_environment(const reader *r, const xml_node *node)
{
    for (uint32_t i = 0; i < r->scene->desc.light_count; i++) {
        if (is_environment(&r->scene->desc.lights[i])) {
            xml_error(node, "a second constant emitter or envmap; there can be only one environment");
        }
    }
}

static volgrad_light read_constant(reader *r, xml_node *node)
{
    volgrad_light light = {.kind = VOLGRAD_LIGHT_ENVIRONMENT};
    light.emission = param_color(node, "radiance", PARAM_REQUIRED, PARAM_NOT_NEGATIVE);
    light.sampling_weight = read_weight(node, PARAM_NOT_NEGATIVE);
    check_only_environment(r, node);
    return light;
}

/* To be freed; NULL on an error. */
static float *read_image(const xml_node *node, const char *path, volgrad_exr_layout *layout)
{
    volgrad_status status = volgrad_exr_read_layout(path, layout);
    if (status != VOLGRAD_OK) {
        return xml_error(node, "%s: %s", path, volgrad_status_message(status)), NULL;
    }
    if (layout->window_height < 2) {
        return xml_error(node, "%s has one row; the first is the up pole and the last the down pole", path), NULL;
    }
    size_t count = 3 * (size_t)layout->window_width * layout->window_height;
    float *image = malloc(count * sizeof *image);
    if (!image) {
        return xml_out_of_memory(node), NULL;
    }
    status = volgrad_exr_read(path, image, count);
    if (status != VOLGRAD_OK) {
        xml_error(node, "%s: %s", path, volgrad_status_message(status));
    }
    for (size_t i = 0; status == VOLGRAD_OK && i < count; i++) {
        if (!(image[i] >= 0 && isfinite(image[i]))) {
            xml_error(node, "%s: pixel (%zu, %zu) is %g; radiance is finite and not negative", path,
                      i / 3 % layout->window_width, i / 3 / layout->window_width, (double)image[i]);
            break;
        }
    }
    return image;
}

static volgrad_light read_environment_map(reader *r, xml_node *node)
{
    volgrad_light light = {.kind = VOLGRAD_LIGHT_ENVIRONMENT_MAP};
    static const double unscaled = 1;
    float scale = (float)param_float(node, "scale", &unscaled, PARAM_NOT_NEGATIVE);
    light.emission = (volgrad_rgb){scale, scale, scale};
    light.sampling_weight = read_weight(node, PARAM_NOT_NEGATIVE);
    transform to_world = param_transform(node, "to_world");
    if (!transform_is_rigid(&to_world)) {
        xml_error(param_find(node, "to_world"), "to_world scales or shears the sky; write rotations only");
    }
    light.edge_u = vec3d_round(transform_axis(&to_world, 0));
    light.edge_v = vec3d_round(transform_axis(&to_world, 1));
    light.direction = vec3d_round(transform_axis(&to_world, 2));
    check_only_environment(r, node);
    const char *filename = param_string(node, "filename", 1);
    char *path = filename ? reader_path(param_find(node, "filename"), filename) : NULL;
    if (path) {
        volgrad_exr_layout layout = {0};
        light.image = read_image(param_find(node, "filename"), path, &layout);
        light.image_width = layout.window_width, light.image_height = layout.window_height;
    }
    free(path);
    return light;
}

static volgrad_light read_directional(xml_node *node)
{
    volgrad_light light = {.kind = VOLGRAD_LIGHT_DIRECTIONAL};
    vec3d direction;
    xml_node *to_world = param_find(node, "to_world");
    light.emission = param_color(node, "irradiance", PARAM_REQUIRED, PARAM_NOT_NEGATIVE);
    light.sampling_weight = read_weight(node, PARAM_POSITIVE);
    if (to_world) {
        to_world->used = 1;
        xml_error(to_world, "to_world is not supported here; write <vector name=\"direction\" .../>, the way the light travels");
    } else if (param_vec3d(node, "vector", "direction", 1, &direction)) {
        if (vec3d_length(direction) > 0) {
            light.direction = vec3d_round(vec3d_unit(direction));
        } else {
            xml_error(param_find(node, "direction"), "direction has no length; write the way the light travels");
        }
    }
    return light;
}

static volgrad_light read_point(xml_node *node)
{
    volgrad_light light = {.kind = VOLGRAD_LIGHT_POINT};
    vec3d position;
    light.emission = param_color(node, "intensity", PARAM_REQUIRED, PARAM_NOT_NEGATIVE);
    light.sampling_weight = read_weight(node, PARAM_POSITIVE);
    transform to_world = param_transform(node, "to_world");
    int has_map = param_find(node, "to_world") != NULL;
    if (param_vec3d(node, "point", "position", !has_map, &position)) {
        if (has_map) {
            xml_error(node, "position and to_world exclude each other; write one of them");
        }
        light.position = vec3d_round(position);
    } else {
        light.position = vec3d_round(transform_translation(&to_world));
    }
    return light;
}

static const double RADIANS_PER_DEGREE = 3.14159265358979323846 / 180.0;

static volgrad_light read_spot(xml_node *node)
{
    static const param_range angle = {1e-3, 180, "greater than 0 and at most 180 degrees"};
    static const double default_cutoff = 20;
    volgrad_light light = {.kind = VOLGRAD_LIGHT_SPOT};
    light.emission = param_color(node, "intensity", PARAM_REQUIRED, PARAM_NOT_NEGATIVE);
    light.sampling_weight = read_weight(node, PARAM_POSITIVE);
    double cutoff = param_float(node, "cutoff_angle", &default_cutoff, angle), default_beam = .75 * cutoff;
    double beam = param_float(node, "beam_width", &default_beam, angle);
    if (beam > cutoff) {
        xml_error(param_find(node, "beam_width"), "beam_width is %g, more than the cutoff_angle, %g", beam, cutoff);
        beam = cutoff;
    }
    light.cos_inner = (float)cos(beam * RADIANS_PER_DEGREE);
    light.cos_outer = (float)cos(cutoff * RADIANS_PER_DEGREE);
    transform to_world = param_transform(node, "to_world");
    if (!transform_is_rigid(&to_world)) {
        xml_error(param_find(node, "to_world"), "to_world scales or shears the spot light; write rotations and translations only");
    }
    light.position = vec3d_round(transform_translation(&to_world));
    light.direction = vec3d_round(transform_axis(&to_world, 2));
    return light;
}

void reader_emitter(reader *r, xml_node *node)
{
    const char *type = param_type(node);
    volgrad_light light = {0};
    if (strcmp(type, "constant") == 0) {
        light = read_constant(r, node);
    } else if (strcmp(type, "directional") == 0) {
        light = read_directional(node);
    } else if (strcmp(type, "point") == 0) {
        light = read_point(node);
    } else if (strcmp(type, "spot") == 0) {
        light = read_spot(node);
    } else if (strcmp(type, "envmap") == 0) {
        light = read_environment_map(r, node);
    } else if (strcmp(type, "area") == 0) {
        xml_error(node, "an area emitter belongs into a <shape>");
    } else {
        xml_error(node, "emitter \"%s\" is not supported; write area, constant, directional, envmap, point or spot", type);
    }
    reader_add_light(r, node, &light);
}
