/* Participating media and phase functions. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "nvdb.h"
#include "reader.h"
#include "vol_file.h"

/* Mitsuba's defaults. */
static const volgrad_rgb DEFAULT_SIGMA_T = {1, 1, 1};
static const volgrad_rgb DEFAULT_ALBEDO = {.75f, .75f, .75f};
static const double DEFAULT_SCALE = 1, DEFAULT_G = .8;

static volgrad_phase read_phase(xml_node *medium)
{
    /* The largest |g| below 1 in single precision. */
    static const param_range cosine = {-0.99999994, 0.99999994, "between -1 and 1 (exclusive)"};
    volgrad_phase phase = {VOLGRAD_PHASE_ISOTROPIC, 0};
    xml_node *node = param_object(medium, "phase");
    if (!node) {
        return phase;
    }
    const char *type = param_type(node);
    if (strcmp(type, "hg") == 0) {
        phase.kind = VOLGRAD_PHASE_HENYEY_GREENSTEIN;
        phase.g = (float)param_float(node, "g", &DEFAULT_G, cosine);
    } else if (strcmp(type, "isotropic") != 0) {
        xml_error(node, "phase function \"%s\" is not supported; write isotropic or hg", type);
    }
    return phase;
}

static volgrad_rgb read_albedo(xml_node *node)
{
    xml_node *albedo = param_find(node, "albedo");
    if (!albedo || strcmp(albedo->name, "volume") != 0) {
        return param_color(node, "albedo", &DEFAULT_ALBEDO, PARAM_UNIT);
    }
    albedo->used = 1;
    xml_error(albedo,
              "an albedo that varies in space (<volume name=\"albedo\">) is not supported; write <rgb name=\"albedo\" .../>");
    return DEFAULT_ALBEDO;
}

static volgrad_rgb scaled(volgrad_rgb color, double scale)
{
    return (volgrad_rgb){(float)(color.r * scale), (float)(color.g * scale), (float)(color.b * scale)};
}

static int is_finite(volgrad_rgb c)
{
    return isfinite(c.r) && isfinite(c.g) && isfinite(c.b);
}

static volgrad_rgb read_homogeneous_sigma_t(xml_node *node)
{
    static const param_range coloured = {
        0, 1, "between 0 and 1 as <rgb> (Mitsuba's rule); write a smaller one and <float name=\"scale\" .../>"};
    xml_node *sigma_t = param_find(node, "sigma_t");
    int is_rgb = sigma_t && strcmp(sigma_t->name, "rgb") == 0;
    return param_color(node, "sigma_t", &DEFAULT_SIGMA_T, is_rgb ? coloured : PARAM_NOT_NEGATIVE);
}

/* The unit cube on the box that the file names. */
static int read_grid_box(const xml_node *node, const vol_grid *grid, transform *out)
{
    vec3d low = vec3d_load(grid->box_min), size = vec3d_difference(vec3d_load(grid->box_max), low);
    if (!(size.x > 0 && size.y > 0 && size.z > 0 && isfinite(size.x + size.y + size.z))) {
        return xml_error(node, "the box in the .vol file is empty; leave use_grid_bbox away and write a to_world transform");
    }
    transform offset = transform_translate(low), scale = transform_scale(size);
    *out = transform_multiply(&offset, &scale);
    return 1;
}

static void set_map(volgrad_medium *medium, const transform *to_world)
{
    for (int i = 0; i < 12; i++) {
        medium->local_to_world[i] = (float)to_world->m[i / 4][i % 4];
    }
}

static void set_grid_map(xml_node *node, const vol_grid *grid, int use_box, volgrad_medium *medium)
{
    transform to_world = param_transform(node, "to_world"), box;
    if (use_box && read_grid_box(node, grid, &box)) {
        to_world = transform_multiply(&to_world, &box);
    }
    if (!transform_is_axis_aligned(&to_world)) {
        xml_warning(node,
                    "this grid is not axis-aligned: Mitsuba clips it at its bounding box in the world and clamps the density in "
                    "that box's corners, volgrad clips it at the rotated grid itself");
    }
    set_map(medium, &to_world);
}

static void read_grid_file(xml_node *node, vol_grid *grid)
{
    const char *filename = param_string(node, "filename", 1);
    char *path = filename ? reader_path(node, filename) : NULL;
    if (path) {
        vol_load(param_find(node, "filename"), path, grid);
    }
    free(path);
}

static void read_grid(xml_node *node, volgrad_medium *medium)
{
    vol_grid grid = {0};
    param_only_string(node, "wrap_mode", "clamp");
    param_only_string(node, "filter_type", "trilinear");
    int use_box = param_boolean(node, "use_grid_bbox", 0);
    read_grid_file(node, &grid);
    set_grid_map(node, &grid, use_box && grid.density, medium);
    medium->density = grid.density;
    medium->nx = grid.nx, medium->ny = grid.ny, medium->nz = grid.nz;
}

static int read_nvdb_file(xml_node *node, nvdb_volume *out)
{
    const char *filename = param_string(node, "filename", 1), *name = param_string(node, "grid", 0);
    char *path = filename ? reader_path(node, filename) : NULL;
    xml_node *blamed = param_find(node, "filename");
    nvdb_grid grid = {NULL, 0};
    int ok = path && nvdb_read(blamed, path, name, &grid) && nvdb_bricks(blamed, path, &grid, out);
    free(grid.words);
    free(path);
    return ok;
}

/* The file's own map, then to_world. */
static void read_nvdb(xml_node *node, volgrad_medium *medium)
{
    nvdb_volume volume;
    transform to_world = param_transform(node, "to_world");
    medium->kind = VOLGRAD_MEDIUM_SPARSE_GRID;
    if (!read_nvdb_file(node, &volume)) {
        return;
    }
    to_world = transform_multiply(&to_world, &volume.to_world);
    set_map(medium, &to_world);
    medium->custom = volume.grid;
    medium->nx = volume.nx, medium->ny = volume.ny, medium->nz = volume.nz;
}

static void read_volume(xml_node *node, volgrad_medium *medium)
{
    const char *type = param_type(node);
    if (strcmp(type, "gridvolume") == 0) {
        read_grid(node, medium);
    } else if (strcmp(type, "nvdbvolume") == 0) {
        read_nvdb(node, medium);
    } else {
        xml_error(node, "volume \"%s\" is not supported as sigma_t; write gridvolume, nvdbvolume, or a homogeneous medium", type);
    }
}

static void read_heterogeneous(xml_node *node, volgrad_medium *medium)
{
    xml_node *sigma_t = param_find(node, "sigma_t");
    medium->kind = VOLGRAD_MEDIUM_GRID;
    medium->sigma_t = DEFAULT_SIGMA_T;
    if (sigma_t && strcmp(sigma_t->name, "volume") == 0) {
        read_volume(sigma_t, medium);
        return;
    }
    if (sigma_t) {
        sigma_t->used = 1;
    }
    xml_error(sigma_t ? sigma_t : node, "a heterogeneous medium needs <volume type=\"gridvolume\" name=\"sigma_t\"> or nvdbvolume");
}

void reader_medium(reader *r, xml_node *node)
{
    volgrad_medium medium = {.kind = VOLGRAD_MEDIUM_HOMOGENEOUS};
    const char *type = param_type(node);
    if (strcmp(type, "homogeneous") == 0) {
        medium.sigma_t = read_homogeneous_sigma_t(node);
    } else if (strcmp(type, "heterogeneous") == 0) {
        read_heterogeneous(node, &medium);
    } else {
        xml_error(node, "medium \"%s\" is not supported; write homogeneous or heterogeneous", type);
    }
    medium.albedo = read_albedo(node);
    medium.sigma_t = scaled(medium.sigma_t, param_float(node, "scale", &DEFAULT_SCALE, PARAM_NOT_NEGATIVE));
    if (!is_finite(medium.sigma_t)) {
        xml_error(node, "sigma_t times scale is too large for single precision");
    }
    medium.phase = read_phase(node);
    node->object = reader_add_medium(r, node, &medium);
}
