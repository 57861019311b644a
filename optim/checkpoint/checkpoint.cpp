#include "optim/checkpoint/checkpoint.h"

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>
#include <type_traits>
#include <unordered_map>
#include <variant>
#include <vector>

#include <boost/crc.hpp>
#include <nlohmann/json.hpp>

#include "optim/parameter/promotion.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/scene/parameter_layout.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Bytes = Json::binary_t::container_type;
using renderer::EnvironmentEmitter;
using renderer::Material;
using renderer::Mesh;
using renderer::ParameterGroup;
using renderer::ParameterLayout;
using renderer::Rgb;
using renderer::Scene;

static_assert(std::endian::native == std::endian::little,
              "arrays are written as they are in memory");

constexpr const char* kFormat = "pathfit state 8";
constexpr std::size_t kKeptStates = 2;
constexpr std::string_view kPrefix = "state_";

/// CRC-32C.
class Checksum {
 public:
  template <class T>
  void Add(const std::vector<T>& values) {
    Add(values.data(), values.size() * sizeof(T));
  }
  void Add(const void* bytes, std::size_t count) { crc_.process_bytes(bytes, count); }
  [[nodiscard]] std::uint32_t value() const { return crc_.checksum(); }

 private:
  boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc_;
};

std::uint32_t ChecksumOf(const Bytes& bytes) {
  Checksum checksum;
  checksum.Add(bytes);
  return checksum.value();
}

/// Takes what is written to it to know its checksum and length: a state fills much of the memory,
/// and need not be there twice.
class ChecksumBuffer : public std::streambuf {
 public:
  [[nodiscard]] std::uint32_t checksum() const { return checksum_.value(); }
  [[nodiscard]] std::uint64_t size() const { return size_; }

 protected:
  std::streamsize xsputn(const char* bytes, std::streamsize count) override {
    checksum_.Add(bytes, static_cast<std::size_t>(count));
    size_ += static_cast<std::uint64_t>(count);
    return count;
  }
  int_type overflow(int_type c) override {
    const char byte = traits_type::to_char_type(c);
    xsputn(&byte, 1);
    return c;
  }

 private:
  Checksum checksum_;
  std::uint64_t size_ = 0;
};

/// Groups of all unknowns that are neither held nor replaced; where the scene's shapes differ, so
/// do the sizes.
ParameterLayout LayoutOf(const Scene& scene, const std::vector<UnknownSpec>& unknowns) {
  ParameterLayout layout(scene);
  for (const UnknownSpec& unknown : unknowns) {
    if (!unknown.hold && !IsReplaced(scene, unknown, unknowns)) {
      layout.Add(unknown.kind, unknown.object);
    }
  }
  return layout;
}

std::vector<double> ValuesOf(const ParameterGroup& group, const std::vector<double>& values) {
  const auto first = values.begin() + group.first_scalar;
  return {first, first + static_cast<std::ptrdiff_t>(group.NumScalars())};
}

/// Arrays of numbers, each content once; the rest of a state refers to them by index.
class ArrayWriter {
 public:
  template <class T>
  std::size_t Add(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    Bytes bytes(values.size() * sizeof(T));
    if (!bytes.empty()) {
      std::memcpy(bytes.data(), values.data(), bytes.size());
    }
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t hash = std::hash<std::string_view>()(text);
    for (auto [at, end] = index_by_hash_.equal_range(hash); at != end; ++at) {
      const Bytes& stored = arrays_[at->second].get_binary();
      if (stored == bytes) {
        return at->second;
      }
    }
    index_by_hash_.emplace(hash, arrays_.size());
    arrays_.push_back(Json::binary(std::move(bytes)));
    return arrays_.size() - 1;
  }
  Json Take() { return std::move(arrays_); }

 private:
  Json arrays_ = Json::array();
  std::unordered_multimap<std::size_t, std::size_t> index_by_hash_;
};

template <class T>
void ReadArray(const Json& arrays, const Json& index, std::vector<T>& values) {
  const Bytes& bytes = arrays.at(index.get<std::size_t>()).get_binary();
  if (bytes.size() % sizeof(T) != 0) {
    throw renderer::IoError("an array has a wrong size");
  }
  values.resize(bytes.size() / sizeof(T));
  if (!bytes.empty()) {
    std::memcpy(values.data(), bytes.data(), bytes.size());
  }
}

/// Calls visit(name, array) for every array of a mesh.
template <class MeshType, class Visitor>
void VisitArrays(MeshType& mesh, const Visitor& visit) {
  visit("positions", mesh.positions);
  visit("normals", mesh.normals);
  visit("uvs", mesh.uvs);
  visit("colors", mesh.colors);
  visit("triangles", mesh.triangles);
  visit("normal_triangles", mesh.normal_triangles);
  visit("uv_triangles", mesh.uv_triangles);
  visit("color_triangles", mesh.color_triangles);
}

bool SameShape(const Mesh& a, const Mesh& b) {
  return a.positions.size() == b.positions.size() && a.normals.size() == b.normals.size() &&
         a.uvs.size() == b.uvs.size() && a.colors.size() == b.colors.size() &&
         a.triangles == b.triangles && a.normal_triangles == b.normal_triangles &&
         a.uv_triangles == b.uv_triangles && a.color_triangles == b.color_triangles;
}

/// Textures and environments.
template <class Raster>
bool SameShape(const Raster& a, const Raster& b) {
  return a.width == b.width && a.height == b.height;
}

/// Materials: what stands in for their constants.
bool SameShape(const Material& a, const Material& b) {
  return a.vertex_colors == b.vertex_colors && a.base_color_texture == b.base_color_texture &&
         a.roughness_texture == b.roughness_texture && a.metallic_texture == b.metallic_texture &&
         a.normal_texture == b.normal_texture;
}

Json ShapeToJson(const Material& material, ArrayWriter& arrays) {
  const Rgb& color = material.base_color;
  return {{"vertex_colors", material.vertex_colors},
          {"base_color_texture", material.base_color_texture},
          {"roughness_texture", material.roughness_texture},
          {"metallic_texture", material.metallic_texture},
          {"normal_texture", material.normal_texture},
          {"base_color", arrays.Add(std::vector<double>{color.r, color.g, color.b})}};
}

void ShapeFromJson(const Json& json, const Json& arrays, Material& material) {
  json.at("vertex_colors").get_to(material.vertex_colors);
  json.at("base_color_texture").get_to(material.base_color_texture);
  json.at("roughness_texture").get_to(material.roughness_texture);
  json.at("metallic_texture").get_to(material.metallic_texture);
  material.normal_texture = json.value("normal_texture", -1);
  std::vector<double> color;
  ReadArray(arrays, json.at("base_color"), color);
  if (color.size() != 3) throw renderer::IoError("a base colour has a wrong size");
  material.base_color = {color[0], color[1], color[2]};
}

Json ShapeToJson(const Mesh& mesh, ArrayWriter& arrays) {
  Json json;
  VisitArrays(
      mesh, [&](const char* name, const auto& values) { json[name] = arrays.Add(values.Items()); });
  return json;
}

void ShapeFromJson(const Json& json, const Json& arrays, Mesh& mesh) {
  VisitArrays(mesh, [&](const char* name, auto& values) {
    ReadArray(arrays, json.at(name), values.Edit());
  });
}

template <class Raster>
Json ShapeToJson(const Raster& raster, ArrayWriter& arrays) {
  return {{"width", raster.width},
          {"height", raster.height},
          {"texels", arrays.Add(raster.texels.Items())}};
}

template <class Raster>
void ShapeFromJson(const Json& json, const Json& arrays, Raster& raster) {
  json.at("width").get_to(raster.width);
  json.at("height").get_to(raster.height);
  ReadArray(arrays, json.at("texels"), raster.texels.Edit());
}

/// Calls visit(name, shape of `a`, shape of `b`) for all that has one; the scenes list the same
/// objects.
template <class SceneType, class Visitor>
void VisitShapes(SceneType& a, const Scene& b, const Visitor& visit) {
  PATHFIT_CHECK_EQ(a.meshes.size(), b.meshes.size());
  PATHFIT_CHECK_EQ(a.materials.size(), b.materials.size());
  PATHFIT_CHECK_EQ(a.textures.size(), b.textures.size());
  PATHFIT_CHECK_EQ(a.emitters.size(), b.emitters.size());
  for (std::size_t i = 0; i < a.meshes.size(); ++i) {
    visit("mesh " + std::to_string(i), a.meshes[i].mesh, b.meshes[i].mesh);
  }
  for (std::size_t i = 0; i < a.materials.size(); ++i) {
    visit("material " + std::to_string(i), a.materials[i], b.materials[i]);
  }
  for (std::size_t i = 0; i < a.textures.size(); ++i) {
    visit("texture " + std::to_string(i), a.textures[i], b.textures[i]);
  }
  for (std::size_t i = 0; i < a.emitters.size(); ++i) {
    auto* environment = std::get_if<EnvironmentEmitter>(&a.emitters[i].light);
    if (environment != nullptr) {
      visit("emitter " + std::to_string(i),
            *environment,
            std::get<EnvironmentEmitter>(b.emitters[i].light));
    }
  }
}

/// Calls visit(name in the file, field) for all that a state or model is made of.
template <class State, class Visitor>
requires std::same_as<std::remove_const_t<State>, FitState>
void VisitFields(State& state, const Visitor& visit) {
  visit("fingerprint", state.fingerprint);
  visit("sequence", state.sequence);
  visit("step", state.step);
  visit("stage", state.stage);
  visit("round", state.round);
  visit("level", state.level);
  visit("level_start", state.level_start);
  visit("restarts", state.restarts);
  visit("accepted", state.accepted);
  visit("growths", state.growths);
  visit("wall_s", state.wall_s);
  visit("radius_factor", state.radius_factor);
  visit("step_share", state.step_share);
  visit("damping", state.damping);
  visit("rejected_in_row", state.rejected_in_row);
  visit("split", state.split);
  visit("costs", state.costs);
  visit("held_out_costs", state.held_out_costs);
  visit("promised_cost", state.promised_cost);
  visit("rounds", state.rounds);
  visit("within_error", state.within_error);
  visit("still", state.still);
  visit("flat", state.flat);
  visit("unexplained", state.unexplained);
  visit("precise", state.precise);
  visit("standard_errors", state.standard_errors);
  visit("scene", state.scene);
  visit("stage_start", state.stage_start);
  visit("level_scene", state.level_scene);
  visit("older", state.average.older);
  visit("newer", state.average.newer);
  visit("newer_start", state.average.newer_start);
}
template <class Model, class Visitor>
requires std::same_as<std::remove_const_t<Model>, QuadraticModel>
void VisitFields(Model& model, const Visitor& visit) {
  visit("weight", model.weight);
  visit("product", model.product);
  visit("square", model.square);
  visit("covariance", model.covariance);
  visit("scatter", model.scatter);
  visit("linear", model.linear);
  visit("variance", model.variance);
}

template <class Sums, class Visitor>
requires std::same_as<std::remove_const_t<Sums>, RoundSums>
void VisitFields(Sums& sums, const Visitor& visit) {
  visit("model", sums.model);
  visit("apart", sums.apart);
  visit("rows", sums.rows);
}
template <class History, class Visitor>
requires std::same_as<std::remove_const_t<History>, RowHistory>
void VisitFields(History& history, const Visitor& visit) {
  visit("weight", history.weight);
  visit("theta", history.theta);
  visit("views", history.views);
}
template <class Rows, class Visitor>
requires std::same_as<std::remove_const_t<Rows>, SummedRows>
void VisitFields(Rows& rows, const Visitor& visit) {
  visit("units", rows.units);
  visit("residuals", rows.residuals);
  visit("jacobians", rows.jacobians);
}

template <class T>
concept PlainField = std::is_arithmetic_v<T> || std::same_as<T, std::string>;
template <class T>
concept FieldsOfState =
    std::same_as<T, RoundSums> || std::same_as<T, QuadraticModel> || std::same_as<T, RowHistory>;

/// States as CBOR relative to one origin.
class Codec {
 public:
  explicit Codec(const FitOrigin& origin) : origin_(origin) {
    const ParameterLayout layout = LayoutOf(origin.start, origin.unknowns);
    const std::vector<double> values = layout.Gather(origin.start);
    for (const ParameterGroup& group : layout.groups()) {
      names_.push_back(group.name);
      start_values_[group.name] = ValuesOf(group, values);
    }
    Checksum checksum;
    checksum.Add(values);
    for (const renderer::SceneMesh& mesh : origin.start.meshes) {
      checksum.Add(mesh.mesh.triangles.Items());
    }
    start_checksum_ = checksum.value();
  }

  /// To be written as CBOR.
  [[nodiscard]] Json Encode(const FitState& state) const {
    ArrayWriter arrays;
    Json json = FieldsToJson(state, arrays);
    json["unknowns"] = names_;
    json["start"] = start_checksum_;
    json["arrays"] = arrays.Take();
    return json;
  }

  [[nodiscard]] FitState Decode(const Bytes& bytes) const {
    const Json json = Json::from_cbor(bytes);
    if (json.at("unknowns").get<std::vector<std::string>>() != names_ ||
        json.at("start") != start_checksum_) {
      throw renderer::IoError(
          "it belongs to another experiment: the unknowns or their values at the start differ");
    }
    FitState state;
    FieldsFromJson(json, json.at("arrays"), state);
    if (!HasWeightsOfRounds(state.average, state.RoundsOfLevel())) {
      throw renderer::IoError("it is damaged: no rounds have the weights of its averages");
    }
    return state;
  }

 private:
  template <class T>
  [[nodiscard]] Json FieldsToJson(const T& value, ArrayWriter& arrays) const {
    Json json;
    VisitFields(value,
                [&](const char* name, const auto& field) { json[name] = ToJson(field, arrays); });
    return json;
  }
  template <class T>
  void FieldsFromJson(const Json& json, const Json& arrays, T& value) const {
    VisitFields(value,
                [&](const char* name, auto& field) { FromJson(json.at(name), arrays, field); });
  }

  template <PlainField T>
  [[nodiscard]] Json ToJson(const T& value, ArrayWriter& /*arrays*/) const {
    return value;
  }
  template <PlainField T>
  void FromJson(const Json& json, const Json& /*arrays*/, T& value) const {
    json.get_to(value);
  }

  template <class T>
  requires std::is_arithmetic_v<T>
  [[nodiscard]] Json ToJson(const std::vector<T>& values, ArrayWriter& arrays) const {
    return arrays.Add(values);
  }
  template <class T>
  requires std::is_arithmetic_v<T>
  void FromJson(const Json& json, const Json& arrays, std::vector<T>& values) const {
    ReadArray(arrays, json, values);
  }

  [[nodiscard]] Json ToJson(const std::vector<SummedRows>& views, ArrayWriter& arrays) const {
    Json json = Json::array();
    for (const SummedRows& view : views) json.push_back(FieldsToJson(view, arrays));
    return json;
  }
  void FromJson(const Json& json, const Json& arrays, std::vector<SummedRows>& views) const {
    views.resize(json.size());
    for (std::size_t i = 0; i < views.size(); ++i) FieldsFromJson(json.at(i), arrays, views[i]);
  }

  [[nodiscard]] Json ToJson(const std::map<std::string, std::vector<double>>& map,
                            ArrayWriter& arrays) const {
    Json json = Json::object();
    for (const auto& [name, values] : map) json[name] = arrays.Add(values);
    return json;
  }
  void FromJson(const Json& json,
                const Json& arrays,
                std::map<std::string, std::vector<double>>& map) const {
    for (const auto& [name, values] : json.items()) ReadArray(arrays, values, map[name]);
  }

  [[nodiscard]] Json ToJson(const renderer::SampleBudget& split, ArrayWriter& /*arrays*/) const {
    Json json = Json::array();
    for (const auto budget : renderer::kBoundaryBudgets) json.push_back(split.*budget);
    return json;
  }
  void FromJson(const Json& json, const Json& /*arrays*/, renderer::SampleBudget& split) const {
    for (std::size_t i = 0; i < renderer::kBoundaryBudgets.size(); ++i) {
      json.at(i).get_to(split.*renderer::kBoundaryBudgets[i]);
    }
  }

  template <FieldsOfState T>
  [[nodiscard]] Json ToJson(const T& value, ArrayWriter& arrays) const {
    return FieldsToJson(value, arrays);
  }
  template <FieldsOfState T>
  void FromJson(const Json& json, const Json& arrays, T& value) const {
    FieldsFromJson(json, arrays, value);
  }

  [[nodiscard]] Json ToJson(const Scene& scene, ArrayWriter& arrays) const {
    Json shapes = Json::object();
    VisitShapes(
        scene, origin_.start, [&](const std::string& name, const auto& shape, const auto& start) {
          if (!SameShape(shape, start)) {
            shapes[name] = ShapeToJson(shape, arrays);
          }
        });
    Json values = Json::object();
    const ParameterLayout layout = LayoutOf(scene, origin_.unknowns);
    const std::vector<double> all = layout.Gather(scene);
    for (const ParameterGroup& group : layout.groups()) {
      const std::vector<double> now = ValuesOf(group, all);
      const auto start = start_values_.find(group.name);
      const bool as_in_start =
          start != start_values_.end() && now.size() == start->second.size() &&
          std::memcmp(now.data(), start->second.data(), now.size() * sizeof(double)) == 0;
      if (!as_in_start) values[group.name] = arrays.Add(now);
    }
    return {{"shapes", shapes}, {"values", values}};
  }

  [[nodiscard]] Json ToJson(const WeightedScene& mean, ArrayWriter& arrays) const {
    if (mean.weight == 0.0) {
      return {};
    }
    return {{"weight", mean.weight}, {"scene", ToJson(mean.scene, arrays)}};
  }

  void FromJson(const Json& json, const Json& arrays, Scene& scene) const {
    scene = origin_.start;
    const Json& shapes = json.at("shapes");
    VisitShapes(
        scene, origin_.start, [&](const std::string& name, auto& shape, const auto& /*start*/) {
          if (shapes.contains(name)) {
            ShapeFromJson(shapes.at(name), arrays, shape);
          }
        });
    const ParameterLayout layout = LayoutOf(scene, origin_.unknowns);
    std::vector<double> all;
    for (const ParameterGroup& group : layout.groups()) {
      std::vector<double> values;
      const Json& changed = json.at("values");
      if (changed.contains(group.name)) {
        ReadArray(arrays, changed.at(group.name), values);
      } else if (const auto start = start_values_.find(group.name); start != start_values_.end()) {
        values = start->second;
      }
      if (values.size() != group.NumScalars()) {
        throw renderer::IoError("'" + group.name + "' has a wrong size");
      }
      all.insert(all.end(), values.begin(), values.end());
    }
    layout.Scatter(all, scene);
  }

  void FromJson(const Json& json, const Json& arrays, WeightedScene& mean) const {
    if (json.is_null()) return;
    json.at("weight").get_to(mean.weight);
    FromJson(json.at("scene"), arrays, mean.scene);
  }

  FitOrigin origin_;
  std::vector<std::string> names_;
  std::map<std::string, std::vector<double>> start_values_;  ///< by group
  std::uint32_t start_checksum_ = 0;
};

/// Newest first.
std::vector<fs::path> StatePaths(const fs::path& folder) {
  std::vector<fs::path> states;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().filename().string().starts_with(kPrefix)) {
      states.push_back(entry.path());
    }
  }
  std::sort(states.begin(), states.end(), std::greater<>());
  return states;
}

/// Whether a file begins as WriteCheckpoint's: a map of three, of which only the checksum's number
/// and a digit of the format may vary, before bytes in one piece. The parser goes one call deeper
/// for each level of what it reads, so it gets nothing else before the checksum was compared.
bool HasHeader(std::string_view bytes) {
  const auto take = [&bytes](std::string_view expected) {
    const bool is_there = bytes.starts_with(expected);
    if (is_there) bytes.remove_prefix(expected.size());
    return is_there;
  };
  const auto skip = [&bytes](std::size_t count) {
    bytes.remove_prefix(std::min(count, bytes.size()));
  };
  if (!take("\xa3\x66"
            "crc32c") ||
      bytes.empty())
    return false;
  const unsigned number = static_cast<unsigned char>(bytes.front());
  if (number > 0x1a) return false;  // more than 4 bytes, or no number
  skip(number < 0x18 ? 1 : 1 + (std::size_t{1} << (number - 0x18)));
  if (!take("\x66"
            "format\x6f"
            "pathfit state "))
    return false;
  skip(1);
  if (!take("\x67"
            "payload") ||
      bytes.empty())
    return false;
  const unsigned payload = static_cast<unsigned char>(bytes.front());
  return payload >= 0x40 && payload <= 0x5b;
}

FitState ReadState(const fs::path& path, const Codec& codec) {
  if (fs::is_directory(path)) {
    throw renderer::IoError("it was written by an earlier version of the program");
  }
  try {
    const std::string bytes = renderer::ReadWholeFile(path);
    if (!HasHeader(bytes)) throw renderer::IoError("it is damaged: it does not begin as a state");
    const Json json = Json::from_cbor(bytes);
    if (json.at("format") != kFormat) {
      throw renderer::IoError("it is no \"" + std::string(kFormat) + "\"");
    }
    const Bytes& payload = json.at("payload").get_binary();
    if (json.at("crc32c") != ChecksumOf(payload)) {
      throw renderer::IoError("it is damaged: its checksum is wrong");
    }
    return codec.Decode(payload);
  } catch (const Json::exception& error) {
    throw renderer::IoError(std::string("it is damaged: ") + error.what());
  }
}

/// Of the file's map all but the bytes of the payload, which comes last.
void WriteHeader(std::uint32_t checksum, std::uint64_t size, std::ostream& stream) {
  Bytes head = Json::to_cbor(Json{{"format", kFormat}, {"crc32c", checksum}});
  head.front() = static_cast<std::uint8_t>(head.front() + 1);  // one entry more in the map
  const Bytes key = Json::to_cbor(Json("payload"));
  head.insert(head.end(), key.begin(), key.end());
  head.push_back(0x5b);  // a byte string, its length in eight bytes
  for (int shift = 56; shift >= 0; shift -= 8) {
    head.push_back(static_cast<std::uint8_t>(size >> static_cast<unsigned>(shift)));
  }
  stream.write(reinterpret_cast<const char*>(head.data()),
               static_cast<std::streamsize>(head.size()));
}

void WriteState(const fs::path& path, const FitOrigin& origin, const FitState& state) {
  const Json json = Codec(origin).Encode(state);
  ChecksumBuffer buffer;
  std::ostream measured(&buffer);
  Json::to_cbor(json, measured);
  fs::create_directories(path.parent_path());
  renderer::WriteThroughTemporary(path, [&](const fs::path& temporary) {
    std::ofstream stream(temporary, std::ios::binary);
    WriteHeader(buffer.checksum(), buffer.size(), stream);
    Json::to_cbor(json, stream);
    stream.close();
    if (!stream) {
      throw renderer::IoError(path.string() + ": cannot be written (disk full?)");
    }
  });
}

renderer::IoError CannotWrite(const fs::path& folder, const fs::filesystem_error& error) {
  return renderer::IoError(folder.string() + ": cannot write a checkpoint: " + error.what());
}

fs::path StageEndPath(const fs::path& folder, int stage) {
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "stage_%02d.cbor", stage);
  return folder / name.data();
}

}  // namespace

bool HasWeightsOfRounds(const AverageState& average, int round) {
  const double most = static_cast<double>(round) * std::numeric_limits<int>::max();
  const double older = average.older.weight;
  const double newer = average.newer.weight;
  return older >= 0.0 && newer >= 0.0 && older + newer <= most && (newer > 0.0 || older == 0.0);
}

bool SameShapes(const Scene& a, const Scene& b) {
  bool same = true;
  VisitShapes(a, b, [&](const std::string& /*name*/, const auto& of_a, const auto& of_b) {
    same = same && SameShape(of_a, of_b);
  });
  return same;
}

std::vector<char> EncodeState(const FitOrigin& origin, const FitState& state) {
  const Bytes bytes = Json::to_cbor(Codec(origin).Encode(state));
  return {bytes.begin(), bytes.end()};
}

FitState DecodeState(const FitOrigin& origin, const std::vector<char>& bytes) {
  return Codec(origin).Decode({bytes.begin(), bytes.end()});
}

void WriteCheckpoint(const fs::path& folder, const FitOrigin& origin, const FitState& state) {
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "state_%06d.cbor", state.sequence);
  try {
    WriteState(folder / name.data(), origin, state);
    const std::vector<fs::path> states = StatePaths(folder);
    for (std::size_t i = kKeptStates; i < states.size(); ++i) {
      fs::remove_all(states[i]);
    }
  } catch (const fs::filesystem_error& error) {
    throw CannotWrite(folder, error);
  }
}

void WriteStageEnd(const fs::path& folder,
                   const FitOrigin& origin,
                   int stage,
                   const renderer::Scene& scene) {
  FitState state;
  state.stage = stage;
  state.scene = state.stage_start = state.level_scene = scene;
  try {
    WriteState(StageEndPath(folder, stage), origin, state);
  } catch (const fs::filesystem_error& error) {
    throw CannotWrite(folder, error);
  }
}

std::optional<renderer::Scene> ReadStageEnd(const fs::path& folder,
                                            const FitOrigin& origin,
                                            int stage) {
  const fs::path path = StageEndPath(folder, stage);
  if (!fs::exists(path)) return std::nullopt;
  try {
    return ReadState(path, Codec(origin)).scene;
  } catch (const renderer::IoError& error) {
    throw renderer::IoError(path.string() + ": " + error.what());
  }
}

NewestCheckpoint ReadNewestCheckpoint(const fs::path& folder, const FitOrigin& origin) {
  NewestCheckpoint newest;
  const Codec codec(origin);
  for (const fs::path& path : StatePaths(folder)) {
    try {
      newest.state = ReadState(path, codec);
      return newest;
    } catch (const renderer::IoError& error) {
      newest.damaged.push_back(path.string() + ": " + error.what());
    }
  }
  if (!newest.damaged.empty()) {
    std::string text = "no checkpoint can be read";
    for (const std::string& reason : newest.damaged) {
      text += "\n  " + reason;
    }
    throw renderer::IoError(text);
  }
  return newest;
}

}  // namespace pathfit::optim
