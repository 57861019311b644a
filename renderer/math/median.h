#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace pathfit::renderer {

/// Of at least one value, which it reorders: the middle one, or the mean of the two middle ones.
inline double Median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return values.size() % 2 == 1 ? *middle
                                : 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

}  // namespace pathfit::renderer
