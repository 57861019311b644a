#include "optim/round/fit.h"

#include <utility>

#include "optim/round/fit_driver.h"

namespace pathfit::optim {

FitResult RunFit(renderer::Scene start,
                 const ObservationSet& observations,
                 const FitSpec& spec,
                 FitObserver& observer,
                 const FitControls& controls) {
  FitDriver driver(std::move(start), observations, spec, observer, controls);
  return driver.Run();
}

}  // namespace pathfit::optim
