#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace pathfit::renderer {

/// 0 to count - 1.
inline std::vector<int> AllIndices(std::size_t count) {
  std::vector<int> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

}  // namespace pathfit::renderer
