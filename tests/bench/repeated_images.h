#pragma once

#include <filesystem>
#include <vector>

#include "renderer/image/image.h"

namespace pathfit::bench {

/// Independent images of the same thing: their mean, and how much one of them varies.
class RepeatedImages {
 public:
  void Add(const renderer::Film& film);
  /// (b - a) / step, pixel by pixel.
  void AddDifference(const renderer::Film& a, const renderer::Film& b, double step);

  [[nodiscard]] int Count() const { return static_cast<int>(images_.size()); }
  /// Variance of a pixel and channel of one image, averaged over the image. Needs two images.
  [[nodiscard]] double MeanVariance() const;
  /// Mean of the squares of the expected image, the noise taken off.
  [[nodiscard]] double MeanSquare() const;
  [[nodiscard]] renderer::Image Mean() const;
  /// Variance of the mean.
  [[nodiscard]] renderer::Image VarianceOfMean() const;

  /// Agreement of the mean with another estimate of the same image, in blocks of kBlock x kBlock
  /// pixels: single pixels of a reference are often unlucky enough to have no variance at all. The
  /// grid is half a block off the film's corner: an edge that stands on a pixel's border, as at the
  /// middle of a film, has its difference quotient in two pixels and its derivative in one.
  struct Agreement {
    double z_rms = 0.0, z_mean = 0.0;  ///< over blocks and channels; 1 and 0 are expected
    double z_total = 0.0;              ///< of the sum over the whole image and all channels
    double relative_l2 = 0.0;          ///< of the blocks' differences, noise included
    double noise_l2 = 0.0;             ///< what relative_l2 is expected to be if both are right
    double relative_total = 0.0;  ///< difference of the sums over the image, over the reference
    int num_blocks = 0;           ///< blocks and channels with any variance
  };
  [[nodiscard]] Agreement CompareWith(const renderer::Image& mean,
                                      const renderer::Image& variance_of_mean) const;

  static constexpr int kBlock = 4;

 private:
  void Add(int width, int height, std::vector<double> values);
  /// Mean and unbiased variance of one number across the images.
  struct Moments {
    double mean = 0.0, variance = 0.0;
  };
  template <class Value>
  [[nodiscard]] Moments MomentsOf(Value value) const;

  int width_ = 0, height_ = 0;
  std::vector<std::vector<double>> images_;  // 3 channels
};

struct ReferenceImage {
  renderer::Image mean;
  renderer::Image variance_of_mean;  ///< zero if not known
  bool has_variance = false;

  /// Mean of the squares, the noise taken off.
  [[nodiscard]] double MeanSquare() const;
};
/// STEM.exr and, if there, STEM_variance.exr of a folder. Fails: IoError.
ReferenceImage ReadReference(const std::filesystem::path& folder, const std::string& stem);

}  // namespace pathfit::bench
