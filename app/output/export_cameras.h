#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/sensor/camera.h"

namespace pathfit::app {

/// nerfstudio's transforms.json: per-frame intrinsics, camera-to-world matrices in the scene's own
/// frame and unit, x right, y up, looking along -z, pixel origin at the image corner; orthographic
/// cameras are ORTHOGRAPHIC with pixels per unit for focal lengths. One path per camera.
/// `metres_per_unit` is left out if it is 0, not known.
std::string TransformsJson(const std::vector<renderer::Camera>& cameras,
                           const std::vector<std::string>& image_paths,
                           double metres_per_unit = 0.0);

/// The same cameras as a list in YAML, as optim::ReadCameraList takes it.
std::string CameraListYaml(const std::vector<renderer::Camera>& cameras,
                           const std::vector<std::string>& image_paths,
                           double metres_per_unit = 0.0);

/// A COLMAP text model without points: world-to-camera, x right, y down, z forward, pixel origin at
/// the image corner. PINHOLE without distortion, OPENCV without k3, FULL_OPENCV otherwise; equal
/// intrinsics share a camera. Throws SceneError for an orthographic one.
struct ColmapText {
  std::string cameras, images, points;
};
ColmapText ColmapModel(const std::vector<renderer::Camera>& cameras,
                       const std::vector<std::string>& image_names);
/// What the cameras have and COLMAP's models do not, in words; empty: nothing.
std::string LostInColmap(const std::vector<renderer::Camera>& cameras);

/// transforms.json, and unless a camera is orthographic cameras.txt, images.txt and points3D.txt.
/// Throws IoError when not writable.
void WriteCameras(const std::filesystem::path& folder,
                  const std::vector<renderer::Camera>& cameras,
                  const std::vector<std::string>& image_names,
                  const std::vector<std::string>& image_paths,
                  double metres_per_unit = 0.0);

}  // namespace pathfit::app
