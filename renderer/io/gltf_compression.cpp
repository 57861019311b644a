#include "renderer/io/gltf_compression.h"

#include <array>
#include <bit>
#include <cstring>
#include <exception>
#include <utility>

#include <draco/compression/decode.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

using Json = nlohmann::json;

static_assert(std::endian::native == std::endian::little, "decoded numbers stay as they are");

const Json* Member(const Json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}
Json* Member(Json& object, const char* key) {
  return const_cast<Json*>(Member(std::as_const(object), key));
}

Json* ExtensionOf(Json& object, const char* name) {
  Json* extensions = Member(object, "extensions");
  return extensions == nullptr ? nullptr : Member(*extensions, name);
}

template <class Act>
void ForEach(Json& object, const char* key, const Act& act) {
  Json* list = Member(object, key);
  if (list == nullptr || !list->is_array()) return;
  for (Json& item : *list) act(item);
}

void GiveByte(Json& buffer) {
  Json* meshopt = ExtensionOf(buffer, kMeshoptExtension);
  if (meshopt == nullptr || Member(buffer, "uri") != nullptr) return;
  const Json* fallback = Member(*meshopt, "fallback");
  if (fallback == nullptr || *fallback != true) return;
  buffer["uri"] = "data:application/octet-stream;base64,AA==";
  buffer["byteLength"] = 1;
}

void GiveView(Json& primitive, Json& file) {
  const Json* indices = Member(primitive, "indices");
  if (ExtensionOf(primitive, kDracoExtension) == nullptr || indices == nullptr ||
      !indices->is_number_unsigned()) {
    return;
  }
  Json* accessors = Member(file, "accessors");
  const auto index = indices->get<std::size_t>();
  if (accessors == nullptr || !accessors->is_array() || index >= accessors->size() ||
      !(*accessors)[index].is_object()) {
    return;
  }
  (*accessors)[index]["bufferView"] = 0;
}

std::size_t Product(std::size_t a, std::size_t b) {
  std::size_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? SIZE_MAX : product;
}

void Require(bool condition, const std::string& what) {
  if (!condition) throw IoError(what);
}

// The least that a triangle takes cannot be told from Draco's format; whole planes take a hundredth
// of a byte.
constexpr std::size_t kMaxTrianglesPerByte = 1000;

/// Refuses headers that announce another mesh than the file around.
void CheckDracoHeader(std::string_view bytes, std::size_t num_triangles) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  std::array<char, 5> magic{};
  std::uint8_t major = 0, minor = 0, type = 0, method = 0;
  std::uint16_t flags = 0;
  Require(buffer.Decode(magic.data(), magic.size()) && buffer.Decode(&major) &&
              buffer.Decode(&minor) && buffer.Decode(&type) && buffer.Decode(&method) &&
              buffer.Decode(&flags) && std::string_view(magic.data(), magic.size()) == "DRACO",
          "it is no Draco data");
  Require(major == 2 && minor == 2, "its Draco version is not 2.2");
  Require(type == draco::TRIANGULAR_MESH, "its Draco data is no triangle mesh");
  buffer.set_bitstream_version(static_cast<std::uint16_t>(DRACO_BITSTREAM_VERSION(major, minor)));
  if ((flags & METADATA_FLAG_MASK) != 0) {
    draco::GeometryMetadata ignored;
    Require(draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &ignored),
            "its Draco metadata is damaged");
  }
  std::uint32_t vertices = 0, faces = 0;
  bool read = true;
  if (method == draco::MESH_EDGEBREAKER_ENCODING) {
    std::uint8_t traversal = 0;
    read = buffer.Decode(&traversal) && draco::DecodeVarint(&vertices, &buffer) &&
           draco::DecodeVarint(&faces, &buffer);
  } else {
    read = draco::DecodeVarint(&faces, &buffer) && draco::DecodeVarint(&vertices, &buffer);
  }
  Require(read, "its Draco data is cut off");
  Require(faces == num_triangles && vertices <= Product(3, num_triangles),
          "its Draco data has " + std::to_string(faces) + " triangles, its indices are for " +
              std::to_string(num_triangles));
  Require(faces / kMaxTrianglesPerByte <= bytes.size(), "its Draco data is cut off");
}

template <class T>
std::vector<unsigned char> ValuesOf(const draco::PointAttribute& attribute,
                                    std::size_t num_points,
                                    std::size_t components) {
  std::vector<unsigned char> bytes(num_points * components * sizeof(T));
  std::vector<T> one(components);
  for (std::size_t i = 0; i < num_points; ++i) {
    const auto value = attribute.mapped_index(draco::PointIndex(static_cast<std::uint32_t>(i)));
    if (value.value() >= attribute.size() ||
        !attribute.ConvertValue<T>(value, static_cast<std::int8_t>(components), one.data())) {
      return {};
    }
    std::memcpy(bytes.data() + i * components * sizeof(T), one.data(), components * sizeof(T));
  }
  return bytes;
}

}  // namespace

std::string ParsableGltf(std::string_view json) {
  const auto mentions = [&](const char* name) {
    return json.find('"' + std::string(name) + '"') != std::string_view::npos;
  };
  if (!mentions(kMeshoptExtension) && !mentions(kDracoExtension)) return std::string(json);
  Json file = Json::parse(json, nullptr, false);
  if (!file.is_object()) return std::string(json);
  ForEach(file, "buffers", GiveByte);
  ForEach(file, "meshes", [&](Json& mesh) {
    ForEach(mesh, "primitives", [&](Json& primitive) { GiveView(primitive, file); });
  });
  return file.dump();
}

std::vector<unsigned char> DecodeMeshopt(const MeshoptView& view) {
  const auto& [bytes, count, stride, mode, filter] = view;
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  // The least that the format takes: a byte for each triangle or index, two bits for 16 bytes that
  // do not change.
  const bool is_attributes = mode == "ATTRIBUTES";
  const bool is_triangles = mode == "TRIANGLES";
  Require(is_attributes || is_triangles || mode == "INDICES", "there is no mode '" + mode + "'");
  if (is_attributes) {
    Require(stride > 0 && stride % 4 == 0 && stride <= 256, "its byteStride is wrong");
    Require(Product(count, stride) <= Product(64, bytes.size()), "its count is too large");
  } else {
    Require(stride == 2 || stride == 4, "its byteStride is wrong");
    Require(!is_triangles || count % 3 == 0, "its count is not one of whole triangles");
    Require(count / (is_triangles ? 3 : 1) <= bytes.size(), "its count is too large");
  }
  Require(count > 0, "its count is 0");
  const bool is_plain = filter.empty() || filter == "NONE";
  Require(is_plain || is_attributes, "filters are for attributes");
  std::vector<unsigned char> decoded(count * stride);
  const int error =
      is_attributes ? meshopt_decodeVertexBuffer(decoded.data(), count, stride, data, bytes.size())
      : is_triangles
          ? meshopt_decodeIndexBuffer(decoded.data(), count, stride, data, bytes.size())
          : meshopt_decodeIndexSequence(decoded.data(), count, stride, data, bytes.size());
  Require(error == 0, "its compressed bytes are damaged");
  if (filter == "OCTAHEDRAL") {
    Require(stride == 4 || stride == 8, "its byteStride is wrong");
    meshopt_decodeFilterOct(decoded.data(), count, stride);
  } else if (filter == "QUATERNION") {
    Require(stride == 8, "its byteStride is wrong");
    meshopt_decodeFilterQuat(decoded.data(), count, stride);
  } else if (filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(decoded.data(), count, stride);
  } else {
    Require(is_plain, "there is no filter '" + filter + "'");
  }
  return decoded;
}

struct DracoMesh::Decoded {
  std::unique_ptr<draco::Mesh> mesh;
};

DracoMesh::DracoMesh(std::string_view bytes, std::size_t num_triangles) {
  CheckDracoHeader(bytes, num_triangles);
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  std::string problem;
  auto decoded = std::make_shared<Decoded>();
  try {
    draco::Decoder decoder;
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (mesh.ok()) {
      decoded->mesh = std::move(mesh).value();
    } else {
      problem = mesh.status().error_msg_string();
    }
  } catch (const std::exception& error) {
    problem = error.what();
  }
  Require(decoded->mesh != nullptr, "its Draco data is damaged: " + problem);
  const draco::Mesh& mesh = *decoded->mesh;
  Require(mesh.num_faces() == num_triangles && mesh.num_points() <= Product(3, num_triangles),
          "its Draco data is damaged");
  for (draco::FaceIndex i(0); i < mesh.num_faces(); ++i) {
    for (const draco::PointIndex& corner : mesh.face(i)) {
      Require(corner.value() < mesh.num_points(), "its Draco data is damaged");
    }
  }
  decoded_ = std::move(decoded);
}

std::size_t DracoMesh::NumPoints() const { return decoded_->mesh->num_points(); }

std::vector<unsigned char> DracoMesh::Corners() const {
  const draco::Mesh& mesh = *decoded_->mesh;
  std::vector<unsigned char> bytes(12 * std::size_t{mesh.num_faces()});
  unsigned char* to = bytes.data();
  for (draco::FaceIndex i(0); i < mesh.num_faces(); ++i) {
    for (const draco::PointIndex& corner : mesh.face(i)) {
      const std::uint32_t point = corner.value();
      std::memcpy(to, &point, 4);
      to += 4;
    }
  }
  return bytes;
}

std::vector<unsigned char> DracoMesh::Attribute(std::uint32_t id,
                                                int component_type,
                                                std::size_t components) const {
  const draco::PointAttribute* attribute = decoded_->mesh->GetAttributeByUniqueId(id);
  if (attribute == nullptr || attribute->num_components() != static_cast<int>(components))
    return {};
  const std::size_t points = NumPoints();
  switch (component_type) {
    case 5120:
      return ValuesOf<std::int8_t>(*attribute, points, components);
    case 5121:
      return ValuesOf<std::uint8_t>(*attribute, points, components);
    case 5122:
      return ValuesOf<std::int16_t>(*attribute, points, components);
    case 5123:
      return ValuesOf<std::uint16_t>(*attribute, points, components);
    case 5125:
      return ValuesOf<std::uint32_t>(*attribute, points, components);
    case 5126:
      return ValuesOf<float>(*attribute, points, components);
    default:
      return {};
  }
}

}  // namespace pathfit::renderer
