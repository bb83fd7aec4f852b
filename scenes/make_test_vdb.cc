/* make_test_vdb FOLDER: writes the small OpenVDB files that tests/render/test_vdb_import.c reads:
 * what a reader must understand, state or refuse. Values of the pattern grids are pattern(i, j, k),
 * which the test computes again. */
#pragma GCC visibility push(default) /* as in render/import/scene/vdb_import.cc */
#include <openvdb/openvdb.h>
#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/LevelSetSphere.h>
#pragma GCC visibility pop

#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

namespace
{

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;

/* A multiple of 1/64 in 0..1, exact as a half too. */
double pattern(int i, int j, int k)
{
    unsigned h = unsigned(i) * 73u ^ unsigned(j) * 19u ^ unsigned(k) * 83u;
    return double(h % 65u) / 64.0;
}

template <typename Grid> typename Grid::Ptr pattern_grid(const char *name)
{
    auto grid = Grid::create(0);
    auto accessor = grid->getAccessor();
    for (int k = -9; k <= 8; k++)
        for (int j = 3; j <= 30; j++)
            for (int i = -5; i <= 20; i++)
                accessor.setValueOn(Coord(i, j, k), typename Grid::ValueType(pattern(i, j, k)));
    grid->setName(name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

/* x = 0.5 i + 0.125 j + 7, y = 0.25 k - 3, z = -2 j + 1: turned, sheared, stretched and moved. */
openvdb::math::Transform::Ptr odd_map()
{
    openvdb::math::Mat4d m(0.5, 0., 0., 0., 0.125, 0., -2., 0., 0., 0.25, 0., 0., 7., -3., 1., 1.);
    return openvdb::math::Transform::createLinearTransform(m);
}

FloatGrid::Ptr one_voxel(const char *name, float value)
{
    auto grid = FloatGrid::create(0);
    grid->tree().setValueOn(Coord(0), value);
    grid->setName(name);
    return grid;
}

openvdb::GridPtrVec patterns()
{
    auto single = pattern_grid<FloatGrid>("density"), half = pattern_grid<FloatGrid>("half");
    auto twice = pattern_grid<openvdb::DoubleGrid>("double");
    single->setTransform(odd_map());
    half->setSaveFloatAsHalf(true);
    return {single, half, twice};
}

/* A 128^3 tile, an 8^3 tile and a voxel on its own. */
openvdb::GridPtrVec tiles()
{
    auto grid = FloatGrid::create(0);
    grid->tree().addTile(2, Coord(0), 0.25f, true);
    grid->tree().addTile(1, Coord(128, 0, 0), 0.5f, true);
    grid->tree().setValueOn(Coord(140, 3, -2), 0.75f);
    grid->setName("density");
    return {grid};
}

/* 8^3 voxels of 1. */
openvdb::GridPtrVec block()
{
    auto grid = FloatGrid::create(0);
    grid->fill(CoordBBox(Coord(0), Coord(7)), 1);
    grid->setName("density");
    return {grid};
}

/* A block of 8^3 with colours from left to right, as vectors and as three grids. */
openvdb::GridPtrVec colours()
{
    auto density = FloatGrid::create(0);
    auto vectors = openvdb::Vec3SGrid::create();
    openvdb::GridPtrVec all = {density, vectors};
    const char *const names[] = {"red", "green", "blue"};
    density->fill(CoordBBox(Coord(0), Coord(7)), 1);
    density->setName("density");
    for (int c = 0; c < 3; c++) {
        auto channel = FloatGrid::create(0);
        channel->setName(names[c]);
        for (int i = 0; i < 8; i++)
            channel->fill(CoordBBox(Coord(i, 0, 0), Coord(i, 7, 7)), float((i + c) % 8 + 1) / 8);
        all.push_back(channel);
    }
    for (int i = 0; i < 8; i++)
        vectors->fill(
            CoordBBox(Coord(i, 0, 0), Coord(i, 7, 7)),
            openvdb::Vec3f(float(i % 8 + 1), float((i + 1) % 8 + 1), float((i + 2) % 8 + 1)) /
                8.0f);
    vectors->setName("Cd");
    return all;
}

/* A grid with nothing in it, made by the library: each kind that is compiled here takes seconds. */
openvdb::GridBase::Ptr nothing(const char *type, const char *name)
{
    auto grid = openvdb::GridBase::createGrid(type);
    grid->setName(name);
    return grid;
}

openvdb::GridPtrVec kinds()
{
    return {nothing("Tree_vec3s_5_4_3", "velocity"), nothing("Tree_int32_5_4_3", "flags"),
            nothing("Tree_bool_5_4_3", "mask")};
}

/* Voxels of some length, moved. */
openvdb::math::Transform::Ptr voxels_of(double length, double x, double y, double z)
{
    auto map = openvdb::math::Transform::createLinearTransform(length);
    map->postTranslate(openvdb::Vec3d(x, y, z));
    return map;
}

/* The same, turned by half a radian about x and sheared. */
openvdb::math::Transform::Ptr skewed(double length)
{
    auto map = voxels_of(length, 0.1, 0.2, -0.1);
    map->preRotate(0.5, openvdb::math::X_AXIS);
    map->preShear(0.3, openvdb::math::X_AXIS, openvdb::math::Y_AXIS);
    return map;
}

openvdb::Vec3SGrid::Ptr vectors(const char *name, const CoordBBox &box,
                                const openvdb::math::Transform::Ptr &map,
                                openvdb::Vec3f (*value)(const openvdb::Vec3d &))
{
    auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3f(0));
    auto accessor = grid->getAccessor();
    grid->setTransform(map);
    grid->setName(name);
    for (auto at = box.begin(); at; ++at)
        accessor.setValueOn(*at, value(map->indexToWorld(*at)));
    return grid;
}

/* One component as a grid of floats. */
FloatGrid::Ptr floats(const openvdb::Vec3SGrid &from, int component, const char *name)
{
    auto grid = FloatGrid::create(0);
    auto accessor = grid->getAccessor();
    grid->setTransform(from.transform().copy());
    grid->setName(name);
    for (auto value = from.cbeginValueOn(); value; ++value)
        accessor.setValueOn(value.getCoord(), (*value)[component]);
    return grid;
}

openvdb::Vec3f along(const openvdb::Vec3d &)
{
    return openvdb::Vec3f(1.5f, -0.5f, 0.25f);
}

/* One turn about z in 2 pi seconds. */
openvdb::Vec3f around(const openvdb::Vec3d &p)
{
    return openvdb::Vec3f(float(-p.y()), float(p.x()), 0);
}

/* The same in voxels of 2. */
openvdb::Vec3f along_in_voxels(const openvdb::Vec3d &p)
{
    return along(p) * 0.5f;
}

/* Out along x and in along y. */
openvdb::Vec3f apart(const openvdb::Vec3d &p)
{
    return openvdb::Vec3f(float(p.x()), float(-p.y()), 0);
}

/* Components on faces, each as it is there. */
openvdb::Vec3SGrid::Ptr apart_on_faces(const CoordBBox &box)
{
    auto map = voxels_of(1, 0.1, 0.2, -0.1);
    auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3f(0));
    auto accessor = grid->getAccessor();
    grid->setTransform(map);
    grid->setGridClass(openvdb::GRID_STAGGERED);
    grid->setName("faces");
    for (auto at = box.begin(); at; ++at) {
        openvdb::Vec3f v;
        for (int i = 0; i < 3; i++) {
            openvdb::Vec3d p = (*at).asVec3d();
            p[i] -= 0.5;
            v[i] = apart(map->indexToWorld(p))[i];
        }
        accessor.setValueOn(*at, v);
    }
    return grid;
}

/* A soft blob at (2, 0.5, 0) and a grid of temperatures with another map, and what moves them. */
openvdb::GridPtrVec flows()
{
    auto density = FloatGrid::create(0), heat = FloatGrid::create(0), slant = FloatGrid::create(0);
    density->setTransform(voxels_of(0.25, 0, 0, 0));
    heat->setTransform(voxels_of(0.5, 0.1, 0, 0.05));
    slant->setTransform(skewed(0.25));
    density->setName("density");
    heat->setName("temperature");
    slant->setName("slant");
    for (auto &grid : {density, heat, slant})
        for (auto at = CoordBBox(Coord(-20), Coord(20)).begin(); at; ++at) {
            openvdb::Vec3d d = grid->indexToWorld(*at) - openvdb::Vec3d(2, 0.5, 0);
            double value = 1 - d.lengthSqr() / (1.5 * 1.5);
            if (value > 0)
                grid->tree().setValueOn(*at, float(value));
        }
    const CoordBBox wide(Coord(-14), Coord(14));
    auto even = vectors("velocity", wide, voxels_of(1, 0.1, 0.2, -0.1), along);
    auto turn = vectors("turn", wide, voxels_of(1, 0.1, 0.2, -0.1), around);
    return {density,
            heat,
            even,
            turn,
            apart_on_faces(wide),
            slant,
            vectors("tilted", wide, skewed(1), around),
            vectors("in_voxels", wide, voxels_of(2, 0, 0, 0), along_in_voxels),
            vectors("far", CoordBBox(Coord(1000), Coord(1008)), voxels_of(0.5, 0, 0, 0), along),
            vectors("narrow", CoordBBox(Coord(4, 1, 0), Coord(4, 1, 0)), voxels_of(0.5, 0, 0, 0),
                    along),
            floats(*even, 0, "vel.x"),
            floats(*even, 1, "vel.y"),
            floats(*even, 2, "vel.z"),
            floats(*even, 0, "u")};
}

/* Velocities that are none. */
openvdb::GridPtrVec bad_flows()
{
    auto density = one_voxel("density", 1), infinite = one_voxel("wrong.x", 0);
    auto nan = openvdb::Vec3SGrid::create(openvdb::Vec3f(0)), frustum = nan->deepCopy(),
         none = nan->deepCopy(), fast = nan->deepCopy(), vast = nan->deepCopy(),
         steady = nan->deepCopy();
    const float big = std::numeric_limits<float>::infinity();
    nan->tree().setValueOn(Coord(1, 2, 3), openvdb::Vec3f(1, std::nanf(""), 1));
    frustum->tree().setValueOn(Coord(0), openvdb::Vec3f(1));
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(10)), 0.5, 10, 1));
    fast->tree().setValueOn(Coord(0), openvdb::Vec3f(3e38f, -3e38f, 1));
    infinite->tree().setValueOn(Coord(0), big);
    vast->setTransform(voxels_of(1e5, 0, 0, 0));
    vast->tree().setValueOn(Coord(0), openvdb::Vec3f(1e8f));
    vast->tree().setValueOn(Coord(8), openvdb::Vec3f(1e8f));
    steady->fill(openvdb::CoordBBox(Coord(-8), Coord(8)), openvdb::Vec3f(1, 0, 0));
    steady->setName("steady");
    nan->setName("nan");
    frustum->setName("frustum");
    none->setName("none");
    fast->setName("fast");
    vast->setName("vast");
    return {density, nan, frustum, none, fast, vast, infinite, steady};
}

openvdb::GridPtrVec bad_values()
{
    return {one_voxel("nan", std::numeric_limits<float>::quiet_NaN()),
            one_voxel("infinite", std::numeric_limits<float>::infinity()),
            one_voxel("negative", -0.5f)};
}

/* 10^3 voxels of 0.5, three of which are a little below 0, two are none, one is too much. */
FloatGrid::Ptr nearly_fog(const char *name)
{
    auto grid = FloatGrid::create(0);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    grid->tree().fill(CoordBBox(Coord(0), Coord(9)), 0.5f, true);
    for (int i = 0; i < 3; i++)
        grid->tree().setValueOn(Coord(i, 2, 3), i == 1 ? -1e-3f : -1e-7f);
    grid->tree().setValueOn(Coord(5, 5, 5), nan);
    grid->tree().setValueOn(Coord(9, 9, 9), nan);
    grid->tree().setValueOn(Coord(0), std::numeric_limits<float>::infinity());
    grid->setName(name);
    return grid;
}

/* Distances of a ball, which does not say what it is. */
openvdb::GridPtrVec odd_values()
{
    auto ball =
        openvdb::tools::createLevelSetSphere<FloatGrid>(5.0f, openvdb::Vec3f(0), 0.5f, 3.0f);
    ball->setName("distance");
    ball->setGridClass(openvdb::GRID_UNKNOWN);
    auto wind = openvdb::Vec3SGrid::create(openvdb::Vec3f(0));
    wind->tree().setValueOn(Coord(0), openvdb::Vec3f(1, std::nanf(""), 1));
    wind->tree().setValueOn(Coord(1), openvdb::Vec3f(1));
    wind->setName("wind");
    return {nearly_fog("density"), nearly_fog("heat"), ball, wind};
}

/* 4^3 voxels of 0.5. */
template <typename Grid> typename Grid::Ptr small_block(const char *name)
{
    auto grid = Grid::create();
    grid->fill(CoordBBox(Coord(0), Coord(3)), typename Grid::ValueType(0.5));
    grid->setName(name);
    return grid;
}

/* A grid for each thing that a file can say of one (docs/reference/formats/volumes.md). */
openvdb::GridPtrVec said_of_grids()
{
    auto fog = small_block<FloatGrid>("fog"), half = small_block<FloatGrid>("half"),
         moved = small_block<FloatGrid>("moved"), scaled = small_block<FloatGrid>("scaled"),
         turned = small_block<FloatGrid>("turned"), frustum = small_block<FloatGrid>("frustum"),
         wide = small_block<FloatGrid>("background"), words = small_block<FloatGrid>("words"),
         tile = FloatGrid::create(0), inactive = small_block<FloatGrid>("inactive");
    fog->setGridClass(openvdb::GRID_FOG_VOLUME);
    half->setSaveFloatAsHalf(true);
    moved->setTransform(voxels_of(1, 5, 6, 7));
    scaled->setTransform(voxels_of(0.25, 0, 0, 0));
    turned->setTransform(skewed(1));
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(10)), 0.5, 10, 1));
    openvdb::tools::changeBackground(wide->tree(), 0.25f);
    words->setCreator("a program");
    words->setIsInWorldSpace(false);
    words->insertMeta("author", openvdb::StringMetadata("somebody"));
    words->insertMeta("frame", openvdb::Int32Metadata(7));
    tile->tree().addTile(1, Coord(0), 0.5f, true);
    tile->setName("tile");
    inactive->tree().setValueOff(Coord(9), 0.7f);
    auto same = small_block<FloatGrid>("same"), shared = same->copy();
    shared->setName("shared");
    auto vec3s = openvdb::Vec3SGrid::create();
    auto vec3d = openvdb::Vec3DGrid::create();
    vec3s->fill(CoordBBox(Coord(0), Coord(3)), openvdb::Vec3f(0.5f, 0.25f, 0));
    vec3d->fill(CoordBBox(Coord(0), Coord(3)), openvdb::Vec3d(0.5, 0.25, 0));
    vec3s->setName("vec3s");
    vec3d->setName("vec3d");
    vec3s->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
    auto empty = FloatGrid::create(0);
    empty->setName("empty");
    return {small_block<FloatGrid>("density"),
            fog,
            half,
            small_block<openvdb::DoubleGrid>("double"),
            moved,
            scaled,
            turned,
            frustum,
            wide,
            words,
            tile,
            inactive,
            same,
            shared,
            vec3s,
            vec3d,
            nothing("Tree_vec3i_5_4_3", "vec3i"),
            nothing("Tree_int32_5_4_3", "int32"),
            nothing("Tree_int64_5_4_3", "int64"),
            nothing("Tree_bool_5_4_3", "bool"),
            nothing("Tree_mask_5_4_3", "mask"),
            empty,
            small_block<FloatGrid>("density")};
}

openvdb::GridPtrVec frustum()
{
    auto grid = one_voxel("density", 1);
    grid->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(10)), 0.5, 10, 1));
    return {grid};
}

openvdb::GridPtrVec sizes()
{
    auto far = one_voxel("far", 1), full = FloatGrid::create(0);
    far->tree().setValueOn(Coord(2000000, 0, 0), 1);
    full->tree().addTile(3, Coord(0), 1, true); /* 4096^3 voxels */
    full->setName("full");
    return {far, full};
}

openvdb::GridPtrVec empty()
{
    auto none = FloatGrid::create(0);
    none->setName("density");
    return {none, one_voxel("zero", 0)};
}

openvdb::GridPtrVec level_set()
{
    auto sphere =
        openvdb::tools::createLevelSetSphere<FloatGrid>(5.0f, openvdb::Vec3f(0), 0.5f, 3.0f);
    sphere->setName("density");
    return {sphere};
}

void write(const std::string &folder, const char *name, const openvdb::GridPtrVec &grids,
           uint32_t compression)
{
    openvdb::io::File file(folder + "/" + name);
    file.setCompression(compression);
    file.write(grids);
    file.close();
}

void write_all(const std::string &folder)
{
    const uint32_t zip = openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_ZIP;
    const uint32_t blosc = openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC;
    openvdb::initialize();
    write(folder, "patterns.vdb", patterns(), blosc);
    write(folder, "patterns_zip.vdb", patterns(), zip);
    write(folder, "patterns_plain.vdb", patterns(), openvdb::io::COMPRESS_NONE);
    write(folder, "tiles.vdb", tiles(), zip);
    write(folder, "block.vdb", block(), zip);
    write(folder, "kinds.vdb", kinds(), zip);
    write(folder, "colours.vdb", colours(), zip);
    write(folder, "names.vdb",
          {one_voxel("density", 1), one_voxel("density", 2), one_voxel("density", 3)}, zip);
    write(folder, "values.vdb", bad_values(), zip);
    write(folder, "odd.vdb", odd_values(), zip);
    write(folder, "said.vdb", said_of_grids(), zip);
    write(folder, "flows.vdb", flows(), zip);
    write(folder, "bad_flows.vdb", bad_flows(), zip);
    write(folder, "frustum.vdb", frustum(), zip);
    write(folder, "sizes.vdb", sizes(), zip);
    write(folder, "empty.vdb", empty(), zip);
    write(folder, "level_set.vdb", level_set(), zip);
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 2) {
        std::fprintf(stderr, "usage: make_test_vdb FOLDER\n");
        return 2;
    }
    try {
        write_all(argv[1]);
    } catch (const std::exception &e) {
        std::fprintf(stderr, "make_test_vdb: %s: %s\n", argv[1], e.what());
        return 1;
    }
    return 0;
}
