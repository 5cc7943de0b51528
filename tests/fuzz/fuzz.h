/* What the fuzz targets share: readers of files want files. */
#ifndef FUZZ_H
#define FUZZ_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static char fuzz_folder[] = "/dev/shm/volgrad-fuzz-XXXXXX";

static void fuzz_remove(void)
{
    char command[sizeof fuzz_folder + 16];
    snprintf(command, sizeof command, "rm -rf '%s'", fuzz_folder);
    if (system(command) != 0) {
        fprintf(stderr, "%s is left behind\n", fuzz_folder);
    }
}

/* The path of a file of this name and content, in memory; valid until the next call. */
static inline const char *fuzz_file(const char *name, const void *data, size_t size)
{
    static char path[128];
    static int ready;
    if (!ready) {
        ready = mkdtemp(fuzz_folder) != NULL && atexit(fuzz_remove) == 0;
    }
    snprintf(path, sizeof path, "%s/%s", fuzz_folder, name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0) {
        perror(path);
        exit(2);
    }
    return path;
}

#endif
