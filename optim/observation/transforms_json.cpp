#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <optional>

#include "optim/observation/camera_import.h"
#include "optim/observation/image_size.h"
#include "optim/observation/json_entry.h"
#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

using nlohmann::json;
using renderer::IoError;

/// Looks a key up in the frame, then in the whole file.
class Intrinsics {
 public:
  Intrinsics(const JsonEntry& frame, const JsonEntry& file) : frame_(frame), file_(file) {}

  [[nodiscard]] std::optional<double> Number(const char* key) const {
    const std::optional<double> own = frame_.Number(key);
    return own ? own : file_.Number(key);
  }
  [[nodiscard]] double NumberOr(const char* key, double otherwise) const {
    return Number(key).value_or(otherwise);
  }
  [[nodiscard]] bool Flag(const char* key) const {
    for (const json* value : {&frame_.value, &file_.value}) {
      const auto found = value->find(key);
      if (found != value->end() && !found->is_null()) return *found == true || *found == 1;
    }
    return false;
  }
  /// Whether the frame itself has a focal length: then the file's belongs to others.
  [[nodiscard]] bool HasOwnFocal() const {
    return frame_.Number("fl_x") || frame_.Number("camera_angle_x");
  }
  [[nodiscard]] std::string Model() const {
    const std::optional<std::string> own = frame_.Text("camera_model");
    return own ? *own : file_.Text("camera_model").value_or("");
  }
  /// Image extent in pixels, 0 when it is not given.
  [[nodiscard]] int Size(const char* key) const {
    const std::optional<double> value = Number(key);
    if (!value) return 0;
    return CheckedImageSize(*value, frame_.place + "." + key);
  }
  /// A positive number, or nothing when the key is absent.
  [[nodiscard]] std::optional<double> Positive(const char* key) const {
    const std::optional<double> value = Number(key);
    if (value && *value <= 0.0) {
      throw IoError(frame_.place + "." + key + ": " + std::to_string(*value) + " must be positive");
    }
    return value;
  }

 private:
  const JsonEntry& frame_;
  const JsonEntry& file_;
};

void ReadLensTerms(const Intrinsics& source, const JsonEntry& frame, renderer::Camera& camera) {
  const std::string model = source.Model();
  const std::initializer_list<const char*> known = {
      "", "OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "ORTHOGRAPHIC"};
  if (std::ranges::find(known, model) == known.end()) {
    throw IoError(
        frame.place + ": camera_model " + model +
        " is not supported (allowed: OPENCV, PINHOLE, SIMPLE_PINHOLE, SIMPLE_RADIAL, RADIAL, "
        "ORTHOGRAPHIC); undistort the photos to PINHOLE, or calibrate again with OPENCV");
  }
  const std::string advice =
      " a fisheye or rational lens, which is not supported; undistort the photos to PINHOLE, or "
      "calibrate again with OPENCV (k1 k2 k3 p1 p2)";
  for (const char* key : {"k4", "k5", "k6", "ftheta_p0", "ftheta_p1", "ftheta_p2", "ftheta_p3"}) {
    if (const double term = source.NumberOr(key, 0.0); term != 0.0) {
      throw IoError(frame.place + "." + key + ": " + std::to_string(term) + " belongs to" + advice);
    }
  }
  if (source.Flag("is_fisheye")) {
    throw IoError(frame.place + ".is_fisheye: says that this is" + advice);
  }
  camera.distortion = {.k1 = source.NumberOr("k1", 0.0),
                       .k2 = source.NumberOr("k2", 0.0),
                       .k3 = source.NumberOr("k3", 0.0),
                       .p1 = source.NumberOr("p1", 0.0),
                       .p2 = source.NumberOr("p2", 0.0)};
  camera.vignetting = {.v1 = source.NumberOr("v1", 0.0),
                       .v2 = source.NumberOr("v2", 0.0),
                       .v3 = source.NumberOr("v3", 0.0)};
  if (model == "ORTHOGRAPHIC") camera.projection = renderer::ProjectionKind::kOrthographic;
  if (model.ends_with("PINHOLE") && !camera.distortion.IsNone()) {
    throw IoError(
        frame.place + ": camera_model " + model +
        " has no distortion, but one of k1 k2 k3 p1 p2 is not zero; write camera_model OPENCV, or "
        "remove the coefficients");
  }
}

void ReadIntrinsics(const JsonEntry& frame, const JsonEntry& file, ImportedCamera& imported) {
  const Intrinsics source(frame, file);
  renderer::Camera& camera = imported.camera;
  camera.width = source.Size("w");
  camera.height = source.Size("h");
  if ((camera.width == 0) != (camera.height == 0)) {
    throw IoError(frame.place + ": w and h must be given together");
  }
  const Intrinsics focal(frame, source.HasOwnFocal() ? frame : file);
  const std::optional<double> fx = focal.Positive("fl_x");
  const std::optional<double> angle = source.Positive("camera_angle_x");
  const auto below_pi = [&](const char* key) {
    const double value = focal.Positive(key).value_or(0.0);
    if (value >= std::numbers::pi) {
      throw IoError(frame.place + "." + key + ": " + std::to_string(value) +
                    " must be below pi (radians)");
    }
    return value;
  };
  if (fx) {
    camera.fx = *fx;
    camera.fy = focal.Positive("fl_y").value_or(*fx);
  } else if (angle) {
    imported.view_angle_x = below_pi("camera_angle_x");
    imported.view_angle_y = below_pi("camera_angle_y");
  } else {
    throw IoError(frame.place +
                  ": no focal length (give fl_x in pixels, or camera_angle_x in radians)");
  }
  const std::optional<double> cx = source.Number("cx");
  const std::optional<double> cy = source.Number("cy");
  if (cx.has_value() != cy.has_value()) {
    throw IoError(frame.place + ": cx and cy must be given together");
  }
  imported.has_principal_point = cx.has_value();
  camera.cx = cx.value_or(0.0);
  camera.cy = cy.value_or(0.0);
  ReadLensTerms(source, frame, camera);
}

renderer::Transform ReadMatrix(const JsonEntry& frame, const char* key) {
  const std::string place = frame.place + "." + key;
  const auto matrix = frame.value.find(key);
  if (matrix == frame.value.end()) throw IoError(place + " is missing");
  const bool has_rows = matrix->is_array() && (matrix->size() == 3 || matrix->size() == 4);
  double m[4][4] = {{}, {}, {}, {0.0, 0.0, 0.0, 1.0}};
  for (std::size_t r = 0; has_rows && r < matrix->size(); ++r) {
    const json& row = (*matrix)[r];
    for (std::size_t c = 0; c < 4; ++c) {
      if (!row.is_array() || row.size() != 4 || !row[c].is_number() ||
          !std::isfinite(row[c].get<double>())) {
        throw IoError(place + "[" + std::to_string(r) + "] must be four finite numbers");
      }
      m[r][c] = row[c].get<double>();
    }
  }
  if (!has_rows || m[3][0] != 0.0 || m[3][1] != 0.0 || m[3][2] != 0.0 || m[3][3] != 1.0) {
    throw IoError(place + " must be 4 rows of 4 numbers, the last row 0 0 0 1");
  }
  const renderer::Mat3 linear{
      {m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}};
  return {ExactRotation(linear, place), CheckedCentre({m[0][3], m[1][3], m[2][3]}, place)};
}

/// What nerfstudio did to the poses it wrote: position * scale after `transform`.
struct Applied {
  renderer::Transform transform;
  double scale = 1.0;

  /// The pose before.
  [[nodiscard]] renderer::Transform Undone(const renderer::Transform& pose,
                                           const std::string& place) const {
    const renderer::Transform inverse = renderer::RigidInverse(transform);
    const renderer::Vec3 centre = pose.translation * (1.0 / scale);
    return {inverse.linear * pose.linear, CheckedCentre(inverse.Point(centre), place)};
  }
};

/// Empty where nothing was applied, so that such files keep their bits.
std::optional<Applied> ReadApplied(const JsonEntry& file, const std::string& name) {
  Applied applied;
  applied.scale = file.Number("applied_scale").value_or(1.0);
  if (!(applied.scale > 0.0) || !std::isfinite(1.0 / applied.scale)) {
    throw IoError(name + ": applied_scale must be positive");
  }
  if (file.value.contains("applied_transform")) {
    applied.transform = ReadMatrix(file, "applied_transform");
  }
  if (applied.scale == 1.0 && applied.transform == renderer::Transform{}) {
    return std::nullopt;
  }
  return applied;
}

}  // namespace

ImportedCameras ReadTransformsJson(const std::filesystem::path& path) {
  const json document = ParseJsonFile(path);
  const std::string name = path.string();
  if (!document.is_object()) {
    throw IoError(name + ": the file must hold a JSON object with \"frames\"");
  }
  const JsonEntry file{document, name + ": (file)"};
  ImportedCameras result;
  result.folder = path.parent_path();
  result.image_folders = {result.folder};
  result.files = {path};
  result.metres_per_unit = file.Number("metres_per_unit").value_or(0.0);
  if (document.contains("metres_per_unit") && result.metres_per_unit <= 0.0) {
    throw IoError(name + ": metres_per_unit must be positive");
  }
  const std::optional<Applied> applied = ReadApplied(file, name);
  if (applied) {
    result.notes.emplace_back(
        "Frame: applied_transform and applied_scale of the file were undone; positions are those "
        "of the program that found the cameras, and meshes are expected there.");
    result.metres_per_unit *= applied->scale;
  }
  if (const std::optional<std::string> points = file.Text("ply_file_path")) {
    result.notes.push_back("Not read: the points in " + *points + " (ply_file_path).");
  }
  const auto frames = document.find("frames");
  if (frames == document.end() || !frames->is_array() || frames->empty()) {
    throw IoError(name + ": frames must be a list with at least one frame");
  }
  for (std::size_t i = 0; i < frames->size(); ++i) {
    const JsonEntry frame{(*frames)[i], name + ": frames[" + std::to_string(i) + "]"};
    if (!frame.value.is_object()) throw IoError(frame.place + " must be an object");
    const std::optional<std::string> image = frame.Text("file_path");
    if (!image) throw IoError(frame.place + ".file_path is missing");
    ImportedCamera imported;
    imported.image = *image;
    imported.mask = frame.Text("mask_path").value_or("");
    imported.place = frame.place;
    imported.camera.name = *image;
    ReadIntrinsics(frame, file, imported);
    const renderer::Transform pose = ReadMatrix(frame, "transform_matrix");
    imported.camera.world_from_camera = applied ? applied->Undone(pose, frame.place) : pose;
    result.cameras.push_back(std::move(imported));
  }
  return result;
}

}  // namespace pathfit::optim
