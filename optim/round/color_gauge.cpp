#include "optim/round/color_gauge.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <variant>

#include "optim/round/exposure_gauge.h"
#include "renderer/core/error.h"
#include "renderer/core/indices.h"
#include "renderer/geometry/mesh_checks.h"

namespace pathfit::optim {
namespace {

using renderer::Emitter;
using renderer::Material;
using renderer::ParameterKind;
using renderer::Rgb;
using renderer::Scene;
using renderer::SceneMesh;

constexpr double kPoints = 20000.0;  // of all surfaces, at which the mean colour is taken
constexpr std::size_t kMostRows = 200;
constexpr double kRelativeStep = 1e-4;  // of theta
constexpr int kMostTries = 30;
constexpr double kExactMean = 1e-9;  // relative
constexpr double kNearMean = 1e-4;

const Material& MaterialOf(const Scene& scene, const SceneMesh& item) {
  return scene.materials[static_cast<std::size_t>(item.material)];
}

/// Base colour at a point of a triangle by the weights of its corners.
Rgb ColorAt(const Scene& scene, const SceneMesh& item, std::size_t t, const double* weights) {
  const Material& material = MaterialOf(scene, item);
  if (material.base_color_texture >= 0) {
    renderer::Vec2 uv;
    for (std::size_t k = 0; k < 3; ++k) {
      uv = uv + item.mesh.uvs[static_cast<std::size_t>(item.mesh.uv_triangles[t][k])] * weights[k];
    }
    return TextureValue(scene.textures[static_cast<std::size_t>(material.base_color_texture)], uv);
  }
  if (!material.vertex_colors) return material.base_color;
  Rgb color;
  for (std::size_t k = 0; k < 3; ++k) {
    color +=
        item.mesh.colors[static_cast<std::size_t>(item.mesh.color_triangles[t][k])] * weights[k];
  }
  return color;
}

struct ColorGroup {
  ParameterKind kind;
  int object;
};
ColorGroup ColorsOf(const Scene& scene, std::size_t mesh) {
  const Material& material = MaterialOf(scene, scene.meshes[mesh]);
  if (material.base_color_texture >= 0) {
    return {ParameterKind::kTextureTexels, material.base_color_texture};
  }
  if (material.vertex_colors) return {ParameterKind::kVertexColors, static_cast<int>(mesh)};
  return {ParameterKind::kBaseColor, scene.meshes[mesh].material};
}

bool IsFree(const ParameterSet& set, const ColorGroup& colors) {
  return set.layout().FirstBlock(colors.kind, colors.object) >= 0;
}

/// Whether a group is the base colours of surfaces that do not shine.
bool IsColor(const Scene& scene, const renderer::ParameterGroup& group) {
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const ColorGroup colors = ColorsOf(scene, m);
    if (AreaLightOf(scene, m) == nullptr && colors.kind == group.kind &&
        colors.object == group.object) {
      return true;
    }
  }
  return false;
}

bool IsBlackSurface(const Scene& scene, std::size_t mesh) {
  const Material& material = MaterialOf(scene, scene.meshes[mesh]);
  return material.base_color_texture < 0 && !material.vertex_colors &&
         renderer::IsBlack(material.base_color);
}

/// Photos that are proportional to lights times base colours say nothing of either alone.
bool IsProportional(const Scene& scene, const FitSpec& spec) {
  const bool one_bounce = spec.estimators.max_bounces <= 1;
  const bool sees_lights =
      ShowsEnvironment(scene) || std::ranges::any_of(scene.emitters, [](const Emitter& emitter) {
        return std::holds_alternative<renderer::AreaEmitter>(emitter.light);
      });
  const bool has_highlights = std::ranges::any_of(scene.meshes, [&](const SceneMesh& item) {
    return std::holds_alternative<renderer::MetallicRoughnessBsdf>(MaterialOf(scene, item).bsdf);
  });
  return one_bounce && !sees_lights && !has_highlights;
}

/// Mean over all directions, or the intensity.
Rgb StrengthOf(const Emitter& emitter) {
  Rgb strength = LightIntensity(emitter);
  if (const auto* sky = std::get_if<renderer::EnvironmentEmitter>(&emitter.light)) {
    Rgb sum;
    double total = 0.0;
    for (std::size_t i = 0; i < sky->texels.size(); ++i) {
      const double row = static_cast<double>(i / static_cast<std::size_t>(sky->width)) + 0.5;
      const double weight = std::sin(std::numbers::pi * row / sky->height);
      sum += sky->texels[i] * weight;
      total += weight;
    }
    strength *= sum / std::max(total, 1e-300);
  }
  return strength;
}

int MaterialOf(const ColorGauge& gauge, const Scene& scene) {
  if (gauge.material.empty()) return -1;
  const auto found = std::ranges::find(scene.materials, gauge.material, &Material::name);
  if (found == scene.materials.end()) {
    throw renderer::SceneError("the gauge's material '" + gauge.material + "' does not exist");
  }
  return static_cast<int>(found - scene.materials.begin());
}

bool IsNear(const Rgb& mean, const Rgb& wanted, double tolerance) {
  for (int c = 0; c < 3; ++c) {
    if (!(std::abs(mean[c] - wanted[c]) <= tolerance * wanted[c])) return false;
  }
  return true;
}

Rgb WantedMean(const ColorGauge& gauge, const Scene& start) {
  if (gauge.mean.empty()) return MeanBaseColor(start, MaterialOf(gauge, start));
  Rgb mean;
  for (std::size_t c = 0; c < 3; ++c) {
    mean[static_cast<int>(c)] = gauge.mean[gauge.mean.size() == 1 ? 0 : c];
  }
  return mean;
}

}  // namespace

Rgb MeanBaseColor(const Scene& scene, int material) {
  double area = 0.0;
  const auto counts = [&](std::size_t m) {
    return (material < 0 || scene.meshes[m].material == material) &&
           AreaLightOf(scene, m) == nullptr;
  };
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const double scale = scene.meshes[m].pose.scale;
    if (counts(m)) area += scale * scale * renderer::SurfaceArea(scene.meshes[m].mesh);
  }
  Rgb sum;
  for (std::size_t m = 0; m < scene.meshes.size() && area > 0.0; ++m) {
    if (!counts(m)) continue;
    const SceneMesh& item = scene.meshes[m];
    for (std::size_t t = 0; t < item.mesh.triangles.size(); ++t) {
      const double share = 0.5 * Norm(renderer::TwiceArea(item.mesh, item.mesh.triangles[t])) *
                           item.pose.scale * item.pose.scale / area;
      const auto rows = std::clamp(static_cast<std::size_t>(std::ceil(std::sqrt(share * kPoints))),
                                   std::size_t{1},
                                   kMostRows);
      const double step = 1.0 / static_cast<double>(rows);
      // The middles of rows * rows congruent parts.
      Rgb mean;
      const auto add = [&](double u, double v) {
        const double weights[3] = {1.0 - u - v, u, v};
        mean += ColorAt(scene, item, t, weights);
      };
      for (std::size_t i = 0; i < rows; ++i) {
        for (std::size_t j = 0; i + j < rows; ++j) {
          const double u = static_cast<double>(i), v = static_cast<double>(j);
          add((u + 1.0 / 3.0) * step, (v + 1.0 / 3.0) * step);
          if (i + j + 1 < rows) add((u + 2.0 / 3.0) * step, (v + 2.0 / 3.0) * step);
        }
      }
      sum += mean * (share * step * step);
    }
  }
  return sum;
}

std::optional<GaugeReport> SourceOfGauge(const ParameterSet& set,
                                         const FitSpec& spec,
                                         const Scene& scene) {
  GaugeReport report;
  bool any_color = false, any_light = false;
  std::string known_color, known_light;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    if (AreaLightOf(scene, m) != nullptr || IsBlackSurface(scene, m)) continue;
    const bool is_free = IsFree(set, ColorsOf(scene, m));
    any_color = any_color || is_free;
    if (!is_free) known_color = MaterialOf(scene, scene.meshes[m]).name;
  }
  for (std::size_t e = 0; e < scene.emitters.size(); ++e) {
    const bool is_free = GroupOfStrength(set, static_cast<int>(e)) >= 0;
    any_light = any_light || is_free;
    if (!is_free) known_light = scene.emitters[e].name;
  }
  // Free exposures say in what unit photos measure a light that is known.
  const bool gains_are_free =
      set.layout().AnyKind([](ParameterKind kind) { return kind == ParameterKind::kExposure; });
  report.is_of_exposures = !known_light.empty() && gains_are_free;
  if (!any_color || !(any_light || report.is_of_exposures)) return std::nullopt;
  if (!known_light.empty() && !gains_are_free) {
    report.source = GaugeSource::kKnownLight;
    report.known = known_light;
  } else if (!known_color.empty()) {
    report.source = GaugeSource::kKnownColor;
    report.known = known_color;
  } else {
    const bool proportional = IsProportional(scene, spec);
    const bool by_rule =
        !report.is_of_exposures && (spec.gauge.rule == ColorGauge::Rule::kMeanColor ||
                                    (spec.gauge.rule == ColorGauge::Rule::kAuto && proportional));
    report.source = by_rule        ? GaugeSource::kMeanColor
                    : proportional ? GaugeSource::kNothing
                                   : GaugeSource::kPhotos;
  }
  return report;
}

void FixColorGauge(const ParameterSet& set, const FitSpec& spec, const Scene& start, Scene& scene) {
  const std::optional<GaugeReport> gauge = SourceOfGauge(set, spec, scene);
  if (!gauge || gauge->source != GaugeSource::kMeanColor) return;
  const Rgb wanted = WantedMean(spec.gauge, start);
  const int material = MaterialOf(spec.gauge, scene);
  const std::vector<double> before = set.layout().Gather(scene);
  std::vector<double> values = before;
  const auto scale = [&](const renderer::ParameterGroup& group, const Rgb& by) {
    const auto first = static_cast<std::size_t>(group.first_scalar);
    const std::size_t count = group.NumScalars();
    for (std::size_t i = first; i < first + count; ++i) {
      values[i] = before[i] * by[static_cast<int>((i - first) % 3)];
    }
  };
  // Where colours meet their bounds, the others have to move by more.
  Rgb factor = Rgb::Constant(1.0);
  Scene moved = scene;
  Rgb mean = MeanBaseColor(moved, material);
  for (int i = 0; i < kMostTries && !IsNear(mean, wanted, kExactMean); ++i) {
    for (int c = 0; c < 3; ++c) {
      if (!(mean[c] > 0.0) || !(wanted[c] > 0.0)) return;
      factor[c] *= wanted[c] / mean[c];
    }
    for (const renderer::ParameterGroup& group : set.layout().groups()) {
      if (IsColor(scene, group)) scale(group, factor);
    }
    values = set.ValuesFromTheta(set.ThetaFromValues(values));
    set.layout().Scatter(values, moved);
    mean = MeanBaseColor(moved, material);
  }
  if (!IsNear(mean, wanted, kNearMean)) return;
  for (std::size_t e = 0; e < scene.emitters.size(); ++e) {
    const int group = GroupOfStrength(set, static_cast<int>(e));
    scale(set.layout().groups()[static_cast<std::size_t>(group)],
          {1.0 / factor.r, 1.0 / factor.g, 1.0 / factor.b});
  }
  if (ClampToBounds(set, values)) set.layout().Scatter(values, scene);
}

std::vector<std::vector<double>> SlopesOfRule(const ParameterSet& set,
                                              const FitSpec& spec,
                                              const Scene& scene) {
  const std::optional<GaugeReport> gauge = SourceOfGauge(set, spec, scene);
  if (!gauge || gauge->source != GaugeSource::kMeanColor) return {};
  const int material = MaterialOf(spec.gauge, scene);
  const std::vector<double> theta = set.ThetaFromValues(set.layout().Gather(scene));
  std::vector<std::vector<double>> slopes(3, std::vector<double>(theta.size()));
  Scene moved = scene;
  const auto mean_at = [&](const std::vector<double>& there) {
    set.layout().Scatter(set.ValuesFromTheta(there), moved);
    return MeanBaseColor(moved, material);
  };
  const auto step = [&](std::size_t i) {
    return kRelativeStep * std::max(1.0, std::abs(theta[i]));
  };
  const Rgb mean = mean_at(theta);
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    if (!IsColor(scene, group)) continue;
    const auto first = static_cast<std::size_t>(group.first_scalar);
    // A colour at a time: each channel's mean depends on that channel alone.
    for (std::size_t i = first; i < first + group.NumScalars(); i += 3) {
      std::vector<double> there = theta;
      for (std::size_t c = 0; c < 3; ++c) there[i + c] += step(i + c);
      const Rgb change = mean_at(there) - mean;
      for (std::size_t c = 0; c < 3; ++c) {
        slopes[c][i + c] = change[static_cast<int>(c)] / step(i + c);
      }
    }
  }
  return slopes;
}

std::optional<GaugeReport> ReportGauge(const FitSpec& spec,
                                       const ExposureModel& exposure,
                                       const Scene& start,
                                       const Scene& result) {
  const std::vector<int> sensors = renderer::AllIndices(result.sensors.size());
  std::optional<GaugeReport> report;
  for (const StageSpec& stage : spec.stages) {
    const ParameterSet set(result, spec.unknowns, stage.free, sensors, exposure);
    std::optional<GaugeReport> now = SourceOfGauge(set, spec, result);
    if (!now) continue;
    report = std::move(now);
    Rgb log_sum;
    double count = 0.0;
    const auto add = [&](const Rgb& after, const Rgb& before) {
      if (!(std::min({after.r, after.g, after.b, before.r, before.g, before.b}) > 0.0)) return;
      for (int c = 0; c < 3; ++c) log_sum[c] += std::log(after[c] / before[c]);
      count += 1.0;
    };
    for (std::size_t e = 0; e < result.emitters.size() && !report->is_of_exposures; ++e) {
      if (GroupOfStrength(set, static_cast<int>(e)) < 0) continue;
      add(StrengthOf(result.emitters[e]), StrengthOf(start.emitters[e]));
    }
    for (const renderer::ParameterGroup& group : set.layout().groups()) {
      if (!report->is_of_exposures || group.kind != ParameterKind::kExposure) continue;
      const auto view = static_cast<std::size_t>(group.object);
      add(result.sensors[view].ChannelGains(), start.sensors[view].ChannelGains());
    }
    for (int c = 0; c < 3; ++c) {
      report->factors[c] = count > 0.0 ? std::exp(log_sum[c] / count) : 1.0;
    }
  }
  if (report) {
    report->mean = MeanBaseColor(result, MaterialOf(spec.gauge, result));
    report->start = MeanBaseColor(start, MaterialOf(spec.gauge, start));
    report->wanted = WantedMean(spec.gauge, start);
  }
  return report;
}

}  // namespace pathfit::optim
