/* The parts of the scene reader: each turns one kind of XML element into a piece of the scene. What is wrong with an element is
   reported where it stands and counted in the document; the part then returns something harmless, and scene_load gives up at the
   end. */
#ifndef RENDER_READER_H
#define RENDER_READER_H

#include "params.h"
#include "scene.h"
#include "xml.h"

typedef struct {
    xml_document *document;
    scene *scene;              /* grows while the file is read */
    uint32_t default_material; /* of shapes without a bsdf; VOLGRAD_NONE until the first one needs it */
    uint32_t black_material;   /* of emitting shapes without a bsdf */
} reader;

/* What an <emitter type="area"> says; the shape makes lights of it. */
typedef struct {
    volgrad_rgb radiance;
    double sampling_weight;
} area_emission;

/* reader_scene.c: append to the scene and return the index; VOLGRAD_NONE if memory is out, which is reported at `node`. */
uint32_t reader_add_medium(reader *r, const xml_node *node,
                           const volgrad_medium *medium); /* takes its grid over, also on failure */
uint32_t reader_add_material(reader *r, const xml_node *node, const volgrad_material *material);
uint32_t reader_add_light(reader *r, const xml_node *node, const volgrad_light *light); /* takes its image over, also on failure */
uint32_t reader_add_shape(reader *r, const xml_node *node, const shape *s); /* takes its arrays over, also on failure */

/* reader_refs.c */

/* The element that `node` stands for: itself, or if it is a <ref> the earlier element of that id; NULL on an error. */
xml_node *reader_resolve(reader *r, xml_node *node);
void reader_check_ids(const xml_document *document);

/* `filename` beside the scene file, unless it is absolute. NULL on an error. To be freed. */
char *reader_path(const xml_node *node, const char *filename);

/* The rest: one file per kind of element. The first two note the index in `node->object`, for references. */
void reader_medium(reader *r, xml_node *node);
void reader_bsdf(reader *r, xml_node *node); /* VOLGRAD_NONE: a null bsdf */
uint32_t reader_default_bsdf(reader *r, const xml_node *shape_node, int emits);
void reader_emitter(reader *r, xml_node *node); /* not area */
area_emission reader_area_emitter(xml_node *node);
void reader_shape(reader *r, xml_node *node);
void reader_sensor(reader *r, xml_node *node);
void reader_integrator(reader *r, xml_node *node);

/* geometry.c, mesh_file.c: the shape's geometry by its type, without material, media and lights. */
int reader_is_mesh_type(const char *type);
void reader_geometry(xml_node *node, const char *type, shape *out, int *mirrored);
void reader_mesh_file(xml_node *node, const char *type, shape *out);

/* Gives the shape room for its corners and triangles; 0 if memory is out. What it has stays owned by the shape. */
int reader_mesh_room(const xml_node *node, shape *out, uint32_t vertices, uint32_t triangles);
void reader_set_corner(shape *s, uint32_t vertex, vec3d position);

/* shape_lights.c: the lights of a shape that emits. */
void reader_shape_lights(reader *r, const xml_node *node, shape *s, area_emission emission);

/* scene_bounds.c: the sphere around all shapes. */
void reader_bounds(scene *s);

#endif
