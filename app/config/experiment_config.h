#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
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
struct InlineGeometry {
  std::vector<Triple> vertices;
  std::vector<std::array<int, 3>> triangles;
  std::vector<Triple> colors;  ///< empty, or one per vertex
};
struct VisualHullGeometry {
  int resolution = 128;
};
using Geometry = std::variant<FileGeometry,
                              SphereGeometry,
                              RectangleGeometry,
                              CubeGeometry,
                              InlineGeometry,
                              VisualHullGeometry>;

struct GeometryConfig {
  std::string name;
  Geometry geometry;
  std::string material;
  TransformConfig transform;
};

struct MaterialConfig {
  std::string name;
  bool metallic_roughness = false;  ///< false: diffuse
  enum class BaseColor {
    kConstant,
    kVertexConstant,
    kVertexOfMesh
  } base_color_source = BaseColor::kConstant;
  Triple base_color{0.5, 0.5, 0.5};  ///< of kConstant, and the initial one of kVertexConstant
  double roughness = 0.5;
  double metallic = 0.0;
  bool two_sided = true;
};

struct LightConfig {
  std::string name;
  enum class Type { kEnvironment, kConstant, kPoint, kDirectional } type = Type::kEnvironment;
  bool camera_frame = false;
  bool visible = true;                 ///< environment: seen behind the objects
  std::filesystem::path file;          ///< environment: image, or empty
  std::array<int, 2> size_px{32, 16};  ///< environment without file
  Triple init{1.0, 1.0, 1.0};          ///< its texels; radiance of kConstant
  Triple intensity{
      1.0, 1.0, 1.0};  ///< factor of an environment; W/sr of a point; irradiance of a directional
  Triple axis{0.0, 1.0, 0.0};  ///< rotation of an environment
  double angle = 0.0;
  Triple position{0.0, 0.0, 0.0};
  Triple direction{0.0, -1.0, 0.0};  ///< as written, not normalised, not zero
};

struct SensorConfig {
  std::string name;
  std::array<int, 2> size_px{0, 0};
  std::array<double, 2> focal_px{0.0, 0.0};  ///< fov is already turned into focal lengths
  std::array<double, 2> principal_point_px{0.0, 0.0};
  double k1 = 0.0, k2 = 0.0, k3 = 0.0, p1 = 0.0, p2 = 0.0;
  bool look_at = true;
  Triple origin{0.0, 0.0, 1.0}, target{0.0, 0.0, 0.0}, up{0.0, 1.0, 0.0};
  std::array<std::array<double, 4>, 4> world_from_camera{};  ///< rows, if not look_at
  std::optional<std::array<int, 4>> crop_px;                 ///< x y w h
  double exposure_ev = 0.0;
};

struct RenderConfig {
  int spp = 64;
  double sppe = 8.0;
  int max_bounces = 1;
  int rr_depth = 5;
};

struct GaussianConfig {
  std::vector<double> mean;  ///< 1 or 3 values
  double sigma = 1.0;
};

struct UnknownConfig {
  std::string name;    ///< "axe.vertices"
  std::string object;  ///< "axe"; empty for exposure
  std::string
      property;  ///< vertices colors base_color roughness metallic intensity texels exposure
  bool log_transform = false;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool hold = false;
  double large_steps_lambda = 0.0;
  double laplacian_weight = 0.0, smooth_weight = 0.0, neutral_weight = 0.0;
  std::optional<GaussianConfig> gaussian;
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
  double sppe = 4.0;
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
  std::vector<LightConfig> lights;
  std::vector<SensorConfig> sensors;
  RenderConfig render;
  std::vector<UnknownConfig> unknowns;
  LossConfig loss;
  std::vector<StageConfig> stages;
  SolverConfig solver;
  OutputConfig output;
  GradcheckConfig gradcheck;

  std::string given_text;     ///< byte copy of the file
  std::string resolved_yaml;  ///< every value with the place it came from; runs alone
};

/// Reads, overrides, validates. Throws ConfigError with all problems. Nothing but the file itself
/// is opened.
ExperimentConfig LoadExperimentConfig(const std::filesystem::path& path,
                                      const std::vector<ConfigOverride>& overrides);

}  // namespace pathfit::app
