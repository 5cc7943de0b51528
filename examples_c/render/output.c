#define _POSIX_C_SOURCE 200809L /* getpid, fsync */

#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int complain(const char *path, const char *problem)
{
    fprintf(stderr, "volgrad-render: %s: %s\n", path, problem);
    return 0;
}

/* ---- names ---- */

/* The name that a file has until it is complete; of its own for every process. Free it. NULL: out of memory. */
static char *part_name(const char *path)
{
    size_t size = strlen(path) + 32;
    char *name = malloc(size);
    if (name != NULL) {
        snprintf(name, size, "%s.%ld.part", path, (long)getpid());
    }
    return name;
}

/* x.png of x.exr. Free it. NULL: out of memory. */
static char *preview_name(const char *exr_path)
{
    size_t size = strlen(exr_path) + 1;
    char *name = malloc(size);
    if (name != NULL) {
        memcpy(name, exr_path, size);
        memcpy(name + size - sizeof ".exr", ".png", sizeof ".png");
    }
    return name;
}

/* ---- one complete file ---- */

/* On disk before the rename, or a power cut could leave an empty file under the final name. */
static int sync_file(const char *path)
{
    int file = open(path, O_RDONLY);
    if (file < 0) {
        return 0;
    }
    int ok = fsync(file) == 0;
    return close(file) == 0 && ok;
}

/* Gives the finished part its name. */
static int publish(const char *part, const char *path)
{
    if (sync_file(part) && rename(part, path) == 0) {
        return 1;
    }
    complain(path, strerror(errno));
    remove(part);
    return 0;
}

static int check_path(const char *path)
{
    struct stat existing;
    if (stat(path, &existing) == 0 && S_ISDIR(existing.st_mode)) {
        return complain(path, "is a directory");
    }
    char *part = part_name(path);
    if (part == NULL) {
        return complain(path, "out of memory");
    }
    FILE *file = fopen(part, "wb");
    int ok = file != NULL && fclose(file) == 0;
    if (!ok) {
        fprintf(stderr, "volgrad-render: cannot write %s: %s\n", path, strerror(errno));
    }
    remove(part);
    free(part);
    return ok;
}

int output_check(const char *exr_path)
{
    char *preview = preview_name(exr_path);
    int ok = preview != NULL ? check_path(exr_path) && check_path(preview) : complain(exr_path, "out of memory");
    free(preview);
    return ok;
}

int output_folder(const char *path)
{
    struct stat existing;
    if (mkdir(path, 0777) == 0 || (stat(path, &existing) == 0 && S_ISDIR(existing.st_mode))) {
        return 1;
    }
    fprintf(stderr, "volgrad-render: cannot make folder %s: %s\n", path, strerror(errno));
    return 0;
}

/* ---- EXR ---- */

int output_write_exr(const char *exr_path, const volgrad_exr_layout *layout, const float *rgb,
                     const volgrad_exr_attribute *attributes, uint32_t attribute_count)
{
    char *part = part_name(exr_path);
    if (part == NULL) {
        return complain(exr_path, "out of memory");
    }
    size_t count = 3 * (size_t)layout->window_width * layout->window_height;
    volgrad_status status = volgrad_exr_write(part, layout, rgb, count, attributes, attribute_count);
    int ok = 0;
    if (status == VOLGRAD_OK) {
        ok = publish(part, exr_path);
    } else {
        complain(exr_path, volgrad_status_message(status));
        remove(part);
    }
    free(part);
    return ok;
}

/* ---- PNG ---- */

/* Source: IEC 61966-2-1. What is not a number becomes black. */
static png_byte srgb_byte(float linear)
{
    if (!(linear > 0.0f)) {
        return 0;
    }
    float x = fminf(linear, 1.0f);
    float encoded = x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1.0f / 2.4f) - 0.055f;
    return (png_byte)(255.0f * encoded + 0.5f);
}

/* Returns the problem, or NULL. `image` holds libpng's text. */
static const char *write_png(png_image *image, const char *path, const png_byte *bytes)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        return strerror(errno);
    }
    int written = png_image_write_to_stdio(image, file, 0, bytes, 0, NULL);
    if (fclose(file) != 0) {
        return strerror(errno);
    }
    return written ? NULL : image->message;
}

static int write_preview_bytes(const char *path, uint32_t width, uint32_t height, const png_byte *bytes)
{
    png_image image = {.version = PNG_IMAGE_VERSION, .width = width, .height = height, .format = PNG_FORMAT_RGB};
    char *part = part_name(path);
    if (part == NULL) {
        return complain(path, "out of memory");
    }
    const char *problem = write_png(&image, part, bytes);
    int ok = 0;
    if (problem == NULL) {
        ok = publish(part, path);
    } else {
        complain(path, problem);
        remove(part);
    }
    free(part);
    return ok;
}

int output_write_preview(const char *exr_path, uint32_t width, uint32_t height, const float *rgb)
{
    size_t count = 3 * (size_t)width * height;
    char *path = preview_name(exr_path);
    png_byte *bytes = malloc(count);
    int ok = 0;
    if (path == NULL || bytes == NULL) {
        complain(exr_path, "out of memory for the preview");
    } else {
        for (size_t i = 0; i < count; ++i) {
            bytes[i] = srgb_byte(rgb[i]);
        }
        ok = write_preview_bytes(path, width, height, bytes);
    }
    free(bytes);
    free(path);
    return ok;
}
