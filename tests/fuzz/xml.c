/* Scene files: any text. Beside them are the grid and the mesh that the corpus names. */
#include "fuzz.h"
#include "scene.h"

static void write_neighbours(void)
{
    static int done;
    if (!done) {
        static const struct {
            char magic[4];
            int32_t numbers[5];
            float box[6], values[8];
        } vol = {{'V', 'O', 'L', 3}, {1, 2, 2, 2, 1}, {-1, -1, -1, 1, 1, 1}, {0, 1, 2, 3, 4, 5, 6, 7}};
        static const char obj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\n";
        fuzz_file("a.vol", &vol, sizeof vol);
        fuzz_file("a.obj", obj, sizeof obj - 1);
        done = 1;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    scene s;
    write_neighbours();
    if (scene_load(fuzz_file("scene.xml", data, size), &s)) {
        scene_free(&s);
    }
    return 0;
}
