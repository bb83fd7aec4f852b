#include "render/import/reader/vdb_read.h"

/* OpenVDB's templates keep state in static members that this program and the library must share;
 * hidden, they would be two, and openvdb::initialize would dereference the one that nobody filled.
 */
#pragma GCC visibility push(default)
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetUtil.h>
#pragma GCC visibility pop

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ext/stdio_filebuf.h>
#include <istream>
#include <string>
#include <unistd.h>
#include <vector>

namespace
{

using openvdb::Coord;
using openvdb::CoordBBox;

/* What all steps need to know, and where they report. */
struct Import {
    const char *name;
    lf_error *err;
    bool is_velocity = false;
    int face = -1; /* of vectors on faces of voxels: the axis whose component this is */
    lf_grid *grid = nullptr;

    ~Import()
    {
        lf_grid_unref(grid);
    }

    lf_status fail(lf_status status, const std::string &what) const
    {
        return lf_error_set(err, status, "", "%s", what.c_str());
    }

    /* What building the bricks said, about this file. */
    lf_status fail(const lf_error &inner) const
    {
        return fail(inner.status, std::string("grid ") + name + ": " + inner.what);
    }
};

struct Box {
    int first[3], last[3];
};

Box to_box(const CoordBBox &bbox, const Coord &origin)
{
    Box box;
    for (int i = 0; i < 3; i++) {
        box.first[i] = bbox.min()[i] - origin[i];
        box.last[i] = bbox.max()[i] - origin[i];
    }
    return box;
}

/* openvdb::io::File, but of a file that is open already: that one opens by name, which a reader may
 * not. */
class OpenFile : public openvdb::io::Archive
{
  public:
    explicit OpenFile(int fd) : buffer(fd, std::ios::in | std::ios::binary), in(&buffer)
    {
        in.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
        readHeader(in);
        openvdb::io::setStreamMetadataPtr(in, said, false);
        setFormatVersion(in);
        setLibraryVersion(in);
        setDataCompression(in);
        meta.readMeta(in);
        int32_t n = readGridCount(in);
        for (int32_t i = 0; i < n; i++) {
            Entry entry;
            entry.grid = entry.descriptor.read(in);
            if (inputHasGridOffsets())
                entry.descriptor.seekToEnd(in);
            else
                readGrid(entry.grid, entry.descriptor, in);
            entries.push_back(entry);
        }
    }

    struct Entry {
        openvdb::io::GridDescriptor descriptor;
        openvdb::GridBase::Ptr grid; /* empty yet where the file tells where each lies */
    };

    void fill(Entry &entry)
    {
        if (!inputHasGridOffsets())
            return;
        entry.descriptor.seekToGrid(in);
        readGrid(entry.grid, entry.descriptor, in);
    }

    /* The grid with its voxels; shared ones are another grid's. */
    openvdb::GridBase::Ptr load(Entry &entry)
    {
        fill(entry);
        if (!entry.descriptor.isInstance())
            return entry.grid;
        NamedGridMap parents{{entry.descriptor.uniqueName(), entry.grid}};
        for (Entry &other : entries)
            if (other.descriptor.uniqueName() == entry.descriptor.instanceParentName()) {
                fill(other);
                parents[other.descriptor.uniqueName()] = other.grid;
            }
        connectInstance(entry.descriptor, parents);
        return entry.grid;
    }

    std::vector<Entry> entries;

  private:
    __gnu_cxx::stdio_filebuf<char> buffer;
    /* the stream keeps the pointer's address */
    openvdb::SharedPtr<openvdb::io::StreamMetadata> said{new openvdb::io::StreamMetadata};
    std::istream in;
    openvdb::MetaMap meta;
};

std::string name_of(const OpenFile::Entry &entry)
{
    return openvdb::io::GridDescriptor::nameAsString(entry.descriptor.uniqueName());
}

/* "density (float), velocity (vec3s)" */
std::string list_grids(const OpenFile &file)
{
    std::string list;
    for (const auto &entry : file.entries) {
        if (list.size() > 300)
            return list + ", …";
        list += (list.empty() ? "" : ", ") + name_of(entry) + " (" + entry.grid->valueType() + ")";
    }
    return list.empty() ? "no grids at all" : list;
}

/* A plain name means the first of that name. */
OpenFile::Entry *find_grid(OpenFile &file, const std::string &wanted)
{
    for (auto &entry : file.entries)
        if (name_of(entry) == wanted || name_of(entry) == wanted + "[0]")
            return &entry;
    return nullptr;
}

/* "Cd.x": "Cd", and which component of it; else "". */
std::string split_component(const std::string &wanted, int *out_component)
{
    const size_t n = wanted.size();
    const size_t at =
        n > 2 && wanted[n - 2] == '.' ? std::string("xyz").find(wanted[n - 1]) : std::string::npos;
    *out_component = int(at);
    return at == std::string::npos ? "" : wanted.substr(0, n - 2);
}

/* The grid of vectors and which component of them a name means; NULL: no such thing. */
OpenFile::Entry *find_component(OpenFile &file, const std::string &wanted, int *out_component)
{
    const std::string vectors = split_component(wanted, out_component);
    OpenFile::Entry *entry = vectors.empty() ? nullptr : find_grid(file, vectors);
    return entry && (entry->grid->isType<openvdb::Vec3SGrid>() ||
                     entry->grid->isType<openvdb::Vec3DGrid>())
               ? entry
               : nullptr;
}

/* What was looked for, in words of who may have typed the name of vectors alone. */
std::string say_missing(const Import &import, OpenFile &file)
{
    const std::string wanted = import.name, holds = "; the file has " + list_grids(file);
    int component = 0;
    const std::string vectors = split_component(wanted, &component);
    if (vectors.empty())
        return "no grid \"" + wanted + "\"" + holds;
    const OpenFile::Entry *scalars = find_grid(file, vectors);
    if (!import.is_velocity)
        return "no grid \"" + wanted + "\", nor a vector grid \"" + vectors + "\"" + holds;
    const std::string nor =
        component == 0 ? "\"" + vectors + ".x\", \".y\", \".z\"" : "\"" + wanted + "\"";
    if (scalars)
        return "grid \"" + vectors + "\" is not a vector grid, but " + scalars->grid->valueType() +
               " (and no " + nor + ")" + holds;
    return "no vector grid \"" + vectors + "\" (nor " + nor + ")" + holds;
}

template <typename Vectors>
openvdb::FloatGrid::Ptr component_of(const Vectors &vectors, int component)
{
    openvdb::FloatTree::Ptr tree(
        new openvdb::FloatTree(vectors.tree(), 0.0f, openvdb::TopologyCopy()));
    auto grid = openvdb::FloatGrid::create(tree);
    auto from = vectors.getConstAccessor();
    grid->setTransform(vectors.transform().copy());
    for (auto value = grid->beginValueOn(); value; ++value)
        value.setValue(float(from.getValue(value.getCoord())[component]));
    return grid;
}

/* All but one, each with a newline behind it; not without end. */
std::string other_grids(const OpenFile &file, const OpenFile::Entry *one)
{
    std::string list;
    for (const auto &entry : file.entries)
        if (&entry != one && list.size() < 2048)
            list += name_of(entry) + "\n";
    return list;
}

/* What the values are. */
struct Values {
    lf_grid_odd odd = {0, 0, 0, 0, 0};
    double n = 0, most = 0;
};

template <typename Tree> Values look_at(const Import &import, const Tree &tree)
{
    Values values;
    for (auto value = tree.cbeginValueOn(); value; ++value) {
        const double v = double(*value), n = double(value.getVoxelCount());
        values.n += n;
        if (!std::isfinite(float(v))) {
            values.odd.n_not_finite += n;
        } else if (v < 0 && !import.is_velocity) {
            values.odd.n_negative += n;
            values.odd.least = std::min(values.odd.least, v);
        } else {
            values.most = std::max(values.most, v);
        }
    }
    return values;
}

/* Filters that resample ring a little below 0, at few voxels or by little; signed distances are
 * negative everywhere inside. */
bool looks_signed(const Values &values)
{
    return values.odd.n_negative > 0.1 * values.n && -values.odd.least > 0.1 * values.most;
}

lf_status refuse_signed(const Import &import, const Values &values)
{
    char what[512];
    std::snprintf(what, sizeof what,
                  "grid %s is negative in %.0f of %.0f active voxels (down to %g); set its class "
                  "to \"level set\", or convert it to fog",
                  import.name, values.odd.n_negative, values.n, values.odd.least);
    return import.fail(LF_E_FORMAT, what);
}

/* Whether a value is anything: an odd one is 0. */
template <typename Value> bool counts(const Import &import, Value value)
{
    return (value > 0 || (value < 0 && import.is_velocity)) && std::isfinite(float(value));
}

/* Box of everything but 0, tiles included. */
template <typename Tree> CoordBBox support(const Import &import, const Tree &tree)
{
    CoordBBox all;
    for (auto value = tree.cbeginValueOn(); value; ++value) {
        if (!counts(import, *value))
            continue;
        CoordBBox box;
        value.getBoundingBox(box);
        all.expand(box);
    }
    return all;
}

/* Row-major 3x4 of the grid's own map behind a shift by the voxel at our index 0. */
bool affine_map(const openvdb::GridBase &grid, const Coord &origin, double out[12])
{
    if (!grid.transform().isLinear())
        return false;
    /* row vectors: x' = x m */
    openvdb::Mat4R m = grid.transform().baseMap()->getAffineMap()->getMat4();
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            out[4 * i + j] = m(j, i);
        out[4 * i + 3] =
            m(3, i) + m(0, i) * origin.x() + m(1, i) * origin.y() + m(2, i) * origin.z();
    }
    return true;
}

/* Components that sit on faces of voxels, half a voxel before their middles. */
void move_to_faces(int axis, double map[12])
{
    for (int i = 0; i < 3; i++)
        map[4 * i + 3] -= 0.5 * map[4 * i + axis];
}

template <typename Tree> lf_status fill(Import &import, const Tree &tree, const Coord &origin)
{
    for (auto value = tree.cbeginValueOn(); value; ++value) {
        CoordBBox bbox;
        value.getBoundingBox(bbox);
        Box box = to_box(bbox, origin);
        if (counts(import, *value))
            lf_grid_mark(import.grid, box.first, box.last);
    }
    lf_error problem;
    if (lf_grid_allocate(import.grid, &problem) != LF_OK)
        return import.fail(problem);
    for (auto value = tree.cbeginValueOn(); value; ++value) {
        CoordBBox bbox;
        value.getBoundingBox(bbox);
        Box box = to_box(bbox, origin);
        if (counts(import, *value))
            lf_grid_fill(import.grid, box.first, box.last, float(*value));
    }
    return LF_OK;
}

template <typename Grid> lf_status convert(Import &import, const Grid &grid)
{
    Values values = look_at(import, grid.tree());
    if (!import.is_velocity)
        values.odd.background = double(grid.background());
    if (looks_signed(values))
        return refuse_signed(import, values);
    CoordBBox box = support(import, grid.tree());
    /* Big active tiles cost nothing in the file; find out before anything is made of them. */
    if (grid.activeVoxelCount() > LF_GRID_MAX_BYTES / sizeof(float))
        return import.fail(LF_E_NOMEM, std::string("grid ") + import.name + " has " +
                                           std::to_string(grid.activeVoxelCount()) +
                                           " active voxels, which do not fit into " +
                                           std::to_string(LF_GRID_MAX_BYTES >> 30) + " GiB");
    if (box.empty())
        box = CoordBBox(Coord(0), Coord(0));
    double local_to_file[12];
    if (!affine_map(grid, box.min(), local_to_file))
        return import.fail(LF_E_FORMAT,
                           std::string("grid ") + import.name +
                               " has a frustum or another transform that is not affine");
    if (import.face >= 0)
        move_to_faces(import.face, local_to_file);
    int64_t size[3];
    for (int i = 0; i < 3; i++)
        size[i] = int64_t(box.max()[i]) - box.min()[i] + 1;
    lf_error problem;
    if (lf_grid_create(size, local_to_file, &import.grid, &problem) != LF_OK)
        return import.fail(problem);
    lf_grid_set_odd(import.grid, &values.odd);
    return fill(import, grid.tree(), box.min());
}

/* Level sets become fog first. */
template <typename Grid> lf_status convert_any_class(Import &import, const typename Grid::Ptr &grid)
{
    if (grid->getGridClass() != openvdb::GRID_LEVEL_SET || import.is_velocity)
        return convert(import, *grid);
    openvdb::tools::sdfToFogVolume(*grid);
    return convert(import, *grid);
}

lf_status keep_others(const Import &import, const OpenFile &file, const OpenFile::Entry *one)
{
    if (lf_grid_set_others(import.grid, other_grids(file, one).c_str()) != LF_OK)
        return import.fail(LF_E_NOMEM, "out of memory");
    return LF_OK;
}

lf_status import_from(Import &import, int fd)
{
    OpenFile file(dup(fd));
    int component = 0;
    OpenFile::Entry *entry = find_grid(file, import.name),
                    *vectors = entry ? nullptr : find_component(file, import.name, &component);
    if (vectors) {
        openvdb::GridBase::Ptr loaded = file.load(*vectors);
        auto single = openvdb::gridPtrCast<openvdb::Vec3SGrid>(loaded);
        if (import.is_velocity && loaded->getGridClass() == openvdb::GRID_STAGGERED)
            import.face = component;
        lf_status status = convert(
            import,
            single ? *component_of(*single, component)
                   : *component_of(*openvdb::gridPtrCast<openvdb::Vec3DGrid>(loaded), component));
        return status == LF_OK ? keep_others(import, file, vectors) : status;
    }
    if (!entry)
        return import.fail(LF_E_FORMAT, say_missing(import, file));
    if (!entry->grid->isType<openvdb::FloatGrid>() && !entry->grid->isType<openvdb::DoubleGrid>())
        return import.fail(
            LF_E_FORMAT,
            std::string("grid \"") + import.name + "\" is of type " + entry->grid->type() +
                (import.is_velocity ? "; a component of a velocity is " : "; a density is ") +
                "float, half or double; the file has " + list_grids(file));
    openvdb::GridBase::Ptr grid = file.load(*entry);
    auto single = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
    lf_status status = single ? convert_any_class<openvdb::FloatGrid>(import, single)
                              : convert_any_class<openvdb::DoubleGrid>(
                                    import, openvdb::gridPtrCast<openvdb::DoubleGrid>(grid));
    return status == LF_OK ? keep_others(import, file, entry) : status;
}

} // namespace

void lf_vdb_begin()
{
    openvdb::initialize();
}

/* What a reader does, with its exceptions as errors. */
template <typename Work> static lf_status guarded(lf_error *err, Work work)
{
    try {
        return work();
    } catch (const std::bad_alloc &) {
        return lf_error_set(err, LF_E_NOMEM, "", LF_READER_NOMEM);
    } catch (const std::ios_base::failure &) {
        return lf_error_set(err, LF_E_FORMAT, "",
                            "cannot be read as OpenVDB: the file ends too early");
    } catch (const std::exception &e) {
        return lf_error_set(err, LF_E_FORMAT, "", "cannot be read as OpenVDB: %s", e.what());
    } catch (...) {
        return lf_error_set(err, LF_E_FORMAT, "", "cannot be read as OpenVDB");
    }
}

lf_status lf_vdb_read(int fd, const char *name, bool is_velocity, lf_grid **out_grid, lf_error *err)
{
    return guarded(
        err,
        [&] {
            Import import{name, err, is_velocity};
            lf_status status = import_from(import, fd);
            if (status == LF_OK) {
                *out_grid = import.grid;
                import.grid = nullptr;
            }
            return status;
        });
}

lf_status lf_vdb_list(int fd, char *out, size_t size, lf_error *err)
{
    return guarded(
        err,
        [&] {
            OpenFile file(dup(fd));
            std::string list;
            for (const auto &entry : file.entries) {
                const std::string name = name_of(entry) + "\n";
                if ((entry.grid->isType<openvdb::FloatGrid>() ||
                     entry.grid->isType<openvdb::DoubleGrid>()) &&
                    list.size() + name.size() < size)
                    list += name;
            }
            std::snprintf(out, size, "%s", list.c_str());
            return LF_OK;
        });
}
