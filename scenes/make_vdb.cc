/* make_vdb FILE: writes the cloud of the shipped scenes, the same bytes of density every time.
 *
 * 128 x 96 x 128 voxels over [-1,1] x [-0.75,0.75] x [-1,1], grid "density", halves, values 0..1:
 * an ellipsoid whose skin is pushed in and out by a ridged multifractal (Musgrave, in Ebert et al.,
 * Texturing & Modeling, 3rd ed., chapter 16) over gradient noise (Perlin, Improving Noise, 2002,
 * with a hash in place of the permutation table). */
#pragma GCC visibility push(default) /* as in render/load/vdb_import.cc */
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>
#pragma GCC visibility pop

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>

namespace
{

constexpr int size[3] = {128, 96, 128};
constexpr double voxel = 2.0 / 128;

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

void write(const char *path)
{
    openvdb::initialize();
    auto grid = openvdb::FloatGrid::create(0.0f);
    auto accessor = grid->getAccessor();
    for (int k = 0; k < size[2]; k++) {
        for (int j = 0; j < size[1]; j++) {
            for (int i = 0; i < size[0]; i++) {
                openvdb::Coord at(i - size[0] / 2, j - size[1] / 2, k - size[2] / 2);
                double d =
                    density((at.x() + 0.5) * voxel, (at.y() + 0.5) * voxel, (at.z() + 0.5) * voxel);
                if (d > 1e-3)
                    accessor.setValueOn(at, float(d));
            }
        }
    }
    auto map = openvdb::math::Transform::createLinearTransform(voxel);
    /* values sit at voxel centres, which lie at whole indices */
    map->postTranslate(openvdb::Vec3d(0.5 * voxel));
    grid->setTransform(map);
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setSaveFloatAsHalf(true);
    openvdb::tools::prune(grid->tree());
    openvdb::io::File file(path);
    file.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC);
    file.write({grid});
    file.close();
    forget_id(path);
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 2) {
        std::fprintf(stderr, "usage: make_vdb FILE\n");
        return 2;
    }
    try {
        write(argv[1]);
    } catch (const std::exception &e) {
        std::fprintf(stderr, "make_vdb: %s: %s\n", argv[1], e.what());
        return 1;
    }
    return 0;
}
