#include "light_media.h"

#include "transform.h"

/* Off a surface towards its front by more than roundings, relative to the size of coordinates and light. */
static vec3d before(vec3d point, vec3d normal, double size)
{
    const double rounding = 5e-5;
    double coordinates = fmax(fabs(point.x), fmax(fabs(point.y), fabs(point.z)));
    return vec3d_along(point, fmin(rounding * fmax(coordinates, size), .25 * size), normal);
}

/* A point inside, on no line of symmetry: the way from it to the camera should not run along the edges of a scene's boxes. */
static vec3d flat_light_point(const volgrad_light *light)
{
    const double u = .3141, v = .2718;
    vec3d edge_u = vec3d_from(light->edge_u), edge_v = vec3d_from(light->edge_v), normal = vec3d_cross(edge_u, edge_v);
    vec3d point = vec3d_along(vec3d_along(vec3d_from(light->position), u, edge_u), v, edge_v);
    return before(point, vec3d_unit(normal), sqrt(vec3d_length(normal)));
}

static vec3d sphere_light_point(const volgrad_light *light, vec3d camera)
{
    vec3d centre = vec3d_from(light->position), out = vec3d_unit(vec3d_sub(camera, centre));
    return before(vec3d_along(centre, light->radius, out), out, light->radius);
}

static int is_far(const volgrad_light *light)
{
    return light->kind == VOLGRAD_LIGHT_ENVIRONMENT || light->kind == VOLGRAD_LIGHT_ENVIRONMENT_MAP ||
           light->kind == VOLGRAD_LIGHT_DIRECTIONAL;
}

/* A point around or in front of the light. */
static vec3d light_point(const volgrad_light *light, const volgrad_camera *camera)
{
    switch (light->kind) {
    case VOLGRAD_LIGHT_PARALLELOGRAM:
    case VOLGRAD_LIGHT_TRIANGLE:
        return flat_light_point(light);
    case VOLGRAD_LIGHT_SPHERE:
        return sphere_light_point(light, vec3d_from(camera->position));
    default:
        return vec3d_from(light->position);
    }
}

void light_media_find(scene *s, const embree_queries *queries)
{
    volgrad_light *lights = (volgrad_light *)s->desc.lights;
    for (uint32_t i = 0; i < s->desc.light_count; i++) {
        if (!is_far(&lights[i])) {
            lights[i].medium = embree_queries_medium_at(queries, vec3d_round(light_point(&lights[i], &s->desc.camera)));
        }
    }
}
