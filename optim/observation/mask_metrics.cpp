#include "optim/observation/mask_metrics.h"

#include <cstdint>

#include "renderer/core/check.h"

namespace pathfit::optim {

double MaskIou(const renderer::Image& coverage, const renderer::Image& mask) {
  PATHFIT_CHECK(coverage.width == mask.width && coverage.height == mask.height);
  PATHFIT_CHECK(coverage.channels == 1 && mask.channels == 1);
  std::int64_t both = 0;
  std::int64_t either = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    const bool rendered = coverage.data[i] > 0.5F;
    const bool masked = mask.data[i] > 0.5F;
    both += rendered && masked ? 1 : 0;
    either += rendered || masked ? 1 : 0;
  }
  return either == 0 ? 1.0 : static_cast<double>(both) / static_cast<double>(either);
}

}  // namespace pathfit::optim
