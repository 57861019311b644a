#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <system_error>
#include <vector>

#include "optim/observation/camera_import.h"
#include "optim/observation/image_size.h"
#include "optim/observation/json_entry.h"
#include "renderer/core/error.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using renderer::IoError;

/// A number, which this format writes as text.
double Number(const json& value, const std::string& place) {
  std::optional<double> number;
  if (value.is_number()) number = value.get<double>();
  if (value.is_string()) number = renderer::ParseReal(value.get_ref<const std::string&>());
  if (!number || !std::isfinite(*number)) {
    throw IoError(place + ": " + JsonEntry::Shown(value) + " is not a finite number");
  }
  return *number;
}

const json* Find(const JsonEntry& entry, const char* key) {
  const auto found = entry.value.find(key);
  return found == entry.value.end() || found->is_null() ? nullptr : &*found;
}
const json& Get(const JsonEntry& entry, const char* key) {
  const json* found = Find(entry, key);
  if (found == nullptr) throw IoError(entry.place + "." + key + " is missing");
  return *found;
}
double Get(const JsonEntry& entry, const char* key, double otherwise) {
  const json* found = Find(entry, key);
  return found == nullptr ? otherwise : Number(*found, entry.place + "." + key);
}

/// A list of `count` numbers, any number of them if that is 0.
std::vector<double> Numbers(const json& value, std::size_t count, const std::string& place) {
  if (!value.is_array() || (count > 0 && value.size() != count)) {
    throw IoError(place + " must be a list of " + (count > 0 ? std::to_string(count) + " " : "") +
                  "numbers");
  }
  std::vector<double> numbers;
  for (const json& item : value) numbers.push_back(Number(item, place));
  return numbers;
}

bool HasPoints(const JsonEntry& file) {
  const json* structure = Find(file, "structure");
  return structure != nullptr && !structure->empty();
}

/// An identifier: written as text, or as a number.
std::string Id(const JsonEntry& entry, const char* key) {
  const json& value = Get(entry, key);
  if (!value.is_string() && !value.is_number_integer()) {
    throw IoError(entry.place + "." + key + ": " + JsonEntry::Shown(value) +
                  " is not an identifier");
  }
  return value.is_string() ? value.get<std::string>() : JsonEntry::Shown(value);
}

/// The objects in a list of the file.
std::vector<JsonEntry> Objects(const JsonEntry& file, const char* key) {
  const json& list = Get(file, key);
  if (!list.is_array() || list.empty()) {
    throw IoError(file.place + "." + key + " must be a list with at least one entry");
  }
  std::vector<JsonEntry> objects;
  for (std::size_t i = 0; i < list.size(); ++i) {
    objects.push_back({list[i], file.place + ": " + key + "[" + std::to_string(i) + "]"});
    if (!list[i].is_object()) throw IoError(objects.back().place + " must be an object");
  }
  return objects;
}

/// Versions from here on mean something else by a key; numbers are major, minor, revision.
using Version = std::array<double, 3>;
constexpr Version kFocalTwice = {1, 2, 0};
constexpr Version kOffsetFromCentre = {1, 2, 1};
constexpr Version kFocalInMillimetres = {1, 2, 2};
constexpr Version kPixelAspect = {1, 2, 5};

int ImageSize(const JsonEntry& entry, const char* key) {
  const std::string place = entry.place + "." + key;
  return CheckedImageSize(Number(Get(entry, key), place), place);
}

void ReadFocalLengths(const JsonEntry& entry, const Version& version, renderer::Camera& camera) {
  if (version < kFocalTwice) {
    camera.fx = camera.fy = Number(Get(entry, "pxFocalLength"), entry.place + ".pxFocalLength");
  } else if (version < kFocalInMillimetres) {
    const std::vector<double> both =
        Numbers(Get(entry, "pxFocalLength"), 2, entry.place + ".pxFocalLength");
    camera.fx = both[0];
    camera.fy = both[1];
  } else {
    const double focal = Number(Get(entry, "focalLength"), entry.place + ".focalLength");
    const double sensor = Number(Get(entry, "sensorWidth"), entry.place + ".sensorWidth");
    const double ratio = Get(entry, "pixelRatio", 1.0);
    if (!(sensor > 0.0) || !(ratio > 0.0)) {
      throw IoError(entry.place + ": sensorWidth and pixelRatio must be positive");
    }
    camera.fx = focal / sensor * camera.width;
    camera.fy = version < kPixelAspect ? camera.fx / ratio : camera.fx * ratio;
  }
  if (!(camera.fx > 0.0 && camera.fy > 0.0 && std::isfinite(camera.fx * camera.fy))) {
    throw IoError(entry.place + ": the focal length must be positive");
  }
}

void ReadDistortion(const JsonEntry& entry, renderer::Camera& camera) {
  // "pinhole" with a distortionType since 1.2.7, before that one word for both.
  std::string model = entry.Text("type").value_or("pinhole");
  if (model == "pinhole") model = entry.Text("distortionType").value_or("none");
  std::vector<double> k;
  if (const json* list = Find(entry, "distortionParams"); list != nullptr && list->is_array()) {
    k = Numbers(*list, 0, entry.place + ".distortionParams");
  }
  const auto expect = [&](std::size_t count) {
    if (k.size() == count) return;
    throw IoError(entry.place + ".distortionParams: " + model + " has " + std::to_string(count) +
                  " numbers, not " + std::to_string(k.size()));
  };
  renderer::LensDistortion& lens = camera.distortion;
  if (model == "radial1" || model == "radialk1") {
    expect(1);
    lens.k1 = k[0];
  } else if (model == "radial3" || model == "radialk3") {
    expect(3);
    lens = {.k1 = k[0], .k2 = k[1], .k3 = k[2], .p1 = 0.0, .p2 = 0.0};
  } else if (model == "brown") {
    expect(5);
    lens = {.k1 = k[0], .k2 = k[1], .k3 = k[2], .p1 = k[3], .p2 = k[4]};
  } else if (model != "none") {
    throw IoError(entry.place + ": the lens model " + model +
                  " is not supported (allowed: none, radialk1, radialk3, brown); choose one of "
                  "these in CameraInit, or undistort the photos");
  } else if (std::ranges::any_of(k, [](double c) { return c != 0.0; })) {
    throw IoError(entry.place + ".distortionParams: a pinhole has none");
  }
}

renderer::Camera ReadIntrinsic(const JsonEntry& entry, const Version& version) {
  renderer::Camera camera;
  camera.width = ImageSize(entry, "width");
  camera.height = ImageSize(entry, "height");
  ReadFocalLengths(entry, version, camera);
  const std::vector<double> point =
      Numbers(Get(entry, "principalPoint"), 2, entry.place + ".principalPoint");
  const double shift = version < kOffsetFromCentre ? 0.0 : 0.5;
  camera.cx = point[0] + shift * camera.width;
  camera.cy = point[1] + shift * camera.height;
  ReadDistortion(entry, camera);
  return camera;
}

renderer::Transform ReadPose(const JsonEntry& entry) {
  const json& pose = Get(entry, "pose");
  const std::string place = entry.place + ".pose";
  if (!pose.is_object()) throw IoError(place + " must be an object");
  const json& transform = Get({pose, place}, "transform");
  if (!transform.is_object()) throw IoError(place + ".transform must be an object");
  const JsonEntry parts{transform, place + ".transform"};
  // camera_from_world by columns, so that its rows are the axes of the camera.
  const std::vector<double> r = Numbers(Get(parts, "rotation"), 9, parts.place + ".rotation");
  const std::vector<double> c = Numbers(Get(parts, "center"), 3, parts.place + ".center");
  return PoseFromForwardAxes(
      ExactRotation({{r[0], r[3], r[6]}, {r[1], r[4], r[7]}, {r[2], r[5], r[8]}},
                    parts.place + ".rotation"),
      {c[0], c[1], c[2]},
      parts.place + ".center");
}

template <class Value, class Read>
std::map<std::string, Value> ReadById(const JsonEntry& file,
                                      const char* list,
                                      const char* key,
                                      const Read& read) {
  std::map<std::string, Value> values;
  for (const JsonEntry& entry : Objects(file, list)) {
    if (!values.emplace(Id(entry, key), read(entry)).second) {
      throw IoError(entry.place + "." + key + " is given twice");
    }
  }
  return values;
}

/// As it is called, or beside the file where it was moved with it.
std::string PhotoName(const std::string& path) {
  std::error_code ignored;
  const fs::path photo(path);
  return photo.is_absolute() && !fs::exists(photo, ignored) ? photo.filename().string() : path;
}

}  // namespace

ImportedCameras ReadAliceVisionSfm(const fs::path& path) {
  const json document = ParseJsonFile(path);
  const JsonEntry file{document, path.string()};
  if (!document.is_object()) throw IoError(file.place + ": the file must hold a JSON object");
  const std::vector<double> numbers = Numbers(Get(file, "version"), 3, file.place + ": version");
  const Version version = {numbers[0], numbers[1], numbers[2]};
  if (version[0] != 1.0) throw IoError(file.place + ": version: only 1 is known");
  const auto lenses =
      ReadById<renderer::Camera>(file, "intrinsics", "intrinsicId", [&](const JsonEntry& entry) {
        return ReadIntrinsic(entry, version);
      });
  const auto poses = ReadById<renderer::Transform>(file, "poses", "poseId", ReadPose);
  ImportedCameras result;
  result.folder = path.parent_path();
  result.image_folders = {result.folder, result.folder / "images"};
  result.files = {path};
  if (HasPoints(file)) result.points = path;
  std::size_t left_out = 0;
  for (const JsonEntry& view : Objects(file, "views")) {
    if (Find(view, "rigId") != nullptr) {
      throw IoError(view.place + ": rigs of cameras are not supported (rigId)");
    }
    const auto pose =
        Find(view, "poseId") == nullptr ? poses.end() : poses.find(Id(view, "poseId"));
    if (pose == poses.end()) {
      ++left_out;
      continue;
    }
    const std::string intrinsic = Id(view, "intrinsicId");
    const auto lens = lenses.find(intrinsic);
    if (lens == lenses.end()) {
      throw IoError(view.place + ": intrinsic " + intrinsic + " is not in the file");
    }
    const std::optional<std::string> image = view.Text("path");
    if (!image) throw IoError(view.place + ".path is missing");
    ImportedCamera& imported = result.cameras.emplace_back();
    imported.image = PhotoName(*image);
    imported.place = view.place;
    imported.camera = lens->second;
    imported.camera.name = imported.image;
    imported.camera.world_from_camera = pose->second;
  }
  if (result.cameras.empty()) throw IoError(file.place + ": no view has a pose");
  if (left_out > 0) {
    result.notes.push_back("Left out: " + std::to_string(left_out) +
                           " views of the camera file without a pose.");
  }
  return result;
}

std::vector<renderer::Vec3> ReadAliceVisionPoints(const fs::path& path) {
  const json document = ParseJsonFile(path);
  const JsonEntry file{document, path.string()};
  if (!document.is_object()) throw IoError(file.place + ": the file must hold a JSON object");
  std::vector<renderer::Vec3> points;
  if (!HasPoints(file)) return points;
  for (const JsonEntry& landmark : Objects(file, "structure")) {
    const std::string place = landmark.place + ".X";
    const std::vector<double> at = Numbers(Get(landmark, "X"), 3, place);
    const json* photos = Find(landmark, "observations");
    if (photos != nullptr && !IsSurePoint(photos->size())) continue;
    points.push_back(CheckedCentre({at[0], at[1], at[2]}, place));
  }
  return points;
}

}  // namespace pathfit::optim
