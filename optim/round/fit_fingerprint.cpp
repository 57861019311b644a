#include "optim/round/fit_fingerprint.h"

#include <sstream>

namespace pathfit::optim {

std::string FitFingerprint(const FitSpec& spec,
                           const ParameterSet& all_unknowns,
                           const ObservationSet& observations) {
  std::ostringstream text;
  text << "seed " << spec.seed << "; views " << observations.views.size() << " (held out:";
  for (std::size_t i = 0; i < observations.views.size(); ++i) {
    if (observations.views[i].validation) {
      text << ' ' << i;
    }
  }
  text << "); stages";
  for (const StageSpec& stage : spec.stages) {
    text << " '" << stage.name << "' at " << stage.image_scale << " free";
    for (const int index : stage.free) {
      text << ' ' << index;
    }
    text << ',';
  }
  text << " unknowns";
  for (const renderer::ParameterGroup& group : all_unknowns.layout().groups()) {
    text << ' ' << group.name << '[' << group.num_blocks << ']';
  }
  return text.str();
}

}  // namespace pathfit::optim
