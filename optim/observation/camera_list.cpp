#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "optim/observation/camera_import.h"
#include "optim/observation/image_size.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using renderer::IoError;
using renderer::Vec3;

constexpr std::size_t kMaxFileBytes = std::size_t{16} << 20U;

/// A value of the file and where it stands.
struct Value {
  YAML::Node node;
  std::string file, key;

  [[nodiscard]] std::string Place() const {
    const YAML::Mark mark = node.Mark();
    return file + ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1) +
           ": " + key;
  }
  [[nodiscard]] double Number() const {
    const std::string text = node.IsScalar() ? node.Scalar() : std::string();
    const std::optional<double> number = renderer::ParseReal(text);
    if (!number) {
      throw IoError(Place() + (node.IsScalar() ? ": '" + text.substr(0, 40) + "'" : "") +
                    " is not a finite number");
    }
    return *number;
  }
  [[nodiscard]] std::string Text() const {
    if (!node.IsScalar() || node.Scalar().empty()) throw IoError(Place() + " must be a text");
    return node.Scalar();
  }
  [[nodiscard]] std::vector<Value> List(std::size_t least, std::size_t most) const {
    if (!node.IsSequence() || node.size() < least || node.size() > most) {
      throw IoError(Place() + " must be a list of " + std::to_string(least) +
                    (most == least ? "" : " or " + std::to_string(most)));
    }
    std::vector<Value> items;
    for (const YAML::Node& item : node) {
      items.push_back({item, file, key + "[" + std::to_string(items.size()) + "]"});
    }
    return items;
  }
  [[nodiscard]] std::vector<double> Numbers(std::size_t least, std::size_t most) const {
    std::vector<double> numbers;
    for (const Value& item : List(least, most)) numbers.push_back(item.Number());
    return numbers;
  }
  [[nodiscard]] Vec3 Triple() const {
    const std::vector<double> n = Numbers(3, 3);
    return {n[0], n[1], n[2]};
  }
  /// One number for both or one for each.
  [[nodiscard]] std::vector<double> Pair() const {
    if (node.IsScalar()) return {Number(), Number()};
    return Numbers(2, 2);
  }
};

using Words = std::span<const std::string_view>;
constexpr std::array<std::string_view, 7> kLensKeys = {
    "type", "size_px", "focal_px", "principal_point_px", "distortion", "vignetting", "axes"};
constexpr std::array<std::string_view, 2> kFileKeys = {"metres_per_unit", "cameras"};
constexpr std::array<std::string_view, 4> kCameraKeys = {
    "image", "mask", "world_from_camera", "look_at"};
constexpr std::array<std::string_view, 5> kBrownKeys = {"k1", "k2", "k3", "p1", "p2"};
constexpr std::array<std::string_view, 3> kVignettingKeys = {"v1", "v2", "v3"};
constexpr std::array<std::string_view, 3> kLookAtKeys = {"origin", "target", "up"};

/// The values of a map, whose keys must be among `known`.
class Entries {
 public:
  Entries(const Value& map, Words known, Words more = {}) {
    if (!map.node.IsMap()) throw IoError(map.Place() + " must be a map");
    for (const auto& entry : map.node) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "(not a name)";
      const Value value{entry.second, map.file, (map.key.empty() ? "" : map.key + ".") + key};
      const Value name{entry.first, map.file, value.key};
      if (std::ranges::find(known, key) == known.end() &&
          std::ranges::find(more, key) == more.end()) {
        std::string words;
        for (const Words list : {known, more}) {
          for (const std::string_view word : list) {
            words += (words.empty() ? "" : ", ") + std::string(word);
          }
        }
        throw IoError(name.Place() + " is no key here (allowed: " + words + ")");
      }
      if (!values_.emplace(key, value).second) throw IoError(name.Place() + " is there twice");
    }
  }
  [[nodiscard]] const Value* Find(const char* key) const {
    const auto found = values_.find(key);
    return found == values_.end() ? nullptr : &found->second;
  }
  [[nodiscard]] double NumberOrZero(const char* key) const {
    const Value* value = Find(key);
    return value == nullptr ? 0.0 : value->Number();
  }

 private:
  std::map<std::string, Value> values_;
};

/// What a camera says, else what the file says for all.
class Lens {
 public:
  Lens(const Entries& camera, const Entries& file) : camera_(camera), file_(file) {}

  void Read(const std::string& place, ImportedCamera& imported) const {
    renderer::Camera& camera = imported.camera;
    if (const Value* type = Find("type")) {
      if (OneOf(*type, {"perspective", "orthographic"}) == 1) {
        camera.projection = renderer::ProjectionKind::kOrthographic;
      }
    }
    if (const Value* size = Find("size_px")) {
      const std::vector<Value> sides = size->List(2, 2);
      camera.width = CheckedImageSize(sides[0].Number(), sides[0].Place());
      camera.height = CheckedImageSize(sides[1].Number(), sides[1].Place());
    }
    const Value* focal = Find("focal_px");
    if (focal == nullptr) throw IoError(place + " has no focal_px");
    const std::vector<double> f = focal->Pair();
    if (!(f[0] > 0.0 && f[1] > 0.0)) throw IoError(focal->Place() + " must be positive");
    camera.fx = f[0];
    camera.fy = f[1];
    const Value* centre = Find("principal_point_px");
    imported.has_principal_point = centre != nullptr;
    if (centre != nullptr) {
      const std::vector<double> c = centre->Numbers(2, 2);
      camera.cx = c[0];
      camera.cy = c[1];
    }
    if (const Value* distortion = Find("distortion")) {
      const Entries terms(*distortion, kBrownKeys);
      camera.distortion = {.k1 = terms.NumberOrZero("k1"),
                           .k2 = terms.NumberOrZero("k2"),
                           .k3 = terms.NumberOrZero("k3"),
                           .p1 = terms.NumberOrZero("p1"),
                           .p2 = terms.NumberOrZero("p2")};
    }
    if (const Value* vignetting = Find("vignetting")) {
      const Entries terms(*vignetting, kVignettingKeys);
      camera.vignetting = {.v1 = terms.NumberOrZero("v1"),
                           .v2 = terms.NumberOrZero("v2"),
                           .v3 = terms.NumberOrZero("v3")};
    }
  }
  /// Whether the camera's axes are x right, y down, z forward.
  [[nodiscard]] bool IsForward() const {
    const Value* axes = Find("axes");
    return axes != nullptr && OneOf(*axes, {"opengl", "opencv"}) == 1;
  }

 private:
  [[nodiscard]] const Value* Find(const char* key) const {
    const Value* own = camera_.Find(key);
    return own != nullptr ? own : file_.Find(key);
  }
  static int OneOf(const Value& value, const std::array<std::string_view, 2>& words) {
    const std::string text = value.Text();
    if (text != words[0] && text != words[1]) {
      throw IoError(value.Place() + ": '" + text.substr(0, 40) + "' is neither " +
                    std::string(words[0]) + " nor " + std::string(words[1]));
    }
    return text == words[1] ? 1 : 0;
  }

  const Entries& camera_;
  const Entries& file_;
};

renderer::Transform ReadMatrix(const Value& matrix, bool is_forward) {
  const std::string place = matrix.Place();
  std::vector<std::vector<double>> m;
  for (const Value& row : matrix.List(3, 4)) m.push_back(row.Numbers(4, 4));
  if (m.size() == 4 && m[3] != std::vector<double>{0.0, 0.0, 0.0, 1.0}) {
    throw IoError(place + ": the last row must be 0 0 0 1");
  }
  const renderer::Mat3 rotation = ExactRotation(
      {{m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}},
      place);
  const Vec3 centre{m[0][3], m[1][3], m[2][3]};
  if (is_forward) return PoseFromForwardAxes(rotation, centre, place);
  return {rotation, CheckedCentre(centre, place)};
}

renderer::Transform ReadLookAt(const Value& look_at) {
  const Entries entries(look_at, kLookAtKeys);
  const Value* origin = entries.Find("origin");
  const Value* target = entries.Find("target");
  const Value* up = entries.Find("up");
  if (origin == nullptr || target == nullptr) {
    throw IoError(look_at.Place() + " needs origin and target");
  }
  const Vec3 from = CheckedCentre(origin->Triple(), origin->Place());
  const Vec3 to = CheckedCentre(target->Triple(), target->Place());
  const Vec3 upwards =
      up == nullptr ? Vec3{0.0, 1.0, 0.0} : CheckedCentre(up->Triple(), up->Place());
  try {
    return renderer::LookAt(from, to, upwards);
  } catch (const std::invalid_argument& error) {
    throw IoError(look_at.Place() + ": " + error.what());
  }
}

}  // namespace

ImportedCameras ReadCameraList(const fs::path& path) {
  const std::string name = path.string();
  const std::string text = renderer::ReadWholeFile(path);
  if (text.size() > kMaxFileBytes) throw IoError(name + ": is larger than 16 MiB");
  ImportedCameras result;
  result.folder = path.parent_path();
  result.image_folders = {result.folder};
  result.files = {path};
  try {
    const Value root{YAML::Load(text), name, ""};
    if (!root.node.IsMap()) throw IoError(name + ": must hold a map with a list called cameras");
    const Entries file(root, kFileKeys, kLensKeys);
    if (const Value* unit = file.Find("metres_per_unit")) {
      result.metres_per_unit = unit->Number();
      if (result.metres_per_unit <= 0.0) throw IoError(unit->Place() + " must be positive");
    }
    const Value* cameras = file.Find("cameras");
    if (cameras == nullptr) throw IoError(name + ": has no list called cameras");
    if (!cameras->node.IsSequence() || cameras->node.size() == 0) {
      throw IoError(cameras->Place() + " must be a list with at least one camera");
    }
    for (const YAML::Node& node : cameras->node) {
      const Value camera{node, name, "cameras[" + std::to_string(result.cameras.size()) + "]"};
      const Entries own(camera, kCameraKeys, kLensKeys);
      ImportedCamera& imported = result.cameras.emplace_back();
      imported.place = camera.Place();
      const Value* image = own.Find("image");
      if (image == nullptr) throw IoError(imported.place + " has no image");
      imported.image = image->Text();
      imported.camera.name = imported.image;
      if (const Value* mask = own.Find("mask")) imported.mask = mask->Text();
      const Lens lens(own, file);
      lens.Read(imported.place, imported);
      const Value* matrix = own.Find("world_from_camera");
      const Value* look_at = own.Find("look_at");
      if ((matrix == nullptr) == (look_at == nullptr)) {
        throw IoError(imported.place + " needs one of world_from_camera and look_at");
      }
      imported.camera.world_from_camera =
          matrix != nullptr ? ReadMatrix(*matrix, lens.IsForward()) : ReadLookAt(*look_at);
    }
  } catch (const YAML::Exception& error) {
    throw IoError(name + ":" + std::to_string(error.mark.line + 1) + ": not valid YAML (" +
                  error.msg + ")");
  }
  return result;
}

}  // namespace pathfit::optim
