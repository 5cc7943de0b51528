/* Emitters: area lights belong to shapes, the others stand alone. */
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

static volgrad_light read_constant(reader *r, xml_node *node)
{
    volgrad_light light = {.kind = VOLGRAD_LIGHT_ENVIRONMENT};
    light.emission = param_color(node, "radiance", PARAM_REQUIRED, PARAM_NOT_NEGATIVE);
    light.sampling_weight = read_weight(node, PARAM_NOT_NEGATIVE);
    for (uint32_t i = 0; i < r->scene->desc.light_count; i++) {
        if (r->scene->desc.lights[i].kind == light.kind) {
            xml_error(node, "a second constant emitter; there can be only one environment");
        }
    }
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
    } else if (strcmp(type, "area") == 0) {
        xml_error(node, "an area emitter belongs into a <shape>");
    } else {
        xml_error(node, "emitter \"%s\" is not supported; write area, constant, directional or point", type);
    }
    reader_add_light(r, node, &light);
}
