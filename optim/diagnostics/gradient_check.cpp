#include "optim/diagnostics/gradient_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <boost/math/distributions/students_t.hpp>

#include "renderer/budget_search.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/derivative/derivative_limits.h"
#include "renderer/derivative/film_sink.h"
#include "renderer/scene/parameter_kinds.h"

namespace pathfit::optim {
namespace {

using renderer::Film;
using renderer::Rgba;

// Differences below this share of the largest value, or of what one sample adds, are rounding, not
// signal.
constexpr double kRounding = 1e-9;
// Pixels around a tile whose light a sample of the tile may carry to its other side of an edge.
constexpr int kAround = 2;
// Replicates of the difference at half the step, and the standard errors from which on it is
// another: rarely by chance (Student's t of 3 degrees), as it then hides wrong derivatives.
constexpr int kHalvedReplicates = 4;
constexpr double kSureTruncation = 5.0;

Film Scaled(const Film& film, double scale) {
  Film out = film;
  for (Rgba& p : out.pixels) {
    p *= scale;
  }
  return out;
}

/// Sum of the tile with corner (x0, y0), weighted 1.
Rgba TileSum(const Film& film, int x0, int y0, int tile) {
  Rgba sum;
  for (int y = y0; y < std::min(film.height, y0 + tile); ++y) {
    for (int x = x0; x < std::min(film.width, x0 + tile); ++x) {
      sum += film.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(film.width) +
                         static_cast<std::size_t>(x)];
    }
  }
  return sum;
}

/// Whether the chance that a sample takes one lobe or another depends on a parameter.
bool ChangesLobes(const renderer::Scene& scene, const renderer::ParameterLayout& layout) {
  using enum renderer::ParameterKind;
  using renderer::MetallicRoughnessBsdf;
  const auto material_of = [&](int index) -> const renderer::Material& {
    return scene.materials[static_cast<std::size_t>(index)];
  };
  const auto is_gltf = [](const renderer::Material& material) {
    return std::holds_alternative<MetallicRoughnessBsdf>(material.bsdf);
  };
  return std::ranges::any_of(layout.groups(), [&](const renderer::ParameterGroup& group) {
    switch (group.kind) {
      case kBaseColor:
      case kMetallic:
      case kSpecular:
        return is_gltf(material_of(group.object));
      case kEta:
        return !std::holds_alternative<renderer::RoughConductorBsdf>(
            material_of(group.object).bsdf);
      case kVertexColors:
        return is_gltf(material_of(scene.meshes[static_cast<std::size_t>(group.object)].material));
      case kTextureTexels:
        return std::ranges::any_of(scene.materials, [&](const renderer::Material& material) {
          return is_gltf(material) && (material.base_color_texture == group.object ||
                                       material.metallic_texture == group.object);
        });
      default:
        return false;
    }
  });
}

/// What moving edges, and samples of other lobes, add to the mean estimate at most, by absolute
/// value: the difference sees it as samples that change.
Film EdgeFilm(const GradientCheckResult& result) {
  Film sum(result.difference.front().width, result.difference.front().height);
  for (const Term term : {Term::kInterior, Term::kPrimary, Term::kDirect, Term::kIndirect}) {
    if (result[term].empty() || (term == Term::kInterior && !result.changes_lobes)) {
      continue;
    }
    const Film mean = MeanFilm(result[term]);
    for (std::size_t i = 0; i < sum.pixels.size(); ++i) {
      for (int c = 0; c < 4; ++c) {
        sum.pixels[i][c] += std::abs(mean.pixels[i][c]);
      }
    }
  }
  return sum;
}

/// Largest values of the tile and what is around it.
Rgba LargestNear(const Film& film, int x0, int y0, int tile) {
  Rgba largest;
  for (int y = std::max(0, y0 - kAround); y < std::min(film.height, y0 + tile + kAround); ++y) {
    for (int x = std::max(0, x0 - kAround); x < std::min(film.width, x0 + tile + kAround); ++x) {
      const Rgba& p =
          film.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(film.width) +
                      static_cast<std::size_t>(x)];
      for (int c = 0; c < 4; ++c) {
        largest[c] = std::max(largest[c], p[c]);
      }
    }
  }
  return largest;
}

/// Upper quantile of Student's t.
double StudentQuantile(double tail, double nu) {
  const boost::math::students_t distribution(nu);
  return boost::math::quantile(boost::math::complement(distribution, std::max(tail, 1e-300)));
}

/// Values that a scalar of a group may have. One that is outside already (a colour above 1) has no
/// limit there, so that it is not moved far.
std::pair<double, double> RangeOf(const renderer::Scene& scene,
                                  const renderer::ParameterGroup& group,
                                  double value) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const renderer::ParameterTraits& traits = renderer::TraitsOf(group.kind, scene, group.object);
  if (!traits.bounded) return {-kInfinity, kInfinity};
  return {value < traits.smallest ? -kInfinity : traits.smallest,
          value > traits.largest ? kInfinity : traits.largest};
}

/// The values that both steps start from: those of the scene, moved inside their ranges.
std::vector<double> Center(const renderer::Scene& scene,
                           const renderer::ParameterLayout& layout,
                           const std::vector<double>& direction,
                           double step) {
  constexpr double kLargest = 1e9;  // relative to the value, or absolute
  constexpr int kMostNamed = 3;
  std::vector<double> center = layout.Gather(scene);
  std::string names;
  int bad = 0;
  for (const renderer::ParameterGroup& group : layout.groups()) {
    for (std::int32_t k = 0; k < static_cast<std::int32_t>(group.NumScalars()); ++k) {
      const auto i = static_cast<std::size_t>(group.first_scalar + k);
      const double size = step * std::abs(direction[i]);
      if (size == 0.0 && direction[i] == 0.0) continue;
      const double value = center[i];
      const auto [low, high] = RangeOf(scene, group, value);
      const bool visible =
          value + size != value && size <= kLargest * std::max(1.0, std::abs(value));
      if (visible && high - low > 2.0 * size) {
        center[i] = std::clamp(value, low + size, high - size);
      } else if (++bad <= kMostNamed) {
        names += (bad > 1 ? ", " : "") +
                 layout.ScalarName(group.first_block + k / group.block_size, k % group.block_size);
      }
    }
  }
  if (bad > 0) {
    throw renderer::SceneError(
        "the step is too large or too small for " + names +
        (bad > kMostNamed ? " and " + std::to_string(bad - kMostNamed) + " more" : std::string()));
  }
  return center;
}

/// The scene moved by a step along the direction both ways, and not at all.
class DisplacedScenes {
 public:
  /// A central difference and the larger of its two images.
  struct Difference {
    Film difference, largest;
  };

  DisplacedScenes(const renderer::Scene& scene,
                  const renderer::Camera& camera,
                  int sensor,
                  const renderer::ParameterLayout& layout,
                  const std::vector<double>& direction,
                  const std::vector<double>& center,
                  double step)
      : camera_(camera),
        sensor_(sensor),
        step_(step),
        at_center_(Displaced(scene, layout, direction, center, 0.0)),
        at_plus_(Displaced(scene, layout, direction, center, step), at_center_),
        at_minus_(Displaced(scene, layout, direction, center, -step), at_center_) {}

  [[nodiscard]] const renderer::Renderer& AtCenter() const { return at_center_; }
  /// The camera in the scene of a renderer, which may move.
  [[nodiscard]] renderer::Camera CameraOf(const renderer::Renderer& r) const {
    return sensor_ < 0
               ? camera_
               : renderer::ScaledCamera(r.scene().sensors[static_cast<std::size_t>(sensor_)],
                                        camera_.width,
                                        camera_.height);
  }
  /// Of the replicate of that number; both images have the same random numbers.
  [[nodiscard]] Difference Render(const GradientCheckOptions& options,
                                  int replicate,
                                  const renderer::CancelFlag* cancel) const {
    renderer::RenderOptions render = options.render;
    render.seed = SeedOf(options, replicate) + 1;
    render.spp = options.difference_spp;
    const Film plus = at_plus_.RenderPrimal(CameraOf(at_plus_), render, {.cancel = cancel});
    const Film minus = at_minus_.RenderPrimal(CameraOf(at_minus_), render, {.cancel = cancel});
    Difference out{Film(plus.width, plus.height), Film(plus.width, plus.height)};
    for (std::size_t i = 0; i < plus.pixels.size(); ++i) {
      out.difference.pixels[i] = (plus.pixels[i] - minus.pixels[i]) * (0.5 / step_);
      for (int c = 0; c < 4; ++c) {
        out.largest.pixels[i][c] = std::max(plus.pixels[i][c], minus.pixels[i][c]);
      }
    }
    return out;
  }
  static std::uint64_t SeedOf(const GradientCheckOptions& options, int replicate) {
    return options.render.seed + 2 * static_cast<std::uint64_t>(replicate);
  }

 private:
  static renderer::Scene Displaced(const renderer::Scene& scene,
                                   const renderer::ParameterLayout& layout,
                                   const std::vector<double>& direction,
                                   std::vector<double> values,
                                   double step) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (direction[i] != 0.0) values[i] += step * direction[i];
    }
    renderer::Scene moved = scene;
    layout.Scatter(values, moved);
    return moved;
  }

  const renderer::Camera& camera_;
  int sensor_;
  double step_;
  renderer::Renderer at_center_, at_plus_, at_minus_;
};

/// The truncation error of the difference in a tile, where it is surely one; else 0.
Rgba TruncationOf(const GradientCheckResult& result, int x0, int y0, int tile) {
  const auto n = static_cast<double>(result.halved.size());
  std::vector<Rgba> errors;
  Rgba mean;
  for (std::size_t r = 0; r < result.halved.size(); ++r) {
    // It falls with the square of the step: three quarters of it are gone at half the step.
    errors.push_back(
        (TileSum(result.difference[r], x0, y0, tile) - TileSum(result.halved[r], x0, y0, tile)) *
        (4.0 / 3.0));
    mean += errors.back() * (1.0 / n);
  }
  Rgba out;
  for (int c = 0; c < 4 && n > 1.0; ++c) {
    double square = 0.0;
    for (const Rgba& e : errors) square += (e[c] - mean[c]) * (e[c] - mean[c]);
    const double error_bar = std::sqrt(square / (n * (n - 1.0)));
    if (std::abs(mean[c]) > kSureTruncation * error_bar) out[c] = std::abs(mean[c]);
  }
  return out;
}

}  // namespace

GradientCheckResult CheckGradient(const renderer::Scene& scene,
                                  const renderer::Camera& camera,
                                  int sensor,
                                  const renderer::ParameterLayout& layout,
                                  const std::vector<double>& direction,
                                  const GradientCheckOptions& options,
                                  const renderer::CancelFlag* cancel) {
  PATHFIT_CHECK(options.replicates > 1 && options.step > 0.0);
  const std::vector<double> center = Center(scene, layout, direction, options.step);
  const DisplacedScenes scenes(scene, camera, sensor, layout, direction, center, options.step);
  const renderer::Renderer& at_center = scenes.AtCenter();
  const renderer::Camera camera_at_center = scenes.CameraOf(at_center);

  renderer::RenderOptions render = options.render;
  render.with_image = false;
  if (options.given) {
    render = renderer::ChooseDerivative(at_center,
                                        {camera_at_center, sensor, layout, {&direction, 1}},
                                        render,
                                        *options.given,
                                        cancel);
  }
  const bool moves = layout.AnyKind(renderer::MovesGeometry);
  GradientCheckResult result;
  result.changes_lobes = ChangesLobes(scene, layout);
  const bool samples_change = result.changes_lobes || layout.AnyKind(renderer::MovesEdges);
  result.quantum = Film(camera.width, camera.height);
  for (int r = 0; r < options.replicates; ++r) {
    render.seed = DisplacedScenes::SeedOf(options, r);
    for (const auto& [name, term] : renderer::kDerivativeTerms) {
      if (!options.render.Has(term) || (term != Term::kInterior && !moves)) {
        continue;
      }
      render.terms = {term};
      render.spp = term == Term::kInterior ? options.render.spp : 1;
      renderer::FilmSink sink(layout, direction, camera.width, camera.height);
      at_center.RenderDerivative(
          camera_at_center, sensor, render, layout, sink, {.cancel = cancel});
      result.terms[static_cast<std::size_t>(term)].push_back(sink.film());
    }
    DisplacedScenes::Difference drawn = scenes.Render(options, r, cancel);
    result.difference.push_back(std::move(drawn.difference));
    for (std::size_t i = 0; i < result.quantum.pixels.size() && samples_change; ++i) {
      for (int c = 0; c < 4; ++c) {
        double& quantum = result.quantum.pixels[i][c];
        quantum = std::max(quantum, drawn.largest.pixels[i][c]);
      }
    }
  }
  for (Rgba& q : result.quantum.pixels) {
    q *= 0.5 / (options.step * options.difference_spp * options.replicates);
  }
  return result;
}

void AddHalvedDifference(const renderer::Scene& scene,
                         const renderer::Camera& camera,
                         int sensor,
                         const renderer::ParameterLayout& layout,
                         const std::vector<double>& direction,
                         const GradientCheckOptions& options,
                         GradientCheckResult& result,
                         const renderer::CancelFlag* cancel) {
  const std::vector<double> center = Center(scene, layout, direction, options.step);
  const DisplacedScenes scenes(
      scene, camera, sensor, layout, direction, center, 0.5 * options.step);
  const auto replicates = std::min<std::size_t>(kHalvedReplicates, result.difference.size());
  while (result.halved.size() < replicates) {
    const auto r = static_cast<int>(result.halved.size());
    result.halved.push_back(scenes.Render(options, r, cancel).difference);
  }
}

GradientComparison Compare(const GradientCheckResult& result, int tile, double sigma) {
  const std::size_t n = result.difference.size();
  const Film& first = result.difference.front();
  const std::vector<Film> estimates = Estimates(result);
  const Film edge_film = EdgeFilm(result);
  const int side = tile > 0 ? tile : std::max(first.width, first.height);
  GradientComparison out;
  double sum_z2 = 0.0;
  double sum_signal2 = 0.0;
  double sum_noise2 = 0.0;
  double sum_truncation2 = 0.0;
  for (int y = 0; y < first.height; y += side) {
    for (int x = 0; x < first.width; x += side) {
      const Rgba quantum = LargestNear(result.quantum, x, y, side);
      const Rgba edges = TileSum(edge_film, x, y, side);
      const Rgba truncation = TruncationOf(result, x, y, side);
      std::vector<Rgba> errors;
      Rgba mean_error;
      Rgba mean_difference;
      for (std::size_t r = 0; r < n; ++r) {
        const Rgba difference = TileSum(result.difference[r], x, y, side);
        errors.push_back(TileSum(estimates[r], x, y, side) - difference);
        mean_error += errors.back() * (1.0 / static_cast<double>(n));
        mean_difference += difference * (1.0 / static_cast<double>(n));
      }
      for (int c = 0; c < 4; ++c) {
        double variance = 0.0;
        double largest = std::abs(mean_difference[c]);
        for (const Rgba& e : errors) {
          variance += (e[c] - mean_error[c]) * (e[c] - mean_error[c]);
          largest = std::max(largest, std::abs(e[c]));
        }
        const bool constant = variance == 0.0 && mean_error[c] == 0.0;
        // Poisson: `edges` in steps of `quantum`; of more than one the spread tells.
        const double counted = constant ? 0.0 : std::min(edges[c], quantum[c]) * quantum[c];
        const double error_bar = std::sqrt(variance / static_cast<double>(n * (n - 1)) + counted +
                                           truncation[c] * truncation[c]);
        const double rounding = kRounding * (largest + quantum[c]) + 1e-300;
        if (error_bar <= rounding &&
            std::abs(mean_error[c]) <= 1e-6 * std::abs(mean_difference[c]) + rounding) {
          if (largest > 1e-300) {
            ++out.count;
            sum_signal2 += mean_difference[c] * mean_difference[c];
          }
          continue;
        }
        ++out.count;
        const double z = std::abs(mean_error[c]) / std::max(error_bar, rounding);
        sum_z2 += z * z;
        out.z_max = std::max(out.z_max, z);
        sum_signal2 += mean_difference[c] * mean_difference[c];
        sum_noise2 += error_bar * error_bar;
        sum_truncation2 += truncation[c] * truncation[c];
      }
    }
  }
  if (out.count > 0) {
    const double count = static_cast<double>(out.count);
    out.z_rms = std::sqrt(sum_z2 / count);
    out.z_limit = StudentQuantile(0.5 * std::erfc(sigma / std::sqrt(2.0)) / count,
                                  static_cast<double>(n - 1));
    out.signal_to_noise = sum_noise2 > 0.0 ? std::sqrt(sum_signal2 / sum_noise2)
                                           : std::numeric_limits<double>::infinity();
    out.truncation = sum_signal2 > 0.0 ? std::sqrt(sum_truncation2 / sum_signal2) : 0.0;
  }
  return out;
}

std::vector<Film> Estimates(const GradientCheckResult& result) {
  std::vector<Film> sums;
  for (const Film& difference : result.difference) {
    sums.emplace_back(difference.width, difference.height);
  }
  for (const auto& [name, term] : renderer::kDerivativeTerms) {
    for (std::size_t r = 0; r < result[term].size(); ++r) {
      for (std::size_t i = 0; i < sums[r].pixels.size(); ++i) {
        sums[r].pixels[i] += result[term][r].pixels[i];
      }
    }
  }
  return sums;
}

Film MeanFilm(const std::vector<Film>& films) {
  Film sum = Scaled(films.front(), 0.0);
  for (const Film& film : films) {
    for (std::size_t i = 0; i < sum.pixels.size(); ++i) {
      sum.pixels[i] += film.pixels[i] * (1.0 / static_cast<double>(films.size()));
    }
  }
  return sum;
}

}  // namespace pathfit::optim
