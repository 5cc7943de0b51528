/* The growing arrays of a scene, and its end. */
#include <stdlib.h>

#include "nvdb.h"
#include "reader.h"

/* Room for one more of `count` items: arrays grow at every power of two. NULL if memory is out; the old array then stays. */
static void *with_room(void *items, uint32_t count, size_t bytes)
{
    if (count & (count - 1)) {
        return items;
    }
    size_t room = count ? 2 * (size_t)count : 1;
    return room > SIZE_MAX / bytes ? NULL : realloc(items, room * bytes);
}

static void free_medium(const volgrad_medium *medium)
{
    free((void *)medium->density);
    if (medium->kind == VOLGRAD_MEDIUM_SPARSE_GRID) {
        nvdb_free(medium->custom);
    }
}

uint32_t reader_add_medium(reader *r, const xml_node *node, const volgrad_medium *medium)
{
    volgrad_scene_desc *desc = &r->scene->desc;
    volgrad_medium *media = with_room((void *)desc->media, desc->media_count, sizeof *media);
    if (!media) {
        free_medium(medium);
        return xml_out_of_memory(node), VOLGRAD_NONE;
    }
    desc->media = media;
    media[desc->media_count] = *medium;
    return desc->media_count++;
}

uint32_t reader_add_material(reader *r, const xml_node *node, const volgrad_material *material)
{
    volgrad_scene_desc *desc = &r->scene->desc;
    volgrad_material *materials = with_room((void *)desc->materials, desc->material_count, sizeof *materials);
    if (!materials) {
        return xml_out_of_memory(node), VOLGRAD_NONE;
    }
    desc->materials = materials;
    materials[desc->material_count] = *material;
    return desc->material_count++;
}

uint32_t reader_add_light(reader *r, const xml_node *node, const volgrad_light *light)
{
    volgrad_scene_desc *desc = &r->scene->desc;
    volgrad_light *lights = with_room((void *)desc->lights, desc->light_count, sizeof *lights);
    if (!lights) {
        free((void *)light->image);
        return xml_out_of_memory(node), VOLGRAD_NONE;
    }
    desc->lights = lights;
    lights[desc->light_count] = *light;
    lights[desc->light_count].medium = VOLGRAD_NONE; /* until light_media_find */
    return desc->light_count++;
}

static void free_shape(const shape *s)
{
    free(s->positions);
    free(s->triangles);
}

uint32_t reader_add_shape(reader *r, const xml_node *node, const shape *s)
{
    scene *target = r->scene;
    shape *shapes = with_room(target->shapes, target->shape_count, sizeof *shapes);
    if (!shapes) {
        return free_shape(s), xml_out_of_memory(node), VOLGRAD_NONE;
    }
    target->shapes = shapes;
    shapes[target->shape_count] = *s;
    return target->shape_count++;
}

void scene_free(scene *s)
{
    for (uint32_t i = 0; i < s->shape_count; i++) {
        free_shape(&s->shapes[i]);
    }
    for (uint32_t i = 0; i < s->desc.media_count; i++) {
        free_medium(&s->desc.media[i]);
    }
    for (uint32_t i = 0; i < s->desc.light_count; i++) {
        free((void *)s->desc.lights[i].image);
    }
    free(s->shapes);
    free((void *)s->desc.media);
    free((void *)s->desc.materials);
    free((void *)s->desc.lights);
    *s = (scene){0};
}
