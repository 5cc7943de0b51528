/* Meshes from .ply and .obj files, through Assimp. */
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reader.h"

/* The whole file, to be freed; NULL on an error. From memory, Assimp goes by the type that the scene names, and opens no other
 * file. */
static char *read_whole(const xml_node *node, const char *path, unsigned *bytes)
{
    FILE *file = fopen(path, "rb");
    if (!file) {
        return xml_error(node, "cannot open %s; file names are relative to the scene file", path), NULL;
    }
    long size = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    int fits = size > 0 && (unsigned long)size <= UINT_MAX && fseek(file, 0, SEEK_SET) == 0;
    char *content = fits ? malloc((size_t)size) : NULL;
    if (!fits) {
        xml_error(node, "%s is empty, larger than 4 GiB or no file", path);
    } else if (!content) {
        xml_out_of_memory(node);
    } else if (fread(content, 1, (size_t)size, file) != (size_t)size) {
        xml_error(node, "%s cannot be read", path);
        free(content);
        content = NULL;
    }
    fclose(file);
    *bytes = content ? (unsigned)size : 0;
    return content;
}

/* Assimp 5.2 never returns from a .ply file whose header does not end. */
static int is_complete(const char *content, size_t bytes, const char *type)
{
    static const char end[] = "end_header";
    size_t length = sizeof end - 1;
    for (size_t i = 0; strcmp(type, "ply") == 0 && i + length <= bytes; i++) {
        if (memcmp(content + i, end, length) == 0) {
            return 1;
        }
    }
    return strcmp(type, "ply") != 0;
}

static const struct aiScene *import(const xml_node *node, const char *path, const char *type)
{
    unsigned bytes;
    char *content = read_whole(node, path, &bytes);
    if (!content) {
        return NULL;
    }
    if (!is_complete(content, bytes, type)) {
        free(content);
        xml_error(node, "%s cannot be read as ply: it has no end_header", path);
        return NULL;
    }
    const struct aiScene *imported = aiImportFileFromMemory(content, bytes, aiProcess_Triangulate, type);
    free(content);
    if (!imported) {
        xml_error(node, "%s cannot be read as %s: %s", path, type, aiGetErrorString());
    }
    return imported;
}

/* Sums over all meshes of the file; 0 on an error. */
static int count_all(const xml_node *node, const struct aiScene *from, uint32_t *vertices, uint32_t *triangles)
{
    uint64_t vertex_sum = 0, triangle_sum = 0;
    for (unsigned m = 0; m < from->mNumMeshes; m++) {
        vertex_sum += from->mMeshes[m]->mNumVertices;
        triangle_sum += from->mMeshes[m]->mNumFaces;
    }
    if (vertex_sum == 0 || triangle_sum == 0) {
        return xml_error(node, "this file holds no triangles");
    }
    if (vertex_sum > INT32_MAX || triangle_sum > INT32_MAX) {
        return xml_error(node, "this mesh has more than 2^31 corners or triangles");
    }
    *vertices = (uint32_t)vertex_sum;
    *triangles = (uint32_t)triangle_sum;
    return 1;
}

static int copy_corners(const xml_node *node, const struct aiMesh *mesh, const transform *to_world, uint32_t first, shape *out)
{
    for (unsigned v = 0; v < mesh->mNumVertices; v++) {
        const struct aiVector3D *p = &mesh->mVertices[v];
        vec3d position = transform_point(to_world, (vec3d){p->x, p->y, p->z});
        volgrad_vec3 rounded = vec3d_round(position);
        if (!vec3d_finite(vec3d_from(rounded))) {
            return xml_error(node, "corner %u of this mesh is not finite", v);
        }
        reader_set_corner(out, first + v, position);
    }
    return 1;
}

static int has_area(const shape *s, const uint32_t *triangle)
{
    vec3d a = vec3d_load(s->positions + 3 * (size_t)triangle[0]), b = vec3d_load(s->positions + 3 * (size_t)triangle[1]);
    vec3d c = vec3d_load(s->positions + 3 * (size_t)triangle[2]);
    return vec3d_length(vec3d_cross(vec3d_difference(b, a), vec3d_difference(c, a))) > 0;
}

/* Appends the mesh's triangles, but for those without area: no ray meets them, and they have no normal. */
static int copy_triangles(const xml_node *node, const struct aiMesh *mesh, uint32_t first, shape *out)
{
    for (unsigned f = 0; f < mesh->mNumFaces; f++) {
        const struct aiFace *face = &mesh->mFaces[f];
        if (face->mNumIndices != 3) {
            return xml_error(node, "this mesh has points or lines; only faces are supported");
        }
        uint32_t *triangle = out->triangles + 3 * (size_t)out->triangle_count;
        for (int i = 0; i < 3; i++) {
            if (face->mIndices[i] >= mesh->mNumVertices) {
                return xml_error(node, "face %u of this mesh names a corner that it lacks", f);
            }
            triangle[i] = first + face->mIndices[i];
        }
        out->triangle_count += has_area(out, triangle);
    }
    return 1;
}

static void copy_meshes(const xml_node *node, const struct aiScene *from, const transform *to_world, shape *out)
{
    uint32_t vertices = 0, triangles = 0, first = 0;
    if (!count_all(node, from, &vertices, &triangles) || !reader_mesh_room(node, out, vertices, triangles)) {
        return;
    }
    out->triangle_count = 0;
    for (unsigned m = 0; m < from->mNumMeshes; m++) {
        if (!copy_corners(node, from->mMeshes[m], to_world, first, out)) {
            return;
        }
        if (!copy_triangles(node, from->mMeshes[m], first, out)) {
            return;
        }
        first += from->mMeshes[m]->mNumVertices;
    }
    if (out->triangle_count == 0) {
        xml_error(node, "no triangle of this mesh has an area");
    }
}

void reader_mesh_file(xml_node *node, const char *type, shape *out)
{
    transform to_world = param_transform(node, "to_world");
    const char *filename = param_string(node, "filename", 1);
    out->primitives_per_light = 1;
    if (!param_boolean(node, "face_normals", 0)) {
        xml_error(node, "shading normals are not supported yet, and Mitsuba would interpolate some here; write <boolean "
                        "name=\"face_normals\" value=\"true\"/>");
    }
    char *path = filename ? reader_path(node, filename) : NULL;
    const xml_node *where = filename ? param_find(node, "filename") : node;
    const struct aiScene *imported = path ? import(where, path, type) : NULL;
    if (imported) {
        copy_meshes(where, imported, &to_world, out);
    }
    if (imported) {
        aiReleaseImport(imported);
    }
    free(path);
}
