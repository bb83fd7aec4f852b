#include "render/import/reader/draco_read.h"

#include <cstdlib>
#include <exception>
#include <new>

#include <draco/compression/decode.h>

#include "base/sandbox/reader.h"

namespace
{

lf_status refuse(lf_error *err, const char *what)
{
    return lf_error_set(err, LF_E_FORMAT, LF_HERE, "KHR_draco_mesh_compression: %s", what);
}

lf_status no_memory(lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
}

unsigned type_of(draco::DataType type)
{
    switch (type) {
    case draco::DT_INT8:
        return 5120;
    case draco::DT_UINT8:
        return 5121;
    case draco::DT_INT16:
        return 5122;
    case draco::DT_UINT16:
        return 5123;
    case draco::DT_UINT32:
        return 5125;
    case draco::DT_FLOAT32:
        return 5126;
    default:
        return 0;
    }
}

lf_status copy_triangles(const draco::Mesh &mesh, lf_draco_mesh *out, lf_error *err)
{
    out->n_points = mesh.num_points();
    out->n_triangles = mesh.num_faces();
    out->triangles =
        static_cast<uint32_t *>(std::malloc(3 * out->n_triangles * sizeof(uint32_t) + 1));
    if (!out->triangles)
        return no_memory(err);
    for (size_t t = 0; t < out->n_triangles; t++) {
        const draco::Mesh::Face &face = mesh.face(draco::FaceIndex(static_cast<uint32_t>(t)));
        for (size_t c = 0; c < 3; c++) {
            if (face[c].value() >= out->n_points)
                return refuse(err, "a triangle refers to a missing vertex");
            out->triangles[3 * t + c] = face[c].value();
        }
    }
    return LF_OK;
}

lf_status copy_attribute(const draco::Mesh &mesh, lf_draco_attribute *out, lf_error *err)
{
    const draco::PointAttribute *from = mesh.GetAttributeByUniqueId(out->id);
    out->type = from ? type_of(from->data_type()) : 0;
    if (out->type == 0)
        return refuse(err, "an attribute is missing or has a type that glTF does not have");
    out->components = static_cast<unsigned>(from->num_components());
    out->bytes = out->components * static_cast<unsigned>(draco::DataTypeLength(from->data_type()));
    size_t n = mesh.num_points();
    if (out->components == 0 || from->byte_stride() < static_cast<int64_t>(out->bytes))
        return refuse(err, "an attribute has no components");
    out->data = static_cast<unsigned char *>(std::malloc(n * out->bytes + 1));
    if (!out->data)
        return no_memory(err);
    for (size_t i = 0; i < n; i++) {
        draco::AttributeValueIndex value =
            from->mapped_index(draco::PointIndex(static_cast<uint32_t>(i)));
        if (value.value() >= from->size() ||
            !from->IsAddressValid(from->GetAddress(value) + out->bytes - 1))
            return refuse(err, "an attribute has too few values");
        std::memcpy(out->data + i * out->bytes, from->GetAddress(value), out->bytes);
    }
    return LF_OK;
}

lf_status read(const unsigned char *data, size_t size, size_t most, lf_draco_attribute *attributes,
               size_t n, lf_draco_mesh *out, lf_error *err)
{
    draco::DecoderBuffer buffer;
    draco::Decoder decoder;
    buffer.Init(reinterpret_cast<const char *>(data), size);
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok())
        return refuse(err, decoded.status().error_msg());
    const draco::Mesh &mesh = *decoded.value();
    if (mesh.num_points() == 0 || mesh.num_points() > most || mesh.num_faces() > most)
        return refuse(err, "the mesh has no points, or too many");
    lf_status status = copy_triangles(mesh, out, err);
    for (size_t i = 0; i < n && status == LF_OK; i++)
        status = copy_attribute(mesh, &attributes[i], err);
    return status;
}

} // namespace

lf_status lf_draco_read(const unsigned char *data, size_t size, size_t most,
                        lf_draco_attribute *attributes, size_t n, lf_draco_mesh *out, lf_error *err)
try {
    return read(data, size, most, attributes, n, out, err);
} catch (const std::bad_alloc &) {
    return no_memory(err);
} catch (const std::exception &problem) {
    return refuse(err, problem.what());
}
