/* Surface materials. */
#include <stdlib.h>
#include <string.h>

#include "reader.h"

static const volgrad_rgb WHITE = {1, 1, 1};
static const volgrad_rgb DEFAULT_REFLECTANCE = {.5f, .5f, .5f}; /* Mitsuba's */

/* Mitsuba's names of refractive indices, those of everyday scenes. */
static const struct {
    const char *name;
    double ior;
} NAMED_IORS[] = {{"vacuum", 1.0},         {"air", 1.000277},       {"water ice", 1.31}, {"water", 1.333},
                  {"fused quartz", 1.458}, {"acrylic glass", 1.49}, {"bk7", 1.5046},     {"diamond", 2.419}};

static double named_ior(xml_node *object, const char *property)
{
    const char *name = param_string(object, property, 1);
    if (!name) {
        return 1;
    }
    for (size_t i = 0; i < sizeof NAMED_IORS / sizeof *NAMED_IORS; i++) {
        if (strcmp(NAMED_IORS[i].name, name) == 0) {
            return NAMED_IORS[i].ior;
        }
    }
    xml_error(param_find(object, property), "\"%s\" is no refractive index that is known here; write <float name=\"%s\" .../>",
              name, property);
    return 1;
}

static double read_ior(xml_node *object, const char *property, double fallback)
{
    const xml_node *node = param_find(object, property);
    if (node && strcmp(node->name, "string") == 0) {
        return named_ior(object, property);
    }
    return param_float(object, property, &fallback, PARAM_POSITIVE);
}

static volgrad_material read_dielectric(xml_node *node)
{
    double inside = read_ior(node, "int_ior", 1.5046), outside = read_ior(node, "ext_ior", 1.000277);
    double eta = inside / outside;
    if (!(eta >= PARAM_POSITIVE.low && eta <= PARAM_POSITIVE.high)) {
        xml_error(node, "int_ior / ext_ior is %g, which single precision cannot hold", eta);
        eta = 1;
    }
    return (volgrad_material){.kind = VOLGRAD_MATERIAL_DIELECTRIC, .eta = (float)eta};
}

static volgrad_material read_conductor(xml_node *node)
{
    const char *material = param_string(node, "material", 1);
    if (material && strcmp(material, "none") != 0) {
        xml_error(param_find(node, "material"), "conductor \"%s\" is not supported; write \"none\", a perfect mirror", material);
    }
    return (volgrad_material){.kind = VOLGRAD_MATERIAL_MIRROR, .reflectance = WHITE, .eta = 1};
}

static volgrad_material diffuse(volgrad_rgb reflectance)
{
    return (volgrad_material){.kind = VOLGRAD_MATERIAL_DIFFUSE, .reflectance = reflectance, .eta = 1};
}

void reader_bsdf(reader *r, xml_node *node)
{
    const char *type = param_type(node);
    volgrad_material material = {0};
    node->object = VOLGRAD_NONE;
    if (strcmp(type, "null") == 0) {
        return;
    }
    if (strcmp(type, "diffuse") == 0) {
        material = diffuse(param_color(node, "reflectance", &DEFAULT_REFLECTANCE, PARAM_UNIT));
    } else if (strcmp(type, "dielectric") == 0) {
        material = read_dielectric(node);
    } else if (strcmp(type, "conductor") == 0) {
        material = read_conductor(node);
    } else {
        xml_error(node, "bsdf \"%s\" is not supported; write diffuse, dielectric, conductor or null", type);
    }
    node->object = reader_add_material(r, node, &material);
}

uint32_t reader_default_bsdf(reader *r, const xml_node *shape_node, int emits)
{
    uint32_t *shared = emits ? &r->black_material : &r->default_material;
    volgrad_material material = diffuse(emits ? (volgrad_rgb){0, 0, 0} : DEFAULT_REFLECTANCE);
    if (*shared == VOLGRAD_NONE) {
        *shared = reader_add_material(r, shape_node, &material);
    }
    return *shared;
}
