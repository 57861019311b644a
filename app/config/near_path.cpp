#include "app/config/near_path.h"

#include <algorithm>
#include <iterator>

namespace pathfit::app {

namespace fs = std::filesystem;

fs::path NearPath(const fs::path& path, const fs::path& folder) {
  fs::path from = folder.lexically_normal();
  if (!from.has_filename()) from = from.parent_path();  // a slash at the end
  const fs::path relative = path.lexically_normal().lexically_relative(from);
  const auto up = std::ranges::count(relative, fs::path(".."));
  const auto depth = std::distance(from.begin(), from.end()) - 1;  // without the root
  return !relative.empty() && up < depth ? relative : path;
}

}  // namespace pathfit::app
