#include "renderer/io/gltf_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <tiny_gltf.h>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/ray.h"
#include "renderer/geometry/tangents.h"
#include "renderer/image/color.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/gltf_compression.h"
#include "renderer/io/gltf_writer.h"
#include "renderer/io/image_file.h"
#include "renderer/io/mesh_assembly.h"

namespace pathfit::renderer {
namespace {

namespace fs = std::filesystem;
using tinygltf::Value;

// The numbers of a small file could ask for more memory than there is.
constexpr std::size_t kMaxElements = std::size_t{1} << 28;  ///< of an accessor
constexpr std::size_t kMaxZeros = std::size_t{1} << 24;     ///< of one without bytes of its own
constexpr std::size_t kMaxTriangles = std::size_t{1} << 27;
constexpr std::size_t kMaxUnpacked = std::size_t{1} << 31;  ///< bytes of all that is compressed
constexpr int kMaxNesting = 200;  ///< of JSON: parts of the parser call themselves

constexpr std::array<std::string_view, 7> kKnownExtensions = {kMeshoptExtension,
                                                              kDracoExtension,
                                                              "KHR_texture_transform",
                                                              "KHR_lights_punctual",
                                                              "KHR_materials_emissive_strength",
                                                              "KHR_materials_specular",
                                                              "KHR_mesh_quantization"};

bool IsKnownExtension(const std::string& name) {
  return std::ranges::find(kKnownExtensions, name) != kKnownExtensions.end();
}

/// What the parser asks the file system for.
struct FileAccess {
  fs::path folder;               ///< of the glTF file, absolute and normal
  std::vector<fs::path> files;   ///< that were read
  std::vector<std::string> far;  ///< that lie elsewhere, as far as they were asked for
};

/// Whether `path`, "FOLDER/URI" as the parser puts it together, may be read.
bool IsReadable(const std::string& path, void* user) {
  auto& access = *static_cast<FileAccess*>(user);
  const std::string folder = access.folder.string() + "/";
  // The parser also looks in the working folder, which has nothing to do with the file.
  if (!path.starts_with(folder)) return false;
  const fs::path inside = fs::path(path).lexically_normal().lexically_relative(access.folder);
  const std::string uri = path.substr(folder.size());
  if (inside.empty() || *inside.begin() == ".." || uri.starts_with('/')) {
    access.far.push_back(uri);
    return false;
  }
  std::error_code error;
  return fs::is_regular_file(path, error);
}

bool ReadBytes(std::vector<unsigned char>* bytes,
               std::string* problem,
               const std::string& path,
               void* user) {
  try {
    const std::string text = ReadWholeFile(path);
    bytes->assign(text.begin(), text.end());
    static_cast<FileAccess*>(user)->files.emplace_back(fs::path(path).lexically_normal());
    return true;
  } catch (const IoError& error) {
    *problem += error.what();
    return false;
  }
}

/// Images stay encoded. Those in buffers are found again by their views: the parser does not check
/// that these fit.
bool KeepEncoded(tinygltf::Image* image,
                 int /*index*/,
                 std::string* /*problem*/,
                 std::string* /*warning*/,
                 int /*width*/,
                 int /*height*/,
                 const unsigned char* bytes,
                 int size,
                 void* /*user*/) {
  if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
  return true;
}

std::uint32_t Uint32At(std::string_view bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[offset + i])) << (8 * i);
  }
  return value;
}

std::string Quoted(const std::string& name) { return name.empty() ? "" : " '" + name + "'"; }

/// "mesh 2 'body'".
template <class Item>
std::string Described(const char* kind, const std::vector<Item>& list, int index) {
  return std::string(kind) + " " + std::to_string(index) +
         Quoted(list[static_cast<std::size_t>(index)].name);
}

/// How a texture's own coordinates follow from a set of the mesh's, v down.
struct UvMap {
  int set = 0;
  Vec2 offset, scale{1.0, 1.0};
  double rotation = 0.0;
  friend bool operator==(const UvMap&, const UvMap&) = default;

  /// Turns counter-clockwise as seen in the picture, as the text of KHR_texture_transform says and
  /// importers do; its listing turns the other way (KhronosGroup/glTF, issue 1563).
  [[nodiscard]] Vec2 Apply(const Vec2& uv) const {
    const double c = std::cos(rotation);
    const double s = std::sin(rotation);
    const Vec2 scaled = {uv.x * scale.x, uv.y * scale.y};
    return {c * scaled.x + s * scaled.y + offset.x, c * scaled.y - s * scaled.x + offset.y};
  }
};

/// A texture as a material uses it.
struct TextureUse {
  int texture = -1;
  UvMap uv;
};

enum class TexelRole { kColor, kRoughness, kMetallic, kNormal };

/// A material while the meshes are read.
struct MaterialPlan {
  std::string where;  ///< "material 2 'skin'"
  Material material;
  Rgb emission;  ///< radiance, or the factor of its texture
  std::optional<TextureUse> base_color, metallic_roughness, emissive, normal;
  UvMap uv;                ///< of the textures that are used
  Vec2 low{1e300, 1e300};  ///< of all UVs of its meshes
  Vec2 high{-1e300, -1e300};
  bool tinted = false;  ///< by vertex colours that are not all white
  int emission_texture = -1;
  int index = -1;  ///< in the scene

  [[nodiscard]] bool HasTextures() const {
    return base_color || metallic_roughness || emissive || normal;
  }
};

class GltfReader {
 public:
  explicit GltfReader(const fs::path& path)
      : path_(path), access_{fs::absolute(path).lexically_normal().parent_path(), {}, {}} {}

  SceneFile Read() {
    const std::string bytes = ReadWholeFile(path_);
    file_.files.push_back(path_);
    Parse(bytes);
    CheckExtensions();
    UnpackViews();
    UnpackPrimitives();
    ReadNodes();
    if (file_.scene.meshes.empty() && file_.scene.emitters.empty() && file_.scene.sensors.empty()) {
      Fail("there is no triangle, light or camera in its scene");
    }
    FinishMaterials();
    AddEmission();
    file_.files.insert(file_.files.end(), access_.files.begin(), access_.files.end());
    return std::move(file_);
  }

 private:
  // What is wrong, and what is left out.

  [[noreturn]] void Fail(const std::string& what) const {
    throw IoError(path_.string() + ": " + what);
  }
  void Require(bool condition, const std::string& where, const std::string& what) const {
    if (!condition) Fail(where + ": " + what);
  }
  void Warn(const std::string& text) {
    if (warned_.insert(text).second) file_.warnings.push_back(path_.string() + ": " + text);
  }
  void WarnUnsupported(const std::string& where, const std::string& what) {
    Warn(where + ": " + what + " is not supported and left out");
  }

  /// The item, which `where` names by its index.
  template <class Item>
  const Item& At(const std::vector<Item>& list,
                 int index,
                 const std::string& where,
                 const char* noun) const {
    if (index < 0 || static_cast<std::size_t>(index) >= list.size()) {
      Fail(where + ": there is no " + noun + " " + std::to_string(index) + "; the file has " +
           std::to_string(list.size()));
    }
    return list[static_cast<std::size_t>(index)];
  }

  // The container, and its JSON.

  void Parse(const std::string& bytes) {
    const bool is_binary = bytes.starts_with("glTF");
    if (bytes.size() > std::numeric_limits<std::uint32_t>::max()) Fail("the file is too large");
    std::string_view container = bytes;
    if (is_binary) container = container.substr(0, CheckBinary(bytes));
    const std::string_view json =
        is_binary ? container.substr(20, Uint32At(container, 12)) : container;
    CheckNesting(json);
    std::string parsable = ParsableGltf(json);
    if (parsable != json) {
      if (is_binary) parsable = WithJson(std::move(parsable), container);
      container = parsable;
    }
    tinygltf::TinyGLTF parser;
    parser.SetImageLoader(KeepEncoded, nullptr);
    parser.SetFsCallbacks({IsReadable,
                           [](const std::string& path, void* /*user*/) { return path; },
                           ReadBytes,
                           nullptr,
                           &access_});
    std::string problem, ignored;
    bool done = false;
    const auto size = static_cast<unsigned int>(container.size());
    const std::string folder = access_.folder.string();
    try {
      done = is_binary ? parser.LoadBinaryFromMemory(
                             &model_,
                             &problem,
                             &ignored,
                             reinterpret_cast<const unsigned char*>(container.data()),
                             size,
                             folder)
                       : parser.LoadASCIIFromString(
                             &model_, &problem, &ignored, container.data(), size, folder);
    } catch (const std::exception& error) {
      problem += error.what();
    }
    // The format allows skins without, which the parser complains about.
    const std::string wrongly = "'inverseBindMatrices' property is missing in Skin.\n";
    for (std::size_t at = 0; (at = problem.find(wrongly)) != std::string::npos;) {
      problem.erase(at, wrongly.size());
    }
    // Some of what is malformed is left out by the parser and mentioned.
    if (done && problem.empty()) return;
    std::ranges::replace(problem, '\n', ' ');
    while (problem.ends_with(' ')) problem.pop_back();
    for (const std::string& uri : access_.far) {
      problem += (problem.empty() ? "" : "; ") + FarMessage(uri);
    }
    Fail("not a glTF file that can be read" + (problem.empty() ? "" : ": " + problem));
  }

  /// The GLB with other JSON in its first chunk.
  static std::string WithJson(std::string json, std::string_view glb) {
    constexpr std::size_t kHeaders = 20;
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::string_view rest = glb.substr(kHeaders + Uint32At(glb, 12));
    std::string bytes(glb.substr(0, kHeaders));
    const auto put = [&bytes](std::size_t at, std::size_t value) {
      for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<char>(value >> (8 * i));
    };
    put(8, kHeaders + json.size() + rest.size());
    put(12, json.size());
    bytes += json;
    return bytes += rest;
  }

  static std::string FarMessage(const std::string& uri) {
    return "'" + uri.substr(0, 200) + "' is outside of the folder of the file";
  }

  /// Size of the container in its file.
  [[nodiscard]] std::size_t CheckBinary(std::string_view bytes) const {
    constexpr std::size_t kHeader = 12;
    constexpr std::size_t kChunkHeader = 8;
    if (bytes.size() < kHeader + kChunkHeader) Fail("cut off: the header of a GLB has 20 bytes");
    if (const std::uint32_t version = Uint32At(bytes, 4); version != 2) {
      Fail("GLB of version " + std::to_string(version) + "; only 2 can be read");
    }
    const std::size_t size = Uint32At(bytes, 8);
    if (size > bytes.size()) {
      Fail("cut off: " + std::to_string(bytes.size()) + " of " + std::to_string(size) +
           " bytes are there");
    }
    int chunk = 0;
    for (std::size_t at = kHeader; at < size; ++chunk) {
      const std::string where = "chunk " + std::to_string(chunk);
      Require(size - at >= kChunkHeader, where, "its header is cut off");
      const std::size_t length = Uint32At(bytes, at);
      Require(length <= size - at - kChunkHeader, where, "it is longer than the file");
      Require(length % 4 == 0, where, "its length is not a multiple of 4");
      const std::string_view type = bytes.substr(at + 4, 4);
      Require(chunk != 0 || type == "JSON", where, "it is not JSON");
      at += kChunkHeader + length;
    }
    if (chunk == 0) Fail("a GLB without chunks");
    return size;
  }

  void CheckNesting(std::string_view json) const {
    int depth = 0;
    bool in_text = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
      const char c = json[i];
      if (in_text) {
        if (c == '\\') ++i;
        in_text = c != '"';
      } else if (c == '"') {
        in_text = true;
      } else if (c == '{' || c == '[') {
        if (++depth > kMaxNesting) {
          Fail("its JSON is nested more than " + std::to_string(kMaxNesting) + " deep");
        }
      } else if (c == '}' || c == ']') {
        --depth;
      }
    }
  }

  [[noreturn]] void FailExtension(const std::string& name) const {
    Fail("it needs the extension '" + name.substr(0, 100) + "', which is not supported" +
         (name.find("meshopt") != std::string::npos ? "; write the file without compression" : ""));
  }

  void CheckExtensions() {
    if (!model_.asset.version.starts_with("2.")) {
      Fail("glTF of version '" + model_.asset.version.substr(0, 32) + "'; only 2 can be read");
    }
    for (const std::string& name : model_.extensionsRequired) {
      if (!IsKnownExtension(name)) FailExtension(name);
    }
    for (const std::string& name : model_.extensionsUsed) {
      // Those of materials are named with the material.
      if (IsKnownExtension(name) || name.starts_with("KHR_materials_")) continue;
      Warn("the extension '" + name.substr(0, 100) + "' is not supported and left out");
    }
    if (!model_.animations.empty()) {
      Warn("animations are not supported; the file is taken as it stands without them");
    }
  }

  // What is compressed.

  /// Index of a new view of these bytes, which no file holds.
  int AddView(std::vector<unsigned char> bytes) {
    tinygltf::BufferView view;
    view.buffer = static_cast<int>(model_.buffers.size());
    view.byteLength = bytes.size();
    model_.buffers.emplace_back().data = std::move(bytes);
    model_.bufferViews.push_back(std::move(view));
    return static_cast<int>(model_.bufferViews.size()) - 1;
  }

  /// A whole number in 0 to 2^31 - 1.
  [[nodiscard]] std::size_t CountIn(const Value& object,
                                    const char* key,
                                    double otherwise,
                                    const std::string& where) const {
    const double number = NumberIn(object, key, otherwise, where);
    Require(number >= 0.0 && number <= 2147483647.0 && number == std::floor(number),
            where,
            "'" + std::string(key) + "' is missing or out of range");
    return static_cast<std::size_t>(number);
  }

  [[nodiscard]] static std::string TextIn(const Value& object, const char* key) {
    const Value& value = object.Get(key);
    return value.IsString() ? value.Get<std::string>().substr(0, 32) : "";
  }

  void UnpackViews() {
    const std::size_t num_views = model_.bufferViews.size();
    for (std::size_t i = 0; i < num_views; ++i) {
      const Value* meshopt = Extension(model_.bufferViews[i].extensions, kMeshoptExtension);
      if (meshopt == nullptr) continue;
      const std::string where = "bufferView " + std::to_string(i) + ", " + kMeshoptExtension;
      MeshoptView packed;
      tinygltf::BufferView& view = model_.bufferViews[i];
      view.buffer = static_cast<int>(CountIn(*meshopt, "buffer", -1.0, where));
      view.byteOffset = CountIn(*meshopt, "byteOffset", 0.0, where);
      view.byteLength = CountIn(*meshopt, "byteLength", -1.0, where);
      packed.bytes = BytesOfView(static_cast<int>(i), where);
      packed.count = CountIn(*meshopt, "count", -1.0, where);
      packed.stride = CountIn(*meshopt, "byteStride", -1.0, where);
      packed.mode = TextIn(*meshopt, "mode");
      packed.filter = TextIn(*meshopt, "filter");
      std::vector<unsigned char> bytes;
      try {
        bytes = DecodeMeshopt(packed);
      } catch (const IoError& error) {
        Fail(where + ": " + error.what());
      }
      CountUnpacked(bytes.size(), where);
      view.buffer = static_cast<int>(model_.buffers.size());
      view.byteOffset = 0;
      view.byteLength = bytes.size();
      model_.buffers.emplace_back().data = std::move(bytes);
    }
  }

  /// Views of the same bytes could be many.
  void CountUnpacked(std::size_t size, const std::string& where) {
    num_unpacked_ += size;
    Require(num_unpacked_ <= kMaxUnpacked, where, "there is too much compressed data");
  }

  void UnpackPrimitives() {
    std::map<int, DracoMesh> meshes;                               // by bufferView
    std::map<std::tuple<int, std::uint32_t, int>, int> accessors;  // by view, attribute, accessor
    for (std::size_t m = 0; m < model_.meshes.size(); ++m) {
      for (std::size_t p = 0; p < model_.meshes[m].primitives.size(); ++p) {
        tinygltf::Primitive& primitive = model_.meshes[m].primitives[p];
        const Value* draco = Extension(primitive.extensions, kDracoExtension);
        if (draco == nullptr) continue;
        const std::string where = Described("mesh", model_.meshes, static_cast<int>(m)) +
                                  ", primitive " + std::to_string(p) + ", " + kDracoExtension;
        UnpackPrimitive(*draco, where, primitive, meshes, accessors);
      }
    }
  }

  void UnpackPrimitive(const Value& draco,
                       const std::string& where,
                       tinygltf::Primitive& primitive,
                       std::map<int, DracoMesh>& meshes,
                       std::map<std::tuple<int, std::uint32_t, int>, int>& accessors) {
    Require(primitive.mode == TINYGLTF_MODE_TRIANGLES, where, "its mode is not that of triangles");
    const auto view = static_cast<int>(CountIn(draco, "bufferView", -1.0, where));
    const std::size_t num_corners =
        At(model_.accessors, primitive.indices, where + ", indices", "accessor").count;
    Require(num_corners > 0 && num_corners % 3 == 0 && num_corners / 3 <= kMaxTriangles,
            where,
            "its indices are not of whole triangles, or too many");
    auto known = meshes.find(view);
    if (known == meshes.end()) {
      try {
        known = meshes.try_emplace(view, BytesOfView(view, where), num_corners / 3).first;
      } catch (const IoError& error) {
        const std::string what = error.what();
        Fail(what.starts_with(path_.string()) ? what.substr(path_.string().size() + 2)
                                              : where + ": " + what);
      }
    }
    const DracoMesh& mesh = known->second;
    const auto unpack = [&](int accessor,
                            std::uint32_t id,
                            std::size_t count,
                            const std::string& name,
                            const auto& decode) {
      const tinygltf::Accessor& from = At(model_.accessors, accessor, name, "accessor");
      const auto [entry, is_new] =
          accessors.try_emplace({view, id, accessor}, static_cast<int>(model_.accessors.size()));
      if (is_new) {
        Require(from.count == count,
                name,
                "its accessor counts " + std::to_string(from.count) + ", its Draco data " +
                    std::to_string(count));
        tinygltf::Accessor unpacked = from;
        unpacked.byteOffset = 0;
        unpacked.sparse.isSparse = false;
        std::vector<unsigned char> bytes = decode(unpacked);
        Require(!bytes.empty(), name, "its Draco data has no such attribute");
        CountUnpacked(bytes.size(), name);
        unpacked.bufferView = AddView(std::move(bytes));
        model_.accessors.push_back(std::move(unpacked));
      }
      return entry->second;
    };
    constexpr std::uint32_t kCorners = std::numeric_limits<std::uint32_t>::max();
    primitive.indices = unpack(primitive.indices,
                               kCorners,
                               num_corners,
                               where + ", indices",
                               [&](tinygltf::Accessor& accessor) {
                                 accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
                                 return mesh.Corners();
                               });
    const Value& attributes = draco.Get("attributes");
    Require(attributes.IsObject(), where, "it has no attributes");
    for (auto& [name, accessor] : primitive.attributes) {
      if (!attributes.Has(name)) continue;
      const auto id = static_cast<std::uint32_t>(CountIn(attributes, name.c_str(), -1.0, where));
      accessor = unpack(accessor,
                        id,
                        mesh.NumPoints(),
                        where + ", " + name.substr(0, 100),
                        [&](const tinygltf::Accessor& from) {
                          return mesh.Attribute(id, from.componentType, ComponentsOf(from.type));
                        });
    }
  }

  // Numbers in buffers.

  /// Elements side by side.
  struct Numbers {
    std::size_t count = 0;
    std::size_t components = 0;
    std::vector<double> values;
  };

  [[nodiscard]] std::string_view BytesOfView(int index, const std::string& where) const {
    const tinygltf::BufferView& view = At(model_.bufferViews, index, where, "bufferView");
    const std::string name = "bufferView " + std::to_string(index);
    const tinygltf::Buffer& buffer = At(model_.buffers, view.buffer, name, "buffer");
    const std::size_t size = buffer.data.size();
    if (view.byteOffset > size || view.byteLength > size - view.byteOffset) {
      Fail(name + ": bytes " + std::to_string(view.byteOffset) + " to " +
           std::to_string(view.byteOffset) + " + " + std::to_string(view.byteLength) +
           " are asked for; buffer " + std::to_string(view.buffer) + " has " +
           std::to_string(size));
    }
    return {reinterpret_cast<const char*>(buffer.data.data()) + view.byteOffset, view.byteLength};
  }

  static std::size_t SizeOf(int component_type) {
    switch (component_type) {
      case TINYGLTF_COMPONENT_TYPE_BYTE:
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
      case TINYGLTF_COMPONENT_TYPE_SHORT:
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
      default:
        return 0;
    }
  }

  static std::size_t ComponentsOf(int kind) {
    return kind == TINYGLTF_TYPE_SCALAR ? 1
           : kind == TINYGLTF_TYPE_VEC2 ? 2
           : kind == TINYGLTF_TYPE_VEC3 ? 3
           : kind == TINYGLTF_TYPE_VEC4 ? 4
                                        : 16;
  }

  static double NumberAt(std::string_view bytes, std::size_t at, int type, bool normalized) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < SizeOf(type); ++i) {
      word |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
    }
    switch (type) {
      case TINYGLTF_COMPONENT_TYPE_BYTE: {
        const auto value = static_cast<double>(static_cast<std::int8_t>(word));
        return normalized ? std::max(value / 127.0, -1.0) : value;
      }
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return normalized ? word / 255.0 : word;
      case TINYGLTF_COMPONENT_TYPE_SHORT: {
        const auto value = static_cast<double>(static_cast<std::int16_t>(word));
        return normalized ? std::max(value / 32767.0, -1.0) : value;
      }
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return normalized ? word / 65535.0 : word;
      case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return static_cast<double>(std::bit_cast<float>(word));
      default:
        return word;
    }
  }

  [[nodiscard]] Numbers ReadAccessor(int index,
                                     std::size_t min_components,
                                     std::size_t max_components,
                                     const std::string& user) const {
    const tinygltf::Accessor& accessor = At(model_.accessors, index, user, "accessor");
    const std::string where = Described("accessor", model_.accessors, index) + " of " + user;
    Numbers numbers;
    numbers.count = accessor.count;
    numbers.components = ComponentsOf(accessor.type);
    Require(numbers.components >= min_components && numbers.components <= max_components,
            where,
            "it has the wrong number of components");
    const std::size_t size = SizeOf(accessor.componentType);
    Require(size > 0,
            where,
            "its componentType is " + std::to_string(accessor.componentType) +
                "; allowed are 5120 to 5123, 5125 and 5126");
    Require(numbers.count > 0, where, "its count is 0");
    const bool has_bytes = accessor.bufferView >= 0;
    Require(numbers.count <= (has_bytes ? kMaxElements : kMaxZeros),
            where,
            "its count " + std::to_string(numbers.count) + " is too large");
    // Before anything of this size is allocated.
    if (has_bytes) CheckRange(accessor, numbers, size, where);
    numbers.values.assign(numbers.count * numbers.components, 0.0);
    if (has_bytes) {
      const std::size_t stride = StrideOf(accessor, numbers.components * size);
      Copy(BytesOfView(accessor.bufferView, where), accessor, stride, numbers);
    }
    if (accessor.sparse.isSparse) ReplaceSparse(accessor, where, numbers);
    const auto wrong =
        std::ranges::find_if(numbers.values, [](double v) { return !std::isfinite(v); });
    if (wrong != numbers.values.end()) {
      const auto at = static_cast<std::size_t>(wrong - numbers.values.begin());
      Fail(where + ": element " + std::to_string(at / numbers.components) + " is not finite");
    }
    return numbers;
  }

  [[nodiscard]] std::size_t StrideOf(const tinygltf::Accessor& accessor,
                                     std::size_t element) const {
    const auto view = static_cast<std::size_t>(accessor.bufferView);
    const std::size_t stride = model_.bufferViews[view].byteStride;
    return stride == 0 ? element : stride;
  }

  void CheckRange(const tinygltf::Accessor& accessor,
                  const Numbers& numbers,
                  std::size_t component_size,
                  const std::string& where) const {
    const std::size_t available = BytesOfView(accessor.bufferView, where).size();
    const std::size_t element = numbers.components * component_size;
    const std::size_t stride = StrideOf(accessor, element);
    Require(stride >= element, where, "its elements overlap: byteStride is too small");
    const std::size_t needed = (numbers.count - 1) * stride + element;
    if (accessor.byteOffset <= available && needed <= available - accessor.byteOffset) return;
    Fail(where + ": " + std::to_string(numbers.count) + " elements from byte " +
         std::to_string(accessor.byteOffset) + " on do not fit bufferView " +
         std::to_string(accessor.bufferView) + " of " + std::to_string(available) + " bytes");
  }

  static void Copy(std::string_view bytes,
                   const tinygltf::Accessor& accessor,
                   std::size_t stride,
                   Numbers& numbers) {
    const std::size_t size = SizeOf(accessor.componentType);
    for (std::size_t i = 0; i < numbers.count; ++i) {
      for (std::size_t c = 0; c < numbers.components; ++c) {
        numbers.values[i * numbers.components + c] =
            NumberAt(bytes,
                     accessor.byteOffset + i * stride + c * size,
                     accessor.componentType,
                     accessor.normalized);
      }
    }
  }

  void ReplaceSparse(const tinygltf::Accessor& accessor,
                     const std::string& where,
                     Numbers& numbers) const {
    const auto& sparse = accessor.sparse;
    const std::string what = where + ", sparse";
    const int type = sparse.indices.componentType;
    Require(type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
            what,
            "its indices have componentType " + std::to_string(type));
    const auto count = static_cast<std::size_t>(std::max(0, sparse.count));
    Require(sparse.count > 0 && count <= numbers.count, what, "its count is out of range");
    const std::string_view indices = BytesOfView(sparse.indices.bufferView, what);
    const std::string_view values = BytesOfView(sparse.values.bufferView, what);
    const std::size_t size = SizeOf(accessor.componentType);
    const std::size_t element = size * numbers.components;
    const auto fits = [count](int offset, std::size_t one, std::size_t available) {
      return offset >= 0 && static_cast<std::size_t>(offset) <= available &&
             count * one <= available - static_cast<std::size_t>(offset);
    };
    Require(fits(sparse.indices.byteOffset, SizeOf(type), indices.size()) &&
                fits(sparse.values.byteOffset, element, values.size()),
            what,
            "its indices or values do not fit their bufferView");
    for (std::size_t k = 0; k < count; ++k) {
      const auto index_at = static_cast<std::size_t>(sparse.indices.byteOffset) + k * SizeOf(type);
      const auto i = static_cast<std::size_t>(NumberAt(indices, index_at, type, false));
      Require(i < numbers.count, what, "there is no element " + std::to_string(i));
      for (std::size_t c = 0; c < numbers.components; ++c) {
        numbers.values[i * numbers.components + c] =
            NumberAt(values,
                     static_cast<std::size_t>(sparse.values.byteOffset) + k * element + c * size,
                     accessor.componentType,
                     accessor.normalized);
      }
    }
  }

  // Extensions' values.

  [[nodiscard]] static const Value* Extension(const tinygltf::ExtensionMap& extensions,
                                              const char* name) {
    const auto found = extensions.find(name);
    return found != extensions.end() && found->second.IsObject() ? &found->second : nullptr;
  }

  [[nodiscard]] double NumberIn(const Value& object,
                                const std::string& key,
                                double otherwise,
                                const std::string& where) const {
    if (!object.Has(key)) return otherwise;
    const Value& value = object.Get(key);
    Require(value.IsNumber() && std::isfinite(value.GetNumberAsDouble()),
            where,
            "'" + key + "' is not a number");
    return value.GetNumberAsDouble();
  }

  [[nodiscard]] std::vector<double> NumbersIn(const Value& object,
                                              const std::string& key,
                                              std::vector<double> otherwise,
                                              const std::string& where) const {
    if (!object.Has(key)) return otherwise;
    const Value& list = object.Get(key);
    bool right = list.IsArray() && list.ArrayLen() == otherwise.size();
    for (std::size_t i = 0; right && i < otherwise.size(); ++i) {
      const Value& value = list.Get(static_cast<int>(i));
      right = value.IsNumber() && std::isfinite(value.GetNumberAsDouble());
      otherwise[i] = value.GetNumberAsDouble();
    }
    Require(right, where, "'" + key + "' is not " + std::to_string(otherwise.size()) + " numbers");
    return otherwise;
  }

  // Materials.

  [[nodiscard]] double Share(double value, const char* key, const std::string& where) const {
    Require(value >= 0.0 && value <= 1.0, where, std::string(key) + " must lie in 0 to 1");
    return value;
  }

  /// A picture that turns or flips on its UVs would not lie along their tangents.
  std::optional<TextureUse> ReadNormalUse(const tinygltf::NormalTextureInfo& info,
                                          const std::string& where) {
    std::optional<TextureUse> use = ReadUse(info, where);
    if (use && (use->uv.rotation != 0.0 || use->uv.scale.x <= 0.0 || use->uv.scale.y <= 0.0)) {
      WarnUnsupported(where, "a KHR_texture_transform that turns or flips it");
      use.reset();
    }
    return use;
  }

  template <class TextureInfo>
  std::optional<TextureUse> ReadUse(const TextureInfo& info, const std::string& where) {
    if (info.index < 0) return std::nullopt;
    At(model_.textures, info.index, where, "texture");
    TextureUse use{info.index, {}};
    use.uv.set = info.texCoord;
    if (const Value* transform = Extension(info.extensions, "KHR_texture_transform")) {
      const std::vector<double> offset = NumbersIn(*transform, "offset", {0.0, 0.0}, where);
      const std::vector<double> scale = NumbersIn(*transform, "scale", {1.0, 1.0}, where);
      use.uv.offset = {offset[0], offset[1]};
      use.uv.scale = {scale[0], scale[1]};
      use.uv.rotation = NumberIn(*transform, "rotation", 0.0, where);
      const double set = NumberIn(*transform, "texCoord", use.uv.set, where);
      Require(set >= 0.0 && set < 1000.0, where, "its texCoord is out of range");
      use.uv.set = static_cast<int>(set);
    }
    return use;
  }

  MaterialPlan& PlanOf(int index, const std::string& user) {
    const auto [entry, is_new] = plans_.try_emplace(index);
    if (is_new) {
      // Without a material the format's default one is meant.
      static const tinygltf::Material default_material = [] {
        tinygltf::Material material;
        material.name = "default";
        material.emissiveFactor = {0.0, 0.0, 0.0};
        return material;
      }();
      const tinygltf::Material& material =
          index < 0 ? default_material : At(model_.materials, index, user, "material");
      entry->second.where =
          index < 0 ? "the default material" : Described("material", model_.materials, index);
      entry->second.material.name =
          material.name.empty() ? "material" + std::to_string(index) : material.name;
      FillPlan(material, entry->second);
    }
    return entry->second;
  }

  void FillPlan(const tinygltf::Material& from, MaterialPlan& plan) {
    const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
    const std::string& where = plan.where;
    MetallicRoughnessBsdf bsdf;
    bsdf.roughness = Share(pbr.roughnessFactor, "roughnessFactor", where);
    bsdf.metallic = Share(pbr.metallicFactor, "metallicFactor", where);
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<std::size_t>(c);
      plan.material.base_color[c] = Share(pbr.baseColorFactor.at(i), "baseColorFactor", where);
      plan.emission[c] = Share(from.emissiveFactor.at(i), "emissiveFactor", where);
    }
    plan.material.two_sided = from.doubleSided;
    plan.base_color = ReadUse(pbr.baseColorTexture, where + ", baseColorTexture");
    plan.metallic_roughness =
        ReadUse(pbr.metallicRoughnessTexture, where + ", metallicRoughnessTexture");
    plan.emissive = ReadUse(from.emissiveTexture, where + ", emissiveTexture");
    ReadMaterialExtensions(from, plan, bsdf);
    plan.material.bsdf = bsdf;
    plan.normal = ReadNormalUse(from.normalTexture, where + ", normalTexture");
    plan.material.normal_scale = from.normalTexture.scale;
    Require(std::abs(from.normalTexture.scale) <= 1e6, where, "its normalTexture's scale is wrong");
    if (from.occlusionTexture.index >= 0) WarnUnsupported(where, "occlusionTexture");
    if (from.alphaMode != "OPAQUE") {
      Warn(where + ": alphaMode " + from.alphaMode.substr(0, 32) +
           " is not supported; it is taken as opaque");
    }
    if (IsBlack(plan.emission)) plan.emissive.reset();
    ChooseUvs(plan);
  }

  void ReadMaterialExtensions(const tinygltf::Material& from,
                              MaterialPlan& plan,
                              MetallicRoughnessBsdf& bsdf) {
    const std::string& where = plan.where;
    if (const Value* e = Extension(from.extensions, "KHR_materials_emissive_strength")) {
      const double strength = NumberIn(*e, "emissiveStrength", 1.0, where);
      Require(strength >= 0.0 && strength <= 1e12, where, "emissiveStrength is out of range");
      plan.emission *= strength;
    }
    if (const Value* e = Extension(from.extensions, "KHR_materials_specular")) {
      bsdf.specular = Share(NumberIn(*e, "specularFactor", 1.0, where), "specularFactor", where);
      const std::vector<double> white(3, 1.0);
      if (NumbersIn(*e, "specularColorFactor", white, where) != white) {
        WarnUnsupported(where, "specularColorFactor");
      }
      for (const char* key : {"specularTexture", "specularColorTexture"}) {
        if (e->Has(key)) WarnUnsupported(where, key);
      }
    }
    for (const auto& [name, value] : from.extensions) {
      if (!IsKnownExtension(name)) WarnUnsupported(where, name.substr(0, 100));
    }
  }

  /// A mesh has one set of UVs: of textures that need others, only those stay that agree with the
  /// first.
  void ChooseUvs(MaterialPlan& plan) {
    const std::array<std::pair<std::optional<TextureUse>*, const char*>, 4> uses = {
        {{&plan.base_color, "baseColorTexture"},
         {&plan.metallic_roughness, "metallicRoughnessTexture"},
         {&plan.normal, "normalTexture"},
         {&plan.emissive, "emissiveTexture"}}};
    const TextureUse* first = nullptr;
    for (const auto& [use, name] : uses) {
      if (!*use) continue;
      if (first == nullptr) {
        first = &**use;
        plan.uv = first->uv;
      } else if (!((*use)->uv == plan.uv)) {
        Warn(plan.where + ": " + name +
             " has other texture coordinates than the first texture of the material, which is not "
             "supported; it is left out" +
             (use == &plan.emissive ? ", and nothing shines"
              : use == &plan.normal ? ""
                                    : ", its factor stays"));
        use->reset();
        if (use == &plan.emissive) plan.emission = {};
      }
    }
  }

  TextureWrap WrapOf(const tinygltf::Texture& texture, const MaterialPlan& plan) {
    const std::string where =
        Described("sampler of texture", model_.textures, TextureIndex(texture));
    tinygltf::Sampler sampler;
    if (texture.sampler >= 0) sampler = At(model_.samplers, texture.sampler, where, "sampler");
    if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) {
      Warn(where + ": filter NEAREST is not supported; texels are interpolated");
    }
    constexpr double kSlack = 1e-5;
    const auto leaves = [&](double low, double high) {
      return low < -kSlack || high > 1.0 + kSlack;
    };
    const auto repeats = [&](int mode, bool is_left) {
      if (mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) {
        // Within the picture its border goes on, as for a clamped one.
        if (is_left) Warn(where + ": MIRRORED_REPEAT is not supported; the picture repeats");
        return is_left;
      }
      return mode != TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    };
    const bool leaves_s = leaves(plan.low.x, plan.high.x);
    const bool leaves_t = leaves(plan.low.y, plan.high.y);
    const bool repeats_s = repeats(sampler.wrapS, leaves_s);
    const bool repeats_t = repeats(sampler.wrapT, leaves_t);
    bool repeat = repeats_s;
    if (repeats_s != repeats_t) {
      if (leaves_s && leaves_t) {
        Warn(where + ": wrapS and wrapT differ, which is not supported; wrapS holds for both");
      } else {
        repeat = leaves_t ? repeats_t : leaves_s && repeats_s;
      }
    }
    return repeat ? TextureWrap::kRepeat : TextureWrap::kClamp;
  }

  [[nodiscard]] int TextureIndex(const tinygltf::Texture& texture) const {
    return static_cast<int>(&texture - model_.textures.data());
  }

  const DecodedImage& ImageOf(int index, const std::string& user) {
    const tinygltf::Image& image = At(model_.images, index, user, "image");
    const auto [entry, is_new] = images_.try_emplace(index);
    if (!is_new) return entry->second;
    const std::string where = Described("image", model_.images, index);
    std::string bytes;
    if (image.bufferView >= 0) {
      bytes = BytesOfView(image.bufferView, where);
    } else {
      bytes.assign(image.image.begin(), image.image.end());
    }
    if (bytes.empty()) {
      const bool is_far = std::ranges::find(access_.far, image.uri) != access_.far.end();
      Fail(where + ": " +
           (is_far ? FarMessage(image.uri)
                   : "the file '" + image.uri.substr(0, 200) + "' is missing, or empty"));
    }
    entry->second = DecodeImage(std::move(bytes), path_.string() + ": " + where);
    return entry->second;
  }

  std::string NameOfTexture(const tinygltf::Texture& texture) const {
    if (!texture.name.empty()) return texture.name;
    const tinygltf::Image& image = model_.images[static_cast<std::size_t>(texture.source)];
    if (!image.name.empty()) return image.name;
    const std::string stem = fs::path(image.uri).stem().string();
    return stem.empty() ? "texture" + std::to_string(TextureIndex(texture)) : stem;
  }

  /// Index in the scene. Materials that use a picture alike share it.
  int AddTexture(const TextureUse& use, TexelRole role, const Rgb& factor, MaterialPlan& plan) {
    const std::string where = Described("texture", model_.textures, use.texture);
    const tinygltf::Texture& from = model_.textures[static_cast<std::size_t>(use.texture)];
    Require(from.source >= 0, where, "it has no PNG or JPEG picture");
    const DecodedImage& decoded = ImageOf(from.source, where);
    const TextureWrap wrap = WrapOf(from, plan);
    const auto key = std::tuple(use.texture, role, wrap, factor.r, factor.g, factor.b);
    if (const auto known = textures_.find(key); known != textures_.end()) return known->second;
    Texture texture;
    texture.width = decoded.image.width;
    texture.height = decoded.image.height;
    texture.wrap = wrap;
    texture.scalar = role == TexelRole::kRoughness || role == TexelRole::kMetallic;
    std::vector<Rgb> texels;
    texels.reserve(decoded.image.data.size() / 3);
    std::size_t num_smooth = 0;
    for (int y = 0; y < texture.height; ++y) {
      for (int x = 0; x < texture.width; ++x) {
        const Rgb pixel = decoded.image.ColorAt(x, y);
        Rgb& texel = texels.emplace_back(pixel);
        if (role == TexelRole::kNormal) continue;
        if (role == TexelRole::kColor) {
          for (int c = 0; c < 3; ++c) texel[c] = LinearFromSrgb(pixel[c]) * factor[c];
          continue;
        }
        double value = (role == TexelRole::kRoughness ? pixel.g : pixel.b) * factor.r;
        if (role == TexelRole::kRoughness && value < kMinRoughness) {
          ++num_smooth;
          value = kMinRoughness;
        }
        texel = Rgb::Constant(value);
      }
    }
    if (num_smooth > 0) {
      Warn(plan.where + ": " + std::to_string(num_smooth) + " of " + std::to_string(texels.size()) +
           " texels of metallicRoughnessTexture are smoother than the least roughness, " +
           RoughnessText() + "; they have that");
    }
    texture.texels = std::move(texels);
    const std::string suffix = role == TexelRole::kRoughness  ? "-roughness"
                               : role == TexelRole::kMetallic ? "-metallic"
                                                              : "";
    std::vector<Texture>& list = file_.scene.textures;
    texture.name = Unused(NameOfTexture(from) + suffix, texture_names_);
    list.push_back(std::move(texture));
    return textures_[key] = static_cast<int>(list.size()) - 1;
  }

  static std::string RoughnessText() {
    std::string text = std::to_string(kMinRoughness);
    while (text.ends_with('0')) text.pop_back();
    return text;
  }

  /// Names that are given to objects of one list.
  struct Names {
    std::set<std::string> taken;
    std::map<std::string, int> next;  ///< number to be tried behind a name
  };

  /// The name, or with a number behind it if something in the list is called so.
  static std::string Unused(const std::string& name, Names& names) {
    std::string unused = name;
    int& next = names.next.try_emplace(name, 2).first->second;
    while (!names.taken.insert(unused).second) unused = name + "-" + std::to_string(next++);
    return unused;
  }

  void FinishMaterials() {
    for (auto& [index, plan] : plans_) {
      Material& material = plan.material;
      auto& bsdf = std::get<MetallicRoughnessBsdf>(material.bsdf);
      if (plan.base_color) {
        material.base_color_texture =
            AddTexture(*plan.base_color, TexelRole::kColor, material.base_color, plan);
        material.base_color = {1.0, 1.0, 1.0};
        if (plan.tinted) {
          WarnUnsupported(plan.where, "COLOR_0, which is a factor of baseColorTexture,");
        }
      }
      material.vertex_colors = plan.tinted && !plan.base_color;
      // A factor of zero leaves nothing of the texture.
      if (plan.metallic_roughness && bsdf.roughness > 0.0) {
        material.roughness_texture = AddTexture(
            *plan.metallic_roughness, TexelRole::kRoughness, Rgb::Constant(bsdf.roughness), plan);
      }
      if (plan.metallic_roughness && bsdf.metallic > 0.0) {
        material.metallic_texture = AddTexture(
            *plan.metallic_roughness, TexelRole::kMetallic, Rgb::Constant(bsdf.metallic), plan);
      }
      if (bsdf.roughness < kMinRoughness) {
        if (material.roughness_texture < 0) {
          Warn(plan.where + ": its roughness " + std::to_string(bsdf.roughness) +
               " is below the least one, " + RoughnessText() + "; it has that");
        }
        bsdf.roughness = kMinRoughness;
      }
      if (plan.normal) {
        material.normal_texture = AddTexture(*plan.normal, TexelRole::kNormal, {1, 1, 1}, plan);
      }
      if (plan.emissive) {
        plan.emission_texture = AddTexture(*plan.emissive, TexelRole::kColor, {1, 1, 1}, plan);
      }
      material.name = Unused(material.name, material_names_);
      plan.index = static_cast<int>(file_.scene.materials.size());
      file_.scene.materials.push_back(material);
    }
    for (std::size_t i = 0; i < file_.scene.meshes.size(); ++i) {
      const MaterialPlan& plan = plans_.at(materials_[i]);
      file_.scene.meshes[i].material = plan.index;
      SetColors(plan, file_.scene.meshes[i].mesh);
    }
    images_.clear();
  }

  static void SetColors(const MaterialPlan& plan, Mesh& mesh) {
    if (!plan.material.vertex_colors) {
      mesh.colors.clear();
      mesh.color_triangles.clear();
    } else if (!mesh.HasColors()) {
      SetUniformVertexColors(plan.material.base_color, mesh);
    } else {
      for (Rgb& color : mesh.colors) color = color * plan.material.base_color;
    }
  }

  void AddEmission() {
    const std::vector<Texture>& textures = file_.scene.textures;
    for (std::size_t i = 0; i < file_.scene.meshes.size(); ++i) {
      const MaterialPlan& plan = plans_.at(materials_[i]);
      if (IsBlack(plan.emission)) continue;
      AreaEmitter light;
      light.mesh = static_cast<int>(i);
      light.intensity = plan.emission;
      light.texture = plan.emission_texture;
      light.two_sided = plan.material.two_sided;
      if (light.texture >= 0 &&
          std::ranges::all_of(textures[static_cast<std::size_t>(light.texture)].texels.Items(),
                              IsBlack)) {
        continue;
      }
      AddEmitter(file_.scene.meshes[i].name + "-emission", light);
    }
  }

  template <class Light>
  void AddEmitter(const std::string& name, Light light) {
    Emitter& emitter = file_.scene.emitters.emplace_back();
    emitter.name = Unused(name, light_names_);
    emitter.light = std::move(light);
  }

  // Nodes.

  void ReadNodes() {
    std::vector<std::pair<int, Transform>> open;
    const auto add_root = [&](int node) { open.push_back({node, Transform{}}); };
    if (!model_.scenes.empty()) {
      const int wanted = std::max(0, model_.defaultScene);
      const std::string where = "scene " + std::to_string(wanted);
      const tinygltf::Scene& scene = At(model_.scenes, wanted, "'scene'", "scene");
      for (const int node : scene.nodes) {
        At(model_.nodes, node, where, "node");
        add_root(node);
      }
      if (model_.scenes.size() > 1) {
        Warn("only " + where + Quoted(scene.name) + " of " + std::to_string(model_.scenes.size()) +
             " scenes is read");
      }
    } else {
      std::vector<bool> is_child(model_.nodes.size(), false);
      for (const tinygltf::Node& node : model_.nodes) {
        for (const int child : node.children) {
          At(model_.nodes, child, "node" + Quoted(node.name), "node");
          is_child[static_cast<std::size_t>(child)] = true;
        }
      }
      for (std::size_t i = 0; i < is_child.size(); ++i) {
        if (!is_child[i]) add_root(static_cast<int>(i));
      }
    }
    std::ranges::reverse(open);
    std::vector<bool> is_seen(model_.nodes.size(), false);
    while (!open.empty()) {
      const auto [index, parent] = open.back();
      open.pop_back();
      const std::string where = Described("node", model_.nodes, index);
      Require(!is_seen[static_cast<std::size_t>(index)],
              where,
              "it is in the scene twice: below two nodes, or below itself");
      is_seen[static_cast<std::size_t>(index)] = true;
      const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(index)];
      const Transform transform = parent * TransformOf(node, where);
      ReadNode(node, transform, where);
      for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
        At(model_.nodes, *child, where, "node");
        open.emplace_back(*child, transform);
      }
    }
  }

  [[nodiscard]] Transform TransformOf(const tinygltf::Node& node, const std::string& where) const {
    const auto has = [&](const std::vector<double>& list, std::size_t count, const char* key) {
      Require(list.empty() || list.size() == count,
              where,
              std::string(key) + " has " + std::to_string(list.size()) + " numbers, not " +
                  std::to_string(count));
      return !list.empty();
    };
    Transform transform;
    const std::vector<double>& m = node.matrix;
    if (has(m, 16, "matrix")) {
      Require(m[3] == 0.0 && m[7] == 0.0 && m[11] == 0.0 && m[15] == 1.0,
              where,
              "the last row of its matrix is not 0 0 0 1");
      transform = {{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}},
                   {m[12], m[13], m[14]}};
    } else {
      if (has(node.rotation, 4, "rotation")) transform.linear = Rotation(node.rotation, where);
      if (has(node.scale, 3, "scale") && !IsUnit(node)) {
        transform.linear.x *= node.scale[0];
        transform.linear.y *= node.scale[1];
        transform.linear.z *= node.scale[2];
      }
      if (has(node.translation, 3, "translation")) {
        transform.translation = {node.translation[0], node.translation[1], node.translation[2]};
      }
    }
    return transform;
  }

  /// Whether the scale only turns the mesh's unit into metres, as WriteGlb says it.
  [[nodiscard]] static bool IsUnit(const tinygltf::Node& node) {
    if (!node.extras.IsObject() || !node.extras.Has(kMetresPerUnit)) return false;
    const tinygltf::Value& unit = node.extras.Get(kMetresPerUnit);
    return unit.IsNumber() &&
           std::ranges::all_of(node.scale, [&](double s) { return s == unit.GetNumberAsDouble(); });
  }

  /// Of a quaternion x, y, z, w.
  [[nodiscard]] Mat3 Rotation(const std::vector<double>& q, const std::string& where) const {
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    Require(norm > 0.0 && std::isfinite(norm), where, "its rotation is not a quaternion");
    const Vec3 axis = {q[0] / norm, q[1] / norm, q[2] / norm};
    const double w = q[3] / norm;
    const auto turned = [&](const Vec3& v) {
      const Vec3 t = Cross(axis, v) * 2.0;
      return v + t * w + Cross(axis, t);
    };
    return {turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1})};
  }

  void ReadNode(const tinygltf::Node& node, const Transform& world, const std::string& where) {
    const Value* light = Extension(node.extensions, "KHR_lights_punctual");
    if (node.mesh < 0 && node.camera < 0 && light == nullptr) return;
    const double determinant = Determinant(world.linear);
    Require(std::isfinite(determinant) && IsWithinBounds(world.translation),
            where,
            "its place or size is out of range");
    if (determinant == 0.0) {
      Warn(where + ": its scale is zero, so that nothing of it is seen");
      return;
    }
    if (node.skin >= 0) {
      Warn(where + ": skins are not supported; the mesh stays as it was before they act");
    }
    if (node.mesh >= 0) ReadMeshOf(node, world, where);
    if (node.camera >= 0) ReadCamera(node, world, where);
    if (light != nullptr) ReadLight(*light, node, world, where);
  }

  void ReadMeshOf(const tinygltf::Node& node, const Transform& world, const std::string& where) {
    const tinygltf::Mesh& mesh = At(model_.meshes, node.mesh, where, "mesh");
    const std::string mesh_where = Described("mesh", model_.meshes, node.mesh);
    std::vector<std::pair<int, Mesh>> parts;
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
      const tinygltf::Primitive& primitive = mesh.primitives[i];
      const std::string part_where = mesh_where + ", primitive " + std::to_string(i);
      if (primitive.mode < TINYGLTF_MODE_TRIANGLES || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
        Require(
            primitive.mode >= TINYGLTF_MODE_POINTS && primitive.mode <= TINYGLTF_MODE_LINE_STRIP,
            part_where,
            "there is no mode " + std::to_string(primitive.mode));
        Warn(part_where + ": points and lines are not supported and left out");
        continue;
      }
      if (!primitive.targets.empty()) {
        Warn(part_where + ": morph targets are not supported and left out");
      }
      const int material = std::max(-1, primitive.material);
      MaterialPlan& plan = PlanOf(material, part_where);
      Mesh part = ReadPrimitive(primitive, plan, part_where);
      if (part.triangles.empty()) continue;
      const auto same =
          std::ranges::find_if(parts, [&](const auto& p) { return p.first == material; });
      if (same == parts.end()) {
        parts.emplace_back(material, std::move(part));
      } else {
        AppendMesh(part, same->second);
      }
    }
    const std::string name = !node.name.empty()   ? node.name
                             : !mesh.name.empty() ? mesh.name
                                                  : "mesh" + std::to_string(node.mesh);
    for (auto& [material, part] : parts) AddMesh(name, parts.size(), material, world, part, where);
  }

  void AddMesh(const std::string& name,
               std::size_t num_parts,
               int material,
               const Transform& world,
               Mesh& part,
               const std::string& where) {
    const MaterialPlan& plan = plans_.at(material);
    FinishMesh(part);
    if (plan.normal && part.normal_triangles.empty()) SetFacetNormals(part);
    ApplyTransform(world, part);
    Require(std::ranges::all_of(part.positions.Items(), IsWithinBounds),
            where,
            "a coordinate is beyond 1e12");
    SceneMesh mesh;
    const std::string own = num_parts == 1 ? name : name + "-" + plan.material.name;
    mesh.name = Unused(own, mesh_names_);
    mesh.mesh = std::move(part);
    file_.scene.meshes.push_back(std::move(mesh));
    materials_.push_back(material);
  }

  /// As the format wants it without NORMAL; a normal map needs some.
  static void SetFacetNormals(Mesh& mesh) {
    mesh.normals.clear();
    mesh.normal_triangles.clear();
    for (const Triangle& t : mesh.triangles) {
      const auto x = [&](std::size_t k) { return mesh.positions[Index(t[k])]; };
      const auto index = static_cast<std::int32_t>(mesh.normals.size());
      mesh.normals.push_back(Normalized(Cross(x(1) - x(0), x(2) - x(0))));
      mesh.normal_triangles.push_back({index, index, index});
    }
  }

  /// Its corners by vertex number.
  std::vector<Triangle> ReadTriangles(const tinygltf::Primitive& primitive,
                                      std::size_t num_vertices,
                                      const std::string& where) {
    std::vector<std::int32_t> corners;
    if (primitive.indices >= 0) {
      const Numbers numbers = ReadAccessor(primitive.indices, 1, 1, where + ", indices");
      const tinygltf::Accessor& accessor =
          model_.accessors[static_cast<std::size_t>(primitive.indices)];
      const int type = accessor.componentType;
      Require(type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                  type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                  type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
              where + ", indices",
              "they have componentType " + std::to_string(type));
      Require(!accessor.normalized, where + ", indices", "they cannot be normalized");
      corners.reserve(numbers.count);
      for (std::size_t i = 0; i < numbers.count; ++i) {
        if (numbers.values[i] >= static_cast<double>(num_vertices)) {
          Fail(where + ": index " + std::to_string(i) + " is " +
               std::to_string(static_cast<std::int64_t>(numbers.values[i])) + "; there are " +
               std::to_string(num_vertices) + " vertices");
        }
        corners.push_back(static_cast<std::int32_t>(numbers.values[i]));
      }
    } else {
      for (std::size_t i = 0; i < num_vertices; ++i)
        corners.push_back(static_cast<std::int32_t>(i));
    }
    const bool is_list = primitive.mode == TINYGLTF_MODE_TRIANGLES;
    Require(!is_list || corners.size() % 3 == 0,
            where,
            std::to_string(corners.size()) + " corners are not whole triangles");
    std::vector<Triangle> triangles;
    std::size_t num_degenerate = 0;
    for (std::size_t i = 0; i + 2 < corners.size(); i += is_list ? 3 : 1) {
      Triangle t = {corners[i], corners[i + 1], corners[i + 2]};
      if (primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP && i % 2 == 1) std::swap(t[1], t[2]);
      if (primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN) t[0] = corners[0];
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
        ++num_degenerate;
      } else {
        triangles.push_back(t);
      }
    }
    // Strips turn by them.
    if (is_list && num_degenerate > 0) {
      Warn(where + ": " + std::to_string(num_degenerate) +
           " triangles with a repeated corner are left out");
    }
    num_triangles_ += triangles.size();
    Require(num_triangles_ <= kMaxTriangles, where, "there are too many triangles");
    return triangles;
  }

  Mesh ReadPrimitive(const tinygltf::Primitive& primitive,
                     MaterialPlan& plan,
                     const std::string& where) {
    const auto attribute = [&](const std::string& name,
                               std::size_t least,
                               std::size_t most) -> std::optional<Numbers> {
      const auto found = primitive.attributes.find(name);
      if (found == primitive.attributes.end()) return std::nullopt;
      return ReadAccessor(found->second, least, most, where + ", " + name);
    };
    const std::optional<Numbers> positions = attribute("POSITION", 3, 3);
    Require(positions.has_value(), where, "it has no POSITION");
    const std::optional<Numbers> normals = attribute("NORMAL", 3, 3);
    const std::string uv_name = "TEXCOORD_" + std::to_string(plan.uv.set);
    const std::optional<Numbers> uvs = attribute(uv_name, 2, 2);
    const std::optional<Numbers> colors = attribute("COLOR_0", 3, 4);
    Require(uvs || !plan.HasTextures(),
            where,
            "it has no " + uv_name + ", which a texture of " + plan.where + " needs");
    for (const auto* numbers : {&normals, &uvs, &colors}) {
      Require(!*numbers || (*numbers)->count == positions->count,
              where,
              "its attributes have different counts");
    }
    std::vector<Triangle> triangles = ReadTriangles(primitive, positions->count, where);
    Mesh mesh;
    // Vertices of other primitives may be in the same accessor.
    std::vector<std::int32_t> place(positions->count, -1);
    std::size_t num_clamped = 0;
    for (Triangle& triangle : triangles) {
      for (std::int32_t& corner : triangle) {
        const auto from = static_cast<std::size_t>(corner);
        if (place[from] < 0) {
          place[from] = static_cast<std::int32_t>(mesh.positions.size());
          const double* p = &positions->values[3 * from];
          mesh.positions.push_back({p[0], p[1], p[2]});
          if (normals) {
            const double* n = &normals->values[3 * from];
            mesh.normals.push_back({n[0], n[1], n[2]});
          }
          if (uvs) AddUv(&uvs->values[2 * from], plan, mesh);
          if (colors) AddColor(&colors->values[colors->components * from], plan, mesh, num_clamped);
        }
        corner = place[from];
      }
    }
    if (num_clamped > 0) {
      Warn(where + ": " + std::to_string(num_clamped) +
           " colours are outside of 0 to 1 and moved there");
    }
    Require(std::ranges::all_of(mesh.positions.Items(), IsWithinBounds),
            where,
            "a coordinate is beyond 1e12");
    mesh.triangles = std::move(triangles);
    if (normals) mesh.normal_triangles = mesh.triangles;
    if (uvs) mesh.uv_triangles = mesh.triangles;
    if (colors) mesh.color_triangles = mesh.triangles;
    if (normals && plan.normal) {
      if (const std::optional<Numbers> given = attribute("TANGENT", 4, 4)) {
        CompareTangents(*given, place, mesh, where);
      }
    }
    return mesh;
  }

  /// Tangents are made of the UVs, as those of files should have been.
  void CompareTangents(const Numbers& given,
                       const std::vector<std::int32_t>& place,
                       const Mesh& mesh,
                       const std::string& where) {
    Require(given.count == place.size(), where, "its attributes have different counts");
    std::vector<Tangent> made(mesh.positions.size());
    const std::vector<std::array<Tangent, 3>> tangents = MakeTangents(mesh);
    for (std::size_t f = 0; f < tangents.size(); ++f) {
      for (std::size_t k = 0; k < 3; ++k) made[Index(mesh.triangles[f][k])] = tangents[f][k];
    }
    constexpr double kCosine = 0.99;  // of 8 degrees
    std::size_t num_off = 0;
    for (std::size_t i = 0; i < place.size(); ++i) {
      if (place[i] < 0) continue;
      const double* t = &given.values[4 * i];
      const Tangent& own = made[Index(place[i])];
      const Vec3 along_u = {t[0], t[1], t[2]};
      const bool same = Dot(along_u, own.along_u) >= kCosine * Norm(along_u) && t[3] == own.sign;
      num_off += same ? 0 : 1;
    }
    constexpr double kFew = 0.02;  // poles and folds of UVs
    if (static_cast<double>(num_off) > kFew * static_cast<double>(made.size())) {
      Warn(where + ": its TANGENT are not those of its UVs, which hold, at " +
           std::to_string(num_off) + " of " + std::to_string(made.size()) + " vertices");
    }
  }

  static void AddUv(const double* from, MaterialPlan& plan, Mesh& mesh) {
    const Vec2 uv = plan.uv.Apply({from[0], from[1]});
    // v runs down in the format.
    mesh.uvs.push_back({uv.x, 1.0 - uv.y});
    const Vec2& added = std::as_const(mesh).uvs.back();
    plan.low = {std::min(plan.low.x, added.x), std::min(plan.low.y, added.y)};
    plan.high = {std::max(plan.high.x, added.x), std::max(plan.high.y, added.y)};
  }

  static void AddColor(const double* from, MaterialPlan& plan, Mesh& mesh, std::size_t& clamped) {
    Rgb color;
    bool is_outside = false;
    for (int c = 0; c < 3; ++c) {
      color[c] = std::clamp(from[c], 0.0, 1.0);
      is_outside = is_outside || color[c] != from[c];
    }
    clamped += is_outside ? 1 : 0;
    plan.tinted = plan.tinted || !(color == Rgb{1.0, 1.0, 1.0});
    mesh.colors.push_back(color);
  }

  // Lights and cameras.

  /// x right, y up, z backwards, without the node's size.
  static Mat3 UprightFrame(const Mat3& linear) {
    const Vec3 z = Normalized(linear.z);
    const Vec3 x = Normalized(Cross(linear.y, z));
    return {x, Cross(z, x), z};
  }

  void ReadLight(const Value& reference,
                 const tinygltf::Node& node,
                 const Transform& world,
                 const std::string& where) {
    const double number = NumberIn(reference, "light", -1.0, where);
    Require(number >= 0.0 && number < static_cast<double>(model_.lights.size()),
            where,
            "its light is not in the file");
    const auto index = static_cast<int>(number);
    const tinygltf::Light& light = model_.lights[static_cast<std::size_t>(index)];
    const std::string light_where = Described("light", model_.lights, index);
    Rgb color{1.0, 1.0, 1.0};
    Require(light.color.empty() || light.color.size() == 3, light_where, "its color is wrong");
    Require(light.intensity >= 0.0 && light.intensity <= 1e20,
            light_where,
            "its intensity is out of range");
    for (std::size_t c = 0; c < light.color.size(); ++c) {
      color[static_cast<int>(c)] = Share(light.color[c], "color", light_where);
    }
    color *= light.intensity;
    if (light.range > 0.0) {
      Warn(light_where + ": range is not supported; the light reaches everything");
    }
    const Mat3 frame = UprightFrame(world.linear);
    const std::string name = !light.name.empty()  ? light.name
                             : !node.name.empty() ? node.name
                                                  : "light" + std::to_string(index);
    if (light.type == "directional") {
      AddEmitter(name, DirectionalEmitter{-frame.z, color});
    } else if (light.type == "point") {
      AddEmitter(name, PointEmitter{world.translation, color});
    } else if (light.type == "spot") {
      constexpr double kWidest = 0.5 * std::numbers::pi - 1e-4;
      SpotEmitter spot;
      spot.position = world.translation;
      spot.frame_from_light = frame;
      spot.intensity = color;
      spot.inner_angle = light.spot.innerConeAngle;
      spot.outer_angle = std::min(light.spot.outerConeAngle, kWidest);
      Require(spot.inner_angle >= 0.0 && spot.inner_angle < spot.outer_angle,
              light_where,
              "its cone angles are not 0 <= inner < outer");
      AddEmitter(name, spot);
    } else {
      Fail(light_where + ": there is no type '" + light.type.substr(0, 32) + "'");
    }
  }

  void ReadCamera(const tinygltf::Node& node, const Transform& world, const std::string& where) {
    const tinygltf::Camera& from = At(model_.cameras, node.camera, where, "camera");
    const std::string camera_where = Described("camera", model_.cameras, node.camera);
    Camera camera;
    camera.name = !from.name.empty()   ? from.name
                  : !node.name.empty() ? node.name
                                       : "camera" + std::to_string(node.camera);
    camera.name = Unused(camera.name, camera_names_);
    double aspect = 16.0 / 9.0;
    if (from.type == "perspective") {
      const double fov = from.perspective.yfov;
      Require(fov > 0.0 && fov < std::numbers::pi, camera_where, "its yfov is out of range");
      if (from.perspective.aspectRatio > 0.0) aspect = from.perspective.aspectRatio;
      camera.fy = 0.5 * kGltfCameraHeight / std::tan(0.5 * fov);
    } else {
      const tinygltf::OrthographicCamera& flat = from.orthographic;
      Require(flat.xmag > 0.0 && flat.ymag > 0.0, camera_where, "xmag or ymag is not positive");
      aspect = flat.xmag / flat.ymag;
      camera.projection = ProjectionKind::kOrthographic;
      camera.fy = 0.5 * kGltfCameraHeight / flat.ymag;
    }
    Require(aspect >= 1e-3 && aspect <= 30.0, camera_where, "its aspect ratio is out of range");
    camera.height = kGltfCameraHeight;
    camera.width = std::max(1, static_cast<int>(std::lround(aspect * kGltfCameraHeight)));
    camera.fx = camera.fy;
    camera.cx = 0.5 * camera.width;
    camera.cy = 0.5 * camera.height;
    camera.world_from_camera = {UprightFrame(world.linear), world.translation};
    file_.scene.sensors.push_back(std::move(camera));
  }

  const fs::path& path_;
  FileAccess access_;
  tinygltf::Model model_;
  SceneFile file_;
  std::set<std::string> warned_;
  Names mesh_names_, material_names_, texture_names_, light_names_, camera_names_;
  std::map<int, MaterialPlan> plans_;  ///< by index in the file, -1: the default
  std::vector<int> materials_;         ///< of the scene's meshes, as in `plans_`
  std::map<int, DecodedImage> images_;
  std::map<std::tuple<int, TexelRole, TextureWrap, double, double, double>, int> textures_;
  std::size_t num_triangles_ = 0, num_unpacked_ = 0;
};

}  // namespace

SceneFile ReadGltf(const fs::path& path) { return GltfReader(path).Read(); }

}  // namespace pathfit::renderer
