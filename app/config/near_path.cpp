#include "app/config/near_path.h"

#include <algorithm>
#include <iterator>
#include <system_error>

namespace pathfit::app {

namespace fs = std::filesystem;

namespace {

/// By the names alone; empty where only the root is above both.
fs::path Relative(const fs::path& path, const fs::path& folder) {
  fs::path from = folder.lexically_normal();
  if (!from.has_filename()) from = from.parent_path();  // a slash at the end
  const fs::path relative = path.lexically_normal().lexically_relative(from);
  const auto up = std::ranges::count(relative, fs::path(".."));
  const auto depth = std::distance(from.begin(), from.end()) - 1;  // without the root
  return up < depth ? relative : fs::path();
}

/// False where both can be seen and are not the same.
bool LeadsTo(const fs::path& path, const fs::path& folder, const fs::path& relative) {
  std::error_code error;
  if (!fs::exists(path, error) || !fs::exists(folder, error)) return true;
  return fs::equivalent(folder / relative, path, error);
}

}  // namespace

fs::path NearPath(const fs::path& path, const fs::path& from) {
  const fs::path folder = fs::absolute(from);
  fs::path relative = Relative(path, folder);
  if (relative.empty() || LeadsTo(path, folder, relative))
    return relative.empty() ? path : relative;
  std::error_code error;
  const fs::path real_folder = fs::canonical(folder, error);
  const fs::path real_parent = fs::canonical(path.parent_path(), error);
  relative = Relative(real_parent / path.filename(), real_folder);
  return !relative.empty() && LeadsTo(path, folder, relative) ? relative : path;
}

}  // namespace pathfit::app
