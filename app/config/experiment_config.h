#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "app/config/config_error.h"

namespace pathfit::app {

/// The validated experiment, name-based and plain: what app/experiment builds from. Angles are
/// radians, paths absolute, colours linear Rec.709; maps keep the order of the file as vectors of
/// named items.
using Triple = std::array<double, 3>;

struct InputConfig {
  std::filesystem::path images;  ///< empty: from the camera file
  std::filesystem::path cameras;
  std::string cameras_format = "auto";  ///< auto | transforms | colmap
  bool refuse_distortion = false;
  bool exif_orientation = false;
  bool has_masks = false;
  std::filesystem::path masks;  ///< empty: named by the camera file, or alpha
  bool masks_alpha = false;
  bool masks_silhouette = true;  ///< false: ignore
  bool masks_invert = false;
  int masks_erode_px = 1;
  std::string masks_require = "all";  ///< all | some | none
  std::string transfer = "auto";      ///< auto | srgb | linear
  double clip_above = 0.99;
  bool exposure_gain = false;
  double exposure_sigma_ev = 0.3;
  double exposure_max_ev = 3.0;
  int validation_every = 8;  ///< 0 = none
  std::vector<std::string> validation_names;
  int max_size_px = 0;
};

struct TransformConfig {
  Triple scale{1.0, 1.0, 1.0};
  Triple axis{0.0, 1.0, 0.0};
  double angle = 0.0;
  Triple translate{0.0, 0.0, 0.0};
};

struct FileGeometry {
  std::filesystem::path path;
};
struct SphereGeometry {
  double radius = 1.0;
  int subdivisions = 4;
};
struct RectangleGeometry {};
struct CubeGeometry {};
struct DiskGeometry {
  int segments = 64;
};
struct InlineGeometry {
  std::vector<Triple> vertices;
  std::vector<std::array<int, 3>> triangles;
  std::vector<Triple> colors;              ///< empty, or one per vertex
  std::vector<Triple> normals;             ///< empty, or one per vertex; not zero
  std::vector<std::array<double, 2>> uvs;  ///< empty, or one per vertex
};
struct VisualHullGeometry {
  int resolution = 128;
};
using Geometry = std::variant<FileGeometry,
                              SphereGeometry,
                              RectangleGeometry,
                              CubeGeometry,
                              DiskGeometry,
                              InlineGeometry,
                              VisualHullGeometry>;

struct GeometryConfig {
  std::string name;
  Geometry geometry;
  std::string material;
  /// Materials of an OBJ file's groups by `usemtl` name; the rest has `material`.
  std::vector<std::pair<std::string, std::string>> group_materials;
  /// kDefault: kFile, or kFlat where the vertices are unknown.
  enum class Normals { kDefault, kFile, kFlat, kSmooth } normals = Normals::kDefault;
  bool repair = false;
  TransformConfig transform;
  std::optional<Triple> pivot;  ///< of the pose; absent: middle of the bounding box
};

struct TextureConfig {
  std::string name;
  std::filesystem::path file;          ///< or empty
  std::array<int, 2> size_px{32, 32};  ///< without file
  Triple init{0.5, 0.5, 0.5};          ///< every texel, without file
  bool repeat = true;                  ///< false: clamp
  /// By what uses it. A texture of light may also be a base colour, never roughness or metallic.
  enum class Role { kUnused, kLight, kBaseColor, kRoughness, kMetallic } role = Role::kUnused;
};

struct MaterialConfig {
  std::string name;
  enum class Model {
    kDiffuse,
    kMetallicRoughness,
    kConductor,
    kDielectric,
    kMirror,
    kGlass
  } model = Model::kDiffuse;
  enum class BaseColor {
    kConstant,
    kVertexConstant,
    kVertexOfMesh,
    kTexture
  } base_color_source = BaseColor::kConstant;
  Triple base_color{0.5, 0.5, 0.5};  ///< of kConstant, and the initial one of kVertexConstant
  double roughness = 0.5;
  double metallic = 0.0;
  std::string base_color_texture, roughness_texture, metallic_texture;  ///< names, or empty
  std::string metal;                                                    ///< named, or empty:
  Triple eta{0.0, 0.0, 0.0}, k{0.0, 0.0, 0.0};  ///< of conductors and mirrors
  double ior = 1.5;                             ///< of dielectrics and glass
  bool two_sided = true;
};

struct LightConfig {
  std::string name;
  enum class Type {
    kEnvironment,
    kConstant,
    kPoint,
    kDirectional,
    kSpot,
    kProjector,
    kArea
  } type = Type::kEnvironment;
  bool camera_frame = false;
  bool visible = true;                 ///< environment: seen behind the objects
  std::filesystem::path file;          ///< environment: image, or empty
  std::array<int, 2> size_px{32, 16};  ///< environment without file
  Triple init{1.0, 1.0, 1.0};          ///< its texels; radiance of kConstant
  /// Factor of an environment or projector; W/sr of a point or spot; irradiance of a directional;
  /// radiance of an area.
  Triple intensity{1.0, 1.0, 1.0};
  Triple axis{0.0, 1.0, 0.0};  ///< rotation of all but points and areas
  double angle = 0.0;
  Triple position{0.0, 0.0, 0.0};
  Triple direction{0.0, -1.0, 0.0};  ///< not normalised, not zero; of a target: towards it
  Triple up{0.0, 1.0, 0.0};          ///< projector; not along the direction
  double inner_angle = 0.3, outer_angle = 0.4;  ///< spot: radians from the axis
  double fov = 0.6;                             ///< projector, along fov_axis of its picture
  std::string fov_axis = "smaller";
  std::string texture;  ///< projector; area, or empty
  std::string mesh;     ///< area
  bool two_sided = false;
};

struct SensorConfig {
  std::string name;
  std::array<int, 2> size_px{0, 0};
  bool orthographic = false;
  /// fov is already turned into focal lengths; orthographic: pixels per metre.
  std::array<double, 2> focal_px{0.0, 0.0};
  std::array<double, 2> principal_point_px{0.0, 0.0};
  double k1 = 0.0, k2 = 0.0, k3 = 0.0, p1 = 0.0, p2 = 0.0;
  bool look_at = true;
  Triple origin{0.0, 0.0, 1.0}, target{0.0, 0.0, 0.0}, up{0.0, 1.0, 0.0};
  std::array<std::array<double, 4>, 4> world_from_camera{};  ///< rows, if not look_at
  std::optional<std::array<int, 4>> crop_px;                 ///< x y w h
  enum class Filter { kBox, kTent, kGaussian } filter = Filter::kBox;
  double filter_radius_px = 0.5;
  double filter_sigma_px = 0.5;  ///< of a Gaussian
  double exposure_ev = 0.0;
};

struct RenderConfig {
  int spp = 64;
  double sppe = 8.0, spp_direct = 8.0, spp_indirect = 8.0, spp_pixel = 4.0;
  int max_bounces = 1;
  int rr_depth = 5;
  bool interior = true, primary = true, direct = true, indirect = true, pixel = true;  ///< terms
  bool material_form = false;
  enum class Guiding { kNone, kGrid, kAdaptive } guiding = Guiding::kAdaptive;
  double guide_share = 0.25;
  bool antithetic = false;
};

/// Only the scene tells what a name stands for: app/experiment reads the settings.
struct UnknownConfig {
  std::string name;  ///< "axe.vertices"
  Place place;       ///< of the name
  bool hold = false;
  YamlNode settings;  ///< the map behind the name, as the schema accepts it; null if it was wrong
};

struct LossConfig {
  bool relative = false;
  double relative_floor = 0.05;
  double silhouette_weight = 1.0;
};

struct StageConfig {
  std::string name;
  std::vector<std::string>
      free;  ///< names of unknowns; `all` is already expanded (without held ones)
  double image_scale = 1.0;
  int max_rounds = 10;
  int spp = 8;
  int max_spp = 64;
  double spp_growth = 1.5;
  double sppe = 4.0, spp_direct = 0.25, spp_indirect = 0.25, spp_pixel = 4.0;
  double stop_relative_cost = 0.0;
};

struct SolverConfig {
  std::string linear_solver = "auto";  ///< auto | gram | cholesky | cgnr
  double max_memory_bytes = 0.0;       ///< 0 = no limit
  int threads = 0;                     ///< 0 = auto
};

struct OutputConfig {
  std::filesystem::path directory;  ///< absolute, may hold {name} and {timestamp}
  bool images_every_stage = true;
  bool report = true;
};

struct GradcheckConfig {
  std::vector<std::string> params;  ///< names or globs of unknown scalars or groups
  double step = 1e-3;
  int spp = 64;
  int replicates = 32;
  double sigma = 4.0;
};

struct ExperimentConfig {
  std::filesystem::path path;  ///< of the file, absolute
  std::string name;
  std::uint64_t seed = 0;
  std::optional<InputConfig> input;
  std::vector<GeometryConfig> geometry;
  std::vector<MaterialConfig> materials;
  std::vector<TextureConfig> textures;
  std::vector<LightConfig> lights;
  std::vector<SensorConfig> sensors;
  RenderConfig render;
  std::vector<UnknownConfig> unknowns;
  LossConfig loss;
  std::vector<StageConfig> stages;
  SolverConfig solver;
  OutputConfig output;
  GradcheckConfig gradcheck;

  ConfigSource source;        ///< for messages about what the scene shows to be wrong
  std::string given_text;     ///< byte copy of the file
  std::string resolved_yaml;  ///< every value with the place it came from; runs alone
};

/// Name of the mesh with one material of a file: "room-oak"; what a name may not hold becomes '_'.
std::string GroupMeshName(const std::string& geometry, const std::string& usemtl);

/// Reads, overrides, validates. Throws ConfigError with all problems. Nothing but the file itself
/// is opened.
ExperimentConfig LoadExperimentConfig(const std::filesystem::path& path,
                                      const std::vector<ConfigOverride>& overrides);

}  // namespace pathfit::app
