/* Surface materials. */
#include <float.h>
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

/* Complex refractive indices of metals in linear RGB, as Mitsuba 3.9.1 has them in its RGB variants. */
static const struct {
    const char *name;
    volgrad_rgb eta, k;
} NAMED_METALS[] = {{"Ag", {.155276f, .116728f, .138388f}, {4.82835f, 3.12222f, 2.1469f}},
                    {"Al", {1.6575f, .880405f, .521244f}, {9.22381f, 6.2695f, 4.837f}},
                    {"Au", {.143036f, .375307f, 1.44205f}, {3.983f, 2.38556f, 1.60336f}},
                    {"Cr", {4.36967f, 2.91651f, 1.6549f}, {5.20655f, 4.23131f, 3.7547f}},
                    {"Cu", {.201005f, .92375f, 1.10222f}, {3.91326f, 2.45305f, 2.14209f}},
                    {"W", {4.37082f, 3.30025f, 2.99841f}, {3.50064f, 2.60487f, 2.27323f}},
                    {"none", {0, 0, 0}, {1, 1, 1}}}; /* reflects all */

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

static void read_metal(xml_node *node, volgrad_material *to)
{
    const char *name = param_string(node, "material", 1);
    for (size_t i = 0; name && i < sizeof NAMED_METALS / sizeof *NAMED_METALS; i++) {
        if (strcmp(NAMED_METALS[i].name, name) == 0) {
            to->conductor_eta = NAMED_METALS[i].eta, to->conductor_k = NAMED_METALS[i].k;
            return;
        }
    }
    if (name) {
        xml_error(param_find(node, "material"), "\"%s\" is no metal that is known here; write <rgb name=\"eta\" .../> and k", name);
    }
}

static volgrad_material read_conductor(xml_node *node)
{
    volgrad_material material = {.kind = VOLGRAD_MATERIAL_CONDUCTOR};
    material.reflectance = param_color(node, "specular_reflectance", &WHITE, PARAM_UNIT);
    if (!param_find(node, "eta") && !param_find(node, "k")) {
        read_metal(node, &material);
        return material;
    }
    material.conductor_eta = param_color(node, "eta", PARAM_REQUIRED, PARAM_NOT_NEGATIVE);
    material.conductor_k = param_color(node, "k", PARAM_REQUIRED, PARAM_NOT_NEGATIVE);
    if (param_find(node, "material")) {
        xml_error(param_find(node, "material"), "material excludes eta and k; write either");
    }
    return material;
}

static float read_roughness(xml_node *node)
{
    static const double fallback = .1;
    static const param_range range = {1e-4, FLT_MAX, "1e-4 or greater"};
    const char *distribution = param_string(node, "distribution", 0);
    if (!distribution) {
        xml_error(node, "Mitsuba's default distribution is beckmann; write <string name=\"distribution\" value=\"ggx\"/>");
    } else if (strcmp(distribution, "ggx") != 0) {
        xml_error(param_find(node, "distribution"), "distribution \"%s\" is not supported; write ggx", distribution);
    }
    return (float)param_float(node, "alpha", &fallback, range);
}

static volgrad_material read_rough(xml_node *node, volgrad_material material)
{
    material.roughness = read_roughness(node);
    if (material.kind == VOLGRAD_MATERIAL_DIELECTRIC && material.eta == 1) {
        xml_error(node, "int_ior and ext_ior are the same; a rough surface refracts only if they differ");
    }
    return material;
}

static volgrad_material diffuse(volgrad_rgb reflectance)
{
    return (volgrad_material){.kind = VOLGRAD_MATERIAL_DIFFUSE, .reflectance = reflectance, .eta = 1};
}

static volgrad_material read_two_sided(reader *r, xml_node *node)
{
    volgrad_material material = diffuse(DEFAULT_REFLECTANCE);
    int found = 0;
    for (xml_node *child = node->first_child; child; child = child->next) {
        xml_node *bsdf = reader_resolve(r, child);
        if (!bsdf) {
            continue;
        }
        if (strcmp(child->name, "bsdf") == 0) {
            reader_bsdf(r, child);
        }
        if (strcmp(bsdf->name, "bsdf") != 0 || bsdf->object == VOLGRAD_NONE) {
            xml_error(child, "twosided takes one bsdf that is not null");
            continue;
        }
        material = r->scene->desc.materials[bsdf->object];
        if (found++) {
            xml_error(child, "a second bsdf in twosided; here both sides are alike");
        }
    }
    if (material.kind == VOLGRAD_MATERIAL_DIELECTRIC) {
        xml_error(node, "a dielectric has two sides already; leave twosided away");
    }
    if (node->first_child == NULL) {
        xml_error(node, "twosided lacks its bsdf");
    }
    material.flags = VOLGRAD_MATERIAL_TWO_SIDED;
    return material;
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
    } else if (strcmp(type, "roughdielectric") == 0) {
        material = read_rough(node, read_dielectric(node));
    } else if (strcmp(type, "roughconductor") == 0) {
        material = read_rough(node, read_conductor(node));
    } else if (strcmp(type, "twosided") == 0) {
        material = read_two_sided(r, node);
    } else {
        xml_error(node,
                  "bsdf \"%s\" is not supported; write diffuse, dielectric, conductor, roughdielectric, roughconductor, twosided "
                  "or null",
                  type);
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
