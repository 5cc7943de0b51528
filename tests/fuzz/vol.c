/* Density grids of Mitsuba. */
#include "fuzz.h"
#include "vol_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    xml_document document = {.path = "fuzz.xml"};
    xml_node node = {.document = &document};
    vol_grid grid;
    if (vol_load(&node, fuzz_file("a.vol", data, size), &grid)) {
        free(grid.density);
    }
    return 0;
}
