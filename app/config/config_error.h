#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "app/config/yaml_node.h"

namespace pathfit::app {

/// One `--set key.path=VALUE`, or a dedicated flag that stands for it.
struct ConfigOverride {
  std::string label;       ///< what messages call it: "--set #2", "--seed"
  std::string assignment;  ///< "stages.light.spp=16"
  bool varies = false;     ///< refused beside another that varies the same value
};

/// What the values of a configuration were read from; kept for messages.
struct ConfigSource {
  std::string file;  ///< as the user wrote it
  std::vector<std::string> lines;
  std::vector<ConfigOverride> overrides;
};

struct Problem {
  Place place;
  std::string path;  ///< "stages[1].free"; empty when there is no key to name
  std::string text;
};

/// "axe.yaml:12:5", "--set #2", or the file alone for defaults.
std::string FormatPlace(const ConfigSource& source, const Place& place);

/// All problems sorted by place as `place: error: path: text` with the source line and a caret
/// below; after 20 of them "... and N more".
std::string FormatProblems(const ConfigSource& source, std::vector<Problem> problems);

/// The configuration is wrong. what() is the complete message for the user: every problem and a
/// closing line.
class ConfigError : public std::runtime_error {
 public:
  ConfigError(const ConfigSource& source, const std::vector<Problem>& problems);
};

}  // namespace pathfit::app
