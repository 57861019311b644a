#include "tests/support/compressed_gltf.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

namespace pathfit::tests {
namespace {

using Json = nlohmann::json;

std::uint32_t WordAt(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, 4);
  return word;
}

struct Glb {
  Json json;
  std::string binary;

  explicit Glb(const std::string& bytes) {
    const std::size_t size = WordAt(bytes, 12);
    json = Json::parse(bytes.substr(20, size));
    binary = bytes.substr(28 + size);
  }

  [[nodiscard]] std::string BytesOfView(std::size_t view) const {
    const Json& v = json["bufferViews"][view];
    return binary.substr(v.value("byteOffset", std::size_t{0}), v["byteLength"]);
  }

  [[nodiscard]] std::string Bytes() const {
    std::string text = json.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string data = binary;
    data.resize((data.size() + 3) / 4 * 4, '\0');
    std::string bytes = "glTF";
    const auto put = [&bytes](std::size_t word) {
      for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(word >> shift);
    };
    put(2);
    put(28 + text.size() + data.size());
    put(text.size());
    bytes += "JSON" + text;
    put(data.size());
    return bytes + std::string("BIN\0", 4) + data;
  }
};

std::size_t Append(std::string& binary, const std::string& bytes) {
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  const std::size_t at = binary.size();
  binary += bytes;
  return at;
}

template <class T>
std::vector<T> Values(const std::string& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

std::string Text(const std::vector<unsigned char>& bytes) { return {bytes.begin(), bytes.end()}; }

/// x, y, z and a zero for each vector of three.
std::vector<float> Fours(const std::vector<float>& threes) {
  std::vector<float> fours;
  for (std::size_t i = 0; i < threes.size(); ++i) {
    fours.push_back(threes[i]);
    if (i % 3 == 2) fours.push_back(0.0F);
  }
  return fours;
}

}  // namespace

std::string WithMeshopt(const std::string& glb, bool filtered) {
  Glb file(glb);
  std::string packed;
  std::vector<std::string> old;
  for (std::size_t i = 0; i < file.json["bufferViews"].size(); ++i) {
    old.push_back(file.BytesOfView(i));
  }
  std::vector<bool> is_done(old.size(), false);
  std::size_t raw_size = 0;
  for (Json& accessor : file.json["accessors"]) {
    const std::size_t view_index = accessor["bufferView"];
    is_done[view_index] = true;
    Json& view = file.json["bufferViews"][view_index];
    const std::string bytes = old[view_index];
    const std::size_t count = accessor["count"];
    std::size_t stride = bytes.size() / count;
    Json by = {{"buffer", 0}, {"count", count}};
    std::vector<unsigned char> encoded;
    if (accessor["type"] == "SCALAR") {
      const auto indices = Values<unsigned int>(bytes);
      by["mode"] = filtered ? "INDICES" : "TRIANGLES";
      encoded.resize(filtered ? meshopt_encodeIndexSequenceBound(count, count)
                              : meshopt_encodeIndexBufferBound(count, count));
      encoded.resize(
          filtered
              ? meshopt_encodeIndexSequence(encoded.data(), encoded.size(), indices.data(), count)
              : meshopt_encodeIndexBuffer(encoded.data(), encoded.size(), indices.data(), count));
    } else {
      by["mode"] = "ATTRIBUTES";
      std::string values = bytes;
      if (filtered) {
        const auto numbers = Values<float>(bytes);
        const bool is_normal = &accessor != &file.json["accessors"][0] && stride == 12;
        by["filter"] = is_normal ? "OCTAHEDRAL" : "EXPONENTIAL";
        if (is_normal) {
          stride = 8;
          accessor["componentType"] = 5122;
          accessor["normalized"] = true;
          values.assign(count * stride, '\0');
          meshopt_encodeFilterOct(values.data(), count, stride, 16, Fours(numbers).data());
        } else {
          meshopt_encodeFilterExp(values.data(), count, stride, 15, numbers.data());
        }
      }
      encoded.resize(meshopt_encodeVertexBufferBound(count, stride));
      encoded.resize(
          meshopt_encodeVertexBuffer(encoded.data(), encoded.size(), values.data(), count, stride));
      view["byteStride"] = stride;
    }
    by["byteStride"] = stride;
    by["byteLength"] = encoded.size();
    by["byteOffset"] = Append(packed, Text(encoded));
    view["extensions"]["EXT_meshopt_compression"] = by;
    view["buffer"] = 1;
    view["byteOffset"] = raw_size;
    view["byteLength"] = count * stride;
    raw_size += (count * stride + 3) / 4 * 4;
  }
  for (std::size_t i = 0; i < old.size(); ++i) {
    if (!is_done[i]) file.json["bufferViews"][i]["byteOffset"] = Append(packed, old[i]);
  }
  file.binary = packed;
  file.json["buffers"] = {{{"byteLength", packed.size()}},
                          {{"byteLength", raw_size},
                           {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  file.json["extensionsUsed"].push_back("EXT_meshopt_compression");
  file.json["extensionsRequired"].push_back("EXT_meshopt_compression");
  return file.Bytes();
}

std::string WithDraco(const std::string& glb, int bits) {
  Glb file(glb);
  for (Json& mesh : file.json["meshes"]) {
    for (Json& primitive : mesh["primitives"]) {
      draco::Mesh packed;
      const auto of = [&](const Json& index) {
        const Json& accessor = file.json["accessors"][index.get<std::size_t>()];
        return std::pair(file.BytesOfView(accessor["bufferView"]), accessor["count"].get<int>());
      };
      const auto corners = Values<std::uint32_t>(of(primitive["indices"]).first);
      packed.SetNumFaces(corners.size() / 3);
      for (std::uint32_t f = 0; f < corners.size() / 3; ++f) {
        const std::uint32_t* c = &corners[std::size_t{3} * f];
        packed.SetFace(draco::FaceIndex(f),
                       {draco::PointIndex(c[0]), draco::PointIndex(c[1]), draco::PointIndex(c[2])});
      }
      Json ids = Json::object();
      std::vector<int> quantized;
      for (const auto& [name, index] : primitive["attributes"].items()) {
        const auto [bytes, count] = of(index);
        packed.set_num_points(static_cast<std::uint32_t>(count));
        const auto kind = name == "POSITION"     ? draco::GeometryAttribute::POSITION
                          : name == "NORMAL"     ? draco::GeometryAttribute::NORMAL
                          : name == "TEXCOORD_0" ? draco::GeometryAttribute::TEX_COORD
                                                 : draco::GeometryAttribute::GENERIC;
        const std::size_t stride = bytes.size() / static_cast<std::size_t>(count);
        draco::PointAttribute attribute;
        attribute.Init(kind,
                       static_cast<std::int8_t>(stride / 4),
                       draco::DT_FLOAT32,
                       false,
                       static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i) {
          attribute.SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(i)),
                                      bytes.data() + stride * static_cast<std::size_t>(i));
        }
        attribute.SetIdentityMapping();
        const int id =
            packed.AddAttribute(std::make_unique<draco::PointAttribute>(std::move(attribute)));
        ids[name] = packed.attribute(id)->unique_id();
        quantized.push_back(id);
      }
      draco::ExpertEncoder encoder(packed);
      encoder.SetTrackEncodedProperties(true);
      encoder.SetEncodingMethod(bits > 0 ? draco::MESH_EDGEBREAKER_ENCODING
                                         : draco::MESH_SEQUENTIAL_ENCODING);
      if (bits > 0) {
        for (const int id : quantized) encoder.SetAttributeQuantization(id, bits);
      }
      draco::EncoderBuffer buffer;
      if (!encoder.EncodeToBuffer(&buffer).ok()) return "";
      const std::size_t at = Append(file.binary, std::string(buffer.data(), buffer.size()));
      primitive["extensions"]["KHR_draco_mesh_compression"] = {
          {"bufferView", file.json["bufferViews"].size()}, {"attributes", ids}};
      file.json["bufferViews"].push_back(
          {{"buffer", 0}, {"byteOffset", at}, {"byteLength", buffer.size()}});
      // Its order is not that of the file.
      const auto count = [&](const Json& index, std::size_t size) {
        Json& accessor = file.json["accessors"][index.get<std::size_t>()];
        accessor.erase("bufferView");
        accessor["count"] = size;
      };
      count(primitive["indices"], encoder.num_encoded_faces() * 3);
      for (const auto& [name, index] : primitive["attributes"].items()) {
        count(index, encoder.num_encoded_points());
      }
    }
  }
  file.json["buffers"][0]["byteLength"] = file.binary.size();
  file.json["extensionsUsed"].push_back("KHR_draco_mesh_compression");
  file.json["extensionsRequired"].push_back("KHR_draco_mesh_compression");
  return file.Bytes();
}

}  // namespace pathfit::tests
