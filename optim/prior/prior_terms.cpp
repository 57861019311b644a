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

namespace pathfit::optim {
namespace {

using renderer::ParameterGroup;
using renderer::ParameterKind;

struct Context {
  const renderer::Scene& run_start;
  const renderer::Scene& scene;
  const ParameterSet& set;
  double num_channels;
  std::vector<PriorTerm>& terms;
};

const renderer::Mesh& MeshOf(const Context& context, const ParameterGroup& group) {
  return context.scene.meshes[static_cast<std::size_t>(group.object)].mesh;
}

void AddLaplacian(const Context& context, const ParameterGroup& group, double weight) {
  const renderer::Mesh& mesh = MeshOf(context, group);
  const auto topology = renderer::MeshTopology::Build(mesh);
  const double edge = topology.MeanEdgeLength(mesh);
  const double scale =
      std::sqrt(context.num_channels * weight / static_cast<double>(group.num_blocks)) / edge;
  for (std::int32_t v = 0; v < group.num_blocks; ++v) {
    const auto& neighbors = topology.neighbors[static_cast<std::size_t>(v)];
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

void AddTexelSmoothness(const Context& context, const ParameterGroup& group, double weight) {
  const TexelGrid grid = GridOf(context, group);
  std::vector<BlockPair> pairs;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width && grid.HasRight(x); ++x) {
      pairs.push_back({grid.Block(x, y), grid.Block(x + 1, y), grid.Weight(y + 0.5)});
    }
    for (int x = 0; x < grid.width && grid.HasBelow(y); ++x) {
      pairs.push_back({grid.Block(x, y), grid.Block(x, y + 1), grid.Weight(y + 1.0)});
    }
  }
  AddDifferences(context, pairs, weight);
}

void AddTotalVariation(const Context& context, const ParameterGroup& group, double weight) {
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
    if (start.size() != static_cast<std::size_t>(group.num_blocks) * size) {
      throw renderer::SceneError(group.name +
                                 ": a prior around the run's start needs the start's shape");
    }
  }
  const double scale = kGaussianResidual / gaussian.sigma;
  for (std::int32_t i = 0; i < group.num_blocks; ++i) {
    PriorTerm term{{group.first_block + i}, {scale}};
    term.is_belief = true;
    for (std::size_t c = 0; c < size; ++c) {
      const double mean = start.empty() ? gaussian.mean[gaussian.mean.size() == 1 ? 0 : c]
                                        : start[static_cast<std::size_t>(i) * size + c];
      term.offset[c] = scale * mean;
    }
    context.terms.push_back(std::move(term));
  }
}

void AddExposure(const Context& context,
                 const ParameterGroup& group,
                 const ExposureModel& exposure) {
  const double scale = kGaussianResidual / (exposure.prior.sigma_ev * std::log(2.0));
  const double start = exposure.start_gains[static_cast<std::size_t>(group.object)];
  PriorTerm term{{group.first_block}, {scale}, {scale * std::log(start), 0.0, 0.0}};
  term.in_theta = true;
  term.is_belief = true;
  context.terms.push_back(std::move(term));
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
    {{"neutral", "Texels: light near grey.", &UnknownSpec::neutral_weight}, AddNeutral}};

/// Only priors that suit the kind count.
void AddWeighted(const Context& context, const ParameterGroup& group, const UnknownSpec& unknown) {
  for (const std::string_view name : renderer::TraitsOf(group.kind).priors) {
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
                                       double num_channels) {
  std::vector<PriorTerm> terms;
  const Context context{run_start, scene, set, num_channels, terms};
  const auto& groups = set.layout().groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const ParameterGroup& group = groups[g];
    const UnknownSpec& unknown = unknowns[static_cast<std::size_t>(set.UnknownOfGroup(g))];
    AddWeighted(context, group, unknown);
    if (group.kind == ParameterKind::kExposure) {
      AddExposure(context, group, exposure);
    } else if (unknown.gaussian) {
      AddGaussian(context, group, *unknown.gaussian);
    }
  }
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
    const auto topology =
        renderer::MeshTopology::Build(scene.meshes[static_cast<std::size_t>(group.object)].mesh);
    for (std::int32_t v = 0; v < group.num_blocks; ++v) {
      const auto& neighbors = topology.neighbors[static_cast<std::size_t>(v)];
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

std::vector<double> PriorHessian(const std::vector<PriorTerm>& terms,
                                 const ParameterSet& set,
                                 const std::vector<double>& theta) {
  const std::size_t n = set.NumScalars();
  std::vector<double> hessian(n * n);
  for (const PriorTerm& term : terms) {
    std::vector<const double*> blocks;
    std::vector<std::vector<double>> jacobians;
    std::vector<double*> targets;
    for (const std::int32_t block : term.blocks) {
      blocks.push_back(theta.data() + set.BlockOffset(block));
      jacobians.emplace_back(kMaxPriorRows * static_cast<std::size_t>(set.BlockSize(block)));
    }
    for (std::vector<double>& jacobian : jacobians) {
      targets.push_back(jacobian.data());
    }
    std::array<double, kMaxPriorRows> residual{};
    EvalPrior(term, set, blocks.data(), residual.data(), targets.data());
    double slope = 1.0;
    if (term.edge > 0.0) {
      double rho[3];
      EdgeLoss(term.edge).Evaluate(
          std::inner_product(residual.begin(), residual.end(), residual.begin(), 0.0), rho);
      slope = rho[1];
    }
    const std::size_t rows =
        term.NumGroups() * static_cast<std::size_t>(set.BlockSize(term.blocks.front()));
    for (std::size_t a = 0; a < blocks.size(); ++a) {
      for (std::size_t b = 0; b < blocks.size(); ++b) {
        const auto size_a = static_cast<std::size_t>(set.BlockSize(term.blocks[a]));
        const auto size_b = static_cast<std::size_t>(set.BlockSize(term.blocks[b]));
        for (std::size_t i = 0; i < size_a * size_b; ++i) {
          const std::size_t p = i / size_b;
          const std::size_t q = i % size_b;
          double sum = 0.0;
          for (std::size_t row = 0; row < rows; ++row) {
            sum += jacobians[a][row * size_a + p] * jacobians[b][row * size_b + q];
          }
          hessian[(set.BlockOffset(term.blocks[a]) + p) * n + set.BlockOffset(term.blocks[b]) +
                  q] += slope * sum;
        }
      }
    }
  }
  return hessian;
}

std::vector<double> BeliefCovariance(const std::vector<PriorTerm>& terms,
                                     const ParameterSet& set,
                                     const std::vector<double>& theta) {
  std::vector<PriorTerm> beliefs;
  std::ranges::copy_if(terms, std::back_inserter(beliefs), &PriorTerm::is_belief);
  std::vector<double> covariance = PriorHessian(beliefs, set, theta);
  for (double& x : covariance) x *= kGaussianResidual * kGaussianResidual;
  return covariance;
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
