#include "app/output/export_cameras.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "app/output/fields.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app {
namespace {

using renderer::Camera;
using renderer::Mat3;
using renderer::Transform;
using renderer::Vec3;

struct Quaternion {
  double w = 1.0, x = 0.0, y = 0.0, z = 0.0;
};

/// Quaternion of a rotation, w >= 0. The largest of four candidates is divided by, so nothing
/// cancels.
Quaternion QuaternionFromRotation(const Mat3& r) {
  const double m00 = r.x.x, m11 = r.y.y, m22 = r.z.z;
  const double m21_12 = r.y.z - r.z.y, m02_20 = r.z.x - r.x.z, m10_01 = r.x.y - r.y.x;
  const double s01 = r.x.y + r.y.x, s02 = r.x.z + r.z.x, s12 = r.y.z + r.z.y;
  const std::array<double, 4> squares = {
      1 + m00 + m11 + m22, 1 + m00 - m11 - m22, 1 - m00 + m11 - m22, 1 - m00 - m11 + m22};
  std::size_t best = 0;
  for (std::size_t i = 1; i < 4; ++i) best = squares[i] > squares[best] ? i : best;
  const double s = 2.0 * std::sqrt(squares[best]);
  Quaternion q;
  if (best == 0) {
    q = {0.25 * s, m21_12 / s, m02_20 / s, m10_01 / s};
  } else if (best == 1) {
    q = {m21_12 / s, 0.25 * s, s01 / s, s02 / s};
  } else if (best == 2) {
    q = {m02_20 / s, s01 / s, 0.25 * s, s12 / s};
  } else {
    q = {m10_01 / s, s02 / s, s12 / s, 0.25 * s};
  }
  const double sign = q.w < 0.0 ? -1.0 : 1.0;
  return {sign * q.w, sign * q.x, sign * q.y, sign * q.z};
}

/// x right, y down, z forward from world.
Transform ComputerVisionPose(const Camera& camera) {
  const Transform camera_from_world = renderer::RigidInverse(renderer::CameraPose(camera));
  const Transform down_from_up{{{1.0, 0.0, 0.0}, {0.0, -1.0, 0.0}, {0.0, 0.0, -1.0}}, {}};
  return down_from_up * camera_from_world;
}

std::string OneLine(std::string text) {
  for (char& c : text) c = c == '\n' || c == '\r' ? '_' : c;
  return text;
}

std::string ColmapIntrinsics(const Camera& c) {
  const renderer::LensDistortion& d = c.distortion;
  const std::string pinhole = fmt::format("{} {} {} {}", c.fx, c.fy, c.cx, c.cy);
  const std::string size = fmt::format("{} {}", c.width, c.height);
  if (d.IsNone()) return "PINHOLE " + size + " " + pinhole;
  const std::string brown = fmt::format(" {} {} {} {}", d.k1, d.k2, d.p1, d.p2);
  if (d.k3 == 0.0) return "OPENCV " + size + " " + pinhole + brown;
  return "FULL_OPENCV " + size + " " + pinhole + brown + fmt::format(" {} 0 0 0", d.k3);
}

bool IsParallel(const Camera& camera) {
  return camera.projection == renderer::ProjectionKind::kOrthographic;
}

Json MatrixRows(const Transform& t) {
  const Mat3& r = t.linear;
  return Json::array({{r.x.x, r.y.x, r.z.x, t.translation.x},
                      {r.x.y, r.y.y, r.z.y, t.translation.y},
                      {r.x.z, r.y.z, r.z.z, t.translation.z},
                      {0.0, 0.0, 0.0, 1.0}});
}

}  // namespace

std::string TransformsJson(const std::vector<Camera>& cameras,
                           const std::vector<std::string>& image_paths,
                           double metres_per_unit) {
  PATHFIT_CHECK(cameras.size() == image_paths.size());
  Json frames = Json::array();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera& c = cameras[i];
    Json frame = {{"file_path", image_paths[i]}, {"w", c.width}, {"h", c.height}};
    frame["camera_model"] = IsParallel(c)           ? "ORTHOGRAPHIC"
                            : c.distortion.IsNone() ? "PINHOLE"
                                                    : "OPENCV";
    frame["fl_x"] = c.fx;
    frame["fl_y"] = c.fy;
    frame["cx"] = c.cx;
    frame["cy"] = c.cy;
    if (!c.distortion.IsNone()) {
      frame["k1"] = c.distortion.k1;
      frame["k2"] = c.distortion.k2;
      frame["k3"] = c.distortion.k3;
      frame["p1"] = c.distortion.p1;
      frame["p2"] = c.distortion.p2;
    }
    if (!c.vignetting.IsNone()) {
      frame["v1"] = c.vignetting.v1;
      frame["v2"] = c.vignetting.v2;
      frame["v3"] = c.vignetting.v3;
    }
    frame["transform_matrix"] = MatrixRows(renderer::CameraPose(c));
    frames.push_back(std::move(frame));
  }
  Json file = Json::object();
  if (metres_per_unit > 0.0) file["metres_per_unit"] = metres_per_unit;
  file["frames"] = std::move(frames);
  return JsonText(file, 1) + "\n";
}

std::string CameraListYaml(const std::vector<Camera>& cameras,
                           const std::vector<std::string>& image_paths,
                           double metres_per_unit) {
  PATHFIT_CHECK(cameras.size() == image_paths.size());
  std::string text = "# x right, y up, looking along -z; pixels from the corner of the image.\n";
  if (metres_per_unit > 0.0) text += fmt::format("metres_per_unit: {}\n", metres_per_unit);
  text += "cameras:\n";
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera& c = cameras[i];
    text += "- image: " + JsonText(image_paths[i]) + "\n";
    if (IsParallel(c)) text += "  type: orthographic\n";
    text +=
        fmt::format("  size_px: [{}, {}]\n  focal_px: [{}, {}]\n  principal_point_px: [{}, {}]\n",
                    c.width,
                    c.height,
                    c.fx,
                    c.fy,
                    c.cx,
                    c.cy);
    if (const renderer::LensDistortion& d = c.distortion; !d.IsNone()) {
      text += fmt::format("  distortion: {{k1: {}, k2: {}, k3: {}, p1: {}, p2: {}}}\n",
                          d.k1,
                          d.k2,
                          d.k3,
                          d.p1,
                          d.p2);
    }
    if (const renderer::Vignetting& v = c.vignetting; !v.IsNone()) {
      text += fmt::format("  vignetting: {{v1: {}, v2: {}, v3: {}}}\n", v.v1, v.v2, v.v3);
    }
    text += "  world_from_camera:\n";
    for (const Json& row : MatrixRows(renderer::CameraPose(c))) {
      text += "  - " + JsonText(row, -1) + "\n";
    }
  }
  return text;
}

std::string LostInColmap(const std::vector<Camera>& cameras) {
  const auto count =
      std::ranges::count_if(cameras, [](const Camera& c) { return !c.vignetting.IsNone(); });
  return count == 0 ? ""
                    : fmt::format(
                          "COLMAP models have no vignetting; that of {} cameras is not "
                          "written (transforms.json and cameras.yaml hold it)",
                          count);
}

ColmapText ColmapModel(const std::vector<Camera>& cameras,
                       const std::vector<std::string>& image_names) {
  PATHFIT_CHECK(cameras.size() == image_names.size());
  if (std::ranges::any_of(cameras, IsParallel)) {
    throw renderer::SceneError("COLMAP has no orthographic cameras; export transforms instead");
  }
  ColmapText text;
  text.cameras = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  text.images =
      "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of POINTS2D[] (empty)\n";
  text.points = "# POINT3D_ID X Y Z R G B ERROR TRACK[] (no points: the mesh is beside)\n";
  std::map<std::string, int> camera_ids;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::string intrinsics = ColmapIntrinsics(cameras[i]);
    const auto [camera, added] =
        camera_ids.try_emplace(intrinsics, static_cast<int>(camera_ids.size()) + 1);
    if (added) text.cameras += fmt::format("{} {}\n", camera->second, intrinsics);
    const Transform pose = ComputerVisionPose(cameras[i]);
    const Quaternion q = QuaternionFromRotation(pose.linear);
    text.images += fmt::format("{} {} {} {} {} {} {} {} {} {}\n\n",
                               i + 1,
                               q.w,
                               q.x,
                               q.y,
                               q.z,
                               pose.translation.x,
                               pose.translation.y,
                               pose.translation.z,
                               camera->second,
                               OneLine(image_names[i]));
  }
  return text;
}

void WriteCameras(const std::filesystem::path& folder,
                  const std::vector<Camera>& cameras,
                  const std::vector<std::string>& image_names,
                  const std::vector<std::string>& image_paths,
                  double metres_per_unit) {
  renderer::WriteFileAtomically(folder / "transforms.json",
                                TransformsJson(cameras, image_paths, metres_per_unit));
  if (std::ranges::any_of(cameras, IsParallel)) return;  // COLMAP has none
  const ColmapText text = ColmapModel(cameras, image_names);
  renderer::WriteFileAtomically(folder / "cameras.txt", text.cameras);
  renderer::WriteFileAtomically(folder / "images.txt", text.images);
  renderer::WriteFileAtomically(folder / "points3D.txt", text.points);
}

}  // namespace pathfit::app
