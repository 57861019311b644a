#pragma once

#include <string>
#include <vector>

#include "app/config/config_error.h"
#include "app/config/yaml_node.h"

namespace pathfit::app {

/// The photos of an experiment, or its sensors, as a configuration names them.
class PhotoNames {
 public:
  explicit PhotoNames(std::vector<std::string> names) : names_(std::move(names)) {}

  /// Whether a name or glob, of which the extension may be left out, stands for photo `index`.
  [[nodiscard]] bool Matches(const std::string& pattern, std::size_t index) const;
  /// Reports a pattern that stands for none, with the nearest name.
  void RequireMatch(const std::string& pattern,
                    const Place& place,
                    const std::string& path,
                    std::vector<Problem>& problems) const;
  [[nodiscard]] std::size_t size() const { return names_.size(); }

 private:
  std::vector<std::string> names_;
};

}  // namespace pathfit::app
