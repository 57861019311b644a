#include "tests/bench/repeated_images.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "renderer/core/check.h"
#include "renderer/io/exr_file.h"

namespace pathfit::bench {

using renderer::Film;
using renderer::Image;

template <class Value>
RepeatedImages::Moments RepeatedImages::MomentsOf(Value value) const {
  const auto count = static_cast<double>(images_.size());
  Moments m;
  for (const auto& image : images_) {
    m.mean += value(image) / count;
  }
  for (const auto& image : images_) {
    const double deviation = value(image) - m.mean;
    m.variance += deviation * deviation / (count - 1.0);
  }
  return m;
}

void RepeatedImages::Add(int width, int height, std::vector<double> values) {
  PATHFIT_CHECK(images_.empty() || (width == width_ && height == height_));
  width_ = width;
  height_ = height;
  images_.push_back(std::move(values));
}

void RepeatedImages::Add(const Film& film) {
  std::vector<double> values;
  values.reserve(3 * film.pixels.size());
  for (const renderer::Rgba& pixel : film.pixels) {
    values.insert(values.end(), {pixel.r, pixel.g, pixel.b});
  }
  Add(film.width, film.height, std::move(values));
}

void RepeatedImages::AddDifference(const Film& a, const Film& b, double step) {
  Film difference(a.width, a.height);
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    difference.pixels[i] = (b.pixels[i] - a.pixels[i]) * (1.0 / step);
  }
  Add(difference);
}

double RepeatedImages::MeanVariance() const {
  const std::size_t size = images_.front().size();
  double sum = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    sum += MomentsOf([i](const auto& image) { return image[i]; }).variance;
  }
  return sum / static_cast<double>(size);
}

double RepeatedImages::MeanSquare() const {
  const std::size_t size = images_.front().size();
  double sum = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    const Moments m = MomentsOf([i](const auto& image) { return image[i]; });
    sum += m.mean * m.mean - m.variance / Count();
  }
  return sum / static_cast<double>(size);
}

Image RepeatedImages::Mean() const {
  Image out(width_, height_, 3);
  for (std::size_t i = 0; i < out.data.size(); ++i) {
    out.data[i] = static_cast<float>(MomentsOf([i](const auto& image) { return image[i]; }).mean);
  }
  return out;
}

Image RepeatedImages::VarianceOfMean() const {
  Image out(width_, height_, 3);
  for (std::size_t i = 0; i < out.data.size(); ++i) {
    const Moments m = MomentsOf([i](const auto& image) { return image[i]; });
    out.data[i] = static_cast<float>(m.variance / Count());
  }
  return out;
}

RepeatedImages::Agreement RepeatedImages::CompareWith(const Image& mean,
                                                      const Image& variance_of_mean) const {
  PATHFIT_CHECK(mean.width == width_ && mean.height == height_ && mean.channels == 3);
  Agreement result;
  double total = 0.0;
  double total_variance = 0.0;
  double total_reference = 0.0;
  double difference2 = 0.0;
  double noise2 = 0.0;
  double reference2 = 0.0;
  for (int y0 = -kBlock / 2; y0 < height_; y0 += kBlock) {
    for (int x0 = -kBlock / 2; x0 < width_; x0 += kBlock) {
      for (int c = 0; c < 3; ++c) {
        const auto sum_over_block = [&](const auto& values) {
          double sum = 0.0;
          for (int y = std::max(y0, 0); y < std::min(y0 + kBlock, height_); ++y) {
            for (int x = std::max(x0, 0); x < std::min(x0 + kBlock, width_); ++x) {
              sum += static_cast<double>(values[mean.Offset(x, y) + static_cast<std::size_t>(c)]);
            }
          }
          return sum;
        };
        const Moments ours = MomentsOf(sum_over_block);
        const double reference = sum_over_block(mean.data);
        const double difference = ours.mean - reference;
        const double variance = ours.variance / Count() + sum_over_block(variance_of_mean.data);
        total += difference;
        total_reference += reference;
        total_variance += variance;
        difference2 += difference * difference;
        noise2 += variance;
        reference2 += reference * reference;
        if (variance > 0.0) {
          const double z = difference / std::sqrt(variance);
          result.z_rms += z * z;
          result.z_mean += z;
          ++result.num_blocks;
        }
      }
    }
  }
  const double count = std::max(1, result.num_blocks);
  result.z_rms = std::sqrt(result.z_rms / count);
  result.z_mean /= count;
  result.z_total = total_variance > 0.0 ? total / std::sqrt(total_variance) : 0.0;
  result.relative_total = total / total_reference;
  result.relative_l2 = std::sqrt(difference2 / reference2);
  result.noise_l2 = std::sqrt(noise2 / reference2);
  return result;
}

double ReferenceImage::MeanSquare() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < mean.data.size(); ++i) {
    const auto value = static_cast<double>(mean.data[i]);
    sum += value * value - static_cast<double>(variance_of_mean.data[i]);
  }
  return sum / static_cast<double>(mean.data.size());
}

ReferenceImage ReadReference(const std::filesystem::path& folder, const std::string& stem) {
  ReferenceImage reference;
  reference.mean = renderer::ReadExr(folder / (stem + ".exr"));
  const std::filesystem::path variance = folder / (stem + "_variance.exr");
  reference.has_variance = std::filesystem::exists(variance);
  reference.variance_of_mean = reference.has_variance
                                   ? renderer::ReadExr(variance)
                                   : Image(reference.mean.width, reference.mean.height, 3);
  return reference;
}

}  // namespace pathfit::bench
