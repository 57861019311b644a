#include "renderer/image/similarity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace pathfit::renderer {
namespace {

constexpr int kRadius = 5;
constexpr double kSigma = 1.5;
constexpr double kMeanConstant = 1e-4;
constexpr double kVarianceConstant = 9e-4;

std::vector<double> GreyOf(const Image& image) {
  const auto channels = static_cast<std::size_t>(image.channels);
  std::vector<double> grey(image.data.size() / channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    grey[i / channels] += static_cast<double>(image.data[i]) / image.channels;
  }
  return grey;
}

std::array<double, 2 * kRadius + 1> Window() {
  std::array<double, 2 * kRadius + 1> window{};
  for (int i = -kRadius; i <= kRadius; ++i) {
    window[static_cast<std::size_t>(i + kRadius)] = std::exp(-i * i / (2.0 * kSigma * kSigma));
  }
  return window;
}

/// Sums of weight times moments over the windows, along one axis after the other.
std::vector<double> Blurred(std::vector<double> values, int width, int height) {
  static const std::array<double, 2 * kRadius + 1> kWindow = Window();
  for (const bool along_x : {true, false}) {
    std::vector<double> next(values.size());
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        double sum = 0.0;
        for (int i = -kRadius; i <= kRadius; ++i) {
          const int u = along_x ? x + i : x, v = along_x ? y : y + i;
          if (u < 0 || v < 0 || u >= width || v >= height) continue;
          sum += kWindow[static_cast<std::size_t>(i + kRadius)] *
                 values[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(u)];
        }
        next[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
             static_cast<std::size_t>(x)] = sum;
      }
    }
    values = std::move(next);
  }
  return values;
}

}  // namespace

double StructuralSimilarity(const Image& a, const Image& b, const Image& weight) {
  const std::vector<double> grey_a = GreyOf(a), grey_b = GreyOf(b);
  std::vector<double> w(grey_a.size(), 1.0);
  for (std::size_t i = 0; i < weight.data.size(); ++i) w[i] = static_cast<double>(weight.data[i]);
  const auto moment = [&](auto value) {
    std::vector<double> values(w.size());
    for (std::size_t i = 0; i < w.size(); ++i) values[i] = w[i] * value(grey_a[i], grey_b[i]);
    return Blurred(std::move(values), a.width, a.height);
  };
  const std::vector<double> norm = moment([](double, double) { return 1.0; });
  const std::vector<double> mean_a = moment([](double x, double) { return x; });
  const std::vector<double> mean_b = moment([](double, double y) { return y; });
  const std::vector<double> aa = moment([](double x, double) { return x * x; });
  const std::vector<double> bb = moment([](double, double y) { return y * y; });
  const std::vector<double> ab = moment([](double x, double y) { return x * y; });
  double sum = 0.0, total = 0.0;
  for (std::size_t i = 0; i < w.size(); ++i) {
    if (!(w[i] > 0.0)) continue;
    const double ma = mean_a[i] / norm[i], mb = mean_b[i] / norm[i];
    const double va = std::max(0.0, aa[i] / norm[i] - ma * ma);
    const double vb = std::max(0.0, bb[i] / norm[i] - mb * mb);
    const double covariance = ab[i] / norm[i] - ma * mb;
    sum += w[i] * (2.0 * ma * mb + kMeanConstant) * (2.0 * covariance + kVarianceConstant) /
           ((ma * ma + mb * mb + kMeanConstant) * (va + vb + kVarianceConstant));
    total += w[i];
  }
  return sum / total;  // 0 / 0 is NaN
}

}  // namespace pathfit::renderer
