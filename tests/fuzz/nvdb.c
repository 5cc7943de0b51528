/* NanoVDB files as they are. What is in their zlib streams is out of a fuzzer's reach: see nvdb_tree.c. */
#include "fuzz.h"
#include "nvdb.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    xml_document document = {.path = "fuzz.xml"};
    xml_node node = {.document = &document};
    nvdb_grid grid;
    nvdb_volume volume;
    const char *path = fuzz_file("a.nvdb", data, size);
    /* The first byte chooses whether a grid is named: that of a file is 'N'. */
    if (nvdb_read(&node, path, size > 0 && data[0] != 'N' ? "density" : NULL, &grid)) {
        if (nvdb_bricks(&node, path, &grid, &volume)) {
            nvdb_free(volume.grid);
        }
        free(grid.words);
    }
    return 0;
}
