#include "renderer/emitter/area_sampler.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <span>
#include <tuple>

#include "renderer/core/check.h"
#include "renderer/geometry/triangle_kernel.h"
#include "renderer/math/frame.h"

namespace pathfit::renderer {
namespace {

// Share of the samples that goes to the triangles by area alone, whatever their brightness.
constexpr double kAreaFloor = 0.1;
// Normals of a leaf lie within this cosine of their mean.
constexpr double kFlat = 0.94;
// Closed meshes whose mean cross-section fills the one of their sphere so far are seen as it.
constexpr double kFilled = 0.75;
constexpr double kClosed = 1e-3;   // largest mean normal of a closed mesh
constexpr double kEven = 1.5;      // greatest over least brightness
constexpr double kOutside = 1.02;  // squared distance over radius from which directions are drawn
// Share of the samples in a cone that is spread evenly over the sphere's face: derivatives by its
// place go with one over the cosine there.
constexpr double kLimbShare = 0.25;
constexpr double kLeastCosine = 1e-6;
// What a difference of normals by one is worth when a range is split, in units of its extent.
constexpr double kNormalScale = 0.25;
// E|z| of n.w is the root of E(z)^2 + this Var(z): right for normals all over a sphere.
constexpr double kSpreadShare = 0.75;
// Variance of n.w by the places on a disk, in units of its squared angle.
constexpr double kParallax = 0.25;

/// The directions from which a sphere is seen. With t the share of the cone's solid angle inside a
/// direction, m = sqrt(1 - t) is the cosine on the sphere of what is seen there from afar.
class Cone {
 public:
  Cone(const Vec3& to_center, double squared_radius) {
    const double squared = SquaredNorm(to_center);
    const double sine2 = squared_radius / squared;
    axis_ = to_center * (1.0 / std::sqrt(squared));
    height_ = sine2 / (1.0 + std::sqrt(1.0 - sine2));
  }

  [[nodiscard]] Vec3 Sample(double u0, double u1, double& pdf) const {
    // (1 - t) (1 - share) + share m = 1 - u0.
    const double inner = 1.0 - kLimbShare;
    const double root = std::sqrt(kLimbShare * kLimbShare + 4.0 * inner * (1.0 - u0));
    const double m = (root - kLimbShare) / (2.0 * inner);
    const double height = (1.0 - m * m) * height_;
    const double radius = std::sqrt(std::max(height * (2.0 - height), 0.0));
    const double angle = 2.0 * std::numbers::pi * u1;
    pdf = PdfAt(m);
    return Frame::FromNormal(axis_).ToWorld(
        {radius * std::cos(angle), radius * std::sin(angle), 1.0 - height});
  }
  [[nodiscard]] double Pdf(const Vec3& w) const {
    // 1 - cos of the angle, without cancellation.
    const double height = 0.5 * SquaredNorm(w - axis_);
    return PdfAt(std::sqrt(std::max(1.0 - height / height_, 0.0)));
  }

 private:
  [[nodiscard]] double PdfAt(double m) const {
    const double density = 1.0 - kLimbShare + 0.5 * kLimbShare / std::max(m, kLeastCosine);
    return density / (2.0 * std::numbers::pi * height_);
  }

  Vec3 axis_;
  double height_ = 0.0;  // 1 - cos of the cone's angle
};

}  // namespace

void AreaSampler::AddMesh(int mesh,
                          const Mesh& world,
                          const std::vector<double>& brightness,
                          bool two_sided) {
  PATHFIT_CHECK(mesh >= 0 && brightness.size() == world.triangles.size());
  const auto index = static_cast<std::size_t>(mesh);
  if (source_of_.size() <= index) {
    source_of_.resize(index + 1);
  }
  PATHFIT_CHECK(source_of_[index].empty());
  source_of_[index].resize(world.triangles.size());
  for (std::size_t i = 0; i < world.triangles.size(); ++i) {
    const auto corner = [&](std::size_t k) {
      return world.positions[static_cast<std::size_t>(world.triangles[i][k])];
    };
    const TriangleGeometry triangle = TriangleGeometry::Make(corner(0), corner(1), corner(2));
    Source source;
    source.id = {mesh, static_cast<std::int32_t>(i)};
    source.corners = {corner(0), corner(1), corner(2)};
    source.normal = triangle.n;
    source.area = triangle.double_area > 0.0 ? 0.5 * triangle.double_area : 0.0;
    source.weight = source.area * std::max(brightness[i], 0.0);
    source.two_sided = two_sided;
    sources_.push_back(source);
  }
}

void AreaSampler::Finish() {
  double total_area = 0.0;
  double total_weight = 0.0;
  for (const Source& source : sources_) {
    total_area += source.area;
    total_weight += source.weight;
  }
  if (!(total_area > 0.0)) {
    sources_.clear();
    source_of_.clear();
    return;
  }
  const double floor =
      total_weight > 0.0 ? kAreaFloor / (1.0 - kAreaFloor) * total_weight / total_area : 1.0;
  for (Source& source : sources_) {
    source.weight += floor * source.area;
  }
  const auto end = std::stable_partition(
      sources_.begin(), sources_.end(), [](const Source& source) { return source.area > 0.0; });
  nodes_.push_back(Bound(0, static_cast<std::int32_t>(end - sources_.begin()), true));
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Node node = nodes_[n];
    const bool is_leaf =
        node.end - node.first == 1 || node.is_compact || (node.is_flat && !node.several_meshes);
    if (is_leaf) {
      continue;
    }
    const std::int32_t cut = Split(node);
    nodes_[n].child = static_cast<std::int32_t>(nodes_.size());
    for (Node child :
         {Bound(node.first, cut, node.several_meshes), Bound(cut, node.end, node.several_meshes)}) {
      child.parent = static_cast<std::int32_t>(n);
      nodes_.push_back(child);
    }
  }
  std::vector<double> weights;
  for (const Source& source : sources_) {
    weights.push_back(source.weight);
  }
  distribution_ = Distribution1D(weights);
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Node& node = nodes_[n];
    for (std::int32_t i = node.first; node.child < 0 && i < node.end; ++i) {
      Source& source = sources_[static_cast<std::size_t>(i)];
      source.leaf = static_cast<std::int32_t>(n);
      source.pdf = distribution_.Probability(i) / source.area;
      source.pdf_in_leaf = source.weight / node.weight / source.area;
    }
  }
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    const TriangleId id = sources_[i].id;
    source_of_[static_cast<std::size_t>(id.mesh)][static_cast<std::size_t>(id.triangle)] =
        static_cast<std::int32_t>(i);
  }
}

AreaSampler::Node AreaSampler::Bound(std::int32_t first, std::int32_t end, bool is_whole) const {
  const auto range = std::span(sources_).subspan(static_cast<std::size_t>(first),
                                                 static_cast<std::size_t>(end - first));
  Node node;
  node.first = first;
  node.end = end;
  Vec3 low = range.front().corners[0];
  Vec3 high = low;
  double area = 0.0;
  double darkest = std::numeric_limits<double>::infinity();
  double brightest = 0.0;
  for (const Source& source : range) {
    for (const Vec3& corner : source.corners) {
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], corner[k]);
        high[k] = std::max(high[k], corner[k]);
      }
    }
    const Vec3& n = source.normal;
    area += source.area;
    darkest = std::min(darkest, source.weight / source.area);
    brightest = std::max(brightest, source.weight / source.area);
    node.several_meshes = node.several_meshes || source.id.mesh != range.front().id.mesh;
    node.weight += source.weight;
    node.mean += n * source.weight;
    node.diagonal += Vec3{n.x * n.x, n.y * n.y, n.z * n.z} * source.weight;
    node.mixed += Vec3{n.x * n.y, n.x * n.z, n.y * n.z} * (2.0 * source.weight);
    node.two_sided = node.two_sided || source.two_sided;
  }
  for (Vec3* moment : {&node.mean, &node.diagonal, &node.mixed}) {
    *moment = *moment * (1.0 / node.weight);
  }
  node.center = (low + high) * 0.5;
  const double norm = Norm(node.mean);
  node.is_flat = norm >= kFlat;
  for (const Source& source : range) {
    for (const Vec3& corner : source.corners) {
      node.squared_radius = std::max(node.squared_radius, SquaredNorm(corner - node.center));
    }
    node.is_flat = node.is_flat && Dot(node.mean, source.normal) >= kFlat * norm;
  }
  node.is_compact = is_whole && !node.several_meshes && darkest * kEven >= brightest &&
                    norm < kClosed &&
                    0.25 * area >= kFilled * std::numbers::pi * node.squared_radius;
  return node;
}

std::int32_t AreaSampler::Split(const Node& node) {
  const auto begin = sources_.begin() + node.first;
  const auto end = sources_.begin() + node.end;
  // Meshes are parted from each other before they are cut.
  std::map<int, std::array<double, 7>> by_mesh;
  const double scale = kNormalScale * 2.0 * std::sqrt(node.squared_radius);
  const auto own_place = [&](const Source& source, std::size_t axis) {
    const int k = static_cast<int>(axis % 3);
    return axis < 3 ? (source.corners[0][k] + source.corners[1][k] + source.corners[2][k]) / 3.0
                    : scale * source.normal[k];
  };
  for (auto it = begin; node.several_meshes && it != end; ++it) {
    auto& sums = by_mesh[it->id.mesh];
    for (std::size_t axis = 0; axis < 6; ++axis) {
      sums[axis] += it->area * own_place(*it, axis);
    }
    sums[6] += it->area;
  }
  const auto place = [&](const Source& source, std::size_t axis) {
    if (!node.several_meshes) {
      return own_place(source, axis);
    }
    const auto& sums = by_mesh.at(source.id.mesh);
    return sums[axis] / sums[6];
  };
  std::size_t widest = 0;
  double widest_extent = -1.0;
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const auto [low, high] = std::minmax_element(
        begin, end, [&](const auto& a, const auto& b) { return place(a, axis) < place(b, axis); });
    const double extent = place(*high, axis) - place(*low, axis);
    if (extent > widest_extent) {
      widest = axis;
      widest_extent = extent;
    }
  }
  const auto before = [&](const Source& a, const Source& b) {
    const double place_a = place(a, widest);
    const double place_b = place(b, widest);
    return place_a != place_b
               ? place_a < place_b
               : std::tie(a.id.mesh, a.id.triangle) < std::tie(b.id.mesh, b.id.triangle);
  };
  auto cut = begin + (node.end - node.first) / 2;
  if (!node.several_meshes) {
    std::nth_element(begin, cut, end, before);
  } else {
    std::sort(begin, end, before);
    const auto other = [&](const Source& source) { return source.id.mesh != cut->id.mesh; };
    const auto next = std::find_if(cut, end, other);
    const auto first =
        std::find_if(std::make_reverse_iterator(cut), std::make_reverse_iterator(begin), other)
            .base();
    cut = next != end && (first == begin || next - cut < cut - first) ? next : first;
  }
  return static_cast<std::int32_t>(cut - sources_.begin());
}

/// Estimate of what reaches x, up to a factor. The part of the normals that faces w has the mean
/// (E(n.w) + E|n.w|) / 2. The nearer x is, the less it sees all of them from one side.
double AreaSampler::Importance(const Node& node, const Vec3& x) {
  const Vec3 away = x - node.center;
  const double squared = std::max(SquaredNorm(away), node.squared_radius);
  const double near = node.squared_radius / squared;
  const double inverse = 1.0 / squared;
  const double square = (Dot(node.diagonal, {away.x * away.x, away.y * away.y, away.z * away.z}) +
                         Dot(node.mixed, {away.x * away.y, away.x * away.z, away.y * away.z})) *
                        inverse;
  const double mean = Dot(node.mean, away) * std::sqrt(inverse * (1.0 - near));
  const double spread = std::max(square - mean * mean, 0.0) + kParallax * near;
  const double both = std::sqrt(mean * mean + kSpreadShare * spread);
  return (node.two_sided ? both : 0.5 * (both + mean)) * node.weight * inverse;
}

std::optional<double> AreaSampler::ShareOfFirst(const Node* siblings, const Vec3& x) {
  const double first = Importance(siblings[0], x);
  const double both = first + Importance(siblings[1], x);
  return both > 0.0 ? std::optional(first / both) : std::nullopt;
}

AreaSample AreaSampler::SampleIn(const Node& node, double u0, double u1) const {
  double remainder = 0.0;
  const int index = distribution_.SampleWithin(node.first, node.end, u0, remainder);
  // The square is folded along its diagonal onto the triangle: uniform and continuous, so strata
  // of the square stay compact on the triangle.
  const double fold = 0.5 * std::min(remainder, u1);
  const double b1 = remainder - fold;
  const double b2 = u1 - fold;
  const Source& source = sources_[static_cast<std::size_t>(index)];
  return {source.id, b1, b2, source.pdf_in_leaf};
}

AreaSample AreaSampler::Sample(double u0, double u1) const {
  AreaSample sample = SampleIn(nodes_[0], u0, u1);
  sample.pdf = Pdf(sample.id);
  return sample;
}

bool AreaSampler::SeesCone(const Node& node, const Vec3& x) {
  return node.is_compact && SquaredNorm(node.center - x) > kOutside * node.squared_radius;
}

AreaChoice AreaSampler::SampleTowards(const Vec3& x, double u0, double u1) const {
  const Node* node = &nodes_[0];
  double probability = 1.0;
  while (node->child >= 0) {
    const Node* child = &nodes_[static_cast<std::size_t>(node->child)];
    const std::optional<double> share = ShareOfFirst(child, x);
    if (!share) {
      return {};
    }
    const bool goes_left = u0 < *share;
    u0 = goes_left ? u0 / *share : (u0 - *share) / (1.0 - *share);
    u0 = std::min(u0, 1.0 - 0x1.0p-53);
    probability *= goes_left ? *share : 1.0 - *share;
    node = goes_left ? child : child + 1;
  }
  AreaChoice choice;
  choice.mesh = sources_[static_cast<std::size_t>(node->first)].id.mesh;
  if (SeesCone(*node, x)) {
    const Cone cone(node->center - x, node->squared_radius);
    choice.direction = cone.Sample(u0, u1, choice.pdf);
    choice.pdf *= probability;
    return choice;
  }
  choice.point = SampleIn(*node, u0, u1);
  choice.point.pdf *= probability;
  return choice;
}

const AreaSampler::Source* AreaSampler::Find(TriangleId id) const {
  const auto mesh = static_cast<std::size_t>(id.mesh);
  if (id.mesh < 0 || mesh >= source_of_.size() || source_of_[mesh].empty()) {
    return nullptr;
  }
  return &sources_[static_cast<std::size_t>(
      source_of_[mesh][static_cast<std::size_t>(id.triangle)])];
}

double AreaSampler::Pdf(TriangleId id) const {
  const Source* source = Find(id);
  return source == nullptr ? 0.0 : source->pdf;
}

double AreaSampler::PdfTowards(const Vec3& x,
                               TriangleId id,
                               const Vec3& w,
                               double cosine_over_square) const {
  const Source* source = Find(id);
  if (source == nullptr || source->leaf < 0) {
    return 0.0;
  }
  std::int32_t at = source->leaf;
  const Node& leaf = nodes_[static_cast<std::size_t>(at)];
  double pdf = SeesCone(leaf, x)
                   ? Cone(leaf.center - x, leaf.squared_radius).Pdf(w) * cosine_over_square
                   : source->pdf_in_leaf;
  while (nodes_[static_cast<std::size_t>(at)].parent >= 0) {
    const std::int32_t parent = nodes_[static_cast<std::size_t>(at)].parent;
    const std::int32_t left = nodes_[static_cast<std::size_t>(parent)].child;
    const std::optional<double> share = ShareOfFirst(&nodes_[static_cast<std::size_t>(left)], x);
    if (!share) {
      return 0.0;
    }
    pdf *= at == left ? *share : 1.0 - *share;
    at = parent;
  }
  return pdf;
}

}  // namespace pathfit::renderer
