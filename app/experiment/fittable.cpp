#include "app/experiment/fittable.h"

#include <vector>

namespace pathfit::app {

void RequireFittable(const ExperimentConfig& config, const std::string& stop_after) {
  const ConfigSource source{config.path.string(), {}, {}};
  std::vector<Problem> problems;
  if (!config.input) {
    problems.push_back({{}, "input", "a fit needs photos: give input.images and input.cameras"});
  }
  if (config.fit.unknowns.empty()) {
    problems.push_back(
        {{}, "unknowns", "a fit needs at least one unknown, for example axe.vertices: {}"});
  }
  if (config.fit.stages.empty()) {
    problems.push_back({{}, "stages", "a fit needs at least one stage"});
  }
  bool found = stop_after.empty();
  for (const optim::StageSpec& stage : config.fit.stages) found = found || stage.name == stop_after;
  if (!found) {
    problems.push_back({{}, "stages", "--stop-after: no stage is called '" + stop_after + "'"});
  }
  if (!problems.empty()) throw ConfigError(source, problems);
}

}  // namespace pathfit::app
