#include "optim/prior/prior_terms.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <variant>

#include <ceres/cost_function.h>

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

double MeanEdgeLength(const renderer::Mesh& mesh, const renderer::MeshTopology& topology) {
  double sum = 0.0;
  for (const renderer::MeshEdge& edge : topology.edges) {
    sum += Norm(mesh.positions[static_cast<std::size_t>(edge.vertices[0])] -
                mesh.positions[static_cast<std::size_t>(edge.vertices[1])]);
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, topology.edges.size()));
}

void AddLaplacian(const Context& context, const ParameterGroup& group, double weight) {
  const renderer::Mesh& mesh = MeshOf(context, group);
  const auto topology = renderer::MeshTopology::Build(mesh);
  const double edge = MeanEdgeLength(mesh, topology);
  const double scale =
      std::sqrt(context.num_channels * weight / static_cast<double>(group.num_blocks)) / edge;
  for (std::int32_t v = 0; v < group.num_blocks; ++v) {
    const auto& neighbors = topology.neighbors[static_cast<std::size_t>(v)];
    if (neighbors.empty()) {
      continue;
    }
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
  for (const BlockPair& pair : pairs) {
    total += pair.weight;
  }
  for (const BlockPair& pair : pairs) {
    const double scale = std::sqrt(context.num_channels * weight * pair.weight / total);
    context.terms.push_back({{pair.a, pair.b}, {scale, -scale}, {}, false, false});
  }
}

void AddEnvironmentSmoothness(const Context& context, const ParameterGroup& group, double weight) {
  const auto& light = context.scene.emitters[static_cast<std::size_t>(group.object)].light;
  const auto& environment = std::get<renderer::EnvironmentEmitter>(light);
  const int width = environment.width;
  const int height = environment.height;
  const auto block = [&](int x, int y) { return group.first_block + y * width + x % width; };
  const auto cosine = [&](double row) {  // of the latitude of a row's centre
    return std::sin(std::numbers::pi * row / static_cast<double>(height));
  };
  std::vector<BlockPair> pairs;
  for (int y = 0; y < height; ++y) {
    const int columns = width > 2 ? width : width - 1;  // two columns are one pair, not two
    for (int x = 0; x < columns; ++x) {
      pairs.push_back({block(x, y), block(x + 1, y), cosine(y + 0.5)});
    }
    for (int x = 0; x < width && y + 1 < height; ++x) {
      pairs.push_back({block(x, y), block(x, y + 1), cosine(y + 1.0)});
    }
  }
  AddDifferences(context, pairs, weight);
}

// The last of two or more is next to the first where the texture repeats; two are one pair.
int NumPairs(int count, bool repeats) { return repeats && count > 2 ? count : count - 1; }

void AddTextureSmoothness(const Context& context, const ParameterGroup& group, double weight) {
  const renderer::Texture& texture = context.scene.textures[static_cast<std::size_t>(group.object)];
  const bool repeats = texture.wrap == renderer::TextureWrap::kRepeat;
  const auto block = [&](int x, int y) {
    return group.first_block + y % texture.height * texture.width + x % texture.width;
  };
  std::vector<BlockPair> pairs;
  for (int y = 0; y < texture.height; ++y) {
    for (int x = 0; x < NumPairs(texture.width, repeats); ++x) {
      pairs.push_back({block(x, y), block(x + 1, y), 1.0});
    }
  }
  for (int y = 0; y < NumPairs(texture.height, repeats); ++y) {
    for (int x = 0; x < texture.width; ++x) {
      pairs.push_back({block(x, y), block(x, y + 1), 1.0});
    }
  }
  AddDifferences(context, pairs, weight);
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
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<BlockPair> pairs;
  pairs.reserve(edges.size());
  for (const auto& edge : edges) {
    pairs.push_back({group.first_block + edge[0], group.first_block + edge[1], 1.0});
  }
  AddDifferences(context, pairs, weight);
}

void AddNeutral(const Context& context, const ParameterGroup& group, double weight) {
  const double scale =
      std::sqrt(context.num_channels * weight / static_cast<double>(group.num_blocks));
  for (std::int32_t i = 0; i < group.num_blocks; ++i) {
    context.terms.push_back({{group.first_block + i}, {scale}, {}, false, true});
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
    PriorTerm term{{group.first_block + i}, {scale}, {}, false, false};
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
  const double scale = kGaussianResidual / (exposure.sigma_ev * std::log(2.0));
  const double start = exposure.start_gains[static_cast<std::size_t>(group.object)];
  context.terms.push_back(
      {{group.first_block}, {scale}, {scale * std::log(start), 0.0, 0.0}, true, false});
}

class PriorCostFunction : public ceres::CostFunction {
 public:
  PriorCostFunction(const PriorTerm& term, const ParameterSet& set) : term_(term), set_(set) {
    set_num_residuals(set.BlockSize(term.blocks.front()));
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

}  // namespace

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
    if (group.kind == ParameterKind::kVertexPositions && unknown.laplacian_weight > 0.0) {
      AddLaplacian(context, group, unknown.laplacian_weight);
    }
    if (group.kind == ParameterKind::kEnvironmentTexels && unknown.smooth_weight > 0.0) {
      AddEnvironmentSmoothness(context, group, unknown.smooth_weight);
    }
    if (group.kind == ParameterKind::kTextureTexels && unknown.smooth_weight > 0.0) {
      AddTextureSmoothness(context, group, unknown.smooth_weight);
    }
    if (group.kind == ParameterKind::kVertexColors && unknown.smooth_weight > 0.0) {
      AddColorSmoothness(context, group, unknown.smooth_weight);
    }
    if (group.kind == ParameterKind::kEnvironmentTexels && unknown.neutral_weight > 0.0) {
      AddNeutral(context, group, unknown.neutral_weight);
    }
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
    if (group.kind != ParameterKind::kVertexPositions || lambda <= 0.0) {
      continue;
    }
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
  for (std::size_t c = 0; c < size; ++c) {
    residual[c] = -term.offset[c];
  }
  for (std::size_t k = 0; k < term.blocks.size(); ++k) {
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
    for (std::size_t c = 0; c < size; ++c) {
      residual[c] += term.weights[k] * (term.neutral ? y[c] - mean : y[c]);
    }
    if (jacobians == nullptr || jacobians[k] == nullptr) {
      continue;
    }
    for (std::size_t row = 0; row < size; ++row) {
      for (std::size_t c = 0; c < size; ++c) {
        double d = row == c ? 1.0 : 0.0;
        if (term.neutral) {
          d -= 1.0 / static_cast<double>(size);
        }
        jacobians[k][row * size + c] = term.weights[k] * d * slope[c];
      }
    }
  }
}

std::unique_ptr<ceres::CostFunction> MakePriorCostFunction(const PriorTerm& term,
                                                           const ParameterSet& set) {
  return std::make_unique<PriorCostFunction>(term, set);
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
    std::array<double, 3> residual{};
    EvalPrior(term, set, blocks.data(), residual.data(), nullptr);
    for (const double r : residual) {
      sum += 0.5 * r * r;
    }
  }
  return sum;
}

}  // namespace pathfit::optim
