#include "optim/observation/shading.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>

#include <Eigen/Dense>

#include "renderer/core/error.h"
#include "renderer/io/image_filter.h"
#include "renderer/math/median.h"

namespace pathfit::optim {
namespace {

using renderer::Image;
using renderer::Vec2;
using renderer::Vec3;
using SymmetricSolver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

constexpr float kWhole = 0.99F;   // of a mask's white: no part of the pixel is outside
constexpr double kDarkest = 0.2;  // of a pixel's median value: less is shadow
constexpr std::size_t kFewestPixels = 50;
constexpr double kLeastInverse = 1e-3;  // smallest over largest of strengths that can be
// Of the two sets of strengths that fit best, what is left by the second over what is by the first,
// and its share of what is by all.
constexpr double kClearGap = 3.0;
constexpr double kLeastGap = 1e-5;
constexpr double kRim = 3.0;         // pixels from the border of the mask
constexpr double kLeastSpan = 1e-3;  // rms of the directions along the least of all axes

/// A pixel's values by photo.
struct Pixel {
  int x = 0, y = 0;
  Eigen::VectorXd values;
};

/// Those of the mask that are not black.
std::vector<Pixel> PixelsOf(const std::vector<Image>& photos, const Image& mask) {
  std::vector<Pixel> pixels;
  const float least = kWhole * *std::ranges::max_element(mask.data);
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      if (!(mask.At(x, y, 0) >= least && least > 0.0F)) continue;
      Pixel pixel{x, y, Eigen::VectorXd(static_cast<Eigen::Index>(photos.size()))};
      std::vector<double> values;
      for (const Image& photo : photos) values.push_back(renderer::MeanOfChannels(photo, x, y));
      std::ranges::copy(values, pixel.values.begin());
      if (renderer::Median(values) > 0.0) pixels.push_back(std::move(pixel));
    }
  }
  return pixels;
}

/// Those that no photo shows in shadow; all if these are too few.
std::vector<Pixel> LitPixels(const std::vector<Pixel>& all) {
  std::vector<Pixel> lit;
  std::ranges::copy_if(all, std::back_inserter(lit), [](const Pixel& pixel) {
    std::vector<double> values(pixel.values.begin(), pixel.values.end());
    return pixel.values.minCoeff() > kDarkest * renderer::Median(values);
  });
  return lit.size() >= kFewestPixels ? lit : all;
}

/// Strengths by which all pixels' values are shades of some normals: values over strengths lie in
/// the space of the directions' columns, so what of them lies outside is least for the inverse
/// strengths. Empty where they are not told: other strengths would do nearly as well.
std::optional<Eigen::VectorXd> FindStrengths(const std::vector<Pixel>& pixels,
                                             const Eigen::MatrixX3d& lamps) {
  const Eigen::Index count = lamps.rows();
  const Eigen::MatrixXd outside = Eigen::MatrixXd::Identity(count, count) -
                                  lamps * (lamps.transpose() * lamps).inverse() * lamps.transpose();
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(count, count);
  for (const Pixel& pixel : pixels) {
    products += pixel.values * pixel.values.transpose() / pixel.values.squaredNorm();
  }
  const SymmetricSolver solver(outside.cwiseProduct(products));
  Eigen::VectorXd inverse = solver.eigenvectors().col(0);
  if (inverse.sum() < 0.0) inverse = -inverse;
  const Eigen::VectorXd& values = solver.eigenvalues();
  const bool is_told = count > 3 && inverse.minCoeff() > kLeastInverse * inverse.maxCoeff() &&
                       values(1) > kClearGap * values(0) && values(1) > kLeastGap * values.sum();
  if (!is_told) return std::nullopt;
  return inverse.cwiseInverse();
}

/// Medians of what a surface that faces the viewer would show.
Eigen::VectorXd FacingStrengths(const std::vector<Pixel>& pixels, const Eigen::MatrixX3d& lamps) {
  Eigen::VectorXd strengths(lamps.rows());
  for (Eigen::Index k = 0; k < lamps.rows(); ++k) {
    std::vector<double> values;
    for (const Pixel& pixel : pixels) values.push_back(pixel.values(k));
    strengths(k) = std::max(1e-6, renderer::Median(values) / std::max(0.1, lamps(k, 2)));
  }
  return strengths;
}

/// Unit vectors out of the mask, by pixels near its border; zero elsewhere.
Vec2 WayOut(const Image& distance, int x, int y) {
  if (x == 0 || y == 0 || x + 1 == distance.width || y + 1 == distance.height) return {};
  if (static_cast<double>(distance.At(x, y, 0)) > kRim) return {};
  const Vec2 out{
      static_cast<double>(distance.At(x - 1, y, 0)) - static_cast<double>(distance.At(x + 1, y, 0)),
      static_cast<double>(distance.At(x, y + 1, 0)) -
          static_cast<double>(distance.At(x, y - 1, 0))};
  const double length = std::hypot(out.x, out.y);
  return length > 0.0 ? Vec2{out.x / length, out.y / length} : Vec2{};
}

/// By sums of products.
double Correlation(double ab, double aa, double bb) {
  return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
}

void FitOutward(const std::vector<Pixel>& pixels,
                const Eigen::Matrix3Xd& inverse,
                const Image& mask,
                ShadingFit& fit) {
  const Image distance = renderer::SignedDistanceToMask(mask);
  Vec2 ab, aa, bb;
  std::size_t count = 0;
  for (const Pixel& pixel : pixels) {
    const Vec2 out = WayOut(distance, pixel.x, pixel.y);
    if (out.x == 0.0 && out.y == 0.0) continue;
    const Eigen::Vector3d n = (inverse * pixel.values).normalized();
    ab = ab + Vec2{n.x() * out.x, n.y() * out.y};
    aa = aa + Vec2{n.x() * n.x(), n.y() * n.y()};
    bb = bb + Vec2{out.x * out.x, out.y * out.y};
    ++count;
  }
  fit.outward = {Correlation(ab.x, aa.x, bb.x), Correlation(ab.y, aa.y, bb.y)};
  fit.has_rim = count >= kFewestPixels;
}

}  // namespace

ShadingFit FitShading(const std::vector<Image>& photos,
                      const Image& mask,
                      const std::vector<Vec3>& towards,
                      const std::vector<double>& strengths) {
  const bool same_sizes = std::ranges::all_of(photos, [&](const Image& photo) {
    return photo.width == mask.width && photo.height == mask.height;
  });
  if (!same_sizes || mask.Empty()) {
    throw renderer::SceneError("photos and mask differ in size, or there is no mask");
  }
  const auto count = static_cast<Eigen::Index>(photos.size());
  Eigen::MatrixX3d lamps(count, 3);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Vec3& l = towards[static_cast<std::size_t>(k)];
    lamps.row(k) << l.x, l.y, l.z;
  }
  const Eigen::MatrixXd moments = lamps.transpose() * lamps / static_cast<double>(count);
  if (count < 3 || SymmetricSolver(moments).eigenvalues()(0) < kLeastSpan * kLeastSpan) {
    throw renderer::SceneError(
        "shading tells shape by three photos or more whose lamps do not lie in one plane");
  }
  const std::vector<Pixel> all = PixelsOf(photos, mask);
  if (all.size() < kFewestPixels) {
    throw renderer::SceneError(
        "the photos are black inside the mask, or the mask is all but empty");
  }
  const std::vector<Pixel> lit = LitPixels(all);
  ShadingFit fit;
  Eigen::VectorXd power;
  if (!strengths.empty()) {
    power = Eigen::Map<const Eigen::VectorXd>(strengths.data(), count);
  } else if (const auto found = FindStrengths(lit, lamps)) {
    power = *found;
  } else {
    fit.strengths_told = false;
    power = FacingStrengths(lit, lamps);
  }
  power /= power.mean();
  const Eigen::MatrixX3d shades = power.asDiagonal() * lamps;
  const Eigen::Matrix3Xd inverse = (shades.transpose() * shades).inverse() * shades.transpose();

  fit.strengths.assign(power.begin(), power.end());
  std::vector<double> brightness;
  double left = 0.0, sum = 0.0;
  for (const Pixel& pixel : lit) {
    const Eigen::Vector3d normal = inverse * pixel.values;
    brightness.push_back(normal.norm());
    left += (pixel.values - shades * normal).squaredNorm();
    sum += pixel.values.squaredNorm();
  }
  fit.brightness = renderer::Median(brightness);
  fit.residual = std::sqrt(left / sum);
  FitOutward(all, inverse, mask, fit);
  return fit;
}

}  // namespace pathfit::optim
