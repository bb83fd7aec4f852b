/* make_vdb FILE cloud|fire: writes a volume of the shipped scenes, the same bytes every time.
 *
 * cloud: 128 x 96 x 128 voxels over [-1,1] x [-0.75,0.75] x [-1,1], grid "density", halves, values
 * 0..1: an ellipsoid whose skin is pushed in and out by a ridged multifractal (Musgrave, in Ebert
 * et al., Texturing & Modeling, 3rd ed., chapter 16) over gradient noise (Perlin, Improving Noise,
 * 2002, with a hash in place of the permutation table).
 *
 * fire: 72 x 128 x 72 voxels over [-0.5625,0.5625] x [0,2] x [-0.5625,0.5625], grids "temperature"
 * and "density", halves, values 0..1: tongues that the same noise, drawn out along y, cuts from a
 * teardrop and bends the more the higher they are; smoke where they end. */
#pragma GCC visibility push(default) /* as in render/import/scene/vdb_import.cc */
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>
#pragma GCC visibility pop

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>

namespace
{

/* Steele et al., Fast Splittable Pseudorandom Number Generators (2014), finalizer. */
uint64_t mix(uint64_t v)
{
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

/* Dot product of the offset with the gradient of a lattice point: one of the twelve edges of a
 * cube. */
double gradient(int64_t x, int64_t y, int64_t z, double dx, double dy, double dz)
{
    uint64_t h = mix(uint64_t(x) * 0x9e3779b97f4a7c15u ^
                     mix(uint64_t(y) * 0xd1b54a32d192ed03u ^ mix(uint64_t(z) + 17)));
    double a = h & 1 ? 1 : -1, b = h & 2 ? 1 : -1;
    switch ((h >> 2) % 3) {
    case 0:
        return a * dx + b * dy;
    case 1:
        return a * dy + b * dz;
    default:
        return a * dz + b * dx;
    }
}

double fade(double t)
{
    return t * t * t * (t * (t * 6 - 15) + 10);
}

double lerp(double a, double b, double t)
{
    return a + t * (b - a);
}

/* About -1..1. */
double noise(double x, double y, double z)
{
    double fx = std::floor(x), fy = std::floor(y), fz = std::floor(z);
    double dx = x - fx, dy = y - fy, dz = z - fz;
    double plane[2];
    for (int k = 0; k < 2; k++) {
        double row[2];
        for (int j = 0; j < 2; j++) {
            double left =
                gradient(int64_t(fx), int64_t(fy) + j, int64_t(fz) + k, dx, dy - j, dz - k);
            double right =
                gradient(int64_t(fx) + 1, int64_t(fy) + j, int64_t(fz) + k, dx - 1, dy - j, dz - k);
            row[j] = lerp(left, right, fade(dx));
        }
        plane[k] = lerp(row[0], row[1], fade(dy));
    }
    return lerp(plane[0], plane[1], fade(dz));
}

/* 0..about 1.3. */
double ridged(double x, double y, double z)
{
    constexpr int octaves = 6;
    constexpr double lacunarity = 2.03, gain = 2.0, offset = 1.0;
    double sum = 0, weight = 1, amplitude = 0.5;
    for (int i = 0; i < octaves; i++) {
        double signal = offset - std::fabs(noise(x, y, z));
        signal *= signal * weight;
        weight = std::fmin(std::fmax(signal * gain, 0.0), 1.0);
        sum += signal * amplitude;
        amplitude *= 0.5;
        x = x * lacunarity + 11.3;
        y = y * lacunarity - 5.7;
        z = z * lacunarity + 3.1;
    }
    return sum;
}

/* Density at a point of [-1,1]^3 scaled by the box. */
double density(double x, double y, double z)
{
    double ellipsoid = 1 - std::sqrt(x * x / 0.64 + y * y / 0.3 + z * z / 0.64);
    double puff = noise(2.1 * x + 4.2, 2.1 * y - 1.3, 2.1 * z + 7.7);
    double skin = ellipsoid + 0.45 * puff + 0.9 * (ridged(1.7 * x + 9.1, 1.7 * y, 1.7 * z) - 0.72);
    double inside = std::fmin(std::fmax(skin / 0.35, 0.0), 1.0);
    double edge = std::fmax(std::fabs(x), std::fmax(std::fabs(y) / 0.75, std::fabs(z)));
    double frame = std::fmin(std::fmax((1 - edge) / 0.1, 0.0), 1.0);
    return inside * frame;
}

/* Every file gets an id of its own when it is written, in the 36 characters behind the numbers of
 * the format and the library: one for all, so that the same cloud is the same bytes. */
void forget_id(const char *path)
{
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(8 + 3 * 4 + 1);
    file << "00000000-0000-4000-8000-000000000000";
    if (!file.flush())
        throw std::runtime_error("cannot be written");
}

double clamp(double x)
{
    return std::fmin(std::fmax(x, 0.0), 1.0);
}

/* What is left of a value at the sides of the fire's box. */
double within(double x, double y, double z)
{
    double edge = std::fmax(std::fabs(x), std::fabs(z)) / 0.5625;
    return clamp((1 - edge) / 0.1) * clamp((2 - y) / 0.2) * clamp(y / 0.03);
}

/* How hot the fire is: y its height, 0..2. */
double temperature(double x, double y, double z)
{
    double sway = 0.2 * y;
    double bent_x = x + sway * noise(1.3 * x + 3.1, 1.5 * y - 2.7, 1.3 * z + 0.4) +
                    0.25 * sway * noise(5 * x, 3 * y, 5 * z + 5.5),
           bent_z = z + sway * noise(1.3 * x - 8.2, 1.5 * y + 6.1, 1.3 * z + 4.9) +
                    0.25 * sway * noise(5 * x + 2.2, 3 * y, 5 * z);
    double width = 0.56 * std::pow(clamp(y / 0.4), 0.4) * std::pow(clamp((1.9 - y) / 1.9), 0.8);
    double r = std::sqrt(bent_x * bent_x + bent_z * bent_z);
    double inside = width > 0 ? 1 - r / width : -1;
    double tongues = ridged(2.6 * bent_x + 1.7, 0.9 * y - 3.3, 2.6 * bent_z + 6.2) - 0.74;
    double hot = inside + (1.1 + 1.3 * clamp(y / 1.1)) * tongues - 0.1 * y;
    return clamp(1.1 * hot) * within(x, y, z);
}

double smoke(double x, double y, double z)
{
    double sway = 0.25 * y, bent_x = x + sway * noise(1.1 * x + 5.3, 1.2 * y, 1.1 * z - 1.9),
           bent_z = z + sway * noise(1.1 * x, 1.2 * y + 9.4, 1.1 * z + 2.2);
    double r = std::sqrt(bent_x * bent_x + bent_z * bent_z) / (0.16 + 0.1 * y);
    double puff = ridged(2.4 * bent_x - 4.4, 1.6 * y + 2.8, 2.4 * bent_z) - 0.7;
    return clamp(1.2 * (1 - r + 1.3 * puff)) * clamp((y - 0.9) / 0.6) * within(x, y, z);
}

using field = double (*)(double x, double y, double z);

/* first: of the box's voxels. */
openvdb::GridBase::Ptr make(const char *name, field value, const openvdb::Coord &size,
                            const openvdb::Coord &first, double voxel)
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    auto accessor = grid->getAccessor();
    for (int k = 0; k < size.z(); k++) {
        for (int j = 0; j < size.y(); j++) {
            for (int i = 0; i < size.x(); i++) {
                openvdb::Coord at = first.offsetBy(i, j, k);
                double d =
                    value((at.x() + 0.5) * voxel, (at.y() + 0.5) * voxel, (at.z() + 0.5) * voxel);
                if (d > 1e-3)
                    accessor.setValueOn(at, float(d));
            }
        }
    }
    auto map = openvdb::math::Transform::createLinearTransform(voxel);
    /* values sit at voxel centres, which lie at whole indices */
    map->postTranslate(openvdb::Vec3d(0.5 * voxel));
    grid->setTransform(map);
    grid->setName(name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setSaveFloatAsHalf(true);
    openvdb::tools::prune(grid->tree());
    return grid;
}

openvdb::GridPtrVec grids_of(const std::string &what)
{
    if (what == "cloud")
        return {make("density", density, {128, 96, 128}, {-64, -48, -64}, 2.0 / 128)};
    if (what == "fire")
        return {make("temperature", temperature, {72, 128, 72}, {-36, 0, -36}, 2.0 / 128),
                make("density", smoke, {72, 128, 72}, {-36, 0, -36}, 2.0 / 128)};
    throw std::runtime_error("cloud or fire?");
}

void write(const char *path, const char *what)
{
    openvdb::initialize();
    openvdb::io::File file(path);
    file.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC);
    file.write(grids_of(what));
    file.close();
    forget_id(path);
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 3) {
        std::fprintf(stderr, "usage: make_vdb FILE cloud|fire\n");
        return 2;
    }
    try {
        write(argv[1], argv[2]);
    } catch (const std::exception &e) {
        std::fprintf(stderr, "make_vdb: %s: %s\n", argv[1], e.what());
        return 1;
    }
    return 0;
}
