#include "app/output/evaluation.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "app/experiment/orbit.h"
#include "app/experiment/parameter_names.h"
#include "app/output/evaluation_fields.h"
#include "app/output/report_images.h"
#include "app/output/sha256.h"
#include "optim/problem/view_quality.h"
#include "optim/round/evaluation.h"
#include "optim/round/exposure_gauge.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/surface_distance.h"
#include "renderer/image/similarity.h"
#include "renderer/io/image_file.h"
#include "renderer/math/box.h"
#include "renderer/math/median.h"
#include "renderer/path/surface_point.h"
#include "renderer/renderer.h"

namespace pathfit::app {
namespace {

using renderer::Camera;
using renderer::Image;
using renderer::Mesh;
using renderer::MeshPoint;
using renderer::ParameterKind;
using renderer::Rgb;
using renderer::Scene;
using renderer::TriangleId;
using renderer::Vec3;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr int kJpegQuality = 88;
constexpr std::size_t kMostPictures = 12;
constexpr std::size_t kMostRelit = 8;
constexpr int kSkyRows = 64;  // of directions at which environments are compared

/// Of nothing it is unknown: a metallic of 0 everywhere has errors, but no share.
double Percent(double part, double whole) { return whole > 0.0 ? 100.0 * part / whole : kUnknown; }

double AngleDeg(const Vec3& a, const Vec3& b) {
  return kDegrees * std::atan2(Norm(Cross(a, b)), Dot(a, b));
}

std::string Jpeg(const Image& linear) {
  const std::vector<unsigned char> bytes =
      renderer::EncodeJpeg(EncodedImage(ReducedImage(linear, kThumbnailPx)), kJpegQuality);
  return {bytes.begin(), bytes.end()};
}
std::string JpegOfDifference(const Image& a, const Image& b, const Image& weight) {
  const Image mask = weight.Empty() ? weight : ReducedImage(weight, kThumbnailPx);
  const std::vector<unsigned char> bytes = renderer::EncodeJpeg(
      DifferenceImage(ReducedImage(a, kThumbnailPx), ReducedImage(b, kThumbnailPx), mask),
      kJpegQuality);
  return {bytes.begin(), bytes.end()};
}

/// What photos and scenes call the same view: the extension may differ.
std::string StemOf(const std::string& name) {
  return std::filesystem::path(name).replace_extension().string();
}
const Camera* CameraOf(const Scene& scene, const std::string& view) {
  for (const Camera& camera : scene.sensors) {
    if (camera.name == view || StemOf(camera.name) == StemOf(view)) return &camera;
  }
  return nullptr;
}

// Photos

void EvaluateViews(const Experiment& run, const EvaluationOptions& options, Evaluation& out) {
  const auto& stages = run.fit.stages;
  out.image_scale = stages.empty() ? 1.0 : stages.back().image_scale;
  const optim::FreeGains gains = optim::FreeGainsOf(run.fit.unknowns);
  const optim::ExposureModel exposure = optim::MakeExposureModel(run.scene, run.fit.exposure);
  optim::Division alone;
  optim::FitEvaluation evaluation(
      run.observations, run.fit, exposure, gains, options.cancel, alone);
  const optim::FitViews& views = evaluation.ViewsAt(out.image_scale);
  const auto source = evaluation.MakeSource(run.scene, {}, views);
  const optim::SampleHalves samples = evaluation.Samples(0, std::max(2, options.spp / 2));
  for (std::size_t v = 0; v < views.levels.size(); ++v) {
    const optim::View& view = run.observations.views[v];
    const optim::ViewLevel level = views.levels[v].Unpack();
    const optim::ReportedView reported =
        optim::RenderForReport(*source,
                               views,
                               static_cast<int>(v),
                               level,
                               run.fit.loss,
                               samples,
                               view.validation ? gains : optim::FreeGains::kNone);
    const Image picture = renderer::ColorImage(reported.film);
    EvaluatedView row{.view = view.name, .validation = view.validation};
    row.psnr_srgb = reported.quality.psnr_srgb;
    row.psnr_linear = reported.quality.psnr_linear;
    row.iou = reported.quality.iou;
    row.ssim = renderer::StructuralSimilarity(
        EncodedImage(picture), EncodedImage(level.photo), level.color_weight);
    row.psnr_scaled = kUnknown;
    out.views.push_back(row);
    if (view.validation && out.pictures.size() < kMostPictures) {
      out.pictures.push_back(
          {view.name,
           "held out",
           {{"Photo", Jpeg(level.photo)},
            {"Result", Jpeg(picture)},
            {"Difference", JpegOfDifference(picture, level.photo, level.color_weight)}}});
    }
  }
}

// Another light

void LightBy(const EvaluationOptions& options, const Vec3& up, Scene& scene) {
  renderer::EnvironmentEmitter sky;
  sky.intensity = {0.4, 0.4, 0.4};
  scene.emitters.clear();
  if (options.environment) {
    sky = *options.environment;
  } else {
    const Vec3 across = std::abs(up.x) < 0.9 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 0.0, 1.0};
    const Vec3 side = Normalized(Cross(up, across));
    scene.emitters.push_back(
        {"sun",
         renderer::LightFrame::kWorld,
         {},
         renderer::DirectionalEmitter{Normalized(-up - side * 0.6 - Cross(side, up) * 0.8),
                                      {2.0, 1.9, 1.7}}});
  }
  scene.emitters.push_back({"sky", renderer::LightFrame::kWorld, {}, sky});
  scene.environment_visible = false;
  for (Camera& camera : scene.sensors) {
    camera.ForgetResponse();
    camera.lights_off.clear();
  }
}

/// A film as the photo of a view: of what either of two sees.
optim::ViewLevel AsPhoto(const renderer::Film& film, const renderer::Film& other) {
  optim::ViewLevel level;
  level.photo = renderer::ColorImage(film);
  level.mask = renderer::CoverageImage(film);
  level.color_weight = level.mask;
  for (std::size_t p = 0; p < film.pixels.size(); ++p) {
    const bool seen = film.pixels[p].a > 0.5 || other.pixels[p].a > 0.5;
    level.color_weight.data[p] = seen ? 1.0F : 0.0F;
  }
  return level;
}

/// One factor per channel with which the pictures of the run come nearest to the truth's.
struct Gauge {
  Rgb both, own;
  void Add(const Rgb& run, const Rgb& truth, double weight) {
    both += run * truth * weight;
    own += run * run * weight;
  }
  [[nodiscard]] Rgb Factor() const {
    Rgb factor{1.0, 1.0, 1.0};
    for (int c = 0; c < 3; ++c) {
      if (own[c] > 0.0) factor[c] = both[c] / own[c];
    }
    return factor;
  }
};

void EvaluateRelit(const Experiment& run,
                   const Scene& truth,
                   const EvaluationOptions& options,
                   Evaluation& out) {
  out.relit_by = options.environment ? options.environment_name : "a grey sky and a sun";
  const Vec3 up = UpDirection(run.scene);
  Scene found = run.scene, right = truth;
  LightBy(options, up, found);
  LightBy(options, up, right);
  const renderer::Renderer of_run(found), of_truth(right);
  renderer::RenderOptions render{{.spp = options.spp}, run.fit.estimators};
  std::vector<std::size_t> chosen;
  for (const bool validation : {true, false}) {
    for (std::size_t v = 0; v < run.observations.views.size(); ++v) {
      if (run.observations.views[v].validation == validation && chosen.size() < kMostRelit) {
        chosen.push_back(v);
      }
    }
  }
  std::vector<renderer::Film> films, truths;
  Gauge gauge;
  for (const std::size_t v : chosen) {
    const Camera& own = found.sensors[v];
    const auto scaled = [&](int size) {
      return std::max(1, static_cast<int>(std::lround(out.image_scale * size)));
    };
    const int width = scaled(own.width), height = scaled(own.height);
    const Camera* true_camera = CameraOf(right, run.observations.views[v].name);
    render.view = v;
    const auto film_of = [&](const renderer::Renderer& renderer, const Camera& camera) {
      return renderer.RenderPrimal(
          renderer::ScaledCamera(camera, width, height), render, {.cancel = options.cancel});
    };
    films.push_back(film_of(of_run, own));
    truths.push_back(film_of(of_truth, true_camera == nullptr ? own : *true_camera));
    for (std::size_t p = 0; p < films.back().pixels.size(); ++p) {
      const renderer::Rgba &a = films.back().pixels[p], &b = truths.back().pixels[p];
      if (a.a > 0.5 && b.a > 0.5) gauge.Add(a.Color(), b.Color(), 1.0);
    }
  }
  const Rgb factor = gauge.Factor();
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const optim::View& view = run.observations.views[chosen[i]];
    const optim::ViewLevel level = AsPhoto(truths[i], films[i]);
    const optim::ViewQuality quality = optim::MeasureView(level, films[i], true);
    const Image picture = renderer::ColorImage(films[i]);
    renderer::Film by_gauge = films[i];
    for (renderer::Rgba& p : by_gauge.pixels) p = renderer::Rgba(p.Color() * factor, p.a);
    EvaluatedView row{.view = view.name, .validation = view.validation};
    row.psnr_srgb = quality.psnr_srgb;
    row.psnr_linear = quality.psnr_linear;
    row.iou = quality.iou;
    row.psnr_scaled = optim::MeasureView(level, by_gauge, true).psnr_srgb;
    row.ssim = renderer::StructuralSimilarity(
        EncodedImage(picture), EncodedImage(level.photo), level.color_weight);
    out.relit.push_back(row);
    out.pictures.push_back(
        {view.name,
         "relit",
         {{"Truth", Jpeg(level.photo)},
          {"Result", Jpeg(picture)},
          {"Difference", JpegOfDifference(picture, level.photo, level.color_weight)}}});
  }
}

// Surfaces

/// Meshes of a scene that are no lamps, as one.
struct JoinedSurface {
  Mesh mesh;
  std::vector<TriangleId> ids;  ///< of its triangles in the scene
};

/// One that shines by a picture is an object with lights on it.
bool IsLamp(const Scene& scene, std::size_t mesh) {
  const renderer::AreaEmitter* light = AreaLightOf(scene, mesh);
  return light != nullptr && light->texture < 0;
}

/// All of them, or the one of this name.
JoinedSurface Join(const renderer::World& world, const std::string& name) {
  JoinedSurface joined;
  std::vector<Vec3> positions;
  std::vector<renderer::Triangle> triangles;
  const Scene& scene = world.scene();
  for (int m = 0; m < world.NumMeshes(); ++m) {
    const auto i = static_cast<std::size_t>(m);
    const bool wanted = name.empty() ? !IsLamp(scene, i) : scene.meshes[i].name == name;
    if (!wanted) continue;
    const Mesh& mesh = world.mesh(m);
    const auto first = static_cast<std::int32_t>(positions.size());
    positions.insert(positions.end(), mesh.positions.begin(), mesh.positions.end());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const renderer::Triangle& own = mesh.triangles[t];
      triangles.push_back({own[0] + first, own[1] + first, own[2] + first});
      joined.ids.push_back({m, static_cast<std::int32_t>(t)});
    }
  }
  joined.mesh.positions = positions;
  joined.mesh.triangles = triangles;
  return joined;
}

/// Those points that a fitted photo sees.
std::vector<MeshPoint> SeenPoints(const renderer::World& world,
                                  const JoinedSurface& surface,
                                  const std::vector<MeshPoint>& points,
                                  const std::vector<Camera>& cameras) {
  constexpr double kGrazing = 0.1;
  std::vector<renderer::CameraModel> models;
  for (const Camera& camera : cameras) models.emplace_back(camera);
  std::vector<char> seen(points.size(), 0);
  renderer::ParallelFor(static_cast<std::int64_t>(points.size()), [&](std::int64_t i) {
    const MeshPoint& point = points[static_cast<std::size_t>(i)];
    const Vec3 n = renderer::TriangleNormal(surface.mesh, point.triangle);
    for (const renderer::CameraModel& model : models) {
      const auto projection = model.Project(point.x);
      const Camera& camera = model.camera();
      if (!projection || projection->u < 0.0 || projection->v < 0.0 ||
          projection->u > camera.width || projection->v > camera.height) {
        continue;
      }
      double distance = 0.0;
      const renderer::Ray to_camera = model.RayTo(point.x, distance);
      const double cosine = Dot(n, to_camera.direction);
      if (std::abs(cosine) < kGrazing) continue;
      const Vec3 start = point.x + n * std::copysign(4.0 * world.caster().Offset(point.x), cosine);
      if (world.caster().Occluded({start, to_camera.direction}, distance)) continue;
      seen[static_cast<std::size_t>(i)] = 1;
      return;
    }
  });
  std::vector<MeshPoint> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (seen[i] != 0) kept.push_back(points[i]);
  }
  return kept;
}

EvaluatedSurface CompareSurfaces(const std::string& name,
                                 const Mesh& found,
                                 const std::vector<MeshPoint>& of_found,
                                 const Mesh& right,
                                 const std::vector<MeshPoint>& of_right) {
  const renderer::SurfaceGap to = renderer::GapBetween(found, of_found, right);
  const renderer::SurfaceGap from = renderer::GapBetween(right, of_right, found);
  EvaluatedSurface row{.surface = name};
  row.diagonal = Norm(renderer::BoxAround(right.positions).Size());
  row.mean_percent = Percent(0.5 * (to.mean + from.mean), row.diagonal);
  row.to_truth_mean = to.mean;
  row.to_truth_rms = to.rms;
  row.to_truth_most = to.most;
  row.to_truth_angle_deg = kDegrees * to.mean_angle;
  row.from_truth_mean = from.mean;
  row.from_truth_rms = from.rms;
  row.from_truth_most = from.most;
  row.from_truth_angle_deg = kDegrees * from.mean_angle;
  return row;
}

// Materials

renderer::BsdfInputs InputsOf(const renderer::World& world,
                              const JoinedSurface& surface,
                              const MeshPoint& point) {
  const TriangleId id = surface.ids[static_cast<std::size_t>(point.triangle)];
  return renderer::InputsAt(
      world.scene(), world.mesh(id.mesh), world.MaterialOf(id.mesh), id, point.b1, point.b2);
}

void CompareMaterials(const std::string& name,
                      const renderer::World& found,
                      const JoinedSurface& found_surface,
                      const renderer::World& right,
                      const JoinedSurface& right_surface,
                      const std::vector<MeshPoint>& points,
                      Evaluation& out) {
  const renderer::NearestSurface nearest(found_surface.mesh);
  struct Sums {
    int count = 0;
    Gauge gauge;
    Rgb squares, truth, truth_squares;
    std::vector<double> errors;  // of each point, rms of its channels
    void Add(const Rgb& a, const Rgb& b) {
      ++count;
      gauge.Add(a, b, 1.0);
      const Rgb square = (a - b) * (a - b);
      squares += square;
      errors.push_back(std::sqrt((square.r + square.g + square.b) / 3.0));
      truth += b;
      truth_squares += b * b;
    }
  };
  std::map<std::string, Sums> sums;
  for (const MeshPoint& point : points) {
    const MeshPoint near = nearest.Nearest(point.x);
    const renderer::BsdfInputs a = InputsOf(found, found_surface, near);
    const renderer::BsdfInputs b = InputsOf(right, right_surface, point);
    sums["base_color"].Add(a.base_color, b.base_color);
    const auto material = [](const renderer::World& world, const JoinedSurface& surface, int t) {
      return world.MaterialOf(surface.ids[static_cast<std::size_t>(t)].mesh);
    };
    const renderer::Material of_a = material(found, found_surface, near.triangle);
    const renderer::Material of_b = material(right, right_surface, point.triangle);
    if (renderer::HasRoughness(of_a.bsdf) && renderer::HasRoughness(of_b.bsdf)) {
      sums["roughness"].Add(Rgb::Constant(a.roughness), Rgb::Constant(b.roughness));
    }
    if (std::holds_alternative<renderer::MetallicRoughnessBsdf>(of_a.bsdf) &&
        std::holds_alternative<renderer::MetallicRoughnessBsdf>(of_b.bsdf)) {
      sums["metallic"].Add(Rgb::Constant(a.metallic), Rgb::Constant(b.metallic));
    }
  }
  for (auto& [property, sum] : sums) {
    const double count = 3.0 * sum.count;
    const auto total = [](const Rgb& c) { return c.r + c.g + c.b; };
    EvaluatedAppearance row{.property = property, .surface = name, .points = sum.count};
    row.mean_truth = total(sum.truth) / count;
    row.rms = std::sqrt(total(sum.squares) / count);
    row.median = renderer::Median(sum.errors);
    row.rms_percent = Percent(row.rms, std::sqrt(total(sum.truth_squares) / count));
    // |f a - b|^2 with the best f.
    double left = 0.0;
    const Rgb factor = sum.gauge.Factor();
    for (int c = 0; c < 3; ++c) {
      left += std::max(0.0, sum.truth_squares[c] - factor[c] * sum.gauge.both[c]);
    }
    row.scaled_percent = property == "base_color"
                             ? Percent(std::sqrt(left), std::sqrt(total(sum.truth_squares)))
                             : kUnknown;
    out.appearance.push_back(row);
  }
}

void EvaluateSurfaces(const Experiment& run,
                      const Scene& truth,
                      const EvaluationOptions& options,
                      Evaluation& out) {
  const renderer::World found(run.scene), right(truth);
  const JoinedSurface all_found = Join(found, ""), all_right = Join(right, "");
  if (all_found.mesh.triangles.empty() || all_right.mesh.triangles.empty()) {
    out.notes.emplace_back(
        "one of the scenes has no surface to compare, but for lamps that shine alike everywhere");
    return;
  }
  const auto of_found = renderer::UniformPoints(all_found.mesh, options.points);
  const auto of_right = renderer::UniformPoints(all_right.mesh, options.points);
  out.surfaces.push_back(
      CompareSurfaces("all", all_found.mesh, of_found, all_right.mesh, of_right));
  std::vector<Camera> own, true_cameras;
  for (std::size_t v = 0; v < run.observations.views.size(); ++v) {
    if (run.observations.views[v].validation) continue;
    own.push_back(run.scene.sensors[v]);
    const Camera* camera = CameraOf(truth, run.observations.views[v].name);
    true_cameras.push_back(camera == nullptr ? own.back() : *camera);
  }
  const auto seen_found = SeenPoints(found, all_found, of_found, own);
  const auto seen_right = SeenPoints(right, all_right, of_right, true_cameras);
  const bool any_seen = !seen_found.empty() && !seen_right.empty();
  if (any_seen) {
    out.surfaces.push_back(
        CompareSurfaces("seen", all_found.mesh, seen_found, all_right.mesh, seen_right));
  }
  if (run.scene.meshes.size() > 1 || truth.meshes.size() > 1) {
    for (const renderer::SceneMesh& mesh : truth.meshes) {
      const JoinedSurface a = Join(found, mesh.name), b = Join(right, mesh.name);
      if (a.mesh.triangles.empty()) continue;
      out.surfaces.push_back(CompareSurfaces(mesh.name,
                                             a.mesh,
                                             renderer::UniformPoints(a.mesh, options.points),
                                             b.mesh,
                                             renderer::UniformPoints(b.mesh, options.points)));
    }
  }
  CompareMaterials("all", found, all_found, right, all_right, of_right, out);
  if (any_seen) CompareMaterials("seen", found, all_found, right, all_right, seen_right, out);
}

// Unknowns

/// Whether the meshes are the same before their poses: only then do poses compare.
bool SameRestShape(const Scene& run, int object, const Scene& truth, const ParameterName& right) {
  const renderer::SceneMesh& a = run.meshes[static_cast<std::size_t>(object)];
  const renderer::SceneMesh& b = truth.meshes[static_cast<std::size_t>(right.parameter.object)];
  return a.pose.pivot == b.pose.pivot && a.mesh.positions.Items() == b.mesh.positions.Items();
}

void EvaluateParameters(const Experiment& run, const Scene& truth, Evaluation& out) {
  for (const optim::UnknownSpec& unknown : run.fit.unknowns) {
    const renderer::ParameterTraits& traits =
        renderer::TraitsOf(unknown.kind, run.scene, std::max(0, unknown.object));
    if (traits.list == renderer::ObjectList::kSensors) continue;  // EvaluateCameras
    const ParameterName right = FindParameter(truth, unknown.name);
    if (!right.problem.empty() || right.parameter.kind != unknown.kind) {
      out.notes.push_back(unknown.name + ": the truth has no such number");
      continue;
    }
    renderer::ParameterLayout of_run(run.scene), of_truth(truth);
    of_run.Add(unknown.kind, unknown.object);
    of_truth.Add(right.parameter.kind, right.parameter.object);
    const std::vector<double> a = of_run.Gather(run.scene), b = of_truth.Gather(truth);
    if (traits.IsPose() && !SameRestShape(run.scene, unknown.object, truth, right)) {
      out.notes.push_back(unknown.name +
                          ": moves another mesh than the truth's: compared as surfaces only");
      continue;
    }
    if (a.size() != b.size()) {
      out.notes.push_back(fmt::format(
          "{}: {} numbers, of which the truth has {}: compared as surfaces and colours only",
          unknown.name,
          a.size(),
          b.size()));
      continue;
    }
    EvaluatedParameter row{
        .name = unknown.name, .unit = traits.unit, .scalars = static_cast<int>(a.size())};
    const auto count = static_cast<double>(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      row.mean_error += (a[i] - b[i]) / count;
      row.rms_error += (a[i] - b[i]) * (a[i] - b[i]) / count;
      row.largest_error = std::max(row.largest_error, std::abs(a[i] - b[i]));
      row.rms_truth += b[i] * b[i] / count;
    }
    row.rms_error = std::sqrt(row.rms_error);
    row.rms_truth = std::sqrt(row.rms_truth);
    out.parameters.push_back(row);
  }
}

// Lights

/// A light's place and direction in its frame; NaN where it has none.
struct LightPose {
  Vec3 position{kUnknown, kUnknown, kUnknown}, direction{kUnknown, kUnknown, kUnknown};
};
LightPose PoseOf(const renderer::Emitter& emitter) {
  LightPose pose;
  const renderer::Mat3 turn = renderer::RotationFromVector(emitter.rotation);
  if (const auto* point = std::get_if<renderer::PointEmitter>(&emitter.light)) {
    pose.position = point->position;
  } else if (const auto* sun = std::get_if<renderer::DirectionalEmitter>(&emitter.light)) {
    pose.direction = turn * sun->direction;
  } else if (const auto* spot = std::get_if<renderer::SpotEmitter>(&emitter.light)) {
    pose = {spot->position, turn * -spot->frame_from_light.z};
  } else if (const auto* slide = std::get_if<renderer::ProjectorEmitter>(&emitter.light)) {
    pose = {slide->position, turn * -slide->frame_from_light.z};
  }
  return pose;
}

Rgb SkyTowards(const renderer::Emitter& emitter, const Vec3& direction) {
  const auto& sky = std::get<renderer::EnvironmentEmitter>(emitter.light);
  const renderer::Mat3 frame_from_light =
      renderer::RotationFromVector(emitter.rotation) * sky.frame_from_light;
  return renderer::EnvironmentRadianceAt(
      sky, renderer::EnvironmentUv(renderer::Transposed(frame_from_light) * direction));
}

/// Errors of radiances against those of the truth, by their weights.
struct SkyError {
  Gauge gauge;
  Rgb squares, truth;

  void Add(const Rgb& a, const Rgb& b, double weight) {
    gauge.Add(a, b, weight);
    squares += (a - b) * (a - b) * weight;
    truth += b * b * weight;
  }
  [[nodiscard]] double Whole() const { return truth.r + truth.g + truth.b; }
  [[nodiscard]] double OfAll() const {
    return Percent(std::sqrt(squares.r + squares.g + squares.b), std::sqrt(Whole()));
  }
  /// After the best factor of each channel.
  [[nodiscard]] double Scaled() const {
    const Rgb factor = gauge.Factor();
    double left = 0.0;
    for (int c = 0; c < 3; ++c) left += std::max(0.0, truth[c] - factor[c] * gauge.both[c]);
    return Percent(std::sqrt(left), std::sqrt(Whole()));
  }
};

/// Calls body(direction, weight of its solid angle) at the middles of so many columns and rows of a
/// rectangle of the map.
template <class Body>
void ForDirections(const renderer::Emitter& emitter,
                   const renderer::Vec2& corner,
                   const renderer::Vec2& size,
                   const std::array<int, 2>& count,
                   const Body& body) {
  const renderer::Mat3 frame_from_light =
      renderer::RotationFromVector(emitter.rotation) *
      std::get<renderer::EnvironmentEmitter>(emitter.light).frame_from_light;
  for (int y = 0; y < count[1]; ++y) {
    for (int x = 0; x < count[0]; ++x) {
      const double u = corner.x + size.x * (x + 0.5) / count[0];
      const double v = corner.y + size.y * (y + 0.5) / count[1];
      body(frame_from_light * renderer::EnvironmentDirection({u, v}),
           std::sin(std::numbers::pi * v));
    }
  }
}

void CompareSkies(const renderer::Emitter& found,
                  const renderer::Emitter& right,
                  EvaluatedLight& row) {
  SkyError raw, of_texels;
  for (int y = 0; y < kSkyRows; ++y) {
    for (int x = 0; x < 2 * kSkyRows; ++x) {
      const double v = (y + 0.5) / kSkyRows;
      const Vec3 d = renderer::EnvironmentDirection({(x + 0.5) / (2 * kSkyRows), v});
      raw.Add(SkyTowards(found, d), SkyTowards(right, d), std::sin(std::numbers::pi * v));
    }
  }
  // A map has no more to say than its texels: the truth's own texels within each are averaged.
  const auto& sky = std::get<renderer::EnvironmentEmitter>(found.light);
  const auto& truth = std::get<renderer::EnvironmentEmitter>(right.light);
  const auto parts = [](int of_truth, int of_found) {
    return std::max(1, (of_truth + of_found - 1) / of_found);
  };
  const std::array<int, 2> count = {parts(truth.width, sky.width), parts(truth.height, sky.height)};
  const renderer::Vec2 size{1.0 / sky.width, 1.0 / sky.height};
  for (int y = 0; y < sky.height; ++y) {
    for (int x = 0; x < sky.width; ++x) {
      const renderer::Vec2 corner{size.x * x, size.y * y};
      Rgb texel, mean;
      ForDirections(found, corner, size, {1, 1}, [&](const Vec3& d, double) {
        texel = SkyTowards(found, d);
      });
      double total = 0.0;
      ForDirections(found, corner, size, count, [&](const Vec3& d, double weight) {
        mean += SkyTowards(right, d) * weight;
        total += weight;
      });
      of_texels.Add(texel, mean / total, total);
    }
  }
  const Rgb factor = raw.gauge.Factor();
  row.radiance_percent = raw.OfAll();
  row.scaled_percent = raw.Scaled();
  row.texels_percent = of_texels.OfAll();
  row.texels_scaled_percent = of_texels.Scaled();
  row.ratio_r = 1.0 / factor.r;
  row.ratio_g = 1.0 / factor.g;
  row.ratio_b = 1.0 / factor.b;
}

/// That of the same name, or the only one of the same kind.
const renderer::Emitter* TrueLight(const renderer::Emitter& light, const Scene& truth) {
  const renderer::Emitter* only = nullptr;
  int count = 0;
  for (const renderer::Emitter& other : truth.emitters) {
    if (other.light.index() != light.light.index()) continue;
    if (other.name == light.name) return &other;
    only = &other;
    ++count;
  }
  return count == 1 ? only : nullptr;
}

void EvaluateLights(const Experiment& run, const Scene& truth, Evaluation& out) {
  for (const renderer::Emitter& light : run.scene.emitters) {
    const renderer::Emitter* right = TrueLight(light, truth);
    if (right == nullptr || right->frame != light.frame) {
      out.notes.push_back("light '" + light.name + "': the truth has none to compare it with" +
                          (right == nullptr ? "" : " in the same frame"));
      continue;
    }
    EvaluatedLight row{.light = light.name, .type = renderer::LightWord(light)};
    const LightPose a = PoseOf(light), b = PoseOf(*right);
    row.direction_deg = AngleDeg(a.direction, b.direction);
    row.position_m = Norm(a.position - b.position);
    row.radiance_percent = row.scaled_percent = kUnknown;
    row.texels_percent = row.texels_scaled_percent = kUnknown;
    if (std::holds_alternative<renderer::EnvironmentEmitter>(light.light)) {
      CompareSkies(light, *right, row);
    } else {
      const Rgb &found = LightIntensity(light), &wanted = LightIntensity(*right);
      row.ratio_r = found.r / wanted.r;
      row.ratio_g = found.g / wanted.g;
      row.ratio_b = found.b / wanted.b;
    }
    out.lights.push_back(row);
  }
}

void EvaluateCameras(const Experiment& run, const Scene& truth, Evaluation& out) {
  for (std::size_t v = 0; v < run.observations.views.size(); ++v) {
    const optim::View& view = run.observations.views[v];
    const Camera* right = CameraOf(truth, view.name);
    if (right == nullptr) continue;
    const Camera& found = run.scene.sensors[v];
    const renderer::Transform a = renderer::CameraPose(found), b = renderer::CameraPose(*right);
    EvaluatedCamera row{.view = view.name, .validation = view.validation};
    row.position_m = Norm(a.translation - b.translation);
    const renderer::Mat3 turn = renderer::Transposed(b.linear) * a.linear;
    const double cosine = 0.5 * (turn.x.x + turn.y.y + turn.z.z - 1.0);
    const Vec3 sine{turn.y.z - turn.z.y, turn.z.x - turn.x.z, turn.x.y - turn.y.x};
    row.rotation_deg = kDegrees * std::atan2(0.5 * Norm(sine), cosine);
    const double scale = static_cast<double>(found.width) / right->width;
    row.focal_percent = 100.0 * (found.fx / (scale * right->fx) - 1.0);
    row.exposure_ev = std::log2(found.gain / right->gain);
    out.cameras.push_back(row);
  }
}

/// Lengths of a scene whose unit is that of the camera file.
void InMetres(double metres_per_unit, Evaluation& evaluation) {
  if (metres_per_unit == 1.0) return;
  for (EvaluatedSurface& row : evaluation.surfaces) {
    for (double EvaluatedSurface::*length : {&EvaluatedSurface::diagonal,
                                             &EvaluatedSurface::to_truth_mean,
                                             &EvaluatedSurface::to_truth_rms,
                                             &EvaluatedSurface::to_truth_most,
                                             &EvaluatedSurface::from_truth_mean,
                                             &EvaluatedSurface::from_truth_rms,
                                             &EvaluatedSurface::from_truth_most}) {
      row.*length *= metres_per_unit;
    }
  }
  for (EvaluatedLight& row : evaluation.lights) row.position_m *= metres_per_unit;
  for (EvaluatedCamera& row : evaluation.cameras) row.position_m *= metres_per_unit;
  if (evaluation.parameters.empty()) return;
  evaluation.notes.push_back(fmt::format(
      "unknowns that are lengths are in the scene's unit, which is {:.4g} m", metres_per_unit));
}

template <class Row>
double MeanOf(const std::vector<Row>& rows, double Row::*member, std::optional<bool> validation) {
  optim::KnownMean mean;
  for (const Row& row : rows) {
    if (!validation || row.validation == *validation) mean.Add(row.*member);
  }
  return mean.Value();
}

Json MeansJson(const std::vector<EvaluatedView>& views, std::optional<bool> validation) {
  const auto mean = [&](double EvaluatedView::*member) {
    return ToJson(MeanOf(views, member, validation));
  };
  const auto count = std::ranges::count_if(views, [&](const EvaluatedView& view) {
    return !validation || view.validation == *validation;
  });
  return {{"views", count},
          {"psnr_srgb_db", mean(&EvaluatedView::psnr_srgb)},
          {"psnr_linear_db", mean(&EvaluatedView::psnr_linear)},
          {"psnr_scaled_db", mean(&EvaluatedView::psnr_scaled)},
          {"ssim", mean(&EvaluatedView::ssim)},
          {"iou", mean(&EvaluatedView::iou)}};
}

template <class Row>
void AddTable(const char* key,
              const char* title,
              const char* note,
              const std::vector<Row>& rows,
              Json& tables) {
  if (rows.empty()) return;
  Json table = {{"key", key}, {"title", title}, {"note", note}, {"columns", Json::array()}};
  const Row none;
  Fields<Row>::Visit(none, [&](const Figure& figure, const auto& member) {
    const auto known = [&](const Row& row) {
      const Json json = ToJson(row);
      return !json[figure.key].is_null();
    };
    static_cast<void>(member);
    if (!std::ranges::any_of(rows, known)) return;
    table["columns"].push_back(
        {{"key", figure.key}, {"unit", figure.unit}, {"label", figure.label}, {"doc", figure.doc}});
  });
  table["rows"] = ToJson(rows);
  tables.push_back(std::move(table));
}

std::string Figured(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

/// One row for each kind of picture that there is.
std::vector<EvaluatedView> MeansOf(const Evaluation& evaluation) {
  std::vector<EvaluatedView> means;
  const auto add_mean = [&](const char* name,
                            const std::vector<EvaluatedView>& rows,
                            std::optional<bool> validation) {
    const Json json = MeansJson(rows, validation);
    if (json["views"] == 0) return;
    EvaluatedView& mean = means.emplace_back();
    mean.view = fmt::format("{}, {} views", name, json["views"].get<int>());
    mean.validation = validation.value_or(false);
    for (double EvaluatedView::*figure : {&EvaluatedView::psnr_srgb,
                                          &EvaluatedView::psnr_linear,
                                          &EvaluatedView::psnr_scaled,
                                          &EvaluatedView::ssim,
                                          &EvaluatedView::iou}) {
      mean.*figure = MeanOf(rows, figure, validation);
    }
  };
  add_mean("held out", evaluation.views, true);
  add_mean("fitted", evaluation.views, false);
  add_mean("relit", evaluation.relit, std::nullopt);
  return means;
}

std::string TextOf(const EvaluatedLight& row) {
  std::string text = fmt::format("Light {}:", row.light);
  if (std::isfinite(row.position_m)) text += fmt::format(" {:.3g} m off,", row.position_m);
  if (std::isfinite(row.direction_deg))
    text += fmt::format(" {:.3g} degrees off,", row.direction_deg);
  if (std::isfinite(row.radiance_percent)) {
    text += fmt::format(" radiance rms {:.3g} %, {:.3g} % after a factor,",
                        row.radiance_percent,
                        row.scaled_percent);
  }
  return text + fmt::format(" ratio {:.4g} {:.4g} {:.4g}\n", row.ratio_r, row.ratio_g, row.ratio_b);
}

}  // namespace

Evaluation Evaluate(const Experiment& run, const Scene* truth, const EvaluationOptions& options) {
  Evaluation out;
  EvaluateViews(run, options, out);
  if (truth == nullptr) {
    out.notes.emplace_back("no truth was given: photos alone are compared");
    return out;
  }
  EvaluateRelit(run, *truth, options, out);
  EvaluateSurfaces(run, *truth, options, out);
  EvaluateParameters(run, *truth, out);
  EvaluateLights(run, *truth, out);
  EvaluateCameras(run, *truth, out);
  if (run.observations.metres_per_unit > 0.0) InMetres(run.observations.metres_per_unit, out);
  return out;
}

Json EvaluationJson(const Evaluation& evaluation) {
  Json json = {{"schema", "pathfit-eval-1"},
               {"image_scale", evaluation.image_scale},
               {"held_out", MeansJson(evaluation.views, true)},
               {"fitted", MeansJson(evaluation.views, false)},
               {"views", ToJson(evaluation.views)}};
  if (!evaluation.relit.empty()) {
    json["relit"] = MeansJson(evaluation.relit, std::nullopt);
    json["relit"]["light"] = evaluation.relit_by;
    json["relit_views"] = ToJson(evaluation.relit);
  }
  json["surfaces"] = ToJson(evaluation.surfaces);
  json["appearance"] = ToJson(evaluation.appearance);
  json["parameters"] = ToJson(evaluation.parameters);
  json["lights"] = ToJson(evaluation.lights);
  json["cameras"] = ToJson(evaluation.cameras);
  json["notes"] = evaluation.notes;
  return json;
}

Json EvaluationPage(const Evaluation& evaluation, const Json& figures) {
  Json page = {{"evaluation", figures}, {"tables", Json::array()}, {"pictures", Json::array()}};
  Json& tables = page["tables"];
  AddTable("means", "Means", "", MeansOf(evaluation), tables);
  AddTable("views",
           "Photos",
           "PSNR and SSIM where colours are compared: inside the masks.",
           evaluation.views,
           tables);
  const std::string relit_note =
      "Run and truth lit by " + evaluation.relit_by +
      " instead of their lights, where either shows a surface. Scaled: after one factor per "
      "channel, the same for all views, which colours and lights share.";
  AddTable("relit", "Under another light", relit_note.c_str(), evaluation.relit, tables);
  AddTable("surfaces",
           "Surfaces",
           "To the truth: from points of the result; from the truth: from points of the truth, so "
           "that it tells what is missing. Seen: points that a fitted photo sees.",
           evaluation.surfaces,
           tables);
  AddTable(
      "appearance",
      "Materials",
      "At points of the truth and the points of the result next to them; in percent of the "
      "root mean square of the truth. Median: half of the points are better; far below the rms "
      "where errors sit along edges. Scaled: after one factor per channel.",
      evaluation.appearance,
      tables);
  AddTable("parameters", "Unknowns", "Result minus truth.", evaluation.parameters, tables);
  AddTable("lights",
           "Lights",
           "Ratios: result over truth; of environments by the best factor per channel.",
           evaluation.lights,
           tables);
  AddTable("cameras", "Cameras", "Result against truth.", evaluation.cameras, tables);
  for (const EvaluatedPicture& picture : evaluation.pictures) {
    Json shown = {{"title", picture.title}, {"tag", picture.tag}, {"pictures", Json::array()}};
    for (const auto& [caption, bytes] : picture.pictures) {
      shown["pictures"].push_back({{"caption", caption}, {"source", DataUri(bytes)}});
    }
    page["pictures"].push_back(std::move(shown));
  }
  return page;
}

std::string EvaluationText(const Evaluation& evaluation) {
  std::string text;
  const auto views = [&](const char* title,
                         const std::vector<EvaluatedView>& rows,
                         std::optional<bool> validation) {
    const Json means = MeansJson(rows, validation);
    if (means["views"] == 0) return;
    text += fmt::format("{}: PSNR {} dB (sRGB), SSIM {}, IoU {}, of {} views\n",
                        title,
                        Figured(MeanOf(rows, &EvaluatedView::psnr_srgb, validation), "{:.2f}"),
                        Figured(MeanOf(rows, &EvaluatedView::ssim, validation), "{:.4f}"),
                        Figured(MeanOf(rows, &EvaluatedView::iou, validation), "{:.4f}"),
                        means["views"].get<int>());
  };
  views("Held out", evaluation.views, true);
  views("Fitted", evaluation.views, false);
  views("Relit", evaluation.relit, std::nullopt);
  for (const EvaluatedSurface& row : evaluation.surfaces) {
    text += fmt::format(
        "Surface {}: {:.3g} % of the diagonal, normals {:.2f} degrees to and {:.2f} from the "
        "truth, at most {:.3g} m\n",
        row.surface,
        row.mean_percent,
        row.to_truth_angle_deg,
        row.from_truth_angle_deg,
        std::max(row.to_truth_most, row.from_truth_most));
  }
  for (const EvaluatedAppearance& row : evaluation.appearance) {
    text += fmt::format("{} ({}): rms {:.3g}", row.property, row.surface, row.rms);
    if (std::isfinite(row.rms_percent)) text += fmt::format(", {:.3g} %", row.rms_percent);
    if (std::isfinite(row.scaled_percent)) {
      text += fmt::format(", {:.3g} % after a factor per channel", row.scaled_percent);
    }
    text += fmt::format(", half of the points within {:.3g}\n", row.median);
  }
  for (const EvaluatedParameter& row : evaluation.parameters) {
    text += fmt::format(
        "{}: rms error {:.3g} (truth {:.3g})\n", row.name, row.rms_error, row.rms_truth);
  }
  for (const EvaluatedLight& row : evaluation.lights) text += TextOf(row);
  if (!evaluation.cameras.empty()) {
    const auto mean = [&](double EvaluatedCamera::*member) {
      return MeanOf(evaluation.cameras, member, std::nullopt);
    };
    text += fmt::format("Cameras: {:.3g} m and {:.3g} degrees off in the mean\n",
                        mean(&EvaluatedCamera::position_m),
                        mean(&EvaluatedCamera::rotation_deg));
  }
  for (const std::string& note : evaluation.notes) text += "Note: " + note + "\n";
  return text;
}

}  // namespace pathfit::app
