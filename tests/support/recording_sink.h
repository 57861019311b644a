#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "renderer/derivative/derivative_sink.h"

namespace pathfit::tests {

/// Keeps every entry of every pixel, in the order of arrival at that pixel.
class RecordingSink : public renderer::DerivativeSink {
 public:
  explicit RecordingSink(std::size_t num_pixels) : pixels(num_pixels) {}
  void Add(std::int64_t pixel,
           std::span<const renderer::ParameterDerivative> derivatives) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    auto& list = pixels[static_cast<std::size_t>(pixel)];
    list.insert(list.end(), derivatives.begin(), derivatives.end());
  }

  std::vector<std::vector<renderer::ParameterDerivative>> pixels;

 private:
  std::mutex mutex_;
};

}  // namespace pathfit::tests
