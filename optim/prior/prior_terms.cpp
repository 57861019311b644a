#include "optim/prior/prior_terms.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <numeric>
#include <string_view>
#include <variant>

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/geometry/texel_places.h"
#include "renderer/sampler/counter_rng.h"
#include "renderer/scene/texture_surface.h"

namespace pathfit::optim {
namespace {

using renderer::ParameterGroup;
using renderer::ParameterKind;

struct Context {
  const renderer::Scene& run_start;
  const renderer::Scene& scene;
  const ParameterSet& set;
  double num_channels;
  double unexplained;
  std::vector<PriorTerm>& terms;
};

const renderer::Mesh& MeshOf(const Context& context, const ParameterGroup& group) {
  return context.scene.meshes[static_cast<std::size_t>(group.object)].mesh;
}

void AddLaplacian(const Context& context, const ParameterGroup& group, double weight) {
  const renderer::Mesh& mesh = MeshOf(context, group);
  const auto topology = renderer::MeshTopology::Build(mesh);
  const auto rings = topology.Neighbors(mesh);
  const double edge = topology.MeanEdgeLength(mesh);
  const double scale =
      std::sqrt(context.num_channels * weight / static_cast<double>(group.num_blocks)) / edge;
  for (std::int32_t v = 0; v < group.num_blocks; ++v) {
    const auto& neighbors = rings[static_cast<std::size_t>(v)];
    if (neighbors.empty()) continue;
    PriorTerm term;
    term.blocks.push_back(group.first_block + v);
    term.weights.push_back(scale);
    for (const std::int32_t neighbor : neighbors) {
      term.blocks.push_back(group.first_block + neighbor);
      term.weights.push_back(-scale / static_cast<double>(neighbors.size()));
    }
    context.terms.push_back(std::move(term));
  }
}

struct BlockPair {
  std::int32_t a, b;
  double weight;
};

void AddDifferences(const Context& context, const std::vector<BlockPair>& pairs, double weight) {
  double total = 0.0;
  for (const BlockPair& pair : pairs) total += pair.weight;
  for (const BlockPair& pair : pairs) {
    const double scale = std::sqrt(context.num_channels * weight * pair.weight / total);
    context.terms.push_back({{pair.a, pair.b}, {scale, -scale}});
  }
}

/// Neighbourhood of the texels of a texture or environment.
struct TexelGrid {
  std::int32_t first_block = 0;
  int width = 1, height = 1;
  bool wraps_u = false, wraps_v = false;
  bool is_sphere = false;  ///< rows are latitudes, and count by their cosine

  [[nodiscard]] std::int32_t Block(int x, int y) const {
    return first_block + y % height * width + x % width;
  }
  /// The last of two or more is next to the first where the grid wraps around; two are one pair.
  [[nodiscard]] bool HasRight(int x) const { return x + 1 < width || (wraps_u && width > 2); }
  [[nodiscard]] bool HasBelow(int y) const { return y + 1 < height || (wraps_v && height > 2); }
  /// `row`: y + 1/2 for a row's centre, y + 1 for its lower border.
  [[nodiscard]] double Weight(double row) const {
    return is_sphere ? std::sin(std::numbers::pi * row / static_cast<double>(height)) : 1.0;
  }
};

TexelGrid GridOf(const Context& context, const ParameterGroup& group) {
  const auto object = static_cast<std::size_t>(group.object);
  if (group.kind == ParameterKind::kTextureTexels) {
    const renderer::Texture& texture = context.scene.textures[object];
    const bool repeats = texture.wrap == renderer::TextureWrap::kRepeat;
    return {group.first_block, texture.width, texture.height, repeats, repeats, false};
  }
  const auto& environment =
      std::get<renderer::EnvironmentEmitter>(context.scene.emitters[object].light);
  return {group.first_block, environment.width, environment.height, true, false, true};
}

/// What priors on the texels of an atlas weigh: the slope on the surface, in differences over the
/// mean texel's side, and jumps across seams.
class AtlasTerms {
 public:
  AtlasTerms(const renderer::Scene& scene, const ParameterGroup& group)
      : texture_(scene.textures[static_cast<std::size_t>(group.object)]),
        first_block_(group.first_block) {
    std::vector<const renderer::Mesh*> meshes;
    for (const int i : renderer::MeshesOfTexture(scene, group.object)) {
      const renderer::SceneMesh& item = scene.meshes[static_cast<std::size_t>(i)];
      meshes.push_back(&item.mesh);
      scales_.push_back(item.pose.scale);
    }
    places_ = renderer::PlaceTexels(meshes, texture_.width, texture_.height);
    seams_ = renderer::SampleSeams(meshes, texture_.width, texture_.height);
    for (const renderer::Mesh* mesh : meshes) {
      metrics_.emplace_back();
      for (std::size_t f = 0; f < mesh->triangles.size(); ++f) {
        metrics_.back().push_back(MetricOf(*mesh, f, scales_[metrics_.size() - 1]));
      }
    }
    std::size_t count = 0;
    for (const renderer::TexelPlace& place : places_) {
      if (place.mesh < 0) continue;
      area_ += Of(place).area;
      ++count;
    }
    side_ = std::sqrt(area_ / static_cast<double>(std::max<std::size_t>(1, count)));
  }

  /// Calls add(term, share) with the terms of the mean over the surface; their weights are those of
  /// differences in units of the texels.
  template <class Add>
  void ForEach(const Add& add) const {
    for (int y = 0; y < texture_.height; ++y) {
      for (int x = 0; x < texture_.width; ++x) AddSlope(x, y, add);
    }
    for (const renderer::SeamPoint& seam : seams_) AddSeam(seam, add);
  }

 private:
  /// d . G^-1 d = |(xx dx + xy dy, yy dy)|^2 for differences d to the neighbours, per metre.
  struct Metric {
    double xx = 0.0, xy = 0.0, yy = 0.0;
    double area = 0.0;  ///< of a texel, square metres
  };

  [[nodiscard]] Metric MetricOf(const renderer::Mesh& mesh, std::size_t f, double scale) const {
    const auto corner = [&](std::size_t k) {
      return mesh.positions[static_cast<std::size_t>(mesh.triangles[f][k])] * scale;
    };
    const auto texel = [&](std::size_t k) {
      const renderer::Vec2& uv = mesh.uvs[static_cast<std::size_t>(mesh.uv_triangles[f][k])];
      return renderer::Vec2{uv.x * texture_.width, -uv.y * texture_.height};
    };
    const renderer::Vec2 a = texel(1) - texel(0);
    const renderer::Vec2 b = texel(2) - texel(0);
    const renderer::Vec3 p = corner(1) - corner(0);
    const renderer::Vec3 q = corner(2) - corner(0);
    const double det = a.x * b.y - a.y * b.x;
    const renderer::Vec3 along_x = (p * b.y - q * a.y) / det;
    const renderer::Vec3 along_y = (q * a.x - p * b.x) / det;
    const double e = SquaredNorm(along_x);
    const double g = SquaredNorm(along_y);
    const double m = Dot(along_x, along_y);
    // G^-1 = [g -m; -m e] / (e g - m^2), and its root by Cholesky.
    const double square = std::max(e * g - m * m, 1e-12 * e * g);
    Metric metric;
    metric.area = std::sqrt(square);
    metric.xx = std::sqrt(g / square);
    metric.xy = -m / std::sqrt(g * square);
    metric.yy = 1.0 / std::sqrt(g);
    return metric;
  }

  [[nodiscard]] const Metric& Of(const renderer::TexelPlace& place) const {
    return metrics_[static_cast<std::size_t>(place.mesh)][static_cast<std::size_t>(place.triangle)];
  }
  [[nodiscard]] std::size_t IndexOf(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(texture_.width) +
           static_cast<std::size_t>(x);
  }
  /// The neighbour on the same chart, ahead or else behind, and the sign of the difference to it;
  /// -1: there is none.
  std::pair<std::int32_t, double> Neighbor(int x, int y, int dx, int dy) const {
    const std::int32_t chart = places_[IndexOf(x, y)].chart;
    for (const int sign : {1, -1}) {
      const int at_x = x + sign * dx, at_y = y + sign * dy;
      if (at_x < 0 || at_y < 0 || at_x >= texture_.width || at_y >= texture_.height) continue;
      const std::size_t index = IndexOf(at_x, at_y);
      if (places_[index].mesh < 0 || places_[index].chart != chart) continue;
      return {static_cast<std::int32_t>(index), static_cast<double>(sign)};
    }
    return {-1, 0.0};
  }

  template <class Add>
  void AddSlope(int x, int y, const Add& add) const {
    const renderer::TexelPlace& place = places_[IndexOf(x, y)];
    if (place.mesh < 0) return;
    const Metric& metric = Of(place);
    const auto [right, sign_x] = Neighbor(x, y, 1, 0);
    const auto [below, sign_y] = Neighbor(x, y, 0, 1);
    if (right < 0 && below < 0) return;
    PriorTerm term;
    term.blocks = {first_block_ + static_cast<std::int32_t>(IndexOf(x, y))};
    std::vector<double> first = {0.0}, second = {0.0};
    const auto include = [&](std::int32_t other, double sign, double in_first, double in_second) {
      if (other < 0) return;
      term.blocks.push_back(first_block_ + other);
      first.push_back(sign * side_ * in_first);
      second.push_back(sign * side_ * in_second);
      first[0] -= first.back();
      second[0] -= second.back();
    };
    include(right, sign_x, metric.xx, 0.0);
    include(below, sign_y, metric.xy, metric.yy);
    term.weights = std::move(first);
    if (below >= 0) term.weights.insert(term.weights.end(), second.begin(), second.end());
    add(std::move(term), metric.area / area_);
  }

  template <class Add>
  void AddSeam(const renderer::SeamPoint& seam, const Add& add) const {
    PriorTerm term;
    for (std::size_t side = 0; side < 2; ++side) {
      const renderer::TextureLookup lookup = LookUpTexture(texture_, seam.uv[side]);
      for (std::size_t k = 0; k < 4; ++k) {
        if (lookup.weight[k] == 0.0) continue;
        const std::int32_t block = first_block_ + lookup.texel[k];
        const auto known = std::ranges::find(term.blocks, block);
        const auto index = static_cast<std::size_t>(known - term.blocks.begin());
        if (known == term.blocks.end()) {
          term.blocks.push_back(block);
          term.weights.push_back(0.0);
        }
        term.weights[index] += side == 0 ? lookup.weight[k] : -lookup.weight[k];
      }
    }
    // A jump counts as a slope over the side of a texel.
    const double length = seam.length * scales_[static_cast<std::size_t>(seam.mesh)];
    add(std::move(term), side_ * length / area_);
  }

  const renderer::Texture& texture_;
  std::int32_t first_block_;
  std::vector<double> scales_;  ///< by mesh
  std::vector<renderer::TexelPlace> places_;
  std::vector<renderer::SeamPoint> seams_;
  std::vector<std::vector<Metric>> metrics_;  ///< by mesh and triangle
  double area_ = 0.0;                         ///< of all texels, square metres
  double side_ = 0.0;                         ///< of the mean texel
};

bool IsOnAtlas(const Context& context, const ParameterGroup& group) {
  return group.kind == ParameterKind::kTextureTexels &&
         renderer::IsAtlas(context.scene, group.object);
}

/// With `edge` > 0 as total variation, else quadratic.
void AddAtlasTerms(const Context& context,
                   const ParameterGroup& group,
                   double weight,
                   double edge) {
  AtlasTerms(context.scene, group).ForEach([&](PriorTerm term, double share) {
    // As for a grid: the mean over pairs of neighbours, of which a texel has two.
    const double scale =
        std::sqrt(context.num_channels * weight * share / (edge > 0.0 ? edge : 2.0));
    for (double& w : term.weights) w *= scale;
    term.edge = scale * edge;
    context.terms.push_back(std::move(term));
  });
}

std::vector<BlockPair> PairsOf(const TexelGrid& grid) {
  std::vector<BlockPair> pairs;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width && grid.HasRight(x); ++x) {
      pairs.push_back({grid.Block(x, y), grid.Block(x + 1, y), grid.Weight(y + 0.5)});
    }
    for (int x = 0; x < grid.width && grid.HasBelow(y); ++x) {
      pairs.push_back({grid.Block(x, y), grid.Block(x, y + 1), grid.Weight(y + 1.0)});
    }
  }
  return pairs;
}

void AddTexelSmoothness(const Context& context, const ParameterGroup& group, double weight) {
  if (IsOnAtlas(context, group)) return AddAtlasTerms(context, group, weight, 0.0);
  AddDifferences(context, PairsOf(GridOf(context, group)), weight);
}

void AddLogSmoothness(const Context& context, const ParameterGroup& group, double weight) {
  const double scale = context.unexplained * std::sqrt(weight);
  for (const BlockPair& pair : PairsOf(GridOf(context, group))) {
    PriorTerm term{{pair.a, pair.b}, {scale, -scale}};
    term.in_theta = true;
    term.belief = context.unexplained;
    context.terms.push_back(std::move(term));
  }
}

void AddTotalVariation(const Context& context, const ParameterGroup& group, double weight) {
  if (IsOnAtlas(context, group)) return AddAtlasTerms(context, group, weight, kTotalVariationEdge);
  const TexelGrid grid = GridOf(context, group);
  double total = 0.0;
  for (int y = 0; y < grid.height; ++y) total += grid.width * grid.Weight(y + 0.5);
  for (int y = 0; y < grid.height; ++y) {
    // The cost scale^2 e (sqrt(|d|^2 + e^2) - e) of a term is its share of the weight.
    const double share = context.num_channels * weight * grid.Weight(y + 0.5) / total;
    const double scale = std::sqrt(share / kTotalVariationEdge);
    for (int x = 0; x < grid.width; ++x) {
      PriorTerm term;
      term.blocks = {grid.Block(x, y)};
      if (grid.HasRight(x)) term.blocks.push_back(grid.Block(x + 1, y));
      if (grid.HasBelow(y)) term.blocks.push_back(grid.Block(x, y + 1));
      const std::size_t count = term.blocks.size();
      for (std::size_t g = 1; g < count; ++g) {
        std::vector<double> row(count, 0.0);
        row[0] = scale;
        row[g] = -scale;
        term.weights.insert(term.weights.end(), row.begin(), row.end());
      }
      term.edge = scale * kTotalVariationEdge;
      if (count > 1) context.terms.push_back(std::move(term));
    }
  }
}

void AddColorSmoothness(const Context& context, const ParameterGroup& group, double weight) {
  const renderer::Mesh& mesh = MeshOf(context, group);
  std::vector<std::array<std::int32_t, 2>> edges;
  for (const renderer::Triangle& t : mesh.color_triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      edges.push_back({low, high});
    }
  }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<BlockPair> pairs;
  pairs.reserve(edges.size());
  for (const auto& edge : edges) {
    pairs.push_back({group.first_block + edge[0], group.first_block + edge[1], 1.0});
  }
  AddDifferences(context, pairs, weight);
}

void AddSmoothness(const Context& context, const ParameterGroup& group, double weight) {
  const bool is_texels = group.kind != ParameterKind::kVertexColors;
  (is_texels ? AddTexelSmoothness : AddColorSmoothness)(context, group, weight);
}

void AddNeutral(const Context& context, const ParameterGroup& group, double weight) {
  const double scale =
      std::sqrt(context.num_channels * weight / static_cast<double>(group.num_blocks));
  for (std::int32_t i = 0; i < group.num_blocks; ++i) {
    PriorTerm term{{group.first_block + i}, {scale}};
    term.neutral = true;
    context.terms.push_back(std::move(term));
  }
}

void AddBinary(const Context& context, const ParameterGroup& group, double weight) {
  const double scale =
      std::sqrt(context.num_channels * weight / static_cast<double>(group.num_blocks));
  for (std::int32_t i = 0; i < group.num_blocks; ++i) {
    PriorTerm term{{group.first_block + i}, {scale}};
    term.binary = true;
    context.terms.push_back(std::move(term));
  }
}

void AddGaussian(const Context& context,
                 const ParameterGroup& group,
                 const GaussianPriorSpec& gaussian) {
  if (gaussian.mean.size() > 1 &&
      gaussian.mean.size() != static_cast<std::size_t>(group.block_size)) {
    throw renderer::SceneError(group.name + ": the prior's mean has " +
                               std::to_string(gaussian.mean.size()) + " values; allowed: 1 or " +
                               std::to_string(group.block_size));
  }
  const auto size = static_cast<std::size_t>(group.block_size);
  std::vector<double> start;
  if (gaussian.mean.empty()) {
    renderer::ParameterLayout layout(context.run_start);
    layout.Add(group.kind, group.object);
    start = layout.Gather(context.run_start);
    if (start.size() != group.NumScalars()) {
      throw renderer::SceneError(group.name +
                                 ": a prior around the run's start needs the start's shape");
    }
  }
  const double scale = kGaussianResidual / gaussian.sigma;
  for (std::int32_t i = 0; i < group.num_blocks; ++i) {
    PriorTerm term{{group.first_block + i}, {scale}};
    term.belief = kGaussianResidual;
    for (std::size_t c = 0; c < size; ++c) {
      const double mean = start.empty() ? gaussian.mean[gaussian.mean.size() == 1 ? 0 : c]
                                        : start[static_cast<std::size_t>(i) * size + c];
      term.offset[c] = scale * mean;
    }
    context.terms.push_back(std::move(term));
  }
}

/// Where a light is known, the unit of its strength is not the photos': what their gains have in
/// common is as open as their bounds.
bool KnowsALight(const Context& context) {
  for (std::size_t e = 0; e < context.scene.emitters.size(); ++e) {
    if (GroupOfStrength(context.set, static_cast<int>(e)) < 0) return true;
  }
  return false;
}

/// Of the gains, or the white balances, of all photos that are fitted.
class ExposureTerms {
 public:
  ExposureTerms(const Context& context, ParameterKind kind, const ExposureModel& exposure)
      : context_(context) {
    for (const ParameterGroup& group : context.set.layout().groups()) {
      if (group.kind != kind) continue;
      blocks_.push_back(group.first_block);
      starts_.push_back(StartOfGain(exposure, kind, group.object));
    }
  }

  [[nodiscard]] std::size_t NumViews() const { return blocks_.size(); }

  /// Each is near its start.
  void AddEach(double sigma_ev) const {
    for (std::size_t i = 0; i < NumViews(); ++i) Add(sigma_ev, i, i + 1, {1.0});
  }

  /// Their mean is.
  void AddMean(double sigma_ev) const {
    Add(sigma_ev, 0, NumViews(), std::vector<double>(NumViews(), 1.0 / Count(NumViews())));
  }

  /// Each of views [begin, end) is near their mean: differences between the means of halves, of
  /// their halves, and so on. Orthonormal, so that their squares are those of the distances from
  /// the mean, with n log n entries instead of n^2.
  void AddContrasts(double sigma_ev, std::size_t begin, std::size_t end) const {
    if (end - begin < 2) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const double a = Count(middle - begin), b = Count(end - middle);
    const double norm = std::sqrt(a * b / (a + b));
    std::vector<double> weights(middle - begin, norm / a);
    weights.resize(end - begin, -norm / b);
    Add(sigma_ev, begin, end, weights);
    AddContrasts(sigma_ev, begin, middle);
    AddContrasts(sigma_ev, middle, end);
  }

 private:
  static double Count(std::size_t n) { return static_cast<double>(n); }

  /// A weighted sum over views [begin, end) is what it is at their starts.
  void Add(double sigma_ev,
           std::size_t begin,
           std::size_t end,
           const std::vector<double>& weights) const {
    const double scale = kGaussianResidual / (sigma_ev * std::log(2.0));
    PriorTerm term;
    term.in_theta = true;
    term.belief = kGaussianResidual;
    double start = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      term.blocks.push_back(blocks_[i]);
      term.weights.push_back(scale * weights[i - begin]);
      start += term.weights.back() * starts_[i];
    }
    term.offset = {start, start, start};
    context_.terms.push_back(std::move(term));
  }

  const Context& context_;
  std::vector<std::int32_t> blocks_;  ///< by fitted view
  std::vector<double> starts_;
};

void AddExposures(const Context& context, const ExposureModel& exposure) {
  const auto [sigma_ev, max_ev] = exposure.prior;
  for (const ParameterKind kind : {ParameterKind::kExposure, ParameterKind::kWhiteBalance}) {
    const ExposureTerms terms(context, kind, exposure);
    if (terms.NumViews() == 0) continue;
    if (KnowsALight(context)) {
      terms.AddMean(max_ev);
      terms.AddContrasts(sigma_ev, 0, terms.NumViews());
    } else {
      terms.AddEach(sigma_ev);
    }
  }
}

struct PriorRow : WeightedPrior {
  void (*add)(const Context& context, const ParameterGroup& group, double weight);
};
constexpr PriorRow kPriors[] = {
    {{"laplacian",
      "Vertices: each near the middle of its neighbours.",
      &UnknownSpec::laplacian_weight},
     AddLaplacian},
    {{"smooth", "Texels and vertex colours: neighbours alike.", &UnknownSpec::smooth_weight},
     AddSmoothness},
    {{"total_variation",
      "Texels: neighbours alike except at edges, which stay sharp.",
      &UnknownSpec::total_variation_weight},
     AddTotalVariation},
    {{"log_smooth",
      "Light: logarithms of neighbouring texels alike where photos leave them open, as if each "
      "difference was believed to be 1 / sqrt(weight) or less.",
      &UnknownSpec::log_smooth_weight},
     AddLogSmoothness},
    {{"neutral", "Texels: light near grey.", &UnknownSpec::neutral_weight}, AddNeutral},
    {{"binary",
      "Metallic: near 0 or 1. 0.1 decides what photos leave open.",
      &UnknownSpec::binary_weight},
     AddBinary}};

/// Only priors that suit the kind count.
void AddWeighted(const Context& context, const ParameterGroup& group, const UnknownSpec& unknown) {
  for (const std::string_view name :
       renderer::TraitsOf(group.kind, context.scene, group.object).priors) {
    const auto* prior = std::ranges::find(kPriors, name, &WeightedPrior::name);
    if (prior == std::end(kPriors) || !(unknown.*prior->weight > 0.0)) continue;
    prior->add(context, group, unknown.*prior->weight);
  }
}

class PriorCostFunction : public ceres::CostFunction {
 public:
  PriorCostFunction(const PriorTerm& term, const ParameterSet& set) : term_(term), set_(set) {
    set_num_residuals(static_cast<int>(term.NumGroups()) * set.BlockSize(term.blocks.front()));
    for (const std::int32_t block : term.blocks) {
      mutable_parameter_block_sizes()->push_back(set.BlockSize(block));
    }
  }

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    EvalPrior(term_, set_, parameters, residuals, jacobians);
    return true;
  }

 private:
  const PriorTerm& term_;
  const ParameterSet& set_;
};

/// rho(s) = 2 e (sqrt(s + e^2) - e).
class EdgeLoss : public ceres::LossFunction {
 public:
  explicit EdgeLoss(double edge) : edge_(edge) {}

  void Evaluate(double square, double rho[3]) const override {
    const double root = std::sqrt(square + edge_ * edge_);
    rho[0] = 2.0 * edge_ * square / (root + edge_);
    rho[1] = edge_ / root;
    rho[2] = -0.5 * rho[1] / (root * root);
  }

 private:
  double edge_;
};

}  // namespace

std::vector<WeightedPrior> WeightedPriors() { return {std::begin(kPriors), std::end(kPriors)}; }

std::vector<PriorTerm> BuildPriorTerms(const renderer::Scene& run_start,
                                       const renderer::Scene& scene,
                                       const std::vector<UnknownSpec>& unknowns,
                                       const ParameterSet& set,
                                       const ExposureModel& exposure,
                                       double num_channels,
                                       double unexplained) {
  std::vector<PriorTerm> terms;
  const Context context{run_start, scene, set, num_channels, unexplained, terms};
  const auto& groups = set.layout().groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const ParameterGroup& group = groups[g];
    const UnknownSpec& unknown = unknowns[static_cast<std::size_t>(set.UnknownOfGroup(g))];
    AddWeighted(context, group, unknown);
    if (!IsOfExposure(group.kind) && unknown.gaussian) {
      AddGaussian(context, group, *unknown.gaussian);
    }
  }
  AddExposures(context, exposure);
  return terms;
}

std::vector<PriorTerm> BuildProximalTerms(const renderer::Scene& scene,
                                          const std::vector<UnknownSpec>& unknowns,
                                          const ParameterSet& set,
                                          const std::vector<double>& values,
                                          double mu) {
  std::vector<PriorTerm> terms;
  const auto& groups = set.layout().groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const ParameterGroup& group = groups[g];
    const double lambda =
        unknowns[static_cast<std::size_t>(set.UnknownOfGroup(g))].large_steps_lambda;
    if (group.kind != ParameterKind::kVertexPositions || lambda <= 0.0) continue;
    const renderer::Mesh& mesh = scene.meshes[static_cast<std::size_t>(group.object)].mesh;
    const auto rings = renderer::MeshTopology::Build(mesh).Neighbors(mesh);
    for (std::int32_t v = 0; v < group.num_blocks; ++v) {
      const auto& neighbors = rings[static_cast<std::size_t>(v)];
      PriorTerm term;
      term.blocks.push_back(group.first_block + v);
      term.weights.push_back(std::sqrt(mu) *
                             (1.0 + lambda * static_cast<double>(neighbors.size())));
      for (const std::int32_t neighbor : neighbors) {
        term.blocks.push_back(group.first_block + neighbor);
        term.weights.push_back(-std::sqrt(mu) * lambda);
      }
      for (std::size_t k = 0; k < term.blocks.size(); ++k) {
        for (std::size_t c = 0; c < 3; ++c) {
          term.offset[c] += term.weights[k] * values[set.BlockOffset(term.blocks[k]) + c];
        }
      }
      terms.push_back(std::move(term));
    }
  }
  return terms;
}

void EvalPrior(const PriorTerm& term,
               const ParameterSet& set,
               double const* const* theta_blocks,
               double* residual,
               double** jacobians) {
  const auto size = static_cast<std::size_t>(set.BlockSize(term.blocks.front()));
  const std::size_t num_blocks = term.blocks.size();
  const std::size_t num_groups = term.NumGroups();
  for (std::size_t row = 0; row < num_groups * size; ++row) {
    residual[row] = -term.offset[row % size];
  }
  for (std::size_t k = 0; k < num_blocks; ++k) {
    const std::size_t offset = set.BlockOffset(term.blocks[k]);
    std::array<double, 3> y{};
    std::array<double, 3> slope{1.0, 1.0, 1.0};
    double mean = 0.0;
    for (std::size_t c = 0; c < size; ++c) {
      y[c] = theta_blocks[k][c];
      if (!term.in_theta && set.IsLog(offset + c)) {
        y[c] = std::exp(y[c]);
        slope[c] = y[c];
      }
      mean += y[c] / static_cast<double>(size);
      if (term.binary) {
        slope[c] *= 1.0 - 2.0 * y[c];
        y[c] *= 1.0 - y[c];
      }
    }
    double* jacobian = jacobians == nullptr ? nullptr : jacobians[k];
    for (std::size_t row = 0; row < num_groups * size; ++row) {
      const double weight = term.weights[row / size * num_blocks + k];
      const std::size_t component = row % size;
      residual[row] += weight * (term.neutral ? y[component] - mean : y[component]);
      for (std::size_t c = 0; jacobian != nullptr && c < size; ++c) {
        double d = component == c ? 1.0 : 0.0;
        if (term.neutral) d -= 1.0 / static_cast<double>(size);
        jacobian[row * size + c] = weight * d * slope[c];
      }
    }
  }
}

std::unique_ptr<ceres::CostFunction> MakePriorCostFunction(const PriorTerm& term,
                                                           const ParameterSet& set) {
  return std::make_unique<PriorCostFunction>(term, set);
}

std::unique_ptr<ceres::LossFunction> MakePriorLossFunction(const PriorTerm& term) {
  return term.edge > 0.0 ? std::make_unique<EdgeLoss>(term.edge) : nullptr;
}

namespace {

/// A term about a point: residual, rho' and derivatives by each of its blocks.
class LinearTerm {
 public:
  LinearTerm(const ParameterSet& set, const std::vector<double>& theta)
      : set_(set), theta_(theta) {}

  void Linearize(const PriorTerm& term) {
    blocks_.clear();
    jacobians.clear();
    targets_.clear();
    for (const std::int32_t block : term.blocks) {
      blocks_.push_back(theta_.data() + set_.BlockOffset(block));
      jacobians.emplace_back(kMaxPriorRows * static_cast<std::size_t>(set_.BlockSize(block)));
    }
    for (std::vector<double>& jacobian : jacobians) {
      targets_.push_back(jacobian.data());
    }
    residual = {};
    EvalPrior(term, set_, blocks_.data(), residual.data(), targets_.data());
    slope = 1.0;
    if (term.edge > 0.0) {
      double rho[3];
      EdgeLoss(term.edge).Evaluate(
          std::inner_product(residual.begin(), residual.end(), residual.begin(), 0.0), rho);
      slope = rho[1];
    }
    rows = term.NumGroups() * static_cast<std::size_t>(set_.BlockSize(term.blocks.front()));
  }

  /// Adds factor * J^T r to the gradient.
  void AddGradient(const PriorTerm& term,
                   double factor,
                   const std::array<double, kMaxPriorRows>& r,
                   std::vector<double>& gradient) const {
    for (std::size_t a = 0; a < jacobians.size(); ++a) {
      const auto size = static_cast<std::size_t>(set_.BlockSize(term.blocks[a]));
      for (std::size_t i = 0; i < rows * size; ++i) {
        gradient[set_.BlockOffset(term.blocks[a]) + i % size] +=
            factor * jacobians[a][i] * r[i / size];
      }
    }
  }

  std::array<double, kMaxPriorRows> residual{};
  std::vector<std::vector<double>> jacobians;  ///< rows x components, row-major
  double slope = 1.0;
  std::size_t rows = 0;

 private:
  const ParameterSet& set_;
  const std::vector<double>& theta_;
  std::vector<const double*> blocks_;
  std::vector<double*> targets_;
};

}  // namespace

void LinearizePriors(const std::vector<PriorTerm>& terms,
                     const ParameterSet& set,
                     const std::vector<double>& theta,
                     std::vector<double>& gradient,
                     const BlockProductSink& add) {
  LinearTerm linear(set, theta);
  std::vector<double> product;
  for (const PriorTerm& term : terms) {
    linear.Linearize(term);
    linear.AddGradient(term, linear.slope, linear.residual, gradient);
    for (std::size_t a = 0; a < term.blocks.size(); ++a) {
      const auto size_a = static_cast<std::size_t>(set.BlockSize(term.blocks[a]));
      for (std::size_t b = 0; b < term.blocks.size(); ++b) {
        const auto size_b = static_cast<std::size_t>(set.BlockSize(term.blocks[b]));
        product.assign(size_a * size_b, 0.0);
        for (std::size_t i = 0; i < product.size(); ++i) {
          double sum = 0.0;
          for (std::size_t row = 0; row < linear.rows; ++row) {
            sum += linear.jacobians[a][row * size_a + i / size_b] *
                   linear.jacobians[b][row * size_b + i % size_b];
          }
          product[i] = linear.slope * sum;
        }
        add(term.blocks[a], term.blocks[b], product);
      }
    }
  }
}

void DrawPriorGradients(const std::vector<PriorTerm>& terms,
                        const ParameterSet& set,
                        const std::vector<double>& theta,
                        double residual,
                        std::uint64_t seed,
                        std::vector<std::vector<double>>& draws) {
  LinearTerm linear(set, theta);
  for (std::size_t t = 0; t < terms.size(); ++t) {
    linear.Linearize(terms[t]);
    const double deviation = terms[t].belief > 0.0 ? terms[t].belief : residual;
    for (std::size_t k = 0; k < draws.size(); ++k) {
      renderer::CounterRng rng(seed, renderer::RandomDomain::kPriorSign, t, k);
      std::array<double, kMaxPriorRows> signs{};
      for (std::size_t row = 0; row < linear.rows; ++row)
        signs[row] = rng.Next() < 0.5 ? -1.0 : 1.0;
      linear.AddGradient(terms[t], std::sqrt(linear.slope) * deviation, signs, draws[k]);
    }
  }
}

std::vector<double> PriorHessian(const std::vector<PriorTerm>& terms,
                                 const ParameterSet& set,
                                 const std::vector<double>& theta) {
  const std::size_t n = set.NumScalars();
  std::vector<double> hessian(n * n), gradient(n);
  LinearizePriors(
      terms,
      set,
      theta,
      gradient,
      [&](std::int32_t row, std::int32_t column, std::span<const double> product) {
        const auto width = static_cast<std::size_t>(set.BlockSize(column));
        for (std::size_t i = 0; i < product.size(); ++i) {
          hessian[(set.BlockOffset(row) + i / width) * n + set.BlockOffset(column) + i % width] +=
              product[i];
        }
      });
  return hessian;
}

std::vector<double> PriorGradient(const std::vector<PriorTerm>& terms,
                                  const ParameterSet& set,
                                  const std::vector<double>& theta) {
  std::vector<double> gradient(set.NumScalars());
  LinearizePriors(
      terms, set, theta, gradient, [](std::int32_t, std::int32_t, std::span<const double>) {});
  return gradient;
}

std::vector<double> BeliefCovariance(const std::vector<PriorTerm>& terms,
                                     const ParameterSet& set,
                                     const std::vector<double>& theta) {
  std::vector<PriorTerm> beliefs;
  for (const PriorTerm& term : terms) {
    if (!(term.belief > 0.0)) continue;
    PriorTerm& weighed = beliefs.emplace_back(term);
    for (double& weight : weighed.weights) weight *= term.belief;
  }
  return PriorHessian(beliefs, set, theta);
}

double PriorCost(const std::vector<PriorTerm>& terms,
                 const ParameterSet& set,
                 const std::vector<double>& theta) {
  double sum = 0.0;
  std::vector<const double*> blocks;
  for (const PriorTerm& term : terms) {
    blocks.clear();
    for (const std::int32_t block : term.blocks) {
      blocks.push_back(theta.data() + set.BlockOffset(block));
    }
    std::array<double, kMaxPriorRows> residual{};
    EvalPrior(term, set, blocks.data(), residual.data(), nullptr);
    if (term.edge > 0.0) {
      double square = 0.0;
      for (const double r : residual) square += r * r;
      double rho[3];
      EdgeLoss(term.edge).Evaluate(square, rho);
      sum += 0.5 * rho[0];
    } else {
      for (const double r : residual) sum += 0.5 * r * r;
    }
  }
  return sum;
}

}  // namespace pathfit::optim
