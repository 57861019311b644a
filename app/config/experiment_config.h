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
#include "app/config/yaml_document.h"
#include "optim/diagnostics/gradient_check.h"
#include "optim/observation/load_observations.h"
#include "optim/observation/visual_hull.h"
#include "optim/round/fit_spec.h"
#include "renderer/bsdf/bsdf.h"
#include "renderer/render_options.h"
#include "renderer/sensor/camera.h"

namespace pathfit::app {

/// The validated experiment, name-based and plain: what app/experiment builds from. Angles are
/// radians, paths absolute, colours linear Rec.709; maps keep the order of the file as vectors of
/// named items.
using Triple = std::array<double, 3>;

/// What of the photos' brightness may be unknown: nothing, a factor each, or white balance, too.
enum class ExposureUnknown { kNone, kGain, kGainRgb };

/// One end of a known distance.
struct ScalePoint {
  Triple position{};  ///< units of the camera file, unless it is picked in photos:
  std::vector<std::pair<std::string, std::array<double, 2>>> picks;  ///< by photo: pixels
};
/// What tells how long the unit of the camera file is.
struct ScaleConfig {
  std::array<ScalePoint, 2> two_points;
  double distance_m = 1.0;
};

struct InputConfig {
  /// As for masks that are given; without them `photos.masks.meaning` becomes kNone.
  optim::ObservationOptions photos = [] {
    optim::ObservationOptions options;
    options.masks.meaning = optim::MaskMeaning::kSilhouette;
    options.masks.erode_px = 1;
    return options;
  }();
  std::string sensor;  ///< one of the scene's: took every picture of the folder; or empty
  std::vector<std::string> sensor_photos;  ///< names or globs of those pictures; empty: all
  ExposureUnknown exposure_model = ExposureUnknown::kNone;
  optim::ExposurePrior exposure;
  std::vector<std::pair<std::string, double>> known_ev;  ///< by name or glob of photos
  std::optional<ScaleConfig> scale;                      ///< absent: as the camera file says
};

/// Side of a picture along which an angle of view is measured.
enum class FovAxis { kX, kY, kSmaller, kLarger, kDiagonal };

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
using VisualHullGeometry = optim::VisualHullOptions;
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
  std::string material;  ///< empty: those of a glTF file
  /// Materials of an OBJ file's groups by `usemtl` name, or instead of those of a glTF file by
  /// their names; the rest has `material`.
  std::vector<std::pair<std::string, std::string>> group_materials;
  // What else a glTF file may bring.
  bool lights = false;
  std::optional<int> camera_height_px;  ///< of the pictures of its cameras
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
  /// By what uses it. A texture of light may also be a base colour; others have one use, but that
  /// roughness may be metallic, too.
  enum class Role {
    kUnused,
    kLight,
    kBaseColor,
    kRoughness,
    kMetallic,
    kNormal
  } role = Role::kUnused;
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
  Triple base_color{0.5, 0.5, 0.5};      ///< of kConstant, and the initial one of kVertexConstant
  renderer::MetallicRoughnessBsdf gltf;  ///< its roughness is that of every rough model
  std::string base_color_texture, roughness_texture, metallic_texture;  ///< names, or empty
  std::string normal_texture;                                           ///< likewise
  double normal_scale = 1.0;
  renderer::MicrofacetDistribution distribution = {};  ///< of conductors and dielectrics
  std::string metal;                                   ///< named, or empty:
  Triple eta{0.0, 0.0, 0.0}, k{0.0, 0.0, 0.0};         ///< of conductors and mirrors
  double ior = 1.5;                                    ///< of dielectrics and glass
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
  Triple init{1.0, 1.0, 1.0};          ///< its texels
  /// Factor of an environment or projector; W/sr of a point or spot; irradiance of a directional;
  /// radiance of an area.
  Triple intensity{1.0, 1.0, 1.0};
  Triple axis{0.0, 1.0, 0.0};  ///< rotation of all but points and areas
  double angle = 0.0;
  Triple position{0.0, 0.0, 0.0};
  Triple target{0.0, 0.0, 0.0};
  Triple direction{0.0, -1.0, 0.0};  ///< not normalised, not zero; of a target: towards it
  Triple up{0.0, 1.0, 0.0};          ///< projector; not along the direction
  double inner_angle = 0.3, outer_angle = 0.4;  ///< spot: radians from the axis
  double fov = 0.6;                             ///< projector, along fov_axis of its picture
  FovAxis fov_axis = FovAxis::kSmaller;
  std::string texture;  ///< projector; area, or empty
  std::string mesh;     ///< area
  bool two_sided = false;
  double width_m = 1.0, height_m = 1.0;  ///< rectangle
  std::vector<std::string> photos;       ///< names or globs of photos or sensors; empty: all
};

struct SensorConfig {
  std::string name;
  std::array<int, 2> size_px{0, 0};
  renderer::ProjectionKind projection = renderer::ProjectionKind::kPerspective;
  double fov = 0.0;  ///< as it was written; the focal length holds for all
  FovAxis fov_axis = FovAxis::kSmaller;
  double height_m = 1.0;                     ///< orthographic
  std::array<double, 2> focal_px{0.0, 0.0};  ///< orthographic: pixels per metre
  std::array<double, 2> principal_point_px{0.0, 0.0};
  renderer::LensDistortion distortion;
  renderer::Vignetting vignetting;
  bool look_at = true;
  Triple origin{0.0, 0.0, 1.0}, target{0.0, 0.0, 0.0}, up{0.0, 1.0, 0.0};
  std::array<std::array<double, 4>, 4> world_from_camera{};  ///< rows, if not look_at
  std::optional<std::array<int, 4>> crop_px;                 ///< x y w h
  renderer::PixelFilter filter;
  double exposure_ev = 0.0;
};

struct OutputConfig {
  std::filesystem::path directory = "runs/{name}/{timestamp}";  ///< made absolute
  bool images_every_stage = true;
  bool report = true;
};

/// What stands for a property of a material, from coarse to fine, and its words in `as`.
enum class SurfaceForm { kConstant, kVertices, kTexture };
inline constexpr std::array kSurfaceForms = {"constant", "vertices", "texture"};

struct GradcheckConfig {
  std::vector<std::string> params;    ///< names or globs of unknown scalars or groups
  optim::GradientCheckOptions check;  ///< estimators and boundary budgets are those of `render`
  double sigma = 4.0;
};

struct ExperimentConfig {
  std::filesystem::path path;  ///< of the file, absolute
  std::string name;
  std::optional<InputConfig> input;
  std::vector<GeometryConfig> geometry;
  std::vector<MaterialConfig> materials;
  std::vector<TextureConfig> textures;
  std::vector<LightConfig> lights;
  std::vector<SensorConfig> sensors;
  renderer::RenderOptions render{
      ///< also holds the seed of everything
      {.spp = 64, .sppe = 8.0, .spp_direct = 8.0, .spp_indirect = 8.0, .spp_pixel = 4.0},
      {}};
  /// What of `render` the file gives, and is there as well; derivative images find the rest.
  renderer::DerivativeChoice derivative;
  /// Stages, loss, solver and unknowns. Only the scene tells what a name stands for:
  /// app/experiment completes the unknowns, and fills the rest.
  optim::FitSpec fit;
  int threads = 0;                ///< 0 = auto
  double max_memory_bytes = 0.0;  ///< 0 = auto, infinite = none
  OutputConfig output;
  GradcheckConfig gradcheck;

  ConfigSource source;  ///< for messages about what the scene shows to be wrong
  /// Where objects are described, by what messages about the built scene begin with: "mesh 'axe'"
  /// -> "axe.yaml:12:5".
  std::map<std::string, std::string> places;
  std::string given_text;  ///< byte copy of the file
  /// Every value with the place it came from, as far as it is known without the scene; the entries
  /// of `unknowns` are in the order of those of `fit`.
  YamlNode resolved;
};

/// Name of the mesh with one material of a file: "room-oak"; what a name may not hold becomes '_'.
std::string GroupMeshName(const std::string& geometry, const std::string& usemtl);

/// Whether the meshes come from a glTF file: then only that tells how many there are, and what they
/// are called besides "GEOMETRY-".
bool IsGltf(const GeometryConfig& geometry);

/// Focal length, in the unit of width and height, at which an angle of view (radians) spans a side
/// of the picture.
double FocalLength(double fov, FovAxis axis, double width, double height);

/// Reads, overrides, validates. Throws ConfigError with all problems. Nothing but the file itself
/// is opened.
ExperimentConfig LoadExperimentConfig(const std::filesystem::path& path,
                                      const std::vector<ConfigOverride>& overrides);

/// The same of a document that was read already; relative paths begin beside `path`, which need not
/// exist.
ExperimentConfig ReadExperimentConfig(YamlDocument document,
                                      const std::filesystem::path& path,
                                      const std::vector<ConfigOverride>& overrides);

}  // namespace pathfit::app
