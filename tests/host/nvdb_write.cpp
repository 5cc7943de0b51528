/* Writes the .nvdb files of nvdb_test, with NanoVDB's own library, and what it says is in them: the same densities as a .vol file, and
   values at random points.

   Build: c++ -DNANOVDB_USE_ZIP nvdb_write.cpp -lz        Usage: nvdb_write FOLDER */
#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/SampleFromVoxels.h>

using nanovdb::Coord;
using nanovdb::CoordBBox;
using nanovdb::GridClass;
using Handle = nanovdb::GridHandle<>;

static std::string folder;

/* Numbers that single precision holds: then nothing depends on the order of computation. A turn, a shear and three scales. */
static nanovdb::Map map()
{
    /* Points are rows here, as in OpenVDB. */
    const double matrix[3][3] = {{0, 1. / 32, 0}, {-1. / 32, 1. / 128, 0}, {0, 0, 1. / 64}};
    const double inverse[3][3] = {{8, -32, 0}, {32, 0, 0}, {0, 0, 64}};
    const double offset[3] = {.5, -.25, 1};
    nanovdb::Map out;
    out.set(matrix, inverse, offset, 1.0);
    return out;
}

static float random_value(int i, int j, int k)
{
    std::mt19937 bits(static_cast<unsigned>((i * 73856093) ^ (j * 19349663) ^ (k * 83492791)));
    return static_cast<float>(bits() % 1024) / 1024;
}

/* Voxels on both sides of 0 along all axes: a ball of random values, a box of constant ones that holds whole nodes, and one voxel
   apart. */
static float density(const Coord &at)
{
    const int i = at[0], j = at[1], k = at[2];
    if (i * i + j * j + k * k < 14 * 14) return random_value(i, j, k);
    if (i >= 16 && i < 56 && j >= -8 && j < 20 && k >= 0 && k < 24) return .75f;
    return i == -40 && j == 30 && k == 47 ? 1 : 0;
}

/* In units of leaves: of the voxels above. */
static const int LOW[3] = {-5, -2, -2}, HIGH[3] = {6, 3, 5};

template<typename T> static Handle build(GridClass grid_class, const char *name, T background = T(0), T factor = T(1))
{
    nanovdb::GridBuilder<T> builder(background, grid_class);
    auto value = [factor](const Coord &at) { return static_cast<T>(density(at)) * factor; };
    builder(value, CoordBBox(Coord(-14), Coord(55, 23, 23)));
    auto accessor = builder.getAccessor();
    accessor.setValue(Coord(-40, 30, 47), value(Coord(-40, 30, 47)));
    return builder.getHandle(map(), name);
}

static void write(const char *file, const Handle &handle, nanovdb::io::Codec codec = nanovdb::io::Codec::NONE)
{
    nanovdb::io::writeGrid(folder + file, handle, codec);
}

/* Two voxels, with all nodes of their own, in which they are at the same place. */
static void write_small()
{
    nanovdb::GridBuilder<float> builder(0, GridClass::FogVolume);
    auto accessor = builder.getAccessor();
    accessor.setValue(Coord(1, 2, 3), .5f);
    accessor.setValue(Coord(1 - 4096, 2, 3), .25f);
    write("small.nvdb", builder.getHandle(map(), "density"));
}

template<typename T> static void put(std::ofstream &file, T value)
{
    file.write(reinterpret_cast<const char *>(&value), sizeof value);
}

/* The box that the reader makes: from a leaf before the first one to one voxel after the last. */
static void write_dense(const nanovdb::NanoGrid<float> &grid)
{
    std::ofstream file(folder + "cloud.vol", std::ios::binary);
    file.write("VOL\3", 4);
    put(file, int32_t(1));
    for (int axis = 0; axis < 3; axis++) put(file, int32_t(8 * (HIGH[axis] - LOW[axis] + 2) + 1));
    put(file, int32_t(1));
    for (int i = 0; i < 6; i++) put(file, float(i >= 3));
    auto accessor = grid.getAccessor();
    for (int k = 8 * (LOW[2] - 1); k <= 8 * (HIGH[2] + 1); k++)
        for (int j = 8 * (LOW[1] - 1); j <= 8 * (HIGH[1] + 1); j++)
            for (int i = 8 * (LOW[0] - 1); i <= 8 * (HIGH[0] + 1); i++) put(file, accessor.getValue(Coord(i, j, k)));
}

/* x, y, z in the world and the interpolated value there. */
static void write_points(const nanovdb::NanoGrid<float> &grid)
{
    std::ofstream file(folder + "points.bin", std::ios::binary);
    std::mt19937 bits(1);
    auto uniform = [&bits](double low, double high) { return std::uniform_real_distribution<double>(low, high)(bits); };
    const auto accessor = grid.getAccessor();
    auto sampler = nanovdb::createSampler<1>(accessor);
    for (int n = 0; n < 4000; n++) {
        const nanovdb::Vec3d index = n % 100 == 0 ? nanovdb::Vec3d(uniform(-42, -38), uniform(28, 32), uniform(45, 49))
                                                  : nanovdb::Vec3d(uniform(-18, 60), uniform(-18, 26), uniform(-18, 28));
        const auto world = grid.map().applyMap(index);
        const float x[3] = {float(world[0]), float(world[1]), float(world[2])};
        for (float coordinate : x) put(file, coordinate);
        put(file, float(sampler(grid.map().applyInverseMap(nanovdb::Vec3d(x[0], x[1], x[2])))));
    }
}

/* Fog in a box that all of the grid is in, seen from the side. */
static void write_scene(const char *file, const std::string &volume)
{
    std::ofstream out(folder + file);
    out << "<scene version='3.0.0'><integrator type='volpath'/><sensor type='perspective'><float name='fov' value='50'/>"
           "<transform name='to_world'><lookat origin='.5,.5,5' target='0,.3,1.2' up='0,1,0'/></transform>"
           "<film type='hdrfilm'><integer name='width' value='48'/><integer name='height' value='40'/>"
           "<rfilter type='box'/></film></sensor><emitter type='constant'><rgb name='radiance' value='1, .8, .6'/></emitter>"
           "<emitter type='directional'><vector name='direction' x='1' y='-1' z='0'/><rgb name='irradiance' value='2'/></emitter>"
           "<shape type='cube'><transform name='to_world'><scale value='4'/></transform><bsdf type='null'/>"
           "<medium type='heterogeneous' name='interior'>"
        << volume << "<float name='scale' value='3'/></medium></shape></scene>\n";
}

static void write_scenes()
{
    write_scene("nvdb.xml", "<volume name='sigma_t' type='nvdbvolume'><string name='filename' value='zip.nvdb'/></volume>");
    /* The unit cube to the box, half a voxel beyond its samples, and then the map. */
    std::string box = "<scale";
    auto attribute = [](int axis, double value) { return std::string(" ") + "xyz"[axis] + "='" + std::to_string(value) + "'"; };
    for (int axis = 0; axis < 3; axis++) box += attribute(axis, 8 * (HIGH[axis] - LOW[axis] + 2) + 1);
    box += "/><translate";
    for (int axis = 0; axis < 3; axis++) box += attribute(axis, 8 * (LOW[axis] - 1) - .5);
    box += "/><matrix value='0 -.03125 0 .5 .03125 .0078125 0 -.25 0 0 .015625 1 0 0 0 1'/>";
    write_scene("vol.xml", "<volume name='sigma_t' type='gridvolume'><string name='filename' value='cloud.vol'/>"
                           "<transform name='to_world'>" + box + "</transform></volume>");
}

int main(int argc, char **argv)
{
    if (argc != 2) return std::fprintf(stderr, "usage: nvdb_write FOLDER\n"), 2;
    folder = std::string(argv[1]) + "/";
    const Handle cloud = build<float>(GridClass::FogVolume, "density");
    write("none.nvdb", cloud);
    write("zip.nvdb", cloud, nanovdb::io::Codec::ZIP);
    write("double.nvdb", build<double>(GridClass::FogVolume, "density"));
    write("level_set.nvdb", build<float>(GridClass::LevelSet, "distance"));
    write("background.nvdb", build<float>(GridClass::FogVolume, "density", .25f));
    write("negative.nvdb", build<float>(GridClass::FogVolume, "density", 0, -1));
    nanovdb::GridBuilder<float> nothing(0, GridClass::FogVolume);
    write("empty.nvdb", nothing.getHandle(map(), "density"));
    std::vector<Handle> two;
    two.push_back(build<float>(GridClass::FogVolume, "density"));
    two.push_back(build<double>(GridClass::Unknown, "temperature"));
    nanovdb::io::writeGrids(folder + "two.nvdb", two, nanovdb::io::Codec::ZIP);
    write_small();
    write_dense(*cloud.grid<float>());
    write_points(*cloud.grid<float>());
    write_scenes();
    return 0;
}
