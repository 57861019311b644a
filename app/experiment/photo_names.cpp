#include "app/experiment/photo_names.h"

#include <filesystem>

#include "app/config/nearest_name.h"

namespace pathfit::app {

bool PhotoNames::Matches(const std::string& pattern, std::size_t index) const {
  const std::string& name = names_[index];
  return pattern == name || MatchesGlob(pattern, name) ||
         MatchesGlob(pattern, std::filesystem::path(name).replace_extension().string());
}

void PhotoNames::RequireMatch(const std::string& pattern,
                              const Place& place,
                              const std::string& path,
                              std::vector<Problem>& problems) const {
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (Matches(pattern, i)) return;
  }
  problems.push_back(
      {place, path, "no photo or sensor is called '" + pattern + "'" + NameHint(pattern, names_)});
}

}  // namespace pathfit::app
