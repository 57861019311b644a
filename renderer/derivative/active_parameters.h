#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/scene/parameter_layout.h"
#include "renderer/sensor/camera.h"

namespace pathfit::renderer {

/// First block of every parameter group by object, -1 where it is not active: what the estimators
/// look up per sample, with the constants of the chain rule from blocks to the world.
struct ActiveParameters {
  struct MeshBlocks {
    std::int32_t positions = -1, normals = -1, uvs = -1, colors = -1;
    std::int32_t translation = -1, rotation = -1, scale = -1;
    bool moves = false;         ///< positions or pose
    bool has_pose = false;      ///< translation, rotation or scale
    bool any_geometry = false;  ///< moves, or normals or UVs are parameters
    Mat3 world_from_object;     ///< scale * R
    Mat3 rotation_matrix;       ///< R
    Mat3 rotation_jacobian;     ///< LeftJacobian of the pose's rotation
    Vec3 center;                ///< pivot + translation
    double inverse_scale = 1.0;
  };
  struct MaterialBlocks {
    /// A property that is the same all over the surface: a block of one number, or of one per
    /// channel.
    struct Constant {
      std::int32_t block = -1;
      bool scalar = false;
      Rgb MaterialPartials::*partial = nullptr;
    };
    std::vector<Constant> constants;
    bool any = false;    ///< any of these or of its textures' texels, or colours of a mesh
    bool bends = false;  ///< eta of smooth glass: turns the refracted ray
  };
  struct LightBlocks {
    std::int32_t intensity = -1, texels = -1, position = -1, rotation = -1, angles = -1;
    bool camera_frame = false;
    Mat3 world_from_frame;   ///< camera rotation for camera-frame lights
    Mat3 rotation_jacobian;  ///< LeftJacobian of Emitter::rotation
    bool moves = false;      ///< position, rotation, or carried by a moving camera
  };
  struct CameraBlocks {
    std::int32_t exposure = -1, white_balance = -1, vignetting = -1, position = -1, rotation = -1,
                 focal = -1, principal_point = -1, radial = -1, tangential = -1;
    Mat3 rotation_jacobian;
    Vec3 center;
    double scale_x = 1.0, scale_y = 1.0;  ///< pixels of the rendered camera per sensor pixel
    bool moves = false;                   ///< position or rotation
    bool intrinsics = false;              ///< focal, principal point or distortion
    [[nodiscard]] bool Any() const { return moves || intrinsics; }
    [[nodiscard]] bool HasGains() const {
      return exposure >= 0 || white_balance >= 0 || vignetting >= 0;
    }
  };
  std::vector<MeshBlocks> meshes;
  std::vector<MaterialBlocks> materials;
  std::vector<std::int32_t> textures;
  std::vector<LightBlocks> lights;  ///< without blocks where the camera has them off
  CameraBlocks camera;
  bool any_geometry = false;  ///< anything that moves a point, normal, UV or direction
  bool any_mesh_moves = false;
  bool any_light_moves = false;
  bool any_light = false;  ///< intensities, texels, textures, angles
  bool any_material = false;
  bool any_bends = false;
  std::vector<bool> touches;  ///< by mesh: whether a path that meets it depends on a parameter
  bool all_paths = false;     ///< whether all paths do, by lights or the sensor

  /// By mesh: whether it moves.
  [[nodiscard]] std::vector<bool> MovingMeshes() const;

  /// `sensor` is the index of the sensor that `camera` stands for, -1 for none.
  static ActiveParameters Make(const Scene& scene,
                               const ParameterLayout& layout,
                               const CameraModel& camera,
                               int sensor);
};

/// Whether a material is smooth glass whose index is a parameter: it bends what is seen through it.
bool BendsRays(const Scene& scene, const ParameterLayout& layout, int material);

}  // namespace pathfit::renderer
